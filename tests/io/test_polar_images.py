"""Polar images of marine radars: what is written is read, where it was looked at and when; damage is refused."""

from __future__ import annotations

import bz2
import gzip
import lzma
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.dataset import check
from seamap_rt.io.polar_images import read_polar_images

REAL = Path(__file__).parents[2] / "validation" / "reference" / "wamos_revelle.pol.zst"
SAMPLES, RADIALS = 40, 500
FRAME = "F0001  03-28-2022  {time} {heading:06.2f} 002.10  1.400   021°33.000 {side}  142°30.000 W 191.13 004.12 309.00"
COMPRESS: dict[str, Callable[[bytes], bytes]] = {
    "": lambda content: content,
    ".gz": gzip.compress,
    ".bz2": bz2.compress,
    ".xz": lzma.compress,
    ".zst": lambda content: zstandard.ZstdCompressor().compress(content),
}


def video(seed: int = 0) -> NDArray[np.uint16]:
    return np.random.default_rng(seed).integers(0, 4096, (RADIALS, SAMPLES)).astype("<u2")


def degrees() -> NDArray[np.float64]:
    """Where the beam truly is, from the picture's start: an antenna that slows down by a fifth."""
    part = np.linspace(0.0, 1.0, RADIALS, endpoint=False)
    return 0.4 + 360.0 * part - 36.0 * part * (part - 1.0)


def polar(
    frames: tuple[NDArray[np.uint16], ...] = (video(),),
    time: str = "02:59:59.699",
    heading: float = 230.0,
    side: str = "S",
    header: str = "",
    counter: NDArray[np.int64] | None = None,
) -> bytes:
    """A file, written by the facts of the format."""
    said = "USER  Furuno FAR-2117\nSDRNG   180   CC [m]\nSFREQ 40.00   CC [MHz]\nRPT 1.4 CC [s]\nBO2RA 5 CC [deg]\n"
    said += f"FIFO {SAMPLES} CC samples\nWINDH    25   CC [m]\n{header}"
    stamps = "".join(FRAME.format(time=time, heading=heading, side=side) + "   \n" for _ in frames)
    content = (said + stamps + "EOH   CC END\n").replace("\n", "\r\n").encode("latin-1")
    whole = np.floor(degrees()).astype(np.int64) if counter is None else counter
    for frame in frames:
        words = frame.copy()
        for place, sample in enumerate((18, 19, 20)):
            words[:, sample] |= ((whole >> (8 - 4 * place)) & 15).astype(np.uint16) << 12
        words[:, 0] |= 0xF000  # flags of other meanings
        content += b"%10d" % words.nbytes + words.tobytes()
    return content


