//! Published white points, chromaticities and colours, and results of an independent program.
//!
//! `scripts/color_golden.py` wrote the files in `tests/data/` with the Python package colour-science 0.4.7
//! (BSD-3-Clause).

use snowblue_color::sampling::{Interpolation, SampledSpectrum};
use snowblue_color::{
    ChromaticAdaptation, Colorimeter, Illuminant, Lab, LinearRgb, Observer, Oklab, Rgb, RgbSpace, Srgb8,
    WavelengthStep, Xyz,
};

fn every(step_nm: f64, first_nm: f64, last_nm: f64) -> Vec<f64> {
    let wavelengths_nm = (0..).map(|index| first_nm + step_nm * f64::from(index));
    wavelengths_nm.take_while(|wavelength_nm| *wavelength_nm <= last_nm).collect()
}

fn white(illuminant: Illuminant, wavelengths_nm: &[f64]) -> Xyz {
    white_of(Observer::Cie1931, illuminant, wavelengths_nm)
}

fn white_of(observer: Observer, illuminant: Illuminant, wavelengths_nm: &[f64]) -> Xyz {
    Colorimeter::new(observer, illuminant, wavelengths_nm).expect("a white").white()
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
/// Adaptation"), with five decimals. Sums at 5 nm agree within 2 units of the last digit; D65 needs 1 nm.
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
    // Z of the 5 nm sum is 1.4e-4 too high.
    assert_xyz(white(Illuminant::D65, &every(5.0, 360.0, 780.0)), d65, 1.5e-4, "D65 at 5 nm");
}

/// The same for the 10° observer, as reprinted with the standard's tables. Sums at 5 nm agree within 4 units of the
/// last digit, except for D65, which needs 1 nm.
#[test]
fn white_points_of_astm_e308_for_10_degrees() {
    let printed = [
        ("A", 1.11144, 0.35200),
        ("C", 0.97285, 1.16145),
        ("D50", 0.96720, 0.81427),
        ("D55", 0.95799, 0.90926),
        ("D75", 0.94416, 1.20641),
        ("FL2", 1.03279, 0.69027),
        ("FL7", 0.95792, 1.07686),
        ("FL11", 1.03863, 0.65607),
    ];
    for (name, x, z) in printed {
        let illuminant: Illuminant = name.parse().unwrap();
        let first_nm = illuminant.range_nm().start().max(360.0);
        let found = white_of(Observer::Cie1964, illuminant, &every(5.0, first_nm, 780.0));
        assert_xyz(found, [x, 1.0, z], 4e-5, name);
    }
    let d65 = white_of(Observer::Cie1964, Illuminant::D65, &every(1.0, 360.0, 780.0));
    assert_xyz(d65, [0.94811, 1.0, 1.07304], 1e-5, "D65 at 1 nm");
}

/// The colour-matching functions have equal areas by construction, with a rounding error of 3.4e-4.
#[test]
fn equal_power_is_white() {
    assert_xyz(white(Illuminant::E, &every(1.0, 360.0, 830.0)), [1.0; 3], 3.4e-4, "1 nm");
    assert_xyz(white(Illuminant::E, &every(5.0, 360.0, 830.0)), [1.0; 3], 3.5e-4, "5 nm");
}

