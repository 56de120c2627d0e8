//! Labels, noise and lattices of other steps as masks.

use super::Mask;
use crate::pipeline::{Region, Scan, SurfaceOptions, TargetSpace, clip::tests::sound};
use isokit_geom::{Affine, Frame, HalfSpace, Space, Unit, vector::length};
use isokit_job::{Job, Threads};
use isokit_lanes::Side;
use isokit_marching_cubes::{Diagonals, Placement};
use isokit_mesh::TriMesh;
use isokit_volume::{Grid, Sample, Volume};
use std::num::NonZeroUsize;

/// Numbers by chance, from a seed.
struct Chance(u64);

impl Chance {
    fn next(&mut self, below: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % below
    }
}

/// A scan whose first sample is at `origin`, and its value by its place.
fn scan<T: Sample>(
    dims: [u64; 3],
    (spacing, origin): ([f64; 3], [f64; 3]),
    mut value: impl FnMut([f64; 3]) -> T,
) -> Scan
where
    isokit_volume::AnyVolume: From<Volume<T>>,
{
    let affine = Affine::axis_aligned(spacing, origin).unwrap();
    let frame = Frame { index_to_world: affine, unit: Unit::Millimetre, space: Space::Ras };
    let grid = Grid::new(dims, frame).unwrap();
    let [nx, ny, _] = dims;
    let place = |n: u64| affine.point([n % nx, n / nx % ny, n / (nx * ny)].map(|i| i as f64));
    Scan::new(Volume::new(grid, (0..grid.count()).map(|n| value(place(n))).collect()).unwrap())
}

/// How deep a place is in a ball of radius 8 around 0.
fn ball() -> Scan {
    let place = ([0.5, 0.6, 0.55], [-11.0, -10.0, -10.5]);
    scan([45, 35, 39], place, |place| (8.0 - length(place)) as f32)
}

fn masked(scan: &Scan, iso: f64, mask: &Mask) -> TriMesh {
    let options = SurfaceOptions::default();
    scan.clipped_mesh(iso, (&[], Some(mask)), &options, &Job::default()).unwrap().0
}

#[track_caller]
fn check_sound(mesh: &TriMesh) -> f64 {
    sound(mesh).measure.volume
}

#[test]
fn a_label_is_a_solid_of_its_own_however_its_neighbours_are_called() {
    let job = Job::default();
    let labels = scan([12, 10, 9], ([1.0, 2.0, 0.5], [5.0, -3.0, 0.25]), |[x, ..]| match x {
        x if x < 8.5 => 3_u8,
        x if x < 12.5 => 7,
        _ => 0,
    });
    let cases = [(Some(&[7.0][..]), 8.5, 4), (Some(&[3.0, 7.0]), 5.0, 8), (None, 5.0, 8)];
    for (values, from, samples) in cases {
        let mask = labels.mask(&labels, values, &job).unwrap();
        assert_eq!(mask.count(), samples * 90);
        let mesh = masked(&labels, 0.5, &mask);
        // Rims are cut off within a cell.
        let (volume, whole) = (check_sound(&mesh), (12.5 - from) * 18.0 * 4.0);
        assert!((0.9..1.001).contains(&(volume / whole)), "{values:?}: {volume} of {whole}");
        // A label ends halfway to the next one; on the border of the volume, there.
        let bounds = mesh.bounds().unwrap();
        let away = [bounds.min[0] - from, bounds.max[0] - 12.5].map(f64::abs);
        assert!(away.iter().all(|away| *away < 2e-3), "{bounds:?}");
    }
    let mask = labels.mask(&labels, Some(&[4.0, f64::NAN, -f64::NAN]), &job).unwrap();
    assert_eq!((mask.count(), masked(&labels, 0.5, &mask).triangles.len()), (0, 0));
}

