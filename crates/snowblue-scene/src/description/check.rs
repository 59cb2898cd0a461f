//! The ranges of values, and the one pass that checks them.

use std::ops::RangeInclusive;

use snowblue_base::RangeError;
use snowblue_color::exposure::GREATEST_STOPS;
use snowblue_color::temperature;
use snowblue_transport::sample::{SnowKeyError, SnowKeys, SnowSample};
use snowblue_transport::{ParameterRange, TransportError, short_number};

use super::camera::CameraDescription;
use super::carved::{CarvedDescription, SolidDescription};
use super::landscape::{
    DepthDescription, GridSettings, GroundSource, HeightFieldDescription, HeightSource, ImprintDescription,
    SnowpackDescription,
};
use super::material::{
    DiffuseDescription, LayersTop, MaskDescription, MaskedSnowDescription, MaterialDescription, ReliefDescription,
    SnowDescription, SnowMaterialDescription, SparkleDescription, TextureDescription,
};
use super::object::{DriftDescription, IglooDescription, ObjectDescription, ShapeDescription};
use super::range::{COORDINATE, Checked, DIRECTION, FRACTION, GREATEST_COORDINATE_M, ROTATION, Range, unit_vector};
use super::scene::SceneDescription;
use super::value::{ColorDescription, Scale, point};
use crate::camera::{LEAST_FOCUS_M, Lens, PerspectiveCamera};
use crate::film::white_balance::WhiteBalance;
use crate::film::{Exposure, FilmSettings};
use crate::integrator::{IntegratorSettings, LightFieldSettings};
use snowblue_base::{KeyError, KeyPath};

/// Standard error of a pixel relative to its luminance.
pub const NOISE_TARGET_RANGE: ParameterRange =
    ParameterRange { quantity: "noise target", least: 1e-4, greatest: 1.0, unit: "" };
/// Size of the cells of the light field at the surface of snow, in mm.
pub const FIELD_STEP_RANGE: ParameterRange =
    ParameterRange { quantity: "step of the light field", least: 0.01, greatest: 1000.0, unit: "mm" };
/// Greatest memory of the light field, in MiB.
pub const FIELD_MEMORY_MIB: RangeInclusive<u32> = 16..=1 << 20;
/// Nodes of the light field of a body of snow.
const FIELD_NODES: RangeInclusive<u32> = 100..=100_000_000;
/// Pixels along a side of a film.
pub const SIDE_PIXELS: RangeInclusive<u32> = 1..=16_384;
/// Samples of a pixel.
pub const SAMPLES_PER_PIXEL: RangeInclusive<u32> = 1..=1 << 24;
/// Surfaces on a path after the first.
pub const BOUNCES: RangeInclusive<u32> = 0..=10_000;

const FIELD_OF_VIEW: Range = Range::new(0.1, 170.0, "deg");
/// Diameter of the aperture of a camera.
const APERTURE: Range = Range::new(0.0, 10.0, "m");
/// Distance of the plane of focus.
const FOCUS: Range = Range::new(LEAST_FOCUS_M, GREATEST_COORDINATE_M, "m");
const SHAPE_SIZE: Range = Range::new(1e-4, 1e5, "m");
/// A height above the sea or above a floor.
const HEIGHT: Range = Range::new(-1e5, 1e5, "m");
/// A coordinate of a map.
const MAP_COORDINATE: Range = Range::new(-1e8, 1e8, "m");
/// Root mean square of the heights of a relief, their correlation length and their Hurst exponent.
const RELIEF_HEIGHT: Range = Range::new(0.01, 30.0, "mm");
const RELIEF_CORRELATION: Range = Range::new(2.0, 1000.0, "mm");
const HURST: Range = Range::new(0.1, 1.0, "");
/// Greatest root mean square of the slope of a relief.
const GREATEST_SLOPE: f64 = 1.0;
const SNOW_DEPTH: Range = Range::new(-100.0, 100.0, "m");
const TAPER: Range = Range::new(0.5, 60.0, "deg");
/// Coordinates and sizes of solids of carved snow, which a mesh of single precision resolves.
const CARVED_REACH: Range = Range::new(-1000.0, 1000.0, "m");
const CARVED_SIZE: Range = Range::new(1e-4, 1000.0, "m");
const SCALE: Range = Range::new(1e-6, 1e6, "");
const TEXTURE_SCALE: Range = Range::new(1e-4, 1e5, "m");
/// Diameter of the facets of grains. Smaller ones scatter light into all directions by diffraction.
const FACET_SIZE: Range = Range::new(5.0, 5000.0, "µm");
const MASK_END: Range = Range::new(-1e9, 1e9, "");
const NOISE_TARGET: Range = Range::of(NOISE_TARGET_RANGE);
const EXPOSURE: Range = Range::new(-GREATEST_STOPS, GREATEST_STOPS, "stops");
const FIELD_STEP: Range = Range::of(FIELD_STEP_RANGE);

