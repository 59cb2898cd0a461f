//! The curves of one snow sample, ready for look-up, and mixes of two.
//!
//! In a mix of two samples of one table, for objects whose snow varies over their surface, the logarithms of
//! transmittance and reflectance are interpolated, ln T = (1 − s) ln T₁ + s ln T₂. The logarithms are linear in the
//! coefficients, so the coefficients are mixed and the spectrum is evaluated once.

use std::f64::consts::LOG2_E;

use snowblue_transport::sample::SnowSample;

use crate::blend::Blend;
use crate::fill::{fill_samples, ice_from_metadata};
use crate::lookup::basis::{Basis, PADDED_COMPONENTS, PaddedCoefficients, Scale};
use crate::lookup::coefficient_grids::{OFFSET_CM, ResampledGrid, SplineGrid};
use crate::pca::{Components, single};
use crate::{Axes, CompressedTable, DatabaseError, Quantity, Space, TableSample};

/// Thickness from which transmittance is 0 in the paper's scheme, in cm.
pub const PAPER_BLACK_THICKNESS_CM: f32 = 100.0;
/// Largest angle of incidence in the paper's scheme, in degrees; 89–90° count as 89°.
pub const PAPER_LAST_ANGLE_DEG: f32 = 89.0;
/// Angle of incidence from which light does not reach a surface, in degrees.
pub const HORIZON_DEG: f32 = 90.0;

/// Principal components of curves that are solved. The embedded table has six, which keep T within 0.5 %.
const SOLVED_COMPONENTS: usize = 8;
/// Rays through grains for curves that are solved: 0.2 % in the transmittance of 15 cm.
const SOLVED_RAYS: u32 = 1 << 18;

/// The curves of one snow sample, ready for look-up.
#[derive(Debug, Clone)]
pub struct PcaSnow {
    wavelengths_nm: Vec<f64>,
    /// The table's last angle.
    table_last_angle_deg: f32,
    /// The largest angle of a look-up.
    last_angle_deg: f32,
    pub(super) last_thickness_cm: f32,
    /// Thickness at the table's density over thickness of this snow.
    pub(super) thickness_scale: f32,
    pub(super) count: usize,
    transmittance_basis: Basis,
    reflectance_basis: Basis,
    pub(super) curves: Curves,
}

/// Coefficients over thickness and angle, for either interpolation.
#[derive(Debug, Clone)]
pub(super) enum Curves {
    Paper { transmittance: SplineGrid, reflectance: SplineGrid },
    Log { transmittance: ResampledGrid, reflectance: ResampledGrid },
}

/// Components of a quantity, and the coefficients of one sample: [angle][thickness][component].
struct SampleCoefficients<'table> {
    components: &'table Components,
    values: Vec<f64>,
}

/// A knot beside the table's: its thickness, and its value of every component.
struct EndKnot {
    thickness_cm: f64,
    values: Vec<f64>,
}

impl PcaSnow {
    /// Extracts the curves of one sample from a table. A table in linear space has the samples of its grid only, a
    /// table in log space any sample within its axes.
    ///
    /// # Errors
    /// [`DatabaseError::OffGrid`] or [`DatabaseError::OffAxis`] if a property of the sample is beyond the table,
    /// [`DatabaseError::NoAxis`] if the table has no axis of it.
    pub fn new(table: &CompressedTable, sample: &TableSample) -> Result<Self, DatabaseError> {
        let axes = &table.axes;
        if axes.angles_deg.is_empty() {
            return Err(DatabaseError::AxisRange { name: "angle", what: "an angle, since look-ups need a beam" });
        }
        let blend = match table.space {
            Space::Linear => Blend::on_grid(axes, sample)?,
            Space::Log => Blend::between(axes, sample)?,
        };
        Ok(Self::of_blend(table, &blend))
    }

