//! Tristimulus values: the response of a standard observer to light, and chromatic adaptation to another white.
//!
//! x = X/(X + Y + Z), y = Y/(X + Y + Z) (CIE 015:2018).
//!
//! For chromatic adaptation the Bradford transform scales sharpened cone responses (ρ, γ, β) = M XYZ by the ratio of
//! the whites (K. M. Lam 1985, *Metamerism and colour constancy*, University of Bradford; in its linear form in
//! ICC.1:2022, annex E, and R. W. G. Hunt & M. R. Pointer 2011, *Measuring Colour*, 4th edition).

use std::ops::{Add, Mul};

use crate::matrix::{Matrix, inverse, product};

/// Relative tristimulus values. The reference white has luminance Y = 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Xyz {
    /// X, mainly long wavelengths.
    pub x: f64,
    /// Y, the luminance.
    pub y: f64,
    /// Z, short wavelengths.
    pub z: f64,
}

/// Hue and saturation without luminance: coordinates in the chromaticity diagram.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chromaticity {
    /// x = X/(X + Y + Z).
    pub x: f64,
    /// y = Y/(X + Y + Z).
    pub y: f64,
}

/// xyY: chromaticity and luminance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Xyy {
    /// Chromaticity x, y.
    pub chromaticity: Chromaticity,
    /// Relative luminance Y.
    pub luminance: f64,
}

impl Xyy {
    /// The tristimulus values. Infinite or NaN if y = 0.
    pub fn xyz(self) -> Xyz {
        let Chromaticity { x, y } = self.chromaticity;
        let scale = self.luminance / y;
        Xyz { x: x * scale, y: self.luminance, z: (1.0 - x - y) * scale }
    }
}

impl Xyz {
    /// Chromaticity and luminance. The chromaticity of black is NaN.
    pub fn xyy(self) -> Xyy {
        Xyy { chromaticity: self.chromaticity(), luminance: self.y }
    }

    /// The chromaticity. NaN for black.
    ///
    /// Incandescent light is yellower than daylight, so its x is larger:
    /// ```
    /// # use snowblue_color::{Colorimeter, Illuminant, Observer};
    /// # let wavelengths_nm: Vec<f64> = (0..31).map(|step| 400.0 + 10.0 * f64::from(step)).collect();
    /// # let chromaticity = |illuminant| {
    /// #     let colorimeter = Colorimeter::new(Observer::Cie1931, illuminant, &wavelengths_nm)?;
    /// #     Ok::<_, snowblue_color::ColorError>(colorimeter.white().chromaticity())
    /// # };
    /// assert!(chromaticity(Illuminant::A)?.x > chromaticity(Illuminant::D65)?.x + 0.1);
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    pub fn chromaticity(self) -> Chromaticity {
        let sum = self.x + self.y + self.z;
        Chromaticity { x: self.x / sum, y: self.y / sum }
    }

    /// Tristimulus values of equal chromaticity at another luminance. NaN for black.
    #[must_use]
    pub fn with_luminance(self, luminance: f64) -> Xyz {
        self * (luminance / self.y)
    }
}

/// Additive mixture of two lights.
impl Add for Xyz {
    type Output = Xyz;

    fn add(self, other: Xyz) -> Xyz {
        Xyz { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

/// Scales the light by a factor.
impl Mul<f64> for Xyz {
    type Output = Xyz;

    fn mul(self, factor: f64) -> Xyz {
        Xyz { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

const XYZ_TO_SHARPENED: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
const SHARPENED_TO_XYZ: Matrix = inverse(XYZ_TO_SHARPENED);

/// A change of white. This crate applies chromatic adaptation only on request.
///
/// White becomes white:
/// ```
/// # use snowblue_color::{ChromaticAdaptation, Rgb, RgbSpace};
/// let (screen, film) = (RgbSpace::Srgb.white(), RgbSpace::AcesCg.white());
/// assert!(RgbSpace::AcesCg.from_xyz(screen).b > 1.05);
/// let adaptation = ChromaticAdaptation { from_white: screen, to_white: film };
/// let Rgb { r, g, b } = RgbSpace::AcesCg.from_xyz(adaptation.apply(screen));
/// assert!([r, g, b].iter().all(|channel| (channel - 1.0).abs() < 1e-12));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChromaticAdaptation {
    /// White of the given colours.
    pub from_white: Xyz,
    /// White of the adapted colours.
    pub to_white: Xyz,
}

impl ChromaticAdaptation {
    /// Whether every cone response of `from_white` is above 0, as of every broadband light.
    pub fn is_possible(self) -> bool {
        cone_responses(self.from_white).iter().all(|response| *response > 0.0)
    }

    /// Tristimulus values that look under `to_white` as `xyz` looks under `from_white`.
    ///
    /// # Panics
    /// If the adaptation is not [possible](Self::is_possible).
    #[must_use]
    pub fn apply(self, xyz: Xyz) -> Xyz {
        assert!(self.is_possible(), "{:?} is no white", self.from_white);
        let [mut cones, from_cones, to_cones] = [xyz, self.from_white, self.to_white].map(cone_responses);
        for ((response, to), from) in cones.iter_mut().zip(to_cones).zip(from_cones) {
            *response *= to / from;
        }
        let [x, y, z] = product(SHARPENED_TO_XYZ, cones);
        Xyz { x, y, z }
    }
}

fn cone_responses(Xyz { x, y, z }: Xyz) -> [f64; 3] {
    product(XYZ_TO_SHARPENED, [x, y, z])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn xyy_round_trips() {
        let light = Xyz { x: 0.25, y: 0.5, z: 0.25 };
        assert_eq!(light.xyy().xyz(), light);
        assert!(Xyz::default().xyy().chromaticity.x.is_nan());
    }

    #[test]
    fn chromaticity_does_not_depend_on_luminance() {
        let dim = Xyz { x: 0.25, y: 0.5, z: 0.25 };
        assert_eq!(dim.chromaticity(), Chromaticity { x: 0.25, y: 0.5 });
        assert_eq!((dim * 8.0).chromaticity(), dim.chromaticity());
        assert_eq!(dim + dim, dim * 2.0);
    }
}
