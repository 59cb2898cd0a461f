//! Coordinates in mesh files, and error messages about invalid coordinates.

use std::fmt::Display;
use std::str::FromStr;

use glam::Vec3;

/// Their names.
pub(super) const COORDINATES: [&str; 3] = ["x", "y", "z"];

/// Checks that the coordinates of a vertex are finite.
pub(super) fn check_finite(position: Vec3, vertex: impl Fn() -> String) -> Result<(), String> {
    match position.to_array().into_iter().zip(COORDINATES).find(|(value, _)| !value.is_finite()) {
        Some((value, name)) => Err(format!("coordinate {name} of {} is {value}, but must be finite", vertex())),
        None => Ok(()),
    }
}

/// Checks that the coordinates of all vertices are finite.
pub(super) fn check_all_finite(positions: &[Vec3]) -> Result<(), String> {
    let mut positions = positions.iter().enumerate();
    positions.try_for_each(|(number, position)| check_finite(*position, || format!("vertex {number}")))
}

/// Parses a word of a text file as a number. `quantity` names the quantity in the error message.
pub(super) fn number<T: FromStr>(word: &str, quantity: impl Display) -> Result<T, String> {
    word.parse().map_err(|_| {
        let hint = if word.contains(',') { " with a decimal point" } else { "" };
        format!("{quantity} is \"{word}\", but must be a number{hint}")
    })
}
