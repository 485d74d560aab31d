"""What a run modelled, at what cost, and what it left out, at what error: for `metrics.json`, the report and the shell.

Each row holds one number, for one scene and its resolved sea: a closed form of the package that owns its subject, or
what one of the simulation's own models says. A row whose number is not finite does not hold for the scene, and is left
out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from ...scene import Scene
from ...sea import Resolved
from . import leaving_out, modelling
from .case import Case
from .rows import Row, account_lines, costed

__all__ = ["account_lines", "costed", "left_out", "modelled"]


def modelled(scene: Scene, resolved: Resolved) -> list[Row]:
    """Rows of what was modelled, how, and the error of leaving it out: what, why, error, value, unit, source."""
    return _finite(Case(scene, resolved), modelling.GROUPS)


def left_out(scene: Scene, resolved: Resolved) -> list[Row]:
    """Rows of what was not, why or by which key it would be, and the error that this costs; keys as of `modelled`."""
    return _finite(Case(scene, resolved), leaving_out.GROUPS)


def _finite(case: Case, groups: Sequence[Callable[[Case], Iterator[Row]]]) -> list[Row]:
    return [row for group in groups for row in group(case) if math.isfinite(row["value"])]
