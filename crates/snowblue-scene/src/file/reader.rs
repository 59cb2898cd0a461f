//! From a TOML document to a description. serde reads the tables; this file chooses by `type` and `shape` what a table
//! describes, which serde could do only without the places of errors.

use serde::Deserialize;
use snowblue_base::toml_value::{Mistake, read};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::description::light::LampKeys;
use crate::description::sky::OvercastKeys;
use crate::description::{
    CarvedDescription, EnvironmentDescription, ImprintDescription, LampDescription, LightDescription, LightSource,
    MaterialDescription, ObjectDescription, ObjectSettings, OvercastSkyDescription, ReliefDescription, ReliefKind,
    SceneDescription, ShapeDescription, SkyDescription, SnowDescription, SnowMaterialDescription, SolidDescription,
    SparkleDescription, UniformSkyDescription,
};
use snowblue_base::KeyPath;
use snowblue_base::key_path::Step;

type Read<T> = Result<T, Mistake>;

/// Reads a document.
pub(super) fn read_description(document: Spanned<DeTable>) -> Read<SceneDescription> {
    const KNOWN: [&str; 10] =
        ["gltf", "camera", "film", "integrator", "light_field", "material", "light", "environment", "sky", "object"];
    let root = document.into_inner();
    if let Some(key) = root.keys().find(|key| !KNOWN.contains(&key.get_ref().as_ref())) {
        let reason = format!("unknown table `{}`; known are {}", key.get_ref(), KNOWN.join(", "));
        return Err(Mistake { span: key.span(), reason });
    }
    let value = |name: &str| root.get(name).map(|value| (value, KeyPath::root(name)));
    let mut scene = SceneDescription::default();
    if let Some((value, path)) = value("gltf") {
        scene.gltf = Some(read(value, &path, &[])?);
    }
    if let Some((value, path)) = value("camera") {
        scene.camera = Some(read(value, &path, &[])?);
    }
    if let Some((value, path)) = value("film") {
        scene.film = read(value, &path, &[])?;
    }
    if let Some((value, path)) = value("integrator") {
        scene.integrator = read(value, &path, &[])?;
    }
    if let Some((value, path)) = value("light_field") {
        scene.light_field = read(value, &path, &[])?;
    }
    if let Some((value, path)) = value("material") {
        for (name, material) in table(value, &path)?.table {
            let (name, path) = (name.get_ref(), path.key(name.get_ref()));
            scene.materials.insert(name.to_string(), read_material(&material, &path)?);
        }
    }
    if let Some((value, path)) = value("light") {
        scene.lights = list(value, &path, read_light)?;
    }
    if let Some((value, path)) = value("environment") {
        scene.environment = Some(read_environment(value, &path)?);
    }
    if let Some((value, path)) = value("sky") {
        scene.sky = Some(read_sky(value, &path)?);
    }
    if let Some((value, path)) = value("object") {
        scene.objects = list(value, &path, read_object)?;
    }
    Ok(scene)
}

fn read_material(value: &Spanned<DeValue>, path: &KeyPath) -> Read<MaterialDescription> {
    let mut keys = table(value, path)?;
    let kind = keys.required_text("type", path)?;
    let known = ["type"];
    match kind.get_ref().as_str() {
        "diffuse" => keys.read(path, &known).map(MaterialDescription::Diffuse),
        "snow" => read_snow(keys, path).map(MaterialDescription::Snow),
        _ => Err(none_of(&kind, &path.key("type"), &["diffuse", "snow"])),
    }
}

/// Reads snow: what it is made of, its sparkle and its relief.
fn read_snow(mut keys: Keys, path: &KeyPath) -> Read<SnowMaterialDescription> {
    let sparkle = read_sparkle(&mut keys, path)?;
    let relief = read_relief(&mut keys, path)?;
    Ok(SnowMaterialDescription { snow: read_contents(keys, path)?, sparkle, relief })
}

