"""Files from a browser, read once by the program's own readers: what they refuse is no upload.

`python -m seamap_rt.app.checking KIND PATH [ARRAY=NAME]…` does so in a process of its own, whose memory and time are
bounded, so that a file which is made to swell or to crash its reader ends that process and not the page.
"""

from __future__ import annotations

import resource
import sys
from collections.abc import Mapping
from pathlib import Path

from ..errors import InputError
from ..settings import ObjectSettings

_MOST_MEMORY = 8 * 2**30  # bytes of addresses: what is read of an upload, and the libraries that read it
_MOST_CPU_S = 120
_ANY_RADAR = {  # beside which the arrays of a recording are read: its own header comes with the retrieval
    "frequency_hz": 10e9, "pulse_width_s": 20e-9, "bandwidth_hz": 50e6, "height_m": 5.0, "baseline_m": 0.2,
    "azimuth_beamwidth_deg": 1.8, "elevation_beamwidth_deg": 18.0, "first_gate_m": 15.0, "gate_m": 1.5,
}  # fmt: skip


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
    if kind == "spectrum":
        from ..io.spectrumfile import read_directional_spectrum

        read_directional_spectrum(path)
    elif kind == "sea":
        from ..io.recorded_sea import recorded_sea

        recorded_sea(str(path)).elevation(0)
    elif kind == "pattern":
        from ..io.patternfile import read_pattern

        read_pattern(path)
    elif kind == "motion":
        from ..io.motionfile import read_motion

        read_motion(path)
    elif kind == "vessel":
        from ..prediction import read_capytaine

        read_capytaine(path)
    elif kind == "mesh":
        from ..io.meshfile import load_mesh

        load_mesh(ObjectSettings(mesh=str(path), position_m=(0.0, 100.0, 0.0)))
    elif kind == "header":
        from ..io.recording_header import read_header

        read_header(path)
    elif kind == "recording":
        from ..io.recorded import read_recording

        read_recording(path, _ANY_RADAR, names)
    else:
        raise InputError(f"{kind}: no kind of upload")


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
