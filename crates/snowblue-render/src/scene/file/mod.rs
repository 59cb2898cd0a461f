//! Scenes from TOML files: metres, degrees, watts; z is up unless the camera says otherwise.
//!
//! ```toml
//! [camera]                 # position, look_at, up = [0, 0, 1], vertical_fov_deg = 40
//! [film]                   # width = 1080, height = 1080, exposure = "auto" or stops
//! [integrator]             # samples_per_pixel = 64, max_bounces = 8, seed = 1, type = "pcasnow" | "reference"
//! [material.NAME]          # type = "diffuse": one of reflectance = 0.5,
//!                          #   reflectance_rgb = [r, g, b] (linear sRGB) or "#rrggbb" (encoded sRGB),
//!                          #   reflectance_spectrum = "FILE.csv" (wavelength_nm,value),
//!                          #   texture = "FILE.png" (encoded sRGB), texture_scale_m = 1
//!                          # type = "pca_snow": grain_size_um, facetness, density_kg_m3,
//!                          #   where the table has axes of them: water_saturation = 0, temperature_c = -5,
//!                          #   impurities_ng_g = { black-carbon = 0, … }; each one value, or two with
//!                          #   mask = { texture = "FILE.png", texture_scale_m = 1 } or
//!                          #   mask = { attribute = "NAME", range = [0, 1] },
//!                          #   path = "brightest" | "normal" | "light" | "view", exit = "last" | "first",
//!                          #   emission = "transmitted" | "relative", reflectance (else the table's)
//! [[light]]                # illuminant = "D65" or spectrum = "FILE.csv" (wavelength_nm,value), and
//!                          # type = "point": position, radiant_intensity_w_sr
//!                          # type = "spot": position, look_at, radiant_intensity_w_sr, inner_cone_deg = 0,
//!                          #   outer_cone_deg = 45
//!                          # type = "directional": direction (in which it shines), irradiance_w_m2
//!                          # type = "sphere": position, radius, radiance_w_m2_sr, visible = true
//!                          # type = "rectangle": position, look_at, up = [0, 0, 1], size (width, height),
//!                          #   radiance_w_m2_sr, visible = true
//! [environment]            # radiance_w_m2_sr, illuminant or spectrum, visible = true; or
//!                          # image = "FILE.exr", scale = 1, rotation_deg = 0 (about z), visible = true
//! [[object]]               # shape = "box": size; shape = "sphere": radius; shape = "plane";
//!                          # shape = "heights": size, heights = [[…], …] or file = "FILE.png" | "FILE.exr", bottom;
//!                          # shape = "drift": size (x, y, depth), mounds = [[x, y, height, radius], …], relief = 0, seed = 1;
//!                          # shape = "igloo": inner_radius = 1.5, wall = 0.15, courses = 6, block_width = 0.6,
//!                          #   seam_depth = wall / 4, seam_width = 0.05, seed = 1;
//!                          # or mesh = "FILE.ply" | "FILE.obj" | "FILE.glb" | "FILE.gltf": part, up = "y" | "z"
//!                          # scale = 1 or [1, 1, 1], position = [0, 0, 0], rotation_deg = [0, 0, 0], material, body
//! gltf = "FILE.glb"        # all its meshes and lights, and its camera where there is no [camera]; before all tables
//! ```
//!
//! Boxes and spheres are placed by their centre, a mesh by its own origin, a plane by any point of it; a plane is level,
//! facing z, until it is turned. Rotations are about x, then y, then z, each counter-clockwise seen from the axis' tip;
//! scale comes before rotation, position after. All files are looked for beside the scene file. glTF has y upwards and
//! is turned to z; `up` says so, or not, for single meshes. `part` is an object or group of an OBJ file, a node or mesh
//! of a glTF. A glTF's materials are those of the scene file under the same names, and else diffuse, of their
//! base colour. Heights, row by row from far to near, rise `size`'s third number each, from a `bottom` that closes the
//! solid. A drift is snow of a depth below z = 0, with mounds above it. An igloo is one object for each block, all of one body.
//! Snow objects of one `body` are one solid. Where a picture lies on a shape is told in
//! [`surface_texture`](crate::scene::material::texture), what a mask does in [`snow_curves`](crate::scene::material::snow_curves).

