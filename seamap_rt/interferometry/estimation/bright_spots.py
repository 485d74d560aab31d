"""Where in a gate its echo comes from, as the powers of the gates beside it tell, and what that does to its phase.

Along a surface the phase turns by τ rad/m. An echo that comes mostly from a place δ beyond the middle of its gate
therefore has a phase that is off by τ δ. At steep looks this is most of the error, whether speckle or the waves made
that place bright.
With y the gate's voltage and y' that of the same scatterers, each times its distance from the gate's middle,
δ = Re(y'y*)/|y|². For a Gaussian pulse that is σ² d ln|y|²/dR exactly (Tweedie's formula; Efron 2011), so that the
powers tell it: a gate whose farther neighbour is the stronger hears its own far side. For any pulse the best linear
estimate from differences D of the neighbours' powers, given the gate's own power u in terms of the mean, follows from
Gaussian moments (Goodman, Speckle Phenomena in Optics, 2007, ch. 2):

    δ u = c u (u G + H + noise)⁻¹ D,   D_n = P(R + n d) − P(R − n d),

c is what y' and the differences have in common through y, G what the differences have in common through y, and H what
they have in common through scatterers that the gate itself does not hear. Of a faded gate (u → 0) the differences tell
nothing, and nothing is taken off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...radar.waveform import RangeResponse
from .error_covariance import GateMoments


_STEP = 0.8  # of the pulse's standard deviation: nearer neighbours tell no more of a Gaussian pulse, farther ones less
_FIRST = 1.9  # by Gaussian speckle drawn at random: of pulses whose phase turns by 0.2 to 1.4 rad within their spread
_FAINTEST = 0.02  # of the mean power, or of the noise: what is less counts as that


@dataclass(frozen=True)
class Offsets:
    """What bright spots do to phases; (look, gate).

    phase [rad]: by how much each is off, as far as the powers tell; left: share of such errors' variance that they do
    not tell.
    """

    phase: Map
    left: Map

    def of_large(self, variance: Map, looks: float) -> Offsets:
        """The same of phases to which speckle of so many looks gives a variance [rad²].

        The powers tell of a phase's first order alone. What a correction of first order explains falls with the
        phase's variance v as exp(−(_FIRST v)² looks) =: f; so the best one is (1 + f)/2 of it.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            part = 0.5 * (1.0 + np.exp(-looks * (_FIRST * variance) ** 2))
        return Offsets(part * self.phase, 1.0 - part**2 * (1.0 - self.left))


