"""The notebooks of the gallery run, and show what its pictures show.

As a program, `python test_notebooks.py FOLDER` writes the picture of each notebook there, as `gallery_NAME.png`: the
one that the cell with the tag `gallery` displays.
"""

import base64
import io
import os
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import nbformat
import pytest
import traitlets
from jupyter_client.kernelspec import KernelSpecManager
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient

REPOSITORY = Path(__file__).resolve().parents[3]
NOTEBOOKS = sorted((REPOSITORY / "docs" / "notebooks").glob("*.ipynb"))
RUN_HERE = [path for path in NOTEBOOKS if path.stem != "blender"]
"""That of Blender runs with the tests of the add-on, whose Python has bpy."""
TIMEOUT_S = 300
SMALLER = {
    "albedo": [("range(2, 202)", "range(2, 12)")],
    "mitsuba": [
        ('"max_depth": 6', '"max_depth": 6, "step_mm": 40.0, "field_step_mm": 20.0'),
        ("spp=96", "spp=8"),
    ],
}
"""Texts of notebooks with others, by which their tests have less to do."""
FACTS = {
    "transmittance": """
blue, red = (snow.transmittance.sel(thickness=50, wavelength=nm).item() for nm in (450, 650))
assert (snow.transmittance_se > 0).all() and (snow.transmittance.diff("thickness") < 0).all()
assert blue > 10 * red
""",
    "layers": """
clean_albedo, sooty_albedo = (spectra[name].reflectance for name in ("layers", "layers with soot"))
assert float(sooty_albedo.sel(wavelength=500)) < float(clean_albedo.sel(wavelength=500)) - 0.01
assert abs(float(sooty_albedo.sel(wavelength=1300) - clean_albedo.sel(wavelength=1300))) < 1e-3
""",
    # 4 standard deviations, and the retrieval that the chapter on measurements prints.
    "albedo": """
assert ((found["retrieved"] - found["truth"]).abs() < 4 * found["standard deviation"]).all()
assert abs(fits["scale 1"].ssa.item() - 30.5) < 0.1 and abs(fits["scale retrieved"].ssa.item() - 28.2) < 0.1
""",
    "swatches": """
assert matches["within reach"]["#5fa8c4"] and not matches["within reach"]["#b79bd0"]
assert (np.diff(light.Y, axis=1) < 0).all() and (np.diff(light.Y, axis=0) > 0).all()
""",
    "mitsuba": """
assert np.isfinite(linear).all() and volume_m3 > 0
assert table["blue / red"]["wall, thick"] > 1.5 * table["blue / red"]["flake, thin"] > 1.5
""",
}
"""What a notebook shows, as assertions on its variables."""


class ThisPython(KernelSpecManager):
    """The kernel is the interpreter that runs the tests, whatever others are installed."""

    def get_kernel_spec(self, kernel_name):
        spec = super().get_kernel_spec(kernel_name)
        spec.argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
        return spec


class Manager(AsyncKernelManager):
    """Starts that kernel."""

    @traitlets.default("kernel_spec_manager")
    def _this_python(self):
        return ThisPython(parent=self)


def executed(path, folder, facts="", smaller=()):
    """A notebook with its outputs, executed in a folder in which the paths of the repository hold."""
    notebook = nbformat.read(path, as_version=4)
    for words, fewer in smaller:
        [cell] = [cell for cell in notebook.cells if words in cell.source]
        cell.source = cell.source.replace(words, fewer)
    notebook.cells.append(nbformat.v4.new_code_cell(facts))
    place = folder / "docs" / "notebooks"
    place.mkdir(parents=True, exist_ok=True)
    if not (folder / "crates").exists():
        (folder / "crates").symlink_to(REPOSITORY / "crates")
    # The figures are those of a notebook, not those of a program without a screen.
    environment = {name: value for name, value in os.environ.items() if name != "MPLBACKEND"}
    client = NotebookClient(
        notebook, kernel_manager_class=Manager, timeout=TIMEOUT_S, resources={"metadata": {"path": str(place)}}
    )
    client.execute(env=environment)
    return notebook


def outputs(cell, kind):
    """What a cell displays of one kind of media."""
    return [one.data[kind] for one in cell.get("outputs", []) if "data" in one and kind in one.data]


def gallery_picture(notebook):
    """The PNG of the cell with the tag `gallery`."""
    [cell] = [cell for cell in notebook.cells if "gallery" in cell.metadata.get("tags", [])]
    [picture] = outputs(cell, "image/png")
    return base64.b64decode(picture)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_without_outputs(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert (notebook.nbformat, notebook.nbformat_minor) == (4, 5)
    assert notebook.metadata.kernelspec.name == "python3"
    for cell in notebook.cells:
        assert not cell.get("outputs") and cell.get("execution_count") is None, cell.id


@pytest.mark.parametrize("path", RUN_HERE, ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_its_picture(path, tmp_path):
    notebook = executed(path, tmp_path, FACTS.get(path.stem, ""), SMALLER.get(path.stem, ()))
    warnings = [one.text for cell in notebook.cells for one in cell.get("outputs", []) if one.get("name") == "stderr"]
    # Mitsuba may write there, and tqdm misses ipywidgets; other warnings of Python name their class.
    assert not [text for text in warnings if "Warning" in text and "TqdmWarning" not in text]
    picture = plt.imread(io.BytesIO(gallery_picture(notebook)))[..., :3]
    assert min(picture.shape[:2]) >= 250 and picture.std() > 0.05


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    for path in RUN_HERE:
        with tempfile.TemporaryDirectory() as temporary:
            notebook = executed(path, Path(temporary))
        file = folder / f"gallery_{path.stem}.png"
        file.write_bytes(gallery_picture(notebook))
        print(f"{file}: {file.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
