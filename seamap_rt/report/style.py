"""What all figures share: size, type, colours, and placing by inches; GIFs.

Figures are matplotlib `Figure`s on the Agg canvas: no pyplot, no window, no global state.
"""

from __future__ import annotations

import functools
import io
from collections.abc import Callable, Sequence
from typing import Any, ParamSpec, TypeVar

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, to_rgba_array
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from PIL import Image

DPI = 130
WIDTH = 7.2  # inches: two columns of a journal
FONT = 7.5  # points

# Okabe & Ito's palette: distinct in all common kinds of colour vision, and by lightness in print.
BLACK, ORANGE, SKY, GREEN = "#000000", "#e69f00", "#56b4e9", "#009e73"
BLUE, VERMILION, PURPLE, GREY = "#0072b2", "#d55e00", "#cc79a7", "#767676"
FAMILY = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)  # of curves that are alike
BLANK = "#c3c0b6"  # where the radar looked and got no height
GRID = "#dcdcdc"
ON_COLOURS = "#fffffe"  # ink on dark colours: no grey, so that it stays white on a dark page

HEIGHT_COLOURS = "RdBu_r"  # both ends dark and of different hue, the middle light: safe for colour-blind readers
SLOPE_COLOURS = "PuOr_r"
SPREAD_COLOURS = "viridis"
COUNT_COLOURS = "cividis_r"
POWER_COLOURS = "viridis"

_STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # comes with matplotlib: the same on every machine
    "font.size": FONT,
    "text.usetex": False,
    "mathtext.fontset": "dejavusans",
    "axes.labelsize": FONT,
    "axes.titlesize": FONT + 0.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "normal",
    "axes.titlepad": 4.0,
    "axes.linewidth": 0.6,
    "axes.grid": False,
    "axes.unicode_minus": True,
    "axes.facecolor": "white",
    "axes.edgecolor": "black",
    "xtick.labelsize": FONT - 0.5,
    "ytick.labelsize": FONT - 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.fontsize": FONT - 0.5,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "figure.facecolor": "white",
    "figure.autolayout": False,
    "figure.constrained_layout.use": False,
    "savefig.bbox": None,
    "savefig.facecolor": "white",
    "savefig.transparent": False,
}

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def styled(draw: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """The function, run under the report's own style whatever the user's matplotlibrc sets."""

    @functools.wraps(draw)
    def draw_styled(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Result:
        with matplotlib.rc_context(_STYLE):  # pyright: ignore[reportArgumentType]
            return draw(*args, **kwargs)

    return draw_styled


@styled
def png(figure: Figure, dark: bool = False) -> bytes:
    """The figure as a PNG. dark: for a dark page."""
    if dark:
        _turn_greys(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, facecolor="auto")
    return buffer.getvalue()


def _turn_greys(figure: Figure) -> None:
    """Black is light, white is dark, and greys lie between; colours stay."""
    for artist in figure.findobj(lambda each: not hasattr(each, "patch")):  # whose colours are its patch's
        greys = {}
        for what in ("color", "facecolor", "edgecolor", "markerfacecolor", "markeredgecolor"):
            get, put = (getattr(artist, f"{verb}_{what}", None) for verb in ("get", "set"))
            rows = to_rgba_array(get()) if get is not None and put is not None else ()
            if len(rows) == 1 and np.ptp(rows[0][:3]) == 0.0:
                greys[put] = (*[0.92 - 0.85 * rows[0][0]] * 3, rows[0][3])
        for put, colour in greys.items():
            put(colour)


def new_figure(height: float, width: float = WIDTH, dpi: float | None = None) -> Figure:
    """An empty figure, as wide as the page unless set otherwise; inches. dpi: of frames."""
    figure = Figure(figsize=(width, height), dpi=dpi)
    FigureCanvasAgg(figure)
    return figure


def place(figure: Figure, left: float, top: float, width: float, height: float, **options: Any) -> Axes:
    """Axes of a size in inches, `left` from the left edge and `top` from the upper edge of the figure."""
    wide, high = figure.get_size_inches()
    return figure.add_axes((left / wide, 1.0 - (top + height) / high, width / wide, height / high), **options)


def graph(axes: Axes, x_label: str, y_label: str, title: str) -> None:
    """Labels, title and a faint grid for a graph."""
    axes.set_xlabel(x_label, labelpad=2.0)
    axes.set_ylabel(y_label)
    axes.set_title(title)
    axes.grid(True, color=GRID, linewidth=0.5)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=FONT - 0.5)


def plain(words: str) -> str:
    """Words from elsewhere, in which Matplotlib finds no formula."""
    return words.replace("$", r"\$")


def few_ticks(axes: Axes, most: int = 6) -> None:
    axes.xaxis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))
    axes.yaxis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))


