"""Commands that simulate: run, simulate, sea and link."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rich.text import Text

from ..compute.machine import A_MODEL
from ..errors import InputError
from ..io.process import progress
from .shell import (
    Count,
    KeysOfHorizon,
    Number,
    Overwrite,
    SceneKeys,
    SceneName,
    Seed,
    StreamFormat,
    StreamTo,
    Tracer,
    Turns,
    about,
    command,
    console,
    scene_of,
    streaming,
)

if TYPE_CHECKING:
    from ..scene import Scene


def _headline(metrics: dict[str, Any]) -> str:
    from ..conventions import written
    from ..report.headline import metres, wave_height  # takes a second

    overall = metrics.get("overall", {})

    def number(key: str, digits: int = 2) -> str:
        value = overall.get(key)
        return "—" if value is None else written(value, digits)

    band = overall.get("range_m")
    at = f"{band[0]:.0f}–{band[1]:.0f} m" if band else "50–200 m"
    return (
        f"{at}, cells more than half visible: height error {number('height_rmse_m', 3)} m rms "
        f"({number('height_robust_m', 3)} robust, bias {number('height_bias_m', 3)}), "
        f"correlation {number('height_correlation')}; visible share {number('visible_fraction')}; "
        f"Hs of the scene {metres(metrics.get('hs_scene_m'), 2)}, from the maps {wave_height(metrics)}"
    )


def describe_record(scene: Scene) -> None:
    """Before anything runs, how far a recorded sea reaches."""
    if scene.sea.model == "recorded":
        from ..scene.radar_checks import record_notes

        console.print(*record_notes(scene.sea, scene.radar), sep="\n")


@command("run choppy_sea", "run mine.toml --turns 3 --set radar.height_m=8 --out runs/8m")
def run(
    scene: Annotated[str, about("Path of a scene file, or the name of a shipped scene (see `scenes`).")],
    *,
    out: Annotated[Path | None, about("Folder for the results; default runs/SCENE-SEED.")] = None,
    turns: Turns = None,
    seed: Seed = None,
    tracer: Tracer = None,
    predict: Annotated[bool, about("Forecast the sea beside the run, from its maps: prediction.nc.")] = False,
    account: Annotated[
        bool, about("Print what was modelled, with its cost, and what was left out, with its error.")
    ] = False,
    stream: StreamTo = None,
    stream_format: StreamFormat = None,
    overwrite: Annotated[bool, about("Replace another run's results in that folder.")] = False,
    set_: SceneKeys = None,
) -> int:
    """Simulate a scene, retrieve its heights, compare them with the truth, and draw a report."""
    if stream is not None and not predict:
        raise InputError(f"--stream {stream}: sends forecasts; give --predict too")
    loaded = scene_of(scene, set_, turns=turns, seed=seed, tracing__tracer=tracer)
    describe_record(loaded)
    from ..session.report_process import ReportProcess, is_compiled

    with streaming(stream, stream_format) as to, ReportProcess() as draw, progress() as say:
        from ..report.headline import forecast_line, verdict, warnings, window_line  # a second, beside that process's
        from ..session import Stream
        from ..session import run as run_scene

        also = "" if is_compiled() else " (compiling, once)"
        options = {"progress": lambda line: say(line + also), "draw": draw}
        sent = None if to is None else Stream(to, stream_format or "json")
        result = run_scene(loaded, out, predict=predict, overwrite=overwrite, stream=sent, **options)
    if words := verdict(result.metrics):
        console.print(words)
    console.print(_headline(result.metrics))
    console.print(f"sea state from the maps: {result.metrics['sea_state_in_words']}")
    if predict:
        console.print(forecast_line(result.metrics))
        if line := window_line(result.metrics):
            console.print(line)
    for warning in warnings(result.metrics):
        console.print(f"flag: {warning}")
    if account:
        from ..report.limits import account_lines

        for line in account_lines(result.metrics["modelled"], result.metrics["left_out"]):
            kind, rest = line.split(": ", 1)
            console.print(Text.assemble((f"{kind}: ", "bold" if kind == "modelled" else "dim bold"), rest))
    else:
        console.print("what was modelled and what was left out: the report, or --account")
    console.print(f"{result.folder / 'report.html'} (with maps.nc, truth.nc, run.zarr, metrics.json, scene.toml)")
    return 0


@command("simulate tiny --out tiny", "simulate mine.toml --out night --turns 60 --seed 2")
def simulate(
    scene: SceneName,
    *,
    out: Annotated[Path, about("Folder for the results.")],
    turns: Turns = None,
    seed: Seed = None,
    tracer: Tracer = None,
    overwrite: Overwrite = False,
    set_: SceneKeys = None,
) -> int:
    """Simulate a scene's echoes and the truth beside them: run.zarr and truth.nc."""
    loaded = scene_of(scene, set_, turns=turns, seed=seed, tracing__tracer=tracer)
    describe_record(loaded)
    from ..session import simulate as simulate_scene

    with progress() as say:
        say("sea: drawing it, and preparing the tracer")
        simulate_scene(loaded, out, overwrite=overwrite, progress=say)
    console.print(f"{out / 'run.zarr'}, {out / 'truth.nc'}")
    return 0


