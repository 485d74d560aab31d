"""Polar images of a marine radar as WaMoS II writes them (.pol, also compressed): one turn of received video a frame.

A file holds lines of ASCII, `KEY value CC comment`, up to the line EOH. For each frame there is a line F0001, F0002 …
of the time and the ship, and after EOH ten digits, the bytes of the frame, and little-endian words of 16 bits (radial,
sample). The lower 12 bits of a word are the video; the upper four of the samples 18 to 20 make a counter of whole
degrees from the picture's start. The facts are those that github.com/mousebrains/WAMOS_tpw documents (MIT licence).

The video is in counts by a law that no header tells (of the Furuno sets it is near a logarithm); it is no power. No
header says the antenna's height, the pulse or the polarization either.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import SPEED_OF_LIGHT
from ..dataset import build
from ..errors import InputError, Refusal, must_be, say_of
from .opening import read_unpacked
from .results_folder import write_whole
from .text import parse_number

_MOST_BYTES = 256 << 20  # of a file, decompressed: some hundred turns
_MOST_HEADER = 1 << 20
_LENGTH = 10  # digits that say how many bytes a frame has
_VIDEO, _FLAGS = 0x0FFF, 12
_COUNTER = (18, 19, 20)  # samples whose flags count degrees, high digits first
_AIR = 1.000273  # refractive index
_LARGEST_STEP = 30  # deg between two radials: more is damage
_LEAST_SECTOR = 3  # deg: the counter must step twice
_EPOCH = datetime(2000, 1, 1, tzinfo=UTC)  # of a simulation's time 0
_KNOT = 1852.0 / 3600.0
# What a header must say, and within which limits: key → least, most, unit.
_NUMBERS: dict[str, tuple[float, float, str]] = {
    "SFREQ": (0.1, 1e3, "MHz"),
    "SDRNG": (0.0, 1e5, "m"),
    "FIFO": (_COUNTER[-1] + 1, 1 << 16, "samples"),
    "RPT": (0.2, 60.0, "s"),
}
_FRAME = re.compile(
    r"F\d{4}\s+(?P<date>\d\d-\d\d-\d{4})\s+(?P<time>\d\d:\d\d:\d\d(?:\.\d+)?)\s+(?P<heading>-?[\d.]+)\s+"
    r"(?P<speed>-?[\d.]+)\s+(?P<period>-?[\d.]+)\s+(?P<latitude>\d+\D\s*[\d.]+\s*[NS])\s+"
    r"(?P<longitude>\d+\D\s*[\d.]+\s*[EW])\s+(?P<course>-?[\d.]+)\s+(?P<wind_speed>-?[\d.]+)\s+(?P<wind_from>-?[\d.]+)"
)


@dataclass(frozen=True)
class _Frame:
    start: datetime
    period: float
    ship: dict[str, float]  # heading, latitude, longitude: deg
    video: NDArray[np.uint16]  # (radial, sample)
    degrees: NDArray[np.float64]  # (radial,) from the picture's start, growing


def read_polar_images(
    paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    azimuth_offset_deg: float = 0.0,
    range_offset_m: float = 0.0,
) -> xr.Dataset:
    """Turns of one file or several as a dataset `polar_images`: `video` (pulse, range) in counts, with `time`,
    `azimuth` from north, `turn`, `heading`, `latitude` and `longitude` of each pulse (NaN where unknown).

    paths: of one or several .pol, plain or compressed as .zst, .gz, .bz2 or .xz, put in the order of their times.
    azimuth_offset_deg, range_offset_m: calibration that is added to what the headers say. Attributes: what the first
    header says of radar, ship and wind, and `start`, the date and time of time 0. Turns come one after the other: where
    a stamp is earlier than the last turn's end (stamps stray by a tenth of a second), it is taken as it is.

    Raises InputError, in one line, for files that are truncated, damaged or absurd.
    """
    given: list[Any] = list(paths) if isinstance(paths, Iterable) and not isinstance(paths, str) else [paths]
    for each in given:
        must_be("paths", each, (str, os.PathLike), "the paths of .pol files")
    if not given:
        raise InputError("paths: no file is named; give at least one .pol")
    for name, value in (("azimuth_offset_deg", azimuth_offset_deg), ("range_offset_m", range_offset_m)):
        if not abs(value) <= 1e4:
            raise InputError(f"{name} = {value:g}: must be −10000 to 10000; correct it")
    files = []
    for path in given:
        content = read_unpacked(path, "a .pol", most=_MOST_BYTES)
        with say_of(f"{Path(path)}: "):
            files.append(_read(content))
    header = files[0][0]
    for path, (other, _) in zip(given, files, strict=True):
        for key in ("SFREQ", "SDRNG", "FIFO"):
            if _number(other, key) != _number(header, key):
                raise InputError(f"{path}: {key} differs from {given[0]}'s; read files of one setting together")
    frames = sorted((frame for _, held in files for frame in held), key=lambda frame: frame.start)
    return _dataset(header, frames, azimuth_offset_deg, range_offset_m)


def write_polar_image(path: str | os.PathLike[str], image: xr.Dataset) -> None:
    """Write one turn of `polar_images` to a .pol file that `read_polar_images` reads; the file appears whole or not.

    image: with `turn_s`, ship's speed and wind among its attributes, as the reader gives them. `start` is left out by a
    simulation, whose time 0 is then the beginning of 2000. The file keeps whole degrees of the counter, and 12 bits.
    Raises InputError for a sector or a window that the format cannot hold.
    """
    azimuth, ranges, words = (image[name].values for name in ("azimuth", "range", "video"))
    swept = np.maximum.accumulate(np.unwrap(azimuth, period=360.0) - azimuth[0]) if azimuth.size else azimuth
    if not azimuth.size or swept[-1] < _LEAST_SECTOR or swept[-1] > 361.0:
        turned = float(swept[-1]) if azimuth.size else 0.0
        raise InputError(f"{path}: the turn covers {turned:.3g}°: must be {_LEAST_SECTOR} to 360; set radar.sector_deg")
    if ranges.size <= _COUNTER[-1]:
        raise InputError(
            f"{path}: has {ranges.size} gates: must be at least {_COUNTER[-1] + 1}; widen radar.range_m or lower "
            "radar.range_sampling_m"
        )
    words = words.astype("<u2") & np.uint16(_VIDEO)
    for place, sample in enumerate(_COUNTER):
        digit = (swept.astype(np.int64) >> (8 - 4 * place)) & 15
        words[:, sample] |= digit.astype(np.uint16) << _FLAGS
    ship = image.attrs
    begun = datetime.fromisoformat(ship["start"]) if "start" in ship else _EPOCH
    begun += timedelta(seconds=float(image["time"][0]))
    first = {name: np.nan_to_num(float(image[name][0])) for name in ("heading", "latitude", "longitude")}
    stamp = (
        f"F0001  {begun:%m-%d-%Y}  {begun:%H:%M:%S.%f} {first['heading']:06.2f} {ship['ship_speed_m_s'] / _KNOT:06.2f} "
        f"{ship['turn_s']:.6f}  {_degrees_minutes(first['latitude'], 'NS')}  "
        f"{_degrees_minutes(first['longitude'], 'EW')} "
        f"{first['heading']:06.2f} {ship['wind_speed_m_s']:06.2f} {ship['wind_from_deg']:06.2f}"
    )
    lines = [
        f"USER {ship['radar'] or 'seamap_rt'}",
        f"SFREQ {SPEED_OF_LIGHT / _AIR / (2e6 * (ranges[1] - ranges[0])):.9f} CC [MHz]",
        f"SDRNG {ranges[0]:.6f} CC [m]",
        f"FIFO {ranges.size} CC samples",
        f"RPT {ship['turn_s']:.6f} CC [s]",
        f"BO2RA {(azimuth[0] - first['heading']) % 360.0:.6f} CC [deg]",
        f"WINDT {int(ship['wind_is_true'])}",
        stamp,
        "EOH   CC END",
        f"{words.nbytes:10d}",
    ]
    write_whole(Path(path), "\r\n".join(lines).encode("latin-1") + words.tobytes())


def _degrees_minutes(degrees: float, sides: str) -> str:
    return f"{int(abs(degrees)):03d}°{abs(degrees) % 1.0 * 60.0:09.6f} {sides[int(degrees < 0.0)]}"


def _dataset(header: Mapping[str, str], frames: list[_Frame], offset: float, range_offset: float) -> xr.Dataset:
    counts = [frame.degrees.size for frame in frames]
    zero = sum(_number(header, key) for key in ("BO2RA", "HDGDL", "CMPOFF")) + offset
    seconds = [  # radials come evenly, whatever the antenna does
        (frame.start - frames[0].start).total_seconds()
        + np.linspace(0.0, (frame.degrees[-1] - frame.degrees[0]) / 360.0 * frame.period, frame.degrees.size)
        for frame in frames
    ]
    azimuth = [frame.degrees + zero + np.nan_to_num(frame.ship["heading"]) for frame in frames]
    step = SPEED_OF_LIGHT / _AIR / (2e6 * _number(header, "SFREQ"))
    ship = {
        name: np.repeat([frame.ship[name] for frame in frames], counts) for name in ("heading", "latitude", "longitude")
    }
    return build(
        "polar_images",
        {"video": np.concatenate([frame.video for frame in frames]), **ship},
        {
            "pulse": np.arange(sum(counts)),
            "range": _number(header, "SDRNG") + range_offset + step * np.arange(int(_number(header, "FIFO"))),
            "time": np.concatenate(seconds),
            "azimuth": np.concatenate(azimuth) % 360.0,
            "turn": np.repeat(np.arange(len(frames)), counts),
        },
        {
            "radar": header.get("USER", ""),
            "site": header.get("TOWER", ""),
            "start": frames[0].start.isoformat(),
            "turn_s": float(np.mean([frame.period for frame in frames])),
            "azimuth_from": "bow" if any(np.isnan(frame.ship["heading"]) for frame in frames) else "north",
            "ship_speed_m_s": frames[0].ship["speed"] * _KNOT,
            "wind_speed_m_s": frames[0].ship["wind_speed"],
            "wind_from_deg": frames[0].ship["wind_from"],
            "wind_is_true": int(_number(header, "WINDT")),
            "wind_sensor_height_m": _number(header, "WINDH", np.nan),
        },
    )


def _read(content: bytes) -> tuple[dict[str, str], list[_Frame]]:
    """Header and frames of one file."""
    end = content.find(b"\nEOH", 0, _MOST_HEADER)
    begin = content.find(b"\n", end + 1) + 1
    if end < 0 or not begin:
        raise Refusal("has no line EOH, so it is no polar image or is cut short; give a whole .pol")
    lines = content[:end].decode("latin-1").splitlines()
    header = _header(lines)
    stamps = [match for line in lines if (match := _FRAME.match(line.strip()))]
    if not stamps:
        raise Refusal("has no line F0001 that says when and where the frame was taken; give a whole .pol")
    frames = []
    for stamp in stamps:
        words, begin = _words(content, begin, int(_number(header, "FIFO")))
        frames.append(_frame(stamp, words))
    return header, frames


def _header(lines: list[str]) -> dict[str, str]:
    """key → what stands before the comment."""
    header = {}
    for line in lines:
        key, _, rest = line.partition(" ")
        if re.fullmatch(r"[A-Z0-9_]{2,8}", key) and key != "CC":
            header.setdefault(key, re.split(r"\s+CC\b", f" {rest}", maxsplit=1)[0].strip())
    for key, (least, most, unit) in _NUMBERS.items():
        value = _number(header, key, np.nan)
        if not least <= value <= most:
            raise Refusal(
                f"{key} = {header.get(key, 'missing')}: must be {least:g} to {most:g} {unit}; give a whole file"
            )
    return header


def _number(header: Mapping[str, str], key: str, otherwise: float = 0.0) -> float:
    try:
        value = parse_number(header[key].split()[0])
    except (KeyError, IndexError, ValueError):
        return otherwise
    return value if np.isfinite(value) else otherwise


def _words(content: bytes, begin: int, samples: int) -> tuple[NDArray[np.uint16], int]:
    """The words of the frame that begins there (radial, sample), and where the next one begins."""
    digits = content[begin : begin + _LENGTH].strip()
    begin += _LENGTH
    size = int(digits) if digits.isdigit() else 0
    if not size or size % (2 * samples):
        given = digits.decode("ascii", "replace")
        raise Refusal(f"a frame of '{given}' bytes: must be whole radials of {samples} samples; give a whole file")
    if begin + size > len(content):
        raise Refusal(f"is cut short: a frame has {len(content) - begin} of {size} bytes; give a whole file")
    return np.frombuffer(content, "<u2", size // 2, begin).reshape(-1, samples), begin + size


def _frame(stamp: re.Match[str], words: NDArray[np.uint16]) -> _Frame:
    try:
        time = stamp["time"] if "." in stamp["time"] else f"{stamp['time']}.0"
        start = datetime.strptime(f"{stamp['date']} {time[:15]}", "%m-%d-%Y %H:%M:%S.%f").replace(tzinfo=UTC)
        numbers = {name: float(stamp[name]) for name in ("period", "heading", "speed", "wind_speed", "wind_from")}
        place = {name: _place(stamp[name]) for name in ("latitude", "longitude")}
    except ValueError as error:
        raise Refusal(f"the frame's line cannot be read ({error}); give a whole file") from None
    least, most, _ = _NUMBERS["RPT"]
    on_earth = abs(place["latitude"]) <= 90.0 and abs(place["longitude"]) <= 180.0
    if not (least <= numbers["period"] <= most and on_earth):
        raise Refusal(f"the frame's line says '{stamp[0]}': no turn or place is such; give a whole file")
    period = numbers.pop("period")
    if not 0.0 <= numbers["heading"] <= 360.0:  # −9 where no compass is heard
        numbers["heading"] = np.nan
    return _Frame(start, period, numbers | place, words & np.uint16(_VIDEO), _degrees(words))


def _place(text: str) -> float:
    """Degrees, from degrees and minutes and N, S, E or W."""
    degrees, minutes, side = re.fullmatch(r"(\d+)\D\s*([\d.]+)\s*([NSEW])", text).groups()  # type: ignore[union-attr]
    return (float(degrees) + float(minutes) / 60.0) * (-1.0 if side in "SW" else 1.0)


def _degrees(words: NDArray[np.uint16]) -> NDArray[np.float64]:
    """(radial,) where the beam is, between the radials at which the counter steps evenly."""
    digits = (words[:, _COUNTER] >> _FLAGS).astype(np.int64)
    counter = digits @ np.array([256, 16, 1])
    steps = np.diff(counter)
    steps[steps < -180] += 360
    at = np.flatnonzero(steps)
    if at.size < 2 or (steps < 0).any() or steps.max() > _LARGEST_STEP:
        raise Refusal("the counter of degrees in samples 18 to 20 does not run; the file is damaged")
    whole = counter[0] + np.cumsum(steps)[at]
    radial, where = np.arange(counter.size), at + 0.5
    rate = (whole[-1] - whole[0]) / (where[-1] - where[0])
    degrees = np.interp(radial, where, whole)
    degrees[: at[0] + 1] = whole[0] + rate * (radial[: at[0] + 1] - where[0])
    degrees[at[-1] + 1 :] = whole[-1] + rate * (radial[at[-1] + 1 :] - where[-1])
    return degrees
