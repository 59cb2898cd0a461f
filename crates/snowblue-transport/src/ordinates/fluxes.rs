//! Fluxes of slabs of a medium, each light with the number of ordinates that it needs.

use super::homogeneous::{Fluxes, HomogeneousMedium, Light};
use super::streams::{Peak, StreamGroup, Streams};
use crate::medium::Medium;
use crate::slab::Incidence;

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
    ) -> Vec<Fluxes> {
        let nothing = Fluxes { reflectance: 0.0, transmittance: 0.0, direct: 0.0 };
        let mut filled = vec![nothing; thicknesses_cm.len() * incidences.len()];
        for StreamGroup { streams, places } in streams.groups(incidences, peak) {
            let modes = HomogeneousMedium::new(&self.scattering, streams);
            let lights: Vec<Light> = places.iter().map(|place| modes.light(&incidences[*place])).collect();
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
