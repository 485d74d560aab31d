"""How the errors of neighbouring dwells and gates go together: what of one gate's error its neighbours share.

To first order the phase of a gate is off by Im(y'y*)/|y|², y the gate's voltage and y' what differs between the
receivers: noise, the same scatterers at other heights (rough), or the same scatterers with the phase that the surface
turns through within the pulse (tilt). The covariance of y'y* over gates follows from the response p of the receiver:

- noise: ρ(d) R(d), ρ the noise's own correlation and R = ∫ p(s) p(s − d) ds that of the echo,
- rough: R²,
- tilt: QR − X², where Q = ∫ s p(s) (s − d) p(s − d) ds and X = ∫ s p(s) p(s − d) ds. A bright spot between two gates
  moves both to it, but from opposite sides, so that means over gates err less than a gate's own error says. For a
  Gaussian pulse this is −½ (R²)''. Where bright spots are taken off, what is left has BrightSpots.covariance.

Gaussian moments: Goodman, Speckle Phenomena in Optics (2007), ch. 2.

What the errors of the motion sensors add to those of heights, by their stated sizes and by how the boat moves.

A tilt δα along the look, a height δz and a bearing δψ that are measured wrong make r² ⟨δα²⟩ + ⟨δz²⟩ + r² s² ⟨δψ²⟩ at a
ground range r, s² the mean square slope across the look. Each mean square is that of the readings' noise, as far as a
height keeps it, of what stays for a turn, as the sensors' maker states it, and of what latency τ and straight lines
between readings T apart make of a course α: α″T²/12 − τα′ in the mean, and α″²T⁴/720 about it. Biases are not looked
for: on a sea of long waves a tilt of the whole map is as likely the sea's.

Where in a gate its echo comes from, as the powers of the gates beside it tell, and what that does to its phase.

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
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from ..radar.pose import boat_axes
from ..radar.waveform import RangeResponse
from ..settings import SensorErrors
from .description import RadarDescription
from .speckle import DwellPulses

if TYPE_CHECKING:
    import xarray as xr


_POINTS = 401  # of the integrals over the pulse's main lobe


@dataclass(frozen=True)
class GateMoments:
    """Means ⟨…⟩ over scatterers that lie at random, over the mean power of a gate.

    y is a gate's voltage; y' that of the same scatterers, each times its distance s from the gate's middle; the second
    gate lies a lag [m], of any shape, beyond the first. offset [m]: s; heard: the pulse's response p(s).
    """

    response: RangeResponse
    offset: Map
    heard: Map

    @classmethod
    def of(cls, response: RangeResponse) -> GateMoments:
        """Of a pulse, of a chirp its main lobe."""
        offset = np.linspace(-response.support_m, response.support_m, _POINTS)
        return cls(response, offset, response(offset))

    def echo(self, lag: Map) -> Map:
        """A = ⟨y₁ y₂*⟩, 1 at lag 0."""
        return _means(self.response, lag)[0]

    def moved(self, lag: Map) -> Map:
        """X = ⟨y'₁ y₂*⟩ [m], odd in the lag."""
        return _means(self.response, lag)[1]

    def both_moved(self, lag: Map) -> Map:
        """Q = ⟨y'₁ y'₂*⟩ [m²]."""
        return _means(self.response, lag)[2]

    def means(self, lag: Map) -> Map:
        """(3, …): A, X and Q."""
        offset, heard = self._second(lag)
        moved = self.offset * self.heard
        return np.stack([self._sum(heard, self.heard), self._sum(heard, moved), self._sum(offset * heard, moved)])

    def _second(self, lag: Map) -> tuple[Map, Map]:
        """The second gate's offsets, and its response: of the main lobe alone as well, or moments of several gates
        would be those of no echo at all."""
        offset = self.offset - np.asarray(lag)[..., None]
        return offset, np.where(np.abs(offset) <= self.offset[-1], self.response(offset), 0.0)

    def _sum(self, other: Map, own: Map) -> Map:
        return np.asarray(other @ own / (self.heard @ self.heard))


def _means(response: RangeResponse, lag: Map) -> Map:
    """The means of a response at lags, known from turn to turn."""
    lags = np.asarray(lag, dtype=np.float64)
    return _cached_means(response, lags.tobytes(), lags.shape)


