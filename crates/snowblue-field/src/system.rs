//! The linear systems of diffusion on a grid, for a few absorption coefficients at once.
//!
//! The equation ∇·(D ∇φ) = μ_a φ with D = ℓ*/3 and the surface condition φ + q ℓ* ∂φ/∂n = 4 Σ K F has the weak form
//!
//! ∫ D ∇φ·∇v dV + ∫ μ_a φ v dV + 1/(3q) ∮ φ v dA = 1/(3q) ∮ 4 Σ K F v dA   for all v,
//!
//! which trilinear elements on a grid turn into a symmetric positive definite matrix.

use std::ops::Range;

use rayon::prelude::*;
use wide::f32x4;

use crate::element::{CORNERS, CellIntegrals, ENTRIES, entry, shape};
use crate::grid::{Cell, Grid, Term};
use crate::octree::NONE;
use crate::vectors::ROWS_PER_TASK;

/// Diffusion and absorption of snow at four wavelengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diffusion {
    /// Transport mean free path ℓ*, in m.
    pub transport_length_m: f32x4,
    /// Absorption coefficient μ_a, in 1/m.
    pub absorption_per_m: f32x4,
}

impl Diffusion {
    /// The mixture of the snow in a cell, by shares that add up to 1: the means of μ_a and of 1/ℓ*.
    ///
    /// Across layers, diffusing media are in series. The flux is equal in all layers, so that the drops of the fluence
    /// rate add up, each in proportion to the 3/ℓ* of its layer.
    #[must_use]
    pub fn mixture(shares: impl IntoIterator<Item = (f32, Self)>) -> Self {
        let (mut absorption_per_m, mut inverse_length_per_m) = (f32x4::ZERO, f32x4::ZERO);
        for (share, snow) in shares {
            absorption_per_m += snow.absorption_per_m * share;
            inverse_length_per_m += f32x4::splat(share) / snow.transport_length_m;
        }
        Self { transport_length_m: f32x4::ONE / inverse_length_per_m, absorption_per_m }
    }
}

/// A sparse symmetric matrix for each of four wavelengths, over the free nodes.
#[derive(Debug)]
pub(crate) struct System {
    row_starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f32x4>,
    pub(crate) inverse_diagonal: Vec<f32x4>,
}

/// A corner of a cell that depends on a free node.
#[derive(Debug, Clone, Copy)]
struct Use {
    cell: u32,
    corner: u8,
    weight: f32,
}

/// The integrals over each cut cell, in single precision.
struct CutIntegrals {
    stiffness: [f32; ENTRIES],
    mass: [f32; ENTRIES],
    surface: [f32; ENTRIES],
    /// Mean square of the cell's width across the surface, in m².
    square_width_m2: f32,
}

