"""PCASnow in Mitsuba 3: snow that transmits light along one straight line.

From the visible point X a straight path through the snow gives a depth d and an exit X_t. Snow sends out
T(d, theta) E / pi, where E is the irradiance of a lamp at X_t and theta the angle of incidence there, and reflects
R(d, theta) E / pi, where E and theta are those at X. T and R are the curves of a slab.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from snowblue import _native
from snowblue._arguments import VISIBLE_NM
from snowblue._database import Database
from snowblue._renderers import _bands

PATH_MODES = ("brightest", "normal", "light", "view")
SOLID = "face_snow_solid"
"""The attribute of a mesh that has the number of its solid."""

OFFSET_CM = 2.0**-6
"""Textures are uniform in the logarithm of the depth plus this."""
CELLS_PER_OCTAVE = 32
"""Cells are 2 % of the depth: linear interpolation changes ln T by 6e-5 of itself."""
BEYOND_OCTAVES = 4
"""The textures end at 16 times the table's last depth, where no light is left."""
SAME_PLACE = 1e-5
"""The greatest difference between two hits of the same triangle, as a part of the coordinates."""
LEAST = 1e-30
"""The least transmittance: curves in linear space may be below 0."""


class Curves:
    """Transmittance and reflectance of one snow over depth and angle."""

    def __init__(self, database: Database, snow: dict[str, Any]) -> None:
        last_cm = float(database.axes["thickness"][-1])
        first = np.log2(OFFSET_CM)
        cells = int(np.ceil((np.log2(last_cm + OFFSET_CM) - first + BEYOND_OCTAVES) * CELLS_PER_OCTAVE))
        depths_cm = 2.0 ** (first + np.arange(cells + 1) / CELLS_PER_OCTAVE) - OFFSET_CM
        depths_cm[0] = 0.0
        within = depths_cm[depths_cm <= last_cm]
        # Two depths more, for the straight line beyond the table.
        ends_cm = [last_cm * (1 - 1 / CELLS_PER_OCTAVE), last_cm]
        self.last_deg = float(database.axes["angle"][-1])
        self.angles = int(np.ceil(self.last_deg)) + 1
        angles_deg = np.linspace(0.0, self.last_deg, self.angles)
        curves = database._table.read_or_solve(snow, [*within, *ends_cm], angles_deg.tolist())
        known = {name: values.reshape(len(within) + 2, self.angles, -1) for name, values in curves.items()}
        logs = _visible(np.log(np.maximum(known["transmittance"], LEAST)), database)
        reflectance = _visible(known["reflectance"], database)
        slope = np.minimum((logs[-1] - logs[-2]) / (ends_cm[1] - ends_cm[0]), 0.0)
        beyond_cm = depths_cm[len(within) :, None, None]
        logs = np.concatenate([logs[:-2], logs[-1] + slope * (beyond_cm - last_cm)])
        reflectance = np.concatenate([reflectance[:-2], np.repeat(reflectance[-1:], len(beyond_cm), axis=0)])
        self.depths = len(depths_cm)
        self._fill(logs, reflectance)

    def _fill(self, logs: np.ndarray, reflectance: np.ndarray) -> None:
        """Makes textures of arrays over depth, angle and wavelength."""
        transmittance = np.exp(logs)
        self.brightness = _plane(np.log(np.maximum(_xyz(transmittance)[..., 1:2], LEAST)))
        self.is_spectral = "spectral" in mi.variant()
        if self.is_spectral:
            self.transmittance, self.reflectance = _volume(logs), _volume(reflectance)
            return
        # A lamp is three bands of wavelengths. The tristimulus values of each are positive, unlike colours.
        bands = [_bands(color) for color in np.eye(3)]
        values = np.concatenate([_xyz(transmittance * band) for band in bands], axis=-1)
        self.transmittance = _plane(np.log(np.maximum(values, LEAST)))
        matrix = _to_rgb()
        self.reflectance = _plane(_xyz(reflectance) @ matrix.T)
        self.to_rgb = mi.Matrix3f(matrix.tolist())

    def _place(self, depth_cm: Any, cosine: Any) -> list[Any]:
        """The place of a depth and an angle in the textures: the angle runs fastest."""
        depth = (dr.log2(dr.maximum(depth_cm, 0) + OFFSET_CM) - np.log2(OFFSET_CM)) * CELLS_PER_OCTAVE
        angle = dr.rad2deg(dr.safe_acos(cosine)) * ((self.angles - 1) / self.last_deg)
        return [(angle + 0.5) / self.angles, (depth + 0.5) / self.depths]

    def transmitted(self, light: Any, wavelengths: Any, depth_cm: Any, cosine: Any) -> Any:
        """A lamp's light through the snow."""
        place = self._place(depth_cm, cosine)
        if self.is_spectral:
            return light * self._spectrum(self.transmittance, wavelengths, place, dr.exp)
        values = [dr.exp(value) for value in self.transmittance.eval(mi.Point2f(*place))]
        seen = mi.Vector3f(0)
        for channel in range(3):
            seen += light[channel] * mi.Vector3f(*values[3 * channel : 3 * channel + 3])
        return mi.Color3f(self.to_rgb @ seen)

    def reflected(self, wavelengths: Any, depth_cm: Any, cosine: Any) -> Any:
        """The reflectance."""
        place = self._place(depth_cm, cosine)
        if self.is_spectral:
            return self._spectrum(self.reflectance, wavelengths, place, lambda value: value)
        return mi.Color3f(*self.reflectance.eval(mi.Point2f(*place)))

    def luminance(self, depth_cm: Any, cosine: Any) -> Any:
        """The luminous transmittance for daylight."""
        return dr.exp(self.brightness.eval(mi.Point2f(*self._place(depth_cm, cosine)))[0])

    def _spectrum(self, texture: Any, wavelengths: Any, place: list[Any], of_value: Any) -> Any:
        spectrum = mi.Spectrum(0.0)
        for lane in range(len(spectrum)):
            unit = (wavelengths[lane] - VISIBLE_NM[0]) / (VISIBLE_NM[-1] - VISIBLE_NM[0])
            across = (unit * (len(VISIBLE_NM) - 1) + 0.5) / len(VISIBLE_NM)
            spectrum[lane] = of_value(texture.eval(mi.Point3f(across, *place))[0])
        return spectrum


