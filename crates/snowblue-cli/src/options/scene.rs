//! The scene of a command: a file, or a scene inside the program.

use std::path::PathBuf;

use clap::Args;
use snowblue_render::SceneFile;

use crate::input::EmbeddedScene;
use crate::output::Failure;

/// The scene of a command.
#[derive(Debug, Args)]
pub(crate) struct SceneOptions {
    /// Scene file (TOML)
    #[arg(id = "SCENE", conflicts_with = "scene")]
    file: Option<PathBuf>,
    /// A scene inside this program instead of a file; 'snowblue render --list-scenes' lists them
    #[arg(long, value_name = "NAME", value_parser = EmbeddedScene::named)]
    scene: Option<EmbeddedScene>,
}

impl SceneOptions {
    /// The scene inside the program; none for a file.
    pub(crate) fn embedded(&self) -> Option<EmbeddedScene> {
        self.scene
    }

    /// Reads the scene.
    pub(crate) fn open(&self) -> Result<SceneFile, Failure> {
        match (&self.file, self.scene) {
            (Some(path), _) => SceneFile::open(path).map_err(Failure::input),
            (None, Some(scene)) => scene.open(),
            (None, None) => Err(Failure::Input("give a scene file, or --scene NAME (render --list-scenes)".to_owned())),
        }
    }

    /// The path of the scene's file, or the name of the scene inside the program.
    pub(crate) fn name(&self) -> String {
        match (&self.file, self.scene) {
            (Some(path), _) => path.display().to_string(),
            (None, Some(scene)) => scene.name.to_owned(),
            (None, None) => String::new(),
        }
    }
}
