"""What waves that the mesh does not carry hide of the facets that it lights: in the mean, by the facet's own grazing.

A ray that reaches a facet meets its small waves under tan = μ + s, of the ray's fall μ and the facet's slope s along
the look. Of a Gaussian surface with rms slopes σ along the look it sees the share

    S = ½ (1 + erf v)/(1 + Λ(v)),   v = (μ + s)/(√2 σ)

(Smith, IEEE Trans. Antennas Propag. 15(5), 668–671, 1967): ½ (1 + erf v) faces the ray, and 1/(1 + Λ) of that is in
sight. Their height drops out. Two things are left out that have one: small waves on the crests before a facet hide a
little more, and on dark facets beside a shadow some reach into the light. They cancel: what the law takes off is within
1.1 % of the window of what exact horizons lose on nine of eleven seas, winds and masts, within 2.1 % on a swell and a
nearly flat sea, of which a third and more is hidden (`python -m validation.light.unresolved_profiles`).

It is a share of a facet's power, not a draw of light or dark: the shadows are a few decimetres long, so that a cell
holds tens of them. Both antennas have the same share. What the lower of two, one above the other, sees of the water,
the upper one sees too: both see what the lower one sees. The law's steepest change with u = (μ + s)/σ is √(π/2), so
that the upper one's surplus is at most √(π/2) B/(R σ) for a baseline B at a range R [3 % of the water at 100 m for
0.2 m and σ = 0.077]. The ray from between them stands for both.

What is in sight lies higher than its facet's plane, by 1 to 10 mm on those seas (same command, 1.5 mm on `choppy_sea`);
heights here do not follow.

And a radar is not light. What bends into shadows of such waves was worked out by the integral equations of the field
(`python -m validation.light.wave_shadows`): on `choppy_sea`, whose small waves are 1.2 cm high (rms), water that they
alone hide keeps 0.43 of its two-way power in VV and 0.14 in HH of what it has without them; of nine seas 0.20 to 0.72
and 0.05 to 0.52, the less the higher those waves are. So `tracing.unresolved_shadowing = "fresnel"` leaves hidden water
the share `kept` (`physics.shadowing.shadow_kept`), "smith" nothing. Neither is the default: what each gets wrong, and
why that is less than what else is wrong at such angles, stands in validation/models/tracing.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..compute.compiled import compiled
from ..compute.machine import run_blocks
from ..conventions import radar_wavenumber
from ..physics.shadowing import facing_share_smith67, shadow_kept, shadowing_smith67
from ..scattering import ShortWaves
from ..scene import Scene
from .illumination import Illumination

_STEEPEST = 6.0  # (μ + s)/σ from which on all is seen, to 1e-9
_STEPS = 1536  # of the table
_FLATTEST = 1e-6  # rms slope that stands in for none


@dataclass(frozen=True)
class UnresolvedWaves:
    """The waves that the mesh does not carry and that tilt its facets: their slopes along and across the wind."""

    slope_variances: tuple[float, float]
    wind_from_deg: float
    kept: float = 0.0  # share of its two-way power that hidden water keeps; light leaves none

    @classmethod
    def of(cls, scene: Scene, resolved_below: float) -> UnresolvedWaves | None:
        """Those of a scene's wind between the wavenumber `resolved_below` [rad/m] and the roughness that scatters; None
        where the scene has them hide nothing."""
        shadows, scattering = scene.tracing.unresolved_shadowing, scene.scattering
        if shadows == "none":
            return None
        short = ShortWaves.of(scattering, resolved_below)
        divide = short.divide(radar_wavenumber(scene.radar.frequency_hz))
        variances, kept = short.tilt_variances(divide), 0.0
        if shadows == "fresnel":
            slope = float(np.sqrt(0.5 * sum(variances)))
            kept = shadow_kept(short.tilt_height(divide), slope, scene.wavelength_m, scattering.polarization)
        return cls(variances, scattering.wind_from_deg, kept)

    def look_slope(self, azimuth_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        """Rms slope along looks."""
        along, across = self.slope_variances
        square = np.cos(np.radians(azimuth_deg - self.wind_from_deg)) ** 2
        return np.sqrt(along * square + across * (1.0 - square))

    def shares(self, tangent: ArrayLike, azimuth_deg: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What answers of a plane met under a grazing angle of that tangent ≥ 0: of all its water, and of what faces
        the ray. They broadcast."""
        slope = np.maximum(self.look_slope(np.asarray(azimuth_deg, dtype=np.float64)), _FLATTEST)
        v = np.asarray(tangent, dtype=np.float64) / (np.sqrt(2.0) * slope)
        whole, facing = _shares(v, self.kept)
        return whole, facing

    def shade(self, light: Illumination) -> Illumination:
        """The same light with `in_sight` and `facing_in_sight`, 0 where no ray arrives."""
        grid = light.grid
        per_slope = (1.0 / np.maximum(self.look_slope(grid.column_azimuth), _FLATTEST)).astype(np.float32)
        reached = np.ascontiguousarray(light.reached.any(axis=0))
        falls = _falls(light) if light.ray_slope is None else light.ray_slope
        whole, facing = (np.empty(reached.shape, np.float32) for _ in range(2))
        given = (
            np.ascontiguousarray(falls),
            np.ascontiguousarray(light.slope_look),
            reached,
            per_slope,
            _table(self.kept),
        )
        run_blocks(lambda *block: _fill(*block, *given, whole, facing), grid.columns)
        return replace(light, in_sight=whole, facing_in_sight=facing)


def _falls(light: Illumination) -> NDArray[np.float32]:
    """(column, facet) tan of the angle by which the straight ray falls."""
    return np.divide(-light.rise, light.distance, dtype=np.float64).astype(np.float32)


def _shares(v: NDArray[np.float64], kept: float) -> NDArray[np.float64]:
    """(2, …): S and 1/(1 + Λ), and the share kept of what is hidden, behind a wave or on its back."""
    shares = np.stack((shadowing_smith67(v), facing_share_smith67(v)))
    return shares + kept * (1.0 - shares)


def _table(kept: float) -> NDArray[np.float32]:
    """`_shares` (entry, 2) at even (μ + s)/σ, the last once more."""
    shares = _shares(np.linspace(0.0, _STEEPEST, _STEPS + 1) / np.sqrt(2.0), kept).T
    return np.concatenate((shares, shares[-1:])).astype(np.float32)


@compiled
def _fill(begin, end, falls, slope_look, reached, per_slope, table, whole, facing):
    """Fill whole and facing (column, facet) from the table; per_slope (column,): 1/σ."""
    last = np.float32(table.shape[0] - 2)
    for column in range(begin, end):
        scale = per_slope[column] * np.float32(_STEPS / _STEEPEST)
        for facet in range(falls.shape[1]):
            if not reached[column, facet]:
                whole[column, facet] = facing[column, facet] = np.float32(0.0)
                continue
            at = (falls[column, facet] + slope_look[column, facet]) * scale
            at = min(max(at, np.float32(0.0)), last)
            entry = int(at)
            part = at - np.float32(entry)
            whole[column, facet] = table[entry, 0] + part * (table[entry + 1, 0] - table[entry, 0])
            facing[column, facet] = table[entry, 1] + part * (table[entry + 1, 1] - table[entry, 1])
