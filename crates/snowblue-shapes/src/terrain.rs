//! Land and snow with a surface of heights, as a closed solid whose triangles are as large as an error bound permits.
//!
//! Heights lie on a grid, with two triangles in each of its cells, as in a plain [height field](crate::height_field).
//! Prints may be pressed into the surface. The largest cells of a quadtree cover many grid cells, and its smallest
//! cells are parts of a grid cell. The quadtree is divided until the surface at each grid point, and at points within
//! prints, lies near the triangles of its cell. A cell has two triangles. Where neighbours are smaller, their corners
//! divide these triangles further, so that there are no cracks.

use arrayvec::ArrayVec;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use snowblue_base::narrow;
use snowblue_geometry::triangle_mesh::TriangleMesh;

use crate::height_field::Heights;
use crate::imprint::{Imprint, displacement_m};
use crate::quadtree::{Cell, Quadtree, Side};
use crate::sheet::{Sheet, SheetVertex};

/// Greatest number of halvings of the width of a surface. The finest cells are then 8 units in the last place of the
/// coordinates.
const MAX_LEVELS: u32 = 20;
/// Greatest number of cells along a side of the lattice on which heights and depths are compared.
const MAX_LATTICE: usize = 1 << 14;
/// Divisions of a side of a cell on which a print is compared.
const PRINT_SAMPLES: u32 = 4;
/// Rounding of coordinates, as a fraction of the greatest coordinate.
const ROUNDING: f64 = 1.0 / (1 << 22) as f64;

/// A surface of heights over a rectangle, and the solid below it.
#[derive(Debug)]
pub struct Terrain {
    /// Heights in m.
    pub heights: Heights,
    /// Position of the first height, in m.
    pub far_left_m: DVec2,
    /// Distance between two columns and between two rows, in m.
    pub cell_m: DVec2,
    /// The kind of solid.
    pub filling: Filling,
    /// Prints that are pressed into its surface.
    pub imprints: Vec<Imprint>,
}

/// The solid at a surface of heights.
#[derive(Debug)]
pub enum Filling {
    /// Everything below the heights, down to a level in m.
    Below(f64),
    /// Snow on the heights.
    Snow(SnowCover),
}

/// Snow on ground.
#[derive(Debug)]
pub struct SnowCover {
    /// Depth of the snow.
    pub depth: Depth,
    /// Height of the snow's underside above the ground, in m.
    pub gap_m: f64,
    /// Depth below which there is no snow, in m.
    pub least_depth_m: f64,
}

/// Depth of snow.
#[derive(Debug)]
pub enum Depth {
    /// Uniform depth, in m.
    Uniform(f64),
    /// Depth from an image.
    Varying(DepthImage),
}

/// Depths from an image.
#[derive(Debug)]
pub struct DepthImage {
    /// Values on a grid.
    pub values: Heights,
    /// Depths where the value is 0 and where it is 1, in m.
    pub range_m: [f64; 2],
    /// Position of the far left corner of the ground, in cells of the grid.
    pub first: DVec2,
    /// Lengths of the ground, in cells of the grid.
    pub span: DVec2,
}

/// The underside and the surface of a solid at a position, in m; equal where there is no solid.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Levels {
    bottom_m: f64,
    top_m: f64,
}

impl Depth {
    /// The depth in m at a fraction of the way from left to right and from near to far.
    fn at(&self, uv: DVec2) -> f64 {
        match self {
            Self::Uniform(depth_m) => *depth_m,
            Self::Varying(image) => image.at(uv),
        }
    }
}

impl DepthImage {
    /// An image that covers the ground from edge to edge.
    pub fn from_edge_to_edge(values: Heights, range_m: [f64; 2]) -> Self {
        let span = DVec2::new((values.columns() - 1) as f64, (values.rows() - 1) as f64);
        Self { values, range_m, first: DVec2::ZERO, span }
    }

    /// The greatest depth in m.
    pub fn greatest_m(&self) -> f64 {
        self.values.values().iter().map(|value| self.depth_m(f64::from(*value))).fold(0.0, f64::max)
    }

    fn depth_m(&self, value: f64) -> f64 {
        let [from_m, to_m] = self.range_m;
        from_m + value * (to_m - from_m)
    }

    /// The depth in m at a fraction of the way from left to right and from near to far.
    pub fn at(&self, uv: DVec2) -> f64 {
        let most = DVec2::new((self.values.columns() - 1) as f64, (self.values.rows() - 1) as f64);
        let place = self.first + DVec2::new(uv.x, 1.0 - uv.y) * self.span;
        self.depth_m(self.values.at(place.clamp(DVec2::ZERO, most)))
    }
}

