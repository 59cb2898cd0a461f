//! Options of all exports: the snow whose colours are fitted.

use clap::Args;
use snowblue_color::Observer;
use snowblue_database::compact::{CompactSnow, MAX_THICKNESS_RANGE};
use snowblue_figures::format_number;

use crate::options::{LightOptions, OrdinatesArguments, SampleCount, SnowOptions, limits, parse};
use crate::output::Failure;

/// Snow, light and the range of thickness.
#[derive(Debug, Args)]
pub(super) struct CompactOptions {
    #[command(flatten)]
    sample: SnowOptions,
    #[command(flatten)]
    light: LightOptions,
    #[command(flatten)]
    ordinates: OrdinatesArguments,
    #[arg(
        long, value_name = "CM", default_value = "100", value_parser = parse::parameter(MAX_THICKNESS_RANGE),
        help_heading = "Slab", help = format!(
            "Greatest thickness in cm [{}]; thicker snow is extrapolated by its decay there",
            limits::ends(&MAX_THICKNESS_RANGE.inclusive())
        )
    )]
    max_thickness: f64,
}

impl CompactOptions {
    pub(super) fn fit(&self) -> Result<CompactSnow, Failure> {
        let colorimeter = self.light.colorimeter(Observer::Cie1931, &SampleCount::ThirtyOne.wavelengths_nm())?;
        let options = self.ordinates.options();
        CompactSnow::new(&self.sample.sample()?, self.max_thickness, &colorimeter, &options).map_err(Failure::input)
    }

    /// Lines that describe the numbers.
    pub(super) fn notes(&self, snow: &CompactSnow) -> Result<Vec<String>, Failure> {
        let mut notes = vec![format!("snowblue {}", env!("CARGO_PKG_VERSION"))];
        notes.extend(self.sample.metadata()?.into_iter().map(|(name, value)| format!("{name}: {value}")));
        notes.push(format!("illuminant: {}, observer: CIE 1931", self.light.illuminant));
        notes.push(format!(
            "0 to {} cm, 0 to 89 degrees; greatest error of the fit: {:.1e} of the value",
            format_number(self.max_thickness),
            snow.error()
        ));
        Ok(notes)
    }
}
