"""The figures that the READMEs quote: which study makes each, its result on file, and what is older than its subject.

python -m validation.evidence [--only NAME]… [--kind debug]… [--within MINUTES] [--draw N] [--again] [--list] [--stale]

Each study of STUDIES runs as a process of its own; what it prints becomes `validation/results/NAME.json` (version,
commit, command, draw, machine, date, seconds, and its tables: title, columns, rows) and `NAME.md`, as soon as it ends.
A result whose subject has not changed since is kept, unless --again; commits that say "(no bit changed)" change none,
and those of CHANGED the packages that stand there: `python -m validation.same OLD NEW` shows whether they do. --draw N
prints what `validate` studies find on scenes drawn from N, and leaves the results on file.

    debug      cases whose answers are known: closed forms, published tables, exact solvers
    validate   scenes drawn from a number, on which nothing was tuned
    scene      shipped or named scenes, with seeds on which nothing was tuned
    time       seconds and bytes

A result of `"carried": true` was measured by the commit and at the date that it states, and not since.
"""

from __future__ import annotations

import argparse
import json
import re
import shlex
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Any

from .report.environment import Environment

ROOT = Path(__file__).parents[1]
RESULTS = Path(__file__).parent / "results"
README = Path(__file__).parent / "README.md"
KINDS = ("debug", "validate", "scene", "time")
NUMBER = re.compile(r"[−+-]?\d[\d,]*(?:\.\d+)?(?:e[−+-]?\d+)?|[−+-]?\.\d+")


@dataclass(frozen=True)
class Study:
    """command: a module below `validation` and its arguments, {draw} where a number is drawn from. subject: files or
    packages below `seamap_rt` that it judges. draw: the number of the result on file."""

    kind: str
    command: str
    subject: str
    draw: int | None = None

    def words(self, draw: int | None, out: str = "DIR") -> list[str]:
        """The command line after `python`; out: a folder for what else it writes."""
        home = "" if self.command.startswith("seamap_rt") else "validation."
        return ["-m", *shlex.split(home + self.command.format(draw=draw, out=out))]

    @property
    def files(self) -> list[str]:
        return [f"seamap_rt/{each}" for each in self.subject.split()]


_RADAR = "sea tracing scattering echoes radar"
_MAPS = f"{_RADAR} interferometry"
_AHEAD = f"{_MAPS} prediction wavefield"

