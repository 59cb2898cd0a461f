//! From the light of an image to displayable colours.
//!
//! A tone curve does not commute with the mean over a pixel. Where snow many times as bright as white covers a tenth of
//! a black pixel, the mean is still about white, and an edge has stairs. So the curve applies to the snow of such a
//! pixel and to the rest of it apart. The [fraction](Film::with_shown) c of snow is known. The rest D is the mean of
//! those of the eight neighbours that show no snow. The snow S follows from the mean c S + (1 − c) D, and
//!
//! > c T(S) + (1 − c) T(D)
//!
//! is shown. Pixels with snow alone, or without, stay as they are. With `filmic` and `none`, so do
//! displayable colours no brighter than the straight part of the curve; `agx` has none.

use rayon::prelude::*;
use snowblue_color::{LinearRgb, Srgb8, ToneCurve};
use snowblue_scene::film::Development;

use crate::film::Film;

/// The encoded colours of an image, row by row from the upper left.
pub(crate) fn displayed(film: &Film, development: Development) -> Vec<Srgb8> {
    let factor = film.display_factor(development);
    let edges = Edges { film, factor, tone: development.tone };
    (0..film.pixels().len()).into_par_iter().map(|pixel| Srgb8::encode(edges.displayed(pixel))).collect()
}

/// The tone curve on an image.
struct Edges<'film> {
    film: &'film Film,
    factor: f64,
    tone: ToneCurve,
}

impl Edges<'_> {
    fn exposed(&self, pixel: usize) -> LinearRgb {
        LinearRgb::from_xyz(self.film.pixels()[pixel] * self.factor)
    }

    fn displayed(&self, pixel: usize) -> LinearRgb {
        let (mean, snow) = (self.exposed(pixel), self.film.snow_fraction(pixel));
        let is_edge = snow > 0.0 && snow < 1.0;
        is_edge.then(|| self.displayed_edge(pixel, mean, snow)).flatten().unwrap_or_else(|| self.tone.displayed(mean))
    }

    /// The displayed colour of a pixel that snow covers in part; none if the rest is not seen beside it.
    fn displayed_edge(&self, pixel: usize, mean: LinearRgb, snow: f64) -> Option<LinearRgb> {
        let (mut rest, mut count) = (LinearRgb::default(), 0_u8);
        // A lamp beside the edge is not what the pixel shows.
        let is_rest = |neighbour: &usize| {
            let shown = self.film.shown(*neighbour);
            shown.snow <= 0.0 && (!shown.emitter || self.film.shown(pixel).emitter)
        };
        for neighbour in self.neighbours(pixel).filter(is_rest) {
            rest += self.exposed(neighbour);
            count += 1;
        }
        let rest = (count > 0).then(|| rest * f64::from(count).recip())?;
        let mut of_snow = mean * snow.recip();
        of_snow += rest * ((snow - 1.0) / snow);
        let mut sum = (of_snow.luminance() > 0.0).then(|| self.tone.displayed(of_snow) * snow)?;
        sum += self.tone.displayed(rest) * (1.0 - snow);
        Some(sum)
    }

    /// The pixels around a pixel.
    fn neighbours(&self, pixel: usize) -> impl Iterator<Item = usize> {
        let [width, height] = [self.film.size().width, self.film.size().height].map(|side| side as usize);
        let (column, row) = (pixel % width, pixel / width);
        let around = |place: usize, end: usize| place.saturating_sub(1)..(place + 2).min(end);
        around(row, height)
            .flat_map(move |y| around(column, width).map(move |x| y * width + x))
            .filter(move |neighbour| *neighbour != pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Shown;
    use snowblue_color::Xyz;
    use snowblue_scene::film::{Exposure, ImageSize};

    /// A row of pixels, given by their light and their fraction of snow.
    fn codes(pixels: &[(f64, f32)], tone: ToneCurve) -> Vec<u8> {
        let grey = |level: f64| LinearRgb { r: level, g: level, b: level }.xyz();
        let light: Vec<Xyz> = pixels.iter().map(|(level, _)| grey(*level)).collect();
        let shown = pixels.iter().map(|(_, snow)| Shown { snow: *snow, emitter: false }).collect();
        let size = ImageSize { width: u32::try_from(pixels.len()).unwrap(), height: 1 };
        let film = Film::new(size, light).with_shown(shown);
        displayed(&film, Development { exposure: Exposure::Stops(0.0), tone }).iter().map(|pixel| pixel.g).collect()
    }

    fn code(level: f64) -> u8 {
        Srgb8::encode(LinearRgb { r: level, g: level, b: level }).g
    }

    /// Snow of light 8 that covers a quarter of a black pixel.
    #[test]
    fn an_edge_of_bright_snow_is_as_bright_as_its_share_of_the_pixel() {
        for tone in ToneCurve::ALL {
            let shown = tone.displayed(LinearRgb { r: 8.0, g: 8.0, b: 8.0 }).luminance();
            let found = codes(&[(0.0, 0.0), (2.0, 0.25), (8.0, 1.0)], tone);
            assert_eq!(found, [0, code(0.25 * shown), code(shown)], "{tone}");
            let found = codes(&[(0.4, 0.0), (0.75 * 0.4 + 2.0, 0.25), (8.0, 1.0)], tone);
            let rest = tone.displayed(LinearRgb { r: 0.4, g: 0.4, b: 0.4 }).luminance();
            assert!(found[1].abs_diff(code(0.25 * shown + 0.75 * rest)) <= 1, "{tone}: {found:?}");
        }
    }

    #[test]
    fn all_else_stays_as_it_is() {
        // Within the straight part of the curve, inside and outside of snow, and where snow covers the neighbours too.
        let pixels = [(0.1, 0.0), (0.3, 0.4), (0.6, 1.0), (1.4, 0.5), (3.0, 1.0), (2.0, 0.0)];
        for tone in [ToneCurve::None, ToneCurve::Filmic] {
            let found = codes(&pixels[..4], tone);
            let alone = pixels[..4].iter().map(|pixel| codes(&[*pixel], tone)[0]).collect::<Vec<_>>();
            assert_eq!(found, alone, "{tone}");
        }
        // More light beside the snow than in the mean: there is no such snow.
        assert_eq!(codes(&[(2.0, 0.0), (0.5, 0.5)], ToneCurve::None)[1], code(0.5));
    }
}
