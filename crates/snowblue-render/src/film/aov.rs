//! Arbitrary output variables (AOVs): values of a pixel beside its colour, and the layout of the sums that they need.
//!
//! The sums of a pixel in their order: X, Y and Z; with `spectrum` one for each of 31 wavelengths; with `variance`
//! the sums of squares of red, green and blue; with `residual` the sums of `ResidualLayout`; and for each `Aov` the
//! number of samples that have it, then the sums of its values. Mattes are counted beside the sums.

use std::fmt;
use std::str::FromStr;

use snowblue_scene::spectrum::SAMPLES;

use crate::film::cryptomatte::Matte;

/// The values that an image has beside its colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Aovs {
    /// Radiance at each wavelength.
    pub spectrum: bool,
    /// Variance of the mean of red, green and blue.
    pub variance: bool,
    /// Unit normal of the first surface.
    pub normal: bool,
    /// Albedo of the first surface, as a colour.
    pub albedo: bool,
    /// Thickness of the snow behind the first surface, in m.
    pub thickness: bool,
    /// Angle between the normal where the path leaves the snow and the first light, in degrees.
    pub angle: bool,
    /// Fraction of the samples that see a lamp or the sun directly. Automatic exposure leaves such pixels out.
    pub emitter: bool,
    /// Fraction of the samples that see snow first. Automatic exposure meters pixels of snow.
    pub snow: bool,
    /// Fraction of the samples that see a surface. The colours then leave out the samples that see none.
    pub alpha: bool,
    /// Distance of the first surface along the viewing axis, in m.
    pub depth: bool,
    /// Position of the first surface from the local origin of the scene, in m.
    pub position: bool,
    /// Objects of the first surfaces, as mattes.
    pub object: bool,
    /// Materials of the first surfaces, as mattes.
    pub material: bool,
    /// The sums that the filter needs. They are no channels of an image.
    pub residual: bool,
}

/// The name of the colours, which every image has.
const RGB: &str = "rgb";

/// The name in files of the sums for the filter.
const RESIDUAL: &str = "residual";

/// A name that belongs to no AOV.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is none of {names}", names = Aovs::names())]
pub struct UnknownAov(pub String);

impl Aovs {
    /// Names of all AOVs that an image may have. It always has `rgb`.
    fn names() -> String {
        let names = Self::default().named_flags().map(|(name, _)| name);
        let names = std::iter::once(RGB).chain(names.into_iter().filter(|name| *name != RESIDUAL));
        names.collect::<Vec<_>>().join(", ")
    }

    fn named_flags(&mut self) -> [(&'static str, &mut bool); 14] {
        [
            ("spectrum", &mut self.spectrum),
            ("variance", &mut self.variance),
            ("normal", &mut self.normal),
            ("albedo", &mut self.albedo),
            ("thickness", &mut self.thickness),
            ("angle", &mut self.angle),
            ("emitter", &mut self.emitter),
            ("snow", &mut self.snow),
            ("alpha", &mut self.alpha),
            ("depth", &mut self.depth),
            ("position", &mut self.position),
            ("object", &mut self.object),
            ("material", &mut self.material),
            (RESIDUAL, &mut self.residual),
        ]
    }
}

/// The names, separated by commas.
impl fmt::Display for Aovs {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let mut copy = *self;
        let names = copy.named_flags().into_iter().filter(|(_, is_set)| **is_set).map(|(name, _)| name);
        formatter.write_str(&std::iter::once(RGB).chain(names).collect::<Vec<_>>().join(","))
    }
}

/// Parses names separated by commas, in any order. The name of the sums for the filter is an error.
impl FromStr for Aovs {
    type Err = UnknownAov;

    fn from_str(text: &str) -> Result<Self, UnknownAov> {
        let aovs = Self::of_file(text)?;
        if aovs.residual { Err(UnknownAov(RESIDUAL.to_owned())) } else { Ok(aovs) }
    }
}

impl Aovs {
    /// Parses the names in a file, which may include the name of the sums for the filter.
    pub(crate) fn of_file(text: &str) -> Result<Self, UnknownAov> {
        let mut aovs = Self::default();
        for name in text.split(',').map(str::trim).filter(|name| *name != RGB) {
            match aovs.named_flags().into_iter().find(|(one, _)| *one == name) {
                Some((_, flag)) => *flag = true,
                None => return Err(UnknownAov(name.to_owned())),
            }
        }
        Ok(aovs)
    }
}

/// An AOV, its channels in an image file, and whether an image has it.
type AovRow = (Aov, &'static [&'static str], fn(Aovs) -> bool);