/// Whether a whole number lies in a range.
fn check_count(path: &KeyPath, value: u32, range: &RangeInclusive<u32>) -> Checked {
    if range.contains(&value) {
        return Ok(());
    }
    Err(path.error(format!("is {value}, but must lie in {}–{}", range.start(), range.end())))
}

impl SceneDescription {
    /// Checks every value that can be checked without the files and the table.
    ///
    /// # Errors
    ///
    /// With the place of the first value that lies out of its range.
    pub fn check(&self) -> Checked {
        if let Some(camera) = &self.camera {
            check_camera(&KeyPath::root("camera"), camera)?;
        }
        check_film(&KeyPath::root("film"), &self.film)?;
        check_integrator(&KeyPath::root("integrator"), &self.integrator)?;
        check_light_field(&KeyPath::root("light_field"), &self.light_field)?;
        for (name, material) in &self.materials {
            check_material(&KeyPath::root("material").key(name), material)?;
        }
        for (index, light) in self.lights.iter().enumerate() {
            light.check(&KeyPath::root("light").index(index))?;
        }
        if let Some(environment) = &self.environment {
            environment.check(&KeyPath::root("environment"))?;
        }
        if let Some(sky) = &self.sky {
            sky.check(&KeyPath::root("sky"))?;
        }
        for (index, object) in self.objects.iter().enumerate() {
            check_object(&KeyPath::root("object").index(index), object)?;
        }
        Ok(())
    }
}

fn check_camera(path: &KeyPath, camera: &CameraDescription) -> Checked {
    COORDINATE.check_all(&path.key("position"), &camera.position)?;
    COORDINATE.check_all(&path.key("look_at"), &camera.look_at)?;
    DIRECTION.check_all(&path.key("up"), &camera.up)?;
    FIELD_OF_VIEW.check(&path.key("vertical_fov_deg"), camera.vertical_fov_deg)?;
    APERTURE.check(&path.key("aperture"), camera.aperture)?;
    if let Some(focus) = camera.focus {
        FOCUS.check(&path.key("focus"), focus)?;
    }
    let distance_m = (camera.view().look_at - camera.view().position).length();
    if camera.aperture > 0.0 && camera.focus.is_none() && f64::from(distance_m) < LEAST_FOCUS_M {
        let reason = format!("is {distance_m} m from the camera, but a lens focuses on {LEAST_FOCUS_M} m and more");
        return Err(path.key("look_at").error(format!("{reason}: give 'focus'")));
    }
    if PerspectiveCamera::new(&camera.view(), Lens::default(), 1.0).is_none() {
        return Err(path.key("look_at").error("must not lie at the camera's position or along its up axis"));
    }
    Ok(())
}

