//! Inversion of a spectral albedo: the specific surface area and the black carbon that fit it best.
//!
//! In the infrared the albedo of thick snow depends on the surface area, since light takes longer paths through the ice
//! of larger grains; in the visible it depends on impurities (Warren & Wiscombe 1980; Gallet et al. 2009,
//! doi:10.5194/tc-3-167-2009). Grains are tallied once; each trial then costs an eigenproblem per wavelength. The light
//! is that of an overcast sky, Lambertian.

use rayon::prelude::*;

mod least_squares;

use crate::TransportError;
use crate::medium::{Demand, GrainTallies, Population};
use crate::optics::impurity::Substance;
use crate::ordinates::{Fluxes, OrdinatesOptions, Peak};
use crate::sample::{GrainSize, SizeMeasure, SnowSample};
use crate::slab::{Incidence, THICKNESS_RANGE, check_wavelengths};
use crate::stack::GROUND_ALBEDO_RANGE;
use least_squares::{Minimum, Parameter, least_squares};

/// Range of surface areas that the fit searches, in m²/kg.
const LEAST_AREA_M2_KG: f64 = 1.5;
const GREATEST_AREA_M2_KG: f64 = 200.0;
/// Greatest mass fraction of black carbon that the fit searches, in ng/g.
const GREATEST_CARBON_NG_G: f64 = 1e5;
/// Range of scales that the fit searches.
const LEAST_SCALE: f64 = 0.5;
const GREATEST_SCALE: f64 = 2.0;
/// Errors correlate over some 50 nm, so the jackknife leaves out blocks of this many rows of 5 nm.
const BLOCK: usize = 10;

/// Snow on a ground, except for the properties to find.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pack {
    /// The snow; its grain size and black carbon are ignored.
    pub snow: SnowSample,
    /// Thickness, in cm.
    pub thickness_cm: f64,
    /// Albedo of the Lambertian ground.
    pub ground_albedo: f64,
}

/// The properties to find.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// Specific surface area, in m²/kg.
    pub surface_area_m2_kg: f64,
    /// Black carbon, in ng/g.
    pub black_carbon_ng_g: f64,
}

/// A measured albedo at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredAlbedo {
    /// Index of the wavelength in the [`AlbedoModel`].
    pub wavelength: usize,
    /// Albedo.
    pub albedo: f64,
    /// Standard deviation of the albedo.
    pub standard_deviation: f64,
}

/// Whether the measured albedo may have a common factor at all wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// The factor is 1.
    Trusted,
    /// Measured = factor · true; the factor is fitted with the snow.
    Free,
}

/// A fitted parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    /// Best value.
    pub value: f64,
    /// Standard error if the errors at all wavelengths are independent; 0 at an end of the parameter's range.
    pub standard_error: f64,
    /// Standard error by a jackknife over blocks of 10 neighbouring wavelengths, which includes correlated errors of
    /// the measurement and of the model.
    pub block_error: f64,
}

/// The snow that fits an albedo best.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Specific surface area, in m²/kg.
    pub surface_area_m2_kg: Fitted,
    /// Black carbon, in ng/g.
    pub black_carbon_ng_g: Fitted,
    /// Measured over true albedo.
    pub scale: Fitted,
    /// Correlation of surface area and black carbon.
    pub area_carbon_correlation: f64,
    /// Correlation of scale and surface area; 0 if the scale is trusted.
    pub scale_area_correlation: f64,
    /// Correlation of scale and black carbon; 0 if the scale is trusted.
    pub scale_carbon_correlation: f64,
    /// Sum of the squared residuals, in standard deviations, per degree of freedom.
    pub chi_square_per_freedom: f64,
}

/// Albedo at fixed wavelengths for any surface area and black carbon; the grains are tallied once.
pub struct AlbedoModel {
    tallies: GrainTallies,
    wavelengths_nm: Vec<f64>,
    options: OrdinatesOptions,
}

impl Fit {
    /// The best surface area and black carbon.
    #[must_use]
    pub fn finding(&self) -> Finding {
        Finding { surface_area_m2_kg: self.surface_area_m2_kg.value, black_carbon_ng_g: self.black_carbon_ng_g.value }
    }
}

impl Finding {
    /// `snow` with this surface area and black carbon.
    ///
    /// # Errors
    /// [`TransportError::Range`] for a surface area outside 1.4–300 m²/kg.
    pub fn in_snow(&self, snow: &SnowSample) -> Result<SnowSample, TransportError> {
        let grain_size = GrainSize::from_specific_surface_area(self.surface_area_m2_kg, snow.temperature_c)?;
        let impurities = snow.impurities.with(Substance::BlackCarbon, self.black_carbon_ng_g);
        Ok(SnowSample { grain_size, impurities, ..*snow })
    }
}

