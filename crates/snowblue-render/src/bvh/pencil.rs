//! Lines through one point, and which leaves of a mesh's hierarchy each of them may meet.
//!
//! All rays of a camera go through one point, and so do all lines to a lamp without extent. Seen from there a mesh is a picture, and
//! a line a place in it: what the line may meet is listed in the cell about that place, nearest first, and nothing is left to walk
//! (Haines & Greenberg 1986, "The light buffer: a shadow-testing accelerator", doi:10.1109/MCG.1986.276832).

use std::ops::RangeInclusive;

use glam::{Vec2, Vec3A};
use rayon::prelude::*;

use crate::geometry::bounds::Bounds;
use crate::geometry::ray::Ray;
use crate::geometry::triangle::FourTriangles;

/// Cells for each leaf. More cost memory; of fewer, each lists more leaves.
const CELLS_PER_LEAF: f32 = 4.0;

/// Most lists that a leaf may be in, on average. A dozen to forty are usual; slivers are in many.
const MOST_LISTS: usize = 64;

/// Greatest tangent of the angle at which a corner of the mesh's box is seen from the middle of the picture.
const GREATEST_TANGENT: f32 = 2.0;

/// How far beside the point lines may pass, as a share of the greatest distance or coordinate: 64 units in the last place, where
/// those that are meant pass within a few.
const TOLERANCE: f32 = 64.0 * f32::EPSILON;

/// A mesh as it is seen from a point.
#[derive(Debug, Clone)]
pub(crate) struct Pencil {
    view: View,
    /// How far beside the point lines may pass.
    tolerance: f32,
    grid: Grid,
    /// Where the list of each cell begins, and where the last one ends.
    starts: Vec<u32>,
    /// The lists: leaves by their numbers, the nearest first.
    lists: Vec<u32>,
    /// The least depth of each leaf.
    depths: Vec<f32>,
}

/// What a line through the point may meet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Listed<'pencil> {
    leaves: &'pencil [u32],
    depths: &'pencil [f32],
    /// Depth of the line's origin.
    origin: f32,
    /// How depth grows along the line.
    slope: f32,
    from: f32,
    to: f32,
}

/// A point, and unit vectors from there: towards the mesh, and along the two sides of the picture.
#[derive(Debug, Clone, Copy)]
struct View {
    point: Vec3A,
    ahead: Vec3A,
    across: Vec3A,
    down: Vec3A,
}

/// The box of a leaf in the picture, in tangents, and the leaf's least depth.
#[derive(Debug, Clone, Copy)]
struct Outline {
    low: Vec2,
    high: Vec2,
    depth: f32,
}

/// Cells of a picture, row by row.
#[derive(Debug, Clone, Copy)]
struct Grid {
    /// The corner where they begin, in tangents.
    low: Vec2,
    /// Cells in a tangent of 1.
    per_tangent: f32,
    columns: usize,
    rows: usize,
}

impl View {
    /// Where a direction, forth or back, lies in the picture, in tangents.
    #[inline]
    fn place(&self, direction: Vec3A) -> Vec2 {
        Vec2::new(self.across.dot(direction), self.down.dot(direction)) / self.ahead.dot(direction)
    }

    /// What lines that pass by the point at most at a distance may meet of a leaf, in the picture.
    fn outline(&self, leaf: &FourTriangles, tolerance: f32) -> Outline {
        let mut outline = Outline { low: Vec2::INFINITY, high: Vec2::NEG_INFINITY, depth: f32::INFINITY };
        for corner in leaf.all_corners() {
            let way = Vec3A::from(corner) - self.point;
            let place = self.place(way);
            outline.low = outline.low.min(place);
            outline.high = outline.high.max(place);
            outline.depth = outline.depth.min(self.ahead.dot(way));
        }
        // A line that passes by the point at a distance m meets its places up to m (1 + tangent) / depth beside its own. The rest
        // is for the rounding of both.
        let margin = (1.0 + GREATEST_TANGENT) * tolerance / outline.depth + TOLERANCE;
        Outline { low: outline.low - margin, high: outline.high + margin, depth: outline.depth - tolerance }
    }
}

