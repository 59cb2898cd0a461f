//! `snowblue render`: renders a scene as a picture.

mod check;
mod job;
mod preview;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use glam::DVec3;
use snowblue_base::atomic_file::is_stream;
use snowblue_base::{Count, Number};
use snowblue_database::CompressedTable;
use snowblue_render::film::image_file::write_png;
use snowblue_render::film::window::Window;
use snowblue_render::render::{render_coarse, with_needed};
use snowblue_render::scene::film::{ImageSize, SidePixels};
use snowblue_render::scene::integrator::{Bounces, NoiseTarget, SamplesPerPixel};
use snowblue_render::scene::progress::Report;
use snowblue_render::scene::{IntegratorKind, PathMode, Views};
use snowblue_render::{Aovs, Integrator, Phase, Preparation, SampleBlock, Scene, SceneDescription, SceneFile};

use crate::commands::interrupt;
use crate::input::SCENES;
use crate::options::{
    DevelopmentOptions, FilmMemory, GivenOptions, Idle, LightFieldOptions, SceneOptions, limits, parse,
};
use crate::output::{
    Failure, Format, Outcome, OutputOptions, Phases, PictureFile, PictureFormat, SCENE_NOTE, TABLE_NOTE,
    check_not_input, output_path, print, print_notes,
};
use job::RenderJob;
use preview::{Preview, TEV};

/// Render a scene (TOML) as PNG or EXR
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue render scenes/block_30cm.toml -o block.png
  snowblue render --list-scenes                         the scenes inside this program
  snowblue render --scene block_30cm -o block.png       one of them
  snowblue render --scene block_30cm --print > my.toml  its file, to start from
  snowblue render scenes/block_30cm.toml --path view -o view.png    the paper's path mode
  snowblue render scenes/block_30cm.toml --width 270 --height 270 --spp 16 -o draft.exr
  snowblue render scenes/block_30cm.toml --integrator diffusion -o block.png    the light field in the snow
  snowblue render scenes/fig9_back.toml --integrator reference --width 32 --height 32 -o truth.exr
  snowblue render scenes/block_30cm.toml --check        sizes; is the snow watertight?
  snowblue render scenes/block_30cm.toml --aovs rgb,spectrum,normal -o block.exr
  snowblue render scenes/block_30cm.toml --spp-range 0:50 -o part1.exr    then merge
  snowblue render scenes/block_30cm.toml --crop 500:516,300:316 --spp 1000 -o detail.exr
  snowblue render scenes/block_30cm.toml --spp 4096 --checkpoint 10 --resume -o block.exr

