//! Bodies: solids that count as one. Where the segments of a line inside them overlap or touch, they are merged.

use crate::ray::Crossing;

/// Solids no farther apart than this touch, in m: the rounding error of coordinates of 100 m, and an eighth of the
/// finest snow grain.
pub const TOUCH_DISTANCE_M: f32 = 1e-5;

/// Sorts the crossings from index `first` on, which belong to one solid, and drops an unpaired last one.
///
/// Returns whether there was one, which means that the surface is open.
pub fn pair_up(crossings: &mut Vec<Crossing>, first: usize) -> bool {
    crossings[first..].sort_unstable_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    let odd = (crossings.len() - first) % 2 == 1;
    if odd {
        crossings.pop();
    }
    odd
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
    fn overlapping_touching_and_nested_segments_merge_and_gaps_remain() {
        assert_eq!(united(&[&[0.5, 0.0], &[0.4, 0.9]]), (vec![0.0, 0.9], false));
        assert_eq!(united(&[&[0.4, 0.9], &[0.0, 0.4]]), (vec![0.0, 0.9], false));
        assert_eq!(united(&[&[0.0, 1.0], &[0.2, 0.3]]), (vec![0.0, 1.0], false));
        assert_eq!(united(&[&[0.0, 0.1, 0.6, 0.9], &[0.2, 0.3]]), (vec![0.0, 0.1, 0.2, 0.3, 0.6, 0.9], false));
        assert_eq!(united(&[&[], &[]]), (vec![], false));
    }

    #[test]
    fn an_open_solid_is_reported_and_does_not_affect_the_others() {
        assert_eq!(united(&[&[0.0, 0.2, 0.5], &[0.6, 0.9]]), (vec![0.0, 0.2, 0.6, 0.9], true));
    }
}
