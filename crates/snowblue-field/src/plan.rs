//! The size of the cells of a body's grid.

use glam::DVec3;

use crate::body::Body;
use crate::lattice::Lattice;
use crate::scan::{coverage, surface, volume_m3};
use crate::system::System;

/// Nodes that a body gets if its snow allows it: enough for details of a fortieth of its size.
const USUAL_NODES: f64 = 60_000.0;
/// Finest cells, in transport mean free paths. Diffusion resolves no more.
const FINEST_LENGTHS: f64 = 1.0;
/// Coarsest cells of a body that is not large, in transport mean free paths.
const COARSE_LENGTHS: f64 = 10.0;
/// Coarsest cells of any body, in transport mean free paths. Beyond, light at the surface is guesswork.
const COARSEST_LENGTHS: f64 = 50.0;
/// Lines along the longest side of a body that estimate its volume and area.
const SURVEY_CELLS: f64 = 32.0;

/// Why a body cannot have a grid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// No line crosses it.
    #[error("has no volume that lines cross")]
    NoVolume,
    /// Its cells would be too coarse for its snow.
    #[error(
        "needs cells of {needed_mm:.0} mm to fit into {memory_mib} MiB, but its snow needs cells of at most \
         {allowed_mm:.1} mm, {COARSEST_LENGTHS:.0} times the transport mean free path"
    )]
    TooLarge {
        /// Size of the cells that fit into the memory, in mm.
        needed_mm: f64,
        /// Greatest size that the snow allows, in mm.
        allowed_mm: f64,
        /// Bound of the memory, in MiB.
        memory_mib: u64,
    },
    /// The cells that were asked for are too coarse for its snow.
    #[error(
        "has cells of {step_mm} mm, but its snow needs cells of at most {allowed_mm:.1} mm, {COARSEST_LENGTHS:.0} \
         times the transport mean free path"
    )]
    StepTooCoarse {
        /// Size of the cells, in mm.
        step_mm: f64,
        /// Greatest size that the snow allows, in mm.
        allowed_mm: f64,
    },
    /// The cells that were asked for do not fit into the memory.
    #[error("has cells of {step_mm} mm, but only cells of at least {needed_mm:.2} mm fit into {memory_mib} MiB")]
    StepTooFine {
        /// Size of the cells, in mm.
        step_mm: f64,
        /// Size of the cells that fit into the memory, in mm.
        needed_mm: f64,
        /// Bound of the memory, in MiB.
        memory_mib: u64,
    },
}

/// Size and extent of a body.
#[derive(Debug, Clone, Copy)]
pub struct Survey {
    volume_m3: f64,
    area_m2: f64,
    bounds_m: DVec3,
}

impl Survey {
    /// Measures a body with some lines.
    ///
    /// # Errors
    ///
    /// If no line crosses the body.
    pub fn new(body: &dyn Body) -> Result<Self, FieldError> {
        let [low, high] = body.bounds();
        let bounds_m = high - low;
        let lattice = Lattice::around(body, bounds_m.max_element() / SURVEY_CELLS, DVec3::ZERO);
        let volume_m3 = volume_m3(&coverage(body, &lattice, &lattice.columns(2)), &lattice);
        let samples = surface(body, &lattice, &[0, 1, 2].map(|axis| lattice.columns(axis)));
        let area_m2 = samples.iter().map(|sample| f64::from(sample.element.area_m2)).sum();
        if volume_m3 > 0.0 { Ok(Self { volume_m3, area_m2, bounds_m }) } else { Err(FieldError::NoVolume) }
    }

    /// Mean thickness in m: four times the volume over the surface, the mean length of a random chord.
    #[must_use]
    pub fn mean_thickness_m(&self) -> f64 {
        4.0 * self.volume_m3 / self.area_m2
    }

    /// Size of the cells at the surface, in m, for snow with a transport mean free path in m, at some number of groups
    /// of four wavelengths, within a bound of memory in MiB.
    ///
    /// # Errors
    ///
    /// If the cells that fit into the memory are too coarse.
    pub fn choose_step_m(&self, transport_length_m: f64, groups: usize, memory_mib: u64) -> Result<f64, FieldError> {
        let usual = bisect(|step_m| self.nodes(step_m) <= USUAL_NODES);
        let wanted = usual.clamp(FINEST_LENGTHS * transport_length_m, COARSE_LENGTHS * transport_length_m);
        let smallest = self.smallest_step_m(groups, memory_mib);
        let allowed = COARSEST_LENGTHS * transport_length_m;
        if smallest > allowed {
            return Err(FieldError::TooLarge { needed_mm: 1e3 * smallest, allowed_mm: 1e3 * allowed, memory_mib });
        }
        Ok(wanted.max(smallest))
    }

