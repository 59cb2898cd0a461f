//! The surface of carved snow as a closed mesh: surface nets.
//!
//! The mesh has a vertex for every patch in a cell of a cubic lattice, and two triangles for every crossed edge (Gibson
//! 1998, "Constrained elastic surface nets", doi:10.1007/BFb0056277). With the patches of dual marching cubes it is a
//! closed manifold. Newton's method moves the vertices onto the surface, within their cells.

use glam::{DVec3, UVec3};
use rayon::prelude::*;
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_geometry::vertex_normals::VertexNormals;

use super::lattice::{Lattice, Surface, SurfaceCell, corner, key};
use super::patches::{CellPatches, Face, edge, ends, is_crossed, other_axes};
use super::snow::Carved;

/// Greatest number of steps of Newton's method. On a smooth surface each step squares the error, which starts at some
/// hundredths of a cell.
const STEPS: usize = 6;
/// Distance from the surface at which Newton's method ends, in cells.
const TOLERANCE: f64 = 1e-6;
/// Distances of the points by which gradients are computed, in cells: for Newton's method, and for vertex normals. The
/// distance for normals is wide, so that sharp edges are shaded as rounded over a cell.
const STEP_REACH: f64 = 1e-3;
const NORMAL_REACH: f64 = 0.25;

/// Why carved snow has no mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CarvedError {
    /// There are too many cells.
    TooFine {
        /// Least length of cells that keeps their number within the limit, in m.
        least_m: f64,
    },
    /// No cell has a point inside and a point outside.
    Empty,
}

impl Carved {
    /// Its closed surface, with vertex normals.
    ///
    /// # Errors
    ///
    /// When there are too many cells, or when nothing is left of the snow.
    pub fn mesh(&self) -> Result<TriangleMesh, CarvedError> {
        let lattice = Lattice::new(self.bounds(), self.cell_m).map_err(|least_m| CarvedError::TooFine { least_m })?;
        let Surface { cells, groups } = lattice.surface(self);
        if cells.is_empty() {
            return Err(CarvedError::Empty);
        }
        let net = Net::new(&cells);
        let (vertices, normals): (Vec<_>, Vec<_>) = (0..cells.len())
            .into_par_iter()
            .flat_map_iter(|cell| {
                let carved = &groups[cells[cell].group];
                net.vertices(cell, &lattice, carved)
                    .map(|at| (at, carved.gradient(at, NORMAL_REACH * self.cell_m).as_vec3()))
            })
            .unzip();
        let indices = (0..cells.len()).into_par_iter().flat_map_iter(|cell| net.triangles(cell, &vertices)).collect();
        Ok(TriangleMesh {
            positions: vertices.iter().map(|at| at.as_vec3()).collect(),
            indices,
            normals: VertexNormals::new(normals),
            ..TriangleMesh::default()
        })
    }

    /// Moves a point onto the surface by Newton's method along the gradient, within a box. At a side of the box, the
    /// component of the gradient along the side is used.
    fn onto_surface(&self, mut point: DVec3, low: DVec3, high: DVec3) -> DVec3 {
        for _ in 0..STEPS {
            let distance_m = self.distance_m(point);
            if distance_m.abs() < TOLERANCE * self.cell_m {
                break;
            }
            let reach_m = STEP_REACH * self.cell_m;
            let change = |axis: DVec3| self.distance_m(point + reach_m * axis) - distance_m;
            let gradient = DVec3::from_array(DVec3::AXES.map(change)) / reach_m;
            let outwards = -distance_m * gradient;
            let is_held =
                (point.cmple(low) & outwards.cmplt(DVec3::ZERO)) | (point.cmpge(high) & outwards.cmpgt(DVec3::ZERO));
            let gradient = DVec3::select(is_held, DVec3::ZERO, gradient);
            let square = gradient.length_squared();
            // Where two surfaces are equally near there is no gradient.
            if square < 0.01 {
                break;
            }
            point = (point - distance_m / square * gradient).clamp(low, high);
        }
        point
    }
}

/// The patches of the surface in its cells. Each patch is a vertex of the mesh.
struct Net<'cells> {
    cells: &'cells [SurfaceCell],
    patches: Vec<CellPatches>,
    /// The number of each cell's first vertex.
    first_vertices: Vec<u32>,
}

impl<'cells> Net<'cells> {
    fn new(cells: &'cells [SurfaceCell]) -> Self {
        let mut net = Self { cells, patches: Vec::new(), first_vertices: Vec::new() };
        net.patches = cells.par_iter().map(|cell| CellPatches::new(cell.inside(), net.split_face(cell))).collect();
        let mut vertices = 0;
        net.first_vertices = net
            .patches
            .iter()
            .map(|patches| {
                vertices += u32::from(patches.count);
                vertices - u32::from(patches.count)
            })
            .collect();
        net
    }

