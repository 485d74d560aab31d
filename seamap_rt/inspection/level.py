"""Mean level by range: what a wrong sign of the phase, a wrong mast height and a phase offset do to it.

The sea's mean level is 0 at every range. With receivers exchanged, or conjugated voltages, a range difference δ is
read as −δ, and the level of a mast of height h as 2h, folded by the cycles of the phase, whose height λR/(pB) grows
with range: a staircase of metres. A mast height too large by Δh lifts the level by Δh everywhere, a phase offset φ
between the receivers by −R φ/(p k B), which grows with range.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import radar_wavenumber
from ..dataset import QUALITY_FLAGS
from ..interferometry.retrieval import retrieve_one
from ..settings import RetrievalSettings
from .findings import Finding, judged, rings

Array = NDArray[np.float64]

_RINGS, _SECTORS = 8, 12
_FEWEST_CELLS = 300  # of a map whose level is judged
_FEWEST_OF_SECTOR = 5
_CREST_M = 100.0  # as far along a crest, or across a long wave, heights go together
_SURE = 4.0  # times flatter, that the other sign's level must be; the right sign's is 15 times on all shipped scenes
_SUSPECT = 0.5  # of the waves' own scatter: a flatter level needs no second look
_MOST_WAVES = 0.5  # of the mast's height
_OF_MAST = 0.2  # as far as that the sea's level is nowhere from 0: 0.04 at most on the shipped scenes
_ALIKE = 2.0  # levels as flat as that tell no remedy from another
_STRAYS = 4.0  # standard errors
_LEAST_LIFT_M = 0.1
_OF_WAVES = 0.5  # standard deviations of the waves, by which what is hidden may lift the level
_ELSE = (
    "check that both receivers sample the same pulses and gates, first_gate_m, gate_m, baseline_m and phase_offset_deg"
)

# What a recorder may have got wrong, by what mends it; voltages (pulse, receiver, gate). With one antenna that sends,
# an exchange and a conjugate turn the heights alike.
_OTHER_SIGNS: dict[str, Callable[[NDArray[np.complex64]], NDArray[np.complex64]]] = {
    "exchange lower and upper (--name lower=… upper=…)": lambda voltage: voltage[:, ::-1],
    "set conjugate in the header": np.conj,
    "do both: exchange lower and upper, and set conjugate": lambda voltage: np.conj(voltage[:, ::-1]),
}


@dataclass(frozen=True)
class Level:
    """Median heights of rings of equally many cells; arrays (ring,), in metres."""

    distance: Array
    height: Array
    error: Array  # standard error, by the scatter between sectors
    waves: float  # standard deviation of the heights about their rings' medians

    @classmethod
    def of(cls, polar: xr.Dataset) -> Level | None:
        """The level of all turns of a polar map; None where too few cells have heights."""
        height, distance = (polar[name].values.astype(np.float64) for name in ("height", "ground_range"))
        known = np.isfinite(height) & np.isfinite(distance)
        known &= (polar["quality"].values & QUALITY_FLAGS["ambiguous"]) == 0
        if np.count_nonzero(known) < _FEWEST_CELLS:
            return None
        sector = np.broadcast_to(np.arange(height.shape[1])[:, None] * _SECTORS // height.shape[1], height.shape)
        height, distance, sector = height[known], distance[known], sector[known]
        ring = rings(distance, _RINGS)
        rows, scatter = [], []
        for number in range(_RINGS):
            here = height[ring == number]
            if not here.size:
                continue
            middle = float(np.median(here))
            parts = [here[sector[ring == number] == each] for each in range(_SECTORS)]
            medians = np.array([np.median(part) for part in parts if part.size >= _FEWEST_OF_SECTOR])
            round_it = 2.0 * np.pi * float(np.median(distance[ring == number])) / _CREST_M
            free = min(medians.size, max(1.0, round_it))  # near by all sectors stand on one wave
            error = medians.std(ddof=1) / np.sqrt(free) if medians.size > 1 else np.nan
            rows.append((float(np.median(distance[ring == number])), middle, float(error)))
            scatter.append(1.4826 * float(np.median(np.abs(here - middle))))
        distances, heights, errors = np.array(rows).T
        return cls(distances, heights, errors, float(np.median(scatter)))

    @property
    def rms(self) -> float:
        return float(np.sqrt(np.mean(self.height**2)))

    def line(self) -> tuple[Array, Array]:
        """Offset [m] and tilt [m per m] of the straight line through the level, and their standard errors."""
        usual = np.nanmedian(self.error) if np.isfinite(self.error).any() else max(self.waves, 1e-6)
        weight = 1.0 / np.hypot(np.nan_to_num(self.error, nan=usual), 0.1 * usual + 1e-9)
        design = np.stack((np.ones(self.distance.size), self.distance), axis=1) * weight[:, None]
        found, *_ = np.linalg.lstsq(design, self.height * weight, rcond=None)
        left = self.height * weight - design @ found
        free = max(1, self.distance.size - 2)
        spread = np.linalg.pinv(design.T @ design) * max(1.0, float(left @ left) / free)
        return np.asarray(found, np.float64), np.asarray(np.sqrt(np.diag(spread)), np.float64)


def sign(turn: xr.Dataset, settings: RetrievalSettings, level: Level | None) -> Finding:
    """Whether the phase has the right sign. turn: the first turn's echoes, of which `level` was retrieved."""
    what = "sign of the phase"
    if level is None:
        return Finding(what, "unknown", "too few cells have a height")
    words = f"the mean level keeps within {level.rms:.2f} m of the sea's"
    plausible = level.waves <= _MOST_WAVES * float(turn.attrs["height_m"])  # heights that fold scatter by themselves
    if plausible and level.rms <= _SUSPECT * level.waves:
        return Finding(what, "good", words)
    others = {}
    for remedy, turned in _OTHER_SIGNS.items():
        voltage = np.ascontiguousarray(turned(turn["voltage"].values))
        maps = retrieve_one(turn.assign(voltage=(turn["voltage"].dims, voltage)), settings)
        other = Level.of(maps["polar"].to_dataset())
        if other is not None:
            others[remedy] = other.rms
    least = min(others.values(), default=np.inf)
    if not least * _SURE <= level.rms and level.rms > _OF_MAST * float(turn.attrs["height_m"]):
        says = f"the mean level strays by {level.rms:.1f} m with range, and by {least:.1f} m at best with another sign"
        return Finding(what, "doubtful", f"{says}: the phase tells no heights", _ELSE)
    if not least * _SURE <= level.rms:
        return Finding(what, "good", f"{words}, {least:.2f} m at best with another sign" if others else words)
    remedies = [remedy for remedy, rms in others.items() if rms <= _ALIKE * least]
    return Finding(
        what,
        "wrong",
        f"the mean level strays by {level.rms:.1f} m with range, and by {least:.2f} m with the other sign: receivers "
        "are exchanged or voltages conjugated",
        " or ".join(remedies),
    )


