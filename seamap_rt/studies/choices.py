"""What a sweep comes to: what to choose, how sure that is, and how its points ended, in a few lines.

Also of a grid's designs by the outlook, the model that answers at once: no simulation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import stdtrit

from ..conventions import written
from ..errors import InputError
from ..measured import FULLY_MEASURED, LEVEL
from ..metrics import BIN_M
from ..report.keys import words_of
from ..scene import Scene, SceneLike, as_scene
from .paired import FEWEST_SEEDS, MOST_SEEDS, WITHIN, Choice, choose, end_of, means, value_with_band
from .vary import CIRCUMSTANCES, Grid, chosen_key, labels, refuse_limit

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
        yield (f"{words}: " if words else "") + f"{choice_in_words(choice)}; {_measured_in_words(table, here, choice)}"
    yield from best_radius_lines(table)


def best_radius_lines(table: xr.Dataset) -> Iterator[str]:
    """The greatest radius of all designs, for each of the circumstances, and at which ends of the grid it lies; where
    one key alone is chosen and its values are numbers, `choices` has said it."""
    mean, along = table["fully_measured_radius_m"].mean("seed"), choice_key(table)
    given = [str(name) for name in mean.dims if str(name).startswith(CIRCUMSTANCES)]
    free = [str(name) for name in mean.dims if mean.sizes[name] > 1 and name not in given]
    if along and len(free) < 2:
        return
    for words, here in _parts(mean, given):
        if along:
            here = here.sel({along: here[along] <= table.attrs.get("at_most", np.inf)})
        if not here.notnull().any():
            continue
        best = here.isel(here.argmax(...))
        where = [f"{_valued(name, best[name].item())}{_end_in_words(mean, here, best, name)}" for name in free]
        greatest = f"{'greatest ' if free else ''}fully measured radius{' of all' if along else ''} {best.item():.0f} m"
        yield (f"{words}: " if words else "") + greatest + (f", at {'; '.join(where)}" if where else "")


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
    confidence = "above 99%" if choice.confidence > 0.995 else f"{choice.confidence:.0%}"
    sure = "" if np.isnan(choice.confidence) else f" (confidence {confidence})"
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


def choices(table: xr.Dataset) -> Iterator[tuple[str, xr.Dataset, Choice]]:
    """For each choice of the other keys: these in words, their part of the table, and what to choose there."""
    key = choice_key(table)
    if not key:
        return
    radius = table["fully_measured_radius_m"]
    for words, here in _parts(table, [str(dim) for dim in radius.dims if dim not in (key, "seed")]):
        choice = choose(here["fully_measured_radius_m"], key, at_most=table.attrs.get("at_most", np.inf))
        if choice is not None:
            yield words, here, choice


def _parts(table: Any, keys: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """For each choice of the keys' values: these in words, and their part of the table or array."""
    for at in product(*(range(table.sizes[name]) for name in keys)):
        here = table.isel(dict(zip(keys, at, strict=True)))
        yield ", ".join(_valued(name, here[name].item()) for name in keys if table.sizes[name] > 1), here


def least_confidence(table: xr.Dataset) -> float:
    """Of all choices; NaN where there are none, or of fewer seeds than a confidence takes."""
    sure = [choice.confidence for _, _, choice in choices(table)]
    return min(sure) if sure and np.isfinite(sure).all() else np.nan


def choice_key(table: xr.Dataset) -> str:
    """The key that is chosen: the antenna's height where it varies, else the one with the most numbers that is no
    circumstance; empty where there is none."""
    values = {str(dim): table[dim].values.tolist() for dim in table["fully_measured_radius_m"].dims if dim != "seed"}
    return chosen_key(values)


def _measured_in_words(table: xr.Dataset, here: xr.Dataset, choice: Choice) -> str:
    """How much is measured at what is chosen; the band is pooled over the whole table."""
    at = {choice.key: here[choice.key].values.tolist().index(choice.value)}
    band = means(table["fully_measured_radius_m"])
    radius = band.sel({name: here[name] for name in band.dims if name != choice.key}).isel(at)
    one = here.isel(at)
    wide = value_with_band(float(radius["mean"]), float(radius["low"]), float(radius["high"]), " m")
    gross = written(100.0 * float(one["gross_share"].mean()), 1)
    more = "at least " if float(one["reach_to_the_end"].max()) > 0.0 else ""
    return (
        f"at {words_of(choice.key).value(choice.value)} fully measured radius {wide}, "
        f"reach {more}{float(one['reach_m'].mean()):.0f} m, "
        f"{gross}% of the heights wrong by more than half the wave height{_half_visible(table, one)}"
    )


def _half_visible(table: xr.Dataset, one: xr.Dataset) -> str:
    """The range to which half of the sea is visible to the radar in its own polarization, and to light, if known."""
    own = str(one[POLARIZATION].item()) if POLARIZATION in one.coords else table.attrs.get("polarization", "")
    half = one.get(f"half_visible_{own.lower()}_m")
    if half is None or not half.notnull().any():
        return ""
    light = float(one["half_visible_m"].mean())
    beside = f" (to light to {light:.0f} m)" if np.isfinite(light) else ""
    return f"; half of the sea is visible to the radar in {own} to {float(half.mean()):.0f} m{beside}"


def _valued(key: str, value: Any) -> str:
    words = words_of(key)
    return f"{words.name} {words.value(value)}"


