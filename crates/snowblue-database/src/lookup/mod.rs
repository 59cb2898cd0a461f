//! PCASnow's look-up: the spectrum of one snow at any thickness and angle (the paper's Algorithm 1).
//!
//! Coefficients of the principal components are interpolated over thickness and angle, then C' V'ᵀ is taken once. The
//! form follows the table's space:
//!
//! - `linear`, the paper's (`splines`): a cubic spline over the thickness at the two nearest angles, then a straight line
//!   between them. The spline runs through 0 cm (white) and 100 cm (black); beyond 100 cm and beyond 89° there is nothing.
//!   It overshoots between the knots, as the paper's does. Snow is that of the grid alone.
//! - `log`, ours: the spline of ln T runs through ln T = 0 at 0 cm and goes on in a straight line beyond the last knot,
//!   since deep in snow light fades exponentially (where that line would rise, it stays); between the angles it is a cubic. Angles beyond the last one are taken
//!   as that one. All of it is worked out beforehand (`resampled`), for any snow within the axes (`blend`).
//!
//! Reflectance is interpolated in the same way, in log space over ln h: it starts in proportion to the thickness and
//! levels off.

mod basis;
mod between;
mod resampled;
mod splines;
mod weighed;

use std::f64::consts::LOG2_E;

pub use basis::Lanes;
pub use between::Between;
pub use weighed::{SUMS, WeighedSnow};

use basis::{Basis, LANES};
use resampled::{Resampled, THIN_CM};
use splines::Splines;

use crate::blend::Blend;
use crate::pca::{Components, single};
use crate::{Axes, CompressedTable, DatabaseError, Quantity, Space, TableSample};

/// Light through snow thicker than this is black in the paper's scheme, in cm.
pub const PAPER_BLACK_BEYOND_CM: f32 = 100.0;
/// Light does not reach a face that it would meet at this angle or a larger one, in degrees.
pub const HORIZON_DEG: f32 = 90.0;

/// One sample's curves, ready to be looked up.
#[derive(Debug, Clone)]
pub struct PcaSnow {
    wavelengths_nm: Vec<f64>,
    last_angle_deg: f32,
    last_thickness_cm: f32,
    thicker: f32,
    count: usize,
    transmittance_basis: Basis,
    reflectance_basis: Basis,
    curves: Curves,
}

/// Coefficients over thickness and angle, in either form.
#[derive(Debug, Clone)]
enum Curves {
    Paper { transmittance: Splines, reflectance: Splines },
    Log { transmittance: Resampled, reflectance: Resampled },
}

impl PcaSnow {
    /// Takes the curves of one sample out of a table: of the grid's own out of one in linear space, of any within the axes
    /// out of one in log space.
    ///
    /// # Errors
    /// [`DatabaseError::OffGrid`] or [`DatabaseError::OffAxis`] if a value of the sample is beyond the table,
    /// [`DatabaseError::NoAxis`] if the table knows nothing of it.
    pub fn new(table: &CompressedTable, sample: &TableSample) -> Result<Self, DatabaseError> {
        let axes = &table.axes;
        if axes.angles_deg.is_empty() {
            return Err(DatabaseError::AxisRange { name: "angle", what: "an angle, since look-ups are of beams" });
        }
        let blend = match table.space {
            Space::Linear => Blend::on_grid(axes, sample)?,
            Space::Log => Blend::between(axes, sample)?,
        };
        let coefficients =
            |quantity: Quantity| (table.components(quantity), blend.coefficients(table, table.components(quantity)));
        let (transmittance, reflectance) = (coefficients(Quantity::Transmittance), coefficients(Quantity::Reflectance));
        let (curves, scale) = match table.space {
            Space::Linear => {
                let (transmittance, reflectance) =
                    (paper_transmittance(axes, transmittance), paper_reflectance(axes, reflectance));
                (Curves::Paper { transmittance, reflectance }, 1.0)
            }
            Space::Log => {
                let (transmittance, reflectance) =
                    (log_transmittance(axes, transmittance), log_reflectance(axes, reflectance));
                (Curves::Log { transmittance, reflectance }, LOG2_E)
            }
        };
        let last = |values: &[f64]| single(values[values.len() - 1]);
        Ok(Self {
            wavelengths_nm: axes.wavelengths_nm.clone(),
            last_angle_deg: last(&axes.angles_deg),
            last_thickness_cm: last(&axes.thicknesses_cm),
            thicker: single(blend.thicker),
            count: table.transmittance.count,
            transmittance_basis: Basis::new(&table.transmittance, scale),
            reflectance_basis: Basis::new(&table.reflectance, scale),
            curves,
        })
    }

