//! Figures and tables of the paper.

pub(crate) mod fig3;
pub(crate) mod fig5_8;
pub(crate) mod lprime;
mod paper_table;
pub(crate) mod renderings;
pub(crate) mod s1;
pub(crate) mod s2;
mod swatches;
pub(crate) mod table1;
