"""A scene turned into what it stands for, once, at the start: the radar as it looks, the sea, and the mast on its boat.

Subpackages take these as arguments, so that no settings are resolved twice.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from .errors import InputError
from .radar.array import as_it_looks
from .radar.mast import Mast
from .radar.platform import boat_motion
from .radar.sensors import Sensors
from .random_streams import Stream, branch
from .scene import Scene
from .sea import Sea, realize
from .settings import RadarSettings


class Masts(NamedTuple):
    """The same mast twice: where it is, and where the boat's sensors say it is. `true.radar` is the radar as it looks:
    with the sector that its beam truly scans."""

    true: Mast
    sensed: Mast


@dataclass(frozen=True)
class ResolvedScene:
    """What all turns of a run share.

    radar: as it looks. sea: the run's own. mast: where the antennas are. sensed: where the boat's sensors say they are.
    """

    scene: Scene
    radar: RadarSettings
    sea: Sea
    mast: Mast
    sensed: Mast


def resolve(scene: Scene) -> ResolvedScene:
    """The run's sea, drawn from the scene's seed, and the mast that rides on it.

    Raises InputError for a sea that cannot be drawn, or a boat whose motion is not known for the whole of the scene.
    """
    sea = run_sea(scene)
    true, sensed = masts(scene, sea)
    return ResolvedScene(scene, true.radar, sea, true, sensed)


def run_sea(scene: Scene) -> Sea:
    """The sea of a run, drawn from its own branch of the scene's seed. Raises InputError for one that cannot be."""
    try:
        return realize(scene.sea, branch(scene.seed, Stream.SEA))
    except ValueError as error:
        raise InputError(f"sea: {error}") from None


def masts(scene: Scene, sea: Sea | None = None) -> Masts:
    """The mast as it moves, and as the sensors have it. sea: the run's; made here if the boat follows it.

    Raises InputError if the boat's motion is not known for as long as the scene lasts.
    """
    if scene.platform.motion == "wave_following" and sea is None:
        sea = run_sea(scene)
    motion = boat_motion(scene.platform, sea)
    true = Mast(as_it_looks(scene.radar), scene.platform, motion)
    return Masts(true, true.sensed(Sensors(scene.platform.sensors, motion, scene.seed)))
