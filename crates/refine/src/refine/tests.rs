//! What is carried on from round to round is what all of it measured anew is.

use super::{Divided, Refined};
use crate::{
    Isosurface, RefineError, RefineOptions, Subdivision,
    edges::{Edges, NEW},
    ground::Ground,
    kit::{FAR, lost},
    known::Known,
    refine,
    sagitta::Sagitta,
    split::middle,
};
use isokit_field::{Sampled, ScalarField};
use isokit_geom::{
    Affine, Frame,
    vector::{dot, normal, sub},
};
use isokit_job::Job;
use isokit_marching_cubes::{Boundary, ExtractOptions, Gradient, Placement, extract};
use isokit_mesh::{Precision, TriMesh};
use isokit_volume::{Grid, Volume};

/// How far a vertex is off, asked of the field alone.
fn off(mesh: &TriMesh, vertex: usize, ground: &Ground<'_>) -> f64 {
    let spot = ground.spot(mesh.positions.get(vertex));
    if spot.is_beyond {
        return 0.0;
    }
    let slope = ground.field().slope(spot.ijk);
    let ascent = ground.ascent(slope.gradient, spot.held());
    let found = ascent.map(|ascent| (slope.value - ground.iso()).abs() / ascent.steepness);
    found.filter(|found| found.is_finite()).unwrap_or(f64::INFINITY)
}

/// The bend of an edge, asked of the field alone.
fn bend(mesh: &TriMesh, ends: [u32; 2], ground: &Ground<'_>) -> f64 {
    let [a, b] = ends.map(|vertex| mesh.positions.get(vertex as usize));
    let [from, to] = [a, b].map(|place| ground.spot(place));
    if from.is_beyond || to.is_beyond {
        return 0.0;
    }
    let (held, along) = (from.held_with(&to), ground.displacement_ijk(sub(b, a)));
    let (mut greatest, mut steepness) = (0.0_f64, f64::INFINITY);
    for ijk in [from.ijk, to.ijk, ground.spot(middle(mesh, ends)).ijk] {
        let jet = ground.field().jet(ijk);
        let Some(ascent) = ground.ascent(jet.gradient, held) else { return f64::INFINITY };
        steepness = steepness.min(ascent.steepness);
        greatest = greatest.max(jet.bend(along).abs());
        if !jet.bend(along).is_finite() {
            return f64::INFINITY;
        }
    }
    greatest / steepness
}

/// The same as `Refined::bounded`, with everything found and measured anew in every round.
fn bounded_plainly(mesh: &mut TriMesh, ground: &Ground<'_>, error: f64) -> Refined {
    let (mut refined, job) = (Refined::default(), Job::default());
    for round in 0.. {
        let edges = Edges::new(mesh, &job).unwrap();
        let known = Known::default();
        let known = known.carried((mesh, &edges), &vec![NEW; edges.len()], ground, &job).unwrap();
        let offs = (0..mesh.positions.len()).map(|vertex| off(mesh, vertex, ground));
        assert!(offs.eq(known.offs.iter().copied()));
        let bends = edges.ends.iter().map(|&ends| bend(mesh, ends, ground));
        assert!(bends.eq(known.bends.iter().copied()));
        let sagitta = Sagitta::of((mesh, &edges), &known, error, &job).unwrap();
        (refined.bound, refined.unbounded) = (sagitta.bound, sagitta.unbounded);
        let chosen = |edge: usize| sagitta.is_too_long(edge);
        if round == Sagitta::ROUNDS || !(0..edges.len()).any(chosen) {
            break;
        }
        let divided = refined.divide((mesh, &edges), ground, chosen, &job).unwrap();
        let Some(Divided { built, .. }) = divided else { break };
        *mesh = built;
    }
    refined
}

#[track_caller]
fn check(samples: Vec<f32>, dims: [u64; 3], error: f64) {
    let volume = Volume::new(Grid::new(dims, Default::default()).unwrap(), samples).unwrap();
    let (view, job) = (volume.view(), Job::default());
    let field = Sampled::new(view);
    let surface = Isosurface { field: &field as &dyn ScalarField, iso: 0.0 };
    for boundary in [Boundary::Closed, Boundary::Open] {
        let extracting = ExtractOptions::DEFAULT.with_placement(Placement::Cubic);
        let extracting = extracting.with_gradient(Gradient::Matching);
        let whole = extract(&view, 0.0, &extracting.with_boundary(boundary), &job).unwrap();
        let (mut plain, mut carried) = (whole.clone(), whole.clone());
        let ground = Ground::new(surface, whole.positions.precision());
        let expected = bounded_plainly(&mut plain, &ground, error);
        let subdivision = Subdivision::MaxError(error);
        let options = RefineOptions::DEFAULT.with_subdivision(subdivision);
        let found = refine(&mut carried, &surface, &options, &job).unwrap();
        assert!(found.rounds > 1, "{error}: it was divided once only");
        assert_eq!(found, expected, "{error}, {boundary:?}");
        assert!(carried == plain, "{error}, {boundary:?}");
    }
}

