//! Files that the command reads itself: settings in TOML and spectra in CSV.

mod settings_file;
pub(crate) mod spectrum_file;

pub(crate) use settings_file::SettingsFile;
