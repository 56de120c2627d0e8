//! Scans of a few samples, of which everything is known.

use super::Scan;
use crate::pipeline::{
    Index, IsoChoice, Normals, PipelineError, Region, Remark, SurfaceOptions, TargetSpace,
};
use isokit_geom::{Affine, Frame, Space};
use isokit_job::Job;
use isokit_marching_cubes::{Boundary, ExtractError, ExtractOptions, Nan, Placement};
use isokit_mesh::TriMesh;
use isokit_volume::{Grid, Volume};
use std::slice;

/// 6 × 5 × 4 samples, in RAS, with distances of 1, 2 and 3.
fn scan(value: impl Fn([usize; 3]) -> f32) -> Scan {
    let index_to_world = Affine::axis_aligned([1.0, 2.0, 3.0], [10.0, 20.0, 30.0]).unwrap();
    let frame = Frame { index_to_world, space: Space::Ras, ..Frame::default() };
    let grid = Grid::new([6, 5, 4], frame).unwrap();
    let samples = (0..120).map(|n| value([n % 6, n / 6 % 5, n / 30])).collect();
    Scan::new(Volume::new(grid, samples).unwrap())
}

/// One sample is 1, all others are 0.
fn dot(at: [usize; 3]) -> Scan {
    scan(move |ijk| if ijk == at { 1.0 } else { 0.0 })
}

fn open() -> SurfaceOptions {
    SurfaceOptions::default().with_extract(ExtractOptions::DEFAULT.with_boundary(Boundary::Open))
}

fn mesh(scan: &Scan, options: &SurfaceOptions) -> TriMesh {
    scan.mesh(0.5, options, &Job::default()).unwrap()
}

fn remark(scan: &Scan, iso: f64, options: &SurfaceOptions) -> Option<Remark> {
    let (job, mut mesh) = (Job::default(), TriMesh::default());
    scan.mesh_into(iso, options, &mut mesh, &job).unwrap();
    scan.remark(iso, mesh.counts(), options, &job).unwrap()
}

#[test]
fn normals_are_those_that_were_asked_for() {
    let dot = dot([2, 2, 2]);
    let with = |normals| mesh(&dot, &SurfaceOptions::default().with_normals(normals));
    let [gradient, area, none] = [Normals::Gradient, Normals::Area, Normals::None].map(with);
    assert!(none.normals.is_none());
    for (made, kind) in [(gradient, "gradient"), (area, "area")] {
        assert_eq!(made.positions, none.positions, "{kind}");
        assert_eq!(made.triangles, none.triangles, "{kind}");
        let centre = [12.0, 24.0, 36.0];
        for (normal, position) in made.normals.unwrap().iter().zip(made.positions.iter()) {
            let outwards = (0..3).map(|k| f64::from(normal[k]) * (position[k] - centre[k]));
            assert!(outwards.sum::<f64>() > 0.0, "{kind} at {position:?}");
        }
    }
}

#[test]
fn a_used_mesh_keeps_nothing_of_its_content() {
    let (dot, job) = (dot([2, 2, 2]), Job::default());
    let mut used = dot.mesh(0.25, &SurfaceOptions::default(), &job).unwrap();
    let flat = SurfaceOptions::default().with_normals(Normals::None);
    for options in [flat, SurfaceOptions::default()] {
        dot.mesh_into(0.5, &options, &mut used, &job).unwrap();
        assert_eq!(used, mesh(&dot, &options));
    }
}

#[test]
fn an_index_changes_no_surface_of_the_whole_or_of_a_part() {
    let (job, region) = (Job::default(), Region::parse_samples("1:,1:4,1:4").unwrap());
    let whole = dot([2, 2, 2]);
    let mut indexed = whole.clone();
    assert_eq!(indexed.index(&job).unwrap(), Index::NotKept(None));
    assert_eq!(mesh(&indexed, &open()), mesh(&whole, &open()));
    let mut meshes = vec![TriMesh::default(); 2];
    let skipped = indexed.meshes_into(&[2.0, 3.0], &open(), &mut meshes, &job).unwrap()[0].skipped;
    assert_eq!((skipped.bricks, skipped.bricks_skipped, skipped.samples_read), (1, 1, 0));
    let [part, indexed] = [whole, indexed].map(|scan| scan.cropped(&region).unwrap());
    assert_eq!(mesh(&indexed, &open()), mesh(&part, &open()));
}

#[test]
fn an_index_is_left_aside_where_a_surface_is_nearly_everywhere() {
    /// Two bricks along x, of 64 samples, and 13 along y and z.
    const N: usize = 100;
    let job = Job::default();
    let samples = |n: usize| {
        let ijk = [n % N, n / N % N, n / (N * N)];
        ijk.iter().map(|&i| (i as f32 - 32.0).powi(2)).sum::<f32>().sqrt()
    };
    let grid = Grid::new([N as u64; 3], Frame::default()).unwrap();
    let plain = Scan::new(Volume::new(grid, (0..N.pow(3)).map(samples).collect()).unwrap());
    let mut indexed = plain.clone();
    indexed.index(&job).unwrap();
    for (radius, is_used) in [(12.0, true), (60.0, false)] {
        let mut found = TriMesh::default();
        let meshes = slice::from_mut(&mut found);
        let skipped = indexed.meshes_into(&[radius], &open(), meshes, &job).unwrap()[0].skipped;
        assert_eq!(skipped.bricks, 2 * 13 * 13);
        assert_eq!(skipped.bricks_skipped > 0, is_used);
        assert_eq!(skipped.samples_read < N.pow(3) as u64, is_used);
        assert_eq!(found, plain.mesh(radius, &open(), &job).unwrap());
    }
}

