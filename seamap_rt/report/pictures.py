"""The figures of a run's page, in order, with what is to be said of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from ..conventions import turn_name
from ..forecast_errors import Verified
from ..scene import Scene
from ..window_errors import Windows
from . import curves, evolution, forecast_figures, gauge_figures, maps, reduce, spectrum_figures
from .headline import headline
from .page_elements import Picture, digits
from .sea_statistics import ground_warning


def pictures(
    scene: Scene,
    retrieved: xr.DataTree,
    truth: xr.DataTree,
    metrics: Mapping[str, Any],
    echoes: xr.Dataset,
    gauges: xr.Dataset | None = None,
    verified: Verified | None = None,
    windows: Windows | None = None,
) -> list[Picture]:
    """The figures of the page, in order, with what is to be said of each. Nothing is drawn yet."""
    run = _Run(scene, retrieved, truth, metrics, echoes)
    return [
        _height_maps(run),
        *evolution.film(scene, retrieved, truth),
        *(spectrum_figures.wave_height_pictures(metrics) if run.turns.size > 1 else ()),
        *forecast_figures.forecast_pictures(scene, retrieved, verified),
        *forecast_figures.window_pictures(windows, scene.prediction.quiet.confidence),
        *gauge_figures.gauge_pictures(gauges),
        _slope_maps(run),
        _error_against_range(run),
        _height_scatter(run),
        _visible_share(run),
        _echo_power(run),
        _timing(run),
    ]


@dataclass(frozen=True)
class _Run:
    """What is shown, and the words that several captions share."""

    scene: Scene
    retrieved: xr.DataTree
    truth: xr.DataTree
    metrics: Mapping[str, Any]
    echoes: xr.Dataset

    @cached_property
    def figures(self) -> dict[str, str]:
        return dict(headline(self.metrics))

    @cached_property
    def turns(self) -> np.ndarray[Any, Any]:
        return reduce.coordinate(self.retrieved, "polar", "turn")

    @property
    def turn(self) -> int:
        """The one that maps and the echo's picture show."""
        return int(self.turns[-1])

    @property
    def which_turn(self) -> str:
        return f" The last of {self.turns.size} turns ({turn_name(self.turn)}) is shown." if self.turns.size > 1 else ""

    @property
    def over_turns(self) -> str:
        return f", over all {self.turns.size} turns" if self.turns.size > 1 else ""

    @property
    def cells(self) -> str:
        settings = self.scene.retrieval
        return f"{settings.cell_range_m:g} m × {settings.cell_azimuth_deg:g}°"

    @property
    def judged(self) -> str:
        return reduce.judged_band(self.truth)

    @property
    def blank(self) -> str:
        """What the grey of the maps means."""
        words = (
            "Grey is where the radar looked and got no height: shadow, an echo under the threshold, or a cell that the "
            "retrieval would not vouch for. Nothing is filled in. "
        )
        if left := ground_warning(self.metrics):
            words += f"{left[0].upper()}{left[1:]}. "
        return words


def _height_maps(run: _Run) -> Picture:
    settings, instant = run.scene.retrieval, run.scene.retrieval.map_time_s
    window = f"{settings.window_range_m:g} m × {settings.window_azimuth_deg:g}°"
    averaged = {
        "adaptive": "by optimal interpolation, which averages more where the echo is weak or unclear",
        "sliding_plane": f"averaged over {window}",
        "single_cell": "averaged over one cell",
    }[settings.estimator]
    moment = "when the beam passed each cell" if instant is None else f"{instant:g} s after the turn's start"
    snapshot = ": the maps are no snapshot" if instant is None else ", over which the maps were brought to one instant"
    return Picture(
        "height_maps",
        "True and retrieved height",
        "Four maps, north up: true height, retrieved height, their difference (rms "
        f"{run.figures['Height error, rms']} at {run.judged}) and the standard error stated by the retrieval.",
        f"Height above mean sea level on ground cells of {settings.ground_m:g} m. (a) The sea as it was {moment}, "
        "lit or not. (b) What the retrieval made of the echoes, "
        f"{averaged}, on the same scale. (c) Their "
        "difference, on its own scale; unlike the figures against range it includes cells that are less than half "
        f"visible. (d) The standard error that the retrieval states for itself. {run.blank}Colour bars end in arrows "
        "where values lie beyond. North is up, the antenna (triangle) at the origin; azimuth is time, since a turn "
        f"takes {run.scene.turn_duration_s:.3g} s and the waves move on meanwhile{snapshot}." + run.which_turn,
        lambda: maps.height_maps(run.scene, run.retrieved, run.truth),
    )


