"""The material of baked snow: L(mu) = sum of R0 F + K(mu) J / pi.

J is the sum over the lamps of an attribute times the strength of the lamp, which drivers read, and of the attribute of
the sky. K J / pi is an emission; it is negative where snow is lit, and Cycles adds it as such.

R0 F is a diffuse surface of the color pi R0. A renderer gives a surface one color for all light, so the color is the
mean over what falls on the place: pi R0 of each lamp and sun disc for its light, and 1 for the sky and for light by way
of other surfaces. The attributes with the irradiance weight it. Eevee gets the sum as one emission, by Shader to RGB.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from snowblue.blender._lamps import drive_strength
from snowblue.blender._nodes import Tree
from snowblue.blender._reflection import FACTOR, TO_LIGHT, reflection_group, reflection_images, remove_groups

SKY, SUN, LAMP = "snow_sky", "snow_sun_", "snow_lamp_"
IRRADIANCE, PLACE = "_irradiance", "_place"
LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Of linear sRGB."""
LEAST_IRRADIANCE = 1e-12
"""Below which there is no light."""


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
    name = f"R0 of {material.name}"
    images = reflection_images(name, reflection)
    flux, shares = _light(tree, lights)
    # On software drivers, Eevee filters images of numbers wrongly.
    [color, color_of_eevee] = (
        _color(tree, row, shares, reflection_group(name, images, is_filtered=is_filtered))
        for row, is_filtered in ((1, True), (1.5, False))
    )
    geometry = tree.add("ShaderNodeNewGeometry", 0, -2)
    # Interpolated normals may point away from the eye.
    dot = tree.vector("DOT_PRODUCT", 1, -2, geometry.outputs["Normal"], geometry.outputs["Incoming"])
    mu = tree.math("MAXIMUM", 2, -2, dot, 0.0)
    *rest, k2, k3 = (float(k) / math.pi for k in escape)
    value: bpy.types.NodeSocket | float = k3
    for column, k in enumerate((k2, *reversed(rest)), start=3):
        value = tree.math("MULTIPLY_ADD", column, -2, value, mu, k)
    light = tree.vector("SCALE", 10, 0, flux, value, label="K J / pi")
    diffuse = tree.add("ShaderNodeBsdfDiffuse", 10, 1, "R0 F")
    tree.link(color, diffuse.inputs["Color"])

    emission = tree.add("ShaderNodeEmission", 11, 0)
    tree.link(light, emission.inputs["Color"])
    both = tree.add("ShaderNodeAddShader", 12, 0)
    tree.link(emission.outputs[0], both.inputs[0])
    tree.link(diffuse.outputs[0], both.inputs[1])
    output = tree.add("ShaderNodeOutputMaterial", 13, 0, target="CYCLES")
    tree.link(both.outputs[0], output.inputs["Surface"])

    diffuse = tree.add("ShaderNodeBsdfDiffuse", 10, 1.5, "R0 F")
    tree.link(color_of_eevee, diffuse.inputs["Color"])
    reflected = tree.add("ShaderNodeShaderToRGB", 11, 1)
    tree.link(diffuse.outputs[0], reflected.inputs[0])
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

        strength = luminance = None
        if light.lamp is not None:
            node = tree.add("ShaderNodeVectorMath", 1, row, light.label, operation="ADD")
            drive_strength(node.inputs[0], light.lamp)
            strength = node.outputs[0]
            luminance = tree.vector("DOT_PRODUCT", 2, row + 0.5, strength, LUMINANCE)
        if not light.attribute.startswith(SUN):
            flux = attribute(row)
            fluxes.append(flux if strength is None else tree.vector("MULTIPLY", 2, row, flux, strength))
        irradiance = attribute(row + 1, IRRADIANCE)
        if luminance is not None:
            irradiance = tree.vector("SCALE", 3, row + 1, irradiance, luminance)
        split = tree.add("ShaderNodeSeparateXYZ", 4, row + 1)
        tree.link(irradiance, split.inputs[0])
        direct, rest = split.outputs[0], split.outputs[1]
        irradiances.append(tree.math("ADD", 5, row + 1, direct, rest))
        if light.is_distant is not None:
            place = attribute(row + 1.5, PLACE, "OBJECT")
            to_light = place if light.is_distant else tree.vector("SUBTRACT", 3, row + 1.5, place, position)
            directed.append((direct, to_light))
    flux = fluxes[0]
    for row, part in enumerate(fluxes[1:], start=1):
        flux = tree.vector("ADD", 7, 2 * row, flux, part)
    return flux, _Shares(directed, tree.math("MAXIMUM", 8, 1, _sum(tree, 1, irradiances), LEAST_IRRADIANCE))


def _color(tree: Tree, row: float, shares: _Shares, reflection: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """The color of the surface: the mean of pi R0 over the light that falls on it."""
    excesses = []
    for number, (irradiance, to_light) in enumerate(shares.directed):
        group = tree.add("ShaderNodeGroup", 4, row + 2 * number + 0.6, node_tree=reflection)
        tree.link(to_light, group.inputs[TO_LIGHT])
        excess = tree.math("SUBTRACT", 5, row + 2 * number + 0.6, group.outputs[FACTOR], 1.0)
        excesses.append(tree.math("MULTIPLY", 6, row + 2 * number + 0.6, excess, irradiance))
    share = tree.math("DIVIDE", 9, row, _sum(tree, row + 0.6, excesses), shares.all_of)
    return tree.math("ADD", 9.5, row, share, 1.0)


def _sum(tree: Tree, row: float, parts: Sequence[bpy.types.NodeSocket]) -> bpy.types.NodeSocket | float:
    total: bpy.types.NodeSocket | float = parts[0] if parts else 0.0
    for number, part in enumerate(parts[1:], start=1):
        total = tree.math("ADD", 7, row + 2 * number, total, part)
    return total


def remove_material(material: bpy.types.Material) -> None:
    """Removes a material of snow that nothing uses, with the group of its nodes."""
    if material.users:
        return
    groups = {node.node_tree for node in material.node_tree.nodes if node.type == "GROUP" and node.node_tree}
    bpy.data.materials.remove(material)
    remove_groups(groups)
