"""Area lamps with a spread, square spots and sun discs of sky textures, beside what Cycles shows of them on a floor."""

import math
import warnings

import bpy
import numpy as np
import OpenEXR
import pytest
from test_blender import AHEAD, COARSE, TOP, bake, block, inner, lamp, link, shot, towards, world
from test_jobs import flux

import snowblue.blender
from snowblue._renderers import BAND_WIDTH_NM
from snowblue.blender._bake import BakeJob
from snowblue.blender._solve import Options

SKY_TYPE = "SINGLE_SCATTERING" if bpy.app.version >= (5, 0) else "NISHITA"
PIXELS, WIDTH = 32, 2.0
"""Of the picture of the floor, and its width in m."""


def floor_of_cycles(folder, samples=256):
    """The irradiance over pi on a white floor at z = 0, as Cycles shows it from above, with nothing else there."""
    scene, path = bpy.context.scene, folder / "floor.exr"
    bpy.ops.mesh.primitive_plane_add(size=20)
    floor = bpy.context.object
    white = bpy.data.materials.new("white")
    if not white.node_tree:
        white.use_nodes = True
    tree = white.node_tree
    tree.nodes.clear()
    diffuse, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    floor.data.materials.append(white)
    data = bpy.data.cameras.new("above")
    data.type, data.ortho_scale = "ORTHO", WIDTH
    scene.camera = link("above", data, (0, 0, 5))
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.cycles.samples, scene.cycles.max_bounces = samples, 0
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = "BOX"
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    bpy.data.objects.remove(floor)
    return OpenEXR.File(str(path)).channels()["RGB"].pixels


def collected():
    job = BakeJob(bpy.context.scene, None, Options())
    job.collect()
    return job._collected[0]


def baked_sun():
    """A bake of one object, and the sun disc of its sky texture."""
    job = BakeJob(bpy.context.scene, None, Options(**COARSE))
    job.collect()
    job.solve()
    [baked] = job.finish()
    [_, sun] = job._collected[0].skylight
    return baked, sun


def floor_of_spots(spots):
    """The same by spots of a scene file: the intensity falls off by the square in the cosine between the cones."""
    across = WIDTH * ((np.arange(PIXELS) + 0.5) / PIXELS - 0.5)
    # The first row of a picture is the top.
    places = np.stack(np.broadcast_arrays(across[None, :], -across[:, None], 0.0), axis=-1)
    total = np.zeros((PIXELS, PIXELS))
    for spot in spots:
        position = np.array(spot["position"])
        axis = np.array(spot["look_at"]) - position
        axis /= np.linalg.norm(axis)
        towards = places - position
        distance = np.linalg.norm(towards, axis=-1)
        inner, outer = (math.cos(math.radians(spot[f"{name}_cone_deg"])) for name in ("inner", "outer"))
        share = np.clip((towards @ axis / distance - outer) / (inner - outer), 0, 1)
        total += spot["radiant_intensity_w_sr"] / BAND_WIDTH_NM * share**2 * position[2] / distance**3
    return total / math.pi


@pytest.mark.parametrize("spread", [20, 60, 120, 170])
def test_spots_light_a_floor_like_an_area_lamp_with_a_spread(scene, tmp_path, spread):
    # The lamp is turned about its axis and is not square. Snow under it lies where the floor is.
    block(size=(2, 2, 0.02), position=(0, 0, -0.01))
    light = lamp("AREA", (0.1, 0.0, 1.0), 1.0, (0.1, 0, 0), shape="RECTANGLE", size=0.3, size_y=0.1)
    light.rotation_euler.z += 0.5
    light.data.spread = math.radians(spread)
    bpy.context.view_layer.update()
    [one] = collected().lamps
    ours = floor_of_spots(one.lights)
    bpy.data.objects.remove(bpy.data.objects["block"])
    theirs = floor_of_cycles(tmp_path)[..., 1]
    # The power is that of the lamp. Of the peak, slices of the profile miss 1/64, spots a quarter of a cone apart some
    # 2 %, and Cycles has noise of 1 %.
    assert ours.sum() == pytest.approx(theirs.sum(), rel=0.01)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=0.05 * theirs.max())


def test_a_spread_just_below_180_degrees_is_nearly_none(scene):
    block()
    light = lamp("AREA", shape="RECTANGLE", size=0.1, size_y=0.3, energy=math.pi)
    [baked] = snowblue.blender.bake()
    whole = flux(baked)
    light.data.spread = math.radians(178)
    snowblue.blender.bake()
    # The vertices are dense beside edges: each counts by the area of its triangles.
    areas = np.zeros(len(whole))
    for face in baked.data.polygons:
        areas[list(face.vertices)] += face.area
    # tan h/(tan h - h) is 1.028 for 89 degrees. The profile errs by 1/64, and less light leaves obliquely.
    assert np.sum((flux(baked).T * areas).T) / np.sum((whole.T * areas).T) == pytest.approx(1.028, abs=0.02)


