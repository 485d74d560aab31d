"""The forward half: scene → sea → mesh → light → echoes, turn by turn, and the truth beside them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from . import sea as sea_package
from .conventions import EARTH_RADIUS, db, unit_from_azimuth
from .dataset import build
from .echoes import expected_look_gates, turn_voltages
from .echoes.files import EchoStore, echo_dataset
from .echoes.radar_cross_section import Returns, SeaSurface
from .io.scenefile import InputError
from .io.turnfile import TurnFile, uninterrupted
from .mesh import Facets, SurfaceMesh, polar_grid, surface_mesh
from .mesh.polar import PolarGrid, sea_on_grid, submerged_lines
from .radar.scan import Pulses, phase_centres, pulses
from .scattering import MEAN_MODELS
from .scattering.short_waves import ShortWaves
from .scene import Scene
from .sea import Resolved, spectral_system
from .settings import RandomWaves, ScatteringSettings
from .tracing import tracer
from .tracing.circle import circle_grid
from .truth import ground_truth, polar_truth

_SEA_STAGE = 1  # of the scene's random source; speckle is 2, noise 3
_BREAKING_STEEPNESS = 0.06  # Hs over the peak's length
_CARRIED = 0.97
_BREAKING_DEPTH = 0.6  # Hs over the depth
_FOLD_LINES = 8  # one line of the mesh in so many is searched for folds


@dataclass
class Stopwatch:
    """Seconds per named step."""

    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def __call__(self, step: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[step] = self.seconds.get(step, 0.0) + time.perf_counter() - start


@dataclass(frozen=True)
class Turn:
    """One simulated turn."""

    number: int
    echoes: xr.Dataset
    truth: xr.DataTree
    timing: dict[str, float]
    facets: int
    rays: int
    slope_rms_look: float  # of the facets, along the look
    folded_share: float  # of the mesh's points that lie under a crest which folds over; 0 for linear waves


@dataclass(frozen=True)
class Simulation:
    """Echoes and truth of a whole run, and what is known of how it was made."""

    echoes: xr.Dataset
    truth: xr.DataTree
    timing: list[dict[str, float]]
    facts: dict[str, Any]


class Simulator:
    """Simulates a scene turn by turn; what turns share (the sea, the traced scene) is made once.

    `sea` is the run's own sea. It is drawn from a branch of the scene's seed, SeedSequence(seed, spawn_key=(1,)), and
    so shares no random number with speckle and noise: `sea.realize(scene.sea, scene.seed)` is another one.
    """

    def __init__(self, scene: Scene) -> None:
        if scene.radar.antenna.pattern == "isotropic":
            raise InputError(
                "radar.antenna.pattern = 'isotropic': an isotropic antenna hears the whole circle at every pulse; "
                "it serves from_scatterers only. Choose slotted_waveguide or gaussian to simulate a sea"
            )
        self.scene = scene
        try:
            self.sea = sea_package.realize(scene.sea, np.random.SeedSequence(scene.seed, spawn_key=(_SEA_STAGE,)))
        except ValueError as error:
            raise InputError(f"sea: {error}") from None
        self._trace = tracer(scene.tracing.tracer, scene.radar, scene.scattering, diffraction=scene.tracing.diffraction)
        self._scattering = SeaSurface(scene.scattering, scene.radar, self.sea.resolved.wavenumber_limit)
        self._refuse_if_under_water()

    def mesh(self, turn: int, clock: Stopwatch | None = None) -> SurfaceMesh:
        """The meshed sea of a turn."""
        return self._mesh(polar_grid(self.scene.radar, self.scene.tracing, turn), clock or Stopwatch())

    def _mesh(self, grid: PolarGrid, clock: Stopwatch) -> SurfaceMesh:
        with clock("sea"):
            elevation, velocity, *shift = sea_on_grid(self.sea, grid, self._scattering.memory_rate)
        with clock("mesh"):
            mesh = surface_mesh(grid, elevation, velocity, self.scene.radar, *shift)
            _ = mesh.facets
        return mesh

    def light(self, turn: int, clock: Stopwatch | None = None) -> tuple[Facets, Returns, NDArray[np.bool_]]:
        """Lit facets of a turn, what they return, and the lines at which the antenna is under water."""
        clock = clock or Stopwatch()
        with clock("calibrate"):
            surface = self.surface
        mesh = self.mesh(turn, clock)
        with clock("trace"):
            facets = self._trace(mesh)
        with clock("echoes"):
            returns = surface(facets)
        with clock("sea"):
            drowned = submerged_lines(mesh, self.sea, self.scene.radar)
        return facets, returns, drowned

    @cached_property
    def surface(self) -> SeaSurface:
        """How the sea scatters, its mean found once on samples of the whole circle, for all turns and any sector."""
        if not self._scattering.needs_calibration:
            return self._scattering
        grid, columns = circle_grid(self.scene.radar, self.scene.tracing)
        light = tracer("horizon", self.scene.radar, self.scene.scattering, diffraction=self.scene.tracing.diffraction)
        return self._scattering.calibrated(light(self._mesh(grid, Stopwatch())), columns)

    def turn(self, number: int) -> Turn:
        """Simulate one turn: every pulse, both receivers, and the truth in the cells of the maps."""
        scene, clock = self.scene, Stopwatch()
        start = time.perf_counter()
        fired = pulses(scene.radar, number)
        facets, returns, drowned = self.light(number, clock)
        with clock("echoes"):
            voltages = turn_voltages(
                facets,
                returns.rcs,
                scene.radar,
                fired,
                scene.seed,
                scene.scattering.decorrelation_time_s,
                motion=returns.motion,
            )
            under_water = _drowned_pulses(drowned, facets, fired)
            voltages[under_water] = np.nan
            echoes = echo_dataset(
                scene.radar, [fired], [voltages], scene.scattering.polarization, [under_water], first_turn=number
            )
        with clock("truth"):
            truth = xr.DataTree.from_dict(
                {
                    "/polar": polar_truth(facets, returns.rcs, scene.radar, scene.retrieval, number),
                    "/ground": ground_truth(self.sea, scene.radar, scene.retrieval, number),
                }
            )
        with clock("sea"):
            folded = self._folded_share(facets)
        count = int(facets.height.size)
        timing = {**clock.seconds, "total": time.perf_counter() - start}
        slope = float(np.sqrt(np.mean(np.square(facets.slope_look, dtype=np.float64))))
        return Turn(number, echoes, truth, timing, count, facets.rays, slope, folded)

    def _folded_share(self, facets: Facets) -> float:
        """Share of the mesh's points, on every eighth line, over which choppy waves fold."""
        if self.scene.sea.model == "linear":
            return 0.0
        grid, lines = facets.grid, slice(None, None, _FOLD_LINES)
        east, north = (part[:, None] * grid.ground_range for part in unit_from_azimuth(grid.azimuth[lines]))
        return float(np.mean(self.sea.folded(east, north, grid.time[lines, None])))

    def facts(self) -> dict[str, Any]:
        """What was modelled, what was left out and why, and which waves are resolved."""
        return {
            "modelled": _modelled(self.scene, self.sea.resolved),
            "left_out": _left_out(self.scene, self.sea.resolved),
            "sea": self._sea_facts(),
            "short_waves": self._short_waves(),
            "calibration": self._calibration(),
        }

    def _calibration(self) -> dict[str, list[float]] | None:
        """How many dB the calibration adds to what theory gives, by grazing angle and direction; None without one."""
        scale = self.surface.scale
        if scale is None:
            return None
        (near, far), height = self.scene.radar.range_m, self.scene.radar.height_m
        grazing = np.geomspace(np.arcsin(height / far), np.arcsin(min(1.0, height / near)), 5)
        looks = {"up_wind_db": 0.0, "cross_wind_db": 0.5 * np.pi, "down_wind_db": np.pi}
        added = {name: db(scale(grazing, angle)).tolist() for name, angle in looks.items()}
        return {"grazing_deg": np.degrees(grazing).tolist(), **added}

    def _short_waves(self) -> dict[str, float] | None:
        """What the scattering takes over from the mesh; None where its level is a given."""
        if self.scene.scattering.nrcs != "two_scale":
            return None
        sea, limit = self.scene.sea, self.sea.resolved.wavenumber_limit
        scattering = self.scene.scattering
        waves = ShortWaves(scattering.wind_speed_m_s, limit, scattering.inverse_wave_age)
        systems = [spectral_system(each, sea.depth_m) for each in sea.waves if isinstance(each, RandomWaves)]
        step = waves.level_step_db(
            lambda k: np.asarray(sum((system.radial(k) for system in systems), np.zeros(k.size)))
        )
        slope = self.sea.resolved.mean_square_slope
        return {
            "wavenumber_from": limit,
            "variance": waves.variance,
            "mean_square_slope": waves.mean_square_slope,
            "resolved_slope_share": slope / (slope + waves.mean_square_slope),
            "level_step_db": step,
        }

    def _sea_facts(self) -> dict[str, Any]:
        return {name: _plain(value) for name, value in asdict(self.sea.resolved).items()}

    def _refuse_if_under_water(self) -> None:
        radar = self.scene.radar
        azimuth = np.array([radar.sector_deg[0]])
        centre = phase_centres(radar, azimuth)[0]
        level = self.sea.elevation(centre[:, 0], centre[:, 1], np.zeros(2))
        if (level >= centre[:, 2]).any():
            worst = int(np.argmax(level - centre[:, 2]))
            raise InputError(
                f"radar.height_m = {radar.height_m:g}: the {('lower', 'upper')[worst]} antenna, at "
                f"{centre[worst, 2]:.2f} m, is under water at time 0 (the sea stands at {level[worst]:.2f} m there); "
                "raise radar.height_m or choose another seed"
            )


