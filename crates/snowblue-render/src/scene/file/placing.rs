//! What all `[[object]]` tables have: a place, a turn, a stretch, a material, a body.

use glam::{DAffine3, DMat3, DVec3, EulerRot, Mat3A, Vec3A};

use crate::error::RenderError;
use crate::geometry::placement::Placement;
use crate::scene::file::GREATEST_COORDINATE_M;
use crate::scene::file::materials::Named;
use crate::scene::file::section::Section;
use crate::scene::material::Material;

/// Least and greatest stretch of a shape.
const SCALE: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Where a shape is, how it is turned and how it is stretched.
pub(super) struct Placing {
    pub(super) position: Vec3A,
    turn: DMat3,
    pub(super) scale: DVec3,
}

impl Placing {
    /// Reads `position`, `rotation_deg` and `scale`, a number or three.
    pub(super) fn read(section: &Section) -> Result<Self, RenderError> {
        let anywhere = -GREATEST_COORDINATE_M..=GREATEST_COORDINATE_M;
        let turn = section.vector("rotation_deg", Some(Vec3A::ZERO), -360.0..=360.0, "deg")?;
        let [x, y, z] = turn.as_dvec3().to_array().map(f64::to_radians);
        let scale = if section.is_list("scale") {
            section.vector("scale", None, SCALE, "")?.as_dvec3()
        } else {
            DVec3::splat(section.number("scale", Some(1.0), SCALE, "")?)
        };
        Ok(Self {
            position: section.vector("position", Some(Vec3A::ZERO), anywhere, "m")?,
            turn: DMat3::from_euler(EulerRot::ZYX, z, y, x),
            scale,
        })
    }

    /// The directions of the shape's axes in the scene.
    pub(super) fn axes(&self) -> Mat3A {
        self.turn.as_mat3().into()
    }

    /// From the shape's coordinates into the scene.
    pub(super) fn to_scene(&self) -> DAffine3 {
        DAffine3::from_mat3_translation(self.turn * DMat3::from_diagonal(self.scale), self.position.as_dvec3())
    }
}

/// The placement by a map, or what is wrong with it.
pub(super) fn placement(to_scene: &DAffine3) -> Result<Placement, String> {
    Placement::new(to_scene).ok_or_else(|| "its transform flattens it, but must keep its volume".to_owned())
}

/// Refuses boxes around things that reach farther than a scene may.
pub(super) fn check_reach(reach_m: f32) -> Result<(), String> {
    if f64::from(reach_m) <= GREATEST_COORDINATE_M {
        return Ok(());
    }
    Err(format!("reaches to {reach_m} m, but must lie within {GREATEST_COORDINATE_M} m"))
}

/// Index of the material that an object names.
pub(super) fn read_material_name(section: &Section, materials: &[Named]) -> Result<usize, RenderError> {
    let name = section.required_text("material")?;
    materials.iter().position(|(other, _)| other == name).ok_or_else(|| {
        let names: Vec<_> = materials.iter().map(|(name, _)| name.as_str()).collect();
        let reason = format!("object.material is \"{name}\", but must be one of {}", names.join(", "));
        section.error_at("material", reason)
    })
}

/// The name of the body that an object of snow belongs to.
pub(super) fn read_body(section: &Section, material: &Named) -> Result<Option<String>, RenderError> {
    let body = section.text("body")?;
    match (body, &material.1) {
        (Some(_), Material::Diffuse(_)) => {
            let reason = format!("object.body joins snow, but the material \"{}\" is diffuse", material.0);
            Err(section.error_at("body", reason))
        }
        _ => Ok(body.map(str::to_owned)),
    }
}