STUDIES: dict[str, Study] = {
    # maps
    "maps": Study("scene", "retrieval.maps --only accuracy,floor,errorbars,slopes", _MAPS),
    "phase_cycles": Study("scene", "retrieval.maps --only ambiguity", _MAPS),
    "bars": Study("validate", "retrieval.bars --draw {draw}", _MAPS, 977),
    "slopes": Study("scene", "retrieval.slopes", _MAPS),
    "slopes_drawn": Study("validate", "retrieval.slopes --draw {draw} --of seas,radars", _MAPS, 962),
    "seas": Study("scene", "retrieval.seas", _MAPS),
    "hidden": Study("validate", "retrieval.hidden --draw {draw}", _MAPS, 981),
    "sea_state": Study("validate", "sea.sea_state --draw {draw}", f"{_MAPS} wavefield", 944),
    "sea_state_long": Study("validate", "sea.sea_state --draw {draw} --of long --count 30", f"{_MAPS} wavefield", 945),
    "sea_state_seeds": Study("scene", "sea.sea_state --seeds 17 18", f"{_MAPS} wavefield"),
    "finite_depth": Study("debug", "sea.finite_depth", "wavefield physics"),
    "sensors": Study("validate", "retrieval.sensors --draw {draw}", _MAPS, 982),
    "recorded_data": Study("debug", "retrieval.recorded_data", "io interferometry"),
    "inspected": Study("debug", "retrieval.inspected", "inspection interferometry"),
    "spoilt": Study("debug", "retrieval.spoilt", "inspection interferometry io"),
    # the sea
    "water": Study("debug", "sea.water", "sea"),
    "recorded_seas": Study("debug", "sea.recorded_seas", "sea io"),
    "recorded_patches": Study("scene", "sea.recorded_patches", _MAPS),
    "wave_statistics": Study("debug", "sea.wave_statistics", "sea/high_order"),
    "high_order": Study("time", "sea.high_order", "sea/high_order"),
    "sea_speed": Study("time", "sea.sea_speed", "sea"),
    # scattering
    "nrcs": Study("debug", "scattering.nrcs", "scattering"),
    "nrcs_wind": Study("debug", "scattering.nrcs --wind", "scattering"),
    "doppler": Study("debug", "scattering.doppler", "scattering echoes"),
    "texture": Study("debug", "scattering.texture", "scattering echoes tracing sea"),
    "sea_spikes": Study("scene", "scattering.sea_spikes", "scattering echoes"),
    # light and shadow
    "paths": Study("debug", "light.paths", "tracing"),
    "detail": Study("debug", "light.detail", "mesh tracing echoes"),
    "share": Study("debug", "light.share", "mesh tracing"),
    "unresolved": Study("debug", "light.unresolved", "tracing mesh"),
    "unresolved_echoes": Study("debug", "light.unresolved --echoes", "tracing mesh echoes"),
    "unresolved_profiles": Study("debug", "light.unresolved_profiles", "tracing"),
    "wave_shadows": Study("debug", "light.wave_shadows", "tracing"),
    "diffraction": Study("debug", "light.diffraction --columns 80", "tracing physics"),
    "height_bias": Study("debug", "light.height_bias --profiles 6 --seed 92", "tracing/diffraction.py physics"),
    "half_visible": Study("debug", "light.half_visible --profiles 10 --seed 43", "tracing/visibility.py studies"),
    "hard_cases": Study("debug", "hard_cases.report --full", _MAPS),
    # the radar
    "truncation": Study("debug", "radar.neglected_power --of sides", "echoes"),
    "between_nodes": Study("debug", "radar.neglected_power --of nodes", "echoes"),
    "modes": Study("scene", "radar.modes --seeds 3", _MAPS),
    "transmitters": Study("scene", "radar.transmitters --seeds 3", _MAPS),
    "riding": Study("scene", "radar.riding --seeds 3", _MAPS),
    "waveforms": Study("scene", "radar.waveforms --seeds 1", _MAPS),
    "digital": Study("debug", "radar.digital", "radar"),
    # forecasts
    "forecasts": Study("scene", "prediction.forecasts --seeds 6 --first 601 --only choppy_sea", _AHEAD),
    "forecasts_drawn": Study("validate", "prediction.forecasts --draw {draw}", _AHEAD, 951),
    "nonlinear_seas": Study("scene", "prediction.nonlinear_seas {out} --seeds 813", f"{_AHEAD} io"),
    "windows": Study("scene", "prediction.windows --seeds 12 --first 611 --turns 30", _AHEAD),
    "windows_drawn": Study("validate", "prediction.windows --draw {draw}", _AHEAD, 943),
    "designers": Study("scene", "prediction.designers", _AHEAD),
    "advice": Study("scene", "prediction.advice --first 771 --seeds 4", _AHEAD),
    "advice_radar": Study("scene", "prediction.advice --radar --first 775 --seeds 2 --minutes 3", _AHEAD),
    "blur": Study("debug", "prediction.blur", "interferometry prediction"),
    "buoys": Study("validate", "prediction.buoys", "prediction"),
    # how far it sees
    "shadowing": Study("scene", "seamap_rt.cli shadowing choppy_sea --heights 3,5,10 --out {out}", "tracing studies"),
    "trade": Study("scene", "claims.trade_heights", "studies metrics.py interferometry echoes"),
    "outlook": Study("validate", "claims.outlook --first 5001 --designs 40 --masts", "design_outlook"),
    "gauges": Study("scene", "retrieval.gauges", "gauges.py interferometry echoes"),
    "trade_visible": Study("scene", "claims.trade_visible --seeds 2", "tracing visible_share.py studies"),
    "hidden_heights": Study("debug", "light.hidden_heights", "tracing/diffraction.py"),
    "partly_shadowed": Study("scene", "retrieval.partly_shadowed", _MAPS),
    # a design study's claims
    "claims_radar": Study("debug", "claims.radar", "radar"),
    "claims_shadowing": Study("debug", "claims.shadowing", "tracing studies"),
    "claims_maps": Study("scene", "claims.maps", _MAPS),
    "claims_sampling": Study("scene", "claims.sampling", _MAPS),
    # the program's answers
    "validate": Study("debug", "seamap_rt.cli validate --full --out {out}", f"{_AHEAD} studies"),
    "plants": Study("debug", "plants", f"{_AHEAD} studies"),
    "fuzz": Study("debug", "fuzz", "io scene settings"),
    "fuzz_turns": Study("debug", "fuzz.turns", _MAPS),
    "fuzz_hiding": Study("debug", "fuzz.hiding", "tracing"),
    "fuzz_declarations": Study("debug", "fuzz.declarations", "io"),
    "kills": Study("debug", "kills --kills 36 --seed 57", "session io studies"),
    "limits": Study("debug", "hard_cases.limits", "compute"),
    # seconds and bytes
    "turn": Study("time", "speed.speed --turns 9", f"{_MAPS} truth"),
    "latency": Study("time", "speed.latency", "interferometry prediction wavefield session/streaming.py"),
    "decisions": Study("time", "speed.decisions --seeds 6 --first 971 --heights 5,10,14,20", f"{_MAPS} studies mesh"),
    "speed_error": Study("time", "speed.speed_error", f"{_RADAR} mesh"),
    "sweep": Study("time", "speed.sweep", f"{_MAPS} studies"),
    "peers": Study("time", "speed.peers --repeat 3", "tracing"),
    "scaling": Study("time", "speed.scaling", _RADAR),
    "page": Study("time", "app.speed", "app"),
}
BY_HAND = {  # results that no study of these makes, and why
    "amplitude_dispersion": "reads a record, as nonlinear_seas makes them",
    "gpu": "needs a GPU",
    "marine_radar": "reads a ship's .pol files",
    "mutants": "goes on where its own file ends",
}
# Messages, names and moves: arrays and forecasts of six scenes, rays and horizon, VV and HH, have the same bits before
# the first and after the last (`python -m validation.same 34b6b167 b6ece1d8`, checkouts of either).
CHANGED: dict[str, str] = {"0d41879c": "", "9ca11d13": "", "a9d3bfea": "", "5cde067f": "", "b6ece1d8": ""}
# Sea states, and what forecasts take from them; maps have the same bits, and one part of their errors more.
CHANGED |= {"6756e74a": "wavefield prediction", "09de6178": "wavefield prediction"}
# Names and docstrings of the nonlinear sea: an Evolution by cf67b166 has the bits of one by 4f5138e8.
CHANGED |= dict.fromkeys(("2e9c02de", "b5217627", "c1c7130c", "b3eb07d0", "c52ecf3e"), f"{_AHEAD} io studies")


