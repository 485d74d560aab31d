"""Sweeps in one process: what is varied, what a point is, how it ends, the table, the usable range, and resuming."""

from __future__ import annotations

import csv
import errno
import json
import shutil
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

from seamap_rt import studies
from seamap_rt.errors import InputError
from seamap_rt.interferometry import retrieve
from seamap_rt.metrics import error_figures
from seamap_rt.scene import Scene, load_scene
from seamap_rt.session import simulate
from seamap_rt.simulation import Simulator, Stopwatch
from seamap_rt.studies import point, sweep
from seamap_rt.studies.paired import Goal, means, seconds
from seamap_rt.studies.point import MANIFEST, judged
from seamap_rt.studies.sweep import Sweep, headline, trade, write_trade
from seamap_rt.studies.trade_figures import draw_pareto, draw_trade, layout, pareto_front
from seamap_rt.studies.trade_table import COST, Criterion, rows, trade_table
from seamap_rt.studies.vary import Grid, parse_varies, parse_vary

KEYS = {
    "radar.range_m": [15.0, 60.0],
    "radar.sector_deg": [262.0, 270.0],
    "sea.extent_m": 180.0,
    "tracing.tracer": "horizon",
}
VARY: dict[str, list[Any]] = {"radar.height_m": [3.0, 5.0]}