#[test]
fn a_mask_of_finer_or_coarser_samples_cuts_where_these_end() {
    let job = Job::default();
    // Half of the space, up to a wall that lies between samples of the mask.
    for (step, expected) in [(0.1, 1.25), (0.5, 1.25), (3.0, 1.0)] {
        let n = (30.0 / step) as u64;
        let place = ([step; 3], [-14.0 + 0.5 * step; 3]);
        let half = scan([n; 3], place, |[x, ..]| u8::from(x < 1.24));
        let mask = ball().mask(&half, None, &job).unwrap();
        let mesh = masked(&ball(), 0.0, &mask);
        check_sound(&mesh);
        let normals = mesh.normals.as_ref().unwrap();
        let farthest = mesh.bounds().unwrap().max[0];
        // The wall is halfway between the last sample within and the first beyond.
        assert!((farthest - expected).abs() <= 0.51 * step, "{step}: {farthest}");
        let on_wall =
            mesh.positions.iter().zip(normals).filter(|([x, ..], _)| *x > farthest - 1e-6);
        let on_wall: Vec<_> = on_wall.collect();
        assert!(on_wall.len() > 500, "{} vertices on the wall", on_wall.len());
        let (place, normal) =
            on_wall.iter().find(|([_, y, z], _)| y.abs() + z.abs() < 1.0).unwrap();
        assert!(normal[0] > 0.8, "{place:?}: {normal:?}");
    }
}

#[test]
fn all_of_a_mask_is_no_cut_and_none_of_it_leaves_nothing() {
    let job = Job::default();
    let other = |value| scan([12; 3], ([2.5; 3], [-13.0; 3]), move |_| value);
    let linear = SurfaceOptions::default();
    let extract = linear.extract.clone().with_placement(Placement::Linear);
    let linear = linear.with_extract(extract.with_diagonals(Diagonals::Table));
    let plain = ball().mesh(0.0, &linear, &job).unwrap();
    let all = masked(&ball(), 0.0, &ball().mask(&other(0.5_f32), None, &job).unwrap());
    assert_eq!(all.triangles, plain.triangles);
    for (a, b) in all.positions.iter().zip(plain.positions.iter()) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 5e-5), "{a:?} {b:?}");
    }
    for nothing in [other(0.0), other(f32::NAN), scan([2; 3], ([1.0; 3], [99.0; 3]), |_| 1.0_f32)] {
        let mask = ball().mask(&nothing, None, &job).unwrap();
        assert_eq!(masked(&ball(), 0.0, &mask).triangles.len(), 0);
    }
}

#[test]
fn masks_by_chance_leave_what_is_closed_for_any_lattice_and_threads() {
    let mut chance = Chance(11);
    for n in 0..40 {
        let noise = scan([9; 3], ([1.0; 3], [0.0; 3]), |_| chance.next(16) as i8 - 8);
        let step = [1.0, 0.37, 2.2, 0.5][n % 4];
        let origin = [0.0, 1.3, -0.5, 0.25][n / 4 % 4];
        let dims = [(8.0 / step) as u64 + 1; 3];
        let other = scan(dims, ([step; 3], [origin; 3]), |_| chance.next(3) as i16);
        let values = [None, Some(&[1.0][..]), Some(&[2.0, 0.0])][n % 3];
        let mask = noise.mask(&other, values, &Job::default()).unwrap();
        let mesh = masked(&noise, 0.0, &mask);
        check_sound(&mesh);
        let threads = Threads::new(NonZeroUsize::new(3).unwrap()).unwrap();
        let job = Job { threads, ..Job::default() };
        let plane = [HalfSpace::new([1.0, 2.0, -0.5], 8.0).unwrap()];
        let options = SurfaceOptions::default();
        let both =
            |job: &Job| noise.clipped_mesh(0.0, (&plane, Some(&mask)), &options, job).unwrap();
        let (mesh, _) = both(&job);
        check_sound(&mesh);
        assert_eq!(mesh, both(&Job::default()).0);
    }
}

