//! The pictures themselves, and the files that they become.

use super::{Seen, read::model};
use crate::{
    Session,
    chart::{self, Canvas},
    commands::to_file,
    fault::UsageError,
    plan::{RenderPlan, Stream, is_png},
    report::{RenderSkipped, RenderTimings, timed},
    scene_file::ModeWord,
};
use anyhow::Result;
use embedded_graphics::{pixelcolor::Rgb888, prelude::RgbColor, text::Alignment};
use isokit::{
    geom::Frame,
    io::write_volume,
    job::Job,
    render::{Background, Channel, Depth, Gathered, Image, Size, write_channel_png, write_png},
    scene::{Scene, Viewpoint},
    volume::{Grid, Volume},
};
use std::{num::NonZeroU32, path::Path, time::Instant};

/// Makes and writes one picture after the other.
pub(super) fn pictures(
    plan: &RenderPlan,
    seen: &mut Seen,
    (skipped, timings): (&mut RenderSkipped, &mut RenderTimings),
    session: &mut Session<'_, '_>,
) -> Result<()> {
    let (size, job, start) = (plan.size, session.job.clone(), Instant::now());
    if let (ModeWord::Raycast, Some(scan)) = (plan.mode, &seen.scan) {
        let mut targets = plan.targets.iter();
        let of = (&plan.viewpoints[..], size);
        seen.scene.cast_each(scan, of, &job, |image, cast| -> Result<()> {
            skipped.add_cast(&cast);
            let mut write = |target| write(plan, &image, target, session);
            timed(&mut timings.write, || targets.next().map_or(Ok(()), &mut write))
        })?;
        timings.render = start.elapsed().as_secs_f64() - timings.write;
        return Ok(());
    }
    for (viewpoint, target) in plan.viewpoints.iter().zip(&plan.targets) {
        seen.scene.viewpoint = *viewpoint;
        let image = timed(&mut timings.render, || match (plan.mode, &seen.scan) {
            _ if plan.is_sheet => sheet(plan, seen, skipped, &job),
            (ModeWord::Splat, Some(scan)) => {
                let (image, splatted) = seen.scene.splat(scan, size, &job)?;
                skipped.add_splatted(&splatted);
                Ok(image)
            }
            _ => surfaces(plan, seen, &seen.scene, size, skipped, &job),
        })?;
        timed(&mut timings.write, || write(plan, &image, target, session))?;
    }
    Ok(())
}

/// The picture of the surfaces of a scene.
fn surfaces(
    plan: &RenderPlan,
    seen: &Seen,
    scene: &Scene,
    size: Size,
    skipped: &mut RenderSkipped,
    job: &Job,
) -> Result<Image> {
    match (plan.mode, &seen.scan) {
        (ModeWord::IsoRaycast, Some(scan)) => {
            let (image, traced) = scene.trace(scan, size, job)?;
            skipped.add_traced(&traced);
            Ok(image)
        }
        (_, scan) => {
            let subject = (scan.as_ref(), seen.around);
            let (image, drawn) = scene.draw(&seen.meshes, subject, size, job)?;
            skipped.add_drawn(&drawn);
            Ok(image)
        }
    }
}

/// How many surfaces stand side by side in a sheet, and the size of the picture of each: as many as make it about square.
fn cells(plan: &RenderPlan, surfaces: usize) -> Result<(u32, Size), UsageError> {
    let count = surfaces.max(1) as u32;
    let [width, height] = [plan.size.width, plan.size.height].map(|n| n.get());
    let square = f64::from(count) * f64::from(width) / f64::from(height);
    let columns = (square.sqrt().round() as u32).clamp(1, count);
    let rows = count.div_ceil(columns);
    match NonZeroU32::new(width / columns).zip(NonZeroU32::new(height / rows)) {
        Some((width, height)) => Ok((columns, Size { width, height })),
        None => Err(UsageError(format!("{count} pictures do not fit into {width} x {height}"))),
    }
}

/// The size of a picture of surfaces.
pub(super) fn size(plan: &RenderPlan, surfaces: usize) -> Result<Size, UsageError> {
    match plan.is_sheet {
        true => Ok(cells(plan, surfaces)?.1),
        false => Ok(plan.size),
    }
}

