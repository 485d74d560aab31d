"""How a boat follows the sea: roll, pitch and heave beside the sea's elevation under it, on two courses.

    python -m validation.radar.boat [--length 7] [--beam 2.5] [--speed 3] [--headings 270 0] [--seconds 60] [--out PNG]

The sea is that of the scene choppy_sea, seed 1, waves from the west; the boat follows it as `wave_following` does. With
the figure comes a table: rms of each motion, the mean period between its upward crossings of zero, and the share of the
variance of the sea's elevation and slopes below its middle that the boat takes up. The sea there is the exact sum of
all its waves, every eighth of a second, which takes a minute.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.radar.platform import BoatState, boat_motion
from seamap_rt.sea import Sea, SurfaceState, direct_sum, realize
from seamap_rt.settings import JonswapWaves, PlatformSettings, SeaSettings
from validation import FIGURES

FIGURE = FIGURES / "boat_motion.png"
WAVES_FROM = 270.0
STEP = 0.125  # s, between the sea's elevations: each is summed wave by wave


def choppy_sea() -> Sea:
    """The waves of scenes/choppy_sea.toml."""
    waves = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5, wave_from_deg=WAVES_FROM)
    return realize(SeaSettings(waves=(waves,)), np.random.SeedSequence(1, spawn_key=(1,)))


def under(sea: Sea, states: list[BoatState], times: NDArray[np.float64]) -> SurfaceState:
    """The sea at the positions of boats, (boat, time)."""
    positions = np.stack([state.position for state in states])
    return direct_sum(sea.components(), positions[..., 0], positions[..., 1], times)


def mean_period(times: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Mean time between upward crossings of the mean, s."""
    about = values - values.mean()
    up = np.flatnonzero((about[:-1] < 0.0) & (about[1:] >= 0.0))
    return float((times[up[-1]] - times[up[0]]) / (up.size - 1)) if up.size > 1 else np.nan


def course_in_words(heading_deg: float) -> str:
    off = abs((heading_deg - WAVES_FROM + 180.0) % 360.0 - 180.0)
    return "into the waves" if off < 30.0 else "with the waves" if off > 150.0 else "across the waves"


def following(arguments: argparse.Namespace, heading_deg: float) -> PlatformSettings:
    """The boat of the command line."""
    return PlatformSettings(
        motion="wave_following",
        speed_m_s=arguments.speed,
        heading_deg=heading_deg,
        length_m=arguments.length,
        beam_m=arguments.beam,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--length", type=float, default=7.0)
    parser.add_argument("--beam", type=float, default=2.5)
    parser.add_argument("--speed", type=float, default=3.0)
    parser.add_argument("--headings", type=float, nargs=2, default=(270.0, 0.0))
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--out", type=Path, default=FIGURE)
    arguments = parser.parse_args()
    sea = choppy_sea()
    times, coarse = np.arange(0.0, arguments.seconds, 0.05), np.arange(0.0, arguments.seconds, STEP)
    figure, panels = plt.subplots(3, 2, figsize=(10.0, 6.2), sharex=True, sharey="row")
    print(f"{'heading':>8}{'motion':>8}{'rms':>10}{'period s':>10}{'of the sea':>12}")
    motions = [boat_motion(following(arguments, heading), sea) for heading in arguments.headings]
    water = under(sea, [motion(coarse) for motion in motions], coarse)
    for number, (column, heading) in enumerate(zip(panels.T, arguments.headings, strict=True)):
        state, there = motions[number](times), motions[number](coarse)
        east, north = unit_from_azimuth(heading)
        ahead = np.degrees(np.arctan(water.slopes[number] @ (east, north)))
        port = np.degrees(np.arctan(water.slopes[number] @ (-north, east)))
        rows = (
            ("heave", "m", state.position[:, 2], there.position[:, 2], water.elevation[number]),
            ("pitch", "°", state.attitude[:, 1], there.attitude[:, 1], ahead),
            ("roll", "°", state.attitude[:, 0], there.attitude[:, 0], port),
        )
        for panel, (name, unit, boat, sampled, surface) in zip(column, rows, strict=True):
            panel.plot(coarse, surface, color="0.65", linewidth=0.9, label="the sea below its middle")
            panel.plot(times, boat, color="C0", linewidth=1.2, label="the boat")
            panel.axhline(0.0, color="0.8", linewidth=0.5, zorder=0)
            share = np.var(sampled) / np.var(surface)
            panel.text(0.995, 0.03, f"rms {boat.std():.2f} {unit}", ha="right", fontsize=8, transform=panel.transAxes)
            print(f"{heading:8.0f}{name:>8}{boat.std():8.3f} {unit}{mean_period(times, boat):10.2f}{share:12.2f}")
        column[0].set_title(f"heading {heading:.0f}°, {course_in_words(heading)}, {arguments.speed:g} m/s", fontsize=9)
        column[-1].set_xlabel("time (s)")
    for panel, label in zip(panels[:, 0], ("heave (m)", "pitch (°), bow up", "roll (°), starboard down"), strict=True):
        panel.set_ylabel(label)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), fontsize=7, loc="upper right", ncols=2)
    figure.suptitle(
        f"A boat of {arguments.length:g} × {arguments.beam:g} m on the sea of choppy_sea (Hs 1.4 m, 5.5 s, from 270°)",
        fontsize=10,
        x=0.02,
        ha="left",
    )
    figure.tight_layout()
    figure.savefig(arguments.out, dpi=130)


if __name__ == "__main__":
    main()
