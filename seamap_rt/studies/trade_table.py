"""The table of a sweep: what came of each point, as a dataset, as rows and on a page; where a map is usable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import __version__
from ..conventions import written
from ..io.text import csv_text
from ..measured import FULLY_MEASURED, LEVEL
from ..metrics import BIN_M
from ..physics.shadowing import SEEN_DB
from ..report.keys import words_of
from ..report.page_elements import Cell, Fold, Image, Table, cell, html_page
from .choices import headline, recommendations
from .paired import ASKED_M, FEWEST_SEEDS, means, seeds_for, significant_difference, value_with_band
from .point import Outcome
from .vary import Vary, labels

if TYPE_CHECKING:
    import xarray as xr


class Window(NamedTuple):
    """The ranges [m] between which a map is usable; NaN where it is nowhere, or where there are no waves to map."""

    nearest: float
    furthest: float


@dataclass(frozen=True)
class Criterion:
    """When a range bin is usable: its heights are accurate enough for the waves, and its cells dense enough.

    error_over_height: rms height error over true significant wave height Hs, at most. The sea's standard deviation is
    Hs/4, so an error of 0.1 Hs is 0.4 of it, and a map with such errors correlates with the sea by 1/√(1 + 0.4²) =
    0.93: a little above the 0.90 that phase-resolved wave reconstructions from radar report as good.

    known_share: cells that are more than half visible and answered, over all cells, at least. A third of cells 3 m long
    leaves one in 9 m along the look. Waves of 18 m and more then have two and more known cells a wavelength on the
    average, which is the least density from which they can be rebuilt (Landau 1967); a peak of 47 m has five.
    """

    error_over_height: float = 0.1
    known_share: float = 1.0 / 3.0

    def __str__(self) -> str:
        return (
            f"the longest unbroken run of whole {BIN_M:g} m bins in which the rms height error is at most "
            f"{self.error_over_height:g} of the true Hs, and at least {self.known_share:.0%} of all cells are both "
            "more than half visible and answered"
        )

    def window(
        self, range_m: Sequence[float], rmse_m: Sequence[float], known_share: Sequence[float], height_m: float
    ) -> Window:
        """Edges of the longest run of usable bins, the nearest of several. What is NaN is not usable.

        It need not begin at the first bin, because a tall mast looks over what is near.
        range_m (bin,): centres [m], rising; rmse_m, known_share (bin,); height_m: significant wave height [m].
        """
        if not height_m > 0.0:
            return Window(np.nan, np.nan)
        first, best = 0, (0, 0)  # bins of a run: its first, and the one after its last
        for number, (rmse, share) in enumerate(zip(rmse_m, known_share, strict=True)):
            if not (rmse <= self.error_over_height * height_m and share >= self.known_share):
                first = number + 1
                continue
            if number > first and range_m[number] - range_m[number - 1] > 1.5 * BIN_M:
                first = number
            if number + 1 - first > best[1] - best[0]:
                best = (first, number + 1)
        if best == (0, 0):
            return Window(np.nan, 0.0)
        return Window(range_m[best[0]] - 0.5 * BIN_M, range_m[best[1] - 1] + 0.5 * BIN_M)


COST = ("cost_s", "peak_memory_bytes")  # what depends on the machine; all else has the same bits on every run


_SEEN = "share of the sea's horizontal area that both antennas see"
_COUNTED = ", 50–200 m, cells more than half visible"
_COLUMNS = {  # units and long name, by the name in the table, which most have in a point's metrics too
    "height_rmse_m": ("m", f"rms height error{_COUNTED}"),
    "height_robust_m": ("m", f"robust height error, 1.4826 × median absolute deviation{_COUNTED}"),
    "height_bias_m": ("m", f"mean height error{_COUNTED}"),
    "height_correlation": ("1", f"correlation of retrieved and true height{_COUNTED}"),
    "slope_rmse": ("1", f"rms error of the slope along the look{_COUNTED}"),
    "visible_fraction": ("1", f"{_SEEN}{_COUNTED}"),
    "hs_true_m": ("m", f"4σ of the cells' true heights{_COUNTED}"),
    "hs_retrieved_m": ("m", f"4σ of the map's unflagged heights{_COUNTED}"),
    "significant_height_m": ("m", "significant wave height of the resolved sea, expected"),
    "fully_measured_radius_m": ("m", "radius of a disc that holds as much as is measured, by the score of all cells"),
    "reach_m": ("m", f"range at which the mean score of all cells falls below {LEVEL:g}"),
    "reach_to_the_end": ("1", "1 where it does not within the range window: the reach may be longer"),
    "gross_share": ("1", "share of the heights that count which are wrong by more than half the significant height"),
    "missed_share": ("1", "share of all cells at 50–200 m without a height that counts"),
    "half_visible_m": ("m", "ground range to which half of the water is visible to light"),
    "half_visible_vv_m": ("m", f"the same of what returns {SEEN_DB:g} dB or more of its power when lit, in VV"),
    "half_visible_hh_m": ("m", f"the same of what returns {SEEN_DB:g} dB or more of its power when lit, in HH"),
    "visible_vv_fraction": ("1", "share of the sea's horizontal area visible to a radar in VV, 50–200 m"),
    "visible_hh_fraction": ("1", "share of the sea's horizontal area visible to a radar in HH, 50–200 m"),
    "usable_range_m": ("m", "where the usable run of bins ends; 0: no bin is usable"),
    "usable_from_m": ("m", "where the usable run of bins begins"),
    "usable_to_the_end": ("1", "1 where the usable run ends with the last whole bin: it may reach farther"),
    "cost_s": ("s", "wall time of the point"),
    "peak_memory_bytes": ("byte", "most memory that its worker held"),
}
_BY_RANGE = {  # and their names in a point's `by_range`
    "height_rmse_by_range_m": ("m", "rms height error", "height_rmse_m"),
    "height_bias_by_range_m": ("m", "mean height error", "height_bias_m"),
    "slope_rmse_by_range": ("1", "rms error of the slope along the look", "slope_rmse"),
    "visible_fraction_by_range": ("1", _SEEN, "visible_fraction"),
    "answered_by_range": ("1", "share of the cells more than half visible that got a sure height", "answered"),
    "quality_by_range": ("1", "mean score of all cells: 1 is a perfect height, 0 none or one no better", "quality"),
    "known_share_by_range": (
        "1",
        "share of all cells that are more than half visible and answered; NaN in bins that the window cuts",
        "known_share",
    ),
}


def trade_table(
    vary: Vary,
    seeds: Sequence[int],
    outcomes: Mapping[tuple[int, ...], Outcome],
    criterion: Criterion,
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """All points over the varied keys, `seed` and, by bin, `range`; points that are not there have status `missing`.

    outcomes: by the point's index in the grid."""
    import xarray as xr

    ranges = sorted({centre for each in outcomes.values() for centre in each.get("by_range", {}).get("range_m", [])})
    index = {centre: number for number, centre in enumerate(ranges)}
    dims, shape = (*vary, "seed"), (*(len(values) for values in vary.values()), len(seeds))
    columns = {name: np.full(shape, np.nan) for name in _COLUMNS}
    bins = {name: np.full((*shape, len(ranges)), np.nan) for name in _BY_RANGE}
    status, reason = np.full(shape, "missing", dtype=object), np.full(shape, "", dtype=object)
    for at, outcome in outcomes.items():
        status[at], reason[at] = outcome["status"], outcome["reason"]
        cost = outcome.get("cost", {})
        columns["cost_s"][at] = cost.get("seconds", {}).get("total", np.nan)
        columns["peak_memory_bytes"][at] = _number(cost.get("peak_memory_bytes"))
        if outcome["status"] != "done":
            continue
        found = {name: _number(value) for name, value in outcome["metrics"].items()} | _usable(outcome, criterion)
        for name in found.keys() & columns.keys():
            columns[name][at] = found[name]
        here = [index[centre] for centre in outcome["by_range"]["range_m"]]
        for name, (*_, source) in _BY_RANGE.items():
            bins[name][at][here] = [_number(value) for value in outcome["by_range"][source]]
    table = xr.Dataset(
        {"status": (dims, status), "reason": (dims, reason)}
        | {name: (dims, values) for name, values in columns.items()}
        | {name: ((*dims, "range"), values) for name, values in bins.items()},
        coords={key: (key, labels(values)) for key, values in vary.items()}
        | {"seed": list(seeds), "range": np.array(ranges, dtype=np.float64)},
        attrs={"seamap_rt": __version__, "usable": str(criterion), **attributes},
    )
    for name, (units, words, *_) in (_COLUMNS | _BY_RANGE).items():
        table[name].attrs = {"long_name": words, "units": units}
    table["range"].attrs = {"long_name": "slant range, middle of the bin", "units": "m"}
    return table


