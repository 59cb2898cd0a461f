"""The code in the page for Blender runs."""

import re

import bpy
import numpy as np


def test_the_page_for_blender_runs(repository, monkeypatch, tmp_path):
    [block] = re.findall(r"```python\n(.*?)```", (repository / "docs" / "src" / "blender.md").read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    page = {}
    exec(compile(block, "blender.md", "exec"), page)
    page["snowblue"].blender.unregister()
    image = bpy.data.images.load(str(tmp_path / "block.png"))
    pixels = np.array(image.pixels[:]).reshape(*image.size, 4)
    # Blue light comes through the block.
    red, green, blue = pixels[140:200, 100:180, :3].mean(axis=(0, 1))
    assert blue > green > red > 0
