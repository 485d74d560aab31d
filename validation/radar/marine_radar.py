"""A ship's marine radar beside its simulation, both measured by the same code: shadow, texture, dispersion.

    python -m validation.radar.marine_radar FOLDER [--turns 6] [--seeds 3] [--plain] [--out PNG]

FOLDER holds .pol files of consecutive turns, as POLAR/2022/03/28/03 of github.com/mousebrains/WAMOS_tpw (R/V Roger
Revelle, Furuno FAR-2117, six turns). A table and a figure; a quarter of a minute a simulated row.

Known of the radar: X band, 1.4 s a turn, 589 radials a second of 3.75 m samples from 180 m on. Not known, and so taken:
mast 25 m (where the header has the wind sensor), pulse 70 ns, 12 kW and HH (of the set's data sheet), five pulses a
radial (3000 Hz over 589), the wind (by the way in which the sea echoes most), and the waves: their lengths and
directions are those that the turns themselves show, and their heights are guessed. Of the video chain turns 00, 01 and
03 told bandwidth (the autocorrelation in range), losses (cells near the noise) and the control's exponent (the fall
with range); the knee is the default. Rows with other guesses show what each would change. No wave truth comes with
these turns.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

import seamap_rt as sr
from seamap_rt.echoes.video import polar_image, video
from seamap_rt.io.polar_images import read_polar_images
from seamap_rt.radar.receiver import noise_power

from .. import FIGURES
from .images import Images, Ring, Waves, box, fastest, fitted_current, peaks, rings, share, standing

FIGURE = FIGURES / "marine_radar.png"
SECTOR, RANGES = (100.0, 240.0), (180.0, 1250.0)  # up the waves, clear of the ship
EDGES = np.array((180.0, 350.0, 550.0, 750.0, 950.0, 1150.0))
BOXES, DISTANCE = (135.0, 170.0, 205.0), 700.0
# Calibration of this ship by the repository's author (configs/default_wamos.yaml), and its blocked sector from the bow.
AZIMUTH_OFFSET, RANGE_OFFSET, BLOCKED = 10.0, -6.0, (160.0, 195.0)
PULSES = 5  # of a radial
NEAR, FAR = (400.0, 300.0), (900.0, 300.0)  # m, distance and side of the boxes in which what stands still is told
ASIDE = (110.0, 135.0, 170.0, 205.0, 230.0)
DEGREE_M = 111_320.0
SWELL, WIND_SEA = (1.5, 9.7, 105.0), (1.2, 6.2, 170.0)  # Hs m, Tp s, from deg

SHIP: dict[str, Any] = {
    "name": "ship",
    "sea.extent_m": 2560.0,
    "sea.resolution_m": 1.6,
    "scattering.polarization": "HH",
    "scattering.sea_spikes": True,
    "scattering.texture": True,
    "scattering.wind_speed_m_s": 7.0,
    "scattering.wind_from_deg": 160.0,
    "radar.frequency_hz": 9.41e9,
    "radar.pulse_width_s": 70e-9,
    "radar.bandwidth_hz": 20e6,
    "radar.prf_hz": 589.0 * PULSES,
    "radar.transmit_power_w": 12e3,
    "radar.noise_figure_db": 6.0,
    "radar.losses_db": 11.0,
    "radar.rotation_rpm": 60.0 / 1.393,
    "radar.sector_deg": list(SECTOR),
    "radar.range_m": list(RANGES),
    "radar.range_sampling_m": 3.75,
    "radar.height_m": 25.0,
    "radar.transmit": "single",
    "radar.receiver.chain": "video",
    "radar.receiver.video_pulses": PULSES,
    "radar.receiver.video_bandwidth_hz": 5e6,
    "radar.receiver.stc_exponent": 1.5,
    "radar.receiver.stc_range_m": 1250.0,
    "radar.antenna.azimuth_beamwidth_deg": 1.23,
    "radar.antenna.elevation_beamwidth_deg": 20.0,
    "radar.antenna.width_m": 1.98,
    "tracing.tracer": "horizon",
    "tracing.height_error_m": 0.2,
    "retrieval.cell_range_m": 7.5,  # not used, but checked
}
LONG_PULSE = {"radar.pulse_width_s": 150e-9, "radar.bandwidth_hz": 10e6}
OTHERWISE: dict[str, tuple[float, dict[str, Any]]] = {  # what is changed: factor of the waves' heights, keys
    "waves 0.6 × as high": (0.6, {}),
    "waves 1.6 × as high": (1.6, {}),
    "mast 18 m": (1.0, {"radar.height_m": 18.0}),
    "mast 35 m": (1.0, {"radar.height_m": 35.0}),
    "pulse 150 ns": (1.0, LONG_PULSE),
    "6 dB less sensitive": (1.0, {"radar.losses_db": 17.0}),
    "150 ns, 6 dB, 1.6 ×": (1.6, LONG_PULSE | {"radar.losses_db": 17.0}),
    "no control": (1.0, {"radar.receiver.stc_exponent": 0.0}),
    "knee 10 dB": (1.0, {"radar.receiver.knee_db": 10.0}),
    "no spikes": (1.0, {"scattering.sea_spikes": False}),
    "no texture": (1.0, {"scattering.texture": False}),
    "straight rays": (1.0, {"tracing.diffraction": "none"}),
    "VV": (1.0, {"scattering.polarization": "VV"}),
}
BEFORE: dict[str, Any] = {  # without texture, spikes and video: the mean of pulses' logarithms
    "scattering.sea_spikes": False,
    "scattering.texture": False,
    "scattering.wind_drift": 0.0,
    "radar.losses_db": 2.0,
    "radar.receiver.knee_db": -60.0,
    "radar.receiver.video_bandwidth_hz": 1e9,
    "radar.receiver.stc_exponent": 0.0,
}


class Measured(NamedTuple):
    """All that is told of one set of turns."""

    images: Images
    rings: list[Ring]
    boxes: list[Waves]
    current: tuple[float, float]
    standing: float
    standing_beside: tuple[float, float]  # in small boxes near and far

    @classmethod
    def of(cls, images: Images) -> Measured:
        images = images.within(SECTOR, RANGES)
        boxes = [box(images, azimuth, DISTANCE) for azimuth in BOXES]
        moving = [each.moving for each in boxes]
        beside = [standing([box(images, azimuth, *place) for azimuth in ASIDE]) for place in (NEAR, FAR)]
        return cls(
            images, rings(images, EDGES), moving, fitted_current(moving), standing(boxes), (beside[0], beside[1])
        )

    @property
    def fall(self) -> float:
        """From the first ring to the last, over the mean spread in a ring."""
        return (self.rings[0].mean - self.rings[-1].mean) / float(np.mean([ring.spread for ring in self.rings]))


def recorded(folder: Path, turns: int) -> Images:
    """The ship's turns; noise from the sector that the ship blocks, far out."""
    files = sorted(path for path in folder.glob("*.pol*") if path.stat().st_size)[:turns]
    if len(files) < 3:
        raise sr.InputError(
            f"FOLDER = '{folder}': holds {len(files)} .pol files: must be at least 3 turns; give another"
        )
    read = read_polar_images(files, AZIMUTH_OFFSET, RANGE_OFFSET)
    video = read["video"].values.astype(np.float64)
    bow = (read["azimuth"].values - read["heading"].values) % 360.0
    blocked = (bow > BLOCKED[0]) & (bow < BLOCKED[1])
    noise = video[blocked][:, (read["range"].values > 2000.0)]
    azimuth, time, turn, ranges = (read[name].values for name in ("azimuth", "time", "turn", "range"))
    return Images(video, azimuth, time, turn, ranges, _drift(read), noise)


