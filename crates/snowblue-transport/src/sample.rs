//! What snow is: grains of a size, a shape and a facetness, packed to a density.
//!
//! The parameters are those of the paper's Tables 1 and S1 (Varsa & Baranoski 2024, doi:10.1109/MCG.2023.3307517).

use crate::TransportError;
use crate::grain;
use crate::ice::{self, Ice, IceTable};
use crate::impurity::{self, Impurities};
use crate::ordinates::Quadrature;
use crate::water;

/// Half-width of the range that a mean grain size stands for, in µm (the paper's Table S1: 200–300 for 250).
pub const MEAN_SIZE_HALF_RANGE_UM: f64 = 50.0;
/// Standard deviation that a mean facetness stands for, and the half-width of its range (the paper's Table S1).
pub const MEAN_FACETNESS_DEVIATION: f64 = 0.075;
const MEAN_FACETNESS_HALF_RANGE: f64 = 0.1;

const SIZE_RANGE_UM: (f64, f64) = (20.0, 5000.0);
pub(crate) const SPHERICITY_RANGE: (f64, f64) = (0.5, 1.0);
pub(crate) const FACETNESS_RANGE: (f64, f64) = (0.0, 1.0);
const DEVIATION_RANGE: (f64, f64) = (0.0, 10.0);
const DENSITY_RANGE_KG_M3: (f64, f64) = (10.0, 900.0);
const TEMPERATURE_RANGE_C: (f64, f64) = (-60.0, 0.0);
/// Down to grains of the greatest size.
const SURFACE_AREA_RANGE_M2_KG: (f64, f64) = (1.4, 300.0);

/// What a grain size measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SizeMeasure {
    /// The greatest extension, as in the International Classification for Seasonal Snow (Fierz et al. 2009).
    #[default]
    GreatestExtension,
    /// Diameter of the sphere of equal volume.
    VolumeDiameter,
    /// Diameter of the sphere of equal volume per surface, 6 V/S.
    OpticalDiameter,
}

/// Grain sizes, uniform in number over a range, in µm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrainSize {
    /// Smallest grain, in µm.
    pub min_um: f64,
    /// Largest grain, in µm.
    pub max_um: f64,
    /// What the size measures.
    pub measure: SizeMeasure,
}

/// A normal distribution cut off outside a range; mean and deviation are those before truncation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruncatedNormal {
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Mean before truncation.
    pub mean: f64,
    /// Standard deviation before truncation; 0 is the mean alone.
    pub standard_deviation: f64,
}

/// Snow: what light meets in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SnowSample {
    /// Grain sizes.
    pub grain_size: GrainSize,
    /// Riley sphericity Ψ of the grains.
    pub sphericity: TruncatedNormal,
    /// Facetness of the grains, which becomes the roughness of their surface.
    pub facetness: TruncatedNormal,
    /// Density of the dry snow, in kg/m³.
    pub density_kg_m3: f64,
    /// Share of the pores' volume that water fills.
    pub water_saturation: f64,
    /// Particles between the grains.
    pub impurities: Impurities,
    /// Temperature, in °C; it changes nothing but the density of ice.
    pub temperature_c: f64,
    /// Whose absorption of ice is used.
    pub ice: IceTable,
}

impl GrainSize {
    /// The range that a mean greatest extension stands for, mean ± 50 µm.
    ///
    /// # Errors
    /// [`TransportError::MeanTooSmall`] if the range would start below 20 µm, [`TransportError::OutOfRange`] if it would
    /// end above 5000 µm.
    pub fn around(mean_um: f64) -> Result<Self, TransportError> {
        let (min_um, max_um) = (mean_um - MEAN_SIZE_HALF_RANGE_UM, mean_um + MEAN_SIZE_HALF_RANGE_UM);
        if min_um < SIZE_RANGE_UM.0 {
            return Err(TransportError::MeanTooSmall { mean_um });
        }
        let size = Self { min_um, max_um, measure: SizeMeasure::default() };
        size.check()?;
        Ok(size)
    }

    /// Grains of one optical diameter that have a specific surface area SSA = S/(V ρ_ice), in m²/kg.
    ///
    /// # Errors
    /// [`TransportError::OutOfRange`] for an area outside 1.4–300 m²/kg.
    pub fn from_specific_surface_area(area_m2_kg: f64, temperature_c: f64) -> Result<Self, TransportError> {
        TransportError::check("specific surface area", area_m2_kg, SURFACE_AREA_RANGE_M2_KG, " m²/kg")?;
        let diameter_um = 6e6 / (ice::density_kg_m3(temperature_c) * area_m2_kg);
        Ok(Self { min_um: diameter_um, max_um: diameter_um, measure: SizeMeasure::OpticalDiameter })
    }

    /// ⟨s²⟩ in µm².
    pub(crate) fn mean_square_um2(&self) -> f64 {
        let (a, b) = (self.min_um, self.max_um);
        (a * a + a * b + b * b) / 3.0
    }

    /// ⟨s³⟩ in µm³.
    pub(crate) fn mean_cube_um3(&self) -> f64 {
        let (a, b) = (self.min_um, self.max_um);
        (a + b) * (a * a + b * b) / 4.0
    }