impl SnowCover {
    /// The depth in m at a fraction of the way from edge to edge; 0 where the depth is below its least value.
    pub(crate) fn depth_m(&self, uv: DVec2) -> f64 {
        let depth_m = self.depth.at(uv);
        if depth_m < self.least_depth_m { 0.0 } else { depth_m }
    }
}

impl Terrain {
    /// Lengths of the rectangle, in m.
    pub(crate) fn size_m(&self) -> DVec2 {
        self.cell_m * DVec2::new((self.heights.columns() - 1) as f64, (self.heights.rows() - 1) as f64)
    }

    /// Height of the surface without prints at a position, in m; none beyond its edges.
    pub fn undisturbed_m(&self, position_m: DVec2) -> Option<f64> {
        let place = (position_m - self.far_left_m) * DVec2::new(1.0, -1.0) / self.cell_m;
        let is_inside = place.cmpge(DVec2::ZERO).all() && place.cmple(self.size_m() / self.cell_m).all();
        is_inside.then(|| self.levels(place, std::iter::empty()).top_m)
    }

    /// The solid. Its surface lies within `tolerance_m` of the heights, vertically; within a print, it lies within the
    /// print's own tolerance. Texture coordinates run from (0, 0) at the near left to (1, 1) at the far right.
    ///
    /// # Errors
    ///
    /// When the bottom is not below the least height, there is no snow, or a print is too small for the surface.
    pub fn solid(&self, tolerance_m: f64) -> Result<TriangleMesh, String> {
        if let Filling::Below(bottom_m) = self.filling {
            let least_m = self.heights.values().iter().copied().fold(f32::INFINITY, f32::min);
            if bottom_m >= f64::from(least_m) {
                return Err(format!("bottom is {bottom_m} m, but must lie below the least height of {least_m} m"));
            }
        }
        let solid = Refinement::new(self, tolerance_m)?.sheet().solid();
        if solid.indices.is_empty() {
            return Err("has no snow anywhere".to_owned());
        }
        Ok(solid)
    }

    /// Underside and surface at a place in grid cells from the far left, with some prints.
    fn levels<'a>(&self, place: DVec2, imprints: impl IntoIterator<Item = &'a Imprint>) -> Levels {
        let height_m = self.heights.at(place);
        let (bottom_m, depth_m, least_m) = match &self.filling {
            Filling::Below(bottom_m) => (*bottom_m, height_m - bottom_m, 0.0),
            Filling::Snow(snow) => {
                let uv = self.uv(place);
                (height_m + snow.gap_m, snow.depth_m(uv), snow.least_depth_m)
            }
        };
        let left_m = depth_m + displacement_m(imprints, self.position_m(place));
        let is_bare = depth_m <= 0.0 || left_m <= 0.0 || left_m < least_m;
        Levels { bottom_m, top_m: if is_bare { bottom_m } else { bottom_m + left_m } }
    }

    fn position_m(&self, place: DVec2) -> DVec2 {
        self.far_left_m + place * self.cell_m * DVec2::new(1.0, -1.0)
    }

    fn uv(&self, place: DVec2) -> DVec2 {
        let across = place * self.cell_m / self.size_m();
        DVec2::new(across.x, 1.0 - across.y)
    }
}

/// The division of a surface into cells.
struct Refinement<'a> {
    terrain: &'a Terrain,
    tolerance_m: f64,
    /// Number of units of the quadtree along a cell of the grid.
    per_grid_cell: u32,
    /// Number of units along a cell of the lattice on which the heights, and depths of snow, are compared.
    per_lattice_cell: u32,
    /// The square around each imprint, in units from the far left.
    reaches: Vec<[DVec2; 2]>,
    /// A square around all these squares.
    all_reaches: [DVec2; 2],
}

