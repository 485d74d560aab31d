"""What the models of mean clutter share: where each was fitted, Douglas' sea states, and the wind's direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import POLARIZATIONS

_POSITIVE = float(np.nextafter(0.0, 1.0))


@dataclass(frozen=True)
class ModelRange:
    """A mean clutter model's name, as its errors call it, and the lowest and highest values that it holds for."""

    model: str
    grazing_deg: tuple[float, float]
    frequency_hz: tuple[float, float]
    sea_state: tuple[float, float]

    def checked(
        self,
        grazing_deg: ArrayLike,
        sea_state: ArrayLike,
        frequency_hz: ArrayLike,
        polarization: str,
        extrapolate: bool,
        clipped: bool,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Grazing angle [°], sea state and frequency [Hz] as arrays that the model may take.

        `clipped` first brings the grazing angle, and only it, into the range. ValueError outside the range, unless
        `extrapolate` lets all run on that is physical, and for a polarization that is neither "VV" nor "HH".
        """
        if polarization not in POLARIZATIONS:
            raise ValueError(f"polarization = {polarization!r}: must be one of {', '.join(POLARIZATIONS)}")
        psi = np.asarray(grazing_deg, dtype=np.float64)
        state = np.asarray(sea_state, dtype=np.float64)
        frequency = np.asarray(frequency_hz, dtype=np.float64)
        if clipped:
            psi = np.clip(psi, *self.grazing_deg)
        if extrapolate:
            _check("grazing_deg", psi, (_POSITIVE, 90.0), "above 0 and at most 90; give a grazing angle above 0")
            _check("sea_state", state, (0.0, np.inf), "0 or more; give a calmer sea as 0")
            _check("frequency_hz", frequency, (_POSITIVE, np.inf), "positive; give it in hertz")
        else:
            for name, value, limits, remedy in (
                ("grazing_deg", psi, self.grazing_deg, "pass clipped=True to use the value at the model's edge"),
                ("sea_state", state, self.sea_state, "change the wind, or pass extrapolate=True"),
                ("frequency_hz", frequency, self.frequency_hz, "use another model, or pass extrapolate=True"),
            ):
                low, high = limits
                _check(name, value, limits, f"{low:g} to {high:g}, where {self.model} holds; {remedy}")
        return psi, state, frequency


def _check(name: str, value: NDArray[np.float64], limits: tuple[float, float], rule: str) -> None:
    low, high = limits
    outside = ~((value >= low) & (value <= high))
    if np.any(outside):
        raise ValueError(f"{name} = {value[outside].flat[0]:g}: must be {rule}")


_UNIT_WIND = 3.16  # m/s, the wind of sea state 1


def sea_state_from_wind(wind_speed: ArrayLike) -> NDArray[np.float64]:
    """Douglas sea state (a real number) of a fully developed sea under a wind [m/s]: (U10/3.16)^1.25."""
    return np.asarray((np.asarray(wind_speed, dtype=np.float64) / _UNIT_WIND) ** 1.25)


def wind_from_sea_state(sea_state: ArrayLike) -> NDArray[np.float64]:
    """Wind U10 [m/s] that raises a Douglas sea state (a real number) when it has blown long enough."""
    return np.asarray(_UNIT_WIND * np.asarray(sea_state, dtype=np.float64) ** 0.8)


def wind_factor(strength: ArrayLike, wind_angle: ArrayLike | None) -> NDArray[np.float64]:
    """exp(strength · cos φ), φ [rad] the look's azimuth less the one that the wind comes from; they broadcast.

    φ = 0 looks into the wind. None is the mean over all φ, the modified Bessel function I0(strength): a mean of
    powers, not of decibels.
    """
    if wind_angle is None:
        return np.asarray(scipy.special.i0(np.asarray(strength, dtype=np.float64)))
    return np.exp(np.asarray(strength, dtype=np.float64) * np.cos(np.asarray(wind_angle, dtype=np.float64)))