impl AlbedoModel {
    /// Tallies the grains of `snow`; their size is ignored.
    ///
    /// # Errors
    /// If the snow or a wavelength is out of range.
    pub fn new(snow: &SnowSample, wavelengths_nm: &[f64], options: &OrdinatesOptions) -> Result<Self, TransportError> {
        let coarsest = Finding { surface_area_m2_kg: LEAST_AREA_M2_KG, black_carbon_ng_g: 1.0 }.in_snow(snow)?;
        coarsest.check()?;
        options.streams.check()?;
        check_wavelengths(wavelengths_nm, &coarsest)?;
        let plan = options.plan(&[Incidence::Diffuse], Peak::of(snow));
        let population = Population::new(&snow.sphericity, &snow.facetness, SizeMeasure::OpticalDiameter);
        Ok(Self {
            tallies: GrainTallies::new(&population, &Demand::of_sample(&coarsest, wavelengths_nm), &plan),
            wavelengths_nm: wavelengths_nm.to_vec(),
            options: *options,
        })
    }

    /// The albedo of a pack at each wavelength, under Lambertian light.
    ///
    /// # Errors
    /// If the pack or the finding is out of range.
    pub fn albedo(&self, pack: &Pack, finding: &Finding) -> Result<Vec<f64>, TransportError> {
        let snow = finding.in_snow(&pack.snow)?;
        snow.check()?;
        THICKNESS_RANGE.check(pack.thickness_cm)?;
        GROUND_ALBEDO_RANGE.check(pack.ground_albedo)?;
        let albedo = |wavelength_nm: &f64| {
            let medium = self.tallies.medium(&snow, *wavelength_nm, None);
            let (streams, peak) = (self.options.streams, Peak::of(&snow));
            let fluxes = medium.fluxes(&[pack.thickness_cm], &[Incidence::Diffuse], streams, peak);
            over_ground(&fluxes[0], pack.ground_albedo)
        };
        Ok(self.wavelengths_nm.par_iter().map(albedo).collect())
    }

    /// Fits the surface area and the black carbon of a pack, and the scale of the measurement if that is free.
    ///
    /// # Errors
    /// If the pack is out of range or `measured` is empty.
    pub fn fit(&self, pack: &Pack, measured: &[MeasuredAlbedo], scale: Scale) -> Result<Fit, TransportError> {
        if measured.is_empty() {
            return Err(TransportError::Missing { quantity: "measured albedo" });
        }
        // All later trials lie in range if the first does.
        let start = [20_f64.ln(), 10.0, 1.0];
        self.albedo(pack, &finding(&start))?;
        let best = self.least(pack, measured, &start, scale);
        let from: [f64; 3] = [best.values[0], best.values[1], value_or_one(&best.values)];
        let blocks: Vec<Vec<f64>> = measured
            .chunks(BLOCK)
            .map(|block| {
                let others: Vec<MeasuredAlbedo> =
                    measured.iter().filter(|measurement| !block.contains(measurement)).copied().collect();
                self.least(pack, &others, &from, scale).values
            })
            .collect();
        Ok(summary(&best, &blocks, measured.len()))
    }

    fn least(&self, pack: &Pack, measured: &[MeasuredAlbedo], start: &[f64; 3], scale: Scale) -> Minimum {
        let parameters = [
            Parameter { start: start[0], least: LEAST_AREA_M2_KG.ln(), greatest: GREATEST_AREA_M2_KG.ln(), step: 1e-4 },
            Parameter { start: start[1], least: 0.0, greatest: GREATEST_CARBON_NG_G, step: 1e-2 },
            Parameter { start: start[2], least: LEAST_SCALE, greatest: GREATEST_SCALE, step: 1e-5 },
        ];
        let count = if scale == Scale::Free { 3 } else { 2 };
        let residuals = |values: &[f64]| -> Vec<f64> {
            let albedo = self.albedo(pack, &finding(values));
            let albedo = albedo.unwrap_or_else(|error| unreachable!("within checked ranges: {error}"));
            let factor = value_or_one(values);
            measured
                .iter()
                .map(|measurement| {
                    (factor * albedo[measurement.wavelength] - measurement.albedo) / measurement.standard_deviation
                })
                .collect()
        };
        least_squares(residuals, &parameters[..count])
    }
}

/// The albedo of a slab over a Lambertian ground under Lambertian light: R + T² a/(1 − a R).
fn over_ground(slab: &Fluxes, ground_albedo: f64) -> f64 {
    let returned = ground_albedo / (1.0 - ground_albedo * slab.reflectance);
    slab.reflectance + slab.transmittance * slab.transmittance * returned
}

