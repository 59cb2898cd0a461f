//! The clear sky and the sun in it, after Hosek & Wilkie.
//!
//! **Sky** (Hosek & Wilkie 2012, doi:10.1145/2185520.2185591). At each wavelength of the tables, the radiance at the
//! zenith angle θ and the angle γ to the sun is
//!
//! L = R (1 + p₀ e^(p₁ / (cos θ + 0.01))) (p₂ + p₃ e^(p₄ γ) + p₅ cos² γ + p₆ χ(p₈, γ) + p₇ √cos θ),
//! χ(g, γ) = (1 + cos² γ) / (1 + g² − 2 g cos γ)^1.5.
//!
//! R and p₀–p₈ are quintic Bézier curves of x = (h₀ / 90°)^(1/3), with h₀ the elevation of the sun, and linear in
//! turbidity and ground albedo.
//!
//! **Sun** (Hosek & Wilkie 2013, doi:10.1109/MCG.2013.18). The radiance of a point of the disc is a piecewise cubic
//! polynomial of the point's own elevation times a limb darkening, which is a polynomial of degree 5 in cos ψ, with
//! sin ψ = sin γ / sin([`SUN_RADIUS_RAD`]).
//!
//! The sky's radiance, the radiance of the sun's centre and the limb darkening are linear between the wavelengths.
//!
//! **Simplified.** Close to the horizon under a low sun, the published fit of the sky's radiance falls below zero at
//! some wavelengths, by up to 0.3 R. The radiance is zero there. Rays are straight: there is no refraction.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::error::{SkyError, check};
use crate::rings::{Ring, midpoints};
use crate::tables::{
    self, CONTROL_POINTS, Coefficients, NODES, PRECIPITABLE_WATER_CM, PRECIPITABLE_WATER_RANGE_CM, SEGMENTS,
    SKY_VALUES, TURBIDITY_RANGE, TurbidityLevel, at_wavelength, polynomial,
};

/// Angle from the centre of the sun's disc to its edge, in radians: half of 0.5358°, as in Mitsuba 3.
///
/// The mean over the year is 0.2666° (Meeus 1998, chapter 55).
pub const SUN_RADIUS_RAD: f64 = 0.5 * 0.5358 * PI / 180.0;

/// Least and greatest elevation of the sun, in degrees.
pub const ELEVATION_RANGE_DEG: (f64, f64) = (0.0, 90.0);

/// Rings around the sun, and points of half a ring, for the irradiance by the sky. More points change the irradiance
/// by less than 1e-3.
const SKY_POINTS: (u32, u32) = (96, 48);

/// Rings and points of half a ring for the irradiance by the sun. More points change the irradiance by less than
/// 1e-3, or 2e-3 where the horizon cuts the disc.
const SUN_POINTS: (u32, u32) = (32, 32);

/// A cloudless sky with its sun, for one elevation of the sun, turbidity and ground.
#[derive(Debug, Clone, PartialEq)]
pub struct ClearSky {
    sun_elevation_deg: f64,
    turbidity: f64,
    precipitable_water_cm: f64,
    ground_albedo: [f64; NODES],
    /// R and p₀–p₈ at each wavelength.
    dome: Box<[[f64; SKY_VALUES]; NODES]>,
    /// Radiance of the sun at each wavelength: the polynomials of each segment.
    sun: Vec<[[f64; 4]; NODES]>,
}

impl ClearSky {
    /// A sky with the coefficients that this build embeds.
    ///
    /// # Errors
    /// As [`with_coefficients`](Self::with_coefficients).
    #[cfg(feature = "coefficients")]
    pub fn new(sun_elevation_deg: f64, turbidity: f64, ground_albedo: &[f64; NODES]) -> Result<Self, SkyError> {
        let coefficients = Coefficients::embedded().unwrap_or_else(|| unreachable!("the feature embeds them"));
        Self::with_coefficients(coefficients, sun_elevation_deg, turbidity, ground_albedo)
    }

