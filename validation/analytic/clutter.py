"""The echo of a flat sea by quadrature: what every gate must receive, and where a gate's echo comes from.

Only the one-way pattern, its gain and the range response are taken from the radar; the sum over the sea is an
integral of its own, the radar equation's,

    Pr(r) = Pt λ² σ0/((4π)³ L) ∬ G²(az, el) |h(r − R)|² R⁻⁴ dA,

over the azimuths within ±3 beam widths, which is as far as the simulator's columns run on. A homogeneous flat sea
gives the same power at every pulse, so that the mean over a dwell is this number too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.compute.quadrature import gauss_legendre
from seamap_rt.conventions import SPEED_OF_LIGHT, from_db
from seamap_rt.radar.antenna import antenna
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.settings import RadarSettings

from .geometry import height_from_range_difference, range_difference

_BEAMS = 3.0  # beam widths to either side
_RANGE_NODES, _AZIMUTH_NODES = 96, 96  # doubling both changes no gate by 1e-9


def flat_sea_power(radar: RadarSettings, nrcs: ArrayLike, gates: ArrayLike) -> NDArray[np.float64]:
    """Expected echo power [W] of each gate [m] from a flat sea of constant NRCS (linear, per horizontal area).

    Both antennas are taken to stand at radar.height_m: it is the power of the pair of lower and upper antenna.
    """
    ranges, response = np.asarray(gates, dtype=np.float64), RangeResponse.of(radar)
    slant, weight = _slant_nodes(radar, ranges)
    # On a flat sea the ground range's element of area is ρ dρ = R dR.
    seen = response(ranges[..., None] - slant) ** 2 * _two_way_cut(radar, slant) / slant**3
    return _constant(radar) * np.asarray(nrcs, dtype=np.float64) * np.sum(weight * seen, axis=-1)


def flat_sea_power_textbook(radar: RadarSettings, nrcs: ArrayLike, gates: ArrayLike) -> NDArray[np.float64]:
    """Pt G² λ² σ0 A/((4π)³ R⁴ L) with A = R θaz (cτ/2) sec ψ, the closed form of the handbooks.

    It leaves out the two-way azimuth pattern's integral, the elevation pattern and what the receiver's filter takes
    from the pulse; θaz is the one-way beam width at −3 dB.
    """
    ranges = np.asarray(gates, dtype=np.float64)
    grazing = np.arcsin(radar.height_m / ranges)
    width = _beam(radar)
    area = ranges * width * 0.5 * SPEED_OF_LIGHT * radar.pulse_width_s / np.cos(grazing)
    return _constant(radar) * np.asarray(nrcs, dtype=np.float64) * area / ranges**4


def flat_sea_gate_height(radar: RadarSettings, gates: ArrayLike, window_m: float = 0.0) -> NDArray[np.float64]:
    """Height [m] that an ideal retrieval gives to each gate [m] of a distributed flat sea: what an infinite number of
    looks leaves.

    A gate weighs what it hears by |h|², R⁻³ and the elevation pattern, so its centre of power R_c, 1/R_c = ⟨1/R⟩,
    lies off its middle, and the phase of R_c, read at r, is the height H (1 − r/R_c). Here the covariance itself is
    integrated, ∫ … exp(jk ΔR), so that a phase that spreads far within the gate is kept too. `window_m`: length of the
    retrieval's range window, over which the covariances of neighbouring gates (radar.range_sampling_m apart) are added
    after each has been turned along the straight line that touches the phase of mean sea level (its central
    difference). Gates refer to the mean half path of the mode's interferograms, R₁ + ΔR/2 (switched) or R₁ + ΔR/4
    (single).
    """
    ranges, response = np.asarray(gates, dtype=np.float64), RangeResponse.of(radar)
    share = 0.5 if radar.transmit == "switched" else 0.25
    wavenumber = 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT

    reach = int(np.ceil(0.5 * window_m / radar.range_sampling_m))
    total = np.zeros(ranges.shape, dtype=np.complex128)
    spacing = radar.range_sampling_m
    beyond, before = (_flat_difference(radar, ranges + step, share) for step in (spacing, -spacing))
    middle = _flat_difference(radar, ranges, share)
    for shift in spacing * np.arange(-reach, reach + 1):
        high = min(shift + 0.5 * radar.range_sampling_m, 0.5 * window_m)
        low = max(shift - 0.5 * radar.range_sampling_m, -0.5 * window_m)
        share_of_window = 1.0 if reach == 0 else max(high - low, 0.0)
        gate = ranges + shift
        slant, weight = _slant_nodes(radar, gate)
        seen = response(gate[..., None] - slant) ** 2 * _two_way_cut(radar, slant) / slant**3
        line = middle + 0.5 * (beyond - before) * shift / spacing
        departure = _flat_difference(radar, slant, share) - line[..., None]
        total += share_of_window * np.sum(weight * seen * np.exp(1j * wavenumber * departure), axis=-1)

    difference = middle + np.angle(total) / wavenumber
    tilt = np.radians(radar.tilt_deg)
    lower_height = radar.height_m - 0.5 * radar.baseline_m * np.cos(tilt)
    return height_from_range_difference(ranges - share * difference, difference, radar.baseline_m, lower_height, tilt)


def _constant(radar: RadarSettings) -> float:
    """Pt G² λ²/((4π)³ L) [W m²]."""
    wavelength = SPEED_OF_LIGHT / radar.frequency_hz
    gain, loss = antenna(radar).gain, float(from_db(radar.losses_db))
    return radar.transmit_power_w * gain**2 * wavelength**2 / ((4.0 * np.pi) ** 3 * loss)


def _beam(radar: RadarSettings) -> float:
    """The azimuth beam's width [rad]; of an isotropic antenna, which has none, that of the scene."""
    width = antenna(radar).azimuth_beamwidth_deg
    return float(np.radians(width if np.isfinite(width) else radar.antenna.azimuth_beamwidth_deg))


