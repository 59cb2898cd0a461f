"""The notebooks of the gallery run, and show what its pictures show.

As a program, `python test_notebooks.py FOLDER [NAME...]` writes the picture of each notebook there, as
`gallery_NAME.png`: the one that the cell with the tag `gallery` displays.
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
    "look_ups": [
        ("facetness = [0.1, 0.3, 0.5, 0.7, 0.9]", "facetness = [0.3]"),
        ("random.uniform(0.1, 0.9, 3)", "[0.3]"),
    ],
    "truth": [("factor = 1 ", "factor = 1 / 64 ")],
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
    # 4 standard deviations, and the retrieval that the book prints.
    "albedo": """
assert ((found["retrieved"] - found["truth"]).abs() < 4 * found["standard deviation"]).all()
assert abs(fits["scale 1"].ssa.item() - 30.5) < 0.1 and abs(fits["scale retrieved"].ssa.item() - 28.2) < 0.1
""",
    # Rows and values of the published tables, and the book's numbers to their printed digits.
    "measured_albedo": """
assert len(measured) == 181 and measured.albedo_340mm.iloc[0] == 0.99419 and measured.albedo_45mm.iloc[-1] == 0.46215
assert abs(rms.loc["400–1300"] - [0.0096, 0.0261, 0.0153]).max() < 1e-4
assert (residuals["4.5 cm, predicted"] > 0).mean() > 0.95
""",
    "tomograms": """
assert len(samples) == 32 and samples.B.iloc[0] == 1.776 and samples.ssa_m2_kg.iloc[-1] == 13.12
assert abs(ours["B"] - 1.72) < 0.01 and abs(ours["g"] - 0.698) < 0.001 and abs(theirs["B"] - 1.53) < 0.01
changes = table.astype(float).loc["their B, g and κ"] / table.astype(float).iloc[1] - 1
assert abs(changes.iloc[:3] - [0.06, 0.09, 0.19]).max() < 0.01
assert abs(table.astype(float).loc["ours"] - [0.02162, 0.01871, 0.01029, 0.8293, 0.6644]).max() < 1e-4
""",
    "water": """
assert (differences["unexposed"].sel(water_saturation=slice(0.01, 0.1)) < 2).all()
assert (differences["at middle grey"].sel(water_saturation=0.1, thickness=[1, 5, 15]) < JUST_NOTICEABLE).all()
assert (brightness.sel(water_saturation=1) > 3).all() and (brightness.diff("water_saturation") > 0).all()
""",
    # Both solvers have the same grains and 16 streams; only rounding differs. The chapter's numbers hold to their last
    # digits but one.
    "simplifications": """
assert abs(full / vertical - 1).max() < 1e-6
errors = costs["error of T of 15 cm, %"]
assert abs(errors.loc["two ordinates, 0°"] - [-18.46, -23.67, -38.52]).max() < 0.05
assert abs(errors.loc["δ-Eddington, 0°"] - [-1.24, -1.21, -1.10]).max() < 0.05
assert abs(errors.loc["no absorption"] - [0.87, 18.07, 116.84]).max() < 0.05
assert abs(errors.loc[["Henyey–Greenstein", "1 − ω proportional to k"]]).max(axis=None) < 0.2
assert abs(costs.loc["spheres of equal SSA", "ΔE*ab unexposed"] - [5.17, 4.74, 4.51]).max() < 0.05
""",
    # Twice the chapter's 99th percentile, since places are random; the paper's form is worse by orders of magnitude.
    # With a fifth of the curves some counts are one less.
    "look_ups": """
numbers = errors.map(lambda entry: [float(value) for value in entry.split(" / ")])
ours, papers = (numbers.loc[key].iloc[0] for key in (("log, l′ = 6", "grid nodes", "0–80°", "transmittance"),
                                                     ("paper, l′ = 2", "grid nodes", "0–80°", "transmittance")))
assert ours[1] < 0.5 and papers[2] > 100 * ours[2]
assert counts.loc["D65"].tolist() == ["8 (6)", "8", "8", "15 (12)"] and counts.loc["E"].iloc[0] == "6"
""",
    # Few samples leave a cell of the corner uncertain by a fifth. By `brightest` the ball is six times too bright.
    "truth": """
energy, rms = errors.energy.unstack(), errors.RMS.unstack()
assert abs(np.log(energy.loc["corner on a floor"])).max() < 0.2
assert (rms.loc["ball, near"].drop("hybrid") > rms.loc["ball, near", "hybrid"]).all()
assert rms.loc["ball, near", "brightest"] > 1
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


def executed(path, folder, facts="", smaller=(), timeout_s=None):
    """A notebook with its outputs, executed in a folder in which the paths of the repository hold."""
    notebook = nbformat.read(path, as_version=4)
    for words, fewer in smaller:
        [cell] = [cell for cell in notebook.cells if words in cell.source]
        cell.source = cell.source.replace(words, fewer)
    notebook.cells.append(nbformat.v4.new_code_cell(facts))
    place = folder / "docs" / "notebooks"
    place.mkdir(parents=True, exist_ok=True)
    for name in ("crates", "docs/data"):
        if not (folder / name).exists():
            (folder / name).symlink_to(REPOSITORY / name)
    # The figures are those of a notebook, not those of a program without a screen.
    environment = {name: value for name, value in os.environ.items() if name != "MPLBACKEND"}
    client = NotebookClient(
        notebook, kernel_manager_class=Manager, timeout=timeout_s, resources={"metadata": {"path": str(place)}}
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
    notebook = executed(path, tmp_path, FACTS.get(path.stem, ""), SMALLER.get(path.stem, ()), TIMEOUT_S)
    warnings = [one.text for cell in notebook.cells for one in cell.get("outputs", []) if one.get("name") == "stderr"]
    # Mitsuba may write there, and tqdm misses ipywidgets; other warnings of Python name their class.
    assert not [text for text in warnings if "Warning" in text and "TqdmWarning" not in text]
    picture = plt.imread(io.BytesIO(gallery_picture(notebook)))[..., :3]
    assert min(picture.shape[:2]) >= 250 and picture.std() > 0.05


def main(folder, names):
    folder.mkdir(parents=True, exist_ok=True)
    for path in RUN_HERE:
        if names and path.stem not in names:
            continue
        with tempfile.TemporaryDirectory() as temporary:
            notebook = executed(path, Path(temporary))
        file = folder / f"gallery_{path.stem}.png"
        file.write_bytes(gallery_picture(notebook))
        print(f"{file}: {file.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
