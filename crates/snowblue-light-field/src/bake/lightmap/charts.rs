//! Charts: connected parts of a surface that are laid flat without overlap.
//!
//! A chart grows from a facet across smooth edges, and is projected along the normal of that facet. No normal is
//! inclined to it by more than [`GREATEST_INCLINATION_DEG`], so that lengths shrink to 0.64 at the least. A facet that
//! would overlap the chart is left to another one.

use std::collections::VecDeque;

use glam::{DVec2, Vec3};
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::edges::visit_edges;
use snowblue_geometry::grouped::Grouped;
use snowblue_geometry::vertex_normals::face_normal;

use crate::bake::lightmap::quadtree::{Quadtree, bounds};
use crate::bake::surface_mesh::SurfaceMesh;
use crate::bake::vertices::is_smooth;

/// Greatest angle between the normal of a facet and the direction along which its chart is projected.
const GREATEST_INCLINATION_DEG: f32 = 50.0;
/// Facets after which a report is due.
const FACETS_PER_REPORT: usize = 1 << 12;

/// A part of a surface that is laid flat.
pub(super) struct Chart {
    /// Its facets, and where the corners of each lie, in m.
    pub(super) facets: Vec<(usize, [DVec2; 3])>,
    /// Sides of the rectangle about it, in m, the longer one first.
    pub(super) extent_m: DVec2,
}

/// The charts of a surface, which have each facet once. It reports how many facets have a chart.
pub(super) fn charts(mesh: &SurfaceMesh, report: &dyn Fn(usize)) -> Vec<Chart> {
    let corners = |vertices: [u32; 3]| vertices.map(|vertex| mesh.positions[vertex as usize]);
    // Facets of an ellipsoid have the normal of the face that they were divided from.
    let normals: Vec<Vec3> = mesh.facets.iter().map(|facet| face_normal(corners(facet.vertices))).collect();
    let neighbours = neighbours(mesh, &normals);
    let size_m = f64::from(Bounds::of(mesh.positions.iter().copied()).diagonal_m());
    // Charts begin at facets with area, whose normals direct them.
    let mut seeds: Vec<usize> = (0..mesh.facets.len()).collect();
    seeds.sort_by_key(|facet| normals[*facet] == Vec3::ZERO);
    let mut is_laid = vec![false; mesh.facets.len()];
    let (mut charts, mut done) = (Vec::new(), 0);
    for seed in seeds {
        if is_laid[seed] {
            continue;
        }
        let axis = normals[seed].try_normalize().unwrap_or(Vec3::Z);
        let plane = axis.as_dvec3().normalize().any_orthonormal_pair();
        let origin = corners(mesh.facets[seed].vertices)[0].as_dvec3();
        let flat = |corner: Vec3| {
            let from_origin = corner.as_dvec3() - origin;
            DVec2::new(plane.0.dot(from_origin), plane.1.dot(from_origin))
        };
        let is_near_axis = |facet: usize| {
            normals[facet] == Vec3::ZERO || normals[facet].dot(axis) >= GREATEST_INCLINATION_DEG.to_radians().cos()
        };
        let mut quadtree = Quadtree::around(size_m);
        let (mut facets, mut waiting) = (Vec::new(), VecDeque::from([seed]));
        while let Some(facet) = waiting.pop_front() {
            let triangle = corners(mesh.facets[facet].vertices).map(flat);
            if is_laid[facet] || quadtree.overlaps(&triangle) {
                continue;
            }
            quadtree.add(triangle);
            facets.push((facet, triangle));
            is_laid[facet] = true;
            done += 1;
            if done % FACETS_PER_REPORT == 0 {
                report(done);
            }
            let next = neighbours.group(facet).iter().map(|neighbour| *neighbour as usize);
            waiting.extend(next.filter(|neighbour| !is_laid[*neighbour] && is_near_axis(*neighbour)));
        }
        charts.push(Chart::of(facets));
    }
    charts
}

/// The neighbours of each facet across smooth edges that two facets share.
fn neighbours(mesh: &SurfaceMesh, normals: &[Vec3]) -> Grouped<u32> {
    let triangles: Vec<[u32; 3]> = mesh.facets.iter().map(|facet| facet.vertices).collect();
    let mut pairs = Vec::new();
    visit_edges(mesh.positions.len(), &triangles, |sides| {
        let [one, other] = sides else { return };
        let [normal, beside] = [one, other].map(|side| normals[side.triangle as usize]);
        if one.from != other.from && is_smooth(normal, beside) {
            pairs.extend([(one.triangle, other.triangle), (other.triangle, one.triangle)]);
        }
    });
    Grouped::new(triangles.len(), pairs.into_iter())
}

impl Chart {
    /// Turns facets into the lowest rectangle along or across an edge of the first one, whose lower corner is at 0.
    fn of(mut facets: Vec<(usize, [DVec2; 3])>) -> Self {
        let turned = |point: DVec2, along: DVec2| DVec2::new(along.dot(point), along.perp_dot(point));
        let around =
            |along: DVec2| bounds(facets.iter().flat_map(|(_, corners)| corners).map(|point| turned(*point, along)));
        let height = |along: &DVec2| {
            let (low, high) = around(*along);
            high.y - low.y
        };
        let [a, b, c] = facets[0].1;
        let directions = [b - a, c - b, a - c].into_iter().filter_map(DVec2::try_normalize);
        let lowest = directions
            .flat_map(|along| [along, along.perp()])
            .min_by(|one, other| height(one).total_cmp(&height(other)));
        let along = lowest.unwrap_or(DVec2::X);
        let (low, high) = around(along);
        facets.iter_mut().flat_map(|(_, corners)| corners).for_each(|point| *point = turned(*point, along) - low);
        Self { facets, extent_m: high - low }
    }
}