    /// Wavelengths of the spectra, in nm.
    #[must_use]
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }

    /// Transmittance at each wavelength through `thickness_cm` for light at `angle_deg` from the normal, into `spectrum`.
    ///
    /// # Panics
    /// If `spectrum` has not as many values as there are wavelengths.
    pub fn transmittance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        self.check_length(spectrum);
        let mut coefficients = [0.0; LANES];
        if thickness_cm <= 0.0 {
            return spectrum.fill(if angle_deg < HORIZON_DEG { 1.0 } else { 0.0 });
        }
        match &self.curves {
            Curves::Paper { transmittance, .. } => {
                if thickness_cm > PAPER_BLACK_BEYOND_CM || angle_deg > self.last_angle_deg {
                    return spectrum.fill(0.0);
                }
                transmittance.coefficients(thickness_cm, angle_deg, &mut coefficients);
                self.transmittance_basis.linear(&coefficients, spectrum);
            }
            Curves::Log { transmittance, .. } => {
                if angle_deg >= HORIZON_DEG {
                    return spectrum.fill(0.0);
                }
                transmittance.coefficients(self.thicker * thickness_cm, angle_deg, &mut coefficients);
                self.transmittance_basis.shares(&coefficients, spectrum);
            }
        }
    }

    /// Reflectance at each wavelength of `thickness_cm` for light at `angle_deg` from the normal, into `spectrum`.
    ///
    /// # Panics
    /// If `spectrum` has not as many values as there are wavelengths.
    pub fn reflectance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        self.check_length(spectrum);
        if thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return spectrum.fill(0.0);
        }
        let mut coefficients = [0.0; LANES];
        match &self.curves {
            Curves::Paper { reflectance, .. } => {
                let (first, last) = reflectance.range();
                reflectance.coefficients(thickness_cm.clamp(first, last), angle_deg, &mut coefficients);
                self.reflectance_basis.linear(&coefficients, spectrum);
            }
            Curves::Log { reflectance, .. } => {
                let thickness_cm = self.seeming_thickness_cm(thickness_cm);
                reflectance.coefficients(thickness_cm, angle_deg, &mut coefficients);
                let ends = (coefficients[self.count], thickness_cm / (thickness_cm + THIN_CM));
                self.reflectance_basis.powers_of_two(&coefficients, ends, spectrum);
            }
        }
    }

    /// The coefficients of transmittance on the table's basis, for thicknesses above 0 cm and angles that the form
    /// reaches, into the first of `coefficients`: what a look-up is without its spectrum.
    #[inline]
    pub fn transmittance_coefficients(&self, thickness_cm: f32, angle_deg: f32, coefficients: &mut Lanes) {
        match &self.curves {
            Curves::Paper { transmittance, .. } => transmittance.coefficients(thickness_cm, angle_deg, coefficients),
            Curves::Log { transmittance, .. } => {
                transmittance.coefficients(self.thicker * thickness_cm, angle_deg, coefficients);
            }
        }
    }

    /// The thickness at which the table's own density reflects as this snow does.
    fn seeming_thickness_cm(&self, thickness_cm: f32) -> f32 {
        (self.thicker * thickness_cm).min(self.last_thickness_cm)
    }

    fn check_length(&self, spectrum: &[f32]) {
        assert_eq!(spectrum.len(), self.wavelengths_nm.len(), "a value for each wavelength");
    }
}

