//! The inside parts of a line through several solids that are one body: where they overlap or touch, they are one part.

use crate::geometry::ray::Crossing;

/// Parts of a line no farther apart than this touch, in m: rounding of coordinates of 100 m, an eighth of the finest
/// grain of snow.
const TOUCH_M: f32 = 1e-5;

/// Sorts the crossings of one solid from `first` on along the line, and drops an unpaired last one.
///
/// Returns whether there was one: the solid's surface is open there.
pub(crate) fn pair_up(crossings: &mut Vec<Crossing>, first: usize) -> bool {
    crossings[first..].sort_unstable_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    let odd = (crossings.len() - first) % 2 == 1;
    if odd {
        crossings.pop();
    }
    odd
}

/// Unites the parts of several solids, each a pair of crossings, into parts that lie apart, in the line's order.
pub(crate) fn unite(crossings: &mut Vec<Crossing>) {
    let (parts, _) = crossings.as_chunks_mut::<2>();
    parts.sort_unstable_by(|a, b| a[0].distance_m.total_cmp(&b[0].distance_m));
    let mut united = 0;
    for index in 1..parts.len() {
        let next = parts[index];
        if next[0].distance_m > parts[united][1].distance_m + TOUCH_M {
            united += 1;
            parts[united] = next;
        } else if next[1].distance_m > parts[united][1].distance_m {
            parts[united][1] = next[1];
        }
    }
    let length = 2 * (united + 1);
    crossings.truncate(length);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    fn united(solids: &[&[f32]]) -> (Vec<f32>, bool) {
        let (mut crossings, mut odd) = (Vec::new(), false);
        for solid in solids {
            let first = crossings.len();
            crossings.extend(solid.iter().map(|&distance_m| Crossing::new(distance_m, Vec3A::X)));
            odd |= pair_up(&mut crossings, first);
        }
        unite(&mut crossings);
        (crossings.iter().map(|crossing| crossing.distance_m).collect(), odd)
    }

    #[test]
    fn overlapping_touching_and_nested_parts_are_one_and_gaps_stay() {
        assert_eq!(united(&[&[0.5, 0.0], &[0.4, 0.9]]), (vec![0.0, 0.9], false));
        assert_eq!(united(&[&[0.4, 0.9], &[0.0, 0.4]]), (vec![0.0, 0.9], false));
        assert_eq!(united(&[&[0.0, 1.0], &[0.2, 0.3]]), (vec![0.0, 1.0], false));
        assert_eq!(united(&[&[0.0, 0.1, 0.6, 0.9], &[0.2, 0.3]]), (vec![0.0, 0.1, 0.2, 0.3, 0.6, 0.9], false));
        assert_eq!(united(&[&[], &[]]), (vec![], false));
    }

    #[test]
    fn an_open_solid_is_told_and_does_not_turn_the_others_inside_out() {
        assert_eq!(united(&[&[0.0, 0.2, 0.5], &[0.6, 0.9]]), (vec![0.0, 0.2, 0.6, 0.9], true));
    }
}
