//! Snow in a browser: what the web page calls.
//!
//! Requests and answers are JSON with the keys of the command and of scene files; arrays of vertices and pixels are
//! typed arrays. `web/src/native.d.ts` declares all of it for TypeScript. Bad input throws an `Error` with the words of
//! the command.
//!
//! The page loads two modules: one of spectra and colours, which is small, and with the feature `scene` one of light
//! fields and pictures, for its workers. A browser runs each on one thread.

mod snow;

pub mod spectrum;

pub mod parameters;

#[cfg(feature = "scene")]
pub mod scene;
