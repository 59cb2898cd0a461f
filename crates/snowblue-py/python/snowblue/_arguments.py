"""Keyword arguments: what they are called, their units, and the axes that arrays among them make."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypedDict

import numpy as np

from snowblue import _native

VISIBLE_NM = np.arange(400.0, 701.0, 10.0)
DIFFUSE_DEG = -1.0


class Snow(TypedDict, total=False):
    """What is known of a snow. Quantities that are missing have defaults, which `parameters` lists.

    - `snow`: kind: fresh, rounded, faceted, wind-packed, melt-forms or firn; sets surface area and density by default
    - `grain_size_um`: a mean, for the range mean ± 50 (70 to 4950), or a tuple of both ends (20 to 5000); 400
    - `size_measure`: what a grain size measures: greatest-extension, volume-diameter or optical-diameter
    - `ssa_m2_kg`: specific surface area instead of a grain size (1.4 to 300)
    - `facetness`: roughness: a mean (0 to 1), or a tuple of min, max, mean and standard deviation; 0.3
    - `sphericity`: Riley sphericity: one value (0.5 to 1), or a tuple as for facetness; (0.7, 0.9, 0.8, 0.1)
    - `density_kg_m3`: density of the dry snow (10 to 900); 300
    - `water_saturation`: fraction of the pore volume that is water (0 to 1), for 300 to 1400 nm; 0
    - `impurities_ng_g`: a dictionary of mass fractions of black-carbon, brown-carbon, saharan-dust, colorado-dust and
      snow-algae, for 305 to 1495 nm; none
    - `temperature_c`: temperature (-60 to 0), which changes the density of ice only; -5
    - `ice`: absorption of ice: warren2008 or picard2016; warren2008
    """

    snow: Any
    grain_size_um: Any
    size_measure: Any
    ssa_m2_kg: Any
    facetness: Any
    sphericity: Any
    density_kg_m3: Any
    water_saturation: Any
    impurities_ng_g: Mapping[str, Any]
    temperature_c: Any
    ice: Any


@dataclass(frozen=True)
class Quantity:
    """The coordinate of an argument."""

    name: str
    unit: str | None = None
    long_name: str | None = None

    def attributes(self) -> dict[str, str]:
        attributes = {"long_name": self.long_name or self.name.replace("_", " ")}
        if self.unit is not None:
            attributes["units"] = self.unit
        return attributes


SNOW = {
    "snow": Quantity("snow", long_name="kind of snow"),
    "grain_size_um": Quantity("grain_size", "um"),
    "size_measure": Quantity("size_measure"),
    "ssa_m2_kg": Quantity("specific_surface_area", "m2 kg-1"),
    "facetness": Quantity("facetness", "1"),
    "sphericity": Quantity("sphericity", "1"),
    "density_kg_m3": Quantity("density", "kg m-3"),
    "water_saturation": Quantity("water_saturation", "1"),
    "temperature_c": Quantity("temperature", "degC"),
    "ice": Quantity("ice", long_name="table of ice"),
}

WORDS = ("snow", "size_measure", "ice")
"""Arguments of snow that are words."""

RESERVED = ("thickness", "angle", "wavelength", "illuminant", "depth")
"""Dimensions of results that snow cannot have."""

THICKNESS = Quantity("thickness", "cm")
ANGLE = Quantity("angle", "degree", "angle of incidence")
WAVELENGTH = Quantity("wavelength", "nm")
DEPTH = Quantity("depth", "cm")


@dataclass
class Snows:
    """Snow for each combination of the values along some axes."""

    dims: list[str] = field(default_factory=list)
    shape: list[int] = field(default_factory=list)
    coords: dict[str, Any] = field(default_factory=dict)
    snows: list[dict[str, Any]] = field(default_factory=list)
    attrs: dict[str, Any] = field(default_factory=dict)


def is_several(value: Any) -> bool:
    """Whether a value makes an axis: lists and arrays do; numbers, words and tuples are one value."""
    return not isinstance(value, (str, tuple)) and np.ndim(value) > 0


def check_names(known: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    """Raises TypeError for an argument that is unknown."""
    for name in given:
        if name not in known:
            raise TypeError(f"'{name}' is not known; there are {', '.join(known)}")


def snows(given: Mapping[str, Any]) -> Snows:
    """All combinations of the values of the arguments of snow."""
    check_names(Snow.__annotations__, given)
    impurities = given.get("impurities_ng_g") or {}
    arguments: list[tuple[Any, Quantity, Any]] = [
        (name, SNOW[name], value) for name, value in given.items() if name in SNOW and value is not None
    ]
    arguments += [((name,), Quantity(name.replace("-", "_"), "ng g-1"), value) for name, value in impurities.items()]
    result = Snows()
    fixed: list[tuple[Any, Any]] = []
    varying: list[tuple[Any, tuple[str, ...], np.ndarray]] = []
    for name, quantity, value in arguments:
        if not is_several(value):
            fixed.append((name, value))
            continue
        array = np.asarray(value)
        dims = tuple(getattr(value, "dims", (quantity.name,)))
        if len(dims) != array.ndim:
            raise ValueError(
                f"{quantity.name} has {array.ndim} dimensions, but must have 1; an xarray.DataArray may have several"
            )
        for dim, size in zip(dims, array.shape):
            if dim in RESERVED:
                raise ValueError(f"{quantity.name} has a dimension '{dim}', which belongs to the results")
            if size == 0:
                raise ValueError(f"{quantity.name} has no values")
            _check_labels(dim, getattr(value, "coords", {}), result.coords)
            if dim not in result.dims:
                result.dims.append(dim)
                result.shape.append(size)
            elif result.shape[result.dims.index(dim)] != size:
                other = result.shape[result.dims.index(dim)]
                raise ValueError(f"the axis '{dim}' has {size} values in {quantity.name}, but {other} elsewhere")
        result.coords.update(getattr(value, "coords", {}))
        result.coords[quantity.name] = (dims, array, quantity.attributes())
        varying.append((name, dims, array))
    for place in itertools.product(*map(range, result.shape)):
        at = dict(zip(result.dims, place))
        own = [(name, array[tuple(at[dim] for dim in dims)].item()) for name, dims, array in varying]
        result.snows.append(_snow(fixed + own))
    # The axes say what differs between the snows, the attributes what all have in common.
    resolved = [_native.resolved(snow) for snow in result.snows]
    common = resolved[0].items()
    result.attrs = {name: value for name, value in common if all(one.get(name) == value for one in resolved)}
    return result


def _check_labels(dim: str, coords: Mapping[str, Any], known: Mapping[str, Any]) -> None:
    """Arrays that share an axis are paired by position: their labels must agree."""
    if dim in coords and dim in known and not np.array_equal(np.asarray(coords[dim]), np.asarray(known[dim])):
        raise ValueError(f"the axis '{dim}' has other labels in one array than in another: align them first")


def one_snow(given: Mapping[str, Any]) -> Snows:
    """A single snow."""
    result = snows(given)
    if result.dims:
        raise ValueError(f"{result.dims[0]} has several values, but must have one")
    return result


def _snow(properties: list[tuple[Any, Any]]) -> dict[str, Any]:
    snow = {name: _plain(name, value) for name, value in properties if isinstance(name, str)}
    impurities = {name[0]: number(name[0], value) for name, value in properties if not isinstance(name, str)}
    return {**snow, "impurities_ng_g": impurities} if impurities else snow


def _plain(name: str, value: Any) -> Any:
    if name in WORDS:
        if not isinstance(value, str):
            raise ValueError(f"{name} is {value!r}, but must be a word")
        return value
    return [number(name, one) for one in value] if isinstance(value, tuple) else number(name, value)


def number(name: str, value: Any) -> float:
    """A number; the words of one are none."""
    if isinstance(value, (str, bytes)):
        raise ValueError(f"{name} is {value!r}, but must be a number")
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}, but must be a number") from None


def whole(name: str, value: Any, least: int = 0) -> int:
    """A whole number."""
    if not isinstance(value, (int, np.integer)) and not number(name, value).is_integer():
        raise ValueError(f"{name} is {value}, but must be a whole number")
    if value < least:
        raise ValueError(f"{name} is {value}, but must be at least {least}")
    return int(value)


def numbers(quantity: Quantity, value: Any) -> list[float]:
    """The values of a one-dimensional axis."""
    dims = getattr(value, "dims", (quantity.name,))
    if dims and dims != (quantity.name,):
        raise ValueError(f"{quantity.name} is an array over '{dims[0]}', but can only be an axis of its own")
    array = np.atleast_1d(np.asarray(value))
    if array.ndim != 1:
        raise ValueError(f"{quantity.name} has {array.ndim} dimensions, but must have 1")
    return [number(quantity.name, one) for one in array.tolist()]


def angles(value: Any) -> list[Any]:
    """Angles in degrees, and the word diffuse; -1 is diffuse too, as in the angles of a result."""
    several = value if is_several(value) else [value]
    plain = [one.item() if hasattr(one, "item") else one for one in several]
    return [
        one if isinstance(one, str) else "diffuse" if one == DIFFUSE_DEG else number("angle_deg", one) for one in plain
    ]


def angle_coordinate(given: list[Any]) -> tuple[str, list[float], dict[str, Any]]:
    """The coordinate of angles: numbers, where -1 flags diffuse light."""
    attributes: dict[str, Any] = ANGLE.attributes()
    if "diffuse" in given:
        attributes |= {"flag_values": DIFFUSE_DEG, "flag_meanings": "diffuse"}
    return ANGLE.name, [DIFFUSE_DEG if one == "diffuse" else one for one in given], attributes


def wavelength_coordinate(wavelengths_nm: list[float]) -> tuple[str, list[float], dict[str, str]]:
    """The coordinate of wavelengths."""
    return WAVELENGTH.name, wavelengths_nm, WAVELENGTH.attributes() | {"standard_name": "radiation_wavelength"}


def ordinates(streams: int | str = "auto", seed: int = 1) -> dict[str, Any]:
    """Options of the discrete ordinates."""
    plain = streams if isinstance(streams, str) else whole("streams", streams)
    return {"streams": plain, "seed": whole("seed", seed)}


def attributes(**made: Any) -> dict[str, Any]:
    """Provenance that NetCDF can store."""
    return {"Conventions": "CF-1.8", "source": f"snowblue {_native.__version__}", **made}
