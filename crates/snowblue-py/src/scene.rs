//! Scenes, their pictures and baked light fields.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_color::LinearRgb;
use snowblue_database::CompressedTable;
use snowblue_render::bake::{
    BakeError, BakeOptions, BakedObject, BakedScene, Channels, STEP_RANGE, write_glb, write_ply,
};
use snowblue_render::files::{FileSource, FilesIn};
use snowblue_render::film::channels::channels;
use snowblue_render::film::image_file::{to_raster, write_png};
use snowblue_render::film::resumable_file;
use snowblue_render::render::{RenderControl, accumulator, all_samples, render_coarse, render_missing};
use snowblue_render::scene::Views;
use snowblue_render::scene::film::PictureSettings;
use snowblue_render::scene::provenance::Provenance;
use snowblue_render::scene::spectrum::wavelengths_nm;
use snowblue_render::{
    Aovs, FilmAccumulator, Integrator, Phase, Preparation, Progress, RenderError, SampleBlock, SceneDescription,
    SceneFile,
};

use crate::database::Table;
use crate::work::{Control, failure, input, run_showing};

/// A scene: its description, and the files that it names.
#[pyclass(frozen, module = "snowblue._native")]
pub(crate) struct Scene {
    description: SceneDescription,
    files: Arc<GivenFiles>,
    /// The last build of this scene or of a scene with equal files.
    last: Arc<Mutex<Option<Built>>>,
}

/// Functions of Python that follow the work.
struct Watchers<'py> {
    progress: Option<Bound<'py, PyAny>>,
    preview: Option<Bound<'py, PyAny>>,
}

/// How a scene is prepared.
#[derive(Default)]
struct Method {
    /// The curves for PCASnow; none for the curves of the scene, or else the embedded curves.
    table: Option<Arc<CompressedTable>>,
    /// The views of the pictures that are needed; none for a bake.
    views: Option<Views>,
}

/// Time between two unfinished pictures.
const PREVIEW_INTERVAL: Duration = Duration::from_secs(1);

/// Content of a bake.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Content {
    /// 31 wavelengths instead of colours.
    spectrum: bool,
    /// All light together instead of each lamp.
    is_total: bool,
    /// The table of the reflection function.
    reflection: bool,
    /// The irradiance at the vertices.
    irradiance: bool,
    /// Columns and rows of a lightmap.
    lightmap: Option<u32>,
}

/// Steps of each argument in the table of the reflection function.
const REFLECTION_STEPS: u32 = 32;

/// Files in memory, and files in a folder.
struct GivenFiles {
    in_memory: HashMap<String, Vec<u8>>,
    folder: FilesIn,
}

/// A scene that is ready to be rendered, and the metadata of its pictures.
struct Built {
    integrator: Integrator,
    provenance: Provenance,
}

impl FileSource for GivenFiles {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        self.in_memory.get(name).map_or_else(|| self.folder.read(name), |bytes| Ok(bytes.clone()))
    }

    fn display_name(&self, name: &str) -> PathBuf {
        if self.in_memory.contains_key(name) { name.into() } else { self.folder.display_name(name) }
    }
}

#[pymethods]
impl Scene {
    /// Reads a scene file.
    #[staticmethod]
    fn open(path: PathBuf) -> PyResult<Self> {
        let file = SceneFile::open(&path).map_err(input)?;
        let files = GivenFiles { in_memory: HashMap::new(), folder: FilesIn::beside(&path) };
        Ok(Self::new(file.description, files))
    }

    /// A scene from a JSON document with the keys of a scene file. Files are those in memory by their names, and else
    /// those in a folder.
    #[staticmethod]
    fn from_json(text: &str, in_memory: HashMap<String, Vec<u8>>, folder: PathBuf) -> PyResult<Self> {
        let files = GivenFiles { in_memory, folder: FilesIn::new(folder) };
        Ok(Self::new(described(text)?, files))
    }

    /// The scene with another description; its files are the same. Whichever of them is built next keeps what it has in
    /// common with the one that was built last.
    fn with_json(&self, text: &str) -> PyResult<Self> {
        let (files, last) = (Arc::clone(&self.files), Arc::clone(&self.last));
        Ok(Self { description: described(text)?, files, last })
    }

    /// Files in memory by their names, and the folder of the others.
    fn files(&self) -> (HashMap<String, Vec<u8>>, PathBuf) {
        (self.files.in_memory.clone(), self.files.folder.display_name(""))
    }

