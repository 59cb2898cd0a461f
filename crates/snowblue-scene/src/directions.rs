//! Directions to light above a surface, sampled by a density.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_geometry::ray::SurfacePoint;
use snowblue_transport::ordinates::HalfSpace;

use crate::sampling::{cosine_direction, cumulative, invert, share, uniform_hemisphere_direction};

/// Bins of a [`ReflectionTable`]: steps of the square root of the cosine of exit, of the square root of the cosine of
/// incidence, and of the sine of half the azimuth. The azimuth is 0 for light that goes on away from its source.
const EXITS: usize = 24;
const INCIDENCES: usize = 32;
const AZIMUTHS: usize = 16;
/// Least cosine of exit. Where both directions are grazing, the reflection has a limit.
const MIN_COSINE: f64 = 1e-3;

/// A density of directions above a surface.
#[derive(Debug, Clone, Copy)]
pub enum Directions<'a> {
    /// Proportional to the cosine with the normal, p = cos θ / π.
    Cosine(SurfacePoint),
    /// Uniform in the hemisphere, p = 1 / 2π.
    Hemisphere(SurfacePoint),
    /// About proportional to the reflection of deep snow.
    Reflected(Reflected<'a>),
}

/// The reflection R₀ μ₀ of deep snow, over all directions of incidence, for some directions of exit. The density is
/// constant over each bin of angles.
#[derive(Debug)]
pub(crate) struct ReflectionTable(Vec<Bins>);

/// The bins of a direction of exit: cumulative shares of the rows of equal incidence, and of the azimuths in each
/// row.
#[derive(Debug)]
struct Bins {
    rows: Vec<f32>,
    columns: Vec<f32>,
}

/// Directions from which deep snow reflects light to a viewer.
#[derive(Debug, Clone, Copy)]
pub struct Reflected<'a> {
    surface: SurfacePoint,
    /// Unit vectors in the surface, along and across the direction in which light goes to the viewer.
    axes: [Vec3A; 2],
    bins: &'a Bins,
}

impl Directions<'_> {
    /// The point of the surface, in m.
    pub(crate) fn point(&self) -> Vec3A {
        self.surface().point
    }

    /// The point of the surface, with its normal.
    pub fn surface(&self) -> &SurfacePoint {
        match self {
            Self::Cosine(surface) | Self::Hemisphere(surface) | Self::Reflected(Reflected { surface, .. }) => surface,
        }
    }

    /// A unit direction drawn from the density, from two numbers in [0, 1).
    #[inline]
    pub fn sample(&self, [u, v]: [f32; 2]) -> Vec3A {
        match self {
            Self::Cosine(surface) => cosine_direction(surface.normal, u, v),
            Self::Hemisphere(surface) => uniform_hemisphere_direction(surface.normal, u, v),
            Self::Reflected(reflected) => reflected.sample([u, v]),
        }
    }

    /// The density, in 1/sr.
    #[inline]
    pub fn density_per_sr(&self, direction: Vec3A) -> f32 {
        let cos = self.surface().normal.dot(direction);
        match self {
            Self::Cosine(_) => cos.max(0.0) * FRAC_1_PI,
            Self::Hemisphere(_) => {
                if cos > 0.0 {
                    0.5 * FRAC_1_PI
                } else {
                    0.0
                }
            }
            Self::Reflected(reflected) => reflected.density_per_sr(direction),
        }
    }

    /// A direction drawn from the density p, and the weight cos θ / (π p).
    #[inline]
    pub fn sample_weighted(&self, numbers: [f32; 2]) -> (Vec3A, f32) {
        let direction = self.sample(numbers);
        match self {
            Self::Cosine(_) => (direction, 1.0),
            Self::Hemisphere(_) | Self::Reflected(_) => {
                // Because of rounding, a grazing direction may lie below the surface, where the density is 0.
                let cos = self.surface().normal.dot(direction);
                let factor = if cos > 0.0 { cos * FRAC_1_PI / self.density_per_sr(direction) } else { 0.0 };
                (direction, factor)
            }
        }
    }
}

