//! The `[[object]]` tables: shapes and meshes with their sizes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3A};

use crate::error::RenderError;
use crate::files::FilesIn;
use crate::geometry::cuboid::Cuboid;
use crate::geometry::ellipsoid::Ellipsoid;
use crate::geometry::instance::Instance;
use crate::geometry::mesh::Mesh;
use crate::geometry::plane::Plane;
use crate::geometry::ray::narrow;
use crate::geometry::shape::Shape;
use crate::geometry::triangle_mesh::TriangleMesh;
use crate::mesh_files::gltf::Y_UP_TO_Z_UP;
use crate::mesh_files::{is_y_up, read_mesh_file};
use crate::scene::file::GREATEST_COORDINATE_M;
use crate::scene::file::materials::Named;
use crate::scene::file::placing::{Placing, check_reach, placement, read_body, read_material_name};
use crate::scene::file::section::Section;
use crate::scene::material::Material;
use crate::scene::objects::Object;
use crate::shapes::drift::{Mound, drift};
use crate::shapes::height_field::Heights;
use crate::shapes::igloo::Igloo;

/// Least and greatest size of a shape, in m.
pub(super) const SIZE_M: std::ops::RangeInclusive<f64> = 1e-4..=1e5;

/// The shapes that have a name.
#[derive(Clone, Copy)]
enum Kind {
    Box,
    Sphere,
    Plane,
    Heights,
    Drift,
    Igloo,
}

/// Mesh files that were read: each is there once, with the map from its centred form to its own coordinates.
#[derive(Default)]
pub(super) struct Meshes(BTreeMap<(PathBuf, Option<String>), (Arc<Mesh>, DAffine3)>);

impl Meshes {
    fn get(&mut self, file: PathBuf, part: Option<&str>) -> Result<(Arc<Mesh>, DAffine3), RenderError> {
        let key = (file, part.map(str::to_owned));
        if let Some((mesh, map)) = self.0.get(&key) {
            return Ok((Arc::clone(mesh), *map));
        }
        let centred = read_mesh_file(&key.0, part)?.centred();
        let (mesh, map) = (Arc::new(Mesh::new(centred.mesh)), centred.to_original);
        self.0.insert(key, (Arc::clone(&mesh), map));
        Ok((mesh, map))
    }
}

const KINDS: [(&str, Kind); 6] = [
    ("box", Kind::Box),
    ("sphere", Kind::Sphere),
    ("plane", Kind::Plane),
    ("heights", Kind::Heights),
    ("drift", Kind::Drift),
    ("igloo", Kind::Igloo),
];

/// Reads one object, an igloo as one for each block; a mesh file is looked for beside the scene file.
pub(super) fn read_object(
    section: &Section,
    scene: &Path,
    materials: &[Named],
    meshes: &mut Meshes,
) -> Result<Vec<Object>, RenderError> {
    let material = read_material_name(section, materials)?;
    let placing = Placing::read(section)?;
    let mut body = read_body(section, &materials[material])?;
    let (name, shapes) = match (section.text("shape")?, section.text("mesh")?) {
        (Some(name), None) => {
            let shapes = match section.choice("shape", Kind::Box, &KINDS)? {
                Kind::Box => vec![read_box(section, &placing)?],
                Kind::Sphere => vec![read_sphere(section, &placing)?],
                Kind::Heights => vec![read_heights(section, scene, &placing)?],
                Kind::Drift => vec![read_drift(section, &placing)?],
                Kind::Plane => vec![read_plane(section, &placing, &materials[material].1)?],
                Kind::Igloo => {
                    // The blocks of an igloo are one solid, whether it has a name or not.
                    if matches!(materials[material].1, Material::PcaSnow(_)) {
                        body = body.or_else(|| Some(format!("igloo at {}", placing.position)));
                    }
                    read_igloo(section, &placing)?
                }
            };
            (name.to_owned(), shapes)
        }
        (None, Some(file)) => {
            only(section, &["mesh", "part", "up"])?;
            let part = section.text("part")?;
            let name = part.map_or_else(|| file.to_owned(), |part| format!("{file} {part}"));
            (name, vec![read_mesh(section, scene.with_file_name(file), &placing, meshes)?])
        }
        _ => return Err(section.error("an object must have either `shape` or `mesh`")),
    };
    let (material_name, made_of) = &materials[material];
    let misfit = |reason| section.error_at("material", format!("object.material \"{material_name}\": {reason}"));
    for shape in &shapes {
        made_of.check(shape).map_err(misfit)?;
    }
    Ok(shapes.into_iter().map(|shape| Object { name: name.clone(), shape, material, body: body.clone() }).collect())
}

