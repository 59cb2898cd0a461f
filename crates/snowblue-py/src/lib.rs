//! The native part of the Python package `snowblue`: it converts arguments and results, and calls the crates below.
//!
//! Arrays are flat; the Python part gives them dimensions, names and units. Long work runs on a thread of its own, so
//! that Python handles signals and shows progress meanwhile ([`work`]). Bad input raises `ValueError` with the
//! message of the command.

mod work;

mod arguments;

mod snow;

mod spectra;

mod color;

mod database;

mod inversion;

mod scene;

mod sky;

/// The native part of `snowblue`.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::color::{colors, draw_swatches, illuminants, match_color};
    #[pymodule_export]
    use super::database::Table;
    #[pymodule_export]
    use super::inversion::invert;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::sky::{daylight_wavelengths, sky, sun_of_day, sun_position, sunlight};
    #[pymodule_export]
    use super::snow::{
        Snows, aged_surface_area, declare_substance, parameters, properties, single_scattering, substances,
        uncertain_properties, wavelength_range,
    };
    #[pymodule_export]
    use super::spectra::{band_weights, brf, bsdf, covered_bands, light_in_layers, spectrum, spread, stacks};

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "a Python name")]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    /// Greatest angle of a beam from the normal, in degrees.
    #[pymodule_export]
    const GREATEST_ANGLE_DEG: f64 = snowblue_transport::parameters::ANGLE.range.greatest;

    /// Least and greatest size of a lightmap.
    #[pymodule_export]
    const LIGHTMAP_SIZES: (u32, u32) =
        (*snowblue_render::bake::LIGHTMAP_SIZES.start(), *snowblue_render::bake::LIGHTMAP_SIZES.end());
}