    /// The curves of any samples by discrete ordinates, in log space, with a tally of `tally_rays` for each kind of
    /// grains. 2¹⁸ rays leave an error of 0.2 % in T of 15 cm. The curves can be mixed with each other.
    ///
    /// ```
    /// use snowblue_database::PcaSnow;
    /// use snowblue_transport::SnowSample;
    ///
    /// let wet = SnowSample { water_saturation: 0.2, ..SnowSample::default() };
    /// let wavelengths_nm = [450.0, 550.0, 650.0];
    /// let snow = PcaSnow::solve(&[SnowSample::default(), wet], &wavelengths_nm, 1 << 12)?;
    /// let mut through = [[0.0; 3]; 2];
    /// snow.iter().zip(&mut through).for_each(|(snow, through)| snow.transmittance(15.0, 0.0, through));
    /// // Wet snow transmits more light than dry snow of the same density.
    /// assert!(through[1][0] > through[0][0]);
    /// # Ok::<(), snowblue_database::DatabaseError>(())
    /// ```
    ///
    /// # Errors
    /// If a sample is out of range, or its tables do not cover a wavelength.
    pub fn solve(samples: &[SnowSample], wavelengths_nm: &[f64], tally_rays: u32) -> Result<Vec<Self>, DatabaseError> {
        let full = fill_samples(samples, wavelengths_nm, tally_rays)?;
        let table = CompressedTable::new(&full, Space::Log, SOLVED_COMPONENTS.min(wavelengths_nm.len()))?;
        Ok((0..samples.len()).map(|number| Self::of_blend(&table, &Blend::one(number))).collect())
    }

