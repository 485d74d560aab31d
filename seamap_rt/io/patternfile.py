"""Measured antenna patterns from files: two cuts, as voltages against the direction cosine.

CSV has the header line `cut,angle_deg,gain_db`: azimuth or elevation, degrees from boresight clockwise or up, and
decibels, absolute or relative. A fourth column `phase_deg` must be 0: a cut here is real and, its sign being unknown,
positive.

MSI/Planet (.msi, .pln, .ant) has header lines such as GAIN, and HORIZONTAL and VERTICAL with lines of an angle and an
attenuation in decibels. Horizontal angles count clockwise; vertical ones count down from the horizon, 90 being the
nadir, as makers' files of down-tilted antennas do. A gain without a unit is in dBd, a frequency in MHz.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import NDArray

from ..errors import InputError, say_of
from .opening import read_bytes
from .text import bad_line, decode_text, finite_number, is_wide, refuse_semicolons

CUTS = ("azimuth", "elevation")
_MSI_CUTS = {"HORIZONTAL": "azimuth", "VERTICAL": "elevation"}
_LEVELS = ("gain_db", "attenuation", "GAIN")
_COLUMNS = ("cut", "angle_deg", "gain_db")
_MSI_ENDINGS = (".msi", ".pln", ".ant")

_FEWEST = 8  # points of a cut
_BEAMS = 3.0  # to either side of boresight that an azimuth cut must tell of
_DIPOLE_DBI = 2.15  # 0 dBd
_LEAST_ABSOLUTE_DB = 3.0  # an antenna that radiates only ahead has 3 dBi at least: lower values are relative
_MOST_DB = 1000.0  # of any level or gain, and of its opposite: lower nulls are as good as this one
_HALF_POWER_DB = 10.0 * np.log10(0.5)

Rows = list[tuple[int, float, float]]  # line of the file, angle [deg], level [dB]
Read = tuple[dict[str, Rows], float | None, float | None]  # the cuts, gain [dBi], frequency [Hz]


@dataclass(frozen=True, eq=False)
class MeasuredCut:
    """The voltage of a cut against the direction cosine: 1 at its peak ahead, 0 where the file does not reach.

    Between its points the level in decibels follows Akima's (1970) spline in the angle: exact on a Gaussian beam, and
    without swings beside a null.
    """

    level_db: scipy.interpolate.Akima1DInterpolator  # over the angle [deg]

    def __call__(self, cosine: NDArray[np.float64]) -> NDArray[np.float64]:
        angle = np.degrees(np.arcsin(np.clip(np.asarray(cosine, dtype=np.float64), -1.0, 1.0)))
        known = np.clip(angle, self.level_db.x[0], self.level_db.x[-1])
        return np.where(np.abs(angle - known) < 1e-6, 10.0 ** (self.level_db(known) / 20.0), 0.0)


@dataclass(frozen=True)
class PatternFile:
    """What a file holds of an antenna. Of the circle only the half ahead counts."""

    azimuth: MeasuredCut
    elevation: MeasuredCut
    gain_dbi: float | None  # as the file has it; a CSV's highest level if above 3 dB, an antenna ahead having no less
    frequency_hz: float | None  # at which it was measured


def read_pattern(path: str | os.PathLike[str]) -> PatternFile:
    """The pattern of a CSV or MSI/Planet file, known by its content. Boresight is the file's angle 0, wherever the peak
    may be.

    An elevation cut must reach ±90°; an azimuth cut ±3 of its own beam widths or ±90°, and is 0 beyond its ends.
    Angles must increase from line to line and lie between −180 and 360. InputError of one line, with the file's line,
    for what cannot be read, is missing, NaN, too short, out of order, or has its peak behind or beside the antenna.
    """
    path = Path(path)
    content = read_bytes(path, "a pattern", named=f"file '{path}'")
    if is_wide(content):
        decode_text(content, f"file '{path}'")
    text = content.decode("utf-8-sig", "replace")  # of another encoding are comments alone
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1)]
    full = [(number, line) for number, line in lines if line and line[0] not in "#;!"]
    read = _reader(path, full)
    with say_of(f"file '{path}', "):
        rows, gain_dbi, frequency_hz = read(full)
        for name in CUTS:
            if not rows[name]:
                raise bad_line(max(1, len(lines)), f"{name} cut: is missing at the end of the file; give both cuts")
        azimuth, elevation = (_cut(name, rows[name]) for name in CUTS)
    return PatternFile(azimuth, elevation, gain_dbi, frequency_hz)


def _reader(path: Path, lines: list[tuple[int, str]]) -> Callable[[list[tuple[int, str]]], Read]:
    """The reader by the file's content; the ending decides where the content has neither format's words."""
    if any(line.split()[0].upper().rstrip(":=") in _MSI_CUTS for _, line in lines):
        return _read_msi
    if path.suffix.lower() == ".csv" or (lines and "," in lines[0][1] and set(_COLUMNS) & set(_words(lines[0][1]))):
        return _read_csv
    if path.suffix.lower() in _MSI_ENDINGS:
        return _read_msi
    raise InputError(
        f"file '{path}': is no antenna pattern: must be CSV with the header {','.join(_COLUMNS)}, or MSI/Planet with "
        "the cuts HORIZONTAL and VERTICAL; convert it"
    )


def _words(header: str) -> list[str]:
    return [word.strip().lower() for word in header.split(",")]


def _number(line: int, name: str, text: str) -> float:
    value = finite_number(line, name, text)
    if name in _LEVELS and abs(value) > _MOST_DB:
        raise bad_line(line, f"{name} = {text}: must lie within ±{_MOST_DB:g} dB; correct it")
    return value


# ------------------------------------------------------------------------------------------------------ the two formats


def _read_csv(lines: list[tuple[int, str]]) -> Read:
    head, header = lines[0] if lines else (1, "")
    refuse_semicolons(head, header)
    columns = _words(header)
    if sorted(columns) not in (sorted(_COLUMNS), sorted((*_COLUMNS, "phase_deg"))):
        raise bad_line(head, f"header = {header[:60]}: must be {','.join(_COLUMNS)}[,phase_deg]; write it so")
    rows: dict[str, Rows] = {name: [] for name in CUTS}
    for number, line in lines[1:]:
        words = [word.strip() for word in line.split(",")]
        if len(words) != len(columns):
            raise bad_line(number, f"{len(words)} values: must be {len(columns)}, as in the header; correct it")
        entry = dict(zip(columns, words, strict=True))
        cut = entry.pop("cut").lower()
        if cut not in CUTS:
            raise bad_line(number, f"cut = {cut}: must be azimuth or elevation; correct it")
        value = {name: _number(number, name, word) for name, word in entry.items()}
        if value.get("phase_deg"):
            raise bad_line(
                number, f"phase_deg = {value['phase_deg']:g}: must be 0, patterns are real; leave the column out"
            )
        rows[cut].append((number, value["angle_deg"], value["gain_db"]))
    _check_order(rows)
    highest = max((level for cut in rows.values() for _, _, level in cut), default=0.0)
    return rows, highest if highest > _LEAST_ABSOLUTE_DB else None, None


def _read_msi(lines: list[tuple[int, str]]) -> Read:
    rows: dict[str, Rows] = {name: [] for name in CUTS}
    promised: dict[str, tuple[int, str]] = {}
    gain_dbi, frequency_hz, cut = None, None, ""
    for number, line in lines:
        words = line.split()
        key = words[0].upper().rstrip(":=")
        if key in _MSI_CUTS:
            cut = _MSI_CUTS[key]
            promised[cut] = (number, words[1] if len(words) > 1 else "")
        elif key == "GAIN":
            gain_dbi = _gain_dbi(number, line)
        elif key == "FREQUENCY":
            frequency_hz = _frequency_hz(line)
        elif key[0].isalpha() and key != "NAN":  # NAME, MAKE, TILT, COMMENT … and whatever else a maker adds
            cut = ""
        elif cut:
            if len(words) != 2:
                raise bad_line(number, f"{len(words)} values: must be 2, an angle and an attenuation; correct it")
            angle, level = (
                _number(number, name, word.replace(",", "."))
                for name, word in zip(("angle", "attenuation"), words, strict=True)
            )
            rows[cut].append((number, angle, level))
    for cut, (number, count) in promised.items():
        if count.isdecimal() and int(count) != len(rows[cut]):
            raise bad_line(
                number, f"{cut} cut: must have the {count} points announced, not {len(rows[cut])}; mend the file"
            )
    _check_order(rows)
    for cut, sense in (("azimuth", 1.0), ("elevation", -1.0)):
        # Attenuations are positive, but some makers write levels.
        sign = 1.0 if all(level <= 0.0 for _, _, level in rows[cut]) else -1.0
        rows[cut] = [(number, sense * angle, sign * level) for number, angle, level in rows[cut]]
    return rows, gain_dbi, frequency_hz


def _gain_dbi(number: int, line: str) -> float | None:
    match = re.fullmatch(r"gain[:=\s]*([-+]?[\d.,]+)\s*(dbi|dbd)?\W*", line, re.IGNORECASE)
    if match is None:
        if re.fullmatch(r"gain[:=\s]*", line, re.IGNORECASE):
            return None
        raise bad_line(number, f"{line[:60]}: must be GAIN, a number and dBi or dBd; correct it")
    gain = _number(number, "GAIN", match[1].replace(",", "."))
    return gain if (match[2] or "dBd").lower() == "dbi" else gain + _DIPOLE_DBI


def _frequency_hz(line: str) -> float | None:
    """The frequency, if it is one number: makers give bands too."""
    match = re.fullmatch(r"frequency[:=\s]*(\d+(?:\.\d+)?)\s*([kmg]?hz)?", line, re.IGNORECASE)
    if match is None:
        return None
    return float(match[1]) * {"hz": 1.0, "khz": 1e3, "mhz": 1e6, "ghz": 1e9}[(match[2] or "MHz").lower()]


def _check_order(rows: dict[str, Rows]) -> None:
    """Angles as the file has them: within the circle, increasing, and enough of them."""
    for name, points in rows.items():
        before = -np.inf
        for number, angle, _ in points:
            wrong = (
                "within −180 and 360; correct it" if not -180.0 <= angle <= 360.0 else
                f"above the last, {before:g}; sort the lines" if angle <= before else
                "within 360 of the first; end the cut there" if angle - points[0][1] > 360.0 else ""
            )  # fmt: skip
            if wrong:
                raise bad_line(number, f"{name} cut: angle = {angle:g}: must be {wrong}")
            before = angle
        if 0 < len(points) < _FEWEST:
            words = f"{name} cut: {len(points)} points: must be at least {_FEWEST}; sample it finer"
            raise bad_line(points[-1][0], words)


# ------------------------------------------------------------------------------------------------------------- the cuts


def _cut(name: str, rows: Rows) -> MeasuredCut:
    """The cut of a file's points, its highest level ahead being 0 dB."""
    line, angle, level = (np.array(column, dtype=np.float64) for column in zip(*rows, strict=True))
    angle = np.where(angle > 180.0, angle - 360.0, np.where(angle < -180.0, angle + 360.0, angle))
    angle, first = np.unique(angle, return_index=True)  # 0 and 360 are one
    line, level = line[first].astype(int), level[first]
    spline = scipy.interpolate.Akima1DInterpolator(angle, level)
    # Extremes are where the spline's slope is 0, which is NaN along a stretch that is flat.
    angles = np.concatenate((angle, spline.derivative().roots(extrapolate=False)))
    angles = angles[np.abs(angles) <= 90.0]
    highest = int(np.argmax(level))
    if angles.size == 0 or np.max(spline(angles)) < level[highest]:
        raise bad_line(
            line[highest],
            f"{name} cut: its peak, at {angle[highest]:g}°: must be ahead, within ±90; count angles from boresight",
        )
    peak = float(angles[np.argmax(spline(angles))])
    top = float(spline(peak))
    _check_reach(name, line, angle, peak, _beamwidth_deg(spline, peak, top))
    return MeasuredCut(scipy.interpolate.Akima1DInterpolator(angle, level - top))


