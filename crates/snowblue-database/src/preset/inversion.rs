//! How renderers turn the colour of a surface into the single scattering below it.
//!
//! **Van de Hulst's.** OpenPBR 1.1 (Academy Software Foundation 2025, section "Subsurface") gives the colour C of a
//! half-space without a boundary, after van de Hulst 1980, and its inverse with rounded numbers, which renderers use:
//!
//! ```text
//! s = 4.09712 + 4.20863 C − √(9.59217 + 41.6808 C + 17.7126 C²),   α = (1 − s²)/(1 − g s²).
//! ```
//!
//! **Cycles'.** Blender 4.0 to 5.1 fit α(C, g) (`kernel/integrator/subsurface_random_walk.h`), after Chiang, Kutz &
//! Burley 2016 (*Practical and controllable subsurface scattering for production path tracing*), by
//!
//! ```text
//! α = (1 − C^¼) A (atan B C)^p + C^¼ D (atan E C)^q, at most 0.999999;
//! ```
//!
//! for isotropic scattering (g = 0) with the constants below. The fit exceeds 1 for bright colours, so the colours of
//! snow, in which α is nearly 1, lie near C = 0.92.

/// Greatest single-scattering albedo of Cycles, as 1 − α.
const MIN_CO_ALBEDO: f64 = 1e-6;
/// Constants of Cycles' fit for isotropic scattering.
const A: f64 = 1.826_052_378_2;
const B: f64 = 4.985_111_943_85 + 0.127_355_959_438;
const P: f64 = 1.096_861_024_24;
const D: f64 = 0.496_310_210_422;
const E: f64 = 4.231_902_997_01 + 0.003_106_039_489_08;
const Q: f64 = 2.406_029_994_08;
/// Halvings of an interval, which leave less than the rounding of a number near 1.
const HALVINGS: u32 = 60;

/// A renderer's way from a colour to single scattering.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AlbedoInversion {
    /// Van de Hulst's approximation with the numbers of OpenPBR 1.1.
    VanDeHulst,
    /// The fit of Cycles in Blender 4.0 to 5.1 for isotropic scattering.
    Cycles,
}

impl AlbedoInversion {
    /// The single-scattering co-albedo 1 − α that a renderer finds for a colour in 0–1 and an asymmetry.
    ///
    /// White does not absorb, and an asymmetric medium absorbs less per event than an isotropic medium of equal
    /// colour:
    /// ```
    /// # use snowblue_database::preset::AlbedoInversion;
    /// assert!(AlbedoInversion::VanDeHulst.one_minus_albedo(1.0, 0.0) < 1e-10);
    /// let [isotropic, forward] = [0.0, 0.7].map(|g| AlbedoInversion::VanDeHulst.one_minus_albedo(0.95, g));
    /// assert!((forward / (1.0 - 0.7) / isotropic - 1.0).abs() < 1e-3);
    /// ```
    #[must_use]
    pub fn one_minus_albedo(self, color: f64, asymmetry: f64) -> f64 {
        match self {
            Self::VanDeHulst => {
                let s = 4.09712 + 4.20863 * color - (9.59217 + 41.6808 * color + 17.7126 * color * color).sqrt();
                (1.0 - asymmetry) * s * s / (1.0 - asymmetry * s * s)
            }
            Self::Cycles => {
                let blend = color.powf(0.25);
                let dark = A * (B * color).atan().powf(P);
                let bright = D * (E * color).atan().powf(Q);
                (1.0 - (1.0 - blend) * dark - blend * bright).clamp(MIN_CO_ALBEDO, 1.0)
            }
        }
    }

    /// The colour for which a renderer finds a co-albedo, by bisection; the nearest colour if no colour has this
    /// co-albedo.
    #[must_use]
    pub fn color(self, one_minus_albedo: f64, asymmetry: f64) -> f64 {
        // Co-albedos fall with the colour.
        let [_, high] = bisect([0.0, 1.0], |color| self.one_minus_albedo(color, asymmetry) > one_minus_albedo);
        high
    }
}

/// Bisects an interval around the number up to which a condition holds.
pub(super) fn bisect([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if holds(middle) { &mut low } else { &mut high }) = middle;
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_gives_back_its_co_albedo() {
        for (inversion, asymmetries) in
            [(AlbedoInversion::VanDeHulst, &[0.0, 0.66, 0.9][..]), (AlbedoInversion::Cycles, &[0.0])]
        {
            for asymmetry in asymmetries {
                for one_minus_albedo in [1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.5, 0.9] {
                    let color = inversion.color(one_minus_albedo, *asymmetry);
                    let back = inversion.one_minus_albedo(color, *asymmetry);
                    // Rounding errors: Cycles' fit has a difference of numbers near 1, and s is a difference of
                    // numbers near 8. 1 − α contains s².
                    let rounding = 1e-15 + 1e-14 * one_minus_albedo.sqrt();
                    assert!((back - one_minus_albedo).abs() < rounding, "{inversion:?} {one_minus_albedo}: {back}");
                }
            }
        }
    }

    /// The printed inverse inverts the forward formula C = (1 − s)(1 − 0.139 s)/(1 + 1.17 s).
    #[test]
    fn the_inverse_is_that_of_van_de_hulst() {
        for s in [0.003, 0.03, 0.1, 0.3, 0.7] {
            let color = AlbedoInversion::VanDeHulst.color(s * s, 0.0);
            let forward = (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s);
            // The constants have six digits.
            assert!((color - forward).abs() < 2e-5, "{s}: {color} {forward}");
        }
    }

    #[test]
    fn no_absorption_is_white_and_all_absorption_black() {
        // The inverse has six digits: its white is 1 to 10⁻⁵.
        assert!(AlbedoInversion::VanDeHulst.color(0.0, 0.6) > 1.0 - 2e-5);
        assert!(AlbedoInversion::VanDeHulst.color(1.0, 0.6) < 1e-5);
        // Cycles' greatest albedo belongs to a colour below white.
        let brightest = AlbedoInversion::Cycles.color(MIN_CO_ALBEDO, 0.0);
        assert!((0.9..0.95).contains(&brightest), "{brightest}");
        assert!((AlbedoInversion::Cycles.one_minus_albedo(1.0, 0.0) - MIN_CO_ALBEDO).abs() < 1e-18);
    }
}
