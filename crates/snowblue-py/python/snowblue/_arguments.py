"""Keyword arguments: what they are called, their units, and the axes that arrays among them make."""

from __future__ import annotations

import difflib
import functools
import inspect
import re
import reprlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar

import numpy as np

from snowblue import _native
from snowblue._blocks import OWN, is_lazy

if TYPE_CHECKING:
    import xarray as xr

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
    - `water_saturation`: fraction of the pore volume that is water (0 to 1); 0
    - `impurities_ng_g`: a dictionary of mass fractions by name, such as black-carbon, saharan-dust and snow-algae; the
      chapter on grains and the command's `--impurity` list all names; none
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
    """What an argument is, for messages and coordinates."""

    name: str
    unit: str | None = None
    long_name: str | None = None
    further: Mapping[str, Any] = field(default_factory=dict)
    """Further attributes of its coordinates."""

    def attributes(self) -> dict[str, Any]:
        """The attributes of its coordinates."""
        units = {} if self.unit is None else {"units": self.unit}
        return {"long_name": self.long_name or self.name.replace("_", " "), **units, **self.further}

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


RENAMED = {"ssa": "specific_surface_area"}
"""Names and units of properties in results that differ from those in tables."""
SNOW = {
    "snow": Quantity("snow", long_name="kind of snow"),
    "size_measure": Quantity("size_measure"),
    **{
        key: Quantity(RENAMED.get(name, name), RENAMED.get(units, units))
        for key, name, units, _ in _native.properties()
    },
    "ice": Quantity("ice", long_name="table of ice"),
}
PAIRS: dict[str, tuple[Any, Any]] = {
    "snow": ("fresh", "firn"),
    "size_measure": ("greatest-extension", "volume-diameter"),
    "ice": ("warren2008", "picard2016"),
    **{
        key: (one["default"], 0.5 * (one["default"] + one["greatest"]))
        for key, one in _native.parameters().items()
        if key in SNOW
    },
}
"""Two values of each property of snow, for what snows have in common that differ in it."""
WORDS = ("snow", "size_measure", "ice")
"""Arguments of snow that are words."""
RANGES = ("grain_size_um", "facetness", "sphericity")
"""Arguments of snow that may be a tuple."""

FLUXES = ("reflectance", "transmittance", "absorptance")
RESULTS = tuple(name + aspect for name in FLUXES for aspect in ("", "_se", "_lower", "_upper"))

RESERVED = ("wavelength", "illuminant", "depth", *RESULTS)
"""Names of dimensions and variables of results, which no dimension of an argument can have."""

THICKNESS = Quantity("thickness", "cm")
BEAM = Quantity("angle", "degree", "angle of incidence")
DIFFUSE_FLAG = {"flag_values": DIFFUSE_DEG, "flag_meanings": "diffuse"}
ANGLE = Quantity("angle", "degree", "angle of incidence", DIFFUSE_FLAG)
WAVELENGTH = Quantity("wavelength", "nm", further={"standard_name": "radiation_wavelength"})
DEPTH = Quantity("depth", "cm")
PARTICLES = (
    Quantity("wavelength_nm", "nm"),
    Quantity("extinction_m2_kg", "m2 kg-1"),
    Quantity("single_scattering_albedo", "1"),
    Quantity("asymmetry", "1"),
    Quantity("absorption_m2_kg", "m2 kg-1"),
)
"""Columns of a table of particles."""
GROUND_ALBEDO = Quantity("ground_albedo", "1", "albedo of the ground")

TAKEN = {*RESULTS, *(one.name for one in (*SNOW.values(), THICKNESS, ANGLE, WAVELENGTH, DEPTH, GROUND_ALBEDO))}
"""Names of arguments and results."""


def word(name: str, value: Any) -> str:
    """A word."""
    if not isinstance(value, str):
        raise ValueError(f"{name} is {value!r}, but must be a word")
    return value


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


def angle(name: str, value: Any) -> float:
    """An angle in degrees; -1, as in the angles of a result, is the word diffuse.

    Arrays of words and numbers hold numbers as words.
    """
    if value == "diffuse":
        return DIFFUSE_DEG
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            raise ValueError(f"{value!r} is neither an angle in degrees nor 'diffuse'") from None
    return number("angle_deg", value)


def angles_or_diffuse(angles_deg: Any) -> list[Any]:
    """Angles in degrees, with the word for diffuse light."""
    return ["diffuse" if one == DIFFUSE_DEG else one for one in np.ravel(angles_deg).tolist()]


