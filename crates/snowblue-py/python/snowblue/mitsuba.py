"""Snow in Mitsuba 3.

>>> import mitsuba as mi
>>> mi.set_variant("llvm_ad_rgb")
>>> import snowblue.mitsuba
>>> scene = mi.load_dict({
...     "type": "scene",
...     "integrator": {"type": "snow", "max_depth": 8},
...     "block": {"type": "cube", "bsdf": {"type": "snow_surface"}, "emitter": {"type": "snow_light"}},
...     "lamp": {"type": "point", "position": [0, 3, 1], "intensity": 10.0},
... })

Importing this module registers three plug-ins. Mitsuba 3.10 and later find them without it, by an entry point.

- the BSDF `snow_surface`: what the surface of snow reflects. Its parameters are those of :class:`snowblue.Snow` that
  are one number or word, such as `grain_size_um` (400), `density_kg_m3` (300) or `snow`; those of impurities in ng/g,
  such as `black_carbon_ng_g` (0); and `body`: shapes of snow with the same word there are one solid;
- the emitter `snow_light`, on the same shape: the light that comes out of the snow. Its parameter `of` has no meaning,
  but must differ between the shapes of a dictionary, since `mitsuba.load_dict` makes one plug-in of equal ones;
- the integrator `snow`: it computes the light of all snow, and renders with another integrator, `path` by default or
  the one nested in it. Its parameter `unit_m` (1) is the length of a unit of the scene, and `method` one of these:

  - `light_field` (the default) solves for the light inside the snow before it renders. The surface reflects by the
    reflection function R0 of deep snow, and the light from inside is K(mu) J / pi, where J is the net flux through the
    surface. `step_mm` is the distance of the points on the surface where J is known, `field_step_mm` the size of the
    cells in the snow, and `gather_depth` (8) the number of surfaces over which light is followed before it enters the
    snow. The light of each lamp is solved for once. The next rendering notices a change of the scene, and solves for
    all lamps again, or only for those that are new or have moved; light is linear, so a lamp that is stronger or has
    another colour needs no solution.
    It is lit by the emitters point, spot, directional, constant, envmap, sunsky, and area on spheres and rectangles.
  - `pcasnow` traces one straight path through the snow for each hit. The light from inside is T(d, theta) E / pi, where
    d is the length of the path in the snow, E the irradiance of a lamp where it leaves the snow, and theta the angle of
    incidence there. The surface reflects R(d, theta) E / pi. `path_mode` is `brightest` (the default), `normal`,
    `light` or `view`, and `database` the file of a compressed table of curves instead of the embedded one. The curves
    of snow that the table does not hold are solved for, in about a second. It is lit by all emitters. Variants of CUDA
    do not have it.

Snow must be a closed mesh: a shape, or arrays by :func:`snow_mesh`.

Pictures hold the colours that come out, unclipped: linear sRGB, in which the red of deep snow is negative, since its
blue lies outside sRGB. Single samples may also be negative because J is negative where light enters the snow. In
scalar variants Mitsuba warns of each such sample; while snow is rendered these warnings are left out.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from snowblue import _native
from snowblue._arguments import SNOW, SUBSTANCES, VISIBLE_NM, WORDS, mass_argument, number, snow_id, whole
from snowblue._database import Database
from snowblue._mitsuba_pcasnow import PATH_MODES, PCASnow, arrays_of, name_of
from snowblue._renderers import BAND_WIDTH_NM, _bands, _csv, _rgb
from snowblue._scene import BakedObject, _baked, _json, _ply, _check_mesh

COMPONENTS = 6
SAMPLING_WEIGHT = 1e-6
HOST_VARIANTS = ("scalar_rgb", "llvm_ad_rgb", "llvm_ad_spectral")
VARIANTS = (*HOST_VARIANTS, "cuda_ad_rgb", "cuda_ad_spectral")
"""The variants that have snow. Those of the host have both methods, those of CUDA the light field."""
PLUGINS = ("snow_surface", "snow_light", "snow")
METHOD_PARAMETERS = {
    "light_field": ("step_mm", "field_step_mm", "gather_depth"),
    "pcasnow": ("path_mode", "database"),
}
"""The methods, and the parameters that only one of them has."""
SKY_FILE, SKY_HEIGHT = "sky.exr", 256
"""The image of an envmap: greater ones are reduced to this height."""
LEAST_OF_PANES = 0.6
"""What a pane of the greatest refractive index, 3, lets pass at normal incidence."""
REFLECTANCE_SAMPLES = 1024
R3_SEQUENCE = np.array([0.8191725134, 0.6710436067, 0.5497004779])
"""The sequence of numbers in three dimensions by M. Roberts (2018): powers of 1/1.2207440846."""
UNSOLVED = "some snow is not solved for"
WHITE_FILE = "white.csv"
"""The spectrum of the lamps that are solved for: 1 at all wavelengths."""


def snow_mesh(vertices: Any, triangles: Any, **parameters: Any) -> Any:
    """A shape of snow from arrays.

    Parameters
    ----------
    vertices : array_like
        Positions in units of the scene, (n, 3).
    triangles : array_like
        Vertices of each triangle, counter-clockwise from outside, (m, 3).
    **parameters
        Those of the plug-in `snow_surface`, such as `grain_size_um` or `body`.

    Returns
    -------
    mitsuba.Mesh
        A shape with a `snow_surface` and a `snow_light`, for a scene or a dictionary of one.

    Examples
    --------
    >>> import snowblue.mitsuba
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> snow = snowblue.mitsuba.snow_mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], density_kg_m3=250)
    >>> snow.face_count()
    4
    """
    vertices, triangles = np.asarray(vertices, dtype=np.float32), np.asarray(triangles)
    _check_mesh(vertices, triangles)
    props = mi.Properties()
    props["bsdf"] = mi.load_dict({"type": "snow_surface", **parameters})
    props["emitter"] = mi.load_dict({"type": "snow_light"})
    mesh = mi.Mesh("snow", len(vertices), len(triangles), props=props, has_vertex_normals=True)
    _set(mesh, {"vertex_positions": vertices, "faces": triangles.astype(np.uint32)})
    mesh.recompute_vertex_normals()
    return mesh


def _register() -> None:
    """Registers the plug-ins in the present variant."""
    if mi.variant() not in VARIANTS:
        classes = [_refused] * len(PLUGINS)
    else:
        classes = [_bsdf_class(), _emitter_class(), _integrator_class()]
    for register, name, one in zip((mi.register_bsdf, mi.register_emitter, mi.register_integrator), PLUGINS, classes):
        register(name, one)


def _refused(props: mi.Properties) -> Any:
    """Instead of a plug-in, in a variant that has no snow."""
    raise ValueError(f"the variant {mi.variant()} has no snow; there are {', '.join(VARIANTS[:-1])} and {VARIANTS[-1]}")


def _unsolved() -> float:
    """The light of snow before it is solved for. Compiled variants evaluate the plug-ins of all scenes that exist, so
    that an exception here would concern scenes that are not rendered."""
    warnings.warn(
        f"{UNSOLVED}: only the integrator 'snow' renders it, with another its pixels are NaN; snow of other scenes, "
        "which are not rendered now, does not matter",
        stacklevel=2,
    )
    return float("nan")


def _bsdf_class() -> type:
    class SnowSurface(mi.BSDF):
        """What the surface of snow reflects."""

        def __init__(self, props: mi.Properties) -> None:
            # An error comes before the plug-in exists: compiled variants would evaluate a part of one.
            self.material = _snow_of(props)
            self.snow_id = snow_id(self.material)
            mi.BSDF.__init__(self, props)
            self.material_name = json.dumps(self.material, sort_keys=True)
            self.body = props.get("body", "")
            self.reflection = None
            # Set while the integrator renders by PCASnow.
            self.pcasnow: PCASnow | None = None
            self.m_flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
            self.m_components = [self.m_flags]

        def set_reflection(self, table: np.ndarray) -> None:
            """The table of (mu + mu0) R0."""
            self.points = round(table.size ** (1 / 3))
            volume = np.ascontiguousarray(table.reshape((self.points,) * 3 + (1,)))
            self.reflection = mi.Texture3f(mi.TensorXf(volume), wrap_mode=dr.WrapMode.Clamp)

        def value(self, wi: mi.Vector3f, wo: mi.Vector3f) -> mi.Float:
            """R0 cos(theta_o)."""
            if self.reflection is None:
                return _unsolved() * wo.z
            per_sines = dr.rsqrt(dr.maximum((1 - wi.z * wi.z) * (1 - wo.z * wo.z), 1e-12))
            # The sine of half the azimuth between both directions of propagation.
            azimuth = dr.sqrt(dr.clip(0.5 + 0.5 * (wi.x * wo.x + wi.y * wo.y) * per_sines, 0, 1))

            def place(unit: mi.Float) -> mi.Float:
                return (unit * (self.points - 1) + 0.5) / self.points

            exit, incidence = dr.sqrt(dr.maximum(wi.z, 0)), dr.sqrt(dr.maximum(wo.z, 0))
            [table] = self.reflection.eval(mi.Point3f(place(azimuth), place(incidence), place(exit)))
            return table / dr.maximum(wi.z + wo.z, 1e-4) * wo.z

        def sample(self, context: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> Any:
            wo = mi.warp.square_to_cosine_hemisphere(sample2)
            sampled = mi.BSDFSample3f()
            sampled.wo = wo if self.pcasnow is None else si.to_local(mi.Frame3f(si.n).to_world(wo))
            sampled.pdf = mi.warp.square_to_cosine_hemisphere_pdf(wo)
            sampled.eta = 1.0
            sampled.sampled_type = +mi.BSDFFlags.GlossyReflection
            sampled.sampled_component = 0
            weight = self.eval(context, si, sampled.wo, active) / dr.maximum(sampled.pdf, 1e-8)
            return sampled, dr.select(sampled.pdf > 0, weight, 0)

        def eval(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            if self.pcasnow is not None:
                cosine = self.cosine(si, wo)
                active = active & (self.cosine(si, si.wi) > 0) & (cosine > 0)
                value = self.pcasnow.reflectance(self, si, cosine, active) * (cosine * dr.inv_pi)
                return dr.select(active, value, 0)
            return mi.Spectrum(dr.select(active & (si.wi.z > 0) & (wo.z > 0), self.value(si.wi, wo), 0))

        def pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            if self.pcasnow is not None:
                cosine = self.cosine(si, wo)
                return dr.select(active & (self.cosine(si, si.wi) > 0) & (cosine > 0), cosine * dr.inv_pi, 0)
            pdf = mi.warp.square_to_cosine_hemisphere_pdf(wo)
            return dr.select(active & (si.wi.z > 0) & (wo.z > 0), pdf, 0)

        def cosine(self, si: Any, direction: Any) -> mi.Float:
            """The cosine to the normal of the triangle, by which PCASnow reflects."""
            return dr.dot(si.n, si.to_world(direction))

        def eval_pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)

        def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
            return mi.Spectrum(1.0)

        def traverse(self, callback: Any) -> None:
            pass

        def to_string(self) -> str:
            return f"SnowSurface[{', '.join(f'{name} = {value}' for name, value in self.material.items())}]"

    return SnowSurface


def _emitter_class() -> type:
    class SnowLight(mi.Emitter):
        """Light from inside snow. Rays find it; it is not sampled."""

        def __init__(self, props: mi.Properties) -> None:
            # Rays find the light: samples of emitters are for the lamps. A scene of weights 0 does not load.
            props["sampling_weight"] = SAMPLING_WEIGHT
            mi.Emitter.__init__(self, props)
            # Equal plug-ins become one in a dictionary: a word of its own keeps them apart.
            self.of = props.get("of", "")
            self.m_flags = mi.EmitterFlags.Surface | mi.EmitterFlags.SpatiallyVarying
            # The light on the shape, for the next rendering.
            self.solution: _Solution | None = None
            # Set while the integrator renders by the light field.
            self.escape: list[float] | None = None
            # Set while the integrator renders by PCASnow.
            self.pcasnow: PCASnow | None = None
            self.basis: list[Any] = []

        def set_light(self, escape: np.ndarray, basis: np.ndarray) -> None:
            """The polynomial K and, for spectra, the wavelength functions of the attributes."""
            self.escape = escape.tolist()
            rows = np.ascontiguousarray(basis.astype(np.float32)[..., None])
            self.basis = [mi.Texture1f(mi.TensorXf(row), wrap_mode=dr.WrapMode.Clamp) for row in rows]

        def eval(self, si: Any, active: Any = True) -> Any:
            if self.pcasnow is not None:
                active = active & (dr.dot(si.n, si.to_world(si.wi)) > 0)
                return dr.select(active, self.pcasnow.transmitted(self.get_shape(), si, active), 0)
            if self.escape is None:
                return mi.Spectrum(_unsolved())
            mu = si.wi.z
            k0, k1, k2, k3 = self.escape
            escape = (k0 + mu * (k1 + mu * (k2 + mu * k3))) * dr.inv_pi
            flux = si.shape.eval_attribute_3("vertex_snow_0", si, active)
            if self.basis:
                coefficients = [*flux, *si.shape.eval_attribute_3("vertex_snow_1", si, active)]
                flux = mi.Spectrum(0.0)
                for lane in range(len(flux)):
                    unit = (si.wavelengths[lane] - VISIBLE_NM[0]) / (VISIBLE_NM[-1] - VISIBLE_NM[0])
                    place = mi.Point1f((unit * (len(VISIBLE_NM) - 1) + 0.5) / len(VISIBLE_NM))
                    for coefficient, function in zip(coefficients, self.basis):
                        flux[lane] += coefficient * function.eval(place)[0]
            return dr.select(active & (mu > 0), mi.Spectrum(flux) * escape, 0)

        def sample_direction(self, it: Any, sample: Any, active: Any = True) -> Any:
            if not mi.variant().startswith("scalar"):
                return dr.zeros(mi.DirectionSample3f), mi.Spectrum(0.0)
            ds = mi.DirectionSample3f()
            ds.pdf = 0.0
            return ds, mi.Spectrum(0.0)

        def pdf_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return mi.Float(0.0)

        def eval_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return mi.Spectrum(0.0)

        def traverse(self, callback: Any) -> None:
            pass

        def to_string(self) -> str:
            return "SnowLight[]"

    return SnowLight


def _integrator_class() -> type:
    class SnowIntegrator(mi.SamplingIntegrator):
        """Solves for the light in snow, then renders with another integrator."""

        def __init__(self, props: mi.Properties) -> None:
            mi.SamplingIntegrator.__init__(self, props)
            nested = [value for _, value in props.objects() if isinstance(value, mi.Integrator)]
            depths = {name: props[name] for name in ("max_depth", "rr_depth") if name in props}
            if len(nested) > 1 or (nested and depths):
                raise ValueError("the integrator 'snow' has one integrator in it, or max_depth and rr_depth of its own")
            self.inner = nested[0] if nested else mi.load_dict({"type": "path", **depths})
            self.method = _method(props)

        def render(self, scene: Any, *arguments: Any, **keywords: Any) -> Any:
            snow, lamps = _snow(scene), [one for one in scene.emitters() if not _is_snow_light(one)]
            if snow and not lamps:
                raise ValueError("the scene has snow but no emitter to light it")
            if not snow:
                return self.inner.render(scene, *arguments, **keywords)
            try:
                self.method.prepare(scene, snow, lamps)
                with _negative_samples_allowed(), warnings.catch_warnings():
                    # All snow of this scene is solved for.
                    warnings.filterwarnings("ignore", UNSOLVED)
                    picture = self.inner.render(scene, *arguments, **keywords)
                    # Compiled variants compute the picture later, when the snow is released.
                    dr.eval(picture)
                    dr.sync_thread()
                    return picture
            finally:
                self.method.release()

        def sample(self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True) -> Any:
            return self.inner.sample(scene, sampler, ray, medium, active)

        def aov_names(self) -> list[str]:
            return self.inner.aov_names()

        def traverse(self, callback: Any) -> None:
            pass

        def to_string(self) -> str:
            return f"SnowIntegrator[{self.inner}]"

    return SnowIntegrator


@contextmanager
def _negative_samples_allowed() -> Iterator[None]:
    """Leaves out what scalar variants log of samples that are negative. Those that are not numbers are logged."""
    if not mi.variant().startswith("scalar"):
        yield
        return
    logger = mi.logger()
    appenders = [logger.appender(number) for number in range(logger.appender_count())]

    class Rest(mi.Appender):
        """Hands all other messages on."""

        def append(self, level: mi.LogLevel, text: str) -> None:
            if "Invalid sample value" in text and "nan" not in text and "inf" not in text:
                return
            for appender in appenders:
                appender.append(level, text)

        def log_progress(self, progress: float, name: str, formatted: str, eta: str, ptr: Any = None) -> None:
            for appender in appenders:
                appender.log_progress(progress, name, formatted, eta, ptr)

    logger.clear_appenders()
    logger.add_appender(Rest())
    try:
        yield
    finally:
        logger.clear_appenders()
        for appender in appenders:
            logger.add_appender(appender)


def _snow_of(props: mi.Properties) -> dict[str, Any]:
    """The snow that the parameters of a surface describe."""
    snow = {name: props[name] if name in WORDS else number(name, props[name]) for name in SNOW if name in props}
    impurities = {}
    for name in SUBSTANCES:
        key = mass_argument(name)
        if key in props:
            impurities[name] = number(key, props[key])
    return {**snow, "impurities_ng_g": impurities} if impurities else snow


def _method(props: mi.Properties) -> _Field | PCASnow:
    """The method that the parameters of the integrator choose."""
    method = props.get("method", "light_field")
    if method not in METHOD_PARAMETERS:
        raise ValueError(f"method is '{method}', but must be one of {', '.join(METHOD_PARAMETERS)}")
    for other, names in METHOD_PARAMETERS.items():
        for name in names:
            if name in props and other != method:
                raise ValueError(f"{name} belongs to the method {other}, but the method is {method}")
    if method == "pcasnow" and mi.variant().startswith("cuda"):
        # A kernel of OptiX traces rays in one scene.
        raise ValueError(
            f"the variant {mi.variant()} has no method pcasnow, which traces rays in scenes of single bodies; use "
            f"{', '.join(HOST_VARIANTS[:-1])} or {HOST_VARIANTS[-1]}")
    lengths = {"unit_m": 1.0, "step_mm": None, "field_step_mm": None}
    for name in lengths:
        if name in props:
            lengths[name] = number(name, props[name])
            if not 0 < lengths[name] < np.inf:
                raise ValueError(f"{name} is {lengths[name]}, but must be finite and above 0")
    if method == "light_field":
        return _Field(**lengths, gather_depth=whole("gather_depth", props.get("gather_depth", 8)))
    database = Database.open(props["database"]) if "database" in props else Database.embedded()
    if database.components is None:
        raise ValueError(f"database is {database.kind}, but must be a compressed table")
    return PCASnow(lengths["unit_m"], props.get("path_mode", PATH_MODES[0]), database)


def _snow(scene: Any) -> list[Any]:
    """The shapes of snow."""
    snow, shapes = [], scene.shapes()
    for shape in shapes:
        reason, is_lit = "", _is_snow_light(shape.emitter())
        if not _is_snow(shape.bsdf()):
            reason = "has the emitter 'snow_light', but not the bsdf 'snow_surface'" if is_lit else ""
        elif "vertex_positions" not in mi.traverse(shape):
            reason = f"is a {shape.class_name()}, but snow must be a mesh (cube, ply, obj)"
        elif not is_lit:
            reason = "has the bsdf 'snow_surface', but not the emitter 'snow_light'"
        else:
            snow.append(shape)
        if reason:
            raise ValueError(f"shape {name_of(shape, shapes)} {reason}")
    return snow


@dataclass(frozen=True)
class _Light:
    """An emitter as a light of our scenes."""

    tables: dict[str, Any]
    """What a scene has of it alone. It is white, and as strong as an emitter of 1 at each wavelength."""
    files: dict[str, bytes]
    strength: np.ndarray
    """The emitter itself, at 31 wavelengths."""


@dataclass
class _Solution:
    """The light on a shape of snow."""

    digest: str
    """Of the scene without its lamps."""
    mesh: dict[str, np.ndarray]
    """The mesh whose vertices have the light: arrays by the names of the parameters of a mesh."""
    escape_polynomial: np.ndarray
    reflection: np.ndarray
    """The table of (mu + mu0) R0."""
    fluxes: dict[str, np.ndarray]
    """The flux at the vertices by each lamp that is white and of strength 1, by the digest of the lamp."""


class _Field:
    """The light on the snow of a scene.

    While the scene is rendered, each shape of snow has the mesh whose vertices have the light. Before and after, it has
    the mesh of the user.
    """

    def __init__(
        self,
        unit_m: float,
        step_mm: float | None,
        field_step_mm: float | None,
        gather_depth: int,
    ) -> None:
        self.unit_m, self.step_mm, self.field_step_mm = unit_m, step_mm, field_step_mm
        self.gather_depth = gather_depth
        self.scene: Any = None
        # The shapes of snow that are rendered, and the arrays of their own meshes.
        self.own: list[tuple[Any, dict[str, Any]]] = []

    def release(self) -> None:
        """Gives the snow its own meshes. It keeps its light for the next rendering."""
        own, self.own = self.own, []
        # A scene that stayed here would live as long as its integrator, which it owns.
        scene, self.scene = self.scene, None
        for shape, arrays in own:
            _remove_light(shape)
            _set(shape, arrays)
        if own:
            scene.parameters_changed([])

    def prepare(self, scene: Any, snow: list[Any], lamps: list[Any]) -> None:
        """Gives the snow its light. What of it is known is not solved for again."""
        document, files = self._description(scene, snow)
        lights = [self._light(lamp, name_of(lamp, lamps)) for lamp in lamps]
        # A scene without light is black. The solution for one lamp sets its meshes.
        lights = [light for light in lights if light.strength.any()] or lights[:1]
        # Other integrators may have other steps.
        solved = _digest(_json(document), str(self.step_mm), files)
        keys = [_digest(_json(light.tables), "", light.files) for light in lights]
        emitters = [shape.emitter() for shape in snow]
        earlier = [emitter.solution for emitter in emitters]
        if not all(one is not None and one.digest == solved for one in earlier):
            earlier = [None] * len(snow)
        missing = {
            key: light for key, light in zip(keys, lights) if not all(one and key in one.fluxes for one in earlier)
        }
        shapes = scene.shapes()
        names = [name_of(shape, shapes) for shape in snow]
        # Nothing changes before all is known.
        solutions = []
        for name, known, by_key in zip(names, earlier, self._solve(names, document, files, lights, missing)):
            fluxes = known.fluxes if known else {}
            for key, (baked, reflection) in by_key.items():
                mesh = self._refined(baked)
                known = known or _Solution(solved, mesh, baked.escape_polynomial, reflection, {})
                if not np.array_equal(mesh["vertex_positions"], known.mesh["vertex_positions"]):
                    raise ValueError(
                        f"the points on shape {name} where light is known differ between lamps: set step_mm"
                    )
                fluxes = fluxes | {key: baked.flux[0]}
            # Lamps that have left or moved are forgotten.
            solutions.append(replace(known, fluxes={key: fluxes[key] for key in keys}))
        self.scene = scene
        for shape, solution in zip(snow, solutions):
            shape.emitter().solution = solution
            self._put(shape, solution, keys, lights)
        scene.parameters_changed([])

    def _solve(
        self,
        names: list[str],
        document: dict[str, Any],
        files: dict[str, bytes],
        lights: list[_Light],
        missing: dict[str, _Light],
    ) -> list[dict[str, Any]]:
        """For each shape of snow, by the keys of the lamps that are not known: its light, and its table of R0."""
        # What scenes of other lamps have in common is built once.
        given: dict[str, bytes] = dict(files)
        for light in lights:
            given |= light.files
        native, solutions = None, [{} for _ in names]
        content = {"spectrum": True, "is_total": True, "reflection": True, "irradiance": False, "lightmap": None}
        for key, light in missing.items():
            text = _json(document | light.tables)
            native = _named(
                names, lambda: native.with_json(text) if native else _native.Scene.from_json(text, given, ".")
            )
            objects = _named(names, lambda: native.bake(self.step_mm, content, None, None)[1:])
            for by_key, one in zip(solutions, objects):
                by_key[key] = _baked(one, []), one["reflection"]
        return solutions

    def _refined(self, baked: BakedObject) -> dict[str, np.ndarray]:
        """The mesh whose vertices have the light."""
        return {
            "vertex_positions": (baked.positions / self.unit_m).astype(np.float32),
            "faces": baked.triangles.astype(np.uint32),
            "vertex_normals": baked.normals.astype(np.float32),
            "vertex_texcoords": np.zeros((len(baked.positions), 2), dtype=np.float32),
        }

    def _description(self, scene: Any, snow: list[Any]) -> tuple[dict[str, Any], dict[str, bytes]]:
        """The scene without lamps."""
        files: dict[str, bytes] = {WHITE_FILE: _csv(np.ones(len(VISIBLE_NM)))}
        materials: dict[str, Any] = {}
        # Many shapes may have one bsdf.
        names: dict[Any, str] = {}
        # One warning for all shapes that are alike.
        notes: dict[str, None] = {}
        left_out: Counter[str] = Counter()
        # Snow comes first, so that its numbers are those of the baked objects.
        objects, is_of_snow = [], set(snow)
        for number, shape in enumerate([*snow, *(one for one in scene.shapes() if one not in is_of_snow)]):
            lamp = shape.emitter()
            if lamp is not None and not _is_snow_light(lamp):
                continue
            one = self._object(shape, f"shape {number}.ply", files)
            if one is None:
                left_out[shape.class_name()] += 1
                continue
            bsdf = shape.bsdf()
            if bsdf not in names and _is_snow(bsdf):
                names[bsdf] = bsdf.material_name
                materials[names[bsdf]] = {"type": "snow", **bsdf.material}
            elif bsdf not in names:
                names[bsdf] = f"bsdf {len(names)}"
                materials[names[bsdf]], note = _surface(bsdf, names[bsdf], files)
                notes |= {note: None} if note else {}
            one["material"] = names[bsdf]
            if _is_snow(bsdf) and bsdf.body:
                one["body"] = bsdf.body
            objects.append(one)
        for kind, count in left_out.items():
            shapes = f"a shape of the kind {kind} casts" if count == 1 else f"{count} shapes of the kind {kind} cast"
            notes[f"{shapes} no shadow on snow and {'gives' if count == 1 else 'give'} it no light"] = None
        for note in notes:
            warnings.warn(note, stacklevel=2)
        document: dict[str, Any] = {
            "integrator": {"type": "diffusion", "max_bounces": self.gather_depth},
            "material": materials,
            "object": objects,
        }
        if self.field_step_mm is not None:
            document["light_field"] = {"step_mm": float(self.field_step_mm)}
        return document, files

    def _object(self, shape: Any, file: str, files: dict[str, bytes]) -> dict[str, Any] | None:
        """A shape as an object of our scenes; none if there is no such object."""
        parameters = mi.traverse(shape)
        if "vertex_positions" in parameters:
            vertices, triangles = arrays_of(parameters)
        elif shape.class_name() == "Rectangle":
            to_world = _matrix(parameters["to_world"])
            corners = np.array([[-1, -1, 0, 1], [1, -1, 0, 1], [1, 1, 0, 1], [-1, 1, 0, 1]]) @ to_world.T
            vertices, triangles = corners[:, :3], np.array([[0, 1, 2], [0, 2, 3]])
        elif shape.class_name() == "Sphere":
            center, radius = _sphere(_matrix(parameters["to_world"]))
            return {"shape": "sphere", "radius": radius * self.unit_m, "position": (center * self.unit_m).tolist()}
        else:
            return None
        files[file] = _ply(np.asarray(vertices * self.unit_m, dtype="<f4"), triangles)
        return {"mesh": file, "up": "z"}

    def _light(self, emitter: Any, name: str) -> _Light:
        kind = emitter.class_name()
        shape = emitter.get_shape() if kind == "AreaLight" else None
        name = f"emitter {name}" if shape is None or not shape.id() else f"emitter of shape '{shape.id()}'"
        on = f" on a {shape.class_name()}" if shape is not None else ""
        if kind in ("AreaLight", "SpotLight") and mi.has_flag(emitter.flags(), mi.EmitterFlags.SpatiallyVarying):
            raise ValueError(
                f"{name} is a {kind}{on} with a texture, which cannot light snow: give it one colour, or divide it "
                "into lamps of one colour each"
            )
        parameters = mi.traverse(emitter if shape is None else shape)
        # A lamp of 1 at each wavelength has this over all of them.
        power, white = BAND_WIDTH_NM, {"spectrum": WHITE_FILE}

        def lamp(strength: np.ndarray, **light: Any) -> _Light:
            return _Light({"light": [white | light]}, {}, np.maximum(strength, 0.0))

        if kind == "PointLight":
            position = np.array(parameters["position"]).ravel()
            return lamp(
                _incident(emitter, position + [0.0, 0.0, 1.0]),
                type="point",
                position=(position * self.unit_m).tolist(),
                radiant_intensity_w_sr=power * self.unit_m**2,
            )
        if kind == "SpotLight":
            to_world = _matrix(parameters["to_world"])
            position, axis = to_world[:3, 3], _unit(to_world[:3, 2])
            angles = {"inner_cone_deg": "beam_width", "outer_cone_deg": "cutoff_angle"}
            return lamp(
                _incident(emitter, position + axis),
                type="spot",
                position=(position * self.unit_m).tolist(),
                look_at=((position + axis) * self.unit_m).tolist(),
                radiant_intensity_w_sr=power * self.unit_m**2,
                **{key: float(np.ravel(parameters[theirs])[0]) for key, theirs in angles.items()},
            )
        if kind == "DirectionalEmitter":
            direction = _matrix(parameters["to_world"])[:3, 2].tolist()
            strength = _incident(emitter, np.zeros(3))
            return lamp(strength, type="directional", direction=direction, irradiance_w_m2=power)
        if kind == "ConstantBackgroundEmitter":
            environment = {"radiance_w_m2_sr": power, **white}
            return _Light({"environment": environment}, {}, np.maximum(_emitted(emitter), 0.0))
        if kind == "EnvironmentMapEmitter":
            scale = float(np.ravel(parameters["scale"])[0])
            image = _panorama(emitter) / (scale or 1.0)
            files = {SKY_FILE: _exr(image)} if image.any() else {}
            sky = {"image": SKY_FILE} if image.any() else {"radiance_w_m2_sr": power, **white}
            return _Light({"environment": sky}, files, np.full(VISIBLE_NM.shape, scale if image.any() else 0.0))
        if kind == "SunskyEmitter":
            scale, sky = _sunsky(name, parameters)
            return _Light({"sky": sky}, {}, np.full(VISIBLE_NM.shape, scale))
        if kind == "AreaLight" and shape.class_name() == "Sphere":
            center, radius = _sphere(_matrix(parameters["to_world"]))
            return lamp(
                _emitted(emitter),
                type="sphere",
                position=(center * self.unit_m).tolist(),
                radius=radius * self.unit_m,
                radiance_w_m2_sr=power,
            )
        if kind == "AreaLight" and shape.class_name() == "Rectangle":
            to_world = _matrix(parameters["to_world"])
            center, sides = to_world[:3, 3], to_world[:3, :2]
            # Transforms may mirror, and normals may be flipped.
            normal = np.array(shape.sample_position(0.0, mi.Point2f(0.5, 0.5)).n, dtype=float).ravel()
            return lamp(
                _emitted(emitter),
                type="rectangle",
                position=(center * self.unit_m).tolist(),
                look_at=(center * self.unit_m + _unit(normal)).tolist(),
                up=sides[:, 1].tolist(),
                size=(2 * self.unit_m * np.linalg.norm(sides, axis=0)).tolist(),
                radiance_w_m2_sr=power,
            )
        raise ValueError(
            f"{name} is a {kind}{on}, which cannot light snow; there are point, spot, directional, constant, envmap, "
            "sunsky, and area on a sphere or rectangle"
        )

    def _put(self, shape: Any, solution: _Solution, keys: list[str], lights: list[_Light]) -> None:
        """Gives a shape the mesh whose vertices have the light: the sum over all lamps, of which several may have one
        key."""
        parameters = mi.traverse(shape)
        # A parameter is a reference, a copy of it stays.
        self.own.append((shape, {key: type(parameters[key])(parameters[key]) for key in solution.mesh}))
        _set(shape, solution.mesh)
        flux = sum(solution.fluxes[key].astype(float) * light.strength for key, light in zip(keys, lights))
        if _is_spectral():
            _, functions = np.linalg.eigh(flux.T @ flux)
            basis = functions.T[: -COMPONENTS - 1 : -1]
            values = np.split(flux @ basis.T, COMPONENTS // 3, axis=1)
        else:
            basis = np.empty((0, flux.shape[1]))
            values = [_rgb(flux / _white())]
        for number, three in enumerate(values):
            shape.add_attribute(f"vertex_snow_{number}", 3, three.astype(np.float32).ravel())
        shape.bsdf().set_reflection(solution.reflection)
        shape.emitter().set_light(solution.escape_polynomial, basis)


def _remove_light(shape: Any) -> None:
    """Removes the light at the vertices, if there is some."""
    emitter = shape.emitter()
    if emitter.escape is not None:
        for number in range(2 if emitter.basis else 1):
            shape.remove_attribute(f"vertex_snow_{number}")
    emitter.escape = None


def _digest(text: str, more: str, files: dict[str, bytes]) -> str:
    digest = hashlib.sha256(f"{text} {more}".encode())
    for name in sorted(files):
        digest.update(files[name])
    return digest.hexdigest()


def _named(names: list[str], action: Any) -> Any:
    """What an action gives. Errors of it name the shapes of snow as the scene does."""
    try:
        return action()
    except ValueError as error:
        reason = str(error)
        for number, name in enumerate(names):
            reason = reason.replace(f"object[{number}]", f"shape {name}")
        raise ValueError(reason) from None


def _set(shape: Any, values: dict[str, Any]) -> None:
    """Sets the arrays of a mesh. Those that it lacks, as normals, stay out."""
    parameters = mi.traverse(shape)
    for key, array in values.items():
        if len(parameters[key]) > 0:
            kind = type(parameters[key])
            # A parameter is compared with its new value, which scalar variants cannot do with other sizes than 1. The
            # value between must differ.
            parameters[key] = kind(parameters[key][0] + 1)
            parameters[key] = kind(array.ravel() if isinstance(array, np.ndarray) else array)
    parameters.update()


def _is_snow(bsdf: Any) -> bool:
    # Each variant has a class of its own.
    return type(bsdf).__name__ == "SnowSurface"


def _is_snow_light(emitter: Any) -> bool:
    return type(emitter).__name__ == "SnowLight"


def _is_spectral() -> bool:
    return "spectral" in mi.variant()


def _white() -> np.ndarray:
    """White light at 31 wavelengths, of luminance 1 for equal energy: D65 in RGB variants, as of images of skies."""
    each = np.eye(len(VISIBLE_NM)).ravel()
    daylight, equal = (
        _native.colors(each, VISIBLE_NM.tolist(), {"illuminant": name, "observer": "1931"}, 0.0)["xyz"].reshape(-1, 3)
        for name in ("D65", "E")
    )
    return daylight.sum(axis=1) / equal.sum(axis=1)


def _spectrum(values: Any) -> np.ndarray:
    """Light at 31 wavelengths: in RGB variants by bands of daylight."""
    array = np.array(values, dtype=float)
    if _is_spectral():
        return np.broadcast_to(array.reshape(-1), VISIBLE_NM.shape)
    red, green, blue = np.broadcast_to(array.reshape(-1), 3) if array.size == 1 else array.reshape(3, -1)[:, 0]
    return _bands((red, green, blue)) * _white()


def _interaction(wavelengths_nm: np.ndarray = VISIBLE_NM) -> Any:
    """The middle of a surface, seen along its normal, at given wavelengths in spectral variants."""
    interaction = dr.zeros(mi.SurfaceInteraction3f)
    interaction.wi = mi.Vector3f(0, 0, 1)
    interaction.uv = mi.Point2f(0.5, 0.5)
    if _is_spectral():
        lanes = mi.Float(wavelengths_nm.astype(np.float32))
        interaction.wavelengths = mi.Spectrum(*[lanes] * 4)
    return interaction


def _first(values: Any) -> Any:
    """The first of the four wavelengths of each lane, or the colour."""
    return values[0] if _is_spectral() else values


def _incident(emitter: Any, point: np.ndarray) -> np.ndarray:
    """The irradiance on a surface that faces a lamp without extent."""
    interaction = _interaction()
    interaction.p = mi.Point3f(*point.tolist())
    _, weight = emitter.sample_direction(interaction, mi.Point2f(0.5, 0.5))
    return _spectrum(_first(weight))


def _emitted(emitter: Any) -> np.ndarray:
    """The radiance of a lamp with extent or of the sky."""
    return _spectrum(_first(emitter.eval(_interaction())))


def _sunsky(name: str, parameters: Any) -> tuple[float, dict[str, Any]]:
    """The scale of a sunsky, and our clear sky of the scale 1, whose model is the same (Hosek & Wilkie 2012, 2013). The
    sun's direction is that in the scene."""
    zenith = _unit(_matrix(parameters["to_world"])[:3, 2])
    if not np.allclose(zenith, [0, 0, 1], atol=1e-6):
        raise ValueError(f"{name} is a sunsky whose zenith is not +z")
    value = {key: float(np.ravel(parameters[key])[0]) for key in ("turbidity", "sky_scale", "sun_scale")}
    if value["sky_scale"] != value["sun_scale"]:
        raise ValueError(f"{name} is a sunsky with different scales of sun and sky, which cannot light snow")
    albedo = [np.ravel(parameters[key]).mean() for key in parameters.keys() if key.startswith("albedo")]
    return value["sky_scale"], {
        "sun": {"towards": np.array(parameters["sun_direction"], dtype=float).ravel().tolist()},
        "turbidity": value["turbidity"],
        "ground_albedo": float(np.mean(albedo)),
        "scale": 1.0,
    }


