//! Large memory: in large pages, and back to the system.
//!
//! The first touch of fresh memory costs more than most work done on it. A 2 MiB page is made with one
//! fault instead of 512; systems that have them give them only where asked.

/// Below this many bytes there is nothing to gain.
const WORTH_IT: usize = 1 << 20;

/// Asks the system for large pages under memory that is written for the first time now. Elsewhere than on Linux,
/// and for little memory, this does nothing; it never changes what the memory holds.
pub fn prefer_large_pages<T>(memory: &mut [T]) {
    #[cfg(target_os = "linux")]
    if size_of_val(memory) >= WORTH_IT {
        advise(memory.as_mut_ptr().cast(), size_of_val(memory), libc::MADV_HUGEPAGE);
    }
}

/// Has the system provide the pages of memory that will be written now, all at once: one by one, each at
/// its first write, they cost several times as much. What the memory holds stays.
pub fn provide<T>(memory: &mut [T]) {
    #[cfg(target_os = "linux")]
    if size_of_val(memory) > 0 {
        advise(memory.as_mut_ptr().cast(), size_of_val(memory), libc::MADV_POPULATE_WRITE);
    }
}

#[cfg(target_os = "linux")]
fn advise(start: *mut u8, bytes: usize, advice: libc::c_int) {
    const PAGE: usize = 4096;
    // Whole pages: a large page is given only where all of it was advised, the first and last included.
    let before = start.addr() % PAGE;
    let whole = (before + bytes).next_multiple_of(PAGE);
    // SAFETY: the advice is about pages that hold memory of the caller, and leaves their content, whoever
    // owns the rest of the first and the last. A system that does not know it answers with an error,
    // which is fine.
    unsafe { libc::madvise(start.wrapping_sub(before).cast(), whole, advice) };
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

#[cfg(test)]
mod tests {
    use super::{prefer_large_pages, provide};

    #[test]
    fn what_is_in_memory_stays() {
        for bytes in [0, 1, 4 << 20, (9 << 20) + 5] {
            let mut memory: Vec<u8> = (0..bytes).map(|i| (i % 251) as u8).collect();
            prefer_large_pages(&mut memory);
            assert!(memory.iter().enumerate().all(|(i, &byte)| byte == (i % 251) as u8));
        }
    }

    #[test]
    fn what_is_in_memory_stays_when_pages_are_provided() {
        for bytes in [0, 1, 4096, 4 << 20, (9 << 20) + 5] {
            let mut memory: Vec<u8> = (0..bytes).map(|i| (i % 251) as u8).collect();
            for start in [0, 1, 4095].map(|start| start.min(bytes)) {
                provide(&mut memory[start..]);
            }
            provide(memory.spare_capacity_mut());
            assert!(memory.iter().enumerate().all(|(i, &byte)| byte == (i % 251) as u8));
        }
    }
}
