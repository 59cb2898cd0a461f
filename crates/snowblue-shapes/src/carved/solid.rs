//! Solids given by their signed distances, in m: the distance to the surface, negative inside.
//!
//! All distances are exact. The distances of two points therefore differ by no more than the distance between the
//! points. The search for the surface relies on this.

use glam::{DMat3, DVec2, DVec3};

/// A solid to heap up or to take away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Solid {
    /// An ellipsoid.
    Ellipsoid {
        /// Its centre, in m.
        centre: DVec3,
        /// Its axes, as columns.
        axes: DMat3,
        /// Half its lengths along its axes, in m.
        radii_m: DVec3,
    },
    /// A box.
    Box {
        /// Its centre, in m.
        centre: DVec3,
        /// Its axes, as columns.
        axes: DMat3,
        /// Its lengths along its axes, in m.
        size_m: DVec3,
        /// Radius of its edges, in m.
        edge_m: f64,
    },
    /// The convex hull of two balls.
    Capsule {
        /// Centre of the first ball, in m.
        from: DVec3,
        /// Centre of the second ball, in m.
        to: DVec3,
        /// Their radii, in m.
        radii_m: [f64; 2],
    },
    /// A round cylinder with level ends.
    Cylinder {
        /// Centre of its first end, in m.
        from: DVec3,
        /// Centre of its second end, in m.
        to: DVec3,
        /// Its radius, in m.
        radius_m: f64,
        /// Radius of its edges, in m.
        edge_m: f64,
    },
    /// The half-space behind a plane.
    HalfSpace {
        /// A point of the plane, in m.
        point: DVec3,
        /// Unit normal of the plane, out of the half-space.
        normal: DVec3,
    },
}

impl Solid {
    /// The signed distance of a point, in m.
    pub(super) fn distance_m(&self, point: DVec3) -> f64 {
        match *self {
            Self::Ellipsoid { centre, axes, radii_m } => {
                ellipsoid_distance_m(radii_m, axes.transpose() * (point - centre))
            }
            Self::Box { centre, axes, size_m, edge_m } => {
                let beyond = (axes.transpose() * (point - centre)).abs() - 0.5 * size_m + edge_m;
                beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0) - edge_m
            }
            Self::Capsule { from, to, radii_m } => capsule_distance_m(point - from, to - from, radii_m),
            Self::Cylinder { from, to, radius_m, edge_m } => {
                let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
                let axis = half.normalize();
                let along_m = (point - middle).dot(axis);
                let aside_m = (point - middle - along_m * axis).length();
                let beyond = DVec2::new(aside_m - radius_m, along_m.abs() - half.length()) + edge_m;
                beyond.max(DVec2::ZERO).length() + beyond.max_element().min(0.0) - edge_m
            }
            Self::HalfSpace { point: foot, normal } => (point - foot).dot(normal),
        }
    }

    /// The lowest and the highest coordinates; none for a half-space.
    pub(super) fn bounds(&self) -> Option<[DVec3; 2]> {
        let about = |centre: DVec3, reach: DVec3| [centre - reach, centre + reach];
        match *self {
            // The greatest coordinate on an axis is the length of a row of the matrix that maps the unit ball to the
            // ellipsoid.
            Self::Ellipsoid { centre, axes, radii_m } => {
                let rows = (axes * DMat3::from_diagonal(radii_m)).transpose();
                Some(about(centre, DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length())))
            }
            Self::Box { centre, axes, size_m, .. } => {
                let reach = axes.x_axis.abs() * size_m.x + axes.y_axis.abs() * size_m.y + axes.z_axis.abs() * size_m.z;
                Some(about(centre, 0.5 * reach))
            }
            Self::Capsule { from, to, radii_m: [first_m, second_m] } => {
                Some([(from - first_m).min(to - second_m), (from + first_m).max(to + second_m)])
            }
            Self::Cylinder { from, to, radius_m, .. } => {
                let axis = (to - from).normalize();
                let reach = radius_m * (1.0 - axis * axis).max(DVec3::ZERO).map(f64::sqrt);
                Some([from.min(to) - reach, from.max(to) + reach])
            }
            Self::HalfSpace { .. } => None,
        }
    }
}

