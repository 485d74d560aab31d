"""Level of detail: how fine the mesh must be for the required errors, by a model of what its facets cost the maps.

Between its corners a facet is flat. Of a wave that advances by κ from one corner to the next the flat facet misses the
share ε(κ) of the mean square (`chord_error`), and ∫Ψ ε is what the sea of spectrum Ψ keeps from the mesh: `e_along` of
rungs facet_m apart, `e_across` of columns that the beam makes wider with range. The errors of a cell follow from both:

    e² = e_r² + e_c²,   e_r² = (0.6 e_along)² + (0.02 σ facet_m)²,   e_c² = e_across²/columns_per_beam
    power = √((5.5 dB q)² + (g M)²),   q = e/(σ cell) the share of a cell by which a crest's shadow moves
    height = √(e² + (0.06/dB σ cell g M)²),   visible share = √((3.8 e_r)² + (1.6 e_c)²)/(σ cell)

To these come the errors of the sum over facets itself, which even a level sea has (`sampling`).

σ is the rms slope, `cell` the radar's range cell. Neighbouring columns err independently; σ facet_m is there because
a facet is lit or dark as a whole. M is the mean-square slope along the look that facets average away: the mean echo is
convex in the slope, in HH all the more, and fades with it.

The coefficients are fits to meshes of 0.25 to 1.5 m and of three to eight columns a beam, on a dozen seas and looks
(`validation/light/detail.py`, by straight rays): over a window heights come out within a factor 1.5 for masts of a few
metres. Under masts of 20 m and more, and in HH on calm seas, the model asks for up to twice too much; within three
heights of the mast, under steep rays, errors may be three times as large, and single cells beside a shadow's edge
larger still. Light that bends over crests turns on finer details: other meshes draw other errors of it, as large.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..physics.shadowing import shadowing_smith67
from ..radar.antenna import cache_by_radar
from ..radar.array import antenna_array
from ..radar.scan import BEAMS_BEYOND, sector_width
from ..radar.waveform import RangeResponse, range_cell
from ..sea import resolution, spectral_system
from ..sea.systems import SpectralSystem, travel_direction
from ..settings import (
    FileWaves,
    RadarSettings,
    RandomWaves,
    ScatteringSettings,
    SeaSettings,
    SinusoidWaves,
    TracingSettings,
)
from .sampling import SamplingErrors, sampling_errors

MOST_TRIANGLES = 2e7
POWER_ERROR_DB = 0.3  # 7 %: less than a clutter model is known to; heights that are asked for finer tighten it anyway
_LEAST_FACET, _COLUMNS = 0.02, (3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64)  # as far as the settings go
_RUNGS_A_CELL = 3
_LEVEL = (0.03, 0.002, 0.003)  # dB, m and of the coherence: what the sum over facets may cost a level sea
_RUNGS_A_WAVE = 8.0  # of a regular one
_LADDER = 1.08  # between the facet sizes that are tried
_SPACINGS = np.geomspace(_LEAST_FACET, 200.0, 64)  # m, at which the chords' error is tabulated
_RANGES, _LOOK_DEG = 8, 30.0
_ALONG, _SNAP = 0.6, 0.02
_POWER_PER_SHIFT = 5.5  # dB
_VISIBLE_BY_RUNGS, _VISIBLE_BY_COLUMNS = 3.8, 1.6
_HEIGHT_PER_DB = 0.06  # of σ cell
_FADE = {"VV": 200.0, "HH": 550.0, "plain": 350.0}  # g [dB]; plain: every lit facet has the mean
_WAVENUMBERS, _ANGLES = 32, 18  # of the spectrum's quadrature; angles of half the circle


@dataclass(frozen=True)
class MeshDetail:
    """The spacings of a mesh, and what they are predicted to cost: rms errors in the expectation over speckle.

    Those of the whole window are the worst look's, its ranges counted by how much of the sea is seen there, as in maps.
    """

    facet_m: float  # between rungs, along the look
    columns_per_beam: int
    facets: int = 0  # of a turn, about
    height_error_m: float = 0.0
    power_error_db: float = 0.0
    visible_error: float = 0.0
    by_range: tuple[tuple[float, float, float, float], ...] = ()  # m, and the three errors there
    limited_by: str = ""  # what forbids a coarser mesh, or that the target is not reached

    def meshing(self, tracing: TracingSettings) -> TracingSettings:
        """The settings with the spacings filled in."""
        return tracing.model_copy(update={"facet_m": self.facet_m, "columns_per_beam": self.columns_per_beam})

    def facts(self) -> dict[str, Any]:
        """The plain numbers, for metrics and report."""
        columns = ("range_m", "height_error_m", "power_error_db", "visible_error")
        return asdict(self) | {"by_range": [dict(zip(columns, row, strict=True)) for row in self.by_range]}

    def words(self) -> str:
        """One sentence."""
        return (
            f"rungs {self.facet_m:g} m apart, {self.columns_per_beam} columns a beam ({self.limited_by}): predicted to "
            f"cost heights {1e3 * self.height_error_m:.2g} mm, power {self.power_error_db:.2g} dB and the visible "
            f"share {self.visible_error:.1%} of a cell, rms"
        )


def radar_detail(radar: RadarSettings, tracing: TracingSettings) -> MeshDetail:
    """The spacings as given; where they are not, six rungs a range cell and four columns a beam, whatever the sea."""
    facet = tracing.facet_m or float(f"{range_cell(radar) / 6.0:.2g}")
    return MeshDetail(facet, tracing.columns_per_beam or 4)


def mesh_detail(
    sea: SeaSettings, radar: RadarSettings, tracing: TracingSettings, scattering: ScatteringSettings | None = None
) -> MeshDetail:
    """The coarsest mesh with which heights, power and, if required, visible shares err by no more than allowed.

    The targets are tracing.height_error_m, 0.3 dB and tracing.visible_error. Spacings that the settings give are taken.
    A mesh that follows is never coarser than the grid of the sea's waves (what neither the mesh nor the scattering has
    would be lost), an eighth of a regular wave, a third of the radar's range cell (finer under steep looks, and for
    long pulses with steep edges: `level_facet`), or three columns a beam (with fewer
    the sum over columns aliases the two-way pattern). Where no mesh that fits memory meets the targets, the
    best is taken, and `limited_by` says so.
    """
    scattering = scattering or ScatteringSettings()
    fade = _FADE[scattering.polarization if scattering.nrcs == "two_scale" else "plain"]
    if any(isinstance(waves, FileWaves) for waves in sea.waves):  # a file may be written anew
        return _chosen(radar, sea, tracing, fade)
    return _kept_choice(radar, sea, tracing, fade)


def _chosen(radar: RadarSettings, sea: SeaSettings, tracing: TracingSettings, fade: float) -> MeshDetail:
    if not np.isfinite(antenna_array(radar).beam_deg):
        return radar_detail(radar, tracing)
    try:
        waves = _Waves.of(sea)
    except (ValueError, OSError):  # the sea itself says what is wrong with it, when it is drawn
        return radar_detail(radar, tracing)
    coarsest, reason = _coarsest(sea, waves.spacing, radar)
    facet = np.array([tracing.facet_m]) if tracing.facet_m else _facet_sizes(coarsest)
    columns = np.array([tracing.columns_per_beam] if tracing.columns_per_beam else _COLUMNS)
    errors = _Errors(waves, radar, facet, columns, fade)
    shares = [errors.window(errors.height) / tracing.height_error_m, errors.window(errors.power) / POWER_ERROR_DB]
    names = ["tracing.height_error_m", f"{POWER_ERROR_DB:g} dB of power"]
    if tracing.visible_error is not None:
        shares.append(errors.window(errors.visible) / tracing.visible_error)
        names.append("tracing.visible_error")
    worst, count = np.max(shares, axis=0), triangles(radar, facet[:, None], columns)
    fits = count <= MOST_TRIANGLES
    enough = fits & (worst <= 1.0)
    given = tracing.facet_m is not None and tracing.columns_per_beam is not None
    if enough.any():
        cell = np.unravel_index(np.argmin(np.where(enough, count, np.inf)), count.shape)
        limited_by = reason if facet[cell[0]] == coarsest else names[int(np.argmax([each[cell] for each in shares]))]
    else:
        # Of those that fit, the best; if none does, the coarsest: the scene then says what is too much.
        rank = np.where(fits, worst, np.inf) if fits.any() else count
        cell = np.unravel_index(np.argmin(rank), count.shape)
        target = names[int(np.argmax([each[cell] for each in shares]))]
        why = "the spacings that are given" if given or fits.all() else f"{MOST_TRIANGLES:.3g} triangles of memory"
        limited_by = f"{why}: {target} is exceeded {worst[cell]:.2g} times"
    if given and enough.any():
        limited_by = "as given"
    return errors.detail(cell, int(count[cell]), limited_by)


_kept_choice = cache_by_radar(maxsize=128)(_chosen)


def level_facet(radar: RadarSettings) -> float:
    """The largest facet size [m], up to a third of the range cell, that costs a level sea no more than _LEVEL."""
    return _level(radar)[0]


@cache_by_radar(maxsize=64)
def _level(radar: RadarSettings) -> tuple[float, SamplingErrors]:
    """`level_facet`, and its errors at `_ranges`."""
    ranges = np.append(_ranges(radar), radar.range_m[0])
    facet, errors = _LEAST_FACET, SamplingErrors(*np.zeros((3, ranges.size, 1)))
    for facet in _facet_sizes(max(_round_down(range_cell(radar) / _RUNGS_A_CELL), _LEAST_FACET)):
        errors = sampling_errors(radar, ranges, np.array([facet]))
        if all(np.max(each) <= most for each, most in zip(errors, _LEVEL, strict=True)):
            break
    return float(facet), SamplingErrors(*(each[:-1] for each in errors))


def _level_errors(radar: RadarSettings, facet: NDArray[np.float64]) -> SamplingErrors:
    """Errors of level by facet size, (range, facet size). They fall with the square of the size at least."""
    known, errors = _level(radar)
    if facet[0] > known:
        known, errors = float(facet[0]), sampling_errors(radar, _ranges(radar), facet[:1])
    return SamplingErrors(*(each * np.square(facet / known) for each in errors))


def _ranges(radar: RadarSettings) -> NDArray[np.float64]:
    """Slant ranges [m] at which errors are predicted."""
    near, far = radar.range_m
    return near + (far - near) * (np.arange(_RANGES) + 0.5) / _RANGES


def triangles(radar: RadarSettings, facet_m: ArrayLike, columns_per_beam: ArrayLike) -> NDArray[np.float64]:
    """How many triangles the mesh of a turn has: from the mast's foot on, as what is near shadows what is far."""
    array = antenna_array(radar)
    facet, columns = np.broadcast_arrays(np.asarray(facet_m, dtype=np.float64), columns_per_beam)
    if not np.isfinite(array.beam_deg):  # an antenna that receives from everywhere is not simulated on a mesh
        return np.zeros(facet.shape)
    scanned = 0.0 if radar.scan == "staring" else sector_width(radar)
    beams = (scanned + 2.0 * BEAMS_BEYOND * array.beam_deg) / array.narrowest_beam_deg
    return 2.0 * columns * beams * (radar.range_m[1] + RangeResponse.of(radar).support_m) / facet


