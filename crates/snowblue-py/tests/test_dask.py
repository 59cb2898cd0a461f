"""Arrays of dask, whose results are computed by blocks, here and on a cluster of two workers, of which one is killed.

Skipped, by name, where dask.distributed is missing.
"""

import os
import pickle
import signal
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import snowblue
from snowblue import _native

distributed = pytest.importorskip("distributed", reason="dask.distributed is missing: lazy arrays are not tested")

dask = pytest.importorskip("dask")

da = pytest.importorskip("dask.array")

PITS, ROWS = 400, 10
FREE = 10
"""Number of blocks that are computed before the worker is killed."""
# A busy machine starts workers slowly.
TIMEOUT_S = 300
NM = [450.0, 650.0, 1030.0]


def drawn(count):
    """Snow pits, with labels and a further coordinate."""
    draw = np.random.default_rng(1)
    ranges = {
        "ssa": (5, 80), "density": (80, 500), "soot": (0, 50), "thickness": (1, 50), "angle": (0, 80),
        "ground": (0, 1), "size": (120, 480),
    }
    pits = xr.Dataset({name: ("pit", draw.uniform(*ends, count)) for name, ends in ranges.items()})
    return pits.assign_coords(pit=np.arange(count) + 7, height=("pit", draw.uniform(0, 4000, count)))


def spectrum(pits, **keywords):
    return snowblue.spectrum(
        ssa_m2_kg=pits.ssa, density_kg_m3=pits.density, impurities_ng_g={"black-carbon": pits.soot},
        thickness_cm=pits.thickness, angle_deg=pits.angle,
        **{"wavelength_nm": NM, "ground_albedo": pits.ground} | keywords)


def look_up(pits):
    # The table holds this snow.
    return snowblue.Database.embedded().look_up(
        grain_size_um=pits["size"], density_kg_m3=pits.density.clip(210, 390), thickness_cm=pits.thickness,
        angle_deg=pits.angle)


def albedo(pits):
    return snowblue.albedo(
        ssa_m2_kg=pits.ssa, density_kg_m3=pits.density, impurities_ng_g={"black-carbon": pits.soot}, angle_deg=60,
        wavelength_nm=[450, 1030])


def aged(pits):
    return snowblue.aged_ssa(ssa_m2_kg=pits.ssa, age_h=[1, 24, 168], temperature_c=-pits.angle / 2)


@pytest.fixture
def nothing_runs():
    """Within it dask computes nothing, and no slab is solved."""

    def refuse(*_, **__):
        raise AssertionError("dask computes something")

    return dask.config.set(scheduler=refuse)


@pytest.fixture
def solved_rows(monkeypatch):
    """The numbers of the slabs and spectra that are solved together."""
    rows = []

    def counted(name):
        function = getattr(_native, name)

        def count(snows, cases, *others):
            rows.append(len(cases["places"]))
            return function(snows, cases, *others)

        monkeypatch.setattr(_native, name, count)

    for name in ("spectrum", "spread", "invert"):
        counted(name)
    return rows


@pytest.mark.parametrize("chunks", [{"pit": 5}, {"pit": (1, 8, 3)}, {"pit": 12}])
@pytest.mark.parametrize("solve", [spectrum, albedo, look_up, aged])
def test_lazy_results_are_those_of_arrays_in_memory(solve, chunks, nothing_runs, solved_rows):
    pits = drawn(12)
    at_once = solve(pits)
    solved_rows.clear()
    with nothing_runs:
        later = solve(pits.chunk(chunks))
    assert not any(solved_rows)
    arrays = later.data_vars.values() if isinstance(later, xr.Dataset) else [later]
    widths = pits.chunk(chunks).chunks["pit"]
    assert all(array.chunksizes["pit"] == widths for array in arrays)
    # Bits, attributes, labels and coordinates.
    xr.testing.assert_identical(later.compute(), at_once)
    if solve in (spectrum, albedo):
        assert sorted(rows for rows in solved_rows if rows) == sorted(widths)
    assert [array.dtype for array in arrays] == [array.compute().dtype for array in arrays]
    xr.testing.assert_identical(pickle.loads(pickle.dumps(later)).compute(), at_once)


