"""The page of a trade: what to choose and how sure that is, then the figures and the table behind it."""

from __future__ import annotations

from itertools import product

import numpy as np
import xarray as xr

from ..conventions import written
from ..measured import FULLY_MEASURED
from ..report import style
from ..report.page_elements import Cell, answer_page, cell
from .choices import along_of, headline, recommendations
from .paired import ASKED_M, FEWEST_SEEDS, means, seeds_for, significant_difference, with_band
from .trade_figures import draw_pareto, draw_quality, draw_shares, larger_radius
from .vary import words_of


def trade_page(table: xr.Dataset, figure: bytes) -> str:
    """One HTML file that needs no other. figure: of `draw_trade`, as PNG."""
    done = bool((table["status"] == "done").any())
    drawn = [("Fully measured radius, reach and error", figure, _RADII)]
    if done:
        drawn += [
            ("How much is measured at which range", style.png(draw_quality(table)), _QUALITY),
            ("What is wrong and what is missed", style.png(draw_shares(table)), _SHARES),
            (larger_radius(along_of(table) or "cost_s"), style.png(draw_pareto(table)), _PARETO),
        ]
    keys = [str(dim) for dim in table["status"].dims if dim != "seed"]
    said = list(recommendations(table)) if done else []
    words = [(key, words_of(key)) for key in keys]
    return answer_page(
        title=f"Trade of {', '.join(words_of(key).name for key in keys if table.sizes[key] > 1) or 'one design'}",
        said=[line[0].upper() + line[1:] for line in said],
        notes=[_seeds(table), *(line for line in headline(table) if line not in (*said, FULLY_MEASURED))],
        figures=drawn,
        table_title="All designs",
        table_note="Means over the seeds, with their 95 % bands from three seeds on.",
        files=["trade.csv", "trade.nc"],
        heads=[*(each.label for _, each in words), *(label for label, _ in _COLUMNS.values())],
        rows=_rows(table, keys),
        small_print=[
            (f"{FULLY_MEASURED[0].upper()}{FULLY_MEASURED[1:]}.", ""),
            *((f"{each.label}: {each.meaning}", key) for key, each in words),
        ],
        scene=table.attrs.get("scene", ""),
    )


_RADII = (
    "A disc of perfect heights of this radius holds as much as all that is measured; the reach is where the mean score "
    "of all cells falls below 0.28. Dots: each seed; bands: 95 % of the mean, from three seeds on. Dotted: the outlook,"
    " a model that answers at once and simulates nothing."
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
# Column of the table: label, and decimals.
_COLUMNS: dict[str, tuple[str, int]] = {
    "fully_measured_radius_m": ("Fully measured radius (m)", 0),
    "reach_m": ("Reach (m)", 0),
    "gross_share": ("Wrong by more than half Hs (%)", 1),
    "missed_share": ("Cells without a height, 50–200 m (%)", 0),
    "height_rmse_m": ("Height error, rms (m)", 3),
    "visible_fraction": ("Visible, 50–200 m (%)", 0),
    "usable_range_m": ("Usable range (m)", 0),
    "cost_s": ("Computed in (s)", 1),
}
_IN_PER_CENT = ("gross_share", "missed_share", "visible_fraction")


def _rows(table: xr.Dataset, keys: list[str]) -> list[list[Cell]]:
    """A row for each design: text and, to sort by, the number."""
    found = {name: table[name].mean("seed") * (100.0 if name in _IN_PER_CENT else 1.0) for name in _COLUMNS}
    bands = {name: means(table[name]) for name in ("fully_measured_radius_m", "reach_m")}
    result = []
    for at in product(*(range(table.sizes[key]) for key in keys)):
        here = dict(zip(keys, at, strict=True))
        cells = [cell(table[key].values[number]) for key, number in here.items()]
        for name, (_, decimals) in _COLUMNS.items():
            value = float(found[name].isel(here))
            text = written(value, decimals)
            if name in bands and np.isfinite(value):
                low, high = (float(bands[name][end].isel(here)) for end in ("low", "high"))
                text = with_band(value, low, high)
            cells.append(Cell(text, value if np.isfinite(value) else None))
        result.append(cells)
    return result


def _seeds(table: xr.Dataset) -> str:
    """How many there are, what they tell apart, and how many would tell more."""
    have, radius = table.sizes["seed"], table["fully_measured_radius_m"]
    if have < FEWEST_SEEDS:
        seeds = "One seed" if have == 1 else f"{have} seeds"
        return f"{seeds}: no bands, and no word on how sure the choice is. Give --seeds 3, or --until 0.95."
    band = means(radius)
    half = float((band["high"] - band["mean"]).max())
    if not np.isfinite(half):
        return f"{have} seeds; no design has {FEWEST_SEEDS} of them."
    words = f"{have} seeds over the same seas for all designs: bands of ± {half:.0f} m at most"
    apart = significant_difference(radius)
    if np.isfinite(apart):
        words += f"; two designs differ with 95% confidence where their means do by {apart:.0f} m"
    if half > ASKED_M:
        words += f". {seeds_for(have, half)}"
    return words + "."
