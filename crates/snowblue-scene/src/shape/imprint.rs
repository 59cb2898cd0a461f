//! Prints in snow.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, ParameterRange, quantities};
use snowblue_shapes::imprint::{Foot, Imprint, ImprintKind, Sole, Wall};

use crate::values::{Coordinate, Rotation, SmallLength, things};

quantities! {
    /// Radius, depth or width of a print.
    pub PrintSize = ParameterRange::new("size of a print", 1e-3, 10.0, "m");
    /// Length of a boot.
    pub BootLength = ParameterRange::new("length of a boot", 0.05, 1.0, "m");
    /// Angle between the wall of a print and the vertical.
    pub Taper = ParameterRange::new("taper", 0.5, 60.0, "°");
}

things! {
    /// A print in snow.
    ImprintDescription by "type": dyn ImprintKeys {
        /// The hole of a pole.
        "hole" => Hole(HoleDescription),
        /// The print of a boot.
        "footprint" => Footprint(FootprintDescription),
    }
}

/// The keys of one kind of print.
pub(crate) trait ImprintKeys {
    /// The middle of the print, in m.
    fn position(&self) -> [f64; 2];

    /// Builds the print.
    fn build(&self, path: &KeyPath) -> Result<Imprint, KeyError>;
}

/// A hole with a vertical axis, narrower below.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HoleDescription {
    /// Its middle, in m.
    pub position: Numbers<Coordinate, 2>,
    /// Radius at the surface, in m.
    pub radius: Number<PrintSize>,
    /// Depth below the surface, in m.
    pub depth: Number<PrintSize>,
    /// Angle between its wall and the vertical, in degrees.
    #[serde(default = "HoleDescription::default_taper_deg")]
    pub taper_deg: Number<Taper>,
    /// Height of the snow pushed up around it, in m.
    #[serde(default)]
    pub rim: Number<SmallLength>,
    /// Width of this rim, in m; twice the radius if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_width: Option<Number<PrintSize>>,
}

/// The print of a boot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FootprintDescription {
    /// Its middle, in m.
    pub position: Numbers<Coordinate, 2>,
    /// Direction of the toe, counter-clockwise from the x axis, in degrees.
    #[serde(default)]
    pub heading_deg: Number<Rotation>,
    /// Which foot.
    #[serde(default)]
    pub foot: FootDescription,
    /// Length of the boot, in m.
    #[serde(default = "FootprintDescription::default_length")]
    pub length: Number<BootLength>,
    /// Depth at the heel, in m, and at the toe unless that has its own.
    pub depth: Number<PrintSize>,
    /// Depth at the toe, in m; the depth at the heel if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toe_depth: Option<Number<PrintSize>>,
    /// Depth of the tread of the sole, in m; at most the lesser depth of the print.
    #[serde(default = "FootprintDescription::default_tread")]
    pub tread: Number<SmallLength>,
    /// Angle between its wall and the vertical, in degrees.
    #[serde(default = "FootprintDescription::default_taper_deg")]
    pub taper_deg: Number<Taper>,
    /// Height of the snow pushed up around it, in m.
    #[serde(default)]
    pub rim: Number<SmallLength>,
    /// Width of this rim, in m; a sixth of the length if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_width: Option<Number<PrintSize>>,
}

/// A foot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FootDescription {
    /// The left one.
    Left,
    /// The right one.
    #[default]
    Right,
}

impl HoleDescription {
    fn default_taper_deg() -> Number<Taper> {
        Number::of(2.0)
    }
}

impl ImprintKeys for HoleDescription {
    fn position(&self) -> [f64; 2] {
        self.position.get()
    }

    fn build(&self, path: &KeyPath) -> Result<Imprint, KeyError> {
        let [radius_m, depth_m, taper_deg] = [self.radius.get(), self.depth.get(), self.taper_deg.get()];
        let width_m = depth_m * taper_deg.to_radians().tan();
        if width_m > radius_m {
            let reason = format!("is {taper_deg}°, which closes the hole above its depth");
            return Err(path.key("taper_deg").error(reason));
        }
        let rim_width_m = self.rim_width.map_or(2.0 * radius_m, Number::get);
        let wall = Wall { width_m, rim_m: self.rim.get(), rim_width_m };
        Ok(Imprint::new(self.position().into(), ImprintKind::Hole { radius_m, depth_m }, wall))
    }
}

impl FootprintDescription {
    fn default_length() -> Number<BootLength> {
        Number::of(0.3)
    }

    fn default_tread() -> Number<SmallLength> {
        Number::of(4e-3)
    }

    fn default_taper_deg() -> Number<Taper> {
        Number::of(8.0)
    }
}

impl ImprintKeys for FootprintDescription {
    fn position(&self) -> [f64; 2] {
        self.position.get()
    }

    fn build(&self, path: &KeyPath) -> Result<Imprint, KeyError> {
        let (length_m, depth_m, tread_m) = (self.length.get(), self.depth.get(), self.tread.get());
        let depths_m = [depth_m, self.toe_depth.map_or(depth_m, Number::get)];
        let least_m = depths_m[0].min(depths_m[1]);
        if tread_m > least_m {
            let reason = format!("is {tread_m} m, but must be at most {least_m} m, the depth of the print");
            return Err(path.key("tread").error(reason));
        }
        let foot = match self.foot {
            FootDescription::Left => Foot::Left,
            FootDescription::Right => Foot::Right,
        };
        let wall = Wall {
            width_m: depths_m[0].max(depths_m[1]) * self.taper_deg.get().to_radians().tan(),
            rim_m: self.rim.get(),
            rim_width_m: self.rim_width.map_or(length_m / 6.0, Number::get),
        };
        let sole = Sole::new(self.heading_deg.get(), length_m, depths_m, tread_m, foot);
        Ok(Imprint::new(self.position().into(), ImprintKind::Footprint(sole), wall))
    }
}
