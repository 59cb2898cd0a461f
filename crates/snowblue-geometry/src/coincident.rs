//! Coincident vertices: a mesh has several vertices where the surface has one point, as at texture seams and at the
//! pole of a sphere.
//!
//! Programs compute these vertices in several ways, so that their positions may differ by a rounding error: the sine
//! of 180° is 10⁻¹⁶ and not 0. Vertices coincide if their distance is within [`TOLERANCE`] times the longest side of
//! the box around the mesh.

use glam::{DVec3, Vec3};

/// Greatest distance of coincident vertices, per longest side of the box around the triangles: 1.2·10⁻⁷, or at least
/// two units in the last place of a coordinate of a mesh about the origin in single precision.
pub const TOLERANCE: f64 = f32::EPSILON as f64;

/// Side of a cell of the grid that finds close vertices, in tolerances. In smaller cells more vertices lie near a
/// side, and are looked up in the neighbouring cell too; larger cells may hold more vertices.
const CELL: f64 = 8.0;

/// As [`merged_within`], for vertices that coincide.
pub fn merged(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    merged_within(positions, triangles, 0.0)
}

/// For each vertex, the first vertex that coincides with it or lies within a distance. This vertex represents these
/// vertices and itself. Distances between representatives exceed the tolerance and the distance. A vertex that is not
/// finite represents itself only. Vertices that no triangle uses do not count for the size of the mesh.
#[expect(clippy::cast_possible_truncation, reason = "vertex indices have 32 bits")]
pub fn merged_within(positions: &[Vec3], triangles: &[[u32; 3]], distance: f64) -> Vec<u32> {
    let mut grid = Grid::around(triangles.as_flattened().iter().map(|corner| positions[*corner as usize]));
    grid.tolerance = grid.tolerance.max(distance);
    // A hash table with open addressing: each slot holds the vertex of a new position.
    let bits = (2 * positions.len()).next_power_of_two().trailing_zeros().max(1);
    let mut slots = vec![u32::MAX; 1 << bits];
    let mut first = Vec::with_capacity(positions.len());
    for (index, position) in positions.iter().enumerate() {
        let slot_of = |cell: [u32; 3]| (hash(cell) >> (u64::BITS - bits)) as usize;
        let mut found = None;
        for mut slot in grid.cells(*position).map(slot_of) {
            while slots[slot] != u32::MAX {
                if grid.are_close(*position, positions[slots[slot] as usize]) {
                    found = Some(found.map_or(slots[slot], |first: u32| first.min(slots[slot])));
                }
                slot = (slot + 1) & (slots.len() - 1);
            }
        }
        first.push(found.unwrap_or_else(|| {
            let mut slot = slot_of(grid.cell(*position, 0.0));
            while slots[slot] != u32::MAX {
                slot = (slot + 1) & (slots.len() - 1);
            }
            slots[slot] = index as u32;
            index as u32
        }));
    }
    first
}

/// Triangles of the vertices that represent their corners ([`merged`]).
pub(crate) fn renumbered(triangles: &[[u32; 3]], vertices: &[u32]) -> Vec<[u32; 3]> {
    triangles.iter().map(|triangle| triangle.map(|corner| vertices[corner as usize])).collect()
}

