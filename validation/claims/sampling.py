"""The design study's claim that its maps sample waves longer than 6 m (9): the grid, and how well maps resolve them.

    python -m validation.claims.sampling [--seeds 2] [--out DIR]

Maps of `choppy_sea` without the radar's noise are compared with the true surface, taken as points at each cell's
position and time, and both are transformed along looks up and down the waves, 50 to 125 m, and along arcs across them,
about 95 m out. By wavelength along the line this gives the gain, |cross-spectrum| over the sea's spectrum, and the
coherence: the share of the map's variance that is the sea's. A cell without a height counts as mean level.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import unit_from_azimuth, wrap_degrees
from seamap_rt.report import style
from seamap_rt.settings import RetrievalSettings
from seamap_rt.simulation import Simulator

from ..options import options
from .radar import NOT, ONLY_IF, STUDY, Claim

Array = NDArray[np.float64]
GRID_M = 3.0
LONGEST_M = 6.0  # of the waves that the study's grid cannot hold
CELL_DEG = RetrievalSettings().cell_azimuth_deg
EVEN_M = GRID_M / np.radians(CELL_DEG)  # where a cell is as wide as it is long
WAVES_FROM = 270.0
HALF_FAN_DEG = 30.0
SPAN_M = (50.0, 125.0)
ARC_M = (90.0, 100.0)
BANDS_M = (5.0, 7.0, 9.0, 11.0, 13.0, 16.0, 20.0, 34.0, 60.0)  # each holds a wavenumber of either line
HALF = 0.5  # coherence from which a map holds more of the sea than of anything else
LINES = {"look": "along the look, up and down the waves", "arc": "along arcs, across the waves"}
MASTS_M = (STUDY.height_m, 15.0)  # the higher one sees nearly all of it
ESTIMATORS = ("adaptive", "single_cell")


@dataclass(frozen=True)
class Transfer:
    """How a map reproduces the waves of the sea, by wavelength along a line; (band,)."""

    gain: Array
    coherence: Array  # squared

    def shortest(self) -> float:
        """Wavelength [m] from which on the coherence is a half or more."""
        poor = np.flatnonzero(self.coherence < HALF)
        if poor.size == 0:
            return float(BANDS_M[0])
        last = int(poor[-1])
        if last + 1 == self.coherence.size:
            return float("inf")
        return float(np.interp(HALF, self.coherence[last : last + 2], MIDDLES_M[last : last + 2]))


MIDDLES_M = np.sqrt(np.multiply(BANDS_M[:-1], BANDS_M[1:]))
Lines = tuple[Array, Array, float]  # map and sea (line, sample), m between samples


@cache
def transfers(mast_m: float, seeds: int) -> dict[tuple[str, str], Transfer]:
    """By estimator and line."""
    sums: dict[tuple[str, str], Array] = {}
    for seed in range(1, seeds + 1):
        keys = {"seed": seed, "radar.height_m": mast_m, "radar.noise": False, "radar.range_m": [15.0, 200.0]}
        scene = sr.load_scene("choppy_sea", {**keys, "tracing.tracer": "horizon"})
        simulator = Simulator(scene)
        echoes = simulator.turn(0).echoes
        for estimator in ESTIMATORS:
            settings = scene.resolved_retrieval.model_copy(update={"estimator": estimator})
            polar = sr.retrieve(echoes, settings)["polar"].to_dataset().isel(turn=0)
            for line, lines in lines_of(polar, surface(simulator, polar)).items():
                sums[estimator, line] = sums.get((estimator, line), 0.0) + spectra(lines)
    return {key: Transfer(cross / sea, cross**2 / (sea * own)) for key, (sea, cross, own) in sums.items()}


def surface(simulator: Simulator, polar: xr.Dataset) -> Array:
    """Elevation (look, gate) of the true sea, at points, at the position and time of each cell."""
    out = np.sqrt(np.maximum(polar["range"].values ** 2 - simulator.scene.radar.height_m**2, 0.0))
    east, north = (axis[:, None] * out for axis in unit_from_azimuth(polar["azimuth"].values))
    times = polar["time"].values
    times = np.broadcast_to(times if times.ndim == 2 else times[:, None], east.shape)
    times = np.where(np.isfinite(times), times, np.nanmean(times, axis=1, keepdims=True))
    return simulator.sea.elevation(east.ravel(), north.ravel(), times.ravel()).reshape(east.shape)


def lines_of(polar: xr.Dataset, sea: Array) -> dict[str, Lines]:
    """Looks along the waves, and arcs across them."""
    ranges, azimuth = polar["range"].values, polar["azimuth"].values
    height = np.nan_to_num(polar["height"].values.astype(np.float64))
    off = wrap_degrees(azimuth - WAVES_FROM)
    along = (np.abs(off) < HALF_FAN_DEG) | (np.abs(off) > 180.0 - HALF_FAN_DEG)
    gates = (ranges >= SPAN_M[0]) & (ranges <= SPAN_M[1])
    gate = (ranges >= ARC_M[0]) & (ranges <= ARC_M[1])
    arcs = []
    for middle in (-90.0, 90.0):
        offset = wrap_degrees(off - middle)
        looks = np.argsort(offset)
        looks = looks[np.abs(offset[looks]) < HALF_FAN_DEG]
        arcs.append((height[np.ix_(looks, gate)].T, sea[np.ix_(looks, gate)].T))
    width = float(np.radians(CELL_DEG) * np.mean(ARC_M))
    both = [np.concatenate(each) for each in zip(*arcs, strict=True)]
    step = float(ranges[1] - ranges[0])
    return {"look": (height[along][:, gates], sea[along][:, gates], step), "arc": (both[0], both[1], width)}


def spectra(lines: Lines) -> Array:
    """(sea, |cross|, map; band), summed over lines."""
    height, sea, step = lines
    window = np.hanning(height.shape[1] + 2)[1:-1]
    map_waves, sea_waves = (
        np.fft.rfft((each - each.mean(axis=1, keepdims=True)) * window, axis=1) for each in (height, sea)
    )
    products = (
        np.abs(sea_waves) ** 2 + 0j,
        map_waves * sea_waves.conj(),
        np.abs(map_waves) ** 2 + 0j,
    )
    with np.errstate(divide="ignore"):
        length = 1.0 / np.fft.rfftfreq(height.shape[1], step)
    bands = [(length >= short) & (length < long) for short, long in pairwise(BANDS_M)]
    return np.array([[np.abs(each[:, band].sum()) for band in bands] for each in products])


def sampling(seeds: int = 2) -> Claim:
    tables = {mast: transfers(mast, seeds) for mast in MASTS_M}
    study, nyquist = tables[MASTS_M[0]], 2.0 * GRID_M
    figures = [
        (f"cells of {GRID_M:g} m, Nyquist", f"{nyquist:g} m; {CELL_DEG:g}° is {GRID_M:g} m at {EVEN_M:.0f} m alone"),
        *(
            (
                f"mast {mast:g} m, {estimator}, {LINES[line]}",
                f"coherence of a half or more from waves of {each.shortest():.1f} m on; at {MIDDLES_M[0]:.1f} m "
                f"it is {each.coherence[0]:.2f}, and the gain {each.gain[0]:.2f}",
            )
            for mast, table in tables.items()
            for (estimator, line), each in table.items()
        ),
    ]
    held = max(study["adaptive", line].shortest() for line in LINES)
    assumption = (
        f"sampling alone is meant, and no farther than {EVEN_M:.0f} m: what the map then holds of the sea begins at "
        f"waves of {held:.0f} m"
    )
    verdict = ONLY_IF if nyquist <= LONGEST_M else NOT
    return Claim("9", f"Nyquist sampling of waves longer than {LONGEST_M:g} m", verdict, assumption, figures)


@style.styled
def draw_transfer(seeds: int = 2) -> Figure:
    figure = style.new_figure(3.3)
    names = ("gain", "coherence, squared")
    for number, name in enumerate(names):
        axes = style.place(figure, 0.55 + 3.6 * number, 0.35, 2.95, 2.1)
        style.graph(axes, "wavelength along the line, m", "", f"{'ab'[number]}) {name}")
        for mast, dash in zip(MASTS_M, ("-", "--"), strict=True):
            for (estimator, line), each in transfers(mast, seeds).items():
                if estimator == "single_cell" and mast != MASTS_M[0]:
                    continue
                ink = {"look": style.VERMILION, "arc": style.BLUE}[line]
                values = (each.gain, each.coherence)[number]
                mark = {"adaptive": "o", "single_cell": "x"}[estimator]
                thin = 1.2 if estimator == "adaptive" else 0.5
                label = f"{line}, mast {mast:g} m, {estimator}"
                axes.plot(MIDDLES_M, values, mark + dash, color=ink, markersize=3, linewidth=thin, label=label)
        axes.axvline(LONGEST_M, color=style.GREY, linewidth=0.8, linestyle=":")
        axes.set_xscale("log")
        axes.set_xticks([6, 8, 10, 15, 20, 30, 40], ["6", "8", "10", "15", "20", "30", "40"])
        axes.minorticks_off()
        axes.set_ylim(0.0, 1.05)
        if number == 0:
            ideal = np.sinc(GRID_M / MIDDLES_M)
            axes.plot(MIDDLES_M, ideal, color=style.BLACK, linewidth=0.8, label=f"mean over {GRID_M:g} m")
            figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=4, fontsize=6, handlelength=3.0)
        else:
            axes.axhline(HALF, color=style.GREY, linewidth=0.8, linestyle="--")
    return figure


def main() -> None:
    arguments = options(__doc__, seeds=2, out=Path)
    sampling(arguments.seeds).show()
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        (arguments.out / "claim_sampling.png").write_bytes(style.png(draw_transfer(arguments.seeds)))


if __name__ == "__main__":
    main()
