//! The memory of this process, on systems that report it: Linux (proc(5)).

use std::fs;

/// Restarts the measurement of the greatest memory. If the system refuses, the greatest memory counts from the start.
pub(super) fn restart_peak() {
    drop(fs::write("/proc/self/clear_refs", "5"));
}

/// The greatest memory in MiB since [`restart_peak`], if it is known.
pub(super) fn peak_mib() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let kib = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(kib.trim().strip_suffix(" kB")?.parse::<f64>().ok()? / 1024.0)
}
