//! The light of one lamp or sky after the other on the same snow, for programs in which the lights move.
//!
//! The grid inside the snow and the vertices of its surface are computed once. Light is linear, so a program adds up
//! the lights, each with its own solution, and scales each light as needed. A clear sky consists of two lights: the
//! sun, and the sky without the sun.
//!
//! The exposure is computed from the vertices, because the snow may be viewed from any side and no picture is known.
//! A vertex counts by a third of the area of its triangles, so that the exposure does not depend on how finely a part
//! of the surface is divided. Its brightness is that at an angle of 37° to the normal, cos θ = 0.8, without the light
//! of lamps that the surface reflects. Under lamps, only vertices count at which more light leaves than enters.

use std::f64::consts::FRAC_1_PI;
use std::sync::{Arc, OnceLock};

use glam::Vec3A;
use rayon::prelude::*;
use snowblue_base::files::FileSource;
use snowblue_base::narrow;
use snowblue_color::LinearRgb;
use snowblue_color::exposure::AutoExposure;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::ray::SurfacePoint;
use snowblue_scene::description::{LightDescription, SceneDescription, SkyDescription};
use snowblue_scene::light::{Light, LightOrigin};
use snowblue_scene::objects::Side;
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::spectrum::{SAMPLES, Spectrum};
use snowblue_scene::{Scene, SceneError};

use crate::bake::sky_directions::SkyDirections;
use crate::bake::{BakeError, BakedObject, DEFAULT_CELLS, MAX_VERTICES, Surface, rgb, surfaces};
use crate::{BodySolution, LightField};

/// The snow of a scene, to be lit by one light at a time.
#[derive(Debug)]
pub struct Relighting {
    pub(super) scene: Scene,
    /// The light field of the scene.
    field: LightField,
    pub(super) surfaces: Vec<Surface>,
    /// The triangles of each object, once a place on them is sought.
    pub(super) meshes: OnceLock<Vec<MeshBvh>>,
}

/// The snow under one light.
#[derive(Debug)]
pub struct LitSnow {
    pub(super) light: Arc<Light>,
    /// The strength of the light as linear sRGB: the radiant intensity of a point, the irradiance of a surface that
    /// faces a distant light or the sun. Other lights have the radiance that reaches a place; here they have none.
    pub strength: LinearRgb,
    /// The light on each object of snow.
    pub surfaces: Vec<LitSurface>,
    /// The spectra at each vertex of each object, before conversion to colours.
    pub(super) spectra: Vec<Vec<VertexSpectra>>,
    /// The directions of a sky, once the reflection of the sky at a place is needed.
    pub(super) directions: OnceLock<SkyDirections<SAMPLES>>,
}

/// A light on an object of snow, at each vertex. The surface sends out the radiance
/// L(μ) = R₀ V F + (H + K(μ) J)/π, with F the irradiance by the light.
#[derive(Debug, Clone, PartialEq)]
pub struct LitSurface {
    /// The net flux J outwards as linear sRGB, in W/m² as the film of a rendering weights them.
    pub flux: Vec<LinearRgb>,
    /// The irradiance H by other surfaces, in the unit of `flux`.
    pub diffuse_irradiance: Vec<LinearRgb>,
    /// V F of a sky, in the unit of `flux`: the direct irradiance by the sky. Empty for lamps and the sun, whose F
    /// follows from their positions.
    pub sky_irradiance: Vec<LinearRgb>,
    /// The visibility V of a lamp or the sun: the share of its light that passes other surfaces, 0 in shadow. It is 1
    /// where the surface faces away, and for a sky.
    pub visibility: Vec<f32>,
}

/// The net flux J and the irradiance H at a vertex, as band densities in W/m².
#[derive(Debug, Clone, Copy)]
pub(super) struct VertexSpectra {
    pub(super) flux: Spectrum,
    pub(super) irradiance: Spectrum,
}

impl Relighting {
    /// Divides the surface of the snow of a scene into triangles with edges of at most `cells_per_edge` cells of its
    /// light field, by default two.
    ///
    /// # Errors
    ///
    /// When there is no snow, or there would be too many vertices.
    pub fn new(scene: Scene, field: LightField, cells_per_edge: Option<f64>) -> Result<Self, BakeError> {
        let cells = cells_per_edge.unwrap_or(DEFAULT_CELLS);
        let surfaces = surfaces(&scene, &field, |body| cells * body.surface_step_m(), MAX_VERTICES, None)?;
        Ok(Self { scene, field, surfaces, meshes: OnceLock::new() })
    }

