"""The published models of mean sea clutter, each by its paper's name; where each was fitted, and what they share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import POLARIZATIONS, radar_wavelength

_POSITIVE = float(np.nextafter(0.0, 1.0))
_UNIT_WIND = 3.16  # m/s, the wind of sea state 1
_CALM = 1e-9  # the least sea state: log 0 has no value, its limit has
_FOOT = 0.3048  # m
_REFERENCE_DEG = 0.1  # of the Hybrid model
_NRL = {
    "HH": (-73.0, 20.781, 7.351, 25.65, 0.00540),
    "VV": (-50.796, 25.93, 0.7093, 21.588, 0.00211),
}
_GIT_VV_OVER_HH = ((-1.73, 3.76, 2.46, 22.2), (-1.05, 1.09, 1.27, 9.7), (-1.38, 3.43, 1.31, 18.55))
_HYBRID_HH_OVER_VV = ((1.7, -3.8, -2.5, -22.2), (1.1, -1.1, -1.3, -9.7), (1.4, -3.4, -1.3, -18.6))


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


NRL = ModelRange("the NRL 2012 sea clutter model", (0.1, 60.0), (0.5e9, 35e9), (0.0, 6.0))
GIT = ModelRange("the GIT 1978 sea clutter model", (0.1, 10.0), (1e9, 100e9), (0.4, 7.0))
TSC = ModelRange("the TSC 1990 sea clutter model", (0.1, 90.0), (0.5e9, 35e9), (0.0, 5.0))
HYBRID = ModelRange("the Hybrid 1990 sea clutter model", (0.1, 30.0), (0.5e9, 35e9), (1.0, 5.0))


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


def nrcs_gregers_hansen12(
    grazing_deg: ArrayLike,
    sea_state: ArrayLike,
    frequency_hz: ArrayLike,
    polarization: str,
    extrapolate: bool = False,
    clipped: bool = False,
) -> NDArray[np.float64]:
    """Mean σ0 [linear] of the sea over all wind directions, "HH" or "VV"; the arguments broadcast.

    Gregers-Hansen & Mittal, An Improved Empirical Model for Radar Sea Clutter Reflectivity,
    NRL/MR/5310–12-9346 (2012): grazing 0.1–60°, 0.5–35 GHz, sea states 0–6. Raises ValueError outside, unless
    `extrapolate` lets the formula run on (grazing must still be positive). `clipped` brings the grazing
    angle, and only it, into 0.1–60° first: facets at the mast's foot or on the horizon then take the value at
    the model's edge, and it must be requested. σ0 is steep at the lower edge: VV rises 5.7 dB from
    0.1° to 0.2°.
    """
    psi, state, frequency = NRL.checked(grazing_deg, sea_state, frequency_hz, polarization, extrapolate, clipped)
    c1, c2, c3, c4, c5 = _NRL[polarization]
    level_db = (
        c1
        + c2 * np.log10(np.sin(np.radians(psi)))
        + (27.5 + c3 * psi) * np.log10(frequency / 1e9) / (1.0 + 0.95 * psi)
        + c4 * (state + 1.0) ** (1.0 / (2.0 + 0.085 * psi + 0.033 * state))
        + c5 * psi**2
    )
    return np.asarray(10.0 ** (level_db / 10.0))


def nrcs_horst78(
    grazing_deg: ArrayLike,
    sea_state: ArrayLike,
    frequency_hz: ArrayLike,
    polarization: str,
    wind_angle: ArrayLike | None = None,
    extrapolate: bool = False,
    clipped: bool = False,
) -> NDArray[np.float64]:
    """Mean σ0 [linear] of the sea, "HH" or "VV"; the arguments broadcast.

    Horst, Dyer & Tuley, Radar Sea Clutter Model, Int. IEEE AP/S–URSI Symposium, 6–10 (1978): grazing 0.1–10°,
    1–100 GHz, winds of 1.5–15 m/s, given here by their sea states 0.4–7. The paper takes the wind and the average
    wave height: `wind_from_sea_state` gives V, and its fully developed sea is h = 4.52e-3 V^2.5. wind_angle [rad]:
    the look's azimuth less the one that the wind comes from; None: the mean power over all directions. ValueError
    outside the range, unless `extrapolate` lets the formula run on; `clipped` brings the grazing angle, and only
    it, into the range first.

    The paper's bands do not meet: at 10 GHz σ0 jumps by −6 to 12 dB, most on a calm sea, and VV at 3 GHz by −7 to
    2 dB. Below a critical angle σ0 falls as ψ^4.4 (sea state 1, 9.3 GHz: below 4°), tens of dB under Nathanson's
    table at 0.1°.
    """
    psi, state, frequency = GIT.checked(grazing_deg, sea_state, frequency_hz, polarization, extrapolate, clipped)
    psi, wavelength = np.radians(psi), radar_wavelength(frequency)
    wind = wind_from_sea_state(np.maximum(state, _CALM))
    height = 4.52e-3 * wind**2.5  # m, average

    roughness = ((14.4 * wavelength + 5.5) * psi * height / wavelength) ** 4
    interference = roughness / (1.0 + roughness)
    wide = wavelength + 0.015
    low_band = frequency <= 10e9
    growth = (1.94 * wind / (1.0 + wind / 15.4)) ** np.where(low_band, 1.1 * wide**-0.4, 1.93 * wavelength**-0.04)
    upwind = (1.0 - 2.8 * psi) * np.where(low_band, 0.2 * wide**-0.4, 0.25 * wavelength**-0.33)
    level = np.where(low_band, 3.9e-6 * wavelength * psi**0.4, 5.78e-6 * psi**0.547) * interference * growth
    if polarization == "VV":
        level = level * 10.0 ** (_ratio_db(_GIT_VV_OVER_HH, psi, wavelength, height, frequency) / 10.0)
    return np.asarray(level * wind_factor(upwind, wind_angle))


def nrcs_tsc90(
    grazing_deg: ArrayLike,
    sea_state: ArrayLike,
    frequency_hz: ArrayLike,
    polarization: str,
    wind_angle: ArrayLike | None = None,
    extrapolate: bool = False,
    clipped: bool = False,
) -> NDArray[np.float64]:
    """Mean σ0 [linear] of the sea, "HH" or "VV"; the arguments broadcast.

    Technology Service Corporation, Backscatter from Sea, Radar Workstation, vol. 2, 177–186 (1990), as printed by
    Antipov, Simulation of Sea Clutter Returns, DSTO-TR-0679 (1998): grazing 0.1–90°, 0.5–35 GHz, sea states 0–5.
    wind_angle, extrapolate, clipped: as of `nrcs_horst78`.

    Its lengths are feet and its wind is in knots, which printed listings miss: read in metres it lies 7–9 dB above
    Nathanson's table at 9.3 GHz, in feet 1–3 dB. VV jumps at 2 GHz, by −10 to 1 dB.
    """
    psi, state, frequency = TSC.checked(grazing_deg, sea_state, frequency_hz, polarization, extrapolate, clipped)
    psi, wavelength = np.radians(psi), radar_wavelength(frequency) / _FOOT
    height = 0.115 * state**1.95  # feet, standard deviation

    roughness = (14.9 * psi * (height + 0.25) / wavelength) ** 1.5
    level = 1.7e-5 * np.sqrt(psi) * roughness / (1.0 + roughness) / (wavelength + 0.05) ** 1.8
    level = level * ((6.2 * state**0.8 + 4.0) / 15.0) ** _wind_exponent(psi, wavelength)
    if polarization == "VV":
        log_height, log_sine, log_wavelength = (
            np.log(2.507 * height + 0.05),
            np.log(np.sin(psi) + 1e-4),
            np.log(wavelength),
        )
        below_2 = -1.73 * log_height + 3.76 * log_wavelength + 2.46 * log_sine + 19.8
        above_2 = -1.05 * log_height + 1.09 * log_wavelength + 1.27 * log_sine + 9.65
        level = level * 10.0 ** (np.where(frequency < 2e9, below_2, above_2) / 10.0)
    upwind = 0.3 * np.exp(-psi / 0.17) / (wavelength**2 + 0.005) ** 0.2
    return np.asarray(level * wind_factor(upwind, wind_angle))


def _wind_exponent(psi: NDArray[np.float64], wavelength: NDArray[np.float64]) -> NDArray[np.float64]:
    """The power of the wind that clutter follows; psi in radians, wavelength in feet."""
    q = psi**0.6
    a1, a2, a3 = ((1.0 + (wavelength / each) ** 3) for each in (0.03, 0.1, 0.3))
    return 2.63 * a1**0.1 / (a2**0.1 * a3 ** (q / 3.0) * (1.0 + 0.35 * q))


def nrcs_reilly90(
    grazing_deg: ArrayLike,
    sea_state: ArrayLike,
    frequency_hz: ArrayLike,
    polarization: str,
    wind_angle: ArrayLike | None = None,
    extrapolate: bool = False,
    clipped: bool = False,
) -> NDArray[np.float64]:
    """Mean σ0 [linear] of the sea, "HH" or "VV"; the arguments broadcast.

    Reilly & Dockery, Influence of evaporation ducts on radar sea return, IEE Proc. F 137(2), 80–88 (1990), whose
    appendix builds it from Barton's and Nathanson's data and parts of GIT's: grazing 0.1–30°, 0.5–35 GHz, sea
    states 1–5. wind_angle, extrapolate, clipped: as of `nrcs_horst78`.

    HH jumps where its bands meet, at 3 GHz by −2 to 7 dB, at 10 GHz by −2 to 0 dB. It lies 3–5 dB above
    Nathanson's table at 9.3 GHz, 17 dB at worst (sea state 1, 10°): beyond the transition it falls as the wind rises,
    up to sea state 1.7. Listings differ in the transition's 0.066 (0.0632: 0.1 dB less; 0.66, a slip: 4 dB more) and
    in the logarithm of the wind's term (natural instead of decimal: 0.7 dB less).
    """
    psi, state, frequency = HYBRID.checked(grazing_deg, sea_state, frequency_hz, polarization, extrapolate, clipped)
    state, wavelength = np.maximum(state, _CALM), radar_wavelength(frequency)
    log_ghz = np.log10(frequency / 1e9)
    level_db = np.where(frequency <= 12.5e9, 24.4 * log_ghz - 65.2, 3.25 * log_ghz - 42.0)
    level_db = level_db + _grazing_db(psi, state, wavelength) + 5.0 * (state - 5.0)
    if polarization == "HH":
        level_db = level_db + _ratio_db(_HYBRID_HH_OVER_VV, np.radians(psi), wavelength, 0.08 * state**2, frequency)
    fall = (2.0 + 1.7 * np.log10(0.1 / wavelength)) * np.log(10.0) / 10.0  # from upwind to crosswind
    return np.asarray(10.0 ** (level_db / 10.0) * np.exp(-fall) * wind_factor(fall, wind_angle))


def _grazing_db(
    psi: NDArray[np.float64], state: NDArray[np.float64], wavelength: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Rises as ψ² up to the transition, as ψ beyond it; psi in degrees."""
    height = 0.031 * state**2  # m, root mean square
    transition = np.degrees(np.arcsin(np.minimum(0.066 * wavelength / height, 1.0)))
    transition = np.maximum(transition, _REFERENCE_DEG)
    square = np.clip(psi, _REFERENCE_DEG, transition) / _REFERENCE_DEG
    return 20.0 * np.log10(square) + 10.0 * np.log10(np.maximum(psi, transition) / transition)


def _ratio_db(
    rows: tuple[tuple[float, ...], ...],
    psi: NDArray[np.float64],
    wavelength: NDArray[np.float64],
    height: NDArray[np.float64],
    frequency: NDArray[np.float64],
) -> NDArray[np.float64]:
    """One polarization over the other [dB], by rows of factors below 3 GHz, up to 10 GHz and above: of the logarithms
    of the average wave height [m], the wavelength [m] and the grazing angle [rad], and a constant."""
    offset = np.log(height + 0.015), np.log(wavelength), np.log(psi + 1e-4)
    plain = np.log(height), np.log(wavelength), np.log(psi)
    below_3, to_10, above_10 = (
        a * h + b * w + c * p + d for (a, b, c, d), (h, w, p) in zip(rows, (offset, offset, plain), strict=True)
    )
    return np.where(frequency < 3e9, below_3, np.where(frequency <= 10e9, to_10, above_10))
