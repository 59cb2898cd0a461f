//! Igloo: a spherical dome of separate snow blocks in level courses, with staggered joints, closed by a king block.
//!
//! Each block is a closed mesh. Blocks overlap slightly in the middle of the wall. Their edges are rounded towards
//! both faces, so that the wall is thinnest along the seams, where most light passes. Widths, joints, courses, offsets
//! and faces are irregular by millimetres to centimetres, as in blocks cut by hand.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec3, IVec3};
use snowblue_geometry::triangle_mesh::{TriangleMesh, closed_grids};

use crate::relief::{relief, uniform};

/// Grid spacing of the faces, in m.
const GRID_SPACING_M: f64 = 0.012;
/// Overlap of blocks on each side, in m: more than the distance between the facets of adjacent blocks.
const OVERLAP_M: f64 = 0.0005;
/// Depth of the lowest course below the ground, in m.
const FOOTING_M: f64 = 0.06;
/// Amplitude of the waves of seams between courses, in m.
const WAVE_M: f64 = 0.012;
/// Relative range of block widths.
const UNEVEN_WIDTH: f64 = 0.16;
/// Greatest horizontal slant of a joint over its height, in m.
const SLANT_M: f64 = 0.03;
/// Greatest offset of a block from the wall, in m.
const OUT_OF_LINE_M: f64 = 0.006;
/// Amplitude and scale of the relief of faces, in m.
const RELIEF_M: f64 = 0.0035;
const RELIEF_SIZE_M: f64 = 0.16;
/// Angular radius of the king block, as a fraction of the right angle from the ground to the top.
const KING_BLOCK_FRACTION: f64 = 0.13;

/// Parameters of an igloo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Igloo {
    /// Inner radius, in m.
    pub inner_radius_m: f64,
    /// Wall thickness in the middle of a block, in m.
    pub wall_m: f64,
    /// Number of courses below the king block.
    pub courses: u32,
    /// Mean width of a block along its course, in m.
    pub block_width_m: f64,
    /// Depth of seams in either face, in m.
    pub seam_depth_m: f64,
    /// Distance from the edge of a block to its full thickness, in m.
    pub seam_width_m: f64,
    /// Seed of all irregularities.
    pub seed: u32,
}

impl Igloo {
    /// The blocks, course by course from the ground, with the king block last. The centre of the sphere is the origin;
    /// the ground is at z = 0.
    pub fn blocks(&self) -> Vec<TriangleMesh> {
        let mut blocks = Vec::new();
        for course in 0..self.courses {
            let middle = 0.5 * (self.rise(course, 0.0) + self.rise(course + 1, 0.0));
            let around_m = TAU * self.middle_radius_m() * middle.cos();
            let count = (around_m / self.block_width_m).round().max(5.0);
            // Shifted by half a block from the course below.
            let turn = 0.5 * TAU / count * f64::from(course % 2);
            for number in 0..whole(count) {
                let joint = |joint: u32| Joint {
                    course,
                    number: joint % whole(count),
                    turn,
                    count,
                    laps: joint >= whole(count),
                };
                blocks.push(self.block(course, number, &joint(number), &joint(number + 1)));
            }
        }
        blocks.push(self.king_block());
        blocks
    }

    fn middle_radius_m(&self) -> f64 {
        self.inner_radius_m + 0.5 * self.wall_m
    }

    /// Angle above the ground of the seam below a course, at an azimuth.
    fn rise(&self, course: u32, azimuth: f64) -> f64 {
        let radius_m = self.middle_radius_m();
        if course == 0 {
            return -FOOTING_M / radius_m;
        }
        let fraction = f64::from(course) / f64::from(self.courses);
        let phase = TAU * self.random(course, 0, 0);
        let wave = (3.0 * azimuth + phase).sin() + 0.6 * (7.0 * azimuth + 2.0 * phase).sin();
        // The waves are smaller near the top, where the seam is short.
        fraction * (1.0 - KING_BLOCK_FRACTION) * FRAC_PI_2 + wave * (1.0 - 0.7 * fraction) * WAVE_M / (1.6 * radius_m)
    }

    /// Azimuth of a joint at a relative height of 0–1 in its course.
    fn azimuth(&self, joint: &Joint, height: f64) -> f64 {
        let uneven = UNEVEN_WIDTH * (self.random(joint.course, joint.number, 1) - 0.5);
        let lap = if joint.laps { TAU } else { 0.0 };
        let slant = SLANT_M / self.block_width_m * (self.random(joint.course, joint.number, 2) - 0.5) * (height - 0.5);
        joint.turn + (f64::from(joint.number) + uneven + 2.0 * slant) * TAU / joint.count + lap
    }

