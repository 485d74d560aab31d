"""Quiet windows: hits against false alarms, and what stated probabilities came to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..window_errors import Class, Windows, area, hits_and_alarms, reliability
from . import style
from .page_elements import Picture, Table, digits, percent

_COLOURS = {"persistence": style.GREY, "group law": style.ORANGE}


def window_pictures(windows: Windows | None, confidence: float) -> list[Picture]:
    """Of a run's windows; none of a run that had none, or of one kind alone."""
    if windows is None or windows.quiet.all() or not windows.quiet.any():
        return []
    return [window_picture(windows, confidence)]


def window_picture(windows: Windows, confidence: float) -> Picture:
    """Hits, false alarms and what probabilities came to."""
    return Picture(
        "quiet_windows",
        "Quiet windows against the sea that came",
        "Hits against false alarms of forecast quiet windows as the threshold varies, beside persistence; and the "
        "share of windows that were quiet against their stated probability.",
        f"(a) Each of {windows.quiet.size} windows was forecast with a probability; the point is what is called "
        f"from {confidence:.0%} on. Persistence: windows are the likelier quiet the lower the water stayed just "
        "before. (b) By classes of stated probability, with the number of windows. Windows overlap, so that one "
        "run tells little of the middle classes.",
        lambda: quiet_windows([windows], confidence),
    )


def window_table(told: Mapping[str, Any] | None) -> list[Table]:
    """What metrics.json says of quiet windows; none if the run had none."""
    if not told:
        return []
    rows = [
        ["Windows", str(told["windows"])],
        ["Quiet", percent(told["quiet_share"])],
        [f"Called at {told['confidence']:.0%}", str(told["called"])],
        ["Called ones that were quiet", percent(told["right"])],
        ["Quiet ones that were called", percent(told["found"])],
        ["Area under hits against false alarms", digits(told["area"], 3)],
        ["… of persistence", digits(told["persistence_area"], 3)],
        ["Mean square error of probabilities", digits(told["brier"], 3)],
        ["… of climatology", digits(told["climatology_brier"], 3)],
    ]
    return [Table("Quiet windows", ("Figure", "Value"), rows, "Of all windows that end within a forecast's leads.")]


@style.styled
def quiet_windows(runs: Sequence[Windows], confidence: float) -> Figure:
    """Of one run or several, whose bands are then drawn too."""
    chance, quiet = (np.concatenate([getattr(run, name) for run in runs]) for name in ("chance", "quiet"))
    scores = {"forecast": chance}
    scores |= {name: np.concatenate([run.others[name] for run in runs]) for name in runs[0].others}
    figure = style.new_figure(2.85)
    curves, stated = (style.place(figure, left, 0.3, 2.7, 2.0) for left in (0.6, 4.2))
    alike = bool(quiet.all() or not quiet.any())
    for name, score in scores.items() if not alike else ():
        hits, alarms = hits_and_alarms(score, quiet)
        label = f"{name}, area {area(score, quiet):.3f}"
        curves.plot(alarms, hits, color=_COLOURS.get(name, style.BLUE), label=label)
    called = chance >= confidence
    if alike:
        style.note(curves, "all windows were quiet" if quiet.any() else "no window was quiet")
    else:
        point = float(called[~quiet].mean()), float(called[quiet].mean())
        curves.plot(*point, "o", color=style.BLUE, label=f"called at {confidence:.0%}")
        curves.legend(loc="lower right", fontsize="small")
    style.graph(curves, "Share of other windows called", "Share of quiet windows called", "(a) Hits and false alarms")
    _draw_probabilities(stated, reliability(runs), len(runs) > 1)
    for axes in (curves, stated):
        axes.set_xlim(-0.02, 1.02)
        axes.set_ylim(-0.02, 1.02)
    return figure


def _draw_probabilities(axes: Axes, classes: Sequence[Class], bands: bool) -> None:
    axes.plot([0.0, 1.0], [0.0, 1.0], "--", color=style.GREY)
    told, found = ([getattr(each, name) for each in classes] for name in ("stated", "found"))
    band = [[each.found - each.low for each in classes], [each.high - each.found for each in classes]]
    axes.errorbar(told, found, band if bands else None, fmt="o-", color=style.BLUE, capsize=3)
    for each in classes:
        place = (each.stated, each.found)
        axes.annotate(str(each.count), place, textcoords="offset points", xytext=(5, -9), fontsize="small")
    style.graph(axes, "Stated probability", "Share that were quiet", "(b) What probabilities came to")
