"""The application: its commands, and how what goes wrong becomes one line and an exit code."""

from __future__ import annotations

import difflib
import errno
import io
import os
import sys
import warnings

from cyclopts import CycloptsError, UnknownCommandError, UnusedCliTokensError

from ..compute.machine import A_TABLE
from ..errors import InputError, NoBackendError, ResourceError, SchemaError, one_line, shortage
from ..io.process import filter_asyncio_log
from ..io.text import shown
from . import beginning, retrieving, simulating, studying  # noqa: F401  commands join the application
from .shell import app, command, console
from .stops import INTERRUPTED, Stops

BAD_INPUT, NO_BACKEND, NO_RESOURCE = 2, 3, 4
_LEFT = "what is complete, if anything, stays readable"


@command("doctor", "run tiny --tracer horizon", name="doctor", need=A_TABLE)
def doctor_command() -> int:
    """Tell which backend is used, what it has, and what mends what is missing; "info" is no fault."""
    from ..compute.backend import checks, doctor_lines

    rows = checks()
    for line in doctor_lines(rows):
        console.print(line)
    return 0 if all(check.ok for check in rows if check.item == "backend") else NO_BACKEND


_FULL = (errno.ENOSPC, errno.EDQUOT)
_SHORT = "raise the limits (ulimit -v, -d, -u), end other programs, or lower what is asked for"
_ADVICE = {
    errno.ENOSPC: "free the space or choose another --out",
    errno.EDQUOT: "free the space or choose another --out",
    errno.EFBIG: "choose another --out, or fewer turns",
    errno.ENAMETOOLONG: "give a shorter path",
}


def answer(arguments: list[str] | None, stops: Stops) -> int:
    """Run a command and return its exit code; each thing that is wrong is one line on stderr."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a terminal of ASCII alone shows "?" for the letters that it lacks
            stream.reconfigure(errors="replace")
    try:
        stops.run()
        code = app(arguments, exit_on_error=False, print_error=False)
    except KeyboardInterrupt as interruption:
        return _refuse(f"interrupted: {str(interruption) or _LEFT}", INTERRUPTED)
    except ResourceError as error:
        return _refuse(str(error), NO_RESOURCE)
    except Exception as error:
        lack = shortage(error)
        if stops.requested or lack is None:
            return _answer_to(error, stops)
        warnings.simplefilter("ignore")  # of what was begun and is never waited for
        known = str(lack) if isinstance(lack, ResourceError) else f"memory or threads ran out; {_SHORT}; {_LEFT}"
        return _refuse(known, NO_RESOURCE)
    sys.stdout.flush()
    return code if isinstance(code, int) else 0


def _answer_to(error: Exception, stops: Stops) -> int:
    """Print what is no lack of memory; its exit code."""
    try:
        raise error
    except InputError as error:
        return _refuse(error.problems, BAD_INPUT)
    except NoBackendError as error:
        return _refuse(str(error), NO_BACKEND)
    except UnknownCommandError as error:
        return _refuse(_commands_in_words(error.unused_tokens or [""]), BAD_INPUT)
    except UnusedCliTokensError as error:
        return _refuse(_leftover_words(error.unused_tokens or [""]), BAD_INPUT)
    except (SchemaError, CycloptsError) as error:
        return _refuse(str(error), BAD_INPUT)
    except OSError as error:
        if stops.requested:
            return _refuse(f"interrupted: {_LEFT}", INTERRUPTED)
        full = error.errno in _FULL or os.strerror(errno.ENOSPC) in str(error)  # HDF5 tells it in words alone
        reason = f"'{error.filename}': {error.strerror or error}" if error.filename else error.strerror or error
        advice = _ADVICE.get(error.errno or 0, "make the file accessible, free the space, or choose another --out")
        return _refuse(f"{reason}; {advice}", NO_RESOURCE if full else BAD_INPUT)
    except Exception:
        if not stops.requested:
            raise
        return _refuse(f"interrupted: {_LEFT}", INTERRUPTED)  # a library made something else of it


def _commands_in_words(tokens: list[str]) -> str:
    names = [name for name in app if not name.startswith("-")]
    near = difflib.get_close_matches(tokens[0], names, 1)
    hint = f"did you mean {near[0]}? The" if near else "the"
    return f"{shown(tokens[0])}: no such command; {hint} commands are {', '.join(names)}"


def _leftover_words(tokens: list[str]) -> str:
    """Words that are left over, such as a key of the scene without --set."""
    left = " ".join(tokens)
    if all("=" in each for each in tokens):
        return f"{left}: belongs to no option; write {' '.join(f'--set {each}' for each in tokens)} to change a key"
    return f"{left}: the command takes no such argument; --help says which it takes"


def _refuse(lines: str | tuple[str, ...], code: int) -> int:
    filter_asyncio_log()  # the process ends, and so do tasks of libraries
    for line in (lines,) if isinstance(lines, str) else lines:
        print(f"seamap-rt: {one_line(line)}", file=sys.stderr)
    return code
