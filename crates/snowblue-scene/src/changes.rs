//! Differences between two descriptions of a scene, so that the unchanged parts need not be built again.

use crate::film::FilmSettings;
use crate::integrator::IntegratorSettings;
use crate::material::MaterialDescription;
use crate::scene::SceneDescription;
use crate::sky::SkyDescription;

/// The differences between two descriptions of a scene.
#[derive(Debug, Clone)]
pub struct Changes {
    /// Whether objects, materials or parts that depend on the integrator differ.
    pub solids: bool,
    /// Whether the grids of the light field differ.
    pub grids: bool,
    /// Whether the view of the camera differs. Cells may depend on the view.
    pub view: bool,
    /// Whether each described light is the same; none if the number of lights differs.
    same_lights: Option<Vec<bool>>,
    /// Whether the greatest number of surfaces on a light path differs.
    bounces: bool,
}

impl Changes {
    /// The differences between two descriptions whose files are the same.
    pub fn new(one: &SceneDescription, other: &SceneDescription) -> Self {
        // All keys are named here, so that the code does not compile until a new key is handled here.
        let SceneDescription {
            gltf,
            camera,
            film: FilmSettings { width, height, exposure: _, tone: _, white: _ },
            integrator:
                IntegratorSettings {
                    kind,
                    samples_per_pixel: _,
                    noise_target: _,
                    filter: _,
                    max_bounces,
                    seed: _,
                    pcasnow: _,
                },
            light_field,
            // A name has one meaning, and materials have the names.
            substances: _,
            materials,
            lights,
            environment,
            sky,
            objects,
            local_origin,
        } = one;
        let solids = *gltf != other.gltf
            || *materials != other.materials
            || *objects != other.objects
            || *local_origin != other.local_origin
            || *kind != other.integrator.kind
            // Without `camera`, the scene takes the camera of the glTF.
            || camera.is_some() != other.camera.is_some();
        let view = *camera != other.camera || [*width, *height] != [other.film.width, other.film.height];
        let has_relief = || materials.values().any(MaterialDescription::has_relief);
        let grids = solids || *light_field != other.light_field || view && has_relief();
        let count = |sky: &Option<SkyDescription>| sky.as_ref().map_or(0, SkyDescription::light_count);
        let has_same_lights = lights.len() == other.lights.len()
            && environment.is_some() == other.environment.is_some()
            && count(sky) == count(&other.sky);
        let same_lights = has_same_lights.then(|| {
            let pairs = lights.iter().zip(&other.lights);
            let same = pairs.map(|(one, other)| one == other);
            let same = same.chain(environment.as_ref().map(|_| *environment == other.environment));
            same.chain(std::iter::repeat_n(*sky == other.sky, count(sky))).collect()
        });
        Self { solids, grids, view, same_lights, bounces: *max_bounces != other.integrator.max_bounces }
    }

    /// Whether any described light differs.
    pub(crate) fn any_light(&self) -> bool {
        self.same_lights.as_ref().is_none_or(|same| same.contains(&false))
    }

    /// Whether the contribution of a light of the scene, given by its index, differs. The lights of a glTF follow the
    /// described lights.
    pub fn has_light(&self, index: usize) -> bool {
        self.bounces || self.same_lights.as_ref().is_none_or(|same| same.get(index) == Some(&false))
    }
}