impl<'a> Refinement<'a> {
    fn new(terrain: &'a Terrain, tolerance_m: f64) -> Result<Self, String> {
        let longer = terrain.heights.columns().max(terrain.heights.rows()) - 1;
        // Depths may be finer than the heights.
        let finer = match &terrain.filling {
            Filling::Snow(SnowCover { depth: Depth::Varying(image), .. }) => {
                (image.span * terrain.cell_m / terrain.size_m()).max_element()
            }
            _ => 1.0,
        };
        let mut per_cell = 1;
        while (per_cell as f64) < finer - 1e-6 {
            per_cell *= 2;
        }
        if longer * per_cell > MAX_LATTICE && per_cell > 1 {
            return Err(format!(
                "has depths on a grid {finer} times as fine as that of the ground; at most {MAX_LATTICE} of its \
                 cells may lie side by side"
            ));
        }
        // Prints need smaller cells still.
        let levels_of_lattice = (longer * per_cell).next_power_of_two().trailing_zeros();
        let lattice_m = terrain.cell_m.max_element() / per_cell as f64;
        let most_halvings = MAX_LEVELS.saturating_sub(levels_of_lattice);
        let mut halvings = 0;
        for (number, imprint) in terrain.imprints.iter().enumerate() {
            let needed = (2.0 * lattice_m / imprint.tolerance_m()).log2().ceil().max(0.0);
            let finest_m = lattice_m / f64::from(most_halvings).exp2();
            if finest_m > imprint.coarsest_m() {
                return Err(format!(
                    "is {} m wide and has no triangles of less than {finest_m} m, but imprint {number} needs {} m; \
                     `crop` makes it smaller",
                    terrain.size_m().max_element(),
                    imprint.coarsest_m(),
                ));
            }
            while halvings < most_halvings && f64::from(halvings) < needed {
                halvings += 1;
            }
        }
        let per_lattice_cell = 1 << halvings;
        let per_grid_cell = index(per_cell) * per_lattice_cell;
        let units = f64::from(per_grid_cell);
        let reach = |imprint: &Imprint| {
            let middle = (imprint.centre_m() - terrain.far_left_m) * DVec2::new(1.0, -1.0) / terrain.cell_m;
            let half = DVec2::splat(imprint.reach_m()) / terrain.cell_m;
            [(middle - half) * units, (middle + half) * units]
        };
        let reaches: Vec<_> = terrain.imprints.iter().map(reach).collect();
        let all_reaches = reaches
            .iter()
            .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], reach| [low.min(reach[0]), high.max(reach[1])]);
        // An error below the rounding of coordinates cannot be seen.
        let tolerance_m = tolerance_m.max(ROUNDING * terrain.size_m().max_element());
        Ok(Self { terrain, tolerance_m, per_grid_cell, per_lattice_cell, reaches, all_reaches })
    }

    /// The triangles of all cells.
    fn sheet(&self) -> Sheet {
        let heights = &self.terrain.heights;
        let [columns, rows] = [heights.columns(), heights.rows()].map(|points| self.units(points - 1));
        let mut tree = Quadtree::new(columns, rows, &|cell| self.must_split(cell, [false; 4]));
        // The corners of smaller neighbours change the triangles of a cell.
        let has_changed = |tree: &Quadtree, cell| {
            let halved = Side::ALL.map(|side| tree.is_halved(cell, side));
            halved.contains(&true) && self.must_split(cell, halved)
        };
        while tree.refine(&has_changed) {}
        let corners_of = |cell: Cell| CORNERS.map(|corner| key(on_cell(cell, corner)));
        let mut corners: Vec<u64> = tree.cells().into_par_iter().flat_map_iter(corners_of).collect();
        corners.par_sort_unstable();
        corners.dedup();
        let vertices: Vec<SheetVertex> = corners.par_iter().map(|corner| self.vertex(*corner)).collect();
        let (triangles, boundary) = triangulation(&tree, &corners);
        // A level underside needs small triangles at its edge only, to fit the walls.
        let is_level = matches!(self.terrain.filling, Filling::Below(_)) && vertices.iter().all(SheetVertex::is_raised);
        let underside = is_level.then(|| {
            let at_edge = |cell| Side::ALL.into_iter().any(|side| tree.is_edge(cell, side));
            let level = Quadtree::new(columns, rows, &|cell| at_edge(cell) && tree.is_split(cell));
            triangulation(&level, &corners).0
        });
        Sheet { vertices, triangles, underside, boundary }
    }

    /// Number of units in some cells of the grid.
    fn units(&self, grid_cells: usize) -> u32 {
        index(grid_cells) * self.per_grid_cell
    }

    fn vertex(&self, corner: u64) -> SheetVertex {
        let place = self.place(units_of(corner));
        let Levels { bottom_m, top_m } = self.levels(place);
        let position = self.terrain.position_m(place).extend(bottom_m).as_vec3();
        SheetVertex { position, top: narrow(top_m), uv: self.terrain.uv(place).as_vec2() }
    }

    /// Converts a place in units to grid cells.
    fn place(&self, units: DVec2) -> DVec2 {
        units / f64::from(self.per_grid_cell)
    }

    fn levels(&self, place: DVec2) -> Levels {
        let units = place * f64::from(self.per_grid_cell);
        let is_near = units.cmpge(self.all_reaches[0]).all() && units.cmple(self.all_reaches[1]).all();
        self.terrain.levels(place, if is_near { self.terrain.imprints.as_slice() } else { &[] })
    }

    /// Whether the triangles of a cell miss the surface. `halved` says for each side whether it has a corner in its
    /// middle.
    fn must_split(&self, cell: Cell, halved: [bool; 4]) -> bool {
        let low = DVec2::new(cell.x.into(), cell.y.into());
        let high = low + f64::from(cell.size);
        let meets = |reach: &[DVec2; 2]| low.cmplt(reach[1]).all() && high.cmpgt(reach[0]).all();
        let meets_any = meets(&self.all_reaches);
        let printed = self.terrain.imprints.iter().zip(&self.reaches).filter(|(_, reach)| meets_any && meets(reach));
        let limits = printed.map(|(imprint, _)| [imprint.coarsest_m(), imprint.tolerance_m()]);
        let finest = limits.reduce(|[size, tolerance], [other_size, other_tolerance]| {
            [size.min(other_size), tolerance.min(other_tolerance)]
        });
        let Some([coarsest_m, print_tolerance_m]) = finest else {
            let divisions = cell.size / self.per_lattice_cell;
            return divisions > 1 && self.misses(cell, halved, divisions, self.tolerance_m);
        };
        let side_m = f64::from(cell.size) / f64::from(self.per_grid_cell) * self.terrain.cell_m.max_element();
        cell.size > self.per_lattice_cell || side_m > coarsest_m || self.misses_print(cell, halved, print_tolerance_m)
    }

    /// Whether the surface at some points of a cell is farther above or below its triangles than a tolerance.
    fn misses(&self, cell: Cell, halved: [bool; 4], divisions: u32, tolerance_m: f64) -> bool {
        let triangles = planes(halved, |point| self.levels(self.place(units_of(key(on_cell(cell, point))))));
        let step = f64::from(cell.size) / f64::from(divisions);
        let mut is_off = false;
        let mut has_snow = false;
        for row in 0..=divisions {
            for column in 0..=divisions {
                let within = DVec2::new(column.into(), row.into()) / f64::from(divisions);
                let units = DVec2::new(cell.x.into(), cell.y.into()) + DVec2::new(column.into(), row.into()) * step;
                let levels = self.levels(self.place(units));
                let found = triangles.at(within);
                has_snow |= levels.top_m > levels.bottom_m;
                is_off |= (levels.top_m - found.top_m).abs() > tolerance_m
                    || (levels.bottom_m - found.bottom_m).abs() > tolerance_m;
                if is_off && has_snow {
                    return true;
                }
            }
        }
        // Where there is no snow, there is nothing to be seen.
        false
    }

    /// Whether the triangles of a cell miss a print. Distances to the surface are compared, which on the walls of a
    /// print are much less than height differences.
    fn misses_print(&self, cell: Cell, halved: [bool; 4], tolerance_m: f64) -> bool {
        const SIDE: usize = PRINT_SAMPLES as usize + 1;
        let step = f64::from(cell.size) / f64::from(PRINT_SAMPLES);
        let place_of = |column: usize, row: usize| {
            let units = DVec2::new(cell.x.into(), cell.y.into()) + DVec2::new(column as f64, row as f64) * step;
            self.place(units)
        };
        let levels: [[Levels; SIDE]; SIDE] =
            std::array::from_fn(|row| std::array::from_fn(|column| self.levels(place_of(column, row))));
        // The corners of triangles are among the samples.
        let triangles = planes(halved, |point| {
            let [column, row] = point.map(|halves| usize::from(halves) * (SIDE - 1) / 2);
            levels[row][column]
        });
        let step_m = self.terrain.cell_m * step / f64::from(self.per_grid_cell);
        let slope = |before: Levels, after: Levels, steps: usize, step_m: f64| {
            (after.top_m - before.top_m) / (step_m * steps as f64)
        };
        let both = |at: usize| [at.saturating_sub(1), (at + 1).min(SIDE - 1)];
        (0..SIDE * SIDE).any(|number| {
            let (column, row) = (number % SIDE, number / SIDE);
            let ([left, right], [far, near]) = (both(column), both(row));
            let across = slope(levels[row][left], levels[row][right], right - left, step_m.x);
            let down = slope(levels[far][column], levels[near][column], near - far, step_m.y);
            let steepness = DVec3::new(across, down, 1.0).length();
            let found = triangles.at(DVec2::new(column as f64, row as f64) / f64::from(PRINT_SAMPLES));
            let sampled = levels[row][column];
            (sampled.top_m - found.top_m).abs() > tolerance_m * steepness
                || (sampled.bottom_m - found.bottom_m).abs() > tolerance_m.max(self.tolerance_m)
        })
    }
}