Ctrl-C and SIGTERM write the samples so far, if there are any, and end with exit code 130; --resume continues an \
.exr. Pictures are identical to the last bit however they are split into parts, and on any number of threads."
)]
pub(crate) struct Render {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    #[command(flatten)]
    scene: SceneOptions,
    /// List the scenes inside this program
    #[arg(long)]
    list_scenes: bool,
    /// Print the file of --scene, to start from, instead of rendering it
    #[arg(long)]
    print: bool,
    /// Picture to write: .png (8-bit sRGB; a new file may begin as a coarse first picture) or .exr (linear RGB,
    /// 32-bit); - is the standard output, as PNG
    #[arg(
        short, long, value_name = "FILE", value_parser = output_path(),
        required_unless_present_any = ["check", "list_scenes", "print"]
    )]
    output: Option<PathBuf>,
    /// Only report the objects: sizes in metres, open edges, rays that find them open; exit code 1 if snow is not
    /// watertight. -o then names a .csv, .json or .txt file
    #[arg(long)]
    check: bool,
    /// Format of --check [default: by the file's ending, else a table on a terminal and CSV into a pipe]
    #[arg(long, value_name = "FORMAT", value_enum, requires = "check")]
    format: Option<Format>,
    /// Compressed table of snow for the integrator pcasnow, NetCDF, instead of the scene's [default: the embedded one];
    /// the curves of snow that it does not hold are solved for
    #[arg(long, value_name = "FILE")]
    database: Option<PathBuf>,
    /// Integrator, instead of the scene's: pcasnow (curves of slabs, along one straight line), diffusion (the light
    /// field inside the snow, read at its surface), hybrid (random walks that end in the light field) or reference
    /// (volumetric path tracer, the ground truth, slow)
    #[arg(long, value_name = "NAME", value_parser = parse_integrator)]
    integrator: Option<IntegratorKind>,
    /// Path mode of the integrator pcasnow, which it selects if --integrator is not given: brightest (the
    /// brighter of the next two), normal (along the inward normal), light (towards the light) or view (along the
    /// viewing ray, as in the paper)
    #[arg(long, value_name = "MODE", value_parser = parse_path_mode)]
    path: Option<PathMode>,
    #[arg(
        long, value_name = "N", value_parser = parse::count::<SidePixels>,
        help = format!("Width in pixels [{}], instead of the scene's", limits::of::<SidePixels>())
    )]
    width: Option<Count<SidePixels>>,
    #[arg(
        long, value_name = "N", value_parser = parse::count::<SidePixels>,
        help = format!("Height in pixels [{}], instead of the scene's", limits::of::<SidePixels>())
    )]
    height: Option<Count<SidePixels>>,
    #[arg(
        long, value_name = "N", value_parser = parse::count::<SamplesPerPixel>,
        help = format!("Samples per pixel [{}], instead of the scene's", limits::of::<SamplesPerPixel>())
    )]
    spp: Option<Count<SamplesPerPixel>>,
    #[arg(
        long, value_name = "FRACTION", value_parser = parse::quantity::<NoiseTarget>,
        help = format!(
            "Standard error of a pixel relative to its luminance [{}] below which it gets no further samples, instead \
             of the scene's; --spp is then the greatest number", limits::of::<NoiseTarget>()
        )
    )]
    noise_target: Option<Number<NoiseTarget>>,
    /// Leave out the filter of hybrid and diffusion, which averages the noise of random walks, of samples of a sky and
    /// of light from other surfaces over pixels of like surfaces
    #[arg(long)]
    raw: bool,
    /// Only samples A to B-1 of each pixel, 0 ≤ A < B ≤ 4294967295: a part for 'snowblue merge'
    #[arg(long, value_name = "A:B", value_parser = parse::whole_range, conflicts_with = "spp")]
    spp_range: Option<Range<u32>>,
    /// Only columns X0 to X1-1 and rows Y0 to Y1-1, from the upper left: a part for 'snowblue merge'
    #[arg(long, value_name = "X0:X1,Y0:Y1", value_parser = parse::window)]
    crop: Option<Window>,
    #[arg(
        long, value_name = "N", value_parser = parse::count::<Bounces>,
        help = format!(
            "Greatest number of bounces [{}], instead of the scene's; 0 is direct light only", limits::of::<Bounces>()
        )
    )]
    max_bounces: Option<Count<Bounces>>,
    /// Seed of random numbers [0–4294967295], instead of the scene's
    #[arg(long, value_name = "N", value_parser = parse::whole_number::<u32>(0..=u32::MAX.into()))]
    seed: Option<u32>,
    #[command(flatten)]
    light_field: LightFieldOptions,
    #[command(flatten)]
    development: DevelopmentOptions,
    /// Arbitrary output variables (AOVs) of an .exr, separated by commas: rgb, spectrum (31 channels, W/(m² sr nm)),
    /// variance (of the mean), normal, albedo, thickness (m), angle (degrees), emitter (fraction of samples that see a
    /// lamp or the sun), snow (fraction that sees snow), alpha (fraction that sees a surface; leaves the sky out of the
    /// colours), depth (m along the viewing axis), position (m), object, material (mattes in the layout of Cryptomatte)
    #[arg(long, value_name = "LIST", default_value = "rgb", value_parser = parse::aovs)]
    aovs: Aovs,
    /// Keep the sums of samples in an .exr, for 'snowblue merge' and --resume; parts of pictures always keep them
    #[arg(long)]
    keep_sums: bool,
    /// Continue the .exr of -o if it exists: after an interrupt, or to more --spp
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    film_memory: FilmMemory,
    /// Write the unfinished picture at this interval in minutes [0.01–100000]
    #[arg(long, value_name = "MINUTES", value_parser = parse::minutes)]
    checkpoint: Option<Duration>,
    /// Show the unfinished picture in the viewer tev, after a first one with coarse cells of snow [127.0.0.1:14158 if
    /// no address is given]
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = TEV)]
    tev: Option<String>,
    /// Print what the picture took to the standard error: time and memory of each phase, and counts of triangles,
    /// cells, solutions, rays and walks
    #[arg(long)]
    stats: bool,
}

