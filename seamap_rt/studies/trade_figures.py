"""Pictures of a sweep: curves with bands over the seeds, maps of two keys, and what a larger radius costs."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..measured import LEVEL
from ..physics.shadowing import SEEN_DB
from ..report import style
from ..report.keys import words_of
from ..report.page_elements import Image
from .choices import choice_key
from .paired import FEWEST_SEEDS, means, significant_difference
from .trade_table import SHOWN
from .vary import CIRCUMSTANCES, chosen_key

QUANTITIES = {name: SHOWN[name][0] for name in ("fully_measured_radius_m", "reach_m", "height_rmse_m")}
_FIRST = "fully_measured_radius_m"
_MOST_CURVES, _MOST_COLUMNS, _MOST_PANELS = 12, 3, 6
_LEFT, _TOP, _GAP, _FOOT = 0.62, 0.3, 0.62, 0.4  # inches
_LEGEND, _LEGEND_COLUMNS = 0.17, 6


class Layout(NamedTuple):
    """Which key goes along the axis, which distinguishes curves, and which panels."""

    along: str
    family: str | None
    panels: tuple[str, ...]


def layout(table: xr.Dataset) -> Layout:
    """The numeric key with the most values goes along; the next has a curve for each value; the others have panels."""
    keys = [str(dim) for dim in table["status"].dims if dim != "seed"]
    along = max(keys, key=lambda key: (table[key].dtype.kind == "f", table.sizes[key]))
    others = sorted((key for key in keys if key != along and table.sizes[key] > 1), key=lambda key: -table.sizes[key])
    curves = [key for key in others if table.sizes[key] <= _MOST_CURVES] or others
    family = curves[0] if curves else None
    return Layout(along, family, tuple(key for key in others if key != family))


@style.styled
def draw_trade(table: xr.Dataset) -> Figure:
    """Fully measured radius, reach and height error over the varied keys.

    Curves are means over the seeds, with their 95 % confidence band where there are three seeds and more, and each seed
    a dot. Two keys with many values make maps. Where there are more than three panels, only the radius is drawn.
    """
    chosen = layout(table)
    alone = [key for key in table["status"].dims if key not in (*chosen, *chosen.panels, "seed")]
    single = table.isel(dict.fromkeys(alone, 0))
    panels = _choices(table, chosen.panels)
    names = list(QUANTITIES) if len(panels) <= _MOST_COLUMNS else [_FIRST]
    as_map = chosen.family is not None and not chosen.panels and table.sizes[chosen.family] > len(style.FAMILY)
    cells = [(name, *panel) for name in names for panel in panels]
    columns = len(names) if len(panels) == 1 else min(_MOST_COLUMNS, len(panels))
    members = table.sizes[chosen.family] if chosen.family and not as_map else 0
    legend = -(-members // _LEGEND_COLUMNS)
    right = 0.35 if as_map else 0.12  # a colour bar's numbers
    high = 2.0 if columns < 3 or len(cells) <= columns else 1.6
    figure, places = _sheet(len(cells), columns, high, legend, right, _FOOT)
    for number, (axes, (name, at, words)) in enumerate(zip(places, cells, strict=True)):
        title = f"({chr(97 + number)}) {words}" if words else f"({chr(97 + number)})"
        style.graph(axes, words_of(chosen.along).label, QUANTITIES[name], title)
        if as_map:
            _map(figure, axes, single.isel(at), name, chosen)
        else:
            _curves(axes, single.isel(at), name, chosen)
    if members:
        _legend(figure, figure.axes[0], words_of(str(chosen.family)).label)
    _foot(figure, table)
    return figure


def _choices(table: xr.Dataset, keys: Sequence[str]) -> list[tuple[dict[str, int], str]]:
    """Every combination of the keys' values: by their places, and in words where there is a choice."""
    places = [dict(zip(keys, at, strict=True)) for at in product(*(range(table.sizes[key]) for key in keys))]
    return [(at, ", ".join(_words(table, k, i) for k, i in at.items() if table.sizes[k] > 1)) for at in places]


def _others(table: xr.Dataset, chosen: Layout) -> list[tuple[dict[str, int], str]]:
    """`_choices` of all keys but the one along."""
    return _choices(table, [str(dim) for dim in table["status"].dims if dim not in (chosen.along, "seed")])


