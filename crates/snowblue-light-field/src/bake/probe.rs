//! The spectrum of the light that leaves lit snow at one place of its meshes: the exit law of [`LitSurface`] for all
//! wavelengths, between vertices as a shader interpolates.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec3, Vec3A};
use snowblue_base::narrow;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::ray::{MeshLocation, Ray, SurfacePoint};
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_scene::light::{LightDirection, LightOrigin};
use snowblue_scene::material::surface_optics::reflection_per_sr;
use snowblue_scene::objects::Side;
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::spectrum::{SAMPLES, Spectrum};

use super::relighting::{LitSnow, Relighting, VertexSpectra, WeightedLight};
use super::sky_directions::SkyDirections;
use super::{BakedObject, Surface};

/// A place on the mesh of an object of snow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SnowPlace {
    /// Number of the object in [`Relighting::objects`].
    pub object: usize,
    /// Location on the triangles of the object.
    pub location: MeshLocation,
}

/// A place and the position of the eye.
struct ProbedPlace<'s> {
    surface: &'s Surface,
    place: SnowPlace,
    point: Vec3A,
    normal: Vec3A,
    eye: Vec3A,
}

impl Relighting {
    /// The place of the snow that a ray meets first.
    pub fn place_along(&self, ray: &Ray) -> Option<SnowPlace> {
        let meshes = self.meshes.get_or_init(|| self.objects().map(mesh).collect());
        let mut nearest_m = f32::INFINITY;
        let mut found = None;
        for (object, mesh) in meshes.iter().enumerate() {
            if let Some(hit) = mesh.first_hit(ray, nearest_m) {
                nearest_m = hit.distance_m;
                found = Some(SnowPlace { object, location: hit.location });
            }
        }
        found
    }

    /// The radiance of a place of the snow towards an eye under some lights, as a band density in W/(m² sr).
    ///
    /// The reflection of a sky is computed at each vertex: the irradiance that the vertex receives, as in
    /// [`LitSurface::sky_irradiance`](super::LitSurface), times a ratio of sums over some unit directions.
    ///
    /// # Panics
    ///
    /// When the place is not on this snow, or a light was solved for on other snow.
    #[must_use]
    pub fn radiance_towards(
        &self,
        eye: Vec3A,
        place: SnowPlace,
        lights: &[WeightedLight],
        directions: &[Vec3A],
    ) -> Spectrum {
        let surface = &self.surfaces[place.object];
        let [point, normal] = [&surface.baked.positions, &surface.baked.normals]
            .map(|values| surface.corners(place).map(|(vertex, weight)| values[vertex] * weight).sum::<Vec3>().into());
        let sight = ProbedPlace { surface, place, point, normal: Vec3A::normalize(normal), eye };
        let mut sum = Spectrum::ZERO;
        for WeightedLight { snow, factor } in lights {
            let mut radiance = sight.scattered(snow);
            radiance += match snow.light.central_sample() {
                Some(sample) => sight.reflected(snow, &sample.origin),
                None => self.reflected_sky(&sight, snow, directions),
            };
            sum += radiance * narrow(*factor);
        }
        sum
    }

    /// ρ V F/π of a sky.
    fn reflected_sky(&self, sight: &ProbedPlace, sky: &LitSnow, directions: &[Vec3A]) -> Spectrum {
        let received = sky.directions.get_or_init(|| SkyDirections::new(&sky.light, |power| power.0));
        let power = |from: &Vec3A| sky.light.power(&LightOrigin::Distant(*from));
        let from: Vec<Spectrum> = directions.iter().map(power).collect();
        let mut queries = SceneQueries::new(self.scene.objects(), self.scene.materials());
        let Surface { object, points, baked, .. } = sight.surface;
        let mut sum = Spectrum::ZERO;
        for (vertex, weight) in sight.surface.corners(sight.place) {
            let normal: Vec3A = baked.normals[vertex].into();
            let to_eye = (sight.eye - Vec3A::from(baked.positions[vertex])).normalize();
            let at = SurfacePoint { point: points[vertex].into(), normal };
            let irradiance = Spectrum(received.irradiance(&mut queries, &at, Side::Outer(*object)));
            let [mut sent, mut open] = [Spectrum::ZERO; 2];
            for (direction, radiance) in directions.iter().zip(&from) {
                let cos = normal.dot(*direction);
                if cos > 0.0 {
                    open += *radiance * cos;
                    sent += *radiance * (cos * reflection_per_sr(&baked.half_space, normal, -to_eye, *direction));
                }
            }
            let share = |at: usize| if open.0[at] > 0.0 { sent.0[at] / open.0[at] } else { 0.0 };
            sum.add_product(weight, &irradiance, &Spectrum(std::array::from_fn::<f32, SAMPLES, _>(share)));
        }
        sum
    }
}

impl Surface {
    /// The vertices around a place and their weights.
    fn corners(&self, SnowPlace { location, .. }: SnowPlace) -> impl Iterator<Item = (usize, f32)> {
        let vertices = self.baked.triangles[location.triangle as usize];
        vertices.into_iter().map(|vertex| vertex as usize).zip(location.weights)
    }
}

impl ProbedPlace<'_> {
    fn to_eye(&self) -> Vec3A {
        (self.eye - self.point).normalize()
    }

    /// (H + K J)/π.
    fn scattered(&self, snow: &LitSnow) -> Spectrum {
        let cos = self.normal.dot(self.to_eye()).clamp(0.0, 1.0);
        let escape = narrow(self.surface.baked.snow.escape.at(cos.into()));
        let spectra = &snow.spectra[self.place.object];
        let mut sum = Spectrum::ZERO;
        for (vertex, weight) in self.surface.corners(self.place) {
            let VertexSpectra { flux, irradiance } = spectra[vertex];
            sum += irradiance * (weight * FRAC_1_PI);
            sum += flux * (weight * FRAC_1_PI * escape);
        }
        sum
    }

    /// R₀ V F of a lamp or the sun.
    fn reflected(&self, snow: &LitSnow, origin: &LightOrigin) -> Spectrum {
        let LightDirection { direction, distance_m } = origin.direction_from(self.point);
        let cos = self.normal.dot(direction);
        if cos <= 0.0 {
            return Spectrum::ZERO;
        }
        let visibility = &snow.surfaces[self.place.object].visibility;
        let visible: f32 = self.surface.corners(self.place).map(|(vertex, weight)| visibility[vertex] * weight).sum();
        let falloff = if distance_m.is_finite() { distance_m.powi(-2) } else { 1.0 };
        let half_space = &self.surface.baked.half_space;
        let reflection = reflection_per_sr(half_space, self.normal, -self.to_eye(), direction);
        snow.light.strength() * (reflection * visible * cos * falloff)
    }
}

/// The triangles of an object.
fn mesh(object: &BakedObject) -> MeshBvh {
    let (positions, indices) = (object.positions.clone(), object.triangles.clone());
    MeshBvh::new(TriangleMesh { positions, indices, ..TriangleMesh::default() })
}
