"""The dataset of a shadowing study: tallies of every realisation become shares, bands, half ranges and run lengths.

Neighbouring azimuths and range bins share crests: they are not independent, and no band here counts them as if they
were. One seed is one draw, whatever it holds; bands are Student's, with one degree of freedom less than seeds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.special import stdtrit

from ..conventions import POLARIZATIONS, unit_from_azimuth
from ..mesh import PolarGrid
from ..physics.dispersion import angular_frequency
from ..physics.shadowing import (
    LEVELS_DB,
    half_range,
    half_range_refusal,
    regular_wave_visible_share,
    shadowing_smith67,
    shadowing_wagner67,
)
from ..products.statistics import expected_slope_variance
from ..report.reduce import main_waves
from ..scene import Scene
from ..sea import Sea, resolution
from ..sea.systems import travel_direction
from ..settings import SinusoidWaves
from .paired import FEWEST_SEEDS
from .visible_tally import Looks, Tally

Array = NDArray[np.float64]

CONFIDENCE = 0.95


def jackknife(
    statistic: Callable[[Array], Array], draws: Array, within: tuple[float, float] = (-np.inf, np.inf)
) -> tuple[Array, Array, Array]:
    """A statistic of the mean over draws (draw, …), and its 95 % band: estimate, low, high; within: what it can be.

    Quenouille's and Tukey's pseudo-values: for a statistic that is linear in the mean, the mean's own t band. NaN bands
    of fewer draws than FEWEST_SEEDS, and where the statistic is not defined without one of the draws.
    """
    number = len(draws)
    whole = statistic(draws.mean(axis=0))
    if number < FEWEST_SEEDS:
        unknown = np.full(np.shape(whole), np.nan)
        return whole, unknown, unknown
    total = draws.sum(axis=0)
    without = np.stack([statistic((total - draw) / (number - 1)) for draw in draws])
    spread = np.std((number - 1) * without, axis=0, ddof=1) / np.sqrt(number)
    reach = stdtrit(number - 1, 0.5 + 0.5 * CONFIDENCE) * spread
    low, high = (np.clip(each, *within) for each in (whole - reach, whole + reach))
    return whole, low, high


def neighbour_correlation(draws: Array, axis: int) -> float:
    """Correlation of neighbours along an axis, of what draws (draw, …) differ by from their mean: 0 if independent.

    NaN for a single draw, or where draws do not differ."""
    moved = np.moveaxis(draws - draws.mean(axis=0), axis, 0)
    one, other = moved[:-1], moved[1:]
    square = np.sum(one**2) * np.sum(other**2)
    return float(np.sum(one * other) / np.sqrt(square)) if square > 1e-24 else np.nan


def count_quantile(counts: NDArray[np.int64], share: float, room: NDArray[np.int64]) -> Array:
    """Quantile (…, bin) in steps of how often each length (…, bin, length) was counted; NaN without any.

    The last length counts runs cut short at the end of the mesh, none of them shorter than `room` (bin,): quantiles up
    to there are right all the same, and those beyond are NaN.
    """
    reached = np.cumsum(counts, axis=-1)
    number = reached[..., -1]
    length = np.argmax(reached >= share * number[..., None], axis=-1)
    return np.where((number > 0) & (length <= room), length, np.nan)


FUNCTIONS = {"smith": shadowing_smith67, "wagner": shadowing_wagner67}
_FAR_AND_NEAR = np.geomspace(1e6, 0.1, 5000)  # m, where half ranges are looked for
_LONG = 1e5  # wavelengths: a wave met so nearly abeam is flat along the look


def shadowing_share(name: str, height_m: float, slope_rms: Array, weight: Array, range_m: Array) -> Array:
    """Visible share (group, range) by one of `FUNCTIONS`, for groups of sectors with slopes (sector,) along the look.

    weight (group, sector): of the sectors in each group, each row adding up to 1. A flat sea is all seen.
    """
    with np.errstate(divide="ignore"):
        v = height_m / (np.sqrt(2.0) * slope_rms[:, None] * range_m)
    unknown = np.isnan(v)  # nothing was seen, or nothing was looked at
    return weight @ np.where(unknown, np.nan, FUNCTIONS[name](np.where(unknown, 0.0, v)))


def shadowing_half(name: str, height_m: float, slope_rms: Array, weight: Array) -> Array:
    """Ground range [m] (group,) at which `shadowing_share` is one half; infinite over a flat sea, else to 1e-5."""
    share = shadowing_share(name, height_m, slope_rms, weight, _FAR_AND_NEAR)
    half = [np.exp(np.interp(0.5, each, np.log(_FAR_AND_NEAR), left=np.nan)) for each in share]
    return np.where(share[:, 0] > 0.5, np.inf, half)


def resolved_slope(sea: Sea, azimuth_deg: ArrayLike) -> Array:
    """rms slope (n,) along azimuths (n,) of the resolved waves: the expectation, of no single realisation or mesh."""
    return np.sqrt([expected_slope_variance(sea, azimuth) for azimuth in np.asarray(azimuth_deg)])


def exact_wave(scene: Scene) -> SinusoidWaves | None:
    """The scene's only wave, if it is a regular one whose light has a closed form; else None."""
    if scene.sea.model != "linear" or len(scene.sea.waves) != 1 or scene.platform.motion != "fixed":
        return None
    (wave,) = scene.sea.waves
    return wave if isinstance(wave, SinusoidWaves) and wave.height_m > 0.0 else None


