//! What the machine did.

use isokit::lanes::Level;
use std::fs;

/// The most memory this process ever held; `None` where the system does not say.
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    of_status(&fs::read_to_string("/proc/self/status").ok()?)
}

/// Linux: a line `VmHWM:   12345 kB`.
fn of_status(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// Which vector instructions the extraction uses.
pub(crate) fn simd() -> &'static str {
    Level::current().name()
}

#[cfg(test)]
mod tests {
    use super::of_status;

    #[test]
    fn the_peak_is_read_from_its_line() {
        let status = "Name:\tisokit\nVmPeak:\t  9 kB\nVmHWM:\t   12 kB\nThreads:\t1\n";
        assert_eq!(of_status(status), Some(12 * 1024));
        assert_eq!(of_status("VmPeak: 9 kB\n"), None);
    }
}