@dataclass(frozen=True)
class BrightSpots:
    """Gaussian moments of the powers of a gate and of two pairs of neighbours, in terms of the mean power."""

    neighbours: NDArray[np.intp]  # (pair,) gates to either side
    spacing: float  # m, of gates
    moments: GateMoments
    shared: Map  # (pair,) c [m]
    through: Map  # (pair, pair) G
    own: Map  # (pair, pair) H
    beat: Map  # (pair, pair) of the noise with the mean echo, per noise over signal
    beat_more: Map  # (pair, pair) and what it has more by as much as u exceeds 1
    hiss: Map  # (pair, pair) of the noise with itself, per its square

    @classmethod
    def of(cls, response: RangeResponse, spacing: float) -> BrightSpots:
        """Of gates that lie `spacing` [m] apart."""
        neighbours = max(1, round(_STEP * response.spread_m / spacing)) * np.array([1, 2])
        moments, lag = GateMoments.of(response), spacing * neighbours
        apart, over = lag[:, None] - lag, lag[:, None] + lag
        echo, noise = moments.echo, response.noise_correlation
        through = echo(lag)[:, None] * echo(lag)
        return cls(
            neighbours,
            spacing,
            moments,
            2.0 * echo(lag) * moments.moved(lag),
            4.0 * through * (echo(apart) - echo(over)),
            2.0 * ((echo(apart) - through) ** 2 - (echo(over) - through) ** 2),
            4.0 * (echo(apart) * noise(apart) - echo(over) * noise(over)),
            4.0 * through * (noise(apart) - noise(over)),
            2.0 * (noise(apart) ** 2 - noise(over) ** 2),
        )

    def weights(self, power: Map, beat: Map, hiss: Map) -> tuple[Map, Map]:
        """Of D in δ u [m], (pair, …), and the share (…) of δ's variance that is left.

        power (…): u; beat, hiss (…): how much noise the powers have, for a sample of speckle and in terms of the mean
        echo: noise over signal and its square, over the samples of noise that they are means of.
        """
        more = beat * (power - 1.0)
        first, both, second = (
            power * self.through[pair]
            + self.own[pair]
            + beat * self.beat[pair]
            + more * self.beat_more[pair]
            + hiss * self.hiss[pair]
            for pair in ((0, 0), (0, 1), (1, 1))
        )
        # Of gates much closer than the pulse is long both pairs tell nearly the same.
        determinant = np.maximum(first * second - both**2, 1e-9 * first * second)
        near, far = self.shared
        made = power * np.stack((near * second - far * both, far * first - near * both)) / determinant
        whole = 0.5 * float(self.moments.both_moved(np.zeros(())))
        told = near * made[0] + far * made[1]
        return made, np.clip(1.0 - told / whole, 0.0, 1.0)

    def covariance(self, lags: Map) -> Map:
        """⟨n n'⟩ of what is left, n = δ u less its estimate [m²], in gates at those distances [m]: of gates of the mean
        power, without noise."""
        moments, nothing = self.moments, np.zeros(())
        weights = self.weights(np.ones(()), nothing, nothing)[0]
        away, lag = self.spacing * self.neighbours, lags[:, None, None]
        here, there = away[:, None], away

        def told(at: Map) -> Map:
            return moments.moved(at) * moments.echo(at)

        def powers(at: Map) -> Map:
            return moments.echo(at) ** 2

        whole = 0.5 * (moments.both_moved(lags) * moments.echo(lags) - moments.moved(lags) ** 2)
        cross = (told(lags[:, None] + away) - told(lags[:, None] - away)) @ weights
        differences = powers(lag + there - here) + powers(lag - there + here)
        differences -= powers(lag - there - here) + powers(lag + there + here)
        return whole - 2.0 * cross + differences @ weights @ weights

    def offsets(
        self, power: Map, mean: Map, heard: NDArray[np.bool_], noise_power: float, ratio: float, turn: Map
    ) -> Offsets:
        """Of echoes of that power, and mean power about them [W], on a surface that turns the phase by `turn` [rad/m].

        All (look, gate); unknown beside gates without an echo in any look. noise_power [W]: of a receiver, of which two
        are averaged; ratio: independent samples of noise over those of speckle. The growth of power along the range
        that all looks share is left to `gate_edge`.
        """
        sampled = np.isfinite(power) & heard.any(axis=0)
        power = np.maximum(np.nan_to_num(power), 0.0)
        mean = np.maximum(np.maximum(np.nan_to_num(mean), _FAINTEST * noise_power), _FAINTEST * power)
        mean = np.where(heard & (mean > 0.0), mean, 1.0)
        own, noise = np.maximum(power / mean, _FAINTEST), noise_power / mean
        weights, left = self.weights(own, 0.5 * noise / ratio, 0.5 * noise**2 / ratio)
        level = _level(power, heard)
        even = power / level
        phase, told = np.zeros(power.shape), np.zeros(power.shape)
        gates, reach = power.shape[1], int(self.neighbours[-1])
        inner = slice(reach, gates - reach)
        if gates <= 2 * reach:
            return Offsets(phase, 1.0 - told)

        def beside(field: NDArray, away: int) -> NDArray:
            return field[:, reach + away : gates - reach + away]

        away = [int(each) for each in self.neighbours]
        known = beside(heard, 0) & np.logical_and.reduce([beside(sampled, n) for n in (*away, *(-n for n in away))])
        told[:, inner] = np.where(known, 1.0 - left[:, inner], 0.0)
        for weight, n in zip(weights, away, strict=True):
            difference = (beside(even, n) - beside(even, -n)) * (level / mean)[:, inner] / own[:, inner]
            # Between scatterers so far apart the phase may turn by radians: its sine counts.
            apart = 0.5 * n * self.spacing
            phase[:, inner] += np.where(
                known, weight[:, inner] * difference * np.sin(turn[:, inner] * apart) / apart, 0.0
            )
        return Offsets(phase, 1.0 - told)


def _level(power: Map, heard: NDArray[np.bool_]) -> Map:
    """Mean power (1, gate) of the looks that are heard; 1 where none is."""
    mean = power.sum(axis=0, where=heard) / np.maximum(heard.sum(axis=0), 1)
    return np.where(mean > 0.0, mean, 1.0)[None]
