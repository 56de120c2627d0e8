//! Prints how far the triangles of a ball and a ring are from their surfaces, as they are extracted, divided and
//! balanced, in units of the distance of samples.
//!
//! usage: cargo run --release -p isokit-tests --example surface_error [SAMPLES_PER_AXIS]

#![expect(clippy::print_stdout, reason = "it is a program")]

use isokit::{
    job::Job,
    marching_cubes::{ExtractOptions, Placement},
    mesh::measure,
    pipeline::{Scan, SurfaceOptions},
    refine::{RefineOptions, Subdivision},
    volume::Volume,
};
use isokit_tests::{
    deviation::{best_by_offsets, deviation},
    fields::{self, Field, gradient},
    volumes,
};
use std::{f64::consts::PI, time::Instant};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let points = std::env::args().nth(1).map_or(Ok(64), |word| word.parse())?;
    let balanced = RefineOptions::default().with_balance(true);
    let levels = |n| RefineOptions::default().with_subdivision(Subdivision::Levels(n));
    let error = |e| RefineOptions::default().with_subdivision(Subdivision::MaxError(e));
    let step = 2.0 / (points - 1) as f64;
    let ball = 4.0 / 3.0 * PI * 0.8_f64.powi(3);
    let ring = 2.0 * PI * PI * 0.6 * 0.25 * 0.25;
    let shapes = [("ball", fields::sphere(0.8), ball), ("ring", fields::torus(0.6, 0.25), ring)];
    let extract = ExtractOptions::DEFAULT.with_placement(Placement::Cubic);
    let surface = SurfaceOptions::default().with_extract(extract);
    let mut all = vec![];
    for (name, field, volume) in shapes {
        let samples = volumes::cube(&field, points);
        let (grid, values) = (*samples.grid(), samples.samples().iter().map(|&v| v as f32));
        let scan = Scan::new(Volume::new(grid, values.collect::<Vec<f32>>())?);
        let whole = scan.mesh(0.0, &surface.before(&balanced), &Job::default())?;
        all.push((name, field, volume, scan, whole));
    }
    for (what, options) in [
        ("extracted", RefineOptions::default()),
        ("balanced", balanced),
        ("refined 1", levels(1)),
        ("refined 1, balanced", levels(1).with_balance(true)),
        ("refined 2", levels(2)),
        ("error 1/1000", error(1e-3 * step)),
    ] {
        for (name, field, volume, scan, whole) in &all {
            let (mut mesh, start) = (whole.clone(), Instant::now());
            let found = scan.refine(0.0, &mut mesh, (&options, &surface), &Job::default())?;
            let seconds = start.elapsed().as_secs_f64();
            let off = deviation(&mesh, field);
            let enclosed = measure(&mesh, &Job::default())?.volume;
            println!(
                "{name}, {what}: {} triangles, rms {:.3e}, greatest {:.3e}, volume {:.2e}, {seconds:.3} s, \
                 {} unprojected, {} undivided, {} unbounded, {} unbalanced",
                mesh.triangles.len(),
                off.rms / step,
                off.greatest / step,
                enclosed / volume - 1.0,
                found.unprojected,
                found.undivided,
                found.unbounded,
                found.unbalanced,
            );
        }
    }
    for (name, field, _, _, whole) in all.iter().filter(|_| points <= 128) {
        let best = best_by_offsets(whole, field, &|place| outward(field, place));
        println!("{name}, best by offsets: rms {:.3e}", deviation(&best, field).rms / step);
    }
    Ok(())
}

fn outward(field: &Field, place: [f64; 3]) -> [f64; 3] {
    let steep = gradient(field, place);
    let length = steep.iter().map(|c| c * c).sum::<f64>().sqrt();
    steep.map(|c| -c / length)
}
