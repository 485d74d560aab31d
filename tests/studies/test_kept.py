"""Points of one sea and seed share it in one process: it is drawn once, no bit of any result changes, and it goes."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from seamap_rt import resolved_scene, simulation
from seamap_rt.resolved_scene import sea_key
from seamap_rt.scene import Scene, load_scene
from seamap_rt.sea import Sea
from seamap_rt.sea.wave_trains import PlaneTrain
from seamap_rt.simulation import Simulator
from seamap_rt.studies import point, trade
from seamap_rt.studies.point import CACHE, BySea, Outcome, Task, compute
from seamap_rt.studies.sweep import Sweep

HEIGHTS = {"radar.height_m": [3.0, 5.0, 6.0]}


def small(**changes: Any) -> Scene:
    keys: dict[str, Any] = {
        "radar.range_m": [15.0, 60.0],
        "radar.sector_deg": [262.0, 270.0],
        "sea.extent_m": 180.0,
        "tracing.tracer": "horizon",
    }
    return load_scene("tiny", overrides=keys | {name.replace("__", "."): value for name, value in changes.items()})


def tasks_of(scene: Scene, vary: dict[str, list[Any]], seeds: int, folder: Path) -> list[Task]:
    return Sweep.of(scene, vary, seeds, folder).tasks


def result(outcome: Outcome) -> Outcome:
    return {name: value for name, value in outcome.items() if name != "cost"}


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Sea]:
    """The seas that are drawn from here on."""
    seas: list[Sea] = []
    draw = resolved_scene.run_sea

    def noted(scene: Scene) -> Sea:
        seas.append(draw(scene))
        return seas[-1]

    CACHE.forget()
    for module in (resolved_scene, simulation):
        monkeypatch.setattr(module, "run_sea", noted)
    return seas


@pytest.mark.parametrize(
    "changes",
    [{}, {"tracing__tracer": "facets"}, {"sea__model": "choppy", "turns": 2}, {"platform__motion": "wave_following"}],
    ids=["horizon", "rays", "choppy, two turns", "a boat on the waves"],
)
def test_a_point_after_others_has_the_bits_that_it_has_alone(
    changes: dict[str, Any], tmp_path: Path, drawn: list[Sea]
) -> None:
    tasks = tasks_of(small(**changes), HEIGHTS, 1, tmp_path)
    together = [result(compute(task)) for task in tasks]
    assert len(drawn) == 1
    assert [each["status"] for each in together] == ["done"] * 3
    for task, outcome in zip(tasks, together, strict=True):
        CACHE.forget()
        assert result(compute(task)) == outcome
    assert len(drawn) == 4
    assert len({outcome["metrics"]["height_rmse_m"] for outcome in together}) == 3


def test_voltages_too(drawn: list[Sea]) -> None:
    """Of whole turns, by rays: through scenes that held the sea as another radar saw it."""
    scenes = [small(tracing__tracer="facets", radar__height_m=height) for height in (3.0, 5.0)]
    first = Simulator(scenes[0])
    first.turn(0)
    after, alone = Simulator(scenes[1], first.sea, first.ray_scenes), Simulator(scenes[1])
    assert len(drawn) == 2
    assert after.sea is first.sea
    xr.testing.assert_identical(after.turn(0).echoes, alone.turn(0).echoes)


def test_a_sweep_draws_each_sea_once(drawn: list[Sea]) -> None:
    trade(small(), HEIGHTS, seeds=2, workers=0)
    assert len(drawn) == 2
    gone = weakref.ref(drawn.pop())
    drawn.clear()
    assert gone() is None  # and leaves none behind


@pytest.fixture
def uncollected() -> Iterator[None]:
    """Python's collector rests: what refers to itself stays."""
    gc.disable()
    yield
    gc.enable()


SHARED: list[dict[str, Any]] = [
    {},
    {"sea__model": "choppy"},
    {"tracing__tracer": "facets"},
    {"platform__motion": "wave_following", "platform__sensors.attitude_noise_deg": 0.2},
    {"sea__waves": [{"spectrum": "sinusoid", "wavelength_m": 40.0, "height_m": 0.5, "wave_from_deg": 270.0}]},
]


@pytest.mark.usefixtures("uncollected")
@pytest.mark.parametrize("changes", SHARED, ids=str)
def test_what_turns_share_goes_with_its_last_holder(changes: dict[str, Any]) -> None:
    """Nothing of a run refers to itself: its sea's memory is free when the next one's is asked for."""
    simulator = Simulator(small(**changes))
    simulator.turn(0)
    held = [weakref.ref(each) for each in (simulator, simulator.sea, simulator.installation, simulator.scenery)]
    held += [weakref.ref(train.field) for train in simulator.sea.trains if isinstance(train, PlaneTrain)]
    del simulator
    assert [each() for each in held] == [None] * len(held)


def test_other_waves_another_seed_or_a_file_written_anew_are_another_sea(tmp_path: Path) -> None:
    frequency, direction = np.arange(0.05, 0.6, 0.05), np.arange(0.0, 360.0, 30.0)
    file = tmp_path / "waves.nc"

    def written(energy: float) -> None:
        table = np.full((frequency.size, direction.size), energy)
        xr.Dataset({"efth": (("freq", "dir"), table)}, {"freq": frequency, "dir": direction}).to_netcdf(file)

    written(1e-3)
    waves = [{"spectrum": "file", "file": str(file)}]
    scene = small(sea__waves=waves)
    key = sea_key(scene)
    assert key == sea_key(small(sea__waves=waves, radar__height_m=7.0))
    for other in (small(sea__waves=waves, seed=2), small(sea__waves=waves, sea__resolution_m=1.3), small()):
        assert key != sea_key(other)
    file.unlink()
    written(2e-3)
    assert key != sea_key(scene)


def test_a_failure_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawn: list[Sea]) -> None:
    tasks = tasks_of(small(), HEIGHTS, 1, tmp_path)
    compute(tasks[0])
    with monkeypatch.context() as patch:
        patch.setattr("seamap_rt.studies.point.error_figures", lambda *_: 1 / 0)
        assert compute(tasks[1])["status"] == "failed"
    compute(tasks[2])
    assert len(drawn) == 2


def test_what_is_kept_goes_when_no_point_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(point, "IDLE_S", 0.0)
    keeper = point.SimulatorCache()
    simulator = keeper.simulator(small())
    keeper.finished(simulator)
    limit = 100
    while keeper._before is not None and limit:
        gc.collect()  # takes as long as the timer does
        limit -= 1
    assert keeper._before is None


def test_each_worker_stays_with_its_sea_as_long_as_it_has_points() -> None:
    names = [f"{sea}{number}" for number in range(3) for sea in "ab"] + ["c0"]  # seeds vary fastest
    queue = BySea(Task(name, "", {}, 1, "", name[0]) for name in names)
    given: dict[str, list[str]] = {"one": [], "two": []}
    for worker in ("one", "two", "two", "two", "one", "two", "one", "two"):
        task = queue.take(worker)
        given[worker] += [task.name] if task else []
    assert given == {"one": ["a0", "a1", "a2"], "two": ["b0", "b1", "b2", "c0"]}
    # The last sea's points are shared out among all.
    queue = BySea(Task(name, "", {}, 1, "", name[0]) for name in ("a0", "a1", "b0", "b1", "b2"))
    taken = [task.name for worker in ("one", "two", "one", "one", "two") if (task := queue.take(worker))]
    assert taken == ["a0", "b0", "a1", "b1", "b2"]
