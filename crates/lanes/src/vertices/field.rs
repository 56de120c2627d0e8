//! What vertices depend on beside samples and edges, and in what type they come out.

use super::AHEAD;
use crate::{
    prefetch::prefetch_beyond,
    wide::{BATCH, Wide},
};
use std::ops::{Add, Mul, Sub};

/// A type of coordinate in the output: `f32` or `f64`.
pub trait Coordinate:
    Copy
    + Default
    + Send
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Into<f64>
    + sealed::Room
{
    /// The coordinate nearest to a value.
    fn round(value: f64) -> Self;

    /// How far it is from another one, rounded to f32.
    fn offset_from(self, other: Self) -> f32;

    /// The places themselves, if their coordinates are f32.
    fn as_f32(places: &[[Self; 3]]) -> Option<&[[f32; 3]]>;
}

mod sealed {
    use super::Places;
    use crate::vertices::curves::Precision;

    pub trait Room: Precision {
        /// The room, whatever the type.
        fn places(room: &mut [[Self; 3]]) -> Places<'_>;
    }
}

impl Coordinate for f32 {
    #[inline(always)]
    fn round(value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn offset_from(self, other: Self) -> f32 {
        self - other
    }

    fn as_f32(places: &[[Self; 3]]) -> Option<&[[f32; 3]]> {
        Some(places)
    }
}

impl sealed::Room for f32 {
    #[inline(always)]
    fn places(room: &mut [[Self; 3]]) -> Places<'_> {
        Places::Single(room)
    }
}

impl Coordinate for f64 {
    #[inline(always)]
    fn round(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn offset_from(self, other: Self) -> f32 {
        (self - other) as f32
    }

    fn as_f32(_: &[[Self; 3]]) -> Option<&[[f32; 3]]> {
        None
    }
}

impl sealed::Room for f64 {
    #[inline(always)]
    fn places(room: &mut [[Self; 3]]) -> Places<'_> {
        Places::Double(room)
    }
}

/// Room for places, of either type of coordinate: loops are compiled once for both.
pub enum Places<'a> {
    Single(&'a mut [[f32; 3]]),
    Double(&'a mut [[f64; 3]]),
}

impl Places<'_> {
    /// Rounds the places of a batch, which come by axis, and writes them vertex by vertex, from number `first` on;
    /// those for which there is no room are left out.
    #[inline(always)]
    pub(super) fn write<W: Wide>(&mut self, wide: W, first: usize, [x, y, z]: [W::F64; 3]) {
        match self {
            Self::Single(room) => {
                let places = [wide.f64_to_f32(x), wide.f64_to_f32(y), wide.f64_to_f32(z)];
                let room = &mut room[first..];
                let Some(room) = room.first_chunk_mut() else {
                    let mut all = [[0.0; 3]; BATCH];
                    wide.interleave(places, &mut all);
                    return room.copy_from_slice(&all[..room.len()]);
                };
                prefetch_beyond::<AHEAD, _>(room);
                wide.interleave(places, room);
            }
            Self::Double(room) => {
                let room = &mut room[first..];
                let Some(room) = room.first_chunk_mut() else {
                    let mut all = [[0.0; 3]; BATCH];
                    wide.interleave_f64([x, y, z], &mut all);
                    return room.copy_from_slice(&all[..room.len()]);
                };
                prefetch_beyond::<AHEAD, _>(room);
                wide.interleave_f64([x, y, z], room);
            }
        }
    }
}

/// Everything beside the samples that a vertex depends on.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// The isovalue.
    pub iso: f64,
    /// The value of a stored sample is `stored · slope + intercept`.
    pub slope: f64,
    /// See `slope`.
    pub intercept: f64,
    /// How far from the middle of its edge a vertex may be, in edge lengths.
    pub reach: f64,
    /// Where a step along x, y, z of index space leads.
    pub columns: [[f64; 3]; 3],
    /// The place of the first sample.
    pub origin: [f64; 3],
    /// What turns a gradient in index space into one in world space, by columns.
    pub covectors: [[f64; 3]; 3],
    /// The number of the first slice of the samples in the whole lattice.
    pub first_slice: f64,
}

