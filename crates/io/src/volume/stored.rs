//! Where samples lie in their files, and in what code.

use super::{files::DataFiles, raw};
use crate::{
    Endian, Format, ReadError, ReadFault,
    bytes::{Bytes, Layer},
};
use isokit_job::Job;
use isokit_volume::Dtype;
use std::{
    io::{self, BufRead},
    path::{Path, PathBuf},
};

/// How the samples of a file are coded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coding {
    Raw,
    Gzip,
    Bzip2,
    /// zlib, or gzip where the first bytes show it.
    Deflate,
    Text,
}

/// Bytes between header and samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Skip {
    Bytes(u64),
    /// The samples are the last bytes of the file.
    AllButSamples,
}

/// Which axis of the lattice has neighbours that lie next to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    XFastest,
    /// z fastest, then y: NumPy's Fortran order of an array `[z, y, x]`.
    ZFastest,
}

/// The samples of all volumes of a header, in one file or several.
#[derive(Clone, Debug)]
pub(super) struct Stored {
    pub(super) format: Format,
    pub(super) files: DataFiles,
    /// The header, where the samples lie in other files.
    pub(super) named_by: Option<PathBuf>,
    /// Bytes before anything else: the header, where the samples lie in the same file.
    pub(super) header: u64,
    /// Lines after that, before anything is unpacked.
    pub(super) lines: u64,
    pub(super) coding: Coding,
    /// Bytes after that, unpacked.
    pub(super) skip: Skip,
    pub(super) dtype: Dtype,
    pub(super) endian: Endian,
    pub(super) order: Order,
    /// Samples in each file.
    pub(super) per_file: u64,
    /// Whether bytes after the samples are a fault.
    pub(super) ends: bool,
}

impl Stored {
    /// Little-endian samples, x fastest, right after a header of `header` bytes.
    pub(super) fn attached(format: Format, path: &Path, header: u64, dtype: Dtype) -> Self {
        Self {
            format,
            files: DataFiles::One(path.to_owned()),
            named_by: None,
            header,
            lines: 0,
            coding: Coding::Raw,
            skip: Skip::Bytes(0),
            dtype,
            endian: Endian::Little,
            order: Order::XFastest,
            per_file: 0,
            ends: false,
        }
    }

    /// The least bytes that so many samples take, unpacked. As text, a digit each and blanks between.
    pub(super) fn least_bytes(&self, samples: u64) -> u64 {
        match self.coding {
            Coding::Text => samples.saturating_mul(2).saturating_sub(1),
            _ => samples.saturating_mul(self.dtype.bytes() as u64),
        }
    }

    /// File `n` from its first sample on.
    pub(super) fn open(&self, n: u64, job: &Job) -> Result<Bytes, ReadError> {
        let path = self.files.path(n);
        let found = self.layered(&path).map_err(|error| ReadFault::Io(self.explained(error)));
        let opened = found.and_then(|bytes| {
            let mut bytes = self.unpacked(bytes, job)?;
            let skip = match self.skip {
                Skip::Bytes(skip) => skip,
                Skip::AllButSamples => {
                    let again = self.unpacked(self.layered(&path)?, job)?;
                    let all = self.count(again, job)?;
                    all.checked_sub(self.least_bytes(self.per_file))
                        .ok_or_else(|| self.truncated(self.per_file, all))?
                }
            };
            bytes.skip(skip, self.format, job)?;
            Ok(bytes)
        });
        opened.map_err(|fault| fault.at(path))
    }

    /// Whether file `n` can hold the first `samples` of its samples, and how many bytes after its
    /// last sample will be ignored, if that can be told before they are read.
    pub(super) fn check(&self, n: u64, samples: u64, job: &Job) -> Result<u64, ReadError> {
        let bytes = self.open(n, job)?;
        if bytes.left() >= self.least_bytes(samples) {
            let left = bytes.exactly_left().filter(|_| self.coding == Coding::Raw);
            return Ok(left.unwrap_or(0).saturating_sub(self.least_bytes(self.per_file)));
        }
        let held = self.count(bytes, job);
        let fault = held.map_or_else(|fault| fault, |held| self.truncated(samples, held));
        Err(fault.at(self.files.path(n)))
    }

    /// Fewer bytes than samples need.
    pub(super) fn truncated(&self, samples: u64, held: u64) -> ReadFault {
        let announced = self.least_bytes(samples);
        if self.format == Format::Raw {
            return raw::too_short(announced, held, self.skip);
        }
        ReadFault::Truncated { format: self.format, what: "samples", announced, held }
    }

    /// The file without the layer that may lie around all of it.
    fn layered(&self, path: &Path) -> io::Result<Bytes> {
        let plain = Bytes::open_plain(path)?;
        if matches!(self.coding, Coding::Gzip | Coding::Bzip2 | Coding::Deflate)
            && self.named_by.is_some()
        {
            return Ok(plain);
        }
        // Samples may begin like a packed file; one of just the right size is none.
        let skip = if let Skip::Bytes(skip) = self.skip { skip } else { 0 };
        let whole =
            self.header.saturating_add(skip).saturating_add(self.least_bytes(self.per_file));
        let has_header = self.named_by.is_none() && self.header > 0;
        if self.coding == Coding::Raw && !has_header && plain.left() == whole {
            return Ok(plain);
        }
        let mut plain = plain;
        let layer = Layer::of_content(plain.fill_buf()?);
        Ok(plain.unpack(layer))
    }

    /// What is left of a file after header and lines, unpacked.
    fn unpacked(&self, mut bytes: Bytes, job: &Job) -> Result<Bytes, ReadFault> {
        bytes.skip(self.header, self.format, job)?;
        for _ in 0..self.lines {
            job.check()?;
            let passed = bytes.skip_until(b'\n').map_err(|e| bytes.fault(self.format, e))?;
            if passed == 0 {
                break;
            }
        }
        let layer = match self.coding {
            Coding::Raw | Coding::Text => Layer::Plain,
            Coding::Gzip => Layer::Gzip,
            Coding::Bzip2 => Layer::Bzip2,
            Coding::Deflate => match Layer::of_content(bytes.fill_buf()?) {
                Layer::Gzip => Layer::Gzip,
                _ => Layer::Zlib,
            },
        };
        Ok(bytes.unpack(layer))
    }

    /// How many bytes are left.
    fn count(&self, mut bytes: Bytes, job: &Job) -> Result<u64, ReadFault> {
        match bytes.exactly_left() {
            Some(left) => Ok(left),
            None => bytes.skip(u64::MAX, self.format, job),
        }
    }

    /// The system's error with the reason why this file was wanted.
    fn explained(&self, error: io::Error) -> io::Error {
        match self.named_by.as_ref().and_then(|header| header.file_name()) {
            Some(header) => {
                let header = header.to_string_lossy();
                io::Error::new(error.kind(), format!("{error} (it holds the samples of {header})"))
            }
            None => error,
        }
    }
}
