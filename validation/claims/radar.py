"""The radar's claims of the design study of 2004, each recomputed and judged.

    python -m validation.claims.radar

Claims on range resolution (1), beam and footprint (2), the weakest detectable sea (3) and the data rate (5): what was
printed, what is computed here, under which assumption, and a verdict: reproduced, only if …, or not reproduced.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from seamap_rt.conventions import SPEED_OF_LIGHT, db, radar_wavelength
from seamap_rt.radar import link
from seamap_rt.radar.antenna import Cut, antenna
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.settings import AntennaSettings, RadarSettings

from .data_rate import CLAIM, claim_data_rate
from .weakest_sea import aperture_gain, claim_minimum_nrcs

REPRODUCED, ONLY_IF, NOT = "reproduced", "only if", "not reproduced"
STUDY = RadarSettings()  # its defaults are the study's radar
TOLERANCE = 0.05  # of a figure that is printed with one or two digits
WEAKEST_DB, AT_M = -55.0, 100.0
_APERTURE = STUDY.antenna.width_m, STUDY.antenna.height_m


class Claim(NamedTuple):
    """One claim, its computed figures, and the verdict."""

    number: str
    printed: str
    verdict: str
    assumption: str
    figures: list[tuple[str, str]]  # what, and its value

    def show(self) -> None:
        assumption = f" {self.assumption}" if self.assumption else ""
        print(f"{self.number}. {self.printed}\n   {self.verdict}{assumption}")
        for what, value in self.figures:
            print(f"     {what:58} {value}")
        print(flush=True)


def range_resolution() -> Claim:
    """A pulse of 20 ns resolves 3 m: as its own length, and as what the receiver's filter leaves of it."""
    pulse = 0.5 * SPEED_OF_LIGHT * STUDY.pulse_width_s
    response = RangeResponse.of(STUDY)
    filtered = response.resolution_m
    wide = RangeResponse(STUDY.pulse_width_s, 1e9).resolution_m
    pairs = {offset: _dip(response, offset) for offset in (filtered, pulse, 1.25 * pulse)}
    figures = [
        ("cτ/2", f"{pulse:.3f} m"),
        (
            "−3 dB width",
            f"{wide:.3f} m through a filter of 1 GHz, {filtered:.3f} m through {STUDY.bandwidth_hz / 1e6:g} MHz",
        ),
        (
            "two equal reflectors in quadrature, dip between them",
            ", ".join(f"{dip:.1f} dB at {offset:.2f} m" for offset, dip in pairs.items()),
        ),
    ]
    good = abs(pulse - 3.0) < 3.0 * TOLERANCE and filtered <= 3.0 * (1.0 + TOLERANCE)
    return Claim("1", "3 m range resolution from 20 ns", REPRODUCED if good else NOT, "", figures)


def _dip(response: RangeResponse, distance: float) -> float:
    """Level [dB] midway between two reflectors whose powers add, below that on either."""
    middle, on = 2.0 * response(0.5 * distance) ** 2, response(0.0) ** 2 + response(distance) ** 2
    return float(db(on / middle))


def beam() -> Claim:
    """Beam widths of the aperture: those of uniform illumination, and the tapers that the study's widths need."""
    half = _half_power(np.sinc)  # half the beam width of an evenly lit line, as (aperture/λ) · direction cosine
    even = [2.0 * np.degrees(np.arcsin(half * radar_wavelength(STUDY.frequency_hz) / size)) for size in _APERTURE]
    figures = [
        (
            f"evenly lit {_APERTURE[0]:g} m × {_APERTURE[1]:g} m",
            f"{even[0]:.2f}° × {even[1]:.1f}°, first sidelobes "
            f"{_first_sidelobe(lambda cosine: np.sinc(10.0 * cosine)):.1f} dB, {db(aperture_gain(STUDY)):.2f} dBi",
        )
    ]
    worst = 0.0
    for elevation in (18.0, 20.0):
        made = antenna(RadarSettings(antenna=AntennaSettings(elevation_beamwidth_deg=elevation)))
        lobes = _first_sidelobe(made.azimuth), _first_sidelobe(made.elevation)
        measured = made.azimuth_beamwidth_deg, made.elevation_beamwidth_deg
        worst = max(worst, abs(measured[0] / 1.8 - 1.0), abs(measured[1] / elevation - 1.0))
        words = f"{measured[0]:.3f}° × {measured[1]:.2f}°, first sidelobes {lobes[0]:.1f} and {lobes[1]:.1f} dB"
        figures.append(("tapered (Taylor, one parameter)", f"{words}, {db(made.gain):.2f} dBi"))
    wider = 1.8 / even[0]
    assumption = f"the aperture is tapered: 1.8° is {wider:.2f} times an evenly lit beam, {2.0 * half * wider:.2f} λ/D"
    return Claim("2a", "1.8° × 18–20° from 1 m × 0.1 m", ONLY_IF if worst < TOLERANCE else NOT, assumption, figures)


