//! Snow with relief: the meshes that a camera sees of rough surfaces.
//!
//! Heights of the relief belong to places in the coordinates of an object ([`Shape::frame`]). The camera decides only
//! how finely triangles are split, and thus which wavelengths the triangles resolve. Where the camera sees a surface,
//! edges are about as long as a pixel is wide. Elsewhere, edges are an eighth of the distance to the nearest place
//! that the camera sees.
//!
//! No vertex moves farther than a third of the distance to the next surface in its direction. Therefore thin snow
//! does not cut itself, and surfaces that touch stay joined. No vertex comes nearer to another part of the surface
//! than to its own original place, so that faces do not cross at creases.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3, Vec3A};
use snowblue_base::{KeyError, KeyPath, narrow};
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::ray::{Ray, off_surface};
use snowblue_geometry::shape::Shape;
use snowblue_geometry::transform::Transform;
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_geometry::vertex_normals::VertexNormals;
use snowblue_shapes::displacement::Displacement;
use snowblue_shapes::refinement::refine;
use snowblue_shapes::roughness::Roughness;

use crate::camera::PerspectiveCamera;
use crate::film::FilmSettings;
use crate::material::Material;
use crate::objects::{Object, Objects};
use crate::seen::{MIN_ROWS, RAYS, SIZE_PER_DISTANCE, SeenPlaces};

/// Greatest length of visible edges, in pixels.
const PIXELS: f64 = 1.5;
/// Greatest number of triangles that splitting adds in a scene. If this number does not suffice, all edges become
/// longer.
const MAX_TRIANGLES: usize = 4_000_000;
/// Greatest movement of a vertex, as a fraction of the distance to the next surface.
const OF_WAY: f32 = 1.0 / 3.0;
/// The fraction of the available distance that a face uses near a crease, so that the faces on both sides do not
/// meet.
const BEFORE_MIDDLE: f32 = 0.9;
/// Distance below which surfaces touch, in m.
const TOUCHING_M: f32 = 1e-4;
/// Distance below which surfaces touch, as a fraction of the largest coordinate, which bounds the rounding of places.
const FARTHEST_TOUCHING: f32 = 1.0 / 524_288.0;
/// Edge length of the mesh of a sphere before its relief, as a fraction of the sphere's greatest extent. The middle
/// of an edge then lies 6·10⁻⁵ of the radius too low.
const ROUNDEST: f32 = 1.0 / 90.0;

/// The objects of a scene with the relief of their materials as a camera sees it, and a sentence if the triangles had
/// to be larger; none if no object has relief.
///
/// # Errors
///
/// If an object has relief, and there is no camera.
pub(crate) fn with_relief(
    objects: &Objects,
    materials: &[Material],
    (camera, film): (Option<&PerspectiveCamera>, &FilmSettings),
) -> Result<Option<(Objects, Option<String>)>, KeyError> {
    let roughness: Vec<Option<Roughness>> =
        materials.iter().map(|material| Some(material.relief()?.roughness())).collect();
    if objects.list().iter().all(|object| roughness[object.material].is_none()) {
        return Ok(None);
    }
    let reason = "is missing, but decides how fine the relief of the snow is";
    let camera = camera.ok_or_else(|| KeyPath::root("camera").error(reason))?;
    let fov_rad = f64::from(camera.view().vertical_fov_deg.to_radians());
    let width_per_m = 2.0 * (0.5 * fov_rad).tan();
    let aspect = f64::from(film.width.get()) / f64::from(film.height.get());
    let sight = ViewDetail {
        seen: SeenPlaces::of(objects, materials, camera),
        viewpoint: camera.view().position.as_dvec3(),
        pixel_per_m: width_per_m / f64::from(film.height.get().max(MIN_ROWS)),
        ray_per_m: width_per_m * aspect.max(1.0) / f64::from(RAYS),
    };
    let surface = |index: usize| {
        let roughness = roughness[objects.list()[index].material].as_ref()?;
        RoughSurface::of(objects, index, roughness, &sight)
    };
    let surfaces: Vec<Option<RoughSurface>> = (0..objects.list().len()).map(surface).collect();
    let mut factor = 1.0;
    loop {
        if let Some(rough) = rough_objects(objects, &surfaces, &sight, factor) {
            let note = (factor > 1.0).then(|| {
                format!(
                    "The triangles of the relief are up to {:.1} pixels wide instead of {PIXELS}, since there may be \
                     {MAX_TRIANGLES} more of them",
                    factor * PIXELS
                )
            });
            return Ok(Some((Objects::new(rough), note)));
        }
        factor *= 1.5;
    }
}

/// All objects, with rough meshes for the objects with relief; none if the meshes need too many triangles.
fn rough_objects(
    objects: &Objects,
    surfaces: &[Option<RoughSurface>],
    sight: &ViewDetail,
    factor: f64,
) -> Option<Vec<Object>> {
    let mut left = MAX_TRIANGLES;
    let rough = objects.list().iter().zip(surfaces).map(|(object, surface)| {
        let Some(surface) = surface.as_ref().filter(|surface| !surface.is_coarse(factor)) else {
            return Some(object.clone());
        };
        let first = surface.smooth.mesh.triangles().indices.len();
        let mesh = surface.displaced(sight, factor, first + left)?;
        left -= mesh.indices.len() - first;
        let shape = Shape::Mesh(Instance::new(Arc::new(MeshBvh::new(mesh)), surface.smooth.placement));
        Some(Object { shape, ..object.clone() })
    });
    rough.collect()
}

