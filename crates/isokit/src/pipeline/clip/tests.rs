//! Balls, waves and noise that planes cut.

use super::{
    Degenerate, Placement,
    samples::{Clipped, Fall, WINDOW, cuts},
};
use crate::pipeline::{Scan, SurfaceOptions};
use isokit_geom::{
    Affine, Frame, HalfSpace,
    vector::{dot, length},
};
use isokit_job::Job;
use isokit_mesh::{Topology, TriMesh, topology};
use isokit_volume::{Grid, Volume, collect};
use std::{collections::BTreeSet, f64::consts::PI};

/// How deep a place is in a ball of radius 10 around 0.
fn ball() -> Scan {
    let affine = Affine::axis_aligned([0.5, 0.6, 0.55], [-12.0; 3]).unwrap();
    let grid = Grid::new([49, 41, 45], Frame { index_to_world: affine, ..Frame::default() });
    let grid = grid.unwrap();
    let depth = |n: u64| {
        let place = affine.point([n % 49, n / 49 % 41, n / 2009].map(|i| i as f64));
        (10.0 - length(place)) as f32
    };
    Scan::new(Volume::new(grid, (0..grid.count()).map(depth).collect()).unwrap())
}

/// The topology of a mesh that falls short in nothing, and has no two vertices in one place.
#[track_caller]
pub(super) fn sound(mesh: &TriMesh) -> Topology {
    let found = topology(mesh, &Job::default()).unwrap();
    assert_eq!(found.shortfalls(), [""; 0]);
    // + 0.0 makes 0 of −0.
    let bits = |place: [f64; 3]| place.map(|c| (c + 0.0).to_bits());
    let places: BTreeSet<_> = mesh.positions.iter().map(bits).collect();
    assert_eq!(places.len(), mesh.positions.len(), "places");
    found
}

fn clipped(scan: &Scan, iso: f64, planes: &[HalfSpace]) -> TriMesh {
    let (options, job) = (SurfaceOptions::default(), Job::default());
    scan.clipped_mesh(iso, (planes, None), &options, &job).unwrap().0
}

#[test]
fn a_ball_that_a_plane_cuts_is_closed_and_flat_there_with_the_volume_of_its_cap() {
    for (normal, far) in [([0.0, 0.0, 1.0], 3.0), ([1.0, -2.0, 0.5], -4.0), ([3.0, 1.0, 2.0], 0.0)]
    {
        let long = length(normal);
        let plane = HalfSpace::new(normal, far * long).unwrap();
        let mesh = clipped(&ball(), 0.0, &[plane]);
        let found = sound(&mesh);
        assert_eq!((found.components.len(), found.euler()), (1, 2));
        // All but a cap of height 10 - far.
        let height = 10.0 - far;
        let whole = 4.0 / 3.0 * PI * 1000.0;
        let expected = whole - PI * height * height * (30.0 - height) / 3.0;
        assert!(
            (found.measure.volume / expected - 1.0).abs() < 0.015,
            "{} for {expected}",
            found.measure.volume
        );
        // The farthest vertices are on the plane, and look along it.
        let unit = normal.map(|c| c / long);
        let normals = mesh.normals.as_ref().unwrap();
        let (mut on, mut area) = (0, 0.0);
        for (place, normal) in mesh.positions.iter().zip(normals) {
            let away = dot(unit, place) - far;
            assert!(away < 2e-3, "{away}");
            let outward = if away > -1e-6 { unit } else { place.map(|c| c / length(place)) };
            on += u32::from(away > -1e-6);
            let cosine = dot(normal.map(f64::from), outward);
            area += f64::from(u8::from(cosine < 0.9));
        }
        let circle = PI * (100.0 - far * far) / 0.3;
        assert!(f64::from(on) > 0.5 * circle, "{on} of {circle}");
        assert!(area < 0.02 * normals.len() as f64, "{area} of {}", normals.len());
    }
}