@contextmanager
def located(name: str, place: int, count: int) -> Iterator[None]:
    """Says which one of several values is wrong."""
    try:
        yield
    except ValueError as error:
        raise ValueError(error.args[0] + (f", at {name}[{place}]" if count > 1 else "")) from None


class Axes:
    """Arguments, and their dimensions in the order in which they first come."""

    def __init__(self) -> None:
        self.arrays: dict[str, xr.DataArray] = {}
        self.sizes: dict[str, int] = {}
        self.own: dict[str, xr.Variable] = {}
        """The arguments that have dimensions, as coordinates."""
        self.gaps: list[str] = []
        """The arguments of several values. Where one of them is NaN, so are the results."""
        self._carriers: list[xr.DataArray] = []
        """Arrays with further coordinates."""
        self._labels: dict[str, Any] = {}

    def add(
        self,
        name: str,
        quantity: Quantity,
        value: Any,
        convert: Callable[[str, Any], Any] = number,
        label: str | None = None,
        always: bool = False,
    ) -> None:
        """Adds an argument, whose values are numbers unless they are converted otherwise, by its name. The label names
        a value that cannot be converted. A single value makes an axis too if it must `always` be one."""
        array = array_of(quantity, value, convert, label)
        if array.ndim > 0:
            self.gaps.append(name)
        elif always:
            array = array.expand_dims(quantity.name)
        self.broadcast(quantity.name, array)
        # Of several angles, those at night are missing.
        is_night = quantity.name == ANGLE.name and name in self.gaps
        self.arrays[name] = array.where(array <= _native.GREATEST_ANGLE_DEG) if is_night else array
        if array.ndim > 0:
            self.own[quantity.name] = array.variable.copy(deep=False)
            self.own[quantity.name].attrs = quantity.attributes()

    def broadcast(self, name: str, array: xr.DataArray) -> None:
        """Adds the dimensions and the coordinates of an array."""
        for dim, size in array.sizes.items():
            if dim in RESERVED:
                raise ValueError(f"{name} has a dimension '{dim}', which belongs to the results")
            if size == 0:
                raise ValueError(f"{name} has no values")
            if self.sizes.setdefault(dim, size) != size:
                raise ValueError(f"the axis '{dim}' has {size} values in {name}, but {self.sizes[dim]} elsewhere")
            # Arrays that share an axis are paired by position: their labels must agree. The values of an argument on
            # an axis of its own are labels. Those that are not known yet are not compared.
            labels = array.indexes.get(dim)
            if labels is None and dim == name and dim not in array.coords and not is_lazy(array):
                labels = array.to_index()
            if labels is not None and not self._labels.setdefault(dim, labels).equals(labels):
                raise ValueError(f"the axis '{dim}' has other labels in one array than in another: align them first")
        self._carriers.append(array)

    def progress(self, given: Any) -> Any:
        """The argument `progress`, of which results that are computed later have none."""
        if not any(map(is_lazy, self.arrays.values())):
            return given
        if given not in (None, False):
            raise ValueError("progress is given, but arrays of dask are computed later; dask has a bar of its own")
        return False

    def coordinates(self, *further: xr.DataArray) -> dict[str, Any]:
        """The coordinates of a result: the arguments, and what they and further arrays carry.

        Of what they carry, names of arguments and results are left out, and names that have other values in one
        argument than in another.
        """
        import xarray as xr

        dims = {*self.sizes, *(dim for array in further for dim in array.dims)}
        given = [array.coords.to_dataset() for array in (*self._carriers, *further)]
        # Values that are not known yet are the same if they are those of one array.
        sources: dict[Any, set[Any]] = {}
        for coords in given:
            for name, one in coords.variables.items():
                sources.setdefault(name, set()).add(one.data.name if is_lazy(one) else None)
        carried = []
        for coords in given:
            dropped = {*self.own} | {name for name, own in sources.items() if len(own) > 1}
            for name, one in coords.variables.items():
                if one.dims != (name,) if name in dims else name in TAKEN:
                    dropped.add(name)
            # An index of several levels has all of them or none.
            broken = [name for name, one in coords.indexes.items() if name in dims and dropped & {*one.names}]
            carried.append(coords.reset_index(broken).drop_vars([*dropped, *broken], errors="ignore"))
        merged = xr.merge(carried, compat="minimal", join="exact", combine_attrs="override")
        return {**merged.coords, **self.own}


def single_values(fixed: Mapping[str, Any], arrays: Mapping[str, xr.DataArray]) -> dict[str, Any]:
    """The properties that all snows have in common, where some are arrays."""
    pairs = {name: PAIRS.get(name, (1.0, 2.0)) for name in arrays if name in SNOW or name in SUBSTANCES}
    try:
        return _native.Snows(dict(fixed), by_argument(pairs), 2 if pairs else 1).common()
    except ValueError as error:
        raise ValueError(error.args[0]) from None


