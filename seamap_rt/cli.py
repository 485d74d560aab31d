"""The command line: a thin shell over the package. Bad input is one line and exit 2; no usable backend, exit 3."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray as xr
from cyclopts import App, CycloptsError, Parameter
from rich.console import Console
from rich.text import Text

from . import __version__
from .account import account_lines
from .backend import NoBackend, doctor, doctor_lines
from .dataset import QUALITY_FLAGS, SchemaError
from .io.scenefile import InputError, list_shipped, read_toml

BAD_INPUT, NO_BACKEND, INTERRUPTED = 2, 3, 130

app = App(
    name="seamap-rt",
    version=__version__,
    help="What an interferometric radar on a small boat's mast can see of the sea around it.",
    suppress_keyboard_interrupt=False,  # `main` says what an interrupted run leaves
)
Names = Annotated[list[str], Parameter(name="--name", negative=(), consume_multiple=False)]
Settings = Annotated[list[str], Parameter(name="--set", negative=(), consume_multiple=False)]
_errors = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)
_out = Console(soft_wrap=True, highlight=False, markup=False)  # a path may hold [brackets]


def _overrides(pairs: list[str] | None, option: str = "--set", **direct: Any) -> dict[str, Any]:
    """KEY=VALUE strings, and options that stand for a key, as one mapping."""
    found: dict[str, Any] = {}
    for pair in pairs or []:
        key, equals, value = pair.partition("=")
        if not equals or not key.strip():
            raise InputError(f"{option} {pair}: must be KEY=VALUE, as in --set radar.height_m=10")
        found[key.strip()] = value.strip()
    return found | {key: value for key, value in direct.items() if value is not None}


def _scene(name: str, pairs: list[str] | None, **direct: Any):
    from .scene import load_scene

    return load_scene(name, overrides=_overrides(pairs, **{k.replace("__", "."): v for k, v in direct.items()}))


def _progress() -> tuple[Callable[[str], None], Callable[[], None]]:
    """A status line on a terminal, nothing elsewhere."""
    if not _errors.is_terminal:
        return (lambda _: None), (lambda: None)
    status = _errors.status("starting")
    status.start()
    return status.update, status.stop


def _headline(metrics: dict[str, Any]) -> str:
    overall = metrics.get("overall", {})

    def number(key: str, digits: int = 2) -> str:
        value = overall.get(key)
        return "—" if value is None else f"{value:.{digits}f}"

    return (
        f"50–200 m, cells more than half visible: height error {number('height_rmse_m', 3)} m rms "
        f"({number('height_robust_m', 3)} robust, bias {number('height_bias_m', 3)}), "
        f"correlation {number('height_correlation')}; visible share {number('visible_fraction')}; "
        f"4σ of their heights true {number('hs_true_m')} m, of the map's {number('hs_retrieved_m')} m"
    )


def _print_account(metrics: dict[str, Any]) -> None:
    """What was modelled and left out; on a terminal the kind of each line stands out."""
    for line in account_lines(metrics["modelled"], metrics["left_out"]):
        kind, said = line.split(": ", 1)
        _out.print(Text.assemble((f"{kind}: ", "bold" if kind == "modelled" else "dim bold"), said))


def _warn_of_folds(metrics: dict[str, Any]) -> None:
    from .report import fold_warning

    if warning := fold_warning(metrics):
        _out.print(f"flag: {warning}")


@app.command
def run(
    scene: str,
    *,
    out: Path | None = None,
    turns: int | None = None,
    seed: int | None = None,
    tracer: str | None = None,
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
    overwrite
        Replace another run's results in that folder.
    set_
        KEY=VALUE, any key of the scene file, as often as wanted.
    """
    loaded = _scene(scene, set_, turns=turns, seed=seed, tracing__tracer=tracer)
    from .runs import run as run_scene

    say, stop = _progress()
    try:
        result = run_scene(loaded, out, overwrite=overwrite, progress=say)
    finally:
        stop()
    _print_account(result.metrics)
    _out.print(_headline(result.metrics))
    _out.print(f"sea state from the maps: {result.metrics['sea_state_in_words']}")
    _warn_of_folds(result.metrics)
    _out.print(f"{result.folder / 'report.html'} (with maps.nc, truth.nc, echoes.zarr, metrics.json, scene.toml)")
    return 0


@app.command
def simulate(scene: str, *, out: Path, overwrite: bool = False, set_: Settings | None = None) -> int:
    """Simulate a scene's echoes and the truth beside them: echoes.zarr and truth.nc.

    Parameters
    ----------
    scene
        Path of a scene file, or the name of a shipped scene.
    out
        Folder for the results.
    overwrite
        Replace earlier results in that folder.
    set_
        KEY=VALUE, any key of the scene file, as often as wanted.
    """
    loaded = _scene(scene, set_)
    from .runs import prepare_folder
    from .simulation import simulate as simulate_scene

    prepare_folder(out, overwrite, ("echoes.zarr", "truth.nc"))
    say, stop = _progress()
    try:
        say(f"simulating {loaded.name}")
        simulate_scene(loaded, out, overwrite=overwrite)
    finally:
        stop()
    _out.print(f"{out / 'echoes.zarr'}, {out / 'truth.nc'}")
    return 0


