"""The Python of the documents runs, each block once: that of the chapter on clusters in test_dask.py, that of the
chapter for Blender in tests_blender."""

import re
import runpy
import warnings

import matplotlib.pyplot as plt
import numpy as np

import snowblue


def test_the_readme_of_the_package_runs(blocks, repository, monkeypatch, tmp_path):
    smaller = [("width=270, height=270", "width=24, height=24, samples_per_pixel=1")]
    [block] = blocks("crates/snowblue-py/README.md", smaller)
    (tmp_path / "scenes").symlink_to(repository / "scenes")
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "README.md", "exec"), {})
    plt.close("all")


def test_the_page_for_mitsuba_runs(blocks, monkeypatch, tmp_path):
    field_and_pcasnow = blocks("docs/src/mitsuba.md", [("spp=256", "spp=8")])
    assert len(field_and_pcasnow) == 2
    monkeypatch.chdir(tmp_path)
    given = {}
    for block in field_and_pcasnow:
        exec(compile(block, "mitsuba.md", "exec"), given)
        # Blue light comes through the block.
        red, green, blue = plt.imread(tmp_path / "block.png")[140:200, 100:160].mean(axis=(0, 1))
        assert blue > green > red > 0
        (tmp_path / "block.png").unlink()


def test_the_page_for_python_runs(blocks, repository, monkeypatch, tmp_path):
    # What the page takes as given: a tetrahedron.
    given = {
        "vertices_m": 0.2 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        "triangles": np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
    }
    (tmp_path / "scenes").symlink_to(repository / "scenes")
    monkeypatch.chdir(tmp_path)
    smaller = [
        ("Database.build(", "Database.build(tally_rays=1024, "),
        ("width=270, height=270, samples_per_pixel=32", "width=24, height=24, samples_per_pixel=1"),
        ("scene.bake()", "scene.bake(step_mm=20)"),
    ]
    for block in blocks("docs/src/python.md", smaller):
        exec(compile(block, "python.md", "exec"), given)
        plt.close("all")
    assert abs(given["fit"].ssa.item() - 20) < 0.5 and abs(given["fit"].black_carbon.item() - 30) < 1
    assert given["solved"].reflectance.dims == ("pit", "angle", "wavelength")
    page = (repository / "docs" / "src" / "python.md").read_text()
    aged = given["area"].sel(age=[24, 168])
    gradient = snowblue.aged_ssa(ssa_m2_kg=60, age_h=[24, 168], temperature_c=-10, temperature_gradient=True)
    assert "become {:.1f} after a day and {:.1f} after a week".format(*aged.values) in page
    assert "they become {:.1f} and {:.1f}.".format(*gradient.values) in page
    albedo = snowblue.albedo(ssa_m2_kg=given["area"].sel(age=[0, 24, 168]), wavelength_nm=1030)
    assert "falls from {:.3f} to {:.3f}\nand {:.3f}".format(*albedo.values) in page
    assert given["baked"].objects[0].flux.shape[0] == 2 and (tmp_path / "coarse.nc").exists()


def test_the_page_on_retrieval_runs_and_prints_its_numbers(blocks, repository, monkeypatch, capsys):
    monkeypatch.chdir(repository)
    page = (repository / "docs" / "src" / "retrieval.md").read_text()
    given = {}
    for block in blocks("docs/src/retrieval.md"):
        exec(compile(block, "retrieval.md", "exec"), given)
    fit, wrong, both = given["fit"], given["wrong"], given["both"]
    check_posterior(fit, page[: page.index("## The light")])
    check_posterior(given["sensed"], page[page.index("## Bands of a sensor") : page.index("## Layers")])
    assert f"comes back as {wrong.ssa.values[0]:.1f} m²/kg" in page
    assert (fit.outcome == "converged").all() and 15 < given["clear"].ssa[0] < 25 < 40 < given["clear"].ssa[1] < 50
    # Only the product of density and thickness is determined: the variance of the density is that of its prior, 0.1².
    _, density, thickness = np.diag(both.covariance)
    assert 0.9 * 0.1**2 < density < 0.1**2 and both.covariance[1, 2] / np.sqrt(density * thickness) < -0.99
    assert abs(both.ssa - 25) < 0.1
    for row, name in (
        ("SSA of the upper layer", "ssa_0"), ("SSA of the lower layer", "ssa_1"), ("soot in both", "black_carbon")
    ):
        [line] = [line for line in page.splitlines() if line.startswith(f"| {row} |")]
        for found in (given["above"], given["below"]):
            assert f"| {found[name].item():.1f} ± {found[f'{name}_sd'].item():.1f} |" in line, line
    printed = capsys.readouterr().out
    check_melting_snow(given, page[page.index("## Melting snow") : page.index("## Many spectra")], printed)
    # The priors that the page lists.
    every = [name for name in re.findall(r"`([a-z0-9_-]+)`", page[page.index("| parameter |"):page.index("## Bands")])]
    arguments = dict(angle_deg=60, thickness_cm=10, ground_albedo=0.3, retrieve=every)
    for prior in snowblue.invert([0.9, 0.5], [450, 1030], **arguments).prior.split("; "):
        name, median, deviation = re.fullmatch(r"(.*): median (.*), deviation (.*)", prior).groups()
        [row] = [line for line in page.splitlines() if line.startswith("| `") and f"`{name}`" in line]
        assert f"| {median.replace('of the argument', 'the argument')} " in row and f"| {deviation}" in row, prior


