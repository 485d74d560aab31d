"""Closed forms of light and shadow: a sinusoid exactly, a random sea by Smith's function."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.mesh.surface import MovingSurface, mesh_turn
from seamap_rt.report import style
from seamap_rt.scene import Scene
from seamap_rt.tracing import Illumination, tracer

from .. import analytic
from ..report import Case, Check, Outcome
from ..report.checks import at_most, recorded

Array = NDArray[np.float64]
INKS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE)


def traced(scene: Scene, surface: MovingSurface, name: str) -> Illumination:
    """Facets of the surface, lit by the lower antenna and the upper one; without scattering."""
    mesh = mesh_turn(surface, scene.radar, scene.meshing, 0)
    return tracer(name, scene.radar, scene.scattering)(mesh)


def light(facets: Illumination) -> NDArray[np.bool_]:
    return facets.lit


# ------------------------------------------------------------------------------------------------------- sinusoid

WAVES_M, LOOKS_DEG = (20.0, 40.0), (90.0, 270.0)


def sinusoid_shadows(full: bool) -> Outcome:
    """A sinusoid's visible share, wave by wave and over the whole window, by the horizon and by rays."""
    checks, curves = [], {}
    for name in ("horizon", "facets"):
        try:
            each, whole = zip(*(_compared(name, length, look) for length in WAVES_M for look in LOOKS_DEG), strict=True)
        except sr.NoBackendError as error:
            checks.append(
                Check(f"{name}: traced", f"not on this machine: {str(error).splitlines()[0]}", "traced", False)
            )
            continue
        worst = max(float(np.max(np.abs(computed - exact))) for _, computed, exact in each)
        checks.append(at_most(f"{name}: visible share of one wavelength, worst of all", worst, 0.01))
        checks.append(at_most(f"{name}: visible share of 40–400 m, mean of four looks, worst", max(whole), 0.005))
        curves[name] = dict(zip([(length, look) for length in WAVES_M for look in LOOKS_DEG], each, strict=True))
    caption = (
        "Visible share of each wavelength of sinusoids a thirtieth as high as long, from 5 m, seen down the waves. "
        "Lines: crest by crest in closed form; dots: traced on facets of 0.2 m by the horizon, crosses by rays."
    )
    return Outcome(tuple(checks), _draw_sinusoid(curves), caption)


def _compared(name: str, length: float, look: float) -> tuple[tuple[Array, Array, Array], float]:
    """Bins with the lower antenna's shares in them, traced and exact; and the whole window's worst error."""
    scene = sr.load_scene(
        "sinusoid",
        {
            "sea.waves.0.wavelength_m": length,
            "sea.waves.0.height_m": length / 30.0,
            "radar.sector_deg": [look, look + 2.0],
            "tracing.facet_m": 0.2,
        },
    )
    facets = traced(scene, sr.sea.realize(scene.sea, 1), name)
    bins = np.arange(40.0, 400.1, length)
    column = -facets.grid.first
    computed, exact = _shares(scene, facets, 0, column, bins)
    window = np.array([40.0, 400.0])
    off = [
        abs(float(np.mean([np.subtract(*_shares(scene, facets, antenna, column + n, window)) for n in range(4)])))
        for antenna in (0, 1)
    ]
    return (bins, computed, exact), max(off)


def _shares(scene: Scene, facets: Illumination, antenna: int, column: int, edges: Array) -> tuple[Array, Array]:
    """Visible share of each range bin, traced and exact, at the column's own azimuth and time."""
    (wave,) = scene.sea.waves
    assert wave.spectrum == "sinusoid"
    k = 2.0 * np.pi / wave.wavelength_m
    downwave = np.cos(np.radians(facets.grid.column_azimuth[column] - 90.0))  # the waves run east
    intervals, _ = analytic.sinusoid_visible_intervals(
        wave.height_m,
        wave.wavelength_m / abs(downwave),
        scene.radar.height_m + (antenna - 0.5) * scene.radar.baseline_m,
        edges[0],
        edges[-1],
        phase=np.radians(wave.phase_deg) - np.sqrt(9.81 * k) * facets.grid.column_time[column],
        direction=1 if downwave > 0.0 else -1,
    )
    length = facets.horizontal_area / facets.distance  # along the look: the closed form knows no width
    number = np.digitize(facets.distance, edges) - 1
    held = (number >= 0) & (number < edges.size - 1)
    lit = np.bincount(number[held], (length * light(facets)[antenna, column])[held], edges.size - 1)
    whole = np.bincount(number[held], length[held], edges.size - 1)
    return lit / whole, analytic.visible_share(intervals, edges)


