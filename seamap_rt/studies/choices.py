"""What a sweep comes to: what to choose, how sure that is, and how its points ended, in a few lines."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from ..measured import LEVEL
from .key_words import words_of
from .paired import WITHIN, Choice, choose, means

FULLY_MEASURED = (
    "fully measured radius: of a disc of perfect heights that holds as much as all cells' scores; reach: where their "
    f"mean falls below {LEVEL:g}"
)


def headline(table: xr.Dataset) -> Iterator[str]:
    """What a sweep comes to: how its points ended, where the usable range is longest, and what it cost."""
    status = table["status"].values
    counts = {name: int(np.count_nonzero(status == name)) for name in ("done", "refused", "failed", "missing")}
    yield f"{status.size} points: " + ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    for name in ("refused", "failed"):
        reasons = sorted(set(table["reason"].values[status == name]))
        if reasons:
            yield f"{name}, {'all' if len(reasons) == 1 else 'one'} of them: {reasons[0]}"
    radius = table["fully_measured_radius_m"]
    if radius.notnull().any():
        yield from recommendations(table)
        yield FULLY_MEASURED
    seconds, most = table["cost_s"].values, table["peak_memory_bytes"].values
    if np.isfinite(seconds).any():
        memory = f", at most {np.nanmax(most) / 1e9:.2g} GB" if np.isfinite(most).any() else ""
        yield f"{np.nanmean(seconds):.1f} s a point{memory}"


def recommendations(table: xr.Dataset) -> Iterator[str]:
    """What to choose of the antenna's height, or of the key with the most numbers, for each choice of the others, by
    the fully measured radius; the best of all where no key's values are numbers."""
    if not _along(table):
        mean = means(table["fully_measured_radius_m"])["mean"]
        best = mean.isel(mean.argmax(...))
        where = ", ".join(_valued(str(name), best[name].item()) for name in mean.dims if mean.sizes[name] > 1)
        yield f"greatest fully measured radius {best.item():.0f} m" + (f", at {where}" if where else "")
        return
    for words, here, choice in choices(table):
        yield (f"{words}: " if words else "") + f"{choice_in_words(choice)}; {_there(table, here, choice)}"


def choice_in_words(choice: Choice) -> str:
    """What to choose, and how sure that is."""
    key = words_of(choice.key)
    sure = "" if np.isnan(choice.confidence) else f" (confidence {_confidence(choice.confidence)})"
    edge = ", at the edge of the grid" if choice.at_edge else ""
    return f"lowest {key.name} within {WITHIN:.0%} of the best: {key.value(choice.value)}{sure}{edge}"


def _confidence(share: float) -> str:
    return "above 99%" if share > 0.995 else f"{share:.0%}"


def choices(table: xr.Dataset) -> Iterator[tuple[str, xr.Dataset, Choice]]:
    """For each choice of the other keys: these in words, their part of the table, and what to choose there."""
    key = _along(table)
    if not key:
        return
    radius = table["fully_measured_radius_m"]
    others = [str(dim) for dim in radius.dims if dim not in (key, "seed")]
    for at in product(*(range(radius.sizes[name]) for name in others)):
        here = table.isel(dict(zip(others, at, strict=True)))
        choice = choose(here["fully_measured_radius_m"], key)
        if choice is not None:
            words = [_valued(name, here[name].item()) for name in others if radius.sizes[name] > 1]
            yield ", ".join(words), here, choice


def least_confidence(table: xr.Dataset) -> float:
    """Of all choices; NaN where there are none, or of a single seed."""
    sure = [choice.confidence for _, _, choice in choices(table)]
    return min(sure) if sure and np.isfinite(sure).all() else np.nan


def _along(table: xr.Dataset) -> str:
    """The antenna's height where it varies, else the key with the most numbers; empty where there is none."""
    from .trade_figures import layout  # loads matplotlib, which workers do without

    key = "radar.height_m" if table.sizes.get("radar.height_m", 1) > 1 else layout(table).along
    return key if table[key].dtype.kind == "f" else ""


def _there(table: xr.Dataset, here: xr.Dataset, choice: Choice) -> str:
    """How much is measured at what is chosen; the band is pooled over the whole table."""
    at = here[choice.key].values.tolist().index(choice.value)
    band = means(table["fully_measured_radius_m"])
    same = {name: here[name] for name in band.dims if name != choice.key}
    radius = band.sel(same).isel({choice.key: at})
    half = 0.5 * float(radius["high"] - radius["low"])
    one = here.isel({choice.key: at})
    wide = f" ± {half:.0f}" if np.isfinite(half) else ""
    more = "at least " if float(one["reach_to_the_end"].max()) > 0.0 else ""
    return (
        f"fully measured radius {float(radius['mean']):.0f}{wide} m, reach {more}{float(one['reach_m'].mean()):.0f} m, "
        f"{float(one['gross_share'].mean()):.1%} of the heights wrong by more than half the wave height"
    )


def _valued(key: str, value: Any) -> str:
    words = words_of(key)
    return f"{words.name} {words.value(value)}"
