//! Daylight on the ground: its direct and its diffuse part.

use crate::clear_sky::ClearSky;
use crate::error::{SkyError, check};
use crate::luminous::{ILLUMINANCE_LX, PAR_UMOL_M2_S, Weight};
use crate::overcast::OvercastSky;
use crate::tables::{NODES, WAVELENGTHS_NM, at_wavelength};

/// A sky with or without a sun.
#[derive(Debug, Clone, PartialEq)]
pub enum Sky {
    /// Without a cloud.
    Clear(ClearSky),
    /// Covered by clouds.
    Overcast(OvercastSky),
}

/// The light that reaches the ground: a spectral irradiance, an illuminance, or a photon flux per area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Daylight {
    /// From the sun's disc, on a plane that faces the sun.
    pub direct_normal: f64,
    /// From the sun's disc, on level ground.
    pub direct: f64,
    /// From the sky without the sun, on level ground.
    pub diffuse: f64,
}

impl Daylight {
    /// All light on level ground.
    #[must_use]
    pub fn global(self) -> f64 {
        self.direct + self.diffuse
    }
}

impl Sky {
    /// Spectral irradiance at each wavelength, in W m⁻² nm⁻¹.
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] if a wavelength lies outside 320–720 nm.
    pub fn irradiance(&self, wavelengths_nm: &[f64]) -> Result<Vec<Daylight>, SkyError> {
        let range = (WAVELENGTHS_NM[0], WAVELENGTHS_NM[NODES - 1]);
        wavelengths_nm.iter().try_for_each(|wavelength_nm| check("wavelength", *wavelength_nm, range, " nm"))?;
        Ok(self.known_irradiance(wavelengths_nm))
    }

    fn known_irradiance(&self, wavelengths_nm: &[f64]) -> Vec<Daylight> {
        match self {
            Self::Clear(sky) => {
                let diffuse = sky.sky_irradiance_at_nodes();
                let level = sky.sun_elevation_deg().to_radians().sin();
                let at = |wavelength_nm: &f64| {
                    let direct_normal = sky.sun_irradiance(*wavelength_nm);
                    let diffuse = at_wavelength(&diffuse, *wavelength_nm);
                    Daylight { direct_normal, direct: level * direct_normal, diffuse }
                };
                wavelengths_nm.iter().map(at).collect()
            }
            Self::Overcast(sky) => {
                let at = |wavelength_nm: &f64| Daylight {
                    direct_normal: 0.0,
                    direct: 0.0,
                    diffuse: sky.irradiance(*wavelength_nm),
                };
                wavelengths_nm.iter().map(at).collect()
            }
        }
    }

    /// Illuminance, in lx.
    ///
    /// A clear noon is four to ten times as bright as an overcast one:
    /// ```
    /// # use snowblue_sky::{ClearSky, OvercastSky, Sky};
    /// let clear = Sky::Clear(ClearSky::new(50.0, 2.5, &[0.2; 11])?).illuminance().global();
    /// let overcast = Sky::Overcast(OvercastSky::under_sun(50.0)?).illuminance().global();
    /// assert!((4.0..10.0).contains(&(clear / overcast)));
    /// # Ok::<(), snowblue_sky::SkyError>(())
    /// ```
    #[must_use]
    pub fn illuminance(&self) -> Daylight {
        self.integral(&ILLUMINANCE_LX)
    }

    /// Photosynthetically active radiation, 400–700 nm, in µmol m⁻² s⁻¹.
    #[must_use]
    pub fn par(&self) -> Daylight {
        self.integral(&PAR_UMOL_M2_S)
    }

    fn integral(&self, weights: &[Weight]) -> Daylight {
        let wavelengths_nm: Vec<f64> = weights.iter().map(|at| at.wavelength_nm).collect();
        let rows = self.known_irradiance(&wavelengths_nm);
        let sum = |part: fn(&Daylight) -> f64| weights.iter().zip(&rows).map(|(at, row)| at.weight * part(row)).sum();
        Daylight {
            direct_normal: sum(|row| row.direct_normal),
            direct: sum(|row| row.direct),
            diffuse: sum(|row| row.diffuse),
        }
    }
}
