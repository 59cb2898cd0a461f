//! Cells of different sizes at the surface: exact solutions, conservation, and agreement with a fine grid.

use std::slice::from_ref;

use glam::{DMat3, DVec3, EulerRot};
use snowblue_base::narrow;
use snowblue_field::shapes::{BoxBody, BoxWithHole};
use snowblue_field::{
    Body, CellSizes, Diffusion, GridOptions, SizeLimits, SizesByDistance, SnowBody, SolveOptions, SurfaceElement,
};
use wide::f32x4;

use crate::surface_flux;

const Q: f64 = 0.714;
const TRANSPORT_LENGTH_M: f64 = 0.002;
/// Blue to deep red in snow of 400 µm and 300 kg/m³.
const ABSORPTION_PER_M: [f64; 4] = [0.0015, 0.02, 0.08, 0.23];

fn snow() -> Diffusion {
    Diffusion {
        transport_length_m: f32x4::splat(narrow(TRANSPORT_LENGTH_M)),
        absorption_per_m: f32x4::from(ABSORPTION_PER_M.map(narrow)),
    }
}

/// The same sizes everywhere.
#[derive(Debug)]
struct EvenSizes(SizeLimits);

impl CellSizes for EvenSizes {
    fn least_between(&self, _: DVec3, _: DVec3) -> SizeLimits {
        self.0
    }

    fn thin_below_m(&self) -> f64 {
        0.1
    }
}

/// The fluence rate at a depth in a slab of a thickness whose front is lit with 4 K F = 4.
fn slab(absorption_per_m: f64, thickness_m: f64, depth_m: f64) -> f64 {
    let k = (3.0 * absorption_per_m / TRANSPORT_LENGTH_M).sqrt();
    let reach = Q * TRANSPORT_LENGTH_M * k;
    let (sinh, cosh) = ((k * thickness_m).sinh(), (k * thickness_m).cosh());
    // φ = a cosh kz + b sinh kz, with φ − q ℓ* φ′ = 4 at 0 and φ + q ℓ* φ′ = 0 at the back.
    let ratio = -(sinh + reach * cosh) / (cosh + reach * sinh);
    let b = 4.0 / (ratio - reach);
    ratio * b * (k * depth_m).cosh() + b * (k * depth_m).sinh()
}

fn values(groups: Option<impl Iterator<Item = f32x4>>) -> [f64; 4] {
    groups.unwrap().next().unwrap().to_array().map(f64::from)
}

fn downward_light(body: &SnowBody) -> Vec<f32x4> {
    body.surface().iter().map(|element| f32x4::splat(element.normal.z.max(0.0))).collect()
}

