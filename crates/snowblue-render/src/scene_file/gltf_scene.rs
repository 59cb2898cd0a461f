//! A whole glTF as part of a scene: its meshes in their places, made of the materials that the scene file has under
//! their names, and else of diffuse ones as bright as the glTF's base colours; and its camera.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

use crate::camera::View;
use crate::error::RenderError;
use crate::instance::Instance;
use crate::material::Material;
use crate::material::diffuse::Diffuse;
use crate::mesh::Mesh;
use crate::mesh_file::gltf::{GltfFile, Y_UP_TO_Z_UP};
use crate::objects::Object;
use crate::ray::narrow;
use crate::scene_file::materials::Named;
use crate::scene_file::placing::{check_reach, placement};
use crate::shape::Shape;

/// What a glTF adds to a scene.
pub(super) struct GltfScene {
    pub(super) objects: Vec<Object>,
    pub(super) view: Option<View>,
}

/// Reads a glTF with y turned to z; materials that the scene has none for are added to `materials`.
pub(super) fn read_gltf(path: &Path, materials: &mut Vec<Named>) -> Result<GltfScene, RenderError> {
    let file = GltfFile::open(path)?;
    let wrong = |reason: String| RenderError::Mesh { path: path.into(), reason };
    let nodes = file.nodes(DAffine3::from_mat3(Y_UP_TO_Z_UP))?;
    let mut meshes = BTreeMap::new();
    let mut objects = Vec::new();
    for node in &nodes {
        let Some(number) = node.mesh() else { continue };
        let parts = match meshes.entry(number) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(fresh) => fresh.insert(centred_surfaces(&file, number)?),
        };
        for (material, mesh, map) in &*parts {
            let name = node.name();
            let placement = placement(&(node.to_root * *map)).map_err(|reason| wrong(format!("{name}: {reason}")))?;
            let instance = Instance { mesh: Arc::clone(mesh), placement };
            check_reach(instance.bounds().greatest_coordinate()).map_err(|reason| wrong(format!("{name} {reason}")))?;
            let material = material_index(&file, *material, materials);
            objects.push(Object { name, shape: Shape::Mesh(instance), material, body: None });
        }
    }
    Ok(GltfScene { objects, view: file.view(&nodes) })
}

/// The number of a material, its mesh about its own middle, and the map that puts that back.
type Part = (Option<usize>, Arc<Mesh>, DAffine3);

fn centred_surfaces(file: &GltfFile, mesh: usize) -> Result<Vec<Part>, RenderError> {
    let centred = file.surfaces(mesh)?.into_iter().map(|(material, surface)| {
        let (centred, map) = surface.centred();
        (material, Arc::new(Mesh::new(centred)), map)
    });
    Ok(centred.collect())
}

/// The scene's material of that name, or a new one.
fn material_index(file: &GltfFile, material: Option<usize>, materials: &mut Vec<Named>) -> usize {
    // A glTF's default material is white.
    let (name, reflectance) = match material.and_then(|index| file.material(index)) {
        Some((name, colour)) => (name.map(str::to_owned), colour.luminance()),
        None => (None, 1.0),
    };
    let named = name.as_ref().and_then(|name| materials.iter().position(|(other, _)| other == name));
    named.unwrap_or_else(|| {
        let name = name.unwrap_or_else(|| format!("glTF material {}", materials.len()));
        materials.push((name, Material::Diffuse(Diffuse { reflectance: narrow(reflectance) })));
        materials.len() - 1
    })
}
