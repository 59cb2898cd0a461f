"""Spectra of slabs and of layers, and distributions over directions."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from snowblue import _native
from snowblue._arguments import (
    ANGLE,
    DEPTH,
    FLUXES,
    GROUND_ALBEDO,
    SNOW,
    SNOW_NAMES,
    SUBSTANCES,
    THICKNESS,
    VISIBLE_NM,
    WAVELENGTH,
    WORDS,
    Axes,
    Quantity,
    Snow,
    add_ground,
    add_snow,
    angle,
    angles_or_diffuse,
    argument_names,
    array_of,
    at_first,
    attributes,
    by_argument,
    by_substance,
    check_engine,
    check_names,
    checks_names,
    grounds,
    hyphenated,
    is_several,
    located,
    mapping,
    mass_argument,
    names_of,
    number,
    one_ground,
    one_snow,
    ordinates,
    own_axis,
    shown,
    single_values,
    slabs_of_rows,
    suggestion,
    truth,
    wavelengths,
    whole,
    word,
)
from snowblue._blocks import dataset, filled, in_blocks
from snowblue._progress import Progress, reporting

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from typing_extensions import Unpack

LONG_NAMES = {
    "reflectance": "reflectance",
    "transmittance": "transmittance, direct and diffuse",
    "absorptance": "absorptance",
    "direct": "direct transmittance",
    "ground": "downward flux at the ground per incident flux",
    "down": "downward flux per incident flux",
    "up": "upward flux per incident flux",
    "net": "net downward flux per incident flux",
    "fluence": "fluence rate (actinic flux) per incident flux",
    "e_folding_depth": "e-folding depth of light deep in snow like that of the layer",
    "extinction": "extinction coefficient",
    "coalbedo": "single-scattering co-albedo",
    "asymmetry": "asymmetry parameter",
    "moments": "Legendre moments of the phase function",
    "brf": "bidirectional reflectance factor",
    "brdf": "bidirectional reflectance distribution function",
    "btdf": "bidirectional transmittance distribution function",
}
UNITS = {"e_folding_depth": "cm", "extinction": "m-1", "brdf": "sr-1", "btdf": "sr-1"}
JACOBIAN = {
    **{name: SNOW[name] for name, *_, has_derivative in _native.properties() if has_derivative},
    "thickness_cm": THICKNESS,
    "ground_albedo": GROUND_ALBEDO,
    "cos_angle": Quantity("cos_angle", "1", "cosine of the angle of incidence"),
}
"""Parameters of derivatives other than impurities."""
DEPTH_FLUXES = ("down", "up", "net", "fluence", "e_folding_depth")
VIEW_ZENITH = Quantity("view_zenith", "degree", "angle of the view from the normal")
VIEW_AZIMUTH = Quantity("view_azimuth", "degree", "azimuth of the view from the forward direction")
NEW_SNOW = Quantity("new_snow", "m2 kg-1", "specific surface area of the snow when it was new")
KIND = Quantity("kind", long_name="kind of a layer that is not snow")
AGE = Quantity("age", "h", "age of the snow")
ASPECTS = {
    "_se": "standard error of {}",
    "_lower": "{}, lower end of the interval that holds 95 % of the cases",
    "_upper": "{}, upper end of the interval that holds 95 % of the cases",
}
DEFAULT_RAYS = 100_000


@checks_names(*SNOW_NAMES)
def spectrum(
    *,
    thickness_cm: Any = 15.0,
    angle_deg: Any = 0.0,
    wavelength_nm: Any = VISIBLE_NM,
    ground_albedo: Any = 0.0,
    engine: Literal["ordinates", "montecarlo"] = "ordinates",
    streams: int | str = "auto",
    rays: int = DEFAULT_RAYS,
    per_wavelength: bool = False,
    seed: int = 1,
    standard_errors: bool = True,
    jacobian: str | Iterable[str] = (),
    plus_minus: Mapping[str, Any] | None = None,
    progress: Progress = None,
    **snow: Unpack[Snow],
) -> xr.Dataset:
    """Reflectance, transmittance and absorptance of slabs of snow.

    Arguments are broadcast as xarray broadcasts: a list or an array makes an axis of its own, and
    :class:`xarray.DataArray` arguments that share a dimension are paired along it, so that there is one slab for
    each row of a table. Where an argument of several values is NaN, or an angle beyond 89.99 (night), the results are
    NaN. If an argument is an array of dask, the result is computed by blocks, when it is asked for.
    Snows that differ in anything but the shapes of their grains (facetness, sphericity) share the rays through grains,
    which take most of the time of a first spectrum.

    Parameters
    ----------
    thickness_cm : float or array, 0 to 100000
        Infinity is a half-space, by discrete ordinates only.
    angle_deg : float, "diffuse" or array
        Angle of a beam from the normal (0 to 89.99), or Lambertian light. In the result diffuse light is -1.
    wavelength_nm : float or array, 300 to 2500
        All slabs have the same wavelengths.
    ground_albedo : float or array, 0 to 1
        On a ground that reflects, `transmittance` is the downward flux at the ground per incident flux, and absorptance
        that of the snow, as in :func:`layers`. A DataArray or Series on `wavelength` is a spectrum, linear between its
        wavelengths, which must cover those of the snow.
    engine : "ordinates" or "montecarlo"
        Discrete ordinates, or random walks from grain to grain.
    streams : even int or "auto"
        Directions of the discrete ordinates in both hemispheres.
    rays : int
        Random walks for each angle and index node, shared by wavelengths and thicknesses.
    per_wavelength : bool
        Separate random walks for each wavelength and thickness, as in the paper.
    seed : int
        Seed of all randomness.
    standard_errors : bool
        Standard errors: variables that end in `_se`. Values alone take about half of the time, once the grains are
        known. Random walks always have errors.
    jacobian : str or several, optional
        Parameters with respect to which the results are differentiated, by discrete ordinates only: `ssa_m2_kg`,
        `density_kg_m3`, `thickness_cm`, `water_saturation`, `ground_albedo`, the names of impurities, and `cos_angle`,
        the cosine of the angle of incidence. The variable `reflectance_per_ssa_m2_kg` is the derivative of the
        reflectance with respect to the specific surface area, in kg/m², and so on. Derivatives are exact for the
        values as computed, and have no standard errors.
    plus_minus : mapping, optional
        Standard deviations of what the snow is made of, such as `{"ssa_m2_kg": 2, "density_kg_m3": 30,
        "black-carbon": 5, "ice": True}`; `grain_size_um` too. `reflectance_lower` and `reflectance_upper`, and so on,
        are the ends of the interval that then holds 95 % of the cases, by 400 snows. Quantities are log-normal with the
        given value as mean, and independent; `ice` makes either table equally likely. By discrete ordinates only.
    progress : bool or callable, optional
    **snow
        `grain_size_um`, `density_kg_m3` and the other arguments of :class:`Snow`.

    Returns
    -------
    xarray.Dataset
        Fractions of the incident flux, on the axes of the snow, then thickness, angle, ground and wavelength. A
        thickness or angle that is one number is an axis of length 1.

    Raises
    ------
    ValueError
        For a value that is out of range, with its index where there are several: `density is 1200 kg/m³, but must lie
        in 10–900 kg/m³, at site[17]`. All values are checked before anything is computed.

    Examples
    --------
    >>> import snowblue
    >>> thick = snowblue.spectrum(thickness_cm=[1, 30], wavelength_nm=[450, 650]).transmittance
    >>> bool(thick.sel(thickness=30, wavelength=450) > 5 * thick.sel(thickness=30, wavelength=650))
    True

    The rows of a table, each with its own thickness:

    >>> import xarray as xr
    >>> pits = xr.Dataset({"ssa": ("pit", [20.0, 40.0]), "depth": ("pit", [10.0, 25.0])})
    >>> snowblue.spectrum(ssa_m2_kg=pits.ssa, thickness_cm=pits.depth).reflectance.dims
    ('pit', 'angle', 'wavelength')

    What 1 ng/g more of soot does to the albedo:

    >>> dirty = snowblue.spectrum(thickness_cm=np.inf, wavelength_nm=[450, 1030], jacobian="black-carbon")
    >>> blue, infrared = dirty.reflectance_per_black_carbon.values.ravel()
    >>> bool(blue < 100 * infrared < 0)
    True
    """
    axes = Axes()
    fixed = add_snow(axes, snow)
    axes.add("thickness_cm", THICKNESS, thickness_cm, always=True)
    axes.add("angle_deg", ANGLE, angle_deg, angle, always=True)
    at = wavelengths(wavelength_nm)
    add_ground(axes, ground_albedo, at)
    if at.dims[0] in axes.sizes:
        raise ValueError(f"wavelength is an array over '{at.dims[0]}', but all slabs have the same wavelengths")
    jacobian = parameters(jacobian, engine)
    uncertainty = None if plus_minus is None else _uncertainty(plus_minus)
    if engine == "montecarlo" and uncertainty:
        raise ValueError("plus_minus needs the engine 'ordinates'")
    solve = functools.partial(
        _spectra,
        fixed=fixed,
        wavelength=at.variable,
        jacobian=jacobian,
        uncertainty=uncertainty,
        engine=_engine(engine, streams, rays, per_wavelength, seed, standard_errors),
    )
    made = _made(engine, streams, rays, per_wavelength, seed)
    with reporting(axes.progress(progress), "rays" if engine == "montecarlo" else "slabs") as report:
        # Blocks have all wavelengths, since the rays through grains are those of indices of refraction among them.
        solve = functools.partial(solve, report=report)
        variables = in_blocks(solve, axes.arrays, axes.sizes, inner=at.dims, gaps=axes.gaps)
    ground = axes.arrays["ground_albedo"]
    if ground.ndim == 0 and ground != 0:
        made["ground_albedo"] = ground.item()
    if plus_minus is not None:
        made["plus_minus"] = ", ".join(f"{name}: {value}" for name, value in plus_minus.items())
    coords = {name: one for name, one in axes.coordinates(at).items() if name not in variables}
    coords["wavelength"] = at.variable
    solved = _dataset(variables, coords, single_values(fixed, axes.arrays) | made)
    if ground.ndim > 0 or ground > 0:
        _describe_ground(solved, made.get("ground_albedo"))
    return solved


def _spectra(
    rows: Mapping[str, np.ndarray],
    fixed: Mapping[str, Any],
    wavelength: xr.Variable,
    jacobian: list[str],
    uncertainty: tuple[list[tuple[str, float]], bool] | None,
    engine: Mapping[str, Any],
    report: Any,
) -> dict[str, Any]:
    """The spectra of some slabs."""
    if engine["rays"] is not None and np.isinf(rows["thickness_cm"]).any():
        raise ValueError(
            "thickness_cm is inf, a half-space, which needs the engine 'ordinates': give 'montecarlo' a finite one"
        )
    native, cases = slabs_of_rows(fixed, rows, wavelength.values.tolist())
    cases["jacobian"] = jacobian
    found = _native.spectrum(native, cases, engine, report)
    if uncertainty:
        found |= _native.spread(native, cases, uncertainty, engine, report)
    return {
        name.replace("-", "_"): (wavelength.dims, values.reshape(len(cases["places"]), wavelength.size))
        for name, values in found.items()
    }


def _describe_ground(solved: xr.Dataset, ground_albedo: float | None) -> None:
    """Names the transmittance above bright ground, and gives each spectrum the albedo of the ground as an attribute,
    which :func:`invert` reads. An albedo that is an axis is a coordinate already."""
    solved.transmittance.attrs["long_name"] = LONG_NAMES["ground"]
    if ground_albedo is not None:
        for name in ("reflectance", "transmittance"):
            solved[name].attrs["ground_albedo"] = ground_albedo


SPECTRUM_NAMES = (*argument_names(spectrum), *SNOW_NAMES)


@checks_names(*(name for name in SPECTRUM_NAMES if name not in ("standard_errors", "jacobian", "plus_minus")))
def albedo(
    *, thickness_cm: Any = np.inf, angle_deg: Any = "diffuse", wavelength_nm: Any = VISIBLE_NM, **arguments: Any
) -> xr.DataArray:
    """Spectral albedo of snow, by default of an infinite depth under an overcast sky.

    It is the reflectance of :func:`spectrum`, whose arguments it takes, without standard errors, derivatives and
    intervals. An argument that is one number makes no axis.

    Examples
    --------
    >>> import snowblue
    >>> fresh, old = snowblue.albedo(ssa_m2_kg=[60, 10], wavelength_nm=1030)
    >>> bool(fresh > old + 0.1)
    True
    """
    solved = spectrum(
        thickness_cm=thickness_cm,
        angle_deg=angle_deg,
        wavelength_nm=wavelength_nm,
        standard_errors=False,
        jacobian=(),
        **arguments,
    )
    # A tuple of wavelengths is a list.
    single = [("thickness", thickness_cm), ("angle", angle_deg), ("wavelength", wavelength_nm)]
    found = solved.reflectance.squeeze([name for name, value in single if np.ndim(value) == 0])
    made = {name: value for name, value in solved.attrs.items() if name not in ("Conventions", "source")}
    return found.rename("albedo").assign_attrs(long_name="albedo", **made)


@checks_names()
def layers(
    layers: Iterable[Mapping[str, Any]] | pd.DataFrame | xr.Dataset,
    *,
    ground_albedo: Any = 0.0,
    depth_cm: Any = (),
    angle_deg: Any = 0.0,
    wavelength_nm: Any = VISIBLE_NM,
    engine: Literal["ordinates", "montecarlo"] = "ordinates",
    streams: int | str = "auto",
    rays: int = DEFAULT_RAYS,
    seed: int = 1,
    standard_errors: bool = True,
    jacobian: str | Iterable[str] = (),
    progress: Progress = None,
) -> xr.Dataset:
    """Fluxes of layers of snow and clear ice on a ground, and at depths.

    Parameters
    ----------
    layers : mappings, pandas.DataFrame or xarray.Dataset, top first
        Each has `thickness_cm`, and arguments of :class:`Snow`. The last may be infinitely thick. A layer of clear ice
        is `{"kind": "ice", "thickness_cm": 1}`; it may have the table `ice` too, and nothing else. In a row of a
        DataFrame, NaN is an argument that is not given, but a size of grains must be, or a kind of snow. Columns such
        as `black_carbon_ng_g` are impurities. A Dataset has these columns as variables on `layer`, and many packs on
        further dimensions, such as `time`: they share the rays through grains. Layers without a thickness (NaN) are
        absent; they must lie below the others. A pack of which anything else is missing has NaN as results, as has a
        depth below its ground. The word "" is a word that is not given.
    ground_albedo : float, 0 to 1, or a spectrum on `wavelength` as in :func:`spectrum`
        On a ground that reflects, `transmittance` is the downward flux at the ground per incident flux. It may
        exceed 1, since light is reflected back and forth.
    depth_cm : array
        Depths at which the fluxes `down`, `up` and `net` through a level plane and the `fluence` rate (the actinic
        flux, from all directions) are computed, by discrete ordinates only. `e_folding_depth` is that of light deep in
        snow like that of the layer, far from all faces. At a face of ice the fluxes and the fluence rate are those
        outside it; `e_folding_depth` at a face of ice to air is that of the ice.
    angle_deg, wavelength_nm, engine, streams, rays, seed
        As in :func:`spectrum`; of several angles also NaN. Angles and grounds of a Dataset pair along its dimensions.
    standard_errors : bool
        Standard errors: variables that end in `_se`. Random walks always have them.
    progress : bool or callable, optional
        As in :func:`spectrum`, of random walks and of packs of a Dataset.
    jacobian : str or several, optional
        Parameters with respect to which the results are differentiated, as in :func:`spectrum`. Derivatives such as
        `down_per_density_kg_m3` have the dimension `changed_layer`, the number of the layer whose property changes,
        from the top; those with respect to `ground_albedo` and `cos_angle` have none. Depths stay where they are below
        the surface when a thickness changes. At the depth of a face derivatives are those in the snow below it, at the
        ground and at the top of ice above it. Ice has the derivative 0 with respect to all of snow but the thickness.

    Returns
    -------
    xarray.Dataset
        Fractions of the incident flux on angle and wavelength, and on angle, wavelength and depth; derivatives also
        on changed_layer. The dimensions of a Dataset come first. Absorptance is that of the snow: 1 - reflectance -
        (1 - ground_albedo) transmittance.

    Examples
    --------
    >>> import snowblue
    >>> fresh_on_firn = [dict(thickness_cm=3, snow="fresh"), dict(thickness_cm=50, snow="firn")]
    >>> pack = snowblue.layers(fresh_on_firn, wavelength_nm=[850, 1030])
    >>> float(pack.reflectance.sel(wavelength=850).item()) > 0.8
    True

    A mass fraction of soot darkens more in the thick layer, although that lies below:

    >>> sooty = snowblue.layers(fresh_on_firn, wavelength_nm=450, jacobian="black-carbon", standard_errors=False)
    >>> upper, lower = sooty.reflectance_per_black_carbon.squeeze().values
    >>> bool(lower < upper < 0)
    True

    Two days, of which the first has one layer:

    >>> import xarray as xr
    >>> columns = {"thickness_cm": [[20, np.nan], [5, 20]], "ssa_m2_kg": [[15, np.nan], [60, 15]]}
    >>> days = xr.Dataset({name: (("time", "layer"), values) for name, values in columns.items()})
    >>> bare, fresh = snowblue.layers(days, wavelength_nm=1030, standard_errors=False).reflectance.squeeze()
    >>> bool(fresh > bare + 0.1)
    True
    """
    wavelength = own_axis(WAVELENGTH, wavelengths(wavelength_nm))
    depth = own_axis(DEPTH, depth_cm)
    if engine == "montecarlo" and depth.size > 0:
        raise ValueError("depth_cm needs the engine 'ordinates'")
    coords = {"wavelength": wavelength} | ({"depth": depth} if depth.size > 0 else {})
    options = _engine(engine, streams, rays, False, seed, standard_errors)
    jacobian = parameters(jacobian, engine)
    engine_made = _made(engine, streams, rays, False, seed)
    lights = {"wavelength_nm": wavelength.values.tolist(), "depths": depth.size}
    if hasattr(layers, "data_vars"):
        if engine == "montecarlo":
            raise ValueError("layers of a Dataset need the engine 'ordinates'")
        axes = Axes()
        count = _add_packs(axes, layers)
        axes.add("angle_deg", ANGLE, angle_deg, angle, always=True)
        add_ground(axes, ground_albedo, wavelength)
        solve = functools.partial(
            _packs, depth_cm=depth.values, jacobian=jacobian, engine=options, lights={**lights, "layers": count}
        )
        with reporting(axes.progress(progress), "packs") as report:
            variables = in_blocks(
                functools.partial(solve, report=report),
                axes.arrays,
                axes.sizes,
                inner=("layer", "wavelength"),
                gaps=axes.gaps,
            )
        coords = axes.coordinates() | coords
        ground = axes.arrays["ground_albedo"]
        stated = {"ground_albedo": ground.item()} if ground.ndim == 0 else {}
        made = {"layers": "of the dataset", **stated, **engine_made}
        is_bright = ground.ndim > 0 or ground > 0
    else:
        packed = packed_layers(layers)
        count = len(packed)
        coords = {"angle": own_axis(ANGLE, angle_deg, angle)} | coords
        # Of several angles, those at night and those that are missing have no results.
        is_day = coords["angle"].values <= _native.GREATEST_ANGLE_DEG
        is_day |= not is_several(angle_deg)
        angles_deg = angles_or_diffuse(coords["angle"][is_day]) or [0.0]
        lights |= {"pack": [0] * len(angles_deg), "angle_deg": angles_deg, "layers": count}
        albedo, of_ground, stated = one_ground(ground_albedo, wavelength)
        pack = {"layers": packed, "ground_albedo": albedo, "depth_cm": depth.values.tolist()}
        with reporting(progress, "rays") as report, locating_layers(packed, pack["depth_cm"], angles_deg):
            arrays = _native.stacks([pack], lights, jacobian, options, report)
        variables = {}
        for name, (dims, values) in _of_packs(arrays, lights).items():
            all_values = np.full([is_day.size, *values.shape[1:]], np.nan)
            all_values[is_day] = values[: is_day.sum()]
            variables[name] = (["angle", *dims], all_values)
        coords |= of_ground
        made = {"layers": described_layers(packed), **stated, **engine_made}
        is_bright = of_ground or albedo > 0
    if jacobian:
        coords["changed_layer"] = changed_layer(count)
    solved = _dataset(variables, coords, made)
    if is_bright:
        _describe_ground(solved, stated.get("ground_albedo"))
    return solved


def _of_packs(arrays: Mapping[str, np.ndarray], lights: Mapping[str, Any]) -> dict[str, Any]:
    """Fluxes under some lights: the dimensions after that of the lights, and the values."""
    sizes = {"wavelength": len(lights["wavelength_nm"]), "depth": lights["depths"], "changed_layer": lights["layers"]}
    variables = {}
    for name, array in arrays.items():
        flux, _, parameter = name.partition("_per_")
        dims = ["wavelength", *([] if flux.removesuffix("_se") in FLUXES else ["depth"])]
        dims += ["changed_layer"] if is_of_layers(parameter) else []
        shape = [len(lights["pack"]), *(sizes[dim] for dim in dims)]
        variables[name.replace("-", "_")] = (dims, array.reshape(shape))
    return variables


def _add_packs(axes: Axes, packs: xr.Dataset) -> int:
    """Adds the properties of packs of layers on `layer`, and gives the number of layers."""
    if "layer" not in packs.dims or "thickness_cm" not in packs:
        raise ValueError("the dataset of layers needs the dimension 'layer', top first, and the variable thickness_cm")
    masses = {mass_argument(substance): substance for substance in SUBSTANCES}
    quantities = {**SNOW, "thickness_cm": THICKNESS, "kind": KIND}
    quantities |= {name: Quantity(name, "ng g-1") for name in masses}
    check_names(quantities, packs.data_vars)
    for name in packs.variables:
        if name not in quantities:
            continue
        array = packs[name].drop_vars([coord for coord in packs.coords if coord in quantities])
        array = array_of(quantities[name], array, word if name in (*WORDS, "kind") else number)
        array = array if "layer" in array.dims else array.expand_dims(layer=packs.sizes["layer"])
        array = array.transpose(..., "layer")
        axes.broadcast(name, at_first(array, "layer"))
        axes.arrays[masses.get(name, name)] = array
    return packs.sizes["layer"]


def _packs(
    rows: Mapping[str, np.ndarray],
    depth_cm: np.ndarray,
    jacobian: list[str],
    engine: Mapping[str, Any],
    lights: Mapping[str, Any],
    report: Any,
) -> dict[str, Any]:
    """The fluxes of packs under a light each; NaN where a property of a pack is missing, or all layers are."""
    albedos = grounds(rows["ground_albedo"], lights["wavelength_nm"])
    columns = {name: values.tolist() for name, values in rows.items() if name not in ("ground_albedo", "angle_deg")}
    order = np.argsort(depth_cm, kind="stable")
    packs: list[dict[str, Any]] = []
    numbers: dict[Any, int | None] = {}
    places = []
    for row, albedo in enumerate(albedos):
        values = [tuple(column[row]) for column in columns.values()]
        key = (*map(repr, values), repr(albedo))
        if key not in numbers:
            layers = _pack([dict(zip(columns, layer)) for layer in zip(*values)])
            numbers[key] = None if layers is None else len(packs)
            if layers is not None:
                bottom_cm = sum(thickness_cm for _, thickness_cm in layers) * (1.0 + 1e-12)
                own_cm = depth_cm[order][depth_cm[order] <= bottom_cm].tolist()
                packs.append({"layers": layers, "ground_albedo": albedo, "depth_cm": own_cm})
        places.append(numbers[key])
    is_known = np.array([place is not None for place in places], dtype=bool)
    lights = {
        **lights,
        "pack": [place for place in places if place is not None],
        "angle_deg": angles_or_diffuse(rows["angle_deg"][is_known]),
    }
    try:
        arrays = _native.stacks(packs, lights, jacobian, engine, report)
    except ValueError as error:
        message, *row = error.args
        raise ValueError(message, *(int(np.flatnonzero(is_known)[place]) for place in row)) from None
    found = {}
    for name, (dims, values) in _of_packs(arrays, lights).items():
        if "depth" in dims:
            values = np.take(values, np.argsort(order), axis=1 + dims.index("depth"))
        found[name] = (dims, filled(values, is_known))
    return found


def _pack(layers: list[dict[str, Any]]) -> list[tuple[dict[str, Any], float]] | None:
    """The layers that have a thickness, for the engine; None if there is none, if one lies below a layer without
    thickness, or if a property is missing."""
    present = [layer for layer in layers if layer["thickness_cm"] == layer["thickness_cm"]]
    if not present or layers[: len(present)] != present:
        return None
    packed = []
    for layer in present:
        # Ice has no properties of snow.
        is_ice = layer.get("kind", "") != ""
        known = {name: value for name, value in layer.items() if value != "" and not (is_ice and value != value)}
        if any(value != value for value in known.values()):
            return None
        thickness_cm = known.pop("thickness_cm")
        packed.append((known if is_ice else by_argument(known), thickness_cm))
    return packed


def packed_layers(
    layers: Iterable[Mapping[str, Any]] | pd.DataFrame,
) -> list[tuple[dict[str, Any], float]]:
    """The snow, or the kind of what is no snow, and the thickness of each layer."""
    packed = []
    what = "mappings in a list, or a pandas.DataFrame, top first, such as [{'thickness_cm': 10, 'snow': 'fresh'}]"
    if hasattr(layers, "keys") and not hasattr(layers, "columns"):
        raise ValueError(f"layers is one mapping, {shown(layers)}, but must be {what}")
    if isinstance(layers, str) or not isinstance(layers, Iterable):
        raise ValueError(f"layers is {shown(layers)}, but must be {what}")
    if hasattr(layers, "to_dict"):
        rows = layers.to_dict("records")
        layers = []
        for place, row in enumerate(rows):
            with located("layers", place, len(rows)):
                layers.append(_row_of_layers(row))
    layers = list(layers)
    for place, layer in enumerate(layers):
        layer = mapping(f"layers[{place}]", layer, "{'thickness_cm': 10, 'snow': 'fresh'}")
        check_names(["thickness_cm", "kind", *SNOW_NAMES], layer)
        if "thickness_cm" not in layer:
            raise TypeError(f"layers[{place}] has no thickness_cm")
        known = {name: value for name, value in layer.items() if name != "thickness_cm" and value is not None}
        with located("layers", place, len(layers)):
            for name in ("kind", "ice") if "kind" in known else ():
                if not isinstance(known.get(name, ""), str):
                    raise ValueError(f"{name} is {shown(known[name])}, but must be a word")
            known = known if "kind" in known else one_snow(known)
            packed.append((known, number("thickness_cm", layer["thickness_cm"])))
    return packed


def _row_of_layers(row: Mapping[str, Any]) -> dict[str, Any]:
    """A layer of a table, whose columns of impurities are named as those of the command."""
    import pandas as pd

    layer = {name: value for name, value in row.items() if np.ndim(value) > 0 or not pd.isna(value)}
    for name in ("ssa_m2_kg", "grain_size_um"):
        if name in row and not layer.keys() & {"ssa_m2_kg", "grain_size_um", "snow", "kind"}:
            raise ValueError(f"{name} is NaN: give it, or a kind of snow, or leave out the layer")
    for substance in SUBSTANCES:
        name = mass_argument(substance)
        if name in layer:
            layer["impurities_ng_g"] = {**layer.get("impurities_ng_g", {}), substance: layer.pop(name)}
    return layer


def is_of_layers(parameter: str) -> bool:
    """Whether a derivative with respect to a parameter is one of layers. Values have no parameter."""
    return parameter not in ("", "cos_angle", "ground_albedo")


def changed_layer(count: int) -> xr.Variable:
    """The coordinate of derivatives of layers."""
    import xarray as xr

    attrs = {"long_name": "number of the layer that changes, from the top"}
    return xr.Variable("changed_layer", np.arange(count), attrs)


@contextmanager
def locating_layers(
    packed: list[tuple[dict[str, Any], float]], depths_cm: Iterable[float] = (), angles_deg: Iterable[Any] = ()
) -> Iterator[None]:
    """Says in which layer, at which of the depths or at which of the angles a value is wrong."""
    try:
        yield
    except ValueError as error:
        message, *others = error.args
        # Only the last layer may be infinitely thick.
        causes = {
            "layers": [{"layers": [layer, ({}, 1.0)]} for layer in packed[:-1]] + [{"layers": packed[-1:]}],
            DEPTH.name: [{"layers": packed, "depth_cm": [depth_cm]} for depth_cm in depths_cm],
            ANGLE.name: [{"layers": packed, "angle_deg": [angle_deg]} for angle_deg in angles_deg],
        }
        for name, alone in causes.items():
            for place, one in enumerate(alone):
                if len(alone) > 1 and _refusal(**one) == message:
                    raise ValueError(f"{message}, at {name}[{place}]", *others) from None
        raise


def _refusal(layers: list[Any], depth_cm: list[float] = [], angle_deg: list[Any] = []) -> str:
    """What is wrong with layers, depths or angles. Nothing is solved: at last, no wavelength is given."""
    pack = {"layers": layers, "ground_albedo": 0.0, "depth_cm": depth_cm}
    lights = {"pack": [0] * len(angle_deg), "angle_deg": angle_deg, "wavelength_nm": [], "layers": 0, "depths": 0}
    try:
        _native.stacks([pack], lights, [], _engine("ordinates", "auto", 2, False, 1, False), None)
    except ValueError as error:
        return error.args[0]
    return ""


def described_layers(packed: list[tuple[dict[str, Any], float]]) -> str:
    """Layers in words."""
    return "; ".join(
        ", ".join([f"{thickness_cm:g} cm", *(f"{name}={value}" for name, value in snow.items())])
        for snow, thickness_cm in packed
    )


@checks_names(*SNOW_NAMES)
def bsdf(
    *,
    thickness_cm: float = 15.0,
    angle_deg: Any = 0.0,
    wavelength_nm: Any = (450.0, 550.0, 650.0),
    rays: int = DEFAULT_RAYS,
    rings: int = 10,
    sectors: int | None = None,
    seed: int = 1,
    progress: Progress = None,
    **snow: Unpack[Snow],
) -> xr.Dataset:
    """BRDF and BTDF of a slab of snow, by random walks.

    Parameters
    ----------
    thickness_cm : float, 0 to 100000
    angle_deg : float or "diffuse"
    wavelength_nm : float or array, 300 to 2500
    rays : int
        Random walks for each wavelength, 2 or more.
    rings, sectors : int
        Patches of a hemisphere, of equal integrals of cos(theta) over solid angle; by default 10 rings of 12 sectors,
        or of 1 where the azimuth does not matter.
    seed : int
    progress : bool or callable, optional
    **snow
        Arguments of :class:`Snow`, one value each.

    Returns
    -------
    xarray.Dataset
        `brdf` and `btdf` in 1/sr on wavelength, theta (degrees from the normal) and phi (degrees from the direction in
        which the beam travels), with standard errors. Light that is not scattered is in `direct` only.
    """
    given = one_snow(snow)
    light = angles_or_diffuse(own_axis(ANGLE, angle_deg, angle))
    if len(light) != 1:
        raise ValueError("angle_deg has several values, but must have one")
    wavelength = own_axis(WAVELENGTH, wavelength_nm)
    patches = (whole("rings", rings, 1), None if sectors is None else whole("sectors", sectors, 1))
    counts = (whole("rays", rays, 2), whole("seed", seed))
    thickness_cm = number("thickness_cm", thickness_cm)
    with reporting(progress, "rays") as report:
        slab = (thickness_cm, light[0], wavelength.values.tolist())
        arrays = _native.bsdf(given, slab, counts, patches, report)
    at = {name: arrays.pop(name).reshape(rings, -1) for name in ("theta", "phi", "solid_angle")}
    variables: dict[str, Any] = {}
    for name, array in arrays.items():
        is_spread = name.startswith(("brdf", "btdf"))
        dims = ["wavelength", "theta", "phi"] if is_spread else ["wavelength"]
        variables[name] = (dims, array.reshape(wavelength.size, rings, -1) if is_spread else array)
    variables["solid_angle"] = (["theta", "phi"], at["solid_angle"])
    coords = {
        "wavelength": wavelength,
        "theta": ("theta", at["theta"][:, 0], {"units": "degree", "long_name": "angle from the normal"}),
        "phi": ("phi", at["phi"][0], {"units": "degree", "long_name": "azimuth from the forward direction"}),
    }
    made = {"thickness_cm": thickness_cm, "angle_deg": light[0], "rays": rays, "seed": seed}
    result = _dataset(variables, coords, single_values(given, {}) | made)
    result["solid_angle"].attrs.update(units="sr", long_name="solid angle of the patch and its mirror image")
    return result


@checks_names(*SNOW_NAMES)
def brf(
    *,
    view_zenith_deg: Any,
    view_azimuth_deg: Any = (0.0, 180.0),
    angle_deg: Any = 60.0,
    wavelength_nm: Any = (450.0, 550.0, 650.0),
    layers: Iterable[Mapping[str, Any]] | pd.DataFrame | None = None,
    thickness_cm: float = np.inf,
    ground_albedo: Any = 0.0,
    streams: int | str = "auto",
    seed: int = 1,
    **snow: Unpack[Snow],
) -> xr.Dataset:
    """Bidirectional reflectance factor of snow or of layers of snow, by discrete ordinates.

    Parameters
    ----------
    view_zenith_deg : float or array, 0 to 89.99
        Angle of the view from the normal.
    view_azimuth_deg : float or array, -360 to 360
        Azimuth of the leaving light from the direction in which the beam travels: 0 is forward, 180 back to the sun.
    angle_deg, wavelength_nm
        As in :func:`spectrum`.
    layers : mappings or pandas.DataFrame, optional
        As in :func:`layers`, of snow only, instead of `thickness_cm` and the arguments of a snow.
    thickness_cm : float, 0 to 100000
        Infinity is a half-space.
    ground_albedo : float, 0 to 1, or a spectrum on `wavelength` as in :func:`spectrum`
    streams : even int or "auto"
        Directions of the discrete ordinates in both hemispheres; half as many azimuthal modes. "auto" is 48.
    seed : int
    **snow
        Arguments of :class:`Snow`, one value each.

    Returns
    -------
    xarray.Dataset
        `brf`, the radiance over that of a white Lambertian surface, on angle, wavelength, view zenith and view azimuth.
        Its mean over the hemisphere, weighted with the cosine of the view zenith, is the albedo.

    Examples
    --------
    >>> import snowblue
    >>> snow = snowblue.brf(view_zenith_deg=60, ssa_m2_kg=20, wavelength_nm=1030).brf
    >>> bool(snow.sel(view_azimuth=0) > 1.2 * snow.sel(view_azimuth=180))
    True
    """
    beside = [*snow, *(["thickness_cm"] if np.isfinite(thickness_cm) else [])]
    if layers is not None and beside:
        raise TypeError(f"{beside[0]} belongs to the layers")
    given = one_snow(snow)
    packed = [(given, number("thickness_cm", thickness_cm))] if layers is None else packed_layers(layers)
    coords = {
        "angle": own_axis(ANGLE, angle_deg, angle),
        "wavelength": own_axis(WAVELENGTH, wavelengths(wavelength_nm)),
        "view_zenith": own_axis(VIEW_ZENITH, view_zenith_deg),
        "view_azimuth": own_axis(VIEW_AZIMUTH, view_azimuth_deg),
    }
    albedo, of_ground, stated = one_ground(ground_albedo, coords["wavelength"])
    ground = {"layers": packed, "ground_albedo": albedo, "depth_cm": []}
    cases = {
        "thickness_cm": [],
        "angle_deg": angles_or_diffuse(coords["angle"]),
        "wavelength_nm": coords["wavelength"].values.tolist(),
    }
    views = (coords["view_zenith"].values.tolist(), coords["view_azimuth"].values.tolist())
    with locating_layers(packed, angles_deg=cases["angle_deg"]):
        values = _native.brf(ground, cases, views, ordinates(streams, seed))
    made = {"layers": described_layers(packed), **stated, **_made("ordinates", streams, DEFAULT_RAYS, False, seed)}
    variables = {"brf": ([*coords], values.reshape([one.size for one in coords.values()]))}
    return _dataset(variables, coords | of_ground, made)


@checks_names(*SNOW_NAMES)
def single_scattering(
    *, wavelength_nm: Any = VISIBLE_NM, degree: int = 32, seed: int = 1, **snow: Unpack[Snow]
) -> xr.Dataset:
    """Single scattering in snow, for other solvers of radiative transfer.

    Parameters
    ----------
    wavelength_nm : float or array, 300 to 2500
    degree : int, 1 to 256
        Greatest degree of the moments.
    seed : int
        Seed of the rays through grains.
    **snow
        Arguments of :class:`Snow`, one value each.

    Returns
    -------
    xarray.Dataset
        `extinction` in 1/m; `coalbedo`, 1 less the single-scattering albedo, which in snow is too small for the albedo
        itself to be exact; `asymmetry`; and `moments`, the means of the Legendre polynomials of the cosine of the
        scattering angle.
    """
    given = one_snow(snow)
    degree = whole("degree", degree)
    if not 1 <= degree <= 256:
        raise ValueError(f"degree is {degree}, but must lie in 1–256")
    wavelength = own_axis(WAVELENGTH, wavelength_nm)
    arrays = _native.single_scattering(given, wavelength.values.tolist(), degree, seed)
    moments = arrays.pop("moments").reshape(wavelength.size, degree + 1)
    variables: dict[str, Any] = {name: (["wavelength"], array) for name, array in arrays.items()}
    variables["moments"] = (["wavelength", "degree"], moments)
    coords = {"wavelength": wavelength, "degree": np.arange(degree + 1)}
    return _dataset(variables, coords, single_values(given, {}) | {"seed": seed})


@checks_names()
def aged_ssa(
    *, ssa_m2_kg: Any, age_h: Any, temperature_c: Any = -5.0, temperature_gradient: bool = False
) -> xr.DataArray:
    """Specific surface area of dry snow after some time, from that of new snow.

    The law of Taillandier et al. (2007), for `ssa_m2_kg` of :func:`spectrum` and others. Arguments are broadcast as
    those of :func:`spectrum`.

    Parameters
    ----------
    ssa_m2_kg : float or array, 1.4 to 300
        Of new snow.
    age_h : float or array, 0 to 8784
    temperature_c : float or array, -60 to 0
    temperature_gradient : bool
        Snow with a gradient of temperature of more than some 10 K/m, whose grains grow faster, instead of isothermal
        snow.

    Returns
    -------
    xarray.DataArray
        In m2 kg-1. The law describes new, dry snow; the snow model Crocus does not follow it below 8 m2 kg-1.

    Examples
    --------
    >>> import snowblue
    >>> new, old = snowblue.aged_ssa(ssa_m2_kg=60, age_h=[0, 168], temperature_c=-10)
    >>> float(new), 25 < float(old) < 35
    (60.0, True)
    """
    axes = Axes()
    axes.add("new_m2_kg", NEW_SNOW, ssa_m2_kg)
    axes.add("temperature_c", SNOW["temperature_c"], temperature_c)
    axes.add("age_h", AGE, age_h)
    solve = functools.partial(_aged, temperature_gradient=bool(temperature_gradient))
    solved = dataset(in_blocks(solve, axes.arrays, axes.sizes, gaps=axes.gaps), axes.coordinates(), {})
    return solved.ssa_m2_kg.assign_attrs(
        **SNOW["ssa_m2_kg"].attributes(),
        source="Taillandier et al. 2007, doi:10.1029/2006JF000514",
        conditions="temperature gradient" if temperature_gradient else "isothermal",
    )


def _aged(rows: Mapping[str, np.ndarray], temperature_gradient: bool) -> dict[str, Any]:
    """Specific surface areas of some snows."""
    columns = {name: values.tolist() for name, values in rows.items()}
    return {"ssa_m2_kg": ((), _native.aged_surface_area(**columns, temperature_gradient=temperature_gradient))}


def _uncertainty(plus_minus: Mapping[str, Any]) -> tuple[list[tuple[str, float]], bool]:
    """Standard deviations by the keys of properties, and whether either table of ice may be right."""
    plus_minus = by_substance("plus_minus", mapping("plus_minus", plus_minus, "{'ssa_m2_kg': 2, 'black-carbon': 5}"))
    check_names([*_native.uncertain_properties(), *SUBSTANCES, "ice"], plus_minus)
    if "ssa_m2_kg" in plus_minus and "grain_size_um" in plus_minus:
        raise ValueError("ssa_m2_kg and grain_size_um are two names of one size: give one")
    keys = {name: mass_argument(name) if name in SUBSTANCES else name for name in sorted(plus_minus) if name != "ice"}
    deviations = [(key, number(name, plus_minus[name])) for name, key in keys.items()]
    return deviations, truth("ice", plus_minus.get("ice", False))


def _engine(
    engine: str, streams: int | str, rays: int, per_wavelength: bool, seed: int, standard_errors: bool
) -> dict[str, Any]:
    check_engine(engine)
    return {
        "ordinates": ordinates(streams, seed),
        "rays": whole("rays", rays, 2) if engine == "montecarlo" else None,
        "per_wavelength": per_wavelength,
        "standard_errors": standard_errors,
    }


def parameter_quantity(name: str) -> Quantity:
    """What a parameter is. Those that are not known elsewhere are impurities."""
    return JACOBIAN.get(name) or Quantity(name.replace("-", "_"), "ng g-1")


def parameters(jacobian: str | Iterable[str], engine: str = "ordinates") -> list[str]:
    """The names of parameters that results are differentiated by, with hyphens in those of impurities."""
    names = [hyphenated(name) for name in names_of("jacobian", () if jacobian is None else jacobian, "parameters")]
    check_parameters(names)
    if engine == "montecarlo" and names:
        raise ValueError("jacobian needs the engine 'ordinates'")
    return names


def check_parameters(names: Iterable[str]) -> None:
    """Raises ValueError for a parameter that is unknown."""
    known = [*JACOBIAN, *SUBSTANCES]
    for name in names:
        if name not in known:
            raise ValueError(f"parameter {name!r} is not known; {suggestion(name, known)}")


def _made(engine: str, streams: int | str, rays: int, per_wavelength: bool, seed: int) -> dict[str, Any]:
    if engine == "montecarlo":
        shared = "each wavelength" if per_wavelength else "each angle and index node"
        return {"engine": f"Monte Carlo, {rays} rays for {shared}", "seed": seed}
    return {"engine": f"discrete ordinates, {streams} streams", "seed": seed}


def _dataset(variables: Mapping[str, Any], coords: Mapping[str, Any], made: Mapping[str, Any]) -> xr.Dataset:
    """A dataset, whose variables have units and long names by their names."""
    solved = dataset(variables, coords, attributes(**made))
    for name, variable in solved.data_vars.items():
        quantity, _, parameter = name.partition("_per_")
        aspect = next((end for end in ASPECTS if quantity.endswith(end)), "")
        plain = quantity.removesuffix(aspect)
        words = plain.replace("_", " ")
        long_name, units = ASPECTS.get(aspect, "{}").format(LONG_NAMES.get(plain, words)), UNITS.get(plain, "1")
        if parameter:
            by = parameter_quantity(parameter)
            long_name = f"derivative of {words} with respect to {by.attributes()['long_name']}"
            units = by.of_derivative(units)
        variable.attrs = {"units": units, "long_name": long_name}
    return solved
