"""The published models of mean sea clutter compared with Nathanson's table, and a figure of both.

    python -m validation.scattering.nrcs [--wind] [--out validation/figures/nrcs_models.png]

Prints the mean absolute deviation, the mean and the worst one of each model at 9.3 GHz, 0.1–10° and sea states 1–5,
averaged over wind directions; of the facets' own echo, summed over simulated seas (`nrcs_facets.py`), raw and
calibrated to NRL 2012; and term by term what theory explains and what the calibration supplies. Draws σ0 against the
grazing angle at three sea states. Takes some five minutes.

`--wind` prints instead how the echo changes with direction: up- over cross-wind and up- over down-wind [dB] in sectors
of 60°, of theory alone, of GIT, and of theory calibrated, in a sea of 8 m/s, by grazing angle; and how means grow with
the wind, within the models' ranges and beyond 13.2 m/s, where NRL 2012 ends. Takes some two minutes.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from seamap_rt.conventions import db
from seamap_rt.report import style
from seamap_rt.scattering import wind_from_sea_state
from seamap_rt.scattering.composite import nrcs_level_sea
from seamap_rt.scattering.mean_models import MEAN_MODELS, MeanModel, mean_nrcs
from seamap_rt.settings import ScatteringSettings

from .. import FIGURES, REFERENCE
from ..options import options
from .nrcs_facets import GRAZING_DEG, SEEDS, levels, looks_by_wind

TABLE = REFERENCE / "nathanson_9p3ghz.csv"
FREQUENCY_HZ = 9.3e9
SEA_STATES = range(1, 6)
DRAWN = (1, 3, 5)
LINES = (
    (style.BLUE, "-"),
    (style.VERMILION, "-"),
    (style.GREEN, "-"),
    (style.PURPLE, "-"),
    (style.ORANGE, "-"),
    (style.ORANGE, ":"),
    (style.SKY, "--"),
)

# (grazing_deg, sea_state, polarization) → linear σ0 at 9.3 GHz, mean over wind directions, NaN where it says nothing
Curve: TypeAlias = Callable[[NDArray[np.float64], float, str], NDArray[np.float64]]


@dataclass(frozen=True)
class Measured:
    """One line of Nathanson's table."""

    grazing_deg: float
    polarization: str
    level_db: dict[int, float]  # by sea state


