//! Ctrl-C, and the signals by which a system or a cluster ends a program.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use snowblue_base::atomic_file::partial_path;

use crate::output::{Failure, INTERRUPTED, Outcome};

static REQUESTED: AtomicBool = AtomicBool::new(false);
/// When the first signal came.
static SINCE: Mutex<Option<Instant>> = Mutex::new(None);

/// Time within which signals count as one: `timeout -s INT` signals the process and its group.
const ONE_SIGNAL: Duration = Duration::from_secs(1);

/// Installs the signal handler. The first signal sets the flag of [`is_requested`]; one more ends the program at once
/// and removes the unfinished file of `output`.
pub(super) fn listen(output: &Path) -> Outcome {
    let unfinished = partial_path(output);
    let handler = move || {
        REQUESTED.store(true, Ordering::Relaxed);
        if is_another() {
            if let Some(unfinished) = &unfinished {
                // Usually there is none.
                drop(std::fs::remove_file(unfinished));
            }
            std::process::exit(INTERRUPTED.into());
        }
    };
    ctrlc::set_handler(handler).map_err(Failure::work)
}

/// Whether a signal has come before the present one.
fn is_another() -> bool {
    // Only a handler holds the lock.
    let Ok(mut since) = SINCE.lock() else { return true };
    since.get_or_insert_with(Instant::now).elapsed() > ONE_SIGNAL
}

/// Whether a signal has been received.
pub(super) fn is_requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