def _drift(read: xr.Dataset) -> tuple[float, float]:
    """East and north, m/s, by the positions of the headers; one a turn."""
    latitude, longitude, time = (read[name].values for name in ("latitude", "longitude", "time"))
    first = np.flatnonzero(np.diff(read["turn"].values, prepend=-1))
    north, east = (float(np.polyfit(time[first], place[first], 1)[0]) * DEGREE_M for place in (latitude, longitude))
    return east * float(np.cos(np.radians(latitude[0]))), north


def simulated(turns: int, seed: int = 1, waves: float = 1.0, keys: Mapping[str, Any] | None = None) -> Images:
    """The pictures that the simulated radar shows, and of noise alone."""
    systems = [
        {
            "spectrum": "jonswap",
            "significant_wave_height_m": waves * height,
            "peak_period_s": period,
            "wave_from_deg": direction,
            "spreading": "cos2s",
            "spreading_exponent": 10.0,
        }
        for height, period, direction in (SWELL, WIND_SEA)
    ]
    scene = sr.load_scene(
        "choppy_sea", overrides=SHIP | {"sea.waves": systems, "turns": turns, "seed": seed, **(keys or {})}
    )
    told = {"ship_speed_m_s": 0.0, "wind_speed_m_s": 0.0, "wind_from_deg": 0.0}
    pictures = [polar_image(turn.echoes, scene.radar, told) for turn in sr.iterate(scene, retrieved=False)]
    shown = {
        name: np.concatenate([each[name].values for each in pictures]) for name in ("video", "azimuth", "time", "turn")
    }
    ranges = pictures[0]["range"].values
    unit = np.random.default_rng(seed).standard_normal((1000 * PULSES, ranges.size, 2)) @ np.array((1.0, 1j))
    noise = video(scene.radar, unit * np.sqrt(0.5 * noise_power(scene.radar)), ranges)
    level = shown["video"].astype(np.float64)
    return Images(level, shown["azimuth"], shown["time"], shown["turn"], ranges, (0.0, 0.0), noise.astype(np.float64))


