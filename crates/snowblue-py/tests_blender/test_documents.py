"""The code in the page for Blender and the notebook run."""

import json
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


def test_the_notebook_runs(repository, monkeypatch, tmp_path):
    cells = json.loads((repository / "docs" / "notebooks" / "blender.ipynb").read_text())["cells"]
    monkeypatch.chdir(tmp_path)
    notebook = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), cell["id"], "exec"), notebook)
    notebook["snowblue"].blender.unregister()

    def colour(name):
        image = bpy.data.images.load(str(tmp_path / name))
        return np.array(image.pixels[:]).reshape(*reversed(image.size), 4)[120:200, 150:250, :3].mean(axis=(0, 1))

    (red, green, blue), (warm_red, warm_green, warm_blue) = colour("white.png"), colour("warm.png")
    assert blue > green > red > 0
    assert warm_red > red and warm_green > warm_blue