fn check_film(path: &KeyPath, film: &FilmSettings) -> Checked {
    check_count(&path.key("width"), film.width, &SIDE_PIXELS)?;
    check_count(&path.key("height"), film.height, &SIDE_PIXELS)?;
    if let WhiteBalance::Temperature(kelvin) = film.white {
        let (least, greatest) = temperature::RANGE_K.into_inner();
        Range::new(least, greatest, "K").check(&path.key("white"), kelvin)?;
    }
    match film.exposure {
        Exposure::Auto => Ok(()),
        Exposure::Stops(stops) => EXPOSURE.check(&path.key("exposure"), stops),
    }
}

fn check_integrator(path: &KeyPath, integrator: &IntegratorSettings) -> Checked {
    check_count(&path.key("samples_per_pixel"), integrator.samples_per_pixel, &SAMPLES_PER_PIXEL)?;
    if let Some(target) = integrator.noise_target {
        NOISE_TARGET.check(&path.key("noise_target"), target)?;
    }
    if let Some(reflectance) = integrator.pcasnow.reflectance {
        FRACTION.check(&path.key("pcasnow").key("reflectance"), reflectance)?;
    }
    check_count(&path.key("max_bounces"), integrator.max_bounces, &BOUNCES)
}

fn check_light_field(path: &KeyPath, light_field: &LightFieldSettings) -> Checked {
    let [least, greatest] = [FIELD_MEMORY_MIB.start(), FIELD_MEMORY_MIB.end()].map(|end| f64::from(*end));
    Range::new(least, greatest, "MiB").check(&path.key("memory_mib"), light_field.memory_mib.into())?;
    match (light_field.step_mm, light_field.nodes) {
        (None, None) => Ok(()),
        (Some(step_mm), None) => FIELD_STEP.check(&path.key("step_mm"), step_mm),
        (None, Some(nodes)) => check_count(&path.key("nodes"), nodes, &FIELD_NODES),
        (Some(_), Some(_)) => Err(path.key("nodes").error("has no effect, since `step_mm` sets the cells")),
    }
}

fn check_material(path: &KeyPath, material: &MaterialDescription) -> Checked {
    match material {
        MaterialDescription::Diffuse(diffuse) => match diffuse {
            DiffuseDescription::Uniform { reflectance } => FRACTION.check(&path.key("reflectance"), *reflectance),
            DiffuseDescription::Color { reflectance_rgb: ColorDescription::Linear(channels) } => {
                FRACTION.check_all(&path.key("reflectance_rgb"), channels)
            }
            DiffuseDescription::Color { reflectance_rgb: ColorDescription::Encoded(_) }
            | DiffuseDescription::Spectrum { .. } => Ok(()),
            DiffuseDescription::Texture(texture) => check_texture(path, texture),
        },
        MaterialDescription::Snow(SnowMaterialDescription { snow, sparkle, relief }) => {
            check_snow(path, snow)?;
            sparkle.map_or(Ok(()), |sparkle| check_sparkle(&path.key("sparkle"), &sparkle))?;
            relief.map_or(Ok(()), |relief| check_relief(&path.key("relief"), &relief))
        }
    }
}

fn check_texture(path: &KeyPath, texture: &TextureDescription) -> Checked {
    TEXTURE_SCALE.check(&path.key("texture_scale_m"), texture.texture_scale_m)
}

fn check_snow(path: &KeyPath, snow: &SnowDescription) -> Checked {
    match snow {
        SnowDescription::Uniform(keys) => check_keys(path, keys).map(drop),
        SnowDescription::Layers(snow) => match snow.layers_top {
            LayersTop::Surface => Ok(()),
            LayersTop::Height(height_m) => COORDINATE.check(&path.key("layers_top"), height_m),
        },
        SnowDescription::Masked(MaskedSnowDescription { mask, between }) => {
            check_mask(&path.key("mask"), mask)?;
            let path = path.key("between");
            let first = check_keys(&path.index(0), &between[0])?;
            let second = check_keys(&path.index(1), &between[1])?;
            if first.grain_size.measure != second.grain_size.measure {
                return Err(path.error(
                    "has two measures of grain size, but must have one: a kind of snow and ssa_m2_kg \
                                       state optical diameters",
                ));
            }
            if first.ice != second.ice {
                return Err(path.error("has two tables of ice, but must have one"));
            }
            Ok(())
        }
    }
}

