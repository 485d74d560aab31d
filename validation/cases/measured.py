"""Accuracy compared with published figures, and the three tracers compared with each other."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.metrics import HEADLINE_M, error_figures
from seamap_rt.report import style
from seamap_rt.simulation import Simulator

from ..hard_cases.case import light
from ..hard_cases.light import beside_an_edge
from ..report import Case, Outcome
from ..report.checks import at_least, at_most, recorded, within
from ..sea.sea_state import SEAS, Sea, scene_of, true_height

Array = NDArray[np.float64]
WIJAYA, OVERLOOKING_M = 0.90, 7.0  # correlation, and the mast [m] of 5 Hs for which it was published
MAST_M = 5.0
MOST_DIFFER = 0.02  # percent
WIRE_CORRELATION, WIRE_SLOPE, WIRE_BIAS_M = 0.92, 0.97, 0.045
BULK_RMSE_M = 0.24
TRACERS = ("facets", "horizon", "paths")
INKS = dict(zip(TRACERS, (style.BLUE, style.VERMILION, style.BLACK), strict=True))


# -------------------------------------------------------------------------------------------- phase by phase


def phase_resolved(full: bool) -> Outcome:
    pairs = [_map_and_sea(seed) for seed in range(1, 5 if full else 2)]
    height, sea, visible = (np.concatenate([pair[number] for pair in pairs]) for number in range(3))
    known = np.isfinite(height)
    seen = known & (visible > 0.5)
    checks = (
        at_least("correlation, cells more than half visible", _correlation(height[seen], sea[seen]), WIJAYA),
        at_least("correlation, all cells with a height", _correlation(height[known], sea[known]), WIJAYA),
        recorded(
            "correlation, cells without a height as mean level", f"{_correlation(np.nan_to_num(height), sea):.3f}"
        ),
        recorded("cells with a height", f"{known.mean():.0%}, {visible.mean():.0%} of the sea in sight"),
    )
    return Outcome(
        checks, draw_pairs(height[known], sea[known], seen[known]), "Every cell with a height, 50–200 m; dark: many."
    )


def _map_and_sea(seed: int) -> tuple[Array, Array, Array]:
    """Heights of map and sea, and visible share; (cell,) of 50–200 m."""
    keys = {"seed": seed, "radar.height_m": OVERLOOKING_M, "tracing.tracer": "horizon"}
    scene = sr.load_scene("choppy_sea", keys)
    turn = Simulator(scene).turn(0)
    got, true = (each["polar"].to_dataset() for each in (sr.retrieve(turn.echoes), turn.truth))
    inside = (got["range"].values >= HEADLINE_M[0]) & (got["range"].values <= HEADLINE_M[1])
    fields = got["height"], true["height"], true["visible_fraction"]
    height, sea, visible = (field.values[..., inside].astype(np.float64).ravel() for field in fields)
    return height, sea, visible


def _correlation(one: Array, other: Array) -> float:
    return float(np.corrcoef(one, other)[0, 1])


@style.styled
def draw_pairs(height: Array, sea: Array, seen: NDArray[np.bool_]) -> Figure:
    figure = style.new_figure(3.3)
    for number, (chosen, title) in enumerate(((seen, "more than half visible"), (~seen, "less visible"))):
        axes = style.place(figure, 0.7 + 3.4 * number, 0.35, 2.4, 2.4)
        style.graph(
            axes, "true mean height of the cell, m", "map, m" if number == 0 else "", f"{'ab'[number]}) {title}"
        )
        axes.hexbin(
            sea[chosen],
            height[chosen],
            gridsize=50,
            extent=(-1.5, 1.5, -1.5, 1.5),
            bins="log",
            cmap=style.COUNT_COLOURS,
            linewidths=0.0,
        )
        axes.plot([-1.5, 1.5], [-1.5, 1.5], color=style.GREY, linewidth=0.7)
        axes.set_aspect("equal")
        axes.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5))
    return figure


# ------------------------------------------------------------------------------------------------- sea by sea


def sea_states(full: bool) -> Outcome:
    rows = np.array([_heights(sea, seed) for seed in range(1, 5 if full else 2) for sea in SEAS])
    true, retrieved, stated, bias = rows.T
    slope, level = np.polyfit(true, retrieved, 1)
    through = float(np.sum(true * retrieved) / np.sum(true**2))
    off = 1.0 - WIRE_SLOPE
    worst = float(np.abs(bias).max())
    checks = (
        at_least("correlation of Hs, map against sea", _correlation(true, retrieved), WIRE_CORRELATION),
        within("slope of Hs, line through 0", through, 1.0, off),
        recorded("slope of Hs, line with an offset", f"{slope:.3f}, {level:+.3f} m (published: {WIRE_SLOPE:g})"),
        at_most("worst bias of heights of a sea", 1e3 * worst, 1e3 * WIRE_BIAS_M, "mm"),
        at_most("rms error of Hs", float(np.sqrt(np.mean((retrieved - true) ** 2))), BULK_RMSE_M, "m"),
    )
    return Outcome(
        checks,
        draw_states(true, retrieved, stated),
        "Significant height by one turn's map; bars: ± 1 of the standard errors that the map states.",
    )


def _heights(sea: Sea, seed: int) -> tuple[float, float, float, float]:
    """Hs [m] of the sea and by the map, the standard error that it states, and the bias of its heights in 50–200 m."""
    simulator = Simulator(scene_of(sea, seed, MAST_M))
    turn = simulator.turn(0)
    maps = sr.retrieve(turn.echoes)
    state = sr.sea_state(maps).isel(turn=0)
    ends = float(state["range_first"]), float(state["range_last"])
    true = true_height(simulator, turn.truth["polar"].to_dataset().isel(turn=0), *ends)
    bias = error_figures(maps, turn.truth)["overall"]["height_bias_m"]
    return true, float(state["significant_wave_height"]), float(state["significant_wave_height_measurement"]), bias


@style.styled
def draw_states(true: Array, retrieved: Array, stated: Array) -> Figure:
    figure = style.new_figure(3.2)
    left, right = (style.place(figure, at, 0.35, 2.6, 2.3) for at in (0.7, 4.2))
    style.graph(left, "Hs of the sea, m", "Hs by the map, m", "a) significant wave height")
    style.graph(right, "Hs of the sea, m", "error, m", "b) its error")
    most = 1.1 * float(true.max())
    left.plot([0.0, most], [0.0, most], color=style.GREY, linewidth=0.7)
    left.errorbar(true, retrieved, stated, fmt="o", color=style.BLUE, markersize=3, linewidth=0.8)
    right.errorbar(true, retrieved - true, stated, fmt="o", color=style.BLUE, markersize=3, linewidth=0.8)
    for level in (-BULK_RMSE_M, BULK_RMSE_M):
        right.axhline(level, color=style.GREY, linewidth=0.8, linestyle="--")
    right.annotate(
        "rms of bulk Hs, Carrasco 2017",
        (0.03, BULK_RMSE_M),
        (0, 3),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        fontsize=6,
        color=style.GREY,
    )
    right.set_ylim(-0.35, 0.35)
    for axes in (left, right):
        axes.set_xlim(0.0, most)
    left.set_ylim(0.0, most)
    return figure


# ---------------------------------------------------------------------------------------------------- tracers


def three_tracers(full: bool) -> Outcome:
    scene = sr.load_scene("choppy_sea", {"seed": 1, "radar.sector_deg": [0.0, 360.0] if full else [210.0, 330.0]})
    mesh = Simulator(scene).mesh(0)
    lit = {name: light(name, mesh, scene) for name in TRACERS}
    checks = []
    for one, other in (("facets", "horizon"), ("paths", "facets"), ("paths", "horizon")):
        differ = lit[one] != lit[other]
        away = differ & ~(beside_an_edge(lit[one]) | beside_an_edge(lit[other]))
        checks += [
            at_most(
                f"{one} and {other} differ on, of {differ.size:.2g}", 100.0 * float(differ.mean()), MOST_DIFFER, "%"
            ),
            at_most("of them further than one facet from an edge of shadow", int(away.sum()), 0),
        ]
    return Outcome(
        tuple(checks),
        draw_light(mesh, lit),
        "Share of lit facets by distance, lower antenna; crosses: where a tracer differs from the horizon.",
    )


@style.styled
def draw_light(mesh: SurfaceMesh, lit: dict[str, NDArray[np.bool_]]) -> Figure:
    figure = style.new_figure(3.0)
    left, right = style.place(figure, 0.65, 0.35, 3.1, 2.1), style.place(figure, 4.35, 0.35, 2.65, 2.1)
    style.graph(left, "ground range, m", "share of facets lit", "a) light by distance")
    style.graph(right, "ground range, m", "column of the mesh", "b) facets lit by one alone")
    distance = mesh.facets.distance
    bins = np.arange(0.0, distance[-1] + 10.0, 10.0)
    number = np.digitize(distance, bins) - 1
    middle = bins[np.unique(number)] + 5.0
    for name, width, dash in zip(TRACERS, (3.5, 2.0, 0.8), ("-", "-", "--"), strict=True):
        share = lit[name][0].mean(axis=0)
        by_bin = np.bincount(number, share) / np.maximum(np.bincount(number), 1)
        left.plot(middle, by_bin[np.unique(number)], dash, color=INKS[name], linewidth=width, label=name, alpha=0.8)
        if name != "horizon":
            _, column, facet = np.nonzero(lit[name] != lit["horizon"])
            mark = {"facets": "x", "paths": "+"}[name]
            right.plot(distance[facet], column, mark, color=INKS[name], markersize=4, label=f"{name}: {column.size}")
    left.set_ylim(0.0, 1.05)
    right.set(xlim=(0.0, float(distance[-1])), ylim=(0.0, lit["horizon"].shape[1]))
    left.legend()
    right.legend()
    return figure


CASES: list[Case] = [
    Case(
        name="phase_resolved",
        group="accuracy",
        title="Wave by wave, from a mast of 5 Hs",
        rationale="The bar that reconstructions of shadowed synthetic radar have set: each wave, not their statistics.",
        setup="choppy_sea with 1 W and its noise from 7 m (5 Hs), 50–200 m; one seed, with --full four",
        expectation=f"Correlation {WIJAYA:g} and more (Wijaya et al. 2015, reconstruction at antenna height 5 Hs), of "
        "what is more than half visible and of every cell that has a height.",
        run=phase_resolved,
    ),
    Case(
        name="sea_states",
        group="accuracy",
        title="Significant wave height, sea by sea",
        rationale="What an X-band interferometer and a wave wire beside it, and bulk marine radar, have been good for.",
        setup=f"Six seas of 0.5 to 4 m, mast {MAST_M:g} m, 1 W and its noise, a turn each; one seed, with --full four",
        expectation=f"As good as published: correlation {WIRE_CORRELATION:g}, slope {WIRE_SLOPE:g} (as near to 1), "
        f"bias {100.0 * WIRE_BIAS_M:g} cm (Eshbaugh & Frasier 2002); rms {BULK_RMSE_M:g} m (Carrasco et al. 2017).",
        run=sea_states,
    ),
    Case(
        name="three_tracers",
        group="light and shadow",
        title="Three tracers light the same facets",
        rationale="Rays of this package, the horizon in float64, and Sionna's own line of sight share the mesh alone.",
        setup="choppy_sea's default mesh, 120° towards the waves, with --full the whole circle; both antennas",
        expectation=f"Fewer than {MOST_DIFFER:g} % of facets differ, none further than one facet from an edge of "
        "shadow: what float32 rounds (0.001–0.01 %).",
        run=three_tracers,
    ),
]