/// The planes of the triangles of a cell, by the levels at its points.
fn planes(halved: [bool; 4], levels: impl Fn(CellPoint) -> Levels) -> Planes {
    Planes(triangles_of(halved).into_iter().map(|points| Plane::new(points, points.map(&levels))).collect())
}

/// The triangles of all cells, and their edges at the boundary of the surface, by the numbers of corners.
fn triangulation(tree: &Quadtree, corners: &[u64]) -> (Vec<[u32; 3]>, Vec<[u32; 2]>) {
    let part_of = |cells: &[Cell]| {
        let (mut triangles, mut boundary) = (Vec::with_capacity(2 * cells.len()), Vec::new());
        for &cell in cells {
            let number = |point| {
                let key = key(on_cell(cell, point));
                index(corners.partition_point(|corner| *corner < key))
            };
            let halved = Side::ALL.map(|side| tree.is_halved(cell, side));
            triangles.extend(triangles_of(halved).into_iter().map(|triangle| triangle.map(number)));
            let edges = Side::ALL.into_iter().filter(|side| tree.is_edge(cell, *side));
            boundary.extend(edges.map(|side| edge_of(side).map(number)));
        }
        (triangles, boundary)
    };
    let (mut triangles, mut boundary) = (Vec::new(), Vec::new());
    for (some, edges) in tree.cells().par_chunks(1 << 12).map(part_of).collect::<Vec<_>>() {
        triangles.extend(some);
        boundary.extend(edges);
    }
    (triangles, boundary)
}