mod gltf_scene;
mod lights;
mod materials;
mod placing;
mod section;
mod snow;
mod things;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use glam::Vec3A;
use snowblue_database::CompressedTable;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::RenderError;
use crate::film::exposure::{Exposure, FilmSettings};
use crate::film::sensor::{FalseColor, Sensor};
use crate::geometry::ray::narrow;
use crate::scene::camera::{PinholeCamera, View};
use crate::scene::material::pca_snow::PathMode;
use crate::scene::objects::Objects;
use crate::scene::{IntegratorKind, IntegratorSettings, Scene};

use gltf_scene::{GltfScene, read_gltf};
use lights::{read_environment, read_light};
use materials::{Named, Workshop, read_materials, read_volumes};
use section::{SceneText, Section};
use things::{Meshes, read_object, snow_around};

/// Greatest coordinate of anything in a scene, in m.
const GREATEST_COORDINATE_M: f64 = 1e5;
/// Most pixels along a side.
const GREATEST_SIDE: u32 = 16_384;
/// Most samples of a pixel.
const GREATEST_SAMPLES: u32 = 1 << 24;
/// Most surfaces on a path after the first.
const GREATEST_BOUNCES: u32 = 10_000;
/// Greatest exposure, in stops.
pub const GREATEST_STOPS: f64 = 100.0;

/// Settings from outside that replace those of the file; `None` leaves the file's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Overrides {
    /// How light finds its way through snow.
    pub integrator: Option<IntegratorKind>,
    /// The path through all snow of the scene.
    pub path: Option<PathMode>,
    /// Pixels from left to right.
    pub width: Option<u32>,
    /// Pixels from top to bottom.
    pub height: Option<u32>,
    /// Brightness of the PNG.
    pub exposure: Option<Exposure>,
    /// Paths per pixel.
    pub samples_per_pixel: Option<u32>,
    /// Surfaces after the first one that a path may visit.
    pub max_bounces: Option<u32>,
    /// Which random numbers.
    pub seed: Option<u32>,
    /// Three wavelengths of the table as red, green and blue, instead of what an eye sees; lights are then white.
    pub false_color: Option<FalseColor>,
}

type Read<T> = Result<T, RenderError>;

impl Scene {
    /// Reads a scene file and the meshes it names; snow takes its curves from `table`.
    ///
    /// # Errors
    ///
    /// When a file is missing or malformed, a key is unknown or missing, a value is out of range, or the table has no
    /// such snow. The message names the file and the line.
    pub fn load(path: &Path, table: &CompressedTable, overrides: &Overrides) -> Read<Self> {
        let text =
            std::fs::read_to_string(path).map_err(|source| RenderError::ReadFile { path: path.into(), source })?;
        Self::parse(SceneText { path, text: &text }, table, overrides)
    }

    /// Reads a scene from its text; files that it names are looked for beside `path`, which errors name.
    ///
    /// # Errors
    ///
    /// As those of [`load`](Self::load).
    pub fn from_text(
        text: &str,
        path: &Path,
        table: &CompressedTable,
        overrides: &Overrides,
    ) -> Result<Self, RenderError> {
        Self::parse(SceneText { path, text }, table, overrides)
    }

