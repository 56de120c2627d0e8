//! What is around the edges of a batch: samples at their ends, and differences of those beside them.

use super::Kernel;
use crate::{
    Lane,
    wide::{BATCH, Exact, Mask, Wide},
};

/// The edges of a batch: the places of both ends along x, y, z, and a bit each for what is true of them.
#[derive(Clone, Copy)]
pub(super) struct Batch<W: Wide> {
    pub(super) axis: W::U32,
    pub(super) low: [W::U32; 3],
    pub(super) high: [W::U32; 3],
    /// The lower end is not a sample, or the upper one.
    pub(super) is_outside: u16,
    /// Both ends have both neighbours along every axis.
    pub(super) is_inner: u16,
    /// There is an edge: the last batch may have fewer than it has numbers.
    pub(super) is_own: u16,
}

impl<W: Wide> Batch<W> {
    /// The same, but each edge whose bit is not set has axis and lower end of one whose bit is, if there is
    /// any. The upper ends stay as they were.
    #[inline(always)]
    fn keeping(&self, wide: W, bits: u16) -> Self {
        let mut batch = *self;
        if bits != 0 && bits != u16::MAX {
            let kept = bits.trailing_zeros() as usize;
            let [x, y, _] = &mut batch.low;
            for numbers in [&mut batch.axis, x, y] {
                let other = wide.u32(wide.store(*numbers)[kept]);
                *numbers = wide.select(wide.mask(bits), *numbers, other);
            }
        }
        batch
    }
}

/// The samples at both ends of each edge, and the differences of their neighbours along x, y, z: those
/// two steps apart, and at a border twice those one step apart. Zeros where none are wanted.
pub(super) struct Around<W: Wide, E: Exact> {
    pub(super) ends: [E::Of<W>; 2],
    pub(super) differences: [[W::F32; 3]; 2],
}

impl<T: Lane> Kernel<'_, '_, T> {
    /// Both ends of the edges of a batch.
    #[inline(always)]
    pub(super) fn ends<W: Wide>(&self, wide: W, first: usize) -> Batch<W> {
        let [axis, x, y] = self.edges.batch(first);
        let (axis, low) = (wide.load(axis), [wide.load(x), wide.load(y), wide.u32(self.edges.z())]);
        let (zero, one) = (wide.u32(0), wide.u32(1));
        let mut high = low;
        for along in 0..3 {
            let is_along = wide.equal(axis, wide.u32(along as u32));
            high[along] = low[along] + wide.select(is_along, one, zero);
        }
        let is_inner = self.are_within(wide, [low, high], 1).bits();
        let is_outside = match is_inner {
            u16::MAX => 0,
            _ => !self.are_within(wide, [low, high], 0).bits(),
        };
        let is_own = u16::MAX >> (BATCH - BATCH.min(self.edges.len() - first));
        Batch { axis, low, high, is_outside, is_inner, is_own }
    }

    /// Those edges of which both ends are so far from the border, or farther.
    #[inline(always)]
    pub(super) fn are_within<W: Wide>(
        &self,
        wide: W,
        ends: [[W::U32; 3]; 2],
        margin: u32,
    ) -> W::Mask {
        let (mut are_within, less) = (wide.mask(u16::MAX), wide.u32(margin.wrapping_neg()));
        for along in 0..3 {
            // No size exceeds 2³¹ − 1, so a wrapped −1 is beyond all of them, and −4 too.
            let within = wide.u32(self.samples.dims()[along].saturating_sub(2 * margin));
            for end in ends {
                are_within = are_within & wide.less(end[along] + less, within);
            }
        }
        are_within
    }

    /// What is around the edges of a batch. Of one that lies outside it is anything.
    #[inline(always)]
    pub(super) fn around<W: Wide>(
        &self,
        wide: W,
        batch: &Batch<W>,
        with_differences: bool,
    ) -> Around<W, T::Exact> {
        let is_inner = if self.samples.is_near(1) { batch.is_inner } else { 0 };
        let mut around = match is_inner {
            0 => Around {
                ends: [T::Exact::splat(wide, 0.0); 2],
                differences: [[wide.f32(0.0); 3]; 2],
            },
            // SAFETY: those that are kept are inner ones, and samples are near, asked above.
            _ => unsafe { self.inner(wide, &batch.keeping(wide, is_inner), with_differences) },
        };
        let others = !is_inner & !batch.is_outside & batch.is_own;
        if others != 0 {
            self.put_in(wide, batch, others, with_differences, &mut around);
        }
        around
    }