    /// The description as a JSON document.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.description).map_err(failure)
    }

    /// The description as the text of a scene file.
    fn to_toml(&self) -> String {
        self.description.to_toml()
    }

    /// Renders the scene: its channels, width and height, and its exposure in stops. Writes them to `output` too,
    /// a PNG or an OpenEXR file. Without a table, PCASnow reads that of the scene, or else the embedded one. Calls
    /// `preview` with unfinished pictures: first one with coarse cells of snow.
    #[expect(clippy::too_many_arguments, reason = "the keywords of Python")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        table: Option<&Table>,
        aovs: &str,
        output: Option<PathBuf>,
        progress: Option<Bound<'py, PyAny>>,
        preview: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let aovs: Aovs = aovs.parse().map_err(input)?;
        let is_png = output.as_deref().map(is_png).transpose()?;
        let development = self.description.film.development();
        let table = table.map(Table::compressed).transpose()?;
        let shows = preview.is_some();
        let (sums, made) = self.work(
            py,
            Method { table, views: Some(Views::Camera) },
            Watchers { progress, preview },
            move |built, control| {
                let Built { integrator, provenance } = built;
                let (scene, target) = (integrator.scene(), all_samples(integrator.scene()));
                let mut sums = accumulator(scene, aovs, &target.window());
                let unusable_samples = add_samples(integrator, &target, &mut sums, control, shows);
                if unusable_samples > 0 {
                    let reason = "samples have a radiance that is not finite, or above 2.8e8 W m⁻² sr⁻¹";
                    return Err(failure(format!("{unusable_samples} {reason}")));
                }
                let notes = integrator.notes().to_vec();
                let settings = scene.picture_settings();
                Ok((sums, (provenance.to_string(), integrator.solved_light_fields(), notes, settings)))
            },
        )?;
        let (provenance, solved_light_fields, notes, settings) = made;
        if let (Some(path), Some(is_png)) = (output, is_png) {
            save(&sums, settings, is_png, &path).map_err(failure)?;
        }
        let dict = PyDict::new(py);
        for channel in channels(&sums) {
            dict.set_item(channel.name, PyArray1::from_vec(py, channel.values))?;
        }
        let film = sums.film();
        dict.set_item("display", PyArray1::from_vec(py, to_raster(&film, development).bytes()))?;
        dict.set_item("attributes", sums.attributes().clone())?;
        dict.set_item("width", film.size().width)?;
        dict.set_item("height", film.size().height)?;
        dict.set_item("exposure_stops", film.display_factor(development).log2())?;
        dict.set_item("wavelengths", wavelengths_nm())?;
        dict.set_item("provenance", provenance)?;
        dict.set_item("solved_light_fields", solved_light_fields)?;
        dict.set_item("notes", notes)?;
        Ok(dict)
    }

    /// Bakes the light field on the snow: a dictionary for each object, after one for all. Writes a GLB or PLY file to
    /// `output` too.
    #[expect(clippy::too_many_arguments, reason = "the keywords of Python")]
    fn bake<'py>(
        &self,
        py: Python<'py>,
        step_mm: Option<f64>,
        content: Content,
        output: Option<PathBuf>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let options = BakeOptions {
            step_m: step_mm.map(|step_mm| 1e-3 * step_mm),
            channels: if content.spectrum { Channels::Spectrum } else { Channels::Rgb },
            is_total: content.is_total,
            lightmap: content.lightmap,
            has_irradiance: content.irradiance,
        };
        if let Some(step_mm) = step_mm {
            STEP_RANGE.check(step_mm).map_err(input)?;
        }
        let (baked, provenance) = self.work(
            py,
            Method::default(),
            Watchers { progress, preview: None },
            move |Built { integrator, provenance }, control| {
                let baked = integrator.bake(options, &|at| control.set_phase(at));
                baked.map(|baked| (baked, provenance.clone())).map_err(|error: BakeError| input(error))
            },
        )?;
        if let Some(path) = output {
            let is_glb = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("glb"));
            let write = if is_glb { write_glb } else { write_ply };
            write(&baked, &provenance, &path).map_err(failure)?;
        }
        let bake_dict = PyDict::new(py);
        bake_dict.set_item("lamps", baked.lamps.iter().map(|lamp| lamp.kind).collect::<Vec<_>>())?;
        bake_dict.set_item("provenance", provenance.to_string())?;
        if let Some(lightmap) = &baked.lightmap {
            bake_dict.set_item("lightmap", PyArray1::from_slice(py, lightmap.texels.as_flattened()))?;
        }
        let objects = baked.objects.iter().enumerate().map(|(number, object)| {
            let dict = baked_object(py, &baked, object)?;
            if let Some(irradiance) = baked.irradiance.get(number) {
                let values = irradiance.iter().flat_map(|vertex| [vertex.direct, vertex.diffuse]);
                let values = values.flat_map(|LinearRgb { r, g, b }| [r, g, b]).collect();
                dict.set_item("irradiance", PyArray1::from_vec(py, values))?;
            }
            if content.reflection {
                dict.set_item(
                    "reflection",
                    PyArray1::from_vec(py, object.half_space.reflection_table(REFLECTION_STEPS)),
                )?;
            }
            Ok(dict)
        });
        std::iter::once(Ok(bake_dict)).chain(objects).collect()
    }
}

