"""Loops over whole scenes: how far a radar sees (shadowing), and what its keys are worth (trade)."""

from .shadowing import shadowing, shadowing_by_cutoff
from .trade import trade

__all__ = ["shadowing", "shadowing_by_cutoff", "trade"]