def tables(text: str) -> list[dict[str, Any]]:
    """Tables of what a study printed: title, columns, and rows of a name and its cells, all as printed.

    A row is a Markdown row, or a line of two or more parts with two spaces between them; columns are named by the row
    over a Markdown rule. Other lines without a number are titles; with numbers, rows whose cells are those numbers.
    """
    made: list[dict[str, Any]] = [{"title": "", "columns": [], "rows": []}]
    for line in text.splitlines():
        if line.startswith("|"):
            cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
            if set("".join(cells)) <= set("-: "):
                table, names = made[-1], made[-1]["rows"].pop()
                if table["rows"]:
                    made.append(table := {"title": table["title"], "columns": [], "rows": []})
                table["columns"] = names[1:]
                continue
        else:
            cells = [cell.strip() for cell in re.split(r"\s{2,}|\s*\|\s*", line.strip()) if cell.strip()]
            if len(cells) == 1 and (numbers := NUMBER.findall(line)):
                cells = [line.strip(), *numbers]
            elif len(cells) == 1:
                made.append({"title": cells[0].rstrip(":"), "columns": [], "rows": []})
                continue
            if cells and made[-1]["columns"]:  # what is printed below a Markdown table is none of its rows
                made.append({"title": made[-1]["title"], "columns": [], "rows": []})
        if cells:
            made[-1]["rows"].append(cells)
    return [table for table in made if table["rows"]]


