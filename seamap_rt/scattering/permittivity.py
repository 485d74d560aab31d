"""Sea water as a dielectric, and how a flat piece of it reflects. Time factor e^{+jωt}: ε = ε′ − jε″."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.settings import ScatteringSettings

_Range: TypeAlias = tuple[float, float]
_VACUUM = 17.97510  # GHz·m/S: 1/(2π ε0), which turns a conductivity in S/m into a loss


def permittivity_klein_swift77(
    frequency_hz: ArrayLike, temperature_c: ArrayLike, salinity_psu: ArrayLike
) -> NDArray[np.complex128]:
    """Relative permittivity ε′ − jε″ of sea water by a single Debye law; the arguments broadcast.

    Klein & Swift, IEEE Trans. Antennas Propag. 25(1), 104–111 (1977): from measurements at 1.43 and 2.65 GHz, and
    trusted by its authors below X band. ValueError outside 1–35 GHz, −2–34 °C, 0–40 psu. That is wider than they
    ask, since all over it |ε| stays within 9 % of `permittivity_meissner_wentz12`, and within 5 % up to 10 GHz.
    """
    limits = (1e9, 35e9), (-2.0, 34.0), (0.0, 40.0)
    f, t, s = _checked("Klein & Swift", limits, frequency_hz, temperature_c, salinity_psu)
    static = 87.134 - 1.949e-1 * t - 1.276e-2 * t**2 + 2.491e-4 * t**3
    static = static * (1.0 + 1.613e-5 * s * t - 3.656e-3 * s + 3.210e-5 * s**2 - 4.232e-7 * s**3)
    relaxation = 1.768e-11 - 6.086e-13 * t + 1.104e-14 * t**2 - 8.111e-17 * t**3  # s
    relaxation = relaxation * (1.0 + 2.282e-5 * s * t - 7.638e-4 * s - 7.760e-6 * s**2 + 1.105e-8 * s**3)
    optical = 4.9
    debye = optical + (static - optical) / (1.0 + 2j * np.pi * f * 1e9 * relaxation)
    return np.asarray(debye - 1j * _conductivity_stogryn71(t, s) * _VACUUM / f)


def permittivity_meissner_wentz04(
    frequency_hz: ArrayLike, temperature_c: ArrayLike, salinity_psu: ArrayLike
) -> NDArray[np.complex128]:
    """Relative permittivity ε′ − jε″ of sea water by a double Debye law; the arguments broadcast.

    Meissner & Wentz, IEEE Trans. Geosci. Remote Sens. 42(9), 1836–1849 (2004). ValueError outside 1–90 GHz,
    −2–29 °C, 0–40 psu.
    """
    limits = (1e9, 90e9), (-2.0, 29.0), (0.0, 40.0)
    f, t, s = _checked("Meissner & Wentz 2004", limits, frequency_hz, temperature_c, salinity_psu)
    static = -3.56417e-3 * s + 4.74868e-6 * s**2 + 1.15574e-5 * s * t
    first = 2.39357e-3 - 3.13530e-5 * t + 2.52477e-7 * t**2
    second = -1.99723e-2 + 1.81176e-4 * t
    return _double_debye(f, t, s, static, first, second)


def permittivity_meissner_wentz12(
    frequency_hz: ArrayLike, temperature_c: ArrayLike, salinity_psu: ArrayLike
) -> NDArray[np.complex128]:
    """Relative permittivity ε′ − jε″ of sea water by a double Debye law; the arguments broadcast.

    Meissner & Wentz, IEEE Trans. Geosci. Remote Sens. 42(9), 1836–1849 (2004), with the saline coefficients
    of their 50(8), 3004–3026 (2012). ValueError outside 1–90 GHz, −2–34 °C, 0–40 psu.
    """
    limits = (1e9, 90e9), (-2.0, 34.0), (0.0, 40.0)
    f, t, s = _checked("Meissner & Wentz 2012", limits, frequency_hz, temperature_c, salinity_psu)
    static = -0.33330e-2 * s + 4.74868e-6 * s**2
    # the T³ coefficient is negative: one printed table has its sign wrong
    cool = 0.23232e-2 - 0.79208e-4 * t + 0.36764e-5 * t**2 - 0.35594e-6 * t**3 + 0.89795e-8 * t**4
    warm = 9.1873715e-4 + 1.5012396e-4 * (t - 30.0)
    second = -1.99723e-2 + 0.5 * 1.81176e-4 * (t + 30.0)
    return _double_debye(f, t, s, static, np.where(t <= 30.0, cool, warm), second)


PERMITTIVITIES: dict[str, Callable[[ArrayLike, ArrayLike, ArrayLike], NDArray[np.complex128]]] = {
    "klein_swift77": permittivity_klein_swift77,
    "meissner_wentz04": permittivity_meissner_wentz04,
    "meissner_wentz12": permittivity_meissner_wentz12,
}


def permittivity_of(settings: ScatteringSettings, frequency_hz: float) -> complex:
    """ε′ − jε″ of a scene's water by its model. Raises ValueError as the model does."""
    model = PERMITTIVITIES[settings.permittivity]
    return complex(model(frequency_hz, settings.temperature_c, settings.salinity_psu))


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