/// A wide slab whose cells are 30 ℓ* wide, in any direction to the grid; the middle is out of reach of the sides.
///
/// The elements' rule has a relative error of (κh)⁴/180 in the flux of a surface on nodes, and up to (κh)²/12 where the
/// surface cuts cells anywhere, since it is right for surfaces on nodes. Light decays by e^{−κh} in a cell, so that the
/// mean of straight lines between nodes is too large by (κh)²/12 as well. κh of a slanted cell is up to √3 larger: the
/// errors of the mean are within (κh)²/8, h the width of a cell, and where light decays within a cell the flux is that
/// of a half-space.
#[test]
fn flat_slabs_of_coarse_cells_have_the_solution_of_one_dimension() {
    let (thickness_m, size_m) = (0.3, 0.06);
    for angle in [0.0, 0.3, 0.6] {
        let axes = DMat3::from_euler(EulerRot::XYZ, angle, 0.5 * angle, 0.2 * angle);
        let width_m = 8.0 * thickness_m;
        let body = BoxBody { centre: DVec3::ZERO, size: DVec3::new(width_m, width_m, thickness_m), axes };
        let sizes = EvenSizes(SizeLimits { flat_m: 1.01 * size_m, detailed_m: 0.51 * size_m, thin_m: 0.51 * size_m });
        let options = GridOptions { step_m: 0.5 * size_m, shift: DVec3::new(0.3, 0.2, 0.4), sizes: Some(&sizes) };
        let prepared = SnowBody::uniform(&body, options, &[snow()], Q);
        let lit = |element: &SurfaceElement| {
            let rise = f64::from(element.normal.dot(axes.z_axis.as_vec3()));
            // The sides are lit as the slab's own field would be there, so that the slab is as good as infinite.
            let depth_m = 0.5 * thickness_m - element.point.as_dvec3().dot(axes.z_axis);
            match rise {
                0.5.. => f32x4::ONE,
                ..-0.5 => f32x4::ZERO,
                _ => f32x4::from(ABSORPTION_PER_M.map(|one| narrow(0.25 * slab(one, thickness_m, depth_m)))),
            }
        };
        let light: Vec<f32x4> = prepared.surface().iter().map(lit).collect();
        let fluence = prepared.solve(from_ref(&light), SolveOptions::default());
        let flux = surface_flux(&prepared, &fluence, &light);
        let [mut front, mut middle, mut back] = [[0.0; 4]; 3];
        for k in 0..256 {
            let place = DVec3::new(f64::from(k % 16) - 7.5, f64::from(k / 16) - 7.5, 0.0) * (0.025 * width_m);
            let at = |depth_m: f64| axes * (place + DVec3::Z * (0.5 * thickness_m - depth_m));
            let found = [
                values(prepared.surface_value(&flux, at(0.0), axes.z_axis)),
                values(prepared.fluence(&fluence, at(0.5 * thickness_m))),
                values(prepared.surface_value(&flux, at(thickness_m), -axes.z_axis)),
            ];
            for (sum, found) in [&mut front, &mut middle, &mut back].into_iter().zip(found) {
                (0..4).for_each(|j| sum[j] += found[j] / 256.0);
            }
        }
        let width_m = size_m * axes.z_axis.abs().element_sum();
        for (j, absorption) in ABSORPTION_PER_M.into_iter().enumerate() {
            let exact = |depth_m: f64| slab(absorption, thickness_m, depth_m);
            let decay = (3.0 * absorption / TRANSPORT_LENGTH_M).sqrt();
            let allowed = 0.01 + (decay * width_m).powi(2) / 12.0;
            let expected = [(exact(0.0) - 4.0) / (3.0 * Q), exact(0.5 * thickness_m), exact(thickness_m) / (3.0 * Q)];
            for (found, expected) in [front[j], middle[j], back[j]].into_iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < allowed, "{angle} {absorption}: {found} {expected}");
            }
        }
    }
}

/// In cells many times wider than light decays in, the flux into a thick slab that is lit evenly is a half-space's.
#[test]
fn cells_wider_than_light_reaches_have_the_flux_of_a_half_space() {
    let axes = DMat3::from_euler(EulerRot::XYZ, 0.3, 0.15, 0.06);
    let body = BoxBody { centre: DVec3::ZERO, size: DVec3::new(6.0, 6.0, 1.0), axes };
    let sizes = EvenSizes(SizeLimits { flat_m: 0.41, detailed_m: 0.21, thin_m: 0.21 });
    let options = GridOptions { step_m: 0.2, shift: DVec3::ZERO, sizes: Some(&sizes) };
    let red = Diffusion { absorption_per_m: f32x4::splat(0.23), ..snow() };
    let prepared = SnowBody::uniform(&body, options, &[red], Q);
    let up = axes.z_axis.as_vec3();
    let light: Vec<f32x4> =
        prepared.surface().iter().map(|element| f32x4::splat(element.normal.dot(up).max(0.0))).collect();
    let flux = surface_flux(&prepared, &prepared.solve(from_ref(&light), SolveOptions::default()), &light);
    let slope = (3.0 * 0.23 * TRANSPORT_LENGTH_M).sqrt();
    let expected = -4.0 / 3.0 * slope / (1.0 + Q * slope);
    for k in 0..64 {
        let place = DVec3::new(f64::from(k % 8) - 3.5, f64::from(k / 8) - 3.5, 0.0) * 0.4 + DVec3::Z * 0.5;
        let found = values(prepared.surface_value(&flux, axes * place, axes.z_axis))[0];
        // The grid's error at single elements is more than a half-space allows for. It is half of the flux in the mean.
        assert!((found / expected - 1.0).abs() < 0.005, "{k}: {found} {expected}");
    }
}

