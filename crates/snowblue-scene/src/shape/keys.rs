//! The common interface of the keys of all kinds of shapes in a scene file, and the context in which a shape is
//! built.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use snowblue_base::{KeyError, KeyPath};
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::shape::Shape;
use snowblue_geometry::triangle_mesh::TriangleMesh;

use super::imprint::ImprintDescription;
use super::placing::{Placing, placement};
use crate::error::SceneError;
use crate::sources::Sources;
use crate::undisturbed::UndisturbedSurface;

/// The keys of one kind of shape.
pub(crate) trait ShapeKeys {
    /// Builds the shape in its place.
    fn build(&self, object: &mut ObjectContext) -> Result<BuiltShape, SceneError>;

    /// Whether prints can be pressed into the surface of the shape.
    fn takes_imprints(&self) -> bool {
        false
    }
}

/// The context in which a shape is built.
pub(crate) struct ObjectContext<'scene> {
    pub(crate) path: &'scene KeyPath,
    pub(crate) placing: Placing,
    pub(crate) is_snow: bool,
    pub(crate) imprints: &'scene [ImprintDescription],
    pub(crate) sources: &'scene Sources<'scene>,
    /// Whether snow must be closed.
    pub(super) must_be_closed: bool,
    pub(super) meshes: &'scene mut MeshCache,
    /// Sentences that say what was changed.
    pub(super) notes: &'scene mut Vec<String>,
}

/// A shape in its place.
pub(crate) struct BuiltShape {
    /// The parts of the shape.
    pub(crate) parts: Vec<Shape>,
    /// The body that the parts form, unless the object has a body.
    pub(crate) body: Option<String>,
    /// The surface of the shape before prints were pressed into it.
    pub(crate) undisturbed: Option<UndisturbedSurface>,
}

impl From<Shape> for BuiltShape {
    fn from(shape: Shape) -> Self {
        Self { parts: vec![shape], body: None, undisturbed: None }
    }
}

/// A mesh from a file, centred at the origin.
pub(crate) struct FileMesh {
    pub(crate) mesh: Arc<MeshBvh>,
    /// The map from the centred mesh to its original place.
    pub(crate) to_original: DAffine3,
    /// Whether the mesh is known to be closed.
    pub(crate) is_closed: bool,
}

impl FileMesh {
    /// A mesh whose coordinates begin at `origin`, with smooth vertex normals or with flat faces.
    pub(crate) fn new(mesh: TriangleMesh, origin: DVec3, is_smooth: bool) -> Self {
        let centred = mesh.centred();
        let mesh = if is_smooth { centred.mesh.smooth() } else { centred.mesh.flat() };
        let to_original = DAffine3::from_translation(origin) * centred.to_original;
        Self { mesh: Arc::new(MeshBvh::new(mesh)), to_original, is_closed: false }
    }
}

/// Meshes by file, by part, by whether they are smooth, and by whether they are snow.
#[derive(Default)]
pub(super) struct MeshCache(pub(super) BTreeMap<(String, Option<String>, bool, bool), FileMesh>);

impl ObjectContext<'_> {
    /// A solid with the transform of the object.
    pub(super) fn place(&self, triangles: TriangleMesh) -> Result<Shape, KeyError> {
        self.place_from(DVec3::ZERO, triangles)
    }

    /// A solid with the transform of the object, whose coordinates begin at `origin` in the coordinates of the object.
    pub(super) fn place_from(&self, origin: DVec3, triangles: TriangleMesh) -> Result<Shape, KeyError> {
        let FileMesh { mesh, to_original, .. } = FileMesh::new(triangles, origin, true);
        let wrong = |reason: String| self.path.error(format!("is misplaced: {reason}"));
        let placement = placement(&(self.placing.to_scene() * to_original)).map_err(wrong)?;
        Ok(Shape::Mesh(Instance::new(mesh, placement)))
    }
}

/// Refuses the shapes of the feature `shapes` in a build without it. The compiler then drops the code that follows.
#[inline]
pub(crate) fn check_shapes(path: &KeyPath) -> Result<(), KeyError> {
    if cfg!(feature = "shapes") {
        return Ok(());
    }
    Err(path.key("shape").error("is one that this build does not make"))
}
