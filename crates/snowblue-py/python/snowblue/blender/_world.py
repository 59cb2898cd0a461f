"""The light of the World: a uniform sky, or an image of it that Cycles renders, and the sun discs of sky textures."""

from __future__ import annotations

import math
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from snowblue._renderers import BAND_WIDTH_NM, _bands, _csv

WIDTH, HEIGHT, SAMPLES = 256, 128, 64
IMAGE_FILE, SPECTRUM_FILE = "sky.exr", "sky.csv"
UNIFORM = 1e-4
"""Greatest relative difference between the parts of a uniform sky."""
WITH_SUN = ("NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING")
"""Types of sky textures that have a sun disc."""
LARGEST_SUN = math.radians(5)
"""The image of the World resolves larger sun discs."""
LEAST_VIEW = math.radians(0.4)
"""Cameras of Blender see no less than 0.367°."""
SUN_PIXELS = 64
"""Across the picture of a sun disc, which is at least twice as wide as the disc."""


@dataclass(frozen=True)
class Skylight:
    """A part of the light of the World."""

    tables: dict[str, Any]
    """Tables of a scene."""
    files: dict[str, bytes] = field(default_factory=dict)
    is_image: bool = False
    to_sun: Vector | None = None
    """The direction of a sun disc."""


def skylight_of(scene: bpy.types.Scene) -> list[Skylight]:
    """What shines like the World of a scene; nothing if it is black."""
    if scene.world is None:
        return []
    if scene.world.node_tree and any(node.type == "LIGHT_PATH" for node in scene.world.node_tree.nodes):
        warnings.warn("the World has a Light Path node: snow is lit by what the camera sees of it", stacklevel=2)
    with _sky_scene(scene.world, scene.frame_current) as (sky, camera):
        suns = [_sun(sky, camera, node) for node in _sun_discs(sky.world)]
        exr, pixels = _panorama(sky, camera)
    parts = [sun for sun in suns if sun is not None]
    if not pixels.any():
        return parts
    first = pixels[0, 0].astype(float)
    if np.abs(pixels - first).max() <= UNIFORM * first.max():
        spectrum = _bands(first)
        table = {"radiance_w_m2_sr": float(spectrum.mean()) * BAND_WIDTH_NM, "spectrum": SPECTRUM_FILE}
        return [Skylight({"environment": table}, {SPECTRUM_FILE: _csv(spectrum)}), *parts]
    return [Skylight({"environment": {"image": IMAGE_FILE}}, {IMAGE_FILE: exr}, is_image=True), *parts]


def changes_with_time(world: bpy.types.World | None) -> bool:
    """Whether a World is animated, or has movies, sequences of images, or nodes that follow an object."""
    if world is None or world.animation_data is not None:
        return world is not None
    for tree in _node_trees(world):
        if tree.animation_data is not None:
            return True
        for node in tree.nodes:
            if getattr(getattr(node, "image", None), "source", "") in ("MOVIE", "SEQUENCE"):
                return True
            if getattr(node, "object", None) is not None:
                return True
    return False


def _node_trees(world: bpy.types.World) -> list[bpy.types.NodeTree]:
    """The nodes of a World, and of the groups in them."""
    trees = [world.node_tree] if world.node_tree else []
    for tree in trees:
        groups = dict.fromkeys(getattr(node, "node_tree", None) for node in tree.nodes)
        trees += [one for one in groups if one is not None and one not in trees]
    return trees


def _sun_discs(world: bpy.types.World) -> list[bpy.types.Node]:
    """Sky textures with a sun that is too small for the image of the World."""
    found = []
    for tree in _node_trees(world):
        skies = [node for node in tree.nodes if node.type == "TEX_SKY" and node.sky_type in WITH_SUN and node.sun_disc]
        small = [node for node in skies if node.sun_size <= LARGEST_SUN and node.outputs["Color"].is_linked]
        if tree == world.node_tree:
            found = small
            continue
        for node in small:
            warnings.warn(
                f"the sun of the sky texture '{node.name}' is in the node group '{tree.name}': its image is coarse, so "
                "use a sun lamp, or put the sky texture outside of the group",
                stacklevel=4,
            )
    return found


