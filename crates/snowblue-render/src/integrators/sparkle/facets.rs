//! Facets of a kind of snow: their number, their sizes, and the light that they mirror.
//!
//! **Number.** Facets have random orientations. The number of facets with the normal m that are visible and lit, per
//! area of the surface and solid angle of m, at the cosines μ to the eye and μ₀ to the light, is
//!
//! ```text
//! N = s b A(i)/(π a) · μ μ₀/(μ + μ₀),
//! ```
//!
//! with the mean area a of facets, the share b of the grains' surface that is facets, and s and A(i) of
//! [`ExternalReflection`]: snow of the extinction coefficient κ, of which grains in air have the share s, has the
//! surface 4sκ of grains in air per volume. The fraction e^{−κz(1/μ + 1/μ₀)} of this surface at the depth z is
//! visible and lit. The density of the snow has no influence. A facet of the area a_j under the irradiance E⊥ sends
//! the intensity F E⊥ a_j cos i g(r) into the direction r, with ∫ g dΩ = 1. With dΩ_r = 4 cos i dΩ_m the mean over
//! all facets equals the value of the reflection function, E⊥ μ₀ s b F A/(4π (μ + μ₀)).
//!
//! **Lobe.** g is a normal distribution about the mirrored centre of the light. Its variance is the sum of the
//! variance of the light (for a disc, a quarter of its radius squared) and the variance of diffraction at the facet.
//! The facet is a disc of the diameter d, foreshortened by cos i in the plane of incidence; the deviation of
//! diffraction is 0.47 λ/d. The variance of the brightness of pixels depends on ∫ g². For equal variance, a normal
//! distribution has the ∫ g² of a disc, and with 0.47 λ/d the ∫ g² of Airy's pattern. Light beyond 2.5 deviations is
//! left out, and the rest scaled up, which adds 9 % to ∫ g². So facets of some 0.03 mm, or lamps without extent, show
//! colours: blue light spreads less than red light. Reflection itself has no colour.
//!
//! **Sizes** are proportional to the sizes of the grains, uniform in number.

use std::f32::consts::PI;

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_transport::medium::{ExternalReflection, facet_diameters_um};
use snowblue_transport::{SnowSample, TransportError};
use wide::f32x4;

use super::facet_field::{BandBins, Facet, FacetField, NormalRegion, Place};
use super::footprint::Footprint;
use snowblue_scene::description::SparkleDescription;
use snowblue_scene::spectrum::{FIRST_WAVELENGTH_NM, SAMPLES, Spectrum, WAVELENGTH_STEP_NM, wavelengths_nm};

/// Number of wavelengths at which light is computed; light is interpolated linearly between them.
const NODES: usize = 4;
/// The node whose share of grains in air gives the number of facets.
const MIDDLE: usize = 2;
/// Deviation of the normal distribution that has the ∫ g² of Airy's pattern, in units of the wavelength over the
/// diameter: (4π ∫ g² λ²/d²)^(−1/2), where ∫ g² is the integral of the square of the modulation transfer function of a
/// disc, 0.361 d²/λ².
const DIFFRACTION: f32 = 0.4695;
/// Number of deviations at which a lobe ends.
const CUT: f32 = 2.5;
/// Least variance of a lobe across one axis, in rad²: no facet is quite flat.
const MIN_VARIANCE: f32 = 1e-8;
/// Between these deviations of a lobe, in rad, sparkle fades into smooth reflection: nothing glints in the light of a
/// sky.
const DEVIATIONS_RAD: [f32; 2] = [0.05, 0.1];
/// Between these cosines of incidence, smooth reflection by grazed facets fades into sparkle.
const GRAZING_COSINES: [f32; 2] = [0.02, 0.05];
/// Between these ratios, smooth reflection by grazed facets fades into sparkle. The ratio is the cosine of incidence
/// over half of the angle, in the plane of incidence, within which normals mirror the light. Below 1 some of these
/// facets would be lit from behind: the lobe passes i = 90°.
const GRAZING_RATIOS: [f32; 2] = [1.0, 2.0];
/// Between these numbers of facets that mirror the light into a pixel, sparkle fades into smooth reflection.
const CROWDED: [f32; 2] = [4.0, 16.0];
/// Greatest mean number of facets that are listed for one sample because they may mirror the light. A footprint with
/// more facets is made smaller, and leaves them to other samples of the pixel.
const MAX_LISTED: f32 = 128.0;
/// A footprint reaches no further than this fraction of the distance to the eye and to the light, and this number of
/// cells. A longer footprint is made smaller.
const MAX_DISTANCE: f32 = 0.125;
const MAX_CELLS: f32 = 16.0;

