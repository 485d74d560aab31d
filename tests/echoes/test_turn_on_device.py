"""A turn whose facets and light stay on the device from ray to gate: the processor's turn, and what crosses for it.

On LLVM here; on a graphics processor the same kernels run.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.compute.device import device, moved
from seamap_rt.echoes.dataset import echo_dataset
from seamap_rt.echoes.motion import Fastest
from seamap_rt.echoes.returns_on_device import returns_on_device
from seamap_rt.echoes.summation import COLUMNS_ON_DEVICE, VARIABLE
from seamap_rt.echoes.turn import Hearing
from seamap_rt.echoes.turn_on_device import turn_echoes_on_device
from seamap_rt.interferometry import retrieve_one
from seamap_rt.mesh.on_device import MeshOnDevice
from seamap_rt.radar.array import antenna_array
from seamap_rt.radar.scan import pulses
from seamap_rt.scene import load_scene
from seamap_rt.simulation import Simulator, Turn
from seamap_rt.tracing.light_on_device import LightOnDevice
from seamap_rt.tracing.rays import RayTracer
from seamap_rt.truth import polar_truth_on_device
from seamap_rt.truth.kernel import QUANTITIES
from seamap_rt.truth.on_device import FacetsOnDevice

SECTOR = {"radar.sector_deg": [250.0, 254.0], "radar.range_m": [15.0, 150.0], "radar.noise": False}
SCENES = {
    "two scales": ("choppy_sea", {}),
    "a boat that heels, light over edges": ("rough_ride", {"tracing.diffraction": "knife_edge"}),
    "breakers one by one, facets in part": (
        "choppy_sea",
        {"scattering.sea_spikes": True, "tracing.unresolved_shadowing": "smith"},
    ),
    "measured means, switched, noise": (
        "choppy_sea",
        {
            "scattering.nrcs": "nrl",
            "radar.transmit": "switched",
            "radar.noise": True,
            "radar.channel_gain_db": 1.0,
            "radar.channel_phase_deg": 20.0,
        },
    ),
    "constant, alternating": (
        "choppy_sea",
        {
            "scattering.nrcs": "constant",
            "scattering.doppler": "orbital",
            "radar.interferogram": "alternating_pulse",
            "radar.noise": True,
        },
    ),
}


@cache
def simulator(name: str) -> Simulator:
    scene, keys = SCENES[name]
    return Simulator(load_scene(scene, overrides={**SECTOR, **keys}))


def turn_by(name: str, way: str, monkeypatch: pytest.MonkeyPatch, number: int = 0) -> Turn:
    monkeypatch.setenv(VARIABLE, way)
    return simulator(name).turn(number)


def relative_rms(found: NDArray[Any], right: NDArray[Any]) -> float:
    np.testing.assert_array_equal(np.isnan(found), np.isnan(right))
    return float(np.sqrt(np.nanmean(np.abs(found - right) ** 2) / np.nanmean(np.abs(right) ** 2)))


@pytest.mark.parametrize("name", SCENES)
def test_a_turn_is_the_processors(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same draws and light, and the processor's own approximations: what is left is float32, 1e-7 of an amplitude
    and 1e-6 rad of a phase; 4e-6 m of a height, whose gain is 3.6 m/rad at 150 m. The less of a cell's power its
    receivers share, the more its phase errs."""
    one, other = (turn_by(name, way, monkeypatch) for way in ("processor", "device"))
    found, right = (retrieve_one(each.echoes)["polar"].to_dataset() for each in (other, one))
    assert "here" not in vars(other.echoes["voltage"].data)  # nor have they come back for it
    off = (found["height"] - right["height"]).values * right["coherence"].values
    np.testing.assert_allclose(off, np.where(np.isfinite(right["height"].values), 0.0, np.nan), rtol=0.0, atol=4e-6)
    np.testing.assert_array_equal(found["quality"].values, right["quality"].values)
    assert relative_rms(other.echoes["voltage"].values, one.echoes["voltage"].values) <= 2e-6
    truth = other.truth["polar"].to_dataset()
    for key, right in one.truth["polar"].to_dataset().data_vars.items():
        found = truth[key].values
        np.testing.assert_allclose(found, right.values, rtol=0.0, atol=2e-5, err_msg=str(key))


@pytest.mark.parametrize("levelled", [False, True])
def test_facets_there_are_those_of_the_host(levelled: bool) -> None:
    mesh = simulator("two scales").mesh(0)
    there, here, strain = MeshOnDevice.of(mesh), mesh.levelled if levelled else mesh, mesh.strain
    there = there.levelled if levelled else there
    of, facets = device(), here.facets
    lane = of.dr.arange(of.UInt32, facets.height.size)
    column, facet = lane // there.facets, lane % there.facets
    np.testing.assert_allclose(np.array(there.height(column, facet)), facets.height.ravel(), rtol=0.0, atol=1e-15)
    pairs = (
        *zip(there.slopes(column, facet), (facets.slope_look, facets.slope_cross), strict=True),
        *zip(there.velocities(column, facet), (facets.velocity_look, facets.velocity_up), strict=True),
        (there.strain(column, facet), strain),
    )
    for found, right in pairs:  # two roundings of float32
        assert right is not None
        np.testing.assert_allclose(np.array(found), right.ravel(), rtol=0.0, atol=2.4e-7 * np.abs(right).max())