def _usable(outcome: Outcome, criterion: Criterion) -> dict[str, float]:
    by_range, height = outcome["by_range"], outcome["facts"]["significant_height_m"]
    rmse, known = ([_number(value) for value in by_range[key]] for key in ("height_rmse_m", "known_share"))
    window = criterion.window(by_range["range_m"], rmse, known, height)
    whole = np.asarray(by_range["range_m"])[np.isfinite(known)]
    end = bool(whole.size and window.furthest > whole[-1])
    return {
        "significant_height_m": height,
        "usable_range_m": window.furthest if whole.size else np.nan,  # no whole bin: nothing to judge
        "usable_from_m": window.nearest,
        "usable_to_the_end": float(end),
    }


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)


def rows(table: xr.Dataset) -> str:
    """The table as CSV, a row per point, empty where there is no value."""
    numbers = [name for name in _COLUMNS if name not in COST]
    frame = table[["status", *numbers, *COST, "reason"]].to_dataframe(dim_order=list(table["status"].dims))
    frame = frame.reset_index()
    return csv_text([list(frame), *frame.itertuples(index=False, name=None)])


# ------------------------------------------------------------------------------------------------------- the page


SHOWN: dict[str, tuple[str, int]] = {  # of the page's table: label, and decimals
    "fully_measured_radius_m": ("Fully measured radius (m)", 0),
    "reach_m": ("Reach (m)", 0),
    "gross_share": ("Wrong by more than half Hs (%)", 1),
    "missed_share": ("Cells without a height, 50–200 m (%)", 0),
    "height_rmse_m": ("Height error, rms (m)", 3),
    "visible_fraction": ("Visible to light, 50–200 m (%)", 0),
    "visible_vv_fraction": ("Visible in VV, 50–200 m (%)", 0),
    "visible_hh_fraction": ("Visible in HH, 50–200 m (%)", 0),
    "half_visible_m": ("Half visible to light to (m)", 0),
    "half_visible_vv_m": ("Half visible in VV to (m)", 0),
    "half_visible_hh_m": ("Half visible in HH to (m)", 0),
    "usable_range_m": ("Usable range (m)", 0),
    "cost_s": ("Computed in (s)", 1),
}


