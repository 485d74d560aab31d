"""The sea state by the maps, turn by turn, and their spectra.

Spectra of maps and of the true sea in the same cells come through one estimator: what the retrieval's cells blur is
taken back of the maps; the true sea is the plain mean over the cells.
"""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from nicegui import ui
from numpy.typing import NDArray

from ..errors import SchemaError
from ..report.spectrum_figures import Density, map_spectra_picture, wave_height_pictures
from ..wavefield.sea_state import TurnSpectrum, water_of
from . import drawing
from .source import Source
from .widgets import Image, Images, draw_images

if TYPE_CHECKING:
    from .see_view import SeeView


Array = NDArray[np.float64]
MOST_TURNS = 6  # whose spectra are averaged: one turn's is ragged
_LEAST_SPAN = 80.0  # degrees of looks, as for the sea state: fewer do not tell directions
LEAST_TRANSFER = 0.25  # of the variance, that cells keep: shorter waves the sea state leaves out as well


_SECTOR_DEG, _LEAST_STEP_HZ = 15.0, 0.015


@dataclass(frozen=True)
class MapSpectra:
    """By the maps, and by the true sea in their cells where there is one; of how many turns up to the one shown. why:
    what is missing, in words."""

    retrieved: Density | None
    true: Density | None
    turns: int
    why: str


def map_spectra(source: Source, turn: int) -> MapSpectra:
    """Of the last turns up to one, by its place. OSError where a turn is not there."""
    results, turns = source.results, range(max(0, turn + 1 - MOST_TURNS), turn + 1)
    retrieved = _mean([source.polar(each) for each in turns]) if results.has_maps else None
    true = _mean([_true(source, each) for each in turns], as_it_is=True) if results.has_truth else None
    why, shown = "", retrieved if results.has_maps else true
    if shown is None:
        why = "Too little of the sea is in sight for a spectrum."
    elif shown.directional is None:
        why = (
            f"The looks span less than {_LEAST_SPAN:.0f}°, or nothing tells which way the waves run: directions are "
            "left out."
        )
    return MapSpectra(retrieved, true, len(turns), why)


def _true(source: Source, turn: int) -> xr.Dataset:
    """A turn with the true heights of all cells."""
    shape = source.layout.azimuth.size, source.layout.range.size
    values = {
        "height": source.results.field("truth/polar/height", turn),
        "ground_range": np.broadcast_to(source.ground_m, shape),
        "height_std": np.full(shape, 1e-3),
        "quality": np.zeros(shape, np.int16),
    }
    polar = source.polar(turn).drop_vars("visible_share", errors="ignore")
    return polar.assign({name: (("azimuth", "range"), each) for name, each in values.items()})


def _mean(polars: list[xr.Dataset], *, as_it_is: bool = False) -> Density | None:
    """Of those turns that show a sea. as_it_is: without taking back what a retrieval's cells blur."""
    water = water_of(polars[0].attrs)
    found = [each for each in (TurnSpectrum.of(polar, water) for polar in polars) if each is not None]
    if not found:
        return None
    if as_it_is:
        found = [replace(each, spectrum=each.spectrum.corrected(1.0 / each.transfer, 0.0)) for each in found]
    first = found[0].spectrum
    frequency = first.ring_frequency
    densities = [_on_rings(each, frequency) for each in found]
    step = max(_LEAST_STEP_HZ, float(np.median(np.diff(frequency))))
    edges = np.arange(0.0, frequency[-1] + step, step)
    directed = [each for each in found if each.way_known and each.polar_map.span > _LEAST_SPAN]
    directional = np.mean([_by_direction(each, edges) for each in directed], axis=0) if directed else None
    return Density(
        frequency,
        np.mean(densities, axis=0),
        0.5 * (edges[1:] + edges[:-1]),
        np.arange(0.5 * _SECTOR_DEG, 360.0, _SECTOR_DEG),
        directional,
    )


