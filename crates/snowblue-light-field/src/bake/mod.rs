//! The light field of a scene on its snow, for other renderers: the net flux J outwards at the vertices of triangle
//! meshes, as glTF or PLY.
//!
//! Snow sends out L(μ) = Σ R₀ F + K(μ) J/π (see [the light field](crate)). J contains all effects of light inside the
//! snow, and it is linear in the light: each lamp has a separate attribute, which may be scaled. One further attribute
//! holds the rest: the light of the sky, and all light via other surfaces. It is the total minus the lamps. Another
//! renderer then needs J, the polynomial of K, and the irradiance F of all light on the surface.
//!
//! J is negative where more light enters than leaves: on lit faces.
//!
//! **Simplifications.** R₀ is not exported: it is nearly 1/π. For layered snow the exported K is the K of the top
//! layer, and for snow with a mask it is the K of the snow where the mask is 0. Faces of snow within other snow of the
//! same body have no meaning; J there is 0, or the J of the surface nearby.

mod escape_polynomial;
mod files;
mod flux_limit;
mod lamps;
mod lightmap;
mod probe;
mod relighting;
mod sky_directions;
mod subdivision;
mod surface_mesh;

#[cfg(test)]
mod tests;

use arrayvec::ArrayVec;
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use snowblue_base::{ParameterRange, narrow};
use snowblue_color::LinearRgb;
use snowblue_transport::ordinates::HalfSpace;

use crate::{BodySolution, LightField};
use snowblue_scene::Scene;
use snowblue_scene::film::Exposure;
use snowblue_scene::film::sensor::Sensor;
use snowblue_scene::progress::{Phase, Progress, Report};
use snowblue_scene::spectrum::{SAMPLES, Spectrum, WAVELENGTH_STEP_NM};

use flux_limit::{BoundedFlux, limit, vertex_areas_m2, within};
use lamps::lamps;
use lightmap::{FlatSurface, lay_out};
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::ray::SurfacePoint;
use subdivision::{Longest, subdivide};
use surface_mesh::{SurfaceMesh, Vertices};

pub use escape_polynomial::EscapePolynomial;
pub use files::{glb_bytes, write_glb, write_ply};
pub use lamps::BakedLamp;
pub use lightmap::{LIGHTMAP_SIZES, Lightmap};
pub use probe::SnowPlace;
pub use relighting::{LitSnow, LitSurface, Relighting, WeightedLight};

/// Greatest length of an edge of a baked mesh.
pub const STEP_RANGE: ParameterRange = ParameterRange { quantity: "step", least: 0.01, greatest: 1e5, unit: "mm" };
/// Greatest number of vertices of all snow together.
pub const MAX_VERTICES: usize = 1 << 22;
/// Greatest number of values of all attributes together, 1 GiB.
const MAX_NUMBERS: usize = 1 << 28;
/// Width of the whole grid of wavelengths, to which band densities refer, in nm.
const BAND_WIDTH_NM: f64 = SAMPLES as f64 * WAVELENGTH_STEP_NM;
/// Whether the program can make lightmaps. Otherwise the compiler removes their code.
const HAS_LIGHTMAPS: bool = cfg!(feature = "lightmaps");
/// Default length of edges, in cells of the light field at the surface.
const DEFAULT_CELLS: f64 = 2.0;
/// Length of edges that run away from a sharp edge, in cells of the light field at the surface.
const CELLS_FROM_EDGES: f64 = 0.25;

/// Greatest distance of vertices from which flux is taken for other vertices, in cells.
const MAX_CELLS_OF_REACH: f64 = 4.0;
/// Relative error of the irradiance at wavelengths between the wavelengths that are solved for.
const IRRADIANCE_ERROR: f64 = 0.005;

/// Ratio of direct to diffuse irradiance up to which the direct irradiance is only the error of a difference.
const MIN_DIRECT: f64 = 0.02;

/// The content of the attributes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Channels {
    /// Linear sRGB, in W/m² as the film of a rendering weights them.
    #[default]
    Rgb,
    /// The 31 wavelengths of the scene, in W/(m² nm).
    Spectrum,
}