def by_argument(columns: Mapping[str, Any]) -> dict[str, Any]:
    """The properties of snow by the names of arguments, in which those of impurities are one."""
    impure = {name: column for name, column in columns.items() if name in SUBSTANCES}
    given = {name: column for name, column in columns.items() if name in SNOW}
    return given | ({"impurities_ng_g": impure} if impure else {})


def snow_id(given: Mapping[str, Any]) -> str:
    """The identifier of one snow, which is the same in all faces."""
    return single_values(given, {})["snow_id"]


def substance(name: str, particles: Any) -> str:
    """Declares an impurity that is not built in, for this process, and returns its name.

    Parameters
    ----------
    name : str
        The name of a new substance: letters, digits, hyphens and underscores.
    particles : xarray.Dataset, DataFrame or mapping of arrays; or xarray.DataArray
        `extinction_m2_kg`, `single_scattering_albedo` and `asymmetry`, or `absorption_m2_kg` alone, with `wavelength`
        or `wavelength_nm` in nm, ascending. A DataArray on `wavelength` is the mass absorption coefficient in m²/kg.
        Between the wavelengths all are linear; wavelengths beyond them are refused.

    Examples
    --------
    >>> import snowblue
    >>> dark = snowblue.substance("dark-dust", {"wavelength_nm": [300, 2500], "absorption_m2_kg": [300, 100]})
    >>> clean, dirty = snowblue.albedo(impurities_ng_g={dark: [0, 5000]}, wavelength_nm=500)
    >>> bool(dirty < clean)
    True
    """
    if hasattr(particles, "dims") and not hasattr(particles, "data_vars"):
        given = {"wavelength_nm": particles["wavelength"], "absorption_m2_kg": particles}
    else:
        example = "{'wavelength_nm': [300, 2500], 'absorption_m2_kg': [300, 100]}"
        given = mapping("particles", getattr(particles, "variables", particles), example)
    columns = {}
    for key, values in given.items():
        key = "wavelength_nm" if key == "wavelength" else key
        quantity = next((one for one in PARTICLES if one.name == key), None)
        if quantity is None:
            known = ", ".join(one.name for one in PARTICLES)
            raise ValueError(f"substance {name}: {shown(key)} is not known; there are {known}")
        quantity.check(values)
        columns[quantity.name] = np.asarray(values, dtype=float).ravel().tolist()
    return _declare(name, columns)


def _declare(name: str, columns: dict[str, list[float]]) -> str:
    """Declares an impurity of checked columns."""
    found = _native.declare_substance(name, columns)
    if found not in SUBSTANCES:
        SUBSTANCES.append(found)
    OWN[found] = functools.partial(_declare, name, columns)
    return found


def is_several(value: Any) -> bool:
    """Whether a value makes an axis: lists and arrays do; numbers, words and tuples are one value."""
    return isinstance(value, list) or not isinstance(value, (str, tuple)) and np.ndim(value) > 0


SNOW_NAMES = tuple(Snow.__annotations__)
SUBSTANCES = list(_native.substances())
"""Names of impurities. Those that are declared are added."""
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


def add_snow(axes: Axes, given: Mapping[str, Any]) -> dict[str, Any]:
    """Adds the arguments of snow that are arrays to the axes, and gives the others."""
    fixed: dict[str, Any] = {}
    for name, value in given.items():
        if name not in SNOW or value is None:
            continue
        SNOW[name].check(value)
        if is_several(value):
            axes.add(name, SNOW[name], value, word if name in WORDS else number, name)
        else:
            fixed[name] = _single(name, value)
    for name, value in impurities(given.get("impurities_ng_g")).items():
        quantity = Quantity(name.replace("-", "_"), "ng g-1")
        quantity.check(value)
        if is_several(value):
            axes.add(name, quantity, value, label=name)
        else:
            fixed.setdefault("impurities_ng_g", {})[name] = number(name, value)
    return fixed


