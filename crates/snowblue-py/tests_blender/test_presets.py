"""The exported script for Blender, and what Cycles renders of its material."""

import math
import os
import re
import runpy
import subprocess

import bpy
import numpy as np
import OpenEXR
import pytest

import snowblue
import snowblue.blender

# Pixels along an edge of a picture.
SIZE = 16


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    path = tmp_path_factory.mktemp("preset") / "snow.py"
    subprocess.run([os.environ["SNOWBLUE"], "export", "principled", "-o", path], check=True)
    return path


def claimed(script, row, column=1):
    """Red, green and blue of a row of the table: of snow (column 0) or of the preset (column 1)."""
    cells = re.search(rf"# {re.escape(row)} +(.*)", script.read_text())[1].split()
    return np.array([float(cells[3 * channel + column]) for channel in range(3)])


def snow_material(script):
    """Runs the script as Blender does."""
    runpy.run_path(str(script), run_name="__main__")
    return bpy.data.materials["Snow"]


def rendered(tmp_path, width, samples):
    """A picture from above by parallel rays, `width` wide: the mean of red, green and blue, and its standard error."""
    scene = bpy.context.scene
    bpy.ops.object.camera_add(location=(0, 0, 5))
    scene.camera = bpy.context.object
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", width
    scene.render.engine, scene.cycles.samples = "CYCLES", samples
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.render.film_transparent = True
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(tmp_path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    pixels = OpenEXR.File(scene.render.filepath).channels()["RGBA"].pixels[..., :3].reshape(-1, 3)
    return pixels.mean(0), pixels.std(0) / math.sqrt(len(pixels))


@pytest.fixture
def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def test_the_script_makes_a_material(empty, script):
    material = snow_material(script)
    [surface] = [node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"]
    [output] = [node for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL"]
    assert output.inputs["Surface"].links[0].from_node == surface
    assert surface.subsurface_method == "RANDOM_WALK"
    # The radius is 4 pi transport mean free paths of 2 mm.
    assert surface.inputs["Subsurface Scale"].default_value == pytest.approx(4 * math.pi * 0.002, rel=0.05)
    assert surface.inputs["Subsurface Weight"].default_value == 1
    # A second run changes the same material.
    assert snow_material(script) == material and len(bpy.data.materials) == 1


@pytest.mark.parametrize("cm", [1, 5])
def test_cycles_transmits_what_the_script_claims(empty, script, tmp_path, cm):
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -0.005 * cm))
    bpy.context.object.scale = (2, 2, 0.01 * cm)
    bpy.context.object.data.materials.append(snow_material(script))
    # A sun of the irradiance pi from below: a white diffuse surface there has the radiance 1.
    bpy.ops.object.light_add(type="SUN", rotation=(math.pi, 0, 0))
    bpy.context.object.data.energy, bpy.context.object.data.angle = math.pi, 0
    mean, error = rendered(tmp_path, 0.2, 1024)
    expected = claimed(script, f"through {cm} cm")
    # 4 standard errors of the picture, and the script's own: of 2^17 walks.
    own = np.sqrt(expected / 2**17)
    assert (np.abs(mean - expected) < 4 * np.hypot(error, own) + 0.01 * expected).all(), (mean, expected, error)


def test_cycles_reflects_what_the_script_claims(empty, script, tmp_path):
    """A parallel view of a ball in a white world averages over all angles as diffuse light does."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=1)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(snow_material(script))
    world = bpy.data.worlds.new("White")
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    bpy.context.scene.world = world
    # Wider than the ball, whose edge the filter of the pixels blurs.
    width, samples = 2.4, 1024
    mean, _ = rendered(tmp_path, width, samples)
    albedo = mean * width**2 / math.pi
    # 4 standard errors of walks of which a tenth is lost, the polygons' area of 0.0004, and the script's own walks.
    noise = 4 * math.hypot(*(math.sqrt(0.09 / walks) for walks in [samples * SIZE**2 / 2, 2**17]))
    assert np.abs(albedo - claimed(script, "albedo, deep")).max() < noise + 0.002


@pytest.fixture(scope="module")
def straight_out():
    """K(1) of the snow of the script: its radiance straight out over the mean of its radiance by diffuse exitance."""
    snow = snowblue.Scene(
        integrator={"type": "diffusion"},
        material={"snow": {"type": "snow", "grain_size_um": 400, "facetness": 0.3, "density_kg_m3": 300}},
        light=[{"type": "point", "position": [0, 1, 0], "illuminant": "D65", "radiant_intensity_w_sr": 1.0}],
        object=[{"shape": "box", "size": [0.1, 0.1, 0.1], "material": "snow"}],
    )
    return snow.bake().objects[0].escape(1.0)


@pytest.mark.parametrize("cm", [1, 5])
def test_a_sheet_of_the_add_on_transmits_what_the_script_says_of_snow(scene, script, straight_out, tmp_path, cm):
    """Straight on, snow is K(1) times as bright as a surface that sends its light equally in all directions, as Cycles'
    does."""
    assert "350–450 µm" in script.read_text() and "300 kg/m³" in script.read_text()
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -0.005 * cm))
    sheet = bpy.context.object
    sheet.scale = (0.8, 0.8, 0.01 * cm)
    sheet.snowblue.is_snow, sheet.snowblue.preset = True, "OLD"
    bpy.ops.object.light_add(type="SUN", rotation=(math.pi, 0, 0))
    bpy.context.object.data.energy, bpy.context.object.data.angle = math.pi, 0
    snowblue.blender.bake()
    bake, _ = rendered(tmp_path, 0.1, 16)
    # The light field of a sheet is within 0.5 % of discrete ordinates, and J between vertices within 0.8 %.
    np.testing.assert_allclose(bake, straight_out * claimed(script, f"through {cm} cm", 0), rtol=0.015)


def test_a_lit_face_of_the_preset_is_as_dark_as_the_chapter_says(scene, script, tmp_path):
    """Straight on, with the sun behind the eye: the means of the preset over those of the add-on."""
    bpy.ops.mesh.primitive_cube_add(size=0.3)
    block = bpy.context.object
    block.snowblue.is_snow, block.snowblue.preset = True, "OLD"
    bpy.ops.object.light_add(type="SUN")
    bpy.context.object.data.energy, bpy.context.object.data.angle = math.pi, 0
    [baked] = snowblue.blender.bake()
    bake, _ = rendered(tmp_path, 0.3, 64)
    snowblue.blender.clear()
    block.snowblue.is_snow = False
    block.data.materials.append(snow_material(script))
    preset, _ = rendered(tmp_path, 0.3, 512)
    np.testing.assert_allclose(preset / bake, [0.91, 0.90, 0.89], atol=0.02)
