//! `info`: what a file holds.

use crate::{
    Exit, Session,
    args::InfoArgs,
    report::{
        ColorVolumeReport, MeshReport, SurfaceBrief, VolumeFacts, VolumeReport, around, to_json,
    },
    text::{chart, counted, grouped, listed},
};
use anyhow::Result;
use isokit::{
    io::{ColorFile, MeshInput, VolumeFile, detect, open_colors, open_volume, read_mesh},
    pipeline::{Region, Scan, TargetSpace},
    volume::{Channels, Grid, Histogram},
};
use std::path::Path;

pub(crate) fn run(args: &InfoArgs, session: &mut Session<'_, '_>) -> Result<Exit> {
    // Options that describe a volume say that it is one, of values.
    if args.volume.is_empty() {
        if !detect(&args.file)?.is_volume() {
            let input = session.watching(|session| read_mesh(&args.file, &session.job))?;
            return of_mesh(args, &input, session);
        }
        if let Some(file) = open_colors(&args.file, &session.job)? {
            return of_colors(args, &file, session);
        }
    }
    of_volume(args, session)
}

fn of_volume(args: &InfoArgs, session: &mut Session<'_, '_>) -> Result<Exit> {
    let options = args.volume.options();
    let path = &args.file;
    let header = open_volume(path, &options, &session.job)?;
    if !args.json {
        session.out.write_all(header_lines(path, &header).as_bytes())?;
        session.out.flush()?;
    }
    let (scan, facts, histogram) = session.watching(|session| -> Result<_> {
        let (space, job) = (TargetSpace::Source, &session.job);
        let scan = Scan::open(path, &options, space, &Region::Whole, job)?;
        let facts = VolumeFacts::of(path, &scan, &scan.statistics(job)?);
        let histogram = scan.histogram(job)?.cloned();
        Ok((scan, facts, histogram))
    })?;
    let suggested_iso = histogram.as_ref().and_then(Histogram::otsu);
    let text = match args.json {
        true => to_json(&VolumeReport {
            schema: "isokit.info/1",
            kind: "volume",
            facts,
            sample_unit: header.sample_unit(),
            suggested_iso,
        })?,
        false => sample_lines(&scan, &facts, histogram.as_ref(), suggested_iso),
    };
    session.out.write_all(text.as_bytes())?;
    Ok(Exit::Done)
}

fn of_colors(args: &InfoArgs, file: &ColorFile, session: &mut Session<'_, '_>) -> Result<Exit> {
    let path = &args.file;
    let text = match args.json {
        true => to_json(&ColorVolumeReport::of(path, file))?,
        false => {
            let of = match file.channels() {
                Channels::Rgb => "colours, 3 bytes each (red, green, blue)",
                Channels::Rgba => "colours, 4 bytes each (red, green, blue, opacity)",
            };
            let mut lines =
                vec![format!("{}: {} volume of colours", path.display(), file.format())];
            lines.extend(grid_lines(file.grid(), of));
            lines.extend(file.notes().iter().map(|note| format!("  note: {note}")));
            let name = path.file_name().unwrap_or_default().display();
            lines.push("\n  for the colours of vertices:".to_owned());
            lines.push(format!(
                "  isokit extract VOLUME --iso VALUE --attribute {name} -o mesh.glb"
            ));
            lines.join("\n") + "\n"
        }
    };
    session.out.write_all(text.as_bytes())?;
    Ok(Exit::Done)
}

/// Sizes and place of a lattice of such samples.
fn grid_lines(grid: &Grid, of: &str) -> Vec<String> {
    let (affine, bounds) = (grid.frame.index_to_world, grid.bounds());
    let [nx, ny, nz] = grid.dims();
    let count = grouped(grid.count());
    let mut lines = vec![
        format!("  samples   {nx} x {ny} x {nz} of {of}, {count} in all"),
        format!("  spacing   {}", listed(affine.spacing())),
        format!("  unit      {}", grid.frame.unit),
        format!("  axes      {}", grid.frame.space),
        format!("  from      {}", listed(bounds.min)),
        format!("  to        {}", listed(bounds.max)),
    ];
    let rows = affine.rows();
    let titles = ["index to  ", "world     ", "          ", "          "];
    lines.extend(titles.iter().zip(rows).map(|(title, row)| format!("  {title}{}", listed(row))));
    lines
}

