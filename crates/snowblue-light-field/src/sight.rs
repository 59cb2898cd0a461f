//! The places that a camera sees, and the cell sizes that suffice for its picture.
//!
//! Snow that is not seen matters only by the light that it sends to places that are seen. Its cells may be as wide as
//! a fraction of the distance to these places.

use std::sync::OnceLock;

use glam::DVec3;
use snowblue_field::{CellSizes, SizeLimits, SizesByDistance};
use snowblue_scene::Scene;
use snowblue_scene::camera::PerspectiveCamera;
use snowblue_scene::objects::Objects;
use snowblue_scene::seen::{MIN_ROWS, SIZE_PER_DISTANCE, SeenPlaces};

/// Greatest size of the cells at the surface that follow the picture, in m.
const MAX_CELL_M: f64 = 1.0;
/// Number of cells of the greatest size along a body that is wider than this number of metres. A million lines pass
/// through all of these cells.
const MAX_CELLS_ALONG: f64 = 1000.0;
/// Pixels of a picture that a cell of a body that is not wide may span.
const PIXELS: f64 = 2.0;

/// A camera, the fineness of its picture, and what it sees.
pub(crate) struct CameraCells<'a> {
    objects: &'a Objects,
    camera: &'a PerspectiveCamera,
    /// Angle of a pixel, in rad.
    pixel_rad: f64,
    seen: OnceLock<SeenPlaces>,
}

impl<'a> CameraCells<'a> {
    /// The cell sizes for the camera of a scene.
    pub(crate) fn of(scene: &'a Scene) -> Self {
        let fov_rad = f64::from(scene.view().vertical_fov_deg.to_radians());
        let rows = scene.film().height.get().max(MIN_ROWS);
        let (objects, camera) = (scene.objects(), scene.camera());
        Self { objects, camera, pixel_rad: fov_rad / f64::from(rows), seen: OnceLock::new() }
    }

    /// Sizes of the cells of a wide body of an extent in m.
    pub(crate) fn sizes_of_wide(&self, extent_m: f64) -> SizesByDistance {
        SizesByDistance::of_picture(self.viewpoint(), self.pixel_rad, greatest_cell_m(extent_m))
    }

    /// Sizes of the cells of a body that is not wide, which are at most `greatest_m` everywhere, in m.
    pub(crate) fn sizes(&self, greatest_m: f64) -> SizesByDistance {
        let [detail_per_distance, flat_per_distance] = [PIXELS * self.pixel_rad; 2];
        SizesByDistance { viewpoint: self.viewpoint(), detail_per_distance, flat_per_distance, greatest_m }
    }

    /// The places that are seen.
    pub(crate) fn seen(&self) -> &SeenPlaces {
        self.seen.get_or_init(|| SeenPlaces::of(self.objects, self.camera))
    }

    fn viewpoint(&self) -> DVec3 {
        self.camera.position().as_dvec3()
    }
}

/// Greatest size of the cells at the surface of a body of an extent in m.
pub(crate) fn greatest_cell_m(extent_m: f64) -> f64 {
    MAX_CELL_M.max(extent_m / MAX_CELLS_ALONG)
}

/// A rule with the sizes of another rule at places that are seen. Elsewhere sizes increase with the distance to these
/// places.
#[derive(Debug)]
pub(crate) struct SizesBySight<'a> {
    /// The sizes where everything is seen.
    pub(crate) sizes: SizesByDistance,
    /// The places that are seen; if none, everything counts as seen.
    pub(crate) seen: Option<&'a SeenPlaces>,
    /// The greatest size, in m.
    pub(crate) greatest_m: f64,
}

impl CellSizes for SizesBySight<'_> {
    fn least_between(&self, low: DVec3, high: DVec3) -> SizeLimits {
        let SizeLimits { flat_m, detailed_m } = self.sizes.least_between(low, high);
        let hidden_m = self.seen.map_or(0.0, |seen| SIZE_PER_DISTANCE * seen.distance_m(low, high));
        let hidden_m = hidden_m.min(self.greatest_m);
        SizeLimits { flat_m: flat_m.max(hidden_m), detailed_m: detailed_m.max(hidden_m) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_small_where_the_picture_shows_them_and_grow_with_the_distance_from_there() {
        let seen = SeenPlaces::of_places(vec![DVec3::new(0.0, 2.0, 0.0)]);
        let sizes = SizesByDistance {
            viewpoint: DVec3::ZERO,
            detail_per_distance: 0.005,
            flat_per_distance: 0.02,
            greatest_m: 0.5,
        };
        let sizes = SizesBySight { sizes, seen: Some(&seen), greatest_m: greatest_cell_m(1.0) };
        let at = |y: f64| sizes.least_between(DVec3::new(0.0, y, 0.0), DVec3::new(0.0, y, 0.0));
        assert_eq!(at(2.0), SizeLimits { flat_m: 0.04, detailed_m: 0.01 });
        // Half a metre behind the place that is seen.
        assert_eq!(at(2.5), SizeLimits { flat_m: 0.0625, detailed_m: 0.0625 });
        assert_eq!(at(100.0), SizeLimits { flat_m: 1.0, detailed_m: 1.0 });
    }
}
