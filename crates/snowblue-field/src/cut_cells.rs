//! The cells that the surface cuts or touches, with the part of each cell inside the body and its surface elements.

use rayon::prelude::*;

use crate::body::Body;
use crate::element::CELL_PARTS;
use crate::lattice::{Lattice, across};
use crate::octree::{Leaf, Octree, key, place};
use crate::scan::{Column, Sample, SurfaceElement, coverage, surface};

/// Depths below the surface, in cells, at which the cell of a surface element is searched for. The surface may lie on
/// the face of a cell, just outside of all cells, or in a cell whose sampled volume is zero because the body fills so
/// little of it. Light cannot enter through a cell without volume.
pub(crate) const INWARD: [f64; 4] = [1e-6, 0.1, 0.5, 1.0];

/// The cells that the surface cuts or touches, in order of their keys, and the surface elements, sorted by cell.
#[derive(Debug, Default)]
pub(crate) struct CutCells {
    pub(crate) cells: Vec<OneCut>,
    pub(crate) surface: Vec<SurfaceElement>,
    /// Thickness of the snow below each element, along the normal of the element, in m.
    pub(crate) thickness_m: Vec<f32>,
}

/// A cell that the surface cuts or touches.
#[derive(Debug)]
pub(crate) struct OneCut {
    /// Key of the finest cell at its corner of least coordinates.
    pub(crate) key: u64,
    /// The fraction of each part of the cell that is inside the body; none if the whole cell is inside.
    pub(crate) inside: Option<Box<[f32; CELL_PARTS]>>,
    /// The range of its surface elements.
    pub(crate) surface: [u32; 2],
}

/// The lines through the cells of one level: lines along each axis, grouped by columns of cells.
struct Scan {
    level: u8,
    lattice: Lattice,
    columns: [Vec<[u32; 2]>; 3],
    /// The coverage of the columns along z.
    covered: Vec<Column>,
}

impl Scan {
    fn new(body: &dyn Body, lattice: &Lattice, level: u8, columns: [Vec<[u32; 2]>; 3]) -> Self {
        let lattice = lattice.coarsened(level);
        let covered = coverage(body, &lattice, &columns[2]);
        Self { level, lattice, columns, covered }
    }

    /// Whether no part of a cell of this level is inside the body, according to the lines through the cell.
    fn is_empty(&self, [x, y, z]: [u32; 3]) -> bool {
        self.columns[2].binary_search(&[x, y]).map_or(true, |column| self.covered[column].is_empty(z))
    }
}

impl CutCells {
    /// The cut cells of a lattice with cells of one size.
    pub(crate) fn finest(body: &dyn Body, lattice: &Lattice) -> Self {
        let scan = Scan::new(body, lattice, 0, [0, 1, 2].map(|axis| lattice.columns(axis)));
        Self::of_scans(body, lattice, vec![scan], &|_| 0)
    }

    /// The cut cells of an octree. Lines pass through the demanded cells of each level and through neighbouring
    /// columns.
    pub(crate) fn of_octree(body: &dyn Body, lattice: &Lattice, octree: &Octree, leaves: &[Leaf]) -> Self {
        let mut by_level: Vec<Vec<[u32; 3]>> = Vec::new();
        for leaf in leaves.iter().filter(|leaf| leaf.is_demanded) {
            let level = usize::from(leaf.level);
            by_level.resize_with(by_level.len().max(level + 1), Vec::new);
            by_level[level].push(leaf.place);
        }
        let scans = (0..).zip(by_level).filter(|(_, places)| !places.is_empty()).map(|(level, places)| {
            let counts = lattice.coarsened(level).counts;
            let columns = [0, 1, 2].map(|axis| {
                let [u, v] = across(axis);
                columns_around(places.iter().map(|place| [place[u], place[v]]).collect(), [counts[u], counts[v]])
            });
            Scan::new(body, lattice, level, columns)
        });
        Self::of_scans(body, lattice, scans.collect(), &|finest| octree.find(finest).1)
    }

