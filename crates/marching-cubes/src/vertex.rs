//! Where an edge is crossed, and the normal there.
//!
//! With α and β the values at the two ends less the isovalue, linear interpolation crosses the edge at
//! δ = ((α + β) / 2) / (α − β) from its middle, in edge lengths. Seen from the other end the same numbers
//! give the same δ with the other sign, to the last bit, so mirrored volumes give mirrored vertices.
//! Everything is f64 until the position is whole; then it is rounded once.

use isokit_lanes::{Coordinate, Edges, Field, Samples, Vertices, Word, vertices};
use isokit_volume::{Sample, View, differences};

/// The range of a gradient's greatest part within which its square neither overflows nor vanishes.
const TAME: std::ops::Range<f64> = 1e-120..1e120;

/// A cut edge of the lattice.
#[derive(Clone, Copy, Debug)]
struct Cut {
    axis: usize,
    /// The lower end in index space; a guard's index may be −1.
    low: [f64; 3],
    /// The samples at the lower and the upper end; none where a guard is.
    ends: [Option<[usize; 3]>; 2],
    values: [Option<f64>; 2],
    /// The crossing, in edge lengths from the middle of the edge.
    delta: f64,
}

/// What a vertex depends on, beside its edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement<'a, T> {
    view: View<'a, T>,
    samples: Option<Samples<'a, T>>,
    field: Field,
}

impl<'a, T: Sample> Placement<'a, T> {
    /// `margin` is the least distance that a vertex keeps from both ends of its edge, in edge lengths.
    /// `first_slice` is the number of the view's first slice in the volume that the frame is of.
    pub(crate) fn new(view: View<'a, T>, iso: f64, margin: f64, first_slice: f64) -> Self {
        let affine = view.frame().index_to_world;
        let field = Field {
            iso,
            slope: view.scaling().slope(),
            intercept: view.scaling().intercept(),
            reach: 0.5 - margin,
            columns: affine.columns(),
            origin: affine.origin(),
            first_slice,
            covectors: affine.covector_columns(),
        };
        Self { samples: view.samples(), view, field }
    }

    /// Places the vertices of edges. Edges between samples go to the kernel; those to a guard, and those
    /// that the kernel calls odd, are placed one by one.
    pub(crate) fn place<C: Coordinate>(
        &self,
        edges: &Edges,
        positions: &mut [[C; 3]],
        mut normals: Option<&mut [[f32; 3]]>,
        odd: &mut Vec<u32>,
    ) {
        odd.clear();
        match &self.samples {
            Some(samples) => {
                let normals = normals.as_deref_mut();
                let out = Vertices { positions: &mut *positions, normals, odd: &mut *odd };
                vertices(samples, &self.field, edges, out);
            }
            None => odd.extend(0..edges.len() as u32),
        }
        for n in odd.iter().map(|&n| n as usize) {
            let (axis, low) = edges.get(n);
            let cut = self.cut(axis, low);
            positions[n] = self.position(&cut);
            if let Some(normals) = &mut normals {
                normals[n] = self.normal(&cut);
            }
        }
    }

    /// Says that samples around edges of `words`, where bit 0 of word 0 of row 0 is sample `first`, will
    /// soon be asked for.
    #[inline(always)]
    pub(crate) fn expect(&self, first: [u32; 3], words: &[Word]) {
        if let Some(samples) = &self.samples {
            samples.prefetch(first, words);
        }
    }

    /// The cut of the edge along `axis` whose lower end is the sample `low`, or the guard before the
    /// first, whose number is one below 0 and wraps.
    fn cut(&self, axis: usize, low: [u32; 3]) -> Cut {
        // The guard stays beyond every size, and one above it is 0.
        let low = low.map(|i| i as i32 as isize as usize);
        let mut high = low;
        high[axis] = high[axis].wrapping_add(1);
        let size = self.view.dims()[axis];
        let ends = [low, high].map(|ijk| (ijk[axis] < size).then_some(ijk));
        let values = ends.map(|end| end.map(|ijk| self.view.value(ijk)));
        let delta = delta(values, self.field.iso).clamp(-self.field.reach, self.field.reach);
        let mut low = low.map(|i| i as isize as f64);
        low[2] += self.field.first_slice;
        Cut { axis, low, ends, values, delta }
    }

    /// Where the edge along `axis` from `low` is crossed, in edge lengths from there. The ends are numbered
    /// as those of [`Edges`].
    pub(crate) fn crossing(&self, axis: usize, low: [u32; 3]) -> f64 {
        0.5 + self.cut(axis, low).delta
    }

