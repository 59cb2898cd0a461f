//! Lights. A point light's irradiance falls with the square of the distance: E = I cos θ / r².

use glam::Vec3A;
use snowblue_color::{ColorError, Colorimeter, Illuminant, Observer};

use crate::ray::narrow;
use crate::spectrum::{Spectrum, wavelengths_nm};

/// A light without extent that shines alike in all directions.
#[derive(Debug, Clone, Copy)]
pub struct PointLight {
    /// Where it is, in m.
    pub position: Vec3A,
    /// Radiant intensity in W/sr, as a band density: the mean of the samples is the total over 400–700 nm.
    pub intensity: Spectrum,
    /// The shape of its spectrum alone, with luminance Y = 1 on the grid.
    pub relative: Spectrum,
}

/// How a light reaches a surface, were nothing in between.
#[derive(Debug, Clone, Copy)]
pub struct Arrival {
    /// Unit direction to the light.
    pub direction: Vec3A,
    /// Cosine between the normal and that direction, above 0.
    pub cos_incidence: f32,
    /// Irradiance per radiant intensity, cos θ / r², in 1/m².
    pub irradiance_per_intensity: f32,
}

impl PointLight {
    /// A light with the spectral shape of a standard illuminant and this radiant intensity in W/sr, summed over the
    /// grid of 400–700 nm.
    ///
    /// # Errors
    ///
    /// When the illuminant's table does not cover the grid.
    pub fn new(position: Vec3A, illuminant: Illuminant, radiant_intensity_w_sr: f32) -> Result<Self, ColorError> {
        let mut power = [0.0; crate::spectrum::SAMPLES];
        for (sample, nm) in power.iter_mut().zip(wavelengths_nm()) {
            *sample = illuminant.relative_power(nm)?;
        }
        let mean = power.iter().sum::<f64>() / power.len() as f64;
        let equal_energy = Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm())?;
        let luminance = equal_energy.xyz(&power).y;
        Ok(Self {
            position,
            intensity: Spectrum(power.map(|sample| narrow(sample / mean) * radiant_intensity_w_sr)),
            relative: Spectrum(power.map(|sample| narrow(sample / luminance))),
        })
    }

    /// A light that shines alike at all wavelengths of a picture, for false colours.
    pub fn equal_energy(position: Vec3A, radiant_intensity_w_sr: f32) -> Self {
        Self { position, intensity: Spectrum::constant(radiant_intensity_w_sr), relative: Spectrum::ONE }
    }

    /// How it reaches a surface point with this normal, or none if it shines from below the horizon.
    ///
    /// At twice the distance a quarter of the light arrives:
    /// ```
    /// # use snowblue_render::light::PointLight;
    /// # use snowblue_color::Illuminant;
    /// # use glam::Vec3A;
    /// let lamp = PointLight::new(Vec3A::ZERO, Illuminant::D65, 40.0)?;
    /// let at = |distance_m: f32| lamp.arrival(Vec3A::Z * distance_m, Vec3A::NEG_Z).map(|a| a.irradiance_per_intensity);
    /// assert_eq!(at(1.0), at(2.0).map(|share| 4.0 * share));
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    #[inline]
    pub fn arrival(&self, point: Vec3A, normal: Vec3A) -> Option<Arrival> {
        let way = self.position - point;
        let distance_squared = way.length_squared();
        let direction = way / distance_squared.sqrt();
        let cos_incidence = normal.dot(direction);
        (cos_incidence > 0.0).then_some(Arrival {
            direction,
            cos_incidence,
            irradiance_per_intensity: cos_incidence / distance_squared,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intensity_is_the_total_over_the_grid_and_the_shape_has_luminance_one() {
        let light = PointLight::new(Vec3A::ZERO, Illuminant::D65, 40.0).unwrap();
        assert!((light.intensity.mean() - 40.0).abs() < 1e-4);
        let equal_energy = Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm()).unwrap();
        assert!((equal_energy.xyz(&light.relative.0.map(f64::from)).y - 1.0).abs() < 1e-6);
        // D65 is bluish: 460 nm has more than 620 nm.
        assert!(light.intensity.0[6] > light.intensity.0[22]);
    }

    #[test]
    fn irradiance_falls_with_the_square_of_the_distance_and_the_cosine() {
        let light = PointLight::new(Vec3A::new(0.0, 0.0, 2.0), Illuminant::E, 1.0).unwrap();
        let above = light.arrival(Vec3A::ZERO, Vec3A::Z).unwrap();
        assert!((above.irradiance_per_intensity - 0.25).abs() < 1e-6);
        let aside = light.arrival(Vec3A::new(2.0, 0.0, 0.0), Vec3A::Z).unwrap();
        assert!((aside.cos_incidence - 0.5f32.sqrt()).abs() < 1e-6);
        assert!((aside.irradiance_per_intensity - 0.5f32.sqrt() / 8.0).abs() < 1e-6);
        assert!(light.arrival(Vec3A::ZERO, Vec3A::NEG_Z).is_none());
    }
}
