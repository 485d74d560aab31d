"""Phases at 20 km, and baselines from 1 mm to 3 m: against 50-digit arithmetic and a sea of closed form."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.echoes import from_scatterers, turn_voltages
from seamap_rt.echoes.speckle import speckle_stream
from seamap_rt.echoes.summation.gaussian import gaussians, key_of
from seamap_rt.interferometry import retrieve
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.scene import Scene
from seamap_rt.settings import RadarSettings, RetrievalSettings, TracingSettings
from seamap_rt.tracing.horizon import trace_horizon
from validation import analytic

FAR = 19_990.0  # m, on the ground
K = 2 * mpmath.pi * mpmath.mpf(10**10) / mpmath.mpf(SPEED_OF_LIGHT)


def wrapped(phase: mpmath.mpf, found: float) -> float:
    """found − phase, brought into [−π, π)."""
    turn = 2 * mpmath.pi
    return float((mpmath.mpf(found) - phase + mpmath.pi) % turn - mpmath.pi)


def far_radar(baseline: float, height: float, transmit: str) -> dict[str, object]:
    """A narrow look at the last 10 m of what a radar may ask for; 20 km are 133 µs there and back."""
    return {
        "noise": False,
        "baseline_m": baseline,
        "height_m": height,
        "transmit": transmit,
        "prf_hz": 7000.0,
        "sector_deg": (37.0, 37.9),
        "range_m": (FAR - 6.0, FAR + 9.0),
    }


@pytest.mark.parametrize("transmit", ["single", "switched"])
@pytest.mark.parametrize(("baseline", "height"), [(0.001, 5.0), (0.2, 5.0), (3.0, 20.0), (20.0, 1000.0)])
def test_phase_of_a_scatterer_at_20_km(baseline: float, height: float, transmit: str) -> None:
    """Asked: 1e-3 rad. Two paths of 20 km round to 4e-12 m each, 3e-9 rad; a voltage of complex64 to 6e-8."""
    level = np.sqrt((FAR + 1.0) ** 2 - height**2)
    place = np.array([level * np.sin(0.6535), level * np.cos(0.6535), 0.37])
    settings = {
        "name": "far",
        "radar": far_radar(baseline, height, transmit),
        "sea": {"extent_m": 20_000.0, "resolution_m": 10.0},
        "retrieval": {"cell_azimuth_deg": 0.45, "ground_m": 20.0},
        "scattering": {"extrapolate": True},
    }
    echoes = from_scatterers(Scene.model_validate(settings), place[None], [1e6])
    worst = 0.0
    with mpmath.workdps(50):
        for pulse in (0, 1, echoes.sizes["pulse"] - 1):
            one = echoes.isel(pulse=pulse)
            volts = one["voltage"].values
            gate = int(np.abs(volts[0]).argmax())
            centres = [(0, 0, mpmath.mpf(height) + side * mpmath.mpf(baseline) / 2) for side in (-1, 1)]
            paths = [
                mpmath.sqrt(sum((mpmath.mpf(float(p)) - q) ** 2 for p, q in zip(place, centre, strict=True)))
                for centre in centres
            ]
            sent = paths[int(one["transmitter"])]
            lower, upper = volts[:, gate].astype(np.complex128)
            assert abs(lower) > 0.0
            for voltage, path in ((lower, paths[0]), (upper, paths[1])):
                worst = max(worst, abs(wrapped(-K * (sent + path), float(np.angle(voltage)))))
            worst = max(worst, abs(wrapped(K * (paths[1] - paths[0]), float(np.angle(lower * np.conj(upper))))))
    assert worst < 1e-6


@pytest.mark.parametrize("transmit", ["single", "switched"])
@pytest.mark.parametrize(("baseline", "height"), [(0.001, 5.0), (3.0, 20.0)])
def test_phase_of_a_facet_at_20_km(baseline: float, height: float, transmit: str) -> None:
    """One facet alone through nodes, gates and interpolation: k ΔR between the receivers, and the lower one's own.

    Asked: 1e-3 rad. float32 phasors and a windowed sinc that both receivers share keep the difference to 1e-5; of the
    phase itself, 2e7 rad, the chain's float64 keeps 4e-9, and nodes in float32 some 1e-5.
    """
    radar = RadarSettings.model_validate({**far_radar(baseline, height, transmit), "sector_deg": (0.0, 1.8)})
    grid = polar_grid(Installation(radar), TracingSettings(facet_m=20.0, columns_per_beam=4), 0)
    shape = (grid.sweep.size, grid.ground_range.size)
    facets = trace_horizon(surface_mesh(grid, np.zeros(shape), np.zeros((*shape, 3), np.float32)))
    column, facet = grid.columns // 2, int(np.argmin(np.abs(np.hypot(facets.distance, height) - FAR)))
    assert facets.lit[:, column, facet].all()
    rcs = np.zeros(facets.height.shape, np.float32)
    rcs[column, facet] = 1e6
    volts = turn_voltages(facets, rcs, Installation(radar), pulses(Installation(radar), 0), 1, np.inf).astype(
        np.complex128
    )
    gate = int(np.abs(volts[:, 0]).max(axis=0).argmax())
    lower, upper = volts[:, 0, gate], volts[:, 1, gate]
    strong = np.abs(lower) > 0.1 * np.abs(lower).max()
    assert np.count_nonzero(strong) > 10
    with mpmath.workdps(50):
        x, half = mpmath.mpf(float(facets.distance[facet])), mpmath.mpf(baseline) / 2
        phase = K * (mpmath.hypot(x, height + half) - mpmath.hypot(x, height - half))
        worst = max(abs(wrapped(phase, angle)) for angle in np.angle(lower * np.conj(upper))[strong])
        # The lower antenna's own path on pulses that it sends itself; its speckle is one number for ever.
        itself = strong & (pulses(Installation(radar), 0).transmitter == 0)
        key = key_of(speckle_stream(1), int(grid.column_number[column]))
        drawn = gaussians(np.uint64(key), facets.distance.size, 1)[0, facet]
        own = -2 * K * mpmath.hypot(x, height - half) + mpmath.mpf(float(np.angle(complex(drawn))))
        alone = max(abs(wrapped(own, angle)) for angle in np.angle(lower)[itself])
    assert worst < 1e-5
    assert alone < 1e-4


def ideal(baseline: float, sea: analytic.FlatSea) -> tuple[NDArray, NDArray, NDArray]:
    """Heights, their quality and the gates of an ideal sea of closed form, seen from 5 m over a baseline."""
    radar = RadarSettings.model_validate(
        {"baseline_m": baseline, "noise": False, "sector_deg": (80.0, 98.0), "range_m": (15.0, 150.0), "prf_hz": 2000.0}
    )
    settings = RetrievalSettings(estimator="single_cell", cell_range_m=1.5, paths="one_way", ground_m=20.0)
    found = retrieve(analytic.echoes(sea, radar), settings)["polar"].to_dataset().isel(turn=0)
    return found["height"].values.astype(np.float64), found["quality"].values, found["range"].values


BASELINES = (0.001, 0.01, 0.05, 0.2, 0.9, 3.0)


@pytest.mark.parametrize("baseline", BASELINES)
def test_a_flat_sea_is_level_over_any_baseline(baseline: float) -> None:
    """The phase of complex64 voltages is good to 1e-7 rad; a height errs by λR/2πB of it: 48 µm at 1 mm and 100 m."""
    height, quality, gate = ideal(baseline, analytic.FlatSea())
    per_radian = SPEED_OF_LIGHT / 10e9 * gate / (2.0 * np.pi * baseline)
    assert np.isfinite(height).all()
    assert (np.abs(height) < 1e-7 * per_radian).all()
    assert (quality & QUALITY_FLAGS["no_echo"] == 0).all()
