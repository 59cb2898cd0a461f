"""Snow in Mitsuba 3, beside our own pictures of the same scenes."""

import collections
import contextlib
import functools
import os
import pickle
import re
import subprocess
import sys
import textwrap
import warnings

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
import trimesh

# The compiled variants that are tested: "cuda" needs a graphics card of NVIDIA.
BACKEND = os.environ.get("SNOWBLUE_MITSUBA", "llvm")
RGB, SPECTRAL = f"{BACKEND}_ad_rgb", f"{BACKEND}_ad_spectral"
mi.set_variant(RGB)

import snowblue  # noqa: E402
import snowblue.mitsuba  # noqa: E402, F401
from snowblue._renderers import BAND_WIDTH_NM  # noqa: E402

SIZE = 48
CAMERA = dict(position=[0.5, -0.7, 0.35], look_at=[0, 0, 0.1], vertical_fov_deg=22)
SNOW = {"snow": {"type": "snow", "grain_size_um": 400, "facetness": 0.3, "density_kg_m3": 300}}
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
COARSE = dict(step_mm=20.0, field_step_mm=10.0)
"""Of light fields that are compared with others alike."""


def scene(shapes, lights, **integrator):
    transform = mi.ScalarTransform4f()
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}}
    to_world = transform.look_at(CAMERA["position"], CAMERA["look_at"], [0, 0, 1])
    sensor = {"type": "perspective", "fov": CAMERA["vertical_fov_deg"], "fov_axis": "y", "to_world": to_world,
              "film": film}
    description = {"type": "scene", "integrator": {"type": "snow", **integrator}, "sensor": sensor, **shapes, **lights}
    try:
        return mi.load_dict(description)
    except RuntimeError as error:
        # Once, and in none of 40,000 tries afterwards, the constructor of Mitsuba 3.9.1's own sunsky failed so.
        if 'plugin of type "sunsky": basic_string' not in str(error):
            raise
        return mi.load_dict(description)


def block(**other):
    transform = mi.ScalarTransform4f()
    return {"block": {"type": "cube", "to_world": transform.translate([0, 0, 0.1]).scale([0.1, 0.05, 0.1]),
                      "bsdf": {"type": "snow_surface", **other}, "emitter": {"type": "snow_light"}}}


@functools.cache
def daylight():
    """The colour of 1 W/(m2 sr) of D65 in our pictures."""
    return snowblue.Scene(
        camera=dict(position=[0, 0, 1], look_at=[0, 0, 0], up=[0, 1, 0]), film={"width": 1, "height": 1},
        integrator={"max_bounces": 0}, material={"white": {"type": "diffuse", "reflectance": 1.0}},
        light=[{"type": "directional", "direction": [0, 0, -1], "illuminant": "D65", "irradiance_w_m2": np.pi}],
        object=[{"shape": "box", "size": [1, 1, 0.1], "position": [0, 0, -0.05], "material": "white"}],
    ).render(integrator="pcasnow", samples_per_pixel=1).rgb.values[0, 0]


OURS = {}
"""Our own pictures, by what they are of: those of all variants are compared with one."""


def ours(*arguments, **keywords):
    """Our picture and its standard errors, in units in which white light of D65 is 1."""
    key = pickle.dumps((arguments, keywords, CAMERA))
    if key not in OURS:
        OURS[key] = rendered(*arguments, **keywords)
    return OURS[key]


def rendered(objects, light, bounces=0, samples=256, integrator="diffusion", more=None, **pcasnow):
    """Our picture and its standard errors."""
    key = "light" if "type" in light else "sky" if "sun" in light else "environment"
    made = snowblue.Scene(
        **(more or {}),
        camera=CAMERA, film={"width": SIZE, "height": SIZE}, integrator={"max_bounces": bounces, "pcasnow": pcasnow},
        material={**SNOW, "floor": {"type": "diffuse", "reflectance": 0.5}},
        object=objects, **{key: [light] if key == "light" else light})
    picture = made.render(integrator=integrator, samples_per_pixel=samples, aovs=["variance"])
    white = daylight()
    return picture.rgb.values / white, np.sqrt(picture.variance.values) / white


def theirs(made, batches=8, samples=32):
    """Mitsuba's picture and its standard errors."""
    pictures = np.stack([np.array(mi.render(made, spp=samples, seed=seed))[..., :3] for seed in range(batches)])
    return pictures.mean(axis=0), pictures.std(axis=0, ddof=1) / np.sqrt(batches)


def inside(picture):
    """The pixels all of whose neighbours are lit: no outlines."""
    lit = picture @ LUMINANCE > 0
    inner = lit.copy()
    for axis in (0, 1):
        for shift in (-1, 1):
            inner &= np.roll(lit, shift, axis=axis)
    return inner


def assert_agree(there, here, mean=0.01, pixel=0.02, allowed=0.02):
    """Means over pixels within 1 %; single pixels within 2 % and 4 standard errors, but for some at edges, where the
    surface is read at vertices and our own picture has single scattering."""
    (a, a_se), (b, b_se) = there, here
    mask = inside(a) & inside(b)
    assert mask.sum() > 200
    np.testing.assert_allclose(a[mask].mean(axis=0), b[mask].mean(axis=0), rtol=mean)
    a, b, se = (x[mask] @ LUMINANCE for x in (a, b, np.hypot(a_se, b_se)))
    beyond = np.abs(a - b) > pixel * b + 4 * se
    assert beyond.mean() <= allowed, f"{beyond.mean():.1%} of the pixels differ"


