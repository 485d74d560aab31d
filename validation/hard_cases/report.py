"""Numerical stability: cases whose right answer is known, at full size; `seamap-rt validate` draws them.

    python -m validation.hard_cases.report [--rays 10000000] [--only storm] [--full]

Each row has the expected result, the result, and whether they agree. --full adds a mesh of 10⁷ facets (7 GB).
"""

from __future__ import annotations

import time
from collections.abc import Callable

from seamap_rt.report import style

from ..options import options
from .ahead import forecasts
from .case import Effort, Finding
from .extreme import choppy_wall, crest, level, storm, ten_million
from .far import baselines, far_from_origin, far_phases, half_a_day
from .light import along_the_ray, one_facet, rays_against_horizon, slivers, terminator, watertight
from .nonlinear import nonlinear_seas

CASES: tuple[Callable[[Effort], list[Finding]], ...] = (
    terminator,
    rays_against_horizon,
    watertight,
    along_the_ray,
    slivers,
    far_from_origin,
    crest,
    choppy_wall,
    level,
    baselines,
    far_phases,
    half_a_day,
    storm,
    nonlinear_seas,
    one_facet,
    forecasts,
    ten_million,
)


def verdict(row: Finding) -> str:
    return {True: "right", False: "WRONG", None: "–"}[row.right]


def main() -> None:
    arguments = options(__doc__, rays=10_000_000, only="", full=False)
    effort = Effort(arguments.rays, arguments.full)
    rows: list[Finding] = []
    for case in CASES:
        if arguments.only not in case.__name__:
            continue
        start = time.perf_counter()
        findings = style.styled(case)(effort)
        rows += findings
        for row in findings:
            print(f"{verdict(row):6}{row.case} | {row.expectation} | {row.obtained}", flush=True)
        print(f"      ({case.__name__}: {time.perf_counter() - start:.1f} s)", flush=True)
    if any(row.right is False for row in rows):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
