//! A part of a file that grows while the parts before it grow too.
//!
//! It is kept in a file without a name, in the bytes that it will have, and copied to its place when all
//! is there: by the system, which may let both files share their blocks. A section that is copied is gone.

use super::stream::Stream;
use crate::{Output, WriteFault};
use isokit_job::Job;
use std::{
    fs::File,
    io::{self, Read, Seek},
};

/// Bytes that are copied between two looks at the job.
const STEP: u64 = 64 << 20;
/// Triples that are read back at a time.
const TRIPLES: usize = 1 << 16;

/// A part of a file, written piece by piece.
#[derive(Debug)]
pub(super) struct Section {
    file: File,
}

impl Section {
    /// An empty section on the disk of `beside`.
    pub(super) fn create(beside: &Output) -> io::Result<Self> {
        Ok(Self { file: beside.scratch()? })
    }

    /// Adds what `put` puts.
    pub(super) fn add(
        &mut self,
        job: &Job,
        put: impl FnOnce(&mut Stream<'_>) -> Result<(), WriteFault>,
    ) -> Result<(), WriteFault> {
        let mut stream = Stream::new(&mut self.file, job);
        put(&mut stream)?;
        stream.finish()
    }

    /// How long it is.
    pub(super) fn bytes(&self) -> u64 {
        // Only progress is told, and what is not known is not worth a failure.
        self.file.metadata().map_or(0, |about| about.len())
    }

    /// Reads back triples of whole numbers, some at a time.
    pub(super) fn read(
        mut self,
        job: &Job,
        mut take: impl FnMut(&[[u32; 3]]) -> Result<(), WriteFault>,
    ) -> Result<(), WriteFault> {
        self.file.rewind()?;
        let mut left = self.file.metadata()?.len() as usize / size_of::<[u32; 3]>();
        let mut triples = vec![[0; 3]; left.min(TRIPLES)];
        while left > 0 {
            let some = &mut triples[..left.min(TRIPLES)];
            let bytes = bytemuck::cast_slice_mut(some);
            self.file.read_exact(bytes)?;
            job.progress.advance(bytes.len() as u64);
            some.as_flattened_mut().iter_mut().for_each(|number| *number = u32::from_le(*number));
            take(some)?;
            left -= some.len();
        }
        Ok(())
    }

    /// Copies all of it to the end of `out`.
    pub(super) fn append_to(mut self, out: &mut Output, job: &Job) -> Result<(), WriteFault> {
        self.file.rewind()?;
        loop {
            job.check()?;
            match out.append(&self.file, STEP)? {
                0 => return Ok(()),
                bytes => job.progress.advance(bytes),
            }
        }
    }
}
