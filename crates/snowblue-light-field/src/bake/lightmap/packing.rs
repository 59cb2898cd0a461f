//! Rectangles side by side on shelves of a square.

use glam::DVec2;

/// Texels around each chart that belong to no other one.
pub(super) const GUTTER: u32 = 2;
/// Bisections of the interval of scales.
const STEPS: u32 = 40;

/// Where rectangles lie in a square of texels, with their gutters.
#[derive(Debug, PartialEq)]
pub(in crate::bake) struct Packing {
    pub(super) texels_per_m: f64,
    /// The lower corner of each rectangle's gutter, column and row.
    pub(super) corners: Vec<[u32; 2]>,
}

/// Packs rectangles, sides in m, into a square of `size` texels at the greatest scale for which shelves of falling
/// height suffice. None if they do not fit at one texel each.
pub(super) fn pack(extents_m: &[DVec2], size: u32) -> Option<Packing> {
    let mut order: Vec<usize> = (0..extents_m.len()).collect();
    order.sort_by(|one, other| extents_m[*other].y.total_cmp(&extents_m[*one].y));
    let mut corners = shelves(extents_m, &order, size, 0.0)?;
    let area_m2: f64 = extents_m.iter().map(|extent| extent.element_product()).sum();
    let longest_m = extents_m.iter().map(|extent| extent.x).fold(f64::MIN_POSITIVE, f64::max);
    let (mut fits, mut fails) = (0.0, f64::from(size) / longest_m.max(area_m2.sqrt()));
    for _ in 0..STEPS {
        let scale = 0.5 * (fits + fails);
        if let Some(found) = shelves(extents_m, &order, size, scale) {
            (fits, corners) = (scale, found);
        } else {
            fails = scale;
        }
    }
    Some(Packing { texels_per_m: fits, corners })
}

/// Columns and rows of a rectangle with its gutter, at least one texel without.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an extent in texels is small")]
pub(super) fn with_gutter(extent_m: DVec2, texels_per_m: f64) -> [u32; 2] {
    (extent_m * texels_per_m).to_array().map(|length| length.ceil().max(1.0) as u32 + 2 * GUTTER)
}

/// The corners of rectangles in an order of falling height; none if they do not fit.
fn shelves(extents_m: &[DVec2], order: &[usize], size: u32, texels_per_m: f64) -> Option<Vec<[u32; 2]>> {
    let mut corners = vec![[0; 2]; extents_m.len()];
    // Where the next rectangle goes, and the height of the shelf.
    let ([mut column, mut row], mut height) = ([0, 0], 0);
    for &number in order {
        let [columns, rows] = with_gutter(extents_m[number], texels_per_m);
        if column + columns > size {
            (column, row, height) = (0, row + height, 0);
        }
        height = height.max(rows);
        if columns > size || row + height > size {
            return None;
        }
        corners[number] = [column, row];
        column += columns;
    }
    Some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_fill_the_square_without_overlap() {
        let extents: Vec<DVec2> =
            (1..90).map(|k| DVec2::new(0.02 * f64::from(k % 13 + 7), 0.01 * f64::from(k % 7 + 1))).collect();
        for size in [64, 256, 1024] {
            let packing = pack(&extents, size).unwrap();
            let mut taken = vec![false; (size * size) as usize];
            for (extent, [column, row]) in extents.iter().zip(&packing.corners) {
                let [columns, rows] = with_gutter(*extent, packing.texels_per_m);
                for row in *row..row + rows {
                    for column in *column..column + columns {
                        assert!(!std::mem::replace(&mut taken[(row * size + column) as usize], true));
                    }
                }
            }
            let share = taken.iter().filter(|taken| **taken).count() as f64 / taken.len() as f64;
            assert!(share > 0.75, "{size}: {share}");
        }
        assert_eq!(pack(&extents, 32), None, "89 rectangles of 5 × 5 texels are more than 32 × 32");
    }

    #[test]
    fn a_square_is_as_large_as_its_gutter_leaves() {
        let packing = pack(&[DVec2::splat(2.0)], 100).unwrap();
        assert!((packing.texels_per_m - 48.0).abs() < 1e-6, "{packing:?}");
        assert_eq!(packing.corners, [[0, 0]]);
        assert!(pack(&[DVec2::ZERO], 8).is_some(), "a chart without area has a texel");
    }
}
