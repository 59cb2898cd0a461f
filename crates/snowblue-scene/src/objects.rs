//! The objects of a scene: first hits, occlusion, and the crossings of a line with a solid.
//!
//! A solid is one object, or all objects of one body: blocks of snow that touch or overlap are one piece of snow.
//! Each object keeps its material. The depth through a body counts in the material of the visible object.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Vec2, Vec3A};
use snowblue_geometry::body::{pair_up, pair_up_from, unite, winding};
use snowblue_geometry::bounds::{Bounds, Interval};
use snowblue_geometry::bvh::{Bvh8, BvhRay};
use snowblue_geometry::ray::{Crossing, MeshLocation, Ray, ShapeHit, SurfacePoint};
use snowblue_geometry::shape::Shape;
use snowblue_geometry::texture_coordinates::TextureCoordinates;

use crate::undisturbed::UndisturbedSurface;

/// Greatest number of objects that are tested one by one. More objects get a hierarchy.
const FEW_OBJECTS: usize = 6;

/// A shape with a material. Clones share large data.
#[derive(Debug, Clone)]
pub struct Object {
    /// Name in reports: its file or shape.
    pub name: String,
    /// Shape.
    pub shape: Shape,
    /// Index of its material in the scene.
    pub material: usize,
    /// Objects of the same body are one solid. An object without a body is a body of its own.
    pub body: Option<String>,
    /// The surface of the object before prints were pressed into it; none if there are no prints.
    pub undisturbed: Option<Arc<UndisturbedSurface>>,
}

/// A hit on an object.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceInteraction {
    /// Index of the object.
    pub object: usize,
    /// Index of its material.
    pub material: usize,
    /// The hit point.
    pub point: Vec3A,
    /// Unit normal on the side of the ray. It points outwards as long as rays stay outside of solids.
    pub normal: Vec3A,
    /// Unit normal for shading: the interpolated vertex normal of a mesh, and for other shapes `normal`. Its cosines to
    /// `normal` and to the direction back along the ray are positive. Depths, shadows and offsets of rays ignore it.
    pub shading_normal: Vec3A,
    /// Unit direction of the ray.
    pub direction: Vec3A,
    /// Location on the object's mesh.
    pub location: MeshLocation,
}

impl SurfaceInteraction {
    /// The point and its normal.
    #[inline]
    pub fn surface_point(&self) -> SurfacePoint {
        SurfacePoint { point: self.point, normal: self.normal }
    }
}

/// The side of an object's surface that light reaches, with the object's index.
#[derive(Debug, Clone, Copy)]
pub enum Side {
    /// The outer side. All objects occlude lights from it.
    Outer(usize),
    /// The inner side, where a path through the object leaves the object. Other objects of its body do not occlude.
    Inner(usize),
    /// The inner side, where the line to the light leaves the body for the last time. No object of the body occludes.
    Last(usize),
}

impl Side {
    /// Index of the object.
    pub(crate) fn object(self) -> usize {
        match self {
            Self::Outer(object) | Self::Inner(object) | Self::Last(object) => object,
        }
    }
}

/// All objects of a scene.
#[derive(Debug)]
pub struct Objects {
    objects: Vec<Object>,
    /// The box around each object; none for infinite objects.
    bounds: Vec<Option<Bounds>>,
    /// Index of each object's body.
    bodies: Vec<usize>,
    /// The objects of each body.
    members: Vec<Members>,
    /// Objects that are tested for every ray: infinite objects, and all objects if there are few.
    tried: Vec<usize>,
    /// Hierarchy over the remaining objects, if there are any.
    hierarchy: Option<ObjectBvh>,
}

/// The objects of a body.
#[derive(Debug)]
struct Members {
    objects: Vec<usize>,
    /// Hierarchy over the objects with bounds, if there are many.
    bvh: Option<ObjectBvh>,
}

/// A hierarchy over some objects.
#[derive(Debug)]
struct ObjectBvh {
    bvh: Bvh8,
    /// Index in the scene of each object of the hierarchy.
    objects: Vec<usize>,
}

impl ObjectBvh {
    fn new(objects: &[usize], bounds: &[Option<Bounds>]) -> Self {
        let boxes: Vec<Bounds> = objects.iter().filter_map(|&index| bounds[index]).collect();
        let greatest = boxes.iter().map(Bounds::greatest_coordinate).fold(0.0, f32::max);
        let padded: Vec<_> = boxes.iter().map(|one| one.padded(greatest * 1e-5)).collect();
        Self { bvh: Bvh8::build(&padded), objects: objects.into() }
    }
}

