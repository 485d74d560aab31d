"""What the retrieval knows of the radar: the echoes' attributes, and the antennas' points that the sensors measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..conventions import SPEED_OF_LIGHT, radar_wavelength
from ..errors import SchemaError
from ..io.text import shown
from ..radar.waveform import RangeResponse
from ..settings import SensorErrors

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class RadarDescription:
    """The radar as the echoes' attributes describe it."""

    wavelength: float
    noise_power: float
    transmit: str
    sector: tuple[float, float]
    period: float
    height: float
    response: RangeResponse
    ranges: NDArray[np.float64]
    interferogram: str = "single_pulse"
    interval: float = 1e-4  # s, between pulses
    tilt: float = 0.0  # deg
    pulse_width: float = 20e-9  # s
    compressed: bool = False
    staring: bool = False
    receiver_antennas: tuple[int, ...] = (0, 1)  # the antenna of each receiver
    azimuth_beamwidth: float = 1.8  # deg, one-way −3 dB
    elevation_beamwidth: float = np.nan  # deg, likewise
    coherent: bool = True  # phases mean something from pulse to pulse
    transmit_phase_error: float = 0.0  # rad rms, new at each pulse
    sensors: SensorErrors | None = None  # of the motion; None where the echoes say nothing of them

    @classmethod
    def of(cls, echoes: xr.Dataset) -> RadarDescription:
        """From the echoes' attributes. Raises SchemaError for an unknown interferogram."""
        attrs = echoes.attrs
        if attrs["interferogram"] not in ("single_pulse", "alternating_pulse"):
            raise SchemaError(
                f"echoes: interferogram = '{attrs['interferogram']}': must be single_pulse or alternating_pulse"
            )
        start, stop = (float(a) for a in attrs["sector_deg"])
        staring = str(attrs.get("scan", "turning")) == "staring"
        receivers = np.atleast_1d(attrs.get("receiver_antennas", (0, 1)))
        magnetron = str(attrs.get("transmitter", "coherent")) == "magnetron"
        measured = magnetron and bool(attrs.get("coherent_on_receive", 0))
        sensors = {key: attrs[name] for key in SensorErrors.model_fields if (name := f"sensors_{key}") in attrs}
        return cls(
            wavelength=radar_wavelength(float(attrs["frequency_hz"])),
            noise_power=float(attrs["noise_power_w"]),
            transmit=str(attrs["transmit"]),
            sector=(start, stop),
            period=float(attrs["stare_s"]) if staring else 60.0 / float(attrs["rotation_rpm"]),
            height=float(attrs["height_m"]),
            response=_response(echoes),
            ranges=np.asarray(echoes["range"].values, dtype=np.float64),
            interferogram=str(attrs["interferogram"]),
            interval=1.0 / float(attrs["prf_hz"]),
            tilt=float(attrs["tilt_deg"]),
            pulse_width=float(attrs["pulse_width_s"]),
            compressed=attrs.get("waveform", "pulse") == "chirp",
            staring=staring,
            receiver_antennas=tuple(int(antenna) for antenna in receivers),
            azimuth_beamwidth=float(attrs["azimuth_beamwidth_deg"]),
            elevation_beamwidth=float(attrs.get("elevation_beamwidth_deg", np.nan)),
            coherent=measured or not magnetron,
            transmit_phase_error=float(np.radians(attrs.get("transmit_phase_error_deg", 0.0))) if measured else 0.0,
            sensors=SensorErrors.model_construct(None, **sensors) if sensors else None,
        )

    @property
    def spacing(self) -> float:
        """m, between gates."""
        return float(self.ranges[1] - self.ranges[0]) if self.ranges.size > 1 else 1.0

    @property
    def closed(self) -> bool:
        """Whether the sector is the full circle."""
        return bool(np.isclose(self.sector[1] - self.sector[0], 360.0)) and not self.staring

    @property
    def alternating(self) -> bool:
        """Receivers are sampled in turn, not on the same pulse."""
        return self.interferogram == "alternating_pulse"

    @property
    def paths(self) -> int:
        """p, by how many of its two ways an echo's interferometric phase differs."""
        return 2 if self.alternating and self.transmit == "switched" else 1

    def footprint(self, turned: float) -> tuple[float, float]:
        """Standard deviations of the area that a dwell's echo comes from: along the look [m], across it [rad].

        turned: degrees that the antenna turns in the dwell. The beam's power is taken as Gaussian, on both ways.
        """
        beam = np.radians(self.azimuth_beamwidth) / (4.0 * np.sqrt(np.log(2.0)))
        return self.response.spread_m, float(np.hypot(beam, np.radians(turned) / np.sqrt(12.0)))

    @property
    def blind(self) -> NDArray[np.bool_]:
        """Gates (gate,) from which nothing is heard while a pulse goes out; of a chirp, which is heard only whole,
        those as well whose echo the next pulse cuts off."""
        on = 0.5 * SPEED_OF_LIGHT * self.pulse_width
        if not self.compressed:
            return self.ranges < on
        cycle = 0.5 * SPEED_OF_LIGHT * self.interval
        within = np.mod(self.ranges, cycle)
        return (within < on) | (within > cycle - on)


def compared_receivers(echoes: xr.Dataset, radar: RadarDescription, receivers: tuple[int, int]) -> tuple[int, int]:
    """Antennas of the two receivers that are compared. Raises SchemaError for receivers that the echoes do not hold."""
    count = echoes.sizes["receiver"]
    if len(set(receivers)) != 2 or not all(0 <= receiver < count for receiver in receivers):
        raise SchemaError(
            f"retrieval.receivers = {receivers}: must be two different ones of the echoes' receivers 0 … {count - 1}"
        )
    if len(radar.receiver_antennas) < count or max(radar.receiver_antennas) >= echoes.sizes["antenna"]:
        raise SchemaError(
            f"echoes: receiver_antennas = {shown(radar.receiver_antennas)}: must name one of the "
            f"{echoes.sizes['antenna']} antennas for each of the {count} receivers"
        )
    lower, upper = (radar.receiver_antennas[receiver] for receiver in receivers)
    return lower, upper


def transmitters(
    sender: NDArray[np.integer], antennas: tuple[int, int], rows: Sequence[NDArray[np.intp]] | None, paths: int
) -> tuple[int, ...]:
    """The antennas whose pulses the interferogram is made of.

    sender (pulse,); antennas: lower, upper; rows: of the pulses that each receiver heard, if they alternate. Raises
    SchemaError unless alternating receivers hear one antenna alike (p = 1), or each its own (p = 2).
    """
    if rows is None:
        return tuple(int(each) for each in np.unique(sender))
    heard = [tuple(int(each) for each in np.unique(sender[row])) for row in rows]
    one = len(heard[0]) == 1 and heard[0] == heard[1]
    own = heard == [(antennas[0],), (antennas[1],)]
    if all(heard) and not (own if paths == 2 else one):
        raise SchemaError(
            f"echoes: transmitter: alternating receivers {antennas} hear antennas {heard[0]} and {heard[1]}; must be "
            f"{'each its own' if paths == 2 else 'one and the same'}, as the attribute transmit says"
        )
    return antennas if paths == 2 else heard[0] or (antennas[0],)


def _response(echoes: xr.Dataset) -> RangeResponse:
    attrs = echoes.attrs
    return RangeResponse(
        float(attrs["pulse_width_s"]),
        float(attrs["bandwidth_hz"]),
        waveform=str(attrs.get("waveform", "pulse")),
        chirp_bandwidth_hz=float(attrs.get("chirp_bandwidth_hz", 0.0)),
        window=str(attrs.get("compression_weighting", "none")),
    )