fn check_sparkle(path: &KeyPath, sparkle: &SparkleDescription) -> Checked {
    if let Some(facet_size_um) = sparkle.facet_size_um {
        FACET_SIZE.check(&path.key("facet_size_um"), facet_size_um)?;
    }
    FRACTION.check(&path.key("flat_fraction"), sparkle.flat_fraction)
}

fn check_relief(path: &KeyPath, relief: &ReliefDescription) -> Checked {
    let ReliefDescription { height_mm, correlation_mm, hurst, seed: _ } = *relief;
    RELIEF_HEIGHT.check(&path.key("height_mm"), height_mm)?;
    RELIEF_CORRELATION.check(&path.key("correlation_mm"), correlation_mm)?;
    HURST.check(&path.key("hurst"), hurst)?;
    let slope = relief.roughness().slope();
    if slope <= GREATEST_SLOPE {
        return Ok(());
    }
    let [height, correlation, hurst] = [height_mm, correlation_mm, hurst].map(short_number);
    let most = short_number((height_mm * GREATEST_SLOPE / slope * 100.0).floor() / 100.0);
    Err(path.key("height_mm").error(format!(
        "is {height} mm, but must be at most {most} mm for a correlation_mm of {correlation} and a hurst of {hurst}: \
         its slope is then {GREATEST_SLOPE} on average (root mean square)"
    )))
}

fn check_keys(path: &KeyPath, keys: &SnowKeys) -> Result<SnowSample, KeyError> {
    keys.sample().map_err(|SnowKeyError { key, impurity, error }| {
        let path = path.key(key);
        match (impurity, error) {
            (Some(name), TransportError::Unknown { known, .. }) => {
                path.key(&name).error(format!("is an unknown impurity; known are {known}"))
            }
            (Some(name), error) => path.key(&name).error(rest_of_sentence(&error)),
            (None, error) => path.error(rest_of_sentence(&error)),
        }
    })
}

/// An error about a quantity as the rest of a sentence that begins with its key.
fn rest_of_sentence(error: &TransportError) -> String {
    let sentence = error.to_string();
    let quantity = match error {
        TransportError::Range(RangeError::OutOfRange { quantity, .. } | RangeError::Reversed { quantity, .. })
        | TransportError::Count { quantity, .. }
        | TransportError::Combination { quantity, .. } => *quantity,
        TransportError::MeanSize { .. } => "mean grain size",
        TransportError::Unknown { name, known, .. } => return format!("is \"{name}\", but must be one of {known}"),
        _ => return format!("is wrong: {sentence}"),
    };
    sentence.strip_prefix(quantity).unwrap_or(&sentence).trim_start().to_owned()
}

fn check_mask(path: &KeyPath, mask: &MaskDescription) -> Checked {
    match mask {
        MaskDescription::Texture(texture) => check_texture(path, texture),
        MaskDescription::Attribute { range, .. } => {
            let path = path.key("range");
            MASK_END.check_all(&path, range)?;
            if (range[1] - range[0]).abs() <= 0.0 {
                return Err(path.error(format!("is {} twice, but must have two ends", range[0])));
            }
            Ok(())
        }
    }
}

