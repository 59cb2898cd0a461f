//! Indexed triangle meshes, as mesh files store them: vertices, triangles by index, and vertex attributes.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3, Vec2, Vec3};

use crate::vertex_normals::{VertexNormals, face_normal};

/// The attributes that hold the second texture coordinates of a mesh, which place it in a lightmap: (0, 0) is the upper
/// left corner of the image, (1, 1) the lower right.
pub const SECOND_UV: [&str; 2] = ["lightmap_u", "lightmap_v"];

/// An indexed triangle mesh in object space.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// The three vertices of each triangle, as indices into `positions`.
    pub indices: Vec<[u32; 3]>,
    /// Texture coordinates of each vertex; empty if the mesh has none.
    pub uv: Vec<Vec2>,
    /// Vertex normals; empty if faces are flat.
    pub normals: VertexNormals,
    /// Further scalar vertex attributes, by name.
    pub attributes: BTreeMap<String, Vec<f32>>,
}

/// A mesh scaled and moved to the origin, and the map back.
#[derive(Debug, Clone, PartialEq)]
pub struct CentredMesh {
    /// The mesh, with coordinates in [−1, 1].
    pub mesh: TriangleMesh,
    /// Maps its coordinates to the coordinates of the original mesh.
    pub to_original: DAffine3,
}

impl TriangleMesh {
    /// A mesh of separate triangles that share no vertices.
    #[expect(clippy::cast_possible_truncation, reason = "a mesh in memory has fewer than 2^32 vertices")]
    pub fn from_triangles(triangles: &[[Vec3; 3]]) -> Self {
        Self {
            positions: triangles.iter().flatten().copied().collect(),
            indices: (0..triangles.len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect(),
            ..Self::default()
        }
    }

    /// The corner positions of a triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.indices[triangle].map(|index| self.positions[index as usize])
    }

    /// The mesh with smooth vertex normals, computed if it has none.
    #[must_use]
    pub fn smooth(mut self) -> Self {
        if self.normals.is_empty() {
            self.normals = VertexNormals::smooth(&self.positions, &self.indices);
        }
        self
    }

    /// The mesh without vertex normals.
    #[must_use]
    pub fn flat(mut self) -> Self {
        self.normals = VertexNormals::default();
        self
    }

    /// The mesh with one vertex for each normal where several normals meet, as at creases and at the edges of flat
    /// faces, and the unit normal of each vertex. The normal is zero if only triangles without area have the vertex.
    ///
    /// # Panics
    ///
    /// When there are 2³² vertices.
    pub fn split_at_creases(mut self) -> (Self, Vec<Vec3>) {
        let mut normals: Vec<Option<Vec3>> = vec![None; self.positions.len()];
        let mut further: BTreeMap<(u32, [u32; 3]), u32> = BTreeMap::new();
        for triangle in 0..self.indices.len() {
            let vertices = self.indices[triangle];
            #[expect(clippy::cast_possible_truncation, reason = "a mesh in memory has fewer than 2^32 triangles")]
            let corners = self.normals.corners(triangle as u32, vertices);
            let corners = corners.unwrap_or_else(|| [face_normal(self.corners(triangle)); 3]);
            self.indices[triangle] = [0, 1, 2].map(|corner| {
                let (vertex, normal) = (vertices[corner], corners[corner]);
                let at = vertex as usize;
                if normal == Vec3::ZERO || *normals[at].get_or_insert(normal) == normal {
                    return vertex;
                }
                *further.entry((vertex, normal.to_array().map(f32::to_bits))).or_insert_with(|| {
                    self.positions.push(self.positions[at]);
                    normals.push(Some(normal));
                    self.uv.extend(self.uv.get(at).copied());
                    self.attributes.values_mut().for_each(|values| values.push(values[at]));
                    u32::try_from(normals.len() - 1).expect("a mesh in memory has fewer than 2^32 vertices")
                })
            });
        }
        self.normals = VertexNormals::default();
        (self, normals.into_iter().map(Option::unwrap_or_default).collect())
    }

