//! The lightmap of a bake beside its vertices, and in a GLB.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use snowblue_base::files::FilesInMemory;
use snowblue_color::{LinearRgb, Srgb8};
use snowblue_geometry::images::DecodedImage;
use snowblue_render::Integrator;
use snowblue_render::bake::{BakeOptions, BakedObject, BakedScene, Lightmap, glb_bytes};

use crate::snow::parsed;

const HEAD: &str = "[camera]\nposition = [0, -3, 0]\nlook_at = [0, 0, 0]\n[film]\nwidth = 1\nheight = 1\n\
    [integrator]\ntype = \"diffusion\"\nsamples_per_pixel = 1\nmax_bounces = 0\n\
    [material.snow]\ntype = \"snow\"\ngrain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n\
    [[light]]\ntype = \"point\"\nposition = [0.1, 0.4, 0.2]\nradiant_intensity_w_sr = 5\nilluminant = \"E\"\n\
    [environment]\nradiance_w_m2_sr = 0.2\nilluminant = \"D65\"\n";
const BLOCK: &str = "[[object]]\nshape = \"box\"\nsize = [0.3, 0.1, 0.2]\nrotation_deg = [0, 0, 20]\n\
    material = \"snow\"\n";
const BALL: &str = "[[object]]\nshape = \"sphere\"\nradius = 0.1\nposition = [0.35, 0, 0]\nmaterial = \"snow\"\n";

