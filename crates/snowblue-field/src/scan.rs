//! Scans a body with lines: which part of each cell is inside, and points on the surface with their areas.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::body::{Body, Scanner};
use crate::element::{CELL_PARTS, PARTS};
use crate::lattice::Lattice;

/// Lines per cell and axis that sample the surface.
const SURFACE_LINES: usize = 2;

/// How much of a cell is inside the body.
#[derive(Debug, Clone)]
pub(crate) enum Coverage {
    /// All of it.
    Whole,
    /// These fractions of its parts.
    Parts(Box<[f32; CELL_PARTS]>),
}

/// A point on the surface of a body with the area that it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceElement {
    /// The point, in m.
    pub point: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Area, in m².
    pub area_m2: f32,
}

/// The coverage of each cell that is not empty, by columns along z.
pub(crate) fn coverage(body: &dyn Body, lattice: &Lattice) -> Vec<Vec<(usize, Coverage)>> {
    let [nx, ny, nz] = lattice.counts;
    let part = lattice.step / PARTS as f64;
    let column = |scanner: &mut Scanner, column: usize| {
        let mut parts = vec![[0.0_f32; CELL_PARTS]; nz];
        let (ix, iy) = (column / ny, column % ny);
        for line in 0..PARTS * PARTS {
            let (sx, sy) = (line / PARTS, line % PARTS);
            let x = lattice.low.x + ((ix * PARTS + sx) as f64 + 0.5) * part.x;
            let y = lattice.low.y + ((iy * PARTS + sy) as f64 + 0.5) * part.y;
            for segment in scanner.segments(2, DVec3::new(x, y, 0.0)) {
                let place =
                    |coordinate_m: f64| ((coordinate_m - lattice.low.z) / part.z).clamp(0.0, (nz * PARTS) as f64);
                let (start, end) = (place(segment.enter.coordinate_m), place(segment.leave.coordinate_m));
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the lattice")]
                let (first, last) = (start as usize, end.ceil() as usize);
                for k in first..last {
                    let length = end.min((k + 1) as f64) - start.max(k as f64);
                    #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
                    let length = length as f32;
                    parts[k / PARTS][line * PARTS + k % PARTS] += length;
                }
            }
        }
        let cells = parts.into_iter().enumerate().filter_map(|(iz, parts)| {
            // A millionth of a part is the rounding of coordinates.
            if parts.iter().all(|fraction| *fraction >= 1.0 - 1e-5) {
                Some((iz, Coverage::Whole))
            } else if parts.iter().any(|fraction| *fraction > 0.0) {
                Some((iz, Coverage::Parts(Box::new(parts.map(|fraction| fraction.min(1.0))))))
            } else {
                None
            }
        });
        cells.collect()
    };
    (0..nx * ny).into_par_iter().map_init(|| Scanner::new(body), column).collect()
}

/// Points on the surface, from lines along all three axes.
///
/// Lines along axis k at a distance δ cross an area A with normal n in A |n_k| / δ² points. Points with the area
/// δ² |n_k| therefore add up to A n_k², and those of all three axes to A.
pub(crate) fn surface(body: &dyn Body, lattice: &Lattice) -> Vec<SurfaceElement> {
    let spacing = lattice.step / SURFACE_LINES as f64;
    let mut elements = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let [lines_u, lines_v] = [u, v].map(|k| lattice.counts[k] * SURFACE_LINES);
        let row = |scanner: &mut Scanner, i: usize| {
            let mut found = Vec::new();
            for j in 0..lines_v {
                let mut point = DVec3::ZERO;
                point[u] = lattice.low[u] + (i as f64 + 0.5) * spacing[u];
                point[v] = lattice.low[v] + (j as f64 + 0.5) * spacing[v];
                for segment in scanner.segments(axis, point) {
                    for crossing in [segment.enter, segment.leave] {
                        point[axis] = crossing.coordinate_m;
                        #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
                        let area_m2 = (spacing[u] * spacing[v]) as f32 * crossing.normal[axis].abs();
                        if area_m2 > 0.0 {
                            found.push(SurfaceElement { point: point.as_vec3(), normal: crossing.normal, area_m2 });
                        }
                    }
                }
            }
            found
        };
        let rows: Vec<Vec<SurfaceElement>> =
            (0..lines_u).into_par_iter().map_init(|| Scanner::new(body), row).collect();
        elements.extend(rows.into_iter().flatten());
    }
    elements
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{Ball, BoxBody};
    use glam::{DMat3, EulerRot};
    use std::f64::consts::PI;

    fn volume(body: &dyn Body, lattice: &Lattice) -> f64 {
        let cell = lattice.step.x * lattice.step.y * lattice.step.z;
        let fraction = |coverage: &Coverage| match coverage {
            Coverage::Whole => 1.0,
            Coverage::Parts(parts) => f64::from(parts.iter().sum::<f32>()) / CELL_PARTS as f64,
        };
        coverage(body, lattice).iter().flatten().map(|(_, coverage)| cell * fraction(coverage)).sum()
    }

    #[test]
    fn lines_measure_volume_and_area_of_balls_and_turned_boxes() {
        let ball = Ball { centre: DVec3::new(0.1, 0.2, -0.3), radius: 0.05 };
        let turned = BoxBody {
            centre: DVec3::ZERO,
            size: DVec3::new(0.06, 0.05, 0.08),
            axes: DMat3::from_euler(EulerRot::XYZ, 0.3, -0.5, 0.8),
        };
        let box_area = 2.0 * (0.06 * 0.05 + 0.05 * 0.08 + 0.06 * 0.08);
        let bodies: [(&dyn Body, f64, f64); 2] = [
            (&ball, 4.0 / 3.0 * PI * 0.05_f64.powi(3), 4.0 * PI * 0.05_f64.powi(2)),
            (&turned, 0.06 * 0.05 * 0.08, box_area),
        ];
        for (body, expected_volume, expected_area) in bodies {
            let lattice = Lattice::around(body, 0.01, DVec3::ZERO);
            let found = volume(body, &lattice);
            assert!((found / expected_volume - 1.0).abs() < 2e-3, "{found} {expected_volume}");
            let elements = surface(body, &lattice);
            let area: f64 = elements.iter().map(|element| f64::from(element.area_m2)).sum();
            assert!((area / expected_area - 1.0).abs() < 0.01, "{area} {expected_area}");
            // ∮ n dA = 0 and ∮ x·n dA = 3 V (Gauss).
            let flux: f64 = elements
                .iter()
                .map(|one| {
                    f64::from(one.area_m2) * (one.point.as_dvec3() - body.bounds()[0]).dot(one.normal.as_dvec3())
                })
                .sum();
            assert!((flux / (3.0 * expected_volume) - 1.0).abs() < 0.02, "{flux} {expected_volume}");
        }
    }
}