/// Lines miss the surface in cells into which the slab reaches by little. These cells have no surface elements.
#[test]
fn every_place_on_a_slab_has_the_thickness_of_the_slab() {
    let thickness_m = 0.3;
    let axes = DMat3::from_euler(EulerRot::XYZ, 0.6, 0.3, 0.12);
    let body = BoxBody { centre: DVec3::ZERO, size: DVec3::new(2.4, 2.4, thickness_m), axes };
    let sizes = EvenSizes(SizeLimits { flat_m: 0.061, detailed_m: 0.031, thin_m: 0.031 });
    let options = GridOptions { step_m: 0.03, shift: DVec3::new(0.3, 0.2, 0.4), sizes: Some(&sizes) };
    let prepared = SnowBody::uniform(&body, options, &[snow()], Q);
    for k in 0..65_536 {
        let place = DVec3::new(f64::from(k % 256) - 127.5, f64::from(k / 256) - 127.5, 0.0) / 256.0;
        let place = axes * (place + 0.5 * thickness_m * DVec3::Z);
        let [_, found_m] = prepared.size_and_thickness_m(&prepared.surface_place(place, axes.z_axis).unwrap());
        // Along an axis the slab may end at its sides.
        assert!((0.5..1.001).contains(&(f64::from(found_m) / thickness_m)), "{k}: {found_m} m");
    }
}

/// The flux by two lights together is the sum of those by each, also in cells in which light decays. The solution for
/// light that goes back and forth in a cavity requires it.
#[test]
fn the_flux_is_linear_in_the_light() {
    let body = BoxBody::aligned(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.5));
    let options = GridOptions { step_m: 0.1, shift: DVec3::splat(0.3), sizes: None };
    let prepared = SnowBody::uniform(&body, options, &[snow()], Q);
    let one: Vec<f32x4> = prepared.surface().iter().map(|element| f32x4::splat(element.point.x + 0.5)).collect();
    let other: Vec<f32x4> = prepared.surface().iter().map(|element| f32x4::splat(-element.normal.z)).collect();
    let both: Vec<f32x4> = one.iter().zip(&other).map(|(one, other)| *one + *other).collect();
    let [one, other, both] = [one, other, both].map(|light| {
        let options = SolveOptions { tolerance: 1e-7, ..SolveOptions::default() };
        prepared.element_flux(&prepared.solve(from_ref(&light), options), from_ref(&light)).swap_remove(0)
    });
    for (element, ((one, other), both)) in prepared.surface().iter().zip(one.into_iter().zip(other).zip(both)) {
        for (difference, scale) in (one + other - both).to_array().into_iter().zip(both.abs().to_array()) {
            // The fluence rate is some 4 in single precision, and the residual is 1e-7 of the light.
            assert!(difference.abs() < 1e-5 * scale.max(1.0), "{:?}: {difference} of {scale}", element.point);
        }
    }
}

