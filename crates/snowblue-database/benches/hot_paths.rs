//! Benchmarks of look-up, compression and filling: `cargo bench -p snowblue-database`.

#![allow(clippy::unwrap_used, reason = "a bench may panic")]

use divan::{Bencher, black_box};
use snowblue_database::fill::{self, FillOptions};
use snowblue_database::{Axes, CompressedTable, PcaSnow, Space, Table, TableSample};

fn main() {
    divan::main();
}

fn table(axes: &Axes) -> Table {
    let options = FillOptions::by_ordinates(1 << 12);
    fill::fill(axes, &options, &|_| ()).unwrap()
}

/// Both spaces with their default components: the paper's two, and the embedded table's six.
const SCHEMES: [&str; 2] = ["paper, 2 components", "log, 6 components"];

fn snow(scheme: &str) -> PcaSnow {
    let (space, components, axes) = if scheme == SCHEMES[0] {
        (Space::Linear, 2, Axes::paper())
    } else {
        (Space::Log, 6, Axes::with_thin_and_thick_knots())
    };
    let sample = TableSample::new(400.0, 0.3, 300.0);
    let axes = Axes { grain_sizes_um: vec![200.0, 400.0], facetness: vec![0.3, 0.7], ..axes };
    PcaSnow::new(&CompressedTable::new(&table(&axes), space, components).unwrap(), &sample).unwrap()
}

/// Points spread over the table, so that caches and branch prediction do not help.
fn points() -> Vec<(f32, f32)> {
    let fraction = |turn: f32, number: u16| (turn * f32::from(number)).fract();
    (0..1024).map(|n| (0.01 * 5000_f32.powf(fraction(0.618_034, n)), 89.0 * fraction(0.754_877, n))).collect()
}

/// The coefficients at a thickness and an angle.
#[divan::bench(args = SCHEMES)]
fn look_up_coefficients(bencher: Bencher, scheme: &str) {
    let (snow, points) = (snow(scheme), points());
    let mut coefficients = [0.0; 32];
    let mut next = 0;
    bencher.bench_local(|| {
        next = (next + 1) % points.len();
        let (thickness_cm, angle_deg) = black_box(points[next]);
        snow.transmittance_coefficients(thickness_cm, angle_deg, &mut coefficients);
        coefficients[0]
    });
}

/// A spectrum of 31 wavelengths at a thickness and an angle.
#[divan::bench(args = SCHEMES)]
fn look_up_spectrum(bencher: Bencher, scheme: &str) {
    let (snow, points) = (snow(scheme), points());
    let mut spectrum = [0.0; 31];
    let mut next = 0;
    bencher.bench_local(|| {
        next = (next + 1) % points.len();
        let (thickness_cm, angle_deg) = black_box(points[next]);
        snow.transmittance(thickness_cm, angle_deg, &mut spectrum);
        spectrum[0]
    });
}

/// Two singular value decompositions of 24,750 × 31 values, and their coefficients.
#[divan::bench(sample_count = 10)]
fn compress(bencher: Bencher) {
    let table = table(&Axes::paper());
    bencher.bench_local(|| CompressedTable::new(&table, Space::Log, 3).unwrap());
}

/// 24,750 curves of transmittance and reflectance, with a grain tally of 4096 rays per node.
#[divan::bench(sample_count = 10)]
fn fill_the_papers_table() -> Table {
    table(&Axes::paper())
}
