"""From a turn's interferogram to heights: one cell at a time, along a sliding plane, or by optimal interpolation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..conventions import wrap_phase
from .description import RadarDescription
from .error_covariance import BrightSpots, ErrorCovariance, Offsets, correlation_beside, correlation_by_range
from .interferogram import Interferogram
from .optimal import MeasuredHeights, optimal_heights
from .poses import Heights
from .quality import gate_median
from .sea_covariance import SeaCovariance
from .slopes import local_planes
from .speckle import ONE_CELL, Weights, wrapped_variance
from .windows import PhaseSlopes, window_weights

Map = NDArray[np.float64]


_UNSEEN = 0.02  # of the errors' variance: a smaller sea's is not distinguishable from none
_SHORTEST = 0.6  # rad/m, of waves that a map shows
_FEWEST_LOOKS = 3


@dataclass(frozen=True)
class Estimate:
    """Heights of a turn; arrays (look, gate)."""

    heights: Heights
    echo_power: Map  # W, without noise
    echoing: NDArray[np.bool_]  # cells with an echo of their own
    variance: Map  # rad², of the phase of the covariance that was averaged, not wrapped
    ambiguous: NDArray[np.bool_]
    window: Weights  # that it was averaged over
    incoherent: Map  # W, that the receivers do not share
    std: Map  # m, of the height, from speckle and noise
    edge: Map  # m, of Interferogram.edge, what is left in the height
    slope_rms: float | None = None  # of the sea in any one direction, where its covariance is known
    # Variances of the cells' mean slopes, outward and clockwise, and their covariance (3, look, gate), where known.
    of_slopes: Map | None = None
    dwells: tuple[Map, Map] | None = None  # m, heights of single dwells and gates, and their errors, where found


def single_cell(given: Interferogram) -> Estimate:
    """Heights from the covariance of each cell alone."""
    settings, radar = given.settings, given.model.radar
    window = (
        window_weights(settings.cell_range_m, radar.spacing),
        window_weights(settings.cell_azimuth_deg, given.echo.width),
    )
    return _averaged(given, window, given.level_slopes)


def sliding_plane(given: Interferogram) -> Estimate:
    """Heights from a wider window that follows the slopes of the single cells' map."""
    settings, radar = given.settings, given.model.radar
    first = _averaged(given, (window_weights(settings.cell_range_m, radar.spacing), np.ones(1)), given.level_slopes)
    window = (
        window_weights(settings.window_range_m, radar.spacing),
        window_weights(settings.window_azimuth_deg, given.echo.width),
    )
    return _averaged(given, window, _wave_phase_slopes(given, first), first)


def adaptive(given: Interferogram) -> Estimate:
    """Heights by optimal interpolation between single dwells and gates, each weighted by its echo.

    The map of sliding planes gives the cycle of each phase; the sea's covariance is taken from the same heights.
    Of fewer than three looks it is not known across them, nor where no cycle is sure: then that map is all.
    """
    start = sliding_plane(given)
    echoing = start.echoing & np.isfinite(start.heights.height)
    sure = echoing & ~start.ambiguous
    if given.dwell.cross.shape[0] < _FEWEST_LOOKS or not sure.any():
        return start
    model, heights, settings = given.model, start.heights, given.settings
    dwells, errors = _dwell_heights(given, start)
    variance = errors.variance
    ground = model.ground(heights.points)
    level, level_variance = mean_plane(np.where(sure, dwells, np.nan), errors, *ground)
    waves = dwells - level
    # Near and far are the radar's: a boat may be far from the origin.
    east, north = (each - centre for each, centre in zip(ground, model.poses.centre, strict=True))
    footprint = model.radar.footprint(given.echo.width)
    sea = SeaCovariance.of(np.where(sure, waves, np.nan), np.where(sure, variance, np.nan), east, north, footprint)
    height, error, of_slopes = optimal_heights(
        # A cell that may be a cycle off has no weight in its neighbours' heights; theirs have in its own.
        MeasuredHeights(
            np.where(start.ambiguous, np.nan, waves),
            errors,
            ground,
            model.outward(*ground),
            0.5 * (footprint[0] ** 2 + (footprint[1] * model.radar.ranges) ** 2),
        ),
        sea,
        echoing,
        (settings.cell_range_m, np.radians(settings.cell_azimuth_deg)),
        model.radar.ranges,
    )
    # Where the sea is smaller than the heights' errors, only that upper bound of it is known.
    usual = variance[sure & np.isfinite(variance)]
    unseen = _UNSEEN * max(0.0, (float(np.median(usual)) if usual.size else 0.0) - sea.variance)
    across = np.radians(settings.cell_azimuth_deg) * model.radar.ranges
    unseen = np.maximum(unseen, sea.unresolved_mean(settings.cell_range_m, across))
    error = error + level_variance + unseen
    of_slopes[:2] += unseen * _SHORTEST**2
    made = model.heights_at(heights.cells, level + height)
    slope_rms = float(np.sqrt(sea.slope_variance))
    return replace(
        start,
        heights=made,
        std=np.sqrt(error),
        # It was worked out for level water: a slope m in place of H/R puts the echo's centre m/(H/R) times as much off.
        edge=np.minimum(slope_rms * model.radar.ranges / model.poses.fan.height, 1.0) * given.edge,
        slope_rms=slope_rms,
        of_slopes=of_slopes,
        dwells=(dwells, np.sqrt(variance)),
    )