#[test]
fn a_cut_is_flat_also_where_samples_are_the_isovalue_and_vertices_may_lie_on_them() {
    let grid = Grid::new([24, 9, 9], Frame::default()).unwrap();
    let block = Scan::new(Volume::new(grid, vec![100_u8; 24 * 81]).unwrap());
    let plane = [HalfSpace::new([1.0, 0.0, 0.0], 11.3).unwrap()];
    let exact = SurfaceOptions::default().extract.with_degenerate(Degenerate::Exact);
    let options = SurfaceOptions::default().with_extract(exact);
    let (mesh, _) = block.clipped_mesh(100.0, (&plane, None), &options, &Job::default()).unwrap();
    assert_eq!(topology(&mesh, &Job::default()).unwrap().shortfalls(), [""; 0]);
    let most = mesh.bounds().unwrap().max[0];
    assert!((most - 11.3).abs() < 1e-5, "{most}");
    let wall = mesh.positions.iter().filter(|place| (place[0] - 11.3).abs() < 1e-5).count();
    assert_eq!(wall, 81, "a vertex on each row of samples");
}

#[test]
fn slice_by_slice_it_is_the_surface_of_all_samples_that_planes_cut() {
    let job = Job::default();
    let grid = Grid::new([400, 300, 80], Frame::default()).unwrap();
    let wave = |n: u64| {
        let [i, j, k] = [n % 400, n / 400 % 300, n / 120_000].map(|i| i as f64);
        ((i * 0.21).sin() + (j * 0.17).cos() + (k * 0.3).sin()) as f32
    };
    let volume = Volume::new(grid, (0..grid.count()).map(wave).collect()).unwrap();
    let planes = [HalfSpace::new([1.0, 2.0, -0.5], 250.0).unwrap()];
    let options = SurfaceOptions::default();
    let linear = options.extract.clone().with_placement(Placement::Linear);
    let linear = options.clone().with_extract(linear);
    let (view, cuts) = (volume.view(), cuts(&grid.frame.index_to_world, &planes));
    let fall = Fall::of(&view, [-3.0, 3.0]);
    let clipped = Clipped { view, iso: 0.5, fall, cuts: &cuts, mask: None, known: None };
    assert!(8 * grid.count() > WINDOW, "more than one window");
    let whole = collect(&mut clipped.slices(&job), &job).unwrap();
    let whole = Scan::new(whole).mesh(0.5, &linear, &job).unwrap();
    let mut slabs = TriMesh::default();
    clipped.mesh_into(&linear, &mut slabs, &job).unwrap();
    assert!(whole.triangles.len() > 10_000 && slabs == whole);
}

#[test]
fn any_planes_leave_what_is_closed_and_none_or_all_of_it() {
    let plane = |normal, offset| HalfSpace::new(normal, offset).unwrap();
    let wedge =
        [plane([1.0, 0.0, 0.0], 0.0), plane([0.2, 1.0, 0.0], 1.0), plane([0.0, 0.3, -1.0], 2.0)];
    let grid = Grid::new([9; 3], Frame::default()).unwrap();
    let mut state = 7_u64;
    let mut chance = |_| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
        (state >> 60) as i8 - 8
    };
    for n in 0..60 {
        let noise = Volume::new(grid, (0..729).map(&mut chance).collect()).unwrap();
        let scan = Scan::new(noise);
        let at = f64::from(n % 7) * 0.5;
        let cuts = [plane([1.0, f64::from(n % 3), 0.0], 3.0 + at), plane([0.0, -1.0, 1.0], at)];
        sound(&clipped(&scan, 0.0, &cuts));
    }
    assert_eq!(sound(&clipped(&ball(), 0.0, &wedge)).components.len(), 1);
    let nothing = clipped(&ball(), 0.0, &[plane([0.0, 0.0, 1.0], -50.0)]);
    assert_eq!(nothing.triangles.len(), 0);
    let all = clipped(&ball(), 0.0, &[plane([0.0, 0.0, 1.0], 50.0)]);
    let linear = SurfaceOptions::default();
    let linear = linear.clone().with_extract(linear.extract.with_placement(Placement::Linear));
    assert_eq!(all.triangles, ball().mesh(0.0, &linear, &Job::default()).unwrap().triangles);
}