def _slope_maps(run: _Run) -> Picture:
    return Picture(
        "slope_maps",
        "True and retrieved slope",
        "Four maps, north up: true and retrieved slope towards east, true and retrieved slope towards north.",
        f"Slope of the sea surface, averaged over ground cells of {run.scene.retrieval.ground_m:g} m, all four panels "
        f"on one scale; positive where the sea rises towards east (upper row) or north (lower row). {run.blank}"
        + run.which_turn,
        lambda: maps.slope_maps(run.scene, run.retrieved, run.truth),
    )


def _error_against_range(run: _Run) -> Picture:
    words = run.figures
    return Picture(
        "error_against_range",
        "Error against range",
        f"Graphs of height error, bias and slope error against range; overall rms {words['Height error, rms']}, "
        f"robust {words['Height error, robust']}, bias {words['Height bias']}.",
        f"Errors per range bin of the polar cells ({run.cells}) that are more than half visible{run.over_turns}: "
        "rms, robust (1.4826 × the median absolute deviation, blind to outliers) and mean (positive: retrieved too "
        "high; the truth is the mean of the whole cell, while the radar sees crests more than troughs). Dashed: "
        "the median of the retrieval's own standard error in the same cells; where it lies below the rms, the "
        f"retrieval is too sure of itself. Over {run.judged}: rms "
        f"{words['Height error, rms']}, robust {words['Height error, robust']}, bias {words['Height bias']}. (c) "
        "The rms error of the slope, as metrics.json gives it.",
        lambda: curves.error_against_range(run.retrieved, run.truth, run.metrics),
    )


def _height_scatter(run: _Run) -> Picture:
    return Picture(
        "height_scatter",
        "Retrieved against true height",
        f"Two-dimensional histogram of retrieved against true height, correlation {run.figures['Correlation']}, and "
        "histogram of the error over its stated standard error.",
        f"Polar cells ({run.cells}) at {run.judged} that "
        f"are more than half visible{run.over_turns}. (a) Counted in squares; the dashed line is a perfect retrieval. "
        "(b) The height error over the standard error that the retrieval states for the cell: one that knows its own "
        "error follows the normal distribution, with 68 % within ±1 and 95 % within ±2.",
        lambda: curves.height_scatter(run.retrieved, run.truth),
    )


def _visible_share(run: _Run) -> Picture:
    slope, from_cells = reduce.slope_rms_along_look(run.truth, run.metrics)
    source = (
        f"taken from the mean slopes of the {run.scene.retrieval.cell_range_m:g} m cells, so that shorter waves are "
        "missing from it and the curves lie too high"
        if from_cells
        else "of the simulated surface"
    )
    return Picture(
        "visible_share",
        "Visible share against range",
        f"Visible share of the sea against ground range with the curves of Smith and Wagner: "
        f"half of the sea is visible to {run.figures['Half visible to']}.",
        f"Share of the horizontal area of the polar cells that is lit for both antennas{run.over_turns}: all looks, "
        "and sectors of ±22.5° about the direction from which the highest waves come (up-wave), the opposite one "
        "(down-wave) and both at right angles (across). Smith (1967) and Wagner (1967) for a Gaussian sea with an "
        f"rms slope along the look of {digits(slope, 3)}, {source}, at the grazing angle atan(antenna height / "
        "ground range). Both ignore that height and slope are correlated along the ray, and overestimate "
        "visibility against exact ray tracing (in the seas of the validation, Smith by 3–16 %, Wagner by 20–45 %).",
        lambda: curves.visible_share(run.scene, run.truth, run.metrics),
    )


def _echo_power(run: _Run) -> Picture:
    noise = reduce.number(run.echoes.attrs.get("noise_power_w", 0.0))
    over_noise = (
        f"in dB over the thermal noise of one gate ({noise:.3g} W); noise is part of the power, so 0 dB means no echo"
        if noise > 0.0
        else "in dB over 1 W (no noise was added)"
    )
    azimuth = reduce.coordinate(run.retrieved, "polar", "azimuth")
    return Picture(
        "echo_power",
        "The echo",
        "Plan position indicator of mean echo power, north up, and its profile against range.",
        f"Mean power per look and range gate, over its pulses and both receivers, {over_noise}. (a) Plan position "
        "indicator: north up, azimuth clockwise, gates placed at the ground range of mean sea level. (b) The mean "
        f"over the looks (of power, not of dB) and the spread of the looks, against slant range." + run.which_turn,
        lambda: maps.echo_power(run.scene, run.echoes, azimuth, run.turn),
    )


def _timing(run: _Run) -> Picture:
    return Picture(
        "timing",
        "Where the time went",
        f"Bars of wall time per stage; real-time factor {digits(run.metrics.get('real_time_factor'), 3)}.",
        "Wall time of each stage. The first turn includes what is done once (compiling kernels, realising the "
        "sea). The real-time factor is the simulated time of the warm turns over their wall time, maps and files "
        "included: above 1 the run is faster than the radar. Stages overlap, so that they add up to more.",
        lambda: curves.timing(run.scene, run.metrics),
    )
