//! The methods that render snow: the data that a method prepares from a scene, which the tracers of all tasks share,
//! and the questions that pictures ask a method. A new method needs a file of its own, a match arm here for each
//! question and in [`ShadingMethod`], and a name in [`IntegratorKind`].

use std::sync::{Arc, OnceLock};

use glam::Vec3A;
use snowblue_database::CompressedTable;
use snowblue_light_field::{BodyOptics, LightField, SnowOfMaterials};
use snowblue_scene::light::Light;
use snowblue_scene::material::Material;
use snowblue_scene::material::snow::SnowKinds;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::progress::{Phase, Progress, Report};
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::{Changes, IntegratorKind, Scene};

use crate::error::RenderError;
use crate::integrators::diffusion::FieldShader;
use crate::integrators::hybrid::WalkTracer;
use crate::integrators::light_tables::LightTables;
use crate::integrators::pcasnow::{PcaSnow, SnowCurves, TableCurves};
use crate::integrators::snow_shader::{ShadingMethod, SnowShader};
use crate::integrators::snow_volumes::SnowVolumes;
use crate::integrators::sparkle::{SceneSparkle, SparkleReader};
use crate::integrators::surface::OpenSky;
use crate::integrators::surroundings::SnowBodies;

/// Rays through grains for the albedo of snow, where nothing else needs its optics.
const ALBEDO_RAYS: u32 = 1 << 14;

/// A scene, and the data that a method has prepared from it.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) scene: Scene,
    pub(super) method: Method,
    pub(super) bodies: SnowBodies,
    /// The lights as the reference samples them: each is found by rays, or is small.
    pub(super) parts_of_lights: Vec<Arc<Light>>,
    /// The facets of snow that sparkles; none where nothing does.
    pub(super) sparkle: Option<SceneSparkle>,
    /// The responses to each light, and no responses, for pictures of spectra.
    pub(super) tables: LightTables,
    pub(super) no_tables: LightTables,
    /// Smooth skies that nothing hides, for a picture that is filtered.
    pub(super) open_sky: Option<OpenSky>,
}

/// The prepared data of a method.
#[derive(Debug)]
pub(super) enum Method {
    PcaSnow(TableCurves),
    Diffusion(LightField),
    Hybrid(LightField, SnowOfMaterials<SnowVolumes>),
    /// Volumes, and the optics of the snow's surface once they are asked for.
    Reference(SnowOfMaterials<SnowVolumes>, Box<OnceLock<SnowOfMaterials<BodyOptics>>>),
}

