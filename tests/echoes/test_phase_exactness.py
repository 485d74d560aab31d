"""Interferometric phase against 50-digit arithmetic, for point scatterers and for facets, out to 3 km."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.echoes import from_scatterers, turn_voltages
from seamap_rt.echoes.paths import facet_paths
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import RangeResponse, gates
from seamap_rt.scene import Scene
from seamap_rt.settings import RadarSettings, TracingSettings
from seamap_rt.tracing.horizon import trace_horizon

RANGES = (15.0, 33.3, 100.0, 400.0, 1000.0, 2000.0, 3000.0)
CORNERS = [(0.05, 3.0, 0.0), (0.05, 20.0, 0.0), (0.9, 3.0, 0.0), (0.9, 20.0, 0.0), (0.2, 5.0, 10.0), (0.9, 20.0, -15.0)]


def mp_phase_centres(radar: RadarSettings, azimuth_deg: float) -> list[tuple]:
    """Both phase centres from the settings alone, in mpmath's working precision."""
    east, north = (f(mpmath.radians(mpmath.mpf(azimuth_deg))) for f in (mpmath.sin, mpmath.cos))
    tilt, half = mpmath.radians(mpmath.mpf(radar.tilt_deg)), mpmath.mpf(radar.baseline_m) / 2
    centres = []
    for side in (-1, 1):
        out, up = side * half * mpmath.sin(tilt), side * half * mpmath.cos(tilt)
        centres.append((out * east, out * north, mpmath.mpf(radar.height_m) + up))
    return centres


def mp_distance(a, b):
    return mpmath.sqrt(sum((mpmath.mpf(p) - mpmath.mpf(q)) ** 2 for p, q in zip(a, b, strict=True)))


def mp_wrapped(phase, found: float) -> float:
    """found − phase, brought into [−π, π)."""
    turn = 2 * mpmath.pi
    return float((mpmath.mpf(found) - phase + mpmath.pi) % turn - mpmath.pi)


def scene_of(ground: float, baseline: float, height: float, tilt: float, transmit: str) -> Scene:
    return Scene.model_validate(
        {
            "name": "phase",
            "radar": {
                "noise": False,
                "baseline_m": baseline,
                "height_m": height,
                "tilt_deg": tilt,
                "transmit": transmit,
                "sector_deg": (37.0, 38.0),
                "range_m": (max(np.hypot(ground, height) - 3.0, 1.0), np.hypot(ground, height) + 3.0),
            },
            "retrieval": {"cell_azimuth_deg": 0.5},
        }
    )


@pytest.mark.parametrize("transmit", ["single", "switched"])
@pytest.mark.parametrize(("baseline", "height", "tilt"), CORNERS)
def test_scatterer_phase(baseline: float, height: float, tilt: float, transmit: str) -> None:
    # Asked: 1e-4 rad. complex64 voltages keep the angle to 6e-8 of a radian or so each; float64 paths of 6 km to
    # 2e-10 rad.
    k = 2 * mpmath.pi * mpmath.mpf(10**10) / mpmath.mpf(SPEED_OF_LIGHT)
    worst = absolute = 0.0
    with mpmath.workdps(50):
        for ground in RANGES:
            scene = scene_of(ground, baseline, height, tilt, transmit)
            place = np.array([ground * np.sin(0.652), ground * np.cos(0.652), 0.37])
            echoes = from_scatterers(scene, place[None], [10.0])
            for pulse in (0, 1, echoes.sizes["pulse"] - 1):
                one = echoes.isel(pulse=pulse)
                gate = int(np.abs(one["voltage"].values[0]).argmax())
                lower, upper = one["voltage"].values[:, gate].astype(np.complex128)
                assert abs(lower) > 0.0
                centres = mp_phase_centres(scene.radar, float(one["azimuth"]))
                for antenna in (0, 1):  # what the dataset tells of the antennas is as good
                    np.testing.assert_allclose(
                        one["position"].values[antenna], [float(c) for c in centres[antenna]], rtol=0, atol=1e-14
                    )
                paths = [mp_distance(place, centre) for centre in centres]
                sent = paths[int(one["transmitter"])]
                found = float(np.angle(lower * np.conj(upper)))
                worst = max(worst, abs(mp_wrapped(k * (paths[1] - paths[0]), found)))
                for voltage, path in ((lower, paths[0]), (upper, paths[1])):
                    absolute = max(absolute, abs(mp_wrapped(-k * (sent + path), float(np.angle(voltage)))))
    assert worst < 1e-6  # two complex64 roundings: measured 5e-8
    assert absolute < 1e-6