    /// The objects of snow, without light.
    pub fn objects(&self) -> impl ExactSizeIterator<Item = &BakedObject> {
        self.surfaces.iter().map(|surface| &surface.baked)
    }

    /// Unknowns of a solution at each wavelength.
    pub fn node_count(&self) -> usize {
        self.field.node_count()
    }

    /// Lights above the snow: the lamps, and then the sun and the sky without it, or an overcast sky. `files` holds the
    /// coefficients of a clear sky where they are not embedded.
    ///
    /// # Errors
    ///
    /// The errors of [`SceneDescription::build`].
    pub fn lights(
        &self,
        lamps: Vec<LightDescription>,
        sky: Option<SkyDescription>,
        files: &dyn FileSource,
    ) -> Result<Vec<Arc<Light>>, SceneError> {
        let description =
            SceneDescription { lights: lamps, sky, film: *self.scene.film(), ..SceneDescription::default() };
        description.lights_over(&self.scene, files)
    }

    /// The [strength](Light::strength) of a light as linear sRGB.
    fn strength(&self, light: &Light) -> LinearRgb {
        rgb(&light.strength(), self.scene.sensor())
    }

    /// The radiance of a sky in a unit direction, as linear sRGB.
    pub fn radiance(&self, sky: &Light, direction: Vec3A) -> LinearRgb {
        self.color(&sky.power(&LightOrigin::Distant(direction)))
    }

    /// A band density as linear sRGB, as the film of a rendering has it.
    #[must_use]
    pub fn color(&self, light: &Spectrum) -> LinearRgb {
        rgb(light, self.scene.sensor())
    }

    /// Solves for the light of a lamp or a sky without any other.
    pub fn light(&self, light: &Arc<Light>) -> LitSnow {
        let max_bounces = self.scene.integrator().max_bounces.get();
        let field = self.field.of_light(&self.scene, light, max_bounces, &|_| {});
        let lit = self.surfaces.iter().map(|surface| surface.lit(&self.scene, &field, light));
        let (surfaces, spectra) = lit.unzip();
        let (light, strength) = (Arc::clone(light), self.strength(light));
        LitSnow { surfaces, spectra, strength, light, directions: OnceLock::new() }
    }
}

impl Surface {
    /// The light of a lamp or a sky at all vertices.
    fn lit(&self, scene: &Scene, field: &LightField, light: &Light) -> (LitSurface, Vec<VertexSpectra>) {
        let spectra_in = |body: &BodySolution| -> Vec<VertexSpectra> {
            let of_place =
                |place| VertexSpectra { flux: body.flux(&place), irradiance: body.diffuse_irradiance(&place) };
            let mut spectra: Vec<VertexSpectra> = self.places().map(of_place).collect();
            for (vertex, [_, flux]) in self.limited(body, &|vertex| spectra[vertex].flux) {
                spectra[vertex].flux = flux;
            }
            spectra
        };
        let spectra = field.of_object(self.object).map_or_else(Vec::new, spectra_in);
        let colors = |of: fn(&VertexSpectra) -> &Spectrum| -> Vec<LinearRgb> {
            spectra.iter().map(|vertex| rgb(of(vertex), scene.sensor())).collect()
        };
        let central = light.central_sample();
        let visibility = |queries: &mut SceneQueries, surface| {
            let facing = central.filter(|sample| sample.incident_at(&surface).is_some());
            facing.map_or(1.0, |sample| sample.transmittance(queries, &surface, Side::Outer(self.object)))
        };
        let surface = LitSurface {
            flux: colors(|vertex| &vertex.flux),
            diffuse_irradiance: colors(|vertex| &vertex.irradiance),
            sky_irradiance: match central {
                Some(_) => Vec::new(),
                None => {
                    let sky = SkyDirections::new(light, |power| {
                        let LinearRgb { r, g, b } = rgb(power, scene.sensor());
                        [r, g, b].map(narrow)
                    });
                    let received = |queries: &mut SceneQueries, surface| {
                        let [r, g, b] = sky.irradiance(queries, &surface, Side::Outer(self.object)).map(f64::from);
                        LinearRgb { r, g, b }
                    };
                    self.places().map_init(|| SceneQueries::new(scene.objects(), scene.materials()), received).collect()
                }
            },
            visibility: self
                .places()
                .map_init(|| SceneQueries::new(scene.objects(), scene.materials()), visibility)
                .collect(),
        };
        (surface, spectra)
    }
}

