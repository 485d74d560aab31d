"""What a backend is, and the names by which Dr.Jit, Mitsuba and the user know it."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Literal

Kind = Literal["cuda", "llvm"]


VARIABLE = "DRJIT_LIBLLVM_PATH"


OLDEST_LLVM = 17  # 15 and 16 abort on x86, Dr.Jit itself refuses 14


VARIANTS: dict[Kind, str] = {"cuda": "cuda_ad_mono_polarized", "llvm": "llvm_ad_mono_polarized"}


WHEEL = "mlc-llvm-static"


PACKAGES = ("sionna-rt", "mitsuba", "drjit", "trimesh", "numpy")


REMEDY_ATOMIC = "run `apt-get install libatomic1`"


REMEDY = (
    "run `apt-get install libllvm19 libatomic1`, or `pip install 'seamap_rt[llvm]'` with g++ installed, "
    "or `conda install -c conda-forge llvm`"
)


@dataclass(frozen=True)
class Backend:
    """What Dr.Jit will run on, and how it was found."""

    kind: Kind
    library: Path | None
    llvm_version: str | None
    source: str
    variant: str
    notes: tuple[str, ...] = ()  # candidates passed over on the way, and why


@dataclass(frozen=True)
class Candidate:
    kind: Kind
    library: Path
    source: str


@dataclass(frozen=True)
class Verdict:
    works: bool
    detail: str  # the library's version if it works, else the reason why not


def package_version(package: str) -> str | None:
    """The version of an installed package, without importing it."""
    try:
        return metadata.version(package)
    except Exception:  # not installed, or its metadata damaged: the same for us
        return None
