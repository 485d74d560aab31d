"""Two runs against each other: what is called better is so by more than chance, and what differs is named."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_folders import write_maps
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from scipy.stats import t as student

from seamap_rt.app.compare_view import RangeVerdict, describe, differences, judge, squares
from seamap_rt.app.source import Layout, Results, Source
from seamap_rt.scene import load_scene

_DRAWS = 200
_RANGE = np.arange(15.0, 300.0, 3.0)


def _field(random: np.random.Generator, looks: int, wide: tuple[float, float]) -> NDArray[np.float64]:
    field = gaussian_filter(random.standard_normal((looks, _RANGE.size)), wide, mode="wrap")
    return field / field.std()


def _run(seed: int, turns: int, factor: NDArray[np.float64] | float = 1.0, span_deg: float = 360.0) -> Any:
    """Maps with known errors: speckle's, of two cells, anew each turn; and the sea's, of some ten metres and degrees,
    which stay. They grow with range, and are twice as large across the waves. factor: of all errors, by range."""
    random = np.random.default_rng(seed)
    azimuth = 200.0 + np.arange(1.0, span_deg, 2.0)
    level = (0.03 + 0.0003 * _RANGE) * (1.5 + 0.5 * np.cos(np.radians(2.0 * azimuth)))[:, None] * factor
    stays = _field(random, azimuth.size, (3.0, 3.0))
    errors = [level * (0.6 * stays + 0.8 * _field(random, azimuth.size, (1.0, 1.0))) for _ in range(turns)]

    def field(name: str, turn: int) -> NDArray[np.float64]:
        return {
            "maps/polar/height": errors[turn],
            "truth/polar/visible_fraction": np.where(random.random(errors[turn].shape) < 0.9, 1.0, 0.0),
        }.get(name, np.zeros_like(errors[turn]))

    held = SimpleNamespace(field=field, turns=lambda: list(range(turns)))
    return SimpleNamespace(results=held, layout=Layout(azimuth, _RANGE, _RANGE, _RANGE))


@pytest.mark.parametrize(("turns", "span_deg"), [((3, 3), 360.0), ((3, 1), 360.0), ((2, 2), 90.0), ((1, 1), 60.0)])
@pytest.mark.slow
def test_runs_that_differ_by_their_seeds_alone_are_called_better_in_one_of_twenty_draws_at_most(
    turns: tuple[int, int], span_deg: float
) -> None:
    called = 0
    for draw in range(_DRAWS):
        told = judge(*(squares(_run(2 * draw + i, n, span_deg=span_deg)) for i, n in enumerate(turns)))
        called += any(each.verdict in ("▲ B better", "▼ B worse") for each in told)
    assert called <= 0.05 * _DRAWS  # in any range at all


def test_a_difference_of_thirty_percent_over_cells_enough_is_called_and_the_range_where_it_is_not() -> None:
    better = 0
    for draw in range(60):
        whole, *_ = judge(squares(_run(2 * draw, 3)), squares(_run(2 * draw + 1, 3, 0.7)))
        better += whole.verdict == "▲ B better"
        assert whole.verdict != "▼ B worse"
    assert better >= 57  # of 60

    near = np.where(_RANGE < 25.0, 5.0, np.where(_RANGE < 150.0, 1.0, 0.4))
    whole, *ranges = judge(squares(_run(1, 3)), squares(_run(2, 3, near)))
    verdicts = {each.range_m[0]: each.verdict for each in ranges}
    assert verdicts[0.0] == "▼ B worse"
    assert {verdicts[each] for each in (25.0, 50.0, 75.0, 100.0)} == {"within chance"}
    assert verdicts[200.0] == "▲ B better"
    words = describe([whole, *ranges])
    assert "B is better at" in words
    assert "B is worse at 0–25 m." in words


def test_the_stated_chance_is_the_scatter_of_independent_cells() -> None:
    """White errors, N cells a run: ln(rms B / rms A) scatters by √(1/(2N) + 1/(2N))."""
    random = np.random.default_rng(1)
    cells = 400.0
    found = []
    for _ in range(200):
        sums = np.zeros((2, 24, 1, 2))
        sums[..., 0] = cells / 24
        sums[..., 1] = random.chisquare(cells / 24, (2, 24, 1))
        told = judge((np.array([0.0]), sums[0]), (np.array([0.0]), sums[1]))
        found.append(np.log(told[0].chance) / student.ppf(0.9875, 10))
    # neighbours' correlation, where it is positive by chance, adds: the mean of √(1 + 2 max(0, ρ)) with ρ of σ 0.3
    assert 1.0 / np.sqrt(cells) < np.mean(found) < 1.2 / np.sqrt(cells)


def test_what_cannot_be_judged_is_not() -> None:
    told = judge(squares(_run(1, 1, span_deg=20.0)), squares(_run(2, 1, 0.3, span_deg=20.0)))
    assert {each.verdict for each in told} == {"too little to tell"}
    assert RangeVerdict((0.0, 25.0), 0.1, float("nan"), float("nan")).verdict == "in one of them alone"
    assert RangeVerdict((0.0, 25.0), 0.0, 0.0, float("nan")).verdict == "too little to tell"  # no error at all


def test_what_differs_is_named(tmp_path: Path) -> None:
    for name, turns, keys in (("a", 3, {}), ("b", 1, {"radar.height_m": 8.0, "seed": 2}), ("c", 1, None)):
        write_maps(tmp_path / name, "maps", "truth", turns=turns)
        if keys is not None:
            (tmp_path / name / "scene.toml").write_text(load_scene("tiny", {"turns": turns, **keys}).to_toml())
    a, b, c = (Source(Results(tmp_path / name)) for name in "abc")
    words = differences(a, b)
    for told in ("turns (A 3, B 1)", "radar.height_m (A 5.0, B 8.0)", "seed (A 1, B 2)"):
        assert told in words
    assert differences(a, a) == "The same scene with the same seed."
    assert "the scene of one is not known" in differences(a, c)
