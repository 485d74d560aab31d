"""Sea spikes: breakers as single events that run with their wave, grow and fade, and carry the breaking share's echo.

`breaking` gives the share q of the sea that breaks and how it is made up of waves of all lengths λ: fronts of a length Λ
per area, each with a zone c_q/k long along its way. Here the fronts are cut into breakers of a length r λ. They are a
Poisson process in space and time. A breaker of a wave with the phase speed c

    is born anywhere, with a way about the wind's that is drawn from the model's own distribution,
    lives for a time that is exponentially distributed about 0.3 of the wave's period 2πc/g (Korinenko, Malinovsky,
    Dulov & Kudryavtsev, "lifetime of whitecaps", Black Sea platform), cut off at four times that,
    grows and fades as g(s) = 6 s (1 − s), s the share of its life that is over, with a mean of 1,
    runs at c, on the water's own current, and echoes from its crest, a line r λ long across its way,
    as a zone of the area a = c_q r 2π/k² would: the crest's bulge returns 9/10 of HH (West et al. 2002, Radio Sci. 37).

At any time there are n = q η/a of a class of waves per area, η its share of the breaking area. So the sum over breakers
of a g, per area, has the mean q: the factor that it puts on a facet's breaking echo has the mean 1, whatever the
facet's size, and the mean echo and its calibration are those without spikes. Where the resolved waves gather the short
ones, breakers are as much brighter as the breaking share is larger there (`modulation.breaking_share`: Kudryavtsev's
spectrum to the power of 6), so that crests and forward faces break and troughs do not.

**How spiky that is.** A cell weighs points of the sea by W; A = (∫W)²/∫W² is its area. By Campbell's theorem the sum of
a g W over a Poisson process has the mean ∫W Σ n a ⟨g⟩ and the variance ∫W² Σ n a² ⟨g²⟩, with ⟨g⟩ = 1, ⟨g²⟩ = 6/5. The
gamma distribution with the same two moments has the shape

    ν = mean²/variance = A q / (6/5 Σ η a),

for cells that are longer than a crest. Smaller is spikier; ν grows with the cell, and falls with wind, since the
breaking area grows faster than the zone that an average part of it belongs to. A cell's whole texture adds the resolved waves'
own: 1/ν_all = 1/ν_waves + ⟨s²⟩/⟨s⟩² b²/ν for a breaking share s of the sea's places, and b of the mean echo.

Waves too short to matter stay a share of each facet: the shortest whose a add up to 2 % of Σ η a. r = 0.1 (see below).
Compare: Λ(c) of Phillips (1985) falls as c⁻⁶; Kudryavtsev's falls as c⁻⁵·⁸ from 1 to 2 m/s, more steeply beyond.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import GRAVITY
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.scattering.breaking import COVERAGE, breaking_area

CREST_LENGTH = 0.1  # r, of a breaker over its wave's length
LEAST_WIND = 1.68  # the wind's speed over that of the fastest waves that break as single events
LIFE_PERIODS = 0.3  # mean life over the wave's period
LONGEST_LIFE = 4.0  # over the scale of the exponential
BURST_SQUARE = 1.2  # ⟨g²⟩ of g(s) = 6 s (1 − s)
QUANTILES = 65  # of the way about the wind's, in the table of each class

_OCTAVE = 0.5  # of wavelength to a class
_LEFT = 0.02  # of Σ η a stays a share of each facet


@dataclass(frozen=True)
class SeaSpikes:
    """The breakers of one wind in classes of their waves' length; arrays (class,)."""

    fraction: float  # q, of the sea's area
    wavelength: NDArray[np.float64]  # m
    share: NDArray[np.float64]  # η, of the breaking area
    zone_m2: NDArray[np.float64]  # a, the area that a breaker stands for, the mean over its life
    life_s: NDArray[np.float64]  # mean
    speed: NDArray[np.float64]  # m/s, phase speed
    angle: NDArray[np.float64]  # (class, quantile) rad from the wind's way, at evenly spaced probabilities from 0 to 1
    left_speed: float  # m/s down-wind, the mean of the breakers that stay a share of each facet
    left_spread: float  # m/s, its standard deviation

    @property
    def left(self) -> float:
        """Share of the breaking area that stays a share of each facet."""
        return 1.0 - float(self.share.sum())

    @property
    def density(self) -> NDArray[np.float64]:
        """n (class,) 1/m², of breakers that live at one time."""
        return self.fraction * self.share / self.zone_m2

    @property
    def crest_m(self) -> NDArray[np.float64]:
        """(class,) m, length of a breaker's crest."""
        return CREST_LENGTH * self.wavelength

    @property
    def brightness_m2(self) -> NDArray[np.float64]:
        """(class,) m²: what a breaker at its mean adds to the factor of a facet, times that facet's area."""
        return self.zone_m2 / self.fraction

    def shape(self, area_m2: ArrayLike) -> NDArray[np.float64]:
        """ν = A q/(6/5 Σ η a) of cells of the area (∫W)²/∫W² [m²] on a level sea; inf where nothing breaks."""
        clumps = BURST_SQUARE * float(np.sum(self.share * self.brightness_m2))
        with np.errstate(divide="ignore"):
            return np.asarray(area_m2, dtype=np.float64) / clumps


