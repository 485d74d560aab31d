"""Hard cases far out, after hours, and of odd baselines."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.mesh import polar_grid
from seamap_rt.mesh.surface import sea_on_grid
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.platform import BoatState
from seamap_rt.report import style
from seamap_rt.scene import Scene
from seamap_rt.settings import RadarSettings, RetrievalSettings
from seamap_rt.simulation import Simulator

from .. import analytic
from .case import Effort, Finding, graph, light, scene

BASELINES_M = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
RANGES_M = (50.0, 200.0, 1000.0, 5000.0, 12_000.0, 19_990.0)

# ------------------------------------------------------------------------------------------------- far and long


def far_from_origin(_: Effort) -> list[Finding]:
    """The same water 20 patches of 512 m away from the origin: voltages, light and map."""
    away, turn = 20 * 512.0, 2000
    made = scene(
        "tiny",
        platform__speed_m_s=5.12,
        platform__heading_deg=90.0,
        radar__sector_deg=[250.0, 290.0],
        platform__list_deg=5.0,
    )
    far, near = Simulator(made), Simulator(made)
    motion = near.installation.motion

    def nearer(times: ArrayLike) -> BoatState:
        state = motion(times)
        return BoatState(state.position - np.array((away, 0.0, 0.0)), state.attitude)

    near.installation = Installation(made.radar, made.platform, nearer)
    meshes = [each.mesh(turn) for each in (far, near)]
    lit = [light("facets", mesh, made) for mesh in meshes]
    turns = [each.turn(turn) for each in (far, near)]
    volts = [each.echoes["voltage"].values for each in turns]
    error = np.abs(volts[0] - volts[1]).max() / np.sqrt(np.mean(np.abs(volts[1]) ** 2))
    maps = [sr.retrieve(each.echoes, made.retrieval)["polar"].to_dataset()["height"].values for each in turns]
    height = np.nanquantile(np.abs(maps[0] - maps[1]), 0.99)
    same = np.array_equal(np.isfinite(maps[0]), np.isfinite(maps[1]))
    differ = int(np.count_nonzero(lit[0] != lit[1]))
    return [
        Finding(
            "10.24 km from the origin",
            "the light, voltages (1e-4 of rms) and heights (10 µm) of the same water at the origin",
            f"{differ} of {lit[0].size} facets, voltages {error:.1e} of rms, heights {1e6 * height:.2f} µm (99 %)",
            bool(error < 1e-4 and same and height < 1e-5 and differ < 1e-4 * lit[0].size),
        )
    ]


def half_a_day(_: Effort) -> list[Finding]:
    """Turn 43 200: the meshed sea against the sum of its waves, and the scan's lines."""
    made, turn = scene("tiny", tracing__facet_m=0.8, tracing__columns_per_beam=4), 43_200
    water, rng, errors, lines = sr.sea.realize(made.sea, 5), np.random.default_rng(3), [], []
    for number in (0, turn):
        grid = polar_grid(Installation(made.radar), made.meshing, number)
        elevation = sea_on_grid(water, grid)[0]
        line, rung = rng.integers(0, grid.sweep.size, 100), rng.integers(0, grid.ground_range.size, 100)
        azimuth, away = np.radians(grid.azimuth[line]), grid.ground_range[rung]
        exact = sr.sea.direct_sum(water.components(), away * np.sin(azimuth), away * np.cos(azimuth), grid.time[line])
        errors.append(np.abs(elevation[line, rung] - exact.elevation).max())
        lines.append(grid.sweep.size)
    return [
        Finding(
            "t = 12 h: the sea",
            "interpolated waves are their direct sum as closely as at time 0",
            f"worst {1e3 * errors[1]:.3f} mm, at time 0 {1e3 * errors[0]:.3f} mm",
            bool(errors[1] < 2.0 * errors[0]),
        ),
        Finding("t = 12 h: the scan", "as many lines as at time 0", f"{lines[1]} and {lines[0]}", lines[0] == lines[1]),
    ]


