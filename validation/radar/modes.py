"""The four modes, transmitter × interferogram: what each costs, and whether switching the transmitter is worth it.

    python -m validation.radar.modes [--seeds 3] [--scene choppy_sea] [--parts map,doppler,…]

 map            errors by range of the scene's four modes, without noise and with it
 doppler        the bias of alternating pulses over a flat sea that drifts, beside 2vτR/(pB)
 channels       the bias of an upper receiver 5° ahead and of a baseline 2 mm too long, and how to measure the former
 decorrelation  alternating pulses over a sea that decorrelates in 2 ms, at 10 kHz and at 2 kHz
 edges          what a switched transmitter loses at the edges of shadows, which each antenna sees elsewhere
 answer         does switching minimise the phase error? In figures of this run

Runs with and without noise share sea and speckle, so the difference of the two maps is due to noise alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.echoes.receiving import add_noise, gate_noise_power
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.scene import Scene
from seamap_rt.settings import RadarSettings
from seamap_rt.simulation import Simulator, Turn

from ..options import options

PARTS = ("map", "doppler", "channels", "decorrelation", "edges", "answer")
BINS_M = (50.0, 100.0, 150.0, 200.0, 300.0)
UP_WAVE = [240.0, 300.0]  # a sector is enough where a case is compared with itself
DRIFT_M_S, DRIFT_TOWARD = 1.0, 90.0
CHANNEL_DEG, BASELINE_ERROR_M = 5.0, 0.002

Pairs = Literal["both", "forward", "backward"]
Field = NDArray[np.float64]


@dataclass(frozen=True)
class Mode:
    """One of the four."""

    transmit: str
    interferogram: str
    paths: int = 1  # p: how often the phase counts the range difference

    @property
    def alternating(self) -> bool:
        return self.interferogram == "alternating_pulse"

    @property
    def keys(self) -> dict[str, str]:
        """Of the scene: the mode, retrieved by its own interferogram alone, with one window for all."""
        retrieval = {"retrieval.paths": "one_way", "retrieval.estimator": "sliding_plane"}
        return {"radar.transmit": self.transmit, "radar.interferogram": self.interferogram, **retrieval}

    def __str__(self) -> str:
        return f"{self.transmit}, {self.interferogram.replace('_', ' ')}"


SINGLE, SWITCHED = Mode("single", "single_pulse"), Mode("switched", "single_pulse")
ALTERNATING, PING_PONG = Mode("single", "alternating_pulse"), Mode("switched", "alternating_pulse", 2)
MODES = (SINGLE, SWITCHED, ALTERNATING, PING_PONG)


@dataclass(frozen=True)
class Cells:
    """The polar map of one turn beside the truth, (look, gate); NaN in cells that do not count.

    Those count that are more than half visible and have a height that is not called ambiguous.
    """

    height: Field
    true: Field
    range: Field
    coherence: Field
    snr_db: Field
    radians_per_m: Field  # of phase for an upright array: 2πpB/(λR)
    azimuth: Field

    @classmethod
    def of(cls, turn: Turn, scene: Scene, mode: Mode, pairs: Pairs = "both") -> Cells:
        maps = sr.retrieve(turn.echoes, {"pulse_pairs": pairs})
        return cls.between(maps, turn.truth, scene.radar, mode.paths)

    @classmethod
    def between(cls, maps: xr.DataTree, truth: xr.DataTree, radar: RadarSettings, paths: int = 1) -> Cells:
        got, true = (tree["polar"].to_dataset().isel(turn=0) for tree in (maps, truth))
        clear = (got["quality"].values & QUALITY_FLAGS["ambiguous"]) == 0
        counted = clear & (true["visible_fraction"].values > 0.5)
        azimuth, ranges = np.meshgrid(got["azimuth"].values, got["range"].values, indexing="ij")
        sensitivity = 2.0 * np.pi * paths * radar.baseline_m * radar.frequency_hz / (SPEED_OF_LIGHT * ranges)
        height = np.where(counted, got["height"].values.astype(np.float64), np.nan)
        return cls(
            height,
            true["height"].values.astype(np.float64),
            ranges,
            got["coherence"].values.astype(np.float64),
            got["snr_db"].values.astype(np.float64),
            sensitivity,
            azimuth,
        )

    @property
    def error(self) -> Field:
        return self.height - self.true

    def within(self, low: float, high: float) -> NDArray[np.bool_]:
        """Cells that count from `low` to `high` metres."""
        return np.isfinite(self.error) & (self.range >= low) & (self.range < high)


def rms(values: Field) -> float:
    return float(np.sqrt(np.mean(values**2)))


def simulated(scene: Scene) -> Turn:
    return Simulator(scene).turn(0)


def with_noise(turn: Turn, radar: RadarSettings, seed: int, boat: Installation | None = None) -> Turn:
    """A turn that was simulated without noise as radar.noise would have it, bit by bit. boat: one that moves."""
    loud, voltage = radar.model_copy(update={"noise": True}), turn.echoes["voltage"].values.copy()
    add_noise(voltage, loud, pulses(boat or Installation(loud), turn.number), seed)
    echoes = turn.echoes.assign(voltage=turn.echoes["voltage"].copy(data=voltage))
    echoes.attrs["noise_power_w"] = gate_noise_power(Installation(loud))
    return replace(turn, echoes=echoes)


def spread(values: Iterable[float], digits: int = 3) -> str:
    """Mean ± standard deviation over seeds."""
    known = np.array(list(values), dtype=np.float64)
    return f"{known.mean():.{digits}f}±{known.std():.{digits}f}"


def bins(edges: Sequence[float] = BINS_M) -> list[tuple[float, float]]:
    return list(pairwise(edges))


# ------------------------------------------------------------------------------------------------- map

Maps = dict[tuple[Mode, bool], list[Cells]]  # of each mode, without noise and with it, by seed


def four_modes(scene: str, seeds: int, **keys: Any) -> Maps:
    """Maps of all modes: the same seas and, pulse by pulse, the same speckle."""
    maps: Maps = {(mode, noise): [] for mode in MODES for noise in (False, True)}
    for seed in range(1, seeds + 1):
        for mode in MODES:
            overrides = {
                "seed": seed,
                "radar.noise": False,
                "tracing.tracer": "horizon",
                "radar.range_m": [15.0, 310.0],
            }
            made = sr.load_scene(scene, overrides={**overrides, **mode.keys, **keys})
            turn = simulated(made)
            for noise in (False, True):
                heard = with_noise(turn, made.radar, seed) if noise else turn
                maps[mode, noise].append(Cells.of(heard, made, mode))
    return maps


def print_map(maps: Maps) -> None:
    print("\nErrors by range; ± over seeds. Phase: rms of the height error × 2πpB/(λR).")
    heading = ("rmse, m", "bias, m", "phase, rad", "coherence", "SNR, dB", "cells")
    print(f"{'mode':28} {'p':1} {'noise':5} {'range, m':9} " + " ".join(f"{name:>13}" for name in heading))
    for (mode, noise), seeds in maps.items():
        for low, high in bins():
            inside = [cells.within(low, high) for cells in seeds]
            each = list(zip(seeds, inside, strict=True))
            shown = (
                spread(rms(c.error[i]) for c, i in each),
                spread(c.error[i].mean() for c, i in each),
                spread(rms((c.error * c.radians_per_m)[i]) for c, i in each),
                spread(np.median(c.coherence[i]) for c, i in each),
                spread((np.median(c.snr_db[i]) for c, i in each), 1) if noise else "-",
                f"{np.mean([i.sum() for i in inside]):.0f}",
            )
            label = f"{mode!s:28} {mode.paths} {'on' if noise else 'off':5} {low:3.0f}–{high:3.0f}   "
            print(label + " ".join(f"{value:>13}" for value in shown))


# --------------------------------------------------------------------------------------------- doppler


def drifting(scene: str, look_deg: float, mode: Mode, seed: int, **keys: Any) -> Scene:
    """A flat sea, alike everywhere, that drifts east at 1 m/s with speckle that does not decorrelate."""
    flat: dict[str, Any] = {
        "seed": seed,
        "sea.waves": [],
        "sea.current_m_s": DRIFT_M_S,
        "sea.current_toward_deg": DRIFT_TOWARD,
        "scattering.nrcs": "constant",
        "scattering.doppler": "orbital",
        "scattering.decorrelation_time_s": np.inf,
        "radar.noise": False,
        "radar.sector_deg": [look_deg - 9.0, look_deg + 9.0],
        "radar.range_m": [15.0, 310.0],
        # The beam that sweeps over speckle has a Doppler of its own, of either sign: the slower the less.
        "radar.rotation_rpm": 10.0,
        "tracing.tracer": "horizon",
    }
    return sr.load_scene(scene, overrides={**flat, **mode.keys, **keys})


def doppler_height(cells: Cells, radar: RadarSettings, mode: Mode, pairs: Pairs) -> Field:
    """∓2vτR/(pB) of each cell [m]: what recedes reads too low by forward pairs, and too high by backward ones."""
    sign = {"forward": -1.0, "backward": 1.0, "both": 0.0}[pairs] if mode.alternating else 0.0
    level = np.sqrt(1.0 - (radar.height_m / cells.range) ** 2)  # the drift is level, the line of sight is not
    away = DRIFT_M_S * level * np.cos(np.radians(cells.azimuth - DRIFT_TOWARD))
    return sign * 2.0 * away / radar.prf_hz * cells.range / (mode.paths * radar.baseline_m)


def doppler_bias(
    scene: str, look_deg: float, mode: Mode, seeds: int, edges: Sequence[float] = BINS_M, **keys: Any
) -> dict[Pairs, NDArray[np.float64]]:
    """(range bin, simulated and predicted) mean height error [m] of each kind of pairs, over seeds."""
    choices: tuple[Pairs, ...] = ("forward", "backward", "both") if mode.alternating else ("both",)
    sums: dict[Pairs, NDArray[np.float64]] = {pairs: np.zeros((len(edges) - 1, 2)) for pairs in choices}
    for seed in range(1, seeds + 1):
        made = drifting(scene, look_deg, mode, seed, **keys)
        turn = simulated(made)
        for pairs in choices:
            cells = Cells.of(turn, made, mode, pairs)
            predicted = doppler_height(cells, made.radar, mode, pairs)
            for row, (low, high) in enumerate(bins(edges)):
                inside = cells.within(low, high)
                sums[pairs][row] += cells.error[inside].mean() / seeds, predicted[inside].mean() / seeds
    return sums


def print_doppler(scene: str, seeds: int) -> None:
    print(f"\nA flat sea that drifts at {DRIFT_M_S:g} m/s: mean height error, m, beside ∓2vτR/(pB);")
    print("measured/predicted from what a pair changes over both, which have the same speckle")
    heading = " ".join(f"{f'{low:.0f}–{high:.0f} m':>15}" for low, high in bins())
    print(f"{'mode':28} {'look':8} {'pairs':9} {heading} {'measured/predicted':>16}")
    for mode in (PING_PONG, ALTERNATING, SWITCHED):
        for look, name in ((90.0, "recedes"), (270.0, "comes")):
            biases = doppler_bias(scene, look, mode, seeds)
            for pairs, rows in biases.items():
                shown = " ".join(f"{got:+7.4f} {predicted:+7.4f}" for got, predicted in rows)
                ratio = "-"
                if pairs != "both":
                    each = (rows[:, 0] - biases["both"][:, 0]) / rows[:, 1]
                    ratio = f"{each.min():.4f}–{each.max():.4f}"
                print(f"{mode!s:28} {name:8} {pairs:9} {shown} {ratio:>16}", flush=True)


# -------------------------------------------------------------------------------------------- channels


def sector(scene: str, mode: Mode, seed: int, **keys: Any) -> Scene:
    """The scene's up-wave sector without noise."""
    overrides = {"seed": seed, "radar.noise": False, "tracing.tracer": "horizon", "radar.sector_deg": UP_WAVE}
    return sr.load_scene(scene, overrides={**overrides, "radar.range_m": [15.0, 310.0], **mode.keys, **keys})


