//! Snow on a mesh: one layer on all that is seen from above, as fallen vertically.
//!
//! Lines along z through the nodes of a square lattice find the ground. Gaps narrower than the depth of the snow are
//! bridged: the ground of the snow is where a ball of that diameter comes to rest. Where the ground ends, or drops by
//! more than half the depth from one node to the next, the snow ends. The ends lie on the edges of the ground, and not
//! at nodes, so that they are as straight as the edges.
//!
//! The snow lies as loose material does. With the height g of the ground, the slope t from which snow slides and the
//! depth D elsewhere, W is the greatest field for which
//!
//! ```text
//! 0 ≤ W ≤ 2 D,   W = 0 where the snow ends,   |∇(g + W)| ≤ t where W > 0,
//! ```
//!
//! and the snow is W − W²/4D deep. At the distance d from an edge of level ground, W is t d: the snow ends in a round
//! rim of slope t. A face steeper than t is bare but for a wedge at its foot. The obstacle problem is solved by fast
//! sweeping (Zhao 2005, "A fast sweeping method for eikonal equations", doi:10.1090/S0025-5718-04-01678-3).
//!
//! The surface of deep snow shows the mean of the ground within half a depth.

use glam::{DVec2, I64Vec2, Vec2, Vec3A};
use rayon::prelude::*;
use snowblue_base::narrow;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::ray::{MeshLocation, Ray, ShapeHit};
use snowblue_geometry::triangle_mesh::TriangleMesh;

use crate::sheet::{Sheet, SheetVertex};

/// Distance of nodes as a fraction of the greatest depth.
const CELL_OF_DEPTH: f64 = 0.125;
/// Growth of this distance if there are too many nodes.
const COARSER: f64 = 1.25;
/// Greatest number of nodes of the lattice, and greatest number of nodes with ground. The solid has at most 12
/// triangles for each node with ground: 6 above and 6 below.
const MAX_LATTICE: f64 = 4_194_304.0;
const MAX_NODES: usize = 1 << 18;
/// Steps of bisection that find where the ground ends between two nodes.
const BISECTIONS: u32 = 12;
/// Change of W at which sweeping ends, as a fraction of the greatest depth.
const TOLERANCE: f64 = 1e-4;
/// The six neighbours of a node in turn, counter-clockwise. Two neighbours in turn and the node are a triangle.
const NEIGHBOURS: [I64Vec2; 6] = [
    I64Vec2::new(1, 0),
    I64Vec2::new(1, 1),
    I64Vec2::new(0, 1),
    I64Vec2::new(-1, 0),
    I64Vec2::new(-1, -1),
    I64Vec2::new(0, -1),
];
/// The corners of the two triangles at a place of the lattice, and for each corner the number of its neighbour among
/// the corners, the next corner in turn.
const TRIANGLES: [([I64Vec2; 3], [usize; 3]); 2] = [
    ([I64Vec2::ZERO, I64Vec2::new(1, 0), I64Vec2::ONE], [0, 2, 4]),
    ([I64Vec2::ZERO, I64Vec2::ONE, I64Vec2::new(0, 1)], [1, 3, 5]),
];
/// The error of a mesh without snow.
const NO_SNOW: &str = "has no snow anywhere";

/// Snow on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SnowLayer {
    /// Height of the underside above the mesh, in m.
    pub gap_m: f64,
    /// Greatest depth, in m.
    pub most_m: f64,
    /// Tangent of the angle from which the snow slides.
    pub slide_slope: f64,
}

/// The solid of snow on a mesh with z upwards. `depth_m` gives the depth at a place of the mesh: at most
/// `layer.most_m`, and 0 where there is no snow.
///
/// # Errors
///
/// When the mesh has no ground that is seen from above, no snow lies anywhere, or the mesh is too wide for the depth.
pub fn snow_on_mesh(
    ground: TriangleMesh,
    layer: &SnowLayer,
    depth_m: &(dyn Fn(&MeshBvh, &MeshLocation) -> f64 + Sync),
) -> Result<TriangleMesh, String> {
    if layer.most_m <= 0.0 {
        return Err(NO_SNOW.to_owned());
    }
    let ground = MeshBvh::new(ground);
    let mut cell_m = CELL_OF_DEPTH * layer.most_m;
    while cell_m <= layer.most_m {
        let lattice = Lattice::new(&ground, cell_m, layer.most_m);
        if lattice.size.as_dvec2().element_product() <= MAX_LATTICE {
            let nodes = lattice.nodes(depth_m);
            if nodes.is_empty() {
                return Err("has no face that is seen from above".to_owned());
            }
            if nodes.len() <= MAX_NODES {
                return Cover::new(&lattice, layer, nodes).solid();
            }
        }
        cell_m *= COARSER;
    }
    Err(format!("is too wide for snow of at most {} m, which needs more than {MAX_NODES} nodes", layer.most_m))
}