POLARIZATION = "scattering.polarization"
RADIUS, REACH, QUALITY = "outlook_fully_measured_radius_m", "outlook_reach_m", "outlook_quality_by_range"
MOTION = "outlook_motion_cost_m"
_ATTRIBUTES = {
    RADIUS: {"units": "m", "long_name": "fully measured radius by the outlook, without a simulation"},
    REACH: {"units": "m", "long_name": f"range at which the mean score falls below {LEVEL:g}, by the outlook"},
    MOTION: {"units": "m", "long_name": "fully measured radius that the boat's motion costs, by the outlook"},
    QUALITY: {"units": "1", "long_name": "mean score of all cells by the outlook, without a simulation"},
}
_SCATTER_M = 1.2  # standard deviation of a run's radius over seeds, of 64 random designs: validation.claims.outlook


def outlooks(scene: SceneLike, vary: Mapping[str, Sequence[Any]], at_most: float | None = None) -> xr.Dataset:
    """What `seamap_rt.outlook` says of every combination of keys, as {"radar.height_m": [3, 5, 10]}.

    A Dataset over the keys with `outlook_fully_measured_radius_m`, `outlook_reach_m`, `outlook_motion_cost_m` [m] and,
    over `range` [m], the middles of bins of 25 m, `outlook_quality_by_range`; NaN where a design is refused. Some tens
    of milliseconds a design. at_most: as for `trade`. Raises InputError where none can be made.
    """
    scene = as_scene(scene)
    grid = Grid.of(scene, vary)
    columns = outlook_columns(grid, np.arange(0.5 * BIN_M, scene.radar.range_m[1] + BIN_M, BIN_M), at_most)
    return columns.assign_attrs({} if at_most is None else {"at_most": at_most})


def outlook_columns(grid: Grid, middles: np.ndarray, at_most: float | None = None) -> xr.Dataset:
    """Of a grid's designs, in bins about `middles` (range,) [m]. Raises InputError for a limit that leaves none."""
    vary, scenes = grid.vary, grid.designs
    refuse_limit(vary, at_most)
    import xarray as xr

    from ..design_outlook import outlook  # loads numba

    dims, shape = tuple(vary), tuple(len(values) for values in vary.values())
    columns = {name: np.full(shape, np.nan) for name in (RADIUS, REACH, MOTION)}
    quality = np.full((*shape, middles.size), np.nan)
    for at, scene in scenes.items():
        try:
            found = outlook(scene) if isinstance(scene, Scene) else None
        except InputError:
            found = None
        if found is None or found.attrs["fully_measured_radius_m"] is None:
            continue
        columns[RADIUS][at], columns[REACH][at] = found.attrs["fully_measured_radius_m"], found.attrs["reach_m"]
        columns[MOTION][at] = max(found.attrs["radius_at_rest_m"] - columns[RADIUS][at], 0.0)
        bins = np.floor(found["range"].values / BIN_M)
        for number, middle in enumerate(middles):
            inside = bins == np.floor(middle / BIN_M)
            if inside.any():
                quality[(*at, number)] = found["quality"].values[inside].mean()
    return xr.Dataset(
        {name: (dims, values, _ATTRIBUTES[name]) for name, values in columns.items()}
        | {QUALITY: ((*dims, "range"), quality, _ATTRIBUTES[QUALITY])},
        {key: (key, labels(values)) for key, values in vary.items()} | {"range": middles},
    )


def outlook_lines(found: xr.Dataset) -> Iterator[str]:
    """What the outlook would choose, and how many seeds a trade needs to tell that from its neighbours."""
    import xarray as xr

    radius = found[RADIUS].expand_dims(seed=[0])
    table = xr.Dataset({"fully_measured_radius_m": radius}, attrs=found.attrs)
    for words, here, choice in choices(table):
        values = here["fully_measured_radius_m"].isel(seed=0).sortby(choice.key)
        at = values[choice.key].values.tolist().index(choice.value)
        beside = values.isel({choice.key: slice(max(at - 1, 0), at + 2)})
        yield (
            (f"{words}: " if words else "")
            + f"{choice_in_words(choice)}; at {words_of(choice.key).value(choice.value)} fully measured radius about "
            + f"{float(values[at]):.0f} m"
            + _seeds_in_words(float(abs(beside - values[at]).where(beside[choice.key] != choice.value).min()))
        )
    yield from best_radius_lines(table)
    yield FULLY_MEASURED
    least, most = (float(each) for each in (found[MOTION].min(), found[MOTION].max()))
    if most > 0.0:
        span = f"{least:.0f} to {most:.0f}" if round(least) < round(most) else written(most, 0)
        yield (
            f"the boat's motion costs {span} m of the radius; it is taken as given, though a taller mast's weight "
            "makes a boat roll more"
        )


def _seeds_in_words(difference: float) -> str:
    """Of a difference [m] between designs over the same seas, to be found with 95 % confidence."""
    many = np.arange(FEWEST_SEEDS, MOST_SEEDS + 1)
    if not np.isfinite(difference):
        return ""
    enough = many[stdtrit(many - 1, 0.975) * np.sqrt(2.0 / many) * _SCATTER_M <= difference]
    seeds = f"{enough[0]} seeds" if enough.size else f"more than {MOST_SEEDS} seeds"
    return f"; a trade needs {seeds} to tell it from its neighbours"


def outlook_table(found: xr.Dataset) -> Iterator[str]:
    """A head, and a line for each design."""
    keys = [str(dim) for dim in found[RADIUS].dims]
    shown = {RADIUS: "Fully measured radius (m)", REACH: "Reach (m)"}
    if float(found[MOTION].max()) > 0.0:
        shown[MOTION] = "The motion costs (m)"
    heads = [*(words_of(key).label for key in keys), *shown.values()]
    yield "  ".join(heads)
    for at in np.ndindex(found[RADIUS].shape):
        labelled = [words_of(key).value(found[key].values[number]) for key, number in zip(keys, at, strict=True)]
        values = [written(float(found[name].values[at]), 0) for name in shown]
        cells = zip([*labelled, *values], heads, strict=True)
        yield "  ".join(f"{value:>{len(head)}}" for value, head in cells)
