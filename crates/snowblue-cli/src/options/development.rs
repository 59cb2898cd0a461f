//! Exposure, tone curve and white of a PNG.

use clap::Args;
use snowblue_color::ToneCurve;
use snowblue_render::Exposure;
use snowblue_render::scene::film::FilmSettings;
use snowblue_render::scene::film::white_balance::WhiteBalance;

use super::{limits, parse};

/// Exposure, tone curve and white of a PNG.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct DevelopmentOptions {
    #[arg(
        long, value_name = "STOPS", value_parser = parse::exposure, allow_negative_numbers = true,
        help = format!(
            "Exposure of a PNG in stops [{}], or 'auto', instead of that of the scene or file; 'auto' shows snow in \
             the sun as white, and snow in less light darker, by its luminance: half a stop below an overcast sky, \
             two stops by a candle; it leaves out pixels that show a lamp or the sun", limits::stops()
        )
    )]
    pub(crate) exposure: Option<Exposure>,
    /// Tone curve of a PNG, instead of that of the scene or file: filmic (a straight line with a shoulder below white,
    /// on luminance), agx (low contrast, with pale highlights) or none (light as it is, up to white)
    #[arg(long, value_name = "CURVE", value_parser = clap::value_parser!(ToneCurve))]
    pub(crate) tone: Option<ToneCurve>,
    #[arg(
        long, value_name = "LIGHT", value_parser = clap::value_parser!(WhiteBalance),
        help = format!(
            "Light that looks white, instead of that of the scene or file: a CIE illuminant such as D65 or D55, a \
             colour temperature [{}], or 'sky' for the light of sun and sky on level ground", limits::temperatures()
        )
    )]
    pub(crate) white: Option<WhiteBalance>,
}

impl DevelopmentOptions {
    /// Overrides the settings of a scene.
    pub(crate) fn override_values(self, film: &mut FilmSettings) {
        film.exposure = self.exposure.unwrap_or(film.exposure);
        film.tone = self.tone.unwrap_or(film.tone);
        film.white = self.white.unwrap_or(film.white);
    }
}
