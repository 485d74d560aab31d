"""What a sweep comes to: what to choose, how sure that is, and how its points ended, in a few lines."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from ..conventions import written
from ..measured import FULLY_MEASURED
from .key_words import words_of
from .paired import WITHIN, Choice, choose, end_of, means, with_band
from .vary import CIRCUMSTANCES, chosen_key

if TYPE_CHECKING:
    import xarray as xr


def headline(table: xr.Dataset) -> Iterator[str]:
    """What a sweep comes to: how its points ended, where the fully measured radius is greatest, and what it cost."""
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
        yield f"{written(float(np.nanmean(seconds)), 1)} s a point{memory}"


def recommendations(table: xr.Dataset) -> Iterator[str]:
    """What to choose of the antenna's height, or of the key with the most numbers, for each choice of the others, by
    the fully measured radius; and the best of all where several keys are chosen, or none whose values are numbers.

    Keys of the sea, the scattering and the boat are circumstances, among which nobody chooses. The attribute `at_most`
    of the table limits the key that is chosen."""
    for words, here, choice in choices(table):
        yield (f"{words}: " if words else "") + f"{choice_in_words(choice)}; {_there(table, here, choice)}"
    yield from best_of_all(table)


def best_of_all(table: xr.Dataset) -> Iterator[str]:
    """The greatest radius of all designs, for each of the circumstances, and at which ends of the grid it lies; where
    one key alone is chosen and its values are numbers, `choices` has said it."""
    mean, along = table["fully_measured_radius_m"].mean("seed"), along_of(table)
    free = [str(name) for name in mean.dims if mean.sizes[name] > 1 and not str(name).startswith(CIRCUMSTANCES)]
    if along and len(free) < 2:
        return
    given = [str(name) for name in mean.dims if str(name).startswith(CIRCUMSTANCES)]
    for at in product(*(range(mean.sizes[name]) for name in given)):
        here = mean.isel(dict(zip(given, at, strict=True)))
        if along:
            here = here.sel({along: here[along] <= table.attrs.get("at_most", np.inf)})
        if not here.notnull().any():
            continue
        best = here.isel(here.argmax(...))
        words = [_valued(name, best[name].item()) for name in given if mean.sizes[name] > 1]
        where = [f"{_valued(name, best[name].item())}{_end_in_words(mean, here, best, name)}" for name in free]
        greatest = f"{'greatest ' if free else ''}fully measured radius{' of all' if along else ''} {best.item():.0f} m"
        yield (f"{', '.join(words)}: " if words else "") + greatest + (f", at {'; '.join(where)}" if where else "")


def _end_in_words(mean: xr.DataArray, here: xr.DataArray, best: xr.DataArray, name: str) -> str:
    """Of a key whose best value is an end of the grid, that it is; empty elsewhere, and of values that are text."""
    if mean[name].dtype.kind != "f":
        return ""
    beside = here.sel({other: best[other].item() for other in here.dims if other != name})
    others = beside.where(beside[name] != best[name])
    end = end_of(mean[name].values, best[name].item(), not bool((others >= best).any()))
    return f" (the {end} of the grid; widen it)" if end else ""


def choice_in_words(choice: Choice) -> str:
    """What is good enough and how sure that is; which is the best, whether the grid ends there; what a limit costs."""
    key = words_of(choice.key)
    limit = f" of at most {key.value(choice.at_most)}" if np.isfinite(choice.at_most) else ""
    sure = "" if np.isnan(choice.confidence) else f" (confidence {_confidence(choice.confidence)})"
    text = f"lowest {key.name} within {WITHIN:.0%} of the best{limit}: {key.value(choice.value)}{sure}, good enough"
    if choice.is_first and choice.best != choice.value:
        text += " (the first of the grid; a lower one may be, too)"
    text += f"; the best is {key.value(choice.best)}"
    if choice.best_end:
        text += f", the {choice.best_end} of the grid; widen it"
        text += " to see what the limit costs" if choice.best_end == "last" and limit else ""
    if np.isfinite(choice.lost):
        costs = f"{choice.lost:.0%} of the fully measured radius" if choice.lost > 0.0 else "nothing"
        text += f"; the limit costs {costs} (without it the best is {key.value(choice.beyond)})"
    return text


def _confidence(share: float) -> str:
    return "above 99%" if share > 0.995 else f"{share:.0%}"


def choices(table: xr.Dataset) -> Iterator[tuple[str, xr.Dataset, Choice]]:
    """For each choice of the other keys: these in words, their part of the table, and what to choose there."""
    key = along_of(table)
    if not key:
        return
    radius = table["fully_measured_radius_m"]
    others = [str(dim) for dim in radius.dims if dim not in (key, "seed")]
    for at in product(*(range(radius.sizes[name]) for name in others)):
        here = table.isel(dict(zip(others, at, strict=True)))
        choice = choose(here["fully_measured_radius_m"], key, at_most=table.attrs.get("at_most", np.inf))
        if choice is not None:
            words = [_valued(name, here[name].item()) for name in others if radius.sizes[name] > 1]
            yield ", ".join(words), here, choice


def least_confidence(table: xr.Dataset) -> float:
    """Of all choices; NaN where there are none, or of fewer seeds than a confidence takes."""
    sure = [choice.confidence for _, _, choice in choices(table)]
    return min(sure) if sure and np.isfinite(sure).all() else np.nan


def along_of(table: xr.Dataset) -> str:
    """The key that is chosen: the antenna's height where it varies, else the one with the most numbers that is no
    circumstance; empty where there is none."""
    values = {str(dim): table[dim].values.tolist() for dim in table["fully_measured_radius_m"].dims if dim != "seed"}
    return chosen_key(values)


def _there(table: xr.Dataset, here: xr.Dataset, choice: Choice) -> str:
    """How much is measured at what is chosen; the band is pooled over the whole table."""
    at = here[choice.key].values.tolist().index(choice.value)
    band = means(table["fully_measured_radius_m"])
    same = {name: here[name] for name in band.dims if name != choice.key}
    radius = band.sel(same).isel({choice.key: at})
    one = here.isel({choice.key: at})
    wide = with_band(float(radius["mean"]), float(radius["low"]), float(radius["high"]), " m")
    gross = written(100.0 * float(one["gross_share"].mean()), 1)
    more = "at least " if float(one["reach_to_the_end"].max()) > 0.0 else ""
    return (
        f"at {words_of(choice.key).value(choice.value)} fully measured radius {wide}, "
        f"reach {more}{float(one['reach_m'].mean()):.0f} m, "
        f"{gross}% of the heights wrong by more than half the wave height"
    )


def _valued(key: str, value: Any) -> str:
    words = words_of(key)
    return f"{words.name} {words.value(value)}"
