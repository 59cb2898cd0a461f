//! A sky whose radiance follows from a model: clear or overcast. Below the horizon the sky is dark.

use std::sync::Arc;

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_sky::{ClearSky, OVERCAST_IRRADIANCE_SR, WAVELENGTHS_NM, overcast_relative_radiance};

use crate::light::direction_table::{DirectionTable, longitude_rad};
use crate::light::emitter::{Emitter, LightType};
use crate::light::sample::LightOrigin;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

/// Number of columns of the table by which directions are sampled. The table has half as many rows.
const COLUMNS: u16 = 512;

/// The light of the sky without the sun.
#[derive(Debug)]
pub(crate) struct SkyDome {
    model: Model,
    table: DirectionTable,
}

/// How radiance depends on direction.
#[derive(Debug)]
enum Model {
    Clear(Arc<ClearRadiance>),
    /// The spectrum at the zenith.
    Overcast(Spectrum),
}

/// Radiance of a clear sky around a sun in the unit direction `to_sun`.
#[derive(Debug)]
pub(crate) struct ClearRadiance {
    pub(crate) sky: ClearSky,
    pub(crate) to_sun: Vec3A,
    pub(crate) resampling: Resampling,
}

impl ClearRadiance {
    /// The radiance in a unit direction at or above the horizon.
    pub(crate) fn at(&self, direction: Vec3A) -> Spectrum {
        let cos_sun = f64::from(direction.dot(self.to_sun)).clamp(-1.0, 1.0);
        self.resampling.spectrum(&self.sky.radiance_at_nodes(direction.z.into(), cos_sun))
    }
}

/// Conversion from the wavelengths of the sky model to the wavelengths of a picture, as band densities.
#[derive(Debug)]
pub(crate) struct Resampling {
    /// For each wavelength, the node of the model before the wavelength, and the weights of this node and the next
    /// node.
    terms: [(usize, [f32; 2]); SAMPLES],
}

impl Resampling {
    /// A conversion that multiplies radiance by `scale`.
    pub(crate) fn new(scale: f64) -> Self {
        /// A band density is a quantity per nm times the width of the grid, in nm.
        const BAND_NM: f64 = 10.0 * SAMPLES as f64;
        let term = |nm: f64| {
            let node = WAVELENGTHS_NM.partition_point(|at| *at <= nm).clamp(1, WAVELENGTHS_NM.len() - 1) - 1;
            let share = (nm - WAVELENGTHS_NM[node]) / (WAVELENGTHS_NM[node + 1] - WAVELENGTHS_NM[node]);
            (node, [1.0 - share, share].map(|weight| narrow(scale * BAND_NM * weight)))
        };
        Self { terms: wavelengths_nm().map(term) }
    }

    /// The band density of a quantity per nm at the model's wavelengths.
    pub(crate) fn spectrum(&self, nodes: &[f64; WAVELENGTHS_NM.len()]) -> Spectrum {
        let nodes = nodes.map(narrow);
        Spectrum(self.terms.map(|(node, [before, after])| before * nodes[node] + after * nodes[node + 1]))
    }
}

impl SkyDome {
    /// A clear sky.
    pub(crate) fn clear(radiance: Arc<ClearRadiance>) -> Option<Self> {
        Self::new(Model::Clear(radiance))
    }

    /// An overcast sky that gives level ground an irradiance in W/m², as a band density.
    pub(crate) fn overcast(irradiance: &Spectrum) -> Option<Self> {
        Self::new(Model::Overcast(*irradiance * narrow(OVERCAST_IRRADIANCE_SR.recip())))
    }

    fn new(model: Model) -> Option<Self> {
        let (width, height) = (COLUMNS, COLUMNS / 2);
        let brightness = |row: u16, column: u16| {
            let polar = std::f32::consts::PI * (f32::from(row) + 0.5) / f32::from(height);
            let longitude = longitude_rad((f32::from(column) + 0.5) / f32::from(width));
            let (sin, z) = polar.sin_cos();
            LightSpectrum::luminance(&model.radiance(Vec3A::new(sin * longitude.cos(), sin * longitude.sin(), z)))
        };
        let bright: Vec<f32> = (0..height)
            .flat_map(|row| (0..width).map(move |column| (row, column)))
            .map(|(r, c)| brightness(r, c))
            .collect();
        let table = DirectionTable::new(width.into(), bright, 0.0)?;
        Some(Self { model, table })
    }
}

impl Emitter for SkyDome {
    fn name(&self) -> &'static str {
        "sky"
    }

    fn light_type(&self) -> LightType {
        LightType::Infinite
    }

    fn is_smooth_sky(&self) -> bool {
        true
    }

    fn le(&self, origin: &LightOrigin) -> Spectrum {
        self.model.radiance(origin.direction())
    }

    fn table(&self) -> Option<&DirectionTable> {
        Some(&self.table)
    }
}

impl Model {
    fn radiance(&self, direction: Vec3A) -> Spectrum {
        if direction.z <= 0.0 {
            return Spectrum::ZERO;
        }
        match self {
            Self::Clear(clear) => clear.at(direction),
            Self::Overcast(zenith) => *zenith * narrow(overcast_relative_radiance(direction.z.into())),
        }
    }
}
