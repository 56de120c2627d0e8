//! What dividing and balancing triangles does to their error, and what it leaves as it was.
//!
//! With `VOLUMES=10000`, as `scripts/sweep` has it, it is done to so many volumes full of ties.

use isokit::{
    geom::{Affine, Frame},
    job::{Job, Limits, Stopped, Threads},
    marching_cubes::{
        Boundary, Degenerate, Diagonals, ExtractOptions, Gradient, Nan, Placement, Topology,
    },
    mesh::{TriMesh, measure},
    pipeline::{Normals, PipelineError, Scan, SurfaceOptions},
    refine::{RefineError, RefineOptions, Refined, Subdivision},
    volume::{AnyVolume, Grid, Volume},
};
use isokit_tests::{
    chance::{for_each_below, looked_at, many},
    check::{assert_closed, assert_sound},
    deviation::{best_by_offsets, deviation},
    fields::{self, Field, gradient},
    volumes,
};
use std::f64::consts::PI;

const BALANCE: RefineOptions = levels(0).with_balance(true);

const fn levels(n: u32) -> RefineOptions {
    let subdivision = if n == 0 { Subdivision::None } else { Subdivision::Levels(n) };
    RefineOptions::DEFAULT.with_subdivision(subdivision)
}

const fn max_error(error: f64) -> RefineOptions {
    RefineOptions::DEFAULT.with_subdivision(Subdivision::MaxError(error))
}

fn surface() -> SurfaceOptions {
    let extract = ExtractOptions::DEFAULT.with_placement(Placement::Cubic);
    SurfaceOptions::default().with_extract(extract)
}

#[track_caller]
fn refined(
    scan: &Scan,
    (iso, options): (f64, &RefineOptions),
    surface: &SurfaceOptions,
    job: &Job,
) -> (TriMesh, Refined) {
    let mut mesh = scan.mesh(iso, &surface.before(options), job).unwrap();
    let found = scan.refine(iso, &mut mesh, (options, surface), job).unwrap();
    (mesh, found)
}

fn of(scan: &Scan, options: &RefineOptions) -> TriMesh {
    refined(scan, (0.0, options), &surface(), &Job::default()).0
}

/// Root mean square over all triangles, and the error of the volume.
fn errors(mesh: &TriMesh, field: &Field, volume: f64) -> [f64; 2] {
    let enclosed = measure(mesh, &Job::default()).unwrap().volume;
    [deviation(mesh, field).rms, (enclosed / volume - 1.0).abs()]
}

fn outward(field: &Field, place: [f64; 3]) -> [f64; 3] {
    let steep = gradient(field, place);
    let length = steep.iter().map(|c| c * c).sum::<f64>().sqrt();
    steep.map(|c| -c / length)
}

#[test]
fn each_division_leaves_a_quarter_of_the_error() {
    for (name, field, volume) in fields::ball_and_ring() {
        let scan = Scan::new(volumes::cube(&field, 33));
        let all = [0, 1, 2].map(|n| errors(&of(&scan, &levels(n)), &field, volume));
        for pair in all.windows(2) {
            for n in [0, 1] {
                let ratio = pair[0][n] / pair[1][n];
                assert!((3.5..4.6).contains(&ratio), "{name}: {ratio}, {all:?}");
            }
        }
    }
}

#[test]
fn balance_is_nearly_the_best_that_offsets_can_do_and_keeps_the_volume() {
    for (name, field, volume) in fields::ball_and_ring() {
        let scan = Scan::new(volumes::cube(&field, 49));
        let plain = of(&scan, &levels(0));
        let (balanced, found) = refined(&scan, (0.0, &BALANCE), &surface(), &Job::default());
        assert_eq!(balanced.triangles, plain.triangles, "{name}");
        assert_eq!(found.balanced, plain.positions.len() as u64, "{name}");
        assert_closed(&balanced);
        let [before, after] = [&plain, &balanced].map(|mesh| errors(mesh, &field, volume));
        let best = best_by_offsets(&plain, &field, &|place| outward(&field, place));
        let best = deviation(&best, &field).rms;
        assert!(after[0] < 1.04 * best, "{name}: {after:?} and {best:e}, {before:?} before");
        assert!(after[0] < 0.5 * before[0], "{name}: {after:?} of {before:?}");
        assert!(after[1] < before[1] / 20.0, "{name}: {after:?} of {before:?}");
    }
}

