//! Look-ups and compression, on one thread: `cargo bench -p snowblue-database`.

#![allow(clippy::unwrap_used, reason = "a bench may panic")]

use divan::{Bencher, black_box};
use snowblue_database::fill::{self, FillOptions};
use snowblue_database::{Axes, CompressedTable, PcaSnow, Space, Table, TableSample};

fn main() {
    divan::main();
}

fn table(axes: &Axes) -> Table {
    let options = FillOptions::by_ordinates(1 << 12);
    fill::fill(axes, &options, &|_, _| ()).unwrap().0
}

/// Both forms, each with the components that it is meant for: the paper's two, and the embedded table's six.
const FORMS: [&str; 2] = ["paper, 2 components", "log, 6 components"];

fn snow(form: &str) -> PcaSnow {
    let (space, components, axes) = if form == FORMS[0] {
        (Space::Linear, 2, Axes::paper())
    } else {
        (Space::Log, 6, Axes::with_thin_and_thick_knots())
    };
    let sample = TableSample::new(400.0, 0.3, 300.0);
    let axes = Axes { grain_sizes_um: vec![200.0, 400.0], facetness: vec![0.3, 0.7], ..axes };
    PcaSnow::new(&CompressedTable::new(&table(&axes), space, components).unwrap(), &sample).unwrap()
}

/// Places all over the splines, so that neither memory nor branches know the next one.
fn places() -> Vec<(f32, f32)> {
    let fraction = |turn: f32, number: u16| (turn * f32::from(number)).fract();
    (0..1024).map(|n| (0.01 * 5000_f32.powf(fraction(0.618_034, n)), 89.0 * fraction(0.754_877, n))).collect()
}

/// Coefficients at some thickness and angle.
#[divan::bench(args = FORMS)]
fn look_up_coefficients(bencher: Bencher, form: &str) {
    let (snow, places) = (snow(form), places());
    let mut coefficients = [0.0; 32];
    let mut next = 0;
    bencher.bench_local(|| {
        next = (next + 1) % places.len();
        let (thickness_cm, angle_deg) = black_box(places[next]);
        snow.transmittance_coefficients(thickness_cm, angle_deg, &mut coefficients);
        coefficients[0]
    });
}

/// A spectrum of 31 wavelengths at some thickness and angle.
#[divan::bench(args = FORMS)]
fn look_up_spectrum(bencher: Bencher, form: &str) {
    let (snow, places) = (snow(form), places());
    let mut spectrum = [0.0; 31];
    let mut next = 0;
    bencher.bench_local(|| {
        next = (next + 1) % places.len();
        let (thickness_cm, angle_deg) = black_box(places[next]);
        snow.transmittance(thickness_cm, angle_deg, &mut spectrum);
        spectrum[0]
    });
}

/// The singular value decomposition of 24,750 × 31 values, twice, and its coefficients.
#[divan::bench(sample_count = 10)]
fn compress(bencher: Bencher) {
    let table = table(&Axes::paper());
    bencher.bench_local(|| CompressedTable::new(&table, Space::Log, 3).unwrap());
}

/// 24,750 curves of transmittance and reflectance, the grain tally aside from 4096 rays a node.
#[divan::bench(sample_count = 10)]
fn fill_the_papers_table() -> Table {
    table(&Axes::paper())
}