def exact_share(scene: Scene, wave: SinusoidWaves, grid: PolarGrid, height_m: float, edges: Array) -> Array:
    """Visible share of horizontal area (column, bin), crest by crest, each column at its own time and place."""
    east, north = travel_direction(wave)
    k = 2.0 * np.pi / wave.wavelength_m
    look_east, look_north = unit_from_azimuth(grid.column_azimuth)
    along = look_east * east + look_north * north
    current_east, current_north = unit_from_azimuth(scene.sea.current_toward_deg)
    drift = k * scene.sea.current_m_s * float(current_east * east + current_north * north)
    origin = grid.column_pose.origin[:, :2] @ (east, north)
    turning = float(angular_frequency(k, scene.sea.depth_m)) + drift
    phase = np.radians(wave.phase_deg) + k * origin - turning * grid.column_time
    below = 0.5 * wave.height_m * np.cos(phase)  # the water at the foot of the mast
    share = np.where((below < height_m)[:, None], 1.0, np.zeros(edges.size - 1))
    for column, cosine in enumerate(along):
        if abs(cosine) * _LONG < 1.0 or below[column] >= height_m:
            continue
        met = wave.wavelength_m / abs(cosine)
        ahead = phase[column] if cosine > 0.0 else -phase[column]
        share[column] = regular_wave_visible_share(wave.height_m, met, height_m, ahead, edges)
    return share


OUTSIDE = "outside the radar's sector"
_VARIABLES = {  # units and long name; _low and _high are the ends of the 95 % band over seeds
    "visible_fraction": ("1", "share of horizontal area that all antennas see"),
    "radar_visible_fraction": ("1", "share of horizontal area whose two-way power reaches the level"),
    "radar_r50": ("m", "ground range beyond which half or more is below the level"),
    "level": ("dB", "two-way power over that of the same water lit"),
    "crest_bias": ("m", "mean height of what is seen above the mean height of all"),
    "r50": ("m", "ground range beyond which half or more is shadowed"),
    "r50_note": ("", "why there is no such range"),
    "smith": ("1", "visible share, Smith 1967, with the meshed slope along each sector"),
    "wagner": ("1", "visible share, Wagner 1967, with the meshed slope along each sector"),
    "exact": ("1", "visible share of the regular wave, crest by crest"),
    "r50_smith": ("m", "ground range at which Smith's share is one half"),
    "r50_wagner": ("m", "ground range at which Wagner's share is one half"),
    "slope_rms": ("1", "rms slope along the look that the mesh carries"),
    "slope_rms_resolved": ("1", "rms slope along the look of the resolved waves, expected"),
    "shadow_run_median": ("m", "length of shadows that begin here, along the look, median"),
    "shadow_run_90": ("m", "length of shadows that begin here, along the look, 90 % are shorter"),
    "visible_run_median": ("m", "length of what is seen at a stretch and begins here, median"),
    "visible_run_90": ("m", "length of what is seen at a stretch and begins here, 90 % are shorter"),
    "share": ("1", "visible share of each realisation"),
    "azimuth": ("degree", "middle of the sector, clockwise from north"),
    "from_waves": ("degree", "sector's angle from where the highest waves come from: 0 looks into them"),
    "range": ("m", "ground range from the mast, middle of the bin"),
    "height": ("m", "radar.height_m, mean height of the antennas above mean sea level"),
    "lowest_antenna": ("m", "height of the lowest antenna, which Smith, Wagner and the exact share are for"),
    "azimuth_correlation": ("1", "correlation of neighbouring sectors' departures from the mean over seeds"),
    "range_correlation": ("1", "correlation of neighbouring range bins' departures from the mean over seeds"),
    "facet_m": ("m", "spacing of the mesh along the look"),
    "columns_per_beam": ("1", "columns of the mesh in a beam's width"),
    "resolution": ("m", "spacing of the resolved waves' grid"),
    "cutoff_wavelength": ("m", "shortest resolved wave, twice the spacing of the grid"),
}


