//! Fills a table by either engine, whole or a part of its grains at a time.
//!
//! Neither engine sees more than it must of a table's axes. By ordinates one grain tally serves a facetness and one
//! eigenproblem a (size, facetness, wavelength) of dry and clean snow; densities, thicknesses and angles follow by
//! back-substitution. By Monte Carlo one trace serves all wavelengths and thicknesses, and all densities of dry snow.
//! The paper traced 10⁵ rays for each of the 767,250 values.

mod monte_carlo;
mod ordinates;

use std::time::Duration;

use snowblue_transport::optics::IceTable;
use snowblue_transport::ordinates::Streams;
use snowblue_transport::sample::SnowSample;

use crate::{Axes, DatabaseError, Table};

/// How a table is filled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FillOptions {
    /// Which engine, and how much of it.
    pub engine: Engine,
    /// Seed of all randomness.
    pub seed: u64,
    /// Whose absorption of ice is used.
    pub ice: IceTable,
}

/// An engine and what it is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Engine {
    /// Discrete ordinates.
    Ordinates {
        /// Ordinates, counting both hemispheres; `Auto` solves steep and grazing angles apart.
        streams: Streams,
        /// Rays per facetness and index node of the grain tally; 2²⁰ leave 0.1 % in T of 15 cm.
        tally_rays: u32,
    },
    /// The walk from grain to grain, the paper's way.
    MonteCarlo {
        /// Rays per sample, angle and index node.
        rays: u64,
    },
}

impl FillOptions {
    /// Discrete ordinates with automatic streams and this many rays of the grain tally.
    #[must_use]
    pub fn by_ordinates(tally_rays: u32) -> Self {
        let engine = Engine::Ordinates { streams: Streams::default(), tally_rays };
        Self { engine, seed: 1, ice: IceTable::default() }
    }
}

impl Default for FillOptions {
    fn default() -> Self {
        Self::by_ordinates(1 << 20)
    }
}

/// How long the parts took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FillTimes {
    /// Sending rays at grains, for the ordinates.
    pub tally: Duration,
    /// Solving the equation of transfer, or walking.
    pub solve: Duration,
}

/// Values of some grains, in their order: `[grain][sample][light][thickness][wavelength]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Values {
    /// Light that leaves below.
    pub transmittance: Vec<f64>,
    /// Light that leaves on top.
    pub reflectance: Vec<f64>,
    /// Standard errors of both, where the engine has rays.
    pub errors: Option<[Vec<f64>; 2]>,
}

/// Fills a table on `axes` with transmittance and reflectance. `progress` is told how many of how many steps are done.
///
/// # Errors
/// If an axis or an option is out of range.
pub fn fill(
    axes: &Axes,
    options: &FillOptions,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<(Table, FillTimes), DatabaseError> {
    let grains: Vec<usize> = (0..axes.grains()).collect();
    let (values, times) = fill_grains(axes, options, &grains, progress)?;
    let Values { transmittance, reflectance, errors } = values;
    Ok((Table { axes: axes.clone(), transmittance, reflectance, errors, metadata: metadata(options) }, times))
}

/// Fills the given grains, each a number of grain size × facetness, as [`fill`] does: to the same bits.
///
/// # Errors
/// If an axis or an option is out of range.
pub fn fill_grains(
    axes: &Axes,
    options: &FillOptions,
    grains: &[usize],
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<(Values, FillTimes), DatabaseError> {
    axes.check(options.ice)?;
    let samples: Vec<SnowSample> =
        (0..axes.samples()).map(|number| axes.sample(number, options.ice)).collect::<Result<_, _>>()?;
    match options.engine {
        Engine::Ordinates { streams, tally_rays } => {
            streams.check()?;
            Ok(ordinates::fill((axes, &samples), (streams, tally_rays, options.seed), grains, progress))
        }
        Engine::MonteCarlo { rays } => monte_carlo::fill((axes, &samples), (rays, options.seed), grains, progress),
    }
}

/// How a table was filled by discrete ordinates, told by its metadata, so that more of the same can be computed.
///
/// # Errors
/// [`DatabaseError::Metadata`] for what is missing or makes no sense: other models' tables do not say.
pub fn told_by(metadata: &[(String, String)]) -> Result<FillOptions, DatabaseError> {
    let word = |name: &'static str| {
        let found = metadata.iter().find(|(other, _)| other == name);
        found.map(|(_, word)| word.as_str()).ok_or(DatabaseError::Metadata { name })
    };
    fn number<N: std::str::FromStr>(name: &'static str, word: &str) -> Result<N, DatabaseError> {
        word.parse().map_err(|_| DatabaseError::Metadata { name })
    }
    let streams = match word("streams")? {
        "auto" => Streams::Auto,
        word => Streams::Exactly(number("streams", word)?),
    };
    streams.check()?;
    let tally_rays = number("tally_rays", word("tally_rays")?)?;
    Ok(FillOptions {
        engine: Engine::Ordinates { streams, tally_rays },
        seed: number("seed", word("seed")?)?,
        ice: ice(metadata)?,
    })
}

/// Whose ice a table is of, by its [`metadata`].
///
/// # Errors
/// [`DatabaseError::Metadata`] if the table does not tell.
pub fn ice(metadata: &[(String, String)]) -> Result<IceTable, DatabaseError> {
    const NAME: &str = "ice_constants";
    let told = metadata.iter().find(|(name, _)| name == NAME);
    let known = [IceTable::WarrenBrandt2008, IceTable::Picard2016];
    let ice = known.into_iter().find(|ice| told.is_some_and(|(_, word)| word == ice_name(*ice)));
    ice.ok_or(DatabaseError::Metadata { name: NAME })
}

/// How a table was made, by name.
#[must_use]
pub fn metadata(options: &FillOptions) -> Vec<(String, String)> {
    let engine = match options.engine {
        Engine::Ordinates { streams, tally_rays } => {
            vec![
                ("engine", "discrete ordinates".to_owned()),
                ("streams", streams.to_string()),
                ("tally_rays", tally_rays.to_string()),
            ]
        }
        Engine::MonteCarlo { rays } => vec![("engine", "Monte Carlo".to_owned()), ("rays", rays.to_string())],
    };
    let first = [
        ("title", "Spectral transmittance and reflectance of snow".to_owned()),
        ("source", format!("snowblue {}", env!("CARGO_PKG_VERSION"))),
    ];
    let last = [
        ("seed", options.seed.to_string()),
        ("ice_constants", ice_name(options.ice).to_owned()),
        ("grain_size_measure", "greatest extension, mean of a uniform range of +-50 um".to_owned()),
    ];
    first.into_iter().chain(engine).chain(last).map(|(name, value)| (name.to_owned(), value)).collect()
}

fn ice_name(ice: IceTable) -> &'static str {
    match ice {
        IceTable::WarrenBrandt2008 => "Warren & Brandt 2008",
        IceTable::Picard2016 => "Picard, Libois & Arnaud 2016; Warren & Brandt 2008 above 600 nm",
    }
}
