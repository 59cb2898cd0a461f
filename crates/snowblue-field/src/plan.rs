//! The size of the cells of a body's grid.

use glam::DVec3;

use crate::body::Body;
use crate::lattice::{Lattice, MAX_ALONG_AXIS};
use crate::octree::Octree;
use crate::scan::{coverage, surface, volume_m3};
use crate::sizes::{CellSizes, SizeLimits, demands};
use crate::system::System;

/// Number of nodes of a body if its snow allows it: enough to resolve details of a fortieth of the body's size.
const USUAL_NODES: f64 = 60_000.0;
/// Size of the finest cells, in transport mean free paths. Diffusion does not resolve smaller scales.
const FINEST_LENGTHS: f64 = 1.0;
/// Size of the coarsest cells of a body that is not large, in transport mean free paths.
const COARSE_LENGTHS: f64 = 10.0;
/// Size of the coarsest cells of any body, in transport mean free paths. For larger cells, the error of the light at
/// the surface is not known.
const COARSEST_LENGTHS: f64 = 50.0;
/// Greatest factor by which the sizes of a rule are scaled to make a grid fit into the memory.
const MAX_FACTOR: f64 = 128.0;
/// Number of cells along the longest side of a body for the estimate of its volume and area.
const SURVEY_CELLS: f64 = 32.0;

/// Least growth of the factor from one estimate to the next.
const MIN_GROWTH: f64 = 1.1;
/// Number of nodes of a grid, including nodes inside, per cell in which a rule demands a size.
const NODES_PER_DEMANDED_CELL: f64 = 2.2;
/// Memory of the parts inside, surface elements and integrals of a cell at the surface, in bytes.
const BYTES_PER_SURFACE_CELL: f64 = 1200.0;

/// Why a body cannot have a grid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// No line crosses the body.
    #[error("has no volume that lines cross")]
    NoVolume,
    /// The cells that fit into the memory are too coarse for the snow.
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
    /// Cells of one size, as for a number of nodes, do not fit into the memory.
    #[error("is too wide for a number of nodes, which gives its surface cells of one size: leave `nodes` out")]
    TooWideForNodes,
    /// The requested cells are too coarse for the snow.
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
    /// A rule for the cell sizes demands more cells than fit into the memory.
    #[error(
        "needs cells more than {MAX_FACTOR:.0} times as large as the pixels of the picture need, to fit into \
         {memory_mib} MiB: allow more memory"
    )]
    TooMuchDetail {
        /// Bound of the memory, in MiB.
        memory_mib: u64,
    },
    /// The requested cells do not fit into the memory.
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

