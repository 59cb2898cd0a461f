//! Heights as pictures: a grey PNG, where white is 1, or an EXR of one channel.

use snowblue_geometry::images::{self, DecodedImage};

use crate::height_files::height_grid::{HeightGrid, StatedByUser};

/// Reads a PNG. A height whose pixel is not opaque is missing.
pub(super) fn read_png(image: &DecodedImage, stated: &StatedByUser) -> Result<HeightGrid, String> {
    if image.channels > 1 {
        return Err("the image is coloured, but must be grey".to_owned());
    }
    let height = |(pixel, value): (usize, &f32)| if image.alpha_of(pixel) < 1.0 { f32::NAN } else { *value };
    let values = image.values.iter().enumerate().map(height).collect();
    HeightGrid::new(image.width, values, [None, stated.no_data], Ok(None))
}

/// Reads an EXR of one channel besides alpha, or of equal channels. A height whose alpha is below 1 is missing.
pub(super) fn read_exr(bytes: &[u8], stated: &StatedByUser) -> Result<HeightGrid, String> {
    // Memory for all channels as they are stored, for one channel as heights, and for alpha.
    let image = images::read_exr(bytes, |samples| samples + 2 * size_of::<f32>())?;
    let [layer] = &image.layer_data[..] else {
        return Err(
            "the file has several parts, but must have one (`oiiotool IN.exr --subimage 0 -o OUT.exr` takes the \
                    first)"
                .to_owned(),
        );
    };
    let window = image.attributes.display_window;
    if (window.position, window.size) != (layer.attributes.layer_position, layer.size) {
        return Err(
            "the image is a part of its display window (`oiiotool IN.exr --croptofull -o OUT.exr` fills it)".to_owned()
        );
    }
    let mut channels = layer.channel_data.list.iter().filter(|channel| channel.name != *"A");
    let channel = channels.next().ok_or("the image has no channel of heights")?;
    if let Some(other) = channels.find(|other| other.sample_data != channel.sample_data) {
        let (first, second) = (&channel.name, &other.name);
        return Err(format!(
            "the channels {first} and {second} differ, but heights must be in one channel (`oiiotool IN.exr --ch \
             {first} -o OUT.exr` takes {first})"
        ));
    }
    let alpha = layer.channel_data.list.iter().find(|channel| channel.name == *"A");
    let alpha: Vec<f32> = alpha.map(|alpha| alpha.sample_data.values_as_f32().collect()).unwrap_or_default();
    let is_opaque = |pixel: usize| alpha.get(pixel).is_none_or(|alpha| *alpha >= 1.0);
    let height = |(pixel, value): (usize, f32)| if is_opaque(pixel) { value } else { f32::NAN };
    let values = channel.sample_data.values_as_f32().enumerate().map(height).collect();
    HeightGrid::new(layer.size.width(), values, [None, stated.no_data], Ok(None))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use snowblue_base::files::{FileError, FilesInMemory};

    use super::*;

    fn read(name: &str, bytes: Vec<u8>) -> Result<HeightGrid, FileError> {
        HeightGrid::read(&FilesInMemory::from([(name, bytes)]), name, &StatedByUser::default())
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
    fn reads_the_channel_of_an_exr_from_far_to_near() {
        use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
        let exr = |size: (usize, usize), channels: Vec<AnyChannel<FlatSamples>>| {
            let mut bytes = Cursor::new(Vec::new());
            let channels = AnyChannels::sort(channels.into_iter().collect());
            Image::from_channels(size, channels).write().to_buffered(&mut bytes).unwrap();
            bytes.into_inner()
        };
        let values = vec![0.25f32, -1.5, 3.0, 1e-3, 70_000.0, 0.0];
        let height = AnyChannel::new("Y", FlatSamples::F32(values.clone()));
        let other = |name: &str| AnyChannel::new(name, FlatSamples::F32(vec![9.0; 6]));
        let grid = read("drift.EXR", exr((3, 2), vec![other("A"), height.clone()])).unwrap();
        assert_eq!((grid.columns, grid.values.as_slice()), (3, values.as_slice()));
        let grey = ["R", "G", "B"].map(|name| AnyChannel { name: name.into(), ..height.clone() });
        assert_eq!(read("drift.EXR", exr((3, 2), grey.to_vec())).unwrap().values, values);
        let message = read("drift.EXR", exr((3, 2), vec![other("Z"), height])).unwrap_err().to_string();
        assert!(message.contains("the channels Y and Z differ, but heights must be in one channel"), "{message}");
        let message = read("drift.EXR", b"no picture".to_vec()).unwrap_err().to_string();
        assert!(message.contains("drift.EXR: not a readable EXR"), "{message}");
        let alpha = AnyChannel::new("A", FlatSamples::F32(vec![1.0, 0.0, 0.5, 1.0, f32::NAN, 1.0]));
        let values = read("drift.EXR", exr((3, 2), vec![alpha, grey[0].clone()])).unwrap().values;
        let missing: Vec<usize> = (0..6).filter(|pixel| values[*pixel].is_nan()).collect();
        assert_eq!((missing, values[3]), (vec![1, 2, 4], 1e-3));
        let hole = AnyChannel::new("Y", FlatSamples::F32(vec![0.0, 0.0, f32::NAN, 0.0]));
        let message = read("drift.EXR", exr((2, 2), vec![hole])).unwrap().filled(None).unwrap_err();
        assert!(message.contains("1 of 4 heights are missing"), "{message}");
    }

    #[test]
    fn a_part_of_a_display_window_is_refused() {
        use exr::meta::attribute::IntegerBounds;
        use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
        let heights = AnyChannel::new("Y", FlatSamples::F32(vec![1.0; 4]));
        let mut image = Image::from_channels((2, 2), AnyChannels::sort([heights].into_iter().collect()));
        image.attributes.display_window = IntegerBounds::from_dimensions((4, 2));
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        let message = read("drift.exr", bytes.into_inner()).unwrap_err().to_string();
        assert!(message.contains("`oiiotool IN.exr --croptofull -o OUT.exr`"), "{message}");
    }

    #[test]
    fn heights_whose_pixels_are_not_opaque_are_missing() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
        encoder.set_color(png::ColorType::GrayscaleAlpha);
        encoder.write_header().unwrap().write_image_data(&[0, 255, 51, 255, 102, 0, 255, 255]).unwrap();
        let values = read("drift.png", bytes).unwrap().values;
        assert_eq!((values[0], values[1], values[3]), (0.0, 0.2, 1.0));
        assert!(values[2].is_nan());
    }
}
