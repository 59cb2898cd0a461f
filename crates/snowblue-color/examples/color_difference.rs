//! Prints how well two dim lights can be told apart, as given and after an exposure.
//!
//! The light below deep snow is so dim that CIELAB differences are small. An observer adapted to it, or an exposed
//! image, shows the difference in hue and chroma.

#![allow(clippy::print_stdout, reason = "an example prints its results")]

use snowblue_color::{ColorDifference, ColorError, Colorimeter, Illuminant, Observer, WavelengthStep};

fn main() -> Result<(), ColorError> {
    let wavelengths_nm = WavelengthStep::Nm10.wavelengths_nm(Illuminant::D65);
    let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::D65, &wavelengths_nm)?;
    // Transmittance falls off towards the red; the steeper it falls, the bluer the light.
    let light = |slope: f64| {
        let values: Vec<f64> = wavelengths_nm.iter().map(|nm| 0.004 * (-slope * (nm - 400.0) / 300.0).exp()).collect();
        colorimeter.xyz(&values)
    };
    let difference = ColorDifference::between(light(1.0), light(2.0), colorimeter.white());
    println!("ΔE*ab as given:             {:6.2}", difference.as_given);
    println!("ΔE*ab at equal luminance:   {:6.2}", difference.at_equal_luminance);
    println!("ΔE*ab at middle grey:       {:6.2}", difference.at_middle_grey);
    println!("CIEDE2000 at middle grey:   {:6.2}", difference.at_middle_grey_2000);
    Ok(())
}
