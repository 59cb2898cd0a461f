//! Options of the discrete-ordinates engine.

use super::streams::{Peak, Streams};
use crate::medium::TallyPlan;
use crate::slab::Incidence;

/// Options of the discrete-ordinates engine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrdinatesOptions {
    /// Ordinates, counting both hemispheres.
    pub streams: Streams,
    /// Rays per index node of the grain tally.
    pub tally_rays: u32,
    /// Seed of the grain tally.
    pub seed: u64,
}

impl OrdinatesOptions {
    /// The tally options for snow with a forward peak under some lights.
    pub(crate) fn plan(&self, incidences: &[Incidence], peak: Peak) -> TallyPlan {
        self.plan_of_degree(self.streams.most(incidences, peak))
    }

    pub(super) fn plan_of_degree(&self, degree: usize) -> TallyPlan {
        TallyPlan { degree, rays: self.tally_rays, seed: self.seed }
    }
}

impl Default for OrdinatesOptions {
    fn default() -> Self {
        Self { streams: Streams::default(), tally_rays: crate::medium::DEFAULT_RAYS, seed: 1 }
    }
}