/// How a method traces paths.
pub(super) enum Tracing<'a> {
    /// Over surfaces, with a shader of snow.
    OverSurfaces(SnowShader<'a>),
    /// Through the volumes of snow.
    InVolumes(&'a SnowOfMaterials<SnowVolumes>),
}

impl Prepared {
    /// # Errors
    ///
    /// If the constants of some snow do not cover a wavelength.
    pub(super) fn new(scene: &Scene, method: Method) -> Result<Self, RenderError> {
        let tables = method.light_tables(scene);
        let is_reference = matches!(method, Method::Reference(..));
        let parts_of_lights = scene.lights().iter().filter(|_| is_reference).flat_map(Light::parts).collect();
        let (bodies, no_tables) = (SnowBodies::new(scene), LightTables::none(scene));
        let is_drawn = method.draws_sparkle() && scene.materials().iter().any(|material| material.sparkle().is_some());
        let sparkle = is_drawn.then(|| SceneSparkle::new(scene, &method.kinds(scene))).transpose()?;
        let is_filtered = scene.description().is_filtered();
        let open_sky = is_filtered.then(|| OpenSky::new(scene.lights().iter().map(Arc::as_ref)));
        Ok(Self { scene: scene.clone(), method, bodies, parts_of_lights, sparkle, tables, no_tables, open_sky })
    }

    /// The reasons why the sparkle of materials is not drawn, in sentences.
    pub(super) fn sparkle_notes(&self) -> Vec<String> {
        let materials = self.scene.materials().iter().enumerate().filter(|(_, material)| material.sparkle().is_some());
        let note = |(material, _): (usize, _)| {
            let reason = match &self.sparkle {
                _ if !self.method.draws_sparkle() => "the reference has no facets that stay in their places",
                Some(sparkle) if !sparkle.has_facets(material) => "its grains have no flat facets in air",
                _ => return None,
            };
            Some(format!("{}: its sparkle is not drawn, because {reason}", self.scene.material_path(material)))
        };
        materials.filter_map(note).collect()
    }

    /// The way of the method to trace paths, for one task.
    pub(super) fn tracing(&self) -> Tracing<'_> {
        let Self { scene, bodies, .. } = self;
        let with_field = |field, walks| ShadingMethod::Field(Box::new(FieldShader::new(scene, field, bodies, walks)));
        let method = match &self.method {
            Method::PcaSnow(TableCurves { curves, .. }) => {
                ShadingMethod::PcaSnow(PcaSnow::new(&scene.integrator().pcasnow, curves))
            }
            Method::Diffusion(field) => with_field(field, None),
            Method::Hybrid(field, volumes) => with_field(field, Some(WalkTracer::new(scene, field, bodies, volumes))),
            Method::Reference(volumes, _) => return Tracing::InVolumes(volumes),
        };
        let sparkle = self.sparkle.as_ref().map(|sparkle| SparkleReader::new(scene, sparkle));
        Tracing::OverSurfaces(SnowShader { method, sparkle })
    }

    /// The reflectance of snow whose path behind the surface has the depth `depth_m`, for light from straight above:
    /// by PCASnow the reflectance of this depth, else the reflectance of deep snow.
    pub(super) fn snow_reflectance(&self, surface: &SurfaceInteraction, depth_m: f32) -> Spectrum {
        let objects = self.scene.objects();
        let optics = match &self.method {
            Method::PcaSnow(TableCurves { curves, .. }) => {
                let Some(curves) = &curves[surface.material] else { return Spectrum::ZERO };
                return curves.reflectance(&self.scene.integrator().pcasnow, objects, surface, depth_m);
            }
            Method::Diffusion(field) | Method::Hybrid(field, _) => {
                field.of_object(surface.object).map(|body| &**body.snow())
            }
            Method::Reference(volumes, optics) => {
                let optics = optics.get_or_init(|| {
                    let kinds: SnowOfMaterials<SnowKinds> =
                        volumes.iter().map(|snow| snow.as_ref().map(|snow| Arc::clone(&snow.kinds))).collect();
                    BodyOptics::of_materials(&self.scene, &kinds, ALBEDO_RAYS, &|_, _, _| None).unwrap_or_default()
                });
                optics.get(surface.material).and_then(Option::as_deref)
            }
        };
        let optics = optics.map(|snow| snow.at_surface(objects, surface.object, &surface.surface_point()));
        optics.map_or(Spectrum::ZERO, |optics| optics.surface().deep_reflectance(1.0))
    }
}

impl Method {
    /// Prepares the method of a scene, with the table of curves for PCASnow if one is given. `has_one_view` means
    /// that only pictures from the camera of the scene are needed.
    ///
    /// # Errors
    ///
    /// As [`Integrator::prepare_with`](super::Integrator::prepare_with).
    pub(super) fn prepare(
        scene: &Scene,
        table: Option<&CompressedTable>,
        has_one_view: bool,
        report: Report,
        notes: &mut Vec<String>,
    ) -> Result<Self, RenderError> {
        report(Progress { phase: Phase::Snow, done: 0, total: 0 });
        let kinds = |material: &Material| material.snow().map(|snow| Arc::new(snow.kinds()));
        let kinds: SnowOfMaterials<SnowKinds> = scene.materials().iter().map(kinds).collect();
        let rays = scene.description().light_field.grain_rays;
        Ok(match scene.integrator().kind {
            IntegratorKind::PcaSnow => Self::PcaSnow(TableCurves::prepare(scene, &kinds, table, notes)?),
            IntegratorKind::Diffusion => {
                let snow = BodyOptics::of_materials(scene, &kinds, rays, &|_, _, _| None)?;
                Self::Diffusion(LightField::new(scene, &snow, has_one_view, report)?)
            }
            IntegratorKind::Hybrid => {
                let volumes = SnowVolumes::for_short_walks(scene, &kinds)?;
                let walk_ends = |material: usize, kind: usize, length_m: f64| {
                    volumes[material].as_ref().map(|snow| snow.walk_ends(kind, length_m))
                };
                let snow = BodyOptics::of_materials(scene, &kinds, rays, &walk_ends)?;
                Self::Hybrid(LightField::new(scene, &snow, has_one_view, report)?, volumes)
            }
            IntegratorKind::Reference => Self::Reference(SnowVolumes::for_long_walks(scene, &kinds)?, Box::default()),
        })
    }

