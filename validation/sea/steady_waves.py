"""Steep waves of constant form, exactly, and how perturbations of them grow: what a nonlinear sea is judged by.

Lengths in 1/k and times in 1/√(g k): wavenumber 1, gravity 1. Nothing here comes from the package.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

HARMONICS = 20
_EASY = 0.2  # a steeper wave is found from a less steep one
_TIMES = 6  # Newton's: 1e-3 becomes 1e-6, 1e-12, rounding


@dataclass(frozen=True)
class SteadyWave:
    """η and φ = Σ B_j f_j(z) sin jθ, θ = x − ct, in the frame without mean flow (Rienecker & Fenton 1981)."""

    depth: float
    speed: float  # c
    surface: NDArray[np.float64]  # η at θ = π i/n, i = 0 … n
    strength: NDArray[np.float64]  # B_j, j = 1 … n

    @property
    def harmonics(self) -> NDArray[np.float64]:
        """Amplitudes of cos jθ in η, j = 0 … n."""
        count = self.strength.size
        even = np.concatenate((self.surface, self.surface[-2:0:-1]))
        return np.fft.rfft(even).real / count * np.where(np.arange(count + 1) % count, 1.0, 0.5)

    def elevation(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.cos(np.outer(theta, np.arange(self.strength.size + 1))) @ self.harmonics

    def flow(self, theta: NDArray[np.float64], z: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        """φ and its derivatives at places (θ, z)."""
        j = np.arange(1, self.strength.size + 1)
        f, h = vertical(j, z[:, None], self.depth)
        sine, cosine = np.sin(np.outer(theta, j)), np.cos(np.outer(theta, j))
        b = self.strength
        return {
            "potential": (f * sine) @ b,
            "u": (f * cosine) @ (j * b),
            "w": (h * sine) @ (j * b),
            "u_z": (h * cosine) @ (j**2 * b),
            "w_z": (f * sine) @ (j**2 * b),
        }


def vertical(j: NDArray, z: NDArray, depth: float) -> tuple[NDArray, NDArray]:
    """cosh j(z + d)/cosh jd and sinh j(z + d)/cosh jd."""
    if np.isinf(depth):
        return np.exp(j * z), np.exp(j * z)
    return np.cosh(j * (z + depth)) / np.cosh(j * depth), np.sinh(j * (z + depth)) / np.cosh(j * depth)


def steady_wave(steepness: float, depth: float = np.inf, harmonics: int = HARMONICS) -> SteadyWave:
    """The wave whose half height is `steepness`, by Newton's method on its 2 harmonics + 4 equations."""
    count = harmonics
    theta = np.pi * np.arange(count + 1) / count
    cosine, sine = (function(np.outer(theta, np.arange(1, count + 1))) for function in (np.cos, np.sin))
    weights = np.full(count + 1, 1.0 / count)
    weights[[0, -1]] *= 0.5
    j = np.arange(1, count + 1)
    level = np.exp(-j * steepness)  # B_j are asked for as they are at the crest, where they matter

    def misses(unknown: NDArray, half_height: float) -> NDArray:
        surface, b = unknown[: count + 1], level * unknown[count + 1 : 2 * count + 1]
        speed, stream, head = unknown[2 * count + 1 :]
        f, h = vertical(j, surface[:, None], depth)
        along, up = -speed + (f * cosine) @ (j * b), (h * sine) @ (j * b)
        return np.concatenate(
            (
                -speed * surface + (h * cosine) @ b + stream,
                0.5 * (along**2 + up**2) + surface - head,
                [weights @ surface, surface[0] - surface[-1] - 2.0 * half_height],
            )
        )

    speed, begin = np.sqrt(np.tanh(depth)), min(steepness, _EASY)
    found = np.concatenate((begin * np.cos(theta), np.zeros(count), [speed, 0.0, 0.5 * speed**2]))
    found[count + 1] = begin / speed / level[0]
    for half_height in (*np.arange(_EASY, steepness, 0.025), steepness):
        for _ in range(_TIMES):
            # Derivatives without differences: Im F(x + ih)/h is exact for so small an h.
            rates = [np.imag(misses(found + 1e-30j * each, half_height)) * 1e30 for each in np.eye(found.size)]
            found = found - np.linalg.solve(np.array(rates).T, misses(found, half_height))
    assert np.abs(misses(found, steepness)).max() < 1e-12, steepness
    return SteadyWave(depth, float(found[2 * count + 1]), found[: count + 1], level * found[count + 1 : 2 * count + 1])


