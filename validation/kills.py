"""What do killed commands leave? Each is stopped at a random instant; what is left is read, mended and gone on with.

python -m validation.kills [--kills 120] [--seed 1] [--only COMMAND]

Commands: `run` with rays, `run` with the horizon tracer, `retrieve` of that run's echoes, `sea` with a nonlinear sea,
`trade` on two processes, `validate` with short cases.
Signals: SIGKILL, SIGTERM, SIGINT. The instants are uniform over the time that the command takes when it is left alone.
After each:

- after SIGTERM and SIGINT: exit code 130 and one line on stderr, or the command had ended, with 0 and none;
- after SIGKILL of a run that had begun to write: the next one is refused in a line that names `recover`, which works,
  or `--resume`;
- by its own name each product opens, all of a run hold as many turns, and these have the bits of the run left alone;
- the same command again (`trade` and `sea` with --resume where they can) gives the same bits as when left alone;
- no process of it lives on, and nothing is left in the temporary folder or hidden beside the results.

The runs draw no pictures: these take most of the time, and are drawn when what grows is closed. And their start is that
of `trade` and `validate`, so they begin with part of the modules loaded. Exit 1 where any of this fails.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import xarray as xr

from seamap_rt.cli import main as seamap_rt

from .same import PRODUCTS, arrays

KILL, TERM, INT = signal.SIGKILL, signal.SIGTERM, signal.SIGINT
_SMALL = {"radar.sector_deg": "[260,275]", "radar.range_m": "[15,60]", "sea.extent_m": "180"}
_CASES = ("slopes_of_the_sea", "tilted_plane", "wavespectra_library", "dispersion_of_the_sea")
_TURNS = 6
_ECHOES = "recorded/run.zarr"
_LIMIT_S = 120.0  # of a command, and of what lives on after it: 10 s
_ORPHANS_S = 10.0
_FIRST_S = 0.005  # after the program says that it begins: its handlers are set by then
# Minds Ctrl-C even where it runs in the background, and says when it begins.
_PROGRAM = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
told = int(sys.argv.pop(1))
if sys.argv[1] in ("run", "retrieve"):
    from seamap_rt.report import page
    page.pictures = lambda *_: ()
from seamap_rt.cli import main
os.write(told, b"!")
main()
"""


@dataclass(frozen=True)
class Command:
    """A command of `seamap-rt` that is stopped. arguments: all but --out. again: those that go on with what is left."""

    name: str
    arguments: tuple[str, ...]
    bits: Callable[[Path], dict[str, Any]]  # what of its folder must be the same each time
    partial: Callable[[Path, dict[str, Any]], Iterator[str]]  # what is wrong with a folder that holds a part of it
    again: Callable[[Path], tuple[str, ...]]

    def line(self, out: Path, *more: str) -> list[str]:
        return [*self.arguments, *more, "--out", str(out)]


@dataclass
class Fate:
    """What became of one kill: how much was whole, and what was wrong."""

    command: str
    signal: str
    instant_s: float
    whole: str
    wrong: list[str] = field(default_factory=list)


# ------------------------------------------------------------------------------------------------- the commands


def _settings(**more: str) -> tuple[str, ...]:
    pairs = _SMALL | {key.replace("__", "."): value for key, value in more.items()}
    return tuple(part for key, value in pairs.items() for part in ("--set", f"{key}={value}"))


def commands(home: Path, turns: int = _TURNS) -> dict[str, Command]:
    """The commands by name. home: of the run whose echoes are retrieved, see `record`."""
    run = ("run", "tiny", "--turns", str(turns))
    wrong_run = partial(_wrong_run, PRODUCTS)
    trade = ("trade", "tiny", *_settings(tracing__tracer="horizon"), "--vary", "radar.height_m=4,6", "--seeds", "2")
    cases = tuple(part for case in _CASES for part in ("--only", case))
    sea = ("sea", "tiny", "--nonlinear", "--order", "2", "--times", "0:30:0.25")
    return {
        each.name: each
        for each in (
            Command("run, rays", (*run, *_settings(tracing__tracer="facets")), _run_bits, wrong_run, _anew),
            Command("run, horizon", (*run, *_settings(tracing__tracer="horizon")), _run_bits, wrong_run, _anew),
            Command("retrieve", ("retrieve", str(home / _ECHOES)), _map_bits, partial(_wrong_run, ("maps.nc",)), _anew),
            Command("sea", sea, _sea_bits, _wrong_sea, _continue_sea),
            Command("trade", (*trade, "--workers", "2"), _trade_bits, _wrong_trade, _go_on),
            Command("validate", ("validate", *cases), _validate_bits, _wrong_validation, _anew),
        )
    }