/// Samples one apart with axes that are turned, the first of them at `origin`.
fn turned(origin: f64, value: impl FnMut(u64) -> f32) -> Scan {
    let columns = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
    let affine = Affine::new(columns, [origin; 3]).unwrap();
    let grid = Grid::new([24, 12, 10], Frame { index_to_world: affine, ..Frame::default() });
    Scan::new(Volume::new(grid.unwrap(), (0..24 * 12 * 10).map(value).collect()).unwrap())
}

#[test]
fn far_from_the_origin_cuts_are_where_they_should_as_far_as_numbers_tell() {
    let job = Job::default();
    for origin in [0.0, 1e4, 1e5, -3e5] {
        let full = turned(origin, |_| 1.0);
        let along = full.frame().index_to_world.columns()[0];
        let at = full.frame().index_to_world.point([11.3, 0.0, 0.0]);
        let plane = HalfSpace::new(along, dot(along, at)).unwrap();
        let labels = turned(origin, |n| f32::from(u8::from(n % 24 < 12)));
        let mask = full.mask(&labels, None, &job).unwrap();
        let options = SurfaceOptions::default();
        for (planes, mask, wall) in [(&[plane][..], None, 11.3), (&[], Some(&mask), 11.5)] {
            let (mesh, told) = full.clipped_mesh(0.5, (planes, mask), &options, &job).unwrap();
            sound(&mesh);
            let inverse = |place| full.frame().index_to_world.inverse_point(place);
            let mut on_wall = 0;
            for place in mesh.positions.iter().map(inverse) {
                // Within what f32 tells of places so far away.
                assert!(place[0] < wall + 4e-7 * origin.abs() + 1e-5, "{origin}: {place:?}");
                on_wall += u32::from(place[0] > 11.0 + told.margin);
            }
            assert_eq!(on_wall, 12 * 10, "{origin}: one on each row");
        }
    }
}

#[test]
fn caps_on_the_border_look_outwards_and_what_is_infinite_is_cut_too() {
    let (options, job) = (SurfaceOptions::default(), Job::default());
    let mut state = 1_u32;
    let noise = turned(0.0, |_| {
        state = state.wrapping_mul(1664525).wrapping_add(1013904223);
        (state >> 16) as f32
    });
    let cut = [HalfSpace::new([0.0, 0.0, 1.0], 7.5).unwrap()];
    let (mesh, _) = noise.clipped_mesh(-1.0, (&cut, None), &options, &job).unwrap();
    let middle = noise.frame().index_to_world.point([11.5, 5.5, 3.75]);
    for (place, normal) in mesh.positions.iter().zip(mesh.normals.as_ref().unwrap()) {
        let outward = [0, 1, 2].map(|k| place[k] - middle[k]);
        assert!(dot(outward, normal.map(f64::from)) > 0.0, "{place:?} {normal:?}");
    }
    for greatest in [f32::INFINITY, f32::MAX] {
        let block = turned(0.0, |n| if n % 24 < 15 { greatest } else { -greatest.min(f32::MAX) });
        let along = block.frame().index_to_world.columns()[0];
        let cut = [HalfSpace::new(along, 9.25).unwrap()];
        let (mesh, _) = block.clipped_mesh(0.0, (&cut, None), &options, &job).unwrap();
        let farthest = mesh.positions.iter().map(|place| dot(along, place)).fold(0.0, f64::max);
        assert!((farthest - 9.25).abs() < 1e-5, "{greatest}: {farthest}");
    }
}
