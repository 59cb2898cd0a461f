//! glTF 2.0 and GLB files (Khronos Group 2021, "glTF 2.0 specification", ISO/IEC 12113:2022): nodes with their
//! transforms, and meshes. All other content of a file, such as materials, cameras and lights, is in its
//! [document](GltfFile::document).
//!
//! Reads triangles with `POSITION`, `NORMAL`, `TEXCOORD_1` (attributes `lightmap_u`, `lightmap_v`), `COLOR_0` (`red`,
//! `green`, `blue`) and application-specific scalar attributes, whose names begin with an underscore. Texture
//! coordinates are the coordinates of the base colour texture, transformed by KHR_texture_transform, or else
//! `TEXCOORD_0`. Morph targets have the default weights. EXT_mesh_gpu_instancing places a mesh several times.
//! [`notes`](GltfFile::notes) names what is not read.

mod checked;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Mat2, Vec2, Vec3};
use gltf::accessor::Dimensions;
use gltf::json::Value;
use gltf::mesh::Mode;
use gltf::texture::{Info, TextureTransform};
use gltf::{Accessor, Document, Image, Node, Primitive, Scene, Semantic};

use crate::mesh_files::faces::strip;
use crate::mesh_files::read_mesh::ReadMesh;
use crate::transform::origin_near;
use crate::triangle_mesh::{SECOND_UV, TriangleMesh};
use crate::vertex_normals::VertexNormals;
use percent_encoding::percent_decode_str;
use snowblue_base::narrow;

use checked::{READ_EXTENSIONS, ValidGltf, numbers, valid, whole};
use snowblue_base::files::{FileError, FileSource, NamedFile, check_memory, check_total, name_beside};

/// Maps the axes of glTF (y up, z towards the viewer) to the axes of a scene (z up, y away from the viewer).
pub const Y_UP_TO_Z_UP: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);

/// Memory of an instance of a mesh in a scene, in bytes.
const BYTES_PER_INSTANCE: f64 = 512.0;

/// A glTF file with its buffers.
#[derive(Debug)]
pub struct GltfFile {
    name: String,
    path: PathBuf,
    document: Document,
    /// The translation of each node, if it is stated. The document has it in single precision.
    translations: Vec<Option<DVec3>>,
    buffers: Vec<Vec<u8>>,
    /// Length of the file and its buffers, in bytes.
    size: usize,
}

/// A node with its transform to the root.
#[derive(Debug, Clone)]
pub struct PlacedNode<'file> {
    /// The node in the document.
    pub node: Node<'file>,
    /// Maps the node's coordinates to the coordinates of the scene.
    pub to_root: DAffine3,
    /// Maps the coordinates of the node's mesh to the coordinates of the scene, for each instance of the mesh.
    pub instances: Vec<DAffine3>,
    /// Whether the node, its mesh or an ancestor has the requested name.
    named: bool,
}

/// The triangles of a mesh with one material.
#[derive(Debug, Clone, PartialEq)]
pub struct GltfSurface {
    /// Index of the material in the file; none for the default material.
    pub material: Option<usize>,
    /// The triangles, in object space.
    pub mesh: TriangleMesh,
}

impl PlacedNode<'_> {
    /// The name of the node or its mesh, or else its index in the file.
    pub fn name(&self) -> String {
        let mesh_name = self.node.mesh().and_then(|mesh| mesh.name().map(str::to_owned));
        self.node.name().map(str::to_owned).or(mesh_name).unwrap_or_else(|| format!("node {}", self.node.index()))
    }

    /// The shape of its mesh, if it has a mesh.
    pub fn mesh_shape(&self) -> Option<MeshShape> {
        let with_own_weights = self.node.weights().map(|_| self.node.index());
        self.node.mesh().map(|mesh| MeshShape { mesh: mesh.index(), with_own_weights })
    }
}

/// A mesh with weights of its morph targets. Nodes share it unless they have weights of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct MeshShape {
    /// Index of the mesh in the file.
    mesh: usize,
    /// Index of the node whose weights the morph targets have; none for the weights of the mesh.
    with_own_weights: Option<usize>,
}

