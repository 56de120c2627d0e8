//! Vertices on curves, sixteen at a time against one by one.

use crate::{ExtractOptions, Gradient, Placement, vertex::Placer};
use isokit_geom::{Affine, Frame};
use isokit_lanes::{Coordinate, Edges, Word};
use isokit_volume::{Grid, Sample, Scaling, Volume};

/// Samples along each axis: enough that a row of edges has a batch far from the border, and another one.
const N: usize = 28;

/// Edges of a row that begin here are far from the lower border of the lattice.
const FAR: usize = 3;

struct Chance(u64);

impl Chance {
    /// From −1 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        (self.0 >> 40) as f64 / 2_f64.powi(23) - 1.0
    }
}

/// Waves and chance from about −2 to 2, and as much more as the noise is.
fn waves(noise: f64, seed: u64) -> impl FnMut(usize) -> f64 {
    waves_of([N; 3], noise, seed)
}

fn waves_of([nx, ny, _]: [usize; 3], noise: f64, seed: u64) -> impl FnMut(usize) -> f64 {
    let mut chance = Chance(seed);
    move |n| {
        let [x, y, z] = [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f64);
        (x * 0.9 + 0.3).sin() + (y * 0.7 + z * 0.5).cos() + noise * chance.next()
    }
}

fn volume<T: Sample>(sample: impl FnMut(usize) -> T) -> Volume<T> {
    volume_of([N; 3], sample)
}

fn volume_of<T: Sample>(dims: [usize; 3], sample: impl FnMut(usize) -> T) -> Volume<T> {
    let columns = [[0.5, 0.1, 0.0], [0.2, 0.7, 0.0], [0.1, -0.9, 2.5]];
    let index_to_world = Affine::new(columns, [3.0, -7.0, 0.5]).unwrap();
    let frame = Frame { index_to_world, ..Frame::default() };
    let grid = Grid::new(dims.map(|n| n as u64), frame).unwrap();
    Volume::new(grid, (0..dims.iter().product()).map(sample).collect::<Vec<T>>()).unwrap()
}

/// Cut edges that are placed, those of them that the curve moved, and those whose matching normal is another.
#[derive(Debug, Default)]
struct Seen {
    placed: usize,
    moved: usize,
    curved: usize,
}

/// Asserts that rows of edges along all axes, up to the border, are placed as one by one, for both types of coordinates.
fn check<T: Sample>(volume: &Volume<T>, iso: f64, placement: Placement) -> Seen {
    let single = check_for::<f32, _>(volume, iso, placement);
    let double = check_for::<f64, _>(volume, iso, placement);
    assert_eq!(single.placed, double.placed);
    double
}

fn check_for<C: Coordinate, T: Sample>(volume: &Volume<T>, iso: f64, placement: Placement) -> Seen {
    let mut seen = Seen::default();
    let [nx, ny, nz] = volume.view().dims();
    // All rows, those next to the border too, or of large lattices so many that each y is there, and each z.
    let rows: Vec<[usize; 2]> = match ny * nz < 100 {
        true => (0..ny * nz).map(|n| [n % ny, n / ny]).collect(),
        false => (0..ny).map(|y| [y, y * 5 % nz]).collect(),
    };
    let ways = [(0.0, Gradient::Matching), (0.01, Gradient::Matching), (0.01, Gradient::Central)];
    for (margin, gradient) in ways {
        let options = ExtractOptions::DEFAULT.with_placement(placement).with_gradient(gradient);
        let placer = Placer::new(volume.view(), iso, margin, 2.0).with_options(&options);
        let begins = [0, FAR].into_iter().flat_map(|first| (0..3).map(move |axis| (first, axis)));
        for ((first, axis), [y, z]) in
            begins.flat_map(|way| rows.iter().map(move |row| (way, *row)))
        {
            let mut edges = Edges::default();
            edges.begin(z as u32);
            let last = nx - usize::from(axis == 0);
            let cuts = [((1 << last) - 1) & (u64::MAX << first); 8];
            edges.push(&[axis], [0, y as u32], &[Word { cuts, ..Word::default() }]);
            let count = edges.len();
            let (mut alone, mut places) = ([[C::default(); 3]; N], [[C::default(); 3]; N]);
            let mut normals = [[0.0; 3]; N];
            let (places, alone) = (&mut places[..count], &mut alone[..count]);
            placer.place(&edges, alone, None, &mut vec![]);
            placer.place(&edges, places, Some(&mut normals[..count]), &mut vec![]);
            for n in 0..count {
                let (axis, low) = edges.get(n);
                let straight = placer.cut(axis, low);
                let [Some(a), Some(b)] = straight.values else { continue };
                if (a >= iso) == (b >= iso) {
                    continue; // no edge that is cut
                }
                let curved = placer.curved::<C>(&straight);
                let cut = curved.unwrap_or(straight);
                let bits = |place: [C; 3]| place.map(|part| part.into().to_bits());
                let one = bits(placer.position(&cut));
                assert_eq!(one, bits(places[n]), "{cut:?}");
                assert_eq!(one, bits(alone[n]), "{cut:?}");
                let normal = placer.normal(&cut);
                assert_eq!(normal.map(f32::to_bits), normals[n].map(f32::to_bits), "{cut:?}");
                seen.placed += 1;
                seen.moved += usize::from(cut.delta != straight.delta);
                seen.curved += usize::from(normal != placer.central_normal(&cut));
            }
        }
    }
    seen
}