    /// A place in world space, in cell sizes from `low`, which may be a wrapped −1.
    pub(crate) fn position_in_cell<C: Coordinate>(&self, low: [u32; 3], place: [f64; 3]) -> [C; 3] {
        let mut ijk = low.map(|i| f64::from(i as i32));
        ijk[2] += self.field.first_slice;
        self.field.world(std::array::from_fn(|axis| ijk[axis] + place[axis])).map(C::round)
    }

    /// The position of a cut in world space.
    fn position<C: Coordinate>(&self, cut: &Cut) -> [C; 3] {
        let mut ijk = cut.low;
        ijk[cut.axis] = ijk[cut.axis] + 0.5 + cut.delta;
        self.field.world(ijk).map(C::round)
    }

    /// The unit normal at a cut: against the gradient, which is interpolated between the ends.
    ///
    /// Where the samples tell no gradient, at a guard or where all differences cancel, the value is still
    /// known to fall along the edge, and that direction stands in.
    fn normal(&self, cut: &Cut) -> [f32; 3] {
        self.by_differences(cut).unwrap_or_else(|| {
            let mut along = [0.0; 3];
            let falls = cut.values[0].is_some_and(|low| low >= self.field.iso);
            along[cut.axis] = if falls { -1.0 } else { 1.0 };
            // An axis has a direction, since the frame can be inverted.
            self.outward(along).unwrap_or([0.0, 0.0, 1.0])
        })
    }

    /// The normal as the kernel makes it, from differences of samples that are first brought into its
    /// range by a power of two: so a field has the same normals at any scale, to the last bit.
    fn by_differences(&self, cut: &Cut) -> Option<[f32; 3]> {
        let [Some(low), Some(high)] = cut.ends else { return None };
        let share = match cut.values.map(|value| value.is_some_and(f64::is_finite)) {
            [true, false] => 0.0,
            [false, true] => 1.0,
            _ => (0.5 + cut.delta) as f32,
        };
        // Half of the kernel's at most; a power of two is no matter.
        let ends = [low, high].map(|end| differences(&self.view, end));
        let most = ends.as_flattened().iter().fold(0.0_f64, |most, part| most.max(part.abs()));
        let scale = to_unit(most);
        let [low, high] = ends.map(|end| end.map(|part| (part * scale) as f32));
        let mix = |axis: usize| low[axis] * (1.0 - share) + high[axis] * share;
        let (mixed, d) = ([mix(0), mix(1), mix(2)], self.field.directions());
        let along = |k: usize| d[0][k] * mixed[0] + d[1][k] * mixed[1] + d[2][k] * mixed[2];
        let world = [along(0), along(1), along(2)];
        let most = world.iter().fold(0.0_f32, |most, part| most.max(part.abs()));
        if most == 0.0 {
            return None;
        }
        let scale = to_unit(most.into());
        let [x, y, z] = world.map(|part| (f64::from(part) * scale) as f32);
        let outward = -1.0 / (x * x + y * y + z * z).sqrt();
        Some([x * outward, y * outward, z * outward])
    }

    /// The direction in world space against a gradient in index space. None for a gradient of zero.
    pub(crate) fn outward(&self, gradient: [f64; 3]) -> Option<[f32; 3]> {
        let world = self.world_gradient(gradient);
        if TAME.contains(&greatest(world)) {
            return Some(against(world));
        }
        // Divided by its greatest part first, so that no square overflows or vanishes.
        let world = self.world_gradient(gradient.map(|part| part / greatest(gradient)));
        let longest = greatest(world);
        (longest > 0.0).then(|| against(world.map(|part| part / longest)))
    }

    /// The gradient in world space of a gradient in index space.
    fn world_gradient(&self, gradient: [f64; 3]) -> [f64; 3] {
        let columns = &self.field.covectors;
        let along = |k: usize, axis: usize| columns[axis][k] * gradient[axis];
        std::array::from_fn(|k| along(k, 0) + along(k, 1) + along(k, 2))
    }
}

/// The power of two by which a number becomes one from 1 to 2, for any but the greatest and the least.
fn to_unit(number: f64) -> f64 {
    let exponent = (number.to_bits() >> 52 & 0x7FF) as i32 - 1023;
    2.0_f64.powi(-exponent.clamp(-1000, 1000))
}

/// The unit vector against `v`, whose square is neither 0 nor infinite.
fn against(v: [f64; 3]) -> [f32; 3] {
    let outward = -1.0 / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|part| (part * outward) as f32)
}