@pytest.mark.parametrize("keywords", [
    {"jacobian": ["ssa_m2_kg", "black-carbon", "cos_angle"]},
    {"standard_errors": False},
    {"plus_minus": {"ssa_m2_kg": 2, "ice": True}, "standard_errors": False},
    {"engine": "montecarlo", "rays": 200},
    {"ground_albedo": 0.4},
    {"ground_albedo": 0.4, "engine": "montecarlo", "rays": 200},
])
def test_all_kinds_of_spectra_are_lazy(keywords, nothing_runs):
    pits = drawn(5)
    with nothing_runs:
        later = spectrum(pits.chunk(pit=2), **keywords)
    xr.testing.assert_identical(later.compute(), spectrum(pits, **keywords))


def test_one_ground_is_that_of_all_blocks(nothing_runs):
    pits = drawn(4)

    def solve(pits, ground):
        return snowblue.albedo(ssa_m2_kg=pits.ssa, thickness_cm=2, ground_albedo=ground, wavelength_nm=450)

    with nothing_runs:
        later = solve(pits.chunk(pit=2), 0.4).compute
    at_once = solve(pits, 0.4)
    xr.testing.assert_identical(later(), at_once)
    assert (at_once > solve(pits, 0.0)).all()


def test_lazy_arrays_are_broadcast_with_others(nothing_runs):
    """With arrays in memory on the same axis or another, lists, tuples, words and series of pandas."""
    pits = drawn(6)
    index = pd.Series(pits.density.values, pd.Index(pits.pit.values, name="pit"))
    grid = xr.DataArray(np.linspace(5, 60, 12).reshape(6, 2), dims=("pit", "layer"))

    def solve(chunk):
        return snowblue.spectrum(
            ssa_m2_kg=chunk(grid), density_kg_m3=index, facetness=(0.2, 0.4, 0.3, 0.05),
            ice=["warren2008", "picard2016"],
            thickness_cm=[5, 20], angle_deg=chunk(pits.angle), standard_errors=False,
            wavelength_nm=xr.DataArray(NM, dims="channel", coords={"channel": ["blue", "red", "infrared"]}))

    with nothing_runs:
        later = solve(lambda array: array.chunk(pit=4, **({"layer": 1} if "layer" in array.dims else {})))
    assert later.reflectance.dims == ("pit", "layer", "ice", "thickness", "channel")
    assert later.reflectance.chunksizes["pit"] == (4, 2) and later.reflectance.chunksizes["layer"] == (1, 1)
    xr.testing.assert_identical(later.compute(), solve(lambda array: array))


def test_wavelengths_stay_together():
    """The rays through grains are those of indices of refraction among all wavelengths."""
    wavelengths = xr.DataArray(np.arange(400.0, 701, 10), dims="wavelength")
    later = snowblue.spectrum(ssa_m2_kg=drawn(3).ssa.chunk(pit=2), wavelength_nm=wavelengths.chunk(wavelength=10))
    assert later.reflectance.chunksizes["wavelength"] == (31,)
    xr.testing.assert_identical(
        later.compute(), snowblue.spectrum(ssa_m2_kg=drawn(3).ssa, wavelength_nm=wavelengths.values))


def test_arrays_of_dask_alone_make_axes_without_an_index(nothing_runs):
    ssa = drawn(6).ssa.values
    with nothing_runs:
        later = snowblue.spectrum(ssa_m2_kg=da.from_array(ssa, chunks=4), wavelength_nm=NM)
        assert "specific_surface_area" not in later.indexes
    at_once = snowblue.spectrum(ssa_m2_kg=ssa, wavelength_nm=NM)
    xr.testing.assert_identical(later.compute().set_xindex("specific_surface_area"), at_once)


def test_results_that_are_not_known_yet_may_be_arguments(nothing_runs):
    """Further coordinates that are not known yet stay if they are those of one array."""
    pits = drawn(4)
    pits["height"] = pits.height.chunk(pit=2)
    ssa = pits.ssa.chunk(pit=2)
    with nothing_runs:
        area = snowblue.aged_ssa(ssa_m2_kg=ssa.data, age_h=[1, 24])
        later = snowblue.albedo(ssa_m2_kg=area, wavelength_nm=NM)
        same = snowblue.albedo(ssa_m2_kg=ssa, density_kg_m3=pits.density.chunk(pit=2), wavelength_nm=NM)
        other = pits.density.assign_coords(height=2 * pits.height)
        different = snowblue.albedo(ssa_m2_kg=ssa, density_kg_m3=other, wavelength_nm=NM)
    assert later.dims == ("new_snow", "age", "wavelength") and "height" in same.coords
    assert "height" not in different.coords and "pit" in different.coords
    np.testing.assert_array_equal(
        later, snowblue.albedo(ssa_m2_kg=snowblue.aged_ssa(ssa_m2_kg=pits.ssa.values, age_h=[1, 24]), wavelength_nm=NM))


