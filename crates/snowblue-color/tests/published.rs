//! Other people's numbers: printed white points, chromaticities and colours, and those of an independent program.
//!
//! `tests/data/` was written by `scripts/color_golden.py` with the Python package colour-science 0.4.7 (BSD-3-Clause).

use snowblue_color::{Colorimeter, Illuminant, Lab, LinearRgb, Observer, Srgb8, Xyz};

fn every(step_nm: f64, first_nm: f64, last_nm: f64) -> Vec<f64> {
    let wavelengths_nm = (0..).map(|index| first_nm + step_nm * f64::from(index));
    wavelengths_nm.take_while(|wavelength_nm| *wavelength_nm <= last_nm).collect()
}

fn white(illuminant: Illuminant, wavelengths_nm: &[f64]) -> Xyz {
    Colorimeter::new(Observer::Cie1931, illuminant, wavelengths_nm).expect("a white").white()
}

fn rows(csv: &str) -> impl Iterator<Item = Vec<&str>> {
    csv.lines().skip(1).map(|line| line.split(',').collect())
}

fn numbers(fields: &[&str]) -> Vec<f64> {
    fields.iter().map(|field| field.parse().expect("a number")).collect()
}

fn assert_xyz(xyz: Xyz, expected: [f64; 3], tolerance: f64, context: &str) {
    let differences = [xyz.x - expected[0], xyz.y - expected[1], xyz.z - expected[2]];
    let close = differences.iter().all(|difference| difference.abs() <= tolerance);
    assert!(close, "{context}: {xyz:?}, expected {expected:?} ± {tolerance}");
}

/// White points of ASTM E308-01 for the 2° observer, as quoted by B. Lindbloom, brucelindbloom.com ("Chromatic
/// Adaptation"), with five decimals. Sums at 5 nm give them within 2 units of the last; D65 takes steps of 1 nm.
#[test]
fn white_points_of_astm_e308() {
    let printed = [
        ("A", 1.09850, 0.35585),
        ("C", 0.98074, 1.18232),
        ("D50", 0.96422, 0.82521),
        ("D55", 0.95682, 0.92149),
        ("D75", 0.94972, 1.22638),
        ("FL2", 0.99186, 0.67393),
        ("FL7", 0.95041, 1.08747),
        ("FL11", 1.00962, 0.64350),
    ];
    for (name, x, z) in printed {
        let illuminant: Illuminant = name.parse().unwrap();
        let first_nm = illuminant.range_nm().start().max(360.0);
        assert_xyz(white(illuminant, &every(5.0, first_nm, 780.0)), [x, 1.0, z], 2e-5, name);
    }
    let d65 = [0.95047, 1.0, 1.08883];
    assert_xyz(white(Illuminant::D65, &every(1.0, 360.0, 780.0)), d65, 1e-5, "D65 at 1 nm");
    // The coarser sum is 1.4e-4 too high in Z.
    assert_xyz(white(Illuminant::D65, &every(5.0, 360.0, 780.0)), d65, 1.5e-4, "D65 at 5 nm");
}

/// The colour-matching functions have equal areas by construction, up to 3.4e-4 by their rounding.
#[test]
fn equal_power_is_white() {
    assert_xyz(white(Illuminant::E, &every(1.0, 360.0, 830.0)), [1.0; 3], 3.4e-4, "1 nm");
    assert_xyz(white(Illuminant::E, &every(5.0, 360.0, 830.0)), [1.0; 3], 3.5e-4, "5 nm");
}

/// CIE 015:2018 prints the chromaticity of each light that it tabulates, mostly with four decimals: half a unit of the
/// last digit is 5e-5, and FL3.13 is out by another 2e-6. A wrong line in a file would show.
#[test]
fn chromaticities_of_all_illuminants() {
    let published: Vec<_> = rows(include_str!("data/illuminant_chromaticities.csv")).collect();
    assert_eq!(published.len(), Illuminant::all().count());
    for row in published {
        let illuminant: Illuminant = row[0].parse().unwrap();
        let (first_nm, last_nm) = illuminant.range_nm().into_inner();
        let found = white(illuminant, &every(5.0, first_nm.max(360.0), last_nm)).chromaticity();
        let expected = numbers(&row[1..]);
        let close = (found.x - expected[0]).abs() < 5.3e-5 && (found.y - expected[1]).abs() < 5.3e-5;
        assert!(close, "{illuminant}: {found:?}, expected {expected:?}");
    }
}