def texture_line(name: str, found: Measured) -> str:
    """A row of the table of the texture: by ring smoothed skewness and share; fall; correlation; standing shares."""
    skewness = ", ".join(f"{ring.smoothed_skewness:.2f}" for ring in found.rings)
    left = ", ".join(f"{ring.smoothed_share:.2f}" for ring in found.rings)
    lags = ", ".join(f"{each:.2f}" for each in found.rings[2].range_correlation)
    near, far = found.standing_beside
    return f"| {name} | {skewness} | {left} | {found.fall:.2f} | {lags} | {near:.2f}, {far:.2f} |"


TEXTURE_HEADER = (
    "| | smoothed skewness at 265, 450, 650, 850, 1050 m | share that smoothing leaves | fall over spread "
    "| correlation in range at 1 to 4 gates | stands still near, far |\n" + "|---" * 6 + "|"
)


def line(name: str, found: Measured) -> str:
    """A row of the table."""
    inner, *_, outer = found.rings
    middle = found.rings[2]
    waves = ", ".join(
        f"{length:.0f} m from {direction:.0f}°" for length, direction in peaks(found.boxes, found.current)
    )
    east, north = found.current
    return (
        f"| {name} | {inner.near_noise:.2f}, {middle.near_noise:.2f}, {outer.near_noise:.2f} "
        f"| {inner.skewness:.2f}, {middle.skewness:.2f}, {outer.skewness:.2f} "
        f"| {middle.range_length:.1f}, {middle.azimuth_length:.1f} | {found.standing:.2f} "
        f"| {share(found.boxes):.2f}, {share(found.boxes, found.current):.2f} "
        f"| {fastest(found.boxes, (0.0, 0.0)):.2f} | {east:+.1f}, {north:+.1f} | {waves} |"
    )


HEADER = (
    "| | cells near the noise at 265, 650, 1050 m | skewness there | half lengths at 650 m, m "
    "| stands still (chance 0.17) | moves on ω² = g k, with the current | a of ω = a √(g k) "
    "| current east, north, m/s | strongest waves |\n" + "|---" * 9 + "|"
)