#[test]
fn with_an_index_bricks_that_a_mask_cuts_away_are_skipped_and_nothing_changes() {
    let (job, options) = (Job::default(), SurfaceOptions::default());
    let place = ([1.0; 3], [-60.0, -30.0, -30.0]);
    // Two balls, of which a mask cuts one in two and leaves nothing of the other.
    let balls = |[x, y, z]: [f64; 3]| {
        let away = [-20.0, 35.0].map(|at| length([x - at, y, z]));
        (6.0 - away[0].min(away[1])) as f32
    };
    let plain = scan([120, 60, 60], place, balls);
    let mut indexed = plain.clone();
    indexed.index(&job).unwrap();
    let half =
        scan([60, 40, 40], ([1.0, 1.5, 1.5], [-70.0, -29.0, -29.0]), |[x, ..]| u8::from(x < -19.0));
    let mask = plain.mask(&half, None, &job).unwrap();
    let made = |scan: &Scan, cut| scan.clipped_mesh(0.0, (&[], cut), &options, &job).unwrap();
    let (mesh, told) = made(&indexed, Some(&mask));
    assert!(mesh.triangles.len() > 300 && mesh == made(&plain, Some(&mask)).0);
    assert!(mesh.bounds().unwrap().max[0] < -18.0);
    let all = made(&indexed, None).1.skipped;
    assert!(told.skipped.bricks_skipped > all.bricks_skipped, "{:?} {all:?}", told.skipped);
}

#[test]
fn what_is_said_of_a_box_holds_for_all_places_in_it() {
    let mut chance = Chance(5);
    let (mut sides, noise) = ([0; 3], ball());
    for n in 0..400 {
        // Pieces as large as some boxes.
        let step = [0.5, 1.7, 0.9][n % 3];
        let place = ([step, step, 0.6 * step], [-12.0, -9.5, -11.0]);
        let dims = [(23.0 / step) as u64; 3];
        let at = [chance.next(12), chance.next(12), chance.next(12)].map(|c| c as f64 - 12.0);
        let piece = scan(dims, place, |place| {
            u8::from((0..3).all(|k| (at[k]..at[k] + 14.0).contains(&place[k])))
        });
        let mask = noise.mask(&piece, None, &Job::default()).unwrap();
        let dims = [45, 35, 39];
        let points = [0, 1, 2].map(|k| {
            let start = chance.next(dims[k]) as usize;
            start..(start + 1 + chance.next(6) as usize).min(dims[k] as usize)
        });
        let [x, y, z] = points.clone();
        let mut kept = vec![];
        for k in z {
            for (i, j) in y.clone().flat_map(|j| x.clone().map(move |i| (i, j))) {
                kept.push(mask.keeps([i, j, k].map(|c| c as f64)));
            }
        }
        let side = mask.side(&points);
        match side {
            Side::Inside => assert!(kept.iter().all(|kept| *kept), "{points:?}"),
            Side::Outside => assert!(kept.iter().all(|kept| !kept), "{points:?}"),
            Side::Both => {}
        }
        sides[side as usize] += 1;
    }
    assert!(sides.iter().all(|&count| count > 20), "{sides:?}");
}

#[test]
fn places_halfway_between_samples_go_one_way_in_any_part_and_world() {
    let job = Job::default();
    let mut chance = Chance(3);
    // Every second sample of the scan is halfway between two of the mask.
    let place = ([0.7, 1.1, 0.3], [12.3, -4.1, 77.7]);
    let all = scan([25, 21, 23], place, |_| 1.0_f32);
    let steps = place.0.map(|step| 2.0 * step);
    let blocks = scan([12, 10, 11], (steps, place.1), |_| chance.next(2) as u8);
    let mask = all.mask(&blocks, None, &job).unwrap();
    let kept = |mask: &Mask, first: f64| {
        let numbers = (0..16 * 16 * 16).map(|n| [n % 16, n / 16 % 16, n / 256]);
        let places = numbers.map(|ijk| ijk.map(|c| f64::from(c) + 1.0 - first));
        places.map(|place| mask.keeps(place)).collect::<Vec<_>>()
    };
    let expected = kept(&mask, 0.0);
    assert!(expected.contains(&true) && expected.contains(&false));
    let later = |ijk: [f64; 3]| mask.keeps(ijk.map(|c| 2.0 * (0.5 * c + 0.5).floor()));
    let numbers = (0..4096).map(|n| [n % 16, n / 16 % 16, n / 256].map(|c| f64::from(c) + 1.0));
    assert!(numbers.zip(&expected).all(|(ijk, kept)| later(ijk) == *kept), "the later one");
    for space in [TargetSpace::Lps, TargetSpace::Index] {
        let placed = all.clone().placed(space).unwrap();
        assert!(kept(&placed.mask(&blocks, None, &job).unwrap(), 0.0) == expected);
    }
    let part = all.cropped(&Region::parse_samples("1:,1:,1:").unwrap()).unwrap();
    assert!(kept(&part.mask(&blocks, None, &job).unwrap(), 1.0) == expected);
}

