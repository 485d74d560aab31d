"""How spiky the simulated echo is: the shape parameter ν of its K-distribution, from the resolved waves alone.

    python -m validation.scattering.texture [--scene choppy_sea] [--seeds 4] [--out PNG] [--set KEY=VALUE]…

In the K-distribution (Ward 1981) the mean power of a cell is itself random, gamma distributed with shape ν: the
smaller, the spikier. Here that texture is what the resolved waves do to the power of a cell, by tilt, shadow, strain
and breakers: no random texture is put in. ν = 1/(⟨w²⟩/⟨w⟩² − 1) of the speckle-averaged, noise-free power w
(`sr.expected`) of single looks and gates, in bands of range, each gate divided by its mean over looks so that a trend
along the range does not count as texture. Beside it the empirical law for grazing X-band clutter (Watts & Wicks 1990;
Ryan & Johnson 1992): log10 ν = 2/3 log10 ψ° + 5/8 log10 A + δ − K, A the cell's area, δ = −1/3 looking up or down the
swell and +1/3 across it, K = 1 for VV and 1.7 for HH. Its own scatter about measurements is a factor of two or three.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT, wrap_degrees
from seamap_rt.report.reduce import main_waves
from seamap_rt.scene import Scene

from .. import FIGURES

FIGURE = FIGURES / "texture.png"
BANDS_M = (30.0, 50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 400.0)
SECTORS = {"along": (0.0, 180.0), "across": (90.0, 270.0)}  # look − the waves' direction, ±30°
WATTS = {"VV": 1.0, "HH": 1.7}
SWELL = {"along": -1.0 / 3.0, "across": 1.0 / 3.0}


def empirical_shape(grazing_deg: NDArray, area_m2: NDArray, polarization: str, sector: str) -> NDArray:
    """ν of Watts & Wicks (1990)."""
    exponent = 2.0 / 3.0 * np.log10(grazing_deg) + 0.625 * np.log10(area_m2) + SWELL[sector] - WATTS[polarization]
    return 10.0**exponent


def shapes(scene: Scene, seeds: int) -> dict[str, NDArray]:
    """ν by sector, (band,): moments of the normalised power are gathered over looks, gates and seeds."""
    moments = {name: np.zeros((3, len(BANDS_M) - 1)) for name in SECTORS}
    waves = main_waves(scene)
    if waves is None:
        raise SystemExit(f"scene '{scene.name}': has no waves with a direction; choose another")
    for seed in range(1, seeds + 1):
        power = sr.expected(scene.model_copy(update={"seed": seed}))["power"]
        levels = power.values[0, 0]
        angle = wrap_degrees(power["azimuth"].values - waves.from_deg)
        ranges = power["range"].values
        for name, middles in SECTORS.items():
            looks = np.any([np.abs(wrap_degrees(angle - middle)) <= 30.0 for middle in middles], axis=0)
            for band, (near, far) in enumerate(pairwise(BANDS_M)):
                gates = (ranges >= near) & (ranges < far)
                cells = levels[looks][:, gates] * ranges[gates] ** 3
                cells = cells / cells.mean(axis=0)  # the mean over looks: a trend along the range does not count
                moments[name][:, band] += (cells.size, cells.sum(), np.sum(cells**2))
    with np.errstate(divide="ignore", invalid="ignore"):
        return {name: 1.0 / (n * square / total**2 - 1.0) for name, (n, total, square) in moments.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="choppy_sea")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--out", type=Path, default=FIGURE)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    arguments = parser.parse_args()
    overrides = dict(each.split("=", 1) for each in arguments.set)
    overrides.setdefault("tracing.tracer", "horizon")
    middle = np.sqrt(np.multiply(BANDS_M[:-1], BANDS_M[1:]))
    figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.8), sharey=True)
    print(f"{'':10}{'':8}" + "".join(f"{value:9.0f}" for value in middle) + "   m")
    for panel, polarization in zip(panels, WATTS, strict=True):
        scene = sr.load_scene(arguments.scene, {**overrides, "scattering.polarization": polarization})
        radar = scene.radar
        grazing = np.degrees(np.arcsin(radar.height_m / middle))
        cell = np.radians(radar.antenna.azimuth_beamwidth_deg) * middle * 0.5 * SPEED_OF_LIGHT * radar.pulse_width_s
        simulated = shapes(scene, arguments.seeds)
        for name, colour in (("along", "C0"), ("across", "C1")):
            law = empirical_shape(grazing, cell, polarization, name)
            for label, values, form in (("simulated", simulated[name], "-o"), ("Watts & Wicks 1990", law, "--")):
                print(f"{polarization} {name:7}{label[:9]:>8}" + "".join(f"{value:9.2f}" for value in values))
                panel.loglog(middle, values, form, color=colour, markersize=4, label=f"{name} the waves, {label}")
        panel.set(title=f"{polarization}", xlabel="Range (m)")
        panel.set_xticks([50.0, 100.0, 200.0, 400.0], ["50", "100", "200", "400"])
        panel.set_xticks([], minor=True)
        panel.grid(True, which="both", linewidth=0.3)
    panels[0].set_ylabel("shape parameter ν of the K-distribution")
    panels[0].legend(fontsize=7)
    figure.suptitle(f"{arguments.scene}: texture of single looks and gates; smaller is spikier", fontsize=10)
    figure.tight_layout()
    figure.savefig(arguments.out, dpi=130)


if __name__ == "__main__":
    main()
