//! Large memory: in large pages, and back to the system.
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

/// Gives memory that was freed back to the system, which glibc does not do by itself below 64 MiB. Then
/// what is allocated next is as fresh as in a new process. Elsewhere than on Linux with glibc this does
/// nothing.
pub fn return_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: it touches free memory only, under the allocator's own locks.
    unsafe {
        libc::malloc_trim(0);
    }
}

/// From now on every large allocation has pages of its own, which go back to the system when it is
/// freed: a process then holds no more than it uses. glibc otherwise learns to keep them. Elsewhere than
/// on Linux with glibc this does nothing.
pub fn return_large_memory_when_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: it sets a number that the allocator reads, and it may be set at any time.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 18);
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