@pytest.fixture(scope="module", autouse=True)
def coarse_pictures() -> Iterator[None]:
    """Nothing here looks at pixels."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("seamap_rt.report.style.DPI", 40)
        yield


def small(**keys: Any) -> Scene:
    return load_scene("tiny", overrides=KEYS | {key.replace("__", "."): value for key, value in keys.items()})


def bits(table: xr.Dataset) -> xr.Dataset:
    return table.drop_vars(COST)


# -------------------------------------------------------------------------------------------------- what is varied


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("radar.height_m=3:20:1", list(range(3, 21))),
        ("radar.height_m=3:20:4", [3, 7, 11, 15, 19]),
        ("radar.height_m= 3 : 4 : 0.5 ", [3.0, 3.5, 4.0]),
        ("radar.baseline_m=0.1:0.4:0.1", [0.1, 0.2, 0.3, 0.4]),  # 0.1 + 0.1 + 0.1 is not 0.3 in binary
        ("radar.tilt_deg=-2:2:2", [-2, 0, 2]),
        ("radar.tilt_deg=5:5:1", [5]),
        ("radar.prf_hz=1e3:3e3:1e3", [1000.0, 2000.0, 3000.0]),
        ("radar.height_m=3,5.5,10", [3, 5.5, 10]),
        ("tracing.tracer=facets,horizon", ["facets", "horizon"]),
        ("radar.noise=true,false", [True, False]),
        ("radar.sector_deg=[0, 90],[90, 180]", [[0, 90], [90, 180]]),
        ("sea.depth_m=5,inf", [5, float("inf")]),
        ("radar.transmit=single", ["single"]),
    ],
)
def test_values_as_they_are_written(text: str, values: list[Any]) -> None:
    key, found = parse_vary(text)
    assert key == text.split("=")[0]
    assert found == values
    assert [type(value) for value in found] == [type(value) for value in values]


@pytest.mark.parametrize(
    "text",
    ["radar.height_m", "=3", "radar.height_m=", "k=3:5", "k=3:5:1:1", "k=5:3:1", "k=3:5:0", "k=3:5:-1", "k=3:nan:1",
     "k=3:inf:1", "k=a:b:c", "k=0:1:1e-9"],
)  # fmt: skip
def test_what_is_no_grid_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError, match="--vary") as refusal:
        parse_vary(text)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("varied", "seeds", "words"),
    [
        ({}, 1, "is missing"),
        ({"radar.height_m": []}, 1, "at least one value"),
        ({"radar.height_m": [3, 5, 3]}, 1, "3 is named twice"),
        ({"seed": [1, 2]}, 1, "give --seeds N"),
        ({"radar.height_m": list(range(200)), "radar.prf_hz": list(range(100))}, 1, "20000 points"),
        ({"radar.height_m": [3]}, 0, "must be at least 1"),
        ({"radar.heigt_m": [3, 5]}, 1, "did you mean height_m"),  # all points are refused: a slip of the pen
        ({"radar.height_m": [-1, -2]}, 1, "must be greater than 0"),
    ],
)
def test_impossible_sweeps_are_refused_and_leave_nothing(
    varied: dict[str, list[Any]], seeds: int, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        write_trade(small(), tmp_path / "out", varied, seeds, workers=0)
    assert not (tmp_path / "out").exists()


def test_a_key_is_varied_once() -> None:
    assert parse_varies(["a.b=1,2", "c=3"]) == {"a.b": [1, 2], "c": [3]}
    with pytest.raises(InputError, match="varied twice"):
        parse_varies(["a.b=1,2", "a.b=3"])


def test_antennas_of_their_own_cannot_be_varied_by_the_common_one() -> None:
    placed = [{"offset_m": [0.0, 0.0, 0.1 * number]} for number in range(2)]
    scene = small(radar__antennas=placed)
    with pytest.raises(InputError, match=r"radar\.antennas hold their own"):
        _ = Grid(scene, {"radar.antenna.ohmic_loss_db": [0.0, 1.0]}, [1]).points


def test_every_point_has_a_file_of_its_own() -> None:
    points = Grid(small(), {"radar.height_m": [3, 3.5], "scattering.nrcs": ["nrl", "../x y"]}, [1, 2]).points
    names = [point.name for point in points]
    assert len(set(names)) == len(points) == 8
    assert names[0] == "00000_radar.height_m=3_scattering.nrcs=nrl_seed=1"
    assert not any(set(name) & set("/ \\") for name in names)
    assert [point.index for point in points] == list(np.ndindex(2, 2, 2))


# ------------------------------------------------------------------------------------------------ the usable range


@pytest.mark.parametrize(
    ("rmse", "share", "window"),
    [
        ([0.05, 0.08, 0.10, 0.11, 0.09], [1, 1, 1, 1, 1], (0, 75)),  # an error at the limit is within it
        ([0.2, 0.05, 0.05, 0.2, 0.05], [1, 1, 1, 1, 1], (25, 75)),  # a tall mast looks over what is near
        ([0.05, 0.2, 0.05, 0.2, 0.2], [1, 1, 1, 1, 1], (0, 25)),  # of equal runs the nearest
        ([0.05] * 5, [np.nan, 0.5, 0.4, 0.3, 0.9], (25, 75)),  # a bin cut by the window, and one with too few cells
        ([0.05] * 5, [1, 1, 1, 1, 1], (0, 125)),
        ([np.nan, 0.2, 0.2, 0.2, 0.2], [0, 1, 1, 1, 1], (np.nan, 0)),
    ],
)
def test_usable_range_of_made_up_bins(rmse: list[float], share: list[float], window: tuple[float, float]) -> None:
    found = Criterion().window([12.5, 37.5, 62.5, 87.5, 112.5], rmse, share, 1.0)
    assert_array_equal(found, window)


def test_usable_range_follows_its_criterion() -> None:
    ranges, rmse, share = [12.5, 37.5, 87.5], [0.1, 0.1, 0.1], [0.5, 0.5, 0.5]
    assert Criterion().window(ranges, rmse, share, 1.0) == (0.0, 50.0)  # bins that do not touch are no run
    assert Criterion().window(ranges, rmse, share, 0.9).furthest == 0.0
    assert Criterion(error_over_height=0.2).window(ranges, rmse, share, 0.6).furthest == 50.0
    assert Criterion(known_share=0.6).window(ranges, rmse, share, 1.0).furthest == 0.0
    assert np.isnan(Criterion().window(ranges, rmse, share, 0.0)).all()  # no waves, nothing to map


# ------------------------------------------------------------------------------------------------------ the table


def outcome(rmse: float, range_m: list[float], seconds: float = 1.0) -> dict[str, Any]:
    bins = {
        name: [rmse] * len(range_m)
        for name in ("height_rmse_m", "height_bias_m", "slope_rmse", "visible_fraction", "quality")
    }
    radii = {
        "fully_measured_radius_m": 1.0 / rmse,
        "reach_m": 2.0 / rmse,
        "reach_to_the_end": 0.0,
        "gross_share": 0.0,
        "missed_share": 0.5,
    }
    return {
        "status": "done",
        "reason": "",
        "metrics": {"height_rmse_m": rmse, "height_correlation": None, **radii},
        "by_range": {"range_m": range_m, "answered": [1.0] * len(range_m), "known_share": [1.0] * len(range_m), **bins},
        "facts": {"significant_height_m": 1.0},
        "cost": {"seconds": {"total": seconds}, "peak_memory_bytes": None},
    }


def made_up(heights: int = 3, baselines: int = 2, seeds: int = 3, extra: int = 1) -> xr.Dataset:
    varied = {
        "radar.height_m": [2.0 + number for number in range(heights)],
        "radar.baseline_m": [0.1 * (number + 1) for number in range(baselines)],
        "sea.waves.0.peak_period_s": [4.0 + number for number in range(extra)],
    }
    generator = np.random.default_rng(1)
    ends = {
        at: outcome(0.02 * (1 + at[0]) + 0.01 * generator.random(), [12.5, 37.5, 62.5])
        for at in np.ndindex(heights, baselines, extra, seeds)
    }
    return trade_table(varied, list(range(1, seeds + 1)), ends, Criterion(), {"title": "made up"})


@pytest.mark.parametrize("part", ["metrics", "by_range", "facts", "status", "reason"])
def test_a_point_that_lacks_a_part_is_computed_anew(part: str, tmp_path: Path) -> None:
    task = point.Task("00000_a", "", {"radar.height_m": 3.0}, 1, str(tmp_path))
    point.keep(task, whole := outcome(0.01, [12.5, 37.5]))
    assert point.load_point(task) == (whole, "")
    content = json.loads(task.file.read_text(encoding="utf-8"))
    del content[part]
    task.file.write_text(json.dumps(content), encoding="utf-8")
    assert point.load_point(task) == (None, "is damaged or was edited")


def test_the_table_holds_each_point_in_its_place() -> None:
    varied: dict[str, list[Any]] = {"radar.height_m": [3, 5], "tracing.tracer": ["horizon", "facets"]}
    ends: dict[tuple[int, ...], dict[str, Any]] = {
        (0, 0, 0): outcome(0.01, [12.5, 37.5]),
        (0, 1, 1): outcome(0.02, [37.5, 62.5]),
        (1, 0, 0): {"status": "refused", "reason": "too low"},
        (1, 1, 1): {"status": "failed", "reason": "killed", "cost": {"seconds": {"total": 7.0}}},
    }
    table = trade_table(varied, [5, 6], ends, Criterion(), {})
    assert table["status"].dims == ("radar.height_m", "tracing.tracer", "seed")
    assert_array_equal(table["range"], [12.5, 37.5, 62.5])
    one = table.sel({"radar.height_m": 3, "tracing.tracer": "facets", "seed": 6})
    assert one["height_rmse_m"] == 0.02
    assert_array_equal(one["height_rmse_by_range_m"], [np.nan, 0.02, 0.02])
    assert (one["usable_from_m"], one["usable_range_m"], one["usable_to_the_end"]) == (25.0, 75.0, 1.0)
    assert_array_equal(
        table["status"].values.ravel(),
        ["done", "missing", "missing", "done", "refused", "missing", "missing", "failed"],
    )
    lines = list(csv.DictReader(rows(table).splitlines()))
    assert len(lines) == 8
    assert lines[3]["tracing.tracer"] == "facets"
    assert (lines[3]["seed"], lines[3]["height_rmse_m"]) == ("6", "0.02")
    assert (lines[4]["status"], lines[4]["reason"], lines[4]["height_rmse_m"]) == ("refused", "too low", "")
    assert lines[7]["cost_s"] == "7"


def test_the_band_over_seeds_covers_as_often_as_it_says() -> None:
    draws = np.random.default_rng(7).normal(3.0, 2.0, (20_000, 4))
    draws[::2, 3] = np.nan  # a failed point: a degree of freedom less
    band = means(xr.DataArray(draws, dims=("key", "seed")))
    covered = ((band["low"] < 3.0) & (band["high"] > 3.0)).values
    # Three standard errors of a share of 95 % over 10 000 draws.
    assert_allclose([covered[::2].mean(), covered[1::2].mean()], 0.95, atol=3.0 * np.sqrt(0.95 * 0.05 / 10_000))
    assert_array_equal(np.unique(band["seeds"]), [3, 4])
    alone = means(xr.DataArray([[1.0], [2.0]], dims=("key", "seed")))
    assert_array_equal(alone["mean"], [1.0, 2.0])
    assert np.isnan(alone["low"]).all()


# ---------------------------------------------------------------------------------------------------- what a point is


def test_a_point_is_the_chain_itself() -> None:
    """Over two turns, to the bit: simulate, retrieve, compare."""
    scene = small(turns=2)
    simulation = simulate(scene)
    expected = error_figures(retrieve(simulation.echoes, scene.retrieval), simulation.truth)
    found = judged(scene, Stopwatch())
    overall = {name: value for name, value in expected["overall"].items() if name != "range_m"}
    assert found["metrics"] == found["metrics"] | overall
    for name in ("range_m", "height_rmse_m", "answered", "visible_fraction", "cells"):
        assert found["by_range"][name] == expected[name]
    # Cells of a whole bin: 25 m of gates 1.5 m apart hold 16 or 17, in each of the looks of both turns.
    looks = simulation.truth["polar"].sizes["azimuth"] * 2
    share, cells = found["by_range"]["known_share"], expected["cells"]
    assert share[0] is share[2] is None  # the window, 15 to 60 m, cuts these bins
    assert cells[1] / share[1] / looks in (16.0, 17.0)
    assert_allclose(found["facts"]["significant_height_m"], 1.4, rtol=0.01)  # 0.8 m of resolution leaves 1 % out


# ------------------------------------------------------------------------------------------- how points end


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, xr.Dataset]:
    folder = tmp_path_factory.mktemp("whole")
    return folder, write_trade(small(), folder, VARY, 2, workers=0).table


def test_the_sweep_leaves_its_files(whole: tuple[Path, xr.Dataset]) -> None:
    folder, table = whole
    assert sorted(path.name for path in folder.iterdir()) == [
        "points",
        "trade.csv",
        "trade.html",
        "trade.json",
        "trade.nc",
        "trade.png",
    ]
    assert (table["status"] == "done").all()
    assert_array_equal(table["seed"], [1, 2])
    assert np.isfinite(table["height_rmse_by_range_m"].sel(range=37.5)).all()
    with xr.open_dataset(folder / "trade.nc") as stored:
        assert stored.identical(table)
    assert (folder / "trade.csv").read_text(encoding="utf-8") == rows(table)


def test_a_refused_point_is_a_row() -> None:
    lines: list[str] = []
    table = studies.trade(small(), {"radar.height_m": [5.0, 70.0]}, workers=0, progress=lines.append)
    assert_array_equal(table["status"].values.ravel(), ["done", "refused"])
    assert "must be greater than radar.height_m" in table["reason"].values[1, 0]
    assert next(headline(table)) == "2 points: 1 done, 1 refused"


class Faulty(Simulator):
    """Fails for a mast of 5 m, and is refused by the sea for seed 2."""

    def __init__(self, scene: Scene, *taken_over: Any) -> None:
        if scene.radar.height_m == 5.0:
            raise MemoryError("no room") if scene.seed == 1 else ZeroDivisionError("two\nlines")
        if scene.seed == 2:
            raise InputError("radar.height_m: the antenna is under water")
        super().__init__(scene, *taken_over)


def test_an_error_is_a_row_and_resume_mends_it(
    whole: tuple[Path, xr.Dataset], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as faulty:
        faulty.setattr("seamap_rt.simulation.Simulator", Faulty)
        table = write_trade(small(), tmp_path, VARY, 2, workers=0).table
    assert table["status"].values.tolist() == [["done", "refused"], ["failed", "failed"]]
    assert table["reason"].values[1, 0].startswith("out of memory (no room)")
    assert table["reason"].values[1, 1] == "ZeroDivisionError: two lines"
    resumed = write_trade(small(), tmp_path, VARY, 2, workers=0, resume=True).table
    assert resumed["status"].values.tolist() == [["done", "refused"], ["done", "done"]]
    seed = {"seed": [1]}
    assert bits(resumed).sel(seed).identical(bits(whole[1]).sel(seed))


def test_interrupted_and_resumed_in_one_process(
    whole: tuple[Path, xr.Dataset], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[int] = []

    class Stopped(Simulator):
        def __init__(self, scene: Scene, *taken_over: Any) -> None:
            started.append(scene.seed)
            if len(started) == 3:
                raise KeyboardInterrupt
            super().__init__(scene, *taken_over)

    with monkeypatch.context() as stopped:
        stopped.setattr("seamap_rt.simulation.Simulator", Stopped)
        with pytest.raises(KeyboardInterrupt, match="2 of 4 points are done and stay; --resume goes on"):
            write_trade(small(), tmp_path, VARY, 2, workers=0)
    with xr.open_dataset(tmp_path / "trade.nc") as part:
        assert part["status"].values.tolist() == [["done", "missing"], ["done", "missing"]]  # sea by sea
    assert bits(write_trade(small(), tmp_path, VARY, 2, workers=0, resume=True).table).identical(bits(whole[1]))


def test_a_full_disk_loses_nothing_that_was_done(
    whole: tuple[Path, xr.Dataset], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write, asked = point.write_whole, []

    def full(path: Path, text: str) -> None:
        asked.append(path)
        if len(asked) > 2:
            raise OSError(errno.ENOSPC, "No space left on device", str(path))
        write(path, text)

    with monkeypatch.context() as disk:
        disk.setattr(point, "write_whole", full)
        with pytest.raises(OSError, match="No space left on device; 2 of 4 points are done and stay, --resume goes on"):
            write_trade(small(), tmp_path, VARY, 2, workers=0)
    assert bits(write_trade(small(), tmp_path, VARY, 2, workers=0, resume=True).table).identical(bits(whole[1]))


def test_nothing_is_computed_twice(whole: tuple[Path, xr.Dataset], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seamap_rt.simulation.Simulator", None)
    folder, table = whole
    assert write_trade(small(), folder, VARY, 2, resume=True).table.identical(table)


@pytest.mark.parametrize(
    ("scene", "varied", "words"),
    [
        ({"radar__tilt_deg": 1.0}, VARY, "another scene"),
        ({}, {"radar.height_m": [3.0, 6.0]}, "another grid"),
        ({"seed": 4}, VARY, "another scene"),
    ],
)
def test_resume_refuses_another_sweep(
    whole: tuple[Path, xr.Dataset], scene: dict[str, Any], varied: dict[str, list[Any]], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        write_trade(small(**scene), whole[0], varied, 2, workers=0, resume=True)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[tuple[float, int]]:
    """Height and seed of each point as it is computed."""
    begun: list[tuple[float, int]] = []

    class Counted(Simulator):
        def __init__(self, scene: Scene, *taken_over: Any) -> None:
            begun.append((scene.radar.height_m, scene.seed))
            super().__init__(scene, *taken_over)

    monkeypatch.setattr("seamap_rt.simulation.Simulator", Counted)
    return begun


def test_resume_with_more_seeds_computes_these_alone(
    whole: tuple[Path, xr.Dataset], tmp_path: Path, counted: list[tuple[float, int]]
) -> None:
    write_trade(small(), tmp_path, VARY, 1, workers=0)
    table = write_trade(small(), tmp_path, VARY, 2, workers=0, resume=True).table
    assert sorted(counted) == [(height, seed) for height in (3.0, 5.0) for seed in (1, 2)]
    assert bits(table).identical(bits(whole[1]))


def _swap(files: list[Path]) -> int:
    first, second = (file.read_bytes() for file in files[:2])
    files[0].write_bytes(second)
    files[1].write_bytes(first)
    return 2


def _copy_over(files: list[Path]) -> int:
    files[-1].write_bytes(files[0].read_bytes())
    return 1


def _edit(path: tuple[str, ...], value: Any, files: list[Path]) -> int:
    content = part = json.loads(files[0].read_text(encoding="utf-8"))
    for name in path[:-1]:
        part = part[name]
    part[path[-1]] = value
    files[0].write_text(json.dumps(content), encoding="utf-8")
    return 1


@pytest.mark.parametrize(
    "spoil",
    [
        _swap,
        _copy_over,
        *(
            pytest.param(partial(_edit, path, value), id=f"{'.'.join(path)}={value}")
            for path, value in [
                (("seed",), 7),
                (("keys", "radar.height_m"), 9.0),
                (("status",), "refused"),
                (("metrics", "height_rmse_m"), 1e300),
                (("by_range", "height_rmse_m"), [np.nan]),
                (("facts", "significant_height_m"), None),
                (("point", "scene_sha256"), "0" * 64),
                (("point", "version"), "0.0.1"),
                (("sha256",), ""),
            ]
        ),
    ],
)
@pytest.mark.slow
def test_a_file_that_is_not_its_points_is_not_believed(
    spoil: Callable[[list[Path]], int],
    whole: tuple[Path, xr.Dataset],
    tmp_path: Path,
    counted: list[tuple[float, int]],
) -> None:
    """Whatever lies in a point's file, the table is that of a sweep from nothing; points that are whole stay."""
    folder = tmp_path / "sweep"
    shutil.copytree(whole[0], folder)
    spoilt = spoil(sorted((folder / "points").glob("*.json")))
    made = write_trade(small(), folder, VARY, 2, workers=0, resume=True)
    assert bits(made.table).identical(bits(whole[1]))
    assert len(counted) == spoilt
    assert sum("is run again" in line for line in made.lines) == spoilt