class PCASnow:
    """The snow of a scene, and its lamps."""

    def __init__(self, unit_m: float, path_mode: str, database: Database) -> None:
        if path_mode not in PATH_MODES:
            raise ValueError(f"path_mode is '{path_mode}', but must be one of {', '.join(PATH_MODES)}")
        self.unit_m, self.path_mode, self.database = unit_m, path_mode, database
        self.curves: dict[str, Curves] = {}
        self.meshes = ""
        self.snow: list[Any] = []

    def prepare(self, scene: Any, snow: list[Any], lamps: list[Any]) -> None:
        """Gives the plug-ins on snow what they need to trace paths in it."""
        self.scene, self.snow = scene, snow
        self.lamps = [_Lamp(lamp) for lamp in lamps]
        # Shapes without a word are solids of their own.
        bodies = [shape.bsdf().body or number for number, shape in enumerate(snow)]
        names = list(dict.fromkeys(bodies))
        self.has_bodies = len(names) < len(snow)
        arrays = [arrays_of(mi.traverse(shape)) for shape in snow]
        digest = hashlib.sha256(repr(bodies).encode())
        for array in (array for pair in arrays for array in pair):
            digest.update(array.tobytes())
        if self.meshes != digest.hexdigest():
            for shape, pair in zip(snow, arrays):
                _check_closed(name_of(shape, scene.shapes()), *pair)
            self._unite(arrays, [names.index(body) for body in bodies])
            self.meshes = digest.hexdigest()
        for number, shape in enumerate(snow):
            solid = names.index(bodies[number])
            triangles = len(arrays[number][1])
            shape.add_attribute(SOLID, 1, np.full(triangles, solid, dtype=np.float32))
            key = shape.bsdf().material_name
            if key not in self.curves:
                try:
                    self.curves[key] = Curves(self.database, shape.bsdf().material)
                except ValueError as error:
                    raise ValueError(f"shape {name_of(shape, scene.shapes())}: {error}") from None
            shape.bsdf().pcasnow = shape.emitter().pcasnow = self

    def release(self) -> None:
        """Takes it back: the plug-ins would keep their scene alive."""
        for shape in self.snow:
            if shape.bsdf().pcasnow is self:
                shape.bsdf().pcasnow = None
            if shape.emitter().pcasnow is self:
                shape.emitter().pcasnow = None
                shape.remove_attribute(SOLID)
        self.scene, self.snow, self.lamps = None, [], []

    def _unite(self, arrays: list[tuple[np.ndarray, np.ndarray]], solids: list[int]) -> None:
        """Makes one mesh of all snow, whose triangles hold the numbers of their shape and solid."""
        counts = [len(triangles) for _, triangles in arrays]
        firsts = np.cumsum([0, *(len(vertices) for vertices, _ in arrays)])
        mesh = mi.Mesh("snow", int(firsts[-1]), sum(counts))
        parameters = mi.traverse(mesh)
        indices = type(parameters["faces"])
        vertices = np.concatenate([vertices for vertices, _ in arrays]).astype(np.float32)
        faces = np.concatenate([triangles + first for (_, triangles), first in zip(arrays, firsts)])
        parameters["vertex_positions"] = type(parameters["vertex_positions"])(vertices.ravel())
        parameters["faces"] = indices(faces.astype(np.uint32).ravel())
        parameters.update()
        self.surfaces = mi.load_dict({"type": "scene", "snow": mesh})
        self.shape_of = indices(np.repeat(np.arange(len(arrays)), counts).astype(np.uint32))
        self.solid_of = indices(np.repeat(solids, counts).astype(np.uint32))

    def _curves(self, bsdf: Any) -> Curves:
        return self.curves[bsdf.material_name]

    def reflectance(self, bsdf: Any, si: Any, cosine: Any, active: Any) -> Any:
        """The reflectance of snow for light at a cosine of incidence."""
        chord = self._straight(si, _solid(si, active), active)
        return self._curves(bsdf).reflected(si.wavelengths, self._depth_cm(chord), cosine)

    def transmitted(self, shape: Any, si: Any, active: Any) -> Any:
        """The light of all lamps through the snow."""
        curves, light, solid = self._curves(shape.bsdf()), mi.Spectrum(0.0), _solid(si, active)
        straight = None if self.path_mode == "light" else self._straight(si, solid, active)
        for place, lamp in enumerate(self.lamps):
            path = self._path(curves, lamp, _sample(lamp, si, place), solid, si, straight, active)
            through = curves.transmitted(path.irradiance, si.wavelengths, path.depth_cm, path.cosine)
            light += dr.select(path.brightness > 0, through * dr.inv_pi, 0)
        return light

    def _path(
        self, curves: Curves, lamp: _Lamp, sample: Any, solid: Any, si: Any, straight: _Chord | None, active: Any
    ) -> _Path:
        """The path of a lamp's light through the snow."""
        if straight is None:
            return self._along_line(curves, lamp, lamp.seen(si, si.p, sample), solid, si, active)
        if self.path_mode != "brightest":
            return self._along_straight(curves, lamp.seen(si, straight.point, sample), solid, straight, active)
        behind = lamp.seen(si, si.p, sample)
        # A spot shines differently in other directions. Of a lamp with extent the same point counts for both paths.
        at_exit = lamp.seen(si, straight.point, sample) if lamp.is_delta else lamp.moved(behind, straight.point)
        first = self._along_straight(curves, at_exit, solid, straight, active)
        second = self._along_line(curves, lamp, behind, solid, si, active)
        pairs = zip(vars(first).values(), vars(second).values())
        return _Path(*(dr.select(first.brightness >= second.brightness, one, other) for one, other in pairs))

    def _along_straight(self, curves: Curves, light: _Light, solid: Any, chord: _Chord, active: Any) -> _Path:
        cosine = dr.dot(chord.normal, light.direction)
        active = active & chord.is_through & (cosine > 0)
        is_lit = active & self._is_visible(chord, light.target, solid, active)
        return self._lit(curves, chord, cosine, light.irradiance * cosine, light.cos_emission, is_lit)

    def _along_line(self, curves: Curves, lamp: _Lamp, light: _Light, solid: Any, si: Any, active: Any) -> _Path:
        # A lamp in front of the surface is reflected.
        active = active & (dr.dot(si.n, light.direction) < 0)
        chord = self._chord(si, solid, light.direction, light.distance, active)
        is_within = chord.ends_within
        cosine = dr.select(is_within, 1.0, dr.dot(chord.normal, light.direction))
        active = active & (is_within | (chord.is_through & (cosine > 0)))
        is_lit = active & (is_within | self._is_visible(chord, light.target, solid, active & _not(is_within)))
        irradiance = light.irradiance
        if not lamp.is_infinite:
            point = dr.select(is_within, si.p, chord.point)
            squared = dr.squared_norm(light.target - point)
            # A lamp that touches the snow gives no more than pi times its radiance.
            irradiance = irradiance * (light.distance * light.distance / (squared + lamp.disk_area * dr.inv_pi))
        return self._lit(curves, chord, cosine, irradiance * cosine, light.cos_emission, is_lit)

    def _lit(
        self, curves: Curves, chord: _Chord, cosine: Any, irradiance: Any, cos_emission: Any, is_lit: Any
    ) -> _Path:
        """A path, with brightness 0 where no light takes it. Points of lamps are compared as if they shone equally in
        all directions: otherwise they would be divided between both paths."""
        depth_cm = self._depth_cm(chord)
        mean = dr.mean(irradiance) / dr.maximum(cos_emission, 1e-6)
        brightness = dr.select(is_lit, curves.luminance(depth_cm, cosine) * mean, 0)
        return _Path(depth_cm, cosine, irradiance, brightness)

    def _depth_cm(self, chord: _Chord) -> Any:
        return chord.length * (100 * self.unit_m)

    def _straight(self, si: Any, solid: Any, active: Any) -> _Chord:
        """The path that does not depend on a lamp."""
        direction = -si.to_world(si.wi) if self.path_mode == "view" else -si.n
        return self._chord(si, solid, direction, mi.Float(dr.inf), active)

    def _chord(self, si: Any, solid: Any, direction: Any, end: Any, active: Any) -> _Chord:
        values = _march(self.surfaces, self.solid_of, self.shape_of, si, solid, direction, end, mi.Bool(active))
        return _Chord(*values)

    def _is_visible(self, chord: _Chord, target: Any, solid: Any, active: Any) -> Any:
        """Whether a point of a lamp is seen from where a path leaves the snow. The other shapes of a solid do not
        occlude it."""
        exit = dr.zeros(mi.SurfaceInteraction3f)
        exit.p, exit.n = chord.point, chord.normal
        if not self.has_bodies:
            return _not(self.scene.ray_test(exit.spawn_ray_to(target), active))
        snow = (self.surfaces, self.solid_of, self.shape_of)
        return _not(_is_blocked(self.scene, snow, exit, target, solid, chord.shape, mi.Bool(active)))


