"""Tables of curves: the embedded one, files, and tables of one's own."""

from __future__ import annotations

import itertools
import math
import tempfile
from collections.abc import Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from snowblue import _native
from snowblue._arguments import (
    ANGLE,
    BEAM,
    DIFFUSE_DEG,
    DIFFUSE_FLAG,
    SUBSTANCES,
    THICKNESS,
    WAVELENGTH,
    Axes,
    Quantity,
    angle,
    angles_or_diffuse,
    attributes,
    axis,
    check_engine,
    checks_names,
    impurities,
    ordinates,
    own_axis,
    suggestion,
    whole,
)
from snowblue._blocks import dataset, in_blocks
from snowblue._progress import Progress, reporting

if TYPE_CHECKING:
    import xarray as xr

PRESETS = Literal["paper", "default", "fine", "infrared"]
MOST_TALLY_RAYS = 1 << 20
LOOKED_UP_SNOW = {"grain_size": "grain_size_um", "facetness": "facetness", "density": "density_kg_m3"}
"""Arguments of a look-up that all tables have, by the names of their axes."""
PROPERTIES = (
    *(name for _, name, *_ in _native.properties() if name not in (*LOOKED_UP_SNOW, "ssa", "sphericity")),
    *(name.replace("-", "_") for name in SUBSTANCES),
)
"""Further axes of tables."""


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
            "angle_deg": None if angle_deg is None else angles_or_diffuse(own_axis(ANGLE, angle_deg, angle)),
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
        axes = Axes()
        units = {name: unit for name, unit, _ in self._table.axis_values}
        given = {"grain_size": grain_size_um, "facetness": facetness, "density": density_kg_m3, **properties}
        for name, value in given.items():
            axes.add(name, Quantity(name, units.get(name)), value)
        axes.add("thickness_cm", THICKNESS, thickness_cm, always=True)
        axes.add("angle_deg", BEAM, angle_deg, always=True)
        variables = in_blocks(_looked_up, axes.arrays, axes.sizes, gaps=axes.gaps, table=self)
        for name, variable in variables.items():
            variable.attrs = {"units": "1", "long_name": name}
        wavelength = axis(WAVELENGTH, self.axes["wavelength"])
        coords = {**axes.coordinates(wavelength), "wavelength": wavelength.variable}
        fixed = {name: axes.arrays[name].item() for name in given if axes.arrays[name].ndim == 0}
        return dataset(variables, coords, attributes(**fixed, table=self.kind))

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
        coords["wavelength"] = own_axis(WAVELENGTH, self.axes["wavelength"])
        if DIFFUSE_DEG in self.axes.get("angle", ()):
            coords["angle"][2].update(DIFFUSE_FLAG)
        variables = {
            name: (dims, array.reshape(shape), {"units": "1", "long_name": name.replace("_se", " standard error")})
            for name, array in self._table.values().items()
        }
        return xr.Dataset(variables, coords, attributes(**self.metadata))


def _looked_up(rows: Mapping[str, np.ndarray], table: Database) -> dict[str, Any]:
    """The curves of some snows under some light."""
    columns = {name: values.tolist() for name, values in rows.items()}
    thicknesses_cm, angles_deg = columns.pop("thickness_cm"), columns.pop("angle_deg")
    cases = list(zip(zip(*columns.values()), thicknesses_cm, angles_deg))
    distinct = [list(dict.fromkeys(one)) for one in (zip(*cases) if cases else ([], [], []))]

    def curves(snows: list[tuple[float, ...]], *light: list[float]) -> dict[str, np.ndarray]:
        properties = [dict(zip(columns, values)) for values in snows]
        samples = [{key: one.pop(name) for name, key in LOOKED_UP_SNOW.items()} for one in properties]
        samples = [sample | {"properties": one} for sample, one in zip(samples, properties)]
        # Without snow a table says which curves it has, or that it has no look-ups.
        found = table._table.look_up(samples, *light)
        return {name: values.reshape(-1, len(table.axes["wavelength"])) for name, values in found.items()}

    if math.prod(map(len, distinct)) == len(cases):
        # All snows are under the same light.
        numbers = {case: number for number, case in enumerate(itertools.product(*distinct))}
        try:
            places = [numbers[case] for case in cases]
            return {name: ((WAVELENGTH.name,), values[places]) for name, values in curves(*distinct).items()}
        except ValueError:
            # Each case alone says where the error is.
            if not cases:
                raise
    found = []
    for row, case in enumerate(cases):
        try:
            found.append(curves(*([one] for one in case)))
        except ValueError as error:
            raise ValueError(str(error), row) from None
    return {name: ((WAVELENGTH.name,), np.concatenate([one[name] for one in found])) for name in found[0]}


def _axis(name: str, values: Any) -> list[float] | None:
    return None if values is None else own_axis(Quantity(name), values).values.tolist()


def existing(path: str | PathLike[str]) -> str:
    if not Path(path).exists():
        raise FileNotFoundError(f"{fspath(path)}: there is no such file")
    return fspath(path)