impl Grid {
    /// About as many cells as are asked for, over a part of the picture.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative, and as many as there is room for"
    )]
    fn new(low: Vec2, high: Vec2, cells: f32) -> Self {
        let size = high - low;
        let per_tangent = (cells / size.element_product()).sqrt();
        let [columns, rows] = (size * per_tangent).to_array().map(|cells| cells as usize + 1);
        Self { low, per_tangent, columns, rows }
    }

    /// Column and row of a place; of one outside those of the nearest cell.
    #[inline]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cast ends at 0, and the rest is cut"
    )]
    fn nearest(&self, place: Vec2) -> [usize; 2] {
        let at = (place - self.low) * self.per_tangent;
        [(at.x as usize).min(self.columns - 1), (at.y as usize).min(self.rows - 1)]
    }

    /// The columns and the rows in which a leaf is.
    fn span(&self, outline: &Outline) -> [RangeInclusive<usize>; 2] {
        let [left, top] = self.nearest(outline.low);
        let [right, bottom] = self.nearest(outline.high);
        [left..=right, top..=bottom]
    }

    /// The cells in which a leaf is.
    fn cells(&self, outline: &Outline) -> impl Iterator<Item = usize> {
        let ([columns, rows], width) = (self.span(outline), self.columns);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    /// Where the list of each cell begins and the last one ends, and the lists, each with the nearest leaf first; none if they are
    /// too long.
    #[expect(clippy::cast_possible_truncation, reason = "a mesh has fewer than 2^31 triangles")]
    fn lists(&self, outlines: &[Outline]) -> Option<(Vec<u32>, Vec<u32>)> {
        let spans = outlines.iter().map(|outline| self.span(outline));
        let total: usize = spans.map(|spans| spans.map(|span| span.end() - span.start() + 1)).map(|[x, y]| x * y).sum();
        let total = u32::try_from(total).ok().filter(|_| total <= MOST_LISTS * outlines.len())?;
        let mut order: Vec<u32> = (0..outlines.len() as u32).collect();
        let depth = |leaf: u32| outlines[leaf as usize].depth;
        order.par_sort_unstable_by(|&a, &b| depth(a).total_cmp(&depth(b)).then(a.cmp(&b)));
        // Where each list ends; as it is filled from its end, where it begins.
        let mut places = vec![0; self.columns * self.rows + 1];
        outlines.iter().flat_map(|outline| self.cells(outline)).for_each(|cell| places[cell] += 1);
        let mut end = 0;
        for place in &mut places {
            end += *place;
            *place = end;
        }
        let mut lists = vec![0; total as usize];
        for &leaf in order.iter().rev() {
            for cell in self.cells(&outlines[leaf as usize]) {
                places[cell] -= 1;
                lists[places[cell] as usize] = leaf;
            }
        }
        Some((places, lists))
    }
}