/// Samples of a function of the place.
fn sampled(dims: [u64; 3], f: impl Fn([f32; 3]) -> f32) -> Vec<f32> {
    let [nx, ny, nz] = dims;
    let place = |n: u64| [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f32);
    (0..nx * ny * nz).map(|n| f(place(n))).collect()
}

/// Numbers that nobody chose, up to ±`most`.
fn chance(count: u64, most: f32, mut state: u64) -> Vec<f32> {
    let mut next = || {
        state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    (0..count).map(|_| most * (2.0 * next() - 1.0)).collect()
}

#[test]
fn smooth_shapes_are_divided_as_plainly() {
    let dims = [13, 11, 12];
    check(
        sampled(dims, |[x, y, z]| 4.2 - (x - 6.1).hypot(y - 5.2).hypot(0.8 * (z - 5.4))),
        dims,
        1e-2,
    );
    check(
        sampled(dims, |[x, y, z]| (0.5 * x).sin() + (0.6 * y).cos() * (0.4 * z + 0.3).sin()),
        dims,
        3e-2,
    );
}

#[test]
fn chance_is_divided_as_plainly() {
    for seed in 1..4 {
        check(chance(7 * 6 * 5, 1.0, seed), [7, 6, 5], 0.1);
    }
}

#[test]
fn ties_and_holes_are_divided_as_plainly() {
    let dims = [8, 6, 7];
    for seed in 1..4 {
        let ties: Vec<_> = chance(8 * 6 * 7, 2.5, seed).into_iter().map(f32::round).collect();
        check(ties.clone(), dims, 0.1);
        let holes = ties.iter().enumerate().map(|(n, &v)| if n % 41 == 7 { f32::NAN } else { v });
        check(holes.collect(), dims, 0.1);
    }
}

/// Of a triangle with all sides cut come four in its place, and each looks where it did, or they look outward by the field.
#[test]
fn what_comes_of_a_triangle_does_not_turn_over_but_to_look_outward() {
    let (job, mut turned) = (Job::default(), 0);
    for seed in 1..9 {
        let mut samples = chance(9 * 8 * 7, 3.4, seed);
        if seed % 2 == 0 {
            samples.iter_mut().for_each(|sample| *sample = sample.round());
        }
        let volume = Volume::new(Grid::new([9, 8, 7], Default::default()).unwrap(), samples);
        let volume = volume.unwrap();
        let field = Sampled::new(volume.view());
        let surface = Isosurface { field: &field as &dyn ScalarField, iso: 0.0 };
        let before = extract(&volume.view(), 0.0, &ExtractOptions::DEFAULT, &job).unwrap();
        let ground = Ground::new(surface, before.positions.precision());
        let mut after = before.clone();
        let options = RefineOptions::DEFAULT.with_subdivision(Subdivision::Levels(1));
        let found = refine(&mut after, &surface, &options, &job).unwrap();
        assert_eq!((found.undivided, after.triangles.len()), (0, 4 * before.triangles.len()));
        for (old, new) in before.triangles.iter().zip(after.triangles.chunks(4)) {
            let looked = normal(before.corners(*old));
            let ways = new.iter().map(|&triangle| after.corners(triangle));
            let outward = |corners: [[f64; 3]; 3]| {
                corners.into_iter().all(|place| {
                    let gradient = field.slope(ground.spot(place).ijk).gradient;
                    dot(normal(corners), gradient) < 0.0
                })
            };
            if !ways.clone().all(|corners| dot(normal(corners), looked) > 0.0) {
                turned += 1;
                assert!(ways.clone().all(outward), "{old:?}, {seed}");
            }
        }
    }
    assert!(turned > 0, "it shows nothing");
}

#[test]
fn where_a_new_vertex_would_be_across_a_border_it_keeps_its_distance_from_that() {
    // Planes that leave the border z = 0 at an angle whose cosine is `flat`.
    let planes = [0.1_f32, 0.2, 0.3, 0.6, 0.9].map(|flat| {
        let steep = (1.0 - flat * flat).sqrt();
        let samples = sampled([9, 5, 7], |[x, _, z]| flat * (x - 4.0) + steep * z);
        (flat, Volume::new(Grid::new([9, 5, 7], Default::default()).unwrap(), samples).unwrap())
    });
    for (flat, volume) in planes {
        let field = Sampled::new(volume.view());
        let surface = Isosurface { field: &field as &dyn ScalarField, iso: 0.0 };
        let ground = Ground::new(surface, Precision::F64);
        let (free, start) = ([false; 3], [4.2, 2.3, 0.01]);
        assert_eq!(ground.projected(start, free), None, "{flat}");
        let beside = ground.projected_beside_borders(start, free, 1.0);
        if flat < 0.25 {
            assert_eq!(beside, None, "{flat}: it would be far away");
            continue;
        }
        let beside = beside.expect("the surface is near");
        assert!(beside[1] == start[1] && beside[2] == start[2], "{flat}: {beside:?}");
        assert!((field.value(beside)).abs() < 1e-6, "{flat}: {beside:?}");
    }
}

#[test]
fn a_new_vertex_goes_as_far_as_a_cell_and_one_that_a_crease_wants_half_as_far() {
    let samples = sampled([9, 5, 7], |[x, _, z]| 0.6 * (x - 4.0) + 0.8 * z);
    let volume = Volume::new(Grid::new([9, 5, 7], Default::default()).unwrap(), samples).unwrap();
    let field = Sampled::new(volume.view());
    let surface = Isosurface { field: &field as &dyn ScalarField, iso: 0.0 };
    let ground = Ground::new(surface, Precision::F64);
    // So far from the plane, most of it along z.
    for (away, is_near, is_in_reach) in
        [(0.6, true, true), (0.65, false, true), (1.3, false, false)]
    {
        let start = [4.0 + 0.6 * away, 2.3, 0.8 * away];
        let found = [
            ground.projected(start, [false; 3]),
            ground.projected_beside_borders(start, [false; 3], 9.0),
        ];
        assert_eq!(found.map(|end| end.is_some()), [is_near, is_in_reach], "{away}: {found:?}");
        assert_eq!(ground.projected_beside_borders(start, [false; 3], 0.9 * away), None, "{away}");
    }
}

#[test]
fn where_no_triangle_is_known_there_is_no_bound() {
    let mut samples = vec![f32::NAN; 27];
    samples[13] = 1.0;
    let volume = Volume::new(Grid::new([3; 3], Default::default()).unwrap(), samples).unwrap();
    let (view, job) = (volume.view(), Job::default());
    let field = Sampled::new(view);
    let surface = Isosurface { field: &field as &dyn ScalarField, iso: 0.0 };
    let mut mesh = extract(&view, 0.0, &ExtractOptions::DEFAULT, &job).unwrap();
    let options = RefineOptions::DEFAULT.with_subdivision(Subdivision::MaxError(0.1));
    let found = refine(&mut mesh, &surface, &options, &job).unwrap();
    assert!(mesh.triangles.len() == 8 && found.unbounded == 8, "{found:?}");
    assert_eq!(found.bound, None);
}

/// Millimetres as far from the origin as f32 goes: a step is a 64th of the distance of samples.
#[test]
fn in_a_file_of_another_unit_nothing_is_in_one_place_or_flat_that_is_not_here() {
    let affine = Affine::axis_aligned([1.0; 3], FAR).unwrap();
    let grid = Grid::new([7; 3], Frame { index_to_world: affine, ..Frame::default() }).unwrap();
    let levels = |n| RefineOptions::DEFAULT.with_subdivision(Subdivision::Levels(n));
    let ways = [levels(1), levels(2).with_balance(true), RefineOptions::DEFAULT.with_balance(true)];
    let mut unscaled = [0, 0];
    for (seed, scale) in (1..).zip([1e-3, 1e-3, 0.0254, 1e-10, 1e-3, 0.3]) {
        let ties = chance(343, 3.4, seed).into_iter().map(f32::round).collect();
        let volume = Volume::new(grid, ties).unwrap();
        let field = Sampled::new(volume.view());
        let surface = Isosurface { field: &field as &dyn ScalarField, iso: 0.0 };
        let extracting = ExtractOptions::DEFAULT.with_placement(Placement::Cubic);
        let plain = extract(&volume.view(), 0.0, &extracting, &Job::default()).unwrap();
        assert_eq!(lost(&plain, scale), [0, 0], "before anything is done");
        for options in ways {
            let done = |options: &RefineOptions| {
                let mut mesh = plain.clone();
                refine(&mut mesh, &surface, options, &Job::default()).unwrap();
                mesh
            };
            let of_scale = done(&options.with_file_scale(Some(scale)));
            assert_eq!((lost(&of_scale, scale), lost(&of_scale, 1.0)), ([0, 0], [0, 0]), "{seed}");
            let found = lost(&done(&options), scale);
            unscaled = [unscaled[0] + found[0], unscaled[1] + found[1]];
        }
    }
    assert!(unscaled[0] > 0 && unscaled[1] > 0, "{unscaled:?}: it shows nothing");
}

#[test]
fn a_file_that_holds_no_positions_is_an_error() {
    let volume =
        Volume::new(Grid::new([2; 3], Frame::default()).unwrap(), vec![0.0_f32; 8]).unwrap();
    let field = Sampled::new(volume.view());
    let surface = Isosurface { field: &field as &dyn ScalarField, iso: 0.0 };
    let plain = extract(&volume.view(), 0.0, &ExtractOptions::DEFAULT, &Job::default()).unwrap();
    let refined = |scale| {
        let options = RefineOptions::DEFAULT.with_file_scale(Some(scale)).with_balance(true);
        refine(&mut plain.clone(), &surface, &options, &Job::default())
    };
    // Of 1, which is the farthest that samples are, the least and the greatest that f32 holds whole.
    for scale in [0.0, -1e-3, f64::NAN, f64::INFINITY, 1e-38, 4e38] {
        assert!(matches!(refined(scale), Err(RefineError::Options(_))), "{scale}");
    }
    assert!([2e-38, 1e-3, 1e38].into_iter().all(|scale| refined(scale).is_ok()));
    assert!(RefineOptions::DEFAULT.with_file_scale(Some(1e-3)).do_nothing());
}
