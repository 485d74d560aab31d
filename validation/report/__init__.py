"""The validation report: cases run one after another, and a page with what each expected and what came out."""

from .case import Case, Check, Group, Outcome
from .result import CaseResult, ValidationResult
from .runner import validate

__all__ = ["Case", "CaseResult", "Check", "Group", "Outcome", "ValidationResult", "validate"]