impl System {
    /// Assembles the matrices of a grid. `diffusion` is the snow of each cell, and `extrapolation` is q.
    pub(crate) fn new(grid: &Grid, diffusion: &[Diffusion], extrapolation: f64) -> Self {
        let integrals = CellIntegrals::new(grid.lattice.step);
        let cut = cut_integrals(grid, &integrals);
        let [whole_stiffness, whole_mass] = [integrals.stiffness, integrals.mass].map(single);
        let surface_factor = single_value(1.0 / (3.0 * extrapolation));
        let cell_entry = |number: usize, cell: &Cell, position: usize| -> f32x4 {
            let Diffusion { transport_length_m, absorption_per_m } = diffusion[number];
            let diffusion_m = transport_length_m * (1.0 / 3.0);
            if cell.cut == NONE {
                let width = (1u32 << cell.level) as f32;
                return diffusion_m * (width * whole_stiffness[position])
                    + absorption_per_m * (width * width * width * whole_mass[position]);
            }
            let CutIntegrals { stiffness, mass, surface, square_width_m2 } = &cut[cell.cut as usize];
            diffusion_m * stiffness[position]
                + absorption_per_m * mass[position]
                + end_correction(&diffusion[number], *square_width_m2) * (surface_factor * surface[position])
        };
        let (use_starts, uses) = uses(grid);
        let rows = |rows: Range<usize>| {
            let mut task = Self::empty();
            let mut row: Vec<(u32, f32x4)> = Vec::with_capacity(64);
            for free in rows {
                row.clear();
                for corner_use in &uses[use_starts[free] as usize..use_starts[free + 1] as usize] {
                    let number = corner_use.cell as usize;
                    let cell = &grid.cells[number];
                    for corner in 0..CORNERS {
                        let value =
                            cell_entry(number, cell, entry(corner_use.corner.into(), corner)) * corner_use.weight;
                        for term in grid.terms(cell.corners[corner]) {
                            let value = value * term.weight;
                            match row.iter_mut().find(|(column, _)| *column == term.free) {
                                Some((_, sum)) => *sum += value,
                                None => row.push((term.free, value)),
                            }
                        }
                    }
                }
                row.sort_unstable_by_key(|(column, _)| *column);
                let diagonal = row.iter().find(|(column, _)| *column as usize == free).map(|(_, value)| *value);
                task.inverse_diagonal.push(f32x4::ONE / diagonal.unwrap_or(f32x4::ONE));
                task.columns.extend(row.iter().map(|(column, _)| *column));
                task.values.extend(row.iter().map(|(_, value)| *value));
                task.row_starts.push(task.columns.len());
            }
            task
        };
        let tasks: Vec<Self> = tasks(grid.free_count).into_par_iter().map(rows).collect();
        let mut system = Self::empty();
        system.row_starts.push(0);
        for task in tasks {
            let first = system.columns.len();
            system.row_starts.extend(task.row_starts.iter().map(|start| first + start));
            system.columns.extend(task.columns);
            system.values.extend(task.values);
            system.inverse_diagonal.extend(task.inverse_diagonal);
        }
        system
    }

    fn empty() -> Self {
        Self { row_starts: Vec::new(), columns: Vec::new(), values: Vec::new(), inverse_diagonal: Vec::new() }
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.inverse_diagonal.len()
    }

    /// Memory, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.row_starts)
            + size_of_val(&*self.columns)
            + size_of_val(&*self.values)
            + size_of_val(&*self.inverse_diagonal)
    }

    /// A row times a vector.
    #[inline]
    pub(crate) fn row_product(&self, row: usize, vector: &[f32x4]) -> f32x4 {
        let range = self.row_starts[row]..self.row_starts[row + 1];
        let mut sum = f32x4::ZERO;
        for (column, value) in self.columns[range.clone()].iter().zip(&self.values[range]) {
            sum += *value * vector[*column as usize];
        }
        sum
    }

    /// Typical memory of a free node, in bytes: some 30 entries of its row, and vectors of the solver.
    pub(crate) const BYTES_PER_NODE: usize = 30 * (size_of::<u32>() + size_of::<f32x4>()) + 8 * size_of::<f32x4>();
}

/// The ranges of rows of all tasks.
pub(crate) fn tasks(rows: usize) -> Vec<Range<usize>> {
    (0..rows).step_by(ROWS_PER_TASK).map(|start| start..(start + ROWS_PER_TASK).min(rows)).collect()
}

/// The right-hand side for light that enters at the surface. `light` is Σ K F plus the diffuse irradiance at each
/// surface element, and `diffusion` is the snow of each cell.
pub(crate) fn right_hand_side(grid: &Grid, light: &[f32x4], diffusion: &[Diffusion], extrapolation: f64) -> Vec<f32x4> {
    let factor = single_value(4.0 / (3.0 * extrapolation));
    let mut sums = vec![f32x4::ZERO; grid.free_count];
    for (number, elements) in grid.numbered_surface_cells() {
        let cell = &grid.cells[number];
        let correction = end_correction(&diffusion[number], square_width_m2(grid, cell, elements.clone()));
        for index in elements {
            let element = &grid.surface[index];
            let shape = shape(grid.within(cell, element.point.as_dvec3()));
            let source = light[index] * correction * (factor * element.area_m2);
            for (node, value) in cell.corners.iter().zip(shape) {
                for Term { free, weight } in grid.terms(*node) {
                    sums[*free as usize] += source * (value * weight);
                }
            }
        }
    }
    sums
}

