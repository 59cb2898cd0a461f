//! Properties of the path mode `brightest`: continuity of radiance over a block, and energy conservation.

use glam::{DVec3, Vec3A};
use snowblue_render::Integrator;

use crate::snow::{SNOW, analytic_table, computed_table, extinction_per_cm, integrator, pcasnow, radiance};

/// Index of the wavelength.
const BAND: usize = 15;
/// Half the size of the block, in m. Its centre is the origin; its back, which the light faces, is at greatest y.
const HALF_M: Vec3A = Vec3A::new(0.3, 0.15, 0.3);
/// Distance of scan lines from edges and from lit faces, in m. Towards a lit face the depth goes to 0 and changes by
/// more than a few per cent within a step.
const RIM_M: f32 = 2e-4;
const LIT_RIM_M: f32 = 0.02;

/// A block with reflectance 0, lit by a point light.
fn block(lamp: [f32; 3]) -> Integrator {
    let size = 2.0 * HALF_M;
    let text = format!(
        "{}{SNOW}[[object]]\nshape = \"box\"\nsize = [{}, {}, {}]\nmaterial = \"snow\"\n\
         [[light]]\ntype = \"point\"\nposition = {lamp:?}\nradiant_intensity_w_sr = 40\n",
        pcasnow("reflectance = 0"),
        size.x,
        size.y,
        size.z
    );
    integrator(&text, Some(&analytic_table()), &[])
}

/// A line segment on a face, and the face's normal.
struct Scan {
    from: Vec3A,
    to: Vec3A,
    normal: Vec3A,
}

impl Scan {
    fn at(&self, fraction: f32) -> Vec3A {
        self.from.lerp(self.to, fraction)
    }

    fn brightness(&self, integrator: &mut Integrator, fraction: f32) -> f64 {
        let target = self.at(fraction);
        radiance(integrator, target + self.normal + Vec3A::new(0.1, -0.2, 0.15), target).0[BAND].into()
    }

    /// Where radiance is discontinuous, and the ratio across: changes that remain after bisection to the precision of
    /// the coordinates.
    fn steps(&self, integrator: &mut Integrator) -> Vec<(Vec3A, f64)> {
        const PIECES: u16 = 1000;
        let mut found = Vec::new();
        for piece in 0..PIECES {
            let (mut low, mut high) = (f32::from(piece) / f32::from(PIECES), f32::from(piece + 1) / f32::from(PIECES));
            let (mut before, mut after) = (self.brightness(integrator, low), self.brightness(integrator, high));
            assert!(before > 0.0 && after > 0.0, "black at {}", self.at(low));
            while (after / before).ln().abs() > 0.01 && (high - low) > 1e-6 {
                let middle = 0.5 * (low + high);
                let between = self.brightness(integrator, middle);
                if (between / before).ln().abs() > (after / between).ln().abs() {
                    (high, after) = (middle, between);
                } else {
                    (low, before) = (middle, between);
                }
            }
            if (after / before).ln().abs() > 0.01 {
                found.push((self.at(low), after / before));
            }
        }
        found
    }
}

/// A scan over the front from left to right, and its continuation over the right side.
fn around(height_m: f32) -> [Scan; 2] {
    let (right, front) = (HALF_M.x, -HALF_M.y);
    let front = Scan {
        from: Vec3A::new(RIM_M - right, front, height_m),
        to: Vec3A::new(right - RIM_M, front, height_m),
        normal: Vec3A::NEG_Y,
    };
    let side = Scan {
        from: Vec3A::new(right, RIM_M - HALF_M.y, height_m),
        to: Vec3A::new(right, HALF_M.y - LIT_RIM_M, height_m),
        normal: Vec3A::X,
    };
    [front, side]
}

#[test]
fn radiance_is_continuous_across_edges_if_the_light_faces_one_side_only() {
    for lamp in [[0.0, 0.45, -0.1], [0.2, 0.3, 0.2], [-0.25, 2.0, 0.0], [0.1, 20.0, 0.1]] {
        let mut integrator = block(lamp);
        for height_m in [-0.28, -0.1, 0.1, 0.29] {
            let [front, side] = around(height_m);
            for scan in [&front, &side] {
                assert_eq!(scan.steps(&mut integrator), [], "lamp at {lamp:?}");
            }
            // Across the edge, over 0.3 mm.
            let ratio = side.brightness(&mut integrator, 0.0) / front.brightness(&mut integrator, 1.0);
            assert!((0.99..1.01).contains(&ratio), "{ratio} around the edge, lamp at {lamp:?}");
        }
    }
}