/// The facets of a kind of snow.
#[derive(Debug)]
pub(super) struct Facets {
    /// The external reflection at each node.
    external: [ExternalReflection; NODES],
    flat_fraction: f32,
    /// Diameters of the smallest and the largest facet, in m.
    diameters_m: [f32; 2],
    mean_area_m2: f32,
    /// s b/(π a), in 1/(m² sr).
    per_m2_sr: f32,
    /// The greatest number of facets per area of the plane that a surface faces most and solid angle of their normals,
    /// in 1/(m² sr).
    greatest_per_m2_sr: f32,
    /// Deviation of the diffraction times the diameter, in m, at each node.
    diffraction_m: f32x4,
    seed: u64,
}

/// The part of a surface that a camera sample sees, in the coordinates of the object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    pub(super) place: Place,
    pub(super) footprint: Footprint,
    /// Unit normal of the plane of the footprint.
    pub(super) normal: Vec3A,
    /// From the middle of the footprint to the eye, in m.
    pub(super) to_eye_m: Vec3A,
    /// Cosine between the shading normal and the direction to the eye.
    pub(super) cos_exit: f32,
}

/// A light that shines on the patch, in the coordinates of the object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beam {
    /// Unit vector from the middle of the footprint to the middle of the light.
    pub(super) to_light: Vec3A,
    /// Distance of the light in m; infinite for a distant one.
    pub(super) distance_m: f32,
    /// Variance of the direction of its light across one axis, in rad².
    pub(super) variance: f32,
    /// Cosine between the shading normal and the direction to the light.
    pub(super) cos_incidence: f32,
}

/// Light of facets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glints {
    /// The part of L_ext per irradiance that sparkle draws, in 1/sr, at each node: less than L_ext where sparkle
    /// fades into smooth reflection.
    pub(super) per_sr: [f32; NODES],
    /// S: the light of the facets over its mean, at each node.
    pub(super) ratio: [f32; NODES],
}

/// Interpolation of light from the nodes to each wavelength.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Nodes {
    wavelengths_nm: [f64; NODES],
    /// The first of two nodes, and the weight of the second, for each wavelength.
    between: [(usize, f32); SAMPLES],
}

impl Nodes {
    /// Nodes for the wavelengths of a picture.
    pub(super) fn new() -> Self {
        let step_nm = (SAMPLES - 1) as f64 * WAVELENGTH_STEP_NM / (NODES - 1) as f64;
        let between = wavelengths_nm().map(|wavelength_nm| {
            let position = (wavelength_nm - FIRST_WAVELENGTH_NM) / step_nm;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the nodes")]
            let first = (position as usize).min(NODES - 2);
            (first, narrow(position - first as f64))
        });
        Self { wavelengths_nm: std::array::from_fn(|node| FIRST_WAVELENGTH_NM + node as f64 * step_nm), between }
    }

    /// Values at all wavelengths, from values at the nodes.
    pub(super) fn spectrum(&self, values: [f32; NODES]) -> Spectrum {
        Spectrum(self.between.map(|(first, share)| values[first] + share * (values[first + 1] - values[first])))
    }
}

/// Lobes of a light at the facets of a patch.
#[derive(Debug, Clone, Copy)]
struct Lobe {
    cos_incidence: f32,
    variance: f32,
}

impl Lobe {
    /// The variances in the plane of incidence and across it, in rad², at a facet of a diameter. `diffraction_m` is
    /// the deviation of diffraction times the diameter.
    #[inline]
    fn variances(self, diffraction_m: f32x4, diameter_m: f32) -> [f32x4; 2] {
        let across = diffraction_m * diameter_m.recip();
        [across * self.cos_incidence.recip(), across].map(|spread| spread * spread + f32x4::splat(self.variance))
    }

    /// The deviations in the plane of incidence and across it, in rad.
    fn deviations(self, diffraction_m: f32, diameter_m: f32) -> [f32; 2] {
        self.variances(f32x4::splat(diffraction_m), diameter_m).map(|variance| variance.to_array()[0].sqrt())
    }
}