@dataclass(frozen=True)
class _Chord:
    """A straight path through a solid."""

    length: Any
    """The sum of the segments inside, up to the last exit or the end."""
    is_through: Any
    """Whether it leaves the solid."""
    ends_within: Any
    """Whether it ends inside."""
    point: Any
    normal: Any
    shape: Any
    """The number of the shape that it leaves last."""


@dataclass(frozen=True)
class _Path:
    """A path of light through the snow."""

    depth_cm: Any
    cosine: Any
    irradiance: Any
    brightness: Any


@dataclass(frozen=True)
class _Light:
    """A point of a lamp as it is seen from another point."""

    direction: Any
    distance: Any
    target: Any
    offset: Any
    """From where it is seen to the target."""
    normal: Any
    cos_emission: Any
    irradiance: Any
    """On a surface that faces it, for all of the lamp."""


class _Lamp:
    """An emitter that is not snow."""

    def __init__(self, emitter: Any) -> None:
        self.emitter = emitter
        flags = emitter.flags()
        self.is_delta = mi.has_flag(flags, mi.EmitterFlags.Delta)
        self.is_infinite = mi.has_flag(flags, mi.EmitterFlags.Infinite)
        self.disk_area = 0.0
        if not (self.is_delta or self.is_infinite):
            shape = emitter.get_shape()
            area = float(np.ravel(np.array(shape.surface_area()))[0])
            # The mean projected area of a convex solid is a quarter of its surface.
            self.disk_area = area if shape.class_name() in ("Rectangle", "Disk") else area / 4

    def seen(self, si: Any, point: Any, sample: Any) -> _Light:
        """A point of the lamp, chosen as it is seen from a point, and its irradiance there."""
        reference = dr.zeros(mi.SurfaceInteraction3f)
        reference.p, reference.wavelengths, reference.time = point, si.wavelengths, si.time
        sampled, weight = self.emitter.sample_direction(reference, sample)
        cosine = mi.Float(1.0) if self.is_delta or self.is_infinite else -dr.dot(sampled.n, sampled.d)
        distance = mi.Float(dr.inf) if self.is_infinite else sampled.dist
        return _Light(sampled.d, distance, sampled.p, sampled.p - point, sampled.n, cosine, weight)

    def moved(self, light: _Light, point: Any) -> _Light:
        """The same point of the lamp, seen from another point."""
        if self.is_infinite:
            return replace(light, target=point + light.offset)
        offset = light.target - point
        distance = dr.norm(offset)
        direction = offset / distance
        cosine = -dr.dot(light.normal, direction)
        ratio = light.distance / distance
        factor = ratio * ratio * dr.maximum(cosine, 0) / dr.maximum(light.cos_emission, 1e-6)
        return _Light(direction, distance, light.target, offset, light.normal, cosine, light.irradiance * factor)


