"""How large the errors of forecasts are, from what came after them.

What a turn sees, less what an earlier field forecast for it, holds the forecast's error and the observation's own. The
observations of looks that do not overlap err independently, but a forecast's error is that of waves, and spans them: so
the covariance of such differences between looks a few metres apart is that of the forecast (Hollingsworth & Lönnberg
1986), whatever the observations' errors are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from .field import WaveField
from .lattice import Field
from .observations import Observations, damped

_APART = 2  # looks: beams of neighbouring ones overlap
_ABREAST = 0.75  # m, of distance from the antennas: the same gate, or nearly
_FARTHEST_M = 5.0  # that two looks of a pair are apart
_PAIRS = 40  # for which the stated covariance is worked out


def pairs_of_looks(seen: Observations, centre: tuple[float, float], radius: float) -> NDArray[np.intp]:
    """Pairs (pair, 2) of one turn's observations abreast of each other, two looks apart, within a radius [m]."""
    away = np.hypot(seen.x - centre[0], seen.y - centre[1])
    near = np.flatnonzero(away < radius)
    moments = np.unique(seen.time[near])
    if near.size < 2 or moments.size < 2 * _APART:
        return np.zeros((0, 2), np.intp)
    tree = KDTree(np.stack((seen.x[near], seen.y[near]), axis=1))
    pairs = near[tree.query_pairs(_FARTHEST_M, output_type="ndarray")]
    look = np.rint(seen.time / np.median(np.diff(moments)))
    apart = np.abs(look[pairs[:, 0]] - look[pairs[:, 1]])
    return pairs[(apart == _APART) & (np.abs(away[pairs[:, 0]] - away[pairs[:, 1]]) < _ABREAST)]


def compared(
    seen: Observations, difference: Field, field: WaveField, pairs: NDArray[np.intp], stream: np.random.Generator
) -> Field:
    """Mean product of differences (n,) [m] over the pairs, what the field that forecast them states for it, and what
    the waves that it knows have of it [m²]."""
    found = float(np.mean(difference[pairs[:, 0]] * difference[pairs[:, 1]]))
    one, other = stream.choice(pairs, min(_PAIRS, len(pairs)), replace=False).T
    groups = field.knowledge.groups
    kx, ky = groups.k * np.sin(groups.toward), groups.k * np.cos(groups.toward)
    lag = np.multiply.outer(seen.x[one] - seen.x[other], kx) + np.multiply.outer(seen.y[one] - seen.y[other], ky)
    lag -= np.multiply.outer(seen.time[one] - seen.time[other], groups.omega)
    blurred = damped(seen.blur[one][:, None], kx, ky) ** 2
    waves = float(np.mean(np.sum(groups.variance * blurred * np.cos(lag), axis=1)))
    lattice = field.members[0].lattice
    blur = damped(seen.blur[one].mean(axis=0), lattice.kx, lattice.ky).astype(np.complex128)
    missed = [field.samples([blur], seen.x[each], seen.y[each], seen.time[each])[0] for each in (one, other)]
    stated = 0.5 * float(np.mean(np.real(missed[0] * np.conj(missed[1]))))
    return np.array([found, stated, waves - stated])
