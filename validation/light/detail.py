"""What the mesh's facets cost the maps: predicted by `seamap_rt/mesh/sizing.py`, and measured against a finer mesh.

Both by straight rays. Light that bends over crests turns on details of centimetres: a finer mesh draws other errors of
that kind, as large. The last table shows it: rms error, bias and share within 1.96 bars of maps of `choppy_sea`.

    python -m validation.light.detail [--quick]

Twelve degrees of each sea are simulated in the expectation over speckle on meshes of 0.25 to 1.5 m and three to eight
columns a beam, and on one of 0.125 m and sixteen, all with the same calibration: the rms differences of height, power
and visible share over the cells that are more than half visible. The table has each as measured/predicted for the whole
window; its last lines, how far the predictions are off. The figure has the errors by range. About four minutes of
one core; --quick (three seas, four meshes) forty seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.echoes import expected_look_gates
from seamap_rt.echoes.radar_cross_section import SeaSurface
from seamap_rt.mesh.sizing import MeshDetail
from seamap_rt.simulation import Simulator
from seamap_rt.truth import polar_truth

from .. import FIGURES
from ..options import options

BANDS_M = (15.0, 25.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0, 400.0)
MESHES = ((0.25, 4), (0.25, 8), (0.5, 3), (0.5, 4), (0.8, 3), (0.8, 4), (0.8, 6), (1.0, 4), (1.5, 4))
QUICK_MESHES = ((0.25, 4), (0.5, 4), (0.8, 3), (1.0, 4))
REFERENCE = (0.125, 16)
UNITS = (("height", 1e3, "mm"), ("power", 1.0, "dB"), ("visible share", 100.0, "%"))
FEWEST_CELLS = 30  # of a band, to tell an rms


def wind_sea(height: float, period: float) -> dict[str, float]:
    return {"sea.waves.0.significant_wave_height_m": height, "sea.waves.0.peak_period_s": period}


HH = {"scattering.polarization": "HH", "scattering.sea_spikes": False}  # spikes are drawn, mesh by mesh
SHORT = {"radar.pulse_width_s": 1e-8, "radar.bandwidth_hz": 1e8, "radar.range_sampling_m": 0.75}
CASES: dict[str, tuple[str, float, dict[str, Any]]] = {  # scene, look, other keys
    "1.4 m, up the waves": ("choppy_sea", 270.0, {}),
    "1.4 m, aslant": ("choppy_sea", 225.0, {}),
    "1.4 m, along the crests": ("choppy_sea", 180.0, {}),
    "1.4 m, down the waves": ("choppy_sea", 90.0, {}),
    "1.4 m, HH, up": ("choppy_sea", 270.0, HH),
    "1.4 m, HH, along": ("choppy_sea", 180.0, HH),
    "1.4 m, 12 m mast": ("choppy_sea", 270.0, {"radar.height_m": 12.0}),
    "1.4 m, cells of 1.5 m": ("choppy_sea", 270.0, {**SHORT, "retrieval.cell_range_m": 1.5}),
    "1.4 m, every lit facet alike": ("choppy_sea", 270.0, {"scattering.nrcs": "nrl"}),
    "0.5 m, 3.5 s, up": ("choppy_sea", 270.0, wind_sea(0.5, 3.5)),
    "0.5 m, 3.5 s, along": ("choppy_sea", 180.0, wind_sea(0.5, 3.5)),
    "4 m, 8 s, up": ("choppy_sea", 270.0, wind_sea(4.0, 8.0)),
    "waves to 0.8 m resolved": ("choppy_sea", 270.0, {"sea.resolution_m": 0.4}),
    "long-crested swell": ("long_crested_swell", 270.0, {}),
    "long-crested swell, aslant": ("long_crested_swell", 306.0, {}),
    "wind and swell, up the wind": ("wind_and_swell", 225.0, {}),
    "wind and swell, up the swell": ("wind_and_swell", 315.0, {}),
    "sinusoid": ("sinusoid", 270.0, {}),
    "calm": ("calm", 270.0, {}),
}
QUICK_CASES = ("1.4 m, up the waves", "1.4 m, along the crests", "0.5 m, 3.5 s, up")


@dataclass(frozen=True)
class Maps:
    """Of one mesh, in the expectation over speckle; (look, gate)."""

    range: NDArray[np.float64]  # (gate,) m
    power: NDArray[np.float64]  # W
    covariance: NDArray[np.complex128]
    visible: NDArray[np.float64]
    radians_a_metre: NDArray[np.float64]  # (gate,) of the interferogram, by height
    detail: MeshDetail


def mesh_keys(mesh: tuple[float, int]) -> dict[str, Any]:
    return {"tracing.tracer": "horizon", "tracing.facet_m": mesh[0], "tracing.columns_per_beam": mesh[1]}


def maps(case: str, mesh: tuple[float, int], surface: SeaSurface | None) -> tuple[Maps, SeaSurface]:
    """The maps of a case on a mesh of rungs and columns, and how its sea scatters: by `surface`, if it is given."""
    name, look, keys = CASES[case]
    keys = {**keys, "radar.sector_deg": [look - 6.0, look + 6.0], "tracing.diffraction": "none"}
    scene = sr.load_scene(name, keys | mesh_keys(mesh))
    simulator = Simulator(scene)
    if surface is not None:
        simulator._surface = surface
    facets, returns, _ = simulator.light(0)
    gates = expected_look_gates(facets, returns.rcs, simulator.installation, scene.retrieval.cell_azimuth_deg)
    visible = polar_truth(facets, returns.rcs, simulator.installation, scene.retrieval, 0)["visible_fraction"].values[0]
    turning = 2.0 * np.pi / scene.wavelength_m * scene.radar.baseline_m / gates.range
    made = Maps(gates.range, _cells(gates.power[0, 0]), _cells(gates.covariance), visible, turning, scene.detail)
    return made, simulator.surface


def _cells(gates: NDArray) -> NDArray:
    """Gates gathered into cells of two gates' length."""
    cells = gates.copy()
    cells[:, 1:-1] = 0.25 * gates[:, :-2] + 0.5 * gates[:, 1:-1] + 0.25 * gates[:, 2:]
    return cells


