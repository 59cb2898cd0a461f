//! `snowblue match`: snow whose transmitted light has a given colour.

use clap::Args;
use snowblue_color::{LinearRgb, Observer, Srgb8, Xyz};
use snowblue_database::fidelity::PERCEPTIBLE_DELTA_E;
use snowblue_database::matching::{self, Given, Match as Found, Problem, Target};
use snowblue_database::{DatabaseError, Interval};
use snowblue_figures::{Cell, DataTable};
use snowblue_transport::optics::Wavelengths;
use snowblue_transport::parameters::{ANGLE, THICKNESS};
use snowblue_transport::slab::Incidence;

use crate::options::parse::{self, Span};
use crate::options::{LightOptions, OrdinatesArguments, SnowOptions, limits};
use crate::output::{Failure, Outcome, OutputOptions, print_message};

const COLUMNS: [&str; 12] = [
    "grain_size_um",
    "density_kg_m3",
    "thickness_cm",
    "angle_deg",
    "illuminant",
    "delta_e",
    "delta_e_2000",
    "within_reach",
    "Y",
    "exposure_stops",
    "hex",
    "hex_transmitted",
];

/// Find snow whose transmitted light comes closest to a colour
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "The target is an sRGB colour, for the CIE 1931 observer and without adaptation to the illuminant. \
Its hue and chroma are matched, not its luminance: delta_e is the CIELAB 1976 difference with the light and the target \
both scaled to L* = 50; up to 2.3 the difference is not noticeable. delta_e_2000 is the same by CIEDE2000.

Quantities that are not given are searched for: first the thickness; if it is given or cannot reach the target, the \
grain size (100–2000 µm), then the density (100–450 kg/m³). The first row is the snow closest to the default. The \
other rows have the same hue as far as possible, but transmit more or less light. Y is the luminance relative to the \
unattenuated light. exposure_stops scales it to the target's luminance; hex is the exposed colour, hex_transmitted the \
unexposed one. A target out of reach is reported on stderr.

Examples:
  snowblue match --target '#5fa8c4'
  snowblue match --target '#9db9b5' --grain-size 250 --thickness 5:30 --illuminant D55
  snowblue match --target '#9dacaf' --thickness 10 --impurity black-carbon=20"
)]
pub(crate) struct Match {
    /// A colour without its option, which is refused with what to type.
    #[arg(value_name = "COLOUR", value_parser = parse::option_of_color, hide = true)]
    color: Option<String>,
    /// Target colour as #rrggbb, not black
    #[arg(long, value_name = "HEX", value_parser = parse::hex)]
    target: Srgb8,
    #[command(flatten)]
    sample: SnowOptions,
    #[arg(
        long, value_name = "CM", value_parser = parse::span, help_heading = "Slab",
        help = format!(
            "{}, or a range MIN:MAX to search [{}; default: 0:100]",
            THICKNESS.describe(), limits::ends(&THICKNESS.range.inclusive())
        )
    )]
    thickness: Option<Span>,
    #[arg(
        long, value_name = "DEG", default_value = "0", value_parser = parse::incidence, help_heading = "Slab",
        help = format!("{}, or 'diffuse' (Lambertian)", limits::described(&ANGLE))
    )]
    angle: Incidence,
    #[command(flatten)]
    ordinates: OrdinatesArguments,
    #[command(flatten)]
    light: LightOptions,
    #[command(flatten)]
    output: OutputOptions,
}

impl Match {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.output.check()?;
        let wavelengths = Wavelengths::visible();
        let colorimeter = self.light.colorimeter(Observer::Cie1931, &wavelengths.0)?;
        let white = LinearRgb { r: 1.0, g: 1.0, b: 1.0 }.xyz();
        let target = Target { color: self.target.decode().xyz(), white, colorimeter: &colorimeter };
        let found =
            matching::closest(&target, &self.snow()?, &self.ordinates.options()).map_err(|error| match error {
                DatabaseError::DarkTarget => Failure::Input(format!("--target {}: {error}", self.target)),
                other => Failure::input(other),
            })?;
        let mut metadata = vec![
            ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
            ("target", self.target.to_string()),
            ("observer", Observer::Cie1931.name().to_owned()),
        ];
        let first_row_metadata = self.sample.metadata_of(&found[0].sample).into_iter();
        // Other rows have other grain sizes and densities.
        metadata.extend(
            first_row_metadata
                .filter(|(name, _)| *name != "snow_id")
                .map(|(name, value)| (if name == "snow" { "snow of the first row" } else { name }, value)),
        );
        metadata.push(("seed", self.ordinates.seed.to_string()));
        let rows = found.iter().map(|matched| self.row(matched, target.color)).collect();
        self.output.write(&DataTable { columns: COLUMNS.to_vec(), rows, metadata }, quiet)?;
        if !found[0].within_reach() {
            print_message(&self.out_of_reach(&found[0], &target));
        }
        Ok(())
    }

    /// The snow, and its free parameters.
    fn snow(&self) -> Result<Problem, Failure> {
        let given = Given {
            thickness_cm: self.thickness.map(|span| Interval { low: span.min, high: span.max }),
            grain_size: self.sample.sets_grain_size(),
            density: self.sample.sets_density(),
        };
        Ok(Problem::new(self.sample.sample()?, self.angle, given))
    }

    fn row(&self, found: &Found, target: Xyz) -> Vec<Cell> {
        let hex = |light: Xyz| Cell::Word(LinearRgb::from_xyz(light).display_hex());
        let within_reach = if found.within_reach() { "yes" } else { "no" };
        vec![
            found.sample.grain_size.middle_um().into(),
            found.sample.density_kg_m3.into(),
            found.thickness_cm.into(),
            Cell::Word(self.angle.to_string()),
            Cell::Word(self.light.illuminant.name().to_owned()),
            found.difference.at_middle_grey.into(),
            found.difference.at_middle_grey_2000.into(),
            Cell::Word(within_reach.to_owned()),
            found.light.y.into(),
            (target.y / found.light.y).log2().into(),
            hex(found.light.with_luminance(target.y)),
            hex(found.light),
        ]
    }

    fn out_of_reach(&self, nearest: &Found, target: &Target) -> String {
        let bound = self.thickness.is_some() || self.sample.sets_grain_size() || self.sample.sets_density();
        let within = if bound { " with the given options" } else { "" };
        format!(
            "snowblue: {} is out of reach{within}: it is {}; {PERCEPTIBLE_DELTA_E} is just noticeable\n",
            self.target,
            nearest.deviation(target)
        )
    }
}
