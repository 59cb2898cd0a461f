//! Daylight on the ground: its direct and its diffuse part.

use std::cell::LazyCell;

use crate::clear_sky::{ClearSky, ELEVATION_RANGE_DEG};
use crate::error::{SkyError, check};
use crate::infrared::{Infrared, Irradiance};
use crate::luminous::{ILLUMINANCE_LX, PAR_UMOL_M2_S, Weight};
use crate::overcast::OvercastSky;
use crate::tables::{NODES, WAVELENGTHS_NM, at_wavelength};

/// A sky with or without a sun.
#[derive(Debug, Clone, PartialEq)]
pub enum Sky {
    /// A clear sky.
    Clear(ClearSky),
    /// A sky covered by clouds.
    Overcast(OvercastSky),
    /// The sun is below the horizon: no light.
    Night,
}

/// Parameters of a sky beside the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weather {
    /// Whether there are clouds.
    pub clouds: Clouds,
    /// Fraction of visible light that the ground reflects, 0–1.
    pub ground_albedo: f64,
    /// Water vapour in the air, in cm of water, 0–10.
    pub precipitable_water_cm: f64,
}

/// Clouds, or none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Clouds {
    /// Air without a cloud.
    None {
        /// Ratio of the extinction by the air to the extinction by its molecules alone, 1–10.
        turbidity: f64,
    },
    /// All of the sky is covered.
    Overcast {
        /// Optical thickness of the clouds in the visible, 1–200.
        optical_thickness: f64,
    },
}

impl Weather {
    /// The sky of a sun at an elevation of −90 to 90°.
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] if a value lies outside its range.
    #[cfg(feature = "coefficients")]
    pub fn sky(self, sun_elevation_deg: f64) -> Result<Sky, SkyError> {
        let Self { clouds, ground_albedo, precipitable_water_cm } = self;
        Sky::of_sun(sun_elevation_deg, |elevation_deg| match clouds {
            Clouds::None { turbidity } => ClearSky::new(elevation_deg, turbidity, &[ground_albedo; NODES])?
                .with_precipitable_water(precipitable_water_cm)
                .map(Sky::Clear),
            Clouds::Overcast { optical_thickness } => OvercastSky::under_sun(elevation_deg)?
                .with_optical_thickness(optical_thickness)?
                .with_ground_albedo(ground_albedo)?
                .with_precipitable_water(precipitable_water_cm)
                .map(Sky::Overcast),
        })
    }
}

/// Wavelengths of irradiances, in nm.
pub const DAYLIGHT_RANGE_NM: (f64, f64) = (WAVELENGTHS_NM[0], 2500.0);

/// The light that reaches the ground: a spectral irradiance, an illuminance, or a photon flux per area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Daylight {
    /// Light from the sun's disc, on a plane that faces the sun.
    pub direct_normal: f64,
    /// Light from the sun's disc, on level ground.
    pub direct: f64,
    /// Light from the sky without the sun, on level ground.
    pub diffuse: f64,
}

/// Wavelengths that sample daylight, in nm: every 10 nm of 320–720 nm and every 20 nm of 740–2500 nm.
#[must_use]
pub fn daylight_wavelengths_nm() -> Vec<f64> {
    (320..=720).step_by(10).chain((740..=2500).step_by(20)).map(f64::from).collect()
}

impl Daylight {
    /// All light on level ground.
    #[must_use]
    pub fn global(self) -> f64 {
        self.direct + self.diffuse
    }
}

impl Sky {
    /// The sky of a sun at an elevation of −90 to 90°, in degrees, which is [`Night`](Self::Night) below the horizon:
    /// twilight has no model. `sky` makes the sky of a sun above the horizon.
    ///
    /// ```
    /// # use snowblue_sky::{OvercastSky, Sky};
    /// let overcast = |elevation_deg| OvercastSky::under_sun(elevation_deg).map(Sky::Overcast);
    /// assert_eq!(Sky::of_sun(-0.1, overcast)?, Sky::Night);
    /// assert!(Sky::of_sun(0.1, overcast)?.illuminance().global() > 300.0);
    /// # Ok::<(), snowblue_sky::SkyError>(())
    /// ```
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] for another elevation, and the errors of `sky`.
    pub fn of_sun(elevation_deg: f64, sky: impl FnOnce(f64) -> Result<Self, SkyError>) -> Result<Self, SkyError> {
        check("sun elevation", elevation_deg, (-90.0, ELEVATION_RANGE_DEG.1), "°")?;
        if elevation_deg < ELEVATION_RANGE_DEG.0 { Ok(Self::Night) } else { sky(elevation_deg) }
    }

    /// Spectral irradiance at each wavelength, in W m⁻² nm⁻¹.
    ///
    /// A low sun has lost its blue, and vapour takes whole bands from the infrared:
    /// ```
    /// # use snowblue_sky::{ClearSky, Sky};
    /// let light = Sky::Clear(ClearSky::new(10.0, 3.0, &[0.8; 11])?).irradiance(&[450.0, 870.0, 1390.0])?;
    /// assert!(light[0].direct < light[1].direct && light[2].global() < 0.01 * light[1].global());
    /// # Ok::<(), snowblue_sky::SkyError>(())
    /// ```
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] if a wavelength lies outside 320–2500 nm.
    pub fn irradiance(&self, wavelengths_nm: &[f64]) -> Result<Vec<Daylight>, SkyError> {
        wavelengths_nm.iter().try_for_each(|nm| check("wavelength", *nm, DAYLIGHT_RANGE_NM, " nm"))?;
        Ok(self.known_irradiance(wavelengths_nm))
    }

    fn known_irradiance(&self, wavelengths_nm: &[f64]) -> Vec<Daylight> {
        match self {
            Self::Clear(sky) => {
                let diffuse = sky.sky_irradiance_at_nodes();
                let level = sky.sun_elevation_deg().to_radians().sin();
                let infrared = LazyCell::new(|| Infrared::clear(sky, &diffuse));
                let at = |wavelength_nm: &f64| {
                    let Irradiance { direct_normal, diffuse } = if *wavelength_nm > WAVELENGTHS_NM[NODES - 1] {
                        infrared.at(*wavelength_nm)
                    } else {
                        let direct_normal = sky.sun_irradiance(*wavelength_nm);
                        Irradiance { direct_normal, diffuse: at_wavelength(&diffuse, *wavelength_nm) }
                    };
                    Daylight { direct_normal, direct: level * direct_normal, diffuse }
                };
                wavelengths_nm.iter().map(at).collect()
            }
            Self::Night => vec![Daylight { direct_normal: 0.0, direct: 0.0, diffuse: 0.0 }; wavelengths_nm.len()],
            Self::Overcast(sky) => {
                let infrared = LazyCell::new(|| Infrared::overcast(sky));
                let at = |wavelength_nm: &f64| {
                    let is_visible = *wavelength_nm <= WAVELENGTHS_NM[NODES - 1];
                    let diffuse =
                        if is_visible { sky.irradiance(*wavelength_nm) } else { infrared.at(*wavelength_nm).diffuse };
                    Daylight { direct_normal: 0.0, direct: 0.0, diffuse }
                };
                wavelengths_nm.iter().map(at).collect()
            }
        }
    }

    /// Illuminance, in lx.
    ///
    /// A clear noon is four to ten times as bright as an overcast noon:
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
