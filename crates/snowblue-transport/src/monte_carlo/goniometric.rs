//! Goniometric mode: how the light that leaves a slab is spread over directions.
//!
//! The bidirectional scattering distribution function (BSDF) is the radiance that leaves over the irradiance of the
//! beam, f = L/E in 1/sr: BRDF on the side of the beam, BTDF on the far side (Nicodemus et al. 1977,
//! doi:10.6028/NBS.MONO.160). A hemisphere is laid out in patches; N rays of weight w = exp(−γℓ) give the mean over a
//! patch
//!
//! ```text
//! f = Σ w / (N ∫ cosθ dω),   the sum over the rays that leave through it, the integral over it.
//! ```
//!
//! All patches have the same ∫ cosθ dω, so that a Lambertian surface sends each of them as many rays. Light that met no
//! grain leaves in one direction, where no patch can hold it: it is told apart as [`Distribution::direct`].

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::options::{check_rays, cos_incidence};
use super::rays::{estimate, trace_in_order};
use super::walk::{Absorption, Paths, Scatterers};
use crate::TransportError;
use crate::medium::{Constituents, hit_size_m};
use crate::rng::Stream;
use crate::slab::{Estimate, Incidence, Slab};

const MOST_RINGS: f64 = 1000.0;
const MOST_SECTORS: f64 = 360.0;

/// A hemisphere laid out in patches of equal ∫ cosθ dω: rings, equal in sin²θ, by sectors, equal in azimuth.
///
/// Nothing but the beam tells left from right, so that azimuths are folded to 0–180° about the plane of incidence: a
/// patch stands for its mirror image too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PatchGrid {
    /// Rings from the normal to the horizon.
    pub rings: usize,
    /// Sectors from forward (azimuth 0°) to backward (180°).
    pub sectors: usize,
}

/// How the mode works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GoniometricOptions {
    /// Rays per wavelength, thickness and direction.
    pub rays: u64,
    /// Seed of all randomness.
    pub seed: u64,
    /// The patches of either hemisphere.
    pub patches: PatchGrid,
}

/// The light that leaves through one patch of the hemisphere and its mirror image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Angle from the slab's normal, in degrees; half of the patch's ∫ cosθ dω lies on either side.
    pub theta_deg: f64,
    /// Middle azimuth, in degrees from the way that the beam travels: 0 is forward, 180 back to the source.
    pub phi_deg: f64,
    /// Solid angle, mirror image included, in sr.
    pub solid_angle_sr: f64,
    /// Mean BSDF over the patch, in 1/sr, weighted with cosθ.
    pub bsdf_per_sr: Estimate,
}

/// Where the light of one wavelength goes.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// Thickness of the slab, in cm.
    pub thickness_cm: f64,
    /// Direction of the light that comes in.
    pub incidence: Incidence,
    /// Wavelength, in nm.
    pub wavelength_nm: f64,
    /// The layout of the patches.
    pub patches: PatchGrid,
    /// BRDF, ring after ring from the normal, each from forward to backward.
    pub reflection: Vec<Patch>,
    /// BTDF in the same order, without the direct light.
    pub transmission: Vec<Patch>,
    /// Share that leaves on top.
    pub reflectance: Estimate,
    /// Share that leaves below, direct and diffuse.
    pub transmittance: Estimate,
    /// Share that passes without meeting a grain; it tends to exp(−τ/μ₀).
    pub direct: Estimate,
}