    /// The face of a cell at which patches on both sides of the face touch along both of its links.
    fn split_face(&self, cell: &SurfaceCell) -> Option<Face> {
        let face = CellPatches::pinched_face(cell.inside())?;
        let step = corner(1 << face.axis);
        let other = self.find(if face.is_upper { cell.at + step } else { cell.at - step });
        let across = Face { is_upper: !face.is_upper, ..face };
        (CellPatches::pinched_face(self.cells[other].inside()) == Some(across)).then_some(face)
    }

    /// The index of a cell that shares a crossed edge with one of the cells.
    fn find(&self, at: UVec3) -> usize {
        self.cells.binary_search_by_key(&key(at), SurfaceCell::key).expect("all cells around a crossed edge are known")
    }

    /// The vertices of a cell.
    fn vertices(&self, cell: usize, lattice: &Lattice, carved: &Carved) -> impl Iterator<Item = DVec3> {
        let (SurfaceCell { at, distances_m, .. }, patches) = (&self.cells[cell], &self.patches[cell]);
        let inside = self.cells[cell].inside();
        let (low, high) = (lattice.point(*at), lattice.point(at + UVec3::ONE));
        (0..patches.count).map(move |patch| {
            let edges = (0..12).filter(|edge| is_crossed(inside, *edge) && patches.edge_patches[*edge] == patch);
            let crossings = edges.clone().map(|edge| {
                let [from, to] = ends(edge);
                let [from_m, to_m] = [from, to].map(|corner| f64::from(distances_m[corner]));
                corner(from).as_dvec3().lerp(corner(to).as_dvec3(), from_m / (from_m - to_m))
            });
            let mean = crossings.sum::<DVec3>() / edges.count() as f64;
            carved.onto_surface(low + lattice.cell_m * mean, low, high)
        })
    }

