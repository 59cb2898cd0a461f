//! Renders until all samples are done or a signal arrives, with checkpoints and previews in between.

use std::time::{Duration, Instant};

use snowblue_render::film::resumable_file::ResumableImage;
use snowblue_render::render::{RenderControl, accumulator, render_missing, with_needed};
use snowblue_render::scene::provenance::Provenance;
use snowblue_render::scene::queries::Statistics;
use snowblue_render::{Aovs, FilmAccumulator, Integrator, Phase, Progress, SampleBlock, Scene};

use super::preview::Preview;
use crate::commands::interrupt;
use crate::options::FilmMemory;
use crate::output::{
    Failure, Outcome, Phases, PictureFile, describe_samples, print_message, print_notes, statistics_table,
};

/// Interval of previews.
const PREVIEW_INTERVAL: Duration = Duration::from_secs(1);

/// A picture to render.
pub(super) struct RenderJob<'a> {
    pub(super) integrator: &'a Integrator,
    pub(super) provenance: Provenance,
    pub(super) aovs: Aovs,
    pub(super) target: SampleBlock,
    pub(super) file: PictureFile,
    pub(super) film_memory: FilmMemory,
    /// Further metadata of the picture.
    pub(super) notes: Vec<(&'static str, String)>,
    /// Interval of checkpoints.
    pub(super) checkpoint: Option<Duration>,
    pub(super) preview: Option<Preview>,
    pub(super) phases: Phases,
    pub(super) prints_statistics: bool,
    pub(super) quiet: bool,
}

impl RenderJob<'_> {
    fn scene(&self) -> &Scene {
        self.integrator.scene()
    }

    /// Renders the picture, from the start or from the samples in the file.
    pub(super) fn run(mut self, resume: bool) -> Outcome {
        let mut sums = match resume.then(|| self.resumed()).transpose()?.flatten() {
            Some(sums) => sums.extended_to(&self.target.window()),
            None => accumulator(self.scene(), self.aovs, &self.target.window()),
        };
        if self.is_finished(&sums) {
            self.print_note(&format!("{}: already has all of these samples", self.file.path.display()));
            return Ok(());
        }
        interrupt::keep_samples();
        let statistics = self.render(&mut sums)?;
        self.phases.end();
        if sums.is_empty() {
            return Err(interrupt::nothing_written());
        }
        self.write(&sums)?;
        self.print_statistics(&statistics);
        if self.is_finished(&sums) { Ok(()) } else { Err(Failure::Interrupted(self.interrupted(&sums))) }
    }

    /// The samples of an existing output file.
    fn resumed(&self) -> Result<Option<FilmAccumulator>, Failure> {
        let path = &self.file.path;
        if !path.exists() {
            return Ok(None);
        }
        let part = ResumableImage::open(path).map_err(Failure::input)?;
        let differs = |what: &str| Failure::Input(format!("{}: cannot be resumed: {what}", path.display()));
        if let Some(difference) = part.provenance.difference(&self.provenance) {
            return Err(differs(&format!("it is another picture: {difference}")));
        }
        let aovs = with_needed(self.aovs, self.scene().description());
        if part.aovs != aovs {
            return Err(differs(&format!("its AOVs are {}, not {aovs}", part.aovs)));
        }
        let first = self.target.samples.start;
        if part.samples.start != first {
            let what =
                format!("it begins with sample {}, not {first}: render another part, and merge", part.samples.start);
            return Err(differs(&what));
        }
        // Samples of other pixels move to a larger film.
        let window = part.window.enclosing(&self.target.window());
        let both = [&window, &part.window];
        self.film_memory.check(&self.file, if window == part.window { &both[..1] } else { &both }, aovs)?;
        part.read_sums().map(Some).map_err(Failure::input)
    }

    /// Renders missing samples until all are done or a signal arrives.
    fn render(&mut self, sums: &mut FilmAccumulator) -> Result<Statistics, Failure> {
        let all = self.target.count();
        let mut statistics = Statistics::default();
        self.phases.report(Progress {
            phase: Phase::Samples,
            done: all - sums.missing_count(&self.target),
            total: all,
        });
        let mut next_checkpoint = self.checkpoint.map(|every| Instant::now() + every);
        loop {
            let missing = sums.missing_count(&self.target);
            if missing == 0 || interrupt::is_requested() {
                return Ok(statistics);
            }
            let done = all - missing;
            let next_preview = self.preview.as_ref().map(|_| Instant::now() + PREVIEW_INTERVAL);
            let pause = next_preview.into_iter().chain(next_checkpoint).min();
            let control = RenderControl {
                report: &|at| self.phases.report(Progress { done: done + at.done, total: all, ..at }),
                stop: &|| interrupt::is_requested() || pause.is_some_and(|pause| Instant::now() >= pause),
            };
            statistics = statistics.plus(render_missing(self.integrator, &self.target, sums, control));
            if let Some(preview) = &mut self.preview
                && let Err(error) = preview.show(sums)
            {
                self.preview = None;
                self.print_note(&format!("the preview has stopped: {error}"));
            }
            if let (Some(at), Some(every)) = (next_checkpoint, self.checkpoint)
                && Instant::now() >= at
            {
                // A full disk may have space again later, so rendering goes on.
                if let Err(Failure::Work(reason)) = self.write(sums) {
                    print_message(&format!("checkpoint failed, rendering continues: {reason}\n"));
                }
                next_checkpoint = Some(Instant::now() + every);
            }
        }
    }

    /// Writes the picture. An unfinished picture keeps its sums, so that it can be resumed.
    fn write(&self, sums: &FilmAccumulator) -> Outcome {
        let mut file = self.file.clone();
        file.keeps_sums |= !self.is_finished(sums);
        // A signal must not remove the finished picture.
        let first_picture = interrupt::keep_picture();
        let written = file.write(sums, (&self.provenance, self.scene().picture_settings()), &[], &self.notes);
        written.inspect_err(|_| first_picture.as_deref().into_iter().for_each(interrupt::set_first_picture))
    }

    fn is_finished(&self, sums: &FilmAccumulator) -> bool {
        sums.missing_count(&self.target) == 0
    }

    fn print_statistics(&self, statistics: &Statistics) {
        if self.prints_statistics {
            print_message(&statistics_table(&self.phases, &self.integrator.statistics(), statistics));
        }
        let Statistics { odd_depth_lines, depth_lines, unusable_samples, .. } = statistics;
        if *odd_depth_lines > 0 {
            self.print_note(&format!(
                "{odd_depth_lines} of {depth_lines} lines through snow crossed its surface an odd number of times: a \
                 mesh is open (--check says which, and `snowblue repair` closes holes)"
            ));
        }
        if *unusable_samples > 0 {
            self.print_note(&format!(
                "{unusable_samples} samples count as black: their radiance is not finite, or above 2.8e8 W m⁻² sr⁻¹"
            ));
        }
    }

    fn interrupted(&self, sums: &FilmAccumulator) -> String {
        let (path, samples) = (self.file.path.display(), describe_samples(sums));
        let asked = self.target.samples.end - self.target.samples.start;
        let next = match self.file.needs_exr("--resume") {
            Ok(()) => "the same command with --resume continues",
            Err(_) => "a PNG cannot be resumed, an EXR can",
        };
        format!("interrupted: {path} has {samples} of {asked} samples per pixel; {next}")
    }

    fn print_note(&self, note: &str) {
        print_notes(self.quiet, [note]);
    }
}
