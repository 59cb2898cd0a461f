//! Laws of diffusion: exact solutions, conservation, and independence of the grid.

use std::slice::from_ref;

use glam::{DMat3, DVec3, EulerRot};
use snowblue_base::narrow;
use snowblue_field::shapes::{Ball, BoxBody};
use snowblue_field::{CellBox, Diffusion, GridOptions, SnowBody, SnowOfCells, SolveOptions, SurfaceElement};
use wide::f32x4;

use crate::surface_flux;

const Q: f64 = 0.714;
const TRANSPORT_LENGTH_M: f32 = 0.002;
/// Blue to deep red in snow of 400 µm and 300 kg/m³.
const ABSORPTION_PER_M: [f32; 4] = [0.0015, 0.02, 0.08, 0.23];

fn snow() -> Diffusion {
    Diffusion { transport_length_m: f32x4::splat(TRANSPORT_LENGTH_M), absorption_per_m: f32x4::from(ABSORPTION_PER_M) }
}

/// The fluence rate in a slab of a thickness whose front is lit with 4 K F = 4, at the front and at the back.
fn slab(absorption_per_m: f64, thickness_m: f64) -> [f64; 2] {
    let length = f64::from(TRANSPORT_LENGTH_M);
    let k = (3.0 * absorption_per_m / length).sqrt();
    let (sinh, cosh) = ((k * thickness_m).sinh(), (k * thickness_m).cosh());
    let reach = Q * length * k;
    // φ = a cosh kz + b sinh kz, with φ − q ℓ* φ′ = 4 at 0 and φ + q ℓ* φ′ = 0 at the back.
    let ratio = -(sinh + reach * cosh) / (cosh + reach * sinh);
    let b = 4.0 / (ratio - reach);
    let a = ratio * b;
    [a, a * cosh + b * sinh]
}

/// Wide slabs with a lit front; the middle is out of reach of the sides.
#[test]
fn slabs_have_the_solution_of_one_dimension() {
    for (thickness_m, step_m) in [(0.01, 0.005), (0.05, 0.02), (0.15, 0.02), (0.3, 0.02)] {
        let width_m = 8.0 * thickness_m;
        let body = BoxBody::aligned(DVec3::ZERO, DVec3::new(width_m, width_m, thickness_m));
        let prepared = SnowBody::uniform(&body, GridOptions { step_m, shift: DVec3::ZERO, sizes: None }, &[snow()], Q);
        // The sides are lit as the slab's own field would be there, so that the slab is as good as infinite: F = 1 on
        // the front, and on the sides no flux, 4 F = φ.
        let light: Vec<f32x4> = prepared
            .surface()
            .iter()
            .map(|element| {
                if element.normal.z < -0.5 {
                    return f32x4::ONE;
                }
                if element.normal.z > 0.5 {
                    return f32x4::ZERO;
                }
                let z = f64::from(element.point.z) + 0.5 * thickness_m;
                f32x4::from(ABSORPTION_PER_M.map(|absorption| narrow(0.25 * within(absorption.into(), thickness_m, z))))
            })
            .collect();
        let fluence = prepared.solve(from_ref(&light), SolveOptions::default());
        for (z, side) in [(-0.5, 0), (0.5, 1)] {
            let found = prepared.fluence(&fluence, DVec3::new(0.0, 0.0, z * thickness_m)).unwrap().next().unwrap();
            for (found, absorption) in found.to_array().into_iter().zip(ABSORPTION_PER_M) {
                let expected = slab(absorption.into(), thickness_m)[side];
                let error = f64::from(found) / expected - 1.0;
                // Fourth order in the size of a cell, 10 ℓ*; single precision; and 1 % through 30 cm, where cells grow.
                let allowed = if thickness_m > 0.2 { 2e-3 } else { 3e-4 };
                assert!(error.abs() < allowed, "{thickness_m} {side} {absorption}: {found} {expected}");
            }
        }
    }
}