/// The surface of an object with relief, before its triangles are split.
struct RoughSurface<'a> {
    roughness: &'a Roughness,
    /// Lower bound of the edge lengths, in m.
    least_edge_m: f64,
    smooth: SmoothSurface,
    neighbours: Neighbours<'a>,
}

impl<'a> RoughSurface<'a> {
    /// The surface of an object; none for a plane, and for an object whose edges are all too long for any height.
    fn of(objects: &'a Objects, index: usize, roughness: &'a Roughness, sight: &ViewDetail) -> Option<Self> {
        let least_edge_m = sight.least_edge_m(objects.bounds(index)?);
        if least_edge_m >= roughness.greatest_edge_m() {
            return None;
        }
        let smooth = SmoothSurface::of(&objects.list()[index].shape)?;
        let own = Shape::Mesh(Instance::new(smooth.mesh.clone(), smooth.placement));
        let neighbours = Neighbours::of(objects, (index, own), narrow(roughness.greatest_m()));
        Some(Self { roughness, least_edge_m, smooth, neighbours })
    }

    /// Whether all edges are too long for any height.
    fn is_coarse(&self, factor: f64) -> bool {
        factor * self.least_edge_m >= self.roughness.greatest_edge_m()
    }

    /// The rough mesh of at most `most` triangles; none if the mesh needs more triangles.
    fn displaced(&self, sight: &ViewDetail, factor: f64, most: usize) -> Option<TriangleMesh> {
        let Self { roughness, smooth, neighbours, .. } = self;
        let least_m = roughness.least_edge_m();
        let displacement = Displacement {
            roughness,
            edge_m: &|place| narrow(factor * sight.edge_m(smooth.to_scene(place), least_m)),
            edge_growth: narrow(factor * sight.edge_growth()),
            room: &|place, offset| neighbours.room(smooth.to_scene(place).as_vec3a(), smooth.turned(offset)),
        };
        displacement.of(smooth.mesh.triangles().clone(), most)
    }
}

/// The detail that a camera resolves.
struct ViewDetail {
    seen: SeenPlaces,
    viewpoint: DVec3,
    /// Width of a pixel over the distance, and width of the gaps between the rays that find visible places over the
    /// distance.
    pixel_per_m: f64,
    ray_per_m: f64,
}

impl ViewDetail {
    /// Distance from visible places within which a place counts as visible, in distances between rays. Few rays meet
    /// a surface at a grazing angle.
    const RAYS_APART: f64 = 3.0;

    /// Lower bound of the lengths of the edges in bounds, in m.
    fn least_edge_m(&self, bounds: Bounds) -> f64 {
        let [low, high] = [bounds.low, bounds.high].map(|corner| corner.as_dvec3());
        let nearest_m = self.viewpoint.distance(self.viewpoint.clamp(low, high));
        let farthest_m = (self.viewpoint - low).abs().max((high - self.viewpoint).abs()).length();
        let hidden_m = self.seen.distance_m(low, high, 0.0) - Self::RAYS_APART * self.ray_per_m * farthest_m;
        (PIXELS * self.pixel_per_m * nearest_m).max(SIZE_PER_DISTANCE * hidden_m)
    }

    /// Greatest growth of the edge length for each metre.
    fn edge_growth(&self) -> f64 {
        (PIXELS * self.pixel_per_m).max(SIZE_PER_DISTANCE * (1.0 + Self::RAYS_APART * self.ray_per_m))
    }

    /// Greatest length of the edges around a place, in m, but at least `least_m`: shorter edges are not needed.
    fn edge_m(&self, place: DVec3, least_m: f64) -> f64 {
        let distance_m = place.distance(self.viewpoint);
        let visible_m = (PIXELS * self.pixel_per_m * distance_m).max(least_m);
        let beside_m = Self::RAYS_APART * self.ray_per_m * distance_m;
        let near_m = beside_m + visible_m / SIZE_PER_DISTANCE;
        visible_m.max(SIZE_PER_DISTANCE * (self.seen.distance_m(place, place, near_m) - beside_m))
    }
}

/// The surface of an object in its own coordinates.
struct SmoothSurface {
    mesh: Arc<MeshBvh>,
    /// The map from these coordinates to the scene.
    frame: DAffine3,
    placement: Transform,
}