    /// `level_at` gives the level of the cell that contains a finest cell. Samples by lines of another level are
    /// discarded.
    fn of_scans(
        body: &dyn Body,
        lattice: &Lattice,
        scans: Vec<Scan>,
        level_at: &(dyn Fn([u32; 3]) -> u8 + Sync),
    ) -> Self {
        let is_empty = |level: u8, place: [u32; 3]| {
            scans.iter().find(|scan| scan.level == level).is_none_or(|scan| scan.is_empty(place))
        };
        // The cell of a surface element: its level, and the key of its first finest cell.
        let cell_of = |element: &SurfaceElement| {
            let point = element.point.as_dvec3();
            let step = lattice.step * f64::from(1u32 << level_at(lattice.cell_at(point)));
            let inward = element.normal.as_dvec3() * step;
            let cells = INWARD.map(|steps| {
                let finest = lattice.cell_at(point - inward * steps);
                let level = level_at(finest);
                (level, finest.map(|k| k >> level))
            });
            let (level, place) = *cells.iter().find(|(level, place)| !is_empty(*level, *place)).unwrap_or(&cells[0]);
            (level, key(place.map(|k| k << level)))
        };
        let mut found: Vec<(u64, Sample)> = Vec::new();
        for scan in &scans {
            let samples = surface(body, &scan.lattice, &scan.columns).into_par_iter();
            let keyed = samples.map(|sample| (cell_of(&sample.element), sample));
            let own = keyed.filter(|((level, _), _)| *level == scan.level);
            let open =
                own.filter(|(_, Sample { element, .. })| !body.is_covered(element.point.as_dvec3(), element.normal));
            found.par_extend(open.map(|((_, key), sample)| (key, sample)));
        }
        found.sort_by_key(|(key, _)| *key);
        // Cells that the surface only touches may be inside or outside.
        let touched = found.chunk_by(|one, other| one.0 == other.0).map(|samples| {
            let (key, finest) = (samples[0].0, place(samples[0].0));
            let level = level_at(finest);
            (key, is_empty(level, finest.map(|k| k >> level)).then(|| Box::new([0.0; CELL_PARTS])))
        });
        let touched: Vec<(u64, Option<Box<[f32; CELL_PARTS]>>)> = touched.collect();
        let mut covered = Vec::new();
        for Scan { level, columns, covered: covered_columns, .. } in scans {
            for ([x, y], column) in columns[2].iter().zip(covered_columns) {
                for (z, inside) in column.cut {
                    let finest = [*x, *y, z].map(|k| k << level);
                    if level_at(finest) == level {
                        covered.push((key(finest), Some(inside)));
                    }
                }
            }
        }
        covered.extend(touched);
        // The coverage by lines along z comes first, and is kept.
        covered.sort_by_key(|(key, _)| *key);
        covered.dedup_by_key(|(key, _)| *key);
        let (mut cells, mut start) = (Vec::with_capacity(covered.len()), 0);
        for (key, inside) in covered {
            let end = start + found[start..].partition_point(|(other, _)| *other <= key);
            cells.push(OneCut { key, inside, surface: [start, end].map(number) });
            start = end;
        }
        let surface = found.iter().map(|(_, sample)| sample.element).collect();
        let thickness_m = found.iter().map(|(_, sample)| sample.thickness_m).collect();
        Self { cells, surface, thickness_m }
    }

    /// The keys of all cells, in order.
    pub(crate) fn keys(&self) -> Vec<u64> {
        self.cells.iter().map(|cell| cell.key).collect()
    }
}

/// The given columns and their neighbours, in order.
fn columns_around(mut columns: Vec<[u32; 2]>, counts: [usize; 2]) -> Vec<[u32; 2]> {
    columns.sort_unstable();
    columns.dedup();
    for axis in 0..2 {
        let around = |column: [u32; 2]| {
            let range = column[axis].saturating_sub(1)..=(column[axis] + 1).min(number(counts[axis]) - 1);
            range.map(move |at| std::array::from_fn(|k| if k == axis { at } else { column[k] }))
        };
        columns = columns.into_iter().flat_map(around).collect();
        columns.sort_unstable();
        columns.dedup();
    }
    columns
}

#[expect(clippy::cast_possible_truncation, reason = "fewer than 2^31 cells and elements")]
fn number(count: usize) -> u32 {
    count as u32
}
