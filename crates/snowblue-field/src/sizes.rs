//! Cells of different sizes at the surface: coarse where the surface is flat, and as fine as a viewer needs.
//!
//! A wide body has too much surface for cells of one size. Where the surface in a cell is one flat sheet above thick
//! snow, the light along the surface varies only with the lighting, and the cell may be large. Edges, holes, thin
//! walls and curved surfaces need small cells, but only as small as a viewer can see.
//!
//! Lines along z find the surface. Their spacing is the smallest allowed cell size at their place. The lines are in
//! the order of a quadtree, so that the lines through a cell are a range. From the largest cell down, each cell that
//! is too large for the surface on its lines is divided. A steep wall thinner than the line spacing may lie between
//! lines along z. Lines along x and y find such walls, and demand cells where lines along z did not.

use std::fmt::Debug;
use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use crate::body::{Body, Scanner, Segment};
use crate::cut_cells::INWARD;
use crate::lattice::{Lattice, across};
use crate::octree::key;

/// Greatest sizes of the cells that a surface cuts, in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeLimits {
    /// Limit where the surface is a flat sheet above snow that is at least two such cells thick.
    pub flat_m: f64,
    /// Limit where the surface is not flat, above thick snow.
    pub detailed_m: f64,
    /// Limit in thin snow, which light passes, and at walls.
    pub thin_m: f64,
}

/// A rule for the sizes of the cells at the surface.
pub trait CellSizes: Debug + Sync {
    /// The least limits at any point of the box between two corners, in m. A box inside another box has no smaller
    /// limits.
    fn least_between(&self, low: DVec3, high: DVec3) -> SizeLimits;

    /// Thickness below which snow is thin, in m.
    fn thin_below_m(&self) -> f64;
}

/// Sizes that grow with the distance to a viewpoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizesByDistance {
    /// Position of the viewer, in m.
    pub viewpoint: DVec3,
    /// Cell size divided by the distance: in thin snow, at details, and at flat sheets.
    pub sizes_per_distance: [f64; 3],
    /// Greatest size of any cell, in m.
    pub greatest_m: f64,
    /// Thickness below which snow is thin, in m.
    pub thin_below_m: f64,
}

/// Greatest number of pixels of a picture that a cell may span: in thin snow, at details, and at flat sheets. Pixels
/// have the light that enters at their place, so that in thick snow cells need not resolve the light along the surface.
const PIXELS: [f64; 3] = [8.0, 16.0, 30.0];
/// Thickness below which snow is thin, in transport mean free paths: it transmits 3 % of the light or more.
const THIN_LENGTHS: f64 = 50.0;

impl SizesByDistance {
    /// Sizes for a picture from a viewpoint, in m, with an angle per pixel in rad, of snow with a transport mean free
    /// path in m. Cells span at most 8 pixels in thin snow, 16 pixels at details and 30 pixels at flat sheets, and are
    /// at most `greatest_m` wide.
    #[must_use]
    pub fn of_picture(viewpoint: DVec3, angle_per_pixel: f64, greatest_m: f64, transport_length_m: f64) -> Self {
        let sizes_per_distance = PIXELS.map(|pixels| pixels * angle_per_pixel);
        Self { viewpoint, sizes_per_distance, greatest_m, thin_below_m: THIN_LENGTHS * transport_length_m }
    }
}

impl CellSizes for SizesByDistance {
    fn least_between(&self, low: DVec3, high: DVec3) -> SizeLimits {
        let distance_m = self.viewpoint.distance(self.viewpoint.clamp(low, high));
        let [thin_m, detailed_m, flat_m] =
            self.sizes_per_distance.map(|per_distance| (per_distance * distance_m).min(self.greatest_m));
        SizeLimits { flat_m, detailed_m, thin_m }
    }

    fn thin_below_m(&self) -> f64 {
        self.thin_below_m
    }
}

