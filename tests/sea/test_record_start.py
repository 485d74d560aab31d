"""Which moment of a recorded sea a run begins at: told, and chosen by `sea.start_s`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from known_waves import FRAMES, STEP_S, WAVE, dataset_of, rms, write

from seamap_rt.errors import InputError
from seamap_rt.report.headline import run_facts
from seamap_rt.scene import Scene
from seamap_rt.scene.model import scene_of
from seamap_rt.scene.radar_checks import record_notes
from seamap_rt.sea import direct_sum, realize
from seamap_rt.simulation import Simulator

BEGIN_S, AUTOMATIC_S = -6.0, -5.0  # of the file; 10 frames later
BEGAN = np.datetime64("2021-03-04T05:06:07.500", "ns")
AXES: dict[str, Any] = {  # of the file's times: what it holds, and the time of its first frame as `start_s` counts
    "seconds": ("time", BEGIN_S + STEP_S * np.arange(FRAMES), {"units": "s"}),
    "dates": ("time", BEGAN + (1e9 * STEP_S * np.arange(FRAMES)).astype("timedelta64[ns]")),
}
FIRST = {"seconds": BEGIN_S, "dates": 0.0}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("records")
    return {name: write(dataset_of().assign_coords(time=axis), folder / f"{name}.nc") for name, axis in AXES.items()}


def scene_with(file: str, turns: int = 1, **sea: Any) -> Scene:
    radar = {"range_m": [15.0, 40.0], "height_m": 4.0, "sector_deg": [60.0, 120.0]}
    tree = {"name": "start", "turns": turns, "radar": radar, "tracing": {"tracer": "horizon"}}
    return scene_of({**tree, "sea": {"model": "recorded", "file": file, "beyond": "level", **sea}})


@pytest.fixture(scope="module")
def whole_std(files: dict[str, str]) -> float:
    """m, of the whole record, whichever moment is time 0."""
    return realize(scene_with(files["seconds"]).sea, 1).resolved.elevation_std


@pytest.mark.parametrize(
    ("times", "later"),
    [("seconds", None), ("seconds", 2.999), ("dates", 1.137)],
)
def test_a_run_is_the_record_from_there_on(
    times: str, later: float | None, files: dict[str, str], whole_std: float
) -> None:
    """At (x, y, t) the surface is the file's at t + start, on a frame and between two: within 1e-3 of the amplitude, as
    that of `test_a_known_wave_comes_back`. Dates count from another moment, and are seconds from there on."""
    start = None if later is None else FIRST[times] + later
    sea = realize(scene_with(files[times], start_s=start).sea, 1)
    random = np.random.default_rng(3)
    x, y = random.uniform(-40.0, 40.0, (2, 300))
    t = random.uniform(0.0, sea.ends_s - 0.01, 300)
    since = 1.0 if later is None else later  # of the file's first frame, from which the wave's own time counts
    assert rms(sea.elevation(x, y, t) - WAVE.elevation(x, y, t + since)) < 1e-3 * WAVE.amplitude
    assert rms(sea.velocity(x, y, t)[..., 2] - WAVE.velocity(x, y, t + since)[..., 2]) < 2e-3 * WAVE.omega
    assert sea.ends_s == pytest.approx((FRAMES - 6) * STEP_S - since)
    assert sea.resolved.record_start_s == pytest.approx(FIRST[times] + since, abs=1e-9)
    assert sea.resolved.elevation_std == whole_std
    # Each wave of the patch by itself: their sum is the sea's at time 0, but for those that the rim makes of it.
    summed = direct_sum(sea.components(), x[:50], y[:50], np.zeros(50)).elevation
    assert rms(summed - WAVE.elevation(x[:50], y[:50], np.full(50, since))) < 0.1 * WAVE.amplitude


@pytest.mark.parametrize(("times", "later"), [("seconds", None), ("dates", 2.05)])
def test_all_that_a_run_leaves_says_it_and_the_echoes_do_not(
    times: str, later: float | None, files: dict[str, str]
) -> None:
    scene = scene_with(files[times], start_s=None if later is None else FIRST[times] + later)
    since = 1.0 if later is None else later
    words = {"seconds": f"{BEGIN_S + since:.6g} s", "dates": f"2021-03-04T05:06:{7.5 + since:06.3f}"}[times]
    simulator = Simulator(scene)
    turn = simulator.turn(0)
    for group in ("polar", "ground"):
        told = turn.truth[group].attrs
        assert (told["record_start_s"], told["record_start"]) == (pytest.approx(FIRST[times] + since), words)
    assert not any("record" in name for name in turn.echoes.attrs)
    facts = run_facts(scene, simulator.sea, simulator.surface)
    assert facts["sea"]["record_start"] == words
    assert any(f"time 0 of the run is {words} of sea.file" in row["why"] for row in facts["modelled"])
    assert any(f"time 0 of the run is its {words}" in line for line in record_notes(scene.sea, scene.radar))
    ground = turn.truth["ground"].to_dataset().isel(turn=0)
    x, y = np.meshgrid(ground["x"], ground["y"])
    right = WAVE.elevation(x, y, ground["time"].values + since)
    known = np.isfinite(ground["height"].values)
    mean = 1.0 - (WAVE.k * scene.retrieval.ground_m) ** 2 / 24.0  # of a wave over a cell, to the fourth order
    assert known.sum() > 50
    assert rms((ground["height"].values - mean * right)[known]) < 5e-3 * WAVE.amplitude


@pytest.mark.parametrize("times", AXES)
@pytest.mark.parametrize("later", [-1.0, 0.999, 4.5, 1e6])
def test_a_start_beside_the_record_is_refused_with_its_limits(times: str, later: float, files: dict[str, str]) -> None:
    low, high = (f"{FIRST[times] + limit:g}" for limit in (1.0, 4.4 - 0.1))
    counted = ", counted from 2021-03-04T05:06:07.500" if times == "dates" else ""
    with pytest.raises(
        InputError, match=rf"sea.start_s = .*: must lie within {low} and {high} s of sea.file{counted} \("
    ):
        scene_with(files[times], start_s=FIRST[times] + later)


def test_limits_that_are_named_are_taken(files: dict[str, str]) -> None:
    for start in (-5.0, -1.7):
        assert realize(scene_with(files["seconds"], start_s=start).sea, 1).resolved.record_start_s == pytest.approx(
            start
        )


def test_a_run_longer_than_what_is_left_says_how_to_shorten_it(files: dict[str, str]) -> None:
    scene = scene_with(files["seconds"], start_s=-2.0)
    with pytest.raises(InputError, match=r"turns = 1: .* or an earlier sea\.start_s"):
        Simulator(scene)


def test_only_a_recorded_sea_has_a_start() -> None:
    with pytest.raises(InputError, match=r"model = 'linear': has no record to begin in; leave start_s = 3 out"):
        scene_of({"name": "drawn", "sea": {"start_s": 3.0}})


def test_times_as_durations_are_seconds(tmp_path: Path) -> None:
    data = dataset_of().assign_coords(time=AXES["seconds"])
    store = tmp_path / "sea.zarr"
    data.assign_coords(time=("time", (data["time"].values * 1e9).astype("timedelta64[ns]"))).to_zarr(
        store, consolidated=False
    )
    assert realize(scene_with(str(store)).sea, 1).resolved.record_start_s == pytest.approx(AUTOMATIC_S)