impl Objects {
    /// Gathers the objects, and builds hierarchies over all objects and over the objects of large bodies.
    pub fn new(objects: Vec<Object>) -> Self {
        let bounds: Vec<_> = objects.iter().map(|object| object.shape.bounds()).collect();
        let bounded: Vec<usize> = (0..objects.len()).filter(|&index| bounds[index].is_some()).collect();
        let many = |objects: &[usize]| (objects.len() > FEW_OBJECTS).then(|| ObjectBvh::new(objects, &bounds));
        let hierarchy = many(&bounded);
        let unbounded = (0..objects.len()).filter(|&index| bounds[index].is_none());
        let tried = if hierarchy.is_some() { unbounded.collect() } else { unbounded.chain(bounded).collect() };
        let (bodies, members) = bodies(&objects);
        let members = members.into_iter().map(|objects| {
            let bounded: Vec<usize> = objects.iter().copied().filter(|&index| bounds[index].is_some()).collect();
            Members { bvh: many(&bounded), objects }
        });
        let members = members.collect();
        Self { objects, bounds, bodies, members, tried, hierarchy }
    }

    /// The objects, in the order of the scene.
    pub fn list(&self) -> &[Object] {
        &self.objects
    }

    /// The box around an object; none if the object is infinite.
    #[inline]
    pub fn bounds(&self, object: usize) -> Option<Bounds> {
        self.bounds[object]
    }

    /// Largest coordinate of an object in m. It bounds the rounding of the object's surface points. It is 0 for an
    /// infinite plane, whose points are as exact as their own coordinates.
    pub fn reach_m(&self, object: usize) -> f32 {
        self.bounds[object].map_or(0.0, |bounds| bounds.greatest_coordinate())
    }

    /// The objects of the body that an object belongs to.
    pub fn body_of(&self, object: usize) -> &[usize] {
        &self.members[self.bodies[object]].objects
    }

    /// Texture coordinates at a hit, if the object's mesh has them.
    pub fn uv(&self, surface: &SurfaceInteraction) -> Option<Vec2> {
        self.objects[surface.object].shape.mesh()?.uv(&surface.location)
    }

    /// Texture coordinates at a hit. A mesh must have texture coordinates.
    pub(crate) fn texture_coordinates_at(&self, surface: &SurfaceInteraction) -> TextureCoordinates {
        match &self.objects[surface.object].shape {
            Shape::Cuboid(cuboid) => cuboid.texture_coordinates(surface.point, surface.normal),
            Shape::Ellipsoid(ellipsoid) => ellipsoid.texture_coordinates(surface.point),
            Shape::Plane(plane) => plane.texture_coordinates(surface.point),
            Shape::Mesh(instance) => {
                TextureCoordinates::Image(instance.mesh().uv(&surface.location).unwrap_or_default())
            }
        }
    }

    /// A vertex attribute of the object's mesh at a hit, by its name in the mesh file.
    pub fn attribute(&self, name: &str, surface: &SurfaceInteraction) -> Option<f32> {
        self.objects[surface.object].shape.mesh()?.attribute(name, &surface.location)
    }

    /// The first hit of a ray.
    #[inline]
    pub fn first_hit(&self, ray: &Ray) -> Option<SurfaceInteraction> {
        self.first_hit_of(ray, f32::INFINITY, |_| true)
    }

    /// The first hit of a ray on an object that counts, nearer than `limit_m`.
    #[inline]
    pub(crate) fn first_hit_of(
        &self,
        ray: &Ray,
        limit_m: f32,
        counts: impl Fn(usize) -> bool,
    ) -> Option<SurfaceInteraction> {
        let mut nearest = Nearest { distance_m: limit_m, hit: None };
        for &index in self.tried.iter().filter(|index| counts(**index)) {
            nearest.try_object(self, index, ray);
        }
        if let Some(hierarchy) = &self.hierarchy {
            hierarchy.visit(ray, nearest.distance_m, &mut |index| {
                if counts(index) {
                    nearest.try_object(self, index, ray);
                }
                nearest.distance_m
            });
        }
        let (object, hit) = nearest.hit?;
        let normal = if hit.normal.dot(ray.direction) <= 0.0 { hit.normal } else { -hit.normal };
        let Object { shape, material, .. } = &self.objects[object];
        Some(SurfaceInteraction {
            object,
            material: *material,
            point: hit.point,
            normal,
            shading_normal: shape.shading_normal(&hit.location, normal, ray.direction),
            direction: ray.direction,
            location: hit.location,
        })
    }