/// An AOV of the first surface on a sample's path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Aov {
    Normal,
    Albedo,
    Thickness,
    Angle,
    Emitter,
    Snow,
    Alpha,
    Depth,
    Position,
}

impl Aov {
    const ROWS: [AovRow; 9] = [
        (Self::Normal, &["normal.X", "normal.Y", "normal.Z"], |aovs| aovs.normal),
        (Self::Albedo, &["albedo.R", "albedo.G", "albedo.B"], |aovs| aovs.albedo),
        (Self::Thickness, &["thickness"], |aovs| aovs.thickness),
        (Self::Angle, &["angle"], |aovs| aovs.angle),
        (Self::Emitter, &["emitter"], |aovs| aovs.emitter),
        (Self::Snow, &["snow"], |aovs| aovs.snow),
        (Self::Alpha, &["A"], |aovs| aovs.alpha),
        (Self::Depth, &["depth.Z"], |aovs| aovs.depth),
        (Self::Position, &["position.X", "position.Y", "position.Z"], |aovs| aovs.position),
    ];

    /// Number of AOVs.
    pub(crate) const COUNT: usize = Self::ROWS.len();

    /// Its channels in an image file.
    pub(crate) fn channel_names(self) -> &'static [&'static str] {
        Self::ROWS[self as usize].1
    }

    /// Its values in a pixel without a sample that has it. The depth is beyond all surfaces, as in Blender's files.
    pub(crate) fn without_samples(self) -> f32 {
        if self == Self::Depth { 1e10 } else { 0.0 }
    }
}

/// Offset of the sums of the spectrum.
pub(crate) const SPECTRUM_OFFSET: usize = 3;

/// Offsets of the sums for the filter. The residual of a sample is its radiance less the baseline, an estimate with
/// little noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ResidualLayout {
    /// X, Y, Z of the residual, then with `spectrum` its wavelengths.
    pub(crate) residual: usize,
    /// Number of values of the residual.
    pub(crate) values: usize,
    /// Square of Y of the residual.
    pub(crate) residual_square: usize,
    /// Square of Y of the radiance without the residual.
    pub(crate) rest_square: usize,
    /// Number of samples that meet a surface. The sums that follow are over these samples.
    pub(crate) count: usize,
    /// Number of samples that hit snow with a light field.
    pub(crate) snow: usize,
    /// Y of the baseline.
    pub(crate) baseline: usize,
    /// The normal.
    pub(crate) normal: usize,
    /// The distance from the camera, in m.
    pub(crate) distance: usize,
}

impl ResidualLayout {
    /// Names of the sums.
    fn names(self) -> impl Iterator<Item = String> {
        let residual = ["X", "Y", "Z"].map(String::from).into_iter();
        let wavelengths = (0..self.values - 3).map(|number| format!("S{number:02}"));
        let others = ["Y_squared", "rest_Y_squared", "surface_samples", "snow_samples", "baseline_Y"]
            .map(String::from)
            .into_iter();
        let others = others.chain(["normal_X", "normal_Y", "normal_Z", "distance"].map(String::from));
        residual.chain(wavelengths).chain(others).map(|name| format!("residual_{name}"))
    }

    /// Number of the sums.
    fn sum_count(self) -> usize {
        self.distance + 1 - self.residual
    }
}

impl Aovs {
    /// Whether any AOV needs the first hit of a sample's camera ray.
    pub(crate) fn need_first_hit(self) -> bool {
        self.emitter || self.need_first_surface()
    }

    /// Whether any AOV needs the first surface on a sample's path.
    pub(crate) fn need_first_surface(self) -> bool {
        let others = [Aov::Emitter, Aov::Snow, Aov::Alpha];
        self.need_mattes() || self.of_first_surface().any(|aov| !others.contains(&aov))
    }

    /// Whether there are mattes.
    pub(crate) fn need_mattes(self) -> bool {
        self.object || self.material
    }

    /// The mattes.
    pub(crate) fn mattes(self) -> impl Iterator<Item = Matte> {
        let is_needed = move |matte: &Matte| match matte {
            Matte::Object => self.object,
            Matte::Material => self.material,
        };
        Matte::ALL.into_iter().filter(is_needed)
    }

    pub(crate) fn contains(self, aov: Aov) -> bool {
        (Aov::ROWS[aov as usize].2)(self)
    }

    /// The AOVs of first surfaces.
    pub(crate) fn of_first_surface(self) -> impl Iterator<Item = Aov> {
        Aov::ROWS.into_iter().filter(move |(_, _, is_needed)| is_needed(self)).map(|(aov, ..)| aov)
    }