def test_rays_whose_answers_stay_there_light_the_same_facets() -> None:
    made = simulator("two scales")
    mesh, trace = made.mesh(0), made._trace
    assert isinstance(trace, RayTracer)
    there = MeshOnDevice.of(mesh)
    moved.forget()
    light = trace.on_device(mesh.levelled, there.levelled)
    assert moved.down_bytes == 0
    np.testing.assert_array_equal(light.fetch_lit(), trace(mesh.levelled).lit)


def test_how_fast_facets_are_is_known_from_two_numbers() -> None:
    """And so the nodes are the processor's: a node more would be another sum."""
    made = simulator("two scales")
    mesh = made.mesh(0)
    lit, returns, _ = made.light(0, mesh=mesh)
    there = MeshOnDevice.of(mesh)
    found = returns_on_device(made.surface, mesh.levelled.facets, there.levelled, LightOnDevice.of(lit))
    moved.forget()
    fastest, right = found.fastest(there), Fastest.of(mesh.facets, returns.motion)
    assert moved.down_bytes == 8
    assert right.breakers is not None
    assert fastest == pytest.approx(right, rel=1e-6)


def test_from_ray_to_map_only_cells_come_back() -> None:
    """Up: the vertices, once, and what columns have: the modes of their speckle and where the beam looks at each node.
    Down: two speeds, and the looks' cells, of the truth and of products of voltages. Of a turn with objects, whose
    voltages are the host's, the sums (component, path, gate, node) come down."""
    made = simulator("two scales")
    mesh, fired, trace = made.mesh(0), pulses(made.radar, 0, made.mast), made._trace
    assert isinstance(trace, RayTracer)
    surface, facets = made.surface, mesh.levelled.facets
    count, lines = facets.height.size, mesh.elevation.size

    moved.forget()
    there = MeshOnDevice.of(mesh)
    assert moved.up_bytes == 24 * lines  # 12 a facet

    moved.forget()
    light = trace.on_device(mesh.levelled, there.levelled)
    # The tree's corners (12 bytes) and triangles (12), with the walls at the border, a ray's number, and what a column
    # has: its look and its antennas' places.
    border = 3 * 12 * 2 * (2 * mesh.grid.ground_range.size + mesh.grid.columns)
    assert moved.up_bytes <= 12 * lines + 12 * count + 4 * light.rays + border + 100 * mesh.grid.columns
    assert moved.down_bytes == 0

    moved.forget()
    returns = returns_on_device(surface, facets, there.levelled, light)
    tables = moved.up_bytes
    assert moved.down_bytes == 0
    assert (
        tables <= 2**19
    )  # Bragg's, and what the range or the look alone decides: of a sector 8, of a turn 0.4 a facet

    moved.forget()
    chain = made.radar, fired, made.scene.seed, made.scene.scattering.decorrelation_time_s
    heard = turn_echoes_on_device(mesh.facets, there, light, returns, *chain)
    assert moved.down_bytes == 8  # two speeds
    up = moved.up_bytes
    moved.forget()
    echoes = echo_dataset(made.radar, [fired], [heard])
    found = retrieve_one(echoes)["polar"].to_dataset()
    size, windows = found["height"].size, 10  # at most, as the estimator and its error bars take them
    means = (4 + windows) * 16 * size  # of one way, and three lags
    # Which pulses were heard; powers, by which a tenth of the gates is chosen, and those of these gates.
    count, cells = fired.number.size, found.sizes["range"]
    assert moved.down_bytes <= means + 2 * count + 4 * min(count, 1000) * cells + 4 * count * (cells // 10)
    # Three numbers of a product, of both receivers; what turns the phases of windows, and the dwells that they are of.
    assert moved.up_bytes <= 12 * 7 * count + (8 * windows + 34) * size + 2**13
    moved.forget()
    objects = np.zeros(heard.voltage.shape, dtype=np.complex64)
    again = turn_echoes_on_device(mesh.facets, there, light, returns, *chain, objects=objects)
    down = moved.down_bytes
    assert relative_rms(np.asarray(heard.voltage), again.voltage) <= 1e-6
    hearing = Hearing.of(mesh.facets, *chain, returns.motion, fastest=returns.fastest(there))
    paths, gates = len(antenna_array(made.radar).paths), hearing.tabulated.samples.range.size
    assert mesh.grid.columns <= COLUMNS_ON_DEVICE  # one batch, whose windows reach beyond the turn's nodes
    passing = mesh.grid.column_pose.time
    first = np.ceil((passing - hearing.reach_s - hearing.nodes.time[0]) / hearing.nodes.spacing_s)
    nodes = hearing.window + int(np.ptp(first))
    assert down == 8 * paths * gates * nodes + 8  # and two speeds
    per_node = 8 * hearing.speckle.modes(slice(0, 1), np.zeros(1))[0].shape[1] * 2 + 24
    tables = 4 * (hearing.beams.tables.size + hearing.tabulated.response.size + 2 * 20_001)
    assert up <= mesh.grid.columns * (per_node * hearing.window + 200) + tables + 2**16

    moved.forget()
    truth = polar_truth_on_device(
        FacetsOnDevice(mesh.facets, there, light, returns), made.radar, made.scene.retrieval, 0
    )
    assert moved.down_bytes == 4 * (QUANTITIES + 2) * truth["height"].size + 8  # and the lowest and the highest water
    assert moved.up_bytes <= 2**18