impl Facets {
    /// The facets of a sample; none if the sample has no flat facets in air.
    ///
    /// # Errors
    ///
    /// If the tables of the sample do not cover the wavelengths.
    pub(super) fn new(
        sample: &SnowSample,
        sparkle: &SparkleDescription,
        nodes: &Nodes,
        seed: u64,
    ) -> Result<Option<Self>, TransportError> {
        let of_model = facet_diameters_um(sample);
        let middle_um = 0.5 * (of_model[0] + of_model[1]);
        let factor = match sparkle.facet_size_um {
            Some(size_um) if middle_um > 0.0 => size_um.get() / middle_um,
            Some(_) | None => 1.0,
        };
        let diameters_um = match sparkle.facet_size_um {
            Some(size_um) if middle_um <= 0.0 => [size_um.get(); 2],
            _ => of_model.map(|diameter_um| factor * diameter_um),
        };
        let flat_fraction = narrow(sparkle.flat_fraction.get());
        let external = ExternalReflection::at_wavelengths(sample, nodes.wavelengths_nm)?;
        let surface_share = flat_fraction * narrow(external[MIDDLE].share());
        if diameters_um[0] <= 0.0 || surface_share <= 0.0 {
            return Ok(None);
        }
        let diameters_m = diameters_um.map(|diameter_um| narrow(1e-6 * diameter_um));
        let [least, greatest] = diameters_m;
        let mean_area_m2 = 0.25 * PI * (least * least + least * greatest + greatest * greatest) / 3.0;
        let per_m2_sr = surface_share / (PI * mean_area_m2);
        // μ μ₀/(μ + μ₀) is at most 1/2.
        let greatest_per_m2_sr = 0.5 * per_m2_sr * narrow(external[MIDDLE].greatest_area()) * MAX_SLOPE;
        Ok(Some(Self {
            external,
            flat_fraction,
            diameters_m,
            mean_area_m2,
            per_m2_sr,
            greatest_per_m2_sr,
            diffraction_m: f32x4::from(
                nodes.wavelengths_nm.map(|wavelength_nm| DIFFRACTION * narrow(1e-9 * wavelength_nm)),
            ),
            seed,
        }))
    }

    /// The light of the facets of a patch; none where reflection is smooth, and the mean light applies.
    pub(super) fn glints(&self, patch: &Patch, beam: &Beam, bins: &mut Vec<BandBins>) -> Option<Glints> {
        let to_eye = patch.to_eye_m.normalize();
        let middle = (to_eye + beam.to_light).normalize_or_zero();
        let cos_incidence = to_eye.dot(middle);
        let lobe = Lobe { cos_incidence, variance: beam.variance.max(MIN_VARIANCE) };
        let [first, .., last] = self.diffraction_m.to_array();
        let [least_m, greatest_m] = self.diameters_m;
        let mean_m = 0.5 * (least_m + greatest_m);
        let widest = lobe.deviations(last, least_m);
        let mean_deviations = lobe.deviations(0.5 * (first + last), mean_m);
        let cosines = patch.cos_exit * beam.cos_incidence / (patch.cos_exit + beam.cos_incidence);
        let area_factor = narrow(self.external[MIDDLE].area(f64::from(cos_incidence)));
        let per_m2_sr = self.per_m2_sr * area_factor * cosines;
        let footprint = patch.footprint.around_facets(mean_m)?;
        // The solid angle Ω of a uniform lobe with equal ∫ g = 1 and ∫ g² = 1/Ω.
        let solid_angle_sr = 4.0 * PI * mean_deviations[0] * mean_deviations[1];
        let in_pixel = footprint.area_m2 * per_m2_sr * solid_angle_sr / (4.0 * cos_incidence);
        let drawn = fading(in_pixel.ln(), CROWDED.map(f32::ln))
            * fading(widest[1], DEVIATIONS_RAD)
            * (1.0 - fading(cos_incidence, GRAZING_COSINES))
            * (1.0 - fading(cos_incidence / (0.5 * CUT * widest[0]), GRAZING_RATIOS));
        if drawn.is_nan() || drawn <= 0.0 || in_pixel <= 0.0 {
            return None;
        }
        // Half of the extent of normals that mirror the light, across the plane of incidence and in it.
        let half_widths = [widest[1] / cos_incidence, widest[0]].map(|deviation| 0.5 * CUT * deviation);
        let listed = footprint.area_m2 * per_m2_sr * 4.0 * half_widths[0] * half_widths[1];
        let field = self.field(widest[1]);
        let nearest_m = patch.to_eye_m.length().min(beam.distance_m);
        let most_m = (MAX_DISTANCE * nearest_m).min(MAX_CELLS * narrow(field.cell_m));
        // Within the footprint, the mirrored direction turns with the directions to the eye and to the light. The
        // footprint is so small that it turns by at most one deviation of the lobe.
        let turn = footprint.reach_across_m(to_eye) / patch.to_eye_m.length()
            + footprint.reach_across_m(beam.to_light) / beam.distance_m;
        let scale = (mean_deviations[1] / turn).min(most_m / footprint.reach_m()).min(1.0);
        let share = (MAX_LISTED / listed).min(scale * scale);
        let footprint = footprint.shrunk(share);
        let turn = 0.5 * turn * share.sqrt();
        let flat = footprint.flat(patch.place.axis)?;
        let across = middle.cross(to_eye).normalize_or(middle.any_orthonormal_vector());
        let region = NormalRegion {
            middle,
            side: across,
            half_widths: [half_widths[0] + turn / cos_incidence, half_widths[1] + turn],
        };
        // The share of the facets of the field that are visible and lit here.
        let slope = patch.normal[patch.place.axis].abs().recip();
        let open_share = per_m2_sr * slope / self.greatest_per_m2_sr;
        let mean = per_m2_sr * footprint.area_m2 * 0.25 * self.mean_area_m2;
        let mut sum = f32x4::ZERO;
        field.list((patch.place, &flat), (&region, open_share), bins, |facet| {
            if let Some(light) = self.mirrored(facet, patch, (beam, lobe), &footprint) {
                sum += light;
            }
        });
        let cos_scattering = -f64::from(to_eye.dot(beam.to_light));
        let factor = drawn * self.flat_fraction / (patch.cos_exit + beam.cos_incidence);
        let per_sr = self.external.each_ref().map(|external| factor * narrow(external.per_sr(cos_scattering)));
        Some(Glints { per_sr, ratio: (sum * mean.recip()).to_array() })
    }

