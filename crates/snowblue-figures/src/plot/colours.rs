//! Colours of curves.
//!
//! Ordered curves run along viridis (van der Walt & Smith 2015) from dark to light, which readers with red-green colour
//! blindness can tell apart. A wavelength has its own colour, with its value beside it.

use snowblue_color::{LinearRgb, Observer, Srgb8};

use super::canvas::GREY;

/// Colour `i` of `count` ordered curves.
pub(crate) fn ordered_colour(i: usize, count: usize) -> String {
    const VIRIDIS: [[f64; 3]; 4] = [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0]];
    let fraction = if count > 1 { i as f64 / (count - 1) as f64 } else { 0.3 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ fraction ≤ 1")]
    let cell = ((fraction * 3.0) as usize).min(2);
    let t = fraction * 3.0 - cell as f64;
    let mix = |channel: usize| VIRIDIS[cell][channel] * (1.0 - t) + VIRIDIS[cell + 1][channel] * t;
    format!("rgb({:.0},{:.0},{:.0})", mix(0), mix(1), mix(2))
}

/// The colour of monochromatic light, dark enough for a line on white; grey outside 390–740 nm.
pub(super) fn wavelength_colour(wavelength_nm: f64) -> String {
    const GREATEST_LUMINANCE: f64 = 0.3;
    let visible = (390.0..=740.0).contains(&wavelength_nm);
    match Observer::Cie1931.color_matching(wavelength_nm) {
        Ok(xyz) if visible => {
            // Spectral colours lie outside sRGB. Negative channels are cut off, which keeps lines saturated.
            let LinearRgb { r, g, b } = LinearRgb::from_xyz(xyz);
            let shown = LinearRgb { r: r.max(0.0), g: g.max(0.0), b: b.max(0.0) };
            let brightness = shown.r.max(shown.g).max(shown.b).max(shown.luminance() / GREATEST_LUMINANCE);
            let scaled = [shown.r, shown.g, shown.b].map(|channel| channel / brightness);
            Srgb8::encode(LinearRgb { r: scaled[0], g: scaled[1], b: scaled[2] }).to_string()
        }
        _ => GREY.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wavelengths_have_their_colours() {
        let channels = |nm: f64| wavelength_colour(nm).parse::<Srgb8>().unwrap();
        let (blue, green, red) = (channels(460.0), channels(535.0), channels(650.0));
        assert!(blue.b > blue.g && green.g > green.r.max(green.b) && red.r > red.g.max(red.b));
        assert_eq!(wavelength_colour(1500.0), GREY);
    }
}