def test_seeds_are_added_until_the_choice_is_sure_or_the_time_over(
    tmp_path: Path, counted: list[tuple[float, int]]
) -> None:
    """Of one seed nothing is sure, so that a second is drawn; a budget that is spent by then ends it there."""
    made = write_trade(small(), tmp_path, VARY, 1, workers=0, until=0.999, budget_s=1e-3)
    assert made.table.sizes["seed"] == 1
    assert made.lines[0].startswith("flag: a choice is less sure")
    made = write_trade(small(), tmp_path, VARY, 1, workers=0, until=0.5, resume=True)
    seeds = made.table.sizes["seed"]
    assert seeds >= 2
    assert len(counted) == len(set(counted)) == 2 * seeds
    assert f"{seeds} seeds, after which every choice is as sure as asked for" in made.lines[0]
    assert json.loads((tmp_path / "trade.json").read_text())["seeds"] == list(range(1, seeds + 1))


def test_seeds_that_a_goal_asks_for() -> None:
    """By hand: half as many again until it is sure; as many as end in the time that is left."""
    assert Goal().seeds(3, 3, 0.1, 10.0) == 3
    assert Goal(until=0.95).seeds(3, 3, 0.96, 10.0) == 3
    assert Goal(until=0.95).seeds(1, 1, np.nan, 10.0) == 2
    assert Goal(until=0.95).seeds(8, 8, 0.6, 10.0) == 12
    assert Goal(until=0.95).seeds(64, 64, 0.6, 10.0) == 64
    assert Goal(budget_s=100.0).seeds(8, 8, 0.99, 80.0) == 10  # 10 s a seed
    assert Goal(budget_s=100.0).seeds(8, 8, np.nan, 99.0) == 8
    assert Goal(budget_s=100.0).seeds(8, 0.0, np.nan, 0.1) == 9  # all were there: one tells how long one takes


