//! A surface with its charts.

use glam::Vec3;
use snowblue_geometry::ellipsoid::Ellipsoid;

use crate::bake::lightmap::charts::Charts;

/// A surface that is laid flat.
pub(in crate::bake) struct FlatSurface<'s> {
    /// Index of the object in the scene.
    pub(in crate::bake) object: usize,
    pub(in crate::bake) charts: &'s Charts,
    /// The ellipsoid whose surface it is.
    pub(in crate::bake) ellipsoid: Option<Ellipsoid>,
    pub(in crate::bake) positions: &'s [Vec3],
    pub(in crate::bake) normals: &'s [Vec3],
    pub(in crate::bake) triangles: &'s [[u32; 3]],
}
