"""How a boat follows the waves under it: the plane that fits best the sea's surface within its waterline.

The waterline is a rectangle, length × beam. The boat heaves by the mean elevation within it, and leans by the slopes of
the least-squares plane over it. Both are linear in the waves, so each wave η = Re a exp(i(k·x − ωt)) acts by itself:
with p = k∥ length/2 along the keel and q = k⊥ beam/2 across it,

    heave  j₀(p) j₀(q),    slope ahead  i k∥ B(p) j₀(q),    slope to starboard  i k⊥ j₀(p) B(q),

j₀(p) = sin p/p and B(p) = 3 (sin p − p cos p)/p³, the weight of the least-squares line (∫ u exp(iku) du / ∫ u² du).
Waves much longer than the boat lift and tilt it as they are; much shorter ones do not move it. This is the boat's size
and nothing else: its dynamics, that is resonance and damping, the water that moves along and the hull's own waves, are
not modelled, nor do waves push it sideways (Salvesen, Tuck & Faltinsen 1970 is a theory of all that).

The boat keeps its course, so that it meets each wave at one frequency Ω = ω − k·v, v its velocity through the water.
Its motion is a sum of sines in time, kept as a B-spline whose coefficients are summed by stretches of time as these
are asked for (see `sea.spline`).
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike, NDArray

from ..conventions import unit_from_azimuth
from ..sea import Components, ResolvedWaves
from ..sea.spline import bspline_polynomials, bspline_transform

NEGLIGIBLE = 1e-4  # share of the variance of heave and of either slope that the waves left out hold at most
_ORDER = 7
_STEP_CYCLES = 0.15  # of the fastest encounter a step: the spline errs by 1e-6 of that one, and less of all others
_ROWS, _COLUMNS = 32, 16  # times of a stretch: coarse steps × fine steps, so that few exponentials are needed
_KNOTS = _ROWS * _COLUMNS
_LOOKS = np.pi * (np.arange(32) + 0.5) / 64.0  # rad between a wave and the look, a quarter of the circle
_STEPS = _KNOTS - _ORDER  # of a stretch: its last points take from the knots beyond it
_WAVES_AT_ONCE = 1 << 13


class WaveFollowing:
    """Heave and slopes of a boat on a straight course, at any times. Values do not depend on earlier calls.

    `omega` (wave,) rad/s are the frequencies of encounter (negative: the boat overtakes the wave), `response` (wave, 3)
    the complex amplitudes of heave [m], slope ahead and slope to starboard of the waves that matter:
    motion = Re Σ response exp(−i omega t).
    """

    def __init__(
        self,
        waves: Components,
        *,
        length_m: float,
        beam_m: float,
        heading_deg: float,
        velocity: tuple[float, float] = (0.0, 0.0),
        start: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """velocity: through the water, m/s east north; start: where the boat's middle is at time 0, m east north.

        The waves of a choppy sea, which displace the water sideways too, are taken as if they did not: first order in
        the waves' height. Where that is 1.4 m at 5.5 s, heave errs by 8 % of its rms and slopes by 20 % of theirs.
        """
        (east, north), k = unit_from_azimuth(heading_deg), waves
        ahead, starboard = k.east * east + k.north * north, k.east * north - k.north * east
        mean = _mean(0.5 * length_m * ahead), _mean(0.5 * beam_m * starboard)
        lean = _lean(0.5 * length_m * ahead), _lean(0.5 * beam_m * starboard)
        there = waves.amplitude * np.exp(1j * (k.east * start[0] + k.north * start[1]))
        response = np.stack((mean[0] * mean[1], 1j * ahead * lean[0] * mean[1], 1j * starboard * mean[0] * lean[1]))
        response = there * response
        kept = _strongest_rows(np.abs(response) ** 2)
        self.omega = (waves.omega - k.east * velocity[0] - k.north * velocity[1])[kept]
        self.response = response[:, kept].T
        fastest = float(np.max(np.abs(self.omega), initial=0.0))
        self.step = 2.0 * np.pi * _STEP_CYCLES / fastest if fastest > 0.0 else 1.0  # s, between the spline's knots
        self._taps = bspline_polynomials(_ORDER, 0)[0]
        self._stretches: dict[int, NDArray[np.float64]] = {}

    def __call__(self, times: ArrayLike) -> NDArray[np.float64]:
        """(n, 3) heave [m], slope ahead (up positive), slope to starboard, at times (n,) s, before 0 too."""
        position = np.asarray(times, dtype=np.float64) / self.step
        interval = np.floor(position)
        weights = polyval(position - interval, self._taps).T  # no matrix product, whose last bits hang on how many rows
        stretch, first = np.divmod(interval.astype(np.int64), _STEPS)
        result = np.empty((position.size, 3))
        for number in np.unique(stretch):
            inside = np.flatnonzero(stretch == number)
            knots = self._stretch(int(number))[first[inside, None] + np.arange(_ORDER + 1)]
            result[inside] = np.einsum("nt,ntq->nq", weights[inside], knots)
        return result

    def _stretch(self, number: int) -> NDArray[np.float64]:
        """The spline's coefficients (knot, 3) of one stretch of time."""
        if number not in self._stretches:
            start = number * _STEPS - (_ORDER - 1) // 2
            total = np.zeros((3 * _ROWS, _COLUMNS))
            for at in range(0, self.omega.size, _WAVES_AT_ONCE):
                waves = slice(at, at + _WAVES_AT_ONCE)
                turn = self.omega[waves] * self.step  # rad a step
                weight = self.response[waves].T / bspline_transform(_ORDER, turn / (2.0 * np.pi))
                coarse = _turning(np.exp(-1j * np.remainder(start * turn, 2.0 * np.pi)), -_COLUMNS * turn, _ROWS)
                fine = _turning(np.ones_like(coarse[0]), turn, _COLUMNS)
                rows = (weight[:, None, :] * coarse).reshape(3 * _ROWS, -1)
                # Re Σ rows · conj(fine), as a product of real numbers.
                total += rows.view(np.float64) @ fine.view(np.float64).T
            self._stretches[number] = total.reshape(3, _KNOTS).T.copy()
        return self._stretches[number]


