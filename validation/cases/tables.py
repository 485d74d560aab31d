"""Published values: sea clutter, sea water, and the statistics on which other cases rest."""

from __future__ import annotations

import csv

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from seamap_rt import scattering
from seamap_rt.conventions import SPEED_OF_LIGHT, db
from seamap_rt.report import style

from .. import REFERENCE, analytic
from ..report import Case, Check, Outcome
from ..report.checks import at_least, at_most, recorded, relative, within

Array = NDArray[np.float64]
TABLE = REFERENCE / "nathanson_9p3ghz.csv"
STATES = (1, 2, 3, 4, 5)
INKS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE, style.ORANGE)

# -------------------------------------------------------------------------------------------------------- clutter


def nathanson() -> dict[str, tuple[Array, Array]]:
    """Grazing angles [°] and levels [dB] (angle, sea state 1–5) by polarization."""
    lines = [line for line in TABLE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    table = {}
    for polarization in ("HH", "VV"):
        own = [row for row in rows if row["polarization"] == polarization]
        levels = np.array([[float(row[f"ss{state}"]) for state in STATES] for row in own])
        table[polarization] = (np.array([float(row["grazing_deg"]) for row in own]), levels)
    return table


def nrl_clutter(full: bool) -> Outcome:
    """The NRL's formula by hand, and its published distance from Nathanson's measured table."""
    nrl, measured = scattering.nrcs_gregers_hansen12, nathanson()
    value = float(nrl(10.0, 2.0, 30e9, "HH"))
    by_hand = -50.796 + 25.93 * np.log10(np.sin(np.radians(3.0))) + (27.5 + 3.0 * 0.7093) * 1.0 / 3.85
    by_hand += 21.588 * 4.0 ** (1.0 / (2.0 + 0.255 + 0.099)) + 0.00211 * 9.0
    checks = [
        relative("sea state 2, 10°, 30 GHz, HH", value, 2.15550e-4, 1e-5),
        within("sea state 3, 3°, 10 GHz, VV, term by term", float(db(nrl(3.0, 3.0, 10e9, "VV"))), by_hand, 1e-6, "dB"),
    ]
    for polarization, published in (("HH", 2.5), ("VV", 2.0)):
        angles, levels = measured[polarization]
        off = db(nrl(angles[:, None], np.array(STATES), 9.3e9, polarization)) - levels
        what = f"mean absolute deviation from Nathanson, {polarization}, 0.1–10°, sea states 1–5"
        checks.append(within(what, float(np.mean(np.abs(off))), published, 0.05, "dB"))
        checks.append(at_least(f"lowest of them, {polarization}", float(off.min()), -5.65, "dB"))
    caption = (
        "NRL 2012 at 9.3 GHz (lines) and Nathanson's measured table (dots), mean over wind directions, at sea states "
        "1, 3 and 5, from below."
    )
    return Outcome(tuple(checks), _draw_clutter(measured), caption)


@style.styled
def _draw_clutter(measured: dict[str, tuple[Array, Array]]) -> Figure:
    figure = style.new_figure(2.7)
    fine = np.geomspace(0.1, 60.0, 200)
    for column, (polarization, (angles, levels)) in enumerate(measured.items()):
        axes = style.place(figure, 0.55 + 3.55 * column, 0.3, 2.9, 1.95)
        for state, ink in zip((1, 3, 5), INKS, strict=False):
            axes.semilogx(
                fine, db(scattering.nrcs_gregers_hansen12(fine, state, 9.3e9, polarization)), color=ink, lw=0.9
            )
            axes.semilogx(angles, levels[:, state - 1], ".", color=ink, ms=5, label=f"sea state {state}")
        axes.legend(loc="lower right")
        style.graph(axes, "grazing angle [°]", "σ0 [dB]", polarization)
    return figure


def git_clutter(full: bool) -> Outcome:
    """Horst, Dyer & Tuley's formula, written out here, and its deviation from Nathanson's table."""
    grazing, states = np.array([0.3, 1.0, 3.0, 10.0]), np.array([1.0, 3.0, 5.0])
    looks = {"upwind": 0.0, "across": 0.5 * np.pi, "downwind": np.pi}
    worst = 0.0
    for angle in looks.values():
        for polarization in ("HH", "VV"):
            computed = scattering.nrcs_horst78(grazing[:, None], states, 9.3e9, polarization, wind_angle=angle)
            tabulated = _git(grazing[:, None], states, angle, polarization)
            worst = max(worst, float(np.max(np.abs(db(computed) - tabulated))))
    checks = [at_most("formula at 4 angles, 3 sea states, 3 looks, HH and VV, worst", worst, 1e-6, "dB")]
    for polarization, (angles, levels) in nathanson().items():
        off = db(scattering.nrcs_horst78(angles[1:, None], np.array(STATES), 9.3e9, polarization)) - levels[1:]
        words = f"{np.mean(np.abs(off)):.1f} dB; lowest {off.min():+.1f} dB"
        checks.append(recorded(f"mean absolute deviation from Nathanson, {polarization}, 0.3–10°", words))
    wind = float(scattering.wind_from_sea_state(3.0))
    checks.append(relative("wind of sea state 3, 3.16 · 3^0.8", wind, 3.16 * 3.0**0.8, 1e-12, "m/s"))
    return Outcome(tuple(checks))


def _git(grazing: Array, state: Array, angle: float, polarization: str) -> Array:
    """σ0 [dB] of the paper below 10 GHz."""
    psi, wavelength, wind = np.radians(grazing), SPEED_OF_LIGHT / 9.3e9, 3.16 * state**0.8
    height = 4.52e-3 * wind**2.5
    rough = (14.4 * wavelength + 5.5) * psi * height / wavelength
    interference = rough**4 / (1.0 + rough**4)
    upwind = np.exp(0.2 * np.cos(angle) * (1.0 - 2.8 * psi) * (wavelength + 0.015) ** -0.4)
    speed = (1.94 * wind / (1.0 + wind / 15.4)) ** (1.1 * (wavelength + 0.015) ** -0.4)
    hh = 10.0 * np.log10(3.9e-6 * wavelength * psi**0.4 * interference * upwind * speed)
    if polarization == "HH":
        return hh
    mixed = -1.05 * np.log(height + 0.015) + 1.09 * np.log(wavelength) + 1.27 * np.log(psi + 1e-4) + 9.70
    return hh + mixed


# ------------------------------------------------------------------------------------------------------ sea water

WATER = {
    "klein_swift77": (55.85, 37.71),
    "meissner_wentz04": (55.94, 37.00),
    "meissner_wentz12": (55.06, 37.51),
}
REFLECTED = {1.0: (0.9959, 0.7591), 5.7: (0.9769, 0.1798)}
BRAGG = {1.0: (0.99590, 102.255), 45.0: (0.84684, 2.16935)}


def sea_water(full: bool) -> Outcome:
    """Permittivity by three models, reflection and Bragg coefficients by the newest."""
    checks: list[Check] = []
    for name, (real, loss) in WATER.items():
        computed = complex(scattering.PERMITTIVITIES[name](10e9, 20.0, 35.0))
        checks.append(within(f"{name}: ε′ at 10 GHz, 20 °C, 35 psu", computed.real, real, 0.005))
        checks.append(within(f"{name}: ε″", -computed.imag, loss, 0.005))
    water = complex(scattering.permittivity_meissner_wentz12(10e9, 20.0, 35.0))
    for grazing, (level, upright) in REFLECTED.items():
        computed = scattering.fresnel(np.radians(90.0 - grazing), water)
        checks.append(within(f"|R_h| at {grazing:g}°", abs(complex(computed[0])), level, 5e-5))
        checks.append(within(f"|R_v| at {grazing:g}°", abs(complex(computed[1])), upright, 5e-5))
    for grazing, (level, upright) in BRAGG.items():
        computed = scattering.bragg_coefficients(np.radians(90.0 - grazing), water)
        checks.append(relative(f"|g_HH| at {grazing:g}°", abs(complex(computed[0])), level, 6e-6))
        checks.append(relative(f"|g_VV| at {grazing:g}°", abs(complex(computed[1])), upright, 6e-6))
    return Outcome(tuple(checks))


# ----------------------------------------------------------------------------------------------------- statistics

LEE = {(0.99, 1): 0.2634, (0.99, 4): 0.0583, (0.5, 1): 1.3361, (0.5, 10): 0.4731}
SHADOWS = {0.1: (0.166083, 0.214182), 0.5: (0.633731, 0.689169), 1.0: (0.898767, 0.909871)}
SINUSOIDS = {0.1: 0.814343, 0.5: 0.524130, 0.9: 0.216875, 2.0 / np.sqrt(np.pi**2 + 4.0): 0.5}


def lee_table(full: bool) -> Outcome:
    """Standard deviations of Lee et al. (1994), and how far the Cramér–Rao bound is from them."""
    checks = [
        within(
            f"coherence {coherence:g}, {looks} look{'s' if looks > 1 else ''}",
            float(analytic.phase_std_lee94(coherence, looks)),
            std,
            5e-5,
            "rad",
        )
        for (coherence, looks), std in LEE.items()
    ]
    ratio = float(analytic.phase_std_lee94(0.99, 1) / analytic.cramer_rao_phase_std(0.99, 1))
    return Outcome((*checks, within("over the Cramér–Rao bound at coherence 0.99, one look", ratio, 2.6, 0.05)))


def shadow_tables(full: bool) -> Outcome:
    """Smith's and Wagner's functions, where they are one half, and a sinusoid under parallel rays."""
    checks = []
    for v, (smith, wagner) in SHADOWS.items():
        checks.append(within(f"Smith at v = {v:g}", float(analytic.shadowing_smith67(v)), smith, 6e-7))
        checks.append(within(f"Wagner at v = {v:g}", float(analytic.shadowing_wagner67(v)), wagner, 6e-7))
    checks.append(within("Smith at v = 0.357835", float(analytic.shadowing_smith67(0.357835)), 0.5, 1e-6))
    checks.append(within("Wagner at v = 0.284432", float(analytic.shadowing_wagner67(0.284432)), 0.5, 1e-6))
    for m, share in SINUSOIDS.items():
        computed = float(analytic.sinusoid_shadowed_fraction(m))
        checks.append(within(f"shadowed share of a sinusoid at m = {m:.6g}", computed, share, 5e-7))
    return Outcome(tuple(checks))


CASES = [
    Case(
        name="nrl_sea_clutter",
        group="outside tables",
        title="NRL 2012 and Nathanson's table",
        rationale="The mean echo of a run is calibrated to this model: its constants decide the range of the radar.",
        setup="Gregers-Hansen & Mittal (2012) against values by hand and against Nathanson's table (1991), in "
        "validation/reference.",
        expectation="By hand to the printed digits. Mean absolute deviation from the table 2.5 dB in HH and 2.0 dB in "
        "VV, the worst −5.6 dB: the paper's own, half a unit of the last digit.",
        run=nrl_clutter,
    ),
    Case(
        name="git_sea_clutter",
        group="outside tables",
        title="Georgia Tech's clutter formula",
        rationale="A second model of the mean, which knows wind direction and interference near grazing.",
        setup="Horst, Dyer & Tuley (1978) at 9.3 GHz, written out a second time here, over angle, sea state and look.",
        expectation="Two transcriptions of one formula agree to rounding. Its distance from the measured table is for "
        "the record: at low grazing it falls tens of dB below.",
        run=git_clutter,
    ),
    Case(
        name="sea_water",
        group="outside tables",
        title="Sea water reflects as published",
        rationale="Polarization at grazing is all in these numbers; a wrong sign of the loss still looks plausible.",
        setup="Klein & Swift (1977), Meissner & Wentz (2004, 2012) at 10 GHz, 20 °C, 35 psu; reflection and first-"
        "order Bragg coefficients at grazing.",
        expectation="The printed values, half a unit of their last digit.",
        run=sea_water,
    ),
    Case(
        name="lee_table",
        group="outside tables",
        title="Standard deviations of Lee et al. (1994)",
        rationale="This formula judges the phases of every other case; so it is judged first.",
        setup="analytic.phase_std_lee94 at low and high coherence, few and many looks.",
        expectation="Published values to half a unit of their last digit; the Cramér–Rao bound is 2.6 times too small "
        "at one look and coherence 0.99.",
        run=lee_table,
    ),
    Case(
        name="shadow_tables",
        group="outside tables",
        title="Smith's and Wagner's functions and the sinusoid's shadow",
        rationale="These judge light and shadow in every other case.",
        setup="Smith (1967), Wagner (1967) and the tangent construction under parallel rays.",
        expectation="Values worked out independently, to half a unit of their last digit.",
        run=shadow_tables,
    ),
]
