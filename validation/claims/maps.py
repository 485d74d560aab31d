"""The design study's claims on its maps, each recomputed and judged: how often (6), how far (7), how early (8).

    python -m validation.claims.maps [--seeds 1] [--out DIR]

The maps are those of `choppy_sea`, whose waves are the 1.4 m of the study, lit by the tracer `horizon`.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.interferometry import retrieve_one
from seamap_rt.metrics import BIN_M, error_figures
from seamap_rt.physics.dispersion import angular_frequency, group_speed, wavenumber
from seamap_rt.radar.scan import turn_duration
from seamap_rt.report import style
from seamap_rt.simulation import Simulator
from seamap_rt.studies.trade_table import Criterion, Window

from ..options import options
from ..prediction.forecasts import Compared, joined, run, scene_of
from .radar import NOT, ONLY_IF, REPRODUCED, STUDY, Claim

Array = NDArray[np.float64]
HEIGHT_M, PERIOD_S = 1.4, 5.5  # H1/3 and peak period of the sea
ROTATIONS_RPM = (30.0, 60.0)
CRITERION = Criterion()  # of a bin of ranges that is usable
SEVERAL_M = 300.0  # the least that is several hundred metres
FEWEST = 0.02  # of all cells, for the error of a bin to be drawn
AHEAD_S = 10.0
FORECAST_SEED, FORECAST_TURNS = 801, 22  # of the seas that are forecast: five forecasts each
FORECAST_CORRELATION = 0.8  # of predictions from shadowed synthetic radar maps (Wijaya et al. 2015)
PERIODS_S = (4.0, 6.0, 8.0, 10.0)
INKS = (style.BLACK, style.BLUE, style.SKY, style.ORANGE, style.VERMILION)


@dataclass(frozen=True)
class Mount:
    """An antenna's mast, baseline and transmitter."""

    height_m: float
    baseline_m: float
    watts: float

    def __str__(self) -> str:
        return f"mast {self.height_m:g} m, B = {self.baseline_m:g} m, {self.watts:g} W"


MOUNTS = (
    Mount(STUDY.height_m, STUDY.baseline_m, STUDY.transmit_power_w),
    Mount(10.0, 0.2, 1.0),
    Mount(10.0, 0.4, 1.0),
    Mount(10.0, 0.4, 25.0),
    Mount(20.0, 0.4, 25.0),
)


@dataclass(frozen=True)
class Usable:
    """What maps hold by range; (bin,), each BIN_M wide."""

    middle: Array  # m
    error: Array  # m rms of heights, cells more than half visible that are answered
    share: Array  # of all cells, those
    visible: Array  # share of the sea

    def window(self) -> Window:
        return CRITERION.window(self.middle.tolist(), self.error.tolist(), self.share.tolist(), HEIGHT_M)