def record(home: Path) -> None:
    """Make the echoes that are retrieved."""
    code, _, said = call(("run", "tiny", "--turns", str(_TURNS), *_settings(), "--out", str((home / _ECHOES).parent)))
    if code:
        raise RuntimeError(f"run: ended with {code}: {said}")


def _run_bits(out: Path) -> dict[str, Any]:
    return dict(arrays(out))


def _map_bits(out: Path) -> dict[str, Any]:
    return dict(arrays(out, ("maps.nc",)))


def _wrong_run(names: tuple[str, ...], out: Path, alone: dict[str, Any]) -> Iterator[str]:
    """The products that are there have one number of turns, and the bits of the run left alone."""
    there = [name for name in names if (out / name).exists()]
    if not there:
        if (out / "scene.toml").exists():
            yield "scene.toml without results"
        return
    if len(there) < len(names):
        yield f"only {', '.join(there)}"
        return
    found = dict(arrays(out, names))
    turns = {name: len(np.unique(values)) for name, values in found.items() if name.endswith(" turn")}
    if len(set(turns.values())) > 1 or 0 in turns.values():
        yield f"unlike numbers of turns: {turns}"
    for name, values in found.items():
        expected = alone[name][: len(values)] if np.ndim(values) else alone[name]
        if not _equal(values, expected):
            yield f"{name}: other bits"
    if (out / "metrics.json").exists():
        json.loads((out / "metrics.json").read_text(encoding="utf-8"))


def _sea_bits(out: Path) -> dict[str, Any]:
    with xr.open_dataset(out / "recorded_sea.nc") as sea:
        return {str(name): values.values for name, values in sea.variables.items()}


def _wrong_sea(out: Path, alone: dict[str, Any]) -> Iterator[str]:
    """What is there of the sea has the bits of the one left alone."""
    if (out / "recorded_sea.nc").exists():
        times = len(alone["time"])
        for name, values in _sea_bits(out).items():
            grows = np.ndim(alone[name]) and len(alone[name]) == times
            if not _equal(values, alone[name][: len(values)] if grows else alone[name]):
                yield f"{name}: other bits"


def _continue_sea(out: Path) -> tuple[str, ...]:
    return ("--resume",) if list(out.glob(".recorded_sea.state*")) else ("--overwrite",)


def _trade_bits(out: Path) -> dict[str, Any]:
    from seamap_rt.studies.trade_table import COST

    with xr.open_dataset(out / "trade.nc") as table:
        return {str(name): values.values for name, values in table.drop_vars(COST).variables.items()}


def _wrong_trade(out: Path, _: dict[str, Any]) -> Iterator[str]:
    """Each point's file is whole, and so is the table."""
    for path in out.glob("points/[0-9]*.json"):
        json.loads(path.read_text(encoding="utf-8"))
    if (out / "trade.nc").exists():
        _trade_bits(out)
    yield from ()


def _anew(_: Path) -> tuple[str, ...]:
    return ("--overwrite",)


def _go_on(out: Path) -> tuple[str, ...]:
    return ("--resume",) if (out / "trade.json").exists() else ()


def _validate_bits(out: Path) -> dict[str, Any]:
    cases = json.loads((out / "metrics.json").read_text(encoding="utf-8"))["cases"]
    return {name: case["checks"] for name, case in cases.items()}


def _wrong_validation(out: Path, alone: dict[str, Any]) -> Iterator[str]:
    """What is there is whole and the same."""
    if (out / "metrics.json").exists():
        yield from (f"{name}: other checks" for name, checks in _validate_bits(out).items() if checks != alone[name])
    if (out / "validation.html").exists() and "</html>" not in (out / "validation.html").read_text(encoding="utf-8"):
        yield "validation.html is cut off"


