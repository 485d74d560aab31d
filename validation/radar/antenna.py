"""The study's antenna, 1 m × 0.1 m at 10 GHz: both cuts of the default pattern, their widths, sidelobes and gain.

    python -m validation.radar.antenna [--out validation/figures/antenna_pattern.png]

Prints beam width, first null, first sidelobe and the gain as measured on the pattern, beside Taylor's closed form, and
the share of the power that lies beyond the three azimuth beams to either side which the simulation hears.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.optimize import brentq

from seamap_rt.conventions import SPEED_OF_LIGHT, db
from seamap_rt.radar.antenna import Antenna, Cut, antenna_of
from seamap_rt.radar.scan import BEAMS_BEYOND
from seamap_rt.report.style import BLACK, BLUE, GREY, ORANGE, graph, new_figure, place, png, styled
from seamap_rt.settings import AntennaSettings
from validation import FIGURES

FREQUENCY_HZ = 10e9
ANGLE_DEG = np.linspace(0.0, 90.0, 180_001)
PATTERNS = ("one-way", "two-way")


@dataclass(frozen=True)
class Lobe:
    """What stands out on one cut, in degrees and dB."""

    width: float
    null: float
    angle: float
    level: float


def measured(cut: Cut, width: float) -> Lobe:
    """Read off the cut on a grid of 0.0005°."""
    voltage = cut(np.sin(np.radians(ANGLE_DEG)))
    null = int(np.flatnonzero(np.diff(np.sign(voltage)))[0])
    top = null + int(np.argmax(np.abs(voltage[null:])))
    return Lobe(width, float(ANGLE_DEG[null]), float(ANGLE_DEG[top]), float(db(voltage[top] ** 2)))


def closed_form(width_deg: float, aperture_m: float) -> tuple[float, Lobe]:
    """Taylor's B for a beam width, and the lobes that it implies (Taylor 1953; Hansen 1964)."""
    length = aperture_m * FREQUENCY_HZ / SPEED_OF_LIGHT
    half = length * np.sin(np.radians(width_deg) / 2.0)

    def excess(b: float) -> float:
        return float(np.real(np.sinc(1j * np.emath.sqrt(b**2 - half**2)) / np.sinc(1j * b))) - np.sqrt(0.5)

    b = float(brentq(excess, 0.0, 3.0))  # type: ignore[arg-type]
    null, top = np.degrees(np.arcsin(np.hypot([1.0, 1.430297], b) / length))
    return b, Lobe(width_deg, null, top, -13.2615 - 20.0 * np.log10(np.sinh(np.pi * b) / (np.pi * b)))


def beyond(cut: Cut, width_deg: float, power: int) -> float:
    """Share of ∫ Eᵖ over the azimuth ahead that lies beyond the beams which the simulation hears."""
    angle = np.concatenate((-ANGLE_DEG[:0:-1], ANGLE_DEG))
    level = np.abs(cut(np.sin(np.radians(angle)))) ** power
    return float(level[np.abs(angle) > BEAMS_BEYOND * width_deg].sum() / level.sum())


def print_table(beam: Antenna, gaussian: Cut) -> None:
    settings = AntennaSettings()
    print(f"{'':26}{'B':>8}{'−3 dB':>10}{'first null':>12}{'sidelobe at':>13}{'level':>11}")
    for name, cut, aperture, width, beamwidth in (
        ("azimuth", beam.azimuth, settings.width_m, settings.azimuth_beamwidth_deg, beam.azimuth_beamwidth_deg),
        (
            "elevation",
            beam.elevation,
            settings.height_m,
            settings.elevation_beamwidth_deg,
            beam.elevation_beamwidth_deg,
        ),
    ):
        b, theory = closed_form(width, aperture)
        for label, taper, lobe in (("measured", "", measured(cut, beamwidth)), ("Taylor", f"{b:.4f}", theory)):
            cells = f"{lobe.width:9.4f}°{lobe.null:11.3f}°{lobe.angle:12.3f}°{lobe.level:8.2f} dB"
            print(f"{name:<10} {aperture:4.1f} m  {label:<8}{taper:>8}{cells}")
    area = 4.0 * np.pi * settings.width_m * settings.height_m * (FREQUENCY_HZ / SPEED_OF_LIGHT) ** 2
    print(f"gain {float(db(beam.gain)):.2f} dBi; 4πA/λ² {float(db(area)):.2f} dBi: the taper takes the difference")
    print(f"share of the power beyond ±{BEAMS_BEYOND:g} azimuth beams:")
    for name, cut in (("Taylor", beam.azimuth), ("Gaussian", gaussian)):
        shares = [beyond(cut, settings.azimuth_beamwidth_deg, power) for power in (2, 4)]
        words = (
            f"{share:.2e} ({float(db(share)):.1f} dB) {pattern}"
            for share, pattern in zip(shares, PATTERNS, strict=True)
        )
        print(f"{name:<10} {', '.join(words)}")


@styled
def draw(beam: Antenna) -> Figure:
    figure = new_figure(2.75)
    cuts = (
        ("azimuth, 1 m aperture", beam.azimuth, beam.azimuth_beamwidth_deg, 15.0),
        ("elevation, 0.1 m aperture", beam.elevation, beam.elevation_beamwidth_deg, 90.0),
    )
    for column, (title, cut, width, reach) in enumerate(cuts):
        axes = place(figure, 0.5 + 3.45 * column, 0.3, 3.0, 1.75)
        graph(axes, "angle from boresight, °", "one-way, dB" if column == 0 else "", title)
        draw_cut(axes, cut, width, reach)
        if column == 0:
            heard = [side * BEAMS_BEYOND * width for side in (-1.0, 1.0)]
            label = f"±{BEAMS_BEYOND:g} beams, as far as simulated"
            axes.vlines(heard, -50.0, 0.0, color=ORANGE, linestyle="--", linewidth=0.9, label=label)
    figure.axes[0].legend(loc="upper left", bbox_to_anchor=(0.0, -0.2), ncols=3)
    return figure


def draw_cut(axes: Axes, cut: Cut, width: float, reach: float) -> None:
    angle: NDArray[np.float64] = np.linspace(-reach, reach, 4001)
    level = db(cut(np.sin(np.radians(angle))) ** 2)
    axes.plot(angle, level, color=BLUE, label="Taylor, one parameter")
    axes.plot(angle, 40.0 * np.log10(0.5) * (angle / width) ** 2, color=GREY, linestyle=":", label="Gaussian")
    lobe = measured(cut, width)
    axes.plot([-0.5 * width, 0.5 * width], [db(0.5)] * 2, color=BLACK, marker="|", linewidth=0.8)
    axes.annotate(f"{width:.2f}°", (0.5 * width, -3.0), (4.0, 1.0), textcoords="offset points")
    axes.plot([lobe.angle], [lobe.level], color=BLACK, marker="o", markersize=3.0)
    axes.annotate(
        f"−{-lobe.level:.1f} dB at {lobe.angle:.1f}°",
        (lobe.angle, lobe.level),
        (0.0, 6.0),
        textcoords="offset points",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
    )
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-50.0, 1.5)
    axes.set_xticks(np.linspace(-reach, reach, 7))


def main() -> None:
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--out", type=Path, default=FIGURES / "antenna_pattern.png")
    chosen = options.parse_args()
    beam = antenna_of(AntennaSettings(), FREQUENCY_HZ, 0.0)
    print_table(beam, antenna_of(AntennaSettings(pattern="gaussian"), FREQUENCY_HZ, 0.0).azimuth)
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    chosen.out.write_bytes(png(draw(beam)))


if __name__ == "__main__":
    main()
