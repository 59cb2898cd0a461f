//! Goniometric mode: the distribution over directions of the light that leaves a slab.
//!
//! The bidirectional scattering distribution function (BSDF) is the radiance that leaves over the irradiance of the
//! beam, f = L/E in 1/sr: BRDF on the side of the beam, BTDF on the far side (Nicodemus et al. 1977,
//! doi:10.6028/NBS.MONO.160). A hemisphere is divided into patches; N rays of weight w = exp(−γℓ) give the mean over a
//! patch
//!
//! ```text
//! f = Σ w / (N ∫ cosθ dω),   the sum over the rays that leave through the patch, the integral over the patch.
//! ```
//!
//! All patches have equal ∫ cosθ dω, so a Lambertian surface sends equal numbers of rays to all patches. Unscattered
//! light leaves in a single direction; [`Distribution::direct`] holds it.

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use snowblue_base::{ParameterRange, RangeError};

use super::rays::{RayProgress, check_rays, cos_incidence, estimate, trace_in_order};
use super::walk::{Absorption, Paths, Scatterers};
use crate::TransportError;
use crate::medium::{Constituents, hit_size_m};
use crate::rng::Stream;
use crate::slab::{Estimate, Incidence, Slab};

const RING_RANGE: ParameterRange =
    ParameterRange { quantity: "number of rings", least: 1.0, greatest: 1000.0, unit: "" };
const SECTOR_RANGE: ParameterRange =
    ParameterRange { quantity: "number of sectors", least: 1.0, greatest: 360.0, unit: "" };

/// A hemisphere divided into patches of equal ∫ cosθ dω: rings, equal in sin²θ, by sectors, equal in azimuth.
///
/// The distribution is symmetric about the plane of incidence, so azimuths are folded to 0–180°: a patch includes its
/// mirror image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PatchGrid {
    /// Rings from the normal to the horizon.
    pub rings: usize,
    /// Sectors from forward (azimuth 0°) to backward (180°).
    pub sectors: usize,
}

/// Options of the goniometric mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GoniometricOptions {
    /// Rays per wavelength, thickness and direction.
    pub rays: u64,
    /// Seed of all randomness.
    pub seed: u64,
    /// Patches of each hemisphere.
    pub patches: PatchGrid,
}

/// Light that leaves through a patch of the hemisphere and its mirror image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Angle from the slab's normal, in degrees; half of the patch's ∫ cosθ dω lies on either side.
    pub theta_deg: f64,
    /// Central azimuth, in degrees from the beam's direction of travel: 0 is forward, 180 is back to the source.
    pub phi_deg: f64,
    /// Solid angle, mirror image included, in sr.
    pub solid_angle_sr: f64,
    /// Mean BSDF over the patch, in 1/sr, weighted with cosθ.
    pub bsdf_per_sr: Estimate,
}

/// The BSDF at one angle in the plane of incidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanePoint {
    /// Angle from the slab's normal, in degrees; negative on the side that the beam comes from.
    pub theta_deg: f64,
    /// BSDF, in 1/sr.
    pub bsdf_per_sr: Estimate,
}

/// Distribution over directions of the light that leaves a slab, at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// Thickness of the slab, in cm.
    pub thickness_cm: f64,
    /// Incident light.
    pub incidence: Incidence,
    /// Wavelength, in nm.
    pub wavelength_nm: f64,
    /// Layout of the patches.
    pub patches: PatchGrid,
    /// BRDF, ring by ring from the normal, each from forward to backward.
    pub reflection: Vec<Patch>,
    /// BTDF in the order of the BRDF, without the direct light.
    pub transmission: Vec<Patch>,
    /// Fraction that leaves the top.
    pub reflectance: Estimate,
    /// Fraction that leaves the bottom, direct and diffuse.
    pub transmittance: Estimate,
    /// Fraction that is transmitted unscattered; its expectation is exp(−τ/μ₀).
    pub direct: Estimate,
}