@lru_cache(maxsize=64)
def _cached_means(response: RangeResponse, lags: bytes, shape: tuple[int, ...]) -> Map:
    means = GateMoments.of(response).means(np.frombuffer(lags).reshape(shape))
    means.flags.writeable = False
    return means


Map = NDArray[np.float64]

_LEAST_CORRELATION = 5e-3  # a smaller correlation is none


@dataclass(frozen=True)
class ErrorCovariance:
    """Of heights of single dwells and gates.

    parts (part, look, gate): standard deviations [m] of the errors by tilt, roughness and noise, infinite where there
    is no height; along (part, gates): their correlations at that many gates' distance; beside: that of speckle between
    neighbouring looks.
    """

    parts: Map
    along: Map
    beside: float

    @property
    def variance(self) -> Map:
        """(look, gate) m²."""
        return np.sum(self.parts**2, axis=0)

    @property
    def mean_variance(self) -> Map:
        """(look, gate) m²: variance of a mean over many alike, times their number."""
        along = np.maximum(1.0 + 2.0 * self.along[:, 1:].sum(axis=1), 0.0)
        along[:2] *= 1.0 + 2.0 * self.beside
        with np.errstate(invalid="ignore"):  # nothing of infinity
            return np.nan_to_num(np.tensordot(along, self.parts**2, 1), nan=np.inf, posinf=np.inf)


def correlation_by_range(response: RangeResponse, lags: NDArray[np.floating], spots: BrightSpots | None = None) -> Map:
    """Correlations (tilt, rough, noise; lag) of errors at those distances [m]; lags[0] = 0.

    spots: whose estimate has been taken off the phases.
    """
    moments, lags = GateMoments.of(response), np.asarray(lags, dtype=np.float64)
    echo = moments.echo(lags)
    tilt = moments.both_moved(lags) * echo - moments.moved(lags) ** 2 if spots is None else spots.covariance(lags)
    found = np.stack((tilt / tilt[0], echo**2, response.noise_correlation(lags) * echo))
    return found[:, : 1 + int(np.flatnonzero(np.any(np.abs(found) > _LEAST_CORRELATION, axis=0))[-1])]


def correlation_beside(dwelt: DwellPulses) -> float:
    """Correlation of the speckle's errors between the dwells of neighbouring looks.

    From that of the pulses, of which the last of one dwell follow the first of the next; half at most, as for two
    dwells that share half of their pulses.
    """
    square = np.abs(dwelt.correlation[: dwelt.pulses]) ** 2
    lag = np.arange(square.size)
    within = dwelt.pulses + 2.0 * float(((dwelt.pulses - lag) * square)[1:].sum())
    return min(0.5, float((lag * square).sum()) / within)


_LOOKS = 2.0  # that a height is found from, where the echo is strong: by runs with noisy sensors of 20 to 1000 Hz
_SHARES = (np.arange(64) + 0.5) / 64.0  # of the time that they last
_DEGREE = 4  # of a course through a turn, which is shorter than the boat's periods


def sensor_variance(echoes: xr.Dataset, radar: RadarDescription, width: float, ground_range: Map, slope: Map) -> Map:
    """Mean square errors [m²] (look, gate) of a turn's heights by the sensors; 0 where the echoes do not tell of them.

    width: degrees between looks; ground_range [m] and slope across the look (look, gate), NaN where unknown.
    """
    errors, known = radar.sensors, np.isfinite(slope)
    if errors is None or errors == SensorErrors():
        return np.zeros(ground_range.shape)
    lasting = radar.period * (1.0 if radar.staring else width / 360.0)
    kept = variance_kept(min(errors.rate_hz, 1.0 / radar.interval) * lasting)
    east, north, heading, height = _motion_errors(echoes, errors, radar.interval)
    tilt = kept * errors.attitude_noise_deg**2 + errors.attitude_accuracy_deg**2 + 0.5 * (east + north)
    turn = kept * errors.heading_noise_deg**2 + errors.heading_accuracy_deg**2 + heading
    up = kept * errors.position_noise_m**2 + errors.height_accuracy_m**2 + height
    steep = float(np.sum(slope[known] ** 2)) / max(1, np.count_nonzero(known))
    return np.radians(np.nan_to_num(ground_range)) ** 2 * (tilt + turn * steep) + up


