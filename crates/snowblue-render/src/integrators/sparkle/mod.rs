//! Sparkle: single facets of grains that mirror a light into the camera.
//!
//! The reflection function R₀ of snow contains the mean of the first reflection from the outside of grains,
//!
//! ```text
//! L_ext = F p_ext(Θ)/(μ + μ₀),
//! ```
//!
//! with p_ext of [`ExternalReflection`](snowblue_transport::medium::ExternalReflection): light scattered once, which
//! meets grains by chance on its way in and out. Sparkle draws the facets whose mean is L_ext. The radiance of a
//! camera sample changes by L_ext (S − 1), where S is the light of the facets in the sample's footprint divided by
//! its mean. So the mean over many pixels does not change.
//!
//! - [`facets`] computes S: the number and the sizes of facets, and the light that each facet reflects.
//! - [`facet_field`] places the facets: positions and orientations by a hash, fixed to the object, without bounds.
//! - [`footprint`] is the part of the surface that a sample sees.
//!
//! This file connects these parts with the objects and lights of a scene, for the integrators.
//!
//! Discrete facets on a grid of places and directions follow Jakob, Hašan, Yan, Lawrence, Ramamoorthi & Marschner
//! (2014, *Discrete stochastic microfacet models*, doi:10.1145/2601097.2601186). So few facets of snow mirror the sun
//! that they can be listed. Neither a hierarchy of facets is needed, as by Jakob et al., nor random numbers of facets
//! for each footprint, as by Zirr & Kaplanyan (2016, doi:10.1145/2856400.2856409) and Deliot & Belcour (2023,
//! doi:10.1111/cgf.14866).

mod facet_field;
mod facets;
mod footprint;

use glam::{Mat3A, Vec3A};
use snowblue_geometry::ray::Ray;
use snowblue_light_field::SnowOfMaterials;
use snowblue_scene::Scene;
use snowblue_scene::light::{Light, LightDirection, LightSample};
use snowblue_scene::material::snow::SnowKinds;
use snowblue_scene::objects::{Objects, SurfaceInteraction};
use snowblue_scene::spectrum::Spectrum;

use crate::error::RenderError;
use crate::integrators::sparkle::facet_field::{BandBins, Place};
use crate::integrators::sparkle::facets::{Beam, Facets, Nodes, Patch};
use crate::integrators::sparkle::footprint::Footprint;

/// The facets of all snow of a scene that sparkles.
#[derive(Debug)]
pub(in crate::integrators) struct SceneSparkle {
    nodes: Nodes,
    /// The facets of each kind of snow of each material; none where facets are not drawn.
    facets: Vec<Vec<Option<Facets>>>,
    /// Axes and origin of each object.
    frames: Vec<(Mat3A, Vec3A)>,
}

/// Reads sparkle for one task.
#[derive(Debug)]
pub(in crate::integrators) struct SparkleReader<'a> {
    scene: &'a Scene,
    sparkle: &'a SceneSparkle,
    bins: Vec<BandBins>,
}

/// Snow that a camera ray meets and that sparkles.
pub(in crate::integrators) struct SparklingPoint<'a> {
    facets: &'a Facets,
    patch: Patch,
    axes: Mat3A,
    point: Vec3A,
    normal: Vec3A,
}

impl SceneSparkle {
    /// The facets of a scene with the given kinds of snow.
    ///
    /// # Errors
    ///
    /// If the constants of some snow do not cover a wavelength.
    pub(in crate::integrators) fn new(scene: &Scene, kinds: &SnowOfMaterials<SnowKinds>) -> Result<Self, RenderError> {
        let nodes = Nodes::new();
        let mut facets = Vec::with_capacity(kinds.len());
        for (material, kinds) in kinds.iter().enumerate() {
            let mut of_kinds = Vec::new();
            if let (Some(sparkle), Some(kinds)) = (scene.materials()[material].sparkle(), kinds) {
                for (kind, sample) in kinds.samples.iter().enumerate() {
                    let seed = (material as u64) << 32 | kind as u64;
                    let of_kind = Facets::new(sample, sparkle, &nodes, seed);
                    let path = scene.material_path(material);
                    of_kinds.push(of_kind.map_err(|error| path.error(format!("cannot be rendered: {error}")))?);
                }
            }
            facets.push(of_kinds);
        }
        let frames = scene.objects().list().iter().map(|object| object.shape.frame()).collect();
        Ok(Self { nodes, facets, frames })
    }

