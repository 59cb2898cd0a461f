//! The integration tests of `snowblue-color` in one program.

mod gamut;
mod published;
mod sampling;
