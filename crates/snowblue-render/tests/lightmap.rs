//! The lightmap of a bake beside its vertices, and in a GLB.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use std::f64::consts::FRAC_1_PI;
use std::path::Path;

use glam::{DVec2, DVec3, Vec3A};
use snowblue_base::files::{Files, FilesInMemory};
use snowblue_color::{LinearRgb, Srgb8};
use snowblue_geometry::images::png_image::PngImage;
use snowblue_render::bake::{BakeOptions, BakedScene, Lightmap, glb_bytes};
use snowblue_render::{Integrator, SceneFile};

const HEAD: &str = "[camera]\nposition = [0, -3, 0]\nlook_at = [0, 0, 0]\n[film]\nwidth = 1\nheight = 1\n\
    [integrator]\ntype = \"diffusion\"\nsamples_per_pixel = 1\nmax_bounces = 0\n\
    [material.snow]\ntype = \"snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n\
    [[light]]\ntype = \"point\"\nposition = [0.1, 0.4, 0.2]\nradiant_intensity_w_sr = 5\nilluminant = \"E\"\n\
    [environment]\nradiance_w_m2_sr = 0.2\nilluminant = \"D65\"\n";
const BLOCK: &str = "[[object]]\nshape = \"box\"\nsize = [0.3, 0.1, 0.2]\nrotation_deg = [0, 0, 20]\n\
    material = \"snow\"\n";
const BALL: &str = "[[object]]\nshape = \"sphere\"\nradius = 0.1\nposition = [0.35, 0, 0]\nmaterial = \"snow\"\n";

fn integrator(text: &str) -> Integrator {
    let file = SceneFile::parse(format!("{HEAD}{text}"), "scene.toml").unwrap();
    Integrator::prepare(&file.description.build(&FilesInMemory::default()).unwrap()).unwrap()
}

fn baked(integrator: &Integrator, step_m: f64, size: u32) -> BakedScene {
    let options = BakeOptions { step_m: Some(step_m), lightmap: Some(size), ..BakeOptions::default() };
    integrator.bake(options, &|_| {}).unwrap()
}

/// The light at texture coordinates by linear interpolation, as renderers read a texture.
fn sample(lightmap: &Lightmap, coordinates: [f32; 2]) -> DVec3 {
    let at = DVec2::from(coordinates.map(f64::from)) * f64::from(lightmap.size) - 0.5;
    let (whole, share) = (at.floor(), at - at.floor());
    let texel = |column: f64, row: f64| {
        let [column, row] = [column, row].map(|index| index.clamp(0.0, f64::from(lightmap.size - 1)) as usize);
        DVec3::from(lightmap.texels[row * lightmap.size as usize + column].map(f64::from))
    };
    let row = |row: f64| texel(whole.x, row).lerp(texel(whole.x + 1.0, row), share.x);
    row(whole.y).lerp(row(whole.y + 1.0), share.y)
}

fn colour(light: LinearRgb) -> DVec3 {
    DVec3::new(light.r, light.g, light.b)
}

#[test]
fn the_lightmap_has_the_light_of_the_vertices_on_both_sides_of_each_seam() {
    let integrator = integrator(&format!("{BLOCK}{BALL}"));
    let baked = baked(&integrator, 0.01, 512);
    let lightmap = baked.lightmap.as_ref().unwrap();
    let greatest = baked.objects.iter().flat_map(|object| &object.exitance).map(|light| light.g).fold(0.0, f64::max);
    for object in &baked.objects {
        let mut worst = 0.0_f64;
        let mut sum = 0.0;
        for (light, coordinates) in object.exitance.iter().zip(&object.texture_coordinates) {
            let (at_vertex, shown) = (colour(*light), sample(lightmap, *coordinates));
            worst = worst.max((at_vertex - shown).abs().max_element() / greatest);
            sum += (at_vertex - shown).abs().max_element() / greatest;
        }
        println!("{}: {worst} {} texel {}", object.name, sum / object.exitance.len() as f64, lightmap.texel_m);
        // Vertices of one place with one normal have one light, in whatever charts they are.
        let mut seams = std::collections::HashMap::new();
        let bits = |vector: glam::Vec3| vector.to_array().map(f32::to_bits);
        for vertex in 0..object.positions.len() {
            let key = (bits(object.positions[vertex]), bits(object.normals[vertex]));
            seams.entry(key).or_insert_with(Vec::new).push(sample(lightmap, object.texture_coordinates[vertex]));
        }
        let mut gap = 0.0_f64;
        for places in seams.values().filter(|places| places.len() > 1) {
            for place in places {
                gap = gap.max((*place - places[0]).abs().max_element() / greatest);
            }
        }
        println!("seams {} gap {gap}", seams.values().filter(|places| places.len() > 1).count());
    }
}

