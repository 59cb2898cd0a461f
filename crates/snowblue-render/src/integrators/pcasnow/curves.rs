//! Curves of snow for PCASnow: read from the table if it contains the snow, else solved by discrete ordinates.
//! Between the kinds of snow of a mask, curves are interpolated logarithmically. Snow of layers has the curves of the
//! layer at the visible point.

use std::borrow::Cow;
use std::sync::Arc;

use snowblue_base::hash::Fnv1a;
use snowblue_base::{KeyPath, narrow};
use snowblue_database::lookup::SnowMix;
use snowblue_database::{CompressedTable, DatabaseError, Space};
use snowblue_light_field::SnowOfMaterials;
use snowblue_scene::material::snow::SnowKinds;
use snowblue_scene::objects::{Objects, SurfaceInteraction};
use snowblue_scene::spectrum::{Spectrum, wavelengths_nm};
use snowblue_scene::{PcaSnowSettings, Scene};

use crate::error::RenderError;

/// The curves of all snow of a scene.
#[derive(Debug)]
pub(in crate::integrators) struct TableCurves {
    /// The curves of each material's snow.
    pub(in crate::integrators) curves: SnowOfMaterials<SnowCurves>,
    /// A hash of the table of curves, if there is a table.
    pub(in crate::integrators) table_hash: Option<u64>,
}

impl TableCurves {
    /// Reads curves from a table: the given table, the table of the scene, or else the embedded table. Curves that
    /// the table lacks are solved for, with a note.
    ///
    /// # Errors
    ///
    /// If the table of the scene cannot be read, or curves cannot be solved.
    pub(in crate::integrators) fn prepare(
        scene: &Scene,
        kinds: &SnowOfMaterials<SnowKinds>,
        table: Option<&CompressedTable>,
        notes: &mut Vec<String>,
    ) -> Result<Self, RenderError> {
        let table = table_of(scene, table)?;
        let mut curves = Vec::with_capacity(kinds.len());
        for (material, kinds) in kinds.iter().enumerate() {
            let Some(kinds) = kinds else {
                curves.push(None);
                continue;
            };
            let path = scene.material_path(material);
            let solved = SnowCurves::new(kinds, table.as_deref());
            let (of_material, reason) =
                solved.map_err(|error| path.error(format!("cannot be rendered by pcasnow: {error}")))?;
            notes.extend(reason.map(|reason| format!("{path}: its curves are solved for, because {reason}")));
            curves.push(Some(Arc::new(of_material)));
        }
        Ok(Self { curves, table_hash: table.as_deref().map(table_hash) })
    }
}

/// The curves of a material's snow.
#[derive(Debug)]
pub(in crate::integrators) struct SnowCurves {
    kinds: Arc<SnowKinds>,
    /// The curves of each kind.
    curves: Vec<snowblue_database::PcaSnow>,
}

impl SnowCurves {
    /// The curves of snow at the wavelengths of an image. If they are solved, also the reason why the table does not
    /// hold them.
    ///
    /// # Errors
    ///
    /// If curves cannot be solved.
    pub(in crate::integrators) fn new(
        kinds: &Arc<SnowKinds>,
        table: Option<&CompressedTable>,
    ) -> Result<(Self, Option<String>), DatabaseError> {
        let (curves, reason) = snowblue_database::PcaSnow::read_or_solve(table, &kinds.samples, &wavelengths_nm())?;
        Ok((Self { kinds: Arc::clone(kinds), curves }, reason))
    }

    /// The kinds of snow, and where they lie.
    pub(in crate::integrators) fn kinds(&self) -> &Arc<SnowKinds> {
        &self.kinds
    }

    /// The reflectance at a hit of snow of some depth, for light from straight above.
    pub(in crate::integrators) fn reflectance(
        &self,
        settings: &PcaSnowSettings,
        objects: &Objects,
        surface: &SurfaceInteraction,
        depth_m: f32,
    ) -> Spectrum {
        reflectance(settings, &self.at(objects, surface), 100.0 * depth_m, 0.0)
    }

    /// The curves, if the snow is uniform.
    pub(in crate::integrators) fn single(&self) -> Option<&snowblue_database::PcaSnow> {
        self.curves.first().filter(|_| self.kinds.is_uniform())
    }

    /// The curves at a hit.
    #[inline]
    pub(in crate::integrators) fn at(&self, objects: &Objects, surface: &SurfaceInteraction) -> SnowMix<'_> {
        if self.kinds.is_uniform() {
            return SnowMix::single(&self.curves[0]);
        }
        let mix = self.kinds.at_surface(objects, surface);
        SnowMix::new(&self.curves[mix.first], &self.curves[mix.second], mix.share)
    }
}

/// The reflectance of snow of some depth by its curves, or the constant of the settings.
pub(super) fn reflectance(settings: &PcaSnowSettings, curves: &SnowMix, depth_cm: f32, angle_deg: f32) -> Spectrum {
    if let Some(constant) = settings.reflectance {
        return Spectrum::constant(narrow(constant.get()));
    }
    let mut reflectance = Spectrum::ZERO;
    curves.reflectance(depth_cm, angle_deg, &mut reflectance.0);
    reflectance
}

/// The table for a scene: the given table, the table of the scene, or else the embedded table.
fn table_of<'a>(
    scene: &Scene,
    given: Option<&'a CompressedTable>,
) -> Result<Option<Cow<'a, CompressedTable>>, RenderError> {
    if let Some(table) = given {
        return Ok(Some(Cow::Borrowed(table)));
    }
    if let Some(file) = scene.table_file() {
        let table = CompressedTable::open(file).map_err(|error| {
            KeyPath::root("integrator").key("pcasnow").key("table").error(format!("cannot be used: {error}"))
        })?;
        return Ok(Some(Cow::Owned(table)));
    }
    Ok(embedded_table().map(Cow::Borrowed))
}

#[cfg(feature = "table")]
#[expect(clippy::unnecessary_wraps, reason = "without the feature there is none")]
fn embedded_table() -> Option<&'static CompressedTable> {
    Some(snowblue_data::embedded())
}

#[cfg(not(feature = "table"))]
fn embedded_table() -> Option<&'static CompressedTable> {
    None
}

/// The hash of a table of curves.
fn table_hash(table: &CompressedTable) -> u64 {
    let mut hash = Fnv1a::default();
    let axes = &table.axes;
    let mut add_axis = |name: &str, values: &[f64]| {
        hash.add(name.as_bytes());
        hash.add(&(values.len() as u64).to_le_bytes());
        values.iter().for_each(|value| hash.add(&value.to_le_bytes()));
    };
    add_axis("grain size", &axes.grain_sizes_um);
    add_axis("facetness", &axes.facetness);
    add_axis("density", &axes.densities_kg_m3);
    axes.properties.iter().for_each(|axis| add_axis(axis.property.name(), &axis.values));
    add_axis(if axes.diffuse { "diffuse and angle" } else { "angle" }, &axes.angles_deg);
    add_axis("thickness", &axes.thicknesses_cm);
    add_axis("wavelength", &axes.wavelengths_nm);
    hash.add(match table.space {
        Space::Linear => b"linear",
        Space::Log => b"log",
    });
    for components in [&table.transmittance, &table.reflectance] {
        for number in components.coefficients.iter().chain(&components.basis) {
            hash.add(&number.to_le_bytes());
        }
    }
    hash.value()
}
