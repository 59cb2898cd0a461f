//! Prints XYZ, CIELAB and the hex code of a spectrum under several illuminants.
//!
//! The spectrum approximates the transmittance of 15 cm of snow: 2 % of the blue light, a quarter of that in the red.

#![allow(clippy::print_stdout, reason = "an example prints its results")]

use snowblue_color::exposure::AutoExposure;
use snowblue_color::{ColorError, Colorimeter, Illuminant, Lab, LinearRgb, Observer, Srgb8, WavelengthStep};

fn main() -> Result<(), ColorError> {
    println!("illuminant       X        Y        Z      L*      a*      b*  hex, exposed");
    for name in ["D65", "D50", "A", "FL2", "LED-B3"] {
        // Illuminants parse from their CIE names.
        let illuminant: Illuminant = name.parse()?;
        // A 5 nm grid over the range of the illuminant's table is accurate for every light.
        let wavelengths_nm = WavelengthStep::Nm5.wavelengths_nm(illuminant);
        let colorimeter = Colorimeter::new(Observer::Cie1931, illuminant, &wavelengths_nm)?;

        let transmittance: Vec<f64> = wavelengths_nm.iter().map(|nm| snow_transmittance(*nm)).collect();
        let xyz = colorimeter.xyz(&transmittance);
        let lab = Lab::from_xyz(xyz, colorimeter.white());

        // Exposure first, then gamut mapping, then encoding.
        let rgb = LinearRgb::from_xyz(xyz);
        let exposure = AutoExposure { fraction: 1.0, level: 0.9 }.factor([rgb]);
        let hex = Srgb8::encode((rgb * exposure).displayable());

        println!(
            "{illuminant:10} {:8.5} {:8.5} {:8.5}  {:6.2}  {:6.2}  {:6.2}  {hex}",
            xyz.x, xyz.y, xyz.z, lab.l, lab.a, lab.b
        );
    }
    Ok(())
}

fn snow_transmittance(wavelength_nm: f64) -> f64 {
    0.0215 * (-((wavelength_nm - 400.0).max(0.0) / 265.0).powi(3)).exp()
}
