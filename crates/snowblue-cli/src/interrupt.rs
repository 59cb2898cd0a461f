//! Ctrl-C, and the signals by which a system or a cluster asks a program to end.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use snowblue_database::file::unfinished_path;

use crate::failure::{Failure, INTERRUPTED, Outcome};

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on the first signal is a request that [`asked`] tells of; the second ends the program at once, and removes what of
/// `output` is only half written.
pub(crate) fn listen(output: &Path) -> Outcome {
    let unfinished = unfinished_path(output);
    let handler = move || {
        if ASKED.swap(true, Ordering::Relaxed) {
            if let Some(unfinished) = &unfinished {
                // Mostly there is none.
                drop(std::fs::remove_file(unfinished));
            }
            std::process::exit(INTERRUPTED.into());
        }
    };
    ctrlc::set_handler(handler).map_err(Failure::work)
}

/// Whether the user wants the work to end.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
