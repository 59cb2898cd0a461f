//! A camera with a thin lens, or a pinhole.
//!
//! A ray through a lens begins at a point of the lens disc. In the plane of focus it meets the ray through the middle
//! of the lens (M. Potmesil & I. Chakravarty 1981, *A lens and aperture camera model for synthetic image generation*,
//! SIGGRAPH, 297–305, doi:10.1145/800224.806818; R. L. Cook, T. Porter & L. Carpenter 1984, *Distributed ray
//! tracing*, SIGGRAPH, 137–145). A point at the distance z along the axis is seen as a disc. On an image plane at
//! distance 1, this disc is A |1/f − 1/z| wide, with the aperture A and the plane of focus at f.

use glam::Vec3A;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, ParameterRange, narrow, quantities};
use snowblue_geometry::ray::Ray;

use crate::sampling::concentric_disc;
use crate::values::{Coordinate, Direction, MAX_REACH_M, point, upwards};

quantities! {
    /// Angle between the upper and the lower edge of a picture.
    pub FieldOfView = ParameterRange::new("field of view", 0.1, 170.0, "°");
    /// Diameter of the aperture of a lens.
    pub Aperture = ParameterRange::new("aperture", 0.0, 10.0, "m");
    /// Distance of the plane of focus.
    pub FocusDistance = ParameterRange::new("distance of focus", MIN_FOCUS_M, MAX_REACH_M, "m");
}

/// A camera: a pinhole, or a thin lens.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraDescription {
    /// Position, in m.
    pub position: Numbers<Coordinate, 3>,
    /// The point in the middle of the picture, in m.
    pub look_at: Numbers<Coordinate, 3>,
    /// The direction that points upwards in the picture, of any length.
    #[serde(default = "upwards")]
    pub up: Numbers<Direction, 3>,
    /// Angle between the upper and the lower edge of the picture, in degrees.
    #[serde(default = "CameraDescription::default_vertical_fov_deg")]
    pub vertical_fov_deg: Number<FieldOfView>,
    /// Diameter of the aperture of the lens, in m; 0 for a pinhole, which sees everything sharp.
    #[serde(default)]
    pub aperture: Number<Aperture>,
    /// Distance of the plane of focus along the viewing axis, in m; the distance of `look_at` if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focus: Option<Number<FocusDistance>>,
}

impl CameraDescription {
    /// An upright pinhole camera with a field of view of 40°.
    pub fn new(position: Numbers<Coordinate, 3>, look_at: Numbers<Coordinate, 3>) -> Self {
        let vertical_fov_deg = Self::default_vertical_fov_deg();
        Self { position, look_at, up: upwards(), vertical_fov_deg, aperture: Number::default(), focus: None }
    }

    /// The lens in single precision.
    pub(crate) fn lens(&self) -> Lens {
        let focus_m = self.focus.map(|focus| narrow(focus.get()));
        Lens { aperture_m: narrow(self.aperture.get()), focus_m }
    }

    /// The camera with another view and its own lens. If the field of view of the other view is out of range, the
    /// camera keeps its own field of view.
    ///
    /// # Errors
    ///
    /// When a coordinate is out of range.
    pub(crate) fn with_view(&self, view: &View) -> Result<Self, snowblue_base::RangeError> {
        let wide = |vector: Vec3A| vector.as_dvec3().to_array();
        Ok(Self {
            position: Numbers::new(wide(view.position))?,
            look_at: Numbers::new(wide(view.look_at))?,
            up: Numbers::new(wide(view.up))?,
            vertical_fov_deg: Number::new(view.vertical_fov_deg.into()).unwrap_or(self.vertical_fov_deg),
            ..self.clone()
        })
    }

    fn default_vertical_fov_deg() -> Number<FieldOfView> {
        Number::of(40.0)
    }

    /// The view in single precision.
    pub(crate) fn view(&self) -> View {
        View {
            position: point(self.position),
            look_at: point(self.look_at),
            up: point(self.up),
            vertical_fov_deg: narrow(self.vertical_fov_deg.get()),
        }
    }

    /// Checks that the camera looks somewhere, and that a lens without a distance of focus is in focus at `look_at`.
    pub(crate) fn check(&self, path: &KeyPath) -> Result<(), KeyError> {
        let view = self.view();
        if PerspectiveCamera::new(&view, Lens::default(), 1.0).is_none() {
            return Err(path.key("look_at").error("must not lie at the camera's position or along its up axis"));
        }
        let distance_m = view.position.distance(view.look_at);
        if self.aperture.get() <= 0.0 || self.focus.is_some() || f64::from(distance_m) >= MIN_FOCUS_M {
            return Ok(());
        }
        Err(path.key("look_at").error(format!(
            "is {distance_m} m from the camera, but a lens focuses on {MIN_FOCUS_M} m and more: give 'focus'"
        )))
    }
}

