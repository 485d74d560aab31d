"""The proof: a process of its own works with a library, since the failure to be expected ends the process."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys

from ..scratch import scratch_folder
from .kinds import OLDEST_LLVM, VARIABLE, VARIANTS, Candidate, Verdict

PROBE_LIMIT_S = 120.0  # a cold import from a slow disk is allowed, a hang is not


# LLVM's failure is an abort, so this runs in a process of its own, without a core dump. ctypes loads the
# library first because Dr.Jit would go on to another one without a message. A ray is traced because CUDA without
# OptiX is of no use.
PROBE = """
import ctypes, sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except ImportError:
    pass
kind, library, variant = sys.argv[1:]
handle = ctypes.CDLL(library)
if kind == "cuda":
    number = ctypes.c_int()
    handle.cuDriverGetVersion(ctypes.byref(number))
    version = f"{number.value // 1000}.{number.value % 1000 // 10}"
elif hasattr(handle, "LLVMGetVersion"):
    numbers = [ctypes.c_uint() for _ in range(3)]
    handle.LLVMGetVersion(*map(ctypes.byref, numbers))
    version = ".".join(str(number.value) for number in numbers)
else:
    version = "15 or older"
import drjit as dr
import mitsuba as mi
mi.set_variant(variant)
x = dr.arange(mi.Float, 7) - 3
if list(dr.maximum(x, 0)) != [0, 0, 0, 0, 1, 2, 3] or list(dr.clip(x, -1, 1)) != [-1, -1, -1, 0, 1, 1, 1]:
    sys.exit("it computes a maximum wrongly")
plate = mi.load_dict({"type": "scene", "plate": {"type": "rectangle"}})
hit = plate.ray_intersect(mi.Ray3f(mi.Point3f(0, 0, 2), mi.Vector3f(0, 0, -1)))
if not dr.all(abs(hit.t - 2) < 1e-3):
    sys.exit("it traces a ray wrongly")
print("works", version)
"""


def try_out(candidate: Candidate) -> Verdict:
    """Let a process of its own work with the library."""
    with scratch_folder() as scratch:
        environment = os.environ | {"DRJIT_CACHE_DIR": str(scratch)}  # a kernel compiled earlier proves nothing
        if candidate.kind == "llvm":
            environment[VARIABLE] = str(candidate.library)
        arguments = [candidate.kind, str(candidate.library), VARIANTS[candidate.kind]]
        # -P: a file called drjit.py in the working folder is not Dr.Jit.
        command = [sys.executable, "-P", "-W", "ignore", "-c", PROBE, *arguments]
        try:
            done = subprocess.run(
                command,
                env=environment,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=PROBE_LIMIT_S,
            )
        except subprocess.TimeoutExpired:
            return Verdict(False, f"no answer within {PROBE_LIMIT_S:.0f} s")
        except OSError as error:
            return Verdict(False, f"cannot start {sys.executable}: {error.strerror}")
    answer = re.search(r"^works (.+)$", done.stdout, re.MULTILINE)
    if done.returncode != 0 or answer is None:
        return Verdict(False, reason(done.returncode, done.stderr))
    return Verdict(True, answer[1])


def reason(returncode: int, stderr: str) -> str:
    """Why a probe failed, in a few words of one line."""
    if "libatomic" in stderr:  # Dr.Jit itself ends in a NameError here, which names no cause
        return "libatomic.so.1 is missing, which Dr.Jit needs"
    if "Cannot select" in stderr or "too old" in stderr or "is inactive because the LLVM" in stderr:
        return f"too old or incomplete, LLVM {OLDEST_LLVM} or newer is needed"
    lines = [line.strip() for line in stderr.splitlines() if line.strip()]
    if returncode < 0:
        with contextlib.suppress(ValueError):
            lines.append(f"the process ended with {signal.Signals(-returncode).name}")
    return lines[-1][:200] if lines else f"the process ended with code {returncode}"