/// Options for baking a light field.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BakeOptions {
    /// Greatest length of an edge, in m; none for twice the cells of the light field at the surface of each body.
    pub step_m: Option<f64>,
    /// The content of the attributes.
    pub channels: Channels,
    /// Whether there is one attribute for all light, instead of an attribute for each lamp and an attribute for the
    /// rest.
    pub is_total: bool,
    /// Columns and rows of a lightmap, within [`LIGHTMAP_SIZES`]; none for no lightmap. It is an error if the charts of
    /// the surface do not fit into it at one texel each, or if places from mesh files overlap.
    pub lightmap: Option<u32>,
    /// Whether the irradiance at the vertices is computed.
    pub has_irradiance: bool,
}

/// Why a light field cannot be baked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BakeError {
    /// No object is snow.
    #[error("the scene has no snow")]
    NoSnow,
    /// The integrator does not solve for the light field.
    #[error("the scene has no light field: its integrator must be diffusion or hybrid")]
    NoField,
    /// The triangles are too small.
    #[error("the snow has more than {most} vertices with edges of at most {step_mm} mm, so the step must be greater")]
    TooManyVertices {
        /// The bound of the vertices.
        most: usize,
        /// The greatest length of an edge, in mm.
        step_mm: f64,
    },
    /// The feature `lightmaps` of this crate is off.
    #[error("this program makes no lightmaps")]
    NoLightmaps,
    /// No lightmap has this size.
    #[error(
        "lightmap is {size}, but must be a whole number in {}–{}", LIGHTMAP_SIZES.start(), LIGHTMAP_SIZES.end()
    )]
    LightmapSize {
        /// Columns and rows.
        size: u32,
    },
    /// The surface cannot be laid out in the lightmap.
    #[error("{reason}")]
    Layout {
        /// The reason.
        reason: String,
    },
}

/// The light field on the snow of a scene.
#[derive(Debug)]
pub struct BakedScene {
    /// The lamps, in the order of their attributes.
    pub lamps: Vec<BakedLamp>,
    /// The content of the attributes.
    pub channels: Channels,
    /// All objects of snow.
    pub objects: Vec<BakedObject>,
    /// The origin of their positions in the coordinates of the scene file, in m.
    pub origin: DVec3,
    /// The light as a texture, if a lightmap was requested.
    pub lightmap: Option<Lightmap>,
    /// The irradiance at the vertices of each object, if it was requested.
    pub irradiance: Vec<Vec<VertexIrradiance>>,
    /// Brightness of the preview.
    pub exposure: Exposure,
}

/// The light field on an object of snow.
#[derive(Debug)]
pub struct BakedObject {
    /// Name of the object in the scene.
    pub name: String,
    /// Vertices in scene space, in m.
    pub positions: Vec<Vec3>,
    /// Outward unit normals of the vertices.
    pub normals: Vec<Vec3>,
    /// The vertices of each triangle, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Coordinates of the vertices in the lightmap, 0–1, v = 0 at its first row; none without a lightmap.
    pub texture_coordinates: Vec<[f32; 2]>,
    /// The net flux J outwards by each lamp, and last by the sky and other surfaces: all channels of the first vertex,
    /// then of the second.
    pub flux: Vec<Vec<f32>>,
    /// The total exitance, J plus the irradiance, as linear sRGB in W/m².
    pub exitance: Vec<LinearRgb>,
    /// Functions and lengths of the surface of the snow.
    pub snow: SnowSurface,
    /// Reflection and escape functions of the snow.
    pub half_space: HalfSpace,
}

/// The irradiance at a vertex as linear sRGB, in W/m² as the film of a rendering weights it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VertexIrradiance {
    /// By lamps and skies that see the vertex, without uniform skies.
    pub direct: LinearRgb,
    /// By uniform skies and via other surfaces.
    pub diffuse: LinearRgb,
}

/// The functions and lengths of the surface of snow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SnowSurface {
    /// The escape function K.
    pub escape: EscapePolynomial,
    /// Extrapolation length q, in transport mean free paths.
    pub extrapolation: f64,
    /// Transport mean free path at the middle wavelength, in m.
    pub transport_length_m: f64,
    /// Greatest length of an edge, in m.
    pub step_m: f64,
}

impl Channels {
    /// Number of values of an attribute at a vertex.
    #[must_use]
    pub fn count(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Spectrum => SAMPLES,
        }
    }

    /// The values of a flux, in W/m² as a band density.
    fn values(self, flux: &Spectrum, sensor: &Sensor) -> ArrayVec<f32, SAMPLES> {
        match self {
            Self::Rgb => {
                let LinearRgb { r, g, b } = rgb(flux, sensor);
                [r, g, b].map(narrow).into_iter().collect()
            }
            Self::Spectrum => (*flux * narrow(1.0 / BAND_WIDTH_NM)).0.into(),
        }
    }
}

