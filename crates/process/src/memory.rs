//! Memory of processes: the proportional set size that the kernel counts, and a heap that fits a small board.

use std::fs;
use std::io;

/// Proportional set size of a process in bytes: its own pages, and its share of those that several map (shared memory
/// included). From `/proc/<pid>/smaps_rollup`; needs the right to look at the process.
pub fn pss_bytes(pid: u32) -> io::Result<u64> {
    let path = format!("/proc/{pid}/smaps_rollup");
    parse_pss(&fs::read_to_string(&path)?).ok_or_else(|| {
        io::Error::new(
            io::ErrorKind::InvalidData,
            format!("{path} has no line \"Pss: N kB\""),
        )
    })
}

fn parse_pss(rollup: &str) -> Option<u64> {
    let line = rollup.lines().find_map(|line| line.strip_prefix("Pss:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

/// Keeps the C library's heap small: two arenas for all threads (its default of eight a core costs megabytes in a
/// process with a dozen threads), and blocks from 256 kB on go back to the system when freed. Call it first in `main`.
pub fn keep_heap_small() {
    #[cfg(target_env = "gnu")]
    // SAFETY: mallopt only sets parameters of the allocator; these values are within its documented ranges.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, 2);
        libc::mallopt(libc::M_MMAP_THRESHOLD, 256 * 1024);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_has_a_set_size() {
        let pss = pss_bytes(std::process::id()).unwrap();
        assert!((100_000..10_000_000_000).contains(&pss), "{pss}");
    }

    #[test]
    fn kilobytes_become_bytes() {
        assert_eq!(parse_pss("Rss:  9 kB\nPss:       12 kB\n"), Some(12 * 1024));
        assert_eq!(parse_pss("Rss:  9 kB\nPss: many\n"), None);
    }
}
