//! Vertex normals of a mesh, for smooth shading (Phong 1975, doi:10.1145/360825.360839).
//!
//! A mesh file gives the normals, or they are computed: the normal of a triangle's corner is the mean of the normals
//! of the triangles around the vertex, each weighted with its angle there (Thürmer & Wüthrich 1998, *Computing vertex
//! normals from polygonal facets*, doi:10.1080/10867651.1998.10487487). The mean then does not depend on how a flat
//! face is divided into triangles. Only triangles count whose normal is within [`CREASE_DEG`] of the normal of the
//! corner's own triangle, so that the edges of cubes and crystals stay sharp. Triangles of opposite orientation do
//! not count either.
//!
//! Where all corners at a vertex have equal normals, as nearly everywhere on a scanned surface, the vertex has one
//! normal. Only triangles at creases have normals of their own, and only if they differ from the normal of the face.

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

use crate::coincident::merged;
use crate::edges::Grouped;

/// Greatest angle between the normals of two triangles that are shaded as one smooth surface, in degrees.
pub const CREASE_DEG: f32 = 40.0;
/// Greatest number of triangles around a vertex with creases. Around vertices with more triangles, as at the tip of a
/// cone of very many sides, faces stay flat. The bound limits the time, which is quadratic in this number.
const MAX_AT_CREASE: usize = 256;
/// A corner normal counts as the normal of the face if the cosine between the two is at least this value.
const FLAT_COS: f32 = 1.0 - 1e-6;

/// Unit normals at the vertices of a mesh. Without any, all faces are flat.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VertexNormals {
    /// Normal of each vertex; zero where there is no normal or more than one normal.
    normals: Vec<Vec3>,
    /// Normals of triangles at creases, in the order of the triangle indices.
    at_creases: Vec<CreaseTriangle>,
}

/// The normals of a triangle at a crease.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CreaseTriangle {
    triangle: u32,
    corner_normals: [Vec3; 3],
}

impl VertexNormals {
    /// One normal for each vertex, of any length. A vertex whose normal is zero or not finite has none, and triangles
    /// with such a vertex are flat.
    pub fn new(normals: impl IntoIterator<Item = Vec3>) -> Self {
        let mut normals: Vec<Vec3> = normals.into_iter().map(Vec3::normalize_or_zero).collect();
        if normals.iter().all(|normal| *normal == Vec3::ZERO) {
            normals.clear();
        }
        Self { normals, at_creases: Vec::new() }
    }

    /// The normals of a mesh from the angles and normals of its triangles. Coincident vertices count as one vertex.
    /// Triangles without area do not contribute.
    pub fn smooth(positions: &[Vec3], indices: &[[u32; 3]]) -> Self {
        let surface = Surface::new(positions, indices);
        let mut normals = surface.normals();
        let creases = surface.corners_at_creases(&normals);
        let at_crease = |triangle: usize| surface.at_crease(triangle, &normals, &creases);
        let at_creases: Vec<_> = (0..indices.len()).into_par_iter().filter_map(at_crease).collect();
        if at_creases.is_empty() && normals.iter().all(|normal| *normal == Vec3::ZERO) {
            normals.clear();
        }
        for at in 0..normals.len() {
            normals[at] = normals[surface.vertices[at] as usize];
        }
        Self { normals, at_creases }
    }

    /// Whether there are none, so that all faces are flat.
    pub fn is_empty(&self) -> bool {
        self.normals.is_empty()
    }

    /// The interpolated unit normal of a triangle at some barycentric weights; none where it equals the normal of the
    /// face.
    ///
    /// `vertices` are the triangle's vertices.
    pub fn at(&self, triangle: u32, vertices: [u32; 3], weights: [f32; 3]) -> Option<Vec3> {
        let corners = self.corners(triangle, vertices)?;
        let sum: Vec3 = corners.into_iter().zip(weights).map(|(normal, weight)| normal * weight).sum();
        sum.try_normalize()
    }

