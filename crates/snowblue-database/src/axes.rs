//! The axes of a table: what snow, how thick, under what light, at which wavelengths.

use crate::DatabaseError;

/// Values along each axis, ascending. The last axis runs fastest in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    /// Mean grain sizes (greatest extension), in µm; each stands for a range of ± 50 µm.
    pub grain_sizes_um: Vec<f64>,
    /// Mean facetness.
    pub facetness: Vec<f64>,
    /// Densities, in kg/m³.
    pub densities_kg_m3: Vec<f64>,
    /// Angles of incidence from the normal, in degrees.
    pub angles_deg: Vec<f64>,
    /// Thicknesses, in cm.
    pub thicknesses_cm: Vec<f64>,
    /// Wavelengths, in nm.
    pub wavelengths_nm: Vec<f64>,
}

/// Greatest angle of incidence, in degrees.
const MOST_ANGLE_DEG: f64 = 89.99;
/// Thin and thick knots beside the paper's thicknesses, in cm, for splines that hold from nothing to a metre of snow.
const THIN_KNOTS_CM: [f64; 11] = [0.000_5, 0.001, 0.002, 0.004, 0.008, 0.015, 0.03, 0.06, 0.12, 0.25, 0.5];
const THICK_KNOTS_CM: [f64; 2] = [70.0, 100.0];

impl Axes {
    /// Table 1 of the paper (Varsa & Baranoski 2024): 225 samples, 24,750 curves of 31 wavelengths.
    ///
    /// ```
    /// # use snowblue_database::Axes;
    /// assert_eq!(Axes::paper().curves(), 24_750);
    /// ```
    #[must_use]
    pub fn paper() -> Self {
        Self {
            grain_sizes_um: steps(100, 500, 50),
            facetness: vec![0.1, 0.3, 0.5, 0.7, 0.9],
            densities_kg_m3: steps(200, 400, 50),
            angles_deg: [steps(0, 80, 10), vec![89.0]].concat(),
            thicknesses_cm: vec![1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 25.0, 35.0, 50.0],
            wavelengths_nm: steps(400, 700, 10),
        }
    }

    /// The paper's axes with thin and thick knots, as in the embedded table.
    #[must_use]
    pub fn with_thin_and_thick_knots() -> Self {
        let paper = Self::paper();
        let thicknesses_cm = [&THIN_KNOTS_CM[..], &paper.thicknesses_cm, &THICK_KNOTS_CM].concat();
        Self { thicknesses_cm, ..paper }
    }

    /// Every axis by its name in files, with its unit and values, slowest first.
    #[must_use]
    pub fn named(&self) -> [(&'static str, &'static str, &[f64]); 6] {
        [
            ("grain_size", "um", &self.grain_sizes_um),
            ("facetness", "1", &self.facetness),
            ("density", "kg m-3", &self.densities_kg_m3),
            ("angle", "degree", &self.angles_deg),
            ("thickness", "cm", &self.thicknesses_cm),
            ("wavelength", "nm", &self.wavelengths_nm),
        ]
    }

    /// Number of curves.
    #[must_use]
    pub fn curves(&self) -> usize {
        self.samples() * self.curves_per_sample()
    }

    /// Number of snow samples: sizes × facetness × densities.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.grain_sizes_um.len() * self.facetness.len() * self.densities_kg_m3.len()
    }

    /// Curves of one sample, which lie side by side: angles × thicknesses.
    #[must_use]
    pub fn curves_per_sample(&self) -> usize {
        self.angles_deg.len() * self.thicknesses_cm.len()
    }

    /// What a curve belongs to, as words: for reports of worst cases.
    #[must_use]
    pub fn describe(&self, curve: usize) -> String {
        let (curve, thickness) = (curve / self.thicknesses_cm.len(), curve % self.thicknesses_cm.len());
        let (sample, angle) = (curve / self.angles_deg.len(), curve % self.angles_deg.len());
        let (grain, density) = (sample / self.densities_kg_m3.len(), sample % self.densities_kg_m3.len());
        let (size, facetness) = (grain / self.facetness.len(), grain % self.facetness.len());
        format!(
            "{} µm, facetness {}, {} kg/m³, {} cm, {}°",
            self.grain_sizes_um[size],
            self.facetness[facetness],
            self.densities_kg_m3[density],
            self.thicknesses_cm[thickness],
            self.angles_deg[angle],
        )
    }

    /// Checks that every axis has finite values in ascending order, that there are two thicknesses or more, all above
    /// 0 cm, and that angles lie in 0–89.99°.
    ///
    /// # Errors
    /// [`DatabaseError::Axis`] or [`DatabaseError::AxisRange`] for the first axis that is otherwise.
    pub fn check(&self) -> Result<(), DatabaseError> {
        for (name, _, values) in self.named() {
            let ascending = values.is_sorted_by(|a, b| a < b) && values.iter().all(|value| value.is_finite());
            if values.is_empty() || !ascending {
                return Err(DatabaseError::Axis { name });
            }
        }
        // A thickness of 0 is not a knot: look-ups know what no snow does.
        if self.thicknesses_cm.len() < 2 || self.thicknesses_cm[0] <= 0.0 {
            return Err(DatabaseError::AxisRange { name: "thickness", what: "two values or more, all above 0 cm" });
        }
        if self.angles_deg[0] < 0.0 || self.angles_deg[self.angles_deg.len() - 1] > MOST_ANGLE_DEG {
            return Err(DatabaseError::AxisRange { name: "angle", what: "values in 0–89.99°" });
        }
        Ok(())
    }
}

fn steps(first: u32, last: u32, step: usize) -> Vec<f64> {
    (first..=last).step_by(step).map(f64::from).collect()
}
