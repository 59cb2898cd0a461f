"""The code in the page for Blender and the notebook run, with coarse bakes and few samples."""

import json
import re

import bpy
import numpy as np
from test_blender import COARSE

BAKE = ("snowblue.blender.bake()", f"snowblue.blender.bake(**{COARSE})")


def smaller(code, *changes):
    """The same with less work to do: texts are replaced by others."""
    for words, fewer in (BAKE, *changes):
        assert words in code, words
        code = code.replace(words, fewer)
    return code


def test_the_page_for_blender_runs(repository, monkeypatch, tmp_path):
    [block] = re.findall(r"```python\n(.*?)```", (repository / "docs" / "src" / "blender.md").read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    page = {}
    exec(compile(smaller(block, ("samples = 32", "samples = 4")), "blender.md", "exec"), page)
    page["snowblue"].blender.unregister()
    image = bpy.data.images.load(str(tmp_path / "block.png"))
    pixels = np.array(image.pixels[:]).reshape(*image.size, 4)
    # Blue light comes through the block.
    red, green, blue = pixels[140:200, 100:180, :3].mean(axis=(0, 1))
    assert blue > green > red > 0


def test_the_notebook_runs(repository, monkeypatch, tmp_path):
    cells = json.loads((repository / "docs" / "notebooks" / "blender.ipynb").read_text())["cells"]
    monkeypatch.chdir(tmp_path)
    code = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    coarse = ("segments=192, ring_count=96", "segments=48, ring_count=24")
    notebook = {}
    exec(compile(smaller(code, coarse, ("samples = 48", "samples = 4")), "blender.ipynb", "exec"), notebook)
    notebook["snowblue"].blender.unregister()

    def colour(name):
        image = bpy.data.images.load(str(tmp_path / name))
        return np.array(image.pixels[:]).reshape(*reversed(image.size), 4)[120:200, 150:250, :3].mean(axis=(0, 1))

    (red, green, blue), (warm_red, warm_green, warm_blue) = colour("white.png"), colour("warm.png")
    assert blue > green > red > 0
    assert warm_red > red and warm_green > warm_blue
