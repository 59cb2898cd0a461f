//! Meshes with a rough surface: triangles are split where a viewer needs it, and each vertex moves along its normal by
//! the height of the roughness at its place.
//!
//! All that is done to a vertex depends on its place, so that a closed mesh stays closed, also where each side of an
//! edge has vertices of its own. The normals for shading bend with the surface: those of the smooth mesh, plus the
//! change of the mean normal of the triangles around the vertex.

use std::collections::BTreeMap;

use glam::Vec3;
use rayon::prelude::*;
use snowblue_geometry::coincident::merged;
use snowblue_geometry::ray::narrow;
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_geometry::vertex_normals::VertexNormals;

use crate::refinement::{Refined, refine};
use crate::roughness::Roughness;

/// How far vertices move.
pub struct Displacement<'a> {
    /// The heights.
    pub roughness: &'a Roughness,
    /// Greatest length of the edges around a place, in m.
    pub edge_m: &'a (dyn Fn(Vec3) -> f32 + Sync),
    /// How much that length grows at most for each metre.
    pub edge_growth: f32,
    /// How far a place may move by a vector, in parts of it.
    pub room: &'a (dyn Fn(Vec3, Vec3) -> f32 + Sync),
}

impl Displacement<'_> {
    /// The rough mesh of a mesh in m, of at most `most` triangles; none if more are needed.
    pub fn of(&self, mesh: TriangleMesh, most: usize) -> Option<TriangleMesh> {
        let (mut mesh, mut normals) = mesh.split_at_creases();
        let too_long_m = narrow(self.roughness.greatest_edge_m());
        let is_long = |[from, to]: [Vec3; 2], [from_m, to_m]: [f32; 2]| {
            let length_m = from.distance(to);
            // At least the length that is asked for anywhere on the edge.
            let least_m = (0.5 * (from_m + to_m - self.edge_growth * length_m)).max(0.0);
            length_m > least_m && least_m < too_long_m
        };
        let Refined { ends, values: edges_m } = refine(&mut mesh, most, self.edge_m, is_long)?;
        for [from, to] in ends {
            normals.push((normals[from as usize] + normals[to as usize]).normalize_or_zero());
        }
        let places = merged(&mesh.positions);
        let mut directions = vec![Vec3::ZERO; places.len()];
        places.iter().zip(&normals).for_each(|(place, normal)| directions[*place as usize] += *normal);
        let moved = |(at, place): (usize, &u32)| {
            if at != *place as usize {
                return Vec3::ZERO;
            }
            let (position, direction) = (mesh.positions[at], directions[at].normalize_or_zero());
            let height_m = self.roughness.height_m(position.as_dvec3(), edges_m[at].into());
            let offset = direction * narrow(height_m);
            if offset == Vec3::ZERO { offset } else { offset * (self.room)(position, offset) }
        };
        let moved: Vec<Vec3> = places.par_iter().enumerate().map(moved).collect();
        let groups = groups(&places, &normals);
        let before = mean_normals(&mesh, &groups);
        for (position, place) in mesh.positions.iter_mut().zip(&places) {
            *position += moved[*place as usize];
        }
        let after = mean_normals(&mesh, &groups);
        let bent = normals.par_iter().zip(&groups).map(|(normal, group)| {
            let (before, after) = (before[*group as usize], after[*group as usize]);
            (*normal + after - before).try_normalize().unwrap_or(after)
        });
        mesh.normals = VertexNormals::new(bent.collect::<Vec<_>>());
        Some(mesh)
    }
}

/// For each vertex, the first one at its place with its normal.
fn groups(places: &[u32], normals: &[Vec3]) -> Vec<u32> {
    let mut further = BTreeMap::new();
    let group = |(at, place): (u32, &u32)| {
        let normal = normals[at as usize];
        if at == *place || normals[*place as usize] == normal {
            return *place;
        }
        *further.entry((*place, normal.to_array().map(f32::to_bits))).or_insert(at)
    };
    (0..).zip(places).map(group).collect()
}

/// The mean normals of the triangles around groups of vertices, weighted with their areas.
fn mean_normals(mesh: &TriangleMesh, groups: &[u32]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; groups.len()];
    for vertices in &mesh.indices {
        let [a, b, c] = vertices.map(|at| mesh.positions[at as usize]);
        let area = (b - a).cross(c - a);
        vertices.iter().for_each(|at| sums[groups[*at as usize] as usize] += area);
    }
    sums.par_iter_mut().for_each(|sum| *sum = sum.normalize_or_zero());
    sums
}