def test_a_narrow_lamp_that_is_large_and_near_is_named(scene):
    block()
    light = lamp("AREA", shape="RECTANGLE", size=2.0, size_y=0.1)
    light.data.spread = math.radians(10)
    with pytest.warns(UserWarning, match="lamp 'lamp' is close to the snow or has a small spread: snow sees 8 spots"):
        assert len(collected().lamps[0].lights) == 8 * 8 * 16


def test_a_square_spot_is_round_in_cycles_and_in_snow(scene, tmp_path):
    block()
    light = lamp("SPOT", spot_size=math.radians(40), shadow_soft_size=0.0)
    [baked] = bake()
    round_one, (picture, mask) = flux(baked), shot(tmp_path, AHEAD, samples=4)
    light.data.use_square = True
    with pytest.warns(UserWarning, match="lamp 'lamp' is a square spot: snow sees a round one, as Cycles does"):
        bake()
    assert np.array_equal(flux(baked), round_one)
    assert np.array_equal(shot(tmp_path, AHEAD, samples=4)[0][inner(mask)], picture[inner(mask)])


def sky_texture(**settings):
    world((1.0, 1.0, 1.0))
    tree = bpy.context.scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sky_type = SKY_TYPE
    for name, value in settings.items():
        setattr(node, name, value)
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = 0.1
    return node


@pytest.mark.parametrize("size", [0.545, 0.1])
def test_the_sun_of_a_sky_texture_has_its_irradiance_and_direction(scene, tmp_path, size):
    block()
    node = sky_texture(
        sun_elevation=math.radians(30), sun_rotation=math.radians(130), sun_size=math.radians(size)
    )
    made = collected()
    # The node itself is as it was.
    assert node.sun_disc
    [sky, sun] = made.skylight
    [light] = sun.tables["light"]
    assert sky.is_image and light["type"] == "directional"
    azimuth = math.radians(130)
    expected = [-math.cos(math.pi / 6) * math.sin(azimuth), -math.cos(math.pi / 6) * math.cos(azimuth), -0.5]
    np.testing.assert_allclose(light["direction"], expected, atol=1e-6)
    bpy.data.objects.remove(bpy.data.objects["block"])
    with_sun = floor_of_cycles(tmp_path, samples=1024).mean(axis=(0, 1))
    node.sun_disc = False
    difference = with_sun - floor_of_cycles(tmp_path, samples=1024).mean(axis=(0, 1))
    irradiance = math.pi * difference / 0.5
    # White light of D65 has the luminance of its irradiance.
    values = np.array([float(row.split(",")[1]) for row in sun.files[light["spectrum"]].decode().split()[1:]])
    assert light["irradiance_w_m2"] == pytest.approx(values.mean() * BAND_WIDTH_NM, rel=1e-6)
    # Red, green and blue are the ends and the middle of the bands. The limb of the disc is darker, and its pixels are
    # sampled at 64 points.
    np.testing.assert_allclose(values[[-1, 13, 0]], irradiance, rtol=0.01)


def test_snow_under_a_sky_texture_has_the_light_of_its_sun(scene):
    """The same as under that sky without its disc and a sun lamp beside it."""
    block()
    node = sky_texture(sun_elevation=math.radians(40))
    baked, sun = baked_sun()
    both = flux(baked, "snow_sky")
    assert "snow_lamp_0" not in baked.data.attributes
    [table] = sun.tables["light"]
    node.sun_disc = False
    direction = np.array(table["direction"])
    lamp("SUN", tuple(-direction), 1.0, (0, 0, 0), angle=0.0)
    bake()
    rest = flux(baked, "snow_sky")
    values = np.array([float(row.split(",")[1]) for row in sun.files[table["spectrum"]].decode().split()[1:]])
    # A lamp is multiplied by channel, bands of wavelengths are not: the difference is in the colours alone.
    luminance = np.array([0.2126, 0.7152, 0.0722])
    white = flux(baked, "snow_lamp_0") * values[[-1, 13, 0]]
    scale = np.abs(both @ luminance).max()
    np.testing.assert_allclose((rest + white) @ luminance, both @ luminance, rtol=0, atol=0.02 * scale)


