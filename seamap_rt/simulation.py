"""The forward half: scene → sea → mesh → light → echoes, turn by turn, and the truth beside them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .compute.machine import A_RUN, check_memory
from .conventions import unit_from_azimuth
from .dataset import build
from .echoes import expected_look_gates
from .echoes.dataset import echo_dataset
from .echoes.radar_cross_section import Returns, SeaSurface, TurnAccumulator
from .echoes.receiving import ReceivedTurn
from .echoes.response import truncation_share
from .echoes.scenery import Scenery
from .echoes.spike_field import SpikeField
from .echoes.texture_field import TextureField
from .echoes.turn import turn_echoes
from .errors import InputError
from .mesh import Facets, SurfaceMesh, polar_grid, surface_mesh
from .mesh.grid import PolarGrid, circle_grid
from .mesh.surface import sea_on_grid, submerged_lines
from .radar.platform import BoatMotion
from .radar.scan import Pulses, pulses
from .resolved_scene import check_record, installation_of, run_sea, sea_key
from .scattering.permittivity import permittivity_of
from .scattering.sea_spikes import sea_spikes
from .scattering.texture import Texture
from .scene import Scene, SceneLike, as_scene
from .scene.agreement import run_bytes
from .sea import Sea
from .tracing import Illumination, RayScenes, UnresolvedWaves, tracer
from .tracing.visibility import water_powers
from .truth import ground_truth, mask_unknown, polar_truth
from .visible_share import VisibleShare

_FOLD_LINES = 8  # one line of the mesh in so many is searched for folds


@dataclass
class Stopwatch:
    """Seconds per named step. on_stage: called with each step's name as it begins."""

    seconds: dict[str, float] = field(default_factory=dict)
    on_stage: Callable[[str], object] | None = None

    @contextmanager
    def __call__(self, step: str) -> Iterator[None]:
        if self.on_stage is not None:
            self.on_stage(step)
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
    begun: float  # s, by time.perf_counter
    timing: dict[str, float]
    facets: int
    rays: int
    slope_rms_look: float  # of the facets, along the look
    folded_share: float  # of the mesh's points that lie under a crest which folds over; 0 for linear waves