def _sheet(
    count: int, columns: int, high: float, legend: int, right: float = 0.12, foot: float = 0.0
) -> tuple[Figure, list[Axes]]:
    """Panels, `high` inches each, under a legend of so many lines."""
    lines, wide = -(-count // columns), (style.WIDTH - _LEFT - right - (columns - 1) * _GAP) / columns
    top = _TOP + (_LEGEND * legend + 0.2 if legend else 0.0)
    figure = style.new_figure(top + lines * (high + _GAP) + foot)
    places = [divmod(number, columns) for number in range(count)]
    return figure, [
        style.place(figure, _LEFT + column * (wide + _GAP), top + line * (high + _GAP), wide, high)
        for line, column in places
    ]


def _curves(axes: Axes, panel: xr.Dataset, name: str, chosen: Layout) -> None:
    x = _positions(axes, panel, chosen.along)
    family = chosen.family
    for number in range(panel.sizes[family] if family else 1):
        member, label = (panel.isel({family: number}), _value(panel, family, number)) if family else (panel, "")
        colour = _colour(number, panel.sizes[family] if family else 1)
        values = member[name].transpose(chosen.along, "seed")
        band = means(values)
        axes.plot(
            np.repeat(x, values.sizes["seed"]), values.values.ravel(), ".", color=colour, markersize=2.5, alpha=0.5
        )
        axes.plot(x, band["mean"], color=colour, marker="o", markersize=3.0, label=label)
        if band["high"].notnull().any():
            style.band(axes, x, band["low"], band["high"], colour, 0.15)
        if f"outlook_{name}" in member:
            axes.plot(x, member[f"outlook_{name}"], ":", color=colour, linewidth=1.0)
        if name == "reach_m":
            open_end = member["reach_to_the_end"].max("seed") > 0.0
            axes.plot(x[open_end], band["mean"].values[open_end], "^", color=colour, markersize=6.0, fillstyle="none")
    top = np.nanmax(panel[name].values, initial=0.0)
    axes.set_ylim(0.0, 1.1 * top if top > 0.0 else 1.0)
    if np.isnan(panel[name].values).all():
        style.note(axes, "no values")


def _legend(figure: Figure, axes: Axes, title: str) -> None:
    """Above the panels, where it hides nothing."""
    figure.legend(
        *axes.get_legend_handles_labels(), title=title, title_fontsize=style.FONT - 0.5, alignment="left",
        loc="upper left", bbox_to_anchor=(0.02, 1.0), borderaxespad=0.2, ncols=_LEGEND_COLUMNS,
    )  # fmt: skip


def _map(figure: Figure, axes: Axes, panel: xr.Dataset, name: str, chosen: Layout) -> None:
    assert chosen.family is not None
    mean = means(panel[name])["mean"].transpose(chosen.family, chosen.along)
    x, y = _positions(axes, panel, chosen.along), _positions(axes, panel, chosen.family, vertical=True)
    colours = axes.pcolormesh(
        x, y, style.masked(mean.values), cmap=style.colours(style.SPREAD_COLOURS), shading="nearest"
    )
    axes.set_facecolor(style.BLANK)
    axes.set_ylabel(words_of(chosen.family).label)
    axes.set_title(f"{axes.get_title(loc='left')} {QUANTITIES[name]}")
    axes.grid(False)
    figure.colorbar(colours, ax=axes, pad=0.03)


def _positions(axes: Axes, table: xr.Dataset, key: str, vertical: bool = False) -> np.ndarray:
    """Values of a key along an axis; what is no number stands side by side."""
    values = table[key].values
    if values.dtype.kind == "f" and np.isfinite(values).all():
        return values
    axis = axes.yaxis if vertical else axes.xaxis
    axis.set_ticks(range(values.size), labels=[_value(table, key, number) for number in range(values.size)])
    return np.arange(values.size, dtype=np.float64)


def _colour(number: int, count: int) -> Any:
    return style.FAMILY[number] if count <= len(style.FAMILY) else _ramp(number, count)


def _ramp(number: int, count: int) -> Any:
    """From dark to light, of values in their order; the lightest yellow is too faint for a line."""
    return matplotlib.colormaps[style.SPREAD_COLOURS](0.9 * number / max(count - 1, 1))


def _value(table: xr.Dataset, key: str, number: int) -> str:
    value = table[key].values[number]
    return f"{value:g}" if isinstance(value, float) else str(value).replace("$", r"\$")  # no formula of Matplotlib's


def _words(table: xr.Dataset, key: str, number: int) -> str:
    words = words_of(key)
    return f"{words.name} {words.value(table[key].values[number])}".replace("$", r"\$")


def _foot(figure: Figure, table: xr.Dataset) -> None:
    """What the quantities are, and what the curves leave out."""
    seeds, absent = table.sizes["seed"], int((table["status"] != "done").sum())
    band = "; dots: each seed; band: 95 % confidence of the mean" if seeds >= FEWEST_SEEDS else "; dots: each seed"
    lost = f" {absent} of {table['status'].size} points have no result." if absent else ""
    open_end = " ▵: up to the end of the range window." if (table["reach_to_the_end"] > 0.0).any() else ""
    at_once = " Dotted: the outlook, a model without simulation." if "outlook_reach_m" in table else ""
    text = (
        "Fully measured radius: of a disc that holds as much as is measured, by the score of all cells, from 1 "
        "(perfect) to 0 (no height, or one no better than the mean level). Reach: where the mean score falls below "
        f"{LEVEL:g}. Error: 50–200 m. Mean of {seeds} seed{'s' * (seeds > 1)}{band}."
    )
    words = textwrap.fill(text + at_once + open_end + lost, 135)
    figure.text(0.01, 0.02, words, fontsize=style.FONT - 1.0, color=style.GREY, va="bottom")


# ------------------------------------------------------------------------------- what stands behind the radii


@style.styled
def draw_quality(table: xr.Dataset) -> Figure:
    """Mean score against range for each value along, a panel for each choice of the other keys (the first six)."""
    chosen = layout(table)
    panels, members = _others(table, chosen)[:_MOST_PANELS], table.sizes[chosen.along]
    legend = -(-members // _LEGEND_COLUMNS)
    figure, places = _sheet(len(panels), min(_MOST_COLUMNS, len(panels)), 1.7, legend)
    for number, (axes, (at, words)) in enumerate(zip(places, panels, strict=True)):
        style.graph(axes, "Slant range (m)", "Mean score of all cells", f"({chr(97 + number)}) {words}")
        here = table.isel(at)
        for value in range(members):
            colour, place = _ramp(value, members), {chosen.along: value}
            score = here["quality_by_range"].mean("seed").isel(place)
            axes.plot(table["range"], score, color=colour, label=_value(table, chosen.along, value))
            if "outlook_quality_by_range" in here:
                axes.plot(
                    table["range"], here["outlook_quality_by_range"].isel(place), ":", color=colour, linewidth=0.9
                )
        axes.axhline(LEVEL, color=style.GREY, linestyle="--", linewidth=0.6)
        axes.set_ylim(0.0, 1.0)
    _legend(figure, figure.axes[0], words_of(chosen.along).label)
    return figure


def draw_half_visible(table: xr.Dataset) -> Figure:
    """Half-visible range and visible share to light, in VV and in HH, a colour for each choice of the other keys."""
    return _draw_means(
        table,
        (
            ("Half visible to (m)", 1.0, ("half_visible_m", "half_visible_vv_m", "half_visible_hh_m")),
            ("Visible at 50–200 m (%)", 100.0, ("visible_fraction", "visible_vv_fraction", "visible_hh_fraction")),
        ),
        {"to light": "-", "in VV": "-.", "in HH": ":"},
    )


def draw_shares(table: xr.Dataset) -> Figure:
    """Share of the heights that are wrong by more than half the wave height, and of the cells without a height."""
    panels = (
        (SHOWN["gross_share"][0], 100.0, ("gross_share",)),
        (SHOWN["missed_share"][0], 100.0, ("missed_share",)),
    )
    return _draw_means(table, panels, {"": "-"})


@style.styled
def _draw_means(
    table: xr.Dataset, panels: Sequence[tuple[str, float, Sequence[str]]], dashes: Mapping[str, Any]
) -> Figure:
    """Means over the seeds, a colour for each choice of the other keys. panels: label, factor, and a quantity for each
    of the dashes, which are by their names."""
    chosen = layout(table)
    choices = _others(table, chosen)
    lines = [Line2D([], [], color=style.BLACK, linestyle=dash, label=name) for name, dash in dashes.items() if name]
    figure, places = _sheet(len(panels), len(panels), 2.0, -(-(len(choices) + len(lines)) // 3))
    for number, (axes, (label, factor, names)) in enumerate(zip(places, panels, strict=True)):
        style.graph(axes, words_of(chosen.along).label, label, f"({chr(97 + number)})")
        x = _positions(axes, table, chosen.along)
        for place, (at, _) in enumerate(choices):
            for name, dash in zip(names, dashes.values(), strict=True):
                y, colour = factor * table[name].isel(at).mean("seed"), _colour(place, len(choices))
                axes.plot(x, y, linestyle=dash, color=colour, marker="o", markersize=2.5)
        axes.set_ylim(bottom=0.0)
    if len(choices) > 1:
        shown = enumerate(choices)
        lines += [Line2D([], [], color=_colour(place, len(choices)), label=words) for place, (_, words) in shown]
    if lines:
        figure.legend(handles=lines, loc="upper left", bbox_to_anchor=(0.02, 1.0), ncols=3)
    return figure


# ------------------------------------------------------------------------------------------------- what it costs


@style.styled
def draw_pareto(table: xr.Dataset, cost: str | None = None) -> Figure:
    """Fully measured radius against a cost that is better low: the key that is chosen (the antenna's height if it
    varies), else seconds of computing.

    Each set of circumstances (keys of sea, scattering and platform) has its own front: the choices that no other one
    beats in both, and of which each gains over the cheaper one before it what the seeds tell from chance.
    """
    varied = {str(dim): table[dim].values.tolist() for dim in table["status"].dims if dim != "seed"}
    price = cost or chosen_key(varied) or "cost_s"
    figure = style.new_figure(4.0)
    axes = style.place(figure, _LEFT, 0.75, style.WIDTH - _LEFT - 0.12, 2.4)
    label = "Seconds a point" if price == "cost_s" else words_of(price).label
    style.graph(axes, label, QUANTITIES[_FIRST], larger_radius(price))
    reach = means(table[_FIRST])["mean"]
    costs = means(table["cost_s"])["mean"] if price == "cost_s" else table[price].broadcast_like(reach)
    given = [str(dim) for dim in reach.dims if str(dim).startswith(CIRCUMSTANCES) and dim != price]
    choices = [str(dim) for dim in reach.dims if dim not in given and dim != price]
    settings = _choices(table, given)
    for number, (here, _) in enumerate(settings):
        x, y = costs.isel(here).values.ravel(), reach.isel(here).values.ravel()
        known = np.isfinite(x) & np.isfinite(y)
        colour = _colour(number, len(settings))
        axes.plot(x[known], y[known], "o", color=colour, markersize=3.0, alpha=0.4)
        least = significant_difference(table[_FIRST].isel(here))
        best = pareto_front(x[known], y[known], least if np.isfinite(least) else 0.0)
        label = ", ".join(_value(table, key, i) for key, i in here.items())
        axes.step(x[known][best], y[known][best], where="post", color=colour, marker="o", markersize=4.0, label=label)
    if given:
        _legend(figure, axes, ", ".join(words_of(key).label for key in given))
    axes.set_ylim(bottom=0.0)
    if choices:
        names = ", ".join(words_of(key).name for key in choices)
        axes.set_title(f"{larger_radius(price)} (each dot a choice of {names})")
    _foot(figure, table)
    return figure


def larger_radius(price: str) -> str:
    """What `draw_pareto` shows, by the key that is its price or "cost_s"."""
    return f"What a larger radius costs in {'computing' if price == 'cost_s' else words_of(price).name}"


def pareto_front(cost: np.ndarray, gain: np.ndarray, least: float = 0.0) -> np.ndarray:
    """Numbers of the points that no other beats in both, by rising cost (point,): each gains more than `least` over
    the one before it, and of those of one cost the one that gains most is taken."""
    order = np.lexsort((-gain, cost))
    front: list[int] = []
    for number in order:
        if not front or gain[number] > gain[front[-1]] + least:
            front.append(int(number))
    return np.array(front, dtype=np.intp)


# -------------------------------------------------------------------------------------------------- for the page


def trade_images(table: xr.Dataset, figure: bytes) -> list[Image]:
    """All pictures with their captions. figure: of `draw_trade`, as PNG."""
    made = [Image.of("Fully measured radius, reach and error", figure, _RADII)]
    if not (table["status"] == "done").any():
        return made
    if table["half_visible_m"].notnull().any():
        made.append(Image.of("How far the sea is visible", style.png(draw_half_visible(table)), _HALF_VISIBLE))
    return [
        *made,
        Image.of("How much is measured at which range", style.png(draw_quality(table)), _QUALITY),
        Image.of("What is wrong and what is missed", style.png(draw_shares(table)), _SHARES),
        Image.of(larger_radius(choice_key(table) or "cost_s"), style.png(draw_pareto(table)), _PARETO),
    ]


_RADII = (
    "A disc of perfect heights of this radius holds as much as all that is measured; the reach is where the mean score "
    "of all cells falls below 0.28. Dots: each seed; bands: 95 % of the mean, from three seeds on. Dotted: the outlook,"
    " a model that answers at once and simulates nothing."
)
_HALF_VISIBLE = (
    "Ground range to which half of the sea is visible to light, and to a radar in VV and in HH: water that returns "
    f"{SEEN_DB:g} dB or more of its two-way power when lit; and the share of the sea that is visible at 50 to 200 m. "
    "Means over the seeds."
)
_QUALITY = (
    "1: a perfect height; 0: none, or one no better than the mean level. Mean over seeds, looks and turns. Dashed: "
    "where the reach ends; dotted: the outlook."
)
_SHARES = "The score does not tell a height that is wrong by a little too much from one that is wrong by far; these do."
_PARETO = (
    "A step leads from design to design that no cheaper one matches: each gains over the one before it more than the "
    "seeds leave to chance (95 %, over the same seas; of fewer than three seeds any gain counts). Faint dots: all "
    "other designs."
)