/// A square lattice over the ground.
struct Lattice<'a> {
    ground: &'a MeshBvh,
    low_m: DVec2,
    cell_m: f64,
    /// Numbers of nodes along both axes.
    size: I64Vec2,
    /// The offsets within half of the greatest depth, in cells, each with the height there of a ball about the origin.
    ball: Vec<(I64Vec2, f64)>,
    radius_m: f64,
}

/// A node of the lattice with ground.
struct Node {
    at: I64Vec2,
    ground_m: f64,
    is_bridge: bool,
    depth_m: f64,
    uv: Vec2,
}

impl<'a> Lattice<'a> {
    fn new(ground: &'a MeshBvh, cell_m: f64, most_m: f64) -> Self {
        let bounds = ground.bounds();
        let [low_m, high_m] = [bounds.low, bounds.high].map(|corner| corner.as_dvec3().truncate());
        let radius_m = 0.5 * most_m;
        let reach = (radius_m / cell_m).ceil();
        let margin = reach + 1.5;
        let offsets = grid(I64Vec2::splat(whole(2.0 * reach) + 1)).map(|at| at - whole(reach));
        let height = |at: I64Vec2| {
            let square = radius_m * radius_m - cell_m * cell_m * at.as_dvec2().length_squared();
            (square > 0.0).then(|| (at, square.sqrt()))
        };
        Self {
            ground,
            low_m: low_m - margin * cell_m,
            cell_m,
            size: ((high_m - low_m) / cell_m + 2.0 * margin).ceil().as_i64vec2(),
            ball: offsets.filter_map(height).collect(),
            radius_m,
        }
    }

    /// The number of a node, if it belongs to the lattice.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a lattice has at most 2^22 nodes")]
    fn number(&self, at: I64Vec2) -> Option<usize> {
        let is_inside = at.cmpge(I64Vec2::ZERO).all() && at.cmplt(self.size).all();
        is_inside.then(|| (at.y * self.size.x + at.x) as usize)
    }

    fn place_m(&self, at: I64Vec2) -> DVec2 {
        self.low_m + self.cell_m * at.as_dvec2()
    }

    /// The ground that is seen from above at a place.
    fn hit(&self, place_m: DVec2) -> Option<ShapeHit> {
        let bounds = self.ground.bounds();
        let origin = place_m.as_vec2().extend(bounds.high.z + bounds.diagonal_m());
        let ray = Ray::new(origin.into(), Vec3A::NEG_Z);
        self.ground.first_hit(&ray, f32::INFINITY)
    }

