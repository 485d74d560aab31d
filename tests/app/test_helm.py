"""The helm: its words, and its advice from a run's maps."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from seamap_rt.app.waves_view import quiet_words, wave_words
from seamap_rt.report.advice_figure import advice_polar
from seamap_rt.report.forecast_figures import BoatForecast


def ahead(chance: list[float]) -> BoatForecast:
    lead = np.arange(float(len(chance)))
    height = np.where(lead == 2.0, 1.5, 0.0)
    return BoatForecast(4, lead, height, np.full(lead.size, 0.25), np.array(chance), "roll below 5 °", None, 2.0, 0.9)


@pytest.mark.parametrize(
    ("chance", "words"),
    [
        ([0.95, 0.2, 0.2, 0.2], "Quiet: now"),
        ([0.2, 0.2, 0.2, 0.9], "Quiet: in 3 s"),
        ([0.2, 0.2, 0.2, np.nan], "Quiet: none in 3 s"),
        ([np.nan] * 4, "Quiet: no limit is named"),
    ],
)
def test_the_countdown_runs_to_the_first_window_that_is_called(chance: list[float], words: str) -> None:
    assert quiet_words(ahead(chance)) == words


def test_the_highest_crest_is_told_with_its_band() -> None:
    assert wave_words(ahead([np.nan] * 4)) == "Highest: 1.5 ± 0.5 m in 2 s"


def test_the_polar_has_north_up_and_each_course_where_it_is() -> None:
    """Of roll that is least on one course, the darkest field lies about that heading and speed."""
    heading, speed = 30.0 * np.arange(12), np.array([0.0, 2.0, 4.0])
    roll = np.full((12, 3, 2), 5.0)
    roll[3, 2] = 1.0
    attributes = {"heading_deg": 0.0, "speed_m_s": 2.0, "best_heading_deg": 90.0, "best_speed_m_s": 4.0}
    made = xr.Dataset(
        {"roll_rms": (("heading", "speed", "part"), roll)},
        {"heading": heading, "speed": speed, "part": ["seen", "beyond"]},
        attributes,
    )
    axes = advice_polar(made).axes[0]
    (mesh,) = axes.collections
    values = np.asarray(mesh.get_array(), np.float64).reshape(3, 12)
    assert np.unravel_index(values.argmin(), values.shape) == (2, 3)
    best = axes.lines[1]
    east_and_up = axes.transData.transform(np.asarray(best.get_xydata())[0])
    centre = axes.transData.transform((0.0, 0.0))
    assert east_and_up[0] > centre[0] + 10.0
    assert east_and_up[1] == pytest.approx(centre[1], abs=1.0)
