"""The light of the World: a uniform sky, or an image of it that Cycles renders."""

from __future__ import annotations

import math
import tempfile
import warnings
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from snowblue._renderers import BAND_WIDTH_NM, _bands, _csv

WIDTH, HEIGHT, SAMPLES = 256, 128, 64
IMAGE_FILE, SPECTRUM_FILE = "sky.exr", "sky.csv"
UNIFORM = 1e-4
"""Greatest relative difference between the parts of a uniform sky."""


def environment_of(scene: bpy.types.Scene, files: dict[str, bytes]) -> dict[str, Any] | None:
    """The environment of a scene that shines like its World; none if it is black."""
    if scene.world is None:
        return None
    if scene.world.node_tree and any(node.type == "LIGHT_PATH" for node in scene.world.node_tree.nodes):
        warnings.warn("the World has a Light Path node: snow is lit by what the camera sees of it", stacklevel=2)
    exr, pixels = _panorama(scene.world, scene.frame_current)
    if not pixels.any():
        return None
    first = pixels[0, 0].astype(float)
    if np.abs(pixels - first).max() <= UNIFORM * first.max():
        spectrum = _bands(first)
        files[SPECTRUM_FILE] = _csv(spectrum)
        return {"radiance_w_m2_sr": float(spectrum.mean()) * BAND_WIDTH_NM, "spectrum": SPECTRUM_FILE}
    files[IMAGE_FILE] = exr
    return {"image": IMAGE_FILE}


def _panorama(world: bpy.types.World, frame: int) -> tuple[bytes, np.ndarray]:
    """The World of a frame in latitude and longitude, +y in the middle: an OpenEXR file, and its pixels."""
    scene = bpy.data.scenes.new("snowblue sky")
    data = bpy.data.cameras.new("snowblue sky")
    camera = bpy.data.objects.new("snowblue sky", data)
    seen = world.copy()
    try:
        scene.collection.objects.link(camera)
        scene.camera, scene.world = camera, seen
        camera.rotation_euler = (math.pi / 2, 0, 0)
        data.type = "PANO"
        # Blender 5 moved the setting to the camera.
        owner = data if "panorama_type" in data.bl_rna.properties else data.cycles
        owner.panorama_type = "EQUIRECTANGULAR"
        seen.cycles_visibility.camera = True
        scene.frame_set(frame)
        render = scene.render
        render.engine = "CYCLES"
        render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
        render.use_compositing = render.use_sequencer = render.film_transparent = False
        scene.cycles.device = "CPU"
        scene.cycles.samples = SAMPLES
        scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
        scene.cycles.pixel_filter_type = "BOX"
        settings = render.image_settings
        settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
        settings.exr_codec = "ZIP"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / IMAGE_FILE
            render.filepath = str(path)
            bpy.ops.render.render(write_still=True, scene=scene.name)
            image = bpy.data.images.load(str(path))
            try:
                values = np.empty(WIDTH * HEIGHT * image.channels, dtype=np.float32)
                image.pixels.foreach_get(values)
                pixels = values.reshape(HEIGHT, WIDTH, image.channels)[..., :3]
            finally:
                bpy.data.images.remove(image)
            return path.read_bytes(), pixels
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)
        bpy.data.worlds.remove(seen)
