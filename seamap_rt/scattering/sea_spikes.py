"""Sea spikes: breakers as single events that run with their wave, grow, fade, and carry the breaking share's echo.

`breaking` gives the share q of the sea that breaks and how waves of all lengths λ make it up: fronts of a length Λ per
area, each with a zone c_q/k long along its way. Here the fronts are cut into breakers of a length r λ, a Poisson
process in space and time. A breaker of waves with the phase speed c

    is born anywhere, at any time, and runs a way about the wind's that is drawn from the model's own distribution;
    lives for 0.3 of the wave's period 2πc/g in the mean, exponentially distributed, as whitecaps do (Korinenko,
    Malinovsky, Dulov & Kudryavtsev, from a platform in the Black Sea), cut off at four times the scale;
    grows and fades as g(s) = 6 s (1 − s), s the share of its life that is over, with the mean 1;
    runs at c, on the water's own current, and its echo has the Doppler of c (Lee et al. 1995: fast scatterers);
    echoes as a zone of the area a = c_q r 2π/k² would, all of it from its crest, a line r λ long across its way: the
    bulge at the crest of a spilling breaker returns 9/10 of its HH (Radio Sci. 2003, 10.1029/2002RS002716).

At any time n = q η/a of a class of waves live per area, η its share of the breaking area. So the sum over breakers of
a g, per area, has the mean q, and the factor that it puts on a facet's breaking echo the mean 1 whatever the facet's
size: the mean echo and its calibration stay as they are. Places and times on the resolved waves are Kudryavtsev's
criterion, saturation to the power of 6 (`breaking_share`): a breaker is as much brighter as the breaking
share of its place is larger than the sea's, so that crests and forward faces break and troughs do not. Barthelemy's
(2018) criterion, water that runs faster than 0.85 of its crest, was measured beside it: on a sum of linear waves its
area doubles with each octave of waves that the mesh carries (validation/models/scattering.md).

How spiky that is. A cell weighs the sea by W and has the area A = (∫W)²/∫W². By Campbell's theorem the sum over the
process of a g W has the mean ∫W Σ n a⟨g⟩ and the variance ∫W² Σ n a²⟨g²⟩, ⟨g⟩ = 1, ⟨g²⟩ = 6/5. A gamma distribution so
spread has the shape

    ν = mean²/variance = A q/(6/5 Σ η a)

for cells longer than a crest; smaller is spikier. On waves 1/ν_all = 1/ν_waves + b² (⟨s²⟩/⟨s⟩²)/ν, s the breaking share
from place to place as it is lit, b the breakers' part of the mean echo.

What was chosen. r = 0.1 brings the texture of HH of one sea (`choppy_sea`, seeds 1 to 6) to the law of Watts & Wicks
(1990); it is the one number that was. Waves that run faster than U10/1.68 break as no single events: half the peak's
speed in a developed sea, and all of it in a young one, is the fastest that Korinenko, Malinovsky & Kudryavtsev (2018)
saw break. Nor do those so short that they add less than 2 % to Σ η a. Both stay a share of each facet.

Λ(c) falls as c^−5.4 from 1 to 2 m/s and c^−6.0 from 3 to 4 (8 m/s of wind), as Phillips' (1985) c⁻⁶. Its level is
Kudryavtsev's, whose few fronts are fitted to radars' echoes: foam that lives as long would cover 1/40 of what Monahan &
O'Muircheartaigh (1980) saw, taken from 2 m/s on. Of more fronts with the same echo in all HH would be smoother.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import GRAVITY
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.scattering.breaking import COVERAGE, breaking_fronts

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
    def remaining_share(self) -> float:
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
    k, angle, front = breaking_fronts(wind_speed, inverse_wave_age, frequency_hz)
    area = 0.5 * COVERAGE * front  # the breaking share per ln k and angle
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


_LOSS = {"VV": 1.0, "HH": 1.7}  # of log10 ν
GRAZING_DEG = (0.1, 10.0)


def clutter_shape_watts_wicks90(grazing_deg: float, area_m2: float, polarization: str) -> float:
    """Shape ν of the K-distribution that measured seas' echoes have, the mean over looks of log ν; NaN beyond the law.

    log₁₀ ν = 2/3 log₁₀ ψ° + 5/8 log₁₀ A − K for grazing angles ψ of 0.1–10° and cells of A m² (Watts & Wicks 1990),
    good to a factor of two or three.
    """
    if not GRAZING_DEG[0] <= grazing_deg <= GRAZING_DEG[1]:
        return float("nan")
    return grazing_deg ** (2.0 / 3.0) * area_m2**0.625 * 10.0 ** -_LOSS[polarization]
