//! What the machine's memory can do: the rates that no program exceeds, and how much of it is in use.

use bytemuck::Pod;
use isokit_lanes::{prefer_large_pages, prefetch};
use rayon::prelude::*;
use std::{fs, hint::black_box};

/// Bytes that a thread takes at a time: enough that the threads hardly meet.
const TASK: usize = 1 << 20;

/// Reads all samples, as fast as they come: their sum as words.
pub(crate) fn read<T: Pod>(samples: &[T]) -> u64 {
    let (head, words, tail) = bytemuck::pod_align_to::<T, u64>(samples);
    let ends = [head, tail].map(|end| bytemuck::cast_slice::<T, u8>(end).len() as u64);
    let sums = words.par_chunks(TASK / 8).map(sum);
    black_box(sums.reduce(|| ends[0] + ends[1], u64::wrapping_add))
}

/// Chunks of words that are asked for ahead, 4 KiB: the machine's own prefetchers stop at the end of every page.
const AHEAD: usize = 16;

/// Sums 32 words side by side, so that no addition waits for the one before.
fn sum(words: &[u64]) -> u64 {
    let (chunks, rest) = words.as_chunks::<32>();
    let mut sums = [0_u64; 32];
    for (n, chunk) in chunks.iter().enumerate() {
        prefetch(chunks.get(n + AHEAD).map_or(&[][..], |chunk| chunk));
        for (sum, word) in sums.iter_mut().zip(chunk) {
            *sum = sum.wrapping_add(*word);
        }
    }
    sums.iter().chain(rest).fold(0, |sum, word| sum.wrapping_add(*word))
}

/// Copies all samples over others.
pub(crate) fn copy<T: Pod + Send + Sync>(from: &[T], to: &mut [T]) {
    let size = TASK / size_of::<T>();
    to.par_chunks_mut(size).zip(from.par_chunks(size)).for_each(|(to, from)| {
        to.copy_from_slice(from);
    });
    black_box(to);
}

/// Takes memory of these sizes, in large pages where there are some, and writes all of it with plain
/// stores. Who drops it does so off the clock.
pub(crate) fn fill(parts: &[usize]) -> Vec<Vec<u64>> {
    let fill = |&bytes: &usize| {
        let mut words = vec![0_u64; bytes.div_ceil(8)];
        prefer_large_pages(&mut words);
        // Not one byte repeated, or the compiler calls `memset`, which may go past the caches.
        words.par_chunks_mut(TASK / 8).for_each(|chunk| chunk.fill(0x0102_0304_0506_0708));
        words
    };
    black_box(parts.iter().map(fill).collect())
}

/// Bytes of memory in use, now and at most so far.
pub(crate) struct InUse {
    pub(crate) now: u64,
    pub(crate) most: u64,
}

/// None where the system does not tell.
pub(crate) fn in_use() -> Option<InUse> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let bytes = |key: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(key))?;
        Some(line.split_whitespace().next()?.parse::<u64>().ok()? << 10)
    };
    Some(InUse { now: bytes("VmRSS:")?, most: bytes("VmHWM:")? })
}

/// Makes "at most so far" mean from here on, where the system lets us.
pub(crate) fn forget_the_most() {
    // Where it does not, the most so far is that of reading the volume, which holds nothing twice.
    let _ = fs::write("/proc/self/clear_refs", "5");
}
