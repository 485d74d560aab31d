"""Closed forms of the water: where a drawn sea's energy lies in space and time, and how much there is."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from seamap_rt.report import style
from seamap_rt.sea import Sea, realize
from seamap_rt.settings import ElfouhailyWaves, JonswapWaves, SeaSettings, TmaWaves

from ..report import Case, Outcome
from ..report.checks import at_most, recorded, relative, within

Array = NDArray[np.float64]
GRAVITY, TENSION = 9.81, 0.074 / 1025.0
INKS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE)

# ----------------------------------------------------------------------------------------------------- dispersion

EXTENT_M, SIDE, DURATION_S, TIMES = 256.0, 64, 60.0, 192
JONSWAP = JonswapWaves(
    spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5, wave_from_deg=250.0, spreading_exponent=10.0
)


def omega_of(k: Array, depth: float) -> Array:
    """ω of gravity–capillary waves, written out here."""
    bottom = 1.0 if np.isinf(depth) else np.tanh(np.minimum(k * depth, 300.0))
    return np.sqrt((GRAVITY * k + TENSION * k**3) * bottom)


def dispersion(full: bool) -> Outcome:
    """The transform of a drawn sea in x, y and t: all energy at ω(k) + k·U, on the side to which the sea runs."""
    seas = {
        "deep water": SeaSettings(resolution_m=4.0, extent_m=EXTENT_M, waves=(JONSWAP,)),
        "5 m deep": SeaSettings(resolution_m=4.0, extent_m=EXTENT_M, waves=(JONSWAP,), depth_m=5.0),
        "current of 1.5 m/s along": SeaSettings(
            resolution_m=4.0, extent_m=EXTENT_M, waves=(JONSWAP,), current_m_s=1.5, current_toward_deg=70.0
        ),
    }
    checks, pictures = [], {}
    for name, settings in seas.items():
        sea = realize(settings, 2)
        along = np.radians(settings.current_toward_deg)
        current = settings.current_m_s * np.sin(along), settings.current_m_s * np.cos(along)  # east, north
        near, forward, picture = _shares_on_the_curve(sea, settings.depth_m, current)
        checks.append(at_most(f"{name}: energy off the curve", 100.0 * (1.0 - near), 1.0, "%"))
        checks.append(
            at_most(f"{name}: of what is on it, energy that runs against the sea", 100.0 * (1.0 - forward), 3.0, "%")
        )
        pictures[name] = (picture, settings)
    caption = (
        "Energy of the records by wave number and frequency, waves within 15° of the sea's direction, 30 dB deep; "
        "lines: the dispersion relation. 60 s resolve 0.1 rad/s."
    )
    return Outcome(tuple(checks), _draw_dispersion(pictures), caption)


def _shares_on_the_curve(sea: Sea, depth: float, current: tuple[float, float]) -> tuple[float, float, Array]:
    """Shares of the energy near the curve, moved by a current [m/s] east and north, and of that forward; and the energy
    (ω > 0, k along x > 0) summed over y."""
    t = DURATION_S * np.arange(TIMES) / TIMES
    positions = EXTENT_M * np.arange(SIDE) / SIDE
    record = sea.elevation(positions[None, :, None], positions[:, None, None], t) * np.hanning(TIMES)
    power = np.abs(np.fft.fftn(record)) ** 2  # exp(i(k·x − ωt)) lies at +k and −ω
    k = 2.0 * np.pi * np.fft.fftfreq(SIDE, EXTENT_M / SIDE)
    omega = -2.0 * np.pi * np.fft.fftfreq(TIMES, DURATION_S / TIMES)
    north, east = k[:, None], k[None, :]
    carried = current[0] * east + current[1] * north
    own = omega_of(np.hypot(north, east), depth)
    width = 2.5 * 2.0 * np.pi / DURATION_S  # the window's main lobe is two bins to either side
    ahead = np.abs(omega - (own + carried)[..., None]) < width
    near = ahead | (np.abs(omega - (carried - own)[..., None]) < width)
    toward = np.radians(250.0 - 180.0)
    ahead_of = (np.sin(toward) * east + np.cos(toward) * north) / np.maximum(np.hypot(north, east), 1e-9)
    forward = power[ahead & (ahead_of > 0.0)[..., None]].sum() / power[near & (ahead_of > 0.0)[..., None]].sum()
    return (
        float(power[near].sum() / power.sum()),
        float(forward),
        _annuli(power, np.hypot(north, east), ahead_of, omega),
    )


def _annuli(power: Array, k: Array, ahead_of: Array, omega: NDArray[Any]) -> Array:
    """Energy (k, ω) of the waves within 15° of the sea's direction, by steps of both."""
    number = np.rint(k / (2.0 * np.pi / EXTENT_M)).astype(int)
    chosen = ahead_of > np.cos(np.radians(15.0))
    energy = np.zeros((SIDE // 2, TIMES))
    np.add.at(energy, np.minimum(number[chosen], SIDE // 2 - 1), power[chosen])
    return energy[:-1, omega > 0.0][:, np.argsort(omega[omega > 0.0])]


@style.styled
def _draw_dispersion(pictures: dict) -> Figure:
    figure = style.new_figure(2.6)
    step, rate = 2.0 * np.pi / EXTENT_M, 2.0 * np.pi / DURATION_S
    for column, (name, (power, settings)) in enumerate(pictures.items()):
        axes = style.place(figure, 0.55 + 2.3 * column, 0.35, 1.95, 1.8)
        level = 10.0 * np.log10(power.T / power.max() + 1e-12)
        where = (-0.5 * step, (power.shape[0] - 0.5) * step, 0.5 * rate, (power.shape[1] + 0.5) * rate)
        options = {"vmin": -30.0, "vmax": 0.0, "cmap": style.colours(style.COUNT_COLOURS), "aspect": "auto"}
        axes.imshow(np.ma.masked_less(level, -30.0), extent=where, origin="lower", **options)
        k = np.linspace(step, 0.6, 200)
        axes.plot(k, omega_of(k, settings.depth_m) + settings.current_m_s * k, color=style.VERMILION, lw=0.9)
        axes.set_xlim(0.0, 0.6)
        axes.set_ylim(0.0, 4.0)
        style.graph(axes, "k [rad/m]", "ω [rad/s]" if column == 0 else "", name)
        axes.grid(False)
    return figure


# ------------------------------------------------------------------------------------------------------- variance

SURFACES = 20  # seas whose surface is drawn; of others the sum over their waves tells as much
SPECTRA = {
    "jonswap": (JONSWAP, np.inf),
    "tma, 6 m deep": (TmaWaves(spectrum="tma", significant_wave_height_m=1.0, peak_period_s=5.5), 6.0),
    "elfouhaily, 7 m/s": (ElfouhailyWaves(spectrum="elfouhaily", wind_speed_m_s=7.0), np.inf),
}


def variance(full: bool) -> Outcome:
    """Mean square of each surface against the sum over its own waves, and of many such sums against the spectrum."""
    checks, drawn = [], {}
    seeds = 300 if full else SURFACES
    for number, (name, (waves, depth)) in enumerate(SPECTRA.items()):
        settings = SeaSettings(resolution_m=4.0, extent_m=EXTENT_M, waves=(waves,), depth_m=depth)
        seas = (realize(settings, seed) for seed in range(1000 * number, 1000 * number + seeds))
        own, apart, expected = [], 0.0, np.nan
        for sea in seas:
            own.append(_of_its_waves(sea))
            expected = sea.resolved.variance
            if len(own) <= SURFACES:
                positions = EXTENT_M * np.arange(SIDE) / SIDE
                surface = sea.elevation(positions[None, :], positions[:, None], 0.0)
                apart = max(apart, abs(float(np.mean(surface**2)) / own[-1] - 1.0))
        what = f"{name}: patch's mean square against its own waves' sum, worst of {SURFACES} seas"
        checks.append(at_most(what, apart, 2e-3))
        error = float(np.std(own, ddof=1) / np.sqrt(seeds))
        what = f"{name}: mean over {seeds} seas over the spectrum's resolved variance"
        checks.append(within(what, float(np.mean(own)) / expected, 1.0, 4.0 * error / expected))
        drawn[name] = (np.array(own), expected)
    for spacing in (1.0, 2.0, 4.0):
        share = realize(
            SeaSettings(resolution_m=spacing, extent_m=EXTENT_M, waves=(JONSWAP,)), 1
        ).resolved.variance_share
        checks.append(
            relative(f"jonswap: share of the variance resolved at {spacing:g} m", share, _below(spacing), 1e-4)
        )
    ratio = np.mean([np.std(each) / level for each, level in drawn.values()])
    checks.append(
        recorded("scatter of a patch's variance from sea to sea, mean of the spectra", f"{100.0 * ratio:.0f} %")
    )
    caption = (
        "Significant height 4√m0 of single patches of 256 m, sea by sea, and that of the resolved spectrum (line): how "
        "far one realisation may be from its spectrum."
    )
    return Outcome(tuple(checks), _draw_variance(drawn), caption)


def _of_its_waves(sea: Sea) -> float:
    """Mean square over the patch by Parseval: Σ|F|² of the lattice's coefficients at t = 0, waves that meet added."""
    waves, step = sea.components(), 2.0 * np.pi / EXTENT_M
    east, north = (np.rint(each / step).astype(int) for each in (waves.east, waves.north))
    side = 2 * int(max(np.abs(east).max(), np.abs(north).max())) + 1
    coefficient = np.zeros((side, side), dtype=np.complex128)
    np.add.at(coefficient, (north, east), 0.5 * waves.amplitude)
    np.add.at(coefficient, (-north, -east), 0.5 * waves.amplitude.conj())
    return float(np.sum(np.abs(coefficient) ** 2))


def _below(spacing: float) -> float:
    """Share of JONSWAP's variance in waves longer than two spacings, by the paper's formula."""
    peak = 2.0 * np.pi / JONSWAP.peak_period_s  # pyright: ignore[reportOperatorIssue]
    omega = np.geomspace(0.3 * peak, 300.0 * peak, 200_001)
    ratio = omega / peak
    width = np.where(ratio <= 1.0, 0.07, 0.09)
    shape = ratio**-5 * np.exp(-1.25 * ratio**-4) * 3.3 ** np.exp(-0.5 * ((ratio - 1.0) / width) ** 2) * omega
    limit = float(omega_of(np.array(np.pi / spacing), np.inf))
    inside = np.append(omega[omega < limit], limit)
    part = np.append(shape[omega < limit], np.interp(limit, omega, shape))
    return float(np.trapezoid(part, np.log(inside)) / np.trapezoid(shape, np.log(omega)))


@style.styled
def _draw_variance(drawn: dict[str, tuple[Array, float]]) -> Figure:
    figure = style.new_figure(2.4)
    axes = style.place(figure, 0.55, 0.3, 4.8, 1.65)
    for (name, (realised, level)), ink in zip(drawn.items(), INKS, strict=False):
        axes.plot(4.0 * np.sqrt(realised), ".", color=ink, ms=5, label=name)
        axes.axhline(4.0 * np.sqrt(level), color=ink, lw=0.9)
    axes.set_ylim(0.0)
    axes.legend(bbox_to_anchor=(1.02, 1.0), loc="upper left")
    style.graph(axes, "sea", "4√m0 of the patch [m]", "Heights of single realisations")
    return figure


CASES = [
    Case(
        name="dispersion_of_the_sea",
        group="closed forms",
        title="The sea moves by its dispersion relation",
        rationale="Currents, depths and waves to come are read off this curve; a wrong sign runs the sea backwards.",
        setup="JONSWAP seas of 5.5 s, 256 m by 256 m by 60 s: deep, 5 m deep, and on a current.",
        expectation="ω² = (gk + Tk³/ρ) tanh kh, moved by k·U: 99 % of the energy within two and a half bins of it, "
        "the window's main lobe. Of cos^2s(θ/2), s = 10, some thousandths run against the sea; 3 % allows for one "
        "sea's chance.",
        run=dispersion,
    ),
    Case(
        name="variance_of_the_sea",
        group="closed forms",
        title="A sea's variance is its spectrum's integral",
        rationale="A surface whose height depended on its grid would make every error relative to Hs meaningless.",
        setup="Patches of 256 m, three spectra, many seeds; the JONSWAP sea at three resolutions.",
        expectation="Parseval over each patch's own waves to 0.2 % (interpolation costs 1e-3 of an amplitude); means "
        "over seas meet the spectrum within four standard errors; resolved shares meet the formula's own integral to "
        "1e-4.",
        run=variance,
    ),
]