    /// The nodes with ground, row by row.
    fn nodes(&self, depth_m: &(dyn Fn(&MeshBvh, &MeshLocation) -> f64 + Sync)) -> Vec<Node> {
        let places: Vec<I64Vec2> = grid(self.size).collect();
        let seen_m = |at: &I64Vec2| self.hit(self.place_m(*at)).map_or(f64::NEG_INFINITY, |hit| hit.point.z.into());
        let seen_m: Vec<f64> = places.par_iter().map(seen_m).collect();
        // The height of a ball's centre that rests on the ground, and the number of the node that it rests on.
        let resting = |at: &I64Vec2| {
            let touched = |(offset, height_m): &(I64Vec2, f64)| {
                let number = self.number(at + offset)?;
                Some((seen_m[number] + height_m, number))
            };
            let touched = self.ball.iter().filter_map(touched);
            touched.fold((f64::NEG_INFINITY, 0), |most, other| if other.0 > most.0 { other } else { most })
        };
        let resting: Vec<(f64, usize)> = places.par_iter().map(resting).collect();
        let node = |(number, at): (usize, &I64Vec2)| {
            let under = |(offset, height_m): &(I64Vec2, f64)| {
                let (centre_m, touched) = self.number(at + offset).map_or((f64::NEG_INFINITY, 0), |ball| resting[ball]);
                (centre_m - height_m, touched)
            };
            let under = self.ball.iter().map(under);
            let (bridge_m, touched) =
                under.fold((f64::INFINITY, 0), |least, other| if other.0 < least.0 { other } else { least });
            // A ball leaves room in every hollow; a gap is deeper than its radius.
            let is_bridge = bridge_m > f64::NEG_INFINITY && bridge_m - seen_m[number] > self.radius_m;
            let (ground_m, source) = if is_bridge { (bridge_m, touched) } else { (seen_m[number], number) };
            let hit = self.hit(self.place_m(places[source]))?;
            let uv = self.ground.uv(&hit.location).unwrap_or(Vec2::ZERO);
            Some(Node { at: *at, ground_m, is_bridge, depth_m: depth_m(self.ground, &hit.location), uv })
        };
        places.par_iter().enumerate().filter_map(node).collect()
    }
}

/// A point between two nodes at which the snow ends.
#[derive(Clone, Copy)]
struct End {
    place_m: DVec2,
    height_m: f64,
    /// Distance from the node, in m.
    distance_m: f64,
}

/// Snow on the nodes of a lattice.
struct Cover<'a> {
    lattice: &'a Lattice<'a>,
    layer: &'a SnowLayer,
    nodes: Vec<Node>,
    /// For each node of the lattice the index of the node with ground, if any.
    index: Vec<Option<u32>>,
    /// For each node with ground, its neighbours in turn: the index of a node, or the number of nodes plus the index
    /// of an end.
    neighbours: Vec<[u32; 6]>,
    ends: Vec<End>,
}

impl<'a> Cover<'a> {
    fn new(lattice: &'a Lattice<'a>, layer: &'a SnowLayer, nodes: Vec<Node>) -> Self {
        let mut index = vec![None; lattice.size.as_usizevec2().element_product()];
        for (number, node) in (0..).zip(&nodes) {
            lattice.number(node.at).into_iter().for_each(|at| index[at] = Some(number));
        }
        let cover = Self { lattice, layer, nodes, index, neighbours: Vec::new(), ends: Vec::new() };
        let ends = cover.ends(&cover.cuts());
        let mut next = count(cover.nodes.len());
        let mut neighbour = |node: &Node, side: usize, end: Option<End>| match end {
            Some(_) => {
                next += 1;
                next - 1
            }
            None => cover.node(node.at + NEIGHBOURS[side]).expect("a side without an end leads to a node"),
        };
        let of_node =
            |(node, ends): (&Node, &[Option<End>; 6])| std::array::from_fn(|side| neighbour(node, side, ends[side]));
        let neighbours = cover.nodes.iter().zip(&ends).map(of_node).collect();
        Self { neighbours, ends: ends.into_iter().flatten().flatten().collect(), ..cover }
    }

    /// The node with ground at a place of the lattice.
    fn node(&self, at: I64Vec2) -> Option<u32> {
        self.index[self.lattice.number(at)?]
    }

    /// The nodes at the corners of all triangles of the lattice, and the sides to the next corners.
    fn triangles(&self) -> impl Iterator<Item = ([Option<u32>; 3], [usize; 3])> {
        let triangles =
            |at: I64Vec2| TRIANGLES.map(|(corners, sides)| (corners.map(|corner| self.node(at + corner)), sides));
        grid(self.lattice.size).flat_map(triangles)
    }

    /// The greatest difference of height over a distance at which the ground still counts as continuous, in m.
    fn greatest_step_m(&self, distance_m: f64) -> f64 {
        self.lattice.radius_m + self.layer.slide_slope * distance_m
    }

