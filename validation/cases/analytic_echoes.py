"""Closed forms of the echo: its power, its speckle, its phase and its Doppler, from the simulated voltages."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT, db, from_db
from seamap_rt.echoes import from_scatterers, turn_voltages
from seamap_rt.radar.antenna import antenna
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.report import style
from seamap_rt.scene import Scene
from seamap_rt.settings import RadarSettings, RetrievalSettings
from seamap_rt.simulation import Simulator

from .. import analytic
from ..reference_forms import directivity, pulse_response
from ..report import Case, Check, Outcome
from ..report.checks import at_most, recorded, relative, within

Array = NDArray[np.float64]
WAVELENGTH = SPEED_OF_LIGHT / 10e9
NRCS_DB = -40.0
INKS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE, style.ORANGE)


def flat_scene(**radar: object) -> Scene:
    """A flat sea of constant NRCS, without noise."""
    changes = {"tracing.tracer": "horizon", "scattering.nrcs": "constant", "scattering.nrcs_db": NRCS_DB}
    return sr.load_scene("flat", {**changes, "radar.noise": False, **{f"radar.{k}": v for k, v in radar.items()}})


# ----------------------------------------------------------------------------------------------- radar equation


def radar_equation(full: bool) -> Outcome:
    """Every gate's expected power against the integral, for two patterns, two masts and a tilted array."""
    cases = [(pattern, mast, 0.0) for pattern in ("slotted_waveguide", "gaussian") for mast in (5.0, 20.0)]
    # The quadrature takes gain and response from the radar: they are judged by integrals of their own.
    checks, curves = [*_gain_and_response()], []
    for pattern, mast, tilt in (*cases, ("slotted_waveguide", 5.0, 8.0)):
        antenna = {"antenna.pattern": pattern, "height_m": mast, "tilt_deg": tilt}
        scene = flat_scene(**antenna, sector_deg=[0.0, 3.6], range_m=[30.0, 400.0])
        expected = sr.expected(scene)
        gates, simulated = expected["range"].values, expected["power"].values[0, 1].mean(axis=0)
        judge = analytic.flat_sea_power(scene.radar, from_db(NRCS_DB), gates)
        off = float(np.max(np.abs(db(simulated / judge))))
        checks.append(
            at_most(
                f"{pattern.replace('_', ' ')}, {mast:g} m mast, tilt {tilt:g}°: worst of {gates.size} gates",
                off,
                0.05,
                "dB",
            )
        )
        textbook = analytic.flat_sea_power_textbook(scene.radar, from_db(NRCS_DB), gates)
        curves.append((f"{pattern.replace('_', ' ')}, {mast:g} m", gates, simulated, judge, textbook))
    gap = db(curves[0][4] / curves[0][2])
    words = f"{gap[0]:.2f} dB at 30 m, {gap[-1]:.2f} dB at 400 m"
    checks.append(recorded("what the handbook's closed form promises too much, slotted waveguide, 5 m", words))
    caption = (
        "Power of a flat sea of −40 dB by range. Dots: simulated, every tenth gate; lines: the radar equation's "
        "integral over beam and pulse; dashed: the handbook's Pt G²λ²σ0A/((4π)³R⁴L), which knows no elevation pattern."
    )
    return Outcome(tuple(checks), _draw_power(curves[:4]), caption)


def _gain_and_response() -> list[Check]:
    checks = []
    for pattern in ("slotted_waveguide", "gaussian"):
        made = antenna(flat_scene(**{"antenna.pattern": pattern}).radar)
        what = f"{pattern.replace('_', ' ')}: gain over 4π/∬|V|²dΩ"
        checks.append(relative(what, made.gain / directivity(made), 1.0, 1e-3))
    radar = flat_scene().radar
    offset = np.linspace(-6.0, 6.0, 481)
    off = float(np.max(np.abs(RangeResponse.of(radar)(offset) - pulse_response(radar, offset))))
    checks.append(at_most("response to a point against the filter's transform, worst within 6 m", off, 1e-3))
    return checks


