//! The inputs of an image. Parts of an image can be merged only if their inputs agree.

use glam::DVec3;
use std::collections::BTreeMap;
use std::fmt;

use snowblue_base::files::FileSource;
use snowblue_base::hash::Fnv1a;

use crate::Scene;
use crate::film::FilmSettings;
use crate::integrator::{IntegratorSettings, LightFieldSettings, PcaSnowSettings, Views};
use crate::scene::SceneDescription;

/// The name of the list of files.
const FILES: &str = "files";

/// Names and values of everything that the samples of an image depend on: the version of this crate, the description
/// of the scene, the content of the files that the description names, and the table. The number of samples and the
/// exposure are not included.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance(Vec<(String, String)>);

impl Provenance {
    /// The provenance of a scene: its description, its files, and the hash of the table of curves if its integrator
    /// reads a table.
    pub fn of(scene: &Scene, table_hash: Option<u64>) -> Self {
        Self::new(&scene.description, table_hash, &scene.file_hashes())
    }

    /// The provenance of a scene that names the same files and reads the same table as this provenance, without
    /// building the scene.
    pub fn of_same_files(&self, scene: &SceneDescription, files: &dyn FileSource) -> Self {
        let names: Vec<String> = self.get(FILES).and_then(|names| serde_json::from_str(names).ok()).unwrap_or_default();
        let hash = |name: &str| files.read(name).ok().map(|bytes| Fnv1a::of(&bytes));
        let hashes = names.iter().filter_map(|name| Some((name.as_str(), hash(name)?))).collect();
        let table = self.get("table").and_then(|hash| u64::from_str_radix(hash, 16).ok());
        Self::new(scene, table, &hashes)
    }

    /// The provenance of a description, with hashes of the files that the description names.
    fn new(scene: &SceneDescription, table: Option<u64>, files: &BTreeMap<&str, u64>) -> Self {
        let (film, integrator) = (&scene.film, &scene.integrator);
        let mut entries = vec![
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("scene", format!("{:016x}", scene_hash(scene, files))),
            ("width", film.width.to_string()),
            ("height", film.height.to_string()),
            ("seed", integrator.seed.to_string()),
            ("max bounces", integrator.max_bounces.to_string()),
            ("noise target", integrator.noise_target.map_or("none".to_owned(), |target| target.to_string())),
            ("integrator", integrator.kind.name().to_owned()),
            ("white", film.white.to_string()),
        ];
        if integrator.kind.has_curves() {
            let PcaSnowSettings { path, reflectance, table: _ } = &integrator.pcasnow;
            let reflectance = reflectance.map_or("of the curves".to_owned(), |share| share.to_string());
            entries.push(("path", path.name().to_owned()));
            entries.push(("reflectance", reflectance));
        }
        entries.extend(table.map(|hash| ("table", format!("{hash:016x}"))));
        if integrator.kind.has_light_field() {
            let LightFieldSettings { step_mm, nodes, views, grain_rays, most_rounds, .. } = scene.light_field;
            let memory_mib = scene.light_field.memory_mib();
            if most_rounds != LightFieldSettings::default().most_rounds {
                entries.push(("rounds of light between bodies", format!("at most {most_rounds}")));
            }
            entries.push(("light field", format!("{memory_mib} MiB, {grain_rays} rays through grains")));
            let cells = match (step_mm, nodes) {
                (Some(step_mm), _) => format!("{step_mm} mm"),
                (None, Some(nodes)) => format!("for {nodes} nodes"),
                (None, None) => match views {
                    Views::Camera => "chosen for the camera".to_owned(),
                    Views::All => "chosen for all views".to_owned(),
                },
            };
            entries.push(("cells of the light field", cells));
        }
        if !files.is_empty() {
            entries.push((FILES, serde_json::json!(files.keys().collect::<Vec<_>>()).to_string()));
        }
        Self(entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
    }

    /// The value of a name.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(one, _)| one == name).map(|(_, value)| &**value)
    }

