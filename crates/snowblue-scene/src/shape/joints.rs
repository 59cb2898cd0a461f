//! Bodies of snow that meet. Inside the snow, no light passes from one body to the next.

use glam::Vec3A;
use snowblue_geometry::body::{TOUCH_DISTANCE_M, pair_up};
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::ray::Ray;

use crate::objects::Objects;

/// Number of rows and of columns of test lines along each axis. The lines look for places where two objects meet.
const LINES: u16 = 8;
/// Least number of lines that must find such a place. Objects that meet at a point or along an edge count as apart.
const MIN_MEETING: usize = 2;
/// Greatest number of examined pairs of objects whose boxes overlap.
const MAX_PAIRS: usize = 1000;
/// Greatest number of objects whose boxes are compared.
const MAX_OBJECTS: usize = 5000;
/// Distance at which surfaces touch, over their greatest coordinate: the rounding of single precision.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// The pairs of bodies that touch or overlap, among objects of some kind. Each body is given by its first object. In
/// very large scenes only the first pairs are found.
pub(crate) fn joints(objects: &Objects, is_of_kind: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let of_kind = (0..objects.list().len()).filter(|index| is_of_kind(*index));
    let bounded = of_kind.filter_map(|index| Some((index, objects.bounds(index)?)));
    let bounded: Vec<(usize, Bounds)> = bounded.take(MAX_OBJECTS).collect();
    let body = |index: usize| objects.body_of(index)[0];
    let (mut joints, mut examined) = (Vec::new(), 0);
    for (k, (one, bounds)) in bounded.iter().enumerate() {
        for (other, of_other) in &bounded[k + 1..] {
            let bodies = [body(*one).min(body(*other)), body(*one).max(body(*other))];
            let margin_m = touch_distance_m(bounds).max(touch_distance_m(of_other));
            let common = bounds.padded(margin_m).common(of_other.padded(margin_m));
            let Some(common) = common.filter(|_| bodies[0] != bodies[1]) else { continue };
            if examined < MAX_PAIRS && !joints.contains(&bodies) {
                examined += 1;
                if meet(objects, [*one, *other], &common) {
                    joints.push(bodies);
                }
            }
        }
    }
    joints
}

/// Distance within which objects in a box touch, in m.
fn touch_distance_m(bounds: &Bounds) -> f32 {
    TOUCH_DISTANCE_M.max(ROUNDING * bounds.greatest_coordinate())
}

/// Whether enough lines through a box pass from one object into the other, or through both at once.
fn meet(objects: &Objects, pair: [usize; 2], common: &Bounds) -> bool {
    let (touch_m, size) = (touch_distance_m(common), common.high - common.low);
    let lines = (0..3).flat_map(|axis| (0..LINES * LINES).map(move |line| (axis, line)));
    let mut crossings = [Vec::new(), Vec::new()];
    let meets = lines.filter(|(axis, line)| {
        let at = |k: u16| (f32::from(k) + 0.5) / f32::from(LINES);
        let mut place = Vec3A::ZERO;
        place[(axis + 1) % 3] = at(line % LINES);
        place[(axis + 2) % 3] = at(line / LINES);
        let ray = Ray::new(common.low + place * size, Vec3A::AXES[*axis]);
        for (object, crossings) in pair.into_iter().zip(&mut crossings) {
            crossings.clear();
            objects.list()[object].shape.crossings(&ray, crossings);
            pair_up(crossings, 0);
        }
        let [one, other] = crossings.each_ref().map(|crossings| crossings.as_chunks::<2>().0);
        one.iter().any(|[enter, leave]| {
            other.iter().any(|[other_enter, other_leave]| {
                let common_m =
                    leave.distance_m.min(other_leave.distance_m) - enter.distance_m.max(other_enter.distance_m);
                common_m >= -touch_m
            })
        })
    });
    meets.take(MIN_MEETING).count() == MIN_MEETING
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::Object;
    use glam::{DAffine3, DVec3, Mat3A};
    use snowblue_geometry::cuboid::Cuboid;
    use snowblue_geometry::ellipsoid::Ellipsoid;
    use snowblue_geometry::shape::Shape;

    fn meeting(shapes: Vec<(Shape, Option<&str>)>) -> Vec<[usize; 2]> {
        let object = |(shape, body): (Shape, Option<&str>)| Object {
            name: "shape".into(),
            shape,
            material: 0,
            body: body.map(Into::into),
            undisturbed: None,
        };
        joints(&Objects::new(shapes.into_iter().map(object).collect()), |_| true)
    }

    fn box_at(centre: [f32; 3]) -> Shape {
        Shape::Cuboid(Cuboid::new(centre.into(), Vec3A::new(0.4, 0.3, 0.2), Mat3A::IDENTITY))
    }

    fn ball_at(x: f64) -> Shape {
        let to_scene = DAffine3::from_translation(DVec3::X * x) * DAffine3::from_scale(DVec3::splat(0.1));
        Shape::Ellipsoid(Ellipsoid::new(to_scene).unwrap())
    }

    #[test]
    fn bodies_that_touch_or_overlap_meet() {
        let low = || (box_at([0.0; 3]), None);
        for (other, meets) in [
            ([0.0, 0.0, 0.2], true),
            ([0.1, 0.1, 0.2], true),
            ([0.1, 0.1, 0.15], true),
            ([0.0; 3], true),
            ([0.0, 0.0, 0.201], false),
            // Along an edge, and at a corner.
            ([0.4, 0.0, 0.2], false),
            ([0.4, 0.3, 0.2], false),
        ] {
            let expected: &[[usize; 2]] = if meets { &[[0, 1]] } else { &[] };
            assert_eq!(meeting(vec![low(), (box_at(other), None)]), expected, "{other:?}");
        }
        let turned = |sign: f32| {
            let axes = Mat3A::from_euler(glam::EulerRot::XYZ, 0.4, 0.7, -0.3);
            let centre = Vec3A::new(300.0, -20.0, 3.0) + axes * Vec3A::Z * (0.1 * sign);
            (Shape::Cuboid(Cuboid::new(centre, Vec3A::new(0.4, 0.3, 0.2), axes)), None)
        };
        assert_eq!(meeting(vec![turned(1.0), turned(-1.0)]), [[0, 1]]);
        assert!(meeting(vec![turned(1.05), turned(-1.05)]).is_empty());
        assert_eq!(meeting(vec![(ball_at(0.0), None), (ball_at(0.15), None), (ball_at(0.36), None)]), [[0, 1]]);
    }

    #[test]
    fn objects_of_one_body_do_not_count() {
        let stack = |bodies: [Option<&'static str>; 3]| {
            meeting((0u8..).zip(bodies).map(|(k, body)| (box_at([0.0, 0.0, 0.2 * f32::from(k)]), body)).collect())
        };
        assert_eq!(stack([Some("a"), Some("a"), Some("b")]), [[0, 2]]);
        assert!(stack([Some("a"); 3]).is_empty());
    }
}