#[test]
fn the_volume_of_a_balanced_surface_is_of_an_order_above_three() {
    for (name, field, volume) in fields::ball_and_ring() {
        let error = |points| {
            let scan = Scan::new(volumes::cube(&field, points));
            errors(&of(&scan, &BALANCE), &field, volume)[1]
        };
        // A lattice half as wide, and more, so that chance in where it cuts the surface counts less.
        let order = (error(29) / error(85)).ln() / 3_f64.ln();
        assert!(order > 3.2, "{name}: {order}");
    }
}

#[test]
fn divided_and_balanced_is_better_than_either() {
    for (name, field, volume) in fields::ball_and_ring() {
        let scan = Scan::new(volumes::cube(&field, 33));
        let error = |options| errors(&of(&scan, &options), &field, volume);
        let [divided, both] = [error(levels(1)), error(levels(1).with_balance(true))];
        assert!(both[0] < 0.5 * divided[0] && both[1] < 0.1 * divided[1], "{name}: {both:?}");
        assert!(both[0] < 0.3 * error(BALANCE)[0], "{name}: {both:?}");
    }
}

#[test]
fn an_error_that_is_named_is_kept_with_fewer_triangles_than_everywhere_the_same() {
    for (name, field, _) in fields::ball_and_ring() {
        let scan = Scan::new(volumes::cube(&field, 33));
        let everywhere = of(&scan, &levels(2));
        let error = deviation(&everywhere, &field).greatest;
        let job = Job::default();
        let (mesh, found) = refined(&scan, (0.0, &max_error(error)), &surface(), &job);
        assert_closed(&mesh);
        let reached = deviation(&mesh, &field).greatest;
        assert!(found.bound.is_some_and(|bound| bound <= error), "{name}: {found:?}");
        // The error is that to the field; where the field is, its vertices tell.
        let off = mesh.positions.iter().map(|place| field(place).abs()).fold(0.0, f64::max);
        assert!(off < 0.5 * error, "{name}: {off:e}");
        assert!(reached <= 1.02 * error + off, "{name}: {reached:e}, {error:e}, {off:e}");
        assert_eq!(found.unbounded, 0, "{name}");
        assert!(mesh.triangles.len() < everywhere.triangles.len(), "{name}");
        // One that holds already changes nothing.
        let (same, found) = refined(&scan, (0.0, &max_error(1.0)), &surface(), &job);
        let plain = scan.mesh(0.0, &surface().before(&max_error(1.0)), &job).unwrap();
        assert_eq!((found.rounds, same), (0, plain), "{name}");
    }
}

#[test]
fn a_sheared_and_stretched_lattice_is_as_good() {
    let shear = [[0.05, 0.0, 0.0], [0.012, 0.035, 0.0], [0.0, -0.01, 0.08]];
    let affine = Affine::new(shear, [-1.3, -0.7, -1.2]).unwrap();
    let field = fields::sphere(0.5);
    let volume = 4.0 / 3.0 * PI * 0.125;
    let scan = Scan::new(volumes::placed(&field, [53, 41, 31], affine));
    let error = |options: &RefineOptions| {
        let mesh = of(&scan, options);
        assert_closed(&mesh);
        errors(&mesh, &field, volume)
    };
    let [plain, divided, balanced] = [levels(0), levels(1), BALANCE].map(|o| error(&o));
    assert!((3.3..4.8).contains(&(plain[0] / divided[0])), "{plain:?}, {divided:?}");
    assert!(balanced[0] < 0.5 * plain[0] && balanced[1] < 0.05 * plain[1], "{balanced:?}");
}

