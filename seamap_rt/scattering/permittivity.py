"""Sea water as a dielectric, and how a flat piece of it reflects. Time factor e^{+jωt}: ε = ε′ − jε″."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_FREQUENCIES_HZ = (1e9, 90e9)
_TEMPERATURES_C = (-2.0, 34.0)
_SALINITIES_PSU = (0.0, 40.0)
_VACUUM = 17.97510  # GHz·m/S: 1/(2π ε0), which turns a conductivity in S/m into a loss


def permittivity_meissner_wentz12(
    frequency_hz: ArrayLike, temperature_c: ArrayLike, salinity_psu: ArrayLike
) -> NDArray[np.complex128]:
    """Relative permittivity ε′ − jε″ of sea water by a double Debye law; the arguments broadcast.

    Meissner & Wentz, IEEE Trans. Geosci. Remote Sens. 42(9), 1836–1849 (2004), with the saline coefficients
    of their 50(8), 3004–3026 (2012); conductivity after Stogryn et al. (1995). ValueError outside 1–90 GHz,
    −2–34 °C, 0–40 psu.
    """
    f = _within("frequency_hz", frequency_hz, _FREQUENCIES_HZ) / 1e9
    t = _within("temperature_c", temperature_c, _TEMPERATURES_C)
    s = _within("salinity_psu", salinity_psu, _SALINITIES_PSU)

    # pure water: static value, first relaxation [GHz], intermediate value, second relaxation, optical value
    e0 = (3.70886e4 - 82.168 * t) / (421.854 + t)
    e1 = 5.7230 + 2.2379e-2 * t - 7.1237e-4 * t**2
    f1 = (45.0 + t) / (5.0478 - 7.0315e-2 * t + 6.0059e-4 * t**2)
    e2 = 3.6143 + 2.8841e-2 * t
    f2 = (45.0 + t) / (0.13652 + 1.4825e-3 * t + 2.4166e-4 * t**2)

    # what the salt changes (the T³ coefficient is negative: one printed table has its sign wrong)
    e0 = e0 * np.exp(-0.33330e-2 * s + 4.74868e-6 * s**2)
    cool = 0.23232e-2 - 0.79208e-4 * t + 0.36764e-5 * t**2 - 0.35594e-6 * t**3 + 0.89795e-8 * t**4
    warm = 9.1873715e-4 + 1.5012396e-4 * (t - 30.0)
    f1 = f1 * (1.0 + s * np.where(t <= 30.0, cool, warm))
    e1 = e1 * np.exp(-6.28908e-3 * s + 1.76032e-4 * s**2 - 9.22144e-5 * s * t)
    f2 = f2 * (1.0 + s * (-1.99723e-2 + 0.5 * 1.81176e-4 * (t + 30.0)))
    e2 = e2 * (1.0 + s * (-2.04265e-3 + 1.57883e-4 * t))

    relaxations = (e0 - e1) / (1.0 + 1j * f / f1) + (e1 - e2) / (1.0 + 1j * f / f2) + e2
    return np.asarray(relaxations - 1j * _conductivity_stogryn95(t, s) * _VACUUM / f)


def fresnel(incidence: ArrayLike, permittivity: ArrayLike) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Voltage reflection coefficients (r_h, r_v) of a flat half-space at an incidence [rad].

    The arguments broadcast. At vertical incidence r_v = −r_h, since each is referred to the vertical plane's
    own axes.
    """
    theta = np.asarray(incidence, dtype=np.float64)
    eps = np.asarray(permittivity, dtype=np.complex128)
    cosine = np.cos(theta).astype(np.complex128)
    below = np.sqrt(eps - np.sin(theta) ** 2)  # the principal root decays downwards, since Im ε < 0
    return (cosine - below) / (cosine + below), (eps * cosine - below) / (eps * cosine + below)


def _conductivity_stogryn95(t: NDArray[np.float64], s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ionic conductivity of sea water [S/m] at t [°C] and s [psu]."""
    at_35 = 2.903602 + 8.60700e-2 * t + 4.738817e-4 * t**2 - 2.9910e-6 * t**3 + 4.3047e-9 * t**4
    at_15 = s * (37.5109 + 5.45216 * s + 1.4409e-2 * s**2) / (1004.75 + 182.283 * s + s**2)
    a0 = (6.9431 + 3.2841 * s - 9.9486e-2 * s**2) / (84.850 + 69.024 * s + s**2)
    a1 = 49.843 - 0.2276 * s + 0.198e-2 * s**2
    return at_35 * at_15 * (1.0 + (t - 15.0) * a0 / (a1 + t))


def _within(name: str, value: ArrayLike, limits: tuple[float, float]) -> NDArray[np.float64]:
    array = np.asarray(value, dtype=np.float64)
    low, high = limits
    outside = ~((array >= low) & (array <= high))
    if np.any(outside):
        worst = array[outside].flat[0]
        raise ValueError(
            f"{name} = {worst:g}: Meissner & Wentz's permittivity holds for {low:g} to {high:g}; give a value within"
        )
    return array
