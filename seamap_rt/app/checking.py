"""Files from a browser, read once by the program's own readers: what they refuse is no upload.

`python -m seamap_rt.app.checking KIND PATH [ARRAY=NAME]…` does so in a process of its own, whose memory and time are
bounded, so that a file which is made to swell or to crash its reader ends that process and not the page.
"""

from __future__ import annotations

import resource
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..settings import ObjectSettings

_MOST_MEMORY = 8 * 2**30  # bytes of addresses: what is read of an upload, and the libraries that read it
_MOST_CPU_S = 120
_ANY_RADAR = {  # beside which the arrays of a recording are read: its own header comes with the retrieval
    "frequency_hz": 10e9, "pulse_width_s": 20e-9, "bandwidth_hz": 50e6, "height_m": 5.0, "baseline_m": 0.2,
    "azimuth_beamwidth_deg": 1.8, "elevation_beamwidth_deg": 18.0, "first_gate_m": 15.0, "gate_m": 1.5,
}  # fmt: skip


_READERS: dict[str, tuple[str, str, Callable[[Any, Path, Any], Any]]] = {  # where it is, and how it is called
    "spectrum": ("io.spectrumfile", "read_directional_spectrum", lambda read, path, _: read(path)),
    "sea": ("io.recorded_sea", "recorded_sea", lambda read, path, _: read(str(path)).elevation(0)),
    "pattern": ("io.patternfile", "read_pattern", lambda read, path, _: read(path)),
    "motion": ("io.motionfile", "read_motion", lambda read, path, _: read(path)),
    "vessel": ("prediction", "read_capytaine", lambda read, path, _: read(path)),
    "mesh": ("io.meshfile", "load_mesh", lambda read, path, _: read(_object(path))),
    "header": ("io.recording_header", "read_header", lambda read, path, _: read(path)),
    "recording": ("io.recorded", "read_recording", lambda read, path, names: read(path, _ANY_RADAR, names)),
}


def _object(path: Path) -> ObjectSettings:
    return ObjectSettings(mesh=str(path), position_m=(0.0, 100.0, 0.0))


def check(kind: str, path: Path, names: Mapping[str, str] | None = None) -> None:
    """Read a file as what it is to be; InputError of one line where it is not. names: of a recording's arrays that it
    calls otherwise."""
    try:
        _read(kind, path, names)
    except (InputError, MemoryError):
        raise
    except Exception as error:  # libraries that read such files raise exceptions of many types
        raise InputError(f"{path}: cannot be read ({type(error).__name__}: {error}); save it anew") from None


def _read(kind: str, path: Path, names: Mapping[str, str] | None) -> None:
    if kind not in _READERS:
        raise InputError(f"{kind}: no kind of upload")
    module, name, read = _READERS[kind]
    reader = getattr(import_module(f"..{module}", __package__), name)  # none of the others is loaded
    read(reader, path, names)


def main() -> int:
    """Check the file that is named."""
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (_MOST_CPU_S, _MOST_CPU_S))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    kind, path, *names = sys.argv[1:]
    try:
        check(kind, Path(path), dict(each.split("=", 1) for each in names))
    except InputError as refusal:
        first, *more = refusal.problems
        print(first + (f" (and {len(more)} more)" if more else ""), file=sys.stderr)
        return 2
    except MemoryError:
        print(f"{path}: takes more memory than an upload may; make it smaller", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