fn check_object(path: &KeyPath, object: &ObjectDescription) -> Checked {
    let common = &object.common;
    COORDINATE.check_all(&path.key("position"), &common.position)?;
    ROTATION.check_all(&path.key("rotation_deg"), &common.rotation_deg)?;
    match common.scale {
        Scale::Uniform(scale) => SCALE.check(&path.key("scale"), scale)?,
        Scale::Axes(scales) => SCALE.check_all(&path.key("scale"), &scales)?,
    }
    for (index, imprint) in object.imprints.iter().enumerate() {
        check_imprint(&path.key("imprint").index(index), imprint)?;
    }
    match &object.shape {
        ShapeDescription::Box(_)
        | ShapeDescription::Sphere(_)
        | ShapeDescription::Plane(_)
        | ShapeDescription::Igloo(_)
        | ShapeDescription::Mesh(_)
        | ShapeDescription::Snowpack(SnowpackDescription { ground: GroundSource::Mesh { .. }, .. })
            if !object.imprints.is_empty() =>
        {
            Err(path.key("imprint").error("needs a surface of heights: heights, drift, or snowpack on heights"))
        }
        ShapeDescription::Box(cuboid) => SHAPE_SIZE.check_all(&path.key("size"), &cuboid.size),
        ShapeDescription::Sphere(sphere) => SHAPE_SIZE.check(&path.key("radius"), sphere.radius),
        ShapeDescription::Plane(_) if common.scale != Scale::default() => {
            Err(path.key("scale").error("does not apply to a plane, which is infinite"))
        }
        ShapeDescription::Plane(_) | ShapeDescription::Mesh(_) => Ok(()),
        ShapeDescription::Heights(heights) => check_height_field(path, heights),
        ShapeDescription::Drift(drift) => check_drift(path, drift),
        ShapeDescription::Snowpack(snowpack) => check_snowpack(path, snowpack),
        ShapeDescription::Igloo(igloo) => check_igloo(path, igloo),
        ShapeDescription::Carved(carved) => check_carved(path, carved),
    }
}

fn check_height_field(path: &KeyPath, heights: &HeightFieldDescription) -> Checked {
    check_grid(path, &heights.grid)?;
    if let Some(bottom) = heights.bottom {
        COORDINATE.check(&path.key("bottom"), bottom)?;
    }
    let HeightSource::Rows { heights: rows } = &heights.source else { return Ok(()) };
    check_rows(path, rows, &heights.grid)?;
    heights.bottom.map(drop).ok_or_else(|| path.key("bottom").error("is missing"))
}

fn check_grid(path: &KeyPath, grid: &GridSettings) -> Checked {
    if let Some(size) = grid.size {
        SHAPE_SIZE.check_all(&path.key("size"), &size)?;
    }
    for (key, height) in [("datum", grid.datum), ("fill", grid.fill)] {
        height.map_or(Ok(()), |height| HEIGHT.check(&path.key(key), height))?;
    }
    if let Some(crop) = grid.crop {
        let path = path.key("crop");
        MAP_COORDINATE.check_all(&path.key("centre"), &crop.centre)?;
        SHAPE_SIZE.check_all(&path.key("size"), &crop.size)?;
    }
    grid.tolerance.map_or(Ok(()), |tolerance| Range::new(0.0, 1e4, "m").check(&path.key("tolerance"), tolerance))
}

fn check_rows(path: &KeyPath, heights: &[Vec<f64>], grid: &GridSettings) -> Checked {
    if heights.windows(2).any(|pair| pair[0].len() != pair[1].len()) {
        return Err(path.key("heights").error("must be a list of lists of numbers, all of one length"));
    }
    grid.size.map(drop).ok_or_else(|| path.key("size").error("is missing"))
}

fn check_drift(path: &KeyPath, drift: &DriftDescription) -> Checked {
    SHAPE_SIZE.check_all(&path.key("size"), &drift.size)?;
    let path_to_mounds = path.key("mounds");
    for (index, mound) in drift.mounds.iter().enumerate() {
        let numbers = [mound.x, mound.y, mound.height, mound.radius];
        if !numbers.iter().all(|number| number.is_finite()) || mound.height <= 0.0 || mound.radius <= 0.0 {
            let reason = "must be x, y, height and radius in m, the last two above 0";
            return Err(path_to_mounds.index(index).error(reason));
        }
    }
    Range::new(0.0, 1.0, "m").check(&path.key("relief"), drift.relief)
}

