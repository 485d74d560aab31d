"""The antennas of a radar, and which of them sends and which hear on each pulse: its mode.

    transmit   interferogram       pulse n is sent by        and heard by                     p
    single     single_pulse        the first transmitter     every receiver                   1
    switched   single_pulse        each transmitter in turn  every receiver                   1
    single     alternating_pulse   the first transmitter     each receiver in turn            1
    switched   alternating_pulse   each antenna in turn      that antenna alone               2

Between antennas i and j the path is the same both ways, so that one sum over the sea serves both.

How far a waveguide's beam stands from the normal of its aperture: squint.

Slots at half a guide wavelength of the design frequency, to either side of the wall's middle by turns, are in phase at
that frequency alone. A guide that is fed in the middle is two halves that squint against each other, and looks ahead;
one that is fed at its end swings its beam away from the feed as the frequency rises (Elliott 2003).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..conventions import SPEED_OF_LIGHT
from ..settings import AntennaSettings, RadarSettings
from .antenna import Antenna, antenna_of, cache_by_radar


def squint_deg(settings: AntennaSettings, frequency_hz: float) -> float:
    """Degrees from the aperture's normal to the beam at a frequency [Hz]; positive away from the feed, clockwise.

    sin θ = λ/λg(f) − λ/λg(f₀) = √(1 − (fc/f)²) − (f₀/f) √(1 − (fc/f₀)²), with fc = c/(2 guide width) the cut-off of the
    guide's TE₁₀ mode. About the design frequency f₀ it grows by λg(f₀)/λ per relative change of frequency: 0.76° per
    percent in WR-90 at 10 GHz. ValueError at and below cut-off, and where no beam is left ahead.
    """
    if settings.feed == "centre":
        return 0.0
    design = frequency_hz if settings.design_frequency_hz is None else settings.design_frequency_hz
    cut_off = SPEED_OF_LIGHT / (2.0 * settings.guide_width_m)
    for name, value in (("radar.frequency_hz", frequency_hz), ("radar.antenna.design_frequency_hz", design)):
        if value <= cut_off:
            raise ValueError(
                f"{name} = {value:g}: must be above the waveguide's cut-off, {cut_off:.4g} Hz; "
                f"raise it, or widen radar.antenna.guide_width_m = {settings.guide_width_m:g}"
            )
    sine = np.sqrt(1.0 - (cut_off / frequency_hz) ** 2) - np.sqrt(design**2 - cut_off**2) / frequency_hz
    if sine <= -1.0:
        raise ValueError(
            f"radar.antenna.design_frequency_hz = {design:g}: must be nearer to the frequency, {frequency_hz:g} "
            "Hz, at which such slots have no beam ahead; lower it"
        )
    return float(np.degrees(np.arcsin(sine)))


@dataclass(frozen=True)
class Element:
    """One antenna of the array. Offsets are (across, boresight, up) [m] from the array's own origin."""

    antenna: Antenna
    offset: tuple[float, float, float]
    known_offset: tuple[float, float, float]  # as the retrieval is given it
    transmits: bool
    receives: bool
    channel: complex  # voltage factor of its receiver
    bandwidth_hz: float


@dataclass(frozen=True)
class Slot:
    """What happens on one pulse of the cycle."""

    transmitter: int  # antenna
    receivers: tuple[int, ...]  # numbers among the receivers, of those that are sampled


@dataclass(frozen=True)
class Array:
    """Antennas in the order of the scene, lower before upper, and the cycle of pulses."""

    elements: tuple[Element, ...]
    receivers: tuple[int, ...]  # antenna of each receiver
    cycle: tuple[Slot, ...]

    @cached_property
    def offsets(self) -> NDArray[np.float64]:
        """(antenna, 3) true phase centres."""
        return np.array([element.offset for element in self.elements])

    @cached_property
    def known_offsets(self) -> NDArray[np.float64]:
        """(antenna, 3) phase centres as they are thought to be."""
        return np.array([element.known_offset for element in self.elements])

    @cached_property
    def baseline_m(self) -> float:
        """m, known distance between the first two receivers."""
        first, second = (self.known_offsets[number] for number in self.receivers[:2])
        return float(np.linalg.norm(second - first))

    @cached_property
    def paths(self) -> tuple[tuple[int, int], ...]:
        """Pairs of antennas, the lower number first, between which echoes are heard."""
        pairs = {
            (min(slot.transmitter, self.receivers[r]), max(slot.transmitter, self.receivers[r]))
            for slot in self.cycle
            for r in slot.receivers
        }
        return tuple(sorted(pairs))

    def path(self, transmitter: int, receiver: int) -> int:
        """Number of the path from an antenna to a receiver."""
        antenna = self.receivers[receiver]
        return self.paths.index((min(transmitter, antenna), max(transmitter, antenna)))

    @cached_property
    def transmitters(self) -> tuple[int, ...]:
        """Antennas that send, in the order of the cycle."""
        return tuple(dict.fromkeys(slot.transmitter for slot in self.cycle))

    @property
    def whole(self) -> bool:
        """Every receiver is sampled on every pulse."""
        return all(len(slot.receivers) == len(self.receivers) for slot in self.cycle)

    @property
    def first_antenna(self) -> Antenna:
        """The antenna of the first receiver."""
        return self.elements[self.receivers[0]].antenna

    @property
    def phase_paths(self) -> int:
        """p: 2 where the antennas that are compared transmit for themselves, else 1."""
        return 1 if self.whole or len(self.transmitters) == 1 else 2

    @cached_property
    def beam_deg(self) -> float:
        """The widest azimuth beam [deg], one-way −3 dB: it fixes how far off its axis the sea is simulated."""
        return max(self._beams_deg)

    @cached_property
    def narrowest_beam_deg(self) -> float:
        """deg, one-way −3 dB."""
        return min(self._beams_deg)

    @property
    def _beams_deg(self) -> list[float]:
        # They are measured on the cuts: rounding must not add a column.
        return [round(element.antenna.azimuth_beamwidth_deg, 9) for element in self.elements]


