use glam::Vec3A;
use snowblue_color::Xyz;
use snowblue_scene::film::ImageSize;
use snowblue_scene::film::sensor::SensorSample;
use snowblue_transport::rng::Stream;

use super::*;
use crate::film::pixel_accumulator::PixelAccumulator;
use crate::film::window::SampleBlock;
use crate::integrators::FilteredSample;

const SIZE: ImageSize = ImageSize { width: 24, height: 16 };

/// An image whose snow has a baseline of 2 and a residual that a function of the column and a random number gives.
/// The normal turns at column 12, and the last four columns show no snow but a radiance of 1.
fn film(samples: u32, residual: impl Fn(u32, f32) -> f32 + Sync) -> FilmAccumulator {
    film_of(samples, |column, number| [residual(column, number); 3])
}

/// An image as of [`film`], with a residual of three values.
fn film_of(samples: u32, residual: impl Fn(u32, f32) -> [f32; 3] + Sync) -> FilmAccumulator {
    film_of_surfaces(samples, |_| (2.0, true), residual)
}

/// An image as of [`film_of`], with the baseline of each column, of snow or of other surfaces.
fn film_of_surfaces(
    samples: u32,
    surface: impl Fn(u32) -> (f32, bool) + Sync,
    residual: impl Fn(u32, f32) -> [f32; 3] + Sync,
) -> FilmAccumulator {
    let aovs = Aovs { residual: true, ..Aovs::default() };
    let block = SampleBlock { columns: 0..SIZE.width, rows: 0..SIZE.height, samples: 0..samples };
    let mut film = FilmAccumulator::new(SIZE, &block.window(), aovs);
    let colour = |[x, y, z]: [f32; 3]| SensorSample::from_array([x, y, z, x.abs() + y.abs() + z.abs()]);
    let grey = |value: f32| colour([value; 3]);
    film.par_rows_mut(&block).for_each(|row| {
        let mut pixel = PixelAccumulator::new(aovs);
        for (column, sums) in (0..SIZE.width).zip(row.sums.chunks_exact_mut(aovs.sum_count())) {
            let mut stream = Stream::new(row.number.into(), column.into());
            for _ in 0..samples {
                let residual = residual(column, narrow(stream.uniform()));
                let (baseline, is_snow) = surface(column);
                let normal = if column < 12 { Vec3A::Z } else { Vec3A::X };
                let filtered = (column < 20).then_some(FilteredSample {
                    residual: colour(residual),
                    baseline: grey(baseline),
                    is_snow,
                    normal,
                    distance_m: 1.0,
                });
                let of_surface = colour(residual.map(|residual| baseline + residual));
                pixel.add_sample(if column < 20 { of_surface } else { grey(1.0) }, filtered.as_ref());
            }
            pixel.flush(sums);
            row.counts[column as usize] = samples;
        }
    });
    film
}

/// Luminances of a row.
fn row(film: &FilmAccumulator, row: usize) -> Vec<f64> {
    let width = SIZE.width as usize;
    film.film().pixels()[row * width..][..width].iter().map(|pixel| pixel.y).collect()
}

#[test]
fn noise_is_averaged_over_like_snow_and_not_over_an_edge() {
    let mean = |column: u32| if column < 12 { 0.2 } else { -0.4 };
    let film = film(16, |column, number| mean(column) + 2.0 * (number - 0.5));
    let light = row(&film, 8);
    let expected = |column: u32| if column < 20 { f64::from(2.0 + mean(column)) } else { 1.0 };
    let errors: Vec<f64> = (0..SIZE.width).zip(&light).map(|(column, light)| light - expected(column)).collect();
    let square = errors[..20].iter().map(|error| error * error).sum::<f64>() / 20.0;
    // The standard error of a pixel is 2/√12/√16 = .14.
    assert!(square.sqrt() < 0.05, "{light:?}");
    assert!(errors[20..].iter().all(|error| error.abs() < 1e-12), "pixels without snow do not change");
}

