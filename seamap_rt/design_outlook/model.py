"""What a design is likely to see, at once: strips of random sea, an exact horizon, the link budget, expected errors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.special import gammaincc

from ..compute.machine import one_blas_thread
from ..conventions import POLARIZATIONS, db, from_db, ground_range, written
from ..errors import InputError
from ..interferometry.slopes import SHADOW_WINDOW, diffraction_height_error
from ..io.text import shown
from ..measured import FULLY_MEASURED, LEVEL, CoverageProfile
from ..physics.shadowing import SEEN_DB, half_range, half_range_refusal
from ..radar import link
from ..radar.array import with_scanned_sector
from ..scattering.permittivity import permittivity_of
from ..scene import Scene, SceneLike, as_scene
from ..settings import PlatformSettings
from ..settings.sea import DEFAULT_RESOLUTION_M
from ..tracing.unresolved_waves import UnresolvedWaves
from .error import Design, Spectrum, ambiguous_share, error_variance, information, score
from .motion import Motion
from .strips import (
    LOOKS,
    ROW_M,
    ROWS,
    STARTS,
    TABLE,
    Sight,
    calibrated,
    echo_by_grazing,
    radar_sight,
    sight,
    snr_of_unity,
    strips,
    table_grazing,
    waves_of,
)

if TYPE_CHECKING:
    import xarray as xr


Array = NDArray[np.float64]

_CENTRES = np.arange(0, ROWS, 4)  # rows in whose middle cells are taken
_AROUND_M = 9.0  # along the look: what a cell's height is found from
_SMOOTH_M = 25.0  # of ranges over which few cells' scatter is averaged
_HALF = 0.5  # of a cell in sight, for it to count
_RADII = ("fully_measured_radius_m", "reach_m", "reach_to_the_end")

_VARIABLES = {
    "visible_fraction": ("1", "share of the sea's horizontal area that both antennas see"),
    "seen_fraction": ("1", "share of the cells that are more than half visible"),
    "answered_fraction": ("1", "share of these that get a sure height"),
    "height_error": ("m", "rms error of these heights"),
    "quality": ("1", "mean score of all cells: 1 is a perfect height, 0 none or one no better"),
    "snr_db": ("dB", "signal-to-noise ratio of one pulse, mean over the sea, shadows counted as 0"),
}


def half_range_key(polarization: str) -> str:
    """Of an outlook's figures, that of the range to which half of the water is visible to a radar."""
    return f"half_visible_{polarization.lower()}_m"


_HALF_RANGES = {"light": "half_visible_m"} | {each: half_range_key(each) for each in POLARIZATIONS}


@dataclass(frozen=True)
class Outlook:
    """An outlook as plain arrays: `outlook` has it as a Dataset.

    range (gate,) slant [m]; profile: each of `_VARIABLES`, (gate,); radar_visible: share of the water that a radar sees
    (polarization, gate); figures: the two radii, whether the reach is the window's end, the first radius of the same
    radar on a boat at rest, and the ranges [m] to which half of the water is visible, NaN where there is none;
    left_out: what it does not know of the scene, motion: how large the boat's and its sensors' errors are, in words,
    empty where neither is.
    """

    range: Array
    profile: dict[str, Array]
    radar_visible: Array
    figures: dict[str, Any]
    left_out: str
    motion: str


def outlook(scene: SceneLike) -> xr.Dataset:
    """What a radar is likely to measure of a scene's sea, without simulating it: some tens of milliseconds.

    A Dataset over `range` (slant, m) with `visible_fraction`, `seen_fraction`, `answered_fraction`, `height_error` [m],
    `quality` and `snr_db`; attributes `fully_measured_radius_m`, `reach_m`, `reach_to_the_end` (as in a run's
    metrics; None without waves), `radius_at_rest_m`, `motion` and `left_out`. `radar_visible_fraction` (polarization,
    range) is the share of the water that returns −6 dB or more of its two-way power when lit, in VV and HH; to
    `half_visible_m`, `half_visible_vv_m` and `half_visible_hh_m` half is visible to light and to these. The same random
    strips of sea serve every scene, so that designs compare on the same waves. A model, not a simulation: README and
    validation say how far the two are apart. Raises InputError for a radar without a baseline or a window that holds no
    sea.
    """
    import xarray as xr

    found = estimate_outlook(as_scene(scene))
    variables: dict[str, Any] = {
        name: ("range", found.profile[name], {"units": units, "long_name": words})
        for name, (units, words) in _VARIABLES.items()
    }
    words = f"share of the water that returns {SEEN_DB:g} dB or more of its two-way power when lit"
    attributes = {"units": "1", "long_name": words}
    variables["radar_visible_fraction"] = (("polarization", "range"), found.radar_visible, attributes)
    coordinates = {
        "range": ("range", found.range, {"units": "m", "long_name": "slant range"}),
        "polarization": list(POLARIZATIONS),
    }
    about = {"reach_level": LEVEL, "motion": found.motion, "left_out": found.left_out}
    return xr.Dataset(variables, coordinates, {**found.figures, **about})


