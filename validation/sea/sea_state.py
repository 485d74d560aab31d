"""Sea state from one turn's map, over seas of 0.5 to 4 m: height, peak period, direction and spread beside the truth.

    python -m validation.sea.sea_state [--seeds 1 2 3] [--mast 5] [--out validation/figures/sea_state.png]
    python -m validation.sea.sea_state --draw N [--count 40] [--of seas]

VV with the 1 W radar's noise, a turn each. The true height is that of the same sea: four times the rms of the resolved
waves, dark ones too, over the range that the estimate names, as points at each look's time. The true direction is that
of the same sea's true heights, dark cells too, by the same transform of the same circle. It differs from the mean
direction of the spectrum, because the circle holds only some waves; that direction and the set period are given too.

--draw: seas that the number N draws (`validation.draws`), after one turn and after ten, beside what the scene sets: Hs,
the highest peak's period, and the mean direction of all energy, by the JONSWAP formula as it stands here. (found −
set)/stated should have an rms of 1, the sampling of the sea included.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import seamap_rt as sr
from seamap_rt.conventions import unit_from_azimuth, wrap_degrees
from seamap_rt.simulation import Simulator
from seamap_rt.wavefield.range_bins import PolarMap, RangeBins
from seamap_rt.wavefield.sea_state import sea_state
from seamap_rt.wavefield.wave_direction import Travel
from seamap_rt.wavefield.wave_spectrum import Cells, Transforms, wave_spectrum

from .. import FIGURES, draws

Sea = tuple[tuple[tuple[float, float, float], ...], float]  # (Hs, Tp, from) of each system; wind speed
SEAS: tuple[Sea, ...] = (
    (((0.5, 3.6, 270.0),), 5.0),
    (((1.0, 4.8, 30.0),), 6.5),
    (((1.4, 5.5, 135.0),), 8.0),
    (((2.5, 7.5, 200.0),), 11.0),
    (((4.0, 9.5, 120.0),), 13.0),
    (((1.2, 4.5, 270.0), (1.0, 9.0, 200.0)), 8.0),
)


def scene_of(sea: Sea, seed: int, mast: float) -> sr.Scene:
    """choppy_sea with other waves."""
    waves, wind = sea
    systems = [
        {
            "spectrum": "jonswap",
            "significant_wave_height_m": height,
            "peak_period_s": period,
            "wave_from_deg": comes_from,
            "spreading": "cos2s",
            "spreading_exponent": 10.0,
        }
        for height, period, comes_from in waves
    ]
    return sr.load_scene(
        "choppy_sea",
        overrides={
            "seed": seed,
            "sea.waves": systems,
            "scattering.wind_speed_m_s": wind,
            "scattering.wind_from_deg": waves[0][2],
            "radar.height_m": mast,
            "tracing.tracer": "horizon",
        },
    )


def true_height(simulator: Simulator, truth: xr.Dataset, first: float, last: float) -> float:
    """Significant height [m] of the resolved waves within a range of distances."""
    distance = np.sqrt(np.maximum(truth["range"].values ** 2 - simulator.scene.radar.height_m**2, 0.0))
    distance = distance[(distance > first) & (distance < last)]
    east, north = (axis[:, None] * distance for axis in unit_from_azimuth(truth["azimuth"].values))
    time = np.broadcast_to(truth["time"].values[:, None], east.shape)
    height = simulator.sea.elevation(east.ravel(), north.ravel(), time.ravel()).reshape(east.shape)
    return 4.0 * float(np.sqrt(np.average(height**2, weights=np.broadcast_to(distance, east.shape))))


def true_direction(simulator: Simulator, truth: xr.Dataset, polar: xr.Dataset, nominal: float) -> float:
    """Mean azimuth [deg] that the waves of the circle come from that `sea_state` sorts by direction."""
    bins = RangeBins.of(PolarMap.of(polar))
    if bins is None or not bins.glimpsed.any():
        return float("nan")
    distance = np.sqrt(np.maximum(truth["range"].values ** 2 - simulator.scene.radar.height_m**2, 0.0))
    height = truth["height"].values
    chosen = np.isfinite(height) & bins.covers(bins.glimpsed, distance)
    look, gate = np.nonzero(chosen)
    east, north = unit_from_azimuth(truth["azimuth"].values[look])
    out = distance[gate]
    cells = Cells(out * east, out * north, truth["time"].values[look], look, height[chosen].astype(np.float64), out)
    moment = wave_spectrum(Transforms.of(cells), Travel.from_direction(nominal)).direction(1)
    return float(np.degrees(np.angle(moment)) + 180.0) % 360.0


@dataclass(frozen=True)
class Case:
    """One turn: the settings, the true sea, and the estimate."""

    sea: Sea
    height: float  # m, true
    comes_from: float  # deg, true
    retrieved: dict[str, float]

    @property
    def nominal(self) -> str:
        return " + ".join(f"{height:g} m, {period:g} s, {azimuth:.0f}°" for height, period, azimuth in self.sea[0])

    @property
    def height_error(self) -> float:
        """Relative, percent."""
        return 100.0 * (self.retrieved["significant_wave_height"] / self.height - 1.0)

    @property
    def direction_error(self) -> float:
        return float(wrap_degrees(self.retrieved["mean_direction"] - self.comes_from))

    def row(self) -> str:
        f = self.retrieved
        return (
            f"| {self.nominal} | {f['range_first']:.0f}–{f['range_last']:.0f} m | {self.height:.3f} "
            f"| {f['significant_wave_height']:.3f} ± {f['significant_wave_height_measurement']:.3f} "
            f"| {self.height_error:+.1f} % "
            f"| {f['peak_period']:.2f} ± {f['peak_period_std']:.2f} | {self.comes_from:.1f} "
            f"| {f['mean_direction']:.1f} ± {f['mean_direction_std']:.1f} | {self.direction_error:+.1f} "
            f"| {f['directional_spread']:.1f} ± {f['directional_spread_std']:.1f} |"
        )


def case_of(sea: Sea, seed: int, mast: float) -> Case:
    simulator = Simulator(scene_of(sea, seed, mast))
    turn = simulator.turn(0)
    maps = sr.retrieve(turn.echoes)
    retrieved = {str(name): float(values[0]) for name, values in sea_state(maps).data_vars.items()}
    truth = turn.truth["polar"].to_dataset().isel(turn=0)
    height = (
        true_height(simulator, truth, retrieved["range_first"], retrieved["range_last"])
        if retrieved["cells"]
        else np.nan
    )
    polar = maps["polar"].to_dataset().isel(turn=0)
    return Case(sea, height, true_direction(simulator, truth, polar, sea[0][0][2]), retrieved)


def drawn(cases: list[Case]) -> Figure:
    """Retrieved heights and directions against the true ones."""
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    for n, sea in enumerate(SEAS):
        those = [case for case in cases if case.sea == sea]
        marks = {"fmt": "o", "color": f"C{n}", "markersize": 4, "capsize": 2}
        height = np.array([case.height for case in those])
        off = np.array([case.height_error for case in those])
        spread = [100.0 * case.retrieved["significant_wave_height_measurement"] / case.height for case in those]
        left.errorbar(height, off, spread, label=those[0].nominal, **marks)
        direction_error = [case.direction_error for case in those]
        right.errorbar(height, direction_error, [case.retrieved["mean_direction_std"] for case in those], **marks)
    _finish(left, 5.0, "error of the significant wave height, %")
    _finish(right, 5.0, "error of the mean direction, °")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    return figure


def _finish(axes: Axes, bound: float, label: str) -> None:
    axes.axhspan(-bound, bound, color="0.92", zorder=0)
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.set(xlabel="true significant wave height, m", ylabel=label, xscale="log", ylim=(-3.0 * bound, 3.0 * bound))
    axes.set_xticks([0.5, 1.0, 2.0, 4.0], ["0.5", "1", "2", "4"])
    axes.minorticks_off()


def set_state(scene: sr.Scene) -> tuple[float, float, float]:
    """Hs [m], the highest peak's period [s] and the mean direction [deg] of a scene of JONSWAP systems."""
    frequency = np.geomspace(0.03, 0.8, 4000)
    density, moment, variance = np.zeros(frequency.size), 0j, 0.0
    for waves in drawn_systems(scene):
        ratio = frequency * waves["peak_period_s"]
        width = np.where(ratio < 1.0, 0.07, 0.09)
        shape = ratio**-5.0 * np.exp(-1.25 * ratio**-4.0)
        shape = shape * waves["peak_enhancement"] ** np.exp(-0.5 * ((ratio - 1.0) / width) ** 2)
        own, exponent = (waves["significant_wave_height_m"] / 4.0) ** 2, waves["spreading_exponent"]
        density += own * shape / np.trapezoid(shape, frequency)
        # Of cos^2s(θ/2) the mean of e^(jθ) is s/(s + 1).
        moment += own * exponent / (exponent + 1.0) * np.exp(1j * np.radians(waves["wave_from_deg"]))
        variance += own
    direction = float(np.degrees(np.angle(moment))) % 360.0
    return 4.0 * np.sqrt(variance), float(1.0 / frequency[np.argmax(density)]), direction