BOX = {"shape": "box", "size": [0.2, 0.1, 0.2], "position": [0, 0, 0.1], "material": "snow"}


def lamp(position, watts=10.0):
    """A point lamp there and here."""
    there = {"lamp": {"type": "point", "position": position, "intensity": {"type": "d65", "scale": watts}}}
    return there, {"type": "point", "position": position, "illuminant": "D65", "radiant_intensity_w_sr": watts}


@pytest.fixture(params=[RGB, SPECTRAL])
def variant(request):
    mi.set_variant(request.param)
    yield request.param
    mi.set_variant(RGB)


@pytest.mark.parametrize("position", [[0.0, 0.6, 0.1], [0.3, -0.8, 0.4]], ids=["from behind", "from the front"])
def test_a_block_is_that_of_our_own_pictures(variant, position):
    there, here = lamp(position)
    made = scene(block(), there, max_depth=2, step_mm=5, field_step_mm=5)
    # Four wavelengths a sample are noisy.
    samples = 32 if variant == RGB else 512
    assert_agree(theirs(made, samples=samples), ours([BOX], here))


@functools.cache
def torus(sides=96, around=48):
    """A closed mesh with a hole, 20 cm wide, 9 cm thick."""
    u, v = np.meshgrid(*(2 * np.pi * np.arange(count) / count for count in (sides, around)), indexing="ij")
    radius = 0.055 + 0.045 * np.cos(v)
    vertices = np.stack([radius * np.cos(u), 0.045 * np.sin(v), radius * np.sin(u) + 0.1], axis=-1).reshape(-1, 3)
    number = np.arange(sides * around).reshape(sides, around)
    right, up = np.roll(number, -1, axis=0), np.roll(number, -1, axis=1)
    corner = np.roll(right, -1, axis=1)
    quads = np.stack([number, up, corner, right], axis=-1).reshape(-1, 4)
    return vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def as_shape(vertices, triangles, folder, kind="snow_surface"):
    path = folder / "mesh.ply"
    path.write_bytes(snowblue._scene._ply(vertices.astype("<f4"), triangles))
    return {"torus": {"type": "ply", "filename": str(path), "bsdf": {"type": kind}, "emitter": {"type": "snow_light"}}}


def test_a_mesh_is_that_of_our_own_pictures(tmp_path):
    mesh = torus()
    there, here = lamp([0.3, -0.8, 0.4])
    made = scene(as_shape(*mesh, tmp_path), there, max_depth=2)
    # Where curved snow is lit and seen at grazing angles, our own picture has single scattering in the body itself.
    assert_agree(theirs(made), ours([{"mesh": mesh, "material": "snow"}], here), pixel=0.03, allowed=0.05)


@pytest.mark.parametrize("position, mean", [([0.0, 0.6, 0.1], 0.74), ([0.3, -0.8, 0.4], 1.09)])
def test_a_small_ball_has_the_light_of_the_chapter_beside_hybrid(tmp_path, monkeypatch, position, mean):
    monkeypatch.setitem(CAMERA, "vertical_fov_deg", 4)
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.02)
    there, here = lamp(position)
    shape = as_shape(ball.vertices + [0, 0, 0.1], ball.faces, tmp_path)
    picture, _error = theirs(scene(shape, there, max_depth=2), batches=2, samples=64)
    sphere = {"shape": "sphere", "radius": 0.02, "position": [0, 0, 0.1], "material": "snow"}
    walks, _error = ours([sphere], here, integrator="hybrid")
    mask = inside(picture) & inside(walks)
    # The noise of 256 walks a pixel, over 700 pixels, and the differences of the two meshes.
    np.testing.assert_allclose(picture[mask].mean(axis=0) / walks[mask].mean(axis=0), mean, atol=0.02)


@pytest.mark.parametrize("kind", ["sphere", "rectangle", "spot", "directional", "constant"])
def test_every_emitter_lights_snow_as_our_own(kind):
    transform = mi.ScalarTransform4f()
    d65 = {"type": "d65", "scale": 20.0}
    position, target = [0.0, 0.6, 0.1], [0.0, 0.0, 0.1]
    area = {"emitter": {"type": "area", "radiance": d65}}
    placed = transform.translate(position).scale(0.05)
    facing = transform.look_at(position, target, [0, 0, 1])
    there, here = {
        "sphere": ({"type": "sphere", "to_world": placed, **area},
                   {"type": "sphere", "position": position, "radius": 0.05, "radiance_w_m2_sr": 20.0}),
        "rectangle": ({"type": "rectangle", "to_world": facing.scale(0.05), **area},
                      {"type": "rectangle", "position": position, "look_at": target, "size": [0.1, 0.1],
                       "radiance_w_m2_sr": 20.0}),
        "spot": ({"type": "spot", "to_world": facing, "intensity": d65, "cutoff_angle": 60, "beam_width": 59},
                 {"type": "spot", "position": position, "look_at": target, "radiant_intensity_w_sr": 20.0,
                  "inner_cone_deg": 59, "outer_cone_deg": 60}),
        "directional": ({"type": "directional", "direction": [0, -1, 0], "irradiance": d65},
                        {"type": "directional", "direction": [0, -1, 0], "irradiance_w_m2": 20.0}),
        "constant": ({"type": "constant", "radiance": d65}, None),
    }[kind]
    if kind == "constant":
        # A white furnace: deep snow under a white sky is white but for what it absorbs.
        made = theirs(scene(block(), {"lamp": there}, max_depth=2))[0]
        white = made[inside(np.ones_like(made)) & inside(made)] / 20
        assert 0.9 < white[..., 2].mean() < 1.01 and white[..., 0].mean() < white[..., 2].mean()
        return
    made = scene(block(), {"lamp": there}, max_depth=2, step_mm=5, field_step_mm=5)
    assert_agree(theirs(made), ours([BOX], {**here, "illuminant": "D65"}))


