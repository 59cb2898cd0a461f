//! `snowblue slab`: a Henyey–Greenstein slab, to check the solver against published values.

use clap::Args;
use snowblue_figures::DataTable;
use snowblue_transport::HenyeyGreenstein;
use snowblue_transport::ordinates::{self, HomogeneousMedium, Streams};

use crate::options::parse;
use crate::output::{Failure, Outcome, OutputOptions};

/// Number of streams with which T is within 10⁻⁴ at almost all angles.
const STREAMS: usize = 32;

/// Solve a homogeneous Henyey–Greenstein slab, to check the solver against published values
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue slab --one-minus-omega 0.1 --g 0.75 --tau 2 --mu0 1 --streams 32
      van de Hulst (1980, Table 35) has R = 0.09739 and T = 0.66096"
)]
pub(crate) struct Slab {
    /// Co-albedo 1 − ω of single scattering [0–1]
    #[arg(long, value_name = "X", value_parser = parse::number)]
    one_minus_omega: f64,
    /// Asymmetry parameter g [-0.9–1]
    #[arg(long, value_name = "G", value_parser = parse::number, allow_negative_numbers = true)]
    g: f64,
    /// Optical depth τ [0–1e9]
    #[arg(long, value_name = "TAU", value_parser = parse::number)]
    tau: f64,
    /// Cosine μ₀ of the angle of incidence [1e-4–1]
    #[arg(long, value_name = "MU0", default_value = "1", value_parser = parse::number)]
    mu0: f64,
    /// Number of streams of both hemispheres together, even
    #[arg(
        long, value_name = "N", default_value_t = STREAMS,
        value_parser = parse::whole_number::<usize>(2..=ordinates::MAX_STREAMS as u64)
    )]
    streams: usize,
    #[command(flatten)]
    output: OutputOptions,
}

impl Slab {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        Streams::Exactly(self.streams).check().map_err(Failure::input)?;
        for (option, value, low, high) in [
            ("--one-minus-omega", self.one_minus_omega, 0.0, 1.0),
            ("--g", self.g, -0.9, 1.0),
            ("--tau", self.tau, 0.0, 1e9),
            ("--mu0", self.mu0, 1e-4, 1.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(Failure::Input(format!("{option} is {value}, but must lie in {low}–{high}")));
            }
        }
        let scattering =
            HenyeyGreenstein { one_minus_albedo: self.one_minus_omega, asymmetry: self.g }.scattering(self.streams);
        HomogeneousMedium::check(&scattering, self.streams).map_err(Failure::input)?;
        let medium = HomogeneousMedium::new(&scattering, self.streams);
        let fluxes = medium.fluxes(self.tau, &[medium.beam(self.mu0)])[0];
        let results = DataTable {
            columns: vec!["reflectance", "transmittance", "direct"],
            rows: vec![vec![fluxes.reflectance.into(), fluxes.transmittance.into(), fluxes.direct.into()]],
            metadata: vec![("snowblue", env!("CARGO_PKG_VERSION").to_owned()), ("streams", self.streams.to_string())],
        };
        self.output.write(&results, quiet)
    }
}
