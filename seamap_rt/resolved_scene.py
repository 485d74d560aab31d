"""A scene turned into what it stands for, once, at the start: the sea, and the radar on its boat.

Subpackages take these as arguments, so that no settings are resolved twice.
"""

from __future__ import annotations

from .errors import InputError
from .radar.array import with_scanned_sector
from .radar.installation import Installation
from .radar.platform import BoatMotion, Sensors, boat_motion
from .random_streams import Stream, branch
from .scattering.breaking import memory_rate
from .scene import Scene
from .sea import Sea, realize
from .sea.systems import file_versions

_LAST_BEAM_S = 0.1  # for which the last pulses hear what the beam has passed


def check_record(scene: Scene, sea: Sea) -> None:
    """Raise InputError for a recorded sea that ends before the run and its last beam, or has too wide a gap before."""
    turn = scene.turn_duration_s
    if scene.turns * turn + _LAST_BEAM_S > sea.ends_s:
        most = int((sea.ends_s - _LAST_BEAM_S) / turn)
        last = f"lower turns to {most}, or give a longer one" if most > 0 else "give a longer one"
        last += ", or an earlier sea.start_s" if scene.sea.start_s is not None else ""
        raise InputError(
            f"turns = {scene.turns}: last {scene.turns * turn:.4g} s, and {_LAST_BEAM_S:g} s more are heard; the "
            f"record of sea.file goes on for {sea.ends_s:.4g} s; {last}"
        )
    if sea.patch is not None:  # of cameras, which do not see all
        from .sea.recorded import check_gaps

        check_gaps(sea.trains, scene.turns * turn + _LAST_BEAM_S)


def sea_key(scene: Scene) -> tuple[object, ...]:
    """What a run's sea is drawn from: runs of equal keys have the same sea."""
    return scene.sea, scene.seed, scene.tracing.height_error_m, _memory_rate(scene), file_versions(scene.sea)


def _memory_rate(scene: Scene) -> float | None:
    return memory_rate(scene.scattering, scene.radar.frequency_hz)


def run_sea(scene: Scene) -> Sea:
    """The sea of a run, drawn from its own branch of the scene's seed. Raises InputError for one that cannot be."""
    try:
        return realize(scene.sea, branch(scene.seed, Stream.SEA), scene.tracing.height_error_m, _memory_rate(scene))
    except ValueError as error:
        raise InputError(f"sea: {error}") from None


def installation_of(scene: Scene, sea: Sea | None = None, motion: BoatMotion | None = None) -> Installation:
    """The radar on its boat. sea: the run's; made here if the boat follows it. motion: the boat's, in place of what
    `scene.platform` says of it.

    Raises InputError if the boat's motion is not known for as long as the scene lasts.
    """
    if motion is None and sea is None and scene.platform.motion == "wave_following":
        sea = run_sea(scene)
    platform, motion = scene.platform, motion or boat_motion(scene.platform, sea)
    return Installation(
        with_scanned_sector(scene.radar), platform, motion, Sensors(platform.sensors, motion, scene.seed)
    )
