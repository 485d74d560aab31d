"""Skewness and kurtosis of nonlinear seas beside theory, and steady waves beside published tables, number by number.

    python -m validation.sea.wave_statistics [--only published,bound,dynamic] [--waves 1024] [--seeds 1:7]

  published  greatest error of the vertical velocity W of exact steady waves: this program's, beside what Dommermuth &
             Yue (1987) printed and what HOS-ocean (Ducrozet et al. 2016) finds with products wholly de-aliased
  bound      skewness and the bound waves' part of the kurtosis
  dynamic    the part of the kurtosis that four-wave interactions make, against time

Long-crested deep-water seas with a Gaussian spectrum, of steepness ε = k₀σ and relative bandwidth δ in frequency (2δ in
wavenumber), begun as linear waves. Excess kurtosis = bound + dynamic, to order ε² and for δ → 0:

Bound. A wave of action N is a cos θ + ½ka² cos 2θ + ⅜k²a³ cos 3θ, with k²a² = k²a₀²(1 − ¼k²a₀²), a₀ the linear wave's
of the same action: momentum is kN, and Stokes' wave has ω₀a²(1 + ¼k²a²)/2. Averaged over Rayleigh's a₀ harmonics give
21 ε², and the first one's lack gives 24 · (−⅛) ε²: 18 ε² in all, as Janssen (2009; coded in ECMWF's WAM) has it. Mori
& Janssen (2006) had 24 ε². The skewness is 3 ∬ S S min(k₁, k₂)/σ³ (Longuet-Higgins 1963), 3ε if narrow.

Dynamic. Schrödinger's equation, first order in the nonlinearity, of an envelope that begins as Gaussian (Janssen 2003):

    κ(t) = 6 BFI² ∫₀ᵗ r(t′) K(ω₀δ²(t − t′)) ω₀δ² dt′,  K(s) = Im (1 − 2is + 3s²)^(−½),  BFI = √2 ε/δ,

r the share of the nonlinear rates that act. It tends to π/√3 BFI² (Mori & Janssen 2006). Limits: BFI ≪ 1, δ ≪ 1, long
crests: with spreading the dynamic part fades (Fedele 2015). What is measured is the kurtosis of the waves of 0.4 to
1.6 k₀ less that of the same sea left linear; their bound part −3 ε² is taken off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import GRAVITY
from seamap_rt.sea.high_order import Band, Evolution, State

from ..options import options
from .published_waves import DOMMERMUTH_YUE, HOS_OCEAN, velocity_error

LENGTH = 100.0  # m
K = 2.0 * np.pi / LENGTH
OMEGA = float(np.sqrt(GRAVITY * K))
PERIOD = 2.0 * np.pi / OMEGA
STEPS = 16  # a period
RELAXING = 5.0  # periods
ORDER = 3
REACH = 3.6  # the shortest wave, in k₀: what is bound at third order


def published() -> None:
    print("greatest error of W/(g/k)^½       order 2                        order 4")
    print("  ka   modes        here   HOS-ocean  D & Y 1987       here   HOS-ocean  D & Y 1987")
    for steepness, modes in DOMMERMUTH_YUE:
        row = f"{steepness:5.2f} {modes:6d}"
        for number, order in enumerate((2, 4)):
            found = velocity_error(steepness, modes, order)
            theirs = HOS_OCEAN[steepness, modes][number], DOMMERMUTH_YUE[steepness, modes][number]
            row += f"   {found:10.1e} {theirs[0]:10.1e} {theirs[1]:10.1e}"
        print(row)


def kernel(s: NDArray[np.float64]) -> NDArray[np.float64]:
    """K(s): Im of ⟨exp(isxy)⟩ of two normal numbers of variance 2 and covariance 1."""
    return np.imag(1.0 / np.sqrt(1.0 - 2.0j * s + 3.0 * s**2))


def dynamic_kurtosis(steepness: float, width: float, periods: NDArray[np.float64]) -> NDArray[np.float64]:
    """κ at so many periods after the nonlinear rates began to set in."""
    pace, found = 2.0 * np.pi * width**2, []
    for end in periods:
        s = np.linspace(0.0, pace * end, 4001)
        acts = -np.expm1(-((s / (pace * RELAXING)) ** 4))
        found.append(float(np.trapezoid(acts * kernel(s[-1] - s), s)))
    return 12.0 * (steepness / width) ** 2 * np.array(found)


@dataclass(frozen=True)
class Basin:
    """A line of water, and the waves on it."""

    waves: int
    steepness: float
    width: float

    @property
    def band(self) -> Band:
        return Band(self.waves * LENGTH, self.waves * LENGTH, int(REACH * self.waves), 0, np.inf)

    @property
    def spectrum(self) -> NDArray[np.float64]:
        """Of each wave, m²."""
        k = self.band.east[0] / K
        shape = np.exp(-0.5 * ((k - 1.0) / (2.0 * self.width)) ** 2) * (k > 0.2) * (k < 1.8)
        return (self.steepness / K) ** 2 * shape / shape.sum()

    @property
    def skewness(self) -> float:
        k, spectrum = self.band.east[0], self.spectrum
        return 3.0 * float(spectrum @ np.minimum(k[:, None], k) @ spectrum) / float(spectrum.sum()) ** 1.5

    def linear(self, seed: int) -> State:
        """Gaussian waves of exactly that steepness."""
        band, random = self.band, np.random.default_rng(seed)
        normal = random.normal(size=(1, self.spectrum.size, 2)).view(np.complex128)[..., 0]
        elevation = 0.5 * np.sqrt(self.spectrum) * normal
        elevation *= self.steepness / K / np.sqrt(2.0 * np.sum(np.abs(elevation) ** 2))
        potential = -1j * elevation * band.omega / np.where(band.rise > 0.0, band.rise, np.inf)
        return State(0.0, elevation, potential)

    def first(self, waves: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Those of the first harmonic."""
        k = self.band.east / K
        return waves * ((k > 0.4) & (k < 1.6))

    def heights(self, waves: NDArray[np.complex128]) -> NDArray[np.float64]:
        return self.band.to_points(waves, (1, 4 * self.band.most_x))[0]

    def envelope(self, waves: NDArray[np.complex128]) -> NDArray[np.float64]:
        """|A| of the first harmonic."""
        points = 4 * self.band.most_x
        return np.abs(np.fft.ifft(2.0 * self.first(waves)[0], points, norm="forward"))