/// A camera with a perspective view.
#[derive(Debug, Clone, Copy)]
pub struct PerspectiveCamera {
    view: View,
    forward: Vec3A,
    /// Vectors from the middle of the image plane at distance 1 to its right edge, and to its upper edge.
    right: Vec3A,
    up: Vec3A,
    /// The lens; none for a pinhole.
    lens: Option<LensDisc>,
}

/// The disc of a lens.
#[derive(Debug, Clone, Copy)]
struct LensDisc {
    /// Vectors from the middle of the lens to its edge, to the right and upwards in the image, in m.
    right: Vec3A,
    up: Vec3A,
    /// One over the distance of the plane of focus along the axis, in 1/m.
    inverse_focus_per_m: f32,
}

/// Least distance of the plane of focus, in m.
pub(crate) const MIN_FOCUS_M: f64 = 1e-3;

/// Aperture and focus. By default everything is in focus, as in a pinhole camera.
#[derive(Debug, Clone, Copy, Default)]
pub struct Lens {
    /// Diameter of the aperture, in m; 0 for a pinhole.
    pub aperture_m: f32,
    /// Distance of the plane of focus along the axis, in m; if none, the distance of the point at the centre of the
    /// image.
    pub focus_m: Option<f32>,
}

/// Position and orientation of a camera.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Position, in m.
    pub position: Vec3A,
    /// The point at the centre of the image, in m.
    pub look_at: Vec3A,
    /// The direction that is up in the image, of any length.
    pub up: Vec3A,
    /// Angle between the upper and the lower edge of the image, in degrees.
    pub vertical_fov_deg: f32,
}

impl PerspectiveCamera {
    /// A camera for images of a width-to-height ratio. None if `look_at` is the position or along the up direction.
    pub fn new(view: &View, lens: Lens, aspect: f32) -> Option<Self> {
        let ahead = view.look_at - view.position;
        let forward = ahead.try_normalize()?;
        let right = forward.cross(view.up.try_normalize()?);
        let right = (right.length() > 1e-6).then(|| right.normalize())?;
        let half_height = (0.5 * view.vertical_fov_deg.to_radians()).tan();
        let up = right.cross(forward);
        let radius_m = 0.5 * lens.aperture_m;
        let lens = (radius_m > 0.0).then(|| LensDisc {
            right: right * radius_m,
            up: up * radius_m,
            inverse_focus_per_m: lens.focus_m.unwrap_or(ahead.length()).max(narrow(MIN_FOCUS_M)).recip(),
        });
        Some(Self { view: *view, forward, right: right * (half_height * aspect), up: up * half_height, lens })
    }

    /// The view.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Distance of a point from the plane of the lens, along the viewing axis, in m.
    pub fn depth_m(&self, point: Vec3A) -> f32 {
        (point - self.view.position).dot(self.forward)
    }

    /// The ray through a point of the image and the middle of the lens: (0, 0) is the upper left corner and (1, 1) the
    /// lower right.
    #[inline]
    pub fn ray(&self, across: f32, down: f32) -> Ray {
        let direction = self.through(across, down);
        Ray::new(self.view.position, direction / direction.length())
    }

    /// The ray through a point of the image and a point of the lens, which two numbers in [0, 1) choose evenly.
    #[inline]
    pub fn lens_ray(&self, across: f32, down: f32, numbers: [f32; 2]) -> Ray {
        let Some(lens) = &self.lens else { return self.ray(across, down) };
        let [x, y] = concentric_disc(numbers);
        let offset = lens.right * x + lens.up * y;
        let direction = self.through(across, down) - offset * lens.inverse_focus_per_m;
        Ray::new(self.view.position + offset, direction / direction.length())
    }

    /// The change of the direction of a ray from one pixel to the next, to the right and downwards, in an image of
    /// `width` by `height` pixels, for a given point of the lens. The component of the change along the ray has no
    /// meaning.
    #[inline]
    pub fn change_per_pixel(&self, ray: &Ray, [width, height]: [u32; 2]) -> [Vec3A; 2] {
        // The change of a direction of length 1 along the axis, which a lens only shifts.
        let scale = 2.0 * ray.direction.dot(self.forward);
        [self.right * (scale / width as f32), self.up * (-scale / height as f32)]
    }

