//! The distance to the surface of carved snow.
//!
//! The distance to all added solids is the smooth minimum of their distances. The distance to the snow is the smooth
//! maximum of this distance and the negative distance to the removed solids, minus the height of the relief. Inside
//! the snow it is negative.

use glam::DVec3;

use super::solid::{Solid, smooth_min_m};
use crate::relief::{MAX_RELIEF, relief_above};

/// Scale of the finest relief, in cells.
const FINEST_RELIEF: f64 = 2.0;

/// Parameters of carved snow.
#[derive(Debug, Clone, PartialEq)]
pub struct Carved {
    /// Length of the mesh's cells, in m.
    pub cell_m: f64,
    /// Distance from the edge at which the rounding of a joint of solids begins, in m.
    pub rounding_m: f64,
    /// Height of the relief, in m.
    pub relief_m: f64,
    /// Scale of the coarsest relief, in m.
    pub relief_length_m: f64,
    /// Seed of the relief.
    pub seed: u32,
    /// Solids that are heaped up. Half-spaces are infinite and must not be among them.
    pub add: Vec<Solid>,
    /// Solids that are taken away.
    pub remove: Vec<Solid>,
}

impl Carved {
    /// A box around the snow.
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let joined =
            |[low, high]: [DVec3; 2], [other_low, other_high]: [DVec3; 2]| [low.min(other_low), high.max(other_high)];
        let bounds = self.add.iter().filter_map(Solid::bounds).reduce(joined);
        let [low, high] = bounds.unwrap_or([DVec3::ZERO; 2]);
        let joint_m = if self.add.len() > 1 { self.rounding_m } else { 0.0 };
        let margin_m = joint_m + self.greatest_relief_m();
        [low - margin_m, high + margin_m]
    }

    /// The snow without the solids that have no effect within a reach of a point. Within the reach, distances change
    /// by less than a millionth of the rounding.
    ///
    /// The distance to a solid, or to joined solids, differs between two points by no more than the distance between
    /// the points. A solid that is farther away than another solid by more than the rounding affects the surface only
    /// through solids in between, each of which takes little of its effect. Solids within three times the rounding of
    /// the nearest solid are kept.
    pub(super) fn near(&self, point: DVec3, reach_m: f64) -> Self {
        let counting = |solids: &[Solid]| {
            let least_m = solids.iter().map(|solid| solid.distance_m(point)).fold(f64::INFINITY, f64::min);
            let most_m = least_m + 2.0 * reach_m + 3.0 * self.rounding_m;
            solids.iter().filter(|solid| solid.distance_m(point) <= most_m).copied().collect()
        };
        let is_taken_elsewhere =
            self.union_m(&self.add, point) + self.union_m(&self.remove, point) > 2.0 * reach_m + self.rounding_m;
        let remove = if is_taken_elsewhere { Vec::new() } else { counting(&self.remove) };
        Self { add: counting(&self.add), remove, ..*self }
    }

    /// Signed distance to the surface without relief, in m. It differs between two points by no more than the distance
    /// between the points.
    pub(super) fn smooth_distance_m(&self, point: DVec3) -> f64 {
        -smooth_min_m(-self.union_m(&self.add, point), self.union_m(&self.remove, point), self.rounding_m)
    }

    /// Signed distance to the surface of solids that are joined, in m.
    fn union_m(&self, solids: &[Solid], point: DVec3) -> f64 {
        let distances = solids.iter().map(|solid| solid.distance_m(point));
        distances.fold(f64::INFINITY, |all_m, one_m| smooth_min_m(all_m, one_m, self.rounding_m))
    }

    /// Signed distance to the surface, in m.
    pub(super) fn distance_m(&self, point: DVec3) -> f64 {
        let smooth_m = self.smooth_distance_m(point);
        if self.relief_m > 0.0 {
            let finest_m = FINEST_RELIEF * self.cell_m;
            smooth_m - self.relief_m * relief_above(point, self.relief_length_m, finest_m, self.seed)
        } else {
            smooth_m
        }
    }

    /// Greatest height or depth of the relief, in m.
    pub(super) fn greatest_relief_m(&self) -> f64 {
        MAX_RELIEF * self.relief_m
    }

    /// Gradient of the distance, by central differences over a length.
    pub(super) fn gradient(&self, point: DVec3, reach_m: f64) -> DVec3 {
        let change = |axis: DVec3| self.distance_m(point + reach_m * axis) - self.distance_m(point - reach_m * axis);
        DVec3::from_array(DVec3::AXES.map(change)) / (2.0 * reach_m)
    }
}
