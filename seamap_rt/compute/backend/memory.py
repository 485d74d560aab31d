"""What is remembered in the user's cache: verdicts on libraries, and the library linked here."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import stat
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

from ..scratch import scratch_folder
from . import probe
from .kinds import Candidate, Verdict, package_version

FAILURE_LIFETIME_S = 3600.0  # after which a rejected library is tried again


def cache_folder() -> Path:
    """The user's cache; where that cannot be written, one under the temporary folder; OSError if neither."""
    error: OSError | None = None
    for folder, shared_parent in ((_user_cache(), False), (_temporary_cache(), True)):
        if folder is None:
            continue
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if shared_parent:
                _refuse_what_others_can_change(folder)
            if os.access(folder, os.W_OK | os.X_OK):
                return folder
            raise PermissionError(f"{folder} is not writable")
        except OSError as problem:
            error = problem
    raise error or OSError("no folder for a cache")


def _user_cache() -> Path | None:
    named = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(named):  # a relative one is to be ignored, says the XDG specification
        return Path(named, "seamap_rt")
    try:
        return Path.home() / ".cache" / "seamap_rt"
    except RuntimeError:  # no HOME, and no entry in the password file
        return None


def _temporary_cache() -> Path:
    owner = os.getuid() if hasattr(os, "getuid") else "cache"
    return Path(tempfile.gettempdir(), f"seamap_rt-{owner}")


def _refuse_what_others_can_change(folder: Path) -> None:
    """Code is loaded from here, and /tmp is shared: a folder that another user could have made is not used."""
    status = folder.lstat()
    mine = not hasattr(os, "getuid") or status.st_uid == os.getuid()
    if not (mine and stat.S_ISDIR(status.st_mode) and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)):
        raise PermissionError(f"{folder} belongs to, or can be changed by, someone else")


def verdict_file(candidate: Candidate) -> Path | None:
    """Where a verdict is kept: its name changes with all that could change the verdict."""
    try:
        status = candidate.library.stat()
        folder = cache_folder()
    except OSError:
        return None  # a bare name for the loader to resolve, or nowhere to write: judged anew each time
    circumstances = [
        candidate.kind,
        str(candidate.library),
        status.st_mtime_ns,
        status.st_size,
        package_version("drjit"),
        package_version("mitsuba"),
        sys.version,
        platform.node(),  # a home folder may be shared by unlike machines
        os.environ.get("CUDA_VISIBLE_DEVICES") if candidate.kind == "cuda" else None,
        probe.PROBE,
    ]
    name = hashlib.sha256(json.dumps(circumstances).encode()).hexdigest()[:24]
    return folder / f"verdict-{name}.json"


def recall(file: Path | None) -> Verdict | None:
    """An earlier verdict on the same library in the same circumstances; a failure only while it is fresh."""
    if file is None:
        return None
    try:
        verdict = Verdict(**json.loads(file.read_text(encoding="utf-8")))
        fresh = time.time() - file.stat().st_mtime < FAILURE_LIFETIME_S
    except (OSError, ValueError, TypeError):
        return None
    return verdict if verdict.works or fresh else None


def remember(file: Path | None, verdict: Verdict) -> None:
    """Keep a verdict. Only speed is lost where that fails."""
    if file is None:
        return
    with (
        contextlib.suppress(OSError),
        scratch_folder(".new-", file.parent) as scratch,
    ):
        whole = scratch / file.name
        whole.write_text(json.dumps(asdict(verdict)), encoding="utf-8")
        os.replace(whole, file)  # two processes may be here at once: each sees a whole file or none
