"""Keyword arguments: what they are called, their units, and the axes that arrays among them make."""

from __future__ import annotations

import difflib
import functools
import inspect
import re
import reprlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, TypedDict, TypeVar

import numpy as np

from snowblue import _native
from snowblue._blocks import Labelled, is_lazy, origin

Function = TypeVar("Function", bound=Callable[..., Any])

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


UNIT_WORDS = {"1": "fractions", "degC": "degrees Celsius", "degree": "degrees"}
"""Units in words, where their symbols are none."""
SPELLINGS = {
    "degrees": "degree", "deg": "degree", "°": "degree",
    "celsius": "degC", "°C": "degC", "C": "degC", "deg_C": "degC", "degree_C": "degC", "degrees_C": "degC",
    "degree_Celsius": "degC", "degrees_Celsius": "degC", "degree_celsius": "degC", "degrees_celsius": "degC",
    "micrometer": "um", "micrometre": "um", "micron": "um", "microns": "um", "nanometer": "nm", "nanometers": "nm",
    "centimeter": "cm", "centimeters": "cm", "hours": "h", "hour": "h", "hr": "h",
    "dimensionless": "", "fraction": "", "none": "", "-": "",
}  # fmt: skip
"""Other spellings of the symbols of units."""


def powers_of(units: str) -> dict[str, int]:
    """The powers of the symbols of units as UDUNITS has them, such as 'kg m-3', 'kg/m3' and 'kg m^-3'."""
    plain = units.strip()
    for given, symbol in {"µ": "u", "μ": "u", "²": "2", "³": "3", "⁻": "-", "¹": "1", "^": "", "**": ""}.items():
        plain = plain.replace(given, symbol)
    powers: dict[str, int] = {}
    for place, factors in enumerate(plain.split("/")):
        for factor in re.split(r"[\s.·*]+", factors):
            parts = re.fullmatch(r"(-|[^\d\s-]+)(-?\d+)?", factor)
            symbol, power = parts.groups() if parts else (factor, None)
            symbol = SPELLINGS.get(symbol, symbol)
            if symbol not in ("", "1"):
                powers[symbol] = powers.get(symbol, 0) + int(power or 1) * (1 if place == 0 else -1)
    return powers


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

    def check(self, value: Any) -> None:
        """Raises ValueError for a dataset, and for an array that states another unit."""
        if hasattr(value, "data_vars"):
            raise ValueError(f"{self.name} is a Dataset, but must be an array, such as one of its variables")
        units = getattr(value, "attrs", {}).get("units")
        if units is None or self.unit is None or powers_of(str(units)) == powers_of(self.unit):
            return
        raise ValueError(
            f"{self.name} states the units '{units}', but must be in {UNIT_WORDS.get(self.unit, self.unit)}: convert "
            "it, and its attribute"
        )

    def of_derivative(self, unit: str) -> str:
        """The unit of the derivative of something with a unit with respect to this quantity."""
        powers = powers_of(unit)
        for symbol, power in powers_of(self.unit).items():
            powers[symbol] = powers.get(symbol, 0) - power
        kept = [symbol if power == 1 else f"{symbol}{power}" for symbol, power in powers.items() if power != 0]
        return " ".join(kept) or "1"


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

STAND_INS: dict[str, tuple[Any, Any]] = {
    "snow": ("fresh", "firn"),
    "grain_size_um": (400.0, 500.0),
    "size_measure": ("greatest-extension", "volume-diameter"),
    "ssa_m2_kg": (20.0, 30.0),
    "facetness": (0.3, 0.4),
    "sphericity": (0.7, 0.8),
    "density_kg_m3": (300.0, 310.0),
    "water_saturation": (0.0, 0.01),
    "temperature_c": (-5.0, -4.0),
    "ice": ("warren2008", "picard2016"),
}
"""Values of arguments that are not known yet."""

WORDS = ("snow", "size_measure", "ice")
"""Arguments of snow that are words."""
RANGES = ("grain_size_um", "facetness", "sphericity")
"""Arguments of snow that may be a tuple."""