@dataclass
class MastView:
    """One height, over the seeds."""

    tallies: list[Tally] = field(default_factory=list)
    lowest_m: float = np.nan
    reason: str = ""


@dataclass(frozen=True)
class Window:
    """Where it is counted: the mesh's grid, its looks, and the range bins."""

    grid: PolarGrid
    looks: Looks
    edges: Array  # (bin + 1,) m
    columns_per_beam: int

    @property
    def middle(self) -> Array:
        """(bin,) m, of the range bins."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])

    @property
    def rung_m(self) -> float:
        """m, between rungs of the mesh."""
        return float(self.grid.ground_range[1] - self.grid.ground_range[0])

    @property
    def room(self) -> NDArray[np.int64]:
        """(bin,) rungs from the bin to the end of the mesh."""
        return np.floor((self.grid.ground_range[-1] - self.edges[1:]) / self.rung_m).astype(np.int64)

    def empty_tally(self) -> Tally:
        """The tally of a mast that sees no sea, its areas empty: all shares are NaN."""
        groups, bins = len(self.looks.members), self.edges.size - 1
        empty, radar = np.zeros((groups, bins)), np.zeros((len(POLARIZATIONS), len(LEVELS_DB), groups, bins))
        runs = np.zeros((2, groups, bins, self.grid.ground_range.size), dtype=np.int64)
        return Tally(empty, empty, radar, empty, empty, np.zeros(groups), runs)


def shadowing_dataset(
    scene: Scene, heights: list[float], result: list[MastView], window: Window, sea: Sea, seeds: int
) -> xr.Dataset:
    """The study's dataset: each variable by sector and, with the prefix `look_`, by look; units as attributes."""
    looks, waves = window.looks, main_waves(scene)
    each = [_mast_dataset(scene, mast, window, seeds) for mast in result]
    whole = xr.concat(each, "height", data_vars="all", coords="minimal")
    sectors = whole.isel(group=slice(0, looks.sectors)).rename(group="azimuth")
    pooled = whole.isel(group=slice(looks.sectors, None)).rename(group="look")
    data = sectors.merge(pooled.rename({str(name): f"look_{name}" for name in pooled.data_vars}))
    data = data.assign_coords(lowest_antenna=("height", [mast.lowest_m for mast in result]))
    shares = data["share"].transpose("height", "seed", "azimuth", "range").values
    for axis, name in ((1, "azimuth"), (2, "range")):
        known = [np.isfinite(each).all() and each.shape[axis] > 1 for each in shares]
        correlations = [neighbour_correlation(s, axis) if k else np.nan for s, k in zip(shares, known, strict=True)]
        data[f"{name}_correlation"] = ("height", correlations)
    data["slope_rms_resolved"] = ("azimuth", resolved_slope(sea, looks.azimuth))
    spacing = resolution(scene.sea)
    meshed = {"facet_m": window.rung_m, "columns_per_beam": window.columns_per_beam}
    data = data.assign(resolution=spacing, cutoff_wavelength=2.0 * spacing, **meshed).assign_coords(
        height=heights,
        azimuth=looks.azimuth,
        from_waves=("azimuth", looks.from_waves),
        look=list(looks.names),
        polarization=list(POLARIZATIONS),
        level=list(LEVELS_DB),
        range=window.middle,
        seed=[scene.seed + number for number in range(seeds)],
    )
    for name in data.variables:
        plain = str(name).removeprefix("look_").removesuffix("_low").removesuffix("_high")
        if plain in _VARIABLES:
            units, words = _VARIABLES[plain]
            data[name].attrs = {"long_name": words} | ({"units": units} if units else {})
    bands = f"none, of {'one seed' if seeds == 1 else f'{seeds} seeds'}"
    if seeds >= FEWEST_SEEDS:
        bands = f"95 %, Student's t over {seeds} seeds ({seeds - 1} degrees of freedom)"
    data.attrs = {
        "title": f"Visible share of the sea of scene {scene.name}",
        "bands": bands + "; neighbouring looks and ranges share crests and count as one draw",
        "scene": scene.name,
        "waves_from_deg": waves.from_deg if waves else np.nan,
        "bin_m": float(window.edges[1] - window.edges[0]),
    }
    return data