#[track_caller]
fn compare<T: Sample>(mut sample: impl FnMut(f64) -> T, [scale, iso]: [f64; 2]) {
    for (noise, placement) in [0.0, 0.1, 1.0]
        .into_iter()
        .flat_map(|noise| [Placement::Cubic, Placement::Quintic].map(|p| (noise, p)))
    {
        let mut value = waves(noise, 5);
        let volume = volume(|n| sample(value(n) * scale));
        let seen = check(&volume, iso, placement);
        assert!(seen.placed > 300 && seen.moved > 100 && seen.curved > 300, "{seen:?}");
    }
}

#[test]
fn vertices_made_sixteen_at_a_time_have_the_bits_of_one_by_one() {
    compare(|value| (value + 128.0) as u8, [40.0, 131.3]);
    compare(|value| value as i8, [40.0, 4.0]);
    compare(|value| (value + 30_000.0) as u16, [9_000.0, 30_777.0]);
    compare(|value| value as i16, [9_000.0, 333.25]);
    compare(|value| (value + 2e9) as u32, [6e8, 2.01e9]);
    compare(|value| value as i32, [6e8, 1e7]);
    compare(|value| value as f32, [1.0, 0.1]);
    compare(|value| value as f32, [1.0, 0.125]);
    compare(|value| value, [1.0, 0.1]);
}

#[test]
fn and_on_lines_of_few_samples() {
    for (length, axis) in (2..=8).flat_map(|length| (0..3).map(move |axis| (length, axis))) {
        let mut dims = [9, 8, 10];
        dims[axis] = length;
        let mut placed = 0;
        for placement in [Placement::Cubic, Placement::Quintic] {
            let (mut value, mut other) = (waves_of(dims, 0.3, 6), waves_of(dims, 0.3, 7));
            let whole = volume_of(dims, |n| (value(n) * 40.0 + 128.0) as u8);
            placed += check(&whole, 131.3, placement).placed;
            placed += check(&volume_of(dims, |n| other(n) as f32), 0.1, placement).placed;
        }
        assert!(placed > 500, "{placed} of {dims:?}");
    }
}

#[test]
fn and_where_samples_tie_are_steps_or_mean_something_else() {
    compare(|value| value.round() as i8, [4.0, 1.0]);
    compare(|value| if value > 0.0 { 200_u8 } else { 0 }, [1.0, 100.0]);
    for scaling in [Scaling::new(-0.37, 12.0), Scaling::new(3e-5, -1.0)] {
        let scaling = scaling.unwrap();
        let mut value = waves(0.1, 8);
        let volume = volume(|n| (value(n) * 9_000.0) as i16).with_scaling(scaling);
        let seen = check(&volume, scaling.value(500.5), Placement::Cubic);
        assert!(seen.moved > 100 && seen.curved > 300, "{seen:?}");
    }
}

#[test]
fn and_beside_samples_that_are_not_finite_or_the_greatest_and_the_least_of_their_type() {
    fn odd<T: Sample>(hole: &[T], sample: fn(f64) -> T, iso: f64) {
        for placement in [Placement::Cubic, Placement::Quintic] {
            let (mut value, mut chance) = (waves(0.1, 3), Chance(9));
            let volume = volume(|n| match (chance.next().abs() * 2000.0) as usize {
                found @ 0..24 => hole[found % hole.len()],
                _ => sample(value(n)),
            });
            let seen = check(&volume, iso, placement);
            assert!(seen.placed > 300 && seen.moved > 50 && seen.curved > 50, "{seen:?}");
        }
    }
    odd(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY], |value| value as f32, 0.1);
    odd(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY], |value| value, 0.1);
    odd(&[f32::MAX, -f32::MAX, f32::MIN_POSITIVE, -0.0], |value| value as f32, 0.1);
    odd(&[f64::MAX, -f64::MAX, f64::MIN_POSITIVE, 5e-324], |value| value, 0.1);
    odd(&[f32::NAN], |value| (value * 1e38) as f32, 1e37);
    odd(&[f32::NAN], |value| (value * 1e38) as f32, 2_f64.powi(123));
    odd(&[f32::NAN], |value| (value * 1e-43) as f32, f32::from_bits(70).into());
    odd(&[f32::NAN], |value| (value * 1e-43) as f32, 1e-43);
    odd(&[f64::NAN], |value| value * 1e300, 1e299);
    odd(&[f64::NAN], |value| value * 1e-300, 1e-301);
    odd(&[u8::MAX, 0], |value| (value * 40.0 + 128.0) as u8, 128.0);
    odd(&[i32::MAX, i32::MIN], |value| (value * 6e8) as i32, 0.5);
    odd(&[u32::MAX, 0], |value| (value * 6e8 + 2e9) as u32, 2e9);
}
