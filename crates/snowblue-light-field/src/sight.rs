//! What a camera sees, and the sizes of cells that suffice for its picture.
//!
//! Snow that is not seen matters by the light that it sends to places that are seen. Its cells may be as wide as a
//! fraction of the distance to them.

use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;
use snowblue_field::{CellSizes, SizeLimits, SizesByDistance};
use snowblue_scene::Scene;
use snowblue_scene::camera::PerspectiveCamera;
use snowblue_scene::objects::Objects;
use snowblue_scene::queries::SceneQueries;

/// Camera rays along each side of the picture that find what is seen.
const RAYS: u16 = 256;
/// Greatest size of a cell over its distance to the nearest place that is seen.
const SIZE_PER_DISTANCE: f64 = 0.125;
/// Greatest cells at the surface that follow the picture, in m.
const GREATEST_CELL_M: f64 = 1.0;
/// Pixels of a picture that a cell of a body that is not wide may span.
const PIXELS: f64 = 2.0;
/// A picture of fewer rows has the cells of one with so many: in one of 32, the wall of a snow hut would be thinner
/// than a cell.
const FEWEST_ROWS: u32 = 240;
/// Most places in a leaf of the tree.
const LEAF: usize = 8;

/// A camera, the fineness of its picture, and what it sees.
pub(crate) struct Sight<'a> {
    objects: &'a Objects,
    camera: &'a PerspectiveCamera,
    /// Angle of a pixel, in rad.
    pixel_rad: f64,
    seen: OnceLock<SeenPlaces>,
}

impl<'a> Sight<'a> {
    /// That of the camera of a scene.
    pub(crate) fn of(scene: &'a Scene) -> Self {
        let fov_rad = f64::from(scene.view().vertical_fov_deg.to_radians());
        let rows = scene.film().height.max(FEWEST_ROWS);
        let (objects, camera) = (scene.objects(), scene.camera());
        Self { objects, camera, pixel_rad: fov_rad / f64::from(rows), seen: OnceLock::new() }
    }

    /// Sizes of the cells of a wide body.
    pub(crate) fn sizes_of_wide(&self) -> SizesByDistance {
        SizesByDistance::of_picture(self.viewpoint(), self.pixel_rad, GREATEST_CELL_M)
    }

    /// Sizes of the cells of another body, in m, which are smaller than the greatest everywhere.
    pub(crate) fn sizes(&self, greatest_m: f64) -> SizesByDistance {
        let [detail_per_distance, flat_per_distance] = [PIXELS * self.pixel_rad; 2];
        SizesByDistance { viewpoint: self.viewpoint(), detail_per_distance, flat_per_distance, greatest_m }
    }

    /// The places that are seen.
    pub(crate) fn seen(&self) -> &SeenPlaces {
        self.seen.get_or_init(|| SeenPlaces::new(self.objects, self.camera))
    }

    fn viewpoint(&self) -> DVec3 {
        self.camera.position().as_dvec3()
    }
}

/// Places that a camera sees, in a tree of boxes.
#[derive(Debug)]
pub(crate) struct SeenPlaces {
    places: Vec<DVec3>,
    /// The first is the root.
    boxes: Vec<PlaceBox>,
}

/// A box around some places.
#[derive(Debug, Clone, Copy)]
struct PlaceBox {
    low: DVec3,
    high: DVec3,
    /// The first of its places if it is a leaf, otherwise the first of its two children.
    first: usize,
    /// How many places it has if it is a leaf, otherwise 0.
    count: usize,
}

impl SeenPlaces {
    fn new(objects: &Objects, camera: &PerspectiveCamera) -> Self {
        let at = |k: u16| (f32::from(k) + 0.5) / f32::from(RAYS);
        let of_row = |row: u16| -> Vec<DVec3> {
            let mut queries = SceneQueries::new(objects);
            let hits = (0..RAYS).filter_map(|column| queries.camera_hit(&camera.ray(at(column), at(row))));
            hits.map(|hit| hit.point.as_dvec3()).collect()
        };
        let rows: Vec<Vec<DVec3>> = (0..RAYS).into_par_iter().map(of_row).collect();
        Self::of_places(rows.concat())
    }

    fn of_places(mut places: Vec<DVec3>) -> Self {
        let mut boxes = vec![PlaceBox::around(&places, 0)];
        let mut next = 0;
        while let Some(PlaceBox { low, high, first, count }) = boxes.get(next).copied() {
            if count > LEAF {
                let size = high - low;
                let axis = size.max_position();
                let (half, own) = (count / 2, &mut places[first..first + count]);
                own.select_nth_unstable_by(half, |one, other| one[axis].total_cmp(&other[axis]));
                let (lower, upper) = own.split_at(half);
                let children = [PlaceBox::around(lower, first), PlaceBox::around(upper, first + half)];
                boxes[next] = PlaceBox { low, high, first: boxes.len(), count: 0 };
                boxes.extend(children);
            }
            next += 1;
        }
        Self { places, boxes }
    }

