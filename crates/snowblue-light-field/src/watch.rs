//! What the work on a light field reports and counts.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use snowblue_scene::progress::{Phase, Progress, Report};

/// Rounds of light between bodies that are expected before one has told how many there will be.
const USUAL_ROUNDS: f64 = 10.0;

/// Watches the work on a light field.
pub(crate) struct Watch<'a> {
    report: Report<'a>,
    solving: Mutex<Solving>,
    rays: AtomicU64,
}

/// The solutions of a light field.
#[derive(Debug, Clone, Copy, Default)]
struct Solving {
    /// Bodies, each of which has a solution in each round.
    bodies: u64,
    /// Lights of one spectrum after the present one.
    lights_ahead: u64,
    /// Solutions, and those before the present light.
    done: u64,
    before: u64,
    /// Solutions that the present light is expected to take.
    expected: u64,
    /// Rounds of light between bodies, and those of the present light.
    rounds: u64,
    rounds_of_light: u64,
}

/// What the work on a light field took.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Work {
    /// Rounds of light between bodies.
    pub(crate) rounds: u64,
    /// Rays that found lights and other surfaces.
    pub(crate) rays: u64,
}

impl<'a> Watch<'a> {
    /// Starts with nothing done.
    pub(crate) fn new(report: Report<'a>) -> Self {
        Self { report, solving: Mutex::default(), rays: AtomicU64::new(0) }
    }

    /// Bodies that have cells, and all; 0 if it is not known how many there are.
    pub(crate) fn cells(&self, done: usize, bodies: usize) {
        (self.report)(Progress { phase: Phase::Cells, done: done as u64, total: bodies as u64 });
    }

    /// Expects the solutions for so many lights of one spectrum each.
    pub(crate) fn expect_lights(&self, lights: usize) {
        self.solving.lock().unwrap_or_else(PoisonError::into_inner).lights_ahead = lights as u64;
    }

    /// Begins the solution for the next light.
    pub(crate) fn begin_light(&self, bodies: usize) {
        self.update(|solving| {
            // A light takes as many solutions as the one before.
            let of_last = solving.done - solving.before;
            *solving = Solving {
                bodies: bodies as u64,
                lights_ahead: solving.lights_ahead.saturating_sub(1),
                before: solving.done,
                expected: of_last.max(bodies as u64),
                rounds_of_light: 0,
                ..*solving
            };
        });
    }

    /// Begins a round of light between bodies. `balanced` is how far they are in balance: by how many of the decades
    /// that it has to fall what is missing has fallen, 0 to 1.
    pub(crate) fn begin_round(&self, balanced: f64) {
        self.update(|solving| {
            let rounds = solving.rounds_of_light as f64;
            let left = if balanced > 0.0 { rounds * (1.0 / balanced - 1.0) } else { USUAL_ROUNDS - rounds };
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive number")]
            let left = left.max(1.0).ceil() as u64;
            solving.expected = solving.done - solving.before + (left + 1) * solving.bodies;
            solving.rounds += 1;
            solving.rounds_of_light += 1;
        });
    }

    /// Ends the rounds: each body has one solution more.
    pub(crate) fn end_rounds(&self) {
        self.update(|solving| solving.expected = solving.done - solving.before + solving.bodies);
    }

    /// Counts a solution in a body.
    pub(crate) fn add_solution(&self) {
        self.update(|solving| solving.done += 1);
    }

    /// Counts rays.
    pub(crate) fn add_rays(&self, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    /// What the work took.
    pub(crate) fn work(&self) -> Work {
        let rounds = self.solving.lock().unwrap_or_else(PoisonError::into_inner).rounds;
        Work { rounds, rays: self.rays.load(Ordering::Relaxed) }
    }

    fn update(&self, change: impl FnOnce(&mut Solving)) {
        let progress = {
            let mut solving = self.solving.lock().unwrap_or_else(PoisonError::into_inner);
            change(&mut solving);
            let Solving { lights_ahead, done, before, expected, .. } = *solving;
            Progress { phase: Phase::Light, done, total: done.max(before + expected * (lights_ahead + 1)) }
        };
        // What is reported may unwind.
        (self.report)(progress);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two bodies under two lights: a solution each in every round, then the last ones.
    #[test]
    fn solutions_are_expected_by_the_decades_of_what_is_missing() {
        let reported = Mutex::new(Vec::new());
        let report = |at: Progress| reported.lock().unwrap().push((at.done, at.total));
        let last = || *reported.lock().unwrap().last().unwrap();
        let watch = Watch::new(&report);
        watch.expect_lights(2);
        watch.begin_light(2);
        assert_eq!(last(), (0, 4));
        watch.begin_round(0.0);
        assert_eq!(last(), (0, 2 * 2 * 11));
        (0..2).for_each(|_| watch.add_solution());
        // A round took a quarter of the decades, so three are left.
        watch.begin_round(0.25);
        assert_eq!(last(), (2, 2 * (2 + 2 * 4)));
        (0..2).for_each(|_| watch.add_solution());
        watch.end_rounds();
        assert_eq!(last(), (4, 2 * 6));
        (0..2).for_each(|_| watch.add_solution());
        watch.begin_light(2);
        assert_eq!(last(), (6, 12));
        assert_eq!(watch.work().rounds, 2);
        // More than expected.
        (0..9).for_each(|_| watch.add_solution());
        assert_eq!(last(), (15, 15));
    }
}