/// Lamps outside: the places near them may clip, so that the light through the snow is bright enough.
const OUTSIDE: AutoExposure = AutoExposure { fraction: 0.9, level: 2.8 };
/// Lamps inside: all light has come through the snow.
const INSIDE: AutoExposure = AutoExposure { fraction: 0.98, level: 0.95 };
/// Under a sky: half of the snow is darker than half of white, so that lit snow keeps its shades.
const SKY: AutoExposure = AutoExposure { fraction: 0.5, level: 0.5 };
/// Greatest ratio of the entering to the leaving net flux at which lamps count as inside.
const ENTERING: f64 = 0.1;
/// Cosine of the exit angle.
const COS_EXIT: f64 = 0.8;

/// Snow under a light, and the factor of the light's strength.
#[derive(Debug, Clone, Copy)]
pub struct WeightedLight<'s> {
    /// The snow under the light.
    pub snow: &'s LitSnow,
    /// The factor.
    pub factor: f64,
}

/// Net flux and irradiance at a vertex by all lights.
#[derive(Clone, Copy)]
struct VertexLight {
    flux: LinearRgb,
    irradiance: LinearRgb,
}

impl Relighting {
    /// The exposure factor of the display for the sum of some lights; none without light.
    #[must_use]
    pub fn exposure_factor(&self, lights: &[WeightedLight]) -> Option<f64> {
        let has_sky = lights.iter().any(|light| light.snow.is_of_sky());
        let (mut seen, mut entering, mut leaving) = (Vec::new(), 0.0, 0.0);
        for (number, surface) in self.surfaces.iter().enumerate() {
            let escape = surface.baked.snow.escape.at(COS_EXIT);
            for (vertex, area) in areas(&surface.baked).into_iter().enumerate() {
                let VertexLight { flux, irradiance: mut exitance } = self.vertex_light(lights, number, vertex);
                let net = flux.luminance();
                if has_sky || net > 0.0 {
                    exitance += flux * escape;
                    seen.push((exitance * FRAC_1_PI, area));
                }
                entering += area * f64::max(-net, 0.0);
                leaving += area * f64::max(net, 0.0);
            }
        }
        let is_lit = seen.iter().any(|(light, _)| light.luminance() > 0.0);
        let rule = if has_sky {
            SKY
        } else if entering < ENTERING * leaving {
            INSIDE
        } else {
            OUTSIDE
        };
        is_lit.then(|| rule.factor_of_areas(seen).unwrap_or(1.0))
    }

    fn vertex_light(&self, lights: &[WeightedLight], surface: usize, vertex: usize) -> VertexLight {
        let mut sum = VertexLight { flux: LinearRgb::default(), irradiance: LinearRgb::default() };
        for WeightedLight { snow, factor } in lights {
            let LitSurface { flux, diffuse_irradiance, sky_irradiance, visibility } = &snow.surfaces[surface];
            sum.flux += flux[vertex] * *factor;
            sum.irradiance += diffuse_irradiance[vertex] * *factor;
            if let Some(irradiance) = sky_irradiance.get(vertex) {
                sum.irradiance += *irradiance * *factor;
            } else if snow.is_of_sky() {
                let direct = self.direct_irradiance(snow, &self.surfaces[surface], vertex);
                sum.irradiance += direct * (factor * f64::from(visibility[vertex]));
            }
        }
        sum
    }

    /// The irradiance by the sun at a vertex, without its visibility.
    fn direct_irradiance(&self, snow: &LitSnow, surface: &Surface, vertex: usize) -> LinearRgb {
        let (point, normal) = (surface.baked.positions[vertex].into(), surface.baked.normals[vertex].into());
        let sample = snow.light.central_sample();
        let incident = sample.as_ref().and_then(|sample| sample.incident_at(&SurfacePoint { point, normal }));
        let cos = incident.map_or(0.0, |incident| incident.cos_incidence);
        snow.strength * f64::from(cos)
    }
}

/// A third of the area of the triangles at each vertex, in m².
fn areas(object: &BakedObject) -> Vec<f64> {
    let mut areas = vec![0.0; object.positions.len()];
    for vertices in &object.triangles {
        let [a, b, c] = vertices.map(|vertex| object.positions[vertex as usize].as_dvec3());
        for vertex in vertices {
            areas[*vertex as usize] += (b - a).cross(c - a).length() / 6.0;
        }
    }
    areas
}

impl LitSnow {
    /// Whether the light is a sky or its sun.
    fn is_of_sky(&self) -> bool {
        self.light.central_sample().is_none_or(|sample| sample.origin.position().is_none())
    }
}
