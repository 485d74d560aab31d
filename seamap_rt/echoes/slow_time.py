"""Slow-time nodes: the few pulses at which echoes are summed, and the pulses between, interpolated.

The echo is band-limited in slow time: rotation of the aperture, Doppler and speckle together span some ±500 Hz, far
less than the PRF. What is known at nodes a few pulses apart is known at every pulse, by a windowed sinc.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled
from ..compute.machine import pool
from ..mesh import Facets
from ..radar.array import antenna_array
from ..radar.scan import Pulses
from ..settings import AntennaSettings, RadarSettings
from .motion import Fastest, Motion, echo_bandwidth
from .paths import wavenumber

_TAPS = 16
_LONGEST_STRIDE = 64  # pulses between nodes, however still the sea: nothing is gained beyond
_OVERSAMPLING = 1.3  # nodes per Nyquist interval of a band that is a sum of worst cases
_PULSES, _NODES = 500, 64  # worked on at a time


@dataclass(frozen=True)
class Nodes:
    """Slow-time nodes of a turn: node n lies at pulse n·stride (n may be negative or beyond the last pulse)."""

    stride: int  # pulses
    first: int  # number of the first node, 0 or negative
    count: int
    spacing_s: float  # s
    time: NDArray[np.float64]  # (node,) s


def choose_nodes(
    facets: Facets,
    radar: RadarSettings,
    pulses: Pulses,
    decorrelation_time_s: float,
    motion: Motion | None = None,
    fastest: Fastest | None = None,
) -> Nodes:
    """Nodes as far apart as the echo's bandwidth allows: rotation + Doppler of the fastest scatterer + speckle of
    decorrelation time τc [s], which may be infinite. motion: of the scatterers relative to the water; fastest: the
    facets' speeds, where they are known already."""
    array = antenna_array(radar)
    wavelength = 2.0 * np.pi / wavenumber(radar)
    per_degree = max(
        _cycles_a_degree(settings, element.antenna.azimuth_beamwidth_deg, wavelength)
        for settings, element in zip(radar.antennas or [radar.antenna] * 2, array.elements, strict=True)
    )
    drift = float(np.max(np.linalg.norm(facets.grid.drift, axis=-1), initial=0.0))
    bandwidth = echo_bandwidth(
        fastest or facets,
        wavenumber(radar),
        _fastest_sweep(facets, pulses) * per_degree,
        decorrelation_time_s,
        motion,
        drift,
    )
    widest = radar.prf_hz / (2.0 * _OVERSAMPLING * _LONGEST_STRIDE)
    stride, cycle = max(1, int(radar.prf_hz / (2.0 * _OVERSAMPLING * max(bandwidth, widest)))), len(array.cycle)
    # A pulse's slot in the mode's cycle then depends on its phase between nodes alone.
    stride = stride - stride % cycle if stride >= cycle else 1
    margin = _TAPS // 2 if stride > 1 else 0
    last = -(-pulses.number.size // stride)
    spacing_s = stride / radar.prf_hz
    first = -margin
    count = last + margin + 1 - first
    return Nodes(stride, first, count, spacing_s, pulses.time[0] + spacing_s * np.arange(first, first + count))


def _fastest_sweep(facets: Facets, pulses: Pulses) -> float:
    """Degrees that the boresight turns in a second: the turntable's, or more where a boat yaws much with it.

    Less than a tenth more is held by the oversampling, and turns that differ so little keep the same nodes.
    """
    if pulses.mast.rate == 0.0:
        return 0.0
    fastest = facets.grid.spacing_deg / float(np.diff(facets.grid.time).min())
    return fastest if fastest > 1.1 * pulses.mast.rate else pulses.mast.rate


def _cycles_a_degree(settings: AntennaSettings, beam_deg: float, wavelength: float) -> float:
    """Bandwidth of an antenna's two-way pattern. It is the transform of the aperture convolved with itself: strictly
    ±width/λ per radian. A Gaussian beam has no edge; 1.35 per beam width holds all but 1e-5 of it. A measured one may
    be either."""
    strict, soft = float(np.radians(settings.width_m / wavelength)), 1.35 / beam_deg
    return {"slotted_waveguide": strict, "file": max(strict, soft)}.get(settings.pattern, soft)


def nodes_first(sums: NDArray[np.float32]) -> NDArray[np.complex64]:
    """Complex sums (node, path, gate) from real and imaginary ones (component, path, gate, node)."""
    echo = np.empty((sums.shape[3], *sums.shape[1:3]), dtype=np.complex64)

    def work(first: int) -> None:
        nodes = slice(first, first + _NODES)
        echo.real[nodes], echo.imag[nodes] = sums[..., nodes].transpose(0, 3, 1, 2)

    with pool() as workers:
        list(workers.map(work, range(0, len(echo), _NODES)))
    return echo


def pulses_from_nodes(
    echo: NDArray[np.complex64], nodes: Nodes, radar: RadarSettings, pulses: Pulses
) -> NDArray[np.complex64]:
    """Voltages (pulse, receiver, gate) [√W] from the paths' sums (node, path, gate) [√W], by a windowed sinc; NaN where
    the mode does not sample a receiver."""
    array = antenna_array(radar)
    count = pulses.number.size
    voltages = np.empty((count, len(array.receivers), echo.shape[2]), dtype=np.complex64)
    path = paths_of_cycle(radar)
    weights = interpolation_weights(nodes.stride)
    # Real and imaginary components are weighed alike: plain numbers, twice as many.
    sums, out = (each.view(np.float32).reshape(*each.shape[:2], -1) for each in (echo, voltages))

    def work(start: int) -> None:
        stop = min(start + _PULSES, count)
        _interpolate(sums, -nodes.first, nodes.stride, weights, path[pulses.slot[start:stop]], start, out)

    with pool() as workers:
        list(workers.map(work, range(0, count, _PULSES)))
    return voltages


def paths_of_cycle(radar: RadarSettings) -> NDArray[np.intp]:
    """The path (slot, receiver) that is heard on each pulse of the mode's cycle; −1 where none is."""
    array = antenna_array(radar)
    path = np.full((len(array.cycle), len(array.receivers)), -1)
    for number, slot in enumerate(array.cycle):
        for receiver in slot.receivers:
            path[number, receiver] = array.path(slot.transmitter, receiver)
    return path


@compiled
def _interpolate(echo, zero, stride, weights, path, start, voltages):
    """Fill voltages (pulse, receiver, number) from `start` on; echo (node, path, number), `zero` the node of pulse 0.

    weights (phase, tap): of nodes around a pulse, by its number of pulses after a node; path (pulse, receiver), −1 for
    none.
    """
    taps = weights.shape[1]
    for pulse in range(path.shape[0]):
        node, phase = zero + (start + pulse) // stride, (start + pulse) % stride
        for receiver in range(path.shape[1]):
            row, number = voltages[start + pulse, receiver], path[pulse, receiver]
            if number < 0:
                row[:] = np.float32(np.nan)
            elif phase == 0:
                row[:] = echo[node, number]
            else:
                row[:] = np.float32(0.0)
                for tap in range(taps):
                    weight, known = weights[phase, tap], echo[node + tap - taps // 2 + 1, number]
                    for n in range(row.size):
                        row[n] += weight * known[n]


@lru_cache(maxsize=16)
def interpolation_weights(stride: int) -> NDArray[np.float32]:
    """Weights (phase, tap) of the nodes around a pulse that lies `phase` pulses after a node, `stride` to the next: a
    sinc in a window of Kaiser (1974)."""
    # Node n + tap − taps/2 + 1 lies phase/stride − (tap − taps/2 + 1) nodes before the pulse.
    offset = np.arange(stride)[:, None] / stride - (np.arange(_TAPS) - _TAPS // 2 + 1)
    # A Kaiser-windowed sinc of support ±taps/2; β trades ripple against the transition that oversampling leaves.
    half = _TAPS // 2
    beta = np.pi * half * (1.0 - 1.0 / _OVERSAMPLING)
    window = np.i0(beta * np.sqrt(np.maximum(0.0, 1.0 - (offset / half) ** 2))) / np.i0(beta)
    return (np.sinc(offset) * window).astype(np.float32)