/// BRDF and BTDF for each thickness, then each incidence, then each wavelength.
///
/// `progress` is called from time to time with the number of rays traced.
///
/// # Errors
/// If a parameter, the number of rays or the number of patches is out of range.
pub fn distribute(
    slab: &Slab,
    options: &GoniometricOptions,
    progress: &(dyn Fn(RayProgress) + Sync),
) -> Result<Vec<Distribution>, TransportError> {
    slab.check_finite()?;
    check_rays(options.rays)?;
    options.patches.check()?;
    let thicknesses = slab.thicknesses_cm.iter();
    let cases: Vec<Case> = thicknesses
        .flat_map(|thickness_cm| slab.incidences.iter().map(move |incidence| (*thickness_cm, *incidence)))
        .flat_map(|(thickness_cm, incidence)| {
            let case = move |wavelength_nm: &f64| Case { thickness_cm, incidence, wavelength_nm: *wavelength_nm };
            slab.wavelengths_nm.iter().map(case)
        })
        .collect();
    let total = cases.len() as u64 * options.rays;
    let mut distributions = Vec::new();
    for (number, case) in (0_u64..).zip(cases) {
        let seed = Stream::key(options.seed, number);
        let report = |traced| progress(RayProgress { traced: number * options.rays + traced, total });
        distributions.push(distribution(slab, case, &GoniometricOptions { seed, ..*options }, report));
    }
    Ok(distributions)
}

impl PatchGrid {
    /// The default for some light: a single sector if the azimuth does not matter, at 0° and for diffuse light.
    #[must_use]
    pub fn for_incidence(incidence: Incidence) -> Self {
        let axisymmetric = matches!(incidence, Incidence::Diffuse) || incidence == Incidence::Beam { angle_deg: 0.0 };
        let default = Self::default();
        if axisymmetric { Self { sectors: 1, ..default } } else { default }
    }

    /// Number of patches of a hemisphere.
    #[must_use]
    pub fn count(self) -> usize {
        self.rings * self.sectors
    }

    /// ∫ cosθ dω over a patch and its mirror image, in sr: an equal part of the hemisphere's π.
    #[must_use]
    pub fn projected_solid_angle_sr(self) -> f64 {
        PI / self.count() as f64
    }

    pub(crate) fn check(self) -> Result<(), RangeError> {
        RING_RANGE.check(self.rings as f64)?;
        SECTOR_RANGE.check(self.sectors as f64)
    }

    /// The patch that a direction belongs to.
    fn index(self, direction: Direction) -> usize {
        let sine_squared = 1.0 - direction.cosine * direction.cosine;
        let azimuth = direction.heading.y.abs().atan2(direction.heading.x);
        part(sine_squared, self.rings) * self.sectors + part(azimuth / PI, self.sectors)
    }

    /// Angles from the normal, `per_ring` in each ring at equal steps of sin²θ, and azimuths, `per_sector` in each
    /// sector, in degrees.
    pub(crate) fn directions_deg(self, per_ring: usize, per_sector: usize) -> (Vec<f64>, Vec<f64>) {
        let middles = |count: usize| (0..count).map(move |step| (step as f64 + 0.5) / count as f64);
        let zeniths = middles(self.rings * per_ring).map(|square: f64| square.sqrt().asin().to_degrees());
        (zeniths.collect(), middles(self.sectors * per_sector).map(|part| 180.0 * part).collect())
    }

    pub(crate) fn patch(self, index: usize, bsdf_per_sr: Estimate) -> Patch {
        let (ring, sector) = ((index / self.sectors) as f64, (index % self.sectors) as f64);
        let (rings, sectors) = (self.rings as f64, self.sectors as f64);
        let cosine = |ring: f64| (1.0 - ring / rings).sqrt();
        Patch {
            theta_deg: ((ring + 0.5) / rings).sqrt().asin().to_degrees(),
            phi_deg: 180.0 * (sector + 0.5) / sectors,
            solid_angle_sr: TAU / sectors * (cosine(ring) - cosine(ring + 1.0)),
            bsdf_per_sr,
        }
    }
}

impl Default for PatchGrid {
    /// 10 rings, the first to 18°, the last from 72°, by 12 sectors of 15°.
    fn default() -> Self {
        Self { rings: 10, sectors: 12 }
    }
}

