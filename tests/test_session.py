"""The one driver: turns come one by one, each goes to all sinks, and memory holds one of them."""

from __future__ import annotations

import gc
import time
import weakref
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_array_equal

import seamap_rt as sr
from seamap_rt.dataset import check
from seamap_rt.interferometry import open_echoes
from seamap_rt.scene import Scene, load_scene
from seamap_rt.session import FileSink, FinishedTurn, deliver, iterate
from seamap_rt.session.driver import real_time_factor, warm_wall
from seamap_rt.session.simulating import run_store
from seamap_rt.session.whole_run import TurnMemory
from seamap_rt.simulation import Simulator

TURNS = 4


def scene() -> Scene:
    """A dozen degrees of sea out to 60 m, by the horizon tracer."""
    small = {
        "radar.range_m": [15.0, 60.0],
        "radar.sector_deg": [260.0, 272.0],
        "tracing.tracer": "horizon",
        "sea.extent_m": 180.0,
        "turns": TURNS,
    }
    return load_scene("tiny", overrides=small)


@pytest.fixture(scope="module")
def finished() -> list[FinishedTurn]:
    return list(iterate(scene()))


def test_maps_and_truth_in_memory_are_those_of_the_files(finished: list[FinishedTurn], tmp_path: Path) -> None:
    kept, read = TurnMemory(finished), TurnMemory(finished, most_bytes=0.0)
    deliver(kept, [store_sink(tmp_path)])
    assert len(list(read)) == TURNS
    with kept.maps_and_truth(tmp_path / "nosuch") as here, read.maps_and_truth(tmp_path) as there:
        for one, other in zip(here, there, strict=True):
            xr.testing.assert_equal(one, other)
            assert one["polar"].sizes["turn"] == TURNS


class Failing:
    """Takes so many turns, and raises at the next one."""

    stage = "write"

    def __init__(self, takes: int, error: BaseException) -> None:
        self.takes, self.error, self.taken = takes, error, 0

    def turn(self, turn: FinishedTurn) -> None:
        if self.taken == self.takes:
            raise self.error
        self.taken += 1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass


def store_sink(folder: Path) -> FileSink:
    parts = ("echoes", "truth", "maps")
    store = run_store(folder, ["truth.nc", "maps.nc"])
    return FileSink(store, lambda turn: {name: getattr(turn, name) for name in parts})


# ---------------------------------------------------------------------------------------------------------- iterate


def test_iterate_is_public() -> None:
    assert sr.iterate is iterate


def test_turns_are_simulated_when_they_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    simulated, turn = [], Simulator.turn

    def noted(self: Simulator, number: int, *told: Any) -> Any:
        simulated.append(number)
        return turn(self, number, *told)

    monkeypatch.setattr(Simulator, "turn", noted)
    turns = iterate(scene())
    for number in range(2):
        assert next(turns).number == number
        assert simulated == list(range(number + 1))


def test_finished_turns_are_whole(finished: list[FinishedTurn]) -> None:
    assert [turn.number for turn in finished] == list(range(TURNS))
    for turn in finished:
        assert turn.maps is not None
        check("echoes", turn.echoes)
        for group in ("polar", "ground"):
            for product, tree in (("maps", turn.maps), ("truth", turn.truth)):
                dataset = tree[group].to_dataset()
                check(f"{product}/{group}", dataset)
                assert_array_equal(dataset["turn"].values, [turn.number])
        assert turn.timing["total"] >= sum(turn.timing[step] for step in ("sea", "mesh", "trace", "retrieve"))
        assert turn.counts["facets"] > 1000
        assert turn.counts["rays"] == 0  # the horizon tracer shoots none
        assert turn.counts["ground_cells"] == np.isfinite(turn.maps["ground"]["time"]).sum()


def test_a_turn_is_what_simulator_and_retrieval_make_of_it(finished: list[FinishedTurn]) -> None:
    alone = Simulator(scene()).turn(2)
    assert alone.echoes["voltage"].values.tobytes() == finished[2].echoes["voltage"].values.tobytes()
    maps = sr.retrieve(alone.echoes)
    assert finished[2].maps is not None
    for group in ("polar", "ground"):
        xr.testing.assert_equal(maps[group].to_dataset(), finished[2].maps[group].to_dataset())


def test_without_retrieval_there_are_no_maps_and_the_echoes_are_the_same(finished: list[FinishedTurn]) -> None:
    progress: list[str] = []
    turn = next(iterate(scene(), retrieved=False, progress=progress.append))
    assert turn.maps is None
    assert "retrieve" not in turn.timing
    assert "ground_cells" not in turn.counts
    assert turn.echoes["voltage"].values.tobytes() == finished[0].echoes["voltage"].values.tobytes()
    stages = ("calibrate", "mesh", "sea", "mesh", "trace", "echoes", "truth")
    assert progress == [f"turn 1 of {TURNS}: {stage}, … left" for stage in stages]


def test_turns_ahead_are_the_same_and_one_by_one(finished: list[FinishedTurn], monkeypatch: pytest.MonkeyPatch) -> None:
    simulated, turn = [], Simulator.turn

    def noted(self: Simulator, number: int, *told: Any) -> Any:
        simulated.append(number)
        return turn(self, number, *told)

    monkeypatch.setattr(Simulator, "turn", noted)
    for number, made in enumerate(iterate(scene(), ahead=True)):
        assert made.number == number
        assert simulated == list(range(min(number + 2, TURNS)))
        assert made.maps is not None
        alone = finished[number].maps
        assert alone is not None
        for group in ("polar", "ground"):
            xr.testing.assert_equal(made.maps[group].to_dataset(), alone[group].to_dataset())
        assert made.echoes["voltage"].values.tobytes() == finished[number].echoes["voltage"].values.tobytes()
        assert made.counts == finished[number].counts
        assert {*made.timing} == {*finished[number].timing}


