//! The work of `snowblue render`: samples until they are done or it is told to stop, with a look at what there is in between.

use std::path::Path;
use std::time::{Duration, Instant};

use snowblue_render::film::part_file::{Kept, Part};
use snowblue_render::film::provenance::Provenance;
use snowblue_render::render::{Watch, render_missing};
use snowblue_render::scene::queries::Statistics;
use snowblue_render::{Aovs, FilmAccumulator, SampleBlock, Scene};

use crate::failure::{Failure, Outcome};
use crate::interrupt;
use crate::picture::{PictureFile, samples_in_words};
use crate::preview::Preview;
use crate::progress::Progress;
use crate::report::tell;

/// How often a preview is sent.
const PREVIEW_EVERY: Duration = Duration::from_secs(1);

/// A picture to be made.
pub(crate) struct RenderJob<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) origin: Provenance,
    pub(crate) channels: Aovs,
    pub(crate) target: SampleBlock,
    pub(crate) file: PictureFile,
    /// What is noted in the picture beside its origin.
    pub(crate) notes: Vec<(&'static str, String)>,
    /// How often the picture is written before it is finished.
    pub(crate) checkpoint: Option<Duration>,
    pub(crate) preview: Option<Preview>,
    pub(crate) quiet: bool,
}

impl RenderJob<'_> {
    /// Makes the picture, from the start or from where the file stopped.
    pub(crate) fn run(mut self, resume: bool) -> Outcome {
        let mut sums = match resume.then(|| self.begun()).transpose()?.flatten() {
            Some(sums) => sums.widened(&self.target.window()),
            None => FilmAccumulator::new(self.scene, self.channels, &self.target.window()),
        };
        if self.is_finished(&sums) {
            self.say(&format!("{}: all of these samples are in it already\n", self.file.path.display()));
            return Ok(());
        }
        interrupt::listen(&self.file.path)?;
        let bar = Progress::new("samples", self.quiet);
        let statistics = self.fill(&mut sums, &bar)?;
        bar.end();
        if sums.coverage().portions().is_empty() {
            return Err(Failure::Interrupted("interrupted before the first sample: nothing is written".to_owned()));
        }
        self.write(&sums)?;
        self.report(&statistics);
        if self.is_finished(&sums) { Ok(()) } else { Err(Failure::Interrupted(self.how_to_go_on(&sums))) }
    }

    /// What a file of the output's name holds, if there is one.
    fn begun(&self) -> Result<Option<FilmAccumulator>, Failure> {
        let path = &self.file.path;
        if !path.exists() {
            return Ok(None);
        }
        let part = Part::open(path).map_err(Failure::input)?;
        let differs = |what: &str| Failure::Input(format!("{}: cannot be resumed: {what}", path.display()));
        if let Some(difference) = part.origin.difference(&self.origin) {
            return Err(differs(&format!("the picture is another; {difference}")));
        }
        if part.channels != self.channels {
            return Err(differs(&format!("it has the channels {}, not {}", part.channels, self.channels)));
        }
        part.read(path).map(Some).map_err(Failure::input)
    }

    /// Adds samples until none is missing or an interrupt; checkpoints and previews are pauses.
    fn fill(&mut self, sums: &mut FilmAccumulator, bar: &Progress) -> Result<Statistics, Failure> {
        let all = self.target.count();
        let mut statistics = Statistics::default();
        let mut next_checkpoint = self.checkpoint.map(|every| Instant::now() + every);
        let mut first = true;
        loop {
            let missing: u64 = sums.coverage().missing_from(&self.target).iter().map(SampleBlock::count).sum();
            if missing == 0 || interrupt::asked() {
                return Ok(statistics);
            }
            let done = all - missing;
            if std::mem::take(&mut first) {
                bar.start_at(done, all);
            }
            let next_preview = self.preview.as_ref().map(|_| Instant::now() + PREVIEW_EVERY);
            let pause = next_preview.into_iter().chain(next_checkpoint).min();
            let watch = Watch {
                progress: &|at| bar.at(done + at.samples_done, all),
                stop: &|| interrupt::asked() || pause.is_some_and(|pause| Instant::now() >= pause),
            };
            statistics = statistics.plus(render_missing(self.scene, &self.target, sums, watch));
            if let Some(preview) = &mut self.preview
                && let Err(error) = preview.show(sums)
            {
                self.preview = None;
                self.say(&format!("the preview has ended: {error}\n"));
            }
            if let (Some(at), Some(every)) = (next_checkpoint, self.checkpoint)
                && Instant::now() >= at
            {
                // Where there is no room now there may be some at the end: no reason to throw samples away.
                if let Err(Failure::Work(reason)) = self.write(sums) {
                    tell(&format!("a checkpoint failed, the work goes on: {reason}\n"));
                }
                next_checkpoint = Some(Instant::now() + every);
            }
        }
    }

    /// Writes the picture; an unfinished one keeps its sums, lest its samples be lost.
    fn write(&self, sums: &FilmAccumulator) -> Outcome {
        let mut file = self.file.clone();
        file.keeps_sums |= !self.is_finished(sums);
        file.write(sums, Kept { origin: &self.origin, exposure: self.scene.film.exposure }, &self.notes)
    }

    fn is_finished(&self, sums: &FilmAccumulator) -> bool {
        sums.coverage().missing_from(&self.target).is_empty()
    }

    fn report(&self, statistics: &Statistics) {
        let Statistics { odd_depth_lines, depth_lines, unusable_samples, .. } = statistics;
        if *odd_depth_lines > 0 {
            self.say(&format!(
                "{odd_depth_lines} of {depth_lines} lines through snow crossed it an odd number of times: a mesh is open (see --check)\n"
            ));
        }
        if *unusable_samples > 0 {
            self.say(&format!(
                "{unusable_samples} samples count as dark: their light is no number, or brighter than 2.8e8 W m⁻² sr⁻¹\n"
            ));
        }
    }

    fn how_to_go_on(&self, sums: &FilmAccumulator) -> String {
        let (path, samples) = (self.file.path.display(), samples_in_words(sums));
        let asked = self.target.samples.end - self.target.samples.start;
        let next = match self.file.needs_exr("--resume") {
            Ok(()) => "the same command with --resume goes on",
            Err(_) => "a PNG cannot be resumed, an .exr can",
        };
        format!("interrupted: {path} has {samples} of {asked} samples per pixel; {next}")
    }

    fn say(&self, text: &str) {
        if !self.quiet {
            tell(text);
        }
    }
}

/// The name of a file without its folders.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
