//! Progress with rate and time left, on a terminal only.

use std::io::{self, IsTerminal as _};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A line on the terminal that says how far the work has come.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// A bar that counts in `unit`; nothing is shown if `quiet` or if stderr is not a terminal.
    pub(crate) fn new(unit: &str, quiet: bool) -> Self {
        let hidden = quiet || !io::stderr().is_terminal();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(None, target);
        let template = format!("{{wide_bar}} {{human_pos}}/{{human_len}} {unit}, {{per_sec}}, {{eta}} left");
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// Counts from what was done before, which says nothing of the rate.
    pub(crate) fn start_at(&self, done: u64, all: u64) {
        self.at(done, all);
        self.0.reset_eta();
    }

    pub(crate) fn at(&self, done: u64, all: u64) {
        self.0.set_length(all);
        self.0.set_position(done);
    }

    pub(crate) fn end(&self) {
        self.0.finish_and_clear();
    }
}
