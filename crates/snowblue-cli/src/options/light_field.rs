//! The grid of the light field in snow.

use clap::Args;
use snowblue_render::scene::LightFieldSettings;

use super::parse;

/// The grid of the light field in snow.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct LightFieldOptions {
    /// Greatest memory of the light field of a body of snow in MiB [16–1048576], instead of the scene's
    #[arg(long, value_name = "N", value_parser = parse::whole_number::<u32>(16..=1 << 20))]
    field_memory_mib: Option<u32>,
    /// Greatest size of the cells of the light field at the surface of snow in mm [0.01–1000], instead of the scene's
    #[arg(long, value_name = "X", value_parser = parse::number_of(0.01..=1000.0))]
    field_step_mm: Option<f64>,
}

impl LightFieldOptions {
    /// Overrides the settings of a scene.
    pub(crate) fn override_values(self, settings: &mut LightFieldSettings) {
        settings.memory_mib = self.field_memory_mib.unwrap_or(settings.memory_mib);
        settings.step_mm = self.field_step_mm.or(settings.step_mm);
    }
}
