//! Meshes from files.

use std::collections::btree_map::Entry;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::KeyPath;
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_files::{ReadMesh, read_mesh_from};
use snowblue_geometry::shape::Shape;

use super::closed::{check_closed, solid};
use super::keys::{BuiltShape, FileMesh, ObjectContext, ShapeKeys};
use super::placing::{placement, upright};
use crate::error::SceneError;
use crate::values::UpAxis;

/// A mesh from a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshDescription {
    /// A PLY, OBJ, STL, glTF or GLB file.
    pub mesh: String,
    /// An object, group or material of an OBJ file, or a node or mesh of a glTF; the whole file if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The axis that points upwards in the file; y in glTF and z in other formats if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// Whether it is shaded by interpolated vertex normals: those of the file, or else the means of its faces. If not,
    /// or at edges of more than 40°, faces are flat.
    #[serde(default = "smooth", skip_serializing_if = "Clone::clone")]
    pub smooth: bool,
}

fn smooth() -> bool {
    true
}

impl MeshDescription {
    /// The mesh of a whole file.
    pub fn new(file: impl Into<String>) -> Self {
        Self { mesh: file.into(), part: None, up: None, smooth: smooth() }
    }

    /// The name of the object in reports.
    pub(super) fn name(&self) -> String {
        match &self.part {
            Some(part) => format!("{} {part}", self.mesh),
            None => self.mesh.clone(),
        }
    }

    /// The mesh, read once for all objects.
    fn read<'cache>(
        &self,
        path: &KeyPath,
        object: &'cache mut ObjectContext,
    ) -> Result<&'cache mut FileMesh, SceneError> {
        let Self { mesh: file, part, smooth, .. } = self;
        Ok(match object.meshes.0.entry((file.clone(), part.clone(), *smooth, object.is_snow)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(fresh) => {
                let read = read_mesh_from(object.sources.files, file, part.as_deref());
                let ReadMesh { mesh: mut read, origin, mut notes } =
                    read.map_err(|error| object.sources.named(path, file, error))?;
                if object.is_snow {
                    notes.extend(solid(&mut read).map_err(|reason| path.error(format!("is \"{file}\": {reason}")))?);
                }
                object.notes.extend(notes.into_iter().map(|note| format!("{path} is \"{file}\": {note}")));
                fresh.insert(FileMesh::new(read, origin, *smooth))
            }
        })
    }
}

impl ShapeKeys for MeshDescription {
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError> {
        let (path, file) = (object.path.key("mesh"), &self.mesh);
        let wrong = |reason: String| path.error(format!("is \"{file}\": {reason}"));
        let (to_scene, must_be_closed) = (object.placing.to_scene() * upright(file, self.up), object.must_be_closed);
        let found = self.read(&path, object)?;
        if must_be_closed && !found.is_closed {
            check_closed(found.mesh.triangles()).map_err(wrong)?;
            found.is_closed = true;
        }
        let placement = placement(&(to_scene * found.to_original)).map_err(wrong)?;
        let instance = Instance::new(Arc::clone(&found.mesh), placement);
        Ok(Shape::Mesh(instance).into())
    }
}