impl ReflectionTable {
    /// The table of a half-space.
    #[must_use]
    pub(crate) fn new(half_space: &HalfSpace) -> Self {
        let square = |place: f64, count: usize| (place / count as f64).powi(2);
        let of_exit = |exit: usize| {
            let cos_exit = square(exit as f64, EXITS).max(MIN_COSINE);
            let (mut row_weights, mut columns) = (Vec::with_capacity(INCIDENCES), Vec::new());
            for row in 0..INCIDENCES {
                let cos_incidence = square(row as f64 + 0.5, INCIDENCES);
                let weights = (0..AZIMUTHS).map(|column| {
                    let half_sine_squared = square(column as f64 + 0.5, AZIMUTHS);
                    let reflection = half_space.reflection(cos_exit, cos_incidence, 1.0 - 2.0 * half_sine_squared);
                    // Above zero, so that every direction can be drawn.
                    narrow(reflection.max(1e-4)) * step_of_azimuth(column)
                });
                let (total, shares) = cumulative(weights);
                columns.extend(shares);
                let [low, high] = edge_cosines(row);
                row_weights.push(narrow(total * cos_incidence) * (high - low));
            }
            let (_, rows) = cumulative(row_weights.into_iter());
            Bins { rows, columns }
        };
        Self((0..=EXITS).map(of_exit).collect())
    }

    /// The directions from which a surface reflects light against the unit vector `direction` of a ray from the
    /// camera.
    #[inline]
    #[must_use]
    pub(crate) fn at(&self, surface: SurfacePoint, direction: Vec3A) -> Reflected<'_> {
        let cos_exit = -surface.normal.dot(direction);
        let along = -direction - surface.normal * cos_exit;
        let along = along.try_normalize().unwrap_or_else(|| surface.normal.any_orthonormal_vector());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number from 0 to EXITS")]
        let exit = (cos_exit.clamp(0.0, 1.0).sqrt() * EXITS as f32).round() as usize;
        Reflected { surface, axes: [along, surface.normal.cross(along)], bins: &self.0[exit] }
    }
}

impl Reflected<'_> {
    fn sample(&self, [u, v]: [f32; 2]) -> Vec3A {
        let (row, down) = invert(&self.bins.rows, v);
        // Half of the numbers belong to each side.
        let (column, across) = invert(self.columns(row), (2.0 * u - 1.0).abs());
        let [low, high] = edge_cosines(row);
        let cos = low + (high - low) * down;
        let [start, end] = edge_azimuths(column);
        let azimuth = (start + (end - start) * across).copysign(u - 0.5);
        let (sine, cosine) = azimuth.sin_cos();
        // Light that goes on with azimuth 0 comes from the side opposite to the viewer.
        let sideways = -(self.axes[0] * cosine + self.axes[1] * sine);
        (sideways * (1.0 - cos * cos).max(0.0).sqrt() + self.surface.normal * cos).normalize()
    }

    fn density_per_sr(&self, direction: Vec3A) -> f32 {
        let cos = self.surface.normal.dot(direction);
        if cos <= 0.0 {
            return 0.0;
        }
        let [along, across] = self.axes.map(|axis| -axis.dot(direction));
        let half_sine = (0.5 - 0.5 * along / along.hypot(across).max(f32::MIN_POSITIVE)).max(0.0).sqrt();
        let (row, column) = (bin(cos.sqrt(), INCIDENCES), bin(half_sine, AZIMUTHS));
        let ([low, high], [start, end]) = (edge_cosines(row), edge_azimuths(column));
        share(&self.bins.rows, row) * share(self.columns(row), column) / (2.0 * (high - low) * (end - start))
    }

    /// Cumulative shares of the azimuths in a row.
    fn columns(&self, row: usize) -> &[f32] {
        &self.bins.columns[row * AZIMUTHS..][..AZIMUTHS]
    }
}

/// Cosines of incidence at the edges of a row.
fn edge_cosines(row: usize) -> [f32; 2] {
    [row, row + 1].map(|edge| (edge as f32 / INCIDENCES as f32).powi(2))
}

/// Azimuths at the edges of a column, in rad.
fn edge_azimuths(column: usize) -> [f32; 2] {
    [column, column + 1].map(|edge| if edge == AZIMUTHS { PI } else { 2.0 * (edge as f32 / AZIMUTHS as f32).asin() })
}

/// The width of a column, in rad.
fn step_of_azimuth(column: usize) -> f32 {
    let [start, end] = edge_azimuths(column);
    end - start
}

