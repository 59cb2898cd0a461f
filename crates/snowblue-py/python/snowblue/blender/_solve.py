"""The light in snow, lamp by lamp. Nothing here reads or changes data of Blender, so that a thread may do it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from snowblue import _native
from snowblue._renderers import BAND_WIDTH_NM, _rgb
from snowblue._scene import BakedObject, _baked, _json
from snowblue.blender._collect import Collected

WORLD = 0
"""What stands for the World among the identifiers of lamps. Those of sun discs in it are lower."""
EQUAL_ENERGY = np.array([1.2048, 0.9483, 0.9087])
"""Linear sRGB of light of equal energy and luminance 1, that of white lamps before it is relative to D65."""
Report = Callable[[int, int, str], object]
"""A function of the number of solutions that are done, of all, and of the name of the present one. An exception in it
stops the work and is raised."""


@dataclass(frozen=True)
class Options:
    """The arguments of a bake."""

    step_mm: float | None = None
    field_step_mm: float | None = None
    max_bounces: int = 8


@dataclass(frozen=True)
class Solution:
    """The light in the snow at one frame."""

    objects: list[BakedObject]
    reflections: list[np.ndarray]
    """The table of R0 of each object."""
    fluxes: dict[int, list[np.ndarray]] = field(default_factory=dict)
    """J on each object, (n, 3), by each lamp and the World."""
    irradiances: dict[int, list[np.ndarray]] = field(default_factory=dict)
    """What falls on each object: directly and by way of other surfaces, (n, 2), by each lamp; in all, (n, 3), by the
    World but for its sun discs directly; and these."""


@dataclass(frozen=True)
class _Light:
    """What is solved for alone."""

    key: int
    name: str
    tables: dict[str, Any]
    """Tables of a scene."""
    files: dict[str, bytes] = field(default_factory=dict)
    is_image: bool = False

    def lit(self, part: dict[str, Any]) -> _LitSnow:
        """An object of snow in this light, of what was baked of it."""
        baked = _baked(part, [])
        # The spectrum of an image is made of its colours, so that its flux is a colour.
        flux = baked.flux[0] if self.is_image else _rgb(baked.flux[0])
        # White light of 1 W/(m² nm) is 1.
        white = 1.0 if self.is_image else EQUAL_ENERGY * BAND_WIDTH_NM
        direct, diffuse = np.moveaxis(part["irradiance"].reshape(-1, 2, 3), 1, 0) / white
        return _LitSnow(baked, part["reflection"], flux, direct, diffuse)


@dataclass(frozen=True)
class _LitSnow:
    """An object of snow in one light."""

    baked: BakedObject
    reflection: np.ndarray
    flux: np.ndarray
    direct: np.ndarray
    """The irradiance by lamps and skies, (n, 3)."""
    diffuse: np.ndarray
    """That by uniform skies and by way of other surfaces, (n, 3)."""


def _add(parts: dict[int, list[np.ndarray]], key: int, values: list[np.ndarray]) -> None:
    """Adds values for each object to those of a light."""
    before = parts.get(key)
    parts[key] = values if before is None else [one + other for one, other in zip(before, values)]


def _put_lamp(irradiances: dict[int, list[np.ndarray]], key: int, lit: list[_LitSnow]) -> None:
    """Keeps the irradiance by a lamp, which is white."""
    here = [np.stack([one.direct[:, 1], one.diffuse[:, 1]], axis=1) for one in lit]
    if key in irradiances:
        # Instances of a lamp shine from several directions, as other surfaces do.
        sums = [one.sum(axis=1) + other.sum(axis=1) for one, other in zip(irradiances[key], here)]
        here = [np.stack([np.zeros_like(one), one], axis=1) for one in sums]
    irradiances[key] = here


def solve(frames: list[Collected], options: Options, report: Report) -> list[Solution]:
    """The light at some frames.

    Raises
    ------
    ValueError
        If the snow cannot be solved for.
    """
    total = sum(len(made.lamps) + len(made.skylight) for made in frames)
    done = 0
    known: dict[bytes, list[_LitSnow]] = {}
    solutions = []
    scene, files = None, {}
    for made in frames:
        files_before, files = files, dict(made.files)
        for part in made.skylight:
            files |= part.files
        # Scenes made from each other share the cells of the snow.
        scene = scene if files == files_before else None
        prefix = f"frame {made.frame}, " if len(frames) > 1 else ""
        # What is equal at two frames that follow each other is solved for once.
        earlier, known = known, {}
        meshes = _digest(b"", made.files)
        solution = None
        for light in _lights(made):
            label = prefix + light.name

            def watch(_part: int, _parts: int, phase: str) -> None:
                report(done, total, f"{label}: {phase}")

            watch(0, 0, "meshes")
            text = _json(_document(made, options) | light.tables)
            digest = _digest(text.encode() + meshes, light.files)
            lit = earlier.get(digest)
            if lit is None:
                content = {"is_total": True, "reflection": True, "irradiance": True, "lightmap": None}
                content["spectrum"] = not light.is_image
                with _names_of_blender(made):
                    scene = _native.Scene.from_json(text, files, ".") if scene is None else scene.with_json(text)
                    parts = scene.bake(options.step_mm, content, None, watch)[1:]
                lit = list(map(light.lit, parts))
            known[digest] = lit
            solution = solution or Solution([one.baked for one in lit], [one.reflection for one in lit])
            for snow, one, other in zip(made.names, solution.objects, lit):
                if not np.array_equal(one.positions, other.baked.positions):
                    raise ValueError(f"the meshes of '{snow}' differ between lamps: give a Step")
            _add(solution.fluxes, max(light.key, WORLD), [one.flux for one in lit])
            if light.key > WORLD:
                _put_lamp(solution.irradiances, light.key, lit)
            else:
                is_sun = light.key < WORLD
                _add(solution.irradiances, WORLD, [one.diffuse if is_sun else one.direct + one.diffuse for one in lit])
                if is_sun:
                    solution.irradiances[light.key] = [one.direct for one in lit]
            done += 1
        solutions.append(solution)
    report(total, total, "")
    return solutions


def _lights(made: Collected) -> list[_Light]:
    lights = [_Light(lamp.uid, f"lamp '{lamp.name}'", {"light": lamp.lights}) for lamp in made.lamps]
    suns = iter(made.suns)
    for one in made.skylight:
        key = WORLD if one.to_sun is None else next(suns)
        lights.append(_Light(key, "the World", {"light": []} | one.tables, one.files, one.is_image))
    return lights


def _document(made: Collected, options: Options) -> dict[str, Any]:
    document: dict[str, Any] = {
        "integrator": {"type": "diffusion", "max_bounces": options.max_bounces},
        "material": made.materials,
        "object": made.objects,
    }
    if options.field_step_mm is not None:
        document["light_field"] = {"step_mm": options.field_step_mm}
    return document


def _digest(start: bytes, files: dict[str, bytes]) -> bytes:
    digest = hashlib.sha256(start)
    for name, content in files.items():
        digest.update(name.encode() + hashlib.sha256(content).digest())
    return digest.digest()


@contextmanager
def _names_of_blender(made: Collected) -> Iterator[None]:
    """Errors name objects as Blender does."""
    try:
        yield
    except ValueError as error:
        reason = str(error)
        for number, name in enumerate(made.names):
            reason = reason.replace(f"object[{number}]", f"'{name}'")
        raise ValueError(reason) from None
