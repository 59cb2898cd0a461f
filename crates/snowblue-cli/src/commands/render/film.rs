//! `snowblue render --frames`: the frames of a film, each as a picture.
//!
//! One scene is built after the other, and keeps what did not change. A frame has the same bits in any part of the
//! film.

use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};

use snowblue_database::CompressedTable;
use snowblue_render::film::exposure::Exposure;
use snowblue_render::film::frame_record::FrameRecord;
use snowblue_render::film::provenance::Provenance;
use snowblue_render::film::resumable_file::ResumableImage;
use snowblue_render::render::with_needed;
use snowblue_render::{Aovs, Scene, SceneFile, render};

use super::job::RenderJob;
use super::preview::Preview;
use super::{Render, file_name, interrupt};
use crate::input::scene_table;
use crate::output::{Failure, Outcome, PictureFile, PictureFormat, print_message};

/// Frames that automatic exposure looks at, evenly over the film.
const METERED_FRAMES: u32 = 5;
/// The longer side of their pictures in pixels, and most samples of a pixel. In smaller pictures the cells of wide snow
/// are so large that light leaks through thin snow.
const METERED_SIDE: u32 = 240;
const METERED_SAMPLES: u32 = 4;
/// Fewest digits of the number of a frame.
const FEWEST_DIGITS: usize = 4;
/// What stands for the number of a frame.
pub(super) const NUMBER: &str = "{}";

/// A film to render.
pub(super) struct Film<'a> {
    options: &'a Render,
    file: SceneFile,
    table: Cow<'static, CompressedTable>,
    names: FrameNames,
    /// Frames of the whole film.
    count: u32,
    /// The frames to render.
    range: Range<u32>,
    format: PictureFormat,
    quiet: bool,
}

/// The names of the frames.
struct FrameNames {
    folder: PathBuf,
    /// What comes before the number, and after it.
    parts: [String; 2],
    digits: usize,
}

impl<'a> Film<'a> {
    /// Reads the scene, and checks it at all frames.
    pub(super) fn open(options: &'a Render, output: &Path, count: u32, quiet: bool) -> Result<Self, Failure> {
        let names = FrameNames::new(output, count)?;
        let range = options.frame_range.clone().unwrap_or(0..count);
        if range.end > count {
            return Err(Failure::Input(format!(
                "--frame-range ends at {}, but the film has {count} frames, 0 to {}",
                range.end,
                count - 1
            )));
        }
        let format = PictureFile::new(&names.path(0), false)?.format;
        let file = options.scene.open()?;
        options.check_effects_on(&file.description)?;
        if !file.has_keyframes() {
            let scene = options.scene.name();
            return Err(Failure::Input(format!("{scene}: has no [keyframes], so all frames would be the same")));
        }
        let table = scene_table(options.database.as_deref())?;
        let film = Self { options, file, table, names, count, range, format, quiet };
        let picture = film.picture(0)?;
        for (is_given, option) in [(options.keep_sums, "--keep-sums"), (options.aovs != Aovs::default(), "--aovs")] {
            if is_given {
                picture.needs_exr(option)?;
            }
        }
        options.check_effects_in(&picture)?;
        for number in 0..count {
            options.check_memory(&film.frame(number)?.description, &picture, quiet || number > 0)?;
        }
        Ok(film)
    }