@cache_by_radar(maxsize=64)
def antenna_array(radar: RadarSettings) -> Array:
    """The array of a radar, lengths in metres. Raises ValueError for a mode that its antennas cannot serve."""
    elements = tuple(_listed(radar)) if radar.antennas else tuple(_stacked(radar))
    receivers = tuple(n for n, element in enumerate(elements) if element.receives)
    transmitters = [n for n, element in enumerate(elements) if element.transmits]
    if len(receivers) < 2 or not transmitters:
        raise ValueError(
            f"radar.antennas: {len(receivers)} receive and {len(transmitters)} transmit; at least two must receive and "
            "one transmit; give them the role both, rx or tx"
        )
    everyone = tuple(range(len(receivers)))
    if radar.interferogram == "single_pulse":
        used = transmitters if radar.transmit == "switched" else transmitters[:1]
        cycle = [Slot(each, everyone) for each in used]
    elif radar.transmit == "single":
        cycle = [Slot(transmitters[0], (number,)) for number in everyone]
    else:
        alone = [n for n in transmitters if n in receivers]
        if len(alone) < 2:
            raise ValueError(
                "radar.interferogram = 'alternating_pulse': with switched transmitters at least two antennas must both "
                "transmit and receive; give them the role both, or choose radar.transmit = 'single'"
            )
        cycle = [Slot(each, (receivers.index(each),)) for each in alone]
    return Array(elements, receivers, tuple(cycle))


def common_squint_deg(radar: RadarSettings) -> float:
    """The angle [deg, clockwise] by which the first antenna's beam points off the normal of its aperture."""
    return squint_deg(radar.antennas[0] if radar.antennas else radar.antenna, radar.frequency_hz)


def with_scanned_sector(radar: RadarSettings) -> RadarSettings:
    """The radar with the sector that its beam truly scans: a squint turns it, and the boresight with it."""
    squint = common_squint_deg(radar)
    if squint == 0.0:
        return radar
    start, stop = radar.sector_deg
    return radar.model_copy(update={"sector_deg": (start + squint, stop + squint)})


def _stacked(radar: RadarSettings) -> list[Element]:
    """Two alike, one above the other: the keys of [radar] themselves."""
    known, true = 0.5 * radar.baseline_m, 0.5 * (radar.baseline_m + radar.baseline_error_m)
    upper = _channel(radar.channel_gain_db, radar.channel_phase_deg)
    return [
        _element(radar, radar.antenna, (0.0, 0.0, side * true), (0.0, 0.0, side * known), "both", channel)
        for side, channel in ((-1.0, 1.0 + 0.0j), (1.0, upper))
    ]


def _listed(radar: RadarSettings) -> list[Element]:
    return [
        _element(
            radar,
            placed,
            tuple(offset + error for offset, error in zip(placed.offset_m, placed.offset_error_m, strict=True)),
            placed.offset_m,
            placed.role,
            _channel(placed.channel_gain_db, placed.channel_phase_deg),
            placed.bandwidth_hz,
        )
        for placed in radar.antennas
    ]


def _element(
    radar: RadarSettings,
    settings: AntennaSettings,
    offset: tuple[float, ...],
    known: tuple[float, ...],
    role: str,
    channel: complex,
    bandwidth_hz: float | None = None,
) -> Element:
    antenna = antenna_of(settings, radar.frequency_hz, radar.tilt_deg)
    error_deg = squint_deg(settings, radar.frequency_hz) - common_squint_deg(radar)
    if abs(error_deg) > 1e-9:
        cut, shift = antenna.azimuth, np.sin(np.radians(error_deg))
        antenna = replace(antenna, azimuth=lambda cosine: cut(np.asarray(cosine) - shift))
    return Element(
        antenna=antenna,
        offset=(offset[0], offset[1], offset[2]),
        known_offset=(known[0], known[1], known[2]),
        transmits=role != "rx",
        receives=role != "tx",
        channel=channel,
        bandwidth_hz=np.inf if bandwidth_hz is None else bandwidth_hz,
    )


def _channel(gain_db: float, phase_deg: float) -> complex:
    return complex(10.0 ** (gain_db / 20.0) * np.exp(1j * np.radians(phase_deg)))