def band(axes: Axes, x: Any, low: Any, high: Any, colour: str, alpha: float, **more: Any) -> None:
    """What lies between two curves, filled."""
    axes.fill_between(x, low, high, color=colour, alpha=alpha, linewidth=0.0, **more)


def upright(axes: Axes, at: float, words: str, colour: str = GREY, line: str = ":", **more: Any) -> None:
    """An abscissa that is marked by a line, with words at its foot. more: of these."""
    axes.axvline(at, color=colour, linestyle=line, linewidth=0.9)
    axes.text(at, 0.02, words, color=colour, transform=axes.get_xaxis_transform(), **more)


def corner(axes: Axes, lines: Sequence[str], **more: Any) -> None:
    """A few words in the upper left corner."""
    axes.text(0.03, 0.97, "\n".join(lines), transform=axes.transAxes, va="top", fontsize=FONT - 0.5, **more)


def mark_antenna(axes: Axes, x: float = 0.0, y: float = 0.0) -> None:
    """A triangle where it stands."""
    axes.plot(x, y, marker="^", color="black", markersize=3.5, linestyle="none", zorder=4.0)


def note(axes: Axes, text: str) -> None:
    """A sentence in the middle of axes that have nothing to show."""
    if not axes.lines:
        axes.set_xticks([])
        axes.set_yticks([])
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=GREY, fontsize=FONT)


def colour_bar(figure: Figure, mappable: Any, left: float, top: float, width: float, label: str, extend: str) -> None:
    """A horizontal colour bar, placed by inches."""
    axes = place(figure, left, top, width, 0.1)
    bar = figure.colorbar(mappable, cax=axes, orientation="horizontal", extend=extend)
    bar.set_label(label, labelpad=2.0)
    bar.locator = MaxNLocator(7 if width > 2.0 else 4, steps=[1, 2, 2.5, 5, 10])
    bar.update_ticks()
    bar.outline.set_linewidth(0.5)  # pyright: ignore
    axes.tick_params(labelsize=FONT - 0.5, width=0.5)


def colours(name: str) -> Colormap:
    """A colour map whose missing values let the background show."""
    return matplotlib.colormaps[name].with_extremes(bad=(0.0, 0.0, 0.0, 0.0))


def masked(values: NDArray[Any]) -> np.ma.MaskedArray[Any, Any]:
    """The values with what is not finite left out."""
    return np.ma.masked_invalid(values)


def snapshot(figure: Figure) -> Image.Image:
    """What is drawn of the figure, as a frame of an animation."""
    canvas: Any = figure.canvas
    return Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")


def gif(frames: Sequence[Image.Image], milliseconds: Sequence[int], colours: int = 256) -> bytes:
    """A GIF of RGB frames, each shown so long. One palette, the first frame's, and no dithering: still parts stay
    still, and the file small."""
    palette = frames[0].quantize(colours, method=Image.Quantize.MEDIANCUT, kmeans=2)
    indexed = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    buffer = io.BytesIO()
    indexed[0].save(
        buffer, "GIF", save_all=True, append_images=indexed[1:], duration=list(milliseconds), loop=0, optimize=False
    )
    return buffer.getvalue()
