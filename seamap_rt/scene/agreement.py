"""The checks across sections, in their order, and what each relies on: all that is wrong is reported at once; and the
memory that a run takes.

Each takes the sections that it compares and gives a line for each problem, or raises ValueError with one: key, value,
limit, reason, remedy. A limit that a line names passes when it is typed in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, NamedTuple

from ..compute.machine import A_RUN
from ..errors import InputError, ResourceError
from ..radar import checks as radars
from ..radar.array import antenna_array
from ..radar.grid import BYTES_PER_VOLTAGE
from ..sea.realisation import resolution
from . import radar_checks, water_checks

if TYPE_CHECKING:
    from .model import Scene


class Check(NamedTuple):
    """made: gives the lines of what is wrong, or raises ValueError with them. relies_on: names of checks without which
    it has no meaning."""

    name: str
    made: Callable[[Scene], Iterable[str] | None]
    relies_on: tuple[str, ...] = ()


_SIZE = ("antennas", "overlap", "waveform", "height", "patch", "pulses", "window", "echo memory", "ground map")
CHECKS = (
    Check("steepness", lambda s: water_checks.check_steepness(s.sea)),
    Check("record", lambda s: water_checks.check_record(s.sea, s.platform)),
    Check("apertures", lambda s: radar_checks.check_apertures(s.radar)),
    Check("antennas", lambda s: radars.check_antennas(s.radar), ("apertures",)),
    Check("mode", lambda s: radars.check_mode(s.radar), ("antennas",)),
    Check("overlap", lambda s: radars.check_overlap(s.radar)),
    Check("waveform", lambda s: radars.check_waveform(s.radar), ("overlap",)),
    Check("receiver", lambda s: radars.check_receiver(s.radar), ("waveform",)),
    Check("transmitter", lambda s: radars.check_transmitter(s.radar), ("waveform",)),
    Check("pulses compared", lambda s: radar_checks.check_pulses_compare(s.radar, s.retrieval)),
    Check("receivers", lambda s: radar_checks.check_receivers(s.radar, s.retrieval), ("antennas",)),
    Check("motion", lambda s: radar_checks.check_motion(s.platform, s.radar, s.turns), ("antennas",)),
    Check("meshes", lambda s: radar_checks.check_meshes(s.objects)),
    Check("height", lambda s: radar_checks.check_height(s.radar)),
    Check("above water", lambda s: radar_checks.check_above_water(s.radar), ("antennas",)),
    Check("patch", lambda s: radar_checks.check_patch(s.radar, s.sea), ("waveform", "receiver")),
    Check("record's start", lambda s: radar_checks.check_start(s.sea)),
    Check("gates", lambda s: radar_checks.check_gates(s.radar, s.retrieval), ("waveform", "receiver")),
    Check("pulses", lambda s: radar_checks.check_pulses(s.radar, s.retrieval), ("antennas", "mode")),
    Check("window", lambda s: radar_checks.check_window(s.radar, s.retrieval), ("height", "gates")),
    Check("echo memory", lambda s: radar_checks.check_echo_memory(s.radar), ("antennas", "window")),
    Check("ground map", lambda s: radar_checks.check_ground_map(s.radar, s.retrieval)),
    Check("permittivity", lambda s: water_checks.check_permittivity(s.scattering, s.radar)),
    Check("mean model", lambda s: water_checks.check_mean_model(s.scattering, s.radar), ("height",)),
    Check("wave on mesh", lambda s: water_checks.check_waves(s.detail, s.sea), _SIZE),
    Check("mesh memory", lambda s: water_checks.check_memory(s.detail, s.radar), _SIZE),
    Check("gauges", lambda s: water_checks.check_names_and_rates(s.gauges)),
    Check("gauges known", lambda s: water_checks.check_known(s.gauges, s.sea), ("patch",)),
    Check(
        "gauges' places",
        lambda s: water_checks.check_positions(s.gauges, s.radar, s.platform, s.retrieval),
        ("height",),
    ),
)


def disagreements(scene: Scene, whole: bool = True) -> list[str]:
    """One line for each fault between the sections of a scene. whole: False where keys are missing that its class has;
    then a check that asks for one cannot be made, nor those that rely on it."""
    problems: list[str] = []
    failed: set[str] = set()
    for check in CHECKS:
        if not failed.isdisjoint(check.relies_on):
            failed.add(check.name)
            continue
        try:
            wrong = tuple(check.made(scene) or ())
        except ResourceError:
            raise
        except ValueError as refusal:
            wrong = refusal.problems if isinstance(refusal, InputError) else (str(refusal),)
        except Exception:
            if whole and not failed:
                raise  # nothing was wrong that the check could have met
            wrong = ()
            failed.add(check.name)
        if wrong:
            failed.add(check.name)
            problems += wrong
    return problems


_BYTES_A_POINT = 100.0  # of the sea's grid


def run_bytes(scene: Scene) -> float:
    """Memory of a run, about."""
    (near, far), receivers = scene.radar.range_m, len(antenna_array(scene.radar).receivers)
    gates = (far - near) / scene.radar.range_sampling_m + 1.0
    echoes = BYTES_PER_VOLTAGE * receivers * radars.pulses_of_a_turn(scene.radar) * gates
    grid = (scene.sea.extent_m / resolution(scene.sea)) ** 2 if scene.sea.waves else 0.0
    return A_RUN.memory + water_checks.BYTES_PER_TRIANGLE * scene.detail.facets + echoes + _BYTES_A_POINT * grid