impl Field {
    /// The place in world space of a point of index space.
    #[inline(always)]
    pub fn world(&self, ijk: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| {
            let along = |axis: usize| self.columns[axis][k] * ijk[axis];
            along(0) + (along(1) + (along(2) + self.origin[k]))
        })
    }

    /// What each coordinate starts from where each axis of index space runs along the one of world space of the
    /// same number. Then [`world`](Self::world) adds to one product with an index this and products with 0, and
    /// is found without those, to the last bit.
    pub(super) fn starts(&self) -> Option<[f64; 3]> {
        let Self { columns, origin, first_slice, .. } = self;
        // No edge that is placed has a negative index, so a product with 0 has the sign of that 0.
        let starts =
            [columns[1][0] + (columns[2][0] + origin[0]), columns[2][1] + origin[1], origin[2]];
        let others = [[1, 0], [2, 0], [2, 1], [0, 1], [0, 2], [1, 2]];
        let are_zero = others.iter().all(|&[axis, k]| columns[axis][k] == 0.0);
        // The last three are added behind the index, where 0 changes −0 and nothing else, and −0 nothing.
        let is_kept = |&[axis, k]: &[usize; 2]| {
            starts[k].to_bits() != (-0.0_f64).to_bits() || columns[axis][k].is_sign_negative()
        };
        let is_short = are_zero && *first_slice >= 0.0 && others[3..].iter().all(is_kept);
        is_short.then_some(starts)
    }

    /// Where crossings so far from the middle of their edges are in world space. The numbers of the lower ends
    /// are along x, y, z; `starts` are [those](Self::starts) of the field.
    #[inline(always)]
    pub(super) fn places<W: Wide>(
        &self,
        wide: W,
        starts: Option<[f64; 3]>,
        axis: W::U32,
        low: [W::U32; 3],
        delta: W::F64,
    ) -> [W::F64; 3] {
        let Self { columns, origin, first_slice, .. } = self;
        let mut ijk = [delta; 3];
        for along in 0..3 {
            let mut low = wide.i32_to_f64(low[along]);
            if along == 2 {
                low = low + wide.f64(*first_slice);
            }
            let is_along = wide.equal(axis, wide.u32(along as u32));
            ijk[along] = wide.select_f64(is_along, low + wide.f64(0.5) + delta, low);
        }
        let mut world = ijk;
        if let Some(starts) = starts {
            for k in 0..3 {
                world[k] = wide.f64(columns[k][k]) * ijk[k] + wide.f64(starts[k]);
            }
            return world;
        }
        for k in 0..3 {
            let z = wide.f64(columns[2][k]) * ijk[2] + wide.f64(origin[k]);
            let y_z = wide.f64(columns[1][k]) * ijk[1] + z;
            world[k] = wide.f64(columns[0][k]) * ijk[0] + y_z;
        }
        world
    }

    /// What turns differences of stored samples into a gradient in world space, but for its length, which
    /// no normal has.
    pub fn directions(&self) -> [[f32; 3]; 3] {
        let parts = self.covectors.as_flattened().iter();
        let greatest = parts.fold(0.0_f64, |most, part| most.max(part.abs()));
        let scale = if self.slope < 0.0 { -greatest } else { greatest };
        self.covectors.map(|column| column.map(|part| (part / scale) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::Field;
    use crate::{
        Edges, Level, Samples,
        vertices::{
            Vertices,
            tests::{Chance, FIELD, edges},
            vertices_at,
        },
    };

    /// A lattice along the axes, whose numbers off the diagonal are 0 and −0.
    fn lattice(sizes: [f64; 3], off: [[f64; 3]; 3], origin: [f64; 3], first_slice: f64) -> Field {
        let mut columns = off;
        for (k, size) in sizes.into_iter().enumerate() {
            columns[k][k] = size;
        }
        Field { columns, origin, first_slice, slope: 1.0, intercept: 0.0, ..FIELD }
    }

    /// Whether a lattice is placed by one index each; all edges are where [`Field::world`] says, to the last bit.
    fn is_short(field: &Field, all_edges: &[Edges]) -> bool {
        let all: Vec<u8> = (0..60).map(|n| ((n % 5 + n / 5 % 4 + n / 20) % 2) as u8).collect();
        let samples = Samples::new(&all, 0, [1, 5, 20], [5, 4, 3]).unwrap();
        for (edges, &level) in
            all_edges.iter().flat_map(|edges| Level::available().iter().map(move |l| (edges, l)))
        {
            let mut positions = vec![[0.0_f64; 3]; edges.len()];
            let out = Vertices { positions: &mut positions, normals: None, odd: &mut Vec::new() };
            vertices_at(level, &samples, field, edges, out);
            for (n, found) in positions.into_iter().enumerate() {
                let (axis, low) = edges.get(n);
                let value = |end: u32| {
                    let at = [0, 1, 2].map(|k| low[k] + if k == axis { end } else { 0 });
                    f64::from(all[(at[0] + 5 * at[1] + 20 * at[2]) as usize]) - field.iso
                };
                let (a, b) = (value(0), value(1));
                let mut ijk = low.map(f64::from);
                ijk[2] += field.first_slice;
                ijk[axis] = ijk[axis] + 0.5 + (a + b) / (a - b) * 0.5;
                let expected = field.world(ijk).map(f64::to_bits);
                assert_eq!(found.map(f64::to_bits), expected, "{level}: {field:?}, {ijk:?}");
            }
        }
        field.starts().is_some()
    }

    #[test]
    fn lattices_along_the_axes_are_placed_as_all_others_whatever_the_sign_of_what_is_0() {
        let mut chance = Chance(7);
        let all_edges = [0, 1].map(|z| {
            let place = |_| (chance.below(3) as usize, [chance.below(4), chance.below(3)]);
            edges(Level::Portable, &(0..50).map(place).collect::<Vec<_>>(), z)
        });
        let is_short = |field: &Field| is_short(field, &all_edges);
        let (mut short, mut count) = (0, 0);
        for signs in 0..1 << 12 {
            let sign = |n: usize| if signs >> n & 1 == 1 { -1.0 } else { 1.0 };
            let off = [[0.0, sign(0), sign(1)], [sign(2), 0.0, sign(3)], [sign(4), sign(5), 0.0]];
            let origin = [sign(6) * 0.0, sign(7) * 0.0, sign(8) * 0.0];
            let sizes = [0.9 * sign(9), 1.7 * sign(10), 0.3 * sign(11)];
            let off = off.map(|column| column.map(|sign| sign * 0.0));
            let first_slice = [0.0, 7.0, -1.0][signs % 3];
            let found = is_short(&lattice(sizes, off, origin, first_slice));
            assert!(!found || first_slice >= 0.0);
            short += usize::from(found);
            count += 1;
        }
        assert!(short > count / 4 && short < count, "{short} of {count}");
        for sizes in [[1.0; 3], [-0.5, -0.5, 2.0], [1e-3, -7.0, 1e5]] {
            let zeros = [[0.0; 3]; 3];
            assert!(is_short(&lattice(sizes, zeros, [-3.25, 1e7, 0.1], 7.0)));
            // An axis that is turned around turns all of its zeros around.
            let turned = sizes.map(|size| 0.0_f64.copysign(size));
            assert!(is_short(&lattice(sizes, [turned; 3], turned, 0.0)));
            let sheared = [[0.0, 0.0, 1e-9], [0.0; 3], [0.0; 3]];
            assert!(!is_short(&lattice(sizes, sheared, [0.0; 3], 0.0)));
        }
        assert_eq!(FIELD.starts(), None);
    }
}
