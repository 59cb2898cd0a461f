//! Baked scenes as files that describe their attributes.
//!
//! **GLB**, binary glTF 2.0 (Khronos Group 2021, ISO/IEC 12113:2022): a mesh for each object, y up. The material is
//! unlit (`KHR_materials_unlit`), so that a viewer shows `COLOR_0` as it is, or the lightmap as the texture of the
//! base colour. `COLOR_0` would multiply the texture, so that a file has only one of the two.
//!
//! **PLY** (Turk 1994, "The PLY polygon file format"), binary: all objects as one mesh in scene axes, z up.

use std::f64::consts::{FRAC_1_PI, PI};
use std::io::{BufWriter, Write};
use std::path::Path;

use glam::{DVec3, Vec3};
use serde_json::{Map, Value, json};
use snowblue_base::atomic_file::write_atomically;
use snowblue_base::files::{FileError, one_line};
use snowblue_base::narrow;
use snowblue_color::{LinearRgb, Srgb8};
use snowblue_geometry::mesh_files::gltf::Y_UP_TO_Z_UP;
use snowblue_scene::provenance::Provenance;
use snowblue_scene::spectrum::wavelengths_nm;

use crate::bake::{BakedObject, BakedScene, Channels, HAS_LIGHTMAPS, Lightmap};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const LINEAR: u32 = 9729;
const CLAMP_TO_EDGE: u32 = 33_071;
/// Size of the header of the file, and of the header of a chunk, in bytes.
const FILE_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Writes a baked scene of linear sRGB as GLB, completely or not at all: `POSITION`, `NORMAL`, `_LAMP_0` and so on,
/// `_SKY`, and a preview of what leaves the surface: `COLOR_0`, or with a lightmap `TEXCOORD_0` and a PNG.
///
/// # Errors
///
/// When the file cannot be written.
///
/// # Panics
///
/// When the scene is baked as spectra, which a GLB cannot hold.
pub fn write_glb(baked: &BakedScene, provenance: &Provenance, path: &Path) -> Result<(), FileError> {
    let written = Parts::new(baked, provenance).and_then(|parts| {
        write_atomically(path, |file| {
            let mut writer = BufWriter::new(file);
            parts.write(&mut writer)?;
            writer.flush()
        })
    });
    written.map_err(|source| FileError::Write { path: path.into(), source })
}

/// The bytes of the file that [`write_glb`] writes.
///
/// # Errors
///
/// When the scene is too large for a GLB.
///
/// # Panics
///
/// When the scene is baked as spectra, which a GLB cannot hold.
pub fn glb_bytes(baked: &BakedScene, provenance: &Provenance) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    Parts::new(baked, provenance)?.write(&mut bytes)?;
    Ok(bytes)
}