fn check_snowpack(path: &KeyPath, snowpack: &SnowpackDescription) -> Checked {
    let is_mesh = match &snowpack.ground {
        GroundSource::Rows { heights, grid } => {
            check_grid(path, grid)?;
            check_rows(path, heights, grid)?;
            false
        }
        GroundSource::Heights { grid, .. } => {
            check_grid(path, grid)?;
            false
        }
        GroundSource::Mesh { .. } => true,
    };
    Range::new(0.0, 1.0, "m").check(&path.key("least_depth"), snowpack.least_depth)?;
    if let Some(gap) = snowpack.gap {
        Range::new(0.0, 10.0, "m").check(&path.key("gap"), gap)?;
    }
    let path = path.key("depth");
    match &snowpack.depth {
        DepthDescription::Uniform(depth) => Range::new(1e-3, SNOW_DEPTH.0.greatest, "m").check(&path, *depth),
        DepthDescription::Attribute { .. } if !is_mesh => {
            Err(path.error("is an attribute, but the ground is no mesh and has none"))
        }
        DepthDescription::Texture { range, .. } | DepthDescription::Attribute { range, .. } => {
            SNOW_DEPTH.check_all(&path.key("range"), range)
        }
    }
}

fn check_imprint(path: &KeyPath, imprint: &ImprintDescription) -> Checked {
    COORDINATE.check_all(&path.key("position"), &imprint.position())?;
    let depth = Range::new(1e-3, 10.0, "m");
    let (rim, rim_width, taper_deg) = match imprint {
        ImprintDescription::Hole(hole) => {
            Range::new(1e-3, 10.0, "m").check(&path.key("radius"), hole.radius)?;
            depth.check(&path.key("depth"), hole.depth)?;
            TAPER.check(&path.key("taper_deg"), hole.taper_deg)?;
            let wall = hole.depth * hole.taper_deg.to_radians().tan();
            if wall > hole.radius {
                let reason = format!("is {} deg, which closes the hole above its depth", hole.taper_deg);
                return Err(path.key("taper_deg").error(reason));
            }
            (hole.rim, hole.rim_width, hole.taper_deg)
        }
        ImprintDescription::Footprint(footprint) => {
            ROTATION.check(&path.key("heading_deg"), footprint.heading_deg)?;
            Range::new(0.05, 1.0, "m").check(&path.key("length"), footprint.length)?;
            depth.check(&path.key("depth"), footprint.depth)?;
            let toe_depth = footprint.toe_depth.unwrap_or(footprint.depth);
            depth.check(&path.key("toe_depth"), toe_depth)?;
            Range::new(0.0, footprint.depth.min(toe_depth), "m").check(&path.key("tread"), footprint.tread)?;
            (footprint.rim, footprint.rim_width, footprint.taper_deg)
        }
    };
    TAPER.check(&path.key("taper_deg"), taper_deg)?;
    Range::new(0.0, 1.0, "m").check(&path.key("rim"), rim)?;
    rim_width.map_or(Ok(()), |width| Range::new(1e-3, 10.0, "m").check(&path.key("rim_width"), width))
}

fn check_igloo(path: &KeyPath, igloo: &IglooDescription) -> Checked {
    Range::new(0.5, 10.0, "m").check(&path.key("inner_radius"), igloo.inner_radius)?;
    Range::new(0.02, 0.5 * igloo.inner_radius, "m").check(&path.key("wall"), igloo.wall)?;
    check_count(&path.key("courses"), igloo.courses, &(2..=20))?;
    Range::new(0.1, igloo.inner_radius, "m").check(&path.key("block_width"), igloo.block_width)?;
    if let Some(depth) = igloo.seam_depth {
        // The relief must not break through a seam.
        Range::new(0.0, 0.4 * igloo.wall, "m").check(&path.key("seam_depth"), depth)?;
    }
    Range::new(0.005, 0.5, "m").check(&path.key("seam_width"), igloo.seam_width)
}

