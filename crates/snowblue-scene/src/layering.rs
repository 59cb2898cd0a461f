//! Positions of the layers of snow in a body: at depths below the surface of the body, or below a height.

use std::cell::RefCell;

use glam::{DVec3, Vec3A};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_base::{Number, narrow};
use snowblue_geometry::ray::{Crossing, Ray, SurfacePoint};
use snowblue_transport::stack::Layer;

use crate::objects::Objects;
use crate::values::{AnyOf, Coordinate, Notations};

/// Distance inside the surface, in m, at which the layer of a surface point is looked up. The distance is far above
/// the rounding of coordinates of 100 m, and far below the thickness of a layer.
const INSET_M: f32 = 1e-4;

/// Where the first layer of snow begins, from which all depths count vertically.
#[derive(Debug, Clone, Copy, PartialEq, Default, JsonSchema)]
#[schemars(with = "AnyOf<String, Number<Coordinate>>")]
pub enum LayersTop {
    /// At the topmost surface of the body above each point: layers follow the terrain.
    #[default]
    Surface,
    /// At a height z, in m: layers are horizontal, and snow above is of the first.
    Height(Number<Coordinate>),
}

impl Serialize for LayersTop {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Surface => serializer.serialize_str("surface"),
            Self::Height(height_m) => height_m.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for LayersTop {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations::<Coordinate, 0, _> {
            expected: "\"surface\" or a height in m",
            number: Some(Self::Height),
            word: Some(|word| match word {
                "surface" => Ok(Self::Surface),
                other => Err(format!("is \"{other}\", but must be \"surface\" or a height in m")),
            }),
            list: None,
        })
    }
}

/// The depths of layers.
#[derive(Debug, Clone, PartialEq)]
pub struct Layering {
    /// Depth of the lower end of each layer except the last, in m, top first. The last layer has no lower end.
    ends_m: Vec<f64>,
    top: LayersTop,
}

thread_local! {
    /// Buffer for the crossings of a line.
    static CROSSINGS: RefCell<Vec<Crossing>> = const { RefCell::new(Vec::new()) };
}

/// Depth of a point in the body of an object below the body's topmost surface above the point, in m; 0 if there is no
/// surface above the point. For an object with prints, depth counts from the surface before the prints were made.
pub(crate) fn depth_below_surface(objects: &Objects, object: usize, point: Vec3A) -> f32 {
    let undisturbed = objects.list()[object].undisturbed.as_ref();
    if let Some(height_m) = undisturbed.and_then(|surface| surface.height_m(point.x, point.y)) {
        return (height_m - point.z).max(0.0);
    }
    let up = Ray::new(point, Vec3A::Z);
    CROSSINGS.with_borrow_mut(|crossings| {
        objects.segments(object, &up, f32::INFINITY, crossings);
        crossings.iter().map(|crossing| crossing.distance_m).fold(0.0, f32::max)
    })
}

impl Layering {
    /// The depths of layers, top first.
    pub(crate) fn new(layers: &[Layer], top: LayersTop) -> Self {
        let end_m = |depth_m: &mut f64, layer: &Layer| {
            *depth_m += 0.01 * layer.thickness_cm;
            Some(*depth_m)
        };
        let mut ends_m: Vec<f64> = layers.iter().scan(0.0, end_m).collect();
        ends_m.pop();
        Self { ends_m, top }
    }

    /// The depths at which each layer begins and ends, in m. The first layer begins at −∞, and the last layer ends at
    /// ∞.
    pub(crate) fn ranges_m(&self) -> impl Iterator<Item = [f64; 2]> {
        let starts = [f64::NEG_INFINITY].into_iter().chain(self.ends_m.iter().copied());
        let ends = self.ends_m.iter().copied().chain([f64::INFINITY]);
        starts.zip(ends).map(|(start, end)| [start, end])
    }

    /// The number of the layer at a point of the surface of the body of an object.
    pub(crate) fn at_surface(&self, objects: &Objects, object: usize, surface: &SurfacePoint) -> usize {
        self.at_point(objects, object, surface.point - surface.normal * INSET_M)
    }

    /// The number of the layer at a point in the body of an object.
    pub(crate) fn at_point(&self, objects: &Objects, object: usize, point: Vec3A) -> usize {
        if self.ends_m.is_empty() {
            return 0;
        }
        let depth_m = self.depth_m(objects, object, point);
        self.ends_m.partition_point(|end_m| *end_m <= depth_m)
    }

    /// Depth of a point below the top of the layers, in m.
    fn depth_m(&self, objects: &Objects, object: usize, point: Vec3A) -> f64 {
        match self.top {
            LayersTop::Surface => depth_below_surface(objects, object, point).into(),
            LayersTop::Height(height_m) => height_m.get() - f64::from(point.z),
        }
    }

    /// The share of each layer in the snow of a box, given by centre and size in m, along vertical lines through the
    /// box. The shares add up to 1.
    pub(crate) fn shares(&self, objects: &Objects, object: usize, [centre, size]: [DVec3; 2]) -> Vec<f32> {
        /// Number of lines along each side: more lines if none of the few lines meets the snow.
        const LINES: [u32; 2] = [2, 4];
        let mut lengths_m = vec![0.0; self.ends_m.len() + 1];
        for lines in LINES {
            let place = |line: u32| (f64::from(line) + 0.5) / f64::from(lines) - 0.5;
            for line in 0..lines * lines {
                let offset = DVec3::new(place(line % lines), place(line / lines), -0.5);
                let bottom = (centre + size * offset).as_vec3a();
                self.add_lengths(objects, object, (bottom, size.z), &mut lengths_m);
            }
            let total_m: f64 = lengths_m.iter().sum();
            if total_m > 0.0 {
                return lengths_m.iter().map(|length_m| narrow(length_m / total_m)).collect();
            }
        }
        // A box with so little snow has a negligible weight.
        let mut top = vec![0.0; lengths_m.len()];
        top[0] = 1.0;
        top
    }

