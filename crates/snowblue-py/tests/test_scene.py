"""Scenes: pictures and baked light fields."""

import os
import subprocess

import numpy as np
import OpenEXR
import pytest
import trimesh

import snowblue

CAMERA = {"position": [0.6, -0.9, 0.5], "look_at": [0, 0, 0.1], "vertical_fov_deg": 30}
SNOW = {"snow": {"type": "snow", "grain_size_um": 400, "facetness": 0.3, "density_kg_m3": 300}}
LAMP = {"type": "point", "position": [-0.3, 0.8, 0.4], "illuminant": "D65", "radiant_intensity_w_sr": 10}
FILM = {"width": 24, "height": 18, "exposure": -1.0}

CORNERS = 0.1 * np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) + [0, 0, 0.1]
SIDES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TRIANGLES = np.array([corners for a, b, c, d in SIDES for corners in ((a, b, c), (a, c, d))])


def block(**other):
    return snowblue.Scene(
        camera=CAMERA, film=FILM, material=SNOW, light=[LAMP],
        object=[{"shape": "box", "size": [0.2, 0.2, 0.2], "position": [0, 0, 0.1], "material": "snow"}], **other)


def test_a_scene_file_renders_as_by_the_command(repository, tmp_path):
    path = repository / "scenes" / "block_30cm.toml"
    ours = snowblue.Scene.open(path).render(
        width=32, height=24, samples_per_pixel=4, integrator="hybrid", output=tmp_path / "ours.exr")
    theirs = tmp_path / "theirs.exr"
    subprocess.run([os.environ["SNOWBLUE"], "render", str(path), "--width", "32", "--height", "24", "--spp", "4",
                    "--quiet", "-o", str(theirs)], check=True)
    with OpenEXR.File(str(theirs), separate_channels=True) as image:
        rgb = np.stack([image.channels()[name].pixels for name in "RGB"], axis=-1)
    np.testing.assert_array_equal(ours.rgb.values, rgb)
    with OpenEXR.File(str(tmp_path / "ours.exr"), separate_channels=True) as image:
        np.testing.assert_array_equal(np.stack([image.channels()[name].pixels for name in "RGB"], axis=-1), rgb)


def test_a_mesh_of_arrays_is_a_box():
    mesh = snowblue.Scene(camera=CAMERA, film=FILM, material=SNOW, light=[LAMP],
                          object=[{"mesh": (CORNERS, TRIANGLES), "smooth": False, "material": "snow"}])
    box = block()
    for integrator in ("pcasnow", "diffusion"):
        ours, theirs = (one.render(integrator=integrator, samples_per_pixel=16).rgb for one in (mesh, box))
        assert ours.sum().item() == pytest.approx(theirs.sum().item(), rel=0.01), integrator


def test_pictures_have_their_aovs_and_a_display(tmp_path):
    picture = block().render(
        integrator="hybrid", samples_per_pixel=4, aovs=["spectrum", "variance", "normal", "thickness"],
        output=tmp_path / "block.png")
    assert picture.display.dtype == np.uint8 and picture.display.shape == (18, 24, 3)
    assert picture.spectrum.dims == ("y", "x", "wavelength") and picture.normal.axis.values.tolist() == ["x", "y", "z"]
    # The face towards the camera, in the middle of the picture.
    middle = picture.normal.isel(y=9, x=12)
    assert middle.sel(axis="y") < -0.9 or middle.sel(axis="x") > 0.9
    assert 0 < picture.thickness.max() < 0.35
    assert picture.y[0] > picture.y[-1], "the first row is the upper one"
    assert (tmp_path / "block.png").read_bytes().startswith(b"\x89PNG")
    picture.display.plot.imshow()


def test_pictures_for_compositing_have_alpha_depth_and_position():
    picture = block(environment={"radiance_w_m2_sr": 1}).render(
        integrator="pcasnow", samples_per_pixel=4, aovs=["alpha", "depth", "position"])
    covered, sky = picture.alpha == 1, picture.alpha == 0
    assert covered.any() and sky.any()
    assert (picture.rgb.where(sky, 0) == 0).all() and (picture.depth.where(sky, 1e10) == np.float32(1e10)).all()
    # The block is a cube of 0.2 m on the plane z = 0, and the camera looks at its middle from 1.15 m.
    assert (abs(picture.position.where(covered, 0)).max(["y", "x"]).values < [0.1001, 0.1001, 0.2001]).all()
    assert 1.0 < picture.depth.isel(y=9, x=12) < 1.15 and picture.depth.units == "m"


