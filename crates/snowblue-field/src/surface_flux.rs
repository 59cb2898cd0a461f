//! The net flux through the surface, smoothed over the size of a cell.
//!
//! The flux of an element follows from the fluence rate at the surface, J = (φ − 4 Σ K F) / (3q). On curved surfaces φ
//! there is uncertain from cell to cell: it is small beside its change across a cell. The mean flux over some cells is
//! accurate, because the solution conserves energy against every shape function. So the flux is averaged with the shape
//! functions as weights, at the nodes of the cells that the surface cuts, and interpolated with them again.
//!
//! Surfaces of different orientation are averaged apart, by six weights n_k² on the sides of the axes, which add up to
//! 1: the flux of a lit face does not leak around the edge to a dark one. The average is sharpened once by averaging
//! what it misses (Tukey's twicing), so that it keeps functions that are quadratic along the surface.

use glam::Vec3;
use wide::f32x4;

use crate::element::shape;
use crate::grid::{Cell, Grid, NONE};

/// Orientations: towards either end of each axis.
const SIDES: usize = 6;

/// Where the surface elements are, as weights of nodes and orientations.
#[derive(Debug)]
pub(crate) struct SurfaceNodes {
    /// The number of each node among those near the surface, or [`NONE`].
    number: Vec<u32>,
    /// Area of each node and orientation, in m².
    area_m2: Vec<[f32; SIDES]>,
}

/// The net flux of a group of wavelengths, times the area, at each node near the surface.
pub(crate) type NodeFlux = Vec<[f32x4; SIDES]>;

impl SurfaceNodes {
    pub(crate) fn new(grid: &Grid) -> Self {
        let mut nodes = Self { number: vec![NONE; grid.node_count()], area_m2: Vec::new() };
        for cell in grid.cells.iter().filter(|cell| cell.cut != NONE) {
            for corner in cell.corners {
                if nodes.number[corner as usize] == NONE {
                    nodes.number[corner as usize] = u32::try_from(nodes.area_m2.len()).unwrap_or(NONE);
                    nodes.area_m2.push([0.0; SIDES]);
                }
            }
        }
        let mut area_m2 = std::mem::take(&mut nodes.area_m2);
        nodes.visit_elements(grid, &mut |_, place, side, weight| area_m2[place][side] += weight);
        nodes.area_m2 = area_m2;
        nodes
    }

    /// The smoothed flux of the fluxes of all surface elements.
    pub(crate) fn smooth(&self, grid: &Grid, flux: &[f32x4]) -> NodeFlux {
        let mut smoothed = self.averaged(grid, flux);
        let mut missed = flux.to_vec();
        for (cell, elements) in grid.surface_cells() {
            for index in elements {
                let element = &grid.surface[index];
                let at = grid.within(cell, element.point.as_dvec3());
                missed[index] -= self.flux(&smoothed, cell, at, element.normal);
            }
        }
        let correction = self.averaged(grid, &missed);
        for (flux, correction) in smoothed.iter_mut().flatten().zip(correction.into_iter().flatten()) {
            *flux += correction;
        }
        smoothed
    }

    /// The flux at a point of a cell on a surface with a normal.
    #[inline]
    pub(crate) fn flux(&self, nodes: &NodeFlux, cell: &Cell, at: [f32; 3], normal: Vec3) -> f32x4 {
        let weights = side_weights(normal);
        let (mut sum, mut area_m2) = (f32x4::ZERO, 0.0);
        for (corner, shape) in cell.corners.iter().zip(shape(at)) {
            let number = self.number[*corner as usize] as usize;
            let Some(flux) = nodes.get(number) else { continue };
            for (side, weight) in weights {
                sum += flux[side] * (shape * weight);
                area_m2 += self.area_m2[number][side] * (shape * weight);
            }
        }
        if area_m2 > 0.0 { sum / f32x4::splat(area_m2) } else { f32x4::ZERO }
    }

    fn averaged(&self, grid: &Grid, flux: &[f32x4]) -> NodeFlux {
        let mut sums = vec![[f32x4::ZERO; SIDES]; self.area_m2.len()];
        self.visit_elements(grid, &mut |index, place, side, weight| sums[place][side] += flux[index] * weight);
        sums
    }

    /// Visits the weights of each surface element: its index, the number of the node, the orientation and the area.
    fn visit_elements(&self, grid: &Grid, visit: &mut dyn FnMut(usize, usize, usize, f32)) {
        for (cell, elements) in grid.surface_cells() {
            for index in elements {
                let element = &grid.surface[index];
                let shape = shape(grid.within(cell, element.point.as_dvec3()));
                for (corner, shape) in cell.corners.iter().zip(shape) {
                    let number = self.number[*corner as usize] as usize;
                    for (side, weight) in side_weights(element.normal) {
                        visit(index, number, side, element.area_m2 * shape * weight);
                    }
                }
            }
        }
    }
}

/// The three orientations of a normal with their weights.
#[inline]
fn side_weights(normal: Vec3) -> [(usize, f32); 3] {
    std::array::from_fn(|axis| (2 * axis + usize::from(normal[axis] > 0.0), normal[axis] * normal[axis]))
}
