//! glTF 2.0 and GLB files (Khronos Group 2021, "glTF 2.0 specification", ISO/IEC 12113:2022): nodes with their
//! transforms, and meshes. All other content of a file, such as materials, cameras and lights, is in its
//! [document](GltfFile::document).
//!
//! Reads triangles with `POSITION`, `NORMAL`, `TEXCOORD_0`, `TEXCOORD_1` (attributes `lightmap_u`, `lightmap_v`),
//! `COLOR_0` (`red`, `green`, `blue`) and application-specific scalar attributes, whose names begin with an underscore.
//! Ignores points and lines, skins and morph targets.

mod checked;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DAffine3, DMat3, DMat4, DVec3, Vec2, Vec3};
use gltf::accessor::Dimensions;
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Image, Node, Primitive, Semantic};

use crate::triangle_mesh::{SECOND_UV, TriangleMesh};
use crate::vertex_normals::VertexNormals;
use snowblue_base::narrow;

use checked::{numbers, valid};
use snowblue_base::files::{FileError, FileSource, FilesIn, NamedFile, check_memory, check_total, name_beside};

/// Maps the axes of glTF (y up, z towards the viewer) to the axes of a scene (z up, y away from the viewer).
pub const Y_UP_TO_Z_UP: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);

/// A glTF file with its buffers.
#[derive(Debug)]
pub struct GltfFile {
    name: String,
    path: PathBuf,
    gltf: Gltf,
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

    /// Index of its mesh in the file, if it has a mesh.
    pub fn mesh(&self) -> Option<usize> {
        self.node.mesh().map(|mesh| mesh.index())
    }
}

