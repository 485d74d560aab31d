"""Published values of the sea: dispersion, spectra, slopes; and the same sea by another library."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from seamap_rt.compute.locks import scratch_folder
from seamap_rt.io.spectrumfile import read_directional_spectrum
from seamap_rt.physics import dispersion
from seamap_rt.report import style
from seamap_rt.sea import spectra, spreading
from seamap_rt.sea.tabulated import TabulatedSpectrum

from ..report import Case, Check, Outcome
from ..report.checks import at_most, recorded, relative, within

Array = NDArray[np.float64]
GRAVITY, THEIR_GRAVITY = 9.81, 9.80665  # m/s², ours and that of wavespectra
INKS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE)

# ------------------------------------------------------------------------------------------------ waves and water

WAVENUMBERS = {
    np.inf: ((0.1019368, 5e-8), (0.4077472, 5e-8), (0.91743119, 5e-9)),
    20.0: ((0.10503601, 5e-9), (0.40774726, 5e-9), (0.91743119, 5e-9)),
}


def dispersion_table(full: bool) -> Outcome:
    """Wavenumbers of ω = 1, 2, 3 rad/s, the slowest ripple, and group speeds of 10 s of prediction."""
    checks = []
    for depth, printed in WAVENUMBERS.items():
        where = "deep" if np.isinf(depth) else f"{depth:g} m"
        for omega, (k, digit) in zip((1.0, 2.0, 3.0), printed, strict=True):
            computed = float(dispersion.wavenumber(omega, depth, surface_tension=0.0))
            checks.append(within(f"k at ω = {omega:g} rad/s, {where}", computed, k, 1.02 * digit, "rad/m"))
    k = np.linspace(300.0, 450.0, 150_001)
    speed = dispersion.angular_frequency(k) / k
    checks.append(within("wavenumber of the slowest wave", float(k[np.argmin(speed)]), 368.6, 0.06, "rad/m"))
    checks.append(within("its phase speed", float(speed.min()), 0.2307, 5e-5, "m/s"))
    for period, metres in ((4.0, 31.0), (6.0, 47.0), (8.0, 62.0), (10.0, 78.0)):
        own = float(dispersion.wavenumber(2.0 * np.pi / period))
        computed = 10.0 * float(dispersion.group_speed(own))
        checks.append(within(f"distance that a group of {period:g} s runs in 10 s", computed, metres, 0.5, "m"))
    return Outcome(tuple(checks))


def _height(spectrum: Array, omega: Array) -> float:
    return float(4.0 * np.sqrt(np.trapezoid(spectrum * omega, np.log(omega))))


def spectra_tables(full: bool) -> Outcome:
    """Pierson–Moskowitz' height, WAFO's Bretschneider values and TMA's factor."""
    omega = np.geomspace(1e-2, 2e3, 100_001)
    computed = _height(spectra.pierson_moskowitz(omega, wind_speed=10.0), omega)
    exact = 2.0 * (10.26**2 / GRAVITY) * np.sqrt(8.1e-3 / 0.74)  # 4√m0, m0 = α U⁴/(4 β g²)
    checks = [
        within("Pierson–Moskowitz, U10 = 10 m/s: Hs", computed, 2.245, 5e-4, "m"),
        relative("the same against 2 U² √(α/β)/g", computed, float(exact), 1e-6, "m"),
    ]
    wafo = (1.69350993, 0.06352698, 0.00844783)
    for rate, value in zip((1.0, 2.0, 3.0), wafo, strict=True):
        computed = float(spectra.pierson_moskowitz_scaled(rate, 6.5, 10.0))
        checks.append(within(f"Bretschneider 6.5 m, 10 s at ω = {rate:g} (WAFO)", computed, value, 5.1e-9, "m² s"))
    factor = float(spectra.tma_depth_factor(1.0, 5.0))
    checks.append(within("TMA: Φ at ω = 1, 5 m deep", factor, 0.252977, 5.1e-7))
    ratio = float(spectra.tma(1.0, 2.0, 8.0, 3.3, 5.0) / spectra.jonswap(1.0, 2.0, 8.0, 3.3))
    checks.append(within("TMA over its JONSWAP parent there", ratio, 0.252977, 5.1e-7))
    for gamma in (1.0, 3.3, 7.0):
        own = _height(spectra.jonswap(omega, 1.4, 5.5, gamma), omega)
        checks.append(relative(f"JONSWAP of 1.4 m, γ = {gamma:g}: Hs", own, 1.4, 1e-6, "m"))
    return Outcome(tuple(checks))


# ---------------------------------------------------------------------------------------------------------- slopes

ELFOUHAILY = {5.0: (0.648, 0.03167, 0.01894), 10.0: (2.634, 0.06047, 0.03560)}  # Hs, mss, its up-wind part
WINDS = (3.0, 5.0, 7.0, 10.0, 14.0)


