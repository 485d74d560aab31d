"""What a run modelled, at what cost, and what it left out, at what error: for `metrics.json`, the report and the shell.

Rows are {what, why, error, source}: the error of leaving a part out, a closed form evaluated for this scene and its
resolved sea, or a measurement of this project; `costed` adds what the parts took in the run itself.
"""

from __future__ import annotations

from ..scene import Scene
from ..sea import Resolved
from .basis import Basis
from .costs import costed
from .left_out import left_out_rows
from .lines import account_lines
from .modelled import modelled_rows

__all__ = ["account_lines", "costed", "left_out", "modelled"]


def modelled(scene: Scene, resolved: Resolved) -> list[dict[str, str]]:
    """Rows of what was modelled, how, and the error of leaving it out."""
    return [row._asdict() for row in modelled_rows(Basis(scene, resolved))]


def left_out(scene: Scene, resolved: Resolved) -> list[dict[str, str]]:
    """Rows of what was not, why or by which key it would be, and the error that this costs."""
    return [row._asdict() for row in left_out_rows(Basis(scene, resolved))]
