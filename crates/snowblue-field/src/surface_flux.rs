//! The net flux through the surface, smoothed over the size of a cell.
//!
//! The flux of an element follows from the fluence rate φ at the surface: J = (φ − 4 Σ K F) / (3q). On curved surfaces
//! φ is uncertain from cell to cell, because φ is small relative to its change across a cell. The mean flux over some
//! cells is accurate, because the solution conserves energy against every shape function. The flux is therefore
//! averaged at the nodes of the cells that the surface cuts, with the shape functions as weights, and interpolated
//! with the shape functions.
//!
//! Surfaces of different orientation are averaged separately, with six weights n_k² for the sides of the axes, which
//! add up to 1. The flux of a lit face therefore does not leak around the edge to a dark face. The average is
//! sharpened once by adding the average of its residual (Tukey's twicing), so that it preserves functions that are
//! quadratic along the surface.

use glam::Vec3;
use rayon::prelude::*;
use wide::{f32x4, f64x4};

use crate::element::shape;
use crate::grid::{Cell, Grid};
use crate::octree::NONE;
use crate::spectral_nodes::Groups;
use crate::vectors::{narrow, ratio, wide};

/// Number of orientations: towards either end of each axis.
pub(crate) const SIDES: usize = 6;

/// Greatest number of steps of averaging over neighbouring cells.
const MAX_STEPS: usize = 6;
/// Least exitance after sharpening, as a fraction of the averaged exitance before sharpening.
const MIN_SHARE: f32 = 0.5;
/// Number of steps that average the noise itself.
const STEPS_OF_ERROR: usize = 2;

/// Positions of the surface elements, as weights of free nodes and orientations. If a node hangs on a larger cell, its
/// share goes to the nodes whose mean it is, so that there is no jump where the cell size changes.
#[derive(Debug)]
pub(crate) struct SurfaceNodes {
    /// The number of each free node among the nodes near the surface, or [`NONE`].
    number: Vec<u32>,
    /// Area of each node and orientation, in m².
    area_m2: Vec<[f32; SIDES]>,
    /// Area of each node and orientation, with larger cells counted as if they had the finest size: the weight of a
    /// node's mean in interpolation. With weights by area, the nodes of large cells would outweigh the nodes of small
    /// cells in the cells between them.
    weight: Vec<[f32; SIDES]>,
    /// Least thickness of the snow below the surface in the cells around each node, in m.
    thickness_m: Vec<f32>,
}

/// Numbers of the nodes around a node, including the node itself, with the number of cells that they share. There are
/// at most 27 nodes where cells have one size.
type Neighbours = Vec<(u32, f32)>;

/// The net flux of a group of wavelengths, times its weight, at each free node near the surface.
pub(crate) type NodeFlux = Vec<[f32x4; SIDES]>;

impl SurfaceNodes {
    pub(crate) fn new(grid: &Grid) -> Self {
        let mut nodes = Self {
            number: vec![NONE; grid.free_count],
            area_m2: Vec::new(),
            weight: Vec::new(),
            thickness_m: Vec::new(),
        };
        for cell in grid.cells.iter().filter(|cell| cell.cut != NONE) {
            for term in cell.corners.iter().flat_map(|corner| grid.terms(*corner)) {
                let number = &mut nodes.number[term.free as usize];
                if *number == NONE {
                    *number = u32::try_from(nodes.area_m2.len()).unwrap_or(NONE);
                    nodes.area_m2.push([0.0; SIDES]);
                }
            }
        }
        let (mut area_m2, mut weight) = (std::mem::take(&mut nodes.area_m2), Vec::new());
        weight.resize(area_m2.len(), [0.0; SIDES]);
        let mut thickness_m = vec![f32::INFINITY; area_m2.len()];
        let mut element_weights = vec![1.0; grid.surface.len()];
        for (cell, elements) in grid.surface_cells() {
            element_weights[elements].fill(0.25_f32.powi(cell.level.into()));
        }
        nodes.visit_elements(grid, &mut |index, place, side, area| {
            area_m2[place][side] += area;
            weight[place][side] += area * element_weights[index];
            thickness_m[place] = thickness_m[place].min(grid.thickness_m[index]);
        });
        Self { area_m2, weight, thickness_m, ..nodes }
    }