/// The crossing between two values, in edge lengths from the middle of the edge, from −½ to ½.
///
/// Next to a guard it is at the sample, next to a value that is not finite at the finite one, between two
/// that are not in the middle.
fn delta(values: [Option<f64>; 2], iso: f64) -> f64 {
    match values {
        [Some(low), Some(high)] if low.is_finite() && high.is_finite() => {
            let (a, b) = (low - iso, high - iso);
            // Only f64 values near the greatest overflow; a quarter of them does not.
            let (a, b) = match (a - b).is_finite() {
                true => (a, b),
                false => (low * 0.25 - iso * 0.25, high * 0.25 - iso * 0.25),
            };
            // Halved last: half of the least value there is would be lost.
            (a + b) / (a - b) * 0.5
        }
        [Some(low), Some(high)] if low.is_finite() || high.is_finite() => {
            if low.is_finite() {
                -0.5
            } else {
                0.5
            }
        }
        [Some(_), Some(_)] => 0.0,
        [None, _] => 0.5,
        [_, None] => -0.5,
    }
}

fn greatest(v: [f64; 3]) -> f64 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

#[cfg(test)]
mod tests {
    use super::{Placement, delta, greatest};
    use isokit_geom::{Affine, Frame};
    use isokit_lanes::{Edges, Word};
    use isokit_volume::{Grid, Volume, gradient};
    use proptest::prelude::*;

    fn check(a: f64, b: f64, iso: f64) {
        let (low, high) = if a >= b { (b, a) } else { (a, b) };
        if !(low < iso && high >= iso) {
            return;
        }
        let there = delta([Some(a), Some(b)], iso);
        let back = delta([Some(b), Some(a)], iso);
        assert!(there.abs() <= 0.5, "{a:e}, {b:e}, {iso:e}: {there}");
        assert_eq!(there.to_bits(), (-back).to_bits(), "{a:e}, {b:e}, {iso:e}");
    }

    proptest! {
        #[test]
        fn a_crossing_is_on_its_edge_and_the_same_from_both_ends(
            bits in any::<[u64; 3]>(), near in -3_i64..=3
        ) {
            let [a, b, iso] = bits.map(f64::from_bits);
            let [a32, b32, iso32] = bits.map(|bits| f64::from(f32::from_bits(bits as u32)));
            if a.is_finite() && b.is_finite() && iso.is_finite() {
                check(a, b, a / 2.0 + b / 2.0);
                check(a, b, iso);
                check(a, f64::from_bits(a.to_bits().wrapping_add_signed(near)), a);
            }
            if a32.is_finite() && b32.is_finite() && iso32.is_finite() {
                check(a32, b32, iso32);
                check(a32, b32, (a32 + b32) / 2.0);
            }
        }
    }

    #[test]
    fn the_greatest_and_the_least_values_are_crossed_where_they_should_be() {
        assert_eq!(delta([Some(-f64::MAX), Some(f64::MAX)], 0.0), 0.0);
        let half = f64::from_bits(0x7FE0_0000_0000_0000); // of what overflows
        assert_eq!(delta([Some(half), Some(-half)], -half / 2.0), 0.25);
        let tiny = f64::from_bits(1);
        assert_eq!(delta([Some(0.0), Some(3.0 * tiny)], tiny), -1.0 / 6.0);
        assert_eq!(delta([Some(1.0), Some(3.0)], 3.0), 0.5);
    }

    #[test]
    fn what_is_not_finite_leaves_the_crossing_to_the_other_end() {
        let (inf, nan) = (f64::INFINITY, f64::NAN);
        assert_eq!(delta([Some(1.0), Some(nan)], 0.0), -0.5);
        assert_eq!(delta([Some(inf), Some(-1.0)], 0.0), 0.5);
        assert_eq!(delta([Some(inf), Some(nan)], 0.0), 0.0);
        assert_eq!(delta([Some(inf), None], 0.0), -0.5);
        assert_eq!(delta([None, Some(1.0)], 0.0), 0.5);
    }

    fn plane_normals(affine: Affine, slope: [f64; 3]) {
        // A linear field in world space: its normal is −slope, whatever the frame.
        let frame = Frame { index_to_world: affine, ..Frame::default() };
        let grid = Grid::new([4, 4, 4], frame).unwrap();
        let value = |n: usize| {
            let xyz = affine.point([n % 4, n / 4 % 4, n / 16].map(|i| i as f64));
            (0..3).map(|k| xyz[k] * slope[k]).sum::<f64>()
        };
        let volume = Volume::new(grid, (0..64).map(value).collect::<Vec<f64>>()).unwrap();
        let placement = Placement::new(volume.view(), value(0).midpoint(value(1)), 0.0, 0.0);
        let cut = placement.cut(0, [0, 0, 0]);
        let length = slope.iter().map(|c| c * c).sum::<f64>().sqrt();
        for (found, part) in placement.normal(&cut).into_iter().zip(slope) {
            assert!((f64::from(found) + part / length).abs() < 1e-6, "{found}, {part}");
        }
    }