/// All that may be done, one after another.
fn ways() -> [RefineOptions; 5] {
    let bounded = max_error(0.1);
    [levels(1), BALANCE, levels(2).with_balance(true), bounded, bounded.with_balance(true)]
}

const PLACEMENTS: [Placement; 3] = [Placement::Cubic, Placement::Linear, Placement::Quintic];

fn check_chance(scan: &Scan, boundary: Boundary, placement: Placement) {
    let extract = ExtractOptions::DEFAULT.with_boundary(boundary).with_placement(placement);
    let fitted = extract.clone().with_diagonals(Diagonals::Fitted);
    let of_table = |options: &ExtractOptions| options.clone().with_topology(Topology::Table);
    for extract in [of_table(&extract), of_table(&fitted), extract, fitted] {
        let surface = surface().with_extract(extract);
        let plain = scan.mesh(0.0, &surface, &Job::default()).unwrap();
        let before = assert_sound(&plain);
        for options in ways() {
            let (mesh, found) = refined(scan, (0.0, &options), &surface, &Job::default());
            let after = assert_sound(&mesh);
            assert_eq!(after.boundary_sides == 0, before.boundary_sides == 0, "{options:?}");
            assert_eq!(after.euler, before.euler, "{options:?}");
            assert_eq!(after.components, before.components, "{options:?}");
            assert_eq!(found.new_vertices as usize, mesh.positions.len() - plain.positions.len());
        }
    }
}

#[test]
fn chance_keeps_its_topology_and_no_triangle_is_flat() {
    for (seed, placement) in (0..).zip(PLACEMENTS) {
        check_chance(&Scan::new(volumes::noise([9, 7, 8], seed)), Boundary::Closed, placement);
        check_chance(&Scan::new(volumes::noise([6, 7, 5], seed + 50)), Boundary::Open, placement);
    }
}

#[test]
fn ties_keep_their_topology_and_no_triangle_is_flat() {
    let count = many("VOLUMES", 12);
    for_each_below(count, |n| {
        let (most, boundary) = ([1, 3][n % 2], [Boundary::Closed, Boundary::Open][n / 2 % 2]);
        let scan = Scan::new(volumes::ties([8, 7, 6], most, n as u64));
        check_chance(&scan, boundary, PLACEMENTS[n / 4 % 3]);
    });
    looked_at(count, "volumes full of ties, divided and balanced in every way");
}

/// The field around a sample on the isovalue, all others below it, has no surface but that point: there new vertices met.
#[test]
fn vertices_that_would_meet_stay_apart() {
    let check = |scan| check_chance(&scan, Boundary::Closed, Placement::Cubic);
    check(Scan::new(volumes::ties([8, 7, 6], 1, 326)));
    for dims in [[1, 5, 4], [5, 5, 4], [3, 3, 3]] {
        let grid = Grid::new(dims, Frame::default()).unwrap();
        let mut samples = vec![-1_i8; grid.count() as usize];
        samples[(dims[0] / 2 + dims[0] * (2 + 2 * dims[1])) as usize] = 0;
        check(Scan::new(Volume::new(grid, samples).unwrap()));
    }
}