#[test]
fn places_halfway_go_to_the_later_sample_whatever_the_ratio_of_steps() {
    let job = Job::default();
    // In steps of sixtieths both volumes have whole numbers.
    for [own, other] in [[50, 60], [5, 60], [10, 60], [42, 12], [20, 24], [7, 2], [30, 60]] {
        let steps = [own, other].map(|step: i64| [step as f64 / 60.0, 1.0, 1.0]);
        let first = [7.3, 0.0, 0.0];
        let count = 40 * other / own;
        let all = scan([count as u64 + 1, 2, 2], (steps[0], first), |_| 1_f32);
        let mut at = 0;
        let odd = scan([40, 2, 2], (steps[1], first), |_| {
            at += 1;
            u8::from(at % 2 == 0)
        });
        let mask = all.mask(&odd, None, &job).unwrap();
        let mut halfway = 0;
        for i in 0..=count {
            // Halfway is rounded up.
            let nearest = (2 * i * own + other).div_euclid(2 * other);
            halfway += i64::from((2 * i * own + other) % (2 * other) == 0);
            let expected = nearest < 40 && nearest % 2 == 1;
            if 2 * i * own <= 79 * other - other {
                assert_eq!(mask.keeps([i as f64, 0.0, 0.0]), expected, "{i} of {own}/{other}");
            }
        }
        assert!(halfway > 2, "{halfway} of {own}/{other}");
    }
}

#[test]
fn of_a_lattice_that_no_number_holds_nothing_is_kept_and_nothing_promised() {
    let far = scan([3; 3], ([1e-74; 3], [1e250; 3]), |_| 1_u8);
    let mask = ball().mask(&far, None, &Job::default()).unwrap();
    assert!(!mask.keeps([1.0; 3]));
    assert_ne!(mask.side(&[0..9, 3..4, 2..20]), Side::Inside);
}

#[test]
#[should_panic(expected = "a mask of the same part in the same place")]
fn a_mask_of_another_part_is_refused() {
    let mask = ball().mask(&ball(), None, &Job::default()).unwrap();
    let part = ball().cropped(&Region::parse_samples("1:,1:,1:").unwrap()).unwrap();
    masked(&part, 0.0, &mask);
}

#[test]
fn parts_and_worlds_of_both_volumes_are_looked_through() {
    let job = Job::default();
    let half =
        scan([40, 16, 16], ([0.5, 1.5, 1.5], [-12.0, -11.0, -12.0]), |[x, ..]| u8::from(x < 0.0));
    let whole = masked(&ball(), 0.0, &ball().mask(&half, None, &job).unwrap());
    let lps = ball().placed(TargetSpace::Lps).unwrap();
    let turned = masked(&lps, 0.0, &lps.mask(&half, None, &job).unwrap());
    assert_eq!(turned.triangles.len(), whole.triangles.len());
    let [there, here] = [&turned, &whole].map(|mesh| mesh.bounds().unwrap());
    assert!((there.min[0] + here.max[0]).abs() < 1e-6, "{there:?} {here:?}");
    // Of parts each sample stays where it was.
    let region = Region::parse_samples("4:,3:33,:").unwrap();
    let part = ball().cropped(&region).unwrap();
    let other = half.clone().cropped(&Region::parse_samples("2:,:,1:15").unwrap()).unwrap();
    let cropped = masked(&part, 0.0, &part.mask(&other, None, &job).unwrap());
    assert_eq!(cropped.positions.len(), whole.positions.len());
    for (a, b) in cropped.positions.iter().zip(whole.positions.iter()) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5), "{a:?} {b:?}");
    }
}