    fn block(&self, course: u32, number: u32, left: &Joint, right: &Joint) -> TriangleMesh {
        let radius_m = self.middle_radius_m();
        let direction = |u: f64, v: f64| {
            let azimuth = self.azimuth(left, v) * (1.0 - u) + self.azimuth(right, v) * u;
            let rise = self.rise(course, azimuth) * (1.0 - v) + self.rise(course + 1, azimuth) * v;
            DVec3::new(rise.cos() * azimuth.cos(), rise.cos() * azimuth.sin(), rise.sin())
        };
        let middle = direction(0.5, 0.5);
        let size_m = [
            radius_m * direction(0.0, 0.5).angle_between(direction(1.0, 0.5)),
            radius_m * direction(0.5, 0.0).angle_between(direction(0.5, 1.0)),
        ];
        // The block is stretched about its middle, so that it overlaps its neighbours.
        let [wider, higher] = size_m.map(|side_m| 1.0 + 2.0 * OVERLAP_M / side_m);
        let stretched = |u: f64, v: f64| direction(0.5 + (u - 0.5) * wider, 0.5 + (v - 0.5) * higher);
        let edges = |u: f64, v: f64| EdgeDistances {
            along_m: u.min(1.0 - u) * size_m[0] * course_stretch(stretched(0.5, v), middle),
            across_m: v.min(1.0 - v) * size_m[1],
        };
        let offset = OUT_OF_LINE_M * (2.0 * self.random(course, number, 3) - 1.0);
        self.closed(size_m, offset, &stretched, &edges)
    }

    /// The round block that closes the top.
    fn king_block(&self) -> TriangleMesh {
        let radius_m = self.middle_radius_m();
        let half_m = radius_m * (FRAC_PI_2 - self.rise(self.courses, 0.0));
        let stretch = 1.0 + OVERLAP_M / half_m;
        let direction = |u: f64, v: f64| {
            let DiscPoint { distance, azimuth } = disc(2.0 * u - 1.0, 2.0 * v - 1.0);
            let fall = distance * stretch * (FRAC_PI_2 - self.rise(self.courses, azimuth));
            DVec3::new(fall.sin() * azimuth.cos(), fall.sin() * azimuth.sin(), fall.cos())
        };
        let edges = |u: f64, v: f64| EdgeDistances {
            along_m: (1.0 - disc(2.0 * u - 1.0, 2.0 * v - 1.0).distance) * half_m,
            across_m: f64::INFINITY,
        };
        self.closed([2.0 * half_m; 2], 0.0, &direction, &edges)
    }

    /// The closed surface of a block. `direction` maps the unit square to directions from the centre, `edges` to
    /// distances from the edges.
    fn closed(
        &self,
        size_m: [f64; 2],
        offset_m: f64,
        direction: &dyn Fn(f64, f64) -> DVec3,
        edges: &dyn Fn(f64, f64) -> EdgeDistances,
    ) -> TriangleMesh {
        let [columns, rows] = size_m.map(|side_m| (side_m / GRID_SPACING_M).ceil().max(8.0));
        let (width, height) = (whole(columns) + 1, whole(rows) + 1);
        let mut block = TriangleMesh::default();
        for outside in [false, true] {
            for row in 0..height {
                for column in 0..width {
                    let (u, v) = (f64::from(column) / columns, f64::from(row) / rows);
                    let towards = direction(u, v);
                    let sunk_m = self.seam_m(&edges(u, v)) - self.relief_m(towards, outside);
                    let radius_m =
                        if outside { self.inner_radius_m + self.wall_m - sunk_m } else { self.inner_radius_m + sunk_m };
                    block.positions.push(((radius_m + offset_m) * towards).as_vec3());
                }
            }
        }
        block.indices = closed_grids(width, height);
        block
    }

    /// Depth of a face below its middle near rounded edges, in m.
    fn seam_m(&self, edges: &EdgeDistances) -> f64 {
        let near = |edge_m: f64| (1.0 - edge_m / self.seam_width_m).clamp(0.0, 1.0);
        // The 4-norm rounds corners less than a circle, which would leave holes where three blocks meet.
        let near = (near(edges.along_m).powi(4) + near(edges.across_m).powi(4)).sqrt().sqrt().min(1.0);
        self.seam_depth_m * near * near
    }

    fn relief_m(&self, towards: DVec3, outside: bool) -> f64 {
        let position = towards * self.inner_radius_m;
        RELIEF_M * relief(position, RELIEF_SIZE_M, self.seed.wrapping_add(if outside { 200 } else { 100 }))
    }

    /// A pseudo-random number in [0, 1) for one of the choices about a block.
    fn random(&self, course: u32, number: u32, choice: u32) -> f64 {
        uniform(IVec3::new(course.cast_signed(), number.cast_signed(), choice.cast_signed()), self.seed)
    }
}

/// A joint between two blocks of a course.
struct Joint {
    course: u32,
    number: u32,
    /// Azimuth at which the course starts.
    turn: f64,
    /// Number of blocks of the course.
    count: f64,
    /// Whether this is the first joint again after a full turn.
    laps: bool,
}

/// Circumference of a course at a height, divided by its circumference at the middle of the block.
fn course_stretch(direction: DVec3, middle: DVec3) -> f64 {
    direction.truncate().length() / middle.truncate().length()
}

/// A point of the unit disc in polar coordinates.
struct DiscPoint {
    distance: f64,
    azimuth: f64,
}

