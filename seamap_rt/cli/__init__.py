"""The command line: a thin shell over the package. Bad input is one line and exit 2; no usable backend, exit 3."""

from __future__ import annotations

import errno
import io
import signal
import sys

from cyclopts import CycloptsError

from ..compute.backend import doctor_checks, doctor_lines
from ..errors import InputError, NoBackend, SchemaError, one_line
from ..io.scenefile import list_shipped, read_toml
from . import retrieving, simulating, studying  # noqa: F401  their commands join the application
from .shell import app, console

BAD_INPUT, NO_BACKEND, INTERRUPTED = 2, 3, 130


@app.command
def scenes() -> int:
    """List the shipped scenes, a line each."""
    for name, path in list_shipped().items():
        console.print(f"{name:20} {read_toml(path).get('title', '')}")
    return 0


@app.command(name="doctor")
def doctor_command() -> int:
    """Tell which backend is used, what it has, and what mends what is missing."""
    for line in doctor_lines():
        console.print(line)
    return 0 if all(check.ok for check in doctor_checks() if check.item == "backend") else NO_BACKEND


def _terminated(*_: object) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # a second one would cut off what closes the files
    raise KeyboardInterrupt


def _print_anywhere() -> None:
    """A terminal that knows ASCII alone shows "?" for the letters that it lacks."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


_ADVICE = {
    errno.ENOSPC: "free the space or choose another --out",
    errno.EDQUOT: "free the space or choose another --out",
    errno.EFBIG: "choose another --out, or fewer turns",
    errno.ENAMETOOLONG: "give a shorter path",
}


def main(arguments: list[str] | None = None) -> None:
    """Entry point of `seamap-rt`."""
    _print_anywhere()
    signal.signal(signal.SIGTERM, _terminated)
    try:
        code = app(arguments, exit_on_error=False, print_error=False)
    except (InputError, SchemaError) as error:
        code = _refuse(str(error), BAD_INPUT)
    except NoBackend as error:
        code = _refuse(str(error), NO_BACKEND)
    except KeyboardInterrupt as interruption:
        code = _refuse(
            f"interrupted: {str(interruption) or 'what is complete, if anything, stays readable'}", INTERRUPTED
        )
    except OSError as error:
        reason = error.strerror or error
        what = f"'{error.filename}': {reason}" if error.filename else reason
        advice = _ADVICE.get(error.errno or 0, "make the file accessible, free the space, or choose another --out")
        code = _refuse(f"{what}; {advice}", BAD_INPUT)
    except CycloptsError as error:
        code = _refuse(str(error), BAD_INPUT)
    sys.stdout.flush()
    sys.exit(code if isinstance(code, int) else 0)


def _refuse(line: str, code: int) -> int:
    print(f"seamap-rt: {one_line(line)}", file=sys.stderr)
    return code