/// Greatest ratio of the size of snow cells to the size that the pixels of a picture need. Above it, a message is
/// printed.
const MAX_FACTOR: f64 = 2.0;

/// Fewest pixels of a picture for which a first picture is written as a file.
const MIN_FIRST_PIXELS: usize = 1 << 14;

impl Render {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.check_effects()?;
        if self.list_scenes {
            return list_scenes();
        }
        if let Some(scene) = self.scene.embedded().filter(|_| self.print) {
            return print(scene.text).map_err(Failure::work);
        }
        let output = match &self.output {
            Some(output) if !self.check => output,
            _ => {
                let output = OutputOptions { output: self.output.clone(), format: self.format };
                output.check()?;
                let (file, smooth) = self.load(&Phases::new(quiet, false), |_| Ok(()))?;
                let scene = smooth.with_relief(&|_| {}).map_err(|error| Failure::input(file.locate(error)))?;
                return check::check(&scene, &output, quiet);
            }
        };
        let _removes = interrupt::RemoveFirstPicture;
        self.render(output, quiet)
    }

    /// Renders the picture into a file.
    fn render(&self, output: &Path, quiet: bool) -> Outcome {
        let file = self.file(output)?;
        interrupt::listen(output)?;
        let mut preview = self.preview(file_name(output))?;
        let phases = Phases::new(quiet, self.stats);
        let (scene_file, smooth) = self.load(&phases, |scene| self.check_memory(scene, &file, quiet))?;
        scene_file.inputs(&smooth).iter().try_for_each(|input| check_not_input(input, output))?;
        let table = self.database.as_deref().map(CompressedTable::open).transpose().map_err(Failure::input)?;
        let report = |at| phases.report(at);
        // Parts and resumed pictures have no first picture, because it would cover the samples that are there.
        if !self.resume && !self.is_part() {
            let failed = first_picture(&smooth, preview.as_mut(), &file, &report).err();
            phases.end();
            print_notes(quiet, failed.map(|reason| format!("{}: no first picture: {reason}", output.display())));
        }
        let scene = smooth.with_relief(&report).map_err(|error| Failure::input(scene_file.locate(error)))?;
        phases.end();
        let (table, views) = (table.as_ref(), Some(Views::Camera));
        let preparation = Preparation { table, views, report: &report, ..Preparation::default() };
        let integrator = Integrator::prepare_with(&scene, preparation);
        let integrator = integrator.map_err(|error| Failure::input(error.located(&scene_file)))?;
        phases.end();
        let origin = scene.local_origin();
        let positions = (self.aovs.position && origin != DVec3::ZERO)
            .then(|| format!("`position` counts from {origin} m, which the attribute `positionOrigin` holds"));
        let notes = integrator.notes().iter().cloned().chain(coarse_cells(&integrator)).chain(positions);
        print_notes(quiet, notes.map(|note| format!("{}: {note}", output.display())));
        let target = self.target(scene.description())?;
        let job = RenderJob {
            integrator: &integrator,
            provenance: integrator.provenance(),
            target,
            notes: self.notes(),
            preview,
            aovs: self.aovs,
            file,
            film_memory: self.film_memory,
            checkpoint: self.checkpoint,
            phases,
            prints_statistics: self.stats,
            quiet,
        };
        job.run(self.resume)
    }

    /// Refuses options without effect on the requested work.
    fn check_effects(&self) -> Outcome {
        let picture_options: &[&str] = &[
            "integrator",
            "path",
            "width",
            "height",
            "spp",
            "noise_target",
            "raw",
            "spp_range",
            "crop",
            "max_bounces",
            "seed",
            "field_memory_mib",
            "field_step_mm",
            "film_memory_mib",
            "exposure",
            "tone",
            "white",
            "aovs",
            "keep_sums",
            "resume",
            "checkpoint",
            "tev",
            "stats",
        ];
        let scene_options: &[&str] = &["output", "check", "format", "database"];
        self.given.refuse_idle(&[
            Idle { when: self.check, options: picture_options, why: "--check renders no picture" },
            Idle { when: self.print, options: picture_options, why: "--print renders no picture" },
            Idle { when: self.print, options: scene_options, why: "--print prints the file of a scene" },
            Idle {
                when: self.scene.embedded().is_none() && !self.list_scenes,
                options: &["print"],
                why: "it prints a scene inside this program, which --scene NAME chooses",
            },
            Idle { when: self.list_scenes, options: picture_options, why: "--list-scenes renders no picture" },
            Idle { when: self.list_scenes, options: scene_options, why: "--list-scenes prints the names of scenes" },
            Idle {
                when: self.list_scenes,
                options: &["SCENE", "scene", "print"],
                why: "--list-scenes lists all scenes",
            },
        ])
    }

    /// Refuses options without effect on a scene.
    fn check_effects_on(&self, scene: &SceneDescription) -> Outcome {
        let mut changed = scene.clone();
        self.override_values(&mut changed);
        let kind = changed.integrator.kind;
        let solves_field = kind.has_light_field();
        let no_field = format!("the integrator {} solves for no light field", kind.name());
        let no_modes = format!("the integrator {} has no path modes", kind.name());
        let no_table = format!("the integrator {} reads no table", kind.name());
        self.given.refuse_idle(&[
            Idle { when: !solves_field, options: &["field_memory_mib", "field_step_mm"], why: &no_field },
            Idle { when: !kind.has_curves(), options: &["path"], why: &no_modes },
            Idle { when: !kind.has_curves(), options: &["database"], why: &no_table },
        ])
    }

    /// The connection to the viewer, if the address of a viewer is given.
    fn preview(&self, name: String) -> Result<Option<Preview>, Failure> {
        self.tev.as_ref().map(|address| Preview::connect(address, name)).transpose()
    }

    /// The notes of a picture on its scene.
    fn notes(&self) -> Vec<(&'static str, String)> {
        let table = self.database.as_deref().map(|path| (TABLE_NOTE, path.display().to_string()));
        [(SCENE_NOTE, self.scene.name())].into_iter().chain(table).collect()
    }

    /// The output file, if the options agree with its format.
    fn file(&self, output: &Path) -> Result<PictureFile, Failure> {
        let file = PictureFile::new(output, self.keep_sums || self.resume || self.is_part())?;
        for (is_given, option) in [(self.resume, "--resume"), (self.checkpoint.is_some(), "--checkpoint")] {
            if is_given && is_stream(output) {
                return Err(Failure::Input(format!("{}: {option} needs a file, not a stream", output.display())));
            }
        }
        for (is_given, option) in
            [(self.resume, "--resume"), (self.keep_sums, "--keep-sums"), (self.aovs != Aovs::default(), "--aovs")]
        {
            if is_given {
                file.needs_exr(option)?;
            }
        }
        Ok(file)
    }

    /// Whether only a part of the samples of a picture is rendered.
    fn is_part(&self) -> bool {
        self.spp_range.is_some() || self.crop.is_some()
    }

    /// The pixels and samples to render.
    fn target(&self, scene: &SceneDescription) -> Result<SampleBlock, Failure> {
        let SceneDescription { film, integrator, .. } = scene;
        let (ImageSize { width, height }, samples) = (film.size(), integrator.samples_per_pixel.get());
        let mut target = SampleBlock { columns: 0..width, rows: 0..height, samples: 0..samples };
        if let Some(samples) = &self.spp_range {
            target.samples = samples.clone();
        }
        if let Some(crop) = &self.crop {
            for (what, own, all) in [("columns", &crop.columns, width), ("rows", &crop.rows, height)] {
                if own.end > all {
                    let (start, end) = (own.start, own.end);
                    return Err(Failure::Input(format!(
                        "--crop has the {what} {start}:{end}, but the picture has {width} × {height} pixels: {what} \
                         lie in 0:{all}"
                    )));
                }
            }
            (target.columns, target.rows) = (crop.columns.clone(), crop.rows.clone());
        }
        Ok(target)
    }

    /// Checks that the pixels to render fit into the memory, and says how much memory they take.
    fn check_memory(&self, scene: &SceneDescription, file: &PictureFile, quiet: bool) -> Outcome {
        let window = self.target(scene)?.window();
        let needed_mib = self.film_memory.check(file, &[&window], with_needed(self.aovs, scene))?;
        let path = file.path.display();
        print_notes(quiet, needed_mib.map(|mib| format!("{path}: the pixels take {mib} MiB of memory")));
        Ok(())
    }

    /// Reads the scene, calls `check` with its description and builds it.
    fn load(
        &self,
        phases: &Phases,
        check: impl Fn(&SceneDescription) -> Outcome,
    ) -> Result<(SceneFile, Scene), Failure> {
        let mut file = self.scene.open()?;
        self.check_effects_on(&file.description)?;
        self.override_values(&mut file.description);
        check(&file.description)?;
        phases.begin(Phase::Meshes);
        let scene = file.build_smooth().map_err(Failure::input)?;
        scene.camera().map_err(|error| Failure::input(file.locate(error.into())))?;
        phases.end();
        Ok((file, scene))
    }

    /// Overrides values of the scene by options.
    fn override_values(&self, scene: &mut SceneDescription) {
        let SceneDescription { film, integrator, light_field, .. } = scene;
        film.width = self.width.unwrap_or(film.width);
        film.height = self.height.unwrap_or(film.height);
        self.development.override_values(film);
        let with_path_mode = self.path.map(|_| IntegratorKind::PcaSnow);
        integrator.kind = self.integrator.or(with_path_mode).unwrap_or(integrator.kind);
        if self.check {
            // Open meshes are to be reported, and no light is needed.
            integrator.kind = IntegratorKind::PcaSnow;
        }
        integrator.samples_per_pixel = self.spp.unwrap_or(integrator.samples_per_pixel);
        integrator.noise_target = self.noise_target.or(integrator.noise_target);
        integrator.filter &= !self.raw;
        integrator.max_bounces = self.max_bounces.unwrap_or(integrator.max_bounces);
        integrator.seed = self.seed.unwrap_or(integrator.seed);
        self.light_field.override_values(light_field);
        integrator.pcasnow.path = self.path.unwrap_or(integrator.pcasnow.path);
    }
}

