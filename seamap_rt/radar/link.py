"""The link budget's radar part: cells, the textbook's echo, the pulses of a dwell and what adding them up gains.

The textbook's echo from the sea (Skolnik 2001, chapter 7) has the beam's peak on every cell, a beam of even strength
as wide as its −3 dB points and a pulse that the receiver leaves whole:

    Pr = Pt G² λ² σ0 A / ((4π)³ R⁴ L),    A = R θaz (cτ/2) sec ψ.

`losses_to_textbook` says what real patterns and the receiver's filter take from that. Nothing here needs a sea: σ0 is
given. Ranges are slant ranges to mean sea level, seen from radar.height_m by a boat that lies level.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..conventions import SPEED_OF_LIGHT, db, from_db, radar_wavelength
from ..physics.shadowing import shadowing_smith67
from ..settings import RadarSettings
from .antenna import antenna
from .array import antenna_array
from .receiver import noise_power, pulse_coherence
from .waveform import RangeResponse, blind_range_m, receiver_filter, window_weight

_BEAMS = 3.0  # beam widths to either side over which an azimuth pattern counts, as everywhere in the simulation
_RANGES, _AZIMUTHS, _OFFSETS = 2001, 401, 801  # of the flat sea's integral: within 1e-8 of its limit
_WINDOW = 400  # ranges of the window, over which a share is taken
_STEPS = 4096  # of those integrals, whose integrands vanish at both ends: doubling changes nothing by 1e-6 dB


class Dwell(NamedTuple):
    """What one receiver hears of a point while the −3 dB beam passes it."""

    duration_s: float
    pulses: int
    interval_s: float  # between the pulses that it hears


def beam_widths_deg(radar: RadarSettings) -> tuple[float, float]:
    """One-way −3 dB widths in azimuth and elevation; where a pattern has none, those that the scene gives."""
    aerial, given = antenna(radar), radar.antenna
    across, up = aerial.azimuth_beamwidth_deg, aerial.elevation_beamwidth_deg
    return (
        across if np.isfinite(across) else given.azimuth_beamwidth_deg,
        up if np.isfinite(up) else given.elevation_beamwidth_deg,
    )


def footprint_m(radar: RadarSettings, range_m: ArrayLike) -> NDArray[np.float64]:
    """Width [m] of the −3 dB beam across the look at a range [m]."""
    return 2.0 * np.asarray(range_m, dtype=np.float64) * np.tan(0.5 * np.radians(beam_widths_deg(radar)[0]))


def grazing_angle(radar: RadarSettings, range_m: ArrayLike) -> NDArray[np.float64]:
    """Angle [rad] under which mean sea level is seen at a slant range [m]; ValueError where there is no sea so near."""
    ranges = np.asarray(range_m, dtype=np.float64)
    if not np.all(ranges > radar.height_m):
        raise ValueError(
            f"range_m = {np.min(ranges):g}: must be greater than radar.height_m = {radar.height_m:g}, where the sea "
            "begins; look farther"
        )
    return np.arcsin(radar.height_m / ranges)


def middle_m(radar: RadarSettings) -> float:
    """Slant range [m] in the middle of the window, or of its part beyond the sea's nearest point."""
    return 0.5 * (max(radar.range_m[0], radar.height_m) + radar.range_m[1])


def window_m(radar: RadarSettings) -> NDArray[np.float64]:
    """(400,) slant ranges [m] that fill the window evenly, where there is sea."""
    near, far = max(radar.range_m[0], radar.height_m), radar.range_m[1]
    return near + (far - near) * (np.arange(_WINDOW) + 0.5) / _WINDOW


def shadowed_share(radar: RadarSettings, slope_variance: float) -> float:
    """Share of the window that lies in shadow; slope_variance: along the look. Smith (1967)."""
    if slope_variance <= 0.0:
        return 0.0
    slope = np.tan(grazing_angle(radar, window_m(radar)))
    return float(np.mean(1.0 - shadowing_smith67(slope / np.sqrt(2.0 * slope_variance))))


def share_outside(radar: RadarSettings, low_deg: float, high_deg: float) -> float:
    """Share of the window that is seen under a grazing angle outside of low_deg to high_deg."""
    grazing = np.degrees(grazing_angle(radar, window_m(radar)))
    return float(np.mean((grazing < low_deg) | (grazing > high_deg)))


