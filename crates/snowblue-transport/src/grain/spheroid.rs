//! The shape of a grain: a prolate spheroid with semi-axes a = b ≤ c.
//!
//! Riley's sphericity Ψ is the square root of the ratio of the diameters of the inscribed and the circumscribed
//! circle in the side view (Riley 1941), so a/c = Ψ². SPLITS, the ancestor of SPLITSnow, uses this spheroid (Kimmel &
//! Baranoski 2007, doi:10.1364/OE.15.009755).

use std::f64::consts::{PI, TAU};
use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use super::microsurface::renormalized;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::{TransportError, find_by_name};
use crate::rng::{Stream, unit_circle};

/// The quantity that a grain size measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SizeMeasure {
    /// The greatest extension, as in the International Classification for Seasonal Snow (Fierz et al. 2009).
    #[default]
    GreatestExtension,
    /// Diameter of the sphere of equal volume.
    VolumeDiameter,
    /// Diameter of the sphere of equal volume per surface, 6 V/S.
    OpticalDiameter,
}

impl SizeMeasure {
    /// Every measure.
    pub const ALL: [Self; 3] = [Self::GreatestExtension, Self::VolumeDiameter, Self::OpticalDiameter];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::GreatestExtension => "greatest-extension",
            Self::VolumeDiameter => "volume-diameter",
            Self::OpticalDiameter => "optical-diameter",
        }
    }
}

/// Formats the name.
impl fmt::Display for SizeMeasure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

impl FromStr for SizeMeasure {
    type Err = TransportError;

    fn from_str(name: &str) -> Result<Self, TransportError> {
        find_by_name("size measure", name, &Self::ALL, Self::name)
    }
}

/// A prolate spheroid about the z axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spheroid {
    /// Semi-axis a = b across.
    pub across: f64,
    /// Semi-axis c ≥ a along.
    pub along: f64,
}

/// A ray at the surface of a spheroid, in units of its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    /// Point on the unit sphere that maps to the spheroid by scaling.
    pub(crate) point: DVec3,
    /// Direction of travel, into the spheroid.
    pub(crate) direction: DVec3,
}

/// A chord of a spheroid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Chord {
    /// Length, in units of the size.
    pub(crate) length: f64,
    /// End point on the unit sphere.
    pub(crate) end: DVec3,
}

