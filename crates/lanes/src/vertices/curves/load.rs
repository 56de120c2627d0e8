//! The values on the lines of edges, and the differences around their ends, 16 edges at a time.
//!
//! Where all edges of a batch are far enough from the border, what is loaded for differences over two steps is used
//! for lines too: the neighbours of an edge's ends on its line are among those of its ends.

use super::{Crossing, Line, MOST, Precision, beyond::Lacking, singly::Singly};
use crate::{
    Lane,
    vertices::{Kernel, around::Batch},
    wide::{BATCH, Exact, Mask, Task, Wide},
};

/// At both ends of the edges of a batch the differences of the neighbours along x, y, z, as
/// [`Around`](crate::vertices::around::Around) has them.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Differences([[[f32; BATCH]; 3]; 2]);

impl Differences {
    pub(in crate::vertices) const DEFAULT: Self = Self([[[0.0; BATCH]; 3]; 2]);

    #[inline(always)]
    fn store<W: Wide>(&mut self, wide: W, differences: [[W::F32; 3]; 2]) {
        for (to, numbers) in self.0.as_flattened_mut().iter_mut().zip(differences.as_flattened()) {
            wide.store_f32(*numbers, to);
        }
    }

    #[inline(always)]
    pub(in crate::vertices) fn load<W: Wide>(&self, wide: W) -> [[W::F32; 3]; 2] {
        let mut differences = [[wide.f32(0.0); 3]; 2];
        for (numbers, from) in differences.as_flattened_mut().iter_mut().zip(self.0.as_flattened())
        {
            *numbers = wide.load_f32(from);
        }
        differences
    }
}

/// Loads the values of the batches from edge `first` on, and the differences where they are wanted.
pub struct Loading<'l, 'b, 'a, T, C> {
    pub(super) kernel: &'l Kernel<'b, 'a, T>,
    pub(super) first: usize,
    pub(super) pairs: usize,
    pub(super) to: (&'l mut [Line<C>], &'l mut [Crossing]),
    pub(super) differences: Option<&'l mut [Differences]>,
    pub(super) singly: &'l mut Singly<T>,
}

impl<T: Lane, C: Precision> Task for Loading<'_, '_, '_, T, C> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        match self.pairs {
            2 => self.load::<W, 4>(wide),
            _ => self.load::<W, 6>(wide),
        }
    }
}

impl<T: Lane, C: Precision> Loading<'_, '_, '_, T, C> {
    #[inline(always)]
    fn load<W: Wide, const HELD: usize>(mut self, wide: W) {
        let (kernel, (lines, crossings)) = (self.kernel, self.to);
        for (number, (line, crossing)) in lines.iter_mut().zip(crossings).enumerate() {
            let batch = kernel.ends(wide, self.first + number * BATCH);
            if let Some(differences) = &mut self.differences {
                let differences = &mut differences[number];
                if kernel.is_far_in(wide, &batch, HELD / 2) {
                    // SAFETY: asked right above.
                    unsafe {
                        kernel.load_both::<W, C, HELD>(wide, &batch, &mut line.values, differences)
                    };
                    crossing.is_odd = 0;
                    continue;
                }
                differences.store(wide, kernel.around(wide, &batch, true).differences);
            } else if !wide.is_gather_quick() && kernel.is_far_in(wide, &batch, HELD / 2) {
                let Stencil { slice, low, step } = kernel.stencil(wide, &batch);
                let begin = low + step * wide.u32((HELD / 2 - 1).wrapping_neg() as u32);
                self.singly.put(number, slice, [wide.store(begin), wide.store(step)]);
                crossing.is_odd = 0;
                continue;
            }
            crossing.is_odd = kernel.load::<W, C, HELD>(wide, &batch, &mut line.values);
        }
        // SAFETY: batches are put above alone, where they are far in: on their lines there are so many samples, from where
        // stencils begin, and so near that numbers and steps fit, as `is_near` says.
        for (number, samples) in unsafe { self.singly.take::<HELD>(kernel.samples) } {
            for (value, samples) in lines[number].values.iter_mut().zip(samples) {
                let mut exact = [T::Exact::default(); BATCH];
                for (exact, sample) in exact.iter_mut().zip(samples) {
                    *exact = sample.exact();
                }
                let exact = T::Exact::load(wide, &exact);
                C::store(wide, C::above_iso(wide, kernel, exact), value);
            }
        }
    }
}

