"""Means over seeds and what to choose: bands, differences, and how sure a recommendation is.

All designs of a sweep meet the same seas. What a sea does to all of them (a group of high waves passes) is in each
design's mean, but in no difference between designs. So a mean's band holds all of the scatter over seeds, and a
choice between designs only what is left of it when each seed's own part is taken away.

A sweep has seeds enough when it is as sure of its choice as was asked for, or out of time. One that stops as soon as
it is sure stops a little too often when it is sure by chance: of the confidence that was asked for, a few per cent less
is reached (Wald 1947, Sequential Analysis).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from ..errors import InputError

if TYPE_CHECKING:
    import xarray as xr


Array = NDArray[np.float64]

WITHIN = 0.05  # of the best: designs between which a user need not choose by this
FEWEST_SEEDS = 3  # of which a band and a confidence are stated: of two, t is 12.7 and says next to nothing
_DRAWS = 4000


def means(values: xr.DataArray) -> xr.Dataset:
    """`mean` over the seeds of each design, and `low` and `high` of its 95 % band.

    values: over keys and `seed`. The variance over seeds is pooled over each design and those beside it along the keys
    whose values are numbers; as these meet the same seas, they tell it not as well as independent ones would: by the
    square of the correlation of their deviations. What has a mean here is never negative, and no band goes below 0. NaN
    bands of designs with fewer than FEWEST_SEEDS.
    """
    import xarray as xr

    count = values.notnull().sum("seed")
    mean = values.mean("seed")
    rest = values - mean
    square, freedom = (rest**2).sum("seed"), (count - 1).clip(0)
    keys = [str(key) for key in values.dims if key != "seed" and values[key].dtype.kind == "f"]
    alike = _likeness(rest.transpose("seed", ...).values.reshape(values.sizes["seed"], -1))
    pooled, known, beside = (_sum_neighbours(each, keys) for each in (square, freedom, (freedom > 0).astype(float)))
    variance = pooled / known.where(known > 0)
    effective = known / (1.0 + (beside - 1.0).clip(0.0) * alike**2)
    half = np.sqrt(variance / count.where(count >= FEWEST_SEEDS)) * xr.apply_ufunc(stdtrit, effective, 0.975)
    return xr.Dataset({"mean": mean, "low": (mean - half).clip(0.0), "high": mean + half, "seeds": count})


def value_with_band(value: float, low: float, high: float, unit: str = "") -> str:
    """A whole number with its band: symmetric, or from 0 where that cuts it; without one where none is known."""
    if not np.isfinite(high):
        return f"{value:.0f}{unit}"
    return f"{value:.0f} ± {high - value:.0f}{unit}" if low > 0.0 else f"{value:.0f}{unit} (0 to {high:.0f}{unit})"


def _likeness(rest: Array) -> float:
    """Mean correlation between designs of their deviations (seed, design) from their own means."""
    rest = rest[:, np.isfinite(rest).all(axis=0)]
    rest = rest[:, np.any(rest != 0.0, axis=0)]
    if rest.shape[0] < 2 or rest.shape[1] < 2:
        return 0.0
    sums = np.sum(rest / np.sqrt(np.sum(rest**2, axis=0)), axis=1)  # their squares: 1 of each design, and of all pairs
    designs = rest.shape[1]
    return float((np.sum(sums**2) - designs) / (designs * (designs - 1)))


def _sum_neighbours(values: xr.DataArray, keys: Sequence[str]) -> xr.DataArray:
    """Sum over each value and those next to it along the keys."""
    total = values.copy()
    for key in keys:
        if values.sizes[key] > 1:
            total = total + values.shift({key: 1}, fill_value=0) + values.shift({key: -1}, fill_value=0)
    return total


@dataclass(frozen=True)
class Choice:
    """The least value of a key that is within WITHIN of the best, of those up to a limit.

    confidence: that it is, if the seas were drawn again; NaN of fewer than FEWEST_SEEDS. best: the value whose mean is
    greatest; best_end: "first" or "last" where that is an end of the grid and no other value is as good, else empty.
    is_first: the value is the first of the grid. at_most: the limit; beyond: the best value without it, and lost: the
    share of the mean there that the limit costs; NaN where no value beyond it has been tried.
    """

    key: str
    value: float
    best: float
    confidence: float
    best_end: str
    is_first: bool
    at_most: float
    beyond: float
    lost: float


def choose(values: xr.DataArray, key: str, seed: int = 0, at_most: float = np.inf) -> Choice | None:
    """What to take of a key whose values are numbers, up to `at_most`; None where no design has a value.

    values: over the key and `seed` alone. Only seeds that all designs have are compared. Means are drawn from the
    multivariate t of the seeds' scatter about them, by which each difference between two designs, and each comparison
    of one with a share of another, is the paired Student t of seeds − 1 degrees of freedom; the confidence is how often
    the same design is chosen. No design's scatter is taken for another's.
    """
    table = values.transpose(key, "seed").sortby(key)
    grid = table[key].values
    table = table.dropna(key, how="all")
    whole = table.dropna("seed", how="any")
    data, at = whole.values, table[key].values
    if not data.size:
        data = table.mean("seed").values[:, None]
    mean, seeds = data.mean(axis=1), data.shape[1]
    allowed = int(np.count_nonzero(at <= at_most))
    if not allowed:
        return None
    chosen = _first_near_best(mean[None, :allowed])[0]
    confidence = np.nan
    if seeds >= FEWEST_SEEDS and allowed > 1:
        rest = (data - mean[:, None])[:allowed]
        stream = np.random.default_rng(seed)
        spread = np.sqrt(1.0 / (seeds * stream.chisquare(seeds - 1, _DRAWS)))
        drawn = mean[:allowed] + spread[:, None] * (stream.normal(size=(_DRAWS, seeds)) @ rest.T)
        confidence = float(np.mean(_first_near_best(drawn) == chosen))
    best, beyond, tried = int(np.argmax(mean[:allowed])), int(np.argmax(mean)), allowed < at.size
    alone = allowed > 1 and np.delete(mean[:allowed], best).max() < mean[best]
    lost = 1.0 - float(mean[best] / mean[beyond]) if tried and mean[beyond] > 0.0 else np.nan
    value, further = float(at[chosen]), float(at[beyond]) if tried else np.nan
    end, is_first = end_of(grid, at[best], alone), value == grid[0] and grid.size > 1
    return Choice(key, value, float(at[best]), confidence, end, is_first, at_most, further, lost)


def end_of(grid: NDArray[np.float64], value: float, alone: bool) -> str:
    """Which end of a key's values (n,) the best one is: "first", "last", or empty; alone: no other is as good."""
    if grid.size < 2 or not alone:
        return ""
    return "last" if value == grid.max() else "first" if value == grid.min() else ""


