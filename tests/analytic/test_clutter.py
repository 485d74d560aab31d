"""The quadrature that judges the echo chain is itself judged: by an adaptive quadrature, by limits, and by the
handbook."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from seamap_rt.compute.quadrature import gauss_legendre
from seamap_rt.conventions import SPEED_OF_LIGHT, db
from seamap_rt.radar.antenna import antenna
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.settings import AntennaSettings, RadarSettings
from validation.analytic import clutter, flat_sea_gate_height, flat_sea_power, flat_sea_power_textbook

NRCS = 1e-4
GATES = np.array([30.0, 57.0, 100.0, 200.0, 400.0])


def radar_of(pattern: str, height: float = 5.0, **others) -> RadarSettings:
    return RadarSettings.model_validate({"antenna": {"pattern": pattern}, "height_m": height, **others})


@pytest.mark.parametrize("pattern", ["slotted_waveguide", "gaussian"])
@pytest.mark.parametrize("height", [5.0, 20.0])
def test_nodes_suffice(pattern: str, height: float, monkeypatch: pytest.MonkeyPatch) -> None:
    radar = radar_of(pattern, height)
    power, level = flat_sea_power(radar, NRCS, GATES), flat_sea_gate_height(radar, GATES)
    monkeypatch.setattr(clutter, "gauss_legendre", lambda _: gauss_legendre(250))
    np.testing.assert_allclose(power, flat_sea_power(radar, NRCS, GATES), rtol=1e-9)
    np.testing.assert_allclose(level, flat_sea_gate_height(radar, GATES), rtol=0, atol=1e-9)


@pytest.mark.parametrize("pattern", ["slotted_waveguide", "gaussian"])
@pytest.mark.parametrize("tilt", [0.0, 6.0])
def test_power_against_cartesian_adaptive_quadrature(pattern: str, tilt: float) -> None:
    # The same integral in other variables (ground range and azimuth, ρ dρ dα) by another rule (adaptive Gauss–Kronrod).
    radar = radar_of(pattern, tilt_deg=tilt)
    beam, response = antenna(radar), RangeResponse.of(radar)
    gate, half = 40.0, 3.0 * np.radians(radar.antenna.azimuth_beamwidth_deg)

    def across(ground: float) -> float:
        slant = np.hypot(ground, radar.height_m)
        elevation = -np.arctan2(radar.height_m, ground)
        cut = quad(lambda a: float(beam.voltage(a, elevation)) ** 4, -half, half, epsrel=1e-9, epsabs=0.0, limit=400)[0]
        return float(response(gate - slant)) ** 2 * cut * ground / slant**4

    near, far = (np.sqrt((gate + side * response.support_m) ** 2 - radar.height_m**2) for side in (-1.0, 1.0))
    integral = quad(across, near, far, epsrel=1e-8, epsabs=0.0, limit=400)[0]
    wavelength = SPEED_OF_LIGHT / radar.frequency_hz
    factor = beam.gain**2 * wavelength**2 / ((4.0 * np.pi) ** 3 * 10.0 ** (radar.losses_db / 10.0))
    expected = radar.transmit_power_w * factor * NRCS * integral
    np.testing.assert_allclose(flat_sea_power(radar, NRCS, gate), expected, rtol=1e-7)


def test_the_textbook_form_and_where_it_differs() -> None:
    # Each known difference as a number of its own; together they are the whole gap (Gaussian beam, 5 m mast).
    radar = radar_of("gaussian")
    gap = db(flat_sea_power_textbook(radar, NRCS, GATES) / flat_sea_power(radar, NRCS, GATES))

    # 1. ∫E⁴ dα of a Gaussian beam is θ√(π/(8 ln 2)), not θ.
    azimuth = -db(np.sqrt(np.pi / (8.0 * np.log(2.0))))
    assert azimuth == pytest.approx(1.233, abs=1e-3)  # −1.2 dB, of a Gaussian beam
    # 2. The filter shortens the pulse's energy: ∫|h|² dr against cτ/2.
    response, length = RangeResponse.of(radar), 0.5 * SPEED_OF_LIGHT * radar.pulse_width_s
    heard = quad(lambda r: float(response(r)) ** 2, -response.support_m, response.support_m, epsrel=1e-10)[0]
    pulse = -db(heard / length)
    assert pulse == pytest.approx(1.65, abs=0.01)  # 20 ns through 50 MHz, Gaussian; a brick wall takes 0.95
    # 3. Two ways through the elevation pattern at the grazing angle of the gate: 24 dB (ψ/18°)².
    grazing = np.degrees(np.arcsin(radar.height_m / GATES))
    elevation = 40.0 * np.log10(np.e) * 2.0 * np.log(2.0) * (grazing / 18.0) ** 2
    assert elevation[0] == pytest.approx(6.87, abs=0.05)  # −6.8 dB at 30 m
    # What is left: the variation of R⁻³ and of the elevation pattern within the gate, second order in (3 m/R).
    np.testing.assert_allclose(gap, azimuth + pulse + elevation, atol=0.15)
    np.testing.assert_allclose(gap[2:], (azimuth + pulse + elevation)[2:], atol=0.01)
    assert gap[-1] == pytest.approx(2.93, abs=0.01)


def test_textbook_area_and_noise_equivalent_nrcs() -> None:
    # By hand: A = 9.43 m² at 100 m; 0 dB SNR for one pulse at NRCS = −51.2 dB with 31.45 dBi.
    radar = radar_of("slotted_waveguide", antenna=AntennaSettings(gain_dbi=31.45))
    power = flat_sea_power_textbook(radar, 1.0, 100.0)
    noise = -93.98 - 30.0
    assert noise - db(power) == pytest.approx(-51.2, abs=0.05)
    wavelength = SPEED_OF_LIGHT / 10e9
    area = power * (4.0 * np.pi) ** 3 * 100.0**4 * 10.0**0.2 / (10.0**6.29 * wavelength**2)
    assert area == pytest.approx(9.43, abs=0.01)


@pytest.mark.parametrize("transmit", ["single", "switched"])
@pytest.mark.parametrize("baseline", [0.05, 0.2, 0.9])
def test_gate_height_is_that_of_the_centre_of_power(transmit: str, baseline: float) -> None:
    # The phase goes as H/R, so that its mean is that of R_c, 1/R_c = ∫(w/R)/∫w, and z = H (1 − r/R_c). The
    # covariance's own argument differs from the mean phase by the phase's third moment in the gate, and H/R from ΔR/B
    # by (B/R)²: both below 0.1 mm from 57 m on; at 30 m and B = 0.9 m the phase spreads by a radian over the gate.
    radar = radar_of("slotted_waveguide", transmit=transmit, baseline_m=baseline)
    slant, weight = clutter._slant_nodes(radar, GATES)
    seen = weight * RangeResponse.of(radar)(GATES[:, None] - slant) ** 2 * clutter._two_way_cut(radar, slant) / slant**3
    simple = radar.height_m * (1.0 - GATES * np.sum(seen / slant, axis=1) / np.sum(seen, axis=1))
    got = flat_sea_gate_height(radar, GATES)
    np.testing.assert_allclose(got[1:], simple[1:], rtol=0, atol=1e-4)
    np.testing.assert_allclose(got[0], simple[0], rtol=0, atol=5e-3 if baseline > 0.5 else 2e-4)
    assert np.all(np.abs(got[1:]) < 0.005)


def test_gate_height_of_an_endless_plane_needs_a_baseline() -> None:
    assert np.isnan(flat_sea_gate_height(radar_of("slotted_waveguide", baseline_m=0.0), GATES)).all()


def test_gate_height_window() -> None:
    # A window of one gate is no window. One of three metres gives half its weight to gates 1.5 m off, whose phase H/R
    # bends away from the straight line by H (1.5/R)²: half of that is the most by which it can shift a gate's height.
    radar = radar_of("slotted_waveguide")
    none, one, three = (flat_sea_gate_height(radar, GATES, window_m=w) for w in (0.0, radar.range_sampling_m, 3.0))
    np.testing.assert_allclose(none, one, rtol=0, atol=1e-12)
    shift = 0.5 * radar.height_m * (radar.range_sampling_m / GATES) ** 2
    assert np.all(np.abs(three - none) < shift + 1e-4)
