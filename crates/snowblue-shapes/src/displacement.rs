//! Meshes with a rough surface: triangles are split where a viewer needs it, and each vertex moves along its normal by
//! the height of the roughness at its place.
//!
//! The displacement of a vertex depends on its place only, so that a closed mesh stays closed, even where each side of
//! an edge has vertices of its own. The shading normals bend with the surface: each is the normal of the smooth mesh
//! plus the change of the mean normal of the triangles around the vertex.

use std::collections::BTreeMap;

use glam::Vec3;
use rayon::prelude::*;
use snowblue_base::narrow;
use snowblue_geometry::coincident::merged;
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_geometry::vertex_normals::VertexNormals;

use crate::refinement::{Refined, refine};
use crate::roughness::Roughness;

/// Displacement of the vertices of a mesh.
pub struct Displacement<'a> {
    /// The heights.
    pub roughness: &'a Roughness,
    /// Greatest length of the edges around a place, in m.
    pub edge_m: &'a (dyn Fn(Vec3) -> f32 + Sync),
    /// Greatest growth of this length per metre of distance.
    pub edge_growth: f32,
    /// Fraction of a displacement vector by which a place may move. At a crease the fraction is computed for each
    /// normal, and the least displacement counts.
    pub room: &'a (dyn Fn(Vec3, Vec3) -> f32 + Sync),
}

