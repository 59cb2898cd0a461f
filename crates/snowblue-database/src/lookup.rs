//! Interface stub.

/// One sample's curves, ready to be looked up (the paper's PCASnow, Algorithm 1).
#[derive(Debug, Clone)]
pub struct PcaSnow {}

/// A sample by its table axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridSample {
    /// Mean grain size in µm.
    pub grain_size_um: f64,
    /// Facetness.
    pub facetness: f64,
    /// Density in kg/m³.
    pub density_kg_m3: f64,
}

/// Error.
#[derive(Debug, thiserror::Error)]
pub enum LookupError {
    /// Not on the grid.
    #[error("grain size ...")]
    OffGrid,
}

/// Stub of the compressed table.
#[derive(Debug, Clone)]
pub struct CompressedTable {}

impl PcaSnow {
    /// New.
    ///
    /// # Errors
    /// When the sample is not a grid value of the table.
    pub fn new(_table: &CompressedTable, _sample: GridSample) -> Result<Self, LookupError> {
        todo!()
    }
    /// Wavelengths in nm.
    pub fn wavelengths_nm(&self) -> &[f64] {
        todo!()
    }
    /// Transmittance per wavelength through `thickness_cm` at `angle_deg` from the normal, into `out`.
    pub fn transmittance(&self, _thickness_cm: f32, _angle_deg: f32, _out: &mut [f32]) {
        todo!()
    }
    /// Reflectance per wavelength.
    pub fn reflectance(&self, _thickness_cm: f32, _angle_deg: f32, _out: &mut [f32]) {
        todo!()
    }
}
