"""PCASnow in Mitsuba 3, beside our own pictures of the same scenes."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
import trimesh
from test_mitsuba import (
    BACKEND,
    BOX,
    CAMERA,
    COARSE,
    LUMINANCE,
    RGB,
    SIZE,
    SNOW,
    as_shape,
    assert_agree,
    assert_refused,
    block,
    inside,
    lamp,
    ours,
    scene,
    theirs,
    torus,
    variant,
)

import snowblue.mitsuba
from snowblue._renderers import _bands, _rgb

__all__ = ["variant"]
pytestmark = pytest.mark.skipif(BACKEND == "cuda", reason="variants of CUDA do not have PCASnow")
MODES = ["brightest", "normal", "light", "view"]
# Lamps by their samples and the first surface only: our own pictures without bounces have no light from snow to snow.
DIRECT = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}
# The direction is oblique to all faces.
SUN = {"type": "directional", "direction": [0.3, -1.0, -0.2]}


def sun(watts=20.0):
    """A directional lamp there and here."""
    there = {"lamp": {**SUN, "irradiance": {"type": "d65", "scale": watts}}}
    return there, {**SUN, "illuminant": "D65", "irradiance_w_m2": watts}


def pictures(shapes, objects, lamps, mode, samples, mean=256):
    there, here = lamps
    made = scene(shapes, there, method="pcasnow", path_mode=mode, inner=DIRECT)
    return theirs(made, samples=samples), ours(objects, here, samples=mean, integrator="pcasnow", path=mode)


def assert_same(there, here, **tolerances):
    """The same light, and the same shadows, but for pixels at their edges."""
    assert_agree(there, here, **tolerances)
    shadows = [picture @ LUMINANCE > 0 for picture, _ in (there, here)]
    assert (shadows[0] != shadows[1]).mean() < 0.02


def samples_of(variant):
    # Four wavelengths a sample are noisy.
    return 32 if variant == RGB else 512


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("lamps", [lamp([0.4, 0.5, 0.5]), sun()], ids=["point", "directional"])
def test_a_block_is_that_of_our_own_pictures(variant, lamps, mode):
    assert_same(*pictures(block(), [BOX], lamps, mode, samples_of(variant)))


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("lamps", [lamp([0.0, 0.6, 0.1]), sun()], ids=["point", "directional"])
def test_a_mesh_with_a_hole_is_that_of_our_own_pictures(variant, lamps, mode, tmp_path):
    mesh = torus()
    shapes = as_shape(*mesh, tmp_path)
    # The thin rim lets most light through and needs more samples for the mean to be within a third of the tolerance.
    samples = 128 if variant == RGB else 512
    there, here = pictures(shapes, [{"mesh": mesh, "material": "snow"}], lamps, mode, samples, mean=1024)
    assert_same(there, here, allowed=0.05)


def chords(made, samples):
    """Lengths in a solid along random rays through each pixel, and numbers of crossings, as Mitsuba finds them."""
    pixel = dr.arange(mi.UInt32, SIZE * SIZE * samples) // samples
    random = np.random.default_rng(1).random((2, dr.width(pixel)), dtype=np.float32)
    place = (mi.Point2f(pixel % SIZE, pixel // SIZE) + mi.Point2f(random)) / SIZE
    [sensor] = made.sensors()
    line, _weight = sensor.sample_ray(0, 0, place, 0)
    active, distance = mi.Bool(True), mi.Float(0)
    length, inside, crossings = mi.Float(0), mi.Int32(0), mi.UInt32(0)
    while dr.any(active):
        # Mitsuba's own step from a surface is a tenth of a millimetre long, along the normal.
        hit = made.ray_intersect(mi.Ray3f(line(distance), line.d), active)
        active &= hit.is_valid()
        distance += dr.select(active, hit.t, 0)
        enters = dr.select(active, dr.select(dr.dot(hit.n, line.d) < 0, 1, -1), 0)
        length -= enters * distance
        inside += enters
        crossings += dr.select(active, 1, 0)
        distance += 2e-6
    # Lines that graze an edge may miss one of two triangles.
    is_whole = np.array(inside) == 0
    assert is_whole.mean() > 1 - 1e-4
    lengths = np.where(is_whole, np.array(length), np.nan)
    return (values.reshape(SIZE, SIZE, samples) for values in (lengths, np.array(crossings)))


def test_the_thickness_of_a_hollow_ring_is_that_along_the_rays_of_mitsuba(tmp_path):
    samples = 256
    outer, inner = (trimesh.creation.torus(0.07, tube) for tube in (0.03, 0.012))
    inner.invert()
    ring = trimesh.util.concatenate([outer, inner]).apply_translation(CAMERA["look_at"])
    mesh = ring.vertices, ring.faces
    there, here = lamp([0.0, 0.6, 0.1])
    lengths, crossings = chords(scene(as_shape(*mesh, tmp_path), there), samples)
    assert (crossings == 8).any()
    thickness = snowblue.Scene(
        camera=CAMERA, film={"width": SIZE, "height": SIZE}, integrator={"max_bounces": 0, "pcasnow": {"path": "view"}},
        material=SNOW, light=[here], object=[{"mesh": mesh, "material": "snow"}],
    ).render(integrator="pcasnow", samples_per_pixel=samples, aovs=["thickness"]).thickness.values
    mask = (crossings > 0).all(axis=-1)
    assert mask.sum() > 200
    # The standard error of the difference of two means of as many lines. One of 300 pixels is beyond 5 of them in one
    # of 6,000 tests; the mean of all, which is known to 0.07 %, is beyond 4 in one of 16,000.
    error = np.nanstd(lengths[mask], axis=-1) * np.sqrt(2 / samples)
    difference = thickness[mask] - np.nanmean(lengths[mask], axis=-1)
    assert (np.abs(difference) < 5 * error).all()
    assert np.abs(difference.sum()) < 4 * np.sqrt((error**2).sum())


def front(made):
    """The light of the face of the block that fills the greater part of the picture."""
    picture = np.array(mi.render(made, spp=16))[..., :3]
    return np.median(picture[inside(np.abs(picture))], axis=0)


@pytest.mark.parametrize("color", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
def test_bands_of_a_lamp_are_those_of_the_table(color):
    """Light that arrives along the normal of a face goes through 10 cm, whatever the path."""
    lamps = {"lamp": {"type": "directional", "direction": [0, -1, 0], "irradiance": {"type": "rgb", "value": color}}}
    curve = snowblue.Database.embedded().look_up(thickness_cm=10.0).transmittance.values.ravel()
    expected = _rgb(curve * _bands(color))[0] / np.pi
    for mode in ("brightest", "normal", "light"):
        made = scene(block(), lamps, method="pcasnow", path_mode=mode, inner=DIRECT)
        # The white of `_rgb` differs from 1 by 0.3 % of each colour.
        np.testing.assert_allclose(front(made), expected, rtol=0.005, atol=0.003 * expected.max())


@pytest.mark.parametrize("kind", ["sphere", "rectangle", "constant", "inside"])
@pytest.mark.parametrize("mode", MODES)
def test_other_lamps_are_those_of_our_own_pictures(kind, mode):
    transform = mi.ScalarTransform4f()
    d65, position, target = {"type": "d65", "scale": 20.0}, [0.0, 0.3, 0.1], [0.0, 0.0, 0.1]
    area = {"emitter": {"type": "area", "radiance": d65}}
    facing = transform.look_at(position, target, [0, 0, 1])
    unseen = {"illuminant": "D65", "radiance_w_m2_sr": 20.0, "visible": False}
    there, here = {
        "sphere": ({"type": "sphere", "to_world": transform.translate(position).scale(0.1), **area},
                   {"type": "sphere", "position": position, "radius": 0.1, **unseen}),
        "rectangle": ({"type": "rectangle", "to_world": facing.scale(0.1), **area},
                      {"type": "rectangle", "position": position, "look_at": target, "size": [0.2, 0.2], **unseen}),
        "constant": ({"type": "constant", "radiance": d65}, unseen),
        "inside": (lamp([0.02, 0.01, 0.1], 20.0)[0]["lamp"], lamp([0.02, 0.01, 0.1], 20.0)[1]),
    }[kind]
    if kind == "inside" and mode in ("normal", "view"):
        made = scene(block(), {"lamp": there}, method="pcasnow", path_mode=mode, inner=DIRECT)
        assert np.array(mi.render(made, spp=4)).max() == 0
        return
    there, here = pictures(block(), [BOX], ({"lamp": there}, here), mode, samples=256, mean=1024)
    # Where the rectangle shines on the upper edge, few samples go through thin snow.
    assert_agree(there, here, allowed=0.05)


@pytest.mark.parametrize("mode", ["brightest", "view"])
@pytest.mark.parametrize("case", ["touching", "overlapping", "behind each other", "two solids"])
def test_shapes_of_one_body_are_one_solid(case, mode):
    (x, width), (y, depth) = {
        "touching": ((0.05, 0.05), (0.0, 0.05)), "overlapping": ((0.04, 0.06), (0.0, 0.05)),
        "behind each other": ((0.0, 0.1), (0.08, 0.03)), "two solids": ((0.0, 0.1), (0.08, 0.03)),
    }[case]
    transform = mi.ScalarTransform4f()
    body = {} if case == "two solids" else {"body": "wall"}
    shapes, objects = {}, []
    for name, sign in (("one", -1), ("other", 1)):
        center = [sign * x, sign * y, 0.1]
        shapes[name] = {"type": "cube", "to_world": transform.translate(center).scale([width, depth, 0.1]),
                        "bsdf": {"type": "snow_surface", **body}, "emitter": {"type": "snow_light", "of": name}}
        objects.append({"shape": "box", "size": [2 * width, 2 * depth, 0.2], "position": center, "material": "snow",
                        **body})
    there, here = pictures(shapes, objects, lamp([0.07, 0.6, 0.3]), mode, samples=64)
    assert_same(there, here, allowed=0.05)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("parts", [1, 2])
def test_other_surfaces_shadow_where_light_enters(parts, mode):
    transform = mi.ScalarTransform4f()
    shapes = {"card": {"type": "cube", "to_world": transform.translate([0.05, 0.2, 0.15]).scale([0.05, 0.01, 0.05]),
                       "bsdf": {"type": "diffuse", "reflectance": 0.5}}}
    objects = [{"shape": "box", "size": [0.1, 0.02, 0.1], "position": [0.05, 0.2, 0.15], "material": "floor"}]
    for part in range(parts):
        width = 0.1 / parts
        center = [(2 * part + 1) * width - 0.1, 0, 0.1]
        shapes[f"part {part}"] = {
            "type": "cube", "to_world": transform.translate(center).scale([width, 0.05, 0.1]),
            "bsdf": {"type": "snow_surface", "body": "wall"}, "emitter": {"type": "snow_light", "of": f"{part}"}}
        objects.append({"shape": "box", "size": [2 * width, 0.1, 0.2], "position": center, "material": "snow",
                        "body": "wall"})
    assert_same(*pictures(shapes, objects, lamp([0.05, 0.6, 0.1]), mode, samples=64), allowed=0.05)


def test_light_from_snow_reaches_other_surfaces():
    transform = mi.ScalarTransform4f()
    floor = {"floor": {"type": "rectangle", "to_world": transform.scale(1.0),
                       "bsdf": {"type": "diffuse", "reflectance": 0.5}}}
    there, here = lamp([0.3, 0.5, 0.4])
    made = scene({**block(), **floor}, there, method="pcasnow", max_depth=12)
    floor_here = {"shape": "box", "size": [2, 2, 0.1], "position": [0, 0, -0.05], "material": "floor"}
    assert_agree(theirs(made, samples=128), ours([BOX, floor_here], here, bounces=11, integrator="pcasnow"))


def test_scalar_variants_agree_with_compiled_ones():
    there, _ = lamp([0.4, 0.5, 0.5])
    compiled = np.array(mi.render(scene(block(), there, method="pcasnow", max_depth=2), spp=64))
    mi.set_variant("scalar_rgb")
    try:
        scalar = np.array(mi.render(scene(block(), there, method="pcasnow", max_depth=2), spp=2))
    finally:
        mi.set_variant(RGB)
    mask = inside(compiled) & inside(scalar)
    assert mask.sum() > 200
    assert scalar[mask].mean() == pytest.approx(compiled[mask].mean(), rel=0.01)


def test_methods_and_path_modes_may_change_between_renderings():
    there, _ = lamp([0.4, 0.5, 0.5])
    made = scene(block(), there, max_depth=2, **COARSE)
    ways = [COARSE, {"method": "pcasnow"}, {"method": "pcasnow", "path_mode": "view"}, COARSE | {"step_mm": 10.0}]
    integrators = [mi.load_dict({"type": "snow", "max_depth": 2, **way}) for way in ways]
    first, second = ([np.array(mi.render(made, integrator=one, spp=16)).mean() for one in integrators] for _ in "ab")
    # The mesh of the light field has other triangles.
    assert second == pytest.approx(first, rel=1e-3)
    assert np.isfinite(first).all() and len(set(first)) == 4


def test_lengths_are_in_units_of_the_scene():
    lamps = {"lamp": {"type": "directional", "direction": [0, -1, 0]}}
    for unit_m in (2.0, 1.0, 0.01):
        curve = snowblue.Database.embedded().look_up(thickness_cm=10.0 * unit_m).transmittance.values.ravel()
        seen = front(scene(block(), lamps, method="pcasnow", inner=DIRECT, unit_m=unit_m))
        np.testing.assert_allclose(seen, _rgb(curve)[0] / np.pi, rtol=0.006)


def test_a_table_may_be_given(tmp_path):
    axes = dict(grain_size_um=[800], facetness=[0.3], density_kg_m3=[300], thickness_cm=[1, 5, 15, 50],
                angle_deg=[0, 60], tally_rays=1 << 14)
    path = tmp_path / "coarse.nc"
    full = snowblue.Database.build(**axes)
    full.compress(components=3).write(path)
    there, _ = lamp([0.0, 0.6, 0.1])
    solved, held = (
        np.array(mi.render(scene(block(grain_size_um=800.0), there, method="pcasnow", max_depth=2, **table), spp=16))
        for table in ({}, {"database": str(path)}))
    # The few depths and rays of the table differ from the engine by some percent.
    assert solved.mean() == pytest.approx(held.mean(), rel=0.05)
    full.write(path)
    assert_refused("database is a full table", block(), there, method="pcasnow", database=str(path))


@pytest.mark.parametrize("method", ["light_field", "pcasnow"])
def test_any_snow_is_rendered(method):
    there, _ = lamp([0.0, 0.6, 0.1])
    kinds = [{"grain_size_um": 1500.0, "water_saturation": 0.1}, {}, {"snow": "fresh"}, {"black_carbon_ng_g": 500.0}]
    cells = COARSE if method == "light_field" else {}
    light = [np.array(mi.render(scene(block(**kind), there, method=method, max_depth=2, **cells), spp=16)).mean()
             for kind in kinds]
    # Coarse and wet snow transmits more light than usual, dirty snow less; light new snow has fewer, finer grains.
    assert light[0] > 1.1 * light[1] and light[3] < 0.8 * light[1] and light[2] > 0


@pytest.mark.parametrize(("integrator", "words"), [
    ({"method": "field"}, "method is 'field', but must be one of light_field, pcasnow"),
    ({"method": "pcasnow", "path_mode": "straight"}, "path_mode is 'straight', but must be one of brightest, normal"),
    ({"method": "pcasnow", "unit_m": 0.0}, "unit_m is 0.0, but must be finite and above 0"),
    ({"method": "pcasnow", "step_mm": 5.0}, "step_mm belongs to the method light_field, but the method is pcasnow"),
    ({"path_mode": "view"}, "path_mode belongs to the method pcasnow, but the method is light_field"),
    ({"step_mm": -1.0}, "step_mm is -1.0, but must be finite and above 0"),
    ({"gather_depth": -1}, "gather_depth is -1, but must be at least 0"),
    ({"unit_m": "1"}, "unit_m is '1', but must be a number"),
    ({"method": "pcasnow", "database": "none.nc"}, "none.nc: there is no such file"),
])
def test_bad_values_are_named(integrator, words):
    assert_refused(words, block(), lamp([0.0, 0.6, 0.1])[0], **integrator)


def test_bad_scenes_are_named(tmp_path):
    there, _ = lamp([0.0, 0.6, 0.1])
    vertices, triangles = torus(24, 12)
    words = "shape 'torus' is open: 3 of its edges.*snowblue repair"
    assert_refused(words, as_shape(vertices, triangles[:-1], tmp_path), there, method="pcasnow")
    assert_refused("density is 2000 kg/m³, but must lie in 10–900", block(density_kg_m3=2000), there, method="pcasnow")
    assert_refused("no emitter to light it", block(), {}, method="pcasnow")
    # An error leaves nothing behind.
    assert np.array(mi.render(scene(block(), there, method="pcasnow"), spp=1)).shape == (SIZE, SIZE, 3)


def test_variants_of_cuda_refuse_it(monkeypatch):
    """Without a graphics card such a variant cannot be chosen."""
    props = mi.Properties()
    props["method"] = "pcasnow"
    monkeypatch.setattr(snowblue.mitsuba.mi, "variant", lambda: "cuda_ad_rgb")
    with pytest.raises(ValueError, match="cuda_ad_rgb has no method pcasnow, .* use scalar_rgb, "):
        snowblue.mitsuba._method(props)
    del props["method"]
    snowblue.mitsuba._method(props)
