//! The smallest rectangle about points of a plane.

use glam::DVec2;

/// Turns and moves points into the smallest rectangle about them that has its lower corner at 0 and its longer sides
/// along x, and returns its sides. One side of the rectangle lies along the convex hull (Freeman & Shapira 1975,
/// "Determining the minimum-area encasing rectangle for an arbitrary closed curve", doi:10.1145/360881.360919). As it
/// turns along the hull, the corners that it touches advance (Toussaint 1983, "Solving geometric problems with the
/// rotating calipers").
pub(super) fn smallest_rectangle(points: &mut [DVec2]) -> DVec2 {
    let hull = convex_hull(points);
    let rectangle = |along: DVec2| {
        let points = hull.iter().map(|point| turned(*point, along));
        let (low, high) =
            points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)));
        (low, high - low)
    };
    let mut along = smallest_direction(&hull);
    let (mut low, mut extent) = rectangle(along);
    if extent.x < extent.y {
        along = along.perp();
        (low, extent) = rectangle(along);
    }
    points.iter_mut().for_each(|point| *point = turned(*point, along) - low);
    extent
}

/// The direction of the edge of a convex hull along which a rectangle about it has the least area.
fn smallest_direction(hull: &[DVec2]) -> DVec2 {
    let point = |number: usize| hull[number % hull.len()];
    let (mut smallest, mut direction) = (f64::INFINITY, DVec2::X);
    // The corners that lie farthest along the edge, across it and against it. Each turns once around the hull.
    let mut touched = [0; 3];
    for number in 0..hull.len() {
        let Some(along) = (point(number + 1) - point(number)).try_normalize() else { continue };
        let ways = [along, along.perp(), -along];
        for (k, way) in ways.into_iter().enumerate() {
            touched[k] = touched[k].max(if k == 0 { number + 1 } else { touched[k - 1] });
            while touched[k] < number + 2 * hull.len() && way.dot(point(touched[k] + 1) - point(touched[k])) > 0.0 {
                touched[k] += 1;
            }
        }
        let [right, top, left] = touched.map(point);
        let area = along.dot(right - left) * along.perp_dot(top - point(number));
        if area < smallest {
            (smallest, direction) = (area, along);
        }
    }
    direction
}

/// A point in axes of which the first has a direction.
fn turned(point: DVec2, along: DVec2) -> DVec2 {
    DVec2::new(along.dot(point), along.perp_dot(point))
}

/// The corners of the convex hull, counter-clockwise, by a monotone chain (Andrew 1979, "Another efficient algorithm
/// for convex hulls in two dimensions", doi:10.1016/0020-0190(79)90072-3).
fn convex_hull(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(|one, other| one.x.total_cmp(&other.x).then(one.y.total_cmp(&other.y)));
    let chain = |points: &mut dyn Iterator<Item = &DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., before, last] = chain[..] {
                if (last - before).perp_dot(*point - last) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let (mut hull, upper) = (chain(&mut sorted.iter()), chain(&mut sorted.iter().rev()));
    hull.extend(upper);
    if hull.is_empty() {
        // All points are one.
        hull.extend(sorted.first());
    }
    hull
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn the_rectangle_of_a_turned_one_is_itself() {
        let corners = [[0.0, 0.0], [0.0, 3.0], [1.0, 3.0], [1.0, 0.0], [0.4, 1.7]].map(DVec2::from);
        for angle in [0.0, 0.3, 1.2, 2.9] {
            let mut points = corners.map(|corner| DVec2::from_angle(angle).rotate(corner) + DVec2::new(7.0, -2.0));
            let extent = smallest_rectangle(&mut points);
            assert!(extent.distance(DVec2::new(3.0, 1.0)) < 1e-12, "{extent}");
            for (one, other) in [(0, 1), (1, 2), (2, 4), (4, 0)] {
                let length = |points: &[DVec2; 5]| points[one].distance(points[other]);
                assert!((length(&points) - length(&corners)).abs() < 1e-12, "it is turned and moved only");
            }
            assert!(points.iter().all(|point| point.min_element() > -1e-12 && (extent - point).min_element() > -1e-12));
            let around = [0, 1, 2, 3].map(|k| points[k].perp_dot(points[(k + 1) % 4])).iter().sum::<f64>();
            assert!((around + 6.0).abs() < 1e-12, "it is not mirrored: {around}");
        }
        // Of a regular polygon each edge is as good.
        let circle = |count: usize| (0..count).map(move |k| DVec2::from_angle(k as f64 * TAU / count as f64));
        let mut many: Vec<DVec2> = circle(100_000).collect();
        assert!(smallest_rectangle(&mut many).distance(DVec2::splat(2.0)) < 1e-8);
        // Points on a line, and a single one.
        let mut line = [[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]].map(DVec2::from);
        assert!(smallest_rectangle(&mut line).distance(DVec2::new(8_f64.sqrt(), 0.0)) < 1e-12);
        assert_eq!(smallest_rectangle(&mut [DVec2::ONE]), DVec2::ZERO);
    }

    /// All directions of edges are tried: the best is among them.
    #[test]
    fn no_edge_has_a_smaller_rectangle() {
        for seed in 0..50_u32 {
            let number = |k: u32, factor: f64| (f64::from(seed * 97 + k) * factor).fract();
            let points: Vec<DVec2> = (0..40)
                .map(|k| DVec2::new(number(k, 0.618_034).powi(2), 0.3 * number(k, 0.754_878)))
                .map(|point| DVec2::from_angle(f64::from(seed)).rotate(point))
                .collect();
            let hull = convex_hull(&points);
            let area = |along: DVec2| {
                let turned = hull.iter().map(|point| turned(*point, along));
                let (low, high) = turned.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| {
                    (low.min(point), high.max(point))
                });
                (high - low).element_product()
            };
            let edges = hull.iter().zip(hull.iter().cycle().skip(1)).map(|(from, to)| (*to - *from).normalize());
            let least = edges.map(area).fold(f64::INFINITY, f64::min);
            let found = smallest_rectangle(&mut points.clone()).element_product();
            assert!((found / least - 1.0).abs() < 1e-12, "{seed}: {found} {least}");
        }
    }
}
