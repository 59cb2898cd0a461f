//! Where the work on a picture or on baked light stands.

/// A phase of the work. Phases come in this order, and some works lack some.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// The objects of the scene are read and made.
    Meshes,
    /// A first picture with coarse cells.
    Preview,
    /// The optics of the snow of each material.
    Snow,
    /// Bodies of snow are divided into cells.
    Cells,
    /// The light in the snow is solved for. Its steps are solutions in a body, of which the number is not known before.
    Light,
    /// The surface of an object is laid flat for a lightmap.
    Charts,
    /// The light of one lamp after the other, to be baked.
    Lamps,
    /// Texels of a lightmap are read.
    Texels,
    /// Samples of pixels.
    Samples,
}

impl Phase {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Meshes => "meshes",
            Self::Preview => "preview",
            Self::Snow => "snow",
            Self::Cells => "cells",
            Self::Light => "light",
            Self::Charts => "charts",
            Self::Lamps => "lamps",
            Self::Texels => "texels",
            Self::Samples => "samples",
        }
    }

    /// What its steps are.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Meshes => "objects",
            Self::Preview => "pictures",
            Self::Snow => "materials",
            Self::Cells => "bodies",
            Self::Light => "solutions",
            Self::Charts => "triangles",
            Self::Lamps => "lamps",
            Self::Texels => "texels",
            Self::Samples => "samples",
        }
    }
}

/// Where the work stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// The present phase.
    pub phase: Phase,
    /// Steps of the phase that are done.
    pub done: u64,
    /// All steps of the phase; 0 where their number is not known yet.
    pub total: u64,
}

/// Receives the progress. Any thread calls it. It may unwind to stop the work.
pub type Report<'a> = &'a (dyn Fn(Progress) + Sync);
