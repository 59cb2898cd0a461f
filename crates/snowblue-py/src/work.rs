//! Long work: signals, progress and errors.

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use numpy::PyArray1;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use snowblue_render::raster::RasterImage;
use snowblue_render::{Phase, Progress};

/// Time between two checks of signals and progress.
const INTERVAL: Duration = Duration::from_millis(50);

/// Data exchanged between work and the thread that waits for it.
#[derive(Default)]
pub(crate) struct Control {
    /// The phase of the work, if it has phases.
    phase: Mutex<Option<Phase>>,
    /// An unfinished picture that has not been shown.
    picture: Mutex<Option<RasterImage>>,
    done: AtomicU64,
    total: AtomicU64,
    stop: AtomicBool,
}

/// The payload of an unwinding that ends work whose result is no longer needed.
struct Stopped;

impl Control {
    /// Sets the progress. It does not return if the work is to stop.
    pub(crate) fn set(&self, done: u64, total: u64) {
        self.done.store(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
        self.check();
    }

    /// Sets the progress of work with phases. It does not return if the work is to stop.
    pub(crate) fn set_phase(&self, Progress { phase, done, total }: Progress) {
        *self.phase.lock().unwrap_or_else(PoisonError::into_inner) = Some(phase);
        self.set(done, total);
    }

    /// Shows an unfinished picture.
    pub(crate) fn show(&self, picture: RasterImage) {
        *self.picture.lock().unwrap_or_else(PoisonError::into_inner) = Some(picture);
    }

    /// Whether the work is to stop.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns unless the work is to stop.
    pub(crate) fn check(&self) {
        if self.is_stopped() {
            resume_unwind(Box::new(Stopped));
        }
    }
}

/// Runs work on another thread without the interpreter's lock. Meanwhile this thread handles signals and calls
/// `progress(done, total)`, or `progress(done, total, phase)` for work with phases; an exception in either stops the
/// work and is raised.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    run_showing(py, progress, None, work)
}

/// As [`run`], for work on a picture, which calls `preview(width, height, pixels)` with unfinished pictures in 8-bit
/// sRGB.
pub(crate) fn run_showing<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    preview: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    check_process()?;
    let control = Arc::new(Control::default());
    let (sender, receiver) = channel();
    // The lock makes the receiver shareable. No other thread takes the lock.
    let receiver = Mutex::new(receiver);
    let seen_by_work = Arc::clone(&control);
    let thread = std::thread::spawn(move || {
        let outcome = catch_unwind(AssertUnwindSafe(|| work(&seen_by_work)));
        // After an exception there is no receiver.
        drop(sender.send(outcome));
    });
    loop {
        match py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(INTERVAL)) {
            Ok(Ok(result)) => return show(py, preview, &control).and(result),
            Ok(Err(panic)) => resume_unwind(panic),
            Err(RecvTimeoutError::Disconnected) => return Err(PyRuntimeError::new_err("the work has ended early")),
            Err(RecvTimeoutError::Timeout) => {
                let reported = py.check_signals().and_then(|()| report(progress, &control));
                let reported = reported.and_then(|()| show(py, preview, &control));
                if let Err(exception) = reported {
                    control.stop.store(true, Ordering::Relaxed);
                    drop(thread);
                    return Err(exception);
                }
            }
        }
    }
}

/// A forked process lacks the threads of its parent, and would wait for them indefinitely.
fn check_process() -> PyResult<()> {
    static FIRST: OnceLock<u32> = OnceLock::new();
    if *FIRST.get_or_init(std::process::id) == std::process::id() {
        return Ok(());
    }
    Err(PyRuntimeError::new_err(
        "snowblue was used before this process was forked: start processes by 'spawn' \
         (multiprocessing.get_context('spawn'))",
    ))
}

fn report(progress: Option<&Bound<'_, PyAny>>, control: &Control) -> PyResult<()> {
    let Some(progress) = progress else { return Ok(()) };
    let phase = *control.phase.lock().unwrap_or_else(PoisonError::into_inner);
    let (done, total) = (control.done.load(Ordering::Relaxed), control.total.load(Ordering::Relaxed));
    match phase {
        Some(phase) => progress.call1((done, total, phase.name())).map(drop),
        None if total > 0 => progress.call1((done, total)).map(drop),
        None => Ok(()),
    }
}

fn show(py: Python<'_>, preview: Option<&Bound<'_, PyAny>>, control: &Control) -> PyResult<()> {
    let picture = control.picture.lock().unwrap_or_else(PoisonError::into_inner).take();
    match (preview, picture) {
        (Some(preview), Some(picture)) => {
            let pixels = PyArray1::from_vec(py, picture.bytes());
            preview.call1((picture.width(), picture.height(), pixels)).map(drop)
        }
        _ => Ok(()),
    }
}

/// Bad input as a `ValueError`.
pub(crate) fn input(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Bad input in one of several rows: a `ValueError` whose arguments are the message and the row.
pub(crate) fn input_in_row(error: impl Display, row: usize) -> PyErr {
    PyValueError::new_err((error.to_string(), row))
}

/// Bad input in one of several rows, perhaps at a place in the row: as [`input_in_row`], with the place as a third
/// argument.
pub(crate) fn input_at(error: impl Display, row: Option<usize>, place: Option<usize>) -> PyErr {
    match (row, place) {
        (Some(row), Some(place)) => PyValueError::new_err((error.to_string(), row, place)),
        (Some(row), None) => input_in_row(error, row),
        _ => input(error),
    }
}

/// A failure at work as a `RuntimeError`.
pub(crate) fn failure(error: impl Display) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}
