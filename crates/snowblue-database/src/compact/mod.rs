//! Colours of the light through one snow sample as polynomials, for shaders.
//!
//! A shader has neither 31 wavelengths nor a table of all snow. The logarithms of the tristimulus values of transmitted
//! and reflected light are smooth over ln(1 + h/h₀) and √μ, with the thickness h, a part h₀ of the extinction length,
//! and the cosine μ of the angle of incidence, once the exponential decay of thick snow and the proportionality of thin
//! snow are split off:
//!
//! - log₂ T = P(x, y) − κ h,
//! - log₂ R = Q(x, y) + log₂ (h / (h + h₀)).
//!
//! Chebyshev polynomials of degree 16 to 40 in x and 8 to 16 in y interpolate them. Their errors are measured between
//! the nodes. Shaders leave out the small coefficients.

mod chebyshev;
mod shader;

use snowblue_base::{ParameterRange, RangeError};
use snowblue_color::{Colorimeter, Xyz};
use snowblue_transport::TransportError;
use snowblue_transport::medium::{Demand, GrainTallies, Population, TallyPlan};
use snowblue_transport::ordinates::{OrdinatesOptions, solve_without_errors};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Radiometry, Slab};

use chebyshev::{Chebyshev2, nodes_and_middles};
pub use shader::ShaderLanguage;

/// Range of the greatest thickness of [`CompactSnow`], in cm.
pub const MAX_THICKNESS_RANGE: ParameterRange =
    ParameterRange { quantity: "greatest thickness", least: 0.1, greatest: 1000.0, unit: "cm" };

/// Range of the error that [`CompactSnow::shortened`] may add.
pub const ADDED_ERROR_RANGE: ParameterRange =
    ParameterRange { quantity: "added error", least: 1e-4, greatest: 0.1, unit: "" };

/// Largest angle of incidence, in degrees. Light from there to 90° counts as at this angle.
const LAST_ANGLE_DEG: f64 = 89.0;
/// Scale of the thickness h₀ over the extinction length: where the angle matters most.
const SCALE_PER_EXTINCTION_LENGTH: f64 = 0.1;
/// The relative error to reach between the nodes.
const TOLERANCE: f64 = 6e-4;
/// The relative error above which a fit is refused.
const MAX_ERROR: f64 = 0.01;
/// The least transmittance whose logarithm is fitted, above the range where discrete ordinates lose digits.
const MIN_TRANSMITTANCE: f64 = 1e-250;
/// Degrees over thickness and angle that are tried in turn.
const DEGREES: [[usize; 2]; 6] = [[16, 8], [20, 10], [24, 12], [28, 12], [32, 12], [40, 16]];

/// Why the colours of a sample have no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CompactError {
    /// The thickness is out of range.
    #[error(transparent)]
    Thickness(#[from] RangeError),
    /// A parameter of the sample is out of range.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// The snow is too dark for logarithms.
    #[error("snow of {thickness_cm:.4} cm lets no light through: choose a smaller greatest thickness")]
    Dark {
        /// The thickness, in cm.
        thickness_cm: f64,
    },
    /// The polynomials do not follow the curves.
    #[error(
        "the fit to {greatest_thickness_cm} cm has an error of {error:.1e}, but may have {MAX_ERROR} at most: \
        choose a smaller greatest thickness"
    )]
    Fit {
        /// The greatest thickness, in cm.
        greatest_thickness_cm: f64,
        /// The relative error of the fit.
        error: f64,
    },
}

/// Colours of the light through one snow sample, by thickness and angle of incidence.
#[derive(Debug, Clone, PartialEq)]
pub struct CompactSnow {
    range: ThicknessRange,
    /// κ of X, Y and Z, in 1/m.
    decay_per_m: [f64; 3],
    transmittance: Chebyshev2,
    reflectance: Chebyshev2,
    error: f64,
}

/// The thicknesses of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ThicknessRange {
    /// The scale h₀, in m.
    scale_m: f64,
    /// The greatest thickness, in m.
    greatest_m: f64,
}

/// Logarithms to base 2 of X, Y and Z on a regular grid of ln(1 + h/h₀) and √μ.
#[derive(Debug, Clone, PartialEq)]
pub struct LookUpTable {
    /// Thicknesses of the columns, in m.
    pub thicknesses_m: Vec<f64>,
    /// Cosines of the angles of incidence of the rows.
    pub cosines: Vec<f64>,
    /// [row][column] of transmitted light.
    pub transmittance: Vec<Vec<[f64; 3]>>,
    /// [row][column] of reflected light, without the factor h / (h + h₀), whose logarithm has no limit in thin snow.
    pub reflectance: Vec<Vec<[f64; 3]>>,
}

