"""Errors of forecasts, on forecasts whose errors are known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from seamap_rt.dataset import build
from seamap_rt.forecast_errors import VerifiedForecasts, judge_forecasts, true_elevation, warm

LEAD = np.arange(0.0, 31.0)


def made(mean: np.ndarray, std: float, turns: list[int], **course: float) -> xr.Dataset:
    """Forecasts (issue, lead) at one place, (3, 4) m, issued ten seconds apart."""
    count = len(turns)
    values = {
        f"{name}{part}": np.zeros((count, LEAD.size, 1))
        for name in ("slope_x", "slope_y", "velocity_z")
        for part in ("", "_std")
    }
    values |= {"elevation": mean[:, :, None], "elevation_std": np.full((count, LEAD.size, 1), std)}
    values |= {
        "predictable": np.ones((count, LEAD.size, 1)),
        "issued": 10.0 * np.arange(count),
        "turns": np.array(turns),
    }
    values |= {"significant_wave_height": np.full(count, 1.4), "peak_period": np.full(count, 5.5)}
    places = {"east": np.full((count, 1), 3.0), "north": np.full((count, 1), 4.0)}
    coords = {"issue": np.arange(count), "lead": LEAD, "place": [0]} | places
    return build("prediction", values, coords, {"heading_deg": 0.0, "speed_m_s": 0.0} | course)


class Plane:
    """A sea that is 1 m higher each metre north, 10 m each metre east, and rises by 100 m a second."""

    def elevation(self, x: np.ndarray, y: np.ndarray, t: np.ndarray) -> np.ndarray:
        return 10.0 * x + y + 100.0 * t


def test_the_sea_that_came_is_taken_along_the_way() -> None:
    still = true_elevation(Plane(), made(np.zeros((2, LEAD.size)), 0.1, [5, 6]))
    np.testing.assert_allclose(still[:, :, 0], 34.0 + 100.0 * (np.array([[0.0], [10.0]]) + LEAD))
    ahead = true_elevation(Plane(), made(np.zeros((2, LEAD.size)), 0.1, [5, 6], heading_deg=90.0, speed_m_s=2.0))
    np.testing.assert_allclose(ahead - still, np.broadcast_to(20.0 * LEAD[:, None], ahead.shape), atol=1e-9)


def test_errors_are_shares_of_the_sea_that_came() -> None:
    # Half the sea is forecast: the error is half of it too. Persistence holds the first value.
    truth = np.cos(2.0 * np.pi * LEAD / 7.0) * np.array([[1.0], [2.0], [3.0]])
    forecasts = made(0.5 * truth, 0.4, [5, 6, 7])
    rows = judge_forecasts(VerifiedForecasts(forecasts, truth[:, :, None], xr.Dataset()))
    sigma = np.std(truth)
    for row in rows:
        inside = (row["lead_s"][0] <= LEAD) & (row["lead_s"][1] >= LEAD)
        was = truth[:, inside]
        assert row["error_share"] == pytest.approx(0.5 * np.sqrt(np.mean(was**2)) / sigma, rel=1e-5)
        kept = np.sqrt(np.mean((0.5 * truth[:, :1] - was) ** 2)) / sigma
        assert row["persistence_share"] == pytest.approx(kept, rel=1e-5)
        assert row["stated_share"] == pytest.approx(0.4 / sigma, rel=1e-5)
        assert row["within"] == pytest.approx(np.mean(np.abs(0.5 * was) < 1.96 * 0.4))
    assert rows[1]["correlation"] == pytest.approx(1.0)


def test_forecasts_from_few_turns_are_not_judged_where_others_are() -> None:
    assert warm(made(np.zeros((3, LEAD.size)), 0.1, [4, 5, 6])).tolist() == [False, True, True]
    assert warm(made(np.zeros((2, LEAD.size)), 0.1, [1, 2])).tolist() == [True, True]


def test_a_calm_has_no_shares() -> None:
    flat = np.zeros((2, LEAD.size, 1))
    assert judge_forecasts(VerifiedForecasts(made(flat[:, :, 0], 0.1, [5, 6]), flat, xr.Dataset())) == []


def test_each_whole_second_to_thirty_counts_once_and_stated_errors_as_squares() -> None:
    """Errors that grow by 0.1 m a second, all of them stated: a span's share is the rms of its own leads, and of what
    was stated the same; no lead is in two spans, and none in none."""
    stream = np.random.default_rng(1)
    truth = stream.standard_normal((3, LEAD.size))
    forecasts = made(truth + 0.1 * LEAD, 0.1, [5, 6, 7])
    forecasts["elevation_std"] = forecasts["elevation_std"] * 0.0 + (0.1 * LEAD)[:, None]
    rows = judge_forecasts(VerifiedForecasts(forecasts, truth[:, :, None], xr.Dataset()))
    counted = np.concatenate([LEAD[(row["lead_s"][0] <= LEAD) & (row["lead_s"][1] >= LEAD)] for row in rows])
    np.testing.assert_array_equal(counted, LEAD)
    for row in rows:
        inside = np.arange(row["lead_s"][0], row["lead_s"][1] + 1.0)
        expected = 0.1 * np.sqrt(np.mean(inside**2)) / np.std(truth)
        assert row["error_share"] == pytest.approx(expected, abs=1e-6)  # of float32
        assert row["stated_share"] == pytest.approx(expected, abs=1e-6)