def drawn_systems(scene: sr.Scene) -> list[dict[str, Any]]:
    return [each.model_dump() for each in scene.sea.waves]


_ASKED = ("significant_wave_height", "peak_period", "mean_direction")


def judge(scene: sr.Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What is set (3,), and found and stated after one turn and after all (2, 3)."""
    simulation = sr.simulate(scene)
    state = sr.sea_state(sr.retrieve(simulation.echoes, scene.resolved_retrieval))
    found, stated = (
        np.array([[float(state[f"{name}{part}"][turn]) for name in _ASKED] for turn in (0, -1)])
        for part in ("", "_std")
    )
    return np.array(set_state(scene)), found, stated


def drawn_seas(number: int, kind: str, count: int) -> None:
    """Prints a row for each sea and a table of (found − set)/stated."""
    rows = []
    for scene in draws.drawn(number, kind, count, turns=10):
        true, found, stated = judge(scene)
        error = found - true
        error[:, 2] = wrap_degrees(error[:, 2])
        rows.append((true, found, stated, error / stated))
        told = "; ".join(
            f"{f[0]:.2f} ± {s[0]:.2f} m, {f[1]:.1f} ± {s[1]:.1f} s, {f[2]:.0f} ± {s[2]:.0f}°"
            for f, s in zip(found, stated, strict=True)
        )
        print(f"{draws.in_words(scene)}: {true[0]:.2f} m, {true[1]:.1f} s, {true[2]:.0f}°; {told}", flush=True)
    true, found, ratio = (np.array([row[n] for row in rows]) for n in (0, 1, 3))
    print("\n| seas | turns | Hs | Tp | direction | beyond 3 | mean of Hs/set | withheld |")
    print("|---|---|---|---|---|---|---|---|")
    for name, chosen in (("all", true[:, 1] > 0.0), ("Tp ≤ 8 s", true[:, 1] <= 8.0), ("Tp > 8 s", true[:, 1] > 8.0)):
        for turn, words in ((0, "1"), (1, "10")):
            own = ratio[chosen, turn]
            if not own.size:
                continue
            rms = np.sqrt(np.nanmean(own**2, axis=0))
            beyond = np.nanmean(np.where(np.isnan(own), np.nan, np.abs(own) > 3.0))
            height = found[chosen, turn, 0] / true[chosen, 0]
            print(
                f"| {name} ({chosen.sum()}) | {words} | {rms[0]:.2f} | {rms[1]:.2f} | {rms[2]:.2f} "
                f"| {100 * beyond:.0f} % "
                f"| {np.nanmean(height):.2f} ± {np.nanstd(height) / np.sqrt(np.isfinite(height).sum()):.2f} "
                f"| {100 * np.mean(np.isnan(height)):.0f} % |"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--mast", type=float, default=5.0)
    parser.add_argument("--out", type=Path, default=FIGURES / "sea_state.png")
    parser.add_argument("--draw", type=int)
    parser.add_argument("--of", choices=list(draws.KINDS), default="seas")
    parser.add_argument("--count", type=int, default=40)
    arguments = parser.parse_args()
    if arguments.draw is not None:
        drawn_seas(arguments.draw, arguments.of, arguments.count)
        return
    print("| nominal: Hs, Tp, from | range | true Hs | Hs | error | Tp | from, true | from | error | spread |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    cases = []
    for sea in SEAS:
        for seed in arguments.seeds:
            cases.append(case_of(sea, seed, arguments.mast))
            print(cases[-1].row(), flush=True)
    print("\n| nominal: Hs, Tp, from | mean error of Hs | rms | rms error of the direction |")
    print("|---|---|---|---|")
    for sea in SEAS:
        those = [case for case in cases if case.sea == sea]
        height, direction = (
            np.array([getattr(case, name) for case in those]) for name in ("height_error", "direction_error")
        )
        rms, direction_rms = np.sqrt(np.mean(height**2)), np.sqrt(np.mean(direction**2))
        print(f"| {those[0].nominal} | {height.mean():+.1f} % | {rms:.1f} % | {direction_rms:.1f}° |")
    drawn(cases).savefig(arguments.out, dpi=130)


if __name__ == "__main__":
    main()
