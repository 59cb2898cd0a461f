//! A whole glTF as part of a scene: its meshes in their places, its camera and its lights. A material is the material
//! of the same name in the description, or else diffuse with the glTF's base colour.

mod lights;
mod material;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use snowblue_base::files::{FileError, check_formats, check_total, first_names};
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_files::gltf::{GltfFile, Y_UP_TO_Z_UP};
use snowblue_geometry::shape::Shape;

use crate::camera::View;
use crate::error::SceneError;
use crate::gltf::lights::{lights, view};
use crate::gltf::material::{DEFAULT_INDEX, base_colour_texture, opacity, unread};
use crate::light::Light;
use crate::material::Material;
use crate::material::NamedMaterial;
use crate::material::diffuse::Diffuse;
use crate::material::glass::Glass;
use crate::material::texture::Texture;
use crate::objects::Object;
use crate::scene::SceneDescription;
use crate::shape::{FileMesh, check_closed, check_reach, placement, solid};
use crate::sources::Sources;
use snowblue_base::KeyPath;

/// The parts of a scene that come from a glTF.
#[derive(Default)]
pub(crate) struct GltfScene {
    pub(crate) objects: Vec<Object>,
    pub(crate) view: Option<View>,
    pub(crate) lights: Vec<Light>,
    /// Sentences that say what was changed in meshes.
    pub(crate) notes: Vec<String>,
}

/// Reads the glTF of a scene, if it has one, with y turned to z, around the local origin of the scene; its materials
/// that the description lacks are added to `materials`.
pub(crate) fn read_gltf(
    scene: &SceneDescription,
    materials: &mut Vec<NamedMaterial>,
    sources: &Sources,
) -> Result<GltfScene, SceneError> {
    let Some(name) = &scene.gltf else { return Ok(GltfScene::default()) };
    let path = &KeyPath::root("gltf");
    check_formats(&sources.files.display_name(name))?;
    let file = GltfFile::read(sources.files, name).map_err(|error| sources.named(path, name, error))?;
    let wrong =
        |reason: String| SceneError::File(FileError::Content { path: sources.files.display_name(name), reason });
    let nodes = file.nodes(DAffine3::from_mat3_translation(Y_UP_TO_Z_UP, -scene.local_origin))?;
    let mut meshes = BTreeMap::new();
    let mut objects = Vec::new();
    let mut notes: Vec<String> = file.notes(true).iter().map(|note| format!("{path} is \"{name}\": {note}")).collect();
    let mut palette = Palette {
        file: &file,
        sources,
        own: materials.len(),
        known: BTreeMap::new(),
        texture_bytes: 0.0,
        notes: Vec::new(),
        unread: BTreeMap::new(),
    };
    for node in &nodes {
        let Some(shape) = node.mesh_shape() else { continue };
        let parts = match meshes.entry(shape) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(fresh) => {
                // Parts of one material each, with its index in the scene.
                let mut parts = Vec::new();
                for mut surface in file.surfaces(node)? {
                    let material = palette.index(surface.material, materials)?;
                    if material >= palette.own && surface.mesh.attributes.contains_key("red") {
                        palette.note("vertex colours", &materials[material].name);
                    }
                    if materials[material].material.is_snow() {
                        let name = node.name();
                        let note = solid(&mut surface.mesh).map_err(|reason| wrong(format!("{name}: {reason}")))?;
                        notes.extend(note.map(|note| format!("{path}, {name}: {note}")));
                    }
                    parts.push((material, FileMesh::new(surface.mesh, DVec3::ZERO, true)));
                }
                fresh.insert(parts)
            }
        };
        for (material, FileMesh { mesh, to_original, is_closed }) in parts {
            let (name, material) = (node.name(), *material);
            let NamedMaterial { name: material_name, material: made_of } = &materials[material];
            let misfit = |reason| wrong(format!("{name} of material \"{material_name}\": {reason}"));
            for to_root in &node.instances {
                let placement = placement(&(*to_root * *to_original));
                let placement = placement.map_err(|reason| wrong(format!("{name}: {reason}")))?;
                let instance = Instance::new(Arc::clone(mesh), placement);
                let shape = Shape::Mesh(instance);
                check_reach(&shape).map_err(|reason| wrong(format!("{name} {reason}")))?;
                made_of.check(&shape).map_err(misfit)?;
                objects.push(Object { name: name.clone(), shape, material, body: None, undisturbed: None });
            }
            if scene.integrator.kind.has_light_field() && made_of.is_snow() && !*is_closed {
                check_closed(mesh.triangles()).map_err(misfit)?;
                *is_closed = true;
            }
        }
    }
    notes.extend(palette.notes);
    notes.extend(palette.unread.into_iter().map(|(what, materials)| unread_note(what, &materials)));
    let lights = lights(&nodes, &mut notes).map_err(wrong)?;
    let view = if scene.camera.is_none() { view(&nodes, &mut notes) } else { None };
    Ok(GltfScene { objects, view, lights, notes })
}

