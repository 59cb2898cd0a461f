//! Ctrl-C, and the signals by which a system or a cluster ends a program.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use snowblue_database::file::partial_path;

use crate::output::{Failure, INTERRUPTED, Outcome, exit_code};

static REQUESTED: AtomicBool = AtomicBool::new(false);
/// When the first signal came.
static SINCE: Mutex<Option<Instant>> = Mutex::new(None);
static LISTENING: AtomicBool = AtomicBool::new(false);
/// The file that may be half written.
static UNFINISHED: Mutex<Option<PathBuf>> = Mutex::new(None);

/// The message if a signal ends the program at once; none while there is something to write.
static AT_ONCE: Mutex<Option<String>> = Mutex::new(None);

/// Time within which signals count as one: `timeout -s INT` signals the process and its group.
const ONE_SIGNAL: Duration = Duration::from_secs(1);

/// Installs the signal handler, or sets its next file. The first signal sets the flag of [`is_requested`]; one more
/// ends the program at once and removes the unfinished file of `output`.
pub(super) fn listen(output: &Path) -> Outcome {
    if let Ok(mut unfinished) = UNFINISHED.lock() {
        *unfinished = partial_path(output);
    }
    if LISTENING.swap(true, Ordering::Relaxed) {
        return Ok(());
    }
    let handler = || {
        REQUESTED.store(true, Ordering::Relaxed);
        if let Ok(message) = AT_ONCE.lock()
            && let Some(message) = &*message
        {
            exit_code(&Err(Failure::Interrupted(message.clone())));
            std::process::exit(INTERRUPTED.into());
        }
        if is_another() {
            if let Ok(unfinished) = UNFINISHED.lock()
                && let Some(unfinished) = &*unfinished
            {
                // Usually there is none.
                drop(std::fs::remove_file(unfinished));
            }
            std::process::exit(INTERRUPTED.into());
        }
    };
    ctrlc::set_handler(handler).map_err(Failure::work)
}

/// Does work that writes nothing: a signal ends the program at once, with this message.
pub(super) fn at_once<T>(message: String, work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    let set = |message: Option<String>| {
        // No thread panics while it holds the lock.
        if let Ok(mut at_once) = AT_ONCE.lock() {
            *at_once = message;
        }
    };
    set(Some(message.clone()));
    let done = if is_requested() { Err(Failure::Interrupted(message)) } else { work() };
    set(None);
    done
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
