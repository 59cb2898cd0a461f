//! Pictures as the commands write them: PNG to look at, EXR to work with or to go on from.

use std::path::{Path, PathBuf};

use snowblue_render::FilmAccumulator;
use snowblue_render::film::image_file::write_png;
use snowblue_render::film::part_file::{self, Kept};

use crate::failure::{Failure, Outcome};
use crate::report::check_place;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Png,
    Exr,
}

/// A picture to be written.
#[derive(Debug, Clone)]
pub(crate) struct PictureFile {
    pub(crate) path: PathBuf,
    pub(crate) kind: Kind,
    /// Whether an EXR has the sums beside their means.
    pub(crate) keeps_sums: bool,
}

impl PictureFile {
    /// The kind of picture that a file's ending asks for, checked before the work and not after it.
    pub(crate) fn new(path: &Path, keeps_sums: bool) -> Result<Self, Failure> {
        let kind = match path.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase).as_deref() {
            Some("png") => Kind::Png,
            Some("exr") => Kind::Exr,
            _ => return Err(Failure::Input(format!("{}: the picture must end in .png or .exr", path.display()))),
        };
        check_place(path)?;
        Ok(Self { path: path.to_owned(), kind, keeps_sums })
    }

    /// Refuses an option that a PNG has no room for.
    pub(crate) fn needs_exr(&self, option: &str) -> Outcome {
        match self.kind {
            Kind::Exr => Ok(()),
            Kind::Png => Err(Failure::Input(format!(
                "{option} needs an .exr: a PNG holds colours only ('snowblue merge FILE.exr -o FILE.png' makes one of it)"
            ))),
        }
    }

    /// Writes the picture with what made it; `more` says what its origin does not know.
    pub(crate) fn write(&self, sums: &FilmAccumulator, kept: Kept, more: &[(&str, String)]) -> Outcome {
        let Kept { origin, exposure } = kept;
        let mut notes = vec![("Software", format!("snowblue {}", origin.get("version").unwrap_or("?")))];
        notes.extend(more.iter().cloned());
        notes.push(("Samples per pixel", samples_in_words(sums)));
        for (keyword, name) in
            [("Seed", "seed"), ("Max bounces", "max bounces"), ("Path", "path"), ("Colours", "colours")]
        {
            notes.extend(origin.get(name).map(|value| (keyword, value.to_owned())));
        }
        let notes: Vec<(&str, &str)> = notes.iter().map(|(keyword, text)| (*keyword, &**text)).collect();
        match self.kind {
            Kind::Png => write_png(&sums.film(), exposure, &notes, &self.path),
            Kind::Exr => part_file::write(sums, self.keeps_sums.then_some(kept), &notes, &self.path),
        }
        .map_err(Failure::work)
    }
}

/// How many samples the pixels have: one number, or the fewest and the most.
pub(crate) fn samples_in_words(sums: &FilmAccumulator) -> String {
    let (fewest, most) = sums.samples_per_pixel();
    if fewest == most { most.to_string() } else { format!("{fewest}–{most}") }
}
