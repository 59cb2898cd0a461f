"""Blender without a window, and the command whose pictures it is compared with."""

import os
import subprocess
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
import pytest

import snowblue
import snowblue.blender

REPOSITORY = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def repository():
    return REPOSITORY


@pytest.fixture
def scene():
    """An empty scene of Blender, with the settings of snow, by which the operator bakes coarsely."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    snowblue.blender.register()
    settings = bpy.context.scene.snowblue_bake
    settings.step_mm, settings.field_step_mm = 20.0, 10.0
    yield bpy.context.scene
    snowblue.blender.unregister()


@pytest.fixture(scope="session")
def render(tmp_path_factory):
    """Renders a scene by the command that the environment variable SNOWBLUE names, as linear sRGB."""
    folder = tmp_path_factory.mktemp("render")

    def picture(tables, integrator, samples):
        (folder / "scene.toml").write_text(snowblue.Scene(folder=folder, **tables).to_toml())
        output = folder / "picture.exr"
        words = ["render", folder / "scene.toml", "--integrator", integrator, "--spp", samples, "-o", output, "--quiet"]
        done = subprocess.run([os.environ["SNOWBLUE"], *map(str, words)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return OpenEXR.File(str(output)).channels()["RGB"].pixels

    picture.folder = folder
    return picture


@pytest.fixture(scope="session")
def white(render):
    """What the command's pictures show of a white surface under D65 of the irradiance pi: 1 in Blender."""
    tables = dict(
        camera=dict(position=[0, 0, 1], look_at=[0, 0, 0], up=[0, 1, 0]),
        film={"width": 1, "height": 1},
        integrator={"max_bounces": 0},
        material={"white": {"type": "diffuse", "reflectance": 1.0}},
        light=[{"type": "directional", "direction": [0, 0, -1], "illuminant": "D65", "irradiance_w_m2": np.pi}],
        object=[{"shape": "box", "size": [1, 1, 0.1], "position": [0, 0, -0.05], "material": "white"}],
    )
    return render(tables, "pcasnow", 1)[0, 0]
