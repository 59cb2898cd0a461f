//! Snow as a medium: its constituents, random grains, and the extinction and single scattering that follow, as moments
//! and as a phase function.

mod angle_bins;
mod constituents;
mod external_reflection;
mod facet_size;
mod grain_tallies;
mod phase_function;
mod population;
mod scattering;
mod tally;
mod tally_cache;

pub(crate) use angle_bins::AngleBins;
pub(crate) use constituents::{Composition, Constituents};
pub use external_reflection::ExternalReflection;
pub use facet_size::facet_diameters_um;
pub use grain_tallies::{Demand, GrainTallies};
pub use phase_function::{PhaseFunction, PhasePlan};
pub use population::Population;
pub(crate) use population::{HitSizes, hit_size_m};
pub use scattering::{HenyeyGreenstein, Medium, Scattering};
pub use tally::TallyPlan;
pub(crate) use tally::{BATCHES, DEFAULT_RAYS};