    /// The least thickness of the snow below the surface in a cell and the cells around it, in m. Lines miss the
    /// surface in cells into which the body reaches by little.
    pub(crate) fn least_thickness_m(&self, grid: &Grid, cell: &Cell) -> f32 {
        let terms = cell.corners.iter().flat_map(|corner| grid.terms(*corner));
        let thicknesses_m = terms.filter_map(|term| self.thickness_m.get(self.number[term.free as usize] as usize));
        thicknesses_m.copied().fold(f32::INFINITY, f32::min)
    }

    /// The smoothed flux, from the fluxes of all surface elements.
    pub(crate) fn smooth(&self, grid: &Grid, flux: &[f32x4]) -> NodeFlux {
        let [smooth, _] = self.smooth_and_averaged(grid, flux);
        smooth
    }

    /// The smoothed flux and exitance. Beside a bright edge the sharpened average is too low, even below 0. The
    /// exitance is therefore kept at or above a share of its average, and at or above 0, and the flux grows by the
    /// same amount. The amount added is subtracted from the excess of sharpening on the same side, so that the total
    /// light of the surface is conserved.
    pub(crate) fn smooth_light(&self, grid: &Grid, flux: &[f32x4], exitance: &[f32x4]) -> [NodeFlux; 2] {
        let mut flux = self.smooth(grid, flux);
        let [mut exitance, averaged] = self.smooth_and_averaged(grid, exitance);
        let least = |averaged: f32x4| (averaged * MIN_SHARE).max(f32x4::ZERO);
        for side in 0..SIDES {
            let (mut added, mut sharpened) = (f64x4::ZERO, f64x4::ZERO);
            for (node, averaged) in averaged.iter().enumerate().filter(|(node, _)| self.weight[*node][side] > 0.0) {
                let area = f64x4::splat((self.area_m2[node][side] / self.weight[node][side]).into());
                added += wide(least(averaged[side]).max(exitance[node][side]) - exitance[node][side]) * area;
                sharpened += wide((exitance[node][side] - averaged[side]).max(f32x4::ZERO)) * area;
            }
            let part = narrow(ratio(added, sharpened).min(f64x4::ONE));
            for ((exitance, flux), averaged) in exitance.iter_mut().zip(&mut flux).zip(&averaged) {
                let excess = (exitance[side] - averaged[side]).max(f32x4::ZERO);
                let change = least(averaged[side]).max(exitance[side]) - exitance[side] - excess * part;
                exitance[side] += change;
                flux[side] += change;
            }
        }
        [flux, exitance]
    }

    /// The smoothed values of the surface elements, and their averages before sharpening.
    fn smooth_and_averaged(&self, grid: &Grid, values: &[f32x4]) -> [NodeFlux; 2] {
        let averaged = self.averaged(grid, values);
        let mut missed = self.at_elements(grid, &averaged);
        missed.iter_mut().zip(values).for_each(|(smoothed, value)| *smoothed = *value - *smoothed);
        let mut smooth = self.averaged(grid, &missed);
        for (smooth, averaged) in smooth.iter_mut().flatten().zip(averaged.iter().flatten()) {
            *smooth += *averaged;
        }
        [smooth, averaged]
    }

    /// The flux at each surface element.
    pub(crate) fn at_elements(&self, grid: &Grid, nodes: &NodeFlux) -> Vec<f32x4> {
        let mut values = vec![f32x4::ZERO; grid.surface.len()];
        for (cell, elements) in grid.surface_cells() {
            for index in elements {
                let element = &grid.surface[index];
                let at = grid.within(cell, element.point.as_dvec3());
                [values[index], ..] = self.flux(grid, std::slice::from_ref(nodes), (cell, at), element.normal);
            }
        }
        values
    }

    /// The flux of some groups at a point of a cell on a surface with a normal.
    #[inline]
    pub(crate) fn flux(&self, grid: &Grid, groups: &[NodeFlux], (cell, at): (&Cell, [f32; 3]), normal: Vec3) -> Groups {
        let weights = side_weights(normal);
        let (mut sums, mut sum_of_weights) = (Groups::default(), 0.0);
        for (corner, shape) in cell.corners.iter().zip(shape(at)) {
            for term in grid.terms(*corner) {
                let number = self.number[term.free as usize] as usize;
                let Some(node_weights) = self.weight.get(number) else { continue };
                let shares = weights.map(|(side, weight)| (side, shape * weight * term.weight));
                for (side, share) in shares {
                    sum_of_weights += node_weights[side] * share;
                }
                for (sum, flux) in sums.iter_mut().zip(groups) {
                    for (side, share) in shares {
                        *sum += flux[number][side] * share;
                    }
                }
            }
        }
        sums.map(|sum| quotient(sum, sum_of_weights))
    }

