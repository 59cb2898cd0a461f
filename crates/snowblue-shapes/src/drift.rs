//! Snow cover: a level layer with mounds, as over stones or shrubs, and a fine relief.

use glam::{DVec2, DVec3, Vec3};
use snowblue_base::narrow;
use snowblue_geometry::triangle_mesh::TriangleMesh;

use crate::height_field::Heights;
use crate::relief::relief;

/// Grid points along the longer side.
const GRID: usize = 480;
/// Horizontal scale of the relief, in m.
const RELIEF_SIZE_M: f64 = 0.35;

/// A mound of snow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mound {
    /// Position of its centre, in m.
    pub centre_m: DVec2,
    /// Height above the level surface, in m.
    pub height_m: f64,
    /// Distance from the centre to the steepest slope, in m.
    pub radius_m: f64,
}

impl Mound {
    /// Height at a position: a rounded top with a smooth foot.
    fn height_m(&self, position: DVec2) -> f64 {
        let distance = position.distance(self.centre_m) / self.radius_m;
        self.height_m / (1.0 + distance.powi(2) * (1.0 + distance.powi(2)) / 2.0).powf(1.5)
    }
}

/// A solid of snow between a surface near z = 0 and a level bottom at z = −`size_m.z`, centred on the z axis.
///
/// # Errors
///
/// When the surface dips below the bottom.
pub fn drift(size_m: DVec3, mounds: &[Mound], relief_m: f64, seed: u32) -> Result<TriangleMesh, String> {
    let heights = drift_heights(size_m, mounds, relief_m, seed)?;
    heights.solid(Vec3::new(narrow(size_m.x), narrow(size_m.y), 1.0), narrow(-size_m.z))
}

/// The heights of the surface of a drift, in m.
///
/// # Errors
///
/// When a height is not finite.
pub fn drift_heights(size_m: DVec3, mounds: &[Mound], relief_m: f64, seed: u32) -> Result<Heights, String> {
    let longer_m = size_m.x.max(size_m.y);
    let points = |side_m: f64| whole((GRID as f64 * side_m / longer_m).ceil().max(2.0));
    let (columns, rows) = (points(size_m.x), points(size_m.y));
    let height_m = |index: usize| {
        let along = (index % columns) as f64 / (columns - 1) as f64 - 0.5;
        let up = 0.5 - (index / columns) as f64 / (rows - 1) as f64;
        let position = DVec2::new(along * size_m.x, up * size_m.y);
        let height =
            relief(position.extend(0.0), RELIEF_SIZE_M, seed) + 0.15 * relief(position.extend(9.0), 0.04, seed);
        narrow(relief_m * height + mounds.iter().map(|mound| mound.height_m(position)).sum::<f64>())
    };
    Heights::new(columns, (0..columns * rows).map(height_m).collect())
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
fn whole(count: f64) -> usize {
    count as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_geometry::topology::Topology;

    #[test]
    fn a_mound_stands_at_its_position_on_a_closed_solid() {
        let mound = Mound { centre_m: DVec2::new(0.5, -0.25), height_m: 0.4, radius_m: 0.2 };
        let solid = drift(DVec3::new(3.0, 2.0, 0.2), &[mound], 0.01, 1).unwrap();
        let topology = Topology::of(&solid);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        let top = solid.positions.iter().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        // The grid spacing is 6 mm, and the relief at most 0.02 m.
        assert!(top.truncate().as_dvec2().distance(mound.centre_m) < 0.03 && (top.z - 0.4).abs() < 0.025, "{top}");
        assert!(drift(DVec3::new(3.0, 2.0, 0.001), &[], 0.01, 1).unwrap_err().contains("bottom"));
    }
}
