"""Whether meshes are closed, and what closes them."""

from __future__ import annotations

from collections.abc import Callable

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from snowblue.blender._meshes import world_mesh

FLAT = 1e-6
"""The least volume of a solid, in parts of the cube of its size."""
VOXELS = 96
"""Voxels of a remeshed object along its greatest length."""
REMESH = "Snow Remesh"
"""The name of the modifier."""


def open_edges(vertices: np.ndarray, triangles: np.ndarray) -> int:
    """The number of edges of an odd number of triangles, after vertices in one place are merged as the solver does."""
    # Adding zero makes zeros of both signs one value.
    places = np.ascontiguousarray(vertices, dtype=np.float32) + np.float32(0)
    _, merged = np.unique(places.view("V12").ravel(), return_inverse=True)
    corners = merged.ravel()[triangles].astype(np.int64)
    first, second = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    edges = (np.minimum(first, second) * len(vertices) + np.maximum(first, second))[first != second]
    _, counts = np.unique(edges, return_counts=True)
    return int((counts % 2).sum())


def extent(vertices: np.ndarray) -> float:
    """The greatest length along an axis."""
    return float(np.ptp(vertices, axis=0).max())


def local_mesh(thing: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of an object with its modifiers, in its own space."""
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return world_mesh(shown, Matrix(), 1.0)[:2]


def fill_holes(thing: bpy.types.Object) -> Callable[[], None]:
    """Fills the holes of a mesh by new faces, and gives what takes that back. The normals of faces are recalculated.
    All else of the mesh stays: UV maps, materials and vertex groups.

    Raises
    ------
    ValueError
        If the mesh is shared, or its holes are not those that are seen, or it is a sheet, of which filling makes no
        solid, or it is not closed then. The mesh is unchanged.
    """
    if thing.data.users - thing.data.use_fake_user > 1:
        raise ValueError(f"the mesh of '{thing.name}' has other users: make it single-user, or choose Voxel Remesh")
    vertices, triangles = local_mesh(thing)
    if len(vertices) != len(thing.data.vertices):
        raise ValueError(
            f"'{thing.name}' has modifiers that change its number of vertices: apply them, or choose Voxel Remesh"
        )
    before, mesh = bmesh.new(), bmesh.new()
    before.from_mesh(thing.data)
    mesh.from_mesh(thing.data)
    seen = open_edges(vertices, triangles)

    def restore() -> None:
        before.to_mesh(thing.data)

    try:
        if _odd_edges(mesh) != seen:
            raise ValueError(
                f"'{thing.name}' has edges that touch but are not joined: use Merge by Distance, or choose Voxel Remesh"
            )
        bmesh.ops.holes_fill(mesh, edges=[edge for edge in mesh.edges if edge.is_boundary], sides=0)
        bmesh.ops.recalc_face_normals(mesh, faces=mesh.faces)
        if mesh.calc_volume() <= FLAT * extent(np.array([vertex.co for vertex in mesh.verts])) ** 3:
            raise ValueError(f"'{thing.name}' is a sheet without thickness: add a Solidify modifier")
        left = _odd_edges(mesh)
        if left:
            raise ValueError(f"'{thing.name}' has {left} open edges that are no holes: choose Voxel Remesh")
        mesh.to_mesh(thing.data)
        left = open_edges(*local_mesh(thing))
        if left:
            raise ValueError(f"'{thing.name}' has {left} open edges by its modifiers: choose Voxel Remesh")
    except ValueError:
        restore()
        raise
    finally:
        mesh.free()
    return restore


def _odd_edges(mesh: bmesh.types.BMesh) -> int:
    return sum(len(edge.link_faces) % 2 for edge in mesh.edges)


def remesh(thing: bpy.types.Object) -> Callable[[], None]:
    """Adds a modifier that makes a closed surface of a mesh, and gives what takes it back.

    Raises
    ------
    ValueError
        If the modifier makes no solid. It does not stay.
    """
    voxel_size = extent(local_mesh(thing)[0]) / VOXELS
    modifier = thing.modifiers.new(REMESH, "REMESH")
    modifier.mode = "VOXEL"
    modifier.voxel_size = voxel_size
    vertices, triangles = local_mesh(thing)
    # Where a hole is wide, the modifier makes a thin shell around the faces. The mean thickness of a shell is twice its
    # volume over its area.
    first, second, third = vertices[triangles].transpose(1, 0, 2)
    volume = np.einsum("tk,tk->", first, np.cross(second, third)) / 6
    area = np.linalg.norm(np.cross(second - first, third - first), axis=1).sum() / 2
    if open_edges(vertices, triangles) or 2 * volume <= modifier.voxel_size * area:
        thing.modifiers.remove(modifier)
        raise ValueError(
            f"Voxel Remesh makes no solid of '{thing.name}': choose Fill Holes, or add a Solidify modifier to a sheet"
        )
    return lambda: thing.modifiers.remove(modifier)