def test_a_uniform_image_of_the_sky_is_a_constant_sky(variant):
    image = mi.Bitmap(np.full((16, 32, 3), 20.0, dtype=np.float32))
    skies = [{"type": "constant", "radiance": {"type": "d65", "scale": 20.0}}, {"type": "envmap", "bitmap": image}]
    samples = 64 if variant == RGB else 512
    pictures = [np.array(mi.render(scene(block(), {"sky": sky}, max_depth=2, **COARSE), spp=samples)) for sky in skies]
    # The pixels in the middle are snow.
    first, second = (picture[18:30, 18:30, :3].mean(axis=(0, 1)) for picture in pictures)
    np.testing.assert_allclose(second, first, rtol=0.01)


def test_sun_and_sky_are_ours(variant):
    transform = mi.ScalarTransform4f().rotate([0, 0, 1], 90)
    # The sun stands behind the block on the left, wherever the sky is turned.
    sunsky = {"type": "sunsky", "sun_direction": [-1, 1, 0.8], "to_world": transform, "turbidity": 4.0, "albedo": 0.3,
              "sun_scale": 0.05, "sky_scale": 0.05}
    # Watts per nm there are watts over all wavelengths here.
    sky = {"sun": {"towards": [-1, 1, 0.8]}, "turbidity": 4, "ground_albedo": 0.3, "scale": 0.05 / BAND_WIDTH_NM}
    samples = 64 if variant == RGB else 512
    made = scene(block(), {"sky": sunsky}, max_depth=2, step_mm=5, field_step_mm=5)
    here = [values * daylight() for values in ours([BOX], sky)]
    # Three channels do not hold the spectrum of the sky, and the sky has noise.
    assert_agree(theirs(made, samples=samples), here, mean=0.03, pixel=0.05, allowed=0.05)
    sunsky["sun_scale"] = 1.0
    assert_refused("sunsky with different scales", block(), {"sky": sunsky})


def test_a_sun_in_an_image_of_the_sky_shines_from_its_place():
    pixels = np.zeros((512, 1024, 3), dtype=np.float32)
    # Its diameter is 2 degrees.
    pixels[148:153, 298:303] = 1000.0
    to_world = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    sky = {"type": "envmap", "bitmap": mi.Bitmap(pixels), "to_world": to_world}
    numbers = np.random.default_rng(1).random((2, 20000), dtype=np.float32)
    seen, weight = mi.load_dict(sky).sample_direction(dr.zeros(mi.SurfaceInteraction3f), mi.Point2f(numbers))
    direction, irradiance = -np.array(seen.d).mean(axis=1), np.array(weight).mean(axis=1)
    sun = {"type": "directional", "direction": direction.tolist(),
           "irradiance": {"type": "rgb", "value": irradiance.tolist()}}
    there = np.array(mi.render(scene(block(), {"lamp": sky}, max_depth=2, **COARSE), spp=256))
    here = np.array(mi.render(scene(block(), {"lamp": sun}, max_depth=2, **COARSE), spp=64))
    mask = inside(here)
    assert mask.sum() > 200
    np.testing.assert_allclose(there[mask].mean(axis=0), here[mask].mean(axis=0), rtol=0.01)


def test_floors_give_and_take_light(variant):
    transform = mi.ScalarTransform4f()
    floor = {"floor": {"type": "rectangle", "to_world": transform.scale(1.0),
                       "bsdf": {"type": "diffuse", "reflectance": 0.5}}}
    there, here = lamp([0.3, -0.8, 0.4])
    made = scene({**block(), **floor}, there, max_depth=8, step_mm=5, field_step_mm=5)
    floor_here = {"shape": "box", "size": [2, 2, 0.1], "position": [0, 0, -0.05], "material": "floor"}
    samples = 64 if variant == RGB else 512
    assert_agree(theirs(made, samples=samples), ours([BOX, floor_here], here, bounces=7), allowed=0.05)


