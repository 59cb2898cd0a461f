//! Names in files beside those of axes and quantities.

pub(super) const COMPONENT: &str = "component";
pub(super) const SINGULAR_VALUE: &str = "singular_value";
/// Ending of the names of packed coefficients.
pub(super) const PACKED_SUFFIX: &str = "_packed";
/// Dimensions of the bytes of packed coefficients, of transmittance and reflectance.
pub(super) const PACKED_DIMENSIONS: [&str; 2] = ["transmittance_byte", "reflectance_byte"];
/// The attribute of packed coefficients that has their step.
pub(super) const STEP: &str = "packing_step";
pub(super) const SPACE: &str = "space";
pub(super) const SHARD: &str = "shard";
pub(super) const ARITHMETIC: &str = "arithmetic";
pub(super) const GRAIN: &str = "grain";
pub(super) const SAMPLE: &str = "sample";
pub(super) const SHARD_DIMENSIONS: [&str; 5] = [GRAIN, SAMPLE, "angle", "thickness", "wavelength"];
/// Ending of the names of standard errors.
pub(super) const ERROR_SUFFIX: &str = "_standard_error";
/// The attribute that names the conventions of a file.
pub(super) const CONVENTIONS: &str = "Conventions";
