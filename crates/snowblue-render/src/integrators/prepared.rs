//! What an integrator has prepared of a scene, which the tracers of all tasks share.

use std::sync::{Arc, OnceLock};

use crate::error::RenderError;
use crate::integrators::path::carried::LightTables;
use crate::integrators::path::vertex::OpenSky;
use crate::integrators::snow_vertex::SnowCurves;
use crate::integrators::snow_volumes::SnowVolumes;
use crate::integrators::sparkle::SceneSparkle;
use crate::integrators::surroundings::SnowBodies;
use snowblue_light_field::{BodyOptics, LightField, SnowOfMaterials, optics_of_materials};
use snowblue_scene::material::snow::SnowKinds;
use snowblue_scene::progress::Report;
use snowblue_scene::{Changes, Scene};

/// Rays through grains for the albedo of snow, where nothing else needs its optics.
const ALBEDO_RAYS: u32 = 1 << 14;

/// A scene, and what a method has prepared of it.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) scene: Scene,
    pub(super) method: Method,
    pub(super) bodies: SnowBodies,
    /// The facets of snow that sparkles; none where nothing does.
    pub(super) sparkle: Option<SceneSparkle>,
    /// The responses to each light, and none, for pictures of spectra.
    pub(super) tables: LightTables,
    pub(super) no_tables: LightTables,
    /// Of a picture that is filtered.
    pub(super) sky: OpenSky,
}

/// What an integrator has prepared.
#[derive(Debug)]
pub(super) enum Method {
    /// The curves of each material's snow.
    PcaSnow(SnowOfMaterials<SnowCurves>),
    Diffusion(LightField),
    Hybrid(LightField, SnowOfMaterials<SnowVolumes>),
    /// Volumes, and the optics of the snow's surface once they are asked for.
    Reference(SnowOfMaterials<SnowVolumes>, Box<OnceLock<SnowOfMaterials<BodyOptics>>>),
}

impl Prepared {
    /// # Errors
    ///
    /// If the constants of some snow do not cover a wavelength.
    pub(super) fn new(scene: &Scene, method: Method) -> Result<Self, RenderError> {
        let tables = match &method {
            Method::PcaSnow(curves) => LightTables::new(scene, curves),
            Method::Diffusion(_) => LightTables::new(scene, &[]),
            Method::Hybrid(..) | Method::Reference(..) => LightTables::none(scene),
        };
        let (bodies, no_tables) = (SnowBodies::new(scene), LightTables::none(scene));
        let is_drawn = !matches!(method, Method::Reference(..))
            && scene.materials().iter().any(|material| material.sparkle().is_some());
        let sparkle = is_drawn.then(|| SceneSparkle::new(scene, &method.kinds(scene))).transpose()?;
        let is_filtered = scene.description().is_filtered();
        let sky = OpenSky::new(scene.lights().iter().map(Arc::as_ref).filter(|_| is_filtered));
        Ok(Self { scene: scene.clone(), method, bodies, sparkle, tables, no_tables, sky })
    }

    /// Why snow does not sparkle that should, in sentences.
    pub(super) fn sparkle_notes(&self) -> Vec<String> {
        let is_reference = matches!(self.method, Method::Reference(..));
        let materials = self.scene.materials().iter().enumerate().filter(|(_, material)| material.sparkle().is_some());
        let note = |(material, _): (usize, _)| {
            let reason = match &self.sparkle {
                _ if is_reference => "the reference has no facets that stay in their places",
                Some(sparkle) if !sparkle.has_facets(material) => "its grains have no flat facets in air",
                _ => return None,
            };
            Some(format!("{}: its sparkle is not drawn, because {reason}", self.scene.material_path(material)))
        };
        materials.filter_map(note).collect()
    }

    /// The optics of the snow of a material, if it is snow, where the method has no curves.
    pub(super) fn body_optics(&self, material: usize) -> Option<&BodyOptics> {
        let Method::Reference(volumes, snow) = &self.method else { return None };
        let snow = snow.get_or_init(|| {
            let kinds: SnowOfMaterials<SnowKinds> =
                volumes.iter().map(|snow| snow.as_ref().map(|snow| Arc::clone(&snow.kinds))).collect();
            optics_of_materials(&self.scene, &kinds, ALBEDO_RAYS, &|_, _, _| None).unwrap_or_default()
        });
        snow.get(material)?.as_deref()
    }
}

impl Method {
    pub(super) fn diffusion(
        scene: &Scene,
        kinds: &SnowOfMaterials<SnowKinds>,
        has_one_view: bool,
        report: Report,
    ) -> Result<Self, RenderError> {
        let rays = scene.description().light_field.grain_rays;
        let snow = optics_of_materials(scene, kinds, rays, &|_, _, _| None)?;
        Ok(Self::Diffusion(LightField::of_scene(scene, &snow, has_one_view, report)?))
    }

    pub(super) fn hybrid(
        scene: &Scene,
        kinds: &SnowOfMaterials<SnowKinds>,
        has_one_view: bool,
        report: Report,
    ) -> Result<Self, RenderError> {
        let volumes = SnowVolumes::for_short_walks(scene, kinds)?;
        let walk_ends = |material: usize, kind: usize, length_m: f64| {
            volumes[material].as_ref().map(|snow| snow.walk_ends(kind, length_m))
        };
        let snow = optics_of_materials(scene, kinds, scene.description().light_field.grain_rays, &walk_ends)?;
        Ok(Self::Hybrid(LightField::of_scene(scene, &snow, has_one_view, report)?, volumes))
    }

    /// The same snow under changed lights.
    pub(super) fn relit(self, scene: &Scene, changes: &Changes, report: Report) -> Result<Self, RenderError> {
        Ok(match self {
            Self::Diffusion(field) => Self::Diffusion(field.after_changes(scene, changes, report)?),
            Self::Hybrid(field, volumes) => Self::Hybrid(field.after_changes(scene, changes, report)?, volumes),
            Self::PcaSnow(_) | Self::Reference(..) => self,
        })
    }

    /// The kinds of the snow of each material that an object has.
    fn kinds(&self, scene: &Scene) -> SnowOfMaterials<SnowKinds> {
        let of_object = |object: usize, material: usize| match self {
            Self::PcaSnow(curves) => curves[material].as_ref().map(|curves| Arc::clone(curves.kinds())),
            Self::Diffusion(field) | Self::Hybrid(field, _) => {
                field.of_object(object).map(|body| Arc::clone(&body.snow().kinds))
            }
            Self::Reference(volumes, _) => volumes[material].as_ref().map(|snow| Arc::clone(&snow.kinds)),
        };
        let mut kinds = vec![None; scene.materials().len()];
        for (object, material) in scene.objects().list().iter().map(|object| object.material).enumerate() {
            if kinds[material].is_none() && scene.materials()[material].is_snow() {
                kinds[material] = of_object(object, material);
            }
        }
        kinds
    }

    pub(super) fn field(&self) -> Option<&LightField> {
        match self {
            Self::Diffusion(field) | Self::Hybrid(field, _) => Some(field),
            Self::PcaSnow(_) | Self::Reference(..) => None,
        }
    }
}
