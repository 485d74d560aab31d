"""Slow-time nodes: the few pulses at which echoes are summed, and the pulses between, interpolated.

The echo is band-limited in slow time: rotation of the aperture, Doppler and speckle together span some ±500 Hz, far
less than the PRF. What is known at nodes a few pulses apart is known at every pulse, but for a share of the power that
the height error allowed bounds.

Of all weights of a few nodes those miss least of an echo of autocorrelation ρ, in the mean, that solve R w = r, with
R_mn = ρ(t_m − t_n) between the nodes and r_n = ρ(t − t_n) between the pulse and them (Wiener 1949). The share missed is

    p(t) = 1 − 2 w·r + w·R w,      ρ(τ) = ρ_beam(ωτ) exp(−(τ/τc)²) sinc(2Fτ)

ρ_beam is the two-way beam's correlation with itself turned; F is the Doppler frequency of the fastest scatterer, up to
which all are taken to be alike: the seas' speeds are nearer to 0, and of them less is missed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled
from ..compute.machine import pool
from ..conventions import radar_wavenumber
from ..mesh import Facets
from ..radar.antenna import cache_by_radar
from ..radar.array import Array
from ..radar.scan import Pulses
from ..settings import RadarSettings
from .response import two_way_beams
from .speckle import Motion, SpeedBounds, fastest_echo

_LEAST = 1e-6  # of the power, where nothing may be left out: what the tables of range and beam miss is no less
_MOST_TAPS = 12  # a pulse's: more cost what wider nodes save
_NOISE = 1e-9  # of a node's power that is not known: it bounds the weights where nodes say the same

Correlation = Callable[[NDArray[np.float64]], NDArray[np.float64]]  # ρ at lags [s]


class NodeWeights(NamedTuple):
    """Nodes every `stride` pulses, and the pulses between."""

    stride: int  # pulses
    weights: NDArray[np.float32]  # (phase, tap): pulse n·stride + phase of node n + tap − taps/2 + 1
    missed: float  # share of the power, in the mean over the phases


def interpolation_loss(share: float) -> float:
    """Share of the power that may be missed between nodes where that share may be left out."""
    return max(share, _LEAST)


def widest(correlation: Correlation, pulse_s: float, share: float, longest: int) -> NodeWeights:
    """The widest stride, up to `longest`, at which no more than a share of the power is missed, and the fewest taps for
    it; pulse_s [s]: between pulses."""
    share, narrow, wide = interpolation_loss(share), 1, longest + 1
    while wide - narrow > 1:  # what is missed grows with the stride
        middle = (narrow + wide) // 2
        narrow, wide = (
            (middle, wide)
            if interpolation_weights(correlation, pulse_s, middle, _MOST_TAPS).missed <= share
            else (narrow, middle)
        )
    if narrow == 1:
        return NodeWeights(1, np.ones((1, 1), np.float32), 0.0)
    made = (interpolation_weights(correlation, pulse_s, narrow, taps) for taps in range(2, _MOST_TAPS + 1, 2))
    return next(each for each in made if each.missed <= share or each.weights.shape[1] == _MOST_TAPS)


def interpolation_weights(correlation: Correlation, pulse_s: float, stride: int, taps: int) -> NodeWeights:
    """The weights of so many nodes, an even number, around each pulse between nodes `stride` apart."""
    node = np.arange(taps, dtype=np.float64) * stride - (taps // 2 - 1) * stride
    among = correlation(pulse_s * (node[:, None] - node))
    towards = correlation(pulse_s * (np.arange(stride, dtype=np.float64)[:, None] - node))
    weights = np.linalg.solve(among + _NOISE * np.eye(taps), towards.T).T
    missed = 1.0 - 2.0 * np.sum(weights * towards, axis=1) + np.sum((weights @ among) * weights, axis=1)
    return NodeWeights(stride, weights.astype(np.float32), float(missed.mean()))


def correlation_of(radar: RadarSettings, sweep_deg_s: float, doppler_hz: float, time_constant_s: float) -> Correlation:
    """ρ of what a beam hears that turns so fast [°/s], with the fastest scatterer's Doppler frequency and the shortest
    decorrelation time τc of any, which may be infinite."""
    step, beam = _beam_correlation(radar)
    turned = np.arange(beam.size) * (step / max(np.radians(sweep_deg_s), 1e-12))  # s

    def correlation(lag: NDArray[np.float64]) -> NDArray[np.float64]:
        smooth = np.exp(-((lag / time_constant_s) ** 2)) * np.sinc(2.0 * doppler_hz * lag)
        return smooth * np.interp(np.abs(lag), turned, beam, right=0.0)

    return correlation


@cache_by_radar(maxsize=8)
def _beam_correlation(radar: RadarSettings) -> tuple[float, NDArray[np.float64]]:
    """Size of a step [rad], and the two-way beam's correlation with itself turned by so many; of all paths' beams, that
    which changes fastest."""
    beams = two_way_beams(radar)
    voltage = beams.tables.astype(np.float64).prod(axis=1)
    changes = np.sum(np.diff(voltage, axis=1) ** 2, axis=1) / np.sum(voltage**2, axis=1)
    spectrum = np.abs(np.fft.rfft(voltage[np.argmax(changes)], 2 * voltage.shape[1])) ** 2
    correlation = np.fft.irfft(spectrum)[: voltage.shape[1]]
    return 1.0 / beams.scale, correlation / correlation[0]


_LONGEST_STRIDE = 64  # pulses between nodes, however still the sea: nothing is gained beyond
_PULSES, _NODES = 500, 64  # worked on at a time


@dataclass(frozen=True)
class Nodes:
    """Slow-time nodes of a turn: node n lies at pulse n·stride (n may be negative or beyond the last pulse)."""

    stride: int  # pulses
    first: int  # number of the first node, 0 or negative
    count: int
    spacing_s: float  # s
    time: NDArray[np.float64]  # (node,) s
    weights: NDArray[np.float32]  # (phase, tap) of the nodes around a pulse; see `NodeWeights`
    missed: float  # share of the power, between nodes


def choose_nodes(
    facets: Facets,
    radar: RadarSettings,
    pulses: Pulses,
    decorrelation_time_s: float,
    motion: Motion | None = None,
    fastest: SpeedBounds | None = None,
    neglected: float = 0.0,
) -> Nodes:
    """Nodes so far apart that no more than a share `neglected` of the power is missed between them, by rotation, by
    Doppler up to the fastest scatterer's, and speckle of decorrelation time τc [s], which may be infinite.

    motion: of the scatterers relative to the water; fastest: the facets' speeds, where they are known already.
    """
    drift = float(np.max(np.linalg.norm(facets.grid.drift, axis=-1), initial=0.0))
    fastest = fastest or SpeedBounds.of(facets, motion)
    echo = fastest_echo(fastest, radar_wavenumber(radar.frequency_hz), decorrelation_time_s, motion, drift)
    correlation = correlation_of(radar, _fastest_sweep(facets, pulses), *echo)
    between = widest(correlation, 1.0 / radar.prf_hz, neglected, _LONGEST_STRIDE)
    stride, margin = between.stride, between.weights.shape[1] // 2
    last = -(-pulses.number.size // stride)
    spacing_s = stride / radar.prf_hz
    first = -margin
    count = last + margin + 1 - first
    time = pulses.time[0] + spacing_s * np.arange(first, first + count)
    return Nodes(stride, first, count, spacing_s, time, between.weights, between.missed)


def _fastest_sweep(facets: Facets, pulses: Pulses) -> float:
    """Degrees that the boresight turns in a second: the turntable's, or more where a boat yaws much with it.

    Less than a tenth more is held by the oversampling, and turns that differ so little keep the same nodes.
    """
    if pulses.installation.rate == 0.0:
        return 0.0
    fastest = facets.grid.spacing_deg / float(np.diff(facets.grid.time).min())
    return fastest if fastest > 1.1 * pulses.installation.rate else pulses.installation.rate


def nodes_first(sums: NDArray[np.float32]) -> NDArray[np.complex64]:
    """Complex sums (node, path, gate) from real and imaginary ones (component, path, gate, node)."""
    echo = np.empty((sums.shape[3], *sums.shape[1:3]), dtype=np.complex64)

    def work(first: int) -> None:
        nodes = slice(first, first + _NODES)
        echo.real[nodes], echo.imag[nodes] = sums[..., nodes].transpose(0, 3, 1, 2)

    with pool() as workers:
        list(workers.map(work, range(0, len(echo), _NODES)))
    return echo


def pulses_from_nodes(echo: NDArray[np.complex64], nodes: Nodes, array: Array, pulses: Pulses) -> NDArray[np.complex64]:
    """Voltages (pulse, receiver, gate) [√W] from the paths' sums (node, path, gate) [√W], by its weights; NaN where
    the mode does not sample a receiver."""
    count = pulses.number.size
    voltages = np.empty((count, len(array.receivers), echo.shape[2]), dtype=np.complex64)
    path = paths_of_cycle(array)
    # Real and imaginary components are weighed alike: plain numbers, twice as many.
    sums, out = (each.view(np.float32).reshape(*each.shape[:2], -1) for each in (echo, voltages))

    def work(start: int) -> None:
        stop = min(start + _PULSES, count)
        _interpolate(sums, -nodes.first, nodes.stride, nodes.weights, path[pulses.slot[start:stop]], start, out)

    with pool() as workers:
        list(workers.map(work, range(0, count, _PULSES)))
    return voltages


def paths_of_cycle(array: Array) -> NDArray[np.intp]:
    """The path (slot, receiver) that is heard on each pulse of the mode's cycle; −1 where none is."""
    path = np.full((len(array.cycle), len(array.receivers)), -1)
    for number, slot in enumerate(array.cycle):
        for receiver in slot.receivers:
            path[number, receiver] = array.path(slot.transmitter, receiver)
    return path


