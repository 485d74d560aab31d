"""One run: `iterate` yields finished turns, and files, gauges, memory and other consumers are its sinks."""

from .driver import FinishedTurn, Sink, TurnFigures, deliver, iterate
from .simulating import Simulation, simulate
from .sinks import FileSink, Memory
from .whole_run import RunResult, run

__all__ = [
    "FileSink",
    "FinishedTurn",
    "Memory",
    "RunResult",
    "Simulation",
    "Sink",
    "TurnFigures",
    "deliver",
    "iterate",
    "run",
    "simulate",
]
