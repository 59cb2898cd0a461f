//! Carved snow: its solids and its mesh.

use glam::DVec3;
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_shapes::carved::{Carved, CarvedError, Solid};

use crate::assembling::landscape::check_shapes;
use crate::assembling::placing::rotation;
use crate::description::{CarvedDescription, SolidDescription};
use snowblue_base::{KeyError, KeyPath};

/// The mesh of carved snow, or what is wrong with its cells or its solids.
pub(super) fn carved_mesh(path: &KeyPath, description: &CarvedDescription) -> Result<TriangleMesh, KeyError> {
    check_shapes(path)?;
    let carved = Carved {
        cell_m: description.cell,
        rounding_m: description.rounding,
        relief_m: description.relief,
        relief_length_m: description.relief_length,
        seed: description.seed,
        add: description.add.iter().map(solid).collect(),
        remove: description.remove.iter().map(solid).collect(),
    };
    carved.mesh().map_err(|error| match error {
        CarvedError::TooFine { least_m } => {
            let (cell_m, least_m) = (description.cell, rounded_up(least_m));
            path.key("cell").error(format!("is {cell_m} m, but must be at least {least_m} m for solids of this size"))
        }
        CarvedError::Empty => path.error("is empty: its solids are removed, rounded away, or smaller than a cell"),
    })
}

fn solid(description: &SolidDescription) -> Solid {
    match description {
        SolidDescription::Ellipsoid(ellipsoid) => Solid::Ellipsoid {
            centre: ellipsoid.centre.into(),
            axes: rotation(ellipsoid.rotation_deg),
            radii_m: ellipsoid.radii.into(),
        },
        SolidDescription::Box(cuboid) => Solid::Box {
            centre: cuboid.centre.into(),
            axes: rotation(cuboid.rotation_deg),
            size_m: cuboid.size.into(),
            edge_m: cuboid.edge,
        },
        SolidDescription::Capsule(capsule) => {
            Solid::Capsule { from: capsule.from.into(), to: capsule.to.into(), radii_m: capsule.radius.ends() }
        }
        SolidDescription::Cylinder(cylinder) => Solid::Cylinder {
            from: cylinder.from.into(),
            to: cylinder.to.into(),
            radius_m: cylinder.radius,
            edge_m: cylinder.edge,
        },
        SolidDescription::HalfSpace(half_space) => {
            Solid::HalfSpace { point: half_space.point.into(), normal: DVec3::from(half_space.normal).normalize() }
        }
    }
}

/// A length rounded up to two digits.
fn rounded_up(length_m: f64) -> f64 {
    let digits = 10f64.powf(1.0 - length_m.log10().floor());
    (length_m * digits).ceil() / digits
}