    /// All facets, with bins of orientation for lobes of a deviation across the plane of incidence, in rad.
    fn field(&self, deviation_rad: f32) -> FacetField {
        FacetField::new(f64::from(self.greatest_per_m2_sr), 0.5 * CUT * deviation_rad, self.seed)
    }

    /// The product a cos i g of a facet at each node, if the facet mirrors the light to the eye.
    #[inline]
    fn mirrored(
        &self,
        facet: &Facet,
        patch: &Patch,
        (beam, lobe): (&Beam, Lobe),
        footprint: &Footprint,
    ) -> Option<f32x4> {
        let offset = footprint.offset(facet.on_disc);
        let to_eye = (patch.to_eye_m - offset).normalize();
        let to_light = if beam.distance_m.is_finite() {
            (beam.to_light * beam.distance_m - offset).normalize()
        } else {
            beam.to_light
        };
        let cos_incidence = to_eye.dot(facet.normal);
        let mirrored = facet.normal * (2.0 * cos_incidence) - to_eye;
        let cos_aside = mirrored.dot(to_light);
        if cos_incidence <= 0.0 || cos_aside < 0.5 {
            return None;
        }
        let [least_m, greatest_m] = self.diameters_m;
        let diameter_m = least_m + facet.size * (greatest_m - least_m);
        // Lambert's projection, which keeps solid angles, in the plane of incidence and across it.
        let aside = (mirrored - to_light * cos_aside) * (2.0 / (1.0 + cos_aside)).sqrt();
        let across = to_light.cross(to_eye).normalize_or(to_light.any_orthonormal_vector());
        let along = across.cross(to_light);
        let [along, across] = [along, across].map(|axis| aside.dot(axis) * aside.dot(axis));
        // All facets of a size have the lobe of a facet in the middle, so that their light to the eye adds up.
        let [along_variance, across_variance] = lobe.variances(self.diffraction_m, diameter_m);
        let square = f32x4::splat(along) / along_variance + f32x4::splat(across) / across_variance;
        let is_inside = square.simd_lt(f32x4::splat(CUT * CUT));
        if !is_inside.any() {
            return None;
        }
        let kept = -(-0.5_f32 * CUT * CUT).exp_m1();
        let norm = (along_variance * across_variance).sqrt() * (2.0 * PI * kept);
        let area_m2 = 0.25 * PI * diameter_m * diameter_m;
        Some(is_inside.select((square * -0.5).exp() / norm * (area_m2 * cos_incidence), f32x4::ZERO))
    }
}

/// Greatest area of a surface per area of its projection on the coordinate plane that it faces most.
const MAX_SLOPE: f32 = 1.732_050_8;