    /// Removes noise from a randomly sampled quantity of the surface elements: averages the quantity over as many
    /// cells around each element as bring its standard error below `tolerance` times its mean.
    ///
    /// The error at a node follows from the scatter of the elements around it. A step averages over the corners of
    /// each cell, then over the cells around each node. It adds ½ cell² to the variance of the position, which is 1/6
    /// cell² for the shape functions. After k steps the mean covers 1 + 3k times the area, and the error is smaller by
    /// the square root of this factor.
    pub(crate) fn denoise(&self, grid: &Grid, values: &mut [f32x4], tolerance: f32) {
        let areas = &self.area_m2;
        let sums = self.averaged(grid, values);
        let means: NodeFlux = sums.iter().zip(&self.weight).map(|(sums, weights)| quotients(sums, weights)).collect();
        // Scatter of the elements around the means, for the sum over all wavelengths.
        let mut scatter = vec![[f32x4::ZERO; SIDES]; areas.len()];
        self.visit_elements(grid, &mut |index, place, side, weight| {
            let difference = (values[index] - means[place][side]).reduce_add() * weight;
            scatter[place][side] += f32x4::new([difference * difference, 0.0, 0.0, 0.0]);
        });
        for ((scatter, means), areas) in scatter.iter_mut().zip(&means).zip(areas) {
            for side in 0..SIDES {
                let area = areas[side];
                let variance = if area > 0.0 { scatter[side].as_array()[0] / (area * area) } else { 0.0 };
                scatter[side] = f32x4::new([variance, means[side].reduce_add(), 0.0, 0.0]);
            }
        }
        let neighbours = self.neighbours(grid);
        // The scatter at a node that lacks a bright sample does not show the lack. The scatter of its neighbours does.
        for _ in 0..STEPS_OF_ERROR {
            scatter = self.spread(&neighbours, &scatter, None);
        }
        let guide: Vec<[f32; SIDES]> = scatter.iter().map(|sides| sides.map(|error| error.as_array()[1])).collect();
        let steps = |scatter: &[f32x4; SIDES]| {
            scatter.map(|error| {
                let [variance, mean, ..] = error.to_array();
                let allowed = (tolerance * mean).powi(2);
                let steps =
                    if variance > allowed { (variance / allowed.max(f32::MIN_POSITIVE) - 1.0) / 3.0 } else { 0.0 };
                steps.min(MAX_STEPS as f32)
            })
        };
        let steps: Vec<[f32; SIDES]> = scatter.iter().map(steps).collect();
        if steps.iter().flatten().all(|steps| *steps <= 0.0) {
            return;
        }
        let mut smooth = means.clone();
        let mut result = means;
        for step in 1..=MAX_STEPS {
            smooth = self.spread(&neighbours, &smooth, Some(&guide));
            for ((result, smooth), steps) in result.iter_mut().zip(&smooth).zip(&steps) {
                for side in 0..SIDES {
                    // The last step may count in part.
                    let part = (steps[side] - (step - 1) as f32).clamp(0.0, 1.0);
                    if part > 0.0 {
                        result[side] = result[side] * (1.0 - part) + smooth[side] * part;
                    }
                }
            }
        }
        for (result, weights) in result.iter_mut().zip(&self.weight) {
            (0..SIDES).for_each(|side| result[side] *= weights[side]);
        }
        values.copy_from_slice(&self.at_elements(grid, &result));
    }

    /// For each node, the nodes of the surrounding cells at the surface, with the number of cells that they share.
    fn neighbours(&self, grid: &Grid) -> Vec<Neighbours> {
        let mut neighbours = vec![Neighbours::new(); self.area_m2.len()];
        for cell in grid.cells.iter().filter(|cell| cell.cut != NONE) {
            let terms = cell.corners.iter().flat_map(|corner| grid.terms(*corner));
            let nodes: Vec<(u32, f32)> = terms.map(|term| (self.number[term.free as usize], term.weight)).collect();
            for (node, neighbour) in nodes.iter().flat_map(|node| nodes.iter().map(move |neighbour| (node, neighbour)))
            {
                let around = &mut neighbours[node.0 as usize];
                let cells = node.1 * neighbour.1;
                match around.iter_mut().find(|(number, _)| *number == neighbour.0) {
                    Some((_, sum)) => *sum += cells,
                    None => around.push((neighbour.0, cells)),
                }
            }
        }
        neighbours
    }

