//! The means of an image as named channels.
//!
//! Every image has the channels `R`, `G` and `B`, and those of its AOVs under names that other programs know. The
//! spectrum follows Fichet, Pacanowski & Wilkie (2021, "An OpenEXR layout for spectral images", Journal of Computer
//! Graphics Techniques 10(3), 1–18): `S0.400,000000nm` and so on, in W m⁻² sr⁻¹ nm⁻¹.

use snowblue_color::LinearRgb;

use crate::film::accumulator::FilmAccumulator;
use crate::film::aov::Aov;
use crate::geometry::ray::narrow;
use crate::spectrum::SAMPLES;

/// A channel of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// A value for each pixel of the window, row by row from the upper left.
    pub values: Vec<f32>,
}

/// The channels of colours and AOVs.
pub fn channels(accumulator: &FilmAccumulator) -> Vec<Channel> {
    let channel = |name: &str, values: Vec<f32>| Channel { name: name.to_owned(), values };
    let film = accumulator.film();
    let rgb = film.pixels().iter().map(|xyz| LinearRgb::from_xyz(*xyz));
    let mut channels = vec![
        channel("R", rgb.clone().map(|colour| narrow(colour.r)).collect()),
        channel("G", rgb.clone().map(|colour| narrow(colour.g)).collect()),
        channel("B", rgb.map(|colour| narrow(colour.b)).collect()),
    ];
    let aovs = accumulator.aovs();
    if aovs.spectrum {
        let wavelengths_nm = accumulator.wavelengths_nm();
        // A band density is a spectral radiance times the width of all bands.
        let band_nm = (wavelengths_nm[SAMPLES - 1] - wavelengths_nm[0]) / (SAMPLES - 1) as f64;
        let per_nm = narrow((SAMPLES as f64 * band_nm).recip());
        for (index, nm) in wavelengths_nm.iter().enumerate() {
            let values = accumulator.radiance(index).into_iter().map(|density| density * per_nm).collect();
            channels.push(channel(&format!("S0.{}nm", format!("{nm:.6}").replace('.', ",")), values));
        }
    }
    if aovs.variance {
        for (name, values) in ["variance.R", "variance.G", "variance.B"].into_iter().zip(accumulator.variance()) {
            channels.push(channel(name, values));
        }
    }
    for aov in Aov::ALL.into_iter().filter(|aov| aovs.contains(*aov)) {
        for (value, name) in aov.channel_names().iter().enumerate() {
            channels.push(channel(name, accumulator.aov(aov, value)));
        }
    }
    channels
}
