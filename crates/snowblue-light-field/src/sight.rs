//! The places that a camera sees, and the cell sizes that suffice for its picture.
//!
//! Snow that is not seen matters only by the light that it sends to places that are seen. Its cells may be as wide as
//! a fraction of the distance to these places.

use std::sync::OnceLock;

use glam::DVec3;
use snowblue_field::{CellSizes, SizeLimits, SizesByDistance};
use snowblue_scene::Scene;
use snowblue_scene::camera::PerspectiveCamera;
use snowblue_scene::seen::{MIN_ROWS, SIZE_PER_DISTANCE, SeenPlaces};

/// Greatest size of the cells at the surface that follow the picture, in m, and as a share of the extent of the body;
/// the larger size counts.
const MAX_CELL_M: f64 = 1.0;
const MAX_CELL_SHARE: f64 = 1.0 / 32.0;
/// Pixels of a picture that a cell of a body that is not wide may span.
const PIXELS: f64 = 2.0;

/// The sizes of cells for the pictures of a scene's camera.
pub(crate) struct Sight<'a> {
    scene: &'a Scene,
    /// The camera; none if the scene is only baked.
    camera: Option<&'a PerspectiveCamera>,
    /// Whether only this camera is used. Snow that it does not see then has larger cells.
    has_one_view: bool,
    seen: OnceLock<SeenPlaces>,
}

impl<'a> Sight<'a> {
    /// The sizes of cells for the camera of a scene, and for no other camera if `has_one_view` holds.
    pub(crate) fn new(scene: &'a Scene, has_one_view: bool) -> Self {
        Self { scene, camera: scene.camera().ok(), has_one_view, seen: OnceLock::new() }
    }

    /// Sizes of the cells of a wide body of an extent in m, of snow with a transport mean free path in m.
    /// Without a camera, all cells at the surface have the size `even_m`, in m.
    pub(crate) fn sizes_of_wide(&self, extent_m: f64, transport_length_m: f64, even_m: f64) -> SizesBySight<'_> {
        let greatest_m = if self.camera.is_some() { greatest_cell_m(extent_m) } else { even_m };
        let sizes = SizesByDistance::of_picture(self.viewpoint(), self.pixel_rad(), greatest_m, transport_length_m);
        SizesBySight { sizes, seen: self.seen(), greatest_m }
    }

    /// Sizes of the cells of a body that is not wide, with an extent in m; none if all cells at its surface have one
    /// size. Visible cells are at most `greatest_m` wide, in m.
    pub(crate) fn sizes(&self, extent_m: f64, greatest_m: f64) -> Option<SizesBySight<'_>> {
        let sizes_per_distance = [PIXELS * self.pixel_rad(); 3];
        let sizes = SizesByDistance { viewpoint: self.viewpoint(), sizes_per_distance, greatest_m, thin_below_m: 0.0 };
        Some(SizesBySight { sizes, seen: Some(self.seen()?), greatest_m: greatest_cell_m(extent_m) })
    }

    /// The places that the camera sees, if it is the only one.
    fn seen(&self) -> Option<&SeenPlaces> {
        let camera = self.camera.filter(|_| self.has_one_view)?;
        Some(self.seen.get_or_init(|| SeenPlaces::of(self.scene.objects(), self.scene.materials(), camera)))
    }

    /// The position of the camera, in m; infinitely far away without a camera.
    fn viewpoint(&self) -> DVec3 {
        self.camera.map_or(DVec3::INFINITY, |camera| camera.view().position.as_dvec3())
    }

    /// Angle of a pixel, in rad; any angle without a camera.
    fn pixel_rad(&self) -> f64 {
        let rows = self.scene.film().height.get().max(MIN_ROWS);
        let fov_deg = self.camera.map_or(1.0, |camera| camera.view().vertical_fov_deg);
        f64::from(fov_deg.to_radians()) / f64::from(rows)
    }
}

/// Greatest size of the cells at the surface of a body of an extent in m.
fn greatest_cell_m(extent_m: f64) -> f64 {
    MAX_CELL_M.max(extent_m * MAX_CELL_SHARE)
}

/// A rule with the sizes of another rule at places that are seen. Elsewhere sizes increase with the distance to these
/// places.
#[derive(Debug)]
pub(crate) struct SizesBySight<'a> {
    /// The sizes where everything is seen.
    sizes: SizesByDistance,
    /// The places that are seen; if none, everything counts as seen.
    seen: Option<&'a SeenPlaces>,
    /// The greatest size, in m.
    greatest_m: f64,
}

impl CellSizes for SizesBySight<'_> {
    fn least_between(&self, low: DVec3, high: DVec3) -> SizeLimits {
        let hidden_m = self.seen.map_or(0.0, |seen| SIZE_PER_DISTANCE * seen.distance_m(low, high, 0.0));
        self.sizes.least_between(low, high).map(|size_m| size_m.max(hidden_m.min(self.greatest_m)))
    }

    fn thin_below_m(&self) -> f64 {
        self.sizes.thin_below_m
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
            sizes_per_distance: [0.005, 0.01, 0.02],
            greatest_m: 0.5,
            thin_below_m: 0.1,
        };
        let sizes = SizesBySight { sizes, seen: Some(&seen), greatest_m: MAX_CELL_M };
        let at = |y: f64| sizes.least_between(DVec3::new(0.0, y, 0.0), DVec3::new(0.0, y, 0.0));
        assert_eq!(at(2.0), SizeLimits { flat_m: 0.04, detailed_m: 0.02, thin_m: 0.01 });
        // Half a metre behind the place that is seen.
        assert_eq!(at(2.5), SizeLimits { flat_m: 0.0625, detailed_m: 0.0625, thin_m: 0.0625 });
        assert_eq!(at(100.0), SizeLimits { flat_m: 1.0, detailed_m: 1.0, thin_m: 1.0 });
    }
}