    /// The unit normals at the corners of a triangle; none where they equal the normal of the face.
    pub(crate) fn corners(&self, triangle: u32, vertices: [u32; 3]) -> Option<[Vec3; 3]> {
        if self.is_empty() {
            return None;
        }
        let corners = vertices.map(|at| self.normals[at as usize]);
        if !corners.contains(&Vec3::ZERO) {
            return Some(corners);
        }
        let found = self.at_creases.binary_search_by_key(&triangle, |crease| crease.triangle).ok()?;
        Some(self.at_creases[found].corner_normals)
    }

    /// Appends the normals of another mesh, transformed by `map`, which also turns mirrored triangles around.
    /// `triangles` is the number of triangles so far, and `vertices` are the numbers of vertices of both meshes.
    /// Vertices of a mesh without normals have none.
    pub(crate) fn append(&mut self, other: &Self, triangles: u32, vertices: [usize; 2], map: &DMat3) {
        if self.is_empty() && other.is_empty() {
            return;
        }
        let (normal_map, mirrors) = (map.inverse().transpose(), map.determinant() < 0.0);
        let transformed = |normal: Vec3| (normal_map * normal.as_dvec3()).normalize_or_zero().as_vec3();
        self.normals.resize(vertices[0], Vec3::ZERO);
        self.normals.extend(other.normals.iter().copied().map(transformed));
        self.normals.resize(vertices[0] + vertices[1], Vec3::ZERO);
        self.at_creases.extend(other.at_creases.iter().map(|crease| {
            let [a, b, c] = crease.corner_normals.map(transformed);
            let corner_normals = if mirrors { [a, c, b] } else { [a, b, c] };
            CreaseTriangle { triangle: crease.triangle + triangles, corner_normals }
        }));
    }
}

/// Triangles with their normals and angles. Normals are kept at the first vertex of each position.
struct Surface<'a> {
    indices: &'a [[u32; 3]],
    /// For each vertex the first vertex at its position, which represents all vertices there.
    vertices: Vec<u32>,
    faces: Vec<Face>,
}

/// A triangle.
#[derive(Clone, Copy)]
struct Face {
    /// Unit normal; zero if it has no area.
    normal: Vec3,
    /// The angle at each corner, in radians.
    angles: [f32; 3],
}

impl<'a> Surface<'a> {
    fn new(positions: &[Vec3], indices: &'a [[u32; 3]]) -> Self {
        let face = |triangle: &[u32; 3]| Face::new(triangle.map(|at| positions[at as usize]));
        Self { indices, vertices: merged(positions, indices), faces: indices.par_iter().map(face).collect() }
    }

    /// The first vertices at the corners of a triangle.
    fn corners(&self, triangle: usize) -> [usize; 3] {
        self.indices[triangle].map(|at| self.vertices[at as usize] as usize)
    }

    /// The normal of each vertex around which no two triangles make a crease; zero for all other vertices.
    fn normals(&self) -> Vec<Vec3> {
        let mut means = vec![Vec3::ZERO; self.vertices.len()];
        for (triangle, face) in self.faces.iter().enumerate() {
            for (at, angle) in self.corners(triangle).into_iter().zip(face.angles) {
                means[at] += face.normal * angle;
            }
        }
        means.par_iter_mut().for_each(|mean| *mean = mean.normalize_or_zero());
        // If the normals of all triangles are within half the angle of the mean, any two normals are within the whole
        // angle.
        let smooth_cos = (0.5 * CREASE_DEG).to_radians().cos();
        let mut is_smooth = vec![true; means.len()];
        for (triangle, face) in self.faces.iter().enumerate().filter(|(_, face)| face.has_area()) {
            for at in self.corners(triangle) {
                is_smooth[at] &= face.normal.dot(means[at]) > smooth_cos;
            }
        }
        means.into_iter().zip(is_smooth).map(|(mean, is_smooth)| if is_smooth { mean } else { Vec3::ZERO }).collect()
    }

    /// The corners of triangles with area at vertices without a normal, as pairs of a triangle and a number below 3.
    #[expect(clippy::cast_possible_truncation, reason = "vertex and triangle indices have 32 bits")]
    fn corners_at_creases(&self, normals: &[Vec3]) -> Grouped<(u32, u8)> {
        let with_area = (0..self.indices.len()).filter(|triangle| self.faces[*triangle].has_area());
        let all = with_area.flat_map(|triangle| {
            let [a, b, c] = self.corners(triangle);
            [(a, 0), (b, 1), (c, 2)].map(|(at, corner)| (at as u32, (triangle as u32, corner)))
        });
        Grouped::new(normals.len(), all.filter(|(at, _)| normals[*at as usize] == Vec3::ZERO))
    }