    /// For each node, whether the snow ends before each neighbour.
    fn cuts(&self) -> Vec<[bool; 6]> {
        let ground_m = |node: u32| self.nodes[node as usize].ground_m;
        let is_cut = |node: &Node, side: usize| {
            let most_m = self.greatest_step_m(self.lattice.cell_m * NEIGHBOURS[side].as_dvec2().length());
            self.node(node.at + NEIGHBOURS[side]).is_none_or(|other| (ground_m(other) - node.ground_m).abs() > most_m)
        };
        let mut cuts: Vec<[bool; 6]> =
            self.nodes.iter().map(|node| std::array::from_fn(|side| is_cut(node, side))).collect();
        // If the snow ends on one side of a triangle, it ends on another side as well.
        let whole: Vec<([u32; 3], [usize; 3])> =
            self.triangles().filter_map(|(nodes, sides)| Some(([nodes[0]?, nodes[1]?, nodes[2]?], sides))).collect();
        let mut has_changed = true;
        while has_changed {
            has_changed = false;
            for (nodes, sides) in &whole {
                let joined = (0..3).filter(|corner| !cuts[nodes[*corner] as usize][sides[*corner]]);
                if joined.clone().count() != 2 {
                    continue;
                }
                let drop_m = |corner: &usize| (ground_m(nodes[*corner]) - ground_m(nodes[(corner + 1) % 3])).abs();
                if let Some(corner) = joined.max_by(|one, other| drop_m(one).total_cmp(&drop_m(other))) {
                    cuts[nodes[corner] as usize][sides[corner]] = true;
                    cuts[nodes[(corner + 1) % 3] as usize][opposite(sides[corner])] = true;
                    has_changed = true;
                }
            }
        }
        cuts
    }

    /// The points where the snow ends around each node.
    fn ends(&self, cuts: &[[bool; 6]]) -> Vec<[Option<End>; 6]> {
        let lattice = self.lattice;
        let end = |node: &Node, side: usize| {
            let (from_m, step_m) = (lattice.place_m(node.at), lattice.cell_m * NEIGHBOURS[side].as_dvec2());
            let (mut inside, mut outside, mut height_m) = (0.0, 1.0, node.ground_m);
            // A bridge has no ground whose edge could be found.
            for _ in 0..if node.is_bridge { 0 } else { BISECTIONS } {
                let middle = 0.5 * (inside + outside);
                let hit_m = lattice.hit(from_m + middle * step_m).map(|hit| f64::from(hit.point.z));
                match hit_m
                    .filter(|hit_m| (hit_m - node.ground_m).abs() <= self.greatest_step_m(middle * step_m.length()))
                {
                    Some(hit_m) => (inside, height_m) = (middle, hit_m),
                    None => outside = middle,
                }
            }
            let fraction = 0.5 * (inside + outside);
            End { place_m: from_m + fraction * step_m, height_m, distance_m: fraction * step_m.length() }
        };
        let of_node =
            |(node, cuts): (&Node, &[bool; 6])| std::array::from_fn(|side| cuts[side].then(|| end(node, side)));
        self.nodes.par_iter().zip(cuts).map(of_node).collect()
    }

    /// For each node, the depth of snow away from edges, by the mean height of the ground around the node.
    fn full_depths_m(&self) -> Vec<f64> {
        let depth_m = |node: &Node| {
            let around = self.lattice.ball.iter().filter_map(|(offset, _)| self.node(node.at + offset));
            let above_m = around.map(|other| self.nodes[other as usize].ground_m - node.ground_m);
            let (sum_m, count) = above_m
                .filter(|above_m| above_m.abs() <= self.layer.most_m)
                .fold((0.0, 0.0), |(sum_m, count), above_m| (sum_m + above_m, count + 1.0));
            if node.depth_m > 0.0 { (node.depth_m + sum_m / count).max(0.0) } else { 0.0 }
        };
        self.nodes.par_iter().map(depth_m).collect()
    }

