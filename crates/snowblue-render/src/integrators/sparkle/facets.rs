//! How many facets a kind of snow shows, of which size, and how much light they mirror.
//!
//! **Number.** Facets have random orientations. A surface at the cosines μ to the eye and μ₀ to the light shows of
//! those with the normal m, per area of the surface and solid angle of m,
//!
//! ```text
//! N = b A(i)/(π a) · μ μ₀/(μ + μ₀),
//! ```
//!
//! with their mean area a, the share b of the grains' surface that is facets, and A(i) of
//! [`ExternalReflection`]: snow of the extinction κ has the surface 4κ per volume, of which the depth z shows
//! e^{−κz(1/μ + 1/μ₀)}. The density of the snow has no influence. A facet of the area a_j under the light E⊥ sends the
//! intensity F E⊥ a_j cos i g(r) into the direction r, ∫ g dΩ = 1. With dΩ_r = 4 cos i dΩ_m the mean over all facets is
//! that of the reflection function, E⊥ μ₀ b F A/(4π (μ + μ₀)).
//!
//! **Lobe.** g is a normal distribution about the mirrored middle of the light. Its variance is that of the light (a
//! quarter of its radius squared, for a disc) and that of diffraction at the facet, a disc of the diameter d that is
//! foreshortened by cos i in the plane of incidence: 0.42 λ/d fits Airy's pattern (Zhang, Zerubia & Olivo-Marin 2007,
//! doi:10.1364/AO.46.001819: 0.21 λ/NA). So variances of the brightness are right, too: ∫ g² of a normal distribution
//! is that of a disc of the same variance. Light beyond 2.5 deviations is left out, and the rest scaled up. Facets of
//! some 0.03 mm, or lamps without extent, so show colours: blue light spreads less than red light. Reflection itself
//! has none.
//!
//! **Sizes** are in proportion to those of the grains, uniform in number.

use std::f32::consts::PI;

use glam::Vec3A;
use snowblue_geometry::ray::narrow;
use snowblue_transport::medium::{ExternalReflection, facet_diameters_um};
use snowblue_transport::{SnowSample, TransportError};
use wide::f32x4;

use super::facet_field::{BandBins, Facet, FacetField, NormalRegion, Place};
use super::footprint::Footprint;
use snowblue_scene::description::SparkleDescription;
use snowblue_scene::spectrum::{SAMPLES, Spectrum};

/// Wavelengths at which light is computed; it is linear between them.
const NODES: usize = 4;
/// Deviation of the diffraction of a disc, in units of the wavelength over its diameter.
const DIFFRACTION: f32 = 0.42;
/// Deviations beyond which a lobe ends.
const CUT: f32 = 2.5;
/// Least variance of a lobe across one axis, in rad²: no facet is quite flat.
const LEAST_VARIANCE: f32 = 1e-8;
/// Wider lobes fade into smooth reflection between these deviations, in rad: nothing glints in the light of a sky.
const DEVIATIONS_RAD: [f32; 2] = [0.05, 0.1];
/// Reflection by grazed facets is smooth between these cosines of incidence.
const GRAZING_COSINES: [f32; 2] = [0.02, 0.05];
/// Between these numbers of facets that mirror the light into a pixel, sparkle fades into smooth reflection.
const CROWDED: [f32; 2] = [4.0, 16.0];
/// Most facets that mirror the light into one sample: a footprint that holds more is made smaller, and leaves them to
/// other samples of the pixel.
const PER_SAMPLE: f32 = 0.25;

/// The facets of a kind of snow.
#[derive(Debug)]
pub(super) struct Facets {
    external: ExternalReflection,
    flat_fraction: f32,
    /// Diameters of the smallest and the largest, in m.
    diameters_m: [f32; 2],
    mean_area_m2: f32,
    /// Deviation of the diffraction times the diameter, in m, at each node.
    diffraction_m: f32x4,
    seed: u64,
}

/// What a camera sample sees of a surface, in the coordinates of its object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    pub(super) place: Place,
    pub(super) footprint: Footprint,
    /// Unit normal of the plane of the footprint.
    pub(super) normal: Vec3A,
    /// From the middle of the footprint to the eye, in m.
    pub(super) to_eye_m: Vec3A,
    /// The cosine to the eye, of the normal for shading.
    pub(super) cos_exit: f32,
}

/// A light that shines on the patch, in the same coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beam {
    /// Unit vector from the middle of the footprint to the middle of the light.
    pub(super) to_light: Vec3A,
    /// Distance of the light in m; infinite for a distant one.
    pub(super) distance_m: f32,
    /// Variance of the direction of its light across one axis, in rad².
    pub(super) variance: f32,
    /// The cosine to the light, of the normal for shading.
    pub(super) cos_incidence: f32,
}