/// Logarithms of transmitted and reflected light at the points of an interpolation, [thickness][angle].
struct Samples {
    transmittance: Vec<Vec<[f64; 3]>>,
    reflectance: Vec<Vec<[f64; 3]>>,
}

impl CompactSnow {
    /// Fits the transmittance and reflectance of a sample from 0 to a thickness in cm, for one illuminant. Thicker snow
    /// is extrapolated by the decay there.
    ///
    /// # Errors
    /// If a parameter of the sample or the thickness is out of range, the snow is too dark, or the error of the fit is
    /// above 1 %.
    pub fn new(
        sample: &SnowSample,
        greatest_thickness_cm: f64,
        colorimeter: &Colorimeter,
        options: &OrdinatesOptions,
    ) -> Result<Self, CompactError> {
        MAX_THICKNESS_RANGE.check(greatest_thickness_cm)?;
        let scale_m = SCALE_PER_EXTINCTION_LENGTH * extinction_length_m(sample, options)?;
        let range = ThicknessRange { scale_m, greatest_m: 1e-2 * greatest_thickness_cm };
        let fitted = |degrees: [usize; 2]| Self::fitted(sample, range, colorimeter, options, degrees);
        let [first, further @ ..] = DEGREES;
        let mut best = fitted(first)?;
        for degrees in further {
            if best.error <= TOLERANCE {
                break;
            }
            let next = fitted(degrees)?;
            if next.error < best.error {
                best = next;
            }
        }
        if best.error > MAX_ERROR {
            return Err(CompactError::Fit { greatest_thickness_cm, error: best.error });
        }
        Ok(best)
    }

    /// The colours with polynomials of fewer coefficients, which add a relative error of at most `added_error` to X,
    /// Y and Z.
    ///
    /// # Errors
    /// If the error lies outside of [`ADDED_ERROR_RANGE`].
    pub fn shortened(&self, added_error: f64) -> Result<Self, RangeError> {
        ADDED_ERROR_RANGE.check(added_error)?;
        let [last_x, last_y] = DEGREES[DEGREES.len() - 1];
        let [xs, ys] = [last_x, last_y].map(nodes_and_middles);
        let tolerance = added_error.ln_1p() / std::f64::consts::LN_2;
        let shortened = |polynomial: &Chebyshev2| polynomial.shortened(tolerance, [&xs, &ys]);
        Ok(Self {
            transmittance: shortened(&self.transmittance),
            reflectance: shortened(&self.reflectance),
            error: (1.0 + self.error) * (1.0 + added_error) - 1.0,
            ..self.clone()
        })
    }

    /// Greatest relative error of X, Y and Z between the nodes of the interpolation.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Greatest thickness of the fit, in m.
    #[must_use]
    pub fn greatest_thickness_m(&self) -> f64 {
        self.range.greatest_m
    }

    /// The scale h₀ of the thickness, in m.
    #[must_use]
    pub fn scale_m(&self) -> f64 {
        self.range.scale_m
    }

    /// The logarithms on a grid of `columns` by `rows`, at least two of each.
    #[must_use]
    pub fn look_up_table(&self, columns: u32, rows: u32) -> LookUpTable {
        let unit = |number: u32, count: u32| f64::from(number) / f64::from(count - 1);
        let thicknesses_m: Vec<f64> =
            (0..columns).map(|column| self.range.thickness_m(2.0 * unit(column, columns) - 1.0)).collect();
        let cosines: Vec<f64> = (0..rows).map(|row| cosine(2.0 * unit(row, rows) - 1.0)).collect();
        let table = |value: &dyn Fn(f64, f64) -> [f64; 3]| {
            cosines.iter().map(|cosine| thicknesses_m.iter().map(|h| value(*h, *cosine)).collect()).collect()
        };
        let transmittance = table(&|h, cosine| self.log2_transmittance(h, cosine));
        let reflectance = table(&|h, cosine| self.log2_reflectance_over_thinness(h, cosine));
        LookUpTable { transmittance, reflectance, thicknesses_m, cosines }
    }

