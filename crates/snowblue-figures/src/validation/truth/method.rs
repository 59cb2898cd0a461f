//! The ways of rendering that are compared.

use snowblue_render::scene::{IntegratorKind, PathMode};

/// A way of rendering snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Method {
    PcaSnow(PathMode),
    Diffusion,
    Hybrid,
    Reference,
}

impl Method {
    /// Those that are compared with the reference.
    pub(super) const COMPARED: [Self; 6] = [
        Self::PcaSnow(PathMode::View),
        Self::PcaSnow(PathMode::Normal),
        Self::PcaSnow(PathMode::Light),
        Self::PcaSnow(PathMode::Brightest),
        Self::Diffusion,
        Self::Hybrid,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::PcaSnow(mode) => mode.name(),
            _ => self.integrator().name(),
        }
    }

    pub(super) fn integrator(self) -> IntegratorKind {
        match self {
            Self::PcaSnow(_) => IntegratorKind::PcaSnow,
            Self::Diffusion => IntegratorKind::Diffusion,
            Self::Hybrid => IntegratorKind::Hybrid,
            Self::Reference => IntegratorKind::Reference,
        }
    }

    /// Samples per pixel. PCASnow and diffusion have no noise but that of edges and shadows.
    pub(super) fn samples(self) -> u32 {
        if self == Self::Hybrid { 1024 } else { 256 }
    }
}