    /// Points on four rings of the lens, the last ring at its edge, in m; none for a pinhole.
    pub fn lens_points(&self) -> impl Iterator<Item = Vec3A> {
        const RINGS: u8 = 4;
        const POINTS: u8 = 16;
        let angles = (0..POINTS).map(|k| std::f32::consts::TAU * f32::from(k) / f32::from(POINTS));
        let ring = move |radius: f32| angles.clone().map(move |angle| (radius * angle.cos(), radius * angle.sin()));
        let places = (1..=RINGS).flat_map(move |k| ring(f32::from(k) / f32::from(RINGS)));
        let point = |lens: LensDisc| places.map(move |(x, y)| lens.right * x + lens.up * y);
        self.lens.map(point).into_iter().flatten().map(|offset| self.view.position + offset)
    }

    /// The direction through a point of the image, of length 1 along the axis.
    #[inline]
    fn through(&self, across: f32, down: f32) -> Vec3A {
        self.forward + self.right * (2.0 * across - 1.0) + self.up * (1.0 - 2.0 * down)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: View = View { position: Vec3A::NEG_Y, look_at: Vec3A::ZERO, up: Vec3A::Z, vertical_fov_deg: 90.0 };

    #[test]
    fn the_image_is_upright_and_not_mirrored() {
        let camera = PerspectiveCamera::new(&VIEW, Lens::default(), 2.0).unwrap();
        assert!((camera.ray(0.5, 0.5).direction - Vec3A::Y).length() < 1e-6);
        let top_right = camera.ray(1.0, 0.0).direction;
        assert!((top_right - Vec3A::new(2.0, 1.0, 1.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn a_view_along_up_or_without_a_direction_is_refused() {
        let camera = |view| PerspectiveCamera::new(&view, Lens::default(), 1.0);
        assert!(camera(View { up: Vec3A::NEG_Y, ..VIEW }).is_none());
        assert!(camera(View { look_at: Vec3A::NEG_Y, ..VIEW }).is_none());
    }

    #[test]
    fn rays_through_a_lens_meet_in_the_plane_of_focus() {
        for (focus_m, distance_m) in [(Some(2.5), 2.5), (None, 1.0)] {
            let camera = PerspectiveCamera::new(&VIEW, Lens { aperture_m: 0.3, focus_m }, 2.0).unwrap();
            let meets_at =
                |ray: Ray| ray.origin + ray.direction * ((distance_m - 1.0 - ray.origin.y) / ray.direction.y);
            let middle = meets_at(camera.ray(0.8, 0.3));
            for numbers in [[0.0, 0.0], [0.99, 0.2], [0.5, 0.5], [0.3, 0.9]] {
                let ray = camera.lens_ray(0.8, 0.3, numbers);
                assert!((meets_at(ray) - middle).length() < 1e-5, "{numbers:?}");
                assert!(
                    ray.origin.distance(VIEW.position) <= 0.15 + 1e-6 && (ray.direction.length() - 1.0).abs() < 1e-6
                );
            }
            let radii: Vec<f32> = camera.lens_points().map(|point| point.distance(VIEW.position)).collect();
            assert_eq!(radii.len(), 64);
            assert!(radii[..48].iter().all(|radius| *radius < 0.12));
            assert!(radii[48..].iter().all(|radius| (radius - 0.15).abs() < 1e-6));
        }
    }

    /// The difference of the rays through neighbouring pixels, across the ray, is met within 1 % for pixels of 1/200.
    #[test]
    fn rays_change_from_pixel_to_pixel() {
        let size = [400, 200];
        for aperture_m in [0.0, 0.1] {
            let camera = PerspectiveCamera::new(&VIEW, Lens { aperture_m, focus_m: Some(3.0) }, 2.0).unwrap();
            for (across, down) in [(0.5, 0.5), (0.9, 0.2)] {
                let at = |x: f32, y: f32| camera.lens_ray(across + x / 400.0, down + y / 200.0, [0.3, 0.8]);
                let ray = at(0.0, 0.0);
                let changes = camera.change_per_pixel(&ray, size);
                for (change, next) in changes.into_iter().zip([at(1.0, 0.0), at(0.0, 1.0)]) {
                    let across_ray = |vector: Vec3A| vector - ray.direction * ray.direction.dot(vector);
                    let expected = across_ray(next.direction - ray.direction);
                    let difference = across_ray(change) - expected;
                    assert!(difference.length() < 0.01 * expected.length(), "{change} {expected}");
                }
            }
        }
    }

    #[test]
    fn a_pinhole_has_one_ray_through_a_point() {
        let camera = PerspectiveCamera::new(&VIEW, Lens { aperture_m: 0.0, focus_m: Some(3.0) }, 1.0).unwrap();
        let [one, other] = [camera.ray(0.2, 0.7), camera.lens_ray(0.2, 0.7, [0.9, 0.1])];
        assert!(camera.lens_points().next().is_none());
        assert_eq!((one.origin, one.direction), (other.origin, other.direction));
    }
}
