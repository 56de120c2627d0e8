//! The least and the greatest sample of blocks, and on which side of a threshold that puts them.
//!
//! The loop is written once and compiled again with wider registers allowed, but for floats with AVX2. It keeps 64
//! columns side by side, so that no step waits for the one before; they are put together only at the end of a block.

use crate::{Lane, Level, Threshold, WORD, prefetch::prefetch_ahead, words};
use std::ops::Range;

#[cfg(target_arch = "x86_64")]
mod wide;

/// The least and the greatest of some samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent<T> {
    /// The least sample. Above `greatest` if there is none but NaN.
    pub least: T,
    /// The greatest sample.
    pub greatest: T,
    /// Whether one is NaN.
    pub has_nan: bool,
}

/// Where all of some samples are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// None is inside.
    Outside,
    /// All are inside.
    Inside,
    /// They differ.
    Both,
}

impl<T: Lane> Extent<T> {
    /// That of no samples.
    pub const EMPTY: Self = Self { least: T::ENDS[1], greatest: T::ENDS[0], has_nan: false };

    /// That of these samples and others.
    #[inline(always)]
    pub fn with(self, other: Self) -> Self {
        Self {
            least: if other.least < self.least { other.least } else { self.least },
            greatest: if other.greatest > self.greatest { other.greatest } else { self.greatest },
            has_nan: self.has_nan | other.has_nan,
        }
    }

    /// Least and greatest; `None` if there are none but NaN.
    pub fn range(self) -> Option<[T; 2]> {
        (self.least <= self.greatest).then_some([self.least, self.greatest])
    }

    /// On which side of a threshold the samples are. Exactly that: what lies between least and greatest
    /// cannot be elsewhere, and NaN is outside.
    pub fn side(self, threshold: Threshold<T>) -> Side {
        let Some(range) = self.range() else { return Side::Outside };
        match range.map(|end| threshold.is_inside(end)) {
            [false, false] => Side::Outside,
            [true, true] if !self.has_nan => Side::Inside,
            _ => Side::Both,
        }
    }
}

/// What is known of 64 columns of samples.
#[derive(Clone, Copy, Debug)]
pub struct Columns<T> {
    least: [T; WORD],
    greatest: [T; WORD],
    has_nan: bool,
    first_has_nan: bool,
}

impl<T: Lane> Columns<T> {
    /// Columns without samples.
    pub const EMPTY: Self = Self {
        least: [T::ENDS[1]; WORD],
        greatest: [T::ENDS[0]; WORD],
        has_nan: false,
        first_has_nan: false,
    };

    /// All columns together.
    pub fn extent(&self) -> Extent<T> {
        let (mut least, mut greatest) = (self.least, self.greatest);
        let mut half = WORD / 2;
        while half > 0 {
            for i in 0..half {
                let (a, b) = (least[i], least[i + half]);
                least[i] = if b < a { b } else { a };
                let (a, b) = (greatest[i], greatest[i + half]);
                greatest[i] = if b > a { b } else { a };
            }
            half /= 2;
        }
        Extent { least: least[0], greatest: greatest[0], has_nan: self.has_nan }
    }

    /// Some columns together; whether one has NaN is told of all.
    ///
    /// # Panics
    ///
    /// If there are not so many.
    #[inline]
    pub fn some(&self, columns: Range<usize>) -> Extent<T> {
        let pairs = self.least[columns.clone()].iter().zip(&self.greatest[columns]);
        let extents = pairs.map(|(&least, &greatest)| Extent { least, greatest, has_nan: false });
        let all = extents.fold(Extent::EMPTY, Extent::with);
        Extent { has_nan: self.has_nan, ..all }
    }

    /// The first column alone.
    pub fn first(&self) -> Extent<T> {
        Extent { least: self.least[0], greatest: self.greatest[0], has_nan: self.first_has_nan }
    }

    #[inline(always)]
    fn take(&mut self, samples: &[T; WORD]) {
        // No branch in the loops, so that they become vector code; NaN compares false and drops out.
        let mut has_nan = false;
        for (i, &sample) in samples.iter().enumerate() {
            let (least, greatest) = (self.least[i], self.greatest[i]);
            self.least[i] = if sample < least { sample } else { least };
            self.greatest[i] = if sample > greatest { sample } else { greatest };
            has_nan |= is_nan(sample);
        }
        self.has_nan |= has_nan;
        self.first_has_nan |= is_nan(samples[0]);
    }
}

#[inline(always)]
fn is_nan<T: PartialOrd>(sample: T) -> bool {
    sample.partial_cmp(&sample).is_none()
}

/// Adds a row of samples to its columns, 64 to each of `columns`.
///
/// # Panics
///
/// If there are not [`words`]`(row.len())` of them.
pub fn add_row<T: Lane>(row: &[T], columns: &mut [Columns<T>]) {
    add_row_at(Level::current(), row, columns);
}

fn add_row_at<T: Lane>(level: Level, row: &[T], columns: &mut [Columns<T>]) {
    assert_eq!(columns.len(), words(row.len()), "64 columns each");
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { wide::add_row_avx512(row, columns) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { wide::add_row_avx2(row, columns) }
        }
        _ => add_row_plain::<T, 0>(row, columns),
    }
}