impl Spheroid {
    /// The grain of sphericity `sphericity` and size 1 by the given measure.
    ///
    /// ```
    /// # use snowblue_transport::grain::{SizeMeasure, Spheroid};
    /// // A ball's volume is 4/3 π r³, its surface 4 π r².
    /// let ball = Spheroid::of_unit_size(1.0, SizeMeasure::GreatestExtension);
    /// assert!((ball.volume() - std::f64::consts::PI / 6.0).abs() < 1e-15);
    /// assert!((ball.surface() - std::f64::consts::PI).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn of_unit_size(sphericity: f64, measure: SizeMeasure) -> Self {
        let slender = Self { across: 0.5 * sphericity * sphericity, along: 0.5 };
        let size = match measure {
            SizeMeasure::GreatestExtension => 1.0,
            SizeMeasure::VolumeDiameter => (6.0 * slender.volume() / PI).cbrt(),
            SizeMeasure::OpticalDiameter => 6.0 * slender.volume() / slender.surface(),
        };
        Self { across: slender.across / size, along: slender.along / size }
    }

    /// Volume, 4/3 π a² c.
    #[must_use]
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.across * self.across * self.along
    }

    /// Surface, 2πa² (1 + (c/a) asin(e)/e), e = √(1 − a²/c²).
    #[must_use]
    pub fn surface(&self) -> f64 {
        let e = self.square_eccentricity().sqrt();
        // asin(e)/e = 1 + e²/6 + 3e⁴/40 + … near the sphere.
        let ratio = if e < 1e-2 { 1.0 + e * e / 6.0 + 3.0 * e.powi(4) / 40.0 } else { e.asin() / e };
        TAU * self.across * (self.across + self.along * ratio)
    }

    /// Mean chord 4V/S of isotropic light in the convex body.
    #[must_use]
    pub fn mean_chord(&self) -> f64 {
        4.0 * self.volume() / self.surface()
    }

    fn square_eccentricity(&self) -> f64 {
        1.0 - (self.across / self.along).powi(2)
    }

    /// Surface area per solid angle of the unit sphere at height `z`, over its greatest value a c.
    pub(crate) fn relative_area(&self, z: f64) -> f64 {
        self.square_relative_area(z).sqrt()
    }

    #[inline]
    fn square_relative_area(&self, z: f64) -> f64 {
        1.0 - self.square_eccentricity() * z * z
    }

    /// Mean of [`Spheroid::relative_area`] over the unit sphere, S/(4π a c).
    pub(crate) fn mean_relative_area(&self) -> f64 {
        self.surface() / (4.0 * PI * self.across * self.along)
    }

    /// Outward normal at a point of the unit sphere.
    #[inline]
    pub(crate) fn normal(&self, point: DVec3) -> DVec3 {
        DVec3::new(point.x / self.across, point.y / self.across, point.z / self.along).normalize()
    }

    /// The chord of a ray inside the spheroid.
    #[inline]
    pub(crate) fn chord(&self, hit: Hit) -> Chord {
        let step =
            DVec3::new(hit.direction.x / self.across, hit.direction.y / self.across, hit.direction.z / self.along);
        let length = (-2.0 * hit.point.dot(step) / step.length_squared()).max(0.0);
        Chord { length, end: renormalized(hit.point + step * length) }
    }

    /// A random hit by isotropic light: uniform over the surface, cosine-distributed about the inward normal.
    pub(crate) fn random_hit(&self, stream: &mut Stream) -> Hit {
        let z = loop {
            let z = 2.0 * stream.uniform() - 1.0;
            let uniform = stream.uniform();
            if uniform * uniform < self.square_relative_area(z) {
                break z;
            }
        };
        self.hit_at(z, [stream.uniform(), stream.uniform()])
    }

    /// The hit at height `z`, with a direction drawn from two uniform numbers.
    pub(crate) fn hit_at(&self, z: f64, uniform: [f64; 2]) -> Hit {
        let point = DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
        let (cos_phi, sin_phi) = unit_circle(uniform[1]);
        let radius = uniform[0].sqrt();
        let local = DVec3::new(radius * cos_phi, radius * sin_phi, (1.0 - uniform[0]).sqrt());
        let direction = Frame::around(-self.normal(point)).to_world(local);
        Hit { point, direction }
    }
}

/// A right-handed frame with a normal as z axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    tangent: DVec3,
    bitangent: DVec3,
    normal: DVec3,
}

impl Frame {
    #[inline]
    pub(crate) fn around(normal: DVec3) -> Self {
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        Self { tangent, bitangent, normal }
    }

    #[inline]
    pub(crate) fn to_local(self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal))
    }

    #[inline]
    pub(crate) fn to_world(self, v: DVec3) -> DVec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surface_is_exact_and_continuous_at_the_sphere() {
        let nearly = |psi| Spheroid::of_unit_size(psi, SizeMeasure::GreatestExtension).surface();
        assert!((nearly(0.999_999) / nearly(1.0) - 1.0).abs() < 1e-5);
        // a = 1, c = 2: S = 2π(1 + 2 · (π/3)/(√3/2)) = 2π + 8π²/(3√3) = 21.478.
        let spheroid = Spheroid { across: 1.0, along: 2.0 };
        assert!((spheroid.surface() - (TAU + 8.0 * PI * PI / (3.0 * 3.0_f64.sqrt()))).abs() < 1e-12);
    }

    #[test]
    fn grains_have_unit_size_by_every_measure() {
        for psi in [0.5, 0.8, 1.0] {
            let volume = Spheroid::of_unit_size(psi, SizeMeasure::VolumeDiameter);
            assert!((volume.volume() - PI / 6.0).abs() < 1e-14);
            let optical = Spheroid::of_unit_size(psi, SizeMeasure::OpticalDiameter);
            assert!((6.0 * optical.volume() / optical.surface() - 1.0).abs() < 1e-14);
        }
    }

    /// Chords of isotropic light have the mean 4V/S (Cauchy).
    #[test]
    fn mean_chord_follows_cauchy() {
        let spheroid = Spheroid { across: 0.3, along: 0.5 };
        let mut stream = Stream::new(1, 0);
        let count = 200_000;
        let lengths: Vec<f64> = (0..count).map(|_| spheroid.chord(spheroid.random_hit(&mut stream)).length).collect();
        let mean = lengths.iter().sum::<f64>() / f64::from(count);
        let variance = lengths.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / f64::from(count);
        assert!((mean - spheroid.mean_chord()).abs() < 4.0 * (variance / f64::from(count)).sqrt());
    }
}