@cache
def usable(mount: Mount, seeds: int) -> Usable:
    """A turn of each seed, all cells of a bin together."""
    square = cells = total = visible = np.zeros(0)
    middle: Array = np.zeros(0)
    for seed in range(1, seeds + 1):
        scene = sr.load_scene(
            "choppy_sea",
            {
                "seed": seed,
                "tracing.tracer": "horizon",
                "radar.height_m": mount.height_m,
                "radar.baseline_m": mount.baseline_m,
                "radar.transmit_power_w": mount.watts,
            },
        )
        turn = Simulator(scene).turn(0)
        maps = sr.retrieve(turn.echoes)
        metrics, polar = error_figures(maps, turn.truth), maps["polar"].to_dataset()
        middle, number = np.array(metrics["range_m"]), np.array(metrics["cells"], dtype=float)
        rms = np.array(metrics["height_rmse_m"], dtype=float)  # None, without a cell, becomes nan
        gates = np.bincount((polar["range"].values // BIN_M).astype(int))
        squares = np.where(number > 0, number * rms**2, 0.0)
        sums = squares, number, polar.sizes["azimuth"] * gates[gates > 0], np.array(metrics["visible_fraction"]) / seeds
        old = (square, cells, total, visible) if square.size else (0.0, 0.0, 0.0, 0.0)
        square, cells, total, visible = (a + b for a, b in zip(old, sums, strict=True))
    with np.errstate(divide="ignore", invalid="ignore"):
        return Usable(middle, np.sqrt(square / cells), cells / total, visible)


# ------------------------------------------------------------------------------------------------- how often


def map_rate(turns: int = 1) -> Claim:
    """A turn is a map. Its processing time is recorded but not judged: it depends on the machine."""
    scene = sr.load_scene("choppy_sea", {"tracing.tracer": "horizon"})
    simulator, taken, ages = Simulator(scene), [], np.zeros(0)
    for number in range(turns):
        echoes = simulator.turn(number).echoes
        retrieve_one(echoes, scene.resolved_retrieval)  # what only a first turn does is no part of it
        start = time.perf_counter()
        maps = retrieve_one(echoes, scene.resolved_retrieval)
        taken.append(time.perf_counter() - start)
        ages = maps["polar"].to_dataset()["time"].values
    turn_s = [turn_duration(STUDY.model_copy(update={"rotation_rpm": rpm})) for rpm in ROTATIONS_RPM]
    spread, k = float(np.nanmax(ages) - np.nanmin(ages)), float(wavenumber(2.0 * np.pi / PERIOD_S))
    moved = float(angular_frequency(k)) / k * spread
    figures = [
        ("a turn, and so a map, at 30 and 60 rpm", " and ".join(f"{each:.2f} s" for each in turn_s)),
        ("a turn's retrieval on this machine", f"{np.median(taken):.2f} s of wall clock"),
        ("times of one map's cells at 60 rpm", f"{spread:.2f} s apart"),
        ("meanwhile waves of the peak run", f"{moved:.1f} m, {moved * k / (2.0 * np.pi):.0%} of their length"),
    ]
    good = max(turn_s) <= 2.0 and min(turn_s) >= 1.0
    assumption = "a map is a turn, and its cells are of different times: the maps on the ground say which"
    return Claim("6", "a map every 1–2 s", REPRODUCED if good else NOT, assumption, figures)


# --------------------------------------------------------------------------------------------------- how far


def useful_heights(seeds: int = 1) -> Claim:
    """How far out heights are of use from the study's mast, and from higher ones with more baseline and power."""
    reach = {mount: usable(mount, seeds).window() for mount in MOUNTS}
    figures = [(str(mount), f"usable from {near:.0f} to {far:.0f} m") for mount, (near, far) in reach.items()]
    enough = [mount for mount in MOUNTS if reach[mount][1] >= SEVERAL_M]
    criterion = f"usable: {CRITERION}; several hundred metres: {SEVERAL_M:g} m"
    if MOUNTS[0] in enough:
        verdict, assumption = REPRODUCED, criterion
    elif enough:
        verdict, assumption = ONLY_IF, f"{enough[0]}; {criterion}"
    else:
        verdict, assumption = NOT, criterion
    return Claim(
        "7", f"useful heights to several hundred metres at H1/3 = {HEIGHT_M:g} m", verdict, assumption, figures
    )


@style.styled
def draw_usable(seeds: int = 1) -> Figure:
    figure = style.new_figure(3.2)
    left, right = (style.place(figure, at, 0.35, 2.95, 2.0) for at in (0.55, 4.1))
    style.graph(left, "range, m", "rms error of heights, m", "a) error, cells more than half visible")
    style.graph(right, "range, m", "share", "b) cells seen and answered; dotted: sea in sight")
    for mount, ink in zip(MOUNTS, INKS, strict=True):
        each = usable(mount, seeds)
        known = np.where(each.share >= FEWEST, each.error, np.nan)
        left.plot(each.middle, known, "o-", color=ink, markersize=2.5, label=str(mount))
        right.plot(each.middle, each.share, "o-", color=ink, markersize=2.5)
        right.plot(each.middle, each.visible, ":", color=ink, linewidth=0.9)
    for axes, limit in ((left, CRITERION.error_over_height * HEIGHT_M), (right, CRITERION.known_share)):
        axes.axhline(limit, color=style.GREY, linewidth=0.9, linestyle="--")
        axes.set_xlim(0.0, STUDY.range_m[1])
    left.set_ylim(0.0, 0.5)
    right.set_ylim(0.0, 1.05)
    figure.legend(*left.get_legend_handles_labels(), loc="lower center", ncols=3, fontsize=6.5)
    return figure


# ------------------------------------------------------------------------------------------------- how early


def run_in(period_s: float, seconds: float = AHEAD_S) -> float:
    """How far [m] the energy of waves of a period travels in that time, in deep water."""
    return seconds * float(group_speed(wavenumber(2.0 * np.pi / period_s)))


def predictability(seeds: int = 1) -> Claim:
    """How well the sea at the boat is forecast, and what bounds it: energy comes at the group speed (Naaijen et al.
    2014), from as far as the map reaches."""
    near, far = usable(MOUNTS[0], seeds).window()
    near = max(near, STUDY.range_m[0])
    figures = []
    for period in PERIODS_S:
        speed = run_in(period, 1.0)
        words = f"run {run_in(period):.0f} m in {AHEAD_S:g} s; from {near:.0f} to {far:.0f} m they are at the boat"
        figures.append((f"waves of {period:g} s", f"{words} after {near / speed:.0f} to {far / speed:.0f} s"))
    known = {seconds: forecast_correlation(seconds, seeds) for seconds in (AHEAD_S, 2.0 * AHEAD_S, 3.0 * AHEAD_S)}
    for seconds, value in known.items():
        low, high = forecast_band(seconds, seeds)
        words = f"correlation {value:.3f} [{low:.3f}, {high:.3f}], {seeds} seed{'s' if seeds > 1 else ''} of choppy_sea"
        figures.append((f"forecast {seconds:g} s ahead", words))
    assumption = (
        f"at the boat at rest, from ten turns' maps of a linear sea: forecast and sea correlate by "
        f"{known[AHEAD_S]:.3f} {AHEAD_S:g} s ahead, against {FORECAST_CORRELATION:g} of published forecasts from "
        f"simulated radars; group speed alone would leave {far / run_in(PERIODS_S[-1], 1.0):.0f} s to waves of "
        f"{PERIODS_S[-1]:g} s"
    )
    verdict = REPRODUCED if known[AHEAD_S] > FORECAST_CORRELATION else NOT
    return Claim("8", "about 10 s of wave predictability", verdict, assumption, figures)


@cache
def _forecasts(seeds: int) -> Compared:
    """What is forecast at the boat, on seas of their own."""
    scenes = (scene_of("choppy_sea", FORECAST_SEED + n, FORECAST_TURNS) for n in range(seeds))
    return joined([run(scene)[0]["boat"] for scene in scenes])


def forecast_correlation(seconds: float, seeds: int) -> float:
    """Of forecast and sea at the boat, two seconds to either side of a lead [s] together."""
    return _forecasts(seeds).figures(_about(seconds))["corr"]


def forecast_band(seconds: float, seeds: int, draws: int = 1000) -> tuple[float, float]:
    """95 % of that, as forecasts are drawn again; those of one sea hang together, so that it is the least."""
    compared, stream = _forecasts(seeds), np.random.default_rng(0)
    mean, truth = (np.stack([row[_about(seconds)] for row in rows]) for rows in (compared.mean, compared.truth))
    chosen = stream.integers(len(mean), size=(draws, len(mean)))
    drawn = [np.corrcoef(mean[each].ravel(), truth[each].ravel())[0, 1] for each in chosen]
    low, high = np.percentile(drawn, (2.5, 97.5))
    return float(low), float(high)


def _about(seconds: float) -> slice:
    """Two seconds to either side."""
    return slice(round(seconds) - 2, round(seconds) + 3)


@style.styled
def draw_predictability(seeds: int = 1) -> Figure:
    """Seconds after which the energy of waves seen from one place arrives, by period."""
    near, far = usable(MOUNTS[0], seeds).window()
    period = np.linspace(3.0, 12.0, 91)
    speed = np.array([run_in(each, 1.0) for each in period])
    figure = style.new_figure(2.9)
    axes = style.place(figure, 0.9, 0.35, 5.6, 2.0)
    style.graph(axes, "period, s", "seconds until it is at the boat", "Energy at the group speed, from the map's edges")
    inner = max(near, STUDY.range_m[0])
    axes.fill_between(period, inner / speed, far / speed, color=style.SKY, alpha=0.3, linewidth=0.0)
    names = (f"usable map, {inner:.0f}–{far:.0f} m", f"if it reached {SEVERAL_M:g} m", f"{AHEAD_S:g} s")
    axes.plot(period, far / speed, color=style.BLUE, label=names[0])
    axes.plot(period, SEVERAL_M / speed, "--", color=style.VERMILION, label=names[1])
    axes.axhline(AHEAD_S, color=style.GREY, linewidth=0.9, linestyle=":", label=names[2])
    axes.set_xlim(period[0], period[-1])
    axes.set_ylim(0.0, 80.0)
    axes.legend(loc="upper right")
    return figure


def main() -> None:
    arguments = options(__doc__, seeds=1, out=Path)
    for claim in (map_rate(), useful_heights(arguments.seeds), predictability(arguments.seeds)):
        claim.show()
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        for name, draw in (("claim_heights", draw_usable), ("claim_forecast", draw_predictability)):
            (arguments.out / f"{name}.png").write_bytes(style.png(draw(arguments.seeds)))


if __name__ == "__main__":
    main()
