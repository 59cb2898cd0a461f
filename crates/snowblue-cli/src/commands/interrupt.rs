//! Ctrl-C, and the signals by which a system or a cluster ends a program.

use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use snowblue_base::atomic_file::partial_path;

use crate::output::{Failure, INTERRUPTED, Outcome, exit_code, print_message};

/// Time within which several signals count as one signal: `timeout -s INT` signals the process and its group.
const ONE_SIGNAL: Duration = Duration::from_secs(1);

static REQUESTED: AtomicBool = AtomicBool::new(false);
static STATE: Mutex<State> = Mutex::new(State { stage: Stage::Preparation, since: None, first_picture: None });

/// The state of the work when a signal arrives.
struct State {
    stage: Stage,
    /// When the first signal came.
    since: Option<Instant>,
    /// A file with a first picture, which is to be removed unless samples replace it.
    first_picture: Option<PathBuf>,
}

/// The stage of the work.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// There is nothing to be written.
    Preparation,
    /// There are samples to be written.
    Samples,
    /// The file is complete.
    Written,
}

/// Installs the signal handler. Until [`keep_samples`] is called, a signal ends the program at once, without a trace
/// of `output`.
pub(super) fn listen(output: &Path) -> Outcome {
    let unfinished = partial_path(output);
    let handler = move || {
        let mut state = STATE.lock().unwrap_or_else(PoisonError::into_inner);
        let is_first = state.since.is_none();
        let elapsed = state.since.get_or_insert_with(Instant::now).elapsed();
        if state.stage == Stage::Samples && elapsed <= ONE_SIGNAL {
            REQUESTED.store(true, Ordering::Relaxed);
            return;
        }
        for unfinished in unfinished.iter().chain(&state.first_picture) {
            // Usually there is no such file.
            drop(std::fs::remove_file(unfinished));
        }
        if is_first && state.stage == Stage::Preparation {
            // The progress bar does not end its line.
            print_message(if io::stderr().is_terminal() { "\n" } else { "" });
            exit_code(&Err(nothing_written()));
        }
        std::process::exit(INTERRUPTED.into());
    };
    ctrlc::set_handler(handler).map_err(Failure::work)
}

/// From now on the first signal sets the flag of [`is_requested`]. A second signal ends the program at once.
pub(super) fn keep_samples() {
    STATE.lock().unwrap_or_else(PoisonError::into_inner).stage = Stage::Samples;
}

/// From now on signals end the program without a message.
pub(super) fn file_is_written() {
    STATE.lock().unwrap_or_else(PoisonError::into_inner).stage = Stage::Written;
}

/// From now on a signal, or the end of [`RemoveFirstPicture`], removes a file.
pub(super) fn set_first_picture(file: &Path) {
    STATE.lock().unwrap_or_else(PoisonError::into_inner).first_picture = Some(file.to_owned());
}

/// From now on the file of the first picture stays, because samples replace it. Returns the file.
pub(super) fn keep_picture() -> Option<PathBuf> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner).first_picture.take()
}

/// Removes at its end, also in a panic, the file of a first picture that no samples have replaced.
pub(super) struct RemoveFirstPicture;

impl Drop for RemoveFirstPicture {
    fn drop(&mut self) {
        if let Some(file) = keep_picture() {
            drop(std::fs::remove_file(file));
        }
    }
}

/// Whether a signal has been received.
pub(super) fn is_requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// The error of an interrupt before there are samples.
pub(super) fn nothing_written() -> Failure {
    Failure::Interrupted("interrupted: nothing is written".to_owned())
}
