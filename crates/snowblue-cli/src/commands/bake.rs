//! `snowblue bake`: the light field of a scene on its snow, for other renderers.

use std::path::PathBuf;

use clap::Args;
use snowblue_base::Count;
use snowblue_render::Exposure;
use snowblue_render::bake::{
    BakeError, BakeOptions, BakedScene, Channels, LIGHTMAP_SIZES, MAX_VERTICES, STEP_RANGE, write_glb, write_ply,
};
use snowblue_render::scene::IntegratorKind;
use snowblue_render::scene::integrator::Bounces;
use snowblue_render::{Integrator, Phase, Preparation, SceneDescription};

use crate::commands::interrupt;
use crate::options::{GivenOptions, Idle, LightFieldOptions, SceneOptions, limits, parse};
use crate::output::{Failure, Outcome, Phases, check_not_input, check_path, ending, output_path, print_notes};

/// Bake the light field of a scene (TOML) on its snow, as GLB or PLY for other renderers
#[derive(Debug, Args)]
#[command(after_help = "\
Each vertex has the net flux J of light outwards through the surface of the snow, negative where it is lit: one \
attribute for each lamp (_LAMP_0, lamp_0_r, ...), which may be scaled, and one for the sky and all light by way \
of other surfaces (_SKY, sky_r, ...). Snow then sends out the radiance L(mu) = R0 F + K(mu) J/pi, where F is the \
irradiance by all light on the surface. The file has K as a polynomial, and a line of GLSL. Fluxes are linear \
sRGB, in W/m2 as in renderings, so that pi L of an .exr agrees with them. COLOR_0 of a GLB is a preview with the \
exposure of a .png; --lightmap makes it a texture, which shows more than the vertices do.

The integrator of the scene does not matter: the light field is always solved for.

Examples:
  snowblue bake scenes/block_30cm.toml -o block.glb
  snowblue bake --scene block_30cm -o block.glb                       a scene inside this program
  snowblue bake scenes/fig10_igloo.toml --step-mm 20 -o igloo.glb      vertices every 20 mm at most
  snowblue bake scenes/block_30cm.toml --lightmap 1024 -o block.glb    the preview as a texture
  snowblue bake scenes/block_30cm.toml --spectrum -o block.ply        31 wavelengths, W/(m2 nm)
  snowblue bake scenes/block_30cm.toml --max-bounces 0 -o direct.ply   no light by way of other surfaces")]
pub(crate) struct Bake {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    #[command(flatten)]
    scene: SceneOptions,
    /// File to write: .glb (binary glTF, y up) or .ply (binary, axes of the scene)
    #[arg(short, long, value_name = "FILE", value_parser = output_path())]
    output: PathBuf,
    #[arg(
        long, value_name = "MM", value_parser = parse::parameter(STEP_RANGE),
        help = format!(
            "Greatest length of an edge in mm [{}; default: twice the cells of the light field at the surface]; there \
             are at most {MAX_VERTICES} vertices", limits::ends(&STEP_RANGE.inclusive())
        )
    )]
    step_mm: Option<f64>,
    /// Write 31 wavelengths instead of red, green and blue, in W/(m² nm); needs a .ply
    #[arg(long)]
    spectrum: bool,
    #[arg(
        long, value_name = "TEXELS",
        value_parser = parse::whole_number::<u32>((*LIGHTMAP_SIZES.start()).into()..=(*LIGHTMAP_SIZES.end()).into()),
        help = format!(
            "Write the preview in a .glb as a texture of so many rows and columns [{}] instead of COLOR_0",
            limits::ends(&LIGHTMAP_SIZES)
        )
    )]
    lightmap: Option<u32>,
    #[arg(
        long, value_name = "STOPS", value_parser = parse::exposure, allow_negative_numbers = true,
        help = format!(
            "Exposure of the preview in a .glb in stops [{}], or 'auto', instead of the scene's", limits::stops()
        )
    )]
    exposure: Option<Exposure>,
    #[arg(
        long, value_name = "N", value_parser = parse::count::<Bounces>,
        help = format!(
            "Greatest number of bounces [{}], instead of the scene's; 0 is direct light only", limits::of::<Bounces>()
        )
    )]
    max_bounces: Option<Count<Bounces>>,
    #[command(flatten)]
    light_field: LightFieldOptions,
}

/// The format of the output.
enum Format {
    Glb,
    Ply,
}

impl Bake {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        let format = self.format()?;
        let is_ply = matches!(format, Format::Ply);
        let why = "a .ply has no preview";
        self.given.refuse_idle(&[Idle { when: is_ply, options: &["exposure", "lightmap"], why }])?;
        let mut file = self.scene.open()?;
        let SceneDescription { film, integrator, light_field, .. } = &mut file.description;
        film.exposure = self.exposure.unwrap_or(film.exposure);
        integrator.kind = IntegratorKind::Diffusion;
        integrator.max_bounces = self.max_bounces.unwrap_or(integrator.max_bounces);
        self.light_field.override_values(light_field);
        interrupt::listen(&self.output)?;
        let phases = Phases::new(quiet, false);
        phases.begin(Phase::Meshes);
        let scene = file.build().map_err(Failure::input)?;
        file.inputs(&scene).iter().try_for_each(|input| check_not_input(input, &self.output))?;
        let preparation = Preparation { views: None, report: &|at| phases.report(at), ..Preparation::default() };
        let integrator = Integrator::prepare_with(&scene, preparation);
        let integrator = integrator.map_err(|error| Failure::input(error.located(&file)))?;
        phases.end();
        print_notes(quiet, integrator.notes().iter().map(|note| format!("{}: {note}", self.output.display())));
        let provenance = integrator.provenance();
        let baked = self.bake(&integrator, &phases)?;
        match format {
            Format::Glb => write_glb(&baked, &provenance, &self.output),
            Format::Ply => write_ply(&baked, &provenance, &self.output),
        }
        .map_err(Failure::work)?;
        interrupt::file_is_written();
        Ok(())
    }

    /// The format by the ending of the output, if the options agree with this format.
    fn format(&self) -> Result<Format, Failure> {
        let name = self.output.display();
        let format = match &*ending(&self.output, "glb") {
            "glb" if self.spectrum => {
                return Err(Failure::Input(format!("{name}: --spectrum needs a .ply: a GLB holds colours only")));
            }
            "glb" => Format::Glb,
            "ply" => Format::Ply,
            _ => return Err(Failure::Input(format!("{name}: the baked snow must end in .glb or .ply"))),
        };
        check_path(&self.output)?;
        Ok(format)
    }

    fn bake(&self, integrator: &Integrator, phases: &Phases) -> Result<BakedScene, Failure> {
        let options = BakeOptions {
            step_m: self.step_mm.map(|step_mm| 1e-3 * step_mm),
            channels: if self.spectrum { Channels::Spectrum } else { Channels::Rgb },
            is_total: false,
            lightmap: self.lightmap,
            has_irradiance: false,
        };
        let baked = integrator.bake(options, &|at| phases.report(at));
        phases.end();
        baked.map_err(|error| {
            let reason = match error {
                BakeError::TooManyVertices { .. } => format!("{error} (--step-mm)"),
                BakeError::Layout { .. } => format!("{error} (--lightmap)"),
                _ => error.to_string(),
            };
            Failure::Input(format!("{}: {reason}", self.scene.name()))
        })
    }
}