#[test]
fn next_to_samples_without_a_value_triangles_stay_and_are_counted() {
    let field = fields::sphere(0.6);
    let plain = volumes::cube(&field, 25);
    let mut samples = plain.samples().to_vec();
    (0..samples.len()).step_by(97).for_each(|n| samples[n] = f64::NAN);
    let scan = Scan::new(Volume::new(*plain.grid(), samples).unwrap());
    for nan in [Nan::Outside, Nan::Mask] {
        let extract = surface().extract.with_nan(nan);
        let surface = surface().with_extract(extract);
        for options in ways() {
            let (mesh, found) = refined(&scan, (0.0, &options), &surface, &Job::default());
            assert_sound(&mesh);
            let counted = found.unprojected + found.unbalanced + found.unbounded;
            assert!(counted > 0, "{nan:?}, {options:?}: {found:?}");
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let (waves, noise) = (volumes::cube(&fields::waves(), 29), volumes::noise([9; 3], 3));
    for scan in [Scan::new(waves), Scan::new(noise)] {
        for options in ways() {
            let with = |count: usize| {
                let threads = Threads::new(count.try_into().unwrap()).unwrap();
                let job = Job { threads, ..Job::default() };
                refined(&scan, (0.0, &options), &surface(), &job)
            };
            let one = with(1);
            assert!([2, 3, 7].into_iter().all(|count| with(count) == one), "{options:?}");
        }
    }
}

#[test]
fn a_flat_field_stays_flat() {
    let plane: Field = Box::new(|[x, y, z]| 0.3 * x - 0.5 * y + 0.7 * z + 0.013);
    let scan = Scan::new(volumes::cube(&plane, 12));
    let open = surface().with_extract(surface().extract.with_boundary(Boundary::Open));
    for options in ways() {
        let (mesh, found) = refined(&scan, (0.0, &options), &open, &Job::default());
        assert_sound(&mesh);
        // Positions are f32, here and before.
        assert!(deviation(&mesh, &plane).greatest < 2e-7, "{options:?}");
        assert_eq!(
            (found.unprojected, found.undivided, found.unbalanced),
            (0, 0, 0),
            "{options:?}"
        );
    }
    let (_, found) = refined(&scan, (0.0, &max_error(1e-3)), &open, &Job::default());
    assert_eq!((found.rounds, found.unbounded), (0, 0));
}

#[test]
fn a_rim_stays_in_the_border_and_a_cap_stays_flat() {
    let field = fields::gyroid(1.5);
    let scan = Scan::new(volumes::cube(&field, 25));
    for boundary in [Boundary::Closed, Boundary::Open] {
        let surface = surface().with_extract(surface().extract.with_boundary(boundary));
        let plain = scan.mesh(0.0, &surface, &Job::default()).unwrap();
        for options in ways() {
            let (mesh, _) = refined(&scan, (0.0, &options), &surface, &Job::default());
            let census = assert_sound(&mesh);
            assert_eq!(census.boundary_sides == 0, boundary == Boundary::Closed);
            let [before, after] = [&plain, &mesh].map(|mesh| mesh.bounds().unwrap());
            assert_eq!(after, before, "{options:?}");
            // Vertices on the rim are on the surface too, as near as others: 1 is nowhere near.
            let on_rim =
                |p: &[f64; 3]| p.iter().all(|c| c.abs() <= 1.0) && p.iter().any(|c| c.abs() == 1.0);
            let off = |p: [f64; 3]| field(p).abs() / 4.0;
            let worst = mesh.positions.iter().filter(on_rim).map(off).fold(0.0, f64::max);
            assert!(worst < 0.02, "{boundary:?}, {options:?}: {worst}");
        }
    }
}

#[test]
fn new_normals_are_those_of_the_field() {
    let field = fields::sphere(0.7);
    let scan = Scan::new(volumes::cube(&field, 33));
    let mesh = of(&scan, &levels(2));
    for (place, normal) in mesh.positions.iter().zip(mesh.normals.as_ref().unwrap()) {
        let exact = outward(&field, place);
        let off = (0..3).map(|k| (f64::from(normal[k]) - exact[k]).powi(2)).sum::<f64>().sqrt();
        assert!(off < 2e-3, "{place:?}: {off}");
    }
    for normals in [Normals::Area, Normals::None] {
        let surface = surface().with_normals(normals);
        let mesh = refined(&scan, (0.0, &levels(1)), &surface, &Job::default()).0;
        assert_eq!(mesh.normals.is_some(), normals == Normals::Area);
        assert_closed(&mesh);
    }
}

#[test]
fn positions_do_not_depend_on_the_normals_that_are_wanted() {
    let (ball, noise) = (volumes::cube(&fields::sphere(0.7), 17), volumes::noise([7, 8, 6], 5));
    let ties = AnyVolume::from(volumes::ties([7, 6, 8], 2, 5));
    for scan in [Scan::new(ball), Scan::new(noise), Scan::new(ties)] {
        for options in ways() {
            let with = |normals, gradient| {
                let mut surface = surface().with_normals(normals);
                surface.extract.gradient = gradient;
                let (mesh, found) = refined(&scan, (0.0, &options), &surface, &Job::default());
                assert_eq!(mesh.normals.is_some(), normals != Normals::None);
                (mesh.positions, mesh.triangles, found)
            };
            let plain = with(Normals::Gradient, Gradient::Central);
            assert!(with(Normals::Gradient, Gradient::Matching) == plain, "{options:?}");
            for normals in [Normals::None, Normals::Area] {
                assert!(with(normals, Gradient::Central) == plain, "{normals:?}, {options:?}");
            }
        }
    }
}

#[test]
fn a_mesh_without_normals_is_balanced_along_those_of_the_field() {
    for (name, field, volume) in fields::ball_and_ring() {
        let scan = Scan::new(volumes::cube(&field, 33));
        let bare = surface().with_normals(Normals::None);
        let mut mesh = scan.mesh(0.0, &bare, &Job::default()).unwrap();
        let found = scan.refine(0.0, &mut mesh, (&BALANCE, &bare), &Job::default()).unwrap();
        assert_eq!(found.unbalanced, 0, "{name}");
        let with = errors(&of(&scan, &BALANCE), &field, volume);
        let without = errors(&mesh, &field, volume);
        assert!((without[0] / with[0] - 1.0).abs() < 0.01, "{name}: {without:?}, {with:?}");
    }
}

#[test]
fn what_means_nothing_is_refused() {
    let scan = Scan::new(AnyVolume::from(volumes::noise([5; 3], 1)));
    let mesh = scan.mesh(0.0, &surface(), &Job::default()).unwrap();
    let refusal = |options: RefineOptions, surface: &SurfaceOptions| {
        let mut same = mesh.clone();
        let error = scan.refine(0.0, &mut same, (&options, surface), &Job::default()).unwrap_err();
        assert_eq!(same, mesh);
        matches!(error, PipelineError::Refine(RefineError::Options(_)))
    };
    for n in [7, 99] {
        assert!(refusal(levels(n), &surface()));
    }
    for error in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refusal(max_error(error), &surface()), "{error}");
    }
    let extract = surface().extract.with_degenerate(Degenerate::Exact);
    assert!(refusal(BALANCE, &surface().with_extract(extract)));
}

#[test]
fn memory_that_is_not_allowed_is_not_taken_and_the_mesh_stays() {
    let scan = Scan::new(volumes::cube(&fields::sphere(0.7), 25));
    let whole = of(&scan, &levels(0));
    let bytes = (whole.triangles.len() * 12) as u64;
    for options in [levels(1), BALANCE, max_error(1e-4)] {
        let (mut mesh, limits) = (whole.clone(), Limits { bytes });
        let job = Job { limits, ..Job::default() };
        let error = scan.refine(0.0, &mut mesh, (&options, &surface()), &job).unwrap_err();
        let PipelineError::Refine(RefineError::Stopped(Stopped::OverLimit(over))) = error else {
            panic!("{error}");
        };
        assert!(over.needed > bytes && mesh == whole, "{over}");
    }
    let job = Job::default();
    job.cancel.cancel();
    let mut mesh = whole.clone();
    assert!(scan.refine(0.0, &mut mesh, (&levels(1), &surface()), &job).is_err());
    assert_eq!(mesh, whole);
}
