"""Spectra on a cluster of two workers, of which one is killed. Skipped, by name, where dask.distributed is missing."""

import os
import re
import signal

import numpy as np
import pytest
import xarray as xr

import snowblue

distributed = pytest.importorskip("distributed", reason="dask.distributed is missing: the cluster is not tested")

dask = pytest.importorskip("dask")

PITS, ROWS = 4000, 100
FREE = 10
"""Number of blocks that are computed before the worker is killed."""
# A busy machine starts workers slowly.
TIMEOUT_S = 300


def albedo(path, first):
    if first >= FREE * ROWS:
        assert distributed.Event("killed").wait(TIMEOUT_S)
    with xr.open_dataset(path) as file:
        pits = file.isel(pit=slice(first, first + ROWS)).load()
    return _albedo(pits), os.getpid()


def _albedo(pits):
    return snowblue.albedo(
        ssa_m2_kg=pits.ssa, density_kg_m3=pits.density, impurities_ng_g={"black-carbon": pits.soot}, angle_deg=60,
        wavelength_nm=[450, 1030],
    )


@pytest.fixture
def pits(tmp_path):
    draw = np.random.default_rng(1)
    ranges = {"ssa": (5, 80), "density": (80, 500), "soot": (0, 50)}
    pits = xr.Dataset({name: ("pit", draw.uniform(*ends, PITS)) for name, ends in ranges.items()})
    pits.to_netcdf(tmp_path / "pits.nc")
    return pits, str(tmp_path / "pits.nc")


@pytest.fixture
def client(tmp_path):
    comm = {f"distributed.comm.timeouts.{name}": f"{TIMEOUT_S}s" for name in ("connect", "tcp")}
    with (
        dask.config.set(comm),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, env={"RAYON_NUM_THREADS": "1"}, dashboard_address=None,
            local_directory=str(tmp_path),
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def test_a_killed_worker_costs_no_pit(pits, client):
    pits, path = pits
    starts = range(0, PITS, ROWS)
    futures = client.map(albedo, [path] * len(starts), starts, pure=False)
    distributed.wait(futures[:FREE], timeout=TIMEOUT_S)
    victim = next(iter(client.run(os.getpid).values()))
    os.kill(victim, signal.SIGKILL)
    assert not any(future.done() for future in futures[FREE:])
    distributed.Event("killed").set()
    distributed.wait(futures, timeout=TIMEOUT_S)
    blocks, workers = zip(*client.gather(futures))
    # The victim's finished blocks are lost with it, and computed again.
    assert victim not in workers and len(blocks) == len(starts)
    joined = xr.concat(blocks, "pit", coords="minimal", compat="override", combine_attrs="override")
    np.testing.assert_array_equal(joined, _albedo(pits))


def test_scenes_and_tables_reach_the_workers(client):
    table = snowblue.Database.embedded()
    there = client.submit(lambda given: given.look_up(thickness_cm=10).transmittance.values, table).result()
    np.testing.assert_array_equal(there, table.look_up(thickness_cm=10).transmittance)
    scene = snowblue.Scene(camera={"position": [0, -1, 1], "look_at": [0, 0, 0]}, sky={"sun": {"elevation_deg": 30}})
    assert client.submit(lambda given: given.description, scene).result() == scene.description


def test_the_page_on_clusters_runs(repository, pits, tmp_path, monkeypatch):
    page = (repository / "docs" / "src" / "clusters.md").read_text()
    [block] = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (tmp_path / "page.py").write_text(block)
    monkeypatch.syspath_prepend(str(tmp_path))
    import page as code

    solved = code.main(pits[1])
    assert solved.sizes == {"pit": PITS, "wavelength": 11} and solved.notnull().all()