def kurtosis(values: NDArray[np.float64]) -> float:
    return float(np.mean(values**4) / np.mean(values**2) ** 2)


def harmonics_kurtosis(envelope: NDArray[np.float64]) -> float:
    """What second and third harmonics add to the kurtosis of a narrow sea with that envelope; 21 ε² of Rayleigh's."""
    two, four, six = (float(np.mean((K * envelope) ** power)) for power in (2, 4, 6))
    return (0.375 * four + 0.5625 * six) / (0.5 * two + 0.125 * four) ** 2 - 1.5 * four / two**2


def bound(waves: int, seeds: range) -> None:
    """After ten periods, when all rates act and four-wave interactions have done little."""
    print("                  skewness/ε              harmonics' kurtosis/ε²           first harmonic, a/a₀ − 1")
    print("  ε      δ     found   Longuet-H.     found  of envelope  Rayleigh     found     −(ka)²/8")
    for steepness, width in ((0.01, 0.02), (0.01, 0.05), (0.02, 0.05), (0.04, 0.05), (0.02, 0.1)):
        basin, rows = Basin(waves, steepness, width), []
        evolution = Evolution(basin.band, ORDER, PERIOD / STEPS, relaxed_from=0.0, relaxing=RELAXING * PERIOD)
        for seed in seeds:
            state = evolution.advanced(basin.linear(seed), 10 * STEPS)
            heights, first = basin.heights(state.elevation), basin.heights(basin.first(state.elevation))
            third = [float(np.mean(each**3) / np.mean(each**2) ** 1.5) for each in (heights, first)]
            more = kurtosis(heights) - kurtosis(first), harmonics_kurtosis(basin.envelope(state.elevation))
            rows.append([(third[0] - third[1]) / steepness, *(each / steepness**2 for each in more)])
        skewness, found, local = np.mean(rows, axis=0)
        alone = regular_wave(np.sqrt(2.0) * steepness)
        print(
            f"{steepness:5.2f} {width:6.2f} {skewness:8.3f} {basin.skewness / steepness:10.3f} {found:11.2f} "
            f"{local:10.2f} {21.0:10.0f} {alone:14.3e} {-(steepness**2) / 4.0:12.3e}",
            flush=True,
        )