@pytest.mark.parametrize("text", ["", "abc", "-3", "10 days", "1e3"])
def test_times_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="--budget"):
        seconds(text)


def test_times_and_confidences_as_they_are_written() -> None:
    assert [seconds(text) for text in ("90", "90s", "1.5min", "2 h")] == [90.0, 90.0, 90.0, 7200.0]
    for goal in ({"until": 1.0}, {"until": 0.2}, {"budget_s": 0.0}, {"until": np.nan}):
        with pytest.raises(InputError, match=r"--until|--budget"):
            Goal(**goal)
    with pytest.raises(InputError, match="nothing to be sure of"):
        trade(small(), {"scattering.nrcs": ["nrl", "tsc"]}, workers=0, until=0.9)


def test_resume_refuses_another_version_and_an_empty_folder(
    whole: tuple[Path, xr.Dataset], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match="holds a sweep already; give --resume"):
        write_trade(small(), whole[0], VARY, 2, workers=0)
    with pytest.raises(InputError, match="give one"):
        write_trade(small(), whole[0], VARY, 2, workers=0, resume=True, overwrite=True)
    with pytest.raises(InputError, match="holds no sweep"):
        write_trade(small(), tmp_path, VARY, 2, workers=0, resume=True)
    monkeypatch.setattr(sweep, "__version__", "0.0.1")
    with pytest.raises(InputError, match=r"another version of seamap_rt \(.*, this is 0\.0\.1\)"):
        write_trade(small(), whole[0], VARY, 2, workers=0, resume=True)


