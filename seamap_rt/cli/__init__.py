"""The command line: a thin shell over the package.

Bad input is one line and exit 2; no usable system or backend, exit 3; too little memory, threads or disk, exit 4.

Ctrl-C and SIGTERM: whenever they come, and however often, the program ends with one line and exit code 130.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import os
import sys

from .stops import Stops


def main(arguments: list[str] | None = None) -> None:
    """Entry point of `seamap-rt`. arguments: default those of the process, which ends with the command."""
    if sys.platform == "win32":  # locks, limits of memory and signals are those of Unix
        print("seamap-rt: Windows: must be Linux or macOS; run it in WSL, as by wsl --install", file=sys.stderr)
        raise SystemExit(3)
    codes: list[int] = []
    if arguments is None:
        gc.disable()  # what is loaded stays: to visit it again and again takes a tenth of a short command's time
        atexit.register(_end_process, codes)  # the first that is registered is the last that is called
    stops = Stops()
    stops.begin()
    try:
        from .application import answer  # takes a second, in which signals may come

        sys.exit(answer(arguments, stops))
    except SystemExit as ended:
        codes += [ended.code] if isinstance(ended.code, int) else []
        raise
    finally:
        if stops.end(process=arguments is None) and arguments is None:
            # Python would first wait for every thread: for ever, where the interruption met one as it was started, for
            # its executor does not know it then, and lets it wait for work.
            atexit._run_exitfuncs()


def _end_process(codes: list[int]) -> None:
    """End the process with the code, if a command gave one: Python would visit all that was loaded, half a second."""
    with contextlib.suppress(OSError, ValueError):  # nobody reads on: Python says so
        if codes:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(codes[0])