/// Splines through white at 0 cm and, beyond the table, through black at 100 cm.
fn paper_transmittance(axes: &Axes, (components, coefficients): (&Components, Vec<f64>)) -> Splines {
    let white: Vec<f64> = (0..components.count)
        .map(|c| components.basis.iter().skip(c).step_by(components.count).map(|v| f64::from(*v)).sum())
        .collect();
    let black = f64::from(PAPER_BLACK_BEYOND_CM);
    let last = axes.thicknesses_cm[axes.thicknesses_cm.len() - 1];
    let after = if last < black { Some((black, vec![0.0; components.count])) } else { None };
    splines(axes, &coefficients, Some((0.0, white)), after)
}

/// Splines through nothing at 0 cm.
fn paper_reflectance(axes: &Axes, (components, coefficients): (&Components, Vec<f64>)) -> Splines {
    splines(axes, &coefficients, Some((0.0, vec![0.0; components.count])), None)
}

/// Splines of ln T through ln T = 0 at 0 cm, resampled.
fn log_transmittance(axes: &Axes, (components, coefficients): (&Components, Vec<f64>)) -> Resampled {
    let splines = splines(axes, &coefficients, Some((0.0, vec![0.0; components.count])), None);
    let (_, last_cm) = splines.range();
    // Where the dark ends of some wavelengths rise, the straight line beyond would bring light out of nothing.
    let fades = |angle: usize| {
        let [last, beyond] = [last_cm, last_cm + 1.0].map(|h| splines.at_angle(angle, h));
        let rises =
            |shape: &[f32]| shape.iter().zip(last.iter().zip(beyond)).map(|(v, (a, b))| v * (b - a)).sum::<f32>();
        components.basis.chunks_exact(components.count).all(|shape| rises(shape) <= 0.0)
    };
    let fades: Vec<bool> = (0..axes.angles_deg.len()).map(fades).collect();
    let at = |angle: usize, thickness_cm: f32| {
        splines.at_angle(angle, if fades[angle] { thickness_cm } else { thickness_cm.min(last_cm) })
    };
    Resampled::new(&axes.angles_deg, last_cm, components.count, at)
}

/// Splines of ln R over ln h, resampled without the factor h/(h + 2⁻⁶ cm), which starts as R does and takes the steepness
/// away. Where straight lines and splines differ over the thickness, so does the factor's own logarithm, which is in base
/// 2 one component more.
fn log_reflectance(axes: &Axes, (components, coefficients): (&Components, Vec<f64>)) -> Resampled {
    let logarithms = Axes { thicknesses_cm: axes.thicknesses_cm.iter().map(|h| h.ln()).collect(), ..axes.clone() };
    let splines = splines(&logarithms, &coefficients, None, None);
    let ends = &axes.thicknesses_cm;
    let (first_cm, last_cm) = (single(ends[0]), single(ends[ends.len() - 1]));
    let (first, last) = splines.range();
    let at = |angle: usize, thickness_cm: f32| {
        let mut lanes = splines.at_angle(angle, thickness_cm.ln().clamp(first, last));
        // Below the first knot R is in proportion to the thickness.
        lanes[components.count] = ((thickness_cm + THIN_CM) / thickness_cm.max(first_cm)).log2();
        lanes
    };
    Resampled::new(&axes.angles_deg, last_cm, components.count + 1, at)
}

/// Splines through the table's knots and through one before and one after them.
fn splines(
    axes: &Axes,
    coefficients: &[f64],
    before: Option<(f64, Vec<f64>)>,
    after: Option<(f64, Vec<f64>)>,
) -> Splines {
    let (mut knots, mut values) = (axes.thicknesses_cm.clone(), Vec::new());
    if let Some((knot, _)) = &before {
        knots.insert(0, *knot);
    }
    knots.extend(after.iter().map(|(knot, _)| *knot));
    for of_angle in coefficients.chunks_exact(coefficients.len() / axes.angles_deg.len()) {
        values.extend(before.iter().flat_map(|(_, values)| values));
        values.extend(of_angle);
        values.extend(after.iter().flat_map(|(_, values)| values));
    }
    Splines::new(&axes.angles_deg, &knots, &values)
}
