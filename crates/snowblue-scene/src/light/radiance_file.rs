//! Radiance pictures: a header of lines of text, then rows of pixels of three mantissas and an exponent, which may be
//! run-length encoded (Ward 1991, "Real pixels", in *Graphics Gems II*; Radiance, "File formats").

use snowblue_color::{Chromaticity, LinearRgb, Primaries};

/// The header of a picture, and the bytes of its pixels.
pub(super) struct Header<'bytes> {
    pub(super) width: usize,
    pub(super) height: usize,
    /// The primaries and the white, if the file states them.
    pub(super) primaries: Option<(Primaries, Chromaticity)>,
    /// The factors by which the channels are multiplied in the file.
    exposure: [f64; 3],
    pixels: &'bytes [u8],
}

impl<'bytes> Header<'bytes> {
    /// Reads the header.
    ///
    /// # Errors
    ///
    /// When the header is malformed, or the pixels are not red, green and blue in rows from the top and the left.
    pub(super) fn read(bytes: &'bytes [u8]) -> Result<Self, String> {
        let mut header = Self { width: 0, height: 0, primaries: None, exposure: [1.0; 3], pixels: bytes };
        while let Some(line) = header.line().filter(|line| !line.is_empty()) {
            let Some((key, value)) = line.split_once('=') else { continue };
            let numbers: Vec<f64> = value.split_whitespace().filter_map(|number| number.parse().ok()).collect();
            let wrong = || Err(format!("{key} is \"{value}\", which is not understood"));
            match (key.trim(), numbers.as_slice()) {
                ("FORMAT", _) if value.trim() == "32-bit_rle_rgbe" => {}
                ("FORMAT", _) => {
                    return Err(format!(
                        "the format is {value}, but must be 32-bit_rle_rgbe (`ra_xyze -r \
                                                     IN.hdr OUT.hdr` makes it)"
                    ));
                }
                // Each line multiplies the factors of the lines before.
                ("EXPOSURE", [factor]) if *factor > 0.0 => header.expose([*factor; 3]),
                ("COLORCORR", [r, g, b]) if r.min(*g).min(*b) > 0.0 => header.expose([*r, *g, *b]),
                ("PRIMARIES", [rx, ry, gx, gy, bx, by, wx, wy]) => {
                    let [red, green, blue, white] =
                        [(*rx, *ry), (*gx, *gy), (*bx, *by), (*wx, *wy)].map(|(x, y)| Chromaticity { x, y });
                    header.primaries = Some((Primaries { red, green, blue }, white));
                }
                ("EXPOSURE" | "COLORCORR" | "PRIMARIES", _) => return wrong(),
                _ => {}
            }
        }
        let line = header.line().unwrap_or_default();
        let size = match line.split_whitespace().collect::<Vec<_>>().as_slice() {
            ["-Y", height, "+X", width] => height.parse().ok().zip(width.parse().ok()),
            _ => None,
        };
        let size = size.filter(|(height, width)| (1..1 << 20).contains(height) && (1..1 << 20).contains(width));
        (header.height, header.width) = size.ok_or_else(|| {
            let line: String = line.chars().take(40).collect();
            format!("the size is \"{line}\", but must be \"-Y HEIGHT +X WIDTH\"")
        })?;
        Ok(header)
    }

    fn line(&mut self) -> Option<String> {
        let end = self.pixels.iter().position(|byte| *byte == b'\n')?;
        let line = String::from_utf8_lossy(&self.pixels[..end]).trim_end().to_owned();
        self.pixels = &self.pixels[end + 1..];
        Some(line)
    }

    fn expose(&mut self, factors: [f64; 3]) {
        self.exposure.iter_mut().zip(factors).for_each(|(exposure, factor)| *exposure *= factor);
    }

    /// The pixels, row by row.
    ///
    /// # Errors
    ///
    /// When the file ends early, or a run ends beyond its row.
    pub(super) fn pixels(&self) -> Result<Vec<LinearRgb>, String> {
        let (mut rest, [r, g, b]) = (self.pixels, self.exposure);
        let mut pixels = Vec::with_capacity(self.width * self.height);
        let mut row = vec![[0; 4]; self.width];
        for number in 0..self.height {
            read_row(&mut rest, &mut row).ok_or_else(|| format!("row {number} of {} is malformed", self.height))?;
            pixels.extend(row.iter().map(|[red, green, blue, exponent]| {
                // A mantissa is a part of 256, and the exponent is relative to 128.
                let unit = if *exponent == 0 { 0.0 } else { 2.0_f64.powi(i32::from(*exponent) - 128 - 8) };
                let channel = |mantissa: u8, factor: f64| unit * f64::from(mantissa) / factor;
                LinearRgb { r: channel(*red, r), g: channel(*green, g), b: channel(*blue, b) }
            }));
        }
        Ok(pixels)
    }
}

/// Reads a row of pixels; none if it is malformed.
fn read_row(rest: &mut &[u8], row: &mut [[u8; 4]]) -> Option<()> {
    let width = row.len();
    let [first, second, high, low] = *rest.first_chunk()?;
    if (first, second) != (2, 2) || usize::from(u16::from_be_bytes([high, low])) != width || width < 8 {
        return read_old_row(rest, row);
    }
    take(rest, 4)?;
    for channel in 0..4 {
        let mut column = 0;
        while column < width {
            // A count above 128 is of one repeated value, else of single values.
            let count = usize::from(take(rest, 1)?[0]);
            let (count, step) = if count > 128 { (count - 128, 0) } else { (count, 1) };
            let values = take(rest, if step == 0 { 1 } else { count })?;
            let pixels = row.get_mut(column..column + count).filter(|pixels| !pixels.is_empty())?;
            pixels.iter_mut().enumerate().for_each(|(number, pixel)| pixel[channel] = values[step * number]);
            column += count;
        }
    }
    Some(())
}

/// Reads a row of whole pixels, in which three mantissas of 1 repeat the pixel before: the exponent is the count, and
/// of further repetitions a higher byte of the count.
fn read_old_row(rest: &mut &[u8], row: &mut [[u8; 4]]) -> Option<()> {
    let (mut column, mut shift) = (0, 0);
    while column < row.len() {
        let pixel: [u8; 4] = *take(rest, 4)?.first_chunk()?;
        if let [1, 1, 1, count] = pixel {
            let before = *row.get(column.checked_sub(1)?)?;
            let count = usize::from(count) << shift;
            row.get_mut(column..column + count)?.fill(before);
            column += count;
            shift = (shift + 8).min(24);
        } else {
            row[column] = pixel;
            column += 1;
            shift = 0;
        }
    }
    Some(())
}

fn take<'bytes>(rest: &mut &'bytes [u8], count: usize) -> Option<&'bytes [u8]> {
    let (taken, after) = rest.split_at_checked(count)?;
    *rest = after;
    Some(taken)
}
