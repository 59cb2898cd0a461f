//! The integrators and their settings, and the settings of the light field in snow.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{Count, KeyError, KeyPath, Number, ParameterRange, quantities};

use crate::values::Fraction;

quantities! {
    /// Samples of a pixel.
    pub SamplesPerPixel = ParameterRange::new("samples of a pixel", 1.0, 16_777_216.0, "");
    /// Standard error of a pixel relative to its luminance.
    pub NoiseTarget = ParameterRange::new("noise target", 1e-4, 1.0, "");
    /// Surfaces on a path after the first.
    pub Bounces = ParameterRange::new("surfaces after the first", 0.0, 10_000.0, "");
    /// Size of the cells of the light field at the surface of snow.
    pub FieldStep = ParameterRange::new("step of the light field", 0.01, 1000.0, "mm");
    /// Greatest memory of the light field.
    pub FieldMemory = ParameterRange::new("memory of the light field", 16.0, 1_048_576.0, "MiB");
    /// Nodes of the light field of a body of snow.
    pub FieldNodes = ParameterRange::new("nodes of the light field", 100.0, 100_000_000.0, "");
}

/// How the radiance of snow is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum IntegratorKind {
    /// PCASnow: the curves of a slab, looked up for one straight line.
    PcaSnow,
    /// The light field inside the snow by diffusion, read at its surface.
    Diffusion,
    /// Random walks that end in the light field inside the snow.
    #[default]
    Hybrid,
    /// A volumetric path tracer, the ground truth: slow, and unbiased for any shape.
    Reference,
}

impl IntegratorKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::PcaSnow, Self::Diffusion, Self::Hybrid, Self::Reference];

    /// The name of the integrator in scene files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::PcaSnow => "pcasnow",
            Self::Diffusion => "diffusion",
            Self::Hybrid => "hybrid",
            Self::Reference => "reference",
        }
    }

    /// Whether the integrator reads the light field inside snow. Snow must then be closed.
    pub fn has_light_field(self) -> bool {
        matches!(self, Self::Diffusion | Self::Hybrid)
    }

    /// Whether the integrator looks up curves of slabs.
    pub fn has_curves(self) -> bool {
        self == Self::PcaSnow
    }

    /// Whether the integrator follows random walks in snow.
    pub fn has_walks(self) -> bool {
        matches!(self, Self::Hybrid | Self::Reference)
    }

    /// Whether light passes from one body of snow into another body that touches it.
    pub fn crosses_bodies(self) -> bool {
        self == Self::Reference
    }
}

/// The integrator, and how many paths it traces and how long.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct IntegratorSettings {
    /// The integrator.
    #[serde(rename = "type")]
    pub kind: IntegratorKind,
    /// Samples per pixel, each of one path.
    pub samples_per_pixel: Count<SamplesPerPixel>,
    /// Standard error of a pixel relative to its luminance below which it gets no further samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_target: Option<Number<NoiseTarget>>,
    /// Whether `hybrid` and `diffusion` filter noise: the difference of samples from an estimate with little noise, for
    /// snow the light field at the surface, is averaged over pixels of like surfaces, over fewer pixels as samples are
    /// added.
    pub filter: bool,
    /// Greatest number of surfaces after the first on a path; 0 is direct light only.
    pub max_bounces: Count<Bounces>,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Settings of PCASnow.
    pub pcasnow: PcaSnowSettings,
}

impl Default for IntegratorSettings {
    fn default() -> Self {
        Self {
            kind: IntegratorKind::default(),
            samples_per_pixel: Count::of(64),
            noise_target: None,
            filter: true,
            max_bounces: Count::of(8),
            seed: 1,
            pcasnow: PcaSnowSettings::default(),
        }
    }
}

/// How PCASnow treats snow. The other integrators have no use for it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PcaSnowSettings {
    /// The straight path that stands for all paths of light through the snow.
    pub path: PathMode,
    /// A constant reflectance, 0–1, instead of that of the curves: the paper's local model. Thin snow then reflects and
    /// transmits more light than it receives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reflectance: Option<Number<Fraction>>,
    /// A file with a table of curves; the embedded table if absent. The curves of snow that the table does not hold are
    /// solved for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
}