class Simulator:
    """Simulates a scene turn by turn; what turns share (the sea, the traced scene) is made once.

    `sea` is the run's own sea. It is drawn from a branch of the scene's seed (`random_streams.Stream.SEA`), and
    so shares no random number with speckle and noise: `sea.realize(scene.sea, scene.seed)` is another one.
    """

    def __init__(
        self,
        scene: Scene,
        sea: Sea | None = None,
        ray_scenes: RayScenes | None = None,
        motion: BoatMotion | None = None,
    ) -> None:
        """sea, ray_scenes: of another run in this process that is over, to be used again instead of being made anew:
        its sea, if it has the sea of this scene too, and the scenes that it traced. They change no bit.
        motion: of the boat at any times (n,) s, asked turn by turn; left out, what `scene.platform` says."""
        if any(each.pattern == "isotropic" for each in scene.radar.antennas or (scene.radar.antenna,)):
            raise InputError(
                "radar.antenna.pattern = 'isotropic': an isotropic antenna hears the whole circle at every pulse; "
                "it serves from_scatterers only. Choose slotted_waveguide, gaussian or file to simulate a sea"
            )
        with suppress(ValueError):  # of a sea that `run_sea` refuses in its own words
            check_memory(f"a run of {scene.name}", A_RUN._replace(memory=run_bytes(scene)))
        self._sea_key = sea_key(scene)
        self.scene, self.sea = scene, sea or run_sea(scene)
        check_record(scene, self.sea)
        self.installation = installation_of(scene, self.sea, motion)
        radar = self.installation.radar
        self.ray_scenes: RayScenes = {} if ray_scenes is None else ray_scenes
        self._trace = tracer(scene.tracing.tracer, radar, scene.scattering, scene.tracing.diffraction, self.ray_scenes)
        self._scattering = SeaSurface(
            scene.scattering,
            radar,
            self.sea.resolved.wavenumber_limit,
            spikes=spikes_of(scene, self.sea),
            texture=texture_of(scene, self.sea),
        )
        self._surface = None if self._scattering.needs_calibration else self._scattering
        self.unresolved = UnresolvedWaves.of(scene, self.sea.resolved.wavenumber_limit)
        self.scenery = Scenery(scene, self.installation)
        self.visible: VisibleShare | None = None  # of the first turn, once it is simulated
        self._refuse_if_under_water()

    def shares_sea_with(self, scene: Scene) -> bool:
        """Whether the scene's sea is this run's, waves and all."""
        return self._sea_key == sea_key(scene)

    def mesh(self, turn: int, clock: Stopwatch | None = None) -> SurfaceMesh:
        """The meshed sea of a turn."""
        clock = clock or Stopwatch()
        with clock("mesh"):
            grid = polar_grid(self.installation, self.scene.meshing, turn)
        return self._mesh(grid, clock)

    def _mesh(self, grid: PolarGrid, clock: Stopwatch) -> SurfaceMesh:
        with clock("sea"):
            water = sea_on_grid(self.sea, grid, self._scattering.memory_rate)
        with clock("mesh"):
            mesh = surface_mesh(grid, *water)
            del water  # most of it is not the mesh's
            _ = mesh.facets
        return mesh

    def light(
        self, turn: int, clock: Stopwatch | None = None, mesh: SurfaceMesh | None = None
    ) -> tuple[Illumination, Returns, NDArray[np.bool_]]:
        """Lit facets of a turn, what they return, and the lines at which the antenna is under water."""
        clock, surface = clock or Stopwatch(), self.surface
        mesh = mesh or self.mesh(turn, clock)
        gathered = TurnAccumulator(mesh.grid.columns)
        for columns, light in self._lights(mesh, clock):
            with clock("mesh"):
                strain = mesh.part(columns).strain
            with clock("echoes"), clock("scattering"):
                gathered.add(columns, light, surface(light, strain))
        with clock("sea"):
            submerged = submerged_lines(mesh, self.sea)
        return *gathered.collect(mesh.facets), submerged

    def _lights(self, mesh: SurfaceMesh, clock: Stopwatch) -> Iterator[tuple[slice, Illumination]]:
        """The lit facets of the levelled mesh, of a large turn part by part: where all rays stay in their columns, no
        more of it is made than that part."""
        whole = None if mesh.upright else self._trace_light(mesh, slice(0, mesh.grid.columns), clock)
        for columns in mesh.grid.parts:
            yield columns, self._trace_light(mesh, columns, clock) if whole is None else whole.part(columns)

    def _trace_light(self, mesh: SurfaceMesh, columns: slice, clock: Stopwatch) -> Illumination:
        with clock("mesh"):
            levelled = mesh.levelled_part(columns)
        with clock("trace"):
            light = self.scenery.hide(self._trace(levelled))
            if self.unresolved is not None:
                with clock("shade"):
                    light = self.shaded(light)
        return light

    @property
    def surface(self) -> SeaSurface:
        """How the sea scatters, its mean found once on samples of the whole circle, for all turns and any sector."""
        if self._surface is None:
            self._surface = self._calibrated()
        return self._surface

    def _calibrated(self) -> SeaSurface:
        grid, columns = circle_grid(self.installation.radar, self.scene.meshing)
        scattering, diffraction = self.scene.scattering, self.scene.tracing.diffraction
        light = tracer("horizon", self.installation.radar, scattering, diffraction=diffraction)
        mesh = self._mesh(grid, Stopwatch())
        return self._scattering.calibrated(self.shaded(light(mesh.levelled)), mesh.strain, columns)

    def shaded(self, light: Illumination) -> Illumination:
        """What tracers give, less what the scene has waves hide that the mesh does not carry."""
        return light if self.unresolved is None else self.unresolved.shade(light)

    def turn(self, number: int, on_stage: Callable[[str], object] | None = None) -> Turn:
        """Simulate one turn: every pulse, both receivers, and the truth in the cells of the maps.

        on_stage: called with the name of each step as it begins.
        """
        clock, begun = Stopwatch(on_stage=on_stage), time.perf_counter()
        fired = pulses(self.installation, number)
        clock.seconds["calibrate"] = 0.0
        if self._surface is None:
            with clock("calibrate"):
                _ = self.surface  # of the whole circle, of which a sector's sea is then a part that is known
        mesh = self.mesh(number, clock)
        light, returns, submerged = self.light(number, clock, mesh)
        with clock("objects"):
            objects = self.scenery.voltages(mesh, fired)
        with clock("echoes"):
            received = self._receive(light, returns, fired, objects)
        with clock("truth"):
            cells = polar_truth(light, returns.rcs, self.installation, self.scene.retrieval, number)
            if self.visible is None:
                self.visible = self._visible_share(mesh, light)
        rays, facets = light.rays, mesh.facets
        del light, returns  # before more is made
        with clock("echoes"):
            echoes = self._record(received, _submerged_pulses(submerged, facets, fired), fired, number)
        with clock("truth"):
            truth = self._truth(cells, number)
        with clock("sea"):
            folded = self._folded_share(facets)
        timing = {**clock.seconds, "total": time.perf_counter() - begun}
        slope = float(np.sqrt(np.mean(np.square(facets.slope_look, dtype=np.float64))))
        return Turn(number, echoes, truth, begun, timing, int(facets.height.size), rays, slope, folded)

    def _receive(
        self, light: Illumination, returns: Returns, fired: Pulses, objects: NDArray[np.complex64] | None
    ) -> ReceivedTurn:
        """The pulses as they are received, noise and all; objects: their voltages."""
        scene = self.scene
        neglected = truncation_share(self.sea.resolved.elevation_std, scene.tracing.height_error_m)
        if returns.running is not None:
            light = replace(light, velocity_look=light.velocity_look + returns.running)
        speckle = scene.seed, scene.scattering.decorrelation_time_s
        return turn_echoes(light, returns.rcs, self.installation, fired, *speckle, returns.motion, objects, neglected)

    def _record(self, received: ReceivedTurn, under_water: NDArray[np.bool_], fired: Pulses, number: int) -> xr.Dataset:
        """The schema's `echoes`, without the pulses (pulse,) of an antenna under water."""
        received.voltage[under_water] = np.nan
        rest = self.scene.scattering.polarization, [under_water], number, self.scene.resolved_retrieval
        return echo_dataset(self.installation, [fired], [received], *rest)

    def _truth(self, cells: xr.Dataset, number: int) -> xr.DataTree:
        """The truth of a turn on both grids; cells: what the facets say of the polar one."""
        scene, resolved = self.scene, self.sea.resolved
        ground = ground_truth(self.sea, self.installation, scene.retrieval, number)
        polar = mask_unknown(cells, self.sea, self.installation, scene.retrieval)
        if resolved.record_start_s is not None:  # to lay the record's own gauges beside
            zero = {"record_start_s": resolved.record_start_s, "record_start": resolved.record_start}
            polar, ground = polar.assign_attrs(zero), ground.assign_attrs(zero)
        return xr.DataTree.from_dict({"/polar": polar, "/ground": ground})

    def _visible_share(self, mesh: SurfaceMesh, light: Illumination) -> VisibleShare:
        water = permittivity_of(self.scene.scattering, self.installation.radar.frequency_hz)

        def parts() -> Iterator[tuple[Illumination, list[NDArray[np.float64]]]]:
            for columns in mesh.grid.parts:
                part = light.part(columns)
                open_to = replace(part, lit=np.ones_like(part.lit), field=None)  # but for objects
                free = self.scenery.hide(open_to).visible_to_both
                powers = water_powers(mesh.part(columns), water, self.scene.wavelength_m)
                yield part, [each * free for each in powers]

        return VisibleShare.of(parts(), mesh.grid, self.installation.radar)

    def _folded_share(self, facets: Facets) -> float:
        """Share of the mesh's points, on every eighth line, over which choppy waves fold."""
        if self.scene.sea.model == "linear":
            return 0.0
        grid, lines = facets.grid, slice(None, None, _FOLD_LINES)
        east, north = (part[:, None] * grid.ground_range for part in unit_from_azimuth(grid.azimuth[lines]))
        return float(np.mean(self.sea.folded(east, north, grid.time[lines, None])))

    def _refuse_if_under_water(self) -> None:
        radar = self.installation.radar
        centre = self.installation.pose(np.zeros(1)).positions[0]
        level = self.sea.elevation(centre[:, 0], centre[:, 1], np.zeros(len(centre)))
        if (level >= centre[:, 2]).any():
            worst = int(np.argmax(level - centre[:, 2]))
            name = ("lower", "upper")[worst] if not radar.antennas else f"{worst}."
            raise InputError(
                f"radar.height_m = {radar.height_m:g}: the {name} antenna, at "
                f"{centre[worst, 2]:.2f} m, is under water at time 0 (the sea stands at {level[worst]:.2f} m there); "
                "raise radar.height_m or choose another seed"
            )


