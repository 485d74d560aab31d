"""What a design is likely to do, at once and without simulating: the outlook, the link budget, closed forms, sizing.

And the graphs of that.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..conventions import db, ground_range
from ..design_outlook import Outlook, estimate_outlook
from ..design_outlook.model import half_range_key
from ..design_outlook.strips import snr_of_unity
from ..errors import InputError
from ..physics import dispersion
from ..products.link import mean_sea, window_of
from ..radar import link
from ..radar.antenna import antenna
from ..radar.precision import height_per_radian, noise_height_error
from ..radar.waveform import RangeResponse
from ..report import style
from ..report.curves import Curve, Graph, analytic_share, analytic_shares, draw_graph
from ..report.page_elements import Image, Picture
from ..report.spectrum_figures import draw_rose
from ..scene import Scene
from ..scene.agreement import run_bytes
from ..sea import directional_density, spectral_system, wave_facts
from ..sea.facts import ResolvedWaves
from ..sea.realisation import resolution
from ..settings import RandomWaves

Array = NDArray[np.float64]

_POINTS = 60  # of a curve against range
_DIRECTIONS, _FREQUENCIES = 72, 48
_LOCK = threading.Lock()
_SECONDS_A_FACET, _SECONDS_A_RUN = 1.4e-6, 12.0  # of one core's warm turn, and of loading, comparing and drawing


@dataclass(frozen=True)
class Spectrum:
    """The waves by frequency (f,) [Hz] and direction (d,) [degrees they come from]: density (f, d) [m²/Hz/degree].

    lines: regular or long-crested systems, as frequency, direction and height.
    """

    frequency: Array
    direction: Array
    density: Array
    lines: tuple[tuple[float, float, float], ...]


class Prospects:
    """What a scene is likely to do. Arrays (range,) along `ground_m`; figures by name with value, unit and digits."""

    def __init__(self, scene: Scene) -> None:
        radar = scene.radar
        self.slant_m = slant = np.linspace(*window_of(scene), _POINTS)
        self.ground_m = ground_range(slant, radar.height_m)
        snr = mean_sea(scene, slant)[0] * snr_of_unity(radar, slant)
        self.snr_db = db(np.maximum(snr, 1e-12))  # of one pulse
        noise = [noise_height_error(radar, float(s), float(r)) for s, r in zip(snr, slant, strict=True)]
        self.noise_error_m = np.array(noise)  # rms height by the receivers' noise alone
        self.ambiguity_m = 2.0 * np.pi * np.array([height_per_radian(radar, float(r)) for r in slant])
        waves = ResolvedWaves.of(scene.sea, np.pi / resolution(scene.sea)) if scene.sea.waves else None
        slope = waves.slopes_lost(np.inf) if waves is not None else 0.0
        self.smith, self.wagner = analytic_share(self.ground_m, radar.height_m, slope)
        self.ahead, self.why_not = _outlook(scene)  # None where the outlook refuses the scene, and why
        far = self.ahead.range if self.ahead is not None else slant
        self.ahead_ground_m = ground_range(far, radar.height_m)  # (range of ahead,)
        self.beam_deg = np.linspace(-60.0, 30.0, 181)  # elevation angles, up is positive
        cut = antenna(radar).voltage(0.0, np.radians(self.beam_deg)) ** 2
        self.beam_db = np.maximum(db(np.maximum(cut, 1e-12)), -60.0)  # one-way, over the peak
        self.figures = tuple(_figures(scene, slant, snr, self.noise_error_m, waves, self.ahead))
        self.spectrum = _spectrum(scene)

    @property
    def values(self) -> dict[str, float]:
        return {key: value for key, _, value, *_ in self.figures}


def prospects(scene: Scene) -> Prospects:
    """The prospects of a valid scene: in some tens of ms, at first in seconds. Safe in threads; the last ones stay."""
    with _LOCK:
        return _kept(scene)  # type: ignore[arg-type]  # frozen, and so hashable


_kept = lru_cache(maxsize=64)(Prospects)


def _outlook(scene: Scene) -> tuple[Outlook | None, str]:
    try:
        return estimate_outlook(scene), ""
    except (InputError, ValueError) as refusal:
        return None, str(refusal)


Figures = Iterator[tuple[str, str, float, str, int, int]]  # key, words, value, unit, digits; 1: better more, −1: less


def _figures(
    scene: Scene, slant: Array, snr: Array, noise: Array, waves: ResolvedWaves | None, ahead: Outlook | None
) -> Figures:
    if ahead is not None and ahead.figures["reach_m"] is not None:
        yield "reach", "Measures waves out to", float(ahead.figures["reach_m"]), "m", 0, 1
        yield "radius", "Fully measured radius", float(ahead.figures["fully_measured_radius_m"]), "m", 0, 1
        inner = (ahead.range >= 50.0) & (ahead.range <= 200.0)
        if inner.any():
            weight = np.nan_to_num((ahead.profile["seen_fraction"] * ahead.profile["answered_fraction"])[inner])
            error = np.nan_to_num(ahead.profile["height_error"][inner])
            rms = float(np.sqrt(np.sum(weight * error**2) / np.sum(weight))) if weight.sum() > 0.0 else float("nan")
            yield "error", "Height error, 50–200 m", rms, "m", 3, -1
        far = ahead.figures[half_range_key(scene.scattering.polarization)]
        yield "half_visible", "Half of the sea seen by radar to", far, "m", 0, 1
    yield from _sea_figures(scene, waves)
    yield from _radar_figures(scene, slant, snr, noise)
    yield "facets", "Facets a turn", float(scene.detail.facets or 0), "", 0, 0
    yield "memory", "Memory", run_bytes(scene) / 1e9, "GB", 1, -1
    yield "seconds", "A run takes", run_seconds(scene), "s", 0, -1


def _sea_figures(scene: Scene, waves: ResolvedWaves | None) -> Figures:
    sigma = waves.elevation_std if waves is not None else 0.0
    facts = [f for f in (wave_facts(each, scene.sea.depth_m) for each in scene.sea.waves) if f is not None]
    main = max(facts, key=lambda each: each.height, default=None)
    yield "hs", "Wave height Hs", 4.0 * sigma, "m", 2, 0
    if main is not None:
        k = float(dispersion.wavenumber(2.0 * np.pi / main.peak_period, scene.sea.depth_m))
        yield "tp", "Peak period Tp", main.peak_period, "s", 1, 0
        yield "steepness", "Steepness Hs/λ", 4.0 * sigma * k / (2.0 * np.pi), "", 3, 0


def _radar_figures(scene: Scene, slant: Array, snr: Array, noise: Array) -> Figures:
    radar, far = scene.radar, scene.radar.range_m[1]
    yield "snr_reach", "One pulse's echo over noise to", _furthest_range(slant, snr), "m", 0, 1
    for at in (100.0, 200.0):
        if radar.height_m < at <= far:
            across, error = float(link.footprint_m(radar, at)), float(np.interp(at, slant, noise))
            grazing = float(np.degrees(np.arcsin(radar.height_m / at)))
            yield f"across_{at:.0f}", f"Beam across at {at:.0f} m", across, "m", 1, -1
            yield f"noise_{at:.0f}", f"Height error by noise at {at:.0f} m", error, "m", 3, -1
            yield f"grazing_{at:.0f}", f"Grazing angle at {at:.0f} m", grazing, "°", 1, 0
            per = 2.0 * np.pi * height_per_radian(radar, at)
            yield f"ambiguity_{at:.0f}", f"Height of a phase cycle at {at:.0f} m", per, "m", 2, 0
    yield "resolution", "Range resolution", RangeResponse.of(radar).resolution_m, "m", 2, -1


def run_seconds(scene: Scene) -> float:
    """Wall time of a run with its page, about, on two cores; a queue knows its own pace."""
    return _SECONDS_A_RUN + scene.turns * (0.05 + _SECONDS_A_FACET * scene.detail.facets)


def _furthest_range(slant: Array, snr: Array) -> float:
    """The last range of the window at which one pulse's echo stands over the noise; 0 where it nowhere does."""
    reach = link.furthest(slant, snr)
    return 0.0 if np.isnan(reach) else float(min(reach, slant[-1]))