/// Reads what snow is made of: layers, two snows and a mask, or one snow.
fn read_contents(keys: Keys, path: &KeyPath) -> Read<SnowDescription> {
    let known = ["type", SnowMaterialDescription::NAMES[0], SnowMaterialDescription::NAMES[1]];
    if keys.table.contains_key("layers") {
        keys.refuse_beside(
            "layers",
            &["snow", "grain_size_um", "ssa_m2_kg", "density_kg_m3", "mask", "between"],
            path,
        )?;
        return keys.read(path, &known).map(SnowDescription::Layers);
    }
    if keys.table.contains_key("mask") || keys.table.contains_key("between") {
        let present = if keys.table.contains_key("mask") { "mask" } else { "between" };
        keys.refuse_beside(present, &["snow", "grain_size_um", "ssa_m2_kg", "density_kg_m3"], path)?;
        return keys.read(path, &known).map(SnowDescription::Masked);
    }
    keys.read(path, &[&known[..], &["layers", "mask", "between"]].concat()).map(SnowDescription::Uniform)
}

/// Takes the sparkle of snow out of its table: whether there is any, or its table.
fn read_sparkle(keys: &mut Keys, path: &KeyPath) -> Read<Option<SparkleDescription>> {
    let [name, _] = SnowMaterialDescription::NAMES;
    let Some(value) = keys.table.remove(name) else { return Ok(None) };
    let path = path.key(name);
    match value.get_ref() {
        DeValue::Boolean(is_on) => Ok(is_on.then(SparkleDescription::default)),
        DeValue::Table(_) => read(&value, &path, &[]).map(Some),
        _ => Err(Mistake { span: value.span(), reason: format!("{path} must be true, false or a table") }),
    }
}

/// Takes the relief of snow out of its table: a kind, or its table.
fn read_relief(keys: &mut Keys, path: &KeyPath) -> Read<Option<ReliefDescription>> {
    let [_, name] = SnowMaterialDescription::NAMES;
    let Some(value) = keys.table.remove(name) else { return Ok(None) };
    let path = path.key(name);
    match value.get_ref() {
        DeValue::String(kind) => {
            let found = ReliefKind::ALL.into_iter().find(|known| known.name() == kind);
            let names = ReliefKind::ALL.map(ReliefKind::name);
            let unknown = || none_of(&Spanned::new(value.span(), kind.to_string()), &path, &names);
            found.map(|kind| Some(kind.into())).ok_or_else(unknown)
        }
        DeValue::Table(_) => read(&value, &path, &[]).map(Some),
        _ => Err(Mistake { span: value.span(), reason: format!("{path} must be a kind of snow or a table") }),
    }
}

fn read_light(value: &Spanned<DeValue>, path: &KeyPath) -> Read<LightDescription> {
    let mut keys = table(value, path)?;
    let kind = keys.required_text("type", path)?;
    let lamp = read_lamp(&mut keys, path)?;
    let known = ["type", LampKeys::NAMES[0], LampKeys::NAMES[1]];
    let keys = Spanned::new(keys.span, DeValue::Table(keys.table));
    let source = LightSource::read(kind.get_ref(), &keys, path, &known)
        .ok_or_else(|| none_of(&kind, &path.key("type"), LightSource::TYPES))??;
    Ok(LightDescription { lamp, source })
}

fn read_environment(value: &Spanned<DeValue>, path: &KeyPath) -> Read<EnvironmentDescription> {
    let mut keys = table(value, path)?;
    if keys.table.contains_key("image") {
        return keys.read(path, &[]).map(EnvironmentDescription::Image);
    }
    let lamp = read_lamp(&mut keys, path)?;
    let glow = keys.read(path, &LampKeys::NAMES)?;
    Ok(EnvironmentDescription::Uniform(UniformSkyDescription { lamp, glow }))
}