/// Refuses keys that neither this kind of object has nor all.
fn only(section: &Section, own: &[&str]) -> Result<(), RenderError> {
    section.only(&[own, &["scale", "position", "rotation_deg", "material", "body"]].concat())
}

fn read_box(section: &Section, placing: &Placing) -> Result<Shape, RenderError> {
    only(section, &["shape", "size"])?;
    let size = section.vector("size", None, SIZE_M, "m")?;
    let size = (size.as_dvec3() * placing.scale).as_vec3a();
    Ok(Shape::Cuboid(Cuboid::new(placing.position, size, placing.axes())))
}

fn read_sphere(section: &Section, placing: &Placing) -> Result<Shape, RenderError> {
    only(section, &["shape", "radius"])?;
    let radius_m = section.number("radius", None, SIZE_M, "m")?;
    let to_scene = placing.to_scene() * DAffine3::from_scale(DVec3::splat(radius_m));
    let ellipsoid = Ellipsoid::new(to_scene);
    ellipsoid.map(Shape::Ellipsoid).ok_or_else(|| section.error_at("scale", "object.scale flattens the sphere"))
}

fn read_plane(section: &Section, placing: &Placing, material: &Material) -> Result<Shape, RenderError> {
    section.only(&["shape", "position", "rotation_deg", "material"])?;
    if matches!(material, Material::PcaSnow(_)) {
        let reason = "a plane has no inside and cannot be snow; a box of 1000 m does for an endless layer";
        return Err(section.error_at("material", reason));
    }
    Ok(Shape::Plane(Plane::new(placing.position, placing.axes())))
}

/// Heights from a list of rows or a picture, as a solid.
fn read_heights(section: &Section, scene: &Path, placing: &Placing) -> Result<Shape, RenderError> {
    only(section, &["shape", "size", "heights", "file", "bottom"])?;
    let heights = match (section.rows("heights")?, section.text("file")?) {
        (Some((columns, values)), None) => {
            Heights::new(columns, values).map_err(|reason| section.error_at("heights", format!("object.{reason}")))?
        }
        (None, Some(file)) => {
            let file = scene.with_file_name(file);
            if !file.is_file() {
                return Err(section.error_at("file", format!("file of heights {} does not exist", file.display())));
            }
            Heights::read(&FilesIn::beside(&file), &file.file_name().unwrap_or_default().to_string_lossy())?
        }
        _ => return Err(section.error("heights must be given either as `heights` or as `file`")),
    };
    let size = section.vector("size", None, SIZE_M, "m")?;
    let anywhere = -GREATEST_COORDINATE_M..=GREATEST_COORDINATE_M;
    let bottom_m = narrow(section.number("bottom", None, anywhere, "m")?);
    let solid = heights.solid(size.into(), bottom_m);
    made(section, placing, solid.map_err(|reason| section.error_at("bottom", format!("object.{reason}")))?)
}

