//! The phases of the work on a picture: a progress bar, the time and the memory of each phase.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use snowblue_render::{Phase, Progress};

use super::memory::{peak_mib, restart_peak};
use super::progress::Progress as Bar;

/// Shows the phases of the work, one after the other.
pub(crate) struct Phases {
    quiet: bool,
    /// Whether the memory of each phase is measured.
    measures_memory: bool,
    start: Instant,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    present: Option<Present>,
    ended: Vec<Ended>,
}

/// The present phase.
struct Present {
    phase: Phase,
    bar: Bar,
    start: Instant,
}

/// A phase that has ended.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ended {
    pub(crate) phase: Phase,
    pub(crate) time: Duration,
    /// Greatest memory of the process in the phase, in MiB, if it is known.
    pub(crate) memory_mib: Option<f64>,
}

impl Phases {
    /// Phases of which none has begun.
    pub(crate) fn new(quiet: bool, measures_memory: bool) -> Self {
        Self { quiet, measures_memory, start: Instant::now(), state: Mutex::default() }
    }

    /// Begins a phase.
    pub(crate) fn begin(&self, phase: Phase) {
        self.report(Progress { phase, done: 0, total: 0 });
    }

    /// Shows the progress. A new phase ends the phase before it.
    pub(crate) fn report(&self, Progress { phase, done, total }: Progress) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match &state.present {
            Some(present) if present.phase == phase => present.bar.set(done, total),
            _ => {
                self.end_of(&mut state);
                if self.measures_memory {
                    restart_peak();
                }
                let bar = Bar::of_phase(phase, self.quiet);
                bar.start_at(done, total);
                state.present = Some(Present { phase, bar, start: Instant::now() });
            }
        }
    }

    /// Ends the present phase.
    pub(crate) fn end(&self) {
        self.end_of(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// The phases that have ended, in their order, and the time since the start.
    pub(crate) fn ended(&self) -> (Vec<Ended>, Duration) {
        (self.state.lock().unwrap_or_else(PoisonError::into_inner).ended.clone(), self.start.elapsed())
    }

    fn end_of(&self, state: &mut State) {
        if let Some(Present { phase, bar, start }) = state.present.take() {
            bar.finish();
            let memory_mib = if self.measures_memory { peak_mib() } else { None };
            state.ended.push(Ended { phase, time: start.elapsed(), memory_mib });
        }
    }
}