def _beamwidth_deg(level_db: scipy.interpolate.Akima1DInterpolator, peak: float, top: float) -> float:
    """Full width at half power about the peak; inf where it is not reached ahead on both sides."""
    crossings = level_db.solve(top + _HALF_POWER_DB, extrapolate=False)
    before, after = crossings[crossings < peak], crossings[crossings > peak]
    if before.size == 0 or after.size == 0 or before.max() < -90.0 or after.min() > 90.0:
        return np.inf
    return float(after.min() - before.max())


def _check_reach(
    name: str, line: NDArray[np.int64], angle: NDArray[np.float64], peak: float, beamwidth_deg: float
) -> None:
    reach, why = 90.0, ""
    if name == "azimuth":
        reach, why = min(90.0, _BEAMS * beamwidth_deg), f", {_BEAMS:g} of its beam widths at most"
    for end, side in ((0, -1.0), (-1, 1.0)):
        if side * angle[end] < reach - 1e-6:
            raise bad_line(
                line[end],
                f"{name} cut: ends at {angle[end]:g}°: must reach {side * reach:.4g}°{why}; measure or extend it",
            )
    if name == "azimuth" and abs(peak) > (_BEAMS - 1.0) * beamwidth_deg:
        raise bad_line(
            line[np.argmin(np.abs(angle - peak))],
            f"azimuth cut: its peak, at {peak:.4g}°: must be within {_BEAMS - 1.0:g} beam widths ({beamwidth_deg:.3g}° "
            "each) of boresight; count angles from it",
        )
