//! The sun: a disc at infinity that is darker towards its limb.

use std::f32::consts::{PI, TAU};

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_geometry::ray::Ray;
use snowblue_sky::{ClearSky, SUN_RADIUS_RAD, limb_darkening_at_nodes};

use crate::light::dome::Resampling;
use crate::light::emitter::{Emitter, LightType};
use crate::light::sample::LightOrigin;
use crate::spectrum::Spectrum;

/// Number of steps of the profile in the cosine at the sun's surface. Linear interpolation between the steps has an
/// error of some 10⁻⁴.
const STEPS: u8 = 32;

/// Directions are sampled with a density proportional to 1 − u + u μ, with the cosine μ at the sun's surface. This
/// linear limb darkening is near the limb darkening of the luminance (Cox 2000, "Allen's Astrophysical Quantities",
/// section 14.7).
const LIMB_DARKENING: f32 = 0.6;

/// Variance of the light's direction across one axis, divided by sin² of the disc's radius: ½∫ r² L dr²/∫ L dr² with
/// L = 1 − u + u μ and r² = 1 − μ². Without the limb darkening u it is ¼.
const VARIANCE: f32 = 0.5 * (0.5 * (1.0 - LIMB_DARKENING) + 4.0 / 15.0 * LIMB_DARKENING) / (1.0 - LIMB_DARKENING / 3.0);

/// The variance of the direction of the sun's light across one axis, in rad².
pub(super) fn angular_variance() -> f32 {
    let radius_rad = narrow(SUN_RADIUS_RAD);
    VARIANCE * radius_rad * radius_rad
}

/// The sun.
#[derive(Debug)]
pub(crate) struct SunDisc {
    /// Unit direction from the scene towards its centre.
    to_sun: Vec3A,
    /// Radiance in W m⁻² sr⁻¹, as a band density, by the cosine at the sun's surface, from the limb to the centre.
    profile: Vec<Spectrum>,
    sin_squared_radius: f32,
}

impl SunDisc {
    /// The sun of a sky in a unit direction.
    pub(crate) fn new(sky: &ClearSky, to_sun: Vec3A, resampling: &Resampling) -> Self {
        let sin_radius = SUN_RADIUS_RAD.sin();
        let centre = sky.sun_centre_at_nodes(sky.sun_elevation_deg().to_radians().sin());
        let radiance = |step: u8| {
            let cos = f64::from(step) / f64::from(STEPS);
            let darkening = limb_darkening_at_nodes((1.0 - cos * cos).sqrt() * sin_radius);
            resampling.spectrum(&std::array::from_fn(|node| centre[node] * darkening[node]))
        };
        let sin_radius = narrow(sin_radius);
        Self { to_sun, profile: (0..=STEPS).map(radiance).collect(), sin_squared_radius: sin_radius * sin_radius }
    }

    /// Cosine of the angle at the sun's surface between its normal and the direction towards the scene; none outside
    /// the disc.
    fn cos_at_surface(&self, direction: Vec3A) -> Option<f32> {
        // The cross product is accurate where the cosine of the angle to the centre is not.
        let sin_squared = direction.cross(self.to_sun).length_squared();
        // Sampled directions lie within the disc up to rounding.
        let squared = 1.0 - sin_squared / self.sin_squared_radius;
        (squared > -1e-3 && direction.dot(self.to_sun) > 0.0).then(|| squared.max(0.0).sqrt())
    }
}

impl Emitter for SunDisc {
    fn name(&self) -> &'static str {
        "sun"
    }

    fn light_type(&self) -> LightType {
        LightType::Disc(self.to_sun)
    }

    fn uniform(&self) -> Option<&Spectrum> {
        None
    }

    /// The radiance is zero outside the disc.
    fn le(&self, origin: &LightOrigin) -> Spectrum {
        let Some(cos) = self.cos_at_surface(origin.direction()) else { return Spectrum::ZERO };
        let place = cos * f32::from(STEPS);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the profile")]
        let below = (place as usize).min(self.profile.len() - 2);
        let share = place - below as f32;
        let mut radiance = self.profile[below] * (1.0 - share);
        radiance += self.profile[below + 1] * share;
        radiance
    }

    fn sample_li(&self, _from: Vec3A, [u, v]: [f32; 2]) -> Option<LightOrigin> {
        let cos = limb_cosine(u);
        let sin_squared = (1.0 - cos * cos) * self.sin_squared_radius;
        let (side, up) = self.to_sun.any_orthonormal_pair();
        let (sin_turn, cos_turn) = (TAU * v).sin_cos();
        let aside = (side * cos_turn + up * sin_turn) * sin_squared.sqrt();
        Some(LightOrigin::Distant((self.to_sun * (1.0 - sin_squared).sqrt() + aside).normalize()))
    }

    /// The disc is so small that its solid angle is π sin² of its radius.
    fn pdf_li(&self, _from: Vec3A, origin: &LightOrigin) -> f32 {
        let norm = PI * self.sin_squared_radius * (1.0 - LIMB_DARKENING / 3.0);
        self.cos_at_surface(origin.direction()).map_or(0.0, |cos| (1.0 - LIMB_DARKENING * (1.0 - cos)) / norm)
    }

    fn hit(&self, ray: &Ray, _limit_m: f32) -> Option<LightOrigin> {
        self.cos_at_surface(ray.direction).map(|_| LightOrigin::Distant(ray.direction))
    }

    /// The irradiance is π sin²r ∫ 2 μ L(μ) dμ, with the radius r of the disc. L is linear in each step, so that the
    /// integral over a step follows from Simpson's formula.
    fn normal_irradiance(&self) -> Spectrum {
        let step = f32::from(STEPS).recip();
        let mut sum = Spectrum::ZERO;
        for (index, pair) in self.profile.windows(2).enumerate() {
            let start = index as f32 * step;
            // Weights of the radiance at both ends: 2 μ L at start, middle and end in the ratio 1 : 4 : 1.
            let middle = 4.0 * (start + 0.5 * step);
            sum += pair[0] * (step / 6.0 * (2.0 * start + middle));
            sum += pair[1] * (step / 6.0 * (middle + 2.0 * (start + step)));
        }
        sum * (PI * self.sin_squared_radius)
    }
}

/// The cosine μ below which a share u of the light lies, for linear limb darkening: the solution of
/// (1 − u′) μ²/2 + u′ μ³/3 = u (1/2 − u′/6) with the limb darkening u′, by Newton's method from above.
fn limb_cosine(u: f32) -> f32 {
    const TOTAL: f32 = 0.5 - LIMB_DARKENING / 6.0;
    let mut cos = 1.0_f32;
    for _ in 0..8 {
        let below = cos * cos * (0.5 * (1.0 - LIMB_DARKENING) + LIMB_DARKENING / 3.0 * cos);
        let density = cos * (1.0 - LIMB_DARKENING + LIMB_DARKENING * cos);
        cos -= (below - u * TOTAL) / density.max(1e-6);
    }
    cos.clamp(0.0, 1.0)
}
