//! How deep a straight path runs through a solid: the inside parts of a line, from a surface point on.
//!
//! A line goes into a closed surface as often as out of it, so its crossings, in order, pair up: in, out, in, out.
//! All crossings of the *whole* line are taken, also those behind the surface point, and the parts before the point
//! are cut away. Thus nothing hangs on whether a rounded point lies a hair inside or outside its surface, and the
//! front or back of a triangle is never asked for.

use glam::Vec3A;
use serde::{Deserialize, Serialize};

use crate::geometry::ray::Crossing;

/// Where a path that leaves the solid more than once ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Exit {
    /// At the last exit; the depth is the sum of the inside parts.
    #[default]
    Last,
    /// At the first exit.
    First,
}

/// A line from a surface point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// The surface point.
    pub(crate) point: Vec3A,
    /// Outward normal there.
    pub(crate) normal: Vec3A,
    /// Unit direction of the path.
    pub(crate) direction: Vec3A,
    /// Where the path ends at the latest, in m: at a light.
    pub(crate) end_m: f32,
}

/// The inside parts of a line, summed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chord {
    /// Length inside, in m.
    pub(crate) depth_m: f32,
    /// Where the path leaves the solid, or its end if that lies inside.
    pub(crate) exit: ChordEnd,
}

/// How a path ends.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ChordEnd {
    /// It leaves the solid.
    Surface {
        /// Index of the object that it leaves.
        object: usize,
        /// Exit point.
        point: Vec3A,
        /// Outward unit normal there.
        normal: Vec3A,
    },
    /// It ends within the solid.
    Inside,
}

/// How far beyond its surface point an outward path's last inside part may seem to reach by rounding, in m, for a
/// path along the normal; an oblique path has this divided by the cosine.
const ROUNDING_M: f32 = 2e-6;

/// The depth of a line through a solid by its inside parts in order, or none where no inside part lies ahead. The normal at the exit
/// has the length that it has in the crossing.
#[inline]
pub(crate) fn chord<'c>(parts: impl Iterator<Item = &'c [Crossing; 2]>, line: &Line, exit: Exit) -> Option<Chord> {
    // A path that starts outwards has just left: the part that ends at its own surface point lies behind it.
    let outward = line.normal.dot(line.direction);
    let behind_m =
        if outward > 0.0 { ROUNDING_M * (1.0 + line.point.abs().max_element()) / outward.max(1e-3) } else { 0.0 };
    let (mut depth_m, mut last) = (0.0, None);
    for [enter, leave] in parts {
        if leave.distance_m <= behind_m {
            continue;
        }
        if enter.distance_m >= line.end_m || (last.is_some() && exit == Exit::First) {
            break;
        }
        depth_m += leave.distance_m.min(line.end_m) - enter.distance_m.max(0.0);
        last = Some(leave);
    }
    let last = last?;
    if last.distance_m > line.end_m {
        return Some(Chord { depth_m, exit: ChordEnd::Inside });
    }
    let normal = if last.normal.dot(line.direction) < 0.0 { -last.normal } else { last.normal };
    let point = line.point + line.direction * last.distance_m;
    Some(Chord { depth_m, exit: ChordEnd::Surface { object: last.object as usize, point, normal } })
}

impl Chord {
    /// The same with a unit normal at its exit.
    pub(crate) fn with_unit_normal(mut self) -> Self {
        if let ChordEnd::Surface { normal, .. } = &mut self.exit {
            *normal = normal.normalize();
        }
        self
    }
}

/// The inside parts of a line, in order, by all its crossings with a solid, which are sorted for that. An unpaired last one (an
/// open surface) is dropped; the caller counts such lines.
pub(crate) fn parts(crossings: &mut [Crossing]) -> impl Iterator<Item = &[Crossing; 2]> {
    match crossings {
        [a, b] if a.distance_m <= b.distance_m => {}
        _ => crossings.sort_unstable_by(|a, b| a.distance_m.total_cmp(&b.distance_m)),
    }
    crossings.as_chunks().0.iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(direction: Vec3A) -> Line {
        Line { point: Vec3A::ZERO, normal: Vec3A::NEG_X, direction, end_m: f32::INFINITY }
    }

    fn crossings(distances_m: &[f32]) -> Vec<Crossing> {
        distances_m.iter().map(|&distance_m| Crossing::new(distance_m, Vec3A::NEG_X * 3.0)).collect()
    }

    #[test]
    fn inside_parts_add_up_to_the_last_exit() {
        let mut unsorted = crossings(&[0.7, 1e-7, 0.5, 0.2, -0.9, -0.4]);
        let last = chord(parts(&mut unsorted), &line(Vec3A::X), Exit::Last).unwrap().with_unit_normal();
        assert!((last.depth_m - 0.4).abs() < 1e-6);
        let ChordEnd::Surface { point, normal, .. } = last.exit else { panic!("leaves the solid") };
        assert!((point.x - 0.7).abs() < 1e-6 && (normal.x - 1.0).abs() < 1e-6);
        let first = chord(parts(&mut unsorted), &line(Vec3A::X), Exit::First).unwrap();
        assert!((first.depth_m - 0.2).abs() < 1e-6);
    }

    #[test]
    fn what_lies_before_the_point_does_not_count() {
        let mut through = crossings(&[-0.4, 0.3]);
        assert!((chord(parts(&mut through), &line(Vec3A::X), Exit::Last).unwrap().depth_m - 0.3).abs() < 1e-6);
    }

    #[test]
    fn a_light_inside_ends_the_line_and_one_outside_hides_what_is_behind_it() {
        let mut twice = crossings(&[0.0, 0.2, 0.5, 0.7]);
        let within = Line { end_m: 0.6, ..line(Vec3A::X) };
        let chord_to_light = chord(parts(&mut twice), &within, Exit::Last).unwrap();
        assert!((chord_to_light.depth_m - 0.3).abs() < 1e-6);
        assert!(matches!(chord_to_light.exit, ChordEnd::Inside));
        let between = Line { end_m: 0.3, ..line(Vec3A::X) };
        assert!((chord(parts(&mut twice), &between, Exit::Last).unwrap().depth_m - 0.2).abs() < 1e-6);
    }

    #[test]
    fn an_outward_path_has_no_depth_though_rounding_leaves_a_trace_of_it() {
        let mut behind = crossings(&[-0.3, 1e-7]);
        assert!(chord(parts(&mut behind), &line(Vec3A::NEG_X), Exit::Last).is_none());
    }

    #[test]
    fn an_unpaired_crossing_adds_nothing() {
        let mut open = crossings(&[0.0, 0.2, 0.5]);
        assert!((chord(parts(&mut open), &line(Vec3A::X), Exit::Last).unwrap().depth_m - 0.2).abs() < 1e-6);
        assert!(chord(parts(&mut crossings(&[0.0])), &line(Vec3A::X), Exit::Last).is_none());
    }
}
