//! Triangles of a plane in a quadtree, to find those that another one overlaps, whatever sizes they have.

use std::collections::HashMap;

use glam::DVec2;

/// Overlaps of triangles by less than this fraction of their edges are rounding.
const ROUNDING: f64 = 1e-9;
/// Most halvings of squares. Smaller triangles are in squares that are wider than they are.
const MOST_HALVINGS: f64 = 40.0;

/// A square of the plane: how often the first one is halved for its side, its column and its row.
type Square = (i32, [i64; 2]);

const FIRST_SQUARE: Square = (0, [0; 2]);

/// Triangles, each in the smallest square that is as wide as it and has its middle.
pub(super) struct Quadtree {
    /// Side of the first square, in m. Its middle is the origin.
    side_m: f64,
    /// Squares with triangles in them, or in a part of them.
    squares: HashMap<Square, Vec<[DVec2; 3]>>,
}

impl Quadtree {
    /// No triangles yet; the places of all have coordinates of at most `reach_m`.
    pub(super) fn around(reach_m: f64) -> Self {
        // Twice as wide as the places, for rounding.
        Self { side_m: 4.0 * reach_m, squares: HashMap::new() }
    }

    #[expect(clippy::cast_possible_truncation, reason = "there are 2⁴⁰ squares in a row at most")]
    pub(super) fn add(&mut self, triangle: [DVec2; 3]) {
        let (low, high) = bounds(triangle.into_iter());
        let halvings = (self.side_m / (high - low).max_element()).log2().floor().clamp(0.0, MOST_HALVINGS);
        let place = (low.midpoint(high) / self.side_m + 0.5) * halvings.exp2();
        let mut square = (halvings as i32, place.floor().to_array().map(|index| index as i64));
        self.squares.entry(square).or_default().push(triangle);
        while square != FIRST_SQUARE {
            square = (square.0 - 1, square.1.map(|index| index / 2));
            self.squares.entry(square).or_default();
        }
    }

    /// Whether a triangle, counter-clockwise, overlaps one of these.
    pub(super) fn overlaps(&self, triangle: &[DVec2; 3]) -> bool {
        self.overlaps_in(triangle, FIRST_SQUARE)
    }

    /// Whether a triangle overlaps one that is in a square.
    fn overlaps_in(&self, triangle: &[DVec2; 3], square: Square) -> bool {
        let Some(triangles) = self.squares.get(&square) else { return false };
        let (halvings, [column, row]) = square;
        let side_m = self.side_m * f64::from(-halvings).exp2();
        let middle = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * side_m - 0.5 * self.side_m;
        // Triangles reach beyond their square by half of its side.
        let (low, high) = bounds(triangle.iter().copied());
        if (middle - side_m).cmpgt(high).any() || (middle + side_m).cmplt(low).any() {
            return false;
        }
        triangles.iter().any(|other| !are_apart(triangle, other) && !are_apart(other, triangle))
            || [(0, 0), (0, 1), (1, 0), (1, 1)]
                .into_iter()
                .any(|(right, up)| self.overlaps_in(triangle, (halvings + 1, [2 * column + right, 2 * row + up])))
    }
}

/// The corners of least and greatest coordinates of the rectangle about points.
pub(super) fn bounds(points: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
}

/// Whether an edge of the first triangle, counter-clockwise, has all of the other one on its outer side.
fn are_apart([a, b, c]: &[DVec2; 3], other: &[DVec2; 3]) -> bool {
    [(a, b), (b, c), (c, a)].into_iter().any(|(from, to)| {
        let edge = *to - *from;
        other.iter().all(|corner| {
            let across = *corner - *from;
            edge.perp_dot(across) <= ROUNDING * edge.length() * (edge.length() + across.length())
        })
    })
}
