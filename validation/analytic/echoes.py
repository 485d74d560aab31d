"""Echoes from closed forms: a test of the retrieval, made with none of the simulator's own echoes.

Phases are those of exact float64 paths; what is heard is one point a gate (ideal, or speckled by drawn numbers of a set
coherence), or the sum over random points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT, from_db
from seamap_rt.dataset import build
from seamap_rt.radar.array import antenna_array
from seamap_rt.radar.waveform import RangeResponse, gates
from seamap_rt.settings import RadarSettings

from .point_sea import Points, PointSea
from .seas import Field, Surface
from .sight import Array, phasor

Motion = tuple[float, float, float] | Callable[[Field], Field]
Voltages = NDArray[np.complex128]

_PULSES_AT_ONCE = 50


def echoes(
    sea: Surface | PointSea,
    radar: RadarSettings | None = None,
    *,
    attitude_deg: Motion = (0.0, 0.0, 0.0),
    position_m: Motion = (0.0, 0.0, 0.0),
    turns: int = 1,
    coherence: ArrayLike | None = None,
    looks: float = 1.0,
    snr_db: ArrayLike | None = None,
    radial_velocity_m_s: float = 0.0,
    seed: int = 1,
) -> xr.Dataset:
    """Schema `echoes` of a sea of closed form.

        from seamap_rt import analytic, retrieve
        from seamap_rt.settings import RadarSettings

        radar = RadarSettings(baseline_m=0.9, transmit="switched", interferogram="alternating_pulse")
        swell = analytic.SinusoidSea(height_m=0.2, wavelength_m=80.0, wave_from_deg=300.0)
        exact = analytic.echoes(swell, radar)  # no speckle: heights to a millimetre
        speckled = analytic.echoes(swell, radar, coherence=0.98, looks=4, snr_db=20.0, seed=7)
        heeled = analytic.echoes(swell, radar, attitude_deg=(10.0, 3.0, 45.0), position_m=(0.0, 8.0, 0.5))
        points = analytic.echoes(analytic.PointSea(swell), radar, snr_db=20.0)
        error = retrieve(speckled)["polar"]["height"] - retrieve(exact)["polar"]["height"]

    A surface echoes ideally: in each gate of each pulse the one point in the middle of the fan-shaped beam whose
    mean half path is the gate's range, at 1 W; a gate that ends above the water receives nothing (0), and
    nothing hides the sea. The points of a PointSea are summed one by one: a whole turn takes most of a minute. The
    turntable, the tilt, the modes, the baseline's error and the channels are those of `radar`; the Earth is flat,
    nothing fades with range or elevation, and power, losses and digital receiver are left out; pulses are coherent.

    attitude_deg: roll (starboard down), pitch (bow up), heading; position_m: of the array's middle from
    (0, 0, radar.height_m); either three numbers or a function of times (pulse,) that gives (pulse, 3). Sectors count
    from north whatever the heading at time 0.
    coherence: of each receiver with the first, (gate,) or one for all: voltages become jointly circular Gaussian.
    looks: independent samples of that in a beam width of the turn; each stays as it is for its share of the beam width
    and is then drawn anew, so that a dwell's covariance is a mean over just so many, whatever antenna sends. Receivers
    that alternate lose some coherence from one sample to the next. Gates are independent.
    snr_db: of one pulse, (gate,) or one for all: adds noise of 1 W, new in each gate and pulse.
    radial_velocity_m_s: all that echoes recedes by it, in phase alone. seed: of all that is drawn, by SeedSequence.

    Raises ValueError for a staring radar, fewer than one turn, a coherence outside 0 … 1 or that of a PointSea, whose
    coherence follows from where its points lie, and looks that are not positive.
    """
    radar = radar or RadarSettings()
    _check(sea, radar, turns, coherence, looks)
    speckle, points, noise = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(3))
    fired = _Fired.of(radar, turns)
    attitude, position = _at(attitude_deg, fired.time), _at(position_m, fired.time)
    array, known = _poses(radar, fired, attitude, position)
    if isinstance(sea, PointSea):
        voltage = _point_voltages(sea, radar, fired, array, attitude, points)
    else:
        voltage = _ideal_voltages(sea, radar, fired, array)
        if coherence is not None:
            voltage *= _speckle(radar, fired, np.asarray(coherence, dtype=np.float64), looks, speckle)
    voltage *= phasor(2.0 * radial_velocity_m_s * fired.time, SPEED_OF_LIGHT / radar.frequency_hz)[:, None, None]
    _receive(voltage, radar, fired, snr_db, noise)
    return build(
        "echoes",
        {"voltage": voltage, "position": known.antennas, "attitude": attitude},
        {
            "pulse": fired.number,
            "range": gates(radar),
            "time": fired.time,
            "azimuth": known.bearing_deg,
            "transmitter": fired.transmitter,
            "turn": fired.turn,
        },
        _attributes(radar, turns, 0.0 if snr_db is None else 1.0),
    )


def _receive(
    voltage: Voltages, radar: RadarSettings, fired: _Fired, snr_db: ArrayLike | None, rng: np.random.Generator
) -> None:
    """Channels and noise onto voltages (pulse, receiver, gate), and NaN where a receiver is not sampled."""
    antennas = antenna_array(radar)
    voltage *= np.array([antennas.elements[antenna].channel for antenna in antennas.receivers])[:, None]
    if snr_db is not None:
        voltage *= np.sqrt(from_db(snr_db))
        voltage += _circular(rng, voltage.shape)
    for slot, each in enumerate(antennas.cycle):
        unheard = np.setdiff1d(np.arange(voltage.shape[1]), each.receivers)
        voltage[np.ix_(fired.slot == slot, unheard)] = np.nan


@dataclass(frozen=True)
class _Fired:
    """The pulses of all turns, arrays (pulse,)."""

    number: NDArray[np.int64]
    time: Field  # s
    turn: NDArray[np.int32]
    sweep: Field  # deg, of the turntable from the sector's start
    slot: NDArray[np.intp]  # of the mode's cycle
    transmitter: NDArray[np.intp]  # antenna

    @classmethod
    def of(cls, radar: RadarSettings, turns: int) -> _Fired:
        a_turn = 60.0 / radar.rotation_rpm * radar.prf_hz  # pulses
        share = (radar.sector_deg[1] - radar.sector_deg[0]) / 360.0
        ends = np.ceil(np.add.outer(np.arange(turns), (0.0, share)) * a_turn - 1e-9).astype(np.int64)
        number = np.concatenate([np.arange(first, last) for first, last in ends])
        turn = np.repeat(np.arange(turns), np.diff(ends)[:, 0]).astype(np.int32)
        cycle = antenna_array(radar).cycle
        slot = number % len(cycle)
        senders = np.array([each.transmitter for each in cycle])
        return cls(number, number / radar.prf_hz, turn, 360.0 * (number / a_turn - turn), slot, senders[slot])


def _poses(radar: RadarSettings, fired: _Fired, attitude: Field, position: Field) -> tuple[Array, Array]:
    """The array as it stands, and with its antennas where they are thought to be."""
    scan = radar.sector_deg[0] + fired.sweep - attitude[0, 2]
    middle = position + np.array((0.0, 0.0, radar.height_m))
    antennas = antenna_array(radar)
    true, known = (
        Array.standing(attitude, scan, radar.tilt_deg, middle, offsets)
        for offsets in (antennas.offsets, antennas.known_offsets)
    )
    return true, known


def _ideal_voltages(sea: Surface, radar: RadarSettings, fired: _Fired, array: Array) -> Voltages:
    """(pulse, receiver, gate) of one point a gate; 0 where there is none."""
    antennas, wavelength, ranges = antenna_array(radar), SPEED_OF_LIGHT / radar.frequency_hz, gates(radar)
    receivers = list(antennas.receivers)
    voltage = np.zeros((fired.time.size, len(receivers), ranges.size), dtype=np.complex128)
    for start in range(0, fired.time.size, _PULSES_AT_ONCE):
        rows = slice(start, start + _PULSES_AT_ONCE)
        points = array[rows].fan_meets(sea, ranges, gate_weights(radar), (receivers[0], receivers[1]))
        away = array[rows].distances(points)
        out = away[np.arange(away.shape[0]), fired.transmitter[rows]]
        voltage[rows] = phasor(out[:, None] + away[:, receivers], wavelength)
    return np.nan_to_num(voltage)


def gate_weights(radar: RadarSettings) -> Field:
    """(antenna,) how much of each antenna's distance is in a gate's range: ½ of what sends, ½ of what hears."""
    antennas = antenna_array(radar)
    weights = np.zeros(len(antennas.elements))
    weights[list(antennas.transmitters)] += 0.5 / len(antennas.transmitters)
    weights[list(antennas.receivers[:2])] += 0.25
    return weights


def _point_voltages(
    sea: PointSea,
    radar: RadarSettings,
    fired: _Fired,
    array: Array,
    attitude: Field,
    rng: np.random.Generator,
) -> Voltages:
    """(pulse, receiver, gate), sums over points."""
    antennas, wavelength, ranges = antenna_array(radar), SPEED_OF_LIGHT / radar.frequency_hz, gates(radar)
    lean = 2.0 * float(np.abs(attitude[:, :2]).max())  # a leaning fan meets near water beside its bearing
    sector = (radar.sector_deg[0] - lean, radar.sector_deg[1] + lean)
    centre, beam = array.antennas.mean(axis=(0, 1)), radar.antenna.azimuth_beamwidth_deg
    points = Points.strewn(sea, ranges, RangeResponse.of(radar), beam, sector, centre, rng)
    chunks = (slice(start, start + _PULSES_AT_ONCE) for start in range(0, fired.time.size, _PULSES_AT_ONCE))
    return np.concatenate(
        [
            points.voltages(array[rows], fired.transmitter[rows], antennas.receivers, ranges, wavelength)
            for rows in chunks
        ]
    )


def _speckle(radar: RadarSettings, fired: _Fired, coherence: Field, looks: float, rng: np.random.Generator) -> Voltages:
    """Unit circular Gaussian factors (pulse, receiver, gate), those of the first receiver in part of the others'."""
    block = np.floor(fired.sweep * looks / radar.antenna.azimuth_beamwidth_deg + 1e-9).astype(np.intp)
    block += fired.turn * (int(block.max()) + 1)
    shape = (int(block.max()) + 1, len(antenna_array(radar).receivers), gates(radar).size)
    drawn = _circular(rng, shape)
    drawn[:, 1:] = coherence * drawn[:, :1] + np.sqrt(1.0 - coherence**2) * drawn[:, 1:]
    return drawn[block]