def significant_difference(values: xr.DataArray) -> float:
    """The least by which two designs' means must differ to differ with 95 % confidence, over the same seas.

    values: over keys and `seed`. From what is left of the scatter when means of designs and of seeds are taken away, of
    the seeds that all designs have. NaN where fewer than FEWEST_SEEDS or than two designs tell it.
    """
    table = values.transpose("seed", ...).values.reshape(values.sizes["seed"], -1)
    table = table[:, np.isfinite(table).any(axis=0)]
    table = table[np.isfinite(table).all(axis=1)]
    seeds, designs = table.shape
    if seeds < FEWEST_SEEDS or designs < 2:
        return np.nan
    rest = table - table.mean(axis=0) - table.mean(axis=1, keepdims=True) + table.mean()
    freedom = (designs - 1) * (seeds - 1)
    return float(stdtrit(freedom, 0.975) * np.sqrt(2.0 * np.sum(rest**2) / freedom / seeds))


def _first_near_best(means: Array) -> NDArray[np.intp]:
    """Number of the first design (row, design) that is within WITHIN of its row's best."""
    return np.argmax(means >= (1.0 - WITHIN) * means.max(axis=1, keepdims=True), axis=1)


MOST_SEEDS = 64
_UNITS_S = {"s": 1.0, "min": 60.0, "h": 3600.0}


@dataclass(frozen=True)
class Goal:
    """until: confidence of every choice that is asked for, 0 to 1; budget_s: seconds in which no further seeds begin
    that would not end in them. None: not asked for; with neither, the seeds that a sweep begins with are enough.
    at_most: of the key that is chosen, the greatest value that may be. Raises InputError for what cannot be reached."""

    until: float | None = None
    budget_s: float | None = None
    at_most: float | None = None

    def __post_init__(self) -> None:
        if self.until is not None and not 0.5 <= self.until < 1.0:
            raise InputError(f"--until = {self.until:g}: must be from 0.5 to less than 1; 0.95 is usual")
        if self.budget_s is not None and not 0.0 < self.budget_s < float("inf"):
            raise InputError(f"--budget = {self.budget_s:g}: must be greater than 0; as in --budget 10min")

    def seeds(self, have: int, computed: float, confidence: float, spent_s: float) -> int:
        """How many seeds to have next; `have` where these are enough.

        computed: of `have`, how many were computed in spent_s seconds; 0 where all were there already. confidence:
        least of all choices; NaN of too few seeds.
        """
        if (self.until is None and self.budget_s is None) or (self.until is not None and confidence >= self.until):
            return have
        step = max(1, have // 2)
        if self.budget_s is not None:
            left = self.budget_s - spent_s
            step = min(step, int(left * computed / spent_s)) if computed and spent_s > 0.0 else int(left > 0.0)
        return min(have + max(step, 0), max(have, MOST_SEEDS))

    def reason(self, have: int, confidence: float) -> str | None:
        """How it ended, in a line; None where nothing was asked for."""
        if self.until is None:
            return None if self.budget_s is None else f"{have} seeds within the time given"
        if confidence >= self.until:
            return f"{have} seeds, after which every choice is as sure as asked for ({self.until:.0%})"
        why = f"{have} seeds are the most" if have >= MOST_SEEDS else "the time given is over"
        sure = "a choice is less sure" + (f" ({confidence:.0%})" if confidence >= 0.0 else ", of too few seeds,")
        return f"flag: {sure} than asked for ({self.until:.0%}), and {why}"


def seconds(text: str) -> float:
    """Seconds of a time as it is written: 90, 90s, 10min, 2h. Raises InputError for anything else."""
    found = re.fullmatch(r"\s*([0-9]*\.?[0-9]+)\s*(s|min|h)?\s*", text)
    if not found:
        raise InputError(f"--budget {text}: must be a time, as 90s, 10min or 2h")
    return float(found[1]) * _UNITS_S[found[2] or "s"]


ASKED_M = 10.0  # half width of a band that tells masts a few metres apart
_MOST = 10_000


def seeds_for(have: int, half_m: float) -> str:
    """How many seeds narrow a band of `have` seeds, which is `half_m` to either side, to ASKED_M."""
    scatter = half_m * np.sqrt(have) / stdtrit(have - 1, 0.975)
    many = np.arange(2, _MOST)
    enough = many[stdtrit(many - 1, 0.975) * scatter / np.sqrt(many) <= ASKED_M]
    number = f"about {enough[0]}" if enough.size else f"more than {_MOST}"
    return f"Bands of ± {ASKED_M:.0f} m ask for {number} seeds"