def regular_wave(steepness: float) -> float:
    """a/a₀ − 1 of the first harmonic of a wave begun slowly as linear, the mean over a period."""
    band = Band(LENGTH, LENGTH, 8, 0, np.inf)
    elevation = np.zeros(band.shape, complex)
    elevation[0, 1] = 0.5 * steepness / K
    state = State(0.0, elevation, -1j * elevation * band.omega / np.where(band.rise > 0.0, band.rise, np.inf))
    evolution = Evolution(band, ORDER, PERIOD / 40, relaxed_from=0.0, relaxing=RELAXING * PERIOD)
    state, found = evolution.advanced(state, 400), []
    for _ in range(40):
        state = evolution.advanced(state)
        found.append(2.0 * abs(state.elevation[0, 1]) * K / steepness)
    return float(np.mean(found)) - 1.0


def dynamic(waves: int, seeds: range) -> None:
    for steepness, width, periods in ((0.005, 0.025, 240), (0.01, 0.05, 120), (0.02, 0.1, 30), (0.04, 0.1, 30)):
        basin = Basin(waves, steepness, width)
        step = PERIOD / STEPS
        evolution = Evolution(basin.band, ORDER, step, relaxed_from=0.0, relaxing=RELAXING * PERIOD)
        still = Evolution(basin.band, 1, step)
        at, grown = periods * np.arange(1, 7) / 6, []
        for seed in seeds:
            state = linear = basin.linear(seed)
            grown.append([])
            for _ in at:
                state, linear = (
                    each.advanced(one, periods * STEPS // 6) for each, one in ((evolution, state), (still, linear))
                )
                first = kurtosis(basin.heights(basin.first(state.elevation)))
                grown[-1].append(first - kurtosis(basin.heights(linear.elevation)) + 3.0 * steepness**2)
        mean, spread = np.mean(grown, axis=0), np.std(grown, axis=0) / np.sqrt(max(1, len(seeds) - 1))
        bfi = np.sqrt(2.0) * steepness / width
        print(f"ε = {steepness:g}, δ = {width:g}: BFI = {bfi:.2f}, π/√3 BFI² = {np.pi / np.sqrt(3.0) * bfi**2:.4f}")
        for label, row in (("periods", at), ("theory", dynamic_kurtosis(steepness, width, at)), ("found", mean)):
            print(f"  {label:8}" + "".join(f"{value:9.4g}" for value in row))
        print("  ±       " + "".join(f"{value:9.2g}" for value in spread), flush=True)


def main() -> None:
    chosen = options(__doc__, only="published,bound,dynamic", waves=1024, seeds="1:7")
    seeds = range(*(int(each) for each in chosen.seeds.split(":")))
    sections = {"published": published, "bound": lambda: bound(chosen.waves, seeds)}
    sections["dynamic"] = lambda: dynamic(chosen.waves, seeds)
    for name in chosen.only.split(","):
        sections[name]()


if __name__ == "__main__":
    main()
