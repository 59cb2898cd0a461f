//! Objects: shapes and meshes in their places.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use snowblue_geometry::cuboid::Cuboid;
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::mesh_files::read_mesh_from;
use snowblue_geometry::plane::Plane;
use snowblue_geometry::shape::Shape;
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_shapes::igloo::Igloo;

use crate::assembling::carved::carved_mesh;
use crate::assembling::closed::{check_closed, solid};
use crate::assembling::landscape::{self, Land, check_shapes};
use crate::assembling::material::NamedMaterial;
use crate::assembling::placing::{Placing, check_reach, placement, upright};
use crate::assembling::sources::Sources;
use crate::description::value::point;
use crate::description::{IglooDescription, MeshDescription, ObjectDescription, ShapeDescription};
use crate::error::SceneError;
use crate::integrator::IntegratorKind;
use crate::objects::Object;
use crate::undisturbed::UndisturbedSurface;
use snowblue_base::{KeyError, KeyPath};

/// A mesh of a file about its own middle.
struct FileMesh {
    mesh: Arc<MeshBvh>,
    /// The map that puts its middle back.
    to_original: DAffine3,
    /// Whether it is known to be closed.
    is_closed: bool,
}

/// Builds objects; each mesh file is read once.
pub(super) struct ObjectBuilder<'scene> {
    sources: &'scene Sources<'scene>,
    materials: &'scene [NamedMaterial],
    /// The materials of planes of snow, by those of the snow.
    grounds: BTreeMap<usize, usize>,
    /// Meshes by file and part, whether they are smooth, and whether they are snow.
    meshes: BTreeMap<(String, Option<String>, bool, bool), FileMesh>,
    /// Whether snow must be closed.
    has_light_field: bool,
    /// What was changed, in sentences.
    pub(super) notes: Vec<String>,
}

impl<'scene> ObjectBuilder<'scene> {
    /// No mesh is read yet.
    pub(super) fn new(
        sources: &'scene Sources<'scene>,
        materials: &'scene [NamedMaterial],
        grounds: BTreeMap<usize, usize>,
        integrator: IntegratorKind,
    ) -> Self {
        let has_light_field = integrator.has_light_field();
        Self { sources, materials, grounds, meshes: BTreeMap::new(), has_light_field, notes: Vec::new() }
    }

    /// Builds an object, an igloo as one for each block.
    pub(super) fn build(&mut self, path: &KeyPath, object: &ObjectDescription) -> Result<Vec<Object>, SceneError> {
        let mut index = self.material(path, &object.common.material)?;
        if let (ShapeDescription::Plane(_), Some(ground)) = (&object.shape, self.grounds.get(&index)) {
            index = *ground;
        }
        let NamedMaterial { name: material_name, material } = &self.materials[index];
        let is_snow = material.is_snow();
        let mut body = object.common.body.clone();
        if body.is_some() && !is_snow {
            let reason = match object.shape {
                ShapeDescription::Plane(_) => "joins snow, but a plane has no inside".to_owned(),
                _ => format!("joins snow, but the material \"{material_name}\" is diffuse"),
            };
            return Err(path.key("body").error(reason).into());
        }
        let placing = Placing::of(&object.common);
        let mut undisturbed = None;
        let mut land = |land: Land| {
            let surface = land.undisturbed.and_then(|terrain| UndisturbedSurface::new(terrain, placing.to_scene()));
            undisturbed = surface.map(Arc::new);
            Ok::<_, KeyError>(vec![placed(path, &placing, land.solid)?])
        };
        let shapes = match &object.shape {
            ShapeDescription::Box(cuboid) => {
                let size = (point(cuboid.size).as_dvec3() * placing.scale).as_vec3a();
                vec![Shape::Cuboid(Cuboid::new(placing.position, size, placing.axes()))]
            }
            ShapeDescription::Sphere(sphere) => {
                let to_scene = placing.to_scene() * DAffine3::from_scale(DVec3::splat(sphere.radius));
                let ellipsoid = Ellipsoid::new(to_scene);
                let ellipsoid = ellipsoid.ok_or_else(|| path.key("scale").error("flattens the sphere"))?;
                vec![Shape::Ellipsoid(ellipsoid)]
            }
            ShapeDescription::Plane(_) => vec![Shape::Plane(Plane::new(placing.position, placing.axes()))],
            ShapeDescription::Heights(heights) => {
                land(landscape::height_field(path, heights, &object.imprints, self.sources)?)?
            }
            ShapeDescription::Drift(drift) => land(landscape::drift_land(path, drift, &object.imprints)?)?,
            ShapeDescription::Snowpack(snowpack) => {
                land(landscape::snowpack(path, snowpack, &object.imprints, self.sources)?)?
            }
            ShapeDescription::Igloo(igloo) => {
                check_shapes(path)?;
                // The blocks of an igloo are one solid, whether it has a name or not.
                if is_snow {
                    body = body.or_else(|| Some(format!("igloo at {}", placing.position)));
                }
                let blocks = igloo_of(igloo).blocks().into_iter();
                blocks.map(|block| placed(path, &placing, block)).collect::<Result<_, _>>()?
            }
            ShapeDescription::Carved(carved) => vec![placed(path, &placing, carved_mesh(path, carved)?)?],
            ShapeDescription::Mesh(mesh) => vec![self.mesh(path, mesh, &placing, is_snow)?],
        };
        for shape in &shapes {
            material.check(shape).map_err(|reason| {
                path.key("material").error(format!("is \"{material_name}\", which does not fit: {reason}"))
            })?;
        }
        let name = object.shape.name();
        let object = |shape| Object {
            name: name.clone(),
            shape,
            material: index,
            body: body.clone(),
            undisturbed: undisturbed.clone(),
        };
        Ok(shapes.into_iter().map(object).collect())
    }

