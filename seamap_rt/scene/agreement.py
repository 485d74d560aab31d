"""The checks across sections, in their order, and what each relies on: all that is wrong is told in one go."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import InputError, ResourceError
from ..io.validation import Key, without
from ..radar import checks as radars
from .checks import gauges, radar, ranges, scattering, sea

if TYPE_CHECKING:
    from .model import Scene


class Check(NamedTuple):
    """made: raises ValueError, a line a problem. relies_on: names of checks without which it has no meaning."""

    name: str
    made: Callable[[Scene], object]
    relies_on: tuple[str, ...] = ()


_SIZE = ("antennas", "overlap", "waveform", "height", "patch", "pulses", "window", "echo memory", "ground map")
CHECKS = (
    Check("steepness", lambda s: sea.check_steepness(s.sea)),
    Check("record", lambda s: sea.check_record(s.sea, s.platform)),
    Check("apertures", lambda s: radar.check_apertures(s.radar)),
    Check("antennas", lambda s: radars.check_antennas(s.radar), ("apertures",)),
    Check("mode", lambda s: radars.check_mode(s.radar), ("antennas",)),
    Check("overlap", lambda s: radars.check_overlap(s.radar)),
    Check("waveform", lambda s: radars.check_waveform(s.radar), ("overlap",)),
    Check("receiver", lambda s: radars.check_receiver(s.radar), ("waveform",)),
    Check("transmitter", lambda s: radars.check_transmitter(s.radar), ("waveform",)),
    Check("pulses compared", lambda s: radar.check_pulses_compare(s.radar, s.retrieval)),
    Check("receivers", lambda s: radar.check_receivers(s.radar, s.retrieval), ("antennas",)),
    Check("motion", lambda s: radar.check_motion(s.platform, s.radar, s.turns), ("antennas",)),
    Check("meshes", lambda s: radar.check_meshes(s.objects)),
    Check("height", lambda s: ranges.check_height(s.radar)),
    Check("above water", lambda s: radar.check_above_water(s.radar), ("antennas",)),
    Check("patch", lambda s: ranges.check_patch(s.radar, s.sea), ("waveform", "receiver")),
    Check("record's start", lambda s: ranges.check_start(s.sea)),
    Check("gates", lambda s: ranges.check_gates(s.radar, s.retrieval), ("waveform", "receiver")),
    Check("pulses", lambda s: radar.check_pulses(s.radar, s.retrieval), ("antennas", "mode")),
    Check("window", lambda s: ranges.check_window(s.radar, s.retrieval), ("height", "gates")),
    Check("echo memory", lambda s: radar.check_echo_memory(s.radar), ("antennas", "window")),
    Check("ground map", lambda s: ranges.check_ground_map(s.radar, s.retrieval)),
    Check("permittivity", lambda s: scattering.check_permittivity(s.scattering, s.radar)),
    Check("mean model", lambda s: scattering.check_mean_model(s.scattering, s.radar), ("height",)),
    Check("wave on mesh", lambda s: sea.check_waves(s.detail, s.sea), _SIZE),
    Check("mesh memory", lambda s: sea.check_memory(s.detail, s.radar), _SIZE),
    Check("gauges", lambda s: gauges.check_names_and_rates(s.gauges)),
    Check("gauges known", lambda s: gauges.check_known(s.gauges, s.sea), ("patch",)),
    Check("gauges' places", lambda s: gauges.check_positions(s.gauges, s.radar, s.platform, s.retrieval), ("height",)),
)


def disagreements(scene: Scene, whole: bool = True) -> list[str]:
    """What is wrong between the sections of a scene, a line each. whole: False where keys are missing that it has by
    its class; then a check that asks for one cannot be made, nor those that rely on it."""
    told: list[str] = []
    failed: set[str] = set()
    for check in CHECKS:
        if not failed.isdisjoint(check.relies_on):
            failed.add(check.name)
            continue
        try:
            check.made(scene)
        except ResourceError:
            raise
        except ValueError as refusal:
            failed.add(check.name)
            told += refusal.problems if isinstance(refusal, InputError) else (str(refusal),)
        except Exception:
            if whole and not failed:
                raise  # nothing was wrong that the check could have met
            failed.add(check.name)
    return told


def disagreements_of_the_rest(scene: type[Scene], tree: Mapping[str, Any], wrong: frozenset[Key]) -> list[str]:
    """The same of the tree of a scene with wrong keys, as far as it can be told without them."""
    return disagreements(without(scene, tree, wrong), whole=False)
