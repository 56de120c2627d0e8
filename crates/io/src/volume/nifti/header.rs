//! The header, field by field, for both versions at once.

use crate::{
    Format, Place, ReadFault,
    bytes::{Endian, Record},
};
use std::borrow::Cow;

/// Where fields lie, in bytes from the start of the file. Fields of several numbers give the first.
pub(super) struct Layout {
    pub(super) size: usize,
    pub(super) magic: usize,
    pub(super) dim: usize,
    pub(super) datatype: usize,
    pub(super) bitpix: usize,
    pub(super) pixdim: usize,
    pub(super) vox_offset: usize,
    /// `scl_slope`, `scl_inter`.
    pub(super) scl: usize,
    pub(super) units: usize,
    /// `qform_code`, `sform_code`.
    pub(super) codes: usize,
    /// `intent_code`.
    pub(super) intent: usize,
    /// `quatern_b`, `_c`, `_d`, `qoffset_x`, `_y`, `_z`.
    pub(super) quatern: usize,
    /// `srow_x`, `srow_y`, `srow_z`.
    pub(super) srow: usize,
    /// Bytes of a size, of a real number, of a code.
    pub(super) widths: [usize; 3],
}

pub(super) const ONE: Layout = Layout {
    size: 348,
    magic: 344,
    dim: 40,
    datatype: 70,
    bitpix: 72,
    pixdim: 76,
    vox_offset: 108,
    scl: 112,
    units: 123,
    codes: 252,
    intent: 68,
    quatern: 256,
    srow: 280,
    widths: [2, 4, 2],
};

pub(super) const TWO: Layout = Layout {
    size: 540,
    magic: 4,
    dim: 16,
    datatype: 12,
    bitpix: 14,
    pixdim: 104,
    vox_offset: 168,
    scl: 176,
    units: 500,
    codes: 344,
    intent: 504,
    quatern: 352,
    srow: 400,
    widths: [8, 8, 4],
};

/// Where the samples are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// In the same file.
    Single,
    /// In the `.img` beside it.
    Pair,
    /// There too, and the header is older than NIfTI.
    Analyze,
}

/// A header of known size and byte order.
pub(super) struct Header<'a> {
    pub(super) record: Record<'a>,
    pub(super) layout: &'static Layout,
    pub(super) kind: Kind,
}

impl<'a> Header<'a> {
    /// Byte order and version are told by the first number: 348 or 540.
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self, ReadFault> {
        let format = Format::Nifti;
        let truncated = |announced: usize| {
            let (announced, held) = (announced as u64, bytes.len() as u64);
            ReadFault::Truncated { format, what: "header", announced, held }
        };
        if bytes.len() < 4 {
            return Err(truncated(ONE.size));
        }
        let read = |endian| Record { bytes, endian }.i32(0);
        let sizes = [Endian::Little, Endian::Big].map(|endian| (endian, read(endian)));
        let found = sizes.into_iter().find_map(|(endian, size)| match size {
            348 => Some((endian, &ONE)),
            540 => Some((endian, &TWO)),
            _ => None,
        });
        let Some((endian, layout)) = found else {
            return Err(ReadFault::Broken {
                format,
                place: Place::Byte(0),
                expected: "a header size of 348 or 540".into(),
                found: read(Endian::Little).to_string(),
            });
        };
        if bytes.len() < layout.size {
            return Err(truncated(layout.size));
        }
        let magic = &bytes[layout.magic..layout.magic + 4];
        let kind = match magic {
            b"n+1\0" | b"n+2\0" => Kind::Single,
            b"ni1\0" | b"ni2\0" => Kind::Pair,
            _ if layout.size == ONE.size => Kind::Analyze,
            _ => {
                let (place, expected) = (Place::Byte(layout.magic as u64), "\"n+2\" or \"ni2\"");
                let found = format!("{:?}", String::from_utf8_lossy(magic));
                return Err(ReadFault::Broken { format, place, expected: expected.into(), found });
            }
        };
        Ok(Self { record: Record { bytes, endian }, layout, kind })
    }