def offsets(echoes: xr.Dataset, level: Level | None, paths: int) -> list[Finding]:
    """Mast height and phase offset, by the level and its trend with range. paths: p, 2 if each antenna hears itself."""
    names = "mast height", "phase offset of the receivers"
    if level is None:
        return [Finding(name, "unknown", "too few cells have a height") for name in names]
    (lift, tilt), (lift_error, tilt_error) = level.line()
    allowed = _OF_WAVES * level.waves
    mast = float(echoes.attrs["height_m"]) - lift
    wavenumber = radar_wavenumber(float(echoes.attrs["frequency_hz"]))
    phase, phase_error = np.degrees(np.array((-tilt, tilt_error)) * paths * wavenumber * echoes.attrs["baseline_m"])
    baseline = float(echoes.attrs["baseline_m"]) * mast / float(echoes.attrs["height_m"])
    of_height = f"height_m = {mast:.4g} would bring it to 0, or baseline_m = {baseline:.4g}; check first_gate_m too"
    of_height = _ELSE if mast <= 0.0 else of_height
    of_phase = (
        f"an offset of the phase of {phase:+.1f} ± {phase_error:.1f}° does this: phase_offset_deg of the header takes "
        "it off; so does a wrong tilt of the antennas"
    )
    return [
        judged(
            names[0],
            abs(lift) > max(_STRAYS * lift_error, allowed, _LEAST_LIFT_M) and abs(level.height.mean()) > _LEAST_LIFT_M,
            f"the sea's mean level comes out at {lift:+.2f} ± {lift_error:.2f} m",
            of_height,
        ),
        judged(
            names[1],
            abs(tilt) > _STRAYS * tilt_error
            and abs(tilt) * float(level.distance.max()) > max(3.0 * allowed, 2.0 * _LEAST_LIFT_M),
            f"the mean level changes by {100.0 * tilt:+.2f} ± {100.0 * tilt_error:.2f} m in 100 m of range",
            _ELSE if abs(phase) > 180.0 else of_phase,
        ),
    ]
