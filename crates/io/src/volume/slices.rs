//! Slices handed over from files.

mod part;

pub use part::PartSlices;

use super::{
    open::VolumeFile,
    stored::{Coding, Order},
};
use crate::{
    Endian, Place, ReadError, ReadFault,
    bytes::Bytes,
    text::{next_number, shown},
};
use isokit_job::Job;
use isokit_lanes::prefer_large_pages;
use isokit_volume::{Grid, Sample, Scaling, SlabSource};
use std::{
    io::{ErrorKind, Read},
    ops::Range,
};

/// The slices of a volume in a file, or in several. [`VolumeFile::into_source`] makes it.
///
/// Takes no memory for samples but the caller's, except for NPY files in Fortran order: there a slice
/// is spread over the whole file, so all samples are fetched when the first slice is asked for.
#[derive(Debug)]
pub struct FileSlices<T> {
    file: VolumeFile,
    reader: Option<Bytes>,
    /// Samples handed over so far, or gone past.
    done: u64,
    /// Those of them that the reader has not gone past yet. It does when it is asked for more.
    behind: u64,
    turned: Vec<T>,
    /// Whole rows, of which some samples are wanted.
    rows: Vec<T>,
}

/// Planes of x that are turned at a time: as many samples as fit one line of the cache, and more.
const PLANES: usize = 32;

impl<T: Sample> FileSlices<T> {
    pub(super) fn new(file: VolumeFile) -> Self {
        Self { file, reader: None, done: 0, behind: 0, turned: vec![], rows: vec![] }
    }

    /// Goes past slices without looking at them; in a file that is not packed without reading them. There
    /// must be so many.
    pub fn skip(&mut self, slices: u64) {
        self.pass(slices * self.file.grid.slice_count());
    }

    /// Goes past samples. Of a packed file that means to unpack them, but not those after the last that is read.
    fn pass(&mut self, samples: u64) {
        let per_file = self.file.stored.per_file;
        let within = (self.file.first + self.done) % per_file;
        self.done += samples;
        self.behind += samples;
        if within + samples >= per_file {
            self.reader = None;
        }
    }

    /// Fills `part` with some rows of the next slice, and of each row with some samples; in a file that is not packed the
    /// rows before and behind them are not read.
    pub(super) fn fill_part(
        &mut self,
        [x, y]: &[Range<usize>; 2],
        part: &mut [T],
    ) -> Result<(), ReadError> {
        let [nx, ny, _] = self.file.grid.dims().map(|n| n as usize);
        if self.file.stored.order == Order::ZFastest {
            self.turn_once()?;
            let slice = &self.turned[self.done as usize..][..nx * ny];
            copy_rows(slice, (nx, y.start), x, part);
            self.done += (nx * ny) as u64;
            return Ok(());
        }
        self.pass((nx * y.start) as u64);
        if x.len() == nx {
            self.read(part)?;
        } else {
            let mut rows = std::mem::take(&mut self.rows);
            rows.resize(nx * y.len(), T::default());
            self.read(&mut rows)?;
            copy_rows(&rows, (nx, 0), x, part);
            self.rows = rows;
        }
        self.pass((nx * (ny - y.end)) as u64);
        Ok(())
    }

    /// All samples of a file that has z fastest, x fastest.
    pub(super) fn turn(&mut self, job: &Job) -> Result<Vec<T>, ReadError> {
        let count = self.file.grid.count();
        let mut samples: Vec<T> = job.limits.vec("volume", Some(count))?;
        let [nx, ny, nz] = self.file.grid.dims().map(|n| n as usize);
        let plane = ny * nz;
        let mut planes: Vec<T> = job.limits.vec("volume", Some((plane * PLANES.min(nx)) as u64))?;
        prefer_large_pages(samples.spare_capacity_mut());
        samples.resize(count as usize, T::default());
        job.progress.begin("read", nx as u64);
        for x in (0..nx).step_by(PLANES) {
            job.check()?;
            let some = PLANES.min(nx - x);
            planes.resize(some * plane, T::default());
            self.read(&mut planes)?;
            for (yz, row) in samples.chunks_exact_mut(nx).enumerate() {
                let (y, z) = (yz % ny, yz / ny);
                for (i, sample) in row[x..x + some].iter_mut().enumerate() {
                    *sample = planes[i * plane + y * nz + z];
                }
            }
            job.progress.advance(some as u64);
        }
        Ok(samples)
    }

    fn turn_once(&mut self) -> Result<(), ReadError> {
        if self.turned.is_empty() {
            let job = self.file.job.clone();
            let done = std::mem::take(&mut self.done);
            self.turned = self.turn(&job)?;
            self.done = done;
        }
        Ok(())
    }

    /// The next samples in the order of the files.
    fn read(&mut self, mut into: &mut [T]) -> Result<(), ReadError> {
        let per_file = self.file.stored.per_file;
        while !into.is_empty() {
            let next = self.file.first + self.done;
            let (n, within) = (next / per_file, next % per_file);
            let behind = std::mem::take(&mut self.behind);
            let mut reader = match self.reader.take() {
                Some(mut reader) => {
                    self.skip_samples(&mut reader, n, behind)?;
                    reader
                }
                None => self.open(n, within)?,
            };
            let count = (per_file - within).min(into.len() as u64);
            let (now, later) = into.split_at_mut(count as usize);
            let read = self.read_part(&mut reader, within, now);
            self.done += count;
            let is_last = within + count == per_file || self.done == self.file.grid.count();
            let read = match is_last {
                true => read.and_then(|()| self.end(reader)),
                false => read.map(|()| self.reader = Some(reader)),
            };
            read.map_err(|fault| fault.at(self.file.stored.files.path(n)))?;
            into = later;
        }
        Ok(())
    }