impl Distribution {
    /// The BSDF near the plane of incidence, in the first and last sectors of `patches`, one of the two hemispheres:
    /// from the backward horizon (angles below 0°) over the normal to the forward horizon.
    #[must_use]
    pub fn in_plane(&self, patches: &[Patch]) -> Vec<PlanePoint> {
        let rings = patches.chunks_exact(self.patches.sectors);
        let point =
            |sign: f64, patch: &Patch| PlanePoint { theta_deg: sign * patch.theta_deg, bsdf_per_sr: patch.bsdf_per_sr };
        let backward = rings.clone().rev().map(|ring| point(-1.0, &ring[ring.len() - 1]));
        backward.chain(rings.map(|ring| point(1.0, &ring[0]))).collect()
    }
}

/// Index of the one of `count` equal parts of 0–1 that holds `fraction`; the last part includes 1.
fn part(fraction: f64, count: usize) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ fraction ≤ 1 and count ≤ 1000")]
    let part = (fraction * count as f64) as usize;
    part.min(count - 1)
}

/// One slab under one light.
#[derive(Clone, Copy)]
struct Case {
    thickness_cm: f64,
    incidence: Incidence,
    wavelength_nm: f64,
}

fn distribution(
    slab: &Slab,
    Case { thickness_cm, incidence, wavelength_nm }: Case,
    options: &GoniometricOptions,
    progress: impl Fn(u64),
) -> Distribution {
    let constituents = Constituents::new(&slab.sample, wavelength_nm);
    let scatterers = Scatterers::new(&slab.sample, &constituents);
    let absorption = Absorption::new(&constituents, &scatterers);
    let optical_depth = scatterers.extinction_per_m * thickness_cm * 0.01;
    let (patches, count) = (options.patches, options.patches.count());
    // Sums of w and w² for the patches above, the patches below, and the direct light.
    let mut sums = vec![(0.0, 0.0); 2 * count + 1];
    let trace = |ray| {
        let mut stream = Stream::new(options.seed, ray);
        let (exit, paths) = trace_ray(&scatterers, optical_depth, cos_incidence(incidence, &mut stream), &mut stream);
        let bin = match exit {
            Exit::Reflected(direction) => patches.index(direction),
            Exit::Transmitted(direction) => count + patches.index(direction),
            Exit::Direct => 2 * count,
        };
        (bin, absorption.transmittance(&paths))
    };
    let mut done = 0;
    trace_in_order(options.rays, trace, |block| {
        for &(bin, weight) in block {
            sums[bin].0 += weight;
            sums[bin].1 += weight * weight;
        }
        done += block.len() as u64;
        progress(done);
    });
    // A ray leaves through one patch only, so the sum of squares of a flux is the sum over its patches.
    let flux = |part: &[(f64, f64)]| {
        let (first, second) = part.iter().fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
        estimate(first, second, options.rays)
    };
    let hemisphere = |part: &[(f64, f64)]| -> Vec<Patch> {
        let spread = |sum: &(f64, f64)| per(patches.projected_solid_angle_sr(), flux(&[*sum]));
        part.iter().map(spread).enumerate().map(|(index, bsdf)| patches.patch(index, bsdf)).collect()
    };
    Distribution {
        thickness_cm,
        incidence,
        wavelength_nm,
        patches,
        reflection: hemisphere(&sums[..count]),
        transmission: hemisphere(&sums[count..2 * count]),
        reflectance: flux(&sums[..count]),
        transmittance: flux(&sums[count..]),
        direct: flux(&sums[2 * count..]),
    }
}

/// An estimate divided by an exact number.
fn per(divisor: f64, estimate: Estimate) -> Estimate {
    Estimate { value: estimate.value / divisor, standard_error: estimate.standard_error / divisor }
}

/// Direction of travel.
#[derive(Debug, Clone, Copy)]
struct Direction {
    /// Cosine from the normal that points into the slab.
    cosine: f64,
    /// Horizontal direction, of unit length; the beam's is the x axis.
    heading: DVec2,
}

/// How a ray leaves the slab.
enum Exit {
    /// From the top.
    Reflected(Direction),
    /// From the bottom, scattered.
    Transmitted(Direction),
    /// From the bottom, unscattered.
    Direct,
}