def add_ground(axes: Axes, value: Any, at: xr.DataArray, used_nm: np.ndarray | None = None) -> None:
    """Adds the albedo of the ground: a number, an axis, or a spectrum on `wavelength`. The spectrum is interpolated at
    the wavelengths `at`, and must cover those that are used, by default all."""
    value = labelled(value)
    if "wavelength" not in getattr(value, "dims", ()):
        axes.add("ground_albedo", GROUND_ALBEDO, value)
        return
    GROUND_ALBEDO.check(value)
    if "wavelength" not in value.coords:
        raise ValueError("ground_albedo has the dimension 'wavelength', but no coordinate with its values in nm")
    found = interpolated("ground albedo", value.astype(float), at.values, at.values if used_nm is None else used_nm)
    [dim] = at.dims
    axes.gaps.append("ground_albedo")
    axes.broadcast("ground_albedo", at_first(found, "wavelength"))
    found = found.drop_vars("wavelength").rename(wavelength=dim)
    axes.arrays["ground_albedo"] = found
    axes.own["ground_albedo"] = found.variable.copy(deep=False)
    axes.own["ground_albedo"].attrs = GROUND_ALBEDO.attributes()


def at_first(array: xr.DataArray, dim: str) -> xr.DataArray:
    """The first part of an array along a dimension, without the coordinates that lie on the dimension."""
    return array.drop_vars([name for name, one in array.coords.items() if dim in one.dims]).isel({dim: 0})


def one_ground(value: Any, at: xr.DataArray) -> tuple[Any, dict[str, Any], dict[str, Any]]:
    """The albedo of one ground, as the engines take it; and the coordinate, if it is a spectrum, or attribute that
    states it."""
    axes = Axes()
    add_ground(axes, value, at)
    if axes.sizes:
        raise ValueError(f"ground_albedo is {shown(value)}, but must be one number, or a spectrum on 'wavelength'")
    albedo = axes.arrays["ground_albedo"]
    if albedo.ndim == 0:
        return albedo.item(), {}, {"ground_albedo": albedo.item()}
    return grounds(albedo.values[None], at.values)[0], axes.own, {}


def grounds(albedos: np.ndarray, wavelengths_nm: Any) -> list[Any]:
    """Grounds as the engines take them: the albedo of each, or its spectrum at some wavelengths."""
    if albedos.ndim == 1:
        return albedos.tolist()
    known_nm, places = np.unique(wavelengths_nm, return_index=True)
    return [(known_nm.tolist(), row) for row in albedos[:, places].tolist()]


def slabs_of_rows(
    fixed: Mapping[str, Any], rows: Mapping[str, np.ndarray], wavelengths_nm: list[float]
) -> tuple[_native.Snows, dict[str, Any]]:
    """The snows that differ among some rows; and thickness, light and ground of each row, whose places among the values
    are those of its snow, thickness, light and ground. A ground may have an albedo at each wavelength."""
    count = len(rows["angle_deg"])
    columns = {name: values.tolist() for name, values in rows.items() if name in SNOW or name in SUBSTANCES}
    all_values = list(zip(*columns.values())) if columns else [()] * count
    firsts: dict[tuple[Any, ...], int] = {}
    for row, values in enumerate(all_values):
        firsts.setdefault(values, row)
    distinct = by_argument({name: list(column) for name, column in zip(columns, zip(*firsts))})
    try:
        native = _native.Snows(dict(fixed), distinct, len(firsts))
    except ValueError as error:
        message, snow = error.args
        raise ValueError(message, [*firsts.values()][snow]) from None
    numbers = {values: snow for snow, values in enumerate(firsts)}
    snow, own = np.array([numbers[values] for values in all_values], dtype=np.int64), np.arange(count)
    return native, {
        "thickness_cm": rows["thickness_cm"].tolist(),
        "angle_deg": angles_or_diffuse(rows["angle_deg"]),
        "ground_albedo": grounds(rows["ground_albedo"], wavelengths_nm),
        "wavelength_nm": wavelengths_nm,
        "places": np.stack([snow, own, own, own], axis=-1),
    }


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


def labelled(value: Any) -> Any:
    """A series of pandas as an array of xarray, whose axis is its index."""
    return value.to_xarray() if hasattr(value, "to_xarray") and np.ndim(value) == 1 else value