def chord_error(kappa: ArrayLike) -> NDArray[np.float64]:
    """Share of a sinusoid's mean square that its chords miss; κ = wavenumber × spacing of the corners.

    The mean of |e^{iκu} − (1 − u) − u e^{iκ}|² over 0 < u < 1: 5/3 + cos κ/3 − 4 (1 − cos κ)/κ², κ⁴/120 of long waves.
    """
    kappa = np.abs(np.asarray(kappa, dtype=np.float64))
    cosine = np.cos(kappa)
    with np.errstate(divide="ignore", invalid="ignore"):
        exact = 5.0 / 3.0 + cosine / 3.0 - 4.0 * (1.0 - cosine) / kappa**2
    return np.where(kappa < 0.1, kappa**4 / 120.0, exact)  # the exact form cancels to κ⁴


# ------------------------------------------------------------------------------------------------------ the model


_Components = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
_NO_WAVES: _Components = (np.zeros(1), np.zeros(1), np.zeros(1))


@dataclass(frozen=True)
class _Waves:
    """The resolved sea as a sum of waves; waves that run to and fro are one."""

    variance: NDArray[np.float64]  # (wave,) m²
    east: NDArray[np.float64]  # (wave,) rad/m
    north: NDArray[np.float64]
    spacing: float  # m, of the grid of the random ones

    @classmethod
    def of(cls, sea: SeaSettings) -> _Waves:
        spacing = resolution(sea)
        components: list[_Components] = [_NO_WAVES]
        for waves in sea.waves:
            if isinstance(waves, SinusoidWaves):
                east, north = travel_direction(waves)
                k = 2.0 * np.pi / waves.wavelength_m
                components.append((np.array([waves.height_m**2 / 8.0]), np.array([k * east]), np.array([k * north])))
            elif isinstance(waves, RandomWaves):
                components.append(_random(spectral_system(waves, sea.depth_m), np.pi / spacing))
        variance, east, north = (np.concatenate(each) for each in zip(*components, strict=True))
        return cls(variance, east, north, spacing)

    def toward(self, azimuth_deg: float) -> NDArray[np.float64]:
        """(wave,) wavenumber along an azimuth."""
        return self.east * np.sin(np.radians(azimuth_deg)) + self.north * np.cos(np.radians(azimuth_deg))

    def slope(self, azimuth_deg: float) -> float:
        """rms slope along an azimuth."""
        return float(np.sqrt(self.variance @ self.toward(azimuth_deg) ** 2))

    @cached_property
    def _missed(self) -> dict[float, NDArray[np.float64]]:
        return {}

    def missed(self, azimuth_deg: float, spacing: NDArray[np.float64]) -> NDArray[np.float64]:
        """rms height [m] that chords between corners `spacing` apart along an azimuth miss."""
        azimuth = round(azimuth_deg % 180.0, 6)  # across one look is along another
        if azimuth not in self._missed:
            square = self.variance @ chord_error(self.toward(azimuth)[:, None] * _SPACINGS)
            self._missed[azimuth] = np.sqrt(square)
        return np.interp(np.log(spacing), np.log(_SPACINGS), self._missed[azimuth])

    def flattened(self, azimuth_deg: float, spacing: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean-square slope along an azimuth that chords average away."""
        k = self.toward(azimuth_deg)[:, None]
        return (self.variance * k[:, 0] ** 2) @ (1.0 - np.sinc(k * spacing / (2.0 * np.pi)) ** 2)


def _random(system: SpectralSystem, limit: float) -> _Components:
    """Variance, east and north of the waves that stand for a system's up to `limit` rad/m."""
    longest = system.peak_wavenumber / 4.0
    if longest >= limit:
        return _NO_WAVES
    edges = np.geomspace(longest, limit, _WAVENUMBERS + 1)
    k = np.sqrt(edges[1:] * edges[:-1])[:, None]
    angle, share = np.zeros(1), np.ones((1, 1))
    if system.spreading is not None:
        angle = np.pi * (np.arange(_ANGLES) + 0.5) / _ANGLES
        cosine, sine, each = np.cos(angle) + 0.0 * k, np.sin(angle) + 0.0 * k, k + 0.0 * angle
        share = (system.spreading(each, cosine, sine) + system.spreading(each, -cosine, -sine)) * (np.pi / _ANGLES)
    variance = system.radial(k) * np.diff(edges)[:, None] * share
    (east, north), along, across = system.toward, k * np.cos(angle), k * np.sin(angle)
    return variance.ravel(), (along * east - across * north).ravel(), (along * north + across * east).ravel()


class _Errors:
    """Predicted rms errors (look, range, facet size, columns) of a radar's cells."""

    def __init__(
        self, waves: _Waves, radar: RadarSettings, facet: NDArray[np.float64], columns: NDArray[np.int_], fade: float
    ) -> None:
        self.facet, self.columns = facet, columns
        self.range = _ranges(radar)
        looks = _looks(radar)
        width = self.range[:, None] * np.radians(antenna_array(radar).narrowest_beam_deg) / columns
        cell = range_cell(radar)
        steep = max(float(np.hypot(waves.slope(0.0), waves.slope(90.0))), 1e-9)
        along = np.stack([waves.missed(look, facet) for look in looks])[:, None, :, None]
        flattened = np.stack([waves.flattened(look, facet) for look in looks])[:, None, :, None]
        across = np.stack([waves.missed(look + 90.0, width) for look in looks])[:, :, None, :]
        by_rungs = np.hypot(_ALONG * along, _SNAP * steep * facet[:, None]) / (steep * cell)
        by_columns = across / np.sqrt(columns) / (steep * cell)
        shift, faded = np.hypot(by_rungs, by_columns), fade * flattened
        self.height = steep * cell * np.hypot(shift, _HEIGHT_PER_DB * faded)
        self.power = np.hypot(_POWER_PER_SHIFT * shift, faded)
        self.visible = np.minimum(np.hypot(_VISIBLE_BY_RUNGS * by_rungs, _VISIBLE_BY_COLUMNS * by_columns), 1.0)
        slopes = np.array([max(waves.slope(look), 1e-9) for look in looks])
        seen = shadowing_smith67(radar.height_m / (np.sqrt(2.0) * slopes[:, None] * self.range))
        whole = seen.sum(axis=1, keepdims=True)  # 0 where nothing is seen of any range, and nothing is weighed
        self._weight = np.divide(seen, whole, out=np.zeros_like(seen), where=whole > 0.0)[:, :, None, None]
        if steep <= 1e-9:  # a flat sea is its own mesh
            self.height, self.power, self.visible = (0.0 * each for each in (self.height, self.power, self.visible))
        level = _level_errors(radar, facet)
        self.height = np.hypot(self.height, level.height_m[None, :, :, None])
        self.power = np.hypot(self.power, level.power_db[None, :, :, None])

    def window(self, errors: NDArray[np.float64]) -> NDArray[np.float64]:
        """rms (facet size, columns) over the ranges of the worst look, by how much is seen there."""
        return np.sqrt(np.sum(self._weight * errors**2, axis=1)).max(axis=0)

    def detail(self, cell: tuple[np.intp, ...], count: int, limited_by: str) -> MeshDetail:
        """What was chosen."""
        every = (self.height, self.power, self.visible)
        height, power, visible = (float(self.window(each)[cell]) for each in every)
        rows = zip(self.range, *(np.sqrt(np.mean(each[:, :, *cell] ** 2, axis=0)) for each in every), strict=True)
        return MeshDetail(
            facet_m=float(self.facet[cell[0]]),
            columns_per_beam=int(self.columns[cell[1]]),
            facets=count,
            height_error_m=height,
            power_error_db=power,
            visible_error=visible,
            by_range=tuple((float(r), float(h), float(p), float(v)) for r, h, p, v in rows),
            limited_by=limited_by,
        )


def _looks(radar: RadarSettings) -> NDArray[np.float64]:
    """Azimuths that stand for the sector; there and back are alike to the model, so half a circle is a whole one."""
    start, width = radar.sector_deg[0], sector_width(radar)
    if radar.scan == "staring":
        return np.array([start + 0.5 * width])
    if width > 150.0:
        start, width = 0.0, 180.0
    number = max(1, int(np.ceil(width / _LOOK_DEG)))
    return start + width * (np.arange(number) + 0.5) / number


def _coarsest(sea: SeaSettings, spacing: float, radar: RadarSettings) -> tuple[float, str]:
    """The largest facet size that is ever chosen, and why."""
    limits = [(level_facet(radar), "the radar's range cell")]
    if any(isinstance(waves, RandomWaves) for waves in sea.waves):
        limits.append((spacing, "the grid of the sea's waves, sea.resolution_m"))
    regular = [waves for waves in sea.waves if isinstance(waves, SinusoidWaves) and waves.height_m > 0.0]
    limits += [(waves.wavelength_m / _RUNGS_A_WAVE, "the regular wave's length") for waves in regular]
    limit, reason = min(limits)
    return max(_round_down(limit), _LEAST_FACET), reason


def _round_down(value: float) -> float:
    """Rounded down, so that sizes are plain numbers."""
    scale = 10.0 ** (1 - np.floor(np.log10(value)))
    return float(f"{np.floor(value * scale * (1.0 + 1e-12)) / scale:.2g}")


def _facet_sizes(coarsest: float) -> NDArray[np.float64]:
    """What is tried, from the coarsest down."""
    number = int(np.log(coarsest / _LEAST_FACET) / np.log(_LADDER))
    return np.array(list(dict.fromkeys(_round_down(coarsest * _LADDER**-n) for n in range(number + 1))))