    /// A sky.
    ///
    /// - `sun_elevation_deg`: angle between the horizon and the sun's centre, 0–90°.
    /// - `turbidity`: ratio of the extinction by the atmosphere to the extinction by its molecules alone, 1–10: 2 in
    ///   very clear arctic or alpine air, 3 on a clear day in a temperate climate, 6 on a warm and moist day, 10 in
    ///   haze.
    /// - `ground_albedo`: fraction of light that the ground reflects, 0–1, at each of
    ///   [`WAVELENGTHS_NM`](crate::WAVELENGTHS_NM). Snow brightens the sky above it.
    ///
    /// # Errors
    /// [`SkyError::SunBelowHorizon`], or [`SkyError::OutOfRange`] if another value lies outside its range.
    pub fn with_coefficients(
        coefficients: &Coefficients,
        sun_elevation_deg: f64,
        turbidity: f64,
        ground_albedo: &[f64; NODES],
    ) -> Result<Self, SkyError> {
        check_elevation(sun_elevation_deg)?;
        check("turbidity", turbidity, TURBIDITY_RANGE, "")?;
        for albedo in ground_albedo {
            check("ground albedo", *albedo, (0.0, 1.0), "")?;
        }
        let level = TurbidityLevel::new(turbidity);
        let weights = bernstein((sun_elevation_deg / ELEVATION_RANGE_DEG.1).cbrt());
        let dome = Box::new(std::array::from_fn(|node| {
            let mut values = [0.0; SKY_VALUES];
            for (point, weight) in weights.iter().enumerate() {
                let control_point = coefficients.sky(level, ground_albedo[node], point, node);
                values.iter_mut().zip(control_point).for_each(|(value, control)| *value += weight * control);
            }
            values
        }));
        let segment = |segment| std::array::from_fn(|node| coefficients.sun(level, segment, node));
        let sun = (0..SEGMENTS).map(segment).collect();
        let (ground_albedo, precipitable_water_cm) = (*ground_albedo, PRECIPITABLE_WATER_CM);
        Ok(Self { sun_elevation_deg, turbidity, precipitable_water_cm, ground_albedo, dome, sun })
    }