    fn parse(source: SceneText, table: &CompressedTable, overrides: &Overrides) -> Read<Self> {
        let root = DeTable::parse(source.text)
            .map_err(|error| source.error(&error.span().unwrap_or(0..0), error.message()))?;
        let place = root.span();
        let root = root.into_inner();
        check_tables(source, &root)?;
        let mut film = FilmSettings { width: 1080, height: 1080, exposure: Exposure::Auto };
        let mut integrator =
            IntegratorSettings { kind: IntegratorKind::PcaSnow, samples_per_pixel: 64, max_bounces: 8, seed: 1 };
        if let Some(value) = root.get("film") {
            film = read_film(Section::new(source, "film".into(), value)?, film)?;
        }
        if let Some(value) = root.get("integrator") {
            integrator = read_integrator(Section::new(source, "integrator".into(), value)?, integrator)?;
        }
        replace(&mut film, &mut integrator, overrides)?;
        let aspect = film.width as f32 / film.height as f32;
        let sensor = match overrides.false_color {
            None => Sensor::cie_1931(),
            Some(colour) => Sensor::false_color(colour, &table.axes.wavelengths_nm)?,
        };
        let workshop = Workshop::new(source.path, table, overrides);
        let mut materials = read_materials(source, &root, &workshop)?;
        let volumes = match integrator.kind {
            IntegratorKind::PcaSnow => Vec::new(),
            IntegratorKind::Reference => read_volumes(source, &root, &workshop)?,
        };
        let mut lights = list(source, &root, "light", |section| read_light(&section, source.path, overrides))?;
        if let Some(value) = root.get("environment") {
            let section = Section::new(source, "environment".into(), value)?;
            lights.push(read_environment(&section, source.path, overrides)?);
        }
        let objects = list(source, &root, "object", {
            let mut meshes = Meshes::default();
            let materials = &materials;
            move |section| read_object(&section, source.path, materials, &mut meshes)
        })?;
        let gltf = read_gltf_of(source, &root, &mut materials, &workshop)?;
        lights.extend(gltf.lights);
        if lights.is_empty() {
            return Err(source.error(&place, "the scene has no light: neither [[light]] nor [environment]"));
        }
        let objects = Objects::new(objects.into_iter().flatten().chain(gltf.objects).collect());
        if let Some(body) = body_of_two(&objects).filter(|_| integrator.kind == IntegratorKind::Reference) {
            let reason = format!("the objects of body \"{body}\" are of several materials; the reference takes one");
            return Err(source.error(&root.get("object").map_or(0..0, Spanned::span), reason));
        }
        let camera = read_view(source, &root, gltf.view)?;
        if let Some(index) = snow_around(&objects, &materials, camera.view.position) {
            let name = &objects.list()[index].name;
            return Err(source.error(&camera.place, format!("camera.position lies inside the snow of \"{name}\"")));
        }
        let camera = PinholeCamera::new(&camera.view, aspect).ok_or_else(|| {
            source.error(&camera.aim_place, "camera.look_at must lie off the camera's position and up axis")
        })?;
        Ok(Self {
            camera,
            objects,
            materials: materials.into_iter().map(|(_, material)| material).collect(),
            lights,
            film,
            integrator,
            sensor,
            volumes,
        })
    }
}

/// Refuses tables that no scene has.
fn check_tables(source: SceneText, root: &DeTable) -> Read<()> {
    const KNOWN: [&str; 8] = ["camera", "film", "integrator", "material", "light", "environment", "object", "gltf"];
    match root.iter().find(|(key, _)| !KNOWN.contains(&key.get_ref().as_ref())) {
        Some((key, _)) => Err(source.error(&key.span(), format!("unknown table `{}`", key.get_ref()))),
        None => Ok(()),
    }
}

/// A body whose objects differ in material.
fn body_of_two(objects: &Objects) -> Option<&str> {
    let mut materials = BTreeMap::new();
    let named = objects.list().iter().filter_map(|object| Some((object.body.as_deref()?, object.material)));
    named
        .filter(|(body, material)| materials.entry(*body).or_insert(*material) != material)
        .map(|(body, _)| body)
        .next()
}

/// What the glTF of a scene adds to it; nothing where there is none.
fn read_gltf_of(source: SceneText, root: &DeTable, materials: &mut Vec<Named>, workshop: &Workshop) -> Read<GltfScene> {
    let Some(value) = root.get("gltf") else {
        return Ok(GltfScene::default());
    };
    let Some(name) = value.get_ref().as_str() else {
        return Err(source.error(&value.span(), "`gltf` must be the name of a file in quotes"));
    };
    let file = source.path.with_file_name(name);
    if !file.is_file() {
        return Err(source.error(&value.span(), format!("glTF file {} does not exist", file.display())));
    }
    read_gltf(&file, materials, workshop)
}

/// A view, and where in the file its position and its aim stand.
struct PlacedView {
    view: View,
    place: Range<usize>,
    aim_place: Range<usize>,
}

fn read_view(source: SceneText, root: &DeTable, gltf_view: Option<View>) -> Read<PlacedView> {
    let Some(camera) = root.get("camera") else {
        let place = root.get("gltf").map_or(0..0, Spanned::span);
        let reason = "the table [camera] is missing, and there is no glTF with a perspective camera";
        let view = gltf_view.ok_or_else(|| source.error(&place, reason))?;
        return Ok(PlacedView { view, place: place.clone(), aim_place: place });
    };
    let section = Section::new(source, "camera".into(), camera)?;
    section.only(&["position", "look_at", "up", "vertical_fov_deg"])?;
    let anywhere = -GREATEST_COORDINATE_M..=GREATEST_COORDINATE_M;
    let view = View {
        position: section.vector("position", None, anywhere.clone(), "m")?,
        look_at: section.vector("look_at", None, anywhere, "m")?,
        up: section.vector("up", Some(Vec3A::Z), -1e6..=1e6, "")?,
        vertical_fov_deg: narrow(section.number("vertical_fov_deg", Some(40.0), 0.1..=170.0, "deg")?),
    };
    Ok(PlacedView { view, place: section.place_of("position"), aim_place: section.place_of("look_at") })
}

