//! Scans a body with lines: the part of each cell that is inside, and points on the surface with their areas.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::body::{Body, Scanner};
use crate::element::{CELL_PARTS, PARTS};
use crate::lattice::{Lattice, across};

/// Number of lines per cell along each axis that sample the surface.
const SURFACE_LINES: usize = 2;

/// The cells of a column along z that are inside the body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Column {
    /// The cells that are partly inside, in order, with the fraction of each part that is inside.
    pub(crate) cut: Vec<(u32, Box<[f32; CELL_PARTS]>)>,
    /// Ranges of cells that are entirely inside, in order.
    pub(crate) whole: Vec<Range<u32>>,
}

/// A point on the surface of a body with the area that it represents.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceElement {
    /// The point, in m.
    pub point: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Area, in m².
    pub area_m2: f32,
}

/// A surface element with the thickness of the snow below it, along its normal, in m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub(crate) element: SurfaceElement,
    pub(crate) thickness_m: f32,
}

/// A segment of a line through a column. Its ends are in parts of cells from the start of the column.
#[derive(Debug, Clone, Copy)]
struct Run {
    line: usize,
    start: f64,
    end: f64,
    /// Range of the parts that it touches, without `last`.
    first: usize,
    last: usize,
}

impl Column {
    /// Whether no part of a cell is inside.
    pub(crate) fn is_empty(&self, cell: u32) -> bool {
        let after = self.whole.partition_point(|range| range.start <= cell);
        let is_whole = after > 0 && cell < self.whole[after - 1].end;
        !is_whole && self.cut.binary_search_by_key(&cell, |(cell, _)| *cell).is_err()
    }

    /// The column of the segments of all its lines.
    fn of_runs(runs: &[Run]) -> Self {
        // Cells in which segments begin or end. Between these cells, each line is either inside or outside.
        let mut ends: Vec<usize> =
            runs.iter().flat_map(|run| [run.first / PARTS, run.last.saturating_sub(1) / PARTS]).collect();
        ends.sort_unstable();
        ends.dedup();
        let mut parts = vec![[0.0_f32; CELL_PARTS]; ends.len()];
        for run in runs {
            let reached = ends.partition_point(|cell| (cell + 1) * PARTS <= run.first)
                ..ends.partition_point(|cell| cell * PARTS < run.last);
            for (cell, parts) in ends[reached.clone()].iter().zip(&mut parts[reached]) {
                for k in run.first.max(cell * PARTS)..run.last.min((cell + 1) * PARTS) {
                    let length = run.end.min((k + 1) as f64) - run.start.max(k as f64);
                    #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
                    let length = length as f32;
                    parts[run.line * PARTS + k % PARTS] += length;
                }
            }
        }
        let mut column = Self::default();
        for (place, (cell, parts)) in ends.iter().zip(parts).enumerate() {
            column.push(*cell..cell + 1, &parts);
            let Some(next) = ends.get(place + 1).filter(|next| **next > cell + 1) else { continue };
            let mut parts = [0.0; CELL_PARTS];
            for run in runs.iter().filter(|run| run.first / PARTS <= *cell && run.last > next * PARTS) {
                parts[run.line * PARTS..(run.line + 1) * PARTS].fill(1.0);
            }
            column.push(cell + 1..*next, &parts);
        }
        column
    }

    /// Adds cells whose parts have equal fractions.
    fn push(&mut self, cells: Range<usize>, parts: &[f32; CELL_PARTS]) {
        // A millionth of a part is the rounding of coordinates.
        if parts.iter().all(|fraction| *fraction >= 1.0 - 1e-5) {
            self.whole.push(number(cells.start)..number(cells.end));
        } else if parts.iter().any(|fraction| *fraction > 0.0) {
            self.cut.extend(cells.map(|cell| (number(cell), Box::new(parts.map(|fraction| fraction.min(1.0))))));
        }
    }
}

/// The part of each cell that is inside, for some columns along z.
pub(crate) fn coverage(body: &dyn Body, lattice: &Lattice, columns: &[[u32; 2]]) -> Vec<Column> {
    let nz = lattice.counts[2];
    let part = lattice.step / PARTS as f64;
    let column = |scanner: &mut Scanner, [ix, iy]: [u32; 2]| {
        let [ix, iy] = [ix as usize, iy as usize];
        let mut runs = Vec::new();
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
                if first < last {
                    runs.push(Run { line, start, end, first, last });
                }
            }
        }
        Column::of_runs(&runs)
    };
    columns.par_iter().map_init(|| Scanner::new(body), |scanner, at| column(scanner, *at)).collect()
}