def _equal(values: Any, expected: Any) -> bool:
    if isinstance(values, np.ndarray):
        nan = values.dtype.kind in "fc"
        return values.dtype == expected.dtype and np.array_equal(values, expected, equal_nan=nan)
    return bool(values == expected)


# ------------------------------------------------------------------------------------------------------ the kills


def call(arguments: Sequence[str]) -> tuple[int, str, str]:
    """A command in this process: exit code, stdout, stderr."""
    out, err = io.StringIO(), io.StringIO()
    plain = mock.patch("seamap_rt.report.page.pictures", return_value=())
    with plain, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            seamap_rt(list(arguments))
            code = 0
        except SystemExit as end:
            code = int(end.code or 0)
    return code, out.getvalue(), err.getvalue()


@contextlib.contextmanager
def begun(arguments: Sequence[str], temporary: Path) -> Iterator[subprocess.Popen[str]]:
    """A command in a process and a session of its own, once its program begins."""
    ready, told = os.pipe()
    process = subprocess.Popen(
        [sys.executable, "-c", _PROGRAM, str(told), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"TMPDIR": str(temporary)},
        pass_fds=(told,),
        start_new_session=True,
    )
    os.close(told)
    try:
        os.read(ready, 1)
        yield process
    finally:
        os.close(ready)
        if process.poll() is None:
            os.killpg(process.pid, KILL)
            process.communicate()


def left_alone(command: Command, folder: Path) -> tuple[dict[str, Any], float]:
    """The bits of a command that nobody stops, and how long it takes once its program begins."""
    with begun(command.line(folder / "out"), _made(folder / "tmp")) as process:
        start = time.monotonic()
        _, complaints = process.communicate(timeout=_LIMIT_S)
    if process.returncode != 0 or complaints:
        raise RuntimeError(f"{command.name}: ended with {process.returncode} when left alone: {complaints}")
    return command.bits(folder / "out"), time.monotonic() - start


def kill(command: Command, number: signal.Signals, instant_s: float, alone: dict[str, Any], folder: Path) -> Fate:
    """Stop a command at an instant, and look at all that is left."""
    fate, out, temporary = Fate(command.name, number.name, instant_s, ""), folder / "out", _made(folder / "tmp")
    with begun(command.line(out), temporary) as process:
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_FIRST_S + instant_s)
        process.send_signal(number)
        _, said = process.communicate(timeout=_LIMIT_S)
    fate.wrong += [f"process {pid} lives on" for pid in _orphans(process.pid)]
    fate.wrong += _wrong_end(number, process.returncode, said)
    before, tempfile.tempdir = tempfile.tempdir, str(temporary)
    try:
        if number is KILL and process.returncode != 0:
            fate.wrong += _mended(command, out)
        fate.wrong += _guarded(command.partial, out, alone)
        fate.whole = _whole(out)
        code, _, complaints = call(command.line(out, *command.again(out)))
        if code or complaints:
            fate.wrong.append(f"again: ended with {code}: {complaints}")
        elif not _same(command.bits(out), alone):
            fate.wrong.append("again: other bits")
    finally:
        tempfile.tempdir = before
    fate.wrong += [f"left in the temporary folder: {path.name}" for path in temporary.iterdir()]
    fate.wrong += [f"left hidden: {path.relative_to(out)}" for path in out.rglob(".*")]
    return fate


def _wrong_end(number: signal.Signals, code: int, said: str) -> Iterator[str]:
    if number is KILL:
        if code not in (0, -KILL) or "Traceback" in said:  # Python itself may speak of semaphores that a kill left
            yield f"ended with {code}: {said}"
    elif not ((code == 0 and not said) or (code == 130 and said.startswith("seamap-rt: interrupted: "))):
        yield f"ended with {code}: {said}"
    elif said.count("\n") > 1:
        yield f"more than a line: {said}"


def _mended(command: Command, out: Path) -> Iterator[str]:
    """What a run left unfinished is refused by the next run, and mended by `recover`."""
    if not (out / ".seamap-rt.unfinished").exists():
        return
    code, _, said = call(command.line(out))
    if code != 2 or said.count("\n") != 1 or not ("seamap-rt recover" in said or "--resume goes on" in said):
        yield f"the next run: ended with {code}: {said}"
    if "--resume" in said:
        return
    code, _, said = call(["recover", str(out)])
    if code or said:
        yield f"recover: ended with {code}: {said}"