    fn check(&self) -> Result<(), TransportError> {
        TransportError::check_range("grain size", (self.min_um, self.max_um), SIZE_RANGE_UM, " µm")
    }
}

impl TruncatedNormal {
    /// A single value.
    #[must_use]
    pub fn exactly(value: f64) -> Self {
        Self { min: value, max: value, mean: value, standard_deviation: 0.0 }
    }

    /// The facetness that a mean alone stands for: mean ± .1 within 0–1, standard deviation .075.
    #[must_use]
    pub fn facetness_around(mean: f64) -> Self {
        Self {
            min: (mean - MEAN_FACETNESS_HALF_RANGE).max(FACETNESS_RANGE.0),
            max: (mean + MEAN_FACETNESS_HALF_RANGE).min(FACETNESS_RANGE.1),
            mean,
            standard_deviation: MEAN_FACETNESS_DEVIATION,
        }
    }

    /// The mean of `f` over the distribution weighted by `weight`, and the inverse of its cumulative distribution.
    pub(crate) fn weighted(&self, weight: impl Fn(f64) -> f64) -> Quantiles {
        let (low, high) = self.support();
        Quantiles::new(low, high, |x| self.relative_density(x) * weight(x))
    }

    /// ⟨f⟩ over the distribution.
    pub(crate) fn mean_of(&self, f: impl Fn(f64) -> f64) -> f64 {
        let (low, high) = self.support();
        if low >= high {
            return f(low);
        }
        let rule = Quadrature::half_range(48);
        let (mut sum, mut norm) = (0.0, 0.0);
        for (node, weight) in rule.cosines.iter().zip(&rule.weights) {
            let x = low + node * (high - low);
            let share = weight * self.relative_density(x);
            sum += share * f(x);
            norm += share;
        }
        sum / norm
    }

    /// The part of the range that holds all but 10⁻¹⁵ of the distribution.
    fn support(&self) -> (f64, f64) {
        let reach = 8.0 * self.standard_deviation;
        (self.min.max(self.mean - reach), self.max.min(self.mean + reach))
    }

    fn relative_density(&self, x: f64) -> f64 {
        (-0.5 * ((x - self.mean) / self.standard_deviation).powi(2)).exp()
    }

    fn check(&self, [quantity, deviation]: [&'static str; 2], range: (f64, f64)) -> Result<(), TransportError> {
        TransportError::check_range(quantity, (self.min, self.max), range, "")?;
        TransportError::check(quantity, self.mean, (self.min, self.max), "")?;
        TransportError::check(deviation, self.standard_deviation, DEVIATION_RANGE, "")
    }
}

impl SnowSample {
    /// Volume fraction of ice, φ = ρ/ρ_ice.
    #[must_use]
    pub fn ice_fraction(&self) -> f64 {
        self.density_kg_m3 / ice::density_kg_m3(self.temperature_c)
    }

    /// Extinction coefficient of the grains in 1/m: κ = φ ⟨S/4⟩/⟨V⟩, since a convex body in random orientation has the mean
    /// projected area S/4 (Cauchy).
    ///
    /// ```
    /// # use snowblue_transport::sample::{GrainSize, SnowSample};
    /// // Finer grains at equal density cut off light sooner: extinction goes as 1/size.
    /// let fine = SnowSample { grain_size: GrainSize::around(100.0).unwrap(), ..SnowSample::default() };
    /// let coarse = SnowSample { grain_size: GrainSize::around(500.0).unwrap(), ..SnowSample::default() };
    /// assert!(fine.extinction_per_m() > 4.0 * coarse.extinction_per_m());
    /// ```
    #[must_use]
    pub fn extinction_per_m(&self) -> f64 {
        let unit = |sphericity| grain::Spheroid::of_unit_size(sphericity, self.grain_size.measure);
        let area = self.sphericity.mean_of(|psi| unit(psi).surface()) * self.grain_size.mean_square_um2();
        let volume = self.sphericity.mean_of(|psi| unit(psi).volume()) * self.grain_size.mean_cube_um3();
        self.ice_fraction() * 0.25 * area / (volume * 1e-6)
    }

    /// Whether the grains are alike in all that a tally sees: shape, facetness, what their size measures, ice.
    pub(crate) fn has_grains_of(&self, other: &Self) -> bool {
        (self.sphericity, self.facetness, self.grain_size.measure, self.ice)
            == (other.sphericity, other.facetness, other.grain_size.measure, other.ice)
    }

    /// Checks every parameter.
    ///
    /// # Errors
    /// The first quantity that lies outside its range.
    pub fn check(&self) -> Result<(), TransportError> {
        self.grain_size.check()?;
        self.sphericity.check(["sphericity", "standard deviation of sphericity"], SPHERICITY_RANGE)?;
        self.facetness.check(["facetness", "standard deviation of facetness"], FACETNESS_RANGE)?;
        TransportError::check("density", self.density_kg_m3, DENSITY_RANGE_KG_M3, " kg/m³")?;
        TransportError::check("water saturation", self.water_saturation, (0.0, 1.0), "")?;
        self.impurities.check()?;
        TransportError::check("temperature", self.temperature_c, TEMPERATURE_RANGE_C, " °C")
    }

