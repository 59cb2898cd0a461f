//! The light field inside a body of snow.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use wide::f32x4;

use crate::body::Body;
use crate::element::{CORNERS, gradients, shape};
use crate::grid::{Cell, Grid, GridOptions, SurfacePlace};
use crate::octree::NONE;
use crate::scan::SurfaceElement;
use crate::solver::solve;
use crate::source::{VolumeSource, add_source};
use crate::spectral_nodes::Groups;
use crate::surface_flux::{NodeFlux, SIDES, SurfaceNodes, sorted_sides};
use crate::system::{Diffusion, System, WideCell, part, right_hand_side, slab_absorptance};

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellBox {
    /// Centre, in m.
    pub centre: DVec3,
    /// Length of its edges along each axis, in m.
    pub size: DVec3,
}

/// A body with its grid and its systems of equations at some wavelengths, in groups of four.
pub struct SnowBody {
    grid: Grid,
    surface_nodes: SurfaceNodes,
    systems: Vec<System>,
    /// The snow of each cell, for each group.
    diffusion: Vec<Vec<Diffusion>>,
    extrapolation: f64,
    /// Flux that the grid misses at each surface element, divided by Σ K F at the element, for each group. Empty for a
    /// group for which all cells at the surface are narrow enough.
    missing_flux: Vec<Vec<f32x4>>,
    /// Number of solutions for four wavelengths so far, and number of their iterations.
    solves: AtomicU64,
    iterations: AtomicU64,
}

/// Initial guess, lamps and stopping criteria of a solution.
#[derive(Debug, Clone, Copy)]
pub struct SolveOptions<'f> {
    /// Initial guess: a solution for similar light.
    pub start: Option<&'f Fluence>,
    /// Lamps inside the body.
    pub sources: &'f [VolumeSource],
    /// Relative residual at which the iteration ends.
    ///
    /// The fluence rate may fall by five orders of magnitude between the lit and the dark side of a body. With a
    /// tolerance of 10⁻⁵, the error at single dark points was up to 77 %; with 10⁻⁶, it was less than the error of the
    /// grid.
    pub tolerance: f64,
    /// Residual relative to the residual of the start at which the iteration also ends.
    pub residual_left: f64,
}

impl Default for SolveOptions<'_> {
    fn default() -> Self {
        Self { start: None, sources: &[], tolerance: 1e-6, residual_left: 0.0 }
    }
}

/// Thickness of a slab in cells up to which cells do not resolve it, and from which on they do.
const RESOLVED_CELLS: [f32; 2] = [1.0, 2.0];

/// A quantity on the surface of a body, smoothed over the size of a cell.
#[derive(Debug, Clone)]
pub struct SurfaceValues(Vec<NodeFlux>);

/// Patches of the surface of a body.
#[derive(Debug)]
pub struct SurfacePatches {
    /// The number of the patch of each surface element.
    pub of_element: Vec<u32>,
    /// The number of the patch of each orientation in each cell at the surface, or [`NONE`].
    of_cell: Vec<[u32; SIDES]>,
    /// The number after the last patch.
    pub end: u32,
}

/// Fluence rates inside a body for one distribution of light on its surface: for each group of four wavelengths, the
/// values of all nodes, in W m⁻² per unit of the light.
#[derive(Debug, Clone)]
pub struct Fluence(Vec<Vec<f32x4>>);

/// Snow that varies from cell to cell.
#[derive(Clone, Copy)]
pub struct SnowOfCells<'a> {
    /// Number of groups of four wavelengths.
    pub groups: usize,
    /// The snow of a cell, for each group.
    pub of_cell: &'a (dyn Fn(&CellBox) -> Vec<Diffusion> + Sync),
    /// Extrapolation length q in units of ℓ*.
    pub extrapolation: f64,
}

