//! Snow in a browser: the functions that the web page calls.
//!
//! Requests and answers are JSON with the keys of the command and of scene files; arrays of vertices and pixels are
//! typed arrays. `web/src/native.d.ts` declares the JSON for TypeScript. Bad input throws an `Error` with the
//! message of the command.
//!
//! The page loads two modules: a small module of spectra, colours and light at depth, with the default feature
//! `spectrum`, and a module of light fields and pictures for its workers, with only the feature `scene`. A third, with
//! only the feature `meshes`, reads the mesh files of visitors. A browser runs each module on one thread.

use std::fmt::Display;

#[cfg(feature = "spectrum")]
mod sample;

#[cfg(feature = "spectrum")]
pub mod spectrum;
#[cfg(feature = "spectrum")]
pub mod sunlight;

#[cfg(feature = "spectrum")]
pub mod depth;
#[cfg(feature = "spectrum")]
pub mod measured;

#[cfg(feature = "spectrum")]
pub mod parameters;

#[cfg(feature = "scene")]
pub mod scene;

#[cfg(feature = "meshes")]
pub mod meshes;

/// The message of an error.
fn text(error: impl Display) -> String {
    error.to_string()
}
