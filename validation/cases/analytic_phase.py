"""Closed forms of the phase: how speckle spreads it, and what that does to a height."""

from __future__ import annotations

from itertools import product
from typing import Literal

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT, wrap_phase
from seamap_rt.report import style
from seamap_rt.settings import RadarSettings, RetrievalSettings
from seamap_rt.simulation import Simulator

from .. import analytic
from ..report import Case, Check, Outcome
from ..report.checks import relative, within

Array = NDArray[np.float64]
WAVELENGTH = SPEED_OF_LIGHT / 10e9
INKS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE)

# ------------------------------------------------------------------------------------------------- phase of speckle

COHERENCES, LOOKS = (0.5, 0.8, 0.95, 0.99), (1, 2, 5, 10, 50)
SEA = analytic.TiltedSea(0.002, -0.001)


def lee_spread(full: bool) -> Outcome:
    """Phases of a set coherence and number of looks through the retrieval, and of the simulator's own single pulses."""
    checks, measured, example = [], {}, np.zeros(0)
    exact = _phases(None, 1)
    for looks in LOOKS:
        for coherence, error in zip(COHERENCES, _phase_errors(exact, looks), strict=True):
            square = float(np.mean(error**2))
            lee = float(analytic.phase_std_lee94(coherence, looks))
            tolerance = 2.0 * float(np.sqrt(np.var(error**2) / error.size)) / square
            what = f"phase spread, coherence {coherence:g}, {looks} look{'s' if looks > 1 else ''}"
            checks.append(relative(what, np.sqrt(square), lee, tolerance, "rad"))
            measured[coherence, looks] = np.sqrt(square)
            example = error if (coherence, looks) == (0.8, 5) else example
    checks.append(_simulated_phases())
    caption = (
        "Left: standard deviation of the retrieved phase by looks, and that of Lee et al. (1994). Right: how phases of "
        "coherence 0.8 and 5 looks are distributed, and Lee's density."
    )
    return Outcome(tuple(checks), _draw_lee(measured, example), caption)


def _phase_errors(exact: Array, looks: int) -> list[Array]:
    """Of each coherence the phase errors [rad] of 20 looks by 100 gates."""
    groups = np.array_split(np.arange(exact.shape[1]), len(COHERENCES))
    error = wrap_phase(_phases(np.repeat(COHERENCES, [group.size for group in groups]), looks) - exact)
    return [error[:, group].ravel() for group in groups]


def _phases(coherence: Array | None, looks: int) -> Array:
    """Retrieved phases (look, gate) [rad] of a gently tilted plane."""
    radar = RadarSettings(sector_deg=(0.0, 36.0), range_m=(20.0, 219.5), range_sampling_m=0.5)
    alone = RetrievalSettings(estimator="single_cell", cell_range_m=0.5, paths="one_way", ground_m=500.0)
    echoes = analytic.echoes(SEA, radar, coherence=coherence, looks=looks, seed=looks)
    return sr.retrieve(echoes, alone)["polar"].to_dataset()["phase"].values[0].astype(np.float64)


def _simulated_phases() -> Check:
    """Single pulses of the simulator's own flat sea: their coherence follows from the expected echo and the noise."""
    radar = {"radar.range_m": [60.0, 300.0], "radar.transmit": "single", "tracing.tracer": "horizon"}
    scene = sr.load_scene("flat", {**radar, "scattering.nrcs": "constant"})
    echoes, expected = Simulator(scene).turn(0).echoes, sr.expected(scene)
    volts, noise = echoes["voltage"].values[:, :, ::4].astype(np.complex128), float(echoes.attrs["noise_power_w"])
    covariance = expected["covariance"].values[:, ::4].mean(axis=0)  # gates 6 m apart
    lower, upper = (expected["power"].values[0, each, :, ::4].mean(axis=0) + noise for each in (0, 1))
    coherence = np.abs(covariance) / np.sqrt(lower * upper)
    error = np.angle(volts[:, 0] * volts[:, 1].conj() * covariance.conj())
    share = (error / analytic.phase_std_lee94(coherence, 1)) ** 2
    blocks = share.mean(axis=1).reshape(50, -1).mean(axis=1)  # 7.2° each: beams apart
    tolerance = 4.0 * float(blocks.std(ddof=1) / np.sqrt(50))
    words = f"coherence {coherence.max():.3f} (60 m) to {coherence.min():.2f} (300 m)"
    return within(f"simulated pulses, {words}: phase variance over Lee's", float(blocks.mean()), 1.0, tolerance)


