//! Layers of snow on a ground: options, and fluxes at depths.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_base::toml_table::ParseError;
use snowblue_figures::{Cell, Metadata, format_number};
use snowblue_transport::GroundAlbedo;
use snowblue_transport::layer_file::LayerFile;
use snowblue_transport::optics::{Substance, Wavelengths};
use snowblue_transport::parameters::GROUND_ALBEDO;
use snowblue_transport::slab::Incidence;
use snowblue_transport::stack::{Layer, Stack, StackRadiometry};

use crate::input::SettingsFile;
use crate::options::parse::GivenGround;
use crate::options::property::PropertyValues;
use crate::options::{limits, parse, snow_options};
use crate::output::Failure;

/// Layers, ground and depths.
#[derive(Debug, Args)]
#[command(next_help_heading = "Layers")]
pub(super) struct StackOptions {
    #[arg(
        long, value_name = "FILE", conflicts_with_all = snow_options(), conflicts_with = "thickness",
        help = format!(
            "TOML file of layers, top first, instead of the options of one snow. Each [[layer]] has thickness_cm (cm) \
             and optionally snow, size_measure, {}, impurities_ng_g = {{ black-carbon = 10 }}; or it is clear ice, \
             with kind = \"ice\" and thickness_cm alone. The file may set ice, the table",
            PropertyValues::<false>::keys()
        )
    )]
    layers: Option<PathBuf>,
    #[arg(
        long, value_name = "ALBEDO", value_parser = parse::ground_albedo,
        help = format!(
            "{} [{}; default: {}, no ground], or a CSV file of its spectrum with the columns wavelength_nm and \
             albedo, linear between its wavelengths. On a ground that reflects, transmittance is the downward flux \
             at the ground over the incident flux; it may exceed 1, since light is reflected to and fro. absorptance \
             is that of the snow: 1 − reflectance − (1 − ALBEDO) transmittance",
            GROUND_ALBEDO.describe(), limits::ends(&GROUND_ALBEDO.range.inclusive()), GROUND_ALBEDO.default
        )
    )]
    ground_albedo: Option<GivenGround>,
    /// Print fluxes through a level plane (down, up, net) and the fluence rate from all directions at these depths in
    /// cm, separated by commas, instead of fluxes of the whole slab
    #[arg(long, value_name = "CM", value_delimiter = ',', value_parser = parse::number)]
    depths: Vec<f64>,
}

/// Layers from a file, with their metadata.
pub(super) struct Pack {
    pub(super) layers: Vec<Layer>,
    pub(super) metadata: Metadata,
}

/// Columns of fluxes at depths.
pub(super) const PROFILE_COLUMNS: [&str; 9] =
    ["thickness_cm", "depth_cm", "angle_deg", "wavelength_nm", "down", "up", "net", "fluence", "e_folding_depth_cm"];

impl StackOptions {
    /// The file of layers.
    pub(super) fn file(&self) -> Option<&Path> {
        self.layers.as_deref()
    }

    /// The albedo of the ground; 0 without a ground.
    pub(super) fn ground_albedo(&self) -> GivenGround {
        let black = || GivenGround { albedo: 0.0.into(), word: "0".to_owned() };
        self.ground_albedo.clone().unwrap_or_else(black)
    }

    /// Whether the snow lies on a ground that reflects.
    pub(super) fn has_ground(&self) -> bool {
        self.ground_albedo.as_ref().is_some_and(|ground| ground.albedo.reflects())
    }

    /// Metadata about the effect of the ground on the columns.
    pub(super) fn metadata(&self, has_column: bool) -> Option<(&'static str, String)> {
        let (albedo, absorbed) = match &self.ground_albedo {
            _ if has_column => ("in the column ground_albedo".to_owned(), "(1 - ground_albedo)".to_owned()),
            Some(GivenGround { albedo: GroundAlbedo::Grey(albedo), .. }) if self.has_ground() => {
                (format_number(*albedo), format_number(1.0 - albedo))
            }
            Some(GivenGround { word, .. }) if self.has_ground() => (format!("of {word}"), "(1 - albedo)".to_owned()),
            _ => return None,
        };
        let columns = if self.has_depths() {
            String::new()
        } else {
            format!(
                "; transmittance is the downward flux at the ground over the incident flux, which may exceed 1; \
                 absorptance is that of the snow, 1 - reflectance - {absorbed} transmittance"
            )
        };
        Some(("ground", format!("albedo {albedo}{columns}")))
    }

    /// Whether fluxes at depths are to be printed.
    pub(super) fn has_depths(&self) -> bool {
        !self.depths.is_empty()
    }

    /// The layers of the file, if there is one.
    pub(super) fn pack(&self) -> Result<Option<Pack>, Failure> {
        let Some(path) = &self.layers else { return Ok(None) };
        let LayerFile { layers, ice, .. } = read(path)?;
        let mut metadata = vec![("ice", ice.name().to_owned()), ("layers", path.display().to_string())];
        let present = layers.iter().filter_map(Layer::sample).flat_map(|sample| sample.impurities.present());
        let present: BTreeSet<Substance> = present.map(|(substance, _)| substance).collect();
        if !present.is_empty() {
            let sources: Vec<&str> = present.into_iter().map(Substance::source).collect();
            metadata.push(("impurities", sources.join(", ")));
        }
        Ok(Some(Pack { layers, metadata }))
    }

    /// Layers on the ground, checked.
    pub(super) fn stack(
        &self,
        layers: Vec<Layer>,
        incidences: &[Incidence],
        wavelengths: &Wavelengths,
    ) -> Result<Stack, Failure> {
        let stack = Stack {
            layers,
            ground_albedo: self.ground_albedo().albedo,
            depths_cm: self.depths.clone(),
            incidences: incidences.to_vec(),
            wavelengths_nm: wavelengths.0.clone(),
        };
        stack.check().map_err(Failure::input)?;
        Ok(stack)
    }
}

/// A row for each depth of a solved stack.
pub(super) fn profile_rows<'a>(answer: &'a StackRadiometry, stack: &'a Stack) -> impl Iterator<Item = Vec<Cell>> + 'a {
    answer.profile.iter().zip(&stack.depths_cm).map(|(at, depth_cm)| {
        let whole = &answer.whole;
        let mut row: Vec<Cell> = vec![whole.thickness_cm.into(), (*depth_cm).into()];
        row.extend([Cell::word(whole.incidence.to_string()), whole.wavelength_nm.into()]);
        row.extend(
            [at.down, at.up, at.net, at.fluence, at.e_folding_depth_cm].map(|estimate| Cell::from(estimate.value)),
        );
        row
    })
}

/// Reads and checks the layers of a file.
fn read(path: &Path) -> Result<LayerFile, Failure> {
    let text = SettingsFile::read(path)?;
    LayerFile::parse(&text)
        .map_err(|ParseError { span, reason }| SettingsFile { path, text: &text }.failure(&span, reason))
}