/// Distance to an ellipsoid about the origin with the axes of the coordinates.
///
/// The point of the surface nearest to y is x with xᵢ = rᵢ² yᵢ / (rᵢ² + t), where t is the greatest root of Σ (rᵢ yᵢ /
/// (rᵢ² + t))² = 1 (Eberly 2013, *Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid*, Geometric
/// Tools). Here t is measured from the pole of the least radius. The sum is convex and falls with t, so Newton's
/// method from below the root approaches the root without passing it. Each summand alone gives a lower bound of the
/// root.
fn ellipsoid_distance_m(radii: DVec3, point: DVec3) -> f64 {
    /// Least coordinate as a fraction of its radius. In a plane of symmetry the root would lie at a pole.
    const LEAST: f64 = 1e-9;
    let y = point.abs().max(LEAST * radii);
    let squares = radii * radii;
    let offsets = squares - squares.min_element();
    let mut t = (radii * y - offsets).max_element();
    for _ in 0..100 {
        let ratios = radii * y / (offsets + t);
        let slope = (ratios * ratios / (offsets + t)).element_sum();
        let step = 0.5 * (ratios.length_squared() - 1.0) / slope;
        t += step;
        if step <= 1e-14 * t {
            break;
        }
    }
    let distance_m = (y - squares * y / (offsets + t)).length();
    if (y / radii).length_squared() < 1.0 { -distance_m } else { distance_m }
}

/// Distance to the hull of a ball about the origin and a second ball about `axis`.
///
/// The hull is the union of the balls about a + τ (b − a) with radii between the radii of both balls. The distance to
/// such a ball is a convex function of τ. The least value of this function between the two ends is the distance to the
/// hull. At the minimum, the direction from the ball's centre to the point has the slope σ = (r₁ − r₀)/|b − a| against
/// the axis.
fn capsule_distance_m(point: DVec3, axis: DVec3, [first_m, second_m]: [f64; 2]) -> f64 {
    let length_m = axis.length();
    let slope = (second_m - first_m) / length_m;
    let fraction = if slope.abs() < 1.0 {
        let along_m = point.dot(axis) / length_m;
        let aside_m = (point - along_m * axis / length_m).length();
        ((along_m + slope * aside_m / (1.0 - slope * slope).sqrt()) / length_m).clamp(0.0, 1.0)
    } else if slope > 0.0 {
        1.0
    } else {
        0.0
    };
    (point - fraction * axis).length() - first_m - fraction * (second_m - first_m)
}