/// Lists the scenes inside the program.
fn list_scenes() -> Outcome {
    let width = SCENES.iter().map(|scene| scene.name.len()).max().unwrap_or(0);
    let lines = SCENES.map(|scene| format!("{:width$}  {}\n", scene.name, scene.summary()));
    print(&lines.concat()).map_err(Failure::work)
}

/// Shows a first picture with coarse cells in the viewer, and as a PNG that does not exist yet.
fn first_picture(
    scene: &Scene,
    preview: Option<&mut Preview>,
    file: &PictureFile,
    report: Report,
) -> Result<(), String> {
    let writes_file = file.format == PictureFormat::Png
        && !is_stream(&file.path)
        && file.is_new()
        && scene.film().size().pixel_count() >= MIN_FIRST_PIXELS;
    if preview.is_none() && !writes_file {
        return Ok(());
    }
    let Some(first) = render_coarse(scene, report).map_err(|error| error.to_string())? else { return Ok(()) };
    // The file may have come meanwhile.
    if writes_file && file.is_new() {
        interrupt::set_first_picture(&file.path);
        let note = ("Comment", "First picture with coarse cells of snow");
        write_png(&first.film, first.development, &[note], &file.path).map_err(|error| error.to_string())?;
    }
    preview.map_or(Ok(()), |preview| preview.show_first(&first.film)).map_err(|error| error.to_string())
}

/// A message about cells of snow that may be too large, if the cells of a body follow the pixels of the picture.
fn coarse_cells(integrator: &Integrator) -> Option<String> {
    let factor = integrator.factor_of_cells().filter(|factor| *factor > MAX_FACTOR)?;
    let memory_mib = integrator.scene().description().light_field.memory_mib;
    Some(format!(
        "in {memory_mib} MiB cells of snow are {factor:.1} times as large as the pixels need; light may leak through \
         thin snow: raise --field-memory-mib"
    ))
}

/// The last component of a path.
fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Finds a value by its name.
fn by_name<T: Copy>(text: &str, values: &[T], name: impl Fn(T) -> &'static str) -> Result<T, String> {
    let names = || values.iter().map(|value| name(*value)).collect::<Vec<_>>().join(", ");
    values.iter().copied().find(|value| name(*value) == text).ok_or_else(|| format!("must be one of {}", names()))
}

fn parse_integrator(text: &str) -> Result<IntegratorKind, String> {
    by_name(text, &IntegratorKind::ALL, IntegratorKind::name)
}

fn parse_path_mode(text: &str) -> Result<PathMode, String> {
    by_name(text, &PathMode::ALL, PathMode::name)
}
