"""What came of forecasts: the run's own sea, drawn again in another process, and the scores that follow from it."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest
from made_folders import OFFSET_M, STATED_M, forecasts

from seamap_rt.app.verification import Verification, Verifications, verify_folder
from seamap_rt.errors import InputError
from seamap_rt.forecast_errors import warm
from seamap_rt.report.forecast_figures import errors_by_lead, verified_sea
from seamap_rt.scene import load_scene


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("forecast")
    (made / "scene.toml").write_text(load_scene("tiny").to_toml())
    forecasts(quiet=True).to_netcdf(made / "prediction.nc", engine="h5netcdf")
    return made


@pytest.fixture(scope="module")
def asked() -> Verifications:
    return Verifications()


@pytest.fixture(scope="module")
def found(folder: Path, asked: Verifications) -> Verification:
    return asyncio.run(asked.ask(folder))


def test_the_sea_is_the_runs_own_and_an_offset_is_found_as_such(found: Verification) -> None:
    """A forecast that is 0.1 m too high everywhere is wrong by 0.1 m at each lead, and correlates by one. To the bits
    of the file's float32."""
    forecasts, truth, judged = found.verified.forecasts, found.verified.truth, warm(found.verified.forecasts)
    np.testing.assert_allclose(forecasts["elevation"].values - truth, OFFSET_M, atol=1e-6)
    told = errors_by_lead(found.verified)
    sigma = float(np.std(truth[judged]))
    np.testing.assert_allclose(told["found"], OFFSET_M / sigma, rtol=1e-4)
    np.testing.assert_allclose(told["stated"], STATED_M / sigma, rtol=1e-5)
    np.testing.assert_allclose(told["correlation"], 1.0, atol=1e-6)
    assert judged.sum() == 8  # of five turns and more
    assert told["persistence"][0] == pytest.approx(OFFSET_M / sigma, rel=1e-4)
    assert told["persistence"][1:].min() > 2.0 * told["found"].max()  # the sea moves on


def test_the_sea_in_time_is_one_curve_through_all_forecasts(found: Verification) -> None:
    time, height = verified_sea(found.verified)
    assert time[0] == 1.0
    assert time.size == 22  # whole seconds from the first issue to the last one's last lead
    later = np.searchsorted(
        time, found.verified.forecasts["issued"].values[3] + found.verified.forecasts["lead"].values
    )
    np.testing.assert_allclose(height[later], found.verified.truth[3, :, 0], atol=1e-12)


def test_windows_that_came_are_those_in_which_the_water_stayed_below(found: Verification) -> None:
    windows, judged = found.windows, np.flatnonzero(warm(found.verified.forecasts))
    assert windows is not None
    quiet = np.array([found.quiet_windows(int(at)) for at in judged])
    assert found.quiet_windows(0) is None  # it rests on too few turns
    assert np.isnan(quiet[:, 9:]).all()  # ends beyond the last lead
    quiet = quiet[:, :9]
    assert windows.chance.size == quiet.size == 72
    # a window of 2 s is not quiet where the water stands above 0.3 m at its beginning, or 1 or 2 s later
    true = np.abs(found.verified.truth[judged, :, 0])
    above = np.max([true[:, k : k + 9] for k in range(3)], axis=0) >= 0.3
    assert above.any()
    assert not (above & (quiet > 0.5)).any()
    assert found.scores["quiet_share"] == pytest.approx(quiet.mean())


def test_what_is_asked_again_is_kept(folder: Path, found: Verification, asked: Verifications) -> None:
    assert asyncio.run(asked.ask(folder)) is asked.find_finished(folder) is found
    assert Verifications().find_finished(folder) is None


def test_where_nobody_knows_what_came_a_line_says_so(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no finished forecasts"):
        asyncio.run(Verifications().ask(tmp_path))
    (tmp_path / "prediction.nc").write_bytes(b"\x89HDF")
    with pytest.raises(InputError, match="scene is not known"):
        verify_folder(tmp_path)
    (tmp_path / "scene.toml").write_text("[radar]\nheight_m = 500.0\n")
    with pytest.raises(InputError, match=r"radar\.range_m"):
        asyncio.run(Verifications().ask(tmp_path))
