"""Figures of a shadowing study, how much is seen from where and what it is that is seen, and its page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import matplotlib
import matplotlib.colors
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..physics.shadowing import SEEN_DB
from ..report import style
from ..report.page_elements import Cell, Fold, Image, Table, html_page
from .paired import ASKED_M, FEWEST_SEEDS, seeds_for
from .visible_tally import LOOKS

_DASHES = {"VV": "-.", "HH": ":"}
_LEFT, _GAP, _HIGH = 0.55, 0.2, 2.1  # inches
LOOK_WORDS = {
    "all looks": "all looks",
    "along": "along the waves, up and down",
    "at 45°": "at 45° to the waves",
    "across": "across the waves",
}


@style.styled
def draw_shadowing(data: xr.Dataset, looks: Sequence[str] = tuple(LOOKS)) -> Figure:
    """Visible share against range for the looks, and the half range against the look; a colour per height."""
    figure = style.new_figure(6.75)
    for axes, look in _row(figure, data, looks, 0.65, "Visible share (%)", "Ground range (m)", titled=True):
        axes.axhline(50.0, color=style.GREY, linewidth=0.6)
        for height, colour in _heights(data):
            _draw_share(axes, data.sel(height=height, look=look), colour)
        axes.set_ylim(0.0, 103.0)
        if data["look_visible_fraction"].sel(look=look).isnull().all():
            style.note(axes, "nothing known")
    lines = "to light, 95 % band", *(f"to a radar, {each} −6 dB" for each in _DASHES), "Smith 1967"
    _legend(figure, data, lines, ("-", *_DASHES.values(), "--"))
    below = style.place(figure, _LEFT, 3.6, style.WIDTH - _LEFT - 0.12, 2.3)
    _draw_half_ranges(below, data, len(looks))
    note = f"Bands: {data.attrs['bands']}.\nJags along the waves are single crests, which stand across a whole sector."
    figure.text(0.08, 0.012, note, color=style.GREY, fontsize=style.FONT - 0.5)
    return figure


def _row(
    figure: Figure, data: xr.Dataset, looks: Sequence[str], top: float, label: str, x_label: str, titled: bool
) -> Iterator[tuple[Axes, str]]:
    """A panel for each look, side by side over the ranges."""
    wide = (style.WIDTH - _LEFT - 0.12 - (len(looks) - 1) * _GAP) / len(looks)
    for number, look in enumerate(looks):
        axes = style.place(figure, _LEFT + number * (wide + _GAP), top, wide, _HIGH)
        title = f"({'abc'[number]}) {LOOK_WORDS[look]}" if titled else ""
        style.graph(axes, x_label, "" if number else label, title)
        axes.tick_params(labelleft=number == 0)
        axes.set_xlim(0.0, float(data["range"].max()))
        yield axes, look


def _draw_share(axes: Axes, mast: xr.Dataset, colour: str) -> None:
    distance = mast["range"].values
    low, high = (100.0 * mast[f"look_visible_fraction_{end}"].values for end in ("low", "high"))
    style.band(axes, distance, low, high, colour, 0.15)
    axes.plot(distance, 100.0 * mast["look_smith"].values, color=colour, linestyle="--", linewidth=0.9)
    if "look_exact" in mast:
        axes.plot(distance, 100.0 * mast["look_exact"].values, "x", color=style.BLACK, markersize=3.0)
    for each, dashes in _DASHES.items() if "look_radar_r50" in mast else ():  # not in studies of versions before
        radar = mast["look_radar_visible_fraction"].sel(polarization=each, level=SEEN_DB).values
        axes.plot(distance, 100.0 * radar, color=colour, linestyle=dashes, linewidth=0.9)
    axes.plot(distance, 100.0 * mast["look_visible_fraction"].values, color=colour)
    axes.plot([float(mast["look_r50"])], [50.0], "o", color=colour, markersize=4.0)


def _draw_half_ranges(axes: Axes, data: xr.Dataset, number: int) -> None:
    style.graph(
        axes,
        "Look, from where the waves come from (°; 0 looks into them)",
        "Half range (m)",
        f"({'abcd'[number]}) Range beyond which half is shadowed, by sectors of 15°; dashed: Smith",
    )
    far = float(data["range"].max())
    angle = data["from_waves"].values
    for height, colour in _heights(data):
        mast = data.sel(height=height)
        half = mast["r50"].values
        reach = np.abs(np.stack([half - mast["r50_low"].values, mast["r50_high"].values - half]))
        axes.errorbar(angle, half, np.nan_to_num(reach), fmt="o", color=colour, markersize=3.0, linewidth=0.8)
        smith = mast["r50_smith"].where(np.isfinite(mast["r50_smith"]))
        axes.plot(angle, smith, "--", color=colour, linewidth=0.9)
        beyond = np.isnan(half) & (mast["visible_fraction"].min("range").values > 0.0)
        axes.plot(angle[beyond], np.full(beyond.sum(), far), "^", color=colour, markersize=4.0, clip_on=False)
    axes.set(ylim=(0.0, 1.02 * far), xlim=(-187.5, 187.5), xticks=range(-180, 181, 45))
    if np.isnan(data["r50"].values).any():
        axes.text(0.995, 0.03, "▲ half or more is visible all through", transform=axes.transAxes, ha="right")


@style.styled
def draw_seen(data: xr.Dataset) -> Figure:
    """How far what is seen stands above the mean, and how long shadows and visible stretches are, along each look."""
    figure = style.new_figure(8.05)
    tops = [0.65 + row * (_HIGH + 0.35) for row in range(3)]
    for axes, look in _row(figure, data, tuple(LOOKS), tops[0], "Seen above the mean (m)", "", titled=True):
        for height, colour in _heights(data):
            mast = data.sel(height=height, look=look)
            low, high = (mast[f"look_crest_bias_{end}"].values for end in ("low", "high"))
            style.band(axes, mast["range"].values, low, high, colour, 0.15)
            axes.plot(mast["range"].values, mast["look_crest_bias"].values, color=colour)
        axes.axhline(0.0, color=style.BLACK, linewidth=0.6)
        axes.set_ylim(_limits(data, "crest_bias"))
    runs = ("shadow", "Shadows (m)", ""), ("visible", "Seen at a stretch (m)", "Ground range (m)")
    for top, (what, label, x_label) in zip(tops[1:], runs, strict=True):
        for axes, look in _row(figure, data, tuple(LOOKS), top, label, x_label, titled=False):
            for height, colour in _heights(data):
                mast = data.sel(height=height, look=look)
                for end, how in (("median", {}), ("90", {"linestyle": "--", "linewidth": 0.9})):
                    axes.plot(mast["range"].values, mast[f"look_{what}_run_{end}"].values, color=colour, **how)
            axes.set_ylim(_limits(data, what))
    _legend(figure, data, ("mean, 95 % band; median length", "90 % are shorter"), ("-", "--"))
    return figure


def _limits(data: xr.Dataset, what: str) -> tuple[float, float]:
    """The same for all looks."""
    name = "look_crest_bias" if what == "crest_bias" else f"look_{what}_run_90"
    known = data[name].values[np.isfinite(data[name].values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    margin = 0.1 * max(high - low, 1e-3)
    return (low - margin, high + margin) if what == "crest_bias" else (0.0, high + margin)


def _heights(data: xr.Dataset) -> list[tuple[float, str]]:
    """Each height and its colour, from dark to light as they rise; three or fewer have the palette's own."""
    heights = [float(height) for height in data["height"].values]
    if len(heights) <= 3:
        return list(zip(heights, (style.VERMILION, style.BLUE, style.GREEN), strict=False))
    shades = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.85, len(heights)))
    return [(height, matplotlib.colors.to_hex(shade)) for height, shade in zip(heights, shades, strict=True)]


