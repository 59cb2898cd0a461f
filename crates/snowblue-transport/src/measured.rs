//! Measured snow to compare with: albedo over black panels and micro-tomograms from Vermont, February 2021 (Letcher,
//! Parno, Courville, Farnsworth & Olivier 2022, doi:10.5194/tc-16-4343-2022, supporting data).

use crate::medium::{GrainOptics, convex_extinction_per_m};

/// Albedo under sky light at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PanelAlbedo {
    /// Wavelength, in nm.
    pub wavelength_nm: f64,
    /// Of 34 cm of undisturbed snow, and its standard deviation.
    pub thick: [f64; 2],
    /// Of 4.5 cm of snow laid over black panels, and its standard deviation.
    pub thin: [f64; 2],
}

/// A snow sample that was seen by X-rays, and what rays of light did in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tomogram {
    /// Density, in kg/m³.
    pub density_kg_m3: f64,
    /// Specific surface area, in m²/kg.
    pub surface_area_m2_kg: f64,
    /// What light meets of the grains.
    pub optics: GrainOptics,
    /// The authors' letters: N new, R rounded, F faceted, M mixed, MF refrozen melt forms, C crust.
    pub kind: &'static str,
}

/// The albedo of thick snow and of thin snow over black panels, 12 February 2021, 400–1300 nm.
#[must_use]
pub fn albedo_over_black_panels() -> Vec<PanelAlbedo> {
    let row = |fields: Vec<&'static str>| PanelAlbedo {
        wavelength_nm: number(fields[0]),
        thick: [number(fields[1]), number(fields[2])],
        thin: [number(fields[3]), number(fields[4])],
    };
    rows(include_str!("../data/albedo_vermont_2021.csv")).map(row).collect()
}

/// The micro-tomograms. Their asymmetry counts diffraction, g = (1 + g_GO)/2; here is g_GO.
#[must_use]
pub fn tomograms() -> Vec<Tomogram> {
    let row = |fields: Vec<&'static str>| {
        let (density_kg_m3, surface_area_m2_kg) = (number(fields[0]), number(fields[1]));
        let optics = GrainOptics {
            extinction_ratio: number(fields[2]) * 1e3 / convex_extinction_per_m(density_kg_m3, surface_area_m2_kg),
            path_enhancement: number(fields[3]),
            asymmetry: 2.0 * number(fields[4]) - 1.0,
        };
        Tomogram { density_kg_m3, surface_area_m2_kg, optics, kind: fields[5] }
    };
    rows(include_str!("../data/tomograms_vermont_2021.csv")).map(row).collect()
}

/// Mean and standard deviation of the samples.
#[must_use]
pub fn mean_and_deviation(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    [mean, (squares / (count - 1.0)).sqrt()]
}

/// Offset and slope of the straight line through points (x, y) by least squares.
#[must_use]
pub fn straight_line(points: &[(f64, f64)]) -> [f64; 2] {
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let (mut products, mut squares) = (0.0, 0.0);
    for point in points {
        products += (point.0 - x) * (point.1 - y);
        squares += (point.0 - x).powi(2);
    }
    let slope = products / squares;
    [y - slope * x, slope]
}

fn rows(csv: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    csv.lines().skip(1).map(|line| line.split(',').collect())
}

/// A number of a table that ships with this crate.
fn number(field: &str) -> f64 {
    field.parse().unwrap_or_else(|_| unreachable!("'{field}' is not a number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Their supporting data: the first and the last row of either table.
    #[test]
    fn tables_are_whole() {
        let albedo = albedo_over_black_panels();
        assert_eq!((albedo.len(), albedo[0].thick), (181, [0.99419, 0.00848]));
        assert_eq!((albedo[180].thin, albedo[180].wavelength_nm.round()), ([0.46215, 0.00723], 1300.0));
        assert!(albedo.windows(2).all(|pair| (pair[1].wavelength_nm - pair[0].wavelength_nm - 5.0).abs() < 1e-9));
        let tomograms = tomograms();
        assert_eq!((tomograms.len(), tomograms[0].kind), (32, "MF"));
        assert!((tomograms[31].surface_area_m2_kg - 13.12).abs() < 1e-12);
        let enhancements: Vec<f64> = tomograms.iter().map(|one| one.optics.path_enhancement).collect();
        assert!((mean_and_deviation(&enhancements)[0] - 1.53).abs() < 0.01);
    }

    #[test]
    fn a_line_goes_through_its_points() {
        let [offset, slope] = straight_line(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]);
        assert!((offset - 3.0).abs() < 1e-12 && (slope - 2.0).abs() < 1e-12);
    }
}