@one_blas_thread()
def estimate_outlook(scene: Scene) -> Outlook:
    """The same as `outlook` says, without the half second that the first Dataset of a process takes."""
    radar, settings = with_scanned_sector(scene.radar), scene.resolved_retrieval
    design = Design.of(radar, settings, scene.scattering.decorrelation_time_s)
    if design.baseline <= 0.0:
        raise InputError("radar.baseline_m = 0: must be greater than 0, or a phase says nothing of heights; raise it")
    if design.ranges.size < 2:
        raise InputError(
            f"radar.range_m = {shown(radar.range_m)}: must reach beyond radar.height_m = {radar.height_m:g}, where the "
            "sea begins; widen it"
        )
    limit = np.pi / float(scene.sea.resolution_m or DEFAULT_RESOLUTION_M)
    waves = waves_of(scene.sea, limit)
    sea, slope = waves.elevation_variance, waves.slope_variance
    surface = strips(waves, design.ranges[-1] + design.cell_m, 2.0 * np.pi / limit)
    looks = np.tile(surface.azimuth, STARTS)
    slant = (design.ranges + side * design.cell_m for side in (-0.5, 0.5))
    near, far = (ground_range(each, radar.height_m) for each in slant)
    table = echo_by_grazing(scene.scattering, radar.frequency_hz, limit, np.sqrt(slope), surface.azimuth)
    in_sight, facing = _unhidden(scene, limit, surface.azimuth)
    motion = Motion.of(scene, radar, waves)
    eye = radar.height_m - 0.5 * design.baseline + (np.zeros(STARTS) if motion is None else motion.rise)
    seen = sight(surface, eye, (near, far), table * facing, in_sight)
    nrcs = calibrated(scene.scattering, radar.frequency_hz, seen.echo, link.grazing_angle(radar, design.ranges), looks)
    cell, dwell, window = (_cross_look_weights(width) for width in _widths(design))
    unity = snr_of_unity(radar, design.ranges, None if motion is None else motion.lean)
    unity = np.broadcast_to(unity, (looks.size, design.ranges.size))[:, None]
    visible, snr = _rows(seen.visible, cell), _rows(nrcs, dwell) * unity
    (start, stop), beside = radar.sector_deg, 180.0 / LOOKS  # looks less than half a step beside the sector count
    inside = np.flatnonzero((looks - start + beside) % 360.0 <= min(360.0, stop - start + 2.0 * beside))
    counts = visible > _HALF
    above_noise = _above_noise(design, _rows(nrcs, window) * unity, settings.min_snr_db)
    spectrum = Spectrum.of(waves)
    known = (information(design, spectrum, snr) * above_noise).mean(axis=1)
    known = uniform_filter1d(known, max(1, round(_AROUND_M / design.spacing)), axis=1)
    error = error_variance(design, spectrum, known, sea)[:, None] + _hidden(design, seen, cell, visible, counts)
    moves, angle = "", 1e-3 * (settings.diffraction_mrad or 0.0)
    if angle > 0.0 and sea > 0.0:
        hidden = 1.0 - uniform_filter1d(visible.mean(axis=1), max(1, round(SHADOW_WINDOW[1] / design.spacing)), axis=1)
        error += diffraction_height_error(hidden, design.ranges, np.sqrt(sea), angle)[:, None] ** 2
    if motion is not None:
        error += np.tile(motion.height_variance(design, waves), (STARTS, 1))[:, None]
        moves = motion.in_words(design, waves)
    audible = (snr * above_noise).sum(axis=(0, 1)) / np.maximum(above_noise.sum(axis=(0, 1)), 1e-12)
    sure = above_noise * (1.0 - ambiguous_share(design, spectrum, audible, sea)) * counts
    visible, snr, counts, sure, error = visible[inside], snr[inside], counts[inside], sure[inside], error[inside]
    quality = np.mean(sure * score(error, sea), axis=(0, 1)) if sea > 0.0 else np.full(design.ranges.size, np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        profile = (
            visible.mean(axis=(0, 1)),
            counts.mean(axis=(0, 1)),
            sure.sum(axis=(0, 1)) / counts.sum(axis=(0, 1)),
            np.sqrt((sure * error).sum(axis=(0, 1)) / sure.sum(axis=(0, 1))),
            quality,
            db(np.maximum(snr.mean(axis=(0, 1)), 1e-30)),
        )
    water = permittivity_of(scene.scattering, radar.frequency_hz)
    radar_visible = radar_sight(surface, eye, (near, far), water, design.wavelength)[:, inside].mean(axis=1)
    even, none = np.ones(design.ranges.size), np.zeros(design.ranges.size)
    measured = CoverageProfile(design.ranges, quality, even, even, none).figures
    figures: dict[str, Any] = {name: measured[name] for name in _RADII}
    figures |= _half_ranges(design.ground, profile[0], radar_visible)
    at_rest = scene.model_copy(update={"platform": PlatformSettings(heading_deg=scene.platform.heading_deg)})
    figures["radius_at_rest_m"] = (figures if motion is None else estimate_outlook(at_rest).figures)[
        "fully_measured_radius_m"
    ]
    profiles = dict(zip(_VARIABLES, profile, strict=True))
    return Outlook(design.ranges, profiles, radar_visible, figures, _unmodelled_parts(scene), moves)


def _unhidden(scene: Scene, limit: float, looks: Array) -> tuple[Array, Array]:
    """By local grazing angle (look, TABLE), of ground that the strips light and of its echo, what waves beyond `limit`
    [rad/m] leave in sight."""
    unresolved = UnresolvedWaves.of(scene, limit)
    if unresolved is None:
        return np.ones((looks.size, TABLE)), np.ones((looks.size, TABLE))
    in_sight, facing = unresolved.shares(np.tan(table_grazing()), looks[:, None])
    return in_sight, facing if scene.scattering.nrcs == "two_scale" else in_sight


def _half_ranges(ground: Array, visible: Array, radar_visible: Array) -> dict[str, float]:
    """Ground ranges [m] to which half is visible; NaN where more or less is, all over the window."""
    found = half_range(ground, np.vstack((visible, radar_visible)))
    return dict(zip(_HALF_RANGES.values(), map(float, found), strict=True))


def _unmodelled_parts(scene: Scene) -> str:
    """Parts of this scene that the outlook does not model."""
    left = {
        "objects and the boat's own structure": bool(scene.objects),
        "sharper crests": scene.sea.model != "linear",
        "sea spikes": scene.scattering.breaking and scene.scattering.has_sea_spikes,
    }
    return ", ".join(name for name, is_there in left.items() if is_there)


def _widths(design: Design) -> tuple[Array, Array, Array]:
    """Standard deviations [m] (gate,) across the look of a cell, a dwell's echo and the window that decides."""
    ground = design.ground
    window = np.hypot(design.beam, design.window_rad / np.sqrt(12.0))
    return design.cell_rad / np.sqrt(12.0) * ground, design.beam * ground, window * ground


def _cross_look_weights(std: Array) -> Array:
    """Weights (centre, row, gate) of means across the look, of a standard deviation [m] (gate,)."""
    apart = np.arange(ROWS)[None] - _CENTRES[:, None]
    offset = ROW_M * ((apart + ROWS // 2) % ROWS - ROWS // 2)[..., None]
    weight = np.exp(-0.5 * (offset / np.maximum(std, 0.3 * ROW_M)) ** 2)
    return weight / weight.sum(axis=1, keepdims=True)


def _rows(field: NDArray[np.float32], weight: Array) -> Array:
    """(look, centre, gate) means over rows."""
    return np.einsum("lrg,crg->lcg", field, weight.astype(np.float32), optimize=True).astype(np.float64)


def _above_noise(design: Design, snr: Array, least_db: float) -> Array:
    """Chance (look, centre, gate) that a window's power, which fades by its speckle, stands over the threshold."""
    mean = uniform_filter1d(snr, max(1, round(design.window_m / design.spacing)), axis=2)
    levels = np.linspace(-30.0, 30.0, 241)  # dB of the mean over the threshold: between them a line is good to 1e-4
    chance = gammaincc(design.window, design.window / from_db(levels))
    return np.interp(db(np.maximum(mean, 1e-12)) - least_db, levels, chance)


def _hidden(design: Design, seen: Sight, cell: Array, visible: Array, counts: NDArray[np.bool_]) -> Array:
    """Variance [m²] (gate,) of what is seen of cells over their mean height, about its own mean."""
    with np.errstate(invalid="ignore", divide="ignore"):
        excess = np.where(counts, _rows(seen.lit_height, cell) / visible - _rows(seen.height, cell), 0.0)
    number = np.maximum(counts.sum(axis=(0, 1)), 1)
    mean = excess.sum(axis=(0, 1)) / number
    square = (excess**2).sum(axis=(0, 1)) / number
    return uniform_filter1d(np.maximum(square - mean**2, 0.0), max(1, round(_SMOOTH_M / design.spacing)))


_STEPS = (25.0, 50.0, 100.0, 250.0, 500.0)  # m, of which the finest that gives at most _LINES is taken
_LINES = 12
_NOTHING = 0.05  # per cent: a chance that is less is none


def outlook_rows(found: Outlook) -> Iterator[str]:
    """The two radii first, then a table by range."""
    radius, reach = found.figures["fully_measured_radius_m"], found.figures["reach_m"]
    if radius is None:
        yield "no waves: nothing is there to measure"
    else:
        end = "at least " if found.figures["reach_to_the_end"] else ""
        yield f"fully measured radius about {radius:.0f} m, reach {end}{reach:.0f} m (a model, not a simulation)"
    seen, answered = (_mean(found.profile[name]) for name in ("seen_fraction", "answered_fraction"))
    if reach == 0.0 and seen > 0.5 > answered:
        yield (
            "the echo lacks, not the light: raise radar.transmit_power_w or the antennas' gain, or point the beam at "
            "the sea by radar.tilt_deg"
        )
    yield _half_visible(found)
    if radius is not None and found.motion:
        cost = written(max(found.figures["radius_at_rest_m"] - radius, 0.0), 0)
        yield f"the boat's motion costs {cost} m of that radius: {found.motion}"
    if found.left_out:
        yield f"it does not know: {found.left_out}"
    yield FULLY_MEASURED
    yield (
        "visible: share of the sea's area that both antennas see; cells seen: those more than half visible; answered: "
        "with a sure height; height error: rms of these; SNR: of one pulse; score: 1 for a perfect height, 0 for none"
    )
    yield "range (m)  visible  cells seen  of these answered  height error (m)  SNR (dB)  score"
    ranges = found.range
    step = next((each for each in _STEPS if np.ptp(ranges) / each <= _LINES), _STEPS[-1])
    for middle in np.arange(np.ceil(ranges[0] / step) * step, ranges[-1] + 0.5 * step, step):
        inside = np.abs(ranges - middle) <= 0.25 * step
        here = {name: _mean(values[inside]) for name, values in found.profile.items()}
        shares = [_share(here[f"{name}_fraction"]) for name in ("visible", "seen", "answered")]
        error, snr, score = (here[name] for name in ("height_error", "snr_db", "quality"))
        error = error if 100.0 * here["answered_fraction"] > _NOTHING else np.nan
        yield (
            f"{middle:9.0f}  {shares[0]:>7}  {shares[1]:>10}  {shares[2]:>17}  {_format_with_floor(error, 1e-3):>16}  "
            f"{written(snr, 0):>8}  {_format_with_floor(score, 5e-4):>5}"
        )


def _half_visible(found: Outlook) -> str:
    """The range to which half of the water is visible to light and to a radar in each polarization, or why to none."""
    words: dict[str, list[str]] = {}
    shares = found.profile["visible_fraction"], *found.radar_visible
    for (name, key), share in zip(_HALF_RANGES.items(), shares, strict=True):
        far = found.figures[key]
        text = f"half is visible to {far:.0f} m" if np.isfinite(far) else half_range_refusal(found.range, share)
        words.setdefault(text, []).append(name)
    return "; ".join(f"{', '.join(names)}: {text}" for text, names in words.items())


def _mean(values: NDArray[np.float64]) -> float:
    """The mean of those that are numbers; NaN where there are none."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else np.nan


def _share(value: float) -> str:
    share = 100.0 * value
    return written(share if share > _NOTHING else 0.0 * share, 0) + (" %" if np.isfinite(share) else "")


def _format_with_floor(value: float, least: float) -> str:
    """A value with two digits; one below the least that counts is written as none."""
    return f"<{least:g}" if value < least else written(value, 2)