/// Least cosine of the angle between a normal of a flat sheet and the mean normal: 45°.
const FLAT_COS: f32 = 0.707;
/// Least vertical component of the normal of a flat sheet: 60°. Lines along z sample steeper sheets poorly.
const STEEP_COS: f32 = 0.5;
/// Greatest distance of a flat sheet from its mean plane, in cells.
const FLAT_CELLS: f64 = 0.3;
/// Least thickness of the snow below a flat sheet, in cells. Two cells resolve light that passes through. Where light
/// decays within one cell, no light passes through two cells.
const THICK_CELLS: f64 = 2.0;
/// Ratio of height difference to distance between neighbouring lines above which there is a wall between the lines.
const WALL_SLOPE: f64 = 2.0;
/// Distance from a face of a cell within which a surface counts as lying on the face, divided by the greatest
/// coordinate of the body: four times the rounding of single precision.
const FACE_ROUNDING: f64 = 4.0 * 6e-8;
/// Positions of a line in its column, as fractions along x and y. A position is used if the lines before it have an
/// odd number of crossings. A line in the middle would meet the vertices of meshes too often.
pub(crate) const LINES: [[f64; 2]; 4] = [[0.375, 0.625], [0.625, 0.375], [0.125, 0.875], [0.875, 0.125]];
/// Number of lines from which on the parts of a cell are examined in parallel.
const PARALLEL_LINES: usize = 1 << 12;

/// A column of a quadtree over the plane of x and y, with one line along z.
#[derive(Debug, Clone)]
struct Line {
    /// Code of its finest cell of least coordinates, in the order of the quadtree.
    code: u64,
    level: u8,
    /// Position of the line, in m, unless the line there has an odd number of crossings.
    at: DVec2,
    /// Range of its segments in [`Lines::segments`].
    segments: Range<usize>,
    /// Range in [`Lines::walls`] of the height intervals in which the surface passes between this line and a
    /// neighbour.
    walls: Range<usize>,
}

/// A segment of a line inside the body.
#[derive(Debug, Clone, Copy)]
struct Inside {
    /// Heights of its ends, in m.
    ends: [f64; 2],
    /// Outward normals at its ends.
    normals: [Vec3; 2],
    /// Thickness of the body below its ends, in m: about along the normals.
    thickness_m: [f64; 2],
}

/// The lines along z, with the surface that they meet.
struct Lines<'a> {
    lattice: &'a Lattice,
    /// Distance from a face of a cell within which a surface counts as lying on the face, in m.
    rounding_m: f64,
    sizes: &'a dyn CellSizes,
    lines: Vec<Line>,
    segments: Vec<Inside>,
    walls: Vec<[f64; 2]>,
}

/// The cells at the surface that must not be part of a larger cell: for each level the keys of its cells, in order.
pub(crate) fn demands(body: &dyn Body, lattice: &Lattice, sizes: &dyn CellSizes) -> Vec<Vec<u64>> {
    let lines = Lines::new(body, lattice, sizes);
    let top = lattice.top_level();
    let mut demands = vec![Vec::new(); usize::from(top) + 1];
    for (level, key) in lines.demands(top, [0; 3], 0..lines.lines.len()) {
        demands[usize::from(level)].push(key);
    }
    demands.iter_mut().for_each(|keys| keys.sort_unstable());
    let missed = [0, 1].map(|axis| missed(body, lattice, sizes, axis, &demands));
    for (level, key) in missed.concat() {
        demands[usize::from(level)].push(key);
    }
    for keys in &mut demands {
        keys.sort_unstable();
        keys.dedup();
    }
    demands
}

/// The levels and keys of the cells that lines along an axis find at the surface and that `demands` does not contain.
fn missed(
    body: &dyn Body,
    lattice: &Lattice,
    sizes: &dyn CellSizes,
    axis: usize,
    demands: &[Vec<u64>],
) -> Vec<(u8, u64)> {
    let cell = |point: DVec3, normal: Vec3, column_level: u8| {
        let finest = lattice.cell_at(point - normal.as_dvec3() * lattice.step * INWARD[0]);
        let is_held = (0..)
            .zip(demands)
            .any(|(level, keys): (u8, _)| keys.binary_search(&key(finest.map(|k| k >> level))).is_ok());
        if is_held {
            return None;
        }
        let is_allowed = |level: &u8| {
            let coarse = lattice.coarsened(*level);
            let low = coarse.corner(finest.map(|k| k >> level));
            coarse.step.max_element() <= sizes.least_between(low, low + coarse.step).thin_m
        };
        let level = (column_level + 1..=lattice.top_level()).take_while(is_allowed).last().unwrap_or(column_level);
        Some((level, key(finest.map(|k| k >> level))))
    };
    let cast = |scanner: &mut Scanner, (level, place): &(u8, [u32; 2])| -> Vec<(u8, u64)> {
        let points = points_of_column(&lattice.coarsened(*level), axis, *place);
        let ends = scanner.sound_segments(axis, points).flat_map(|segment| [segment.enter, segment.leave]);
        let cells = ends.filter_map(|end| {
            let mut point = points[0];
            point[axis] = end.coordinate_m;
            cell(point, end.normal, *level)
        });
        cells.collect()
    };
    let columns = columns(lattice, body, sizes, axis);
    let found: Vec<Vec<(u8, u64)>> = columns.par_iter().map_init(|| Scanner::new(body), cast).collect();
    found.concat()
}

