//! Places on the objects of a scene that a camera sees, and the distances to these places.

use arrayvec::ArrayVec;
use glam::DVec3;
use rayon::prelude::*;

use crate::camera::PerspectiveCamera;
use crate::material::Material;
use crate::objects::Objects;
use crate::queries::SceneQueries;

/// Number of camera rays along each side of the picture that find visible places.
pub const RAYS: u16 = 256;
/// A picture of fewer rows gets the cells and triangles of a picture of this number of rows. With the cells of a
/// picture of 32 rows, the wall of a snow hut would be thinner than a cell.
pub const MIN_ROWS: u32 = 240;
/// Greatest size of an invisible cell or edge, over its distance to the nearest visible place.
pub const SIZE_PER_DISTANCE: f64 = 0.125;
/// Greatest number of places in a leaf of the tree.
const LEAF: usize = 8;
/// More than the number of levels of the tree. Each level halves the number of places.
const MAX_LEVELS: usize = 64;

/// Places that a camera sees, in a tree of boxes.
#[derive(Debug)]
pub struct SeenPlaces {
    places: Vec<DVec3>,
    /// The first box is the root.
    boxes: Vec<PlaceBox>,
}

/// A box around some places.
#[derive(Debug, Clone, Copy)]
struct PlaceBox {
    low: DVec3,
    high: DVec3,
    /// For a leaf, the index of the first of its places; otherwise the index of the first of its two children.
    first: usize,
    /// For a leaf, the number of its places; otherwise 0.
    count: usize,
}

impl SeenPlaces {
    /// The places on objects that a camera sees, straight on through transparent surfaces.
    pub fn of(objects: &Objects, materials: &[Material], camera: &PerspectiveCamera) -> Self {
        let at = |k: u16| (f32::from(k) + 0.5) / f32::from(RAYS);
        let of_row = |row: u16| -> Vec<DVec3> {
            let queries = SceneQueries::new(objects, materials);
            let hits = (0..RAYS).filter_map(|column| queries.hit(&mut camera.ray(at(column), at(row)), || 0.0, |_| {}));
            hits.map(|hit| hit.point.as_dvec3()).collect()
        };
        let rows: Vec<Vec<DVec3>> = (0..RAYS).into_par_iter().map(of_row).collect();
        Self::of_places(rows.concat())
    }

    /// A tree of given places.
    pub fn of_places(mut places: Vec<DVec3>) -> Self {
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

    /// The distance in m from the box between two corners to the nearest place; infinite if no place is visible. If a
    /// place lies within `near_m`, the distance is that to such a place, which need not be the nearest.
    pub fn distance_m(&self, low: DVec3, high: DVec3, near_m: f64) -> f64 {
        let mut least = f64::INFINITY;
        let with_distance = |index: usize| (self.boxes[index].distance_squared(low, high), index);
        let mut stack = ArrayVec::<_, MAX_LEVELS>::from_iter([with_distance(0)]);
        while let Some((nearest, index)) = stack.pop() {
            if least <= near_m * near_m {
                break;
            }
            if nearest >= least {
                continue;
            }
            let PlaceBox { first, count, .. } = self.boxes[index];
            if count > 0 {
                let places = self.places[first..first + count].iter();
                least = places.map(|place| place.distance_squared(place.clamp(low, high))).fold(least, f64::min);
            } else {
                // The nearer child is visited first.
                let [one, other] = [0, 1].map(|child| with_distance(first + child));
                stack.extend(if one.0 < other.0 { [other, one] } else { [one, other] });
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
            assert!((seen.distance_m(low, high, 0.0) - nearest).abs() < 1e-12, "{low} {high}");
            let near_m = 0.1;
            let found = seen.distance_m(low, high, near_m);
            assert!(if nearest <= near_m { found <= near_m } else { (found - nearest).abs() < 1e-12 }, "{low} {high}");
        }
        assert!(SeenPlaces::of_places(Vec::new()).distance_m(DVec3::ZERO, DVec3::ONE, 0.0).is_infinite());
    }
}
