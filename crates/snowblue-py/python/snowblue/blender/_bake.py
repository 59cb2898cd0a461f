"""Bakes the light in the snow of a scene: at once, or step by step while Blender goes on."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence

import bpy

from snowblue.blender._collect import Collected, collect, request_of, unchanged_snow
from snowblue.blender._put import put, remove_baked
from snowblue.blender._settings import baked_of, source_of
from snowblue.blender._solve import Options, Solution, solve


def bake(
    scene: bpy.types.Scene | None = None,
    objects: Iterable[bpy.types.Object] | None = None,
    *,
    frames: Sequence[int] | None = None,
    step_mm: float | None = None,
    field_step_mm: float | None = None,
    max_bounces: int = 8,
    progress: Callable[[int, int], object] | None = None,
) -> list[bpy.types.Object]:
    """Solves for the light in snow and makes a baked object of each object of snow.

    The light of each lamp, and that of the World, is solved for by itself, with what comes by way of other surfaces.
    The baked object lies exactly on the original, which is hidden and kept. Its points have the net flux J outwards by
    a lamp of the energy 1 as the attributes `snow_lamp_0`, `snow_lamp_1` …, and that by the World as `snow_sky`; its
    material reads the energy and the colour of the lamps, so that these can change afterwards. Further attributes, such
    as `snow_lamp_0_irradiance`, and properties, such as `snow_lamp_0_place`, say how much light of each lamp falls on a
    point and from where.

    Parameters
    ----------
    scene : bpy.types.Scene, optional
        By default that of the context.
    objects : iterable, optional
        Objects of snow, or what was baked of them; by default all snow of the scene. Other snow of the scene takes
        part in the solution.
    frames : sequence of int, optional
        Frames at equal distances, such as `range(1, 25)`. The baked object then has a mesh for each, and a modifier of
        geometry nodes that shows that of the frame. By default the light is that of the present frame.
    step_mm : float, optional
        Greatest length of an edge of the baked meshes; by default twice the cells in the snow.
    field_step_mm : float, optional
        Size of the cells in the snow at its surface; by default it follows from the size and the kind of the snow.
    max_bounces : int
        Number of surfaces over which light is followed before it enters the snow.
    progress : callable, optional
        Called with the number of solutions that are done, and of all.

    Returns
    -------
    list of bpy.types.Object
        The baked objects.

    Raises
    ------
    ValueError
        If there is no snow or no lamp, an object is not a closed mesh, or a lamp is of an unknown kind.
    """
    job = BakeJob(scene or bpy.context.scene, objects, Options(step_mm, field_step_mm, max_bounces), frames)
    while not job.is_collected:
        job.collect()
    job.solve((lambda done, total, _: progress(done, total)) if progress is not None else None)
    return job.finish()


def clear(scene: bpy.types.Scene | None = None, objects: Iterable[bpy.types.Object] | None = None) -> int:
    """Removes the baked objects of a scene, or of some objects, and shows the originals.

    Returns the number of baked objects removed.
    """
    scene = scene or bpy.context.scene
    sources = [source_of(one) for one in (scene.objects if objects is None else objects)]
    count = 0
    for source in dict.fromkeys(sources):
        baked = baked_of(source)
        if baked is not None:
            remove_baked(baked)
            count += 1
    return count


class Stopped(Exception):
    """The bake was stopped."""


class BakeJob:
    """A bake in steps. Only its solution may run on another thread: all else reads or changes data of Blender.

    `collect` until `is_collected`, then `start` and wait until `is_done`, then `finish`. `stop` may come at any time.
    """

    def __init__(
        self,
        scene: bpy.types.Scene,
        objects: Iterable[bpy.types.Object] | None,
        options: Options,
        frames: Sequence[int] | None = None,
    ) -> None:
        if frames is not None:
            _check_frames(frames)
        self._request = request_of(scene, objects)
        self._options = options
        self._frames: list[int | None] = [None] if frames is None else list(frames)
        self._collected: list[Collected] = []
        self._solutions: list[Solution] = []
        self._error: BaseException | None = None
        self._thread: threading.Thread | None = None
        self._stopping = threading.Event()
        self._progress: tuple[float, str] = (0.0, "")

    @property
    def is_collected(self) -> bool:
        """Whether all frames of the scene are read."""
        return len(self._collected) == len(self._frames)

    def collect(self) -> None:
        """Reads the scene at the next frame.

        Raises
        ------
        ValueError
            If it cannot be baked.
        """
        count = len(self._collected)
        earlier = self._collected[-1] if self._collected else None
        self._collected.append(collect(self._request, self._frames[count], earlier))
        self._progress = (count + 1) / len(self._frames), f"read frame {self._collected[-1].frame}"

    def start(self) -> None:
        """Begins to solve for the light on another thread."""
        # A thread of its own must not keep Blender from closing.
        self._thread = threading.Thread(target=self._run, name="snowblue bake", daemon=True)
        self._thread.start()

    def solve(self, report: Callable[[float, int, str], object] | None = None) -> None:
        """Solves for the light."""

        def watch(done: float, total: int, label: str) -> None:
            if self._stopping.is_set():
                raise Stopped
            self._progress = done / total, label
            if report is not None:
                report(done, total, label)

        self._solutions = solve(self._collected, self._options, watch)

    def _run(self) -> None:
        try:
            self.solve()
        except BaseException as error:
            # `finish` raises it on the thread of Blender, a panic of Rust too.
            self._error = error

    @property
    def frame_count(self) -> int:
        """The number of frames."""
        return len(self._frames)

    @property
    def is_stopping(self) -> bool:
        """Whether it was stopped."""
        return self._stopping.is_set()

    @property
    def is_done(self) -> bool:
        """Whether there is no more to wait for: the solution has ended, by itself, by an error or by `stop`."""
        return not self._thread.is_alive() if self._thread is not None else self.is_stopping

    @property
    def progress(self) -> tuple[float, str]:
        """What part of the work is done, and what is being done."""
        return self._progress

    def stop(self, *, waits: bool = False) -> None:
        """Ends the solution, at its next report. Nothing of it stays."""
        self._stopping.set()
        if waits and self._thread is not None:
            self._thread.join()

    @property
    def is_solved(self) -> bool:
        """Whether there is a solution, of which `finish` makes baked objects."""
        return bool(self._solutions) and not self.is_stopping

    def wait(self, reason: str) -> None:
        """Shows in the progress what the end of the bake waits for."""
        self._progress = self._progress[0], reason

    def finish(self) -> list[bpy.types.Object]:
        """Makes the baked objects of a solution.

        Raises
        ------
        Stopped
            If it was stopped.
        ValueError
            If the snow could not be solved for, or all of it was changed or removed meanwhile.
        """
        if self._stopping.is_set():
            raise Stopped
        if self._error is not None:
            raise self._error
        targets = self._request.targets
        if self._thread is not None:
            targets = unchanged_snow(self._request, self._collected[0])
        return put(self._collected, self._solutions, targets)


def _check_frames(frames: Sequence[int]) -> None:
    """Refuses frames that are not at equal distances."""
    steps = {later - earlier for earlier, later in zip(frames, frames[1:])}
    if not len(frames) or len(steps) > 1 or min(steps, default=1) < 1:
        raise ValueError("the frames of a bake must be one or more, upwards and at equal distances: use a range")
