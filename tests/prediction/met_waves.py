"""Waves that vessels are put on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.prediction.vessel import Responses, Vessel

K = np.geomspace(0.02, 8.0, 40)  # rad/m: waves of 300 m to 0.8 m


def toward(azimuth_deg: float, k: NDArray[np.float64] = K) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    east, north = unit_from_azimuth(azimuth_deg)
    return k * east, k * north


def sigma(k: NDArray[np.float64] | float, depth: float = np.inf) -> NDArray[np.float64]:
    return angular_frequency(k, depth, surface_tension=0.0)


def moved(
    vessel: Vessel,
    azimuth_deg: float,
    heading_deg: float = 0.0,
    speed: float = 0.0,
    k: NDArray[np.float64] = K,
    depth: float = np.inf,
) -> Responses:
    """Motions in waves that run towards an azimuth, on still water."""
    return vessel.response(*toward(azimuth_deg, k), sigma(k, depth), heading_deg, speed, depth)


def each(responses: Responses) -> NDArray[np.complexfloating]:
    return np.array([responses.heave, responses.roll, responses.pitch])
