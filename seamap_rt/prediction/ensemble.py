"""What a fit leaves open, by samples: seas drawn as the prior expects them are seen where and as well as the real one
was, are fitted as it was, and are missed by what the fit leaves open (perturbed observations: Houtekamer & Mitchell
1998).

A sample is of the long waves, which hold nearly all of the sea, and of one observation in a few that counts for all of
them: its errors are those of the whole fit to a tenth, for a fifth of its cost. Each turn adds one sample to those of
the turns before it: what is open depends on mast, sea and noise, which hardly change in some turns, and is set in the
antennas' frame.
"""

from __future__ import annotations

from collections import deque
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .assimilation import Batch, Unknowns, solve
from .field import Member
from .fit import Fit
from .observations import Observations
from .spectrum import Field, Lattice
from .wave_sum import WaveSum

_KEPT = 12  # samples: a standard error is known to a tenth from them and their neighbourhood
_OTHER = 4  # samples that rest on a fourth more or fewer turns tell of another state
_LONG, _SHORT = 3.5, 0.06  # times the peak's wavenumber, or all but this share of the sea: what samples are of
_THINNEST, _ENOUGH = 3, 5000  # one observation in three at most, of so many or more a batch


@dataclass
class _ThinnedBatch:
    """Some of a batch's observations for all of them, and the errors (chain, n) of unit variance that seas are seen
    with."""

    whole: Observations
    chosen: NDArray[np.intp]
    batch: Batch
    errors: Field


class Ensemble:
    """Samples for one fit's lattices. chains: seas that are drawn, of which one is fitted anew each turn."""

    def __init__(self, fit: Fit, chains: int = 3, seed: int = 0) -> None:
        self._stream = np.random.default_rng(seed)
        spectrum, whole = fit.spectrum, fit.lattices[0]
        peak = float(spectrum.water.wavenumber(2.0 * np.pi / spectrum.peak_period))
        edge = min(max(_LONG * peak, spectrum.wavenumber_above(_SHORT)), whole.band[1])
        side = min(2 * int(np.ceil(edge / whole.spacing)) + 1, whole.k.shape[0])
        self._lattice = Lattice.of(spectrum, side, whole.spacing, (0.0, edge), np.inf)
        self._seen: dict[int, list[_ThinnedBatch]] = {}
        parts = self._stream.standard_normal((2, chains, *self._lattice.k.shape))
        self._drawn = (parts[0] + 1j * parts[1]).astype(np.complex64)
        self._found: list[Unknowns | None] = [None] * chains  # what was last found of each drawn sea
        self._next = 0
        self._members: deque[Member] = deque(maxlen=_KEPT)

    @property
    def members(self) -> tuple[Member, ...]:
        """The samples, the last one last."""
        return tuple(self._members)

    def solve(self, fit: Fit, issued: float, workers: Executor) -> None:
        """Solves the fit and advances beside it: while one gathers what the workers made, they work for the other."""
        fit.update_weights()
        with ThreadPoolExecutor(1) as beside:
            advanced = beside.submit(self.advance, fit, issued, workers)
            fit.solve(workers)
            advanced.result()

    def advance(self, fit: Fit, issued: float, workers: Executor) -> None:
        """Takes up what the fit took up and weighed, and adds a sample; all chains' at first."""
        self._lattice = self._lattice.rescaled(fit.spectrum)
        self._seen = {number: self._thinned_batches(number, fit) for number in fit.batches}
        alike = [each for each in self._members if abs(each.turns - fit.turns) <= max(1, fit.turns // _OTHER)]
        self._members = deque(alike, maxlen=_KEPT)
        for _ in range(max(1, len(self._found) - len(alike))):
            self._members.append(self._sample(fit, issued, workers))

    def _thinned_batches(self, number: int, fit: Fit) -> list[_ThinnedBatch]:
        """One turn's batches, thinned if they are new, with the weights of now."""
        whole, known = fit.batches[number], self._seen.get(number, [])
        same = len(known) == len(whole) and all(a.whole is b.seen for a, b in zip(known, whole, strict=True))
        parts = known if same else [self._thinned(batch, fit) for batch in whole]
        for part, batch in zip(parts, whole, strict=True):
            thin = len(part.whole) / max(part.chosen.size, 1)
            weight, variance = thin * batch.weight[part.chosen], batch.variance[part.chosen] / thin
            part.batch = replace(part.batch, weight=weight, variance=variance)
        return parts

    def _thinned(self, batch: Batch, fit: Fit) -> _ThinnedBatch:
        size = len(batch.seen)
        thin = int(np.clip(size // _ENOUGH, 1, _THINNEST))
        chosen = np.sort(self._stream.permutation(size)[: size // thin])
        seen, weight = batch.seen[chosen], batch.weight[chosen]
        made = WaveSum(seen, [self._lattice], fit.spectrum.water, weight, fit.centre)
        errors = self._stream.standard_normal((len(self._found), chosen.size))
        return _ThinnedBatch(batch.seen, chosen, Batch(seen, made, weight, batch.variance[chosen]), errors)

    def _sample(self, fit: Fit, issued: float, workers: Executor) -> Member:
        """The next chain's."""
        number, lattice = self._next, self._lattice
        self._next = (number + 1) % len(self._found)
        root, seen = lattice.scale.astype(np.float32), [part for parts in self._seen.values() for part in parts]
        drawn = self._drawn[number]
        values = [
            each.batch.sum.values([root * drawn])
            + (each.errors[number] * np.sqrt(each.batch.variance)).astype(np.float32)
            for each in seen
        ]
        found, _ = solve([each.batch for each in seen], [lattice], workers, self._found[number], values)
        self._found[number] = found
        phase = lattice.kx * fit.centre[0] + lattice.ky * fit.centre[1] - lattice.omega * issued
        missed = root * (drawn - found[0]) * np.exp(1j * phase)
        fitted = root * found[0] * np.exp(1j * phase)
        return Member(lattice, missed.astype(np.complex64), fitted.astype(np.complex64), fit.turns)
