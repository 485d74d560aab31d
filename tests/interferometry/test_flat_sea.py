"""A flat sea must come out flat: single reflectors to a millimetre, the distributed sea to what its gates' weighting
predicts."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.echoes import from_scatterers, turn_voltages
from seamap_rt.echoes.dataset import echo_dataset
from seamap_rt.interferometry import retrieve
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import gates
from seamap_rt.scene import Scene
from seamap_rt.settings import RadarSettings, RetrievalSettings
from seamap_rt.simulation import Simulator
from validation.analytic import flat_sea_gate_height, range_difference

GROUPS = 8  # reflectors every 8 gates = 12 m: twice the pulse's support (5.1 m) and no window reaches two of them
APART = 7  # looks between the groups: 12.6°, so that a reflector is out of the others' beams (± 5.4°)
ONE_GATE = {"cell_range_m": 1.5, "window_range_m": 1.5, "window_azimuth_deg": 1.8}
COARSE = 50.0  # m, ground cells: the ground map is not looked at here

CORNERS = [(baseline, height) for baseline in (0.05, 0.9) for height in (3.0, 20.0)]


def share_of(radar: RadarSettings) -> float:
    """The gate of a reflector is R₀ + share (R₁ − R₀), the mean half path of the mode's interferograms."""
    return 0.5 if radar.transmit == "switched" else 0.25


def lower_height(radar: RadarSettings) -> float:
    return radar.height_m - 0.5 * radar.baseline_m