    /// Whether a ray hits anything nearer than `limit_m`.
    pub fn any_hit(&self, ray: &Ray, limit_m: f32) -> bool {
        self.occluded_by(ray, limit_m, |_| true)
    }

    /// Whether an object can occlude a light from one side of a surface.
    #[inline]
    pub(crate) fn can_occlude(&self, index: usize, side: Side) -> bool {
        match side {
            Side::Outer(_) => true,
            // A convex shape does not occlude a light in front of the surface point where the path leaves the shape.
            Side::Inner(object) if index == object => !self.objects[index].shape.is_convex(),
            Side::Inner(object) | Side::Last(object) => self.bodies[index] != self.bodies[object],
        }
    }

    /// Whether an object that counts occludes a ray nearer than `limit_m`.
    #[inline]
    pub(crate) fn occluded_by(&self, ray: &Ray, limit_m: f32, counts: impl Fn(usize) -> bool) -> bool {
        let occludes = |index: usize| counts(index) && self.objects[index].shape.occludes(ray, limit_m);
        if self.tried.iter().any(|&index| occludes(index)) {
            return true;
        }
        let Some(hierarchy) = &self.hierarchy else { return false };
        let mut occluded = false;
        hierarchy.visit(ray, limit_m, &mut |index| {
            occluded = occluded || occludes(index);
            // A negative limit ends the search.
            if occluded { f32::NEG_INFINITY } else { f32::INFINITY }
        });
        occluded
    }

    /// The shape of an object, if the shape is convex and the object is the only object of its body.
    #[inline]
    pub(crate) fn convex(&self, object: usize) -> Option<&Shape> {
        let shape = &self.objects[object].shape;
        let alone = || self.members[self.bodies[object]].objects.len() == 1;
        (shape.is_convex() && alone()).then_some(shape)
    }

    /// Collects the segments of a line inside the solid that an object is or belongs to: an entry and an exit each, in
    /// order along the line. Segments wholly behind the origin may be missing, and within a body of several objects
    /// segments beyond `limit_m`.
    ///
    /// Returns whether the line crossed an object's surface an odd number of times.
    pub fn segments(&self, object: usize, ray: &Ray, limit_m: f32, segments: &mut Vec<Crossing>) -> bool {
        self.cross(object, ray, (limit_m, false), segments)
    }

    /// Collects the segments of a line as [`segments`](Self::segments) does, of a solid that is known to be closed.
    /// This is faster: the segment that holds the origin may begin just behind the origin.
    pub fn segments_of_closed(&self, object: usize, ray: &Ray, limit_m: f32, segments: &mut Vec<Crossing>) -> bool {
        self.cross(object, ray, (limit_m, true), segments)
    }

    fn cross(
        &self,
        object: usize,
        ray: &Ray,
        (limit_m, is_closed): (f32, bool),
        crossings: &mut Vec<Crossing>,
    ) -> bool {
        crossings.clear();
        let members = &self.members[self.bodies[object]];
        if members.objects.len() == 1 {
            return self.cross_alone(object, ray, is_closed, crossings);
        }
        let (interval, mut odd) = (Interval { start_m: 0.0, end_m: limit_m }, false);
        let mut add = |member| odd |= self.add_segments(member, ray, interval, crossings);
        match &members.bvh {
            Some(bvh) => bvh.visit_unordered(ray, interval, &mut add),
            None => members.objects.iter().for_each(|&member| add(member)),
        }
        unite(crossings);
        odd
    }

    /// Adds the pairs of crossings of a line with a member of a body, if an interval of the line meets the member's
    /// bounds.
    ///
    /// Returns whether the number of crossings was odd.
    #[inline]
    fn add_segments(&self, member: usize, ray: &Ray, interval: Interval, crossings: &mut Vec<Crossing>) -> bool {
        if self.bounds[member].and_then(|bounds| bounds.intersect(ray, interval)).is_none() {
            return false;
        }
        let first = crossings.len();
        self.add_crossings(member, ray, crossings);
        pair_up(crossings, first)
    }