    /// Number `n` of the sizes; the first says how many follow.
    pub(super) fn size(&self, n: usize) -> i64 {
        let at = self.layout.dim + n * self.layout.widths[0];
        if self.layout.widths[0] == 2 { self.record.i16(at).into() } else { self.record.i64(at) }
    }

    /// Real number `n` of the field at `at`.
    pub(super) fn real(&self, at: usize, n: usize) -> f64 {
        let at = self.real_place(at, n);
        if self.layout.widths[1] == 4 { self.record.f32(at).into() } else { self.record.f64(at) }
    }

    /// Where real number `n` of the field at `at` lies.
    pub(super) fn real_place(&self, at: usize, n: usize) -> usize {
        at + n * self.layout.widths[1]
    }

    /// `qform_code` and `sform_code`.
    pub(super) fn codes(&self) -> [i32; 2] {
        if self.kind == Kind::Analyze {
            return [0, 0];
        }
        [0, 1].map(|n| {
            let at = self.layout.codes + n * self.layout.widths[2];
            if self.layout.widths[2] == 2 {
                self.record.i16(at).into()
            } else {
                self.record.i32(at)
            }
        })
    }

    /// Whether the samples are said to be vectors: `NIFTI_INTENT_VECTOR` or `_DISPVECT`.
    pub(super) fn is_of_vectors(&self) -> bool {
        let code = match self.layout.widths[2] {
            _ if self.kind == Kind::Analyze => 0,
            2 => self.record.i16(self.layout.intent).into(),
            _ => self.record.i32(self.layout.intent),
        };
        matches!(code, 1006 | 1007)
    }

    /// `xyzt_units`.
    pub(super) fn units(&self) -> i32 {
        match self.layout.widths[2] {
            _ if self.kind == Kind::Analyze => 0,
            2 => self.record.bytes[self.layout.units].into(),
            _ => self.record.i32(self.layout.units),
        }
    }

    /// Bytes before the samples; not whole in a broken NIfTI-1, where it is stored as f32.
    pub(super) fn vox_offset(&self) -> f64 {
        match self.layout.widths[1] {
            4 => self.record.f32(self.layout.vox_offset).into(),
            _ => self.record.i64(self.layout.vox_offset) as f64,
        }
    }

    /// Sizes along x, y, z, and how many volumes the other axes make.
    pub(super) fn sizes(&self) -> Result<([u64; 3], u64), ReadFault> {
        let axes = self.size(0);
        if !(1..=7).contains(&axes) {
            return Err(self.broken(self.layout.dim, "1 to 7 axes", axes.to_string()));
        }
        let mut sizes = [1_u64; 7];
        for (n, size) in sizes.iter_mut().enumerate().take(axes as usize) {
            let found = self.size(n + 1);
            let place = self.layout.dim + (n + 1) * self.layout.widths[0];
            let positive = u64::try_from(found).ok().filter(|&found| found > 0);
            *size =
                positive.ok_or_else(|| self.broken(place, "a size above 0", found.to_string()))?;
        }
        let volumes = sizes[3..].iter().try_fold(1_u64, |count, &n| count.checked_mul(n));
        let volumes = volumes.ok_or_else(|| {
            let found = format!("{:?}", &sizes[3..]);
            self.broken(self.layout.dim, "sizes that can be multiplied", found)
        })?;
        Ok(([sizes[0], sizes[1], sizes[2]], volumes))
    }

    /// The field at `at` is wrong.
    pub(super) fn broken(
        &self,
        at: usize,
        expected: impl Into<Cow<'static, str>>,
        found: String,
    ) -> ReadFault {
        let (format, place) = (Format::Nifti, Place::Byte(at as u64));
        ReadFault::Broken { format, place, expected: expected.into(), found }
    }
}
