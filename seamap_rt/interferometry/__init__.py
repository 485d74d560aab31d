"""Echoes → phase, height and slope, on the ground. Reads echoes and the radar's own description, nothing else."""

from ..wavefield.sea_state import sea_state
from .input.recorded import echoes_from_recording, open_recording
from .retrieval import open_echoes, retrieve, retrieve_one

__all__ = ["echoes_from_recording", "open_echoes", "open_recording", "retrieve", "retrieve_one", "sea_state"]
