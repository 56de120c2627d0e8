//! A volume whose sample type is known only at run time, and the one macro that asks.

use crate::{Dtype, Grid, Scaling, Volume};
use isokit_geom::Frame;

/// A [`Volume`] of any of the eight types. [`for_any!`](crate::for_any) opens it.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "each name is the type it holds")]
pub enum AnyVolume {
    U8(Volume<u8>),
    I8(Volume<i8>),
    U16(Volume<u16>),
    I16(Volume<i16>),
    U32(Volume<u32>),
    I32(Volume<i32>),
    F32(Volume<f32>),
    F64(Volume<f64>),
}

/// Runs one expression on the volume inside an [`AnyVolume`], whatever its type.
///
/// ```
/// # use isokit_volume::*;
/// # let grid = Grid::new([2, 1, 1], Default::default()).unwrap();
/// let any = AnyVolume::from(Volume::new(grid, vec![3_i16, 4]).unwrap());
/// let sum = for_any!(&any, volume => volume.samples().iter().map(|s| s.to_f64()).sum::<f64>());
/// assert_eq!(sum, 7.0);
/// ```
#[macro_export]
macro_rules! for_any {
    ($any:expr, $volume:pat => $body:expr) => {
        match $any {
            $crate::AnyVolume::U8($volume) => $body,
            $crate::AnyVolume::I8($volume) => $body,
            $crate::AnyVolume::U16($volume) => $body,
            $crate::AnyVolume::I16($volume) => $body,
            $crate::AnyVolume::U32($volume) => $body,
            $crate::AnyVolume::I32($volume) => $body,
            $crate::AnyVolume::F32($volume) => $body,
            $crate::AnyVolume::F64($volume) => $body,
        }
    };
}

/// Runs one expression with `$T` standing for the type that a [`Dtype`](crate::Dtype) names.
///
/// ```
/// # use isokit_volume::*;
/// let bytes = for_dtype!(Dtype::F64, T => size_of::<T>());
/// assert_eq!(bytes, 8);
/// ```
#[macro_export]
macro_rules! for_dtype {
    ($dtype:expr, $T:ident => $body:expr) => {
        match $dtype {
            $crate::Dtype::U8 => {
                type $T = u8;
                $body
            }
            $crate::Dtype::I8 => {
                type $T = i8;
                $body
            }
            $crate::Dtype::U16 => {
                type $T = u16;
                $body
            }
            $crate::Dtype::I16 => {
                type $T = i16;
                $body
            }
            $crate::Dtype::U32 => {
                type $T = u32;
                $body
            }
            $crate::Dtype::I32 => {
                type $T = i32;
                $body
            }
            $crate::Dtype::F32 => {
                type $T = f32;
                $body
            }
            $crate::Dtype::F64 => {
                type $T = f64;
                $body
            }
        }
    };
}

macro_rules! from_volume {
    ($($t:ident $name:ident),*) => {$(
        impl From<Volume<$t>> for AnyVolume {
            fn from(volume: Volume<$t>) -> Self {
                Self::$name(volume)
            }
        }
    )*};
}

from_volume!(u8 U8, i8 I8, u16 U16, i16 I16, u32 U32, i32 I32, f32 F32, f64 F64);

impl AnyVolume {
    /// The type of the samples.
    pub fn dtype(&self) -> Dtype {
        fn of<T: crate::Sample>(_: &Volume<T>) -> Dtype {
            T::DTYPE
        }
        for_any!(self, volume => of(volume))
    }

    /// The lattice.
    pub fn grid(&self) -> &Grid {
        for_any!(self, volume => volume.grid())
    }

    /// What a stored sample means.
    pub fn scaling(&self) -> Scaling {
        for_any!(self, volume => volume.scaling())
    }

    /// Moves the lattice in the world; the samples stay.
    pub fn set_frame(&mut self, frame: Frame) {
        for_any!(self, volume => volume.set_frame(frame));
    }
}
