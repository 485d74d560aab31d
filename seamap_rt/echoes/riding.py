"""The run's own sea, and the mast that rides on it: where it is, and where its sensors say it is."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..radar.array import as_it_looks
from ..radar.mast import Mast
from ..radar.platform import boat_motion
from ..radar.sensors import Sensors
from ..scene import Scene
from ..sea import Sea, realize

_SEA_STAGE = 1  # of the scene's random source; speckle is 2, noise 3, the sensors 7, objects 8


class Masts(NamedTuple):
    """The same mast twice."""

    true: Mast
    sensed: Mast


def run_sea(scene: Scene) -> Sea:
    """The sea of a run, drawn from its own branch of the scene's seed. Raises InputError for one that cannot be."""
    try:
        return realize(scene.sea, np.random.SeedSequence(scene.seed, spawn_key=(_SEA_STAGE,)))
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