fn read_sky(value: &Spanned<DeValue>, path: &KeyPath) -> Read<SkyDescription> {
    let mut keys = table(value, path)?;
    let Some(kind) = keys.text("type", path)? else {
        return keys.read(path, &["type"]).map(SkyDescription::Clear);
    };
    match kind.get_ref().as_str() {
        "clear" => keys.read(path, &["type"]).map(SkyDescription::Clear),
        "overcast" => {
            let lamp = read_lamp(&mut keys, path)?;
            let span = keys.span.clone();
            let keys: OvercastKeys = keys.read(path, &["type", LampKeys::NAMES[0], LampKeys::NAMES[1]])?;
            let reason = || format!("{path} must have either `irradiance_w_m2` or `sun`");
            let strength = keys.strength().ok_or_else(|| Mistake { span, reason: reason() })?;
            Ok(SkyDescription::Overcast(OvercastSkyDescription { lamp, strength, visible: keys.visible }))
        }
        _ => Err(none_of(&kind, &path.key("type"), &["clear", "overcast"])),
    }
}

/// Takes the spectrum of a light out of its table.
fn read_lamp(keys: &mut Keys, path: &KeyPath) -> Read<LampDescription> {
    let lamp = keys.split(&LampKeys::NAMES);
    let span = lamp.table.get("spectrum").map_or(lamp.span.clone(), Spanned::span);
    let reason = || format!("{path} has either `illuminant` or `spectrum`, not both");
    lamp.read::<LampKeys>(path, &[])?.lamp().ok_or_else(|| Mistake { span, reason: reason() })
}

fn read_object(value: &Spanned<DeValue>, path: &KeyPath) -> Read<ObjectDescription> {
    let mut keys = table(value, path)?;
    let common = keys.split(&ObjectSettings::NAMES).read(path, &[])?;
    let imprints = keys.list("imprint", path, read_imprint)?;
    let mut known = ObjectSettings::NAMES.to_vec();
    let shape = match (keys.text("shape", path)?, keys.table.contains_key("mesh")) {
        (Some(shape), false) => {
            known.insert(0, "shape");
            match shape.get_ref().as_str() {
                "box" => keys.read(path, &known).map(ShapeDescription::Box),
                "sphere" => keys.read(path, &known).map(ShapeDescription::Sphere),
                "plane" => keys.read(path, &known).map(ShapeDescription::Plane),
                "heights" => keys.read(path, &known).map(ShapeDescription::Heights),
                "drift" => keys.read(path, &known).map(ShapeDescription::Drift),
                "snowpack" => keys.read(path, &known).map(ShapeDescription::Snowpack),
                "igloo" => keys.read(path, &known).map(ShapeDescription::Igloo),
                "carved" => read_carved(keys, path, known).map(ShapeDescription::Carved),
                _ => {
                    let shapes = ["box", "sphere", "plane", "heights", "drift", "snowpack", "igloo", "carved"];
                    Err(none_of(&shape, &path.key("shape"), &shapes))
                }
            }
        }
        (None, true) => keys.read(path, &known).map(ShapeDescription::Mesh),
        _ => Err(Mistake { span: value.span(), reason: format!("{path} must have either `shape` or `mesh`") }),
    };
    Ok(ObjectDescription { shape: shape?, common, imprints })
}

fn read_imprint(value: &Spanned<DeValue>, path: &KeyPath) -> Read<ImprintDescription> {
    let mut keys = table(value, path)?;
    let kind = keys.required_text("type", path)?;
    let known = ["type"];
    match kind.get_ref().as_str() {
        "hole" => keys.read(path, &known).map(ImprintDescription::Hole),
        "footprint" => keys.read(path, &known).map(ImprintDescription::Footprint),
        _ => Err(none_of(&kind, &path.key("type"), &["hole", "footprint"])),
    }
}

fn read_carved(mut keys: Keys, path: &KeyPath, mut known: Vec<&str>) -> Read<CarvedDescription> {
    known.extend(["add", "remove"]);
    let (add, remove) = (keys.list("add", path, read_solid)?, keys.list("remove", path, read_solid)?);
    Ok(CarvedDescription { add, remove, ..keys.read(path, &known)? })
}

