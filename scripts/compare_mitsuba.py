#!/usr/bin/env python3
"""Compares the mean radiance of small pictures of snow by snowblue with that by Mitsuba 3 at 550 nm. Called by
compare-mitsuba.

Mitsuba's `volpath` traces a homogeneous medium with an index-matched boundary. Its extinction, single-scattering albedo
and phase function are those of `snowblue.single_scattering`. Lengths are in centimetres there: Mitsuba moves the
origins of rays by a distance that is not small against free paths in metres.
"""

import argparse
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np
import snowblue

mi.set_variant("llvm_ad_mono")
mi.set_log_level(mi.LogLevel.Error)

WAVELENGTH_NM = 550
SNOW = {"grain_size_um": 400, "facetness": 0.3, "density_kg_m3": 300}
# Power of a lamp of equal energy that has 1 W/(sr nm): that of 31 bands of 10 nm.
LAMP_W_SR = 310
CM_PER_M = 100
SIZE = 16
INTEGRATORS = ("reference", "hybrid", "diffusion")
# Pictures of other seeds, whose scatter is the standard error.
PICTURES = 8
# Moments and points of the tabulated phase function.
DEGREE, POINTS = 64, 2001
# An integrator fails if it differs by more than both.
TOLERANCES, STANDARD_ERRORS = {"reference": 0.03, "hybrid": 0.05}, 3


def torus():
    """Vertices and triangles of a torus with bumps."""
    around, across = 160, 64
    u, v = np.meshgrid(np.arange(around) / around, np.arange(across) / across, indexing="ij")
    u, v = math.tau * u.ravel(), math.tau * v.ravel()
    small = 0.02 * (1 + 0.08 * np.sin(5 * u) * np.cos(3 * v))
    large = 0.05 + small * np.cos(v)
    vertices = np.stack([large * np.cos(u), large * np.sin(u), small * np.sin(v)], -1)
    i, j = np.divmod(np.arange(around * across), across)
    right, up = (i + 1) % around, (j + 1) % across
    a, b, c, d = i * across + j, right * across + j, right * across + up, i * across + up
    return vertices, np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])


class Scene:
    """A body of snow, a lamp and a camera, in metres."""

    def __init__(self, name, lamp, camera, field_of_view_deg, shape, mesh=None):
        self.name, self.lamp, self.camera, self.field_of_view_deg = name, lamp, camera, field_of_view_deg
        self.shape, self.mesh = shape, mesh

    def write(self, folder):
        """Writes the file of snowblue, and the mesh that it names."""
        snow = "".join(f"{key} = {value}\n" for key, value in SNOW.items())
        path = folder / f"{self.name}.toml"
        path.write_text(
            f"[camera]\nposition = {self.camera}\nlook_at = [0, 0, 0]\nvertical_fov_deg = {self.field_of_view_deg}\n"
            f"[film]\nwidth = {SIZE}\nheight = {SIZE}\n[material.snow]\ntype = \"snow\"\n{snow}"
            f"[[light]]\ntype = \"point\"\nposition = {self.lamp}\nilluminant = \"E\"\n"
            f"radiant_intensity_w_sr = {LAMP_W_SR}\n[[object]]\nmaterial = \"snow\"\n{self.shape}\n"
        )
        if self.mesh:
            vertices, triangles = self.mesh
            lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
            lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
            (folder / "mesh.obj").write_text("\n".join(lines) + "\n")
        return path

    def mitsuba(self, shape, medium):
        """The same for Mitsuba, with a shape in centimetres."""
        position, lamp = ([CM_PER_M * value for value in place] for place in (self.camera, self.lamp))
        return mi.load_dict({
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 1 << 30},
            "sensor": {
                "type": "perspective",
                "fov": self.field_of_view_deg,
                "to_world": mi.ScalarTransform4f().look_at(position, [0, 0, 0], [0, 0, 1]),
                "film": {
                    "type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"},
                    "pixel_format": "luminance",
                },
            },
            "lamp": {"type": "point", "position": lamp, "intensity": {"type": "uniform", "value": CM_PER_M**2}},
            "snow": shape | {"bsdf": {"type": "null"}, "interior": medium},
        })


def medium():
    """The snow as a medium of Mitsuba."""
    snow = snowblue.single_scattering(wavelength_nm=WAVELENGTH_NM, degree=DEGREE, **SNOW).isel(wavelength=0)
    degrees = np.arange(DEGREE + 1)
    cosines = np.linspace(-1, 1, POINTS)
    series = np.polynomial.legendre.legval(cosines, (2 * degrees + 1) / 2 * snow["moments"].values)
    # A finite series may be negative where the function is small.
    values = np.maximum(series, 0)
    asymmetry = np.trapezoid(values * cosines, cosines) / np.trapezoid(values, cosines)
    if abs(asymmetry - float(snow["asymmetry"])) > 1e-3 * (1 - asymmetry):
        sys.exit(f"compare-mitsuba: the phase function has the asymmetry {asymmetry}, not {float(snow['asymmetry'])}")
    return {
        "type": "homogeneous",
        "sigma_t": float(snow["extinction"]) / CM_PER_M,
        "albedo": 1 - float(snow["coalbedo"]),
        "phase": {"type": "tabphase", "values": ",".join(f"{value:.9g}" for value in values)},
    }


