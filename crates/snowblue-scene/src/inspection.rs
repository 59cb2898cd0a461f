//! Checks of the objects of a scene: size, volume, topology, and crossings of random lines.

use glam::Vec3A;
use snowblue_geometry::body::pair_up;
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::ray::{Crossing, Ray};
use snowblue_geometry::shape::Shape;
use snowblue_geometry::topology::{Topology, volume};

use crate::Scene;
use crate::objects::Object;
use crate::sampling::Sampler;

/// Number of random lines through each object.
const LINES: u32 = 10_000;
/// Relative rounding error of sums of lengths.
const ROUNDING: f64 = 1e-4;

/// The checks of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// Name of the object in the scene.
    pub name: String,
    /// Whether the object is snow. Snow should be watertight.
    pub is_snow: bool,
    /// Axis-aligned extent in m; none for a plane.
    pub size_m: Option<Vec3A>,
    /// Volume in m³; none if the surface is open, inconsistently oriented or infinite.
    pub volume_m3: Option<f64>,
    /// Topology of the object's mesh. For other shapes, the topology is without triangles.
    pub topology: Topology,
    /// Number of random lines through the bounding sphere that crossed the object.
    pub lines: u32,
    /// Number of these lines that crossed the object an odd number of times.
    pub odd_lines: u32,
}

impl Inspection {
    /// Whether the object is a closed solid, so that depths through the object are well defined.
    pub fn is_watertight(&self) -> bool {
        self.size_m.is_some() && self.topology.is_closed() && self.odd_lines == 0
    }
}

/// Checks every object of a scene.
pub fn inspect(scene: &Scene) -> Vec<Inspection> {
    let is_snow = |object: &Object| scene.materials()[object.material].is_snow();
    let numbered = (0u32..).zip(scene.objects().list());
    numbered.map(|(number, object)| inspect_object(number, object, is_snow(object))).collect()
}

fn inspect_object(number: u32, object: &Object, is_snow: bool) -> Inspection {
    let lines = random_lines(number, &object.shape);
    let (topology, volume_m3) = match &object.shape {
        Shape::Cuboid(cuboid) => (Topology::default(), Some(cuboid.volume_m3())),
        Shape::Ellipsoid(ellipsoid) => (Topology::default(), Some(ellipsoid.volume_m3())),
        Shape::Plane(_) => (Topology::default(), None),
        Shape::Mesh(instance) => {
            let mesh = instance.mesh().triangles();
            let topology = Topology::of(mesh);
            let is_solid = topology.is_closed() && topology.reversed_edges == 0;
            let volume_m3 = || volume(mesh) * instance.transform().volume_scale() * lines.inside_per_wound();
            (topology, is_solid.then(volume_m3))
        }
    };
    Inspection {
        name: object.name.clone(),
        is_snow,
        size_m: extent(&object.shape).map(|bounds| bounds.high - bounds.low),
        volume_m3,
        topology,
        lines: lines.crossing,
        odd_lines: lines.odd,
    }
}

/// Tight bounds of a shape. The bounds of a mesh for ray tracing are padded.
fn extent(shape: &Shape) -> Option<Bounds> {
    let Shape::Mesh(instance) = shape else {
        return shape.bounds();
    };
    let mesh = instance.mesh().triangles();
    let corner = |&index: &u32| instance.transform().point_to_scene(mesh.positions[index as usize].into()).into();
    Some(Bounds::of(mesh.indices.iter().flatten().map(corner)))
}

/// Random lines through an object.
#[derive(Default)]
struct RandomLines {
    /// Number of lines that cross the object.
    crossing: u32,
    /// Number of these lines that cross the object an odd number of times.
    odd: u32,
    /// Length of these lines inside the object, in m.
    inside_m: f64,
    /// Their length inside times the winding number, which counts overlapping shells more than once, in m.
    wound_m: f64,
}

impl RandomLines {
    /// The volume of the inside as a share of the volume by the orientation of triangles. Lengths of random lines are
    /// proportional to volumes. Without overlapping shells it is 1.
    fn inside_per_wound(&self) -> f64 {
        let share = self.inside_m / self.wound_m.abs();
        if (share - 1.0).abs() < ROUNDING || !share.is_finite() { 1.0 } else { share }
    }
}

fn random_lines(number: u32, shape: &Shape) -> RandomLines {
    let mut lines = RandomLines::default();
    let Some(bounds) = shape.bounds() else {
        return lines;
    };
    let (centre, radius_m) = (0.5 * (bounds.low + bounds.high), 0.5 * bounds.diagonal_m());
    let mut crossings = Vec::new();
    for line in 0..LINES {
        let [a, b, c, d] = Sampler::new(1, number, line).next_four();
        let (from, to) = (on_sphere(a, b), on_sphere(c, d));
        let Some(direction) = (to - from).try_normalize() else {
            continue;
        };
        crossings.clear();
        shape.crossings(&Ray::new(centre + radius_m * from, direction), &mut crossings);
        lines.crossing += u32::from(!crossings.is_empty());
        lines.odd += u32::from(crossings.len() % 2 == 1);
        let signed_m =
            |crossing: &Crossing| f64::from(crossing.distance_m) * if crossing.is_entry { -1.0 } else { 1.0 };
        lines.wound_m += crossings.iter().map(signed_m).sum::<f64>();
        pair_up(&mut crossings, 0);
        let length_m = |[enter, leave]: &[Crossing; 2]| f64::from(leave.distance_m - enter.distance_m);
        lines.inside_m += crossings.as_chunks().0.iter().map(length_m).sum::<f64>();
    }
    lines
}

/// A uniformly distributed point on the unit sphere, from two uniform numbers.
fn on_sphere(u: f32, v: f32) -> Vec3A {
    let z = 1.0 - 2.0 * u;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
    Vec3A::new(radius * cos, radius * sin, z)
}