    /// Index of a material by its name.
    fn material(&self, path: &KeyPath, name: &str) -> Result<usize, KeyError> {
        self.materials.iter().position(|other| other.name == name).ok_or_else(|| {
            let named = &self.materials[..self.materials.len() - self.grounds.len()];
            let names: Vec<_> = named.iter().map(|material| material.name.as_str()).collect();
            path.key("material").error(format!("is \"{name}\", but must be one of {}", names.join(", ")))
        })
    }

    fn mesh(
        &mut self,
        path: &KeyPath,
        description: &MeshDescription,
        placing: &Placing,
        is_snow: bool,
    ) -> Result<Shape, SceneError> {
        let MeshDescription { mesh: file, up, .. } = description;
        let path = path.key("mesh");
        let upright = upright(file, *up);
        let wrong = |reason: String| path.error(format!("is \"{file}\": {reason}"));
        let must_be_closed = is_snow && self.has_light_field;
        let found = self.file_mesh(&path, description, is_snow)?;
        if must_be_closed && !found.is_closed {
            check_closed(found.mesh.triangles()).map_err(wrong)?;
            found.is_closed = true;
        }
        let placement = placement(&(placing.to_scene() * upright * found.to_original)).map_err(wrong)?;
        let instance = Instance::new(Arc::clone(&found.mesh), placement);
        check_reach(instance.bounds().greatest_coordinate()).map_err(wrong)?;
        Ok(Shape::Mesh(instance))
    }

    fn file_mesh(
        &mut self,
        path: &KeyPath,
        description: &MeshDescription,
        is_snow: bool,
    ) -> Result<&mut FileMesh, SceneError> {
        let MeshDescription { mesh: file, part, smooth, .. } = description;
        Ok(match self.meshes.entry((file.clone(), part.clone(), *smooth, is_snow)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(fresh) => {
                let read = read_mesh_from(self.sources.files, file, part.as_deref());
                let mut read = read.map_err(|error| self.sources.named(path, file, error))?;
                if is_snow {
                    let note = solid(&mut read).map_err(|reason| path.error(format!("is \"{file}\": {reason}")))?;
                    self.notes.extend(note.map(|note| format!("{path} is \"{file}\": {note}")));
                }
                let centred = read.centred();
                let mesh = if *smooth { centred.mesh.smooth() } else { centred.mesh.flat() };
                let (mesh, to_original) = (Arc::new(MeshBvh::new(mesh)), centred.to_original);
                fresh.insert(FileMesh { mesh, to_original, is_closed: false })
            }
        })
    }
}

impl ShapeDescription {
    /// What its object is called in reports.
    fn name(&self) -> String {
        let name = match self {
            Self::Box(_) => "box",
            Self::Sphere(_) => "sphere",
            Self::Plane(_) => "plane",
            Self::Heights(_) => "heights",
            Self::Drift(_) => "drift",
            Self::Snowpack(_) => "snowpack",
            Self::Igloo(_) => "igloo",
            Self::Carved(_) => "carved",
            Self::Mesh(MeshDescription { mesh, part: Some(part), .. }) => return format!("{mesh} {part}"),
            Self::Mesh(MeshDescription { mesh, part: None, .. }) => mesh,
        };
        name.to_owned()
    }
}

fn igloo_of(description: &IglooDescription) -> Igloo {
    Igloo {
        inner_radius_m: description.inner_radius,
        wall_m: description.wall,
        courses: description.courses,
        block_width_m: description.block_width,
        seam_depth_m: description.seam_depth.unwrap_or(0.25 * description.wall),
        seam_width_m: description.seam_width,
        seed: description.seed,
    }
}

/// A solid with its transform.
fn placed(path: &KeyPath, placing: &Placing, triangles: TriangleMesh) -> Result<Shape, KeyError> {
    let centred = triangles.centred();
    let wrong = |reason: String| path.error(format!("is misplaced: {reason}"));
    let placement = placement(&(placing.to_scene() * centred.to_original)).map_err(wrong)?;
    let instance = Instance::new(Arc::new(MeshBvh::new(centred.mesh.smooth())), placement);
    check_reach(instance.bounds().greatest_coordinate()).map_err(wrong)?;
    Ok(Shape::Mesh(instance))
}
