//! Where the layers of snow in a body lie: at depths below its surface, or below a height.

use std::cell::RefCell;

use glam::{DVec3, Vec3A};
use snowblue_field::CellBox;
use snowblue_geometry::body::pair_up;
use snowblue_geometry::ray::{Crossing, Ray, SurfacePoint, narrow};
use snowblue_transport::stack::Layer;

use crate::scene::description::LayersTop;
use crate::scene::objects::Objects;

/// How far inside the surface, in m, its layer is looked up: far above the rounding of coordinates of 100 m, and far
/// below the thickness of a layer.
const INSET_M: f32 = 1e-4;

/// The depths of layers.
#[derive(Debug, Clone, PartialEq)]
pub struct Layering {
    /// Depth of the lower end of each layer but the last, in m, top first. The last layer goes on below.
    ends_m: Vec<f64>,
    top: LayersTop,
}

thread_local! {
    /// Buffer for the crossings of a line.
    static CROSSINGS: RefCell<Vec<Crossing>> = const { RefCell::new(Vec::new()) };
}

/// Depth of a point in the body of an object below the body's topmost surface above the point, in m; 0 if there is
/// none. Of an object with prints it is the surface before they were pressed into it.
pub(crate) fn depth_below_surface(objects: &Objects, object: usize, point: Vec3A) -> f32 {
    let undisturbed = objects.list()[object].undisturbed.as_ref();
    if let Some(height_m) = undisturbed.and_then(|surface| surface.height_m(point.x, point.y)) {
        return (height_m - point.z).max(0.0);
    }
    let up = Ray { origin: point, direction: Vec3A::Z };
    CROSSINGS.with_borrow_mut(|crossings| {
        objects.crossings(object, &up, f32::INFINITY, crossings);
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

    /// The depths at which each layer begins and ends, in m; the first begins above all, and the last ends below.
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
            LayersTop::Height(height_m) => height_m - f64::from(point.z),
        }
    }

    /// The share of each layer in the snow of a cell, along vertical lines through the cell. The shares add up to 1.
    pub(crate) fn shares(&self, objects: &Objects, object: usize, cell: &CellBox) -> Vec<f32> {
        /// Lines along each side: more where few meet the snow.
        const LINES: [u32; 2] = [2, 4];
        let mut lengths_m = vec![0.0; self.ends_m.len() + 1];
        for lines in LINES {
            let place = |line: u32| (f64::from(line) + 0.5) / f64::from(lines) - 0.5;
            for line in 0..lines * lines {
                let offset = DVec3::new(place(line % lines), place(line / lines), -0.5);
                let bottom = (cell.centre + cell.size * offset).as_vec3a();
                self.add_lengths(objects, object, (bottom, cell.size.z), &mut lengths_m);
            }
            let total_m: f64 = lengths_m.iter().sum();
            if total_m > 0.0 {
                return lengths_m.iter().map(|length_m| narrow(length_m / total_m)).collect();
            }
        }
        // A cell with so little snow has next to no weight.
        let mut top = vec![0.0; lengths_m.len()];
        top[0] = 1.0;
        top
    }

    /// Adds the length of a vertical line in each layer, in m.
    fn add_lengths(&self, objects: &Objects, object: usize, (bottom, height_m): (Vec3A, f64), lengths_m: &mut [f64]) {
        let depth_m = self.depth_m(objects, object, bottom);
        let up = Ray { origin: bottom, direction: Vec3A::Z };
        CROSSINGS.with_borrow_mut(|crossings| {
            objects.crossings(object, &up, f32::INFINITY, crossings);
            pair_up(crossings, 0);
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
