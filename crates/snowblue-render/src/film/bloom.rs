//! Bloom: the light that a lens or an eye scatters around what is bright.
//!
//! A fraction of the light of each pixel is spread by a point spread function of integral 1. Its wings are those of the
//! glare of the eye by day, 0.478 θ⁻³ and 0.138 θ⁻² (G. Spencer, P. Shirley, K. Zimmerman & D. P. Greenberg 1995,
//! *Physically-based glare effects for digital images*, SIGGRAPH, 325–334, doi:10.1145/218380.218466), as a sum of
//! three Gaussians of deviations of 1/256, 1/64 and 1/16 of the height of the picture: a factor of 4 apart, Gaussians
//! of weights as σ⁻¹ have wings of θ⁻³, and those of equal weights wings of θ⁻². Borders are mirrors, so that no light
//! is lost. A Gaussian is three box filters.

use rayon::prelude::*;
use snowblue_color::Xyz;
use snowblue_scene::film::ImageSize;

/// Deviation of each Gaussian as a fraction of the height, and its weight.
const GLARE: [(f64, f64); 3] = [(1.0 / 256.0, 0.666), (1.0 / 64.0, 0.222), (1.0 / 16.0, 0.112)];
/// Box filters of a Gaussian.
const BOXES: usize = 3;

/// The image with a fraction of its light spread. The size comes with the rows of the whole image, of which it may be a
/// part.
pub(crate) fn spread(pixels: &[Xyz], size: (ImageSize, u32), fraction: f64) -> Vec<Xyz> {
    let glare = |value: fn(&Xyz) -> f64| glare(&pixels.iter().map(value).collect::<Vec<_>>(), size);
    let [x, y, z] = [glare(|xyz| xyz.x), glare(|xyz| xyz.y), glare(|xyz| xyz.z)];
    let spread = |(index, pixel): (usize, &Xyz)| {
        *pixel * (1.0 - fraction) + Xyz { x: x[index], y: y[index], z: z[index] } * fraction
    };
    pixels.iter().enumerate().map(spread).collect()
}

/// A plane of rows under the point spread function.
fn glare(plane: &[f64], (size, image_height): (ImageSize, u32)) -> Vec<f64> {
    let (width, height) = (size.width as usize, size.height as usize);
    let mut sum = vec![0.0; plane.len()];
    for (deviation, weight) in GLARE {
        let radius = box_radius(deviation * f64::from(image_height));
        let rows = blurred(plane.to_vec(), width, radius);
        let columns = blurred(transposed(&rows, width), height, radius);
        sum.iter_mut().zip(transposed(&columns, height)).for_each(|(sum, value)| *sum += weight * value);
    }
    sum
}

/// The radius of [`BOXES`] boxes of 2r + 1 pixels, whose variance is r (r + 1), with the deviation of a Gaussian in
/// pixels.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive, and less than a picture")]
fn box_radius(deviation: f64) -> usize {
    (0.5 * ((1.0 + 4.0 * deviation * deviation).sqrt() - 1.0)).round() as usize
}

/// Lines of some length, each filtered by boxes.
fn blurred(mut plane: Vec<f64>, length: usize, radius: usize) -> Vec<f64> {
    plane.par_chunks_exact_mut(length).for_each(|line| {
        for _ in 0..BOXES {
            let before = line.to_vec();
            // The line continues as in mirrors at its ends.
            let at = |place: usize| {
                let place = place % (2 * length);
                before[if place < length { place } else { 2 * length - 1 - place }]
            };
            // Places are counted from a whole number of mirror images before the line.
            let start = (radius / (2 * length) + 1) * 2 * length;
            let scale = ((2 * radius + 1) as f64).recip();
            let mut sum: f64 = (start - radius..=start + radius).map(at).sum();
            for (place, value) in line.iter_mut().enumerate() {
                *value = sum * scale;
                sum += at(start + place + radius + 1) - at(start + place - radius);
            }
        }
    });
    plane
}

