"""What each design of a grid is likely to measure, by the model that answers at once: no simulation."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import stdtrit

from ..conventions import written
from ..errors import InputError
from ..measured import FULLY_MEASURED, LEVEL
from ..metrics import BIN_M
from ..scene import Scene, SceneLike, as_scene
from .choices import best_of_all, choice_in_words, choices
from .key_words import words_of
from .paired import FEWEST_SEEDS
from .vary import grid, labels, refuse_limit, scenes_of

if TYPE_CHECKING:
    import xarray as xr

RADIUS, REACH, QUALITY = "outlook_fully_measured_radius_m", "outlook_reach_m", "outlook_quality_by_range"
MOTION = "outlook_motion_cost_m"
_WORDS = {
    RADIUS: ("m", "fully measured radius by the outlook, without a simulation"),
    REACH: ("m", f"range at which the mean score falls below {LEVEL:g}, by the outlook"),
    MOTION: ("m", "fully measured radius that the boat's motion costs, by the outlook"),
    QUALITY: ("1", "mean score of all cells by the outlook, without a simulation"),
}
_SCATTER_M = 1.2  # standard deviation of a run's radius over seeds, of 64 random designs: validation.claims.outlook
_MOST_SEEDS = 64


def outlooks(scene: SceneLike, vary: Mapping[str, Sequence[Any]], at_most: float | None = None) -> xr.Dataset:
    """What `seamap_rt.outlook` says of every combination of keys, as {"radar.height_m": [3, 5, 10]}.

    A Dataset over the keys with `outlook_fully_measured_radius_m`, `outlook_reach_m`, `outlook_motion_cost_m` [m] and,
    over `range` [m], the middles of bins of 25 m, `outlook_quality_by_range`; NaN where a design is refused. Some tens
    of milliseconds a design. at_most: as for `trade`. Raises InputError where none can be made.
    """
    scene = as_scene(scene)
    values = json.loads(json.dumps({key: list(each) for key, each in vary.items()}, default=str))
    points = grid(scene, values, [scene.seed])
    refuse_limit(values, at_most)
    scenes = {point.index[:-1]: made for point, made in zip(points, scenes_of(scene, points), strict=True)}
    middles = np.arange(0.5 * BIN_M, scene.radar.range_m[1] + BIN_M, BIN_M)
    return outlook_columns(values, scenes, middles).assign_attrs({} if at_most is None else {"at_most": at_most})


def outlook_columns(
    vary: Mapping[str, Sequence[Any]], scenes: Mapping[tuple[int, ...], Scene | InputError], middles: np.ndarray
) -> xr.Dataset:
    """Of scenes by their place in the grid, in bins about `middles` (range,) [m]."""
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
        {name: (dims, values, _attrs(name)) for name, values in columns.items()}
        | {QUALITY: ((*dims, "range"), quality, _attrs(QUALITY))},
        {key: (key, labels(values)) for key, values in vary.items()} | {"range": middles},
    )


def _attrs(name: str) -> dict[str, str]:
    units, words = _WORDS[name]
    return {"units": units, "long_name": words}


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
    yield from best_of_all(table)
    yield FULLY_MEASURED
    least, most = (float(each) for each in (found[MOTION].min(), found[MOTION].max()))
    if most > 0.0:
        span = f"{least:.0f} to {most:.0f}" if round(least) < round(most) else written(most, 0)
        yield (
            f"the boat's motion costs {span} m of the radius; it is taken as given, though a taller mast's weight "
            "makes a boat roll more"
        )


def _seeds_in_words(difference: float) -> str:
    """Of a difference [m] between designs over the same seas, to be told with 95 % confidence."""
    many = np.arange(FEWEST_SEEDS, _MOST_SEEDS + 1)
    if not np.isfinite(difference):
        return ""
    enough = many[stdtrit(many - 1, 0.975) * np.sqrt(2.0 / many) * _SCATTER_M <= difference]
    seeds = f"{enough[0]} seeds" if enough.size else f"more than {_MOST_SEEDS} seeds"
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