    /// Appends another mesh, transformed by `map`. Texture coordinates and attributes are kept only where both meshes
    /// have them. If one of them has no vertex normals, its faces are flat.
    ///
    /// # Errors
    ///
    /// When there would be 2³² vertices or more.
    pub fn append(&mut self, other: &Self, map: &DAffine3) -> Result<(), String> {
        let too_many = |_| "the mesh has more than 4294967295 vertices".to_owned();
        u32::try_from(self.positions.len() + other.positions.len()).map_err(too_many)?;
        let base = u32::try_from(self.positions.len()).map_err(too_many)?;
        let first = self.indices.is_empty() && self.positions.is_empty();
        let triangles = u32::try_from(self.indices.len()).map_err(|_| "the mesh has more than 4294967295 triangles")?;
        let vertices = [self.positions.len(), other.positions.len()];
        self.normals.append(&other.normals, triangles, vertices, &map.matrix3);
        if first {
            (self.uv, self.attributes) = (other.uv.clone(), other.attributes.clone());
        } else {
            if self.uv.is_empty() || other.uv.is_empty() {
                self.uv.clear();
            } else {
                self.uv.extend(&other.uv);
            }
            self.attributes
                .retain(|name, values| other.attributes.get(name).inspect(|more| values.extend(more.iter())).is_some());
        }
        let mirrors = map.matrix3.determinant() < 0.0;
        let transformed = |position: &Vec3| map.transform_point3(position.as_dvec3()).as_vec3();
        self.positions.extend(other.positions.iter().map(transformed));
        self.indices.extend(other.indices.iter().map(|&[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|index| index + base);
            if mirrors { [a, c, b] } else { [a, b, c] }
        }));
        Ok(())
    }

    /// Moves the centre of the bounding box to the origin and scales the mesh to a half extent of at most 1.
    ///
    /// Single precision is finest near the origin, so that meshes surveyed in kilometres or modelled in micrometres
    /// are traced as precisely as any other. The scale is a power of two, which rounds nothing.
    #[must_use]
    pub fn centred(mut self) -> CentredMesh {
        let low = self.positions.iter().fold(Vec3::INFINITY, |low, position| low.min(*position)).as_dvec3();
        let high = self.positions.iter().fold(Vec3::NEG_INFINITY, |high, position| high.max(*position)).as_dvec3();
        let centre = (0.5 * (low + high)).as_vec3().as_dvec3();
        let half_extent = (0.5 * (high - low)).max_element();
        let unit = if half_extent > 0.0 { half_extent.log2().ceil().exp2() } else { 1.0 };
        for position in &mut self.positions {
            *position = ((position.as_dvec3() - centre) / unit).as_vec3();
        }
        let to_original = DAffine3::from_scale_rotation_translation(DVec3::splat(unit), glam::DQuat::IDENTITY, centre);
        CentredMesh { mesh: self, to_original }
    }
}

/// The triangles of a closed solid between two grids of vertices, the inner grid first, including the side walls. Seen
/// from outside, columns run to the right and rows up; all triangles face outwards.
pub fn closed_grids(width: u32, height: u32) -> Vec<[u32; 3]> {
    let inner = |column: u32, row: u32| row * width + column;
    let outer = |column: u32, row: u32| width * height + inner(column, row);
    let mut triangles = Vec::new();
    let mut quad = |a: u32, b: u32, c: u32, d: u32| triangles.extend([[a, b, c], [a, c, d]]);
    for row in 0..height - 1 {
        for column in 0..width - 1 {
            let (right, up) = (column + 1, row + 1);
            quad(outer(column, row), outer(right, row), outer(right, up), outer(column, up));
            quad(inner(column, row), inner(column, up), inner(right, up), inner(right, row));
        }
    }
    let (last, top) = (width - 1, height - 1);
    for column in 0..last {
        let right = column + 1;
        quad(inner(column, 0), inner(right, 0), outer(right, 0), outer(column, 0));
        quad(inner(column, top), outer(column, top), outer(right, top), inner(right, top));
    }
    for row in 0..top {
        let up = row + 1;
        quad(inner(0, row), outer(0, row), outer(0, up), inner(0, up));
        quad(inner(last, row), inner(last, up), outer(last, up), outer(last, row));
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centring_preserves_positions() {
        let corners = [Vec3::new(5000.1, -3.0, 0.25), Vec3::new(5003.7, -2.0, 0.5), Vec3::new(5001.0, 9.0, 0.75)];
        let centred = TriangleMesh::from_triangles(&[corners]).centred();
        for (position, corner) in centred.mesh.positions.iter().zip(corners) {
            assert!(position.abs().max_element() <= 1.0);
            assert_eq!(centred.to_original.transform_point3(position.as_dvec3()).as_vec3(), corner);
        }
    }

    #[test]
    fn append_drops_attributes_that_only_one_mesh_has() {
        let part = |uv: bool| TriangleMesh {
            uv: if uv { vec![Vec2::X; 3] } else { vec![] },
            normals: VertexNormals::new(if uv { vec![Vec3::Z; 3] } else { vec![] }),
            attributes: BTreeMap::from([("wetness".to_owned(), vec![0.5; 3])]),
            ..TriangleMesh::from_triangles(&[[Vec3::ZERO, Vec3::X, Vec3::Y]])
        };
        let mut both = part(true);
        both.append(&part(false), &DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0))).unwrap();
        assert!(both.uv.is_empty());
        let normal =
            |triangle: u32, of: &TriangleMesh| of.normals.at(triangle, of.indices[triangle as usize], [0.2, 0.3, 0.5]);
        assert_eq!([normal(0, &both), normal(1, &both)], [Some(Vec3::Z), None]);
        let mut flat_first = part(false);
        flat_first.append(&part(true), &DAffine3::IDENTITY).unwrap();
        assert_eq!([normal(0, &flat_first), normal(1, &flat_first)], [None, Some(Vec3::Z)]);
        assert_eq!(both.attributes["wetness"].len(), 6);
        assert_eq!(both.indices, [[0, 1, 2], [3, 5, 4]], "a mirrored part still faces outwards");
    }
}
