//! A scene that is built after another, and an integrator that is prepared after another, have the same pictures, to
//! the last bit, as those that are made alone. The light field is solved for only where it differs.

use snowblue_render::files::FilesInMemory;
use snowblue_render::render::render_all;
use snowblue_render::scene::description::{
    Coordinate, Count, EmissionSpectrum, LightSource, NamedShape, Number, Numbers, PlaneDescription,
};
use snowblue_render::scene::light::RadiantIntensity;
use snowblue_render::{Integrator, Preparation, Scene, SceneDescription};

use crate::snow::parsed;

/// A block between a lamp behind it and one within, of different spectra, and a floor that makes light return.
const SCENE: &str = "[camera]\nposition = [0.3, -1, 0.4]\nlook_at = [0, 0, 0]\nvertical_fov_deg = 25\n\
    [film]\nwidth = 8\nheight = 6\n[integrator]\nsamples_per_pixel = 2\nmax_bounces = 2\n\
    [light_field]\nstep_mm = 15\n\
    [material.snow]\ntype = \"snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n\
    [material.grey]\ntype = \"diffuse\"\nreflectance = 0.5\n\
    [[light]]\ntype = \"point\"\nposition = [0, 0.4, 0.1]\nradiant_intensity_w_sr = 10\n\
    [[light]]\ntype = \"point\"\nposition = [0.05, 0, 0]\nradiant_intensity_w_sr = 2\nilluminant = \"A\"\n\
    [[object]]\nshape = \"box\"\nsize = [0.16, 0.06, 0.12]\nmaterial = \"snow\"\n\
    [[object]]\nshape = \"plane\"\nposition = [0, 0, -0.1]\nmaterial = \"grey\"\n";

fn scene() -> SceneDescription {
    let mut scene = parsed(SCENE);
    // The pictures are compared with each other only.
    scene.light_field.grain_rays = 1 << 12;
    scene
}

fn built(scene: &SceneDescription) -> Scene {
    scene.build(&FilesInMemory::default()).unwrap()
}

fn move_to(position: &mut Numbers<Coordinate, 3>, axis: usize, coordinate_m: f64) {
    let mut moved = position.get();
    moved[axis] = coordinate_m;
    *position = Numbers::of(moved);
}

fn intensity(scene: &mut SceneDescription, light: usize) -> &mut Number<RadiantIntensity> {
    match &mut scene.lights[light].source {
        LightSource::Point(light) => &mut light.radiant_intensity_w_sr,
        other => panic!("{other:?}"),
    }
}

/// Builds a scene after another and prepares its integrator after the other's, and compares it with one that is made
/// alone.
fn prepare_and_compare(earlier: Integrator, scene: &SceneDescription, name: &str) -> Integrator {
    let after = scene.build_after(earlier.scene(), &FilesInMemory::default()).unwrap();
    assert_eq!(after.description(), scene, "{name}");
    let preparation = Preparation { earlier: Some(earlier), ..Preparation::default() };
    let after = Integrator::prepare_with(&after, preparation).unwrap();
    let alone = Integrator::prepare(&built(scene)).unwrap();
    assert!(render_all(&after, &|_| {}) == render_all(&alone, &|_| {}), "{name}");
    assert_eq!(after.provenance(), alone.provenance(), "{name}");
    after
}

#[test]
fn what_is_kept_does_not_change_the_picture() {
    type Change = (&'static str, fn(&mut SceneDescription), usize);
    // Each change follows the ones before; with the number of light fields to solve for.
    let changes: [Change; 11] = [
        ("camera", |scene| move_to(&mut scene.camera.as_mut().unwrap().position, 0, -0.5), 0),
        (
            "film and samples",
            |scene| (scene.film.width, scene.integrator.samples_per_pixel) = (Count::of(9), Count::of(3)),
            0,
        ),
        ("the inner lamp", |scene| *intensity(scene, 1) = Number::of(3.0), 1),
        ("the outer lamp is dark", |scene| *intensity(scene, 0) = Number::of(0.0), 0),
        ("all is dark", |scene| *intensity(scene, 1) = Number::of(0.0), 0),
        ("both shine", |scene| (*intensity(scene, 0), *intensity(scene, 1)) = (Number::of(5.0), Number::of(1.0)), 2),
        ("both have one spectrum", |scene| scene.lights[1].spectrum = EmissionSpectrum::default(), 1),
        ("bounces", |scene| scene.integrator.max_bounces = Count::of(1), 1),
        ("one lamp", |scene| drop(scene.lights.remove(0)), 1),
        ("another block", |scene| move_to(&mut scene.objects[0].common.position, 2, 0.02), 1),
        ("other cells", |scene| scene.light_field.step_mm = Some(Number::of(17.0)), 1),
    ];
    let mut scene = scene();
    let mut last = Integrator::prepare(&built(&scene)).unwrap();
    assert_eq!(last.solved_light_fields(), 2);
    for (name, change, solved) in changes {
        change(&mut scene);
        last = prepare_and_compare(last, &scene, name);
        assert_eq!(last.solved_light_fields(), solved, "{name}");
    }
    // Back to all at once.
    prepare_and_compare(last, &self::scene(), "all");
}

#[test]
fn what_is_kept_is_checked_again() {
    let refused = |change: fn(&mut SceneDescription), expected: &str| {
        let mut scene = scene();
        let earlier = built(&scene);
        change(&mut scene);
        let error = scene.build_after(&earlier, &FilesInMemory::default()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    refused(
        |scene| scene.camera.as_mut().unwrap().position = Numbers::of([0.01, 0.0, 0.0]),
        "camera.position lies inside the snow",
    );
    refused(|scene| scene.lights.clear(), "light is missing");
    let plane = |scene: &mut SceneDescription| {
        scene.objects[0].shape = NamedShape::Plane(PlaneDescription {}).into();
        scene.objects[0].common.body = Some("block".to_owned());
    };
    refused(plane, "body joins snow, but a plane has no inside");
}