def simulate(scene: Scene, out: str | Path | None = None, *, overwrite: bool = False) -> Simulation:
    """Simulate all turns of a scene.

    out: a folder into which `echoes.zarr` and `truth.nc` are streamed turn by turn, so that memory holds one turn; the
    datasets of the result are then read from there. Without it everything stays in memory. Earlier echoes or truth in
    that folder are replaced only with `overwrite`.
    Raises InputError for a scene that cannot be simulated, NoBackend if rays are asked for and cannot be traced.
    """
    simulator = Simulator(scene)
    if out is None:
        turns = [simulator.turn(number) for number in range(scene.turns)]
        echoes = xr.concat([t.echoes for t in turns], "pulse", data_vars="minimal", coords="minimal", compat="override")
        echoes.attrs = turns[-1].echoes.attrs
        truth = xr.DataTree.from_dict(
            {
                f"/{group}": xr.concat([t.truth[group].to_dataset() for t in turns], "turn", data_vars="all")
                for group in ("polar", "ground")
            }
        )
        return Simulation(echoes, truth, [t.timing for t in turns], simulator.facts())
    folder = Path(out)
    for name in ("echoes.zarr", "truth.nc"):
        if (folder / name).exists() and not overwrite:
            raise InputError(f"out = '{folder}': holds an earlier {name}; choose another folder, or overwrite it")
    folder.mkdir(parents=True, exist_ok=True)
    store, timing = EchoStore(folder / "echoes.zarr"), []
    with TurnFile(folder / "truth.nc") as truth_file:
        for number in range(scene.turns):
            turn = simulator.turn(number)
            with uninterrupted():
                store.append(turn.echoes)
                truth_file.append(turn.truth)
            timing.append(turn.timing)
    from .interferometry import open_echoes

    return Simulation(
        open_echoes(folder / "echoes.zarr"), xr.open_datatree(folder / "truth.nc"), timing, simulator.facts()
    )


