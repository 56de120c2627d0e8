//! Values or colours of another volume at the vertices.

use super::tell_notes;
use crate::{
    Session,
    commands::NEUTRAL,
    fault::CallerError,
    plan::ColorPlan,
    report::AttributeReport,
    text::{counted, grouped},
};
use anyhow::Result;
use isokit::{
    field::Between,
    io::{ColorFile, Format, VolumeOptions, open_colors},
    mesh::{Rgba, Surface},
    pipeline::{Region, Scan, TargetSpace},
    volume::Channels,
};
use std::path::Path;

/// A volume, and what is between its samples.
pub(super) type Other<'a> = (&'a Path, Between);

/// What another volume is of.
pub(super) enum Attribute<'a> {
    Values(Other<'a>),
    Colors(Box<ColorFile>, Other<'a>),
}

/// What the planned volume is of; none if there is none. Looked for before anything else is read, for not all fits all.
pub(super) fn open<'a>(
    plan: &'a ColorPlan,
    format: Format,
    session: &Session<'_, '_>,
) -> Result<Option<Attribute<'a>>> {
    let Some((path, between)) = &plan.attribute else { return Ok(None) };
    let other = (path.as_path(), *between);
    let refused = |says: &str, advice| {
        let message = format!("{}: {says}", path.display());
        Err(CallerError { message, advice }.into())
    };
    match open_colors(path, &session.job)? {
        Some(_) if plan.map.is_some() => {
            refused("it holds colours already, no values for a --colormap", "leave out --colormap")
        }
        Some(_) if plan.texture.is_some() => {
            refused("it holds colours, and --texture makes others", "leave out either of them")
        }
        Some(file) => Ok(Some(Attribute::Colors(Box::new(file), other))),
        None if format == Format::Obj && plan.map.is_none() && plan.texture.is_none() => refused(
            "OBJ holds colours of vertices, but no values",
            "add --colormap, or write .ply or .glb",
        ),
        None => Ok(Some(Attribute::Values(other))),
    }
}

/// The values of the volume at all vertices.
pub(super) fn values(
    (path, between): Other<'_>,
    scan: &Scan,
    surfaces: &mut [Surface],
    session: &Session<'_, '_>,
) -> Result<AttributeReport> {
    let (options, space) = (VolumeOptions::default(), TargetSpace::Source);
    let other = Scan::open(path, &options, space, &Region::Whole, &session.job)?;
    let name = path.display();
    let notes = other.notes().iter().cloned().chain(scan.differences(&other));
    tell_notes(path, notes, session);
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
    let report = report((path, between), without);
    Ok(AttributeReport { range, ..report })
}

/// The colours of the volume at all vertices. Where it has none they keep the colour of their surface; where it says nothing of
/// opacity, the opacity.
pub(super) fn colors(
    (file, (path, between)): (ColorFile, Other<'_>),
    scan: &Scan,
    surfaces: &mut [Surface],
    session: &Session<'_, '_>,
) -> Result<AttributeReport> {
    let (name, channels) = (path.display(), file.channels());
    let notes = file.notes().iter().cloned().chain(scan.differences_from(&file.grid().frame));
    tell_notes(path, notes, session);
    let volume = file.collect(&session.job)?;
    let (mut vertices, mut without) = (0, 0);
    for surface in surfaces {
        let own = surface.color.unwrap_or(NEUTRAL);
        let found = scan.attribute_colors(&surface.mesh, &volume, between, &session.job)?;
        vertices += found.len() as u64;
        without += found.iter().filter(|color| color.is_none()).count() as u64;
        let color = |found: Option<Rgba>| match (found, channels) {
            (Some(Rgba([r, g, b, _])), Channels::Rgb) => Rgba([r, g, b, own.0[3]]),
            (found, _) => found.unwrap_or(own),
        };
        surface.mesh.attributes.colors = Some(found.into_iter().map(color).collect());
    }
    if without > 0 {
        let (of, all) = (grouped(without), counted(vertices, "vertex", "vertices"));
        let says = "are outside of it, and have the colour of their surface";
        session.console.note(&format!("{name}: {of} of {all} {says}"));
    }
    Ok(AttributeReport { channels: Some(channels.count()), ..report((path, between), without) })
}

fn report((path, between): Other<'_>, without_value: u64) -> AttributeReport {
    let kernel = match between {
        Between::Linear => "linear",
        Between::Nearest => "nearest",
    };
    let path = path.display().to_string();
    AttributeReport { path, kernel, channels: None, range: None, without_value }
}