    /// The depth of snow at each node.
    fn depths_m(&self) -> Vec<f64> {
        let full_m = self.full_depths_m();
        let ground_m = |node: usize| self.nodes[node].ground_m;
        let mut tops_m: Vec<f64> = (0..self.nodes.len()).map(|node| ground_m(node) + 2.0 * full_m[node]).collect();
        let rows: Vec<usize> = (0..self.nodes.len()).collect();
        let mut columns = rows.clone();
        columns.sort_unstable_by_key(|node| self.nodes[*node].at.to_array());
        let mut change_m = f64::INFINITY;
        while change_m > TOLERANCE * self.layer.most_m {
            change_m = 0.0;
            let sweeps = rows.iter().chain(rows.iter().rev()).chain(&columns).chain(columns.iter().rev());
            for &node in sweeps {
                // The lower of both neighbours on each axis.
                let lower = [[0, 3], [2, 5]].map(|sides| {
                    let [one, other] = sides.map(|side| self.beside(&tops_m, node, side));
                    let limit_m = |(top_m, distance_m): (f64, f64)| top_m + self.layer.slide_slope * distance_m;
                    if limit_m(one) < limit_m(other) { one } else { other }
                });
                let top_m = highest_m(self.layer.slide_slope, lower).max(ground_m(node)).min(tops_m[node]);
                change_m = change_m.max(tops_m[node] - top_m);
                tops_m[node] = top_m;
            }
        }
        let depth_m = |(node, full_m): (usize, f64)| {
            let limit_m = tops_m[node] - ground_m(node);
            if full_m > 0.0 { limit_m - limit_m * limit_m / (4.0 * full_m) } else { 0.0 }
        };
        full_m.into_iter().enumerate().map(depth_m).collect()
    }

    /// The height of g + W on a side of a node, and the distance from the node.
    fn beside(&self, tops_m: &[f64], node: usize, side: usize) -> (f64, f64) {
        let neighbour = self.neighbours[node][side] as usize;
        match neighbour.checked_sub(self.nodes.len()) {
            Some(end) => (self.ends[end].height_m, self.ends[end].distance_m),
            None => (tops_m[neighbour], self.lattice.cell_m),
        }
    }

    /// The solid.
    fn solid(&self) -> Result<TriangleMesh, String> {
        let vertex = |place_m: DVec2, ground_m: f64, depth_m: f64, uv: Vec2| {
            let bottom_m = ground_m + self.layer.gap_m;
            SheetVertex { position: place_m.extend(bottom_m).as_vec3(), top: narrow(bottom_m + depth_m), uv }
        };
        let nodes = self.nodes.iter().zip(self.depths_m());
        let mut vertices: Vec<SheetVertex> = nodes
            .map(|(node, depth_m)| vertex(self.lattice.place_m(node.at), node.ground_m, depth_m, node.uv))
            .collect();
        for (node, neighbours) in self.nodes.iter().zip(&self.neighbours) {
            let ends = neighbours.iter().filter_map(|neighbour| (*neighbour as usize).checked_sub(self.nodes.len()));
            vertices.extend(ends.map(|end| vertex(self.ends[end].place_m, self.ends[end].height_m, 0.0, node.uv)));
        }
        let mut triangles = Vec::new();
        self.triangles().for_each(|(nodes, sides)| self.add_parts(nodes, sides, &mut triangles));
        let mut solid = Sheet { vertices, triangles, ..Sheet::default() }.solid();
        if solid.indices.is_empty() {
            return Err(NO_SNOW.to_owned());
        }
        if self.lattice.ground.triangles().uv.is_empty() {
            solid.uv.clear();
        }
        Ok(solid)
    }

    /// Adds the parts of a triangle of the lattice on which snow lies.
    fn add_parts(&self, nodes: [Option<u32>; 3], sides: [usize; 3], parts: &mut Vec<[u32; 3]>) {
        let neighbour = |node: u32, side: usize| self.neighbours[node as usize][side];
        let is_node = |vertex: u32| (vertex as usize) < self.nodes.len();
        let mut joined = 0;
        for corner in 0..3 {
            let Some(node) = nodes[corner] else { continue };
            let [next_side, last_side] = [1, 2].map(|step| sides[(corner + step) % 3]);
            let (next, previous) = (neighbour(node, sides[corner]), neighbour(node, opposite(last_side)));
            joined += u32::from(is_node(next));
            match (is_node(previous), is_node(next)) {
                (false, false) => parts.push([node, next, previous]),
                (false, true) => {
                    let beyond = neighbour(next, next_side);
                    parts.extend([[node, next, beyond], [node, beyond, previous]]);
                }
                (true, _) => {}
            }
        }
        if let ([Some(a), Some(b), Some(c)], 3) = (nodes, joined) {
            parts.push([a, b, c]);
        }
    }
}

