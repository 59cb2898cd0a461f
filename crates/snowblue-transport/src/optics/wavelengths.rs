//! Lists of wavelengths, and their notation.

use std::str::FromStr;

use serde::Deserialize;

/// Greatest number of steps of a range of wavelengths.
const MAX_STEPS: f64 = 100_000.0;

/// Wavelengths, in nm.
///
/// As a word they are a range FIRST:LAST:STEP, which includes both ends, or a list with commas; in files also a list of
/// numbers.
///
/// ```
/// # use snowblue_transport::optics::Wavelengths;
/// let Wavelengths(visible) = "400:700:100".parse()?;
/// assert_eq!(visible, [400.0, 500.0, 600.0, 700.0]);
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Notation")]
pub struct Wavelengths(pub Vec<f64>);

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "must be a list of wavelengths or a range FIRST:LAST:STEP")]
enum Notation {
    List(Vec<f64>),
    Word(String),
}

impl TryFrom<Notation> for Wavelengths {
    type Error = String;

    fn try_from(notation: Notation) -> Result<Self, String> {
        match notation {
            Notation::List(list) => Ok(Self(list)),
            Notation::Word(word) => word.parse().map_err(|error| format!("is wrong: {error}")),
        }
    }
}

impl Wavelengths {
    /// 400, 410, … 700 nm.
    #[must_use]
    pub fn visible() -> Self {
        Self((400..=700).step_by(10).map(f64::from).collect())
    }
}

impl FromStr for Wavelengths {
    type Err = String;

    /// # Errors
    /// If a word is not a number, or the range does not ascend or has more than 100,000 steps.
    fn from_str(words: &str) -> Result<Self, String> {
        const FORMS: &str = "give FIRST:LAST:STEP (400:700:10) or a list (450,550,650), in nm";
        let number = |word: &str| word.trim().parse::<f64>().map_err(|_| format!("'{word}' is not a number; {FORMS}"));
        if !words.contains(':') {
            return words.split(',').map(number).collect::<Result<_, _>>().map(Self);
        }
        let [first, last, step] = words.split(':').map(number).collect::<Result<Vec<f64>, _>>()?[..] else {
            return Err(FORMS.to_owned());
        };
        let steps = (last - first) / step;
        if !(step > 0.0 && (0.0..MAX_STEPS).contains(&steps)) {
            return Err(format!(
                "the range is {words} nm, but must ascend, with a step above 0 nm and at most {MAX_STEPS} steps"
            ));
        }
        // Rounding must not drop the last wavelength.
        let at = (0_u32..).map(|i| first + f64::from(i) * step).take_while(|nm| *nm <= last + 1e-9 * step);
        Ok(Self(at.map(|nm| nm.min(last)).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_wavelengths_include_both_ends() {
        let wavelengths = |words: &str| words.parse().map(|Wavelengths(list)| list);
        let visible = wavelengths("400:700:10").unwrap();
        assert_eq!(
            (visible.len(), visible[0].to_bits(), visible[30].to_bits()),
            (31, 400_f64.to_bits(), 700_f64.to_bits())
        );
        assert_eq!(wavelengths("0.1:0.7:0.1").unwrap().len(), 7);
        assert_eq!(wavelengths("450,550").unwrap().len(), 2);
        for bad in ["400:700:0", "700:400:10", "400:700", "blue", "1:1e12:1", "1:2:nan"] {
            assert!(wavelengths(bad).is_err(), "{bad}");
        }
    }
}
