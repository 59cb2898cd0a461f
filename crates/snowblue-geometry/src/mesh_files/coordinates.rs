//! Coordinates in mesh files, and what is said of wrong ones.

use std::fmt::Display;

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

/// The number that a word of a text file is; `quantity` says what it stands for.
pub(super) fn number(word: &str, quantity: impl Display) -> Result<f32, String> {
    word.parse().map_err(|_| {
        let hint = if word.contains(',') { " with a decimal point" } else { "" };
        format!("{quantity} is \"{word}\", but must be a number{hint}")
    })
}
