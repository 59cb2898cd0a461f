"""One sample of snow in the command, Python, Mitsuba, Blender and a preset: one identifier, and the same numbers."""

import json
import math
import os
import subprocess

import bpy
import numpy as np

import snowblue.blender

SNOW = {"grain_size_um": 200.0, "facetness": 0.25, "density_kg_m3": 210.0}
OPTIONS = ["--grain-size", "200", "--facetness", "0.25", "--density", "210"]
LAMP = [0.1, 0.5, 0.2]
STEP_MM = 10.0
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

OTHERS = """
import json, subprocess, sys
import mitsuba as mi
import numpy as np
mi.set_variant("llvm_ad_rgb")
import snowblue, snowblue.mitsuba

folder, snow, lamp, step_mm = sys.argv[1], *map(json.loads, sys.argv[2:])
mesh = [np.load(f"{folder}/{name}.npy") for name in ("vertices", "triangles")]
result = {}

spectrum = snowblue.spectrum(thickness_cm=5.0, wavelength_nm=550.0, **snow)
result["python id"] = spectrum.attrs["snow_id"]
result["python transmittance"] = float(spectrum.transmittance.squeeze())
color = snowblue.color(thickness_cm=5.0, illuminant="D65", **snow)
result["python color"] = [float(color[f"{name}_linear"].squeeze()) for name in "rgb"]

light = {"type": "point", "position": lamp, "illuminant": "D65", "radiant_intensity_w_sr": 1.0}
scene = snowblue.Scene(
    material={"snow": {"type": "snow", **snow}}, light=[light], object=[{"mesh": mesh, "material": "snow"}])
[baked] = scene.bake(step_mm=step_mm, output=f"{folder}/python.ply").objects
np.save(f"{folder}/python.npy", np.concatenate([baked.positions, baked.flux[0]], axis=1))

shape = snowblue.mitsuba.snow_mesh(*mesh, **snow)
result["mitsuba id"] = shape.bsdf().snow_id
made = mi.load_dict({
    "type": "scene", "integrator": {"type": "snow", "step_mm": step_mm}, "shape": shape,
    "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 1, "height": 1}},
    "lamp": {"type": "point", "position": lamp, "intensity": {"type": "d65", "scale": 1.0}}})
method = made.integrator().method
release = method.release

def saved_and_released():
    # The shape has its light while it is rendered.
    parameters = mi.traverse(shape)
    points, flux = (np.array(parameters[name]).reshape(-1, 3) for name in ("vertex_positions", "vertex_snow_0"))
    np.save(f"{folder}/mitsuba.npy", np.concatenate([points, flux], axis=1))
    release()

method.release = saved_and_released
mi.render(made, spp=1)
print(json.dumps(result))
"""
"""Python and Mitsuba, by the Python that has both."""


def command(*words):
    done = subprocess.run([os.environ["SNOWBLUE"], *map(str, words), "--quiet"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_one_sample_is_the_same_snow_everywhere(scene, white, tmp_path):
    ids, fluxes = {}, {}

    # Blender: a lamp of 4 pi W has 1 W/sr. There and in Mitsuba white light has the luminance 1.
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.1), scale=(0.2, 0.1, 0.2))
    block = bpy.context.object
    block.snowblue.is_snow, block.snowblue.preset = True, "CUSTOM"
    for name, value in SNOW.items():
        setattr(block.snowblue, name, value)
    bpy.ops.object.light_add(type="POINT", location=LAMP)
    bpy.context.object.data.shadow_soft_size = 0.0
    [baked] = snowblue.blender.bake(step_mm=STEP_MM)
    ids["Blender"] = baked["snow_id"]
    bpy.context.view_layer.update()
    positions = np.array([baked.matrix_world @ one.co for one in baked.data.vertices])
    flux = np.array([one.vector for one in baked.data.attributes["snow_lamp_0"].data])
    fluxes["Blender"] = np.concatenate([positions, 4 * math.pi * flux * (white @ LUMINANCE)], axis=1)

    # The mesh of Blender, for the others.
    depsgraph = bpy.context.evaluated_depsgraph_get()
    block.hide_viewport = False
    vertices, triangles, _ = snowblue.blender._meshes.world_mesh(
        block.evaluated_get(depsgraph), block.matrix_world, scene.unit_settings.scale_length)
    np.save(tmp_path / "vertices.npy", vertices)
    np.save(tmp_path / "triangles.npy", triangles)
    words = [tmp_path, *map(json.dumps, (SNOW, LAMP, STEP_MM))]
    done = subprocess.run(
        [os.environ["MITSUBA_PYTHON"], "-c", OTHERS, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    others = json.loads(done.stdout.splitlines()[-1])
    ids["Python"], ids["Mitsuba"] = others["python id"], others["mitsuba id"]
    fluxes["Python"] = np.load(tmp_path / "python.npy")
    fluxes["Mitsuba"] = np.load(tmp_path / "mitsuba.npy")
    fluxes["Mitsuba"][:, 3:] *= white @ LUMINANCE

    # The command.
    numbers = json.loads(command(
        "spectrum", *OPTIONS, "--thickness", 5, "--wavelengths", 550, "--format", "json"))
    ids["command"] = numbers["metadata"]["snow_id"]
    [row] = numbers["rows"]
    assert row["transmittance"] == others["python transmittance"]
    light = dict(type="point", position=LAMP, illuminant="D65", radiant_intensity_w_sr=1.0)
    (tmp_path / "block.ply").write_bytes(snowblue._scene._ply(vertices.astype("<f4"), triangles))
    made = snowblue.Scene(
        material={"snow": {"type": "snow", **SNOW}}, light=[light],
        object=[{"mesh": "block.ply", "up": "z", "material": "snow"}], folder=tmp_path)
    (tmp_path / "scene.toml").write_text(made.to_toml())
    command("bake", tmp_path / "scene.toml", "--step-mm", STEP_MM, "-o", tmp_path / "command.ply")
    files = [(tmp_path / f"{name}.ply").read_bytes().split(b"end_header\n", 1)[1] for name in ("command", "python")]
    assert files[0] == files[1]

    # A preset: what its file says of the snow.
    preset = command("export", "openpbr", *OPTIONS, "--color-space", "srgb-linear")
    [ids["preset"]] = [line.split(": ")[1] for line in preset.splitlines() if "snow_id: " in line]
    [through] = [line.split()[3:] for line in preset.splitlines() if "through 5 cm" in line]
    # Channels of a preset are over those of the light, whose luminance is 1 in colours. Four digits are written.
    expected = others["python color"] / (white / (white @ LUMINANCE))
    np.testing.assert_allclose([float(cell) for cell in through[::3]], expected, rtol=2e-4)

    assert len(set(ids.values())) == 1, ids
    reference = fluxes.pop("Python")
    assert np.abs(reference[:, 3:]).min() > 0
    for name, values in fluxes.items():
        np.testing.assert_allclose(values[:, :3], reference[:, :3], atol=1e-6, err_msg=name)
        # Sums of 31 numbers of 24 bits, which partly cancel in red.
        np.testing.assert_allclose(values[:, 3:], reference[:, 3:], rtol=1e-4, atol=1e-6, err_msg=name)
