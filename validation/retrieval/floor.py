"""The floor under a map's errors: the same estimator, given the sea's covariance and each cell's true coherence.

The expectation of the echo over speckle is known: for each look and gate the power, and the covariance of the two
receivers, whose phase and coherence contain the spread of heights within the cell, layover and shadow. From it follows
the error variance of each phase, given the power of the echo.

`known` is the floor: the phases of the same echoes, with the true cycles, interpolated with those variances and the
covariance of the true sea. An error above it is due to what the retrieval has to estimate.
`drawn` checks it without the echoes: speckle and noise drawn pulse by pulse from the expectation, with the correlation
in time that the echoes have. Each gate has its own speckle, so that its neighbours do not tell where its bright spots
lie, and nothing is taken off: near by, where real gates tell, `drawn` errs more than `known`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.conventions import wrap_phase
from seamap_rt.echoes.expected import expected_look_gates
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.error_covariance import (
    ErrorCovariance,
    correlation_beside,
    correlation_by_range,
)
from seamap_rt.interferometry.estimators import bright_spots, sliding_plane
from seamap_rt.interferometry.interferogram import Interferogram
from seamap_rt.interferometry.looks import Looks, interferogram
from seamap_rt.interferometry.optimal import MeasuredHeights, optimal_heights
from seamap_rt.interferometry.sea_covariance import SeaCovariance
from seamap_rt.interferometry.speckle import ONE_CELL, phase_variances
from seamap_rt.interferometry.windows import Covariance
from seamap_rt.radar.installation import Installation
from seamap_rt.scene import Scene
from seamap_rt.sea import Sea
from seamap_rt.simulation import Simulator

Map = NDArray[np.float64]

LAG_M, STEP_M = 48.0, 0.5  # of the sea's covariance: as far, and as fine, as the retrieval's own


@dataclass(frozen=True)
class Law:
    """What the two receivers receive from each look and gate, over all speckle, without noise; arrays (look, gate)."""

    lower: Map  # W
    upper: Map  # W
    cross: NDArray[np.complex128]  # W
    sea: SeaCovariance

    @property
    def incoherent(self) -> Map:
        return 0.5 * (self.lower + self.upper) - np.abs(self.cross)


def law_of(scene: Scene) -> Law:
    """Of the pairs of both ways (p = 2), which `paths = "best"` takes from switched transmitters."""
    simulator = Simulator(scene)
    facets, returns, _ = simulator.light(0)
    radar = simulator.installation.radar.model_copy(update={"interferogram": "alternating_pulse"})
    gates = expected_look_gates(facets, returns.rcs, Installation(radar), scene.retrieval.cell_azimuth_deg)
    return Law(
        gates.power[0, 0], gates.power[1, 1], gates.covariance, sea_covariance(simulator.sea, scene.sea.extent_m)
    )


def sea_covariance(sea: Sea, extent_m: float) -> SeaCovariance:
    """Of the surface itself, over its whole patch at one time, at points."""
    x = STEP_M * np.arange(round(extent_m / STEP_M))
    waves = np.concatenate([sea.elevation(*np.meshgrid(part, x, indexing="ij"), 0.5) for part in np.split(x, 16)])
    power = np.abs(np.fft.rfft2(waves - waves.mean())) ** 2
    lags = np.arange(-round(LAG_M / STEP_M), round(LAG_M / STEP_M) + 1)
    covariance = np.fft.irfft2(power, waves.shape)[lags[:, None], lags] / waves.size
    return SeaCovariance(np.ascontiguousarray(covariance), STEP_M)


def floors(scene: Scene, echoes: xr.Dataset, height: Map, law: Law, seed: int) -> dict[str, Map]:
    """Heights (look, gate) by `drawn` and `known`; height: the truth's, for the phases' cycles."""
    radar = RadarDescription.of(echoes)
    looks = Looks.of(echoes, radar, scene.retrieval)
    given, _ = interferogram(looks)
    if given.model.paths != 2:
        raise ValueError(f"paths = {given.model.paths}: must be 2; give echoes of switched transmitters")
    cells = _drawn(law, given, radar, np.random.default_rng(seed))
    drawn = replace(given, dwell=cells, echo=replace(given.echo, pulses=cells))
    return {"drawn": _interpolated(drawn, law, height, told=False), "known": _interpolated(given, law, height)}


def _interpolated(given: Interferogram, law: Law, height: Map, told: bool = True) -> Map:
    """Optimal interpolation between single dwells and gates, as the `adaptive` estimator does it; told: where bright
    spots lie, by the gates beside each."""
    model, cells, settings = given.model, given.dwell, given.settings
    expected = model.phase_at_height(np.nan_to_num(height))
    echoing = sliding_plane(given).echoing  # of a strong speckle: it is heard farther out, and errs less
    samples = given.dwelt.samples(ONE_CELL, model.radar)
    speckle, noise = phase_variances(
        cells, law.incoherent, given.echo.noise, samples.speckle, samples.noise, given.noise_square
    )
    spots, offsets = bright_spots(given, expected, echoing if told else np.zeros_like(echoing), speckle * given.doubt)
    phase = expected + wrap_phase(np.angle(cells.cross) - expected) - offsets.phase
    each = model.heights_of(cells, phase - model.flat)
    tilted = given.tilted_share(law.incoherent, expected)
    with np.errstate(invalid="ignore"):  # where there is no echo at all
        parts = np.stack((speckle * tilted * offsets.left, speckle * (1.0 - tilted), noise))
    along = correlation_by_range(model.radar.response, model.radar.spacing * np.arange(9), spots if told else None)
    errors = ErrorCovariance(each.gain * np.sqrt(parts), along, correlation_beside(given.dwelt))
    ground = model.ground(each.points)
    footprint = model.radar.footprint(given.echo.width)
    blur = 0.5 * (footprint[0] ** 2 + (footprint[1] * model.radar.ranges) ** 2)
    known = MeasuredHeights(each.height, errors, ground, model.outward(*ground), blur)
    cell = settings.cell_range_m, np.radians(settings.cell_azimuth_deg)
    return optimal_heights(known, law.sea, echoing & np.isfinite(each.height), cell, model.radar.ranges)[0]


def _drawn(law: Law, given: Interferogram, radar: RadarDescription, random: np.random.Generator) -> Covariance:
    """Dwells' means of echoes and noise drawn pulse by pulse."""
    looks, gates = law.cross.shape
    pulses = given.dwelt.pulses
    lags = radar.spacing * np.arange(gates)
    hissing = _along_gates(radar.response.noise_correlation(lags)).astype(np.float32)

    def white() -> NDArray[np.complex64]:
        pieces = random.standard_normal((2, looks * pulses, gates), dtype=np.float32) * np.float32(np.sqrt(0.5))
        return pieces[0] + 1j * pieces[1]

    shape = (looks, pulses, gates)
    one, other = (_in_time(white(), given).reshape(shape) for _ in range(2))
    scale = np.sqrt(np.maximum(law.lower * law.upper, 1e-300))
    coherence = np.clip(np.abs(law.cross) / scale, 0.0, 1.0)
    shared = coherence * np.exp(1j * np.angle(law.cross))
    lower = np.sqrt(law.lower)[:, None] * one
    upper = np.sqrt(law.upper)[:, None] * (shared.conj()[:, None] * one + np.sqrt(1.0 - coherence**2)[:, None] * other)
    root = np.sqrt(given.echo.noise)
    lower, upper = (volts + root * (white() @ hissing.T).reshape(shape) for volts in (lower, upper))
    powers = [np.asarray(np.mean(np.abs(volts) ** 2, axis=1, dtype=np.float64)) for volts in (lower, upper)]
    beside = 0.5 * (upper + np.roll(upper, 1, axis=1))  # each pulse is compared with that before it and that after it
    return Covariance(np.mean(lower * beside.conj(), axis=1), *powers)


def _in_time(white: NDArray[np.complex64], given: Interferogram) -> NDArray[np.complex64]:
    """Pulses (pulse, gate) correlated as exp(−(lag/τ)²), τ from what the echoes do within a dwell."""
    constant = max(1, np.count_nonzero(given.dwelt.correlation > np.exp(-1.0)))
    lag = np.minimum(np.arange(white.shape[0]), white.shape[0] - np.arange(white.shape[0]))
    gain = np.sqrt(np.maximum(np.fft.fft(np.exp(-((lag / constant) ** 2))).real, 0.0)).astype(np.float32)
    return np.fft.ifft(np.fft.fft(white, axis=0) * gain[:, None], axis=0).astype(np.complex64)


def _along_gates(correlation: Map) -> Map:
    """A root of the correlation's matrix (gate, gate)."""
    lag = np.abs(np.subtract.outer(np.arange(correlation.size), np.arange(correlation.size)))
    value, vector = np.linalg.eigh(correlation[lag])
    return vector * np.sqrt(np.maximum(value, 0.0))
