//! PCASnow's look-up: the spectrum of one snow at any thickness and angle (the paper's Algorithm 1).
//!
//! A cubic spline over the thickness at the two nearest angles, then a straight line between the angles, both on the
//! coefficients of the principal components, which is exact as both are linear; then C' V'ᵀ once. The form follows the
//! table's space:
//!
//! - `linear`, the paper's: the spline runs through 0 cm (white) and 100 cm (black); beyond 100 cm and beyond 89° there
//!   is nothing. It overshoots between the knots, as the paper's does.
//! - `log`: the spline of ln T runs through ln T = 0 at 0 cm and goes on in a straight line beyond the last knot, since
//!   deep in snow light fades exponentially. Angles beyond the last one are taken as that one.
//!
//! Reflectance is interpolated in the same way but over ln h: it starts in proportion to the thickness and levels off.

use wide::f32x8;

use crate::pca::{Components, MOST_COMPONENTS};
use crate::spline::{Piece, curvatures, piece};
use crate::{CompressedTable, DatabaseError, Quantity, Space};

/// Light through snow thicker than this is black in the paper's scheme, in cm.
pub const PAPER_BLACK_BEYOND_CM: f32 = 100.0;
/// Light does not reach a face that it would meet at this angle or a larger one, in degrees.
pub const HORIZON_DEG: f32 = 90.0;

/// Wavelengths that are rebuilt together.
const LANES: usize = 8;

/// A sample by its place on the table's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridSample {
    /// Mean grain size, in µm.
    pub grain_size_um: f64,
    /// Mean facetness.
    pub facetness: f64,
    /// Density, in kg/m³.
    pub density_kg_m3: f64,
}

/// One sample's curves, ready to be looked up.
#[derive(Debug, Clone)]
pub struct PcaSnow {
    space: Space,
    wavelengths_nm: Vec<f64>,
    angles_deg: Vec<f32>,
    transmittance: Curves,
    reflectance: Curves,
}

/// Splines of one quantity: [angle][knot][value or second derivative][component].
#[derive(Debug, Clone)]
struct Curves {
    knots: Vec<f32>,
    count: usize,
    pieces: Vec<f32>,
    /// Eight wavelengths at a time, and for each eight the components; what lies beyond the last wavelength is 0.
    basis: Vec<f32x8>,
}

impl PcaSnow {
    /// Takes the curves of one sample out of a table.
    ///
    /// # Errors
    /// [`DatabaseError::OffGrid`] if a value of the sample is not on the table's axes.
    pub fn new(table: &CompressedTable, sample: GridSample) -> Result<Self, DatabaseError> {
        let axes = &table.axes;
        let size = place("grain size", " µm", &axes.grain_sizes_um, sample.grain_size_um)?;
        let facetness = place("facetness", "", &axes.facetness, sample.facetness)?;
        let density = place("density", " kg/m³", &axes.densities_kg_m3, sample.density_kg_m3)?;
        let mut row = (size * axes.facetness.len() + facetness) * axes.densities_kg_m3.len() + density;
        for (property, values) in &axes.further {
            row = row * values.len() + place(property.name(), "", values, property.usual())?;
        }
        let curves = |quantity| Curves::new(table, quantity, row);
        Ok(Self {
            space: table.space,
            wavelengths_nm: axes.wavelengths_nm.clone(),
            angles_deg: axes.angles_deg.iter().map(|angle| single(*angle)).collect(),
            transmittance: curves(Quantity::Transmittance),
            reflectance: curves(Quantity::Reflectance),
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
        if thickness_cm <= 0.0 {
            return spectrum.fill(if angle_deg < HORIZON_DEG { 1.0 } else { 0.0 });
        }
        let dark = match self.space {
            Space::Linear => thickness_cm > PAPER_BLACK_BEYOND_CM || angle_deg > self.last_angle_deg(),
            Space::Log => angle_deg >= HORIZON_DEG,
        };
        if dark {
            return spectrum.fill(0.0);
        }
        self.spectrum(&self.transmittance, thickness_cm, (angle_deg, 0.0), spectrum);
    }

    /// Reflectance at each wavelength of `thickness_cm` for light at `angle_deg` from the normal, into `spectrum`.
    ///
    /// # Panics
    /// If `spectrum` has not as many values as there are wavelengths.
    pub fn reflectance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        if thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return spectrum.fill(0.0);
        }
        let knots = &self.reflectance.knots;
        let x = match self.space {
            Space::Linear => thickness_cm,
            Space::Log => thickness_cm.ln(),
        };
        let (first, last) = (knots[0], knots[knots.len() - 1]);
        self.spectrum(&self.reflectance, x.clamp(first, last), (angle_deg, (x - first).min(0.0)), spectrum);
    }

    fn last_angle_deg(&self) -> f32 {
        self.angles_deg[self.angles_deg.len() - 1]
    }

    /// The spectrum at spline place `x` and an angle; `offset` is added to every value in this space.
    #[inline]
    fn spectrum(&self, curves: &Curves, x: f32, (angle_deg, offset): (f32, f32), spectrum: &mut [f32]) {
        assert_eq!(spectrum.len(), self.wavelengths_nm.len(), "a value for each wavelength");
        let mut coefficients = [0.0; MOST_COMPONENTS];
        let coefficients = &mut coefficients[..curves.count];
        let (angle, share) = self.between_angles(angle_deg);
        let piece = piece(&curves.knots, x);
        curves.add(angle, 1.0 - share, piece, coefficients);
        if share > 0.0 {
            curves.add(angle + 1, share, piece, coefficients);
        }
        for (values, basis) in spectrum.chunks_mut(LANES).zip(curves.basis.chunks_exact(curves.count)) {
            let mut sum = f32x8::splat(offset);
            for (coefficient, shape) in coefficients.iter().zip(basis) {
                sum += f32x8::splat(*coefficient) * shape;
            }
            let eight = match self.space {
                Space::Linear => sum,
                Space::Log => sum.exp(),
            };
            values.copy_from_slice(&eight.to_array()[..values.len()]);
        }
    }