@app.command
def sea(
    scene: str,
    *,
    out: Path,
    times: str = "0:5:0.5",
    side: float | None = None,
    spacing: float | None = None,
    seed: int | None = None,
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
    loaded = _scene(scene, ["tracing.tracer=horizon", *(set_ or [])], seed=seed)
    from .products import write_sea

    say, stop = _progress()
    try:
        made = write_sea(loaded, out, times=times, side=side, spacing=spacing, overwrite=overwrite, progress=say)
    finally:
        stop()
    for note in made.notes:
        _out.print(note)
    _out.print(made.headline())
    first, *others = made.files
    _out.print(f"{made.folder / first} (with {', '.join(others)})")
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
    loaded = _scene(scene, set_)
    from .products.link import write_link

    made = write_link(loaded, out, ranges=ranges, overwrite=overwrite)
    for line in made.lines:
        _out.print(line)
    if made.files:
        _out.print(", ".join(map(str, made.files)))
    return 0


@app.command
def retrieve(
    echoes: Path,
    *,
    header: Path | None = None,
    name: Names | None = None,
    out: Path | None = None,
    overwrite: bool = False,
    set_: Settings | None = None,
) -> int:
    """Heights and slopes (maps.nc) from echoes that keep the schema, or a recording. Never opens a truth file.

    Parameters
    ----------
    echoes
        A Zarr store, or a recording as .npz, .h5, .hdf5 or .nc.
    header
        Of a recording: a TOML or JSON file that describes the radar, where the recording does not.
    name
        Of a recording: ARRAY=NAME, what it calls an array, as in lower=rx/1; as often as wanted.
    out
        Folder for maps.nc; default beside the echoes.
    overwrite
        Replace an earlier maps.nc.
    set_
        retrieval.KEY=VALUE, as often as wanted.
    """
    from .interferometry import retrieve as retrieve_echoes
    from .interferometry import sea_state
    from .interferometry.sea_state import in_words
    from .io.scenefile import apply_overrides, validate
    from .io.turnfile import TurnFile
    from .runs import clear_folder, prepare_folder
    from .settings import RetrievalSettings

    overrides = _overrides(set_)
    for key in overrides:
        if not key.startswith("retrieval."):
            raise InputError(f"--set {key}: retrieve takes only retrieval.KEY, as in --set retrieval.cell_range_m=3")
    tree = apply_overrides({}, {key.removeprefix("retrieval."): value for key, value in overrides.items()})
    try:
        settings = validate(RetrievalSettings, tree)
    except InputError as error:
        raise InputError(f"retrieval.{error}") from None
    if not echoes.exists():
        raise InputError(f"ECHOES = '{echoes}': no such file or folder; give the path of an echoes.zarr")
    folder = out or echoes.parent
    prepare_folder(folder, overwrite, ("maps.nc",))
    recorded = _opened(echoes, header, name)
    maps = retrieve_echoes(recorded, settings)
    clear_folder(folder, ("maps.nc",))
    with TurnFile(folder / "maps.nc") as file:
        for turn in range(maps["polar"].sizes["turn"]):
            file.append(maps.isel(turn=slice(turn, turn + 1)))
    for line in _answered(maps):
        _out.print(line)
    _out.print(f"sea state: {in_words(sea_state(maps), -1)}")
    _out.print(str(folder / "maps.nc"))
    return 0


def _opened(echoes: Path, header: Path | None, name: list[str] | None) -> xr.Dataset:
    """Echoes from a store, or from a recording and its header."""
    from .interferometry import open_echoes, open_recording
    from .io.recorded import RECORDING_ENDINGS

    try:
        if echoes.suffix.lower() in RECORDING_ENDINGS:
            return open_recording(echoes, header, _overrides(name, "--name"))
        if header is None:
            return open_echoes(echoes)
        raise InputError(f"--header {header}: goes with a recording ({', '.join(RECORDING_ENDINGS)}); leave it out")
    except (SchemaError, InputError):
        raise
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"ECHOES = '{echoes}': is not an echo store ({error}); give an echoes.zarr") from None


def _answered(maps: xr.DataTree) -> list[str]:
    """How much of the maps holds heights, and what kept the rest from it, if that is all."""
    polar = maps["polar"].to_dataset()
    known = np.isfinite(polar["height"].values)
    if known.any():
        spread = float(np.median(polar["height_std"].values[known]))
        return [f"{known.mean():.0%} of the cells answered, median error bar {spread:.3f} m"]
    flags = polar["quality"].values
    shares = {name: float(np.mean((flags & bit) != 0)) for name, bit in QUALITY_FLAGS.items()}
    said = ", ".join(f"{name} {share:.0%}" for name, share in shares.items() if share > 0.0)
    return [f"flag: no cell answered ({said})"]


@app.command
def scenes() -> int:
    """List the shipped scenes, a line each."""
    for name, path in list_shipped().items():
        _out.print(f"{name:20} {read_toml(path).get('title', '')}")
    return 0


@app.command(name="doctor")
def doctor_command() -> int:
    """Tell which backend is used, what was found, and what mends what is missing."""
    for line in doctor_lines():
        _out.print(line)
    return 0 if all(check.ok for check in doctor() if check.item == "backend") else NO_BACKEND


def _terminated(*_: object) -> None:
    raise KeyboardInterrupt


def main(arguments: list[str] | None = None) -> None:
    """Entry point of `seamap-rt`."""
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
        what = f"'{error.filename}': {error.strerror}" if error.filename else " ".join(str(error).split())
        code = _refuse(f"{what}; free the space or choose another --out", BAD_INPUT)
    except CycloptsError as error:
        code = _refuse(" ".join(str(error).split()), BAD_INPUT)
    sys.stdout.flush()
    sys.exit(code if isinstance(code, int) else 0)


def _refuse(line: str, code: int) -> int:
    print(f"seamap-rt: {line}", file=sys.stderr)
    return code


if __name__ == "__main__":
    os.environ.setdefault("COLUMNS", "120")
    main()
