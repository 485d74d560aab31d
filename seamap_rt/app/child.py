"""A module of the page's own in a process of its own: what takes memory, or reads what nobody vouches for."""

from __future__ import annotations

import subprocess
import sys

from ..errors import InputError, one_line


def asked(module: str, *words: str, longest_s: float) -> bytes:
    """What `python -m MODULE WORDS` prints. InputError with its last line where it refuses, ends badly or takes too
    long."""
    try:
        done = subprocess.run(
            [sys.executable, "-m", module, *words],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=longest_s,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"takes longer than {longest_s:.0f} s; make it smaller") from None
    if done.returncode == 0:
        return done.stdout
    said = done.stderr.decode("utf-8", "replace").strip().splitlines()
    if done.returncode == 2 and said:
        raise InputError(one_line(said[-1]))
    why = f"by signal {-done.returncode}" if done.returncode < 0 else f"with exit code {done.returncode}"
    raise InputError(f"cannot be read: what reads it ended {why}; make it smaller, or save it anew")
