//! Integrals over rings of equal angle to the sun, as far as they lie above the horizon.
//!
//! A direction is given by its angle γ to the sun and by the angle φ around the sun, 0 on the side of the zenith. The
//! elevation h of the direction follows from the elevation h₀ of the sun: sin h = sin h₀ cos γ + cos h₀ sin γ cos φ.
//! It lies above the horizon where cos φ > −tan h₀ / tan γ. The two halves of a ring are mirror images.

use std::f64::consts::PI;

/// The part of a ring above the horizon.
pub(crate) struct Ring {
    /// sin h₀ cos γ and cos h₀ sin γ.
    along: f64,
    across: f64,
    /// Greatest φ above the horizon, in radians.
    last_angle: f64,
}

impl Ring {
    /// The ring at the angle γ (`sun_angle`, in radians) around a sun at or above the horizon.
    pub(crate) fn new(sin_elevation: f64, sun_angle: f64) -> Self {
        let along = sin_elevation * sun_angle.cos();
        let across = (1.0 - sin_elevation * sin_elevation).max(0.0).sqrt() * sun_angle.sin();
        let last_angle = if along.abs() < across {
            (-along / across).acos()
        } else if along > 0.0 {
            PI
        } else {
            0.0
        };
        Self { along, across, last_angle }
    }

    /// Cosines of the zenith angle at `count` points, evenly spaced in φ over one half.
    pub(crate) fn cos_zeniths(&self, count: u32) -> impl Iterator<Item = f64> {
        midpoints(0.0, self.last_angle, count).map(|angle| (self.along + self.across * angle.cos()).max(0.0))
    }

    /// The angle φ, in radians, that both halves cover together.
    pub(crate) fn extent(&self) -> f64 {
        2.0 * self.last_angle
    }
}

/// The midpoints of `count` equal parts of an interval.
pub(crate) fn midpoints(from: f64, to: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |index| from + (to - from) * (f64::from(index) + 0.5) / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All rings together are the hemisphere: ∫ dω = 2π and ∫ cos θ dω = π.
    #[test]
    fn rings_make_the_hemisphere() {
        let count = 2000;
        for elevation in [0.0, 0.02, 0.7, 1.5, 0.5 * PI] {
            let (mut solid_angle, mut projected) = (0.0, 0.0);
            for angle in midpoints(0.0, PI, count) {
                let ring = Ring::new(f64::sin(elevation), angle);
                let weight = ring.extent() * angle.sin() * PI / f64::from(count);
                solid_angle += weight;
                projected += weight * ring.cos_zeniths(64).sum::<f64>() / 64.0;
            }
            // The midpoint rule on 2000 rings. The integrand has a kink in two rings.
            assert!((solid_angle / (2.0 * PI) - 1.0).abs() < 2e-4, "{elevation}: {solid_angle}");
            assert!((projected / PI - 1.0).abs() < 2e-4, "{elevation}: {projected}");
        }
    }
}