def expected(scene: Scene, turn: int = 0) -> xr.Dataset:
    """Noise-free, speckle-averaged `power(transmitter, receiver, azimuth, range)` and `covariance(azimuth, range)` [W]
    of one turn, each look averaged over its dwell: what tracers and facet sizes are compared on."""
    facets, returns, _ = Simulator(scene).light(turn)
    gates = expected_look_gates(facets, returns.rcs, scene.radar, scene.retrieval.cell_azimuth_deg)
    return build(
        "expected",
        {"power": gates.power, "covariance": gates.covariance},
        {
            "azimuth": (scene.radar.sector_deg[0] + gates.sweep) % 360.0,
            "range": gates.range,
            "transmitter": [0, 1],
            "receiver": [0, 1],
        },
    )


def _drowned_pulses(drowned: NDArray[np.bool_], facets: Facets, fired: Pulses) -> NDArray[np.bool_]:
    """(pulse,): the antenna is under water when the pulse is fired."""
    if not drowned.any():
        return np.zeros(fired.number.size, dtype=bool)
    line = np.rint((fired.sweep - facets.grid.sweep[0]) / facets.grid.spacing_deg).astype(int)
    return drowned[np.clip(line, 0, drowned.size - 1)]


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, dict):
        return {name: _plain(v) for name, v in value.items()}
    if isinstance(value, tuple | list | np.ndarray):
        return [_plain(v) for v in value]
    return value