fn rgb(flux: &Spectrum, sensor: &Sensor) -> LinearRgb {
    LinearRgb::from_xyz(sensor.xyz(flux))
}

/// Bakes the light field of a scene. It reports which lamps, charts and texels are done.
///
/// # Errors
///
/// When there is no snow, there would be too many vertices, the size of the lightmap is not within [`LIGHTMAP_SIZES`],
/// or the surface cannot be laid out in it.
pub fn bake(scene: &Scene, field: &LightField, options: BakeOptions, report: Report) -> Result<BakedScene, BakeError> {
    if options.lightmap.is_some() && !HAS_LIGHTMAPS {
        return Err(BakeError::NoLightmaps);
    }
    if let Some(size) = options.lightmap.filter(|size| !LIGHTMAP_SIZES.contains(size)) {
        return Err(BakeError::LightmapSize { size });
    }
    let lamps = if options.is_total { Vec::new() } else { lamps(scene) };
    let numbers = options.channels.count() * (lamps.len() + 1);
    let step_m = |body: &BodySolution| options.step_m.unwrap_or_else(|| DEFAULT_CELLS * body.surface_step_m());
    let most_vertices = MAX_VERTICES.min(MAX_NUMBERS / numbers);
    let lightmap = options.lightmap.filter(|_| HAS_LIGHTMAPS);
    let mut surfaces = surfaces(scene, field, step_m, most_vertices, lightmap.map(|size| (size, report)))?;
    // Errors of a lightmap are found before the lamps are computed, which takes long.
    let shown = lightmap.map(|size| {
        let flat: Vec<FlatSurface> = surfaces.iter().map(Surface::flat).collect();
        let shown = lightmap::shown(&flat, size).map_err(|reason| BakeError::Layout { reason })?;
        Ok((shown, size))
    });
    let shown = shown.transpose()?;
    let mut sky: Vec<Vec<f32>> =
        surfaces.iter().map(|surface| surface.flux(field, options.channels, scene.sensor())).collect();
    let irradiance = match options.has_irradiance {
        true => surfaces.iter().map(|surface| surface.irradiance(field, scene.sensor())).collect(),
        false => Vec::new(),
    };
    for (surface, flux) in surfaces.iter_mut().zip(&mut sky) {
        surface.baked.exitance = surface.exitance(field, scene.sensor());
        if options.is_total {
            surface.limit(flux, field, options.channels, scene.sensor());
        }
    }
    let of_lamp = |done: usize| Progress { phase: Phase::Lamps, done: done as u64, total: lamps.len() as u64 };
    for (number, lamp) in lamps.iter().enumerate() {
        // Without other surfaces. Reports of the solution for a lamp only show that the program is running.
        let alone = field.of_light(scene, &scene.lights()[lamp.light], 0, &|_| report(of_lamp(number)));
        for (surface, sky) in surfaces.iter_mut().zip(&mut sky) {
            let mut flux = surface.flux(&alone, options.channels, scene.sensor());
            sky.iter_mut().zip(&flux).for_each(|(rest, value)| *rest -= value);
            surface.limit(&mut flux, &alone, options.channels, scene.sensor());
            surface.baked.flux.push(flux);
        }
        report(of_lamp(number + 1));
    }
    let lightmap = shown.map(|(shown, size)| {
        let flat: Vec<FlatSurface> = surfaces.iter().map(Surface::flat).collect();
        lightmap::read(&flat, (&shown, size), field, scene.sensor(), |done, total| {
            report(Progress { phase: Phase::Texels, done: done as u64, total: total as u64 });
        })
    });
    let finished = surfaces.into_iter().zip(sky).map(|(mut surface, sky)| {
        surface.baked.flux.push(sky);
        surface.baked
    });
    Ok(BakedScene {
        lamps,
        channels: options.channels,
        objects: finished.collect(),
        origin: scene.local_origin(),
        lightmap,
        irradiance,
        exposure: scene.film().exposure,
    })
}

/// An object of snow to be baked.
#[derive(Debug)]
struct Surface {
    /// Index of the object in the scene.
    object: usize,
    /// Points where the light is read.
    points: Vec<Vec3>,
    /// The ellipsoid whose surface it is.
    ellipsoid: Option<Ellipsoid>,
    baked: BakedObject,
}