def measured_channel_phase(echoes: xr.Dataset) -> float:
    """The upper receiver's phase over the lower's [deg], from the cross paths of switched transmitters.

    From lower to upper antenna an echo runs the same path as from upper to lower, one pulse later: what differs is the
    receivers, and Doppler, which pulses in the other order have the other way round.
    """
    voltage, sender = echoes["voltage"].values, echoes["transmitter"].values
    upper_heard, lower_heard = np.flatnonzero(sender == 0), np.flatnonzero(sender == 1)
    forward = upper_heard[np.isin(upper_heard + 1, lower_heard)]
    backward = upper_heard[np.isin(upper_heard - 1, lower_heard)]
    crosses = [
        np.sum(voltage[first, 1] * voltage[first + step, 0].conj(), dtype=np.complex128)
        for first, step in ((forward, 1), (backward, -1))
    ]
    return float(np.degrees(np.angle(sum(cross / np.abs(cross) for cross in crosses))))


FAULTS = {
    f"upper receiver {CHANNEL_DEG:g}° ahead": {"radar.channel_phase_deg": CHANNEL_DEG},
    f"baseline {1e3 * BASELINE_ERROR_M:g} mm longer": {"radar.baseline_error_m": BASELINE_ERROR_M},
}


def fault_height(cells: Cells, radar: RadarSettings, fault: dict[str, float]) -> Field:
    """Height [m] that a fault adds to each cell: φλR/(2πpB), or −(H − z) ΔB/B."""
    if "radar.channel_phase_deg" in fault:
        return np.radians(fault["radar.channel_phase_deg"]) / cells.radians_per_m
    return -(radar.height_m - cells.true) * fault["radar.baseline_error_m"] / radar.baseline_m


