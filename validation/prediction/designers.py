"""What forecasts at the boat are worth against turns, mast, baseline, steepness and speed, as one figure for designers.

    python -m validation.prediction.designers [--seeds 2] [--first 641] [--out validation/figures/forecast_design.png]

`choppy_sea` with one thing changed at a time, by the horizon tracer, with the 1 W radar's noise: from the tenth turn of
24 on each second turn's forecast is compared with the scene's own sea along the boat's way, 5–10 s and 11–20 s ahead.
Persistence holds the height that the boat is believed to have now.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import seamap_rt as sr
from seamap_rt.forecast_errors import true_elevation
from seamap_rt.prediction import Predictor
from seamap_rt.report import style
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator

from ..options import options
from ..retrieval.seas import system

TURNS, FIRST, EACH = 24, 9, 2
SPANS = {"5–10 s": (5.0, 10.0), "11–20 s": (11.0, 20.0)}
MEMORIES = (1, 2, 3, 5, 10, 20)
PEAK_M = 47.2  # of choppy_sea, 5.5 s on deep water
DESIGNS: dict[str, dict[float, dict[str, Any]]] = {
    "Turns in the fit": {float(each): {} for each in MEMORIES},
    "Mast (m)": {each: {"radar.height_m": each} for each in (3.0, 5.0, 8.0, 12.0)},
    "Baseline (m)": {each: {"radar.baseline_m": each} for each in (0.1, 0.2, 0.4)},
    "Hs over wavelength": {
        round(height / PEAK_M, 4): {"sea.waves": [system(height, 5.5)]} for height in (0.5, 1.4, 2.0)
    },
    "Boat speed (m/s)": {each: {"platform.speed_m_s": each} for each in (0.0, 3.0, 8.0)},
}


def scene_of(seed: int, turns: int = TURNS, **changed: Any) -> Scene:
    """`choppy_sea` by the horizon tracer with some keys changed."""
    return sr.load_scene("choppy_sea", {"seed": seed, "turns": turns, "tracing.tracer": "horizon"} | changed)


def errors(scene: Scene, memories: Iterable[int] = (10,)) -> dict[int, dict[str, np.ndarray]]:
    """For each number of turns in the fit: `mean`, `std`, `kept` (as now) and `truth` (forecast, lead) by `lead`."""
    simulator, settings = Simulator(scene), scene.resolved_prediction
    told = settings.sharpness, settings.amplitude_dispersion
    predictors = {number: Predictor(number, settings.lead_s, *told) for number in memories}
    rows: dict[int, dict[str, list[np.ndarray]]] = {
        number: {"mean": [], "std": [], "kept": [], "truth": []} for number in predictors
    }
    lead = np.arange(0.0, 31.0)
    for number in range(scene.turns):
        polar = sr.retrieve(simulator.turn(number).echoes, scene.resolved_retrieval)["polar"].to_dataset()
        for memory, predictor in predictors.items():
            field = predictor.turn(polar.isel(turn=0))
            if field is None or number < FIRST or (number - FIRST) % EACH:
                continue
            heading, speed = settings.heading_deg or 0.0, settings.speed_m_s or 0.0
            made = sr.forecast(field, lead_s=lead, draws=0, heading_deg=heading, speed_m_s=speed)
            mean, std = (made[name].values[0, :, 0].astype(np.float64) for name in ("elevation", "elevation_std"))
            parts = mean, std, np.full(lead.size, mean[0]), true_elevation(simulator.sea, made)[0, :, 0]
            for name, part in zip(rows[memory], parts, strict=True):
                rows[memory][name].append(part)
    return {
        number: {name: np.array(parts) for name, parts in each.items()} | {"lead": lead}
        for number, each in rows.items()
    }


def figures(parts: list[dict[str, np.ndarray]], span: tuple[float, float]) -> dict[str, float]:
    """Of some seeds together, over one span of leads: shares of the standard deviation of the sea that came."""
    inside = (parts[0]["lead"] >= span[0]) & (parts[0]["lead"] <= span[1])
    mean, std, kept, truth = (
        np.concatenate([part[name][:, inside].ravel() for part in parts]) for name in ("mean", "std", "kept", "truth")
    )
    sigma = float(np.std(np.concatenate([part["truth"].ravel() for part in parts])))
    return {
        "correlation": float(np.corrcoef(mean, truth)[0, 1]),
        "error": float(np.sqrt(np.mean((mean - truth) ** 2))) / sigma,
        "stated": float(np.sqrt(np.mean(std**2))) / sigma,
        "persistence": float(np.sqrt(np.mean((kept - truth) ** 2))) / sigma,
    }


def studied(seeds: list[int]) -> dict[str, dict[float, dict[str, dict[str, float]]]]:
    """Figures by design, value and span of leads; what is the scene's own is simulated once."""
    made: dict[str, dict[float, dict[str, dict[str, float]]]] = {}
    own = [errors(scene_of(seed), MEMORIES) for seed in seeds]
    default = {"Mast (m)": 5.0, "Baseline (m)": 0.2, "Boat speed (m/s)": 0.0}
    for name, values in DESIGNS.items():
        made[name] = {}
        for value, changed in values.items():
            if name.startswith("Turns"):
                parts = [each[int(value)] for each in own]
            elif default.get(name) == value or changed.get("sea.waves") == [system(1.4, 5.5)]:
                parts = [each[10] for each in own]
            else:
                parts = [errors(scene_of(seed, **changed))[10] for seed in seeds]
            made[name][value] = {words: figures(parts, span) for words, span in SPANS.items()}
            for words, found in made[name][value].items():
                told = ", ".join(f"{key} {number:.3f}" for key, number in found.items())
                print(f"{name} {value:g}, {words}: {told}", flush=True)
    return made


@style.styled
def draw(made: dict[str, dict[float, dict[str, dict[str, float]]]]) -> Figure:
    """A panel for each thing that was changed."""
    figure = style.new_figure(2.5)
    for number, (name, values) in enumerate(made.items()):
        axes = style.place(figure, 0.5 + 1.36 * number, 0.3, 1.14, 1.4)
        for words, colour in zip(SPANS, (style.BLUE, style.ORANGE), strict=True):
            for key, line in (("error", "o-"), ("stated", "--")):
                label = f"{words} ahead, {'found' if key == 'error' else 'stated'}"
                each = [found[words][key] for found in values.values()]
                axes.plot(list(values), each, line, color=colour, markersize=3.0, label=label)
        style.graph(axes, name, "Rms error over σ" if not number else "", "")
        axes.set_ylim(0.0, 0.6)
        if name.startswith("Turns"):
            axes.set_xscale("log")
            axes.set_xticks(MEMORIES, [str(each) for each in MEMORIES], minor=False)
            axes.minorticks_off()
        if number:
            axes.tick_params(labelleft=False)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=4, bbox_to_anchor=(0.5, 0.0))
    return figure


def main() -> None:
    given = options(__doc__, seeds=2, first=641, out=Path("validation/figures/forecast_design.png"))
    made = studied([given.first + number for number in range(given.seeds)])
    given.out.write_bytes(style.png(draw(made)))
    print(given.out)


if __name__ == "__main__":
    main()