    /// The curves of any samples at some wavelengths, which can be mixed with each other: from a table if it holds
    /// all of them, else solved for. In the latter case the second value says why.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn read_or_solve(
        table: Option<&CompressedTable>,
        samples: &[SnowSample],
        wavelengths_nm: &[f64],
    ) -> Result<(Vec<Self>, Option<String>), DatabaseError> {
        match samples.iter().map(|sample| Self::read(table, sample, wavelengths_nm)).collect() {
            Ok(curves) => Ok((curves, None)),
            Err(reason) => Ok((Self::solve(samples, wavelengths_nm, SOLVED_RAYS)?, Some(reason))),
        }
    }

    /// The curves of a sample from a table, or the reason why the table does not have them.
    fn read(table: Option<&CompressedTable>, sample: &SnowSample, wavelengths_nm: &[f64]) -> Result<Self, String> {
        let table = table.ok_or("there is no table")?;
        let own = &table.axes.wavelengths_nm;
        let is_same = |(one, other): (&f64, &f64)| (one - other).abs() < 1e-6;
        if own.len() != wavelengths_nm.len() || !own.iter().zip(wavelengths_nm).all(is_same) {
            return Err("the table has other wavelengths than the picture".to_owned());
        }
        // A table of measurements or of another model may name no ice.
        if ice_from_metadata(&table.metadata).is_ok_and(|ice| ice != sample.ice) {
            return Err("the table was made with other constants of ice".to_owned());
        }
        let sample = TableSample::of(sample).ok_or("its grains have other sizes or shapes than those of the table")?;
        Self::new(table, &sample).map_err(|error| error.to_string())
    }

    fn of_blend(table: &CompressedTable, blend: &Blend) -> Self {
        let axes = &table.axes;
        let coefficients = |quantity: Quantity| {
            let components = table.components(quantity);
            SampleCoefficients { components, values: blend.coefficients(table, components) }
        };
        let (transmittance, reflectance) = (coefficients(Quantity::Transmittance), coefficients(Quantity::Reflectance));
        let (curves, scale) = match table.space {
            Space::Linear => {
                let (transmittance, reflectance) =
                    (paper_transmittance(axes, &transmittance), paper_reflectance(axes, &reflectance));
                (Curves::Paper { transmittance, reflectance }, 1.0)
            }
            Space::Log => {
                let (transmittance, reflectance) =
                    (log_transmittance(axes, &transmittance), log_reflectance(axes, &reflectance));
                (Curves::Log { transmittance, reflectance }, LOG2_E)
            }
        };
        let last = |values: &[f64]| single(values[values.len() - 1]);
        let table_last_angle_deg = last(&axes.angles_deg);
        Self {
            wavelengths_nm: axes.wavelengths_nm.clone(),
            table_last_angle_deg,
            last_angle_deg: match table.space {
                Space::Linear => PAPER_LAST_ANGLE_DEG,
                Space::Log => table_last_angle_deg,
            },
            last_thickness_cm: last(&axes.thicknesses_cm),
            thickness_scale: single(blend.thickness_scale),
            count: table.transmittance.count,
            transmittance_basis: Basis::new(&table.transmittance, scale),
            reflectance_basis: Basis::new(&table.reflectance, scale),
            curves,
        }
    }

    /// Wavelengths of the spectra, in nm.
    #[must_use]
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }

    /// Largest angle of incidence that look-ups resolve, in degrees. Light between it and 90° is looked up at this
    /// angle.
    ///
    /// It is the table's last angle in log space, and [`PAPER_LAST_ANGLE_DEG`] in the paper's scheme.
    #[must_use]
    #[inline]
    pub const fn last_angle_deg(&self) -> f32 {
        self.last_angle_deg
    }

    /// Angle of incidence to look up, in degrees, for the cosine of an angle of incidence: its arc cosine, at most
    /// [`last_angle_deg`](Self::last_angle_deg).
    #[must_use]
    #[inline]
    pub fn look_up_angle_deg(&self, cos_incidence: f32) -> f32 {
        cos_incidence.min(1.0).acos().to_degrees().min(self.last_angle_deg)
    }

    /// Writes the spectral transmittance of `thickness_cm` for light at `angle_deg` from the normal into `spectrum`.
    ///
    /// # Panics
    /// If the length of `spectrum` is not the number of wavelengths.
    pub fn transmittance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        self.check_length(spectrum);
        let mut coefficients = [0.0; PADDED_COMPONENTS];
        if thickness_cm <= 0.0 {
            return spectrum.fill(if angle_deg < HORIZON_DEG { 1.0 } else { 0.0 });
        }
        match &self.curves {
            Curves::Paper { transmittance, .. } => {
                if thickness_cm > PAPER_BLACK_THICKNESS_CM || angle_deg > self.table_last_angle_deg {
                    return spectrum.fill(0.0);
                }
                transmittance.coefficients(thickness_cm, angle_deg, &mut coefficients);
                self.transmittance_basis.linear(&coefficients, spectrum);
            }
            Curves::Log { transmittance, .. } => {
                if angle_deg >= HORIZON_DEG {
                    return spectrum.fill(0.0);
                }
                transmittance.coefficients(self.thickness_scale * thickness_cm, angle_deg, &mut coefficients);
                self.transmittance_basis.transmittance(&coefficients, spectrum);
            }
        }
    }

    /// Writes the spectral reflectance of `thickness_cm` for light at `angle_deg` from the normal into `spectrum`.
    ///
    /// # Panics
    /// If the length of `spectrum` is not the number of wavelengths.
    pub fn reflectance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        self.check_length(spectrum);
        if thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return spectrum.fill(0.0);
        }
        let mut coefficients = [0.0; PADDED_COMPONENTS];
        match &self.curves {
            Curves::Paper { reflectance, .. } => {
                let thickness_cm = thickness_cm.clamp(reflectance.first_knot(), reflectance.last_knot());
                reflectance.coefficients(thickness_cm, angle_deg, &mut coefficients);
                self.reflectance_basis.linear(&coefficients, spectrum);
            }
            Curves::Log { reflectance, .. } => {
                let thickness_cm = self.equivalent_thickness_cm(thickness_cm);
                reflectance.coefficients(thickness_cm, angle_deg, &mut coefficients);
                let scale = Scale { factor: thickness_cm / (thickness_cm + OFFSET_CM), log2: coefficients[self.count] };
                self.reflectance_basis.powers_of_two(&coefficients, scale, spectrum);
            }
        }
    }

    /// Writes the coefficients of transmittance on the table's basis, for thicknesses above 0 cm and angles within the
    /// table: a look-up without its spectrum.
    #[inline]
    pub fn transmittance_coefficients(&self, thickness_cm: f32, angle_deg: f32, coefficients: &mut PaddedCoefficients) {
        match &self.curves {
            Curves::Paper { transmittance, .. } => transmittance.coefficients(thickness_cm, angle_deg, coefficients),
            Curves::Log { transmittance, .. } => {
                transmittance.coefficients(self.thickness_scale * thickness_cm, angle_deg, coefficients);
            }
        }
    }

    /// Thickness at the table's density with the reflectance of this snow.
    fn equivalent_thickness_cm(&self, thickness_cm: f32) -> f32 {
        (self.thickness_scale * thickness_cm).min(self.last_thickness_cm)
    }

    pub(super) fn check_length(&self, spectrum: &[f32]) {
        assert_eq!(spectrum.len(), self.wavelengths_nm.len(), "the spectrum needs one value per wavelength");
    }
}

