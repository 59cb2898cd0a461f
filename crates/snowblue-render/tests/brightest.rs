//! What the path `brightest` keeps and what it does not: brightness along lines over a block, and the balance of light.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic, and rays are single")]

mod snow;

use glam::{DVec3, Vec3A};
use snow::{SNOW, extinction_per_cm, real, scene, seen, simple_law};
use snowblue_render::scene::Scene;

/// The wavelength that is looked at.
const BAND: usize = 15;
/// Half the size of the block, whose middle is the origin, in m. Its back, which lamps light, is at greatest y.
const HALF_M: Vec3A = Vec3A::new(0.3, 0.15, 0.3);
/// How near to an edge lines begin and end, and how far from the lit faces, in m: towards those depths go to 0, and a step of
/// the line changes them by more than a few per cent.
const RIM_M: f32 = 2e-4;
const LIT_RIM_M: f32 = 0.02;

/// A block that reflects nothing, before a lamp.
fn block(lamp: [f32; 3]) -> Scene {
    let size = 2.0 * HALF_M;
    let text = format!(
        "{SNOW}reflectance = 0\n[[object]]\nshape = \"box\"\nsize = [{}, {}, {}]\nmaterial = \"snow\"\n\
         [[light]]\ntype = \"point\"\nposition = {lamp:?}\nradiant_intensity_w_sr = 40\n",
        size.x, size.y, size.z
    );
    scene(&text, &simple_law(), &[])
}

/// A straight line on a face, from one point to another, and the face's normal.
struct Scan {
    from: Vec3A,
    to: Vec3A,
    normal: Vec3A,
}

impl Scan {
    fn at(&self, share: f32) -> Vec3A {
        self.from.lerp(self.to, share)
    }

    fn brightness(&self, scene: &mut Scene, share: f32) -> f64 {
        let target = self.at(share);
        seen(scene, target + self.normal + Vec3A::new(0.1, -0.2, 0.15), target).0[BAND].into()
    }

    /// Where brightness steps, and by how much: what stays of a change when the way is halved as long as coordinates allow.
    fn steps(&self, scene: &mut Scene) -> Vec<(Vec3A, f64)> {
        const PIECES: u16 = 1000;
        let mut found = Vec::new();
        for piece in 0..PIECES {
            let (mut low, mut high) = (f32::from(piece) / f32::from(PIECES), f32::from(piece + 1) / f32::from(PIECES));
            let (mut before, mut after) = (self.brightness(scene, low), self.brightness(scene, high));
            assert!(before > 0.0 && after > 0.0, "black at {}", self.at(low));
            while (after / before).ln().abs() > 0.01 && (high - low) > 1e-6 {
                let middle = 0.5 * (low + high);
                let between = self.brightness(scene, middle);
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

/// A line over the front, from left to right, and one on from there over the right side to near the back.
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
fn brightness_is_continuous_across_edges_where_a_lamp_lights_one_face() {
    for lamp in [[0.0, 0.45, -0.1], [0.2, 0.3, 0.2], [-0.25, 2.0, 0.0], [0.1, 20.0, 0.1]] {
        let mut scene = block(lamp);
        for height_m in [-0.28, -0.1, 0.1, 0.29] {
            let [front, side] = around(height_m);
            for scan in [&front, &side] {
                assert_eq!(scan.steps(&mut scene), [], "lamp at {lamp:?}");
            }
            // Around the edge, 0.3 mm farther on.
            let ratio = side.brightness(&mut scene, 0.0) / front.brightness(&mut scene, 1.0);
            assert!((0.99..1.01).contains(&ratio), "{ratio} around the edge, lamp at {lamp:?}");
        }
    }
}

#[test]
fn brightness_steps_where_lines_to_the_lamp_pass_the_edge_between_two_lit_faces() {
    let mut greatest = 1.0f64;
    for lamp in [[0.6, 0.6, 0.0], [0.5, 1.5, 0.1], [0.4, 0.4, -0.2], [0.31, 0.45, 0.0], [0.9, 0.3, 0.1]] {
        let mut scene = block(lamp);
        let lamp = DVec3::from_array(lamp.map(f64::from));
        let edge = HALF_M.as_dvec3();
        for height_m in [-0.2, 0.0, 0.2] {
            let [mut front, _] = around(height_m);
            front.to.x = HALF_M.x - LIT_RIM_M;
            let steps = front.steps(&mut scene);
            assert!(steps.len() <= 1, "{steps:?}");
            for (at, ratio) in steps {
                let way = lamp - at.as_dvec3();
                let exit = at.as_dvec3() + way * ((edge.y - f64::from(at.y)) / way.y);
                assert!((exit.x - edge.x).abs() < 1e-5, "{at}: the line leaves at {exit}");
                // T cos θ of one face over that of the other, with the same depth.
                let depth_cm = 100.0 * exit.distance(at.as_dvec3());
                let passed = |cos: f64| {
                    let angle_deg = cos.acos().to_degrees().min(89.0);
                    cos * (-extinction_per_cm(BAND) * depth_cm * (1.0 + angle_deg / 100.0)).exp()
                };
                let expected = (passed(way.x / way.length()) / passed(way.y / way.length())).ln().abs();
                let step = ratio.ln().abs();
                // Less where the path along the normal stands in for the darker side.
                assert!(step < expected + 1e-3, "{at}: a step of {step} for {expected}");
                greatest = greatest.max(step.exp());
            }
        }
    }
    assert!((3.0..4.0).contains(&greatest), "the greatest step is {greatest}");
}

/// The most that a block of snow returns at a place on its front of what a white sky gives it, at any wavelength.
fn returned(size_m: [f64; 3], path: &str) -> f32 {
    let text = format!(
        "{SNOW}path = \"{path}\"\n[[object]]\nshape = \"box\"\nsize = {size_m:?}\nmaterial = \"snow\"\n\
         [environment]\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n"
    );
    let mut scene = scene(&text, &real(), &[]);
    scene.set_samples_per_pixel(256);
    let places = (0..64).map(|k| [k % 8, k / 8].map(|step| (step as f32 + 0.5) / 8.0 - 0.5));
    let brightest = places.map(|[across, up]| {
        let target = Vec3A::new(across * size_m[0] as f32, -0.5 * size_m[1] as f32, up * size_m[2] as f32);
        let light = seen(&mut scene, target + Vec3A::new(0.1, -2.0, 0.2), target);
        light.0.into_iter().fold(0.0, f32::max)
    });
    brightest.fold(0.0, f32::max)
}

/// What three components and splines add to R + T at most, from 2 mm of snow on, where ice absorbs next to nothing.
const TABLE_ROUNDING: f32 = 2e-3;

#[test]
fn blocks_return_no_more_than_they_get_but_for_what_the_brightest_path_finds_at_edges() {
    for size_m in [[1.0, 1.0, 1.0], [0.05, 0.05, 0.05], [0.02, 0.5, 0.5], [0.5, 0.002, 0.5]] {
        for path in ["normal", "view"] {
            let most = returned(size_m, path);
            assert!(most < 1.0 + TABLE_ROUNDING, "{path} through {size_m:?} m: {most}");
        }
        // The better of two paths for every direction is more than a mean over all paths: beside an edge, by a third and more.
        let most = returned(size_m, "brightest");
        assert!(most < 1.5, "brightest through {size_m:?} m: {most}");
    }
}