impl GltfFile {
    /// Reads a `.gltf` or `.glb` file and its buffers. Buffer names are relative to the file's own name.
    ///
    /// # Errors
    ///
    /// When a file cannot be read, or is truncated or malformed.
    pub fn read(files: &dyn FileSource, name: &str) -> Result<Self, FileError> {
        let NamedFile { path, bytes } = NamedFile::read(files, name)?;
        let wrong = |reason: String| FileError::Content { path: path.clone(), reason };
        let ValidGltf { document, mut blob, translations } =
            valid(&bytes).map_err(|reason| wrong(format!("not a readable glTF file: {reason}")))?;
        let (name, size) = (name.to_owned(), bytes.len());
        let mut file = Self { name, path, document, translations, buffers: Vec::new(), size };
        for buffer in file.document.buffers() {
            let content = file.buffer(&buffer, &mut blob, files)?;
            file.size = file.size.saturating_add(content.len());
            check_total("its buffers", file.size as f64).map_err(|reason| file.wrong(reason))?;
            file.buffers.push(content);
        }
        Ok(file)
    }

    /// The content of a buffer. The content of the binary chunk is taken from `blob`, since only one buffer may have
    /// it.
    fn buffer(
        &self,
        buffer: &gltf::Buffer,
        blob: &mut Option<Vec<u8>>,
        files: &dyn FileSource,
    ) -> Result<Vec<u8>, FileError> {
        let number = buffer.index();
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => {
                blob.take().ok_or_else(|| self.wrong(format!("buffer {number} is missing from the file")))?
            }
            gltf::buffer::Source::Uri(uri) => self.uri(uri, &format!("buffer {number}"), files)?,
        };
        if bytes.len() < buffer.length() {
            let (found, wanted) = (bytes.len(), buffer.length());
            let reason = format!("buffer {number} has {found} bytes, but must have {wanted}: the file is truncated");
            return Err(self.wrong(reason));
        }
        Ok(bytes)
    }

    /// The bytes of a data URI, or of the file that the URI names.
    fn uri(&self, uri: &str, what: &str, files: &dyn FileSource) -> Result<Vec<u8>, FileError> {
        let Some(data) = uri.strip_prefix("data:") else {
            let name = name_beside(&self.name, &percent_decode_str(uri).decode_utf8_lossy());
            return NamedFile::read(files, &name).map(|file| file.bytes);
        };
        let text = data.split_once(";base64,").map(|(_, text)| text);
        let text = text.ok_or_else(|| self.wrong(format!("{what} must be encoded as base64")))?;
        STANDARD.decode(text).map_err(|error| self.wrong(format!("{what} is not base64: {error}")))
    }

    /// The default scene, or else the first.
    fn scene(&self) -> Option<Scene<'_>> {
        self.document.default_scene().or_else(|| self.document.scenes().next())
    }

    /// The nodes of the default scene, parents before children, with the root transformed by `root`.
    ///
    /// # Errors
    ///
    /// When the file has no scene, a node has two parents or is its own ancestor, or the meshes of all nodes would take
    /// too much memory.
    pub fn nodes(&self, root: DAffine3) -> Result<Vec<PlacedNode<'_>>, FileError> {
        self.nodes_named(root, None)
    }

    fn nodes_named(&self, root: DAffine3, name: Option<&str>) -> Result<Vec<PlacedNode<'_>>, FileError> {
        let scene = self.scene().ok_or_else(|| self.wrong("the file has no scene".into()))?;
        let mut nodes = Vec::new();
        let mut pending: Vec<_> = scene.nodes().map(|node| (node, root, name.is_none())).collect();
        pending.reverse();
        let mut visited = vec![false; self.document.nodes().len()];
        let mut instance_count = 0;
        while let Some((node, parent, named)) = pending.pop() {
            let index = node.index();
            if std::mem::replace(&mut visited[index], true) {
                return Err(self.wrong(format!("node {index} has two parents")));
            }
            let local = DMat4::from_cols_array_2d(&node.transform().matrix().map(|column| column.map(f64::from)));
            let mut local = DAffine3::from_mat4(local);
            local.translation = self.translations[index].unwrap_or(local.translation);
            let to_root = parent * local;
            let mesh_named = node.mesh().is_some_and(|mesh| name.is_some() && mesh.name() == name);
            let named = named || mesh_named || (name.is_some() && node.name() == name);
            let children: Vec<_> = node.children().collect();
            pending.extend(children.into_iter().rev().map(|child| (child, to_root, named)));
            let instances = self.instances(&node, to_root, instance_count);
            let instances = instances.map_err(|reason| self.wrong(format!("node {index}: {reason}")))?;
            instance_count += instances.len();
            nodes.push(PlacedNode { node, to_root, instances, named });
        }
        let shapes: BTreeSet<MeshShape> = nodes.iter().filter_map(PlacedNode::mesh_shape).collect();
        self.check_mesh_memory("its meshes", shapes.iter().map(|shape| shape.mesh))?;
        Ok(nodes)
    }

    /// The places of the mesh of a node (Khronos Group 2022, EXT_mesh_gpu_instancing), which come after `others`.
    fn instances(&self, node: &Node, to_root: DAffine3, others: usize) -> Result<Vec<DAffine3>, String> {
        let Some(extension) = node.extension_value("EXT_mesh_gpu_instancing") else { return Ok(vec![to_root]) };
        let attributes = &extension["attributes"];
        let translations = self.of_instances(attributes, "TRANSLATION", Dimensions::Vec3)?;
        let rotations = self.of_instances(attributes, "ROTATION", Dimensions::Vec4)?;
        let scales = self.of_instances(attributes, "SCALE", Dimensions::Vec3)?;
        let lengths = [translations.len(), rotations.len(), scales.len()];
        let count = lengths.into_iter().max().unwrap_or(0);
        if count == 0 || lengths.iter().any(|length| ![0, count].contains(length)) {
            return Err("the attributes of its instances are missing, or differ in their numbers".into());
        }
        check_memory("all instances", (others + count) as f64 * BYTES_PER_INSTANCE, self.size)?;
        let place = |number: usize| {
            let translation = translations.get(number).map_or(DVec3::ZERO, |own| DVec3::from_array(*own));
            let rotation = rotations.get(number).map_or(DQuat::IDENTITY, |own| DQuat::from_array(*own).normalize());
            let scale = scales.get(number).map_or(DVec3::ONE, |own| DVec3::from_array(*own));
            to_root * DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        };
        Ok((0..count).map(place).collect())
    }

    /// An attribute of instances; empty if they lack it.
    fn of_instances<const WIDTH: usize>(
        &self,
        attributes: &Value,
        name: &str,
        dimensions: Dimensions,
    ) -> Result<Vec<[f64; WIDTH]>, String> {
        let Some(index) = attributes.get(name) else { return Ok(Vec::new()) };
        let number = index.as_u64().and_then(|number| usize::try_from(number).ok());
        let accessor = number.and_then(|number| self.document.accessors().nth(number));
        let accessor =
            accessor.ok_or_else(|| format!("{name} of its instances is accessor {index}, which is missing"))?;
        Ok(numbers(&accessor, dimensions, &self.buffers)?.as_chunks().0.to_vec())
    }

    /// Sentences on content of the file that changes shapes or, where its materials count, light, but is not read.
    pub fn notes(&self, with_materials: bool) -> Vec<String> {
        let primitives = || self.document.meshes().flat_map(|mesh| mesh.primitives());
        let counts = |name: &&str| with_materials || !name.starts_with("KHR_materials_");
        let unread = self.document.extensions_used().filter(|name| !READ_EXTENSIONS.contains(name));
        let unread: Vec<&str> = unread.filter(counts).collect();
        let scene = |scene: Scene| scene.name().map_or_else(|| scene.index().to_string(), |name| format!("\"{name}\""));
        let read = self.scene().map(scene).unwrap_or_default();
        let lines = primitives().filter(|primitive| triangles(primitive.mode(), &[0; 3]).is_empty()).count();
        let notes = [
            (!unread.is_empty(), format!("extensions that are not read: {}", unread.join(", "))),
            (self.document.scenes().len() > 1, format!("only one of its scenes is read: {read}")),
            (self.document.skins().len() > 0, "skins are not read: meshes have their shape without a pose".into()),
            (self.document.animations().len() > 0, "animations are not read: nodes are in their default places".into()),
            (lines > 0, format!("points and lines have no area and are left out: {lines} primitives")),
        ];
        notes.into_iter().filter(|(is_so, _)| *is_so).map(|(_, note)| note).collect()
    }

    /// Refuses meshes, given by their indices, that take too much memory together.
    fn check_mesh_memory(&self, what: &str, meshes: impl Iterator<Item = usize>) -> Result<(), FileError> {
        let bytes: Vec<f64> =
            self.document.meshes().map(|mesh| mesh.primitives().map(|primitive| bytes_of(&primitive)).sum()).collect();
        let asked = meshes.map(|mesh| bytes[mesh]).sum();
        check_memory(what, asked, self.size).map_err(|reason| self.wrong(reason))
    }

    /// All triangles of the file in its own axes, or only the triangles of the nodes or meshes named `part` and their
    /// descendants.
    ///
    /// # Errors
    ///
    /// When a mesh is malformed, or no node or mesh has that name.
    pub fn mesh(&self, part: Option<&str>) -> Result<ReadMesh, FileError> {
        let mut whole = TriangleMesh::default();
        let mut nodes = self.nodes_named(DAffine3::IDENTITY, part)?;
        nodes.retain(|node| node.named);
        let with_mesh = || nodes.iter().filter_map(|node| Some((node, node.mesh_shape()?.mesh)));
        let copies = with_mesh().flat_map(|(node, mesh)| node.instances.iter().map(move |_| mesh));
        self.check_mesh_memory("the meshes of its nodes", copies)?;
        let origin = with_mesh().next().map_or(DVec3::ZERO, |(node, _)| origin_near(node.to_root.translation));
        for (node, _) in with_mesh() {
            for surface in self.surfaces(node)? {
                for to_root in &node.instances {
                    let near_origin = DAffine3::from_translation(-origin) * *to_root;
                    whole.append(&surface.mesh, &near_origin).map_err(|reason| self.wrong(reason))?;
                }
            }
        }
        match part {
            Some(part) if nodes.is_empty() => {
                Err(self.wrong(format!("its scene has no node or mesh named \"{part}\"")))
            }
            _ => Ok(ReadMesh { mesh: whole, origin, notes: self.notes(false) }),
        }
    }

    /// The triangles of the mesh of a node in object space, grouped by material; none without a mesh.
    ///
    /// # Errors
    ///
    /// When the mesh data are malformed or missing.
    pub fn surfaces(&self, node: &PlacedNode) -> Result<Vec<GltfSurface>, FileError> {
        let mut surfaces: Vec<GltfSurface> = Vec::new();
        let Some(mesh) = node.node.mesh() else { return Ok(surfaces) };
        let weights = node.node.weights().or(mesh.weights()).unwrap_or_default();
        for primitive in mesh.primitives() {
            let triangles = self.primitive(&primitive, weights);
            let triangles = triangles.map_err(|reason| self.wrong(format!("mesh {}: {reason}", mesh.index())))?;
            let material = primitive.material().index();
            match surfaces.iter_mut().find(|surface| surface.material == material) {
                Some(surface) => {
                    surface.mesh.append(&triangles, &DAffine3::IDENTITY).map_err(|reason| self.wrong(reason))?;
                }
                None => surfaces.push(GltfSurface { material, mesh: triangles }),
            }
        }
        surfaces.retain(|surface| !surface.mesh.indices.is_empty());
        Ok(surfaces)
    }

    fn primitive(&self, primitive: &Primitive, weights: &[f32]) -> Result<TriangleMesh, String> {
        let read = |accessor: &Accessor<'_>, dimensions| numbers(accessor, dimensions, &self.buffers);
        let positions = primitive.get(&Semantic::Positions).ok_or("there are no positions")?;
        let targets = || primitive.morph_targets().zip(weights).filter(|(_, weight)| **weight != 0.0);
        let moves = targets().map(|(target, weight)| (target.positions(), *weight));
        let positions = self.vectors(&positions, moves)?;
        if let Some(value) = positions.iter().flat_map(|position| position.to_array()).find(|value| !value.is_finite())
        {
            return Err(format!("a coordinate is {value}, but must be finite"));
        }
        let indices: Vec<u32> = match primitive.indices() {
            Some(accessor) => read(&accessor, Dimensions::Scalar)?.into_iter().map(whole).collect(),
            None => (0..u32::try_from(positions.len()).map_err(|_| "there are too many vertices")?).collect(),
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= positions.len()) {
            return Err(format!(
                "a triangle refers to vertex {index}, but there are {} (0 is the first)",
                positions.len()
            ));
        }
        let normals = match primitive.get(&Semantic::Normals) {
            Some(accessor) => self.vectors(&accessor, targets().map(|(target, weight)| (target.normals(), *weight)))?,
            None => Vec::new(),
        };
        let uv = self.texture_coordinates(primitive)?;
        let mut attributes = BTreeMap::new();
        for (semantic, accessor) in primitive.attributes() {
            let kind = accessor.dimensions();
            let names: Vec<String> = match (semantic, kind) {
                (Semantic::Extras(name), Dimensions::Scalar) => vec![format!("_{name}")],
                (Semantic::Colors(0), Dimensions::Vec3 | Dimensions::Vec4) => {
                    ["red", "green", "blue"].map(str::to_owned).into()
                }
                (Semantic::TexCoords(1), Dimensions::Vec2) => SECOND_UV.map(str::to_owned).into(),
                _ => continue,
            };
            let values = read(&accessor, kind)?;
            for (channel, name) in names.into_iter().enumerate() {
                let channel = values.chunks_exact(kind.multiplicity()).map(|element| narrow(element[channel]));
                attributes.insert(name, channel.collect());
            }
        }
        let count = positions.len();
        let differs = |length: usize| length != 0 && length != count;
        if differs(uv.len())
            || differs(normals.len())
            || attributes.values().any(|values: &Vec<f32>| values.len() != count)
        {
            return Err("its attributes differ in their numbers of vertices".into());
        }
        let indices = triangles(primitive.mode(), &indices);
        Ok(TriangleMesh { positions, indices, uv, normals: VertexNormals::new(normals), attributes })
    }

    /// The vectors of an accessor, to which morph targets add in proportion to their weights.
    fn vectors<'file>(
        &self,
        base: &Accessor,
        targets: impl Iterator<Item = (Option<Accessor<'file>>, f32)>,
    ) -> Result<Vec<Vec3>, String> {
        let mut all = numbers(base, Dimensions::Vec3, &self.buffers)?;
        for (accessor, weight) in targets.filter_map(|(accessor, weight)| Some((accessor?, weight))) {
            let added = numbers(&accessor, Dimensions::Vec3, &self.buffers)?;
            if added.len() != all.len() {
                return Err("a morph target has another number of vertices".into());
            }
            all.iter_mut().zip(added).for_each(|(value, added)| *value += f64::from(weight) * added);
        }
        Ok(all.as_chunks().0.iter().map(|vector| DVec3::from_array(*vector).as_vec3()).collect())
    }

    /// The coordinates in the texture of the base colour, or else `TEXCOORD_0`; empty without coordinates.
    fn texture_coordinates(&self, primitive: &Primitive) -> Result<Vec<Vec2>, String> {
        let texture = primitive.material().pbr_metallic_roughness().base_color_texture();
        let transform = texture.as_ref().and_then(Info::texture_transform);
        let set = transform.as_ref().and_then(TextureTransform::tex_coord).or(texture.as_ref().map(Info::tex_coord));
        let Some(accessor) = primitive.get(&Semantic::TexCoords(set.unwrap_or(0))) else { return Ok(Vec::new()) };
        let (offset, rotation, scale) =
            transform.map_or(([0.0; 2], 0.0, [1.0; 2]), |found| (found.offset(), found.rotation(), found.scale()));
        // A rotation is counter-clockwise as seen in the image, unlike the matrix in the text of KHR_texture_transform
        // (github.com/KhronosGroup/glTF/issues/1563).
        let turn = Mat2::from_angle(-rotation);
        let to_image = |[u, v]: [f64; 2]| {
            let Vec2 { x, y } = turn * (Vec2::from(scale) * Vec2::new(narrow(u), narrow(v))) + Vec2::from(offset);
            // The origin of glTF is the upper left corner of the image, ours the lower left.
            Vec2::new(x, 1.0 - y)
        };
        let values = numbers(&accessor, Dimensions::Vec2, &self.buffers)?;
        Ok(values.as_chunks().0.iter().copied().map(to_image).collect())
    }

    /// The whole content of the file. Every index in it is in range, and everything that a part requires is present.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The bytes of an image of the document, in the image's own format.
    ///
    /// # Errors
    ///
    /// When the image's file cannot be read, its data URI is malformed, or it reaches beyond the end of its buffer.
    pub fn image(&self, image: &Image, files: &dyn FileSource) -> Result<Vec<u8>, FileError> {
        let what = format!("image {}", image.index());
        match image.source() {
            gltf::image::Source::Uri { uri, .. } => self.uri(uri, &what, files),
            gltf::image::Source::View { view, .. } => {
                let buffer = self.buffers.get(view.buffer().index());
                let end = view.offset().checked_add(view.length());
                let part = buffer.zip(end).and_then(|(buffer, end)| buffer.get(view.offset()..end));
                part.map(<[u8]>::to_vec)
                    .ok_or_else(|| self.wrong(format!("{what} reaches beyond the end of its buffer")))
            }
        }
    }

    /// An error about the content of the file.
    pub fn wrong(&self, reason: String) -> FileError {
        FileError::Content { path: self.path.clone(), reason }
    }
}

