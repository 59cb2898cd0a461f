//! A progress bar with rate and remaining time, on a terminal only.

use std::fmt::Write;
use std::io::{self, IsTerminal as _};
use std::time::Duration;

use indicatif::{HumanCount, HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use snowblue_render::Phase;

/// Interval at which a bar is drawn even if nothing is reported.
const TICK: Duration = Duration::from_millis(200);

/// A progress bar on stderr.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// A bar that counts in `unit`, hidden if `quiet` or if stderr is not a terminal.
    pub(crate) fn new(unit: &str, quiet: bool) -> Self {
        Self::with_template(&format!("{{wide_bar}} {{human_pos}}/{{human_len}} {unit}{{pace}}"), quiet)
    }

    /// A bar for a phase of the work on a picture. Phases without known steps have a clock.
    pub(crate) fn of_phase(phase: Phase, quiet: bool) -> Self {
        let (name, unit) = (phase.name(), phase.unit());
        let bar = match phase {
            Phase::Meshes | Phase::Preview | Phase::Relief | Phase::Snow => {
                Self::with_template(&format!("{name} {{spinner}} {{elapsed}}"), quiet)
            }
            Phase::Light => {
                Self::with_template(&format!("{name} {{spinner}} {{human_pos}} {unit}, {{elapsed}}"), quiet)
            }
            Phase::Cells | Phase::Charts | Phase::Lamps | Phase::Texels | Phase::Samples => {
                Self::with_template(&format!("{name} {{wide_bar}} {{human_pos}}/{{human_len}} {unit}{{pace}}"), quiet)
            }
        };
        if !bar.0.is_hidden() {
            bar.0.enable_steady_tick(TICK);
        }
        bar
    }

    fn with_template(template: &str, quiet: bool) -> Self {
        let hidden = quiet || !io::stderr().is_terminal();
        let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template(template) {
            let write = |state: &ProgressState, text: &mut dyn Write| {
                // Errors are ignored: the bar shows what was written.
                let _ = text.write_str(&pace(state.per_sec(), state.eta()));
            };
            bar.set_style(style.with_key("pace", write));
        }
        Self(bar)
    }

    /// Sets the count of earlier work, which does not enter the rate.
    pub(crate) fn start_at(&self, done: u64, total: u64) {
        self.set(done, total);
        self.0.reset_eta();
    }

    pub(crate) fn set(&self, done: u64, total: u64) {
        self.0.set_length(total);
        self.0.set_position(done);
    }

    pub(crate) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// The rate in 1/s and the remaining time; nothing before the first step is done.
fn pace(per_second: f64, left: Duration) -> String {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a rounded rate is whole")]
    let whole = per_second.round() as u64;
    let left = HumanDuration(left);
    match per_second {
        fast if fast >= 10.0 => format!(", {}/s, {left:#} left", HumanCount(whole)),
        slow if slow >= 0.01 => format!(", {slow:.2}/s, {left:#} left"),
        slower if slower > 0.0 => format!(", {left:#} left"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_short_and_absent_before_the_first_step() {
        let left = Duration::from_secs(90);
        assert_eq!(pace(42_088.920_6, left), ", 42,089/s, 2m left");
        assert_eq!(pace(0.256, left), ", 0.26/s, 2m left");
        assert_eq!(pace(0.002, left), ", 2m left");
        assert_eq!(pace(0.0, left), "");
        assert_eq!(pace(f64::NAN, left), "");
    }
}