@style.styled
def _draw_power(curves: list[tuple[str, Array, Array, Array, Array]]) -> Figure:
    figure = style.new_figure(3.0)
    axes = style.place(figure, 0.6, 0.3, 4.3, 2.25)
    for (name, gates, simulated, judge, textbook), ink in zip(curves, INKS, strict=False):
        axes.plot(gates, db(judge) + 30.0, color=ink, lw=0.9, label=name)
        axes.plot(gates[::10], db(simulated)[::10] + 30.0, ".", color=ink, ms=4)
        axes.plot(gates, db(textbook) + 30.0, "--", color=ink, lw=0.6)
    axes.set_ylim(-150.0, -60.0)
    axes.legend(bbox_to_anchor=(1.02, 1.0), loc="upper left")
    style.graph(axes, "range [m]", "power [dBm]", "Echo of a flat sea, −40 dB")
    return figure


# ------------------------------------------------------------------------------------------------------- speckle


def speckle(full: bool) -> Outcome:
    """Intensity, its contrast, its independence, and its decorrelation in time."""
    scene = flat_scene(range_m=[60.0, 105.0], transmit="single")
    facets, returns, _ = Simulator(scene).light(0)
    volts = turn_voltages(
        facets, returns.rcs, Installation(scene.radar), pulses(Installation(scene.radar), 0), 3, 0.5e-3
    )[:, 0]
    intensity = np.abs(volts[:, ::5].astype(np.complex128)) ** 2  # gates 7.5 m apart share no echo
    intensity /= intensity.mean(axis=0)
    contrast = (intensity**2).mean(axis=1).reshape(50, -1).mean(axis=1)
    error = float(contrast.std(ddof=1) / np.sqrt(50))
    checks = [within("⟨I²⟩/⟨I⟩² of one pulse in one gate", float(contrast.mean()), 2.0, 4.0 * error)]
    for level in (1.0, 2.0, 4.0):
        share = (intensity > level).mean(axis=1).reshape(50, -1).mean(axis=1)
        error = float(share.std(ddof=1) / np.sqrt(50))
        what = f"share of intensities above {level:g} of their mean"
        checks.append(within(what, float(share.mean()), float(np.exp(-level)), 4.0 * error))
    lags, correlations, laws = _forgetting()
    for tau, kept in correlations.items():
        checks.append(
            at_most(
                f"correlation in time, τc = {1e3 * tau:g} ms, worst lag", float(np.max(np.abs(kept - laws[tau]))), 0.05
            )
        )
    caption = (
        "Left: intensities of a flat sea's echo over their mean, and the exponential that many scatterers give. Right: "
        "correlation of the voltages over that of speckle that never changes, and exp(−(τ/τc)²)."
    )
    return Outcome(tuple(checks), _draw_speckle(intensity, lags, correlations), caption)


def _forgetting() -> tuple[Array, dict[float, Array], dict[float, Array]]:
    """Lags [s], correlation at them, simulated and set, by decorrelation time [s]."""
    scene = flat_scene(rotation_rpm=6.0, sector_deg=[20.0, 80.0], prf_hz=4e3, range_m=[15.0, 120.0], transmit="single")
    facets, returns, _ = Simulator(scene).light(0)
    fired, lags = pulses(Installation(scene.radar), 0), np.array([0, 2, 4, 8, 12, 16, 24, 32])

    def correlation(tau: float) -> NDArray[np.complex128]:
        volts = turn_voltages(facets, returns.rcs, Installation(scene.radar), fired, 4, tau)[:, 0].astype(np.complex128)
        volts /= np.sqrt(np.mean(np.abs(volts) ** 2, axis=0))
        return np.array([np.mean(volts[lag:] * volts[: volts.shape[0] - lag].conj()) for lag in lags])

    still, times = correlation(np.inf), lags / scene.radar.prf_hz
    correlations = {tau: (correlation(tau) / still).real for tau in (2e-3, 5e-3)}
    return times, correlations, {tau: np.exp(-((times / tau) ** 2)) for tau in correlations}


