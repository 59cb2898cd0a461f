//! Curves of snow on named axes.
pub mod lookup;