def page(name: str, result: dict[str, Any], text: str) -> str:
    """A result's page: what was printed, its Markdown tables as they are."""
    facts = [result["kind"], result["date"], f"commit {result['commit']}", result.get("machine"), result.get("note")]
    if "seconds" in result:
        facts.append(f"{result['seconds']:.0f} s")
    if result.get("carried"):
        facts.insert(1, "carried over from an earlier version")
    parts = [f"# {name}", f"`{result['command']}`", "; ".join(fact for fact in facts if fact)]
    for is_table, lines in groupby(text.strip("\n").splitlines(), lambda line: line.startswith("|")):
        if block := "\n".join(line.rstrip() for line in lines).strip("\n"):
            parts.append(block if is_table else f"```\n{block}\n```")
    return "\n\n".join(parts) + "\n"


@cache
def result(name: str) -> dict[str, Any]:
    """That on file."""
    return json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))


def figure(path: str) -> float:
    """The number at `NAME :: row :: column` or `NAME :: title :: row :: column`.

    A row by its first cell, or by how its cells begin with commas between them; a column by its name or its number from
    1; `#2` takes the second number of a cell. KeyError where there is no such cell, or more than one.
    """
    name, *title, row, last = path.split(" :: ")
    column, _, which = last.partition("#")
    found = [
        (row in (cells[0], ", ".join(cells[:2])), table["columns"], cells)
        for table in result(name)["tables"]
        if (not title or title[0] in table["title"]) and (column in table["columns"] or column.isdigit())
        for cells in table["rows"]
        if ", ".join(cells).startswith(row)
    ]
    found = [each for each in found if each[0]] or found
    if len(found) != 1:
        raise KeyError(f"{path}: {len(found)} cells in results/{name}.json, not one")
    _, columns, cells = found[0]
    cell = cells[1 + columns.index(column)] if column in columns else cells[int(column)]
    numbers = NUMBER.findall(cell)
    if len(numbers) < int(which or 1):
        raise KeyError(f"{path}: {cell!r} in results/{name}.json has no such number")
    return number(numbers[int(which or 1) - 1])


def number(text: str) -> float:
    return float(text.replace("−", "-").replace(",", ""))


def quotes(text: str) -> list[tuple[str, str]]:
    """(figure as quoted, path) of a text: `<!-- 0.092 = maps :: row :: rms; … -->` after the words that quote."""
    comments = re.findall(r"<!-- (\S+ = .*?) -->", text, flags=re.DOTALL)
    entries = [entry.split(" = ", 1) for comment in comments for entry in " ".join(comment.split()).split("; ")]
    return [(quoted, path) for quoted, path in entries]


def agrees(quoted: str, path: str) -> bool:
    """Whether a figure is that of its result, to its own digits (sizes where it is quoted without a sign)."""
    mantissa, _, power = quoted.partition("e")
    digits = len(mantissa.partition(".")[2]) - int(power.replace("−", "-") or 0)
    value = figure(path) if quoted[0] in "−-+" else abs(figure(path))
    return abs(number(quoted) - value) <= 0.5000001 * 10.0**-digits


def versions() -> str:
    """A table of the results that the READMEs quote: commit, date, whether carried, names."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    text = "".join(each.read_text(encoding="utf-8") for each in (ROOT / "README.md", README))
    for name in sorted({path.split(" :: ")[0] for _, path in quotes(text)}):
        made = result(name)
        groups.setdefault((made["date"][:10], made["commit"], "carried" if made.get("carried") else ""), []).append(
            name
        )
    rows = [
        f"| {commit} | {date} | {carried} | {', '.join(names)} |"
        for (date, commit, carried), names in sorted(groups.items(), reverse=True)
    ]
    return "\n".join(["| commit | date | | results |", "|---|---|---|---|", *rows])


def with_versions(text: str) -> str:
    """A README's text with the table of `versions` between its marks."""
    before, rest = text.split("<!-- versions -->\n")
    return f"{before}<!-- versions -->\n{versions()}\n\n<!-- end -->{rest.split('<!-- end -->')[1]}"


def git(*words: str) -> str:
    return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=False).stdout.strip()


