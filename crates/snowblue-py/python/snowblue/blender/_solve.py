"""The light in snow, lamp by lamp. Nothing here reads or changes data of Blender, so that a thread may do it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from snowblue import _native
from snowblue._renderers import _rgb
from snowblue._scene import BakedObject, _baked, _json
from snowblue.blender._collect import Collected

WORLD = 0
"""What stands for the World among the identifiers of lamps."""
LONGEST_PHASE = "light"
"""The phase of a solution that takes nearly all of the time."""

Report = Callable[[float, int, str], object]
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
    fluxes: dict[int, list[np.ndarray]] = field(default_factory=dict)
    """J on each object, (n, 3), by each lamp and the World."""


def solve(frames: list[Collected], options: Options, report: Report) -> list[Solution]:
    """The light at some frames.

    Raises
    ------
    ValueError
        If the snow cannot be solved for.
    """
    total = sum(len(made.lamps) + len(made.skylight) for made in frames)
    done = 0
    known: dict[bytes, list[BakedObject]] = {}
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
        for key, name, tables, own_files, is_image in _lights(made):
            label = prefix + name

            def watch(part: int, parts: int, phase: str) -> None:
                share = part / parts if phase == LONGEST_PHASE and parts else 0.0
                report(done + share, total, f"{label}: {phase}")

            watch(0, 0, "meshes")
            text = _json(_document(made, options) | tables)
            digest = _digest(text.encode() + meshes, own_files)
            objects = earlier.get(digest)
            if objects is None:
                # The spectrum of an image is made of its colours, so that its flux is a colour.
                content = {"spectrum": not is_image, "is_total": True, "reflection": False, "lightmap": None}
                with _names_of_blender(made):
                    scene = _native.Scene.from_json(text, files, ".") if scene is None else scene.with_json(text)
                    objects = [_baked(one, []) for one in scene.bake(options.step_mm, content, None, watch)[1:]]
            known[digest] = objects
            solution = solution or Solution(objects)
            for snow, one, other in zip(made.names, solution.objects, objects):
                if not np.array_equal(one.positions, other.positions):
                    raise ValueError(f"the meshes of '{snow}' differ between lamps: give a Step")
            fluxes = [one.flux[0] if is_image else _rgb(one.flux[0]) for one in objects]
            parts = solution.fluxes.get(key)
            solution.fluxes[key] = fluxes if parts is None else [one + other for one, other in zip(parts, fluxes)]
            done += 1
        solutions.append(solution)
    report(total, total, "")
    return solutions


def _lights(made: Collected) -> list[tuple[int, str, dict[str, Any], dict[str, bytes], bool]]:
    """What is solved for alone: an identifier, a name, tables and files of a scene, and whether it is an image."""
    lights = [(lamp.uid, f"lamp '{lamp.name}'", {"light": lamp.lights}, {}, False) for lamp in made.lamps]
    return lights + [(WORLD, "the World", {"light": []} | one.tables, one.files, one.is_image) for one in made.skylight]


def _document(made: Collected, options: Options) -> dict[str, Any]:
    document: dict[str, Any] = {
        "camera": {"position": [0, -1, 0], "look_at": [0, 0, 0]},
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