def slopes(full: bool) -> Outcome:
    """Elfouhaily's moments against their values, and his slopes against those that Cox & Munk measured."""
    checks = []
    for wind, printed in ELFOUHAILY.items():
        computed = _moments(wind)
        for what, value, expected, digit in zip(
            ("Hs", "mss", "up-wind mss"), computed, printed, (5e-4, 5e-6, 6e-6), strict=True
        ):
            checks.append(within(f"U10 = {wind:g} m/s: {what}", value, expected, digit, "m" if what == "Hs" else ""))
    computed = np.array([_moments(wind)[1:] for wind in WINDS])
    measured = np.array([_cox_munk(wind)[:2] for wind in WINDS])
    for part, name in enumerate(("total", "up-wind")):
        off = np.abs(computed[:, part] - measured[:, part]) / (0.004 + 0.06 * measured[:, part])
        what = f"{name} mss off Cox & Munk's, 3–14 m/s, worst, over what both leave open"
        checks.append(at_most(what, float(off.max()), 1.0))
    caption = (
        "Mean square slopes by wind: Elfouhaily et al. (lines) and Cox & Munk's fits to sun glitter on clean water "
        "(dots; their scatter is 0.004). The bend at 6.5 m/s is the paper's own, where u* = cm."
    )
    return Outcome(tuple(checks), _draw_slopes(), caption)


def _moments(wind: float) -> tuple[float, float, float]:
    """Hs [m], mean square slope and its up-wind part."""
    k = np.geomspace(1e-3, 2e4, 20_001)
    density, contrast = spectra.elfouhaily97(k, wind), spectra.elfouhaily97_spreading(k, wind)

    def over(values: Array) -> float:
        return float(np.trapezoid(values * k, np.log(k)))

    return 4.0 * np.sqrt(over(density)), over(k**2 * density), over(k**2 * density * (0.5 + 0.25 * contrast))


def _cox_munk(wind: float) -> tuple[float, float, float]:
    """Total, up-wind and cross-wind mean square slope of clean water; wind at 12.5 m, 2 % above that at 10 m."""
    mast = 1.02 * wind
    return 0.003 + 0.00512 * mast, 0.00316 * mast, 0.003 + 0.00192 * mast


@style.styled
def _draw_slopes() -> Figure:
    figure = style.new_figure(2.5)
    axes = style.place(figure, 0.6, 0.3, 4.0, 1.75)
    winds = np.linspace(3.0, 14.0, 23)
    ours = np.array([_moments(float(wind)) for wind in winds])
    theirs = np.array([_cox_munk(float(wind)) for wind in winds])
    lines = (ours[:, 1], ours[:, 2], ours[:, 1] - ours[:, 2])
    for part, (line, name) in enumerate(zip(lines, ("total", "up-wind", "cross-wind"), strict=True)):
        axes.plot(winds, line, color=INKS[part], lw=0.9, label=name)
        axes.plot(winds[::2], theirs[::2, part], ".", color=INKS[part], ms=4)
    axes.legend(bbox_to_anchor=(1.02, 1.0), loc="upper left")
    style.graph(axes, "wind at 10 m [m/s]", "mean square slope", "Elfouhaily 1997 and Cox & Munk 1954")
    return figure


# ----------------------------------------------------------------------------------------------- another library

FREQUENCY = np.arange(0.02, 4.0, 0.0005)  # Hz, far and fine enough that sums and integrals agree
PERIOD = 8.0


def wavespectra_library(full: bool) -> Outcome:
    """Spectra, spreading and a file of the library wavespectra."""
    with warnings.catch_warnings():  # of readers that want packages which are not here, and of a sinh where Φ is 1
        warnings.filterwarnings("ignore", message="Cannot import function")
        warnings.filterwarnings("ignore", message="overflow encountered in sinh")
        import wavespectra.construct as library

        return Outcome(tuple(_by_another(library)))


def _by_another(library: Any) -> list[Check]:
    omega = 2.0 * np.pi * FREQUENCY
    made, checks = library.frequency, []

    def worst(theirs: Array, ours: Array) -> float:
        seen = ours > 1e-9 * ours.max()
        return float(np.max(np.abs(theirs[seen] / ours[seen] - 1.0)))

    for gamma in (1.0, 3.3, 7.0):
        theirs = made.jonswap(FREQUENCY, fp=1.0 / PERIOD, gamma=gamma, hs=2.0).to_numpy()
        ours = 2.0 * np.pi * spectra.jonswap(omega, 2.0, PERIOD, gamma)
        checks.append(at_most(f"JONSWAP, γ = {gamma:g}: worst density apart", worst(theirs, ours), 1e-8))
    peak = (0.8 * 0.74) ** 0.25 * GRAVITY / 10.26 / (2.0 * np.pi)  # 1.25 (fp/f)⁴ = β (g/Uω)⁴
    theirs = made.pierson_moskowitz(FREQUENCY, fp=peak, alpha=8.1e-3).to_numpy() * (GRAVITY / THEIR_GRAVITY) ** 2
    ours = 2.0 * np.pi * spectra.pierson_moskowitz(omega, wind_speed=10.0)
    checks.append(at_most("Pierson–Moskowitz of a wind: worst density apart", worst(theirs, ours), 1e-8))
    deep = made.jonswap(FREQUENCY, fp=1.0 / PERIOD).to_numpy()
    waves = FREQUENCY > 0.3 / PERIOD
    for depth in (8.0, 20.0):
        theirs = made.tma(FREQUENCY, fp=1.0 / PERIOD, dep=depth).to_numpy()
        ours = spectra.tma_depth_factor(omega, depth)
        off = float(np.max(np.abs(theirs[waves] / deep[waves] / ours[waves] - 1.0)))
        checks.append(at_most(f"TMA's factor, {depth:g} m deep: worst apart", off, 1e-3))
    direction = np.arange(0.0, 360.0, 1.0)
    for spread in (12.0, 25.0):
        theirs = library.direction.cartwright(direction, dm=300.0, dspr=spread).to_numpy()
        exponent = 2.0 / np.radians(spread) ** 2 - 1.0
        ours = spreading.cos2s(np.radians(direction - 300.0), exponent) * np.pi / 180.0
        checks.append(
            at_most(
                f"spreading of {spread:g}°: worst apart over its peak",
                float(np.max(np.abs(theirs - ours)) / ours.max()),
                2e-7,
            )
        )
    return checks + _through_a_file(library)


