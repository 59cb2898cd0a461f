//! `snowblue export lut`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde_json::json;
use snowblue_database::compact::LookUpTable;
use snowblue_render::film::image_file::write_numbers_exr;

use super::compact_options::CompactOptions;
use crate::options::{GivenOptions, Idle};
use crate::output::{Failure, Outcome, check_path, ending, output_path, write_file};

/// Columns and rows of a table.
const SIZE: [u32; 2] = [256, 64];

/// A look-up table.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub(crate) struct TableFile {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    #[command(flatten)]
    compact: CompactOptions,
    /// What an .exr holds; a .json has both
    #[arg(long, value_name = "QUANTITY", default_value = "transmittance", value_enum, help_heading = "Output")]
    quantity: TableQuantity,
    /// File to write: .exr (32-bit floats, 256 thicknesses by 64 angles) or .json
    #[arg(short, long, value_name = "FILE", value_parser = output_path(), help_heading = "Output")]
    output: PathBuf,
}

/// What a table holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TableQuantity {
    Transmittance,
    Reflectance,
}

impl TableFile {
    pub(super) fn write(&self) -> Outcome {
        let is_exr = match &*ending(&self.output, "json") {
            "exr" => true,
            "json" => false,
            _ => return Err(Failure::Input(format!("{}: the table must end in .exr or .json", self.output.display()))),
        };
        check_path(&self.output)?;
        self.given.refuse_idle(&[Idle {
            when: !is_exr,
            options: &["quantity"],
            why: "a .json has both quantities",
        }])?;
        let snow = self.compact.fit()?;
        let table = snow.look_up_table(SIZE[0], SIZE[1]);
        let mut notes = self.compact.notes(&snow)?;
        let [transmitted, reflected] = snow.interpolation_errors(&table);
        notes.push(format!(
            "linear interpolation adds {transmitted:.1e} to transmittance, {reflected:.1e} to reflectance"
        ));
        notes.push("values: log2 of X, Y, Z; the light itself has Y = 1".to_owned());
        let (scale, greatest) = (snow.scale_m(), snow.greatest_thickness_m());
        notes.push(format!("first to last column: log(1 + h / {scale:.6e}) from 0 to that of h = {greatest} m"));
        notes.push(format!("multiply reflectance by h / (h + {scale:.6e})"));
        notes.push("first to last row: sqrt(cos) from that of 89 degrees to 1".to_owned());
        if is_exr {
            let notes: Vec<(&str, &str)> = notes.iter().map(|note| ("snow table", &**note)).collect();
            return write_numbers_exr(&self.rows(&table), &notes, &self.output).map_err(Failure::work);
        }
        let document = json!({
            "notes": notes,
            "thickness_m": table.thicknesses_m,
            "cos_incidence": table.cosines,
            "scale_m": scale,
            "log2_xyz_transmittance": table.transmittance,
            "log2_xyz_reflectance": table.reflectance,
        });
        write_file(&self.output, format!("{document:#}\n").as_bytes())
    }

    #[expect(clippy::cast_possible_truncation, reason = "an image has single precision")]
    fn rows(&self, table: &LookUpTable) -> Vec<Vec<[f32; 3]>> {
        let values = match self.quantity {
            TableQuantity::Transmittance => &table.transmittance,
            TableQuantity::Reflectance => &table.reflectance,
        };
        let texel = |xyz: &[f64; 3]| xyz.map(|value| value as f32);
        values.iter().map(|row| row.iter().map(texel).collect()).collect()
    }
}