    /// The size of the cells at the surface that was asked for, in m, if the snow allows it and the grid fits into the
    /// memory; otherwise as [`choose_step_m`](Self::choose_step_m).
    ///
    /// # Errors
    ///
    /// If the cells are too coarse for the snow or too fine for the memory.
    pub fn check_step_m(
        &self,
        step_m: f64,
        transport_length_m: f64,
        groups: usize,
        memory_mib: u64,
    ) -> Result<f64, FieldError> {
        let step_mm = 1e3 * step_m;
        let allowed = COARSEST_LENGTHS * transport_length_m;
        if step_m > allowed {
            return Err(FieldError::StepTooCoarse { step_mm, allowed_mm: 1e3 * allowed });
        }
        let smallest = self.smallest_step_m(groups, memory_mib);
        if step_m < smallest {
            return Err(FieldError::StepTooFine { step_mm, needed_mm: 1e3 * smallest, memory_mib });
        }
        Ok(step_m)
    }

    /// Size in m of the smallest cells that fit into a memory in MiB.
    fn smallest_step_m(&self, groups: usize, memory_mib: u64) -> f64 {
        let bytes = memory_mib as f64 * f64::from(1 << 20);
        bisect(|step_m| self.bytes(step_m, groups) <= bytes)
    }

    /// About how many nodes a grid has: those of layers of cells that double in size away from the surface.
    fn nodes(&self, step_m: f64) -> f64 {
        let (mut rest_m3, mut size_m, mut nodes) = (self.volume_m3, step_m, 0.5 * self.area_m2 / (step_m * step_m));
        while rest_m3 > 0.0 {
            let layer_m3 = rest_m3.min(4.0 * size_m * self.area_m2);
            nodes += layer_m3 / (size_m * size_m * size_m);
            rest_m3 -= layer_m3;
            size_m *= 2.0;
        }
        nodes
    }

    fn bytes(&self, step_m: f64, groups: usize) -> f64 {
        /// The cell of each finest cell, its state while the grid is built, and its node.
        const BYTES_PER_FINEST_CELL: f64 = 16.0;
        /// Parts inside, surface elements and integrals of a cell at the surface.
        const BYTES_PER_SURFACE_CELL: f64 = 1200.0;
        let finest = self.bounds_m.x * self.bounds_m.y * self.bounds_m.z / step_m.powi(3);
        let at_surface = 1.5 * self.area_m2 / (step_m * step_m);
        BYTES_PER_FINEST_CELL * finest
            + BYTES_PER_SURFACE_CELL * at_surface
            + (groups * System::BYTES_PER_NODE) as f64 * self.nodes(step_m)
    }
}

/// The least size in m for which a condition holds that holds for all greater ones.
fn bisect(holds: impl Fn(f64) -> bool) -> f64 {
    let (mut least, mut greatest) = (1e-6_f64, 1e6_f64);
    for _ in 0..60 {
        let middle = (least * greatest).sqrt();
        if holds(middle) { greatest = middle } else { least = middle }
    }
    greatest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::GridOptions;
    use crate::grid::Grid;
    use crate::shapes::{Ball, BoxBody};

    #[test]
    fn the_estimate_of_nodes_is_near_their_number() {
        let ball = Ball { centre: DVec3::ZERO, radius: 0.3 };
        let block = BoxBody::aligned(DVec3::ZERO, DVec3::new(0.6, 0.15, 0.6));
        let bodies: [&dyn Body; 2] = [&ball, &block];
        for body in bodies {
            for step_m in [0.01, 0.02] {
                let estimate = Survey::new(body).unwrap().nodes(step_m);
                let count = Grid::new(body, GridOptions { step_m, shift: DVec3::ZERO, sizes: None }).free_count as f64;
                assert!(estimate > 0.6 * count && estimate < 1.7 * count, "{estimate} {count}");
            }
        }
    }

    #[test]
    fn a_kilometre_of_fine_snow_does_not_fit() {
        let body = BoxBody::aligned(DVec3::ZERO, DVec3::splat(1000.0));
        let error = Survey::new(&body).unwrap().choose_step_m(1e-4, 2, 1024).unwrap_err();
        assert!(matches!(error, FieldError::TooLarge { memory_mib: 1024, .. }), "{error}");
        let small = BoxBody::aligned(DVec3::ZERO, DVec3::new(0.6, 0.15, 0.6));
        let step_m = Survey::new(&small).unwrap().choose_step_m(0.002, 2, 1024).unwrap();
        assert!(step_m > 0.005 && step_m < 0.02, "{step_m}");
    }

    #[test]
    fn a_given_step_must_suit_the_snow_and_the_memory() {
        let survey = Survey::new(&BoxBody::aligned(DVec3::ZERO, DVec3::new(0.6, 0.15, 0.6))).unwrap();
        assert!((survey.check_step_m(0.007, 0.002, 2, 1024).unwrap() - 0.007).abs() < 1e-12);
        let coarse = survey.check_step_m(0.3, 0.002, 2, 1024).unwrap_err();
        assert!(
            coarse.to_string().contains("cells of 300 mm, but its snow needs cells of at most 100.0 mm"),
            "{coarse}"
        );
        let fine = survey.check_step_m(0.0005, 0.002, 2, 64).unwrap_err();
        let FieldError::StepTooFine { needed_mm, memory_mib: 64, .. } = fine else { panic!("{fine}") };
        assert!(needed_mm > 1.0 && survey.check_step_m(1.001e-3 * needed_mm, 0.002, 2, 64).is_ok(), "{fine}");
    }
}