@pytest.mark.parametrize("ending", COMPRESS)
def test_what_is_written_is_read(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"one.pol{ending}"
    path.write_bytes(COMPRESS[ending](polar()))
    read = read_polar_images(path)
    check("polar_images", read)
    np.testing.assert_array_equal(read["video"].values, video())
    assert read.attrs["radar"] == "Furuno FAR-2117"
    assert read.attrs["wind_sensor_height_m"] == 25.0
    spacing = 299_792_458.0 / 1.000273 / 2.0 / 40e6
    np.testing.assert_allclose(read["range"].values, 180.0 + spacing * np.arange(SAMPLES), rtol=1e-12)
    np.testing.assert_allclose(read["latitude"].values, -21.55)
    np.testing.assert_allclose(read["longitude"].values, -142.5)


def test_the_beam_is_placed_between_whole_degrees(tmp_path: Path) -> None:
    """From north: heading 230 + bow to radar 5 + 10 of calibration. Steps of the counter are known to half a radial,
    0.4°. Radials come evenly in time."""
    path = tmp_path / "one.pol"
    path.write_bytes(polar())
    read = read_polar_images(path, azimuth_offset_deg=10.0)
    off = (read["azimuth"].values - (degrees() + 245.0) + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(off, 0.0, atol=0.4)
    assert abs(off.mean()) < 0.05
    step = 1.4 * (degrees()[-1] - degrees()[0]) / 360.0 / (RADIALS - 1)
    np.testing.assert_allclose(read["time"].values, step * np.arange(RADIALS), rtol=2e-3)


def test_turns_come_in_the_order_of_their_times(tmp_path: Path) -> None:
    late, early = tmp_path / "a.pol", tmp_path / "b.pol"
    late.write_bytes(polar((video(2),), time="03:00:01.099"))
    early.write_bytes(polar((video(1),)))
    read = read_polar_images([late, early])
    np.testing.assert_array_equal(read["video"].values, np.concatenate((video(1), video(2))))
    assert read["time"].values[RADIALS] == pytest.approx(1.4)
    assert read.attrs["start"].startswith("2022-03-28T02:59:59.699")


def test_a_ship_without_compass_looks_from_the_bow(tmp_path: Path) -> None:
    path = tmp_path / "one.pol"
    path.write_bytes(polar(heading=-9.0))
    read = read_polar_images(path)
    assert read.attrs["azimuth_from"] == "bow"
    assert np.isnan(read["heading"].values).all()
    assert read["azimuth"].values[100] == pytest.approx(degrees()[100] + 5.0, abs=0.4)


def test_a_real_radar_is_read() -> None:
    """Thirty radials of R/V Roger Revelle: what the header says, and 589 radials a second of a turn of 1.373 s."""
    read = read_polar_images(REAL)
    assert read["video"].shape == (30, 752)
    assert read.attrs["radar"] == "Furuno FAR-2117"
    assert float(read["latitude"][0]) == pytest.approx(21.0 + 33.954 / 60.0)
    assert float(read["heading"][0]) == 230.4
    np.testing.assert_allclose(np.diff(read["azimuth"].values).mean(), 360.0 / 808, rtol=0.03)
    assert read["video"].values[:, 0].mean() > 4.0 * read["video"].values[:, -100:].mean()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "no line EOH"),
        (polar()[:200], "no line EOH"),
        (polar()[:-1], "is cut short"),
        (polar().replace(b"F0001", b"G0001"), "no line F0001"),
        (polar().replace(b"SFREQ 40.00", b"SFREQ -4.00"), "SFREQ = -4.00: must be"),
        (polar().replace(b"SFREQ", b"SFRAQ"), "SFREQ = missing"),
        (polar().replace(b"RPT 1.4", b"RPT nan"), "RPT = nan"),
        (polar().replace(b"FIFO 40", b"FIFO 41"), "whole radials of 41"),
        (polar().replace(b"     40000", b"4000000000"), "bytes: must be|is cut short"),
        (polar().replace(b"03-28-2022", b"13-28-2022"), "cannot be read"),
        (polar().replace(b"1.400", b"0.000"), "no turn or place"),
        (polar().replace(b"021\xb0", b"921\xb0"), "no turn or place"),
        (polar(counter=np.zeros(RADIALS, dtype=np.int64)), "does not run"),
        (polar(counter=np.arange(RADIALS)[::-1] % 360), "does not run"),
    ],
)
def test_damage_is_refused_in_one_line(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "one.pol"
    path.write_bytes(content)
    with pytest.raises(sr.InputError, match=words) as refused:
        read_polar_images(path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("ending", [".gz", ".bz2", ".xz", ".zst"])
def test_damaged_packing_is_refused(tmp_path: Path, ending: str) -> None:
    whole = COMPRESS[ending](polar())
    for content in (whole[: len(whole) // 2], b"nothing of the kind", whole[:30] + bytes(40) + whole[70:]):
        path = tmp_path / f"one.pol{ending}"
        path.write_bytes(content)
        with pytest.raises(sr.InputError):
            read_polar_images(path)


def test_a_small_file_that_unpacks_to_much_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.pol.zst"
    with zstandard.open(path, "wb") as bomb:
        for _ in range(300):
            bomb.write(bytes(1 << 20))
    assert path.stat().st_size < 100_000
    with pytest.raises(sr.InputError, match="more than 268 MB"):
        read_polar_images(path)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.integers(0, 700), value=st.integers(0, 255))
def test_any_changed_byte_of_the_header_is_read_or_refused(tmp_path: Path, place: int, value: int) -> None:
    content = bytearray(polar())
    content[place] = value
    path = tmp_path / "one.pol"
    path.write_bytes(bytes(content))
    with suppress(sr.InputError):
        read = read_polar_images(path)
        assert np.isfinite(read["time"].values).all()
        assert np.isfinite(read["azimuth"].values).all()
