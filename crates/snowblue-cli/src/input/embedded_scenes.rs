//! The scenes of the repository, embedded in the program, so that the program can show them without its sources.

use snowblue_render::SceneFile;

use crate::output::Failure;

/// A scene inside the program.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EmbeddedScene {
    /// The name of the file without the ending.
    pub(crate) name: &'static str,
    /// The file.
    pub(crate) text: &'static str,
}

macro_rules! embedded {
    ($name:literal) => {
        EmbeddedScene { name: $name, text: include_str!(concat!("../../scenes/", $name, ".toml")) }
    };
}

/// All embedded scenes, by name.
pub(crate) const SCENES: [EmbeddedScene; 22] = [
    embedded!("block_30cm"),
    embedded!("clump"),
    embedded!("cornice"),
    embedded!("crevasse"),
    embedded!("fig10_igloo"),
    embedded!("fig10_opaque"),
    embedded!("fig11_dragon"),
    embedded!("fig1_lamp"),
    embedded!("fig9_back"),
    embedded!("fig9_front"),
    embedded!("fig9_oblique"),
    embedded!("hole_and_footprint"),
    embedded!("igloo_clear"),
    embedded!("igloo_overcast"),
    embedded!("lantern"),
    embedded!("probe_hole"),
    embedded!("quinzhee"),
    embedded!("snow_cave"),
    embedded!("snow_tunnel"),
    embedded!("truth_ball"),
    embedded!("truth_corner"),
    embedded!("truth_floor"),
];

/// The scene that needs a file which is not inside the program, and the reason.
const DRAGON: &str = "fig11_dragon";
const NEEDS_A_MODEL: &str = "needs models/dragon.ply, which scripts/fetch-models of the sources downloads";

impl EmbeddedScene {
    /// The scene of a name.
    pub(crate) fn named(name: &str) -> Result<Self, String> {
        let known = || SCENES.map(|scene| scene.name).join(", ");
        let found = SCENES.into_iter().find(|scene| scene.name == name);
        found.ok_or_else(|| format!("must be one of {}", known()))
    }

    /// The summary of the scene: the first sentences of its file below the line of its schema, up to the first line
    /// that is no comment or an empty comment.
    pub(crate) fn summary(self) -> String {
        let lines = self.text.lines().skip(1).map_while(|line| line.strip_prefix('#')).map(str::trim);
        let summary = lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
        self.lacks().map_or(summary.clone(), |lacks| format!("{summary} It {lacks}."))
    }

    /// The text about a file that the scene needs and that is not inside the program.
    fn lacks(self) -> Option<&'static str> {
        (self.name == DRAGON).then_some(NEEDS_A_MODEL)
    }

    /// Reads the scene.
    pub(crate) fn open(self) -> Result<SceneFile, Failure> {
        let path = format!("{}.toml", self.name);
        match self.lacks() {
            Some(lacks) => Err(Failure::Input(format!(
                "--scene {}: the scene {lacks}; then render scenes/{path} of the sources",
                self.name
            ))),
            None => SceneFile::parse(self.text, path).map_err(Failure::input),
        }
    }
}