def percent(name: str) -> float:
    """The factor that brings a quantity of SHOWN to the unit of its label."""
    return 100.0 if "(%)" in SHOWN[name][0] else 1.0


def trade_page(table: xr.Dataset, images: Sequence[Image]) -> str:
    """One HTML file that needs no other. images: of the table, see `trade_figures.trade_images`."""
    done = bool((table["status"] == "done").any())
    keys = [str(dim) for dim in table["status"].dims if dim != "seed"]
    advice = list(recommendations(table)) if done else []
    words = [(key, words_of(key)) for key in keys]
    small_print = [(f"{FULLY_MEASURED[0].upper()}{FULLY_MEASURED[1:]}.", "")]
    small_print += [(f"{each.label}: {each.meaning}", key) for key, each in words]
    heads = [*(each.label for _, each in words), *(label for label, _ in SHOWN.values())]
    note = "Means over the seeds, with their 95 % bands from three seeds on."
    return html_page(
        f"Trade of {', '.join(words_of(key).name for key in keys if table.sizes[key] > 1) or 'one design'}",
        [f"{line[0].upper()}{line[1:]}." for line in advice] or ["Nothing has a result yet."],
        images,
        [Fold("Words, keys and the scene", notes=small_print, text=table.attrs.get("scene", ""))],
        notes=[_seeds(table), *(line for line in headline(table) if line not in (*advice, FULLY_MEASURED))],
        table=Table("All designs", heads, _rows(table, keys), note, files=["trade.csv", "trade.nc"]),
    )


def _rows(table: xr.Dataset, keys: list[str]) -> list[list[Cell]]:
    """A row for each design: text and, to sort by, the number."""
    found = {name: table[name].mean("seed") * percent(name) for name in SHOWN}
    bands = {name: means(table[name]) for name in ("fully_measured_radius_m", "reach_m")}
    result = []
    for at in np.ndindex(*(table.sizes[key] for key in keys)):
        here = dict(zip(keys, at, strict=True))
        cells = [cell(table[key].values[number]) for key, number in here.items()]
        for name, (_, decimals) in SHOWN.items():
            value = float(found[name].isel(here))
            known, band = np.isfinite(value), bands[name].isel(here) if name in bands else None
            ends = (float(band["low"]), float(band["high"])) if band is not None else ()
            text = value_with_band(value, *ends) if ends and known else written(value, decimals)
            cells.append(Cell(text, value if known else None))
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
