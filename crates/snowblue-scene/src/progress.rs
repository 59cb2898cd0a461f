//! Progress of the work on a picture or on baked light.

/// A phase of the work. Phases come in this order; a phase may be absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// The objects of the scene are read and made.
    Meshes,
    /// A first picture with coarse cells, without relief.
    Preview,
    /// The relief of snow is added.
    Relief,
    /// The optics of the snow of each material.
    Snow,
    /// Bodies of snow are divided into cells.
    Cells,
    /// The light in the snow is solved for. Each step is a solution in a body. The number of steps is not known in
    /// advance.
    Light,
    /// The surface of an object is laid flat for a lightmap.
    Charts,
    /// The light to be baked is computed for one lamp after the other.
    Lamps,
    /// Texels of a lightmap are read.
    Texels,
    /// Samples of pixels.
    Samples,
}

impl Phase {
    /// The name of the phase.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Meshes => "meshes",
            Self::Preview => "preview",
            Self::Relief => "relief",
            Self::Snow => "snow",
            Self::Cells => "cells",
            Self::Light => "light",
            Self::Charts => "charts",
            Self::Lamps => "lamps",
            Self::Texels => "texels",
            Self::Samples => "samples",
        }
    }

    /// The name of the steps of the phase.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Meshes | Self::Relief => "objects",
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

/// The state of the work.
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