/// Points on the surface, from lines along each axis through some columns of cells.
///
/// Lines along axis k with a spacing δ cross an area A with normal n in A |n_k| / δ² points. Points with the area δ²
/// |n_k| therefore add up to A n_k², and the points of all three axes add up to A.
pub(crate) fn surface(body: &dyn Body, lattice: &Lattice, columns: &[Vec<[u32; 2]>; 3]) -> Vec<Sample> {
    let spacing = lattice.step / SURFACE_LINES as f64;
    let mut samples = Vec::new();
    for (axis, columns) in columns.iter().enumerate() {
        let [u, v] = across(axis);
        let row = |scanner: &mut Scanner, (columns, line): (&[[u32; 2]], usize)| {
            let mut found = Vec::new();
            let mut point = DVec3::ZERO;
            let place = |column: u32, line: usize| (column as usize * SURFACE_LINES + line) as f64 + 0.5;
            for (column, across) in columns.iter().flat_map(|column| (0..SURFACE_LINES).map(move |line| (column, line)))
            {
                point[u] = lattice.low[u] + place(column[0], line) * spacing[u];
                point[v] = lattice.low[v] + place(column[1], across) * spacing[v];
                for segment in scanner.segments(axis, point) {
                    for crossing in [segment.enter, segment.leave] {
                        point[axis] = crossing.coordinate_m;
                        let cos = crossing.normal[axis].abs();
                        #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
                        let (area_m2, length_m) = ((spacing[u] * spacing[v]) as f32 * cos, segment.length_m() as f32);
                        if area_m2 > 0.0 {
                            let element = SurfaceElement { point: point.as_vec3(), normal: crossing.normal, area_m2 };
                            found.push(Sample { element, thickness_m: length_m * cos });
                        }
                    }
                }
            }
            found
        };
        let rows: Vec<(&[[u32; 2]], usize)> = columns
            .chunk_by(|one, other| one[0] == other[0])
            .flat_map(|columns| (0..SURFACE_LINES).map(move |line| (columns, line)))
            .collect();
        let rows: Vec<Vec<Sample>> = rows.into_par_iter().map_init(|| Scanner::new(body), row).collect();
        samples.extend(rows.into_iter().flatten());
    }
    samples
}

/// Volume in m³: the sum of the fractions of cells that are inside, times the volume of a cell.
pub(crate) fn volume_m3(columns: &[Column], lattice: &Lattice) -> f64 {
    let cells = |column: &Column| -> f64 {
        let whole: u32 = column.whole.iter().map(|range| range.end - range.start).sum();
        let cut = column.cut.iter().map(|(_, parts)| f64::from(parts.iter().sum::<f32>()) / CELL_PARTS as f64);
        f64::from(whole) + cut.sum::<f64>()
    };
    columns.iter().map(cells).sum::<f64>() * lattice.step.x * lattice.step.y * lattice.step.z
}

#[expect(clippy::cast_possible_truncation, reason = "a lattice has at most 2^20 cells along an axis")]
fn number(count: usize) -> u32 {
    count as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{Ball, BoxBody};
    use glam::{DMat3, EulerRot};
    use std::f64::consts::PI;

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
            let found = volume_m3(&coverage(body, &lattice, &lattice.columns(2)), &lattice);
            assert!((found / expected_volume - 1.0).abs() < 2e-3, "{found} {expected_volume}");
            let samples = surface(body, &lattice, &[0, 1, 2].map(|axis| lattice.columns(axis)));
            let elements: Vec<SurfaceElement> = samples.into_iter().map(|sample| sample.element).collect();
            let area: f64 = elements.iter().map(|element| f64::from(element.area_m2)).sum();
            assert!((area / expected_area - 1.0).abs() < 0.01, "{area} {expected_area}");
            // ∮ n dA = 0 and ∮ x·n dA = 3 V (Gauss).
            let flux: f64 = elements
                .iter()
                .map(|element| {
                    f64::from(element.area_m2)
                        * (element.point.as_dvec3() - body.bounds()[0]).dot(element.normal.as_dvec3())
                })
                .sum();
            assert!((flux / (3.0 * expected_volume) - 1.0).abs() < 0.02, "{flux} {expected_volume}");
        }
    }
}