/// Where the samples on the lines of a batch are.
struct Stencil<W: Wide> {
    /// The number of the first sample of the slice of all lower ends.
    slice: i64,
    /// The numbers of the lower ends from there.
    low: W::U32,
    /// How far apart samples are along the edge.
    step: W::U32,
}

impl<T: Lane> Kernel<'_, '_, T> {
    /// Whether all edges have so many samples to either side of their middle, as many beyond both ends along all axes,
    /// less one, and [near](crate::Samples::is_near).
    #[inline(always)]
    fn is_far_in<W: Wide>(&self, wide: W, batch: &Batch<W>, pairs: usize) -> bool {
        let is_inner = match pairs {
            2 => batch.is_inner,
            _ => self.are_within(wide, [batch.low, batch.high], pairs as u32 - 1).bits(),
        };
        is_inner == u16::MAX && self.samples.is_near(pairs as i64)
    }

    /// Loads the values on lines, and the differences around the ends of their edges.
    ///
    /// # Safety
    ///
    /// The batch must be [far in](Self::is_far_in) for half as many pairs as are held.
    #[inline(always)]
    unsafe fn load_both<W: Wide, C: Precision, const HELD: usize>(
        &self,
        wide: W,
        batch: &Batch<W>,
        values: &mut [[C; BATCH]; MOST],
        differences: &mut Differences,
    ) {
        let Stencil { slice, low, step } = self.stencil(wide, batch);
        let (pairs, back) = (HELD / 2, step * wide.u32(u32::MAX));
        let [_, y, z] = self.samples.strides();
        for (end, at) in [low, low + step].into_iter().enumerate() {
            // SAFETY: both ends have all their neighbours.
            let [below, own, above] = unsafe { wide.along_x(self.samples, slice, at) };
            // The one beyond this end, which is below the lower and above the upper one.
            let mut beyond = [below, above][end];
            let to = &mut differences.0[end];
            wide.store_f32(T::Exact::difference(wide, above, below), &mut to[0]);
            let [own_to, beyond_to] = [pairs - 1 + end, pairs - 2 + 3 * end];
            C::store(wide, C::above_iso(wide, self, own), &mut values[own_to]);
            for (axis, stride) in [(1, y), (2, z)] {
                // SAFETY: as above.
                let sides = unsafe {
                    [
                        wide.near(self.samples, slice - stride, at),
                        wide.near(self.samples, slice + stride, at),
                    ]
                };
                wide.store_f32(T::Exact::difference(wide, sides[1], sides[0]), &mut to[axis]);
                let is_along = wide.equal(batch.axis, wide.u32(axis as u32));
                beyond = T::Exact::select(wide, is_along, sides[end], beyond);
            }
            C::store(wide, C::above_iso(wide, self, beyond), &mut values[beyond_to]);
            if pairs == 3 {
                let outward = [back, step][end];
                // SAFETY: two samples beyond each end there is one, with both neighbours along the other axes, and so
                // many slices away that all are near.
                let farthest = unsafe { wide.near(self.samples, slice, at + outward + outward) };
                let farthest_to = &mut values[[0, HELD - 1][end]];
                C::store(wide, C::above_iso(wide, self, farthest), farthest_to);
            }
        }
    }