def _modelled(scene: Scene, resolved: Resolved) -> list[dict[str, str]]:
    radar, scattering = scene.radar, scene.scattering
    light = {
        "facets": "a shadow ray to each facet that faces the antenna, for each antenna, traced by Sionna RT/Mitsuba",
        "horizon": "running maximum of the elevation angle, float64",
    }[scene.tracing.tracer]
    if scene.tracing.diffraction == "knife_edge":
        light += "; beyond a crest, and close above it, the field of two knife edges"
    rows = [
        ("sea", _sea_words(scene, resolved)),
        ("shadowing", light),
        ("scattering", f"{scattering.polarization}: {_scattering_words(scattering)}"),
        ("speckle", f"complex Gaussian per facet, decorrelation time {1e3 * scattering.decorrelation_time_s:g} ms"),
        ("motion", _motion_words(scattering)),
        ("scan", "azimuth is time: each column of the sea is meshed when the beam passes it"),
        ("mode", f"{radar.transmit} transmitter, {radar.interferogram} interferogram"),
        (
            "receiver",
            "rectangular pulse through a Gaussian filter; " + ("thermal noise" if radar.noise else "no noise"),
        ),
    ]
    return [{"what": what, "why": why} for what, why in rows]


def _scattering_words(scattering: ScatteringSettings) -> str:
    if scattering.nrcs == "constant":
        return f"{scattering.nrcs_db:g} dB per horizontal area, shadowing on top"
    paper = MEAN_MODELS[scattering.mean_model].paper if scattering.mean_model else ""
    if scattering.nrcs != "two_scale":
        return f"the mean of {paper} on every lit facet, shadowing counted once"
    words = ["Bragg waves and mirrors on each facet, tilted by it and by the wind's waves that the mesh does not carry"]
    if scattering.hydrodynamic_modulation:
        words.append("their height modulated by the strain of the resolved waves")
    if scattering.breaking:
        words.append("breakers, most of them where the resolved waves converge")
    words.append(f"mean calibrated to {paper}, shadowing counted once" if paper else "theory's own mean")
    return "; ".join(words)


def _motion_words(scattering: ScatteringSettings) -> str:
    water = "each facet's phase follows its water particle while the beam dwells on it"
    if scattering.doppler == "orbital":
        return water
    extra = "Bragg waves of both directions run on it at their phase speed"
    if scattering.nrcs == "two_scale" and scattering.breaking:
        extra += ", breakers at theirs"
    return f"{water}; {extra}"


def _sea_words(scene: Scene, resolved: Resolved) -> str:
    kind = {"linear": "linear", "choppy": "choppy (first-order Lagrangian)"}[scene.sea.model]
    current = f", on a current of {scene.sea.current_m_s:g} m/s" if scene.sea.current_m_s > 0.0 else ""
    return (
        f"{kind}, evolving{current}; waves longer than {2.0 * resolved.resolution_m:.3g} m resolved: "
        f"{resolved.variance_share:.2%} of the variance, {resolved.mean_square_slope_share:.0%} of the same "
        "spectra's mean square slope"
    )