def nathanson() -> list[Measured]:
    """The table, without its empty entries."""
    lines = [line for line in TABLE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return [
        Measured(
            float(row["grazing_deg"]),
            row["polarization"],
            {int(name[2:]): float(value) for name, value in row.items() if name.startswith("ss") and value},
        )
        for row in csv.DictReader(lines)
    ]


def curves() -> list[tuple[str, Curve]]:
    """Label and σ0 of all that is compared: further ones go here."""
    published = [(model.paper, curve_of(model)) for model in MEAN_MODELS.values()]
    return [
        *published,
        ("two_scale, raw theory", facets_raw),
        ("two_scale, raw, knife edges", facets_diffracted),
        ("two_scale, calibrated", facets_calibrated),
    ]


def facets_raw(grazing_deg: NDArray[np.float64], sea_state: float, polarization: str) -> NDArray[np.float64]:
    """What the facets of a simulated sea return by theory alone."""
    return between_bands(grazing_deg, levels(sea_state, polarization).raw)


def facets_diffracted(grazing_deg: NDArray[np.float64], sea_state: float, polarization: str) -> NDArray[np.float64]:
    """By theory alone, with diffraction at the shadows' edges in place of geometric shadows."""
    return between_bands(grazing_deg, levels(sea_state, polarization, diffraction="knife_edge").raw)


def facets_calibrated(grazing_deg: NDArray[np.float64], sea_state: float, polarization: str) -> NDArray[np.float64]:
    """What they return in a run, whose mean is calibrated to NRL 2012."""
    return between_bands(grazing_deg, levels(sea_state, polarization).calibrated)


def between_bands(grazing_deg: NDArray[np.float64], sigma: NDArray[np.float64]) -> NDArray[np.float64]:
    """Levels between the bands of grazing in which they were summed, straight in decibels against the logarithm."""
    at = np.log(np.asarray(grazing_deg) * (1.0 + 1e-12))
    return 10.0 ** np.interp(at, np.log(GRAZING_DEG), np.log10(sigma), left=np.nan, right=np.nan)


def curve_of(model: MeanModel) -> Curve:
    """A published model within its own range."""

    def sigma(grazing_deg: NDArray[np.float64], sea_state: float, polarization: str) -> NDArray[np.float64]:
        least, most = model.grazing_deg
        inside = (grazing_deg >= least) & (grazing_deg <= most)
        clipped = model.function(grazing_deg, sea_state, FREQUENCY_HZ, polarization, clipped=True)
        return np.where(inside, clipped, np.nan)

    return sigma


# --------------------------------------------------------------------------------------------------------- deviations


def deviations(
    curve: Curve, polarization: str, table: list[Measured], least_grazing: float = 0.0
) -> NDArray[np.float64]:
    """dB of the curve over the table, at each of its points, from a grazing angle up, that the curve covers."""
    values = [
        float(db(curve(np.array(row.grazing_deg), float(state), polarization))) - row.level_db[state]
        for row in table
        if row.polarization == polarization and row.grazing_deg >= least_grazing
        for state in SEA_STATES
        if state in row.level_db
    ]
    return np.array([each for each in values if np.isfinite(each)])


def print_deviations(compared: list[tuple[str, Curve]], table: list[Measured]) -> None:
    print("dB over Nathanson's table, 9.3 GHz, sea states 1 to 5: mean absolute deviation, mean, worst")
    print(f"{'':<40}{'0.1° to 10°':>30}{'1° to 10°':>30}")
    for label, curve in compared:
        for polarization in ("HH", "VV"):
            cells = [f"{label:<37}{polarization:<3}"]
            for least in (0.1, 1.0):
                errors = deviations(curve, polarization, table, least)
                worst = errors[np.argmax(np.abs(errors))]
                cells.append(f"{np.mean(np.abs(errors)):12.1f}{np.mean(errors):+9.1f}{worst:+9.1f}")
            print("".join(cells))


def print_terms(table: list[Measured]) -> None:
    """What each term of the theory adds, what calibration adds, and how close the result is to the model."""
    given = {(row.grazing_deg, row.polarization): row.level_db for row in table}
    print("\ntwo_scale by term, dB: first-order Bragg on a plane; that of the tilted facets, shadows included; with")
    print("mirrors; with breakers: raw theory; that with knife edges for geometric shadows; NRL 2012; calibrated less")
    print("NRL 2012; Nathanson's table")
    names = ("plane", "tilted", "mirrors", "raw", "edges", "NRL", "cal−NRL", "table")
    print(f"{'':12}" + "".join(f"{name:>10}" for name in names))
    worst = 0.0
    for state in SEA_STATES:
        for polarization in ("HH", "VV"):
            computed = levels(float(state), polarization)
            tilted = computed.terms["bragg"]
            edges = levels(float(state), polarization, diffraction="knife_edge").raw
            rows = [computed.flat, tilted, tilted + computed.terms["specular"], computed.raw, edges, computed.target]
            off = db(computed.calibrated / computed.target)
            worst = max(worst, float(np.max(np.abs(off))))
            for band, grazing in enumerate(GRAZING_DEG):
                level = given.get((float(grazing), polarization), {}).get(state)
                if level is None:
                    continue
                cells = "".join(f"{float(db(row[band])):10.1f}" for row in rows)
                print(f"SS{state} {polarization} {grazing:4.1f}°{cells}{off[band]:+10.2f}{level:10.0f}")
    print(f"calibrated less its mean model: at most {worst:.2f} dB in any band (mean of {len(SEEDS)} seas)")


# ------------------------------------------------------------------------------------------------------ by the wind


def print_contrasts(wind_speed: float, seeds: tuple[int, ...]) -> None:
    """Up- over cross-wind and up- over down-wind."""
    print(f"wind {wind_speed:g} m/s, {len(seeds)} seas; dB up/cross, up/down ± the standard error of the latter")
    names = ("theory", "GIT", "to NRL", "to NRL, by both", "to GIT")
    print(f"{'':9}" + "".join(f"{name:>20}" for name in names))
    for polarization in ("VV", "HH"):
        looks = looks_by_wind(wind_speed, polarization, seeds)
        for band, grazing in enumerate(GRAZING_DEG):
            cells = []
            for level in looks:
                across, down = (db(level[:, 0, band] / level[:, each, band]) for each in (1, 2))
                error = float(np.std(down, ddof=1)) / np.sqrt(len(seeds))
                cells.append(f"{np.mean(across):9.1f}{np.mean(down):5.1f} ± {error:.1f}")
            print(f"{polarization} {grazing:5.1f}°" + "".join(f"{cell:>20}" for cell in cells), flush=True)


def print_growth() -> None:
    """How the mean grows with the wind: what theory supplies beyond the models' winds, and what they say within."""
    last = float(wind_from_sea_state(6.0))
    steps = ((float(wind_from_sea_state(4.0)), last), (last, 15.0), (last, 18.0), (last, 25.0))
    grazing = np.array([0.3, 1.0, 3.0, 10.0])
    print("\ngrowth of the mean, dB, at " + ", ".join(f"{angle:g}°" for angle in grazing))
    for polarization in ("VV", "HH"):
        settings = ScatteringSettings.model_validate({"polarization": polarization})
        for start, end in steps:
            theory = [
                nrcs_level_sea(settings.model_copy(update={"wind_speed_m_s": speed}), FREQUENCY_HZ, np.radians(grazing))
                for speed in (start, end)
            ]
            cells = [("theory", theory)]
            for name in MEAN_MODELS:
                ends = (mean_nrcs(name, grazing, v, FREQUENCY_HZ, polarization, extrapolate=True) for v in (start, end))
                cells.append((name, list(ends)))
            words = "; ".join(f"{name} " + " ".join(f"{each:.1f}" for each in db(b / a)) for name, (a, b) in cells)
            print(f"{polarization} {start:.1f} to {end:.1f} m/s: {words}")


# ------------------------------------------------------------------------------------------------------------ picture


@style.styled
def draw(compared: list[tuple[str, Curve]], table: list[Measured]) -> Figure:
    """HH above VV, calm to rough from left to right."""
    figure = style.new_figure(5.2)
    for row, polarization in enumerate(("HH", "VV")):
        for column, state in enumerate(DRAWN):
            axes = style.place(figure, 0.5 + 2.27 * column, 0.3 + 2.25 * row, 1.95, 1.75)
            draw_panel(axes, polarization, state, compared, table)
            if column == 0:
                axes.set_ylabel("σ0, dB")
            else:
                axes.tick_params(labelleft=False)
            if row == 0:
                axes.set_xlabel("")
                axes.tick_params(labelbottom=False)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=3, bbox_to_anchor=(0.5, 0.0))
    return figure