    /// Greatest relative error of transmitted and of reflected light in the middle of the cells of a table that is
    /// interpolated linearly.
    #[must_use]
    pub fn interpolation_errors(&self, table: &LookUpTable) -> [f64; 2] {
        // Middles in x and y, in which the table is regular.
        let middles = |values: &[f64], coordinate: &dyn Fn(f64) -> f64, value: &dyn Fn(f64) -> f64| -> Vec<f64> {
            values.windows(2).map(|pair| value(0.5 * (coordinate(pair[0]) + coordinate(pair[1])))).collect()
        };
        let thicknesses_m =
            middles(&table.thicknesses_m, &|h| self.range.coordinate(h), &|x| self.range.thickness_m(x));
        let cosines = middles(&table.cosines, &cosine_coordinate, &cosine);
        let greatest = |values: &[Vec<[f64; 3]>], exact: &dyn Fn(f64, f64) -> [f64; 3]| {
            let mut greatest = 0.0_f64;
            for (rows, cosine) in values.windows(2).zip(&cosines) {
                for (column, h) in thicknesses_m.iter().enumerate() {
                    for (channel, exact) in exact(*h, *cosine).into_iter().enumerate() {
                        let sum: f64 = rows.iter().map(|row| row[column][channel] + row[column + 1][channel]).sum();
                        greatest = greatest.max((0.25 * sum - exact).abs());
                    }
                }
            }
            (greatest * std::f64::consts::LN_2).exp_m1()
        };
        [
            greatest(&table.transmittance, &|h, cosine| self.log2_transmittance(h, cosine)),
            greatest(&table.reflectance, &|h, cosine| self.log2_reflectance_over_thinness(h, cosine)),
        ]
    }

    fn log2_transmittance(&self, thickness_m: f64, cos_incidence: f64) -> [f64; 3] {
        let logarithms = self.transmittance.at(self.range.coordinate(thickness_m), cosine_coordinate(cos_incidence));
        std::array::from_fn(|channel| logarithms[channel] - self.decay_per_m[channel] * thickness_m)
    }

    /// Base-2 logarithm of the reflectance without the factor h / (h + h₀).
    fn log2_reflectance_over_thinness(&self, thickness_m: f64, cos_incidence: f64) -> [f64; 3] {
        self.reflectance.at(self.range.coordinate(thickness_m), cosine_coordinate(cos_incidence))
    }

    /// A fit with polynomials of some degrees over thickness and angle.
    fn fitted(
        sample: &SnowSample,
        range: ThicknessRange,
        colorimeter: &Colorimeter,
        options: &OrdinatesOptions,
        degrees: [usize; 2],
    ) -> Result<Self, CompactError> {
        let [xs, ys] = degrees.map(nodes_and_middles);
        let thicknesses_m: Vec<f64> = xs.iter().map(|x| range.thickness_m(*x)).collect();
        let cosines: Vec<f64> = ys.iter().map(|y| cosine(*y)).collect();
        let Samples { mut transmittance, mut reflectance } =
            samples(sample, &thicknesses_m, &cosines, colorimeter, options)?;
        // Points run from the thickest snow to the thinnest, and from normal incidence to grazing.
        let decay_per_m: [f64; 3] = std::array::from_fn(|channel| {
            let [thick, thinner] = [0, 1].map(|point| transmittance[point][0][channel]);
            (thinner - thick) / (thicknesses_m[0] - thicknesses_m[1])
        });
        for ((transmittance, reflectance), thickness_m) in
            transmittance.iter_mut().zip(&mut reflectance).zip(&thicknesses_m)
        {
            for (transmitted, reflected) in transmittance.iter_mut().zip(reflectance) {
                for channel in 0..3 {
                    transmitted[channel] += decay_per_m[channel] * thickness_m;
                    reflected[channel] += (range.scale_m + thickness_m).log2();
                }
            }
        }
        let [through, back] = [&transmittance, &reflectance].map(|samples| Chebyshev2::interpolate(samples));
        let differences = |polynomial: &Chebyshev2, samples: &[Vec<[f64; 3]>]| {
            let point = |(x, row): (&f64, &Vec<[f64; 3]>)| {
                let row_differences = ys.iter().zip(row).map(|(y, exact)| {
                    let ours = polynomial.at(*x, *y);
                    (0..3).map(|channel| (ours[channel] - exact[channel]).abs()).fold(0.0, f64::max)
                });
                row_differences.fold(0.0, f64::max)
            };
            xs.iter().zip(samples).map(point).fold(0.0, f64::max)
        };
        let logarithm = differences(&through, &transmittance).max(differences(&back, &reflectance));
        let error = (logarithm * std::f64::consts::LN_2).exp_m1();
        Ok(Self { range, decay_per_m, transmittance: through, reflectance: back, error })
    }
}

