"""The validation report: cases run one after another, and a page that says what each asked and what came out."""

from .case import Case, Check, Group, Outcome
from .result import Done, Result
from .runner import validate

__all__ = ["Case", "Check", "Done", "Group", "Outcome", "Result", "validate"]
