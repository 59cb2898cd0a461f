//! Makes a PNG of a finished EXR.

use std::path::Path;

use snowblue_render::film::finished_file::FinishedImage;
use snowblue_render::film::image_file::write_png;
use snowblue_render::scene::film::ImageSize;
use snowblue_render::{Development, Exposure};

use super::pictures::adaptations;
use crate::options::{DevelopmentOptions, FilmMemory};
use crate::output::{Failure, PictureFile, print_notes};

/// Writes the PNG and returns a summary. What no option gives is what the file keeps, or else the default of scenes.
pub(super) fn develop(
    path: &Path,
    file: &PictureFile,
    given: DevelopmentOptions,
    memory: FilmMemory,
    quiet: bool,
) -> Result<String, Failure> {
    memory.check_bytes(file, FinishedImage::memory_bytes(path).map_err(Failure::input)?)?;
    let FinishedImage { film, settings, knows_snow, layer, comments } =
        FinishedImage::read(path).map_err(Failure::input)?;
    let own = settings.unwrap_or_default();
    let film = film.adapted(&adaptations(path, own.white, given.white)?);
    let development = Development {
        exposure: given.exposure.unwrap_or(own.development.exposure),
        tone: given.tone.unwrap_or(own.development.tone),
    };
    let mut notes = Vec::new();
    if development.exposure == Exposure::Auto && !knows_snow {
        notes.push("there is no channel `snow`: the automatic exposure is for a picture without snow");
    }
    print_notes(quiet, notes.iter().map(|note| format!("{}: {note}", path.display())));
    // The comments of another program have no keywords, which a PNG needs.
    let comments = settings.map_or("", |_| &*comments);
    let metadata: Vec<(&str, &str)> = comments.lines().filter_map(|line| line.split_once(": ")).collect();
    write_png(&film, development, &metadata, &file.path).map_err(Failure::work)?;
    let ImageSize { width, height } = film.size();
    let layer = if layer.is_empty() { String::new() } else { format!(" of the layer {}", layer.trim_end_matches('.')) };
    Ok(format!("{width} × {height} pixels{layer}, from {}", path.display()))
}