/// Distances from the edges of a block along and across its course.
struct EdgeDistances {
    along_m: f64,
    across_m: f64,
}

/// Maps the square [−1, 1]² to the unit disc, and concentric squares to circles (Shirley & Chiu 1997, "A low distortion
/// map between disk and square", doi:10.1080/10867651.1997.10487479).
fn disc(x: f64, y: f64) -> DiscPoint {
    let eighth = TAU / 8.0;
    if x == 0.0 && y == 0.0 {
        DiscPoint { distance: 0.0, azimuth: 0.0 }
    } else if x.abs() > y.abs() {
        DiscPoint { distance: x.abs(), azimuth: eighth * y / x + if x < 0.0 { 4.0 * eighth } else { 0.0 } }
    } else {
        let azimuth = 2.0 * eighth - eighth * x / y + if y < 0.0 { 4.0 * eighth } else { 0.0 };
        DiscPoint { distance: y.abs(), azimuth }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
fn whole(count: f64) -> u32 {
    count as u32
}

/// The vertex in the middle of a block's inner face.
#[cfg(test)]
fn middle_of_inner_face(block: &TriangleMesh) -> glam::Vec3 {
    let half = &block.positions[..block.positions.len() / 2];
    let mean = half.iter().sum::<glam::Vec3>() / half.len() as f32;
    *half.iter().min_by(|a, b| a.distance(mean).total_cmp(&b.distance(mean))).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use snowblue_base::narrow;
    use snowblue_geometry::mesh_bvh::MeshBvh;
    use snowblue_geometry::ray::Ray;
    use snowblue_geometry::topology::{Topology, volume};

    const IGLOO: Igloo = Igloo {
        inner_radius_m: 1.5,
        wall_m: 0.15,
        courses: 6,
        block_width_m: 0.6,
        seam_depth_m: 0.035,
        seam_width_m: 0.05,
        seed: 3,
    };

    #[test]
    fn every_block_is_closed_and_faces_outwards() {
        let blocks = IGLOO.blocks();
        for (number, block) in blocks.iter().enumerate() {
            let topology = Topology::of(block);
            assert!(topology.is_closed() && topology.reversed_edges == 0, "block {number}: {topology:?}");
            assert_eq!((topology.shared_edges, topology.degenerate_triangles), (0, 0), "block {number}");
        }
        // A half shell and its footing. The seams take less than a fifth of the volume.
        let shell_m3 = TAU / 3.0 * (1.65f64.powi(3) - 1.5f64.powi(3)) + TAU * 1.575 * 0.15 * 0.06;
        let filled = blocks.iter().map(volume).sum::<f64>() / shell_m3;
        assert!((0.8..1.0).contains(&filled), "{filled}");
    }

    #[test]
    fn walls_have_full_thickness_in_the_middle_of_blocks_and_less_at_seams() {
        for (number, block) in IGLOO.blocks().into_iter().enumerate() {
            let middle = middle_of_inner_face(&block).normalize();
            let edge = block.positions[0].normalize();
            let mesh = MeshBvh::new(block);
            // Just inside the edge, where the neighbour does not overlap.
            let thickness = |towards: Vec3| {
                let mut crossings = Vec::new();
                mesh.crossings(&Ray::new((0.1 * towards).into(), towards.into()), f32::NEG_INFINITY, &mut crossings);
                crossings.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
                crossings.chunks_exact(2).map(|pair| pair[1].distance_m - pair[0].distance_m).sum::<f32>()
            };
            // The relief of either face is at most twice its amplitude.
            assert!((thickness(middle) - 0.15).abs() < 4.0 * narrow(RELIEF_M), "block {number}: {}", thickness(middle));
            let seam = thickness(edge.lerp(middle, 0.01).normalize());
            assert!((0.06..0.12).contains(&seam), "block {number}: {seam}");
        }
    }

    #[test]
    fn lines_from_inside_hit_snow_in_every_direction() {
        let blocks: Vec<MeshBvh> = IGLOO.blocks().into_iter().map(MeshBvh::new).collect();
        for number in 0..3000u32 {
            let rise = f64::from(number) / 3000.0;
            let azimuth = 2.399_963 * f64::from(number);
            let level = (1.0 - rise * rise).sqrt();
            let direction = DVec3::new(level * azimuth.cos(), level * azimuth.sin(), rise).as_vec3a();
            let ray = Ray::new(glam::Vec3A::ZERO, direction);
            assert!(blocks.iter().any(|block| block.occludes(&ray, f32::INFINITY)), "{direction}");
        }
    }

    #[test]
    fn courses_have_at_most_as_many_blocks_as_those_below() {
        for course in 1..IGLOO.courses {
            let around = |course: u32| {
                let middle = 0.5 * (IGLOO.rise(course, 0.0) + IGLOO.rise(course + 1, 0.0));
                (TAU * IGLOO.middle_radius_m() * middle.cos() / IGLOO.block_width_m).round()
            };
            assert!(around(course) <= around(course - 1), "courses get shorter");
        }
    }
}
