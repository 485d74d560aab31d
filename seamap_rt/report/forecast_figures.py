"""Forecasts beside the sea that came: the last field as maps, errors by lead, and the run as an animation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from ..conventions import turn_name
from ..forecast_errors import Verified, prediction_time, warm
from ..scene import Scene
from . import reduce, style
from .gif import gif
from .page_elements import Picture, Table, digits, percent

Array = NDArray[np.float64]

_LEAD_S = 10.0  # of the forecasts that are drawn in time
_BAND = 1.96
_BACK_S = 15.0  # that the animation looks back
_MOST_FRAMES, _FRAME_MS, _PIXELS, _COLOURS = 60, 400, 760, 64
_HALF_KNOWN = np.sqrt(0.5)  # of σ


def forecast_pictures(scene: Scene, maps: xr.DataTree, verified: Verified | None) -> list[Picture]:
    """The field's maps, the forecasts in lead and time, and how they ran ahead; none of a run that did not forecast."""
    if verified is None:
        return []
    issues = verified.forecasts.sizes["issue"]
    made = [
        Picture(
            "wave_field",
            "The wave field through the shadows",
            "Four maps, north up: the height that the last turn alone gave, the height reconstructed from the last "
            "turns, the true height at the same moment, and the stated error of the reconstruction.",
            "(a) One turn's map, each cell when the beam passed it; grey is where it gave no height. (b) Free waves "
            f"fitted to the last {int(verified.forecasts['turns'].values[-1])} turns, at the end of the last one, "
            "shadows and the water around the mast included. (c) The sea then. (d) The stated standard error over the "
            "sea's standard deviation; white: where half the sea's variance is known.",
            lambda: wave_field(scene, maps, verified.field),
        ),
        Picture(
            "forecast_errors",
            "Forecasts against the sea that came",
            "Error of forecasts at the boat against their lead beside the stated error, persistence and climatology; "
            f"and the sea at the boat in time with what was forecast of it {_LEAD_S:g} s ahead.",
            f"(a) Rms over the sea's standard deviation σ, of {int(warm(verified.forecasts).sum())} forecasts. "
            "Persistence: the sea stays as it is now. Climatology: the mean level. Upright: the maximum prediction "
            "time, up to which the stated error stays below half of σ. (b) The sea that came, and what was "
            f"forecast {_LEAD_S:g} s before, ± 1.96 stated standard errors.",
            lambda: forecast_errors(verified),
        ),
    ]
    if issues > 1:
        made.append(
            Picture(
                "forecast_ahead",
                "Forecasts run ahead of the sea",
                "Animation of the sea at the boat: what came, and the forecast of each turn with its band.",
                "Height at the boat about the moment of each forecast. Black: the sea that came, grey: that comes. "
                "Orange: the forecast ± 1.96 stated standard errors.",
                lambda: forecast_ahead(verified),
            )
        )
    return made


def forecast_table(rows: list[dict[str, object]]) -> list[Table]:
    """What metrics.json says of forecasts; none if the run made none."""
    if not rows:
        return []
    made = []
    for row in rows:
        first, last = reduce.series(row["lead_s"])
        numbers = [digits(row[name], 3) for name in ("correlation", "error_share", "stated_share", "persistence_share")]
        lead = "now" if last == 0.0 else f"{first:g}–{last:g} s"
        made.append([str(row["place"]), lead, *numbers, percent(row["within"])])
    head = ("Place", "Lead", "Correlation", "Error (σ)", "Stated (σ)", "Persistence (σ)", "Within 1.96 stated")
    note = (
        f"Of {rows[0]['forecasts']} forecasts that rest on five turns or more, or of all where none does; σ is the "
        "standard deviation of the sea that came."
    )
    return [Table("Forecasts", head, made, note)]


