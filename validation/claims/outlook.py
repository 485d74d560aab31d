"""The outlook beside the simulation: fully measured radius and reach of random designs, each on three seas.

    python -m validation.claims.outlook [--designs 24] [--first 1] [--seeds 3] [--masts]

A design is a sea (Hs 0.4 to 3 m, 22 to 55 times as long, spread, wind), a mast of 3 to 20 m, a baseline of 0.15 to 1 m,
0.3 to 20 W, VV or HH and one of three modes, all drawn. --masts: also which of six masts both would choose, on the
trade of `validation.claims.trade_heights`. Light by the horizon.
"""

from __future__ import annotations

import math
import time
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.measured import CoverageProfile
from seamap_rt.report import style
from seamap_rt.simulation import Simulator
from seamap_rt.studies.choices import choices, outlooks
from seamap_rt.studies.paired import WITHIN
from seamap_rt.studies.sweep import trade

from .. import FIGURES
from ..options import options
from .trade_heights import CHOICES, WAVE_HEIGHT, scene

Array = NDArray[np.float64]
MODES = (("single", "single_pulse"), ("switched", "single_pulse"), ("switched", "alternating_pulse"))
BLIND_M = 30.0  # of a radar that measures less a share says nothing: it is blind


class Compared(NamedTuple):
    """Of designs; arrays (design,): metres, the simulation's the means of its seeds."""

    radius: Array
    reach: Array
    outlook_radius: Array
    outlook_reach: Array
    seconds: Array  # of an outlook, at its second call

    @property
    def seeing(self) -> NDArray[np.bool_]:
        return self.radius >= BLIND_M

    def off(self, name: str) -> Array:
        """Per cent by which the outlook is off, of the designs that see anything and reach anywhere."""
        true, model = getattr(self, name), getattr(self, f"outlook_{name}")
        some = self.seeing & (true >= BLIND_M)
        return 100.0 * (model[some] / true[some] - 1.0)


def designs(first: int, count: int) -> list[dict[str, Any]]:
    """Keys of scenes, drawn; the same for the same numbers."""
    made = []
    for number in range(first, first + count):
        stream = np.random.default_rng(number)

        def drawn(low: float, high: float, stream: np.random.Generator = stream) -> float:
            return float(f"{math.exp(stream.uniform(math.log(low), math.log(high))):.3g}")

        height, transmit = drawn(0.4, 3.0), MODES[int(stream.integers(3))]
        made.append(
            {
                WAVE_HEIGHT: height,
                "sea.waves.0.peak_period_s": round(math.sqrt(2.0 * math.pi * height * drawn(22.0, 55.0) / 9.81), 2),
                "sea.waves.0.spreading_exponent": drawn(4.0, 20.0),
                "scattering.wind_speed_m_s": min(13.0, max(3.5, 8.0 * math.sqrt(height / 1.4) * drawn(0.8, 1.25))),
                "scattering.polarization": str(stream.choice(["VV", "HH"])),
                "radar.height_m": drawn(3.0, 20.0),
                "radar.baseline_m": drawn(0.15, 1.0),
                "radar.transmit_power_w": drawn(0.3, 20.0),
                "radar.transmit": transmit[0],
                "radar.interferogram": transmit[1],
                "tracing.tracer": "horizon",
            }
        )
    return made


def simulated(keys: dict[str, Any], seeds: int) -> tuple[float, float]:
    """Fully measured radius and reach [m], means over the seeds."""
    found = []
    for seed in range(101, 101 + seeds):
        simulator = Simulator(sr.load_scene("choppy_sea", overrides={**keys, "seed": seed}))
        turn = next(iter(sr.iterate(simulator.scene, simulator=simulator)))
        assert turn.maps is not None
        sigma = simulator.sea.resolved.elevation_std
        rings = CoverageProfile.of(turn.maps["polar"].to_dataset(), turn.truth["polar"].to_dataset(), sigma)
        found.append((rings.fully_measured_radius, rings.reach[0]))
    radius, reach = np.mean(found, axis=0)
    return float(radius), float(reach)


def compared(first: int, count: int, seeds: int) -> Compared:
    rows = []
    for keys in designs(first, count):
        made = sr.load_scene("choppy_sea", overrides=keys)
        sr.outlook(made)
        start = time.perf_counter()
        found = sr.outlook(made)
        seconds = time.perf_counter() - start
        rows.append((*simulated(keys, seeds), found.attrs["fully_measured_radius_m"], found.attrs["reach_m"], seconds))
    return Compared(*np.array(rows).T)


def words(found: Compared) -> list[str]:
    lines = [f"{found.radius.size} designs, {np.count_nonzero(~found.seeing)} of them blind (less than {BLIND_M:g} m)"]
    for name in ("radius", "reach"):
        off = found.off(name)
        lines.append(
            f"{name}: {np.sqrt(np.mean(off**2)):.1f} % rms, {np.median(abs(off)):.1f} % in the median, "
            f"{np.mean(off):+.1f} % in the mean, {abs(off).max():.1f} % at most"
        )
    lines.append(f"an outlook takes {1e3 * np.median(found.seconds):.0f} ms in the median")
    return lines


@style.styled
def draw(found: Compared) -> Figure:
    figure = style.new_figure(3.2)
    names = {"radius": "Fully measured radius (m)", "reach": "Reach (m)"}
    for column, (name, label) in enumerate(names.items()):
        axes = style.place(figure, 0.62 + column * 3.4, 0.3, 2.5, 2.4)
        style.graph(axes, f"{label}, simulated", f"{label}, outlook", f"({chr(97 + column)})")
        true, model = getattr(found, name), getattr(found, f"outlook_{name}")
        end = 1.05 * float(max(true.max(), model.max()))
        line = np.array([0.0, end])
        axes.fill_between(line, 0.95 * line, 1.05 * line, color=style.SKY, alpha=0.3, linewidth=0.0)
        axes.plot(line, line, color=style.GREY, linewidth=0.8)
        axes.plot(true, model, "o", color=style.BLUE, markersize=3.0)
        axes.set_xlim(0.0, end)
        axes.set_ylim(0.0, end)
    return figure


def masts(seeds: int) -> list[str]:
    """What a trade and the outlook would choose, and what the outlook's choice gives away."""
    lines = []
    for height in (0.7, 1.4, 2.8):
        vary = {WAVE_HEIGHT: [height], **CHOICES}
        table, at_once = trade(scene(height), vary, seeds), outlooks(scene(height), vary)
        radius = at_once["outlook_fully_measured_radius_m"].expand_dims(seed=[0])
        model = at_once.assign(fully_measured_radius_m=radius, status=radius)
        for (about, here, choice), (_, _, other) in zip(choices(table), choices(model), strict=True):
            mean = here["fully_measured_radius_m"].mean("seed")
            lost = 1.0 - float(mean.sel({choice.key: other.value}) / mean.max())
            lines.append(
                f"Hs {height:g} m, {about}: simulated {choice.value:g} m, outlook {other.value:g} m, whose simulated "
                f"radius is {lost:.1%} below the best ({WITHIN:.0%} allowed)"
            )
    return lines


def main() -> None:
    arguments = options(__doc__, designs=24, first=1, seeds=3, masts=False)
    found = compared(arguments.first, arguments.designs, arguments.seeds)
    print("\n".join(words(found)), flush=True)
    (FIGURES / "outlook.png").write_bytes(style.png(draw(found)))
    if arguments.masts:
        print("\n".join(masts(arguments.seeds)))


if __name__ == "__main__":
    main()