def _double_debye(
    f: NDArray[np.float64],
    t: NDArray[np.float64],
    s: NDArray[np.float64],
    static: NDArray[np.float64],
    first: NDArray[np.float64],
    second: NDArray[np.float64],
) -> NDArray[np.complex128]:
    """Meissner & Wentz's law at f [GHz], t [°C], s [psu].

    static: what salt adds to the static value's logarithm. first, second: what one psu adds to either relaxation
    frequency, relative to pure water's.
    """
    e0 = (3.70886e4 - 82.168 * t) / (421.854 + t) * np.exp(static)
    e1 = 5.7230 + 2.2379e-2 * t - 7.1237e-4 * t**2
    e1 = e1 * np.exp(-6.28908e-3 * s + 1.76032e-4 * s**2 - 9.22144e-5 * s * t)  # between the relaxations
    e2 = (3.6143 + 2.8841e-2 * t) * (1.0 + s * (-2.04265e-3 + 1.57883e-4 * t))  # optical
    f1 = (45.0 + t) / (5.0478 - 7.0315e-2 * t + 6.0059e-4 * t**2) * (1.0 + s * first)
    f2 = (45.0 + t) / (0.13652 + 1.4825e-3 * t + 2.4166e-4 * t**2) * (1.0 + s * second)
    relaxations = (e0 - e1) / (1.0 + 1j * f / f1) + (e1 - e2) / (1.0 + 1j * f / f2) + e2
    return np.asarray(relaxations - 1j * _conductivity_stogryn95(t, s) * _VACUUM / f)


def _conductivity_stogryn71(t: NDArray[np.float64], s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ionic conductivity of sea water [S/m] at t [°C] and s [psu]: Stogryn (1971) after Weyl (1964)."""
    at_25 = s * (0.182521 - 1.46192e-3 * s + 2.09324e-5 * s**2 - 1.28205e-7 * s**3)
    d = 25.0 - t
    fall = 2.033e-2 + 1.266e-4 * d + 2.464e-6 * d**2 - s * (1.849e-5 - 2.551e-7 * d + 2.551e-8 * d**2)
    return at_25 * np.exp(-d * fall)


def _conductivity_stogryn95(t: NDArray[np.float64], s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ionic conductivity of sea water [S/m] at t [°C] and s [psu]: Stogryn et al. (1995)."""
    at_35 = 2.903602 + 8.60700e-2 * t + 4.738817e-4 * t**2 - 2.9910e-6 * t**3 + 4.3047e-9 * t**4
    at_15 = s * (37.5109 + 5.45216 * s + 1.4409e-2 * s**2) / (1004.75 + 182.283 * s + s**2)
    a0 = (6.9431 + 3.2841 * s - 9.9486e-2 * s**2) / (84.850 + 69.024 * s + s**2)
    a1 = 49.843 - 0.2276 * s + 0.198e-2 * s**2
    return at_35 * at_15 * (1.0 + (t - 15.0) * a0 / (a1 + t))


def _checked(
    model: str,
    limits: tuple[_Range, _Range, _Range],
    frequency_hz: ArrayLike,
    temperature_c: ArrayLike,
    salinity_psu: ArrayLike,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Frequency in GHz, temperature and salinity, all within the model's limits."""
    frequency, t, s = (np.asarray(each, dtype=np.float64) for each in (frequency_hz, temperature_c, salinity_psu))
    named = (("frequency_hz", frequency), ("temperature_c", t), ("salinity_psu", s))
    for (name, values), (low, high) in zip(named, limits, strict=True):
        outside = ~((values >= low) & (values <= high))
        if np.any(outside):
            worst = values[outside].flat[0]
            raise ValueError(
                f"{name} = {worst:g}: must be {low:g} to {high:g} for {model}'s permittivity; give a value within"
            )
    return frequency / 1e9, t, s
