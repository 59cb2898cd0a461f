//! Heights as pictures: a grey PNG, where white is 1, or the first channel of an EXR.

use std::io::Cursor;

use exr::prelude::{ReadChannels, ReadLayers, read};
use snowblue_base::files::{FileError, NamedFile};
use snowblue_geometry::images::{PngImage, check_exr_size};

use crate::height_files::height_grid::HeightGrid;

/// Reads a PNG.
pub(super) fn read_png(file: &NamedFile) -> Result<HeightGrid, FileError> {
    let image = PngImage::decode(file)?;
    if image.channels > 1 {
        let reason = "the image is coloured, but must be grey".into();
        return Err(FileError::Content { path: file.path.clone(), reason });
    }
    Ok(HeightGrid { columns: image.width, values: image.values, georeference: None, no_data: None })
}

/// Reads an EXR. A height that is not finite is an error.
pub(super) fn read_exr(bytes: &[u8]) -> Result<HeightGrid, String> {
    // Memory for all channels as they are stored, and for one channel as heights.
    check_exr_size(bytes, |samples| samples + size_of::<f32>())?;
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.from_buffered(Cursor::new(bytes)).map_err(|error| format!("not a readable EXR file: {error}"))?;
    let layer = image.layer_data;
    let channel = layer.channel_data.list.first().ok_or("the image has no channel")?;
    let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
    if let Some(height) = values.iter().find(|height| !height.is_finite()) {
        return Err(format!("a height is {height}, but must be finite"));
    }
    Ok(HeightGrid { columns: layer.size.width(), values, georeference: None, no_data: None })
}

#[cfg(test)]
mod tests {
    use snowblue_base::files::FilesInMemory;

    use super::*;

    fn read(name: &str, bytes: Vec<u8>) -> Result<HeightGrid, FileError> {
        HeightGrid::read(&FilesInMemory::from([(name, bytes)]), name)
    }

    #[test]
    fn reads_16_bit_png() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.write_header().unwrap().write_image_data(&[0, 0, 0xff, 0xff, 0x80, 0, 0, 1]).unwrap();
        let grid = read("drift.png", bytes).unwrap();
        assert_eq!((grid.columns, grid.values), (2, vec![0.0, 1.0, 32_768.0 / 65_535.0, 1.0 / 65_535.0]));
        let message = read("drift.png", b"no picture".to_vec()).unwrap_err().to_string();
        assert!(message.contains("drift.png: not a readable PNG"), "{message}");
    }

    #[test]
    fn reads_the_first_channel_of_an_exr_from_far_to_near() {
        use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
        let exr = |size: (usize, usize), channels: Vec<AnyChannel<FlatSamples>>| {
            let mut bytes = Cursor::new(Vec::new());
            let channels = AnyChannels::sort(channels.into_iter().collect());
            Image::from_channels(size, channels).write().to_buffered(&mut bytes).unwrap();
            bytes.into_inner()
        };
        let values = vec![0.25f32, -1.5, 3.0, 1e-3, 70_000.0, 0.0];
        let height = AnyChannel::new("Y", FlatSamples::F32(values.clone()));
        let other = AnyChannel::new("Z", FlatSamples::F32(vec![9.0; 6]));
        let grid = read("drift.EXR", exr((3, 2), vec![other, height])).unwrap();
        assert_eq!((grid.columns, grid.values), (3, values));
        let message = read("drift.EXR", b"no picture".to_vec()).unwrap_err().to_string();
        assert!(message.contains("drift.EXR: not a readable EXR"), "{message}");
        let hole = AnyChannel::new("Y", FlatSamples::F32(vec![0.0, 0.0, f32::NAN, 0.0]));
        let message = read("drift.EXR", exr((2, 2), vec![hole])).unwrap_err().to_string();
        assert!(message.contains("a height is NaN, but must be finite"), "{message}");
    }
}
