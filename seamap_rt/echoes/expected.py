"""The speckle-averaged echo: power of every pair and covariance of the receivers, per look and gate, without noise.

Facets are independent scatterers, so their powers add, and each contributes its own interferometric phase; where its
field comes over an edge, that of the detour as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..mesh import Facets
from ..radar.antenna import antenna
from ..radar.scan import BEAMS_BEYOND, look_sweeps
from ..settings import RadarSettings
from .gating import Gating
from .paths import facet_paths, wavenumber

_CHUNK = 32
_BEAM_POINTS = 24  # of the dwell over which a look's beam is averaged


@dataclass(frozen=True)
class ExpectedGates:
    """Expectation over speckle; arrays (look, gate) unless said otherwise."""

    sweep: NDArray[np.float64]  # (look,) deg from the start of the sector
    range: NDArray[np.float64]  # (gate,) m
    power: NDArray[np.float64]  # (tx, rx, look, gate) W
    covariance: NDArray[np.complex128]  # W, mean over the transmitters that are used
    weight: NDArray[np.float64]  # Σ beam · gate · area: what weighs a cell's places, shadow or not
    weighted_height: NDArray[np.float64]  # m, the mean height with that weight


def expected_look_gates(
    facets: Facets, rcs: NDArray[np.float32], radar: RadarSettings, cell_azimuth_deg: float
) -> ExpectedGates:
    """Expected power and covariance of each look (averaged over its dwell) and gate."""
    gating = Gating(radar, facets)
    sweeps = look_sweeps(radar.sector_deg, cell_azimuth_deg)
    gates, looks = gating.range.size, sweeps.size
    power = np.zeros((3, looks, gates))
    covariance = np.zeros((2, looks, gates), dtype=np.complex128)
    weight, moment = np.zeros((looks, gates)), np.zeros((looks, gates))
    k = wavenumber(radar)
    for begin in range(0, facets.grid.columns, _CHUNK):
        columns = slice(begin, min(begin + _CHUNK, facets.grid.columns))
        paths = facet_paths(facets, rcs, radar, columns, 3)
        count = columns.stop - columns.start
        column_power = np.zeros((3, count, gates))
        column_covariance = np.zeros((2, count, gates), dtype=np.complex128)
        column_weight, column_moment = np.zeros((count, gates)), np.zeros((count, gates))
        turning = np.exp(1j * np.remainder(k * paths.difference, 2.0 * np.pi))
        for block in gating.blocks:
            heard = [gating.weights(block, length).astype(np.float64) for length in paths.length]
            volts = [h * a[:, block.facets, None] for h, a in zip(heard, paths.amplitude, strict=True)]
            for pair, voltage in enumerate(volts):
                column_power[pair, :, block.gates] = np.einsum("cfg,cfg->cg", voltage, voltage.conj()).real
            phase = turning[:, block.facets, None]
            for transmitter in (0, 1):
                product = volts[transmitter] * volts[transmitter + 1].conj()
                column_covariance[transmitter, :, block.gates] = np.sum(product * phase, axis=1)
            area = heard[1] ** 2 * facets.horizontal_area[block.facets][:, None]
            column_weight[:, block.gates] = area.sum(axis=1)
            column_moment[:, block.gates] = np.einsum("cfg,cf->cg", area, facets.height[columns, block.facets])
        for column in range(count):
            sweep = facets.grid.column_sweep[columns.start + column]
            near, beam = look_beams(radar, sweeps, cell_azimuth_deg, sweep, gating.level)
            power[:, near] += beam * column_power[:, column, None, :]
            covariance[:, near] += beam * column_covariance[:, column, None, :]
            weight[near] += beam * column_weight[column]
            moment[near] += beam * column_moment[column]
    used = (0, 1) if radar.transmit == "switched" else (0,)
    with np.errstate(invalid="ignore", divide="ignore"):
        height = moment / weight
    return ExpectedGates(
        sweep=sweeps,
        range=gating.range,
        power=np.stack((power[:2], power[1:])),
        covariance=covariance[list(used)].mean(axis=0),
        weight=weight,
        weighted_height=height,
    )


def look_beams(
    radar: RadarSettings,
    sweeps: NDArray[np.float64],
    cell_azimuth_deg: float,
    column_sweep: float,
    level: NDArray[np.float64],
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """The looks that hear a column, and the dwell's mean two-way power pattern towards it (look, gate)."""
    reach = BEAMS_BEYOND * radar.antenna.azimuth_beamwidth_deg
    near = np.flatnonzero(np.abs(sweeps - column_sweep) <= reach + 0.5 * cell_azimuth_deg)
    dwell = cell_azimuth_deg * ((np.arange(_BEAM_POINTS) + 0.5) / _BEAM_POINTS - 0.5)
    offset = sweeps[near, None] + dwell - column_sweep
    cosine = np.sin(np.radians(offset))[..., None] * level
    span = np.sin(np.radians(min(90.0, reach + cell_azimuth_deg)))
    table = np.linspace(-span, span, 4001)
    pattern = np.interp(cosine, table, antenna(radar).azimuth(table) ** 4)
    pattern[np.abs(offset) > reach] = 0.0
    return near, pattern.mean(axis=1)