/// 1 below the first value, 0 above the second, and smooth between.
fn fading(value: f32, [start, end]: [f32; 2]) -> f32 {
    let part = ((value - start) / (end - start)).clamp(0.0, 1.0);
    1.0 - part * part * (3.0 - 2.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_base::Number;
    use snowblue_transport::sample::GrainSize;
    use snowblue_transport::{Impurities, Substance, TruncatedNormal};

    const MRAD: f32 = 1e-3;

    /// A geometry on level snow: elevation of the light, and elevation and azimuth of the eye, in degrees, with the
    /// distance of the eye in m. The light shines from the azimuth 0.
    #[derive(Debug, Clone, Copy)]
    struct Geometry(f32, f32, f32, f32);

    const GEOMETRIES: [Geometry; 8] = [
        Geometry(50.0, 60.0, 100.0, 1.0),
        Geometry(3.0, 4.0, 180.0, 1.0),
        Geometry(8.0, 8.0, 180.0, 1.0),
        Geometry(8.0, 12.0, 180.0, 1.0),
        Geometry(20.0, 30.0, 20.0, 0.15),
        Geometry(35.0, 35.0, 0.5, 2.0),
        Geometry(60.0, 85.0, 250.0, 6.0),
        Geometry(5.0, 40.0, 140.0, 0.6),
    ];

    fn direction(elevation_deg: f32, azimuth_deg: f32) -> Vec3A {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let (y, x) = azimuth_deg.to_radians().sin_cos();
        Vec3A::new(x * cos, y * cos, sin)
    }

    impl Geometry {
        fn patch(self, point: [f64; 3], pixel_rad: f32) -> Patch {
            let Self(_, elevation_deg, azimuth_deg, distance_m) = self;
            let to_eye = direction(elevation_deg, azimuth_deg);
            let [right, up] = [to_eye.any_orthonormal_pair().0, to_eye.any_orthonormal_pair().1];
            let changes = [right * pixel_rad, up * pixel_rad];
            Patch {
                place: Place { object: 0, point, axis: 2 },
                footprint: Footprint::new(-to_eye, distance_m, changes, Vec3A::Z).unwrap(),
                normal: Vec3A::Z,
                to_eye_m: to_eye * distance_m,
                cos_exit: to_eye.z,
            }
        }

        fn beam(self, variance: f32, distance_m: f32) -> Beam {
            let to_light = direction(self.0, 0.0);
            Beam { to_light, distance_m, variance, cos_incidence: to_light.z }
        }
    }

    fn facets(facet_size_um: f64) -> Facets {
        let sample = SnowSample { facetness: TruncatedNormal::exactly(0.5), ..SnowSample::default() };
        let sparkle =
            SparkleDescription { facet_size_um: Some(Number::of(facet_size_um)), flat_fraction: Number::of(0.7) };
        Facets::new(&sample, &sparkle, &Nodes::new(), 9).unwrap().unwrap()
    }

    /// Places far apart, so that their facets are independent.
    fn place(trial: u32) -> [f64; 3] {
        [0.37 * f64::from(trial % 1000), 0.53 * f64::from(trial / 1000), 0.0]
    }

    /// The variance of the sun's direction across one axis, in rad².
    const SUN: f32 = 2.2 * 2.2 * MRAD * MRAD;

    /// The mean of S over many footprints is 1 at each wavelength, for lights of every kind: within 4 standard errors,
    /// which are below 3 %. Where the lobe would pass grazing incidence, reflection is smooth.
    #[test]
    fn the_mean_of_the_facets_is_the_smooth_term() {
        let lights = [(SUN, f32::INFINITY), (0.0, f32::INFINITY), (30.0 * 30.0 * MRAD * MRAD, 1.5)];
        for geometry in GEOMETRIES {
            for (size_um, (variance, distance_m)) in [(40.0, lights[0]), (200.0, lights[1]), (90.0, lights[2])] {
                let (facets, mut bins) = (facets(size_um), Vec::new());
                if geometry.1 < 5.0 && size_um < 100.0 {
                    let beam = geometry.beam(variance, distance_m);
                    assert!(facets.glints(&geometry.patch([0.0; 3], 0.1 * MRAD), &beam, &mut bins).is_none());
                    continue;
                }
                let beam = geometry.beam(variance, distance_m);
                // A pixel holds most facets from the greatest distance at which they do not crowd.
                let at = |distance_m: f32| Geometry(geometry.0, geometry.1, geometry.2, distance_m);
                let per_sr_from = |distance_m: f32, bins: &mut Vec<BandBins>| {
                    let patch = at(distance_m).patch([0.0; 3], MRAD);
                    facets.glints(&patch, &beam, bins).map(|glints| glints.per_sr[0])
                };
                let mut from_m = 0.01;
                let all = per_sr_from(from_m, &mut bins).unwrap();
                while per_sr_from(1.4 * from_m, &mut bins).is_some_and(|per_sr| per_sr > 0.99 * all) {
                    from_m *= 1.4;
                }
                let trials = 10_000;
                let (mut sums, mut squares) = ([0.0; NODES], [0.0; NODES]);
                for trial in 0..trials {
                    let patch = at(from_m).patch(place(trial), MRAD);
                    let Some(glints) = facets.glints(&patch, &beam, &mut bins) else {
                        panic!("{geometry:?} is smooth")
                    };
                    for (node, ratio) in glints.ratio.into_iter().enumerate() {
                        sums[node] += f64::from(ratio);
                        squares[node] += f64::from(ratio * ratio);
                    }
                }
                let count = f64::from(trials);
                for (sum, square) in sums.into_iter().zip(squares) {
                    let mean = sum / count;
                    let error = ((square / count - mean * mean) / count).sqrt();
                    assert!((mean - 1.0).abs() < 4.0 * error, "{geometry:?} {size_um}: {mean} ± {error}");
                    assert!(error < 0.03, "{geometry:?} {size_um}: {error}");
                }
            }
        }
    }

    /// The variance of S is one over the number of facets that mirror the light into a footprint, and so is the
    /// variance of the light of a disc: within 4 standard errors of the variance, by the fourth moments of the
    /// sample.
    #[test]
    fn glints_have_the_variance_of_their_number() {
        let geometry = Geometry(25.0, 40.0, 60.0, 1.0);
        let (facets, mut bins) = (facets(100.0), Vec::new());
        let beam = geometry.beam(SUN, f32::INFINITY);
        let pixel_rad = 3.0 * MRAD;
        let trials = 800_000;
        let ratio = |trial: u32, bins: &mut Vec<BandBins>| {
            let glints = facets.glints(&geometry.patch(place(trial), pixel_rad), &beam, bins).unwrap();
            f64::from(glints.ratio[1])
        };
        let deviations: Vec<f64> = (0..trials).map(|trial| (ratio(trial, &mut bins) - 1.0).powi(2)).collect();
        let count = f64::from(trials);
        let variance = deviations.iter().sum::<f64>() / count;
        let error = (deviations.iter().map(|square| (square - variance).powi(2)).sum::<f64>() / count / count).sqrt();
        // The number that the docs state, with diameters of 87–112 µm and a wavelength of 500 nm.
        let patch = geometry.patch([0.0; 3], pixel_rad);
        let middle = (patch.to_eye_m.normalize() + beam.to_light).normalize();
        let cos = patch.to_eye_m.normalize().dot(middle);
        let steps = 200;
        let mean_over = |of: &dyn Fn(f32) -> f64| {
            let size = |step: i32| {
                facets.diameters_m[0]
                    + (step as f32 + 0.5) / steps as f32 * (facets.diameters_m[1] - facets.diameters_m[0])
            };
            (0..steps).map(|step| of(size(step))).sum::<f64>() / f64::from(steps)
        };
        let area = |diameter_m: f32| f64::from(0.25 * PI * diameter_m * diameter_m);
        // E Σ w² / (E Σ w)², with ∫ (a cos i g)² dΩ_m = a² cos i/(16π σσ′) and the lobe's ends cut off.
        let kept = |power: f64| -(-0.5 * power * f64::from(CUT * CUT)).exp_m1();
        let square = mean_over(&|diameter_m| {
            let [along, across] =
                Lobe { cos_incidence: cos, variance: beam.variance }.deviations(DIFFRACTION * 5e-7, diameter_m);
            area(diameter_m).powi(2) * f64::from(cos) / (16.0 * std::f64::consts::PI * f64::from(along * across))
        }) * kept(2.0)
            / kept(1.0).powi(2);
        let mean = 0.25 * mean_over(&area);
        let grown = patch.footprint.around_facets(1e-4).unwrap();
        let open = patch.cos_exit * beam.cos_incidence / (patch.cos_exit + beam.cos_incidence);
        let area_factor = facets.external[MIDDLE].area(f64::from(cos));
        let per_m2_sr = 0.7 * area_factor * f64::from(open) / (std::f64::consts::PI * f64::from(facets.mean_area_m2));
        let expected = square / (mean * mean * per_m2_sr * f64::from(grown.area_m2));
        assert!((variance - expected).abs() < 4.0 * error, "{variance} ± {error}, {expected}");
        assert!(error < 0.1 * expected, "{error} {expected}");
    }

    /// The greatest brightness of a facet of a diameter in the sun, per irradiance of the surface, in 1/sr:
    /// F a cos i g/(μ μ₀ A) with g of the middle of the lobe.
    fn greatest_per_sr(geometry: Geometry, pixel_rad: f32, diameter_m: f32, wavelength_nm: f32) -> f64 {
        let patch = geometry.patch([0.0; 3], pixel_rad);
        let to_eye = patch.to_eye_m.normalize();
        let to_light = geometry.beam(SUN, f32::INFINITY).to_light;
        let cos = to_eye.dot((to_eye + to_light).normalize());
        let lobe = Lobe { cos_incidence: cos, variance: SUN };
        let [along, across] = lobe.deviations(DIFFRACTION * 1e-9 * wavelength_nm, diameter_m);
        let kept = 1.0 - (-3.125_f32).exp();
        let area_m2 = 0.25 * PI * diameter_m * diameter_m;
        let peak = area_m2 * cos / (2.0 * PI * along * across * kept);
        let footprint_m2 = patch.footprint.around_facets(diameter_m).unwrap().area_m2;
        fresnel_of_ice(f64::from(cos)) * f64::from(peak / (to_eye.z * to_light.z * footprint_m2))
    }

    /// The brightness of a glint over the brightness of white snow, 1/π, is as the documentation states, within a
    /// quarter.
    #[test]
    fn glints_are_as_bright_as_the_documentation_says() {
        let geometry = Geometry(30.0, 40.0, 80.0, 1.0);
        for (diameter_m, stated) in [(130e-6, 25.0), (1e-3, 2000.0)] {
            let times = std::f64::consts::PI * greatest_per_sr(geometry, MRAD, diameter_m, 550.0);
            assert!((times / stated - 1.0_f64).abs() < 0.25, "{diameter_m}: {times}");
        }
    }

    /// A glint is one facet of a grain, whatever else is in the snow. Where r² of facets is uniform up to 2.5², and g
    /// falls as e^{−r²/2}, the brightest of n is fainter than the middle of the lobe by e^{−3.125 x} with the
    /// probability (1 − x)^n: by a tenth with 10⁻⁴ for n = 300. The reflectance is known to 0.3 %, by four digits of
    /// the index. Water and dust hide grains, and so change the number of glints: within 4 standard errors.
    #[test]
    fn the_brightness_of_a_glint_is_that_of_a_facet() {
        let geometry = Geometry(25.0, 40.0, 60.0, 1.0);
        let beam = geometry.beam(SUN, f32::INFINITY);
        let dry = SnowSample {
            facetness: TruncatedNormal::exactly(0.5),
            grain_size: GrainSize { min_um: 400.0, max_um: 400.0, ..SnowSample::default().grain_size },
            ..SnowSample::default()
        };
        let wet = SnowSample { water_saturation: 0.5, ..dry };
        let dusty = SnowSample { impurities: Impurities::none().with(Substance::SAHARAN_DUST, 1e7), ..dry };
        for (sample, shares) in [(dry, 0.999..1.001), (wet, 0.3..0.7), (dusty, 0.3..0.97)] {
            let (size_um, flat_fraction, pixel_rad) = (100.0, 0.7, MRAD);
            let sparkle = SparkleDescription {
                facet_size_um: Some(Number::of(size_um)),
                flat_fraction: Number::of(flat_fraction),
            };
            let nodes = Nodes::new();
            let facets = Facets::new(&sample, &sparkle, &nodes, 3).unwrap().unwrap();
            let share = facets.external[MIDDLE].share();
            assert!(shares.contains(&share), "{share}");
            let patch = geometry.patch([0.0; 3], pixel_rad);
            let to_eye = patch.to_eye_m.normalize();
            let cos = f64::from(to_eye.dot((to_eye + beam.to_light).normalize()));
            let [cos_exit, cos_light] = [patch.cos_exit, beam.cos_incidence].map(f64::from);
            let footprint_m2 = f64::from(patch.footprint.around_facets(1e-4).unwrap().area_m2);
            let pi = std::f64::consts::PI;
            let area_m2 = 0.25 * pi * 1e-8;
            // The lobe at 700 nm.
            let lobe = Lobe { cos_incidence: narrow(cos), variance: SUN };
            let [along, across] = lobe.deviations(DIFFRACTION * 7e-7, 1e-4).map(f64::from);
            let greatest = greatest_per_sr(geometry, pixel_rad, 1e-4, 700.0);
            let trials: u32 = 1_000_000;
            let (mut brightest, mut count, mut bins) = (0.0_f64, 0, Vec::new());
            for trial in 0..trials {
                let glints = facets.glints(&geometry.patch(place(trial), pixel_rad), &beam, &mut bins).unwrap();
                let radiance = f64::from(glints.per_sr[NODES - 1] * glints.ratio[NODES - 1]);
                brightest = brightest.max(radiance);
                count += i32::from(radiance > 0.0);
            }
            let ratio = brightest / greatest;
            assert!((0.9..1.003).contains(&ratio), "{share}: {ratio} of {greatest}");
            // Facets with a normal within the lobe: dΩ_r = 4 cos i dΩ_m.
            let solid_angle = pi * f64::from(CUT * CUT) * along * across / (4.0 * cos);
            let open = facets.external[MIDDLE].area(cos) * cos_exit * cos_light / (cos_exit + cos_light);
            let number = share * f64::from(narrow(flat_fraction)) / (pi * area_m2) * open * solid_angle * footprint_m2;
            let hit = -(-number).exp_m1();
            let [found, expected] = [f64::from(count), f64::from(trials) * hit];
            assert!((found - expected).abs() < 4.0 * expected.sqrt() && found > 300.0, "{share}: {found} {expected}");
        }
    }

    /// Fresnel's reflectance of unpolarised light by ice at 700 nm (Warren & Brandt 2008).
    fn fresnel_of_ice(cos: f64) -> f64 {
        let index: f64 = 1.3069;
        let inside = (1.0 - (1.0 - cos * cos) / (index * index)).sqrt();
        let [across, along] =
            [(cos - index * inside) / (cos + index * inside), (index * cos - inside) / (index * cos + inside)];
        0.5 * (across * across + along * along)
    }

    /// The deviation of the lobe of diffraction keeps ∫ g² of Airy's pattern, by the modulation transfer function of a
    /// disc, 2/π (arccos s − s √(1 − s²)) (Goodman 2005, *Introduction to Fourier Optics*, section 6.3).
    #[test]
    fn diffraction_keeps_the_square_of_airys_pattern() {
        let steps = 10_000;
        let square = |step: i32| {
            let s = (f64::from(step) + 0.5) / f64::from(steps);
            let transfer = std::f64::consts::FRAC_2_PI * (s.acos() - s * (1.0 - s * s).sqrt());
            2.0 * std::f64::consts::PI * s * transfer * transfer / f64::from(steps)
        };
        let airy: f64 = (0..steps).map(square).sum();
        let normal = 1.0 / (4.0 * std::f64::consts::PI * f64::from(DIFFRACTION).powi(2));
        // Four digits of the constant.
        assert!((normal / airy - 1.0).abs() < 3e-4, "{normal} {airy}");
    }

    /// Many facets, and wide lamps, give smooth reflection; single facets do not.
    #[test]
    fn many_facets_and_wide_lamps_are_smooth() {
        let (geometry, facets, mut bins) = (GEOMETRIES[0], facets(100.0), Vec::new());
        let mut drawn = |pixel_rad: f32, deviation_rad: f32| {
            let beam = geometry.beam(deviation_rad * deviation_rad, f32::INFINITY);
            facets.glints(&geometry.patch([0.0; 3], pixel_rad), &beam, &mut bins).map(|glints| glints.per_sr[0])
        };
        assert!(drawn(500.0 * MRAD, 2.2 * MRAD).is_none() && drawn(0.1 * MRAD, 200.0 * MRAD).is_none());
        let full = drawn(0.1 * MRAD, 2.2 * MRAD).unwrap();
        // Continuous on the way: a pixel that is wider by 2 % holds 1.02² times the facets. The fading is over the
        // logarithm of their number, with a slope of at most 3/2 of its range.
        let (mut before, start) = (full, 5.0 * MRAD);
        let most = 1.5 * 2.0 * 1.02_f32.ln() / (CROWDED[1] / CROWDED[0]).ln();
        for step in 0..=255_u8 {
            let next = drawn(start * 1.02_f32.powi(step.into()), 2.2 * MRAD).unwrap_or(0.0);
            assert!(next <= before * 1.0001 && before - next < 1.001 * most * full, "{before} {next}");
            before = next;
        }
        assert!(before < 1e-3 * full, "{before} {full}");
    }
}