#[test]
fn a_part_leaves_the_surface_where_it_was() {
    let region = Region::parse_samples("1:,1:4,1:4").unwrap();
    for space in [TargetSpace::Source, TargetSpace::Lps, TargetSpace::Index] {
        let whole = dot([2, 2, 2]).placed(space).unwrap();
        let part = whole.clone().cropped(&region).unwrap();
        assert!(part.is_cropped() && !whole.is_cropped());
        let extract = open().extract.with_placement(Placement::Linear);
        let linear = open().with_extract(extract);
        let [whole, part] = [whole, part].map(|scan| mesh(&scan, &linear));
        assert_eq!(part.bounds(), whole.bounds(), "{space:?}");
        assert_eq!(part.counts(), whole.counts(), "{space:?}");
    }
}

#[test]
fn where_the_samples_around_an_edge_are_in_a_part_it_leaves_the_vertex_where_it_was() {
    const N: usize = 20;
    let grid = Grid::new([N as u64; 3], Frame::default()).unwrap();
    let wave = |n: usize| [n % N, n / N % N, n / N / N].map(|i| (0.7 * i as f32).sin());
    let samples = (0..N.pow(3)).map(|n| wave(n).iter().sum::<f32>()).collect();
    let whole = Scan::new(Volume::new(grid, samples).unwrap());
    let part = whole.clone().cropped(&Region::parse_samples("4:16,3:17,5:18").unwrap()).unwrap();
    let places = |scan: &Scan| -> Vec<[f64; 3]> {
        let inner = [6.0..13.0, 5.0..14.0, 7.0..15.0];
        let is_inner = |place: &[f64; 3]| inner.iter().zip(place).all(|(i, c)| i.contains(c));
        mesh(scan, &open()).positions.iter().filter(is_inner).collect()
    };
    let (part, whole) = (places(&part), places(&whole));
    assert!(part.len() == whole.len() && part.len() > 150, "{} of {}", part.len(), whole.len());
    // The place, a sum with the sample's number, may round differently.
    let off = part.iter().flatten().zip(whole.iter().flatten()).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) <= 2e-6);
}

#[test]
fn what_is_chosen_is_chosen_by_the_part() {
    let ramp = scan(|[i, _, _]| i as f32);
    let job = Job::default();
    assert_eq!(ramp.iso(IsoChoice::Percent(50.0), &job).unwrap(), 2.5);
    assert_eq!(ramp.iso(IsoChoice::Value(-7.0), &job).unwrap(), -7.0);
    let part = ramp.cropped(&Region::parse_samples("3:5,:,:").unwrap()).unwrap();
    assert_eq!(part.iso(IsoChoice::Percent(50.0), &job).unwrap(), 3.5);
    let auto = part.iso(IsoChoice::Auto, &job).unwrap();
    assert!(auto > 3.0 && auto < 4.0, "{auto}");
}

#[test]
fn samples_of_one_value_give_no_automatic_isovalue() {
    let (flat, job) = (scan(|_| 7.0), Job::default());
    let error = flat.iso(IsoChoice::Auto, &job).unwrap_err().to_string();
    assert_eq!(error, "auto gives no isovalue: all samples have one value");
    let none = scan(|_| f32::NAN).iso(IsoChoice::Percent(10.0), &job).unwrap_err().to_string();
    assert_eq!(none, "10% gives no isovalue: no sample is finite");
}

#[test]
fn an_infinite_sample_leaves_the_percentages_finite() {
    let ramp = scan(|[i, _, _]| if i == 0 { f32::NEG_INFINITY } else { i as f32 });
    let half = ramp.iso(IsoChoice::Percent(50.0), &Job::default()).unwrap();
    assert_eq!(half, 3.0);
    let five = scan(|[i, _, _]| if i == 0 { f32::INFINITY } else { 5.0 });
    for percent in [0.0, 50.0, 100.0] {
        assert_eq!(five.iso(IsoChoice::Percent(percent), &Job::default()).unwrap(), 5.0);
    }
}

#[test]
fn an_empty_surface_is_explained() {
    let dot = dot([2, 2, 2]);
    let (range, closed) = ([0.0, 1.0], SurfaceOptions::default());
    assert_eq!(remark(&dot, 0.5, &closed), None);
    assert_eq!(remark(&dot, 1.0, &closed), None);
    assert_eq!(remark(&dot, 2.0, &closed), Some(Remark::AllOutside { iso: 2.0, range }));
    for (options, boundary) in [(closed, Boundary::Closed), (open(), Boundary::Open)] {
        let all_inside = Remark::AllInside { iso: 0.0, range, boundary };
        assert_eq!(remark(&dot, 0.0, &options), Some(all_inside));
    }
    let thin = dot.cropped(&Region::parse_samples(":,:,2:3").unwrap()).unwrap();
    assert_eq!(remark(&thin, 0.5, &open()), Some(Remark::NoCells));
    assert_eq!(remark(&scan(|_| f32::NAN), 0.5, &open()), Some(Remark::AllNan));
}

#[test]
fn nan_is_named_by_its_place_in_the_whole() {
    let region = Region::parse_samples("1:,2:,3:").unwrap();
    let hole = scan(|ijk| if ijk == [4, 3, 3] { f32::NAN } else { 0.0 }).cropped(&region).unwrap();
    let strict =
        SurfaceOptions::default().with_extract(ExtractOptions::DEFAULT.with_nan(Nan::Error));
    let error = hole.mesh(0.5, &strict, &Job::default()).unwrap_err();
    let nan = ExtractError::Nan { count: 1, first: [4, 3, 3] };
    assert!(matches!(error, PipelineError::Extract(found) if found == nan));
}
