"""The reflection function R0 of snow as nodes: a group that gives pi R0 for light from a direction.

The logarithm of (mu + mu0) R0 is a polynomial in the cosine of the azimuth. Its coefficients are smooth functions of
the roots of both cosines, and so the red, green and blue of images. Against the table, pi R0 has an RMS error of 1 %
where both cosines are at least 0.1, and of 1.5 % where they are at least 0.05.
"""

from __future__ import annotations

import math
from itertools import product

import bpy
import numpy as np

from snowblue.blender._nodes import Tree

TO_LIGHT, FACTOR = "To Light", "Factor"
OWN = "snowblue"
"""A property of groups that were made here."""
DEGREE = 5
LEAST_VALUE = 1e-6
"""Of pi (mu + mu0) R0, which has a logarithm."""
LEAST_COSINES = 1e-3
"""Sum of the cosines of incidence and exit below which the function is not resolved."""
LEAST_SINES = 1e-6
"""Product of the sines of incidence and exit below which R0 does not depend on the azimuth."""
LEAST_INCIDENCE = 0.02
"""Cosine of incidence below which pi R0 goes to 1: only the rim of a wide lamp lights the place."""


def reflection_images(name: str, table: np.ndarray) -> list[bpy.types.Image]:
    """The coefficients of a reflection function, exits upwards.

    `table` is (mu + mu0) R0 at equal steps of the roots of the cosines of exit and of incidence, and, fastest, of the
    sine of half the azimuth.
    """
    coefficients = _coefficients(table)
    starts = range(0, coefficients.shape[-1], 3)
    return [_image(f"{name} {start // 3}", coefficients[..., start : start + 3]) for start in starts]


def reflection_group(name: str, images: list[bpy.types.Image], *, is_filtered: bool) -> bpy.types.NodeTree:
    """A group of nodes from the vector to a light to pi R0 there, 1 for a white diffuse surface.

    Either the renderer filters the images, or nodes interpolate between their texels, which takes longer.
    """
    group = bpy.data.node_groups.new(name, "ShaderNodeTree")
    group[OWN] = True
    group.interface.new_socket(TO_LIGHT, in_out="INPUT", socket_type="NodeSocketVector")
    group.interface.new_socket(FACTOR, in_out="OUTPUT", socket_type="NodeSocketFloat")
    tree = Tree(group)
    given, geometry = tree.add("NodeGroupInput", 0, 0), tree.add("ShaderNodeNewGeometry", 0, 1)
    normal, eye = geometry.outputs["Normal"], geometry.outputs["Incoming"]
    light = tree.vector("NORMALIZE", 1, 0, given.outputs[TO_LIGHT])
    # Interpolated normals may point away.
    incidence = tree.math("MAXIMUM", 3, 0, tree.vector("DOT_PRODUCT", 2, 0, normal, light), 0.0)
    exit = tree.math("MAXIMUM", 3, 1, tree.vector("DOT_PRODUCT", 2, 1, normal, eye), 0.0)

    # The cosine of the azimuth between both directions of propagation, -1 for light that returns.
    squares = [tree.math("MULTIPLY", 4, row, cosine, cosine) for row, cosine in ((0, incidence), (1, exit))]
    squares = [tree.math("SUBTRACT", 5, row, 1.0, square) for row, square in enumerate(squares)]
    sines = tree.math("MAXIMUM", 7, 0, tree.math("MULTIPLY", 6, 0, *squares), LEAST_SINES**2)
    cosines = tree.math("MULTIPLY", 4, 2, incidence, exit)
    across = tree.math("SUBTRACT", 5, 2, cosines, tree.vector("DOT_PRODUCT", 2, 2, eye, light))
    azimuth = tree.math("DIVIDE", 9, 1, across, tree.math("SQRT", 8, 0, sines))
    azimuth = tree.math("MINIMUM", 11, 1, tree.math("MAXIMUM", 10, 1, azimuth, -1.0), 1.0)

    roots = [tree.math("SQRT", 4, row, cosine) for row, cosine in ((3, incidence), (4, exit))]
    read = _filtered if is_filtered else _interpolated
    terms: list[bpy.types.NodeSocket] = []
    for row, value in enumerate(read(tree, roots, images), start=3):
        split = tree.add("ShaderNodeSeparateXYZ", 16, row)
        tree.link(value, split.inputs[0])
        terms += split.outputs
    *rest, value = terms
    for number, term in enumerate(reversed(rest)):
        value = tree.math("MULTIPLY_ADD", 17 + number, 2, value, azimuth, term)
    cosines = tree.math("MAXIMUM", 5, 5, tree.math("ADD", 4, 5, incidence, exit), LEAST_COSINES)
    value = tree.math("EXPONENT", 18 + len(rest), 2, value)
    excess = tree.math("SUBTRACT", 20 + len(rest), 2, tree.math("DIVIDE", 19 + len(rest), 2, value, cosines), 1.0)
    is_lit = tree.math("DIVIDE", 20 + len(rest), 3, incidence, LEAST_INCIDENCE, use_clamp=True)
    output = tree.add("NodeGroupOutput", 22 + len(rest), 2)
    tree.link(tree.math("MULTIPLY_ADD", 21 + len(rest), 2, excess, is_lit, 1.0), output.inputs[FACTOR])
    return group


