#!/usr/bin/env python3
"""Renders the oblique block of snow with Mitsuba 3 and with snowblue, compares the images and times both. Called by
bench-mitsuba.

Both render direct light only, on the same number of threads. Mitsuba's time is that of tracing alone, with the scene,
table and kernel ready. snowblue's time is that of the whole command, from start to the image on disk.
"""

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np
from mitsuba_snow import RGB, Colours, SnowTable, Spectra, lamp_weights, mitsuba_scene

SCENES = Path(__file__).resolve().parent.parent / "scenes"
BLOCK, DRAGON = SCENES / "block_30cm.toml", SCENES / "fig11_dragon.toml"
LUMINANCE = np.linalg.inv(RGB)[1]
# Largest deviation of the luminance ratio from 1 with the same table. Linear instead of spline interpolation causes a
# few thousandths; a wrong lamp, normal or angle would cause tens of percent.
TOLERANCE = 0.01
# Largest fraction of pixels that may be lit in one image only: outlines, at few samples.
OUTLINES = 0.01
PLAIN_SAMPLES = 16


class Snowblue:
    """The command, on the same number of threads as Mitsuba."""

    def __init__(self, program, threads):
        self.start = [program, "--threads", str(threads), "--quiet"]

    def __call__(self, *arguments):
        done = subprocess.run([*self.start, *map(str, arguments)], stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"bench-mitsuba: {done.stderr.strip()}")


def snow_pixels(scene, snow, size):
    """Mask of the pixels whose centre shows snow."""
    row, column = dr.meshgrid(*[(dr.arange(mi.Float, size) + 0.5) / size] * 2, indexing="ij")
    ray, _ = scene.sensors()[0].sample_ray(0, 0, mi.Point2f(column, row), 0)
    return np.array(scene.ray_intersect(ray).shape == mi.ShapePtr(snow)).reshape(size, size)


def linear(path):
    """Reads an image file as linear sRGB."""
    return np.array(mi.Bitmap(str(path)))[..., :3]


def compare(name, theirs, ours, parts):
    """Prints the mean logarithmic difference of the pixels, and exits if it is too large."""
    there, here = theirs @ LUMINANCE, ours @ LUMINANCE
    for part, pixels in parts.items():
        both, either = pixels & (there > 0) & (here > 0), pixels & ((there > 0) | (here > 0))
        unmatched = (either & ~both).sum() / pixels.sum()
        difference = np.exp(np.log(there[both] / here[both]).mean()) - 1
        print(f"{name}: {part} differs by {difference:+.2%} from snowblue; lit in one image only: {unmatched:.2%}")
        if not (abs(difference) <= TOLERANCE and unmatched <= OUTLINES):
            sys.exit(f"bench-mitsuba: images differ by more than {TOLERANCE:.0%}, or {OUTLINES:.0%} of the pixels")


def used_s(action):
    """Wall and CPU time of an action in s, including its processes."""

    def cpu_s():
        return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))

    wall, cpu = time.perf_counter(), cpu_s()
    action()
    return time.perf_counter() - wall, cpu_s() - cpu


def medians_s(actions, repeats):
    """Median wall and CPU times of actions in s, measured alternately after two warm-up runs of each.

    Mitsuba compiles in the first run, and again in the second since its state has changed.
    """
    for action in 2 * list(actions.values()):
        action()
    times = {name: [] for name in actions}
    for _ in range(repeats):
        for name, action in actions.items():
            times[name].append(used_s(action))
    return {name: [statistics.median(kind) for kind in zip(*pairs)] for name, pairs in times.items()}


def report(medians, pairs):
    """Prints a row per action, and the ratio of the times of each pair."""
    print(f"{'':44}{'wall s':>9}{'CPU s':>9}")
    for name, (wall, cpu) in medians.items():
        print(f"{name:44}{wall:9.2f}{cpu:9.2f}")
    for theirs, ours in pairs:
        wall, cpu = (there / here for there, here in zip(medians[theirs], medians[ours]))
        print(f"{theirs}: {wall:.2f} times the wall time of {ours}, {cpu:.2f} times its CPU time")


