//! NIfTI in one file, little-endian.
//!
//! NIfTI-1 where it can hold the volume: sizes up to 32 767, a scaling and a map that f32 can say.
//! Else NIfTI-2. The map goes into the sform: code 1 where the world is RAS or LPS, 2 where nobody
//! knows which way its axes point. A grid along the axes of an unknown world, with no origin, is just
//! that in NIfTI: both codes 0.

use super::{
    super::write::{Form, put_samples},
    header::{Layout, ONE, TWO},
};
use crate::WriteFault;
use isokit_geom::{Affine, Space, Unit};
use isokit_job::Job;
use isokit_volume::{AnyVolume, Dtype, Grid, Scaling};
use std::io::Write;

pub(in super::super) fn write(
    out: &mut impl Write,
    volume: &AnyVolume,
    job: &Job,
) -> Result<(), WriteFault> {
    out.write_all(&header(volume.grid(), volume.dtype(), volume.scaling())?)?;
    put_samples(out, volume, Form::Stored, job)
}

/// The header with the four bytes that say that no extension follows.
fn header(grid: &Grid, dtype: Dtype, scaling: Scaling) -> Result<Vec<u8>, WriteFault> {
    let (unit_code, factor) = unit(grid.frame.unit);
    let frame = grid.frame.in_space(Space::Ras).unwrap_or(grid.frame);
    let affine = frame.index_to_world.scaled_world([factor; 3]).map_err(|error| {
        WriteFault::Caller(format!("no unit of NIfTI fits the map to the world: {error}").into())
    })?;
    let small = grid.dims().iter().all(|&n| n <= i16::MAX as u64);
    let layout = if small && fits_f32(&affine, scaling) { &ONE } else { &TWO };
    let mut header = Writer { bytes: vec![0; layout.size + 4], layout };
    header.start();
    header.put(layout.datatype, 0, 2, code(dtype).into());
    header.put(layout.bitpix, 0, 2, 8 * dtype.bytes() as i64);
    header.put(layout.dim, 0, layout.widths[0], 3);
    for n in 1..8 {
        let size = grid.dims().get(n - 1).copied().unwrap_or(1);
        header.put(layout.dim, n, layout.widths[0], size as i64);
    }
    header.put_real(layout.pixdim, 0, 1.0);
    for (axis, step) in affine.spacing().into_iter().enumerate() {
        header.put_real(layout.pixdim, axis + 1, step);
    }
    header.put_real(layout.scl, 0, scaling.slope());
    header.put_real(layout.scl, 1, scaling.intercept());
    let units_width = if layout.widths[2] == 2 { 1 } else { 4 };
    header.put(layout.units, 0, units_width, unit_code);
    let plain = Affine::axis_aligned(affine.spacing(), [0.0; 3]) == Ok(affine);
    let sform_code = match grid.frame.space {
        Space::Unknown if plain => 0,
        Space::Unknown => 2,
        _ => 1,
    };
    header.put(layout.codes, 1, layout.widths[2], sform_code);
    for (n, entry) in affine.rows()[..3].iter().flatten().enumerate() {
        header.put_real(layout.srow, n, *entry);
    }
    Ok(header.bytes)
}

/// Whether NIfTI-1 can say these numbers: the scaling exactly, the map as a map.
fn fits_f32(affine: &Affine, scaling: Scaling) -> bool {
    let exact = |number: f64| f64::from(number as f32) == number;
    let round = |number: f64| f64::from(number as f32);
    let columns = affine.columns().map(|column| column.map(round));
    exact(scaling.slope())
        && exact(scaling.intercept())
        && Affine::new(columns, affine.origin().map(round)).is_ok()
}

struct Writer {
    bytes: Vec<u8>,
    layout: &'static Layout,
}

impl Writer {
    /// Size, magic, and where the samples start.
    fn start(&mut self) {
        let (size, layout) = (self.layout.size, self.layout);
        self.put(0, 0, 4, size as i64);
        let magic: &[u8] = if size == ONE.size { b"n+1\0" } else { b"n+2\0\r\n\x1a\n" };
        self.bytes[layout.magic..layout.magic + magic.len()].copy_from_slice(magic);
        let offset = size + 4;
        match size == ONE.size {
            true => self.put_real(layout.vox_offset, 0, offset as f64),
            false => self.put(layout.vox_offset, 0, 8, offset as i64),
        }
    }

    /// Whole number `n`, of `width` bytes each, of the field at `at`.
    fn put(&mut self, at: usize, n: usize, width: usize, number: i64) {
        let at = at + n * width;
        self.bytes[at..at + width].copy_from_slice(&number.to_le_bytes()[..width]);
    }

    fn put_real(&mut self, at: usize, n: usize, number: f64) {
        let width = self.layout.widths[1];
        let at = at + n * width;
        match width {
            4 => self.bytes[at..at + 4].copy_from_slice(&(number as f32).to_le_bytes()),
            _ => self.bytes[at..at + 8].copy_from_slice(&number.to_le_bytes()),
        }
    }
}

fn code(dtype: Dtype) -> i16 {
    match dtype {
        Dtype::U8 => 2,
        Dtype::I16 => 4,
        Dtype::I32 => 8,
        Dtype::F32 => 16,
        Dtype::F64 => 64,
        Dtype::I8 => 256,
        Dtype::U16 => 512,
        Dtype::U32 => 768,
    }
}

/// The code of a unit that NIfTI has, and how many of it make the unit given.
fn unit(unit: Unit) -> (i64, f64) {
    match (unit, unit.metres()) {
        (_, None) => (0, 1.0),
        (Unit::Metre, _) => (1, 1.0),
        (Unit::Millimetre, _) => (2, 1.0),
        (Unit::Centimetre, _) => (2, 10.0),
        (Unit::Micrometre, _) => (3, 1.0),
        (Unit::Nanometre, _) => (3, 1e-3),
        (_, Some(metres)) => (3, metres / 1e-6),
    }
}