/// One sample in three hundred is far less than the others: its pixel would be black.
#[test]
fn outliers_are_spread_and_their_light_stays() {
    let film = film(4, |_, number| if number < 0.003 { -60.0 } else { number - 0.5 });
    let raw: Vec<f64> = film.all_pixels().iter().map(|pixel| pixel.mean_xyz().y).collect();
    let filtered: Vec<f64> = film.film().pixels().iter().map(|pixel| pixel.y).collect();
    let [before, after] = [&raw, &filtered].map(|picture| picture.iter().copied().fold(f64::INFINITY, f64::min));
    assert!(before < 0.0, "{before}");
    assert!(after > 0.5, "{after}");
    let [before, after] = [&raw, &filtered].map(|picture| picture.iter().sum::<f64>());
    // Samples other than outliers have a mean of 2 at 320 pixels of snow, and of 1 at 64 others.
    let without_outliers = 2.0 * 320.0 + 64.0;
    assert!((after - before).abs() < 0.2 * (without_outliers - before), "{after} {before}");
}

/// One sample in five thousand is large where the other samples have so little noise that no pixel is filtered.
#[test]
fn a_large_sample_among_quiet_pixels_is_spread() {
    let film = film(64, |_, number| if number < 2e-4 { -64.0 } else { 0.1 * (number - 0.5) });
    let (light, mean) = light_of_snow(&film);
    let greatest = light.iter().map(|light| (light / mean - 1.0).abs()).fold(0.0, f64::max);
    // The greatest deviation is 0.5 if nothing is spread.
    assert!(greatest < 0.05, "{greatest}");
    let raw = film.all_pixels().iter().map(|pixel| pixel.mean_xyz().y).sum::<f64>();
    let filtered = film.film().pixels().iter().map(|pixel| pixel.y).sum::<f64>();
    // The neighbours of a large sample are filtered, which keeps the light on average. Without the large samples the
    // light is 0.6 % more.
    assert!((filtered / raw - 1.0).abs() < 0.004, "{filtered} {raw}");
}

/// The pixels around an outlier cannot take all of its excess, and none of them becomes black.
#[test]
fn large_outliers_make_no_other_pixel_dark() {
    let film = film(4, |column, number| if column < 4 && number < 0.01 { -2000.0 } else { 0.0 });
    let raw: Vec<f64> = film.all_pixels().iter().map(|pixel| pixel.mean_xyz().y).collect();
    let filtered: Vec<f64> = film.film().pixels().iter().map(|pixel| pixel.y).collect();
    let outliers = raw.iter().filter(|light| **light < 0.0).count();
    assert!(outliers > 0);
    let darkened: Vec<_> =
        filtered.iter().zip(&raw).filter(|(after, before)| **after < 0.0 && **before > 0.0).collect();
    assert!(darkened.is_empty(), "{darkened:?}");
}

/// Snow has half the light of its baseline. A rare walk finds far less light, but more red: its pixel would be magenta.
#[test]
fn outliers_make_no_coloured_dots() {
    let film = film_of(4, |_, number| if number < 0.003 { [30.0, -60.0, 20.0] } else { [-1.0; 3] });
    let raw: Vec<Xyz> = film.all_pixels().iter().map(PixelSums::mean_xyz).collect();
    let filtered = film.film();
    let is_snow = |index: &usize| index % (SIZE.width as usize) < 20;
    let sum = |picture: &[Xyz], of: fn(&Xyz) -> f64| -> f64 {
        picture.iter().enumerate().filter(|(index, _)| is_snow(index)).map(|(_, xyz)| of(xyz)).sum()
    };
    assert!(raw.iter().any(|xyz| xyz.y < 0.0 && xyz.x > 5.0));
    let mean_redness = sum(&raw, |xyz| xyz.x) / sum(&raw, |xyz| xyz.y);
    for xyz in filtered.pixels().iter().enumerate().filter(|(index, _)| is_snow(index)).map(|(_, xyz)| xyz) {
        assert!(xyz.y > 0.0 && xyz.x / xyz.y < 2.0 * mean_redness, "{xyz:?} {mean_redness}");
    }
}