def wave_tilt_std(waves: ResolvedWaves, length_m: float, beam_m: float) -> float:
    """Rms tilt [rad] along the look of a boat that lies in the plane that fits the waves within its waterline, to the
    first order in their slope; the mean over its headings and the looks."""
    square = 0.0
    for angle in _LOOKS:
        ahead, aside = waves.wavenumber * np.cos(angle), waves.wavenumber * np.sin(angle)
        p, q = 0.5 * length_m * ahead, 0.5 * beam_m * aside
        pitch, roll = ahead * _lean(p) * _mean(q), aside * _mean(p) * _lean(q)
        square += 0.5 * float(np.sum(waves.variance * (pitch**2 + roll**2))) / _LOOKS.size
    return float(np.sqrt(square))


def _turning(first: NDArray[np.complex128], turn: NDArray[np.float64], count: int) -> NDArray[np.complex128]:
    """(count, wave) first · exp(i n turn): products, which cost a tenth of exponentials."""
    steps = np.empty((count, first.size), dtype=np.complex128)
    steps[0], steps[1:] = first, np.exp(1j * turn)
    return np.cumprod(steps, axis=0, out=steps)


def _mean(phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean of exp(iku) over |u| ≤ l, phase = kl."""
    return np.sinc(phase / np.pi)


def _lean(phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Slope of the least-squares line through exp(iku) over |u| ≤ l, over its slope ik at 0; phase = kl."""
    small = np.abs(phase) < 0.05  # there the difference of sin p and p cos p loses digits, and the series none
    safe = np.where(small, 1.0, phase)
    return np.where(
        small, 1.0 - phase**2 / 10.0 + phase**4 / 280.0, 3.0 * (np.sin(safe) - safe * np.cos(safe)) / safe**3
    )


def _strongest_rows(power: NDArray[np.float64]) -> NDArray[np.int64]:
    """Numbers of the waves that remain when those are left out that hold least of all rows of power (row, wave)."""
    total = power.sum(axis=1, keepdims=True)
    share = np.max(power / np.where(total > 0.0, total, 1.0), axis=0, initial=0.0)
    order = np.argsort(share)
    return np.sort(order[np.cumsum(share[order]) > NEGLIGIBLE])