/// Points of the lines along an axis through a column: the first line, and the lines that may replace it.
fn points_of_column(coarse: &Lattice, axis: usize, place: [u32; 2]) -> [DVec3; 4] {
    let [u, v] = across(axis);
    LINES.map(|fractions| {
        let mut point = DVec3::ZERO;
        for ((k, place), fraction) in [u, v].into_iter().zip(place).zip(fractions) {
            point[k] = coarse.low[k] + (f64::from(place) + fraction) * coarse.step[k];
        }
        point
    })
}

impl<'a> Lines<'a> {
    fn new(body: &dyn Body, lattice: &'a Lattice, sizes: &'a dyn CellSizes) -> Self {
        let columns = columns(lattice, body, sizes, 2);
        let cast = |scanner: &mut Scanner, (level, place): &(u8, [u32; 2])| -> Vec<Inside> {
            let points = points_of_column(&lattice.coarsened(*level), 2, *place);
            let segments: Vec<Segment> = scanner.sound_segments(2, points).collect();
            let inside = |segment: &Segment| {
                let ends = [segment.enter, segment.leave];
                let thickness_m = ends.map(|end| {
                    let point = points[0].truncate().extend(end.coordinate_m);
                    let inside = point - end.normal.as_dvec3() * (INWARD[0] * lattice.step);
                    scanner.thickness_m(inside, end.normal)
                });
                Inside { ends: ends.map(|end| end.coordinate_m), normals: ends.map(|end| end.normal), thickness_m }
            };
            segments.iter().map(inside).collect()
        };
        let found: Vec<Vec<Inside>> = columns.par_iter().map_init(|| Scanner::new(body), cast).collect();
        let (mut lines, mut segments) = (Vec::with_capacity(columns.len()), Vec::new());
        for ((level, place), found) in columns.into_iter().zip(found) {
            let start = segments.len();
            segments.extend(found);
            let coarse = lattice.coarsened(level);
            let at = coarse.corner([place[0], place[1], 0]).truncate() + DVec2::from(LINES[0]) * coarse.step.truncate();
            let code = code(place.map(|k| k << level));
            lines.push(Line { code, level, at, segments: start..segments.len(), walls: 0..0 });
        }
        let [low, high] = body.bounds();
        let rounding_m = FACE_ROUNDING * low.abs().max(high.abs()).max_element();
        let mut lines = Self { lattice, rounding_m, sizes, lines, segments, walls: Vec::new() };
        lines.find_walls();
        lines
    }

    /// Compares each line with the lines of the neighbouring columns.
    fn find_walls(&mut self) {
        let walls = |line: &Line| -> Vec<[f64; 2]> {
            let half = self.lattice.coarsened(line.level).step.truncate() * 0.5;
            let middle = line.at + (DVec2::ONE - 2.0 * DVec2::from(LINES[0])) * half;
            let mut walls = Vec::new();
            for side in [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y] {
                let beside = self.line_at(middle + side * (half + 0.5 * self.lattice.step.truncate()));
                let distance = beside.map_or(half.max_element(), |beside| beside.at.distance(line.at));
                // Sorted in pairs, the ends of both lines' segments bound the heights at which only one of the lines
                // is inside.
                let segments = |line: &Line| self.segments[line.segments.clone()].iter();
                let own = segments(line).chain(beside.into_iter().flat_map(segments));
                let mut ends: Vec<f64> = own.flat_map(|inside| inside.ends).collect();
                ends.sort_unstable_by(f64::total_cmp);
                let apart = ends.as_chunks::<2>().0.iter().filter(|[low, high]| high - low > WALL_SLOPE * distance);
                walls.extend(apart);
            }
            walls
        };
        let found: Vec<Vec<[f64; 2]>> = self.lines.par_iter().map(walls).collect();
        for (line, found) in self.lines.iter_mut().zip(found) {
            let start = self.walls.len();
            self.walls.extend(found);
            line.walls = start..self.walls.len();
        }
    }

