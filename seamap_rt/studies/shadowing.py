"""How far a radar sees: the visible share of the sea by range, look and antenna height, over several realisations.

Seen is what all antennas see, by horizontal area, in the first turn of each seed, in the sea's own shadows. By light
these are geometric. A radar's are not: water is visible to it (`radar_`), in VV and in HH, whose two-way power is at
least −3, −6 or −10 dB of that of the same water lit (`tracing/visibility.py`).

It is counted by sectors of 15° about the waves' direction, and again by the looks of `visible_tally`: along the waves
(up and down), at 45°, across, and all together. The bands are Student's over seeds alone, as crests that neighbouring
sectors and ranges share make these dependent; `azimuth_correlation` and `range_correlation` say how much.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, report_partial_results
from ..io.process import Progress, ProgressEstimate, hold_interruptions, ignore_progress
from ..io.results_folder import results_folder
from ..io.text import csv_text
from ..mesh import polar_grid
from ..report.reduce import main_waves
from ..resolved_scene import installation_of, run_sea
from ..scene import Scene, SceneLike, as_scene, with_keys
from ..sea import Sea
from ..settings import TracingSettings

if TYPE_CHECKING:
    import xarray as xr

    from .visible_dataset import Window

LEAST_RUNGS_A_BIN = 4
_RADAR = ("radar_visible_fraction", "radar_r50")
PRODUCTS = ("scene.toml", "shadowing.nc", "shadowing.csv", "shadowing.png", "shadowing_seen.png", "shadowing.html")


def shadowing(
    scene: SceneLike,
    heights_m: Sequence[float] = (3.0, 5.0, 10.0),
    seeds: int = 4,
    *,
    bin_m: float = 10.0,
    tracer: str = "horizon",
    progress: Progress | None = None,
) -> xr.Dataset:
    """Visible share, its half range, what is seen of crests, and the lengths of shadows, beside theory.

    Realisations are those of the scene's seed, +1, … All heights see the same seas on the same mesh, the finest that
    one of them asks for. A height with an antenna under water at time 0 is NaN, and `r50_note` says why. Ranges are
    horizontal, in bins of bin_m within radar.range_m. `smith`, `wagner` and, for a scene of one regular wave, `exact`
    are for the lowest antenna: what it sees, all see. Over the dims `azimuth` and, with `look_` before their names,
    `look`; `share(seed, …)` holds the realisations themselves. `radar_visible_fraction` and `radar_r50` are also over
    `polarization` and `level` [dB].
    """
    from .visible_dataset import MastView, shadowing_dataset  # takes a second
    from .visible_tally import Light, Looks, common_meshing, lights, tally

    _refuse(heights_m, seeds, bin_m)
    scene = as_scene(scene)
    say = progress or ignore_progress
    pace = ProgressEstimate("seed", seeds, say)
    scenes = [with_keys(scene, {"radar.height_m": float(height)}) for height in heights_m]
    meshing = common_meshing(scenes)
    result = [MastView() for _ in scenes]
    sea, window = None, None
    from_deg = waves.from_deg if (waves := main_waves(scene)) else 0.0
    for number in range(seeds):
        pace.begin()
        pace.stage(f"trace of {len(scenes)} height{'s' if len(scenes) > 1 else ''}")
        sea = run_sea(with_keys(scene, {"seed": scene.seed + number}))  # the very one that `simulate` draws
        if window is None:
            window = _window_of(scenes[0], meshing, sea, bin_m, from_deg)
        seeded = [with_keys(each, {"seed": scene.seed + number}) for each in scenes]
        for mast, light in zip(result, lights(seeded, meshing, sea, tracer), strict=True):
            if isinstance(light, Light):
                mast.lowest_m = light.lowest_m
                grid = light.facets.grid  # how far beyond the sector it goes follows from how this mast leans
                mast.tallies.append(tally(light, Looks.of(grid, scene.radar, from_deg), window.edges))
            else:
                mast.reason = mast.reason or light
    assert sea is not None
    assert window is not None
    say("counting")
    return shadowing_dataset(scene, [float(height) for height in heights_m], result, window, sea, seeds)


def shadowing_by_cutoff(
    scene: Scene,
    resolutions_m: Sequence[float],
    heights_m: Sequence[float] = (5.0,),
    seeds: int = 4,
    *,
    bin_m: float = 10.0,
    progress: Progress | None = None,
) -> xr.Dataset:
    """`shadowing` over the spacing [m] of the resolved waves' grid: the effect of the shortest wave that is drawn.

    The mesh follows by the scene's tracing settings, never coarser than the grid: `facet_m(resolution)` is its
    spacing. `cutoff_wavelength(resolution)` [m], twice the spacing, is the shortest wave. Different resolutions have
    independent draws. Raises InputError for no resolution.
    """
    if not len(resolutions_m):
        raise InputError("resolutions: is empty; give spacings of the sea's grid in metres, such as 0.8")
    each: list[xr.Dataset] = []
    for spacing in resolutions_m:
        if progress:
            progress(f"waves down to {2.0 * spacing:g} m")
        finer = with_keys(scene, {"sea.resolution_m": float(spacing)})
        each.append(shadowing(finer, heights_m, seeds, bin_m=bin_m).set_coords("resolution"))
    return joined(each).set_coords("cutoff_wavelength")


def joined(each: Sequence[xr.Dataset]) -> xr.Dataset:
    """Studies of one scene as one, along their `resolution`."""
    import xarray as xr

    how: Any = {"join": "exact", "combine_attrs": "override", "data_vars": "all", "coords": "minimal"}
    return xr.concat(each, "resolution", compat="override", **how)


def _refuse(heights_m: Sequence[float], seeds: int, bin_m: float) -> None:
    try:
        listed = np.asarray(heights_m, dtype=np.float64).ndim == 1
    except (TypeError, ValueError):
        listed = False
    if not listed:
        raise InputError(f"heights = {heights_m!r:.60}: must be a list of metres, such as [3, 5, 10]")
    if not len(heights_m):
        raise InputError("heights: is empty; give antenna heights in metres, such as 3,5,10")
    if len({float(height) for height in heights_m}) < len(heights_m):
        raise InputError(f"heights = {', '.join(f'{h:g}' for h in heights_m)}: one is given twice; give each once")
    if seeds < 1:
        raise InputError(f"seeds = {seeds}: must be at least 1; 3 or more give bands")
    if not (np.isfinite(bin_m) and bin_m > 0.0):
        raise InputError(f"bin = {bin_m:g}: must be finite and greater than 0, the length of a range bin in metres")


def _window_of(scene: Scene, meshing: TracingSettings, sea: Sea, bin_m: float, from_deg: float) -> Window:
    from .visible_dataset import Window  # takes a second
    from .visible_tally import Looks

    mast = installation_of(scene, sea)
    grid = polar_grid(mast, meshing, 0)
    rung, (near, far) = float(grid.ground_range[1] - grid.ground_range[0]), scene.radar.range_m
    if bin_m < LEAST_RUNGS_A_BIN * rung:
        least = LEAST_RUNGS_A_BIN * rung
        raise InputError(
            f"bin = {bin_m:g}: must be at least {least:g} ({LEAST_RUNGS_A_BIN} rungs of the mesh); lengthen it"
        )
    edges = np.arange(np.ceil(near / bin_m - 1e-9), np.floor(far / bin_m + 1e-9) + 1.0) * bin_m
    if edges.size < 3:
        raise InputError(f"bin = {bin_m:g}: radar.range_m = [{near:g},{far:g}] must hold two of them; shorten it")
    looks = Looks.of(grid, scene.radar, from_deg)
    return Window(grid, looks, edges, meshing.columns_per_beam or 0)


def write_shadowing(
    scene: SceneLike,
    out: str | Path | None = None,
    heights_m: Sequence[float] = (3.0, 5.0, 10.0),
    seeds: int = 4,
    overwrite: bool = False,
    progress: Progress | None = None,
    bin_m: float = 10.0,
) -> list[str]:
    """`shadowing`, by the scene's own tracer, into a folder (default `runs/<scene>-shadowing`); returns the headlines.

    scene.toml, shadowing.nc, shadowing.csv with a row per height, look and range bin, two figures and shadowing.html,
    the page that holds them, each whole or not at all.
    Raises InputError for bad input, and where the folder holds another study and `overwrite` is not given.
    """
    _refuse(heights_m, seeds, bin_m)
    from ..report import style  # it and the next two load matplotlib, which a trade's workers do without
    from .shadowing_figures import draw_seen, draw_shadowing, shadowing_page

    scene = as_scene(scene)
    folder = Path(out) if out is not None else Path("runs") / f"{scene.name}-shadowing"
    with results_folder(folder, overwrite, PRODUCTS):
        with report_partial_results(lambda: "nothing of this study is kept; what the folder held before stays"):
            data = shadowing(scene, heights_m, seeds, tracer=scene.tracing.tracer, bin_m=bin_m, progress=progress)
            if progress:
                progress("writing and drawing")
            shares, seen, lines = style.png(draw_shadowing(data)), style.png(draw_seen(data)), headlines(data)
            made = {
                "scene.toml": scene.to_toml().encode("utf-8"),
                "shadowing.nc": bytes(data.to_netcdf(engine="h5netcdf")),  # HDF5 itself may crash on a full disk
                "shadowing.csv": table(data).encode("utf-8"),
                "shadowing.png": shares,
                "shadowing_seen.png": seen,
                "shadowing.html": shadowing_page(data, lines, shares, seen, seeds, scene.to_toml()).encode("utf-8"),
            }
        with hold_interruptions():
            _write_all(folder, made)
    return lines


def headlines(data: xr.Dataset) -> list[str]:
    """A line per height: beyond which range half is shadowed, along the waves, at 45°, across, all looks; a last line
    says when water is visible to a radar."""
    from ..physics.shadowing import SEEN_DB
    from .visible_dataset import OUTSIDE  # it and the next take a second

    lines = []
    for height in data["height"].values:
        mast = data.sel(height=height)
        notes = [str(note) for note in mast["look_r50_note"].values]
        if notes[0] and len(set(notes)) == 1:
            lines.append(f"mast {height:g} m: {notes[0]}")
            continue
        looked = [look for look, note in zip(mast["look"].values, notes, strict=True) if note != OUTSIDE]
        words = [_half_in_words(mast.sel(look=look), SEEN_DB) for look in looked]
        lines.append(f"mast {height:g} m: half of the sea is shadowed beyond {', '.join(words)}")
    if data["look_radar_r50"].sel(level=SEEN_DB).notnull().any():
        lines.append(
            f"VV, HH: range beyond which less than half of the sea returns {SEEN_DB:g} dB or more of its "
            "two-way power when lit"
        )
    return lines


def _half_in_words(mast: xr.Dataset, level_db: float) -> str:
    where, half = str(mast["look"].values), float(mast["look_r50"])
    if np.isnan(half):
        return f"no range {where} ({mast['look_r50_note'].item()})"
    low, high = float(mast["look_r50_low"]), float(mast["look_r50_high"])
    band = f" [{low:.0f}, {high:.0f}]" if np.isfinite(low) else ""
    radar = mast["look_radar_r50"].sel(level=level_db)
    found = [(str(each), float(radar.sel(polarization=each))) for each in radar["polarization"].values]
    by_radar = "".join(f"{each} {to:.0f} m, " for each, to in found if np.isfinite(to))
    return f"{half:.0f} m{band} {where} ({by_radar}Smith {float(mast['look_r50_smith']):.0f} m)"


def table(data: xr.Dataset) -> str:
    """CSV with a row per height, look and range bin: the three looks first, then every sector by its angle."""
    shown = ("visible_fraction", "smith", "wagner", "exact", "crest_bias")
    runs = [f"{kind}_run_{end}" for kind in ("shadow", "visible") for end in ("median", "90")]
    columns = [f"{name}{end}" for name in (*shown, *runs) for end in ("", "_low", "_high")] + ["r50", "r50_note"]
    lines: list[Sequence[Any]] = []
    for dim, prefix in (("look", "look_"), ("azimuth", "")):
        names = {f"{prefix}{column}": column for column in columns if f"{prefix}{column}" in data}
        part = data[list(names)].rename(names).drop_vars("lowest_antenna")
        for name, wave, level in product(_RADAR, data["polarization"].values, data["level"].values):
            chosen = data[f"{prefix}{name}"].sel(polarization=wave, level=level, drop=True)
            part[f"{name}_{str(wave).lower()}_{-level:.0f}_db"] = chosen
        frame = part.to_dataframe(dim_order=["height", dim, "range"]).reset_index()
        if dim == "look":
            frame.insert(1, "azimuth", np.nan)
        else:
            frame.insert(2, "look", [f"at {angle:+.0f}°" for angle in frame.pop("from_waves")])
        lines += [] if lines else [list(frame)]
        lines += frame.itertuples(index=False, name=None)
    return csv_text(lines, 6)


def _write_all(folder: Path, made: Mapping[str, bytes]) -> None:
    """Write files that replace an earlier study's only when all of them are on the disk."""
    pieces = {name: folder / f".{name}.part" for name in made}
    try:
        for name, data in made.items():
            pieces[name].write_bytes(data)
        for name, part in pieces.items():
            os.replace(part, folder / name)
    finally:
        for part in pieces.values():
            part.unlink(missing_ok=True)
