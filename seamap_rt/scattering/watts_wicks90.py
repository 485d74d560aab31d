"""How spiky measured sea clutter is: the shape of its K-distribution (Watts & Wicks 1990)."""

from __future__ import annotations

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