@style.styled
def _draw_sinusoid(curves: dict[str, dict[tuple[float, float], tuple[Array, Array, Array]]]) -> Figure:
    figure = style.new_figure(2.7)
    axes = style.place(figure, 0.55, 0.3, 5.0, 1.95)
    for name, curve in curves.items():
        mark, words = (".", "by the horizon") if name == "horizon" else ("x", "by rays")
        for length, ink in zip(WAVES_M, INKS, strict=False):
            bins, share, exact = curve[length, LOOKS_DEG[0]]
            middle = 0.5 * (bins[1:] + bins[:-1])
            axes.plot(middle, exact, color=ink, lw=0.8, label=f"{length:g} m long" if mark == "." else None)
            axes.plot(middle, share, mark, color=ink, ms=4, mew=0.7, label=words if length == 20.0 else None)
    axes.legend(bbox_to_anchor=(1.02, 1.0), loc="upper left")
    style.graph(axes, "range [m]", "visible share", "Sinusoid, H = λ/30, antenna at 4.9 m")
    return figure


# ---------------------------------------------------------------------------------------------------------- Smith

SECTORS_DEG = {"along the waves": (0.0, 20.0), "at 45°": (35.0, 55.0), "across them": (70.0, 90.0)}
RANGE_BINS_M = np.arange(40.0, 241.0, 20.0)


@dataclass(frozen=True)
class RangeBin:
    """What the seas show in one range bin of one sector."""

    share: float
    error: float  # standard error of it over the seas
    v: float  # tan ψ/(√2 σ)

    @property
    def smith_over(self) -> float:
        return float(analytic.shadowing_smith67(self.v)) / self.share - 1.0

    @property
    def wagner_over(self) -> float:
        return float(analytic.shadowing_wagner67(self.v)) / self.share - 1.0


def smith(full: bool) -> Outcome:
    """A short broad-banded sea, many waves to each range bin: the visible share beside those of Smith and Wagner."""
    seas = [_seen(seed) for seed in range(1, 13 if full else 5)]
    range_bins = {
        name: [_range_bin([sea[name][n] for sea in seas]) for n in range(RANGE_BINS_M.size - 1)] for name in SECTORS_DEG
    }
    checks: list[Check] = []
    for name, in_sector in range_bins.items():
        grazing = [range_bin for range_bin in in_sector if range_bin.v < 0.6]
        least = min(grazing, key=lambda range_bin: range_bin.smith_over + 3.0 * range_bin.error / range_bin.share)
        most = max(grazing, key=lambda range_bin: range_bin.smith_over - 3.0 * range_bin.error / range_bin.share)
        for range_bin, limit, side in ((least, 3.0, 1.0), (most, 16.0, -1.0)):
            word, ask = ("least", "at least") if side > 0.0 else ("most", "at most")
            over, slack = 100.0 * range_bin.smith_over, 100.0 * range_bin.error / range_bin.share
            what = f"{name}: Smith over what is seen, {word} of {len(grazing)} range bins (v = {range_bin.v:.2f})"
            required = f"{ask} {limit:g} %, to three standard errors"
            passed = bool(side * (over - limit) > -3.0 * slack)
            checks.append(Check(what, f"{over:.1f} ± {slack:.1f} %", required, passed))
        wagner = [100.0 * range_bin.wagner_over for range_bin in grazing]
        checks.append(recorded(f"{name}: Wagner over what is seen", f"{min(wagner):.0f} to {max(wagner):.0f} %"))
    caption = (
        "Share of the sea that the lower antenna sees, against v = tan ψ/(√2 σ) with σ the mesh's rms slope along the "
        f"look there; means over {len(seas)} seas with two standard errors. Smith and Wagner take heights and "
        "slopes along a ray for independent."
    )
    return Outcome(tuple(checks), _draw_smith(range_bins), caption)


