//! Small whole numbers put samples exactly on the isovalue all the time.
//!
//! With `VOLUMES=10000`, as `scripts/sweep` has it, so many of them are looked at in every mode. Divided and balanced surfaces
//! of such volumes are looked at in `refine.rs`.

use isokit::{
    geom::Frame,
    job::Job,
    marching_cubes::{
        Boundary, Degenerate, Diagonals, ExtractOptions, Gradient, Placement, Topology, extract,
    },
    mesh::Positions,
    volume::{Grid, Volume},
};
use isokit_tests::{
    chance::{looked_at, many},
    check::{Census, assert_closed, assert_sound},
    fields, volumes,
};

const SIDE: u64 = 7;

/// Whole numbers from −1 to 1, −2 to 2 or −3 to 3.
fn volume(seed: u64) -> Volume<i8> {
    volumes::ties([SIDE; 3], 1 + seed % 3, seed)
}

const PLACEMENTS: [Placement; 3] = [Placement::Linear, Placement::Cubic, Placement::Quintic];

/// Everything that may be chosen and promises no flat triangle.
fn modes() -> Vec<ExtractOptions> {
    let mut modes = vec![ExtractOptions::DEFAULT];
    let mut each = |with: &dyn Fn(ExtractOptions) -> Vec<ExtractOptions>| {
        modes = modes.drain(..).flat_map(with).collect();
    };
    each(&|o| [Topology::Table, Topology::Trilinear].map(|t| o.clone().with_topology(t)).into());
    each(&|o| [Boundary::Closed, Boundary::Open].map(|b| o.clone().with_boundary(b)).into());
    each(&|o| PLACEMENTS.map(|p| o.clone().with_placement(p)).into());
    each(&|o| [Gradient::Central, Gradient::Matching].map(|g| o.clone().with_gradient(g)).into());
    each(&|o| [Diagonals::Table, Diagonals::Fitted].map(|d| o.clone().with_diagonals(d)).into());
    modes
}

#[test]
fn volumes_full_of_ties_are_closed_and_have_no_flat_triangle_in_any_mode() {
    let modes = modes();
    assert_eq!(modes.len(), 48);
    let count = many("VOLUMES", 100);
    for seed in 0..count as u64 {
        let volume = volume(seed);
        let ties = volume.samples().iter().filter(|&&sample| sample == 0).count();
        assert!(ties > 15, "chance without ties shows nothing");
        for options in &modes {
            let mesh = extract(&volume.view(), 0.0, options, &Job::default()).unwrap();
            assert!(matches!(mesh.positions, Positions::F32(_)), "what files hold");
            assert!(mesh.normals.is_some(), "which are looked at too");
            match options.boundary {
                Boundary::Closed => {
                    assert!(assert_closed(&mesh).volume > 0.0, "seed {seed}, {options:?}");
                }
                Boundary::Open => drop(assert_sound(&mesh)),
            }
        }
    }
    looked_at(count, &format!("volumes full of ties, in {} modes each", modes.len()));
}

#[test]
fn exact_placement_has_the_same_triangles_and_some_of_them_flat() {
    // What is fitted is fitted to positions.
    let mut modes = modes();
    modes.retain(|options| options.diagonals == Diagonals::Table);
    let (mut flat, count) = (0, many("VOLUMES", 50));
    for seed in 0..count as u64 {
        let volume = volume(seed);
        for options in &modes {
            let of = |degenerate| {
                let options = options.clone().with_degenerate(degenerate);
                extract(&volume.view(), 0.0, &options, &Job::default()).unwrap()
            };
            let (never, exact) = (of(Degenerate::Never), of(Degenerate::Exact));
            assert_eq!(never.triangles, exact.triangles, "seed {seed}, {options:?}");
            let census = Census::of(&exact);
            assert_eq!(census.faults_of_topology(), 0, "seed {seed}, {options:?}");
            let is_closed = options.boundary == Boundary::Closed;
            assert!(!is_closed || census.boundary_sides == 0, "seed {seed}, {options:?}");
            flat += census.flat_triangles;
        }
    }
    assert!(flat > 3 * count * modes.len(), "{flat}");
    looked_at(count, &format!("volumes full of ties, exactly placed in {} modes", modes.len()));
}

#[test]
fn a_smooth_shape_rounded_to_whole_numbers_is_closed_at_every_isovalue() {
    let torus = fields::torus(0.6, 0.25);
    let grid = Grid::new([20; 3], Frame::default()).unwrap();
    let at = |n: u64| {
        let ijk = [n % 20, n / 20 % 20, n / 400];
        (torus(ijk.map(|i| i as f64 * 2.0 / 19.0 - 1.0)) * 10.0).round() as i8
    };
    let volume = Volume::new(grid, (0..8000).map(at).collect()).unwrap();
    for iso in -8..=2 {
        let iso = f64::from(iso);
        let mesh = extract(&volume.view(), iso, &ExtractOptions::DEFAULT, &Job::default()).unwrap();
        assert!(assert_closed(&mesh).volume > 0.0, "iso {iso}");
    }
}
