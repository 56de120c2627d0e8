//! How far triangles are from a surface that is no ball, beside the bound that is told with a named error: no more are farther
//! than are counted as having none, and these are few.

use isokit::{
    geom::Affine,
    job::Job,
    marching_cubes::{Boundary, ExtractOptions, Placement},
    mesh::TriMesh,
    pipeline::{Scan, SurfaceOptions},
    refine::{RefineOptions, Refined, Subdivision},
};
use isokit_tests::{
    chance::Chance,
    fields::{self, Field, gradient},
    volumes,
};
use std::f64::consts::PI;

/// What is left of the first order, and what the field between samples is off, in samples.
const SLACK: f64 = 0.003;

fn divided(scan: &Scan, iso: f64, error: f64) -> (TriMesh, Refined) {
    let extract = ExtractOptions::DEFAULT.with_placement(Placement::Quintic);
    let surface = SurfaceOptions::default().with_extract(extract.with_boundary(Boundary::Open));
    let options = RefineOptions::DEFAULT.with_subdivision(Subdivision::MaxError(error));
    let job = Job::default();
    let mut mesh = scan.mesh(iso, &surface.before(&options), &job).unwrap();
    let found = scan.refine(iso, &mut mesh, (&options, &surface), &job).unwrap();
    (mesh, found)
}

/// Triangles of which the middle, the middle of a side, or one of some points by chance is not near.
fn far(mesh: &TriMesh, is_near: impl Fn([f64; 3]) -> bool) -> u64 {
    let mut chance = Chance::new(5);
    let mut far = 0;
    for &triangle in &mesh.triangles {
        let corners = mesh.corners(triangle);
        let at = |shares: [f64; 3]| {
            std::array::from_fn(|k| (0..3).map(|n| shares[n] * corners[n][k]).sum::<f64>())
        };
        let (a, b) = (chance.unit(), chance.unit());
        let any = [a.min(b), (a - b).abs(), 1.0 - a.max(b)];
        let all = [[1.0 / 3.0; 3], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], any];
        far += u64::from(!all.into_iter().all(|shares| is_near(at(shares))));
    }
    far
}

#[test]
fn on_smooth_fields_the_bound_holds_of_every_triangle() {
    let shapes: [(&str, Field); 2] = [("gyroid", fields::gyroid(2.0)), ("waves", fields::waves())];
    for (name, field) in shapes {
        let points = 33;
        let step = 2.0 / (points - 1) as f64;
        let scan = Scan::new(volumes::cube(&field, points));
        for error in [0.05, 0.01] {
            let (mesh, found) = divided(&scan, 0.0, error * step);
            // Near a surface its distance is the value over the slope.
            let distance = |place| {
                let steep = gradient(&field, place);
                field(place).abs() / steep.iter().map(|c| c * c).sum::<f64>().sqrt()
            };
            let bound = found.bound.expect("triangles have one");
            assert!(bound <= error * step && found.unbounded == 0, "{name}, {found:?}");
            let limit = 1.02 * bound + SLACK * step;
            assert_eq!(far(&mesh, |place| distance(place) <= limit), 0, "{name}, {error}");
            // Nor is it much too large.
            assert!(far(&mesh, |place| distance(place) <= 0.5 * bound) > 0, "{name}, {error}");
        }
    }
}

/// The height of Marschner and Lobb's surface at a distance from its axis.
fn height(radius: f64) -> f64 {
    let rings = (12.0 * PI * (PI * radius / 2.0).cos()).cos();
    2.0 / PI * (0.25 * rings).asin()
}

/// Divides a window of that surface, `step` from sample to sample, to an error in samples. How many triangles are farther from it
/// than what `limit` makes of the bound, both in samples; what is known of them; and how many there are.
fn crests(step: f64, error: f64, limit: impl Fn(f64) -> f64) -> (u64, Refined, u64) {
    let field = fields::marschner_lobb();
    let affine = Affine::axis_aligned([step; 3], [0.5123, 0.3031, -0.168]).unwrap();
    let dims = [0.25, 0.25, 0.34].map(|extent| (extent / step).ceil() as u64 + 1);
    let scan = Scan::new(volumes::placed(&field, dims, affine));
    let (mesh, found) = divided(&scan, 0.5, error * step);
    let bound = found.bound.expect("triangles have one");
    assert!(bound <= error * step, "{found:?}");
    let limit = limit(bound / step) * step;
    let is_near = |[x, y, z]: [f64; 3]| {
        let radius = x.hypot(y);
        // Straight up, or to a point of the surface around it.
        let to = |aside: f64| aside.hypot(height(radius + aside) - z);
        to(0.0) <= limit || (-100..=100).any(|n| to(f64::from(n) / 100.0 * limit) <= limit)
    };
    (far(&mesh, is_near), found, mesh.triangles.len() as u64)
}

/// Chords across crests leave them by 0.4 of a cell before they are divided, and thin triangles beside them look along the
/// surface.
#[test]
fn crests_as_sharp_as_half_a_cell_are_kept_to_but_for_a_few_triangles_that_are_counted() {
    let (step, error) = (1.0 / 256.0, 0.05);
    // What is there already is within one sample, and some of it not within 0.4.
    let (over, plain, before) = crests(step, 1.0, |_| 0.4);
    assert!(0 < over && over < before / 100 && plain.rounds == 0, "{over} over, {plain:?}");
    let (over, found, count) = crests(step, error, |bound| 1.02 * bound + SLACK);
    assert!(over <= found.unbounded && found.unbounded * 200 < count, "{over} over, {found:?}");
    assert!(count < 2 * before, "{count} of {before}");
}

#[test]
fn where_crests_are_sharper_more_is_over_the_error_and_counted() {
    for step in [1.0 / 128.0, 1.0 / 96.0] {
        let (over, found, count) = crests(step, 0.1, |bound| 1.02 * bound + 0.02);
        assert!(0 < over && over <= found.unbounded, "{over} over, {found:?}");
        assert!(found.unbounded * 15 < count, "{found:?} of {count}");
    }
}
