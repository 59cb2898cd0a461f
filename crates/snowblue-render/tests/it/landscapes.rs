//! Landscapes of scene files: maps with their places, snow on them, and prints in the snow.

use glam::Vec3A;
use snowblue_base::Count;
use snowblue_geometry::ray::{Crossing, Ray};
use snowblue_render::scene::Scene;
use snowblue_render::scene::inspection::{Inspection, inspect};
use snowblue_transport::ordinates::{OrdinatesOptions, solve};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Slab};

use crate::snow::{SNOW, prepared, radiance, scene, scene_by};

const SKY: &str = "[environment]\nradiance_w_m2_sr = 1\n[material.rock]\ntype = \"diffuse\"\nreflectance = 0.2\n";

/// A map of 9 × 6 heights, 2 m apart; its lower left height lies at 1001 m east and 2001 m north.
fn map(height_m: impl Fn(f64, f64) -> f64) -> String {
    let row = |row: u32| {
        let height = |column: u32| format!("{}", height_m(f64::from(column) * 2.0, f64::from(5 - row) * 2.0));
        (0..9).map(height).collect::<Vec<_>>().join(" ")
    };
    let rows: Vec<String> = (0..6).map(row).collect();
    format!("ncols 9\nnrows 6\nxllcorner 1000\nyllcorner 2000\ncellsize 2\nNODATA_value -9999\n{}\n", rows.join("\n"))
}

fn land(objects: &str, files: &[(&str, String)]) -> Scene {
    scene(&format!("{SNOW}{SKY}{objects}"), files)
}

/// Heights of the crossings of a vertical line with an object, from above.
fn heights(scene: &Scene, object: usize, x: f32, y: f32) -> Vec<f32> {
    let mut crossings: Vec<Crossing> = Vec::new();
    let ray = Ray::new(Vec3A::new(x, y, 100.0), Vec3A::NEG_Z);
    assert!(!scene.objects().segments(object, &ray, f32::INFINITY, &mut crossings));
    crossings.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    crossings.iter().map(|crossing| 100.0 - crossing.distance_m).collect()
}

fn check_watertight(scene: &Scene) -> Vec<Inspection> {
    let inspections = inspect(scene);
    for inspection in &inspections {
        assert!(inspection.is_watertight(), "{inspection:?}");
    }
    inspections
}

#[test]
fn maps_lie_in_their_place_with_snow_on_them() {
    let hill =
        |x: f64, y: f64| 1500.0 + 0.25 * x - 0.125 * y + 2.0 * (-((x - 8.0).powi(2) + (y - 5.0).powi(2)) / 9.0).exp();
    let objects = "[[object]]\nshape = \"heights\"\nfile = \"hill.asc\"\nmaterial = \"rock\"\n\
        [[object]]\nshape = \"snowpack\"\nground = \"hill.asc\"\ndepth = 0.5\nmaterial = \"snow\"\n";
    let scene = land(objects, &[("hill.asc", map(hill))]);
    for key in ["object[0].file", "object[1].ground"] {
        let note = format!("{key} states no coordinate system: its coordinates count as metres");
        assert!(scene.notes().iter().any(|other| other.starts_with(&note)), "{:?}", scene.notes());
    }
    let inspections = check_watertight(&scene);
    // 8 cells of 2 m by 5 cells of 2 m, all under 0.5 m of snow; coordinates are rounded by 1e-6 m.
    let volume_m3 = inspections[1].volume_m3.unwrap();
    assert!((volume_m3 - 16.0 * 10.0 * 0.5).abs() < 1e-3, "{volume_m3}");
    // The origin is the middle of the map, between two heights, and the ground there lies at z = 0. Triangles miss the
    // heights by a twentieth of 2 m at most; slopes are below 1.
    let datum = 0.5 * (hill(8.0, 4.0) + hill(8.0, 6.0));
    for (x, y) in [(0.0, 1.0), (4.0, 1.0), (-6.0, -3.0), (2.0, 3.0)] {
        let expected = hill(f64::from(x) + 8.0, f64::from(y) + 5.0) - datum;
        let ground = heights(&scene, 0, x + 1e-3, y + 1e-3);
        assert!((f64::from(ground[0]) - expected).abs() < 0.102, "{x}, {y}: {ground:?} for {expected}");
    }
    // Snow and ground do not cross anywhere.
    for k in 0..900u16 {
        let (x, y) = (f32::from(k % 30) * 0.5 - 7.3, f32::from(k / 30) * 0.3 - 4.4);
        let (ground, snow) = (heights(&scene, 0, x, y), heights(&scene, 1, x, y));
        assert_eq!((ground.len(), snow.len()), (2, 2), "{x}, {y}");
        assert!(snow[1] > ground[0] + 0.0009 && snow[1] < ground[0] + 0.41, "{x}, {y}: {snow:?} on {ground:?}");
    }
    // The rock ends a hundredth of 16 m below its least height.
    let size_m = inspections[0].size_m.unwrap();
    assert!((size_m.x - 16.0).abs() < 1e-5 && (size_m.y - 10.0).abs() < 1e-5, "{size_m}");
}

