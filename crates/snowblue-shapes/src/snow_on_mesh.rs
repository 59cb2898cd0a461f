//! Snow on a mesh: on all its faces that look upwards, raised vertically by the depth of the snow.
//!
//! Where such a face borders on a face that does not look upwards, as at the eaves of a roof, the snow ends in a round
//! edge. At a distance d from the border, the snow is d − d²/4D deep for d < 2D, where D is the depth elsewhere.
//! Triangles there are split until they are not visible in the round edge. Where a face borders on no other face, as
//! at the edge of a map, the snow ends in a wall. Objects above a face do not shelter it from snow.

use glam::{Vec2, Vec3};
use snowblue_base::narrow;
use snowblue_geometry::coincident::merged;
use snowblue_geometry::edges::{Side, visit_edges};
use snowblue_geometry::triangle_mesh::TriangleMesh;

use crate::refinement::refine;
use crate::segments::Segments;
use crate::sheet::{Sheet, SheetVertex};

/// Width of a round edge, in depths.
const WIDTH_OF_DEPTH: f64 = 2.0;

/// Longest side of triangles within a round edge, as a fraction of the greatest depth.
const EDGE_OF_DEPTH: f64 = 0.25;

/// Shortest side that is split, as a fraction of the greatest coordinate: some steps of single precision.
const EDGE_OF_REACH: f64 = 1e-6;

/// Distance from the edge within which there is no snow, as a fraction of the greatest depth. Rounding may place the
/// middle of a straight edge beside the edge.
const NONE_OF_DEPTH: f64 = 1e-3;

/// The error of a mesh without snow.
const NO_SNOW: &str = "has no snow anywhere";

/// Greatest number of triangles under snow after sides are split.
const MAX_TRIANGLES: usize = 2_000_000;

/// The solid of snow on a mesh with z upwards. `depth_m` gives the depth at a vertex of the mesh with split sides, by
/// the number of the vertex: at most `most_m`, and 0 where there is no snow. The underside lies `gap_m` above the
/// mesh.
///
/// # Errors
///
/// When no face looks upwards, no snow lies anywhere, or the depth is so small that too many triangles are needed.
pub fn snow_on_mesh(
    mut ground: TriangleMesh,
    gap_m: f64,
    most_m: f64,
    depth_m: impl Fn(&TriangleMesh, usize) -> f64,
) -> Result<TriangleMesh, String> {
    let first = merged(&ground.positions, &ground.indices);
    ground.indices.iter_mut().flatten().for_each(|corner| *corner = first[*corner as usize]);
    let edges = Segments::new(keep_upper(&mut ground));
    if ground.indices.is_empty() {
        return Err("has no face that looks upwards".to_owned());
    }
    if most_m <= 0.0 {
        return Err(NO_SNOW.to_owned());
    }
    split_sides(&mut ground, &edges, most_m)?;
    let vertex = |(number, position): (usize, &Vec3)| {
        let uv = ground.uv.get(number).copied().unwrap_or(Vec2::ZERO);
        let bottom_m = f64::from(position.z) + gap_m;
        let from_edge_m = f64::from(edges.distance_m(*position, narrow(WIDTH_OF_DEPTH * most_m)));
        let is_edge = from_edge_m < NONE_OF_DEPTH * most_m;
        let depth_m = if is_edge { 0.0 } else { rounded_m(depth_m(&ground, number), from_edge_m) };
        SheetVertex { position: position.with_z(narrow(bottom_m)), top: narrow(bottom_m + depth_m), uv }
    };
    let vertices = ground.positions.iter().enumerate().map(vertex).collect();
    let boundary = boundary(ground.positions.len(), &ground.indices);
    let has_uv = !ground.uv.is_empty();
    let sheet = Sheet { vertices, boundary, triangles: ground.indices, underside: None };
    let mut solid = sheet.solid();
    if solid.indices.is_empty() {
        return Err(NO_SNOW.to_owned());
    }
    if !has_uv {
        solid.uv.clear();
    }
    Ok(solid)
}

/// The depth at a distance from an edge at which the snow ends.
fn rounded_m(depth_m: f64, from_edge_m: f64) -> f64 {
    let width_m = WIDTH_OF_DEPTH * depth_m;
    if from_edge_m < width_m { from_edge_m - from_edge_m.powi(2) / (2.0 * width_m) } else { depth_m }
}