def gain_towards_sea(radar: RadarSettings, range_m: ArrayLike) -> NDArray[np.float64]:
    """One-way gain (a ratio) in the middle of the beam towards mean sea level at a slant range [m]."""
    aerial = antenna(radar)
    return aerial.gain * aerial.voltage(0.0, -grazing_angle(radar, range_m)) ** 2


# ------------------------------------------------------------------------------------------- power from the sea


def range_cell_m(radar: RadarSettings) -> float:
    """Length [m] along the ray of the textbook's cell: cτ/2, and c/(2B) of a compressed chirp."""
    width = 1.0 / radar.chirp_bandwidth_hz if radar.waveform == "chirp" else radar.pulse_width_s
    return 0.5 * SPEED_OF_LIGHT * width


def compression_gain(radar: RadarSettings) -> float:
    """Signal to noise ratio that compressing a chirp gains at best: its length times the receiver's bandwidth."""
    return radar.pulse_width_s * radar.bandwidth_hz if radar.waveform == "chirp" else 1.0


def cell_area(radar: RadarSettings, range_m: ArrayLike) -> NDArray[np.float64]:
    """A = R θaz (cτ/2) sec ψ [m²] at a slant range [m]."""
    ranges = np.asarray(range_m, dtype=np.float64)
    across = ranges * np.radians(beam_widths_deg(radar)[0])
    return across * range_cell_m(radar) / np.cos(grazing_angle(radar, ranges))


def textbook_power(
    radar: RadarSettings, nrcs: ArrayLike, range_m: ArrayLike, gain: float | None = None
) -> NDArray[np.float64]:
    """Echo power [W] by the textbook's equation; nrcs: σ0, a ratio. gain: in place of the antenna's own, a ratio."""
    ranges = np.asarray(range_m, dtype=np.float64)
    peak = antenna(radar).gain if gain is None else gain
    sent = radar.transmit_power_w * peak**2 * radar_wavelength(radar.frequency_hz) ** 2 * compression_gain(radar)
    spread = (4.0 * np.pi) ** 3 * ranges**4 * from_db(radar.losses_db)
    return sent * np.asarray(nrcs, dtype=np.float64) * cell_area(radar, ranges) / spread


def signal_to_noise(radar: RadarSettings, nrcs: float, range_m: float) -> float:
    """Signal to noise of one pulse, a ratio, by the textbook's equation with the antenna's gain towards the sea; nrcs:
    σ0, a ratio."""
    towards = float(gain_towards_sea(radar, range_m))
    return float(textbook_power(radar, nrcs, range_m, towards)) / noise_power(radar)


def signal_to_clutter_db(radar: RadarSettings, rcs_dbsm: float, nrcs: float, range_m: float) -> float:
    """A target's cross-section over that of the sea in its cell, dB; nrcs: σ0, a ratio."""
    return rcs_dbsm - float(db(nrcs * cell_area(radar, range_m)))


def flat_sea_power(radar: RadarSettings, nrcs: ArrayLike, range_m: ArrayLike) -> NDArray[np.float64]:
    """Echo power [W] of gates (range,) [m] from a flat sea of constant σ0 (a ratio), by the radar equation's integral:

        Pr(r) = Pt λ² σ0/((4π)³ L) ∬ G²(az, el) h²(r − R) R⁻³ dR d az,

    h being the response to a point at R. Both antennas stand at radar.height_m. The textbook's equation is its limit
    for an even beam and a rectangular response.
    """
    ranges = np.asarray(range_m, dtype=np.float64)
    response, aerial = RangeResponse.of(radar), antenna(radar)
    near = max(float(ranges.min()) - response.support_m, radar.height_m)
    far = float(ranges.max()) + response.support_m
    slant = 1.0 / np.linspace(1.0 / near, 1.0 / far, _RANGES)  # even in elevation
    half = min(np.pi, _BEAMS * np.radians(beam_widths_deg(radar)[0]))
    azimuth = np.linspace(-half, half, _AZIMUTHS)
    # The pattern's integral changes slowly with range: it is tabulated, and interpolated.
    cut = aerial.voltage(azimuth, -np.arcsin(radar.height_m / slant)[:, None]) ** 4
    pattern = scipy.interpolate.CubicSpline(slant, scipy.integrate.trapezoid(cut, azimuth, axis=-1))
    offset = np.linspace(-response.support_m, response.support_m, _OFFSETS)
    slant_range = ranges[..., None] + offset
    on_sea = slant_range >= radar.height_m  # no sea is nearer than the mast's foot
    slant_range = np.maximum(slant_range, radar.height_m)
    received = np.where(on_sea, pattern(slant_range) / slant_range**3 * response(offset) ** 2, 0.0)
    whole = scipy.integrate.trapezoid(received, offset, axis=-1)
    sent = radar.transmit_power_w * aerial.gain**2 * radar_wavelength(radar.frequency_hz) ** 2
    return sent * np.asarray(nrcs, dtype=np.float64) * whole / ((4.0 * np.pi) ** 3 * from_db(radar.losses_db))