def _sun(sky: bpy.types.Scene, camera: bpy.types.Object, node: bpy.types.Node) -> Skylight | None:
    """The sun disc of a sky texture as a lamp, and switches it off; none if it does not shine."""
    to_sun = Vector(
        (
            math.cos(node.sun_elevation) * math.sin(node.sun_rotation),
            math.cos(node.sun_elevation) * math.cos(node.sun_rotation),
            math.sin(node.sun_elevation),
        )
    )
    camera.rotation_euler = to_sun.to_track_quat("-Z", "Y").to_euler()
    camera.data.type, camera.data.angle = "PERSP", max(2 * node.sun_size, LEAST_VIEW)
    half = math.tan(camera.data.angle / 2)
    across = half * (2 * (np.arange(SUN_PIXELS) + 0.5) / SUN_PIXELS - 1)
    distance = np.sqrt(1 + across[:, None] ** 2 + across[None, :] ** 2)
    # Of each pixel, times the cosine of the angle from the sun.
    solid_angle = (2 * half / SUN_PIXELS) ** 2 / distance**4
    _, with_sun = _rendered(sky, SUN_PIXELS, SUN_PIXELS)
    # Without its sun a sky texture has a Vector, which may be linked.
    for link in [one for one in sky.world.node_tree.links if one.to_node == node]:
        sky.world.node_tree.links.remove(link)
    node.sun_disc = False
    _, without = _rendered(sky, SUN_PIXELS, SUN_PIXELS)
    irradiance = np.einsum("yx,yxc->c", solid_angle, np.maximum(with_sun.astype(float) - without, 0.0))
    if not irradiance.any():
        if node.sun_elevation > -node.sun_size / 2 and with_sun.any():
            warnings.warn(
                f"the sun of the sky texture '{node.name}' was not found in the World: the light in the snow lacks it",
                stacklevel=4,
            )
        return None
    spectrum, name = _bands(irradiance), f"sun {node.name}.csv"
    lamp = {
        "type": "directional",
        "direction": list(-to_sun),
        "irradiance_w_m2": float(spectrum.mean()) * BAND_WIDTH_NM,
        "spectrum": name,
    }
    return Skylight({"light": [lamp]}, {name: _csv(spectrum)}, to_sun=to_sun)


@contextmanager
def _sky_scene(world: bpy.types.World, frame: int) -> Iterator[tuple[bpy.types.Scene, bpy.types.Object]]:
    """A scene with a copy of a World at a frame, and its camera."""
    scene = bpy.data.scenes.new("snowblue sky")
    data = bpy.data.cameras.new("snowblue sky")
    camera = bpy.data.objects.new("snowblue sky", data)
    seen = world.copy()
    try:
        scene.collection.objects.link(camera)
        scene.camera, scene.world = camera, seen
        seen.cycles_visibility.camera = True
        scene.frame_set(frame)
        render = scene.render
        render.engine = "CYCLES"
        render.use_compositing = render.use_sequencer = render.film_transparent = False
        scene.cycles.device = "CPU"
        scene.cycles.samples = SAMPLES
        scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
        scene.cycles.pixel_filter_type = "BOX"
        settings = render.image_settings
        settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
        settings.exr_codec = "ZIP"
        yield scene, camera
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)
        bpy.data.worlds.remove(seen)


def _panorama(scene: bpy.types.Scene, camera: bpy.types.Object) -> tuple[bytes, np.ndarray]:
    """The World in latitude and longitude, +y in the middle: an OpenEXR file, and its pixels."""
    data = camera.data
    camera.rotation_euler = (math.pi / 2, 0, 0)
    data.type = "PANO"
    # Blender 5 moved the setting to the camera.
    owner = data if "panorama_type" in data.bl_rna.properties else data.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    return _rendered(scene, WIDTH, HEIGHT)


def _rendered(scene: bpy.types.Scene, width: int, height: int) -> tuple[bytes, np.ndarray]:
    """A picture of a scene: an OpenEXR file, and its pixels."""
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / IMAGE_FILE
        render.filepath = str(path)
        bpy.ops.render.render(write_still=True, scene=scene.name)
        image = bpy.data.images.load(str(path))
        try:
            values = np.empty(width * height * image.channels, dtype=np.float32)
            image.pixels.foreach_get(values)
            pixels = values.reshape(height, width, image.channels)[..., :3]
        finally:
            bpy.data.images.remove(image)
        return path.read_bytes(), pixels
