//! What differs between two descriptions, so that the rest of a scene need not be built again.

use crate::film::FilmSettings;
use crate::integrator::IntegratorSettings;
use crate::material::MaterialDescription;
use crate::scene::SceneDescription;
use crate::sky::SkyDescription;

/// What differs between two descriptions.
#[derive(Debug, Clone)]
pub struct Changes {
    /// Objects, materials, or what depends on the integrator.
    pub solids: bool,
    /// The grids of the light field.
    pub grids: bool,
    /// What the camera sees, on which cells may depend.
    pub view: bool,
    /// What is the same for each described light; none if their number differs.
    same_lights: Option<Vec<bool>>,
    /// The greatest number of surfaces on paths of light.
    bounces: bool,
}

impl Changes {
    /// The differences between two descriptions whose files are the same.
    pub fn new(one: &SceneDescription, other: &SceneDescription) -> Self {
        // All keys are named here, so that a new one must be given its place.
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
            materials,
            lights,
            environment,
            sky,
            objects,
        } = one;
        let solids = *gltf != other.gltf
            || *materials != other.materials
            || *objects != other.objects
            || *kind != other.integrator.kind
            // Without a camera there is the camera of the glTF.
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

    /// Whether the light of a light of the scene, given by its index, differs. Those of a glTF follow the described
    /// ones.
    pub fn has_light(&self, index: usize) -> bool {
        self.bounces || self.same_lights.as_ref().is_none_or(|same| same.get(index) == Some(&false))
    }
}