    /// Renders the frames, with `--resume` those that are not finished.
    pub(super) fn render(&self) -> Outcome {
        let (mut missing, mut finished) = (Vec::new(), Vec::new());
        for number in self.range.clone() {
            match self.finished(number)? {
                None => missing.push(number),
                Some(record) => finished.push((number, record.exposure)),
            }
        }
        let note = format!("{} of {} frames are finished\n", finished.len(), self.range.len());
        if missing.is_empty() && self.format == PictureFormat::Exr {
            self.print_note(&note);
            return Ok(());
        }
        let first = self.names.path(missing.first().copied().unwrap_or(self.range.start));
        interrupt::listen(&first)?;
        let mut preview = if missing.is_empty() { None } else { self.options.preview(file_name(&first))? };
        let mut scene = None;
        // Also if no frame is missing: those that are there may have another exposure.
        let exposure = self.automatic_exposure(&mut scene)?;
        if self.format == PictureFormat::Png {
            for (number, found) in &finished {
                let wanted = self.exposed_frame(*number, exposure)?.description.film.exposure;
                if *found != wanted {
                    let what = format!("its exposure is {found}, not {wanted}");
                    return Err(self.cannot_resume(*number, &what));
                }
            }
        }
        if !finished.is_empty() {
            self.print_note(&note);
        }
        for number in missing {
            let frame = self.exposed_frame(number, exposure)?;
            let built = interrupt::at_once(interrupted(number), || self.build(&frame, scene.take()))?;
            self.render_frame(number, &built, preview.as_mut())?;
            scene = Some(built);
        }
        Ok(())
    }

    /// The scene of a frame, with the values of the options.
    fn frame(&self, number: u32) -> Result<SceneFile, Failure> {
        let mut frame = self.file.frame(number, self.count).map_err(Failure::input)?;
        self.options.override_values(&mut frame.description);
        frame.description.check().map_err(Failure::input)?;
        Ok(frame)
    }

    /// The same with the exposure of the film in place of an automatic one.
    fn exposed_frame(&self, number: u32, exposure: Option<Exposure>) -> Result<SceneFile, Failure> {
        let mut frame = self.frame(number)?;
        let film = &mut frame.description.film;
        if let (Exposure::Auto, Some(exposure)) = (film.exposure, exposure) {
            film.exposure = exposure;
        }
        Ok(frame)
    }

    /// Builds a scene, after another one if there is one.
    fn build(&self, frame: &SceneFile, earlier: Option<Scene>) -> Result<Scene, Failure> {
        let built = match earlier {
            None => frame.build(&self.table),
            Some(earlier) => frame.build_after(earlier, &self.table),
        };
        built.map_err(Failure::input)
    }

    /// The file of a frame.
    fn picture(&self, number: u32) -> Result<PictureFile, Failure> {
        let keeps_sums = self.options.keep_sums || self.options.is_part();
        Ok(PictureFile { is_frame: true, ..PictureFile::new(&self.names.path(number), keeps_sums)? })
    }

    /// With `--resume`, the record of a frame that has all samples.
    fn finished(&self, number: u32) -> Result<Option<FrameRecord>, Failure> {
        let path = self.names.path(number);
        if !self.options.resume || !path.exists() {
            return Ok(None);
        }
        let record = FrameRecord::read(&path).ok_or_else(|| self.cannot_resume(number, "it is no frame of a film"))?;
        let scene = self.frame(number)?.description;
        let files = self.options.scene.files();
        let expected = record.provenance.of_same_files(&scene, &self.table, &files);
        if let Some(difference) = record.provenance.difference(&expected) {
            return Err(self.cannot_resume(number, &format!("it is another picture: {difference}")));
        }
        let aovs = with_needed(self.options.aovs, &scene);
        if record.aovs != aovs {
            return Err(self.cannot_resume(number, &format!("its AOVs are {}, not {aovs}", record.aovs)));
        }
        if record.coverage.missing_from(&self.options.target(&scene)?).is_empty() {
            return Ok(Some(record));
        }
        if self.format == PictureFormat::Exr {
            ResumableImage::open(&path).map_err(Failure::input)?;
        }
        Ok(None)
    }

    fn cannot_resume(&self, number: u32, reason: &str) -> Failure {
        Failure::Input(format!("{}: cannot be resumed: {reason}", self.names.path(number).display()))
    }

