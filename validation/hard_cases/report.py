"""Numerical stability: cases whose right answer is known, at full size. A table, figures and a page of their own.

    python -m validation.hard_cases.report [--out validation/figures/hard_cases] [--rays 10000000] [--full]

Each row has the expected result, the result, and whether they agree. --full adds a mesh of 10⁷ facets (7 GB).
"""

from __future__ import annotations

import argparse
import base64
import time
from collections.abc import Callable
from pathlib import Path

import jinja2

from seamap_rt.report import style
from validation import FIGURES
from validation.hard_cases.ahead import forecasts
from validation.hard_cases.case import Effort, Finding
from validation.hard_cases.extreme import choppy_wall, crest, level, storm, ten_million
from validation.hard_cases.far import baselines, far_from_origin, far_phases, half_a_day
from validation.hard_cases.light import along_the_ray, one_facet, rays_against_horizon, slivers, terminator, watertight
from validation.hard_cases.nonlinear import nonlinear_seas

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

PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Hard cases – seamap_rt</title><link rel="icon" href="data:,">
<style>
body { margin: 0 auto; padding: 1.5rem 1rem 4rem; max-width: 62rem; background: #fff; color: #1b1b1b;
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.6rem; }
table { border-collapse: collapse; font-size: .85rem; }
th, td { padding: .2rem .7rem; text-align: left; border-bottom: 1px solid #e2e2e2; vertical-align: top; }
td.wrong { color: #d55e00; font-weight: 600; }
figure { margin: 2rem 0; } img { width: 100%; max-width: 936px; }
</style></head><body>
<h1>Numerical stability: hard cases</h1>
<p>{{ right }} of {{ total }} cases come out as they must. Each has an answer that is known: a closed form, extended
precision, or the same scene where it is easy.</p>
<table><thead><tr><th>Case</th><th>What must come out</th><th>What did</th><th>Verdict</th></tr></thead><tbody>
{% for row in rows %}
<tr><td>{{ row.case }}</td><td>{{ row.expectation }}</td><td>{{ row.obtained }}</td>
<td{% if row.right == False %} class="wrong"{% endif %}>{{ verdict(row) }}</td></tr>
{% endfor %}
</tbody></table>
{% for data, row in shown %}
<figure><img src="data:image/png;base64,{{ data }}" alt="{{ row.case }}: {{ row.obtained }}">
<figcaption><b>Figure {{ loop.index }}.</b> {{ row.case }}: {{ row.expectation }}.
Result: {{ row.obtained }}.</figcaption>
</figure>
{% endfor %}
</body></html>
"""


def verdict(row: Finding) -> str:
    return {True: "right", False: "WRONG", None: "–"}[row.right]


def write_page(out: Path, rows: list[Finding]) -> Path:
    """Figures as PNGs and in a page that needs no other file; its path."""
    out.mkdir(parents=True, exist_ok=True)
    shown = []
    for number, row in enumerate([row for row in rows if row.figure is not None], 1):
        assert row.figure is not None
        data = style.png(row.figure)
        (out / f"hard_cases_{number}.png").write_bytes(data)
        shown.append((base64.b64encode(data).decode("ascii"), row))
    template = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined).from_string(PAGE)
    judged = [row.right for row in rows if row.right is not None]
    page = template.render(rows=rows, shown=shown, verdict=verdict, right=sum(judged), total=len(judged))
    path = out / "hard_cases.html"
    path.write_text(page, encoding="utf-8")
    return path


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=FIGURES / "hard_cases")
    parser.add_argument("--rays", type=int, default=10_000_000)
    parser.add_argument("--only", default="", help="part of the name of the functions to run")
    parser.add_argument("--full", action="store_true")
    arguments = parser.parse_args()
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
    print(f"written: {write_page(arguments.out, rows)}")
    if any(row.right is False for row in rows):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
