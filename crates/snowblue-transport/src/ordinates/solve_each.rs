//! Fluxes of slabs of a medium, and of slabs of several samples. Samples with equal grain shapes share a tally, so
//! that their differences are free of the noise of the tally.

use rayon::prelude::*;

use super::homogeneous::{HomogeneousMedium, MediumFluxes, ModalLight};
use super::options::{OrdinatesOptions, Peak, StreamGroup, Streams};
use crate::TransportError;
use crate::medium::{Demand, GrainTallies, Medium, Population};
use crate::sample::SnowSample;
use crate::slab::{Incidence, Slab};

impl Medium {
    /// Fluxes of slabs of this medium over a black ground, for each thickness, then each incidence.
    ///
    /// `peak` is the forward peak of the medium, which decides how many streams [`Streams::Auto`] takes.
    #[must_use]
    pub fn fluxes(
        &self,
        thicknesses_cm: &[f64],
        incidences: &[Incidence],
        streams: Streams,
        peak: Peak,
    ) -> Vec<MediumFluxes> {
        let nothing = MediumFluxes { reflectance: 0.0, transmittance: 0.0, direct: 0.0 };
        let mut filled = vec![nothing; thicknesses_cm.len() * incidences.len()];
        for StreamGroup { streams, places } in streams.groups(incidences, peak) {
            let modes = HomogeneousMedium::new(&self.scattering, streams);
            let lights: Vec<ModalLight> = places.iter().map(|place| modes.light(&incidences[*place])).collect();
            for (row, thickness_cm) in filled.chunks_exact_mut(incidences.len()).zip(thicknesses_cm) {
                let optical_depth = self.extinction_per_m * thickness_cm * 0.01;
                for (place, fluxes) in places.iter().zip(modes.fluxes(optical_depth, &lights)) {
                    row[*place] = fluxes;
                }
            }
        }
        filled
    }
}

/// Fluxes of the slabs of one sample: a spectrum for each thickness and incidence.
#[derive(Debug, Clone, PartialEq)]
pub struct FluxSpectra {
    incidences: usize,
    wavelengths: usize,
    /// Thickness, incidence, wavelength; the wavelength varies fastest.
    fluxes: Vec<MediumFluxes>,
}

impl FluxSpectra {
    /// The spectrum of the slab's thickness number `thickness` under its incidence number `incidence`.
    ///
    /// # Panics
    /// If the slab has fewer thicknesses or incidences.
    #[must_use]
    pub fn spectrum(&self, thickness: usize, incidence: usize) -> &[MediumFluxes] {
        assert!(incidence < self.incidences, "incidence is {incidence}, but there are {}", self.incidences);
        &self.fluxes[(thickness * self.incidences + incidence) * self.wavelengths..][..self.wavelengths]
    }
}

/// Fluxes of slabs of each of `samples`, which replace the slab's own. Samples with equal sphericity, facetness, size
/// measure and ice table share a tally.
///
/// ```
/// use snowblue_transport::ordinates::{OrdinatesOptions, solve_each};
/// use snowblue_transport::sample::SnowSample;
/// use snowblue_transport::slab::{Incidence, Slab};
///
/// let dry = SnowSample::default();
/// let wet = SnowSample { water_saturation: 0.2, ..dry };
/// let slab = Slab {
///     sample: dry,
///     thicknesses_cm: vec![5.0],
///     incidences: vec![Incidence::Diffuse],
///     wavelengths_nm: vec![450.0],
/// };
/// let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
/// let fluxes = solve_each(&[dry, wet], &slab, &options)?;
/// // Ice in water hardly scatters, so wet snow transmits more light.
/// assert!(fluxes[1].spectrum(0, 0)[0].transmittance > 1.1 * fluxes[0].spectrum(0, 0)[0].transmittance);
/// # Ok::<(), snowblue_transport::TransportError>(())
/// ```
///
/// # Errors
/// If a parameter or the number of streams is out of range.
pub fn solve_each(
    samples: &[SnowSample],
    slab: &Slab,
    options: &OrdinatesOptions,
) -> Result<Vec<FluxSpectra>, TransportError> {
    let groups = groups_alike(samples, 0..samples.len());
    let solve = |group: &Vec<usize>| {
        let alike: Vec<SnowSample> = group.iter().map(|place| samples[*place]).collect();
        solve_alike(&alike, slab, options)
    };
    let solved: Vec<_> = groups.par_iter().map(solve).collect::<Result<_, _>>()?;
    let mut answers: Vec<_> = groups.iter().flatten().zip(solved.into_iter().flatten()).collect();
    answers.sort_by_key(|(place, _)| **place);
    Ok(answers.into_iter().map(|(_, answer)| answer).collect())
}

