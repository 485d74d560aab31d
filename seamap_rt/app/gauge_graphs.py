"""What the wave gauges of a run read, and its graphs: record of the surface and of the map, spectra, pairs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ..gauges import GaugeSpectra, NoSpectrum, aliasing, judge_one, spectra
from ..io.growing_file import GrowingFile, read_whole_turns
from . import figures
from .figures import Figure
from .results import Results
from .views import Source

_LONGEST = 90  # turns that are drawn in time
_DECADES = 4.0  # of a spectrum that are drawn
_MARGIN = {"l": 54, "r": 10, "t": 30, "b": 66}
_TURN = ("height", "height_std", "seen_time", "quality", "seen_true_height", "seen_cell_height")


def has_gauges(results: Results) -> bool:
    """Whether a run writes, or wrote, what gauges read."""
    path = results.folder / "gauges.nc"
    return path.exists() or any(results.folder.glob(f".{path.name}*"))


def read_gauges(results: Results) -> xr.Dataset:
    """All whole turns (schema `gauges`), also while they grow. OSError where there are none yet."""
    return read_whole_turns(results.folder / "gauges.nc", _read)


def _read(file: GrowingFile) -> xr.Dataset:
    def values(name: str) -> np.ndarray[Any, Any]:
        return np.asarray(file.array(name)[:])

    names = [each.decode("utf-8", "replace") if isinstance(each, bytes) else str(each) for each in values("gauge")]
    variables: dict[str, Any] = {name: (("gauge", "turn"), values(name)) for name in _TURN if name in file}
    variables |= {name: (("gauge",), values(name)) for name in ("east", "north")}
    if "true_height" in file:
        variables["true_height"] = ("gauge", "sample"), values("true_height")
    coordinates = {"gauge": names, "turn": values("turn"), "time": (("sample",), values("time"))}
    return xr.Dataset(variables, coordinates)


class Told(NamedTuple):
    """Of one gauge up to a turn, and what gauges there are; graphs that have nothing to show are None."""

    names: list[str]
    name: str
    place: str
    record: Figure
    why: str  # there is no spectrum, or what it leaves out
    spectrum: Figure | None
    pairs: Figure | None
    judged: dict[str, Any]


def told_of(source: Source, turn: int, chosen: str | None, dark: bool) -> Told | None:
    """What there is up to a turn of the gauge that is chosen, else of the first; None of a run without gauges."""
    if not has_gauges(source.results):
        return None
    read = read_gauges(source.results)
    names = [str(each) for each in read["gauge"].values]
    name = chosen if chosen in names else names[0]
    gauge = read.sel(gauge=name)
    east, north = (float(gauge[each]) for each in ("east", "north"))
    place = f"At {np.hypot(east, north):.0f} m, {np.degrees(np.arctan2(east, north)) % 360.0:.0f}°."
    drawn = record(gauge, source.results.turns()[turn], dark)
    result = spectra_of(gauge)
    if isinstance(result, NoSpectrum):
        why, graph = f"No spectrum: {result.reason}.", None
    else:
        told = (each for each in (aliasing(result), result.reason) if each)
        why, graph = " ".join(f"{each[:1].upper()}{each[1:]}." for each in told), spectrum(result, dark)
    return Told(names, name, place, drawn, why, graph, pairs(gauge, dark), judge_one(gauge))


def record(gauge: xr.Dataset, turn: int, dark: bool) -> Figure:
    """In time: the wire, and the map there once a turn with its stated error. turn: its number, which is marked."""
    last = int(np.searchsorted(gauge["turn"].values, turn, side="right"))
    part = gauge.isel(turn=slice(max(0, last - _LONGEST), max(last, min(_LONGEST, gauge.sizes["turn"]))))
    seen, height, spread = (part[name].values.astype(np.float64) for name in ("seen_time", "height", "height_std"))
    begin, end = (float(each(seen)) if np.isfinite(seen).any() else 0.0 for each in (np.nanmin, np.nanmax))
    time = gauge["time"].values
    drawn = (time >= begin - 1.0) & (time <= end + 1.0)
    data = [
        figures.line(time[drawn], gauge["true_height"].values[drawn], "the surface, by the wire", figures.ink(dark))
    ]
    unflagged = part["quality"].values == 0
    for members, name, symbol in (
        (unflagged, "the map", "circle"), (~unflagged, "the map, flagged", "circle-open"),
    ):  # fmt: skip
        shown = members & np.isfinite(height)
        if shown.any():
            data.append({
                "type": "scatter", "mode": "markers", "x": figures.plain(seen[shown]),
                "y": figures.plain(height[shown]), "name": name,
                "error_y": {
                    "type": "data", "array": figures.plain(1.96 * spread[shown]), "thickness": 1, "width": 0,
                },
                "marker": {"symbol": symbol, "size": 8, "color": figures.VERMILION},
            })  # fmt: skip
    now = part["seen_time"].values[part["turn"].values == turn]
    shapes = [
        {"type": "line", "x0": float(at), "x1": float(at), "y0": 0, "y1": 1, "yref": "paper",
         "line": {"color": figures.GREY, "width": 1, "dash": "dot"}}
        for at in now if np.isfinite(at)
    ]  # fmt: skip
    look = figures.layout(
        dark, "Height at the gauge; bars: ± 1.96 stated errors", 340, margin=_MARGIN, shapes=shapes,
        xaxis=figures.axis("Time (s)", dark, range=[begin - 1.0, end + 1.0]), yaxis=figures.axis("Height (m)", dark),
    )  # fmt: skip
    return figures.figure(data, look, figures.CONFIG)


def spectrum(result: GaugeSpectra, dark: bool) -> Figure:
    """Of the wire, of the wire read once a turn, and of the map."""
    inside = result.wire_frequency <= 2.0 * result.nyquist
    data = [
        figures.line(result.wire_frequency[inside], result.wire[inside], "wire", figures.ink(dark)),
        figures.line(result.frequency, result.wire_once_a_turn, "wire, once a turn", figures.BLUE, dash="dash"),
    ]
    if not result.reason:
        data.append(figures.line(result.frequency, result.radar, "the map", figures.VERMILION))
    whole = np.concatenate((result.wire[inside], result.wire_once_a_turn, result.radar))
    top = 3.0 * float(np.nanmax(whole)) if np.nanmax(whole) > 0.0 else 1.0
    half = {
        "type": "line", "x0": result.nyquist, "x1": result.nyquist, "y0": 0, "y1": 1, "yref": "paper",
        "line": {"color": figures.GREY, "width": 1, "dash": "dot"},
        "label": {
            "text": "half the turn rate", "textposition": "end", "textangle": 0, "xanchor": "left", "yanchor": "top",
            "font": {"size": 10},
        },
    }  # fmt: skip
    exponent = float(np.log10(top))
    look = figures.layout(
        dark, "Spectra", 340, margin=_MARGIN, shapes=[half], xaxis=figures.axis("Frequency (Hz)", dark),
        yaxis=figures.axis(
            "m²/Hz", dark, type="log", range=[exponent - _DECADES, exponent], dtick=1, exponentformat="power"
        ),
    )  # fmt: skip
    return figures.figure(data, look)


def pairs(gauge: xr.Dataset, dark: bool) -> Figure | None:
    """The map's heights against the wire's at the same moments; None without any."""
    true, found = (gauge[name].values.astype(np.float64) for name in ("seen_true_height", "height"))
    both = np.isfinite(true) & np.isfinite(found)
    if not both.any():
        return None
    reach = 1.08 * max(0.05, float(np.abs(np.concatenate((true[both], found[both]))).max()))
    data = [
        figures.line([-reach, reach], [-reach, reach], "equal", figures.GREY, dash="dash"),
        {
            "type": "scatter", "mode": "markers", "x": figures.plain(true[both]), "y": figures.plain(found[both]),
            "name": "a turn", "marker": {"size": 7, "color": figures.VERMILION, "opacity": 0.7},
        },
    ]  # fmt: skip
    look = figures.layout(
        dark, "At the same moments", 340, hovermode="closest", margin=_MARGIN,
        xaxis=figures.axis("Wire (m)", dark, range=[-reach, reach], constrain="domain"),
        yaxis=figures.axis("Map (m)", dark, range=[-reach, reach], scaleanchor="x", constrain="domain"),
    )  # fmt: skip
    return figures.figure(data, look)


def spectra_of(gauge: xr.Dataset) -> GaugeSpectra | NoSpectrum:
    """Of one gauge, or why there are none."""
    return spectra(gauge)
