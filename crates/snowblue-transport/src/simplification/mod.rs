//! Results of simpler models of snow: each changes one property of the model and keeps the rest.

use rayon::prelude::*;
use snowblue_base::ParameterRange;

use crate::TransportError;
use crate::medium::{Demand, GrainTallies, HenyeyGreenstein, Medium, Population, Scattering};

use crate::ordinates::{OrdinatesOptions, Peak, Streams};
use crate::parameters::WATER_SATURATION;
use crate::sample::{GrainSize, SizeMeasure, SnowSample, TruncatedNormal};
use crate::slab::{Incidence, Slab};

mod two_stream;
use two_stream::delta_eddington;

/// Wavelength of the refractive index in a model without dispersion, in nm.
const ONE_INDEX_NM: f64 = 550.0;
/// Wavelength below which ice is often assumed not to absorb, in nm.
const CLEAR_BELOW_NM: f64 = 500.0;

/// A simpler model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Simplification {
    /// No simplification, as the reference.
    Exact,
    /// The refractive index of 550 nm at all wavelengths.
    OneIndex,
    /// No absorption at any wavelength.
    ClearIce,
    /// No absorption below 500 nm.
    ClearBlue,
    /// Smooth spheres with the same diameters as the grains' greatest extension.
    SpheresOfEqualExtension,
    /// Smooth spheres with the same specific surface area.
    SpheresOfEqualArea,
    /// Henyey & Greenstein's phase function with the grains' asymmetry.
    HenyeyGreenstein,
    /// 1 − ω in proportion to the absorption coefficient.
    LinearAbsorption,
    /// Two ordinates with δ-M, one in each hemisphere.
    TwoOrdinates,
    /// The δ-Eddington approximation.
    DeltaEddington,
    /// The other ice table, to compare the size of the errors.
    OtherIce,
}

/// A slab with its grains tallied once for all simplifications.
pub struct Simplifier<'s> {
    slab: &'s Slab,
    options: OrdinatesOptions,
    grains: GrainTallies,
    spheres: GrainTallies,
}

impl Simplification {
    /// Every simpler model, and the other table of ice.
    pub const ALL: [Self; 10] = [
        Self::OneIndex,
        Self::ClearIce,
        Self::ClearBlue,
        Self::SpheresOfEqualExtension,
        Self::SpheresOfEqualArea,
        Self::HenyeyGreenstein,
        Self::LinearAbsorption,
        Self::TwoOrdinates,
        Self::DeltaEddington,
        Self::OtherIce,
    ];

    /// A short description.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "none",
            Self::OneIndex => "one refractive index",
            Self::ClearIce => "no absorption",
            Self::ClearBlue => "no absorption below 500 nm",
            Self::SpheresOfEqualExtension => "spheres of equal extension",
            Self::SpheresOfEqualArea => "spheres of equal SSA",
            Self::HenyeyGreenstein => "Henyey–Greenstein",
            Self::LinearAbsorption => "absorption linear in k",
            Self::TwoOrdinates => "two ordinates",
            Self::DeltaEddington => "δ-Eddington",
            Self::OtherIce => "the other ice table",
        }
    }
}

impl<'s> Simplifier<'s> {
    /// Tallies the grains of a slab of dry and clean snow under beams, and smooth spheres of the same sizes.
    ///
    /// # Errors
    /// If a parameter is out of range, the snow holds water or impurities, or the light is diffuse.
    pub fn new(slab: &'s Slab, options: &OrdinatesOptions) -> Result<Self, TransportError> {
        slab.check()?;
        options.streams.check()?;
        ParameterRange { greatest: 0.0, ..WATER_SATURATION.range }.check(slab.sample.water_saturation)?;
        if !slab.sample.impurities.is_none() || slab.incidences.contains(&Incidence::Diffuse) {
            return Err(TransportError::Missing { quantity: "clean snow under beams" });
        }
        let plan = options.plan(&slab.incidences, Peak::Broad);
        let tally = |sample: &SnowSample| {
            GrainTallies::new(&Population::of_sample(sample), &Demand::of_sample(sample, &slab.wavelengths_nm), &plan)
        };
        let grains = tally(&slab.sample);
        Ok(Self { slab, options: *options, grains, spheres: tally(&spheres(&slab.sample)) })
    }

