//! Tristimulus values: the response of a standard observer to light.
//!
//! x = X/(X + Y + Z), y = Y/(X + Y + Z) (CIE 015:2018).

use std::ops::{Add, Mul};

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

    /// The same chromaticity at another luminance. NaN for black.
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
