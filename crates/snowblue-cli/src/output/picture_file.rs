//! Pictures as PNG, to look at, or as EXR, to process, merge or resume.

use std::path::{Path, PathBuf};

use snowblue_render::FilmAccumulator;
use snowblue_render::film::accumulator::SampleCounts;
use snowblue_render::film::aov::Aovs;
use snowblue_render::film::image_file::write_png;
use snowblue_render::film::residual_filter;
use snowblue_render::film::resumable_file::{self, ResumeData};

use super::failure::{Failure, Outcome};
use super::files::{check_path, ending};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    Png,
    Exr,
}

/// Keywords of the notes of a picture on its scene.
pub(crate) const SCENE_NOTE: &str = "Scene";
pub(crate) const TABLE_NOTE: &str = "Table";

/// Why options of a PNG have no effect on an EXR without sums.
pub(crate) const IDLE_PNG_OPTION: &str =
    "an .exr holds light as it is; with --keep-sums it also keeps exposure and tone curve of a later .png";

/// A picture file to write.
#[derive(Debug, Clone)]
pub(crate) struct PictureFile {
    pub(crate) path: PathBuf,
    pub(crate) format: PictureFormat,
    /// Whether an EXR keeps the sums of samples, which merging and resuming need.
    pub(crate) keeps_sums: bool,
}

impl PictureFile {
    /// A file in the format of its extension. Call it before long work.
    pub(crate) fn new(path: &Path, keeps_sums: bool) -> Result<Self, Failure> {
        let format = match &*ending(path, "png") {
            "png" => PictureFormat::Png,
            "exr" => PictureFormat::Exr,
            _ => return Err(Failure::Input(format!("{}: the picture must end in .png or .exr", path.display()))),
        };
        check_path(path)?;
        Ok(Self { path: path.to_owned(), format, keeps_sums })
    }

    /// Memory that writing takes in addition to the sums, in bytes for each pixel: the memory of the filter, and for
    /// a PNG the memory of its colours, of what they show, of their brightness for the exposure, and of the bytes
    /// before and after encoding. An EXR is written in blocks.
    pub(crate) fn bytes_per_pixel(&self, aovs: Aovs) -> u64 {
        let encoding = match self.format {
            PictureFormat::Png => 44,
            PictureFormat::Exr => 0,
        };
        encoding + residual_filter::bytes_per_pixel(aovs)
    }

    /// Refuses an option that needs an EXR if the picture is a PNG.
    pub(crate) fn needs_exr(&self, option: &str) -> Outcome {
        match self.format {
            PictureFormat::Exr => Ok(()),
            PictureFormat::Png => Err(Failure::Input(format!(
                "{option} needs an .exr: a PNG holds colours only ('snowblue merge FILE.exr -o FILE.png' converts one)"
            ))),
        }
    }

    /// Writes the picture with metadata. The metadata `more` precede the metadata of the provenance.
    pub(crate) fn write(&self, sums: &FilmAccumulator, resume_data: ResumeData, more: &[(&str, String)]) -> Outcome {
        let ResumeData { provenance, development } = resume_data;
        let mut notes = vec![("Software", format!("snowblue {}", provenance.get("version").unwrap_or("?")))];
        notes.extend(more.iter().cloned());
        notes.push(("Samples per pixel", describe_samples(sums)));
        for (keyword, name) in
            [("Seed", "seed"), ("Max bounces", "max bounces"), ("Path", "path"), ("Colours", "colours")]
        {
            notes.extend(provenance.get(name).map(|value| (keyword, value.to_owned())));
        }
        let notes: Vec<(&str, &str)> = notes.iter().map(|(keyword, text)| (*keyword, &**text)).collect();
        match self.format {
            PictureFormat::Png => write_png(&sums.film(), development, &notes, &self.path),
            PictureFormat::Exr => {
                resumable_file::write(sums, self.keeps_sums.then_some(resume_data), &notes, &self.path)
            }
        }
        .map_err(Failure::work)
    }
}

/// The number of samples per pixel: one number, or the least and the greatest.
pub(crate) fn describe_samples(sums: &FilmAccumulator) -> String {
    let SampleCounts { fewest, most } = sums.samples_per_pixel();
    if fewest == most { most.to_string() } else { format!("{fewest}–{most}") }
}
