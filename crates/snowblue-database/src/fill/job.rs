//! What an engine has to fill, and the progress that it reports.

use snowblue_transport::sample::SnowSample;

use crate::Axes;

/// A stage of filling a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FillStage {
    /// Tracing rays in single grains, for discrete ordinates.
    Tally,
    /// Solving the equation of transfer, or tracing rays through the snow.
    Solve,
}

/// Progress of a fill. Its first report of [`FillStage::Solve`] comes when the tally is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FillProgress {
    /// The current stage.
    pub stage: FillStage,
    /// Steps done, over all stages.
    pub done: u64,
    /// Steps of all stages.
    pub total: u64,
}

/// Some grains of a table.
pub(super) struct FillJob<'job> {
    pub(super) axes: &'job Axes,
    /// All samples of the table.
    pub(super) samples: &'job [SnowSample],
    /// Indices of the grains to fill.
    pub(super) grains: &'job [usize],
    pub(super) seed: u64,
    pub(super) progress: &'job (dyn Fn(FillProgress) + Sync),
}

impl FillJob<'_> {
    pub(super) fn report(&self, stage: FillStage, done: u64, total: u64) {
        (self.progress)(FillProgress { stage, done, total });
    }
}