    /// Whether snow of a material has facets anywhere.
    #[inline]
    pub(in crate::integrators) fn has_facets(&self, material: usize) -> bool {
        self.facets.get(material).is_some_and(|kinds| kinds.iter().any(Option::is_some))
    }
}

impl<'a> SparkleReader<'a> {
    /// Reads the sparkle of a scene.
    pub(in crate::integrators) fn new(scene: &'a Scene, sparkle: &'a SceneSparkle) -> Self {
        Self { scene, sparkle, bins: Vec::new() }
    }

    /// The objects of the scene.
    pub(in crate::integrators) fn objects(&self) -> &'a Objects {
        self.scene.objects()
    }

    /// The facets where a camera ray meets snow of a kind; `normal` is the normal for shading.
    pub(in crate::integrators) fn at(
        &self,
        (surface, kind, normal): (&SurfaceInteraction, usize, Vec3A),
        camera_ray: &Ray,
    ) -> Option<SparklingPoint<'a>> {
        let facets = self.sparkle.facets.get(surface.material)?.get(kind)?.as_ref()?;
        let (axes, origin) = self.sparkle.frames[surface.object];
        let film = self.scene.film();
        let changes = self.scene.camera().ok()?.change_per_pixel(camera_ray, [film.width.get(), film.height.get()]);
        let to_object = |vector: Vec3A| axes.transpose() * vector;
        let to_eye_m = camera_ray.origin - surface.point;
        let plane = to_object(surface.normal);
        let footprint =
            Footprint::new(to_object(camera_ray.direction), to_eye_m.length(), changes.map(to_object), plane)?;
        let axis = plane.abs().max_position();
        let local = axes.as_dmat3().transpose() * (surface.point.as_dvec3() - origin.as_dvec3());
        let patch = Patch {
            place: Place { object: surface.object, point: local.to_array(), axis },
            footprint,
            normal: plane,
            to_eye_m: to_object(to_eye_m),
            cos_exit: -normal.dot(camera_ray.direction),
        };
        Some(SparklingPoint { facets, patch, axes, point: surface.point, normal })
    }

    /// The change of the radiance by sparkle at a point, per irradiance by a light sample that is visible from the
    /// point, in 1/sr: the light of the facets less its mean, where the mean counts as at most `most_per_sr`. None
    /// where reflection is smooth.
    pub(in crate::integrators) fn change(
        &mut self,
        at: &SparklingPoint,
        light: &Light,
        sample: &LightSample,
        most_per_sr: f32,
    ) -> Option<Spectrum> {
        let variance = light.angular_variance(at.point)?;
        let centre = light.central_sample().map_or(sample.origin, |central| central.origin);
        let LightDirection { direction, distance_m } = centre.direction_from(at.point);
        let beam = Beam {
            to_light: at.axes.transpose() * direction,
            distance_m,
            variance,
            cos_incidence: at.normal.dot(direction),
        };
        if beam.cos_incidence <= 0.0 || at.patch.cos_exit <= 0.0 {
            return None;
        }
        let glints = at.facets.glints(&at.patch, &beam, &mut self.bins)?;
        let change = |node: usize| glints.per_sr[node].min(most_per_sr) * (glints.ratio[node] - 1.0);
        Some(self.sparkle.nodes.spectrum(std::array::from_fn(change)))
    }
}