def check_melting_snow(given, section, printed):
    """The tables and the text on melting snow."""
    dry, wet, liquid = given["dry"], given["wet"], given["liquid"]
    for sample in given["samples"]:
        [line] = [line for line in section.splitlines() if line.startswith(f"| {sample}") and line.count("|") == 8]
        own, ends = wet.sel(sample=sample), (liquid.sel(sample=sample).min(), liquid.sel(sample=sample).max())
        cells = [f"{(one.chi_square / one.data).sel(sample=sample).item():.2f}" for one in (dry, wet)]
        cells += [f"{own[name].item():.{digits}f} ± {own[name + '_sd'].item():.{digits}f}"
                  for name, digits in (("ssa", 1), ("water_saturation", 3), ("albedo_scale", 2))]
        cells.insert(4, "–".join(f"{end.item():.3f}" for end in ends))
        assert line.split(" | ", 1)[1] == " | ".join(cells) + " |"
    assert (wet.chi_square < 0.5 * dry.chi_square).all() and (wet.outcome == "converged").all()
    assert dry.outcome.sel(sample="mSnw09") == "ssa_m2_kg is at an end of its range"
    saturation = given["guessed"].water_saturation
    assert (saturation[-1] > 9 * saturation[0]).all() and 5 < wet.ssa[0] / wet.ssa[-1] < 6
    # A beam from the zenith.
    assumed = given["assumed"] | {"angle_deg": 0, "retrieve": ["ssa_m2_kg", "black-carbon", "water_saturation"]}
    above = snowblue.invert(given["near"].sel(sample="mSnw01a"), **assumed)
    assert f"{(above.ssa / wet.ssa[0]).item():.1f} times as great" in section
    for line in printed.splitlines()[-3:]:
        start, end, measured, predicted = line.split()
        assert f"| {start}–{end} nm | {float(measured):.3f} | {float(predicted):.3f} |" in section


def check_posterior(fit, section):
    """The table of two snows with soot."""
    number = r"([0-9.]+)"
    for place, (area, soot) in enumerate((("SSA 20 m²/kg", "soot 15 ng/g, in the first"),
                                          ("SSA 45 m²/kg", "soot 15 ng/g, in the second"))):
        at = fit.isel(specific_surface_area=place)
        for row, name in ((area, "ssa"), (soot, "black_carbon")):
            printed = re.search(rf"\| {row} \| {number} \| {number}–{number} \| {number} \|", section)
            kernel = at.averaging_kernel.sel(parameter=name, true_parameter=name)
            values = [at[name], at[f"{name}_lower"], at[f"{name}_upper"], kernel]
            assert [f"{value.item():.{digits}f}" for value, digits in zip(values, (1, 1, 1, 2))] == [*printed.groups()]


def test_the_albedos_of_other_models_are_those_of_the_book(repository):
    page = (repository / "docs" / "src" / "how_good_it_is.md").read_text()
    compare = runpy.run_path(str(repository / "scripts" / "compare"))
    with warnings.catch_warnings():
        # PythonicDISORT warns of albedos near 1.
        warnings.simplefilter("ignore")
        nm, albedos, single = compare["beside_tartes"]()
        beside_snicar = compare["beside_snicar"]()
    for row in compare["rows"](compare["BESIDE_TARTES"], nm, albedos, (800, 1300)):
        assert row in page
    off = {angle: of["TARTES"] - of["its grains, 32 streams"] for angle, of in albedos.items()}
    assert all(abs(of["snowblue"] - of["our grains, 32 streams"]).max() < 2e-5 for of in albedos.values())
    near = nm <= 1300
    assert f"{max(one[near].max() for one in off.values()):.3f}" == "0.011"
    assert f"{min(one[near].min() for one in off.values()):.3f}" == "-0.035"
    assert 8.5 < max((of["TARTES"] / of["its grains, 32 streams"]).max() for of in albedos.values()) < 9
    coalbedos = [np.array([one[0] for one in single[name]])[near] for name in ("ours", "theirs")]
    assert abs(coalbedos[0] / coalbedos[1] - 1).max() < 0.03
    asymmetry = single["medium"].asymmetry.values[near]
    assert [round(asymmetry.min(), 2), round(asymmetry.max(), 2)] == [0.68, 0.72]
    check_spheres(compare, *beside_snicar, page)
    # Reduced scattering, and the decay of light.
    for row in compare["spread_and_decay"]():
        assert row in page


