//! Vertices at the same position, as at texture seams, where a surface has one vertex and a mesh several.

use glam::Vec3;

/// For each vertex, the first vertex with the same position.
#[expect(clippy::cast_possible_truncation, reason = "vertex indices have 32 bits")]
pub fn merged(positions: &[Vec3]) -> Vec<u32> {
    // Adding zero turns negative zeros into positive ones.
    let key = |position: Vec3| (position + 0.0).to_array().map(f32::to_bits);
    // A hash table with open addressing: the slots hold vertices, each that of a new position.
    let bits = (2 * positions.len()).next_power_of_two().trailing_zeros().max(1);
    let mut slots = vec![u32::MAX; 1 << bits];
    let mut first = Vec::with_capacity(positions.len());
    for (index, position) in positions.iter().enumerate() {
        let key_here = key(*position);
        let mut slot = (hash(key_here) >> (u64::BITS - bits)) as usize;
        while slots[slot] != u32::MAX && key(positions[slots[slot] as usize]) != key_here {
            slot = (slot + 1) & (slots.len() - 1);
        }
        if slots[slot] == u32::MAX {
            slots[slot] = index as u32;
        }
        first.push(slots[slot]);
    }
    first
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

    #[test]
    fn only_used_positions_are_kept() {
        let (mut positions, mut triangles) = (vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE], [[3, 0, 1], [0, 3, 3]]);
        keep_used(&mut positions, &mut triangles);
        assert_eq!((positions, triangles), (vec![Vec3::ONE, Vec3::X, Vec3::Y], [[0, 1, 2], [1, 0, 0]]));
    }

    #[test]
    fn the_first_of_equal_positions_represents_them() {
        let positions = [Vec3::X, Vec3::new(0.0, 1.0, -0.0), Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::X];
        assert_eq!(merged(&positions), [0, 1, 0, 1, 4, 0]);
        assert!(merged(&[]).is_empty());
        assert_eq!(merged(&[Vec3::ONE; 3]), [0; 3]);
        // A grid of many positions, twice.
        let grid = |k: u16| Vec3::new(f32::from(k % 64), f32::from(k / 64 % 64), f32::from(k / 4096)) / 7.0;
        let twice: Vec<Vec3> = (0..32768).chain(0..32768).map(grid).collect();
        assert!((0..).zip(merged(&twice)).all(|(index, first)| first == index % 32768));
    }
}