/// What is known before a sample is read.
fn header_lines(path: &Path, file: &VolumeFile) -> String {
    let scaling = file.scaling();
    let mut lines = vec![format!("{}: {} volume", path.display(), file.format())];
    lines.extend(grid_lines(file.grid(), &file.dtype().to_string()));
    if !scaling.is_identity() {
        let (slope, intercept) = (scaling.slope(), scaling.intercept());
        lines.push(format!("  a sample s means {slope} s + {intercept}"));
    }
    if let Some(unit) = file.sample_unit() {
        lines.push(format!("  values in {unit}, as the file says"));
    }
    lines.extend(file.notes().iter().map(|note| format!("  note: {note}")));
    lines.join("\n") + "\n"
}

/// What the samples say.
fn sample_lines(
    scan: &Scan,
    facts: &VolumeFacts,
    histogram: Option<&Histogram>,
    iso: Option<f64>,
) -> String {
    let mut lines = vec![match facts.range {
        Some([least, greatest]) => format!("  range     {least} to {greatest}"),
        None => "  range     none".to_owned(),
    }];
    lines.push(format!("  NaN       {}", grouped(facts.nan)));
    if facts.infinite > 0 {
        lines.push(format!("  infinite  {}", grouped(facts.infinite)));
    }
    if let Some(histogram) = histogram {
        lines.push("\n  samples from each value on (bars grow with the logarithm)".to_owned());
        lines.extend(chart(histogram).iter().map(|line| format!("  {line}")));
    }
    match iso {
        Some(iso) => {
            let stem = Path::new(&facts.path).file_name().unwrap_or_default().display();
            lines.push(format!("\n  a first isovalue to try (Otsu's): {iso}"));
            lines.push(format!("  isokit extract {stem} --iso {iso} -o mesh.glb"));
        }
        None => lines.push(format!(
            "\n  no isovalue separates the samples of this volume of {}",
            scan.volume().dtype()
        )),
    }
    lines.join("\n") + "\n"
}

fn of_mesh(args: &InfoArgs, input: &MeshInput, session: &mut Session<'_, '_>) -> Result<Exit> {
    let surfaces: Vec<SurfaceBrief> = input.surfaces.iter().map(SurfaceBrief::of).collect();
    let report = MeshReport {
        schema: "isokit.info/1",
        kind: "mesh",
        path: args.file.display().to_string(),
        format: input.format.name(),
        unit: input.unit.to_string(),
        space: input.space.to_string(),
        vertices: surfaces.iter().map(|surface| surface.vertices).sum(),
        triangles: surfaces.iter().map(|surface| surface.triangles).sum(),
        bounds: around(surfaces.iter().filter_map(|surface| surface.bounds)),
        surfaces,
        notes: input.notes.clone(),
    };
    let text = if args.json { to_json(&report)? } else { mesh_lines(&report, input) };
    session.out.write_all(text.as_bytes())?;
    Ok(Exit::Done)
}

fn mesh_lines(report: &MeshReport, input: &MeshInput) -> String {
    let mut lines = vec![
        format!("{}: {} mesh", report.path, input.format),
        format!("  unit      {}", report.unit),
        format!("  axes      {}", report.space),
    ];
    if let Some([min, max]) = report.bounds {
        lines.push(format!("  from      {}", listed(min)));
        lines.push(format!("  to        {}", listed(max)));
    }
    for surface in &report.surfaces {
        let name = if surface.name.is_empty() { "surface" } else { &surface.name };
        let vertices = counted(surface.vertices, "vertex", "vertices");
        let triangles = counted(surface.triangles, "triangle", "triangles");
        let normals = if surface.normals { "with" } else { "without" };
        let color = surface.color.as_ref().map_or(String::new(), |color| format!(", {color}"));
        lines.push(format!("  {name}: {vertices}, {triangles}, {normals} normals{color}"));
    }
    lines.extend(report.notes.iter().map(|note| format!("  note: {note}")));
    lines.join("\n") + "\n"
}
