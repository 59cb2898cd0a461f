//! Ground under snow: a level cover with mounds on it, as snow lies over stones, shrubs and garden lamps, slightly uneven.

use glam::{DVec2, DVec3, Vec3};

use crate::geometry::ray::narrow;
use crate::geometry::triangle_mesh::TriangleMesh;
use crate::shapes::height_field::Heights;
use crate::shapes::relief::relief;

/// Points of the grid along the longer side.
const GRID: usize = 480;
/// Over which length the surface is uneven, in m, and at which height of its relief.
const RELIEF_SIZE_M: f64 = 0.35;

/// A heap on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mound {
    /// Its middle, in m.
    pub middle_m: DVec2,
    /// Its height above the level cover, in m.
    pub height_m: f64,
    /// From its middle to where its side is steepest, in m.
    pub radius_m: f64,
}

impl Mound {
    /// Height at a place: a rounded top with sides as snow lies on a thing, and no edge at the foot.
    fn height_m(&self, at: DVec2) -> f64 {
        let distance = at.distance(self.middle_m) / self.radius_m;
        self.height_m / (1.0 + distance.powi(2) * (1.0 + distance.powi(2)) / 2.0).powf(1.5)
    }
}

/// The solid of snow between a surface about z = 0 and a level bottom, over a rectangle about the origin.
///
/// # Errors
///
/// When the surface dips below the bottom.
pub fn drift(size_m: DVec3, mounds: &[Mound], relief_m: f64, seed: u32) -> Result<TriangleMesh, String> {
    let longer_m = size_m.x.max(size_m.y);
    let points = |side_m: f64| whole((GRID as f64 * side_m / longer_m).ceil().max(2.0));
    let (columns, rows) = (points(size_m.x), points(size_m.y));
    let height_m = |index: usize| {
        let along = (index % columns) as f64 / (columns - 1) as f64 - 0.5;
        let up = 0.5 - (index / columns) as f64 / (rows - 1) as f64;
        let at = DVec2::new(along * size_m.x, up * size_m.y);
        let uneven = relief(at.extend(0.0), RELIEF_SIZE_M, seed) + 0.15 * relief(at.extend(9.0), 0.04, seed);
        narrow(relief_m * uneven + mounds.iter().map(|mound| mound.height_m(at)).sum::<f64>())
    };
    let heights = Heights::new(columns, (0..columns * rows).map(height_m).collect())?;
    heights.solid(Vec3::new(narrow(size_m.x), narrow(size_m.y), 1.0), narrow(-size_m.z))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
fn whole(count: f64) -> usize {
    count as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_tools::topology::Topology;

    #[test]
    fn a_mound_stands_where_it_is_put_on_a_closed_cover() {
        let mound = Mound { centre_m: DVec2::new(0.5, -0.25), height_m: 0.4, radius_m: 0.2 };
        let solid = drift(DVec3::new(3.0, 2.0, 0.2), &[mound], 0.01, 1).unwrap();
        let topology = Topology::of(&solid);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        let top = solid.positions.iter().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        // A grid of 6 mm, and a relief of at most two layers' heights.
        assert!(top.truncate().as_dvec2().distance(mound.middle_m) < 0.03 && (top.z - 0.4).abs() < 0.025, "{top}");
        assert!(drift(DVec3::new(3.0, 2.0, 0.001), &[], 0.01, 1).unwrap_err().contains("bottom"));
    }
}
