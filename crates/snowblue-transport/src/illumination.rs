//! Light at depth in layers of snow under the sun and the sky: irradiances, fluence rates, absorbed power and warming.
//!
//! Fluxes are solved for the beam of each sun and for Lambertian light, which represents the sky, each with unit
//! irradiance. The fluxes are then weighted with the irradiances. **Conventions.** Irradiances on the snow and fluxes
//! at depth are per level area (plane). The actinic flux, or fluence rate, counts light from all directions alike
//! (scalar); a small sphere receives a quarter of it per area of its surface. Absorbed power is per volume of snow,
//! or per level area of a layer.
//!
//! The light of a band is an integral over the wavelengths of the band. Spectra are linear between wavelengths. PAR
//! counts photons of 400–700 nm (McCree 1972). The warming rate of the ice includes the absorbed light only, with the
//! heat capacity 152.5 + 7.122 T J kg⁻¹ K⁻¹, T in K (Cuffey & Paterson 2010, eq. 9.1): snow also conducts, radiates
//! and evaporates.

use crate::TransportError;
use crate::optics::ice;
use crate::ordinates::{DifferentiatedStack, OrdinatesOptions, differentiate_stack, solve_stack_without_errors};
use crate::parameters::{ANGLE, TEMPERATURE};
use crate::sample::SnowSample;
use crate::slab::Incidence;
use crate::stack::{DepthFluxes, Layer, Stack, StackRadiometry};
use crate::sunlight::{Band, band_integrals};
use crate::variable::{LayerVariable, Variable};

/// Temperature of clear ice, in °C: the default temperature of snow.
const ICE_TEMPERATURE_C: f64 = TEMPERATURE.default;

/// Light on a level surface: its spectral irradiances, in W m⁻² nm⁻¹.
#[derive(Debug, Clone, PartialEq)]
pub struct Illumination {
    /// Angle of the sun from the vertical, in degrees; none without a sun.
    pub sun_angle_deg: Option<f64>,
    /// Irradiance by the sun, at each wavelength.
    pub direct: Vec<f64>,
    /// Irradiance by the sky, at each wavelength.
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
    /// Flux downwards less flux upwards.
    pub net: f64,
    /// Fluence rate, from all directions.
    pub actinic: f64,
    /// Power per volume that the snow below this depth (at the ground, the snow above) absorbs.
    pub absorbed_per_m: f64,
}

/// Light in layers.
#[derive(Debug, Clone, PartialEq)]
pub struct LightInLayers {
    /// Light at each depth, then each wavelength.
    pub levels: Vec<LightLevel>,
    /// Power that each layer absorbs per level area: for each layer, then each wavelength.
    pub absorbed: Vec<f64>,
}

/// Light in layers, with its derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct DifferentiatedLight {
    /// The light.
    pub light: LightInLayers,
    /// Derivatives of the light with respect to each variable of each layer, as [`LayerVariable::of_layers`] lists
    /// the variables, per unit of the variable. Depths below the top stay fixed. The power that a layer absorbs is
    /// the power absorbed between its faces.
    pub derivatives: Vec<LightInLayers>,
}

/// A stack under all the incidences of some lights, with the faces of its layers as further depths.
struct LitStack {
    stack: Stack,
    /// For each light, the index of its sun among the incidences. The first incidence is the diffuse light of the
    /// sky.
    place_of_sun: Vec<Option<usize>>,
    /// Number of depths that precede the depths of faces.
    depths: usize,
}

/// Light of a band in layers: W m⁻² and W m⁻³, or for PAR µmol s⁻¹ in place of W.
#[derive(Debug, Clone, PartialEq)]
pub struct BandLight {
    /// Light at each depth.
    pub levels: Vec<LightLevel>,
    /// Power that each layer absorbs per level area.
    pub absorbed: Vec<f64>,
}