/// Traces a ray until it leaves. The ray draws the random numbers of [`walk`](super::walk::walk), and its azimuth is
/// tracked too.
fn trace_ray(scatterers: &Scatterers, optical_depth: f64, cos_incidence: f64, stream: &mut Stream) -> (Exit, Paths) {
    let mut direction = Direction { cosine: cos_incidence, heading: DVec2::X };
    let (mut depth, mut paths, mut scattered) = (0.0, Paths::default(), false);
    loop {
        let flight = -stream.uniform().ln();
        let next = depth + flight * direction.cosine;
        if next <= 0.0 || next >= optical_depth {
            let face = if next > 0.0 { optical_depth } else { 0.0 };
            paths.free += (face - depth) / direction.cosine;
            let exit = match (next > 0.0, scattered) {
                (false, _) => Exit::Reflected(direction),
                (true, true) => Exit::Transmitted(direction),
                (true, false) => Exit::Direct,
            };
            return (exit, paths);
        }
        depth = next;
        paths.free += flight;
        let collision = scatterers.collide(stream);
        collision.add_ice_path(hit_size_m(&scatterers.size, stream), &mut paths);
        direction = direction.scattered(collision.cos_scattering, stream);
        scattered = true;
    }
}

impl Direction {
    /// The direction after scattering by an angle Θ with a random azimuth ψ about the direction of travel: in the frame
    /// with the heading as x axis, cosΘ (s, 0, c) + sinΘ cosψ (−c, 0, s) + sinΘ sinψ (0, 1, 0), with s² = 1 − c².
    fn scattered(self, cos_scattering: f64, stream: &mut Stream) -> Self {
        let sine = (1.0 - self.cosine * self.cosine).max(0.0).sqrt();
        let sin_scattering = (1.0 - cos_scattering * cos_scattering).max(0.0).sqrt();
        let (sin_psi, cos_psi) = (TAU * stream.uniform()).sin_cos();
        let cosine = self.cosine * cos_scattering + sine * sin_scattering * cos_psi;
        let turn = DVec2::new(sine * cos_scattering - self.cosine * sin_scattering * cos_psi, sin_scattering * sin_psi);
        // Straight up or down, any heading serves.
        let heading = self.heading.rotate(turn.normalize_or(DVec2::X)).normalize();
        Self { cosine: cosine.clamp(-1.0, 1.0), heading }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn vector(direction: Direction) -> DVec3 {
        let sine = (1.0 - direction.cosine * direction.cosine).sqrt();
        (direction.heading * sine).extend(direction.cosine)
    }

    #[test]
    fn directions_differ_by_the_scattering_angle() {
        let mut stream = Stream::new(1, 0);
        let mut direction = Direction { cosine: 0.3, heading: DVec2::X };
        for i in 0..10_000 {
            let cos_scattering = 2.0 * stream.uniform() - 1.0;
            let next = direction.scattered(cos_scattering, &mut stream);
            let found = vector(direction).dot(vector(next));
            // Sines from cosines lose half of the digits near the poles, and some of 10⁴ directions come close to them.
            assert!((found - cos_scattering).abs() < 1e-11, "{i}: {found}, not {cos_scattering}");
            direction = next;
        }
        let down = Direction { cosine: 1.0, heading: DVec2::X };
        assert!((down.scattered(0.2, &mut stream).cosine - 0.2).abs() < 1e-15);
    }

    #[test]
    fn patches_cover_the_hemisphere() {
        let grid = PatchGrid { rings: 7, sectors: 5 };
        let none = Estimate { value: 0.0, standard_error: 0.0 };
        let whole: f64 = (0..grid.count()).map(|index| grid.patch(index, none).solid_angle_sr).sum();
        assert!((whole - TAU).abs() < 1e-13);
        for index in 0..grid.count() {
            let patch = grid.patch(index, none);
            let (theta, phi) = (patch.theta_deg.to_radians(), patch.phi_deg.to_radians());
            for mirrored in [phi, -phi] {
                let direction = Direction { cosine: theta.cos(), heading: DVec2::from_angle(mirrored) };
                assert_eq!(grid.index(direction), index);
                assert_eq!(grid.index(Direction { cosine: -direction.cosine, ..direction }), index);
            }
        }
        let corner = Direction { cosine: 0.0, heading: -DVec2::X };
        assert_eq!(grid.index(corner), grid.count() - 1);
    }
}
