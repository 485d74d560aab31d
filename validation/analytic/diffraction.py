"""The field behind a knife edge, by Fresnel's integrals, and on the faces of a wedge, by its eigenfunctions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import fresnel, hankel2, jv


def knife_edge(v: ArrayLike) -> NDArray[np.complex128]:
    """F = (1 + j)/2 ∫_v^∞ exp(−jπt²/2) dt: field behind a half plane over that without it, for time exp(+jωt).

    v = h √(2(d₁ + d₂)/(λ d₁ d₂)), the edge's height h over the straight ray in Fresnel's measure, positive in shadow:
    F → 1 for v → −∞, F(0) = ½. The half plane is black and the angles are small. Born & Wolf, Principles of Optics
    (7th ed., 1999), section 8.7.3; −20 log₁₀|F| is J(ν) of ITU-R P.526. Good to 1e-16 absolutely, so that in shadow its
    relative error grows as v.
    """
    sine, cosine = fresnel(np.asarray(v, dtype=np.float64))
    return 0.5 * (1.0 + 1.0j) * ((0.5 - cosine) - 1.0j * (0.5 - sine))


def wedge_faces(
    distance_m: float, source_m: float, source_angle: float, exterior_angle: float, wavelength_m: float
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Fields (face,) on both faces of a conducting wedge, at a distance from its edge, over those of a line source
    without it: ψ with H along the edge, and ∂ψ/∂n over k with E along it, n into the air; for time exp(+jωt).

    The source is source_m > distance_m from the edge, at an angle [rad] from the first face; the air fills
    exterior_angle. Eigenfunctions of the wedge (Macdonald, Electric Waves, 1902; Balanis, Advanced Engineering
    Electromagnetics, section 11.6), summed until the Bessel functions have died out. ValueError for a nearer source.
    """
    if not 0.0 < distance_m < source_m:
        raise ValueError(f"source_m = {source_m:g}: must be above distance_m = {distance_m:g}, and both above 0")
    k, n = 2.0 * np.pi / wavelength_m, exterior_angle / np.pi
    near, far = k * distance_m, k * source_m
    order = np.arange(int(n * (near + 10.0 * near ** (1.0 / 3.0) + 60.0))) / n
    radial = jv(order, near) * hankel2(order, far)
    angles = np.array([0.0, exterior_angle])
    reach = np.sqrt(distance_m**2 + source_m**2 - 2.0 * distance_m * source_m * np.cos(angles - source_angle))
    free = hankel2(0, k * reach)
    weight = np.where(order == 0.0, 1.0, 2.0)
    along_h = (np.cos(order * angles[:, None]) * weight * radial * np.cos(order * source_angle)).sum(axis=1)
    turned = order * np.cos(order * angles[:, None])
    along_e = (turned * 2.0 * radial * np.sin(order * source_angle)).sum(axis=1) / near
    return 2.0 / n * along_h / free, 2.0 / n * along_e * np.array([1.0, -1.0]) / free
