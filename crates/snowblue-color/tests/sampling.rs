//! What coarser steps cost: light through snow summed every 5 and 10 nm, against every 1 nm.

use snowblue_color::{Colorimeter, Illuminant, Lab, Observer, Step};

/// The size and slope of light through 15 cm of snow.
fn snow(wavelength_nm: f64) -> f64 {
    0.0215 * (-((wavelength_nm - 400.0).max(0.0) / 265.0).powi(3)).exp()
}

/// CIELAB of snow exposed so that its bluest is white, against the white of the same sum.
fn lab(observer: Observer, illuminant: Illuminant, step: Step) -> Lab {
    let grid_nm = step.wavelengths_nm(illuminant);
    let colorimeter = Colorimeter::new(observer, illuminant, &grid_nm).expect("a white");
    let values: Vec<f64> = grid_nm.iter().map(|nm| snow(*nm) / 0.0215).collect();
    Lab::from_xyz(colorimeter.xyz(&values), colorimeter.white())
}

/// The greatest ΔE*ab of a step against 1 nm, among lights whose names begin like one of these and both observers.
fn greatest_cost(names: &[&str], step: Step) -> f64 {
    let lights = Illuminant::all().filter(|light| names.iter().any(|name| light.name().starts_with(name)));
    let cost =
        |light| Observer::ALL.map(|observer| lab(observer, light, step).delta_e_1976(lab(observer, light, Step::Nm1)));
    lights.flat_map(cost).fold(0.0, f64::max)
}

/// The limits are what was found, rounded up: 0.0083 at 5 nm under C, 0.066 at 10 nm under LED-RGB1, 0.056 at 5 nm under
/// HP1 and 3.25 at 10 nm under FL3.11, whose lines every second entry of its table misses.
#[test]
fn steps_cost_little_but_under_lines() {
    let (smooth, diodes, lines) = (["D", "E", "A", "C"], ["LED"], ["FL", "HP"]);
    for step in [Step::Nm5, Step::Nm10] {
        assert!(greatest_cost(&smooth, step) < 0.01);
        assert!(greatest_cost(&diodes, step) < 0.07);
    }
    assert!(greatest_cost(&lines, Step::Nm5) < 0.06);
    let cost = greatest_cost(&lines, Step::Nm10);
    assert!((3.2..3.3).contains(&cost), "{cost}");
}