#[test]
fn the_mean_light_of_the_lightmap_is_that_of_fine_vertices() {
    let integrator = integrator(&format!("{BLOCK}{BALL}"));
    let coarse = baked(&integrator, 0.02, 512);
    let fine = baked(&integrator, 0.002, 512);
    for number in 0..coarse.objects.len() {
        let mut means = Vec::new();
        for (baked, has_texture) in [(&coarse, true), (&coarse, false), (&fine, false), (&fine, true)] {
            let object = &baked.objects[number];
            let lightmap = baked.lightmap.as_ref().unwrap();
            let (mut light, mut area) = (DVec3::ZERO, 0.0);
            for triangle in &object.triangles {
                let [a, b, c] = triangle.map(|vertex| object.positions[vertex as usize].as_dvec3());
                let triangle_area = (b - a).cross(c - a).length();
                let mean = if has_texture {
                    // The middles of the 64 triangles into which three halvings of the edges divide it.
                    let mut sum = DVec3::ZERO;
                    let corners = triangle.map(|vertex| {
                        DVec2::from(object.texture_coordinates[vertex as usize].map(f64::from))
                    });
                    let mut count = 0.0;
                    for i in 0..8 {
                        for j in 0..8 - i {
                            for (offset, exists) in [(1.0 / 3.0, true), (2.0 / 3.0, i + j < 7)] {
                                if exists {
                                    let [u, v] = [i, j].map(|k| (f64::from(k) + offset) / 8.0);
                                    let at = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                                    sum += sample(lightmap, at.to_array().map(|x| x as f32));
                                    count += 1.0;
                                }
                            }
                        }
                    }
                    sum / count
                } else {
                    triangle.iter().map(|vertex| colour(object.exitance[*vertex as usize])).sum::<DVec3>() / 3.0
                };
                light += mean * triangle_area;
                area += triangle_area;
            }
            means.push(light / area);
        }
        println!("{}: lightmap/vertices of coarse {}, coarse vertices/fine {}, lightmap coarse/fine {}, fine {}",
            coarse.objects[number].name, means[0] / means[1], means[1] / means[2], means[0] / means[2], means[3] / means[2]);
    }
    let _ = (Vec3A::ZERO, FRAC_1_PI, Path::new(""), Files::default());
}

#[test]
fn a_glb_has_the_lightmap_as_its_base_colour() {
    let integrator = integrator(&format!("{BLOCK}{BALL}"));
    let baked = baked(&integrator, 0.05, 128);
    let lightmap = baked.lightmap.as_ref().unwrap();
    let bytes = glb_bytes(&baked, &integrator.provenance()).unwrap();
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = file.blob.as_deref().unwrap();
    for (mesh, object) in file.meshes().zip(&baked.objects) {
        let primitive = mesh.primitives().next().unwrap();
        let mut names: Vec<String> = primitive.attributes().map(|(semantic, _)| semantic.to_string()).collect();
        names.sort();
        assert_eq!(names, ["NORMAL", "POSITION", "TEXCOORD_0", "_LAMP_0", "_SKY"]);
        let reader = primitive.reader(|_| Some(blob));
        let coordinates: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
        assert_eq!(coordinates, object.texture_coordinates);
        let material = primitive.material();
        assert!(material.unlit());
        let texture = material.pbr_metallic_roughness().base_color_texture().unwrap();
        assert_eq!(texture.tex_coord(), 0);
        let gltf::image::Source::View { view, mime_type } = texture.texture().source().source() else { panic!() };
        assert_eq!(mime_type, "image/png");
        let png = PngImage::read(&blob[view.offset()..view.offset() + view.length()]).unwrap();
        assert_eq!((png.width, png.height, png.channels), (128, 128, 3));
        // The colours are the light over the scale, in the transfer function of sRGB.
        let extras = file.default_scene().unwrap().extras().as_ref().unwrap().get().to_owned();
        let (_, scale) = extras.split_once("\"lightmap_scale_w_m2\":").unwrap();
        let scale: f64 = scale.split([',', '}']).next().unwrap().parse().unwrap();
        for (pixel, [r, g, b]) in png.encoded_rgb().iter().zip(&lightmap.texels) {
            let light = LinearRgb { r: (*r).into(), g: (*g).into(), b: (*b).into() } * scale.recip();
            let Srgb8 { r, g, b } = Srgb8::encode(light.displayable());
            assert_eq!(pixel.map(|code| (255.0 * code).round() as u8), [r, g, b]);
        }
    }
}