    /// This sky with another amount of water vapour, which absorbs only in the infrared.
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] outside 0–10 cm.
    pub fn with_precipitable_water(self, precipitable_water_cm: f64) -> Result<Self, SkyError> {
        check("precipitable water", precipitable_water_cm, PRECIPITABLE_WATER_RANGE_CM, " cm")?;
        Ok(Self { precipitable_water_cm, ..self })
    }

    /// Water vapour in the air, in cm of water.
    #[must_use]
    pub fn precipitable_water_cm(&self) -> f64 {
        self.precipitable_water_cm
    }

    /// Albedo of the ground at each of [`WAVELENGTHS_NM`](crate::WAVELENGTHS_NM).
    #[must_use]
    pub fn ground_albedo(&self) -> &[f64; NODES] {
        &self.ground_albedo
    }

    /// Angle between the horizon and the sun's centre, in degrees.
    #[must_use]
    pub fn sun_elevation_deg(&self) -> f64 {
        self.sun_elevation_deg
    }

    /// The turbidity.
    #[must_use]
    pub fn turbidity(&self) -> f64 {
        self.turbidity
    }

    /// Radiance of the sky without the sun, in W m⁻² sr⁻¹ nm⁻¹.
    ///
    /// `cos_zenith` and `cos_sun` are the cosines of the angles from the direction to the zenith and to the sun's
    /// centre. Below the horizon the radiance is zero.
    ///
    /// The clear sky is blue, most of all far from the sun:
    /// ```
    /// # use snowblue_sky::ClearSky;
    /// let sky = ClearSky::new(45.0, 3.0, &[0.2; 11])?;
    /// let (cos_zenith, cos_sun) = (0.5_f64.sqrt(), 0.0); // opposite to the sun, 90° away from it
    /// assert!(sky.radiance(450.0, cos_zenith, cos_sun) > 3.0 * sky.radiance(650.0, cos_zenith, cos_sun));
    /// # Ok::<(), snowblue_sky::SkyError>(())
    /// ```
    ///
    /// # Panics
    /// If the wavelength lies outside 320–720 nm.
    #[must_use]
    pub fn radiance(&self, wavelength_nm: f64, cos_zenith: f64, cos_sun: f64) -> f64 {
        at_wavelength(&self.radiance_at_nodes(cos_zenith, cos_sun), wavelength_nm)
    }

    /// [`radiance`](Self::radiance) at each of [`WAVELENGTHS_NM`](crate::WAVELENGTHS_NM).
    ///
    /// For many wavelengths in one direction, call this once and then [`at_wavelength`].
    #[must_use]
    pub fn radiance_at_nodes(&self, cos_zenith: f64, cos_sun: f64) -> [f64; NODES] {
        if cos_zenith < 0.0 {
            return [0.0; NODES];
        }
        let cos_sun = cos_sun.clamp(-1.0, 1.0);
        let sun_angle = cos_sun.acos();
        std::array::from_fn(|node| {
            let [factor, p0, p1, p2, p3, p4, p5, p6, p7, p8] = self.dome[node];
            let zenith = 1.0 + p0 * (p1 / (cos_zenith + 0.01)).exp();
            let base = 1.0 + p8 * p8 - 2.0 * p8 * cos_sun;
            let aureole = (1.0 + cos_sun * cos_sun) / (base * base.sqrt());
            let sun = p2 + p3 * (p4 * sun_angle).exp() + p5 * cos_sun * cos_sun + p6 * aureole + p7 * cos_zenith.sqrt();
            (factor * zenith * sun).max(0.0)
        })
    }

    /// Radiance of the sun's disc without the sky, in W m⁻² sr⁻¹ nm⁻¹.
    ///
    /// `cos_zenith` is the cosine of the zenith angle of the direction, and `sin_sun` the sine of its angle to the
    /// sun's centre, which must be less than 90°. The radiance is zero beyond the edge of the disc and below the
    /// horizon.
    ///
    /// # Panics
    /// If the wavelength lies outside 320–720 nm.
    #[must_use]
    pub fn sun_radiance(&self, wavelength_nm: f64, cos_zenith: f64, sin_sun: f64) -> f64 {
        let centre = at_wavelength(&self.sun_centre_at_nodes(cos_zenith), wavelength_nm);
        centre * at_wavelength(&limb_darkening_at_nodes(sin_sun), wavelength_nm)
    }

    /// Radiance that the centre of the sun's disc would have at a zenith angle, apart from
    /// [`limb_darkening_at_nodes`], in W m⁻² sr⁻¹ nm⁻¹, at each of [`WAVELENGTHS_NM`](crate::WAVELENGTHS_NM).
    ///
    /// For many wavelengths in one direction: the radiance of the disc is the product of this radiance and the limb
    /// darkening, each interpolated by [`at_wavelength`].
    #[must_use]
    pub fn sun_centre_at_nodes(&self, cos_zenith: f64) -> [f64; NODES] {
        if cos_zenith < 0.0 {
            return [0.0; NODES];
        }
        let elevation = cos_zenith.min(1.0).asin();
        let position = (elevation / FRAC_PI_2).cbrt() * SEGMENTS as f64;
        #[expect(clippy::cast_possible_truncation, reason = "a number from 0 to 45")]
        let segment = (position as usize).min(SEGMENTS - 1);
        let start = FRAC_PI_2 * (segment as f64 / SEGMENTS as f64).powi(3);
        self.sun[segment].map(|coefficients| polynomial(&coefficients, elevation - start).max(0.0))
    }

    /// Irradiance of a plane that faces the sun by its disc, in W m⁻² nm⁻¹.
    ///
    /// The air scatters more of the blue out of the beam:
    /// ```
    /// # use snowblue_sky::ClearSky;
    /// let ratio = |elevation_deg| {
    ///     let sky = ClearSky::new(elevation_deg, 2.0, &[0.2; 11]).unwrap();
    ///     sky.sun_irradiance(450.0) / sky.sun_irradiance(650.0)
    /// };
    /// assert!(ratio(5.0) < 0.2 * ratio(60.0));
    /// ```
    ///
    /// # Panics
    /// If the wavelength lies outside 320–720 nm.
    #[must_use]
    pub fn sun_irradiance(&self, wavelength_nm: f64) -> f64 {
        self.disc_integral(wavelength_nm, SUN_POINTS)
    }

    /// Irradiance of level ground by the sky without the sun, in W m⁻² nm⁻¹.
    ///
    /// # Panics
    /// If the wavelength lies outside 320–720 nm.
    #[must_use]
    pub fn sky_irradiance(&self, wavelength_nm: f64) -> f64 {
        at_wavelength(&self.sky_irradiance_at_nodes(), wavelength_nm)
    }

    /// [`sky_irradiance`](Self::sky_irradiance) at each of [`WAVELENGTHS_NM`](crate::WAVELENGTHS_NM), for
    /// [`at_wavelength`].
    #[must_use]
    pub fn sky_irradiance_at_nodes(&self) -> [f64; NODES] {
        self.dome_integral(SKY_POINTS)
    }

    /// ∫ L cos θ dω over the sky.
    ///
    /// Rings up to γ = h₀ are whole, rings up to 180° − h₀ are cut by the horizon, and all further rings lie below
    /// the horizon. In both intervals γ = γ₁ + (γ₂ − γ₁) (1 − cos t) / 2, which removes the square roots where rings
    /// touch the horizon and resolves the aureole.
    fn dome_integral(&self, (rings, points): (u32, u32)) -> [f64; NODES] {
        let elevation = self.sun_elevation_deg.to_radians();
        let mut sum = [0.0; NODES];
        for (from, to) in [(0.0, elevation), (elevation, PI - elevation)] {
            for t in midpoints(0.0, PI, rings) {
                let sun_angle = from + 0.5 * (to - from) * (1.0 - t.cos());
                let step = 0.5 * (to - from) * t.sin() * PI / f64::from(rings);
                let ring = Ring::new(elevation.sin(), sun_angle);
                let weight = sun_angle.sin() * step * ring.extent() / f64::from(points);
                for cos_zenith in ring.cos_zeniths(points) {
                    let radiance = self.radiance_at_nodes(cos_zenith, sun_angle.cos());
                    sum.iter_mut().zip(radiance).for_each(|(sum, value)| *sum += weight * cos_zenith * value);
                }
            }
        }
        sum
    }

    /// ∫ L cos γ dω over the disc. With m = cos ψ, cos γ dω = sin² r m dm dφ.
    fn disc_integral(&self, wavelength_nm: f64, (rings, points): (u32, u32)) -> f64 {
        let sin_elevation = self.sun_elevation_deg.to_radians().sin();
        let sin_radius = SUN_RADIUS_RAD.sin();
        let ring_sum = |cos_surface: f64| {
            let sin_sun = sin_radius * (1.0 - cos_surface * cos_surface).sqrt();
            let limb_darkening = at_wavelength(&limb_darkening_at_nodes(sin_sun), wavelength_nm);
            let ring = Ring::new(sin_elevation, sin_sun.asin());
            let centre = |cos_zenith| at_wavelength(&self.sun_centre_at_nodes(cos_zenith), wavelength_nm);
            let mean = ring.cos_zeniths(points).map(centre).sum::<f64>() / f64::from(points);
            cos_surface * limb_darkening * mean * ring.extent()
        };
        sin_radius * sin_radius * midpoints(0.0, 1.0, rings).map(ring_sum).sum::<f64>() / f64::from(rings)
    }
}