@np.errstate(invalid="ignore", divide="ignore")
def _mast_dataset(scene: Scene, mast: MastView, window: Window, seeds: int) -> xr.Dataset:
    """One height's shares, half ranges, biases and runs, over (group, range)."""
    tallies = [window.empty_tally()] * seeds if mast.reason else mast.tallies
    middle, looks, both, radar = window.middle, window.looks, ("group", "range"), ("polarization", "level")
    share = np.stack([each.lit / each.area for each in tallies])
    answering = np.stack([each.answering / each.area for each in tallies])
    sums = np.stack([(each.area, each.lit, each.height, each.lit_height) for each in tallies])
    slope = np.sqrt(np.sum([each.slope for each in tallies], axis=0) / sums[:, 0].sum(axis=(0, 2)))
    visible = jackknife(lambda mean: mean, share, (0.0, 1.0))
    values: dict[str, object] = {"share": (("seed", *both), share)}
    for name, (dims, three) in {
        "visible_fraction": (both, visible),
        "crest_bias": (both, jackknife(lambda mean: mean[3] / mean[1] - mean[2] / mean[0], sums)),
        "r50": ("group", jackknife(lambda mean: half_range(middle, mean), share, (0.0, np.inf))),
        "radar_visible_fraction": ((*radar, *both), jackknife(lambda mean: mean, answering, (0.0, 1.0))),
        "radar_r50": ((*radar, "group"), jackknife(lambda mean: half_range(middle, mean), answering, (0.0, np.inf))),
    }.items():
        values |= {f"{name}{end}": (dims, each) for end, each in zip(("", "_low", "_high"), three, strict=True)}
    notes = [OUTSIDE if np.isnan(each).all() else half_range_refusal(middle, each) for each in visible[0]]
    values["r50_note"] = ("group", [mast.reason or note for note in notes])
    values["slope_rms"] = ("group", slope)
    for name in FUNCTIONS:
        theory = name, mast.lowest_m, slope[: looks.sectors], looks.weight
        values[name] = (both, shadowing_share(*theory, middle))
        values[f"r50_{name}"] = ("group", shadowing_half(*theory))
    if (wave := exact_wave(scene)) is not None:
        columns = np.full((window.grid.columns, middle.size), np.nan)
        if not mast.reason:
            columns = exact_share(scene, wave, window.grid, mast.lowest_m, window.edges)
        values["exact"] = (both, looks.members @ columns / looks.members.sum(axis=1, keepdims=True))
    runs = np.sum([each.runs for each in tallies], axis=0)
    for kind, name in enumerate(("shadow_run", "visible_run")):
        for end, quantile in (("median", 0.5), ("90", 0.9)):
            values[f"{name}_{end}"] = (both, window.rung_m * count_quantile(runs[kind], quantile, window.room))
    return xr.Dataset(values)
