"""A large turn worked on in parts: the same bits, and no more memory than the turn itself and one part take."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

from seamap_rt.radar.waveform import gates
from seamap_rt.scene import load_scene
from seamap_rt.simulation import Simulator
from seamap_rt.truth import polar_truth

SCENES = {
    "rays": ("choppy_sea", {"radar.sector_deg": [250.0, 270.0]}),
    "horizon, spikes, patches and small waves' shadows": (
        "choppy_sea",
        {
            "radar.sector_deg": [250.0, 270.0],
            "tracing.tracer": "horizon",
            "tracing.unresolved_shadowing": "smith",
            "scattering.texture": True,
        },
    ),
    "a leaning boat, light over edges": (
        "rough_ride",
        {"radar.sector_deg": [250.0, 265.0]},
    ),
    "objects": ("harbour", {"radar.sector_deg": [20.0, 50.0], "tracing.tracer": "horizon"}),
    "water alone moves": (
        "choppy_sea",
        {"radar.sector_deg": [250.0, 260.0], "tracing.tracer": "horizon", "scattering.doppler": "orbital"},
    ),
}


def in_parts(monkeypatch: pytest.MonkeyPatch, facets: int) -> None:
    """From here on every turn of more than so many facets is worked on so many at a time."""
    for name in ("MOST_FACETS", "PART_FACETS"):
        monkeypatch.setattr(f"seamap_rt.mesh.grid.{name}", facets)


def variables(turn: Any) -> dict[str, xr.Variable]:
    """Everything that a turn gives."""
    found = {f"echoes {name}": each for name, each in turn.echoes.variables.items()}
    for group in turn.truth.groups:
        found |= {f"{group} {name}": each for name, each in turn.truth[group].to_dataset().variables.items()}
    return found


@pytest.mark.parametrize("kind", SCENES)
def test_parts_have_the_whole_turn_s_bits(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    simulator = Simulator(load_scene(*SCENES[kind]))
    whole = simulator.turn(0)
    in_parts(monkeypatch, whole.facets // 7)
    parted = simulator.turn(0)
    assert len(simulator.mesh(0).grid.parts) >= 7
    assert (parted.facets, parted.rays) == (whole.facets, whole.rays)
    expected, got = variables(whole), variables(parted)
    assert expected.keys() == got.keys()
    for name, each in expected.items():
        np.testing.assert_array_equal(got[name].values, each.values, err_msg=name)


def test_a_part_is_levelled_as_the_whole_is() -> None:
    """Within the turn and at both its ends."""
    mesh = Simulator(load_scene("choppy_sea", {"radar.sector_deg": [250.0, 255.0]})).mesh(0)
    columns = mesh.grid.columns
    for part in (slice(0, 3), slice(4, 9), slice(columns - 2, columns), slice(0, columns)):
        alone, within = mesh.levelled_part(part), mesh.levelled.part(part)
        np.testing.assert_array_equal(alone.elevation, within.elevation)
        np.testing.assert_array_equal(alone.facets.slope_look, mesh.levelled.facets.slope_look[part])
        np.testing.assert_array_equal(alone.grid.column_number, mesh.grid.column_number[part])


PARTS = 20
STRAIGHT = {"tracing.diffraction": "none", "scattering.sea_spikes": False}
WHILE_WORKED_ON = 80.0  # bytes for each facet of a part: planes, rays, cross-sections and what they are made of


def fine(tracer: str) -> Simulator:
    """Of a scene of 0.6 million facets, with all that is made and compiled once."""
    mesh = {"tracing.facet_m": 0.4, "tracing.columns_per_beam": 8}
    simulator = Simulator(
        load_scene("choppy_sea", {"radar.sector_deg": [240.0, 300.0], "tracing.tracer": tracer, **mesh, **STRAIGHT})
    )
    simulator.turn(0)  # a compiler takes memory too
    return simulator


def memory(work: Callable[[], object]) -> tuple[float, float]:
    """Bytes that work has allocated when it is done, and at most."""
    tracemalloc.start()
    try:
        kept = work()
        found = tracemalloc.get_traced_memory()
        del kept
    finally:
        tracemalloc.stop()
    return found


def test_a_mesh_holds_its_own_fields_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of each vertex, two facets', height (8 bytes), velocity and relaxed shift (8 each); of each facet height (8),
    slopes and velocity (8 each)."""
    simulator = fine("horizon")
    facets = simulator.mesh(0).facets.height.size
    in_parts(monkeypatch, facets // PARTS)
    kept, _ = memory(lambda: simulator.mesh(0))
    assert kept / facets < 12.0 + 24.0 + 1.0  # a hundredth of the vertices are the last line's and rung's; poses


@pytest.mark.parametrize("tracer", ["horizon", "facets"])
def test_a_turn_in_parts_takes_the_memory_of_two_parts_beside_its_own(
    tracer: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Light and returns keep two antennas' light (a byte each), cross-section and breakers' share (4 each); truth keeps
    ten sums of 8 bytes for each column and gate. A part is still there when the next is made."""
    simulator = fine(tracer)
    mesh = simulator.mesh(0)
    count = mesh.facets.height.size
    _, whole = memory(lambda: simulator.light(0, mesh=mesh))
    in_parts(monkeypatch, count // PARTS)
    mesh = simulator.mesh(0)
    _, most = memory(lambda: simulator.light(0, mesh=mesh))
    assert most / count < 10.0 + 2.0 * WHILE_WORKED_ON / PARTS
    assert most < 0.55 * whole  # as 18 bytes to more than 33 of a levelled mesh, its light and what it returns
    facets, returns, _ = simulator.light(0, mesh=mesh)
    retrieval = simulator.scene.retrieval
    _, most = memory(lambda: polar_truth(facets, returns.rcs, simulator.installation, retrieval, 0))
    cells = 80.0 * mesh.grid.columns * gates(simulator.installation.radar).size
    assert most < cells + WHILE_WORKED_ON * count / PARTS
