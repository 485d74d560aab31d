"""What the whole chain is for: heights of `choppy_sea`, 50–200 m, cells more than half visible, against the truth.

The bounds without noise are those that were set for this scene, or what seeds leave of them. The horizon tracer stands
in for the rays: they light the same facets but for a few in a million.
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

from seamap_rt.interferometry import retrieve
from seamap_rt.metrics import HEADLINE_M, error_figures
from seamap_rt.scene import load_scene
from seamap_rt.settings import RetrievalSettings
from seamap_rt.simulation import Simulator, Turn
from validation.radar import modes

# For HH a third of the circle is enough, looks into the waves' troughs and across them.
SECTOR = {"VV": [0.0, 360.0], "HH": [210.0, 330.0]}


@cache
def turn(noise: bool, polarization: str = "VV") -> Turn:
    return turns_of(polarization, seed=1)[noise]


@lru_cache(maxsize=2)
def turns_of(polarization: str, seed: int) -> tuple[Turn, Turn]:
    """Without noise and with it, by straight rays; the simulation's own is a law of `test_modes_and_riding`."""
    changes = {"radar.noise": False, "radar.sector_deg": SECTOR[polarization], "tracing.tracer": "horizon"}
    changes |= {"tracing.diffraction": "none", "scattering.sea_spikes": False}
    changes |= {"scattering.polarization": polarization, "seed": seed}
    simulator = Simulator(load_scene("choppy_sea", changes))
    quiet = simulator.turn(0)
    return quiet, modes.with_noise(quiet, simulator.scene.radar, seed, simulator.installation)


@cache
def maps(noise: bool, polarization: str = "VV", estimator: str = "adaptive", *window: float) -> xr.DataTree:
    asked = {"estimator": estimator, **dict(zip(("window_range_m", "window_azimuth_deg"), window, strict=False))}
    return retrieve(turn(noise, polarization).echoes, RetrievalSettings.model_validate(asked))


def overall(noise: bool, polarization: str = "VV", estimator: str = "adaptive", *window: float) -> dict[str, Any]:
    return error_figures(maps(noise, polarization, estimator, *window), turn(noise, polarization).truth)["overall"]


def test_single_cells_without_noise() -> None:
    found = overall(False, "VV", "single_cell")
    assert found["height_robust_m"] <= 0.12
    assert abs(found["height_bias_m"]) <= 0.02


# Seeds 1 … 6: 0.072 ± 0.0023 m in VV, 0.072 ± 0.0028 m in HH (of a third of the circle). The bounds lie three of those
# spreads higher.
@pytest.mark.parametrize(("polarization", "rmse"), [("VV", 0.079), ("HH", 0.081)])
def test_default_estimator_without_noise(polarization: str, rmse: float) -> None:
    found = overall(False, polarization)
    assert found["height_rmse_m"] <= rmse
    assert found["height_correlation"] >= 0.95
    assert abs(found["height_bias_m"]) <= 0.02


@pytest.mark.parametrize("noise", [False, True])
def test_near_by_the_gates_beside_tell_where_bright_spots_lie(noise: bool) -> None:
    # 25–50 m, robust: 0.028 m over five seeds (± 0.001); 0.040 m where bright spots are left in.
    got, true = maps(noise)["polar"].to_dataset(), turn(noise).truth["polar"].to_dataset()
    near = (got["range"] > 25.0) & (got["range"] <= 50.0) & (true["visible_fraction"] > 0.5)
    error = (got["height"] - true["height"]).where(near).values
    error = error[np.isfinite(error)]
    assert 1.4826 * np.median(np.abs(error - np.median(error))) < 0.033


@pytest.mark.parametrize("noise", [False, True])
def test_a_window_that_follows_the_waves_beats_single_cells(noise: bool) -> None:
    # 5 × 1.5 weights instead of 2 × 1 average more speckle; along the wrong slope they would flatten the waves instead.
    single = overall(noise, "VV", "single_cell")["height_rmse_m"]
    assert overall(noise, "VV", "sliding_plane")["height_rmse_m"] < 0.92 * single


@pytest.mark.parametrize("noise", [False, True])
def test_a_window_that_adapts_itself_beats_fixed_ones(noise: bool) -> None:
    # By 5 %, as asked; over five seeds it is 10 % and 13 %. These windows do best here (validation.retrieval.maps).
    windows = [(6.0, 2.7), (9.0, 2.7)]
    fixed = min(overall(noise, "VV", "sliding_plane", *window)["height_rmse_m"] for window in windows)
    assert overall(noise)["height_rmse_m"] < 0.95 * fixed


