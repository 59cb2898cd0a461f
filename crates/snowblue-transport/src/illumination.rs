//! Light at depth in layers of snow under the sun and the sky: irradiances, fluence rates, absorbed power and warming.
//!
//! Fluxes are solved for one unit of light, for the beam of each sun and for Lambertian light, which stands for the
//! sky, and weighted with their irradiances. **Conventions.** Irradiances on the snow and fluxes at depth are per level
//! area (plane). The actinic flux, or fluence rate, counts light from all directions alike (scalar); a small sphere
//! receives a quarter of it per area of its surface. Absorbed power is per volume of snow, or per level area of a
//! layer.
//!
//! A band is an integral over its wavelengths, between which spectra are linear; PAR counts photons of 400–700 nm
//! (McCree 1972). Warming is that of the ice by the absorbed light alone, with the heat capacity
//! 152.5 + 7.122 T J kg⁻¹ K⁻¹, T in K (Cuffey & Paterson 2010, eq. 9.1): snow also conducts, radiates and evaporates.

use crate::TransportError;
use crate::optics::ice;
use crate::ordinates::{OrdinatesOptions, solve_stack_without_errors};
use crate::sample::SnowSample;
use crate::slab::{ANGLE_RANGE, Incidence};
use crate::stack::{Layer, Stack, StackRadiometry};
use crate::sunlight::{Band, band_integrals};

/// Light on a level surface: its spectral irradiances, in W m⁻² nm⁻¹.
#[derive(Debug, Clone, PartialEq)]
pub struct Illumination {
    /// Angle of the sun from the vertical, in degrees; none without a sun.
    pub sun_angle_deg: Option<f64>,
    /// By the sun, at each wavelength.
    pub direct: Vec<f64>,
    /// By the sky, at each wavelength.
    pub diffuse: Vec<f64>,
}

/// Light at one depth: spectral, or over a band. Units are W m⁻² nm⁻¹ and W m⁻³ nm⁻¹, W m⁻² and W m⁻³, or µmol s⁻¹ in
/// place of W.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LightLevel {
    /// Flux downwards, through a level plane.
    pub down: f64,
    /// Flux upwards.
    pub up: f64,
    /// Downwards less upwards.
    pub net: f64,
    /// Fluence rate, from all directions.
    pub actinic: f64,
    /// Power that the snow below this depth (at the ground, above it) absorbs per volume.
    pub absorbed_per_m: f64,
}

/// Light in layers.
#[derive(Debug, Clone, PartialEq)]
pub struct LightInLayers {
    /// At each depth, then each wavelength.
    pub levels: Vec<LightLevel>,
    /// Power that each layer absorbs per level area, then each wavelength.
    pub absorbed: Vec<f64>,
}

/// Light of a band in layers: W m⁻² and W m⁻³, or for PAR µmol s⁻¹ in place of W.
#[derive(Debug, Clone, PartialEq)]
pub struct BandLight {
    /// At each depth.
    pub levels: Vec<LightLevel>,
    /// Power that each layer absorbs per level area.
    pub absorbed: Vec<f64>,
}

impl Illumination {
    /// The light of a sun at an elevation in degrees, and of its sky. The sun within 0.01° of the horizon, at which
    /// beams have no model, and below it counts as sky.
    #[must_use]
    pub fn under_sun(elevation_deg: f64, direct: Vec<f64>, diffuse: Vec<f64>) -> Self {
        let angle_deg = 90.0 - elevation_deg;
        if angle_deg <= ANGLE_RANGE.greatest {
            return Self { sun_angle_deg: Some(angle_deg), direct, diffuse };
        }
        let diffuse = direct.iter().zip(&diffuse).map(|(direct, diffuse)| direct + diffuse).collect();
        Self { sun_angle_deg: None, direct: vec![0.0; direct.len()], diffuse }
    }
}

/// The light in a stack under each of `lights`, whose incidences are not used, by discrete ordinates.
///
/// # Errors
/// As [`Stack::check`], for a wrong number of streams, and for a sun that is no beam.
///
/// # Panics
/// If a light has not as many irradiances as there are wavelengths.
pub fn light_in_layers(
    stack: &Stack,
    lights: &[Illumination],
    options: &OrdinatesOptions,
) -> Result<Vec<LightInLayers>, TransportError> {
    let mut incidences = vec![Incidence::Diffuse];
    let mut place_of_sun = Vec::new();
    for light in lights {
        assert!(
            light.direct.len() == stack.wavelengths_nm.len() && light.diffuse.len() == stack.wavelengths_nm.len(),
            "a light needs an irradiance at each wavelength"
        );
        let place = light.sun_angle_deg.map(|angle_deg| {
            let sun = Incidence::Beam { angle_deg };
            incidences.iter().position(|known| *known == sun).unwrap_or_else(|| {
                incidences.push(sun);
                incidences.len() - 1
            })
        });
        place_of_sun.push(place);
    }
    // The faces of the layers follow the depths.
    let mut faces_cm = vec![0.0];
    for layer in &stack.layers {
        faces_cm.push(faces_cm[faces_cm.len() - 1] + layer.thickness_cm);
    }
    let depths = stack.depths_cm.len();
    let depths_cm = [&stack.depths_cm[..], &faces_cm].concat();
    let answers = solve_stack_without_errors(&Stack { incidences, depths_cm, ..stack.clone() }, options)?;
    let wavelengths = stack.wavelengths_nm.len();
    let in_light = |(light, place): (&Illumination, &Option<usize>)| {
        // The level of each unit of light, at a place of the profile.
        let level = |profile: usize, wavelength: usize| {
            let unit = |incidence: usize| unit_level(&answers[incidence * wavelengths + wavelength], profile);
            let sky = unit(0).times(light.diffuse[wavelength]);
            place.map_or(sky, |place| sky.plus(unit(place).times(light.direct[wavelength])))
        };
        let levels = (0..depths).flat_map(|depth| (0..wavelengths).map(move |wavelength| level(depth, wavelength)));
        let layers = (depths..depths + stack.layers.len())
            .flat_map(|face| (0..wavelengths).map(move |nm| level(face, nm).net - level(face + 1, nm).net));
        LightInLayers { levels: levels.collect(), absorbed: layers.collect() }
    };
    Ok(lights.iter().zip(&place_of_sun).map(in_light).collect())
}