    /// Names of the sums of a pixel, in their order.
    pub(crate) fn sum_names(self) -> Vec<String> {
        let mut names: Vec<String> = ["X", "Y", "Z"].map(String::from).into();
        if self.spectrum {
            names.extend((0..SAMPLES).map(|number| format!("S{number:02}")));
        }
        if self.variance {
            names.extend(["R", "G", "B"].map(|name| format!("{name}_squared")));
        }
        names.extend(self.residual_layout().into_iter().flat_map(ResidualLayout::names));
        for aov in self.of_first_surface() {
            let values = aov.channel_names().iter().map(|name| name.replace('.', "_"));
            let first = aov.channel_names()[0];
            names.push(format!("{}_samples", first.split('.').next().unwrap_or(first)));
            names.extend(values);
        }
        names
    }

    /// Number of sums of a pixel.
    pub(crate) fn sum_count(self) -> usize {
        self.first_aov_offset() + self.of_first_surface().map(|aov| 1 + aov.channel_names().len()).sum::<usize>()
    }

    /// Number of the sums of colours and wavelengths.
    fn colour_count(self) -> usize {
        SPECTRUM_OFFSET + if self.spectrum { SAMPLES } else { 0 }
    }

    /// Offset of the sums of squares, if there are any.
    pub(crate) fn squares_offset(self) -> Option<usize> {
        self.variance.then_some(self.colour_count())
    }

    /// Offset of the number of samples that have an AOV; the sums of its values follow.
    pub(crate) fn offset(self, aov: Aov) -> Option<usize> {
        let before = self.of_first_surface().take_while(|one| *one != aov);
        let values_before = before.map(|one| 1 + one.channel_names().len()).sum::<usize>();
        self.contains(aov).then(|| self.first_aov_offset() + values_before)
    }

    /// Offsets of the sums for the filter, if there are any.
    pub(crate) fn residual_layout(self) -> Option<ResidualLayout> {
        let values = self.colour_count();
        let residual = values + if self.variance { 3 } else { 0 };
        let after = residual + values;
        self.residual.then_some(ResidualLayout {
            residual,
            values,
            residual_square: after,
            rest_square: after + 1,
            count: after + 2,
            snow: after + 3,
            baseline: after + 4,
            normal: after + 5,
            distance: after + 8,
        })
    }

    fn first_aov_offset(self) -> usize {
        let residual = self.residual_layout().map_or(0, ResidualLayout::sum_count);
        self.colour_count() + if self.variance { 3 } else { 0 } + residual
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_agree_with_names() {
        for bits in 0..16_384u32 {
            let mut aovs = Aovs::default();
            for (k, (_, flag)) in aovs.named_flags().into_iter().enumerate() {
                *flag = bits >> k & 1 == 1;
            }
            let Aovs { spectrum, residual, .. } = aovs;
            let names = aovs.sum_names();
            let distinct: std::collections::HashSet<&String> = names.iter().collect();
            assert_eq!(distinct.len(), names.len(), "{names:?}");
            let offset = |name: &str| names.iter().position(|one| one == name);
            assert_eq!(names.len(), aovs.sum_count());
            assert_eq!(offset("R_squared"), aovs.squares_offset());
            let layout = aovs.residual_layout();
            for (name, of) in [
                ("X", (|layout| layout.residual) as fn(ResidualLayout) -> usize),
                ("Y_squared", |layout| layout.residual_square),
                ("rest_Y_squared", |layout| layout.rest_square),
                ("surface_samples", |layout| layout.count),
                ("snow_samples", |layout| layout.snow),
                ("baseline_Y", |layout| layout.baseline),
                ("normal_X", |layout| layout.normal),
                ("distance", |layout| layout.distance),
            ] {
                assert_eq!(offset(&format!("residual_{name}")), layout.map(of));
            }
            let first_names = ["normal", "albedo", "thickness", "angle", "emitter", "snow", "A", "depth", "position"];
            for ((aov, ..), name) in Aov::ROWS.into_iter().zip(first_names) {
                assert_eq!(offset(&format!("{name}_samples")), aovs.offset(aov), "{names:?}");
            }
            assert_eq!(offset("S00"), spectrum.then_some(SPECTRUM_OFFSET));
            assert_eq!(Aovs::of_file(&aovs.to_string()), Ok(aovs));
            assert_eq!(aovs.to_string().parse::<Aovs>().is_ok(), !residual);
        }
    }

    #[test]
    fn unknown_names_are_errors() {
        assert_eq!("rgb, z".parse::<Aovs>(), Err(UnknownAov("z".to_owned())));
    }
}
