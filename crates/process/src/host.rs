//! The host's name.

/// The name of this host as the kernel knows it; empty if it can't be read.
pub fn host_name() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    name.trim().to_owned()
}