    /// File `n` from sample `within` on.
    fn open(&self, n: u64, within: u64) -> Result<Bytes, ReadError> {
        let stored = &self.file.stored;
        let mut reader = stored.open(n, &self.file.job)?;
        self.skip_samples(&mut reader, n, within)?;
        Ok(reader)
    }

    /// Goes on by so many samples in file `n`.
    fn skip_samples(&self, reader: &mut Bytes, n: u64, samples: u64) -> Result<(), ReadError> {
        let stored = &self.file.stored;
        let skipped = match stored.coding {
            Coding::Text => skip_numbers(reader, &self.file, samples),
            _ => {
                let bytes = stored.least_bytes(samples);
                reader.skip(bytes, stored.format, &self.file.job).map(drop)
            }
        };
        skipped.map_err(|fault| fault.at(stored.files.path(n)))
    }

    fn read_part(&self, reader: &mut Bytes, before: u64, into: &mut [T]) -> Result<(), ReadFault> {
        match self.file.stored.coding {
            Coding::Text => self.read_text(reader, into),
            _ => self.read_binary(reader, before, into),
        }
    }

    fn read_binary(
        &self,
        reader: &mut Bytes,
        before: u64,
        into: &mut [T],
    ) -> Result<(), ReadFault> {
        let stored = &self.file.stored;
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(into);
        let read = reader.read_up_to(bytes);
        let held = read.map_err(|error| reader.fault(stored.format, error))?;
        if held < bytes.len() {
            let samples = before + into.len() as u64;
            return Err(stored.truncated(samples, stored.least_bytes(before) + held as u64));
        }
        if stored.endian != Endian::NATIVE {
            into.iter_mut().for_each(|sample| *sample = sample.swap_bytes());
        }
        Ok(())
    }

    fn read_text(&self, reader: &mut Bytes, into: &mut [T]) -> Result<(), ReadFault> {
        let format = self.file.stored.format;
        let mut text = String::new();
        for sample in into {
            let number = next_number(reader, format, &mut text)?;
            *sample = number.parse().map_err(|_| ReadFault::Broken {
                format,
                place: Place::Byte(reader.position()),
                expected: format!("a sample of type {}", T::DTYPE).into(),
                found: if number.is_empty() { "the end".into() } else { shown(number) },
            })?;
        }
        Ok(())
    }

    /// Looks at what follows the last sample wanted from a file: a packed stream that ends there is
    /// checked against its sum, and where nothing may follow, nothing does.
    fn end(&self, mut reader: Bytes) -> Result<(), ReadFault> {
        let stored = &self.file.stored;
        if stored.coding == Coding::Text {
            return Ok(());
        }
        let more = match reader.read(&mut [0]) {
            Ok(more) => more as u64,
            // Cut off after the last sample: all that was wanted is there.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => 0,
            Err(error) => return Err(reader.fault(stored.format, error)),
        };
        if more == 0 || !stored.ends {
            return Ok(());
        }
        let more = more + reader.skip(u64::MAX, stored.format, &self.file.job)?;
        Err(super::raw::too_long(stored, more))
    }
}

/// Of rows of `nx` samples, from one on, those in a range.
fn copy_rows<T: Copy>(rows: &[T], (nx, from): (usize, usize), x: &Range<usize>, part: &mut [T]) {
    let rows = rows.chunks_exact(nx).skip(from);
    for (into, row) in part.chunks_exact_mut(x.len()).zip(rows) {
        into.copy_from_slice(&row[x.clone()]);
    }
}

fn skip_numbers(reader: &mut Bytes, file: &VolumeFile, count: u64) -> Result<(), ReadFault> {
    let mut text = String::new();
    for _ in 0..count {
        if next_number(reader, file.stored.format, &mut text)?.is_empty() {
            break;
        }
    }
    Ok(())
}

impl<T: Sample> SlabSource<T> for FileSlices<T> {
    type Error = ReadError;

    fn grid(&self) -> &Grid {
        &self.file.grid
    }

    fn scaling(&self) -> Scaling {
        self.file.scaling
    }

    fn fill(&mut self, slices: &mut [T]) -> Result<(), ReadError> {
        if self.file.stored.order == Order::XFastest {
            return self.read(slices);
        }
        self.turn_once()?;
        let start = self.done as usize;
        slices.copy_from_slice(&self.turned[start..start + slices.len()]);
        self.done += slices.len() as u64;
        Ok(())
    }

    fn fill_rows(&mut self, slice: &mut [T], rows: Range<usize>) -> Result<(), ReadError> {
        let nx = self.file.grid.dims()[0] as usize;
        let own = nx * rows.start..nx * rows.end;
        self.fill_part(&[0..nx, rows], &mut slice[own])
    }
}