/// The JSON and the binary chunk of a file.
#[derive(Default)]
struct Parts {
    json: Vec<u8>,
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Parts {
    fn new(baked: &BakedScene, provenance: &Provenance) -> std::io::Result<Self> {
        assert_eq!(baked.channels.count(), 3, "a GLB holds linear sRGB");
        let names = attributes(baked, |lamp| format!("_LAMP_{lamp}"), "_SKY");
        let preview = Preview::of(baked);
        let mut parts = Self::default();
        let (mut nodes, mut meshes) = (Vec::new(), Vec::new());
        for (number, object) in baked.objects.iter().enumerate() {
            let accessors = parts.add_object(object, &names, &preview);
            let extras: Map<String, Value> =
                of_snow(object, &names).into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
            let mut node = json!({ "name": object.name, "mesh": number });
            if baked.origin != DVec3::ZERO {
                node["translation"] = json!((Y_UP_TO_Z_UP.transpose() * baked.origin).to_array());
            }
            nodes.push(node);
            let primitive = json!({
                "attributes": accessors.attributes, "indices": accessors.indices, "material": 0, "mode": 4
            });
            meshes.push(json!({ "name": object.name, "primitives": [primitive], "extras": extras }));
        }
        let mut extras: Map<String, Value> =
            of_file(baked, provenance).into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect();
        let attribute = |(name, kind): &(String, &str)| json!({ "name": name, "kind": kind });
        extras.insert("attributes".to_owned(), names.iter().map(attribute).collect());
        let shown = if baked.lightmap.is_some() { "lightmap" } else { "color_0" };
        extras.insert(
            format!("{shown}_content"),
            json!("exitance: J and the irradiance by all light, at most 1, mapped into sRGB"),
        );
        extras.insert(format!("{shown}_scale_w_m2"), json!(preview.scale_w_m2));
        let mut document = json!({
            "asset": { "version": "2.0", "generator": generator(provenance) },
            "extensionsUsed": ["KHR_materials_unlit"],
            "scene": 0,
            "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>(), "extras": extras }],
            "nodes": nodes,
            "meshes": meshes,
            "materials": [{
                "name": "snow",
                "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
                "extensions": { "KHR_materials_unlit": {} }
            }],
        });
        // Without lightmaps a program needs no encoder for PNG.
        if let Some(lightmap) = baked.lightmap.as_ref().filter(|_| HAS_LIGHTMAPS) {
            document["scenes"][0]["extras"]["lightmap_texel_m"] = json!(lightmap.texel_m);
            document["images"] =
                json!([{ "bufferView": parts.add_image(lightmap, &preview)?, "mimeType": "image/png" }]);
            // Without mipmaps: their smaller levels mix charts, which shows as bright dashes along edges.
            document["samplers"] = json!([{
                "magFilter": LINEAR, "minFilter": LINEAR, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE
            }]);
            document["textures"] = json!([{ "sampler": 0, "source": 0 }]);
            document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
        }
        document["accessors"] = json!(parts.accessors);
        document["bufferViews"] = json!(parts.views);
        document["buffers"] = json!([{ "byteLength": parts.binary.len() }]);
        parts.json = document.to_string().into_bytes();
        // Chunks are multiples of four bytes.
        parts.json.resize(parts.json.len().next_multiple_of(4), b' ');
        Ok(parts)
    }

    /// Adds the arrays of an object.
    fn add_object(&mut self, object: &BakedObject, names: &[(String, &'static str)], preview: &Preview) -> Accessors {
        let positions: Vec<Vec3> = object.positions.iter().map(|position| y_up(*position)).collect();
        let low = positions.iter().fold(Vec3::INFINITY, |low, position| low.min(*position));
        let high = positions.iter().fold(Vec3::NEG_INFINITY, |high, position| high.max(*position));
        let position = self.add_vectors(positions.iter().flat_map(|position| position.to_array()));
        self.accessors[position]["min"] = json!(low.to_array());
        self.accessors[position]["max"] = json!(high.to_array());
        let normal = self.add_vectors(object.normals.iter().flat_map(|normal| y_up(*normal).to_array()));
        let shown = if object.texture_coordinates.is_empty() {
            ("COLOR_0", self.add_vectors(object.exitance.iter().flat_map(|exitance| preview.colour(*exitance))))
        } else {
            ("TEXCOORD_0", self.add_floats("VEC2", 2, object.texture_coordinates.iter().flatten().copied()))
        };
        let mut attributes: Map<String, Value> = [("POSITION", position), ("NORMAL", normal), shown]
            .map(|(name, k)| (name.to_owned(), json!(k)))
            .into_iter()
            .collect();
        for ((name, _), flux) in names.iter().zip(&object.flux) {
            attributes.insert(name.clone(), json!(self.add_vectors(flux.iter().copied())));
        }
        Accessors { attributes, indices: self.add_indices(&object.triangles) }
    }

    /// Adds vectors of three numbers, and returns their accessor.
    fn add_vectors(&mut self, numbers: impl Iterator<Item = f32>) -> usize {
        self.add_floats("VEC3", 3, numbers)
    }

    /// Adds vectors of a type with `dimensions` numbers, and returns their accessor.
    fn add_floats(&mut self, kind: &str, dimensions: usize, numbers: impl Iterator<Item = f32>) -> usize {
        let start = self.binary.len();
        self.binary.extend(numbers.flat_map(f32::to_le_bytes));
        let count = (self.binary.len() - start) / (dimensions * size_of::<f32>());
        self.add_accessor(start, ARRAY_BUFFER, json!({ "componentType": FLOAT, "type": kind, "count": count }))
    }

    /// Adds a lightmap as PNG, and returns its view.
    fn add_image(&mut self, lightmap: &Lightmap, preview: &Preview) -> std::io::Result<usize> {
        let start = self.binary.len();
        let mut encoder = png::Encoder::new(&mut self.binary, lightmap.size, lightmap.size);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        let colours: Vec<u8> = lightmap.texels.iter().flat_map(|exitance| preview.encoded(*exitance)).collect();
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&colours)?;
        writer.finish()?;
        let length = self.binary.len() - start;
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length }));
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        Ok(self.views.len() - 1)
    }

    fn add_indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let start = self.binary.len();
        self.binary.extend(triangles.iter().flatten().flat_map(|vertex| vertex.to_le_bytes()));
        let count = 3 * triangles.len();
        let accessor = json!({ "componentType": UNSIGNED_INT, "type": "SCALAR", "count": count });
        self.add_accessor(start, ELEMENT_ARRAY_BUFFER, accessor)
    }

    /// Adds an accessor of the bytes from `start` on.
    fn add_accessor(&mut self, start: usize, target: u32, mut accessor: Value) -> usize {
        let length = self.binary.len() - start;
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": target }));
        accessor["bufferView"] = json!(self.views.len() - 1);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn write(&self, writer: &mut impl Write) -> std::io::Result<()> {
        let length = |length: usize| u32::try_from(length).map_err(std::io::Error::other).map(u32::to_le_bytes);
        writer.write_all(b"glTF")?;
        writer.write_all(&2_u32.to_le_bytes())?;
        writer.write_all(&length(FILE_HEADER + 2 * CHUNK_HEADER + self.json.len() + self.binary.len())?)?;
        for (name, content) in [(b"JSON", &self.json), (b"BIN\0", &self.binary)] {
            writer.write_all(&length(content.len())?)?;
            writer.write_all(name)?;
            writer.write_all(content)?;
        }
        Ok(())
    }
}

