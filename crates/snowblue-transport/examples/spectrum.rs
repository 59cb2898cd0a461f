//! Prints the reflectance, transmittance and absorptance of 15 cm of snow at visible wavelengths as a table:
//! `cargo run -p snowblue-transport --example spectrum`.

#![allow(clippy::print_stdout, reason = "the example prints its result")]

use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::{GrainSize, Incidence, Slab, SnowSample, TransportError, TruncatedNormal};

fn main() -> Result<(), TransportError> {
    let slab = Slab {
        sample: SnowSample {
            grain_size: GrainSize::around(400.0)?,
            facetness: TruncatedNormal::facetness_around(0.3),
            density_kg_m3: 300.0,
            ..SnowSample::default()
        },
        thicknesses_cm: vec![15.0],
        incidences: vec![Incidence::Beam { angle_deg: 0.0 }],
        wavelengths_nm: (0..=12).map(|step| 400.0 + 25.0 * f64::from(step)).collect(),
    };
    println!("wavelength  reflectance  transmittance  absorptance");
    // One row for each thickness, then each incidence, then each wavelength.
    for row in ordinates::solve(&slab, &OrdinatesOptions::default())? {
        println!(
            "{:7} nm {:12.5} {:14.6} {:12.6}",
            row.wavelength_nm,
            row.fluxes.reflectance.value,
            row.fluxes.transmittance.value,
            row.fluxes.absorptance.value
        );
    }
    Ok(())
}