/// Factor of the surface terms in a cell at the surface.
///
/// With the integration rule of the elements, absorption is summed by the trapezoidal rule across the cells. The
/// leading error of the trapezoidal rule is −h²/12 times the slope at the ends (Euler–Maclaurin). The surface
/// condition gives the slope at the surface.
fn end_correction(diffusion: &Diffusion, square_width_m2: f32) -> f32x4 {
    let Diffusion { transport_length_m, absorption_per_m } = *diffusion;
    f32x4::ONE + absorption_per_m / transport_length_m * (0.25 * square_width_m2)
}

/// Share of the diffuse irradiance that a slab of a thickness in m does not return on the side of incidence: −J
/// divided by the irradiance, for the solution φ ∝ sinh κ(d − z) + qκℓ* cosh κ(d − z) without light on the opposite
/// side. The share is limited to 1, which diffusion exceeds where snow absorbs nearly all light.
pub(crate) fn slab_absorptance(diffusion: &Diffusion, thickness_m: f32, extrapolation: f64) -> f32x4 {
    let Diffusion { transport_length_m, absorption_per_m } = *diffusion;
    let (lengths_m, absorption_per_m) = (transport_length_m.to_array(), absorption_per_m.to_array());
    let thickness_m = f64::from(thickness_m);
    f32x4::from(std::array::from_fn(|k| {
        let length_m = f64::from(lengths_m[k]);
        let decay_per_m = (3.0 * f64::from(absorption_per_m[k]) / length_m).sqrt().max(MIN_DECAY / length_m);
        let (slope, tanh) = (decay_per_m * length_m, (decay_per_m * thickness_m).tanh());
        let passed = extrapolation * slope;
        let absorptance = 4.0 / 3.0 * slope * (1.0 + passed * tanh) / ((1.0 + passed * passed) * tanh + 2.0 * passed);
        single_value(absorptance.min(1.0))
    }))
}

/// Decay of light over a transport mean free path that replaces zero where there is no absorption.
const MIN_DECAY: f64 = 1e-6;

/// Widths of a cell, in decay lengths 1/κ, between which the flux at its surface changes from the flux of the grid to
/// the flux of a half-space.
const UNRESOLVED_WIDTHS: [f32; 2] = [0.75, 1.75];
/// Thicknesses of the snow below, in decay lengths 1/κ, between which the flux changes likewise. Less than e⁻² of the
/// light passes through thicker snow.
const HALF_SPACE_DEPTHS: [f32; 2] = [2.0, 3.0];
/// The net flux in a cell at the surface that is too wide for the flux of the grid to be right.
///
/// Light decays as e^{−κz} below the surface, with κ² = 3 μ_a / ℓ*. A cell wider than 1/κ does not resolve this decay,
/// and absorbs too much or too little, depending on how the surface cuts the cell. Where the snow is also thicker than
/// a few 1/κ, the flux is the flux of a half-space, J = −4 Σ K F κℓ*/3 / (1 + q κℓ*).
pub(crate) struct WideCell {
    /// κ, in 1/m.
    decay_per_m: f32x4,
    /// The share of the flux of a half-space, by the width of the cell.
    share: f32x4,
    /// The flux of a half-space, divided by Σ K F.
    half_space: f32x4,
}

impl WideCell {
    /// Prepares the flux of a cell with some surface elements; none if the cell is narrow at all wavelengths.
    pub(crate) fn new(
        grid: &Grid,
        (cell, elements): (&Cell, Range<usize>),
        diffusion: &Diffusion,
        extrapolation: f64,
    ) -> Option<Self> {
        let Diffusion { transport_length_m, absorption_per_m } = *diffusion;
        let decay_per_m = (absorption_per_m * 3.0 / transport_length_m).sqrt();
        let share = part(UNRESOLVED_WIDTHS, decay_per_m * square_width_m2(grid, cell, elements).sqrt());
        let slope = decay_per_m * transport_length_m;
        let half_space = slope * (-4.0 / 3.0) / (f32x4::ONE + slope * single_value(extrapolation));
        share.to_array().iter().any(|share| *share > 0.0).then_some(Self { decay_per_m, share, half_space })
    }