def array_of(
    quantity: Quantity, value: Any, convert: Callable[[str, Any], Any], label: str | None = None
) -> xr.DataArray:
    """The converted values of an argument. Those of dask must have numbers, which are converted later."""
    import xarray as xr

    quantity.check(value)
    if isinstance(value, tuple):
        raise ValueError(f"{quantity.name} is {value}, but must be a number or an array")
    value = labelled(value)
    if not hasattr(value, "dims"):
        several = is_several(value)
        values = value if several and is_lazy(value) else values_of(value)
        if values.ndim > 1:
            raise ValueError(
                f"{quantity.name} has {values.ndim} dimensions, but must have 1; an xarray.DataArray may have several"
            )
        value = xr.DataArray(values, dims=[quantity.name] if several else [])
    elif value.ndim == 0:
        value = xr.DataArray(value.values)
    if any(size != size for size in value.shape):
        raise ValueError(f"{quantity.name} has chunks of unknown sizes: call its compute_chunk_sizes() first")
    if value.dtype.kind in "fiu" and convert is not word:
        return value.astype(float)
    if is_lazy(value):
        if convert is word:
            return value
        raise ValueError(f"{quantity.name} is an array of dask of the type {value.dtype}, but must have numbers")
    # Times stay as they are, since as those of Python some would become numbers.
    plain = list(value.values.reshape(-1)) if value.dtype.kind in "mM" else value.values.reshape(-1).tolist()
    for place, one in enumerate(plain):
        try:
            plain[place] = convert(label or quantity.name, one)
        except ValueError as error:
            indices = zip(value.sizes.items(), np.unravel_index(place, value.shape) if value.shape else ())
            at = ", ".join(f"{dim}[{index}]" for (dim, size), index in indices if size > 1)
            raise ValueError(f"{error}, at {at}" if at else str(error)) from None
    return value.copy(data=np.array(plain, dtype=None if convert is word else float).reshape(value.shape))


def axis(quantity: Quantity, value: Any, convert: Callable[[str, Any], Any] = number) -> xr.DataArray:
    """An argument that is one axis, also of a tuple or a single value. Its labels are known at once."""
    if is_lazy(value):
        value = value.compute()
    array = array_of(quantity, list(value) if isinstance(value, tuple) else value, convert)
    if array.ndim > 1:
        raise ValueError(f"{quantity.name} has {array.ndim} dimensions, but must have 1")
    array = array if array.ndim else array.expand_dims(quantity.name)
    array.attrs = quantity.attributes()
    return array


def own_axis(quantity: Quantity, value: Any, convert: Callable[[str, Any], Any] = number) -> xr.Variable:
    """An argument that is an axis of its own, as a coordinate."""
    variable = axis(quantity, value, convert).variable
    if variable.dims != (quantity.name,):
        raise ValueError(f"{quantity.name} is an array over '{variable.dims[0]}', but can only be an axis of its own")
    return variable


def interpolated(label: str, value: Any, wavelengths_nm: np.ndarray, used_nm: np.ndarray) -> Any:
    """An array on `wavelength` at other wavelengths, of which it must cover those that are used."""
    import xarray as xr

    if "wavelength" not in getattr(value, "dims", ()) or "wavelength" not in value.coords:
        return value
    value = value.transpose(..., "wavelength")
    own_nm = own_axis(WAVELENGTH, value.wavelength.values).values
    if not (np.diff(own_nm) > 0).all():
        raise ValueError(f"the {label} has wavelengths that do not ascend")
    if own_nm[0] > used_nm.min() or own_nm[-1] < used_nm.max():
        raise ValueError(
            f"the {label} is given from {own_nm[0]:g} to {own_nm[-1]:g} nm, but it is needed from "
            f"{used_nm.min():g} to {used_nm.max():g} nm"
        )
    found = xr.apply_ufunc(
        lambda row: np.interp(wavelengths_nm, own_nm, row),
        value,
        input_core_dims=[["wavelength"]],
        output_core_dims=[["wavelength"]],
        exclude_dims={"wavelength"},
        vectorize=True,
        dask="parallelized",
        output_dtypes=[float],
        dask_gufunc_kwargs={"output_sizes": {"wavelength": len(wavelengths_nm)}, "allow_rechunk": True},
    )
    return found.assign_coords(wavelength=wavelengths_nm)


def wavelengths(value: Any) -> xr.DataArray:
    """Wavelengths of the model, along their own dimension or another one."""
    array = axis(WAVELENGTH, value)
    least, greatest = _native.wavelength_range()
    for place, nm in enumerate(array.values.tolist()):
        with located("wavelength", place, array.size):
            if not least <= nm <= greatest:
                text = "NaN" if nm != nm else f"{nm:.12g}"
                raise ValueError(f"wavelength is {text} nm, but must lie in {least:g}–{greatest:g} nm")
    return array


def one_snow(given: Mapping[str, Any]) -> dict[str, Any]:
    """The properties of a single snow that are given."""
    axes = Axes()
    fixed = add_snow(axes, given)
    if axes.sizes:
        raise ValueError(f"{next(iter(axes.sizes))} has several values, but must have one")
    # This checks them.
    single_values(fixed, {})
    return fixed


def _single(name: str, value: Any) -> Any:
    if name in WORDS:
        return word(name, value)
    if isinstance(value, tuple) and name not in RANGES:
        raise ValueError(f"{name} is {value!r}, but must be a number; a list makes an axis")
    return [number(name, one) for one in value] if isinstance(value, tuple) else number(name, value)


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