#[test]
fn residuals_without_noise_stay_as_they_are() {
    let film = film(4, |column, _| 0.1 * (column % 3) as f32);
    for (column, luminance) in (0..20u32).zip(row(&film, 3)) {
        assert!((luminance - 2.0 - 0.1 * f64::from(column % 3)).abs() < 1e-6, "{luminance}");
    }
}

#[test]
fn the_filter_states_the_noise_that_is_left() {
    let film = film(16, |_, number| 2.0 * (number - 0.5));
    let noise = Filtered::new(&film).unwrap().noise().to_vec();
    let errors = film.film();
    let pixels = || errors.pixels().iter().zip(&noise).enumerate().filter(|(k, _)| k % 24 < 20);
    let [square, stated] = pixels().fold([0.0, 0.0], |[square, stated], (_, (pixel, noise))| {
        [square + (pixel.y / 2.0 - 1.0).powi(2), stated + f64::from(*noise).powi(2)]
    });
    // Neighbouring pixels share most of their samples: 320 pixels are some 20 independent values, and the borders
    // have fewer neighbours.
    let ratio = (square / stated).sqrt();
    assert!((0.5..1.7).contains(&ratio), "{ratio}");
    assert!(noise.iter().enumerate().all(|(k, noise)| k % 24 < 20 || *noise == 0.0), "constant pixels have none");
}

#[test]
fn one_sample_and_pixels_without_samples_give_finite_colours() {
    let one = film(1, |_, number| number - 0.5);
    assert!(row(&one, 5).iter().all(|luminance| luminance.is_finite() && *luminance > 0.0));
    let block = SampleBlock { columns: 0..SIZE.width, rows: 0..4, samples: 0..1 };
    let mut some = one.clone();
    some.par_rows_mut(&block).for_each(|row| {
        row.sums.fill(0);
        row.counts.fill(0);
    });
    assert!(row(&some, 2).iter().all(|luminance| *luminance == 0.0), "no samples are black");
    assert!(row(&some, 10).iter().all(|luminance| luminance.is_finite()));
}

/// The mean of each column.
fn columns(film: &FilmAccumulator) -> Vec<f64> {
    let (width, pixels) = (SIZE.width as usize, film.film());
    let mean = |column: usize| {
        let of_column = pixels.pixels().iter().skip(column).step_by(width);
        of_column.map(|pixel| pixel.y).sum::<f64>() / f64::from(SIZE.height)
    };
    (0..width).map(mean).collect()
}

/// Features that only the residual shows remain: a contact shadow on a floor, the light of an edge of snow.
#[test]
fn edges_that_the_baseline_does_not_know_stay() {
    let residual = |column: u32, number: f32| [if column < 6 { -1.0 } else { 0.0 } + 2.0 * (number - 0.5); 3];
    for is_snow in [false, true] {
        let means = columns(&film_of_surfaces(16, |_| (2.0, is_snow), residual));
        for (column, light) in [(3, 1.0), (8, 2.0)] {
            // The mean of a column has a standard error of 2/√12/√256 = .036 before the filter.
            let error = (means[column] - light).abs();
            assert!(error < 0.15, "snow {is_snow}, column {column}: {error}");
        }
    }
}

/// The luminance of each pixel of snow, and their mean.
fn light_of_snow(film: &FilmAccumulator) -> (Vec<f64>, f64) {
    let film = film.film();
    let luminances = film.pixels().iter().map(|pixel| pixel.y);
    let light: Vec<f64> =
        luminances.zip((0..SIZE.width).cycle()).filter(|(_, column)| *column < 20).map(|(y, _)| y).collect();
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    (light, mean)
}

