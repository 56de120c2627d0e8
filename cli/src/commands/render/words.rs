//! What was computed for pictures, and what not, in words.

use super::Seen;
use crate::{
    Session,
    plan::RenderPlan,
    report::{ReadSamples, RenderSkipped, RenderTimings},
    scene_file::ModeWord,
    text::{counted, grouped},
};
use isokit::render::Channel;

/// Says what was computed, and what not.
pub(super) fn tell(
    (mode, samples): (ModeWord, Option<&ReadSamples>),
    skipped: &RenderSkipped,
    timings: &RenderTimings,
    session: &Session<'_, '_>,
) {
    samples.iter().for_each(|samples| session.console.detail(&read_line(samples)));
    for surface in &skipped.surfaces {
        session.console.detail(&format!("{} not made: {}", surface.name, surface.why));
    }
    skipped_lines(mode, skipped).iter().for_each(|line| session.console.detail(line));
    let RenderTimings { read, extract, render, write, total } = timings;
    session.console.detail(&format!(
        "read {read:.3} s, extract {extract:.3} s, render {render:.3} s, write {write:.3} s, \
         total {total:.3} s"
    ));
}

/// What would be done, for people.
pub(super) fn plan_lines(plan: &RenderPlan, seen: &Seen, skipped: &RenderSkipped) -> String {
    let pictures = counted(plan.viewpoints.len() as u64, "picture", "pictures");
    let [width, height] = [plan.size.width, plan.size.height];
    let mut lines = vec![format!("{pictures} of {width} x {height}, {}", mode_name(plan.mode))];
    lines.extend(seen.samples.iter().map(read_line));
    if seen.file.is_some() && skipped.bricks == 0 {
        lines.push(
            "which bricks hold something is not known before samples are read: an index says it \
             (isokit extract --index)"
                .into(),
        );
    }
    if !plan.mode.shows_values() {
        for (n, look) in seen.scene.surfaces.iter().enumerate() {
            let why = skipped.surfaces.iter().find(|skipped| skipped.number == n);
            let what = match (why, look.iso) {
                (Some(why), _) => format!("not made: {}", why.why),
                (None, Some(iso)) if plan.mode == ModeWord::IsoRaycast => {
                    format!("found by rays at {iso}")
                }
                (None, Some(iso)) => {
                    let has_normals = plan.neediest(&seen.scene).raster.needs_normals();
                    let how = if has_normals { "with" } else { "without" };
                    format!("extracted at {iso}, {how} normals")
                }
                (None, None) => "read".to_owned(),
            };
            lines.push(format!("  {}: {what}", look.name));
        }
    } else if !seen.scene.surfaces.is_empty() {
        lines.push("not computed: surfaces and caps, which pictures of values do not show".into());
    }
    if plan.is_sheet {
        lines.push("each surface alone, side by side".into());
    }
    for (channel, path) in &plan.channels {
        let what = match channel {
            Channel::Depth => "depths",
            _ => "normals",
        };
        lines.push(format!("{what} of surfaces, to {}", path.display()));
    }
    if let Some(path) = &plan.plot {
        lines.push(format!("a chart of what values look like, to {}", path.display()));
    }
    lines.extend(skipped_lines(plan.mode, skipped));
    lines.join("\n") + "\n"
}

/// Which samples are read, and why no others or all.
fn read_line(samples: &ReadSamples) -> String {
    let ReadSamples { all, of_part, read, ranges, why } = samples;
    let part = match all == of_part {
        true => String::new(),
        false => format!(" in the part, of {} in the file", grouped(*all)),
    };
    if read == of_part {
        let why = why.map_or(String::new(), |why| format!(": {why}"));
        return format!("reads all {} samples{part}{why}", grouped(*read));
    }
    let [x, y, z] = ranges.map(|[from, to]| format!("{from}:{to}"));
    format!(
        "reads {} of {} samples{part}, {x},{y},{z}: planes cut the others away, or no picture shows them",
        grouped(*read),
        grouped(*of_part)
    )
}

/// What is not computed, a sentence each.
fn skipped_lines(mode: ModeWord, skipped: &RenderSkipped) -> Vec<String> {
    let of = |part: u64, all: u64, what: &str| {
        (all > 0).then(|| format!("skipped {} of {} {what}", grouped(part), grouped(all)))
    };
    let triangles = skipped.triangles + skipped.triangles_skipped;
    let of_samples = match mode {
        ModeWord::Splat => Some("samples, which give nothing to what can be seen"),
        _ => Some("samples, which planes cut away or no picture shows"),
    };
    let every = skipped.halvings.map(|halvings| 1_u64 << halvings.min(63));
    let steps = skipped.steps + skipped.steps_leapt + skipped.steps_hidden;
    [
        (skipped.bricks > 0).then(|| {
            let what = match mode {
                mode if mode.shows_values() => "nothing that can be seen",
                _ => "no surface that can be seen",
            };
            let [part, all] = [skipped.bricks_skipped, skipped.bricks].map(grouped);
            format!("{part} of {all} bricks hold {what}")
        }),
        (every != [1; 3]).then(|| {
            let [x, y, z] = every;
            format!("looked at one sample of {x} x {y} x {z}, which are nearer to each other than pixels")
        }),
        of_samples.and_then(|what| of(skipped.samples_skipped, skipped.samples, what)),
        of(skipped.triangles_skipped, triangles, "triangles, which are not in the picture"),
        (skipped.triangles_hidden > 0).then(|| {
            let triangles = grouped(skipped.triangles_hidden);
            format!("passed {triangles} times a triangle behind all that is opaque in a part of a picture")
        }),
        of(skipped.steps_leapt, steps, "steps of rays, where nothing can be seen"),
        of(skipped.steps_hidden, steps, "steps of rays, behind what is opaque"),
        (skipped.bricks_passed > 0).then(|| {
            let bricks = grouped(skipped.bricks_passed);
            format!("rays passed {bricks} times a brick without a surface")
        }),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub(super) fn mode_name(mode: ModeWord) -> &'static str {
    match mode {
        ModeWord::Surfaces => "surfaces",
        ModeWord::IsoRaycast => "iso-raycast",
        ModeWord::Raycast => "raycast",
        ModeWord::Splat => "splat",
    }
}