def test_the_stated_error_holds() -> None:
    # Without noise and with it. The bounds are those that were asked, the share's less its 1 %: errors of partly hidden
    # cells have a long tail upwards, for crests are seen, troughs not. A turn shows a few dozen waves: its ratio
    # scatters by 0.07 over seeds, its share by 2 %, the means of six by 0.03 and 0.8 %.
    ratios, shares = np.empty((2, 6)), np.empty((2, 6))
    for seed in range(6):
        for noise, made in enumerate(turns_of("VV", seed + 1)):
            got, true = retrieve(made.echoes)["polar"].to_dataset(), made.truth["polar"].to_dataset()
            headline = (got["range"] >= HEADLINE_M[0]) & (got["range"] <= HEADLINE_M[1]) & (got["quality"] == 0)
            ratio = ((got["height"] - true["height"]) / got["height_std"]).where(headline).values
            ratio = ratio[np.isfinite(ratio)]
            ratios[noise, seed] = 1.4826 * np.median(np.abs(ratio - np.median(ratio)))
            shares[noise, seed] = np.mean(np.abs(ratio) < 1.96)
    np.testing.assert_allclose(ratios.mean(axis=1), 1.0, rtol=0.0, atol=0.1)
    np.testing.assert_allclose(shares.mean(axis=1), 0.945, rtol=0.0, atol=0.025)


@pytest.mark.parametrize("mast", [3.5, 9.0])
def test_the_stated_error_holds_where_crests_turn_the_phase(mast: float) -> None:
    """By knife edges, with noise, in a sea and from masts on which nothing was set. A turn's ratio scatters by 0.1 and
    its share by 2 %, the means of three by 0.06 and 1.2 %; without what bars hold of it 84 % lie within, from 3.5 m."""
    ratios, shares, bare = [], [], []
    for seed in range(31, 34):
        changes = {"radar.height_m": mast, "radar.sector_deg": [225.0, 315.0], "sea.waves": [system(1.0, 4.8)]}
        made = Simulator(load_scene("choppy_sea", changes | {"tracing.tracer": "horizon", "seed": seed})).turn(0)
        true = made.truth["polar"].to_dataset()
        for error, found in ((None, shares), (0.0, bare)):
            got = retrieve(made.echoes, {} if error is None else {"diffraction_mrad": error})["polar"].to_dataset()
            ratio = ((got["height"] - true["height"]) / got["height_std"]).where(true["visible_fraction"] > 0.5)
            ratio = ratio.where((got["range"] >= HEADLINE_M[0]) & (got["range"] <= HEADLINE_M[1])).values
            ratio = ratio[np.isfinite(ratio)]
            found.append(np.mean(np.abs(ratio) < 1.96))
            if error is None:
                ratios.append(1.4826 * np.median(np.abs(ratio - np.median(ratio))))
    np.testing.assert_allclose(np.mean(ratios), 1.0, rtol=0.0, atol=0.15)
    np.testing.assert_allclose(np.mean(shares), 0.94, rtol=0.0, atol=0.03)
    assert np.mean(bare) < np.mean(shares) - 0.03


def system(height: float, period: float, toward: float = 270.0, exponent: float = 10.0) -> dict[str, Any]:
    return {
        "spectrum": "jonswap",
        "significant_wave_height_m": height,
        "peak_period_s": period,
        "wave_from_deg": toward,
        "spreading": "cos2s",
        "spreading_exponent": exponent,
    }


SEAS = {
    "short": ([system(0.7, 4.0)], 8.0, 0.35),
    "swell": ([system(2.5, 8.0), system(2.0, 12.0, 200.0, 40.0)], 8.0, 0.35),
    "high": ([system(4.0, 10.0)], 20.0, 0.9),
}


@pytest.mark.parametrize("name", SEAS)
@pytest.mark.slow
def test_error_bars_hold_on_other_seas(name: str) -> None:
    """Of waves of 25 m, which the footprint flattens, to a swell of 225 m; from a high mast phases turn by cycles.

    One turn of one sea leaves its error bars 15 % (`python -m validation.retrieval.seas`); before short waves were
    taken from the sea's own spectrum these were 1.35, 0.56 and 0.63.
    """
    waves, height, baseline = SEAS[name]
    changes = {"seed": 3, "sea.waves": waves, "radar.height_m": height, "radar.baseline_m": baseline}
    changes |= {"sea.extent_m": 1024.0, "radar.range_m": [height + 5.0, 210.0], "tracing.tracer": "horizon"}
    made = Simulator(load_scene("choppy_sea", changes)).turn(0)
    got, true = retrieve(made.echoes)["polar"].to_dataset(), made.truth["polar"].to_dataset()
    headline = (got["range"] >= HEADLINE_M[0]) & (got["range"] <= HEADLINE_M[1]) & (got["quality"] == 0)
    error = (got["height"] - true["height"]).where(headline).values
    ratio = error / got["height_std"].values
    ratio = ratio[np.isfinite(ratio)]
    assert 0.8 < 1.4826 * np.median(np.abs(ratio - np.median(ratio))) < 1.2
    assert 0.9 < np.mean(np.abs(ratio) < 1.96) < 0.985
    # None of the cells is a cycle off: they would err by more than a metre where bars are of 0.1 m.
    assert np.nanmax(np.abs(error)) < 1.0
