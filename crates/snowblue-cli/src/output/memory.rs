//! The memory of this process, where the system tells it: on Linux (proc(5)).

use std::fs;

/// Lets the greatest memory be that from now on. Where the system refuses, it stays that since the start.
pub(super) fn restart_peak() {
    drop(fs::write("/proc/self/clear_refs", "5"));
}

/// The greatest memory in MiB since [`restart_peak`], if it is known.
pub(super) fn peak_mib() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let kib = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(kib.trim().strip_suffix(" kB")?.parse::<f64>().ok()? / 1024.0)
}