/// Radiance of a point of the sun's disc relative to the radiance of its centre, at each of
/// [`WAVELENGTHS_NM`](crate::WAVELENGTHS_NM): the limb darkening.
///
/// `sin_sun` is the sine of the angle from the direction to the sun's centre, which must be less than 90°. Beyond the
/// edge the result is zero.
///
/// The edge of the sun is darker than its centre, and redder:
/// ```
/// # use snowblue_sky::{limb_darkening_at_nodes, SUN_RADIUS_RAD};
/// let edge = limb_darkening_at_nodes(0.99 * SUN_RADIUS_RAD.sin());
/// assert!(edge[3] < edge[8] && edge[8] < 0.6); // 440 and 640 nm
/// ```
#[must_use]
pub fn limb_darkening_at_nodes(sin_sun: f64) -> [f64; NODES] {
    let sin_surface = sin_sun / SUN_RADIUS_RAD.sin();
    if sin_surface > 1.0 {
        return [0.0; NODES];
    }
    let cos_surface = (1.0 - sin_surface * sin_surface).sqrt();
    std::array::from_fn(|node| polynomial(&tables::limb_darkening(node), cos_surface))
}

/// Checks that the sun is above the horizon, at an elevation in degrees.
pub(crate) fn check_elevation(sun_elevation_deg: f64) -> Result<(), SkyError> {
    if sun_elevation_deg < ELEVATION_RANGE_DEG.0 {
        let elevation_deg = (1e4 * sun_elevation_deg).floor() / 1e4;
        return Err(SkyError::SunBelowHorizon { elevation_deg });
    }
    check("sun elevation", sun_elevation_deg, ELEVATION_RANGE_DEG, "°")
}

