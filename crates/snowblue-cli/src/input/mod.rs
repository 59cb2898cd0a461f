//! Files that the command reads itself: settings in TOML, spectra in CSV and tables for scenes; and the scenes inside
//! it.

mod embedded_scenes;
mod scene_table;
mod settings_file;
pub(crate) mod spectrum_file;

pub(crate) use embedded_scenes::{EmbeddedScene, SCENES};
pub(crate) use scene_table::scene_table;
pub(crate) use settings_file::SettingsFile;