def test_bands_of_lazy_spectra_are_lazy(nothing_runs):
    pits = drawn(4)
    wavelength_nm = np.arange(400, 701, 20)
    with nothing_runs:
        later = snowblue.bands(spectrum(pits.chunk(pit=2), wavelength_nm=wavelength_nm), "visible")
    # Sums may have another order.
    at_once = snowblue.bands(spectrum(pits, wavelength_nm=wavelength_nm), "visible")
    xr.testing.assert_allclose(later.compute(), at_once, rtol=1e-12)


@pytest.fixture(scope="module")
def measured():
    """Albedos with gaps."""
    pits = drawn(7)
    solved = snowblue.albedo(ssa_m2_kg=pits.ssa, angle_deg=pits.angle, wavelength_nm=np.arange(400, 1401, 100))
    return solved.where(solved.pit != 9).where((solved.pit != 12) | (solved.wavelength > 700))


@pytest.mark.parametrize("chunks", [{"pit": 3}, {"pit": 2, "wavelength": 4}])
@pytest.mark.parametrize(("keywords", "scaled"), [
    ({}, ()),
    ({"scale_error": 0.01, "retrieve": ("ssa_m2_kg", "density_kg_m3"), "angle_deg": 60}, ("standard_deviation",)),
    ({"layers": [{"thickness_cm": 3, "snow": "fresh"}, {"thickness_cm": 30}], "retrieve": [("ssa_m2_kg", 0)]},
     ("diffuse_fraction",)),
])
def test_lazy_spectra_are_inverted_later(measured, chunks, keywords, scaled, nothing_runs, solved_rows):
    def solve(albedo):
        return snowblue.invert(albedo, **keywords, **{name: albedo * 0.01 + 0.001 for name in scaled})

    at_once = solve(measured)
    solved_rows.clear()
    with nothing_runs:
        later = solve(measured.chunk(chunks))
    assert not any(solved_rows) and later.chunksizes["wavelength"] == (11,)
    assert {name: array.dtype.kind for name, array in later.items()} == {
        name: array.dtype.kind for name, array in at_once.items()}
    if "angle_deg" not in keywords:
        # The light is said in words, of angles that are not known yet.
        assert later.light.startswith("beams or diffuse light at several angles")
        later.attrs["light"] = at_once.light
    xr.testing.assert_identical(later.compute(), at_once)
    assert sorted(rows for rows in solved_rows if rows) == sorted(later.chunksizes["pit"])


def test_blocks_that_lack_other_wavelengths_differ_by_a_part_of_the_deviation(measured):
    """Other rays through grains have errors of some per thousand, as the standard errors of spectra say; the standard
    deviation here is some per cent."""
    nm = measured.wavelength
    gaps = measured.isel(pit=slice(3)).where((measured.pit != 7) | (nm > 700)).where((measured.pit != 8) | (nm < 1100))
    keywords = {"angle_deg": 60, "standard_deviation": 0.01}
    at_once, later = (snowblue.invert(given, **keywords) for given in (gaps, gaps.chunk(pit=1)))
    assert (abs(later.ssa - at_once.ssa) < 0.1 * at_once.ssa_sd).all()


def test_lazy_fluxes_and_bands_are_inverted(nothing_runs):
    solved = snowblue.layers(
        [dict(thickness_cm=30, ssa_m2_kg=20)], depth_cm=[2, 5], wavelength_nm=np.arange(400, 1001, 100),
        angle_deg=[60, 70, 80], standard_errors=False)

    def from_fluxes(fluxes):
        return snowblue.invert(fluxes=fluxes, fluxes_standard_deviation=0.01, thickness_cm=30, retrieve="ssa_m2_kg")

    bands = {"visible": (np.arange(400, 701, 50), np.ones(7)), "infrared": ([800, 900, 1000], [0, 1, 0])}
    fraction = xr.DataArray([0.3, 0.1], dims="wavelength", coords={"wavelength": [400, 1000]})
    means = snowblue.bands(
        snowblue.albedo(ssa_m2_kg=[15, 30, 60], angle_deg=50, wavelength_nm=np.arange(400, 1001, 10)), bands)

    def from_bands(means):
        return snowblue.invert(
            means, bands=bands, angle_deg=50, diffuse_fraction=fraction.chunk() if means.chunks else fraction)

    for solve, given, chunks in (
        (from_fluxes, solved[["down", "up"]], {"angle": 2, "depth": 1}),
        (from_bands, means, {"specific_surface_area": 2, "band": 1}),
    ):
        with nothing_runs:
            later = solve(given.chunk(chunks))
        at_once = solve(given)
        later.attrs["light"] = at_once.light
        xr.testing.assert_identical(later.compute(), at_once)