def _panorama(emitter: Any) -> np.ndarray:
    """The sky as our own images of it: from zenith to nadir, +y in the middle, clockwise as seen from above."""
    rows = mi.traverse(emitter)["data"].shape[0]
    height = min(rows, SKY_HEIGHT)
    width = 2 * height
    # Small suns must not fall between the pixels.
    fine = max(1, -(-rows // height))
    polar = (np.arange(height * fine) + 0.5) * np.pi / (height * fine)
    longitude = np.pi / 2 - 2 * np.pi * ((np.arange(width * fine) + 0.5) / (width * fine) - 0.5)
    theta, phi = (grid.ravel() for grid in np.meshgrid(polar, longitude, indexing="ij"))
    directions = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    seen = _sky_colors(emitter, directions).reshape(height, fine, width, fine, 3)
    # A value of 1 is the luminance of 1 W/(m2 sr) of equal energy.
    return seen.mean(axis=(1, 3)) * BAND_WIDTH_NM


def _sky_colors(emitter: Any, directions: np.ndarray) -> np.ndarray:
    """Linear sRGB of the sky in directions, where the luminance is that for equal energy."""
    interaction = dr.zeros(mi.SurfaceInteraction3f)
    if mi.variant().startswith("scalar"):
        colors = []
        for direction in directions.T:
            interaction.wi = mi.Vector3f(*(-direction).tolist())
            colors.append(np.array(emitter.eval(interaction)))
        return np.array(colors)
    interaction.wi = mi.Vector3f(*(mi.Float(-row.astype(np.float32)) for row in directions))
    if not _is_spectral():
        return np.array(emitter.eval(interaction)).T
    spectra = []
    # Four wavelengths at a time.
    for first in range(0, len(VISIBLE_NM), 4):
        lanes = np.resize(VISIBLE_NM[first : first + 4], 4)
        interaction.wavelengths = mi.Spectrum(*lanes.tolist())
        spectra.extend(np.array(emitter.eval(interaction))[: len(VISIBLE_NM) - first])
    light = {"illuminant": "E", "observer": "1931"}
    values = np.ascontiguousarray(np.stack(spectra, axis=-1), dtype=float).ravel()
    return _native.colors(values, VISIBLE_NM.tolist(), light, 0.0)["rgb_linear"].reshape(-1, 3)


def _exr(image: np.ndarray) -> bytes:
    stream = mi.MemoryStream()
    mi.Bitmap(image.astype(np.float32)).write(stream, mi.Bitmap.FileFormat.OpenEXR)
    return stream.raw_buffer()


def _surface(bsdf: Any, name: str, files: dict[str, bytes]) -> tuple[dict[str, Any], str]:
    """The material of a surface that is not snow: the pane of a thin dielectric, else what it reflects and what it lets
    pass straight on; and a sentence on what differs from the surface in Mitsuba."""
    passed = float(np.mean(_first(bsdf.eval_null_transmission(_interaction()))))
    if bsdf.class_name() == "ThinDielectric" and passed > LEAST_OF_PANES:
        # At normal incidence, a pane of the refractive index n lets 2n / (n² + 1) pass.
        return {"type": "glass", "refractive_index": (1.0 + (1.0 - min(passed, 1.0) ** 2) ** 0.5) / passed}, ""
    opacity = {"opacity": 1.0 - passed} if passed > 0.0 else {}
    kind, flags = bsdf.class_name(), bsdf.flags()
    other = (mi.BSDFFlags.Glossy, mi.BSDFFlags.DeltaReflection, mi.BSDFFlags.DeltaTransmission)
    is_diffuse = not any(mi.has_flag(flags, lobe) for lobe in other)
    if is_diffuse:
        values = np.array(_first(bsdf.eval_diffuse_reflectance(_interaction())), dtype=float)
    else:
        values = _reflectance(bsdf) / max(1.0 - passed, 1e-6)
        # Samples have noise.
        values = np.where(values < 1.02, np.minimum(values, 1.0), values)
    if not ((values >= 0) & (values <= 1)).all():
        raise ValueError(f"the {kind} of a shape reflects {values.max():g}, but must reflect 0 to 1")
    note = ""
    if passed == 0.0 and mi.has_flag(flags, mi.BSDFFlags.Transmission):
        note = f"a {kind} blocks light for snow; a thindielectric or a mask does not"
    elif not is_diffuse:
        note = f"a {kind} gives light to snow as a diffuse surface with its reflectance at normal incidence"
    if mi.has_flag(flags, mi.BSDFFlags.SpatiallyVarying):
        note = f"{note or f'a {kind} gives light to snow'}, with the values at the middle of its textures"
    if _is_spectral():
        file = f"{name}.csv"
        # A uniform reflectance has one value.
        files[file] = _csv(np.broadcast_to(values.reshape(-1), VISIBLE_NM.shape))
        return {"type": "diffuse", "reflectance_spectrum": file, **opacity}, note
    return {"type": "diffuse", "reflectance_rgb": np.broadcast_to(values.reshape(-1), 3).tolist(), **opacity}, note


def _reflectance(bsdf: Any) -> np.ndarray:
    """The share of the light along the normal that a surface reflects in all directions, at the middle of its
    textures: the mean over samples of the BSDF."""
    numbers = np.arange(1, REFLECTANCE_SAMPLES + 1)[:, None] * R3_SEQUENCE % 1.0
    context = mi.BSDFContext()
    if mi.variant().startswith("scalar"):
        samples = [bsdf.sample(context, _interaction(), one, mi.Point2f(two, three)) for one, two, three in numbers]
        weights = [np.array(weight) * (sampled.wo.z > 0) for sampled, weight in samples]
        return np.mean(weights, axis=0)
    wavelengths_nm = np.repeat(VISIBLE_NM, len(numbers)) if _is_spectral() else VISIBLE_NM[:1]
    one, two, three = (mi.Float(np.resize(row, max(len(row), len(wavelengths_nm)))) for row in numbers.T)
    sampled, weight = bsdf.sample(context, _interaction(wavelengths_nm), one, mi.Point2f(two, three))
    weights = np.array(_first(dr.select(sampled.wo.z > 0, weight, 0)))
    # Weights that are all equal are one number.
    rows = max(1, weights.size // len(numbers)) if _is_spectral() else 3
    return weights.reshape(rows, -1).mean(axis=1)


def _matrix(transform: Any) -> np.ndarray:
    return np.array(transform.matrix, dtype=float).reshape(4, 4)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def _sphere(to_world: np.ndarray) -> tuple[np.ndarray, float]:
    return to_world[:3, 3], float(np.linalg.norm(to_world[:3, 0]))


if mi.variant() is None:
    raise ImportError("choose a variant before importing snowblue.mitsuba: mitsuba.set_variant('llvm_ad_rgb')")
mi.detail.add_variant_callback(lambda old, new: _register())
_register()