/// Moves each vertex to the first vertex that coincides with it, so that no ray passes between them. Returns these
/// first vertices.
pub fn weld(positions: &mut [Vec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    let vertices = merged(positions, triangles);
    for (index, first) in vertices.iter().enumerate() {
        positions[index] = positions[*first as usize];
    }
    vertices
}

/// A grid around vertices.
struct Grid {
    low: DVec3,
    tolerance: f64,
}

impl Grid {
    fn around(positions: impl Iterator<Item = Vec3>) -> Self {
        let finite = positions.filter(|position| position.is_finite());
        let ends = finite.fold(None, |ends: Option<[Vec3; 2]>, position| {
            let [low, high] = ends.unwrap_or([position; 2]);
            Some([low.min(position), high.max(position)])
        });
        let [low, high] = ends.unwrap_or_default().map(|end| end.as_dvec3());
        Self { low, tolerance: TOLERANCE * (high - low).max_element() }
    }

    fn are_close(&self, position: Vec3, other: Vec3) -> bool {
        position.as_dvec3().distance_squared(other.as_dvec3()) <= self.tolerance * self.tolerance
    }

    /// The cell of a position that is moved by a number of tolerances along all axes. Regular meshes have positions at
    /// the lower side plus its length divided by a power of two, which lie in the middle of cells.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "there are 2²⁰ cells along an axis")]
    fn cell(&self, position: Vec3, moved: f64) -> [u32; 3] {
        let at = (position.as_dvec3() - self.low) / (CELL * self.tolerance) + 0.5 + moved / CELL;
        at.to_array().map(|at| at as u32)
    }

    /// The cells that may hold positions within the tolerance of a position.
    fn cells(&self, position: Vec3) -> impl Iterator<Item = [u32; 3]> {
        let ([ax, ay, az], [bx, by, bz]) = (self.cell(position, -1.0), self.cell(position, 1.0));
        (ax..=bx).flat_map(move |x| (ay..=by).flat_map(move |y| (az..=bz).map(move |z| [x, y, z])))
    }
}

/// Keeps the positions that triangles use, in the order in which they use them.
#[expect(clippy::cast_possible_truncation, reason = "vertex indices have 32 bits")]
pub fn keep_used(positions: &mut Vec<Vec3>, triangles: &mut [[u32; 3]]) {
    let mut renumbered = vec![u32::MAX; positions.len()];
    let mut used = Vec::new();
    for corner in triangles.iter_mut().flatten() {
        let new = &mut renumbered[*corner as usize];
        if *new == u32::MAX {
            *new = used.len() as u32;
            used.push(positions[*corner as usize]);
        }
        *corner = *new;
    }
    *positions = used;
}

/// A hash of three words, whose upper bits are well mixed (multiplicative hashing, Knuth 1998, *The Art of Computer
/// Programming* 3, section 6.4).
fn hash(words: [u32; 3]) -> u64 {
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    words.into_iter().fold(0, |hash: u64, word| (hash.rotate_left(26) ^ u64::from(word)).wrapping_mul(GOLDEN))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [`merged`] for vertices that are all used by triangles.
    fn merged_all(positions: &[Vec3]) -> Vec<u32> {
        let triangles: Vec<[u32; 3]> = (0..).zip(positions).map(|(index, _)| [index; 3]).collect();
        merged(positions, &triangles)
    }

    #[test]
    fn only_used_positions_are_kept() {
        let (mut positions, mut triangles) = (vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE], [[3, 0, 1], [0, 3, 3]]);
        keep_used(&mut positions, &mut triangles);
        assert_eq!((positions, triangles), (vec![Vec3::ONE, Vec3::X, Vec3::Y], [[0, 1, 2], [1, 0, 0]]));
    }

    #[test]
    fn the_first_of_equal_positions_represents_them() {
        let positions = [Vec3::X, Vec3::new(0.0, 1.0, -0.0), Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::X];
        assert_eq!(merged_all(&positions), [0, 1, 0, 1, 4, 0]);
        assert!(merged_all(&[]).is_empty());
        assert_eq!(merged_all(&[Vec3::ONE; 3]), [0; 3]);
        // A grid of many positions, twice.
        let grid = |k: u16| Vec3::new(f32::from(k % 64), f32::from(k / 64 % 64), f32::from(k / 4096)) / 7.0;
        let twice: Vec<Vec3> = (0..32768).chain(0..32768).map(grid).collect();
        assert!((0..).zip(merged_all(&twice)).all(|(index, first)| first == index % 32768));
    }

    #[test]
    fn positions_within_the_tolerance_of_the_size_are_one() {
        for size in [1e-20_f32, 1.0, 1e20] {
            let box_of_size = [Vec3::splat(-0.5 * size), Vec3::splat(0.5 * size)];
            // Points on a sphere around a position, which lies on a side of a cell or inside a cell.
            for middle in (0..40u8).map(|k| 0.01 * f32::from(k) * size * Vec3::new(0.25, 0.5, 1.0)) {
                let directions = [Vec3::X, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::ONE.normalize()];
                let around = |distance: f32| directions.map(|direction| middle + direction * (distance * size));
                let of = |positions: [Vec3; 5]| merged_all(&[&box_of_size[..], &[middle], &positions].concat());
                assert_eq!(of(around(0.7 * f32::EPSILON)), [0, 1, 2, 2, 2, 2, 2, 2], "{middle}");
                assert!(of(around(1.7 * f32::EPSILON))[3..].iter().all(|first| *first != 2), "{middle}");
            }
        }
    }

    #[test]
    fn positions_that_are_not_finite_represent_themselves_only() {
        let positions = [Vec3::ZERO, Vec3::splat(f32::NAN), Vec3::X, Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::X];
        assert_eq!(merged_all(&positions), [0, 1, 2, 3, 4, 2]);
        assert_eq!(merged_all(&[Vec3::splat(f32::NAN)]), [0]);
    }

    #[test]
    fn welded_positions_are_equal() {
        let mut positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1e-17, 0.0, -1e-17), Vec3::new(1.0, 0.0, 1e-8)];
        weld(&mut positions, &[[0, 1, 2], [3; 3]]);
        assert_eq!(positions, [Vec3::ZERO, Vec3::X, Vec3::ZERO, Vec3::X]);
    }

    #[test]
    fn vertices_that_no_triangle_uses_merge_no_others() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::splat(-1e9), Vec3::splat(1e9), Vec3::X];
        assert_eq!(merged(&positions, &[[0, 1, 2]]), [0, 1, 2, 3, 4, 1]);
    }
}
