"""Evaluated meshes in metres, with modifiers and transforms applied, and the materials of surfaces without snow."""

from __future__ import annotations

import warnings
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

WITH_FACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")
"""Types of objects that can have faces."""
DEFAULT_REFLECTANCE = 0.8
"""That of Blender's default material."""
UNKNOWN_REFLECTANCE = 0.5
GREATEST_INDEX = 3.0
"""The greatest refractive index of a pane."""


def world_mesh(
    evaluated: bpy.types.Object, to_world: Matrix, unit_m: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices in m (n, 3), triangles (m, 3), and the number of the material of each triangle (m)."""
    mesh = evaluated.to_mesh()
    if mesh is None:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    try:
        mesh.calc_loop_triangles()
        vertices = np.empty(3 * len(mesh.vertices), dtype=np.float32)
        mesh.vertices.foreach_get("co", vertices)
        triangles = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        materials = np.empty(len(mesh.loop_triangles), dtype=np.int32)
        mesh.loop_triangles.foreach_get("material_index", materials)
    finally:
        evaluated.to_mesh_clear()
    in_world = placed(vertices.reshape(-1, 3).astype(float), to_world, unit_m)
    return in_world, triangles.reshape(-1, 3).astype(np.int64), materials.astype(np.int64)


def placed(vertices: np.ndarray, to_world: Matrix, unit_m: float) -> np.ndarray:
    """Vertices (n, 3) of an object in the world, in m."""
    matrix = np.array(to_world)
    return (vertices @ matrix[:3, :3].T + matrix[:3, 3]) * unit_m


def material_of(thing: bpy.types.Object, slot: int) -> dict[str, Any]:
    """The material of a scene for a surface that is not snow."""
    slots = thing.material_slots
    material = slots[min(slot, len(slots) - 1)].material if len(slots) else None
    if material is None:
        return {"type": "diffuse", "reflectance": DEFAULT_REFLECTANCE}
    # From Blender 5 on, all materials have nodes.
    has_nodes = bpy.app.version >= (5, 0) or material.use_nodes
    tree = material.node_tree if has_nodes else None
    if tree is None:
        return {"type": "diffuse", "reflectance_rgb": list(material.diffuse_color[:3])}
    if any(_shines(node) for node in tree.nodes):
        warnings.warn(
            f"material '{material.name}' emits light, which snow does not get: it takes light from lamps and the World",
            stacklevel=2,
        )
    output = tree.get_output_node("CYCLES")
    links = output.inputs["Surface"].links if output else ()
    node = links[0].from_node if links else None
    kind = node.type if node else ""
    is_principled = kind == "BSDF_PRINCIPLED"
    transmission = _value(node, "Transmission Weight", "Transmission") if is_principled else float(kind == "BSDF_GLASS")
    index = _value(node, "IOR") if transmission == 1.0 else None
    if index is not None and 1.0 <= index <= GREATEST_INDEX:
        return {"type": "glass", "refractive_index": index}
    alpha = _value(node, "Alpha") if is_principled else 1.0
    if is_principled and (transmission != 0.0 or alpha is None):
        warnings.warn(f"material '{material.name}' blocks light for snow that it lets pass in part", stacklevel=2)
    opacity = {} if alpha is None or alpha == 1.0 else {"opacity": alpha}
    name = {"BSDF_PRINCIPLED": "Base Color", "BSDF_DIFFUSE": "Color"}.get(kind)
    if name is None or node.inputs[name].is_linked:
        warnings.warn(
            f"material '{material.name}' has no plain colour: it reflects light onto snow as a grey of "
            f"{UNKNOWN_REFLECTANCE}, and blocks light unless it has an alpha",
            stacklevel=2,
        )
        return {"type": "diffuse", "reflectance": UNKNOWN_REFLECTANCE, **opacity}
    return {"type": "diffuse", "reflectance_rgb": list(node.inputs[name].default_value[:3]), **opacity}


def _value(node: bpy.types.Node, *names: str) -> float | None:
    """The value of an input, which has one of some names in each version of Blender; none where it varies."""
    socket = next(node.inputs[name] for name in names if name in node.inputs)
    return None if socket.is_linked else float(socket.default_value)


def _shines(node: bpy.types.Node) -> bool:
    if node.type == "EMISSION":
        return True
    if node.type != "BSDF_PRINCIPLED":
        return False
    strength, color = node.inputs["Emission Strength"], node.inputs["Emission Color"]
    is_black = not color.is_linked and not any(color.default_value[:3])
    return (strength.is_linked or strength.default_value > 0) and not is_black