/// Greatest memory of the triangles of a primitive, in bytes: the numbers of its accessors in double precision and as
/// they are used.
fn bytes_of(primitive: &Primitive) -> f64 {
    let numbers = |accessor: Accessor| accessor.count() as f64 * accessor.dimensions().multiplicity() as f64;
    let indices = primitive.indices().map_or(0.0, numbers);
    let attributes: f64 = primitive.attributes().map(|(_, accessor)| numbers(accessor)).sum();
    16.0 * (indices + attributes)
}

/// The triangles of a list, strip or fan; none of points and lines.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::Triangles => indices.chunks_exact(3).map(|corner| [corner[0], corner[1], corner[2]]).collect(),
        Mode::TriangleStrip => strip(indices).collect(),
        Mode::TriangleFan => match indices {
            [centre, rim @ ..] => rim.windows(2).map(|pair| [*centre, pair[0], pair[1]]).collect(),
            [] => Vec::new(),
        },
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_base::files::FilesInMemory;

    /// Accessor 0 of [`read`]: the corners of a triangle, in m.
    const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// A mesh of the triangle.
    const MESHES: &str = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]"#;
    /// A node with the mesh.
    const NODES: &str = r#""nodes":[{"mesh":0}]"#;

    fn bytes(numbers: &[f32]) -> Vec<u8> {
        numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
    }

    /// Reads a file with further content. Accessors after the triangle are given by their bytes and keys, and accessor
    /// N has buffer view N, unless it has no bytes.
    fn read(content: &[&str], accessors: &[(Vec<u8>, &str)]) -> Result<GltfFile, String> {
        let corners = r#""componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]"#;
        let all = [&[(bytes(CORNERS.as_flattened()), corners)], accessors].concat();
        let (mut data, mut views, mut of_views) = (Vec::new(), Vec::new(), Vec::new());
        for (number, (bytes, keys)) in all.into_iter().enumerate() {
            views.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, data.len(), bytes.len().max(1)));
            let view = if bytes.is_empty() { String::new() } else { format!(r#""bufferView":{number},"#) };
            of_views.push(format!("{{{view}{keys}}}"));
            data.extend(bytes);
            data.resize(data.len().next_multiple_of(4), 0);
        }
        let text = format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],{},"bufferViews":[{}],"accessors":[{}],
            "buffers":[{{"byteLength":{},"uri":"gel%C3%A4nde%20%231.bin"}}]}}"#,
            content.join(","),
            views.join(","),
            of_views.join(","),
            data.len()
        );
        // The byte order mark is allowed in files, though not in glTF.
        let files = FilesInMemory::from([("a.gltf", format!("\u{feff}{text}").into_bytes()), ("gelände #1.bin", data)]);
        GltfFile::read(&files, "a.gltf").map_err(|error| error.to_string())
    }

    fn positions(content: &[&str], accessors: &[(Vec<u8>, &str)]) -> Vec<Vec3> {
        read(content, accessors).unwrap().mesh(None).unwrap().mesh.positions
    }

    fn assert_near(found: &[Vec3], expected: &[[f32; 3]]) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        let near = found.iter().zip(expected).all(|(one, other)| one.abs_diff_eq(Vec3::from_array(*other), 1e-6));
        assert!(near, "{found:?} for {expected:?}");
    }

    #[test]
    fn nodes_far_away_keep_their_places_and_further_scenes_have_a_note() {
        // Single precision has steps of 0.5 m at 5,190,200 m.
        let far = DVec3::new(5_190_200.312_5, 0.0, -455_123.640_625);
        let matrix = format!("[1,0,0,0, 0,1,0,0, 0,0,1,0, {},{},{},1]", far.x, far.y, far.z);
        for place in [format!(r#""translation":{:?}"#, far.to_array()), format!(r#""matrix":{matrix}"#)] {
            let nodes = format!(r#""nodes":[{{"mesh":0,{place}}}]"#);
            let file = read(&[&nodes, MESHES], &[]).unwrap();
            assert_eq!(file.nodes(DAffine3::IDENTITY).unwrap()[0].to_root.translation, far);
            let ReadMesh { mesh, origin, notes } = file.mesh(None).unwrap();
            assert_eq!(origin + mesh.positions[1].as_dvec3(), far + DVec3::X);
            assert!(notes.is_empty(), "{notes:?}");
        }
        let file = GltfFile::read(&FilesInMemory::from([("a.gltf", TWO_SCENES)]), "a.gltf").unwrap();
        assert_eq!(file.notes(false), ["only one of its scenes is read: \"winter\""]);
    }

    const TWO_SCENES: &str = r#"{"asset": {"version": "2.0"}, "scene": 1, "nodes": [{}, {}],
        "scenes": [{"nodes": [0]}, {"nodes": [1], "name": "winter"}]}"#;

    /// Nodes share a mesh of a million vertices, 48 MB, unless each has weights of its own.
    #[test]
    fn memory_counts_the_mesh_of_each_node_with_own_weights() {
        let large = r#""componentType":5126,"count":1000000,"type":"VEC3","min":[0,0,0],"max":[0,0,0]"#;
        let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":1}}]}]"#;
        let places = |own: &str| {
            let node = format!(r#",{{"mesh":0{own}}}"#).repeat(100);
            let children: Vec<usize> = (1..=100).collect();
            let nodes = format!(r#""nodes":[{{"children":{children:?}}}{node}]"#);
            let file = read(&[&nodes, mesh], &[(vec![0; 36], large)]).unwrap();
            file.nodes(DAffine3::IDENTITY).map(|nodes| nodes.len()).map_err(|error| error.to_string())
        };
        assert_eq!(places(""), Ok(101));
        assert!(places(r#","weights":[0.5]"#).unwrap_err().contains("its meshes take"));
    }

    #[test]
    fn a_mesh_is_placed_at_each_of_its_instances() {
        // The second instance is turned by 90° about z and twice as large. The node moves both by (0, 0, 5).
        let nodes = r#""nodes":[{"mesh":0,"translation":[0,0,5],"extensions":{"EXT_mesh_gpu_instancing":
            {"attributes":{"TRANSLATION":1,"ROTATION":2,"SCALE":3}}}}],
            "extensionsRequired":["EXT_mesh_gpu_instancing"]"#;
        let vectors = r#""componentType":5126,"count":2,"type":"VEC3""#;
        let half = 0.5f32.sqrt();
        let instances = [
            (bytes(&[0.0, 0.0, 0.0, 10.0, 0.0, 0.0]), vectors),
            (bytes(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]), r#""componentType":5126,"count":2,"type":"VEC4""#),
            (bytes(&[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]), vectors),
        ];
        let expected = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]];
        let turned = [[10.0, 0.0, 5.0], [10.0, 2.0, 5.0], [8.0, 0.0, 5.0]];
        assert_near(&positions(&[nodes, MESHES], &instances), &[expected, turned].concat());
        let file = read(&[nodes, MESHES], &instances).unwrap();
        assert_eq!(file.nodes(DAffine3::IDENTITY).unwrap()[0].instances.len(), 2);
        assert!(file.notes(true).is_empty());
        for (right, wrong, expected) in [
            (r#""SCALE":3"#, r#""SCALE":0"#, "node 0: the attributes of its instances are missing, or differ"),
            (r#""SCALE":3"#, r#""SCALE":9"#, "node 0: SCALE of its instances is accessor 9, which is missing"),
        ] {
            let file = read(&[&nodes.replace(right, wrong), MESHES], &instances).unwrap();
            let message = file.nodes(DAffine3::IDENTITY).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn morph_targets_have_the_weights_of_the_node_or_else_of_the_mesh() {
        let mesh = r#""meshes":[{"weights":[0.5,1],"primitives":[{"attributes":{"POSITION":0},
            "targets":[{"POSITION":1},{"POSITION":2}]}]}]"#;
        let vectors = r#""componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,4]"#;
        let targets = [
            (bytes(&[0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), vectors),
            (bytes(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), vectors),
        ];
        let expected = [[0.0, 0.0, 2.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_near(&positions(&[NODES, mesh], &targets), &expected);
        let of_node = r#""nodes":[{"mesh":0,"weights":[0.25,0]}]"#;
        let expected = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_near(&positions(&[of_node, mesh], &targets), &expected);
        assert_near(&positions(&[NODES, &mesh.replace(r#""weights":[0.5,1],"#, "")], &targets), &CORNERS);
        let short = [targets[0].clone(), (bytes(&[1.0; 6]), &*vectors.replace(r#""count":3"#, r#""count":2"#))];
        let message = read(&[NODES, mesh], &short).unwrap().mesh(None).unwrap_err().to_string();
        assert!(message.contains("mesh 0: a morph target has another number of vertices"), "{message}");
    }

    #[test]
    fn sparse_accessors_replace_elements_of_their_base_or_of_zeros() {
        let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":1}}]}]"#;
        let sparse = r#""componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0],"sparse":{"count":2,
            "indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":3}}"#;
        let unused = r#""componentType":5121,"count":2,"type":"SCALAR""#;
        let all = |base: &[f32], index: u8| {
            let values = bytes(&[7.0, 7.0, 7.0, 8.0, 8.0, 8.0]);
            [(bytes(base), sparse), (vec![0, index], unused), (values, unused)]
        };
        let [zero, one, seven, eight] = [[0.0; 3], [1.0; 3], [7.0; 3], [8.0; 3]];
        assert_near(&positions(&[NODES, mesh], &all(&[1.0; 9], 2)), &[seven, one, eight]);
        assert_near(&positions(&[NODES, mesh], &all(&[], 2)), &[seven, zero, eight]);
        let message = read(&[NODES, mesh], &all(&[1.0; 9], 3)).unwrap().mesh(None).unwrap_err().to_string();
        assert!(message.contains("accessor 1 replaces element 3, but has fewer"), "{message}");
    }

    #[test]
    fn quantised_positions_are_integers_or_fractions() {
        let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":1}}]}],
            "extensionsRequired":["KHR_mesh_quantization"]"#;
        let keys = |normalized| {
            format!(
                r#""componentType":5122,"normalized":{normalized},"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]"#
            )
        };
        let numbers: Vec<u8> = [0i16, 0, 0, 32767, 0, 0, 0, -32767, 0].iter().flat_map(|n| n.to_le_bytes()).collect();
        let of = |normalized| positions(&[NODES, mesh], &[(numbers.clone(), &keys(normalized))]);
        assert_near(&of(true), &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
        assert_near(&of(false), &[[0.0; 3], [32767.0, 0.0, 0.0], [0.0, -32767.0, 0.0]]);
    }

    #[test]
    fn texture_coordinates_are_those_of_the_base_colour_texture() {
        let mesh = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":2},
            "material":0}]}],
            "textures":[{"source":0}],"images":[{"uri":"a.png"}]"#;
        let texture = |keys: &str| {
            format!(r#""materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0{keys}}}}}}}]"#)
        };
        let pairs = r#""componentType":5126,"count":3,"type":"VEC2""#;
        let sets = [(bytes(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]), pairs), (bytes(&[0.5; 6]), pairs)];
        let of = |keys: &str| read(&[NODES, mesh, &texture(keys)], &sets).unwrap().mesh(None).unwrap().mesh;
        let transform = |keys: &str| of(&format!(r#","extensions":{{"KHR_texture_transform":{{{keys}}}}}"#)).uv;
        // The first number counts to the right, and the second upwards from the lower edge.
        let near = |found: Vec<Vec2>, expected: [[f32; 2]; 3]| {
            let near = found.iter().zip(expected).all(|(one, other)| one.abs_diff_eq(Vec2::from(other), 1e-6));
            assert!(near && found.len() == 3, "{found:?} for {expected:?}");
        };
        near(of("").uv, [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
        near(of(r#","texCoord":1"#).uv, [[0.5; 2]; 3]);
        assert_eq!(of("").attributes[SECOND_UV[0]], [0.5; 3], "the lightmap has the second set in any case");
        near(transform(r#""texCoord":1,"scale":[4,2]"#), [[2.0, 0.0]; 3]);
        near(transform(r#""offset":[0.25,0.5],"scale":[4,2]"#), [[0.25, 0.5], [4.25, 0.5], [0.25, -1.5]]);
        // A quarter turn counter-clockwise in the image: right becomes up, and down becomes right.
        near(transform(r#""rotation":1.5707963267948966"#), [[0.0, 1.0], [0.0, 2.0], [1.0, 1.0]]);
        // The scale comes before the rotation.
        near(transform(r#""rotation":1.5707963267948966,"scale":[3,1]"#), [[0.0, 1.0], [0.0, 4.0], [1.0, 1.0]]);
    }

    #[test]
    fn extensions_that_are_required_are_refused_with_a_way_out_and_others_are_named() {
        for (name, way_out) in [
            ("KHR_draco_mesh_compression", "export it from Blender with Data > Compression switched off"),
            ("EXT_meshopt_compression", "run `gltfpack` without `-c`, `-cc` and `-cz`"),
            ("KHR_texture_basisu", "run `gltfpack` without `-tc`"),
            ("ACME_roof", "export it without this extension"),
        ] {
            let required = format!(r#""extensionsUsed":["{name}"],"extensionsRequired":["{name}"]"#);
            let message = read(&[NODES, MESHES, &required], &[]).unwrap_err();
            assert!(
                message.contains(&format!("it requires the extension {name}, which is not read: {way_out}")),
                "{message}"
            );
            let used = format!(r#""extensionsUsed":["{name}","KHR_lights_punctual"]"#);
            let file = read(&[NODES, MESHES, &used], &[]).unwrap();
            assert_eq!(file.notes(true), [format!("extensions that are not read: {name}")]);
        }
    }

    #[test]
    fn notes_name_what_changes_shapes_and_is_not_read() {
        let nodes = r#""nodes":[{"mesh":0,"skin":0}],"skins":[{"joints":[0]}]"#;
        let meshes =
            r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"mode":1}]}]"#;
        let file = read(&[nodes, meshes], &[]).unwrap();
        let notes = file.notes(true).join("\n");
        assert!(notes.contains("skins are not read") && notes.contains("left out: 1 primitives"), "{notes}");
        assert_eq!(file.mesh(None).unwrap().mesh.indices.len(), 1);
    }
}