    /// The normals of a triangle if one of its vertices has no normal and the triangle is not flat.
    #[expect(clippy::cast_possible_truncation, reason = "a mesh in memory has fewer than 2^32 triangles")]
    fn at_crease(&self, triangle: usize, normals: &[Vec3], creases: &Grouped<(u32, u8)>) -> Option<CreaseTriangle> {
        let (face, corners) = (self.faces[triangle], self.corners(triangle));
        if !face.has_area() || corners.iter().all(|at| normals[*at] != Vec3::ZERO) {
            return None;
        }
        let corner_normals = corners.map(|at| match normals[at] {
            Vec3::ZERO => self.corner_normal(creases.group(at), face.normal),
            vertex_normal => vertex_normal,
        });
        let is_flat = corner_normals.iter().all(|normal| normal.dot(face.normal) >= FLAT_COS);
        (!is_flat).then_some(CreaseTriangle { triangle: triangle as u32, corner_normals })
    }

    /// The normal of a triangle's corner among all corners at its vertex, by the normal of the triangle.
    fn corner_normal(&self, corners: &[(u32, u8)], normal: Vec3) -> Vec3 {
        if corners.len() > MAX_AT_CREASE {
            return normal;
        }
        let crease_cos = CREASE_DEG.to_radians().cos();
        let faces = corners.iter().map(|(triangle, corner)| (self.faces[*triangle as usize], usize::from(*corner)));
        let smooth = faces.filter(|(face, _)| face.normal.dot(normal) > crease_cos);
        let sum: Vec3 = smooth.map(|(face, corner)| face.normal * face.angles[corner]).sum();
        sum.try_normalize().unwrap_or(normal)
    }
}

impl Face {
    fn new(corners: [Vec3; 3]) -> Self {
        let normal = face_normal(corners);
        let [a, b, c] = corners;
        let [ab, bc, ca] = [b - a, c - b, a - c].map(Vec3::normalize_or_zero);
        let angle = |from: Vec3, to: Vec3| (-from.dot(to)).clamp(-1.0, 1.0).acos();
        Self { normal, angles: [angle(ca, ab), angle(ab, bc), angle(bc, ca)] }
    }

    fn has_area(&self) -> bool {
        self.normal != Vec3::ZERO
    }
}

