//! How deep random walks end in the light field.

use snowblue_transport::monte_carlo::WalkEnds;

/// How deep random walks end in the light field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndDepth {
    /// Under a surface with thick snow below, far from edges for the mean free paths of light.
    Thick,
    /// Near edges, and in bodies that are small or thin.
    Thin,
}

impl EndDepth {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Thick, Self::Thin];

    /// The depth below the nearest surface from which on walks end, in transport mean free paths.
    ///
    /// Under flat surfaces light is diffuse from one on: the radiance is right within 1 %, under a torus of 25 and a
    /// ball of 10 within 3 %. Nearer to an edge than 10 it loses 7 % with an end at 1, 3 % at 2. An end at 1 halves the
    /// noise.
    pub const fn lengths(self) -> f32 {
        match self {
            Self::Thick => 1.0,
            Self::Thin => 2.0,
        }
    }

    /// Depth below the entry of the point that the light of a tangent half-space is matched to, in transport mean free
    /// paths: near the ends of walks.
    pub fn match_lengths(self) -> f32 {
        self.lengths() + 1.0
    }
}

/// Where random walks end, for each depth.
pub type WalkEndsByDepth = [WalkEnds; EndDepth::ALL.len()];