/// Volume, surface area and extent of a body.
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

    /// Mean thickness, in m: four times the volume divided by the surface area, the mean length of a random chord.
    #[must_use]
    pub fn mean_thickness_m(&self) -> f64 {
        4.0 * self.volume_m3 / self.area_m2
    }

    /// Size of the cells at the surface, in m. `transport_length_m` is the transport mean free path of the snow,
    /// `groups` the number of groups of four wavelengths, and `memory_mib` the memory limit.
    ///
    /// # Errors
    ///
    /// If the cells that fit into the memory are too coarse.
    pub fn choose_step_m(&self, transport_length_m: f64, groups: usize, memory_mib: u64) -> Result<f64, FieldError> {
        let usual = bisect(|step_m| self.nodes(step_m) <= USUAL_NODES);
        let wanted = usual.clamp(FINEST_LENGTHS * transport_length_m, COARSE_LENGTHS * transport_length_m);
        self.at_least(wanted, transport_length_m, groups, memory_mib)
    }

    /// Size of the cells at the surface, in m, for about `nodes` nodes. The cells are at most as coarse as the snow
    /// allows; otherwise as [`choose_step_m`](Self::choose_step_m).
    ///
    /// # Errors
    ///
    /// If the cells that fit into the memory are too coarse.
    pub fn step_of_nodes_m(
        &self,
        nodes: u32,
        transport_length_m: f64,
        groups: usize,
        memory_mib: u64,
    ) -> Result<f64, FieldError> {
        let wanted = bisect(|step_m| self.nodes(step_m) <= f64::from(nodes));
        let wanted = wanted.clamp(FINEST_LENGTHS * transport_length_m, COARSEST_LENGTHS * transport_length_m);
        self.at_least(wanted, transport_length_m, groups, memory_mib).map_err(|_| FieldError::TooWideForNodes)
    }

    /// The wanted cell size or the smallest cell size that fits into the memory, whichever is larger.
    fn at_least(
        &self,
        wanted: f64,
        transport_length_m: f64,
        groups: usize,
        memory_mib: u64,
    ) -> Result<f64, FieldError> {
        let smallest = self.smallest_step_m(groups, memory_mib);
        let allowed = COARSEST_LENGTHS * transport_length_m;
        if smallest > allowed {
            return Err(FieldError::TooLarge { needed_mm: 1e3 * smallest, allowed_mm: 1e3 * allowed, memory_mib });
        }
        Ok(wanted.max(smallest))
    }

    /// Whether a body is so wide that even cells of ten transport mean free paths do not fit into `memory_mib`, for
    /// `groups` groups of four wavelengths.
    #[must_use]
    pub fn is_wide(&self, transport_length_m: f64, groups: usize, memory_mib: u64) -> bool {
        self.smallest_step_m(groups, memory_mib) > COARSE_LENGTHS * transport_length_m
    }

    /// Size of the finest cells of a wide body, in m: the scale that diffusion resolves, but not so small that the
    /// cells along an axis exceed their greatest number.
    #[must_use]
    pub fn finest_step_m(&self, transport_length_m: f64) -> f64 {
        (FINEST_LENGTHS * transport_length_m).max(self.bounds_m.max_element() / MAX_ALONG_AXIS as f64)
    }

    /// Returns `step_m`, the requested size of the cells at the surface, if the snow allows it and the grid fits into
    /// the memory. The other parameters are as for [`choose_step_m`](Self::choose_step_m).
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

    /// Size of the smallest cells that fit into `memory_mib`, in m, if all cells at the surface have one size.
    #[must_use]
    pub fn smallest_step_m(&self, groups: usize, memory_mib: u64) -> f64 {
        let bytes = memory_mib as f64 * f64::from(1 << 20);
        let countable_m = self.bounds_m.max_element() / MAX_ALONG_AXIS as f64;
        bisect(|step_m| self.bytes(step_m, groups) <= bytes).max(countable_m)
    }

    /// Approximate number of nodes of a grid, for layers of cells that double in size away from the surface.
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

    /// Approximate memory of the cells and equations, in MiB. `step_m` is the cell size at the surface, and `groups`
    /// the number of groups of four wavelengths.
    #[must_use]
    pub fn memory_mib(&self, step_m: f64, groups: usize) -> f64 {
        self.bytes(step_m, groups) / f64::from(1 << 20)
    }

    /// Greatest size of the cells at the surface of a body that is not wide, in m. `transport_length_m` is the
    /// transport mean free path of the snow.
    #[must_use]
    pub fn coarsest_usual_step_m(&self, transport_length_m: f64) -> f64 {
        COARSE_LENGTHS * transport_length_m
    }

    fn bytes(&self, step_m: f64, groups: usize) -> f64 {
        let at_surface = 1.5 * self.area_m2 / (step_m * step_m);
        BYTES_PER_SURFACE_CELL * at_surface + (groups * System::BYTES_PER_NODE) as f64 * self.nodes(step_m)
    }
}

/// A rule whose sizes are the sizes of another rule times a factor.
#[derive(Debug, Clone, Copy)]
pub struct ScaledSizes<'r> {
    /// The other rule.
    pub sizes: &'r dyn CellSizes,
    /// The factor.
    pub factor: f64,
}

impl CellSizes for ScaledSizes<'_> {
    fn least_between(&self, low: DVec3, high: DVec3) -> SizeLimits {
        self.sizes.least_between(low, high).map(|size_m| self.factor * size_m)
    }

    fn thin_below_m(&self) -> f64 {
        self.sizes.thin_below_m()
    }
}

/// Scales the sizes of a rule by increasing factors, from 1 on, until the grid of a body fits into `memory_mib`, for
/// `groups` groups of four wavelengths. Returns the factor and the approximate number of nodes. `step_m` is the size
/// of the finest cells in m, which does not change.
///
/// # Errors
///
/// If the factor exceeds 128.
pub fn fit_sizes(
    body: &dyn Body,
    step_m: f64,
    sizes: &dyn CellSizes,
    groups: usize,
    memory_mib: u64,
) -> Result<(f64, usize), FieldError> {
    let lattice = Lattice::around(body, step_m, DVec3::ZERO);
    let memory = memory_mib as f64 * f64::from(1 << 20);
    let mut factor = 1.0;
    while factor <= MAX_FACTOR {
        let demands = demands(body, &lattice, &ScaledSizes { sizes, factor });
        let (_, leaves) = Octree::new(&lattice, &demands);
        let at_surface = leaves.iter().filter(|leaf| leaf.is_demanded).count();
        let nodes = NODES_PER_DEMANDED_CELL * at_surface as f64;
        let bytes = (groups * System::BYTES_PER_NODE) as f64 * nodes + BYTES_PER_SURFACE_CELL * at_surface as f64;
        if bytes <= memory {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and rounded")]
            return Ok((factor, nodes.round() as usize));
        }
        factor *= (bytes / memory).sqrt().max(MIN_GROWTH);
    }
    Err(FieldError::TooMuchDetail { memory_mib })
}