/// The conversion of the materials of a glTF to materials of a scene.
struct Palette<'file> {
    file: &'file GltfFile,
    sources: &'file Sources<'file>,
    /// Number of materials of the description.
    own: usize,
    /// For the materials converted so far, the index in the scene by the number in the glTF.
    known: BTreeMap<Option<usize>, usize>,
    /// Memory of the textures so far, in bytes.
    texture_bytes: f64,
    /// Sentences on what is not read.
    notes: Vec<String>,
    /// The names of materials with a property that is not read, by the property.
    unread: BTreeMap<&'static str, Vec<String>>,
}

/// A sentence on a property of materials that is not read.
fn unread_note(what: &str, materials: &[String]) -> String {
    let names = first_names(materials, materials.len());
    format!("glTF materials are diffuse: {what} is not read of {names}")
}

impl Palette<'_> {
    /// Index of the scene's own material of the same name, or of a new material.
    fn index(&mut self, number: Option<usize>, materials: &mut Vec<NamedMaterial>) -> Result<usize, SceneError> {
        if let Some(&index) = self.known.get(&number) {
            return Ok(index);
        }
        // A glTF's default material is white.
        let material = number.and_then(|number| self.file.document().materials().nth(number));
        let name = material.as_ref().and_then(|material| material.name().map(str::to_owned));
        let own = name.as_ref().and_then(|name| materials[..self.own].iter().position(|other| other.name == *name));
        let index = match own {
            Some(index) => index,
            None => {
                let name = name.unwrap_or_else(|| format!("glTF material {}", materials.len()));
                let material = match &material {
                    Some(material) => {
                        unread(material).for_each(|what| self.note(what, &name));
                        self.convert(&name, material)?
                    }
                    None => Material::Diffuse(Diffuse::colored([1.0; 3], self.sources.upsampling), 1.0),
                };
                materials.push(NamedMaterial { name, material });
                materials.len() - 1
            }
        };
        self.known.insert(number, index);
        Ok(index)
    }

    /// Adds a material to the materials with a property that is not read.
    fn note(&mut self, what: &'static str, material: &str) {
        let (materials, name) = (self.unread.entry(what).or_default(), format!("\"{material}\""));
        if !materials.contains(&name) {
            materials.push(name);
        }
    }

    /// Glass, if all light passes the material where it is opaque, else a diffuse material.
    fn convert(&mut self, name: &str, material: &gltf::Material) -> Result<Material, SceneError> {
        let paint = base_colour_texture(self.file, material, self.sources.files)?;
        self.texture_bytes += paint.as_ref().map_or(0.0, Texture::bytes);
        // Any number of materials may have the same image.
        check_total("its textures", self.texture_bytes).map_err(|reason| self.file.wrong(reason))?;
        let [r, g, b, _] = material.pbr_metallic_roughness().base_color_factor();
        let mut transmission = material.transmission().map_or(0.0, |found| found.transmission_factor());
        let mut note = |what: &str| self.notes.push(format!("glTF material \"{name}\" {what}"));
        if material.transmission().is_some_and(|found| found.transmission_texture().is_some()) {
            note("blocks light: its transmission has a texture, which is not read");
            transmission = 0.0;
        } else if transmission >= 1.0 {
            if paint.is_some() || [r, g, b].iter().any(|factor| *factor < 1.0) {
                note("is clear glass: its colour is not read");
            }
            return Ok(Material::Glass(Glass::new(material.ior().unwrap_or(DEFAULT_INDEX).into())));
        }
        let (diffuse, opacity) = match paint {
            Some(texture) => (Diffuse::textured(texture, self.sources.upsampling), 1.0),
            None => (Diffuse::colored([r, g, b], self.sources.upsampling), opacity(material, 1.0)),
        };
        Ok(Material::Diffuse(diffuse, opacity * (1.0 - transmission)))
    }
}
