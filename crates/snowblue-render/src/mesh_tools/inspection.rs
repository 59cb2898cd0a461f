//! The solids of a scene looked at one by one, without light: their size, whether they are closed, and whether random
//! lines find them so.

use glam::Vec3A;

use crate::geometry::bounds::Bounds;
use crate::geometry::ray::Ray;
use crate::geometry::shape::Shape;
use crate::mesh_tools::topology::{Topology, volume};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::scene::material::Material;
use crate::scene::objects::Object;

/// Random lines tried through each object.
const LINES: u32 = 10_000;

/// What was found out about an object.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// What the scene calls it.
    pub name: String,
    /// Whether it is snow, which should be watertight.
    pub is_snow: bool,
    /// Its axis-parallel extent in m; none for an endless plane.
    pub size_m: Option<Vec3A>,
    /// Its volume in m³; none where its surface is open, turned inside out in parts, or endless.
    pub volume_m3: Option<f64>,
    /// How its triangles hang together; without triangles for a shape that has none.
    pub topology: Topology,
    /// Of random lines through the ball around it those that crossed it.
    pub lines: u32,
    /// Of these, those that crossed it an odd number of times.
    pub odd_lines: u32,
}

impl Inspection {
    /// Whether depths through it are those of a solid.
    pub fn is_watertight(&self) -> bool {
        self.size_m.is_some() && self.topology.is_closed() && self.odd_lines == 0
    }
}

/// Looks at every object of a scene.
pub fn inspect(scene: &Scene) -> Vec<Inspection> {
    let is_snow = |object: &Object| matches!(scene.materials[object.material], Material::PcaSnow(_));
    let numbered = (0u32..).zip(scene.objects.list());
    numbered.map(|(number, object)| inspect_object(number, object, is_snow(object))).collect()
}

fn inspect_object(number: u32, object: &Object, is_snow: bool) -> Inspection {
    let (topology, volume_m3) = match &object.shape {
        Shape::Cuboid(cuboid) => (Topology::default(), Some(cuboid.volume_m3())),
        Shape::Ellipsoid(ellipsoid) => (Topology::default(), Some(ellipsoid.volume_m3())),
        Shape::Plane(_) => (Topology::default(), None),
        Shape::Mesh(instance) => {
            let surface = instance.mesh().source();
            let topology = Topology::of(surface);
            let whole = topology.is_closed() && topology.reversed_edges == 0;
            (topology, whole.then(|| volume(surface) * instance.placement().volume_factor()))
        }
    };
    let (lines, odd_lines) = try_lines(number, &object.shape);
    Inspection {
        name: object.name.clone(),
        is_snow,
        size_m: extent(&object.shape).map(|bounds| bounds.high - bounds.low),
        volume_m3,
        topology,
        lines,
        odd_lines,
    }
}

/// The box around a shape, for a mesh that of its triangles' corners: the box for tracing rays is wider.
fn extent(shape: &Shape) -> Option<Bounds> {
    let Shape::Mesh(instance) = shape else {
        return shape.bounds();
    };
    let surface = instance.mesh().source();
    let place = |&corner: &u32| instance.placement().point(surface.positions[corner as usize].into()).into();
    Some(Bounds::of(surface.corners.iter().flatten().map(place)))
}

/// How many of some random lines cross a shape, and how many of these an odd number of times.
fn try_lines(number: u32, shape: &Shape) -> (u32, u32) {
    let Some(bounds) = shape.bounds() else {
        return (0, 0);
    };
    let (centre, radius_m) = (0.5 * (bounds.low + bounds.high), 0.5 * bounds.diagonal_m());
    let (mut lines, mut odd, mut crossings) = (0, 0, Vec::new());
    for line in 0..LINES {
        let [a, b, c, d] = Sampler::new(1, number, line).next_four();
        let (from, to) = (on_sphere(a, b), on_sphere(c, d));
        let Some(direction) = (to - from).try_normalize() else {
            continue;
        };
        crossings.clear();
        shape.crossings(&Ray { origin: centre + radius_m * from, direction }, &mut crossings);
        lines += u32::from(!crossings.is_empty());
        odd += u32::from(crossings.len() % 2 == 1);
    }
    (lines, odd)
}

/// A point spread evenly over the unit sphere, from two numbers in [0, 1).
fn on_sphere(u: f32, v: f32) -> Vec3A {
    let z = 1.0 - 2.0 * u;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
    Vec3A::new(radius * cos, radius * sin, z)
}