@pytest.mark.parametrize(("baseline", "height", "tilt"), CORNERS)
def test_facet_paths(baseline: float, height: float, tilt: float) -> None:
    # Lengths to an ulp or two of themselves; the difference to a few ulp of the baseline, which is 1e-12 rad: nothing
    # cancels. They change by (u − d)·(r − a)/|r − a|, where water flows past an antenna before the axis as it does past
    # the axis: of its 3 m/s by 1 − cos 0.075°, times 0.1 m in 5 m.
    radar = RadarSettings(
        baseline_m=baseline, height_m=height, tilt_deg=tilt, sector_deg=(0.0, 0.9), range_m=(15.0, 3000.0)
    )
    grid = polar_grid(Installation(radar), TracingSettings(facet_m=20.0), 0)
    shape = (grid.sweep.size, grid.ground_range.size)
    rng = np.random.default_rng(5)
    elevation, velocity = rng.normal(0.0, 0.5, shape), rng.normal(0.0, 1.0, (*shape, 3)).astype(np.float32)
    facets = trace_horizon(surface_mesh(grid, elevation, velocity))
    facets = replace(facets, lit=np.ones_like(facets.lit))
    paths = facet_paths(facets, np.ones(facets.height.shape, np.float32), Installation(radar), slice(2, 4))
    assert facets.distance[-1] > 2990.0
    eps = np.finfo(np.float64).eps
    with mpmath.workdps(50):
        lean = mpmath.radians(mpmath.mpf(tilt))
        across, up = (mpmath.mpf(baseline) / 2 * f(lean) for f in (mpmath.sin, mpmath.cos))
        turning = mpmath.mpf(radar.rotation_rpm) * mpmath.pi / 30  # rad/s
        for column in (0, 1):
            for facet in (0, 1, 7, 40, 150, facets.distance.size - 1):
                angle, away = (mpmath.mpf(float(part[facet])) for part in (facets.angle, facets.distance))
                x, y = away * mpmath.cos(angle), away * mpmath.sin(angle)
                z = mpmath.mpf(float(facets.height[2 + column, facet])) - mpmath.mpf(height)
                lower, upper = (mpmath.sqrt((x + s * across) ** 2 + y**2 + (z + s * up) ** 2) for s in (1, -1))
                for pair, exact in enumerate((lower, (lower + upper) / 2, upper)):
                    assert abs(paths.length[pair, column, facet] - exact) < 4 * eps * float(exact)
                assert abs(paths.difference[1, column, facet] - (upper - lower)) < 8 * eps * baseline
                flow, lift = (float(v[2 + column, facet]) for v in (facets.velocity_look, facets.velocity_up))
                for antenna, (s, exact) in enumerate(((1, lower), (-1, upper))):
                    rate = flow * (away + s * across * mpmath.cos(angle)) + lift * (z + s * up)
                    rate += s * turning * across * y  # a leaning array's ends run round, one each way
                    assert abs(paths.coming[antenna, column, facet] - rate / exact) < 1e-7


def test_facets_are_heard_by_how_high_they_stand_over_an_array_that_leans_any_way() -> None:
    """Each antenna's cut, at the direction cosine between the way to the facet and the array's axis."""
    installation = Installation(RadarSettings(sector_deg=(0.0, 0.9), range_m=(15.0, 300.0)))
    grid = polar_grid(installation, TracingSettings(facet_m=2.0), 0)
    shape = (grid.sweep.size, grid.ground_range.size)
    facets = trace_horizon(surface_mesh(grid, np.zeros(shape), np.zeros((*shape, 3), np.float32)))
    rise = facets.height - facets.grid.column_height
    way = np.stack(
        np.broadcast_arrays(facets.distance * np.cos(facets.angle), facets.distance * np.sin(facets.angle), rise), -1
    )
    assert np.ptp(facets.angle) > 1e-3
    cut, found, expected = installation.array.elements[0].antenna.elevation, [], []
    for up in ((0.0, 0.0, 1.0), (0.1, 0.5, np.sqrt(0.74))):
        grid = replace(facets.grid)
        vars(grid)["array_up"] = np.tile(up, (len(rise), 1))
        leaning = replace(facets, grid=grid)
        found.append(facet_paths(leaning, np.ones(rise.shape, np.float32), installation, slice(None)).amplitude[0])
        expected.append(cut(way @ np.array(up) / np.linalg.norm(way, axis=-1)) ** 2)
    # Cuts are tables of steps of 1e-4, amplitudes float32.
    np.testing.assert_allclose(found[1] / found[0], expected[1] / expected[0], rtol=1e-5)


