//! Vertices with normals: one for each smooth part of the surface that meets there.
//!
//! The normal is the mean of the faces around the vertex, weighted by their angles (Thürmer & Wüthrich 1998, "Computing
//! vertex normals from polygonal facets", doi:10.1080/10867651.1998.10487487), of those that are inclined to each other
//! by less than the crease angle. At a sharper edge the faces have vertices of their own, as where they lie apart in a
//! lightmap.

use glam::{Vec2, Vec3, Vec3A};
use snowblue_geometry::grouped::Grouped;
use snowblue_geometry::vertex_normals::CREASE_DEG;

use crate::bake::surface_mesh::{Facet, SurfaceMesh};

/// How far a point of the surface is moved from a vertex on a sharp edge towards the middle of a face, as a fraction of
/// the distance. The field ends at edges, and rounding must not move the point beyond.
pub(super) const INSET: f32 = 0.02;

/// Vertices and triangles of a surface.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    /// In m.
    pub(super) positions: Vec<Vec3>,
    /// Outward unit normals.
    pub(super) normals: Vec<Vec3>,
    /// The points where the light is read, in m. They lie on the surface: a point inside convex snow would be in its
    /// own shadow. On a sharp edge it is beside the vertex, within the smooth part.
    pub(super) points: Vec<Vec3>,
    /// Places in a lightmap.
    pub(super) uv: Vec<Vec2>,
    /// Counter-clockwise from outside.
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Vertices {
    /// The vertices of a surface with normals.
    ///
    /// # Panics
    ///
    /// When there are 2³² vertices.
    pub(super) fn of(mesh: &SurfaceMesh) -> Self {
        // The facets around each vertex, with the corner of the facet that the vertex is.
        let corners = (0..).zip(&mesh.facets).flat_map(|(number, facet)| {
            let [a, b, c] = facet.vertices;
            [(a, (number, 0)), (b, (number, 1)), (c, (number, 2))]
        });
        let around: Grouped<(u32, u8)> = Grouped::new(mesh.positions.len(), corners);
        let mut vertices = Self { triangles: vec![[0; 3]; mesh.facets.len()], ..Self::default() };
        for vertex in 0..mesh.positions.len() {
            let first = vertices.positions.len();
            for &(facet, corner) in around.group(vertex) {
                let uv = mesh.facets[facet as usize].uv[corner as usize];
                let (normal, point) = smooth_part(mesh, vertex, &mesh.facets[facet as usize], around.group(vertex));
                let same = |known: &usize| vertices.normals[*known] == normal && vertices.uv[*known] == uv;
                let known = (first..vertices.normals.len()).find(same);
                let number = known.unwrap_or_else(|| {
                    vertices.positions.push(mesh.positions[vertex]);
                    vertices.normals.push(normal);
                    vertices.points.push(point);
                    vertices.uv.push(uv);
                    vertices.positions.len() - 1
                });
                let number = u32::try_from(number).expect("a mesh in memory has fewer than 2^32 vertices");
                vertices.triangles[facet as usize][corner as usize] = number;
            }
        }
        vertices
    }
}

/// The normal of the smooth part around a vertex that a facet belongs to, and a point of the surface within that part:
/// the vertex itself, or on a sharp edge a point of the facet in the middle of the part.
fn smooth_part(mesh: &SurfaceMesh, vertex: usize, facet: &Facet, around: &[(u32, u8)]) -> (Vec3, Vec3) {
    let position = mesh.positions[vertex];
    if let Some(ellipsoid) = &mesh.ellipsoid {
        return (ellipsoid.project(Vec3A::from(position)).normal.into(), position);
    }
    let (mut sum, mut middles) = (Vec3::ZERO, Vec::with_capacity(around.len()));
    for &(other, corner) in around {
        let other = &mesh.facets[other as usize];
        if is_smooth(facet.normal, other.normal) {
            let [a, b] = [1, 2].map(|step| mesh.positions[other.vertices[(corner as usize + step) % 3] as usize]);
            sum += other.normal * (a - position).angle_between(b - position).max(0.0);
            middles.push((a + b + position) / 3.0);
        }
    }
    let normal = sum.try_normalize().or(facet.normal.try_normalize()).unwrap_or(Vec3::Z);
    if middles.len() == around.len() {
        return (normal, position);
    }
    let middle = middles.iter().sum::<Vec3>() / middles.len() as f32;
    let by_distance =
        |one: &Vec3, other: &Vec3| one.distance_squared(middle).total_cmp(&other.distance_squared(middle));
    let nearest = middles.into_iter().min_by(by_distance).unwrap_or(position);
    (normal, position + (nearest - position) * INSET)
}

/// Whether the surface is smooth between two facets with some normals. A facet without area, whose normal is zero, is
/// smooth to all.
pub(super) fn is_smooth(one: Vec3, other: Vec3) -> bool {
    one == Vec3::ZERO || other == Vec3::ZERO || one.dot(other) > CREASE_DEG.to_radians().cos()
}