impl SnowBody {
    /// Divides a body of uniform snow into cells and prepares its equations. `snow` holds the properties for each
    /// group of four wavelengths, and `extrapolation` is the extrapolation length q in units of ℓ*.
    pub fn uniform(body: &dyn Body, options: GridOptions, snow: &[Diffusion], extrapolation: f64) -> Self {
        let of_cell = |_: &CellBox| snow.to_vec();
        Self::new(body, options, &SnowOfCells { groups: snow.len(), of_cell: &of_cell, extrapolation })
    }

    /// Divides a body into cells and prepares its equations.
    ///
    /// # Panics
    ///
    /// If `of_cell` returns fewer groups for a cell than `groups`.
    pub fn new(body: &dyn Body, options: GridOptions, snow: &SnowOfCells) -> Self {
        let SnowOfCells { groups, of_cell: snow, extrapolation } = *snow;
        let grid = Grid::new(body, options);
        let of_cell = |cell| snow(&CellBox { centre: grid.cell_centre(cell), size: grid.cell_size(cell) });
        let cell_groups: Vec<Vec<Diffusion>> = grid.cells.par_iter().map(of_cell).collect();
        let of_group = |group: usize| cell_groups.iter().map(|groups| groups[group]).collect();
        let diffusion: Vec<Vec<Diffusion>> = (0..groups).map(of_group).collect();
        let systems = diffusion.iter().map(|diffusion| System::new(&grid, diffusion, extrapolation)).collect();
        let surface_nodes = SurfaceNodes::new(&grid);
        let (missing_flux, [solves, iterations]) = (Vec::new(), [0; 2].map(AtomicU64::new));
        let mut body =
            Self { surface_nodes, grid, systems, diffusion, extrapolation, missing_flux, solves, iterations };
        body.missing_flux = (0..groups).map(|group| body.missing_flux(group)).collect();
        body
    }

    /// Compares the flux of the grid under uniform light with the flux of a half-space, in wide cells.
    fn missing_flux(&self, group: usize) -> Vec<f32x4> {
        let wide_cell = |(number, elements): (usize, Range<usize>)| {
            let place = (&self.grid.cells[number], elements.clone());
            let wide = WideCell::new(&self.grid, place, &self.diffusion[group][number], self.extrapolation)?;
            Some((wide, elements))
        };
        let wide_cells: Vec<(WideCell, Range<usize>)> =
            self.grid.numbered_surface_cells().filter_map(wide_cell).collect();
        if wide_cells.is_empty() {
            return Vec::new();
        }
        let light = vec![f32x4::ONE; self.grid.surface.len()];
        let nodes = self.solve_group(group, &light, SolveOptions::default());
        let grid_flux = self.flux_of_grid(&nodes, &light);
        let mut missing = vec![f32x4::ZERO; light.len()];
        for (wide, elements) in wide_cells {
            for index in elements {
                missing[index] = wide.missing_flux(grid_flux[index], self.grid.thickness_m[index]);
            }
        }
        missing
    }

    /// The points of the surface where light enters.
    #[must_use]
    pub fn surface(&self) -> &[SurfaceElement] {
        &self.grid.surface
    }

    /// Size of the finest cells, in m. Without a rule for sizes, all cells at the surface have this size.
    #[must_use]
    pub fn step_m(&self) -> f64 {
        self.grid.lattice.step.max_element()
    }

    /// Mean size of the cells at the surface, weighted by surface area, in m.
    #[must_use]
    pub fn surface_step_m(&self) -> f64 {
        let (mut area_m2, mut sum) = (f64::MIN_POSITIVE, 0.0);
        for (cell, elements) in self.grid.surface_cells() {
            let of_cell: f64 = self.grid.surface[elements].iter().map(|element| f64::from(element.area_m2)).sum();
            area_m2 += of_cell;
            sum += of_cell * f64::from(1u32 << cell.level);
        }
        self.step_m() * sum / area_m2
    }

