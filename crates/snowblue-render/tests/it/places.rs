//! Snow looks alike wherever it lies: far from the origin of coordinates, and on surfaces of kilometres.

use glam::{DVec3, Vec3A};
use snowblue_render::SceneDescription;
use snowblue_render::files::FilesInMemory;
use snowblue_render::render::render_all;
use snowblue_render::scene::Scene;

use crate::snow::{SNOW, estimate, prepared, scene_of_few_grains};

/// A ball and a lamp before a camera, moved by some lengths in m.
fn ball_at([x, y, z]: [f64; 3]) -> SceneDescription {
    let at = |[own_x, own_y, own_z]: [f64; 3]| format!("[{}, {}, {}]", x + own_x, y + own_y, z + own_z);
    let text = format!(
        "[camera]\nposition = {}\nlook_at = {}\nvertical_fov_deg = 14\n[film]\nwidth = 8\nheight = 6\n[integrator]\n\
         type = \"hybrid\"\nsamples_per_pixel = 16\nfilter = false\n[light_field]\nstep_mm = 10\n{SNOW}\
         [[object]]\nshape = \"sphere\"\nradius = 0.1\nposition = {}\nmaterial = \"snow\"\n\
         [[light]]\ntype = \"point\"\nposition = {}\nradiant_intensity_w_sr = 10\n",
        at([0.0, -1.0, 0.3]),
        at([0.0; 3]),
        at([0.0; 3]),
        at([0.5, -1.0, 0.5]),
    );
    crate::snow::parsed(text)
}

#[test]
fn a_scene_in_a_national_grid_is_as_at_the_origin() {
    let light = |scene: &Scene| -> f64 {
        let film = render_all(&prepared(scene, None), &|_| {}).film;
        film.pixels().iter().map(|xyz| xyz.y).sum()
    };
    let built = |described: SceneDescription| described.build(&FilesInMemory::default()).unwrap();
    let described = ball_at([54_300.0, 5_190_200.0, 2400.0]);
    // Without a camera the first object counts.
    let bare = built(SceneDescription { camera: None, ..described.clone() });
    let (near, far) = (built(ball_at([0.0; 3])), built(described));
    assert_eq!(bare.local_origin(), far.local_origin());
    assert!(near.notes().is_empty(), "{:?}", near.notes());
    assert_eq!(far.local_origin(), DVec3::new(54_000.0, 5_190_000.0, 2000.0));
    assert_eq!(far.notes(), ["the scene is computed around [54000, 5190000, 2000] m"]);
    let ratio = light(&far) / light(&near);
    // Rounding turns a few walks of thousands elsewhere.
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
}

/// Walks in snow take steps of a millimetre. A kilometre from the local origin, coordinates are rounded to 0.06 mm.
#[test]
fn snow_a_kilometre_away_is_as_bright_as_near_by() {
    let slope = |at: Vec3A| {
        let text = format!(
            "{SNOW}[[object]]\nshape = \"heights\"\nheights = [[0, 1], [0, 1]]\nsize = [1, 1, 0.6]\nbottom = -0.4\n\
             position = [{}, {}, {}]\nmaterial = \"snow\"\n\
             [[light]]\ntype = \"directional\"\ndirection = [0.98, 0, -0.17]\nirradiance_w_m2 = 500\n",
            at.x, at.y, at.z
        );
        let mut integrator = prepared(&scene_of_few_grains("hybrid", &text, &[]), None);
        let target = at + Vec3A::new(0.1, 0.01, 0.36);
        let [_, green, _] = estimate(&mut integrator, target + Vec3A::new(-0.5, -0.5, 0.1), target, 256, [3, 15, 28]);
        green
    };
    let (far, near) = (slope(Vec3A::new(912.3, 345.6, 789.1)), slope(Vec3A::new(0.3, 0.6, 0.1)));
    let difference = far.mean / near.mean - 1.0;
    let error = far.standard_error.hypot(near.standard_error) / near.mean;
    assert!(difference.abs() < 4.0 * error && error < 0.01, "{difference} ± {error}");
}
