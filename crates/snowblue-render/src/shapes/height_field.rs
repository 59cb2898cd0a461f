//! Height fields: solids between a surface given by heights on a grid and a level bottom, closed by side walls.

use std::io::Cursor;

use exr::prelude::{ReadChannels, ReadLayers, read};
use glam::{Vec2, Vec3};

use crate::error::RenderError;
use crate::files::{NamedFile, SceneFiles, check_formats};
use crate::geometry::triangle_mesh::{TriangleMesh, closed_grids};
use crate::images::png_image::PngImage;

/// Heights on a grid, row by row from the far side (greatest y) to the near side, each from left to right.
#[derive(Debug, Clone, PartialEq)]
pub struct Heights {
    columns: usize,
    values: Vec<f32>,
}

impl Heights {
    /// A grid with a number of columns.
    ///
    /// # Errors
    ///
    /// When there are fewer than two rows or columns, an incomplete row, more than 2²⁸ heights, or one that is not
    /// finite.
    pub fn new(columns: usize, values: Vec<f32>) -> Result<Self, String> {
        let rows = values.len().checked_div(columns).unwrap_or(0);
        if rows < 2 || columns < 2 || rows * columns != values.len() || values.len() > 1 << 28 {
            return Err(format!(
                "heights are a grid of {columns} × {rows}, but must be at least 2 × 2, and at most 2^28 in all"
            ));
        }
        match values.iter().find(|height| !height.is_finite()) {
            Some(height) => Err(format!("a height is {height}, but must be finite")),
            None => Ok(Self { columns, values }),
        }
    }

    /// Reads a grey PNG, where white is 1, or the first channel of an EXR.
    ///
    /// # Errors
    ///
    /// When the file cannot be read or has another extension.
    pub fn read(files: &dyn SceneFiles, name: &str) -> Result<Self, RenderError> {
        let file = NamedFile::read(files, name)?;
        check_formats(&file.path)?;
        let wrong = |reason: String| RenderError::Mesh { path: file.path.clone(), reason };
        let (columns, values) = match file.extension().as_str() {
            "png" => read_png(&file)?,
            "exr" => read_exr(&file).map_err(wrong)?,
            other => return Err(wrong(format!("the extension is \"{other}\", but must be png or exr"))),
        };
        Self::new(columns, values).map_err(wrong)
    }