/// Keeps the triangles that look upwards, and returns the edges between them and other triangles.
fn keep_upper(ground: &mut TriangleMesh) -> Vec<[Vec3; 2]> {
    let looks_up = |triangle: usize| {
        let [a, b, c] = ground.corners(triangle).map(|corner| corner.as_dvec3());
        (b - a).cross(c - a).z > 0.0
    };
    let is_upper: Vec<bool> = (0..ground.indices.len()).map(looks_up).collect();
    let mut edges = Vec::new();
    visit_edges(ground.positions.len(), &ground.indices, |sides| {
        let upper = sides.iter().filter(|side| is_upper[side.triangle as usize]).count();
        if 0 < upper && upper < sides.len() {
            edges.push([sides[0].from, sides[0].to].map(|end| ground.positions[end as usize]));
        }
    });
    let mut kept = is_upper.into_iter();
    ground.indices.retain(|_| kept.next() == Some(true));
    edges
}

/// Splits sides near the edges at which the snow ends.
fn split_sides(ground: &mut TriangleMesh, ends: &Segments, most_m: f64) -> Result<(), String> {
    let reach_m = ground.positions.iter().map(|position| position.abs().max_element()).fold(0.0, f32::max);
    let longest_m = narrow((EDGE_OF_DEPTH * most_m).max(EDGE_OF_REACH * f64::from(reach_m)));
    let width_m = narrow(WIDTH_OF_DEPTH * most_m);
    let is_long = |[from, to]: [Vec3; 2], _: [(); 2]| {
        let length_m = from.distance(to);
        let near_m = width_m + 0.5 * length_m;
        length_m > longest_m && ends.distance_m(from.midpoint(to), near_m) < near_m
    };
    if refine(ground, MAX_TRIANGLES, |_| (), is_long).is_some() {
        return Ok(());
    }
    Err(format!(
        "needs more than {MAX_TRIANGLES} triangles for snow of at most {most_m} m, whose edges are too long for so \
         little"
    ))
}

