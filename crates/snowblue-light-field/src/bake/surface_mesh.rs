//! The surface of a solid as triangles that face outwards and share their vertices, and vertices with normals: one for
//! each smooth part of the surface that meets there.
//!
//! The normal is the mean of the normals of the faces around the vertex, weighted by their angles (Thürmer & Wüthrich
//! 1998, "Computing vertex normals from polygonal facets", doi:10.1080/10867651.1998.10487487). Only faces that are
//! inclined to each other by less than the crease angle count. At a sharper edge, and where faces lie apart in a
//! lightmap, the faces have separate vertices.

use glam::{Vec2, Vec3, Vec3A};
use snowblue_geometry::body::winding;
use snowblue_geometry::coincident::{keep_used, merged};
use snowblue_geometry::edges::{Grouped, PartTriangle, parts};
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::instance::Instance;
use snowblue_geometry::ray::{Crossing, Ray};
use snowblue_geometry::shape::Shape;
use snowblue_geometry::triangle_mesh::{SECOND_UV, TriangleMesh};
use snowblue_geometry::vertex_normals::{CREASE_DEG, face_normal};

/// Edges of an ellipsoid are at most as long as this fraction of its greatest extent.
const ROUNDEST: f32 = 0.1;

/// The surface of a solid in scene space.
pub(super) struct SurfaceMesh {
    /// Vertices, in m.
    pub(super) positions: Vec<Vec3>,
    pub(super) facets: Vec<Facet>,
    /// The ellipsoid whose surface it is, on which further vertices lie.
    pub(super) ellipsoid: Option<Ellipsoid>,
    /// Whether its facets have places of their own in a lightmap.
    pub(super) has_uv: bool,
}

/// A triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// Its vertices, counter-clockwise from outside.
    pub(super) vertices: [u32; 3],
    /// Outward unit normal of the face that the triangle is part of; zero if the face has no area.
    pub(super) normal: Vec3,
    /// Where its corners lie in a lightmap, 0–1; all 0 where they have no place yet.
    pub(super) uv: [Vec2; 3],
}

impl SurfaceMesh {
    /// The surface of a shape with as few triangles as it has; none of a plane.
    pub(super) fn of(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::Cuboid(cuboid) => Some(Self::of_triangles(cuboid.triangles())),
            Shape::Ellipsoid(ellipsoid) => {
                Some(Self { ellipsoid: Some(*ellipsoid), ..Self::of_triangles(ellipsoid.icosahedron()) })
            }
            Shape::Plane(_) => None,
            Shape::Mesh(instance) => Some(Self::of_mesh(shape, instance)),
        }
    }

    /// The longest edge that keeps the shape.
    pub(super) fn longest_edge_m(&self) -> f32 {
        self.ellipsoid.as_ref().map_or(f32::INFINITY, |ellipsoid| {
            let bounds = ellipsoid.bounds();
            ROUNDEST * (bounds.high - bounds.low).max_element()
        })
    }

    /// Adds the vertex of the surface at the middle of an edge.
    ///
    /// # Panics
    ///
    /// When there are 2³² vertices.
    pub(super) fn add_midpoint(&mut self, middle: Vec3) -> u32 {
        self.positions
            .push(self.ellipsoid.as_ref().map_or(middle, |ellipsoid| ellipsoid.project(middle.into()).point.into()));
        u32::try_from(self.positions.len() - 1).expect("a mesh in memory has fewer than 2^32 vertices")
    }

    /// Triangles that face outwards.
    fn of_triangles(TriangleMesh { positions, indices, .. }: TriangleMesh) -> Self {
        let facets = indices.into_iter().map(|vertices| facet(vertices, &positions)).collect();
        Self { positions, facets, ellipsoid: None, has_uv: false }
    }

    /// The triangles of a mesh that have distinct corners, turned outwards. All triangles of a connected part are
    /// turned consistently, as most of its area indicates: a single triangle may be covered where it is tested.
    fn of_mesh(shape: &Shape, instance: &Instance) -> Self {
        let mesh = instance.mesh().triangles();
        let first = merged(&mesh.positions, &mesh.indices);
        let to_scene = |position: &Vec3| Vec3::from(instance.transform().point_to_scene((*position).into()));
        let mut positions: Vec<Vec3> = mesh.positions.iter().map(to_scene).collect();
        let reach_m = instance.bounds().greatest_coordinate();
        let second_uv = mesh.attributes.get(SECOND_UV[0]).zip(mesh.attributes.get(SECOND_UV[1]));
        let uv_of =
            |vertex: u32| second_uv.map_or(Vec2::ZERO, |(u, v)| Vec2::new(u[vertex as usize], v[vertex as usize]));
        let corners = mesh.indices.iter().map(|triangle| (triangle.map(|vertex| first[vertex as usize]), triangle));
        let distinct = corners.filter(|([a, b, c], _)| a != b && b != c && c != a);
        let (mut triangles, uv): (Vec<[u32; 3]>, Vec<[Vec2; 3]>) =
            distinct.map(|(vertices, triangle)| (vertices, triangle.map(uv_of))).unzip();
        keep_used(&mut positions, &mut triangles);
        let facets = triangles.iter().zip(uv).map(|(vertices, uv)| Facet { uv, ..facet(*vertices, &positions) });
        let mut facets: Vec<Facet> = facets.collect();
        for part in parts(positions.len(), &triangles) {
            // Positive if the first triangle of the part faces outwards.
            let facing_m2 = |PartTriangle { triangle, is_reversed }: &PartTriangle| {
                let [a, b, c] = triangles[*triangle].map(|vertex| positions[vertex as usize]);
                let area_m2 = 0.5 * (b - a).cross(c - a).length();
                match faces_outwards(shape, (a + b + c) / 3.0, facets[*triangle].normal, reach_m) {
                    Some(is_outward) if is_outward != *is_reversed => area_m2,
                    Some(_) => -area_m2,
                    None => 0.0,
                }
            };
            let facing_m2: f32 = part.iter().map(facing_m2).sum();
            for PartTriangle { triangle, is_reversed } in part {
                if facing_m2 != 0.0 && is_reversed != (facing_m2 < 0.0) {
                    facets[triangle] = facets[triangle].reversed();
                }
            }
        }
        Self { positions, facets, ellipsoid: None, has_uv: second_uv.is_some() }
    }

    /// Removes the places of its facets in a lightmap.
    pub(super) fn forget_uv(&mut self) {
        self.has_uv = false;
        self.facets.iter_mut().for_each(|facet| facet.uv = [Vec2::ZERO; 3]);
    }
}

