"""Snow from measured spectra."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from snowblue import _native
from snowblue._arguments import (
    ANGLE,
    DEPTH,
    GROUND_ALBEDO,
    THICKNESS,
    SNOW_NAMES,
    WAVELENGTH,
    Axes,
    Quantity,
    Snow,
    add_ground,
    add_snow,
    angle,
    angles_or_diffuse,
    attributes,
    checks_names,
    hyphenated,
    interpolated,
    labelled,
    mapping,
    mass_argument,
    number,
    ordinates,
    own_axis,
    powers_of,
    single_values,
    slabs_of_rows,
    values_of,
    wavelengths,
    whole,
)
from snowblue._bands import Curve, band_weights, response_curves
from snowblue._blocks import dataset, in_blocks, is_lazy, no_rows
from snowblue._progress import Progress, reporting
from snowblue._spectra import (
    LONG_NAMES,
    check_parameters,
    described_layers,
    locating_layers,
    packed_layers,
    parameter_quantity,
)

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from typing_extensions import Unpack

STATED = {
    "angle_deg": (ANGLE, "angle", "diffuse"),
    "thickness_cm": (THICKNESS, "thickness", np.inf),
    "ground_albedo": (GROUND_ALBEDO, None, 0.0),
}
"""Arguments that a spectrum may state as a coordinate or attribute: its other name, which needs units, the default."""

ASPECTS = {
    "": "{}, median of the posterior",
    "_sd": "standard deviation of {}",
    "_lower": "{}, lower end of the interval that holds 95 % of the posterior",
    "_upper": "{}, upper end of the interval that holds 95 % of the posterior",
}
AT_DEPTH = {"down": "flux down", "up": "flux up", "net": "net flux", "fluence": "fluence rate"}
"""Fluxes at depth that can be measured, as :func:`snowblue.layers` names them, in words."""
BAND_STEP_NM = 10.0
"""Greatest distance of the wavelengths at which the model of a band is solved, unless they are given."""
MOST_STEPS = 10_000
"""More wavelengths of a band are out of every range, and no array is made of them."""
MOST_LAYERS = 1_000_000
"""Greater numbers of layers are refused at once."""
DEVIATIONS = {"albedo": "standard_deviation", "transmittance": "transmittance_standard_deviation"}
"""The argument with the standard deviation of each quantity that is no flux at depth."""
NUMBERS = {
    "degrees_of_freedom": "degrees of freedom for signal",
    "data": "number of measured values",
    "data_chi_square": "sum of squared residuals in units of their errors",
    "chi_square": "the same with the squared distance from the prior; expected: the number of values",
    "solutions": "number of solutions of the equation of transfer",
}


@checks_names(*SNOW_NAMES)
def invert(
    albedo: Any = None,
    wavelength_nm: Any = None,
    *,
    bands: str | Iterable[str] | Mapping[str, Any] | None = None,
    light: xr.DataArray | None = None,
    transmittance: Any = None,
    fluxes: Mapping[str, xr.DataArray] | xr.Dataset | None = None,
    layers: Iterable[Mapping[str, Any]] | pd.DataFrame | None = None,
    retrieve: str | Iterable[Any] | Mapping[Any, Any] = ("ssa_m2_kg", "black-carbon"),
    standard_deviation: Any = 0.01,
    transmittance_standard_deviation: Any = None,
    fluxes_standard_deviation: Any = None,
    scale_error: float = 0.0,
    correlation_nm: float = 0.0,
    angle_deg: Any = None,
    diffuse_fraction: Any = None,
    thickness_cm: Any = None,
    ground_albedo: Any = None,
    prior_correlation: Any = None,
    streams: int | str = "auto",
    seed: int = 1,
    progress: Progress = None,
    **snow: Unpack[Snow],
) -> xr.Dataset:
    """Properties of snow from measured spectra, and how well the data determine them.

    The spectra are those of albedo, transmittance and fluxes at depth, at wavelengths or in the bands of a sensor; the
    snow may have layers.

    Optimal estimation (Rodgers 2000): the most probable state, given the data, their errors, and a prior. The state has
    the logarithms of positive quantities and the log-odds of fractions. All spectra are retrieved together, in
    parallel; those of dask by blocks, when the result is asked for.

    Parameters
    ----------
    albedo, transmittance : array
        Measured fractions of the light, with NaN where there is none; one of these or `fluxes` is needed. Dimensions of
        an :class:`xarray.DataArray` other than `wavelength` (nm) are those of the result, and pair with those of other
        arguments. Plain arrays have the wavelength last.
    wavelength_nm : array
        Needed where no dimension `wavelength` has it. With `bands`
        the wavelengths at which the model is solved; by default those of the responses in steps of 10 nm or less.
    bands : names, or a mapping of names to responses, optional
        The bands of a sensor, as in :func:`snowblue.bands`, if the values are means over them. The last dimension of
        the spectra, or that of the name `band`, is then that of the bands, in their order or with their names. All that
        is said of wavelengths below holds for bands; their errors correlate by their mean wavelengths. Bands without a
        response of their own, such as "visible", need `wavelength_nm`.
    light : xarray.DataArray, optional
        Irradiance on `wavelength` with which the means are weighted, as in :func:`snowblue.bands`.
    fluxes : mapping or Dataset, optional
        Measured fluxes at depth over the incident flux: any of `down`, `up` and `net`, through a level plane, and
        `fluence`, from all directions, as :func:`snowblue.layers` gives them. Each has the dimensions `depth`, with
        the depths below the surface in cm, and `wavelength`.
    layers : mappings or pandas.DataFrame, top first, optional
        The layers of all packs, as in :func:`snowblue.layers`, in place of `thickness_cm` and the arguments of
        :class:`Snow`.
    retrieve : names, or a mapping of names to priors
        Parameters that spectra can be differentiated by: `ssa_m2_kg`, `density_kg_m3`, `thickness_cm`,
        `water_saturation`, `ground_albedo`, `cos_angle`, and impurities. In layers a name is that of the common value
        of all of them, and a pair such as `("ssa_m2_kg", 0)` that of one; they are numbered from 0 at the top. A prior
        is a median, in the parameter's unit, and the standard deviation of the logarithm (of the log-odds of
        saturation, `ground_albedo` and `cos_angle`). None is a weak prior, which the attributes of the result state;
        for density, thickness, `ground_albedo` and `cos_angle` its median is the argument.
    standard_deviation, transmittance_standard_deviation, fluxes_standard_deviation : float or array
        Standard deviation of each value: of the instrument and of the model. A transmittance needs one, and so do
        fluxes, perhaps a mapping with one for each.
    scale_error : float
        Standard deviation of the logarithm of a factor that all values of a spectrum have in common, such as that of a
        white reference, 0 or 1e-6 to 1; it is retrieved too, for each measured quantity. All depths share it.
    correlation_nm : float
        Distance over which errors of neighbouring wavelengths correlate.
    angle_deg : float, "diffuse" or array
        Angle of the beam from the normal. Default: the spectrum's coordinate or attribute `angle_deg`, or its
        coordinate `angle` in degrees; if it has none, "diffuse", the light of an overcast sky.
    diffuse_fraction : float or array
        Fraction of the light that is diffuse, beside the beam; it may have the dimension `wavelength`, on which it is
        interpolated if the data are those of bands.
    thickness_cm : float or array
        Default: the spectrum's coordinate or attribute `thickness_cm`, or its coordinate `thickness` in cm; if it has
        none, infinity.
    ground_albedo : float or array
        As in :func:`snowblue.spectrum`. Default: the spectrum's coordinate or attribute; if it has none, 0.
    prior_correlation : array
        Correlation matrix of the prior, in the order of `retrieve`.
    streams, seed, progress
        As in :func:`snowblue.spectrum`.
    **snow
        Arguments of :class:`Snow`; what is retrieved is ignored. With `ssa_m2_kg` the grains have one size.

    Returns
    -------
    xarray.Dataset
        For each parameter (`ssa`, `black_carbon`; of one layer `ssa_0`, ...) the median of the posterior, `_sd`, its
        standard deviation to first order, and `_lower` and `_upper`, which hold 95 %. `averaging_kernel`, the
        derivative of the retrieved state by the true one, and `covariance`, both of the state. `degrees_of_freedom`:
        how many parameters the data determine. A parameter at an end of its range, beyond which the fit would improve,
        is held there: its rows of both matrices and its `_sd` are 0, and the others have their posterior given its
        value. `chi_square`, which is near `data`, the number of values, if model, errors and prior are right.
        `outcome`: "converged"; or which parameters are at ends of their ranges; "not converged"; or "no data", where
        the posterior is the prior. Measured and fitted spectra. The attribute `light` says which light was assumed.

    Raises
    ------
    ValueError
        For a value that is out of range, with its index: `albedo is 2, but must lie in -0.5–1.5, at pit[3],
        wavelength[7]`, or `..., in the band red`.

    Examples
    --------
    >>> import numpy as np
    >>> import snowblue
    >>> wavelength_nm = np.arange(400, 1401, 50)
    >>> measured = snowblue.albedo(ssa_m2_kg=[12, 20], angle_deg=60, wavelength_nm=wavelength_nm)
    >>> fit = snowblue.invert(measured, standard_deviation=0.01)
    >>> fit.ssa.round().values
    array([12., 20.])
    >>> fit.light
    "beam at 60 degrees, by the albedo's coordinate 'angle'"

    Soot in clean snow is not determined; the prior is.

    >>> bool((fit.averaging_kernel.sel(parameter="black_carbon", true_parameter="black_carbon") < 0.7).all())
    True
    """
    import xarray as xr

    given = {name: value for name, value in (("albedo", albedo), ("transmittance", transmittance)) if value is not None}
    deviations = {"albedo": standard_deviation, "transmittance": transmittance_standard_deviation}
    if transmittance is None and transmittance_standard_deviation is not None:
        raise TypeError("transmittance_standard_deviation is given without a transmittance")
    if fluxes is not None:
        at_depth = _fluxes(fluxes)
        given |= at_depth
        deviations |= _deviations(at_depth, fluxes_standard_deviation)
    elif fluxes_standard_deviation is not None:
        raise TypeError("fluxes_standard_deviation is given without fluxes")
    if not given:
        raise TypeError("no albedo, transmittance or fluxes are given")
    for name in given:
        if deviations[name] is None:
            raise TypeError(f"{name} needs {DEVIATIONS.get(name, 'fluxes_standard_deviation')}")
    packed = None if layers is None else packed_layers(layers)
    if packed is not None:
        for name in (*snow, *(["thickness_cm"] if thickness_cm is not None else [])):
            raise TypeError(f"{name} belongs to the layers")
    weights = None
    if bands is None:
        if light is not None:
            raise TypeError("light is given without bands")
        used_nm = wavelengths_nm = _wavelengths(given, wavelength_nm)
        channels = xr.Variable("wavelength", wavelengths_nm)
    else:
        curves = response_curves(bands)
        wavelengths_nm = _model_wavelengths(curves, wavelength_nm)
        weights = band_weights(curves, light, wavelengths_nm.tolist())
        used_nm = wavelengths_nm[weights.any(axis=0)]
        channels = xr.Variable("band", [*curves])
    measured = _measured(given, channels)
    first = next(iter(measured.values())).at_one_depth()
    names, priors = _priors(retrieve)
    axes = Axes()
    fixed = add_snow(axes, snow)
    for name, spectrum in measured.items():
        label = f"standard deviation of the {_in_words(name)}"
        axes.arrays[name] = spectrum.rows(name, spectrum.values, axes)
        axes.arrays[_deviation_of(name)] = spectrum.rows(label, deviations[name], axes)
    if diffuse_fraction is not None:
        spectrum = first
        if weights is not None:
            spectrum = _at_wavelengths(wavelengths_nm)
            diffuse_fraction = interpolated("diffuse fraction", diffuse_fraction, wavelengths_nm, used_nm)
        axes.arrays["diffuse_fraction"] = spectrum.rows("diffuse fraction", diffuse_fraction, axes)
    made: dict[str, Any] = {}
    for name, own in (("thickness_cm", thickness_cm), ("angle_deg", angle_deg), ("ground_albedo", ground_albedo)):
        if name == "thickness_cm" and packed is not None:
            # Layers have their own.
            axes.arrays[name] = xr.DataArray(np.inf)
            continue
        value, source = (own, "argument") if own is not None else _stated(name, measured)
        quantity = STATED[name][0]
        if quantity is GROUND_ALBEDO:
            add_ground(axes, value, xr.DataArray(wavelengths_nm, dims="wavelength"), used_nm)
        else:
            axes.add(name, quantity, value, angle if quantity is ANGLE else number)
        values = [] if is_lazy(axes.arrays[name]) else axes.arrays[name].values.ravel().tolist()
        values = angles_or_diffuse(values) if quantity is ANGLE else values
        made[name] = values[0] if len(values) == 1 else f"of the {source}"
        if quantity is ANGLE:
            made["light"] = _light(values, source, diffuse_fraction is not None)
    errors = {"scale_error": number("scale_error", scale_error)}
    errors["correlation_nm"] = number("correlation_nm", correlation_nm)
    labels = {_label(*name): name for name in names}
    unknowns = {
        "names": names,
        "labels": [*labels],
        "median": [median for median, _ in priors],
        "deviation": [deviation for _, deviation in priors],
        "correlation": None if prior_correlation is None else _matrix("prior_correlation", prior_correlation),
        "ordinates": ordinates(streams, seed),
    }
    packs = {
        "wavelength_nm": wavelengths_nm.tolist(),
        "bands": None if weights is None else weights.tolist(),
        "layers": packed,
    }
    quantities = [{"quantity": name, "depth_cm": one.depths_cm, **errors} for name, one in measured.items()]
    described = _described(labels, measured, is_scaled=errors["scale_error"] != 0)
    taken = {*channels.dims, "parameter", "true_parameter", *described}
    for dim in axes.sizes:
        if dim in taken:
            raise ValueError(f"an argument has a dimension '{dim}', which belongs to the results: rename it")
    inner = ("depth", *channels.dims, *([] if weights is None else ["wavelength"]))
    with reporting(axes.progress(progress), "spectra") as report:
        options = {"fixed": fixed, "packs": packs, "quantities": quantities, "unknowns": unknowns, "report": report}
        prior = _found(no_rows(axes.arrays, inner), **options)["prior"]
        bands = None if weights is None else [*curves]
        solve = functools.partial(_retrieved, dims={name: one.inner for name, one in measured.items()}, **options)
        found = in_blocks(solve, axes.arrays, axes.sizes, inner=inner, bands=bands, gaps=axes.gaps)
    made["prior"] = "; ".join(
        f"{_words(name, layer)}: median {'of the argument' if median is None else f'{median:g}'}, "
        f"deviation {deviation:g}"
        for (name, layer), (median, deviation) in zip(names, prior)
    )
    made |= errors | {"seed": seed}
    if packed is None:
        made = _without(single_values(fixed, axes.arrays), names, None) | made
        made.pop("snow_id", None)
    else:
        kept = [(_without(snow, names, place), thickness) for place, (snow, thickness) in enumerate(packed)]
        made = {"layers": described_layers(kept), **made}
    coords = {name: one for name, one in axes.coordinates(first.values).items() if name not in described}
    if weights is not None and "wavelength" in axes.arrays["ground_albedo"].dims:
        del coords["ground_albedo"]  # The wavelengths of the result are those of the bands.
    mean_nm = wavelengths_nm if weights is None else weights @ wavelengths_nm
    coords["wavelength"] = (channels.dims, mean_nm, WAVELENGTH.attributes())
    if weights is not None:
        coords["band"] = channels
        made["band_light"] = "ASTM G173-03" if light is None else str(light.name or "given")
    coords |= {"parameter": [*labels], "true_parameter": [*labels]}
    for spectrum in measured.values():
        if spectrum.depths_cm:
            coords["depth"] = ("depth", spectrum.depths_cm, DEPTH.attributes())
    variables = {name: (found[name].dims, found[name].data, attrs) for name, attrs in described.items()}
    return dataset(variables, coords, attributes(**made))


def _described(
    parameters: Mapping[str, tuple[str, int | None]], measured: Mapping[str, Measured], is_scaled: bool
) -> dict[str, dict[str, str]]:
    """The attributes of the variables of a result, of parameters by their labels."""
    long_names: dict[str, str] = {}
    units: dict[str, str] = {}
    for label, (name, layer) in parameters.items():
        quantity = parameter_quantity(name).attributes()
        for aspect, text in ASPECTS.items():
            long_names[label + aspect] = text.format(_words(quantity["long_name"], layer))
            units[label + aspect] = quantity["units"]
    for name, spectrum in measured.items():
        long_name = LONG_NAMES.get(name, name) if spectrum.depths_cm else name
        for aspect, text in ASPECTS.items() if is_scaled else ():
            long_names[f"{name}_scale{aspect}"] = text.format(f"measured over true {name}")
        long_names |= {name: f"measured {long_name}", f"{name}_fit": f"{long_name} of the retrieved snow"}
    long_names["averaging_kernel"] = "derivative of the retrieved state by the true one"
    long_names["covariance"] = "covariance of the posterior of the state"
    long_names |= NUMBERS
    described = {name: {"long_name": text, "units": units.get(name, "1")} for name, text in long_names.items()}
    return described | {"outcome": {"long_name": "how the search has ended"}}


def _found(
    rows: Mapping[str, np.ndarray],
    fixed: Mapping[str, Any],
    packs: Mapping[str, Any],
    quantities: Iterable[Mapping[str, Any]],
    unknowns: Mapping[str, Any],
    report: Any,
) -> dict[str, Any]:
    """What is retrieved from some spectra, and the priors that were used."""
    native, given = slabs_of_rows(fixed, rows, packs["wavelength_nm"])
    flat = {name: values.reshape(len(values), math.prod(values.shape[1:])) for name, values in rows.items()}
    measured = [
        {**one, "values": flat[one["quantity"]], "standard_deviation": flat[_deviation_of(one["quantity"])]}
        for one in quantities
    ]
    given |= {**packs, "diffuse_fraction": flat.get("diffuse_fraction"), "measured": measured}
    with locating_layers(packs["layers"] or []):
        return _native.invert(native, given, unknowns, report)


def _retrieved(
    rows: Mapping[str, np.ndarray], dims: Mapping[str, list[str]], unknowns: Mapping[str, Any], **options: Any
) -> dict[str, Any]:
    """The variables of what is retrieved from some spectra, which have further dimensions."""
    found = _found(rows, unknowns=unknowns, **options)
    labels = unknowns["labels"]
    of_states = [len(rows["angle_deg"]), len(labels), len(labels)]
    # The longest outcome: all parameters are at ends of their ranges.
    longest = " and ".join(_words(*name) for name in unknowns["names"]) + " are at ends of their ranges"
    variables: dict[str, Any] = {"outcome": ((), np.array(found["outcome"], dtype=f"U{len(longest)}"))}
    for name, own in dims.items():
        variables[name] = (own, rows[name])
        variables[f"{name}_fit"] = (own, found[f"{name}_fit"].reshape(rows[name].shape))
    for name in ("averaging_kernel", "covariance"):
        variables[name] = (["parameter", "true_parameter"], found[name].reshape(of_states))
    for label in (*labels, *(f"{name}_scale" for name in dims)):
        variables |= {label + aspect: ((), found[label + aspect]) for aspect in ASPECTS}
    for name in NUMBERS:
        variables[name] = ((), found[name].astype(np.int64) if name in ("data", "solutions") else found[name])
    return variables


def _deviation_of(quantity: str) -> str:
    """The name of the standard deviation of a measured quantity among the arguments."""
    return f"{quantity} deviation"


def _priors(retrieve: Any) -> tuple[list[tuple[str, int | None]], list[tuple[Any, Any]]]:
    """The name and the layer, or None, of each parameter, and the median and deviation of its prior, or None."""
    if isinstance(retrieve, str):
        retrieve = [retrieve]
    if not isinstance(retrieve, Iterable):
        raise ValueError(f"retrieve is {retrieve!r}, but must be names of parameters, or a mapping of names to priors")
    given_priors = retrieve.items() if isinstance(retrieve, Mapping) else [(key, None) for key in retrieve]
    names: list[tuple[str, int | None]] = []
    priors = []
    for key, prior in given_priors:
        name, layer = key if isinstance(key, (tuple, list)) and len(key) == 2 else (key, None)
        if not isinstance(name, str):
            raise ValueError(f"retrieve has {key!r}, but must have names, or pairs of a name and the number of a layer")
        layer = None if layer is None else whole("the number of the layer", layer)
        if layer is not None and layer >= MOST_LAYERS:
            raise ValueError(f"the number of the layer is {layer}, but must be below {MOST_LAYERS}")
        check_parameters([hyphenated(name)])
        names.append((hyphenated(name), layer))
        words = _words(*names[-1])
        try:
            median, deviation = (None, None) if prior is None else prior
        except (TypeError, ValueError):
            raise ValueError(f"the prior of {words} is {prior!r}, but must be a median and a deviation") from None
        given = (("median", median), ("deviation", deviation))
        priors.append(tuple(None if one is None else number(f"{what} of {words}", one) for what, one in given))
        if deviation is not None and not priors[-1][1] > 0:
            raise ValueError(f"deviation of {words} is {deviation}, but must be above 0")
    return names, priors


def _in_words(quantity: str) -> str:
    """What is measured."""
    return AT_DEPTH.get(quantity, quantity)


def _label(name: str, layer: int | None) -> str:
    """The name of a parameter in results."""
    label = {"ssa_m2_kg": "ssa"}.get(name, parameter_quantity(name).name)
    return label if layer is None else f"{label}_{layer}"


def _words(name: str, layer: int | None) -> str:
    """A name with that of its layer."""
    return name if layer is None else f"{name} of layer {layer}"


def _without(snow: Mapping[str, Any], names: list[tuple[str, int | None]], layer: int | None) -> dict[str, Any]:
    """The properties of the snow of a layer, or of all, without those that are retrieved."""
    retrieved = {name for name, own in names if own is None or own == layer}
    dropped = {"ssa_m2_kg", "grain_size_um", "size_measure"} if "ssa_m2_kg" in retrieved else set()
    dropped |= {key for name in retrieved for key in (name, mass_argument(name))}
    kept = {name: value for name, value in snow.items() if name not in dropped}
    impurities = kept.pop("impurities_ng_g", {})
    impurities = {name: value for name, value in impurities.items() if hyphenated(name) not in retrieved}
    return kept | ({"impurities_ng_g": impurities} if impurities else {})


def _fluxes(given: Mapping[str, Any]) -> dict[str, xr.DataArray]:
    """Fluxes with their depths."""
    arrays: dict[str, xr.DataArray] = {}
    for name, value in mapping("fluxes", given, "{'down': array}").items():
        if name not in AT_DEPTH:
            raise ValueError(f"fluxes have {name!r}, but may have {', '.join(AT_DEPTH)}")
        if "depth" not in getattr(value, "dims", ()) or "depth" not in getattr(value, "coords", ()):
            raise ValueError(f"{name} must be an xarray.DataArray with the dimension 'depth' and its values in cm")
        if value.ndim == 1:
            raise ValueError(f"{name} has no dimension of wavelengths")
        unit = value.depth.attrs.get("units", DEPTH.unit)
        if unit != DEPTH.unit:
            raise ValueError(f"{name} has depths in {unit}, but they must be in {DEPTH.unit}")
        depths_cm = own_axis(DEPTH, value.depth.values).values.tolist()
        if not depths_cm or not np.isfinite(depths_cm).all():
            raise ValueError(f"{name} must have depths, and all of them finite")
        for other, array in arrays.items():
            if array.depth.values.tolist() != depths_cm:
                raise ValueError(f"{name} has other depths than {other}")
        arrays[name] = value
    if not arrays:
        raise ValueError("fluxes are empty")
    return arrays


def _deviations(fluxes: Mapping[str, Any], given: Any) -> dict[str, Any]:
    """The standard deviation of each flux."""
    if not isinstance(given, Mapping):
        return dict.fromkeys(fluxes, given)
    for name in given:
        if name not in fluxes:
            raise ValueError(f"fluxes_standard_deviation has {name!r}, but the fluxes are {', '.join(fluxes)}")
    return {name: given[name] if name in given else None for name in fluxes}


def _with_channels(value: xr.DataArray, dim: str, channels: xr.Variable) -> xr.DataArray:
    """An array whose dimension of wavelengths or bands, if it has one, is called so, without labels of another name."""
    [own] = channels.dims
    if dim != own and dim in value.dims:
        value = value.swap_dims({dim: own}).drop_vars(dim, errors="ignore")
    if own != "band" or "band" not in value.dims or "band" not in value.coords:
        return value
    names = value.band.values
    if names.dtype.kind not in "OU":
        return value.drop_vars("band")
    is_same_set = len(names) == channels.size and {*names.tolist()} == {*channels.values.tolist()}
    return value.sel(band=channels.values) if is_same_set else value


@dataclass
class Measured:
    """A measured spectrum."""

    values: xr.DataArray
    """The wavelength or band is the last dimension, with its coordinate, perhaps after the depth."""
    given: xr.DataArray
    """The array that is given."""
    dim: str
    """What it calls the dimension of the wavelength or band."""

    @property
    def depths_cm(self) -> list[float]:
        return self.values.depth.values.tolist() if "depth" in self.values.dims else []

    @property
    def inner(self) -> list[str]:
        """The dimensions that belong to one pack."""
        return [*(["depth"] if "depth" in self.values.dims else []), str(self.values.dims[-1])]

    def at_one_depth(self) -> Measured:
        """The spectrum at one of the depths."""
        if not self.depths_cm:
            return self
        return Measured(self.values.isel(depth=0, drop=True), self.given.isel(depth=0, drop=True), self.dim)

    def rows(self, label: str, value: Any, axes: Axes) -> xr.DataArray:
        """Values on some dimensions, which are added to the axes, and then at all depths and channels."""
        import xarray as xr

        channels = self.values[self.values.dims[-1]].variable
        value = labelled(value)
        if not hasattr(value, "dims"):
            array = value if is_lazy(value) else _floats(label, value)
            known = {(): (), (channels.size,): (self.dim,), self.given.shape: self.given.dims}
            if array.shape not in known:
                raise ValueError(
                    f"the {label} has the shape {array.shape}, but there are {channels.size} {channels.dims[0]}s, and "
                    f"spectra of the shape {self.given.shape}"
                )
            value = xr.DataArray(array, dims=known[array.shape])
        value = _with_channels(value, self.dim, channels)
        for dim in self.inner:
            labels = self.values[dim].values
            if dim not in value.dims:
                value = value.expand_dims({dim: labels})
            elif not _has_labels(value, dim, labels):
                raise ValueError(f"the {label} has other {dim}s than the {'fluxes' if dim == 'depth' else 'spectra'}")
        value = value.astype(float).transpose(..., *self.inner)
        axes.broadcast(label, value.isel(dict.fromkeys(self.inner, 0), drop=True))
        return value


def _has_labels(value: xr.DataArray, dim: str, labels: np.ndarray) -> bool:
    """Whether an array has as many values along a dimension, and no other labels."""
    is_same_size = value.sizes.get(dim) == len(labels)
    return is_same_size and (dim not in value.coords or np.array_equal(value[dim].values, labels))


def _wavelengths(given: dict[str, Any], wavelength_nm: Any) -> np.ndarray:
    """The wavelengths of the spectra."""
    if wavelength_nm is None:
        for value in map(labelled, given.values()):
            if "wavelength" in getattr(value, "dims", ()) and "wavelength" in value.coords:
                wavelength_nm = value.wavelength
                break
        else:
            name = next(iter(given))
            words = f"the {_in_words(name)} has no dimension 'wavelength' with values"
            raise TypeError(f"wavelength_nm is missing, and {words}")
    values_nm = wavelengths(wavelength_nm).values
    if values_nm.size == 0:
        raise ValueError("wavelength_nm has no values")
    return values_nm


def _model_wavelengths(curves: Mapping[str, Curve | None], wavelength_nm: Any) -> np.ndarray:
    """The wavelengths at which the model is solved."""
    if wavelength_nm is not None:
        return own_axis(WAVELENGTH, wavelength_nm).values
    points: set[float] = set()
    for name, curve in curves.items():
        if curve is None:
            raise TypeError(f"wavelength_nm is missing, and the band {name} has no response")
        own_nm = curve[0]
        if own_nm:
            steps = np.ceil(abs(own_nm[-1] - own_nm[0]) / BAND_STEP_NM)
            points |= {*np.linspace(own_nm[0], own_nm[-1], int(min(steps, MOST_STEPS)) + 1).tolist()}
    return np.array(sorted(points))


def _at_wavelengths(wavelengths_nm: np.ndarray) -> Measured:
    """A spectrum at the wavelengths of the model, with which others pair."""
    import xarray as xr

    values = xr.DataArray(np.zeros(len(wavelengths_nm)), {"wavelength": wavelengths_nm}, ["wavelength"])
    return Measured(values, values, "wavelength")


def _measured(given: dict[str, Any], channels: xr.Variable) -> dict[str, Measured]:
    """The measured spectra."""
    import xarray as xr

    [own] = channels.dims
    measured = {}
    for name, value in given.items():
        as_given = labelled(value)
        Quantity(name, "1").check(as_given)
        if not hasattr(as_given, "dims"):
            array = as_given if is_lazy(as_given) else np.atleast_1d(_floats(name, as_given))
            as_given = xr.DataArray(array, dims=[*(f"dim_{i}" for i in range(array.ndim - 1)), own])
        if own == "band" and "wavelength" in as_given.dims:
            words = f"the {_in_words(name)} has the dimension 'wavelength'"
            raise ValueError(f"{words}, but its values must be those of the bands")
        inner = [dim for dim in as_given.dims if dim != "depth"]
        dim = own if own in as_given.dims or not inner else inner[-1]
        value = _with_channels(as_given, dim, channels)
        if value.sizes.get(own) != channels.size:
            words = f"there are {channels.size} {own}s"
            raise ValueError(f"the {_in_words(name)} has the shape {as_given.shape}, but {words}")
        if not _has_labels(value, own, channels.values):
            raise ValueError(f"the {_in_words(name)} has other {own}s than those given")
        value = value.astype(float).transpose(..., own).assign_coords({own: channels.values})
        measured[name] = Measured(value, as_given, dim)
    return measured


def _floats(label: str, value: Any) -> np.ndarray:
    """The values of a list or an array as numbers."""
    try:
        return np.asarray(values_of(value), dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{label} is not an array of numbers with rows of one length") from None


def _matrix(label: str, value: Any) -> np.ndarray:
    """An array with rows and columns."""
    array = _floats(label, value)
    return array if array.ndim == 2 else array.reshape(1, -1)


def _stated(name: str, measured: dict[str, Measured]) -> tuple[Any, str]:
    """What a spectrum states of an argument that is not given, or the default, and where it is from."""
    quantity, other, default = STATED[name]
    for label, spectrum in measured.items():
        array = spectrum.values
        if name in array.coords:
            return array.coords[name], f"{label}'s coordinate '{name}'"
        if name in array.attrs:
            return array.attrs[name], f"{label}'s attribute '{name}'"
        if other in array.coords:
            unit = array.coords[other].attrs.get("units")
            if unit is None or powers_of(unit) != powers_of(quantity.unit):
                raise ValueError(
                    f"the {label} has a coordinate '{other}' with the units {unit}, but they must be {quantity.unit}: "
                    f"give {name}"
                )
            return array.coords[other], f"{label}'s coordinate '{other}'"
    return default, "default"


def _light(angles_deg: list[Any], source: str, is_mixed: bool) -> str:
    """Which light was assumed, and why."""
    beams = {angle for angle in angles_deg if angle != "diffuse"}
    kinds = ["diffuse"] if "diffuse" in angles_deg else []
    if not angles_deg:
        kinds = ["beams or diffuse light at several angles"]
    elif beams:
        kinds.append(f"beam at {beams.pop():g} degrees" if len(beams) == 1 else "beams at several angles")
    text = " or ".join(kinds)
    text += " with diffuse light" if is_mixed else ""
    return text + {"argument": "", "default": ", by default"}.get(source, f", by the {source}")