def test_a_sky_texture_is_reflected_as_its_sky_and_a_sun(scene, tmp_path):
    """Low suns are reflected forwards, and that of a sky texture as a lamp in its place."""
    block()
    node = sky_texture(sun_elevation=math.radians(15), sun_rotation=math.radians(180))
    baked, sun = baked_sun()
    [name] = [key for key in baked.keys() if key.startswith("snow_sun_")]
    np.testing.assert_allclose(baked[name], towards(15, 180), atol=1e-6)
    picture, mask = shot(tmp_path, TOP, samples=256)
    node.sun_disc = False
    values = np.array([float(row.split(",")[1]) for row in list(sun.files.values())[0].decode().split()[1:]])
    lamp("SUN", towards(15, 180), 1.0, (0, 0, 0), angle=0.0).data.color = values[[-1, 13, 0]]
    bake()
    apart, _ = shot(tmp_path, TOP, samples=256)
    mask = inner(mask)
    # As in the test above, and noise. Lamps are multiplied by channel.
    np.testing.assert_allclose(picture[mask].mean(axis=0), apart[mask].mean(axis=0), rtol=0.04)


def test_a_large_sun_stays_in_the_image(scene):
    block()
    node = sky_texture(sun_size=math.radians(8))
    assert len(collected().skylight) == 1
    node.sun_size = math.radians(0.5)
    assert len(collected().skylight) == 2
    node.sun_elevation = math.radians(-10)
    # Below the horizon.
    assert len(collected().skylight) == 1


def test_a_sun_without_a_size_shines(scene):
    block()
    sky_texture(sun_size=0.0)
    assert len(collected().skylight) == 2


def test_a_sun_that_is_not_found_is_named(scene):
    block()
    node = sky_texture(sun_elevation=math.radians(30))
    tree = scene.world.node_tree
    mix = tree.nodes.new("ShaderNodeMixRGB")
    mix.inputs["Fac"].default_value = 0.0
    tree.links.new(node.outputs["Color"], mix.inputs["Color2"])
    tree.links.new(mix.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    with pytest.warns(UserWarning, match="the sun of the sky texture 'Sky Texture' was not found in the World"):
        assert len(collected().skylight) == 1
    # Below the horizon there is none to be found, and none in a black World.
    lamp()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        node.sun_elevation = math.radians(-10)
        collected()
        node.sun_elevation = math.radians(30)
        tree.nodes["Background"].inputs["Strength"].default_value = 0.0
        assert collected().skylight == []


def test_a_sun_in_a_node_group_is_named(scene):
    block()
    world((1.0, 1.0, 1.0))
    group = bpy.data.node_groups.new("sky", "ShaderNodeTree")
    group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    node, end = group.nodes.new("ShaderNodeTexSky"), group.nodes.new("NodeGroupOutput")
    node.sky_type = SKY_TYPE
    group.links.new(node.outputs["Color"], end.inputs["Color"])
    tree = scene.world.node_tree
    inside = tree.nodes.new("ShaderNodeGroup")
    inside.node_tree = group
    tree.links.new(inside.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    with pytest.warns(UserWarning, match="the sun of the sky texture 'Sky Texture' is in the node group 'sky'"):
        assert len(collected().skylight) == 1


def test_denoising_keeps_the_light_of_snow(scene, tmp_path):
    block()
    bpy.ops.mesh.primitive_plane_add(size=4)
    lamp(position=(0, 0.3, 0.1))
    bake()
    path = tmp_path / "picture.exr"
    data = bpy.data.cameras.new("camera")
    data.angle = math.radians(35)
    scene.camera = link("camera", data, (0.5, -0.8, 0.4), (0, 0, 0.08))
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 200
    # The block of snow alone.
    scene.render.use_border = scene.render.use_crop_to_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.4, 0.6
    scene.render.border_min_y, scene.render.border_max_y = 0.35, 0.65
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    scene.render.filepath = str(path)

    def picture(samples, denoises):
        scene.cycles.samples, scene.cycles.use_denoising = samples, denoises
        scene.cycles.use_adaptive_sampling = False
        bpy.ops.render.render(write_still=True)
        return OpenEXR.File(str(path)).channels()["RGB"].pixels

    reference, noisy, denoised = picture(512, False), picture(16, False), picture(16, True)
    error, error_denoised = (np.sqrt(np.mean((one - reference) ** 2)) for one in (noisy, denoised))
    assert error_denoised < error / 2
    np.testing.assert_allclose(denoised.mean(axis=(0, 1)), reference.mean(axis=(0, 1)), rtol=0.01)
