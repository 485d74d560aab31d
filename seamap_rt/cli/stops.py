"""Ctrl-C and SIGTERM.

While the modules are loaded nothing has been begun yet, and the process ends at once. Later the first signal raises
KeyboardInterrupt, so that files are closed, and all further ones do nothing: they would cut off what closes the files.
A library may swallow the first: where nothing deals with it a second later, it is raised again. Doing nothing is a
handler's work: Python complains of a signal that came just before it was set to be ignored.
"""

from __future__ import annotations

import os
import signal
import sys
from typing import Any

from ..errors import is_interruption

INTERRUPTED = 130
_AGAIN_S, _LOST_S = 0.01, 1.0  # after an interruption that met a callback; after which any other counts as lost


class Stops:
    """The handlers of both signals, from `begin` to `end`. A signal that the process was started to ignore stays so."""

    def __init__(self) -> None:
        self.requested = False
        self._before: dict[int, Any] = {}
        self._hook = sys.unraisablehook

    def begin(self) -> None:
        """The modules are being loaded."""
        for number in (signal.SIGINT, signal.SIGTERM):
            if signal.getsignal(number) is not signal.SIG_IGN:
                self._before[number] = signal.signal(number, _end_at_once)

    def run(self) -> None:
        """The command runs."""
        sys.unraisablehook = self._unraisable
        for number in self._before:
            signal.signal(number, self._stop)

    def end(self, process: bool) -> bool:
        """Restore or ignore both signals at the command's end; return whether it was interrupted. process: it ends with
        the command, and further signals are ignored.

        Of an interrupted one nothing is printed then that its libraries' tasks and destructors still meet.
        """
        interrupted, self.requested = self.requested, True
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        sys.unraisablehook = (lambda _: None) if process and interrupted else self._hook
        for number, handler in self._before.items():
            signal.signal(number, signal.SIG_IGN if process else handler)
        return interrupted

    def _stop(self, *_: object) -> None:
        if not self.requested:
            self.requested = True
            _raise_after(_LOST_S)
            raise KeyboardInterrupt

    def _unraisable(self, lost: sys.UnraisableHookArgs) -> None:
        """An interruption that met a callback from which nothing can be raised comes again, a little later."""
        if issubclass(lost.exc_type, KeyboardInterrupt):
            _raise_after(_AGAIN_S)
        else:
            self._hook(lost)


def _raise_after(seconds: float) -> None:
    signal.signal(signal.SIGALRM, _raise_unless_met)
    signal.setitimer(signal.ITIMER_REAL, seconds)


def _raise_unless_met(*_: object) -> None:
    """Raise KeyboardInterrupt, and again if that is lost too; not where one is being dealt with."""
    met = sys.exc_info()[1]
    if met is None or not is_interruption(met):
        _raise_after(_LOST_S)
        raise KeyboardInterrupt


def _end_at_once(*_: object) -> None:
    os.write(2, b"seamap-rt: interrupted: nothing was begun\n")
    os._exit(INTERRUPTED)
