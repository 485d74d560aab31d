"""Commands that simulate: run, simulate, sea and link."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.text import Text

from .shell import Settings, Whole, app, console, progress, scene_of


def _headline(metrics: dict[str, Any]) -> str:
    from ..report.headline import wave_height  # takes a second

    overall = metrics.get("overall", {})

    def number(key: str, digits: int = 2) -> str:
        value = overall.get(key)
        return "—" if value is None else f"{value:.{digits}f}"

    band = overall.get("range_m")
    at = f"{band[0]:.0f}–{band[1]:.0f} m" if band else "50–200 m"
    return (
        f"{at}, cells more than half visible: height error {number('height_rmse_m', 3)} m rms "
        f"({number('height_robust_m', 3)} robust, bias {number('height_bias_m', 3)}), "
        f"correlation {number('height_correlation')}; visible share {number('visible_fraction')}; "
        f"Hs true {number('hs_true_m')} m, from the maps {wave_height(metrics)}"
    )


def _print_account(metrics: dict[str, Any]) -> None:
    """What was modelled and left out; on a terminal the kind of each line stands out."""
    from ..report.limits import account_lines

    for line in account_lines(metrics["modelled"], metrics["left_out"]):
        kind, rest = line.split(": ", 1)
        console.print(Text.assemble((f"{kind}: ", "bold" if kind == "modelled" else "dim bold"), rest))


def _warn(metrics: dict[str, Any]) -> None:
    from ..report import warnings

    for warning in warnings(metrics):
        console.print(f"flag: {warning}")


@app.command
def run(
    scene: str,
    *,
    out: Path | None = None,
    turns: Whole | None = None,
    seed: Whole | None = None,
    tracer: str | None = None,
    predict: bool = False,
    overwrite: bool = False,
    set_: Settings | None = None,
) -> int:
    """Simulate a scene, retrieve its heights, compare them with the truth, and draw a report.

    Parameters
    ----------
    scene
        Path of a scene file, or the name of a shipped scene (see `scenes`).
    out
        Folder for the results; default runs/SCENE-SEED.
    turns
        Turns of the antenna.
    seed
        Of all random numbers.
    tracer
        facets, horizon or paths.
    predict
        Forecast the sea beside the run, from its maps: prediction.nc.
    overwrite
        Replace another run's results in that folder.
    set_
        KEY=VALUE, any key of the scene file, as often as wanted.
    """
    loaded = scene_of(scene, set_, turns=turns, seed=seed, tracing__tracer=tracer)
    from ..report.headline import forecast_line, verdict, window_line
    from ..session import run as run_scene

    say, stop = progress()
    try:
        result = run_scene(loaded, out, predict=predict, overwrite=overwrite, progress=say)
    finally:
        stop()
    if words := verdict(result.metrics):
        console.print(words)
    console.print(_headline(result.metrics))
    console.print(f"sea state from the maps: {result.metrics['sea_state_in_words']}")
    if predict:
        console.print(forecast_line(result.metrics))
        if told := window_line(result.metrics):
            console.print(told)
    _warn(result.metrics)
    _print_account(result.metrics)
    console.print(f"{result.folder / 'report.html'} (with maps.nc, truth.nc, echoes.zarr, metrics.json, scene.toml)")
    return 0


@app.command
def simulate(
    scene: str,
    *,
    out: Path,
    turns: Whole | None = None,
    seed: Whole | None = None,
    tracer: str | None = None,
    overwrite: bool = False,
    set_: Settings | None = None,
) -> int:
    """Simulate a scene's echoes and the truth beside them: echoes.zarr and truth.nc.

    Parameters
    ----------
    scene
        Path of a scene file, or the name of a shipped scene.
    out
        Folder for the results.
    turns
        Turns of the antenna.
    seed
        Of all random numbers.
    tracer
        facets, horizon or paths.
    overwrite
        Replace earlier results in that folder.
    set_
        KEY=VALUE, any key of the scene file, as often as wanted.
    """
    loaded = scene_of(scene, set_, turns=turns, seed=seed, tracing__tracer=tracer)
    from ..session import simulate as simulate_scene

    say, stop = progress()
    try:
        say("sea: drawing it, and preparing the tracer")
        simulate_scene(loaded, out, overwrite=overwrite, progress=say)
    finally:
        stop()
    console.print(f"{out / 'echoes.zarr'}, {out / 'truth.nc'}")
    return 0


@app.command
def sea(
    scene: str,
    *,
    out: Path,
    times: str = "0:5:0.5",
    side: float | None = None,
    spacing: float | None = None,
    seed: Whole | None = None,
    overwrite: bool = False,
    set_: Settings | None = None,
) -> int:
    """Write a scene's sea itself: heights, slopes, velocities and radar cross-sections in time, and pictures of them.

    Parameters
    ----------
    scene
        Path of a scene file, or the name of a shipped scene.
    out
        Folder for the results.
    times
        START:STOP:STEP or T,T,… in seconds; write --times=-5:0:1 for times before 0.
    side
        Of the square of points around the antenna, m; default the range circle.
    spacing
        Of the points, m; default what is resolved, at most 512 points a side.
    seed
        Of all random numbers.
    overwrite
        Replace earlier results in that folder.
    set_
        KEY=VALUE, any key of the scene file. Shadows are found by the horizon; tracing.tracer=facets traces rays.
    """
    loaded = scene_of(scene, ["tracing.tracer=horizon", *(set_ or [])], seed=seed)
    from ..products.writing import write_sea

    say, stop = progress()
    try:
        made = write_sea(loaded, out, times=times, side=side, spacing=spacing, overwrite=overwrite, progress=say)
    finally:
        stop()
    for note in made.notes:
        console.print(note)
    console.print(made.headline())
    first, *others = made.files
    console.print(f"{made.folder / first} (with {', '.join(others)})")
    return 0


@app.command
def link(
    scene: str,
    *,
    ranges: str | None = None,
    out: Path | None = None,
    overwrite: bool = False,
    set_: Settings | None = None,
) -> int:
    """Print a scene's link budget: echo, noise and the weakest sea against range, by the textbook and as simulated.

    Parameters
    ----------
    scene
        Path of a scene file, or the name of a shipped scene.
    ranges
        R,R,… slant ranges in metres; default a handful across the range window.
    out
        Folder for link.csv and link.png; default none.
    overwrite
        Replace earlier results in that folder.
    set_
        KEY=VALUE, any key of the scene file, as often as wanted.
    """
    loaded = scene_of(scene, set_)
    from ..products.link import write_link

    made = write_link(loaded, out, ranges=ranges, overwrite=overwrite)
    for line in made.lines:
        console.print(line)
    if made.files:
        console.print(", ".join(map(str, made.files)))
    return 0