impl Pencil {
    /// The leaves of a mesh within `bounds` as they are seen from a point; none if the point is too close to see all of the mesh at
    /// once, or if the lists would grow too long.
    pub(crate) fn new(point: Vec3A, bounds: &Bounds, leaves: &[FourTriangles]) -> Option<Self> {
        let ahead = (0.5 * (bounds.low + bounds.high) - point).try_normalize()?;
        let (across, down) = ahead.any_orthonormal_pair();
        let view = View { point, ahead, across, down };
        let ways = bounds.corners().map(|corner| corner - point);
        let least_depth = bounds.diagonal_m() / 16.0;
        let seen = |way: &Vec3A| ahead.dot(*way) >= least_depth && view.place(*way).length() <= GREATEST_TANGENT;
        if !ways.iter().all(seen) {
            return None;
        }
        let greatest_coordinate = bounds.greatest_coordinate().max(point.abs().max_element());
        let tolerance = TOLERANCE * ways.iter().map(|way| way.length()).fold(greatest_coordinate, f32::max);
        let outlines: Vec<Outline> = leaves.par_iter().map(|leaf| view.outline(leaf, tolerance)).collect();
        let low = outlines.iter().fold(Vec2::INFINITY, |low, one| low.min(one.low));
        let high = outlines.iter().fold(Vec2::NEG_INFINITY, |high, one| high.max(one.high));
        let grid = Grid::new(low, high, CELLS_PER_LEAF * leaves.len() as f32);
        let (starts, lists) = grid.lists(&outlines)?;
        let depths = outlines.iter().map(|outline| outline.depth).collect();
        Some(Self { view, tolerance, grid, starts, lists, depths })
    }

    /// The room that it takes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.lists) + size_of_val(&*self.depths)
    }

    /// What a line may meet between two distances along it; none if it does not go through the point.
    #[inline]
    pub(crate) fn listed(&self, line: &Ray, from: f32, to: f32) -> Option<Listed<'_>> {
        let way = line.origin - self.view.point;
        // Half for the rounding of what else is asked of the line.
        if way.cross(line.direction).length() > 0.5 * self.tolerance {
            return None;
        }
        let place = self.view.place(line.direction);
        let [column, row] = self.grid.nearest(place);
        let cell = row * self.grid.columns + column;
        Some(Listed {
            leaves: &self.lists[self.starts[cell] as usize..self.starts[cell + 1] as usize],
            depths: &self.depths,
            origin: self.view.ahead.dot(way),
            slope: self.view.ahead.dot(line.direction),
            from,
            to,
        })
    }
}

