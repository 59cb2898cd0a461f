//! What a picture is made from, in a few words: parts can be added up only if these agree.

use std::fmt;
use std::path::Path;

use snowblue_database::CompressedTable;
use toml::de::{DeTable, DeValue};

use crate::error::RenderError;
use crate::scene::Scene;
use crate::scene::file::Overrides;
use crate::scene::material::pca_snow::PathMode;

/// Names and values of all that a picture's samples depend on: the version of this library, the content of the scene and of
/// the files that it names, the table, and the settings that replace those of the scene. How many samples there are, and
/// the exposure of a PNG, are no part of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance(Vec<(String, String)>);

impl Provenance {
    /// What a scene was loaded from.
    ///
    /// # Errors
    ///
    /// When a file cannot be read any more.
    pub fn of(scene: &Scene, path: &Path, table: &CompressedTable, overrides: &Overrides) -> Result<Self, RenderError> {
        let colours = match overrides.false_color {
            None => "as seen".to_owned(),
            Some(colour) => format!("{} {} {} nm", colour.red_nm, colour.green_nm, colour.blue_nm),
        };
        let integrator = &scene.integrator;
        let entries = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("scene", format!("{:016x}", scene_hash(path)?)),
            ("table", format!("{:016x}", table_hash(table))),
            ("width", scene.film.width.to_string()),
            ("height", scene.film.height.to_string()),
            ("seed", integrator.seed.to_string()),
            ("max bounces", integrator.max_bounces.to_string()),
            ("integrator", integrator.kind.name().to_owned()),
            ("path", overrides.path.map_or("scene's", PathMode::name).to_owned()),
            ("colours", colours),
        ];
        Ok(Self(entries.map(|(name, value)| (name.to_owned(), value)).into()))
    }

    /// A value by its name.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(one, _)| one == name).map(|(_, value)| &**value)
    }

    /// The first difference to another, in words; none if both are the same.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let (name, value) = self.0.iter().find(|(name, value)| other.get(name) != Some(value))?;
        // Their values are hashes, which say nothing to a reader.
        match &**name {
            "scene" => return Some("the scene, or a file that it names, has another content".to_owned()),
            "table" => return Some("the table has another content".to_owned()),
            _ => {}
        }
        Some(format!("{name} is {value} in one and {} in the other", other.get(name).unwrap_or("not told")))
    }

    /// Reads what [`Display`](fmt::Display) wrote; a line without a colon is left out.
    pub(crate) fn parse(text: &str) -> Self {
        let entry = |line: &str| line.split_once(": ").map(|(name, value)| (name.to_owned(), value.to_owned()));
        Self(text.lines().filter_map(entry).collect())
    }
}

impl fmt::Display for Provenance {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let lines: Vec<String> = self.0.iter().map(|(name, value)| format!("{name}: {value}")).collect();
        formatter.write_str(&lines.join("\n"))
    }
}

/// The hash of a scene's text and of all files that it names, and of those that these name.
fn scene_hash(path: &Path) -> Result<u64, RenderError> {
    let bytes = read(path)?;
    let mut hash = Hash::new();
    hash.add(&bytes);
    if let Ok(text) = std::str::from_utf8(&bytes)
        && let Ok(table) = DeTable::parse(text)
    {
        let mut names = Vec::new();
        table.get_ref().values().for_each(|value| texts(value.get_ref(), &mut names));
        for name in names {
            add_file(&mut hash, &path.with_file_name(name))?;
        }
    }
    Ok(hash.0)
}

/// All texts of a scene; those that are names of files are not told from others.
fn texts(value: &DeValue, into: &mut Vec<String>) {
    match value {
        DeValue::String(text) => into.push(text.to_string()),
        DeValue::Array(values) => values.iter().for_each(|value| texts(value.get_ref(), into)),
        DeValue::Table(table) => table.values().for_each(|value| texts(value.get_ref(), into)),
        _ => {}
    }
}

/// Adds the content of a file, if it is one, and of a glTF the files beside it.
fn add_file(hash: &mut Hash, path: &Path) -> Result<(), RenderError> {
    if !path.is_file() {
        return Ok(());
    }
    let bytes = read(path)?;
    // Where a file ends is part of what it says.
    hash.add(&(bytes.len() as u64).to_le_bytes());
    hash.add(&bytes);
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gltf"))
        && let Ok(file) = gltf::Gltf::from_slice_without_validation(&bytes)
    {
        let buffers = file.buffers().filter_map(|buffer| match buffer.source() {
            gltf::buffer::Source::Uri(uri) => Some(uri),
            gltf::buffer::Source::Bin => None,
        });
        let images = file.images().filter_map(|image| match image.source() {
            gltf::image::Source::Uri { uri, .. } => Some(uri),
            gltf::image::Source::View { .. } => None,
        });
        // What is written into the file itself is no name of another, and stands for itself.
        for uri in buffers.chain(images).filter(|uri| !uri.starts_with("data:")) {
            add_file(hash, &path.with_file_name(uri.replace("%20", " ")))?;
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<Vec<u8>, RenderError> {
    std::fs::read(path).map_err(|source| RenderError::ReadFile { path: path.into(), source })
}

fn table_hash(table: &CompressedTable) -> u64 {
    let mut hash = Hash::new();
    hash.add(format!("{:?} {:?}", table.axes, table.space).as_bytes());
    for components in [&table.transmittance, &table.reflectance] {
        for number in components.coefficients.iter().chain(&components.basis) {
            hash.add(&number.to_le_bytes());
        }
    }
    hash.0
}

/// FNV-1a of 64 bits (Fowler, Noll & Vo 1991, isthe.com/chongo/tech/comp/fnv).
struct Hash(u64);

impl Hash {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one() {
        // The authors' own test vectors.
        for (text, expected) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut hash = Hash::new();
            hash.add(text.as_bytes());
            assert_eq!(hash.0, expected, "{text}");
        }
    }

    #[test]
    fn scenes_differ_with_the_files_that_they_name() {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("scene.toml");
        std::fs::write(&scene, "[[object]]\nmesh = \"a.gltf\"\n[material.a]\nmask = { texture = \"mask.png\" }\n")
            .unwrap();
        let gltf = r#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "a%20b.bin", "byteLength": 3}]}"#;
        std::fs::write(folder.path().join("a.gltf"), gltf).unwrap();
        let mut hashes = vec![scene_hash(&scene).unwrap()];
        for (name, content) in [("mask.png", "mask"), ("mask.png", "face"), ("a b.bin", "abc"), ("other.bin", "abc")] {
            std::fs::write(folder.path().join(name), content).unwrap();
            hashes.push(scene_hash(&scene).unwrap());
        }
        assert_eq!(hashes[3], hashes[4], "a file that is not named");
        hashes.pop();
        hashes.sort_unstable();
        hashes.dedup();
        assert_eq!(hashes.len(), 4);
    }

    #[test]
    fn differences_are_told() {
        let one = Provenance::parse("version: 1\nseed: 1");
        let other = Provenance::parse("version: 1\nseed: 2\nnonsense");
        assert_eq!(one.difference(&Provenance::parse(&one.to_string())), None);
        assert_eq!(one.difference(&other).unwrap(), "seed is 1 in one and 2 in the other");
    }
}
