//! Files that the command reads itself, which are settings in TOML, and the scenes inside the program.

mod embedded_scenes;
mod settings_file;

pub(crate) use embedded_scenes::{EmbeddedScene, SCENES};
pub(crate) use settings_file::SettingsFile;