def print_channels(scene: str, seeds: int) -> None:
    print("\nWhat a fault adds to the mean height, m, beside φλR/(2πpB) and −(H − z) ΔB/B; no noise")
    ranges = bins(BINS_M[:4])
    heading = " ".join(f"{f'{low:.0f}–{high:.0f} m':>15}" for low, high in ranges)
    print(f"{'fault':32} {'mode':28} {heading}")
    estimated: list[float] = []
    for mode in MODES:
        shifts = {name: np.zeros((len(ranges), 2)) for name in FAULTS}
        for seed in range(1, seeds + 1):
            faultless = sector(scene, mode, seed)
            clean = Cells.of(simulated(faultless), faultless, mode)
            for name, fault in FAULTS.items():
                faulty = sector(scene, mode, seed, **fault)
                turn = simulated(faulty)
                if mode is SWITCHED and "radar.channel_phase_deg" in fault:
                    estimated.append(measured_channel_phase(turn.echoes))
                off, predicted = Cells.of(turn, faulty, mode), fault_height(clean, faultless.radar, fault)
                for row, (low, high) in enumerate(ranges):
                    inside = clean.within(low, high) & off.within(low, high)
                    more = (off.height - clean.height)[inside].mean()
                    shifts[name][row] += more / seeds, predicted[inside].mean() / seeds
        for name, rows in shifts.items():
            shown = " ".join(f"{got:+7.4f} {predicted:+7.4f}" for got, predicted in rows)
            print(f"{name:32} {mode!s:28} {shown}", flush=True)
    print(
        f"From the switched radar's own echoes, lower → upper against upper → lower: {spread(estimated, 4)}° of "
        f"{CHANNEL_DEG:g}°"
    )