def test_a_mesh_from_elsewhere_lies_in_the_sun_under_a_sky_on_a_floor():
    """A ring by trimesh: concave, with sharp edges and long triangles. The sun has its true width in the sky."""
    ring = trimesh.creation.annulus(r_min=0.04, r_max=0.1, height=0.08, sections=48)
    ring.apply_transform(trimesh.transformations.rotation_matrix(1.2, [1, 0.2, 0]))
    ring.apply_translation([0, 0, 0.12])
    sun, radius = [3.0, -4.0, 5.0], 0.0329
    there = {
        "sun": {"type": "sphere", "center": sun, "radius": radius,
                "emitter": {"type": "area", "radiance": {"type": "d65", "scale": 20000.0}}},
        "sky": {"type": "constant", "radiance": {"type": "d65", "scale": 0.5}},
        "floor": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 0.5}},
    }
    snow = snowblue.mitsuba.snow_mesh(ring.vertices, ring.faces)
    made = scene({"ring": snow}, there, max_depth=8, step_mm=5, field_step_mm=5)
    objects = [{"mesh": (ring.vertices, ring.faces), "material": "snow"},
               {"shape": "box", "size": [2, 2, 0.1], "position": [0, 0, -0.05], "material": "floor"}]
    light = {"type": "sphere", "position": sun, "radius": radius, "illuminant": "D65", "radiance_w_m2_sr": 20000.0}
    sky = {"environment": {"illuminant": "D65", "radiance_w_m2_sr": 0.5}}
    here = ours(objects, light, bounces=7, samples=128, more=sky)
    assert_agree(theirs(made, samples=128), here, pixel=0.03, allowed=0.05)


def logged(action):
    """The messages that an action logs."""
    texts = []

    class Kept(mi.Appender):
        def append(self, level, text):
            texts.append(text)

        def log_progress(self, progress, name, formatted, eta, ptr=None):
            pass

    kept = Kept()
    mi.logger().add_appender(kept)
    try:
        action()
    finally:
        mi.logger().remove_appender(kept)
    return texts


def test_scalar_variants_agree_with_compiled_ones_and_are_silent(monkeypatch):
    floor = {"floor": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 0.5}}}
    there, _ = lamp([0.0, 0.6, 0.1])
    compiled = np.array(mi.render(scene({**block(), **floor}, there, max_depth=3, **COARSE), spp=64))
    mi.set_variant("scalar_rgb")
    try:
        made, pictures = scene({**block(), **floor}, there, max_depth=3, **COARSE), []
        texts = logged(lambda: pictures.append(np.array(mi.render(made, spp=16))))
        with monkeypatch.context() as patched:
            # The snow of this scene has samples below 0, of which Mitsuba would warn.
            patched.setattr(snowblue.mitsuba, "_negative_samples_allowed", contextlib.nullcontext)
            loud = logged(lambda: mi.render(made, spp=1))
        with snowblue.mitsuba._negative_samples_allowed():
            others = ["Invalid sample value: [nan, 0, 0, 1]", "Another message"]
            passed = logged(lambda: [mi.Log(mi.LogLevel.Warn, text) for text in others])
    finally:
        mi.set_variant(RGB)
    assert any("Invalid sample value" in text for text in loud)
    assert not any("Invalid sample value" in text for text in texts)
    assert all(any(other in text for text in passed) for other in others)
    mask = inside(compiled) & inside(pictures[0])
    np.testing.assert_allclose(pictures[0][mask].mean(axis=0), compiled[mask].mean(axis=0), rtol=0.01)


@pytest.fixture
def solutions(monkeypatch):
    """Counts the solutions for light in snow."""
    count, native = collections.Counter(), snowblue.mitsuba._native.Scene

    class Counted:
        def __init__(self, scene):
            self.scene = scene

        @staticmethod
        def from_json(*arguments):
            return Counted(native.from_json(*arguments))

        def with_json(self, text):
            return Counted(self.scene.with_json(text))

        def bake(self, *arguments):
            count["bakes"] += 1
            return self.scene.bake(*arguments)

    class Native:
        Scene = Counted
        colors = staticmethod(snowblue.mitsuba._native.colors)

    monkeypatch.setattr(snowblue.mitsuba, "_native", Native)
    return lambda: count["bakes"]


def lamp_scene(color, position, sky=0.5):
    """A block on a floor, lit by a lamp, whose colour is one number in spectral variants, and a sky."""
    floor = {"floor": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 0.5}}}
    strength = {"type": "rgb", "value": color} if np.ndim(color) else {"type": "uniform", "value": color}
    lights = {"lamp": {"type": "point", "position": position, "intensity": strength},
              "sky": {"type": "constant", "radiance": {"type": "uniform", "value": sky}}}
    return scene({**block(), **floor}, lights, max_depth=3, **COARSE)


def changed(made, name, value):
    parameters = mi.traverse(made)
    key = next(key for key in parameters.keys() if key.startswith(name))
    parameters[key] = value
    parameters.update()
    return np.array(mi.render(made, spp=16))


def test_a_lamp_of_another_strength_or_colour_needs_no_solution(variant, solutions):
    is_rgb = variant == RGB
    first, second = ([10.0, 10.0, 10.0], [3.0, 1.0, 8.0]) if is_rgb else (10.0, 30.0)
    made = lamp_scene(first, [0.0, 0.6, 0.1])
    mi.render(made, spp=1)
    assert solutions() == 2
    stronger = changed(made, "lamp.intensity", mi.Color3f(second) if is_rgb else mi.Float(second))
    assert solutions() == 2
    fresh = np.array(mi.render(lamp_scene(second, [0.0, 0.6, 0.1]), spp=16))
    assert solutions() == 4
    # The same samples, to the rounding of numbers with 24 bits.
    np.testing.assert_allclose(stronger, fresh, rtol=1e-3, atol=1e-4 * fresh.max())