def _legend(figure: Figure, data: xr.Dataset, lines: Sequence[str], dashes: Sequence[str]) -> None:
    """Two rows above the panels: a colour per height, a dash per kind of line."""
    colours = [Line2D([], [], color=colour, label=f"mast {height:g} m") for height, colour in _heights(data)]
    kinds = [Line2D([], [], color=style.GREY, ls=dash, label=line) for line, dash in zip(lines, dashes, strict=True)]
    if "look_exact" in data and len(lines) == 4:
        kinds.append(Line2D([], [], color=style.BLACK, marker="x", ls="", markersize=3.0, label="exact"))
    for row, handles in enumerate((colours, kinds)):
        top = 1.0 - 0.19 * row / figure.get_size_inches()[1]
        figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.06, top), ncols=len(handles))


_SHARES = (
    "Share of the sea's horizontal area that both antennas see in light, and that returns to a radar, in VV and HH, "
    "−6 dB or more of its two-way power when lit; along the waves, at 45° and across them, with the curve of Smith for "
    "the slopes that the mesh carries. Below: the range beyond which half is shadowed from light, by look."
)
_SEEN = "Mean height of what is seen (crests, at grazing angles), and lengths of shadows and of visible stretches."


def shadowing_page(data: xr.Dataset, lines: Sequence[str], shares: bytes, seen: bytes, seeds: int, scene: str) -> str:
    """lines: what the study says; shares, seen: its figures, as PNG; scene: as TOML."""
    words = ("Antenna height: mean height of the phase centres over mean sea level.", "radar.height_m")
    return html_page(
        "Shadowing",
        [f"{line[0].upper()}{line[1:]}." for line in lines],
        [Image.of("Visible share against range", shares, _SHARES), Image.of("What it is that is seen", seen, _SEEN)],
        [Fold("Words, keys and the scene", notes=[words], text=scene)],
        notes=[_seeds(data, seeds)],
        table=Table("Half ranges", _HEADS, _rows(data), _NOTE, files=["shadowing.csv", "shadowing.nc"]),
    )


_HEADS = (
    "Antenna height (m)",
    "Look",
    "Half range (m)",
    "from",
    "to",
    "Smith 1967 (m)",
    "VV, −6 dB (m)",
    "HH, −6 dB (m)",
)
_NOTE = (
    "The range beyond which half of the sea is in shadow, with its 95 % band; and beyond which less than half returns "
    "to a radar −6 dB or more of its two-way power when lit."
)


def _rows(data: xr.Dataset) -> list[list[Cell]]:
    names = ("look_r50", "look_r50_low", "look_r50_high", "look_r50_smith")
    result = []
    for height in data["height"].values:
        for look in data["look"].values:
            values = [float(data[name].sel(height=height, look=look)) for name in names]
            values += data["look_radar_r50"].sel(height=height, look=look, level=SEEN_DB).values.tolist()
            numbers = [Cell(f"{each:.0f}", each) if np.isfinite(each) else Cell("—") for each in values]
            result.append([Cell(f"{height:g}", float(height)), Cell(str(look)), *numbers])
    return result


def _seeds(data: xr.Dataset, seeds: int) -> str:
    if seeds < FEWEST_SEEDS:
        return f"{'One seed' if seeds == 1 else f'{seeds} seeds'}: no bands. Give --seeds 3 or more."
    half = (data["look_r50_high"] - data["look_r50"]).values
    if not np.isfinite(half).any():
        return f"{seeds} seeds."
    worst = float(np.nanmax(half))
    words = f"{seeds} seeds: bands of half ranges of ± {worst:.0f} m at most. "
    return words + (f"{seeds_for(seeds, worst)}." if worst > ASKED_M else "")