# ---------------------------------------------------------------------------------------- decorrelation


def print_decorrelation(scene: str, seeds: int) -> None:
    print("\nA sea that forgets itself, 50–200 m, no noise: height rmse, m, and median coherence")
    combinations: tuple[tuple[Mode, Pairs], ...] = (
        (SWITCHED, "both"),
        (PING_PONG, "both"),
        (PING_PONG, "forward"),
        (ALTERNATING, "both"),
        (ALTERNATING, "forward"),
    )
    heading = " ".join(f"{name:>13}" for name in ("rmse, m", "bias, m", "coherence"))
    print(f"{'τc, ms':>6} {'prf, kHz':>8} {'mode':28} {'pairs':9} {heading} pair's")
    for tau in (10e-3, 2e-3):
        for prf in (10e3, 2e3):
            for mode in (SWITCHED, PING_PONG, ALTERNATING):
                keys = {"scattering.decorrelation_time_s": tau, "radar.prf_hz": prf}
                made = [sector(scene, mode, seed, **keys) for seed in range(1, seeds + 1)]
                turns = [simulated(each) for each in made]
                for other, pairs in combinations:
                    if other is not mode:
                        continue
                    each = [Cells.of(turn, one, mode, pairs) for turn, one in zip(turns, made, strict=True)]
                    inside = [c.within(50.0, 200.0) for c in each]
                    both = list(zip(each, inside, strict=True))
                    shown = (
                        spread(rms(c.error[i]) for c, i in both),
                        spread(c.error[i].mean() for c, i in both),
                        spread(np.median(c.coherence[i]) for c, i in both),
                    )
                    pair = np.exp(-((1.0 / (prf * tau)) ** 2)) if mode.alternating else 1.0
                    label = f"{1e3 * tau:6.0f} {1e-3 * prf:8.0f} {mode!s:28} {pairs if mode.alternating else '-':9} "
                    print(label + " ".join(f"{value:>13}" for value in shown) + f" {pair:6.4f}", flush=True)


# ------------------------------------------------------------------------------------------------ edges


