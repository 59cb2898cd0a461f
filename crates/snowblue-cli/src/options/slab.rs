//! Thickness of a slab, and direction of the light.

use clap::Args;
use snowblue_transport::slab::Incidence;

use super::parse;

/// Thickness of a slab, and direction of the light.
#[derive(Debug, Args)]
#[command(next_help_heading = "Slab")]
pub(crate) struct SlabOptions {
    /// Thicknesses in cm, separated by commas [0–100000]
    #[arg(long, value_name = "CM", default_value = "15", value_delimiter = ',', value_parser = parse::number)]
    pub(crate) thickness: Vec<f64>,
    /// Angles of incidence from the normal in degrees [0–89.99], or 'diffuse' (Lambertian), separated by commas
    #[arg(long, value_name = "DEG", default_value = "0", value_delimiter = ',', value_parser = parse::incidence)]
    pub(crate) angle: Vec<Incidence>,
}
