"""The page of a shadowing study: how far half of the sea is seen from each height, then the figures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from ..report.page_elements import Cell, answer_page
from .enough import ASKED_M, seeds_for
from .paired import FEWEST_SEEDS

_SHARES = (
    "Share of the sea's horizontal area that both antennas see, along the waves, at 45° and across them, with the "
    "curves of Smith and Wagner for the slopes that the mesh carries. Below: the range beyond which half is shadowed, "
    "by look."
)
_SEEN = "Mean height of what is seen (crests, at grazing angles), and lengths of shadows and of visible stretches."


def shadowing_page(data: xr.Dataset, lines: Sequence[str], shares: bytes, seen: bytes, seeds: int, scene: str) -> str:
    """lines: what the study says; shares, seen: its figures, as PNG; scene: as TOML."""
    return answer_page(
        title="Shadowing",
        said=[line[0].upper() + line[1:] for line in lines],
        notes=[_seeds(data, seeds)],
        figures=[("Visible share against range", shares, _SHARES), ("What it is that is seen", seen, _SEEN)],
        table_title="Half ranges",
        table_note="The range beyond which half of the sea is shadowed, with its 95 % band.",
        files=["shadowing.csv", "shadowing.nc"],
        heads=["Antenna height (m)", "Look", "Half range (m)", "from", "to", "Smith 1967 (m)"],
        rows=_rows(data),
        small_print=[("Antenna height: mean height of the phase centres over mean sea level.", "radar.height_m")],
        scene=scene,
    )


def _rows(data: xr.Dataset) -> list[list[Cell]]:
    names = ("look_r50", "look_r50_low", "look_r50_high", "look_r50_smith")
    result = []
    for height in data["height"].values:
        for look in data["look"].values:
            values = [float(data[name].sel(height=height, look=look)) for name in names]
            numbers = [Cell(f"{each:.0f}", each) if np.isfinite(each) else Cell("—") for each in values]
            result.append([Cell(f"{height:g}", float(height)), Cell(str(look)), *numbers])
    return result


def _seeds(data: xr.Dataset, seeds: int) -> str:
    if seeds < FEWEST_SEEDS:
        return f"{'One seed' if seeds == 1 else f'{seeds} seeds'}: no bands. Give --seeds 3 or more."
    half = (data["look_r50_high"] - data["look_r50"]).values
    if not np.isfinite(half).any():
        return f"{seeds} seeds."
    worst = float(np.nanmax(half))
    words = f"{seeds} seeds: bands of half ranges of ± {worst:.0f} m at most. "
    return words + (f"{seeds_for(seeds, worst)}." if worst > ASKED_M else "")
