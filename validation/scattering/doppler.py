"""Decorrelation and Doppler of the voltages beside those of their scatterers: up-wave and down-wave, HH and VV.

    python -m validation.scattering.doppler [--seeds 4] [--out validation/figures]

The slowest scan (1 rpm, a beam's dwell of 0.2 s resolves 2 Hz) over the waves of `choppy_sea`. Draws

  doppler_correlation.png   autocorrelation of cells of a sea at rest, beside the one that was set
  doppler_spectra.png       Doppler spectra of range cells, beside the radial velocities of the water that they see
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

import seamap_rt as sr
from seamap_rt.conventions import POLARIZATIONS, radar_wavenumber
from seamap_rt.echoes import turn_voltages
from seamap_rt.echoes.paths import facet_paths
from seamap_rt.echoes.speckle import Motion
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import gates
from seamap_rt.report import style
from seamap_rt.scene import Scene
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import Illumination

from .. import FIGURES
from ..options import options

UP_WAVE, DOWN_WAVE = 270.0, 90.0  # waves and wind of choppy_sea come from 270°
LOOKS = ((UP_WAVE, "up-wave"), (DOWN_WAVE, "down-wave"))
SEGMENT = 400  # pulses: with a Hann window 3 Hz
DWELL_DEG = 1.27  # two-way beam at half power
COLOUR = {"VV": style.BLUE, "HH": style.VERMILION}
SHOWN_HZ = 300.0
SMOOTH = 31  # gates: a wavelength of the waves' peak


def slow_scene(look_deg: float, polarization: str = "VV", **others) -> Scene:
    """choppy_sea in 10° about a look, so slowly that a dwell resolves the Doppler."""
    overrides = {
        "scattering.polarization": polarization,
        "radar.sector_deg": [look_deg - 5.0, look_deg + 5.0],
        "radar.range_m": [50.0, 200.0],
        "radar.rotation_rpm": 1.0,
        "radar.prf_hz": 800.0,
        "radar.transmit": "single",
        "radar.noise": False,
        "tracing.tracer": "horizon",
    }
    return sr.load_scene("choppy_sea", overrides={**overrides, **others})


# ------------------------------------------------------------------------------------------------- autocorrelation


@dataclass(frozen=True)
class Case:
    """One kind of scatterers, for the first figure."""

    name: str
    colour: str
    approaching: float
    share: float  # of breakers
    speed: float = 0.0

    def motion(self, facets: Illumination) -> Motion:
        columns = facets.grid.columns
        share = np.full(facets.height.shape, self.share, dtype=np.float32)
        return Motion(0.23, np.full(columns, self.approaching), share, np.full(columns, self.speed), 0.5)

    def law(self, lag: NDArray[np.float64], tau: float, k: float) -> NDArray[np.complex128]:
        """The covariance that was set."""
        phase = 2.0 * k * 0.23 * lag
        bragg = np.cos(phase) + 1j * (2.0 * self.approaching - 1.0) * np.sin(phase)
        breakers = np.exp(-2j * k * self.speed * lag - 0.5 * (2.0 * k * 0.5 * lag) ** 2)
        return np.exp(-((lag / tau) ** 2)) * ((1.0 - self.share) * bragg + self.share * breakers)


CASES = (
    Case("Bragg waves, both ways alike", style.BLACK, 0.5, 0.0),
    Case("Bragg waves, 90 % approach", style.BLUE, 0.9, 0.0),
    Case("and half breakers at 3 m/s towards", style.VERMILION, 0.9, 0.5, -3.0),
    Case("breakers at 1 m/s away", style.GREEN, 0.5, 1.0, 1.0),
)


def correlations(seeds: int) -> tuple[NDArray[np.float64], dict[str, NDArray[np.complex128]], Scene]:
    """Lags [s] and each case's autocorrelation over the gates and pulses of a flat sea at rest, the beam taken out."""
    scene = slow_scene(UP_WAVE, **{"sea.waves": [], "scattering.nrcs": "constant", "radar.rotation_rpm": 3.0})
    facets, (rcs, _, _), _ = Simulator(scene).light(0)
    fired, lags, tau = pulses(Installation(scene.radar), 0), np.arange(25), scene.scattering.decorrelation_time_s

    def correlation(decorrelation_time_s: float, motion: Motion | None) -> NDArray[np.complex128]:
        total = np.zeros(lags.size, dtype=np.complex128)
        for seed in range(seeds):
            v = turn_voltages(facets, rcs, Installation(scene.radar), fired, seed, decorrelation_time_s, motion=motion)[
                :, 0
            ]
            v = v.astype(np.complex128) * gates(scene.radar) ** 2  # all ranges count
            total += [np.sum(v[lag:] * v[: v.shape[0] - lag].conj()) for lag in lags]
        return total / total[0].real

    beam = correlation(np.inf, None)
    return lags / scene.radar.prf_hz, {c.name: correlation(tau, c.motion(facets)) / beam for c in CASES}, scene