/// The greatest height of a node next to lower neighbours along x and along y, each with its height and its distance,
/// so that the surface has at most a slope.
fn highest_m(slope: f64, [along_x, along_y]: [(f64, f64); 2]) -> f64 {
    let along_one_m = (along_x.0 + slope * along_x.1).min(along_y.0 + slope * along_y.1);
    let [x, y] = [along_x, along_y].map(|(_, distance_m)| distance_m.powi(-2));
    let mean_m = (x * along_x.0 + y * along_y.0) / (x + y);
    let square = slope * slope - x * y / (x + y) * (along_x.0 - along_y.0).powi(2);
    let both_m = mean_m + (square.max(0.0) / (x + y)).sqrt();
    if square >= 0.0 && both_m >= along_x.0.max(along_y.0) { both_m.min(along_one_m) } else { along_one_m }
}

/// The side of the neighbour that leads back.
fn opposite(side: usize) -> usize {
    (side + 3) % 6
}

/// All places of a lattice, row by row.
fn grid(size: I64Vec2) -> impl Iterator<Item = I64Vec2> {
    (0..size.y).flat_map(move |y| (0..size.x).map(move |x| I64Vec2::new(x, y)))
}

#[expect(clippy::cast_possible_truncation, reason = "a lattice has at most 2^22 nodes")]
fn count(count: usize) -> u32 {
    count as u32
}

