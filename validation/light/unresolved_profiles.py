"""Smith's law for small waves on resolved ones, against exact horizons on profiles that carry both.

    python -m validation.light.unresolved_profiles [--profiles 120]

Profiles along a look, 450 m at steps of 2 cm: a JONSWAP sea up to a wavenumber, the wind's short waves (Elfouhaily
1997) from there to the roughness that scatters, and the running maximum of the elevation angle without and with the
latter. No mesh, tracer or table of the program is used. Printed, of 25–400 m: what the small waves hide, what the law
takes of the points lit without them, what they light of dark points, and by how much what is seen lies higher on them
than their mean. Twenty seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamap_rt.scattering import ShortWaves
from seamap_rt.sea import spectra

from ..analytic.shadowing import shadowing_smith67
from ..options import options

Array = NDArray[np.floating]
STEP_M, POINTS, NEAR_M, FAR_M = 0.02, 22_500, 25.0, 400.0
_GRAVITY = 9.81


@dataclass(frozen=True)
class Case:
    """A wave system, the wind, where the mesh's waves end [rad/m], the mast, and the look against waves and wind."""

    hs: float = 1.4
    tp: float = 5.5
    wind: float = 8.0
    limit: float = 3.93
    mast: float = 5.0
    look_deg: float = 0.0


CASES = {
    "choppy_sea": Case(),
    "across": Case(look_deg=90.0),
    "10 m mast": Case(mast=10.0),
    "0.3 m 3 s, wind 2 m/s": Case(0.3, 3.0, 2.0, 6.28),
    "0.7 m 4 s, 3 m mast": Case(0.7, 4.0, 6.0, 6.28, 3.0),
    "2.5 m 8 s, 8 m mast": Case(2.5, 8.0, 10.0, 2.0, 8.0),
    "4 m 10 s, 20 m mast": Case(4.0, 10.0, 15.0, 1.6, 20.0),
    "2 m 12 s swell": Case(2.0, 12.0, 5.0, 2.0, 6.0),
    "mesh to 6.3 m waves": Case(limit=1.0),
    "mesh to 0.4 m waves": Case(limit=15.0),
    "nearly flat": Case(hs=0.05, tp=4.0),
}


def along(look: Array, level: Array, k: Array, spread: Callable[[Array, Array], Array]) -> Array:
    """Variance at each wavenumber `look` of a profile from S(k) `level` and its spreading."""
    angle = 2.0 * np.pi * (np.arange(720) + 0.5) / 720
    share = spread(k[:, None], angle)
    power = (level * np.gradient(np.log(k)) * k)[:, None] * share / share.sum(axis=1, keepdims=True)
    edges = np.concatenate(([0.0], 0.5 * (look[1:] + look[:-1]), [2.0 * look[-1]]))
    return np.histogram(np.abs(k[:, None] * np.cos(angle)), edges, weights=power)[0]


def wavenumbers() -> Array:
    """Of a profile [rad/m]."""
    return 2.0 * np.pi * np.arange(1, POINTS // 2) / (STEP_M * POINTS)


def both(case: Case, look: Array) -> tuple[Array, Array]:
    """Variances of the resolved and of the small waves by wavenumber along the look."""
    turned = np.radians(case.look_deg)
    k = np.geomspace(1e-3, case.limit, 3000)
    level = spectra.jonswap(np.sqrt(_GRAVITY * k), hs=case.hs, tp=case.tp, gamma=3.3) * 0.5 * np.sqrt(_GRAVITY / k)
    long = along(look, level, k, lambda _, angle: np.abs(np.cos(0.5 * (angle - turned))) ** 20 + 0.0 * _)
    short, k = ShortWaves(case.wind, case.limit), np.geomspace(case.limit, 200.0, 4000)
    level = short.spectrum(k) - short.roughness(k, short.divide(2.0 * np.pi / 0.03))
    return long, along(look, level, k, lambda k, angle: 1.0 + short.contrast(k) * np.cos(2.0 * (angle - turned)))


def drawn(random: np.random.Generator, variance: Array, points: int = POINTS, order: int = 0) -> list[Array]:
    """A profile (point,) and its derivatives up to an order; the same waves for any number of points."""
    made = np.zeros(points // 2 + 1, dtype=complex)
    made[1 : variance.size + 1] = 0.5 * points * np.sqrt(variance) * (random.normal(size=(variance.size, 2)) @ [1, 1j])
    k = 2.0 * np.pi * np.arange(made.size) / (STEP_M * POINTS)
    return [np.fft.irfft(made * (1j * k) ** n, points) for n in range(order + 1)]


def visible(x: Array, height: Array, eye: float) -> NDArray[np.bool_]:
    rise = np.full(x.size, -np.inf)
    rise[x > 1.0] = (height[x > 1.0] - eye) / x[x > 1.0]
    return rise >= np.maximum.accumulate(rise)


def judged(case: Case, profiles: int) -> Array:
    """Shares of the window that are hidden by horizons, hidden by the law, lit of the dark; and the height [m]."""
    look = wavenumbers()
    long, short = both(case, look)
    slope, x, random = np.sqrt(short @ look**2), STEP_M * np.arange(POINTS), np.random.default_rng(7)
    window = (x >= NEAR_M) & (x < FAR_M)
    sums = np.zeros(4)
    for _ in range(profiles):
        (sea,), (small,) = drawn(random, long), drawn(random, short)
        before, after = visible(x, sea, case.mast)[window], visible(x, sea + small, case.mast)[window]
        grazing = (np.gradient(sea, x) + (case.mast - sea) / np.maximum(x, 1.0))[window]
        law = before * shadowing_smith67(np.maximum(grazing, 0.0) / (np.sqrt(2.0) * slope))
        shares = before.mean() - after.mean(), before.mean() - law.mean(), (after & ~before).mean()
        sums += [*shares, np.mean(after * small[window]) / max(after.mean(), 1e-9)]
    return sums / profiles


def main() -> None:
    arguments = options(__doc__, profiles=120)
    print(f"{'% of the window':26}{'hidden':>9}{'by the law':>12}{'lit of dark':>13}{'height, mm':>12}")
    for name, case in CASES.items():
        hidden, law, lit, height = judged(case, arguments.profiles)
        print(f"{name:26}{100 * hidden:9.2f}{100 * law:12.2f}{100 * lit:13.2f}{1000 * height:12.1f}", flush=True)


if __name__ == "__main__":
    main()