def remove_groups(groups: set[bpy.types.NodeTree]) -> None:
    """Removes groups that nothing uses, with their images."""
    images = {node.image for group in groups for node in group.nodes if node.type == "TEX_IMAGE" and node.image}
    for group in groups:
        if not group.users:
            bpy.data.node_groups.remove(group)
    for image in images:
        if not image.users:
            bpy.data.images.remove(image)


def _coefficients(table: np.ndarray) -> np.ndarray:
    """Those of ln pi (mu + mu0) R0 by ascending powers of the cosine of the azimuth, (exit, incidence, powers)."""
    points = round(table.size ** (1 / 3))
    cosines = 1 - 2 * np.linspace(0.0, 1.0, points) ** 2
    values = np.log(np.maximum(math.pi * table.reshape(-1, points).astype(float), LEAST_VALUE))
    powers = np.polynomial.polynomial.polyfit(cosines, values.T, DEGREE)
    return powers.T.reshape(points, points, DEGREE + 1)


def _filtered(
    tree: Tree, roots: list[bpy.types.NodeSocket], images: list[bpy.types.Image]
) -> list[bpy.types.NodeSocket]:
    """The values of images at a place, as numbers from 0 to 1 along both of their sides."""
    at = tree.add("ShaderNodeCombineXYZ", 6, 3)
    for row, (root, points, socket) in enumerate(zip(roots, images[0].size, ("X", "Y")), start=3):
        # The ends of the range are the middles of the first and the last texel.
        tree.link(tree.math("MULTIPLY_ADD", 5, row, root, 1 - 1 / points, 0.5 / points), at.inputs[socket])
    return [_texel(tree, 7, row, image, at.outputs[0], "Linear") for row, image in enumerate(images, start=3)]


def _interpolated(
    tree: Tree, roots: list[bpy.types.NodeSocket], images: list[bpy.types.Image]
) -> list[bpy.types.NodeSocket]:
    """The same, by the four texels around the place."""
    ends: list[list[bpy.types.NodeSocket]] = []
    beyond: list[bpy.types.NodeSocket] = []
    for row, (root, points) in enumerate(zip(roots, images[0].size), start=3):
        place = tree.math("MULTIPLY", 5, row, root, points - 1.0)
        cell = tree.math("MINIMUM", 7, row, tree.math("FLOOR", 6, row, place), points - 2.0)
        beyond.append(tree.math("SUBTRACT", 8, row, place, cell))
        middles = [tree.math("ADD", 8, row + 0.2 * end, cell, end + 0.5) for end in (0, 1)]
        ends.append([tree.math("DIVIDE", 9, row + 0.2 * end, at, float(points)) for end, at in enumerate(middles)])
    corners = []
    for number, (above, right) in enumerate(product((0, 1), repeat=2)):
        corner = tree.add("ShaderNodeCombineXYZ", 10, 3 + number)
        tree.link(ends[0][right], corner.inputs["X"])
        tree.link(ends[1][above], corner.inputs["Y"])
        corners.append(corner.outputs[0])
    results = []
    for number, image in enumerate(images):
        row = 3 + 4 * number
        texels = [_texel(tree, 11, row + place, image, corner, "Closest") for place, corner in enumerate(corners)]
        sides = [_mixed(tree, 12, row + end, *texels[2 * end : 2 * end + 2], beyond[0]) for end in (0, 1)]
        results.append(_mixed(tree, 14, row, *sides, beyond[1]))
    return results


def _texel(
    tree: Tree, column: float, row: float, image: bpy.types.Image, at: bpy.types.NodeSocket, interpolation: str
) -> bpy.types.NodeSocket:
    node = tree.add("ShaderNodeTexImage", column, row, image=image, extension="EXTEND", interpolation=interpolation)
    tree.link(at, node.inputs["Vector"])
    return node.outputs["Color"]


def _mixed(
    tree: Tree,
    column: float,
    row: float,
    one: bpy.types.NodeSocket,
    other: bpy.types.NodeSocket,
    share: bpy.types.NodeSocket,
) -> bpy.types.NodeSocket:
    """A vector between two."""
    return tree.vector("MULTIPLY_ADD", column + 1, row, tree.vector("SUBTRACT", column, row, other, one), share, one)


def _image(name: str, colors: np.ndarray) -> bpy.types.Image:
    """An image of numbers, the first row below."""
    rows, columns, _ = colors.shape
    image = bpy.data.images.new(name, columns, rows, alpha=False, float_buffer=True, is_data=True)
    image.use_half_precision = False
    pixels = np.ones((rows, columns, 4), dtype=np.float32)
    pixels[..., :3] = colors
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image
