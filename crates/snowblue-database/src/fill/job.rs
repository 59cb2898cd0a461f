//! What an engine has to fill and how: options, their form in a table's metadata, and the progress of a fill.

use snowblue_transport::optics::IceTable;
use snowblue_transport::ordinates::Streams;
use snowblue_transport::sample::SnowSample;

use crate::table::Attribute;
use crate::{Axes, DatabaseError};

/// How a table is filled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FillOptions {
    /// The engine and its options.
    pub engine: Engine,
    /// Seed of the random numbers.
    pub seed: u64,
    /// The ice constants.
    pub ice: IceTable,
}

/// An engine and its options.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Engine {
    /// Discrete ordinates.
    Ordinates {
        /// Ordinates in both hemispheres; `Auto` solves steep and grazing angles separately.
        streams: Streams,
        /// Rays per facetness and index node of the grain tally; 2²⁰ leave an error of 0.1 % in T of 15 cm.
        tally_rays: u32,
    },
    /// Random walks from grain to grain, the paper's method.
    MonteCarlo {
        /// Rays per sample, angle and index node.
        rays: u64,
    },
}

impl FillOptions {
    /// Discrete ordinates with automatic streams and `tally_rays` rays of the grain tally.
    #[must_use]
    pub fn by_ordinates(tally_rays: u32) -> Self {
        let engine = Engine::Ordinates { streams: Streams::default(), tally_rays };
        Self { engine, seed: 1, ice: IceTable::default() }
    }

    /// The metadata of a table filled with these options.
    #[must_use]
    pub fn metadata(&self) -> Vec<Attribute> {
        let engine = match self.engine {
            Engine::Ordinates { streams, tally_rays } => vec![
                Attribute::new("engine", "discrete ordinates"),
                Attribute::new("streams", streams.to_string()),
                Attribute::new("tally_rays", tally_rays.to_string()),
            ],
            Engine::MonteCarlo { rays } => {
                vec![Attribute::new("engine", "Monte Carlo"), Attribute::new("rays", rays.to_string())]
            }
        };
        let first = [
            Attribute::new("title", "Spectral transmittance and reflectance of snow"),
            Attribute::new("source", format!("snowblue {}", env!("CARGO_PKG_VERSION"))),
        ];
        let last = [
            Attribute::new("seed", self.seed.to_string()),
            Attribute::new(ICE_CONSTANTS, ice_name(self.ice)),
            Attribute::new("grain_size_measure", "greatest extension, mean of a uniform range of +-50 um"),
        ];
        first.into_iter().chain(engine).chain(last).collect()
    }
}

impl Default for FillOptions {
    fn default() -> Self {
        Self::by_ordinates(1 << 20)
    }
}

const ICE_CONSTANTS: &str = "ice_constants";

/// The ice constants of a table, from its metadata.
///
/// # Errors
/// [`DatabaseError::Metadata`] if the metadata do not name them.
pub fn ice_from_metadata(metadata: &[Attribute]) -> Result<IceTable, DatabaseError> {
    let word = find(metadata, ICE_CONSTANTS);
    let known = [IceTable::WarrenBrandt2008, IceTable::Picard2016];
    let ice = known.into_iter().find(|ice| word == Some(ice_name(*ice)));
    ice.ok_or(DatabaseError::Metadata { name: ICE_CONSTANTS })
}

fn ice_name(ice: IceTable) -> &'static str {
    match ice {
        IceTable::WarrenBrandt2008 => "Warren & Brandt 2008",
        IceTable::Picard2016 => "Picard, Libois & Arnaud 2016; Warren & Brandt 2008 above 600 nm",
    }
}

fn find<'m>(metadata: &'m [Attribute], name: &str) -> Option<&'m str> {
    metadata.iter().find(|attribute| attribute.name == name).map(|attribute| attribute.value.as_str())
}

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
