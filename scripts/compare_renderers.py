#!/usr/bin/env python3
"""Compares pictures of a block and a torus of snow by every renderer with those by `hybrid`.

    target/bpy/bin/python scripts/compare_renderers.py SNOWBLUE MITSUBA_PYTHON [GODOT]

It runs in a Python with Blender, OpenEXR and the package `snowblue`. SNOWBLUE is the program, MITSUBA_PYTHON a
Python with Mitsuba and the package, and GODOT the program of Godot 4, without which it is left out. three.js is shown
in Chromium by web/compare.mjs, with the packages of web/. `scripts/test all` makes all but Godot.

It prints a table: the mean of red, green and blue over that of `hybrid`; the root mean square of ln(luminance ratio)
over parts of 6 × 6 pixels of a picture of 48 × 48, all of which show snow; the seconds that a renderer takes, its
solution or bake included; and the number of these parts.
"""

import json
import math
import os
import runpy
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
from mathutils import Vector

import snowblue.blender

ROOT = Path(__file__).resolve().parent.parent
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
SIZE, PART = 48, 6
# The place of the camera of examples/godot, whose pictures of 480 × 480 pixels have a field of view of 30°. Others see
# the middle of that, at a third of its resolution.
EYE, TARGET, GODOT_SIZE, GODOT_FOV_DEG, GODOT_PIXELS = [1.2, -1.6, 0.7], [0, 0, 0.27], 480, 30, 3
FOV_DEG = 2 * math.degrees(math.atan(math.tan(math.radians(GODOT_FOV_DEG / 2)) * SIZE * GODOT_PIXELS / GODOT_SIZE))
VIEW = {"position": EYE, "look_at": TARGET, "vertical_fov_deg": FOV_DEG}
SNOW = {"type": "snow", "grain_size_um": 400, "facetness": 0.3, "density_kg_m3": 300}
LAMPS = {"behind": [0.0, 0.6, 0.27], "in front": [0.3, -0.8, 0.57]}
BOX = [0.2, 0.1, 0.2]
# Samples of each pixel, so that the noise is below the differences.
SAMPLES = {"hybrid": 512, "diffusion": 64, "Mitsuba": 256, "bake": 64, "preset": 512}
# Along each side of a pixel of three.js, which takes one.
THREE_SAMPLES = 8
# Codes of 255 below which Godot's picture has steps of some per cent.
LEAST_CODE = 32

MITSUBA = """
import json, sys, time
import mitsuba as mi
import numpy as np
mi.set_variant("llvm_ad_rgb")
import snowblue.mitsuba
start, given = time.perf_counter(), json.load(sys.stdin)
shape = snowblue.mitsuba.snow_mesh(np.load(given["vertices"]), np.load(given["triangles"]))
view = given["view"]
made = mi.load_dict({
    "type": "scene", "integrator": {"type": "snow", "max_depth": 2, "gather_depth": 0}, "snow": shape,
    "sensor": {"type": "perspective", "fov": view["vertical_fov_deg"],
               "to_world": mi.ScalarTransform4f().look_at(view["position"], view["look_at"], [0, 0, 1]),
               "film": {"type": "hdrfilm", "width": given["size"], "height": given["size"],
                        "rfilter": {"type": "box"}}},
    "lamp": {"type": "point", "position": given["lamp"], "intensity": {"type": "d65", "scale": 1.0}}})
picture = np.array(mi.render(made, spp=given["samples"]))[..., :3]
print(time.perf_counter() - start)
np.save(given["output"], picture)
"""


