"""Files of the boat's motion and of the objects' meshes."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from ...errors import refuse
from ...radar.array import antenna_array
from ...radar.platform import boat_motion
from ...radar.scan import BEAMS_BEYOND, turn_duration
from ...settings import ObjectSettings, PlatformSettings, RadarSettings


def check_motion(platform: PlatformSettings, radar: RadarSettings, turns: int) -> None:
    """A recorded motion can be read, and is as long as the run.

    The run takes in what a turn hears before and after itself, and the earlier motion that late sensors report.
    """
    if platform.motion != "file":
        return
    sensors, beam = platform.sensors, antenna_array(radar).beam_deg
    beside = min(360.0, (BEAMS_BEYOND + 1.0) * beam + 5.0) / (6.0 * radar.rotation_rpm)
    reading = 0.0 if math.isinf(sensors.rate_hz) else 1.0 / sensors.rate_hz
    early, late = min(-beside, -sensors.latency_s - reading), max(beside, reading)
    boat_motion(platform)([0.0, early, turns * turn_duration(radar) + late])


def check_meshes(objects: Sequence[ObjectSettings]) -> None:
    """The objects' mesh files are there."""
    refuse(
        f"objects.{number}.mesh = '{thing.mesh}': no such file; give the path of a mesh"
        for number, thing in enumerate(objects)
        if not os.path.isfile(thing.mesh)  # no name is too long for it
    )