def _left_out(scene: Scene, resolved: Resolved) -> list[dict[str, str]]:
    beam = np.radians(scene.radar.antenna.azimuth_beamwidth_deg)
    facet_width = scene.radar.range_m[1] * beam / scene.tracing.columns_per_beam
    rows = [
        ("multiple scattering", "one bounce; the second is not traced"),
        ("boat motion", "the boat is at rest"),
        ("analogue-to-digital conversion", "ideal complex gates; no quantisation or saturation"),
        (
            "slopes of resolved waves that the mesh is too coarse for",
            f"its columns are {facet_width:.2g} m wide at the far gate, its rungs {scene.tracing.facet_m:g} m apart; "
            f"the shortest resolved waves are {2.0 * resolved.resolution_m:.2g} m long",
        ),
        (
            "Earth curvature",
            f"flat Earth: the drop at {scene.radar.range_m[1]:g} m is "
            f"{scene.radar.range_m[1] ** 2 / (2.0 * 4.0 / 3.0 * EARTH_RADIUS):.2g} m",
        ),
    ]
    rows += _left_out_of_the_scattering(scene)
    rows += _left_out_of_the_sea(scene, resolved)
    return [{"what": what, "why": why} for what, why in rows]


def _left_out_of_the_scattering(scene: Scene) -> list[tuple[str, str]]:
    scattering, rows = scene.scattering, list[tuple[str, str]]()
    if scene.tracing.diffraction == "none":
        rows.append(
            (
                "diffraction at shadow edges",
                "geometric shadows; an edge blurs by about 0.5 m at X band; tracing.diffraction = 'knife_edge'",
            )
        )
    if scattering.doppler == "orbital":
        rows.append(("the scatterers' own velocity", "facets move with the water only; scattering.doppler = 'full'"))
    if scattering.nrcs == "two_scale":
        rows.append(("shadows of waves that are not resolved", "the mesh does not carry them; a tilt may turn away"))
        if scattering.breaking:
            rows.append(("a breaker's life", "breakers are a share of each facet, not bursts that grow and fade"))
        else:
            rows.append(("breakers", "scattering.breaking = false: HH owes its mean to the calibration"))
        if not scattering.hydrodynamic_modulation:
            rows.append(("hydrodynamic modulation", "scattering.hydrodynamic_modulation = false: tilt alone modulates"))
    if scattering.mean_model is not None:
        model = MEAN_MODELS[scattering.mean_model]
        if not model.knows_wind_direction:
            rows.append(
                (
                    "wind-direction contrast of the mean echo",
                    f"{model.paper} is an average over directions; git, tsc and hybrid know them",
                )
            )
        low, high = model.grazing_deg
        rows.append(
            (f"the mean outside {low:g}–{high:g}° grazing", "facets beyond take the value at the edge of its range")
        )
    return rows


def _left_out_of_the_sea(scene: Scene, resolved: Resolved) -> list[tuple[str, str]]:
    rows: list[tuple[str, str]] = []
    if scene.sea.model == "linear":
        rows.append(("sharper crests", "waves are linear; sea.model = 'choppy' sharpens them"))
    else:
        rows.append(
            (
                "skewness of the elevation",
                "0 at the first Lagrangian order; a narrow-banded second-order sea of this height and peak would have "
                f"{resolved.skewness_stokes:.2g}",
            )
        )
    if scene.tracing.facet_m > resolved.resolution_m:
        rows.append(
            (
                f"slopes of resolved waves shorter than {2.0 * scene.tracing.facet_m:g} m along the look",
                f"facets are {scene.tracing.facet_m:g} m apart, the waves' grid {resolved.resolution_m:.3g} m: neither "
                "the mesh nor the scattering has all of them; lower tracing.facet_m or coarsen sea.resolution_m",
            )
        )
    if resolved.carried_share < _CARRIED:
        rows.append(
            (
                "the longest waves' place in the spectrum",
                f"the periodic patch samples {resolved.carried_share:.0%} of a system's variance; the rest is spread "
                "over its other waves; raise sea.extent_m",
            )
        )
    if resolved.significant_steepness > _BREAKING_STEEPNESS:
        rows.append(
            (
                "breaking, which this sea would do",
                f"its significant height over the length of its peak is {resolved.significant_steepness:.2g}; real "
                f"seas stay below about {_BREAKING_STEEPNESS:g}",
            )
        )
    if 4.0 * resolved.elevation_std > _BREAKING_DEPTH * scene.sea.depth_m:
        rows.append(
            (
                "breaking on the bed, which this sea would do",
                f"its significant height is {4.0 * resolved.elevation_std / scene.sea.depth_m:.2g} of the depth; real "
                f"seas stay below about {_BREAKING_DEPTH:g}, and troughs may reach below the bed",
            )
        )
    return rows
