"""The backend that Dr.Jit runs on: CUDA or an LLVM library, tested before it is used."""

from .choose import Backend, Check, checks, doctor_lines, prepare
from .trial import VARIABLE

__all__ = ["VARIABLE", "Backend", "Check", "checks", "doctor_lines", "prepare"]
