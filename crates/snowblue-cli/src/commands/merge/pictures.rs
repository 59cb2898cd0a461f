//! Merges parts of a picture.

use std::path::PathBuf;

use crate::output::{Failure, Outcome, PictureFile, PictureFormat, describe_samples};
use snowblue_render::FilmAccumulator;
use snowblue_render::film::exposure::Exposure;
use snowblue_render::film::part_file::{Kept, Part};

/// Merges parts, writes the picture and returns a summary. Without an exposure, that of the parts is used.
///
/// All headers are checked before the first pixel is read.
pub(super) fn merge_pictures(
    paths: &[PathBuf],
    file: &PictureFile,
    exposure: Option<Exposure>,
) -> Result<String, Failure> {
    let parts: Vec<Part> =
        paths.iter().map(|path| Part::open(path).map_err(Failure::input)).collect::<Result<_, _>>()?;
    check(paths, &parts)?;
    let exposure = match exposure {
        Some(exposure) => exposure,
        None if file.format == PictureFormat::Exr && !file.keeps_sums => Exposure::Auto,
        None => common_exposure(paths, &parts)?,
    };
    let first = &parts[0];
    let window = parts.iter().fold(first.window.clone(), |window, part| window.enclosing(&part.window));
    let mut sums = FilmAccumulator::empty(first.size, first.channels, first.wavelengths_nm, &window);
    for (path, part) in paths.iter().zip(&parts) {
        sums.add(&part.read(path).map_err(Failure::input)?);
    }
    if let Some((x, y)) = sums.first_empty_pixel() {
        return Err(Failure::Input(format!("no part has a sample of pixel {x},{y}: the tiles leave a gap")));
    }
    let (columns, rows) = (window.width(), window.height());
    let place = if (columns, rows) == first.size {
        String::new()
    } else {
        format!(" of {} × {}, from {},{}", first.size.0, first.size.1, window.columns.start, window.rows.start)
    };
    let count = [("Parts", paths.len().to_string())];
    file.write(&sums, Kept { origin: &first.origin, exposure }, &count)?;
    let (samples, count) = (describe_samples(&sums), paths.len());
    let parts = if count == 1 { "part" } else { "parts" };
    Ok(format!("{columns} × {rows} pixels{place}, {samples} samples per pixel, from {count} {parts}"))
}

/// The exposure of all parts.
fn common_exposure(paths: &[PathBuf], parts: &[Part]) -> Result<Exposure, Failure> {
    let exposure = parts[0].exposure;
    match paths.iter().zip(parts).find(|(_, part)| part.exposure != exposure) {
        None => Ok(exposure),
        Some((path, part)) => Err(Failure::Input(format!(
            "the exposure is {exposure} in {}, but {} in {}: give --exposure",
            paths[0].display(),
            part.exposure,
            path.display()
        ))),
    }
}

/// Checks that the parts belong to one picture and have no common sample.
fn check(paths: &[PathBuf], parts: &[Part]) -> Outcome {
    for (number, (path, part)) in paths.iter().zip(parts).enumerate() {
        let names = |other: usize| format!("{} and {}", paths[other].display(), path.display());
        if let Some(difference) = parts[0].origin.difference(&part.origin) {
            return Err(Failure::Input(format!("{} are of different pictures: {difference}", names(0))));
        }
        if (part.channels, part.size) != (parts[0].channels, parts[0].size) {
            let (one, other) = (parts[0].channels, part.channels);
            return Err(Failure::Input(format!("{} have different channels: {one}, and {other}", names(0))));
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