/// Ground under snow, with mounds.
fn read_drift(section: &Section, placing: &Placing) -> Result<Shape, RenderError> {
    only(section, &["shape", "size", "mounds", "relief", "seed"])?;
    let size_m = section.vector("size", None, SIZE_M, "m")?.as_dvec3();
    let (columns, numbers) = section.rows("mounds")?.unwrap_or((4, Vec::new()));
    let right = |row: &[f32]| row.iter().all(|number| number.is_finite()) && row[2] > 0.0 && row[3] > 0.0;
    if columns != 4 || !numbers.chunks_exact(4).all(right) {
        let reason = "object.mounds must be rows of x, y, height and radius in m, the last two above 0";
        return Err(section.error_at("mounds", reason));
    }
    let mounds: Vec<Mound> = numbers
        .chunks_exact(4)
        .map(|row| row.iter().copied().map(f64::from).collect::<Vec<_>>())
        .map(|row| Mound { middle_m: DVec2::new(row[0], row[1]), height_m: row[2], radius_m: row[3] })
        .collect();
    let relief_m = section.number("relief", Some(0.0), 0.0..=1.0, "m")?;
    let solid = drift(size_m, &mounds, relief_m, section.count("seed", 1, 0..=u32::MAX)?);
    made(section, placing, solid.map_err(|reason| section.error_at("size", format!("object.size: {reason}")))?)
}

/// The blocks of an igloo.
fn read_igloo(section: &Section, placing: &Placing) -> Result<Vec<Shape>, RenderError> {
    only(section, &["shape", "inner_radius", "wall", "courses", "block_width", "seam_depth", "seam_width", "seed"])?;
    let inner_radius_m = section.number("inner_radius", Some(1.5), 0.5..=10.0, "m")?;
    let wall_m = section.number("wall", Some(0.15), 0.02..=0.5 * inner_radius_m, "m")?;
    let courses = section.count("courses", 6, 2..=20)?;
    let igloo = Igloo {
        inner_radius_m,
        wall_m,
        courses,
        block_width_m: section.number("block_width", Some(0.6), 0.1..=inner_radius_m, "m")?,
        // The relief must not break through a seam.
        seam_depth_m: section.number("seam_depth", Some(0.25 * wall_m), 0.0..=0.4 * wall_m, "m")?,
        seam_width_m: section.number("seam_width", Some(0.05), 0.005..=0.5, "m")?,
        seed: section.count("seed", 1, 0..=u32::MAX)?,
    };
    igloo.blocks().into_iter().map(|block| made(section, placing, block)).collect()
}

/// Puts triangles made here in their place.
fn made(section: &Section, placing: &Placing, triangles: TriangleMesh) -> Result<Shape, RenderError> {
    let centred = triangles.centred();
    let wrong = |reason: String| section.error(format!("object: {reason}"));
    let placement = placement(&(placing.to_scene() * centred.to_original)).map_err(wrong)?;
    let instance = Instance::new(Arc::new(Mesh::new(centred.mesh)), placement);
    check_reach(instance.bounds().greatest_coordinate()).map_err(wrong)?;
    Ok(Shape::Mesh(instance))
}

fn read_mesh(section: &Section, file: PathBuf, placing: &Placing, meshes: &mut Meshes) -> Result<Shape, RenderError> {
    if !file.is_file() {
        return Err(section.error_at("mesh", format!("mesh file {} does not exist", file.display())));
    }
    let y_up = section.choice("up", is_y_up(&file), &[("y", true), ("z", false)])?;
    let upright = DAffine3::from_mat3(if y_up { Y_UP_TO_Z_UP } else { DMat3::IDENTITY });
    let named = format!("mesh {}", file.display());
    let (mesh, map) = meshes.get(file, section.text("part")?)?;
    let wrong = |reason: String| section.error_at("mesh", format!("{named}: {reason}"));
    let placement = placement(&(placing.to_scene() * upright * map)).map_err(wrong)?;
    let instance = Instance::new(mesh, placement);
    let bounds = instance.bounds();
    check_reach(bounds.greatest_coordinate())
        .map_err(|reason| section.error_at("mesh", format!("{named} {reason}")))?;
    Ok(Shape::Mesh(instance))
}

/// Whether a point lies inside snow, and then in which object.
pub(super) fn snow_around(
    objects: &crate::scene::objects::Objects,
    materials: &[Named],
    point: Vec3A,
) -> Option<usize> {
    (0..objects.list().len()).find(|&index| {
        let is_snow = matches!(materials[objects.list()[index].material].1, Material::PcaSnow(_));
        is_snow && objects.holds(index, point)
    })
}
