"""Cells of maps beside the truth: which of them count, and statistics of their errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise, product

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.metrics import HALF_VISIBLE, HEADLINE_M

Case = tuple[str, bool]  # polarization, whether the radar has noise
Cells = Mapping[str, NDArray]  # of all seeds, those with a height; one entry per cell

CASES: tuple[Case, ...] = tuple(product(("VV", "HH"), (False, True)))
BINS_M = tuple(range(0, 351, 25))
SNR_DB = (-np.inf, 6.0, 10.0, 15.0, 20.0, 30.0, np.inf)
APART_M = (15.0, 25.0, 50.0, 100.0, 150.0, 200.0, 400.0)
SEEN = (0.0, 0.5, 0.7, 0.9, 1.0001)
LEAST_CELLS = 100  # of a class, for its figures to mean something


def name_of(case: Case) -> str:
    return f"{case[0]} {'with noise' if case[1] else 'no noise'}"


def robust(error: NDArray) -> float:
    """1.4826 MAD about the median: the standard deviation, were the errors Gaussian."""
    return 1.4826 * float(np.median(np.abs(error - np.median(error))))


def rms(error: NDArray) -> float:
    return float(np.sqrt(np.mean(np.square(error))))


def cells_of(maps: xr.DataTree, truth: xr.DataTree, stated: Mapping[str, NDArray]) -> dict[str, NDArray]:
    """The values of each cell of a turn, (cell,), by name; stated: heights (look, gate) of the floors."""
    got, true = (each["polar"].isel(turn=0).to_dataset() for each in (maps, truth))
    fields = {
        "range": np.broadcast_to(got["range"].values, got["height"].shape),
        "height": true["height"],
        "error": got["height"] - true["height"],
        "std": got["height_std"],
        "snr": got["snr_db"],
        "visible": true["visible_fraction"],
        "share": got["visible_share"],
        "quality": got["quality"],
        "outward": true["slope_range"],
        "outward_error": got["slope_range"] - true["slope_range"],
        "clockwise": true["slope_azimuth"],
        "clockwise_error": got["slope_azimuth"] - true["slope_azimuth"],
        **{name: height - true["height"].values for name, height in stated.items()},
    }
    values = {name: np.asarray(field, dtype=np.float64).ravel() for name, field in fields.items()}
    some = np.any([np.isfinite(values[name]) for name in ("error", *stated)], axis=0)
    return {name: value[some] for name, value in values.items()}


def judged(cells: Cells, error: str = "error") -> NDArray[np.bool_]:
    """Cells that count: more than half visible, and with a height that is not called ambiguous."""
    clear = (cells["quality"].astype(int) & QUALITY_FLAGS["ambiguous"]) == 0
    return np.isfinite(cells[error]) & (cells["visible"] > HALF_VISIBLE) & (clear if error == "error" else True)


def between(cells: Cells, near: float, far: float) -> NDArray[np.bool_]:
    return (cells["range"] >= near) & (cells["range"] < far)


def headline(cells: Cells) -> NDArray[np.bool_]:
    return (cells["range"] >= HEADLINE_M[0]) & (cells["range"] <= HEADLINE_M[1])


def by_range(cells: Cells, measure: Callable[[NDArray], float], error: str = "error") -> NDArray[np.float64]:
    """(bin,) of BINS_M, NaN where cells are few."""
    good = judged(cells, error)
    chosen = [cells[error][good & between(cells, *edges)] for edges in pairwise(BINS_M)]
    return np.array([measure(each) if each.size >= LEAST_CELLS else np.nan for each in chosen])


def classes(cells: Cells) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Unflagged cells with a height, all and by class."""
    known = (cells["quality"] == 0) & np.isfinite(cells["error"] / cells["std"])
    yield "all", known
    yield "all, visible > 0.5", known & (cells["visible"] > HALF_VISIBLE)
    yield "all, 50–200 m", known & headline(cells)
    for low, high in pairwise(SNR_DB):
        name = f"SNR {low:g}–{high:g} dB".replace("-inf–", "below ").replace("–inf dB", " dB and more")
        yield name, known & (cells["snr"] >= low) & (cells["snr"] < high)
    for low, high in pairwise(APART_M):
        yield f"{low:g}–{high:g} m", known & between(cells, low, high)
    for kind, name in (("visible", "visible"), ("share", "visible by echo")):
        for low, high in pairwise(SEEN):
            yield f"{name} {low:g}–{min(high, 1.0):g}", known & (cells[kind] >= low) & (cells[kind] < high)


def held(ratio: NDArray) -> tuple[float, float]:
    """1.4826 MAD of error over stated error, and the share within ±1.96: 1 and 0.95 if both are Gaussian."""
    return robust(ratio), float(np.mean(np.abs(ratio) < 1.96))


# ------------------------------------------------------------------------------------------------- tables


def row(*entries: object) -> None:
    print("| " + " | ".join(str(entry) for entry in entries) + " |", flush=True)


def heading(title: str, *names: str) -> None:
    print(f"\n**{title}**\n")
    row(*names)
    row(*("---" for _ in names))
