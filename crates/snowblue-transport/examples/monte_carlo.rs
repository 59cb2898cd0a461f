//! Compares the Monte Carlo engine with discrete ordinates for 2 cm of snow, in units of the standard error:
//! `cargo run -p snowblue-transport --example monte_carlo`.

#![allow(clippy::print_stdout, reason = "the example prints its result")]

use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::{Incidence, Slab, SnowSample, TransportError};

fn main() -> Result<(), TransportError> {
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![2.0],
        incidences: vec![Incidence::Beam { angle_deg: 30.0 }],
        wavelengths_nm: vec![450.0, 550.0, 650.0, 1000.0],
    };
    let options = MonteCarloOptions { rays: 20_000, ..MonteCarloOptions::default() };
    let simulated = monte_carlo::solve(&slab, &options, &|_progress| ())?;
    let solved = ordinates::solve(&slab, &OrdinatesOptions::default())?;
    println!("wavelength  transmittance, Monte Carlo  ordinates  difference");
    for (a, b) in simulated.iter().zip(&solved) {
        let (a, b, wavelength_nm) = (a.fluxes.transmittance, b.fluxes.transmittance, a.wavelength_nm);
        let difference = (a.value - b.value) / a.standard_error.hypot(b.standard_error);
        println!("{wavelength_nm:7} nm {:16.5} ± {:.5} {:12.5} {difference:9.1} σ", a.value, a.standard_error, b.value);
    }
    Ok(())
}