class Losses(NamedTuple):
    """What the textbook's equation leaves out, dB; positive takes from the echo."""

    azimuth: float  # the two-way pattern's integral, over an even beam as wide as its −3 dB points
    elevation: NDArray[np.float64]  # (range,) two-way, towards mean sea level
    response: float  # of the range response, over a whole pulse


def losses_to_textbook(radar: RadarSettings, range_m: ArrayLike) -> Losses:
    """What the simulator's echo has less at slant ranges [m], each part by itself.

    What their sum neglects: R⁻³ and the elevation pattern within one cell, 0.01 dB from 50 m on at 5 m, and that an
    arc on the ground is R cos ψ θaz, not R θaz, long, 0.02 dB there.
    """
    aerial, beam = antenna(radar), np.radians(beam_widths_deg(radar)[0])
    angle = np.linspace(-1.0, 1.0, _STEPS + 1) * min(np.pi, _BEAMS * beam)
    even = np.trapezoid(aerial.azimuth(np.sin(angle)) ** 4, angle) / beam
    response = RangeResponse.of(radar)
    offset = np.linspace(-1.0, 1.0, _STEPS + 1) * response.support_m
    energy = np.trapezoid(response(offset) ** 2, offset) / (range_cell_m(radar) * compression_gain(radar))
    towards = gain_towards_sea(radar, range_m) / aerial.gain
    return Losses(-float(db(even)), -2.0 * db(towards), -float(db(energy)))


def eclipsed_share(radar: RadarSettings, range_m: ArrayLike) -> NDArray[np.float64]:
    """Share of the sea's compressed echo that is left where a chirp's head comes back while its tail is still sent.

    At R < cT/2 only the last R/(cT/2) of the sweep is heard: of the energy under |H W|², the receiver's filter times
    the window, what lies there. 1 for a plain pulse, whose gates are heard whole or not at all.
    """
    ranges = np.asarray(range_m, dtype=np.float64)
    if radar.waveform != "chirp":
        return np.ones_like(ranges)
    swept = np.linspace(-0.5, 0.5, 2001) * radar.chirp_bandwidth_hz
    window = window_weight(swept, radar.chirp_bandwidth_hz, radar.compression_window)
    power = (window * receiver_filter(swept, radar.bandwidth_hz)) ** 2
    energy = scipy.integrate.cumulative_trapezoid(power, swept, initial=0.0)
    swept_share = np.clip(ranges / blind_range_m(radar), 0.0, 1.0)
    # The window and the filter are even, so that the tail's share is the head's.
    return np.interp((swept_share - 0.5) * radar.chirp_bandwidth_hz, swept, energy) / energy[-1]


# ------------------------------------------------------------------------------------------- adding pulses up


def dwell(radar: RadarSettings) -> Dwell:
    """The pulses of one receiver while the −3 dB azimuth beam passes a point, or while a staring antenna looks.

    Pulses of all transmitters count: those of another one differ by a phase that is constant over the dwell. With
    alternating pulses a receiver hears only those of its turn.
    """
    turning, array = radar.scan == "turning", antenna_array(radar)
    duration = beam_widths_deg(radar)[0] / (6.0 * radar.rotation_rpm) if turning else radar.stare_s
    duty = sum(len(slot.receivers) for slot in array.cycle) / (len(array.cycle) * len(array.receivers))
    rate = radar.prf_hz * duty
    return Dwell(duration, max(1, round(duration * rate)), 1.0 / rate)


def noncoherent_gain(pulses: int) -> float:
    """√N: by so much (a ratio) the weakest σ0 that stands out falls when the powers of N pulses are added.

    The square-root law for echoes below the noise (Marcum 1947; Skolnik 2001, section 2.6): 10 log10 √N dB.
    It does not include the echo's own speckle, which adding correlated pulses leaves as it is.
    """
    return float(np.sqrt(pulses))