def check_spheres(compare, nm, albedos, single, page):
    """The table and the text on SNICAR."""
    for row in compare["rows"](compare["BESIDE_SNICAR"], nm, albedos, (805, 1305)):
        assert row in page
    near = nm <= 1305
    spheres = single["spheres"]
    default = snowblue.single_scattering(ssa_m2_kg=single["area_m2_kg"], wavelength_nm=nm[near])
    ratio = (single["coalbedo"] / spheres.coalbedo.values)[near]
    assert (round(100 * (ratio.min() - 1)), round(100 * (ratio.max() - 1))) == (2, 6)
    assert abs(single["asymmetry"] - spheres.asymmetry.values)[near].max() < 0.005
    ratio = default.coalbedo.values / spheres.coalbedo.values[near]
    assert (round(ratio.min(), 1), round(ratio.max(), 1)) == (1.3, 1.4)
    columns = compare["BESIDE_SNICAR"]
    differences = {
        (one, other): [(of[one] - of[other])[near] for of in albedos.values()]
        for one, other in ((columns[0], columns[1]), (columns[2], columns[1]), (columns[3], columns[2]))
    }
    high, steep, low, grazing = differences[columns[0], columns[1]]
    assert [f"{one.max():.3f}" for one in (high, steep)] == ["0.009", "0.009"]
    assert [nm[one.argmax()] for one in (high, steep)] == [1205, 1305]
    assert [f"{one.min():.3f}" for one in (low, grazing)] == ["-0.018", "-0.062"]
    assert nm[low.argmin()] == nm[grazing.argmin()] == 1305
    assert f"{max(abs(one).max() for one in differences[columns[2], columns[1]]):.3f}" == "0.009"
    assert f"{max(abs(one).max() for one in differences[columns[3], columns[2]]):.3f}" == "0.018"


def test_the_page_on_tables_of_other_programs_runs(blocks, repository, monkeypatch, tmp_path):
    page = (repository / "docs" / "src" / "exchange.md").read_text()
    (tmp_path / "scenes").symlink_to(repository / "scenes")
    monkeypatch.chdir(tmp_path)
    smaller = [("scene.render(", "scene.render(width=24, height=24, samples_per_pixel=1, ")]
    [block] = blocks("docs/src/exchange.md", smaller)
    exec(compile(block, "exchange.md", "exec"), {})
    assert plt.imread(tmp_path / "tartes.png").mean() > 0.05
    theirs = snowblue.Database.open("tartes.nc").to_xarray().transmittance.sel(grain_size=400, angle=0).squeeze()
    for text, thickness_cm, printed in (
        ("1 cm 0.226 and 0.225", 1, (0.226, 0.225)), ("15 cm 0.0180 and 0.0073", 15, (0.018, 0.0073)),
        ("cm 0.0049 and 2.1·10⁻⁵", 50, (0.0049, 2.1e-5)),
    ):
        assert text in page
        np.testing.assert_allclose(theirs.sel(thickness=thickness_cm, wavelength=[450, 650]), printed, rtol=0.02)


def test_the_page_on_a_day_in_frames_runs(blocks, repository, monkeypatch, tmp_path):
    (tmp_path / "scenes").symlink_to(repository / "scenes")
    monkeypatch.chdir(tmp_path)
    opened = snowblue.Scene.open
    # A small picture with coarse cells.
    small = {"width": 24, "height": 18, "exposure": -7.0}
    monkeypatch.setattr(snowblue.Scene, "open", lambda path: opened(path).with_(
        film=small, light_field={"step_mm": 80}, integrator={"type": "diffusion", "samples_per_pixel": 1}))
    given = {}
    for block in blocks("docs/src/day_in_frames.md", [("frames = 120", "frames = 2")]):
        exec(compile(block, "day_in_frames.md", "exec"), given)
    noon, evening = (plt.imread(tmp_path / "film" / f"{frame:04}.png").mean() for frame in (0, 1))
    assert noon > 1.2 * evening > 0.1
    assert "14:00" in given["scenes"][0].to_toml() and "17:00" in given["scenes"][1].to_toml()


