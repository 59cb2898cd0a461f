"""The code in the documents runs."""

import re

import matplotlib.pyplot as plt
import numpy as np

import snowblue


def test_the_page_for_mitsuba_runs(repository, monkeypatch, tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", (repository / "docs" / "src" / "mitsuba.md").read_text(), re.DOTALL)
    assert len(blocks) == 2
    monkeypatch.chdir(tmp_path)
    # The light field, then PCASnow.
    given = {}
    for block in blocks:
        exec(compile(block, "mitsuba.md", "exec"), given)
        # Blue light comes through the block.
        red, green, blue = plt.imread(tmp_path / "block.png")[140:200, 100:160].mean(axis=(0, 1))
        assert blue > green > red > 0
        (tmp_path / "block.png").unlink()


def test_the_page_for_python_runs(repository, monkeypatch, tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", (repository / "docs" / "src" / "python.md").read_text(), re.DOTALL)
    assert len(blocks) >= 7
    # What the page takes as given: a measured albedo, and a tetrahedron.
    wavelength_nm = np.arange(400, 1401, 50)
    deep = snowblue.spectrum(ssa_m2_kg=20, thickness_cm=80, angle_deg="diffuse", wavelength_nm=wavelength_nm)
    given = {
        "wavelength_nm": wavelength_nm,
        "albedo": deep.reflectance.values.ravel(),
        "vertices_m": 0.2 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        "triangles": np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
    }
    (tmp_path / "scenes").symlink_to(repository / "scenes")
    monkeypatch.chdir(tmp_path)
    for block in blocks:
        exec(compile(block, "python.md", "exec"), given)
        plt.close("all")
    assert given["baked"].objects[0].flux.shape[0] == 2 and (tmp_path / "coarse.nc").exists()
