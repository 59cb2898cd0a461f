"""UV maps and vertex groups of a mesh, carried over to the baked one, which divides its triangles."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from snowblue.blender._closing import extent

NEAR = 1e-5
"""Faces whose distances differ by less, in parts of the size of the mesh, are in one place."""


@dataclass
class Layers:
    """What a mesh holds beside its shape, on its triangles."""

    vertices: np.ndarray
    """In the space of the object, (n, 3)."""
    triangles: np.ndarray
    """Those with an area, (m, 3)."""
    uv_maps: dict[str, np.ndarray]
    """At the corners of each triangle, (m, 3, 2)."""
    groups: dict[str, np.ndarray]
    """Weights at the vertices, (n)."""


def layers_of(evaluated: bpy.types.Object) -> Layers | None:
    """The layers of an object with its modifiers; none if it has no UV map and no vertex group."""
    mesh = evaluated.to_mesh()
    try:
        if not (mesh.uv_layers or evaluated.vertex_groups):
            return None
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        vertices = np.empty(3 * len(mesh.vertices))
        triangles, loops = np.empty(3 * count, int), np.empty(3 * count, int)
        mesh.vertices.foreach_get("co", vertices)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        mesh.loop_triangles.foreach_get("loops", loops)
        vertices, triangles, loops = vertices.reshape(-1, 3), triangles.reshape(-1, 3), loops.reshape(-1, 3)
        has_area = np.any(_cross(vertices[triangles]), axis=1)
        triangles, loops = triangles[has_area], loops[has_area]
        uv_maps = {}
        for layer in mesh.uv_layers:
            values = np.empty(2 * len(mesh.loops))
            layer.uv.foreach_get("vector", values)
            uv_maps[layer.name] = values.reshape(-1, 2)[loops]
        groups = {group.name: np.zeros(len(mesh.vertices)) for group in evaluated.vertex_groups}
        names = list(groups)
        for vertex in mesh.vertices:
            for element in vertex.groups:
                groups[names[element.group]][vertex.index] = element.weight
        return Layers(vertices, triangles, uv_maps, groups)
    finally:
        evaluated.to_mesh_clear()


def put_layers(layers: Layers, thing: bpy.types.Object) -> None:
    """Gives a baked object the layers. Each of its triangles lies in one of the original, or in two that
    make a rectangle."""
    mesh = thing.data
    places, corners = np.empty(3 * len(mesh.vertices)), np.empty(len(mesh.loops), int)
    mesh.vertices.foreach_get("co", places)
    mesh.loops.foreach_get("vertex_index", corners)
    places, corners = places.reshape(-1, 3), corners.reshape(-1, 3)
    tree = BVHTree.FromPolygons(layers.vertices.tolist(), layers.triangles.tolist(), all_triangles=True)
    middles, normals = places[corners].mean(axis=1), _cross(places[corners])
    reach = NEAR * extent(layers.vertices)
    pairs = zip(middles.tolist(), normals.tolist())
    owners = np.array([_owner(tree, middle, Vector(normal), reach) for middle, normal in pairs])
    shares = _barycentric(layers.vertices[layers.triangles[owners]], places[corners])
    for name, values in layers.uv_maps.items():
        layer = mesh.uv_layers.new(name=name, do_init=False)
        layer.uv.foreach_set("vector", np.einsum("tcs,tsk->tck", shares, values[owners]).astype(np.float32).ravel())
    thing.vertex_groups.clear()
    for name, weights in layers.groups.items():
        group = thing.vertex_groups.new(name=name)
        at_corners = np.einsum("tcs,ts->tc", shares, weights[layers.triangles[owners]])
        values = np.zeros(len(places))
        values[corners.ravel()] = np.clip(at_corners.ravel(), 0.0, 1.0)
        for index in np.flatnonzero(values).tolist():
            group.add([index], values[index], "REPLACE")


def _owner(tree: BVHTree, middle: list[float], normal: Vector, reach: float) -> int:
    """The triangle nearest to a point. Of faces in one place, it is one with the normal."""
    hits = tree.find_nearest_range(middle, tree.find_nearest(middle)[3] + reach)
    return min(hits, key=lambda hit: (hit[1].dot(normal) < 0, hit[3]))[2]


def _cross(triangles: np.ndarray) -> np.ndarray:
    """Normals of triangles (m, 3, 3), of twice the length of their areas."""
    return np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])


def _barycentric(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The shares of the corners of triangles (m, 3, 3) in points of them (m, p, 3), as (m, p, 3)."""
    normals = _cross(triangles)
    normals /= np.einsum("tk,tk->t", normals, normals)[:, None]
    offset = points - triangles[:, None, 0]
    first, second = (triangles[:, None, corner] - triangles[:, None, 0] for corner in (1, 2))
    u, v = (np.einsum("tpk,tk->tp", sides, normals) for sides in (np.cross(offset, second), np.cross(first, offset)))
    # Points may lie in the other triangle of a rectangle. Rounding puts them far outside narrow triangles.
    shares = np.clip(np.stack([1 - u - v, u, v], axis=-1), -1.0, 2.0)
    return shares / shares.sum(axis=-1, keepdims=True)
