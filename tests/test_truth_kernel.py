"""The compiled pass from facets to cells, by its plain definition: every facet's share of every cell, in matrices."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.compute import machine
from seamap_rt.mesh import polar_grid
from seamap_rt.mesh.facets import facets_of, velocities_of
from seamap_rt.radar.array import antenna_array
from seamap_rt.radar.grid import look_sweeps
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import dwell_power
from seamap_rt.radar.waveform import RangeResponse, gates
from seamap_rt.settings import RadarSettings, RetrievalSettings, TracingSettings
from seamap_rt.tracing import Illumination
from seamap_rt.truth import polar_truth

RETRIEVAL = RetrievalSettings()
CHIRP = {
    "waveform": "chirp", "pulse_width_s": 2e-7, "chirp_bandwidth_hz": 5e7, "compression_window": "hann",
    "range_m": (40.0, 70.0),
}  # fmt: skip
Means = dict[str, NDArray[np.float64]]


def radar_of(**changes: Any) -> RadarSettings:
    return RadarSettings.model_validate({"sector_deg": (0.0, 10.0), "range_m": (20.0, 50.0), **changes})


def lit_facets(radar: RadarSettings, facet_m: float, bent: bool) -> tuple[Illumination, NDArray[np.float32]]:
    """Facets of a surface of random heights, lit at random, geometrically or by a field, and their cross-sections."""
    random = np.random.default_rng(7)
    grid = polar_grid(Installation(radar), TracingSettings(facet_m=facet_m, columns_per_beam=3), 0)
    lines = grid.sweep.size, grid.ground_range.size
    still = np.zeros(lines, np.float32)
    facets = facets_of(grid, 0.3 * random.standard_normal(lines), velocities_of(still, still))
    light = random.random((2, *facets.height.shape)) < 0.6
    lit = Illumination.of(facets, light)
    if bent:
        field = random.standard_normal(light.shape) + 1j * random.standard_normal(light.shape)
        lit = replace(lit, field=field.astype(np.complex64))
    rcs = np.where(lit.reached.any(axis=0), random.random(facets.height.shape), 0.0)
    return lit, rcs.astype(np.float32)


def bends(facets: Illumination) -> NDArray[np.float64]:
    """(column, facet) m by which the water lies below the facets in the mean: Σ eᵀHe/24 over a triangle's edges e, with
    H by differences of the slopes of facets of one kind."""
    step = np.repeat(np.diff(facets.grid.ground_range), 2)
    width = facets.distance * np.radians(facets.grid.spacing_deg)
    bend = np.empty(facets.height.shape)
    for kind in (slice(0, None, 2), slice(1, None, 2)):
        turning, look = np.gradient(facets.slope_look[:, kind].astype(float))
        cross = np.gradient(facets.slope_cross[:, kind].astype(float), axis=0)
        bend[:, kind] = (step[kind] * (look + turning) + width[kind] * cross) / 12.0
    return bend


def overlap(middle: NDArray, width: float, cell: NDArray, length: float) -> NDArray[np.float64]:
    """(cell, n): share of intervals about their middles that lies in the cells."""
    high = np.minimum(middle + 0.5 * width, cell[:, None] + 0.5 * length)
    low = np.maximum(middle - 0.5 * width, cell[:, None] - 0.5 * length)
    return np.maximum(high - low, 0.0) / width


def plain_truth(facets: Illumination, rcs: NDArray[np.float32], radar: RadarSettings) -> Means:
    """(look, gate) by the definition: a facet's point lies between the middles of two bins of slant range, to which it
    belongs as it is near to them; bins belong to gates, and columns to looks, by their overlap, or by response and
    beam."""
    grid, ranges, pulse = facets.grid, gates(radar), RangeResponse.of(radar)
    rung = float(np.diff(grid.ground_range).max())
    parts = 2 if rung > RETRIEVAL.cell_range_m / 6.0 else 1
    apart = (np.arange(parts) - 0.5 * (parts - 1)) * 2.0 * rung / np.sqrt(18.0)
    width = max(radar.range_sampling_m / 6.0, 0.5 * rung)
    start = ranges[0] - max(pulse.support_m, 0.5 * RETRIEVAL.cell_range_m) - 2.0 * width
    stop = ranges[-1] + max(pulse.support_m, 0.5 * RETRIEVAL.cell_range_m) + 2.0 * width
    bins = start + width * (np.arange(np.ceil((stop - start) / width)) + 0.5)
    sweeps = look_sweeps(radar.sector_deg, RETRIEVAL.cell_azimuth_deg)
    in_look = overlap(grid.column_sweep, grid.spacing_deg, sweeps, RETRIEVAL.cell_azimuth_deg)
    in_beam = dwell_power(antenna_array(radar), sweeps[:, None] - grid.column_sweep, RETRIEVAL.cell_azimuth_deg)
    in_cell, in_gate = overlap(bins, width, ranges, RETRIEVAL.cell_range_m), pulse(ranges[:, None] - bins) ** 2

    light: NDArray[np.float64] = np.asarray(facets.lit if facets.field is None else np.abs(facets.field) ** 2, float)
    arriving, lit = np.square(light.mean(axis=0)), np.asarray(facets.lit.all(axis=0))
    area = facets.horizontal_area / parts
    names = ("area", "seen", "height", "height_seen", "look", "cross", "echo", "light", "heard", "heard_height")
    sums: Means = {name: np.zeros((sweeps.size, ranges.size)) for name in names}
    for column in range(grid.columns):
        for shift in apart:
            height = (facets.height - bends(facets))[column] + facets.slope_look[column] * shift
            slant = np.hypot(facets.distance + shift, height - grid.column_height[column])
            near = np.maximum(1.0 - np.abs(slant - bins[:, None]) / width, 0.0)  # (bin, facet)
            near[:, (slant < bins[0]) | (slant >= bins[-1])] = 0.0
            values = {
                "area": area,
                "seen": area * lit[column],
                "height": area * height,
                "height_seen": area * lit[column] * height,
                "look": area * facets.slope_look[column],
                "cross": area * facets.slope_cross[column],
                "echo": rcs[column] * arriving[column] / parts,
                "light": area * arriving[column],
            }
            for name, value in values.items():
                sums[name] += in_look[:, column, None] * (in_cell @ (near @ value))
            sums["heard"] += in_beam[:, column, None] * (in_gate @ (near @ area))
            sums["heard_height"] += in_beam[:, column, None] * (in_gate @ (near @ (area * height)))
    with np.errstate(invalid="ignore", divide="ignore"):
        made = {
            "height": sums["height"] / sums["area"],
            "height_visible": sums["height_seen"] / sums["seen"],
            "visible_fraction": sums["seen"] / sums["area"],
            "slope_range": sums["look"] / sums["area"],
            "slope_azimuth": sums["cross"] / sums["area"],
            "nrcs_db": 10.0 * np.log10(sums["echo"] / sums["area"]),
            "illumination": sums["light"] / sums["area"],
            "height_weighted": sums["heard_height"] / sums["heard"],
        }
    return {name: np.where(sums["area"] > 0.0, value, np.nan) for name, value in made.items()}


@pytest.mark.parametrize(
    ("changes", "facet_m", "bent"),
    [({}, 0.8, False), ({}, 0.4, True), ({"range_m": (3.0, 40.0)}, 0.8, False), (CHIRP, 0.6, False)],
    ids=["halves", "a field over whole facets", "gates without sea", "a chirp's long response"],
)
def test_the_pass_is_the_definition(changes: dict[str, Any], facet_m: float, bent: bool) -> None:
    radar = radar_of(**changes)
    facets, rcs = lit_facets(radar, facet_m, bent)
    truth, plain = polar_truth(facets, rcs, Installation(radar), RETRIEVAL, 0), plain_truth(facets, rcs, radar)
    if not bent:
        del plain["illumination"]
    for name, expected in plain.items():
        got = truth[name].values[0]
        np.testing.assert_array_equal(np.isnan(got), ~np.isfinite(expected), err_msg=name)
        known = np.isfinite(expected)
        assert known.any()
        # Kept, and partly given, in single precision: an ulp is 1.2e-7 of a value, and of what it is a difference of.
        np.testing.assert_allclose(got[known], expected[known], rtol=5e-7, atol=2e-7, err_msg=name)


def test_threads_do_not_change_a_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    radar = radar_of(sector_deg=(0.0, 90.0))  # a hundred and more columns, several blocks
    facets, rcs = lit_facets(radar, 0.8, False)
    made: list[xr.Dataset] = []
    for count in (1, 3):
        monkeypatch.setattr(machine, "threads", lambda count=count: count)
        made.append(polar_truth(facets, rcs, Installation(radar), RETRIEVAL, 0))
    assert made[0].identical(made[1])