    /// First and last wavelength, in nm, that the tables of all that the snow holds reach.
    #[must_use]
    pub fn range_nm(&self) -> (f64, f64) {
        let mut range = Ice::new(self.ice).range_nm();
        let mut cut = |(low, high): (f64, f64)| range = (range.0.max(low), range.1.min(high));
        if self.water_saturation > 0.0 {
            cut(water::RANGE_NM);
        }
        if !self.impurities.is_none() {
            cut(impurity::RANGE_NM);
        }
        range
    }

    /// Checks that the tables of all that the snow holds reach `wavelength_nm`.
    ///
    /// # Errors
    /// [`TransportError::OutOfRange`] if one does not.
    pub fn check_wavelength(&self, wavelength_nm: f64) -> Result<(), TransportError> {
        Ice::new(self.ice).check_wavelength(wavelength_nm)?;
        if self.water_saturation > 0.0 {
            water::check_wavelength(wavelength_nm)?;
        }
        self.impurities.check_wavelength(wavelength_nm)
    }
}

impl Default for SnowSample {
    /// Sizes 350–450 µm, sphericity .7–.9 about .8 ± .1, facetness .3 (.2–.4 ± .075), 300 kg/m³, −5 °C, dry and
    /// clean.
    fn default() -> Self {
        Self {
            grain_size: GrainSize { min_um: 350.0, max_um: 450.0, measure: SizeMeasure::default() },
            sphericity: TruncatedNormal { min: 0.7, max: 0.9, mean: 0.8, standard_deviation: 0.1 },
            facetness: TruncatedNormal::facetness_around(0.3),
            density_kg_m3: 300.0,
            water_saturation: 0.0,
            impurities: Impurities::none(),
            temperature_c: -5.0,
            ice: IceTable::default(),
        }
    }
}

/// The inverse of a cumulative distribution at equal steps of probability, linear between them.
#[derive(Debug, Clone)]
pub(crate) struct Quantiles(Vec<f64>);

impl Quantiles {
    /// From a density that need not be normalised.
    pub(crate) fn new(low: f64, high: f64, density: impl Fn(f64) -> f64) -> Self {
        if low >= high {
            return Self(vec![low]);
        }
        const CELLS: usize = 8192;
        const STEPS: usize = 1024;
        let at = |i: usize| low + (high - low) * i as f64 / CELLS as f64;
        let mut cumulative = vec![0.0];
        for i in 0..CELLS {
            cumulative.push(cumulative[i] + 0.5 * (density(at(i)) + density(at(i + 1))));
        }
        let mut values = vec![low];
        let mut cell = 0;
        for step in 1..STEPS {
            let target = cumulative[CELLS] * step as f64 / STEPS as f64;
            while cumulative[cell + 1] < target {
                cell += 1;
            }
            let inside = (target - cumulative[cell]) / (cumulative[cell + 1] - cumulative[cell]);
            values.push(at(cell) + inside * (at(cell + 1) - at(cell)));
        }
        values.push(high);
        Self(values)
    }

    /// The value below which the share `uniform` of the distribution lies.
    #[inline]
    pub(crate) fn at(&self, uniform: f64) -> f64 {
        let last = self.0.len() - 1;
        if last == 0 {
            return self.0[0];
        }
        let place = uniform * last as f64;
        // A probability in (0, 1) times 1024 fits any integer.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ place ≤ 1024")]
        let cell = (place as usize).min(last - 1);
        self.0[cell] + (place - cell as f64) * (self.0[cell + 1] - self.0[cell])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_and_means_agree() {
        let law = TruncatedNormal { min: 0.7, max: 0.9, mean: 0.8, standard_deviation: 0.1 };
        let quantiles = law.weighted(|x| x * x);
        let count = 10_000;
        let mean =
            (0..count).map(|i| quantiles.at((f64::from(i) + 0.5) / f64::from(count))).sum::<f64>() / f64::from(count);
        let expected = law.mean_of(|x| x.powi(3)) / law.mean_of(|x| x * x);
        // Linear interpolation on 1024 steps of a smooth density.
        assert!((mean - expected).abs() < 1e-7, "{mean} {expected}");
    }

    #[test]
    fn messages_name_quantity_value_range_and_unit() {
        let sample = SnowSample { density_kg_m3: 1200.0, ..SnowSample::default() };
        assert_eq!(sample.check().unwrap_err().to_string(), "density is 1200 kg/m³, but must lie in 10–900 kg/m³");
        assert!(GrainSize::around(60.0).unwrap_err().to_string().contains("below 20 µm"));
    }

    #[test]
    fn surface_area_and_optical_diameter_are_one_thing() {
        let size = GrainSize::from_specific_surface_area(16.0, -5.0).unwrap();
        let sample = SnowSample { grain_size: size, ..SnowSample::default() };
        // κ = ρ SSA / 4 for any convex grain.
        assert!((sample.extinction_per_m() / (300.0 * 16.0 / 4.0) - 1.0).abs() < 1e-12);
    }
}