#[test]
fn a_part_of_a_map_is_cut_out_in_its_coordinates() {
    let objects = "[[object]]\nshape = \"heights\"\nfile = \"slope.asc\"\nmaterial = \"rock\"\ntolerance = 0\n\
        crop = { centre = [1006, 2006], size = [6, 4] }\ndatum = 1500\nbottom = -1\n";
    let scene = land(objects, &[("slope.asc", map(|x, y| 1500.0 + x + 10.0 * y))]);
    let inspections = check_watertight(&scene);
    // From x = 1003 to 1009 and y = 2004 to 2008, at the nearest heights: y = 2003 or 2005 and so on, 4 m apart.
    let size_m = inspections[0].size_m.unwrap();
    assert_eq!((size_m.x, size_m.y), (6.0, 4.0));
    // The point at 1006 m east and 2006 m north is 5 m from the first height each way.
    let top = heights(&scene, 0, 0.0, 0.1)[0];
    assert!((top - (5.0 + 10.0 * 5.1)).abs() < 1e-4, "{top}");
}

#[test]
fn maps_of_depths_lie_in_their_place_on_maps_of_heights() {
    let objects = "[[object]]\nshape = \"snowpack\"\nground = \"flat.asc\"\nmaterial = \"snow\"\ntolerance = 0\n\
        crop = { centre = [1006, 2005], size = [6, 4] }\ndepth = { texture = \"depth.asc\" }\n";
    // Depths rise to the north-east of the map's corner, and the snow from 1003 to 1009 m and 2003 to 2007 m is 0.1 m
    // times the way from there.
    let depths = map(|x, y| 0.1 * (x + y));
    let scene = land(objects, &[("flat.asc", map(|_, _| 700.0)), ("depth.asc", depths)]);
    let volume_m3 = check_watertight(&scene)[0].volume_m3.unwrap();
    // The mean depth is that of the middle, 5 m and 4 m from the first height.
    assert!((volume_m3 - 6.0 * 4.0 * 0.9).abs() < 1e-4, "{volume_m3}");
    let [top, bottom] = heights(&scene, 0, 2.0, 1.0)[..] else { panic!("snow") };
    assert!((top - bottom - 0.1 * (7.0 + 5.0)).abs() < 1e-4, "{top} {bottom}");
}

#[test]
fn maps_of_depths_have_the_keys_that_messages_advise() {
    // 16 m by 10 m of snow: 50 cm deep, 0.25 m where the map has no depth, and 3/4 of the way from 0 to 1 m.
    for (keys, depth_of_map, volume_m3) in [
        (", unit = \"cm\"", 50.0, 80.0),
        (", fill = 0.25", -9999.0, 40.0),
        (", nodata = 7, fill = 0.75, unit = \"cm\", range = [0.5, 1]", 7.0, 120.0),
    ] {
        let objects = format!(
            "[[object]]\nshape = \"snowpack\"\nground = \"flat.asc\"\nmaterial = \"snow\"\n\
             depth = {{ texture = \"depth.asc\"{keys} }}\n"
        );
        let files = [("flat.asc", map(|_, _| 700.0)), ("depth.asc", map(|_, _| depth_of_map))];
        let found_m3 = check_watertight(&land(&objects, &files))[0].volume_m3.unwrap();
        assert!((found_m3 - volume_m3).abs() < 1e-3, "{keys}: {found_m3}");
    }
}

