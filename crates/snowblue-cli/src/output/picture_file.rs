//! Pictures as PNG, to look at, or as EXR, to process, merge or resume.

use std::path::{Path, PathBuf};

use snowblue_color::ChromaticAdaptation;
use snowblue_render::FilmAccumulator;
use snowblue_render::film::accumulator::SampleCounts;
use snowblue_render::film::aov::Aovs;
use snowblue_render::film::image_file::{PNG_BYTES, write_png};
use snowblue_render::film::residual_filter;
use snowblue_render::film::resumable_file;
use snowblue_render::scene::film::PictureSettings;
use snowblue_render::scene::provenance::Provenance;

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

    /// Whether there is no file, and no link either.
    pub(crate) fn is_new(&self) -> bool {
        self.path.symlink_metadata().is_err()
    }

    /// Memory that writing takes in addition to the sums, in bytes for each pixel: the memory of the filter, and the
    /// memory of a PNG. An EXR is written in blocks.
    pub(crate) fn bytes_per_pixel(&self, aovs: Aovs) -> u64 {
        let encoding = match self.format {
            PictureFormat::Png => PNG_BYTES as u64,
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

    /// Writes the picture with metadata. The metadata `more` precede the metadata of the provenance. A PNG shows the
    /// colours after some adaptations.
    pub(crate) fn write(
        &self,
        sums: &FilmAccumulator,
        (provenance, settings): (&Provenance, PictureSettings),
        adaptations: &[ChromaticAdaptation],
        more: &[(&str, String)],
    ) -> Outcome {
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
            PictureFormat::Png => {
                write_png(&sums.film().adapted(adaptations), settings.development, &notes, &self.path)
            }
            PictureFormat::Exr => {
                let provenance = self.keeps_sums.then_some(provenance);
                resumable_file::write(sums, settings, provenance, &notes, &self.path)
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