@style.styled
def _draw_lee(measured: dict[tuple[float, int], float], example: Array) -> Figure:
    figure = style.new_figure(2.7)
    left = style.place(figure, 0.55, 0.3, 2.9, 1.95)
    many = np.geomspace(1.0, 60.0, 60)
    for coherence, ink in zip(COHERENCES, INKS, strict=False):
        left.loglog(many, analytic.phase_std_lee94(coherence, many), color=ink, lw=0.9)
        left.loglog(
            LOOKS, [measured[coherence, looks] for looks in LOOKS], ".", color=ink, ms=5, label=f"{coherence:g}"
        )
    left.legend(title="coherence", title_fontsize=style.FONT - 0.5, loc="lower left")
    style.graph(left, "looks", "phase spread [rad]", "Retrieved phases and Lee et al.")
    right = style.place(figure, 4.1, 0.3, 2.9, 1.95)
    edges = np.linspace(-np.pi, np.pi, 50)
    count, _ = np.histogram(example, edges)
    middle = 0.5 * (edges[1:] + edges[:-1])
    right.plot(middle, count / (example.size * np.diff(edges)), ".", color=style.BLUE, ms=4)
    fine = np.linspace(-1.5, 1.5, 400)
    right.plot(fine, analytic.phase_pdf_lee94(fine, 0.8, 5), color=style.VERMILION, lw=0.9)
    right.set_xlim(-1.5, 1.5)
    style.graph(right, "phase error [rad]", "density [1/rad]", "Coherence 0.8, 5 looks")
    return figure


# ------------------------------------------------------------------------------------------ height error's scaling

BASELINES, COHERENCE = (0.1, 0.2, 0.4, 0.8), 0.99


def error_scaling(full: bool) -> Outcome:
    """Speckle of one look and set coherence on a flat sea: heights scatter by λR/(2πpB) times Lee's phase."""
    lee = float(analytic.phase_std_lee94(COHERENCE, 1))
    checks: list[Check] = []
    drawn: dict[int, list[tuple[Array, Array]]] = {1: [], 2: []}
    for paths, baseline in product((1, 2), BASELINES):
        ranges, error = _scatter(paths, baseline, 2 if full else 1)
        phase = error * 2.0 * np.pi * paths * baseline / (WAVELENGTH * ranges)
        square = float(np.nanmean(phase**2))
        sampling = 2.0 * float(np.sqrt(np.nanvar(phase**2) / phase.size)) / square  # four errors of half of it
        what = f"rms height error over λR/(2πpB), p = {paths}, B = {baseline:g} m"
        checks.append(relative(what, np.sqrt(square), lee, sampling + (0.05 if paths == 2 else 0.0), "rad"))
        blocks = error.reshape(error.shape[0], -1, 20)
        drawn[paths].append((ranges.reshape(-1, 20).mean(axis=1), np.sqrt(np.nanmean(blocks**2, axis=(0, 2)))))
    for paths in (1, 2):
        means = [np.sqrt(np.mean(rms**2)) for _, rms in drawn[paths]]
        slope = float(np.polyfit(np.log(BASELINES), np.log(means), 1)[0])
        checks.append(within(f"power of B in the error, p = {paths}", slope, -1.0, 0.06))
        scaled = [rms * baseline for (_, rms), baseline in zip(drawn[paths], BASELINES, strict=True)]
        bins = np.log(np.mean(scaled, axis=0))
        slope = float(np.polyfit(np.log(drawn[paths][0][0]), bins, 1)[0])
        checks.append(within(f"power of R in the error, p = {paths}", slope, 1.0, 0.1))
    caption = (
        f"Rms height error of a flat sea, speckle of one look with a coherence of {COHERENCE}, against range; lines "
        "are λR/(2πpB) times the standard deviation of Lee et al. (1994)."
    )
    return Outcome(tuple(checks), _draw_scaling(drawn, lee), caption)