@dr.syntax
def _march(
    surfaces: Any, solid_of: Any, shape_of: Any, si: Any, solid: Any, direction: Any, end: Any, active: Any
) -> tuple[Any, ...]:
    """Follows a line from a point on a solid into it, up to an end or its last exit.

    Before an exit the line is in snow. Before an entry it is so only where shapes overlap.
    """
    ray = si.spawn_ray(direction)
    length, last = mi.Float(0), mi.Float(0)
    is_through, ends_within = mi.Bool(False), mi.Bool(False)
    point, normal, shape = mi.Point3f(0), mi.Normal3f(0), mi.UInt32(0)
    # A line that starts outwards leaves the solid behind.
    layers = mi.Int32(dr.select(dr.dot(direction, si.n) > 0, 0, 1))
    while active:
        hit = surfaces.ray_intersect(ray, ray_flags=mi.RayFlags.Minimal, coherent=False, active=active)
        active &= hit.is_valid()
        is_own = active & (_at(solid_of, hit.prim_index, active) == solid)
        place = dr.dot(hit.p - si.p, direction)
        leaves = dr.dot(hit.n, direction) > 0
        is_beyond = is_own & (place >= end)
        ends_within |= is_beyond & leaves
        length += dr.select(is_own & (leaves | (layers > 0)), dr.minimum(place, end) - last, 0)
        active &= _not(is_beyond)
        is_own &= _not(is_beyond)
        last = dr.select(is_own, place, last)
        layers = dr.select(is_own, dr.select(leaves, dr.maximum(layers - 1, 0), layers + 1), layers)
        is_exit = is_own & leaves
        is_through |= is_exit
        point = dr.select(is_exit, hit.p, point)
        normal = dr.select(is_exit, hit.n, normal)
        shape = dr.select(is_exit, _at(shape_of, hit.prim_index, is_exit), shape)
        ray = hit.spawn_ray(direction)
    return length, is_through, ends_within, point, normal, shape


