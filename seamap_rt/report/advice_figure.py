"""What to steer, as a chart: the roll that is expected by heading and speed."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes

from . import style
from .page_elements import Picture


def advice_picture(advice: xr.Dataset) -> Picture:
    """Expected roll by heading and speed."""
    low, high = (float(each) for each in (advice["speed"].min(), advice["speed"].max()))
    return Picture(
        "advice",
        "Expected roll by heading and speed",
        f"Polar chart, north up: rms roll of the next {advice.attrs['horizon_s']:.0f} s by heading, at speeds of "
        f"{low:g} to {high:g} m/s outward; the best and the present course are marked.",
        "Dark is little roll, bright is much. Star: the best course; circle: the present one; outward: speed in m/s.",
        lambda: advice_polar(advice),
    )


@style.styled
def advice_polar(advice: xr.Dataset) -> Figure:
    """Rms roll (heading, speed) of the seen part, north up and clockwise."""
    figure = style.new_figure(3.2, 3.9)
    axes = figure.add_axes((0.12, 0.1, 0.64, 0.78), projection="polar")
    assert isinstance(axes, PolarAxes)
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    roll = advice["roll_rms"].sel(part="seen").transpose("speed", "heading").values
    heading, speed = advice["heading"].values, advice["speed"].values
    edges = np.radians(np.append(heading, heading[0] + 360.0) - 0.5 * 360.0 / heading.size)
    half = 0.5 * np.diff(speed)
    rings = np.concatenate(([0.0], speed[:-1] + half, [speed[-1] + half[-1]]))
    image = axes.pcolormesh(edges, rings, roll, cmap="cividis")
    held, best = ((np.radians(advice.attrs[f"{n}heading_deg"]), advice.attrs[f"{n}speed_m_s"]) for n in ("", "best_"))
    axes.plot(*held, "o", markersize=13.0, markerfacecolor="none", markeredgecolor="white", markeredgewidth=2.0)
    axes.plot(*best, "*", markersize=16.0, color=style.VERMILION, markeredgecolor="white")
    axes.set_yticks(speed)
    axes.tick_params(labelsize=12.0)
    axes.grid(alpha=0.3)
    bar = figure.colorbar(image, cax=figure.add_axes((0.83, 0.12, 0.04, 0.74)))
    bar.set_label("Roll, rms (°)", fontsize=12.0)
    bar.ax.tick_params(labelsize=12.0)
    return figure