def test_the_page_on_the_sun_and_depth_runs_and_prints_its_numbers(blocks, repository, monkeypatch, tmp_path):
    page = (repository / "docs" / "src" / "sun_and_depth.md").read_text()
    monkeypatch.chdir(tmp_path)
    given = {}
    for block in blocks("docs/src/sun_and_depth.md"):
        exec(compile(block, "sun_and_depth.md", "exec"), given)
        plt.close("all")
    assert "<svg" in (tmp_path / "sun_and_depth.svg").read_text()
    light, day, sky = given["light"], given["day"], given["sky"]
    rows = [line.strip("| ").split("|") for line in page.splitlines() if re.match(r"\| [0-9.]+ \|", line)]
    assert len(rows) == 10
    quantities = [given[name] for name in ("par", "actinic", "e_folding_cm", "power", "warming")]
    for depth, *cells in rows:
        for cell, quantity in zip(cells, quantities):
            # Three digits.
            if cell.strip():
                assert abs(float(cell) / quantity.sel(depth=float(depth)).item() - 1) < 6e-3, (depth, cell)
    visible = slice(320, 720)
    by_light = light.absorbed.sel(wavelength=visible).integrate("wavelength")
    layers = light.layer_absorbed.sel(wavelength=visible).integrate("wavelength").sum()
    clean = [{name: value for name, value in layer.items() if name != "impurities_ng_g"} for layer in given["pack"]]
    noon = dict(given["place"], time="2026-02-01T12:00:00+01:00", wavelength_nm=light.wavelength)
    without = snowblue.light_at_depth(clean, noon, depth_cm=[20], ground_albedo=0.2)
    power, par, actinic = given["power"], given["par"], given["actinic"]
    for words, value in (
        (r"up to 720 nm bring (\S+) of", by_light.sel(depth=0)), (r"of the (\S+) W m⁻³; at 20 cm", power.sel(depth=0)),
        (r"they bring (\S+) of", by_light.sel(depth=20)), (r"they bring \S+ of (\S+)\. The pack", power.sel(depth=20)),
        (r"The pack absorbs (\S+) W", light.solar_layer_absorbed.sum()), (r"in all, and (\S+) of light", layers),
        (r"upper layer takes (\S+) W", light.solar_layer_absorbed[0]),
        (r"the lower (\S+)\. Without", light.solar_layer_absorbed[1]),
        (r"would take (\S+), and", without.solar_layer_absorbed[1]),
        (r"at 20 cm would be (\S+) instead", without.par_down[0]),
        (r"instead of (\S+) µmol", par.sel(depth=20)),
        (r"receives (\S+) % of", 100 * par.sel(depth=20) / par.sel(depth=0)),
        (r"and (\S+) times", actinic.sel(depth=20) / par.sel(depth=20)),
        (r"not become (\S+) K", given["warming"].sel(depth=0)),
        (r"(\S+) mol of photons", 1e-6 * day.par_down.sel(depth=0)),
        (r"and (\S+) mol reach", 1e-6 * day.par_actinic.sel(depth=20)),
        (r"layers take (\S+) and", 1e-6 * day.solar_layer_absorbed[0]),
        (r"layers take \S+ and (\S+) MJ", 1e-6 * day.solar_layer_absorbed[1]), (r"stands (\S+)°", sky.elevation),
        (r"receives (\S+) µmol", sky.par_direct), (r"from it and (\S+) from", sky.par_diffuse),
    ):
        printed = re.search(words, re.sub(r"\s+", " ", page))
        assert printed, words
        number = printed.group(1)
        digits = 10.0 ** -len(number.partition(".")[2]) if "." in number or number[-1] != "0" else 10.0
        assert abs(float(number) - value.item()) < 0.51 * digits, (words, number, value.item())

    kinds = ["fresh", "rounded", "wind-packed", "faceted", "melt-forms", "firn"]
    through = snowblue.spectrum(
        snow=kinds, thickness_cm=10, angle_deg="diffuse", wavelength_nm=[500, 800], standard_errors=False).transmittance
    assert "transmit 2–11 % and 0.1–5 % of diffuse light" in page
    for wavelength_nm, least, greatest in ((500, 0.02, 0.11), (800, 0.001, 0.05)):
        at = through.sel(wavelength=wavelength_nm)
        assert least < at.min() < 1.5 * least and 0.9 * greatest < at.max() < 1.05 * greatest
