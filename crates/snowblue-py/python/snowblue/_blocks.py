"""Arrays of dask: results that are computed by blocks, when their values are asked for."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

Labelled = tuple[Sequence[str], Any]
"""The dimensions of an array, and the array."""

_origin: ContextVar[Mapping[str, int]] = ContextVar("origin", default={})


def is_lazy(value: Any) -> bool:
    """Whether a value is an array of dask, or one of xarray with such values."""
    graph = getattr(value, "__dask_graph__", None)
    return getattr(value, "chunks", None) is not None and callable(graph) and graph() is not None


def origin() -> Mapping[str, int]:
    """The place of the present block in the whole result, for the indices in messages."""
    return _origin.get()


@contextmanager
def _beginning(place: Mapping[str, int]) -> Iterator[None]:
    token = _origin.set(place)
    try:
        yield
    finally:
        _origin.reset(token)


def in_blocks(
    solve: Callable[..., Mapping[str, Any]],
    arrays: Mapping[str, Labelled],
    sizes: Mapping[str, int],
    outputs: Mapping[str, tuple[Mapping[str, int], Any]],
    **options: Any,
) -> dict[str, Any]:
    """The results of a function as arrays of dask, one block for each combination of the chunks of its arguments.

    The function gets `arrays` with the values of a block, and `options`. The arrays share the dimensions of `sizes`,
    along which the results are divided; an argument is whole along others. `outputs` has, for each array that the
    function gives, its further dimensions with their sizes, and its type.
    """
    import dask.array as da

    pairs = []
    for dims, array in arrays.values():
        pairs += [array if is_lazy(array) else da.from_array(array, chunks=-1), tuple(dims)]
    chunks, _ = da.core.unify_chunks(*pairs)
    numbered = [dim for dim, size in sizes.items() if size > 1 and dim in chunks]
    for dim in numbered:
        pairs += [da.arange(sizes[dim], chunks=(chunks[dim],)), (dim,)]
    dims = tuple(sizes)
    blocks = da.blockwise(
        functools.partial(_solved, solve, {name: tuple(dims) for name, (dims, _) in arrays.items()}, numbered),
        dims,
        *pairs,
        new_axes={dim: size for dim, size in sizes.items() if dim not in chunks},
        concatenate=True,
        dtype=object,
        meta=np.empty([0] * len(dims), dtype=object),
        **options,
    )
    return {
        name: da.blockwise(
            _picked,
            (*dims, *more),
            blocks,
            dims,
            new_axes=dict(more),
            dtype=dtype,
            meta=np.empty([0] * (len(dims) + len(more)), dtype=dtype),
            key=name,
        )
        for name, (more, dtype) in outputs.items()
    }


def _solved(
    solve: Callable[..., Any],
    arrays: Mapping[str, tuple[str, ...]],
    numbered: Sequence[str],
    *blocks: np.ndarray,
    **options: Any,
) -> Any:
    """The results of a block, by their names."""
    places = {dim: int(numbers[0]) for dim, numbers in zip(numbered, blocks[len(arrays) :])}
    with _beginning(places):
        return solve({name: (dims, block) for (name, dims), block in zip(arrays.items(), blocks)}, **options)


def _picked(block: Mapping[str, Any], key: str) -> Any:
    return block[key]


def dataset(variables: Mapping[str, Any], coords: Mapping[str, Any], attrs: Mapping[str, Any]) -> xr.Dataset:
    """A dataset, with coordinates that are arrays or tuples. Labels that are not known yet make no index."""
    import xarray as xr

    unknown = {}
    for name, coordinate in coords.items():
        dims, values = (coordinate[0], coordinate[1]) if isinstance(coordinate, tuple) else ((), None)
        if tuple(np.atleast_1d(dims)) == (name,) and is_lazy(values):
            unknown[name] = xr.Variable(*coordinate)
    solved = xr.Dataset(variables, {name: one for name, one in coords.items() if name not in unknown}, attrs)
    return solved.assign_coords(xr.Coordinates(unknown, indexes={})) if unknown else solved
