"""Lamps of Blender as lamps of snowblue, at unit strength and white, and their strength as drivers.

A lamp of energy P has, in Cycles, the radiant intensity P/(4 pi) (point and spot), the irradiance P (sun), or the
radiance P/(pi A) on its area A (area lamp), all in units of the scene. `Normalize` off multiplies P by the area: 4 pi
r² for a point or spot of radius r, pi sin²(angle/2) for a sun.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from snowblue._renderers import BAND_WIDTH_NM

WHITE_FILE = "white.csv"
"""The file of a scene that holds the spectrum of white light."""
SPOT_FALLOFF = 0.75
"""Blender's spot falls off by smoothstep, ours by the square, both in the cosine. Their means over the blend are 1/2
and 1/3: this width of ours, relative to that of Blender, makes the power equal."""
LEAST_FALLOFF = 0.001
"""Least width of the falloff of our spots, as a difference of cosines, as in glTF."""
CYCLES_POINT_AREA = 4.0
"""The area that Cycles gives to a point without a radius if `Normalize` is off."""
FALLOFF_ERROR = 0.01
"""Greatest error of the irradiance by a soft falloff that needs no warning."""
FULL_SPREAD = 1e-4
"""A spread within so much of 180° is none."""
LEAST_SPREAD = math.radians(1)
SPREAD_SLICES = 16
"""Cones of each of the spots that stand for an area lamp with a spread."""
MOST_SPOTS = 8
"""Along each side of an area lamp with a spread."""


class SnowSurface:
    """The surface of the snow of a scene."""

    def __init__(self, meshes: list[tuple[np.ndarray, np.ndarray]]) -> None:
        """Of vertices in m, (n, 3), and triangles (m, 3)."""
        self._meshes = meshes

    @cached_property
    def _trees(self) -> list[BVHTree]:
        meshes = self._meshes
        return [BVHTree.FromPolygons(*(one.tolist() for one in mesh), all_triangles=True) for mesh in meshes]

    def distance_m(self, place: Sequence[float]) -> float:
        """From a place to the nearest point of the snow."""
        return min(tree.find_nearest(place)[3] for tree in self._trees)


@dataclass(frozen=True)
class Lamp:
    """A lamp that is solved for alone."""

    name: str
    uid: int
    """Of its object: the `session_uid`. That of an evaluated one differs."""
    kind: tuple[str, bool]
    """What the strength of the lights follows from: the type, and whether `Normalize` is on."""
    place: Vector
    """Where it is in units of the scene; of a sun, the direction to it."""
    lights: list[dict[str, Any]]
    """Lights of a scene that together are white, and as strong as a Blender lamp with the energy 1."""


def lamp_of(thing: bpy.types.Object, to_world: Matrix, unit_m: float, snow: SnowSurface) -> Lamp | None:
    """The lamp of an object; none for what is no lamp.

    `unit_m` is the length of a unit of the scene.
    """
    light = thing.data
    if light.type == "AREA" and light.cycles.is_portal:
        return None
    _check(thing)
    place = -_axis(to_world) if light.type == "SUN" else to_world.translation.copy()
    return Lamp(thing.name, thing.original.session_uid, _kind(light), place, _lights(thing, to_world, unit_m, snow))


def is_driven(lamp: Lamp, thing: bpy.types.Object) -> bool:
    """Whether drivers can still make the strength of an object that of a lamp."""
    if thing.type != "LIGHT" or _kind(thing.data) != lamp.kind:
        return False
    return not thing.data.use_nodes or emission_of(thing.data) is not None


def _kind(light: bpy.types.Light) -> tuple[str, bool]:
    return light.type, _is_normalized(light)


def _axis(to_world: Matrix) -> Vector:
    """Where a lamp shines."""
    return (to_world.to_3x3() @ Vector((0, 0, -1))).normalized()


def _lights(thing: bpy.types.Object, to_world: Matrix, unit_m: float, snow: SnowSurface) -> list[dict[str, Any]]:
    light = thing.data
    is_normalized = _is_normalized(light)
    position = to_world.translation * unit_m
    axis = _axis(to_world)
    at = {"position": list(position), "spectrum": WHITE_FILE}
    if light.type == "SUN":
        area = 1.0 if is_normalized or light.angle == 0 else math.pi * math.sin(light.angle / 2) ** 2
        description = {"type": "directional", "direction": list(axis), "spectrum": WHITE_FILE}
        description["irradiance_w_m2"] = BAND_WIDTH_NM * area
        return [description]
    if light.type == "AREA":
        rectangle = at | _rectangle(thing, to_world, position, axis, unit_m)
        return [rectangle] if light.spread > math.pi - FULL_SPREAD else _spread(thing, rectangle, snow)
    radius = light.shadow_soft_size
    area = 1.0 if is_normalized else 4 * math.pi * radius**2 if radius > 0 else CYCLES_POINT_AREA
    intensity = BAND_WIDTH_NM * area / (4 * math.pi) * unit_m**2
    if light.use_soft_falloff and radius > 0:
        _check_falloff(thing, radius * unit_m, snow.distance_m(position))
    if light.type == "SPOT":
        description = at | {"type": "spot", "look_at": list(position + axis), "radiant_intensity_w_sr": intensity}
        description |= _cone(light.spot_size, light.spot_blend)
    elif radius > 0:
        radiance = intensity / (math.pi * (radius * unit_m) ** 2)
        description = at | {"type": "sphere", "radius": radius * unit_m, "radiance_w_m2_sr": radiance}
    else:
        description = at | {"type": "point", "radiant_intensity_w_sr": intensity}
    return [description]


def _is_normalized(light: bpy.types.Light) -> bool:
    """Whether the power of a lamp does not depend on its size. Before Blender 4.5 it never does."""
    return getattr(light, "normalize", True)


def _cone(size: float, blend: float) -> dict[str, float]:
    """The cone of a spot of the same power."""
    outer = math.cos(size / 2)
    blended = (1 - outer) * blend
    width = max(SPOT_FALLOFF * blended, LEAST_FALLOFF)
    outer += blended / 2 - 2 / 3 * width
    outer_deg, inner_deg = (math.degrees(math.acos(min(cosine, 1.0))) for cosine in (outer, outer + width))
    return {"inner_cone_deg": inner_deg, "outer_cone_deg": outer_deg}


def _rectangle(
    thing: bpy.types.Object, to_world: Matrix, position: Vector, axis: Vector, unit_m: float
) -> dict[str, Any]:
    light, scale = thing.data, to_world.to_scale()
    length = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    size = np.array([abs(light.size * scale.x), abs(length * scale.y)])
    if light.shape in ("DISK", "ELLIPSE"):
        # A rectangle of the same area.
        size *= math.sqrt(math.pi / 4)
        warnings.warn(
            f"lamp '{thing.name}' is a {light.shape.lower()}: snow sees a rectangle of the same area", stacklevel=2
        )
    radiance = BAND_WIDTH_NM / math.pi / (size.prod() if _is_normalized(light) else 1.0)
    return {
        "type": "rectangle",
        "look_at": list(position + axis),
        "up": list((to_world.to_3x3() @ Vector((0, 1, 0))).normalized()),
        "size": (size * unit_m).tolist(),
        "radiance_w_m2_sr": radiance,
    }


def _spread(thing: bpy.types.Object, rectangle: dict[str, Any], snow: SnowSurface) -> list[dict[str, Any]]:
    """Spots that shine together like an area lamp with a spread.

    Cycles gives each point of the lamp the radiance L tan h/(tan h - h) (1 - tan(theta)/tan h) up to half the spread h,
    and so the intensity in proportion to sin(h - theta)/sin h.
    """
    half = thing.data.spread / 2
    size, position = np.array(rectangle["size"]), np.array(rectangle["position"])
    axis, up = np.array(rectangle["look_at"]) - position, np.array(rectangle["up"])
    sides = np.stack([np.cross(axis, up), up])
    corners = [position + (np.array(corner) * size / 2) @ sides for corner in product((-1, 0, 1), repeat=2)]
    distance = min(snow.distance_m(corner.tolist()) for corner in corners)
    # A quarter of the radius of a cone on the snow.
    spacing = max(0.25 * distance * min(1.0, math.tan(half)), 1e-9)
    wanted = np.ceil(size / spacing)
    if wanted.max() > MOST_SPOTS:
        warnings.warn(
            f"lamp '{thing.name}' is close to the snow or has a small spread: snow sees {MOST_SPOTS} spots along a "
            "side",
            stacklevel=2,
        )
    columns, rows = np.clip(wanted, 1, MOST_SPOTS).astype(int)
    peak = rectangle["radiance_w_m2_sr"] * size.prod() / (1 - half / math.tan(half)) / (columns * rows * SPREAD_SLICES)
    spots = []
    for column, row in product(range(columns), range(rows)):
        center = position + (np.array([(column + 0.5) / columns - 0.5, (row + 0.5) / rows - 0.5]) * size) @ sides
        at = {"type": "spot", "position": center.tolist(), "look_at": (center + axis).tolist()}
        at |= {"spectrum": rectangle["spectrum"], "radiant_intensity_w_sr": peak}
        spots += [at | cone for cone in _slices(half)]
    return spots


def _slices(half: float) -> list[dict[str, float]]:
    """Cones of spots whose mean has the profile sin(h - theta)/sin h, to 1/4 of a slice of it.

    Each has the power of its slice.
    """
    theta = np.linspace(0.0, half, 2001)
    profile = SPREAD_SLICES * np.sin(half - theta) / math.sin(half)
    cones = []
    for number in range(SPREAD_SLICES):
        values = np.clip(profile - number, 0.0, 1.0) * np.sin(theta)
        power = float(((values[1:] + values[:-1]) / 2 * np.diff(theta)).sum())
        outer = math.cos(half - math.asin(number / SPREAD_SLICES * math.sin(half)))
        # The mean of the falloff over its part of the cone is 1/3.
        inner = min((3 * (1 - power) - outer) / 2, 1.0)
        inner_deg, outer_deg = (math.degrees(math.acos(cosine)) for cosine in (inner, outer))
        cones.append({"inner_cone_deg": inner_deg, "outer_cone_deg": outer_deg})
    return cones


def _check(thing: bpy.types.Object) -> None:
    """Refuses lamps whose light snow cannot take, and warns of what it does not see."""
    light, name = thing.data, thing.name
    if light.use_nodes and emission_of(light) is None:
        raise ValueError(f"lamp '{name}' has nodes other than a plain Emission: switch 'Use Nodes' off")
    if light.type == "AREA" and light.spread < LEAST_SPREAD:
        raise ValueError(
            f"lamp '{name}' has a spread of {math.degrees(light.spread):.2g}°, but must have "
            f"{math.degrees(LEAST_SPREAD):.0f}–180°"
        )
    if light.type == "SPOT" and light.use_square:
        warnings.warn(f"lamp '{name}' is a square spot: snow sees a round one, as Cycles does", stacklevel=2)
    if light.type == "SPOT" and light.spot_size >= math.pi:
        raise ValueError(f"lamp '{name}' has a cone of {math.degrees(light.spot_size):.0f}°, but must be below 180°")
    if not light.use_shadow:
        warnings.warn(f"lamp '{name}' casts no shadow, but the light in the snow has shadows", stacklevel=2)
    linking = thing.light_linking
    if linking.receiver_collection or linking.blocker_collection:
        warnings.warn(f"lamp '{name}' has light linking, which the light in the snow does not", stacklevel=2)


def _check_falloff(thing: bpy.types.Object, radius_m: float, nearest_m: float) -> None:
    error = radius_m**2 / (radius_m**2 + nearest_m**2)
    if error > FALLOFF_ERROR:
        warnings.warn(
            f"lamp '{thing.name}' has 'Soft Falloff': close by, snow takes up to {error:.0%} more light than Blender "
            "shows; switch it off",
            stacklevel=2,
        )


def emission_of(light: bpy.types.Light) -> bpy.types.Node | None:
    """The node that sets the light of a lamp with nodes, if it is a plain Emission."""
    output = light.node_tree.get_output_node("CYCLES") if light.node_tree else None
    links = output.inputs["Surface"].links if output else ()
    node = links[0].from_node if links else None
    is_plain = node is not None and node.type == "EMISSION" and not any(socket.is_linked for socket in node.inputs)
    return node if is_plain else None


def drive_strength(socket: bpy.types.NodeSocket, lamp: bpy.types.Object) -> None:
    """Makes a socket of three numbers the strength of a lamp: its colour times its energy, and 0 if it is hidden."""
    light = lamp.data
    for channel, curve in enumerate(socket.driver_add("default_value")):
        driver = curve.driver
        driver.type = "SCRIPTED"
        terms = ["energy", "color", "(1 - hidden)"]
        _variable(driver, "energy", "LIGHT", light, "energy")
        _variable(driver, "color", "LIGHT", light, f"color[{channel}]")
        _variable(driver, "hidden", "OBJECT", lamp, "hide_render")
        if "exposure" in light.bl_rna.properties:
            terms.append("pow(2, exposure)")
            _variable(driver, "exposure", "LIGHT", light, "exposure")
        if "use_temperature" in light.bl_rna.properties:
            terms.append("(warmth if warm else 1)")
            _variable(driver, "warmth", "LIGHT", light, f"temperature_color[{channel}]")
            _variable(driver, "warm", "LIGHT", light, "use_temperature")
        if light.use_nodes:
            node = emission_of(light)
            terms += ["tint", "strength"]
            for name, number, part in (("tint", 0, f"[{channel}]"), ("strength", 1, "")):
                path = f"{node.inputs[number].path_from_id('default_value')}{part}"
                _variable(driver, name, "NODETREE", light.node_tree, path)
        driver.expression = " * ".join(terms)


def _variable(driver: bpy.types.Driver, name: str, kind: str, thing: bpy.types.ID, path: str) -> None:
    variable = driver.variables.new()
    variable.name = name
    variable.type = "SINGLE_PROP"
    target = variable.targets[0]
    target.id_type = kind
    target.id = thing
    target.data_path = path