/// Chromaticities of monochromatic light, Wyszecki & Stiles 2000, *Color Science*, table I(3.3.1).
#[test]
fn spectral_locus() {
    let printed = [
        (450.0, 0.1566, 0.0177),
        (480.0, 0.0913, 0.1327),
        (500.0, 0.0082, 0.5384),
        (520.0, 0.0743, 0.8338),
        (550.0, 0.3016, 0.6923),
        (600.0, 0.6270, 0.3725),
        (700.0, 0.7347, 0.2653),
    ];
    for (wavelength_nm, x, y) in printed {
        let found = Observer::Cie1931.matching(wavelength_nm).unwrap().chromaticity();
        assert!((found.x - x).abs() < 6e-5 && (found.y - y).abs() < 6e-5, "{wavelength_nm} nm: {found:?}");
    }
}

/// Forward matrix of IEC 61966-2-1:1999, printed with four decimals.
#[test]
fn matrix_of_srgb() {
    let printed = [
        (LinearRgb { r: 1.0, g: 0.0, b: 0.0 }, [0.4124, 0.2126, 0.0193]),
        (LinearRgb { r: 0.0, g: 1.0, b: 0.0 }, [0.3576, 0.7152, 0.1192]),
        (LinearRgb { r: 0.0, g: 0.0, b: 1.0 }, [0.1805, 0.0722, 0.9505]),
    ];
    for (primary, xyz) in printed {
        assert_xyz(primary.xyz(), xyz, 5e-5, &format!("{primary:?}"));
    }
}

/// CIELAB of the sRGB primaries for D65, as converters print them (B. Lindbloom, brucelindbloom.com, CIE calculator).
#[test]
fn lab_of_the_srgb_primaries() {
    let white = "#ffffff".parse::<Srgb8>().unwrap().decode().xyz();
    let printed = [
        ("#ff0000", Lab { l: 53.24, a: 80.09, b: 67.20 }),
        ("#00ff00", Lab { l: 87.73, a: -86.18, b: 83.18 }),
        ("#0000ff", Lab { l: 32.30, a: 79.19, b: -107.86 }),
    ];
    for (hex, expected) in printed {
        let lab = Lab::from_xyz(hex.parse::<Srgb8>().unwrap().decode().xyz(), white);
        // The printed values come from the rounded matrix of the standard.
        assert!(lab.delta_e_1976(expected) < 0.02, "{hex}: {lab:?}");
    }
}

/// Four spectra under eight lights on 400–700 nm every 10 nm.
#[test]
fn colours_of_colour_science() {
    let spectra = include_str!("data/spectra.csv");
    let header: Vec<&str> = spectra.lines().take(1).flat_map(|line| line.split(',')).collect();
    let column = |index: usize| -> Vec<f64> { rows(spectra).map(|row| row[index].parse().unwrap()).collect() };
    let wavelengths_nm = column(0);
    assert_eq!(wavelengths_nm, every(10.0, 400.0, 700.0));
    let expected_colours: Vec<_> = rows(include_str!("data/colours.csv")).collect();
    assert_eq!(expected_colours.len(), 32);
    for row in expected_colours {
        let context = format!("{} under {}", row[0], row[1]);
        let values = column(header.iter().position(|name| *name == row[0]).unwrap());
        let colorimeter = Colorimeter::new(Observer::Cie1931, row[1].parse().unwrap(), &wavelengths_nm).unwrap();
        let xyz = colorimeter.xyz(&values);
        let lab = Lab::from_xyz(xyz, colorimeter.white());
        let rgb = LinearRgb::from_xyz(xyz);
        let found = [xyz.x, xyz.y, xyz.z, lab.l, lab.a, lab.b, rgb.r, rgb.g, rgb.b];
        for (value, expected) in found.into_iter().zip(numbers(&row[2..])) {
            // The file has 12 digits; a* and b* are up to 500 times a difference of numbers near 1.
            assert!((value - expected).abs() < 1e-9, "{context}: {value}, expected {expected}");
        }
    }
}
