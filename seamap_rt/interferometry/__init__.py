"""Echoes → phase, height and slope, on the ground. Reads echoes and the radar's own description, nothing else."""

from .retrieval import open_echoes, retrieve, retrieve_one

__all__ = ["open_echoes", "retrieve", "retrieve_one"]