/// The bin of a number from 0 to 1 among `count`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number from 0 to 1")]
fn bin(place: f32, count: usize) -> usize {
    ((place * count as f32) as usize).min(count - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::surface_optics::reflection_per_sr;
    use crate::sampling::Sampler;
    use snowblue_transport::PhaseFunction;

    /// Snow without absorption reflects all light: the mean of R₀ μ₀ / p is 1 for every direction of exit. The
    /// remaining standard deviation comes from the finite size of the bins.
    #[test]
    fn reflected_directions_have_the_density_of_what_is_reflected() {
        let half_space = HalfSpace::new(&PhaseFunction::henyey_greenstein(0.8));
        let table = ReflectionTable::new(&half_space);
        let normal = Vec3A::new(0.48, 0.6, 0.64);
        let side = normal.any_orthonormal_vector();
        let mut deviations = Vec::new();
        for cos_exit in [0.03_f32, 0.1, 0.31, 0.7, 1.0] {
            let to_viewer = normal * cos_exit + side * (1.0 - cos_exit * cos_exit).sqrt();
            let surface = SurfacePoint { point: Vec3A::ONE, normal };
            let ways = [Directions::Reflected(table.at(surface, -to_viewer)), Directions::Cosine(surface)];
            let of_way = ways.map(|directions| {
                let (mut sum, mut squares) = (0.0, 0.0);
                for sample in 0..1 << 14 {
                    let [u, v, ..] = Sampler::new(1, 7, sample).next_four();
                    let (direction, factor) = directions.sample_weighted([u, v]);
                    assert!((direction.length() - 1.0).abs() < 1e-5 && normal.dot(direction) >= 0.0);
                    let value = f64::from(PI * factor * reflection_per_sr(&half_space, normal, -to_viewer, direction));
                    sum += value / 16384.0;
                    squares += value * value / 16384.0;
                }
                (sum, (squares - sum * sum).sqrt())
            });
            let (mean, deviation) = of_way[0];
            // Scrambled points of a Sobol set are better than random points, whose standard error is 0.8 % of the
            // deviation.
            assert!((mean - 1.0).abs() < 5e-3, "{cos_exit}: {mean}");
            deviations.push((cos_exit, deviation, of_way[1].1));
        }
        for (cos_exit, by_table, by_cosine) in &deviations {
            assert!(*by_table < 0.35 && by_table < by_cosine, "{cos_exit}: {deviations:?}");
        }
    }

    /// Directions of a tilted surface have finite factors, also at the ends of the range of numbers.
    #[test]
    fn grazing_directions_have_finite_factors() {
        let table = ReflectionTable::new(&HalfSpace::new(&PhaseFunction::henyey_greenstein(0.8)));
        let least = f32::EPSILON / 2.0;
        for k in 0..1000 {
            let turn = k as f32;
            let normal = Vec3A::new(turn.cos(), turn.sin(), 0.3 * (turn * 0.7).sin()).normalize();
            let to_viewer = (normal * 0.02 + normal.any_orthonormal_vector()).normalize();
            let directions = Directions::Reflected(table.at(SurfacePoint { point: Vec3A::ZERO, normal }, -to_viewer));
            for (u, v) in [(0.0, 0.0), (0.5, 0.0), (1.0 - least, 0.0), (0.3, least), (0.7, 1.0 - least)] {
                let (direction, factor) = directions.sample_weighted([u, v]);
                assert!(factor.is_finite() && factor >= 0.0 && direction.is_finite(), "{normal} {u} {v}: {factor}");
            }
        }
    }

    #[test]
    fn densities_add_up_to_one() {
        let half_space = HalfSpace::new(&PhaseFunction::henyey_greenstein(0.8));
        let table = ReflectionTable::new(&half_space);
        let surface = SurfacePoint { point: Vec3A::ZERO, normal: Vec3A::Y };
        let directions = Directions::Reflected(table.at(surface, Vec3A::new(0.9, -0.4, 0.1).normalize()));
        // The density is 0 below the surface. The density of uniform directions above the surface is 1 / 2π.
        let mean: f64 = (0..1 << 16)
            .map(|sample| {
                let [u, v, ..] = Sampler::new(1, 9, sample).next_four();
                f64::from(directions.density_per_sr(uniform_hemisphere_direction(Vec3A::Y, u, v)))
            })
            .sum::<f64>()
            / 65536.0;
        assert!((mean * std::f64::consts::TAU - 1.0).abs() < 5e-3, "{mean}");
        assert!(directions.density_per_sr(Vec3A::NEG_Y) <= 0.0);
    }
}
