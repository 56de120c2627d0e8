//! Large memory in large pages.
//!
//! The first touch of fresh memory costs more than most work done on it. A 2 MiB page is made with one
//! fault instead of 512; systems that have them give them only where asked.

/// Below this many bytes there is nothing to gain.
const WORTH_IT: usize = 4 << 20;

/// Asks the system for large pages under memory that nobody has written yet. Elsewhere than on Linux,
/// and for little memory, this does nothing; it never changes what the memory holds.
pub fn prefer_large_pages<T>(memory: &mut [T]) {
    let bytes = size_of_val(memory);
    if bytes >= WORTH_IT {
        advise(memory.as_mut_ptr().cast(), bytes);
    }
}

#[cfg(target_os = "linux")]
fn advise(start: *mut u8, bytes: usize) {
    const PAGE: usize = 4096;
    let skipped = start.align_offset(PAGE);
    if let Some(whole) = bytes.checked_sub(skipped) {
        // SAFETY: the range lies within memory that the caller has borrowed; the advice is a hint about
        // its pages and leaves their content. A system without them answers with an error, which is fine.
        unsafe {
            libc::madvise(start.add(skipped).cast(), whole / PAGE * PAGE, libc::MADV_HUGEPAGE)
        };
    }
}

#[cfg(not(target_os = "linux"))]
fn advise(_: *mut u8, _: usize) {}

#[cfg(test)]
mod tests {
    use super::prefer_large_pages;

    #[test]
    fn what_is_in_memory_stays() {
        for bytes in [0, 1, 4 << 20, (9 << 20) + 5] {
            let mut memory: Vec<u8> = (0..bytes).map(|i| (i % 251) as u8).collect();
            prefer_large_pages(&mut memory);
            assert!(memory.iter().enumerate().all(|(i, &byte)| byte == (i % 251) as u8));
        }
    }
}
