//! Polygons as triangles: faces of mesh files, and holes. A polygon becomes a triangle fan if the fan lies within the
//! polygon, else its ears are clipped (Meisters 1975, "Polygons have ears", doi:10.2307/2319703; the crate `earcut`).

use std::collections::BTreeSet;

use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use glam::{DVec3, Vec3};

/// Greatest difference between the area of a polygon and the areas of its triangles, as a fraction of the area.
const MAX_DIFFERENCE: f64 = 1e-6;

/// Greatest number of corners of a face whose fan does not lie within it. The time to clip ears may be quadratic in
/// this number.
const MAX_CLIPPED: usize = 30_000;

/// The triangles of the faces of a file, and the number of faces that have no triangles of their shape.
#[derive(Default)]
pub(crate) struct Faces {
    /// The triangles, as indices of vertices.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Faces of less than three corners.
    small: usize,
    /// Faces with edges that cross.
    crossed: usize,
}

impl Faces {
    /// Adds a face with these corners, which are indices into `positions`.
    ///
    /// # Errors
    ///
    /// When a face without a fan has too many corners.
    pub(crate) fn add(&mut self, corners: &[u32], positions: &[Vec3]) -> Result<(), String> {
        match corners {
            [] | [_] | [_, _] => self.small += 1,
            &[a, b, c] => self.triangles.push([a, b, c]),
            [first, rest @ ..] if has_fan(corners, positions) => {
                self.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }
            _ if corners.len() > MAX_CLIPPED => {
                return Err(format!(
                    "a face is concave and has {} corners, but must have at most {MAX_CLIPPED}: export the mesh as \
                     triangles",
                    corners.len()
                ));
            }
            _ => {
                let (triangles, is_simple) = without_ears(corners, positions);
                self.triangles.extend(triangles.iter().map(|triangle| triangle.map(|corner| corners[corner as usize])));
                self.crossed += usize::from(!is_simple);
            }
        }
        Ok(())
    }

    /// Sentences on the faces that have no triangles of their shape.
    pub(super) fn notes(&self) -> Vec<String> {
        let all = [
            (self.small, "faces of less than three corners, which have no area, are left out"),
            (self.crossed, "edges of faces cross, so that their triangles cover another area"),
        ];
        all.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{what}: {count}")).collect()
    }
}

/// Whether no triangle of the fan about the first corner is turned against the polygon. Where the edges of a polygon
/// cross, the areas of its triangles may cancel.
fn has_fan(corners: &[u32], positions: &[Vec3]) -> bool {
    let at = |corner: u32| positions[corner as usize].as_dvec3() - positions[corners[0] as usize].as_dvec3();
    let areas = || corners[1..].windows(2).map(|pair| at(pair[0]).cross(at(pair[1])));
    let whole: DVec3 = areas().sum();
    let least = MAX_DIFFERENCE * areas().map(DVec3::length).sum::<f64>();
    whole.length() >= least && areas().all(|area| area.dot(whole) >= 0.0)
}

/// The triangles of a polygon as indices of its corners, and whether their area is the area of the polygon.
#[expect(clippy::cast_possible_truncation, reason = "a face in memory has fewer than 2^32 corners")]
fn without_ears(corners: &[u32], positions: &[Vec3]) -> (Vec<[u32; 3]>, bool) {
    let first = positions[corners[0] as usize].as_dvec3();
    let places: Vec<DVec3> = corners.iter().map(|corner| positions[*corner as usize].as_dvec3() - first).collect();
    let size = places.iter().fold(0.0, |size: f64, place| size.max(place.abs().max_element()));
    let places: Vec<[f64; 3]> = places.into_iter().map(|place| (place / size).to_array()).collect();
    let (mut flat, mut clipped) = (Vec::new(), Vec::<u32>::new());
    if project3d_to_2d(&places, places.len(), &mut flat) {
        Earcut::new().earcut_slice(&flat, &[], &mut clipped);
    }
    let area = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|corner| flat.get(corner as usize).copied().unwrap_or_default());
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let turned = |[a, b, c]: [u32; 3]| if area([a, b, c]) < 0.0 { [a, c, b] } else { [a, b, c] };
    let mut triangles: Vec<[u32; 3]> = clipped.as_chunks().0.iter().copied().map(turned).collect();
    let count = corners.len() as u32;
    let whole: f64 = (1..count - 1).map(|corner| area([0, corner, corner + 1])).sum();
    let covered: f64 = triangles.iter().copied().map(area).sum();
    // Corners on straight edges may be left out. Faces beside these edges have the corners, so that the mesh would be
    // open without triangles of no area.
    let mut missing: BTreeSet<[u32; 2]> = (0..count).map(|corner| [corner, (corner + 1) % count]).collect();
    for [from, to] in triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]) {
        if !missing.remove(&[from, to]) {
            missing.insert([to, from]);
        }
    }
    while let Some([start, mut at]) = missing.pop_first() {
        let mut last = None;
        while at != start {
            triangles.extend(last.map(|last| [start, last, at]));
            let Some(&next) = missing.range([at, 0]..).next().filter(|[from, _]| *from == at) else { break };
            missing.remove(&next);
            (last, at) = (Some(at), next[1]);
        }
    }
    (triangles, !flat.is_empty() && (covered - whole).abs() <= MAX_DIFFERENCE * whole.abs())
}

