//! Look-ups and compression, on one thread: `cargo bench -p snowblue-database`.

#![allow(clippy::unwrap_used, reason = "a bench may panic")]

use divan::{Bencher, black_box};
use snowblue_database::fill::{self, FillOptions};
use snowblue_database::{Axes, CompressedTable, GridSample, PcaSnow, Space, Table};

fn main() {
    divan::main();
}

fn table() -> Table {
    let options = FillOptions::by_ordinates(1 << 12);
    fill::fill(&Axes::paper(), &options, &|_, _| ()).unwrap().0
}

/// A spectrum of 31 wavelengths at some thickness and angle, in the paper's form and in ours.
#[divan::bench(args = ["linear 2", "log 3"])]
fn look_up(bencher: Bencher, form: &str) {
    let (space, components) = if form == "linear 2" { (Space::Linear, 2) } else { (Space::Log, 3) };
    let sample = GridSample { grain_size_um: 400.0, facetness: 0.3, density_kg_m3: 300.0 };
    let snow = PcaSnow::new(&CompressedTable::new(&table(), space, components).unwrap(), sample).unwrap();
    let mut spectrum = [0.0; 31];
    let mut thickness_cm = 0.0;
    bencher.bench_local(|| {
        thickness_cm = if thickness_cm > 49.0 { 0.1 } else { thickness_cm + 0.37 };
        snow.transmittance(black_box(thickness_cm), black_box(33.0), &mut spectrum);
        spectrum[0]
    });
}

/// The singular value decomposition of 24,750 × 31 values, twice, and its coefficients.
#[divan::bench(sample_count = 10)]
fn compress(bencher: Bencher) {
    let table = table();
    bencher.bench_local(|| CompressedTable::new(&table, Space::Log, 3).unwrap());
}

/// 24,750 curves of transmittance and reflectance, the grain tally aside from 4096 rays a node.
#[divan::bench(sample_count = 10)]
fn fill_the_papers_table() -> Table {
    table()
}