/// The edges of an odd number of triangles, each in the direction of one of these triangles.
fn boundary(vertices: usize, triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut boundary = Vec::new();
    visit_edges(vertices, triangles, |sides| {
        if sides.len() % 2 == 1 {
            // The sides are sorted by direction, so that the middle side has the direction of the majority.
            let Side { from, to, .. } = sides[sides.len() / 2];
            boundary.push([from, to]);
        }
    });
    boundary
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_geometry::topology::{Topology, volume};

    fn uniform(depth_m: f64) -> impl Fn(&TriangleMesh, usize) -> f64 {
        move |_, _| depth_m
    }

    fn check(solid: &TriangleMesh, expected_m3: f64, tolerance_m3: f64) {
        let topology = Topology::of(solid);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        assert!((volume(solid) - expected_m3).abs() < tolerance_m3, "{} m³ of {expected_m3} m³", volume(solid));
    }

    #[test]
    fn snow_on_an_open_slope_has_the_volume_of_its_plan_times_its_depth() {
        let corners = [Vec3::ZERO, Vec3::new(3.0, 0.0, 1.0), Vec3::new(3.0, 2.0, 1.5), Vec3::new(0.0, 2.0, 0.5)];
        let slope =
            TriangleMesh::from_triangles(&[[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(|at| corners[at])));
        let solid = snow_on_mesh(slope.clone(), 0.01, 0.25, uniform(0.25)).unwrap();
        check(&solid, 3.0 * 2.0 * 0.25, 1e-6);
        assert_eq!(solid.indices.len(), 2 * 2 + 2 * 4, "an edge in a wall needs no further triangles");
        let down = TriangleMesh::from_triangles(&[[corners[0], corners[2], corners[1]]]);
        let refused = |ground: TriangleMesh, most_m: f64| snow_on_mesh(ground, 0.0, most_m, uniform(0.0)).unwrap_err();
        assert_eq!(refused(down, 1.0), "has no face that looks upwards");
        assert_eq!(refused(slope, 0.0), "has no snow anywhere");
    }

    /// A block of 2 × 1 × 1, its top divided into fans about points of it.
    fn block(columns: u16, rows: u16, skew: f32) -> TriangleMesh {
        let (width, height) = (columns + 1, rows + 1);
        let place = |k: u16| {
            let [x, y] = [f32::from(k % width) / f32::from(columns), f32::from(k / width) / f32::from(rows)];
            // The boundary stays straight.
            let moved = skew * x * (1.0 - x) * y * (1.0 - y);
            Vec3::new(2.0 * (x + moved), y - moved, 1.0)
        };
        let top: Vec<Vec3> = (0..width * height).map(place).collect();
        let at = |column: u16, row: u16| top[usize::from(row * width + column)];
        let mut triangles = Vec::new();
        for (column, row) in (0..columns).flat_map(|column| (0..rows).map(move |row| (column, row))) {
            let [a, b] = [at(column, row), at(column + 1, row)];
            let [c, d] = [at(column + 1, row + 1), at(column, row + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let mut wall = |a: Vec3, b: Vec3| triangles.extend([[b, a, a.with_z(0.0)], [b, a.with_z(0.0), b.with_z(0.0)]]);
        (0..columns).for_each(|column| wall(at(column, 0), at(column + 1, 0)));
        (0..rows).for_each(|row| wall(at(columns, row), at(columns, row + 1)));
        (0..columns).rev().for_each(|column| wall(at(column + 1, rows), at(column, rows)));
        (0..rows).rev().for_each(|row| wall(at(0, row + 1), at(0, row)));
        TriangleMesh::from_triangles(&triangles)
    }

    /// ∫ depth dA, summed over layers of depth. `area_m2` is the area beyond a distance from the edge.
    fn rounded_m3(most_m: f64, area_m2: impl Fn(f64) -> f64) -> f64 {
        let steps = 10_000u16;
        let layer = |step: u16| {
            let [from_m, to_m] = [0, 1].map(|k| 2.0 * most_m * f64::from(step + k) / f64::from(steps));
            (rounded_m(most_m, to_m) - rounded_m(most_m, from_m)) * area_m2(0.5 * (from_m + to_m))
        };
        (0..steps).map(layer).sum()
    }

    #[test]
    fn the_depth_near_an_edge_is_the_distance_whatever_the_triangles() {
        let most_m = 0.2;
        let expected_m3 = rounded_m3(most_m, |from_edge_m| (2.0 - 2.0 * from_edge_m) * (1.0 - 2.0 * from_edge_m));
        for ground in [block(1, 1, 0.0), block(3, 2, 0.7), block(16, 1, 0.0), block(23, 17, -0.6)] {
            let solid = snow_on_mesh(ground, 0.0, most_m, uniform(most_m)).unwrap();
            // Where two edges meet, the depth has a kink. Within a side's length of the kink, the depth is inexact.
            check(&solid, expected_m3, 0.01 * expected_m3);
            for (number, &[a, b, c]) in solid.indices.iter().enumerate() {
                let [a, b, c] = [a, b, c].map(|corner| solid.positions[corner as usize].as_dvec3());
                if (b - a).cross(c - a).z <= 0.0 {
                    continue;
                }
                let middle = (a + b + c) / 3.0;
                let from_edge_m = [middle.x, 2.0 - middle.x, middle.y, 1.0 - middle.y].into_iter().fold(1.0, f64::min);
                let depth_m = middle.z - 1.0;
                let expected_m = rounded_m(most_m, from_edge_m);
                // Corners lie 0.58 of the longest edge from the middle on average.
                assert!(
                    (depth_m - expected_m).abs() < 0.58 * EDGE_OF_DEPTH * most_m,
                    "{number}: {depth_m} m, not {expected_m} m"
                );
            }
        }
    }

    #[test]
    fn a_house_of_few_triangles_has_snow_on_both_sides_of_its_roof() {
        // A prism: a roof without a house, of two slopes and two gables.
        let [a, b, c, d] = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let [e, f] = [Vec3::new(0.0, 1.0, 1.0), Vec3::new(4.0, 1.0, 1.0)];
        let sides = [[a, b, f], [a, f, e], [c, d, e], [c, e, f], [b, c, f], [d, a, e], [a, c, b], [a, d, c]];
        let roof = TriangleMesh::from_triangles(&sides);
        let most_m = 0.25;
        let solid = snow_on_mesh(roof, 0.0, most_m, uniform(most_m)).unwrap();
        // Each slope is 4 × √2, and the snow is less deep near three of its edges. The ridge is not such an edge.
        let slope = 2.0f64.sqrt();
        let strips = |from_edge_m: f64| (4.0 - 2.0 * from_edge_m) * (slope - from_edge_m);
        let expected_m3 = 2.0 * rounded_m3(most_m, strips) / slope;
        check(&solid, expected_m3, 0.01 * expected_m3);
        let ridge = solid.positions.iter().filter(|place| (place.y - 1.0).abs() < 1e-6 && (place.x - 2.0).abs() < 0.5);
        let top = ridge.map(|place| place.z).fold(0.0, f32::max);
        assert!((top - 1.25).abs() < 1e-6, "{top}");
    }

    #[test]
    fn little_snow_on_long_edges_is_refused() {
        let ground = block(1, 1, 0.0);
        let message = snow_on_mesh(ground, 0.0, 1e-5, uniform(1e-5)).unwrap_err();
        assert!(message.starts_with("needs more than 2000000 triangles for snow of at most 0.00001 m"), "{message}");
    }
}
