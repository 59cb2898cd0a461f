//! What a picture tells of its pixels beside their colour, and how the sums behind that are laid out.
//!
//! The sums of a pixel stand side by side: X, Y and Z; with `spectrum` those of 31 wavelengths; with `variance` the
//! squares of red, green and blue; and for each feature asked for how many samples had it, then its values.

use std::fmt;
use std::str::FromStr;

use crate::spectrum::SAMPLES;

/// What is told of the pixels beside their colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Aovs {
    /// Radiance at each wavelength.
    pub spectrum: bool,
    /// Variance of the mean of red, green and blue.
    pub variance: bool,
    /// Unit normal of the surface seen.
    pub normal: bool,
    /// Reflectance of the surface seen, as a colour.
    pub albedo: bool,
    /// Snow behind the point seen, in m.
    pub thickness: bool,
    /// Angle between the normal where the path leaves the snow and the first light, in degrees.
    pub angle: bool,
}

impl Aovs {
    /// What can be asked for; colour is there in any case.
    pub const NAMES: [&str; 7] = ["rgb", "spectrum", "variance", "normal", "albedo", "thickness", "angle"];

    fn named(&mut self) -> [(&'static str, &mut bool); 6] {
        let Self { spectrum, variance, normal, albedo, thickness, angle } = self;
        let [_, names @ ..] = Self::NAMES;
        let mut names = names.into_iter();
        [spectrum, variance, normal, albedo, thickness, angle].map(|flag| (names.next().unwrap_or_default(), flag))
    }
}

/// The names by commas.
impl fmt::Display for Aovs {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let mut copy = *self;
        let asked = copy.named().into_iter().filter(|(_, asked)| **asked).map(|(name, _)| name);
        formatter.write_str(&std::iter::once(Self::NAMES[0]).chain(asked).collect::<Vec<_>>().join(","))
    }
}

/// Reads names by commas, in any order; the error is the first one that is unknown.
impl FromStr for Aovs {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut channels = Self::default();
        for name in text.split(',').map(str::trim).filter(|name| *name != Self::NAMES[0]) {
            match channels.named().into_iter().find(|(one, _)| *one == name) {
                Some((_, asked)) => *asked = true,
                None => return Err(name.to_owned()),
            }
        }
        Ok(channels)
    }
}

/// Something that is told of the first surface on a sample's path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Aov {
    Normal,
    Albedo,
    Thickness,
    Angle,
}

impl Aov {
    pub(crate) const ALL: [Self; 4] = [Self::Normal, Self::Albedo, Self::Thickness, Self::Angle];

    /// Its channels in a file.
    pub(crate) fn names(self) -> &'static [&'static str] {
        match self {
            Self::Normal => &["normal.X", "normal.Y", "normal.Z"],
            Self::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Self::Thickness => &["thickness"],
            Self::Angle => &["angle"],
        }
    }
}

impl Aovs {
    /// Whether something is asked for that the light along the path does not tell.
    pub(crate) fn has_features(self) -> bool {
        Aov::ALL.into_iter().any(|feature| self.has(feature))
    }

    pub(crate) fn has(self, feature: Aov) -> bool {
        match feature {
            Aov::Normal => self.normal,
            Aov::Albedo => self.albedo,
            Aov::Thickness => self.thickness,
            Aov::Angle => self.angle,
        }
    }

    /// Names of all sums of a pixel, in their order.
    pub(crate) fn sums(self) -> Vec<String> {
        let mut names: Vec<String> = ["X", "Y", "Z"].map(String::from).into();
        if self.spectrum {
            names.extend((0..SAMPLES).map(|number| format!("S{number:02}")));
        }
        if self.variance {
            names.extend(["R", "G", "B"].map(|name| format!("{name}_squared")));
        }
        for feature in Aov::ALL.into_iter().filter(|feature| self.has(*feature)) {
            let parts = feature.names().iter().map(|name| name.replace('.', "_"));
            let first = feature.names()[0];
            names.push(format!("{}_samples", first.split('.').next().unwrap_or(first)));
            names.extend(parts);
        }
        names
    }

    /// Place of the sums of squares, if they are kept.
    pub(crate) fn squares(self) -> Option<usize> {
        self.variance.then_some(3 + if self.spectrum { SAMPLES } else { 0 })
    }

    /// Place of a feature's count, which its values follow, if it is kept.
    pub(crate) fn place(self, feature: Aov) -> Option<usize> {
        let start = self.squares().map_or(3 + if self.spectrum { SAMPLES } else { 0 }, |squares| squares + 3);
        let before = Aov::ALL.into_iter().take_while(|one| *one != feature).filter(|one| self.has(*one));
        self.has(feature).then(|| start + before.map(|one| 1 + one.names().len()).sum::<usize>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_names_agree() {
        for bits in 0..64u32 {
            let [spectrum, variance, normal, albedo, thickness, angle] = [0, 1, 2, 3, 4, 5].map(|k| bits >> k & 1 == 1);
            let channels = Aovs { spectrum, variance, normal, albedo, thickness, angle };
            let names = channels.sums();
            let at = |name: &str| names.iter().position(|one| one == name);
            assert_eq!(at("R_squared"), channels.squares());
            for (feature, name) in Aov::ALL.into_iter().zip(["normal", "albedo", "thickness", "angle"]) {
                assert_eq!(at(&format!("{name}_samples")), channels.place(feature), "{names:?}");
            }
            assert_eq!(at("S00").is_some(), spectrum);
            assert_eq!(channels.to_string().parse(), Ok(channels));
        }
        assert_eq!("rgb, depth".parse::<Aovs>(), Err("depth".to_owned()));
    }
}