    /// The segments of a line inside an object that is a body by itself, without segments behind the origin.
    ///
    /// A point just behind the surface point where a line starts is usually outside. If the line enters a mesh as often
    /// as it leaves it ahead of this point, these crossings suffice. Else the point is inside a closed mesh, and the
    /// first segment begins at this point.
    fn cross_alone(&self, object: usize, ray: &Ray, is_closed: bool, crossings: &mut Vec<Crossing>) -> bool {
        /// Distance of this point behind the origin, as a fraction of the largest coordinate: far more than rounding.
        const BEHIND: f32 = 1.0 / 1024.0;
        if let Shape::Mesh(instance) = &self.objects[object].shape {
            let from_m = -BEHIND * self.reach_m(object);
            instance.crossings_from(ray, from_m, crossings);
            if is_closed || winding(crossings) == 0 {
                let start = Crossing { distance_m: from_m, normal: -ray.direction, object: 0, is_entry: true };
                pair_up_from(start, crossings);
                set_object(object, crossings);
                return false;
            }
            crossings.clear();
        }
        self.add_crossings(object, ray, crossings);
        pair_up(crossings, 0)
    }

    fn add_crossings(&self, object: usize, ray: &Ray, crossings: &mut Vec<Crossing>) {
        let first = crossings.len();
        self.objects[object].shape.crossings(ray, crossings);
        set_object(object, &mut crossings[first..]);
    }

    /// Whether a point inside a body is farther than `depth_m` from the surface of an object of the body: the object
    /// whose bounds hold the point most deeply. Joints between objects count as surface.
    #[inline]
    pub fn holds_deeply(&self, object: usize, point: Vec3A, depth_m: f32) -> bool {
        let members = self.body_of(object);
        if let [only] = members {
            return self.objects[*only].shape.holds_deeply(point, depth_m);
        }
        let may_hold =
            |member: &usize| self.bounds[*member].is_some_and(|bounds| bounds.padded(-depth_m).contains(point));
        members.iter().filter(|member| may_hold(member)).any(|member| {
            let shape = &self.objects[*member].shape;
            shape.holds_deeply(point, depth_m) && (shape.is_convex() || self.holds(*member, point))
        })
    }

    /// The point of the surface of an object's body that is nearest to a point; none if the body is infinite.
    pub(crate) fn nearest(&self, object: usize, point: Vec3A) -> Option<SurfaceInteraction> {
        let found = self.body_of(object).iter().filter_map(|&member| {
            let hit = self.objects[member].shape.nearest(point)?;
            Some((member, hit))
        });
        let (object, hit) = found.min_by(|(_, one), (_, other)| one.distance_m.total_cmp(&other.distance_m))?;
        Some(SurfaceInteraction {
            object,
            material: self.objects[object].material,
            point: hit.point,
            normal: hit.normal,
            shading_normal: hit.normal,
            direction: -hit.normal,
            location: hit.location,
        })
    }

    /// The first object of some kind in which a point lies.
    pub fn around(&self, point: Vec3A, is_of_kind: impl Fn(&Object) -> bool) -> Option<usize> {
        (0..self.objects.len()).find(|&index| is_of_kind(&self.objects[index]) && self.holds(index, point))
    }

    /// Whether a point lies inside an object: lines in three directions must agree. False for an open surface. The
    /// inside of a plane is the space behind it.
    pub fn holds(&self, object: usize, point: Vec3A) -> bool {
        if let Shape::Plane(plane) = &self.objects[object].shape {
            return plane.is_behind(point);
        }
        if self.bounds[object].is_some_and(|bounds| !bounds.contains(point)) {
            return false;
        }
        let mut crossings = Vec::new();
        [Vec3A::new(0.36, 0.48, 0.8), Vec3A::new(-0.8, 0.6, 0.0), Vec3A::new(0.48, -0.6, -0.64)].iter().all(
            |&direction| {
                crossings.clear();
                self.objects[object].shape.crossings(&Ray::new(point, direction), &mut crossings);
                let is_open = pair_up(&mut crossings, 0);
                let holds = |[enter, leave]: &[Crossing; 2]| enter.distance_m <= 0.0 && leave.distance_m > 0.0;
                !is_open && crossings.as_chunks().0.iter().any(holds)
            },
        )
    }
}

/// The nearest hit of a ray so far.
struct Nearest {
    distance_m: f32,
    /// Index of the object and the hit on it.
    hit: Option<(usize, ShapeHit)>,
}

