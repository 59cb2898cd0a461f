//! Integrators, ready for a scene.

use snowblue_base::Count;
use snowblue_database::CompressedTable;
use snowblue_geometry::ray::Ray;
use snowblue_light_field::bake::{BakeError, BakeOptions, BakedScene, Relighting, bake};
use snowblue_light_field::{FieldStatistics, LightField};
use snowblue_scene::air::Air;
use snowblue_scene::camera::View;
use snowblue_scene::film::sensor::SensorSample;
use snowblue_scene::progress::{Phase, Progress, Report};
use snowblue_scene::provenance::Provenance;
use snowblue_scene::queries::Statistics;
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::{Changes, Scene, Views};

use crate::error::RenderError;
use crate::integrators::PathSample;
use crate::integrators::first_hit::FirstHits;
use crate::integrators::method::{Method, Prepared, Tracing};
use crate::integrators::path::PathTracer;
use crate::integrators::reference::ReferenceTracer;

/// Memory of the coarse cells of snow for a first picture, in MiB: the first value, then the second if the cells do
/// not fit.
const COARSE_MEMORY_MIB: [u32; 2] = [8, 32];

/// An integrator that is ready for a scene. It shares the scene's parts.
#[derive(Debug)]
pub struct Integrator {
    prepared: Prepared,
    notes: Vec<String>,
}

/// Counts of a scene, and of the method that is ready for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SceneStatistics {
    /// Objects of the scene.
    pub objects: usize,
    /// Objects that are meshes.
    pub meshes: usize,
    /// Triangles of all meshes.
    pub triangles: usize,
    /// The light field, if the method has one.
    pub light_field: Option<FieldStatistics>,
}

/// Inputs for the preparation of an integrator.
pub struct Preparation<'a> {
    /// The table of curves for PCASnow; none for the table of the scene, or else the embedded table.
    pub table: Option<&'a CompressedTable>,
    /// The integrator of an earlier scene. Its light fields are kept if nothing that they depend on differs. The
    /// files of both scenes must be equal.
    pub earlier: Option<Integrator>,
    /// The views of the pictures that are needed; none for a bake, which needs no camera. For pictures from the camera
    /// of the scene alone, snow that it does not see has larger cells, unless the scene asks for all views.
    pub views: Option<Views>,
    /// Receives the progress.
    pub report: Report<'a>,
}

/// The table of the scene or the embedded table, no earlier integrator, pictures from all views, and no report.
impl Default for Preparation<'_> {
    fn default() -> Self {
        Self { table: None, earlier: None, views: Some(Views::All), report: &|_| {} }
    }
}

impl Integrator {
    /// Prepares the integrator of a scene, with the table of the scene or else the embedded table.
    ///
    /// # Errors
    ///
    /// As [`prepare_with`](Self::prepare_with).
    pub fn prepare(scene: &Scene) -> Result<Self, RenderError> {
        Self::prepare_with(scene, Preparation::default())
    }

    /// Prepares the integrator of a scene.
    ///
    /// # Errors
    ///
    /// If the scene has no camera for pictures, a body of snow has no light field because it is infinite or too thin
    /// for its memory, a lamp other than a point or a sphere lies inside snow, or the scene's table cannot be read.
    pub fn prepare_with(scene: &Scene, preparation: Preparation) -> Result<Self, RenderError> {
        let mut notes = scene.notes().to_vec();
        let Preparation { table, earlier, views, report } = preparation;
        if views.is_some() {
            scene.camera()?;
        }
        let is_camera = |views: Views| views == Views::Camera;
        let has_one_view = views.is_some_and(is_camera) && is_camera(scene.description().light_field.views);
        let method = match earlier.and_then(|earlier| earlier.kept(scene, has_one_view)) {
            Some((method, changes)) => method.relit(scene, &changes, report)?,
            None => Method::prepare(scene, table, has_one_view, report, &mut notes)?,
        };
        let prepared = Prepared::new(scene, method)?;
        notes.extend(prepared.sparkle_notes());
        Ok(Self { prepared, notes })
    }

    /// Prepares an integrator for a first picture of a scene ([`Scene::coarse`]); none for PCASnow. It reports
    /// [`Phase::Preview`].
    ///
    /// # Errors
    ///
    /// As [`prepare_with`](Self::prepare_with).
    pub fn prepare_coarse(scene: &Scene, report: Report) -> Result<Option<Self>, RenderError> {
        let report = |_| report(Progress { phase: Phase::Preview, done: 0, total: 0 });
        let prepare = |memory_mib: u32| {
            let coarse = scene.coarse(memory_mib)?;
            let preparation = Preparation { views: Some(Views::Camera), report: &report, ..Preparation::default() };
            Some(Self::prepare_with(&coarse, preparation))
        };
        let [memory_mib, more_mib] = COARSE_MEMORY_MIB;
        match prepare(memory_mib) {
            Some(Err(_)) => prepare(more_mib),
            prepared => prepared,
        }
        .transpose()
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.prepared.scene
    }

    /// Deviations from the files, in sentences: about meshes, and about curves that a table lacks.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The number of light fields that were solved, one for all lights of one spectrum. Light fields that were kept
    /// from an earlier integrator do not count.
    pub fn solved_light_fields(&self) -> usize {
        self.prepared.method.field().map_or(0, LightField::solved_count)
    }

    /// The greatest factor that fits the cell sizes for the pixels of the image into the memory of the light field;
    /// none if no body of snow has such cell sizes. Light leaks through snow that is thinner than two cells.
    pub fn factor_of_cells(&self) -> Option<f64> {
        self.prepared.method.field().and_then(LightField::view_factor)
    }