/// Splines through T = 1 at 0 cm and, if the table ends before 100 cm, through T = 0 at 100 cm.
fn paper_transmittance(axes: &Axes, sample: &SampleCoefficients) -> SplineGrid {
    let count = sample.components.count;
    let white: Vec<f64> = (0..count)
        .map(|c| sample.components.basis.iter().skip(c).step_by(count).map(|v| f64::from(*v)).sum())
        .collect();
    let black_cm = f64::from(PAPER_BLACK_THICKNESS_CM);
    let last_cm = axes.thicknesses_cm[axes.thicknesses_cm.len() - 1];
    let before = EndKnot { thickness_cm: 0.0, values: white };
    let after = (last_cm < black_cm).then(|| EndKnot { thickness_cm: black_cm, values: vec![0.0; count] });
    splines(axes, &sample.values, Some(before), after)
}

/// Splines through R = 0 at 0 cm.
fn paper_reflectance(axes: &Axes, sample: &SampleCoefficients) -> SplineGrid {
    let before = EndKnot { thickness_cm: 0.0, values: vec![0.0; sample.components.count] };
    splines(axes, &sample.values, Some(before), None)
}

/// Splines of ln T through ln T = 0 at 0 cm, resampled.
fn log_transmittance(axes: &Axes, sample: &SampleCoefficients) -> ResampledGrid {
    let components = sample.components;
    let before = EndKnot { thickness_cm: 0.0, values: vec![0.0; components.count] };
    let splines = splines(axes, &sample.values, Some(before), None);
    let last_cm = splines.last_knot();
    // Where noise makes the last interval of some wavelength rise, its extrapolation would grow with the thickness.
    let decays = |angle: usize| {
        let [last, beyond] = [last_cm, last_cm + 1.0].map(|h| splines.at_angle(angle, h));
        let slope =
            |shape: &[f32]| shape.iter().zip(last.iter().zip(beyond)).map(|(v, (a, b))| v * (b - a)).sum::<f32>();
        components.basis.chunks_exact(components.count).all(|shape| slope(shape) <= 0.0)
    };
    let decays: Vec<bool> = (0..axes.angles_deg.len()).map(decays).collect();
    let at = |angle: usize, thickness_cm: f32| {
        splines.at_angle(angle, if decays[angle] { thickness_cm } else { thickness_cm.min(last_cm) })
    };
    ResampledGrid::new(&axes.angles_deg, last_cm, components.count, at)
}

/// Splines of ln R over ln h, resampled without the factor h/(h + 2⁻⁶ cm). Like R, this factor is proportional to the
/// thickness of thin layers, so that the rest varies slowly. One more coefficient holds the base-2 logarithm of the
/// inverse of this factor at the nodes, so that the factor is interpolated like all coefficients.
fn log_reflectance(axes: &Axes, sample: &SampleCoefficients) -> ResampledGrid {
    let count = sample.components.count;
    let log_axes = Axes { thicknesses_cm: axes.thicknesses_cm.iter().map(|h| h.ln()).collect(), ..axes.clone() };
    let splines = splines(&log_axes, &sample.values, None, None);
    let ends = &axes.thicknesses_cm;
    let (first_cm, last_cm) = (single(ends[0]), single(ends[ends.len() - 1]));
    let (first, last) = (splines.first_knot(), splines.last_knot());
    let at = |angle: usize, thickness_cm: f32| {
        let mut coefficients = splines.at_angle(angle, thickness_cm.ln().clamp(first, last));
        // Below the first knot R is proportional to the thickness.
        coefficients[count] = ((thickness_cm + OFFSET_CM) / thickness_cm.max(first_cm)).log2();
        coefficients
    };
    ResampledGrid::new(&axes.angles_deg, last_cm, count + 1, at)
}