def _spectrum(scene: Scene) -> Spectrum:
    depth = scene.sea.depth_m
    facts = [(waves, wave_facts(waves, depth)) for waves in scene.sea.waves]
    known = [(waves, fact) for waves, fact in facts if fact is not None]
    longest = max((fact.peak_period for _, fact in known), default=5.0)
    shortest = min((fact.peak_period for _, fact in known), default=5.0)
    frequency = np.linspace(0.4 / longest, max(2.5 / shortest, 1.0 / longest), _FREQUENCIES)
    direction = 360.0 / _DIRECTIONS * np.arange(_DIRECTIONS, dtype=np.float64)
    density, lines = np.zeros((_FREQUENCIES, _DIRECTIONS)), []
    for waves, fact in known:
        system = spectral_system(waves, depth) if isinstance(waves, RandomWaves) else None
        if system is None or system.spreading is None:
            lines.append((1.0 / fact.peak_period, fact.from_deg, fact.height))
        else:
            density += directional_density(system, frequency, direction, depth)
    return Spectrum(frequency, direction, density, tuple(lines))


# ------------------------------------------------------------------------------------------------------ graphs

_WIDE, _HIGH = 3.9, 1.75  # inches


def design_images(found: Prospects, beside: Prospects | None, scene: Scene, dark: bool) -> list[Image]:
    """The graphs of a design. beside: prospects of the kept one, drawn dashed."""
    pictures = [
        Picture(name, title, f"{title}, as a graph.", "", lambda graph=graph: draw_graph(graph, _WIDE, _HIGH))
        for name, title, graph in _graphs(found, beside, scene)
    ]
    title, spectrum = "Waves by frequency and the direction they come from", found.spectrum
    rose = partial(draw_rose, spectrum.frequency, spectrum.direction, spectrum.density, spectrum.lines, _WIDE)
    pictures.append(Picture("spectrum", title, f"{title}, over the compass.", "", rose))
    return [each.image(dark) for each in pictures]