    /// Whether the integrator is prepared for one camera: snow that this camera does not see has larger cells.
    pub fn has_one_view(&self) -> bool {
        self.prepared.method.field().is_some_and(LightField::has_one_view)
    }

    /// The inputs of the scene, its settings, and the table of curves if the method reads a table.
    pub fn provenance(&self) -> Provenance {
        Provenance::of(self.scene(), self.prepared.method.table_hash())
    }

    /// Counts of the scene and of the method.
    pub fn statistics(&self) -> SceneStatistics {
        let objects = self.scene().objects().list();
        let meshes = || objects.iter().filter_map(|object| object.shape.mesh());
        SceneStatistics {
            objects: objects.len(),
            meshes: meshes().count(),
            triangles: meshes().map(|mesh| mesh.triangles().indices.len()).sum(),
            light_field: self.light_field().map(LightField::statistics),
        }
    }

    /// The light field, if the method has one.
    pub fn light_field(&self) -> Option<&LightField> {
        self.prepared.method.field()
    }

    /// [Bakes](bake()) the light field.
    ///
    /// # Errors
    ///
    /// When the method has no light field, and as [`bake`](bake()).
    pub fn bake(&self, options: BakeOptions, report: Report) -> Result<BakedScene, BakeError> {
        bake(self.scene(), self.light_field().ok_or(BakeError::NoField)?, options, report)
    }

    /// The snow of the scene, to be [lit](Relighting) by one light at a time, with edges of at most `cells_per_edge`
    /// cells of the light field.
    ///
    /// # Errors
    ///
    /// As [`bake`](Self::bake).
    pub fn into_relighting(self, cells_per_edge: Option<f64>) -> Result<Relighting, BakeError> {
        let Prepared { scene, method, .. } = self.prepared;
        Relighting::new(scene, method.into_field().ok_or(BakeError::NoField)?, cells_per_edge)
    }

    /// Points the camera elsewhere; false, and no change, if the view looks along its own up direction or nowhere.
    ///
    /// The light field keeps the cells for the former view: in wide bodies, and in all bodies if it [has one
    /// view](Self::has_one_view).
    pub fn set_view(&mut self, view: &View) -> bool {
        self.prepared.scene.set_view(view)
    }

    /// Sets the number of samples per pixel to the nearest number in its range.
    pub fn set_samples_per_pixel(&mut self, samples: u32) {
        self.prepared.scene.set_samples_per_pixel(Count::nearest(samples));
    }

    /// Sets the seed of the random numbers.
    pub fn set_seed(&mut self, seed: u32) {
        self.prepared.scene.set_seed(seed);
    }

    /// Finds first hits, for one task.
    pub(crate) fn first_hits(&self) -> FirstHits<'_> {
        FirstHits::new(&self.prepared)
    }

    /// The method, if it is valid for another scene apart from the lights, and the changes between the scenes.
    fn kept(self, scene: &Scene, has_one_view: bool) -> Option<(Method, Changes)> {
        let Prepared { scene: before, method, .. } = self.prepared;
        let changes = Changes::new(before.description(), scene.description());
        method.holds_after(&changes, has_one_view).then_some((method, changes))
    }

    /// A tracer for one task, with zero counts. For pictures of spectra, `responses` is false.
    pub(crate) fn tracer(&self, responses: bool) -> Tracer<'_> {
        let Prepared { scene, bodies, parts_of_lights, .. } = &self.prepared;
        let paths = match self.prepared.tracing() {
            Tracing::OverSurfaces(snow) => {
                Paths::OverSurfaces(Box::new(PathTracer::new(&self.prepared, snow, responses)))
            }
            Tracing::InVolumes(volumes) => {
                Paths::Reference(Box::new(ReferenceTracer::new((scene, parts_of_lights), bodies, volumes)))
            }
        };
        Tracer { paths, air: scene.air() }
    }
}

/// Traces camera rays, with the state of one thread.
#[derive(Debug)]
pub(crate) struct Tracer<'a> {
    paths: Paths<'a>,
    /// The air between the camera and the first surface, if it counts.
    air: Option<&'a Air>,
}

/// The tracer of paths.
#[derive(Debug)]
enum Paths<'a> {
    OverSurfaces(Box<PathTracer<'a>>),
    Reference(Box<ReferenceTracer<'a>>),
}

impl Tracer<'_> {
    /// One sample of the radiance along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> PathSample<Spectrum> {
        let sample = match &mut self.paths {
            Paths::OverSurfaces(tracer) => tracer.radiance(camera_ray, sampler),
            Paths::Reference(tracer) => tracer.radiance(camera_ray, sampler),
        };
        match (self.air, sample.distance_m) {
            (Some(air), Some(distance_m)) => sample.through(&air.between(camera_ray, distance_m)),
            _ => sample,
        }
    }

    /// The sensor's response to one sample of the radiance along a camera ray.
    #[inline]
    pub(crate) fn response(
        &mut self,
        scene: &Scene,
        camera_ray: &Ray,
        sampler: &mut Sampler,
    ) -> PathSample<SensorSample> {
        match &mut self.paths {
            Paths::OverSurfaces(tracer) if self.air.is_none() => tracer.response(camera_ray, sampler),
            _ => self.radiance(camera_ray, sampler).map(|light| scene.sensor().sample(light)),
        }
    }

    /// Counts of the queries so far.
    pub(crate) fn statistics(&self) -> Statistics {
        match &self.paths {
            Paths::OverSurfaces(tracer) => tracer.statistics(),
            Paths::Reference(tracer) => tracer.statistics(),
        }
    }
}
