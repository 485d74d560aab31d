"""Section [prediction]: how a wave field is fitted to the maps, and how far ahead it is asked."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Ge, Le

from .limits import Meaning
from .section import Section


class PredictionSettings(Section):
    """From maps to a forecast."""

    turns: Annotated[
        int,
        Ge(1),
        Le(40),
        Meaning("How many turns' maps a wave field rests on.", unit="1", reason="turns that the fit holds"),
    ] = 10
    lead_s: Annotated[
        float,
        Ge(0.0),
        Le(60.0),
        Meaning("How far ahead forecasts are made.", unit="s", reason="beyond it the sea is not predictable"),
    ] = 30.0
    sharpness: Annotated[
        float | None,
        Ge(0.0),
        Le(1.0),
        Meaning(
            "How far the water is moved by its own waves: 0 for waves of Airy, 1 for first-order Lagrangian ones.",
            unit="1",
            reason="from linear to first-order Lagrangian waves",
            left_out="as the maps show it",
        ),
    ] = None