    /// The solid between these heights and a level bottom, centred on the z axis: a height h lies at z = h · `size.z`.
    /// Texture coordinates run from (0, 0) at the near left to (1, 1) at the far right.
    ///
    /// # Errors
    ///
    /// When the bottom is not below the least height.
    pub fn solid(&self, size: Vec3, bottom: f32) -> Result<TriangleMesh, String> {
        let least = self.values.iter().fold(f32::INFINITY, |least, &height| least.min(height * size.z));
        if bottom >= least {
            return Err(format!("bottom is {bottom} m, but must lie below the least height of {least} m"));
        }
        let (columns, rows) = (self.columns, self.values.len() / self.columns);
        let uv = |column: usize, row: usize| {
            Vec2::new(column as f32 / (columns - 1) as f32, 1.0 - row as f32 / (rows - 1) as f32)
        };
        let mut solid = TriangleMesh::default();
        let mut add = |uv: Vec2, z: f32| {
            solid.positions.push(Vec3::new((uv.x - 0.5) * size.x, (uv.y - 0.5) * size.y, z));
            solid.uv.push(uv);
        };
        for (index, height) in self.values.iter().enumerate() {
            add(uv(index % columns, index / columns), height * size.z);
        }
        for index in 0..self.values.len() {
            add(uv(index % columns, index / columns), bottom);
        }
        // `closed_grids` faces the second grid outwards, here the bottom; seen from below, rows run from far to near.
        solid.indices = closed_grids(count(columns), count(rows));
        Ok(solid)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a grid has at most 2^28 points")]
fn count(count: usize) -> u32 {
    count as u32
}

fn read_png(file: &NamedFile) -> Result<(usize, Vec<f32>), RenderError> {
    let image = PngImage::decode(file)?;
    if image.channels > 1 {
        let reason = "the image is coloured, but must be grey".into();
        return Err(RenderError::Mesh { path: file.path.clone(), reason });
    }
    Ok((image.width, image.values))
}

fn read_exr(file: &NamedFile) -> Result<(usize, Vec<f32>), String> {
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image =
        image.from_buffered(Cursor::new(&file.bytes)).map_err(|error| format!("not a readable EXR file: {error}"))?;
    let layer = image.layer_data;
    let channel = layer.channel_data.list.first().ok_or("the image has no channel")?;
    Ok((layer.size.width(), channel.sample_data.values_as_f32().collect()))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::files::FilesIn;
    use crate::mesh_tools::topology::{Topology, volume};

    fn read(path: &Path) -> Result<Heights, RenderError> {
        Heights::read(&FilesIn::beside(path), path.file_name().unwrap().to_str().unwrap())
    }

    #[test]
    fn the_solid_is_closed_and_its_volume_is_area_times_mean_height() {
        let (columns, rows) = (7, 5);
        let slope = |k: usize| 1.0 + (k % columns) as f32 / 6.0 + (k / columns) as f32 / 4.0;
        let heights = Heights::new(columns, (0..columns * rows).map(slope).collect()).unwrap();
        let solid = heights.solid(Vec3::new(3.0, 2.0, 0.1), -0.2).unwrap();
        let topology = Topology::of(&solid);
        assert!(topology.is_closed() && topology.reversed_edges == 0 && topology.merged_vertices == 0, "{topology:?}");
        // Heights rise evenly from 0.1 to 0.3 m, with a mean of 0.2 m, above a bottom at −0.2 m.
        assert!((volume(&solid) - 3.0 * 2.0 * 0.4).abs() < 1e-6);
        // The far right corner is the highest of the first row.
        assert_eq!(solid.positions[6], Vec3::new(1.5, 1.0, 0.2));
        assert_eq!(solid.uv[6], Vec2::ONE);
    }

    #[test]
    fn rejects_a_bottom_above_the_surface_and_incomplete_grids() {
        assert!(Heights::new(2, vec![0.0; 4]).unwrap().solid(Vec3::ONE, 0.0).unwrap_err().contains("bottom is 0 m"));
        assert!(Heights::new(3, vec![0.0; 3]).is_err());
        assert!(Heights::new(2, vec![0.0, 1.0, f32::NAN, 0.0]).unwrap_err().contains("NaN"));
    }

    #[test]
    fn reads_16_bit_png() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drift.png");
        let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), 2, 2);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.write_header().unwrap().write_image_data(&[0, 0, 0xff, 0xff, 0x80, 0, 0, 1]).unwrap();
        let heights = read(&path).unwrap();
        assert_eq!(heights, Heights::new(2, vec![0.0, 1.0, 32_768.0 / 65_535.0, 1.0 / 65_535.0]).unwrap());
        std::fs::write(&path, b"no picture").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("drift.png: not a readable PNG"));
    }

    #[test]
    fn reads_the_first_channel_of_an_exr_from_far_to_near() {
        use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drift.EXR");
        let values = vec![0.25f32, -1.5, 3.0, 1e-3, 70_000.0, 0.0];
        let height = AnyChannel::new("Y", FlatSamples::F32(values.clone()));
        let other = AnyChannel::new("Z", FlatSamples::F32(vec![9.0; 6]));
        let channels = AnyChannels::sort([other, height].into_iter().collect());
        Image::from_channels((3, 2), channels).write().to_file(&path).unwrap();
        let heights = read(&path).unwrap();
        assert_eq!(heights, Heights::new(3, values).unwrap());
        // The first row is the far one, at greatest y.
        let solid = heights.solid(Vec3::new(4.0, 2.0, 0.1), -1.0).unwrap();
        assert_eq!((solid.positions[0], solid.positions[5]), (Vec3::new(-2.0, 1.0, 0.025), Vec3::new(2.0, -1.0, 0.0)));
        std::fs::write(&path, b"no picture").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("drift.EXR: not a readable EXR"));
        let hole = AnyChannel::new("Y", FlatSamples::F32(vec![0.0, 0.0, f32::NAN, 0.0]));
        Image::from_channels((2, 2), AnyChannels::sort([hole].into_iter().collect())).write().to_file(&path).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("a height is NaN, but must be finite"));
    }
}
