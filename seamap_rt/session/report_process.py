"""A second process beside a run: it loads what draws while the first one does its part, and then draws the report.

The pictures are drawn by two processes, where a process can be forked.

In an installation that has compiled no loop yet it first compiles the sum of the echoes and the retrieval's loops, by
summing no facet and retrieving some waves, while the first process compiles the rest of the simulation's. Both keep
what they compile on disk, where the other finds it.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import multiprocessing
import pickle
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from ..report.page_elements import Image, Picture

_ANSWER = f"from {__name__} import answer; answer()"
_PR_SET_PDEATHSIG = 1  # linux/prctl.h


class ReportProcess:
    """`report.write_report` in a process of its own, for one report. A context; it ends with the process it serves.

    Where it cannot be started, or has ended (no memory is left for it), the report is drawn here.
    """

    def __enter__(self) -> Self:
        self._process: subprocess.Popen[bytes] | None = None
        with contextlib.suppress(OSError):
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", _ANSWER],  # -P: no module of the user's folder is taken for a library's
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        return self

    def __call__(self, *given: Any) -> Path:
        """Draw what `write_report` is given, and raise what it raises."""
        if self._process is None or self._process.stdin is None or self._process.stdout is None:
            return write_report(*given)
        try:
            with self._process.stdin as sent:
                pickle.dump(given, sent)
            drawn = pickle.load(self._process.stdout)
        except (OSError, EOFError, pickle.UnpicklingError):
            return write_report(*given)
        if isinstance(drawn, Exception):
            raise drawn
        return drawn

    def __exit__(self, *raised: object) -> None:
        if self._process is not None:
            self._process.kill()  # it has nothing to finish
            with self._process:
                pass


def write_report(*given: Any) -> Path:
    """Write the report as `report.page.write_report` does, whose loading takes a second."""
    from ..report.page import write_report

    return write_report(*given)


def answer() -> None:
    """Draw the report that is sent on the standard input; the answer is its path, or an error."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that it serves
    _end_with_parent()
    answers, sys.stdout = sys.stdout.buffer, sys.stderr
    if not is_compiled():
        gc.disable()  # compiling makes many objects that last; of figures, which refer to themselves, memory is freed
        compile_sum()
        compile_retrieval()
        gc.enable()
    from ..report import page

    _load_libraries()
    try:
        given = pickle.load(sys.stdin.buffer)
    except EOFError:
        return
    try:
        drawn: Any = page.write_report(*given, draw=draw_in_two)
    except Exception as error:
        drawn = error
    pickle.dump(drawn, answers)
    answers.flush()


def _load_libraries() -> None:
    """Load what drawing loads at its first figure: Matplotlib's fonts and text, and dask, of which xarray asks."""
    import numpy as np
    import xarray as xr

    from ..report import style

    figure = style.new_figure(1.0, 1.0)
    style.place(figure, 0.2, 0.2, 0.6, 0.6).set_title("m²")
    style.png(figure)
    xr.Dataset({"a": ("x", np.zeros(1))})


def draw_in_two(pictures: Sequence[Picture]) -> list[Image]:
    """The images of the pictures, drawn by this process, which must have no other thread, and a child of it: each takes
    the next one.

    What fails in the child is drawn here again, where it says why. Linux alone forks: elsewhere libraries forbid it.
    """
    from ..report.page_elements import draw_images

    if sys.platform != "linux":
        return draw_images(pictures)
    forked = multiprocessing.get_context("fork")
    # From the last one: the echo's, which is read from the disk, takes longest.
    remaining = forked.Value("i", len(pictures))
    receiver, sender = forked.Pipe(duplex=False)

    def draw() -> dict[int, Image]:
        made = {}
        while True:
            with remaining.get_lock():
                remaining.value = number = remaining.value - 1
            if number < 0:
                return made
            made[number] = pictures[number].image()

    def draw_beside() -> None:
        _end_with_parent()
        sender.send(draw())

    child = forked.Process(target=draw_beside, daemon=True)
    child.start()
    sender.close()  # so that the child's end is the last one
    made = draw()
    with receiver, contextlib.suppress(EOFError):
        made |= receiver.recv()
    child.join()
    return [made[n] if n in made else picture.image() for n, picture in enumerate(pictures)]


def _end_with_parent() -> None:
    """Let Linux kill this process when its parent ends, also when that is killed; other systems have no such call."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def is_compiled() -> bool:
    """Whether the retrieval's loops have been compiled, by this or another process."""
    from ..interferometry import optimal

    loop: Any = optimal.interpolate
    return any(Path(loop.stats.cache_path).glob("optimal.interpolate-*.nbi"))


def compile_sum() -> None:
    """Sum one column of no facets."""
    import numpy as np

    from ..echoes.summation import batch
    from ..echoes.summation.processor import sum_columns

    number, real = np.zeros(1, int), np.zeros(1)
    one = np.zeros((1, 1))
    sum_columns(
        batch.ColumnBatch(
            window=1,
            nodes=1,
            columns=batch.Columns(number, np.zeros(2, int), number, real),
            facets=batch.ListedFacets(number[:0], real[:0], one[:, :0], one[:, :0], np.zeros((1, 0), np.complex64)),
            speckle=batch.Speckle(
                np.zeros(1, np.uint64), np.zeros((1, 1, 1), np.complex64), 1, np.zeros((0, 1), np.float32)
            ),
            geometry=batch.Geometry(np.zeros((1, 2), int), 1.0, 1.0),
            response=batch.RangeTable(np.zeros((1, 2), np.float32), 1.0, 0.0, 1.0),
            beam=batch.Beam(np.zeros((1, 1, 2), np.float32), 1.0, one, real, real, real, one, one, one),
        )
    )


def compile_retrieval() -> None:
    """Retrieve a turn over waves that are high enough for the phase's cycle to be looked for."""
    import numpy as np

    from ..conventions import ground_range, radar_wavenumber
    from ..echoes.dataset import echo_dataset
    from ..interferometry import retrieve
    from ..radar.scan import pulses
    from ..radar.waveform import gates
    from ..resolved_scene import installation_of
    from ..scene import load_scene
    from ..wavefield import sea_state

    installation = installation_of(load_scene("tiny"))
    radar = installation.radar
    fired, slant = pulses(installation, 0), gates(radar)
    ground = ground_range(slant, radar.height_m)
    above = fired.pose.positions[0, :, 2, None] - 2.0 * np.sin(ground / 6.0)
    phase = -radar_wavenumber(radar.frequency_hz) * np.hypot(ground, above)
    speckle = np.random.default_rng(0).standard_normal((2, fired.number.size, 1, slant.size))
    voltage = (1e-3 * (speckle[0] + 1j * speckle[1]) * np.exp(1j * phase)).astype(np.complex64)
    sea_state(retrieve(echo_dataset(installation, [fired], [voltage])))