def print_edges(scene: str, seeds: int) -> None:
    print("\nThe shadows' edges, no noise: height rmse, m (1 − median coherence in thousandths)")
    print("by rays the upper antenna lights what the lower does not hear; bent light has no such edge")
    ranges = bins(BINS_M[:4])
    print(f"{'light':12} {'facet, m':8} {'mode':28} " + " ".join(f"{f'{a:.0f}–{b:.0f} m':>20}" for a, b in ranges))
    for light, facet in (("none", 0.5), ("none", 0.25), ("knife_edge", 0.5)):
        for mode in (SINGLE, SWITCHED):
            keys = {"tracing.diffraction": light, "tracing.facet_m": facet, "radar.range_m": [15.0, 210.0]}
            made = [sector(scene, mode, seed, **keys) for seed in range(1, seeds + 1)]
            cells = [Cells.of(simulated(each), each, mode) for each in made]
            shown = []
            for low, high in ranges:
                inside = [c.within(low, high) for c in cells]
                lost = np.mean([1e3 * (1.0 - np.median(c.coherence[i])) for c, i in zip(cells, inside, strict=True)])
                errors = spread(rms(c.error[i]) for c, i in zip(cells, inside, strict=True))
                shown.append(f"{f'{errors} ({lost:4.1f})':>20}")
            print(f"{light:12} {facet:8.2f} {mode!s:28} {' '.join(shown)}", flush=True)


# ----------------------------------------------------------------------------------------------- answer


def phase_errors(maps: Maps, mode: Mode, low: float, high: float) -> tuple[list[float], list[float], list[float]]:
    """Rms of the phase by seed: without noise, what noise alone adds between the two maps, and with noise."""
    still, alone, noisy = [], [], []
    for clean, loud in zip(maps[mode, False], maps[mode, True], strict=True):
        inside = clean.within(low, high) & loud.within(low, high)
        scale = clean.radians_per_m
        still.append(rms((clean.error * scale)[inside]))
        noisy.append(rms((loud.error * scale)[inside]))
        alone.append(rms(((loud.height - clean.height) * scale)[inside]))
    return still, alone, noisy


def noise_ratio(mode: Mode, snr_db: Field) -> float:
    """Rms phase error by noise alone over that of single pulses, at equal pulses, over cells of these SNR (n,).

    Alternating, each receiver hears half of the pulses: var φ = (2/S + β/S²)/(2N) with N halved; of the noise's beat
    with itself, β, half is left, since each pulse meets two of the other receiver's.
    """
    if not mode.alternating:
        return 1.0
    noise = 10.0 ** (-0.1 * snr_db)
    return float(np.sqrt(2.0 * np.mean(2.0 * noise + 0.5 * noise**2) / np.mean(2.0 * noise + noise**2)))


def print_answer(maps: Maps) -> None:
    print("\nDoes switching minimise the phase error? Each mode's over that of the single transmitter on single pulses")
    heading = ("speckle", "noise alone", "predicted", "both", "height, both")
    print(f"{'mode':28} {'range, m':9} " + " ".join(f"{name:>13}" for name in heading))
    for low, high in bins():
        reference = phase_errors(maps, SINGLE, low, high)
        snr = np.concatenate([c.snr_db[c.within(low, high)] for c in maps[SINGLE, True]])
        for mode in MODES:
            still, alone, noisy = (
                np.array(own) / np.array(other)
                for own, other in zip(phase_errors(maps, mode, low, high), reference, strict=True)
            )
            predicted = f"{noise_ratio(mode, snr):.3f}"
            shown = (spread(still), spread(alone), predicted, spread(noisy), spread(noisy / mode.paths))
            print(f"{mode!s:28} {low:3.0f}–{high:3.0f}   " + " ".join(f"{value:>13}" for value in shown))


def main() -> None:
    arguments = options(__doc__, seeds=3, scene="choppy_sea", parts=",".join(PARTS))
    parts = arguments.parts.split(",")
    maps = four_modes(arguments.scene, arguments.seeds) if {"map", "answer"} & set(parts) else {}
    if "map" in parts:
        print_map(maps)
    if "doppler" in parts:
        print_doppler(arguments.scene, arguments.seeds)
    if "channels" in parts:
        print_channels(arguments.scene, arguments.seeds)
    if "decorrelation" in parts:
        print_decorrelation(arguments.scene, arguments.seeds)
    if "edges" in parts:
        print_edges(arguments.scene, arguments.seeds)
    if "answer" in parts:
        print_answer(maps)


if __name__ == "__main__":
    main()