    /// Describes the first difference to another provenance; none if both are equal.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let (name, value) = self.0.iter().find(|(name, value)| other.get(name) != Some(value))?;
        // These values are hashes.
        match &**name {
            "scene" => return Some("the scene, or a file that it names, differs".to_owned()),
            "table" => return Some("the table differs".to_owned()),
            _ => {}
        }
        Some(format!("{name} is {value} in one and {} in the other", other.get(name).unwrap_or("not given")))
    }

    /// Parses the output of [`Display`](fmt::Display). Lines without a colon are ignored.
    pub fn parse(text: &str) -> Self {
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

/// The hash of a scene's description, as TOML, and of the files that were read for it. The settings that have entries
/// of their own are left out.
fn scene_hash(scene: &SceneDescription, files: &BTreeMap<&str, u64>) -> u64 {
    let mut description = scene.clone();
    (description.film, description.integrator) = (FilmSettings::default(), IntegratorSettings::default());
    description.light_field = LightFieldSettings::default();
    let mut hash = Fnv1a::default();
    hash.add(description.to_toml().as_bytes());
    if description.local_origin != DVec3::ZERO {
        hash.add(description.local_origin.to_string().as_bytes());
    }
    for (name, content) in files {
        hash.add(name.as_bytes());
        hash.add(&content.to_le_bytes());
    }
    hash.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::IntegratorKind;
    use crate::scene_file::SceneFile;
    use snowblue_base::files::FilesInMemory;

    #[test]
    fn scenes_differ_with_their_values_and_with_the_files_that_they_name() {
        let gltf = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}],
            "buffers": [{"uri": "a%20b.bin", "byteLength": 3}]}"#;
        let text = "gltf = \"models/a.gltf\"\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 1, 1]\n\
                    [environment]\nradiance_w_m2_sr = 1\nspectrum = \"sky.csv\"\n";
        let mut hashes = Vec::new();
        let mut files = FilesInMemory::from([("models/a.gltf", gltf), ("models/a b.bin", "abc")]);
        files.insert("sky.csv", "400,1\n700,2\n");
        let mut hash = |text: &str, files: &FilesInMemory| {
            let scene = SceneFile::parse(text, "scene.toml").unwrap().description.build(files).unwrap();
            hashes.push(scene_hash(&scene.description, &scene.file_hashes()));
            // The same provenance without building the scene.
            let provenance = Provenance::of(&scene, None);
            let again = Provenance::parse(&provenance.to_string()).of_same_files(&scene.description, files);
            assert_eq!(again, provenance);
        };
        hash(text, &files);
        hash(&text.replace("sr = 1", "sr = 2"), &files);
        for (name, content) in [("models/a b.bin", "abd"), ("sky.csv", "400,1\n700,3\n"), ("other.csv", "400,1\n")] {
            files.insert(name, content);
            hash(text, &files);
        }
        hash(
            &format!(
                "# A comment, and settings that have entries of their own.\n{text}[film]\nwidth = 3\n\
            [light_field]\nstep_mm = 3\n"
            ),
            &files,
        );
        assert_eq!(hashes[3], hashes[4], "a file that is not named");
        assert_eq!(hashes[4], hashes[5], "neither the wording of the file nor settings");
        hashes.truncate(4);
        hashes.sort_unstable();
        hashes.dedup();
        assert_eq!(hashes.len(), 4);
    }

    #[test]
    fn another_file_is_noticed_without_building_the_scene() {
        let text = "[camera]\nposition = [0, 0, 1]\nlook_at = [0, 1, 1]\n\
                    [environment]\nradiance_w_m2_sr = 1\nspectrum = \"sky.csv\"\n";
        let mut files = FilesInMemory::from([("sky.csv", "400,1\n700,2\n")]);
        let scene = SceneFile::parse(text, "scene.toml").unwrap().description;
        let built = Provenance::of(&scene.build(&files).unwrap(), None);
        let difference =
            |scene: &SceneDescription, files: &FilesInMemory| built.difference(&built.of_same_files(scene, files));
        assert_eq!(difference(&scene, &files), None);
        let mut other = scene.clone();
        other.integrator.seed = 7;
        assert_eq!(difference(&other, &files).unwrap(), "seed is 1 in one and 7 in the other");
        files.insert("sky.csv", "400,1\n700,3\n");
        assert!(difference(&scene, &files).unwrap().contains("a file that it names, differs"));
        assert!(difference(&scene, &FilesInMemory::default()).unwrap().contains("a file that it names, differs"));
    }

    #[test]
    fn only_pcasnow_has_settings_of_its_own() {
        let text = "[camera]\nposition = [0, 0, 1]\nlook_at = [0, 1, 1]\n[environment]\nradiance_w_m2_sr = 1\n";
        let mut scene = SceneFile::parse(text, "scene.toml").unwrap().description;
        for kind in IntegratorKind::ALL {
            scene.integrator.kind = kind;
            let scene = scene.build(&FilesInMemory::default()).unwrap();
            let provenance = Provenance::of(&scene, None);
            let names = ["path", "reflectance", "light field"].map(|name| provenance.get(name).is_some());
            let [curves, field] = [kind.has_curves(), kind.has_light_field()];
            assert_eq!(names, [curves, curves, field], "{kind:?}");
        }
    }

    #[test]
    fn differences_are_named() {
        let one = Provenance::parse("version: 1\nseed: 1");
        let other = Provenance::parse("version: 1\nseed: 2\nnonsense");
        assert_eq!(one.difference(&Provenance::parse(&one.to_string())), None);
        assert_eq!(one.difference(&other).unwrap(), "seed is 1 in one and 2 in the other");
    }
}
