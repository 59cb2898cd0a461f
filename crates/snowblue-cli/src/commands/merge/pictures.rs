//! Merges parts of a picture.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use snowblue_color::ChromaticAdaptation;
use snowblue_render::film::resumable_file::ResumableImage;
use snowblue_render::raster::PixelPosition;
use snowblue_render::scene::film::white_balance::{PictureWhite, WhiteBalance};
use snowblue_render::scene::film::{ImageSize, PictureSettings};
use snowblue_render::{Development, FilmAccumulator};

use crate::options::{DevelopmentOptions, FilmMemory};
use crate::output::{Failure, Outcome, PictureFile, SCENE_NOTE, TABLE_NOTE, describe_samples};

/// Merges parts, writes the picture and returns a summary.
///
/// All headers are checked before the first pixel is read. Parts are checked for consecutive samples as they are
/// added.
pub(super) fn merge_pictures(
    paths: &[PathBuf],
    file: &PictureFile,
    given: DevelopmentOptions,
    memory: FilmMemory,
) -> Result<String, Failure> {
    let parts: Vec<ResumableImage> =
        paths.iter().map(|path| ResumableImage::open(path).map_err(Failure::input)).collect::<Result<_, _>>()?;
    check(paths, &parts)?;
    let exposures = || common(paths, &parts, "exposure", |development| development.exposure);
    let tones = || common(paths, &parts, "tone", |development| development.tone);
    let development =
        Development { exposure: given.exposure.map_or_else(exposures, Ok)?, tone: given.tone.map_or_else(tones, Ok)? };
    let first = &parts[0];
    let settings = PictureSettings { development, ..first.settings };
    let adaptations = adaptations(&paths[0], settings.white, given.white)?;
    let window = parts.iter().fold(first.window.clone(), |window, part| window.enclosing(&part.window));
    let largest = parts.iter().map(|part| &part.window).max_by_key(|window| window.size().pixel_count());
    memory.check(file, &[Some(&window), largest].into_iter().flatten().collect::<Vec<_>>(), first.aovs)?;
    let mut sums = FilmAccumulator::new(first.image_size, &window, first.aovs);
    let mut ordered: Vec<(&PathBuf, &ResumableImage)> = paths.iter().zip(&parts).collect();
    ordered.sort_by_key(|(_, part)| part.samples.start);
    for (path, part) in ordered {
        let added = sums.add(&part.read_sums().map_err(Failure::input)?);
        added.map_err(|error| Failure::Input(format!("{}: {error} of the other parts", path.display())))?;
    }
    if let Some(PixelPosition { x, y }) = sums.first_empty_pixel() {
        return Err(Failure::Input(format!("no part has a sample of pixel {x},{y}: the tiles leave a gap")));
    }
    let ImageSize { width: columns, height: rows } = window.size();
    let whole = first.image_size;
    let crop = if window.size() == whole {
        String::new()
    } else {
        format!(" of {} × {}, from {},{}", whole.width, whole.height, window.columns.start, window.rows.start)
    };
    file.write(&sums, (&first.provenance, settings), &adaptations, &common_notes(&parts))?;
    let (samples, count) = (describe_samples(&sums), paths.len());
    let parts = if count == 1 { "part" } else { "parts" };
    Ok(format!("{columns} × {rows} pixels{crop}, {samples} samples per pixel, from {count} {parts}"))
}

/// The adaptations after which the light of `--white` looks white; none without the option.
pub(super) fn adaptations(
    path: &Path,
    own: PictureWhite,
    given: Option<WhiteBalance>,
) -> Result<Vec<ChromaticAdaptation>, Failure> {
    let adaptations = given.map(|white| own.changed_to(white)).transpose();
    let adaptations = adaptations.map_err(|reason| Failure::Input(format!("{}: --white: {reason}", path.display())))?;
    Ok(adaptations.into_iter().flatten().collect())
}

/// The notes on the scene that all parts share: a merged file is the file of a single run.
fn common_notes(parts: &[ResumableImage]) -> Vec<(&'static str, String)> {
    let common = |keyword| {
        let text = parts[0].note(keyword)?;
        parts.iter().all(|part| part.note(keyword) == Some(text)).then(|| (keyword, text.to_owned()))
    };
    [SCENE_NOTE, TABLE_NOTE].into_iter().filter_map(common).collect()
}

/// The setting of the picture on which all parts agree. `name` is the name of its option.
fn common<T: Copy + PartialEq + Display>(
    paths: &[PathBuf],
    parts: &[ResumableImage],
    name: &str,
    of: impl Fn(Development) -> T,
) -> Result<T, Failure> {
    let first = of(parts[0].settings.development);
    match paths.iter().zip(parts).find(|(_, part)| of(part.settings.development) != first) {
        None => Ok(first),
        Some((path, part)) => Err(Failure::Input(format!(
            "the {name} is {first} in {}, but {} in {}: give --{name}",
            paths[0].display(),
            of(part.settings.development),
            path.display()
        ))),
    }
}

/// Checks that the parts belong to one picture.
fn check(paths: &[PathBuf], parts: &[ResumableImage]) -> Outcome {
    for (path, part) in paths.iter().zip(parts) {
        let names = format!("{} and {}", paths[0].display(), path.display());
        if let Some(difference) = parts[0].provenance.difference(&part.provenance) {
            return Err(Failure::Input(format!("{names} are of different pictures: {difference}")));
        }
        if (part.aovs, part.image_size) != (parts[0].aovs, parts[0].image_size) {
            let (one, other) = (parts[0].aovs, part.aovs);
            return Err(Failure::Input(format!("{names} have different AOVs: {one}, and {other}")));
        }
    }
    Ok(())
}
