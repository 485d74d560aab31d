"""Amplitude dispersion of a recorded nonlinear sea, wave by wave, against theory; and what free waves can forecast.

    python -m validation.sea.amplitude_dispersion RECORD [RECORD …]

RECORD: a `recorded_sea.nc` of deep water with its surface potential (`validation.prediction.nonlinear_seas` says how).
From elevation η and potential φ of a mode k the amplitude of the wave that runs along k is η + i √(k/g) φ. How fast its
phase gets ahead of linear waves over 16 s, of all such waves of a band together, stands beside `sea_shift` of the
record's own spectrum; `alike` is how much of them still agrees with themselves then. Below: a whole frame carried on by
free waves, linear ones and those that theory hastens, and the correlation of what they make with the frames that came:
more than that no forecast by free waves can know, however good the maps are.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from seamap_rt.conventions import GRAVITY
from seamap_rt.io.recorded_sea import RecordedSea, recorded_sea
from seamap_rt.physics.dispersion import sea_shift

Waves = NDArray[np.complex128]
LAG_S, EACH_S = 16.0, 2.0
BANDS = (0.08, 0.11, 0.14, 0.18, 0.23, 0.3, 0.4, 0.55)  # rad/m
WAYS = ((0.0, 23.0), (23.0, 52.0))  # deg from the mean direction, which is east
AHEAD_S = (5.0, 10.0, 20.0, 30.0)
RINGS, DIRECTIONS = 96, 36


@dataclass(frozen=True)
class Record:
    """The waves of a record's frames, rows along y and columns along x in an FFT's order."""

    file: RecordedSea

    @cached_property
    def k(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Wavevectors east and north, and their length, 1 in place of 0 [rad/m]."""
        rows, columns = self.file.elevation(0).shape
        east, north = (2.0 * np.pi * np.fft.fftfreq(n, self.file.spacing_m) for n in (columns, rows))
        kx, ky = np.meshgrid(east, north)
        length = np.hypot(kx, ky)
        away = np.where(length > 0.0, length, 1.0)
        return np.asarray(kx, np.float64), np.asarray(ky, np.float64), np.asarray(away, np.float64)

    @cached_property
    def omega(self) -> NDArray[np.float64]:
        """rad/s, of linear waves."""
        return np.sqrt(GRAVITY * self.k[2])

    def waves(self, frame: int) -> Waves:
        """Amplitudes [m] of the waves that run along their wavevectors: the surface is the real part of their sum."""
        rise, flow = (np.fft.fft2(each(frame)) for each in (self.file.elevation, self.file.surface_potential))
        made = (rise + 1j * np.sqrt(self.k[2] / GRAVITY) * flow) / rise.size
        made[0, 0] = 0.0
        return made

    def frames(self, step_s: float) -> range:
        return range(0, self.file.frames, round(step_s / self.file.step_s))

    def shift(self, waves: Waves) -> NDArray[np.float64]:
        """rad/s, by theory, of each wave among these."""
        kx, ky, k = self.k
        rings = np.geomspace(0.03, float(k.max()), RINGS)
        ring = np.log(k / rings[0]) / np.log(rings[1] / rings[0])
        way = np.arctan2(kx, ky) % (2.0 * np.pi) / (2.0 * np.pi) * DIRECTIONS
        near = np.clip(np.rint(ring), 0, RINGS - 1).astype(int) * DIRECTIONS + np.rint(way).astype(int) % DIRECTIONS
        variance = np.bincount(near.ravel(), 0.5 * np.abs(waves.ravel()) ** 2, RINGS * DIRECTIONS)
        table = sea_shift(rings, np.asarray(variance, np.float64).reshape(RINGS, DIRECTIONS))
        return map_coordinates(np.concatenate((table, table[:, :1]), axis=1), [ring, way], order=1, mode="nearest")


def print_shifts(record: Record) -> None:
    every = record.frames(EACH_S)
    lag, (kx, ky, k) = round(LAG_S / EACH_S), record.k
    waves = np.array([record.waves(frame).astype(np.complex64) for frame in every])
    power = np.mean(np.abs(waves) ** 2, axis=0)
    product = np.mean(waves[lag:] * np.conj(waves[:-lag]), axis=0) * np.exp(1j * record.omega * LAG_S)
    theory = record.shift(np.sqrt(power).astype(np.complex128))
    away = np.degrees(np.abs(np.arctan2(ky, kx)))
    print("  rad/m         deg from east  energy   alike   rad/s   theory   ratio")
    for low, high in pairwise(BANDS):
        for first, last in WAYS:
            band = (k >= low) & (k < high) & (away >= first) & (away < last)
            total = product[band].sum()
            found, said = -np.angle(total) / LAG_S, np.average(theory[band], weights=power[band])
            print(
                f"  {low:.2f}–{high:.2f}  {first:4.0f}–{last:2.0f}  {power[band].sum() / power.sum():14.1%} "
                f"{np.abs(total) / power[band].sum():9.3f} {found:8.4f} {said:8.4f} {found / said:7.2f}"
            )


def print_ahead(record: Record) -> None:
    begin, (kx, *_), last = 40, record.k, record.file.frames
    waves = record.waves(begin)
    ways = {"linear": 0.0 * kx, "theory": record.shift(waves), "a current of 0.1 m/s": 0.1 * kx}
    print("  correlation of a frame carried on: " + ", ".join(f"{ahead:g} s" for ahead in AHEAD_S))
    for name, shift in ways.items():
        row = []
        for ahead in AHEAD_S:
            frame = begin + round(ahead / record.file.step_s)
            if frame >= last:
                continue
            made = np.real(np.fft.ifft2(waves * np.exp(-1j * (record.omega + shift) * ahead)))
            row.append(f"{np.corrcoef(made.ravel(), record.file.elevation(frame).ravel())[0, 1]:.3f}")
        print(f"  {name:22}" + " ".join(row), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("records", type=Path, nargs="+")
    for path in parser.parse_args().records:
        record = Record(recorded_sea(str(path)))
        if not record.file.potential:
            raise SystemExit(f"{path}: has no surface potential, by which waves that run either way are told apart")
        print(path)
        print_shifts(record)
        print_ahead(record)


if __name__ == "__main__":
    main()
