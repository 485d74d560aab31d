"""What a point of a sweep leaves for the next one in the same process: its sea and its traced scenes.

Drawing a sea and transforming it to the times of a turn takes longer than to look at it. Where the radar's height or
power varies over one sea of one seed, it is drawn once, and evaluated once where the same points are asked for again.
Results do not depend on it.
"""

from __future__ import annotations

import gc
from threading import Lock, Timer
from typing import TYPE_CHECKING

from ..scene import Scene

if TYPE_CHECKING:
    from ..simulation import Simulator

_REMEMBERED_BYTES = 100e6  # of a sea's values: a turn of `choppy_sea` and its calibration are 50
IDLE_S = 60.0  # after which a process that is given no other point frees what it has kept


class Kept:
    """The last point's simulator, from which the next one takes over what is alike."""

    def __init__(self) -> None:
        self._before: Simulator | None = None
        self._lock, self._timer = Lock(), Timer(IDLE_S, self.forget)  # not started

    def simulator(self, scene: Scene) -> Simulator:
        """The scene's own. It is kept once it is `finished`, and so never one that failed."""
        from ..simulation import Simulator  # takes half a second

        before = self._taken()
        if before is None:
            return self._remembering(Simulator(scene))
        sea, rays = before.sea if before.has_sea_of(scene) else None, before.ray_scenes
        if sea is None:
            del before
            gc.collect()  # before the next sea takes memory: a sea refers to itself
            return self._remembering(Simulator(scene, None, rays))
        return Simulator(scene, sea, rays)

    @staticmethod
    def _remembering(simulator: Simulator) -> Simulator:
        simulator.sea.remember(_REMEMBERED_BYTES)
        return simulator

    def finished(self, simulator: Simulator) -> None:
        """Keep it for the next point, if that comes soon."""
        with self._lock:
            self._before, self._timer = simulator, Timer(IDLE_S, self.forget)
            self._timer.daemon = True
            self._timer.start()

    def forget(self) -> None:
        """Free it now."""
        if self._taken() is not None:
            gc.collect()

    def _taken(self) -> Simulator | None:
        with self._lock:
            self._timer.cancel()
            before, self._before = self._before, None
        return before