    /// Size of the cell at a place of the surface, and the least thickness of the snow below the surface in this cell
    /// and the cells around it, in m.
    #[must_use]
    pub fn size_and_thickness_m(&self, place: &SurfacePlace) -> [f32; 2] {
        let cell = &self.grid.cells[place.cell as usize];
        let thickness_m = self.surface_nodes.least_thickness_m(&self.grid, cell);
        [self.grid.cell_size(cell).as_vec3().max_element(), thickness_m]
    }

    /// Number of unknowns at each wavelength.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.grid.free_count
    }

    /// Number of cells.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.grid.cells.len()
    }

    /// Number of solutions for four wavelengths so far, and total number of their conjugate-gradient iterations.
    #[must_use]
    pub fn solves_and_iterations(&self) -> [u64; 2] {
        [&self.solves, &self.iterations].map(|count| count.load(Ordering::Relaxed))
    }

    /// Approximate memory of the grid and the systems, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.grid.bytes() + self.systems.iter().map(System::bytes).sum::<usize>()
    }

    /// Solves for light that enters at the surface. `light` is Σ K F plus the diffuse irradiance at each surface
    /// element, for each group of wavelengths. F is the irradiance from one direction, and K the escape function of
    /// its cosine.
    ///
    /// # Panics
    ///
    /// If there are not as many groups as the body has, or not as many values as surface elements.
    #[must_use]
    pub fn solve(&self, light: &[Vec<f32x4>], options: SolveOptions) -> Fluence {
        assert_eq!(light.len(), self.systems.len());
        let groups = light.iter().enumerate();
        Fluence(groups.map(|(group, light)| self.solve_group(group, light, options)).collect())
    }

    /// Share of the diffuse irradiance that leaves each surface element again, 1 + J/H, for each group of wavelengths.
    /// The snow below the element is approximated by a slab with the thickness of the body there, so no solution is
    /// needed. The share is low where the snow is so thin that the cells do not resolve it: there the grid reflects
    /// less than a slab.
    #[must_use]
    pub fn slab_reflectance(&self) -> Vec<Vec<f32x4>> {
        let of_group = |diffusion: &Vec<Diffusion>| {
            let mut values = vec![f32x4::ZERO; self.grid.surface.len()];
            for (number, elements) in self.grid.numbered_surface_cells() {
                let size_m = self.grid.cell_size(&self.grid.cells[number]).as_vec3();
                for index in elements {
                    let thickness_m = self.grid.thickness_m[index];
                    let cells = thickness_m / self.grid.surface[index].normal.abs().dot(size_m);
                    let absorptance = slab_absorptance(&diffusion[number], thickness_m, self.extrapolation);
                    values[index] = (f32x4::ONE - absorptance) * part(RESOLVED_CELLS, f32x4::splat(cells));
                }
            }
            values
        };
        self.diffusion.par_iter().map(of_group).collect()
    }

    /// The patches of the surface, numbered from `first` on. A patch is the set of surface elements in a cell that face
    /// about the same way.
    #[must_use]
    pub fn patches(&self, first: u32) -> SurfacePatches {
        let mut patches = SurfacePatches {
            of_element: vec![0; self.grid.surface.len()],
            of_cell: vec![[NONE; SIDES]; self.grid.cut_cells.len()],
            end: first,
        };
        for (cell, elements) in self.grid.surface_cells() {
            let of_side = &mut patches.of_cell[cell.cut as usize];
            for index in elements {
                let [(side, _), ..] = sorted_sides(self.grid.surface[index].normal);
                if of_side[side] == NONE {
                    of_side[side] = patches.end;
                    patches.end += 1;
                }
                patches.of_element[index] = of_side[side];
            }
        }
        patches
    }

    /// The number of the patch that holds a place; none if no patch of its cell faces this way.
    #[must_use]
    pub fn patch_at(&self, patches: &SurfacePatches, place: &SurfacePlace) -> Option<u32> {
        let of_side = patches.of_cell.get(self.grid.cells[place.cell as usize].cut as usize)?;
        sorted_sides(place.normal).into_iter().map(|(side, _)| of_side[side]).find(|patch| *patch != NONE)
    }

    /// The fluence rates of a group at all nodes.
    fn solve_group(&self, group: usize, light: &[f32x4], options: SolveOptions) -> Vec<f32x4> {
        assert_eq!(light.len(), self.grid.surface.len());
        let diffusion = &self.diffusion[group];
        let mut right = right_hand_side(&self.grid, light, diffusion, self.extrapolation);
        for source in options.sources {
            add_source(&self.grid, source, group, diffusion, &mut right);
        }
        let start = options.start.map(|start| self.at_free_nodes(&start.0[group]));
        let residuals = [options.tolerance, options.residual_left];
        let (solution, iterations) = solve(&self.systems[group], &right, start, residuals);
        self.solves.fetch_add(1, Ordering::Relaxed);
        self.iterations.fetch_add(iterations, Ordering::Relaxed);
        let node = |node: u32| {
            let terms = self.grid.terms(node).iter();
            terms.fold(f32x4::ZERO, |sum, term| sum + solution[term.free as usize] * term.weight)
        };
        let count = u32::try_from(self.grid.node_count()).unwrap_or(u32::MAX);
        (0..count).into_par_iter().map(node).collect()
    }

    /// The values of the free nodes, taken from the values of all nodes.
    fn at_free_nodes(&self, nodes: &[f32x4]) -> Vec<f32x4> {
        let mut free = vec![f32x4::ZERO; self.grid.free_count];
        for (node, value) in (0..).zip(nodes) {
            if let [term] = self.grid.terms(node) {
                free[term.free as usize] = *value;
            }
        }
        free
    }

    /// Net outward flux at each surface element for the light of the solution, for each group of wavelengths. The flux
    /// is linear in the light and in the solution.
    #[must_use]
    pub fn element_flux(&self, fluence: &Fluence, light: &[Vec<f32x4>]) -> Vec<Vec<f32x4>> {
        let of_group = |((nodes, light), missing): ((&Vec<f32x4>, &Vec<f32x4>), &Vec<f32x4>)| {
            let mut flux = self.flux_of_grid(nodes, light);
            for ((flux, light), missing) in flux.iter_mut().zip(light).zip(missing) {
                *flux += *missing * *light;
            }
            flux
        };
        fluence.0.par_iter().zip(light).zip(&self.missing_flux).map(of_group).collect()
    }

    /// J = (φ − 4 Σ K F) / (3q) at each surface element.
    fn flux_of_grid(&self, nodes: &[f32x4], light: &[f32x4]) -> Vec<f32x4> {
        #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
        let factor = (1.0 / (3.0 * self.extrapolation)) as f32;
        let mut flux = vec![f32x4::ZERO; light.len()];
        for (cell, elements) in self.grid.surface_cells() {
            for index in elements {
                let at = self.grid.within(cell, self.grid.surface[index].point.as_dvec3());
                flux[index] = (interpolated(nodes, cell, at) - light[index] * 4.0) * factor;
            }
        }
        flux
    }

    /// Smooths a quantity of the surface elements for [`surface_value`](Self::surface_value). `elements` holds a value
    /// at each element for each group of wavelengths.
    #[must_use]
    pub fn smooth(&self, elements: &[Vec<f32x4>]) -> SurfaceValues {
        SurfaceValues(elements.par_iter().map(|values| self.surface_nodes.smooth(&self.grid, values)).collect())
    }

    /// Smooths the net flux outwards and the exitance of the surface elements. The exitance does not fall below 0
    /// beside bright edges.
    #[must_use]
    pub fn smooth_light(&self, flux: &[Vec<f32x4>], exitance: &[Vec<f32x4>]) -> [SurfaceValues; 2] {
        let of_group = |(flux, exitance): (&Vec<f32x4>, &Vec<f32x4>)| {
            self.surface_nodes.smooth_light(&self.grid, flux, exitance).into()
        };
        let (flux, exitance) = flux.par_iter().zip(exitance).map(of_group).unzip();
        [SurfaceValues(flux), SurfaceValues(exitance)]
    }

    /// Removes noise from a randomly sampled quantity of the surface elements, for each group of wavelengths. Each
    /// element gets the average over just as much of the surrounding surface as brings the standard error below
    /// `tolerance` times the mean. The average extends over at most about two cells in each direction, and not across
    /// an edge of light and shadow.
    pub fn denoise(&self, elements: &mut [Vec<f32x4>], tolerance: f32) {
        elements.par_iter_mut().for_each(|values| self.surface_nodes.denoise(&self.grid, values, tolerance));
    }

    /// The value of each group of wavelengths at a point of the surface, in m, with an outward unit normal; none if
    /// there is no cell within a step of the point.
    #[inline]
    pub fn surface_value<'f>(
        &'f self,
        values: &'f SurfaceValues,
        point: DVec3,
        normal: DVec3,
    ) -> Option<impl Iterator<Item = f32x4> + use<'f>> {
        let place = self.grid.find_at_surface(point, normal)?;
        Some(self.value_at(values, &place).into_iter().take(values.0.len()))
    }

    /// The place of a point of the surface, in m, with an outward unit normal; none if there is no cell within a step
    /// of the point.
    #[must_use]
    pub fn surface_place(&self, point: DVec3, normal: DVec3) -> Option<SurfacePlace> {
        self.grid.find_at_surface(point, normal)
    }

    /// The values that [`surface_value`](Self::surface_value) gives, at a place.
    #[inline]
    #[must_use]
    pub fn value_at(&self, values: &SurfaceValues, place: &SurfacePlace) -> Groups {
        let cell = &self.grid.cells[place.cell as usize];
        self.surface_nodes.flux(&self.grid, &values.0, (cell, place.at), place.normal)
    }

    /// The fluence rate of each group of wavelengths at a point of the body, in m; none if there is no cell.
    #[inline]
    pub fn fluence<'f>(&self, fluence: &'f Fluence, point: DVec3) -> Option<impl Iterator<Item = f32x4> + use<'f>> {
        let (cell, at) = self.grid.find_inside(point)?;
        let (shape, corners) = (shape(at), cell.corners);
        Some(fluence.0.iter().map(move |nodes| weighted(nodes, &corners, &shape)))
    }

    /// The gradient of the fluence rate of each group of wavelengths at a point of the body, per m; none if there is no
    /// cell.
    #[inline]
    pub fn gradient<'f>(
        &self,
        fluence: &'f Fluence,
        point: DVec3,
    ) -> Option<impl Iterator<Item = [f32x4; 3]> + use<'f>> {
        let (cell, at) = self.grid.find_inside(point)?;
        let slopes = gradients(at.map(f64::from).into(), self.grid.cell_size(cell)).map(DVec3::as_vec3);
        let corners = cell.corners;
        Some(
            fluence.0.iter().map(move |nodes| {
                std::array::from_fn(|axis| weighted(nodes, &corners, &slopes.map(|slope| slope[axis])))
            }),
        )
    }
}

/// The value at a point of a cell.
#[inline]
fn interpolated(nodes: &[f32x4], cell: &Cell, at: [f32; 3]) -> f32x4 {
    weighted(nodes, &cell.corners, &shape(at))
}

/// The weighted sum of the values at the corners of a cell.
#[inline]
fn weighted(nodes: &[f32x4], corners: &[u32; CORNERS], weights: &[f32; CORNERS]) -> f32x4 {
    let terms = corners.iter().zip(weights);
    terms.fold(f32x4::ZERO, |sum, (node, weight)| sum + nodes[*node as usize] * *weight)
}
