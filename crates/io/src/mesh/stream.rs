//! Vertices and triangles as bytes, a megabyte at a time.
//!
//! Each item is appended to a buffer by a small function; the buffer goes out when it is full. Between
//! two of them the job may be cancelled, and its progress moves on.

use crate::WriteFault;
use isokit_job::Job;
use std::io::Write;

/// Bytes gathered before they are handed on.
const FULL: usize = 1 << 20;

/// Where the items of a mesh go.
pub(super) struct Stream<'a> {
    out: &'a mut dyn Write,
    job: &'a Job,
    buffer: Vec<u8>,
}

impl<'a> Stream<'a> {
    pub(super) fn new(out: &'a mut dyn Write, job: &'a Job) -> Self {
        // An item begun below the mark may end above it.
        Self { out, job, buffer: Vec::with_capacity(FULL + (FULL >> 4)) }
    }

    /// Puts bytes of a header.
    pub(super) fn put(&mut self, bytes: &[u8]) {
        self.buffer.extend_from_slice(bytes);
    }

    /// Puts all items, each by `put`, and counts them as done.
    pub(super) fn items<T>(
        &mut self,
        items: impl IntoIterator<Item = T>,
        put: impl Fn(&mut Vec<u8>, T),
    ) -> Result<(), WriteFault> {
        let mut count = 0;
        for item in items {
            put(&mut self.buffer, item);
            count += 1;
            if self.buffer.len() >= FULL {
                self.hand_on()?;
                self.job.progress.advance(std::mem::take(&mut count));
            }
        }
        self.job.progress.advance(count);
        Ok(())
    }

    /// Hands on what is left.
    pub(super) fn finish(mut self) -> Result<(), WriteFault> {
        self.hand_on()?;
        Ok(self.out.flush()?)
    }

    fn hand_on(&mut self) -> Result<(), WriteFault> {
        self.job.check()?;
        self.out.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }
}

/// Three numbers, little-endian.
pub(super) fn put_f32(bytes: &mut Vec<u8>, numbers: [f32; 3]) {
    bytes.extend_from_slice(bytemuck::bytes_of(&numbers.map(|n| n.to_bits().to_le())));
}

/// Three numbers, little-endian.
pub(super) fn put_f64(bytes: &mut Vec<u8>, numbers: [f64; 3]) {
    bytes.extend_from_slice(bytemuck::bytes_of(&numbers.map(|n| n.to_bits().to_le())));
}

/// Three numbers, little-endian.
pub(super) fn put_u32(bytes: &mut Vec<u8>, numbers: [u32; 3]) {
    bytes.extend_from_slice(bytemuck::bytes_of(&numbers.map(u32::to_le)));
}

#[cfg(test)]
mod tests {
    use super::{FULL, Stream, put_u32};
    use crate::WriteFault;
    use isokit_job::Job;

    #[test]
    fn every_item_comes_out_once_and_in_order() {
        let (job, mut out) = (Job::default(), vec![]);
        let mut stream = Stream::new(&mut out, &job);
        stream.put(b"head");
        let count = FULL as u32 / 5;
        stream.items(0..count, |bytes, i| put_u32(bytes, [i; 3])).unwrap();
        stream.finish().unwrap();
        assert_eq!(out.len(), 4 + 12 * count as usize);
        let last = out.rchunks(4).next().unwrap();
        assert_eq!(last, (count - 1).to_le_bytes());
        assert_eq!(job.progress.snapshot().done, u64::from(count));
    }

    #[test]
    fn a_cancelled_job_stops() {
        let (job, mut out) = (Job::default(), vec![]);
        job.cancel.cancel();
        let mut stream = Stream::new(&mut out, &job);
        let stopped = stream.items(0..u32::MAX, |bytes, i| put_u32(bytes, [i; 3]));
        assert!(matches!(stopped, Err(WriteFault::Cancelled(_))));
        assert!(out.is_empty());
    }
}
