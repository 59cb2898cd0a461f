#!/usr/bin/env python3
"""Compares thickness through meshes with Embree: the same hits, numbers of crossings and mean thickness.

    python3 scripts/check_embree.py XTASK [MESH.ply ...]

XTASK is the program target/debug/xtask, whose task thickness-map traces grids of lines in three directions and prints
them with all digits. Embree traces the same lines through the same triangles. A generated mesh is checked first: a
wavy, hollow torus with thin parts.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

LINES = 250
# Embree restarts behind each crossing, by this fraction of the mesh's size. Two crossings closer than that, at thin or
# grazing spots, count as one.
STEP = 2e-6
# Largest fraction of lines that may differ: those that graze an outline, or have two crossings within a step.
MAX_DIFFERENT = 1e-4
# Tolerance for distances, as a fraction of the mesh's size: rounding in single precision on a surface hit as obliquely
# as by one line in ten thousand.
TOLERANCE = 1e-5


def export_torus(path):
    """Exports a wavy torus that contains a smaller one with inverted faces. The file shares all common vertices."""
    turns, around = 480, 240
    u, v = np.meshgrid(np.arange(turns) * 2 * np.pi / turns, np.arange(around) * 2 * np.pi / around, indexing="ij")
    corner = (np.arange(turns)[:, None] * around + np.arange(around)).astype(int)
    right, up = np.roll(corner, -1, 0), np.roll(corner, -1, 1)
    both = np.roll(right, -1, 1)
    faces = np.concatenate([np.stack([corner, right, both], -1), np.stack([corner, both, up], -1)]).reshape(-1, 3)
    vertices = []
    for radius in (0.3 + 0.06 * np.sin(7 * u) * np.cos(5 * v), 0.12 + 0.05 * np.cos(9 * u + 2 * v)):
        ring = 1 + radius * np.cos(v)
        vertices.append(np.stack([ring * np.cos(u), ring * np.sin(u), radius * np.sin(v)], -1).reshape(-1, 3))
    faces = np.concatenate([faces, len(vertices[0]) + faces[:, ::-1]])
    trimesh.Trimesh(np.concatenate(vertices), faces, process=False).export(path)


def embree_lines(triangles, origins, directions, size):
    """First hit, number of crossings and length inside of each line, from successive closest hits."""
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, triangles)
    count = len(origins)
    first, crossings, thickness = np.full(count, np.inf), np.zeros(count, int), np.zeros(count)
    start, entered = np.zeros(count), np.zeros(count)
    active = np.arange(count)
    while len(active):
        at = (origins[active] + directions[active] * start[active, None]).astype(np.float32)
        answer = scene.run(at, directions[active].astype(np.float32), query="INTERSECT", output=True)
        met = answer["primID"] >= 0
        active = active[met]
        distance = start[active] + answer["tfar"][met]
        fresh = crossings[active] == 0
        first[active[fresh]] = distance[fresh]
        leaves = crossings[active] % 2 == 1
        thickness[active[leaves]] += distance[leaves] - entered[active[leaves]]
        entered[active] = distance
        crossings[active] += 1
        start[active] = distance + STEP * size
    return first, crossings, thickness


def compare(xtask, mesh):
    """Prints the results of both, and fails if they differ."""
    done = subprocess.run([xtask, "thickness-map", mesh, str(LINES)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    ours = np.array([[float(field) for field in row.split(",")] for row in done.stdout.splitlines()[1:]])
    hit, crossings, thickness = ours[:, 6], ours[:, 7].astype(int), ours[:, 8]
    triangles = np.asarray(trimesh.load(mesh, process=False).triangles, dtype=np.float32)
    size = float(np.linalg.norm(np.ptp(triangles.reshape(-1, 3), axis=0)))
    first, theirs, length = embree_lines(triangles, ours[:, :3], ours[:, 3:6], size)
    met, met_there = np.isfinite(hit), np.isfinite(first)
    both = met & met_there
    same = both & (crossings == theirs)
    off = np.abs(hit[both] - first[both]) / size
    # If Embree missed a crossing, its length is different.
    means = thickness[same].mean(), length[same].mean()
    print(f"{Path(mesh).name}: {len(triangles)} triangles, {len(ours)} lines")
    print(f"  hits: {met.sum()} here, {met_there.sum()} by Embree, {(met != met_there).sum()} lines differ")
    print(f"  first hit: median difference {np.median(off):.1e} of the size, "
          f"{(off > TOLERANCE).sum()} lines above {TOLERANCE:g}")
    print(f"  crossings: {crossings.sum()} here, {theirs.sum()} by Embree, {(both & ~same).sum()} lines differ; "
          f"odd: {(crossings % 2).sum()} here, {(theirs % 2).sum()} by Embree")
    print(f"  mean thickness of the other lines: {means[0]:.7g} here, {means[1]:.7g} by Embree, "
          f"difference {abs(means[0] / means[1] - 1):.1e}")
    thickness_off = np.abs(thickness[same] - length[same]) / size
    for different in (met != met_there, off > TOLERANCE, both & ~same, thickness_off > TOLERANCE):
        assert different.mean() < MAX_DIFFERENT
    assert abs(means[0] / means[1] - 1) < TOLERANCE
    return (crossings % 2).sum()


def main():
    xtask, *meshes = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        torus = Path(folder) / "torus.ply"
        export_torus(torus)
        assert compare(xtask, torus) == 0, "a line crosses a closed mesh an even number of times"
    for mesh in meshes:
        compare(xtask, mesh)


if __name__ == "__main__":
    main()