/// The least size, in m, that meets a condition which all greater sizes meet too.
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
    use crate::grid::{Grid, GridOptions};
    use crate::shapes::{Ball, BoxBody, BoxWithHole};
    use crate::sizes::SizesByDistance;
    use glam::DMat3;

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
    fn a_survey_measures_a_wide_thin_slope() {
        let axes = DMat3::from_rotation_y(0.3);
        let slope = BoxBody { centre: DVec3::ZERO, size: DVec3::new(100.0, 100.0, 1.0), axes };
        let survey = Survey::new(&slope).unwrap();
        // Of 128 lines along x and y, each edge cuts one line.
        assert!((survey.volume_m3 / 1e4 - 1.0).abs() < 0.02, "{}", survey.volume_m3);
        assert!((survey.area_m2 / 2.04e4 - 1.0).abs() < 0.03, "{}", survey.area_m2);
    }

    #[test]
    fn the_sizes_of_a_rule_grow_until_the_grid_fits() {
        let slope = BoxWithHole {
            outer: BoxBody::aligned(DVec3::ZERO, DVec3::new(10.0, 10.0, 1.0)),
            hole_centre: DVec3::Z * 0.5,
            hole_size: DVec3::new(0.1, 0.1, 0.2),
        };
        let ball = Ball { centre: DVec3::ZERO, radius: 1.0 };
        let sizes = SizesByDistance {
            viewpoint: DVec3::Z * 1.5,
            sizes_per_distance: [0.03, 0.03, 0.15],
            greatest_m: 0.5,
            thin_below_m: 0.1,
        };
        let wall = BoxBody::aligned(DVec3::ZERO, DVec3::new(3.0, 3.0, 0.15));
        let turned = BoxBody { axes: DMat3::from_rotation_y(0.4), ..wall };
        let bodies: [&dyn Body; 4] = [&slope, &ball, &wall, &turned];
        for body in bodies {
            for memory_mib in [1000, 16] {
                let (factor, nodes) = fit_sizes(body, 0.01, &sizes, 1, memory_mib).unwrap();
                assert_eq!(factor > 1.0, memory_mib == 16);
                let sizes = ScaledSizes { sizes: &sizes, factor };
                let options = GridOptions { step_m: 0.01, shift: DVec3::ZERO, sizes: Some(&sizes) };
                let count = Grid::new(body, options).free_count as f64;
                let ratio = nodes as f64 / count;
                assert!(ratio > 0.6 && ratio < 1.7, "{nodes} {count}");
            }
        }
        let tiny = fit_sizes(&ball, 0.01, &sizes, 1, 0).unwrap_err();
        assert!(tiny.to_string().contains("needs cells more than 128 times as large"), "{tiny}");
    }

    #[test]
    fn a_kilometre_of_fine_snow_does_not_fit() {
        let body = BoxBody::aligned(DVec3::ZERO, DVec3::splat(1000.0));
        let error = Survey::new(&body).unwrap().choose_step_m(1e-4, 2, 1024).unwrap_err();
        assert!(matches!(error, FieldError::TooLarge { memory_mib: 1024, .. }), "{error}");
        let error = Survey::new(&body).unwrap().step_of_nodes_m(1000, 1e-4, 2, 1024).unwrap_err();
        assert!(error.to_string().contains("leave `nodes` out"), "{error}");
        let small = BoxBody::aligned(DVec3::ZERO, DVec3::new(0.6, 0.15, 0.6));
        let step_m = Survey::new(&small).unwrap().choose_step_m(0.002, 2, 1024).unwrap();
        assert!(step_m > 0.005 && step_m < 0.02, "{step_m}");
    }

    #[test]
    fn a_grid_has_about_the_nodes_that_are_wanted_unless_its_snow_needs_more() {
        let body = Ball { centre: DVec3::ZERO, radius: 0.19 };
        let survey = Survey::new(&body).unwrap();
        for nodes in [5000, 40_000] {
            let step_m = survey.step_of_nodes_m(nodes, 0.002, 2, 1024).unwrap();
            let count = Grid::new(&body, GridOptions { step_m, shift: DVec3::ZERO, sizes: None }).free_count as f64;
            let ratio = count / f64::from(nodes);
            assert!(ratio > 0.6 && ratio < 1.7, "{nodes} {count}");
        }
        let fine = survey.step_of_nodes_m(5000, 2e-4, 2, 1024).unwrap();
        assert!((fine - 50.0 * 2e-4).abs() < 1e-12, "{fine}");
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
