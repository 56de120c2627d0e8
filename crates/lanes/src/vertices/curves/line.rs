//! What is known of the lines of a batch of edges, in the type of the coordinates that are made of it.
//!
//! Places are no better than the type that they are rounded to. So for f32 the values on lines are rounded to it, and roots
//! are found in it, twice as many numbers at a time; `vertex/curve/short.rs` of `marching-cubes` says how well. For f64 a
//! root that was found in f32 is corrected.

use super::{Loading, MOST};
use crate::{
    Lane, Level,
    vertices::{
        Kernel,
        roots::{Roots, Search},
    },
    wide::{BATCH, Exact, Wide, run_at},
};

/// The samples on the line of each edge, less the isovalue, as many as the curve goes through.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Line<C> {
    pub(in crate::vertices) values: [[C; BATCH]; MOST],
}

impl<C: Precision> Line<C> {
    pub(super) const DEFAULT: Self = Self { values: [[C::ZERO; BATCH]; MOST] };
}

/// Where the edges of a batch are crossed.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Crossing {
    /// In edge lengths from their middles.
    pub(in crate::vertices) delta: [f64; BATCH],
    /// Which are odd.
    pub(in crate::vertices) is_odd: u16,
}

impl Crossing {
    pub(super) const DEFAULT: Self = Self { delta: [0.0; BATCH], is_odd: 0 };
}

/// A type that values on lines are held in. What differs by it is here, and compiled here, not anew wherever edges are placed.
pub trait Precision: Exact {
    const ZERO: Self;

    /// Does the task with the instructions of a level.
    fn load_lines<T: Lane>(level: Level, loading: Loading<'_, '_, '_, T, Self>);

    /// Does the task with the instructions of a level.
    fn find_roots(level: Level, roots: Roots<'_, Self>);

    /// Ends searches that have come near.
    fn finish<W: Wide, const PAIRS: usize>(
        wide: W,
        held: (&[Line<Self>], &mut [Search]),
        crossings: &mut [Crossing],
    );

    /// Values less the isovalue, rounded to the nearest.
    fn above_iso<W: Wide, T: Lane>(
        wide: W,
        kernel: &Kernel<'_, '_, T>,
        samples: <T::Exact as Exact>::Of<W>,
    ) -> Self::Of<W>;
}

impl Precision for f32 {
    const ZERO: Self = 0.0;

    fn load_lines<T: Lane>(level: Level, loading: Loading<'_, '_, '_, T, Self>) {
        T::load_rounded(level, loading);
    }

    fn find_roots(level: Level, roots: Roots<'_, Self>) {
        run_at(level, roots);
    }

    #[inline(always)]
    fn finish<W: Wide, const PAIRS: usize>(
        wide: W,
        (_, searches): (&[Line<Self>], &mut [Search]),
        crossings: &mut [Crossing],
    ) {
        for (search, crossing) in searches.iter().zip(crossings) {
            search.step_to::<W, PAIRS>(wide, crossing);
        }
    }

    #[inline(always)]
    fn above_iso<W: Wide, T: Lane>(
        wide: W,
        kernel: &Kernel<'_, '_, T>,
        samples: <T::Exact as Exact>::Of<W>,
    ) -> W::F32 {
        match kernel.narrow_iso {
            Some(iso) => T::Exact::to_f32(wide, samples) - wide.f32(iso),
            None => wide.f64_to_f32(kernel.above_iso(wide, samples)),
        }
    }
}

impl Precision for f64 {
    const ZERO: Self = 0.0;

    fn load_lines<T: Lane>(level: Level, loading: Loading<'_, '_, '_, T, Self>) {
        T::load(level, loading);
    }

    fn find_roots(level: Level, roots: Roots<'_, Self>) {
        run_at(level, roots);
    }

    #[inline(always)]
    fn finish<W: Wide, const PAIRS: usize>(
        wide: W,
        (lines, searches): (&[Line<Self>], &mut [Search]),
        crossings: &mut [Crossing],
    ) {
        for search in &mut *searches {
            search.last_step::<W, PAIRS>(wide);
        }
        for ((line, search), crossing) in lines.iter().zip(searches).zip(crossings) {
            search.correct::<W, PAIRS>(wide, line, crossing);
        }
    }

    #[inline(always)]
    fn above_iso<W: Wide, T: Lane>(
        wide: W,
        kernel: &Kernel<'_, '_, T>,
        samples: <T::Exact as Exact>::Of<W>,
    ) -> W::F64 {
        kernel.above_iso(wide, samples)
    }
}