/// The loop of the lowest level, which the compiler makes as wide as it may, and asks for what lies so many bytes
/// ahead, if that is not 0.
#[inline(always)]
fn add_row_plain<T: Lane, const AHEAD: usize>(row: &[T], columns: &mut [Columns<T>]) {
    let (whole, rest) = row.as_chunks::<WORD>();
    for (samples, columns) in whole.iter().zip(&mut *columns) {
        if AHEAD > 0 {
            prefetch_ahead::<AHEAD, _>(samples);
        }
        columns.take(samples);
    }
    if let (Some(samples), Some(columns)) = (padded(rest), columns.last_mut()) {
        columns.take(&samples);
    }
}

/// The samples behind the last whole columns, if there are some, and the first of them once more in place of those that
/// are not there.
#[inline(always)]
fn padded<T: Lane>(rest: &[T]) -> Option<[T; WORD]> {
    let mut padded = [*rest.first()?; WORD];
    padded[..rest.len()].copy_from_slice(rest);
    Some(padded)
}

#[cfg(test)]
mod tests {
    use super::{Columns, Extent, Side, add_row_at};
    use crate::{Lane, Level, Threshold, words};
    use std::{fmt::Debug, slice};

    /// The definition, sample by sample.
    fn of<T: Lane>(samples: impl Iterator<Item = T>) -> Extent<T> {
        let one = |sample: T| match sample.partial_cmp(&sample) {
            Some(_) => Extent { least: sample, greatest: sample, has_nan: false },
            None => Extent { has_nan: true, ..Extent::EMPTY },
        };
        samples.map(one).fold(Extent::EMPTY, Extent::with)
    }

    fn bits<T: Lane>(extent: Extent<T>) -> [u64; 2] {
        [extent.least, extent.greatest].map(|end| end.into().to_bits())
    }

    fn check<T: Lane + Debug>(bounds: &[T], sample: fn(u64) -> T) {
        let mut state = 3_u64;
        let mut next = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
            sample(state >> 33)
        };
        for length in 1..=200 {
            let rows: Vec<Vec<T>> = (0..3).map(|_| (0..length).map(|_| next()).collect()).collect();
            for &level in Level::available() {
                let mut columns = vec![Columns::EMPTY; words(length)];
                rows.iter().for_each(|row| add_row_at(level, row, &mut columns));
                for (w, columns) in columns.iter().enumerate() {
                    let block = |row: &Vec<T>| row[64 * w..length.min(64 * w + 64)].to_vec();
                    let expected = of(rows.iter().flat_map(block));
                    assert_eq!(columns.extent(), expected, "{level}, {length} samples");
                    let mut plain = Columns::EMPTY;
                    rows.iter().for_each(|row| {
                        add_row_at(Level::Portable, &block(row), slice::from_mut(&mut plain));
                    });
                    assert_eq!(bits(columns.extent()), bits(plain.extent()), "{level}: which zero");
                    assert_eq!(columns.first(), of(rows.iter().map(|row| row[64 * w])));
                    for &bound in bounds {
                        for threshold in [Threshold::AtLeast(bound), Threshold::AtMost(bound)] {
                            let all: Vec<T> = rows.iter().flat_map(block).collect();
                            let inside = all.iter().filter(|&&s| threshold.is_inside(s)).count();
                            let side = match inside {
                                0 => Side::Outside,
                                n if n == all.len() => Side::Inside,
                                _ => Side::Both,
                            };
                            assert_eq!(expected.side(threshold), side, "{threshold:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn every_level_agrees_with_the_definition() {
        check(&[0_u8, 3, 4, 255], |r| if r.is_multiple_of(40) { 255 } else { (r % 3) as u8 + 3 });
        check(&[i8::MIN, 0, i8::MAX], |r| r as i8);
        check(&[0_u16, 0x8000], |r| r as u16);
        check(&[-1_i16, 5, 6], |r| (r % 2) as i16 + 5);
        check(&[0_u32, u32::MAX], |r| r as u32);
        check(&[i32::MIN, 0], |r| r as i32);
        check(&[0.0_f32, 2.0], |r| [f32::NAN, 1.0, 2.0, f32::INFINITY][r as usize % 4]);
        check(&[0.0, -0.0, 1.0], |r| if r.is_multiple_of(50) { f64::NAN } else { (r % 2) as f64 });
        check(&[f64::INFINITY], |_| f64::INFINITY);
        check(&[0.0_f32], |r| [0.0, -0.0, f32::NAN][r as usize % 3]);
        check(&[0.0_f64], |r| [0.0, -0.0, f64::NAN][r as usize % 3]);
    }

    #[test]
    fn nan_alone_is_outside_of_all_and_has_no_range() {
        let nan = of([f32::NAN; 3].into_iter());
        assert_eq!((nan.range(), nan.has_nan), (None, true));
        assert_eq!(nan.side(Threshold::AtLeast(f32::NEG_INFINITY)), Side::Outside);
    }

    #[test]
    fn one_nan_among_what_is_inside_makes_a_difference() {
        let some = of([1.0, f32::NAN, 2.0].into_iter());
        assert_eq!(some.side(Threshold::AtLeast(1.0)), Side::Both);
        assert_eq!(some.side(Threshold::AtLeast(2.5)), Side::Outside);
        assert_eq!(some.side(Threshold::Never), Side::Outside);
    }
}