    /// Spectral transmittance by a simpler model, for each thickness, then each incidence.
    #[must_use]
    pub fn transmittance(&self, simplification: Simplification) -> Vec<Vec<f64>> {
        let Slab { thicknesses_cm, incidences, wavelengths_nm, .. } = self.slab;
        // [wavelength][thickness × incidence]
        let by_wavelength: Vec<Vec<f64>> = wavelengths_nm
            .par_iter()
            .map(|wavelength_nm| {
                let medium = self.medium(simplification, *wavelength_nm);
                if simplification == Simplification::DeltaEddington {
                    return thicknesses_cm.iter().flat_map(|h| eddington(&medium, *h, incidences)).collect();
                }
                let streams = match simplification {
                    Simplification::TwoOrdinates => Streams::Exactly(2),
                    _ => self.options.streams,
                };
                medium
                    .fluxes(thicknesses_cm, incidences, streams, Peak::Broad)
                    .iter()
                    .map(|fluxes| fluxes.transmittance)
                    .collect()
            })
            .collect();
        let cases = thicknesses_cm.len() * incidences.len();
        (0..cases).map(|case| by_wavelength.iter().map(|fluxes| fluxes[case]).collect()).collect()
    }

    fn medium(&self, simplification: Simplification, wavelength_nm: f64) -> Medium {
        let sample = &self.slab.sample;
        let ice = sample.ice;
        let (index, absorption_per_m) = (ice.index(wavelength_nm), ice.absorption_per_m(wavelength_nm));
        let of_grains = |index: f64, absorption_per_m: f64| Medium {
            extinction_per_m: sample.extinction_per_m(),
            scattering: self.grains.in_air(&sample.grain_size, index, absorption_per_m),
        };
        let exact = of_grains(index, absorption_per_m);
        match simplification {
            Simplification::OneIndex => of_grains(ice.index(ONE_INDEX_NM), absorption_per_m),
            Simplification::ClearIce => of_grains(index, 0.0),
            Simplification::ClearBlue if wavelength_nm < CLEAR_BELOW_NM => of_grains(index, 0.0),
            Simplification::SpheresOfEqualExtension => self.of_spheres(&spheres(sample), wavelength_nm),
            Simplification::SpheresOfEqualArea => self.of_spheres(&spheres_of_equal_area(sample), wavelength_nm),
            Simplification::HenyeyGreenstein => {
                let Scattering { one_minus_albedo, moments } = &exact.scattering;
                let scattering = HenyeyGreenstein { one_minus_albedo: *one_minus_albedo, asymmetry: moments[1] }
                    .scattering(moments.len() - 1);
                Medium { scattering, ..exact }
            }
            Simplification::LinearAbsorption => {
                const WEAKER: f64 = 1e-9;
                let weak = of_grains(index, absorption_per_m * WEAKER).scattering;
                let scattering = Scattering { one_minus_albedo: weak.one_minus_albedo / WEAKER, ..weak };
                Medium { scattering, ..exact }
            }
            Simplification::OtherIce => of_grains(index, sample.ice.other().absorption_per_m(wavelength_nm)),
            _ => exact,
        }
    }

    fn of_spheres(&self, sample: &SnowSample, wavelength_nm: f64) -> Medium {
        self.spheres.medium(sample, wavelength_nm, None)
    }
}

fn eddington(medium: &Medium, thickness_cm: f64, incidences: &[Incidence]) -> Vec<f64> {
    let under = |incidence: &Incidence| match incidence {
        Incidence::Beam { angle_deg } => delta_eddington(medium, thickness_cm, angle_deg.to_radians().cos()),
        Incidence::Diffuse => unreachable!("the light is beams"),
    };
    incidences.iter().map(under).collect()
}

