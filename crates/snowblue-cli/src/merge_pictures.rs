//! Parts of a picture added up.

use std::path::PathBuf;

use snowblue_render::FilmAccumulator;
use snowblue_render::film::exposure::Exposure;
use snowblue_render::film::part_file::{Kept, Part};

use crate::failure::{Failure, Outcome};
use crate::picture::{Kind, PictureFile, samples_in_words};

/// Adds parts up, writes the whole, and says in a few words what it is. Without an exposure that of the parts holds.
///
/// The parts are checked before any pixel is read, and then read one after the other.
pub(crate) fn merge_pictures(
    paths: &[PathBuf],
    file: &PictureFile,
    exposure: Option<Exposure>,
) -> Result<String, Failure> {
    let parts: Vec<Part> =
        paths.iter().map(|path| Part::open(path).map_err(Failure::input)).collect::<Result<_, _>>()?;
    check(paths, &parts)?;
    let exposure = match exposure {
        Some(exposure) => exposure,
        None if file.kind == Kind::Exr && !file.keeps_sums => Exposure::Auto,
        None => common_exposure(paths, &parts)?,
    };
    let first = &parts[0];
    let window = parts.iter().fold(first.window.clone(), |window, part| window.enclosing(&part.window));
    let mut sums = FilmAccumulator::empty(first.size, first.channels, first.wavelengths_nm, &window);
    for (path, part) in paths.iter().zip(&parts) {
        sums.add(&part.read(path).map_err(Failure::input)?);
    }
    if let Some((x, y)) = sums.first_empty_pixel() {
        return Err(Failure::Input(format!("no part has a sample of pixel {x},{y}: the tiles leave gaps")));
    }
    let (columns, rows) = (window.width(), window.height());
    let place = if (columns, rows) == first.size {
        String::new()
    } else {
        format!(" of {} × {}, from {},{}", first.size.0, first.size.1, window.columns.start, window.rows.start)
    };
    let count = [("Parts", paths.len().to_string())];
    file.write(&sums, Kept { origin: &first.origin, exposure }, &count)?;
    let (samples, count) = (samples_in_words(&sums), paths.len());
    let parts = if count == 1 { "part" } else { "parts" };
    Ok(format!("{columns} × {rows} pixels{place}, {samples} samples per pixel, from {count} {parts}"))
}

/// The exposure that all parts were made for.
fn common_exposure(paths: &[PathBuf], parts: &[Part]) -> Result<Exposure, Failure> {
    let exposure = parts[0].exposure;
    match paths.iter().zip(parts).find(|(_, part)| part.exposure != exposure) {
        None => Ok(exposure),
        Some((path, part)) => Err(Failure::Input(format!(
            "{} is for an exposure of {exposure}, {} for one of {}: give --exposure",
            paths[0].display(),
            path.display(),
            part.exposure
        ))),
    }
}

/// Whether the parts are of one picture, and have no sample twice.
fn check(paths: &[PathBuf], parts: &[Part]) -> Outcome {
    for (number, (path, part)) in paths.iter().zip(parts).enumerate() {
        let names = |other: usize| format!("{} and {}", paths[other].display(), path.display());
        if let Some(difference) = parts[0].origin.difference(&part.origin) {
            return Err(Failure::Input(format!("{} are not of one picture: {difference}", names(0))));
        }
        if (part.channels, part.size) != (parts[0].channels, parts[0].size) {
            let (one, other) = (parts[0].channels, part.channels);
            return Err(Failure::Input(format!("{} tell different things: {one}, and {other}", names(0))));
        }
        for (other, before) in parts[..number].iter().enumerate() {
            if let Some(twice) = before.coverage.overlap(&part.coverage) {
                let (x, y, sample) = (twice.columns.start, twice.rows.start, twice.samples.start);
                return Err(Failure::Input(format!("{} both have sample {sample} of pixel {x},{y}", names(other))));
            }
        }
    }
    Ok(())
}