/// A point of a cell, in halves of its side from the far left.
type CellPoint = [u8; 2];

const FAR_LEFT: CellPoint = [0, 0];
const FAR_RIGHT: CellPoint = [2, 0];
const NEAR_LEFT: CellPoint = [0, 2];
const NEAR_RIGHT: CellPoint = [2, 2];
const CORNERS: [CellPoint; 4] = [FAR_LEFT, FAR_RIGHT, NEAR_LEFT, NEAR_RIGHT];

/// The ends of a side, counter-clockwise as seen from above.
fn edge_of(side: Side) -> [CellPoint; 2] {
    match side {
        Side::Far => [FAR_RIGHT, FAR_LEFT],
        Side::Right => [NEAR_RIGHT, FAR_RIGHT],
        Side::Near => [NEAR_LEFT, NEAR_RIGHT],
        Side::Left => [FAR_LEFT, NEAR_LEFT],
    }
}

/// The triangles of a cell, counter-clockwise as seen from above; for each side, whether it has a corner in its middle.
///
/// The diagonal from far left to near right always divides the cell, as it divides the cells of the grid.
fn triangles_of([far, right, near, left]: [bool; 4]) -> ArrayVec<[CellPoint; 3], 6> {
    let half = |from: CellPoint, corner: CellPoint, to: CellPoint, halved: [bool; 2]| {
        let middle = |one: CellPoint, other: CellPoint| [(one[0] + other[0]) / 2, (one[1] + other[1]) / 2];
        let (before, after) = (middle(from, corner), middle(corner, to));
        let mut triangles = ArrayVec::<_, 3>::new();
        match halved {
            [false, false] => triangles.push([from, corner, to]),
            [true, false] => triangles.extend([[from, before, to], [before, corner, to]]),
            [false, true] => triangles.extend([[from, corner, after], [from, after, to]]),
            [true, true] => triangles.extend([[before, corner, after], [from, before, after], [from, after, to]]),
        }
        triangles
    };
    let near_left = half(FAR_LEFT, NEAR_LEFT, NEAR_RIGHT, [left, near]);
    near_left.into_iter().chain(half(NEAR_RIGHT, FAR_RIGHT, FAR_LEFT, [right, far])).collect()
}

/// A point of a cell, in units from the far left.
fn on_cell(cell: Cell, [x, y]: CellPoint) -> [u32; 2] {
    [cell.x + u32::from(x) * cell.size / 2, cell.y + u32::from(y) * cell.size / 2]
}