impl Listed<'_> {
    /// Calls `visit` with the leaves until it has seen enough.
    #[inline]
    pub(crate) fn walk(&self, mut visit: impl FnMut(usize) -> bool) {
        let most = self.greatest_depth(self.to);
        for &leaf in self.leaves {
            if self.depths[leaf as usize] > most || visit(leaf as usize) {
                return;
            }
        }
    }

    /// Calls `visit` with the leaves, the nearest to the point first; it returns the distance up to which to look on.
    #[inline]
    pub(crate) fn traverse_ordered(&self, mut visit: impl FnMut(usize) -> f32) {
        let mut most = self.greatest_depth(self.to);
        for &leaf in self.leaves {
            if self.depths[leaf as usize] > most {
                return;
            }
            most = self.greatest_depth(visit(leaf as usize).min(self.to));
        }
    }

    /// The greatest depth up to a distance along the line.
    #[inline]
    fn greatest_depth(&self, to: f32) -> f32 {
        self.origin + (self.slope * self.from).max(self.slope * to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    use crate::geometry::mesh::Mesh;
    use crate::geometry::mesh::tests::{directions, sphere};
    use crate::geometry::triangles::Triangles;

    /// A bumpy body with hollows, so that lines cross it up to ten times.
    fn bumpy() -> Vec<[Vec3; 3]> {
        let bump = |at: Vec3| at * (0.7 + 0.3 * ((9.0 * at.x).sin() * (11.0 * at.y).sin() * (8.0 * at.z).cos()));
        sphere(32).into_iter().map(|corners| corners.map(bump)).collect()
    }

    /// Lines through a point or up to `beside` off it: at the mesh's corners and edges, at the places between, and past it; forth and
    /// back, from the point, from before the mesh, from within, and from behind it.
    fn lines(point: Vec3A, beside: f32, triangles: &[[Vec3; 3]]) -> impl Iterator<Item = Ray> {
        directions(6000).enumerate().map(move |(k, aside)| {
            let point = point + aside * (beside * (k % 3) as f32 / 2.0);
            let [a, b, c] = triangles[k * 13 % triangles.len()].map(Vec3A::from);
            let target = [a, 0.5 * (a + b), (a + b + c) / 3.0, 1.5 * aside][k % 4];
            let from = point.lerp(target, [0.0, 0.9, 1.0, 1.1, 1.3][k % 5]);
            let direction = if k % 5 == 0 { target - point } else { (target - point) * [1.0, -1.0][k / 20 % 2] };
            Ray { origin: from, direction: direction.normalize() }
        })
    }

    #[test]
    fn lines_through_the_point_meet_the_same_as_on_a_walk() {
        let triangles = bumpy();
        let mesh = Mesh::new(Triangles::loose(&triangles));
        for point in [Vec3A::new(2.0, 0.3, -0.2), Vec3A::new(-2.0, 3.0, 1.0), Vec3A::new(5.0, 40.0, -300.0)] {
            let pencils = [mesh.pencil(point).unwrap()];
            let (mut listed, mut crossed, mut most) = (0, 0, 0);
            for (k, ray) in lines(point, 0.4 * pencils[0].tolerance, &triangles).enumerate() {
                let crossings = |pencils: &[Pencil]| {
                    let mut crossings = Vec::new();
                    mesh.crossings(pencils, &ray, f32::NEG_INFINITY, &mut crossings);
                    crossings.sort_unstable_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
                    crossings.iter().map(|crossing| crossing.distance_m.to_bits()).collect::<Vec<_>>()
                };
                assert_eq!(crossings(&pencils), crossings(&[]), "line {k} through {point}");
                for limit_m in [f32::INFINITY, 0.4, 0.9 * point.length()] {
                    let first = |pencils: &[Pencil]| {
                        let hit = mesh.first_hit(pencils, &ray, limit_m)?;
                        Some((hit.distance_m.to_bits(), hit.place.triangle))
                    };
                    assert_eq!(first(&pencils), first(&[]), "line {k} through {point}");
                    assert_eq!(mesh.occludes(&pencils, &ray, limit_m), mesh.occludes(&[], &ray, limit_m), "line {k}");
                }
                listed += usize::from(pencils[0].listed(&ray, 0.0, f32::INFINITY).is_some());
                (crossed, most) = (crossed + usize::from(!crossings(&[]).is_empty()), most.max(crossings(&[]).len()));
            }
            assert!(listed == 6000 && crossed > 4500 && most >= 6, "{listed} {crossed} {most}");
        }
    }

    #[test]
    fn lines_beside_the_point_are_not_its_own() {
        let mesh = Mesh::new(Triangles::loose(&sphere(16)));
        let point = Vec3A::new(0.0, -3.0, 0.5);
        let pencil = mesh.pencil(point).unwrap();
        let towards = Quat::from_rotation_x(0.1) * Vec3A::Y;
        for (beside, own) in [(0.0, true), (1e-6, true), (1e-4, false), (0.1, false)] {
            let ray = Ray { origin: point + beside * Vec3A::X, direction: towards };
            assert_eq!(pencil.listed(&ray, 0.0, 9.0).is_some(), own, "{beside}");
        }
    }

    #[test]
    fn there_is_none_from_within_from_too_near_or_where_all_leaves_overlap() {
        let mesh = Mesh::new(Triangles::loose(&sphere(16)));
        for near in [Vec3A::ZERO, Vec3A::new(0.0, 0.0, 0.9), Vec3A::new(0.0, 1.05, 0.0)] {
            assert!(mesh.pencil(near).is_none(), "{near}");
        }
        let sheet = |k: usize| [Vec3::NEG_X, Vec3::X, Vec3::Y].map(|corner| corner + Vec3::Z * (k as f32 * 1e-3));
        let sheets: Vec<_> = (0..1000).map(sheet).collect();
        assert!(Mesh::new(Triangles::loose(&sheets)).pencil(Vec3A::new(0.0, 0.0, 5.0)).is_none());
    }
}
