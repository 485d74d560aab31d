"""Setups to compute a turn, their seconds and their errors: see `speed_error.py`."""

from __future__ import annotations

import copy
import itertools
import statistics
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.echoes import expected_look_gates
from seamap_rt.echoes.dataset import echo_dataset
from seamap_rt.echoes.response import truncation_share
from seamap_rt.echoes.turn import turn_echoes
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.metrics import HALF_VISIBLE, HEADLINE_M
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.resolved_scene import run_sea
from seamap_rt.scene import Scene
from seamap_rt.sea import Sea, realisation
from seamap_rt.simulation import Simulator, Stopwatch
from seamap_rt.tracing import Illumination, tracer
from seamap_rt.truth import polar_truth

Array = NDArray[np.float64]
SCENE = "choppy_sea"
TRACERS = ("facets", "horizon")
STAGES = ("sea", "mesh", "trace", "echoes")
SECTORS = {"up the waves": (255.0, 285.0), "along the crests": (345.0, 375.0)}
WINDOW_M = (15.0, 400.0)
LARGE = 2_500_000  # facets, from which on a turn is timed once


class Mesh(NamedTuple):
    """Its spacings."""

    facet_m: float
    columns: int

    def __str__(self) -> str:
        return f"{self.facet_m:g} m × {self.columns}"

    def keys(self) -> dict[str, Any]:
        return {"tracing.facet_m": self.facet_m, "tracing.columns_per_beam": self.columns}


class Spline(NamedTuple):
    """How the sea is interpolated between the points of its grid and its knots in time."""

    order: int
    oversampling: float
    steps: float = 1.0  # the time between knots, over the sea's own choice

    def __str__(self) -> str:
        return f"order {self.order}, {self.oversampling:g} ×" + (f", steps × {self.steps:g}" if self.steps != 1 else "")


OWN_SPLINE = Spline(*realisation.FASTER)  # which the scene's height error allows
FINE_SPLINE = Spline(7, 2.0, 0.5)  # 7 is as high as the kernel goes

# --------------------------------------------------------------------------------------------------- simulators


def scene_of(**keys: Any) -> Scene:
    return sr.load_scene(SCENE, overrides={name.replace("__", "."): value for name, value in keys.items()})


def _tracer(name: Any, scene: Scene) -> Callable[..., Any]:
    return tracer(name, scene.radar, scene.scattering)


class Bench:
    """Simulators of one sea, which share its knots and its calibration, as a run's turns do."""

    def __init__(self) -> None:
        self.whole = Simulator(scene_of())
        _ = self.whole.surface
        detail = self.whole.scene.detail
        self.default = Mesh(detail.facet_m, detail.columns_per_beam)
        self._sectors = {name: Simulator(scene_of(radar__sector_deg=[*at])) for name, at in SECTORS.items()}

    def simulator(self, mesh: Mesh, sector: str | None = None, sea: Sea | None = None, kept: int = 1) -> Simulator:
        """One that lights a mesh by `facets`; by default of the whole circle, the scene's own sea and all pulses."""
        made = copy.copy(self._sectors[sector] if sector else self.whole)
        prf = made.installation.radar.prf_hz / kept
        keys = {**mesh.keys(), "radar.prf_hz": prf, "radar.sector_deg": [*made.installation.radar.sector_deg]}
        made.scene = scene_of(**keys)
        radar = made.installation.radar.model_copy(update={"prf_hz": prf})
        made.installation = replace(made.installation, radar=radar)
        made.sea = sea or self.whole.sea
        made._surface = self.whole.surface
        made._trace = _tracer("facets", made.scene)
        return made

    def sea(self, spline: Spline) -> Sea:
        """The same waves, interpolated otherwise."""
        (plane,) = self.whole.sea.trains
        with _interpolated(spline, plane.field.time_step):  # pyright: ignore[reportAttributeAccessIssue]
            return run_sea(self.whole.scene)


@contextmanager
def _interpolated(spline: Spline, time_step: float) -> Iterator[None]:
    """Seas that are drawn meanwhile are interpolated so."""
    known = realisation.SPLINE_ORDER, realisation.OVERSAMPLING, realisation.FASTER, realisation.MovingField
    realisation.SPLINE_ORDER, realisation.OVERSAMPLING = realisation.FASTER = spline.order, spline.oversampling
    if spline.steps != 1.0:
        realisation.MovingField = partial(known[3], time_step=spline.steps * time_step)  # pyright: ignore
    try:
        yield
    finally:
        realisation.SPLINE_ORDER, realisation.OVERSAMPLING, realisation.FASTER, realisation.MovingField = known


# ------------------------------------------------------------------------------------------------------- errors