    /// Loads the values on lines; the bits of those that cannot be loaded, which have others.
    #[inline(always)]
    fn load<W: Wide, C: Precision, const HELD: usize>(
        &self,
        wide: W,
        batch: &Batch<W>,
        values: &mut [[C; BATCH]; MOST],
    ) -> u16 {
        let pairs = HELD / 2;
        if !self.samples.is_near(pairs as i64) {
            return u16::MAX;
        }
        let Stencil { slice, low, step } = self.stencil(wide, batch);
        // From so many steps before the lower end.
        let mut begin = low + step * wide.u32((pairs - 1).wrapping_neg() as u32);
        // Inner edges have one neighbour on either side.
        let (mut is_odd, mut lacking) = (0, None);
        if batch.is_inner != u16::MAX || pairs > 2 {
            let (along, size) = self.along(wide, batch);
            is_odd = batch.is_outside | wide.less(size, wide.u32(HELD as u32)).bits();
            let found = Lacking::new(wide, pairs as u32, wide.mask(!is_odd), along, size);
            if found.any != 0 {
                begin = found.moved(wide, begin, step);
                // Samples are as many slices farther in as are lacking.
                if !self.samples.is_near(2 * pairs as i64 - 1) {
                    is_odd |= found.any;
                }
                lacking = Some(found);
            }
            is_odd |=
                !self.can_load(wide, slice, [begin, begin + step * wide.u32(HELD as u32 - 1)]);
        }
        let mut numbers = [begin; HELD];
        for n in 1..HELD {
            numbers[n] = numbers[n - 1] + step;
        }
        if is_odd == u16::MAX {
            return u16::MAX;
        }
        if is_odd != 0 {
            // In place of each that cannot be loaded there is one that can.
            let kept = is_odd.trailing_ones() as usize;
            for number in &mut numbers {
                let other = wide.u32(wide.store(*number)[kept]);
                *number = wide.select(wide.mask(is_odd), other, *number);
            }
        }
        let mut samples = [T::Exact::splat(wide, 0.0); HELD];
        for (sample, number) in samples.iter_mut().zip(numbers) {
            // SAFETY: of the edges that are left both ends are samples, and so are the others on their lines: there are as
            // many as are held, or more, and those that would not be are moved in. Four bytes can be read from each
            // on: that was looked at, or all have both neighbours across. The farthest is as many slices away as
            // there are pairs, or twice as many less one where that was asked.
            *sample = unsafe { wide.near(self.samples, slice, number) };
        }
        let Some(lacking) = lacking else {
            for (value, sample) in values.iter_mut().zip(samples) {
                C::store(wide, C::above_iso(wide, self, sample), value);
            }
            return is_odd;
        };
        // Continued in f64, as one by one.
        let mut exact = [[0.0; BATCH]; MOST];
        for (value, sample) in exact.iter_mut().zip(samples) {
            wide.store_f64(self.above_iso(wide, sample), value);
        }
        lacking.put_in::<HELD>(wide, &mut exact);
        for (value, exact) in values[..HELD].iter_mut().zip(&exact) {
            C::store(wide, C::from_f64(wide, wide.load_f64(exact)), value);
        }
        is_odd
    }

    /// Where the samples on the lines of edges are. The lower ends are in the lattice, or any number will do.
    #[inline(always)]
    fn stencil<W: Wide>(&self, wide: W, batch: &Batch<W>) -> Stencil<W> {
        // Numbers fit, as `is_near` says, and wrap to what they are.
        let strides = self.samples.strides();
        let mut all = [wide.u32(0); 3];
        for (step, stride) in all.iter_mut().zip(strides) {
            *step = wide.u32(stride as u32);
        }
        let mut step = all[2];
        for axis in [1, 0] {
            let is_along = wide.equal(batch.axis, wide.u32(axis as u32));
            step = wide.select(is_along, all[axis], step);
        }
        let low = batch.low[0] * all[0] + batch.low[1] * all[1];
        let slice = self.samples.first() + i64::from(self.edges.z()) * strides[2];
        Stencil { slice, low, step }
    }

    /// The places of lower ends along their edges, and how many samples the lattice has there.
    #[inline(always)]
    fn along<W: Wide>(&self, wide: W, batch: &Batch<W>) -> (W::U32, W::U32) {
        let size = self.samples.dims();
        let (mut along, mut sizes) = (batch.low[2], wide.u32(size[2]));
        for axis in [1, 0] {
            let is_along = wide.equal(batch.axis, wide.u32(axis as u32));
            along = wide.select(is_along, batch.low[axis], along);
            sizes = wide.select(is_along, wide.u32(size[axis]), sizes);
        }
        (along, sizes)
    }

    /// The bits of those lines from whose samples, of which the first and the last have these numbers from that of
    /// the slice, four bytes can be read on.
    #[inline(always)]
    fn can_load<W: Wide>(&self, wide: W, slice: i64, ends: [W::U32; 2]) -> u16 {
        let reach = 4_usize.div_ceil(size_of::<T>());
        let end = self.samples.all().len() as i64 - reach as i64 - slice + 1;
        // Compared as numbers without a sign, from the least on.
        let least = i64::from(i32::MIN);
        let end = end.clamp(least, i32::MAX.into()) - least;
        let mut can_load = wide.mask(u16::MAX);
        for number in ends {
            can_load = can_load & wide.less(number + wide.u32(1 << 31), wide.u32(end as u32));
        }
        can_load.bits()
    }
}