/// CIE 015:2018 prints the chromaticity of each illuminant, mostly with four decimals. Half a unit of the last digit is
/// 5e-5; FL3.13 is off by another 2e-6. A wrong line in a file would exceed this.
#[test]
fn chromaticities_of_all_illuminants() {
    let published: Vec<_> = rows(include_str!("../data/illuminant_chromaticities.csv")).collect();
    // 2°: all illuminants. 10°: all but FL1–FL12; the ASTM E308 test above covers three of these.
    assert_eq!(published.len(), 2 * Illuminant::all().count() - 12);
    for row in published {
        let illuminant: Illuminant = row[0].parse().unwrap();
        let (first_nm, last_nm) = illuminant.range_nm().into_inner();
        let grid_nm = every(5.0, first_nm.max(360.0), last_nm);
        let found = white_of(row[1].parse().unwrap(), illuminant, &grid_nm).chromaticity();
        let expected = numbers(&row[2..]);
        let close = (found.x - expected[0]).abs() < 5.3e-5 && (found.y - expected[1]).abs() < 5.3e-5;
        assert!(close, "{row:?}: {found:?}");
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
        let found = Observer::Cie1931.color_matching(wavelength_nm).unwrap().chromaticity();
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

/// CIELAB of the sRGB primaries for D65, as printed by converters (B. Lindbloom, brucelindbloom.com, CIE calculator).
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

/// Four spectra under eight illuminants, on 400–700 nm every 10 nm.
#[test]
fn colours_of_colour_science() {
    let spectra = include_str!("../data/spectra.csv");
    let header: Vec<&str> = spectra.lines().take(1).flat_map(|line| line.split(',')).collect();
    let column = |index: usize| -> Vec<f64> { rows(spectra).map(|row| row[index].parse().unwrap()).collect() };
    let wavelengths_nm = column(0);
    assert_eq!(wavelengths_nm, every(10.0, 400.0, 700.0));
    let expected_colours: Vec<_> = rows(include_str!("../data/colours.csv")).collect();
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

/// Every illuminant, observer and step, each with one of three spectra.
#[test]
fn sums_of_colour_science() {
    let curve = |name: &str, nm: f64| match name {
        "snow" => 0.0215 * (-((nm - 400.0).max(0.0) / 265.0).powi(3)).exp(),
        "green_band" => (-((nm - 540.0) / 30.0).powi(2)).exp(),
        _ => (nm - 300.0) / 600.0,
    };
    let expected_sums: Vec<_> = rows(include_str!("../data/sums.csv")).collect();
    assert_eq!(expected_sums.len(), 48 * 2 * 3);
    for row in expected_sums {
        let illuminant: Illuminant = row[0].parse().unwrap();
        let step = WavelengthStep::ALL.into_iter().find(|step| step.nm().to_string() == row[2]).unwrap();
        let grid_nm = step.wavelengths_nm(illuminant);
        let colorimeter = Colorimeter::new(row[1].parse().unwrap(), illuminant, &grid_nm).unwrap();
        let values: Vec<f64> = grid_nm.iter().map(|nm| curve(row[3], *nm)).collect();
        let expected = numbers(&row[4..]);
        // The file has 12 digits of numbers up to 3.
        assert_xyz(colorimeter.xyz(&values), [expected[0], expected[1], expected[2]], 1e-11, &format!("{row:?}"));
    }
}

#[test]
fn spaces_of_colour_science() {
    let (d65, aces) = (RgbSpace::Srgb.white(), RgbSpace::AcesCg.white());
    let mut before: Option<Lab> = None;
    for row in rows(include_str!("../data/spaces.csv")) {
        let expected = numbers(&row);
        let xyz = Xyz { x: expected[0], y: expected[1], z: expected[2] };
        let wide = [RgbSpace::Rec2020, RgbSpace::AcesCg].map(|space| space.from_xyz(xyz));
        let lab = Lab::from_xyz(xyz, d65);
        let mut found: Vec<f64> = wide.into_iter().flat_map(|Rgb { r, g, b }| [r, g, b]).collect();
        let adapted = ChromaticAdaptation { from_white: d65, to_white: aces }.apply(xyz);
        found.extend([adapted.x, adapted.y, adapted.z, lab.l, lab.a, lab.b]);
        found.push(before.map_or(0.0, |before| before.delta_e_2000(lab)));
        for (value, expected) in found.iter().zip(&expected[3..]) {
            // The file has 12 digits; a* and b* are up to 500 times a difference of numbers near 1.
            assert!((value - expected).abs() < 1e-9, "{row:?}: {value}, expected {expected}");
        }
        let Oklab { l, a, b } = Oklab::from_xyz(xyz);
        for (value, expected) in [l, a, b].into_iter().zip(&expected[16..]) {
            // Our rows of M₁ are scaled by up to 5e-4: a third of that in the cube roots, times up to 2.4 in a and b.
            assert!((value - expected).abs() < 4e-4, "{row:?}: {value}, expected {expected}");
        }
        before = Some(lab);
    }
}

/// Table 1 of Sharma, Wu & Dalal 2005, doi:10.1002/col.20070: all 34 pairs, printed with four decimals.
#[test]
fn pairs_of_sharma_2005() {
    let pairs: Vec<Vec<f64>> = rows(include_str!("../data/sharma_2005.csv")).map(|row| numbers(&row)).collect();
    assert_eq!(pairs.len(), 34);
    for pair in pairs {
        let [first, second] = [&pair[..3], &pair[3..6]].map(|lab| Lab { l: lab[0], a: lab[1], b: lab[2] });
        for found in [first.delta_e_2000(second), second.delta_e_2000(first)] {
            assert!((found - pair[6]).abs() <= 5e-5, "{pair:?}: {found}");
        }
    }
}

#[test]
fn sprague_curves_of_colour_science() {
    let spectra: Vec<Vec<f64>> = rows(include_str!("../data/spectra.csv")).map(|row| numbers(&row)).collect();
    let (known_nm, snow): (Vec<f64>, Vec<f64>) = spectra.iter().map(|row| (row[0], row[1])).unzip();
    let spectrum = SampledSpectrum { wavelengths_nm: &known_nm, values: &snow };
    for row in rows(include_str!("../data/sprague.csv")) {
        let expected = numbers(&row);
        let found = spectrum.resample(&expected[..1], Interpolation::Sprague).unwrap();
        assert!((found[0] - expected[1]).abs() < 1e-12, "{row:?}: {found:?}");
    }
}