def _seen(seed: int) -> dict[str, list[tuple[float, float, float]]]:
    """Visible share, mean square slope and mean distance of each sector's range bins."""
    waves = {"peak_period_s": 3.0, "significant_wave_height_m": 0.42}  # as steep as choppy_sea, waves 14 m long
    scene = sr.load_scene(
        "choppy_sea",
        {
            **{f"sea.waves.0.{key}": value for key, value in waves.items()},
            "sea.resolution_m": 0.4,
            "sea.extent_m": 560.0,
            "radar.range_m": [15.0, 250.0],
        },
    )
    facets = traced(scene, sr.sea.realize(scene.sea, seed), "horizon")
    off = np.abs((facets.grid.column_azimuth - 270.0 + 90.0) % 180.0 - 90.0)
    range_bin = np.digitize(facets.distance, RANGE_BINS_M) - 1
    area = facets.horizontal_area
    visible = {}
    for name, (low, high) in SECTORS_DEG.items():
        chosen = (off >= low) & (off < high)
        lit, square = light(facets)[0, chosen].mean(axis=0), np.square(facets.slope_look[chosen]).mean(axis=0)
        masks = [range_bin == n for n in range(RANGE_BINS_M.size - 1)]
        visible[name] = [
            tuple(float(np.average(each[mask], weights=area[mask])) for each in (lit, square, facets.distance))
            for mask in masks
        ]
    return visible


def _range_bin(seas: list[tuple[float, float, float]]) -> RangeBin:
    shares, squares, distances = np.array(seas).T
    lower = 5.0 - 0.1
    v = lower / distances.mean() / np.sqrt(2.0 * squares.mean())
    return RangeBin(float(shares.mean()), float(shares.std(ddof=1) / np.sqrt(shares.size)), float(v))


@style.styled
def _draw_smith(range_bins: dict[str, list[RangeBin]]) -> Figure:
    figure = style.new_figure(2.9)
    axes = style.place(figure, 0.55, 0.3, 4.6, 2.15)
    v = np.linspace(0.1, 1.8, 200)
    axes.plot(v, analytic.shadowing_smith67(v), color=style.BLACK, lw=0.9, label="Smith 1967")
    axes.plot(v, analytic.shadowing_wagner67(v), "--", color=style.BLACK, lw=0.9, label="Wagner 1967")
    for (name, in_sector), ink in zip(range_bins.items(), INKS, strict=False):
        at, share, error = ([getattr(range_bin, field) for range_bin in in_sector] for field in ("v", "share", "error"))
        axes.errorbar(at, share, 2.0 * np.array(error), fmt=".", color=ink, ms=4, lw=0.8, label=name)
    axes.legend(bbox_to_anchor=(1.02, 1.0), loc="upper left")
    style.graph(axes, "v = tan ψ/(√2 σ)", "visible share", "Broad-banded sea from 4.9 m")
    return figure


CASES = [
    Case(
        name="sinusoid_shadows",
        group="closed forms",
        title="Shadows of a sinusoid",
        rationale="Shadowing decides what such a radar can see at all; here its answer is known to any digit.",
        setup="Waves 20 and 40 m long, a thirtieth as high, from a 5 m mast down and up the waves, 40–400 m, facets of "
        "0.2 m, by the horizon method and by rays.",
        expectation="The tangent construction crest by crest. A facet is lit or dark as a whole: a shadow's edge errs "
        "by up to 0.05 m, four edges and ends in a bin of 20 m by 0.01; over the whole window errors nearly cancel.",
        run=sinusoid_shadows,
    ),
    Case(
        name="smith_overestimates",
        group="closed forms",
        title="Smith's function overestimates what is seen by 3–16 %",
        rationale="Link budgets take the visible share from Smith; exact ray tracing is known to see less.",
        setup="Linear JONSWAP seas of 3 s and 0.42 m, as steep as choppy_sea, resolved to 0.8 m waves, many waves to "
        "each range bin of 20 m; slopes are those that the mesh carries along the look.",
        expectation="Smith over rays by 3 to 16 % where v < 0.6, as exact ray Monte Carlo has it, less and more three "
        "standard errors over the seas. Wagner, who is known to be off by 20–45 %, is for the record.",
        run=smith,
    ),
]