@style.styled
def draw_correlations(
    lag: NDArray[np.float64], correlation: dict[str, NDArray[np.complex128]], tau: float, k: float
) -> Figure:
    figure = style.new_figure(3.0)
    fine = np.linspace(0.0, lag[-1], 400)
    for n, (part, name) in enumerate(((np.real, "real part"), (np.imag, "imaginary part"))):
        axes = style.place(figure, 0.55 + 3.5 * n, 0.3, 2.9, 1.75)
        style.graph(axes, "lag, ms", "autocorrelation", f"{'ab'[n]}) {name}")
        for case in CASES:
            axes.plot(1e3 * fine, part(case.law(fine, tau, k)), color=case.colour, linewidth=1.0, label=case.name)
            axes.plot(
                1e3 * lag, part(correlation[case.name]), color=case.colour, marker="o", markersize=2.5, linestyle=""
            )
        axes.axhline(0.0, color=style.GREY, linewidth=0.5)
        axes.set_xlim(0.0, 1e3 * lag[-1])
        if n == 0:
            figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=2)
    return figure


# ------------------------------------------------------------------------------------------------- spectra


@dataclass(frozen=True)
class Look:
    """Spectra (gate, frequency) of one look; over a wavelength of sea the mean power of the gates is 1."""

    frequency: NDArray[np.float64]  # Hz, ascending
    simulated: NDArray[np.float64]
    expected: NDArray[np.float64]  # of the scatterers that are in the cell
    water: NDArray[np.float64]  # of the water under them, without their own motion and speckle
    middle: NDArray[np.float64]  # one dwell's spectra in the middle of the sector
    middle_water: NDArray[np.float64]  # (gate,) Hz, that dwell's mean Doppler of the water; nan where all is dark

    def mean(self, spectra: NDArray[np.float64]) -> NDArray[np.float64]:
        """Density over frequency, all gates alike [1/Hz]."""
        return spectra.mean(axis=0) / (self.frequency[1] - self.frequency[0])

    def centroid(self, spectra: NDArray[np.float64]) -> float:
        """Mean frequency [Hz]."""
        mean = self.mean(spectra)
        return float(np.sum(mean * self.frequency) / np.sum(mean))