impl Illumination {
    /// The light of a sun at an elevation in degrees, and of its sky. A sun below the horizon or within 0.01° of it
    /// counts as sky, because the model has no beams there.
    #[must_use]
    pub fn under_sun(elevation_deg: f64, direct: Vec<f64>, diffuse: Vec<f64>) -> Self {
        let angle_deg = 90.0 - elevation_deg;
        if angle_deg <= ANGLE.range.greatest {
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
/// If the number of irradiances of a light differs from the number of wavelengths.
pub fn light_in_layers(
    stack: &Stack,
    lights: &[Illumination],
    options: &OrdinatesOptions,
) -> Result<Vec<LightInLayers>, TransportError> {
    let lit = LitStack::new(stack, lights);
    let answers = solve_stack_without_errors(&lit.stack, options)?;
    let unit = |row: usize, place: usize| unit_level(&answers[row], place);
    Ok(lights.iter().enumerate().map(|(number, light)| lit.weighted(number, light, &unit)).collect())
}

/// The light in a stack under each of `lights`, and its derivatives with respect to each of `variables` of each
/// layer. The irradiances are constant: the cosine changes the direction of the sun, but not its irradiance.
///
/// # Errors
/// As [`light_in_layers`], for a wavelength that the table of a variable's substance does not cover, and with
/// variables for a layer of no thickness, whose faces lie at one depth.
///
/// # Panics
/// If the number of irradiances of a light differs from the number of wavelengths.
pub fn differentiate_light_in_layers(
    stack: &Stack,
    lights: &[Illumination],
    variables: &[Variable],
    options: &OrdinatesOptions,
) -> Result<Vec<DifferentiatedLight>, TransportError> {
    if !variables.is_empty() && stack.layers.iter().any(|layer| layer.thickness_cm <= 0.0) {
        return Err(TransportError::Combination {
            quantity: "thickness of a layer",
            rule: "must be above 0 for derivatives of the light at depth",
        });
    }
    let lit = LitStack::new(stack, lights);
    let DifferentiatedStack { fluxes, derivatives } = differentiate_stack(&lit.stack, variables, options, false)?;
    let of_layers = LayerVariable::of_layers(variables, stack.layers.len());
    let unit = |row: usize, place: usize| unit_level(&fluxes[row], place);
    let in_light = |(number, light): (usize, &Illumination)| {
        let by = |(place_of_variable, by): (usize, &LayerVariable)| {
            let change = |row: usize, place: usize| {
                let at = derivatives[row * of_layers.len() + place_of_variable].profile[place];
                let DepthFluxes { down, up, net, fluence, absorbed_per_m, .. } = at;
                // A face moves down with the thickness of a layer above it, and the net flux falls with depth. A
                // depth at the ground under ice has moved with the ground.
                let layers_above = place.saturating_sub(lit.depths);
                let is_own = by.layer.is_some_and(|layer| layer < layers_above);
                let has_moved = layers_above == stack.layers.len() && stack.layers[layers_above - 1].is_ice();
                let moves = by.variable == Variable::Thickness && is_own && !has_moved;
                let net = if moves { net - 0.01 * unit(row, place).absorbed_per_m } else { net };
                LightLevel { down, up, net, actinic: fluence, absorbed_per_m }
            };
            lit.weighted(number, light, &change)
        };
        DifferentiatedLight {
            light: lit.weighted(number, light, &unit),
            derivatives: of_layers.iter().enumerate().map(by).collect(),
        }
    };
    Ok(lights.iter().enumerate().map(in_light).collect())
}

impl LitStack {
    fn new(stack: &Stack, lights: &[Illumination]) -> Self {
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
        let depths_cm = [&stack.depths_cm[..], &faces_cm].concat();
        Self { stack: Stack { incidences, depths_cm, ..stack.clone() }, place_of_sun, depths: stack.depths_cm.len() }
    }

    /// The light under the irradiances of `light`. `unit` gives the level under one unit of light, for a row (each
    /// incidence at each wavelength) and a depth.
    fn weighted(
        &self,
        number: usize,
        light: &Illumination,
        unit: &dyn Fn(usize, usize) -> LightLevel,
    ) -> LightInLayers {
        let wavelengths = self.stack.wavelengths_nm.len();
        let level = |depth: usize, wavelength: usize| {
            let sky = unit(wavelength, depth).times(light.diffuse[wavelength]);
            let sun = self.place_of_sun[number].map(|place| unit(place * wavelengths + wavelength, depth));
            sun.map_or(sky, |sun| sky.plus(sun.times(light.direct[wavelength])))
        };
        let places = |from: usize, to: usize| (from..to).flat_map(|at| (0..wavelengths).map(move |nm| (at, nm)));
        let absorbed = |(face, nm): (usize, usize)| level(face, nm).net - level(face + 1, nm).net;
        LightInLayers {
            levels: places(0, self.depths).map(|(depth, nm)| level(depth, nm)).collect(),
            absorbed: places(self.depths, self.depths + self.stack.layers.len()).map(absorbed).collect(),
        }
    }
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
    /// The quantities as numbers, in the order of their declaration.
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

    /// The light of a band, from spectra at these ascending wavelengths.
    ///
    /// # Errors
    /// If the wavelengths do not cover the band, as for [`BandWeights`](crate::sunlight::BandWeights).
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
    /// Rates at which the light warms the ice, in K/h: at each depth, and on average over each layer. The rates are
    /// NaN in wet snow, which melts instead. The average over a half-space is NaN too. Clear ice is at the default
    /// temperature.
    #[must_use]
    pub fn warming_k_h(&self, stack: &Stack) -> [Vec<f64>; 2] {
        let rate = |power_w_m3: f64, layer: &Layer| match layer.sample() {
            Some(sample) => warming_k_h(power_w_m3, sample),
            None => warming_of_ice_k_h(power_w_m3, ice::density_kg_m3(ICE_TEMPERATURE_C), ICE_TEMPERATURE_C),
        };
        let at = |(level, layer): (&LightLevel, &Layer)| rate(level.absorbed_per_m, layer);
        let powers = self.absorbed_per_m_of_layers(stack);
        [
            self.levels.iter().zip(stack.layers_at_depths()).map(at).collect(),
            powers.iter().zip(&stack.layers).map(|(power, layer)| rate(*power, layer)).collect(),
        ]
    }

    /// Power that each layer absorbs per volume, on average: NaN for a layer of zero thickness, and for a half-space,
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

/// Rate at which an absorbed power, in W/m³, warms the ice of snow, in K/h; NaN in wet snow.
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
    warming_of_ice_k_h(absorbed_w_m3, sample.density_kg_m3, sample.temperature_c)
}

fn warming_of_ice_k_h(absorbed_w_m3: f64, density_kg_m3: f64, temperature_c: f64) -> f64 {
    3600.0 * absorbed_w_m3 / (density_kg_m3 * ice::heat_capacity_j_kg_k(temperature_c))
}
