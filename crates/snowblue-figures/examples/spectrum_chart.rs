//! Solves two slabs of snow and draws their spectra into `spectrum.svg`.
//!
//! ```sh
//! cargo run --release -p snowblue-figures --example spectrum_chart
//! ```

use std::error::Error;

use snowblue_figures::plot;
use snowblue_transport::optics::Wavelengths;
use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Slab};

fn main() -> Result<(), Box<dyn Error>> {
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![5.0, 15.0],
        incidences: vec![Incidence::Diffuse],
        wavelengths_nm: Wavelengths::visible().0,
    };
    let rows = ordinates::solve(&slab, &OrdinatesOptions::default())?;
    let metadata = [("snow", "400 µm, 300 kg/m³".to_owned())];
    std::fs::write("spectrum.svg", plot::spectrum(&rows, &metadata, false))?;
    Ok(())
}