def torus(sides=96, around=48):
    """Vertices and triangles of a torus that stands upright, 20 cm wide and 9 cm thick."""
    u, v = np.meshgrid(*(2 * np.pi * np.arange(count) / count for count in (sides, around)), indexing="ij")
    radius = 0.055 + 0.045 * np.cos(v)
    vertices = np.stack([radius * np.cos(u), 0.045 * np.sin(v), radius * np.sin(u)], axis=-1).reshape(-1, 3) + TARGET
    number = np.arange(sides * around).reshape(sides, around)
    right, up = np.roll(number, -1, axis=0), np.roll(number, -1, axis=1)
    quads = np.stack([number, up, np.roll(right, -1, axis=1), right], axis=-1).reshape(-1, 4)
    return vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def box():
    """Vertices and triangles of the block."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * BOX + TARGET
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return corners, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


class Comparison:
    """A body of snow and a lamp, in all renderers."""

    def __init__(self, programs, folder, mesh, lamp):
        self.snowblue, self.mitsuba_python, self.godot = programs
        self.folder, self.lamp = folder, lamp
        self.vertices, self.triangles = mesh
        lines = ["v " + " ".join(f"{x:.9g}" for x in vertex) for vertex in self.vertices]
        lines += ["f " + " ".join(map(str, triangle)) for triangle in self.triangles + 1]
        (folder / "mesh.obj").write_text("\n".join(lines) + "\n")
        light = {"type": "point", "position": lamp, "illuminant": "D65", "radiant_intensity_w_sr": 1.0}
        self.write("snow.toml", [light], {"mesh": "mesh.obj", "up": "z", "material": "snow"})

    def write(self, name, light, thing, size=SIZE, view=VIEW):
        materials = {"snow": SNOW, "white": {"type": "diffuse", "reflectance": 1.0}}
        made = snowblue.Scene(
            folder=self.folder, camera=view, film={"width": size, "height": size}, integrator={"max_bounces": 0},
            material=materials, light=light, object=[thing])
        (self.folder / name).write_text(made.to_toml())

    def command(self, *words):
        subprocess.run([self.snowblue, "--quiet", *map(str, words)], cwd=self.folder, check=True)

    def rendered(self, name, integrator, samples):
        self.command("render", name, "--integrator", integrator, "--spp", samples, "-o", "picture.exr")
        return OpenEXR.File(str(self.folder / "picture.exr")).channels()["RGB"].pixels

    def white(self):
        """What our pictures show of a white surface under D65 of the irradiance pi."""
        sun = {"type": "directional", "direction": [0, 0, -1], "illuminant": "D65", "irradiance_w_m2": np.pi}
        ground = {"shape": "box", "size": [1, 1, 0.1], "position": [0, 0, -0.05], "material": "white"}
        self.write("white.toml", [sun], ground, 1, {"position": [0, 0, 1], "look_at": [0, 0, 0], "up": [0, 1, 0]})
        return self.rendered("white.toml", "pcasnow", 1)[0, 0]

    def ours(self, integrator):
        return self.rendered("snow.toml", integrator, SAMPLES[integrator])

    def mitsuba(self):
        names = {name: str(self.folder / f"{name}.npy") for name in ("vertices", "triangles", "output")}
        np.save(names["vertices"], self.vertices)
        np.save(names["triangles"], self.triangles)
        given = names | {"view": VIEW, "size": SIZE, "samples": SAMPLES["Mitsuba"], "lamp": self.lamp}
        done = subprocess.run(
            [self.mitsuba_python, "-c", MITSUBA], input=json.dumps(given), capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"compare_renderers: Mitsuba: {done.stderr.strip()}")
        # Without the start of Python.
        return np.load(names["output"]) * self.white(), float(done.stdout.split()[-1])

    def blender(self, has_preset):
        """Cycles, with the bake of the add-on or with the preset."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        snowblue.blender.register()
        start = time.perf_counter()
        scene, data = bpy.context.scene, bpy.data.meshes.new("snow")
        data.from_pydata(self.vertices.tolist(), [], self.triangles.tolist())
        snow = bpy.data.objects.new("snow", data)
        lamp, camera = bpy.data.lights.new("lamp", "POINT"), bpy.data.cameras.new("camera")
        # One watt per steradian.
        lamp.energy, lamp.shadow_soft_size = 4 * math.pi, 0.0
        camera.sensor_fit, camera.angle, camera.clip_start = "VERTICAL", math.radians(FOV_DEG), 0.01
        things = [snow, bpy.data.objects.new("lamp", lamp), bpy.data.objects.new("camera", camera)]
        for thing, place in zip(things, ([0, 0, 0], self.lamp, EYE)):
            scene.collection.objects.link(thing)
            thing.location = place
        scene.camera = things[2]
        scene.camera.rotation_euler = (Vector(TARGET) - Vector(EYE)).to_track_quat("-Z", "Y").to_euler()
        if len(self.triangles) > 12:
            data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
        if has_preset:
            self.command("export", "principled", "-o", "snow.py")
            runpy.run_path(str(self.folder / "snow.py"), run_name="__main__")
            data.materials.append(bpy.data.materials["Snow"])
        else:
            snow.snowblue.is_snow, snow.snowblue.preset = True, "OLD"
            snowblue.blender.bake(max_bounces=0)
            # Light by way of other places of the snow is left out in all pictures.
            scene.cycles.max_bounces = 0
        scene.render.engine, scene.cycles.samples = "CYCLES", SAMPLES["preset" if has_preset else "bake"]
        scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
        scene.cycles.sample_clamp_indirect, scene.cycles.pixel_filter_type = 0, "BOX"
        scene.render.film_transparent = True
        scene.render.resolution_x = scene.render.resolution_y = SIZE
        settings = scene.render.image_settings
        settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
        scene.render.filepath = str(self.folder / "cycles.exr")
        bpy.ops.render.render(write_still=True)
        seconds = time.perf_counter() - start
        snowblue.blender.unregister()
        pixels = OpenEXR.File(scene.render.filepath).channels()["RGBA"].pixels
        return pixels[..., :3] * self.white(), seconds

    def three(self):
        """three.js by the lines of the chapter on real time, whose standard material is lit by its own lamp."""
        start = time.perf_counter()
        self.command("bake", "snow.toml", "-o", "snow.glb")
        size = SIZE * THREE_SAMPLES
        given = {"glb": str(self.folder / "snow.glb"), "size": size, "lamp": self.lamp,
                 "view": [EYE, TARGET, FOV_DEG], "intensity": float(self.white() @ LUMINANCE)}
        done = subprocess.run(
            ["node", ROOT / "web/compare.mjs"], input=json.dumps(given), capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"compare_renderers: three.js: {done.stderr.strip()}")
        samples = np.array(json.loads(done.stdout)).reshape(SIZE, THREE_SAMPLES, SIZE, THREE_SAMPLES, 3)
        return samples.mean(axis=(1, 3)), time.perf_counter() - start

    def preview(self):
        """Godot: the lightmap, an unshaded texture at the exposure of the bake, in 8 bits."""
        start = time.perf_counter()
        self.command("bake", "snow.toml", "--lightmap", "512", "--exposure", "auto", "-o", "snow.glb")
        display = [] if "DISPLAY" in os.environ else ["xvfb-run", "-a"]
        options = ["--rendering-method", "forward_plus", "--rendering-driver", "vulkan", "--audio-driver", "Dummy"]
        files = [self.folder / name for name in ("snow.glb", "godot.png")]
        command = [*display, self.godot, "--path", ROOT / "examples/godot", *options, "--", *files]
        subprocess.run(list(map(str, command)), check=True, capture_output=True, timeout=300)
        seconds = time.perf_counter() - start
        image = bpy.data.images.load(str(files[1]))
        # Codes of 8 bits over 255, the lowest row first.
        codes = np.array(image.pixels).reshape(GODOT_SIZE, GODOT_SIZE, 4)[::-1, :, :3]
        linear = np.where(codes > 0.04045, ((codes + 0.055) / 1.055) ** 2.4, codes / 12.92)
        # Clipped pixels, and those with steps of some per cent, tell nothing.
        linear[(codes.max(axis=-1) >= 1) | (codes[..., 1] < LEAST_CODE / 255)] = np.nan
        half = SIZE * GODOT_PIXELS // 2
        middle = slice(GODOT_SIZE // 2 - half, GODOT_SIZE // 2 + half)
        picture = linear[middle, middle].reshape(SIZE, GODOT_PIXELS, SIZE, GODOT_PIXELS, 3).mean(axis=(1, 3))
        return picture * exitance_of_one(files[0]) / np.pi, seconds


def exitance_of_one(path):
    """The exitance that a lightmap shows as 1."""
    data = path.read_bytes()
    [length] = struct.unpack_from("<I", data, 12)
    [scene] = json.loads(data[20:20 + length])["scenes"]
    return float(scene["extras"]["lightmap_scale_w_m2"])


def inner(picture):
    """The pixels all of whose neighbours show snow."""
    lit = (picture @ LUMINANCE) > 0
    result = lit.copy()
    for axis in (0, 1):
        for shift in (-1, 1):
            result &= np.roll(lit, shift, axis=axis)
    return result


def parts(values):
    return values.reshape(SIZE // PART, PART, SIZE // PART, PART, *values.shape[2:])


def row(name, picture, truth, seconds):
    """A row of the table. Pixels that are not numbers tell nothing."""
    compared = inner(truth) & np.isfinite(picture).all(axis=-1)
    mean = picture[compared].mean(axis=0) / truth[compared].mean(axis=0)
    whole = parts(compared).all(axis=(1, 3))
    ratios = np.divide(*(parts(image @ LUMINANCE).mean(axis=(1, 3))[whole] for image in (picture, truth)))
    if not whole.any():
        error = "no part"
    else:
        error = f"{np.sqrt(np.mean(np.log(ratios) ** 2)):.2f}" if (ratios > 0).all() else "black"
    seen = f"{whole.sum()} parts"
    return f"| {name} | {', '.join(f'{value:.2f}' for value in mean)} | {error} | {seconds:.1f} | {seen} |"


def main(snowblue_program, mitsuba_python, godot=None):
    print("| snow | lamp | renderer | mean | RMS | s | |\n|---|---|---|---|---|---|---|")
    programs = [snowblue_program, mitsuba_python, godot]
    for body, mesh in (("block", box()), ("torus", torus())):
        for place, lamp in LAMPS.items():
            with tempfile.TemporaryDirectory() as folder:
                one = Comparison(programs, Path(folder), mesh, lamp)
                start = time.perf_counter()
                truth = one.ours("hybrid")
                print(row(f"{body} | {place} | `hybrid`", truth, truth, time.perf_counter() - start), flush=True)
                start = time.perf_counter()
                picture = one.ours("diffusion")
                named = {"`diffusion`": (picture, time.perf_counter() - start)}
                named["Mitsuba"] = one.mitsuba()
                named["Cycles, bake"] = one.blender(False)
                named["Cycles, preset"] = one.blender(True)
                named["three.js"] = one.three()
                if godot:
                    named["Godot"] = one.preview()
                for name, (picture, seconds) in named.items():
                    print(row(f"{body} | {place} | {name}", picture, truth, seconds), flush=True)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__.strip())
    main(*sys.argv[1:])