/// Light of facets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glints {
    /// L_ext per irradiance that sparkle draws, in 1/sr: less than all where it fades into smooth reflection.
    pub(super) per_sr: f32,
    /// S: the light of the facets over its mean, at each node.
    pub(super) ratio: [f32; NODES],
    /// Number of facets that contributed.
    pub(super) count: u32,
}

/// How light at the nodes counts at each wavelength.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Nodes {
    wavelengths_nm: [f32; NODES],
    /// The first of two nodes, and the weight of the second, for each wavelength.
    between: [(usize, f32); SAMPLES],
}

impl Nodes {
    /// Nodes for the wavelengths of a picture.
    pub(super) fn new(wavelengths_nm: &[f64; SAMPLES]) -> Self {
        let least = wavelengths_nm.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = wavelengths_nm.iter().copied().fold(0.0, f64::max);
        let step = ((greatest - least) / (NODES - 1) as f64).max(f64::MIN_POSITIVE);
        let between = wavelengths_nm.map(|wavelength_nm| {
            let position = (wavelength_nm - least) / step;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the nodes")]
            let first = (position as usize).min(NODES - 2);
            (first, narrow(position - first as f64))
        });
        Self { wavelengths_nm: std::array::from_fn(|node| narrow(least + node as f64 * step)), between }
    }

    /// Values at the nodes at all wavelengths.
    pub(super) fn spectrum(&self, values: [f32; NODES]) -> Spectrum {
        Spectrum(self.between.map(|(first, share)| values[first] + share * (values[first + 1] - values[first])))
    }
}

/// Lobes of a light at the facets of a patch: deviations in the plane of incidence and across it, in rad.
#[derive(Debug, Clone, Copy)]
struct Lobe {
    cos_incidence: f32,
    variance: f32,
}

impl Lobe {
    /// The deviations at a facet of a diameter, for a deviation of diffraction times the diameter.
    fn deviations(self, diffraction_m: f32, diameter_m: f32) -> [f32; 2] {
        let across = diffraction_m / diameter_m;
        [across / self.cos_incidence, across].map(|spread| (self.variance + spread * spread).sqrt())
    }
}

impl Facets {
    /// The facets of a sample, with a wavelength in its middle; none where it has none that are flat.
    ///
    /// # Errors
    ///
    /// If the tables of the sample do not cover the wavelength.
    pub(super) fn new(
        sample: &SnowSample,
        sparkle: &SparkleDescription,
        (nodes, wavelength_nm): (&Nodes, f64),
        seed: u64,
    ) -> Result<Option<Self>, TransportError> {
        let of_model = facet_diameters_um(sample);
        let middle_um = 0.5 * (of_model[0] + of_model[1]);
        let factor = match sparkle.facet_size_um {
            Some(size_um) if middle_um > 0.0 => size_um / middle_um,
            Some(_) | None => 1.0,
        };
        let diameters_um = match sparkle.facet_size_um {
            Some(size_um) if middle_um <= 0.0 => [size_um; 2],
            _ => of_model.map(|diameter_um| factor * diameter_um),
        };
        let flat_fraction = narrow(sparkle.flat_fraction);
        if diameters_um[0] <= 0.0 || flat_fraction <= 0.0 {
            return Ok(None);
        }
        let diameters_m = diameters_um.map(|diameter_um| narrow(1e-6 * diameter_um));
        let [least, greatest] = diameters_m;
        Ok(Some(Self {
            external: ExternalReflection::of_sample(sample, wavelength_nm)?,
            flat_fraction,
            diameters_m,
            mean_area_m2: 0.25 * PI * (least * least + least * greatest + greatest * greatest) / 3.0,
            diffraction_m: f32x4::from(nodes.wavelengths_nm.map(|wavelength_nm| DIFFRACTION * 1e-9 * wavelength_nm)),
            seed,
        }))
    }