    /// The line of the column that holds a point; none outside of the lattice.
    fn line_at(&self, at: DVec2) -> Option<&Line> {
        let place = (at - self.lattice.low.truncate()) / self.lattice.step.truncate();
        let [nx, ny, _] = self.lattice.counts.map(|count| count as f64);
        if place.min_element() < 0.0 || place.x >= nx || place.y >= ny {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the lattice")]
        let code = code([place.x as u32, place.y as u32]);
        self.lines[..self.lines.partition_point(|line| line.code <= code)].last()
    }

    /// The levels and keys of the demands within a cell. `lines` is the range of lines through the cell.
    fn demands(&self, level: u8, place: [u32; 3], lines: Range<usize>) -> Vec<(u8, u64)> {
        let coarse = self.lattice.coarsened(level);
        // A surface on the face of a cell belongs to the cells on both sides.
        let low = coarse.corner(place) - self.rounding_m;
        let high = low + coarse.step + 2.0 * self.rounding_m;
        if !lines.clone().any(|line| self.meets(&self.lines[line], low.z, high.z)) {
            return Vec::new();
        }
        let SizeLimits { flat_m, detailed_m, thin_m } = self.sizes.least_between(low, high);
        let size_m = coarse.step.max_element();
        let is_smallest = level == 0 || self.lines[lines.start].level >= level;
        if is_smallest
            || size_m <= thin_m
            || size_m <= detailed_m && !self.is_thin(lines.clone(), low, high)
            || size_m <= flat_m && self.is_flat(lines.clone(), low, high)
        {
            return vec![(level, key(place))];
        }
        let is_wide = lines.len() >= PARALLEL_LINES;
        let of_child = |child: u32| {
            let place = [0, 1, 2].map(|k| 2 * place[k] + (child >> k & 1));
            let first = code([place[0], place[1]].map(|k| k << (level - 1)));
            let through = &self.lines[lines.clone()];
            let start = lines.start + through.partition_point(|line| line.code < first);
            let end = lines.start + through.partition_point(|line| line.code < first + (1 << (2 * (level - 1))));
            self.demands(level - 1, place, start..end)
        };
        if is_wide {
            (0..8).into_par_iter().flat_map_iter(of_child).collect()
        } else {
            (0..8).flat_map(of_child).collect()
        }
    }

    /// Whether the surface crosses a line, or passes between the line and its neighbours, at a height from `low` to
    /// `high`.
    fn meets(&self, line: &Line, low: f64, high: f64) -> bool {
        let crosses = |inside: &Inside| inside.ends.iter().any(|end| (low..=high).contains(end));
        self.segments[line.segments.clone()].iter().any(crosses)
            || self.walls[line.walls.clone()].iter().any(|wall| wall[0] < high && wall[1] > low)
    }

    /// Whether much light may pass through the snow between two corners of a cell.
    fn is_thin(&self, lines: Range<usize>, low: DVec3, high: DVec3) -> bool {
        self.lines[lines].iter().any(|line| {
            let mut ends = self.segments[line.segments.clone()]
                .iter()
                .flat_map(|inside| inside.ends.into_iter().zip(inside.thickness_m));
            ends.any(|(end, thickness_m)| (low.z..=high.z).contains(&end) && thickness_m < self.sizes.thin_below_m())
        })
    }

    /// Whether the surface passes between a line and its neighbours at the height of a cell.
    fn has_wall(&self, line: &Line, low: DVec3, high: DVec3) -> bool {
        self.walls[line.walls.clone()].iter().any(|wall| wall[0] < high.z && wall[1] > low.z)
    }

    /// Whether the surface between two corners of a cell is one flat sheet above thick snow.
    fn is_flat(&self, lines: Range<usize>, low: DVec3, high: DVec3) -> bool {
        let lines = &self.lines[lines];
        let size_m = (high - low).max_element();
        let (mut normal, mut point, mut count) = (Vec3::ZERO, DVec3::ZERO, 0.0);
        let mut least_thickness_m = f64::INFINITY;
        let crossings = || {
            let segments =
                lines.iter().flat_map(|line| self.segments[line.segments.clone()].iter().zip(std::iter::repeat(line)));
            let ends = segments.flat_map(|(inside, line)| [0, 1].map(|end| (line, inside, end)));
            ends.filter(|(_, inside, end)| (low.z..=high.z).contains(&inside.ends[*end]))
        };
        for (line, inside, end) in crossings() {
            normal += inside.normals[end];
            point += line.at.extend(inside.ends[end]);
            count += 1.0;
            least_thickness_m = least_thickness_m.min(inside.thickness_m[end]);
        }
        let (normal, point) = (normal.normalize_or_zero(), point / count);
        let is_plain = |(_, inside, end): (&Line, &Inside, usize)| inside.normals[end].dot(normal) >= FLAT_COS;
        let rise = f64::from(normal.z);
        if normal.z.abs() < STEEP_COS
            || least_thickness_m < THICK_CELLS * size_m
            || !crossings().all(is_plain)
            || lines.iter().any(|line| self.has_wall(line, low, high))
        {
            return false;
        }
        let slack_m = FLAT_CELLS * size_m / rise.abs();
        lines.iter().all(|line| {
            let aside = (line.at - point.truncate()).dot(normal.as_dvec3().truncate());
            let height = (point.z - aside / rise).clamp(low.z - slack_m, high.z + slack_m);
            // Heights that must be inside, and heights that must be outside.
            let (full, void) = if rise > 0.0 {
                ([low.z, height - slack_m], [height + slack_m, high.z])
            } else {
                ([height + slack_m, high.z], [low.z, height - slack_m])
            };
            let mut segments = self.segments[line.segments.clone()].iter();
            let is_full = full[0] >= full[1]
                || segments.clone().any(|inside| inside.ends[0] <= full[0] && inside.ends[1] >= full[1]);
            is_full && !segments.any(|inside| inside.ends[0].max(void[0]) < inside.ends[1].min(void[1]))
        })
    }
}

/// The levels and places of the columns along an axis, in quadtree order. They are the leaves of a quadtree over the
/// plane across the axis.
fn columns(lattice: &Lattice, body: &dyn Body, sizes: &dyn CellSizes, axis: usize) -> Vec<(u8, [u32; 2])> {
    let [u, v] = across(axis);
    let (mut columns, mut left) = (Vec::new(), vec![(lattice.top_level(), [0; 2])]);
    while let Some((level, place)) = left.pop() {
        let coarse = lattice.coarsened(level);
        if place[0] as usize >= coarse.counts[u] || place[1] as usize >= coarse.counts[v] {
            continue;
        }
        let [mut low, mut high] = body.bounds();
        for (k, place) in [u, v].into_iter().zip(place) {
            low[k] = coarse.low[k] + f64::from(place) * coarse.step[k];
            high[k] = low[k] + coarse.step[k];
        }
        if level == 0 || coarse.step[u].max(coarse.step[v]) <= sizes.least_between(low, high).thin_m {
            columns.push((level, place));
        } else {
            let children = (0..4).rev().map(|child| [0, 1].map(|k| 2 * place[k] + (child >> k & 1)));
            left.extend(children.map(|place| (level - 1, place)));
        }
    }
    columns
}

/// Interleaves the bits of two coordinates, which gives the order of a quadtree.
fn code([x, y]: [u32; 2]) -> u64 {
    let spread = |coordinate: u32| {
        let mut bits = u64::from(coordinate);
        for (shift, mask) in [
            (16, 0x0000_ffff_0000_ffff),
            (8, 0x00ff_00ff_00ff_00ff),
            (4, 0x0f0f_0f0f_0f0f_0f0f),
            (2, 0x3333_3333_3333_3333),
            (1, 0x5555_5555_5555_5555),
        ] {
            bits = (bits | bits << shift) & mask;
        }
        bits
    };
    spread(x) | spread(y) << 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::AxisCrossing;
    use crate::octree::place;
    use crate::shapes::{BoxBody, BoxWithHole};

    #[test]
    fn sizes_grow_with_the_distance_to_the_nearest_point_of_a_box() {
        let rule = SizesByDistance {
            viewpoint: DVec3::new(0.0, 0.0, 2.0),
            sizes_per_distance: [0.005, 0.01, 0.1],
            greatest_m: 0.15,
            thin_below_m: 0.1,
        };
        let at = |low: DVec3, high: DVec3| rule.least_between(low, high);
        let near = at(DVec3::new(-1.0, -1.0, 0.0), DVec3::ONE);
        assert!((near.detailed_m - 0.01).abs() < 1e-12 && (near.flat_m - 0.1).abs() < 1e-12, "{near:?}");
        let far = at(DVec3::new(3.0, 4.0, 2.0), DVec3::splat(9.0));
        assert!((far.detailed_m - 0.05).abs() < 1e-12 && (far.flat_m - 0.15).abs() < 1e-12, "{far:?}");
        let around = at(DVec3::splat(-3.0), DVec3::splat(3.0));
        assert!(around.detailed_m.abs() < 1e-12 && around.flat_m.abs() < 1e-12, "{around:?}");
    }

    /// Equal limits everywhere.
    #[derive(Debug)]
    struct Everywhere(SizeLimits);

    impl CellSizes for Everywhere {
        fn least_between(&self, _: DVec3, _: DVec3) -> SizeLimits {
            self.0
        }

        fn thin_below_m(&self) -> f64 {
            0.1
        }
    }

    /// A box whose faces lie outside of its bounds by the rounding of single precision.
    struct Rounded(BoxBody);

    impl Body for Rounded {
        fn bounds(&self) -> [DVec3; 2] {
            self.0.bounds()
        }

        fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>) {
            self.0.crossings(axis, point, crossings);
            let middle = self.0.centre[axis];
            crossings
                .iter_mut()
                .for_each(|crossing| crossing.coordinate_m += 5e-8 * (crossing.coordinate_m - middle).signum());
        }
    }

