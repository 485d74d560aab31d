"""Judges of quiet windows, on windows whose fate is known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from seamap_rt.window_errors import Windows, area, hits_and_alarms, judge_windows, observed_windows, reliability

LEAD = np.arange(0.0, 21.0)


class Standing:
    """A sea that is 1 m high for five seconds of every ten, and 0.1 m deep in the others."""

    def elevation(self, x: np.ndarray, y: np.ndarray, t: np.ndarray) -> np.ndarray:
        return np.where(t % 10.0 < 5.0, 1.0, -0.1)


class Sloping:
    """A sea that is as high as it is far east."""

    def elevation(self, x: np.ndarray, y: np.ndarray, t: np.ndarray) -> np.ndarray:
        return x


def forecasts(lasts: float, limit: str = "limit_elevation", speed: float = 0.0) -> xr.Dataset:
    """Of two turns, 10 s apart, with a chance that falls with the lead; beyond what ends in time there is none."""
    chance = np.where(LEAD + lasts <= LEAD[-1], 1.0 - LEAD / 40.0, np.nan)
    return xr.Dataset(
        {
            "quiet": (("issue", "lead", "place"), np.stack([chance, chance])[:, :, None]),
            "issued": ("issue", [10.0, 20.0]),
            "turns": ("issue", [8, 9]),
        },
        {"issue": [8, 9], "lead": LEAD, "place": [0]}
        | {name: (("issue", "place"), np.zeros((2, 1))) for name in ("east", "north")},
        {limit: 0.5, "duration_s": lasts, "heading_deg": 90.0, "speed_m_s": speed},
    )


def test_a_window_is_quiet_where_the_sea_stays_low_all_through() -> None:
    # Of 3 s: those that begin 5 to 6 s into each ten; the one at 7 s ends as the water rises again.
    found = observed_windows(Standing(), forecasts(3.0))
    assert found is not None
    begin = LEAD[LEAD[-1] >= LEAD + 3.0]
    expected = (begin % 10.0 >= 5.0) & (begin % 10.0 <= 6.0)
    np.testing.assert_array_equal(found.quiet, np.tile(expected, 2))
    np.testing.assert_allclose(found.chance, np.tile(1.0 - begin / 40.0, 2))
    # Water that stood 0.1 m deep before each forecast, and rose at its moment.
    np.testing.assert_allclose(found.others["persistence"], -1.0)


def test_windows_run_along_the_way_of_the_place() -> None:
    # 0.05 m further east a second: the limit is passed 10 s ahead, so 3 s before for the begin.
    found = observed_windows(Sloping(), forecasts(3.0, speed=0.05))
    assert found is not None
    begin = LEAD[LEAD[-1] >= LEAD + 3.0]
    np.testing.assert_array_equal(found.quiet, np.tile(begin + 3.0 < 10.0, 2))


def test_windows_of_what_the_water_alone_does_not_tell_are_not_judged() -> None:
    assert observed_windows(Standing(), forecasts(3.0, "limit_roll")) is None
    assert observed_windows(Standing(), forecasts(3.0).drop_vars("quiet")) is None
    assert observed_windows(Standing(), forecasts(30.0)) is None


def test_areas_are_chances_that_quiet_ones_score_higher() -> None:
    # Mann and Whitney's count, ties half.
    stream = np.random.default_rng(2)
    score, quiet = np.round(stream.random(300), 1), stream.random(300) < 0.3
    one, other = score[quiet][:, None], score[~quiet]
    assert area(score, quiet) == pytest.approx(np.mean((one > other) + 0.5 * (one == other)))
    hits, alarms = hits_and_alarms(score, quiet)
    assert (hits[0], alarms[0], hits[-1], alarms[-1]) == (0.0, 0.0, 1.0, 1.0)
    assert np.isnan(area(score, np.ones(300, bool)))


def test_probabilities_that_are_true_are_found_true() -> None:
    # 20 runs of independent windows: bands are those of a binomial share.
    stream = np.random.default_rng(3)
    chance = stream.random((20, 200))
    quiet = stream.random((20, 200)) < chance
    runs = [Windows(a, b, {"persistence": a}) for a, b in zip(chance, quiet, strict=True)]
    for each in reliability(runs):
        expected = np.sqrt(each.stated * (1.0 - each.stated) / each.count)
        assert abs(each.found - each.stated) < 3.5 * expected
        assert each.high - each.low == pytest.approx(2.0 * 1.96 * expected, rel=0.5)
    told = judge_windows(Windows(chance.ravel(), quiet.ravel(), {"persistence": 1.0 - chance.ravel()}), 0.9)
    # ∫ over p from 0 to 1: half is quiet; a tenth is called, 0.95 of it right, that is 0.19 of the quiet ones; Brier
    # 1/6; each within three standard errors of 4000.
    expected = {"quiet_share": 0.5, "right": 0.95, "found": 0.19, "brier": 1.0 / 6.0, "climatology_brier": 0.25}
    for name, value in expected.items():
        assert told[name] == pytest.approx(value, abs=0.035), name
    assert told["area"] == pytest.approx(5.0 / 6.0, abs=0.03)
    assert told["persistence_area"] == pytest.approx(1.0 - told["area"])


def test_what_is_not_defined_is_none() -> None:
    told = judge_windows(Windows(np.array([0.1, 0.2]), np.array([False, False]), {"persistence": np.zeros(2)}), 0.9)
    assert told["right"] is None
    assert told["found"] is None
    assert told["area"] is None
    assert told["windows"] == 2
    assert told["called"] == 0


def test_bands_are_of_95_in_100_and_every_window_is_in_a_class() -> None:
    """400 runs of one window each are independent: 1.96 standard errors to either side. Of 2000 runs drawn again a
    quantile at 2.5 % is known to 3.5 %. A chance of 1 is one too."""
    stream = np.random.default_rng(5)
    runs = [Windows(np.array([0.8]), np.array([stream.random() < 0.8])) for _ in range(400)]
    (only,) = reliability(runs)
    error = np.sqrt(only.found * (1.0 - only.found) / 400.0)
    assert only.high - only.low == pytest.approx(2.0 * 1.96 * error, rel=0.09)
    chances = np.linspace(0.0, 1.0, 11)
    classes = reliability([Windows(chances, chances > 0.5)])
    assert sum(each.count for each in classes) == chances.size


def test_the_limit_is_the_forecast_s_own() -> None:
    """Water that stands at 0.49 m holds 0.5 m for ever, at 0.51 m never, and as much below the level alike."""

    class Level(Standing):
        def __init__(self, height: float) -> None:
            self.height = height

        def elevation(self, x: np.ndarray, y: np.ndarray, t: np.ndarray) -> np.ndarray:
            return np.full(t.shape, self.height)

    for height, quiet in ((0.49, True), (-0.49, True), (0.51, False), (-0.51, False)):
        found = observed_windows(Level(height), forecasts(3.0))
        assert found is not None
        assert np.all(found.quiet == quiet)