def figure(real: Measured, made: Measured, out: Path) -> None:
    """Both seas side by side, and what was measured of them."""
    plt.rcParams.update({"font.size": 9})
    drawn, axes = plt.subplot_mosaic(
        [["real", "real", "simulated", "simulated"], ["fall", "noise", "shell", "levels"]],
        figsize=(12.5, 6.6), height_ratios=(1.25, 1.0), layout="constrained",
    )  # fmt: skip
    for name, found in (("real", real), ("simulated", made)):
        _picture(axes[name], found.images, f"{name}: one turn, level within each gate")
    for name, found, style in (("real", real, "-"), ("simulated", made, "--")):
        distance = [ring.distance for ring in found.rings]
        spread = float(np.mean([ring.spread for ring in found.rings]))
        axes["fall"].plot(distance, [ring.mean / spread for ring in found.rings], style, label=name)
        axes["noise"].plot(distance, [ring.near_noise for ring in found.rings], style, label=name)
        faster = np.arange(0.3, 1.81, 0.05)
        axes["shell"].plot(faster, [share(found.boxes, found.current, each) for each in faster], style, label=name)
        level = found.images.level[:, (found.images.ranges > EDGES[2]) & (found.images.ranges < EDGES[3])]
        level = (level - level.mean()) / level.std()
        axes["levels"].hist(
            level.ravel(), np.arange(-4.0, 4.1, 0.2).tolist(), density=True, histtype="step", label=name, ls=style
        )
    axes["shell"].axhline(1.0 / len(np.unique(real.images.turn)), color="0.6", lw=0.8, label="chance")
    for place, x, y, title in (
        (axes["fall"], "range (m)", "mean level over noise / spread", "fall with range"),
        (axes["noise"], "range (m)", "share of cells", "cells near the noise"),
        (axes["shell"], "a", "share of energy", "what moves, on ω = a√(gk) + k·U"),
        (axes["levels"], "level, standard deviations", "density", "levels at 550–750 m"),
    ):
        place.set(xlabel=x, ylabel=y, title=title)
        place.set_ylim(bottom=0.0)
        place.legend(frameon=False)
    drawn.savefig(out, dpi=110)
    plt.close(drawn)


def _picture(place: Any, images: Images, title: str) -> None:
    one = images.turn == images.turn[0]
    level = images.level[one] - images.level.mean(axis=0)
    level = level / images.level.std(axis=0)
    east, north = (
        images.ranges * part[:, None]
        for part in (np.sin(np.radians(images.azimuth[one])), np.cos(np.radians(images.azimuth[one])))
    )
    place.pcolormesh(east, north, level, vmin=-2.0, vmax=2.5, cmap="gray", shading="gouraud", rasterized=True)
    place.set(xlabel="east (m)", ylabel="north (m)", title=title, aspect="equal")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="of .pol files of consecutive turns")
    parser.add_argument("--turns", type=int, default=6)
    parser.add_argument("--seeds", type=int, default=3, help="of the simulated sea as guessed first")
    parser.add_argument("--plain", action="store_true", help="without the rows of other guesses")
    parser.add_argument("--out", type=Path, default=FIGURE)
    given = parser.parse_args()
    told = recorded(given.folder, given.turns)
    real, seeds = Measured.of(told), range(1, 1 + given.seeds)
    rows = [(f"real, {np.unique(told.turn).size} turns", real)]
    rows += [(f"before, seed {seed}", Measured.of(simulated(given.turns, seed, keys=BEFORE))) for seed in seeds]
    made = [Measured.of(simulated(given.turns, seed)) for seed in seeds]
    rows += [(f"simulated, seed {seed}", each) for seed, each in zip(seeds, made, strict=True)]
    if not given.plain:
        rows += [(name, Measured.of(simulated(given.turns, 1, *other))) for name, other in OTHERWISE.items()]
    for header, row in ((HEADER, line), (TEXTURE_HEADER, texture_line)):
        print(header, *(row(*each) for each in rows), sep="\n", end="\n\n", flush=True)
    figure(real, made[0], given.out)


if __name__ == "__main__":
    main()