@command("sea choppy_sea --out sea --times 0:5:0.5", "sea mine.toml --out steep --nonlinear --times 0:60:0.25")
def sea(
    scene: SceneName,
    *,
    out: Annotated[Path, about("Folder for the results.")],
    times: str | None = None,
    side: Number | None = None,
    spacing: Number | None = None,
    nonlinear: bool = False,
    order: Annotated[Count | None, about("Of the nonlinear sea in the steepness, 1 (linear) to 5; default 3.")] = None,
    resume: Annotated[bool, about("Go on with a nonlinear sea that a kill or Ctrl-C stopped.")] = False,
    seed: Seed = None,
    overwrite: Overwrite = False,
    set_: KeysOfHorizon = None,
) -> int:
    """Write a scene's sea itself: heights, slopes, velocities and radar cross-sections in time, and pictures of them.

    With --nonlinear: heights and surface potential of a nonlinear sea that begins as the scene's waves, to be used as a
    recorded sea as often as wanted.

    Parameters
    ----------
    times
        START:STOP:STEP or T,T,… in seconds, default 0:5:0.5; write --times=-5:0:1 for times before 0. Of a nonlinear
        sea even ones, default 0:60:0.25.
    side
        Of the square of points around the antenna, m; default the range circle. A nonlinear sea has the whole patch.
    spacing
        Of the points, m; default what is resolved, at most 512 points a side. Of a nonlinear sea: half the shortest
        wave, m; default 8 wavenumbers of the steepest system's peak, or what is resolved where that is coarser.
    nonlinear
        Write recorded_sea.nc, a nonlinear sea by the high-order spectral method.
    """
    if nonlinear and side is not None:
        raise InputError("--side: a nonlinear sea fills its patch; leave it out, or set sea.extent_m")
    if not nonlinear and (order is not None or resume):
        raise InputError(f"{'--order' if order is not None else '--resume'}: is of a nonlinear sea; give --nonlinear")
    loaded = scene_of(scene, ["tracing.tracer=horizon", *(set_ or [])], seed=seed)
    if times is not None:
        from ..products.sampling import times_of

        times_of(times)  # is refused before the second in which the rest is loaded
    given: dict[str, Any] = {} if times is None else {"times": times}
    with progress() as say:
        given |= {"spacing": spacing, "overwrite": overwrite, "progress": say}
        if nonlinear:
            from ..products.recorded_sea import write_recorded_sea

            given |= {} if order is None else {"order": order}
            record = write_recorded_sea(loaded, out, resume=resume, **given)
            files, notes, headline = record.file, record.notes, record.headline()
        else:
            from ..products.writing import write_sea

            made = write_sea(loaded, out, side=side, **given)
            files = f"{made.folder / made.files[0]} (with {', '.join(made.files[1:])})"
            notes, headline = made.notes, made.headline()
    console.print(*notes, headline, files, sep="\n")
    return 0


@command("link choppy_sea", "link mine.toml --ranges 50,100,200 --out link", need=A_MODEL)
def link(
    scene: SceneName,
    *,
    ranges: Annotated[
        str | None, about("R,R,… slant ranges in metres; default a handful across the range window.")
    ] = None,
    out: Annotated[Path | None, about("Folder for link.csv and link.png; default none.")] = None,
    overwrite: Overwrite = False,
    set_: SceneKeys = None,
) -> int:
    """Print a scene's link budget: echo, noise and the weakest sea against range, by the textbook and as simulated."""
    loaded = scene_of(scene, set_)
    from ..products.link import write_link

    made = write_link(loaded, out, ranges=ranges, overwrite=overwrite)
    console.print(*made.lines, sep="\n")
    if made.files:
        console.print(", ".join(map(str, made.files)))
    return 0