def changes(name: str) -> int | None:
    """How many commits changed what the subject of a study computes since its result, by its date where its commit is
    not in this history; None without a result."""
    if not (RESULTS / f"{name}.json").exists():
        return None
    made = result(name)
    commit = made["commit"].split()[0]
    known = git("merge-base", commit, "HEAD") != ""
    since = [f"{commit}..HEAD"] if known else [f"--since={made['date']}", "HEAD"]
    unchanged = ("--fixed-strings", "--invert-grep", "--grep=(no bit changed)")
    log = git("log", "--format=%H", *unchanged, *since, "--", *made["subject"]).splitlines()
    subject = {Path(each).name for each in made["subject"]}
    return sum(each[:8] not in CHANGED or not subject.isdisjoint(CHANGED[each[:8]].split()) for each in log)


def minutes(name: str) -> float:
    """That its result took; infinity where that is not known."""
    known = (RESULTS / f"{name}.json").exists() and "seconds" in result(name)
    return result(name)["seconds"] / 60.0 if known else float("inf")


def make(name: str, draw: int | None = None) -> tuple[dict[str, Any], str]:
    """What a study finds, and what it prints. RuntimeError with its last words where it fails."""
    study, here, begin = STUDIES[name], Environment.here(), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, *study.words(draw, folder)]
        ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if ran.returncode not in (0, 1) or "Traceback (most recent call last)" in ran.stderr:
        raise RuntimeError(f"{name} ended with {ran.returncode}: {ran.stderr[-500:]}")
    made = {
        "command": f"python {' '.join(study.words(draw))}",
        "kind": study.kind,
        "subject": study.files,
        "draw": draw,
        "version": here.versions["seamap_rt"],
        "commit": git("log", "-1", "--format=%h", "--", "seamap_rt"),
        "date": here.when,
        "machine": here.machine,
        "seconds": round(time.perf_counter() - begin, 1),
        "tables": tables(ran.stdout),
    }
    return made, ran.stdout


def write(name: str, made: dict[str, Any], text: str) -> None:
    RESULTS.mkdir(exist_ok=True)
    facts = json.dumps({key: value for key, value in made.items() if key != "tables"}, ensure_ascii=False, indent=1)
    rows = ",\n".join(json.dumps(table, ensure_ascii=False) for table in made["tables"])
    (RESULTS / f"{name}.md").write_text(page(name, made, text), encoding="utf-8")
    (RESULTS / f"{name}.json").write_text(f'{facts[:-2]},\n "tables": [\n{rows}\n]}}\n', encoding="utf-8")
    result.cache_clear()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", choices=list(STUDIES), metavar="NAME")
    parser.add_argument("--kind", action="append", choices=KINDS)
    parser.add_argument("--within", type=float, default=float("inf"), help="minutes: studies that took no more")
    parser.add_argument("--draw", type=int)
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--stale", action="store_true")
    given = parser.parse_args()
    chosen = {
        name: study
        for name, study in STUDIES.items()
        if (not given.only or name in given.only)
        and (not given.kind or study.kind in given.kind)
        and minutes(name) <= given.within
        and (given.draw is None or study.draw is not None)
    }
    failed = 0
    for name, study in chosen.items():
        behind = changes(name)
        carried = behind is not None and bool(result(name).get("carried"))
        state = "no result" if behind is None else f"{behind} commits behind{', carried' if carried else ''}"
        if given.list or given.stale:
            if given.list or behind or behind is None:
                draw = study.draw or ""
                print(f"{name:24} {study.kind:9}{minutes(name):6.1f} min  {state:28} {draw:>5}  {study.command}")
        elif given.again or given.draw is not None or behind or behind is None or carried:
            print(f"{name}: {study.command}", flush=True)
            try:
                made, text = make(name, study.draw if given.draw is None else given.draw)
            except RuntimeError as error:
                failed += 1
                print(f"  {error}", flush=True)
                continue
            if given.draw is None:
                write(name, made, text)
                README.write_text(with_versions(README.read_text(encoding="utf-8")), encoding="utf-8")
                print(f"  {made['seconds']:.0f} s", flush=True)
            else:
                print(page(name, made, text), flush=True)
    if (given.list or given.stale) and not (given.only or given.kind or given.draw):
        for name, reason in BY_HAND.items():
            made, behind = result(name), changes(name)
            if given.list or behind:
                print(f"{name:24} {made['kind']:19}{behind} commits behind; by hand: {reason}  {made['command']}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