    #[test]
    fn normals_are_covectors_in_sheared_stretched_and_mirrored_frames() {
        let slope = [1.0, -2.0, 0.5];
        let shear = [[0.5, 0.0, 0.0], [0.2, 0.7, 0.0], [0.1, -0.9, 2.5]];
        plane_normals(Affine::new(shear, [0.0; 3]).unwrap(), slope);
        plane_normals(Affine::axis_aligned([1.0, 3.0, -9.0], [5.0; 3]).unwrap(), slope);
        plane_normals(
            Affine::axis_aligned([1e-12, 1.0, 1e6], [0.0; 3]).unwrap(),
            [1e12, 1.0, 1e-6],
        );
    }

    /// Sixteen steps of f32, for gradients at the ends that cancel no more than half.
    #[test]
    fn normals_made_sixteen_at_a_time_are_right_to_a_few_units_of_their_last_place() {
        let frame = Affine::new([[0.5, 0.1, 0.0], [0.2, 0.7, 0.0], [0.1, -0.9, 2.5]], [0.0; 3]);
        let frame = Frame { index_to_world: frame.unwrap(), ..Frame::default() };
        let grid = Grid::new([20, 20, 20], frame).unwrap();
        let mut state = 9_u64;
        let mut chance = |_| {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            (state >> 40) as f32 / 1e5 - 80.0
        };
        let volume = Volume::new(grid, (0..8000).map(&mut chance).collect::<Vec<f32>>()).unwrap();
        let placement = Placement::new(volume.view(), 0.0, 0.0, 0.0);
        let mut compared = 0;
        for (axis, y) in (0..3).flat_map(|axis| (0..19).map(move |y| (axis, y))) {
            let mut edges = Edges::default();
            edges.begin(9);
            edges.push(&[axis], [0, y], &[Word { cuts: [(1 << 19) - 1; 8], ..Word::default() }]);
            let (mut positions, mut normals) = ([[0_f32; 3]; 19], [[0.0; 3]; 19]);
            placement.place(&edges, &mut positions, Some(&mut normals), &mut vec![]);
            for (n, normal) in normals.into_iter().enumerate() {
                let (axis, low) = edges.get(n);
                let cut = placement.cut(axis, low);
                assert_eq!(placement.normal(&cut), normal, "one by one as all at once");
                let [low, high] = cut.ends.map(|end| gradient(&volume.view(), end.unwrap()));
                let share = 0.5 + cut.delta;
                let mixed = [0, 1, 2].map(|k| low[k] * (1.0 - share) + high[k] * share);
                if greatest(mixed) < 0.5 * greatest(low).max(greatest(high)) {
                    continue;
                }
                compared += 1;
                let exact = placement.outward(mixed).unwrap();
                for (found, exact) in normal.into_iter().zip(exact) {
                    assert!((found - exact).abs() < 16.0 * f32::EPSILON, "{found}, {exact}");
                }
            }
        }
        assert!(compared > 300, "{compared} normals");
    }

    #[test]
    fn next_to_a_sample_without_a_value_the_other_differences_tell_the_normal() {
        let grid = Grid::new([7, 7, 7], Frame::default()).unwrap();
        for hole in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let value = |n: usize| match [n % 7, n / 7 % 7, n / 49] {
                [3, 3, 3] => hole,
                [x, y, z] => 2.0 * x as f32 - y as f32 + 2.0 * z as f32,
            };
            let volume = Volume::new(grid, (0..343).map(value).collect::<Vec<f32>>()).unwrap();
            // Beside the hole, and to it: no vertex there looks along the edge.
            for (axis, low) in [(1, [2, 3, 3]), (0, [3, 4, 3]), (2, [3, 3, 2]), (0, [3, 3, 3])] {
                let placement = Placement::new(volume.view(), 8.5, 0.0, 0.0);
                let normal = placement.normal(&placement.cut(axis, low));
                for (found, part) in normal.into_iter().zip([-2.0, 1.0, -2.0]) {
                    assert!(
                        (found - part / 3.0).abs() < 1e-6,
                        "{hole}, {axis}, {low:?}: {normal:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn where_all_differences_cancel_the_normal_follows_the_edge() {
        let grid = Grid::new([4, 4, 4], Frame::default()).unwrap();
        let checker = |n: usize| if (n + n / 4 + n / 16) % 2 == 1 { -1.0 } else { 1.0 };
        let volume = Volume::new(grid, (0..64).map(checker).collect::<Vec<f32>>()).unwrap();
        let placement = Placement::new(volume.view(), 0.0, 0.0, 0.0);
        assert_eq!(placement.normal(&placement.cut(1, [1, 1, 1])), [0.0, -1.0, 0.0]);
        assert_eq!(placement.normal(&placement.cut(1, [2, 1, 1])), [0.0, 1.0, 0.0]);
    }
}
