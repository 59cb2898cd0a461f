//! The curves of snow for PCASnow: read from the table where it holds the snow, else solved by discrete ordinates.
//!
//! Curves are mixed logarithmically between the kinds of snow of a mask. Of snow of layers, those of the layer at the
//! point that is seen count.

use std::sync::Arc;

use snowblue_database::lookup::SnowMix;
use snowblue_database::{CompressedTable, DatabaseError, PcaSnow};

use snowblue_scene::material::snow::SnowKinds;
use snowblue_scene::objects::{Objects, SurfaceInteraction};
use snowblue_scene::spectrum::wavelengths_nm;

/// The curves of a material's snow.
#[derive(Debug)]
pub(crate) struct SnowCurves {
    kinds: Arc<SnowKinds>,
    /// Of each kind.
    curves: Vec<PcaSnow>,
}

impl SnowCurves {
    /// The curves of snow at the wavelengths of an image. If they are solved, also the reason why the table does not
    /// hold them.
    ///
    /// # Errors
    ///
    /// If curves cannot be solved.
    pub(crate) fn new(
        kinds: &Arc<SnowKinds>,
        table: Option<&CompressedTable>,
    ) -> Result<(Self, Option<String>), DatabaseError> {
        let (curves, reason) = PcaSnow::read_or_solve(table, &kinds.samples, &wavelengths_nm())?;
        Ok((Self { kinds: Arc::clone(kinds), curves }, reason))
    }

    /// The kinds of snow, and where they lie.
    pub(crate) fn kinds(&self) -> &Arc<SnowKinds> {
        &self.kinds
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