impl GltfFile {
    /// Reads a `.gltf` or `.glb` file and its buffers.
    ///
    /// # Errors
    ///
    /// When a file cannot be read, or is truncated or malformed.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        Self::read(&FilesIn::beside(path), &path.file_name().unwrap_or_default().to_string_lossy())
    }

    /// Reads a file and its buffers from a source of files. Buffer names are relative to the file's own name.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open).
    pub fn read(files: &dyn FileSource, name: &str) -> Result<Self, FileError> {
        let NamedFile { path, bytes } = NamedFile::read(files, name)?;
        let wrong = |reason: String| FileError::Content { path: path.clone(), reason };
        let mut gltf = valid(&bytes).map_err(|reason| wrong(format!("not a readable glTF file: {reason}")))?;
        let mut blob = gltf.blob.take();
        let neighbours = Neighbours { files, name, path: &path };
        let mut buffers: Vec<Vec<u8>> = Vec::new();
        let mut size = bytes.len();
        for buffer in gltf.buffers() {
            let content = neighbours.buffer(&buffer, &mut blob)?;
            size = size.saturating_add(content.len());
            check_total("its buffers", size as f64).map_err(wrong)?;
            buffers.push(content);
        }
        Ok(Self { name: name.to_owned(), path, gltf, buffers, size })
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
        let scene = self.gltf.default_scene().or_else(|| self.gltf.scenes().next());
        let scene = scene.ok_or_else(|| self.wrong("the file has no scene".into()))?;
        let mut nodes = Vec::new();
        let mut pending: Vec<_> = scene.nodes().map(|node| (node, root, name.is_none())).collect();
        pending.reverse();
        let mut visited = vec![false; self.gltf.nodes().len()];
        while let Some((node, parent, named)) = pending.pop() {
            let index = node.index();
            if std::mem::replace(&mut visited[index], true) {
                return Err(self.wrong(format!("node {index} has two parents")));
            }
            let local = DMat4::from_cols_array_2d(&node.transform().matrix().map(|column| column.map(f64::from)));
            let to_root = parent * DAffine3::from_mat4(local);
            let mesh_named = node.mesh().is_some_and(|mesh| name.is_some() && mesh.name() == name);
            let named = named || mesh_named || (name.is_some() && node.name() == name);
            let children: Vec<_> = node.children().collect();
            pending.extend(children.into_iter().rev().map(|child| (child, to_root, named)));
            nodes.push(PlacedNode { node, to_root, named });
        }
        // Nodes share a mesh.
        let meshes: BTreeSet<usize> = nodes.iter().filter_map(PlacedNode::mesh).collect();
        self.check_mesh_memory("its meshes", meshes.into_iter())?;
        Ok(nodes)
    }

    /// Refuses meshes, given by their indices, that take too much memory together.
    fn check_mesh_memory(&self, what: &str, meshes: impl Iterator<Item = usize>) -> Result<(), FileError> {
        let bytes: Vec<f64> =
            self.gltf.meshes().map(|mesh| mesh.primitives().map(|primitive| bytes_of(&primitive)).sum()).collect();
        let asked = meshes.map(|mesh| bytes[mesh]).sum();
        check_memory(what, asked, self.size).map_err(|reason| self.wrong(reason))
    }

    /// All triangles of the file in its own axes, or only the triangles of the nodes or meshes named `part` and their
    /// descendants.
    ///
    /// # Errors
    ///
    /// When a mesh is malformed, or no node or mesh has that name.
    pub fn mesh(&self, part: Option<&str>) -> Result<TriangleMesh, FileError> {
        let mut whole = TriangleMesh::default();
        let mut found = false;
        let mut nodes = self.nodes_named(DAffine3::IDENTITY, part)?;
        nodes.retain(|node| node.named);
        self.check_mesh_memory("the meshes of its nodes", nodes.iter().filter_map(PlacedNode::mesh))?;
        for node in &nodes {
            found = true;
            for surface in node.mesh().map_or_else(|| Ok(Vec::new()), |mesh| self.surfaces(mesh))? {
                whole.append(&surface.mesh, &node.to_root).map_err(|reason| self.wrong(reason))?;
            }
        }
        match part {
            Some(part) if !found => Err(self.wrong(format!("its scene has no node or mesh named \"{part}\""))),
            _ => Ok(whole),
        }
    }

    /// The triangles of a mesh in object space, grouped by material.
    ///
    /// # Errors
    ///
    /// When the mesh data are malformed or missing.
    pub fn surfaces(&self, mesh: usize) -> Result<Vec<GltfSurface>, FileError> {
        let mut surfaces: Vec<GltfSurface> = Vec::new();
        for primitive in self.gltf.meshes().nth(mesh).into_iter().flat_map(|mesh| mesh.primitives()) {
            let triangles =
                self.primitive(&primitive).map_err(|reason| self.wrong(format!("mesh {mesh}: {reason}")))?;
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

    fn primitive(&self, primitive: &Primitive) -> Result<TriangleMesh, String> {
        let read = |accessor, dimensions| numbers(&accessor, dimensions, &self.buffers);
        let positions = primitive.get(&Semantic::Positions).ok_or("there are no positions")?;
        let vectors = |numbers: Vec<f64>| -> Vec<Vec3> {
            numbers.chunks_exact(3).map(|p| Vec3::new(narrow(p[0]), narrow(p[1]), narrow(p[2]))).collect()
        };
        let positions = vectors(read(positions, Dimensions::Vec3)?);
        if let Some(value) = positions.iter().flat_map(|position| position.to_array()).find(|value| !value.is_finite())
        {
            return Err(format!("a coordinate is {value}, but must be finite"));
        }
        let indices: Vec<u32> = match primitive.indices() {
            Some(accessor) => read(accessor, Dimensions::Scalar)?.into_iter().map(whole).collect(),
            None => (0..u32::try_from(positions.len()).map_err(|_| "there are too many vertices")?).collect(),
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= positions.len()) {
            return Err(format!(
                "a triangle refers to vertex {index}, but there are {} (0 is the first)",
                positions.len()
            ));
        }
        let uv = match primitive.get(&Semantic::TexCoords(0)) {
            Some(accessor) => {
                let values = read(accessor, Dimensions::Vec2)?;
                // The origin of glTF is the upper left corner of the image, ours the lower left.
                values.chunks_exact(2).map(|uv| Vec2::new(narrow(uv[0]), narrow(1.0 - uv[1]))).collect()
            }
            None => Vec::new(),
        };
        let normals = match primitive.get(&Semantic::Normals) {
            Some(accessor) => vectors(read(accessor, Dimensions::Vec3)?),
            None => Vec::new(),
        };
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
            let values = read(accessor, kind)?;
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

    /// The whole content of the file. Every index in it is in range, and everything that a part requires is present.
    pub fn document(&self) -> &Document {
        &self.gltf.document
    }

    /// The bytes of an image of the document, in the image's own format.
    ///
    /// # Errors
    ///
    /// When the image's file cannot be read, its data URI is malformed, or it reaches beyond the end of its buffer.
    pub fn image(&self, image: &Image, files: &dyn FileSource) -> Result<Vec<u8>, FileError> {
        let what = format!("image {}", image.index());
        match image.source() {
            gltf::image::Source::Uri { uri, .. } => {
                Neighbours { files, name: &self.name, path: &self.path }.uri(uri, &what)
            }
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
    let numbers = |accessor: gltf::Accessor| accessor.count() as f64 * accessor.dimensions().multiplicity() as f64;
    let indices = primitive.indices().map_or(0.0, numbers);
    let attributes: f64 = primitive.attributes().map(|(_, accessor)| numbers(accessor)).sum();
    16.0 * (indices + attributes)
}

/// The triangles of a list, strip or fan; none of points and lines.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::Triangles => indices.chunks_exact(3).map(|corner| [corner[0], corner[1], corner[2]]).collect(),
        Mode::TriangleStrip => {
            let turned = |(number, corner): (usize, &[u32])| {
                let (second, third) = if number % 2 == 0 { (1, 2) } else { (2, 1) };
                [corner[0], corner[second], corner[third]]
            };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => match indices {
            [centre, rim @ ..] => rim.windows(2).map(|pair| [*centre, pair[0], pair[1]]).collect(),
            [] => Vec::new(),
        },
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "accessors hold unsigned integers of at most 32 bits"
)]
fn whole(index: f64) -> u32 {
    index as u32
}

/// The files that a glTF names.
struct Neighbours<'file> {
    files: &'file dyn FileSource,
    /// The glTF's own name, and its name in error messages.
    name: &'file str,
    path: &'file Path,
}

impl Neighbours<'_> {
    /// The content of a buffer. The content of the binary chunk is taken from `blob`, since only one buffer may have
    /// it.
    fn buffer(&self, buffer: &gltf::Buffer, blob: &mut Option<Vec<u8>>) -> Result<Vec<u8>, FileError> {
        let wrong = |reason: String| FileError::Content { path: self.path.into(), reason };
        let number = buffer.index();
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => {
                blob.take().ok_or_else(|| wrong(format!("buffer {number} is missing from the file")))?
            }
            gltf::buffer::Source::Uri(uri) => self.uri(uri, &format!("buffer {number}"))?,
        };
        if bytes.len() < buffer.length() {
            let (found, wanted) = (bytes.len(), buffer.length());
            let reason = format!("buffer {number} has {found} bytes, but must have {wanted}: the file is truncated");
            return Err(wrong(reason));
        }
        Ok(bytes)
    }

    /// The bytes of a data URI, or of the file that the URI names.
    fn uri(&self, uri: &str, what: &str) -> Result<Vec<u8>, FileError> {
        let wrong = |reason: String| FileError::Content { path: self.path.into(), reason: format!("{what} {reason}") };
        let Some(data) = uri.strip_prefix("data:") else {
            let name = name_beside(self.name, &uri.replace("%20", " "));
            return NamedFile::read(self.files, &name).map(|file| file.bytes);
        };
        let text = data.split_once(";base64,").map(|(_, text)| text);
        let text = text.ok_or_else(|| wrong("must be encoded as base64".into()))?;
        STANDARD.decode(text).map_err(|error| wrong(format!("is not base64: {error}")))
    }
}