# ---------------------------------------------------------------------------------------------------------- phases


def baselines(_: Effort) -> list[Finding]:
    """A flat sea of closed form over baselines of 1 mm to 3 m."""
    settings = RetrievalSettings(estimator="single_cell", cell_range_m=1.5, paths="one_way", ground_m=20.0)
    worst, bounds = [], []
    for baseline in BASELINES_M:
        radar = RadarSettings(baseline_m=baseline, noise=False, sector_deg=(80.0, 98.0), range_m=(15.0, 400.0))
        polar = sr.retrieve(analytic.echoes(analytic.FlatSea(), radar), settings)["polar"].to_dataset()
        per_radian = SPEED_OF_LIGHT / radar.frequency_hz * polar["range"].values / (2.0 * np.pi * baseline)
        worst.append(float(np.abs(polar["height"].values).max()))
        bounds.append(float(1e-7 * per_radian.max()))
    figure, axes = graph("Baseline (m)", "Worst height of a flat sea to 400 m (m)", "Baselines from 1 mm to 3 m")
    axes.loglog(BASELINES_M, worst, "o-", color=style.BLUE, label="retrieved")
    axes.loglog(BASELINES_M, bounds, ":", color=style.GREY, label="1e-7 rad × λR/2πB")
    axes.legend()
    return [
        Finding(
            "B from 1 mm to 3 m",
            "a flat sea of closed form is level to 1e-7 rad of phase",
            f"{1e6 * worst[0]:.0f} µm at 1 mm, {1e6 * worst[-1]:.3f} µm at 3 m",
            bool(np.all(np.array(worst) < bounds)),
            figure,
        )
    ]


def far_phases(_: Effort) -> list[Finding]:
    """Phases of point scatterers out to 20 km against extended precision."""
    exact = np.longdouble
    pi = np.arctan2(exact(0.0), exact(-1.0))
    k, worst = 2 * pi * exact(10e9) / exact(SPEED_OF_LIGHT), []
    for ground in RANGES_M:
        settings = {
            "name": "far",
            "radar": {
                "noise": False,
                "baseline_m": 3.0,
                "prf_hz": 7000.0,
                "sector_deg": (37.0, 37.9),
                "range_m": (ground - 6.0, ground + 9.0),
            },
            "sea": {"extent_m": 20_000.0, "resolution_m": 10.0},
            "retrieval": {"cell_azimuth_deg": 0.45, "ground_m": 20.0},
            "scattering": {"extrapolate": True},
        }
        position = np.array([ground * np.sin(0.6535), ground * np.cos(0.6535), 0.37])
        echoes = sr.echoes.from_scatterers(Scene.model_validate(settings), position[None], [1e6])
        paths = [
            np.sqrt(np.sum((position.astype(exact) - np.array((0.0, 0.0, 5.0 + side), dtype=exact)) ** 2))
            for side in (-1.5, 1.5)
        ]
        errors = []
        for pulse in range(echoes.sizes["pulse"]):
            one = echoes.isel(pulse=pulse)
            volts = one["voltage"].values[:, int(np.abs(one["voltage"].values[0]).argmax())]
            for voltage, path in zip(volts, paths, strict=True):
                off = np.angle(complex(voltage)) + k * (paths[int(one["transmitter"])] + path)
                errors.append(abs(float(np.remainder(off + pi, 2 * pi) - pi)))
        worst.append(max(errors))
    figure, axes = graph("Ground range (m)", "Worst phase error (rad)", "Phases of a point scatterer, B = 3 m")
    axes.loglog(RANGES_M, worst, "o-", color=style.BLUE)
    axes.axhline(1e-3, color=style.GREY, linestyle=":", label="required")
    axes.legend()
    return [
        Finding(
            "phases at 20 km",
            "within 1e-3 rad of extended precision",
            f"{worst[-1]:.1e} rad at 20 km, {worst[0]:.1e} rad at 50 m",
            max(worst) < 1e-3,
            figure,
        )
    ]