/// A point as a number that is sorted by rows.
fn key([x, y]: [u32; 2]) -> u64 {
    u64::from(y) << 32 | u64::from(x)
}

/// The point of a key, in units.
fn units_of(key: u64) -> DVec2 {
    let [x, y] = [key & u64::from(u32::MAX), key >> 32];
    DVec2::new(x as f64, y as f64)
}

#[expect(clippy::cast_possible_truncation, reason = "a surface has at most 2^28 heights, and is divided into 2^20")]
fn index(place: usize) -> u32 {
    place as u32
}

/// The triangles of a cell, for interpolating the levels between their corners.
struct Planes(ArrayVec<Plane, 6>);

/// A triangle of a cell.
struct Plane {
    /// Its corners, as fractions of the cell's side.
    corners: [DVec2; 3],
    levels: [Levels; 3],
}

impl Plane {
    fn new(points: [CellPoint; 3], levels: [Levels; 3]) -> Self {
        Self { corners: points.map(|[x, y]| 0.5 * DVec2::new(x.into(), y.into())), levels }
    }

    /// The weights of the corners at a point. Outside of the triangle, some weights are negative.
    fn weights(&self, point: DVec2) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let area = (b - a).perp_dot(c - a);
        let [for_a, for_b] = [(c - b).perp_dot(point - b), (a - c).perp_dot(point - c)].map(|part| part / area);
        [for_a, for_b, 1.0 - for_a - for_b]
    }
}