def _dwell_heights(given: Interferogram, start: Estimate) -> tuple[Map, ErrorCovariance]:
    """Heights [m] of single dwells and gates of a distributed sea, bright spots taken off, and their errors.

    Phases lie on the cycles of a map that is less noisy, and turn within a pulse as its phases do.
    """
    model, expected = given.model, start.heights.phase
    phase = expected + wrap_phase(np.angle(given.dwell.cross) - expected)
    variance = given.variances(given.dwell, ONE_CELL, start.incoherent)[0]
    spots, offsets = bright_spots(given, expected, start.echoing, variance)
    each = model.heights_of(given.dwell, phase - offsets.phase - model.flat)
    return each.height - given.edge, _errors(given, each.gain, start, spots, offsets)


def bright_spots(
    given: Interferogram, phase: Map, echoing: NDArray[np.bool_], variance: Map
) -> tuple[BrightSpots, Offsets]:
    """Of a pulse, and what they do to the phases of single dwells on a surface of that phase [rad], which speckle gives
    a variance [rad²]; (look, gate)."""
    radar, samples = given.model.radar, given.dwelt.samples(ONE_CELL, given.model.radar)
    spots = BrightSpots.of(radar.response, radar.spacing)
    ratio = samples.noise / samples.speckle
    power, around = given.echo.dwells, given.echo.neighbourhood_mean
    offsets = spots.offsets(power, around, echoing, given.echo.noise, ratio, given.turn(phase))
    return spots, offsets.shrink_for_speckle(variance / given.doubt, samples.speckle)


def _errors(given: Interferogram, gain: Map, start: Estimate, spots: BrightSpots, offsets: Offsets) -> ErrorCovariance:
    """Of the heights of dwells and gates, gain (look, gate) [m/rad], less what bright spots tell of them."""
    radar = given.model.radar
    speckle, noise = given.variances(given.dwell, ONE_CELL, start.incoherent)
    speckle = speckle + given.texture(start.incoherent)
    tilted = given.tilted_share(start.incoherent, start.heights.phase)
    with np.errstate(invalid="ignore"):  # nothing of no error
        parts = np.stack((speckle * tilted * offsets.left, speckle * (1.0 - tilted), noise))
    along = correlation_by_range(radar.response, radar.spacing * np.arange(min(radar.ranges.size, 9)), spots)
    return ErrorCovariance(gain * np.sqrt(np.nan_to_num(parts, posinf=np.inf)), along, correlation_beside(given.dwelt))


ESTIMATORS = {"adaptive": adaptive, "single_cell": single_cell, "sliding_plane": sliding_plane}