/// Each surface alone, side by side, all from the same place, with their names.
fn sheet(plan: &RenderPlan, seen: &Seen, skipped: &mut RenderSkipped, job: &Job) -> Result<Image> {
    let scene = &seen.scene;
    let (columns, cell) = cells(plan, scene.surfaces.len())?;
    let (around, space) = seen.around;
    let bounds = scene.extent(&seen.meshes).unwrap_or(around);
    let camera = scene.viewpoint.camera((bounds, space), cell)?;
    let mut image = Image::new(plan.size, &job.limits)?;
    for (n, look) in (0..).zip(&scene.surfaces) {
        let mut only = scene.with_only(n as usize);
        only.viewpoint = Viewpoint::of(&camera);
        let one = surfaces(plan, seen, &only, cell, skipped, job)?;
        let [left, top] = [n % columns * cell.width.get(), n / columns * cell.height.get()];
        for (row, pixels) in (0..).zip(one.pixels().chunks(cell.width.get() as usize)) {
            let first = (top + row) as usize * plan.size.width.get() as usize + left as usize;
            image.pixels_mut()[first..first + pixels.len()].copy_from_slice(pixels);
        }
        let name = match look.iso {
            Some(iso) if !look.name.starts_with("iso_") => format!("{} ({iso})", look.name),
            _ => look.name.clone(),
        };
        let is_light = match plan.background {
            Background::Color(color) => color.iter().sum::<f32>() > 0.6,
            Background::Transparent => true,
        };
        let ink = if is_light { Rgb888::BLACK } else { Rgb888::WHITE };
        let place = [left + 8, top + cell.height.get().saturating_sub(8)];
        let place = place.map(|c| i32::try_from(c).unwrap_or(i32::MAX));
        Canvas(&mut image).words(&name, place, ink, Alignment::Left);
    }
    Ok(image)
}

/// Writes what else surfaces have.
pub(super) fn channels(plan: &RenderPlan, seen: &Seen, session: &Session<'_, '_>) -> Result<()> {
    for (channel, path) in &plan.channels {
        let mut scene = seen.scene.clone();
        scene.raster = scene.raster.with_channel(*channel);
        let mut skipped = RenderSkipped::default();
        let image = surfaces(plan, seen, &scene, plan.size, &mut skipped, &session.job)?;
        if !is_png(path) {
            let depth = |pixel: &Gathered| {
                if pixel.opacity > 0.0 { pixel.color[0] } else { f32::NAN }
            };
            let [width, height] = [plan.size.width, plan.size.height].map(|n| n.get().into());
            let grid = Grid::new([width, height, 1], Frame::default())?;
            let mut depths = session.job.limits.vec("depths", Some(plan.size.pixels()))?;
            depths.extend(image.pixels().iter().map(depth));
            write_volume(path, &Volume::new(grid, depths)?.into(), &session.job)?;
        } else {
            let range =
                to_file(path, session, |out| Ok(write_channel_png(&image, *channel, out)?))?;
            if let (Channel::Depth, Some([near, far])) = (channel, range) {
                session.console.note(&format!("depths are from {near} to {far} world units"));
            }
            continue;
        }
        session.console.info(&format!("wrote {}", path.display()));
    }
    Ok(())
}

/// Writes the chart of what values look like.
pub(super) fn plot(
    path: &Path,
    plan: &RenderPlan,
    seen: &Seen,
    session: &Session<'_, '_>,
) -> Result<()> {
    let Some(scan) = &seen.scan else { return Ok(()) };
    let made;
    let shown = match &seen.scene.model {
        Some(shown) => shown,
        None => {
            made = model(&plan.model, Some(scan), session)?;
            &made
        }
    };
    let Some(histogram) = scan.histogram(&session.job)? else {
        let says = "no value is finite: there is nothing to plot";
        return Err(UsageError(says.into()).into());
    };
    let isos = seen.scene.surfaces.iter();
    let isos = isos.filter_map(|look| Some((look.name.clone(), look.iso?, look.color)));
    let image = chart::plot(histogram, shown, &isos.collect::<Vec<_>>(), &session.job)?;
    let ground = Background::Color([1.0; 3]);
    to_file(path, session, |out| Ok(write_png(&image, ground, Depth::Eight, out)?))
}

fn write(
    plan: &RenderPlan,
    image: &Image,
    target: &Stream,
    session: &mut Session<'_, '_>,
) -> Result<()> {
    match target {
        Stream::Stdout => write_png(image, plan.background, plan.depth, &mut session.out)?,
        Stream::File(path) => {
            to_file(path, session, |out| Ok(write_png(image, plan.background, plan.depth, out)?))?;
        }
    }
    Ok(())
}