@style.styled
def _draw_speckle(intensity: Array, lags: Array, correlations: dict[float, Array]) -> Figure:
    figure = style.new_figure(2.7)
    left = style.place(figure, 0.55, 0.3, 2.9, 1.95)
    edges = np.linspace(0.0, 8.0, 41)
    count, _ = np.histogram(intensity.ravel(), edges)
    middle = 0.5 * (edges[1:] + edges[:-1])
    left.semilogy(middle, count / (intensity.size * np.diff(edges)), ".", color=style.BLUE, ms=4)
    left.semilogy(edges, np.exp(-edges), color=style.VERMILION, lw=0.9)
    style.graph(left, "intensity over its mean", "density", "One pulse, one gate")
    right = style.place(figure, 4.1, 0.3, 2.9, 1.95)
    for (tau, kept), ink in zip(correlations.items(), INKS, strict=False):
        fine = np.linspace(0.0, lags[-1], 200)
        right.plot(1e3 * fine, np.exp(-((fine / tau) ** 2)), color=ink, lw=0.9)
        right.plot(1e3 * lags, kept, ".", color=ink, ms=5, label=f"τc = {1e3 * tau:g} ms")
    right.legend()
    style.graph(right, "lag [ms]", "correlation", "Pulse to pulse")
    return figure


# ------------------------------------------------------------------------------------------------------- Doppler


SPEEDS = (-6.0, -2.0, -0.5, 0.5, 2.0, 6.0)  # m/s, outward
RECEDING = 1.0  # m/s


def doppler(full: bool) -> Outcome:
    """A point that moves turns its voltage by −2v/λ; a sea that moves shifts the heights of alternating pulses."""
    worst = max(abs(_turning(speed) + 2.0 * speed * 100.0 / np.hypot(100.0, 5.0) / WAVELENGTH) for speed in SPEEDS)
    checks = [at_most("frequency of a point at ±0.5 to ±6 m/s against −2v/λ, worst", worst, 0.5, "Hz")]
    biases: dict[str, tuple[Array, Array]] = {}
    for pairs, sign in (("forward", 1.0), ("backward", -1.0), ("both", 0.0)):
        ranges, bias = _bias_of(pairs)
        # The upper antenna hears after the lower one in a forward pair: what recedes is farther from it than it was,
        # and farther from the upper antenna is lower.
        law = -sign * 2.0 * RECEDING * 1e-4 * ranges / 0.1
        off = float(np.max(np.abs(bias - law)))
        at = float(np.interp(100.0, ranges, bias))
        checks.append(at_most(f"{pairs}: height bias at 1 m/s against 2vτR/(pB), worst", 1e3 * off, 5.0, "mm"))
        checks.append(recorded(f"{pairs}: bias at 100 m", f"{at:+.4f} m"))
        biases[pairs] = (ranges, bias)
    caption = (
        "Height bias of a flat sea that recedes at 1 m/s, one transmitter, alternating receivers 100 µs apart, "
        "baseline 0.1 m. Dots: retrieved; lines: ∓2vτR/(pB)."
    )
    return Outcome(tuple(checks), _draw_doppler(biases), caption)


def _turning(speed: float) -> float:
    """Frequency [Hz] of the echo of a point 100 m away that moves outward."""
    scene = flat_scene(sector_deg=[0.0, 9.0], range_m=[88.0, 112.0], transmit="single")
    out = np.array([np.sin(np.radians(4.5)), np.cos(np.radians(4.5)), 0.0])
    volts = from_scatterers(scene, [100.0 * out], [1.0], [speed * out])["voltage"].values[:, 0].astype(np.complex128)
    return float(np.angle(np.sum(volts[1:] * volts[:-1].conj())) * scene.radar.prf_hz / (2.0 * np.pi))