/// A body of snow, and the greatest length of an edge of its surface.
struct SteppedBody<'f> {
    /// Index of the object in the scene.
    object: usize,
    body: &'f BodySolution,
    step_m: f64,
}

/// The surfaces of all snow, with edges of at most a length in m that depends on the body. For a lightmap the surfaces
/// are laid out, and the progress is reported.
fn surfaces(
    scene: &Scene,
    field: &LightField,
    step_m: impl Fn(&BodySolution) -> f64,
    most_vertices: usize,
    lightmap: Option<(u32, Report)>,
) -> Result<Vec<Surface>, BakeError> {
    let objects = scene.objects().list();
    let too_many = |step_m: f64| BakeError::TooManyVertices { most: most_vertices, step_mm: 1e3 * step_m };
    let (mut bodies, mut meshes, mut count) = (Vec::new(), Vec::new(), 0);
    for (object, listed) in objects.iter().enumerate() {
        let (Some(body), Some(mut mesh)) = (field.of_object(object), SurfaceMesh::of(&listed.shape)) else { continue };
        if lightmap.is_none() {
            mesh.forget_uv();
        }
        let step_m = step_m(body);
        let edge_m = narrow(step_m).min(mesh.longest_edge_m());
        // As short as the cells resolve, but longer where a large step asks for it.
        let away_m = edge_m.min(narrow(CELLS_FROM_EDGES * body.surface_step_m().max(step_m / DEFAULT_CELLS)));
        if !subdivide(&mut mesh, Longest { edge_m, away_m }, most_vertices.saturating_sub(count)) {
            return Err(too_many(step_m));
        }
        count += mesh.positions.len();
        if !mesh.facets.is_empty() {
            bodies.push(SteppedBody { object, body, step_m });
            meshes.push(mesh);
        }
    }
    if let Some((size, report)) = lightmap.filter(|_| HAS_LIGHTMAPS) {
        let names: Vec<&str> = bodies.iter().map(|stepped| &*objects[stepped.object].name).collect();
        lay_out(&names, &mut meshes, size, report).map_err(|reason| BakeError::Layout { reason })?;
    }
    let mut surfaces = Vec::new();
    count = 0;
    for (SteppedBody { object, body, step_m }, mesh) in bodies.into_iter().zip(meshes) {
        let Vertices { positions, normals, points, uv, triangles } = Vertices::of(&mesh);
        count += positions.len();
        if count > most_vertices {
            return Err(too_many(step_m));
        }
        let top = body.snow().top();
        let half_space = top.surface().half_space();
        let snow = SnowSurface {
            escape: EscapePolynomial::of(half_space),
            extrapolation: half_space.extrapolation(),
            transport_length_m: top.transport_length_m().into(),
            step_m,
        };
        let baked = BakedObject {
            name: objects[object].name.clone(),
            positions,
            normals,
            triangles,
            texture_coordinates: uv.iter().filter(|_| lightmap.is_some()).map(Vec2::to_array).collect(),
            flux: Vec::new(),
            exitance: Vec::new(),
            snow,
            half_space: half_space.clone(),
        };
        surfaces.push(Surface { object, points, ellipsoid: mesh.ellipsoid, baked });
    }
    if surfaces.is_empty() { Err(BakeError::NoSnow) } else { Ok(surfaces) }
}

