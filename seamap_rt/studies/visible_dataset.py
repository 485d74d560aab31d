"""The dataset of a shadowing study: tallies of every realisation become shares, bands, half ranges and run lengths."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..mesh import PolarGrid
from ..report.reduce import main_waves
from ..scene import Scene
from ..sea import Sea, resolution
from .paired import FEWEST_SEEDS
from .visible_statistics import (
    FUNCTIONS,
    count_quantile,
    exact_share,
    exact_wave,
    half_range,
    jackknife,
    neighbour_correlation,
    resolved_slope,
    shadowing_half,
    shadowing_share,
    why_no_half,
)
from .visible_tally import Looks, Tally

Array = NDArray[np.float64]

OUTSIDE = "outside the radar's sector"
_VARIABLES = {  # units and long name; _low and _high are the ends of the 95 % band over seeds
    "visible_fraction": ("1", "share of horizontal area that all antennas see"),
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

    def nothing(self) -> Tally:
        """The tally of a mast that sees no sea, its areas empty: all shares are NaN."""
        groups, bins = len(self.looks.members), self.edges.size - 1
        empty = np.zeros((groups, bins))
        runs = np.zeros((2, groups, bins, self.grid.ground_range.size), dtype=np.int64)
        return Tally(empty, empty, empty, empty, np.zeros(groups), runs)


def shadowing_dataset(
    scene: Scene, heights: list[float], result: list[MastView], window: Window, sea: Sea, seeds: int
) -> xr.Dataset:
    """The study's dataset: each variable by sector and, with the prefix `look_`, by look; units as attributes."""
    looks, waves = window.looks, main_waves(scene)
    each = [_of_mast(scene, mast, window, seeds) for mast in result]
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
        range=window.middle,
        seed=[scene.seed + number for number in range(seeds)],
    )
    for name in data.variables:
        plain = str(name).removeprefix("look_").removesuffix("_low").removesuffix("_high")
        if plain in _VARIABLES:
            units, words = _VARIABLES[plain]
            data[name].attrs = {"long_name": words} | ({"units": units} if units else {})
    freedom = f"{seeds - 1} degree{'s' if seeds > 2 else ''} of freedom"
    told = f"95 %, Student's t over {seeds} seeds ({freedom})"
    bands = told if seeds >= FEWEST_SEEDS else f"none, of {'one seed' if seeds == 1 else f'{seeds} seeds'}"
    data.attrs = {
        "title": f"Visible share of the sea of scene {scene.name}",
        "bands": bands + "; neighbouring looks and ranges share crests and count as one draw",
        "scene": scene.name,
        "waves_from_deg": waves.from_deg if waves else np.nan,
        "bin_m": float(window.edges[1] - window.edges[0]),
    }
    return data


def _of_mast(scene: Scene, mast: MastView, window: Window, seeds: int) -> xr.Dataset:
    """One height's shares, half ranges, biases and runs, over (group, range)."""
    tallies = [window.nothing()] * seeds if mast.reason else mast.tallies
    with np.errstate(invalid="ignore", divide="ignore"):
        return _counted(scene, mast, tallies, window)


def _counted(scene: Scene, mast: MastView, tallies: list[Tally], window: Window) -> xr.Dataset:
    middle, looks, both = window.middle, window.looks, ("group", "range")
    share = np.stack([each.lit / each.area for each in tallies])
    sums = np.stack([(each.area, each.lit, each.height, each.lit_height) for each in tallies])
    slope = np.sqrt(np.sum([each.slope for each in tallies], axis=0) / sums[:, 0].sum(axis=(0, 2)))
    visible = jackknife(lambda mean: mean, share, (0.0, 1.0))
    values: dict[str, object] = {"share": (("seed", *both), share)}
    for name, (dims, three) in {
        "visible_fraction": (both, visible),
        "crest_bias": (both, jackknife(lambda mean: mean[3] / mean[1] - mean[2] / mean[0], sums)),
        "r50": ("group", jackknife(lambda mean: half_range(middle, mean), share, (0.0, np.inf))),
    }.items():
        values |= {f"{name}{end}": (dims, each) for end, each in zip(("", "_low", "_high"), three, strict=True)}
    values["r50_note"] = ("group", [_note(mast, middle, each) for each in visible[0]])
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


def _note(mast: MastView, middle: Array, share: Array) -> str:
    if mast.reason:
        return mast.reason
    return OUTSIDE if np.isnan(share).all() else why_no_half(middle, share)
