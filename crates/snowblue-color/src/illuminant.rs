//! Standard illuminants: relative spectral power, tabulated by the CIE.
//!
//! CIE 015:2018, *Colorimetry*, doi:10.25039/TR.015.2018; the files and their ranges are listed in `data/SOURCES.md`.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::sync::LazyLock;

use crate::curve::{self, Curve};
use crate::error::ColorError;

/// CIE name and table of each illuminant.
static ENTRIES: [(&str, &str); 48] = [
    ("E", include_str!("../data/illuminant_e.csv")),
    ("A", include_str!("../data/illuminant_a.csv")),
    ("C", include_str!("../data/illuminant_c.csv")),
    ("D50", include_str!("../data/illuminant_d50.csv")),
    ("D55", include_str!("../data/illuminant_d55.csv")),
    ("D65", include_str!("../data/illuminant_d65.csv")),
    ("D75", include_str!("../data/illuminant_d75.csv")),
    ("FL1", include_str!("../data/illuminant_fl1.csv")),
    ("FL2", include_str!("../data/illuminant_fl2.csv")),
    ("FL3", include_str!("../data/illuminant_fl3.csv")),
    ("FL4", include_str!("../data/illuminant_fl4.csv")),
    ("FL5", include_str!("../data/illuminant_fl5.csv")),
    ("FL6", include_str!("../data/illuminant_fl6.csv")),
    ("FL7", include_str!("../data/illuminant_fl7.csv")),
    ("FL8", include_str!("../data/illuminant_fl8.csv")),
    ("FL9", include_str!("../data/illuminant_fl9.csv")),
    ("FL10", include_str!("../data/illuminant_fl10.csv")),
    ("FL11", include_str!("../data/illuminant_fl11.csv")),
    ("FL12", include_str!("../data/illuminant_fl12.csv")),
    ("FL3.1", include_str!("../data/illuminant_fl3_1.csv")),
    ("FL3.2", include_str!("../data/illuminant_fl3_2.csv")),
    ("FL3.3", include_str!("../data/illuminant_fl3_3.csv")),
    ("FL3.4", include_str!("../data/illuminant_fl3_4.csv")),
    ("FL3.5", include_str!("../data/illuminant_fl3_5.csv")),
    ("FL3.6", include_str!("../data/illuminant_fl3_6.csv")),
    ("FL3.7", include_str!("../data/illuminant_fl3_7.csv")),
    ("FL3.8", include_str!("../data/illuminant_fl3_8.csv")),
    ("FL3.9", include_str!("../data/illuminant_fl3_9.csv")),
    ("FL3.10", include_str!("../data/illuminant_fl3_10.csv")),
    ("FL3.11", include_str!("../data/illuminant_fl3_11.csv")),
    ("FL3.12", include_str!("../data/illuminant_fl3_12.csv")),
    ("FL3.13", include_str!("../data/illuminant_fl3_13.csv")),
    ("FL3.14", include_str!("../data/illuminant_fl3_14.csv")),
    ("FL3.15", include_str!("../data/illuminant_fl3_15.csv")),
    ("HP1", include_str!("../data/illuminant_hp1.csv")),
    ("HP2", include_str!("../data/illuminant_hp2.csv")),
    ("HP3", include_str!("../data/illuminant_hp3.csv")),
    ("HP4", include_str!("../data/illuminant_hp4.csv")),
    ("HP5", include_str!("../data/illuminant_hp5.csv")),
    ("LED-B1", include_str!("../data/illuminant_led_b1.csv")),
    ("LED-B2", include_str!("../data/illuminant_led_b2.csv")),
    ("LED-B3", include_str!("../data/illuminant_led_b3.csv")),
    ("LED-B4", include_str!("../data/illuminant_led_b4.csv")),
    ("LED-B5", include_str!("../data/illuminant_led_b5.csv")),
    ("LED-BH1", include_str!("../data/illuminant_led_bh1.csv")),
    ("LED-RGB1", include_str!("../data/illuminant_led_rgb1.csv")),
    ("LED-V1", include_str!("../data/illuminant_led_v1.csv")),
    ("LED-V2", include_str!("../data/illuminant_led_v2.csv")),
];

/// Parsed curves, in the order of `ENTRIES`.
static CURVES: LazyLock<Vec<Curve>> = LazyLock::new(|| {
    let parse = |(_, csv): &(&str, &str)| {
        let [curve] = curve::parse(csv, "wavelength_nm,relative_power");
        curve
    };
    ENTRIES.iter().map(parse).collect()
});

/// A standard illuminant. Parses from its CIE name, case-insensitively:
///
/// ```
/// # use snowblue_color::Illuminant;
/// let lamp: Illuminant = "A".parse()?;
/// // An incandescent lamp emits ten times as much red as blue light.
/// assert!(lamp.relative_power(700.0)? > 10.0 * lamp.relative_power(400.0)?);
/// # Ok::<(), snowblue_color::ColorError>(())
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Illuminant {
    index: usize,
}