FLUXES = ("reflectance", "transmittance", "absorptance")
RESULTS = tuple(name + aspect for name in FLUXES for aspect in ("", "_se", "_lower", "_upper"))

RESERVED = ("wavelength", "illuminant", "depth", *RESULTS)
"""Names of dimensions and variables of results, which no dimension of an argument can have."""

THICKNESS = Quantity("thickness", "cm")
ANGLE = Quantity("angle", "degree", "angle of incidence")
WAVELENGTH = Quantity("wavelength", "nm")
DEPTH = Quantity("depth", "cm")
GROUND_ALBEDO = Quantity("ground_albedo", "1", "albedo of the ground")

_QUANTITIES = (*SNOW.values(), THICKNESS, ANGLE, WAVELENGTH, DEPTH, GROUND_ALBEDO)
TAKEN = {*RESULTS, *(quantity.name for quantity in _QUANTITIES)}
"""Names of arguments and results."""


ARGUMENTS = {
    **{quantity.name: name for name, quantity in SNOW.items()},
    THICKNESS.name: "thickness_cm",
    ANGLE.name: "angle_deg",
    WAVELENGTH.name: "wavelength_nm",
    GROUND_ALBEDO.name: "ground_albedo",
}
"""Arguments by the names of their quantities; others are impurities."""


@dataclass
class Axes:
    """The dimensions of several arguments, which are broadcast by name as those of xarray are."""

    sizes: dict[str, int] = field(default_factory=dict)
    own: dict[str, Any] = field(default_factory=dict)
    """The values of the arguments, as coordinates."""
    carried: list[Mapping[str, Any]] = field(default_factory=list)
    """Further coordinates of each argument."""
    labels: dict[str, Any] = field(default_factory=dict)
    """The labels of the dimensions that have some, as pandas.Index."""

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(self.sizes.values())

    def add(self, quantity: Quantity, value: Any, array: np.ndarray, made: dict[str, Any] | None = None) -> None:
        """Adds the dimensions of an argument, which has this array of values, and its coordinate."""
        import pandas as pd

        dims, coords = dims_of(quantity, value, array), getattr(value, "coords", {})
        for dim, size in zip(dims, array.shape):
            if dim in RESERVED:
                raise ValueError(f"{quantity.name} has a dimension '{dim}', which belongs to the results")
            if size != size:
                raise ValueError(f"{quantity.name} has chunks of unknown sizes: call its compute_chunk_sizes() first")
            if size == 0:
                raise ValueError(f"{quantity.name} has no values")
            if self.sizes.setdefault(dim, size) != size:
                raise ValueError(
                    f"the axis '{dim}' has {size} values in {quantity.name}, but {self.sizes[dim]} elsewhere"
                )
            # Arrays that share an axis are paired by position: their labels must agree.
            # Labels that are not known yet are not compared.
            if dim in coords:
                labels = None if is_lazy(coords[dim].variable) else coords[dim].to_index()
            else:
                labels = pd.Index(array) if dim == quantity.name and not is_lazy(array) else None
            if labels is not None and not self.labels.setdefault(dim, labels).equals(labels):
                raise ValueError(f"the axis '{dim}' has other labels in one array than in another: align them first")
        self.carried.append(coords)
        self.own[quantity.name] = (dims, array, quantity.attributes() if made is None else made)

    def coordinates(self, wavelengths: Wavelengths | None = None) -> dict[str, Any]:
        """The coordinates of a result: the arguments, and what they carry.

        Of what they carry, names of arguments and results are left out, and names that have other values in one
        argument than in another.
        """
        spectral = [] if wavelengths is None else [wavelengths]
        dims = {*self.sizes, *(one.dim for one in spectral)}
        kept: dict[str, Any] = {}
        differing: set[str] = set()
        for coords in [*self.carried, *(one.carried for one in spectral)]:
            for name, coordinate in coords.items():
                if coordinate.dims == (name,) if name in dims else name not in TAKEN:
                    first = kept.setdefault(name, coordinate)
                    if not _are_same(first.variable, coordinate.variable):
                        differing.add(name)
        own = {**self.own, **{WAVELENGTH.name: one.own for one in spectral}}
        kept = {name: one for name, one in kept.items() if name not in differing and name not in own}
        # An index of several levels has all of them or none.
        for dim in dims & kept.keys():
            levels = kept[dim].to_index().names
            if len(levels) > 1 and not kept.keys() >= {*levels}:
                del kept[dim]
                kept |= {name: kept[name].variable.to_base_variable() for name in levels if name in kept}
        plain = {name: one.reset_coords(drop=True) if hasattr(one, "coords") else one for name, one in kept.items()}
        return {**plain, **own}

    def places(self, dims: Iterable[str]) -> np.ndarray:
        """For each element of all axes, flat, its place among the values of an argument with these dimensions."""
        own = list(dims)
        sizes = [self.sizes[dim] for dim in own]
        places = np.arange(int(np.prod(sizes))).reshape(sizes)
        ordered = [dim for dim in self.sizes if dim in own]
        places = places.transpose([own.index(dim) for dim in ordered])
        spread = places.reshape([size if dim in own else 1 for dim, size in self.sizes.items()])
        return np.broadcast_to(spread, self.shape).reshape(-1)

    @property
    def arrays(self) -> dict[str, Labelled]:
        """The values of the arguments that have dimensions, by the names of the quantities."""
        return {name: (dims, array) for name, (dims, array, _) in self.own.items() if len(dims) > 0}

    @property
    def are_lazy(self) -> bool:
        """Whether the values of an argument are not known yet."""
        return any(is_lazy(array) for _, array in self.arrays.values())

    @contextmanager
    def locating_errors(self, wavelengths: int = 1, bands: Sequence[str] | None = None) -> Iterator[None]:
        """Says where among the axes, and perhaps the wavelengths or the bands, a value is wrong."""
        try:
            yield
        except ValueError as error:
            if len(error.args) == 2:
                message, row = error.args
                raise ValueError(message + _at(row, self.sizes, self.shape)) from None
            if len(error.args) == 3:
                message, row, wavelength = error.args
                if bands is not None:
                    place = _at(row, self.sizes, self.shape)
                    raise ValueError(f"{message}{place}, in the band {bands[wavelength]}") from None
                dims, shape = [*self.sizes, WAVELENGTH.name], (*self.shape, wavelengths)
                raise ValueError(message + _at(row * wavelengths + wavelength, dims, shape)) from None
            raise