/// Layers of different snow, top first: thickness in m, transport mean free path in m and absorption coefficient in
/// 1/m. The first is a crust with soot, thinner than some cells, and all others lie across the faces of the cells.
const LAYERS: [(f64, f32, f32); 4] =
    [(0.007, 0.001, 0.5), (0.022, 0.004, 0.02), (0.009, 0.0015, 0.3), (0.062, 0.003, 0.05)];

/// φ and the flux −ℓ*/3 φ′ at a depth in the layers, lit from above with 4 K F = 4.
///
/// Within a layer φ and the flux turn into those below by a matrix of determinant 1.
fn exact_layers(depth_m: f64) -> [f64; 2] {
    // Those below some snow that begins with the flux `flux`, where φ + 3q flux = 4.
    let below = |flux: f64, depth_m: f64| {
        let (mut at, mut top_m) = ([4.0 - 3.0 * Q * flux, flux], 0.0);
        for (thickness_m, length_m, absorption_per_m) in LAYERS {
            let (length_m, absorption_per_m) = (f64::from(length_m), f64::from(absorption_per_m));
            let k = (3.0 * absorption_per_m / length_m).sqrt();
            let within = k * (depth_m - top_m).clamp(0.0, thickness_m);
            let ([fluence, flux], conductance) = (at, length_m / 3.0 * k);
            at[0] = fluence * within.cosh() - flux * within.sinh() / conductance;
            at[1] = flux * within.cosh() - fluence * conductance * within.sinh();
            top_m += thickness_m;
        }
        at
    };
    // At the bottom φ = 3q flux, which is linear in the flux at the top.
    let miss = |flux: f64| {
        let [fluence, flux] = below(flux, f64::INFINITY);
        fluence - 3.0 * Q * flux
    };
    below(miss(0.0) / (miss(0.0) - miss(1.0)), depth_m)
}

/// The layers in a column whose sides are lit as the light within would be there, so that no light passes them.
#[test]
fn layers_have_the_solution_of_one_dimension_wherever_their_faces_lie_in_the_cells() {
    let thickness_m: f64 = LAYERS.iter().map(|layer| layer.0).sum();
    let shares = |cell: &CellBox| {
        let top_m = 0.5 * thickness_m - cell.centre.z - 0.5 * cell.size.z;
        let (mut depth_m, mut shares) = (0.0_f64, Vec::new());
        for (number, (layer_m, length_m, absorption_per_m)) in LAYERS.into_iter().enumerate() {
            // The first and the last layer go on outside.
            let start = if number == 0 { f64::NEG_INFINITY } else { depth_m };
            depth_m += layer_m;
            let end = if number + 1 == LAYERS.len() { f64::INFINITY } else { depth_m };
            let within_m = end.min(top_m + cell.size.z) - start.max(top_m);
            let snow = Diffusion {
                transport_length_m: f32x4::splat(length_m),
                absorption_per_m: f32x4::splat(absorption_per_m),
            };
            shares.push((narrow(within_m.max(0.0) / cell.size.z), snow));
        }
        vec![Diffusion::mixture(shares)]
    };
    for step_m in [0.002, 0.005, 0.01] {
        let width_m = 6.0 * step_m;
        let body = BoxBody::aligned(DVec3::ZERO, DVec3::new(width_m, width_m, thickness_m));
        let snow = SnowOfCells { groups: 1, of_cell: &shares, extrapolation: Q };
        let prepared = SnowBody::new(&body, GridOptions { step_m, shift: DVec3::ZERO, sizes: None }, &snow);
        let lit = |element: &SurfaceElement| match element.normal.z {
            0.5.. => f32x4::ONE,
            ..-0.5 => f32x4::ZERO,
            _ => {
                let [fluence, _] = exact_layers(0.5 * thickness_m - f64::from(element.point.z));
                f32x4::splat(narrow(0.25 * fluence))
            }
        };
        let light: Vec<f32x4> = prepared.surface().iter().map(lit).collect();
        let flux = surface_flux(&prepared, &prepared.solve(from_ref(&light), SolveOptions::default()), &light);
        for normal in [1.0, -1.0] {
            let point = DVec3::new(0.0, 0.0, normal * 0.5 * thickness_m);
            let [_, expected] = exact_layers(0.5 * thickness_m - point.z);
            let found = prepared.surface_value(&flux, point, DVec3::Z * normal).unwrap().next().unwrap().to_array()[0];
            // The second order of cells of up to 10 ℓ*: measured to 2·10⁻³ of the flux through, and to 10⁻³ at the top,
            // where it is a small difference of the light that enters and leaves.
            let allowed = if normal > 0.0 { 2e-3 } else { 3e-3 * expected };
            assert!((f64::from(found) + normal * expected).abs() < allowed, "{step_m} {normal}: {found} {expected}");
        }
    }
}