def _circular(rng: np.random.Generator, shape: tuple[int, ...]) -> Voltages:
    """Circular Gaussian numbers of unit mean power."""
    return rng.standard_normal((*shape, 2)).view(np.complex128)[..., 0] / np.sqrt(2.0)


def _at(motion: Motion, time: Field) -> Field:
    """(pulse, 3) of a motion, or of what stands still."""
    values = motion(time) if callable(motion) else np.tile(np.asarray(motion, dtype=np.float64), (time.size, 1))
    return np.asarray(values, dtype=np.float64)


def _check(
    sea: Surface | PointSea, radar: RadarSettings, turns: int, coherence: ArrayLike | None, looks: float
) -> None:
    if radar.scan != "turning":
        raise ValueError(f"radar.scan = {radar.scan!r}: must be 'turning'; a staring antenna is not made here")
    if turns < 1:
        raise ValueError(f"turns = {turns}: must be at least 1; ask for whole turns")
    if not looks > 0.0:
        raise ValueError(f"looks = {looks}: must be above 0; give independent samples in a beam width")
    if coherence is None:
        return
    if isinstance(sea, PointSea):
        raise ValueError(f"coherence = {coherence}: must be None for a PointSea; its points decide, leave it out")
    if not np.all((np.asarray(coherence) >= 0.0) & (np.asarray(coherence) <= 1.0)):
        raise ValueError(f"coherence = {coherence}: must be within 0 … 1; give that of the receivers without noise")


def _attributes(radar: RadarSettings, turns: int, noise_power: float) -> dict[str, object]:
    antennas, chirped = antenna_array(radar), radar.waveform == "chirp"
    return {
        "frequency_hz": radar.frequency_hz,
        "pulse_width_s": radar.pulse_width_s,
        "bandwidth_hz": radar.bandwidth_hz,
        "prf_hz": radar.prf_hz,
        "rotation_rpm": radar.rotation_rpm,
        "sector_deg": list(radar.sector_deg),
        "height_m": radar.height_m,
        "baseline_m": antennas.baseline_m,
        "tilt_deg": radar.tilt_deg,
        "azimuth_beamwidth_deg": radar.antenna.azimuth_beamwidth_deg,
        "elevation_beamwidth_deg": radar.antenna.elevation_beamwidth_deg,
        "polarization": "VV",
        "transmit": radar.transmit,
        "interferogram": radar.interferogram,
        "noise_power_w": noise_power,
        "complete_turns": turns,
        "waveform": radar.waveform,
        "chirp_bandwidth_hz": radar.chirp_bandwidth_hz if chirped else 0.0,
        "compression_weighting": radar.compression_window if chirped else "none",
        "receiver_antennas": list(antennas.receivers),
    }
