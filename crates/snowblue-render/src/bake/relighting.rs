//! The light of one lamp after the other on the same snow, for programs in which lamps move.
//!
//! The grid inside the snow and the vertices of its surface are made once. Light is linear, so a program adds up the
//! lamps, each with its own solution, and scales them as it likes.

use rayon::prelude::*;
use snowblue_color::LinearRgb;

use super::{BakeError, BakedObject, MOST_VERTICES, Surface, rgb, surfaces};
use crate::bake::BakeOptions;
use crate::geometry::ray::SurfacePoint;
use crate::scene::Scene;
use crate::scene::light::{Light, PointLight};
use crate::scene::light_field::{BodyField, FieldScene, InnerLamp, LampInSnow, LightField};
use crate::scene::material::Material;
use crate::scene::objects::{Object, Side, SurfaceInteraction};
use crate::scene::queries::SceneQueries;
use crate::spectrum::Spectrum;

/// The snow of a scene, to be lit by one lamp at a time.
#[derive(Debug)]
pub struct Relighting {
    /// Without its light field.
    scene: Scene,
    /// That of the last light; it is taken and put back when it is solved for anew.
    field: Option<LightField>,
    surfaces: Vec<Surface>,
}

/// The light of a lamp on an object of snow, at each vertex. The surface sends out the radiance
/// L(μ) = R₀ V F + (H + K(μ) J)/π, F the irradiance by the unoccluded lamp.
#[derive(Debug, Clone, PartialEq)]
pub struct LampOnSnow {
    /// The net flux J outwards as linear sRGB, in W/m² as the film of a rendering weights them.
    pub flux: Vec<LinearRgb>,
    /// The irradiance H by other surfaces, the same.
    pub diffuse_irradiance: Vec<LinearRgb>,
    /// The visibility V of the lamp: 0 in shadow, else 1. Where the surface faces away, it is 1.
    pub visibility: Vec<f32>,
}

impl Relighting {
    /// Divides the surface of a scene's snow into triangles with edges of at most `step_m`, or of twice the cells of
    /// the light field.
    ///
    /// # Errors
    ///
    /// When there is no snow, the scene has no light field, or there would be too many vertices.
    pub fn new(mut scene: Scene, step_m: Option<f64>) -> Result<Self, BakeError> {
        let field = scene.light_field.take().ok_or(BakeError::NoField)?;
        let surfaces = surfaces(&scene, &field, BakeOptions { step_m, ..BakeOptions::default() }, MOST_VERTICES)?;
        Ok(Self { scene, field: Some(field), surfaces })
    }

    /// The objects of snow, without light.
    pub fn objects(&self) -> impl ExactSizeIterator<Item = &BakedObject> {
        self.surfaces.iter().map(|surface| &surface.baked)
    }

    /// Unknowns of a solution at each wavelength.
    pub fn node_count(&self) -> usize {
        self.field.as_ref().map_or(0, LightField::node_count)
    }

    /// What a spectrum adds to the film, as linear sRGB.
    pub fn rgb(&self, spectrum: &Spectrum) -> LinearRgb {
        rgb(spectrum, &self.scene.sensor)
    }

    /// Solves for the light of a lamp without any other, and returns it for each object.
    pub fn light(&mut self, lamp: PointLight) -> Vec<LampOnSnow> {
        let Self { scene, surfaces, .. } = self;
        let is_snow = |object: &Object| scene.materials[object.material].is_snow();
        let holder = scene.objects.around(lamp.position, is_snow);
        let light = Light::Point(lamp);
        let inside = holder.and_then(|object| Some(LampInSnow { light: 0, object, lamp: InnerLamp::new(&light)? }));
        let reflectance = |surface: &SurfaceInteraction| match &scene.materials[surface.material] {
            Material::Diffuse(diffuse) => Some(diffuse.reflectance(&scene.objects, surface)),
            Material::PcaSnow(_) | Material::LayeredSnow(_) => None,
        };
        let Some(field) = self.field.take() else { return Vec::new() };
        let field = field.relit(&FieldScene {
            objects: &scene.objects,
            lights: std::slice::from_ref(&light),
            snow: &|_| None,
            lamps_in_snow: inside.as_slice(),
            reflectance: &reflectance,
            max_bounces: scene.integrator.max_bounces,
            viewer: None,
            settings: scene.description.light_field,
        });
        let of_surface = |surface: &Surface| surface.lit(scene, &field, &light);
        let lit = surfaces.iter().map(of_surface).collect();
        self.field = Some(field);
        lit
    }
}

impl Surface {
    /// The light of a lamp at all vertices.
    fn lit(&self, scene: &Scene, field: &LightField, lamp: &Light) -> LampOnSnow {
        let values = |of: &(dyn Fn(&BodyField, SurfacePoint) -> Spectrum + Sync)| -> Vec<LinearRgb> {
            let Some(body) = field.of_object(self.object) else { return Vec::new() };
            let places = self.places().map(|(point, normal)| of(body, SurfacePoint { point, normal }));
            places.map(|spectrum| rgb(&spectrum, &scene.sensor)).collect()
        };
        let visibility = |queries: &mut SceneQueries, (point, normal)| {
            let surface = SurfacePoint { point, normal };
            let is_hidden = lamp.delta_sample().is_some_and(|sample| {
                sample.incident_at(&surface).is_some()
                    && !sample.is_visible(queries, &surface, Side::Outer(self.object))
            });
            if is_hidden { 0.0 } else { 1.0 }
        };
        LampOnSnow {
            flux: values(&|body, surface| body.flux(surface.point, surface.normal)),
            diffuse_irradiance: values(&|body, surface| body.diffuse_irradiance(&surface)),
            visibility: self.places().map_init(|| SceneQueries::new(&scene.objects), visibility).collect(),
        }
    }
}