@lru_cache(maxsize=32)
def sea_spikes(wind_speed: float, inverse_wave_age: float, frequency_hz: float) -> SeaSpikes | None:
    """Breakers of a wind [m/s at 10 m], from the waves' peak down; None where nothing breaks. Raises as `breakers`."""
    k, angle, area = breaking_area(wind_speed, inverse_wave_age, frequency_hz)
    step = np.log(k[1] / k[0])
    # The trapezoidal rule in ln k, as a sum: its weights on the wavenumbers.
    rule = np.full(k.size, step)
    rule[[0, -1]] *= 0.5
    by_wave = rule * np.trapezoid(area, angle, axis=1)
    fraction = float(by_wave.sum())
    if fraction == 0.0:
        return None
    length, celerity = 2.0 * np.pi / k, angular_frequency(k) / k
    zone = COVERAGE * CREST_LENGTH * 2.0 * np.pi / k**2
    slow = celerity <= wind_speed / LEAST_WIND
    clumps = np.cumsum((slow * by_wave * zone)[::-1])[::-1]  # of this wave and all shorter ones
    single = slow & (clumps > _LEFT * clumps[0])
    if not single.any():
        return None
    number = np.floor(np.log2(length / length[single].min()) / _OCTAVE).astype(int)
    members = [single & (number == each) & (by_wave > 0.0) for each in range(int(number.max()) + 1)]
    members = [each for each in members if each.any()]

    def mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.array([np.sum((by_wave * values)[each]) / by_wave[each].sum() for each in members])

    probability = np.linspace(0.0, 1.0, QUANTILES)
    tables = []
    for each in members:
        spread = np.sum((rule[:, None] * area)[each], axis=0)
        rising = np.concatenate(([0.0], np.cumsum(0.5 * (spread[1:] + spread[:-1]))))
        tables.append(np.interp(probability, rising / rising[-1], angle))
    downwind = celerity * np.trapezoid(area * np.cos(angle), angle, axis=1)
    square = celerity**2 * np.trapezoid(area * np.cos(angle) ** 2, angle, axis=1)
    rest = by_wave[~single].sum()
    left = float((rule * downwind)[~single].sum() / rest) if rest > 0.0 else 0.0
    left_square = float((rule * square)[~single].sum() / rest) if rest > 0.0 else 0.0
    speed = mean(celerity)
    return SeaSpikes(
        fraction=fraction,
        wavelength=mean(length),
        share=np.array([by_wave[each].sum() for each in members]) / fraction,
        zone_m2=mean(zone),
        life_s=LIFE_PERIODS * 2.0 * np.pi * speed / GRAVITY,
        speed=speed,
        angle=np.array(tables),
        left_speed=left,
        left_spread=float(np.sqrt(max(left_square - left**2, 0.0))),
    )