@dataclass(frozen=True)
class Maps:
    """Expected over speckle; (look, gate), the sectors' looks one after the other."""

    range: Array  # (gate,) m
    power: Array  # W
    covariance: NDArray[np.complex128]
    visible: Array

    def __sub__(self, exact: Maps) -> Array:
        """(quantity, look, gate): height m, power dB, visible share, phase rad."""
        with np.errstate(divide="ignore", invalid="ignore"):
            power = 10.0 * np.log10(self.power / exact.power)
        phase = np.angle(self.covariance * exact.covariance.conj())
        return np.stack((phase / _turning(self.range), power, self.visible - exact.visible, phase))

    def cells(self, span_m: tuple[float, float] = WINDOW_M, visible: float = HALF_VISIBLE) -> NDArray[np.bool_]:
        """Those of a span of ranges of which more is seen."""
        return (self.visible > visible) & (self.range >= span_m[0]) & (self.range <= span_m[1])


def _turning(ranges: Array) -> Array:
    """Interferometric phase by height [rad/m]."""
    scene = scene_of()
    return 2.0 * np.pi / scene.wavelength_m * scene.radar.baseline_m / ranges


def expected_maps(
    bench: Bench, mesh: Mesh, tracers: Sequence[str] = TRACERS, sea: Sea | None = None
) -> dict[str, Maps]:
    """The expected maps of a mesh on both sectors, by tracer."""
    maps: dict[str, list[Maps]] = {name: [] for name in tracers}
    for sector in SECTORS:
        simulator = bench.simulator(mesh, sector, sea)
        scene, radar, made = simulator.scene, simulator.installation.radar, simulator.mesh(0)
        for name in tracers:
            simulator._trace = _tracer(name, scene)
            facets, returns, _ = simulator.light(0, mesh=made)
            gates = expected_look_gates(facets, returns.rcs, Installation(radar), scene.retrieval.cell_azimuth_deg)
            truth = polar_truth(facets, returns.rcs, Installation(radar), scene.retrieval, 0)
            cells = _cells(gates.power[0, 0]), _cells(gates.covariance), truth["visible_fraction"].values[0]
            maps[name].append(Maps(gates.range, *cells))
    return {name: _joined(pieces) for name, pieces in maps.items()}


def _cells(gates: NDArray) -> NDArray:
    """Gates gathered into cells of two gates' length."""
    cells = gates.copy()
    cells[:, 1:-1] = 0.25 * gates[:, :-2] + 0.5 * gates[:, 1:-1] + 0.25 * gates[:, 2:]
    return cells


def _joined(pieces: Sequence[Maps]) -> Maps:
    power, covariance, visible = (
        np.concatenate([getattr(each, name) for each in pieces]) for name in ("power", "covariance", "visible")
    )
    return Maps(pieces[0].range, power, covariance, visible)


@dataclass(frozen=True)
class Errors:
    """(quantity,) rms over cells more than half visible, unless said otherwise."""

    window: Array
    headline: Array  # of 50 to 200 m
    sectors: dict[str, Array]
    lit: Array  # over every cell of which anything is seen
    lit_median: Array  # of those, the median error without its sign
    dark: float  # share of those without a height

    @classmethod
    def of(cls, simulated: Maps, exact: Maps) -> Errors:
        errors, cells, lit = simulated - exact, exact.cells(), exact.cells(visible=0.0)
        looks = np.array_split(np.arange(len(cells)), len(SECTORS))
        known = lit & np.isfinite(errors).all(axis=0)
        return cls(
            rms(errors, cells),
            rms(errors, exact.cells(HEADLINE_M)),
            {name: rms(errors[:, part], cells[part]) for name, part in zip(SECTORS, looks, strict=True)},
            rms(errors, lit),
            np.median(np.abs(errors[:, known]), axis=1),
            1.0 - float(known.sum() / lit.sum()),
        )


def rms(errors: Array, cells: NDArray[np.bool_]) -> Array:
    """(quantity,) over the cells with a height."""
    chosen = errors[:, cells & np.isfinite(errors).all(axis=0)]
    return np.sqrt(np.mean(chosen**2, axis=1))


