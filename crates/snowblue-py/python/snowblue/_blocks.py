"""Functions of rows of arguments: xarray broadcasts the arguments, and divides those of dask into blocks."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

OWN: dict[str, Callable[[], Any]] = {}
"""For each impurity that is not built in, a function that declares it in another process."""

Solve = Callable[..., Mapping[str, tuple[Sequence[str], np.ndarray]]]
"""A function of the values of each argument, row by row, that gives arrays by their names: the dimensions after that
of the rows, and the array. A ValueError may have the number of a row after its message, and the number of a wavelength
or band."""


def is_lazy(value: Any) -> bool:
    """Whether a value is an array of dask, or one of xarray with such values."""
    graph = getattr(value, "__dask_graph__", None)
    return getattr(value, "chunks", None) is not None and callable(graph) and graph() is not None


def no_rows(arrays: Mapping[str, xr.DataArray], inner: Sequence[str] = ()) -> dict[str, np.ndarray]:
    """The arguments of a function of rows if there are none. A row has the dimensions `inner`."""
    return {
        name: np.empty([0, *(array.sizes[dim] for dim in inner if dim in array.dims)], array.dtype)
        for name, array in arrays.items()
    }


def in_blocks(
    solve: Solve,
    arrays: Mapping[str, xr.DataArray],
    sizes: Mapping[str, int],
    *,
    inner: Sequence[str] = (),
    bands: Sequence[str] | None = None,
    gaps: Sequence[str] = (),
    **shared: Any,
) -> dict[str, xr.Variable]:
    """What a function gives for each element of the dimensions `sizes`, at once or, of arrays of dask, by blocks.

    An array is broadcast to these dimensions, and whole along those of `inner`. Where an array among `gaps` is NaN, so
    are the results; whole numbers are 0 and words are empty there. First the function is called without
    rows: it checks its options, and says what it gives. `shared` are further arguments, which workers get once.
    """
    import xarray as xr

    is_later = any(map(is_lazy, arrays.values()))
    outputs = solve(no_rows(arrays, inner), **shared)
    places = [xr.Variable(dim, np.arange(size)) for dim, size in sizes.items()]
    cores = [[dim for dim in inner if dim in array.dims] for array in arrays.values()]
    values = [array.variable for array in arrays.values()]
    options: dict[str, Any] = {}
    if is_later:
        import dask

        places = [place.chunk() for place in places]
        values = [value.chunk(dict.fromkeys(core, -1)) for value, core in zip(values, cores)]
        options = {name: dask.delayed(value, traverse=False) for name, value in shared.items()}
        options["output_sizes"] = {}
        for dims, array in outputs.values():
            options["output_sizes"] |= dict(zip(dims, array.shape[1:]))
    found = xr.apply_ufunc(
        functools.partial(
            _solved, [*OWN.values()], solve, dict(zip(arrays, map(len, cores))), dict(sizes), bands, gaps),
        *places,
        *values,
        input_core_dims=[[] for _ in places] + cores,
        output_core_dims=[dims for dims, _ in outputs.values()],
        kwargs=None if is_later else shared,
        keep_attrs=False,
        dask="parallelized",
        dask_gufunc_kwargs=options,
        output_dtypes=[array.dtype for _, array in outputs.values()],
    )
    return dict(zip(outputs, found if len(outputs) > 1 else [found]))


def _solved(
    own: Sequence[Callable[[], Any]],
    solve: Solve,
    inner: Mapping[str, int],
    sizes: Mapping[str, int],
    bands: Sequence[str] | None,
    gaps: Sequence[str],
    *blocks: np.ndarray,
    **shared: Any,
) -> Any:
    """The results of a block, of places along the dimensions `sizes` and arrays, which have inner dimensions."""
    for declare in own:
        declare()
    places = blocks[: len(sizes)]
    shape = np.broadcast_shapes(*(place.shape for place in places))
    rows = {}
    for (name, count), block in zip(inner.items(), blocks[len(sizes) :]):
        own = block.shape[block.ndim - count :]
        rows[name] = np.broadcast_to(block, shape + own).reshape(-1, *own)
    known = np.ones(int(np.prod(shape)), bool)
    for name in gaps:
        known &= (rows[name] == rows[name]).reshape(known.size, -1).all(axis=1)
    rows = rows if known.all() else {name: values[known] for name, values in rows.items()}
    try:
        found = [filled(array, known).reshape(shape + array.shape[1:]) for _, array in solve(rows, **shared).values()]
    except ValueError as error:
        if len(error.args) == 1:
            raise
        message, row, *channel = error.args
        row = np.flatnonzero(known)[row]
        indices = zip(sizes.items(), places, np.unravel_index(row, shape) if shape else ())
        at = [f"{dim}[{place.flat[0] + index}]" for (dim, size), place, index in indices if size > 1]
        at += [] if bands else [f"wavelength[{place}]" for place in channel]
        message += f", at {', '.join(at)}" if at else ""
        message += f", in the band {bands[channel[0]]}" if bands and channel else ""
        raise ValueError(message) from None
    return tuple(found) if len(found) > 1 else found[0]


def filled(array: np.ndarray, known: np.ndarray) -> np.ndarray:
    """The results of known rows, among all rows."""
    if known.all():
        return array
    filled = np.full((known.size, *array.shape[1:]), np.nan if array.dtype.kind == "f" else 0, array.dtype)
    if array.dtype.kind == "U":
        filled[:] = ""
    filled[known] = array
    return filled


def dataset(variables: Mapping[str, Any], coords: Mapping[str, Any], attrs: Mapping[str, Any]) -> xr.Dataset:
    """A dataset. Labels that are not known yet make no index."""
    import xarray as xr

    unknown = {name: one for name, one in coords.items() if getattr(one, "dims", ()) == (name,) and is_lazy(one)}
    solved = xr.Dataset(variables, {name: one for name, one in coords.items() if name not in unknown}, attrs)
    return solved.assign_coords(xr.Coordinates(unknown, indexes={})) if unknown else solved