def coherent_gain(pulses: int, interval_s: float, decorrelation_time_s: float, coherence: float = 1.0) -> float:
    """Signal to noise ratio that adding N voltages in phase gains over one: (1/N) Σₘ Σₙ ρ((m − n) T).

    The echo's mean Doppler is taken out first and its correlation is ρ(τ) = exp(−(τ/τc)²), the noise of each pulse its
    own. N for a still sea; √π τc/T, however many pulses there are, for one that decorrelates within the dwell.
    coherence: that the transmitter leaves between two pulses (`transmitter.pulse_coherence`); with none the gain is 1.
    """
    lag = np.arange(1, pulses, dtype=np.float64)
    correlation = coherence * np.exp(-np.square(lag * interval_s / decorrelation_time_s))
    return 1.0 + 2.0 * float(np.sum((1.0 - lag / pulses) * correlation))


class Integration(NamedTuple):
    """A method to add pulses up, and the ratio by which it exceeds one pulse."""

    name: str
    gain: float


def integrations(radar: RadarSettings, decorrelation_time_s: float) -> tuple[Integration, Integration, Integration]:
    """One pulse, a dwell added without phase, a dwell added in phase; gains are ratios, times in seconds."""
    pulses, coherence = dwell(radar), pulse_coherence(radar)
    return (
        Integration("one pulse", 1.0),
        Integration("non-coherent", noncoherent_gain(pulses.pulses)),
        Integration("coherent", coherent_gain(pulses.pulses, pulses.interval_s, decorrelation_time_s, coherence)),
    )


def minimum_nrcs(radar: RadarSettings, power_of_unity: ArrayLike, gain: float = 1.0) -> NDArray[np.float64]:
    """σ0 (a ratio) at which the signal to noise ratio is 0 dB; power_of_unity: the echo [W] of σ0 = 1."""
    return noise_power(radar) / (np.asarray(power_of_unity, dtype=np.float64) * gain)


# ------------------------------------------------------------------------------------------------ the budget


@dataclass(frozen=True)
class Budget:
    """One method to compute the echo; arrays (range,) and (integration, range), ratios and watts."""

    name: str
    power: NDArray[np.float64]  # W, of one pulse
    snr: NDArray[np.float64]
    minimum_nrcs: NDArray[np.float64]


@dataclass(frozen=True)
class LinkBudget:
    """A radar's echo from the mean sea against range, beside its noise; arrays (range,)."""

    range: NDArray[np.float64]  # m, slant
    grazing: NDArray[np.float64]  # rad
    gain: NDArray[np.float64]  # towards the sea, a ratio
    area: NDArray[np.float64]  # m²
    nrcs: NDArray[np.float64]
    nrcs_model: str
    noise: float  # W
    integrations: tuple[Integration, ...]
    budgets: tuple[Budget, ...]


def budget(
    radar: RadarSettings,
    name: str,
    power_of_unity: NDArray[np.float64],
    nrcs: NDArray[np.float64],
    integrations: tuple[Integration, ...],
) -> Budget:
    """What follows from the echo [W] of σ0 = 1 and from σ0 itself, for each method to add pulses up."""
    power = power_of_unity * nrcs
    minimum = np.stack([minimum_nrcs(radar, power_of_unity, each.gain) for each in integrations])
    return Budget(name, power, nrcs / minimum, minimum)


def furthest(range_m: NDArray[np.float64], ratio: NDArray[np.float64]) -> float:
    """Range [m] beyond which a ratio (range,), drawn as straight lines in log-log, stays below 1.

    NaN where it never reaches 1, inf where it still does at the last range.
    """
    above = np.flatnonzero(ratio >= 1.0)
    if above.size == 0:
        return float("nan")
    last = int(above[-1])
    if last == ratio.size - 1:
        return float("inf")
    levels = np.log(np.maximum(ratio[last : last + 2], 1e-300))
    share = levels[0] / (levels[0] - levels[1])
    return float(range_m[last] * (range_m[last + 1] / range_m[last]) ** share)


def nrcs_words(budget: LinkBudget) -> str:
    """Where the mean σ0 comes from, and what of shadows it holds."""
    if budget.nrcs_model == "constant":
        return "mean σ0: constant; shadows are not counted"
    return f"mean σ0: {budget.nrcs_model}, which holds the shadows of its data; no others are counted"