#[test]
fn radiance_steps_where_lines_to_the_light_cross_the_edge_between_two_lit_faces() {
    let mut greatest = 1.0f64;
    for lamp in [[0.6, 0.6, 0.0], [0.5, 1.5, 0.1], [0.4, 0.4, -0.2], [0.31, 0.45, 0.0], [0.9, 0.3, 0.1]] {
        let mut integrator = block(lamp);
        let lamp = DVec3::from_array(lamp.map(f64::from));
        let edge = HALF_M.as_dvec3();
        for height_m in [-0.2, 0.0, 0.2] {
            let [mut front, _] = around(height_m);
            front.to.x = HALF_M.x - LIT_RIM_M;
            let steps = front.steps(&mut integrator);
            assert!(steps.len() <= 1, "{steps:?}");
            for (at, ratio) in steps {
                let to_light = lamp - at.as_dvec3();
                let exit = at.as_dvec3() + to_light * ((edge.y - f64::from(at.y)) / to_light.y);
                assert!((exit.x - edge.x).abs() < 1e-5, "{at}: the line leaves at {exit}");
                // Ratio of T cos θ of the two faces at the same depth.
                let depth_cm = 100.0 * exit.distance(at.as_dvec3());
                let passed = |cos: f64| {
                    let angle_deg = cos.acos().to_degrees().min(89.0);
                    cos * (-extinction_per_cm(BAND) * depth_cm * (1.0 + angle_deg / 100.0)).exp()
                };
                let expected =
                    (passed(to_light.x / to_light.length()) / passed(to_light.y / to_light.length())).ln().abs();
                let step = ratio.ln().abs();
                // The step is smaller where the path along the normal replaces the darker one.
                assert!(step < expected + 1e-3, "{at}: a step of {step} for {expected}");
                greatest = greatest.max(step.exp());
            }
        }
    }
    assert!((3.0..4.0).contains(&greatest), "the greatest step is {greatest}");
}

/// Maximum over points of the front and wavelengths of the radiance of a block under a sky of radiance 1.
fn returned(size_m: [f64; 3], path: &str) -> f32 {
    let text = format!(
        "{}{SNOW}[[object]]\nshape = \"box\"\nsize = {size_m:?}\nmaterial = \"snow\"\n\
         [environment]\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n",
        pcasnow(&format!("path = \"{path}\""))
    );
    let mut integrator = integrator(&text, Some(&computed_table()), &[]);
    integrator.set_samples_per_pixel(256);
    let places = (0..64).map(|k| [k % 8, k / 8].map(|step| (step as f32 + 0.5) / 8.0 - 0.5));
    let brightest = places.map(|[across, up]| {
        let target = Vec3A::new(across * size_m[0] as f32, -0.5 * size_m[1] as f32, up * size_m[2] as f32);
        let light = radiance(&mut integrator, target + Vec3A::new(0.1, -2.0, 0.2), target);
        light.0.into_iter().fold(0.0, f32::max)
    });
    brightest.fold(0.0, f32::max)
}

/// Error limit of R + T in a compressed table where ice hardly absorbs, for at least 2 mm of snow.
const TABLE_ROUNDING: f32 = 2e-3;

#[test]
fn blocks_conserve_energy_except_near_edges_with_the_brightest_path() {
    for size_m in [[1.0, 1.0, 1.0], [0.05, 0.05, 0.05], [0.02, 0.5, 0.5], [0.5, 0.002, 0.5]] {
        for path in ["normal", "view"] {
            let most = returned(size_m, path);
            assert!(most < 1.0 + TABLE_ROUNDING, "{path} through {size_m:?} m: {most}");
        }
        // The brighter of two paths exceeds the mean over all paths, near an edge by more than a third.
        let most = returned(size_m, "brightest");
        assert!(most < 1.5, "brightest through {size_m:?} m: {most}");
    }
}