    #[test]
    fn faces_on_the_bounds_need_cells_whatever_the_rounding() {
        let body = BoxBody::aligned(DVec3::new(0.5, 0.1, 0.75), DVec3::splat(0.3));
        let lattice = Lattice::around(&body, 0.03, DVec3::ZERO);
        let finest = |body: &dyn Body| -> Vec<u64> {
            let keys = demands(body, &lattice, &Everywhere(SizeLimits { flat_m: 0.0, detailed_m: 0.0, thin_m: 0.0 }))
                [0]
            .clone();
            keys.into_iter().filter(|key| place(*key).iter().all(|k| *k < 10)).collect()
        };
        assert_eq!(finest(&body).len(), 10 * 10 * 10 - 8 * 8 * 8);
        assert_eq!(finest(&Rounded(body)), finest(&body));
    }

    /// Lines along z stand between walls of 3 mm, 30 mm apart.
    #[test]
    fn steep_walls_thinner_than_lines_are_apart_need_cells() {
        let outer = BoxBody::aligned(DVec3::new(0.5, 0.1, 0.75), DVec3::splat(0.3));
        let body = BoxWithHole { outer, hole_centre: outer.centre, hole_size: DVec3::splat(0.294) };
        let lattice = Lattice::around(&body, 0.03, DVec3::ZERO);
        let found = demands(&body, &lattice, &Everywhere(SizeLimits { flat_m: 0.0, detailed_m: 0.0, thin_m: 0.0 }));
        let within = found[0].iter().filter(|key| place(**key).iter().all(|k| *k < 10)).count();
        assert_eq!(within, 10 * 10 * 10 - 8 * 8 * 8);
    }