impl ThicknessRange {
    /// x of a thickness in m, −1 to 1.
    fn coordinate(self, thickness_m: f64) -> f64 {
        (2.0 * (thickness_m / self.scale_m).ln_1p() / self.greatest_logarithm() - 1.0).clamp(-1.0, 1.0)
    }

    /// The thickness in m of x.
    fn thickness_m(self, x: f64) -> f64 {
        self.scale_m * (0.5 * (x + 1.0) * self.greatest_logarithm()).exp_m1()
    }

    /// ln (1 + h/h₀) of the greatest thickness.
    fn greatest_logarithm(self) -> f64 {
        (self.greatest_m / self.scale_m).ln_1p()
    }
}

/// log₂ T, and log₂ (R / h), of X, Y and Z.
fn samples(
    sample: &SnowSample,
    thicknesses_m: &[f64],
    cosines: &[f64],
    colorimeter: &Colorimeter,
    options: &OrdinatesOptions,
) -> Result<Samples, CompactError> {
    // The ratio of reflectance to thickness has a limit at thickness 0. Thin snow gives this limit.
    const THINNEST_CM: f64 = 1e-7;
    let slab = Slab {
        sample: *sample,
        thicknesses_cm: thicknesses_m.iter().map(|h| (1e2 * h).max(THINNEST_CM)).collect(),
        incidences: cosines.iter().map(|cosine| beam(*cosine)).collect(),
        wavelengths_nm: colorimeter.wavelengths_nm().to_vec(),
    };
    let solved = solve_without_errors(&slab, options)?;
    let count = slab.wavelengths_nm.len();
    let spectra: Vec<_> = solved.chunks_exact(count).collect();
    let darkest = solved.iter().find(|radiometry| radiometry.fluxes.transmittance.value <= MIN_TRANSMITTANCE);
    if let Some(Radiometry { thickness_cm, .. }) = darkest {
        return Err(CompactError::Dark { thickness_cm: *thickness_cm });
    }
    let logarithms = |spectrum: Vec<f64>, divisor: f64| {
        let Xyz { x, y, z } = colorimeter.xyz(&spectrum);
        [x, y, z].map(|value| (value / divisor).log2())
    };
    let rows = |quantity: &dyn Fn(usize) -> [f64; 3]| -> Vec<Vec<[f64; 3]>> {
        let row = |thickness: usize| (0..cosines.len()).map(|a| quantity(thickness * cosines.len() + a)).collect();
        (0..thicknesses_m.len()).map(row).collect()
    };
    Ok(Samples {
        transmittance: rows(&|case| {
            logarithms(spectra[case].iter().map(|radiometry| radiometry.fluxes.transmittance.value).collect(), 1.0)
        }),
        reflectance: rows(&|case| {
            let thickness_m = 1e-2 * spectra[case][0].thickness_cm;
            logarithms(
                spectra[case].iter().map(|radiometry| radiometry.fluxes.reflectance.value).collect(),
                thickness_m,
            )
        }),
    })
}

/// Mean distance between two grains on a straight line, in m.
fn extinction_length_m(sample: &SnowSample, options: &OrdinatesOptions) -> Result<f64, TransportError> {
    const MIDDLE_NM: f64 = 550.0;
    sample.check()?;
    let plan = TallyPlan { degree: 2, rays: options.tally_rays, seed: options.seed };
    let demand = Demand::of_sample(sample, &[MIDDLE_NM]);
    let tallies = GrainTallies::new(&Population::of_sample(sample), &demand, &plan);
    Ok(1.0 / tallies.medium(sample, MIDDLE_NM).extinction_per_m)
}

/// y of the cosine of an angle of incidence, −1 to 1.
fn cosine_coordinate(cos_incidence: f64) -> f64 {
    let least = least_root();
    (2.0 * (cos_incidence.max(0.0).sqrt() - least) / (1.0 - least) - 1.0).clamp(-1.0, 1.0)
}

/// The cosine of an angle of incidence of y.
fn cosine(y: f64) -> f64 {
    let least = least_root();
    (least + 0.5 * (y + 1.0) * (1.0 - least)).powi(2)
}

/// The square root of the least cosine.
fn least_root() -> f64 {
    LAST_ANGLE_DEG.to_radians().cos().sqrt()
}

fn beam(cosine: f64) -> Incidence {
    Incidence::Beam { angle_deg: cosine.min(1.0).acos().to_degrees() }
}
