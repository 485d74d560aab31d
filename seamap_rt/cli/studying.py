"""Commands that study and judge: shadowing, trade and validate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..compute.machine import A_MODEL
from ..errors import InputError
from ..io.process import progress
from ..io.text import number_list
from ..lazy import judge
from .shell import (
    Count,
    KeysOfHorizon,
    Number,
    Overwrite,
    SceneName,
    Settings,
    Whole,
    about,
    command,
    console,
    scene_of,
)

FAILED = 1
Varied = Annotated[list[str], Parameter(name="--vary", negative=(), consume_multiple=False)]
Bin = Annotated[Number, Parameter(name="--bin")]
Cases = Annotated[list[str], Parameter(name="--only", negative=(), consume_multiple=False)]


@command("shadowing choppy_sea --heights 3,5,10", "shadowing mine.toml --seeds 8 --out seen")
def shadowing(
    scene: SceneName,
    *,
    heights: Annotated[str | None, about("H,H,… or START:STOP:STEP in metres; default the scene's.")] = None,
    seeds: Annotated[Count, about("Seas to draw; their spread gives the confidence bands.")] = 4,
    bin_m: Annotated[Bin, about("Metres of a range bin.")] = 10.0,
    out: Annotated[
        Path | None, about("Folder for shadowing.nc, shadowing.csv and figures; default runs/SCENE-shadowing.")
    ] = None,
    overwrite: Overwrite = False,
    set_: KeysOfHorizon = None,
) -> int:
    """How much of a scene's sea a radar sees against range, look and height, beside the analytic curves."""
    loaded = scene_of(scene, ["tracing.tracer=horizon", *(set_ or [])])
    heights_m = [loaded.radar.height_m] if heights is None else _metres(heights)
    from ..studies.shadowing import write_shadowing

    folder = out or Path("runs") / f"{loaded.name}-shadowing"
    with progress() as say:
        lines = write_shadowing(loaded, folder, heights_m, seeds, overwrite, say, bin_m)
    others = "shadowing.nc, shadowing.csv, shadowing.png, shadowing_seen.png, scene.toml"
    console.print(*lines, f"{folder / 'shadowing.html'} (with {others})", sep="\n")
    return 0


def _metres(text: str) -> list[float]:
    form = "write H,H,… or START:STOP:STEP in metres, as in 3,5,10"
    return [float(each) for each in number_list(text, f"--heights {text}", form)]


@command("outlook choppy_sea", "outlook mine.toml --vary radar.height_m=3:20:1", need=A_MODEL)
def outlook(
    scene: SceneName,
    *,
    vary: Annotated[
        Varied | None,
        about("KEY=START:STOP:STEP or KEY=VALUE,VALUE,… for a line a design, and what a trade would choose of them."),
    ] = None,
    at_most: Annotated[
        Number | None,
        about("Highest antenna (or greatest value of the key that is chosen) to recommend; says what that costs."),
    ] = None,
    set_: Annotated[Settings | None, about("KEY=VALUE, any key of the scene file.")] = None,
) -> int:
    """What a scene's radar is likely to measure, at once: a model, not a simulation."""
    loaded = scene_of(scene, set_)
    if vary:
        from ..studies.choices import outlook_lines, outlook_table, outlooks  # takes a second to load
        from ..studies.vary import parse_varies

        found = outlooks(loaded, parse_varies(vary), at_most)
        lines = [*outlook_table(found), *outlook_lines(found)]
    elif at_most is not None:
        raise InputError(f"--at-most {at_most:g}: limits what is varied; give --vary too, as radar.height_m=3:12:1")
    else:
        from ..design_outlook import estimate_outlook
        from ..design_outlook.model import outlook_rows

        lines = list(outlook_rows(estimate_outlook(loaded)))
    console.print(*lines, sep="\n")
    return 0


@command(
    "trade choppy_sea --vary radar.height_m=5,8,12 --until 0.95",
    "trade mine.toml --vary radar.height_m=3:9:2 --seeds 3 --out heights",
)
def trade(
    scene: SceneName,
    *,
    vary: Varied,
    seeds: Count = 1,
    until: Annotated[Number | None, about("Add seeds until each choice has this confidence, as 0.95.")] = None,
    budget: Annotated[str | None, about("Add seeds as long as they end in this time, as 10min.")] = None,
    at_most: Number | None = None,
    workers: Whole | None = None,
    scheduler: str | None = None,
    out: Path | None = None,
    resume: Annotated[bool, about("Go on with the points that are missing in that folder.")] = False,
    overwrite: Annotated[bool, about("Replace another sweep in that folder.")] = False,
    set_: Annotated[
        Settings | None,
        about(
            "KEY=VALUE, any key of the scene file, for all points. tracing.tracer=horizon chooses as rays do, "
            "and sooner; a coarser mesh sees too far."
        ),
    ] = None,
) -> int:
    """Run a grid of scenes and compare what each one's maps are worth; one table, one figure.

    Parameters
    ----------
    vary
        KEY=START:STOP:STEP or KEY=VALUE,VALUE,…, any key of the scene file, as often as wanted.
    seeds
        Seas and noises to draw for each point of the grid; with until or budget, to begin with.
    at_most
        Highest antenna (or greatest value of the key that is chosen) to recommend; says what that costs.
    workers
        Processes of the local cluster; default as many as fit the cores and the memory.
    scheduler
        Of a running dask cluster, instead of a local one: tls://HOST:PORT (certificates in dask's configuration),
        tcp://HOST:PORT (on a network that you trust), or its scheduler file.
    out
        Folder for the points, trade.csv, trade.nc and figures; default runs/SCENE-trade.
    """
    loaded = scene_of(scene, set_)
    from ..studies.paired import seconds
    from ..studies.sweep import write_trade
    from ..studies.vary import parse_varies

    varied, budget_s = parse_varies(vary), seconds(budget) if budget is not None else None
    with progress() as say:
        made = write_trade(
            loaded,
            out,
            varied,
            seeds=seeds,
            until=until,
            budget_s=budget_s,
            at_most=at_most,
            workers=workers,
            scheduler=scheduler,
            resume=resume,
            overwrite=overwrite,
            progress=say,
        )
    first, *others = made.files
    console.print(*made.lines, f"{made.folder / first} (with {', '.join(others)})", sep="\n")
    return 0


@command("validate", "validate --only claim_4_shadowing --out checked")
def validate(
    *,
    full: Annotated[bool, about("The long cases too.")] = False,
    only: Annotated[Cases | None, about("Names of cases, as often as wanted; default all.")] = None,
    out: Annotated[Path | None, about("Folder for validation.html and metrics.json; default runs/validation.")] = None,
    overwrite: Annotated[bool, about("Replace an earlier report in that folder.")] = False,
) -> int:
    """Hold the program against closed forms, tables, peers and the claims of 2004; exit 1 if a case fails."""
    run_cases = judge("report").validate
    with progress() as say:
        result = run_cases(out or Path("runs/validation"), full=full, only=only, overwrite=overwrite, progress=say)
    for done in result.done:
        if done.passed is False:
            console.print(f"red: {done.case.name}: {done.case.title}")
    console.print(result.summary)
    console.print(f"{result.folder / 'validation.html'} (with metrics.json)")
    return FAILED if result.failed else 0