def test_a_tone_curve_changes_the_display_alone():
    few = {"integrator": "diffusion", "samples_per_pixel": 4, "exposure": 4.0}
    none, filmic, agx = (block().render(tone=tone, **few) for tone in ("none", "filmic", "agx"))
    np.testing.assert_array_equal(none.rgb.values, filmic.rgb.values)
    assert none.display.max() == 255 and filmic.display.values.sum() < none.display.values.sum()
    assert agx.display.values.sum() < filmic.display.values.sum()
    np.testing.assert_array_equal(block().render(**few).display.values, filmic.display.values)
    assert 0 < filmic.snow.mean() < 1
    with pytest.raises(ValueError, match="tone curve is `hable`, but must be one of filmic, agx, none"):
        block().render(tone="hable", **few)


def test_automatic_exposure_shows_snow_as_white():
    scene = block(environment={"radiance_w_m2_sr": 100}).with_(light=[])
    picture = scene.with_(film={"width": 24, "height": 18}).render(integrator="diffusion", samples_per_pixel=16)
    snow = picture.display.values[picture.snow.values == 1].max(axis=-1)
    # The 90th percentile is displayed at 0.8.
    assert abs(int(np.percentile(snow, 90)) - 231) <= 2


def test_the_white_of_a_temperature():
    few = {"integrator": "diffusion", "samples_per_pixel": 4}
    of = {white: block().with_(film=FILM | {"white": white}).render(**few).rgb for white in ("D65", 6504, "2856K", "A")}
    np.testing.assert_allclose(of[6504], of["D65"], rtol=5e-3, atol=1e-4)
    np.testing.assert_allclose(of["2856K"], of["A"], rtol=5e-3, atol=1e-3)
    with pytest.raises(ValueError, match="white is 500 K, but must lie in 2000–25000 K"):
        block().with_(film=FILM | {"white": 500})


def test_snow_beyond_the_table_is_rendered_and_its_curves_are_solved_for():
    wet = {"snow": {"type": "snow", "snow": "melt-forms", "water_saturation": 0.1,
                    "impurities_ng_g": {"black-carbon": 50}}}
    scene = block().with_(material=wet)
    few = {"samples_per_pixel": 1, "width": 8, "height": 6}
    solved, field = (scene.render(integrator=integrator, **few) for integrator in ("pcasnow", "diffusion"))
    assert solved.attrs["notes"].startswith("material.snow: its curves are solved for") and field.attrs["notes"] == ""
    assert block().render(integrator="pcasnow", **few).attrs["notes"] == ""
    assert solved.rgb.max() > 0 and field.rgb.max() > 0


