//! `snowblue bsdf`: how the light that leaves a slab is spread over directions.

use std::path::PathBuf;

use clap::Args;
use snowblue_transport::monte_carlo::{self, Distribution, GoniometricOptions, PatchGrid};
use snowblue_transport::slab::{Estimate, Incidence, Slab};

use crate::failure::{Failure, Outcome};
use crate::options::{OutputOptions, SampleOptions};
use crate::parse::{self, Wavelengths};
use crate::plot;
use crate::progress::Progress;
use crate::report::{Cell, Report, figures};

const COLUMNS: [&str; 7] =
    ["side", "theta_deg", "phi_deg", "solid_angle_sr", "wavelength_nm", "bsdf_per_sr", "bsdf_se_per_sr"];

/// How light leaves a slab of snow: BRDF and BTDF on a hemisphere of patches
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "A patch lies about theta_deg from the normal and phi_deg from the way that the beam travels \
(0 is forward, 180 back to the light), and stands for its mirror image too. All patches have the same integral of \
cos theta over solid angle, pi/(RINGS*SECTORS), so that bsdf_per_sr times it, summed, is the flux. Light that met no \
grain is in no patch: the metadata tell its share.

Examples:
  snowblue bsdf --thickness 5 --angle 60 --wavelengths 450,550,650 --plot bsdf.svg
  snowblue bsdf --thickness 1 --patches 20x24 --rays 1000000 -o bsdf.csv"
)]
pub(crate) struct Bsdf {
    #[command(flatten)]
    sample: SampleOptions,
    /// Thickness in cm
    #[arg(long, value_name = "CM", default_value = "15", value_parser = parse::number, help_heading = "Slab")]
    thickness: f64,
    /// Angle of incidence from the normal in degrees [0–89.99], or 'diffuse' (Lambertian)
    #[arg(long, value_name = "DEG", default_value = "0", value_parser = parse::incidence, help_heading = "Slab")]
    angle: Incidence,
    /// Wavelengths in nm: FIRST:LAST:STEP or a list
    #[arg(
        long, value_name = "NM", default_value = "450,550,650", value_parser = parse::wavelengths,
        help_heading = "Slab"
    )]
    wavelengths: Wavelengths,
    /// Rays for each wavelength
    #[arg(long, value_name = "N", default_value_t = monte_carlo::DEFAULT_RAYS, value_parser = parse::count, help_heading = "Engine")]
    rays: u64,
    /// Seed of all randomness
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Engine")]
    seed: u64,
    /// Patches of a hemisphere, RINGSxSECTORS [default: 10x12; 10x1 where azimuths are all alike, at 0° and diffuse]
    #[arg(long, value_name = "GRID", value_parser = patches, help_heading = "Engine")]
    patches: Option<PatchGrid>,
    #[command(flatten)]
    output: OutputOptions,
    /// Draw the plane of incidence into an SVG file
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Option<PathBuf>,
}

impl Bsdf {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.output.check()?;
        self.plot.as_deref().map_or(Ok(()), plot::check_place)?;
        let slab = Slab {
            sample: self.sample.sample()?,
            thicknesses_cm: vec![self.thickness],
            incidences: vec![self.angle],
            wavelengths_nm: self.wavelengths.0.clone(),
        };
        let options = GoniometricOptions { rays: self.rays, seed: self.seed, patches: self.grid() };
        let bar = Progress::new("rays", quiet);
        let spread = monte_carlo::distribute(&slab, &options, &|done, all| bar.at(done, all));
        bar.end();
        let spread = spread.map_err(Failure::input)?;
        let made = self.provenance()?;
        let report = self.report(&spread, &made);
        if let Some(path) = &self.plot {
            plot::bsdf(path, &spread, &made)?;
        }
        report.write(&self.output, quiet)
    }

    fn grid(&self) -> PatchGrid {
        let axial = matches!(self.angle, Incidence::Diffuse) || self.angle == Incidence::Beam { angle_deg: 0.0 };
        let usual = PatchGrid::default();
        self.patches.unwrap_or(if axial { PatchGrid { sectors: 1, ..usual } } else { usual })
    }

    fn report(&self, spread: &[Distribution], made: &[(&'static str, String)]) -> Report {
        let mut rows = Vec::new();
        for one in spread {
            for (side, patches) in [("reflection", &one.reflection), ("transmission", &one.transmission)] {
                rows.extend(patches.iter().map(|patch| {
                    let Estimate { value, standard_error } = patch.bsdf_per_sr;
                    let place = [patch.theta_deg, patch.phi_deg, patch.solid_angle_sr, one.wavelength_nm];
                    let numbers = place.into_iter().chain([value, standard_error]);
                    std::iter::once(Cell::Word(side.to_owned())).chain(numbers.map(Cell::from)).collect()
                }));
            }
        }
        Report { columns: COLUMNS.to_vec(), rows, metadata: metadata(spread, made) }
    }

    /// What made the answer.
    fn provenance(&self) -> Result<Vec<(&'static str, String)>, Failure> {
        let PatchGrid { rings, sectors } = self.grid();
        let mut made = vec![
            ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
            ("engine", format!("Monte Carlo, {} rays on {rings} × {sectors} patches", self.rays)),
        ];
        made.extend(self.sample.metadata()?);
        made.push(("seed", self.seed.to_string()));
        Ok(made)
    }
}

/// What made the answer, then the fluxes.
fn metadata(spread: &[Distribution], made: &[(&'static str, String)]) -> Vec<(&'static str, String)> {
    let fluxes = |quantity: &dyn Fn(&Distribution) -> Estimate| {
        let words = spread.iter().map(|one| {
            let Estimate { value, standard_error } = quantity(one);
            format!("{} ± {} at {} nm", figures(value), figures(standard_error), one.wavelength_nm)
        });
        words.collect::<Vec<_>>().join(", ")
    };
    let mut metadata = made.to_vec();
    metadata.extend([
        ("reflectance", fluxes(&|one| one.reflectance)),
        ("transmittance", fluxes(&|one| one.transmittance)),
        ("direct", fluxes(&|one| one.direct)),
    ]);
    metadata
}

fn patches(words: &str) -> Result<PatchGrid, String> {
    let count = |word: &str| word.trim().parse().ok();
    let grid = words
        .split_once('x')
        .and_then(|(rings, sectors)| Some(PatchGrid { rings: count(rings)?, sectors: count(sectors)? }));
    grid.ok_or_else(|| "give RINGSxSECTORS (10x12)".to_owned())
}