impl SmoothSurface {
    /// The surface of a shape; none for a plane.
    fn of(shape: &Shape) -> Option<Self> {
        let (axes, origin) = shape.frame();
        let frame = DAffine3::from_mat3_translation(axes.as_dmat3(), origin.as_dvec3());
        let placed = |mesh: &TriangleMesh, to_scene| {
            let mut own = TriangleMesh::default();
            own.append(mesh, &(frame.inverse() * to_scene)).ok()?;
            Some(Arc::new(MeshBvh::new(own)))
        };
        let mesh = match shape {
            Shape::Cuboid(cuboid) => placed(&cuboid.triangles(), DAffine3::IDENTITY),
            Shape::Ellipsoid(ellipsoid) => placed(&round(ellipsoid), DAffine3::IDENTITY),
            Shape::Plane(_) => None,
            Shape::Mesh(instance) => {
                let map = instance.transform().scene_map();
                let matrix: DMat3 = map.matrix3.as_dmat3();
                let to_scene = DAffine3::from_mat3_translation(matrix, map.translation.as_dvec3());
                // Without a scale or a rotation, the hierarchy of the mesh is reused.
                if frame == to_scene {
                    Some(instance.mesh().clone())
                } else {
                    placed(instance.mesh().triangles(), to_scene)
                }
            }
        }?;
        let placement = Transform::new(&frame).expect("a frame is a rotation and a shift");
        Some(Self { mesh, frame, placement })
    }

    fn to_scene(&self, place: Vec3) -> DVec3 {
        self.frame.transform_point3(place.as_dvec3())
    }

    fn turned(&self, vector: Vec3) -> Vec3A {
        self.frame.transform_vector3(vector.as_dvec3()).as_vec3a()
    }
}

/// The surface of an ellipsoid in the scene, as triangles that look round.
fn round(ellipsoid: &Ellipsoid) -> TriangleMesh {
    let bounds = ellipsoid.bounds();
    let longest_m = ROUNDEST * (bounds.high - bounds.low).max_element();
    let mut mesh = ellipsoid.icosahedron();
    let is_long = |[from, to]: [Vec3; 2], _: [(); 2]| from.distance(to) > longest_m;
    refine(&mut mesh, MAX_TRIANGLES, |_| (), is_long);
    let surface: Vec<_> = mesh.positions.iter().map(|position| ellipsoid.project((*position).into())).collect();
    mesh.positions = surface.iter().map(|surface| surface.point.into()).collect();
    mesh.normals = VertexNormals::new(surface.iter().map(|surface| surface.normal.into()));
    mesh
}

/// The shapes near the surface of an object.
struct Neighbours<'a> {
    /// The smooth mesh in m. Its vertices lie exactly on this shape, and its nearest points are the nearest points in
    /// the scene.
    own: Shape,
    reach_m: f32,
    /// Other shapes, each with whether it belongs to the same body.
    others: Vec<(&'a Shape, bool)>,
}

impl<'a> Neighbours<'a> {
    /// The neighbours that heights of at most the magnitude `greatest_m` may reach.
    fn of(objects: &'a Objects, (index, own): (usize, Shape), greatest_m: f32) -> Self {
        let around = objects.bounds(index).map(|bounds| bounds.padded(greatest_m / OF_WAY + TOUCHING_M));
        let is_near = |other: &usize| {
            let both = around.zip(objects.bounds(*other));
            *other != index && both.is_none_or(|(around, other)| around.common(other).is_some())
        };
        let (list, body) = (objects.list(), objects.body_of(index));
        let others = (0..list.len()).filter(is_near).map(|other| (&list[other].shape, body.contains(&other)));
        Self { own, reach_m: objects.reach_m(index), others: others.collect() }
    }

    /// The fraction of an offset by which a point of the surface may move: at most a third of the distance to the
    /// next surface. In a body of several objects, where surfaces may be joints, the distance in the opposite
    /// direction counts as well.
    fn room(&self, point: Vec3A, offset: Vec3A) -> f32 {
        let length_m = offset.length();
        if length_m <= 0.0 {
            return 0.0;
        }
        let (direction, limit_m) = (offset / length_m, length_m / OF_WAY);
        let ahead = Ray::new(off_surface(point, direction, self.reach_m), direction);
        let mut way_m = self.own.first_hit(&ahead, limit_m).map_or(limit_m, |hit| hit.distance_m);
        // Where the moved point is nearer to another part of the surface, a face may move only to the middle between
        // both parts.
        let most_m = OF_WAY * way_m;
        let nearest_m = self.own.nearest(point + direction * most_m).map_or(most_m, |hit| hit.distance_m.min(most_m));
        let near = if most_m > 0.0 { nearest_m / most_m } else { 0.0 };
        way_m *= BEFORE_MIDDLE * near + (1.0 - BEFORE_MIDDLE) * near.powi(8);
        let touching_m = TOUCHING_M.max(self.reach_m * FARTHEST_TOUCHING);
        for (shape, is_of_body) in &self.others {
            let both = [direction, -direction];
            for direction in &both[..if *is_of_body { 2 } else { 1 }] {
                let ray = Ray::new(point - *direction * touching_m, *direction);
                let hit = shape.first_hit(&ray, limit_m + 2.0 * touching_m);
                way_m = hit.map_or(way_m, |hit| way_m.min((hit.distance_m - 2.0 * touching_m).max(0.0)));
            }
        }
        way_m / limit_m
    }
}
