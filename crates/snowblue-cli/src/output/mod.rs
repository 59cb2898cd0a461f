//! What the command prints and writes: results, pictures, progress, errors and exit codes.

mod printable;
mod statistics;
mod terminal;

mod failure;
mod files;
mod memory;
mod phases;
mod progress;

pub(crate) mod color_row;
mod picture_file;
mod report;

pub(crate) use failure::{Failure, INTERRUPTED, Outcome, exit_code};
pub(crate) use files::{
    check_extension, check_not_input, check_path, check_table_path, create_folder, ending, output_path, write_file,
};
pub(crate) use phases::Phases;
pub(crate) use picture_file::{PictureFile, PictureFormat, SCENE_NOTE, TABLE_NOTE, describe_samples};
pub(crate) use printable::printable;
pub(crate) use progress::Progress;
pub(crate) use report::{Format, OutputOptions};
pub(crate) use statistics::statistics_table;
pub(crate) use terminal::{print, print_message, print_notes};
