//! The hash of a table of curves, by which pictures tell what they were made from.

use snowblue_database::{CompressedTable, Space};

use snowblue_base::hash::Fnv1a;

/// The hash of a table of curves.
pub(in crate::integrators) fn table_hash(table: &CompressedTable) -> u64 {
    let mut hash = Fnv1a::default();
    let axes = &table.axes;
    let mut add_axis = |name: &str, values: &[f64]| {
        hash.add(name.as_bytes());
        hash.add(&(values.len() as u64).to_le_bytes());
        values.iter().for_each(|value| hash.add(&value.to_le_bytes()));
    };
    add_axis("grain size", &axes.grain_sizes_um);
    add_axis("facetness", &axes.facetness);
    add_axis("density", &axes.densities_kg_m3);
    axes.properties.iter().for_each(|axis| add_axis(axis.property.name(), &axis.values));
    add_axis(if axes.diffuse { "diffuse and angle" } else { "angle" }, &axes.angles_deg);
    add_axis("thickness", &axes.thicknesses_cm);
    add_axis("wavelength", &axes.wavelengths_nm);
    hash.add(match table.space {
        Space::Linear => b"linear",
        Space::Log => b"log",
    });
    for components in [&table.transmittance, &table.reflectance] {
        for number in components.coefficients.iter().chain(&components.basis) {
            hash.add(&number.to_le_bytes());
        }
    }
    hash.value()
}
