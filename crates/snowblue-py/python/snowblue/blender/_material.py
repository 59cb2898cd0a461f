"""The material of baked snow: L(mu) = R0 F + K(mu) J / pi.

R0 F is a white diffuse surface. J is the sum over the lamps of an attribute times the strength of the lamp, which
drivers read, and of the attribute of the sky. K J / pi is an emission; it is negative where snow is lit, and Cycles
adds it as such. Eevee gets the sum as one emission, by Shader to RGB.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import bpy

from snowblue.blender._lamps import drive_strength

SKY, LAMP = "snow_sky", "snow_lamp_"
COLUMN = 220


def attribute_of(number: int) -> str:
    """The name of the attribute of a lamp."""
    return f"{LAMP}{number}"


class Tree:
    """Nodes in columns from left to right."""

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree

    def add(self, kind: str, column: int, row: float = 0.0, label: str = "", **settings: object) -> bpy.types.Node:
        node = self.tree.nodes.new(kind)
        node.location = (COLUMN * column, -COLUMN * row)
        node.label = label
        for name, value in settings.items():
            setattr(node, name, value)
        return node

    def link(self, source: bpy.types.NodeSocket, target: bpy.types.NodeSocket) -> None:
        self.tree.links.new(source, target)

    def join(
        self, kind: str, operation: str, column: int, row: float, *values: bpy.types.NodeSocket | float
    ) -> bpy.types.NodeSocket:
        """The first output of a node of mathematics of some values."""
        node = self.add(kind, column, row, operation=operation)
        for value, socket in zip(values, node.inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.link(value, socket)
            else:
                socket.default_value = value
        return node.outputs[0]


def fill_material(
    material: bpy.types.Material, lamps: Sequence[bpy.types.Object], has_sky: bool, escape: Sequence[float]
) -> None:
    """Makes the nodes of snow, whose K has these coefficients by ascending powers."""
    if not material.node_tree:
        material.use_nodes = True
    material.node_tree.nodes.clear()
    tree = Tree(material.node_tree)
    flux = _flux(tree, lamps, has_sky)
    geometry = tree.add("ShaderNodeNewGeometry", 0, -2)
    dot = tree.add("ShaderNodeVectorMath", 1, -2, operation="DOT_PRODUCT")
    tree.link(geometry.outputs["Normal"], dot.inputs[0])
    tree.link(geometry.outputs["Incoming"], dot.inputs[1])
    # Interpolated normals may point away from the eye.
    mu = tree.join("ShaderNodeMath", "MAXIMUM", 2, -2, dot.outputs["Value"], 0.0)
    *rest, k2, k3 = (float(k) / math.pi for k in escape)
    value: bpy.types.NodeSocket | float = k3
    for column, k in enumerate((k2, *reversed(rest)), start=3):
        value = tree.join("ShaderNodeMath", "MULTIPLY_ADD", column, -2, value, mu, k)
    light = tree.add("ShaderNodeVectorMath", 6, 0, "K J / pi", operation="SCALE")
    tree.link(flux, light.inputs[0])
    tree.link(value, light.inputs["Scale"])
    diffuse = tree.add("ShaderNodeBsdfDiffuse", 6, 1, "R0 F")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)

    emission = tree.add("ShaderNodeEmission", 7, 0)
    tree.link(light.outputs[0], emission.inputs["Color"])
    both = tree.add("ShaderNodeAddShader", 8, 0)
    tree.link(emission.outputs[0], both.inputs[0])
    tree.link(diffuse.outputs[0], both.inputs[1])
    output = tree.add("ShaderNodeOutputMaterial", 9, 0, target="CYCLES")
    tree.link(both.outputs[0], output.inputs["Surface"])

    reflected = tree.add("ShaderNodeShaderToRGB", 7, 1)
    tree.link(diffuse.outputs[0], reflected.inputs[0])
    total = tree.join("ShaderNodeVectorMath", "ADD", 8, 1, reflected.outputs["Color"], light.outputs[0])
    shown = tree.add("ShaderNodeEmission", 9, 1)
    tree.link(total, shown.inputs["Color"])
    output = tree.add("ShaderNodeOutputMaterial", 10, 1, target="EEVEE")
    tree.link(shown.outputs[0], output.inputs["Surface"])
    # Triangles are sampled by their area, negative or not. On a floor that is lit by snow alone, the noise is half that
    # of "NONE", and the mean the same.
    material.cycles.emission_sampling = "FRONT"


def _flux(tree: Tree, lamps: Sequence[bpy.types.Object], has_sky: bool) -> bpy.types.NodeSocket:
    """J, the sum over the lamps and the sky."""
    parts = []
    for row, lamp in enumerate(lamps):
        attribute = tree.add("ShaderNodeAttribute", 0, row, lamp.name, attribute_name=attribute_of(row))
        strength = tree.add("ShaderNodeVectorMath", 1, row, lamp.name, operation="MULTIPLY")
        tree.link(attribute.outputs["Vector"], strength.inputs[0])
        drive_strength(strength.inputs[1], lamp)
        parts.append(strength.outputs[0])
    if has_sky:
        parts.append(tree.add("ShaderNodeAttribute", 0, len(lamps), SKY, attribute_name=SKY).outputs["Vector"])
    flux = parts[0]
    for row, part in enumerate(parts[1:], start=1):
        flux = tree.join("ShaderNodeVectorMath", "ADD", 3, row, flux, part)
    return flux
