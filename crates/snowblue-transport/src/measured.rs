//! Published measurements of snow: albedo over black panels and micro-tomograms from Vermont, February 2021 (Letcher,
//! Parno, Courville, Farnsworth & Olivier 2022, doi:10.5194/tc-16-4343-2022, supporting data).

use crate::medium::{GrainOptics, Microstructure};

/// Albedo under sky light at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PanelAlbedo {
    /// Wavelength, in nm.
    pub wavelength_nm: f64,
    /// Albedo of 34 cm of undisturbed snow.
    pub thick: MeanAndDeviation,
    /// Albedo of 4.5 cm of snow laid over black panels.
    pub thin: MeanAndDeviation,
}

/// A mean and a standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanAndDeviation {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of a single value.
    pub standard_deviation: f64,
}

/// A point to fit a line to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
}

/// The line y = offset + slope · x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Value at x = 0.
    pub offset: f64,
    /// Slope.
    pub slope: f64,
}

/// An X-ray micro-tomogram of a snow sample, with optical properties from rays traced through it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tomogram {
    /// Density and specific surface area.
    pub structure: Microstructure,
    /// Optical properties of the grains.
    pub optics: GrainOptics,
    /// Kind of snow in the authors' letters: N new, R rounded, F faceted, M mixed, MF refrozen melt forms, C crust.
    pub kind: &'static str,
}

/// The albedo of thick snow and of thin snow over black panels, 12 February 2021, 400–1300 nm.
#[must_use]
pub fn albedo_over_black_panels() -> Vec<PanelAlbedo> {
    let row = |fields: Vec<&'static str>| {
        let albedo = |mean: usize, deviation: usize| MeanAndDeviation {
            mean: number(fields[mean]),
            standard_deviation: number(fields[deviation]),
        };
        PanelAlbedo { wavelength_nm: number(fields[0]), thick: albedo(1, 2), thin: albedo(3, 4) }
    };
    rows(include_str!("../data/albedo_vermont_2021.csv")).map(row).collect()
}

/// The micro-tomograms. The published asymmetry g = (1 + g_GO)/2 includes diffraction; this returns g_GO.
#[must_use]
pub fn tomograms() -> Vec<Tomogram> {
    let row = |fields: Vec<&'static str>| {
        let structure = Microstructure { density_kg_m3: number(fields[0]), surface_area_m2_kg: number(fields[1]) };
        let optics = GrainOptics {
            extinction_ratio: number(fields[2]) * 1e3 / structure.convex_extinction_per_m(),
            path_enhancement: number(fields[3]),
            asymmetry: 2.0 * number(fields[4]) - 1.0,
        };
        Tomogram { structure, optics, kind: fields[5] }
    };
    rows(include_str!("../data/tomograms_vermont_2021.csv")).map(row).collect()
}

/// Mean and standard deviation of some values.
#[must_use]
pub fn mean_and_deviation(values: &[f64]) -> MeanAndDeviation {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    MeanAndDeviation { mean, standard_deviation: (squares / (count - 1.0)).sqrt() }
}

/// The least-squares line through some points.
#[must_use]
pub fn fit_line(points: &[Point]) -> Line {
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.x / count, y + point.y / count));
    let (mut products, mut squares) = (0.0, 0.0);
    for point in points {
        products += (point.x - x) * (point.y - y);
        squares += (point.x - x).powi(2);
    }
    let slope = products / squares;
    Line { offset: y - slope * x, slope }
}

fn rows(csv: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    csv.lines().skip(1).map(|line| line.split(',').collect())
}

/// Parses a number of a table that ships with this crate.
fn number(field: &str) -> f64 {
    field.parse().unwrap_or_else(|_| unreachable!("'{field}' is not a number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Their supporting data: the first and the last row of either table.
    #[test]
    fn tables_are_complete() {
        let albedo = albedo_over_black_panels();
        let printed = |mean, standard_deviation| MeanAndDeviation { mean, standard_deviation };
        assert_eq!((albedo.len(), albedo[0].thick), (181, printed(0.99419, 0.00848)));
        assert_eq!((albedo[180].thin, albedo[180].wavelength_nm.round()), (printed(0.46215, 0.00723), 1300.0));
        assert!(albedo.windows(2).all(|pair| (pair[1].wavelength_nm - pair[0].wavelength_nm - 5.0).abs() < 1e-9));
        let tomograms = tomograms();
        assert_eq!((tomograms.len(), tomograms[0].kind), (32, "MF"));
        assert!((tomograms[31].structure.surface_area_m2_kg - 13.12).abs() < 1e-12);
        let enhancements: Vec<f64> = tomograms.iter().map(|tomogram| tomogram.optics.path_enhancement).collect();
        assert!((mean_and_deviation(&enhancements).mean - 1.53).abs() < 0.01);
    }

    #[test]
    fn the_line_through_collinear_points_is_exact() {
        let points = [(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)].map(|(x, y)| Point { x, y });
        let Line { offset, slope } = fit_line(&points);
        assert!((offset - 3.0).abs() < 1e-12 && (slope - 2.0).abs() < 1e-12);
    }
}