/// The smaller of two distances, rounded where the distances differ by less than `rounding_m`: the quadratic
/// polynomial smooth minimum (Quilez 2013, "Smooth minimum", <https://iquilezles.org/articles/smin>).
///
/// Its derivatives are weighted means of the derivatives of the two distances, so it changes no faster than the
/// distances. A chain of such minima is below the least of its distances by at most `rounding_m`.
pub(super) fn smooth_min_m(a_m: f64, b_m: f64, rounding_m: f64) -> f64 {
    let overlap_m = rounding_m - (a_m - b_m).abs();
    if overlap_m > 0.0 { a_m.min(b_m) - overlap_m * overlap_m / (4.0 * rounding_m) } else { a_m.min(b_m) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relief::uniform;
    use glam::{EulerRot, IVec3};

    fn random(number: i32, choice: i32) -> f64 {
        uniform(IVec3::new(number, choice, 0), 11)
    }

    fn random_point(number: i32, choice: i32, reach_m: f64) -> DVec3 {
        reach_m * (2.0 * DVec3::new(0.0, 1.0, 2.0).map(|k| random(number, 3 * choice + whole(k))) - 1.0)
    }

    #[expect(clippy::cast_possible_truncation, reason = "a small whole number")]
    fn whole(value: f64) -> i32 {
        value as i32
    }

    fn solids() -> [Solid; 7] {
        let axes = DMat3::from_euler(EulerRot::ZYX, 0.4, -0.7, 1.1);
        let (from, to) = (DVec3::new(-0.5, 0.2, 0.1), DVec3::new(0.6, -0.1, 0.7));
        let centre = DVec3::new(0.1, -0.2, 0.3);
        [
            Solid::Ellipsoid { centre, axes, radii_m: DVec3::new(1.3, 0.4, 0.8) },
            Solid::Ellipsoid { centre, axes, radii_m: DVec3::splat(0.7) },
            Solid::Box { centre, axes, size_m: DVec3::new(1.0, 0.5, 1.5), edge_m: 0.1 },
            Solid::Capsule { from, to, radii_m: [0.2, 0.5] },
            Solid::Capsule { from, to, radii_m: [0.2, 2.5] },
            Solid::Cylinder { from, to, radius_m: 0.4, edge_m: 0.05 },
            Solid::HalfSpace { point: centre, normal: axes.x_axis },
        ]
    }

    #[test]
    fn distances_are_exact() {
        for (kind, solid) in solids().iter().enumerate() {
            for number in 0..2000 {
                let point = random_point(number, 0, 2.0);
                let distance_m = solid.distance_m(point);
                // Along the gradient, the distance to the surface is the signed distance. Where the nearest point is
                // not unique, there is no gradient.
                let slope = |axis: DVec3| (solid.distance_m(point + axis) - solid.distance_m(point - axis)) / 2e-6;
                let gradient = DVec3::new(slope(1e-6 * DVec3::X), slope(1e-6 * DVec3::Y), slope(1e-6 * DVec3::Z));
                if (gradient.length() - 1.0).abs() < 1e-6 {
                    let foot = point - distance_m * gradient;
                    assert!(solid.distance_m(foot).abs() < 1e-5, "{kind}: {point} {}", solid.distance_m(foot));
                } else {
                    // The inside of a solid has few such points, and the outside has none.
                    assert!(distance_m < 0.0 && gradient.length() < 1.0 + 1e-6, "{kind}: {point} {gradient}");
                }
                let other = random_point(number, 1, 2.0);
                let change_m = (solid.distance_m(other) - distance_m).abs();
                assert!(change_m <= point.distance(other) * (1.0 + 1e-9), "{kind}: {point} {other}");
            }
        }
    }

    #[test]
    fn distances_have_known_values() {
        let at = |x, y, z| DVec3::new(x, y, z);
        let [_, ball, ..] = solids();
        assert!((ball.distance_m(at(0.1, -0.2, 1.3)) - 0.3).abs() < 1e-9);
        let (centre, axes) = (DVec3::ZERO, DMat3::IDENTITY);
        let egg = Solid::Ellipsoid { centre, axes, radii_m: at(3.0, 2.0, 1.0) };
        // In the middle, on the axes, and inside a plane of symmetry: of (2, 0, 0), x = 9 · 2/(9 − 1) = 2.25 and
        // z² = 1 − 2.25²/9.
        let planes = (0.25f64.powi(2) + 1.0 - 2.25f64.powi(2) / 9.0).sqrt();
        for (point, distance_m) in [
            (DVec3::ZERO, -1.0),
            (at(4.0, 0.0, 0.0), 1.0),
            (at(0.0, -5.0, 0.0), 3.0),
            (at(0.0, 0.0, 0.25), -0.75),
            (at(2.0, 0.0, 0.0), -planes),
            (at(0.0, 0.0, 1.0), 0.0),
        ] {
            assert!((egg.distance_m(point) - distance_m).abs() < 1e-8, "{point}: {}", egg.distance_m(point));
        }
        let block = Solid::Box { centre, axes, size_m: at(2.0, 2.0, 2.0), edge_m: 0.0 };
        assert!((block.distance_m(at(2.0, 2.0, 0.0)) - 2f64.sqrt()).abs() < 1e-12);
        assert!((block.distance_m(at(0.5, 0.0, 0.0)) + 0.5).abs() < 1e-12);
        let rod = Solid::Cylinder { from: centre, to: at(0.0, 0.0, 2.0), radius_m: 0.5, edge_m: 0.1 };
        assert!((rod.distance_m(at(1.5, 0.0, 1.0)) - 1.0).abs() < 1e-12);
        assert!((rod.distance_m(at(0.0, 0.0, -1.0)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn bounds_hold_the_solid_and_touch_it() {
        for (kind, solid) in solids().iter().enumerate() {
            let Some([low, high]) = solid.bounds() else {
                assert!(matches!(solid, Solid::HalfSpace { .. }));
                continue;
            };
            let (mut lowest, mut highest) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for number in 0..200_000 {
                let point = low + (high - low) * (random_point(number, 0, 0.6) + 0.5);
                if solid.distance_m(point) <= 0.0 {
                    lowest = lowest.min(point);
                    highest = highest.max(point);
                }
            }
            assert!(lowest.cmpge(low).all() && highest.cmple(high).all(), "{kind}");
            // The random points come within some hundredths of a metre of every side of the boxes, up to 5 m wide.
            assert!((lowest - low).max_element() < 0.15 && (high - highest).max_element() < 0.15, "{kind}");
        }
    }

    #[test]
    fn joints_are_smooth_and_bounded() {
        assert!((smooth_min_m(0.3, 0.5, 0.1) - 0.3).abs() < 1e-15, "away from the joint nothing changes");
        assert!((smooth_min_m(0.3, 0.3, 0.1) - 0.275).abs() < 1e-15, "a quarter of the rounding where both are equal");
        assert!((smooth_min_m(0.3, 0.5, 0.0) - 0.3).abs() < 1e-15);
        assert!((smooth_min_m(0.3, f64::INFINITY, 0.1) - 0.3).abs() < 1e-15);
        for chain in 0..500 {
            let distances: Vec<f64> = (0..40).map(|k| 0.2 * random(chain, k)).collect();
            let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
            let joined = distances.iter().copied().fold(f64::INFINITY, |a, b| smooth_min_m(a, b, 0.1));
            assert!(joined <= least && joined >= least - 0.1, "{joined} {least}");
        }
    }
}