@compiled
def _interpolate(echo, zero, stride, weights, path, start, voltages):
    """Fill voltages (pulse, receiver, number) from `start` on; echo (node, path, number), `zero` the node of pulse 0.

    weights (phase, tap): of an even number of nodes around a pulse, by its number of pulses after a node; path (pulse,
    receiver), −1 for none.
    """
    taps = weights.shape[1]
    for pulse in range(path.shape[0]):
        node, phase = zero + (start + pulse) // stride, (start + pulse) % stride
        for receiver in range(path.shape[1]):
            row, number = voltages[start + pulse, receiver], path[pulse, receiver]
            if number < 0:
                row[:] = np.float32(np.nan)
            elif phase == 0:
                for n in range(row.size):  # loops: to assign a part of an array takes the compiler two seconds
                    row[n] = echo[node, number, n]
            else:
                first = node - taps // 2 + 1
                for tap in range(0, taps, 2):  # two at a time: the row is read and written half as often
                    one, other = weights[phase, tap], weights[phase, tap + 1]
                    near, beside = echo[first + tap, number], echo[first + tap + 1, number]
                    if tap == 0:
                        for n in range(row.size):
                            row[n] = one * near[n] + other * beside[n]
                    else:
                        for n in range(row.size):
                            row[n] += one * near[n] + other * beside[n]