def _half_power(cut: Cut, power: int = 2, most: float = 0.9) -> float:
    """Where a cut to that power has fallen to one half."""
    value = brentq(lambda u: float(cut(np.array([u]))[0]) ** power - 0.5, 0.0, most)
    return float(value)  # type: ignore[arg-type]


def _first_sidelobe(cut: Cut) -> float:
    """dB of the first maximum beyond the first null."""
    level = np.abs(cut(np.linspace(0.0, 1.0, 200_001)))
    rising = np.flatnonzero(np.diff(level) > 0.0)
    if rising.size == 0:
        return float("-inf")
    falling = rising[0] + np.flatnonzero(np.diff(level)[rising[0] :] < 0.0)
    return float(2.0 * db(level[falling[0]] if falling.size else level[-1]))


def footprint() -> Claim:
    """How wide the beam is on the water."""
    got = link.footprint_m(STUDY, [100.0, 200.0])
    azimuth = antenna(STUDY).azimuth
    both = got * _half_power(azimuth, 4, 0.02) / _half_power(azimuth, 2, 0.02)
    names = ("−3 dB one-way at 100 and 200 m", "two-way, as the echo has it")
    figures = [(name, f"{near:.2f} and {far:.2f} m") for name, (near, far) in zip(names, (got, both), strict=True)]
    good = np.all(np.abs(got / [3.0, 6.0] - 1.0) < TOLERANCE)
    return Claim("2b", "3 m at 100 m, 6 m at 200 m", REPRODUCED if good else NOT, "", figures)


def weakest_sea() -> Claim:
    """Minimum detectable NRCS: which link budgets give 0 dB there."""
    rows = claim_minimum_nrcs(STUDY, claim_db=WEAKEST_DB, range_m=AT_M)
    figures = [
        (
            f"{row.assumption}, {row.gain_dbi:.2f} dBi, {row.integration}",
            f"{row.minimum_db:.1f} dB at {AT_M:g} m, {WEAKEST_DB:g} dB to {row.reached_m:.0f} m: "
            f"{'met' if row.met else 'missed'}",
        )
        for row in rows
    ]
    met = [row for row in rows if row.met]
    closest = min(rows, key=lambda row: abs(row.minimum_db - WEAKEST_DB))
    verdict = REPRODUCED if len(met) == len(rows) else ONLY_IF if met else NOT
    single = min(row.minimum_db for row in rows if row.integration == "one pulse")
    assumption = (
        f"the dwell's {link.dwell(STUDY).pulses} pulses are added (one pulse: {single:.1f} dB at best); met by "
        f"{len(met)} of {len(rows)}, closest {closest.minimum_db:.2f} dB: {closest.assumption}, {closest.integration}"
    )
    return Claim("3", f"minimum detectable NRCS {WEAKEST_DB:g} dB at {AT_M:g} m", verdict, assumption, figures)


def rate() -> Claim:
    """Bytes per second over 400 m at 10 kHz: which readings give the figure."""
    readings = claim_data_rate()
    figures = [
        (
            f"{row.receivers} receiver{'s' if row.receivers > 1 else ''}, {row.sampling}, {row.bits} bits a sample",
            f"{row.bytes_per_second / 1e6:.1f} MB/s{': fits' if row.fits else ''}",
        )
        for row in readings
    ]
    fits = [f"{row.receivers} × {row.sampling} of {row.bits} bits" for row in readings if row.fits]
    assumption = "the samples are " + ", or ".join(fits) if fits else ""
    printed = f"{CLAIM / 1e6:g} MB/s at 10 kHz over 400 m"
    return Claim("5", printed, ONLY_IF if fits else NOT, assumption, figures)


def claims() -> list[Claim]:
    """All of them, in the study's order."""
    return [range_resolution(), beam(), footprint(), weakest_sea(), rate()]


def main() -> None:
    for claim in claims():
        claim.show()


if __name__ == "__main__":
    main()