def test_baked_snow_conserves_light_and_lamps_add_up():
    baked = block().bake(max_bounces=0, step_mm=10)
    [snow] = baked.objects
    assert baked.lamps == ["point"] and snow.flux.shape == (2, len(snow.positions), 3)
    assert snow.triangles.max() < len(snow.positions)
    # No sky, no bounces: all light is the lamp's.
    assert np.abs(snow.flux[1]).max() < 0.02 * np.abs(snow.flux[0]).max()
    corners = snow.positions[snow.triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    assert areas.sum() == pytest.approx(6 * 0.2**2, rel=1e-4)
    # Blue light is hardly absorbed in 20 cm, and red light a little: what enters leaves. Vertices 10 mm apart give the
    # sums to 1 %.
    flux = (areas[:, None] * snow.flux[0][snow.triangles].mean(axis=1)).sum(axis=0)
    entered = (areas[:, None] * np.minimum(snow.flux[0], 0)[snow.triangles].mean(axis=1)).sum(axis=0)
    assert abs(flux[2] / entered[2]) < 0.01 and 0.01 < flux[0] / entered[0] < 0.2
    # The half-space sends out what it contains: 2 ∫ K μ dμ = 1.
    mu = (np.arange(200) + 0.5) / 200
    assert 2 * np.mean(snow.escape(mu) * mu) == pytest.approx(1, rel=1e-3)


def test_a_lightmap_is_read_by_another_program(tmp_path):
    path = tmp_path / "snow.glb"
    baked = block().bake(max_bounces=0, step_mm=20, lightmap=256, output=path)
    [snow] = baked.objects
    assert baked.lightmap.shape == (256, 256, 3) and snow.texture_coordinates.shape == (len(snow.positions), 2)
    mesh = trimesh.load(path, force="mesh", process=False)
    # trimesh counts v from the last row. A GLB has y upwards.
    np.testing.assert_allclose(mesh.visual.uv, snow.texture_coordinates * [1, -1] + [0, 1], atol=1e-7)
    np.testing.assert_array_equal(mesh.vertices, snow.positions[:, [0, 2, 1]] * [1, 1, -1])
    colours = np.asarray(mesh.visual.material.baseColorTexture.convert("RGB"))
    assert colours.shape == (256, 256, 3)
    # Brighter light has a brighter colour, up to white.
    green, code = baked.lightmap[..., 1].ravel(), colours[..., 1].ravel().astype(int)
    assert (np.diff(code[np.argsort(green, kind="stable")]) >= -1).all() and code.min() < 20 and code.max() == 255
    for size in [63, 4097, -1, 256.5, "256"]:
        with pytest.raises(ValueError, match=f"lightmap is {size}, but must be a whole number in 64–4096"):
            block().bake(lightmap=size)
    with pytest.raises(ValueError, match="snow.ply: a lightmap needs a .glb"):
        block().bake(lightmap=64, output=tmp_path / "snow.ply")


def test_snow_sparkles_in_single_pixels():
    def picture(sparkle, integrator):
        snow = SNOW["snow"] | {"sparkle": sparkle}
        scene = snowblue.Scene(
            camera=CAMERA | {"vertical_fov_deg": 0.5, "look_at": [0, 0, 0.2]}, film=FILM, material={"snow": snow},
            light=[LAMP],
            object=[{"shape": "box", "size": [0.2, 0.2, 0.2], "position": [0, 0, 0.1], "material": "snow"}])
        return scene.render(integrator=integrator, samples_per_pixel=4).rgb.sum("channel").values

    for integrator in ("pcasnow", "diffusion"):
        change = picture({"facet_size_um": 40}, integrator) - picture(False, integrator)
        # Most pixels lose the mean of the glints, and a few gain much more.
        assert np.median(change) < 0 and change.max() > -5 * change.min(), integrator
    with pytest.raises(ValueError, match="facet_size_um is 500 µm, but must be at most"):
        picture({"facet_size_um": 500}, "pcasnow")


def test_descriptions_are_plain_data():
    scene = block(integrator={"samples_per_pixel": 2})
    assert scene.description["integrator"]["type"] == "hybrid"
    assert scene.description["object"][0]["size"] == [0.2, 0.2, 0.2]
    assert "objects: 1" in repr(scene) and "[[object]]" in scene.to_toml()


def test_a_scene_with_other_tables_solves_only_for_what_differs(tmp_path):
    few = {"integrator": "diffusion", "samples_per_pixel": 2}
    (tmp_path / "lamp.csv").write_text("wavelength_nm,value\n400,1\n700,2\n")
    bulb = {name: value for name, value in LAMP.items() if name != "illuminant"} | {"spectrum": "lamp.csv"}
    scene = snowblue.Scene(camera=CAMERA, film=FILM, material=SNOW, light=[LAMP, bulb], folder=tmp_path,
                           light_field={"views": "all"},
                           object=[{"mesh": (CORNERS, TRIANGLES), "smooth": False, "material": "snow"}])
    dim = {**scene.description["light"][0], "radiant_intensity_w_sr": 3}
    moved, dimmed, file = {"camera": {**CAMERA, "position": [0.5, -1, 0.5]}}, {"light": [dim, bulb]}, {}
    for tables, solved in [({}, 2), (moved, 0), (dimmed, 1), (file, 2)]:
        if tables is file:
            # Another file under the same name is noticed.
            (tmp_path / "lamp.csv").write_text("wavelength_nm,value\n400,2\n700,1\n")
        scene = scene.with_(**tables)
        picture = scene.render(**few)
        assert picture.attrs["solved_light_fields"] == solved, tables
        # A scene without a past has the same picture.
        alone = snowblue.Scene(folder=tmp_path, **{
            **scene.description, "object": [{"mesh": (CORNERS, TRIANGLES), "smooth": False, "material": "snow"}]})
        np.testing.assert_array_equal(alone.render(**few).rgb, picture.rgb)
    assert "light" not in scene.with_(light=None, environment={"radiance_w_m2_sr": 1}).description
    with pytest.raises(ValueError, match="unknown key `clouds`"):
        scene.with_(clouds={})


def test_bad_scenes_are_named(tmp_path, repository):
    with pytest.raises(FileNotFoundError, match="missing.toml"):
        snowblue.Scene.open(tmp_path / "missing.toml")
    broken = tmp_path / "broken.toml"
    broken.write_text("[camera]\nposition = [0, 0, 0]\nlook_at = [0, 1, 0]\nzoom = 2\n")
    with pytest.raises(ValueError, match=r"broken.toml:4: .*zoom"):
        snowblue.Scene.open(broken)
    with pytest.raises(ValueError, match="vertical_fov_deg"):
        snowblue.Scene(camera={**CAMERA, "vertical_fov_deg": 400})
    with pytest.raises(ValueError, match="samples"):
        block().render(samples_per_pixel=0)
    with pytest.raises(ValueError, match="'distance' is none of"):
        block().render(aovs=["distance"])
    with pytest.raises(ValueError, match="must end in .png or .exr"):
        block().render(output=tmp_path / "picture.jpg")
    with pytest.raises(FileNotFoundError, match="no such folder"):
        block().render(output=tmp_path / "missing" / "picture.png")
    with pytest.raises(ValueError, match="step is NaN mm, but must lie in 0.01–100000 mm"):
        block().bake(step_mm=float("nan"))
    with pytest.raises(ValueError, match="must end in .glb or .ply"):
        block().bake(output=tmp_path / "snow.obj")
    opened = snowblue.Scene(camera=CAMERA, material=SNOW, light=[LAMP],
                            object=[{"mesh": (CORNERS, TRIANGLES[:-1]), "material": "snow"}])
    with pytest.raises(ValueError, match="open"):
        opened.render(integrator="hybrid")
    with pytest.raises(ValueError, match="outside 0–7"):
        snowblue.Scene(camera=CAMERA, object=[{"mesh": (CORNERS, TRIANGLES + 1), "material": "snow"}])
    with pytest.raises(ValueError, match="missing.ply does not exist"):
        snowblue.Scene(camera=CAMERA, material=SNOW, light=[LAMP], folder=tmp_path,
                       object=[{"mesh": "missing.ply", "material": "snow"}]).render()
    with pytest.raises(ValueError, match="no snow"):
        snowblue.Scene(camera=CAMERA, light=[LAMP], object=[]).bake()
    with pytest.raises(ValueError, match="full table|compressed table"):
        full = snowblue.Database.build(grain_size_um=[400], facetness=[0.3], density_kg_m3=[300], thickness_cm=[1, 5],
                                       angle_deg=[0], tally_rays=1024)
        block().render(database=full)


def test_phases_come_in_their_order_and_the_last_preview_is_the_picture():
    phases, shown = [], []
    picture = block().render(
        integrator="diffusion", samples_per_pixel=1, preview=shown.append,
        progress=lambda done, total, phase: phases.append((phase, 0 <= done <= total or phase == "light")))
    order = ["meshes", "preview", "snow", "cells", "light", "samples"]
    # Progress is looked at every 50 ms, so that short phases may be missed.
    places = [order.index(phase) for phase, _ in phases]
    assert places == sorted(places) and all(is_right for _, is_right in phases)
    np.testing.assert_array_equal(shown[-1], picture.display)
    alone = block().render(integrator="diffusion", samples_per_pixel=1)
    np.testing.assert_array_equal(picture.rgb, alone.rgb)
