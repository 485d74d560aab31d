"""Which pulses make up which cell's dwell.

A pulse belongs to the look in which its fan meets mean sea level. While the fan stands upright that is the look of the
boresight's bearing, for all gates alike; a rolling boat leans the fan, so that near gates hear another azimuth than far
ones, and each gate then has its own pulses.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled


@dataclass(frozen=True)
class Dwells:
    """The look of each pulse, or −1: `look` is (pulse,) for an upright fan, (pulse, gate) for a leaning one."""

    look: NDArray[np.intp]
    looks: int

    @classmethod
    def of_single_pulses(cls, count: int) -> Dwells:
        """Each pulse a dwell of its own."""
        return cls(np.arange(count), count)

    @property
    def leaning(self) -> bool:
        """Whether the look of a pulse depends on the gate."""
        return self.look.ndim == 2

    @cached_property
    def pulses(self) -> NDArray[np.intp]:
        """How many pulses each cell has: (look, 1), or (look, gate)."""
        if not self.leaning:
            return np.bincount(self.look[self.look >= 0], minlength=self.looks)[:, None]
        return self._summed(np.ones((self.look.shape[0], 1)))[0].astype(np.intp)

    @property
    def median_pulses(self) -> int:
        """Pulses of the median cell that has any; at least 1."""
        some = self.pulses[self.pulses > 0]
        return max(1, int(np.median(some))) if some.size else 1

    def __getitem__(self, rows: NDArray[np.intp]) -> Dwells:
        """Those of some pulses alone."""
        return Dwells(self.look[rows], self.looks)

    def means(self, fields: NDArray[np.float64]) -> NDArray[np.float64]:
        """Means of (pulse, field) over each cell's pulses, (field, look, 1 or gate); those not finite are left out."""
        good = np.isfinite(fields).all(axis=1)
        if not good.all():
            return self[np.flatnonzero(good)].means(fields[good])
        with np.errstate(invalid="ignore"):
            return self._summed(fields) / np.where(self.pulses > 0, self.pulses, np.nan)

    def _summed(self, fields: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sums of (pulse, field) over each cell's pulses, (field, look, 1 or gate)."""
        if self.leaning:
            totals = np.zeros((self.looks, self.look.shape[1], fields.shape[1]))
            add_fields(self.look, np.ascontiguousarray(fields), totals)
            return np.ascontiguousarray(np.moveaxis(totals, -1, 0))
        look, most = self.look + 1, self.looks + 1
        sums = [np.bincount(look, weights=row, minlength=most)[1:, None] for row in np.ascontiguousarray(fields.T)]
        return np.asarray(np.stack(sums), dtype=np.float64)

    def sums(self, field: NDArray) -> NDArray:
        """Sums of (pulse, gate) over each cell's pulses, (look, gate)."""
        shape = (self.looks, field.shape[1])
        if not self.leaning:
            rows, present, starts = self._runs
            total = np.zeros(shape, dtype=np.result_type(field.dtype, np.float64))
            if present.size:
                total[present] = np.add.reduceat(field if rows is None else field[rows], starts, axis=0)
            return total
        if np.iscomplexobj(field):
            return self.sums(np.real(field)) + 1j * self.sums(np.imag(field))
        count = (self.looks + 1) * shape[1]
        return np.bincount(self._cell, weights=field.ravel(), minlength=count)[shape[1] :].reshape(shape)

    @cached_property
    def _runs(self) -> tuple[NDArray[np.intp] | None, NDArray[np.intp], NDArray[np.intp]]:
        """Rows in the order of their looks, None if they lie so already; the looks they have; where each begins."""
        rows = np.flatnonzero(self.look >= 0)
        rows = rows[np.argsort(self.look[rows], kind="stable")]
        present, starts = np.unique(self.look[rows], return_index=True)
        return None if np.array_equal(rows, np.arange(self.look.size)) else rows, present, starts

    @cached_property
    def _cell(self) -> NDArray[np.intp]:
        gates = self.look.shape[1]
        return ((self.look + 1) * gates + np.arange(gates)).ravel()


def allot(
    sweep: NDArray[np.float64],
    aside: NDArray[np.float64] | None,
    centres: NDArray[np.float64],
    width: float,
    closed: bool,
) -> Dwells:
    """Pulses to looks. sweep (pulse,) deg from the sector's start, not wrapped; aside (pulse, gate) deg clockwise of it
    at which a leaning fan meets the sea; centres (look,) and width of the looks, deg; closed: a full circle.

    Bearings that a yawing boat carries beyond the circle's end fall on its first looks, a turn later in time: each look
    keeps the pass that gave it more pulses. Looks with less than half the pulses of the median are left without any:
    what they heard is not what lies in their middle.
    """
    toward = sweep if aside is None else sweep[:, None] + aside
    with np.errstate(invalid="ignore"):
        number = np.floor((toward - centres[0]) / width + 0.5 + 1e-9)
    looks = centres.size
    number = np.where(np.isfinite(number), number, -2 * looks).astype(np.intp)
    if closed:
        number = _select_pass(number, looks)
    dwells = Dwells(np.where((number >= 0) & (number < looks), number, -1), looks)
    scarce = (dwells.pulses > 0) & (dwells.pulses < 0.5 * dwells.median_pulses)
    if not scarce.any():
        return dwells
    gate = np.arange(scarce.shape[1]) if dwells.leaning else 0
    return Dwells(np.where((dwells.look >= 0) & scarce[dwells.look, gate], -1, dwells.look), looks)


def unwrapped_sweep(
    azimuth: NDArray[np.float64], time: NDArray[np.float64], sector: tuple[float, float], period: float
) -> NDArray[np.float64]:
    """Bearings (pulse,) as angles from the sector's start [deg] that go on across its ends, as the turn goes on.

    Of all that differ by whole turns the one is meant that leaves most pulses within the sector.
    """
    expected = azimuth[0] + 360.0 * (time - time[0]) / period
    sweep = azimuth + 360.0 * np.round((expected - azimuth) / 360.0) - sector[0]
    wide = sector[1] - sector[0]
    first = np.floor(np.median(sweep) / 360.0)
    turns = 360.0 * (first + np.array([0.0, -1.0, 1.0]))
    within = [np.count_nonzero((sweep - turn >= 0.0) & (sweep - turn < wide)) for turn in turns]
    return sweep - turns[int(np.argmax(within))]


def _select_pass(number: NDArray[np.intp], looks: int) -> NDArray[np.intp]:
    """Numbers of looks folded into the circle, of each look the pass (before, in, after the turn) with most pulses."""
    if number.size == 0 or (number.min() >= 0 and number.max() < looks):
        return number
    near = (number >= -looks) & (number < 2 * looks)
    spread = Dwells(np.where(near, number + looks, -1), 3 * looks)
    passes = spread.pulses.reshape(3, looks, -1)
    chosen = np.argmax(passes[[1, 0, 2]], axis=0)  # at equal numbers the turn itself
    chosen = np.array([1, 0, 2])[chosen]
    look = np.mod(number, looks)
    gate = np.arange(chosen.shape[1]) if number.ndim == 2 else 0
    return np.where(near & (chosen[look, gate] == number // looks + 1), look, -1)


@compiled
def add_fields(look, fields, totals):
    """Add fields (pulse, field) to the totals (look, gate, field) of each gate's look (pulse, gate), −1 for none."""
    for pulse in range(look.shape[0]):
        for gate in range(look.shape[1]):
            if look[pulse, gate] >= 0:
                total = totals[look[pulse, gate], gate]
                for n in range(fields.shape[1]):
                    total[n] += fields[pulse, n]