    /// Averages means at the nodes over the corners of each cell, then over the cells around each node, weighted by
    /// area and separately for each orientation. With a guide, the weight of a node decreases with the difference of
    /// their guide values, so that light does not leak from a bright surface to a dark surface beside it.
    fn spread(&self, neighbours: &[Neighbours], means: &NodeFlux, guide: Option<&[[f32; SIDES]]>) -> NodeFlux {
        let mean = |node: usize, side: usize| {
            // A node without area has no weight.
            if self.area_m2[node][side] <= 0.0 {
                return f32x4::ZERO;
            }
            let (mut sum, mut area_m2) = (f32x4::ZERO, 0.0);
            for (neighbour, cells) in &neighbours[node] {
                let neighbour = *neighbour as usize;
                let likeness = guide.map_or(1.0, |guide| likeness(guide[node][side], guide[neighbour][side]));
                let weight = self.area_m2[neighbour][side] * likeness * cells;
                sum += means[neighbour][side] * weight;
                area_m2 += weight;
            }
            quotient(sum, area_m2)
        };
        (0..means.len()).into_par_iter().map(|node| std::array::from_fn(|side| mean(node, side))).collect()
    }

    /// The means at the nodes, times their weights.
    fn averaged(&self, grid: &Grid, flux: &[f32x4]) -> NodeFlux {
        let mut sums = vec![[f32x4::ZERO; SIDES]; self.area_m2.len()];
        self.visit_elements(grid, &mut |index, place, side, area| sums[place][side] += flux[index] * area);
        for ((sums, areas), weights) in sums.iter_mut().zip(&self.area_m2).zip(&self.weight) {
            for side in (0..SIDES).filter(|side| areas[*side] > 0.0) {
                sums[side] *= weights[side] / areas[side];
            }
        }
        sums
    }

    /// Visits the weights of each surface element with the index of the element, the number of the node, the
    /// orientation and the area.
    fn visit_elements(&self, grid: &Grid, visit: &mut dyn FnMut(usize, usize, usize, f32)) {
        for (cell, elements) in grid.surface_cells() {
            for index in elements {
                let element = &grid.surface[index];
                let shape = shape(grid.within(cell, element.point.as_dvec3()));
                for (corner, shape) in cell.corners.iter().zip(shape) {
                    for term in grid.terms(*corner) {
                        let number = self.number[term.free as usize] as usize;
                        for (side, weight) in side_weights(element.normal) {
                            visit(index, number, side, element.area_m2 * shape * weight * term.weight);
                        }
                    }
                }
            }
        }
    }
}

/// Sums divided by areas or weights.
fn quotients(sums: &[f32x4; SIDES], areas: &[f32; SIDES]) -> [f32x4; SIDES] {
    std::array::from_fn(|side| quotient(sums[side], areas[side]))
}

/// A sum divided by an area or weight; 0 if the divisor is 0.
fn quotient(sum: f32x4, weight: f32) -> f32x4 {
    if weight > 0.0 { sum / f32x4::splat(weight) } else { f32x4::ZERO }
}

/// Similarity of two surfaces by brightness: the square of the ratio of the lower to the higher brightness.
fn likeness(one: f32, other: f32) -> f32 {
    let (least, greatest) = if one < other { (one, other) } else { (other, one) };
    if greatest > 0.0 { (least.max(0.0) / greatest).powi(2) } else { 1.0 }
}

/// The three orientations of a normal, the nearest first, with their weights.
pub(crate) fn sorted_sides(normal: Vec3) -> [(usize, f32); 3] {
    let mut sides = side_weights(normal);
    sides.sort_by(|first, second| second.1.total_cmp(&first.1));
    sides
}

/// The three orientations of a normal with their weights.
#[inline]
fn side_weights(normal: Vec3) -> [(usize, f32); 3] {
    std::array::from_fn(|axis| (2 * axis + usize::from(normal[axis] > 0.0), normal[axis] * normal[axis]))
}
