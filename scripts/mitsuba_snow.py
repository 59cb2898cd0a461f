"""An efficient implementation of PCASnow in Mitsuba 3, measured by bench_mitsuba.py.

The integrator runs in Mitsuba's compiled (LLVM) mode, traces rays against Mitsuba's own scene, and looks snow up in
textures. There are two kinds of textures. `Spectra` rebuilds all wavelengths of snowblue from two components in log
space. `Colours` holds precomputed tristimulus values, which are valid for one lamp spectrum only.
"""

import json
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

COLOUR_DATA = Path(__file__).resolve().parent.parent / "crates/snowblue-color/data"
WAVELENGTHS_NM = np.arange(400, 701, 10)
# XYZ to linear sRGB (IEC 61966-2-1).
RGB = np.linalg.inv([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
# Rows and columns of the textures: uniform in the angle, and in the square root of the depth since T is steep in thin
# snow.
ANGLES, LAST_ANGLE_DEG = 17, 89.0
DEPTHS, LAST_DEPTH_CM = 64, 100.0


def lamp_weights(light):
    """XYZ of a lamp's radiant intensity per wavelength. 1 W/sr of equal energy has Y = 1, as in snowblue's files."""

    def column(name, count):
        rows = np.loadtxt(COLOUR_DATA / f"{name}.csv", delimiter=",", skiprows=1)
        return np.stack([np.interp(WAVELENGTHS_NM, rows[:, 0], rows[:, k + 1]) for k in range(count)], -1)

    matching, lamp = column("cmf_1931_2deg_1nm", 3), column(f"illuminant_{light['illuminant'].lower()}", 1)
    return light["radiant_intensity_w_sr"] * matching / matching[:, 1].sum() * lamp / lamp.mean()


class SnowTable:
    """Log transmittance and reflectance of one kind of snow over angle and depth, in two components."""

    def __init__(self, snowblue, snow, folder):
        depths = LAST_DEPTH_CM * (np.arange(1, DEPTHS + 1) / DEPTHS) ** 2
        angles = np.linspace(0, LAST_ANGLE_DEG, ANGLES)

        def listed(values):
            return ",".join(f"{value:.9g}" for value in values)

        snowblue(
            *("database", "build", "--space", "log", "--components", 2, "-o", folder / "snow.nc"),
            *("--grain-size", snow["grain_size_um"], "--facetness", snow["facetness"]),
            *("--density", snow["density_kg_m3"]),
            *("--thickness", listed(depths), "--angle", listed(angles), "--wavelengths", listed(WAVELENGTHS_NM)),
        )
        snowblue("database", "export", folder / "snow.nc", "-o", folder / "snow.json")
        document = json.loads((folder / "snow.json").read_text())
        numbers = np.fromfile(folder / document["numbers"], "<f4")
        arrays = {one["name"]: numbers[one["first_number"] :][: one["count"]] for one in document["arrays"]}
        names = ("transmittance", "reflectance")
        self.coefficients = [arrays[f"{name}_coefficients"].reshape(ANGLES, DEPTHS, 2) for name in names]
        self.basis = [arrays[f"{name}_basis"].reshape(-1, 2) for name in names]


def textured(values):
    """Texture of a table over angle and depth."""
    return mi.Texture2f(mi.TensorXf(values), wrap_mode=dr.WrapMode.Clamp)


def texture_coordinates(depth_m, cosine):
    """Texture coordinates of a depth and an angle."""
    angle = dr.rad2deg(dr.acos(dr.clip(cosine, 0, 1))) / LAST_ANGLE_DEG * (ANGLES - 1)
    depth = dr.sqrt(depth_m * (100 / LAST_DEPTH_CM)) * DEPTHS - 1
    return mi.Point2f((depth + 0.5) / DEPTHS, (angle + 0.5) / ANGLES)


class Spectra:
    """Looks up two coefficients and rebuilds all wavelengths."""

    def __init__(self, table, weights):
        self.textures = [textured(coefficients) for coefficients in table.coefficients]
        self.basis = table.basis
        self.weights = weights @ RGB.T

    def radiance(self, through, at_through, reflected, at, floor):
        transmitting, reflecting = self.textures[0].eval(at_through), self.textures[1].eval(at)
        colour = mi.Color3f(0)
        for t, r, weight in zip(*self.basis, self.weights):
            transmittance = dr.exp(float(t[0]) * transmitting[0] + float(t[1]) * transmitting[1])
            reflectance = dr.exp(float(r[0]) * reflecting[0] + float(r[1]) * reflecting[1])
            reflectance = dr.select(floor > 0, floor, reflectance)
            colour += mi.Color3f(weight.tolist()) * (transmittance * through + reflectance * reflected)
        return colour


class Colours:
    """Looks up log tristimulus values of the lamp's transmitted and reflected light."""

    def __init__(self, table, weights):
        pairs = zip(table.coefficients, table.basis)
        self.textures = [textured(np.log(np.exp(coefficients @ basis.T) @ weights)) for coefficients, basis in pairs]
        self.white = mi.Vector3f(weights.sum(0).tolist())

    def radiance(self, through, at_through, reflected, at, floor):
        transmitted = dr.exp(mi.Vector3f(self.textures[0].eval(at_through)))
        off = dr.exp(mi.Vector3f(self.textures[1].eval(at)))
        off = dr.select(floor > 0, floor * self.white, off)
        return mi.Color3f(mi.Matrix3f(RGB.tolist()) @ (transmitted * through + off * reflected))


class PCASnow(mi.SamplingIntegrator):
    """Direct light of one point lamp on diffuse surfaces and through one snow object (the paper's Algorithm 1)."""

    def set_up(self, snow, body, lamp, curves, floor, path):
        self.snow, self.body, self.lamp = mi.ShapePtr(snow), body, mi.Point3f(lamp)
        self.curves, self.floor, self.path = curves, floor, path
        return self

    def irradiance(self, scene, si, normal, active):
        """Cosine of incidence, and E/π for 1 W/sr: inverse square, cosine and visibility."""
        to_lamp = self.lamp - si.p
        squared = dr.squared_norm(to_lamp)
        cosine = dr.dot(normal, to_lamp) * dr.rsqrt(squared)
        facing = active & (cosine > 0)
        lit = facing & ~scene.ray_test(si.spawn_ray_to(self.lamp), facing)
        return cosine, dr.select(lit, cosine * dr.rcp(squared) * dr.inv_pi, 0)

    def sample(self, scene, sampler, ray, medium=None, active=True):
        si = scene.ray_intersect(ray, active)
        active = active & si.is_valid()
        snow = active & (si.shape == self.snow)
        into = ray.d if self.path == "view" else -si.n
        out = self.body.ray_intersect(si.spawn_ray(into), snow)
        outward = dr.mulsign(out.n, dr.dot(out.n, into))
        cosine_through, through = self.irradiance(scene, out, outward, snow & out.is_valid())
        cosine, reflected = self.irradiance(scene, si, si.n, active)
        depth, floor = dr.select(out.is_valid(), out.t, 0), dr.select(snow, 0, self.floor)
        at_through, at = texture_coordinates(depth, cosine_through), texture_coordinates(depth, cosine)
        colour = self.curves.radiance(through, at_through, reflected, at, floor)
        return dr.select(active, colour, 0), active, []


mi.register_integrator("pca_snow_bench", PCASnow)


def mitsuba_scene(document, folder, size, intensity):
    """Converts camera, lamp and shapes of a snowblue scene file."""
    camera, light = document["camera"], document["light"][0]
    scene = {
        "type": "scene",
        "camera": {
            "type": "perspective",
            "fov": camera["vertical_fov_deg"],
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(camera["position"], camera["look_at"], [0, 0, 1]),
            "sampler": {"type": "independent"},
            "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}},
        },
        "lamp": {"type": "point", "position": light["position"]},
    }
    scene["lamp"]["intensity"] = {"type": "rgb", "value": intensity.tolist()}
    for number, thing in enumerate(document["object"]):
        to_world = mi.ScalarTransform4f().translate(thing.get("position", [0, 0, 0]))
        to_world = to_world @ mi.ScalarTransform4f().scale(thing.get("scale", 1))
        reflectance = document["material"][thing["material"]].get("reflectance", 0.0)
        shape = {"bsdf": {"type": "diffuse", "reflectance": reflectance}}
        if "mesh" in thing:
            upright = mi.ScalarTransform4f().rotate([1, 0, 0], 90 if thing.get("up") == "y" else 0)
            shape |= {"type": "ply", "filename": str(folder / thing["mesh"]), "face_normals": True}
            shape["to_world"] = to_world @ upright
        elif thing["shape"] == "box":
            half = [length / 2 for length in thing["size"]]
            shape |= {"type": "cube", "to_world": to_world @ mi.ScalarTransform4f().scale(half)}
        else:  # a plane, large enough to fill the view
            shape |= {"type": "rectangle", "to_world": to_world @ mi.ScalarTransform4f().scale(1000)}
        scene[f"object {number}"] = shape
    return scene
