//! What a frame of a film says of itself, so that a film can be resumed without building the scenes of the frames that
//! are there.
//!
//! The record is a text of the picture, as JSON: in a PNG an `iTXt` chunk, in an EXR a line of the comments.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use exr::meta::MetaData;
use png::Decoder;
use serde::{Deserialize, Serialize};

use crate::film::aov::Aovs;
use crate::film::exposure::Exposure;
use crate::film::image_file::{note_of, of_exr_text};
use crate::film::provenance::Provenance;
use crate::film::sample_block::Coverage;

/// What a frame holds.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameRecord {
    /// The inputs that its samples depend on.
    pub provenance: Provenance,
    /// The samples of all its pixels.
    pub coverage: Coverage,
    /// Its exposure as PNG.
    pub exposure: Exposure,
    /// The values that are means beside colours.
    pub aovs: Aovs,
}

/// The record as texts.
#[derive(Serialize, Deserialize)]
struct Texts {
    provenance: String,
    samples: String,
    exposure: String,
    aovs: String,
}

impl FrameRecord {
    /// The keyword of the text.
    pub const KEYWORD: &'static str = "Frame";

    /// The text, one line.
    ///
    /// # Panics
    ///
    /// Never: texts have a notation in JSON.
    pub fn to_text(&self) -> String {
        let Self { provenance, coverage, exposure, aovs } = self;
        let texts = Texts {
            provenance: provenance.to_string(),
            samples: coverage.to_string(),
            exposure: exposure.to_string(),
            aovs: aovs.to_string(),
        };
        serde_json::to_string(&texts).expect("texts have a notation in JSON")
    }

    /// The record of a PNG or EXR file; none if it is no such file or has none.
    pub fn read(path: &Path) -> Option<Self> {
        let text = png_text(path).or_else(|| exr_text(path))?;
        let Texts { provenance, samples, exposure, aovs } = serde_json::from_str(&text).ok()?;
        Some(Self {
            provenance: Provenance::parse(&provenance),
            coverage: samples.parse().ok()?,
            exposure: exposure.parse().ok()?,
            aovs: aovs.parse().ok()?,
        })
    }
}

fn png_text(path: &Path) -> Option<String> {
    let reader = Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
    let chunk = reader.info().utf8_text.iter().find(|chunk| chunk.keyword == FrameRecord::KEYWORD)?;
    chunk.get_text().ok()
}

fn exr_text(path: &Path) -> Option<String> {
    let meta = MetaData::read_from_file(path, false).ok()?;
    let comments = of_exr_text(meta.headers.first()?.own_attributes.comments.as_ref()?);
    note_of(&comments, FrameRecord::KEYWORD).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use snowblue_color::Xyz;

    use super::*;
    use crate::film::Film;
    use crate::film::image_file::{write_exr, write_png};
    use crate::images::raster::ImageSize;

    #[test]
    fn a_record_is_read_from_both_kinds_of_files() {
        let record = FrameRecord {
            provenance: Provenance::parse("version: 1\nfiles: [\"é: a.png\"]"),
            coverage: "0:2,0:1,0:5".parse().unwrap_or_default(),
            exposure: Exposure::Stops(-1.25),
            aovs: Aovs { normal: true, ..Aovs::default() },
        };
        let film = Film::new(ImageSize { width: 2, height: 1 }, vec![Xyz::default(); 2]);
        let folder = tempfile::tempdir().unwrap();
        let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
        let text = record.to_text();
        let texts = [("Scene", "one: two"), (FrameRecord::KEYWORD, &*text), ("Seed", "1")];
        write_png(&film, Exposure::Auto, &texts, &png).unwrap();
        write_exr(&film, &texts, &exr).unwrap();
        for path in [&png, &exr] {
            assert_eq!(FrameRecord::read(path).unwrap(), record);
        }
        write_png(&film, Exposure::Auto, &[], &png).unwrap();
        write_exr(&film, &[], &exr).unwrap();
        std::fs::write(folder.path().join("a.txt"), "text").unwrap();
        for name in ["a.png", "a.exr", "a.txt", "missing.png"] {
            assert_eq!(FrameRecord::read(&folder.path().join(name)), None, "{name}");
        }
    }
}
