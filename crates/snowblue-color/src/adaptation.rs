//! Chromatic adaptation: the tristimulus values that look the same under another white.
//!
//! The Bradford transform scales sharpened cone responses (ρ, γ, β) = M XYZ by the ratio of the whites (K. M. Lam 1985,
//! *Metamerism and colour constancy*, University of Bradford; in its linear form in ICC.1:2022, annex E, and R. W. G.
//! Hunt & M. R. Pointer 2011, *Measuring Colour*, 4th edition).

use crate::matrix::{Matrix, inverse, product};
use crate::xyz::Xyz;

const XYZ_TO_SHARPENED: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
const SHARPENED_TO_XYZ: Matrix = inverse(XYZ_TO_SHARPENED);

/// A change of white. This crate applies none on its own.
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
    /// Tristimulus values that look under `to_white` as `xyz` looks under `from_white`.
    ///
    /// # Panics
    /// If a cone response of `from_white` is not above 0. Every broadband light has positive responses.
    #[must_use]
    pub fn apply(self, xyz: Xyz) -> Xyz {
        let [mut cones, from_cones, to_cones] =
            [xyz, self.from_white, self.to_white].map(|Xyz { x, y, z }| product(XYZ_TO_SHARPENED, [x, y, z]));
        assert!(from_cones.iter().all(|response| *response > 0.0), "{:?} is no white", self.from_white);
        for ((response, to), from) in cones.iter_mut().zip(to_cones).zip(from_cones) {
            *response *= to / from;
        }
        let [x, y, z] = product(SHARPENED_TO_XYZ, cones);
        Xyz { x, y, z }
    }
}