def draw_panel(
    axes: Axes, polarization: str, state: int, compared: list[tuple[str, Curve]], table: list[Measured]
) -> None:
    style.graph(axes, "grazing angle, °", "", f"{polarization}, sea state {state}")
    grazing = np.geomspace(0.1, 60.0, 300)
    for (label, curve), (colour, dash) in zip(compared, LINES, strict=True):
        level = db(curve(grazing, float(state), polarization))
        axes.semilogx(grazing, level, color=colour, linestyle=dash, label=label)
    points = [row for row in table if row.polarization == polarization and state in row.level_db]
    axes.plot(
        [row.grazing_deg for row in points],
        [row.level_db[state] for row in points],
        color=style.BLACK,
        marker="o",
        markersize=3.5,
        linestyle="",
        label="Nathanson 1991, table",
    )
    axes.set_xlim(0.08, 70.0)
    axes.set_ylim(-90.0, 0.0)
    axes.set_yticks(np.arange(-90.0, 1.0, 15.0))
    axes.set_xticks([0.1, 1.0, 10.0], ["0.1", "1", "10"])


def main() -> None:
    chosen = options(__doc__, out=FIGURES / "nrcs_models.png", wind=False)
    if chosen.wind:
        print_contrasts(8.0, SEEDS)
        print_growth()
        return
    compared, table = curves(), nathanson()
    print_deviations(compared, table)
    print_terms(table)
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    chosen.out.write_bytes(style.png(draw(compared, table)))


if __name__ == "__main__":
    main()
