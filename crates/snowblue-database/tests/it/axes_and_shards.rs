//! Tables on any axes, by either engine, in parts and merged.

use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{self, Engine, FillOptions};
use snowblue_database::shard::{self, NamedShard, Part};
use snowblue_database::{Axes, CompressedTable, Property, PropertyAxis, Quantity, Space, Table};
use snowblue_transport::optics::Substance;
use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::slab::{Radiometry, Slab};

const TALLY_RAYS: u32 = 1 << 12;

fn axes() -> Axes {
    Axes {
        grain_sizes_um: vec![200.0, 400.0, 900.0],
        facetness: vec![0.2, 0.6],
        densities_kg_m3: vec![250.0, 400.0],
        properties: vec![
            PropertyAxis { property: Property::WaterSaturation, values: vec![0.0, 0.2] },
            PropertyAxis { property: Property::Impurity(Substance::BLACK_CARBON), values: vec![0.0, 50.0] },
        ],
        diffuse: true,
        angles_deg: vec![0.0, 60.0],
        thicknesses_cm: vec![0.5, 3.0],
        wavelengths_nm: vec![400.0, 550.0, 700.0],
    }
}

fn fill(axes: &Axes) -> Table {
    fill::fill(axes, &FillOptions::by_ordinates(TALLY_RAYS), &|_| ()).unwrap()
}

fn shards(of: usize) -> Vec<NamedShard> {
    let part = |number| {
        let part = Part { number, of };
        let options = FillOptions::by_ordinates(TALLY_RAYS);
        let shard = shard::fill_part(&axes(), &options, part, &|_| ()).unwrap();
        NamedShard { name: format!("part{number}.nc"), shard }
    };
    (1..=of).map(part).collect()
}

/// Every sample of a table, wet or with impurities, under any light, is the engine's result for that sample alone. The
/// tallies differ only in the ends of the grid of absorptions, which change its interpolation by 10⁻⁹.
#[test]
fn values_are_those_of_single_samples() {
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
        for (place, Radiometry { fluxes, .. }) in solved.iter().enumerate() {
            // In the engine's results the light runs faster than the thickness, in the table slower.
            let (rest, w) = (place / 3, place % 3);
            let (thickness, light) = (rest / lights, rest % lights);
            let there = number * per_sample + (light * axes.thicknesses_cm.len() + thickness) * 3 + w;
            for (value, expected) in
                [(table.transmittance[there], fluxes.transmittance), (table.reflectance[there], fluxes.reflectance)]
            {
                assert!((value / expected.value - 1.0).abs() < 1e-6, "{}", axes.describe(there / 3));
            }
        }
    }
}

#[test]
fn tables_on_any_axes_are_read_as_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.nc");
    let table = fill(&axes());
    table.write(&path).unwrap();
    assert_eq!(file::read(&path).unwrap(), AnyTable::Full(table.clone()));
    for space in [Space::Linear, Space::Log] {
        let compressed = CompressedTable::new(&table, space, 2).unwrap();
        compressed.write(&path).unwrap();
        assert_eq!(file::read(&path).unwrap(), AnyTable::Compressed(compressed));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "a partial file remains");
}

/// The file of a merged table is bit for bit that of the whole table, for any order and number of shards.
#[test]
fn merged_shards_are_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fill(&axes()).write(&path("whole.nc")).unwrap();
    for of in [1, 4, 6] {
        let mut read = Vec::new();
        for NamedShard { name, shard } in shards(of).into_iter().rev() {
            shard.write(&path(&name)).unwrap();
            let AnyTable::Shard(shard) = file::read(&path(&name)).unwrap() else { panic!("{name} is no shard") };
            read.push(NamedShard { name, shard });
        }
        shard::merge(&read).unwrap().write(&path("merged.nc")).unwrap();
        assert!(std::fs::read(path("whole.nc")).unwrap() == std::fs::read(path("merged.nc")).unwrap(), "{of} shards");
    }
}

#[test]
fn shards_of_different_tables_are_refused_by_name() {
    let message = |shards: &[NamedShard]| shard::merge(shards).unwrap_err().to_string();
    let all = shards(3);
    assert!(message(&all[..2]).ends_with("of 3 parts these are missing: 3"));
    assert!(
        message(&[&all[..], &[NamedShard { name: "again.nc".to_owned(), ..all[1].clone() }]].concat())
            .contains("part2.nc and again.nc")
    );
    let mut other = all.clone();
    other[2].shard.axes.thicknesses_cm[1] = 4.0;
    assert!(message(&other).contains("part3.nc has other axes than part1.nc"));
    let mut other = all.clone();
    other[1].shard.metadata[0].value = "another title".to_owned();
    assert!(message(&other).contains("part2.nc was filled with other options than part1.nc"));
    let mut other = all.clone();
    other[2].shard.arithmetic = "0".repeat(16);
    assert!(message(&other).contains("part3.nc was filled by another kind of processor"));
    assert!(message(&[all[0].clone(), shards(2)[1].clone()]).contains("has another number of parts"));
    assert!(message(&[]).contains("there are none"));
}

/// Monte Carlo fills the same table within 4 standard errors, its own and the tally's: 288 correlated pairs of values.
#[test]
fn engines_fill_the_same_table() {
    // Thin snow, in which random walks end soon.
    let axes = Axes { grain_sizes_um: vec![400.0], facetness: vec![0.4], thicknesses_cm: vec![0.3, 1.0], ..axes() };
    let options = FillOptions { engine: Engine::MonteCarlo { rays: 4_000 }, ..FillOptions::default() };
    let traced = fill::fill(&axes, &options, &|_| ()).unwrap();
    let solved = fill::fill(&axes, &FillOptions::by_ordinates(1 << 18), &|_| ()).unwrap();
    let errors = traced.errors.as_ref().unwrap();
    for quantity in Quantity::ALL {
        let pairs = traced.values(quantity).iter().zip(solved.values(quantity));
        for (number, ((traced, solved), error)) in pairs.zip(errors.of(quantity)).enumerate() {
            // The noise of the tally is about 0.2 %.
            let sigma = error.hypot(2e-3 * solved);
            assert!(
                (traced - solved).abs() < 4.0 * sigma,
                "{}: {traced} ± {error}, {solved}",
                axes.describe(number / 3)
            );
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("traced.nc");
    traced.write(&path).unwrap();
    assert_eq!(file::read(&path).unwrap(), AnyTable::Full(traced));
}
