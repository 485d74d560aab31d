"""The evidence: studies, benchmarks and judged cases, and the figures and tables that they make."""

from pathlib import Path

FIGURES = Path(__file__).parent / "figures"
REFERENCE = Path(__file__).parent / "reference"
ROOT = Path(__file__).parents[1]  # from which `python -m validation.…` finds it
