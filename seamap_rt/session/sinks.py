"""Sinks of finished turns: files that grow with them, and memory."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import Any, Protocol, Self

import numpy as np
import xarray as xr

from ..gauges import gauge_series
from ..io.appendable import AppendableNetCDF
from ..radar.scan import turn_duration
from ..simulation import Simulator
from .driver import FinishedTurn


class _Appendable(Protocol):
    """A file that grows by whole turns, or a stand-in for one."""

    def append(self, data: Any, /) -> None: ...

    def take_back(self) -> None: ...

    def __enter__(self) -> Any: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None, /
    ) -> bool | None: ...


class FileSink:
    """Appends what `select` picks of each turn to a file, such as an EchoStore or an AppendableNetCDF."""

    def __init__(self, file: _Appendable, select: Callable[[FinishedTurn], Any], stage: str = "write") -> None:
        self.stage = stage
        self._file, self._select = file, select

    def turn(self, turn: FinishedTurn) -> None:
        self._file.append(self._select(turn))

    def take_back(self) -> None:
        self._file.take_back()

    def __enter__(self) -> Self:
        self._file.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool | None:
        return self._file.__exit__(kind, error, trace)


def gauge_sink(file: AppendableNetCDF, simulator: Simulator) -> FileSink:
    """Appends what the scene's gauges read in each turn (schema `gauges`). The turns must hold maps."""
    scene, period = simulator.scene, turn_duration(simulator.radar)

    def read(turn: FinishedTurn) -> xr.Dataset:
        assert turn.maps is not None
        middle = simulator.sensed.pose(np.array([(turn.number + 0.5) * period])).origin[0, :2]
        return gauge_series(turn.maps, simulator.sea, scene.gauges, turn.truth, turn_s=period, antenna_m=middle)

    return FileSink(file, read, stage="truth")


class Memory:
    """Keeps the echoes and the truth of all turns in memory."""

    stage = "write"

    def __init__(self) -> None:
        self._echoes: list[xr.Dataset] = []
        self._truth: list[xr.DataTree] = []

    def turn(self, turn: FinishedTurn) -> None:
        self._echoes.append(turn.echoes)
        self._truth.append(turn.truth)

    def take_back(self) -> None:
        self._echoes.pop()
        self._truth.pop()

    @property
    def echoes(self) -> xr.Dataset:
        """The echoes of all turns (schema `echoes`)."""
        joined = xr.concat(self._echoes, "pulse", data_vars="minimal", coords="minimal", compat="override")
        joined.attrs = self._echoes[-1].attrs
        return joined

    @property
    def truth(self) -> xr.DataTree:
        """The truth of all turns: groups `polar` and `ground`."""
        groups = ("polar", "ground")
        return xr.DataTree.from_dict(
            {f"/{g}": xr.concat([t[g].to_dataset() for t in self._truth], "turn", data_vars="all") for g in groups}
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass
