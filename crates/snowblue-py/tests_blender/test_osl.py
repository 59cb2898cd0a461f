"""The exported shader in Cycles."""

import math
import os
import subprocess

import _cycles
import bpy
import mathutils
import numpy as np
import OpenEXR
import pytest

SIZE, POSITION, LAMP = (0.6, 0.3, 0.6), (0.0, 0.0, 0.3), (0.1, 0.5, 0.35)
INTENSITY_W_SR = 40.0
CAMERA = {"position": [0.4, -1.5, 0.6], "look_at": [0, 0, 0.3], "vertical_fov_deg": 16}


def script_node(tree, program, unit_m):
    """The node of a compiled script. Blender as a module cannot ask it for its sockets, which a window does."""
    node = tree.nodes.new("ShaderNodeScript")
    node.mode, node.filepath = "EXTERNAL", str(program)
    node.inputs.new("NodeSocketVector", "lamp_1_position").default_value = np.divide(LAMP, unit_m)
    power = 4 * math.pi * INTENSITY_W_SR / unit_m**2
    node.inputs.new("NodeSocketColor", "lamp_1_power").default_value = [power, power, power, 1]
    node.inputs.new("NodeSocketFloat", "unit_m").default_value = unit_m
    node.outputs.new("NodeSocketShader", "BSDF")
    return node


# Blender's own update of script nodes needs a module that only the program has.
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("unit_m", [1.0, 0.01])
def test_the_shader_shows_what_pcasnow_does(render, white, tmp_path, unit_m):
    source, program = tmp_path / "snow.osl", tmp_path / "snow.oso"
    subprocess.run([os.environ["SNOWBLUE"], "export", "osl", "-o", source], check=True)
    assert _cycles.osl_compile(str(source), str(program))

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.shading_system, scene.cycles.samples = "CYCLES", True, 64
    # Direct light only.
    scene.cycles.max_bounces = 0
    # A floor behind the back casts no shadow and is not snow.
    bpy.ops.mesh.primitive_plane_add(size=4 / unit_m, location=(0, 0, -0.01 / unit_m))
    bpy.ops.mesh.primitive_cube_add(size=1 / unit_m, location=np.divide(POSITION, unit_m))
    snow = bpy.context.object
    snow.scale = SIZE
    material = bpy.data.materials.new("Snow")
    material.use_nodes = True
    material.node_tree.nodes.clear()
    output = material.node_tree.nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(script_node(material.node_tree, program, unit_m).outputs[0], output.inputs["Surface"])
    snow.data.materials.append(material)
    bpy.ops.object.camera_add(location=np.divide(CAMERA["position"], unit_m))
    scene.camera = bpy.context.object
    towards = np.subtract(CAMERA["look_at"], CAMERA["position"])
    scene.camera.rotation_euler = mathutils.Vector(towards).to_track_quat("-Z", "Y").to_euler()
    scene.camera.data.clip_end = 100 / unit_m
    scene.camera.data.angle = math.radians(CAMERA["vertical_fov_deg"])
    scene.render.resolution_x = scene.render.resolution_y = 64
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(tmp_path / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    cycles = OpenEXR.File(scene.render.filepath).channels()["RGBA"].pixels[..., :3]

    light = {"type": "point", "position": list(LAMP), "illuminant": "D65", "radiant_intensity_w_sr": INTENSITY_W_SR}
    ours = render(
        {
            "camera": CAMERA,
            "film": {"width": 64, "height": 64},
            "integrator": {"max_bounces": 0},
            "material": {
                "snow": {"type": "snow", "grain_size_um": 400, "facetness": 0.3, "density_kg_m3": 300},
                "floor": {"type": "diffuse", "reflectance": 0.0},
            },
            "light": [light],
            "object": [
                {"shape": "box", "size": list(SIZE), "position": list(POSITION), "material": "snow"},
                {"shape": "plane", "position": [0, 0, -0.01], "material": "floor"},
            ],
        },
        "pcasnow",
        64,
    )
    # The front face, away from its edges, in the middle of the picture.
    middle = (slice(16, 48), slice(20, 40))
    ratio = cycles[middle].mean((0, 1)) / (ours[middle].mean((0, 1)) / white)
    # The table's own look-up is within 0.5 % of the engine, whose fit the shader has.
    assert ratio[1:] == pytest.approx(1, abs=0.01)
    assert ratio[0] == pytest.approx(1, abs=0.02)