fn read_solid(value: &Spanned<DeValue>, path: &KeyPath) -> Read<SolidDescription> {
    let mut keys = table(value, path)?;
    let kind = keys.required_text("type", path)?;
    let known = ["type"];
    match kind.get_ref().as_str() {
        "ellipsoid" => keys.read(path, &known).map(SolidDescription::Ellipsoid),
        "box" => keys.read(path, &known).map(SolidDescription::Box),
        "capsule" => keys.read(path, &known).map(SolidDescription::Capsule),
        "cylinder" => keys.read(path, &known).map(SolidDescription::Cylinder),
        "half_space" => keys.read(path, &known).map(SolidDescription::HalfSpace),
        _ => Err(none_of(&kind, &path.key("type"), &["ellipsoid", "box", "capsule", "cylinder", "half_space"])),
    }
}

/// The keys of a table that are still to be read.
struct Keys<'text> {
    table: DeTable<'text>,
    span: std::ops::Range<usize>,
}

impl<'text> Keys<'text> {
    /// Takes a text out.
    fn text(&mut self, key: &str, path: &KeyPath) -> Read<Option<Spanned<String>>> {
        let Some(value) = self.table.remove(key) else {
            return Ok(None);
        };
        Ok(Some(Spanned::new(value.span(), read(&value, &path.key(key), &[])?)))
    }

    /// Takes a text out that must be there.
    fn required_text(&mut self, key: &str, path: &KeyPath) -> Read<Spanned<String>> {
        let span = self.span.clone();
        self.text(key, path)?.ok_or_else(|| Mistake { span, reason: format!("{} is missing", path.key(key)) })
    }

    /// Takes the tables of an array out; none if it is not there.
    fn list<T>(
        &mut self,
        key: &str,
        path: &KeyPath,
        read: impl Fn(&Spanned<DeValue<'text>>, &KeyPath) -> Read<T>,
    ) -> Read<Vec<T>> {
        self.table.remove(key).map_or(Ok(Vec::new()), |value| list(&value, &path.key(key), read))
    }

    /// Refuses keys beside one that they have no meaning with.
    fn refuse_beside(&self, present: &str, others: &[&str], path: &KeyPath) -> Read<()> {
        match self.table.iter().find(|(key, _)| others.contains(&key.get_ref().as_ref())) {
            Some((key, _)) => {
                let reason = format!("{path} has either `{present}` or `{}`, not both", key.get_ref());
                Err(Mistake { span: key.span(), reason })
            }
            None => Ok(()),
        }
    }

    /// Takes some keys out.
    fn split(&mut self, names: &[&str]) -> Self {
        let entries = names.iter().filter_map(|name| self.table.remove_entry(*name));
        Self { table: entries.collect(), span: self.span.clone() }
    }

    /// Reads all keys that are left.
    fn read<T: Deserialize<'text>>(self, path: &KeyPath, known: &[&str]) -> Read<T> {
        read(&Spanned::new(self.span, DeValue::Table(self.table)), path, known)
    }
}

fn table<'text>(value: &Spanned<DeValue<'text>>, path: &KeyPath) -> Read<Keys<'text>> {
    match value.get_ref().as_table() {
        Some(table) => Ok(Keys { table: table.clone(), span: value.span() }),
        None => Err(Mistake { span: value.span(), reason: format!("{path} must be a table") }),
    }
}

/// Reads every table of an array like `[[light]]`.
fn list<'text, T>(
    value: &Spanned<DeValue<'text>>,
    path: &KeyPath,
    read: impl Fn(&Spanned<DeValue<'text>>, &KeyPath) -> Read<T>,
) -> Read<Vec<T>> {
    let Some(tables) = value.get_ref().as_array() else {
        let names: Vec<_> = path.steps().iter().filter_map(Step::key).collect();
        let reason = format!("{path} must be written as [[{}]]", names.join("."));
        return Err(Mistake { span: value.span(), reason });
    };
    tables.iter().enumerate().map(|(index, table)| read(table, &path.index(index))).collect()
}

fn none_of(found: &Spanned<String>, path: &KeyPath, names: &[&str]) -> Mistake {
    let reason = format!("{path} is \"{}\", but must be one of {}", found.get_ref(), names.join(", "));
    Mistake { span: found.span(), reason }
}
