//! Kinds of snow by name, after the International Classification for Seasonal Snow on the Ground (Fierz et al. 2009).
//!
//! The classification is by shape; optics depends on the specific surface area and the density. Each kind has a
//! typical, measured value of both ([`SnowType::source`] says where a value is chosen instead). Within a kind both
//! vary by a factor of two. Measured shapes, by their asymmetry and mean path in ice, vary as much within kinds as
//! between kinds (the micro-tomograms of Letcher et al. 2022), so all kinds share one sphericity and one facetness.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::grain_size::GrainSize;
use super::snow_sample::SnowSample;
use crate::error::{TransportError, find_by_name};

/// A kind of snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SnowType {
    /// Precipitation particles (PP): new snow.
    Fresh,
    /// Rounded grains (RG): settled for days.
    Rounded,
    /// Faceted crystals (FC): grown under a temperature gradient.
    Faceted,
    /// Wind-packed rounded grains (RGwp).
    WindPacked,
    /// Melt forms (MF): coarse grains of a melting or refrozen pack.
    MeltForms,
    /// Firn: snow that has survived a summer.
    Firn,
}

impl SnowType {
    /// Every kind.
    pub const ALL: [Self; 6] =
        [Self::Fresh, Self::Rounded, Self::Faceted, Self::WindPacked, Self::MeltForms, Self::Firn];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fresh => "fresh",
            Self::Rounded => "rounded",
            Self::Faceted => "faceted",
            Self::WindPacked => "wind-packed",
            Self::MeltForms => "melt-forms",
            Self::Firn => "firn",
        }
    }

    /// Specific surface area, in m²/kg.
    #[must_use]
    pub fn surface_area_m2_kg(self) -> f64 {
        match self {
            Self::Fresh => 80.0,
            Self::Rounded => 25.0,
            Self::Faceted => 13.0,
            Self::WindPacked => 20.0,
            Self::MeltForms => 3.0,
            Self::Firn => 6.0,
        }
    }

    /// Density, in kg/m³.
    #[must_use]
    pub fn density_kg_m3(self) -> f64 {
        match self {
            Self::Fresh => 80.0,
            Self::Rounded => 250.0,
            Self::Faceted => 290.0,
            Self::WindPacked => 380.0,
            Self::MeltForms => 450.0,
            Self::Firn => 600.0,
        }
    }

    /// Sources of the specific surface area and the density.
    #[must_use]
    pub fn source(self) -> &'static str {
        match self {
            Self::Fresh => {
                "61–154 m²/kg on falling: Cabanes et al. 2003, doi:10.1021/es025880r; 81 kg/m³ where it is softest: \
                 Geldsetzer & Jamieson 2000"
            }
            Self::Rounded => {
                "26 m²/kg after six days: Cabanes et al. 2003, doi:10.1021/es025880r; 202–273 kg/m³ at middling \
                 hardness: Geldsetzer & Jamieson 2000"
            }
            Self::Faceted => "12.7 ± 2.5 m²/kg and 289 ± 35 kg/m³, 11 samples: Letcher et al. 2022, supporting data",
            Self::WindPacked => {
                "19–23 m²/kg in hard windpacks: Gallet et al. 2011, doi:10.5194/tc-5-631-2011; 394 kg/m³ where it is \
                 hardest: Geldsetzer & Jamieson 2000"
            }
            Self::MeltForms => {
                "below 3 m²/kg at a melting surface: Vérin et al. 2022, The Cryosphere 16, 3431; the density is chosen"
            }
            Self::Firn => "400–830 kg/m³: Cuffey & Paterson 2010; the surface area, of .5 mm radius, is chosen",
        }
    }

    /// Dry and clean snow of this kind.
    ///
    /// ```
    /// # use snowblue_transport::sample::SnowType;
    /// // Fresh snow has a higher extinction coefficient than firn at a fifth of its density.
    /// let (fresh, firn) = (SnowType::Fresh.sample()?, SnowType::Firn.sample()?);
    /// assert!(fresh.density_kg_m3 < 0.2 * firn.density_kg_m3 && fresh.extinction_per_m() > firn.extinction_per_m());
    /// # Ok::<(), snowblue_transport::TransportError>(())
    /// ```
    ///
    /// # Errors
    /// Never for the present kinds, whose grains lie within the model's range.
    pub fn sample(self) -> Result<SnowSample, TransportError> {
        let default = SnowSample::default();
        let grain_size = GrainSize::from_specific_surface_area(self.surface_area_m2_kg(), default.temperature_c)?;
        Ok(SnowSample { grain_size, density_kg_m3: self.density_kg_m3(), ..default })
    }
}

/// Formats the name.
impl fmt::Display for SnowType {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

impl FromStr for SnowType {
    type Err = TransportError;

    fn from_str(name: &str) -> Result<Self, TransportError> {
        find_by_name("snow", name, &Self::ALL, Self::name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_valid() {
        for kind in SnowType::ALL {
            let sample = kind.sample().unwrap();
            sample.check().unwrap();
            // κ = ρ SSA / 4 for convex grains.
            let expected = 0.25 * kind.density_kg_m3() * kind.surface_area_m2_kg();
            assert!((sample.extinction_per_m() / expected - 1.0).abs() < 1e-12, "{kind}");
        }
    }
}
