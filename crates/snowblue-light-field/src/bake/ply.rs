//! PLY files (Turk 1994, "The PLY polygon file format"), binary: all objects as one mesh in scene axes, z up.

use std::io::{BufWriter, Write};
use std::path::Path;

use snowblue_base::atomic_file::write_atomically;
use snowblue_base::files::FileError;

use crate::bake::metadata::{attributes, of_file, of_snow};
use crate::bake::{BakedObject, BakedScene, Channels};
use snowblue_scene::provenance::Provenance;
use snowblue_scene::spectrum::wavelengths_nm;

/// Writes a baked scene as PLY, completely or not at all: vertex properties `x y z nx ny nz`, then of each lamp
/// `lamp_0_r lamp_0_g lamp_0_b` or the wavelengths `lamp_0_400nm`, and last the same of `sky`.
///
/// # Errors
///
/// When the file cannot be written.
pub fn write_ply(baked: &BakedScene, provenance: &Provenance, path: &Path) -> Result<(), FileError> {
    let written = write_atomically(path, |file| {
        let mut writer = BufWriter::new(file);
        write(baked, provenance, &mut writer)?;
        writer.flush()
    });
    written.map_err(|source| FileError::Write { path: path.into(), source })
}

fn write(baked: &BakedScene, provenance: &Provenance, writer: &mut impl Write) -> std::io::Result<()> {
    writer.write_all(header(baked, provenance).as_bytes())?;
    for object in &baked.objects {
        for vertex in 0..object.positions.len() {
            let place = object.positions[vertex].to_array().into_iter().chain(object.normals[vertex].to_array());
            let count = baked.channels.count();
            let flux = object.flux.iter().flat_map(|values| &values[vertex * count..(vertex + 1) * count]);
            for number in place.chain(flux.copied()) {
                writer.write_all(&number.to_le_bytes())?;
            }
        }
    }
    let mut first = 0;
    for object in &baked.objects {
        for triangle in &object.triangles {
            writer.write_all(&[3])?;
            for vertex in triangle {
                writer.write_all(&(first + vertex).to_le_bytes())?;
            }
        }
        first += u32::try_from(object.positions.len()).unwrap_or(u32::MAX);
    }
    Ok(())
}

fn header(baked: &BakedScene, provenance: &Provenance) -> String {
    let mut lines = vec!["ply".to_owned(), "format binary_little_endian 1.0".to_owned()];
    let names = attributes(baked, |lamp| format!("lamp_{lamp}"), "sky");
    for (name, value) in of_file(baked, provenance) {
        lines.push(format!("comment {name}: {value}"));
    }
    lines.extend(names.iter().map(|(name, kind)| format!("comment {name}: {kind}")));
    let mut first = 0;
    for object in &baked.objects {
        let after = first + object.positions.len();
        lines.push(format!("comment object {}: vertices {first} to {}", one_line(&object.name), after - 1));
        first = after;
    }
    let mut snow: Vec<String> = Vec::new();
    for object in &baked.objects {
        for (name, value) in of_snow(object, &names) {
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            let line = format!("comment {name} of {}: {value}", one_line(&object.name));
            if !snow.contains(&line) {
                snow.push(line);
            }
        }
    }
    lines.extend(snow);
    let count = |count: fn(&BakedObject) -> usize| baked.objects.iter().map(count).sum::<usize>();
    lines.push(format!("element vertex {}", count(|object| object.positions.len())));
    lines.extend(["x", "y", "z", "nx", "ny", "nz"].map(|name| format!("property float {name}")));
    let channels: Vec<String> = match baked.channels {
        Channels::Rgb => ["r", "g", "b"].map(str::to_owned).into(),
        Channels::Spectrum => wavelengths_nm().iter().map(|nm| format!("{nm}nm")).collect(),
    };
    for (name, _) in &names {
        lines.extend(channels.iter().map(|channel| format!("property float {name}_{channel}")));
    }
    lines.push(format!("element face {}", count(|object| object.triangles.len())));
    lines.push("property list uchar uint vertex_indices".to_owned());
    lines.push("end_header\n".to_owned());
    lines.join("\n")
}

/// A name without line breaks.
fn one_line(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}
