//! Height fields: solids between a surface given by heights on a grid and a level bottom, closed by side walls.

use glam::{DVec2, Vec2, Vec3};

use snowblue_base::narrow;
use snowblue_geometry::triangle_mesh::{TriangleMesh, closed_grids};

/// Heights on a grid, row by row from the far side (greatest y) to the near side, each from left to right.
#[derive(Debug, Clone, PartialEq)]
pub struct Heights {
    columns: usize,
    values: Vec<f32>,
}

impl Heights {
    /// A grid with a number of columns.
    ///
    /// # Errors
    ///
    /// When there are fewer than two rows or columns, an incomplete row, more than 2²⁸ heights, or a height that is
    /// not finite.
    pub fn new(columns: usize, values: Vec<f32>) -> Result<Self, String> {
        let rows = values.len().checked_div(columns).unwrap_or(0);
        if rows < 2 || columns < 2 || rows * columns != values.len() || values.len() > 1 << 28 {
            return Err(format!(
                "heights are a grid of {columns} × {rows}, but must be at least 2 × 2, and at most 2^28 in all"
            ));
        }
        match values.iter().find(|height| !height.is_finite()) {
            Some(height) => Err(format!("a height is {height}, but must be finite")),
            None => Ok(Self { columns, values }),
        }
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns
    }

    /// All heights.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The heights times a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f32) -> Self {
        self.values.iter_mut().for_each(|height| *height *= factor);
        self
    }

    /// The heights minus `by`.
    #[must_use]
    pub fn lowered(mut self, by: f64) -> Self {
        self.values.iter_mut().for_each(|height| *height = narrow(f64::from(*height) - by));
        self
    }

    /// The height at a place in cells from the far left, on the two triangles of [`solid`](Self::solid) in each cell.
    /// Beyond the edge, the triangles of the edge cell are extrapolated.
    pub fn at(&self, place: DVec2) -> f64 {
        let (column, across) = cell(place.x, self.columns);
        let (row, down) = cell(place.y, self.rows());
        let height = |right: usize, near: usize| f64::from(self.values[(row + near) * self.columns + column + right]);
        let (far_left, near_right) = (height(0, 0), height(1, 1));
        if across >= down {
            let far_right = height(1, 0);
            far_left + across * (far_right - far_left) + down * (near_right - far_right)
        } else {
            let near_left = height(0, 1);
            far_left + down * (near_left - far_left) + across * (near_right - near_left)
        }
    }

    /// The solid between these heights and a level bottom, centred on the z axis: a height h lies at z = h · `size.z`.
    /// Texture coordinates run from (0, 0) at the near left to (1, 1) at the far right.
    ///
    /// # Errors
    ///
    /// When the bottom is not below the least height.
    pub fn solid(&self, size: Vec3, bottom: f32) -> Result<TriangleMesh, String> {
        let least = self.values.iter().fold(f32::INFINITY, |least, &height| least.min(height * size.z));
        if bottom >= least {
            return Err(format!("bottom is {bottom} m, but must lie below the least height of {least} m"));
        }
        let (columns, rows) = (self.columns, self.values.len() / self.columns);
        let uv = |column: usize, row: usize| {
            Vec2::new(column as f32 / (columns - 1) as f32, 1.0 - row as f32 / (rows - 1) as f32)
        };
        let mut solid = TriangleMesh::default();
        let mut add = |uv: Vec2, z: f32| {
            solid.positions.push(Vec3::new((uv.x - 0.5) * size.x, (uv.y - 0.5) * size.y, z));
            solid.uv.push(uv);
        };
        for (index, height) in self.values.iter().enumerate() {
            add(uv(index % columns, index / columns), height * size.z);
        }
        for index in 0..self.values.len() {
            add(uv(index % columns, index / columns), bottom);
        }
        // `closed_grids` faces the second grid outwards, here the bottom; seen from below, rows run from far to near.
        solid.indices = closed_grids(count(columns), count(rows));
        Ok(solid)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a grid has at most 2^28 points")]
fn count(count: usize) -> u32 {
    count as u32
}

/// The cell that contains a place, among the cells between `points` points, and the position within the cell.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "kept within the cells")]
fn cell(place: f64, points: usize) -> (usize, f64) {
    let cell = place.floor().clamp(0.0, (points - 2) as f64);
    (cell as usize, place - cell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_geometry::topology::{Topology, volume};

    #[test]
    fn the_solid_is_closed_and_its_volume_is_area_times_mean_height() {
        let (columns, rows) = (7, 5);
        let slope = |k: usize| 1.0 + (k % columns) as f32 / 6.0 + (k / columns) as f32 / 4.0;
        let heights = Heights::new(columns, (0..columns * rows).map(slope).collect()).unwrap();
        let solid = heights.solid(Vec3::new(3.0, 2.0, 0.1), -0.2).unwrap();
        let topology = Topology::of(&solid);
        assert!(topology.is_closed() && topology.reversed_edges == 0 && topology.merged_vertices == 0, "{topology:?}");
        // Heights rise evenly from 0.1 to 0.3 m, with a mean of 0.2 m, above a bottom at −0.2 m.
        assert!((volume(&solid) - 3.0 * 2.0 * 0.4).abs() < 1e-6);
        // The far right corner is the highest of the first row.
        assert_eq!(solid.positions[6], Vec3::new(1.5, 1.0, 0.2));
        assert_eq!(solid.uv[6], Vec2::ONE);
    }

    #[test]
    fn rejects_a_bottom_above_the_surface_and_incomplete_grids() {
        assert!(Heights::new(2, vec![0.0; 4]).unwrap().solid(Vec3::ONE, 0.0).unwrap_err().contains("bottom is 0 m"));
        assert!(Heights::new(3, vec![0.0; 3]).is_err());
        assert!(Heights::new(2, vec![0.0, 1.0, f32::NAN, 0.0]).unwrap_err().contains("NaN"));
    }

    #[test]
    fn heights_between_grid_points_lie_on_the_triangles_of_the_solid() {
        let heights = Heights::new(3, vec![0.0, 1.0, 5.0, 2.0, -3.0, 4.0, 7.0, 0.5, 1.5]).unwrap();
        let solid = heights.solid(Vec3::new(2.0, 2.0, 1.0), -9.0).unwrap();
        for triangle in 0..solid.indices.len() {
            let corners = solid.corners(triangle).map(Vec3::as_dvec3);
            let point = 0.5 * corners[0] + 0.3 * corners[1] + 0.2 * corners[2];
            let is_top = corners.iter().all(|corner| corner.z > -9.0);
            if is_top {
                // From the far left: x and y run from −1 to 1.
                let found = heights.at(DVec2::new(point.x + 1.0, 1.0 - point.y));
                assert!((found - point.z).abs() < 1e-6, "{point}: {found}");
            }
        }
    }
}
