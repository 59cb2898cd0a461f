"""Bars for work that takes long."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Progress = bool | Callable[[int, int], object] | None
"""False for none, a function of what is done and of all, or None for a bar by tqdm if that is installed."""

PhaseProgress = bool | Callable[[int, int, str], object] | None
"""The same for work with phases, whose function also gets the name of the present phase. Its steps are 0 of 0 while
their number is not known."""

DELAY_S = 1.0


@contextmanager
def reporting(progress: Any, unit: str = "it") -> Iterator[Any]:
    """None, the given function, or one that shows the progress of some work by a bar."""
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise ValueError(f"progress is {progress!r}, but must be True, False or a function")
    if progress is False or callable(progress):
        yield progress or None
        return
    try:
        from tqdm.auto import tqdm
    except ImportError:
        yield None
        return

    def show(done: int, total: int, phase: str | None = None) -> None:
        nonlocal last
        if phase != last:
            last = phase
            bar.reset(total or None)
            bar.set_description(phase, refresh=False)
        bar.total = total or None
        bar.update(done - bar.n)

    last = None
    # Without a terminal or notebook tqdm shows nothing: disable=None.
    with tqdm(delay=DELAY_S, unit=f" {unit}", unit_scale=True, disable=None, leave=False) as bar:
        yield show