def test_only_the_lamp_that_moves_is_solved_for_again(solutions):
    made = lamp_scene([10.0, 10.0, 10.0], [0.0, 0.6, 0.1])
    mi.render(made, spp=1)
    assert solutions() == 2
    moved = changed(made, "lamp.position", mi.Point3f(0.3, -0.8, 0.4))
    assert solutions() == 3
    fresh = np.array(mi.render(lamp_scene([10.0, 10.0, 10.0], [0.3, -0.8, 0.4]), spp=16))
    np.testing.assert_allclose(moved, fresh, rtol=1e-3, atol=1e-4 * fresh.max())
    # Dark lamps leave the light of the others.
    dark = changed(made, "lamp.intensity", mi.Color3f(0.0))
    assert solutions() == 5
    without = np.array(mi.render(lamp_scene([0.0, 0.0, 0.0], [0.3, -0.8, 0.4]), spp=16))
    np.testing.assert_allclose(dark, without, rtol=1e-3, atol=1e-4 * without.max())
    assert np.abs(changed(made, "sky.radiance", mi.Float(0.0))).max() == 0


def test_lamps_in_one_place_add_up(solutions):
    there = {name: {"type": "point", "position": [0.0, 0.6, 0.1], "intensity": {"type": "rgb", "value": color}}
             for name, color in (("one", [8.0, 1.0, 3.0]), ("other", [2.0, 9.0, 7.0]))}
    both = np.array(mi.render(scene(block(), there, max_depth=1, **COARSE), spp=4))
    assert solutions() == 1
    there = {"lamp": {"type": "point", "position": [0.0, 0.6, 0.1], "intensity": {"type": "rgb", "value": [10.0] * 3}}}
    # Emission alone, which has no noise but that of the pixels.
    alone = np.array(mi.render(scene(block(), there, max_depth=1, **COARSE), spp=4))
    np.testing.assert_allclose(both, alone, rtol=1e-3, atol=1e-4)