fn finding(values: &[f64]) -> Finding {
    Finding { surface_area_m2_kg: values[0].exp(), black_carbon_ng_g: values[1] }
}

/// The scale, or 1 if it is trusted.
fn value_or_one(values: &[f64]) -> f64 {
    values.get(2).copied().unwrap_or(1.0)
}

fn summary(best: &Minimum, blocks: &[Vec<f64>], count: usize) -> Fit {
    // A trusted scale, the third parameter, is 1 without error.
    let variance = |i: usize| best.covariance.get((i, i)).copied().unwrap_or(0.0);
    let correlation = |i: usize, j: usize| {
        let product = (variance(i) * variance(j)).sqrt();
        if product > 0.0 { best.covariance[(i, j)] / product } else { 0.0 }
    };
    let fitted = |i: usize| {
        if i >= best.values.len() {
            return Fitted { value: 1.0, standard_error: 0.0, block_error: 0.0 };
        }
        let parts = || blocks.iter().map(move |values| values[i]);
        let mean = parts().sum::<f64>() / blocks.len() as f64;
        let squares: f64 = parts().map(|part| (part - mean).powi(2)).sum();
        let factor = (blocks.len() as f64 - 1.0) / blocks.len() as f64;
        Fitted { value: best.values[i], standard_error: variance(i).sqrt(), block_error: (factor * squares).sqrt() }
    };
    // The first parameter is the logarithm of the area.
    let logarithm = fitted(0);
    let area = logarithm.value.exp();
    Fit {
        surface_area_m2_kg: Fitted {
            value: area,
            standard_error: area * logarithm.standard_error,
            block_error: area * logarithm.block_error,
        },
        black_carbon_ng_g: fitted(1),
        scale: fitted(2),
        area_carbon_correlation: correlation(0, 1),
        scale_area_correlation: correlation(0, 2),
        scale_carbon_correlation: correlation(1, 2),
        chi_square_per_freedom: best.sum_of_squares / (count as f64 - best.values.len() as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    const DEVIATION: f64 = 0.004;

    /// A normal number (Box & Muller 1958).
    fn normal(stream: &mut Stream) -> f64 {
        (-2.0 * stream.uniform().ln()).sqrt() * (std::f64::consts::TAU * stream.uniform()).cos()
    }

    /// Fits of noisy albedos recover the snow within their standard errors: χ² of 20 numbers, whose 0.1 % and 99.9 %
    /// quantiles are 5.9 and 45.3.
    #[test]
    fn fits_recover_known_snow_within_their_standard_errors() {
        let wavelengths_nm: Vec<f64> = (0..31).map(|i| 400.0 + 30.0 * f64::from(i)).collect();
        let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
        let model = AlbedoModel::new(&SnowSample::default(), &wavelengths_nm, &options).unwrap();
        let pack = Pack { snow: SnowSample::default(), thickness_cm: 20.0, ground_albedo: 0.1 };
        let truth = Finding { surface_area_m2_kg: 18.0, black_carbon_ng_g: 300.0 };
        let exact = model.albedo(&pack, &truth).unwrap();
        let mut chi_square = 0.0;
        for (seed, scale) in (0..10).map(|seed| (seed, if seed % 2 == 0 { Scale::Trusted } else { Scale::Free })) {
            let mut stream = Stream::new(seed, 0);
            let factor = if scale == Scale::Free { 1.02 } else { 1.0 };
            let mut noisy = |(wavelength, albedo): (usize, &f64)| MeasuredAlbedo {
                wavelength,
                albedo: factor * albedo + DEVIATION * normal(&mut stream),
                standard_deviation: DEVIATION,
            };
            let measured: Vec<MeasuredAlbedo> = exact.iter().enumerate().map(&mut noisy).collect();
            let fit = model.fit(&pack, &measured, scale).unwrap();
            let off = |fitted: Fitted, truth: f64| ((fitted.value - truth) / fitted.standard_error).powi(2);
            chi_square += off(fit.surface_area_m2_kg, truth.surface_area_m2_kg);
            chi_square += off(fit.black_carbon_ng_g, truth.black_carbon_ng_g);
            assert!((0.3..2.2).contains(&fit.chi_square_per_freedom), "{fit:?}");
            assert!((fit.scale.value - factor).abs() < 4.0 * fit.scale.standard_error + 1e-12, "{fit:?}");
        }
        assert!((5.9..45.3).contains(&chi_square), "{chi_square}");
    }

    #[test]
    fn a_white_ground_makes_a_lossless_slab_white() {
        let slab = Fluxes { reflectance: 0.5, transmittance: 0.5, direct: 0.0 };
        assert!((over_ground(&slab, 1.0) - 1.0).abs() < 1e-15 && (over_ground(&slab, 0.0) - 0.5).abs() < 1e-15);
    }
}
