#!/usr/bin/env python3
"""Compares baked snow in Godot 4 with its file, read by trimesh: the colours of pixels.

    python3 scripts/check_godot.py SNOWBLUE GODOT

SNOWBLUE is the program target/debug/snowblue, and GODOT that of Godot 4. It runs without a graphics card, in a virtual
display (xvfb-run) where there is no other. A block is baked with a lightmap and with colours at its vertices, and shown
by the project in examples/godot.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
PROJECT = ROOT / "examples/godot"
SCENE = ROOT / "scenes/block_30cm.toml"
# The camera of examples/godot, and the size of its window.
EYE, TARGET, FOV_DEG, SIZE = np.array([1.2, 0.7, 1.6]), np.array([0, 0.27, 0]), 30, 480
# A pixel is compared where its file is nearly the same one pixel around, in sRGB codes.
STEADY = 3
# Godot's renderer for OpenGL approximates the transfer function of sRGB: from this code on within 0.3 codes, below it
# by up to 6.4 codes.
LEAST_CODE = 64
# Half a code of rounding, 0.3 of the approximation, and the rest for texture coordinates that graphics cards round.
MOST_DIFFERENCE = 1.5
# Beside that, light is linear between vertices that are 5 mm apart, and between texels, 5 mm too, in another way.
MOST_DIFFERENCE_OF_VERTICES = 4
# What is baked, and Godot's renderer. That for OpenGL takes vertex colours for encoded ones and shows them too dark.
CASES = [
    ("lightmap", "gl_compatibility", MOST_DIFFERENCE),
    ("lightmap", "forward_plus", MOST_DIFFERENCE),
    ("vertices", "forward_plus", MOST_DIFFERENCE_OF_VERTICES),
]


def rays():
    """Directions through the middles of all pixels, row by row."""
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    place = (2 * (np.arange(SIZE) + 0.5) / SIZE - 1) * np.tan(np.radians(FOV_DEG) / 2)
    return forward + place[None, :, None] * right - place[:, None, None] * up


def expected(path):
    """The codes that the file has at each pixel; NaN where there is no snow."""
    mesh = trimesh.load(path, force="mesh", process=False)
    directions = rays().reshape(-1, 3)
    hits, lines, triangles = mesh.ray.intersects_location(
        np.broadcast_to(EYE, directions.shape), directions, multiple_hits=False
    )
    weights = trimesh.triangles.points_to_barycentric(mesh.triangles[triangles], hits)[..., None]
    codes = np.full((SIZE * SIZE, 3), np.nan)
    texture = np.asarray(mesh.visual.material.baseColorTexture.convert("RGB"), dtype=float)
    rows, columns = texture.shape[:2]
    u, v = (mesh.visual.uv[mesh.faces[triangles]] * weights).sum(axis=1).T
    # trimesh counts v from the last row.
    x, y = u * columns - 0.5, (1 - v) * rows - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    codes[lines] = sum(
        texture[np.clip(top + j, 0, rows - 1), np.clip(left + i, 0, columns - 1)]
        * (np.where(i, x - left, 1 - x + left) * np.where(j, y - top, 1 - y + top))[:, None]
        for i in (0, 1)
        for j in (0, 1)
    )
    return codes.reshape(SIZE, SIZE, 3)


def shown(godot, path, picture, renderer):
    """The picture that Godot renders of a file."""
    display = [] if "DISPLAY" in os.environ else ["xvfb-run", "-a"]
    driver = "vulkan" if renderer == "forward_plus" else "opengl3"
    options = ["--rendering-method", renderer, "--rendering-driver", driver, "--audio-driver", "Dummy"]
    command = [*display, godot, "--path", PROJECT, *options, "--", path, picture]
    run = subprocess.run(command, check=True, capture_output=True, text=True, timeout=300)
    if renderer == "forward_plus" and "Vulkan" not in run.stdout:
        sys.exit("check_godot: Godot finds no driver of Vulkan")
    return np.asarray(Image.open(picture).convert("RGB"), dtype=float)


def steady(codes):
    """Where all pixels around show nearly the same."""
    around = [np.roll(codes, (i, j), axis=(0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return (np.max(around, axis=0) - np.min(around, axis=0)).max(axis=-1) <= STEADY


def main(snowblue, godot):
    with tempfile.TemporaryDirectory() as folder:
        paths = {name: os.path.join(folder, f"{name}.glb") for name in ("lightmap", "vertices")}
        for name, options in (("lightmap", ["--lightmap", "256"]), ("vertices", ["--step-mm", "5"])):
            subprocess.run([snowblue, "--quiet", "bake", SCENE, *options, "-o", paths[name]], check=True)
        codes = expected(paths["lightmap"])
        chosen = steady(codes)[..., None] & (codes >= LEAST_CODE)
        if chosen.sum() < 10_000 or np.ptp(codes[chosen]) < 100:
            sys.exit("check_godot: the file has too few colours")
        for name, renderer, most in CASES:
            picture = shown(godot, paths[name], os.path.join(folder, "picture.png"), renderer)
            difference = np.abs(picture - codes)[chosen].max()
            print(f"{name}, {renderer}: {chosen.sum()} values differ by at most {difference:.1f} codes of 255")
            if difference > most:
                sys.exit(f"check_godot: {name}, {renderer}: Godot shows other colours than the file has")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__.strip())
    main(*sys.argv[1:])