@dataclass
class Snows:
    """Snow for each combination of the values along some axes."""

    axes: Axes
    native: _native.Snows
    fixed: dict[str, Any]
    """The properties of all snows that are given."""

    @property
    def attrs(self) -> dict[str, Any]:
        """The properties that all snows have in common. The axes say what differs."""
        return self.native.common()


def single_arguments(given: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of snow that are one value."""
    single = {name: value for name, value in given.items() if name in SNOW and not is_several(value)}
    mixed = impurities(given.get("impurities_ng_g"))
    return single | {"impurities_ng_g": {name: value for name, value in mixed.items() if not is_several(value)}}


def with_arrays(
    single: Mapping[str, Any], arrays: Mapping[str, Labelled], names: Mapping[str, str] = {}
) -> dict[str, Any]:
    """Arguments that are one value, and arrays by the names of their quantities, as keyword arguments."""
    import xarray as xr

    given = dict(single)
    for name, (dims, values) in arrays.items():
        array, argument = xr.DataArray(values, dims=dims), (ARGUMENTS | names).get(name)
        if argument is None:
            given["impurities_ng_g"] = {**given["impurities_ng_g"], name: array}
        else:
            given[argument] = array
    return given


def snow_id(given: Mapping[str, Any]) -> str:
    """The identifier of one snow, which is the same in all faces."""
    return _native.Snows(dict(given), {}, 1).common()["snow_id"]


def is_several(value: Any) -> bool:
    """Whether a value makes an axis: lists and arrays do; numbers, words and tuples are one value."""
    return isinstance(value, list) or not isinstance(value, (str, tuple)) and np.ndim(value) > 0


SNOW_NAMES = tuple(Snow.__annotations__)
SUBSTANCES = ("black-carbon", "brown-carbon", "saharan-dust", "colorado-dust", "snow-algae")
"""Names of impurities."""
IMPURITIES = {
    "soot": "black-carbon",
    "dust": "saharan-dust",
    "algae": "snow-algae",
    **{name: name for name in SUBSTANCES},
}
"""Impurities by words for them."""


def shown(value: Any) -> str:
    """A value in a message, on one line of moderate length."""
    short = reprlib.Repr()
    short.maxstring = short.maxother = 60
    return " ".join(short.repr(value).split())


def mapping(name: str, value: Any, example: str) -> dict[Any, Any]:
    """An argument that must be a mapping, as one of Python."""
    if not hasattr(value, "keys") or not hasattr(value, "items"):
        raise ValueError(f"{name} is {shown(value)}, but must be a mapping such as {example}")
    return dict(value.items())


def names_of(name: str, value: Any, what: str) -> list[str]:
    """An argument that must be one name or several."""
    given = [value] if isinstance(value, str) else value
    names = list(given) if isinstance(given, Iterable) else [given]
    if not all(isinstance(one, str) for one in names):
        raise ValueError(f"{name} is {shown(value)}, but must be names of {what}")
    return names


def mass_argument(substance: str) -> str:
    """The name of the mass fraction of an impurity where it is an argument of its own, as `black_carbon_ng_g`."""
    return f"{substance.replace('-', '_')}_ng_g"


def hyphenated(name: Any) -> Any:
    """The name of an impurity, whose words may be joined by hyphens or underscores; other names as they are."""
    plain = name.replace("_", "-") if isinstance(name, str) else name
    return plain if plain in SUBSTANCES else name


def by_substance(argument: str, given: Any) -> dict[str, Any]:
    """A mapping with the names of impurities in one form."""
    named: dict[str, Any] = {}
    for name, value in given.items():
        if hyphenated(name) in named:
            raise ValueError(f"{argument} has {hyphenated(name)} twice, with a hyphen and with an underscore")
        named[hyphenated(name)] = value
    return named


def impurities(given: Any) -> dict[str, Any]:
    """The argument impurities_ng_g, by the names of the impurities."""
    if given is None:
        return {}
    named = by_substance("impurities_ng_g", mapping("impurities_ng_g", given, "{'black-carbon': 10}"))
    for name in named:
        if name not in SUBSTANCES:
            word = str(name).removesuffix("_ng_g").replace("_", "-")
            raise ValueError(f"impurity {name!r} is not known; {suggestion(word, SUBSTANCES, IMPURITIES.get(word))}")
    return named


def suggestion(name: str, known: Iterable[str], close: str | None = None) -> str:
    """The end of a message on an unknown name: the nearest one, or the given one, and all."""
    known = list(known)
    if close is None:
        # Many names are the beginning of a right one, which has a unit at its end.
        close = next((one for one in known if one.startswith(name)), None)
        close = close or next(iter(difflib.get_close_matches(name, known, 1, 0.5)), None)
    return f"{f'did you mean {close}? There' if close else 'there'} are {', '.join(known)}"


def check_names(known: Iterable[str], given: Iterable[str]) -> None:
    """Raises TypeError for an argument that is unknown."""
    known = list(known)
    for name in given:
        if name not in known:
            word = str(name)
            impurity = IMPURITIES.get(word.removesuffix("_ng_g").replace("_", "-"))
            close = f"impurities_ng_g={{'{impurity}': ...}}" if impurity and "impurities_ng_g" in known else None
            raise TypeError(f"{name!r} is not known; {suggestion(word, known, close)}")


def checks_names(*further: str) -> Callable[[Function], Function]:
    """Makes a function name all its arguments where one is unknown; `further` are those that it takes in `**`."""

    def decorate(function: Function) -> Function:
        names = list(dict.fromkeys([*argument_names(function), *further]))
        parameters = inspect.signature(function).parameters.values()
        switches = {one.name for one in parameters if isinstance(one.default, bool)}
        positional = [one.name for one in parameters if one.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD]

        @functools.wraps(function)
        def checked(*arguments: Any, **named: Any) -> Any:
            if len(arguments) > len(positional):
                value = shown(arguments[len(positional)])
                named_only = [name for name in names if name not in positional]
                name = "snow" if value.startswith("'") and "snow" in named_only else named_only[0]
                raise TypeError(
                    f"{value} is given without the name of its argument; "
                    f"{suggestion('', named_only, f'{name}={value}')}"
                )
            check_names(names, named)
            for name in switches & named.keys():
                truth(name, named[name])
            return function(*arguments, **named)

        return checked

    return decorate


def argument_names(function: Callable[..., Any]) -> list[str]:
    """The arguments of a function, without those that it takes in `**`."""
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    parameters = inspect.signature(function).parameters.values()
    return [one.name for one in parameters if one.kind in kinds and one.name not in ("self", "cls")]


def snows(given: Mapping[str, Any]) -> Snows:
    """All combinations of the values of the arguments of snow."""
    axes = Axes()
    fixed: dict[str, Any] = {}
    varying: list[tuple[str, str | None, tuple[str, ...], list[Any] | None]] = []

    def add(name: str, impurity: str | None, quantity: Quantity, value: Any) -> None:
        label = impurity or name
        quantity.check(value)
        if not is_several(value):
            plain = number(label, value) if impurity else _plain(name, value)
            if impurity:
                fixed.setdefault(name, {})[impurity] = plain
            else:
                fixed[name] = plain
            return
        value = labelled(value)
        array = array_of(value)
        dims = dims_of(quantity, value, array)
        if is_lazy(array):
            axes.add(quantity, value, array)
            varying.append((name, impurity, dims, None))
            return
        convert = functools.partial(_plain if name in WORDS else number, label)
        values = converted(convert, array, dims)
        axes.add(quantity, value, array if array.dtype.kind in "fiu" else np.array(values).reshape(array.shape))
        varying.append((name, impurity, dims, values))

    for name, value in given.items():
        if name in SNOW and value is not None:
            add(name, None, SNOW[name], value)
    for impurity, value in impurities(given.get("impurities_ng_g")).items():
        add("impurities_ng_g", impurity, Quantity(impurity.replace("-", "_"), "ng g-1"), value)
    # Arguments that are not known yet, and those on their axes, have two values of their own: the snows of a result
    # have in common what they have in common with these.
    unknown = {dim for _, _, dims, values in varying if values is None for dim in dims}
    known = Axes({dim: 2 if dim in unknown else size for dim, size in axes.sizes.items()})
    columns: dict[str, Any] = {}
    for name, impurity, dims, values in varying:
        if unknown & {*dims}:
            values = np.resize(STAND_INS.get(name, (1.0, 2.0)), [known.sizes[dim] for dim in dims]).reshape(-1).tolist()
        column = [values[place] for place in known.places(dims).tolist()]
        if impurity:
            columns.setdefault(name, {})[impurity] = column
        else:
            columns[name] = column
    with known.locating_errors():
        native = _native.Snows(fixed, columns, int(np.prod(known.shape, dtype=int)))
    return Snows(axes, native, fixed)


def _are_same(first: Any, second: Any) -> bool:
    """Whether two variables of xarray are equal. Those that are not known yet are if they are the same array."""
    if is_lazy(first) or is_lazy(second):
        return first.dims == second.dims and getattr(first.data, "name", 1) == getattr(second.data, "name", 2)
    return first.equals(second)


def labelled(value: Any) -> Any:
    """A series of pandas as an array of xarray, whose axis is its index."""
    return value.to_xarray() if hasattr(value, "to_xarray") and np.ndim(value) == 1 else value


def values_of(value: Any) -> np.ndarray:
    """The values of a list or an array. Those that are masked are NaN, and mixed ones keep their types."""
    if isinstance(value, np.ma.MaskedArray):
        return np.ma.filled(value.astype(float if value.dtype.kind in "fiub" else object), np.nan)
    try:
        array = np.asarray(value)
    except ValueError:  # Lists of several lengths.
        array = np.empty(0, dtype=object)
    # A list may hold numbers and words.
    return array if array.dtype.kind in "fiu" or not isinstance(value, list) else np.asarray(value, dtype=object)


def array_of(value: Any) -> Any:
    """The values of a list or an array, without labels; an array of dask as it is."""
    return getattr(value, "data", value) if is_lazy(value) else values_of(value)


def dims_of(quantity: Quantity, value: Any, array: np.ndarray) -> tuple[str, ...]:
    """The dimensions of an argument, which has this array of values."""
    dims = tuple(getattr(value, "dims", (quantity.name,)))
    if len(dims) != array.ndim:
        raise ValueError(
            f"{quantity.name} has {array.ndim} dimensions, but must have 1; an xarray.DataArray may have several"
        )
    return dims


def plain_values(array: np.ndarray) -> list[Any]:
    """The values of an array, flat, as those of Python; times stay as they are, since some would become numbers."""
    return list(array.reshape(-1)) if array.dtype.kind in "mM" else array.reshape(-1).tolist()


def converted(convert: Callable[[Any], Any], array: np.ndarray, dims: Iterable[str]) -> list[Any]:
    """The converted values of an array, flat. An error has the index of its value."""
    plain = plain_values(array)
    for place, value in enumerate(plain):
        try:
            plain[place] = convert(value)
        except ValueError as error:
            raise ValueError(str(error) + _at(place, dims, array.shape)) from None
    return plain


def _at(place: int, dims: Iterable[str], shape: tuple[int, ...]) -> str:
    """Names an element of an array at the end of a message."""
    places = zip(dims, shape, np.unravel_index(place, shape) if shape else ())
    first = origin()
    at = ", ".join(f"{dim}[{first.get(dim, 0) + index}]" for dim, size, index in places if size > 1 or dim in first)
    return f", at {at}" if at else ""


def one_snow(given: Mapping[str, Any]) -> Snows:
    """A single snow."""
    result = snows(given)
    if result.axes.sizes:
        raise ValueError(f"{next(iter(result.axes.sizes))} has several values, but must have one")
    return result


def _plain(name: str, value: Any) -> Any:
    if name in WORDS:
        if not isinstance(value, str):
            raise ValueError(f"{name} is {value!r}, but must be a word")
        return value
    if isinstance(value, tuple) and name not in RANGES:
        raise ValueError(f"{name} is {value!r}, but must be a number; a list makes an axis")
    return [number(name, one) for one in value] if isinstance(value, tuple) else number(name, value)


def truth(name: str, value: Any) -> bool:
    """True or False; words and numbers for them are neither."""
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{name} is {value!r}, but must be True or False")
    return bool(value)


def number(name: str, value: Any) -> float:
    """A number; the words of one, times and truth values are none."""
    if isinstance(value, (str, bytes, bool, np.bool_, np.datetime64, np.timedelta64)):
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
    return _numbers(quantity, value)


def _numbers(quantity: Quantity, value: Any) -> list[float]:
    quantity.check(value)
    array = np.atleast_1d(values_of(list(value) if isinstance(value, tuple) else value))
    if array.ndim != 1:
        raise ValueError(f"{quantity.name} has {array.ndim} dimensions, but must have 1")
    return converted(functools.partial(number, quantity.name), array, (quantity.name,))


def angle(value: Any) -> Any:
    """An angle in degrees, or the word diffuse; -1 is diffuse too, as in the angles of a result.

    Arrays of words and numbers hold numbers as words.
    """
    if isinstance(value, str):
        if value == "diffuse":
            return value
        try:
            value = float(value)
        except ValueError:
            raise ValueError(f"{value!r} is neither an angle in degrees nor 'diffuse'") from None
    return "diffuse" if value == DIFFUSE_DEG else number("angle_deg", value)


def angles(value: Any) -> list[Any]:
    """The angles of a one-dimensional axis."""
    if not is_several(value):
        return [angle(value.item() if hasattr(value, "item") else value)]
    return converted(angle, values_of(value), (ANGLE.name,))


def slab_argument(quantity: Quantity, value: Any, axes: Axes, always: bool = True) -> tuple[list[Any], tuple[str, ...]]:
    """The values of a thickness, angle or albedo, flat, and its dimensions, which are added to the axes.

    A single value makes an axis too if it must `always` be one.
    """
    quantity.check(value)
    made: dict[str, Any] = quantity.attributes()
    if is_several(value) and quantity is ANGLE:
        # Of an array this does not depend on its values, which may not be known yet.
        made = angle_coordinate(["diffuse"])[2]
    elif not is_several(value):
        if isinstance(value, tuple):
            raise ValueError(f"{quantity.name} is {value}, but must be a number or an array")
        [value] = plain_values(np.asarray(value))
        if not always:
            return [angle(value) if quantity is ANGLE else number(quantity.name, value)], ()
        value = [value]
        made = angle_coordinate(value)[2] if quantity is ANGLE else made
    value = labelled(value)
    array = array_of(value)
    dims = dims_of(quantity, value, array)
    if is_lazy(array):
        if array.dtype.kind not in "fiu":
            raise ValueError(f"{quantity.name} is an array of dask of the type {array.dtype}, but must have numbers")
        axes.add(quantity, value, array.astype(float), made)
        return [], dims
    if quantity is ANGLE:
        values = converted(angle, array, dims)
        _, plain, _ = angle_coordinate(values)
    else:
        values = plain = converted(functools.partial(number, quantity.name), array, dims)
    axes.add(quantity, value, np.array(plain, dtype=float).reshape(array.shape), made)
    return values, dims


def angle_coordinate(given: list[Any]) -> tuple[str, list[float], dict[str, Any]]:
    """The coordinate of angles: numbers, where -1 flags diffuse light."""
    attributes: dict[str, Any] = ANGLE.attributes()
    if "diffuse" in given:
        attributes |= {"flag_values": DIFFUSE_DEG, "flag_meanings": "diffuse"}
    return ANGLE.name, [DIFFUSE_DEG if one == "diffuse" else one for one in given], attributes


def wavelength_coordinate(wavelengths_nm: list[float]) -> tuple[str, list[float], dict[str, str]]:
    """The coordinate of wavelengths."""
    return WAVELENGTH.name, wavelengths_nm, WAVELENGTH.attributes() | {"standard_name": "radiation_wavelength"}


def check_wavelengths(wavelengths_nm: list[float]) -> None:
    """Raises ValueError for the first wavelength at which no ice is known. Tables of other matter reach less far."""
    least, greatest = _native.wavelength_range({})
    for place, nm in enumerate(wavelengths_nm):
        if not least <= nm <= greatest:
            at = _at(place, (WAVELENGTH.name,), (len(wavelengths_nm),))
            value = "NaN" if nm != nm else f"{nm:.12g}"
            raise ValueError(f"wavelength is {value} nm, but must lie in {least:g}–{greatest:g} nm{at}")


@dataclass
class Wavelengths:
    """The wavelengths of spectra."""

    values: list[float]
    dim: str
    own: Any
    """Their coordinate."""
    carried: Mapping[str, Any]
    """Further coordinates on their dimension."""


def wavelength_argument(value: Any) -> Wavelengths:
    """Wavelengths along their own dimension, or another one that no other argument has."""
    values = _numbers(WAVELENGTH, value)
    check_wavelengths(values)
    [dim] = getattr(value, "dims", None) or (WAVELENGTH.name,)
    own = (dim, *wavelength_coordinate(values)[1:])
    return Wavelengths(values, dim, own, getattr(value, "coords", {}))


def check_engine(engine: str) -> None:
    """Raises ValueError for an engine that is unknown."""
    if engine not in ("ordinates", "montecarlo"):
        word = str(engine).replace("-", "").replace("_", "").lower()
        raise ValueError(f"engine {engine!r} is not known; {suggestion(word, ('ordinates', 'montecarlo'))}")


def ordinates(streams: int | str = "auto", seed: int = 1) -> dict[str, Any]:
    """Options of the discrete ordinates."""
    plain = streams if isinstance(streams, str) else whole("streams", streams)
    return {"streams": plain, "seed": whole("seed", seed)}


def attributes(**made: Any) -> dict[str, Any]:
    """Provenance that NetCDF can store."""
    return {"Conventions": "CF-1.8", "source": f"snowblue {_native.__version__}", **made}