def ground_range_of_gate(radar: RadarSettings, gate: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where on z = 0 a reflector lies that a gate hears in its middle (upright baseline)."""
    ground = np.sqrt(gate**2 - lower_height(radar) ** 2)
    for _ in range(20):
        delta = range_difference(ground, 0.0, radar.baseline_m, lower_height(radar))
        ground = np.sqrt((gate - share_of(radar) * delta) ** 2 - lower_height(radar) ** 2)
    return ground


@cache
def reflectors(baseline: float, height: float, transmit: str) -> tuple[RadarSettings, xr.Dataset]:
    """Echoes of a reflector in the middle of every gate, each group of gates in an azimuth of its own."""
    scene = Scene.model_validate(
        {
            "name": "reflectors",
            "radar": {
                "noise": False,
                "baseline_m": baseline,
                "height_m": height,
                "transmit": transmit,
                "sector_deg": (0.0, 1.8 * (APART * (GROUPS - 1) + 5)),
                "range_m": (max(15.0, 1.2 * height), 400.0),
            },
        }
    )
    gate = gates(scene.radar)
    ground = ground_range_of_gate(scene.radar, gate)
    azimuth = np.radians(1.8 * (look_of_gate(gate.size) + 0.5))
    points = np.stack((ground * np.sin(azimuth), ground * np.cos(azimuth), np.zeros(gate.size)), axis=1)
    return scene.radar, from_scatterers(scene, points, (gate / 100.0) ** 4)


def look_of_gate(count: int) -> NDArray[np.intp]:
    return 2 + APART * (np.arange(count) % GROUPS)


def heights_at_reflectors(echoes: xr.Dataset, **settings) -> NDArray[np.float64]:
    maps = retrieve(echoes, RetrievalSettings.model_validate({"ground_m": COARSE, **settings}))["polar"].to_dataset()
    height = maps["height"].values[0].astype(np.float64)
    assert height.shape[0] == APART * (GROUPS - 1) + 5
    return height[look_of_gate(height.shape[1]), np.arange(height.shape[1])]


@pytest.mark.parametrize("transmit", ["single", "switched"])
@pytest.mark.parametrize(("baseline", "height"), CORNERS)
@pytest.mark.parametrize("estimator", ["single_cell", "sliding_plane"])
@pytest.mark.parametrize(
    ("window", "limit"),
    [
        # Asked: 1 mm. A window is turned along a straight line, so that a lone reflector keeps its phase in it; left
        # over (0.9 mm at worst) is that receivers 0.9 m apart hear it in the neighbouring gates with unlike weights.
        pytest.param({}, 1e-3, id="default windows"),
        # Alone in one gate and one look: complex64 (6e-8 rad) through λR/2πB = 38 m/rad at 0.05 m and 400 m is 2 µm.
        pytest.param(ONE_GATE, 1e-5, id="one gate"),
    ],
)
def test_single_reflectors(
    baseline: float, height: float, transmit: str, estimator: str, window: dict[str, float], limit: float
) -> None:
    _, echoes = reflectors(baseline, height, transmit)
    found = heights_at_reflectors(echoes, estimator=estimator, **window)
    assert np.abs(found).max() < limit
    assert found.size >= 250


@pytest.mark.parametrize("tilt", [-10.0, 10.0])
@pytest.mark.parametrize("transmit", ["single", "switched"])
def test_reflectors_with_a_leaning_baseline(tilt: float, transmit: str) -> None:
    # Heights that are not zero, each in the middle of a gate that is laid through it. The dwell's pulses look up to
    # 0.9° past the reflector, so that a baseline leaning by B sin α shortens by 1e-4 of it in the reflector's
    # direction: 2 µm of ΔR at most, R/B = 600 times that in height.
    radar = RadarSettings.model_validate(
        {
            "noise": False,
            "baseline_m": 0.3,
            "height_m": 6.0,
            "tilt_deg": tilt,
            "transmit": transmit,
            "sector_deg": (0.0, 9.0),
        }
    )
    azimuth, half, lean = np.radians(4.5), 0.15, np.radians(tilt)
    for ground, z in zip(30.0 + 15.0 * np.arange(11), np.random.default_rng(2).uniform(-0.5, 0.5, 11), strict=True):
        lower = np.hypot(ground + half * np.sin(lean), z - 6.0 + half * np.cos(lean))
        upper = np.hypot(ground - half * np.sin(lean), z - 6.0 - half * np.cos(lean))
        gate = lower + share_of(radar) * (upper - lower)
        aimed = radar.model_copy(update={"range_m": (gate - 6.0, gate + 7.0)})
        scene = Scene(name="leaning", radar=aimed)
        echoes = from_scatterers(scene, [[ground * np.sin(azimuth), ground * np.cos(azimuth), z]], [10.0])
        settings = RetrievalSettings(estimator="single_cell", cell_range_m=1.5, ground_m=COARSE)
        cell = retrieve(echoes, settings)["polar"].to_dataset().isel(turn=0, azimuth=2, range=4)
        assert float(cell["range"]) == pytest.approx(gate, abs=1e-9)
        assert float(cell["height"]) == pytest.approx(z, abs=1.5e-3)
        assert float(cell["ground_range"]) == pytest.approx(ground, abs=2e-4)


# ----------------------------------------------------------------------------------------- the distributed flat sea


@pytest.fixture(scope="module")
def flat_sea() -> tuple[RadarSettings, xr.Dataset]:
    """A circle of a flat sea through the horizon tracer, speckled; τc = 1 ms gives each dwell a few samples."""
    scene = Scene.model_validate(
        {
            "name": "flat",
            "sea": {"waves": [{"spectrum": "flat"}]},
            "scattering": {"nrcs": "constant"},
            "tracing": {"tracer": "horizon"},
            "radar": {"noise": False},
        }
    )
    facets, returns, _ = Simulator(scene).light(0)
    fired = pulses(Installation(scene.radar), 0)
    voltages = turn_voltages(facets, returns.rcs, Installation(scene.radar), fired, 1, 1e-3)
    return scene.radar, echo_dataset(Installation(scene.radar), [fired], [voltages])


@pytest.mark.parametrize("estimator", ["single_cell", "sliding_plane"])
def test_mean_height_of_the_flat_sea(flat_sea: tuple[RadarSettings, xr.Dataset], estimator: str) -> None:
    # The mean over 200 looks of their own heights, gate by gate, from 50 m on: 2 cm is asked.
    _, echoes = flat_sea
    # Of one way: in the first gates the flat sea itself turns the phase of both ways by more than 1 rad within a pulse.
    settings = RetrievalSettings.model_validate({"estimator": estimator, "ground_m": COARSE, "paths": "one_way"})
    maps = retrieve(echoes, settings)["polar"].to_dataset()
    height = maps["height"].values[0].astype(np.float64)
    assert np.isfinite(height).all()
    assert not (maps["quality"].values & (QUALITY_FLAGS["no_echo"] | QUALITY_FLAGS["low_coherence"])).any()
    mean = height.mean(axis=0)[maps["range"].values >= 50.0]
    assert np.abs(mean).max() < 0.02
    assert abs(mean.mean()) < 0.002


@pytest.mark.parametrize(("cell", "first"), [(1.5, 0), (3.0, 1)])
def test_height_of_each_gate_is_what_its_weighting_predicts(
    flat_sea: tuple[RadarSettings, xr.Dataset], cell: float, first: int
) -> None:
    # Covariances summed over 15° (8 dwells' worth of pulses in one look) and then inverted, so that no single look's
    # heavy tail is averaged; 24 such looks give the mean and its standard error. The first gate's window shrinks to
    # itself, for want of a gate nearer still.
    radar, echoes = flat_sea
    settings = RetrievalSettings.model_validate(
        {
            "estimator": "single_cell",
            "cell_range_m": cell,
            "cell_azimuth_deg": 15.0,
            "ground_m": COARSE,
            # As the closed form has it. Both ways turn within a pulse there: 8 ± 1 mm higher at the first gates.
            "paths": "one_way",
        }
    )
    maps = retrieve(echoes, settings)["polar"].to_dataset()
    ranges = maps["range"].values
    height = maps["height"].values[0].astype(np.float64)[:, first:-1]
    predicted = flat_sea_gate_height(radar, ranges, window_m=cell)[first:-1]
    error = (height.mean(axis=0) - predicted) / (height.std(axis=0, ddof=1) / np.sqrt(height.shape[0]))
    # Student, 23 degrees of freedom, 250 gates: the largest passes 5 once in a hundred seeds; its variance is 23/21.
    assert np.abs(error).max() < 5.0
    independent = error[::4]  # 6 m apart
    assert np.mean(independent**2) < 23.0 / 21.0 + 3.0 * np.sqrt(2.4 / independent.size)
    # The prediction is not idle: at 16 m it is decimetres, where the beam's edge pulls the gate outward.
    near = ranges[first:-1] < 20.0
    assert np.abs(predicted[near]).max() > 0.1
    assert np.abs(height.mean(axis=0) - predicted)[near].max() < 0.03
    beyond = ranges[first:-1] > 50.0
    assert np.abs(predicted[beyond]).max() < 0.02  # what is asked of the mean height