def _on_rings(turn: TurnSpectrum, frequency: Array) -> Array:
    """Density [m²/Hz] at the frequencies of the first turn's rings, which hardly differ from turn to turn; NaN of waves
    too short for the cells."""
    own = turn.spectrum.ring_frequency
    density = np.interp(frequency, own, turn.spectrum.ring_power / (_modes_a_wave(turn) * np.gradient(own)), right=0.0)
    return np.where(np.interp(frequency, own, turn.transfer) > LEAST_TRANSFER, density, np.nan)


def _by_direction(turn: TurnSpectrum, edges: Array) -> Array:
    """Density [m²/Hz/°] (f, d): the modes' power, gathered; what lies below the floor is 0."""
    spectrum = turn.spectrum
    frequency = spectrum.water.frequency(spectrum.wavenumber) / (2.0 * np.pi)
    comes_from = (np.degrees(spectrum.toward) + 180.0) % 360.0
    sectors = np.arange(0.0, 360.0 + _SECTOR_DEG, _SECTOR_DEG)
    power = np.histogram2d(frequency, comes_from, (edges, sectors), weights=spectrum.power)[0]
    return np.maximum(power, 0.0) / (_modes_a_wave(turn) * np.diff(edges)[:, None] * _SECTOR_DEG)


def _modes_a_wave(turn: TurnSpectrum) -> float:
    """How many modes of the lattice, which is finer than a sea of area A asks, hold one wave: (2π/Δk)²/A."""
    polar_map, bins = turn.polar_map, turn.bins
    inside = polar_map.known & bins.within(bins.glimpsed, polar_map.distance)
    step = float(np.median(np.diff(turn.spectrum.ring_wavenumber)))  # rings are one step wide
    return (2.0 * np.pi / step) ** 2 / float(polar_map.cells(inside).weight.sum())


class StatePanel:
    """The sea state by the maps, and their spectrum."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._words = ui.label().mark("sea-state")
        self._images = Images()
        ui.label("Wave spectrum").classes("text-base font-bold")
        self._said = ui.label().classes("text-sm").props("role=status").mark("spectrum-words")
        self._spectra = Images()

    async def show(self, source: Source, turn: int) -> None:
        metrics = await asyncio.to_thread(source.results.metrics)
        known = bool((metrics.get("sea_state") or {}).get("significant_wave_height"))
        self._words.set_text(str(metrics.get("sea_state_in_words", "")) if known else _why_no_state(source))
        self._words.classes(replace="font-bold" if known else "text-sm")
        try:
            heights, said, spectra = await drawing.slow(state_of, source, turn, self.view.page.dark)
        except (SchemaError, KeyError, ValueError) as error:  # maps of another program
            heights, said, spectra = [], f"No spectrum: {error}", []
        self._images.show(heights)
        self._said.set_text(said)
        self._said.set_visibility(bool(said))
        self._spectra.show(spectra)


def state_of(source: Source, turn: int, dark: bool) -> tuple[list[Image], str, list[Image]]:
    """The wave height turn by turn; of the spectra of the turns up to one what is missing, and their figure."""
    heights, found = draw_images(wave_height_pictures(source.results.metrics()), dark), map_spectra(source, turn)
    if found.retrieved is None and found.true is None:
        return heights, found.why, []
    law = source.expected()
    of_scene = None
    if law is not None and law.spectrum.density.any():
        step = 360.0 / law.spectrum.direction.size
        of_scene = law.spectrum.frequency, law.spectrum.density.sum(axis=1) * step
    turns = f"the last {found.turns} turns" if found.turns > 1 else "this turn"
    words = f"Of {turns}, in the frame of the water."
    return heights, found.why, draw_images([map_spectra_picture(found.retrieved, found.true, of_scene, words)], dark)


def _why_no_state(source: Source) -> str:
    if not source.results.has_maps:
        return "Nothing was retrieved of these echoes yet: press Retrieve beside them in Runs."
    if source.results.growing or source.scene is not None:
        return "The wave height, turn by turn, is worked out when a run has ended."
    return "The wave height of these echoes stands in their own page: Download, retrieval.html."