def look_spectra(scene: Scene, seeds: int) -> Look:
    """Simulated and predicted spectra; the seeds draw other speckle over the same sea."""
    facets, (rcs, motion, running), _ = Simulator(scene).light(0)
    assert motion is not None  # scattering.doppler = "full"
    if running is not None:
        facets = replace(facets, velocity_look=facets.velocity_look + running)
    radar, fired = scene.radar, pulses(Installation(scene.radar), 0)
    frequency = np.arange(-(SEGMENT // 2), SEGMENT // 2, dtype=np.float64) * (radar.prf_hz / SEGMENT)
    water, expected = expected_spectra(facets, rcs, scene, motion, frequency)
    power = uniform_filter1d(expected.sum(axis=1, keepdims=True), SMOOTH, axis=0)
    simulated, middle = np.zeros_like(expected), np.zeros_like(expected)
    for seed in range(seeds):
        v = turn_voltages(
            facets, rcs, Installation(radar), fired, seed, scene.scattering.decorrelation_time_s, motion=motion
        )[:, 0].T.astype(np.complex128)
        spectra = np.stack([segment_spectra(v[:, start : start + SEGMENT]) for start in segments(v.shape[1])])
        simulated += spectra.mean(axis=0) / seeds
        if seed == 0:
            half = fired.time.size // 2 - SEGMENT // 4  # half as long: the beam turns by 1.5°
            middle = segment_spectra(v[:, half : half + SEGMENT // 2], SEGMENT)
    dwelt = np.abs(facets.grid.column_sweep - 5.0) <= 0.5 * DWELL_DEG
    at_once, _ = expected_spectra(facets, rcs, scene, motion, frequency, dwelt)
    with np.errstate(invalid="ignore"):
        middle_water = (at_once @ frequency) / at_once.sum(axis=1)
    scale = np.mean(
        simulated.sum(axis=1) / power[:, 0]
    )  # the antenna's azimuth pattern and the range response, the same for all
    return Look(
        frequency, simulated / power / scale, expected / power, water / power, middle / power / scale, middle_water
    )


def segments(count: int) -> Iterator[int]:
    """First pulses of segments that overlap by a half."""
    yield from range(0, count - SEGMENT + 1, SEGMENT // 2)


def segment_spectra(v: NDArray[np.complex128], size: int = SEGMENT) -> NDArray[np.float64]:
    """(gate, frequency) periodogram with a Hann window, whose sum over frequency is the mean power."""
    window = np.hanning(v.shape[1])
    amplitude = np.fft.fftshift(np.fft.fft(v * window, size, axis=1), axes=1)
    return np.abs(amplitude) ** 2 / (size * np.sum(window**2))


def expected_spectra(
    facets: Illumination,
    rcs: NDArray[np.float32],
    scene: Scene,
    motion: Motion,
    frequency: NDArray[np.float64],
    chosen: NDArray[np.bool_] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(gate, frequency): returned power by the Doppler of the water, and by that of the scatterers on it.

    A facet counts for the nearest gate; columns (those of the sector, unless chosen) count alike.
    """
    radar, step = scene.radar, frequency[1] - frequency[0]
    sweep = facets.grid.column_sweep
    columns = np.flatnonzero((sweep > 0.0) & (sweep < 10.0) if chosen is None else chosen)
    paths = facet_paths(facets, rcs, Installation(radar), slice(columns[0], columns[-1] + 1))
    power = np.abs(paths.amplitude[0]).astype(np.float64) ** 2
    k, tau = radar_wavenumber(radar.frequency_hz), scene.scattering.decorrelation_time_s
    gate = np.rint((paths.range[0] - gates(radar)[0]) / radar.range_sampling_m)

    def by_doppler(share: NDArray[np.float64], outward: NDArray[np.float64] | float) -> NDArray[np.float64]:
        doppler = -k / np.pi * (paths.coming.mean(axis=0) + outward)
        edges = [np.arange(gates(radar).size + 1) - 0.5, np.append(frequency, frequency[-1] + step) - 0.5 * step]
        return np.histogram2d(gate.ravel(), doppler.ravel(), edges, weights=(share * power).ravel())[0]

    def widened(spectra: NDArray[np.float64], time_constant: float) -> NDArray[np.float64]:
        sigma = 1.0 / (np.sqrt(2.0) * np.pi * time_constant * step)  # of exp(−(τ/τc)²)
        return gaussian_filter1d(spectra, sigma, axis=1, mode="wrap")

    breaking = np.zeros_like(power) if motion.breaking is None else motion.breaking[columns].astype(np.float64)
    towards, speed = motion.approaching[columns, None], motion.breaker_speed[columns, None]
    bragg = by_doppler((1.0 - breaking) * towards, -motion.bragg_speed)
    bragg += by_doppler((1.0 - breaking) * (1.0 - towards), motion.bragg_speed)
    breakers = widened(by_doppler(breaking, speed), motion.breaker_time(k, tau))
    return by_doppler(np.ones_like(power), 0.0), widened(bragg, tau) + breakers


@style.styled
def draw_spectra(looks: dict[tuple[float, str], Look], radar_gates: NDArray[np.float64], hz: float) -> Figure:
    """Range–Doppler pictures of one dwell, and mean spectra; hz: Doppler of 1 m/s."""
    figure = style.new_figure(6.35)
    for n, polarization in enumerate(POLARIZATIONS):
        axes = style.place(figure, 0.5 + 3.45 * n, 0.3, 2.9, 2.2)
        title = f"{'ab'[n]}) up-wave, {polarization}: one dwell of {0.5 * SEGMENT / 800.0:.2f} s"
        draw_dwell(axes, looks[UP_WAVE, polarization], radar_gates, title)
    label = "power density over its mean in a wavelength of sea, dB"
    style.colour_bar(figure, figure.axes[0].collections[0], 2.2, 3.0, 2.8, label, "both")
    for n, (direction, name) in enumerate(LOOKS):
        axes = style.place(figure, 0.5 + 3.45 * n, 4.1, 2.9, 1.65)
        style.graph(axes, "Doppler frequency, Hz", "density, 10⁻³/Hz", "")
        axes.set_title(f"{'cd'[n]}) {name}, {radar_gates[0]:.0f}–{radar_gates[-1]:.0f} m", pad=25.0)
        draw_mean(axes, {p: looks[direction, p] for p in POLARIZATIONS})
        top = axes.secondary_xaxis("top", functions=(lambda f: np.divide(f, hz), lambda v: np.multiply(v, hz)))
        top.set_xlabel("velocity towards the radar, m/s", labelpad=2.0)
        if n == 0:
            figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=5, columnspacing=1.0)
    return figure


def draw_mean(axes: Axes, looks: dict[str, Look]) -> None:
    """Mean spectra of a look, over the distribution of the water's own Doppler."""
    water = looks["VV"]
    axes.fill_between(
        water.frequency, 1e3 * water.mean(water.water), color=style.GREY, alpha=0.3, linewidth=0.0, label="water, VV"
    )
    for polarization, look in looks.items():
        colour = COLOUR[polarization]
        axes.plot(look.frequency, 1e3 * look.mean(look.simulated), color=colour, linewidth=0.9, label=polarization)
        axes.plot(
            look.frequency,
            1e3 * look.mean(look.expected),
            color=style.BLACK,
            linewidth=1.0,
            linestyle=":" if polarization == "VV" else "--",
            label=f"{polarization}, from the facets",
        )
    axes.set_xlim(-SHOWN_HZ, SHOWN_HZ)
    axes.set_ylim(0.0, None)
    axes.axvline(0.0, color=style.GREY, linewidth=0.5)


def draw_dwell(axes: Axes, look: Look, ranges: NDArray[np.float64], title: str) -> None:
    """One dwell's spectra, and the mean Doppler of the water that it lights."""
    style.graph(axes, "Doppler frequency, Hz", "range, m", title)
    level = 10.0 * np.log10(np.maximum(look.middle * look.frequency.size, 1e-6))
    axes.pcolormesh(look.frequency, ranges, level, vmin=-15.0, vmax=20.0, cmap=style.POWER_COLOURS, rasterized=True)
    axes.plot(look.middle_water, ranges, color="white", linewidth=2.4)
    axes.plot(look.middle_water, ranges, color=style.VERMILION, linewidth=1.2)
    axes.set_xlim(-SHOWN_HZ, SHOWN_HZ)
    axes.set_ylim(ranges[0], ranges[-1])
    axes.grid(False)


# ------------------------------------------------------------------------------------------------- main


def main() -> None:
    chosen = options(__doc__, seeds=4, out=FIGURES)
    chosen.out.mkdir(parents=True, exist_ok=True)

    lag, correlation, scene = correlations(chosen.seeds)
    k, tau = radar_wavenumber(scene.radar.frequency_hz), scene.scattering.decorrelation_time_s
    print(f"autocorrelation over {lag[-1] * 1e3:.0f} ms, {chosen.seeds} draws: largest deviation from the expected one")
    for case in CASES:
        print(f"  {case.name:36} {np.max(np.abs(correlation[case.name] - case.law(lag, tau, k))):.4f}")
    (chosen.out / "doppler_correlation.png").write_bytes(style.png(draw_correlations(lag, correlation, tau, k)))

    looks = {}
    print(f"{'mean Doppler':24} {'water':>8} {'expected':>10} {'simulated':>9}   Hz (positive: approaching)")
    for direction, name in LOOKS:
        for polarization in POLARIZATIONS:
            scene = slow_scene(direction, polarization)
            look = looks[direction, polarization] = look_spectra(scene, chosen.seeds)
            centroids = [look.centroid(s) for s in (look.water, look.expected, look.simulated)]
            print(
                f"{name + ', ' + polarization:24} {centroids[0]:8.1f} {centroids[1]:10.1f} {centroids[2]:8.1f}",
                flush=True,
            )
    (chosen.out / "doppler_spectra.png").write_bytes(style.png(draw_spectra(looks, gates(scene.radar), k / np.pi)))
    print(f"figures: {chosen.out}/doppler_correlation.png, doppler_spectra.png")


if __name__ == "__main__":
    main()