impl Illuminant {
    /// Equal power at every wavelength.
    pub const E: Illuminant = Illuminant { index: 0 };
    /// An incandescent lamp at 2856 K.
    pub const A: Illuminant = Illuminant { index: 1 };
    /// Horizon daylight, about 5000 K; the white of print.
    pub const D50: Illuminant = Illuminant { index: 3 };
    /// Noon daylight, about 6500 K; the white of sRGB.
    pub const D65: Illuminant = Illuminant { index: 5 };

    /// All illuminants.
    pub fn all() -> impl Iterator<Item = Illuminant> {
        (0..ENTRIES.len()).map(|index| Illuminant { index })
    }

    /// The CIE name, such as `D65` or `FL3.15`.
    pub fn name(self) -> &'static str {
        ENTRIES[self.index].0
    }

    /// Relative spectral power, in an arbitrary unit that differs between illuminants.
    ///
    /// # Errors
    /// If the wavelength lies outside the table ([`range_nm`](Self::range_nm)).
    pub fn relative_power(self, wavelength_nm: f64) -> Result<f64, ColorError> {
        let range_nm = self.range_nm();
        CURVES[self.index].at(wavelength_nm).ok_or_else(|| ColorError::OutsideTable {
            wavelength_nm,
            first_nm: *range_nm.start(),
            last_nm: *range_nm.end(),
            table: format!("illuminant {self}"),
        })
    }

    /// The first and the last wavelength of the table, in nm.
    pub fn range_nm(self) -> RangeInclusive<f64> {
        CURVES[self.index].range_nm()
    }
}

impl FromStr for Illuminant {
    type Err = ColorError;

    fn from_str(name: &str) -> Result<Illuminant, ColorError> {
        let found = Illuminant::all().find(|illuminant| illuminant.name().eq_ignore_ascii_case(name));
        found.ok_or_else(|| ColorError::UnknownIlluminant {
            name: name.to_owned(),
            known: ENTRIES.map(|(name, _)| name).join(", "),
        })
    }
}

impl fmt::Display for Illuminant {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl fmt::Debug for Illuminant {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Illuminant({})", self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_have_their_published_size() {
        for illuminant in Illuminant::all() {
            let (first_nm, last_nm, count) = match illuminant.name() {
                "E" => (360.0, 830.0, 95),
                "A" | "C" | "D50" | "D55" | "D65" | "D75" => (300.0, 780.0, 97),
                _ => (380.0, 780.0, 81),
            };
            assert_eq!(illuminant.range_nm(), first_nm..=last_nm, "{illuminant}");
            assert_eq!(CURVES[illuminant.index].count(), count, "{illuminant}");
        }
    }

    /// Values printed in CIE 015:2018.
    #[test]
    fn tables_contain_published_values() {
        let printed = [
            ("D65", 300.0, 0.0341),
            ("D65", 560.0, 100.0),
            ("D65", 780.0, 63.3828),
            ("A", 300.0, 0.930483),
            ("A", 560.0, 100.0),
            ("A", 780.0, 241.675),
            ("FL3.15", 435.0, 1417.0),
        ];
        for (name, wavelength_nm, power) in printed {
            let illuminant: Illuminant = name.parse().unwrap();
            assert_eq!(illuminant.relative_power(wavelength_nm), Ok(power), "{name} at {wavelength_nm} nm");
        }
    }

    /// The definition: Planck's law with c₂ = 0.014350 m K at 2848 K (CIE 015:2018).
    #[test]
    fn illuminant_a_is_a_black_body() {
        let planck = |nm: f64| nm.powi(-5) / (1.435e7 / (2848.0 * nm)).exp_m1();
        for wavelength_nm in [300.0, 450.0, 780.0] {
            let power = Illuminant::A.relative_power(wavelength_nm).unwrap();
            let expected = 100.0 * planck(wavelength_nm) / planck(560.0);
            assert!((power / expected - 1.0).abs() < 1e-5, "{power} {expected}");
        }
    }

    #[test]
    fn names_are_case_insensitive() {
        for illuminant in Illuminant::all() {
            assert_eq!(illuminant.name().to_lowercase().parse(), Ok(illuminant));
        }
        let named = [Illuminant::E, Illuminant::A, Illuminant::D50, Illuminant::D65];
        assert_eq!(named.map(Illuminant::name), ["E", "A", "D50", "D65"]);
    }

    #[test]
    fn the_error_for_an_unknown_name_lists_all_names() {
        let message = "D66".parse::<Illuminant>().unwrap_err().to_string();
        assert!(message.starts_with("illuminant is `D66`, but must be one of E, A, C, D50, "), "{message}");
        assert!(message.ends_with("LED-V1, LED-V2"), "{message}");
    }

    #[test]
    fn a_wavelength_outside_the_table_is_rejected() {
        let message = Illuminant::D65.relative_power(781.0).unwrap_err().to_string();
        assert_eq!(message, "wavelength is 781 nm, but must lie in 300–780 nm for illuminant D65");
    }
}
