"""A turn's interferogram: the covariance of each dwell and gate, what its phase means, and how far it may be off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from ..settings import RetrievalSettings
from .ambiguity import CycleEstimate, HeightEstimate, ambiguous_gates, doubtful_cycle, resolve, sea_size
from .description import RadarDescription
from .poses import Heights, PhaseModel, edge_bias
from .quality import has_echo, lit_power, object_echo, own_echo
from .speckle import (
    ONE_CELL,
    DwellPulses,
    Samples,
    Weights,
    echo_correlations,
    estimation_doubt,
    incoherent_power,
    phase_variances,
    wrapped_variance,
)
from .windows import Covariance, PhaseSlopes

Map = NDArray[np.float64]

BLURRED_GATES = 0.2  # at most, of all
LASTING = 0.9  # coherence of an antenna's echo with its next one, below which pulses are not compared
_BESIDE = 4, 1  # gates and looks to either side: 6 m, an eighth of the length of a wind sea's waves
_APART, _EVENED = 2.5, 21  # pulse's standard deviations between gates that share little; gates of one contrast
_LEAST_SHARED = 0.1  # coherence, at which a phase says nothing
AROUND: Weights = (np.ones(5), np.ones(3))  # gates, looks: the window over which the incoherent power is averaged


@dataclass(frozen=True)
class EchoPower:
    """Power [W] (look, gate) of a turn's echo, noise taken off: of all pulses, whether or not they are compared, and so
    of the interferograms of all ways."""

    pulses: Covariance
    noise: float  # W, of one receiver
    radar: RadarDescription
    width: float  # degrees between looks

    def window_mean(self, window: Weights) -> Map:
        """Means over a window, without noise."""
        return self.pulses.power_in(*window) - self.noise

    @cached_property
    def dwells(self) -> Map:
        """Of each dwell and gate."""
        return 0.5 * (self.pulses.lower + self.pulses.upper) - self.noise

    @cached_property
    def neighbourhood_mean(self) -> Map:
        """The mean of a cell and its neighbours."""
        return self.window_mean(AROUND)

    @cached_property
    def lit_cell_power(self) -> Map:
        """(1, gate) of a lit cell of the sea."""
        return lit_power(self.dwells, self.radar.ranges)

    @cached_property
    def own_echo_mask(self) -> NDArray[np.bool_]:
        """(look, gate) of cells with more echo, in their gate or one beside it, than neighbours leave; no object's."""
        beam = self.radar.response, (self.width, self.radar.spacing), self.radar.azimuth_beamwidth
        own = own_echo(self.dwells, *beam)
        beside = own.copy()
        beside[:, 1:] |= own[:, :-1]
        beside[:, :-1] |= own[:, 1:]
        return beside & ~object_echo(self.dwells, self.lit_cell_power + self.noise, *beam)