def differences(simulated: Maps, exact: Maps) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Height [m], power [dB] and visible share of a mesh less those of the finest, and which cells count."""
    with np.errstate(divide="ignore", invalid="ignore"):
        power = 10.0 * np.log10(simulated.power / exact.power)
    height = np.angle(simulated.covariance * exact.covariance.conj()) / exact.radians_a_metre
    return np.stack((height, power, simulated.visible - exact.visible)), exact.visible > 0.5


def map_errors(light: str, mesh: tuple[float, int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Height errors [m] of cells that are more than half visible, and those over their bars, of three turns."""
    errors = []
    for seed in (88101, 88102, 88103):
        keys = {"seed": seed, "radar.noise": False, "tracing.diffraction": light} | mesh_keys(mesh)
        simulation = sr.simulate(sr.load_scene("choppy_sea", keys))
        found, true = (
            tree["polar"].to_dataset().isel(turn=0) for tree in (sr.retrieve(simulation.echoes), simulation.truth)
        )
        chosen = (true["visible_fraction"] > 0.5) & (true["range"] >= 50.0) & (true["range"] < 200.0)
        error = (found["height"] - true["height"]).where(chosen)
        both = np.stack((error.values, (error / found["height_std"]).values)).reshape(2, -1)
        errors.append(both[:, np.isfinite(both).all(axis=0)])
    whole = np.concatenate(errors, axis=1)
    return whole[0], whole[1]


