//! Small whole numbers put samples exactly on the isovalue all the time.

use isokit::{
    geom::Frame,
    job::Job,
    marching_cubes::{Degenerate, ExtractOptions, Placement, Topology, extract},
    mesh::Positions,
    volume::{Grid, Volume},
};
use isokit_tests::{
    chance::Chance,
    check::{Census, assert_closed},
    fields,
};

const SIDE: usize = 7;

/// Whole numbers from −3 to 3.
fn volume(seed: u64) -> Volume<i8> {
    let mut chance = Chance::new(seed);
    let grid = Grid::new([SIDE as u64; 3], Frame::default()).unwrap();
    Volume::new(grid, (0..grid.count()).map(|_| chance.below(7) as i8 - 3).collect()).unwrap()
}

const PLACEMENTS: [Placement; 2] = [Placement::Linear, Placement::Quintic];

#[test]
fn a_thousand_volumes_full_of_ties_are_closed_and_have_no_flat_triangle() {
    for seed in 0..1000 {
        let volume = volume(seed);
        let ties = volume.samples().iter().filter(|&&sample| sample == 0).count();
        assert!(ties > 15, "chance without ties shows nothing");
        let topologies = [Topology::Table, Topology::Trilinear];
        for (topology, placement) in topologies.into_iter().flat_map(|t| PLACEMENTS.map(|p| (t, p)))
        {
            let options = ExtractOptions::DEFAULT.with_topology(topology).with_placement(placement);
            let mesh = extract(&volume.view(), 0.0, &options, &Job::default()).unwrap();
            assert!(matches!(mesh.positions, Positions::F32(_)), "what files hold");
            assert!(assert_closed(&mesh).volume > 0.0, "seed {seed}");
        }
    }
}

#[test]
fn exact_placement_has_the_same_triangles_and_some_of_them_flat() {
    let mut flat = 0;
    for (seed, placement) in (0..50).flat_map(|seed| PLACEMENTS.map(|placement| (seed, placement)))
    {
        let volume = volume(seed);
        let of = |degenerate| {
            let options = ExtractOptions::DEFAULT.with_placement(placement);
            let options = options.with_degenerate(degenerate);
            extract(&volume.view(), 0.0, &options, &Job::default()).unwrap()
        };
        let (never, exact) = (of(Degenerate::Never), of(Degenerate::Exact));
        assert_eq!(never.triangles, exact.triangles);
        let census = Census::of(&exact);
        assert_eq!((census.faults_of_topology(), census.boundary_sides), (0, 0));
        flat += census.flat_triangles;
    }
    assert!(flat > 1000, "{flat}");
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