@dataclass(frozen=True)
class Interferogram:
    """Of p ways; arrays (look, gate)."""

    dwell: Covariance
    echo: EchoPower
    model: PhaseModel
    dwelt: DwellPulses
    noise_square: float  # what is left of the noise's beat with itself, see PulsePairs
    settings: RetrievalSettings
    kept: Map | float = 1.0  # share of the echo that is left between the pulses that are compared
    others: Callable[[], tuple[HeightEstimate, ...]] = field(default=tuple)  # of the same heights, on demand

    def echoing(self, cells: Covariance, echo_power: Map) -> NDArray[np.bool_]:
        """Cells (look, gate) with an echo of their own; echo_power [W] of these cells."""
        return has_echo(cells, echo_power, self.echo.noise, self.settings) & self.echo.own_echo_mask

    @cached_property
    def edge(self) -> Map:
        """Height [m] by which a distributed sea is found too high where its echo grows along the range."""
        return edge_bias(self.echo.dwells, self.model.poses.fan.height, self.model.radar)

    @cached_property
    def level_slopes(self) -> PhaseSlopes:
        """Along mean sea level."""
        return PhaseSlopes(self.model.flat_per_gate, np.zeros(1), self.model.level)

    def windowed(self, window: Weights, along: PhaseSlopes) -> Covariance:
        """Covariance (look, gate) over a window whose phase follows these slopes."""
        return self.dwell.windowed_along(*window, along)

    def incoherent(self, along: PhaseSlopes) -> Map:
        """Power [W] that the receivers do not share, the noise's apart: of windows that follow the phase's slopes, or
        the waves would count as a lack of coherence."""
        return incoherent_power(self.windowed(AROUND, along), self.echo.noise, self._neighbourhood.noise, self.kept)

    def incoherent_about(self, phase: Map) -> Map:
        """The same of windows that follow a map of phases [rad], (look, gate), which waves curve within a window."""
        turned = self.dwell.rotated(-np.nan_to_num(phase)).windowed(*AROUND)
        samples = self._neighbourhood.speckle
        one_fitted = samples / max(samples - 1.0, 1.0)  # the map's phase there, which made the windows look coherent
        return incoherent_power(turned, self.echo.noise, self._neighbourhood.noise, self.kept) * one_fitted

    @cached_property
    def _neighbourhood(self) -> Samples:
        return self.dwelt.samples(AROUND, self.model.radar)

    @property
    def doubt(self) -> float:
        """By how much the incoherent power may be more than it is found to be."""
        return estimation_doubt(self._neighbourhood.speckle)

    def variances(self, cells: Covariance, window: Weights, incoherent: Map) -> tuple[Map, Map]:
        """Variance [rad²] of the phase of windows' means, by speckle and by noise; infinite where nothing is heard."""
        samples = self.dwelt.samples(window, self.model.radar)
        # Von Mises's law of a coherence γ: (1 − γ²)/2γ in place of 1 − γ.
        with np.errstate(invalid="ignore", divide="ignore"):
            shared = np.clip(1.0 - np.nan_to_num(incoherent / self.echo.neighbourhood_mean), _LEAST_SHARED, 1.0)
        incoherent = incoherent * 0.5 * (1.0 + shared) / shared
        return phase_variances(
            cells, incoherent, self.echo.noise, samples.speckle, samples.noise, self.noise_square, self.doubt
        )

    def texture(self, incoherent: Map) -> Map:
        """Variance [rad²] (look, gate) of a dwell's phase by what makes one part of its footprint brighter than another
        besides speckle: waves, breakers."""
        around = self.echo.neighbourhood_mean
        return np.divide(incoherent, around, out=np.zeros(around.shape), where=around > 0.0) * self._contrast

    @cached_property
    def _contrast(self) -> Map:
        """Variance (1, gate) of the echo's mean power from one footprint to the next, over that power's square.

        Of gates a pulse apart, whose speckle of L samples has a correlation r, ⟨(a − b)²⟩ : ⟨(a + b)²⟩ of the powers is
        2V + (2(1 − r) + V(1 + r))/L : 4 + (2(1 + r) + V(1 − r))/L.
        """
        radar, power, gates = self.model.radar, self.echo.dwells, self.model.radar.ranges.size
        apart = min(gates, max(1, round(_APART * radar.response.spread_m / radar.spacing)))
        a, b = power[:, : gates - apart], power[:, apart:]
        both = self.echo.own_echo_mask[:, : gates - apart] & self.echo.own_echo_mask[:, apart:] & (a + b > 0.0)
        noise = self.echo.noise * (a + b + self.echo.noise) / self.dwelt.pulses
        sums = [np.sum(each**2 - noise, axis=0, where=both) for each in (a - b, a + b)]
        around = np.ones(min(_EVENED, gates))
        less, more = (np.convolve(np.pad(each, (apart // 2, apart - apart // 2)), around, "same") for each in sums)
        ratio = np.divide(less, more, out=np.zeros(gates), where=more > 0.0)
        faded = 1.0 / self.dwelt.samples(ONE_CELL, radar).speckle
        alike = float(echo_correlations(radar.response, apart * radar.spacing, 2)[0][1]) ** 2
        excess = ratio * (4.0 + 2.0 * (1.0 + alike) * faded) - 2.0 * (1.0 - alike) * faded
        return np.maximum(excess / (2.0 + (1.0 + alike) * faded - ratio * (1.0 - alike) * faded), 0.0)[None]

    def variance(self, cells: Covariance, window: Weights, incoherent: Map) -> Map:
        """The sum of both, not wrapped."""
        speckle, noise = self.variances(cells, window, incoherent)
        return speckle + noise

    def tilted_share(self, incoherent: Map, phase: Map) -> Map:
        """Share (look, gate) of the incoherent power that is due to the phase's turn within a pulse.

        phase [rad] (look, gate): along the surface. Of a Gaussian pulse exp(−(turn · spread)²/2) stays coherent.
        """
        turn = self.turn(phase) * self.model.radar.response.spread_m
        lost = -np.expm1(-0.5 * turn**2) * np.maximum(self.echo.neighbourhood_mean, 0.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(incoherent > 0.0, np.clip(lost / incoherent, 0.0, 1.0), 0.0)

    def turn(self, phase: Map) -> Map:
        """By how much [rad/m] a phase (look, gate) along the surface turns along the range.

        Where it is not known, as that of mean sea level does.
        """
        each = np.gradient(phase, axis=1) if phase.shape[1] > 1 else np.zeros(phase.shape)
        each = np.where(np.isfinite(each), each, np.nan_to_num(self.model.flat_per_gate))
        return each / self.model.radar.spacing

    def resolved(
        self, cells: Covariance, variance: Map, echoing: NDArray[np.bool_]
    ) -> tuple[Heights, NDArray[np.bool_]]:
        """Heights of averaged cells whose phases have that variance [rad²], and which of them stay ambiguous."""
        residual = self.model.residual(cells)
        heights = self.model.heights_of(cells, residual)
        ambiguous = np.zeros(residual.shape, dtype=bool)
        if self.settings.ambiguity == "fold":
            return heights, ambiguous
        # Nearer than the sea is below, nothing is level: what echoes there is no part of it.
        known = echoing & np.isfinite(heights.gain) & (self.model.radar.ranges > self.model.poses.fan.height)
        size = sea_size(residual, heights.gain, known)
        if not ambiguous_gates(heights.gain, known, size).any():
            return heights, ambiguous
        resolved = self._cycles(residual, np.sqrt(wrapped_variance(variance)), heights, known)
        if resolved.cycles.any():
            heights = self.model.heights_of(cells, residual + 2.0 * np.pi * resolved.cycles)
        # Where mean sea level alone turns the phase by a radian within a pulse, neighbours cannot be followed, of both
        # ways nor of one; and where the sea's rms height is half a cycle, one break misleads all beyond it.
        with np.errstate(invalid="ignore"):
            blind = np.zeros_like(known) if self.others() else np.pi * np.abs(heights.gain) < size
        turn = self.model.turn_within_pulse / (self.model.paths if self.others() else 1)
        blurred = known & ((turn > 1.0) | blind)
        return heights, resolved.ambiguous | blurred

    def heights_near(
        self, cells: Covariance, before: Heights, known: NDArray[np.bool_], ambiguous: NDArray[np.bool_]
    ) -> tuple[Heights, NDArray[np.bool_]]:
        """Heights of averaged cells, on the cycles that are nearest to an earlier map's, and which stay ambiguous.

        known, ambiguous (look, gate): where that map has a height, and where its cycle is doubtful. Where it has none
        its neighbours' mean stands in, from which the sea may stray.
        """
        residual = self.model.residual(cells)
        if self.settings.ambiguity == "fold":
            return self.model.heights_of(cells, residual), ambiguous
        earlier = before.phase - self.model.flat
        known = known & np.isfinite(earlier) & np.isfinite(before.gain)
        if not known.all():
            earlier = np.where(known, earlier, _mean_beside(np.where(known, earlier, np.nan)))
            ambiguous = ambiguous | (
                ~known & doubtful_cycle((residual - earlier) / (2.0 * np.pi), 2.0 * np.pi * before.gain)
            )
        cycles = np.round((earlier - residual) / (2.0 * np.pi))
        return self.model.heights_of(cells, residual + 2.0 * np.pi * np.nan_to_num(cycles)), ambiguous

    def _cycles(self, residual: Map, spread: Map, heights: Heights, known: NDArray[np.bool_]) -> CycleEstimate:
        radar = self.model.radar
        across = radar.ranges * np.radians(self.echo.width)
        gain = np.broadcast_to(self.model.rise_sign, heights.gain.shape) * heights.gain
        return resolve(residual, spread, gain, known, radar.spacing, across, *self.others())


def _mean_beside(phase: Map) -> Map:
    """Mean phase (look, gate) over a cell's neighbourhood, of those that are known; NaN where none is."""
    known = np.isfinite(phase)
    size: Any = 2 * _BESIDE[1] + 1, 2 * _BESIDE[0] + 1  # which scipy's types do not know of
    with np.errstate(invalid="ignore", divide="ignore"):
        total, number = (
            uniform_filter(each, size, mode="constant")
            for each in (np.where(known, phase, 0.0), known.astype(np.float64))
        )
        return np.where(number > 0.5 / (size[0] * size[1]), total / number, np.nan)
