//! Distances to line segments, by a bounding volume hierarchy.

use glam::Vec3;

/// Greatest number of segments of a leaf.
const LEAF: usize = 4;

/// Segments in the order of a balanced binary tree: each node has one half of its segments on either side.
pub(crate) struct Segments {
    segments: Vec<[Vec3; 2]>,
    /// Lower and upper corner of the bounds of each node; the children of node n are 2n + 1 and 2n + 2.
    bounds: Vec<[Vec3; 2]>,
}

impl Segments {
    pub(crate) fn new(mut segments: Vec<[Vec3; 2]>) -> Self {
        let mut bounds = Vec::new();
        sort(&mut segments, 0, &mut bounds);
        Self { segments, bounds }
    }

    /// The distance from a point to the nearest segment, or `most_m` if none is nearer.
    pub(crate) fn distance_m(&self, point: Vec3, most_m: f32) -> f32 {
        self.nearer_m(point, most_m, 0, &self.segments)
    }

    fn nearer_m(&self, point: Vec3, most_m: f32, node: usize, segments: &[[Vec3; 2]]) -> f32 {
        if segments.len() <= LEAF {
            return segments.iter().map(|segment| distance_m(point, segment)).fold(most_m, f32::min);
        }
        let (left, right) = segments.split_at(segments.len() / 2);
        let away = |child: usize| {
            let [low, high] = self.bounds[child];
            point.distance(point.clamp(low, high))
        };
        let mut children =
            [(2 * node + 1, left), (2 * node + 2, right)].map(|(child, part)| (away(child), child, part));
        if children[1].0 < children[0].0 {
            children.swap(0, 1);
        }
        children.into_iter().fold(most_m, |most_m, (away_m, child, part)| {
            if away_m < most_m { self.nearer_m(point, most_m, child, part) } else { most_m }
        })
    }
}

/// Sorts segments into the order of the tree below a node.
fn sort(segments: &mut [[Vec3; 2]], node: usize, bounds: &mut Vec<[Vec3; 2]>) {
    let [mut low, mut high] = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    for end in segments.as_flattened() {
        (low, high) = (low.min(*end), high.max(*end));
    }
    if bounds.len() <= node {
        bounds.resize(node + 1, [Vec3::INFINITY, Vec3::NEG_INFINITY]);
    }
    bounds[node] = [low, high];
    if segments.len() <= LEAF {
        return;
    }
    let axis = (high - low).max_position();
    let middle = segments.len() / 2;
    segments.select_nth_unstable_by(middle, |[a, b], [c, d]| (a[axis] + b[axis]).total_cmp(&(c[axis] + d[axis])));
    let (left, right) = segments.split_at_mut(middle);
    sort(left, 2 * node + 1, bounds);
    sort(right, 2 * node + 2, bounds);
}

fn distance_m(point: Vec3, &[from, to]: &[Vec3; 2]) -> f32 {
    let along = to - from;
    let part = (point - from).dot(along) / along.length_squared();
    // `part` is not a number where the segment is a point.
    let part = if part > 0.0 { part.min(1.0) } else { 0.0 };
    point.distance(from + part * along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_is_that_to_the_nearest_of_all() {
        let place = |k: u16| {
            let part = |factor: u16| f32::from((k * factor) % 101) / 101.0;
            Vec3::new(part(17), part(29), part(43))
        };
        let segments: Vec<[Vec3; 2]> = (0..77).map(|k| [place(k), place(k + 9).lerp(place(k), 0.8)]).collect();
        let tree = Segments::new(segments.clone());
        for k in 0..200 {
            let point = 1.5 * place(k) - Vec3::splat(0.2);
            let nearest = segments.iter().map(|segment| distance_m(point, segment)).fold(f32::INFINITY, f32::min);
            assert!((tree.distance_m(point, f32::INFINITY) - nearest).abs() < 1e-7);
            assert!((tree.distance_m(point, 0.05) - nearest.min(0.05)).abs() < 1e-7);
        }
        assert!((distance_m(Vec3::X, &[Vec3::ZERO; 2]) - 1.0).abs() < 1e-7);
        assert!((Segments::new(Vec::new()).distance_m(Vec3::ZERO, 3.0) - 3.0).abs() < 1e-7);
    }
}