@pytest.mark.parametrize("transmit", ["single", "switched"])
@pytest.mark.parametrize("height", [3.0, 20.0])
def test_phase_of_a_single_facet_through_the_echo_chain(height: float, transmit: str) -> None:
    # One facet echoes, all others are silent: the phase between the receivers is k ΔR of that facet through nodes,
    # gates and
    # interpolation. Asked: 1e-4 rad. float32 phasors and a windowed sinc applied alike to both receivers keep it to
    # 1e-6.
    k = 2 * mpmath.pi * mpmath.mpf(10**10) / mpmath.mpf(SPEED_OF_LIGHT)
    for middle in (30.0, 400.0, 2950.0):
        radar = RadarSettings.model_validate(
            {
                "noise": False,
                "baseline_m": 0.9,
                "height_m": height,
                "transmit": transmit,
                "sector_deg": (0.0, 1.8),
                "range_m": (middle - 6.0, middle + 6.0),
            }
        )
        grid = polar_grid(Installation(radar), TracingSettings(facet_m=2.0), 0)
        shape = (grid.sweep.size, grid.ground_range.size)
        facets = trace_horizon(surface_mesh(grid, np.zeros(shape), np.zeros((*shape, 3), np.float32)))
        column, facet = grid.columns // 2, int(np.argmin(np.abs(np.hypot(facets.distance, height) - middle)))
        rcs = np.zeros(facets.height.shape, np.float32)
        rcs[column, facet] = 1.0
        fired = pulses(Installation(radar), 0)
        voltages = turn_voltages(facets, rcs, Installation(radar), fired, 1, np.inf).astype(np.complex128)
        gate = int(np.abs(voltages[:, 0]).max(axis=0).argmax())
        lower, upper = voltages[:, 0, gate], voltages[:, 1, gate]
        strong = np.abs(lower) > 0.1 * np.abs(lower).max()
        assert np.count_nonzero(strong) > 10
        with mpmath.workdps(50):
            x, z = mpmath.mpf(float(facets.distance[facet])), -mpmath.mpf(height)
            half = mpmath.mpf(radar.baseline_m) / 2
            phase = k * (mpmath.hypot(x, z - half) - mpmath.hypot(x, z + half))
            errors = [abs(mp_wrapped(phase, angle)) for angle in np.angle(lower * np.conj(upper))[strong]]
        assert max(errors) < 1e-5


def test_scatterers_carry_the_scene_and_refuse_what_does_not_fit() -> None:
    scene = Scene.model_validate(
        {
            "name": "one",
            "scattering": {"polarization": "HH"},
            "radar": {"sector_deg": (0.0, 4.0), "range_m": (15.0, 60.0), "noise": False},
        }
    )
    assert from_scatterers(scene, [[0.0, 30.0, 0.0]], [1.0]).attrs["polarization"] == "HH"
    with pytest.raises(ValueError, match=r"rcs \(3,\): must be one number, or one for each of the 1 scatterers"):
        from_scatterers(scene, [[0.0, 30.0, 0.0]], [1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="must be finite"):
        from_scatterers(scene, [[0.0, np.nan, 0.0]], [1.0])


def test_an_isotropic_antenna_hears_behind_itself() -> None:
    scene = Scene.model_validate(
        {
            "name": "round",
            "radar": {"range_m": (15.0, 60.0), "noise": False, "prf_hz": 1000.0, "antenna": {"pattern": "isotropic"}},
        }
    )
    volts = np.abs(from_scatterers(scene, [[0.0, 30.0, 0.0]], [1.0])["voltage"].values[::2, 0]).max(axis=1)
    np.testing.assert_allclose(volts, volts[0], rtol=1e-5)  # every other pulse: the lower antenna's own
    # The radar equation of 1 m² and gains of 1: P λ² σ/((4π)³ R⁴ L), of which a gate beside it has the response.
    radar, distance = scene.radar, np.hypot(30.0, scene.radar.height_m - 0.5 * scene.radar.baseline_m)
    wavelength, loss = SPEED_OF_LIGHT / radar.frequency_hz, 10.0 ** (radar.losses_db / 10.0)
    received = radar.transmit_power_w * wavelength**2 / ((4.0 * np.pi) ** 3 * distance**4 * loss)
    beside = np.abs(gates(radar) - distance).min()
    response = float(RangeResponse.of(radar)(np.array([beside]))[0])
    np.testing.assert_allclose(volts[0], np.sqrt(received) * response, rtol=1e-5)  # complex64