    /// What is around edges that are all inner ones.
    ///
    /// # Safety
    ///
    /// They must be, and [`Samples::is_near`](crate::Samples) must hold for one slice.
    #[inline(always)]
    unsafe fn inner<W: Wide>(
        &self,
        wide: W,
        batch: &Batch<W>,
        with_differences: bool,
    ) -> Around<W, T::Exact> {
        let strides = self.samples.strides();
        // Numbers in a slice fit, as `is_near` says.
        let steps = [wide.u32(strides[0] as u32), wide.u32(strides[1] as u32)];
        let low = batch.low[0] * steps[0] + batch.low[1] * steps[1];
        let mut step = wide.u32(strides[2] as u32);
        step = wide.select(wide.equal(batch.axis, wide.u32(1)), steps[1], step);
        step = wide.select(wide.equal(batch.axis, wide.u32(0)), steps[0], step);
        let high = low + step;
        let slice = self.samples.first() + i64::from(self.edges.z()) * strides[2];
        // SAFETY: both ends of every edge are samples, and so are their neighbours along every axis.
        unsafe {
            if with_differences {
                let low = self.with_differences(wide, slice, low);
                let high = self.with_differences(wide, slice, high);
                return Around { ends: [low.0, high.0], differences: [low.1, high.1] };
            }
            let ends = [wide.near(self.samples, slice, low), wide.near(self.samples, slice, high)];
            Around { ends, differences: [[wide.f32(0.0); 3]; 2] }
        }
    }

    /// Samples, and the differences between their neighbours along x, y, z.
    ///
    /// # Safety
    ///
    /// Each sample must have them, and [`Samples::is_near`](crate::Samples) must hold for one slice.
    #[inline(always)]
    unsafe fn with_differences<W: Wide>(
        &self,
        wide: W,
        from: i64,
        at: W::U32,
    ) -> (<T::Exact as Exact>::Of<W>, [W::F32; 3]) {
        let [_, y, z] = self.samples.strides();
        // SAFETY: the caller says so.
        unsafe {
            let [below, own, above] = wide.along_x(self.samples, from, at);
            let along_x = T::Exact::difference(wide, above, below);
            let [along_y, along_z] =
                [self.difference(wide, from, y, at), self.difference(wide, from, z, at)];
            (own, [along_x, along_y, along_z])
        }
    }

    /// The differences between the neighbours of samples that are so far from them.
    ///
    /// # Safety
    ///
    /// Each sample must have all its neighbours, and [`Samples::is_near`](crate::Samples) must hold for one
    /// slice.
    #[inline(always)]
    unsafe fn difference<W: Wide>(&self, wide: W, from: i64, stride: i64, at: W::U32) -> W::F32 {
        // SAFETY: the caller says so.
        let [above, below] = unsafe {
            [wide.near(self.samples, from + stride, at), wide.near(self.samples, from - stride, at)]
        };
        T::Exact::difference(wide, above, below)
    }

    /// Puts in what is around some edges, one by one. None lies outside.
    #[inline(always)]
    fn put_in<W: Wide>(
        &self,
        wide: W,
        batch: &Batch<W>,
        edges: u16,
        with_differences: bool,
        around: &mut Around<W, T::Exact>,
    ) {
        let mut samples = [[T::Exact::default(); BATCH]; 2];
        let mut differences = [[[0.0; BATCH]; 3]; 2];
        let mut places = [[[0; BATCH]; 3]; 2];
        for end in 0..2 {
            T::Exact::store(wide, around.ends[end], &mut samples[end]);
            for (to, numbers) in places[end].iter_mut().zip([batch.low, batch.high][end]) {
                *to = wide.store(numbers);
            }
            if with_differences {
                for (to, numbers) in differences[end].iter_mut().zip(around.differences[end]) {
                    wide.store_f32(numbers, to);
                }
            }
        }
        let mut left = edges;
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            for end in 0..2 {
                let [x, y, z] = &places[end];
                let place = [x[n], y[n], z[n]];
                samples[end][n] = self.sample(place);
                for along in 0..if with_differences { 3 } else { 0 } {
                    let (mut above, mut below) = (place, place);
                    above[along] = (place[along] + 1).min(self.samples.dims()[along] - 1);
                    below[along] = place[along].saturating_sub(1);
                    let scale = if above[along] - below[along] < 2 { 2.0 } else { 1.0 };
                    // A difference of two f32 that is rounded to f64 first comes out as if it were not: f64
                    // has more than twice the digits, and two (Figueroa 1995), and where an f32 would be
                    // denormal the difference is exact.
                    let difference: f64 = self.sample(above).into() - self.sample(below).into();
                    differences[end][along][n] = difference as f32 * scale;
                }
            }
        }
        for end in 0..2 {
            around.ends[end] = T::Exact::load(wide, &samples[end]);
            if with_differences {
                for (to, list) in around.differences[end].iter_mut().zip(&differences[end]) {
                    *to = wide.load_f32(list);
                }
            }
        }
    }

    #[inline(always)]
    fn sample(&self, place: [u32; 3]) -> T::Exact {
        let (dims, strides) = (self.samples.dims(), self.samples.strides());
        debug_assert!(place.iter().zip(dims).all(|(&place, size)| place < size), "{place:?}");
        let along = |axis: usize| i64::from(place[axis]) * strides[axis];
        let number = self.samples.first() + along(0) + along(1) + along(2);
        // SAFETY: `place` is a lattice point, whose sample lies in the slice.
        unsafe { *self.samples.all().get_unchecked(number as usize) }.exact()
    }
}