def mitsuba_shape(scene, folder):
    """The shape of a scene in centimetres."""
    if scene.mesh:
        path = str(folder / "mesh.obj")
        scale = mi.ScalarTransform4f().scale(CM_PER_M)
        return {"type": "obj", "filename": path, "face_normals": True, "to_world": scale}
    if scene.name == "ball":
        return {"type": "sphere", "radius": 0.02 * CM_PER_M}
    half = [0.5 * CM_PER_M * length for length in (0.12, 0.05, 0.12)]
    return {"type": "cube", "to_world": mi.ScalarTransform4f().scale(half)}


def mean_and_error(values):
    return np.mean(values), np.std(values, ddof=1) / math.sqrt(len(values))


def by_mitsuba(scene, samples):
    """Mean radiances in W/(m² sr nm) of pictures of several seeds."""
    pictures = (mi.render(scene, spp=samples, seed=seed) for seed in range(1, PICTURES + 1))
    return [float(np.mean(np.array(picture))) for picture in pictures]


def by_snowblue(program, path, integrator, samples, folder):
    """The same by an integrator of snowblue."""
    means = []
    picture = folder / "picture.exr"
    for seed in range(1, PICTURES + 1):
        subprocess.run(
            [program, "--quiet", "render", path, "--integrator", integrator, "--spp", str(samples), "--seed", str(seed),
             "--aovs", "spectrum", "-o", picture],
            check=True,
        )
        image = mi.Bitmap(str(picture))
        names = [field.name for field in image.struct_()]
        [channel] = [number for number, name in enumerate(names) if f"{WAVELENGTH_NM},000" in name]
        means.append(float(np.mean(np.array(image)[..., channel])))
    return means


SCENES = [
    Scene("ball", [0.05, 0.4, 0.1], [0.06, -0.2, 0.08], 14, 'shape = "sphere"\nradius = 0.02'),
    Scene("block", [0.05, 0.4, 0.1], [0.3, -0.8, 0.3], 12, 'shape = "box"\nsize = [0.12, 0.05, 0.12]'),
    Scene("torus", [0.4, -0.5, 0.4], [0.2, -0.7, 0.5], 12, 'mesh = "mesh.obj"\nsmooth = false', torus()),
]


def compare(scene, options, folder):
    """Prints the ratios of a scene, and says whether reference and hybrid agree."""
    path = scene.write(folder)
    traced = scene.mitsuba(mitsuba_shape(scene, folder), medium())
    truth, truth_error = mean_and_error(by_mitsuba(traced, options.mitsuba_samples))
    agrees = True
    ratios = []
    for integrator in INTEGRATORS:
        samples = options.reference_samples if integrator == "reference" else options.samples
        mean, error = mean_and_error(by_snowblue(options.snowblue, path, integrator, samples, folder))
        ratio = mean / truth
        ratio_error = ratio * math.hypot(error / mean, truth_error / truth)
        ratios.append(f"{ratio:.3f} ± {ratio_error:.3f}")
        if integrator in TOLERANCES:
            agrees &= abs(ratio - 1) <= max(TOLERANCES[integrator], STANDARD_ERRORS * ratio_error)
    columns = [f"{scene.name:8}{truth:15.5g} ± {truth_error / truth:6.2%}", *(f"{ratio:>16}" for ratio in ratios)]
    print(*columns, flush=True)
    return agrees


def samples(text):
    count = int(text)
    if not 1 <= count <= 1 << 20:
        raise argparse.ArgumentTypeError(f"is {count}, but must lie in 1–{1 << 20}")
    return count


def main():
    parser = argparse.ArgumentParser(prog="compare-mitsuba", description=__doc__)
    one_picture = f"in each of {PICTURES} pictures (default %(default)s)"
    parser.add_argument("--mitsuba-samples", type=samples, default=256, help=f"samples per pixel {one_picture}")
    parser.add_argument("--reference-samples", type=samples, default=128, help=f"those of the reference {one_picture}")
    parser.add_argument("--samples", type=samples, default=128, help=f"those of hybrid and diffusion {one_picture}")
    parser.add_argument("--scene", choices=[scene.name for scene in SCENES], help="only this scene")
    parser.add_argument("snowblue", help="the program")
    options = parser.parse_args()
    print(f"{'scene':8}{'Mitsuba, W/(m² sr nm)':>24}", *(f"{name:>16}" for name in INTEGRATORS))
    chosen = [scene for scene in SCENES if options.scene in (None, scene.name)]
    with tempfile.TemporaryDirectory() as folder:
        failed = [scene.name for scene in chosen if not compare(scene, options, Path(folder))]
    if failed:
        sys.exit(f"compare-mitsuba: the reference or hybrid differs from Mitsuba: {', '.join(failed)}")


if __name__ == "__main__":
    main()