/// A wide slab under diffuse light. Its edges are 3.5 thicknesses away, over which light decays by e^{−3.5π}.
#[test]
fn the_absorptance_of_a_slab_is_that_of_its_solution() {
    let snow =
        Diffusion { transport_length_m: f32x4::splat(0.002), absorption_per_m: f32x4::from([0.0, 0.02, 0.3, 3.0]) };
    let body = BoxBody::aligned(DVec3::ZERO, DVec3::new(0.24, 0.24, 0.03));
    let options = GridOptions { step_m: 0.003, shift: DVec3::ZERO, sizes: None };
    let prepared = SnowBody::uniform(&body, options, &[snow], Q);
    let (top, normal) = (DVec3::Z * 0.015, DVec3::Z);
    let lit = |element: &SurfaceElement| if element.normal.z > 0.5 { f32x4::ONE } else { f32x4::ZERO };
    let light: Vec<f32x4> = prepared.surface().iter().map(lit).collect();
    let flux = surface_flux(&prepared, &prepared.solve(from_ref(&light), SolveOptions::default()), &light);
    let flux = prepared.surface_value(&flux, top, normal).unwrap().next().unwrap().to_array();
    let distance = |element: &SurfaceElement| element.point.distance(top.as_vec3());
    let nearest = (0..prepared.surface().len())
        .min_by(|one, other| distance(&prepared.surface()[*one]).total_cmp(&distance(&prepared.surface()[*other])));
    let reflectance = prepared.slab_reflectance()[0][nearest.unwrap()].to_array();
    for (flux, reflectance) in flux.into_iter().zip(reflectance) {
        let absorptance = 1.0 - reflectance;
        assert!((0.0..=1.0).contains(&reflectance));
        // Cells of 1.5 ℓ* have an error of second order.
        assert!((absorptance + flux).abs() < 5e-3 * absorptance, "{absorptance} {flux}");
    }
}

/// A solution that goes on from another until a part of the residual is left is as good as one from nothing.
#[test]
fn solutions_in_steps_come_to_the_same_light() {
    let snow =
        Diffusion { transport_length_m: f32x4::splat(0.002), absorption_per_m: f32x4::from([0.001, 0.02, 0.08, 0.3]) };
    let body = BoxBody::aligned(DVec3::ZERO, DVec3::new(0.1, 0.1, 0.1));
    let options = GridOptions { step_m: 0.005, shift: DVec3::ZERO, sizes: None };
    let prepared = SnowBody::uniform(&body, options, &[snow], Q);
    let lit = |element: &SurfaceElement| if element.normal.z > 0.5 { f32x4::ONE } else { f32x4::ZERO };
    let light: Vec<f32x4> = prepared.surface().iter().map(lit).collect();
    let whole = prepared.solve(from_ref(&light), SolveOptions::default());
    let mut steps = prepared.solve(from_ref(&light), SolveOptions { residual_left: 0.03, ..SolveOptions::default() });
    for _ in 0..4 {
        let options = SolveOptions { start: Some(&steps), residual_left: 0.03, ..SolveOptions::default() };
        steps = prepared.solve(from_ref(&light), options);
    }
    let values = |fluence| prepared.fluence(fluence, DVec3::ZERO).unwrap().next().unwrap().to_array();
    for (whole, steps) in values(&whole).into_iter().zip(values(&steps)) {
        // Both have a relative residual of 10⁻⁶.
        assert!((whole / steps - 1.0).abs() < 1e-4, "{whole} {steps}");
    }
}