def _slant_nodes(radar: RadarSettings, gates: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Gauss–Legendre nodes and weights (…, node) over the slant ranges of the sea that each gate hears."""
    nodes, weights = gauss_legendre(_RANGE_NODES)
    support = RangeResponse.of(radar).support_m
    far = np.maximum(gates + support, radar.height_m)[..., None]
    near = np.maximum(gates - support, radar.height_m)[..., None]  # no sea is nearer than the mast's foot
    return 0.5 * (near + far) + 0.5 * (far - near) * nodes, 0.5 * (far - near) * weights


def _two_way_cut(radar: RadarSettings, slant: NDArray[np.float64]) -> NDArray[np.float64]:
    """∫ E⁴(az, el) d az [rad] towards the sea at each slant range, E the one-way voltage pattern."""
    nodes, weights = gauss_legendre(_AZIMUTH_NODES)
    half = min(np.pi, _BEAMS * _beam(radar))
    elevation = -np.arcsin(radar.height_m / slant)
    total = np.zeros(slant.shape)
    for node, weight in zip(half * nodes, half * weights, strict=True):
        total += weight * antenna(radar).voltage(node, elevation) ** 4
    return total


def _flat_difference(radar: RadarSettings, mean_path: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """ΔR [m] of the point of the flat sea with R₁ + share ΔR = mean_path."""
    tilt = np.radians(radar.tilt_deg)
    height = radar.height_m - 0.5 * radar.baseline_m * np.cos(tilt)
    difference = np.zeros(mean_path.shape)
    for _ in range(12):  # each step gains a factor of about B/R
        lower = mean_path - share * difference
        ground = np.sqrt(np.maximum(lower**2 - height**2, 0.0))
        difference = range_difference(ground, 0.0, radar.baseline_m, height, tilt)
    return difference
