//! 3×3 matrices whose products and inverses are evaluated at compile time.

/// A row or column vector.
pub(crate) type Vector = [f64; 3];
/// Three rows of a matrix.
pub(crate) type Matrix = [Vector; 3];

/// Product of a matrix and a column vector.
pub(crate) const fn product(matrix: Matrix, vector: Vector) -> Vector {
    [dot(matrix[0], vector), dot(matrix[1], vector), dot(matrix[2], vector)]
}

/// Matrix product `left` · `right`, which applies `right` first.
pub(crate) const fn compose(left: Matrix, right: Matrix) -> Matrix {
    let columns = transpose(right);
    transpose([product(left, columns[0]), product(left, columns[1]), product(left, columns[2])])
}

pub(crate) const fn transpose([a, b, c]: Matrix) -> Matrix {
    [[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]]
}

/// Component-wise product.
pub(crate) const fn multiply(left: Vector, right: Vector) -> Vector {
    [left[0] * right[0], left[1] * right[1], left[2] * right[2]]
}

/// Inverse: the columns are cross products of the rows divided by the determinant.
pub(crate) const fn inverse([first, second, third]: Matrix) -> Matrix {
    let [a, b, c] = [cross(second, third), cross(third, first), cross(first, second)];
    let scale = 1.0 / dot(first, a);
    transpose([multiply(a, [scale; 3]), multiply(b, [scale; 3]), multiply(c, [scale; 3])])
}

pub(crate) const fn dot(left: Vector, right: Vector) -> f64 {
    left[0] * right[0] + left[1] * right[1] + left[2] * right[2]
}

const fn cross(left: Vector, right: Vector) -> Vector {
    [
        left[1] * right[2] - left[2] * right[1],
        left[2] * right[0] - left[0] * right[2],
        left[0] * right[1] - left[1] * right[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_times_its_inverse_is_the_identity() {
        let matrix = [[2.0, 1.0, 0.5], [-1.0, 3.0, 0.0], [0.25, -2.0, 4.0]];
        let both = compose(inverse(matrix), matrix);
        for (found, expected) in product(both, [1.0, -2.0, 3.0]).into_iter().zip([1.0, -2.0, 3.0]) {
            assert!((found - expected).abs() < 1e-14, "{both:?}");
        }
    }

    #[test]
    fn the_right_matrix_is_applied_first() {
        let swap = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let double_first = [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let [first, second, _] = product(compose(swap, double_first), [1.0, 5.0, 7.0]);
        assert!((first - 5.0).abs() < 1e-15 && (second - 2.0).abs() < 1e-15, "{first} {second}");
    }
}