    /// The flux that the grid misses at an element, for snow of a thickness in m. All fluxes are divided by Σ K F, and
    /// `grid_flux` is the flux under uniform light.
    pub(crate) fn missing_flux(&self, grid_flux: f32x4, thickness_m: f32) -> f32x4 {
        self.share * part(HALF_SPACE_DEPTHS, self.decay_per_m * thickness_m) * (self.half_space - grid_flux)
    }
}

/// Relative position of values between two ends, limited to the range from 0 to 1.
pub(crate) fn part([start, end]: [f32; 2], values: f32x4) -> f32x4 {
    ((values - f32x4::splat(start)) / f32x4::splat(end - start)).fast_max(f32x4::ZERO).fast_min(f32x4::ONE)
}

/// Mean square of the width of a cell across its surface elements, in m².
fn square_width_m2(grid: &Grid, cell: &Cell, elements: Range<usize>) -> f32 {
    let step = grid.cell_size(cell).as_vec3();
    let (mut area_m2, mut sum) = (f32::MIN_POSITIVE, 0.0);
    for element in &grid.surface[elements] {
        let width_m = element.normal.abs().dot(step);
        area_m2 += element.area_m2;
        sum += element.area_m2 * width_m * width_m;
    }
    sum / area_m2
}

fn cut_integrals(grid: &Grid, integrals: &CellIntegrals) -> Vec<CutIntegrals> {
    let cells: Vec<(&Cell, Range<usize>)> = grid.surface_cells().collect();
    let of_cell = |(cell, elements): (&Cell, Range<usize>)| {
        let (stiffness, mass) = match &grid.cut_cells[cell.cut as usize].inside {
            Some(inside) => integrals.cut(inside),
            None => (integrals.stiffness, integrals.mass),
        };
        let mut surface = [0.0; ENTRIES];
        for element in &grid.surface[elements.clone()] {
            let shape = shape(grid.within(cell, element.point.as_dvec3()));
            for a in 0..CORNERS {
                for b in a..CORNERS {
                    surface[entry(a, b)] += element.area_m2 * shape[a] * shape[b];
                }
            }
        }
        let width = f64::from(1u32 << cell.level);
        CutIntegrals {
            stiffness: single(stiffness.map(|value| width * value)),
            mass: single(mass.map(|value| width * width * width * value)),
            surface,
            square_width_m2: square_width_m2(grid, cell, elements),
        }
    };
    cells.into_par_iter().map(of_cell).collect()
}

/// For each free node the cell corners that depend on it: the ranges and the list.
fn uses(grid: &Grid) -> (Vec<u32>, Vec<Use>) {
    let mut starts = vec![0; grid.free_count + 1];
    let corners = || {
        grid.cells.iter().enumerate().flat_map(|(number, cell)| {
            let terms = move |corner: usize| grid.terms(cell.corners[corner]).iter().map(move |term| (corner, term));
            (0..CORNERS).flat_map(terms).map(move |(corner, term)| (number, corner, *term))
        })
    };
    corners().for_each(|(_, _, term)| starts[term.free as usize + 1] += 1);
    for free in 0..grid.free_count {
        starts[free + 1] += starts[free];
    }
    let mut next = starts.clone();
    let mut uses = vec![Use { cell: 0, corner: 0, weight: 0.0 }; starts[grid.free_count] as usize];
    for (number, corner, term) in corners() {
        let place = &mut next[term.free as usize];
        #[expect(clippy::cast_possible_truncation, reason = "fewer than 2^31 cells of eight corners")]
        let corner_use = Use { cell: number as u32, corner: corner as u8, weight: term.weight };
        uses[*place as usize] = corner_use;
        *place += 1;
    }
    (starts, uses)
}

#[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
fn single_value(value: f64) -> f32 {
    value as f32
}

fn single(matrix: [f64; ENTRIES]) -> [f32; ENTRIES] {
    matrix.map(single_value)
}
