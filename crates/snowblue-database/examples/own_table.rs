//! Makes a table of one's own: choose axes, fill, compress, evaluate the errors, write, read, look up.
//!
//! `cargo run --release -p snowblue-database --example own_table -- [FILE.nc]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

use std::path::PathBuf;

use snowblue_color::Illuminant;
use snowblue_database::fidelity;
use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{FillOptions, fill};
use snowblue_database::{
    Axes, CompressedTable, DatabaseError, PcaSnow, Property, PropertyAxis, Quantity, Space, TableSample,
};
use snowblue_transport::optics::Substance;

fn main() -> Result<(), DatabaseError> {
    let default = || std::env::temp_dir().join("sooty-snow.nc");
    let path = std::env::args_os().nth(1).map_or_else(default, PathBuf::from);

    // 1. Axes. Start from the paper's and replace what differs: here old snow with soot, at three angles.
    let soot = Property::Impurity(Substance::BLACK_CARBON);
    let axes = Axes {
        grain_sizes_um: vec![400.0, 600.0, 900.0],
        facetness: vec![0.1],
        densities_kg_m3: vec![350.0],
        properties: vec![PropertyAxis { property: soot, values: vec![0.0, 10.0, 50.0, 200.0] }],
        angles_deg: vec![0.0, 40.0, 70.0],
        ..Axes::with_thin_and_thick_knots()
    };

    // 2. Fill. Few rays are quick and noisy; `FillOptions::default()` has 2²⁰.
    let table = fill(&axes, &FillOptions::by_ordinates(1 << 12), &|_| ())?;
    println!("{} curves of {} samples", axes.curves(), axes.samples());

    // 3. Compress, and compare the rebuilt curves with the originals.
    let compressed = CompressedTable::new(&table, Space::Log, Space::Log.default_components())?;
    for quantity in Quantity::ALL {
        let components = compressed.components(quantity);
        let errors = fidelity::evaluate(&table, quantity, components, Space::Log, Some(Illuminant::D65))?;
        println!("{}: RMSE ≤ {:.1e}, ΔE*ab ≤ {:.3}", quantity.name(), errors.rmse.worst, errors.delta_e.worst);
    }

    // 4. Write a NetCDF file, and read it again.
    compressed.write(&path)?;
    let AnyTable::Compressed(compressed) = file::read(&path)? else { return Ok(()) };
    println!("wrote {}", path.display());

    // 5. Look up: any sample, thickness and angle within the axes.
    for soot_ng_g in [0.0, 30.0, 100.0] {
        let sample = TableSample::new(500.0, 0.1, 400.0).with(soot, soot_ng_g);
        let snow = PcaSnow::new(&compressed, &sample)?;
        let mut transmittance = vec![0.0; snow.wavelengths_nm().len()];
        snow.transmittance(20.0, 30.0, &mut transmittance);
        println!(
            "{soot_ng_g:>4} ng/g of soot: 20 cm transmit {:.5} at 450 nm, {:.5} at 650 nm",
            transmittance[5], transmittance[25]
        );
    }
    Ok(())
}