fn check_carved(path: &KeyPath, carved: &CarvedDescription) -> Checked {
    CARVED_SIZE.check(&path.key("cell"), carved.cell)?;
    Range::new(0.0, CARVED_REACH.0.greatest, "m").check(&path.key("rounding"), carved.rounding)?;
    if carved.relief > 0.0 {
        // Shorter unevenness would fall between the vertices.
        let length = Range::new(2.0 * carved.cell, CARVED_REACH.0.greatest, "m");
        length.check(&path.key("relief_length"), carved.relief_length)?;
    }
    // Higher unevenness would come apart.
    Range::new(0.0, 0.25 * carved.relief_length, "m").check(&path.key("relief"), carved.relief)?;
    let path_to_add = path.key("add");
    if carved.add.is_empty() {
        return Err(path_to_add.error("is empty, but must have at least one solid"));
    }
    for (index, solid) in carved.add.iter().enumerate() {
        let path = path_to_add.index(index);
        if matches!(solid, SolidDescription::HalfSpace(_)) {
            return Err(path.key("type").error("is \"half_space\", which has no end and can only be removed"));
        }
        check_solid(&path, solid)?;
    }
    let path_to_remove = path.key("remove");
    carved.remove.iter().enumerate().try_for_each(|(index, solid)| check_solid(&path_to_remove.index(index), solid))
}

fn check_solid(path: &KeyPath, solid: &SolidDescription) -> Checked {
    let reach = |key: &str, coordinates: &[f64; 3]| CARVED_REACH.check_all(&path.key(key), coordinates);
    let size = |key: &str, sizes: &[f64]| CARVED_SIZE.check_all(&path.key(key), sizes);
    let rotation = |angles: &[f64; 3]| ROTATION.check_all(&path.key("rotation_deg"), angles);
    let edge = |edge: f64, greatest: f64| Range::new(0.0, greatest, "m").check(&path.key("edge"), edge);
    let apart = |from: &[f64; 3], to: &[f64; 3]| {
        let axis = point(*to) - point(*from);
        unit_vector(&path.key("to"), axis, "must not be the point `from`").map(drop)
    };
    match solid {
        SolidDescription::Ellipsoid(ellipsoid) => {
            reach("centre", &ellipsoid.centre)?;
            size("radii", &ellipsoid.radii)?;
            rotation(&ellipsoid.rotation_deg)
        }
        SolidDescription::Box(cuboid) => {
            reach("centre", &cuboid.centre)?;
            size("size", &cuboid.size)?;
            rotation(&cuboid.rotation_deg)?;
            edge(cuboid.edge, 0.5 * cuboid.size.iter().copied().fold(f64::INFINITY, f64::min))
        }
        SolidDescription::Capsule(capsule) => {
            reach("from", &capsule.from)?;
            reach("to", &capsule.to)?;
            size("radius", &capsule.radius.ends())?;
            apart(&capsule.from, &capsule.to)
        }
        SolidDescription::Cylinder(cylinder) => {
            reach("from", &cylinder.from)?;
            reach("to", &cylinder.to)?;
            size("radius", &[cylinder.radius])?;
            apart(&cylinder.from, &cylinder.to)?;
            let half = 0.5 * f64::from(point(cylinder.from).distance(point(cylinder.to)));
            edge(cylinder.edge, half.min(cylinder.radius))
        }
        SolidDescription::HalfSpace(half_space) => {
            reach("point", &half_space.point)?;
            DIRECTION.check_all(&path.key("normal"), &half_space.normal)?;
            let reason = "is [0, 0, 0], but must not be zero";
            unit_vector(&path.key("normal"), point(half_space.normal), reason).map(drop)
        }
    }
}