def _scatter(paths: int, baseline: float, seeds: int) -> tuple[Array, Array]:
    """Ranges (gate,) and height errors (look, gate): one pulse a look serves one way, both ways need pairs."""
    mode: dict[str, object] = {"transmit": "single", "prf_hz": 200.0, "sector_deg": (0.0, 360.0)}
    if paths == 2:
        mode = {"transmit": "switched", "interferogram": "alternating_pulse", "sector_deg": (0.0, 72.0)}
    radar = RadarSettings.model_validate(
        {"baseline_m": baseline, "range_m": (40.0, 359.5), "range_sampling_m": 1.0, **mode}
    )
    choice: Literal["best", "one_way"] = "best" if paths == 2 else "one_way"
    alone = RetrievalSettings(
        estimator="single_cell", cell_range_m=1.0, paths=choice, ambiguity="fold", ground_m=1000.0
    )
    heights = []
    for seed in range(seeds):
        number = 10 * round(100.0 * baseline) + paths + 1000 * seed
        echoes = analytic.echoes(analytic.FlatSea(), radar, coherence=COHERENCE, looks=1, seed=number)
        heights.append(sr.retrieve(echoes, alone)["polar"].to_dataset()["height"].values[0, 1:-1])
    return np.arange(40.0, 360.0), np.concatenate(heights).astype(np.float64)


@style.styled
def _draw_scaling(drawn: dict[int, list[tuple[Array, Array]]], lee: float) -> Figure:
    figure = style.new_figure(2.7)
    for column, paths in enumerate((1, 2)):
        axes = style.place(figure, 0.55 + 3.55 * column, 0.35, 2.9, 1.9)
        for (ranges, rms), baseline, ink in zip(drawn[paths], BASELINES, INKS, strict=True):
            axes.loglog(ranges, WAVELENGTH * ranges / (2.0 * np.pi * paths * baseline) * lee, color=ink, lw=0.8)
            axes.loglog(ranges, rms, ".", color=ink, ms=4, label=f"{baseline:g} m")
        axes.set_xticks([50.0, 100.0, 200.0, 350.0], ["50", "100", "200", "350"])
        axes.xaxis.set_minor_formatter("")
        axes.set_xlim(45.0, 390.0)
        axes.set_ylim(0.03, 20.0)
        axes.legend(loc="upper left", title="baseline", title_fontsize=style.FONT - 0.5, ncols=2)
        title = "p = 1: one transmitter" if paths == 1 else "p = 2: each antenna hears itself"
        style.graph(axes, "range [m]", "rms height error [m]", title)
    return figure


CASES = [
    Case(
        name="lee_phase_spread",
        group="closed forms",
        title="Phases spread as Lee et al. (1994) have it",
        rationale="The error bar of each height rests on this law, and at few looks the Cramér–Rao bound is far off.",
        setup="Analytic echoes with speckle of coherence 0.5–0.99 and 1–50 looks through the retrieval, 2000 cells "
        "each; and single pulses of the simulator's flat sea with noise.",
        expectation="The standard deviation of the closed density, to four standard errors by the sample's own fourth "
        "moment; the simulator's to four standard errors over 50 blocks of a turn.",
        run=lee_spread,
    ),
    Case(
        name="height_error_scaling",
        group="closed forms",
        title="The height error is λR/(2πpB) times the phase error",
        rationale="This is why a baseline is long and why alternating pulses pay; a factor of two in p hides easily.",
        setup="A flat sea, drawn speckle of one look and coherence 0.99, baselines 0.1–0.8 m, one way and both ways.",
        expectation="Lee's standard deviation of one look, 0.263 rad, to four standard errors of the sample by its own "
        "fourth moment. Both ways: one pulse pair in fifty reaches into the dwell before, whose speckle is another; "
        "that may add 5 %.",
        run=error_scaling,
    ),
]