#[expect(clippy::cast_possible_truncation, reason = "a small whole number")]
fn whole(value: f64) -> i64 {
    value as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use snowblue_geometry::topology::{Topology, volume};

    const DEPTH_M: f64 = 0.2;
    /// That of 45°.
    const SLOPE: f64 = 1.0;

    fn layer(most_m: f64) -> SnowLayer {
        SnowLayer { gap_m: 0.0, most_m, slide_slope: SLOPE }
    }

    fn snow(ground: &[[Vec3; 3]]) -> TriangleMesh {
        let solid = snow_on_mesh(TriangleMesh::from_triangles(ground), &layer(DEPTH_M), &|_, _| DEPTH_M).unwrap();
        let topology = Topology::of(&solid);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        solid
    }

    /// Two triangles with three of the corners of a parallelogram.
    fn quad(corner: Vec3, along: Vec3, across: Vec3) -> [[Vec3; 3]; 2] {
        let far = corner + along + across;
        [[corner, corner + along, far], [corner, far, corner + across]]
    }

    /// A level rectangle at a place with some sides.
    fn level(at: [f32; 3], size: [f32; 2]) -> [[Vec3; 3]; 2] {
        quad(at.into(), size[0] * Vec3::X, size[1] * Vec3::Y)
    }

    /// The depth of the snow below a place, if there is any.
    fn depth_m(mesh: &MeshBvh, x: f32, y: f32) -> Option<f32> {
        let mut crossings = Vec::new();
        let ray = Ray::new(Vec3A::new(x, y, 9.0), Vec3A::NEG_Z);
        mesh.crossings(&ray, 0.0, &mut crossings);
        crossings.sort_by(|one, other| one.distance_m.total_cmp(&other.distance_m));
        assert_eq!(crossings.len() % 2, 0);
        let (pairs, _) = crossings.as_chunks::<2>();
        (!pairs.is_empty()).then(|| pairs.iter().map(|[top, bottom]| bottom.distance_m - top.distance_m).sum())
    }

    /// Depth at a distance from the edge of level ground.
    fn rim_m(from_edge_m: f64) -> f64 {
        let limit_m = (SLOPE * from_edge_m).min(2.0 * DEPTH_M);
        limit_m - limit_m * limit_m / (4.0 * DEPTH_M)
    }

    fn divided(triangles: &[[Vec3; 3]]) -> Vec<[Vec3; 3]> {
        let quarters = |[a, b, c]: &[Vec3; 3]| {
            let [ab, bc, ca] = [a.midpoint(*b), b.midpoint(*c), c.midpoint(*a)];
            [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
        };
        triangles.iter().flat_map(quarters).collect()
    }

    #[test]
    fn snow_on_level_ground_ends_in_a_round_rim_at_its_edges() {
        let coarse = level([0.07, -0.03, 1.0], [2.0, 1.5]).to_vec();
        let fine = divided(&divided(&divided(&coarse)));
        // ∫ depth dA over the strips at a distance from the edge.
        let strip_m3 = |step: u16| {
            let from_edge_m = 0.75 * (f64::from(step) + 0.5) / 1000.0;
            rim_m(from_edge_m) * 2.0 * (2.0 + 1.5 - 4.0 * from_edge_m) * 0.75 / 1000.0
        };
        let expected_m3: f64 = (0..1000).map(strip_m3).sum();
        let solids = [coarse, fine].map(|ground| snow(&ground));
        assert_eq!(solids[0].indices.len(), solids[1].indices.len(), "triangles follow the depth");
        for solid in solids {
            // Chords of cells of an eighth of the depth.
            assert!((volume(&solid) / expected_m3 - 1.0).abs() < 0.01, "{} m³ of {expected_m3} m³", volume(&solid));
            // The outline is straight, and lies on the edge of the ground.
            let [low, high] = [Vec2::new(0.07, -0.03), Vec2::new(2.07, 1.47)];
            let cell_m = narrow(CELL_OF_DEPTH * DEPTH_M);
            assert!(solid.positions.iter().all(|at| {
                let beyond = (low - at.truncate()).max(at.truncate() - high).max_element();
                beyond < 0.02 * cell_m
            }));
            let mesh = MeshBvh::new(solid);
            for from_edge_m in [0.01f32, 0.05, 0.1, 0.2, 0.35, 0.6] {
                let found_m = depth_m(&mesh, 0.07 + from_edge_m, 0.7).map(f64::from).unwrap();
                let expected_m = rim_m(from_edge_m.into());
                assert!(
                    (found_m - expected_m).abs() < 0.02 * DEPTH_M,
                    "{from_edge_m} m: {found_m} m, not {expected_m} m"
                );
            }
        }
    }

    #[test]
    fn gaps_narrower_than_the_depth_are_bridged_and_wider_gaps_are_open() {
        for (gap_of_depth, is_bridged) in [(0.3, true), (0.75, true), (1.3, false), (2.0, false)] {
            let half_m = narrow(0.5 * gap_of_depth * DEPTH_M);
            // Nothing below, and a floor far below.
            for floor in [Vec::new(), level([-1.0, 0.0, -3.0], [2.0, 2.0]).to_vec()] {
                let sides =
                    [level([-1.0, 0.0, 0.0], [1.0 - half_m, 2.0]), level([half_m, 0.0, 0.0], [1.0 - half_m, 2.0])];
                let mesh = MeshBvh::new(snow(&[sides.concat(), floor].concat()));
                let ray = Ray::new(Vec3A::new(0.003, 1.0, 9.0), Vec3A::NEG_Z);
                let top_m = mesh.first_hit(&ray, f32::INFINITY).map(|hit| f64::from(hit.point.z));
                // A ball between both sides sinks by less than its radius.
                let is_closed = top_m.is_some_and(|top_m| (0.5..1.05).contains(&(top_m / DEPTH_M)));
                assert_eq!(is_closed, is_bridged, "{gap_of_depth}: {top_m:?}");
                assert!(is_closed || top_m.is_none_or(|top_m| top_m < -2.5), "{gap_of_depth}: {top_m:?}");
            }
        }
    }

    /// Slopes around the angle of 45° between level parts.
    #[test]
    fn steep_faces_are_bare_and_the_surface_of_snow_is_nowhere_steeper_than_the_limit() {
        for (slope, is_covered) in [(0.0, true), (0.6, true), (0.9, true), (1.3, false), (3.0, false)] {
            let rise = Vec3::new(2.0, 0.0, 2.0 * slope);
            let ground = [
                level([-2.0, 0.0, 0.0], [2.0, 3.0]),
                quad(Vec3::ZERO, rise, 3.0 * Vec3::Y),
                level(rise.to_array(), [2.0, 3.0]),
            ];
            let solid = snow(&ground.concat());
            let (mut area_m2, mut steep_m2) = (0.0, 0.0);
            for triangle in 0..solid.indices.len() {
                let [a, b, c] = solid.corners(triangle).map(Vec3::as_dvec3);
                let normal = (b - a).cross(c - a);
                // Not the wedge of snow that ends on a steep face.
                let is_level = [a, b, c].iter().all(|at| at.x < -0.05 || at.x > 2.05);
                if normal.z > 0.0 && (is_level || is_covered) {
                    area_m2 += normal.length();
                    // Sweeping on a lattice has an error of the first order.
                    steep_m2 += if normal.truncate().length() > 1.1 * SLOPE * normal.z { normal.length() } else { 0.0 };
                }
            }
            assert!(steep_m2 < 0.002 * area_m2, "{slope}: {steep_m2} of {area_m2}");
            let mesh = MeshBvh::new(solid);
            let on_slope_m = depth_m(&mesh, 1.4, 1.5).map_or(0.0, f64::from);
            assert!((on_slope_m / DEPTH_M - f64::from(u8::from(is_covered))).abs() < 0.03, "{slope}: {on_slope_m}");
            // The level parts carry the full depth, the lower up to the foot.
            for x in [-1.0, 3.0] {
                assert!((depth_m(&mesh, x, 1.5).map_or(0.0, f64::from) / DEPTH_M - 1.0).abs() < 0.03, "{slope}: {x}");
            }
        }
    }

    #[test]
    fn snow_ends_at_a_step_and_shelters_the_ground_below() {
        let strip = level([1.5, 0.0, 0.5], [0.01, 2.0]);
        let ground = [level([-1.0, 0.0, 0.0], [2.0, 2.0]), level([0.0, 0.0, 1.0], [1.5, 2.0]), strip];
        let solid = snow(&ground.concat());
        // No triangle joins both levels, not even where a face between two nodes lies far below the edge.
        for triangle in 0..solid.indices.len() {
            let [a, b, c] = solid.corners(triangle).map(|corner| corner.z);
            assert!(a.max(b).max(c) - a.min(b).min(c) < 0.1, "{a} {b} {c}");
        }
        let mesh = MeshBvh::new(solid);
        for (x, levels) in [(-0.5, 1), (0.75, 1), (1.49, 1)] {
            let mut crossings = Vec::new();
            mesh.crossings(&Ray::new(Vec3A::new(x, 1.0, 9.0), Vec3A::NEG_Z), 0.0, &mut crossings);
            assert_eq!(crossings.len(), 2 * levels, "{x}");
        }
    }

    #[test]
    fn the_number_of_triangles_is_bounded_and_the_rest_is_refused() {
        let wide = |side_m: f32| level([0.0; 3], [side_m, side_m]);
        let solid = snow(&wide(60.0));
        assert!(solid.indices.len() <= 12 * MAX_NODES, "{}", solid.indices.len());
        assert!((volume(&solid) / (3600.0 * DEPTH_M) - 1.0).abs() < 0.02);
        let refused = |ground: &[[Vec3; 3]], most_m: f64| {
            snow_on_mesh(TriangleMesh::from_triangles(ground), &layer(most_m), &|_, _| 0.0).unwrap_err()
        };
        let message = refused(&wide(600.0), DEPTH_M);
        assert_eq!(message, "is too wide for snow of at most 0.2 m, which needs more than 262144 nodes");
        let wall = quad(Vec3::ZERO, Vec3::X, Vec3::Z);
        assert_eq!(refused(&wall, 1.0), "has no face that is seen from above");
        assert_eq!(refused(&wide(1.0), 0.0), "has no snow anywhere");
        assert_eq!(refused(&wide(1.0), 1.0), "has no snow anywhere");
    }

    #[test]
    fn one_thread_and_many_give_the_same_snow() {
        let needle = |k: u16| {
            let at = Vec3::from_array([0.37, 0.71, 0.13].map(|step: f32| (step * f32::from(k)).fract()));
            let across = Vec3::new(at.y - 0.5, 0.5 - at.x, 0.1);
            [at, at + 0.1 * across, at + 0.02 * Vec3::ONE]
        };
        let branches: Vec<_> = (0..400).map(needle).collect();
        let on_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| snow(&branches))
        };
        assert_eq!(on_threads(1), on_threads(3));
    }
}