    /// The angle on the axis below, and how far on the way to the next.
    fn between_angles(&self, angle_deg: f32) -> (usize, f32) {
        let angles = &self.angles_deg;
        if angles.len() == 1 || angle_deg <= angles[0] {
            return (0, 0.0);
        }
        let below = (angles.partition_point(|angle| *angle <= angle_deg) - 1).min(angles.len() - 2);
        (below, ((angle_deg - angles[below]) / (angles[below + 1] - angles[below])).min(1.0))
    }
}

impl Curves {
    fn new(table: &CompressedTable, quantity: Quantity, sample: usize) -> Self {
        let components = table.components(quantity);
        let thicknesses = table.axes.thicknesses_cm.len();
        let per_angle = thicknesses * components.count;
        // Lambertian light, which stands first, is not looked up.
        let beams = if table.axes.diffuse { per_angle } else { 0 };
        let start = sample * table.axes.curves_per_sample() * components.count + beams;
        let (knots, [before, after]) = knots(table, quantity, components);
        let mut pieces = Vec::new();
        for angle in 0..table.axes.angles_deg.len() {
            let coefficients = &components.coefficients[start + angle * per_angle..][..per_angle];
            let inner = coefficients.iter().map(|c| f64::from(*c));
            let values: Vec<f64> = before.iter().copied().chain(inner).chain(after.iter().copied()).collect();
            let column = |c: usize| values.iter().skip(c).step_by(components.count).copied().collect::<Vec<f64>>();
            let columns: Vec<(Vec<f64>, Vec<f64>)> =
                (0..components.count).map(column).map(|y| (curvatures(&knots, &y), y)).collect();
            for knot in 0..knots.len() {
                pieces.extend(columns.iter().map(|(_, y)| single(y[knot])));
                pieces.extend(columns.iter().map(|(second, _)| single(second[knot])));
            }
        }
        let knots = knots.into_iter().map(single).collect();
        Self { knots, count: components.count, pieces, basis: lanes(components) }
    }

    /// Adds `share` of the splines at one angle to `coefficients`.
    #[inline]
    fn add(&self, angle: usize, share: f32, piece: Piece, coefficients: &mut [f32]) {
        let n = self.count;
        let start = (angle * self.knots.len() + piece.knot) * 2 * n;
        let (below, above) = self.pieces[start..start + 4 * n].split_at(2 * n);
        for (c, coefficient) in coefficients.iter_mut().enumerate() {
            let values = piece.values[0] * below[c] + piece.values[1] * above[c];
            let bends = piece.curvatures[0] * below[n + c] + piece.curvatures[1] * above[n + c];
            *coefficient += share * (values + bends);
        }
    }
}

/// The basis, eight wavelengths at a time.
fn lanes(components: &Components) -> Vec<f32x8> {
    let wavelengths = components.basis.len() / components.count;
    let entry = |wavelength: usize, component: usize| {
        if wavelength < wavelengths { components.basis[wavelength * components.count + component] } else { 0.0 }
    };
    let eight = |first: usize, component: usize| f32x8::new(std::array::from_fn(|lane| entry(first + lane, component)));
    let firsts = (0..wavelengths).step_by(LANES);
    firsts.flat_map(|first| (0..components.count).map(move |component| eight(first, component))).collect()
}

/// The places of the knots, and the coefficients of knots that the form adds before and after the table's own.
fn knots(table: &CompressedTable, quantity: Quantity, components: &Components) -> (Vec<f64>, [Vec<f64>; 2]) {
    let thicknesses = &table.axes.thicknesses_cm;
    let nothing = vec![0.0; components.count];
    let with_zero = [&[0.0], &thicknesses[..]].concat();
    match (table.space, quantity) {
        // ln T = 0 where there is no snow.
        (Space::Log, Quantity::Transmittance) => (with_zero, [nothing, vec![]]),
        (Space::Log, Quantity::Reflectance) => (thicknesses.iter().map(|h| h.ln()).collect(), [vec![], vec![]]),
        (Space::Linear, Quantity::Reflectance) => (with_zero, [nothing, vec![]]),
        (Space::Linear, Quantity::Transmittance) => {
            let white = (0..components.count)
                .map(|c| components.basis.iter().skip(c).step_by(components.count).map(|v| f64::from(*v)).sum())
                .collect();
            let black = f64::from(PAPER_BLACK_BEYOND_CM);
            if thicknesses[thicknesses.len() - 1] < black {
                ([&with_zero[..], &[black]].concat(), [white, nothing])
            } else {
                (with_zero, [white, vec![]])
            }
        }
    }
}

/// The place of a value on an axis.
fn place(quantity: &'static str, unit: &'static str, axis: &[f64], value: f64) -> Result<usize, DatabaseError> {
    axis.iter().position(|known| (known - value).abs() <= 1e-9 * known.abs()).ok_or_else(|| {
        let known = axis.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        DatabaseError::OffGrid { quantity, value, known, unit }
    })
}

#[expect(clippy::cast_possible_truncation, reason = "look-ups run in single precision")]
fn single(value: f64) -> f32 {
    value as f32
}
