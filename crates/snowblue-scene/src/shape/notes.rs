//! Notes on the bodies of snow of a scene.

use std::collections::BTreeMap;

use snowblue_base::files::MAX_NAMED;
use snowblue_base::short_number;
use snowblue_geometry::bounds::Bounds;

use super::joints::joints;
use crate::integrator::IntegratorKind;
use crate::material::NamedMaterial;
use crate::objects::{Object, Objects};

/// Notes on bodies of snow that have a side below the size of their finest grains, or that meet.
pub(crate) fn notes_on_bodies(
    objects: &Objects,
    materials: &[NamedMaterial],
    integrator: IntegratorKind,
) -> Vec<String> {
    let name = |object: usize| {
        let Object { name, body, .. } = &objects.list()[object];
        body.as_ref().unwrap_or(name)
    };
    let mut small = Vec::new();
    for (index, object) in objects.list().iter().enumerate() {
        let members = objects.body_of(index);
        let snow = materials[object.material].material.snow().filter(|_| members.first() == Some(&index));
        let bounds: Option<Vec<Bounds>> = members.iter().map(|member| objects.list()[*member].shape.bounds()).collect();
        let (Some(snow), Some(bounds)) = (snow, bounds) else { continue };
        let bounds = Bounds::of(bounds.iter().flat_map(|bounds| [bounds.low.into(), bounds.high.into()]));
        let name = name(index);
        let size_mm = 1e3 * (bounds.high - bounds.low).as_dvec3();
        let rounding_mm = 2e3 * f64::from(bounds.low.abs().max(bounds.high.abs()).max_element() * f32::EPSILON);
        let grains_mm = snow.samples().iter().map(|sample| 1e-3 * sample.grain_size.middle_um());
        let grain_mm = grains_mm.fold(f64::INFINITY, f64::min);
        let [x, y, z] = size_mm.to_array().map(|side_mm| short_number((side_mm * 1e4).round() / 1e4));
        if size_mm.min_element() + rounding_mm < grain_mm {
            small.push(format!(
                "\"{name}\" is {x} × {y} × {z} mm, smaller than a grain of its snow, which is {} mm: light is computed \
                 as in many grains",
                short_number(grain_mm)
            ));
        }
    }
    let is_snow = |object: usize| materials[objects.list()[object].material].material.is_snow();
    let of_pair = |[one, other]: [usize; 2]| {
        let is_same = objects.list()[one].material == objects.list()[other].material;
        let remedy = if is_same { "give both the same `body`" } else { "make them `layers` of one snow" };
        format!(
            "\"{}\" and \"{}\" are bodies of snow that meet, but light does not spread from one into the other: \
             {remedy}",
            name(one),
            name(other)
        )
    };
    // Web pages show no notes.
    let has_joints = !integrator.crosses_bodies() && !cfg!(target_family = "wasm");
    let pairs = if has_joints { joints(objects, is_snow) } else { Vec::new() };
    let mut meeting: Vec<String> = pairs.into_iter().map(of_pair).collect();
    name_first(&mut small, "bodies are smaller than a grain of their snow");
    name_first(&mut meeting, "pairs of bodies meet");
    [small, meeting].concat()
}

/// Keeps the first notes on bodies, and adds the number of the remaining notes.
fn name_first(notes: &mut Vec<String>, others: &str) {
    if notes.len() > MAX_NAMED {
        let more = notes.len() - MAX_NAMED;
        notes.truncate(MAX_NAMED);
        notes.push(format!("{more} more {others}"));
    }
}

/// A body whose objects differ in material.
pub(crate) fn body_of_two(objects: &Objects) -> Option<&str> {
    let mut materials = BTreeMap::new();
    let named = objects.list().iter().filter_map(|object| Some((object.body.as_deref()?, object.material)));
    named
        .filter(|(body, material)| materials.entry(*body).or_insert(*material) != material)
        .map(|(body, _)| body)
        .next()
}
