//! The segments of a line inside bodies (solids that count as one solid), and inside a solid from a surface point on.
//!
//! Overlapping or touching segments of the solids of one body are merged.
//!
//! The inside of a surface is where its winding number is not 0: the entries of a line so far less its exits. Shells
//! of one mesh may therefore overlap, and a shell inside another shell is a cavity if it is turned inwards. The
//! orientation of the whole surface has no effect. For the depth of a path from a surface point, all crossings of the
//! *whole* line count, also crossings behind the point. The segments are then clipped at the point. The result
//! therefore does not depend on whether a rounded point lies inside or outside its surface.

use glam::Vec3A;

use crate::ray::Crossing;

/// Solids no farther apart than this touch, in m: the rounding error of coordinates of 100 m, and an eighth of the
/// finest snow grain.
pub const TOUCH_DISTANCE_M: f32 = 1e-5;

/// Replaces the crossings of a line with one solid, from index `first` on, by its segments inside: an entry and an
/// exit each, in order along the line.
///
/// If entries and exits differ in number, the orientation of the surface is inconsistent or the surface is open. The
/// crossings then alternate, and an unpaired last crossing is dropped. Returns whether there was one, which means that
/// the surface is open.
pub fn pair_up(crossings: &mut Vec<Crossing>, first: usize) -> bool {
    sort(&mut crossings[first..]);
    if winding(&crossings[first..]) == 0 {
        keep_ends(crossings, first, 0);
        return false;
    }
    let odd = (crossings.len() - first) % 2 == 1;
    if odd {
        crossings.pop();
    }
    odd
}

/// Replaces the crossings of a line with a closed solid beyond a point by its segments inside, as [`pair_up`] does. If
/// the point is inside, the first segment begins with `start`.
pub fn pair_up_from(start: Crossing, crossings: &mut Vec<Crossing>) {
    sort(crossings);
    let before = -winding(crossings);
    keep_ends(crossings, 0, before);
    if before != 0 {
        crossings.insert(0, start);
    }
}

/// The change of the winding number along crossings: 0 for all crossings of a line with a closed surface.
pub fn winding(crossings: &[Crossing]) -> i32 {
    crossings.iter().map(change).sum()
}

fn change(crossing: &Crossing) -> i32 {
    if crossing.is_entry { 1 } else { -1 }
}

/// Sorts crossings along their line, of equal distances the entries first.
fn sort(crossings: &mut [Crossing]) {
    let order = |a: &Crossing, b: &Crossing| a.distance_m.total_cmp(&b.distance_m).then(b.is_entry.cmp(&a.is_entry));
    match crossings {
        [a, b] if a.distance_m <= b.distance_m => {}
        _ => crossings.sort_unstable_by(order),
    }
}

/// Keeps the crossings, from index `first` on, at which the winding number begins or ceases to be 0. It is `winding`
/// before them.
fn keep_ends(crossings: &mut Vec<Crossing>, first: usize, mut winding: i32) {
    let mut kept = first;
    for index in first..crossings.len() {
        let before = winding;
        winding += change(&crossings[index]);
        if (before == 0) != (winding == 0) {
            crossings[kept] = crossings[index];
            kept += 1;
        }
    }
    crossings.truncate(kept);
}

/// Merges the segments of several solids, each a pair of crossings, into disjoint segments in order along the line.
///
/// The result does not depend on the order of the segments.
pub fn unite(crossings: &mut Vec<Crossing>) {
    let (segments, _) = crossings.as_chunks_mut::<2>();
    segments.sort_unstable_by(|[enter_a, leave_a], [enter_b, leave_b]| {
        enter_a
            .distance_m
            .total_cmp(&enter_b.distance_m)
            .then(enter_a.object.cmp(&enter_b.object))
            .then(leave_a.distance_m.total_cmp(&leave_b.distance_m))
    });
    let mut united = 0;
    for index in 1..segments.len() {
        let next = segments[index];
        if next[0].distance_m > segments[united][1].distance_m + TOUCH_DISTANCE_M {
            united += 1;
            segments[united] = next;
        } else if next[1].distance_m > segments[united][1].distance_m {
            segments[united][1] = next[1];
        }
    }
    let length = 2 * (united + 1);
    crossings.truncate(length);
}

/// A line from a surface point.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    /// The surface point.
    pub point: Vec3A,
    /// Outward normal there.
    pub normal: Vec3A,
    /// Unit direction of the path.
    pub direction: Vec3A,
    /// Greatest length of the path, in m: the distance to a light.
    pub end_m: f32,
}