/// The straight path that stands for all paths of light through the snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PathMode {
    /// Along the viewing ray, as in the paper. Snow seen obliquely looks thicker than it is, and black where the exit
    /// does not face the light.
    View,
    /// Along the inward normal: exact for a slab, from every viewing direction.
    Normal,
    /// Along the line to the light.
    Light,
    /// The brighter of `Normal` and `Light`, by luminance.
    #[default]
    Brightest,
}

impl PathMode {
    /// All modes.
    pub const ALL: [Self; 4] = [Self::Brightest, Self::Normal, Self::Light, Self::View];

    /// The name of the mode in scene files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::View => "view",
            Self::Normal => "normal",
            Self::Light => "light",
            Self::Brightest => "brightest",
        }
    }

    /// Whether the mode uses a path that does not depend on the light.
    #[inline]
    pub fn uses_straight(self) -> bool {
        self != Self::Light
    }

    /// Whether the mode uses lines to the light.
    #[inline]
    pub fn uses_lines(self) -> bool {
        matches!(self, Self::Light | Self::Brightest)
    }
}

/// The views that the light field is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Views {
    /// That of the camera: cells are as small as its picture needs, and larger where it does not look.
    #[default]
    Camera,
    /// All: light fields do not depend on the camera, but for those of wide bodies.
    All,
}

/// The grid of the light field in each body of snow, for the integrators that have one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LightFieldSettings {
    /// Greatest memory of the grids of all bodies together, in MiB.
    pub memory_mib: Count<FieldMemory>,
    /// Greatest size of a cell at the surface, in mm; if absent, it follows from the body, its snow and the memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_mm: Option<Number<FieldStep>>,
    /// About how many nodes the grid of a body has, instead of a size of its cells; more if the snow needs smaller
    /// ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes: Option<Count<FieldNodes>>,
    /// The views that it is for.
    pub views: Views,
    /// Rays through grains for the optics of the snow, per node of the refractive index, and scattering events of walks
    /// from grain to grain; those of the reference are four times as many. Scene files have no such key.
    #[serde(skip)]
    pub grain_rays: u32,
    /// Most rounds of light between bodies of snow. Scene files have no such key.
    #[serde(skip)]
    pub most_rounds: u32,
    /// Memory of the grids of a first, coarse picture, in MiB, which may be less than scene files allow. Scene files
    /// have no such key.
    #[serde(skip)]
    pub coarse_memory_mib: Option<u32>,
}

/// Number of rays through grains for an error of 0.2 % in the transmittance of 15 cm of snow.
pub const GRAIN_RAYS: u32 = 1 << 18;
/// Greatest number of rounds of light between bodies of snow. Caves take some ten rounds.
const MAX_ROUNDS: u32 = 12;

impl LightFieldSettings {
    /// Greatest memory of the grids of all bodies together, in MiB.
    pub fn memory_mib(&self) -> u32 {
        let memory_mib = self.memory_mib.get();
        self.coarse_memory_mib.map_or(memory_mib, |coarse_mib| coarse_mib.min(memory_mib))
    }

    /// Checks that only one key sets the cells.
    pub(crate) fn check(&self, path: &KeyPath) -> Result<(), KeyError> {
        if self.step_mm.is_some() && self.nodes.is_some() {
            return Err(path.key("nodes").error("has no effect, since `step_mm` sets the cells"));
        }
        Ok(())
    }
}

impl Default for LightFieldSettings {
    fn default() -> Self {
        Self {
            memory_mib: Count::of(1024),
            step_mm: None,
            nodes: None,
            views: Views::Camera,
            grain_rays: GRAIN_RAYS,
            most_rounds: MAX_ROUNDS,
            coarse_memory_mib: None,
        }
    }
}
