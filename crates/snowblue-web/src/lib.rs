//! Snow in a browser: what the web page calls.
//!
//! Requests and answers are JSON with the keys of the command and of scene files; arrays of vertices and pixels are
//! typed arrays. `web/src/native.d.ts` declares all of it for TypeScript. Bad input throws an `Error` with the words of
//! the command.
//!
//! The page loads two modules: with the default feature `spectrum` one of spectra, colours and light at depth, which is
//! small, and with the feature `scene` alone one of light fields and pictures, for its workers. A browser runs each on
//! one thread.

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

/// The words of an error.
fn text(error: impl Display) -> String {
    error.to_string()
}
