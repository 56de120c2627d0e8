//! What vertices depend on beside samples and edges, and in what type they come out.

use crate::wide::{BATCH, Wide};

/// A type of coordinate in the output: `f32` or `f64`.
pub trait Coordinate: Copy + Default + Send + sealed::Write {
    /// The coordinate nearest to a value.
    fn round(value: f64) -> Self;

    /// How far it is from another one, rounded to f32.
    fn offset_from(self, other: Self) -> f32;

    /// The places themselves, if their coordinates are f32.
    fn as_f32(places: &[[Self; 3]]) -> Option<&[[f32; 3]]>;
}

mod sealed {
    use super::{BATCH, Wide};

    pub trait Write: Sized {
        /// Rounds the places of a batch, which come by axis, and writes them vertex by vertex.
        fn write<W: Wide>(wide: W, places: [W::F64; 3], out: &mut [[Self; 3]; BATCH]);
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

impl sealed::Write for f32 {
    #[inline(always)]
    fn write<W: Wide>(wide: W, [x, y, z]: [W::F64; 3], out: &mut [[Self; 3]; BATCH]) {
        wide.interleave([wide.f64_to_f32(x), wide.f64_to_f32(y), wide.f64_to_f32(z)], out);
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

impl sealed::Write for f64 {
    #[inline(always)]
    fn write<W: Wide>(wide: W, places: [W::F64; 3], out: &mut [[Self; 3]; BATCH]) {
        wide.interleave_f64(places, out);
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

    /// Where crossings so far from the middle of their edges are in world space. The numbers of the lower ends
    /// are along x, y, z.
    #[inline(always)]
    pub(super) fn places<W: Wide>(
        &self,
        wide: W,
        axis: W::U32,
        low: [W::U32; 3],
        delta: W::F64,
    ) -> [W::F64; 3] {
        let Self { columns, origin, first_slice, .. } = self;
        let first = [0.0, 0.0, *first_slice];
        let mut ijk = [delta; 3];
        for along in 0..3 {
            let low = wide.u32_to_f64(low[along]) + wide.f64(first[along]);
            let is_along = wide.equal(axis, wide.u32(along as u32));
            ijk[along] = wide.select_f64(is_along, low + wide.f64(0.5) + delta, low);
        }
        let mut world = ijk;
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