def _bias_of(pairs: str) -> tuple[Array, Array]:
    """Ranges and mean height of a receding flat sea, by the pulse pairs that are taken."""
    mode = {"transmit": "single", "interferogram": "alternating_pulse", "baseline_m": 0.1}
    radar = RadarSettings.model_validate({"sector_deg": (0.0, 18.0), "range_m": (40.0, 250.0), **mode})
    echoes = analytic.echoes(analytic.FlatSea(), radar, radial_velocity_m_s=RECEDING)
    settings = {"estimator": "single_cell", "cell_range_m": 1.5, "ground_m": 500.0, "pulse_pairs": pairs}
    maps = sr.retrieve(echoes, RetrievalSettings.model_validate(settings))["polar"].to_dataset()
    return maps["range"].values, maps["height"].values[0, 1:-1].mean(axis=0)


@style.styled
def _draw_doppler(biases: dict[str, tuple[Array, Array]]) -> Figure:
    figure = style.new_figure(2.7)
    axes = style.place(figure, 0.6, 0.3, 4.0, 1.95)
    for (pairs, (ranges, bias)), ink in zip(biases.items(), INKS, strict=False):
        axes.plot(ranges[::8], bias[::8], ".", color=ink, ms=5, label=f"{pairs} pairs")
    ranges = biases["both"][0]
    for sign in (-1.0, 0.0, 1.0):
        axes.plot(ranges, sign * 2.0 * RECEDING * 1e-4 * ranges / 0.1, color=style.BLACK, lw=0.7)
    axes.legend(bbox_to_anchor=(1.02, 1.0), loc="upper left")
    style.graph(axes, "range [m]", "height bias [m]", "Alternating pulses, sea receding at 1 m/s")
    return figure


CASES = [
    Case(
        name="radar_equation",
        group="closed forms",
        title="Echo power obeys the radar equation's integral",
        rationale="Detection range, signal-to-noise and with them every error bar hang on the level.",
        setup="A flat sea of −40 dB from mesh, tracer, patterns and pulse: the expected power of every gate, 30–400 m.",
        expectation="Pt λ²σ0/((4π)³L) ∬ G²|h|²R⁻⁴ dA by a quadrature of its own, to 0.05 dB; G by the pattern's "
        "integral and h by the filter's transform, to 1e-3. Facets of half a metre under a response of ten, and "
        "columns under a third of the beam, sum smooth functions and cost far less.",
        run=radar_equation,
    ),
    Case(
        name="speckle",
        group="closed forms",
        title="Speckle is Gaussian and forgets itself as it should",
        rationale="Speckle sets the floor of a radar's heights; too tame a speckle would make every map too good.",
        setup="Voltages of a flat sea of constant NRCS; every fifth gate of one turn, and a slow scan for time.",
        expectation="Exponential intensities, ⟨I²⟩/⟨I⟩² = 2, to four standard errors over 50 blocks of a turn. In time "
        "exp(−(τ/τc)²) times what the turning beam leaves, to 0.05: some 1000 independent samples leave 0.03.",
        run=speckle,
    ),
    Case(
        name="doppler_of_what_moves",
        group="closed forms",
        title="What moves has its Doppler, and alternating pulses their bias",
        rationale="A sign here turns the correction of alternating pulses into a doubling of their error.",
        setup="A point 100 m away at six speeds, simulated; a flat sea that recedes at 1 m/s through the retrieval, "
        "receivers alternating every 100 µs, baseline 0.1 m.",
        expectation="−2v/λ to 0.5 Hz: the range to the point changes by 0.15 m at most while the beam passes. "
        "2vτR/(pB), 0.20 m at 100 m, too low by forward pairs (the upper antenna hears later), too high by backward "
        "ones, and nothing by both, to 5 mm.",
        run=doppler,
    ),
]