def variance_kept(readings: float) -> float:
    """Of independent readings, `readings` to a look: A(x) = 2 ∫₀¹ (1 − u) B(x u) du of one's, over a height's looks.

    Straight lines between readings have the cubic B-spline B for their correlation, B(0) = 2/3.
    """
    apart = readings * _LOOKS * _SHARES
    beside = np.where(apart < 1.0, 2.0 / 3.0 - apart**2 + 0.5 * apart**3, np.clip(2.0 - apart, 0.0, 1.0) ** 3 / 6.0)
    return 2.0 * float(np.mean((1.0 - _SHARES) * beside))


def _motion_errors(echoes: xr.Dataset, errors: SensorErrors, interval: float) -> Map:
    """Mean squares over the turn of what latency and straight lines make of the lean towards east and north, of the
    heading [deg²] and of the height [m²]. interval: between pulses [s]."""
    when, attitude = echoes["time"].values, echoes["attitude"].values
    up, heading = boat_axes(attitude)[:, 2], np.unwrap(attitude[:, 2], period=360.0)
    lean = np.degrees(np.arctan(up[:, :2] / up[:, 2:]))
    course = np.column_stack((lean, heading, echoes["position"].values[:, :, 2].mean(axis=1)))
    half = max(0.5 * float(np.ptp(when)), 1e-9)
    at = (when - when.mean()) / half
    fit = polynomial.polyfit(at, course, min(_DEGREE, when.size - 1))
    speed, bent = (polynomial.polyval(at, polynomial.polyder(fit, n)) / half**n for n in (1, 2))
    bent *= 0.0 if errors.rate_hz * interval >= 1.0 else errors.rate_hz**-2.0
    return np.mean((bent / 12.0 - errors.latency_s * speed) ** 2 + bent**2 / 720.0, axis=1)


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

    def shrink_for_speckle(self, variance: Map, looks: float) -> Offsets:
        """The offsets of phases to which speckle of so many looks gives a variance [rad²].

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
        explained = near * made[0] + far * made[1]
        return made, np.clip(1.0 - explained / whole, 0.0, 1.0)

    def covariance(self, lags: Map) -> Map:
        """⟨n n'⟩ of what is left, n = δ u less its estimate [m²], in gates at those distances [m]: of gates of the mean
        power, without noise."""
        moments, nothing = self.moments, np.zeros(())
        weights = self.weights(np.ones(()), nothing, nothing)[0]
        away, lag = self.spacing * self.neighbours, lags[:, None, None]
        here, there = away[:, None], away

        def moved_echo(at: Map) -> Map:
            return moments.moved(at) * moments.echo(at)

        def powers(at: Map) -> Map:
            return moments.echo(at) ** 2

        whole = 0.5 * (moments.both_moved(lags) * moments.echo(lags) - moments.moved(lags) ** 2)
        cross = (moved_echo(lags[:, None] + away) - moved_echo(lags[:, None] - away)) @ weights
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
        phase, explained = np.zeros(power.shape), np.zeros(power.shape)
        gates, reach = power.shape[1], int(self.neighbours[-1])
        inner = slice(reach, gates - reach)
        if gates <= 2 * reach:
            return Offsets(phase, 1.0 - explained)

        def shift(field: NDArray, away: int) -> NDArray:
            return field[:, reach + away : gates - reach + away]

        away = [int(each) for each in self.neighbours]
        known = shift(heard, 0) & np.logical_and.reduce([shift(sampled, n) for n in (*away, *(-n for n in away))])
        explained[:, inner] = np.where(known, 1.0 - left[:, inner], 0.0)
        for weight, n in zip(weights, away, strict=True):
            difference = (shift(even, n) - shift(even, -n)) * (level / mean)[:, inner] / own[:, inner]
            # Between scatterers so far apart the phase may turn by radians: its sine counts.
            apart = 0.5 * n * self.spacing
            phase[:, inner] += np.where(
                known, weight[:, inner] * difference * np.sin(turn[:, inner] * apart) / apart, 0.0
            )
        return Offsets(phase, 1.0 - explained)


def _level(power: Map, heard: NDArray[np.bool_]) -> Map:
    """Mean power (1, gate) of the looks that are heard; 1 where none is."""
    mean = power.sum(axis=0, where=heard) / np.maximum(heard.sum(axis=0), 1)
    return np.where(mean > 0.0, mean, 1.0)[None]