def _guarded(look: Callable[[Path, dict[str, Any]], Iterator[str]], out: Path, alone: dict[str, Any]) -> list[str]:
    try:
        return list(look(out, alone))
    except Exception as error:
        return [f"cannot be read: {type(error).__name__}: {error}"]


def _whole(out: Path) -> str:
    """How far it had come."""
    if (out / "maps.nc").exists() and not (out / "metrics.json").exists():
        with xr.open_datatree(out / "maps.nc") as maps:
            return f"{maps['polar'].sizes['turn']} turns"
    if (out / "recorded_sea.nc").exists():
        with xr.open_dataset(out / "recorded_sea.nc") as sea:
            return f"{sea.sizes['time']} times"
    if (out / "points").exists():
        return f"{len(list(out.glob('points/[0-9]*.json')))} points"
    return "all" if (out / "metrics.json").exists() else "nothing"


def _same(found: dict[str, Any], alone: dict[str, Any]) -> bool:
    return found.keys() == alone.keys() and all(_equal(found[name], alone[name]) for name in alone)


def _orphans(session: int) -> list[int]:
    """Processes of a session that outlive it by more than they should."""
    limit = time.monotonic() + _ORPHANS_S
    while living := _members(session):
        if time.monotonic() > limit:
            return living
        time.sleep(0.05)
    return []


def _members(session: int) -> list[int]:
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, _, member_of, *_ = stat.read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
            if int(member_of) == session and state != "Z":
                found.append(int(stat.parent.name))
    return found


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True)
    return folder


# -------------------------------------------------------------------------------------------------------- the sum


def kills(
    chosen: Sequence[Command],
    number: int,
    seed: int,
    home: Path,
    signals: Sequence[signal.Signals] = (KILL, TERM, INT),
    say: Callable[[str], None] = lambda _: None,
) -> list[Fate]:
    """So many kills, spread evenly over commands and signals, at instants that the seed draws."""
    drawn, fates = random.Random(seed), list[Fate]()
    if any(command.name == "retrieve" for command in chosen):
        record(home)
    known = {command.name: left_alone(command, home / f"alone-{place}") for place, command in enumerate(chosen)}
    for place in range(number):
        command, signalled = chosen[place % len(chosen)], signals[place // len(chosen) % len(signals)]
        alone, seconds = known[command.name]
        folder = home / f"kill-{place}"
        fate = kill(command, signalled, drawn.uniform(0.0, seconds), alone, folder)
        fates.append(fate)
        say(
            f"{place + 1:4} {fate.command:13} {fate.signal:8} {fate.instant_s:6.2f} of {seconds:.2f} s  "
            f"{fate.whole:9} {fate.wrong or ''}"
        )
        shutil.rmtree(folder)
    return fates


def table(fates: Sequence[Fate]) -> Iterator[str]:
    """A line for each command and signal, and all."""
    yield "| command | signal | kills | failed | whole when it was stopped |"
    yield "|---|---|---|---|---|"
    for command, name in dict.fromkeys((fate.command, fate.signal) for fate in fates):
        these = [fate for fate in fates if (fate.command, fate.signal) == (command, name)]
        whole = ", ".join(f"{what} × {count}" for what, count in sorted(Counter(fate.whole for fate in these).items()))
        yield f"| {command} | {name} | {len(these)} | {sum(bool(fate.wrong) for fate in these)} | {whole} |"
    yield f"| all | | {len(fates)} | {sum(bool(fate.wrong) for fate in fates)} | |"


def main() -> None:
    every = commands(Path())
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1, help="of the instants")
    parser.add_argument("--only", choices=every, action="append", help="a command, as often as wanted")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="seamap-rt-kills-") as home:
        chosen = [each for name, each in commands(Path(home)).items() if name in (arguments.only or every)]
        fates = kills(chosen, arguments.kills, arguments.seed, Path(home), say=lambda line: print(line, flush=True))
    print("\n**stops at random instants**\n")
    for line in table(fates):
        print(line)
    sys.exit(1 if any(fate.wrong for fate in fates) else 0)


if __name__ == "__main__":
    main()
