//! Builds a scene in code and renders it: a block of snow on a floor, lit from behind.
//!
//! `cargo run --release -p snowblue-render --example scene_from_code -- block.png`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

use std::error::Error;

use snowblue_render::files::FilesInMemory;
use snowblue_render::scene::description::{
    BoxDescription, CameraDescription, Count, DiffuseDescription, LightSource, MaterialDescription, NamedShape, Number,
    Numbers, ObjectDescription, PointLightDescription, SnowDescription,
};
use snowblue_render::{Exposure, SceneDescription, render};
use snowblue_transport::sample::{SnowKeys, SnowType};
use snowblue_transport::{Impurities, Substance};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "block.png".to_owned());
    let mut description = block_on_floor();

    // A description is plain data: change it and build it again for another picture. Numbers lie in the ranges of their
    // quantities: `Number::new` says what is wrong with others, and `Number::of` panics.
    description.film.exposure = Exposure::Stops(0.5);
    (description.film.width, description.film.height) = (Count::of(240), Count::of(200));
    (description.integrator.samples_per_pixel, description.integrator.max_bounces) = (Count::of(32), Count::of(2));

    // As the text of a scene file, for `snowblue render`.
    println!("{}", description.to_toml());

    let rendering = render(&description.build(&FilesInMemory::default())?)?;
    rendering.write_png(&path)?;
    println!("# {path}: {} camera rays", rendering.statistics.camera_rays);
    Ok(())
}

/// A block of snow, 10 cm thick, on a grey floor.
fn block_on_floor() -> SceneDescription {
    let mut scene = SceneDescription::default();
    let camera = CameraDescription::new(Numbers::of([0.9, -1.5, 0.6]), Numbers::of([0.0, 0.0, 0.22]));
    scene.camera = Some(CameraDescription { vertical_fov_deg: Number::of(30.0), ..camera });

    // Fresh snow with some soot, in ng/g; all that is not said follows from the kind.
    let fresh = SnowKeys {
        snow: Some(SnowType::Fresh),
        impurities_ng_g: Impurities::none().with(Substance::BLACK_CARBON, 20.0),
        ..SnowKeys::default()
    };
    scene.materials.insert("snow".to_owned(), MaterialDescription::Snow(SnowDescription::Uniform(fresh).into()));
    let grey = DiffuseDescription::grey(Number::of(0.2));
    scene.materials.insert("floor".to_owned(), MaterialDescription::Diffuse(grey));

    let cuboid = |size| NamedShape::Box(BoxDescription { size: Numbers::of(size) });
    scene.objects = vec![
        ObjectDescription::new(cuboid([0.5, 0.1, 0.5]), "snow").at(Numbers::of([0.0, 0.0, 0.25])),
        ObjectDescription::new(cuboid([3.0, 3.0, 0.1]), "floor").at(Numbers::of([0.0, -1.45, -0.05])),
    ];

    // Daylight (D65) unless it has another spectrum.
    let lamp =
        PointLightDescription { position: Numbers::of([0.0, 0.5, 0.2]), radiant_intensity_w_sr: Number::of(40.0) };
    scene.lights.push(LightSource::Point(lamp).into());
    scene
}
