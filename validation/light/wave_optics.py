"""The field on a rough profile, from the boundary integral equations of two-dimensional waves, exact but for what is
scattered back.

A line source stands over a profile h(x). Of the total field ψ in the air above, e^{+jωt}, Green's theorem leaves on
the surface, with n its upward normal and G = −(j/4) H₀⁽²⁾(k r),

    E across the plane of incidence (HH), ψ = 0 there:    ½ ∂ₙψ = ∂ₙψᵢ − ∫ ∂ₙG ∂ₙψ ds′
    H across it (VV), ∂ₙψ = jkα ψ there:                  ½ ψ = ψᵢ + ∫ (∂ₙ′G − jkα G) ψ ds′

with α the water's impedance over that of free space, 0 of a perfect conductor. Near grazing, waves run outward: the
integrals are taken over x′ ≤ x alone, in one march. That is the first sweep of Holliday, DeRaad & St-Cyr (IEEE Trans.
Antennas Propag. 44(5), 722–729, 1996) and Kapp & Brown (44(5), 711–721). Of ∫ G ψ the part x′ > x is that of a wave
which goes on as it arrives, 2/(πk) of ∫₀^∞ H₀⁽²⁾(kr) e^{−jkr} dr. Water at X band is all but a conductor to HH: its
reflection is −1 + 2 sin ψ/√ε, sin ψ of the grazing angle.

What is small on the surface answers with these fields squared, once each way (reciprocity): echoes go as |∂ₙψ|⁴ and
|ψ|⁴.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import hankel2

from seamap_rt.compute.compiled import compiled

Array = NDArray[np.floating]
Complex = NDArray[np.complex128]
_NEAR = 20.0  # k r from which on two terms of Hankel's asymptotic series are good to 2e-5
_BEGINS_M = 3.0
_ENTRIES = 4096  # of the table of nearer ones, by even 1/(k r)


@dataclass(frozen=True)
class Profile:
    """Heights (point,) [m] at even x [m], with their first two derivatives."""

    x: Array
    height: Array
    slope: Array
    bend: Array  # h″, 1/m

    @property
    def step(self) -> float:
        return float(self.x[1] - self.x[0])


@dataclass(frozen=True)
class SurfaceField:
    """Fields (point,) over that of the free source: ½ ∂ₙψ/(jk ψᵢ), on a level conductor the sine of the grazing angle;
    ½ ψ/ψᵢ, which is 1 there."""

    hh: Complex
    vv: Complex
    vv_conductor: Complex


def surface_field(
    profile: Profile, source_m: tuple[float, float], wavelength: float, impedance: complex
) -> SurfaceField:
    """Those of a line source at (x, z), before the profile, whose steps may be a quarter of a wave at most.

    ValueError otherwise. The surface fades in over 3 m, so that its beginning bends no light.
    """
    k = 2.0 * np.pi / wavelength
    away, up = profile.x - source_m[0], profile.height - source_m[1]
    if away[0] <= 0.0 or profile.step > 0.2501 * wavelength:
        raise ValueError("the source must stand before the profile, and steps be a quarter of a wave at most")
    reach, stretch = np.hypot(away, up), np.sqrt(1.0 + profile.slope**2)
    begun = np.sin(0.5 * np.pi * np.clip((profile.x - profile.x[0]) / _BEGINS_M, 0.0, 1.0)) ** 2
    free = np.exp(-1j * k * (reach - profile.x)) / np.sqrt(reach)  # the march's unknowns go without e^{−jkx}
    incident = 1j * k * sine_of_grazing(profile, source_m) * (1.0 - 0.5j / (k * reach)) * free
    parts = [np.zeros((3, reach.size)) for _ in range(2)]
    surface = profile.x, profile.height, profile.slope, profile.bend, stretch, begun, begun * stretch
    tables = (_near_waves(order, k * profile.step) for order in (0, 1))
    _march(*surface, k, complex(impedance), incident, free, *tables, *parts)
    hh, vv, conductor = parts[0] + 1j * parts[1]
    return SurfaceField(hh / (2j * k * free), 0.5 * vv / free, 0.5 * conductor / free)


def sine_of_grazing(profile: Profile, source_m: tuple[float, float]) -> Array:
    """(point,) of the angle under which the surface itself meets the straight ray; negative where it turns away."""
    away, up = profile.x - source_m[0], profile.height - source_m[1]
    return (profile.slope * away - up) / (np.sqrt(1.0 + profile.slope**2) * np.hypot(away, up))


def _near_waves(order: int, nearest: float) -> Complex:
    """H⁽²⁾ over √(2/πt) e^{−j(t − π/4)} at even 1/t from 0 to 1/nearest, the last once more."""
    t = 1.0 / np.maximum(np.linspace(0.0, 1.0 / nearest, _ENTRIES + 1), 1e-4)
    table = hankel2(order, t) * np.exp(1j * (t - 0.25 * np.pi)) * np.sqrt(0.5 * np.pi * t)
    return np.append(table, table[-1])


@compiled
def _march(x, height, slope, bend, stretch, begun, arc, k, impedance, incident, free, table0, table1, real, imag):
    """Fill (3, point) real and imag: ∂ₙψ of HH, ψ of VV over an impedance and over a conductor, times e^{jkx}."""
    step = x[1] - x[0]
    scale = np.sqrt(2.0 / (np.pi * k))
    eighth = np.exp(0.25j * np.pi)
    steps_near = int(_NEAR / (k * step)) + 1
    per_entry = k * step * _ENTRIES
    half = np.sqrt(0.5)
    for i in range(x.size):
        last = max(0, i - steps_near)
        hr = hi = sr = si = cr = ci = tr = ti = 0.0
        xi, zi, slant = x[i], height[i], slope[i]
        for j in range(last):
            dx = xi - x[j]
            dz = zi - height[j]
            square = dx * dx + dz * dz
            over = 1.0 / np.sqrt(square)
            r = square * over
            late = k * dz * dz / (r + dx)
            turns = np.floor(late * (0.5 / np.pi) + 0.5)
            y = 0.5 * (late - turns * (2.0 * np.pi))
            q = y * y
            s = y * (1.0 + q * (-1 / 6 + q * (1 / 120 + q * (-1 / 5040 + q * (1 / 362880 - q / 39916800)))))
            c = 1.0 + q * (-0.5 + q * (1 / 24 + q * (-1 / 720 + q * (1 / 40320 + q * (-1 / 3628800 + q / 479001600)))))
            sine, cosine = 2.0 * s * c, 1.0 - 2.0 * s * s
            size = np.sqrt(over) * step
            # e^{j(π/4 − late)}
            er, ei = size * half * (cosine + sine), size * half * (cosine - sine)
            f = over / k
            # H₀: 1 + j f/8 − 9 f²/128; H₁: j (1 − 3j f/8 + 15 f²/128)
            ar, ai = 1.0 - 9.0 / 128.0 * f * f, 0.125 * f
            br, bi = 0.375 * f, 1.0 + 15.0 / 128.0 * f * f
            h0r, h0i = er * ar - ei * ai, er * ai + ei * ar
            h1r, h1i = er * br - ei * bi, er * bi + ei * br
            at_i = (dz - slant * dx) * over * arc[j]  # (n·d/r) ds, times the stretch at i
            at_j = (dz - slope[j] * dx) * over * begun[j]  # (n′·d/r) ds′
            hr += at_i * (h1r * real[0, j] - h1i * imag[0, j])
            hi += at_i * (h1r * imag[0, j] + h1i * real[0, j])
            sr += at_j * (h1r * real[1, j] - h1i * imag[1, j])
            si += at_j * (h1r * imag[1, j] + h1i * real[1, j])
            tr += arc[j] * (h0r * real[1, j] - h0i * imag[1, j])
            ti += arc[j] * (h0r * imag[1, j] + h0i * real[1, j])
            cr += at_j * (h1r * real[2, j] - h1i * imag[2, j])
            ci += at_j * (h1r * imag[2, j] + h1i * real[2, j])
        of_h = scale * complex(hr, hi)
        of_s, of_t, of_c = scale * complex(sr, si), scale * complex(tr, ti), scale * complex(cr, ci)
        for j in range(last, i):
            dx = xi - x[j]
            dz = zi - height[j]
            r = np.sqrt(dx * dx + dz * dz)
            place = per_entry / (k * r)
            entry = min(int(place), _ENTRIES - 1)
            part = place - entry
            late = k * dz * dz / (r + dx)
            wave = scale * step / np.sqrt(r) * eighth * complex(np.cos(late), -np.sin(late))
            h0 = wave * (table0[entry] + part * (table0[entry + 1] - table0[entry]))
            h1 = wave * (table1[entry] + part * (table1[entry + 1] - table1[entry]))
            at_i = (dz - slant * dx) / r * arc[j]
            at_j = (dz - slope[j] * dx) / r * begun[j]
            of_h += at_i * h1 * complex(real[0, j], imag[0, j])
            v = complex(real[1, j], imag[1, j])
            of_s += at_j * h1 * v
            of_t += arc[j] * h0 * v
            of_c += at_j * h1 * complex(real[2, j], imag[2, j])
        # the point itself, half a step of it before: ∂ₙG is h″/(4π g³) there, and ds = g dx
        itself = 0.5 * step * bend[i] / (4.0 * np.pi * stretch[i] ** 2)
        hh = (incident[i] - 0.25j * k / stretch[i] * of_h) / (0.5 + itself)
        # k ∫ of H₀ over that half step, and beyond the point: 2/π of a wave that goes on
        small = 0.5 * k * step * stretch[i]
        own = small * (1.0 - 2.0j / np.pi * (np.log(0.5 * small) + np.euler_gamma - 1.0)) + 2.0 / np.pi
        vv = (free[i] - 0.25j * k * of_s - 0.25 * k * impedance * of_t) / (0.5 - itself + 0.25 * impedance * own)
        conductor = (free[i] - 0.25j * k * of_c) / (0.5 - itself)
        real[0, i], imag[0, i] = hh.real, hh.imag
        real[1, i], imag[1, i] = vv.real, vv.imag
        real[2, i], imag[2, i] = conductor.real, conductor.imag