    /// The light of the facets of a patch. None where reflection is smooth, and the light is that of the mean.
    pub(super) fn glints(&self, patch: &Patch, beam: &Beam, bins: &mut Vec<BandBins>) -> Option<Glints> {
        let to_eye = patch.to_eye_m.normalize();
        let middle = (to_eye + beam.to_light).normalize_or_zero();
        let cos_incidence = to_eye.dot(middle);
        let lobe = Lobe { cos_incidence, variance: beam.variance.max(LEAST_VARIANCE) };
        let [first, .., last] = self.diffraction_m.to_array();
        let [least_m, greatest_m] = self.diameters_m;
        let mean_m = 0.5 * (least_m + greatest_m);
        let widest = lobe.deviations(last, least_m);
        let usual = lobe.deviations(0.5 * (first + last), mean_m);
        let cosines = patch.cos_exit * beam.cos_incidence / (patch.cos_exit + beam.cos_incidence);
        let area_factor = narrow(self.external.area(f64::from(cos_incidence)));
        let per_m2_sr = self.flat_fraction * area_factor * cosines / (PI * self.mean_area_m2);
        let footprint = patch.footprint.around_facets(mean_m)?;
        // The solid angle of directions over which a lobe has its mean, ∫ g = 1 and ∫ g² = 1/Ω.
        let solid_angle_sr = 4.0 * PI * usual[0] * usual[1];
        let in_pixel = footprint.area_m2 * per_m2_sr * solid_angle_sr / (4.0 * cos_incidence);
        let drawn = fading(in_pixel.ln(), CROWDED.map(f32::ln))
            * fading(widest[1], DEVIATIONS_RAD)
            * (1.0 - fading(cos_incidence, GRAZING_COSINES));
        if drawn.is_nan() || drawn <= 0.0 {
            return None;
        }
        // Within the footprint, the mirrored direction turns with those to the eye and the light: by no more than a
        // deviation of the lobe.
        let turn = footprint.reach_across_m(to_eye) / patch.to_eye_m.length()
            + footprint.reach_across_m(beam.to_light) / beam.distance_m;
        let narrowest = (usual[1] / turn).min(1.0);
        let footprint = footprint.shrunk((PER_SAMPLE / in_pixel).min(narrowest * narrowest));
        let turn = 0.5 * turn * narrowest;
        let flat = footprint.flat(patch.place.axis)?;
        let across = middle.cross(to_eye).normalize_or(middle.any_orthonormal_vector());
        let region = NormalRegion {
            middle,
            side: across,
            half_widths: [(0.5 * CUT * widest[1] + turn) / cos_incidence, 0.5 * CUT * widest[0] + turn],
        };
        // Of the facets of the field, the share that is seen and lit here.
        let slope = patch.normal[patch.place.axis].abs().recip();
        let open = 2.0 * cosines * area_factor / narrow(self.external.greatest_area()) * slope / GREATEST_SLOPE;
        let mean = per_m2_sr * footprint.area_m2 * 0.25 * self.mean_area_m2;
        let (mut sum, mut count) = (f32x4::ZERO, 0);
        self.field(beam.variance).list((patch.place, &flat), (&region, open), bins, |facet| {
            if let Some(light) = self.mirrored(facet, patch, (beam, lobe), &footprint) {
                sum += light;
                count += 1;
            }
        });
        let mirrored = narrow(self.external.per_sr(-f64::from(to_eye.dot(beam.to_light))));
        let per_sr = drawn * self.flat_fraction * mirrored / (patch.cos_exit + beam.cos_incidence);
        Some(Glints { per_sr, ratio: (sum * mean.recip()).to_array(), count })
    }

    /// All facets, with bins of orientation for the lobes of a light.
    fn field(&self, variance: f32) -> FacetField {
        let [.., last] = self.diffraction_m.to_array();
        let lobe = Lobe { cos_incidence: 1.0, variance: variance.max(LEAST_VARIANCE) };
        let [deviation, _] = lobe.deviations(last, self.diameters_m[0]);
        let greatest = f64::from(self.flat_fraction) * self.external.greatest_area() * f64::from(GREATEST_SLOPE)
            / (2.0 * std::f64::consts::PI * f64::from(self.mean_area_m2));
        FacetField::new(greatest, 0.5 * CUT * deviation, self.seed)
    }