@pytest.mark.parametrize("error", [KeyboardInterrupt(), RuntimeError("a turn"), SystemError("exception set")])
def test_a_turn_that_is_whole_comes_before_the_error_of_the_next(
    error: BaseException, monkeypatch: pytest.MonkeyPatch
) -> None:
    turn = Simulator.turn

    def stopped(self: Simulator, number: int, *told: Any) -> Any:
        if number == 2:
            raise error
        return turn(self, number, *told)

    monkeypatch.setattr(Simulator, "turn", stopped)
    sink = Failing(TURNS, RuntimeError())
    with pytest.raises(type(error)) as raised:
        deliver(iterate(scene(), ahead=True), [sink])
    assert raised.value is error
    assert sink.taken == 2


@pytest.mark.parametrize("retrieved", [False, True])
def test_memory_holds_one_turn(retrieved: bool) -> None:
    """Neither the driver nor the delivery keeps a turn, or its arrays, when the next one is there; ahead, that one is
    simulated already."""
    alive: list[list[weakref.ref[Any]]] = []

    def watched() -> Iterator[FinishedTurn]:
        for turn in iterate(scene(), retrieved=retrieved, ahead=retrieved):
            gc.collect()  # a tree and its groups refer to one another
            assert not [ref for before in alive for ref in before if ref() is not None]
            alive.append([weakref.ref(turn), weakref.ref(turn.echoes["voltage"].values)])
            yield turn
            del turn

    figures = deliver(watched(), [Failing(TURNS, RuntimeError())])
    assert len(figures) == len(alive) == TURNS


# ------------------------------------------------------------------------------------------------------------ sinks


@pytest.mark.parametrize("behind", [False, True])
@pytest.mark.parametrize("error", [OSError("no room"), KeyboardInterrupt()])
def test_a_sink_that_raises_leaves_the_store_whole(
    finished: list[FinishedTurn], tmp_path: Path, behind: bool, error: BaseException
) -> None:
    """All products of the store end with the same turn: the last that it was given."""
    failing, store = Failing(2, error), store_sink(tmp_path)
    with pytest.raises(type(error)):
        deliver(finished, [store, failing] if behind else [failing, store])
    turns = 3 if behind else 2
    assert failing.taken == 2
    voltage = np.concatenate([turn.echoes["voltage"].values for turn in finished[:turns]])
    stored = open_echoes(tmp_path)
    assert stored.attrs["complete_turns"] == turns
    assert stored["voltage"].values.tobytes() == voltage.tobytes()
    for product in ("truth", "maps"):
        with xr.open_datatree(tmp_path / f"{product}.nc") as tree:
            for group in ("polar", "ground"):
                assert_array_equal(tree[group]["turn"].values, np.arange(turns))
    assert {path.name for path in tmp_path.iterdir()} == {"run.zarr", "maps.nc", "truth.nc"}


def test_a_first_turn_that_the_store_does_not_get_leaves_no_file(finished: list[FinishedTurn], tmp_path: Path) -> None:
    with pytest.raises(OSError, match="no room"):
        deliver(finished, [Failing(0, OSError("no room")), store_sink(tmp_path)])
    assert not list(tmp_path.iterdir())


def test_the_figures_hold_what_sinks_took(finished: list[FinishedTurn], tmp_path: Path) -> None:
    further = Failing(TURNS, RuntimeError())
    further.stage = "maps"
    figures = deliver(finished, [store_sink(tmp_path), further])
    for turn, kept in zip(finished, figures, strict=True):
        assert kept.counts == turn.counts
        assert kept.timing["write"] > 0.0
        assert kept.timing["maps"] > 0.0
        added = kept.timing["write"] + kept.timing["maps"]
        assert kept.timing["total"] == pytest.approx(turn.timing["total"] + added)


@pytest.mark.parametrize("ahead", [False, True])
def test_the_real_time_factor_times_the_wall_is_the_simulated_time(
    ahead: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Stages overlap, and sinks take their time too: the factor is of what a clock on the wall shows, from the begin of
    # the second turn on.
    begins, turn, asked = [], Simulator.turn, (TURNS - 1) * scene().turn_duration_s

    def noted(self: Simulator, number: int, *told: Any) -> Any:
        begins.append(time.perf_counter())
        return turn(self, number, *told)

    class Slow(Failing):
        def turn(self, turn: FinishedTurn) -> None:
            time.sleep(0.15)

    monkeypatch.setattr(Simulator, "turn", noted)

    def simulated() -> float:
        begins.clear()
        figures = deliver(iterate(scene(), ahead=ahead), [Slow(TURNS, RuntimeError())])
        wall = time.perf_counter() - begins[1]
        factor = real_time_factor(scene().turn_duration_s, figures)
        assert factor is not None
        assert warm_wall(figures[:1]) is None
        assert real_time_factor(1.0, figures[:1]) is None
        return factor * wall

    # 5 %: what lies between two readings of the clock. On a busy machine others come between; once of four they do not.
    assert any(simulated() == pytest.approx(asked, rel=0.05) for _ in range(4))
