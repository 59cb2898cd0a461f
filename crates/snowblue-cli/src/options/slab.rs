//! Thickness of a slab, and direction of the light.

use clap::Args;
use snowblue_transport::parameters::{ANGLE, THICKNESS};
use snowblue_transport::slab::Incidence;

use super::{limits, parse};
use crate::output::{Failure, Outcome};

/// Thickness of a slab, and direction of the light.
#[derive(Debug, Args)]
#[command(next_help_heading = "Slab")]
pub(crate) struct SlabOptions {
    #[arg(
        long, value_name = "CM", default_values_t = [THICKNESS.default], value_delimiter = ',',
        value_parser = parse::number,
        help = format!("{}, or inf for a half-space, several separated by commas", limits::described(&THICKNESS))
    )]
    pub(crate) thickness: Vec<f64>,
    #[arg(
        long, value_name = "DEG", default_value = "0", value_delimiter = ',', value_parser = parse::incidence,
        help = format!("{}, or 'diffuse' (Lambertian), several separated by commas", limits::described(&ANGLE))
    )]
    pub(crate) angle: Vec<Incidence>,
}

/// Checks that light passes through the slabs if their transmitted colour is requested.
pub(crate) fn check_transmits(thicknesses_cm: &[f64], is_reflected: bool) -> Outcome {
    if !is_reflected && thicknesses_cm.iter().any(|thickness_cm| thickness_cm.is_infinite()) {
        let message = "thickness is inf cm, which lets no light through: give --reflected, or a finite thickness";
        return Err(Failure::Input(message.to_owned()));
    }
    Ok(())
}