def test_scenes_in_other_units_are_solved_for():
    there, _ = lamp([0.0, 0.6, 0.1])
    first = np.array(mi.render(scene(block(), there, max_depth=2, **COARSE), spp=64))
    transform = mi.ScalarTransform4f()
    larger = block()
    larger["block"]["to_world"] = transform.translate([0, 0, 10]).scale([10, 5, 10])
    far, _ = lamp([0.0, 60.0, 10.0], watts=10.0 * 100**2)
    centimetres = {"type": "perspective", "fov": CAMERA["vertical_fov_deg"], "fov_axis": "y",
                   "to_world": transform.look_at([50, -70, 35], [0, 0, 10], [0, 0, 1]),
                   "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}}}
    made = mi.load_dict({"type": "scene", "integrator": {"type": "snow", "max_depth": 2, "unit_m": 0.01, **COARSE},
                         "sensor": centimetres, **larger, **far})
    np.testing.assert_allclose(np.array(mi.render(made, spp=64)).mean(), first.mean(), rtol=0.01)


def test_lamps_have_all_samples_of_emitters():
    there, _ = lamp([0.0, 0.6, 0.1])
    made = scene(block(), there)
    at = [made.pdf_emitter(number) for number in range(2)]
    assert max(np.ravel(one)[0] for one in at) > 0.999


def test_touching_blocks_of_one_body_are_one_block():
    transform = mi.ScalarTransform4f()
    there, _ = lamp([0.0, 0.6, 0.1])
    halves = {
        name: {"type": "cube", "to_world": transform.translate([x, 0, 0.1]).scale([0.05, 0.05, 0.1]),
               "bsdf": {"type": "snow_surface", "body": "wall"}, "emitter": {"type": "snow_light", "of": name}}
        for name, x in (("left", -0.05), ("right", 0.05))}
    whole = np.array(mi.render(scene(block(), there, max_depth=2), spp=64))
    parts = np.array(mi.render(scene(halves, there, max_depth=2), spp=64))
    # Vertices are in other places, and the joint has no thickness.
    assert parts.mean() == pytest.approx(whole.mean(), rel=0.02)


def test_integrators_and_scenes_may_be_combined():
    there, _ = lamp([0.0, 0.6, 0.1])
    first, second = scene(block(), there, max_depth=2, **COARSE), scene(block(), there, max_depth=2, **COARSE)
    integrator = mi.load_dict({"type": "snow", "max_depth": 2, **COARSE})
    expected = np.array(mi.render(first, spp=64)).mean()
    for made in (first, second, first):
        assert np.array(mi.render(made, integrator=integrator, spp=64)).mean() == pytest.approx(expected, rel=0.01)


def test_mirrored_rectangles_light_the_side_that_they_face():
    transform = mi.ScalarTransform4f()
    facing = transform.look_at([0.0, 0.6, 0.1], [0.0, 0.0, 0.1], [0, 0, 1]).scale(0.05)
    pictures = []
    for to_world, flip in ((facing, False), (facing.scale([-1, 1, 1]), False), (facing.rotate([0, 1, 0], 180), True)):
        area = {"type": "rectangle", "to_world": to_world, "flip_normals": flip,
                "emitter": {"type": "area", "radiance": 20.0}}
        pictures.append(np.array(mi.render(scene(block(), {"lamp": area}, max_depth=2, **COARSE), spp=64)).mean())
    assert pictures[1:] == pytest.approx([pictures[0]] * 2, rel=0.02)


def test_xml_scenes_have_snow():
    made = mi.load_string("""<scene version="3.0.0"><integrator type="snow"/>
        <sensor type="perspective"><transform name="to_world"><lookat origin="5,-7,3" target="0,0,0" up="0,0,1"/>
        </transform><film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film>
        </sensor><shape type="cube" id="block"><transform name="to_world"><scale value="0.1"/></transform>
        <bsdf type="snow_surface"><float name="grain_size_um" value="200"/></bsdf><emitter type="snow_light"/></shape>
        <emitter type="point"><point name="position" x="0" y="1" z="1"/></emitter></scene>""")
    assert np.array(mi.render(made, spp=1)).max() > 0


def test_shapes_need_no_ids(variant):
    """Two blocks in XML without ids, beside the same with ids."""
    def xml(*ids):
        shapes = "".join(f"""<shape type="cube" {name}><transform name="to_world"><scale value="0.1"/>
            <translate x="{x}"/></transform><bsdf type="snow_surface"/><emitter type="snow_light"/></shape>"""
            for name, x in zip(ids, (-0.15, 0.15)))
        return mi.load_string(f"""<scene version="3.0.0"><integrator type="snow"><float name="step_mm" value="20"/>
            <float name="field_step_mm" value="10"/></integrator>
            <sensor type="perspective"><transform name="to_world"><lookat origin="0.5,-0.7,0.3" target="0,0,0"
            up="0,0,1"/></transform><film type="hdrfilm"><integer name="width" value="16"/>
            <integer name="height" value="16"/></film></sensor>{shapes}
            <emitter type="point"><point name="position" x="0" y="1" z="1"/></emitter></scene>""")
    named, nameless = (np.array(mi.render(xml(*ids), spp=16)) for ids in (('id="a"', 'id="b"'), ("", "")))
    assert named.max() > 0
    np.testing.assert_allclose(nameless, named, rtol=1e-4, atol=1e-6)


def test_arrays_make_shapes(tmp_path):
    vertices, triangles = torus(48, 24)
    there, _ = lamp([0.3, -0.8, 0.4])
    by_file = np.array(mi.render(scene(as_shape(vertices, triangles, tmp_path), there, max_depth=2, **COARSE), spp=64))
    made = snowblue.mitsuba.snow_mesh(vertices, triangles.tolist())
    by_arrays = np.array(mi.render(scene({"torus": made}, there, max_depth=2, **COARSE), spp=64))
    mask = inside(by_file) & inside(by_arrays)
    # The file has no normals: its triangles are flat.
    np.testing.assert_allclose(by_arrays[mask].mean(axis=0), by_file[mask].mean(axis=0), rtol=0.02)
    with pytest.raises(ValueError, match=r"vertices of a mesh have the shape \(3,\), but must have \(n, 3\)"):
        snowblue.mitsuba.snow_mesh([0.0, 1.0, 2.0], triangles)
    with pytest.raises(ValueError, match="triangles of a mesh name vertices outside"):
        snowblue.mitsuba.snow_mesh(vertices[:5], triangles)


def test_the_entry_point_brings_the_plug_ins():
    """As Mitsuba 3.10 does: it imports the module of each entry point, and again after each change of the variant."""
    done = subprocess.run([sys.executable, "-W", "error", "-c", textwrap.dedent("""
        import importlib, importlib.metadata
        import mitsuba as mi

        mi.set_variant("llvm_ad_mono")
        [entry] = importlib.metadata.entry_points(group="mitsuba", name="snowblue")
        module = importlib.import_module(entry.value)
        for kind in ("snow_surface", "snow_light", "snow"):
            try:
                mi.load_dict({"type": kind})
                raise SystemExit(f"{kind} is not refused")
            except RuntimeError as error:
                assert "has no snow; there are scalar_rgb, llvm_ad_rgb, " in str(error), error
        for variant in ("llvm_ad_rgb", "scalar_rgb", "llvm_ad_spectral"):
            mi.set_variant(variant)
            importlib.reload(module)
            for kind in ("snow_surface", "snow_light"):
                mi.load_dict({"type": kind})
        """)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def assert_refused(words, shapes, lights, **integrator):
    with pytest.raises((ValueError, RuntimeError)) as caught:
        mi.render(scene(shapes, lights, **integrator), spp=1)
    messages, error = [], caught.value
    while error is not None:
        messages.append(str(error))
        error = error.__cause__
    assert re.search(words, "\n".join(messages)), messages


def test_bad_scenes_are_named(tmp_path):
    there, _ = lamp([0.0, 0.6, 0.1])
    vertices, triangles = torus(24, 12)

    def refused(words, shapes, lights=there, **integrator):
        assert_refused(words, shapes, lights, **integrator)

    refused("shape 'torus'.*open", as_shape(vertices, triangles[:-1], tmp_path))
    refused("no emitter to light it", block(), {})
    ball = {"type": "sphere", "bsdf": {"type": "snow_surface"}, "emitter": {"type": "snow_light"}}
    refused("'ball' is a Sphere, but snow must be a mesh", {"ball": ball})
    dark = block()
    del dark["block"]["emitter"]
    refused("not the emitter 'snow_light'", dark)
    refused("density", block(density_kg_m3=2000))
    refused("unit_m is -1", block(), unit_m=-1.0)
    refused("unreferenced property|step", block(), step=5.0)
    plain = block()
    plain["block"]["bsdf"] = {"type": "diffuse"}
    refused("'snow_light', but not the bsdf 'snow_surface'", {**block(), "plain": {**plain["block"], "emitter": {
        "type": "snow_light", "of": "plain"}}})
    refused("one integrator in it", block(), max_depth=3, inner={"type": "direct"})
    disk = {"lamp": {"type": "disk", "emitter": {"type": "area"}}}
    refused("emitter of shape 'lamp' is a AreaLight on a Disk, which cannot light snow", block(), disk)
    image = {"type": "bitmap", "bitmap": mi.Bitmap(np.ones((4, 4, 3), dtype=np.float32)), "raw": True}
    for lamp_of in ({"type": "rectangle", "emitter": {"type": "area", "radiance": image}},
                    {"type": "sphere", "emitter": {"type": "area", "radiance": image}},
                    {"type": "spot", "texture": image}):
        refused("'lamp' is a .* with a texture, which cannot light snow", block(), {"lamp": lamp_of})
    nameless = mi.load_string("""<scene version="3.0.0"><integrator type="snow"/><sensor type="perspective"/>
        <shape type="sphere"><bsdf type="snow_surface"/><emitter type="snow_light"/></shape>
        <emitter type="point"/></scene>""")
    with pytest.raises(RuntimeError) as caught:
        mi.render(nameless, spp=1)
    assert "shape number 1 without an id is a Sphere" in str(caught.value.__cause__)


def test_snow_that_is_not_solved_for_is_nan():
    """In a process of its own: compiled variants evaluate the plug-ins of all scenes that exist."""
    done = subprocess.run([sys.executable, "-c", textwrap.dedent("""
        import warnings
        import mitsuba as mi
        import numpy as np
        mi.set_variant("llvm_ad_rgb")
        import snowblue.mitsuba

        scene = mi.load_dict({
            "type": "scene", "integrator": {"type": "path"},
            "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 8, "height": 8},
                       "to_world": mi.ScalarTransform4f().look_at([5, -7, 3], [0, 0, 0], [0, 0, 1])},
            "block": {"type": "cube", "bsdf": {"type": "snow_surface"}, "emitter": {"type": "snow_light"}},
            "lamp": {"type": "point", "position": [0, -3, 3]}})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            assert np.isnan(np.array(mi.render(scene, spp=1))).any()
        assert any("only the integrator 'snow' renders it" in str(one.message) for one in caught)
        """)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_lamp_that_fails_changes_nothing(monkeypatch):
    made = lamp_scene([10.0, 10.0, 10.0], [0.0, 0.6, 0.1])
    [emitter] = [one for one in made.emitters() if type(one).__name__ == "SnowLight"]
    bake, calls = snowblue.mitsuba._baked, []

    def failing(*arguments):
        calls.append(arguments)
        if len(calls) == 2:
            raise ValueError("no light")
        return bake(*arguments)

    monkeypatch.setattr(snowblue.mitsuba, "_baked", failing)
    with pytest.raises((ValueError, RuntimeError)):
        mi.render(made, spp=1)
    assert len(calls) == 2 and emitter.solution is None
    monkeypatch.undo()
    fresh = np.array(mi.render(lamp_scene([10.0, 10.0, 10.0], [0.0, 0.6, 0.1]), spp=4))
    np.testing.assert_allclose(np.array(mi.render(made, spp=4)), fresh, rtol=1e-3, atol=1e-4 * fresh.max())


def test_snow_may_lie_anywhere():
    slab = block()
    slab["block"]["to_world"] = mi.ScalarTransform4f().scale([3, 3, 0.25])
    sky = {"sky": {"type": "constant"}}
    picture = np.array(mi.render(scene(slab, sky, max_depth=2, step_mm=200, field_step_mm=40), spp=4))
    assert np.isfinite(picture).all() and picture.max() > 0.5


@pytest.mark.parametrize("variant", [RGB, SPECTRAL, "scalar_rgb"])
def test_snow_moves_as_any_shape(variant, solutions):
    mi.set_variant(variant)
    try:
        samples = 4 if variant == "scalar_rgb" else 16
        light = {"lamp": {"type": "point", "position": [0.0, 0.6, 0.1], "intensity": 10.0}}

        def picture(made):
            # Emission alone, which has no noise but that of the pixels.
            return np.array(mi.render(made, spp=samples))

        made, moved = scene(block(), light, max_depth=1, **COARSE), block()
        moved["block"]["to_world"] = mi.ScalarTransform4f().translate([0, 0.2, 0.1]).scale([0.1, 0.05, 0.1])
        fresh = picture(scene(moved, light, max_depth=1, **COARSE))
        parameters = mi.traverse(made)
        names = [name for name in parameters.keys() if name.startswith("block.")]
        own = {name: np.array(parameters[name]) for name in names}
        kind, positions = type(parameters["block.vertex_positions"]), own["block.vertex_positions"]
        shifted = (positions.reshape(-1, 3) + np.float32([0, 0.2, 0])).ravel()
        first = picture(made)
        for round in range(20):
            for values, expected in ((positions, first), (shifted, fresh)):
                parameters["block.vertex_positions"] = kind(values)
                parameters.update()
                if round in (0, 10, 19):
                    there = picture(made)
                    np.testing.assert_allclose(there, expected, rtol=1e-3, atol=1e-4 * expected.max())
            parameters["block.vertex_positions"] = kind(positions)
            parameters.update()
            for name in names:
                # Mitsuba computes normals of positions that are set.
                np.testing.assert_allclose(np.array(parameters[name]), own[name], atol=1e-6 * ("normals" in name))
    finally:
        mi.set_variant(RGB)
    assert abs(fresh - first).max() > 0.1 * first.max()
    # Of each scene at first, and after each change that was rendered but the first, which changes nothing.
    assert solutions() == 2 + 5


def test_snow_keeps_normals_of_its_own():
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    shape = snowblue.mitsuba.snow_mesh(ball.vertices, ball.faces)
    parameters = mi.traverse(shape)
    slanted = np.float32([[0.6, 0.0, 0.8]] * len(ball.vertices)).ravel()
    parameters["vertex_normals"] = mi.Float(slanted)
    parameters.update()
    mi.render(scene({"ball": shape}, lamp([0.0, 0.6, 0.1])[0], **COARSE), spp=1)
    np.testing.assert_array_equal(np.array(parameters["vertex_normals"]), slanted)
    np.testing.assert_array_equal(np.array(parameters["vertex_positions"]), np.float32(ball.vertices).ravel())


@pytest.mark.parametrize("variant", [RGB, SPECTRAL, "scalar_rgb"])
def test_mirrors_give_snow_as_much_as_a_diffuse_surface(variant):
    mi.set_variant(variant)
    try:
        def picture(bsdf):
            transform = mi.ScalarTransform4f()
            floor = {"floor": {"type": "rectangle", "to_world": transform.translate([0, 0, -0.05]), "bsdf": bsdf}}
            light = {"lamp": {"type": "point", "position": [0.0, 0.6, 0.1], "intensity": 10.0}}
            # Emission alone, which has no noise but that of the pixels.
            return np.array(mi.render(scene({**block(), **floor}, light, max_depth=1, **COARSE), spp=4))[..., :3]

        diffuse, black = (picture({"type": "diffuse", "reflectance": value}) for value in (0.6, 0.0))
        for mirror in ({"type": "conductor", "material": "none", "specular_reflectance": 0.6},
                       {"type": "roughconductor", "material": "none", "alpha": 0.3, "specular_reflectance": 0.6}):
            with pytest.warns(UserWarning, match="Conductor gives light to snow as a diffuse surface with its"):
                there = picture(mirror)
            # At a roughness of 0.3, single scattering between its facets loses 2 %.
            np.testing.assert_allclose(there, diffuse, rtol=0.03, atol=1e-3 * diffuse.max())
        assert diffuse.mean() > 1.05 * black.mean()
    finally:
        mi.set_variant(RGB)


def test_shapes_that_are_alike_have_one_warning_and_one_material(monkeypatch):
    transform = mi.ScalarTransform4f()
    places = [transform.translate([0.03 * number, 0.4, 0.1]).scale(0.01) for number in range(10)]
    group = {"group": {"type": "shapegroup", "cube": {"type": "cube", "bsdf": {"type": "conductor"}}}}
    instances = {f"instance {number}": {"type": "instance", "to_world": place, "group": {"type": "ref", "id": "group"}}
                 for number, place in enumerate(places)}
    conductor = mi.load_dict({"type": "conductor"})
    cubes = {f"cube {number}": {"type": "cube", "to_world": transform.translate([0, 0, 1]) @ place, "bsdf": conductor}
             for number, place in enumerate(places)}
    surface, materials = snowblue.mitsuba._surface, []
    monkeypatch.setattr(snowblue.mitsuba, "_surface", lambda *of: materials.append(of[1]) or surface(*of))
    there, _ = lamp([0.0, 0.6, 0.1])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mi.render(scene({**block(), **group, **instances, **cubes}, there, **COARSE), spp=1)
    assert [str(one.message) for one in caught] == [
        "a SmoothConductor gives light to snow as a diffuse surface with its reflectance at normal incidence",
        "10 shapes of the kind Instance cast no shadow on snow and give it no light",
    ]
    assert len(materials) == 1


def test_a_shape_may_be_in_two_scenes(solutions):
    ring = trimesh.creation.torus(0.15, 0.06)
    shape = snowblue.mitsuba.snow_mesh(ring.vertices, ring.faces)
    lamps = [{"lamp": {"type": "point", "position": [x, 0.5, 0.4], "intensity": 1.0}} for x in (-0.3, 0.3)]
    first, second = [scene({"ring": shape}, lamp, **COARSE) for lamp in lamps]
    pictures = [np.array(mi.render(made, spp=4)) for made in (first, second, first)]
    assert solutions() == 3
    # The same samples, to the rounding of numbers with 24 bits.
    np.testing.assert_allclose(pictures[0], pictures[2], rtol=1e-3, atol=1e-4 * pictures[0].max())
    assert abs(pictures[0] - pictures[1]).max() > 0.1 * pictures[0].max()