impl Displacement<'_> {
    /// The rough mesh of a mesh in m, of at most `most` triangles; none if more are needed.
    pub fn of(&self, mesh: TriangleMesh, most: usize) -> Option<TriangleMesh> {
        let (mut mesh, mut normals) = mesh.split_at_creases();
        let too_long_m = narrow(self.roughness.greatest_edge_m());
        let is_long = |[from, to]: [Vec3; 2], [from_m, to_m]: [f32; 2]| {
            let length_m = from.distance(to);
            // Lower bound of the allowed length anywhere on the edge.
            let least_m = (0.5 * (from_m + to_m - self.edge_growth * length_m)).max(0.0);
            length_m > least_m && least_m < too_long_m
        };
        let Refined { ends, values: edges_m } = refine(&mut mesh, most, self.edge_m, is_long)?;
        for [from, to] in ends {
            normals.push((normals[from as usize] + normals[to as usize]).normalize_or_zero());
        }
        let places = merged(&mesh.positions, &mesh.indices);
        let mut directions = vec![Vec3::ZERO; places.len()];
        places.iter().zip(&normals).for_each(|(place, normal)| directions[*place as usize] += *normal);
        let height_m = |at: usize| -> f32 {
            let height_m = narrow(self.roughness.height_m(mesh.positions[at].as_dvec3(), edges_m[at].into()));
            let offset = normals[at] * height_m;
            // A vertex without a normal has no direction, and other vertices at its place decide.
            if offset == Vec3::ZERO { height_m } else { height_m * (self.room)(mesh.positions[at], offset) }
        };
        let mut heights_m: Vec<f32> = (0..places.len()).into_par_iter().map(height_m).collect();
        for (at, place) in places.iter().enumerate() {
            if heights_m[at].abs() < heights_m[*place as usize].abs() {
                heights_m[*place as usize] = heights_m[at];
            }
        }
        let moved = directions.par_iter().zip(heights_m).map(|(sum, height_m)| sum.normalize_or_zero() * height_m);
        let moved: Vec<Vec3> = moved.collect();
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

/// For each vertex, the first vertex with the same place and the same normal.
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

#[cfg(test)]
mod tests {
    use glam::{Mat3A, Vec3A};

    use super::*;
    use crate::roughness::RoughnessStatistics;
    use snowblue_geometry::cuboid::Cuboid;
    use snowblue_geometry::topology::{Topology, volume};

    fn roughness() -> Roughness {
        Roughness::new(&RoughnessStatistics { height_m: 0.01, correlation_m: 0.1, hurst: 0.6 }, 3)
    }

    /// The unit cube with separate triangles.
    fn cube() -> TriangleMesh {
        let joined = Cuboid::new(Vec3A::splat(0.5), Vec3A::ONE, Mat3A::IDENTITY).triangles();
        let triangles: Vec<_> = (0..joined.indices.len()).map(|triangle| joined.corners(triangle)).collect();
        TriangleMesh::from_triangles(&triangles)
    }

    /// Edges that are short near a corner of the cube.
    fn near_corner(place: Vec3) -> f32 {
        (0.1 * place.distance(Vec3::ONE)).max(0.01)
    }

    fn rough(edge_m: &(dyn Fn(Vec3) -> f32 + Sync), room: &(dyn Fn(Vec3, Vec3) -> f32 + Sync)) -> TriangleMesh {
        let displacement = Displacement { roughness: &roughness(), edge_m, edge_growth: 0.1, room };
        displacement.of(cube(), 1_000_000).unwrap()
    }

    #[test]
    fn a_closed_mesh_stays_closed_and_edges_are_as_short_as_asked() {
        let mesh = rough(&near_corner, &|_, _| 1.0);
        let topology = Topology::of(&mesh);
        assert!(topology.is_closed() && topology.reversed_edges + topology.degenerate_triangles == 0, "{topology:?}");
        // Heights of 1 % of the side, which are independent beyond a tenth of the side, leave the volume nearly
        // unchanged.
        assert!((volume(&mesh) - 1.0).abs() < 0.01, "{}", volume(&mesh));
        let smooth = rough(&near_corner, &|_, _| 0.0);
        assert!((volume(&smooth) - 1.0).abs() < 1e-5);
        for triangle in 0..smooth.indices.len() {
            let [a, b, c] = smooth.corners(triangle);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let asked_m = 0.5 * (near_corner(from) + near_corner(to));
                assert!(from.distance(to) <= 1.001 * asked_m, "{from} {to}");
            }
        }
    }

    /// The heights of the upper side equal the heights of the field at the original places of its vertices.
    #[test]
    fn vertices_move_along_the_normal_by_the_height_at_their_place() {
        let roughness = roughness();
        let mesh = rough(&near_corner, &|_, _| 1.0);
        let inner = mesh.positions.iter().filter(|at| (0.9..1.1).contains(&at.z) && at.truncate().max_element() < 0.9);
        let mut count = 0;
        for position in inner.filter(|at| at.truncate().min_element() > 0.1) {
            let place = position.with_z(1.0);
            let height_m = roughness.height_m(place.as_dvec3(), near_corner(place).into());
            assert!((f64::from(position.z) - 1.0 - height_m).abs() < 1e-6, "{position}");
            count += 1;
        }
        assert!(count > 500, "{count}");
    }

    /// Where edges are as short as the heights need, shorter edges do not change any height.
    #[test]
    fn finer_triangles_keep_the_heights_of_coarser_ones() {
        // Octaves down to a 200th of the side.
        let roughness = Roughness::new(&RoughnessStatistics { height_m: 3e-4, correlation_m: 4e-3, hurst: 0.5 }, 3);
        let least_m = narrow(roughness.least_edge_m());
        let mut small = cube();
        small.positions.iter_mut().for_each(|position| *position *= 0.02);
        let heights = [least_m, 0.5 * least_m].map(|edge_m| {
            let displacement =
                Displacement { roughness: &roughness, edge_m: &|_| edge_m, edge_growth: 0.1, room: &|_, _| 1.0 };
            let mesh = displacement.of(small.clone(), 1_000_000).unwrap();
            let upper =
                mesh.positions.iter().filter(|at| at.z > 0.018 && at.x.min(at.y) > 2e-3 && at.x.max(at.y) < 0.018);
            let heights = upper.map(|at| ([at.x, at.y].map(f32::to_bits), at.z.to_bits()));
            heights.collect::<BTreeMap<_, _>>()
        });
        let [coarse, fine] = &heights;
        let both: Vec<_> = coarse.iter().filter_map(|(place, height)| Some((*height, *fine.get(place)?))).collect();
        assert!(both.len() > 500 && 2 * coarse.len() < fine.len(), "{} {} {}", both.len(), coarse.len(), fine.len());
        assert!(both.iter().all(|(coarse, fine)| coarse == fine));
    }

    /// The bent normals of a fine mesh are close to the normals of its triangles. Without displacement, smooth normals
    /// stay.
    #[test]
    fn normals_bend_with_the_surface_and_creases_stay() {
        let mesh = rough(&|_| 0.012, &|_, _| 1.0);
        let (mut sum, mut count) = (0.0, 0);
        for (triangle, vertices) in (0..).zip(&mesh.indices) {
            let face = snowblue_geometry::vertex_normals::face_normal(vertices.map(|at| mesh.positions[at as usize]));
            let bent = mesh.normals.at(triangle, *vertices, [1.0 / 3.0; 3]).unwrap();
            sum += bent.angle_between(face).to_degrees();
            count += 1;
        }
        let mean_deg = sum / count as f32;
        assert!(mean_deg < 8.0, "{mean_deg}");
        let flat = rough(&|_| 0.05, &|_, _| 0.0);
        for (triangle, vertices) in (0..).zip(&flat.indices) {
            let normal = flat.normals.at(triangle, *vertices, [0.2, 0.3, 0.5]).unwrap();
            assert!((normal.abs().max_element() - 1.0).abs() < 1e-4, "{normal}");
        }
    }

    #[test]
    fn too_many_triangles_are_refused() {
        let displacement =
            Displacement { roughness: &roughness(), edge_m: &|_| 0.01, edge_growth: 0.1, room: &|_, _| 1.0 };
        assert!(displacement.of(cube(), 1000).is_none());
    }
}
