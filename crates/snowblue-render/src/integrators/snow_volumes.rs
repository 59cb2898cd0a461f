//! The snow of a scene for random walks from grain to grain.

use std::sync::Arc;

use snowblue_transport::monte_carlo::{GrainPlan, PathLengths, Volume, WalkEnds};
use snowblue_transport::{SnowSample, TransportError};

use crate::error::RenderError;
use snowblue_light_field::{EndDepth, SnowOfMaterials, WalkEndsByDepth};
use snowblue_scene::Scene;
use snowblue_scene::material::snow::SnowKinds;
use snowblue_scene::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

/// Scattering events per ray through grains that the scene asks for, for walks of any length; short walks have one
/// event per ray. With the usual 2¹⁸ rays each bin has some thousand events: P has a standard error of 1.5 % in each
/// bin, and far less in the mean over the bins.
const LONG_WALK_GRAINS: u32 = 4;
/// Greatest number of scattering events of all kinds of snow together, of 12 bytes each.
const MAX_GRAINS: usize = 1 << 26;
/// Nodes of the refractive index in snow that is clean and dry.
const FEW_NODES: usize = 3;

/// The kinds of snow of a material as volumes.
#[derive(Debug)]
pub(crate) struct SnowVolumes {
    pub(crate) kinds: Arc<SnowKinds>,
    /// The volume of each kind.
    pub(crate) volumes: Vec<Volume>,
}

impl SnowVolumes {
    /// The snow of a scene for walks of any length, at a few nodes of the refractive index.
    pub(crate) fn for_long_walks(
        scene: &Scene,
        kinds: &SnowOfMaterials<SnowKinds>,
    ) -> Result<SnowOfMaterials<Self>, RenderError> {
        let samples: Vec<SnowSample> = kinds.iter().flatten().flat_map(|kinds| &kinds.samples).copied().collect();
        let is_plain = |sample: &SnowSample| sample.impurities.is_none() && sample.water_saturation <= 0.0;
        let nodes = if samples.iter().all(is_plain) { FEW_NODES } else { SAMPLES };
        let most = u32::try_from(MAX_GRAINS / (nodes * samples.len().max(1))).unwrap_or(u32::MAX);
        let wished = scene.description().light_field.grain_rays.saturating_mul(LONG_WALK_GRAINS);
        let plan = GrainPlan { grains: wished.min(most), seed: 1 };
        let volumes = Volume::of_samples(&samples, &wavelengths_nm(), &plan);
        let mut volumes = volumes.map_err(|error| unusable(scene, &error))?.into_iter();
        let mut of_kinds = |kinds: &Arc<SnowKinds>| {
            let volumes = volumes.by_ref().take(kinds.samples.len()).collect();
            Arc::new(Self { kinds: Arc::clone(kinds), volumes })
        };
        Ok(kinds.iter().map(|kinds| kinds.as_ref().map(&mut of_kinds)).collect())
    }

    /// The snow of a scene for walks of a few transport mean free paths, with one refractive index.
    pub(crate) fn for_short_walks(
        scene: &Scene,
        kinds: &SnowOfMaterials<SnowKinds>,
    ) -> Result<SnowOfMaterials<Self>, RenderError> {
        let plan = GrainPlan { grains: scene.description().light_field.grain_rays, seed: 1 };
        let volume = |sample: &SnowSample| Volume::with_one_index(sample, &wavelengths_nm(), &plan);
        let of_kinds = |kinds: &Arc<SnowKinds>| {
            let volumes: Result<_, _> = kinds.samples.iter().map(volume).collect();
            Ok(Arc::new(Self { kinds: Arc::clone(kinds), volumes: volumes.map_err(|error| unusable(scene, &error))? }))
        };
        kinds.iter().map(|kinds| kinds.as_ref().map(of_kinds).transpose()).collect()
    }

    /// Where walks end in a kind of snow with a transport mean free path in m.
    pub(crate) fn walk_ends(&self, kind: usize, transport_length_m: f64) -> WalkEndsByDepth {
        let node = &self.volumes[kind].nodes()[0];
        EndDepth::ALL.map(|depth| WalkEnds::new(node, transport_length_m, depth.lengths().into()))
    }

    /// The greatest extinction coefficient of all kinds at a node, in 1/m.
    #[inline]
    pub(crate) fn greatest_extinction_per_m(&self, node: usize) -> f64 {
        self.volumes.iter().map(|volume| volume.nodes()[node].extinction_per_m()).fold(0.0, f64::max)
    }
}

fn unusable(scene: &Scene, error: &TransportError) -> RenderError {
    scene.material_path(usize::MAX).error(format!("has snow that cannot be rendered: {error}")).into()
}

/// Attenuation of each wavelength by absorption along a path, less the optical depth `accounted`.
pub(super) fn attenuation(volume: &Volume, lengths: &PathLengths, accounted: f64) -> Spectrum {
    let mut attenuation = Spectrum::ZERO;
    volume.attenuation(lengths, accounted, &mut attenuation.0);
    attenuation
}
