//! Triangles as files give them: corners by index, and what else is known at each vertex.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3, Vec2, Vec3};

/// A surface of triangles in coordinates of its own.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Triangles {
    /// Places of the vertices.
    pub positions: Vec<Vec3>,
    /// The three vertices of each triangle, as indices into `positions`.
    pub corners: Vec<[u32; 3]>,
    /// Texture coordinates of each vertex, or nothing at all.
    pub uv: Vec<Vec2>,
    /// Further values of each vertex, by name.
    pub attributes: BTreeMap<String, Vec<f32>>,
}

impl Triangles {
    /// Triangles by their corners alone, no two of which share a vertex.
    #[expect(clippy::cast_possible_truncation, reason = "a mesh in memory has fewer than 2^32 vertices")]
    pub fn loose(triangles: &[[Vec3; 3]]) -> Self {
        Self {
            positions: triangles.iter().flatten().copied().collect(),
            corners: (0..triangles.len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect(),
            ..Self::default()
        }
    }

    /// The places of one triangle's corners.
    pub fn places(&self, triangle: usize) -> [Vec3; 3] {
        self.corners[triangle].map(|index| self.positions[index as usize])
    }

    /// Adds a surface's triangles to these, under a map into their coordinates. Texture coordinates and attributes stay
    /// only where both have them.
    ///
    /// # Errors
    ///
    /// When there would be 2³² vertices or more.
    pub fn append(&mut self, other: &Self, map: &DAffine3) -> Result<(), String> {
        let too_many = |_| "the mesh has more than 4294967295 vertices".to_owned();
        u32::try_from(self.positions.len() + other.positions.len()).map_err(too_many)?;
        let base = u32::try_from(self.positions.len()).map_err(too_many)?;
        let first = self.corners.is_empty() && self.positions.is_empty();
        if first {
            (self.uv, self.attributes) = (other.uv.clone(), other.attributes.clone());
        } else {
            if self.uv.is_empty() || other.uv.is_empty() {
                self.uv.clear();
            } else {
                self.uv.extend(&other.uv);
            }
            self.attributes
                .retain(|name, values| other.attributes.get(name).inspect(|more| values.extend(more.iter())).is_some());
        }
        let mirrors = map.matrix3.determinant() < 0.0;
        let moved = |place: &Vec3| map.transform_point3(place.as_dvec3()).as_vec3();
        self.positions.extend(other.positions.iter().map(moved));
        self.corners.extend(other.corners.iter().map(|&[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|index| index + base);
            if mirrors { [a, c, b] } else { [a, b, c] }
        }));
        Ok(())
    }

    /// The same surface about the middle of its box and at a size of about 1, and the map that puts it back.
    ///
    /// Single precision is finest there: a mesh surveyed in coordinates of kilometres, or drawn in micrometres, then
    /// is traced as well as any other. The size is changed by a power of two, which rounds nothing.
    #[must_use]
    pub fn centred(mut self) -> (Self, DAffine3) {
        let low = self.positions.iter().fold(Vec3::INFINITY, |low, place| low.min(*place)).as_dvec3();
        let high = self.positions.iter().fold(Vec3::NEG_INFINITY, |high, place| high.max(*place)).as_dvec3();
        let centre = (0.5 * (low + high)).as_vec3().as_dvec3();
        let reach = (0.5 * (high - low)).max_element();
        let unit = if reach > 0.0 { reach.log2().ceil().exp2() } else { 1.0 };
        for place in &mut self.positions {
            *place = ((place.as_dvec3() - centre) / unit).as_vec3();
        }
        (self, DAffine3::from_scale_rotation_translation(DVec3::splat(unit), glam::DQuat::IDENTITY, centre))
    }
}

/// The triangles of two grids of points, the inner before the outer, and of the walls between their rims. Seen from outside,
/// columns run to the right and rows up; all triangles face outwards.
pub(crate) fn closed_grids(width: u32, height: u32) -> Vec<[u32; 3]> {
    let inner = |column: u32, row: u32| row * width + column;
    let outer = |column: u32, row: u32| width * height + inner(column, row);
    let mut corners = Vec::new();
    let mut quad = |a: u32, b: u32, c: u32, d: u32| corners.extend([[a, b, c], [a, c, d]]);
    for row in 0..height - 1 {
        for column in 0..width - 1 {
            let (right, up) = (column + 1, row + 1);
            quad(outer(column, row), outer(right, row), outer(right, up), outer(column, up));
            quad(inner(column, row), inner(column, up), inner(right, up), inner(right, row));
        }
    }
    let (last, top) = (width - 1, height - 1);
    for column in 0..last {
        let right = column + 1;
        quad(inner(column, 0), inner(right, 0), outer(right, 0), outer(column, 0));
        quad(inner(column, top), outer(column, top), outer(right, top), inner(right, top));
    }
    for row in 0..top {
        let up = row + 1;
        quad(inner(0, row), outer(0, row), outer(0, up), inner(0, up));
        quad(inner(last, row), inner(last, up), outer(last, up), outer(last, row));
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centring_changes_no_place() {
        let places = [Vec3::new(5000.1, -3.0, 0.25), Vec3::new(5003.7, -2.0, 0.5), Vec3::new(5001.0, 9.0, 0.75)];
        let (centred, back) = Triangles::loose(&[places]).centred();
        for (own, place) in centred.positions.iter().zip(places) {
            assert!(own.abs().max_element() <= 1.0);
            assert_eq!(back.transform_point3(own.as_dvec3()).as_vec3(), place);
        }
    }

    #[test]
    fn what_only_one_part_knows_is_dropped() {
        let part = |uv: bool| Triangles {
            uv: if uv { vec![Vec2::X; 3] } else { vec![] },
            attributes: BTreeMap::from([("wetness".to_owned(), vec![0.5; 3])]),
            ..Triangles::loose(&[[Vec3::ZERO, Vec3::X, Vec3::Y]])
        };
        let mut both = part(true);
        both.append(&part(false), &DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0))).unwrap();
        assert!(both.uv.is_empty());
        assert_eq!(both.attributes["wetness"].len(), 6);
        assert_eq!(both.corners, [[0, 1, 2], [3, 5, 4]], "a mirrored part keeps its outside");
    }
}
