//! A lower bound of the net flux at vertices.
//!
//! No radiance is negative. By the exit law with the R₀ = 1/π of a white diffuse surface, F + K(μ) J ≥ 0 for every
//! cosine μ, so J ≥ −F/K(1), since K grows with μ. Within a transport mean free path of the edge of a lit face, the
//! diffusion approximation violates this bound. Its solution conserves energy against each shape function, whose
//! support includes both sides of the edge: a deficit of flux on one side is an excess of flux on the opposite side.
//! The flux that the bound adds is therefore subtracted from the vertices around, in proportion to the excess of each
//! vertex over its own bound. The total flux through the surface is conserved, unless no vertex is near.

use std::collections::HashMap;

use glam::{IVec3, Vec3};
use snowblue_scene::spectrum::Spectrum;

/// The net flux J at a vertex, its least value −F/K(1), and the area around the vertex.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoundedFlux {
    pub(super) position: Vec3,
    /// A third of the area of the triangles around the vertex, in m².
    pub(super) area_m2: f32,
    pub(super) flux: Spectrum,
    pub(super) least: Spectrum,
}

/// A third of the area of the triangles around each vertex, in m².
pub(super) fn vertex_areas_m2(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<f32> {
    let mut areas_m2 = vec![0.0; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
        let share_m2 = (b - a).cross(c - a).length() / 6.0;
        triangle.iter().for_each(|vertex| areas_m2[*vertex as usize] += share_m2);
    }
    areas_m2
}

/// The numbers of the positions within a distance in m of some positions, including these positions.
pub(super) fn within(reach_m: f32, centres: &[usize], positions: &[Vec3]) -> Vec<usize> {
    let cubes = Cubes::around(reach_m, centres.iter().map(|number| (*number, positions[*number])));
    let is_near = |number: &usize| cubes.near(positions[*number]).next().is_some();
    (0..positions.len()).filter(is_near).collect()
}

/// Raises each flux to its least value, and subtracts the added flux from the vertices within `reach_m`.
pub(super) fn limit(vertices: &mut [BoundedFlux], reach_m: f32) {
    let mut lacking = Vec::new();
    for (number, vertex) in vertices.iter_mut().enumerate() {
        let missing = vertex.below();
        if missing.0.iter().any(|value| *value > 0.0) {
            vertex.flux += missing;
            lacking.push((number, missing * vertex.area_m2));
        }
    }
    let cubes = Cubes::around(reach_m, vertices.iter().map(|vertex| vertex.position).enumerate());
    for (number, missing) in lacking {
        let around: Vec<usize> = cubes.near(vertices[number].position).collect();
        let mut whole = Spectrum::ZERO;
        around.iter().for_each(|other| whole += vertices[*other].above() * vertices[*other].area_m2);
        let share = |k: usize| if whole.0[k] > 0.0 { (missing.0[k] / whole.0[k]).min(1.0) } else { 0.0 };
        let shares = Spectrum(std::array::from_fn(share));
        for other in around {
            let vertex = &mut vertices[other];
            vertex.flux += vertex.above() * shares * -1.0;
        }
    }
}

impl BoundedFlux {
    /// Excess of the flux over its least value.
    fn above(&self) -> Spectrum {
        Spectrum(std::array::from_fn(|k| (self.flux.0[k] - self.least.0[k]).max(0.0)))
    }

    /// Deficit of the flux below its least value.
    fn below(&self) -> Spectrum {
        Spectrum(std::array::from_fn(|k| (self.least.0[k] - self.flux.0[k]).max(0.0)))
    }
}

/// Numbered positions, grouped by cubes of a grid.
struct Cubes {
    reach_m: f32,
    of_cube: HashMap<IVec3, Vec<(usize, Vec3)>>,
}

impl Cubes {
    fn around(reach_m: f32, positions: impl Iterator<Item = (usize, Vec3)>) -> Self {
        let mut of_cube: HashMap<IVec3, Vec<(usize, Vec3)>> = HashMap::new();
        for (number, position) in positions {
            of_cube.entry((position / reach_m).floor().as_ivec3()).or_default().push((number, position));
        }
        Self { reach_m, of_cube }
    }

    /// The numbers of positions within the reach of a place, in a fixed order.
    fn near(&self, place: Vec3) -> impl Iterator<Item = usize> {
        let cube = (place / self.reach_m).floor().as_ivec3();
        let step = |k: i32| IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        let numbered = (0..27).filter_map(move |k| self.of_cube.get(&(cube + step(k)))).flatten();
        numbered.filter(move |(_, other)| other.distance(place) <= self.reach_m).map(|(number, _)| *number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of vertices across an edge, the darkest far below its bound. After the limit no vertex is below its
    /// bound, the total flux is conserved, and the vertex out of reach does not change.
    #[test]
    fn fluxes_are_raised_to_their_bounds_and_their_sum_is_kept() {
        let vertex = |k: usize| BoundedFlux {
            position: Vec3::X * (k as f32),
            area_m2: 1.0 + k as f32,
            flux: Spectrum::ONE * [-2.0, -1.2, -0.5, 0.1, 3.0, 0.2][k],
            least: Spectrum::ONE * [-0.8, -0.8, -0.8, 0.0, 0.0, 0.0][k],
        };
        let before: Vec<BoundedFlux> = (0..6).map(vertex).collect();
        let mut after = before.clone();
        limit(&mut after, 3.5);
        let sum = |vertices: &[BoundedFlux]| vertices.iter().map(|one| one.flux.0[3] * one.area_m2).sum::<f32>();
        assert!((sum(&before) - sum(&after)).abs() < 1e-5, "{} {}", sum(&before), sum(&after));
        // Rounding to 24 bits.
        assert!(after.iter().all(|vertex| vertex.flux.0[3] >= vertex.least.0[3] - 1e-6), "{after:?}");
        assert!(after[4].flux.0[3] < before[4].flux.0[3]);
        assert_eq!(after[5].flux.0[3].to_bits(), before[5].flux.0[3].to_bits());
        assert_eq!(within(1.5, &[0], &before.iter().map(|one| one.position).collect::<Vec<_>>()), [0, 1]);
    }
}