def _graphs(found: Prospects, beside: Prospects | None, scene: Scene) -> Iterator[tuple[str, str, Graph]]:
    """Name, title and what is drawn."""
    both = [(found, "-", ""), *([(beside, "--", ", kept")] if beside else [])]

    def curves(x: str, y: str, words: str, colour: str) -> list[Curve]:
        return [
            Curve(f"{words}{tail}".removeprefix(", "), getattr(each, x), getattr(each, y), colour, dash)
            for each, dash, tail in both
        ]

    def outlook_curves(name: str, words: str, colour: str, factor: float = 1.0) -> list[Curve]:
        return [
            Curve(f"{words}{tail}", each.ahead_ground_m, factor * each.ahead.profile[name], colour, dash)
            for each, dash, tail in both
            if each.ahead is not None
        ]

    def graph(y_label: str, drawn: Sequence[Curve], **more: Any) -> Graph:
        return Graph("Ground range (m)", y_label, drawn, x_span=(0.0, float(found.ground_m[-1])), **more)

    seen = [
        *outlook_curves("visible_fraction", "in sight", style.BLUE, 100.0),
        *outlook_curves("quality", "measured", style.GREEN, 100.0),
    ]
    seen += [each._replace(y=100.0 * each.y) for each in analytic_shares(found.ground_m, found.smith, found.wagner)]
    yield "visible", "Share of the sea that is in sight, and that is measured", graph("%", seen, y_span=(0.0, 102.0))
    error = outlook_curves("height_error", "of the map", style.VERMILION)
    error += curves("ground_m", "noise_error_m", "noise of one dwell", style.GREY)
    yield "error", "Height error", graph("m", error, log=True)
    snr = curves("ground_m", "snr_db", "", style.GREEN)
    yield "snr", "One pulse's echo of the mean sea over noise", graph("dB", snr)
    places = [at for at in (20.0, 50.0, scene.radar.range_m[1]) if at > scene.radar.height_m]
    marks = [(-float(np.degrees(np.arcsin(scene.radar.height_m / at))), f"{at:.0f} m") for at in places]
    beam = curves("beam_deg", "beam_db", "", style.BLUE)
    title, span = "Beam up and down, and where the sea is", (-40.0, 1.0)
    yield "beam", title, Graph("Elevation (°)", "dB under the peak", beam, "", (-45.0, 30.0), span, marks=marks)
    cycle = curves("ground_m", "ambiguity_m", "", style.ORANGE)
    yield "cycle", "Height that a phase cycle is worth", graph("m", cycle)