@dataclass(frozen=True)
class Mode:
    """A perturbation e^{σt} e^{ipθ} Σ (a_j, b_j) e^{ijθ} of a steady deep-water wave, seen as it moves."""

    rate: complex  # σ
    places: NDArray[np.float64]  # θ over one wave
    surface: NDArray[np.complex128]  # η' without e^{ipθ}
    potential: NDArray[np.complex128]  # of φ at the moving surface, likewise: φ' + w η'


def fastest_mode(wave: SteadyWave, p: float, reach: int = 14) -> Mode:
    """The perturbation of wavenumber p that grows most (McLean 1982): the conditions at the surface, linearised about
    the wave, at 2 reach + 1 places."""
    j = np.arange(-reach, reach + 1)
    theta = 2.0 * np.pi * np.arange(j.size) / j.size
    eta = wave.elevation(theta)
    flow = wave.flow(theta, eta)
    u, w = flow["u"] - wave.speed, flow["w"]
    j_wave = np.arange(wave.strength.size + 1)
    slope = -np.sin(np.outer(theta, j_wave)) @ (j_wave * wave.harmonics)
    bare = np.exp(1j * np.outer(theta, j))
    kappa = np.abs(p + j)
    decay = np.exp(kappa * eta[:, None]) * bare  # φ' at the surface
    along, up = 1j * (p + j) * decay, kappa * decay
    slopes = 1j * (p + j) * bare
    # φ'_t = −(u φ'_x + w φ'_z + η' (1 + u u_z + w w_z));  η'_t = φ'_z − φ'_x η_x − u η'_x − η' (u_z η_x − w_z)
    pressure = 1.0 + u * flow["u_z"] + w * flow["w_z"]
    right = np.block(
        [
            [-u[:, None] * slopes - (flow["u_z"] * slope - flow["w_z"])[:, None] * bare, up - slope[:, None] * along],
            [-pressure[:, None] * bare, -u[:, None] * along - w[:, None] * up],
        ]
    )
    left = np.block([[bare, np.zeros_like(bare)], [np.zeros_like(bare), decay]])
    rates, modes = (np.asarray(each, dtype=np.complex128) for each in eig(right, left)[:2])
    best = int(np.argmax(np.where(np.abs(rates) < 1.5, np.real(rates), -np.inf)))
    a, b = modes[: j.size, best], modes[j.size :, best]
    surface = bare @ a
    potential = np.asarray(decay @ b + w * surface, dtype=np.complex128)
    return Mode(complex(rates[best]), theta, surface, potential)


def fenton85(steepness: float, depth: float) -> tuple[float, NDArray[np.float64]]:
    """Speed and amplitudes of cos jθ, j = 1 … 5, of the fifth-order wave, as printed (Fenton 1985, table 1)."""
    e, s, coth = steepness, 0.0 if np.isinf(depth) else 1.0 / np.cosh(2.0 * depth), 1.0 / np.tanh(depth)
    b22 = coth * (1 + 2 * s) / (2 * (1 - s))
    b31 = -3 * (1 + 3 * s + 3 * s**2 + 2 * s**3) / (8 * (1 - s) ** 3)
    fourth = (3 + 2 * s) * (1 - s) ** 4
    b42 = coth * (6 - 26 * s - 182 * s**2 - 204 * s**3 - 25 * s**4 + 26 * s**5) / (6 * fourth)
    b44 = coth * (24 + 92 * s + 122 * s**2 + 66 * s**3 + 67 * s**4 + 34 * s**5) / (24 * fourth)
    fifth = (3 + 2 * s) * (4 + s) * (1 - s) ** 6
    b53 = 9 * np.polyval([82, 467, 194, -2687, -6292, -5897, -2216, 17, 132], s) / (128 * fifth)
    b55 = 5 * np.polyval([130, 827, 1326, 675, 1188, 2949, 3176, 1579, 300], s) / (384 * fifth)
    c2 = (2 + 7 * s**2) / (4 * (1 - s) ** 2)
    c4 = np.polyval([146, -71, -400, -116, 32, 4], s) / (32 * (1 - s) ** 5)
    speed = np.sqrt(np.tanh(depth)) * (1 + e**2 * c2 + e**4 * c4)
    first = e + e**3 * b31 - e**5 * (b53 + b55)
    harmonics = [first, e**2 * b22 + e**4 * b42, -(e**3) * b31 + e**5 * b53, e**4 * b44, e**5 * b55]
    return float(speed), np.array([float(each) for each in harmonics])