@style.styled
def wave_field(scene: Scene, maps: xr.DataTree, field: xr.Dataset) -> Figure:
    """One turn's map, the field of the last turns, the truth, and the stated error."""
    x, y = field["x"].values, field["y"].values
    alone = np.asarray(maps["ground"].dataset["height"].isel(turn=-1).values, np.float64)
    sigma = float(np.std(field["true"].values)) or 1.0
    near = np.hypot(*np.meshgrid(x, y)) <= scene.far_ground_range
    shown = [np.where(near | np.isfinite(alone), each, np.nan) for each in (field["reconstructed"], field["true"])]
    stated = np.where(near, field["stated"].values / sigma, np.nan)
    limit = 2.5 * sigma
    panel, gap, left = 2.85, 0.32, 0.55
    figure = style.new_figure(2.0 * (panel + 0.35) + 1.0)
    edges = reduce.edges(x), reduce.edges(y)
    extent = edges[0][0], edges[0][-1], edges[1][0], edges[1][-1]
    titles = ("(a) One turn's map", "(b) Reconstructed", "(c) True", "(d) Stated error")
    for number, (title, values) in enumerate(zip(titles, (alone, *shown, stated), strict=True)):
        column, row = number % 2, number // 2
        axes = style.place(figure, left + column * (panel + gap + 0.2), 0.3 + row * (panel + 0.42), panel, panel)
        of_error = number == 3
        image = axes.imshow(
            style.masked(values), origin="lower", extent=extent, interpolation="nearest",
            vmin=0.0 if of_error else -limit, vmax=1.0 if of_error else limit,
            cmap=style.colours(style.SPREAD_COLOURS if of_error else style.HEIGHT_COLOURS),
        )  # fmt: skip
        axes.set_facecolor(style.BLANK)
        axes.set_title(title)
        axes.plot(*_boat(scene, maps), marker="^", color="black", markersize=3.5, linestyle="none")
        if of_error and np.nanmin(stated) < _HALF_KNOWN < np.nanmax(stated):
            axes.contour(x, y, stated, levels=[_HALF_KNOWN], colors="white", linewidths=0.8)
        style.few_ticks(axes, 5)
        axes.tick_params(labelleft=column == 0, labelbottom=row == 1)
        if column == 0:
            axes.set_ylabel("North (m)", labelpad=1.0)
        if row == 1:
            axes.set_xlabel("East (m)", labelpad=1.0)
        if number > 1:
            label = "Stated error over σ" if of_error else "Height above mean sea level (m)"
            top = 0.3 + 2.0 * panel + 0.42 + 0.42
            start = left + column * (panel + gap + 0.2) + 0.2
            style.colour_bar(figure, image, start, top, panel - 0.4, label, "max" if of_error else "both")
    return figure


def _boat(scene: Scene, maps: xr.DataTree) -> tuple[float, float]:
    polar = maps["polar"].dataset
    if not scene.platform.speed_m_s or "antenna_x" not in polar:
        return 0.0, 0.0
    x, y = (float(np.asarray(polar[name].isel(turn=-1).values).ravel()[-1]) for name in ("antenna_x", "antenna_y"))
    return x, y


@style.styled
def forecast_errors(verified: Verified) -> Figure:
    """Errors by lead, and the sea at the first place in time with its forecasts of ten seconds before."""
    figure = style.new_figure(3.05)
    left, right = (style.place(figure, start, 0.3, wide, 2.15) for start, wide in ((0.55, 2.5), (3.65, 3.4)))
    kept = np.flatnonzero(warm(verified.forecasts))
    forecasts, truth = verified.forecasts.isel(issue=kept, place=0), verified.truth[kept, :, 0]
    lead, mean, std = (forecasts[name].values.astype(np.float64) for name in ("lead", "elevation", "elevation_std"))
    sigma = float(np.std(truth)) or 1.0
    for values, colour, line, name in (
        (mean - truth, style.BLUE, "-", "found"),
        (std, style.ORANGE, "-", "stated"),
        (mean[:, :1] - truth, style.GREY, "--", "persistence"),
        (truth, style.GREY, ":", "climatology"),
    ):
        left.plot(lead, np.sqrt(np.mean(values**2, axis=0)) / sigma, color=colour, linestyle=line, label=name)
    longest = prediction_time(verified.forecasts.isel(issue=kept))
    if longest is not None:
        left.axvline(longest, color=style.ORANGE, linestyle="-.", linewidth=0.9)
        left.text(longest, 0.02, f" {longest:.0f} s", color=style.ORANGE, transform=left.get_xaxis_transform())
    style.graph(left, "Lead (s)", "Rms error over σ", "(a) By lead, at the boat")
    left.set_ylim(bottom=0.0)
    left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=4, columnspacing=1.0, handlelength=1.6)
    _draw_in_time(right, verified)
    return figure