def test_overwrite_begins_anew(whole: tuple[Path, xr.Dataset], tmp_path: Path) -> None:
    (tmp_path / "points").mkdir()
    (tmp_path / "points" / "00009_old.json").write_text("{}", encoding="utf-8")
    (tmp_path / MANIFEST).write_text(json.dumps({}), encoding="utf-8")
    table = write_trade(small(), tmp_path, {"radar.height_m": [3.0]}, 1, workers=0, overwrite=True).table
    assert [path.name for path in (tmp_path / "points").iterdir()] == ["00000_radar.height_m=3_seed=1.json"]
    first = whole[1].sel({"radar.height_m": [3.0], "seed": [1]})
    assert_array_equal(table["height_rmse_by_range_m"], first["height_rmse_by_range_m"])


@pytest.mark.parametrize(
    ("scheduler", "workers", "words"),
    [
        ("nowhere.json", None, "neither an address, such as tcp://host:8786, nor a scheduler file"),
        ("tcp://127.0.0.1:9", 2, "goes without --scheduler"),
        (None, -1, "must be at least 0"),
    ],
)
def test_where_nothing_can_be_computed(scheduler: str | None, workers: int | None, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        write_trade(small(), tmp_path / "out", VARY, scheduler=scheduler, workers=workers)
    assert not (tmp_path / "out").exists()


# ------------------------------------------------------------------------------------------------------- figures


def test_the_front_is_what_no_other_choice_beats() -> None:
    generator = np.random.default_rng(3)
    for _ in range(50):
        cost, gain = generator.integers(0, 6, (2, 12)).astype(float)
        front = pareto_front(cost, gain)
        pairs = set(zip(cost, gain, strict=True))
        best = {(c, g) for c, g in pairs if not any(a <= c and b >= g and (a, b) != (c, g) for a, b in pairs)}
        assert {(cost[i], gain[i]) for i in front} == best
        assert (np.diff(cost[front]) > 0.0).all()


@pytest.mark.parametrize(
    ("shape", "panels"),
    [
        ({"heights": 5, "baselines": 1}, 3),  # a curve in each of three panels
        ({"heights": 5, "baselines": 2}, 3),  # two curves
        ({"heights": 9, "baselines": 8}, 6),  # three maps, each with its colour bar
        ({"heights": 5, "baselines": 3, "extra": 2}, 6),  # two panels for each of three quantities
        ({"heights": 7, "baselines": 6, "extra": 5}, 5),  # the radius alone
    ],
)
def test_figures_of_one_two_and_three_keys(shape: dict[str, int], panels: int) -> None:
    table = made_up(**shape)
    figure = draw_trade(table)
    assert len(figure.axes) == panels
    assert layout(table).along == "radar.height_m"
    mean = means(table["height_rmse_m"])["mean"]
    if panels == 3:
        drawn = [line for line in figure.axes[2].lines if line.get_linestyle() == "-"]
        found = np.stack([np.asarray(line.get_ydata()) for line in drawn])
        assert_allclose(found, mean.squeeze(drop=True).values.reshape(shape["heights"], -1).T)
    assert len(draw_pareto(table).axes) == 1
    assert len(draw_pareto(table, "cost_s").axes) == 1


def test_words_and_gaps_are_drawn_too() -> None:
    varied: dict[str, list[Any]] = {"tracing.tracer": ["horizon", "facets"]}
    table = trade_table(varied, [1], {(0, 0): {"status": "refused", "reason": "no"}}, Criterion(), {})
    axes = draw_trade(table).axes[0]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["horizon", "facets"]
    assert any("no values" in text.get_text() for text in axes.texts)


def test_files_that_changed_are_another_sweep(tmp_path: Path) -> None:
    rows = [f"{time},{{roll}}" for time in range(-20, 21, 5)]
    motion = tmp_path / "motion.csv"
    motion.write_text("\n".join(["time_s,roll_deg", *rows]).format(roll=1))
    scene = load_scene("tiny", overrides={"platform.motion": "file", "platform.file": str(motion)})
    vary, folder = {"radar.height_m": [5.0]}, tmp_path / "out"
    with Sweep.of(scene, vary, 1, folder).prepared(resume=False, overwrite=False):
        pass
    with Sweep.of(scene, vary, 1, folder).prepared(resume=True, overwrite=False):
        pass
    motion.write_text("\n".join(["time_s,roll_deg", *rows]).format(roll=2))
    with pytest.raises(InputError, match="another content of the files"):
        Sweep.of(scene, vary, 1, folder).prepared(resume=True, overwrite=False).__enter__()


def test_what_a_user_keeps_among_the_points_stays(tmp_path: Path) -> None:
    own = tmp_path / "points" / "mine.json"
    own.parent.mkdir()
    own.write_text("{}")
    with Sweep.of(load_scene("tiny"), {"radar.height_m": [5.0]}, 1, tmp_path).prepared(resume=False, overwrite=False):
        pass
    assert own.exists()


def test_one_value_in_two_writings_is_named_twice() -> None:
    with pytest.raises(InputError, match="named twice"):
        _ = Sweep.of(load_scene("tiny"), {"radar.height_m": [5, 5.0]}, 1, Path("unused")).points