    /// Whether the method is valid for another scene apart from the lights.
    pub(super) fn holds_after(&self, changes: &Changes, has_one_view: bool) -> bool {
        match self {
            // The table may differ.
            Self::PcaSnow(_) => false,
            Self::Reference(..) => !changes.solids,
            Self::Diffusion(field) | Self::Hybrid(field, _) => {
                let is_of_other_view = field.view_factor().is_some() && changes.view;
                !changes.grids && !is_of_other_view && (has_one_view || !field.has_one_view())
            }
        }
    }

    /// The method for unchanged snow under changed lights.
    pub(super) fn relit(self, scene: &Scene, changes: &Changes, report: Report) -> Result<Self, RenderError> {
        Ok(match self {
            Self::Diffusion(field) => Self::Diffusion(field.after_changes(scene, changes, report)?),
            Self::Hybrid(field, volumes) => Self::Hybrid(field.after_changes(scene, changes, report)?, volumes),
            Self::PcaSnow(_) | Self::Reference(..) => self,
        })
    }

    /// The light field, if the method has one.
    pub(super) fn field(&self) -> Option<&LightField> {
        match self {
            Self::Diffusion(field) | Self::Hybrid(field, _) => Some(field),
            Self::PcaSnow(_) | Self::Reference(..) => None,
        }
    }

    /// Extracts the light field, if the method has one.
    pub(super) fn into_field(self) -> Option<LightField> {
        match self {
            Self::Diffusion(field) | Self::Hybrid(field, _) => Some(field),
            Self::PcaSnow(_) | Self::Reference(..) => None,
        }
    }

    /// A hash of the table of curves, if the method reads one.
    pub(super) fn table_hash(&self) -> Option<u64> {
        if let Self::PcaSnow(TableCurves { table_hash, .. }) = self { *table_hash } else { None }
    }

    /// The direction of the path through snow that does not depend on the lights: the view direction in the mode
    /// `view` of PCASnow, else the inward normal.
    pub(super) fn straight_direction(&self, scene: &Scene, surface: &SurfaceInteraction) -> Vec3A {
        match self {
            Self::PcaSnow(_) => super::pcasnow::straight_direction(scene.integrator().pcasnow.path, surface),
            Self::Diffusion(_) | Self::Hybrid(..) | Self::Reference(..) => -surface.normal,
        }
    }

    /// Whether the method draws single facets of snow.
    fn draws_sparkle(&self) -> bool {
        !matches!(self, Self::Reference(..))
    }

    /// The tables of responses to lights for the method.
    fn light_tables(&self, scene: &Scene) -> LightTables {
        match self {
            Self::PcaSnow(TableCurves { curves, .. }) => LightTables::new(scene, curves),
            Self::Diffusion(_) => LightTables::new(scene, &[]),
            Self::Hybrid(..) | Self::Reference(..) => LightTables::none(scene),
        }
    }

    /// The kinds of snow of each material that an object uses.
    fn kinds(&self, scene: &Scene) -> SnowOfMaterials<SnowKinds> {
        let of_object = |object: usize, material: usize| match self {
            Self::PcaSnow(TableCurves { curves, .. }) => curves[material].as_deref().map(SnowCurves::kinds).cloned(),
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
}