def _draw_in_time(axes: Axes, verified: Verified) -> None:
    forecasts = verified.forecasts.isel(place=0)
    lead = forecasts["lead"].values
    number = int(np.argmin(np.abs(lead - _LEAD_S)))
    time, truth = _sea_that_came(verified)
    moment = forecasts["issued"].values + lead[number]
    mean, std = (forecasts[name].values[:, number].astype(np.float64) for name in ("elevation", "elevation_std"))
    axes.plot(time, truth, color=style.BLACK, linewidth=0.9, label="the sea that came")
    axes.fill_between(moment, mean - _BAND * std, mean + _BAND * std, color=style.ORANGE, alpha=0.3, linewidth=0.0)
    axes.plot(moment, mean, "o-", color=style.ORANGE, markersize=2.5, label=f"forecast {lead[number]:g} s before")
    style.graph(axes, "Time (s)", "Height at the boat (m)", "(b) In time")
    axes.margins(y=0.25)
    axes.legend(loc="upper right", ncols=2)


def _sea_that_came(verified: Verified) -> tuple[Array, Array]:
    """True heights at the first place by time, of all forecasts together; of a moving boat as the last one that looked
    at a moment has it."""
    forecasts = verified.forecasts
    time = np.round(forecasts["issued"].values[:, None] + forecasts["lead"].values, 3)
    found, first = np.unique(time.ravel(), return_index=True)
    return found.astype(np.float64), verified.truth[:, :, 0].ravel()[first]


@style.styled
def forecast_ahead(verified: Verified) -> bytes:
    """A GIF: about the moment of each forecast, the sea at the first place and what is forecast of it."""
    return gif(frames := list(_frames(verified)), [_FRAME_MS] * len(frames), _COLOURS)


def _frames(verified: Verified) -> Iterator[Image.Image]:
    forecasts = verified.forecasts.isel(place=0)
    lead, issued = forecasts["lead"].values, forecasts["issued"].values
    time, truth = _sea_that_came(verified)
    limit = 1.25 * float(np.max(np.abs(truth)))
    figure = Figure(figsize=(style.WIDTH, 2.2), dpi=_PIXELS / style.WIDTH)
    canvas = FigureCanvasAgg(figure)
    for number in range(0, issued.size, -(-issued.size // _MOST_FRAMES)):
        figure.clear()
        axes = style.place(figure, 0.55, 0.28, style.WIDTH - 0.7, 1.45)
        now = issued[number]
        past, coming = time <= now, (time >= now) & (time <= now + lead[-1])
        axes.plot(time[past] - now, truth[past], color=style.BLACK)
        axes.plot(time[coming] - now, truth[coming], color=style.GREY, linewidth=0.9)
        mean, std = (forecasts[name].values[number].astype(np.float64) for name in ("elevation", "elevation_std"))
        axes.fill_between(lead, mean - _BAND * std, mean + _BAND * std, color=style.ORANGE, alpha=0.3, linewidth=0.0)
        axes.plot(lead, mean, color=style.ORANGE)
        axes.axvline(0.0, color=style.GREY, linewidth=0.6)
        style.graph(axes, "Time from now (s)", "Height at the boat (m)", turn_name(forecasts["issue"][number]))
        axes.set_xlim(-_BACK_S, float(lead[-1]))
        axes.set_ylim(-limit, limit)
        canvas.draw()
        yield Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
