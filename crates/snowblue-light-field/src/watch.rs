//! Progress and statistics of the work on a light field.

use std::sync::atomic::{AtomicU64, Ordering};

use snowblue_scene::progress::{Phase, Progress, Report};

/// Reports the work on a light field and counts its steps.
pub(crate) struct Watch<'a> {
    report: Report<'a>,
    solutions: AtomicU64,
    rounds: AtomicU64,
    rays: AtomicU64,
}

/// Statistics of the work on a light field.
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
        let [solutions, rounds, rays] = [(); 3].map(|()| AtomicU64::new(0));
        Self { report, solutions, rounds, rays }
    }

    /// Reports the number of bodies that have cells, and the number of all bodies; 0 if it is not known.
    pub(crate) fn cells(&self, done: usize, bodies: usize) {
        (self.report)(Progress { phase: Phase::Cells, done: done as u64, total: bodies as u64 });
    }

    /// Reports the solutions so far.
    pub(crate) fn light(&self) {
        let done = self.solutions.load(Ordering::Relaxed);
        (self.report)(Progress { phase: Phase::Light, done, total: 0 });
    }

    /// Counts a round of light between bodies.
    pub(crate) fn begin_round(&self) {
        self.rounds.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts and reports a solution in a body.
    pub(crate) fn add_solution(&self) {
        self.solutions.fetch_add(1, Ordering::Relaxed);
        self.light();
    }

    /// Counts rays.
    pub(crate) fn add_rays(&self, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    /// The statistics.
    pub(crate) fn work(&self) -> Work {
        Work { rounds: self.rounds.load(Ordering::Relaxed), rays: self.rays.load(Ordering::Relaxed) }
    }
}