/// The accessors of an object.
struct Accessors {
    attributes: Map<String, Value>,
    indices: usize,
}

/// Display of an exitance in `COLOR_0` or the lightmap: a PNG shows the radiance of a diffuse surface with this
/// exitance in the same way.
struct Preview {
    /// The exitance that is shown as 1, in W/m².
    scale_w_m2: f64,
}

impl Preview {
    fn of(baked: &BakedScene) -> Self {
        let exitances = baked.objects.iter().flat_map(|object| &object.exitance);
        let radiances = exitances.map(|exitance| *exitance * FRAC_1_PI);
        Self { scale_w_m2: PI / baked.exposure.display_factor(radiances) }
    }

    fn colour(&self, exitance: LinearRgb) -> [f32; 3] {
        let LinearRgb { r, g, b } = (exitance * self.scale_w_m2.recip()).displayable();
        [r, g, b].map(narrow)
    }

    /// The colour as a PNG has it.
    fn encoded(&self, [r, g, b]: [f32; 3]) -> [u8; 3] {
        let [r, g, b] = self.colour(LinearRgb { r: r.into(), g: g.into(), b: b.into() });
        let Srgb8 { r, g, b } = Srgb8::encode(LinearRgb { r: r.into(), g: g.into(), b: b.into() });
        [r, g, b]
    }
}

/// A vector of the scene in the axes of glTF.
fn y_up(vector: Vec3) -> Vec3 {
    (Y_UP_TO_Z_UP.transpose() * vector.as_dvec3()).as_vec3()
}

/// Writes a baked scene as PLY, completely or not at all. The vertex properties are `x y z nx ny nz`, then for each
/// lamp `lamp_0_r lamp_0_g lamp_0_b` or the wavelengths `lamp_0_400nm`, and last the same properties for `sky`.
///
/// # Errors
///
/// When the file cannot be written.
pub fn write_ply(baked: &BakedScene, provenance: &Provenance, path: &Path) -> Result<(), FileError> {
    let written = write_atomically(path, |file| {
        let mut writer = BufWriter::new(file);
        write(baked, provenance, &mut writer)?;
        writer.flush()
    });
    written.map_err(|source| FileError::Write { path: path.into(), source })
}

fn write(baked: &BakedScene, provenance: &Provenance, writer: &mut impl Write) -> std::io::Result<()> {
    writer.write_all(header(baked, provenance).as_bytes())?;
    for object in &baked.objects {
        for vertex in 0..object.positions.len() {
            let place = object.positions[vertex].to_array().into_iter().chain(object.normals[vertex].to_array());
            let count = baked.channels.count();
            let flux = object.flux.iter().flat_map(|values| &values[vertex * count..(vertex + 1) * count]);
            for number in place.chain(flux.copied()) {
                writer.write_all(&number.to_le_bytes())?;
            }
        }
    }
    let mut first = 0;
    for object in &baked.objects {
        for triangle in &object.triangles {
            writer.write_all(&[3])?;
            for vertex in triangle {
                writer.write_all(&(first + vertex).to_le_bytes())?;
            }
        }
        first += u32::try_from(object.positions.len()).unwrap_or(u32::MAX);
    }
    Ok(())
}

