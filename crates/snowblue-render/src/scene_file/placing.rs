//! The `[[object]]` tables: shapes with their size, turn and place.

use std::path::Path;

use glam::{EulerRot, Mat3A, Vec3, Vec3A};

use crate::cuboid::Cuboid;
use crate::error::RenderError;
use crate::mesh::Mesh;
use crate::objects::{Object, Shape};
use crate::ply_file::read_triangles;
use crate::ray::narrow;
use crate::scene_file::GREATEST_COORDINATE_M;
use crate::scene_file::materials::Named;
use crate::scene_file::section::Section;

/// Least and greatest size of a box, in m.
const BOX_SIZE_M: std::ops::RangeInclusive<f64> = 1e-4..=1e5;

/// Where a shape is and how it is turned.
struct Placing {
    position: Vec3A,
    axes: Mat3A,
}

/// Reads one object; a mesh file is looked for beside the scene file.
pub(super) fn read_object(section: Section, scene: &Path, materials: &[Named]) -> Result<Object, RenderError> {
    let is_box = section.has("shape");
    if is_box {
        section.only(&["shape", "size", "position", "rotation_deg", "material"])?;
    } else {
        section.only(&["mesh", "scale", "position", "rotation_deg", "material"])?;
    }
    let material_name = section.required_text("material")?;
    let Some(material) = materials.iter().position(|(name, _)| name == material_name) else {
        let names: Vec<_> = materials.iter().map(|(name, _)| name.as_str()).collect();
        let reason = format!("object.material is \"{material_name}\", but must be one of {}", names.join(", "));
        return Err(section.error_at("material", reason));
    };
    let anywhere = -GREATEST_COORDINATE_M..=GREATEST_COORDINATE_M;
    let turn = section.vector("rotation_deg", Some(Vec3A::ZERO), -360.0..=360.0, "deg")?;
    let [x, y, z] = turn.to_array().map(f32::to_radians);
    let placing = Placing {
        position: section.vector("position", Some(Vec3A::ZERO), anywhere, "m")?,
        axes: Mat3A::from_euler(EulerRot::ZYX, z, y, x),
    };
    section.choice("shape", (), &[("box", ())])?;
    let shape = match section.text("mesh")? {
        None if is_box => read_box(&section, &placing)?,
        Some(file) => read_mesh(&section, &scene.with_file_name(file), &placing)?,
        None => return Err(section.error("an object must have either `shape` or `mesh`")),
    };
    Ok(Object { shape, material })
}

fn read_box(section: &Section, placing: &Placing) -> Result<Shape, RenderError> {
    let size = section.vector("size", None, BOX_SIZE_M, "m")?;
    Ok(Shape::Cuboid(Cuboid::new(placing.position, size, placing.axes)))
}

fn read_mesh(section: &Section, file: &Path, placing: &Placing) -> Result<Shape, RenderError> {
    let scale = narrow(section.number("scale", Some(1.0), 1e-6..=1e6, "")?);
    if !file.is_file() {
        return Err(section.error_at("mesh", format!("mesh file {} does not exist", file.display())));
    }
    let place = |corner: Vec3| Vec3::from(placing.position + placing.axes * Vec3A::from(corner * scale));
    let triangles: Vec<_> = read_triangles(file)?.into_iter().map(|corners| corners.map(place)).collect();
    let reach = triangles.iter().flatten().map(|corner| corner.abs().max_element()).fold(0.0, f32::max);
    if f64::from(reach) > GREATEST_COORDINATE_M {
        let reason =
            format!("mesh {} reaches to {reach} m, but must lie within {GREATEST_COORDINATE_M} m", file.display());
        return Err(section.error_at("mesh", reason));
    }
    Ok(Shape::Mesh(Mesh::new(&triangles)))
}