/// Fluxes of slabs of samples, one or more, that one tally serves.
fn solve_alike(
    samples: &[SnowSample],
    slab: &Slab,
    options: &OrdinatesOptions,
) -> Result<Vec<FluxSpectra>, TransportError> {
    options.streams.check()?;
    for sample in samples {
        Slab { sample: *sample, ..slab.clone() }.check()?;
    }
    let demand = Demand::of_samples(samples, &slab.wavelengths_nm);
    let peak = samples.iter().map(Peak::of).max().unwrap_or_default();
    let plan = options.plan(&slab.incidences, peak);
    let tallies = GrainTallies::new(&Population::of_sample(&samples[0]), &demand, &plan);
    let solve = |sample: &SnowSample| {
        let at = |nm: &f64| {
            let medium = tallies.medium(sample, *nm);
            medium.fluxes(&slab.thicknesses_cm, &slab.incidences, options.streams, Peak::of(sample))
        };
        let by_wavelength: Vec<Vec<MediumFluxes>> = slab.wavelengths_nm.par_iter().map(at).collect();
        let cases = 0..slab.thicknesses_cm.len() * slab.incidences.len();
        FluxSpectra {
            incidences: slab.incidences.len(),
            wavelengths: slab.wavelengths_nm.len(),
            fluxes: cases.flat_map(|case| by_wavelength.iter().map(move |fluxes| fluxes[case])).collect(),
        }
    };
    Ok(samples.iter().map(solve).collect())
}

/// Places of samples in groups that one tally serves.
pub(super) fn groups_alike(samples: &[SnowSample], places: impl Iterator<Item = usize>) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for place in places {
        match groups.iter_mut().find(|group| samples[group[0]].has_grains_of(&samples[place])) {
            Some(group) => group.push(place),
            None => groups.push(vec![place]),
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ordinates::solve;
    use crate::sample::TruncatedNormal;
    use crate::slab::Incidence;

    #[test]
    fn a_single_sample_has_the_fluxes_of_solve() {
        let slab = Slab {
            sample: SnowSample::default(),
            thicknesses_cm: vec![2.0, 9.0],
            incidences: vec![Incidence::Diffuse, Incidence::Beam { angle_deg: 30.0 }],
            wavelengths_nm: vec![450.0, 600.0],
        };
        let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
        let alone = solve(&slab, &options).unwrap();
        let own = |sample: SnowSample| solve_each(&[sample], &slab, &options).unwrap().remove(0);
        let each = own(slab.sample);
        for (case, alone) in alone.chunks_exact(2).enumerate() {
            for (alone, each) in alone.iter().zip(each.spectrum(case / 2, case % 2)) {
                assert!((alone.fluxes.transmittance.value / each.transmittance - 1.0).abs() < 1e-12);
                assert!((alone.fluxes.reflectance.value / each.reflectance - 1.0).abs() < 1e-12);
            }
        }
        let other = SnowSample { facetness: TruncatedNormal::exactly(0.5), ..slab.sample };
        let each = solve_each(&[slab.sample, other, slab.sample], &slab, &options).unwrap();
        assert_eq!(each, [own(slab.sample), own(other), own(slab.sample)]);
    }
}