    /// a cos i g of a facet at each node, if it mirrors the light to the eye.
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
        let variance = f32x4::splat(lobe.variance);
        let diffraction = self.diffraction_m * diameter_m.recip();
        let across_variance = variance + diffraction * diffraction;
        // All facets of a size have the lobe of one in the middle, so that what they send to the eye adds up.
        let foreshortened = diffraction / lobe.cos_incidence;
        let along_variance = variance + foreshortened * foreshortened;
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

/// Greatest area of a surface per area of the plane that it faces most.
const GREATEST_SLOPE: f32 = 1.732_050_8;

/// 1 below the first value, 0 above the second, and smooth between.
fn fading(value: f32, [start, end]: [f32; 2]) -> f32 {
    let part = ((value - start) / (end - start)).clamp(0.0, 1.0);
    1.0 - part * part * (3.0 - 2.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_scene::spectrum::wavelengths_nm;
    use snowblue_transport::TruncatedNormal;

    const MRAD: f32 = 1e-3;

    /// A geometry on level snow: elevation of the light, and elevation and azimuth of the eye, in degrees, with the
    /// distance of the eye in m. The light shines from the azimuth 0.
    #[derive(Debug, Clone, Copy)]
    struct Geometry(f32, f32, f32, f32);

    const GEOMETRIES: [Geometry; 6] = [
        Geometry(50.0, 60.0, 100.0, 1.0),
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
                place: Place { point, axis: 2 },
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
        let sparkle = SparkleDescription { facet_size_um: Some(facet_size_um), flat_fraction: 0.7 };
        Facets::new(&sample, &sparkle, (&Nodes::new(&wavelengths_nm()), 550.0), 9).unwrap().unwrap()
    }

    /// Places far apart, so that their facets are independent.
    fn place(trial: u32) -> [f64; 3] {
        [0.37 * f64::from(trial % 1000), 0.53 * f64::from(trial / 1000), 0.0]
    }

    /// The mean of S over many footprints is 1 at each wavelength, for lights of every kind: within 4 standard errors,
    /// which are below 3 %.
    #[test]
    fn the_mean_of_the_facets_is_the_smooth_term() {
        let sun = 2.2 * 2.2 * MRAD * MRAD;
        let lights = [(sun, f32::INFINITY), (0.0, f32::INFINITY), (30.0 * 30.0 * MRAD * MRAD, 1.5)];
        for geometry in GEOMETRIES {
            for (size_um, (variance, distance_m)) in [(40.0, lights[0]), (200.0, lights[1]), (90.0, lights[2])] {
                let (facets, mut bins) = (facets(size_um), Vec::new());
                let beam = geometry.beam(variance, distance_m);
                // From as far as may be before facets crowd, a pixel holds most of them.
                let at = |distance_m: f32| Geometry(geometry.0, geometry.1, geometry.2, distance_m);
                let per_sr_from = |distance_m: f32, bins: &mut Vec<BandBins>| {
                    let patch = at(distance_m).patch([0.0; 3], MRAD);
                    facets.glints(&patch, &beam, bins).map(|glints| glints.per_sr)
                };
                let mut from_m = 0.01;
                let all = per_sr_from(from_m, &mut bins).unwrap();
                while per_sr_from(1.4 * from_m, &mut bins).is_some_and(|per_sr| per_sr > 0.99 * all) {
                    from_m *= 1.4;
                }
                let trials = 20_000;
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

    /// The variance of S is one over the number of facets that mirror the light into a footprint, and so is that of
    /// the light of a disc: within 4 standard errors of the variance, by the fourth moments of the sample.
    #[test]
    fn glints_have_the_variance_of_their_number() {
        let geometry = Geometry(25.0, 40.0, 60.0, 1.0);
        let (facets, mut bins) = (facets(100.0), Vec::new());
        let beam = geometry.beam(2.2 * 2.2 * MRAD * MRAD, f32::INFINITY);
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
            let [along, across] = Lobe { cos_incidence: cos, variance: beam.variance }.deviations(2.1e-7, diameter_m);
            area(diameter_m).powi(2) * f64::from(cos) / (16.0 * std::f64::consts::PI * f64::from(along * across))
        }) * kept(2.0)
            / kept(1.0).powi(2);
        let mean = 0.25 * mean_over(&area);
        let grown = patch.footprint.around_facets(1e-4).unwrap();
        let open = patch.cos_exit * beam.cos_incidence / (patch.cos_exit + beam.cos_incidence);
        let area_factor = facets.external.area(f64::from(cos));
        let per_m2_sr = 0.7 * area_factor * f64::from(open) / (std::f64::consts::PI * f64::from(facets.mean_area_m2));
        let expected = square / (mean * mean * per_m2_sr * f64::from(grown.area_m2));
        assert!((variance - expected).abs() < 4.0 * error, "{variance} ± {error}, {expected}");
        assert!(error < 0.1 * expected, "{error} {expected}");
    }

    /// Facets that are many become smooth, and so does the light of wide lamps; single ones do not.
    #[test]
    fn many_facets_and_wide_lamps_are_smooth() {
        let (geometry, facets, mut bins) = (GEOMETRIES[0], facets(100.0), Vec::new());
        let mut drawn = |pixel_rad: f32, deviation_rad: f32| {
            let beam = geometry.beam(deviation_rad * deviation_rad, f32::INFINITY);
            facets.glints(&geometry.patch([0.0; 3], pixel_rad), &beam, &mut bins).map(|glints| glints.per_sr)
        };
        assert!(drawn(500.0 * MRAD, 2.2 * MRAD).is_none() && drawn(0.1 * MRAD, 200.0 * MRAD).is_none());
        let full = drawn(0.1 * MRAD, 2.2 * MRAD).unwrap();
        // Continuous on the way.
        let (mut before, start) = (full, 5.0 * MRAD);
        for step in 0..=255_u8 {
            let next = drawn(start * 1.02_f32.powi(step.into()), 2.2 * MRAD).unwrap_or(0.0);
            assert!(next <= before * 1.0001 && before - next < 0.05 * full, "{before} {next}");
            before = next;
        }
        assert!(before < 1e-3 * full, "{before} {full}");
    }
}