@pytest.mark.parametrize(("name", "value", "words"), [
    ("density", 1200, r"density is 1200 kg/m³, but must lie in 10–900 kg/m³, at pit\[9\]"),
    ("thickness", -1, r"thickness is -1 cm, but must lie in 0–100000 cm, at pit\[9\]"),
    ("angle", -5, r"angle is -5°, .*at pit\[9\]"),
])
def test_a_wrong_value_is_named_when_its_block_is_computed(name, value, words):
    pits = drawn(12)
    pits[name][9] = value
    for chunks in (5, 9, 1):
        later = spectrum(pits.chunk(pit=chunks))
        # The other blocks are computed.
        assert later.isel(pit=slice(0, 5)).compute().reflectance.notnull().all()
        with pytest.raises(ValueError, match=words):
            later.compute()
    with pytest.raises(ValueError, match=words):
        spectrum(pits)


def test_wrong_spectra_and_look_ups_are_named_too(measured):
    wrong = measured.copy(deep=True)
    wrong[5, 3] = 4
    for given in (wrong, wrong.chunk(pit=2)):
        with pytest.raises(ValueError, match=r"albedo is 4, but must lie in -0.5–1.5, at pit\[5\], wavelength\[3\]"):
            snowblue.invert(given).compute()
    pits = drawn(6)
    pits["size"][4] = 2000
    for given in (pits, pits.chunk(pit=3)):
        with pytest.raises(ValueError, match=r"grain size is 2000 µm, but the table covers 100–500 µm, at pit\[4\]"):
            look_up(given).compute()


@pytest.mark.parametrize(("keywords", "words"), [
    ({"jacobian": "size"}, "parameter 'size' is not known"),
    ({"streams": 7}, "streams are 7"),
    ({"progress": print}, "dask has a bar of its own"),
    ({"ssa_m2_kg": "x"}, "ssa_m2_kg is 'x'"),
    ({"size_measure": ["volume-diameter", 3]}, r"size_measure is 3.*, at size_measure\[1\]"),
])
def test_options_are_checked_at_once(keywords, words):
    with pytest.raises(ValueError, match=words):
        snowblue.spectrum(density_kg_m3=drawn(4).density.chunk(pit=2), **keywords)


def test_arrays_of_dask_have_numbers_and_known_sizes():
    with pytest.raises(ValueError, match="chunks of unknown sizes"):
        array = da.from_array(np.arange(5.0) * 100)
        snowblue.albedo(density_kg_m3=array[array > 100])
    with pytest.raises(ValueError, match="thickness is an array of dask of the type object"):
        snowblue.spectrum(thickness_cm=da.from_array(np.array([1, None], dtype=object), chunks=1))