/// The fluence rate on the surface of a ball that a distant light shines on with K F = max(cos, 0), by spherical
/// harmonics: φ = Σ a_l P_l(cos), and the surface condition gives a_l (1 + q ℓ* i_l′(κR) κ / i_l(κR)) = g_l.
struct LitBall {
    coefficients: Vec<f64>,
}

impl LitBall {
    fn new(absorption_per_m: f64, radius_m: f64) -> Self {
        const DEGREE: usize = 200;
        let length = f64::from(TRANSPORT_LENGTH_M);
        let kappa = (3.0 * absorption_per_m / length).sqrt();
        let z = kappa * radius_m;
        // i_{l+1}/i_l by backward recurrence.
        let mut ratios = vec![0.0; DEGREE + 60];
        for l in (0..DEGREE + 59).rev() {
            ratios[l] = 1.0 / ((2 * l + 3) as f64 / z + ratios[l + 1]);
        }
        // ∫₀¹ c P_l(c) dc: 1/2, 1/3, 1/8, and by recurrence, with 0 at odd l from 3.
        let mut integrals = vec![0.0; DEGREE];
        integrals[..3].copy_from_slice(&[1.0 / 2.0, 1.0 / 3.0, 1.0 / 8.0]);
        for l in 4..DEGREE {
            integrals[l] = -integrals[l - 2] * (l - 3) as f64 / (l + 2) as f64;
        }
        // g_l is 4 (2l + 1)/2 times the integral.
        let coefficient = |(l, integral): (usize, &f64)| {
            2.0 * (2 * l + 1) as f64 * integral / (1.0 + Q * length * kappa * (l as f64 / z + ratios[l]))
        };
        let coefficients = integrals.iter().enumerate().map(coefficient).collect();
        Self { coefficients }
    }

    fn at(&self, cos: f64) -> f64 {
        let mut sum = 0.0;
        legendre(cos, self.coefficients.len(), &mut |l, value| sum += self.coefficients[l] * value);
        sum
    }
}

fn legendre(x: f64, degree: usize, add: &mut dyn FnMut(usize, f64)) {
    let (mut before, mut here) = (0.0, 1.0);
    for l in 0..degree {
        add(l, here);
        (before, here) = (here, ((2 * l + 1) as f64 * x * here - l as f64 * before) / (l + 1) as f64);
    }
}

/// Means over rings about the axis of the light, and the worst point of each, of the fluence rate that the flux gives.
#[test]
fn balls_have_the_solution_by_spherical_harmonics() {
    let radius_m = 0.05;
    let exact = ABSORPTION_PER_M.map(|absorption| LitBall::new(absorption.into(), radius_m));
    let body = Ball { centre: DVec3::new(0.01, 0.02, -0.03), radius: radius_m };
    let toward = DVec3::new(0.5, 0.85, 0.2).normalize();
    for (step_m, allowed_mean, allowed_worst) in [(0.005, 0.035, 0.08), (0.0025, 0.015, 0.04)] {
        let options = GridOptions { step_m, shift: DVec3::new(0.3, 0.2, 0.4), sizes: None };
        let prepared = SnowBody::uniform(&body, options, &[snow()], Q);
        let lit = |element: &SurfaceElement| f32x4::splat(element.normal.dot(toward.as_vec3()).max(0.0));
        let light: Vec<f32x4> = prepared.surface().iter().map(lit).collect();
        let flux = surface_flux(&prepared, &prepared.solve(from_ref(&light), SolveOptions::default()), &light);
        for cos in [-1.0, -0.6, -0.2, 0.2, 0.6, 1.0_f64] {
            let (mut means, mut worst) = ([0.0; 4], 0.0_f64);
            for k in 0..32 {
                let side = toward.any_orthonormal_vector();
                let aside = (DMat3::from_axis_angle(toward, f64::from(k)) * side).normalize();
                let direction = toward * cos + aside * (1.0 - cos * cos).sqrt();
                let point = body.centre + direction * radius_m;
                let flux = prepared.surface_value(&flux, point, direction).unwrap().next().unwrap().to_array();
                for j in 0..4 {
                    let found = 3.0 * Q * f64::from(flux[j]) + 4.0 * cos.max(0.0);
                    let error = found / exact[j].at(cos) - 1.0;
                    means[j] += error / 32.0;
                    worst = worst.max(error.abs());
                }
            }
            let greatest_mean = means.into_iter().fold(0.0, |worst: f64, mean| worst.max(mean.abs()));
            assert!(greatest_mean < allowed_mean && worst < allowed_worst, "{step_m} {cos}: {means:?} {worst}");
        }
    }
}

