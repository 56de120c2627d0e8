//! Values of another volume at the vertices, and colours.

use crate::{
    Session,
    plan::ColorPlan,
    report::{AttributeReport, ColorMapReport, ColorReport, TextureReport},
    text::{counted, grouped},
};
use anyhow::Result;
use isokit::{
    field::Between,
    geom::Aabb,
    io::VolumeOptions,
    mesh::{Rgba, Surface},
    pipeline::{Region, Scan, TargetSpace},
    render::{ColorMap, Pattern, SolidTexture},
};
use std::path::Path;

/// What a surface without colour looks like, as in files that want one.
const NEUTRAL: Rgba = Rgba([204, 204, 204, 255]);
/// How much of its light the darker colour of a pattern keeps.
const DARK: f32 = 0.25;

/// Gives vertices what is planned; none if that is nothing.
pub(super) fn color(
    plan: &ColorPlan,
    scan: &Scan,
    surfaces: &mut [Surface],
    session: &Session<'_, '_>,
) -> Result<Option<ColorReport>> {
    if plan.is_empty() {
        return Ok(None);
    }
    let mut report = pattern(plan, surfaces);
    if let Some((path, between)) = &plan.attribute {
        let attribute = values((path, *between), scan, surfaces, session)?;
        if let Some((map, ends)) = plan.map {
            let range = ends.or(attribute.range).unwrap_or([0.0, 1.0]);
            surfaces.iter_mut().for_each(|surface| by_map(surface, map, range));
            report.colormap = Some(ColorMapReport { name: map.name(), range });
        }
        report.attribute = Some(attribute);
    }
    Ok(Some(report))
}

/// Gives vertices the colours that are planned without a volume.
pub(super) fn pattern(plan: &ColorPlan, surfaces: &mut [Surface]) -> ColorReport {
    let texture = plan.texture.and_then(|(pattern, size)| by_pattern(surfaces, pattern, size));
    ColorReport { texture, ..ColorReport::default() }
}

/// The values of the volume at all vertices.
fn values(
    (path, between): (&Path, Between),
    scan: &Scan,
    surfaces: &mut [Surface],
    session: &Session<'_, '_>,
) -> Result<AttributeReport> {
    let (options, space) = (VolumeOptions::default(), TargetSpace::Source);
    let other = Scan::open(path, &options, space, &Region::Whole, &session.job)?;
    let name = path.display();
    let notes = other.notes().iter().cloned().chain(scan.differences(&other));
    notes.for_each(|note| session.console.note(&format!("{name}: {note}")));
    let (mut range, mut vertices, mut without): (Option<[f64; 2]>, _, _) = (None, 0, 0);
    for surface in surfaces {
        let values = scan.attribute(&surface.mesh, &other, between, &session.job)?;
        for value in values.iter().map(|&value| f64::from(value)) {
            if value.is_nan() {
                without += 1;
                continue;
            }
            let [low, high] = range.unwrap_or([value; 2]);
            range = Some([low.min(value), high.max(value)]);
        }
        vertices += values.len() as u64;
        surface.mesh.attributes.values = Some(values);
    }
    if without > 0 {
        let (of, all) = (grouped(without), counted(vertices, "vertex", "vertices"));
        let says = "are outside of it, or where it has no value, and have none";
        session.console.note(&format!("{name}: {of} of {all} {says}"));
    }
    if let Some([low, high]) = range {
        session.console.detail(&format!("{name}: {low} to {high} at vertices"));
    }
    let kernel = match between {
        Between::Linear => "linear",
        Between::Nearest => "nearest",
    };
    Ok(AttributeReport { path: name.to_string(), kernel, range, without_value: without })
}

/// Colours by values. Opacity is the surface's.
fn by_map(surface: &mut Surface, map: ColorMap, range: [f64; 2]) {
    let own = surface.color.unwrap_or(NEUTRAL);
    let color = |&value: &f32| {
        let found = map.color(value.into(), range);
        found.map_or(own, |Rgba([r, g, b, _])| Rgba([r, g, b, own.0[3]]))
    };
    let attributes = &mut surface.mesh.attributes;
    let values = attributes.values.iter().flatten();
    attributes.colors = Some(values.map(color).collect());
}

/// Colours by a pattern. None if there are no vertices.
fn by_pattern(
    surfaces: &mut [Surface],
    pattern: Pattern,
    size: Option<f64>,
) -> Option<TextureReport> {
    let corners = surfaces.iter().filter_map(|surface| surface.mesh.bounds());
    let bounds = Aabb::around(corners.flat_map(|bounds| [bounds.min, bounds.max]))?;
    let longest = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max);
    let size = size.unwrap_or(longest / 8.0);
    for surface in surfaces {
        let own = surface.color.unwrap_or(NEUTRAL);
        let [r, g, b, alpha] = own.to_linear();
        let colors = [[r, g, b], [r, g, b].map(|part| part * DARK)];
        // A mesh that is a point has no longest side.
        let texture = SolidTexture::new(pattern, colors, size).ok()?;
        let color = |place| {
            let [r, g, b] = texture.at(place);
            Rgba::from_linear([r, g, b, alpha])
        };
        surface.mesh.attributes.colors = Some(surface.mesh.positions.iter().map(color).collect());
    }
    Some(TextureReport { pattern: format!("{pattern:?}").to_lowercase(), size })
}