def _averaged(given: Interferogram, window: Weights, along: PhaseSlopes, before: Estimate | None = None) -> Estimate:
    """Heights of a window's means; their cycles are those of an earlier map, if there is one."""
    cells = given.windowed(window, along)
    echo_power = given.echo.window_mean(window)
    echoing = given.echoing(cells, echo_power)
    if before is None:
        incoherent = given.incoherent(along)
        variance = given.variance(cells, window, incoherent)
        heights, ambiguous = given.resolved(cells, variance, echoing)
    else:
        heights, ambiguous = given.heights_near(cells, before.heights, before.echoing, before.ambiguous)
        incoherent = given.incoherent_about(heights.phase)
        variance = given.variance(cells, window, incoherent)
    std = heights.gain * np.sqrt(wrapped_variance(variance))
    return Estimate(heights, echo_power, echoing, variance, ambiguous, window, incoherent, std, given.edge)


def _wave_phase_slopes(given: Interferogram, first: Estimate) -> PhaseSlopes:
    """Phase slopes of the waves that a first map shows.

    By planes over three looks and a cell and a half to either side; shorter ones would follow steeper waves, and more
    noise. Strong echoes count for more, up to thrice the median.
    """
    model, heights = given.model, first.heights
    radar = model.radar
    power = heights.cells.lower
    with np.errstate(invalid="ignore", divide="ignore"):
        weight = np.clip(np.nan_to_num(power / gate_median(power, np.isfinite(power))), 0.0, 3.0)
    ground = model.ground(heights.points)
    reach = 1.0 + max(1, round(1.5 * given.settings.cell_range_m / radar.spacing)), 2.0
    planes = local_planes(heights.height, weight, ground, model.outward(*ground), reach)
    per_height = model.rise_sign * np.nan_to_num(1.0 / heights.gain, posinf=0.0, neginf=0.0)
    step = _ground_step(radar, heights.ground_range, model.poses.fan.height - heights.height, planes.outward)
    across = heights.ground_range * np.radians(given.echo.width)
    return PhaseSlopes(
        model.flat_per_gate + np.nan_to_num(planes.outward * step) * per_height,
        np.nan_to_num(planes.clockwise * across) * per_height,
        model.level,
    )


def _ground_step(radar: RadarDescription, ground_range: Map, drop: Map, slope: Map) -> Map:
    """Ground range from a gate to the next along a surface of that slope: r dr = (x − drop · slope) dx.

    Kept within three gates' spacing: where the surface faces the radar squarely, many points share a gate.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        step = radar.ranges / (ground_range - drop * np.nan_to_num(slope))
    return radar.spacing * np.clip(np.where(step > 0.0, step, 3.0), 0.0, 3.0)


_TOGETHER = 100.0  # cells of a few metres that lie on the same part of a wave: 30 m a side


def mean_plane(height: Map, errors: ErrorCovariance, x: Map, y: Map) -> tuple[Map, Map]:
    """The plane [m] through a turn's heights [m] at x, y [m], and the variance [m²] that their errors leave it; all
    (look, gate). 0 where there are too few for a plane."""
    variance = errors.variance
    known = np.isfinite(height) & np.isfinite(variance) & np.isfinite(x) & np.isfinite(y)
    if np.count_nonzero(known) < 3:
        return np.zeros(height.shape), np.zeros(height.shape)
    sea = float(np.median(height[known] ** 2)) + 1e-9
    root = 1.0 / np.sqrt(sea + variance[known] / _TOGETHER)
    terms = np.stack((np.ones(root.size), x[known], y[known]), axis=1)
    scale = np.maximum(np.abs(terms).max(axis=0), 1e-9)
    inverse = np.linalg.pinv(terms / scale * root[:, None], rcond=1e-9)
    plane = inverse @ (height[known] * root) / scale
    doubt = (inverse * (errors.mean_variance[known] * root**2)) @ inverse.T / np.outer(scale, scale)
    places = np.stack((np.ones(x.shape), np.nan_to_num(x), np.nan_to_num(y)))
    level = np.einsum("i,i...->...", plane, places)
    return level, np.einsum("i...,ij,j...->...", places, doubt, places)