    /// Adds the length of a vertical line in each layer, in m.
    fn add_lengths(&self, objects: &Objects, object: usize, (bottom, height_m): (Vec3A, f64), lengths_m: &mut [f64]) {
        let depth_m = self.depth_m(objects, object, bottom);
        let up = Ray::new(bottom, Vec3A::Z);
        CROSSINGS.with_borrow_mut(|crossings| {
            objects.segments(object, &up, f32::INFINITY, crossings);
            for segment in crossings.chunks_exact(2) {
                // Depths of the upper and the lower end.
                let [low_m, high_m] = [0, 1].map(|end| f64::from(segment[end].distance_m).clamp(0.0, height_m));
                let (first_m, last_m) = (depth_m - high_m, depth_m - low_m);
                for (length_m, [start_m, end_m]) in lengths_m.iter_mut().zip(self.ranges_m()) {
                    *length_m += (last_m.min(end_m) - first_m.max(start_m)).max(0.0);
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use snowblue_base::files::FilesInMemory;
    use snowblue_transport::layer_file::LayerFile;

    use super::*;
    use crate::scene_file::SceneFile;

    const HEAD: &str = "[camera]\nposition = [0, -3, 0]\nlook_at = [0, 0, 0]\n\
        [material.pack]\ntype = \"snow\"\nlayers = \"pack.toml\"\n";
    /// A crust over depth hoar.
    const PACK: &str = "[[layer]]\nthickness_cm = 2\ngrain_size_um = 200\ndensity_kg_m3 = 350\n\
        [[layer]]\nthickness_cm = 8\ngrain_size_um = 800\ndensity_kg_m3 = 250\n";

    #[test]
    fn layers_of_clear_ice_are_refused() {
        let pack = format!("{PACK}[[layer]]\nkind = \"ice\"\nthickness_cm = 1\n");
        let files = FilesInMemory::from([("pack.toml", &*pack)]);
        let body = "[[object]]\nshape = \"box\"\nsize = [1, 1, 1]\nmaterial = \"pack\"\n";
        let file = SceneFile::parse(format!("{HEAD}{body}"), "scene.toml").unwrap();
        let message = file.description.build(&files).err().unwrap().to_string();
        assert!(message.contains("pack.toml:9") && message.contains("clear ice"), "{message}");
    }

    /// Two steps of a stair, as one body. Depth counts from the step above the point, also through a gap.
    #[test]
    fn depth_follows_the_terrain_or_a_height() {
        let step = |x: f64, top: f64| {
            format!(
                "[[object]]\nshape = \"box\"\nsize = [0.2, 0.2, 0.1]\nposition = [{x}, 0, {}]\nmaterial = \"pack\"\n\
                 body = \"stair\"\n",
                top - 0.05
            )
        };
        let lamp = "[[light]]\ntype = \"point\"\nposition = [0, 0, 3]\nradiant_intensity_w_sr = 5\n";
        let text = format!("{HEAD}{lamp}{}{}{}", step(0.0, 0.0), step(0.2, 0.06), step(0.2, 0.2));
        let files = FilesInMemory::from([("pack.toml", PACK)]);
        let scene = SceneFile::parse(text, "scene.toml").unwrap().description.build(&files).unwrap();
        let objects = scene.objects();
        let depth_m = |x: f32, z: f32| depth_below_surface(objects, 0, Vec3A::new(x, 0.01, z));
        for (x, z, expected) in [(0.0, -0.03, 0.03), (0.2, -0.03, 0.23), (0.2, 0.15, 0.05), (0.0, 0.01, 0.0)] {
            assert!((depth_m(x, z) - expected).abs() < 1e-6, "{x} {z}: {}", depth_m(x, z));
        }
        let layers = LayerFile::parse(PACK).unwrap().layers;
        // A cell from z = −0.035 to −0.005 in the lower step. The upper half of its snow is crust.
        let (centre, size) = (DVec3::new(0.0, 0.0, -0.02), DVec3::new(0.02, 0.02, 0.03));
        let cell = [centre, size];
        let raised = [centre + DVec3::Z * 0.015, size];
        let beside = [DVec3::new(-0.104, 0.0, -0.02), size];
        for (top, cell, crust) in [
            (LayersTop::Surface, cell, 0.5),
            (LayersTop::Height(Number::of(0.0)), cell, 0.5),
            (LayersTop::Height(Number::of(-0.01)), cell, 5.0 / 6.0),
            // The lower two thirds of this cell are snow.
            (LayersTop::Surface, raised, 1.0),
            // Less than a third of this cell is snow.
            (LayersTop::Surface, beside, 0.5),
        ] {
            let shares = Layering::new(&layers, top).shares(objects, 0, cell);
            assert!(
                (shares[0] - crust).abs() < 1e-4 && (shares[0] + shares[1] - 1.0).abs() < 1e-6,
                "{top:?}: {shares:?}"
            );
        }
    }
}