impl Nearest {
    #[inline(always)]
    fn try_object(&mut self, objects: &Objects, index: usize, ray: &Ray) {
        if let Some(hit) = objects.objects[index].shape.first_hit(ray, self.distance_m) {
            *self = Self { distance_m: hit.distance_m, hit: Some((index, hit)) };
        }
    }
}

impl ObjectBvh {
    /// Calls `visit` for objects whose padded bounds an interval of the ray meets, in any order.
    fn visit_unordered(&self, ray: &Ray, interval: Interval, visit: &mut dyn FnMut(usize)) {
        self.bvh.traverse(&BvhRay::new(ray, interval), |leaf| {
            self.bvh.primitives(leaf).for_each(|primitive| visit(self.objects[primitive]));
            false
        });
    }

    // Not inlined, so that `try_object` is inlined where all objects are tried.
    #[inline(never)]
    fn visit(&self, ray: &Ray, limit_m: f32, try_object: &mut dyn FnMut(usize) -> f32) {
        let mut nearest = limit_m;
        self.bvh.traverse_ordered(&BvhRay::new(ray, Interval { start_m: 0.0, end_m: nearest }), |leaf| {
            for primitive in self.bvh.primitives(leaf) {
                nearest = nearest.min(try_object(self.objects[primitive]));
            }
            nearest
        });
    }
}

/// Sets the object of some crossings.
#[expect(clippy::cast_possible_truncation, reason = "a scene in memory has fewer than 2^32 objects")]
#[inline]
pub(crate) fn set_object(object: usize, crossings: &mut [Crossing]) {
    crossings.iter_mut().for_each(|crossing| crossing.object = object as u32);
}