#[test]
fn snow_lies_on_meshes_by_an_attribute_of_their_vertices() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property float snow_cm\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 10\n2 0 0.5 10\n2 3 0.5 40\n0 3 0 40\n3 0 1 2\n3 0 2 3\n";
    let objects = "[[object]]\nshape = \"snowpack\"\nground = \"slope.ply\"\nmaterial = \"snow\"\n\
        depth = { attribute = \"snow_cm\", range = [0, 0.01] }\ngap = 0\n";
    let scene = land(objects, &[("slope.ply", ply.to_owned())]);
    check_watertight(&scene);
    // Farther from the edges than the rims are wide, on ground that rises by a quarter of x.
    for (x, y) in [(1.0, 1.2), (1.0, 1.5), (0.9, 1.8)] {
        let expected_m = 0.25 * x + 0.1 + 0.1 * y;
        let top_m = heights(&scene, 0, x, y)[0];
        assert!((top_m - expected_m).abs() < 1e-3, "{x}, {y}: {top_m}");
    }
}

#[test]
fn prints_are_pressed_into_every_surface_of_heights() {
    let prints = "[[object.imprint]]\ntype = \"hole\"\nposition = [0.2, 0.1]\nradius = 0.025\ndepth = 0.15\n\
        [[object.imprint]]\ntype = \"footprint\"\nposition = [-0.3, 0]\nheading_deg = 90\ndepth = 0.06\n\
        toe_depth = 0.05\nrim = 0.01\nfoot = \"left\"\n";
    for shape in [
        "shape = \"drift\"\nsize = [1.6, 1.2, 0.3]\nrelief = 0.01\n",
        "shape = \"heights\"\nsize = [1.6, 1.2, 1]\nbottom = -0.3\nheights = [[0, 0.01], [0, 0]]\n",
        "shape = \"snowpack\"\nsize = [1.6, 1.2, 1]\ndepth = 0.3\nheights = [[0, 0.01], [0, 0]]\n",
    ] {
        let object = format!("[[object]]\n{shape}material = \"snow\"\n");
        let (whole, pressed) = (land(&object, &[]), land(&format!("{object}{prints}"), &[]));
        assert!(whole.objects().list()[0].undisturbed.is_none());
        check_watertight(&pressed);
        let surface = pressed.objects().list()[0].undisturbed.as_ref().unwrap();
        for (x, y, depth_m) in [(0.2, 0.1, 0.15), (-0.3, 0.1, 0.05), (0.5, -0.4, 0.0)] {
            let (before, after) = (heights(&whole, 0, x, y)[0], heights(&pressed, 0, x, y)[0]);
            // The tread stands up by 4 mm, and the sole's triangles are within 1 mm.
            assert!((before - after - depth_m).abs() < 0.0051, "{shape}: {before} to {after}");
            assert!((surface.height_m(x, y).unwrap() - before).abs() < 1e-4, "{shape}");
        }
        assert_eq!(surface.height_m(0.9, 0.0), None);
    }
}

#[test]
fn undisturbed_surfaces_follow_their_objects() {
    let land = |placing: &str| {
        land(
            &format!(
                "[[object]]\nshape = \"heights\"\nsize = [2, 2, 1]\nbottom = -1\nheights = [[0, 1], [0, 1]]\n\
                 material = \"snow\"\n{placing}[[object.imprint]]\ntype = \"hole\"\nposition = [0, 0]\nradius = 0.1\n\
                 depth = 0.2\n"
            ),
            &[],
        )
    };
    let turned = land("position = [10, 0, 5]\nrotation_deg = [0, 0, 90]\nscale = 2\n");
    let surface = turned.objects().list()[0].undisturbed.as_ref().unwrap();
    // Along the object's x, which is the scene's y, heights rise from 0 to 2 m over 4 m.
    for (x, y, height_m) in [(10.0, 0.0, 6.0), (11.9, 0.0, 6.0), (10.0, 1.9, 6.95)] {
        assert!((surface.height_m(x, y).unwrap() - height_m).abs() < 1e-5, "{x}, {y}");
    }
    assert!(land("rotation_deg = [5, 0, 0]\n").objects().list()[0].undisturbed.is_none(), "tilted");
}