/// Without absorption all light that enters a body leaves it again: ∮ J dA = 0, to the tolerance of the solver.
#[test]
fn light_is_conserved_without_absorption() {
    let turned = BoxBody {
        centre: DVec3::ZERO,
        size: DVec3::new(0.06, 0.1, 0.08),
        axes: DMat3::from_euler(EulerRot::XYZ, 0.3, -0.5, 0.8),
    };
    let white = Diffusion { transport_length_m: f32x4::splat(TRANSPORT_LENGTH_M), absorption_per_m: f32x4::ZERO };
    let options = GridOptions { step_m: 0.01, shift: DVec3::ZERO, sizes: None };
    let prepared = SnowBody::uniform(&turned, options, &[white], Q);
    let lit = |element: &SurfaceElement| f32x4::splat(element.normal.z.max(0.0));
    let light: Vec<f32x4> = prepared.surface().iter().map(lit).collect();
    let fluence = prepared.solve(from_ref(&light), SolveOptions::default());
    let flux = prepared.element_flux(&fluence, from_ref(&light));
    let total: f64 =
        flux[0].iter().zip(prepared.surface()).map(|(flux, one)| f64::from(flux.to_array()[0] * one.area_m2)).sum();
    let entered: f64 =
        light.iter().zip(prepared.surface()).map(|(f, one)| f64::from(f.to_array()[0] * one.area_m2)).sum();
    assert!((total / entered).abs() < 1e-4, "{total} {entered}");
}

/// Beside the edge of a lit face the sharpened average of the exitance falls below 0, and light that leaves cannot.
#[test]
fn the_exitance_is_not_negative_beside_a_bright_edge() {
    let size = DVec3::new(0.1, 0.06, 0.08);
    let body = BoxBody::aligned(DVec3::ZERO, size);
    let options = GridOptions { step_m: 0.01, shift: DVec3::ZERO, sizes: None };
    let prepared = SnowBody::uniform(&body, options, &[snow()], Q);
    let lit = |element: &SurfaceElement| f32x4::splat(element.normal.y.max(0.0));
    let light: Vec<f32x4> = prepared.surface().iter().map(lit).collect();
    let fluence = prepared.solve(from_ref(&light), SolveOptions::default());
    let flux = prepared.element_flux(&fluence, from_ref(&light));
    let exitance = vec![flux[0].iter().zip(&light).map(|(flux, light)| *flux + *light).collect::<Vec<_>>()];
    let smooth = [prepared.smooth(&flux), prepared.smooth(&exitance)];
    let limited = prepared.smooth_light(&flux, &exitance);
    // Over the side next to the lit face.
    let (mut is_below, mut is_same) = (false, false);
    let [mut sum, mut sum_of_magnitudes] = [[0.0; 4]; 2];
    for k in 0..1600 {
        let [y, z] = [k % 40, k / 40].map(|number| (f64::from(number) + 0.5) / 40.0 - 0.5);
        let point = DVec3::new(0.5, y, z) * size;
        let at = |values| prepared.surface_value(values, point, DVec3::X).unwrap().next().unwrap().to_array();
        let [[flux, exitance], [flux_limited, exitance_limited]] =
            [&smooth, &limited].map(|[flux, exitance]| [at(flux), at(exitance)]);
        for wavelength in 0..4 {
            assert!(exitance_limited[wavelength] >= 0.0, "{y} {z}: {}", exitance_limited[wavelength]);
            let [added, to_flux] =
                [exitance_limited[wavelength] - exitance[wavelength], flux_limited[wavelength] - flux[wavelength]];
            // Rounding of values of about 1.
            assert!((added - to_flux).abs() < 1e-6, "{y} {z}: {added} {to_flux}");
            is_below |= exitance[wavelength] < 0.0;
            is_same |= exitance[wavelength] > 0.01 && added.abs() < 0.01 * exitance[wavelength];
            sum[wavelength] += added;
            sum_of_magnitudes[wavelength] += added.abs();
        }
    }
    assert!(is_below && is_same);
    for (sum, magnitudes) in sum.into_iter().zip(sum_of_magnitudes) {
        // The points stand for the integral over cells that some five of them share.
        assert!(sum.abs() < 0.1 * magnitudes, "{sum} {magnitudes}");
    }
}