def spikes_of(scene: Scene, sea: Sea) -> SpikeField | None:
    """The run's breakers as single events, where its scene has them."""
    settings = scene.scattering
    if not settings.has_sea_spikes:
        return None
    found = sea_spikes(settings.wind_speed_m_s, settings.inverse_wave_age, scene.radar.frequency_hz)
    return None if found is None else SpikeField(found, scene.seed, settings.wind_from_deg, sea.current)


def texture_of(scene: Scene, sea: Sea) -> TextureField | None:
    """The run's patches of breakers, where its scene has them."""
    settings = scene.scattering
    if not (settings.texture and settings.breaking and settings.nrcs == "two_scale"):
        return None
    return TextureField(Texture.of(settings.wind_speed_m_s), scene.seed, settings.wind_from_deg, sea.current)


def expected(scene: SceneLike, turn: int = 0, spikes: bool = False) -> xr.Dataset:
    """Noise-free, speckle-averaged `power(transmitter, receiver, azimuth, range)` and `covariance(azimuth, range)` [W]
    of one turn, each look averaged over its dwell: what tracers and facet sizes are compared on. It is the sea's echo:
    objects shadow it, but what they echo themselves is not in it. It is the mean over breakers too, unless spikes
    asks for the run's own, where `scattering.sea_spikes` or `texture` has them."""
    scene = as_scene(scene)
    if not spikes:
        mean = {"sea_spikes": False, "texture": False}
        scene = scene.model_copy(update={"scattering": scene.scattering.model_copy(update=mean)})
    simulator = Simulator(scene)
    facets, returns, _ = simulator.light(turn)
    gates = expected_look_gates(facets, returns.rcs, simulator.installation, scene.retrieval.cell_azimuth_deg)
    return build(
        "expected",
        {"power": gates.power, "covariance": gates.covariance},
        {
            "azimuth": (simulator.installation.radar.sector_deg[0] + gates.sweep) % 360.0,
            "range": gates.range,
            "transmitter": range(gates.power.shape[0]),
            "receiver": range(gates.power.shape[1]),
        },
    )


def _submerged_pulses(submerged: NDArray[np.bool_], facets: Facets, fired: Pulses) -> NDArray[np.bool_]:
    """(pulse,): the antenna is under water when the pulse is fired."""
    if not submerged.any():
        return np.zeros(fired.number.size, dtype=bool)
    line = np.rint((fired.sweep - facets.grid.sweep[0]) / facets.grid.spacing_deg).astype(int)
    return submerged[np.clip(line, 0, submerged.size - 1)]