fn unit_level(answer: &StackRadiometry, place: usize) -> LightLevel {
    let at = &answer.profile[place];
    LightLevel {
        down: at.down.value,
        up: at.up.value,
        net: at.net.value,
        actinic: at.fluence.value,
        absorbed_per_m: at.absorbed_per_m.value,
    }
}

impl LightLevel {
    /// Its quantities as numbers, in the order of their declaration.
    #[must_use]
    pub fn values(self) -> [f64; 5] {
        [self.down, self.up, self.net, self.actinic, self.absorbed_per_m]
    }

    fn of_values([down, up, net, actinic, absorbed_per_m]: [f64; 5]) -> Self {
        Self { down, up, net, actinic, absorbed_per_m }
    }

    fn times(self, factor: f64) -> Self {
        Self::of_values(self.values().map(|value| factor * value))
    }

    fn plus(self, other: Self) -> Self {
        let (own, other) = (self.values(), other.values());
        Self::of_values(std::array::from_fn(|i| own[i] + other[i]))
    }
}

impl LightInLayers {
    /// The sum over a day of lights at equal steps of time, in J in place of W.
    ///
    /// # Panics
    /// If there is no light.
    #[must_use]
    pub fn sum_of_day(lights: &[Self]) -> Self {
        const SECONDS_OF_DAY: f64 = 86_400.0;
        let factor = SECONDS_OF_DAY / lights.len() as f64;
        let level = |place| {
            let sum = lights.iter().fold(LightLevel::default(), |sum, light| sum.plus(light.levels[place]));
            sum.times(factor)
        };
        let absorbed = |place| factor * lights.iter().map(|light| light.absorbed[place]).sum::<f64>();
        Self {
            levels: (0..lights[0].levels.len()).map(level).collect(),
            absorbed: (0..lights[0].absorbed.len()).map(absorbed).collect(),
        }
    }

    /// The light of a band, whose spectra are on these ascending wavelengths.
    ///
    /// # Errors
    /// If the wavelengths do not cover the band, as for [`BandWeights`](crate::sunlight::BandWeights). The solar band
    /// is that of all wavelengths.
    pub fn band(&self, band: Band, wavelengths_nm: &[f64]) -> Result<BandLight, TransportError> {
        let weights = band_integrals(band, wavelengths_nm)?;
        let level = |spectrum: &[LightLevel]| {
            let terms = spectrum.iter().zip(&weights).map(|(level, weight)| level.times(*weight));
            terms.fold(LightLevel::default(), LightLevel::plus)
        };
        let absorbed = |spectrum: &[f64]| spectrum.iter().zip(&weights).map(|(value, weight)| value * weight).sum();
        let count = wavelengths_nm.len();
        Ok(BandLight {
            levels: self.levels.chunks_exact(count).map(level).collect(),
            absorbed: self.absorbed.chunks_exact(count).map(absorbed).collect(),
        })
    }
}

impl BandLight {
    /// Rates at which the light warms the ice, in K/h: at each depth, and of each layer on average. Where water is in
    /// the snow they are NaN, as it melts instead, and so is that of a half-space.
    #[must_use]
    pub fn warming_k_h(&self, stack: &Stack) -> [Vec<f64>; 2] {
        let at = |(level, layer): (&LightLevel, &Layer)| warming_k_h(level.absorbed_per_m, &layer.sample);
        let powers = self.absorbed_per_m_of_layers(stack);
        [
            self.levels.iter().zip(stack.layers_at_depths()).map(at).collect(),
            powers.iter().zip(&stack.layers).map(|(power, layer)| warming_k_h(*power, &layer.sample)).collect(),
        ]
    }

    /// Power that each layer absorbs per volume, on average: NaN of a layer with no thickness, and of a half-space,
    /// which has no average.
    #[must_use]
    pub fn absorbed_per_m_of_layers(&self, stack: &Stack) -> Vec<f64> {
        let of = |(absorbed, layer): (&f64, &Layer)| {
            let is_half_space = layer.thickness_cm.is_infinite();
            if is_half_space { f64::NAN } else { absorbed / (0.01 * layer.thickness_cm) }
        };
        self.absorbed.iter().zip(&stack.layers).map(of).collect()
    }
}

/// Rate at which absorbed light warms the ice of snow, in K/h, by its power in W/m³; NaN in wet snow.
///
/// A spring sun deposits kilowatts per cubic metre in the first millimetre:
/// ```
/// use snowblue_transport::{SnowSample, illumination::warming_k_h};
///
/// let rate = warming_k_h(3000.0, &SnowSample { density_kg_m3: 100.0, ..SnowSample::default() });
/// assert!((50.0..55.0).contains(&rate));
/// ```
#[must_use]
pub fn warming_k_h(absorbed_w_m3: f64, sample: &SnowSample) -> f64 {
    if sample.water_saturation > 0.0 {
        return f64::NAN;
    }
    3600.0 * absorbed_w_m3 / (sample.density_kg_m3 * ice::heat_capacity_j_kg_k(sample.temperature_c))
}
