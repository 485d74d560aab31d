"""The memory that a scene's run takes."""

from __future__ import annotations

from ..compute.machine import A_RUN
from ..radar.array import antenna_array
from ..radar.checks import pulses_of_a_turn
from ..radar.grid import BYTES_PER_VOLTAGE
from ..sea.realisation import resolution
from .checks.sea import BYTES_PER_TRIANGLE
from .model import Scene

_BYTES_A_POINT = 100.0  # of the sea's grid


def run_bytes(scene: Scene) -> float:
    """Memory of a run, about."""
    radar = scene.radar
    gates = (radar.range_m[1] - radar.range_m[0]) / radar.range_sampling_m + 1.0
    echoes = BYTES_PER_VOLTAGE * len(antenna_array(radar).receivers) * pulses_of_a_turn(radar) * gates
    grid = (scene.sea.extent_m / resolution(scene.sea)) ** 2 if scene.sea.waves else 0.0
    return A_RUN.memory + BYTES_PER_TRIANGLE * scene.detail.facets + echoes + _BYTES_A_POINT * grid