@dr.syntax
def _is_blocked(scene: Any, snow: tuple[Any, ...], exit: Any, target: Any, solid: Any, own: Any, active: Any) -> Any:
    """Whether something other than the other shapes of a solid occludes a point."""
    blocked, ray = mi.Bool(False), exit.spawn_ray_to(target)
    while active:
        hit = scene.ray_intersect(ray, ray_flags=mi.RayFlags.Minimal, coherent=False, active=active)
        active &= hit.is_valid()
        blocked |= active & _not(_is_other(snow, ray, hit, solid, own, active))
        active &= _not(blocked)
        ray = hit.spawn_ray_to(target)
    return blocked


def _is_other(snow: tuple[Any, ...], ray: Any, hit: Any, solid: Any, own: Any, active: Any) -> Any:
    """Whether a hit is on another shape of a solid: the mesh of all snow, which holds its shapes, is hit there too."""
    surfaces, solid_of, shape_of = snow
    same = surfaces.ray_intersect(ray, ray_flags=mi.RayFlags.Minimal, coherent=False, active=active)
    active = active & same.is_valid() & (dr.abs(same.t - hit.t) <= SAME_PLACE * (1 + dr.max(dr.abs(hit.p))))
    is_solid = _at(solid_of, same.prim_index, active) == solid
    return active & is_solid & (_at(shape_of, same.prim_index, active) != own)


def _solid(si: Any, active: Any) -> Any:
    """The number of the solid that was hit."""
    return mi.UInt32(si.shape.eval_attribute_1(SOLID, si, active) + 0.5)


