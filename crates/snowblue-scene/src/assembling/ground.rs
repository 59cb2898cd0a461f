//! Snow as the land around a scene: planes of deep snow.

use std::collections::BTreeMap;

use crate::assembling::material::NamedMaterial;
use crate::description::{ObjectDescription, ShapeDescription};
use crate::material::Material;
use crate::material::deep_snow::DeepSnow;
use snowblue_base::{KeyError, KeyPath};

/// Adds the materials of planes of snow, and returns their indices by those of the snow. Of layers the uppermost
/// counts, and of a mask the snow at 0.
pub(super) fn add_grounds(
    materials: &mut Vec<NamedMaterial>,
    objects: &[ObjectDescription],
) -> Result<BTreeMap<usize, usize>, KeyError> {
    let mut grounds = BTreeMap::new();
    for (number, object) in objects.iter().enumerate() {
        let index = materials.iter().position(|material| material.name == object.common.material);
        let (Some(index), ShapeDescription::Plane(_)) = (index, &object.shape) else { continue };
        let Some(snow) = materials[index].material.snow().filter(|_| !grounds.contains_key(&index)) else { continue };
        let ground = DeepSnow::new(&snow.samples()[0]).map_err(|error| {
            let reason = format!("cannot be the snow of a plane: {error}");
            KeyPath::root("object").index(number).key("material").error(reason)
        })?;
        grounds.insert(index, materials.len());
        let name = materials[index].name.clone();
        materials.push(NamedMaterial { name, material: Material::Ground(Box::new(ground)) });
    }
    Ok(grounds)
}
