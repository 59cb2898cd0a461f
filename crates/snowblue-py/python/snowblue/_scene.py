"""Scenes, their pictures, and the light field on their snow."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from snowblue import _native
from snowblue._arguments import WAVELENGTH, attributes, checks_names, own_axis
from snowblue._database import Database, existing
from snowblue._progress import PhaseProgress, reporting

if TYPE_CHECKING:
    import xarray as xr

Integrator = Literal["hybrid", "diffusion", "pcasnow", "reference"]
Tone = Literal["filmic", "agx", "none"]
Aov = Literal[
    "spectrum", "variance", "normal", "albedo", "thickness", "angle", "emitter", "snow", "alpha", "depth", "position",
    "object", "material"]
AXES = {"R": "r", "G": "g", "B": "b", "X": "x", "Y": "y", "Z": "z"}


class Scene:
    """A scene with snow in it, in metres and degrees, z upwards.

    The keywords are the tables of a scene file, and have its keys: see the chapter on rendering. A mesh is the name of
    a file or a pair of NumPy arrays, vertices (n, 3) in m and triangles (m, 3), counter-clockwise from outside.

    Examples
    --------
    >>> import snowblue
    >>> scene = snowblue.Scene(
    ...     camera={"position": [1, -1, 0.6], "look_at": [0, 0, 0.15], "vertical_fov_deg": 30},
    ...     film={"width": 32, "height": 24, "exposure": -1.0},
    ...     material={"snow": {"type": "snow", "grain_size_um": 400, "density_kg_m3": 300}},
    ...     light=[{"type": "point", "position": [-0.5, 1, 0.5], "illuminant": "D65", "radiant_intensity_w_sr": 10}],
    ...     object=[{"shape": "box", "size": [0.3, 0.1, 0.3], "position": [0, 0, 0.15], "material": "snow"}],
    ... )
    >>> picture = scene.render(samples_per_pixel=4, integrator="diffusion")
    >>> dict(picture.rgb.sizes)
    {'y': 24, 'x': 32, 'channel': 3}
    """

    @checks_names()
    def __init__(
        self,
        *,
        camera: Mapping[str, Any] | None = None,
        film: Mapping[str, Any] | None = None,
        integrator: Mapping[str, Any] | None = None,
        light_field: Mapping[str, Any] | None = None,
        material: Mapping[str, Mapping[str, Any]] | None = None,
        light: Iterable[Mapping[str, Any]] = (),
        environment: Mapping[str, Any] | None = None,
        sky: Mapping[str, Any] | None = None,
        object: Iterable[Mapping[str, Any]] = (),
        gltf: str | None = None,
        folder: str | PathLike[str] = ".",
    ) -> None:
        tables = {
            "gltf": gltf,
            "camera": camera,
            "film": film,
            "integrator": integrator,
            "light_field": light_field,
            "material": material,
            "environment": environment,
            "sky": sky,
        }
        document: dict[str, Any] = {name: table for name, table in tables.items() if table is not None}
        files: dict[str, bytes] = {}
        document["light"] = [dict(one) for one in light]
        document["object"] = [_with_file(dict(one), files) for one in object]
        self._scene = _native.Scene.from_json(_json(document), files, fspath(folder))

    @classmethod
    def open(cls, path: str | PathLike[str]) -> Scene:
        """Reads a scene file (TOML)."""
        scene = cls.__new__(cls)
        scene._scene = _native.Scene.open(existing(path))
        return scene

    def with_(self, **tables: Any) -> Scene:
        """The scene with other tables: keywords of :class:`Scene`, of which None removes a table.

        Its files, and meshes of arrays by their names, are those of this scene. A scene and those made from it keep
        what was built for the last picture of any of them; the next picture computes only what differs: where lights
        differ, their light in the snow, and where only the camera or the film differ, nothing of the snow.

        Examples
        --------
        >>> import snowblue
        >>> scene = snowblue.Scene(
        ...     camera={"position": [0, -1, 1], "look_at": [0, 0, 0]}, sky={"sun": {"elevation_deg": 30}}
        ... )
        >>> evening = scene.with_(sky={"sun": {"elevation_deg": 5}})
        >>> evening.description["sky"]["sun"]["elevation_deg"]
        5.0
        """
        document = {name: table for name, table in {**self.description, **tables}.items() if table is not None}
        scene = Scene.__new__(Scene)
        scene._scene = self._scene.with_json(_json(document))
        return scene

    def __getstate__(self) -> tuple[str, dict[str, bytes], str]:
        """Its description, meshes of arrays, and the folder of its files, for pickle. The files themselves stay."""
        files, folder = self._scene.files()
        return self._scene.to_json(), {name: bytes(content) for name, content in files.items()}, str(folder.absolute())

    def __setstate__(self, state: tuple[str, dict[str, bytes], str]) -> None:
        self._scene = _native.Scene.from_json(*state)

    @property
    def description(self) -> dict[str, Any]:
        """The tables of the scene, with all defaults. A copy."""
        return json.loads(self._scene.to_json())

    def to_toml(self) -> str:
        """The text of a scene file. Meshes from arrays have names without files."""
        return self._scene.to_toml()

    def __repr__(self) -> str:
        tables = self.description
        names = ", ".join(tables.get("material", {}))
        lights, objects = len(tables.get("light", [])), len(tables.get("object", []))
        return f"<snowblue.Scene: objects: {objects}, lights: {lights}, materials: {names}>"

    @checks_names()
    def render(
        self,
        *,
        integrator: Integrator | None = None,
        width: int | None = None,
        height: int | None = None,
        samples_per_pixel: int | None = None,
        noise_target: float | None = None,
        raw: bool = False,
        max_bounces: int | None = None,
        seed: int | None = None,
        exposure: float | Literal["auto"] | None = None,
        tone: Tone | None = None,
        aovs: Sequence[Aov] = (),
        database: Database | None = None,
        output: str | PathLike[str] | None = None,
        progress: PhaseProgress = None,
        preview: Callable[[np.ndarray], object] | None = None,
    ) -> xr.Dataset:
        """Renders the scene.

        Parameters
        ----------
        integrator : "hybrid", "diffusion", "pcasnow" or "reference", optional
        width, height, samples_per_pixel, noise_target, max_bounces, seed, exposure, tone : optional
            Instead of those of the scene.
        raw : bool
            Leave out the filter of hybrid and diffusion, which averages the noise of random walks, of samples of a sky
            and of light from other surfaces over pixels of like surfaces.
        aovs : sequence
            Values beside the colours: spectrum, variance, normal, albedo, thickness, angle, emitter, snow, alpha (the
            colours then leave the sky out), depth along the viewing axis, position (in m from the attribute
            position_origin_m), object and material (the fraction of each pixel that each name covers).
        database : Database, optional
            A compressed table of curves for pcasnow instead of that of the scene, or else the embedded one. The curves
            of snow that it does not hold are solved for.
        output : path, optional
            A .png or .exr file to write too.
        progress : bool or callable, optional
            A function of the steps done, of all (0 where their number is not known, as for light), and of the phase:
            meshes, snow, cells, light, samples.
        preview : callable, optional
            A function of unfinished pictures, (rows, columns, 3) in 8-bit sRGB: a coarse one of fewer pixels before the
            light in the snow is solved for, and then one about every second. An exception in it stops the work.

        Returns
        -------
        xarray.Dataset
            `rgb`: linear sRGB, where luminance 1 is that of 1 W/(m² sr) of equal-energy light over 400 to 700 nm;
            `display`: 8-bit sRGB at the exposure and by the tone curve, for `picture.display.plot.imshow()`; and the
            AOVs. The pixel at the upper left is the first; y grows upwards. The attribute `solved_light_fields` counts
            the solutions for light in snow that were not kept of an earlier picture, and `notes` says which curves
            pcasnow solved for.
        """
        changed = self._changed(
            film={"width": width, "height": height, "exposure": exposure, "tone": tone},
            integrator={
                "type": integrator,
                "samples_per_pixel": samples_per_pixel,
                "noise_target": noise_target,
                "filter": False if raw else None,
                "max_bounces": max_bounces,
                "seed": seed,
            },
        )
        target = _target(output)
        with reporting(progress) as report:
            table = None if database is None else database._table
            shown = None if preview is None else lambda width, height, pixels: preview(pixels.reshape(height, width, 3))
            rendered = changed.render(table, ",".join(["rgb", *aovs]), target, report, shown)
        return _picture(rendered)

    @checks_names()
    def bake(
        self,
        *,
        step_mm: float | None = None,
        spectrum: bool = False,
        lightmap: int | None = None,
        max_bounces: int | None = None,
        output: str | PathLike[str] | None = None,
        progress: PhaseProgress = None,
    ) -> Bake:
        """Solves for the light field and gives the net flux J outwards at the vertices of the snow.

        Snow then sends out the radiance L(mu) = R0 F + K(mu) J / pi, where F is the irradiance of all light on the
        surface, R0 is nearly 1/pi, and K is :meth:`BakedObject.escape`.

        Parameters
        ----------
        step_mm : float, optional
            Greatest length of an edge; by default twice the cells of the light field.
        spectrum : bool
            31 wavelengths in W/(m² nm) instead of linear sRGB in W/m².
        lightmap : int, optional
            Rows and columns, 64 to 4096, of a texture of all that leaves the snow: `lightmap` of the result. A .glb
            shows it in place of COLOR_0.
        max_bounces : int, optional
        output : path, optional
            A .glb or .ply file to write too.
        progress : bool or callable, optional
            A function of the steps done, of all, and of the phase: meshes, snow, cells, light, lamps,
            and with a lightmap charts before and texels after lamps.
        """
        target = _target(output)
        if target is not None and Path(target).suffix.lower() not in (".glb", ".ply"):
            raise ValueError(f"{target}: the baked snow must end in .glb or .ply")
        if target is not None and spectrum and Path(target).suffix.lower() == ".glb":
            raise ValueError(f"{target}: spectra need a .ply: a GLB holds colours only")
        if target is not None and lightmap is not None and Path(target).suffix.lower() == ".ply":
            raise ValueError(f"{target}: a lightmap needs a .glb: a PLY holds no texture")
        least, most = _native.LIGHTMAP_SIZES
        if lightmap is not None and lightmap not in range(least, most + 1):
            raise ValueError(f"lightmap is {lightmap}, but must be a whole number in {least}–{most}")
        size = None if lightmap is None else int(lightmap)
        changed = self._changed(integrator={"type": "diffusion", "max_bounces": max_bounces})
        with reporting(progress) as report:
            content = {"is_total": False, "reflection": False, "irradiance": False, "lightmap": size}
            content["spectrum"] = spectrum
            of_all, *objects = changed.bake(step_mm, content, target, report)
        texels = of_all.get("lightmap")
        return Bake(
            [_baked(one, of_all["lamps"]) for one in objects],
            of_all["lamps"],
            of_all["provenance"],
            None if texels is None else texels.reshape(size, size, 3),
        )

    def _changed(self, **tables: Mapping[str, Any]) -> _native.Scene:
        changes = {
            name: {key: value for key, value in table.items() if value is not None} for name, table in tables.items()
        }
        if not any(changes.values()):
            return self._scene
        document = self.description
        for name, table in changes.items():
            document.setdefault(name, {}).update(table)
        return self._scene.with_json(_json(document))


@dataclass(frozen=True)
class BakedObject:
    """The light field on an object of snow."""

    name: str
    positions: np.ndarray
    """Vertices in m, (n, 3)."""
    normals: np.ndarray
    """Outward unit normals, (n, 3)."""
    triangles: np.ndarray
    """Vertices of each triangle, counter-clockwise from outside, (m, 3)."""
    texture_coordinates: np.ndarray
    """Columns and rows of the lightmap at the vertices as fractions of its size, (n, 2); (0, 2) without a lightmap."""
    flux: np.ndarray
    """Net flux J outwards by each lamp, and last by the sky and all light by way of other surfaces: (lamps + 1, n, 3)
    in W/m² as linear sRGB, or (lamps + 1, n, 31) in W/(m² nm)."""
    exitance: np.ndarray
    """All that leaves the surface, (n, 3), in W/m² as linear sRGB."""
    escape_polynomial: np.ndarray
    """The coefficients of K(mu) by ascending powers of mu."""
    extrapolation_length: float
    """In transport mean free paths."""
    transport_length_m: float
    """Transport mean free path at the middle wavelength."""

    def escape(self, mu: Any) -> np.ndarray:
        """K at cosines of the angle from the normal: the angular distribution of light from inside the snow."""
        return np.polynomial.polynomial.polyval(mu, self.escape_polynomial)

    def __repr__(self) -> str:
        counts = f"{len(self.positions)} vertices, {len(self.triangles)} triangles"
        return f"<snowblue.BakedObject: {self.name}, {counts}, fluxes {self.flux.shape}>"


@dataclass(frozen=True)
class Bake:
    """The light field on the snow of a scene."""

    objects: list[BakedObject]
    lamps: list[str]
    """What each lamp is: point, spot, directional, sphere or rectangle."""
    provenance: str
    lightmap: np.ndarray | None = None
    """What leaves the surface of all snow as a texture, (rows, columns, 3), in W/m² as linear sRGB."""

    def __repr__(self) -> str:
        vertices = sum(len(one.positions) for one in self.objects)
        return f"<snowblue.Bake: objects: {len(self.objects)}, vertices: {vertices}, lamps: {len(self.lamps)}>"


def _target(output: str | PathLike[str] | None) -> str | None:
    """The path of a file to write after long work."""
    if output is not None and not Path(output).parent.is_dir():
        raise FileNotFoundError(f"{fspath(output)}: there is no such folder")
    return None if output is None else fspath(output)


_MATTES = {"object": "CryptoObject", "material": "CryptoMaterial"}


def _mattes(rendered: dict[str, Any], about: dict[str, str], layer: str) -> dict[str, np.ndarray]:
    """The coverage of the pixels by each name, from the ranked identifiers of a layer, which are taken out."""
    ranked = [rendered.pop(name) for name in list(rendered) if name.startswith(layer)]
    if not ranked:
        return {}
    key = next(key for key, text in about.items() if key.endswith("/name") and text == layer)
    manifest: dict[str, str] = json.loads(about[key.replace("/name", "/manifest")])
    ids = {name: np.frombuffer(bytes.fromhex(code)[::-1], "<f4") for name, code in manifest.items()}
    pairs = list(zip(ranked[::2], ranked[1::2], strict=True))
    return {name: sum(np.where(found == one, covered, 0) for found, covered in pairs) for name, one in ids.items()}


def _picture(rendered: dict[str, Any]) -> xr.Dataset:
    import xarray as xr

    width, height = rendered.pop("width"), rendered.pop("height")
    display, wavelengths_nm = rendered.pop("display"), rendered.pop("wavelengths")
    made = {name: rendered.pop(name) for name in ("exposure_stops", "provenance", "solved_light_fields")}
    made["notes"] = "\n".join(rendered.pop("notes"))
    about = rendered.pop("attributes")
    if "positionOrigin" in about:
        made["position_origin_m"] = [float(number) for number in about["positionOrigin"].split()]
    mattes = {group: _mattes(rendered, about, layer) for group, layer in _MATTES.items()}
    groups: dict[str, list[str]] = {}
    for name in rendered:
        group = "rgb" if name in ("R", "G", "B") else "spectrum" if name.startswith("S0.") else name.split(".")[0]
        group = "alpha" if name == "A" else group
        groups.setdefault(group, []).append(name)
    last = {"rgb": "channel", "variance": "channel", "albedo": "channel", "spectrum": "wavelength"}
    last |= {"normal": "axis", "position": "axis"}
    units = {"rgb": "W m-2 sr-1", "variance": "W2 m-4 sr-2", "spectrum": "W m-2 sr-1 nm-1"}
    units |= {"thickness": "m", "angle": "degree", "depth": "m", "position": "m"}
    coords: dict[str, Any] = {
        "y": ("y", np.arange(height)[::-1], {"long_name": "rows from the bottom"}),
        "x": ("x", np.arange(width), {"long_name": "columns from the left"}),
        "channel": ["r", "g", "b"],
    }
    variables: dict[str, Any] = {"display": (("y", "x", "channel"), display.reshape(height, width, 3))}
    for group, of_names in mattes.items():
        if of_names:
            coords[group] = list(of_names)
            stacked = np.stack([matte.reshape(height, width) for matte in of_names.values()], axis=-1)
            variables[group] = (("y", "x", group), stacked, {"units": "1", "long_name": f"coverage by each {group}"})
    for group, names in groups.items():
        stacked = np.stack([rendered[name].reshape(height, width) for name in names], axis=-1)
        description = {"units": units.get(group, "1"), "long_name": group}
        if group not in last:
            variables[group] = (("y", "x"), stacked[..., 0], description)
            continue
        variables[group] = (("y", "x", last[group]), stacked, description)
        if group == "spectrum":
            coords["wavelength"] = own_axis(WAVELENGTH, wavelengths_nm)
        elif last[group] == "axis":
            coords["axis"] = [AXES[name.split(".")[1]] for name in names]
    return xr.Dataset(variables, coords, attributes(**made))


def _baked(one: dict[str, Any], lamps: list[str]) -> BakedObject:
    count = one["positions"].size // 3
    return BakedObject(
        name=one["name"],
        positions=one["positions"].reshape(count, 3),
        normals=one["normals"].reshape(count, 3),
        triangles=one["triangles"].reshape(-1, 3),
        texture_coordinates=one["texture_coordinates"].reshape(-1, 2),
        flux=np.stack(one["flux"]).reshape(len(lamps) + 1, count, one["channels"]),
        exitance=one["exitance"].reshape(count, 3),
        escape_polynomial=np.array(one["escape_polynomial"]),
        extrapolation_length=one["extrapolation"],
        transport_length_m=one["transport_length_m"],
    )


def _with_file(table: dict[str, Any], files: dict[str, bytes]) -> dict[str, Any]:
    """An object whose mesh, if that is a pair of arrays, is the name of a file in memory."""
    mesh = table.get("mesh")
    if mesh is None or isinstance(mesh, (str, PathLike)):
        return {**table, "mesh": fspath(mesh)} if mesh is not None else table
    vertices, triangles = mesh
    name = f"array-{len(files)}.ply"
    files[name] = _ply(np.asarray(vertices, dtype="<f4"), np.asarray(triangles))
    return {"up": "z", **table, "mesh": name}


def _check_mesh(vertices: np.ndarray, triangles: np.ndarray) -> None:
    """Refuses arrays that are no mesh."""
    for name, array in (("vertices", vertices), ("triangles", triangles)):
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"the {name} of a mesh have the shape {array.shape}, but must have (n, 3)")
    if not np.issubdtype(triangles.dtype, np.integer):
        raise ValueError(f"the triangles of a mesh are {triangles.dtype}, but must be whole numbers")
    if triangles.size and not (0 <= triangles.min() and triangles.max() < len(vertices)):
        raise ValueError(f"the triangles of a mesh name vertices outside 0–{len(vertices) - 1}")


def _ply(vertices: np.ndarray, triangles: np.ndarray, attributes: Mapping[str, np.ndarray] | None = None) -> bytes:
    """A mesh as a binary PLY file, with further numbers at the vertices by their names."""
    _check_mesh(vertices, triangles)
    attributes = attributes or {}
    properties = "".join(f"property float {name}\n" for name in ("x", "y", "z", *attributes))
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n{properties}"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.column_stack([vertices, *attributes.values()]).astype("<f4")
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    return header.encode() + rows.tobytes() + faces.tobytes()


def _json(document: Mapping[str, Any]) -> str:
    def plain(value: Any) -> Any:
        if isinstance(value, (np.ndarray, np.generic)):
            return value.tolist()
        if isinstance(value, PathLike):
            return fspath(value)
        raise TypeError(f"a scene cannot have a {type(value).__name__}")

    return json.dumps(document, default=plain, allow_nan=False)
