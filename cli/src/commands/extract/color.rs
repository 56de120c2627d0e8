//! Colours of vertices: by values, or by a pattern.

use super::attribute::{Attribute, colors, values};
use crate::{
    Session,
    commands::NEUTRAL,
    plan::ColorPlan,
    report::{ColorMapReport, ColorReport, TextureReport},
};
use anyhow::Result;
use isokit::{
    geom::Aabb,
    mesh::{Rgba, Surface},
    pipeline::Scan,
    render::{ColorMap, Pattern, SolidTexture},
};

/// How much of its light the darker colour of a pattern keeps.
const DARK: f32 = 0.25;

/// Gives vertices what is planned; none if that is nothing.
pub(super) fn color(
    (plan, attribute): (&ColorPlan, Option<Attribute<'_>>),
    scan: &Scan,
    surfaces: &mut [Surface],
    session: &Session<'_, '_>,
) -> Result<Option<ColorReport>> {
    if plan.is_empty() {
        return Ok(None);
    }
    let mut report = pattern(plan, surfaces);
    report.attribute = match attribute {
        Some(Attribute::Colors(file, other)) => {
            Some(colors((*file, other), scan, surfaces, session)?)
        }
        Some(Attribute::Values(other)) => {
            let found = values(other, scan, surfaces, session)?;
            if let Some((map, ends)) = plan.map {
                let range = ends.or(found.range).unwrap_or([0.0, 1.0]);
                surfaces.iter_mut().for_each(|surface| by_map(surface, map, range));
                report.colormap = Some(ColorMapReport { name: map.name(), range });
            }
            Some(found)
        }
        None => None,
    };
    Ok(Some(report))
}

/// Gives vertices the colours that are planned without a volume.
pub(super) fn pattern(plan: &ColorPlan, surfaces: &mut [Surface]) -> ColorReport {
    let texture = plan.texture.and_then(|(pattern, size)| by_pattern(surfaces, pattern, size));
    ColorReport { texture, ..ColorReport::default() }
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