/// The weights of the control points of a quintic Bézier curve.
fn bernstein(x: f64) -> [f64; CONTROL_POINTS] {
    let y = 1.0 - x;
    [
        y.powi(5),
        5.0 * x * y.powi(4),
        10.0 * x.powi(2) * y.powi(3),
        10.0 * x.powi(3) * y.powi(2),
        5.0 * x.powi(4) * y,
        x.powi(5),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bezier_weights_sum_to_one_and_reproduce_a_line() {
        for x in [0.0, 0.2, 0.77, 1.0] {
            let weights = bernstein(x);
            let line: f64 = weights.iter().zip([0.0, 0.2, 0.4, 0.6, 0.8, 1.0]).map(|(weight, at)| weight * at).sum();
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14 && (line - x).abs() < 1e-14);
        }
    }

    #[test]
    fn irradiances_have_converged() {
        for elevation_deg in [0.0, 0.1, 0.5, 3.0, 30.0, 80.0, 90.0] {
            for turbidity in [1.0, 4.5, 10.0] {
                let sky = ClearSky::new(elevation_deg, turbidity, &[0.3; NODES]).unwrap();
                let finer = sky.dome_integral((4 * SKY_POINTS.0, 4 * SKY_POINTS.1));
                for (value, finer) in sky.sky_irradiance_at_nodes().into_iter().zip(finer) {
                    assert!((value - finer).abs() <= 1e-3 * finer, "sky at {elevation_deg}°: {value} {finer}");
                }
                for wavelength_nm in [430.0, 700.0] {
                    let value = sky.sun_irradiance(wavelength_nm);
                    let finer = sky.disc_integral(wavelength_nm, (8 * SUN_POINTS.0, 8 * SUN_POINTS.1));
                    assert!((value - finer).abs() <= 2e-3 * finer, "sun at {elevation_deg}°: {value} {finer}");
                }
            }
        }
    }

    #[test]
    fn bad_input_is_refused_in_one_line() {
        let message = |elevation_deg, turbidity, albedo| {
            ClearSky::new(elevation_deg, turbidity, &[albedo; NODES]).unwrap_err().to_string()
        };
        assert_eq!(
            message(-3.2, 3.0, 0.5),
            "sun elevation is -3.2°, but must lie in 0–90°: there is no model of twilight"
        );
        assert_eq!(message(90.5, 3.0, 0.5), "sun elevation is 90.5°, but must lie in 0–90°");
        assert_eq!(message(f64::NAN, 3.0, 0.5), "sun elevation is NaN°, but must lie in 0–90°");
        assert_eq!(message(30.0, 0.5, 0.5), "turbidity is 0.5, but must lie in 1–10");
        assert_eq!(message(30.0, f64::NAN, 0.5), "turbidity is NaN, but must lie in 1–10");
        assert_eq!(message(30.0, 3.0, 1.1), "ground albedo is 1.1, but must lie in 0–1");
    }
}