/// Adds all samples of a picture, which is shown from time to time if it `shows`, and returns how many cannot be used.
fn add_samples(
    integrator: &Integrator,
    target: &SampleBlock,
    sums: &mut FilmAccumulator,
    control: &Control,
    shows: bool,
) -> u64 {
    let (all, mut unusable_samples) = (target.count(), 0);
    loop {
        let missing = sums.missing_count(target);
        if missing == 0 || control.is_stopped() {
            return unusable_samples;
        }
        let pause = shows.then(|| Instant::now() + PREVIEW_INTERVAL);
        let render_control = RenderControl {
            report: &|at| control.set_phase(Progress { done: all - missing + at.done, total: all, ..at }),
            stop: &|| control.is_stopped() || pause.is_some_and(|pause| Instant::now() >= pause),
        };
        unusable_samples += render_missing(integrator, target, sums, render_control).unusable_samples;
        if shows {
            control.show(to_raster(&sums.film(), integrator.scene().film().development()));
        }
    }
}

/// The description of a JSON document.
fn described(text: &str) -> PyResult<SceneDescription> {
    serde_json::from_str(text).map_err(input)
}

impl Scene {
    fn new(description: SceneDescription, files: GivenFiles) -> Self {
        Self { description, files: Arc::new(files), last: Arc::default() }
    }

    /// Prepares the scene on another thread and works with it on that thread. If the files have not changed, the
    /// scene keeps the parts that it has in common with the scene that was built last.
    fn work<T: Send + 'static>(
        &self,
        py: Python<'_>,
        Method { table, views }: Method,
        Watchers { progress, preview }: Watchers,
        work: impl FnOnce(&Built, &Control) -> PyResult<T> + Send + 'static,
    ) -> PyResult<T> {
        let (description, files, last) = (self.description.clone(), Arc::clone(&self.files), Arc::clone(&self.last));
        let shows = preview.is_some();
        run_showing(py, progress.as_ref(), preview.as_ref(), move |control| {
            let is_current = |Built { integrator, provenance }: &Built| {
                *provenance == provenance.of_same_files(integrator.scene().description(), &*files)
            };
            let earlier = last.lock().unwrap_or_else(PoisonError::into_inner).take().filter(is_current);
            let earlier = earlier.map(|built| built.integrator);
            control.set_phase(Progress { phase: Phase::Meshes, done: 0, total: 0 });
            let report = |at| control.set_phase(at);
            let scene = if let Some(earlier) = &earlier {
                description.build_after(earlier.scene(), &*files)
            } else {
                let smooth = description.build_smooth(&*files).map_err(input)?;
                // If the first picture fails, its cells are too coarse for the snow, and no first picture is shown.
                if shows && let Ok(Some(first)) = render_coarse(&smooth, &report) {
                    control.show(to_raster(&first.film, first.development));
                }
                smooth.with_relief(&report)
            };
            let scene = scene.map_err(input)?;
            let preparation = Preparation { table: table.as_deref(), earlier, views, report: &report };
            let integrator = Integrator::prepare_with(&scene, preparation).map_err(input)?;
            let built = Built { provenance: integrator.provenance(), integrator };
            let result = work(&built, control);
            *last.lock().unwrap_or_else(PoisonError::into_inner) = Some(built);
            result
        })
    }
}

fn baked_object<'py>(py: Python<'py>, baked: &BakedScene, object: &BakedObject) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let vectors =
        |vectors: &[glam::Vec3]| PyArray1::from_vec(py, vectors.iter().flat_map(|vector| vector.to_array()).collect());
    dict.set_item("name", &object.name)?;
    dict.set_item("positions", vectors(&object.positions))?;
    dict.set_item("normals", vectors(&object.normals))?;
    dict.set_item("triangles", PyArray1::from_vec(py, object.triangles.concat()))?;
    dict.set_item("texture_coordinates", PyArray1::from_slice(py, object.texture_coordinates.as_flattened()))?;
    let flux: Vec<_> = object.flux.iter().map(|flux| PyArray1::from_slice(py, flux)).collect();
    dict.set_item("flux", flux)?;
    let exitance = object.exitance.iter().flat_map(|colour| [colour.r, colour.g, colour.b]).collect();
    dict.set_item("exitance", PyArray1::from_vec(py, exitance))?;
    dict.set_item("channels", baked.channels.count())?;
    dict.set_item("escape_polynomial", object.snow.escape.coefficients.to_vec())?;
    dict.set_item("extrapolation", object.snow.extrapolation)?;
    dict.set_item("transport_length_m", object.snow.transport_length_m)?;
    Ok(dict)
}

/// Whether a picture is a PNG; otherwise it is an OpenEXR file.
fn is_png(path: &Path) -> PyResult<bool> {
    match path.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase).as_deref() {
        Some("png") => Ok(true),
        Some("exr") => Ok(false),
        _ => Err(input(format!("{}: a picture must end in .png or .exr", path.display()))),
    }
}

fn save(sums: &FilmAccumulator, settings: PictureSettings, is_png: bool, path: &Path) -> Result<(), RenderError> {
    let software = concat!("snowblue ", env!("CARGO_PKG_VERSION"));
    let metadata = [("Software", software)];
    if is_png {
        write_png(&sums.film(), settings.development, &metadata, path)
    } else {
        resumable_file::write(sums, settings, None, &metadata, path)
    }
}