def test_memory_is_that_of_a_block():
    """The peak of 60,000 pits, of which only the means are kept, is below half of that in one piece."""
    code = """if True:
        import re, sys, dask, dask.array as da, xarray as xr, snowblue
        def draw(low, high, seed):
            return "pit", da.random.default_rng(seed).uniform(low, high, 60_000, chunks=500)
        pits = xr.Dataset({"ssa": draw(5, 80, 1), "density": draw(80, 500, 2)})
        pits = pits if sys.argv[1] == "later" else pits.compute()
        def peak_kib():
            return int(re.search("VmHWM:[^0-9]*([0-9]+)", open("/proc/self/status").read())[1])
        snowblue.albedo(density_kg_m3=[200, 300], wavelength_nm=[450, 1030])
        before = peak_kib()
        albedo = snowblue.albedo(ssa_m2_kg=pits.ssa, density_kg_m3=pits.density, wavelength_nm=[450, 1030])
        with dask.config.set(scheduler="threads", num_workers=2):
            mean = albedo.mean("pit").compute()
        print(peak_kib() - before, *mean.values)
    """
    found = []
    for when in ("later", "at once"):
        done = subprocess.run([sys.executable, "-c", code, when], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        found.append([float(word) for word in done.stdout.split()])
    (later, *means), (at_once, *others) = found
    assert later < at_once / 2
    np.testing.assert_allclose(means, others, rtol=1e-12)


@pytest.fixture
def pits(tmp_path):
    pits = drawn(PITS)
    pits.to_netcdf(tmp_path / "pits.nc")
    return pits, str(tmp_path / "pits.nc")


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    comm = {f"distributed.comm.timeouts.{name}": f"{TIMEOUT_S}s" for name in ("connect", "tcp")}
    with (
        dask.config.set(comm),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, env={"RAYON_NUM_THREADS": "1"}, dashboard_address=None,
            local_directory=str(tmp_path_factory.mktemp("workers")),
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def held(block, block_info=None):
    """A block, after the first ones not before a worker has been killed."""
    if block_info[None]["chunk-location"][0] >= FREE:
        distributed.Event("held").set()
        assert distributed.Event("killed").wait(TIMEOUT_S)
    return block


def test_a_killed_worker_costs_no_pit(pits, client):
    pits, path = pits
    with xr.open_dataset(path, chunks={"pit": ROWS}) as file:
        gated = file.assign(ssa=file.ssa.copy(data=file.ssa.data.map_blocks(held, dtype=float)))
        later = client.compute(albedo(gated).data)
        assert distributed.Event("held").wait(TIMEOUT_S)
        victim = next(iter(client.run(os.getpid).values()))
        os.kill(victim, signal.SIGKILL)
        assert not later.done()
        distributed.Event("killed").set()
        # The victim's finished blocks are lost with it, and computed again.
        np.testing.assert_array_equal(later.result(TIMEOUT_S), albedo(pits))
    assert victim not in client.run(os.getpid).values()


def test_look_ups_and_retrievals_run_on_workers(pits, client):
    some = pits[0].isel(pit=slice(0, 40))
    xr.testing.assert_identical(look_up(some.chunk(pit=15)).compute(), look_up(some))
    spectra = snowblue.albedo(ssa_m2_kg=some.ssa, wavelength_nm=[450, 850, 1030])
    fit = snowblue.invert(spectra.chunk(pit=15)).compute()
    np.testing.assert_array_equal(fit.ssa, snowblue.invert(spectra).ssa)


def test_a_wrong_row_is_named_by_the_client(pits, client):
    pits[0].density[150] = 1200
    with pytest.raises(ValueError, match=r"density is 1200 kg/m³.*, at pit\[150\]"):
        albedo(pits[0].chunk(pit=ROWS)).compute()


def test_scenes_and_tables_reach_the_workers(client):
    table = snowblue.Database.embedded()
    there = client.submit(lambda given: given.look_up(thickness_cm=10).transmittance.values, table).result()
    np.testing.assert_array_equal(there, table.look_up(thickness_cm=10).transmittance)
    scene = snowblue.Scene(camera={"position": [0, -1, 1], "look_at": [0, 0, 0]}, sky={"sun": {"elevation_deg": 30}})
    assert client.submit(lambda given: given.description, scene).result() == scene.description


def test_the_page_on_clusters_runs(blocks, pits, tmp_path, monkeypatch):
    [block] = blocks("docs/src/clusters.md", [('chunks={"pit": 1000}', 'chunks={"pit": 100}')])
    (tmp_path / "page.py").write_text(block)
    monkeypatch.syspath_prepend(str(tmp_path))
    import page as code

    code.main(pits[1], str(tmp_path / "albedo.nc"))
    with xr.open_dataset(tmp_path / "albedo.nc") as solved:
        assert solved.albedo.sizes == {"pit": PITS, "wavelength": 11} and solved.albedo.notnull().all()
        alone = snowblue.albedo(
            ssa_m2_kg=pits[0].ssa[:5], density_kg_m3=pits[0].density[:5], angle_deg=60,
            impurities_ng_g={"black-carbon": pits[0].soot[:5]}, wavelength_nm=range(400, 1401, 100))
        np.testing.assert_array_equal(solved.albedo[:5], alone)


def test_own_particles_are_known_in_other_processes():
    table = {"wavelength_nm": [300, 2500], "absorption_m2_kg": [300, 100]}
    name = snowblue.substance("dust-of-workers", table)
    amounts = xr.DataArray(da.from_array(np.array([500.0, 9000.0]), chunks=1), dims="pit")
    later = snowblue.albedo(impurities_ng_g={name: amounts}, wavelength_nm=500)
    now = snowblue.albedo(impurities_ng_g={name: amounts.compute()}, wavelength_nm=500)
    np.testing.assert_array_equal(later.compute(scheduler="processes"), now)
    assert now[1] < now[0] - 0.01