@dataclass(frozen=True)
class Reference:
    """Maps of the reference mesh, and the bounds of their own errors."""

    maps: Maps
    order: Array  # (quantity,): errors fall as the spacings to this power
    residual: Array  # (quantity,) rms

    @classmethod
    def of(cls, bench: Bench, mesh: Mesh, sea: Sea) -> Reference:
        """By `horizon`. Where the rms differences of meshes of halved spacings fall by 2^p, so do the errors, and of
        the last difference 1/(2^p − 1) is left."""
        meshes = [Mesh(mesh.facet_m * times, mesh.columns // times) for times in (4, 2, 1)]
        coarse, middle, fine = (expected_maps(bench, each, ("horizon",), sea)["horizon"] for each in meshes)
        first, second = rms(coarse - middle, fine.cells()), rms(middle - fine, fine.cells())
        order = np.log2(first / second)
        return cls(fine, order, second / (2.0 ** np.clip(order, 0.5, 2.0) - 1.0))


# ------------------------------------------------------------------------------------------------------ seconds


@dataclass
class Timed:
    """Seconds of a setup's turns by stage, one entry a round; of the trace, those of either tracer."""

    simulator: Simulator
    facets: int = 0
    seconds: dict[str, list[float]] = field(default_factory=dict)

    def stage(self, name: str, light: str) -> float:
        return statistics.median(self.seconds[_clock(name, light)])

    def totals(self, light: str) -> Array:
        """(round,) s"""
        return np.sum([self.seconds[_clock(stage, light)] for stage in STAGES], axis=0)


def _clock(stage: str, light: str) -> str:
    return light if stage == "trace" else stage


def take_turns(setups: Sequence[Timed], rounds: int) -> None:
    """Times them, setup by setup and round by round; what only a first turn needs is done in a round before.

    No sea is asked for the same turn twice, so that each makes the knots of its own time, as in a run.
    """
    number: Counter[int] = Counter()
    lights = [{name: _tracer(name, setup.simulator.scene) for name in TRACERS} for setup in setups]
    for turn in range(-1, rounds):
        for setup, light in zip(setups, lights, strict=True):
            if turn > 0 and setup.facets >= LARGE:
                continue
            number[id(setup.simulator.sea)] += 1
            clock = _turn(setup, light, number[id(setup.simulator.sea)], echoes=turn >= 0 or setup is setups[0])
            if turn >= 0:
                for name, taken in clock.seconds.items():
                    setup.seconds.setdefault(name, []).append(taken)


def _turn(setup: Timed, light: dict[str, Callable[..., Any]], number: int, *, echoes: bool) -> Stopwatch:
    """A turn as `Simulator.turn` makes it, but for the truth; lit by either tracer."""
    simulator, clock = setup.simulator, Stopwatch()
    scene, radar = simulator.scene, simulator.installation.radar
    _ = simulator.surface  # calibrated once, as for all turns of a run
    mesh = simulator.mesh(number, clock)
    with clock("horizon"):
        light["horizon"](mesh)
    with clock("facets"):
        lit = light["facets"](mesh)

    def lit_before(part: SurfaceMesh) -> Illumination:
        first = part.grid.first - mesh.grid.first
        return lit.part(slice(first, first + part.grid.columns))

    simulator._trace = lit_before  # of a large turn part by part
    facets, returns, _ = simulator.light(number, clock, mesh)
    del clock.seconds["trace"]
    setup.facets = facets.height.size
    if echoes:
        with clock("echoes"):
            fired = pulses(simulator.installation, number)
            speckle = scene.seed, scene.scattering.decorrelation_time_s
            share = truncation_share(simulator.sea.resolved.elevation_std, scene.tracing.height_error_m)
            heard = turn_echoes(
                facets, returns.rcs, Installation(radar), fired, *speckle, motion=returns.motion, neglected=share
            )
            echo_dataset(Installation(radar), [fired], [heard], scene.scattering.polarization, None, number)
    return clock


# ------------------------------------------------------------------------------------------------ points, fronts


@dataclass(frozen=True)
class Point:
    """A setup, its seconds and its errors."""

    tracer: str
    mesh: Mesh
    timed: Timed
    errors: Errors

    @property
    def seconds(self) -> float:
        return float(np.median(self.timed.totals(self.tracer)))

    @property
    def label(self) -> str:
        return f"{self.tracer} {self.mesh}"


def front(points: Sequence[Point], quantities: Sequence[int]) -> list[Point]:
    """Points than which no other is better, in seconds and in these quantities; by seconds."""
    costs = np.array([(point.seconds, *point.errors.window[list(quantities)]) for point in points])
    beaten = [bool(((costs <= own).all(axis=1) & (costs < own).any(axis=1)).any()) for own in costs]
    return sorted((p for p, each in zip(points, beaten, strict=True) if not each), key=lambda p: p.seconds)


# ------------------------------------------------------------------------------------------------------- pulses


def retrieved_errors(seed: int, kept: int, mesh: Mesh, sector: str) -> tuple[float, float]:
    """rms [m] of retrieved heights, of the whole window and of 50 to 200 m: cells more than half visible."""
    at = {"radar.sector_deg": [*SECTORS[sector]], "radar.prf_hz": scene_of().radar.prf_hz / kept, "seed": seed}
    scene = scene_of(**mesh.keys(), **at)
    turn = Simulator(scene).turn(0)
    maps = sr.retrieve(turn.echoes)
    got, true = (each["polar"].to_dataset().isel(turn=0) for each in (maps, turn.truth))
    error, seen = (got["height"] - true["height"]).values, true["visible_fraction"].values > HALF_VISIBLE
    clear = (got["quality"].values & QUALITY_FLAGS["ambiguous"]) == 0
    ranges, known = got["range"].values, seen & clear & np.isfinite(error)
    whole, headline = (error[known & (ranges >= near) & (ranges <= far)] for near, far in (WINDOW_M, HEADLINE_M))
    return float(np.sqrt(np.mean(whole**2))), float(np.sqrt(np.mean(headline**2)))


def crossed(facets: Sequence[float], columns: Sequence[int]) -> list[Mesh]:
    return [Mesh(*each) for each in itertools.product(facets, columns)]