def _through_a_file(library: Any) -> list[Check]:
    """A sea of that library, written by it and read here."""
    frequency, direction = np.arange(0.03, 0.6, 0.005), np.arange(0.0, 360.0, 5.0)
    sea = library.construct_partition(
        freq_kwargs={"freq": frequency, "fp": 1.0 / PERIOD, "hs": 2.5},
        dir_kwargs={"dir": direction, "dm": 285.0, "dspr": 25.0},
    ).to_dataset(name="efth")
    with scratch_folder() as folder:
        sea.to_netcdf(folder / "theirs.nc", engine="h5netcdf")
        table = read_directional_spectrum(folder / "theirs.nc")
    ours = TabulatedSpectrum(table.frequency_hz, table.from_deg, table.density)
    circle = np.radians(np.arange(0.0, 360.0, 0.1))
    going = np.sum(ours.spreading(np.array(0.06), np.cos(circle), np.sin(circle)) * np.exp(1j * circle))
    coming_from = float((270.0 - np.degrees(np.angle(going))) % 360.0)
    return [
        relative("a file of theirs: Hs", ours.hs, float(sea.spec.hs()), 2e-4, "m"),
        within(
            "a file of theirs: peak frequency", ours.peak_frequency_hz, float(sea.spec.fp(smooth=False)), 1e-6, "Hz"
        ),
        within("a file of theirs: direction it comes from", coming_from, float(sea.spec.dm()), 1e-3, "°"),
        recorded("the same, as asked of them", "285°"),
    ]


CASES = [
    Case(
        name="dispersion_table",
        group="outside tables",
        title="Dispersion: printed wavenumbers, ripples and groups",
        rationale="Wave lengths, speeds and predictability all follow from it; tanh must keep its digits at both ends.",
        setup="ω = 1, 2, 3 rad/s without surface tension, deep and in 20 m; the slowest ripple; groups of 4–10 s.",
        expectation="The printed digits, half a unit of the last; 368.6 rad/m and 0.2307 m/s; 31, 47, 62 and 78 m in "
        "10 s (Naaijen et al. 2014).",
        run=dispersion_table,
    ),
    Case(
        name="spectra_tables",
        group="outside tables",
        title="Spectra: Pierson–Moskowitz, Bretschneider, TMA, JONSWAP",
        rationale="A constant of the spectrum that is off by a per cent moves every height of every scene.",
        setup="Hs of a wind; three values of the WAFO toolbox's own Bretschneider; TMA's factor; JONSWAP's own height.",
        expectation="Printed values to half a unit of their last digit; integrals to 1e-6, which sums leave.",
        run=spectra_tables,
    ),
    Case(
        name="slopes_of_the_sea",
        group="outside tables",
        title="Elfouhaily's heights and slopes, and Cox & Munk's",
        rationale="Short waves carry the slopes that scatter; public codes differ by traps in a0 and γ.",
        setup="Elfouhaily et al. (1997), fully developed, waves of 0.3 mm to 6 km; Cox & Munk's fits for clean water.",
        expectation="Values worked out independently from the paper's formulas, to their last digit. Cox & Munk to "
        "0.004 and 6 %: the scatter of their fits, and what variants of the spectrum move the slopes by.",
        run=slopes,
    ),
    Case(
        name="wavespectra_library",
        group="outside tables",
        title="The same sea by the library wavespectra",
        rationale="Code by other hands, with other conventions of direction, units and gravity.",
        setup="JONSWAP, Pierson–Moskowitz, TMA, cos^2s, and a file that wavespectra writes and seamap_rt reads.",
        expectation="1e-8 where both are the same formula (sums against integrals); TMA to 1e-3, their wavenumber "
        "being a rational approximation; the file's height to 2e-4, rectangles against trapezoids.",
        run=wavespectra_library,
    ),
]
