//! The eight types a sample may have.

use crate::Dtype;
use bytemuck::Pod;
use isokit_lanes::Lane;
use std::{
    fmt::{Debug, Display},
    str::FromStr,
};

/// A type of sample: `u8 i8 u16 i16 u32 i32 f32 f64`, and no other.
pub trait Sample:
    Lane + Pod + Debug + Display + FromStr + Send + Sync + 'static + sealed::Sealed
{
    /// The same type, as a value.
    const DTYPE: Dtype;

    /// The same number; exact for all eight types.
    fn to_f64(self) -> f64;

    /// The sample with its bytes in the opposite order.
    fn swap_bytes(self) -> Self;

    /// Where the sample stands among all samples of its type, in order of value: −∞ or the least
    /// integer is 0. NaN has no place of meaning.
    fn rank(self) -> u64;

    /// The sample at a place, up to that of +∞ or the greatest integer.
    fn at_rank(rank: u64) -> Self;

    /// The place of the greatest sample, +∞ where there is one.
    const LAST_RANK: u64;
}

mod sealed {
    pub trait Sealed {}
}

macro_rules! integer_sample {
    ($($t:ident $dtype:ident),*) => {$(
        impl sealed::Sealed for $t {}

        impl Sample for $t {
            const DTYPE: Dtype = Dtype::$dtype;
            const LAST_RANK: u64 = ($t::MAX as i64 - $t::MIN as i64) as u64;

            #[inline(always)]
            fn to_f64(self) -> f64 {
                self.into()
            }

            #[inline(always)]
            fn swap_bytes(self) -> Self {
                $t::swap_bytes(self)
            }

            fn rank(self) -> u64 {
                (self as i64 - $t::MIN as i64) as u64
            }

            fn at_rank(rank: u64) -> Self {
                (rank as i64 + $t::MIN as i64) as $t
            }
        }
    )*};
}

integer_sample!(u8 U8, i8 I8, u16 U16, i16 I16, u32 U32, i32 I32);

macro_rules! float_sample {
    ($($t:ident $bits:ident $dtype:ident),*) => {$(
        impl sealed::Sealed for $t {}

        impl Sample for $t {
            const DTYPE: Dtype = Dtype::$dtype;
            // From −∞ up to −0, then from +0 up to +∞.
            const LAST_RANK: u64 = 2 * $t::INFINITY.to_bits() as u64 + 1;

            #[inline(always)]
            fn to_f64(self) -> f64 {
                self.into()
            }

            #[inline(always)]
            fn swap_bytes(self) -> Self {
                $t::from_bits(self.to_bits().swap_bytes())
            }

            fn rank(self) -> u64 {
                let infinity = u64::from($t::INFINITY.to_bits());
                let magnitude = u64::from(self.abs().to_bits());
                match self.is_sign_negative() {
                    true => infinity - magnitude.min(infinity),
                    false => infinity + 1 + magnitude.min(infinity),
                }
            }

            fn at_rank(rank: u64) -> Self {
                let infinity = u64::from($t::INFINITY.to_bits());
                match rank.checked_sub(infinity + 1) {
                    Some(magnitude) => $t::from_bits(magnitude as $bits),
                    None => -$t::from_bits((infinity - rank) as $bits),
                }
            }
        }
    )*};
}

float_sample!(f32 u32 F32, f64 u64 F64);

#[cfg(test)]
mod tests {
    use super::Sample;

    fn ranks_are_in_order_of_value<T: Sample>(samples: &[T]) {
        for pair in samples.windows(2) {
            assert!(pair[0].rank() < pair[1].rank(), "{:?}", pair);
        }
        for &sample in samples {
            assert_eq!(T::at_rank(sample.rank()), sample);
        }
        assert_eq!(samples[0].rank(), 0, "the least sample comes first");
        assert_eq!(samples[samples.len() - 1].rank(), T::LAST_RANK, "the greatest comes last");
    }

    #[test]
    fn a_rank_orders_samples_and_names_them() {
        ranks_are_in_order_of_value(&[0_u8, 1, 255]);
        ranks_are_in_order_of_value(&[i32::MIN, -1, 0, 1, i32::MAX]);
        let (inf, tiny) = (f32::INFINITY, f32::from_bits(1));
        ranks_are_in_order_of_value(&[-inf, f32::MIN, -1.0, -tiny, -0.0, 0.0, tiny, 1.0, inf]);
        ranks_are_in_order_of_value(&[-f64::INFINITY, -1.0, 0.0, f64::INFINITY]);
    }
}