/// The body of each object, and the objects of each body.
fn bodies(objects: &[Object]) -> (Vec<usize>, Vec<Vec<usize>>) {
    let mut named = BTreeMap::new();
    let (mut bodies, mut members) = (Vec::with_capacity(objects.len()), Vec::<Vec<usize>>::new());
    for (index, object) in objects.iter().enumerate() {
        let fresh = members.len();
        let body = object.body.as_ref().map_or(fresh, |name| *named.entry(name).or_insert(fresh));
        if body == fresh {
            members.push(Vec::new());
        }
        bodies.push(body);
        members[body].push(index);
    }
    (bodies, members)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DVec3, Mat3A, Vec3};
    use snowblue_geometry::cuboid::Cuboid;
    use snowblue_geometry::instance::Instance;
    use snowblue_geometry::mesh_bvh::MeshBvh;
    use snowblue_geometry::plane::Plane;
    use snowblue_geometry::transform::Transform;
    use snowblue_geometry::triangle_mesh::TriangleMesh;
    use snowblue_geometry::vertex_normals::VertexNormals;
    use snowblue_shapes::igloo::Igloo;
    use std::f64::consts::TAU;
    use std::sync::Arc;

    /// A unit sphere of 8 · `steps`² triangles, subdivided from an octahedron.
    fn sphere(steps: usize) -> Vec<[Vec3; 3]> {
        let mut triangles = Vec::new();
        for octant in 0..8 {
            let sign = Vec3::from_array([1, 2, 4].map(|bit| if octant & bit == 0 { 1.0 } else { -1.0 }));
            let point = |i: usize, j: usize| (Vec3::new(i as f32, j as f32, (steps - i - j) as f32) * sign).normalize();
            for i in 0..steps {
                for j in 0..steps - i {
                    triangles.push([point(i, j), point(i + 1, j), point(i, j + 1)]);
                    if i + j + 1 < steps {
                        triangles.push([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
                    }
                }
            }
        }
        triangles
    }

    fn directions(count: usize) -> impl Iterator<Item = Vec3A> {
        (0..count).map(move |k| {
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / count as f32;
            let turn = 2.399_963 * k as f32;
            let radius = (1.0 - z * z).sqrt();
            Vec3A::new(radius * turn.cos(), radius * turn.sin(), z)
        })
    }

    fn object(shape: Shape, material: usize) -> Object {
        Object { name: String::new(), shape, material, body: None, undisturbed: None }
    }

    fn row(count: usize) -> Vec<Object> {
        let cube =
            |k: usize| Shape::Cuboid(Cuboid::new(Vec3A::new(2.0 * k as f32, 0.0, 0.0), Vec3A::ONE, Mat3A::IDENTITY));
        (0..count).map(|k| object(cube(k), k)).collect()
    }

    /// An igloo whose blocks are objects of one body, with lines from near its wall and through its joints.
    #[test]
    fn a_hierarchy_over_a_body_finds_the_same_segments_as_all_members() {
        let igloo = Igloo {
            inner_radius_m: 1.5,
            wall_m: 0.15,
            courses: 6,
            block_width_m: 0.6,
            seam_depth_m: 0.035,
            seam_width_m: 0.05,
            seed: 3,
        };
        let block = |block: TriangleMesh| {
            let transform = Transform::new(&DAffine3::IDENTITY).unwrap();
            let shape = Shape::Mesh(Instance::new(MeshBvh::new(block).into(), transform));
            Object { body: Some("igloo".to_owned()), ..object(shape, 0) }
        };
        let objects = Objects::new(igloo.blocks().into_iter().map(block).collect());
        assert!(objects.list().len() > 60 && objects.members[0].bvh.is_some());
        let (mut found, mut expected, mut merged) = (Vec::new(), Vec::new(), 0);
        for k in 0..4000u32 {
            let number = |salt: u32| (f64::from(k) * [0.618_034, 0.754_878, 0.569_840][salt as usize]).fract();
            let (azimuth, height) = (TAU * number(0), 1.2 * number(1));
            let wall_m = 1.3 + 0.5 * number(2);
            let origin = Vec3A::from(DVec3::new(wall_m * azimuth.cos(), wall_m * azimuth.sin(), height).as_vec3());
            let target = DVec3::new(3.0 * number(1) - 1.5, 3.0 * number(2) - 1.5, number(0)).as_vec3a();
            let ray = Ray::new(origin, (target - origin).normalize());
            for limit_m in [f32::INFINITY, 0.5] {
                let odd = objects.segments(0, &ray, limit_m, &mut found);
                expected.clear();
                let interval = Interval { start_m: 0.0, end_m: limit_m };
                let (mut expected_odd, mut segments) = (false, 0);
                for member in 0..objects.list().len() {
                    expected_odd |= objects.add_segments(member, &ray, interval, &mut expected);
                    segments = expected.len() / 2;
                }
                unite(&mut expected);
                merged += usize::from(expected.len() / 2 < segments);
                let bits = |crossings: &[Crossing]| -> Vec<_> {
                    let bits = |one: &Crossing| {
                        (one.distance_m.to_bits(), one.normal.to_array().map(f32::to_bits), one.object)
                    };
                    crossings.iter().map(bits).collect()
                };
                assert_eq!((odd, bits(&found)), (expected_odd, bits(&expected)), "line {k}");
            }
        }
        assert!(merged > 1000, "{merged}");
    }

    /// Lines from points inside a torus and near its surface cross the torus up to four times.
    #[test]
    fn lines_from_inside_have_the_segments_of_the_whole_line() {
        const STEPS: [usize; 2] = [48, 24];
        let point = |i: usize, j: usize| {
            let [a, b] = [i % STEPS[0], j % STEPS[1]];
            let ((sin_a, cos_a), (sin_b, cos_b)) =
                ((TAU * a as f64 / 48.0).sin_cos(), (TAU * b as f64 / 24.0).sin_cos());
            let radius = 1.0 + 0.4 * cos_b;
            DVec3::new(radius * cos_a, radius * sin_a, 0.4 * sin_b).as_vec3()
        };
        let triangles = |(i, j): (usize, usize)| {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(k, l)| point(i + k, j + l));
            [[a, b, c], [a, c, d]]
        };
        let places = (0..STEPS[0]).flat_map(|i| (0..STEPS[1]).map(move |j| (i, j)));
        let torus = TriangleMesh::from_triangles(&places.flat_map(triangles).collect::<Vec<_>>());
        let upright = Transform::new(&DAffine3::IDENTITY).unwrap();
        let objects = Objects::new(vec![object(Shape::Mesh(Instance::new(MeshBvh::new(torus).into(), upright)), 0)]);
        let (mut found, mut whole, mut inside) = (Vec::new(), Vec::new(), 0);
        for k in 0..4000u32 {
            let number = |salt: f64| (f64::from(k) * salt).fract();
            let (turn, radius) = (TAU * number(0.618_034), 0.5 + number(0.569_840));
            let origin = DVec3::new(radius * turn.cos(), radius * turn.sin(), 0.8 * number(0.754_878) - 0.4);
            let direction = DVec3::new(number(0.447_214), number(0.577_350), number(0.732_051)) - 0.5;
            let ray = Ray::new(origin.as_vec3a(), direction.as_vec3a().normalize());
            assert!(!objects.segments_of_closed(0, &ray, f32::INFINITY, &mut found), "line {k}");
            assert!(!objects.segments(0, &ray, f32::INFINITY, &mut whole), "line {k}");
            let ahead = |crossings: &[Crossing]| -> Vec<Crossing> {
                let pairs = crossings.chunks_exact(2).filter(|pair| pair[1].distance_m > 0.0);
                pairs.flatten().copied().collect()
            };
            let (found, whole) = (ahead(&found), ahead(&whole));
            assert_eq!(found.len(), whole.len(), "line {k}");
            for (found, whole) in found.iter().zip(&whole) {
                // Coordinates of up to 1.4 are rounded where the queries enter the bounds, which shifts grazing
                // crossings more.
                let cos = whole.normal.normalize().dot(ray.direction).abs();
                let apart = found.distance_m.max(0.0) - whole.distance_m.max(0.0);
                assert!(apart.abs() * cos < 4.0 * f32::EPSILON, "line {k}: {apart}");
            }
            inside += usize::from(whole.first().is_some_and(|enter| enter.distance_m <= 0.0));
        }
        assert!(inside > 1000, "{inside}");
    }

    /// A sphere of triangles, stretched, mirrored and turned, compared with the true normals of the ellipsoid.
    #[test]
    fn shading_normals_of_placed_meshes_are_those_of_the_smooth_surface() {
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.5, -2.0, 1.2),
            glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0),
            DVec3::new(3.0, -1.0, 0.5),
        );
        let outwards = |[a, b, c]: [Vec3; 3]| if (b - a).cross(c - a).dot(a) < 0.0 { [a, c, b] } else { [a, b, c] };
        let triangles: Vec<_> = sphere(24).into_iter().map(outwards).collect();
        let mesh = Arc::new(MeshBvh::new(TriangleMesh::from_triangles(&triangles).smooth()));
        let instance = Instance::new(Arc::clone(&mesh), Transform::new(&map).unwrap());
        let plain = Shape::Cuboid(Cuboid::new(Vec3A::new(20.0, 0.0, 0.0), Vec3A::ONE, Mat3A::IDENTITY));
        let objects = Objects::new(vec![object(Shape::Mesh(instance), 0), object(plain, 1)]);
        let (mut greatest_deg, mut greatest_flat_deg): (f32, f32) = (0.0, 0.0);
        for (k, direction) in directions(2000).enumerate() {
            let centre = Vec3A::from(map.translation.as_vec3());
            let side = direction.any_orthonormal_vector() * (0.01 * (k % 40) as f32);
            let from_inside = k % 3 == 0;
            let origin = if from_inside { centre } else { centre + side - direction * 4.0 };
            let Some(hit) = objects.first_hit(&Ray::new(origin, direction)) else { continue };
            assert!(hit.shading_normal.is_normalized());
            assert!(hit.shading_normal.dot(hit.normal) > 0.0 && hit.shading_normal.dot(direction) < 0.0);
            // In object space the normal equals the point. The transform is the transform of normals.
            let on_sphere = map.inverse().transform_point3(hit.point.as_dvec3()).normalize();
            let normal = (map.matrix3.inverse().transpose() * on_sphere).normalize().as_vec3a();
            let normal = if from_inside { -normal } else { normal };
            if normal.dot(direction) < -0.2 {
                greatest_deg = greatest_deg.max(hit.shading_normal.angle_between(normal).to_degrees());
                greatest_flat_deg = greatest_flat_deg.max(hit.normal.angle_between(normal).to_degrees());
            }
        }
        assert!(greatest_deg < 1.0 && greatest_flat_deg > 2.0, "{greatest_deg} {greatest_flat_deg}");
        let on_box = Ray::new(Vec3A::new(20.1, 0.2, 4.0), Vec3A::NEG_Z);
        let hit = objects.first_hit(&on_box).unwrap();
        assert_eq!((hit.object, hit.shading_normal), (1, hit.normal));
    }

    /// A normal of a file that points away from the viewer cannot be used.
    #[test]
    fn a_shading_normal_that_faces_away_gives_way_to_the_geometric_one() {
        let normals = VertexNormals::new([Vec3::new(-0.9, 0.0, 0.2); 3]);
        let mesh = TriangleMesh::from_triangles(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]);
        let mesh = MeshBvh::new(TriangleMesh { normals, ..mesh });
        let instance = Instance::new(mesh.into(), Transform::new(&DAffine3::IDENTITY).unwrap());
        let objects = Objects::new(vec![object(Shape::Mesh(instance), 0)]);
        let from = |origin: Vec3A| {
            let direction = (Vec3A::new(0.3, 0.3, 0.0) - origin).normalize();
            objects.first_hit(&Ray::new(origin, direction)).unwrap().shading_normal
        };
        let slanted = Vec3A::new(-0.9, 0.0, 0.2).normalize();
        assert!(from(Vec3A::new(-1.0, 0.3, 0.5)).abs_diff_eq(slanted, 1e-6));
        assert_eq!(from(Vec3A::new(1.6, 0.3, 0.2)), Vec3A::Z);
        assert!(from(Vec3A::new(1.6, 0.3, -0.2)).abs_diff_eq(-slanted, 1e-6), "seen from the other side");
    }

    #[test]
    fn few_objects_and_many_answer_alike() {
        for count in [3, 40] {
            let objects = Objects::new(row(count));
            let from_left = Ray::new(Vec3A::new(-5.0, 0.1, 0.2), Vec3A::X);
            let hit = objects.first_hit(&from_left).unwrap();
            assert_eq!((hit.object, hit.material), (0, 0));
            assert!((hit.point.x + 0.5).abs() < 1e-6 && (hit.normal.x + 1.0).abs() < 1e-6);
            let last = (count - 1) as f32;
            let from_right = Ray::new(Vec3A::new(2.0 * last + 5.0, 0.1, 0.2), Vec3A::NEG_X);
            assert_eq!(objects.first_hit(&from_right).unwrap().object, count - 1);
            assert!(objects.any_hit(&from_left, 4.6) && !objects.any_hit(&from_left, 4.4));
            let between = Ray::new(Vec3A::new(1.0, -3.0, 0.0), Vec3A::Y);
            assert!(objects.first_hit(&between).is_none() && !objects.any_hit(&between, 99.0));
        }
    }

    #[test]
    fn a_plane_hides_and_is_hidden_among_few_and_many() {
        for count in [3, 40] {
            let mut all = row(count);
            all.push(object(Shape::Plane(Plane::new(Vec3A::new(0.0, 0.0, -2.0), Mat3A::IDENTITY)), count));
            let objects = Objects::new(all);
            let down = |x: f32| Ray::new(Vec3A::new(x, 0.1, 3.0), Vec3A::NEG_Z);
            assert_eq!(objects.first_hit(&down(0.2)).unwrap().object, 0);
            assert_eq!(objects.first_hit(&down(1.0)).unwrap().object, count);
            assert!(objects.any_hit(&down(1.0), 5.1) && !objects.any_hit(&down(1.0), 4.9));
            let up = Ray::new(Vec3A::new(0.2, 0.1, -4.0), Vec3A::Z);
            assert_eq!(objects.first_hit(&up).unwrap().object, count);
        }
    }

    #[test]
    fn objects_of_a_body_are_crossed_as_one_and_do_not_hide_each_other() {
        let mut all = row(3);
        for (object, body) in all.iter_mut().zip(["wall", "wall", "other"]) {
            object.body = Some(body.to_owned());
        }
        let objects = Objects::new(all);
        let ray = Ray::new(Vec3A::new(-0.5, 0.1, 0.2), Vec3A::X);
        let mut crossings = Vec::new();
        assert!(!objects.segments(1, &ray, f32::INFINITY, &mut crossings));
        let crossed: Vec<_> = crossings.iter().map(|crossing| crossing.object).collect();
        assert_eq!(crossed, [0, 0, 1, 1]);
        let beyond = Ray::new(Vec3A::new(0.6, 0.1, 0.2), Vec3A::X);
        assert!(objects.any_hit(&beyond, 2.5));
        let occluded =
            |limit_m| objects.occluded_by(&beyond, limit_m, |index| objects.can_occlude(index, Side::Inner(0)));
        assert!(!occluded(2.5), "the second block of the wall does not count");
        assert!(occluded(3.5), "another body does");
        assert!(objects.holds(1, Vec3A::new(2.2, 0.3, -0.4)) && !objects.holds(1, Vec3A::new(2.2, 0.6, -0.4)));
    }
}
