"""Tables of curves: the embedded one, files, and tables of one's own."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from snowblue import _native
from snowblue._arguments import (
    ANGLE,
    SUBSTANCES,
    THICKNESS,
    WAVELENGTH,
    Axes,
    Quantity,
    Wavelengths,
    angles,
    attributes,
    check_engine,
    checks_names,
    impurities,
    numbers,
    ordinates,
    slab_argument,
    suggestion,
    wavelength_coordinate,
    whole,
)
from snowblue._blocks import Labelled, dataset, in_blocks
from snowblue._progress import Progress, reporting

if TYPE_CHECKING:
    import xarray as xr

PRESETS = Literal["paper", "default", "fine", "infrared"]
MOST_TALLY_RAYS = 1 << 20
LOOKED_UP_SNOW = {"grain_size": "grain_size_um", "facetness": "facetness", "density": "density_kg_m3"}
"""Arguments of a look-up that all tables have, by the names of their axes."""
PROPERTIES = ("water_saturation", "temperature", *(name.replace("-", "_") for name in SUBSTANCES))
"""Further axes of tables."""
BEAM = replace(ANGLE)
"""The angle of a beam. Look-ups have no diffuse light."""


class Database:
    """Curves of transmittance and reflectance on axes of snow, angle and thickness, full or compressed."""

    def __init__(self, table: _native.Table) -> None:
        self._table = table

    @classmethod
    def open(cls, path: str | PathLike[str]) -> Database:
        """Reads a table from a NetCDF file."""
        return cls(_native.Table.open(existing(path)))

    @classmethod
    def embedded(cls) -> Database:
        """The compressed table of the package."""
        return cls(_native.Table.embedded())

    @classmethod
    @checks_names()
    def build(
        cls,
        *,
        preset: PRESETS = "paper",
        grain_size_um: Any = None,
        facetness: Any = None,
        density_kg_m3: Any = None,
        thickness_cm: Any = None,
        angle_deg: Any = None,
        wavelength_nm: Any = None,
        water_saturation: Any = None,
        temperature_c: Any = None,
        impurities_ng_g: Mapping[str, Any] | None = None,
        engine: Literal["ordinates", "montecarlo"] = "ordinates",
        streams: int | str = "auto",
        tally_rays: int = MOST_TALLY_RAYS,
        rays: int = 100_000,
        seed: int = 1,
        ice: str = "warren2008",
        progress: Progress = None,
    ) -> Database:
        """Computes a full table. Axes that are not given are those of the preset, by default the paper's."""
        check_engine(engine)
        properties: dict[str, Any] = {"water_saturation": water_saturation, "temperature": temperature_c}
        properties |= {name.replace("-", "_"): values for name, values in impurities(impurities_ng_g).items()}
        axes = {
            "preset": preset,
            "grain_size_um": _axis("grain_size", grain_size_um),
            "facetness": _axis("facetness", facetness),
            "density_kg_m3": _axis("density", density_kg_m3),
            "thickness_cm": _axis("thickness", thickness_cm),
            "angle_deg": None if angle_deg is None else angles(angle_deg),
            "wavelength_nm": _axis("wavelength", wavelength_nm),
            "properties": [(name, _axis(name, values)) for name, values in properties.items() if values is not None],
        }
        filling = {
            "ordinates": ordinates(streams, seed),
            "tally_rays": whole("tally_rays", tally_rays),
            "rays": whole("rays", rays, 2) if engine == "montecarlo" else None,
            "ice": ice,
        }
        with reporting(progress, "steps") as report:
            return cls(_native.Table.build(axes, filling, report))

    def __getstate__(self) -> bytes:
        """The bytes of its file, for pickle."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "table.nc"
            self.write(path)
            return path.read_bytes()

    def __setstate__(self, state: bytes) -> None:
        self._table = _native.Table.from_bytes(state)

    @property
    def kind(self) -> str:
        """What it is, in words."""
        return self._table.kind

    @property
    def components(self) -> int | None:
        """Number of principal components; None for a full table."""
        return self._table.components

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """The values of each axis. An angle of -1 is diffuse light."""
        return {name: np.array(values) for name, _, values in self._table.axis_values}

    @property
    def metadata(self) -> dict[str, str]:
        """Provenance."""
        return dict(sorted(self._table.metadata.items()))

    def __len__(self) -> int:
        return self._table.curves

    def __repr__(self) -> str:
        axes = ", ".join(f"{name}: {len(values)}" for name, values in self.axes.items())
        return f"<snowblue.Database: {self.kind} of {len(self)} curves ({axes})>"

    @checks_names()
    def compress(
        self,
        *,
        space: Literal["log", "linear"] = "log",
        components: int | None = None,
        max_delta_e: float | None = None,
        max_rmse: float | None = None,
        illuminants: tuple[str, ...] = ("D65",),
    ) -> Database:
        """The full table in terms of principal components: their number, or as many as the greatest errors need."""
        if components is None and max_delta_e is None and max_rmse is None:
            raise TypeError("give components, max_delta_e or max_rmse")
        wanted = {"space": space, "components": components, "max_delta_e": max_delta_e, "max_rmse": max_rmse}
        return Database(self._table.compress({**wanted, "illuminants": list(illuminants)}))

    def write(self, path: str | PathLike[str]) -> None:
        """Writes the table as NetCDF, which :func:`xarray.open_dataset` reads."""
        self._table.write(fspath(path))

    def look_up(
        self,
        *,
        thickness_cm: Any,
        angle_deg: Any = 0.0,
        grain_size_um: Any = 400.0,
        facetness: Any = 0.3,
        density_kg_m3: Any = 300.0,
        **properties: Any,
    ) -> xr.Dataset:
        """Interpolates the curves of a compressed table.

        Arguments are broadcast as those of :func:`snowblue.spectrum`: lists and arrays make axes of the result, and
        :class:`xarray.DataArray` arguments that share a dimension are paired along it. If one is of dask, the result
        is computed by blocks, when it is asked for. Further properties are axes of the table: `water_saturation`,
        `temperature`, `black_carbon` and so on. Values are single precision, as in a rendering.
        """
        for name in properties:
            if name not in PROPERTIES:
                raise ValueError(f"property {name!r} is not known; {suggestion(name, PROPERTIES)}")
        units = {name: unit for name, unit, _ in self._table.axis_values}
        axes = Axes()
        given = {"grain_size": grain_size_um, "facetness": facetness, "density": density_kg_m3, **properties}
        columns = {
            name: slab_argument(Quantity(name, units.get(name)), value, axes, always=False)
            for name, value in given.items()
        }
        snow_axes = Axes(dict(axes.sizes))
        light = [slab_argument(THICKNESS, thickness_cm, axes), slab_argument(BEAM, angle_deg, axes)]
        fixed = {name: values[0] for name, (values, dims) in columns.items() if not dims}
        wavelengths_nm = self.axes["wavelength"].tolist()
        sizes = {**axes.sizes, WAVELENGTH.name: len(wavelengths_nm)}
        # Without snow a table says which curves it has, or that it has no look-ups.
        found = self._table.look_up([], [], [])
        if axes.are_lazy:
            import dask

            # Workers get the table once.
            options = {"table": dask.delayed(self, traverse=False), "fixed": fixed}
            found = in_blocks(_looked_up, axes.arrays, sizes, dict.fromkeys(found, ({}, np.float32)), **options)
        else:
            rows = ([values[place] for place in snow_axes.places(dims)] for values, dims in columns.values())
            found = self._curves([dict(zip(columns, row)) for row in zip(*rows)], tuple(snow_axes.sizes), light, axes)
        variables = {
            name: ([*sizes], array.reshape([*sizes.values()]), {"units": "1", "long_name": name})
            for name, array in found.items()
        }
        own = wavelength_coordinate(wavelengths_nm)
        coords = axes.coordinates(Wavelengths(wavelengths_nm, WAVELENGTH.name, own, {}))
        return dataset(variables, coords, attributes(**fixed, table=self.kind))

    def _curves(
        self,
        snows: list[dict[str, float]],
        snow_dims: tuple[str, ...],
        light: list[tuple[list[float], tuple[str, ...]]],
        axes: Axes,
    ) -> dict[str, np.ndarray]:
        """The curves of some snows under some light, which has thicknesses and angles, for each element of the axes."""
        samples = []
        for snow in snows:
            *main, properties = *(snow.pop(name) for name in LOOKED_UP_SNOW), snow
            samples.append(dict(zip(LOOKED_UP_SNOW.values(), main)) | {"properties": properties})
        (thicknesses_cm, thickness_dims), (angles_deg, angle_dims) = light
        dims = (*snow_dims, *thickness_dims, *angle_dims)
        if len({*dims}) == len(dims):
            try:
                return self._table.look_up(samples, thicknesses_cm, angles_deg)
            except ValueError:
                # Each element alone says where the error is.
                if len(axes.places(())) == 1:
                    raise
        places = zip(*(axes.places(own).tolist() for own in (snow_dims, thickness_dims, angle_dims)))
        curves = []
        with axes.locating_errors():
            for row, (snow, thickness, angle) in enumerate(places):
                try:
                    one = self._table.look_up([samples[snow]], [thicknesses_cm[thickness]], [angles_deg[angle]])
                except ValueError as error:
                    raise ValueError(str(error), row) from None
                curves.append(one)
        return {name: np.concatenate([one[name] for one in curves]) for name in curves[0]}

    def fidelity(
        self, *, space: Literal["log", "linear"] = "log", components: int = 4, illuminant: str = "D65"
    ) -> xr.Dataset:
        """The errors of 1 to `components` principal components over all curves of a full table."""
        import xarray as xr

        rows = self._table.fidelity(space, whole("components", components, 1), illuminant)
        names = [name for name in rows[0] if name not in ("quantity", "components")]
        values = {name: np.array([row[name] for row in rows]).reshape(2, components) for name in names}
        coords = {"quantity": ["transmittance", "reflectance"], "components": np.arange(1, components + 1)}
        variables = {name: (("quantity", "components"), array) for name, array in values.items()}
        return xr.Dataset(variables, coords, attributes(space=space, illuminant=illuminant))

    def to_xarray(self) -> xr.Dataset:
        """All curves; those of a compressed table are rebuilt."""
        import xarray as xr

        axes = self._table.axis_values
        dims, shape = [name for name, _, _ in axes], [len(values) for _, _, values in axes]
        coords: dict[str, Any] = {
            name: (name, values, Quantity(name, unit).attributes()) for name, unit, values in axes
        }
        coords["wavelength"] = wavelength_coordinate(list(self.axes["wavelength"]))
        if -1.0 in self.axes.get("angle", ()):
            coords["angle"][2].update(flag_values=-1.0, flag_meanings="diffuse")
        variables = {
            name: (dims, array.reshape(shape), {"units": "1", "long_name": name.replace("_se", " standard error")})
            for name, array in self._table.values().items()
        }
        return xr.Dataset(variables, coords, attributes(**self.metadata))


def _looked_up(arrays: Mapping[str, Labelled], table: Database, fixed: Mapping[str, float]) -> dict[str, Any]:
    """The curves of some snows."""
    import xarray as xr

    names = {**LOOKED_UP_SNOW, THICKNESS.name: "thickness_cm", ANGLE.name: "angle_deg"}
    given = {name: xr.DataArray(values, dims=dims) for name, (dims, values) in arrays.items()} | fixed
    solved = table.look_up(**{names.get(name, name): value for name, value in given.items()})
    return {name: variable.values for name, variable in solved.data_vars.items()}


def _axis(name: str, values: Any) -> list[float] | None:
    return None if values is None else numbers(Quantity(name), values)


def existing(path: str | PathLike[str]) -> str:
    if not Path(path).exists():
        raise FileNotFoundError(f"{fspath(path)}: there is no such file")
    return fspath(path)