/// A slab with a hole, seen from above the hole, beside one of fine cells everywhere.
///
/// Cells within 4 cm of an edge of the hole have the same size in both. Farther off they grow to a quarter of their
/// distance d to it. Light from there has decayed by e^{−κd}, and has the error of cells of a width h = d/4, (κh)²/12:
/// together at most (2/e)²/192 < 0.3 %, for light from the sides and from below.
#[test]
fn a_hole_in_a_slab_has_the_light_of_a_fine_grid() {
    let body = BoxWithHole {
        outer: BoxBody::aligned(DVec3::ZERO, DVec3::new(1.6, 1.6, 0.4)),
        hole_centre: DVec3::Z * 0.2,
        hole_size: DVec3::new(0.1, 0.1, 0.2),
    };
    let sizes = SizesByDistance {
        viewpoint: DVec3::Z * 0.4,
        sizes_per_distance: [0.03, 0.03, 0.15],
        thin_below_m: 0.1,
        greatest_m: 0.11,
    };
    let step_m = 0.0125;
    let [fine, seen] = [None, Some(&sizes as &dyn CellSizes)].map(|sizes| {
        let options = GridOptions { step_m, shift: DVec3::ZERO, sizes };
        let prepared = SnowBody::uniform(&body, options, &[snow()], Q);
        let light = downward_light(&prepared);
        let fluence = prepared.solve(from_ref(&light), SolveOptions::default());
        let flux = surface_flux(&prepared, &fluence, &light);
        (prepared, fluence, flux)
    });
    assert!(3 * seen.0.node_count() < fine.0.node_count(), "{} {}", seen.0.node_count(), fine.0.node_count());
    let compare = |found: [f64; 4], expected: [f64; 4], place: DVec3| {
        for j in 0..4 {
            assert!((found[j] / expected[j] - 1.0).abs() < 0.01, "{place} {j}: {found:?} {expected:?}");
        }
    };
    for k in 0..9 {
        let place = DVec3::new(f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0) * 0.03;
        let [bottom, below] = [0.1, 0.02].map(|height| place + DVec3::Z * height);
        let [seen_flux, fine_flux] =
            [&seen, &fine].map(|(body, _, flux)| values(body.surface_value(flux, bottom, DVec3::Z)));
        compare(seen_flux, fine_flux, bottom);
        let wall = DVec3::new(0.05, place.x, 0.15 + place.y);
        let [seen_flux, fine_flux] =
            [&seen, &fine].map(|(body, _, flux)| values(body.surface_value(flux, wall, DVec3::NEG_X)));
        compare(seen_flux, fine_flux, wall);
        let [seen_fluence, fine_fluence] =
            [&seen, &fine].map(|(body, fluence, _)| values(body.fluence(fluence, below)));
        compare(seen_fluence, fine_fluence, below);
    }
}

/// What enters and does not leave is absorbed, with cells of many sizes.
#[test]
fn light_is_conserved_where_cells_change_their_size() {
    let body = BoxWithHole {
        outer: BoxBody {
            centre: DVec3::ZERO,
            size: DVec3::new(1.5, 1.2, 0.4),
            axes: DMat3::from_euler(EulerRot::XYZ, 0.3, -0.2, 0.8),
        },
        hole_centre: DVec3::new(0.0, 0.0, 0.2),
        hole_size: DVec3::new(0.1, 0.1, 0.2),
    };
    let sizes = SizesByDistance {
        viewpoint: DVec3::Z * 0.4,
        sizes_per_distance: [0.05, 0.05, 0.2],
        thin_below_m: 0.1,
        greatest_m: 0.2,
    };
    for absorption in [0.0, 0.0015] {
        let nearly_white = Diffusion {
            transport_length_m: f32x4::splat(narrow(TRANSPORT_LENGTH_M)),
            absorption_per_m: f32x4::splat(narrow(absorption)),
        };
        let options = GridOptions { step_m: 0.015, shift: DVec3::ZERO, sizes: Some(&sizes) };
        let prepared = SnowBody::uniform(&body, options, &[nearly_white], Q);
        let light = downward_light(&prepared);
        let fluence = prepared.solve(from_ref(&light), SolveOptions::default());
        let flux = prepared.element_flux(&fluence, from_ref(&light));
        let over_surface = |values: &[f32x4]| -> f64 {
            let terms = values.iter().zip(prepared.surface());
            terms.map(|(value, element)| f64::from(value.to_array()[0] * element.area_m2)).sum()
        };
        let (leaving, entering) = (over_surface(&flux[0]), over_surface(&light));
        // The sum of the fluence rate over points 1 cm apart, inside by the crossings of lines along z.
        let (mut absorbed, mut crossings) = (0.0, Vec::new());
        let [low, high] = body.bounds();
        let counts = ((high - low) / 0.01).ceil().as_u64vec3();
        for column in 0..counts.x * counts.y {
            let at = low + DVec3::new((column % counts.x) as f64, (column / counts.x) as f64, 0.0) * 0.01;
            crossings.clear();
            body.crossings(2, at, &mut crossings);
            let mut heights: Vec<f64> = crossings.iter().map(|crossing| crossing.coordinate_m).collect();
            heights.sort_by(f64::total_cmp);
            for ends in heights.as_chunks::<2>().0 {
                for k in 0..40 {
                    let height = ends[0] + (ends[1] - ends[0]) * (f64::from(k) + 0.5) / 40.0;
                    let point = at.truncate().extend(height);
                    // There may be no cell at an edge.
                    let found = prepared.fluence(&fluence, point).map_or(0.0, |found| values(Some(found))[0]);
                    absorbed += absorption * found * 1e-4 * (ends[1] - ends[0]) / 40.0;
                }
            }
        }
        // The tolerance of the solver, and the sum over points, by which light at the surface changes by 5 % a cell.
        assert!((leaving + absorbed).abs() < 1e-4 * entering + 0.02 * absorbed, "{leaving} {absorbed} {entering}");
    }
}

