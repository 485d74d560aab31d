"""The account in lines, as the command prints it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Rows = Sequence[Mapping[str, Any]]


def account_lines(modelled: Rows, left_out: Rows, most: int = 20) -> list[str]:
    """What is modelled with its cost, what is left out with its error; beyond so many lines the last one only names."""
    lines = [
        f"modelled: {row['what']} ({row.get('cost', 'not timed')}; without it {row.get('error') or 'not known'})"
        for row in modelled
    ]
    lines += [f"left out: {row['what']} ({row.get('error') or 'not known'})" for row in left_out]
    if len(lines) <= most:
        return lines
    others = "; ".join(row["what"] for row in [*modelled, *left_out][most - 1 :])
    return [*lines[: most - 1], f"left out: {others} (errors in the report)"]
