//! Objects: shapes of a material in their places.
//!
//! **A new shape** needs a file here and a line in the list below. The file declares the keys of the shape in a scene
//! file with their ranges, and builds the shape from these keys (`ShapeKeys`).

mod carved;
mod closed;
mod cuboid;
mod drift;
mod grid;
mod height_field;
mod igloo;
mod imprint;
mod joints;
mod keys;
mod mesh;
mod notes;
mod placing;
mod plane;
mod relief;
mod snowpack;
mod solid;
mod sphere;

use std::collections::BTreeMap;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyError, KeyPath, Numbers, ParseError};

use crate::error::SceneError;
use crate::integrator::IntegratorKind;
use crate::material::NamedMaterial;
use crate::objects::Object;
use crate::sources::Sources;
use crate::values::{Coordinate, Scale, things};
pub(crate) use keys::FileMesh;
use keys::{BuiltShape, MeshCache, ObjectContext, ShapeKeys};
use placing::Placing;

pub use carved::CarvedDescription;
pub(crate) use closed::{check_closed, solid};
pub use cuboid::BoxDescription;
pub use drift::{DriftDescription, MoundDescription};
pub use grid::CropDescription;
pub use height_field::HeightFieldDescription;
pub use igloo::IglooDescription;
pub use imprint::{FootDescription, FootprintDescription, HoleDescription, ImprintDescription};
pub use mesh::MeshDescription;
pub(crate) use notes::{body_of_two, notes_on_bodies};
pub use placing::ObjectSettings;
pub(crate) use placing::{check_reach, placement};
pub use plane::PlaneDescription;
pub(crate) use relief::with_relief;
pub use snowpack::{DepthDescription, SnowpackDescription};
pub use solid::{
    CapsuleDescription, CylinderDescription, HalfSpaceDescription, SolidBoxDescription, SolidDescription,
    SolidEllipsoidDescription,
};
pub use sphere::SphereDescription;

things! {
    /// A shape with a name of its own.
    NamedShape by "shape": dyn ShapeKeys {
        /// A box about the origin.
        "box" => Box(BoxDescription),
        /// A sphere about the origin.
        "sphere" => Sphere(SphereDescription),
        /// The endless plane z = 0.
        "plane" => Plane(PlaneDescription),
        /// A solid under a surface of heights.
        "heights" => Heights(HeightFieldDescription, read),
        /// Ground under snow, with mounds.
        "drift" => Drift(DriftDescription),
        /// Snow on a surface of heights or on a mesh.
        "snowpack" => Snowpack(SnowpackDescription, read),
        /// An igloo, one object for each block.
        "igloo" => Igloo(IglooDescription),
        /// The union of solids without the union of others.
        "carved" => Carved(CarvedDescription, read),
    }
}

/// A shape.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[expect(clippy::large_enum_variant, reason = "there is one for each object")]
pub enum ShapeDescription {
    /// A shape that `shape` names.
    Named(NamedShape),
    /// A mesh from a file.
    Mesh(MeshDescription),
}

/// A shape with a transform and a material.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ObjectDescription {
    /// Its shape.
    #[serde(flatten)]
    pub shape: ShapeDescription,
    /// What it is made of and where it is.
    #[serde(flatten)]
    pub common: ObjectSettings,
    /// What is pressed into its surface: into heights, drifts and snow on heights.
    #[serde(rename = "imprint", skip_serializing_if = "Vec::is_empty")]
    #[schemars(default)]
    pub imprints: Vec<ImprintDescription>,
}

impl ShapeDescription {
    fn keys(&self) -> &dyn ShapeKeys {
        match self {
            Self::Named(named) => named.keys(),
            Self::Mesh(mesh) => mesh,
        }
    }

    fn is_plane(&self) -> bool {
        matches!(self, Self::Named(NamedShape::Plane(_)))
    }

    /// The name of the object in reports.
    fn name(&self) -> String {
        match self {
            Self::Named(named) => named.word().to_owned(),
            Self::Mesh(mesh) => mesh.name(),
        }
    }
}

impl ObjectDescription {
    /// A shape of a material at the origin, without rotation.
    pub fn new(shape: impl Into<ShapeDescription>, material: impl Into<String>) -> Self {
        let common = ObjectSettings {
            material: material.into(),
            name: None,
            body: None,
            position: Numbers::default(),
            rotation_deg: Numbers::default(),
            scale: Scale::default(),
        };
        Self { shape: shape.into(), common, imprints: Vec::new() }
    }

    /// The object at another position.
    #[must_use]
    pub fn at(mut self, position: Numbers<Coordinate, 3>) -> Self {
        self.common.position = position;
        self
    }