/// The segments of a line inside a solid, summed.
#[derive(Debug, Clone, Copy)]
pub struct Chord {
    /// Total length inside, in m.
    pub depth_m: f32,
    /// The last exit of the path from the solid, if there is an exit.
    pub exit: ChordEnd,
}

/// Where a path ends.
#[derive(Debug, Clone, Copy)]
pub enum ChordEnd {
    /// On the surface of the solid.
    Surface {
        /// Index of the object that the path leaves.
        object: usize,
        /// Exit point.
        point: Vec3A,
        /// Outward unit normal there.
        normal: Vec3A,
    },
    /// Inside the solid.
    Inside,
}

/// Tolerance in m for the end of the segment behind an outward path, which rounding may move beyond the surface point.
/// It is divided by the cosine to the normal for oblique paths.
const ROUNDING_M: f32 = 2e-6;

/// The depth of a line through a solid, by its segments in order; none if no segment lies ahead. The normal at the exit
/// keeps its length.
#[inline]
pub fn chord<'c>(parts: impl Iterator<Item = &'c [Crossing; 2]>, line: &Line) -> Option<Chord> {
    // An outward path has just left the solid: the segment that ends at its surface point lies behind it.
    let outward = line.normal.dot(line.direction);
    let behind_m =
        if outward > 0.0 { ROUNDING_M * (1.0 + line.point.abs().max_element()) / outward.max(1e-3) } else { 0.0 };
    let (mut depth_m, mut last) = (0.0, None);
    for [enter, leave] in parts {
        if leave.distance_m <= behind_m {
            continue;
        }
        if enter.distance_m >= line.end_m {
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
    /// Normalises the normal at the exit.
    pub fn with_unit_normal(mut self) -> Self {
        if let ChordEnd::Surface { normal, .. } = &mut self.exit {
            *normal = normal.normalize();
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn united(solids: &[&[f32]]) -> (Vec<f32>, bool) {
        let (mut crossings, mut odd) = (Vec::new(), false);
        for solid in solids {
            let first = crossings.len();
            let crossing = |(k, &distance_m): (usize, &f32)| Crossing::new(distance_m, Vec3A::X, k % 2 == 0);
            crossings.extend(solid.iter().enumerate().map(crossing));
            odd |= pair_up(&mut crossings, first);
        }
        unite(&mut crossings);
        (crossings.iter().map(|crossing| crossing.distance_m).collect(), odd)
    }

    #[test]
    fn overlapping_touching_and_nested_segments_merge_and_gaps_remain() {
        assert_eq!(united(&[&[0.0, 0.5], &[0.4, 0.9]]), (vec![0.0, 0.9], false));
        assert_eq!(united(&[&[0.4, 0.9], &[0.0, 0.4]]), (vec![0.0, 0.9], false));
        assert_eq!(united(&[&[0.0, 1.0], &[0.2, 0.3]]), (vec![0.0, 1.0], false));
        assert_eq!(united(&[&[0.0, 0.1, 0.6, 0.9], &[0.2, 0.3]]), (vec![0.0, 0.1, 0.2, 0.3, 0.6, 0.9], false));
        assert_eq!(united(&[&[], &[]]), (vec![], false));
    }

    fn wound(crossings: &[(f32, bool)]) -> (Vec<f32>, bool) {
        let crossing = |&(distance_m, is_entry)| Crossing::new(distance_m, Vec3A::X, is_entry);
        let mut crossings: Vec<Crossing> = crossings.iter().map(crossing).collect();
        let odd = pair_up(&mut crossings, 0);
        (crossings.iter().map(|crossing| crossing.distance_m).collect(), odd)
    }

    #[test]
    fn the_inside_is_where_the_winding_number_is_not_0() {
        let (entry, exit) = (true, false);
        // Shells that overlap, one shell inside another, and the same shell twice.
        assert_eq!(wound(&[(0.5, exit), (0.0, entry), (0.4, entry), (0.9, exit)]), (vec![0.0, 0.9], false));
        assert_eq!(wound(&[(0.0, entry), (0.4, entry), (0.5, exit), (0.9, exit)]), (vec![0.0, 0.9], false));
        assert_eq!(wound(&[(0.0, entry), (0.0, entry), (0.9, exit), (0.9, exit)]), (vec![0.0, 0.9], false));
        // A cavity, and a surface that is turned inside out.
        let cavity = [(0.0, entry), (0.4, exit), (0.5, entry), (0.9, exit)];
        assert_eq!(wound(&cavity), (vec![0.0, 0.4, 0.5, 0.9], false));
        assert_eq!(wound(&cavity.map(|(at, is_entry)| (at, !is_entry))), (vec![0.0, 0.4, 0.5, 0.9], false));
        // Without a consistent orientation the crossings alternate.
        assert_eq!(wound(&[(0.0, entry), (0.4, entry), (0.5, entry), (0.9, exit)]), (vec![0.0, 0.4, 0.5, 0.9], false));
        assert_eq!(wound(&[(0.0, entry), (0.4, entry), (0.5, entry)]), (vec![0.0, 0.4], true));
    }

    #[test]
    fn a_line_that_starts_inside_begins_there() {
        let from = |crossings: &[(f32, bool)]| {
            let crossing = |&(distance_m, is_entry)| Crossing::new(distance_m, Vec3A::X, is_entry);
            let mut crossings: Vec<Crossing> = crossings.iter().map(crossing).collect();
            pair_up_from(Crossing::new(-1.0, Vec3A::X, true), &mut crossings);
            crossings.iter().map(|crossing| crossing.distance_m).collect::<Vec<_>>()
        };
        assert_eq!(from(&[(0.2, false), (0.1, false)]), [-1.0, 0.2]);
        assert_eq!(from(&[(0.1, false), (0.2, true), (0.3, false)]), [-1.0, 0.1, 0.2, 0.3]);
        assert_eq!(from(&[(0.1, true), (0.3, false)]), [0.1, 0.3]);
    }

    #[test]
    fn an_open_solid_is_reported_and_does_not_affect_the_others() {
        assert_eq!(united(&[&[0.0, 0.2, 0.5], &[0.6, 0.9]]), (vec![0.0, 0.2, 0.6, 0.9], true));
    }

    fn line(direction: Vec3A) -> Line {
        Line { point: Vec3A::ZERO, normal: Vec3A::NEG_X, direction, end_m: f32::INFINITY }
    }

    fn chord_of(distances_m: &[f32], line: &Line) -> Option<Chord> {
        let crossing = |(k, &distance_m)| Crossing::new(distance_m, Vec3A::NEG_X * 3.0, k % 2 == 0);
        let mut crossings = distances_m.iter().enumerate().map(crossing).collect();
        pair_up(&mut crossings, 0);
        chord(crossings.as_chunks().0.iter(), line)
    }

    #[test]
    fn segments_add_up_to_the_last_exit() {
        let last = chord_of(&[-0.9, -0.4, 1e-7, 0.2, 0.5, 0.7], &line(Vec3A::X)).unwrap().with_unit_normal();
        assert!((last.depth_m - 0.4).abs() < 1e-6);
        let ChordEnd::Surface { point, normal, .. } = last.exit else { panic!("leaves the solid") };
        assert!((point.x - 0.7).abs() < 1e-6 && (normal.x - 1.0).abs() < 1e-6);
    }

    #[test]
    fn segments_behind_the_point_do_not_count() {
        assert!((chord_of(&[-0.4, 0.3], &line(Vec3A::X)).unwrap().depth_m - 0.3).abs() < 1e-6);
    }

    #[test]
    fn a_light_ends_the_path_inside_or_outside() {
        let twice = [0.0, 0.2, 0.5, 0.7];
        let within = Line { end_m: 0.6, ..line(Vec3A::X) };
        let chord_to_light = chord_of(&twice, &within).unwrap();
        assert!((chord_to_light.depth_m - 0.3).abs() < 1e-6);
        assert!(matches!(chord_to_light.exit, ChordEnd::Inside));
        let between = Line { end_m: 0.3, ..line(Vec3A::X) };
        assert!((chord_of(&twice, &between).unwrap().depth_m - 0.2).abs() < 1e-6);
    }

    #[test]
    fn an_outward_path_has_no_depth_despite_rounding() {
        assert!(chord_of(&[-0.3, 1e-7], &line(Vec3A::NEG_X)).is_none());
    }

    #[test]
    fn an_unpaired_crossing_adds_no_depth() {
        assert!((chord_of(&[0.0, 0.2, 0.5], &line(Vec3A::X)).unwrap().depth_m - 0.2).abs() < 1e-6);
        assert!(chord_of(&[0.0], &line(Vec3A::X)).is_none());
    }
}