/// One sample in twenty is large. A pixel without a large sample seems to contradict the pixels around it, and
/// becomes smooth.
#[test]
fn few_large_samples_of_snow_are_no_evidence() {
    let film = film(8, |_, number| if number < 0.05 { 30.0 } else { number - 0.5 });
    let (light, mean) = light_of_snow(&film);
    let deviation = (light.iter().map(|light| (light - mean).powi(2)).sum::<f64>() / light.len() as f64).sqrt();
    // A single pixel deviates by 30 √(.05 · .95)/√8 = 2.3.
    assert!(deviation < 0.35, "{deviation} of {mean}");
}

/// One sample in five thousand is large, and makes its pixel more than twice as bright.
#[test]
fn rare_large_samples_of_snow_leave_no_dots() {
    let film = film(128, |_, number| if number < 2e-4 { 270.0 } else { number - 0.5 });
    let (light, mean) = light_of_snow(&film);
    let greatest = light.iter().map(|light| (light / mean - 1.0).abs()).fold(0.0, f64::max);
    // The pixel of a large sample deviates by 1 if nothing is filtered.
    assert!(greatest < 0.08, "{greatest} of {mean}");
}

/// A mean over 5 × 5 pixels may differ by chance from the pixels farther away.
#[test]
fn even_noise_leaves_no_dots() {
    let film = film(16, |_, number| 2.0 * (number - 0.5));
    let (light, mean) = light_of_snow(&film);
    let square = light.iter().map(|light| (light / mean - 1.0).powi(2)).sum::<f64>() / light.len() as f64;
    // The standard errors of a pixel and of a mean over 5 × 5 pixels are 0.072 and 0.02.
    assert!(square.sqrt() < 0.0125, "{}", square.sqrt());
}

/// The residuals of snow and of other surfaces differ in kind.
#[test]
fn snow_and_other_surfaces_of_like_light_are_kept_apart() {
    let residual = |column: u32, number: f32| [if column < 6 { 0.4 } else { -0.4 } + 2.0 * (number - 0.5); 3];
    let means = columns(&film_of_surfaces(16, |column| (2.0, column < 6), residual));
    for (column, light) in [(4, 2.4), (5, 2.4), (6, 1.6), (7, 1.6)] {
        // Four standard errors of the mean of a column.
        assert!((means[column] - light).abs() < 0.15, "{column}: {}", means[column]);
    }
}

/// A floor to which no lamp, sky or snow seems to shine has no baseline. A floor under a roof has less light than its
/// baseline. Both are filtered, and have the noise of their own light.
#[test]
fn noise_counts_beside_the_light_that_there_is() {
    for baseline in [0.0, 20.0] {
        let film = film_of_surfaces(16, |_| (baseline, false), |_, number| [2.0 * number - baseline; 3]);
        let light = row(&film, 8);
        // The standard error of a pixel is 2/√12/√16 = .14 of a light of 1.
        let square: f64 = light[1..11].iter().map(|light| (light - 1.0).powi(2)).sum();
        assert!((square / 10.0).sqrt() < 0.07, "{baseline}: {light:?}");
        let noise = Filtered::new(&film).unwrap().noise().to_vec();
        assert!(noise[..20].iter().all(|noise| (0.005..0.2).contains(noise)), "{baseline}: {:?}", &noise[..20]);
    }
}

/// Work that is left out for pixels that are done changes no other pixel, although each pixel reads up to 62 pixels
/// on each side.
#[test]
fn pixels_that_are_done_do_not_change_the_others() {
    let film = film(8, |_, number| number - 0.5);
    let all = Filtered::new(&film).unwrap();
    for left in [0, 5 * SIZE.width as usize + 7, 15 * SIZE.width as usize + 18] {
        let mut done = vec![true; all.noise().len()];
        done[left] = false;
        let one = Filtered::but_for(&film, &done).unwrap();
        assert_eq!(Filtered::changes(Some(&one), left), Filtered::changes(Some(&all), left), "{left}");
        assert!((one.noise()[left] - all.noise()[left]).abs() == 0.0, "{left}");
        assert!(Filtered::changes(Some(&one), left + 1) != Filtered::changes(Some(&all), left + 1), "{left}");
    }
}
