//! Snow as a medium: its constituents, random grains, and the extinction and single scattering that follow, as moments
//! and as a phase function.

mod constituents;
mod external_reflection;
mod grain_tallies;
mod phase_function;
mod population;
mod scattering;
mod tally;
mod tally_errors;

pub(crate) use constituents::{Composition, Constituents};
pub use external_reflection::ExternalReflection;
pub use grain_tallies::{Demand, GrainTallies};
pub(crate) use phase_function::AngleBins;
pub use phase_function::{PhaseFunction, PhasePlan};
pub(crate) use population::{HitSizes, hit_size_m};
pub use population::{Population, facet_diameters_um};
pub use scattering::{HenyeyGreenstein, Medium, Scattering};
pub(crate) use tally::DEFAULT_RAYS;
pub use tally::TallyPlan;
pub(crate) use tally_errors::{GrainDeviations, directions};
