//! The curves of snow for PCASnow: read from the table where it holds the snow, else solved by discrete ordinates.
//!
//! Curves are mixed logarithmically between the kinds of snow of a mask. Of snow of layers, those of the layer at the
//! point that is seen count.

use std::sync::Arc;

use snowblue_database::fill::ice_from_metadata;
use snowblue_database::lookup::SnowMix;
use snowblue_database::{CompressedTable, DatabaseError, PcaSnow, TableSample};
use snowblue_transport::SnowSample;

use crate::scene::material::snow::SnowKinds;
use crate::scene::objects::{Objects, SurfaceInteraction};
use crate::spectrum::SAMPLES;

/// Rays through grains for curves that are solved: 0.2 % in the transmittance of 15 cm.
const SOLVED_RAYS: u32 = 1 << 18;

/// The curves of a material's snow.
#[derive(Debug)]
pub(crate) struct SnowCurves {
    kinds: Arc<SnowKinds>,
    /// Of each kind.
    curves: Vec<PcaSnow>,
}

impl SnowCurves {
    /// The curves of snow at some wavelengths, with the reason why they are not from the table if they are solved.
    ///
    /// # Errors
    ///
    /// If curves cannot be solved.
    pub(crate) fn new(
        kinds: &Arc<SnowKinds>,
        wavelengths_nm: &[f64; SAMPLES],
        table: Option<&CompressedTable>,
    ) -> Result<(Self, Option<String>), DatabaseError> {
        let of_table = |sample: &SnowSample| look_up(table, sample, wavelengths_nm);
        let (curves, reason) = match kinds.samples.iter().map(of_table).collect() {
            Ok(curves) => (curves, None),
            Err(reason) => (PcaSnow::solve(&kinds.samples, wavelengths_nm, SOLVED_RAYS)?, Some(reason)),
        };
        Ok((Self { kinds: Arc::clone(kinds), curves }, reason))
    }

    /// The curves, if they are the same everywhere.
    pub(crate) fn single(&self) -> Option<&PcaSnow> {
        self.curves.first().filter(|_| self.kinds.is_uniform())
    }

    /// The curves at a hit.
    #[inline]
    pub(crate) fn at(&self, objects: &Objects, surface: &SurfaceInteraction) -> SnowMix<'_> {
        if self.kinds.is_uniform() {
            return SnowMix::single(&self.curves[0]);
        }
        let mix = self.kinds.at_surface(objects, surface);
        SnowMix::new(&self.curves[mix.first], &self.curves[mix.second], mix.share)
    }
}

/// The curves of a sample from a table, or why it does not have them.
fn look_up(
    table: Option<&CompressedTable>,
    sample: &SnowSample,
    wavelengths_nm: &[f64; SAMPLES],
) -> Result<PcaSnow, String> {
    let table = table.ok_or("there is no table")?;
    let own = &table.axes.wavelengths_nm;
    let is_same = |(one, other): (&f64, &f64)| (one - other).abs() < 1e-6;
    if own.len() != SAMPLES || !own.iter().zip(wavelengths_nm).all(is_same) {
        return Err("the table has other wavelengths than the picture".to_owned());
    }
    // A table of measurements or of another model may name no ice.
    if ice_from_metadata(&table.metadata).is_ok_and(|ice| ice != sample.ice) {
        return Err("the table was made with other constants of ice".to_owned());
    }
    let sample = TableSample::of(sample).ok_or("its grains have other sizes or shapes than those of the table")?;
    PcaSnow::new(table, &sample).map_err(|error| error.to_string())
}
