//! The grid of the light field in snow.

use clap::Args;
use snowblue_base::{Count, Number};
use snowblue_render::scene::LightFieldSettings;
use snowblue_render::scene::integrator::{FieldMemory, FieldStep};

use super::{limits, parse};

/// The grid of the light field in snow.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct LightFieldOptions {
    #[arg(
        long, value_name = "N", value_parser = parse::count::<FieldMemory>,
        help = format!(
            "Greatest memory of the light field in MiB [{}], instead of the scene's",
            limits::of::<FieldMemory>()
        )
    )]
    field_memory_mib: Option<Count<FieldMemory>>,
    #[arg(
        long, value_name = "X", value_parser = parse::quantity::<FieldStep>,
        help = format!(
            "Greatest size of the cells of the light field at the surface of snow in mm [{}], instead of the scene's",
            limits::of::<FieldStep>()
        )
    )]
    field_step_mm: Option<Number<FieldStep>>,
}

impl LightFieldOptions {
    /// Overrides the settings of a scene.
    pub(crate) fn override_values(self, settings: &mut LightFieldSettings) {
        settings.memory_mib = self.field_memory_mib.unwrap_or(settings.memory_mib);
        if self.field_step_mm.is_some() {
            (settings.step_mm, settings.nodes) = (self.field_step_mm, None);
        }
    }
}