impl Surface {
    fn flat(&self) -> FlatSurface<'_> {
        let Self { object, ellipsoid, ref baked, .. } = *self;
        let BakedObject { name, positions, normals, triangles, texture_coordinates: uv, .. } = baked;
        FlatSurface { object, name, ellipsoid, positions, normals, uv, triangles }
    }

    /// The net flux at all vertices.
    fn flux(&self, field: &LightField, channels: Channels, sensor: &Sensor) -> Vec<f32> {
        let Some(body) = field.of_object(self.object) else { return Vec::new() };
        let values = |place| channels.values(&body.flux(&place), sensor);
        self.places().flat_map_iter(values).collect()
    }

    /// Raises the net flux at vertices so that no radiance is negative. The exitance changes by the same amount.
    fn limit(&mut self, values: &mut [f32], field: &LightField, channels: Channels, sensor: &Sensor) {
        let count = channels.count();
        let Some(body) = field.of_object(self.object) else { return };
        let flux_at = |vertex: usize| body.flux(&self.place(vertex));
        for (vertex, [before, flux]) in self.limited(body, &flux_at) {
            let mut change = flux;
            change += before * -1.0;
            self.baked.exitance[vertex] += rgb(&change, sensor);
            values[count * vertex..count * (vertex + 1)].copy_from_slice(&channels.values(&flux, sensor));
        }
    }

    /// The vertices whose net flux changes so that no radiance is negative, with the flux in the light field and the
    /// changed flux. The added flux is subtracted from the vertices within an edge of the mesh. `flux_at` gives the
    /// flux in the light field at a vertex.
    fn limited(
        &self,
        body: &BodySolution,
        flux_at: &(dyn Fn(usize) -> Spectrum + Sync),
    ) -> Vec<(usize, [Spectrum; 2])> {
        // Renderers use the polynomial, so that the greater of both escape functions counts.
        let escape = self.baked.half_space.escape(1.0).max(self.baked.snow.escape.at(1.0));
        let least = |vertex: usize, flux: &Spectrum| {
            let mut irradiance = body.exitance(&self.place(vertex));
            irradiance += *flux * -1.0;
            irradiance * -narrow((1.0 - IRRADIANCE_ERROR) / escape)
        };
        let is_below = |vertex: &usize| {
            let flux = flux_at(*vertex);
            // Only where light enters can the net flux exceed the incident light.
            flux.0.iter().any(|flux| *flux < 0.0)
                && flux.0.iter().zip(least(*vertex, &flux).0).any(|(flux, least)| *flux < least)
        };
        let lacking: Vec<usize> = (0..self.baked.positions.len()).into_par_iter().filter(is_below).collect();
        if lacking.is_empty() {
            return Vec::new();
        }
        let cell_m = body.surface_step_m();
        let reach_m = narrow(self.baked.snow.step_m.clamp(cell_m, MAX_CELLS_OF_REACH * cell_m));
        let changed = within(reach_m, &lacking, &self.baked.positions);
        let areas_m2 = vertex_areas_m2(&self.baked.positions, &self.baked.triangles);
        let bounded = |vertex: &usize| {
            let flux = flux_at(*vertex);
            let (position, area_m2) = (self.baked.positions[*vertex], areas_m2[*vertex]);
            BoundedFlux { position, area_m2, least: least(*vertex, &flux), flux }
        };
        let mut limited: Vec<BoundedFlux> = changed.par_iter().map(bounded).collect();
        let before: Vec<Spectrum> = limited.iter().map(|vertex| vertex.flux).collect();
        limit(&mut limited, reach_m);
        let fluxes = before.into_iter().zip(limited).map(|(before, BoundedFlux { flux, .. })| [before, flux]);
        changed.into_iter().zip(fluxes).collect()
    }

    /// The exitance at all vertices.
    fn exitance(&self, field: &LightField, sensor: &Sensor) -> Vec<LinearRgb> {
        let Some(body) = field.of_object(self.object) else { return Vec::new() };
        self.places().map(|place| rgb(&body.exitance(&place), sensor)).collect()
    }

    /// The irradiance at all vertices: the exitance minus the net flux.
    fn irradiance(&self, field: &LightField, sensor: &Sensor) -> Vec<VertexIrradiance> {
        let Some(body) = field.of_object(self.object) else { return Vec::new() };
        let at_vertex = |place| {
            let diffuse = body.diffuse_irradiance(&place);
            let mut direct = body.exitance(&place);
            direct += body.flux(&place) * -1.0;
            direct += diffuse * -1.0;
            let [direct, diffuse] = [direct, diffuse].map(|light| rgb(&light, sensor));
            let is_seen = direct.luminance() > MIN_DIRECT * diffuse.luminance();
            VertexIrradiance { direct: if is_seen { direct } else { LinearRgb::default() }, diffuse }
        };
        self.places().map(at_vertex).collect()
    }

    /// The places where the light of all vertices is read.
    fn places(&self) -> impl IndexedParallelIterator<Item = SurfacePoint> {
        (0..self.points.len()).into_par_iter().map(|vertex| self.place(vertex))
    }

    /// The place where the light of a vertex is read.
    fn place(&self, vertex: usize) -> SurfacePoint {
        SurfacePoint { point: self.points[vertex].into(), normal: self.baked.normals[vertex].into() }
    }
}