/// The triangles of a strip: every second one is turned, so that all face one way.
pub(super) fn strip<Index: Copy>(indices: &[Index]) -> impl Iterator<Item = [Index; 3]> {
    indices.windows(3).enumerate().map(|(number, corners)| match number % 2 {
        0 => [corners[0], corners[1], corners[2]],
        _ => [corners[0], corners[2], corners[1]],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle_mesh::TriangleMesh;

    /// The triangles of a polygon in the plane z = 1, and their area.
    fn cut(outline: &[[f32; 2]]) -> (Faces, Vec<f32>) {
        let positions: Vec<Vec3> = outline.iter().map(|[x, y]| Vec3::new(*x, *y, 1.0)).collect();
        let mut faces = Faces::default();
        let corners: Vec<u32> = (0..).zip(outline).map(|(corner, _)| corner).collect();
        faces.add(&corners, &positions).unwrap();
        let mesh = TriangleMesh { positions, indices: faces.triangles.clone(), ..TriangleMesh::default() };
        let area = |triangle| {
            let [a, b, c] = mesh.corners(triangle);
            0.5 * (b - a).cross(c - a).z
        };
        let areas = (0..mesh.indices.len()).map(area).collect();
        (faces, areas)
    }

    #[test]
    fn concave_polygons_are_covered_once_from_every_first_corner_and_from_both_sides() {
        let l_shape = [[-1.0, -1.0], [2.0, -1.0], [2.0, 0.0], [0.0, 0.0], [0.0, 2.0], [-1.0, 2.0]];
        // A comb of three teeth of 1 × 3 on a back of 5 × 1: 14 squares.
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 4.0],
            [4.0, 4.0],
            [4.0, 1.0],
            [3.0, 1.0],
            [3.0, 4.0],
            [2.0, 4.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 4.0],
            [0.0, 4.0],
        ];
        // A square of 3 with a hole of 1, joined by a cut along which two edges coincide.
        let keyhole = [
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ];
        let dart = [[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]];
        for (outline, area) in [(&l_shape[..], 5.0), (&comb, 14.0), (&keyhole, 8.0), (&dart, 1.0)] {
            for (first, sign) in (0..outline.len()).flat_map(|first| [(first, 1.0), (first, -1.0)]) {
                let mut turned: Vec<[f32; 2]> = outline.to_vec();
                turned.rotate_left(first);
                turned.iter_mut().for_each(|[x, _]| *x *= sign);
                let (faces, areas) = cut(&turned);
                assert!(faces.notes().is_empty(), "{:?}", faces.notes());
                assert!(areas.iter().all(|area| area * sign >= 0.0), "{turned:?}: {areas:?}");
                assert!((areas.iter().sum::<f32>() * sign - area).abs() < 1e-5, "{turned:?}: {areas:?}");
            }
        }
    }

    #[test]
    fn every_edge_belongs_to_a_triangle_also_where_corners_lie_on_a_straight_edge() {
        // An L with a corner in the middle of each edge. A face beside an edge has the middle too.
        let corners = [[-1.0, -1.0], [2.0, -1.0], [2.0, 0.0], [0.0, 0.0], [0.0, 2.0], [-1.0, 2.0f32]];
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let outline: Vec<[f32; 2]> =
            edges.flat_map(|(a, b)| [*a, [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]]).collect();
        for first in 0..12 {
            let mut turned = outline.clone();
            turned.rotate_left(first);
            let (faces, areas) = cut(&turned);
            assert_eq!(faces.triangles.len(), 10, "{:?}", faces.triangles);
            assert!((areas.iter().sum::<f32>() - 5.0).abs() < 1e-5);
            let all: Vec<[u32; 2]> = faces.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
            assert!((0..12).all(|corner| all.contains(&[corner, (corner + 1) % 12])), "{:?}", faces.triangles);
        }
    }

    #[test]
    fn convex_polygons_are_fans_and_others_have_notes() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(cut(&square).0.triangles, [[0, 1, 2], [0, 2, 3]]);
        let (line, _) = cut(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]);
        assert_eq!(line.triangles.len(), 2, "faces beside a line stay joined");
        assert_eq!(
            cut(&square[..2]).0.notes(),
            ["faces of less than three corners, which have no area, are left out: 1"]
        );
        // The edges of bow ties of unequal and of equal wings, of a star of five points, and of a loop cross.
        let star: Vec<[f32; 2]> = (0..5_u8).map(|k| (2.5 * f32::from(k)).sin_cos().into()).collect();
        let loop_of_six = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [1.0, 4.0], [1.0, -1.0], [0.0, -1.0]];
        for crossed in [
            &[[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 1.0]][..],
            &[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]],
            &star,
            &loop_of_six,
        ] {
            let (faces, _) = cut(crossed);
            assert_eq!(
                faces.notes(),
                ["edges of faces cross, so that their triangles cover another area: 1"],
                "{crossed:?}: {:?}",
                faces.triangles
            );
        }
    }

    #[test]
    fn a_concave_face_of_very_many_corners_is_refused() {
        // A circle, and a circle with a dent.
        let corner = |radius: f32, k: u16| {
            let (sin, cos) = (f32::from(k) * std::f32::consts::TAU / 40_000.0).sin_cos();
            Vec3::new(radius * cos, radius * sin, 0.0)
        };
        let mut positions: Vec<Vec3> = (0..40_000).map(|k| corner(1.0, k)).collect();
        let corners: Vec<u32> = (0..40_000).collect();
        let mut faces = Faces::default();
        faces.add(&corners, &positions).unwrap();
        assert_eq!(faces.triangles.len(), 39_998);
        positions[7] = corner(0.9, 7);
        let message = faces.add(&corners, &positions).unwrap_err();
        assert!(message.contains("has 40000 corners, but must have at most 30000"), "{message}");
    }
}