fn integrator(text: &str) -> Integrator {
    let description = parsed(format!("{HEAD}{text}"));
    Integrator::prepare(&description.build(&FilesInMemory::default()).unwrap()).unwrap()
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

/// The light at a vertex, relative to the greatest, and that of the lightmap there differ by what light changes within
/// a texel of 1.5 mm: by 0.5 % on the ball, and by 0.6 % between charts. At edges of the block light falls off within a
/// cell of the field, and vertices read it beside the edge: there they differ by 10 %, which counts in the mean only.
#[test]
fn the_lightmap_has_the_light_of_the_vertices_on_both_sides_of_each_seam() {
    let baked = baked(&integrator(&format!("{BLOCK}{BALL}")), 0.01, 512);
    let lightmap = baked.lightmap.as_ref().unwrap();
    let greatest = baked.objects.iter().flat_map(|object| &object.exitance).map(|light| light.g).fold(0.0, f64::max);
    for (object, is_round) in baked.objects.iter().zip([false, true]) {
        let shown: Vec<DVec3> = object.texture_coordinates.iter().map(|at| sample(lightmap, *at) / greatest).collect();
        let vertices = object.exitance.iter().map(|light| colour(*light) / greatest);
        let differences: Vec<f64> =
            shown.iter().zip(vertices).map(|(one, other)| (*one - other).abs().max_element()).collect();
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        assert!(mean < 0.002, "{}: {mean}", object.name);
        let worst = differences.into_iter().fold(0.0, f64::max);
        assert!(!is_round || worst < 0.01, "{}: {worst}", object.name);
        // Vertices of one place with one normal have one light, in whatever charts they are.
        let mut charts: BTreeMap<[u32; 6], Vec<DVec3>> = BTreeMap::new();
        for (vertex, light) in shown.into_iter().enumerate() {
            let numbers = [object.positions[vertex], object.normals[vertex]].map(|vector| vector.to_array());
            let key = numbers.concat().try_into().map(|numbers: [f32; 6]| numbers.map(f32::to_bits));
            charts.entry(key.unwrap()).or_default().push(light);
        }
        let at_seams = vertices_of_several_charts(&charts);
        assert_eq!(!at_seams.is_empty(), is_round, "faces of a block have charts of their own");
        let gap = |lights: &&Vec<DVec3>| (lights[0] - lights[1]).abs().max_element();
        let widest = at_seams.iter().map(gap).fold(0.0, f64::max);
        assert!(widest < 0.015, "{}: {widest}", object.name);
    }
}

/// The light of the places that more than one chart has.
fn vertices_of_several_charts(charts: &BTreeMap<[u32; 6], Vec<DVec3>>) -> Vec<&Vec<DVec3>> {
    charts.values().filter(|lights| lights.len() > 1).collect()
}

/// The light of all surfaces of an object in W.
fn light_w(object: &BakedObject, of_triangle: impl Fn([usize; 3]) -> DVec3) -> DVec3 {
    let light = |triangle: &[u32; 3]| {
        let triangle = triangle.map(|vertex| vertex as usize);
        let [a, b, c] = triangle.map(|vertex| object.positions[vertex].as_dvec3());
        of_triangle(triangle) * (0.5 * (b - a).cross(c - a).length())
    };
    object.triangles.iter().map(light).sum()
}

/// The mean light of the lightmap in a triangle: at the middles of the 64 into which three halvings divide it.
fn mean_in_triangle(lightmap: &Lightmap, corners: [DVec2; 3]) -> DVec3 {
    let places = (0..8).flat_map(|i| (0..8 - i).map(move |j| [f64::from(i), f64::from(j)]));
    let middles = places.flat_map(|[i, j]| {
        let lower = [i + 1.0 / 3.0, j + 1.0 / 3.0];
        let upper = (i + j < 6.5).then_some([i + 2.0 / 3.0, j + 2.0 / 3.0]);
        std::iter::once(lower).chain(upper)
    });
    let light = |[u, v]: [f64; 2]| {
        let [a, b, c] = corners;
        let place = a + (b - a) * (u / 8.0) + (c - a) * (v / 8.0);
        sample(lightmap, place.as_vec2().to_array())
    };
    middles.map(light).sum::<DVec3>() / 64.0
}

/// The lightmap of a mesh with edges of 20 mm has the light of vertices 2 mm apart: the texels are read from the light
/// field, not from the vertices. 0.02 % was found for the block, where vertices 20 mm apart miss 0.5 %.
#[test]
fn the_light_of_the_lightmap_is_that_of_fine_vertices() {
    let integrator = integrator(&format!("{BLOCK}{BALL}"));
    let [coarse, fine] = [(0.02, 512), (0.002, 64)].map(|(step_m, size)| baked(&integrator, step_m, size));
    let lightmap = coarse.lightmap.as_ref().unwrap();
    for (coarse, fine) in coarse.objects.iter().zip(&fine.objects) {
        let at_vertices = |object: &BakedObject| {
            light_w(object, |triangle| {
                triangle.iter().map(|vertex| colour(object.exitance[*vertex])).sum::<DVec3>() / 3.0
            })
        };
        let of_lightmap = light_w(coarse, |triangle| {
            let corners = triangle.map(|vertex| DVec2::from(coarse.texture_coordinates[vertex].map(f64::from)));
            mean_in_triangle(lightmap, corners)
        });
        let error = |light: DVec3, truth: DVec3| (light / truth - 1.0).abs().max_element();
        let of_coarse = at_vertices(coarse);
        assert!(error(of_lightmap, of_coarse) < 0.01, "{}: {of_lightmap} {of_coarse}", coarse.name);
        // The ball is cut off by flat triangles, in both in another way.
        let same_area = light_w(coarse, |_| DVec3::ONE) / light_w(fine, |_| DVec3::ONE);
        let truth = at_vertices(fine) * same_area;
        assert!(error(of_lightmap, truth) < 0.001, "{}: {of_lightmap} {truth}", coarse.name);
    }
}

/// A baked block whose texture coordinates become the second ones of a mesh is baked onto the same places. There it has
/// the light of the same mesh on charts, but for what light changes within a texel: at edges the texels lie elsewhere.
#[test]
fn a_mesh_keeps_its_second_texture_coordinates() {
    let block = integrator(BLOCK);
    let block_baked = baked(&block, 0.02, 256);
    let glb = glb_bytes(&block_baked, &block.provenance()).unwrap();
    let [on_charts, on_its_own] = [glb.clone(), with_second_coordinates(&glb)].map(|glb| {
        let description = parsed(format!("{HEAD}[[object]]\nmesh = \"block.glb\"\nmaterial = \"snow\"\n"));
        let scene = description.build(&FilesInMemory::from([("block.glb", glb)])).unwrap();
        baked(&Integrator::prepare(&scene).unwrap(), 0.05, 256)
    });
    let given = &block_baked.objects[0];
    let vertex_at = |object: &BakedObject, vertex: usize| {
        let is_there = |other: &usize| {
            object.positions[*other].distance(given.positions[vertex]) < 1e-6
                && object.normals[*other].distance(given.normals[vertex]) < 1e-3
        };
        (0..object.positions.len()).find(is_there).unwrap()
    };
    let mut differences = Vec::new();
    for vertex in 0..given.positions.len() {
        let [charted, kept] = [&on_charts, &on_its_own].map(|baked| {
            let object = &baked.objects[0];
            let place = object.texture_coordinates[vertex_at(object, vertex)];
            (place, sample(baked.lightmap.as_ref().unwrap(), place))
        });
        assert_eq!(kept.0.map(f32::to_bits), given.texture_coordinates[vertex].map(f32::to_bits), "{vertex}");
        differences.push((charted.1 - kept.1).abs().max_element());
    }
    let greatest = given.exitance.iter().map(|light| light.g).fold(0.0, f64::max);
    let mean = differences.iter().sum::<f64>() / differences.len() as f64 / greatest;
    assert!(mean < 0.002, "{mean}");
}

/// A GLB whose texture coordinates are the second set.
fn with_second_coordinates(glb: &[u8]) -> Vec<u8> {
    const NAME: &[u8] = b"TEXCOORD_0";
    let mut glb = glb.to_vec();
    for start in 0..glb.len() - NAME.len() {
        if glb[start..].starts_with(NAME) {
            glb[start + NAME.len() - 1] = b'1';
        }
    }
    glb
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
        let coordinates = primitive.get(&gltf::Semantic::TexCoords(0)).unwrap();
        assert_eq!(
            (coordinates.count(), coordinates.dimensions()),
            (object.positions.len(), gltf::accessor::Dimensions::Vec2)
        );
        let view = coordinates.view().unwrap();
        let numbers: Vec<u8> =
            object.texture_coordinates.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
        assert_eq!(blob[view.offset()..view.offset() + view.length()], numbers);
        let material = primitive.material();
        let texture = material.pbr_metallic_roughness().base_color_texture().unwrap();
        assert_eq!(texture.tex_coord(), 0);
        let gltf::image::Source::View { view, mime_type } = texture.texture().source().unwrap().source() else {
            panic!()
        };
        assert_eq!(mime_type, "image/png");
        let png = DecodedImage::read(&blob[view.offset()..view.offset() + view.length()]).unwrap();
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
