"""The backend that Dr.Jit runs on: CUDA or an LLVM library, tested before it is used."""

from .choose import prepare
from .doctor import Check, doctor_lines
from .doctor import checks as doctor_checks
from .kinds import VARIABLE, Backend

__all__ = ["VARIABLE", "Backend", "Check", "doctor_checks", "doctor_lines", "prepare"]
