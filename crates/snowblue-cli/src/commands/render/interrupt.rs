//! Ctrl-C, and the signals by which a system or a cluster ends a program.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use snowblue_database::file::partial_path;

use crate::output::{Failure, INTERRUPTED, Outcome};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the signal handler. The first signal sets the flag of [`is_requested`]; the second ends the program at once
/// and removes the unfinished file of `output`.
pub(super) fn listen(output: &Path) -> Outcome {
    let unfinished = partial_path(output);
    let handler = move || {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            if let Some(unfinished) = &unfinished {
                // Usually there is none.
                drop(std::fs::remove_file(unfinished));
            }
            std::process::exit(INTERRUPTED.into());
        }
    };
    ctrlc::set_handler(handler).map_err(Failure::work)
}

/// Whether a signal has been received.
pub(super) fn is_requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
