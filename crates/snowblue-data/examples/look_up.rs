//! Looks up spectra in the embedded table and prints them with their colours.
//!
//! `cargo run -p snowblue-data --example look_up`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

use std::error::Error;

use snowblue_color::{Colorimeter, Illuminant, LinearRgb, Observer, Srgb8};
use snowblue_database::{PcaSnow, TableSample};

fn main() -> Result<(), Box<dyn Error>> {
    // Mean grain size in µm, mean facetness, density in kg/m³.
    let snow = PcaSnow::new(snowblue_data::embedded(), &TableSample::new(400.0, 0.3, 300.0))?;
    let daylight = Colorimeter::new(Observer::Cie1931, Illuminant::D65, snow.wavelengths_nm())?;
    println!("thickness  T(450 nm)  T(550 nm)  T(650 nm)  colour of the transmitted daylight");
    for thickness_cm in [1.0, 5.0, 15.0, 30.0_f32] {
        let mut transmittance = vec![0.0; snow.wavelengths_nm().len()];
        snow.transmittance(thickness_cm, 0.0, &mut transmittance);
        let spectrum: Vec<f64> = transmittance.iter().map(|value| f64::from(*value)).collect();
        let light = daylight.xyz(&spectrum);
        // At one luminance, so that colours of dim light are visible.
        let colour = Srgb8::encode(LinearRgb::from_xyz(light * (0.5 / light.y)).displayable());
        let [blue, green, red] = [transmittance[5], transmittance[15], transmittance[25]];
        println!("{thickness_cm:>6} cm  {blue:>9.5}  {green:>9.5}  {red:>9.5}  {colour}");
    }
    Ok(())
}