    /// Reads an object.
    pub(crate) fn read(mut table: Table) -> Result<Self, ParseError> {
        let common = table.split(&ObjectSettings::KEYS).read()?;
        let imprints: Result<_, _> = table.take_tables("imprint")?.into_iter().map(ImprintDescription::read).collect();
        let shape = match (table.has("shape"), table.has("mesh")) {
            (true, false) => NamedShape::read(table)?.into(),
            (false, true) => ShapeDescription::Mesh(table.read()?),
            _ => return Err(table.error("must have either `shape` or `mesh`")),
        };
        Ok(Self { shape, common, imprints: imprints? })
    }

    /// Whether the object is a plane.
    pub(crate) fn is_plane(&self) -> bool {
        self.shape.is_plane()
    }
}

impl From<NamedShape> for ShapeDescription {
    fn from(named: NamedShape) -> Self {
        Self::Named(named)
    }
}

impl From<MeshDescription> for ShapeDescription {
    fn from(mesh: MeshDescription) -> Self {
        Self::Mesh(mesh)
    }
}

/// Builds objects; each mesh file is read once.
pub(crate) struct ObjectBuilder<'scene> {
    sources: &'scene Sources<'scene>,
    materials: &'scene [NamedMaterial],
    /// For each snow material with planes, by its index, the index of the material of these planes.
    grounds: BTreeMap<usize, usize>,
    meshes: MeshCache,
    has_light_field: bool,
    /// Sentences that say what was changed.
    pub(crate) notes: Vec<String>,
}

impl<'scene> ObjectBuilder<'scene> {
    /// A builder that has read no mesh yet.
    pub(crate) fn new(
        sources: &'scene Sources<'scene>,
        materials: &'scene [NamedMaterial],
        grounds: BTreeMap<usize, usize>,
        integrator: IntegratorKind,
    ) -> Self {
        let has_light_field = integrator.has_light_field();
        Self { sources, materials, grounds, meshes: MeshCache::default(), has_light_field, notes: Vec::new() }
    }

    /// Builds an object. An igloo becomes one object for each block.
    pub(crate) fn build(&mut self, path: &KeyPath, object: &ObjectDescription) -> Result<Vec<Object>, SceneError> {
        let ObjectDescription { shape, common, imprints } = object;
        let mut index = self.material(path, &common.material)?;
        if let Some(ground) = self.grounds.get(&index).filter(|_| shape.is_plane()) {
            index = *ground;
        }
        let NamedMaterial { name: material_name, material } = &self.materials[index];
        let is_snow = material.is_snow();
        if common.body.is_some() && !is_snow {
            let reason = if shape.is_plane() {
                "joins snow, but a plane has no inside".to_owned()
            } else {
                format!("joins snow, but the material \"{material_name}\" is diffuse")
            };
            return Err(path.key("body").error(reason).into());
        }
        if !imprints.is_empty() && !shape.keys().takes_imprints() {
            let reason = "needs a surface of heights: heights, drift, or snowpack on heights";
            return Err(path.key("imprint").error(reason).into());
        }
        let BuiltShape { parts, body, undisturbed } = shape.keys().build(&mut ObjectContext {
            path,
            placing: Placing::of(common),
            is_snow,
            imprints,
            sources: self.sources,
            must_be_closed: is_snow && self.has_light_field,
            meshes: &mut self.meshes,
            notes: &mut self.notes,
        })?;
        for part in &parts {
            check_reach(part).map_err(|reason| path.error(reason))?;
            material.check(part).map_err(|reason| {
                path.key("material").error(format!("is \"{material_name}\", which does not fit: {reason}"))
            })?;
        }
        let name = common.name.clone().unwrap_or_else(|| shape.name());
        let undisturbed = undisturbed.map(Arc::new);
        let body = common.body.clone().or(body);
        let object = |shape| Object {
            name: name.clone(),
            shape,
            material: index,
            body: body.clone(),
            undisturbed: undisturbed.clone(),
        };
        Ok(parts.into_iter().map(object).collect())
    }

    /// Index of a material by its name.
    fn material(&self, path: &KeyPath, name: &str) -> Result<usize, KeyError> {
        self.materials.iter().position(|other| other.name == name).ok_or_else(|| {
            let named = &self.materials[..self.materials.len() - self.grounds.len()];
            let names: Vec<_> = named.iter().map(|material| material.name.as_str()).collect();
            path.key("material").error(format!("is \"{name}\", but must be one of {}", names.join(", ")))
        })
    }
}
