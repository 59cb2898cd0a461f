//! Tables on any axes, by either engine, in parts and merged.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{self, Engine, FillOptions};
use snowblue_database::shard::{self, Part, Shard};
use snowblue_database::{Axes, CompressedTable, Property, Space, Table};
use snowblue_transport::optics::Substance;
use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::slab::Slab;

const TALLY_RAYS: u32 = 1 << 12;

fn axes() -> Axes {
    Axes {
        grain_sizes_um: vec![200.0, 400.0, 900.0],
        facetness: vec![0.2, 0.6],
        densities_kg_m3: vec![250.0, 400.0],
        further: vec![
            (Property::WaterSaturation, vec![0.0, 0.2]),
            (Property::Impurity(Substance::BlackCarbon), vec![0.0, 50.0]),
        ],
        diffuse: true,
        angles_deg: vec![0.0, 60.0],
        thicknesses_cm: vec![0.5, 3.0],
        wavelengths_nm: vec![400.0, 550.0, 700.0],
    }
}

fn fill(axes: &Axes) -> Table {
    fill::fill(axes, &FillOptions::by_ordinates(TALLY_RAYS), &|_, _| ()).unwrap().0
}

fn shards(of: usize) -> Vec<(String, Shard)> {
    let part = |number| {
        let part = Part { number, of };
        let options = FillOptions::by_ordinates(TALLY_RAYS);
        (format!("part{number}.nc"), shard::fill_part(&axes(), &options, part, &|_, _| ()).unwrap().0)
    };
    (1..=of).map(part).collect()
}

/// Every sample of a table is what the engine says of it by itself, wet or sooty, under any light. The tallies differ in
/// nothing but the grid of absorptions, whose ends change its interpolation by 10⁻⁹.
#[test]
fn values_stand_at_their_places() {
    let (axes, table) = (axes(), fill(&axes()));
    let per_sample = axes.curves_per_sample() * axes.wavelengths_nm.len();
    for number in (0..axes.samples()).step_by(7) {
        let slab = Slab {
            sample: axes.sample(number, snowblue_transport::optics::IceTable::default()).unwrap(),
            thicknesses_cm: axes.thicknesses_cm.clone(),
            incidences: axes.incidences(),
            wavelengths_nm: axes.wavelengths_nm.clone(),
        };
        let options = OrdinatesOptions { tally_rays: TALLY_RAYS, ..OrdinatesOptions::default() };
        let solved = ordinates::solve(&slab, &options).unwrap();
        let lights = slab.incidences.len();
        for (place, row) in solved.iter().enumerate() {
            // The engine runs through lights within thicknesses, the table the other way about.
            let (rest, w) = (place / 3, place % 3);
            let (thickness, light) = (rest / lights, rest % lights);
            let there = number * per_sample + (light * axes.thicknesses_cm.len() + thickness) * 3 + w;
            for (value, expected) in
                [(table.transmittance[there], row.transmittance), (table.reflectance[there], row.reflectance)]
            {
                assert!((value / expected.value - 1.0).abs() < 1e-6, "{}", axes.describe(there / 3));
            }
        }
    }
}

#[test]
fn tables_on_any_axes_survive_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.nc");
    let table = fill(&axes());
    table.write(&path).unwrap();
    assert_eq!(file::read(&path).unwrap(), AnyTable::Full(table.clone()));
    let compressed = CompressedTable::new(&table, Space::Log, 2).unwrap();
    compressed.write(&path).unwrap();
    assert_eq!(file::read(&path).unwrap(), AnyTable::Compressed(compressed));
}

/// A merged table is the whole one to the last bit, and so is its file, whatever the order and number of the shards.
#[test]
fn shards_make_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fill(&axes()).write(&path("whole.nc")).unwrap();
    for of in [1, 4, 6] {
        let mut read = Vec::new();
        for (name, shard) in shards(of).into_iter().rev() {
            shard.write(&path(&name)).unwrap();
            let AnyTable::Shard(shard) = file::read(&path(&name)).unwrap() else { panic!("{name} is no shard") };
            read.push((name, shard));
        }
        shard::merge(&read).unwrap().write(&path("merged.nc")).unwrap();
        assert!(std::fs::read(path("whole.nc")).unwrap() == std::fs::read(path("merged.nc")).unwrap(), "{of} shards");
    }
}

#[test]
fn shards_that_do_not_belong_together_are_refused_by_name() {
    let message = |shards: &[(String, Shard)]| shard::merge(shards).unwrap_err().to_string();
    let all = shards(3);
    assert!(message(&all[..2]).ends_with("of 3 parts these are missing: 3"));
    assert!(
        message(&[&all[..], &[("again.nc".to_owned(), all[1].1.clone())]].concat()).contains("part2.nc and again.nc")
    );
    let mut other = all.clone();
    other[2].1.axes.thicknesses_cm[1] = 4.0;
    assert!(message(&other).contains("part3.nc has other axes than part1.nc"));
    let mut other = all.clone();
    other[1].1.metadata[0].1 = "another title".to_owned();
    assert!(message(&other).contains("part2.nc was made in another way than part1.nc"));
    let mut other = all.clone();
    other[2].1.arithmetic = "0".repeat(16);
    assert!(message(&other).contains("part3.nc was filled by another kind of processor"));
    assert!(message(&[all[0].clone(), shards(2)[1].clone()]).contains("has another number of parts"));
    assert!(message(&[]).contains("there are none"));
}

/// Monte Carlo fills the same table, within 4 of its standard errors and the tally's: 288 pairs of values, correlated.
#[test]
fn engines_fill_the_same_table() {
    let axes = Axes { grain_sizes_um: vec![400.0], facetness: vec![0.4], ..axes() };
    let options = FillOptions { engine: Engine::MonteCarlo { rays: 4_000 }, ..FillOptions::default() };
    let (walked, _) = fill::fill(&axes, &options, &|_, _| ()).unwrap();
    let solved = fill::fill(&axes, &FillOptions::by_ordinates(1 << 18), &|_, _| ()).unwrap().0;
    let errors = walked.errors.as_ref().unwrap();
    for (walked, solved, errors) in [
        (&walked.transmittance, &solved.transmittance, &errors[0]),
        (&walked.reflectance, &solved.reflectance, &errors[1]),
    ] {
        for (number, ((walked, solved), error)) in walked.iter().zip(solved).zip(errors).enumerate() {
            // The tally leaves some .2 %.
            let sigma = error.hypot(2e-3 * solved);
            assert!(
                (walked - solved).abs() < 4.0 * sigma,
                "{}: {walked} ± {error}, {solved}",
                axes.describe(number / 3)
            );
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walked.nc");
    walked.write(&path).unwrap();
    assert_eq!(file::read(&path).unwrap(), AnyTable::Full(walked));
}
