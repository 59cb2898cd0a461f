//! Look-up of spectra: one snow sample at any thickness and angle of incidence (Algorithm 1 of Varsa & Baranoski 2024).
//!
//! The coefficients of the principal components are interpolated over thickness and angle, then C' V'ᵀ is evaluated
//! once. The interpolation follows the table's space:
//!
//! - `linear`, the paper's (`SplineGrid`): a cubic spline over the thickness at the two nearest angles, then linear
//!   interpolation between them. The spline passes through transmittance 1 at 0 cm and 0 at 100 cm; beyond 100 cm and
//!   beyond the last angle transmittance is 0. The spline overshoots between the knots, like the paper's spline. The
//!   sample must be a sample of the table.
//! - `log`, ours (`ResampledGrid`): the spline of ln T passes through 0 at 0 cm and continues as a straight line
//!   beyond the last knot, since light decays exponentially deep in snow (where that line would rise, it stays
//!   constant); between angles, a cubic. Angles beyond the last angle are looked up at the last angle. Everything is
//!   precomputed on a fine grid, for any sample within the axes (`blend`).
//!
//! Reflectance is interpolated like transmittance, but in log space over ln h: reflectance is proportional to the
//! thickness of thin layers and levels off in thick layers.
//!
//! [`SnowMix`] interpolates between two samples. [`ProjectedTable`] holds a sample's spectra already projected on the
//! few sums that the colours of one light source need.

mod basis;
mod coefficient_grids;
mod pca_snow;
mod projected;

pub use basis::{PADDED_COMPONENTS, PaddedCoefficients};
pub use pca_snow::{HORIZON_DEG, PAPER_BLACK_THICKNESS_CM, PAPER_LAST_ANGLE_DEG, PcaSnow, SnowMix};
pub use projected::{PROJECTIONS, ProjectedTable};