    #[test]
    fn cells_of_30_cm_do_not_miss_a_hole_of_10_cm() {
        let rule = Everywhere(SizeLimits { flat_m: 0.3, detailed_m: 0.05, thin_m: 0.05 });
        for x in [0.0, 0.013, 0.11] {
            let hole_centre = DVec3::new(x, 0.4, 0.7);
            let body = BoxWithHole {
                outer: BoxBody::aligned(DVec3::ZERO, DVec3::new(4.8, 4.8, 1.4)),
                hole_centre,
                hole_size: DVec3::new(0.1, 0.1, 0.2),
            };
            let lattice = Lattice::around(&body, 0.0375, DVec3::ZERO);
            let demands = demands(&body, &lattice, &rule);
            let at = lattice.cell_at(hole_centre - DVec3::Z * 0.1);
            let demands_at = |level: usize, key: u64| place(key) == at.map(|k| k >> level);
            let found = (0..demands.len()).find(|level| demands[*level].iter().any(|key| demands_at(*level, *key)));
            assert_eq!(found, Some(0), "{x}");
            // Far from the hole and the edges the top is flat.
            let flat = lattice.cell_at(DVec3::new(-1.3, -1.3, 0.69)).map(|k| k >> 3);
            assert!(demands[3].iter().any(|key| place(*key) == flat), "{x}");
        }
    }
}
