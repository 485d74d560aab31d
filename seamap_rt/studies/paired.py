"""Means over seeds and what to choose: bands, differences, and how sure a recommendation is.

All designs of a sweep meet the same seas. What a sea does to all of them (a group of high waves passes) is in each
design's mean, but in no difference between designs. So a mean's band holds all of the scatter over seeds, and a
choice between designs only what is left of it when each seed's own part is taken away.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.special import stdtrit

Array = NDArray[np.float64]

WITHIN = 0.05  # of the best: designs between which a user need not choose by this
_DRAWS = 4000


def means(values: xr.DataArray) -> xr.Dataset:
    """`mean` over the seeds of each design, and `low` and `high` of its 95 % band.

    values: over keys and `seed`. The variance over seeds is pooled over each design and those beside it along the keys
    whose values are numbers; as these meet the same seas, they tell it not as well as independent ones would: by the
    square of the correlation of their deviations. NaN bands where no design has two seeds.
    """
    count = values.notnull().sum("seed")
    mean = values.mean("seed")
    rest = values - mean
    square, freedom = (rest**2).sum("seed"), (count - 1).clip(0)
    keys = [str(key) for key in values.dims if key != "seed" and values[key].dtype.kind == "f"]
    alike = _likeness(rest.transpose("seed", ...).values.reshape(values.sizes["seed"], -1))
    pooled, known, beside = (_with_neighbours(each, keys) for each in (square, freedom, (freedom > 0).astype(float)))
    variance = pooled / known.where(known > 0)
    effective = known / (1.0 + (beside - 1.0).clip(0.0) * alike**2)
    half = np.sqrt(variance / count.where(count > 0)) * xr.apply_ufunc(stdtrit, effective, 0.975)
    return xr.Dataset({"mean": mean, "low": mean - half, "high": mean + half, "seeds": count})


def _likeness(rest: Array) -> float:
    """Mean correlation between designs of their deviations (seed, design) from their own means."""
    rest = rest[:, np.isfinite(rest).all(axis=0)]
    rest = rest[:, np.any(rest != 0.0, axis=0)]
    if rest.shape[0] < 2 or rest.shape[1] < 2:
        return 0.0
    sums = np.sum(rest / np.sqrt(np.sum(rest**2, axis=0)), axis=1)  # their squares: 1 of each design, and of all pairs
    designs = rest.shape[1]
    return float((np.sum(sums**2) - designs) / (designs * (designs - 1)))


def _with_neighbours(values: xr.DataArray, keys: Sequence[str]) -> xr.DataArray:
    """Sum over each value and those next to it along the keys."""
    total = values.copy()
    for key in keys:
        if values.sizes[key] > 1:
            total = total + values.shift({key: 1}, fill_value=0) + values.shift({key: -1}, fill_value=0)
    return total


@dataclass(frozen=True)
class Choice:
    """The least value of a key that is within WITHIN of the best.

    confidence: that it is, if the seas were drawn again; NaN of a single seed. at_edge: of the values, beyond which the
    answer may lie."""

    key: str
    value: float
    best: float  # the value whose mean is greatest
    confidence: float
    at_edge: bool


def choose(values: xr.DataArray, key: str, seed: int = 0) -> Choice | None:
    """What to take of a key whose values are numbers; None where no design has a value.

    values: over the key and `seed` alone. Only seeds that all designs have are compared. What is left of the scatter
    when means of designs and of seeds are taken away is normal, its variance known by (designs − 1)(seeds − 1) degrees
    of freedom; means drawn by it tell how often the same design is chosen.
    """
    table = values.transpose(key, "seed").sortby(key).dropna(key, how="all")
    if not table.sizes[key]:
        return None
    whole = table.dropna("seed", how="any")
    data, at = whole.values, table[key].values
    if not data.size:
        data = table.mean("seed").values[:, None]
    mean, (designs, seeds) = data.mean(axis=1), data.shape
    chosen = _least(mean[None])[0]
    confidence = np.nan
    if seeds > 1 and designs > 1:
        rest = data - mean[:, None] - data.mean(axis=0) + data.mean()
        freedom = (designs - 1) * (seeds - 1)
        stream = np.random.default_rng(seed)
        spread = np.sqrt(np.sum(rest**2) / stream.chisquare(freedom, _DRAWS) / seeds)
        drawn = mean + spread[:, None] * stream.normal(size=(_DRAWS, designs))
        confidence = float(np.mean(_least(drawn) == chosen))
    best = int(np.argmax(mean))
    at_edge = designs > 1 and (best == designs - 1 or chosen == 0)
    return Choice(key, float(at[chosen]), float(at[best]), confidence, at_edge)


def significant_difference(values: xr.DataArray) -> float:
    """By how much two designs' means must differ to differ with 95 % confidence, over the same seas.

    values: over keys and `seed`. From what is left of the scatter when means of designs and of seeds are taken away, of
    the seeds that all designs have. NaN where fewer than two seeds or designs tell it.
    """
    table = values.transpose("seed", ...).values.reshape(values.sizes["seed"], -1)
    table = table[:, np.isfinite(table).any(axis=0)]
    table = table[np.isfinite(table).all(axis=1)]
    seeds, designs = table.shape
    if seeds < 2 or designs < 2:
        return np.nan
    rest = table - table.mean(axis=0) - table.mean(axis=1, keepdims=True) + table.mean()
    freedom = (designs - 1) * (seeds - 1)
    return float(stdtrit(freedom, 0.975) * np.sqrt(2.0 * np.sum(rest**2) / freedom / seeds))


def _least(means: Array) -> NDArray[np.intp]:
    """Number of the first design (row, design) that is within WITHIN of its row's best."""
    return np.argmax(means >= (1.0 - WITHIN) * means.max(axis=1, keepdims=True), axis=1)
