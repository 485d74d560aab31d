"""One run: `iterate` yields finished turns, and files, gauges, memory and other consumers are its sinks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_attributes

if TYPE_CHECKING:
    from .driver import FinishedTurn, Sink, TurnFigures, deliver, iterate
    from .simulating import FileSink, Memory, Simulation, simulate
    from .whole_run import RunResult, Stream, run

__all__ = [
    "FileSink",
    "FinishedTurn",
    "Memory",
    "RunResult",
    "Simulation",
    "Sink",
    "Stream",
    "TurnFigures",
    "deliver",
    "iterate",
    "run",
    "simulate",
]

__getattr__ = lazy_attributes(
    __name__,
    {
        "driver": "FinishedTurn Sink TurnFigures deliver iterate",
        "simulating": "FileSink Memory Simulation simulate",
        "whole_run": "RunResult Stream run",
    },
)