impl Planes {
    /// The levels of the triangles at a point, by fractions of the cell's side.
    fn at(&self, point: DVec2) -> Levels {
        let least = |weights: &[f64; 3]| weights.iter().copied().fold(f64::INFINITY, f64::min);
        // The triangle that holds the point, or misses it by rounding only.
        let mut best = ([f64::NEG_INFINITY; 3], &self.0[0]);
        for plane in &self.0 {
            let weights = plane.weights(point);
            if least(&weights) > least(&best.0) {
                best = (weights, plane);
            }
        }
        let (weights, plane) = best;
        let sum = |level: fn(&Levels) -> f64| {
            weights.iter().zip(&plane.levels).map(|(weight, levels)| weight * level(levels)).sum()
        };
        Levels { bottom_m: sum(|levels| levels.bottom_m), top_m: sum(|levels| levels.top_m) }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glam::{DAffine3, Vec3A};

    use super::*;
    use crate::imprint::{Foot, ImprintKind, Sole, Wall};
    use snowblue_geometry::mesh_bvh::MeshBvh;
    use snowblue_geometry::ray::Ray;
    use snowblue_geometry::topology::{Topology, volume};
    use snowblue_geometry::transform::Transform;

    /// Heights by a function of x and y, about the origin.
    fn terrain(points: [usize; 2], cell_m: f64, filling: Filling, height_m: impl Fn(DVec2) -> f64) -> Terrain {
        let cells = DVec2::new((points[0] - 1) as f64, (points[1] - 1) as f64);
        let far_left_m = 0.5 * cell_m * cells * DVec2::new(-1.0, 1.0);
        let place = |at: usize| DVec2::new((at % points[0]) as f64, -((at / points[0]) as f64));
        let height = |at: usize| narrow(height_m(far_left_m + cell_m * place(at)));
        let heights = Heights::new(points[0], (0..points[0] * points[1]).map(height).collect()).unwrap();
        Terrain { heights, far_left_m, cell_m: DVec2::splat(cell_m), filling, imprints: Vec::new() }
    }

    fn snow(depth: Depth) -> Filling {
        Filling::Snow(SnowCover { depth, gap_m: 0.001, least_depth_m: 0.001 })
    }

    /// Asserts a closed mesh of consistent orientation, without cracks, T-junctions or doubled vertices.
    fn check_closed(solid: &TriangleMesh) {
        let topology = Topology::of(solid);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        assert_eq!((topology.merged_vertices, topology.degenerate_triangles), (0, 0), "{topology:?}");
    }

    fn hole(x: f64, y: f64, radius_m: f64, depth_m: f64) -> Imprint {
        let wall = Wall { width_m: depth_m * 2.0f64.to_radians().tan(), rim_m: 0.0, rim_width_m: 0.1 };
        Imprint::new(DVec2::new(x, y), ImprintKind::Hole { radius_m, depth_m }, wall)
    }

    fn hills_m(position: DVec2) -> f64 {
        2.0 * (TAU * position.x / 40.0).cos() * (TAU * position.y / 20.0).cos()
    }

    #[test]
    fn snow_has_the_volume_of_its_plan_times_its_depth() {
        let slope_m = |position: DVec2| 0.3 * position.x - 0.1 * position.y;
        let flat = terrain([9, 6], 0.5, snow(Depth::Uniform(0.8)), |_| 3.0).solid(0.0).unwrap();
        let sloping = terrain([9, 6], 0.5, snow(Depth::Uniform(0.8)), slope_m).solid(0.0).unwrap();
        for solid in [&flat, &sloping] {
            check_closed(solid);
            // Coordinates up to 4 m are rounded by 2e-7 m.
            assert!((volume(solid) - 4.0 * 2.5 * 0.8).abs() < 1e-5, "{}", volume(solid));
            // Each of 8 × 5 cells would have two triangles above and two below, and each of 26 cell sides at the edge
            // would have two.
            assert!(solid.indices.len() < (4 * 40 + 2 * 26) * 2 / 3, "{} triangles", solid.indices.len());
        }
        assert!((flat.positions.iter().map(|vertex| vertex.z).fold(0.0, f32::max) - 3.801).abs() < 1e-6);
    }

    #[test]
    fn hills_keep_their_volume_and_their_heights_within_the_tolerance() {
        let hills = terrain([321, 161], 0.25, Filling::Below(-3.0), hills_m);
        let exact = hills.solid(0.0).unwrap();
        let coarse = hills.solid(0.05).unwrap();
        for solid in [&exact, &coarse] {
            check_closed(solid);
        }
        // The mean height over whole waves is 0.
        let whole_m3 = 80.0 * 40.0 * 3.0;
        assert!((volume(&exact) - whole_m3).abs() < 1e-5 * whole_m3, "{}", volume(&exact));
        assert!((volume(&coarse) - whole_m3).abs() < 0.05 * 80.0 * 40.0);
        // Two triangles in each cell, walls of two at each edge, and a coarser underside.
        let on_top_and_sides = 2 * 320 * 160 + 4 * (320 + 160);
        assert!((on_top_and_sides..on_top_and_sides * 11 / 10).contains(&exact.indices.len()));
        assert!(coarse.indices.len() < exact.indices.len() / 10, "{} triangles", coarse.indices.len());
        let mesh = MeshBvh::new(coarse);
        for row in 0..161u16 {
            for column in 0..321u16 {
                let position = DVec2::new(f64::from(column) * 0.25 - 40.0, 20.0 - f64::from(row) * 0.25);
                // A little inwards, so that lines do not miss the edge; slopes are below 0.7.
                let origin = Vec3A::new(narrow(0.9999 * position.x), narrow(0.9999 * position.y), 10.0);
                let hit = mesh.first_hit(&Ray::new(origin, Vec3A::NEG_Z), f32::INFINITY).unwrap();
                let error_m = f64::from(hit.point.z) - hills_m(position);
                assert!(error_m.abs() < 0.05 + 0.7 * 0.005, "{position}: {error_m}");
            }
        }
    }

    #[test]
    fn there_is_no_solid_where_there_is_no_snow() {
        // A drift map finer than the ground: snow on the left half, in steps of 1/8 m.
        let value = |at: usize| if at % 17 < 8 { 1.0 } else { 0.0 };
        let values = Heights::new(17, (0..17 * 9).map(value).collect()).unwrap();
        let ground = |depth: Depth| terrain([5, 3], 0.5, snow(depth), |position| 0.1 * position.x);
        let solid = ground(Depth::Varying(DepthImage::from_edge_to_edge(values, [0.0, 0.4]))).solid(0.0).unwrap();
        check_closed(&solid);
        // Up to x = −1/8 m the snow has the whole depth, and over the next 1/8 m half the depth. The snow is 1 m wide.
        assert!((volume(&solid) - 0.4 * (0.875 + 0.125 / 2.0)).abs() < 1e-5, "{}", volume(&solid));
        let far_right = solid.positions.iter().map(|vertex| vertex.x).fold(f32::NEG_INFINITY, f32::max);
        assert!(far_right.abs() < 1e-6);
        let none = Heights::new(2, vec![0.0; 4]).unwrap();
        let message = ground(Depth::Varying(DepthImage::from_edge_to_edge(none, [0.0, 0.4]))).solid(0.0).unwrap_err();
        assert_eq!(message, "has no snow anywhere");
    }

    #[test]
    fn a_hole_takes_the_volume_of_its_cone_out_of_the_snow() {
        let mut land = terrain([5, 5], 0.5, snow(Depth::Uniform(0.8)), |_| 0.0);
        let whole_m3 = volume(&land.solid(0.0).unwrap());
        land.imprints = vec![hole(0.13, -0.21, 0.03, 0.4)];
        let solid = land.solid(0.0).unwrap();
        check_closed(&solid);
        let below_m = 0.03 - 0.4 * 2.0f64.to_radians().tan();
        let cone_m3 = PI * 0.4 / 3.0 * (0.03f64.powi(2) + 0.03 * below_m + below_m.powi(2));
        // The wall lies within a 25th of the radius of 3 cm: 8 % of the volume at most, and less on average.
        let taken_m3 = whole_m3 - volume(&solid);
        assert!((taken_m3 / cone_m3 - 1.0).abs() < 0.04, "{taken_m3} m³ of {cone_m3} m³");
        // The undisturbed surface is the surface without the hole.
        assert!((land.undisturbed_m(DVec2::new(0.13, -0.21)).unwrap() - 0.801).abs() < 1e-9);
        assert_eq!(land.undisturbed_m(DVec2::new(1.01, 0.0)), None);
    }

    #[test]
    fn a_hole_deeper_than_the_snow_ends_on_the_ground() {
        let mut land = terrain([2, 2], 2.0, snow(Depth::Uniform(0.2)), |_| 0.0);
        land.imprints = vec![hole(0.0, 0.0, 0.05, 0.5)];
        let solid = land.solid(0.0).unwrap();
        check_closed(&solid);
        let mesh = MeshBvh::new(solid);
        let down = |x: f32| {
            let ray = Ray::new(Vec3A::new(x, 0.003, 1.0), Vec3A::NEG_Z);
            mesh.first_hit(&ray, f32::INFINITY).map(|hit| hit.point.z)
        };
        assert_eq!(down(0.0), None);
        assert!((down(0.2).unwrap() - 0.201).abs() < 1e-6);
    }

    #[test]
    fn prints_lie_within_their_tolerance() {
        let mut land = terrain([21, 21], 0.1, Filling::Below(-0.5), |position| 0.02 * (7.0 * position.x).sin());
        let wall = Wall { width_m: 0.011, rim_m: 0.01, rim_width_m: 0.05 };
        let sole = Sole::new(30.0, 0.3, [0.08, 0.06], 0.004, Foot::Left);
        land.imprints =
            vec![Imprint::new(DVec2::new(-0.4, 0.3), ImprintKind::Footprint(sole), wall), hole(0.5, -0.5, 0.025, 0.3)];
        let solid = land.solid(0.0).unwrap();
        check_closed(&solid);
        assert!(solid.indices.len() < 300_000, "{} triangles", solid.indices.len());
        let mesh = MeshBvh::new(solid);
        let identity = Transform::new(&DAffine3::IDENTITY).unwrap();
        for imprint in &land.imprints {
            let mut far = 0;
            for k in 0..200u16 * 200 {
                let within = DVec2::new(f64::from(k % 200) + 0.31, f64::from(k / 200) + 0.77) / 100.0 - 1.0;
                let position_m = imprint.centre_m() + within * imprint.reach_m();
                let place = (position_m - land.far_left_m) * DVec2::new(1.0, -1.0) / land.cell_m;
                let point = position_m.extend(land.levels(place, &land.imprints).top_m).as_vec3a();
                far += u32::from(!mesh.is_near(&identity, point, narrow(imprint.tolerance_m())));
            }
            // The tolerance is checked at some points of each triangle only.
            assert!(far < 40, "{far} of 40000 points are farther away");
        }
    }

    #[test]
    fn surfaces_without_room_are_refused() {
        let low = terrain([3, 3], 1.0, Filling::Below(0.5), |position| 1.0 + 0.6 * position.x);
        assert_eq!(low.solid(0.0).unwrap_err(), "bottom is 0.5 m, but must lie below the least height of 0.4 m");
        let mut wide = terrain([4001, 3], 30.0, Filling::Below(-1.0), |_| 0.0);
        wide.imprints = vec![hole(0.0, 0.0, 0.02, 0.1)];
        let message = wide.solid(0.0).unwrap_err();
        assert!(message.contains("is 120000 m wide") && message.contains("imprint 0 needs 0.01 m"), "{message}");
    }
}