/// The sample with smooth spheres for grains, of the same sizes.
fn spheres(sample: &SnowSample) -> SnowSample {
    let grain_size = GrainSize { measure: SizeMeasure::GreatestExtension, ..sample.grain_size };
    let (sphericity, facetness) = (TruncatedNormal::exactly(1.0), TruncatedNormal::exactly(0.0));
    SnowSample { grain_size, sphericity, facetness, ..*sample }
}

/// Smooth spheres with all sizes scaled by one factor to the extinction coefficient of the sample.
fn spheres_of_equal_area(sample: &SnowSample) -> SnowSample {
    let equal = spheres(sample);
    let factor = equal.extinction_per_m() / sample.extinction_per_m();
    let GrainSize { min_um, max_um, measure } = equal.grain_size;
    SnowSample { grain_size: GrainSize { min_um: factor * min_um, max_um: factor * max_um, measure }, ..equal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ordinates::solve;

    fn slab() -> Slab {
        Slab {
            sample: SnowSample::default(),
            thicknesses_cm: vec![5.0],
            incidences: vec![Incidence::Beam { angle_deg: 0.0 }, Incidence::Beam { angle_deg: 60.0 }],
            wavelengths_nm: vec![450.0, 550.0, 650.0],
        }
    }

    fn options() -> OrdinatesOptions {
        OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() }
    }

    #[test]
    fn without_simplification_the_engines_result_is_reproduced() {
        let slab = slab();
        let simple = Simplifier::new(&slab, &options()).unwrap().transmittance(Simplification::Exact).concat();
        for (row, simple) in solve(&slab, &options()).unwrap().iter().zip(simple) {
            assert!((row.transmittance.value / simple - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn each_simplification_has_its_effect() {
        let slab = slab();
        let simplifier = Simplifier::new(&slab, &options()).unwrap();
        let exact = simplifier.transmittance(Simplification::Exact);
        let ratio = |simplification: Simplification, case: usize, place: usize| {
            simplifier.transmittance(simplification)[case][place] / exact[case][place]
        };
        assert!((ratio(Simplification::OneIndex, 0, 1) - 1.0).abs() < 1e-12);
        assert!(
            ratio(Simplification::ClearBlue, 0, 0) > 1.0
                && (ratio(Simplification::ClearBlue, 0, 2) - 1.0).abs() < 1e-12
        );
        let clear = [0, 2].map(|place| ratio(Simplification::ClearIce, 0, place));
        assert!(clear[0] > 1.0 && clear[1] > 1.05 && clear[1] - 1.0 > 10.0 * (clear[0] - 1.0), "{clear:?}");
        // Spheres of the same extension have less extinction and scatter further forward.
        assert!(ratio(Simplification::SpheresOfEqualExtension, 0, 1) > ratio(Simplification::SpheresOfEqualArea, 0, 1));
        assert!(ratio(Simplification::SpheresOfEqualArea, 0, 1) > 1.1);
        assert!((ratio(Simplification::LinearAbsorption, 0, 0) - 1.0).abs() < 1e-3);
        for simple in [Simplification::HenyeyGreenstein, Simplification::DeltaEddington, Simplification::TwoOrdinates] {
            assert!((ratio(simple, 0, 1) - 1.0).abs() < 0.2 && (ratio(simple, 0, 1) - 1.0).abs() > 1e-4, "{simple:?}");
        }
        let equal = spheres_of_equal_area(&slab.sample).extinction_per_m();
        assert!((equal / slab.sample.extinction_per_m() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn wet_snow_is_refused() {
        let mut slab = slab();
        slab.sample.water_saturation = 0.1;
        assert!(Simplifier::new(&slab, &options()).is_err());
    }
}