/// A plane of rows of some length, as columns.
fn transposed(plane: &[f64], length: usize) -> Vec<f64> {
    let mut columns = Vec::with_capacity(plane.len());
    columns.extend((0..length).flat_map(|column| plane.iter().skip(column).step_by(length).copied()));
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: ImageSize = ImageSize { width: 90, height: 64 };

    fn grey(level: f64) -> Xyz {
        Xyz { x: 0.9 * level, y: level, z: 1.1 * level }
    }

    fn sum(pixels: &[Xyz]) -> [f64; 3] {
        [pixels.iter().map(|p| p.x).sum(), pixels.iter().map(|p| p.y).sum(), pixels.iter().map(|p| p.z).sum()]
    }

    #[test]
    fn the_weights_keep_all_light() {
        assert!((GLARE.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
        // A lamp in the middle, at a border and in a corner of a dark picture.
        for place in [32 * 90 + 45, 10, 64 * 90 - 1] {
            let mut pixels = vec![grey(0.1); 64 * 90];
            pixels[place] = grey(1e6);
            for fraction in [0.0, 0.1, 1.0] {
                let after = spread(&pixels, (SIZE, 64), fraction);
                for (after, before) in sum(&after).into_iter().zip(sum(&pixels)) {
                    assert!((after / before - 1.0).abs() < 1e-12, "{after} {before}");
                }
                // Each difference of running sums is rounded at 1e6 · 2⁻⁵³.
                assert!(after.iter().all(|pixel| pixel.y > 0.1 - 1e-7), "no light is negative");
            }
        }
    }

    #[test]
    fn an_even_picture_and_no_bloom_change_nothing() {
        let even = vec![grey(0.7); 64 * 90];
        assert!(spread(&even, (SIZE, 64), 0.5).iter().all(|pixel| (pixel.y - 0.7).abs() < 1e-12));
        let ramp: Vec<Xyz> = (0..64 * 90).map(|k| grey(f64::from(k))).collect();
        assert_eq!(spread(&ramp, (SIZE, 64), 0.0), ramp);
        // Wider than the picture.
        let narrow = ImageSize { width: 1, height: 640 };
        assert!(spread(&vec![grey(2.0); 640], (narrow, 640), 1.0).iter().all(|pixel| (pixel.y - 2.0).abs() < 1e-12));
    }

    /// A lamp in a crop of a picture is spread as in the whole picture.
    #[test]
    fn a_part_of_a_picture_has_the_deviations_of_the_whole() {
        let lamp = |side: usize| {
            let mut pixels = vec![Xyz::default(); side * side];
            pixels[side / 2 * side + side / 2] = grey(1.0);
            pixels
        };
        let size = |side| ImageSize { width: side, height: side };
        let whole = spread(&lamp(256), (size(256), 256), 1.0);
        let part = spread(&lamp(128), (size(128), 256), 1.0);
        let (whole, part) = (whole[128 * 256 + 128].y, part[64 * 128 + 64].y);
        // The mirrors of the part are four deviations away.
        assert!((part / whole - 1.0).abs() < 1e-3, "{part} {whole}");
    }

    /// The variance of the spread light is the weighted sum of those of the Gaussians, and it falls from the middle.
    #[test]
    fn light_is_spread_as_by_the_three_gaussians() {
        let size = ImageSize { width: 512, height: 512 };
        let mut pixels = vec![Xyz::default(); 512 * 512];
        pixels[256 * 512 + 256] = grey(1.0);
        let after = spread(&pixels, (size, 512), 1.0);
        let variance: f64 =
            after.iter().enumerate().map(|(k, pixel)| pixel.y * ((k % 512) as f64 - 256.0).powi(2)).sum();
        let of_boxes = |deviation: f64| {
            let radius = box_radius(deviation) as f64;
            radius * (radius + 1.0)
        };
        let expected: f64 = GLARE.iter().map(|(deviation, weight)| weight * of_boxes(deviation * 512.0)).sum();
        assert!((variance / expected - 1.0).abs() < 1e-9, "{variance} {expected}");
        // The radii of the boxes are whole numbers, off by half a pixel at most.
        for deviation in [2.0, 8.0, 32.0, 100.0_f64] {
            assert!((of_boxes(deviation).sqrt() - deviation).abs() < 0.51, "{deviation}");
        }
        let row: Vec<f64> = after[256 * 512 + 256..257 * 512].iter().map(|pixel| pixel.y).collect();
        assert!(row.windows(2).all(|pair| pair[1] <= pair[0] + 1e-15));
    }
}
