"""Nodes of materials and of geometry, made in columns from left to right."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

COLUMN = 220


class Tree:
    """Nodes in columns from left to right."""

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree

    def add(self, kind: str, column: float, row: float = 0.0, label: str = "", **settings: object) -> bpy.types.Node:
        node = self.tree.nodes.new(kind)
        node.location = (COLUMN * column, -COLUMN * row)
        node.label = label
        for name, value in settings.items():
            setattr(node, name, value)
        return node

    def link(self, source: bpy.types.NodeSocket, target: bpy.types.NodeSocket) -> None:
        self.tree.links.new(source, target)

    def math(
        self,
        operation: str,
        column: float,
        row: float,
        *values: bpy.types.NodeSocket | float,
        use_clamp: bool = False,
    ) -> bpy.types.NodeSocket:
        """A number of some numbers, limited to 0–1 by `use_clamp`."""
        return self._join(self.add("ShaderNodeMath", column, row, operation=operation, use_clamp=use_clamp), values)

    def vector(
        self, operation: str, column: float, row: float, *values: bpy.types.NodeSocket | float, label: str = ""
    ) -> bpy.types.NodeSocket:
        """A vector of some vectors and a scale, or the number that a product of two is."""
        return self._join(self.add("ShaderNodeVectorMath", column, row, label, operation=operation), values)

    def _join(
        self, node: bpy.types.Node, values: Sequence[bpy.types.NodeSocket | float | Sequence[float]]
    ) -> bpy.types.NodeSocket:
        # Operations use some of the sockets that a node has.
        for value, socket in zip(values, [one for one in node.inputs if one.enabled]):
            if isinstance(value, bpy.types.NodeSocket):
                self.link(value, socket)
            else:
                socket.default_value = value
        return next(one for one in node.outputs if one.enabled)