/// Splines through the table's knots and the end knots.
fn splines(axes: &Axes, coefficients: &[f64], before: Option<EndKnot>, after: Option<EndKnot>) -> SplineGrid {
    let (mut knots, mut values) = (axes.thicknesses_cm.clone(), Vec::new());
    if let Some(before) = &before {
        knots.insert(0, before.thickness_cm);
    }
    knots.extend(after.iter().map(|after| after.thickness_cm));
    for at_angle in coefficients.chunks_exact(coefficients.len() / axes.angles_deg.len()) {
        values.extend(before.iter().flat_map(|before| &before.values));
        values.extend(at_angle);
        values.extend(after.iter().flat_map(|after| &after.values));
    }
    SplineGrid::new(&axes.angles_deg, &knots, &values)
}

/// A mix of two snow samples of one table.
#[derive(Debug, Clone, Copy)]
pub struct SnowMix<'snow> {
    first: &'snow PcaSnow,
    second: &'snow PcaSnow,
    fraction: f32,
}

impl<'snow> SnowMix<'snow> {
    /// A mix of a single sample.
    #[must_use]
    pub const fn single(snow: &'snow PcaSnow) -> Self {
        Self { first: snow, second: snow, fraction: 0.0 }
    }

    /// A fraction of the second sample, 0–1, and the rest of the first. Samples of a table in linear space are not
    /// mixed, since the paper's scheme does not interpolate between samples: the sample with the larger fraction is
    /// taken.
    #[must_use]
    pub const fn new(first: &'snow PcaSnow, second: &'snow PcaSnow, fraction: f32) -> Self {
        match (&first.curves, &second.curves) {
            (Curves::Log { .. }, Curves::Log { .. }) => Self { first, second, fraction },
            _ if fraction < 0.5 => Self::single(first),
            _ => Self::single(second),
        }
    }

    /// Angle of incidence to look up, in degrees: [`PcaSnow::look_up_angle_deg`].
    #[must_use]
    #[inline]
    pub fn look_up_angle_deg(&self, cos_incidence: f32) -> f32 {
        self.first.look_up_angle_deg(cos_incidence)
    }

    /// Writes the spectral transmittance of `thickness_cm` for light at `angle_deg` from the normal into `spectrum`.
    ///
    /// # Panics
    /// If the length of `spectrum` is not the number of wavelengths.
    pub fn transmittance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        // In these cases the result does not depend on the mix.
        if self.fraction <= 0.0 || thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return self.first.transmittance(thickness_cm, angle_deg, spectrum);
        }
        self.first.check_length(spectrum);
        let (mut mixed, mut second) = ([0.0; PADDED_COMPONENTS], [0.0; PADDED_COMPONENTS]);
        self.first.transmittance_coefficients(thickness_cm, angle_deg, &mut mixed);
        self.second.transmittance_coefficients(thickness_cm, angle_deg, &mut second);
        mixed.iter_mut().zip(second).for_each(|(mixed, second)| *mixed += self.fraction * (second - *mixed));
        self.first.transmittance_basis.transmittance(&mixed, spectrum);
    }

    /// Writes the spectral reflectance of `thickness_cm` for light at `angle_deg` from the normal into `spectrum`.
    ///
    /// # Panics
    /// If the length of `spectrum` is not the number of wavelengths.
    pub fn reflectance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        let (Curves::Log { reflectance: first, .. }, Curves::Log { reflectance: second, .. }) =
            (&self.first.curves, &self.second.curves)
        else {
            return self.first.reflectance(thickness_cm, angle_deg, spectrum);
        };
        if self.fraction <= 0.0 || thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return self.first.reflectance(thickness_cm, angle_deg, spectrum);
        }
        self.first.check_length(spectrum);
        let (mut mixed, mut other) = ([0.0; PADDED_COMPONENTS], [0.0; PADDED_COMPONENTS]);
        let [first_cm, second_cm] = [self.first, self.second].map(|snow| snow.equivalent_thickness_cm(thickness_cm));
        first.coefficients(first_cm, angle_deg, &mut mixed);
        second.coefficients(second_cm, angle_deg, &mut other);
        mixed.iter_mut().zip(other).for_each(|(mixed, other)| *mixed += self.fraction * (other - *mixed));
        let [first_factor, second_factor] = [first_cm, second_cm].map(|h| h / (h + OFFSET_CM));
        let factor = first_factor * (second_factor / first_factor).powf(self.fraction);
        let scale = Scale { factor, log2: mixed[self.first.count] };
        self.first.reflectance_basis.powers_of_two(&mixed, scale, spectrum);
    }
}
