//! Chromatic adaptation: the light under which an eye has got used to one white, as it would look under another.
//!
//! Bradford's transform, a scaling of sharpened cone responses (ρ, γ, β) = M XYZ by the ratio of the whites
//! (K. M. Lam 1985, *Metamerism and colour constancy*, University of Bradford; in its linear form in ICC.1:2022, annex E,
//! and R. W. G. Hunt & M. R. Pointer 2011, *Measuring Colour*, 4th edition).

use crate::matrix::{Matrix, inverse, product};
use crate::xyz::Xyz;

const SHARPENED: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
const FROM_SHARPENED: Matrix = inverse(SHARPENED);

impl Xyz {
    /// What looks beside the white `to` as these tristimulus values do beside the white `from`.
    ///
    /// Nothing in this crate does it unasked. White becomes white:
    /// ```
    /// # use snowblue_color::{RgbSpace, Rgb};
    /// let (screen, film) = (RgbSpace::Srgb.white(), RgbSpace::AcesCg.white());
    /// assert!(RgbSpace::AcesCg.from_xyz(screen).b > 1.05);
    /// let Rgb { r, g, b } = RgbSpace::AcesCg.from_xyz(screen.adapted(screen, film));
    /// assert!([r, g, b].iter().all(|channel| (channel - 1.0).abs() < 1e-12));
    /// ```
    ///
    /// # Panics
    /// If the eye cannot be used to `from`: one of its cone responses is not above 0, which no light of all colours has.
    #[must_use]
    pub fn adapted(self, from: Xyz, to: Xyz) -> Xyz {
        let [mut cones, from_cones, to_cones] = [self, from, to].map(|Xyz { x, y, z }| product(SHARPENED, [x, y, z]));
        assert!(from_cones.iter().all(|response| *response > 0.0), "{from:?} is no white");
        for ((response, to), from) in cones.iter_mut().zip(to_cones).zip(from_cones) {
            *response *= to / from;
        }
        let [x, y, z] = product(FROM_SHARPENED, cones);
        Xyz { x, y, z }
    }
}