/// Shifts of the grid by parts of a cell do not change the light that leaves the dark side of a block by more than 2 %.
/// Cells of the image at an edge may change by 2 % more for each edge: the coverage of a cell is known to an eighth of
/// it, 0.5 mm, and the light falls to nearly nothing over their 25 mm.
#[test]
fn a_shift_of_the_grid_changes_little() {
    let size = DVec3::new(0.3, 0.1, 0.2);
    let body = BoxBody::aligned(DVec3::ZERO, size);
    let lamp = DVec3::new(0.05, 0.3, 0.02);
    let leaving = |shift: DVec3| -> Vec<f32> {
        let prepared = SnowBody::uniform(&body, GridOptions { step_m: 0.004, shift, sizes: None }, &[snow()], Q);
        let lit = |element: &SurfaceElement| {
            let way = lamp.as_vec3() - element.point;
            f32x4::splat(element.normal.dot(way).max(0.0) / way.length().powi(3))
        };
        let light: Vec<f32x4> = prepared.surface().iter().map(lit).collect();
        let flux = surface_flux(&prepared, &prepared.solve(from_ref(&light), SolveOptions::default()), &light);
        let cell = |column: u32, row: u32| {
            let points = (0..16).map(|k| {
                let [x, z] =
                    [(column, k % 4), (row, k / 4)].map(|(cell, k)| (f64::from(4 * cell + k) + 0.5) / 32.0 - 0.5);
                DVec3::new(x, -0.5, z) * size
            });
            let fluxes =
                points.map(|point| prepared.surface_value(&flux, point, DVec3::NEG_Y).unwrap().next().unwrap());
            fluxes.map(|flux| flux.to_array()).fold([0.0; 4], |sum, flux| std::array::from_fn(|k| sum[k] + flux[k]))
        };
        (0..64).flat_map(|number| cell(number % 8, number / 8)).collect()
    };
    let fitting = leaving(DVec3::ZERO);
    for shift in [DVec3::new(0.3, 0.5, 0.7), DVec3::new(0.9, 0.1, 0.4)] {
        for (index, (shifted, fitting)) in leaving(shift).into_iter().zip(&fitting).enumerate() {
            let place = [index / 4 % 8, index / 32];
            let edges = place.into_iter().filter(|place| [0, 7].contains(place)).count();
            let allowed = 0.02 * (1.0 + edges as f32);
            assert!((shifted / fitting - 1.0).abs() < allowed, "{shift} {place:?}: {shifted} {fitting}");
        }
    }
}

fn within(absorption_per_m: f64, thickness_m: f64, z: f64) -> f64 {
    let length = f64::from(TRANSPORT_LENGTH_M);
    let k = (3.0 * absorption_per_m / length).sqrt();
    let reach = Q * length * k;
    let (sinh, cosh) = ((k * thickness_m).sinh(), (k * thickness_m).cosh());
    let ratio = -(sinh + reach * cosh) / (cosh + reach * sinh);
    let b = 4.0 / (ratio - reach);
    ratio * b * (k * z).cosh() + b * (k * z).sinh()
}