/// Snow of kilometres, whose cells are far larger than the depth that light reaches, reflects the sun as a plane of
/// snow does.
#[test]
fn snow_of_kilometres_is_deep_snow() {
    let of = |shape: &str| {
        let sun =
            "[[light]]\ntype = \"directional\"\ndirection = [0, 2, -1]\nirradiance_w_m2 = 5\nilluminant = \"E\"\n";
        let text = format!("{SNOW}{sun}[[object]]\nmaterial = \"snow\"\n{shape}");
        let mut integrator = prepared(&scene_by("diffusion", &text, &[]), None);
        // Single scattering is sampled.
        integrator.set_samples_per_pixel(4096);
        radiance(&mut integrator, Vec3A::new(0.0, -9.0, 0.0), Vec3A::new(100.0, 50.0, -600.0))
    };
    let wide = of("shape = \"box\"\nsize = [2000, 2000, 300]\nposition = [0, 0, -750]\n");
    let plane = of("shape = \"plane\"\nposition = [0, 0, -600]\n");
    // The single scattering of the body is that of few grains, at all wavelengths by the same factor.
    let ratios: Vec<f32> = wide.0.iter().zip(plane.0).map(|(wide, plane)| wide / plane).collect();
    assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.02), "{ratios:?}");
    assert!(ratios.iter().all(|ratio| (ratio / ratios[0] - 1.0).abs() < 2e-3), "{ratios:?}");
}

/// Under a white sky, thin snow reflects what the slab of the same depth does by discrete ordinates on the same ground.
#[test]
fn the_ground_shines_through_thin_snow() {
    let brightness = |reflectance: f64| {
        let ground = "size = [0.8, 0.8, 1]\nheights = [[0, 0.1], [0, 0.1]]\n";
        let text = format!(
            "{SNOW}[light_field]\nstep_mm = 10\n[environment]\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n\
             [material.rock]\ntype = \"diffuse\"\nreflectance = {reflectance}\n\
             [[object]]\nshape = \"heights\"\n{ground}bottom = -0.1\nmaterial = \"rock\"\n\
             [[object]]\nshape = \"snowpack\"\n{ground}depth = 0.02\nmaterial = \"snow\"\n"
        );
        let mut scene = scene_by("diffusion", &text, &[]);
        scene.set_max_bounces(Count::of(8));
        let mut integrator = prepared(&scene, None);
        let eye = Vec3A::new(0.0, -1.0, 3.0);
        let [snow, sky] = [Vec3A::new(0.0, 0.0, 0.07), Vec3A::new(0.0, 0.0, 9.0)]
            // At 450 nm.
            .map(|target| radiance(&mut integrator, eye, target).0[5]);
        snow / sky
    };
    // The camera sees the snow at 19° from its normal, and by reciprocity with the reflectance for a beam from there.
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![2.0],
        incidences: vec![Incidence::Beam { angle_deg: 19.0 }, Incidence::Diffuse],
        wavelengths_nm: vec![450.0],
    };
    let known = solve(&slab, &OrdinatesOptions::default()).unwrap();
    let of = |incidence: Incidence| known.iter().find(|known| known.incidence == incidence).unwrap();
    let (beam, diffuse) = (of(slab.incidences[0]), of(Incidence::Diffuse));
    for ground in [0.0, 0.5] {
        // Light that the slab lets through goes back and forth between it and the ground.
        let to_and_fro = ground / (1.0 - diffuse.fluxes.reflectance.value * ground);
        let through = beam.fluxes.transmittance.value * diffuse.fluxes.transmittance.value * to_and_fro;
        let expected = beam.fluxes.reflectance.value + through;
        let found = f64::from(brightness(ground));
        // The error of diffusion in a slab of this depth, and 1 % at which gathering of light ends.
        assert!((found / expected - 1.0).abs() < 0.01, "{ground}: {found} for {expected}");
    }
}