    /// The triangles about the crossed edges at the lowest corner of a cell.
    fn triangles(&self, cell: usize, vertices: &[DVec3]) -> impl Iterator<Item = [u32; 3]> {
        let inside = self.cells[cell].inside();
        let crossed = (0..3).filter(move |axis| is_crossed(inside, edge(*axis, 0)));
        crossed.flat_map(move |axis| {
            let [u, v] = other_axes(axis).map(|axis| 1 << axis);
            // The cells around the edge, counter-clockwise seen from its upper end. In each cell the edge has another
            // place.
            let around = [0, u, u | v, v].map(|place| {
                let cell = self.find(self.cells[cell].at - corner(place));
                self.first_vertices[cell] + u32::from(self.patches[cell].edge_patches[edge(axis, place)])
            });
            let [a, b, c, d] = if inside & 1 == 1 {
                around
            } else {
                let [a, b, c, d] = around;
                [d, c, b, a]
            };
            let length = |from: u32, to: u32| vertices[from as usize].distance_squared(vertices[to as usize]);
            if length(a, c) <= length(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};
    use std::f64::consts::PI;

    use super::*;
    use crate::carved::Solid;
    use crate::relief::uniform;
    use glam::{DMat3, EulerRot, IVec3};
    use snowblue_geometry::topology::{Topology, volume};
    use snowblue_geometry::vertex_normals::face_normal;

    fn carved(cell_m: f64, add: &[Solid], remove: &[Solid]) -> Carved {
        Carved {
            cell_m,
            rounding_m: 0.0,
            relief_m: 0.0,
            relief_length_m: 0.3,
            seed: 1,
            add: add.to_vec(),
            remove: remove.to_vec(),
        }
    }

    fn ball(centre: DVec3, radius_m: f64) -> Solid {
        Solid::Ellipsoid { centre, axes: DMat3::IDENTITY, radii_m: DVec3::splat(radius_m) }
    }

    fn area(mesh: &TriangleMesh) -> f64 {
        let corners = |triangle| mesh.corners(triangle).map(|corner| corner.as_dvec3());
        (0..mesh.indices.len()).map(corners).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    /// Every edge has two triangles, of the same orientation, and the triangles around a vertex are one ring.
    fn assert_manifold(mesh: &TriangleMesh, what: &str) {
        let topology = Topology::of(mesh);
        // Vertices of neighbouring cells may be within the tolerance of merging, but are not equal.
        let merged_vertices = topology.merged_vertices;
        let triangles = mesh.indices.len();
        let expected = Topology { triangles, merged_vertices, most_of_an_edge: 2, ..Topology::default() };
        assert_eq!(topology, expected, "{what}");
        let places: BTreeSet<[u32; 3]> =
            mesh.positions.iter().map(|position| (*position + 0.0).to_array().map(f32::to_bits)).collect();
        assert_eq!(places.len(), mesh.positions.len(), "{what}");
        // For each vertex, a map from each neighbouring vertex to the next vertex of the ring.
        let mut rings = vec![BTreeMap::new(); mesh.positions.len()];
        for &[a, b, c] in &mesh.indices {
            for [at, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
                rings[at as usize].insert(from, to);
            }
        }
        for ring in rings {
            let start = *ring.keys().next().unwrap();
            let mut at = ring[&start];
            let mut length = 1;
            while at != start {
                at = ring[&at];
                length += 1;
            }
            assert_eq!(length, ring.len(), "{what}");
        }
    }

    #[test]
    fn a_ball_has_the_volume_and_the_area_of_a_ball_and_a_hollow_one_the_difference() {
        let centre = DVec3::new(0.013, -0.2, 0.31);
        let (radius_m, hollow_m) = (0.5, 0.3);
        for cell_m in [0.05, 0.02] {
            let full = carved(cell_m, &[ball(centre, radius_m)], &[]).mesh().unwrap();
            let hollow = carved(cell_m, &[ball(centre, radius_m)], &[ball(centre, hollow_m)]).mesh().unwrap();
            assert_manifold(&full, "full");
            assert_manifold(&hollow, "hollow");
            // Corners lie on the sphere. The middle of a triangle within a circle of one cell is up to h²/2R below the
            // sphere, and the mean depth of the triangle is less than half of this. Relative to the volume, this is
            // 3/R · h²/4R.
            let loss = |radius_m: f64| 0.75 * (cell_m / radius_m).powi(2);
            let ball_m3 = |radius_m: f64| 4.0 / 3.0 * PI * radius_m.powi(3);
            let filled = volume(&full) / ball_m3(radius_m);
            assert!((1.0 - loss(radius_m)..1.0).contains(&filled), "{filled}");
            let shell_m3 = ball_m3(radius_m) - ball_m3(hollow_m);
            let lost_m3 = volume(&hollow) - shell_m3;
            let greatest_m3 = [radius_m, hollow_m].map(|radius_m| loss(radius_m) * ball_m3(radius_m));
            assert!((-greatest_m3[0]..greatest_m3[1]).contains(&lost_m3), "{lost_m3}");
            // An inscribed surface of a ball is smaller, by no more than the square of the volume's cube root.
            let covered = area(&full) / (4.0 * PI * radius_m.powi(2));
            assert!((1.0 - loss(radius_m)..1.0).contains(&covered), "{covered}");
            let covered = area(&hollow) / (4.0 * PI * (radius_m.powi(2) + hollow_m.powi(2)));
            assert!((1.0 - loss(hollow_m)..1.0).contains(&covered), "{covered}");
        }
    }

    #[test]
    fn vertices_and_normals_of_a_ball_are_exact_and_faces_face_outwards() {
        let (centre, radius_m) = (DVec3::new(0.4, 0.1, -0.2), 0.5);
        let mesh = carved(0.03, &[ball(centre, radius_m)], &[]).mesh().unwrap();
        for (triangle, indices) in mesh.indices.iter().enumerate() {
            let corners = mesh.corners(triangle);
            for (corner, weights) in corners.iter().zip([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) {
                let outwards = corner.as_dvec3() - centre;
                // Single precision at 1 m is 6e-8 m.
                assert!((outwards.length() - radius_m).abs() < 2e-7, "{corner}");
                let normal = mesh.normals.at(0, *indices, weights).unwrap();
                // The third derivatives of a distance are at most 1.2/R². The error of a central difference over ±h is
                // h²/6 times the third derivative, in each of three components.
                let allowed = 0.35 * (NORMAL_REACH * 0.03 / radius_m).powi(2) + 1e-6;
                assert!(normal.as_dvec3().distance(outwards.normalize()) < allowed, "{corner}");
            }
            let face = face_normal(corners).as_dvec3();
            let outwards = (corners[0].as_dvec3() - centre).normalize();
            // A triangle within a circle of one cell is tilted by at most h/R.
            assert!(face.dot(outwards) > (1.5 * 0.03 / radius_m).cos(), "{}", face.dot(outwards));
        }
    }

    #[test]
    fn triangles_are_no_slivers() {
        let (centre, axes) = (DVec3::new(0.1, 0.0, 0.2), DMat3::from_euler(EulerRot::ZYX, 0.4, -0.7, 1.1));
        let egg = Solid::Ellipsoid { centre, axes, radii_m: DVec3::new(1.0, 0.6, 0.8) };
        let block = Solid::Box { centre, axes, size_m: DVec3::new(1.5, 0.7, 1.0), edge_m: 0.0 };
        // At sharp edges a few vertices come close to each other.
        for (solid, few_deg) in [(egg, 20.0), (block, 4.0)] {
            let mesh = carved(0.04, &[solid], &[]).mesh().unwrap();
            let mut angles_deg = Vec::new();
            for triangle in 0..mesh.indices.len() {
                let [a, b, c] = mesh.corners(triangle);
                for [corner, next, previous] in [[a, b, c], [b, c, a], [c, a, b]] {
                    angles_deg.push((next - corner).angle_between(previous - corner).to_degrees());
                }
            }
            angles_deg.sort_unstable_by(f32::total_cmp);
            let [thousandth, hundredth] = [1000, 100].map(|part| angles_deg[angles_deg.len() / part]);
            assert!(thousandth > few_deg && hundredth > 25.0, "{thousandth} {hundredth}");
            assert_eq!(Topology::of(&mesh).degenerate_triangles, 0);
        }
    }

    /// A random number from 0 to 1.
    fn random(number: i32, choice: i32) -> f64 {
        uniform(IVec3::new(number, choice, 5), 3)
    }

    fn random_solid(number: i32, choice: i32) -> Solid {
        let vector = |of: i32| DVec3::from_array([0, 1, 2].map(|axis| random(number, 100 * choice + 10 * of + axis)));
        let [kind, edge, angles] = [0, 1, 2].map(|of| random(number, 100 * choice + 90 + of));
        let axes = DMat3::from_euler(EulerRot::ZYX, 6.0 * angles, 6.0 * edge, 6.0 * kind);
        let (centre, other) = (vector(1) - 0.5, vector(2) - 0.5);
        let size_m = 0.02 + 0.5 * vector(3);
        match (5.0 * kind).floor() {
            0.0 => Solid::Ellipsoid { centre, axes, radii_m: size_m },
            1.0 => Solid::Box { centre, axes, size_m, edge_m: 0.4 * edge * size_m.min_element() },
            2.0 => Solid::Capsule { from: centre, to: other, radii_m: [0.5 * size_m.x, 0.5 * size_m.y] },
            3.0 => Solid::Cylinder { from: centre, to: other, radius_m: size_m.x, edge_m: 0.0 },
            _ => Solid::Ellipsoid { centre, axes, radii_m: DVec3::splat(0.5 * size_m.x) },
        }
    }

    fn random_snow(number: i32) -> Carved {
        let counts = [1.0 + 6.0 * random(number, 1), 8.0 * random(number, 2)];
        let solids = |from: i32, count: f64| {
            (from..).map(move |choice| random_solid(number, choice)).take_while({
                let mut left = count;
                move |_| {
                    left -= 1.0;
                    left >= 0.0
                }
            })
        };
        Carved {
            rounding_m: if random(number, 3) < 0.3 { 0.0 } else { 0.2 * random(number, 3) },
            relief_m: if random(number, 4) < 0.3 { 0.0 } else { 0.05 * random(number, 4) },
            relief_length_m: 0.1 + random(number, 5),
            ..carved(
                0.02 + 0.05 * random(number, 6),
                &solids(10, counts[0]).collect::<Vec<_>>(),
                &solids(50, counts[1]).collect::<Vec<_>>(),
            )
        }
    }

    #[test]
    fn random_snow_is_closed() {
        let mut vertices = 0;
        for number in 0..150 {
            let snow = random_snow(number);
            match snow.mesh() {
                Ok(mesh) => {
                    assert_manifold(&mesh, &format!("{number}: {snow:?}"));
                    vertices += mesh.positions.len();
                }
                Err(error) => assert_eq!(error, CarvedError::Empty, "{number}"),
            }
        }
        assert!(vertices > 100_000, "{vertices}");
    }

    /// Cells with random corners inside, with all around them outside.
    fn random_cells(seed: u32) -> Vec<SurfaceCell> {
        const SIDE: u32 = 12;
        let distance_m = |at: UVec3| {
            let is_inner = at.cmpge(UVec3::ONE).all() && at.cmplt(UVec3::splat(SIDE)).all();
            if is_inner && uniform(at.as_ivec3(), seed) < 0.6 { -1.0 } else { 1.0 }
        };
        let places = (0..SIDE.pow(3)).map(|k| UVec3::new(k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE));
        let cells = places.map(|at| SurfaceCell {
            at,
            group: 0,
            distances_m: std::array::from_fn(|k| distance_m(at + corner(k))),
        });
        let mut cells: Vec<_> = cells.filter(|cell| !matches!(cell.inside(), 0 | 255)).collect();
        cells.sort_unstable_by_key(SurfaceCell::key);
        cells
    }

    #[test]
    fn a_net_through_any_cells_is_a_manifold() {
        let mut split = 0;
        for seed in 0..40 {
            let cells = random_cells(seed);
            let net = Net::new(&cells);
            split += cells.iter().filter(|cell| net.split_face(cell).is_some()).count();
            let count = net.patches.iter().map(|patches| usize::from(patches.count)).sum::<usize>();
            // Each vertex has a place of its own, and no three lie on a line.
            let place = |k: usize| DVec3::from_array([0, 1, 2].map(|axis| random(k.try_into().unwrap(), 900 + axis)));
            let vertices: Vec<DVec3> = (0..count).map(place).collect();
            let mesh = TriangleMesh {
                positions: vertices.iter().map(|at| at.as_vec3()).collect(),
                indices: (0..cells.len()).flat_map(|cell| net.triangles(cell, &vertices)).collect(),
                ..TriangleMesh::default()
            };
            assert_manifold(&mesh, &format!("seed {seed}"));
        }
        assert!(split > 100, "{split}");
    }

    #[test]
    fn one_thread_and_many_give_the_same_mesh() {
        let on_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| (0..6).map(|number| random_snow(number).mesh()).collect::<Vec<_>>())
        };
        assert_eq!(on_threads(1), on_threads(5));
    }

    #[test]
    fn the_search_finds_every_cell_of_the_surface() {
        for number in 0..12 {
            let snow = Carved { cell_m: 0.08, ..random_snow(number) };
            let lattice = Lattice::new(snow.bounds(), snow.cell_m).unwrap();
            let found: Vec<_> = lattice.surface(&snow).cells.iter().map(SurfaceCell::key).collect();
            // All solids lie within 4 m.
            let is_inside = |at: UVec3| snow.distance_m(lattice.point(at)) < 0.0;
            let inside: Vec<bool> = (0..51)
                .flat_map(|z| (0..51).flat_map(move |y| (0..51).map(move |x| UVec3::new(x, y, z))))
                .map(is_inside)
                .collect();
            let is_crossed = |at: &UVec3| {
                let corners =
                    (0..8).map(|k| at + corner(k)).map(|at| inside[((at.z * 51 + at.y) * 51 + at.x) as usize]);
                corners.clone().any(|corner| corner) && !corners.clone().all(|corner| corner)
            };
            let places = (0..50).flat_map(|z| (0..50).flat_map(move |y| (0..50).map(move |x| UVec3::new(x, y, z))));
            let known: Vec<_> = places.filter(is_crossed).map(key).collect();
            assert!(!known.is_empty() || snow.mesh().is_err());
            assert_eq!(found, known, "{number}");
        }
    }

    #[test]
    fn distances_do_not_depend_on_solids_that_are_left_out_as_far() {
        let (mut left_out, mut all) = (0, 0);
        for number in 0..600 {
            let snow = random_snow(number);
            for place in 0..20 {
                let vector =
                    |of: i32| DVec3::from_array([0, 1, 2].map(|axis| random(number, 40 * place + 3 * of + axis)));
                let (centre, reach_m) = (1.5 * (vector(1000) - 0.5), 0.2 * random(number, place));
                let near = snow.near(centre, reach_m);
                all += snow.add.len() + snow.remove.len();
                left_out += snow.add.len() + snow.remove.len() - near.add.len() - near.remove.len();
                for probe in 0..10 {
                    let point = centre + reach_m * (vector(probe) * 2.0 - 1.0) / 3f64.sqrt();
                    let change_m = near.distance_m(point) - snow.distance_m(point);
                    assert!(change_m.abs() <= 1e-6 * snow.rounding_m, "{number}: {change_m}");
                }
            }
        }
        assert!(left_out > all / 4, "{left_out} of {all}");
    }

    #[test]
    fn too_many_cells_and_nothing_left_are_errors() {
        let solid = ball(DVec3::ZERO, 5.0);
        let Err(CarvedError::TooFine { least_m }) = carved(1e-3, &[solid], &[]).mesh() else {
            panic!("10 000³ cells are too many")
        };
        // 6 · (10 m / h)² = 2²² at h = 0.012 m.
        assert!((0.0119..0.0123).contains(&least_m), "{least_m}");
        assert_eq!(carved(0.1, &[solid], &[ball(DVec3::ZERO, 6.0)]).mesh(), Err(CarvedError::Empty));
    }
}
