//! The scenes of the repository: each has a description, renders, and its snow is watertight.

use std::collections::BTreeSet;

use crate::shell::{shipped_scene, stdout};
use snowblue_base::{Count, Number};
use snowblue_render::SceneFile;
use snowblue_render::render::render;
use snowblue_render::scene::LightFieldSettings;
use snowblue_render::scene::description::{MaterialDescription, NamedShape, SceneDescription, ShapeDescription};
use snowblue_render::scene::inspection::inspect;

/// A test for each scene.
macro_rules! tests_of_scenes {
    ($($name:ident),* $(,)?) => {
        $(#[test]
        fn $name() {
            assert_renders(stringify!($name));
        })*

        const NAMES: &[&str] = &[$(stringify!($name)),*];
    };
}

tests_of_scenes!(
    block_30cm,
    clump,
    cornice,
    crevasse,
    fig1_lamp,
    fig9_back,
    fig9_front,
    fig9_oblique,
    fig10_igloo,
    fig10_opaque,
    fig11_dragon,
    hole_and_footprint,
    igloo_clear,
    igloo_overcast,
    lantern,
    probe_hole,
    quinzhee,
    snow_cave,
    snow_tunnel,
    truth_ball,
    truth_corner,
    truth_floor,
);

#[test]
fn every_scene_has_a_test() {
    let files = std::fs::read_dir(shipped_scene("")).unwrap().map(|entry| entry.unwrap().path());
    let names = files.filter(|file| file.extension().is_some_and(|ending| ending == "toml"));
    let names: BTreeSet<String> = names.map(|file| file.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    assert_eq!(names, NAMES.iter().map(|name| (*name).to_owned()).collect());
}

/// Few pixels, coarse cells, few rays through grains, one bounce and smooth surfaces: whether a scene renders and is
/// watertight does not depend on them, and its time does. `rough_solids_are_closed` of `snowblue-render` adds relief.
fn make_cheap(scene: &mut SceneDescription) {
    let SceneDescription { film, integrator, light_field, materials, objects, .. } = scene;
    integrator.max_bounces = Count::of(integrator.max_bounces.get().min(1));
    (film.width, film.height, integrator.samples_per_pixel) = (Count::of(8), Count::of(8), Count::of(1));
    let step_mm = light_field.step_mm.map(|step_mm| Number::of(8.0 * step_mm.get()));
    *light_field = LightFieldSettings {
        memory_mib: Count::of(16),
        step_mm,
        grain_rays: 1024,
        most_rounds: 1,
        ..LightFieldSettings::default()
    };
    for material in materials.values_mut() {
        if let MaterialDescription::Snow(snow) = material {
            snow.relief = None;
        }
    }
    for object in objects {
        if let ShapeDescription::Named(NamedShape::Carved(carved)) = &mut object.shape {
            carved.cell = Number::of(2.0 * carved.cell.get());
        }
    }
}

fn assert_renders(name: &str) {
    let path = shipped_scene(&format!("{name}.toml"));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("#:schema scene.schema.json\n# "), "the second line describes the scene");
    let mut file = SceneFile::open(&path).unwrap();
    make_cheap(&mut file.description);
    // Built once for both: the meshes of the large scenes take seconds.
    let scene = match file.build() {
        // A mesh that `scripts/fetch-models` downloads.
        Err(missing) if name == "fig11_dragon" => return assert!(missing.to_string().contains("dragon.ply")),
        built => built.unwrap(),
    };
    let film = render(&scene).unwrap().film;
    assert!(film.pixels().iter().all(|xyz| xyz.y.is_finite()));
    assert!(film.pixels().iter().any(|xyz| xyz.y > 0.0), "{name} is black");
    let objects = inspect(&scene);
    assert!(!objects.is_empty());
    let open: Vec<_> = objects.iter().filter(|object| object.is_snow && !object.is_watertight()).collect();
    assert!(open.is_empty(), "{name}: {open:?}");
}

#[test]
fn an_igloo_has_a_watertight_object_for_each_block() {
    let objects = stdout("render --scene fig10_igloo --check --format csv");
    let blocks: Vec<&str> = objects.lines().filter(|line| line.contains(",igloo,")).collect();
    assert!(blocks.len() > 50 && blocks.iter().all(|block| block.contains(",igloo,yes,yes,")), "{objects}");
}
