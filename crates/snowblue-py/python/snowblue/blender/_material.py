"""The material of baked snow: L(mu) = sum of R0 F + K(mu) J / pi.

J is the sum over the lamps of an attribute times the strength of the lamp, which drivers read, and of the attribute of
the sky. K J / pi is an emission; it is negative where snow is lit, and Cycles adds it as such.

R0 F is a diffuse surface of the colour pi R0. A renderer gives a surface one colour for all light, so the colour is the
mean over what falls on the place, for each channel: pi R0 of each lamp and sun disc for its light, and 1 for the sky
and for light by way of other surfaces. The attributes with the irradiance weight it. Eevee gets the sum as one
emission, by Shader to RGB.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from snowblue.blender._lamps import drive_strength
from snowblue.blender._nodes import Tree
from snowblue.blender._reflection import FACTOR, OWN, TO_LIGHT, reflection_group, reflection_images, remove_groups

SKY, SUN, LAMP = "snow_sky", "snow_sun_", "snow_lamp_"
IRRADIANCE, PLACE = "_irradiance", "_place"
MOST_ATTRIBUTES, MOST_PROPERTIES = 15, 8
"""Of points and of objects, that a material has in Eevee."""


@dataclass(frozen=True)
class LightNodes:
    """A light on the snow."""

    attribute: str
    """The name of its J, and the beginning of the names of its irradiance and its place. J of sun discs is in that of
    the sky."""
    label: str
    lamp: bpy.types.Object | None = None
    """What its strength is read of; by default that is 1."""
    is_distant: bool | None = None
    """Whether its place is a direction; none for the sky, which has no place."""


def fill_material(
    material: bpy.types.Material, lights: Sequence[LightNodes], escape: Sequence[float], reflection: np.ndarray
) -> None:
    """Makes the nodes of snow, whose K has these coefficients by ascending powers, and whose R0 has this table."""
    if not material.node_tree:
        material.use_nodes = True
    material.node_tree.nodes.clear()
    tree = Tree(material.node_tree)
    flux, shares = _light(tree, lights)
    diffuse, diffuse_of_eevee = (tree.add("ShaderNodeBsdfDiffuse", 10, row, "R0 F") for row in (1, 1.5))
    for node in (diffuse, diffuse_of_eevee):
        node.inputs["Color"].default_value = (1, 1, 1, 1)
    if shares.directed:
        name = f"R0 of {material.name}"
        images = reflection_images(name, reflection)
        color = _color(tree, 1, shares, reflection_group(name, images, is_filtered=True))
        tree.link(color, diffuse.inputs["Color"])
        if _fits_eevee(lights):
            # On software drivers, Eevee filters images of numbers wrongly.
            color = _color(tree, 1.5, shares, reflection_group(name, images, is_filtered=False))
            tree.link(color, diffuse_of_eevee.inputs["Color"])
    geometry = tree.add("ShaderNodeNewGeometry", 0, -2)
    # Interpolated normals may point away from the eye.
    dot = tree.vector("DOT_PRODUCT", 1, -2, geometry.outputs["Normal"], geometry.outputs["Incoming"])
    mu = tree.math("MAXIMUM", 2, -2, dot, 0.0)
    *rest, k2, k3 = (float(k) / math.pi for k in escape)
    value: bpy.types.NodeSocket | float = k3
    for column, k in enumerate((k2, *reversed(rest)), start=3):
        value = tree.math("MULTIPLY_ADD", column, -2, value, mu, k)
    light = tree.vector("SCALE", 10, 0, flux, value, label="K J / pi")

    emission = tree.add("ShaderNodeEmission", 11, 0)
    tree.link(light, emission.inputs["Color"])
    both = tree.add("ShaderNodeAddShader", 12, 0)
    tree.link(emission.outputs[0], both.inputs[0])
    tree.link(diffuse.outputs[0], both.inputs[1])
    output = tree.add("ShaderNodeOutputMaterial", 13, 0, target="CYCLES")
    tree.link(both.outputs[0], output.inputs["Surface"])

    reflected = tree.add("ShaderNodeShaderToRGB", 11, 1)
    tree.link(diffuse_of_eevee.outputs[0], reflected.inputs[0])
    total = tree.vector("ADD", 12, 1, reflected.outputs["Color"], light)
    shown = tree.add("ShaderNodeEmission", 13, 1)
    tree.link(total, shown.inputs["Color"])
    output = tree.add("ShaderNodeOutputMaterial", 14, 1, target="EEVEE")
    tree.link(shown.outputs[0], output.inputs["Surface"])
    # Triangles are sampled by their area, negative or not. On a floor that is lit by snow alone, the noise is half that
    # of "NONE", and the mean the same.
    material.cycles.emission_sampling = "FRONT"


@dataclass(frozen=True)
class _Shares:
    """What falls on a place."""

    directed: list[tuple[bpy.types.NodeSocket, bpy.types.NodeSocket]]
    """The irradiance by lights that have a place, and the vectors to them."""
    all_of: bpy.types.NodeSocket
    """The irradiance by all light."""


def _fits_eevee(lights: Sequence[LightNodes]) -> bool:
    """Whether Eevee has as many attributes as the reflection of some lights takes."""
    suns = sum(light.attribute.startswith(SUN) for light in lights)
    places = sum(light.is_distant is not None for light in lights)
    return 2 * len(lights) - suns <= MOST_ATTRIBUTES and places <= MOST_PROPERTIES


def _light(tree: Tree, lights: Sequence[LightNodes]) -> tuple[bpy.types.NodeSocket, _Shares]:
    """J, and what falls on the surface."""
    position = tree.add("ShaderNodeNewGeometry", 0, -1).outputs["Position"]
    fluxes, irradiances, directed = [], [], []
    for number, light in enumerate(lights):
        row = 2 * number

        def attribute(
            row: float, ending: str = "", kind: str = "GEOMETRY", light: LightNodes = light
        ) -> bpy.types.NodeSocket:
            name = light.attribute + ending
            node = tree.add("ShaderNodeAttribute", 0, row, light.label, attribute_name=name, attribute_type=kind)
            return node.outputs["Vector"]

        irradiance = attribute(row + 1, IRRADIANCE)
        if light.lamp is None:
            direct = irradiance
            # That of sun discs is not in the attribute of the World.
            irradiances.append(irradiance)
            if not light.attribute.startswith(SUN):
                fluxes.append(attribute(row))
        else:
            node = tree.add("ShaderNodeVectorMath", 1, row, light.label, operation="ADD")
            drive_strength(node.inputs[0], light.lamp)
            strength = node.outputs[0]
            fluxes.append(tree.vector("MULTIPLY", 2, row, attribute(row), strength))
            # Lamps may be negative, and their sum zero where they light the snow.
            amount = tree.vector("ABSOLUTE", 2, row + 0.5, strength)
            split = tree.add("ShaderNodeSeparateXYZ", 2, row + 1)
            tree.link(irradiance, split.inputs[0])
            direct = tree.vector("SCALE", 4, row + 1, amount, split.outputs[0])
            both = tree.math("ADD", 3, row + 1, split.outputs[0], split.outputs[1])
            irradiances.append(tree.vector("SCALE", 5, row + 1, amount, both))
        if light.is_distant is not None:
            place = attribute(row + 1.5, PLACE, "OBJECT")
            to_light = place if light.is_distant else tree.vector("SUBTRACT", 3, row + 1.5, place, position)
            directed.append((direct, to_light))
    return _sum(tree, 0, fluxes), _Shares(directed, _sum(tree, 1, irradiances))


def _color(tree: Tree, row: float, shares: _Shares, reflection: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """The colour of the surface: the mean of pi R0 over the light that falls on it."""
    excesses = []
    for number, (irradiance, to_light) in enumerate(shares.directed):
        group = tree.add("ShaderNodeGroup", 4, row + 2 * number + 0.6, node_tree=reflection)
        tree.link(to_light, group.inputs[TO_LIGHT])
        excess = tree.math("SUBTRACT", 5, row + 2 * number + 0.6, group.outputs[FACTOR], 1.0)
        excesses.append(tree.vector("SCALE", 6, row + 2 * number + 0.6, irradiance, excess))
    # Where there is no light, Blender's quotient is 0.
    share = tree.vector("DIVIDE", 9, row, _sum(tree, row + 0.6, excesses), shares.all_of)
    return tree.vector("ADD", 9.5, row, share, (1.0, 1.0, 1.0))


def _sum(tree: Tree, row: float, parts: Sequence[bpy.types.NodeSocket]) -> bpy.types.NodeSocket:
    total = parts[0]
    for number, part in enumerate(parts[1:], start=1):
        total = tree.vector("ADD", 7, row + 2 * number, total, part)
    return total


def remove_material(material: bpy.types.Material) -> None:
    """Removes a material of snow that nothing uses, with the groups that were made for it."""
    if material.users:
        return
    nodes = material.node_tree.nodes if material.node_tree else ()
    groups = {node.node_tree for node in nodes if node.type == "GROUP" and node.node_tree and OWN in node.node_tree}
    bpy.data.materials.remove(material)
    remove_groups(groups)