    /// One exposure for all frames, if it is automatic and has an effect: the exposure of the brightest of some frames,
    /// rounded to a hundredth of a stop so that it does not depend on the machine.
    fn automatic_exposure(&self, scene: &mut Option<Scene>) -> Result<Option<Exposure>, Failure> {
        let is_automatic = self.frame(0)?.description.film.exposure == Exposure::Auto;
        if !is_automatic || (self.format == PictureFormat::Exr && !self.picture(0)?.keeps_sums) {
            return Ok(None);
        }
        let metered = METERED_FRAMES.min(self.count);
        let mut least: Option<f64> = None;
        for index in 0..metered {
            let number = index * (self.count - 1) / (metered - 1);
            let mut frame = self.frame(number)?;
            let (film, integrator) = (&mut frame.description.film, &mut frame.description.integrator);
            let side = film.width.max(film.height);
            if side > METERED_SIDE {
                (film.width, film.height) =
                    ((film.width * METERED_SIDE / side).max(1), (film.height * METERED_SIDE / side).max(1));
            }
            integrator.samples_per_pixel = integrator.samples_per_pixel.min(METERED_SAMPLES);
            integrator.noise_target = None;
            let (built, film) = interrupt::at_once(interrupted(number), || {
                let built = self.build(&frame, scene.take())?;
                let film = render(&built, &|_| {}).film;
                Ok((built, film))
            })?;
            *scene = Some(built);
            // A dark frame has no exposure of its own.
            if film.metered_pixels().any(|pixel| pixel.y > 0.0) {
                let factor = film.display_factor(Exposure::Auto);
                least = Some(least.map_or(factor, |least| least.min(factor)));
            }
        }
        let stops = least.map_or(0.0, |factor| (100.0 * factor.log2()).round() / 100.0);
        self.print_note(&format!("exposure: {stops} stops, by {metered} frames\n"));
        Ok(Some(Exposure::Stops(stops)))
    }

    fn render_frame(&self, number: u32, scene: &Scene, mut preview: Option<&mut Preview>) -> Outcome {
        let path = self.names.path(number);
        if let Some(preview) = &mut preview {
            preview.begin(file_name(&path));
        }
        let job = RenderJob {
            scene,
            provenance: Provenance::of(scene, &self.table),
            target: self.options.target(scene.description())?,
            notes: self.options.notes(),
            preview,
            aovs: self.options.aovs,
            file: self.picture(number)?,
            film_memory: self.options.film_memory,
            checkpoint: self.options.checkpoint,
            unit: format!("samples of frame {number} of 0–{}", self.count - 1),
            quiet: self.quiet,
        };
        match job.run(self.options.resume && self.format == PictureFormat::Exr) {
            Ok(()) => {
                if scene.description().integrator.kind.has_light_field() {
                    let solved = scene.solved_light_fields();
                    let fields = if solved == 1 { "field" } else { "fields" };
                    self.print_note(&format!("{}: {solved} light {fields} solved\n", path.display()));
                }
                Ok(())
            }
            Err(Failure::Interrupted(_)) => Err(Failure::Interrupted(interrupted(number))),
            Err(failure) => Err(failure),
        }
    }

    fn print_note(&self, text: &str) {
        if !self.quiet {
            print_message(text);
        }
    }
}

fn interrupted(number: u32) -> String {
    format!("interrupted at frame {number}; the same command with --resume continues")
}

impl FrameNames {
    fn new(output: &Path, count: u32) -> Result<Self, Failure> {
        let name = file_name(output);
        let Some((before, after)) = name.split_once(NUMBER) else {
            return Err(Failure::Input(format!(
                "{}: the name of frames must contain {NUMBER} for their number, such as film/{NUMBER}.png",
                output.display()
            )));
        };
        let digits = (count - 1).to_string().len().max(FEWEST_DIGITS);
        let folder = output.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self { folder, parts: [before, after].map(str::to_owned), digits })
    }

    fn path(&self, number: u32) -> PathBuf {
        let (digits, [before, after]) = (self.digits, &self.parts);
        self.folder.join(format!("{before}{number:0digits$}{after}"))
    }
}
