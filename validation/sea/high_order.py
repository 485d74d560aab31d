"""What a nonlinear sea costs: against points, order and seconds of sea, beside the floor of its FFTs.

    python -m validation.sea.high_order [--sides 128 256 512 1024] [--orders 2 3 5] [--repeats 5] [--minutes 10]
        [--out validation/figures/high_order.png]

A JONSWAP sea (Hs 1.4 m, Tp 5.5 s; all else as `seamap-rt sea --nonlinear` has it by itself: half waves of 2.9 m at
the shortest) on patches of growing side. A step is four evaluations of the nonlinear rates; the floor is the FFTs of
that step alone, on the same points. Medians; memory by `Plan.memory`. Also what the time step costs: the change of the
energy in ten periods after the beginning, without breaking, by steps of the default and of half of it. Then seas of
growing steepness go on for some minutes.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from seamap_rt.compute.machine import threads
from seamap_rt.report.style import BLUE, GREEN, GREY, ORANGE, PURPLE, graph, new_figure, place, png, styled
from seamap_rt.sea import realize
from seamap_rt.sea.high_order import Evolution, Plan
from seamap_rt.settings import JonswapWaves, SeaSettings

from .. import FIGURES
from ..options import options

_PERIOD = 5.5  # s
_COLOURS = {1: GREY, 2: BLUE, 3: GREEN, 4: PURPLE, 5: ORANGE}


@dataclass(frozen=True)
class Cost:
    """Of one patch and order."""

    points: int  # a side, of the record
    order: int
    step: float  # s
    seconds: float  # of a step
    floor: float  # of its FFTs
    memory: int  # bytes, as planned

    @property
    def per_second(self) -> float:
        """Seconds of work a second of sea."""
        return self.seconds / self.step


def plan_of(side: float, order: int) -> Plan:
    waves = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=_PERIOD)
    settings = SeaSettings(extent_m=side, waves=(waves,))
    return Plan(settings, realize(settings, seed=1), order)


def medians(works: tuple[Callable[[], object], ...], repeats: int) -> list[float]:
    """Seconds of each, one after the other in every repeat: what else the machine does meets them alike."""
    taken = np.zeros((repeats, len(works)))
    for repeat in range(repeats):
        for number, work in enumerate(works):
            start = time.perf_counter()
            work()
            taken[repeat, number] = time.perf_counter() - start
    return [float(each) for each in np.median(taken, axis=0)]


def cost(side: float, order: int, repeats: int) -> Cost:
    plan = plan_of(side, order)
    evolution = plan.evolution(0.0, 0.25)
    before = plan.beginning(evolution)
    rates, band = evolution.rates, plan.band
    evolution.advanced(before)
    backward = order + 1  # φ^(2) … φ^(M), and the two rates
    points = band.to_points(before.elevation, rates.points)

    def transforms() -> None:
        for _ in range(5 + order * (order + 1) // 2 - 1 + (order - 1) + 2 - backward):
            band.to_points(before.elevation, rates.points)
        for _ in range(backward):
            band.to_waves(points)

    seconds, once = medians((lambda: evolution.advanced(before), transforms), repeats)
    return Cost(2 * band.most_x + 2, order, evolution.step, seconds, 4.0 * once, plan.memory)


def energy_errors() -> list[tuple[float, float]]:
    """Steps a peak period, and the relative change of the energy in ten periods of a long-crested sea."""
    waves = JonswapWaves(
        spectrum="jonswap",
        significant_wave_height_m=1.4,
        peak_period_s=_PERIOD,
        spreading="long_crested",
        wave_from_deg=270.0,
    )
    settings = SeaSettings(extent_m=512.0, waves=(waves,))
    plan, found = Plan(settings, realize(settings, seed=1), 3), []
    for finer in (1, 2):
        step = plan.longest_step / finer
        evolution = Evolution(plan.band, 3, step, None, 0.0, plan.relaxing)
        state = evolution.advanced(plan.start.state(plan.band, 0.0), plan.steps_before(step))
        begin = evolution.energy(state)
        state = evolution.advanced(state, round(10 * _PERIOD / step))
        found.append((_PERIOD / step, evolution.energy(state) / begin - 1.0))
    return found


@dataclass(frozen=True)
class Life:
    """Of a sea that goes on: what became of it."""

    heights: tuple[float, float]  # m, significant, at the end of the beginning and of all
    lost: float  # share of the energy
    broken: float  # share that breaking is counted to have taken
    skewness: float  # means over the record, one sample a period
    kurtosis: float


def life(settings: SeaSettings, minutes: float) -> Life:
    """So many minutes of a sea at the default of the command."""
    plan = Plan(settings, realize(settings, seed=1))
    evolution = plan.evolution(0.0, 0.5)
    band, shape = plan.band, tuple(4 * most + 4 if most else 1 for most in (plan.band.most_y, plan.band.most_x))
    begin = state = evolution.advanced(plan.beginning(evolution), plan.steps_before(evolution.step))
    every, moments = max(1, round(plan.steepest.peak_period / evolution.step)), []
    for _ in range(round(60.0 * minutes / (every * evolution.step))):
        state = evolution.advanced(state, every)
        height = band.to_points(state.elevation, (shape[0], shape[1]))
        moments.append([np.mean(height**3) / np.std(height) ** 3, np.mean(height**4) / np.var(height) ** 2])
    energies = [evolution.energy(each) for each in (begin, state)]
    skewness, kurtosis = np.mean(moments, axis=0)
    heights = begin.significant_height, state.significant_height
    broken = (state.broken - begin.broken) / energies[0]
    return Life(heights, 1.0 - energies[1] / energies[0], broken, float(skewness), float(kurtosis))


def print_lives(minutes: float) -> None:
    """Long-crested seas of growing steepness, and a short-crested one in 5 m of water."""
    deep = {"spectrum": "jonswap", "peak_period_s": _PERIOD, "spreading": "long_crested", "wave_from_deg": 270.0}
    seas = {
        f"long-crested, Hs/λ 1/{steep}": (512.0, np.inf, {**deep, "significant_wave_height_m": 47.2 / steep})
        for steep in (50, 30, 20, 15)
    }
    shallow = {"spectrum": "tma", "peak_period_s": _PERIOD, "significant_wave_height_m": 0.8, "wave_from_deg": 270.0}
    seas["short-crested, 5 m deep, Hs 0.8 m"] = (256.0, 5.0, shallow)
    print(f"{minutes:g} min                              Hs m           lost   broken  skewness kurtosis")
    for name, (side, depth, waves) in seas.items():
        settings = SeaSettings.model_validate({"extent_m": side, "depth_m": depth, "waves": [waves]})
        each = life(settings, minutes)
        print(
            f"{name:36s} {each.heights[0]:.3f} → {each.heights[1]:.3f} {each.lost:7.2%} {each.broken:7.2%} "
            f"{each.skewness:8.3f} {each.kurtosis:8.3f}",
            flush=True,
        )


@styled
def draw(costs: list[Cost], out: Path) -> None:
    """Seconds of work a second of sea against points."""
    figure = new_figure(2.95)
    axes = place(figure, 0.6, 0.35, 4.2, 2.2)
    graph(axes, "points a side", "", "seconds of work a second of sea")
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    for order in sorted({each.order for each in costs}):
        mine = [each for each in costs if each.order == order]
        sides = [each.points for each in mine]
        colour = _COLOURS[order]
        axes.plot(sides, [each.per_second for each in mine], "o-", color=colour, markersize=3, label=f"order {order}")
        axes.plot(sides, [each.floor / each.step for each in mine], ":", color=colour, label="its FFTs alone")
    axes.axhline(1.0, color=GREY, linewidth=0.8)
    axes.set_xticks(sorted({each.points for each in costs}))
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:.0f}")
    axes.legend(loc="center left", bbox_to_anchor=(1.04, 0.5))
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_bytes(png(figure))


def main() -> None:
    chosen = options(
        __doc__,
        sides=[128.0, 256.0, 512.0, 1024.0],
        orders=[2, 3, 5],
        minutes=10.0,
        repeats=5,
        out=FIGURES / "high_order.png",
    )
    print(f"{threads()} threads")
    cost(chosen.sides[0], chosen.orders[0], 1)  # begins the threads
    print("order  points   step s  s/step  s a s of sea   FFTs  share     MB")
    costs = []
    for order in chosen.orders:
        for side in chosen.sides:
            each = cost(side, order, chosen.repeats)
            costs.append(each)
            print(
                f"{order:5d} {each.points:5d}²  {each.step:7.3f} {each.seconds:7.4f} {each.per_second:13.3f} "
                f"{each.floor:6.4f} {each.floor / each.seconds:6.0%} {each.memory / 1e6:6.1f}",
                flush=True,
            )
    for steps, error in energy_errors():
        print(f"{steps:.0f} steps a peak period: energy {error:+.1e} in ten periods without breaking")
    if chosen.minutes > 0.0:
        print_lives(chosen.minutes)
    draw(costs, chosen.out)
    print(f"figure: {chosen.out}")


if __name__ == "__main__":
    main()
