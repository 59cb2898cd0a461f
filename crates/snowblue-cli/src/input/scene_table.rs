//! The table from which the snow of a scene takes its curves.

use std::borrow::Cow;
use std::path::Path;

use snowblue_database::CompressedTable;
use snowblue_database::file::{self, AnyTable};

use crate::output::Failure;

/// The compressed table in a file, or the embedded one.
pub(crate) fn scene_table(path: Option<&Path>) -> Result<Cow<'static, CompressedTable>, Failure> {
    let Some(path) = path else { return Ok(Cow::Borrowed(snowblue_data::embedded())) };
    let name = path.display();
    match file::read(path).map_err(Failure::input)? {
        AnyTable::Compressed(table) => Ok(Cow::Owned(table)),
        other => Err(Failure::Input(format!(
            "{name}: is {}, but rendering needs a compressed table{}",
            other.kind(),
            match other {
                AnyTable::Full(_) => format!(": snowblue merge {name} --space log --components 3 -o FILE.nc"),
                _ => String::new(),
            }
        ))),
    }
}