/// The unit normal of a triangle by the order of its corners; zero if it has no area.
pub fn face_normal(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::ZERO).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn corners(triangles: &[[Vec3; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let positions: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        let indices = (0..).zip(triangles).map(|(k, _)| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        (positions, indices)
    }

    /// A torus of radii 1 and 0.4 about z, of `steps`² squares, with the true normals of its vertices.
    fn torus(steps: u32) -> (Vec<Vec3>, Vec<Vec3>, Vec<[u32; 3]>) {
        let (mut positions, mut normals, mut indices) = (Vec::new(), Vec::new(), Vec::new());
        for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
            let [(sin_u, cos_u), (sin_v, cos_v)] = [i, j].map(|k| (TAU * f64::from(k) / f64::from(steps)).sin_cos());
            let normal = DVec3::new(cos_v * cos_u, cos_v * sin_u, sin_v);
            normals.push(normal.as_vec3());
            positions.push((DVec3::new(cos_u, sin_u, 0.0) + 0.4 * normal).as_vec3());
            let at = |i: u32, j: u32| (i % steps) * steps + j % steps;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            indices.extend([[a, b, c], [a, c, d]]);
        }
        (positions, normals, indices)
    }

    /// Greatest angle between the interpolated normal and the true normal over some points of a torus, in degrees.
    fn greatest_error_deg(normals: &VertexNormals, true_normals: &[Vec3], indices: &[[u32; 3]]) -> f32 {
        let mut greatest: f32 = 0.0;
        for (triangle, vertices) in (0..).zip(indices) {
            for weights in [[1.0, 0.0, 0.0], [0.2, 0.3, 0.5], [0.1, 0.8, 0.1], [0.0, 0.5, 0.5]] {
                let found = normals.at(triangle, *vertices, weights).unwrap();
                assert!((found.length() - 1.0).abs() < 1e-5);
                let known: Vec3 =
                    vertices.iter().zip(weights).map(|(at, weight)| true_normals[*at as usize] * weight).sum();
                greatest = greatest.max(found.angle_between(known).to_degrees());
            }
        }
        greatest
    }

    #[test]
    fn normals_of_a_torus_are_within_a_degree() {
        let (positions, true_normals, indices) = torus(48);
        let normals = VertexNormals::smooth(&positions, &indices);
        assert!(normals.at_creases.is_empty(), "no crease, no further memory");
        let error_deg = greatest_error_deg(&normals, &true_normals, &indices);
        assert!(error_deg < 1.0, "{error_deg}");
        // The flat faces are several degrees off.
        let faces = indices.iter().map(|vertices| face_normal(vertices.map(|at| positions[at as usize])));
        let flat = faces.zip(&indices).map(|(face, at)| face.angle_between(true_normals[at[1] as usize]).to_degrees());
        assert!(flat.fold(0.0, f32::max) > 3.0);
    }

    #[test]
    fn seams_do_not_show() {
        let (positions, true_normals, indices) = torus(48);
        let triangles: Vec<_> = indices.iter().map(|vertices| vertices.map(|at| positions[at as usize])).collect();
        let apart = corners(&triangles);
        let normals = VertexNormals::smooth(&apart.0, &apart.1);
        let corner_normals: Vec<Vec3> = indices.iter().flatten().map(|at| true_normals[*at as usize]).collect();
        assert!(greatest_error_deg(&normals, &corner_normals, &apart.1) < 1.0);
    }

    /// The sides of a cube, each two triangles or four.
    fn cube() -> Vec<[Vec3; 3]> {
        let corner = |bits: usize| Vec3::from_array([1, 2, 4].map(|bit| if bits & bit == 0 { 0.0 } else { 1.0 }));
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|bits| bits.map(corner)).collect()
    }

    /// Two triangles on each segment of a line in the plane of x and z, from y = 0 to 1.
    fn faces(strip: &[Vec3]) -> Vec<[Vec3; 3]> {
        let face = |pair: &[Vec3]| {
            let (a, b) = (pair[0], pair[1]);
            [[a, b, b + Vec3::Y], [a, b + Vec3::Y, a + Vec3::Y]]
        };
        strip.windows(2).flat_map(face).collect()
    }

    #[test]
    fn a_cube_stays_sharp_and_bends_of_30_degrees_are_smooth() {
        let (positions, indices) = corners(&cube());
        assert!(VertexNormals::smooth(&positions, &indices).is_empty());
        // Three faces, each turned by 30° from the previous face.
        let along = [0.0f32, 30.0, 60.0].map(|deg| Vec3::new(deg.to_radians().cos(), 0.0, -deg.to_radians().sin()));
        let strip: Vec<Vec3> = (0..4).map(|k| along[..k].iter().sum()).collect();
        let (positions, indices) = corners(&faces(&strip));
        let normals = VertexNormals::smooth(&positions, &indices);
        let tilt_deg = |triangle: u32, weights| {
            let normal = normals.at(triangle, indices[triangle as usize], weights).unwrap();
            normal.x.atan2(normal.z).to_degrees()
        };
        assert!(tilt_deg(0, [1.0, 0.0, 0.0]).abs() < 0.01 && (tilt_deg(0, [0.0, 1.0, 0.0]) - 15.0).abs() < 0.01);
        let (start, end) = (tilt_deg(4, [1.0, 0.0, 0.0]), tilt_deg(4, [0.0, 1.0, 0.0]));
        assert!((start - 45.0).abs() < 0.01 && (end - 60.0).abs() < 0.01);
    }

    #[test]
    fn each_corner_at_a_crease_has_the_normal_of_its_side() {
        // A roof that turns by 97° at its ridge and by 16° on one side.
        let strip = [[-1.0, -1.0], [0.0, 0.0], [0.7, -0.9], [1.1, -1.9]].map(|[x, z]| Vec3::new(x, 0.0, z));
        let (positions, indices) = corners(&faces(&strip));
        let normals = VertexNormals::smooth(&positions, &indices);
        assert_eq!(normals.at(0, indices[0], [0.0, 0.5, 0.5]), None, "flat up to the ridge");
        let [first, second] = [2, 4].map(|k| face_normal(indices[k].map(|at| positions[at as usize])));
        let at_ridge = normals.at(2, indices[2], [1.0, 0.0, 0.0]).unwrap();
        let at_bend = normals.at(2, indices[2], [0.0, 1.0, 0.0]).unwrap();
        assert!(at_ridge.abs_diff_eq(first, 1e-6) && at_bend.abs_diff_eq((first + second).normalize(), 1e-5));
    }

    #[test]
    fn triangles_without_area_and_bad_normals_of_files_have_no_part() {
        let (mut positions, true_normals, mut indices) = torus(48);
        positions.extend([Vec3::splat(7.0); 2]);
        let (sound, lonely) = (indices.len(), 48 * 48);
        indices.extend([[0, 0, 1], [5, 5, 5], [lonely, lonely + 1, lonely], [2, 1, 2]]);
        let normals = VertexNormals::smooth(&positions, &indices);
        assert!(greatest_error_deg(&normals, &true_normals, &indices[..sound]) < 1.0);
        assert!(normals.normals.iter().all(|normal| normal.is_finite()));
        assert_eq!(normals.at(0, indices[sound + 2], [0.2, 0.3, 0.5]), None);
        let given = VertexNormals::new([Vec3::Z * 3.0, Vec3::NAN, Vec3::ZERO, Vec3::X, Vec3::Z]);
        assert_eq!(given.at(0, [0, 4, 0], [0.2, 0.3, 0.5]), Some(Vec3::Z));
        assert_eq!(given.at(0, [0, 1, 3], [0.2, 0.3, 0.5]), None);
        assert_eq!(given.at(0, [0, 3, 2], [0.2, 0.3, 0.5]), None);
    }

    #[test]
    fn the_tip_of_a_cone_of_very_many_sides_stays_flat() {
        let count = 2000;
        let rim = |k: u32| {
            let (sin, cos) = (TAU * f64::from(k % count) / f64::from(count)).sin_cos();
            DVec3::new(cos, sin, 0.0).as_vec3()
        };
        let sides: Vec<_> = (0..count).map(|k| [Vec3::Z, rim(k), rim(k + 1)]).collect();
        let (positions, indices) = corners(&sides);
        let normals = VertexNormals::smooth(&positions, &indices);
        let at = |weights| normals.at(7, indices[7], weights).unwrap_or(face_normal(sides[7]));
        assert!(at([1.0, 0.0, 0.0]).abs_diff_eq(face_normal(sides[7]), 1e-6));
        assert!(at([0.2, 0.4, 0.4]).is_finite());
    }

    #[test]
    fn appended_normals_are_those_of_the_whole() {
        let (positions, indices) = corners(&cube().into_iter().take(2).collect::<Vec<_>>());
        let bent = positions.iter().map(|place| *place + Vec3::Z * 0.2 * place.x * place.y).collect::<Vec<_>>();
        let part = VertexNormals::smooth(&bent, &indices);
        let map = DMat3::from_diagonal(DVec3::new(2.0, 1.0, -3.0));
        let mut whole = VertexNormals::default();
        whole.append(&part, 0, [0, 6], &DMat3::IDENTITY);
        assert!(whole.normals.iter().zip(&part.normals).all(|(one, other)| one.abs_diff_eq(*other, 1e-6)));
        whole.append(&part, 2, [6, 6], &map);
        let weights = [0.2, 0.3, 0.5];
        let normal = part.at(1, indices[1], weights).unwrap().as_dvec3();
        let [a, b, c] = indices[1].map(|at| at + 6);
        let appended = whole.at(3, [a, c, b], [0.2, 0.5, 0.3]).unwrap().as_dvec3();
        let transformed = (map.inverse().transpose() * normal).normalize();
        assert!(appended.dot(transformed) > 0.999, "{appended} {transformed}");
    }
}