def block(options, snowblue, folder):
    """The block of snow with direct light."""
    document = tomllib.loads(BLOCK.read_text())
    weights = lamp_weights(document["light"][0])
    table = SnowTable(snowblue, document["material"]["drift"], folder)
    shapes = mitsuba_scene(document, BLOCK.parent, options.size, RGB @ weights.sum(0))
    scene, body = mi.load_dict(shapes), mi.load_dict({"type": "scene", "snow": shapes["object 0"]})
    snow = next(shape for shape in scene.shapes() if shape.id() == "object 0")
    floor, lamp = document["material"]["floor"]["reflectance"], document["light"][0]["position"]
    pictures = {}

    def mitsuba(name, curves):
        integrator = mi.load_dict({"type": "pca_snow_bench"}).set_up(snow, body, lamp, curves, floor, options.path)
        seeds = iter(range(1000))

        def action():
            pictures[name] = np.array(integrator.render(scene, spp=options.samples, seed=next(seeds)))

        return action

    def ours(name, *more):
        place = folder / f"{name}.exr"
        size = ("--width", options.size, "--height", options.size, "--spp", options.samples)
        return lambda: snowblue("render", BLOCK, "--max-bounces", 0, *size, "-o", place, *more)

    spectra, colours = f"Mitsuba, 31 wavelengths, path {options.path}", f"Mitsuba, colours, path {options.path}"
    same, brightest = f"snowblue, path {options.path}", "snowblue, path brightest"
    actions = {spectra: mitsuba(spectra, Spectra(table, weights)), colours: mitsuba(colours, Colours(table, weights))}
    actions[same] = ours("same", "--path", options.path)
    actions[brightest] = ours("brightest", "--path", "brightest")
    medians = medians_s(actions, options.repeats)
    ours("two", "--path", options.path, "--database", folder / "snow.nc")()
    shown = snow_pixels(scene, snow, options.size)
    for name in (spectra, colours):
        compare(name, pictures[name], linear(folder / "two.exr"), {"snow": shown, "floor": ~shown})
    print(f"\n{options.size}×{options.size}, {options.samples} samples, direct light, {options.threads} threads")
    report(medians, [(spectra, same), (colours, same), (spectra, brightest)])
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
        side_by_side = np.hstack([pictures[spectra], linear(folder / "same.exr")]) * 2 ** document["film"]["exposure"]
        mi.util.write_bitmap(str(options.pictures / "block.png"), side_by_side.astype(np.float32), write_async=False)


def plain(options, snowblue, folder):
    """Ray tracing alone: a grey dragon, with a camera ray and a shadow ray per sample."""
    text = DRAGON.read_text().replace('material = "snow"', 'material = "floor"')
    document = tomllib.loads(text)
    mesh = (DRAGON.parent / document["object"][0]["mesh"]).resolve()
    if not mesh.exists():
        print(f"\nskipping the dragon: {mesh} does not exist (scripts/fetch-models)")
        return
    scene_file = folder / "grey.toml"
    scene_file.write_text(text.replace(document["object"][0]["mesh"], str(mesh)))
    shapes = mitsuba_scene(document, DRAGON.parent, options.size, RGB @ lamp_weights(document["light"][0]).sum(0))
    integrator = mi.load_dict({"type": "direct", "emitter_samples": 1, "bsdf_samples": 0})
    loaded, seeds = {}, iter(range(1000))

    def load():
        loaded["scene"] = mi.load_dict(shapes)

    def render():
        loaded["picture"] = np.array(integrator.render(loaded["scene"], spp=PLAIN_SAMPLES, seed=next(seeds)))

    def ours(size, samples):
        size = ("--width", size, "--height", size, "--spp", samples, "--max-bounces", 0)
        return lambda: snowblue("render", scene_file, *size, "-o", folder / "grey.exr")

    actions = {"Mitsuba, loading": load, "Mitsuba, rays": render}
    actions |= {"snowblue, loading": ours(1, 1), "snowblue, loading and rays": ours(options.size, PLAIN_SAMPLES)}
    medians = medians_s(actions, options.repeats)
    whole = medians.pop("snowblue, loading and rays")
    medians["snowblue, rays"] = [both - first for both, first in zip(whole, medians["snowblue, loading"])]
    print()
    everywhere = np.full((options.size, options.size), True)
    compare("Mitsuba", loaded["picture"], linear(folder / "grey.exr"), {"the grey dragon": everywhere})
    print(f"\ndragon, {options.size}×{options.size}, {PLAIN_SAMPLES} samples of two rays, {options.threads} threads")
    report(medians, [("Mitsuba, loading", "snowblue, loading"), ("Mitsuba, rays", "snowblue, rays")])
    paths = options.size**2 * PLAIN_SAMPLES
    for name in ("Mitsuba, rays", "snowblue, rays"):
        print(f"{name}: {medians[name][1] / paths * 1e6:.3f} µs of CPU per sample")


def positive(text):
    """Parses a whole number from 1."""
    number = int(text)
    if number < 1:
        raise ValueError
    return number


def main():
    parser = argparse.ArgumentParser(prog="bench-mitsuba", description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=positive, default=1080, help="width and height in pixels [1080]")
    parser.add_argument("--samples", type=positive, default=100, help="samples per pixel of the block [100]")
    parser.add_argument("--repeats", type=positive, default=3, help="measured runs of each [3]")
    parser.add_argument("--threads", type=positive, default=2, help="threads of each program [2]")
    parser.add_argument("--path", choices=("view", "normal"), default="view", help="path mode [view]")
    parser.add_argument("--plain", action="store_true", help="also measure ray tracing alone, on the dragon")
    parser.add_argument("--pictures", type=Path, metavar="FOLDER", help="write both images side by side into FOLDER")
    parser.add_argument("program", help=argparse.SUPPRESS)
    options = parser.parse_args()
    dr.set_thread_count(options.threads)
    snowblue = Snowblue(options.program, options.threads)
    with tempfile.TemporaryDirectory() as folder:
        block(options, snowblue, Path(folder))
        if options.plain:
            plain(options, snowblue, Path(folder))


if __name__ == "__main__":
    main()