/// The flux at the surface has no jump where cells change their size.
#[test]
fn the_flux_is_continuous_where_cells_change_their_size() {
    let body = BoxBody::aligned(DVec3::ZERO, DVec3::new(1.6, 1.6, 0.4));
    let sizes = SizesByDistance {
        viewpoint: DVec3::Z * 0.3,
        sizes_per_distance: [0.05, 0.05, 0.2],
        thin_below_m: 0.1,
        greatest_m: 0.2,
    };
    let options = GridOptions { step_m: 0.02, shift: DVec3::ZERO, sizes: Some(&sizes) };
    let prepared = SnowBody::uniform(&body, options, &[snow()], Q);
    let lamp = DVec3::new(0.2, 0.1, 0.5).as_vec3();
    let lit = |element: &SurfaceElement| {
        let way = lamp - element.point;
        f32x4::splat(element.normal.dot(way).max(0.0) / way.length().powi(3))
    };
    let light: Vec<f32x4> = prepared.surface().iter().map(lit).collect();
    let flux = surface_flux(&prepared, &prepared.solve(from_ref(&light), SolveOptions::default()), &light);
    let steps = 20_000;
    let mut before: Option<[f64; 4]> = None;
    for k in 0..steps {
        let point = DVec3::new(1.4 * (f64::from(k) / f64::from(steps) - 0.5), 0.0137, 0.2);
        let flux = values(prepared.surface_value(&flux, point, DVec3::Z));
        if let Some(before) = before {
            // The smallest cells are 290 steps wide, and means at nodes differ by up to a factor of three.
            assert!((flux[0] - before[0]).abs() < 0.01 * before[0].abs(), "{point}: {flux:?} {before:?}");
        }
        before = Some(flux);
    }
}

/// A slope of 100 m with a hole of 10 cm, seen from 1 m, has a grid of few nodes that resolves the hole.
#[test]
fn a_landscape_with_a_hole_has_few_nodes() {
    let axes = DMat3::from_rotation_y(20_f64.to_radians());
    let top = axes * DVec3::new(0.0, 0.0, 0.5);
    let slope = BoxWithHole {
        outer: BoxBody { centre: DVec3::ZERO, size: DVec3::new(100.0, 100.0, 1.0), axes },
        hole_centre: top,
        hole_size: DVec3::new(0.1, 0.1, 0.2),
    };
    let sizes = SizesByDistance {
        viewpoint: top + axes.z_axis,
        sizes_per_distance: [0.02, 0.02, 0.1],
        thin_below_m: 0.1,
        greatest_m: 1.0,
    };
    let options = GridOptions { step_m: 0.0078, shift: DVec3::ZERO, sizes: Some(&sizes) };
    let prepared = SnowBody::uniform(&slope, options, &[], Q);
    assert!(prepared.node_count() < 250_000, "{}", prepared.node_count());
    let area = |holds: &dyn Fn(DVec3) -> bool| -> f64 {
        let elements = prepared.surface().iter().filter(|element| holds(axes.transpose() * element.point.as_dvec3()));
        elements.map(|element| f64::from(element.area_m2)).sum()
    };
    // Four walls and the bottom. The coverage of a cell is known to an eighth of it.
    let of_hole = area(&|point| point.truncate().abs().max_element() < 0.055 && point.z > 0.35 && point.z < 0.495);
    assert!((of_hole / 0.05 - 1.0).abs() < 0.1, "{of_hole}");
    let all = area(&|_| true);
    assert!((all / (2e4 + 400.0 + 0.04) - 1.0).abs() < 0.01, "{all}");
}
