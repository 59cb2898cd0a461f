"""Whether meshes are closed, and what closes them."""

from __future__ import annotations

from collections.abc import Callable

import bmesh
import bpy

FLAT = 1e-6
"""The least volume of a solid, in parts of the cube of its size."""
VOXELS = 96
"""Voxels of a remeshed object along its greatest length."""
REMESH = "Snow Remesh"
"""The name of the modifier."""


def open_edges(thing: bpy.types.Object) -> int:
    """The number of edges at holes of an object, with its modifiers: edges that do not have faces on both sides."""
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = bmesh.new()
    try:
        mesh.from_mesh(shown.to_mesh())
        return sum(len(edge.link_faces) % 2 for edge in mesh.edges)
    finally:
        mesh.free()
        shown.to_mesh_clear()


def fill_holes(thing: bpy.types.Object) -> Callable[[], None]:
    """Fills the holes of a mesh by new faces, and gives what takes that back. All else of the mesh stays: UV maps,
    materials and vertex groups.

    Raises
    ------
    ValueError
        If the mesh is a sheet, of which filling makes no solid, or if it is not closed then. The mesh is unchanged.
    """
    before, mesh = bmesh.new(), bmesh.new()
    before.from_mesh(thing.data)
    mesh.from_mesh(thing.data)

    def restore() -> None:
        before.to_mesh(thing.data)

    try:
        bmesh.ops.holes_fill(mesh, edges=[edge for edge in mesh.edges if edge.is_boundary], sides=0)
        bmesh.ops.recalc_face_normals(mesh, faces=mesh.faces)
        size = max(thing.dimensions) / max(map(abs, thing.scale)) if any(thing.scale) else 0.0
        if abs(mesh.calc_volume()) <= FLAT * size**3:
            raise ValueError(f"'{thing.name}' is a sheet without thickness: add a Solidify modifier")
        left = sum(len(edge.link_faces) % 2 for edge in mesh.edges)
        if left:
            raise ValueError(f"'{thing.name}' has {left} open edges that are no holes: choose Voxel Remesh")
        mesh.to_mesh(thing.data)
        left = open_edges(thing)
        if left:
            raise ValueError(f"'{thing.name}' has {left} open edges by its modifiers: choose Voxel Remesh")
    except ValueError:
        restore()
        raise
    finally:
        mesh.free()
    return restore


def remesh(thing: bpy.types.Object) -> Callable[[], None]:
    """Adds a modifier that makes a closed surface of any mesh, and gives what takes it back."""
    modifier = thing.modifiers.new(REMESH, "REMESH")
    modifier.mode = "VOXEL"
    # The voxels are those of the mesh, before the scale of the object.
    corners = [list(corner) for corner in thing.bound_box]
    modifier.voxel_size = max(max(axis) - min(axis) for axis in zip(*corners)) / VOXELS
    return lambda: thing.modifiers.remove(modifier)