/// BRDF and BTDF for each thickness, then each incidence, then each wavelength.
///
/// `progress` is told how many of how many rays are traced, now and then.
///
/// # Errors
/// If the question, the number of rays or that of patches is out of range.
pub fn distribute(
    slab: &Slab,
    options: &GoniometricOptions,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Vec<Distribution>, TransportError> {
    slab.check()?;
    check_rays(options.rays)?;
    options.patches.check()?;
    let thicknesses = slab.thicknesses_cm.iter();
    let cases: Vec<(f64, Incidence, f64)> = thicknesses
        .flat_map(|h| slab.incidences.iter().map(move |incidence| (*h, *incidence)))
        .flat_map(|(h, incidence)| slab.wavelengths_nm.iter().map(move |nm| (h, incidence, *nm)))
        .collect();
    let all = cases.len() as u64 * options.rays;
    let mut answer = Vec::new();
    for (number, case) in (0_u64..).zip(cases) {
        let seed = Stream::key(options.seed, number);
        let seen = |done| progress(number * options.rays + done, all);
        answer.push(distribution(slab, case, &GoniometricOptions { seed, ..*options }, seen));
    }
    Ok(answer)
}

impl PatchGrid {
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

    fn check(self) -> Result<(), TransportError> {
        TransportError::check("number of rings", self.rings as f64, (1.0, MOST_RINGS), "")?;
        TransportError::check("number of sectors", self.sectors as f64, (1.0, MOST_SECTORS), "")
    }

    /// The patch that a direction belongs to.
    fn at(self, direction: Direction) -> usize {
        let sine_squared = 1.0 - direction.cosine * direction.cosine;
        let azimuth = direction.heading.y.abs().atan2(direction.heading.x);
        part(sine_squared, self.rings) * self.sectors + part(azimuth / PI, self.sectors)
    }

    fn patch(self, index: usize, bsdf_per_sr: Estimate) -> Patch {
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
    /// The BSDF in the plane of incidence: `patches`, one of the two hemispheres, from the backward horizon (angles below
    /// 0°) over the normal to the forward one, as far as the first and last sectors hold it.
    #[must_use]
    pub fn in_plane(&self, patches: &[Patch]) -> Vec<(f64, Estimate)> {
        let rings = patches.chunks_exact(self.patches.sectors);
        let backward = rings.clone().rev().map(|ring| ring[ring.len() - 1]);
        backward
            .map(|patch| (-patch.theta_deg, patch.bsdf_per_sr))
            .chain(rings.map(|ring| (ring[0].theta_deg, ring[0].bsdf_per_sr)))
            .collect()
    }
}

/// Which of `count` equal parts of 0–1 holds `share`; the last part includes 1.
fn part(share: f64, count: usize) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ share ≤ 1 and count ≤ 1000")]
    let part = (share * count as f64) as usize;
    part.min(count - 1)
}

fn distribution(
    slab: &Slab,
    (thickness_cm, incidence, wavelength_nm): (f64, Incidence, f64),
    options: &GoniometricOptions,
    progress: impl Fn(u64),
) -> Distribution {
    let met = Constituents::new(&slab.sample, wavelength_nm);
    let scatterers = Scatterers::new(&slab.sample, &met);
    let absorption = Absorption::new(&met, &scatterers);
    let optical_depth = scatterers.extinction_per_m * thickness_cm * 0.01;
    let (patches, count) = (options.patches, options.patches.count());
    // Sums of w and w² over the patches on top, then those below, then the direct light.
    let mut sums = vec![(0.0, 0.0); 2 * count + 1];
    let trace = |ray| {
        let mut stream = Stream::new(options.seed, ray);
        let exit = follow(&scatterers, optical_depth, cos_incidence(incidence, &mut stream), &mut stream);
        let bin = match exit.way {
            Way::Reflected(direction) => patches.at(direction),
            Way::Transmitted(direction) => count + patches.at(direction),
            Way::Direct => 2 * count,
        };
        (bin, absorption.left(&exit.paths))
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
    // A ray leaves once, so that the squares of a flux's rays are those of its patches.
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

/// An estimate over a quantity that is known.
fn per(divisor: f64, estimate: Estimate) -> Estimate {
    Estimate { value: estimate.value / divisor, standard_error: estimate.standard_error / divisor }
}

/// Direction of travel.
#[derive(Debug, Clone, Copy)]
struct Direction {
    /// Cosine from the normal that points into the slab.
    cosine: f64,
    /// Its horizontal part, of unit length; the beam's lies along x.
    heading: DVec2,
}

/// How a ray left, and how far it went.
struct Exit {
    way: Way,
    paths: Paths,
}

enum Way {
    Reflected(Direction),
    Transmitted(Direction),
    Direct,
}

/// Follows a ray as the spectrometric walk does, random number by random number, and keeps its azimuth too.
fn follow(scatterers: &Scatterers, optical_depth: f64, cos_incidence: f64, stream: &mut Stream) -> Exit {
    let mut direction = Direction { cosine: cos_incidence, heading: DVec2::X };
    let (mut depth, mut paths, mut scattered) = (0.0, Paths::default(), false);
    loop {
        let flight = -stream.uniform().ln();
        let next = depth + flight * direction.cosine;
        if next <= 0.0 || next >= optical_depth {
            let face = if next > 0.0 { optical_depth } else { 0.0 };
            paths.free += (face - depth) / direction.cosine;
            let way = match (next > 0.0, scattered) {
                (false, _) => Way::Reflected(direction),
                (true, true) => Way::Transmitted(direction),
                (true, false) => Way::Direct,
            };
            return Exit { way, paths };
        }
        depth = next;
        paths.free += flight;
        let met = scatterers.meet(stream);
        met.lengthen(hit_size_m(&scatterers.size, stream), &mut paths);
        direction = direction.turned(met.cos_scattering, stream);
        scattered = true;
    }
}

impl Direction {
    /// The direction after scattering through an angle Θ with a random azimuth ψ about the way it came: in the frame
    /// whose x axis is the heading, cosΘ (s, 0, c) + sinΘ cosψ (−c, 0, s) + sinΘ sinψ (0, 1, 0), with s² = 1 − c².
    fn turned(self, cos_scattering: f64, stream: &mut Stream) -> Self {
        let sine = (1.0 - self.cosine * self.cosine).max(0.0).sqrt();
        let sin_scattering = (1.0 - cos_scattering * cos_scattering).max(0.0).sqrt();
        let (sin_psi, cos_psi) = (TAU * stream.uniform()).sin_cos();
        let cosine = self.cosine * cos_scattering + sine * sin_scattering * cos_psi;
        let turn = DVec2::new(sine * cos_scattering - self.cosine * sin_scattering * cos_psi, sin_scattering * sin_psi);
        // Straight up or down any heading will do.
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
    fn turning_keeps_the_scattering_angle() {
        let mut stream = Stream::new(1, 0);
        let mut direction = Direction { cosine: 0.3, heading: DVec2::X };
        for i in 0..10_000 {
            let cos_scattering = 2.0 * stream.uniform() - 1.0;
            let next = direction.turned(cos_scattering, &mut stream);
            let found = vector(direction).dot(vector(next));
            // Sines from cosines lose half of the digits near the poles, which 10⁴ directions come close to.
            assert!((found - cos_scattering).abs() < 1e-11, "{i}: {found}, not {cos_scattering}");
            direction = next;
        }
        let down = Direction { cosine: 1.0, heading: DVec2::X };
        assert!((down.turned(0.2, &mut stream).cosine - 0.2).abs() < 1e-15);
    }

    #[test]
    fn patches_share_the_hemisphere() {
        let grid = PatchGrid { rings: 7, sectors: 5 };
        let none = Estimate { value: 0.0, standard_error: 0.0 };
        let whole: f64 = (0..grid.count()).map(|index| grid.patch(index, none).solid_angle_sr).sum();
        assert!((whole - TAU).abs() < 1e-13);
        for index in 0..grid.count() {
            let patch = grid.patch(index, none);
            let (theta, phi) = (patch.theta_deg.to_radians(), patch.phi_deg.to_radians());
            for mirrored in [phi, -phi] {
                let direction = Direction { cosine: theta.cos(), heading: DVec2::from_angle(mirrored) };
                assert_eq!(grid.at(direction), index);
                assert_eq!(grid.at(Direction { cosine: -direction.cosine, ..direction }), index);
            }
        }
        let corner = Direction { cosine: 0.0, heading: -DVec2::X };
        assert_eq!(grid.at(corner), grid.count() - 1);
    }
}