impl Facet {
    fn reversed(self) -> Self {
        let ([a, b, c], [at_a, at_b, at_c]) = (self.vertices, self.uv);
        Self { vertices: [a, c, b], normal: -self.normal, uv: [at_a, at_c, at_b] }
    }
}

fn facet(vertices: [u32; 3], positions: &[Vec3]) -> Facet {
    let normal = face_normal(vertices.map(|vertex| positions[vertex as usize]));
    Facet { vertices, normal, uv: [Vec2::ZERO; 3] }
}

/// Whether a triangle's normal points out of the solid: just beyond it, the winding number of the surface is 0.
/// None if the line gives no answer: at an open mesh, and where another triangle covers the middle of this triangle.
fn faces_outwards(shape: &Shape, middle: Vec3, normal: Vec3, reach_m: f32) -> Option<bool> {
    /// Greatest distance from the triangle at which the line crosses it, as a fraction of the greatest coordinate.
    const ROUNDING: f32 = 1e-5;
    if normal == Vec3::ZERO {
        return None;
    }
    let mut crossings = Vec::new();
    shape.crossings(&Ray::new(middle.into(), normal.into()), &mut crossings);
    let is_here = |crossing: &&Crossing| crossing.distance_m.abs() <= ROUNDING * reach_m;
    if winding(&crossings) != 0 || crossings.iter().filter(is_here).count() != 1 {
        return None;
    }
    crossings.retain(|crossing| !is_here(&crossing) && crossing.distance_m > 0.0);
    Some(winding(&crossings) == 0)
}

/// Shift of a point of the surface from a vertex on a sharp edge towards the middle of a face, as a fraction of the
/// distance. The field ends at edges, and rounding must not move the point beyond an edge.
pub(super) const INSET: f32 = 0.02;

/// Vertices and triangles of a surface.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    /// Positions, in m.
    pub(super) positions: Vec<Vec3>,
    /// Outward unit normals.
    pub(super) normals: Vec<Vec3>,
    /// The points where the light is read, in m. They lie on the surface: a point inside convex snow would be in its
    /// own shadow. At a sharp edge the point is beside the vertex, within the smooth part.
    pub(super) points: Vec<Vec3>,
    /// Places in a lightmap.
    pub(super) uv: Vec<Vec2>,
    /// The vertices of each triangle, counter-clockwise from outside.
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

/// Whether the surface is smooth between two facets with some normals. A facet without area, whose normal is zero,
/// counts as smooth with all facets.
pub(super) fn is_smooth(one: Vec3, other: Vec3) -> bool {
    one == Vec3::ZERO || other == Vec3::ZERO || one.dot(other) > CREASE_DEG.to_radians().cos()
}