fn header(baked: &BakedScene, provenance: &Provenance) -> String {
    let mut lines = vec!["ply".to_owned(), "format binary_little_endian 1.0".to_owned()];
    let names = attributes(baked, |lamp| format!("lamp_{lamp}"), "sky");
    for (name, value) in of_file(baked, provenance) {
        lines.push(format!("comment {name}: {value}"));
    }
    lines.extend(names.iter().map(|(name, kind)| format!("comment {name}: {kind}")));
    let mut first = 0;
    for object in &baked.objects {
        let after = first + object.positions.len();
        lines.push(format!("comment object {}: vertices {first} to {}", one_line(&object.name), after - 1));
        first = after;
    }
    let mut snow: Vec<String> = Vec::new();
    for object in &baked.objects {
        for (name, value) in of_snow(object, &names) {
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            let line = format!("comment {name} of {}: {value}", one_line(&object.name));
            if !snow.contains(&line) {
                snow.push(line);
            }
        }
    }
    lines.extend(snow);
    let count = |count: fn(&BakedObject) -> usize| baked.objects.iter().map(count).sum::<usize>();
    lines.push(format!("element vertex {}", count(|object| object.positions.len())));
    lines.extend(["x", "y", "z", "nx", "ny", "nz"].map(|name| format!("property float {name}")));
    let channels: Vec<String> = match baked.channels {
        Channels::Rgb => ["r", "g", "b"].map(str::to_owned).into(),
        Channels::Spectrum => wavelengths_nm().iter().map(|nm| format!("{nm}nm")).collect(),
    };
    for (name, _) in &names {
        lines.extend(channels.iter().map(|channel| format!("property float {name}_{channel}")));
    }
    lines.push(format!("element face {}", count(|object| object.triangles.len())));
    lines.push("property list uchar uint vertex_indices".to_owned());
    lines.push("end_header\n".to_owned());
    lines.join("\n")
}

/// The metadata of the whole file: names and values.
fn of_file(baked: &BakedScene, provenance: &Provenance) -> Vec<(&'static str, String)> {
    let weighting = match baked.channels {
        Channels::Rgb => {
            "W/m2 as linear sRGB, unclipped; 1 is the luminance of 1 W/m2 of equal-energy light over 400-700 nm"
        }
        Channels::Spectrum => "W/(m2 nm)",
    };
    let mut entries = vec![
        ("generator", generator(provenance)),
        ("content", "net flux J of light outwards through the surface of snow; negative on lit faces".to_owned()),
        ("origin", format!("{} m: what positions count from in the scene file", baked.origin)),
        ("units", format!("positions in m; fluxes in {weighting}")),
        ("shading", "L(mu) = sum of R0 F over direct lights + K(mu) J / pi, R0 nearly 1/pi, J a sum".to_owned()),
    ];
    for name in ["scene", "table", "max bounces", "white"] {
        entries.extend(provenance.get(name).map(|value| (key(name), value.to_owned())));
    }
    entries
}

/// The program, for files that name it.
fn generator(provenance: &Provenance) -> String {
    format!("snowblue {}", provenance.get("version").unwrap_or_default())
}

/// The key of a name in the provenance.
fn key(name: &str) -> &'static str {
    match name {
        "scene" => "scene_hash",
        "table" => "table_hash",
        "max bounces" => "max_bounces",
        _ => "white",
    }
}

/// The names of the attributes, lamps first, with the kind of each. `lamp` gives the name for the number of a lamp.
pub(super) fn attributes(baked: &BakedScene, lamp: impl Fn(usize) -> String, sky: &str) -> Vec<(String, &'static str)> {
    let lamps = baked.lamps.iter().enumerate().map(|(number, one)| (lamp(number), one.kind));
    lamps.chain([(sky.to_owned(), "sky, and all light by way of other surfaces")]).collect()
}

/// The metadata of the snow of an object: names and values.
fn of_snow(object: &BakedObject, attributes: &[(String, &'static str)]) -> Vec<(&'static str, Value)> {
    let snow = &object.snow;
    vec![
        ("escape_polynomial", json!(snow.escape.coefficients)),
        ("escape_greatest_error", json!(snow.escape.greatest_error)),
        ("extrapolation_length", json!(snow.extrapolation)),
        ("transport_mean_free_path_m", json!(snow.transport_length_m)),
        ("greatest_edge_m", json!(snow.step_m)),
        ("glsl", json!(glsl(object, attributes))),
    ]
}

/// A line of GLSL that shades the snow of an object.
fn glsl(object: &BakedObject, attributes: &[(String, &'static str)]) -> String {
    let [k0, k1, k2, k3] = object.snow.escape.coefficients;
    let names: Vec<&str> = attributes.iter().map(|(name, _)| name.as_str()).collect();
    format!(
        "vec3 radiance = (irradiance + ({k0:.6} + mu * ({k1:.6} + mu * ({k2:.6} + mu * ({k3:.6})))) * ({})) / \
         3.14159265; // mu: cosine between normal and direction to the eye; irradiance: of all light on the surface",
        names.join(" + ")
    )
}