    /// The distance in m from the box between two corners to the nearest place; infinite if none is seen.
    fn distance_m(&self, low: DVec3, high: DVec3) -> f64 {
        let mut least = f64::INFINITY;
        let with_distance = |found: &PlaceBox| (found.distance_squared(low, high), *found);
        let mut stack = vec![with_distance(&self.boxes[0])];
        while let Some((nearest, PlaceBox { first, count, .. })) = stack.pop() {
            if nearest >= least {
                continue;
            }
            if count > 0 {
                let places = self.places[first..first + count].iter();
                least = places.map(|place| place.distance_squared(place.clamp(low, high))).fold(least, f64::min);
            } else {
                let mut children = [0, 1].map(|child| with_distance(&self.boxes[first + child]));
                // The nearer child is visited first.
                children.sort_by(|one, other| other.0.total_cmp(&one.0));
                stack.extend(children);
            }
        }
        least.sqrt()
    }
}

impl PlaceBox {
    fn around(places: &[DVec3], first: usize) -> Self {
        let bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [low, high] = places.iter().fold(bounds, |[low, high], place| [low.min(*place), high.max(*place)]);
        Self { low, high, first, count: places.len() }
    }

    /// Square of the distance to the box between two corners, in m².
    fn distance_squared(&self, low: DVec3, high: DVec3) -> f64 {
        (self.low - high).max(low - self.high).max(DVec3::ZERO).length_squared()
    }
}

/// The sizes of another rule at what is seen, and greater ones with the distance to it.
#[derive(Debug)]
pub(crate) struct SizesBySight<'a> {
    /// The sizes where all is seen.
    pub(crate) sizes: SizesByDistance,
    /// What is seen; all if none.
    pub(crate) seen: Option<&'a SeenPlaces>,
}

impl CellSizes for SizesBySight<'_> {
    fn least_between(&self, low: DVec3, high: DVec3) -> SizeLimits {
        let SizeLimits { flat_m, detailed_m } = self.sizes.least_between(low, high);
        let hidden_m = self.seen.map_or(0.0, |seen| SIZE_PER_DISTANCE * seen.distance_m(low, high));
        let hidden_m = hidden_m.min(GREATEST_CELL_M);
        SizeLimits { flat_m: flat_m.max(hidden_m), detailed_m: detailed_m.max(hidden_m) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_the_nearest_of_all_places() {
        let random =
            |seed: u32, axis: u32| f64::from((seed * 3 + axis).wrapping_mul(2_654_435_769) >> 8) / 16_777_216.0;
        let point = |seed: u32| DVec3::new(random(seed, 0), random(seed, 1), random(seed, 2));
        let places: Vec<DVec3> = (0..1000).map(point).collect();
        let seen = SeenPlaces::of_places(places.clone());
        for k in 0..200 {
            let low = 3.0 * point(5000 + k) - DVec3::ONE;
            let high = low + 0.2 * point(7000 + k);
            let nearest =
                places.iter().map(|place| place.distance(place.clamp(low, high))).fold(f64::INFINITY, f64::min);
            assert!((seen.distance_m(low, high) - nearest).abs() < 1e-12, "{low} {high}");
        }
        assert!(SeenPlaces::of_places(Vec::new()).distance_m(DVec3::ZERO, DVec3::ONE).is_infinite());
    }

    #[test]
    fn cells_are_small_where_the_picture_shows_them_and_grow_with_the_distance_from_there() {
        let seen = SeenPlaces::of_places(vec![DVec3::new(0.0, 2.0, 0.0)]);
        let sizes = SizesByDistance {
            viewpoint: DVec3::ZERO,
            detail_per_distance: 0.005,
            flat_per_distance: 0.02,
            greatest_m: 0.5,
        };
        let sizes = SizesBySight { sizes, seen: Some(&seen) };
        let at = |y: f64| sizes.least_between(DVec3::new(0.0, y, 0.0), DVec3::new(0.0, y, 0.0));
        assert_eq!(at(2.0), SizeLimits { flat_m: 0.04, detailed_m: 0.01 });
        // Half a metre behind it.
        assert_eq!(at(2.5), SizeLimits { flat_m: 0.0625, detailed_m: 0.0625 });
        assert_eq!(at(100.0), SizeLimits { flat_m: 1.0, detailed_m: 1.0 });
    }
}