fn read_film(section: Section, defaults: FilmSettings) -> Read<FilmSettings> {
    section.only(&["width", "height", "exposure"])?;
    let exposure = if section.is_text("exposure") {
        section.choice("exposure", Exposure::Auto, &[("auto", Exposure::Auto)])?
    } else if section.has("exposure") {
        Exposure::Stops(section.number("exposure", None, -GREATEST_STOPS..=GREATEST_STOPS, "stops")?)
    } else {
        section.choice("exposure", defaults.exposure, &[])?
    };
    let film = FilmSettings {
        width: section.count("width", defaults.width, 1..=GREATEST_SIDE)?,
        height: section.count("height", defaults.height, 1..=GREATEST_SIDE)?,
        exposure,
    };
    Ok(film)
}

fn read_integrator(section: Section, defaults: IntegratorSettings) -> Read<IntegratorSettings> {
    section.only(&["type", "samples_per_pixel", "max_bounces", "seed"])?;
    let integrators = IntegratorKind::ALL.map(|kind| (kind.name(), kind));
    let integrator = IntegratorSettings {
        kind: section.choice("type", defaults.kind, &integrators)?,
        samples_per_pixel: section.count("samples_per_pixel", defaults.samples_per_pixel, 1..=GREATEST_SAMPLES)?,
        max_bounces: section.count("max_bounces", defaults.max_bounces, 0..=GREATEST_BOUNCES)?,
        seed: section.count("seed", defaults.seed, 0..=u32::MAX)?,
    };
    Ok(integrator)
}

/// Reads every table of an array like `[[light]]`; none at all is an empty list.
fn list<'text, T>(
    source: SceneText<'text>,
    root: &'text DeTable<'text>,
    name: &str,
    mut read: impl FnMut(Section<'text>) -> Read<T>,
) -> Read<Vec<T>> {
    let Some(value) = root.get(name) else {
        return Ok(Vec::new());
    };
    let Some(tables) = value.get_ref().as_array() else {
        return Err(source.error(&value.span(), format!("`{name}` must be written as [[{name}]]")));
    };
    let section = |table: &'text Spanned<DeValue<'text>>| Section::new(source, name.into(), table);
    tables.iter().map(|table| read(section(table)?)).collect()
}

/// Puts the settings from outside in place of the file's.
fn replace(film: &mut FilmSettings, integrator: &mut IntegratorSettings, overrides: &Overrides) -> Read<()> {
    let settings = [
        ("width", &mut film.width, overrides.width, 1..=GREATEST_SIDE),
        ("height", &mut film.height, overrides.height, 1..=GREATEST_SIDE),
        ("samples per pixel", &mut integrator.samples_per_pixel, overrides.samples_per_pixel, 1..=GREATEST_SAMPLES),
        ("bounces", &mut integrator.max_bounces, overrides.max_bounces, 0..=GREATEST_BOUNCES),
        ("seed", &mut integrator.seed, overrides.seed, 0..=u32::MAX),
    ];
    for (name, setting, value, range) in settings {
        let Some(value) = value else { continue };
        if !range.contains(&value) {
            let (low, high) = range.into_inner();
            return Err(RenderError::Override(format!("{name} is {value}, but must lie in {low}–{high}")));
        }
        *setting = value;
    }
    integrator.kind = overrides.integrator.unwrap_or(integrator.kind);
    if let Some(exposure) = overrides.exposure {
        if let Exposure::Stops(stops) = exposure
            && !(-GREATEST_STOPS..=GREATEST_STOPS).contains(&stops)
        {
            let reason =
                format!("exposure is {stops} stops, but must lie in -{GREATEST_STOPS} to {GREATEST_STOPS} stops");
            return Err(RenderError::Override(reason));
        }
        film.exposure = exposure;
    }
    Ok(())
}