def _not(mask: Any) -> Any:
    # The complement of a bool of Python, which scalar variants have, is a number.
    return mask ^ True


def _at(numbers: Any, index: Any, active: Any) -> Any:
    """An element of an array; 0 where none is asked for."""
    if mi.variant().startswith("scalar"):
        return numbers[index] if active else 0
    return dr.gather(mi.UInt32, numbers, index, active)


def _sample(lamp: _Lamp, si: Any, place: int) -> Any:
    """Two random numbers for a lamp with extent: a hash of the point."""
    if lamp.is_delta:
        return mi.Point2f(0.5, 0.5)
    keys = []
    for coordinate in si.p:
        # The last digits of the coordinate.
        scaled = coordinate * 4096
        keys.append(mi.UInt32((scaled - dr.floor(scaled)) * 2.0**23))
    first = mi.sample_tea_32(keys[0], keys[1])[0]
    second = mi.UInt32(keys[2] + place)
    return mi.Point2f(mi.sample_tea_float32(first, second), mi.sample_tea_float32(second, first))


def name_of(thing: Any, things: list[Any]) -> str:
    """How messages name a shape or an emitter of a scene: by its id, or by its number among all."""
    return f"'{thing.id()}'" if thing.id() else f"number {list(things).index(thing) + 1} without an id"


def arrays_of(parameters: Any) -> tuple[np.ndarray, np.ndarray]:
    """The vertices and triangles of a mesh, by its parameters."""
    vertices = np.array(parameters["vertex_positions"]).reshape(-1, 3)
    return vertices, np.array(parameters["faces"]).astype(np.int64).reshape(-1, 3)


def _check_closed(name: str, vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Refuses meshes in which a line may enter and not leave."""
    _, corner = np.unique(vertices, axis=0, return_inverse=True)
    corners = corner.reshape(-1)[triangles]
    corners = corners[(corners != np.roll(corners, 1, axis=1)).all(axis=1)]
    edges = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    odd = int((counts % 2).sum())
    if odd:
        raise ValueError(
            f"shape {name} is open: {odd} of its edges have an odd number of triangles, but must have an even one; "
            "`snowblue repair` closes holes"
        )


def _visible(values: np.ndarray, database: Database) -> np.ndarray:
    """Curves at 400 to 700 nm."""
    known = database.axes["wavelength"]
    if known[0] > VISIBLE_NM[0] or known[-1] < VISIBLE_NM[-1]:
        raise ValueError(
            f"the table has wavelengths of {known[0]:g} to {known[-1]:g} nm, but must have {VISIBLE_NM[0]:g} to "
            f"{VISIBLE_NM[-1]:g} nm"
        )
    if np.array_equal(known, VISIBLE_NM):
        return values
    return np.apply_along_axis(lambda curve: np.interp(VISIBLE_NM, known, curve), -1, values)


def _colors(spectra: np.ndarray) -> dict[str, np.ndarray]:
    light = {"illuminant": "D65", "observer": "1931"}
    values = np.ascontiguousarray(spectra, dtype=float).reshape(-1)
    return _native.colors(values, VISIBLE_NM.tolist(), light, 0.0)


def _xyz(spectra: np.ndarray) -> np.ndarray:
    """Tristimulus values of light relative to D65."""
    return _colors(spectra)["xyz"].reshape(*spectra.shape[:-1], 3)


def _to_rgb() -> np.ndarray:
    """The matrix from tristimulus values to linear sRGB in which the light itself is white."""
    colors = _colors(np.stack([_bands(color) for color in np.eye(3)]))
    xyz, rgb = colors["xyz"].reshape(3, 3), colors["rgb_linear"].reshape(3, 3)
    # The bands add up to the light.
    return np.linalg.solve(xyz, rgb / rgb.sum(axis=0)).T


def _plane(values: np.ndarray) -> Any:
    """A texture over depth and angle."""
    return mi.Texture2f(mi.TensorXf(np.ascontiguousarray(values, dtype=np.float32)), wrap_mode=dr.WrapMode.Clamp)


def _volume(values: np.ndarray) -> Any:
    """A texture over depth, angle and wavelength."""
    array = np.ascontiguousarray(values[..., None], dtype=np.float32)
    return mi.Texture3f(mi.TensorXf(array), wrap_mode=dr.WrapMode.Clamp)
