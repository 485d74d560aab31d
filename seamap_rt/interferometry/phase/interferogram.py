"""A turn's interferogram: the covariance of each dwell and gate, what its phase means, and how far it may be off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...settings import RetrievalSettings
from ..covariance.windows import Covariance, Level
from ..estimation.quality import has_echo, own_echo
from ..geometry.gate_edge import edge_bias
from ..geometry.heights import Heights, PhaseModel
from .ambiguity import Expected, Resolved, needed, resolve, sea_size
from .speckle import estimation_doubt, incoherent_power, phase_variance, wrapped_variance
from .uncertainty import ONE_CELL, Dwelt, Samples, Weights

Map = NDArray[np.float64]
# rad per gate, rad per look, which broadcast to a map, and the level of the sea as seen from a boat that moves
PhaseSlopes = tuple[Map, Map, Level | None]

_AROUND: Weights = (np.ones(5), np.ones(3))  # gates, looks: the window over which the incoherent power is averaged


@dataclass(frozen=True)
class Interferogram:
    """Of p ways; arrays (look, gate). width: degrees between looks."""

    dwell: Covariance
    heard: Covariance  # its powers are those of all pulses, whether or not they are compared
    model: PhaseModel
    dwelt: Dwelt
    noise_power: float  # W, of one receiver
    noise_square: float  # what is left of the noise's beat with itself, see PulsePairs
    width: float
    settings: RetrievalSettings
    others: Callable[[], tuple[Expected, ...]] = field(default=tuple)  # other estimates of the heights, made on demand

    def echo_power(self, window: Weights = ONE_CELL) -> Map:
        """Power [W] of the echo, noise taken off: of a window, by default of each dwell and gate."""
        level = np.zeros(1)
        cells = self.heard if window is ONE_CELL else self.heard.windowed_along(*window, level, level)
        return 0.5 * (cells.lower + cells.upper) - self.noise_power

    def echoing(self, cells: Covariance, echo_power: Map) -> NDArray[np.bool_]:
        """Cells (look, gate) with an echo of their own; echo_power [W] as `echo_power` gives it."""
        return has_echo(cells, echo_power, self.noise_power, self.settings) & self.own

    @cached_property
    def edge(self) -> Map:
        """Height [m] by which a distributed sea is found too high where its echo grows along the range."""
        return edge_bias(self.echo_power(), self.model.poses.fan.height, self.model.radar)

    @cached_property
    def own(self) -> NDArray[np.bool_]:
        """(look, gate) of cells with more echo, in their gate or one beside it, than neighbours' echoes leave there."""
        radar = self.model.radar
        power = self.echo_power()
        own = own_echo(power, radar.response, (self.width, radar.spacing), radar.azimuth_beamwidth)
        beside = own.copy()
        beside[:, 1:] |= own[:, :-1]
        beside[:, :-1] |= own[:, 1:]
        return beside

    @property
    def level_slopes(self) -> PhaseSlopes:
        """Along mean sea level."""
        return self.model.flat_per_gate, np.zeros(1), self.model.level

    def windowed(self, window: Weights, along: PhaseSlopes) -> Covariance:
        """Covariance (look, gate) over a window whose phase follows these slopes."""
        return self.dwell.windowed_along(*window, *along)

    def incoherent(self, along: PhaseSlopes) -> Map:
        """Power [W] that the receivers do not share, the noise's apart: of windows that follow the phase's slopes, or
        the waves would count as a lack of coherence."""
        return incoherent_power(self.windowed(_AROUND, along), self.noise_power, self._around.noise)

    @cached_property
    def _around(self) -> Samples:
        return self.dwelt.samples(_AROUND, self.model.radar)

    def variance(self, cells: Covariance, window: Weights, incoherent: Map) -> Map:
        """Variance [rad²] of the phase of windows' means, infinite where nothing is heard; not wrapped."""
        samples = self.dwelt.samples(window, self.model.radar)
        doubt = estimation_doubt(self._around.speckle)
        return phase_variance(
            cells, incoherent, self.noise_power, samples.speckle, samples.noise, self.noise_square, doubt
        )

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
        if not needed(heights.gain, known, sea_size(residual, heights.gain, known)).any():
            return heights, ambiguous
        resolved = self._cycles(residual, np.sqrt(wrapped_variance(variance)), heights, known)
        if resolved.cycles.any():
            heights = self.model.heights_of(cells, residual + 2.0 * np.pi * resolved.cycles)
        # Where mean sea level alone turns the phase by a radian within a pulse, neighbours cannot be followed.
        blurred = known & (self.model.turn_within_pulse > 1.0) & (len(self.others()) == 0)
        return heights, resolved.ambiguous | blurred

    def heights_near(self, cells: Covariance, before: Heights) -> Heights:
        """Heights of averaged cells, on the cycles that are nearest to an earlier map's phases."""
        residual = self.model.residual(cells)
        if self.settings.ambiguity == "fold":
            return self.model.heights_of(cells, residual)
        cycles = np.round((before.phase - self.model.flat - residual) / (2.0 * np.pi))
        return self.model.heights_of(cells, residual + 2.0 * np.pi * np.nan_to_num(cycles))

    def _cycles(self, residual: Map, spread: Map, heights: Heights, known: NDArray[np.bool_]) -> Resolved:
        radar = self.model.radar
        across = radar.ranges * np.radians(self.width)
        gain = np.broadcast_to(self.model.rise_sign, heights.gain.shape) * heights.gain
        return resolve(residual, spread, gain, known, radar.spacing, across, *self.others())