def rms(errors: NDArray[np.float64], kept: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(quantity,) over the cells that count."""
    return np.sqrt(np.mean(errors[:, kept] ** 2, axis=-1))


def by_band(errors: NDArray[np.float64], kept: NDArray[np.bool_], ranges: NDArray[np.float64]) -> NDArray[np.float64]:
    """(quantity, band) rms; NaN where too few cells are seen."""
    bands = [kept & ((ranges >= a) & (ranges < b)) for a, b in pairwise(BANDS_M)]
    nothing = np.full(3, np.nan)
    return np.stack([rms(errors, each) if each.sum() >= FEWEST_CELLS else nothing for each in bands], axis=1)


def draw(curves: dict[str, list[tuple[tuple[float, int], NDArray[np.float64], MeshDetail]]], path: Path) -> None:
    """Errors by range: measured as points, predicted as lines."""
    figure, axes = plt.subplots(3, len(curves), figsize=(4.2 * len(curves), 9.0), sharex=True, squeeze=False)
    middles = 0.5 * (np.array(BANDS_M[1:]) + np.array(BANDS_M[:-1]))
    for column, (case, meshes) in zip(axes.T, curves.items(), strict=True):
        column[0].set_title(case)
        for number, (mesh, bands, detail) in enumerate(meshes):
            predicted = np.array(detail.by_range).T
            for axis, quantity, row, (_, scale, _) in zip(column, bands, predicted[1:], UNITS, strict=True):
                axis.plot(middles, scale * quantity, "o", color=f"C{number}", ms=4)
                axis.plot(predicted[0], scale * row, color=f"C{number}", label=f"{mesh[0]:g} m, {mesh[1]} columns")
        for axis, (what, _, unit) in zip(column, UNITS, strict=True):
            axis.set_ylabel(f"{what}, rms ({unit})")
            axis.set_ylim(bottom=0.0)
        column[-1].set_xlabel("range (m)")
    figure.suptitle("What the mesh costs the maps: predicted (lines), measured against 0.125 m and 16 columns (points)")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=5)
    figure.tight_layout(rect=(0.0, 0.06, 1.0, 1.0))
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=110)


def main() -> None:
    quick = options(__doc__, quick=False).quick
    cases, meshes = (QUICK_CASES, QUICK_MESHES) if quick else (tuple(CASES), MESHES)
    ratios, curves = [], {}
    print("measured/predicted".ljust(30) + "".join(f"{f'{f:g} m × {c}':>34}" for f, c in meshes))
    print(" " * 30 + f"{'height mm, power dB, visible %':>34}" * len(meshes))
    for case in cases:
        _, surface = maps(case, (0.5, 4), None)
        exact, _ = maps(case, REFERENCE, surface)
        line, curve = case.ljust(30), []
        for mesh in meshes:
            simulated, _ = maps(case, mesh, surface)
            errors, kept = differences(simulated, exact)
            measured, detail = rms(errors, kept), simulated.detail
            predicted = np.array([detail.height_error_m, detail.power_error_db, detail.visible_error])
            ratios.append(measured / predicted)
            pairs = zip(measured, predicted, UNITS, strict=True)
            line += "  ".join(f"{scale * m:.2g}/{scale * p:.2g}" for m, p, (_, scale, _) in pairs).rjust(34)
            curve.append((mesh, by_band(errors, kept, exact.range), detail))
        print(line, flush=True)
        if case in QUICK_CASES:
            curves[case] = curve
    for (what, _, _), ratio in zip(UNITS, np.array(ratios).T, strict=True):
        within = np.mean((ratio < 1.5) & (ratio > 1.0 / 1.5))
        print(
            f"{what}: measured/predicted {np.exp(np.mean(np.log(ratio))):.2f} in the mean, {ratio.min():.2f} to "
            f"{ratio.max():.2f}, {within:.0%} of {ratio.size} within a factor 1.5"
        )
    draw(curves, FIGURES / "detail.png")
    print("\n| choppy_sea, 50–200 m, no noise | rms, m | bias, m | within 1.96, % |\n|---|---|---|---|")
    for light, mesh in (("none", (0.8, 4)), *product(("knife_edge",), ((0.8, 4), (0.8, 16), (0.4, 16)))):
        error, ratio = map_errors(light, mesh)
        within = 100.0 * np.mean(np.abs(ratio) < 1.96)
        figures = f"{np.sqrt(np.mean(error**2)):.3f} | {error.mean():.3f} | {within:.0f}"
        print(f"| {light}, {mesh[0]:g} m × {mesh[1]} | {figures} |", flush=True)


if __name__ == "__main__":
    main()
