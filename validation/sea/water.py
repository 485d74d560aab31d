"""The water compared with published values, and figures of its behaviour.

    python -m validation.sea.water [--seeds 8] [--out validation/figures]

Prints published values beside this package's, and the effect of first-order Lagrangian waves on the spectrum's tail.
Draws

  sea_dispersion.png   wavenumber–frequency spectra of 60 s of sea, deep and 5 m deep, without and with a current
  sea_spectra.png      all spectra as saturation k³ S(k) from swell to ripples, and the spreadings
  sea_choppy.png       linear and choppy waves: profile, elevations, spectrum over the ground
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from seamap_rt.physics.dispersion import angular_frequency, wavenumber
from seamap_rt.report.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    SPREAD_COLOURS,
    VERMILION,
    graph,
    new_figure,
    place,
    png,
    styled,
)
from seamap_rt.sea import Sea, realize, spectral_system, spreading
from seamap_rt.sea.spectra import elfouhaily97_contrast
from seamap_rt.settings import ElfouhailyWaves, JonswapWaves, PiersonMoskowitzWaves, RandomWaves, SeaSettings, TmaWaves

from .. import FIGURES
from ..options import options

LIMIT = np.pi / 0.8  # rad/m, the default resolution's: beyond it the waves are the scattering's
LOG_K = np.linspace(np.log(1e-3), np.log(2e4), 20_001)
WIND_SEA = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5)
PM = PiersonMoskowitzWaves(spectrum="pierson_moskowitz", significant_wave_height_m=1.4, peak_period_s=5.5)
TMA = TmaWaves(spectrum="tma", significant_wave_height_m=1.4, peak_period_s=5.5)
YOUNG = JonswapWaves(spectrum="jonswap", wind_speed_m_s=8.0, fetch_m=1e5)
STEEP = JonswapWaves(spectrum="jonswap", significant_wave_height_m=2.4, peak_period_s=5.0)  # Hs/length 0.06
STEEP_PEAK = float(wavenumber(2.0 * np.pi / 5.0))
STEEP_EXTENT, STEEP_RESOLUTION, STEEP_SIDE = 256.0, 1.0, 768


# --------------------------------------------------------------------------------------------------------- dispersion


@styled
def draw_dispersion() -> Figure:
    """Energy over k and f of waves that run along the cut: averaged over the crests, only those are left."""
    figure = new_figure(6.15)
    cases = ((np.inf, 0.0), (np.inf, 1.5), (5.0, 0.0), (5.0, -1.5))
    images = []
    for number, (depth, current) in enumerate(cases):
        axes = place(figure, 0.5 + 3.3 * (number % 2), 0.35 + 2.75 * (number // 2), 2.7, 2.0)
        where = "deep water" if np.isinf(depth) else f"{depth:g} m of water"
        flow = "no current" if current == 0.0 else f"{abs(current):g} m/s {'with' if current > 0 else 'against'} them"
        graph(axes, "wavenumber along the waves, rad/m", "frequency, Hz", f"{'abcd'[number]}) {where}, {flow}")
        k, frequency, power = travelling_spectrum(depth, current)
        shown = np.maximum(power / power.max(), 1e-9)
        colours = {"norm": LogNorm(1e-6, 1.0), "cmap": SPREAD_COLOURS}
        images.append(axes.pcolormesh(k, frequency, shown, shading="nearest", rasterized=True, **colours))
        curve = np.linspace(0.0, k.max(), 300)
        for side in (1.0, -1.0):
            line = (angular_frequency(curve, depth) + side * curve * current) / (2.0 * np.pi)
            axes.plot(side * curve, line, color="white", linestyle="--", linewidth=0.8)
        still = angular_frequency(curve, depth) / (2.0 * np.pi)
        if current:
            axes.plot(curve, still, color=ORANGE, linestyle=":", linewidth=1.1)
        axes.set_xlim(-1.0, 1.0)
        axes.set_xticks([-1.0, -0.5, 0.0, 0.5, 1.0])
        axes.set_ylim(0.0, 0.8)
        axes.grid(False)
    bar = figure.colorbar(images[0], cax=place(figure, 0.5, 5.55, 6.0, 0.1), orientation="horizontal")
    bar.set_label(
        "energy over its maximum; dashed: ω(k) + k·U, dotted: ω(k) without the current; k > 0 runs with the waves"
    )
    return figure


def travelling_spectrum(
    depth: float, current: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """k [rad/m], f ≥ 0 [Hz] and energy (f, k) of 60 s of a wind sea from the west, of waves without a part across."""
    side, count, duration, extent = 128, 240, 60.0, 384.0
    settings = SeaSettings(
        depth_m=depth,
        resolution_m=3.0,
        extent_m=extent,
        waves=(WIND_SEA,),
        current_m_s=abs(current),
        current_toward_deg=90.0 if current >= 0.0 else 270.0,
    )
    sea = realize(settings, 1)
    t, positions = duration * np.arange(count) / count, extent * np.arange(side) / side
    cut = np.stack([sea.elevation(positions, positions[:, None], time).mean(axis=0) for time in t])
    power = np.abs(np.fft.fft2(cut * np.hanning(count)[:, None])) ** 2
    # exp(i(kx − ωt)) lies at +k and −ω: of the real field's two halves, the one with f ≥ 0.
    frequency = np.arange(count // 2) / duration
    wrapped = power[-np.arange(count // 2)]
    k = np.asarray(2.0 * np.pi / extent * np.arange(-side // 2, side // 2), dtype=np.float64)
    return k, frequency, np.fft.fftshift(wrapped, axes=1)


# ------------------------------------------------------------------------------------------------------------ spectra


@styled
def draw_spectra() -> Figure:
    """Saturation of all spectra, and the spreadings at three frequencies."""
    figure = new_figure(6.4)
    draw_saturation(figure)
    for number, ratio in enumerate((0.7, 1.0, 2.0)):
        axes = place(figure, 0.4 + 2.3 * number, 4.35, 1.8, 1.8, projection="polar")
        angle = np.linspace(-np.pi, np.pi, 721)
        for name, colour, density in spreadings_at(ratio, angle):
            axes.plot(angle, density, color=colour, linewidth=1.1, label=name)
        axes.set_title(f"f/fp = {ratio:g}", loc="center", pad=6.0)
        axes.set_xticks(np.radians([0, 90, 180, 270]), ["0°", "90°", "180°", "−90°"])
        axes.set_yticks([0.5, 1.0], ["0.5", "1"], color=GREY)
        axes.set_rlabel_position(135.0)  # pyright: ignore
        axes.set_ylim(0.0, 1.2)  # pyright: ignore
        axes.grid(True, color="#dcdcdc", linewidth=0.5)
        axes.tick_params(pad=-1.0)
        if number == 2:
            axes.legend(loc="center left", bbox_to_anchor=(0.2, 1.75), title="spreadings of b", alignment="left")
    figure.text(0.55 / 7.2, 1.0 - 3.85 / 6.4, "b) spreadings, 1/rad, of a fully developed sea (U10/cp = 0.84; s = 10)")
    return figure


def draw_saturation(figure: Figure) -> None:
    axes = place(figure, 0.55, 0.3, 4.3, 2.85)
    graph(axes, "wavenumber k, rad/m", "saturation k³ S(k)", "a) spectra; at Hs 1.4 m, Tp 5.5 s or by the wind")
    k = np.geomspace(1e-3, 1e4, 2000)
    lines: list[tuple[str, RandomWaves, float, str, str]] = [
        ("Pierson–Moskowitz", PM, np.inf, BLACK, "-"),
        ("JONSWAP, γ = 3.3", WIND_SEA, np.inf, ORANGE, "-"),
        ("TMA, 5 m of water", TMA, 5.0, VERMILION, "--"),
        ("JONSWAP, 8 m/s, 100 km", YOUNG, np.inf, PURPLE, "-"),
        *(
            (f"Elfouhaily, {wind:g} m/s", ElfouhailyWaves(spectrum="elfouhaily", wind_speed_m_s=wind), np.inf, c, "-")
            for wind, c in ((3.0, SKY), (8.0, BLUE), (15.0, GREEN))
        ),
    ]
    for name, waves, depth, colour, style in lines:
        saturation = k**3 * spectral_system(waves, depth).radial(k)
        axes.loglog(k, np.where(saturation > 0.0, saturation, np.nan), color=colour, linestyle=style, label=name)
    axes.axvspan(LIMIT, 1e4, color=GREY, alpha=0.12, linewidth=0.0)
    axes.axvline(LIMIT, color=GREY, linewidth=1.0)
    axes.set_xlim(1e-3, 1e4)
    axes.set_ylim(1e-5, 0.3)
    axes.text(LIMIT / 1.2, 0.18, "mesh (0.8 m)", ha="right", color=GREY)
    axes.text(LIMIT * 1.2, 0.18, "scattering", ha="left", color=GREY)
    axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))


def spreadings_at(ratio: float, angle: NDArray[np.float64]) -> Iterator[tuple[str, str, NDArray[np.float64]]]:
    """Name, colour and density over the angle of each spreading at f/fp, deep water and a fully developed sea."""
    age, wind = 0.84, 8.0
    peak = 9.81 * (age / wind) ** 2
    yield "cos2s, s = 10", BLACK, spreading.cos2s(angle, 10.0)
    yield "mitsuyasu", ORANGE, spreading.cos2s(angle, spreading.mitsuyasu_exponent(ratio, age))
    yield "hasselmann", VERMILION, spreading.cos2s(angle, spreading.hasselmann_exponent(ratio, age))
    yield "donelan_banner", PURPLE, spreading.donelan_banner(angle, spreading.donelan_banner_beta(ratio))
    contrast = elfouhaily97_contrast(peak * ratio**2, wind, peak)
    yield "elfouhaily", BLUE, spreading.half_plane_elfouhaily(np.cos(angle), contrast)


# ------------------------------------------------------------------------------------------------------- choppy waves


@dataclass(frozen=True)
class Ground:
    """What the steep sea looks like over the ground, over seeds."""

    elevation: NDArray[np.float64]  # (seed, row, column) m
    k: NDArray[np.float64]  # rad/m, middles of rings
    spectrum: NDArray[np.float64]  # (k,) m³, mean over seeds

    def moment(self, power: int) -> float:
        """Skewness for 3, kurtosis for 4."""
        scaled = self.elevation / self.elevation.std()
        return float(np.mean(scaled**power))


def steep_sea(model: str, seed: int, waves: JonswapWaves = STEEP) -> Sea:
    """The steep sea as linear or choppy waves."""
    settings = SeaSettings.model_validate(
        {"model": model, "resolution_m": STEEP_RESOLUTION, "extent_m": STEEP_EXTENT, "waves": (waves,)}
    )
    return realize(settings, seed)


def over_the_ground(model: str, seeds: int) -> Ground:
    """Elevations on a square grid three times as fine as the waves', and their omnidirectional spectrum."""
    step = STEEP_EXTENT / STEEP_SIDE
    positions = step * np.arange(STEEP_SIDE)
    wave = np.fft.fftfreq(STEEP_SIDE, 1.0 / STEEP_SIDE)
    ring = np.rint(np.hypot(wave[:, None], wave[None, :])).astype(int).ravel()
    fields, spectrum = [], np.zeros(ring.max() + 1)
    for seed in range(seeds):
        fields.append(steep_sea(model, seed).elevation(positions, positions[:, None], 0.0))
        power = np.abs(np.fft.fft2(fields[-1]) / STEEP_SIDE**2) ** 2
        spectrum += np.bincount(ring, power.ravel()) / seeds
    spacing = 2.0 * np.pi / STEEP_EXTENT
    most = STEEP_SIDE // 2
    return Ground(np.stack(fields), spacing * np.arange(1.0, most), spectrum[1:most] / spacing)


def tail_ratios(linear: Ground, choppy: Ground) -> list[tuple[str, float]]:
    """Choppy over linear S(k), in bands of ± 10 % around multiples of the peak's wavenumber and near the limit."""
    limit = np.pi / STEEP_RESOLUTION
    wavenumbers = [(f"{n:g} kp", n * STEEP_PEAK) for n in (1.0, 2.0, 4.0, 8.0)] + [("0.9 limit", 0.9 * limit)]
    ratios = []
    for name, k in wavenumbers:
        band = np.abs(linear.k / k - 1.0) < 0.1
        ratios.append((name, float(choppy.spectrum[band].sum() / linear.spectrum[band].sum())))
    return ratios


@styled
def draw_choppy(linear: Ground, choppy: Ground) -> Figure:
    """Profile, elevations and spectrum."""
    figure = new_figure(5.2)
    draw_profile(figure)
    axes = place(figure, 0.55, 3.0, 2.7, 1.75)
    graph(axes, "elevation over its rms", "density", "b) elevations over the ground")
    edges = np.linspace(-5.0, 5.0, 81)
    middle = 0.5 * (edges[1:] + edges[:-1])
    axes.semilogy(middle, np.exp(-0.5 * middle**2) / np.sqrt(2.0 * np.pi), color=GREY, linestyle=":", label="Gaussian")
    for ground, name, colour in ((linear, "linear", BLUE), (choppy, "choppy", VERMILION)):
        counts, _ = np.histogram(ground.elevation / ground.elevation.std(), edges, density=True)
        label = f"{name}: skewness {ground.moment(3):+.2f}, kurtosis {ground.moment(4):.2f}"
        axes.step(middle, np.where(counts > 0.0, counts, np.nan), where="mid", color=colour, linewidth=1.0, label=label)
    axes.set_ylim(1e-5, 1e3)
    axes.legend(loc="upper center")
    axes = place(figure, 4.0, 3.0, 2.9, 1.75)
    graph(axes, "wavenumber k, rad/m", "saturation k³ S(k)", "c) spectrum over the ground")
    nominal = spectral_system(STEEP, np.inf).radial(linear.k)
    axes.loglog(linear.k, linear.k**3 * nominal, color=GREY, linestyle=":", label="nominal")
    axes.loglog(linear.k, linear.k**3 * linear.spectrum, color=BLUE, linewidth=1.0, label="linear")
    axes.loglog(choppy.k, choppy.k**3 * choppy.spectrum, color=VERMILION, linewidth=1.0, label="choppy")
    for n in (1.0, 2.0, 4.0):
        axes.axvline(n * STEEP_PEAK, color=GREY, linewidth=0.5)
        axes.text(n * STEEP_PEAK, 0.14, f" {n:g} kp", color=GREY)
    axes.axvline(np.pi / STEEP_RESOLUTION, color=BLACK, linewidth=0.8)
    axes.text(np.pi / STEEP_RESOLUTION, 0.14, " limit", color=BLACK)
    axes.set_xlim(0.05, 7.0)  # aliases begin beyond
    axes.set_ylim(1e-4, 0.25)
    axes.legend(loc="lower center")
    return figure


def draw_profile(figure: Figure) -> None:
    axes = place(figure, 0.55, 0.35, 6.4, 1.9)
    title = f"a) Hs {STEEP.significant_wave_height_m:g} m, Tp {STEEP.peak_period_s:g} s, long-crested, the same draw"
    graph(axes, "distance along the waves, m", "elevation, m", title)
    x = np.arange(0.0, 120.0, 0.1)
    crested = STEEP.model_copy(update={"spreading": "long_crested"})
    for model, colour in (("linear", BLUE), ("choppy", VERMILION)):
        axes.plot(x, steep_sea(model, 0, crested).elevation(x, 0.0, 0.0), color=colour, linewidth=1.1, label=model)
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    axes.set_xlim(0.0, 120.0)
    axes.legend(loc="upper right", ncols=2)


def main() -> None:
    chosen = options(__doc__, seeds=6, out=FIGURES)

    linear, choppy = (over_the_ground(model, chosen.seeds) for model in ("linear", "choppy"))
    facts = steep_sea("choppy", 0).resolved.choppy
    assert facts is not None
    print(f"\nsteep sea, {chosen.seeds} seeds: waves × {facts.amplitude_scale:.4f}, folded {facts.folded_share:.2e}")
    for name, ground in (("linear", linear), ("choppy", choppy)):
        print(
            f"  {name}: Hs {4.0 * ground.elevation.std():.3f} m, mean {ground.elevation.mean():+.4f} m, "
            f"skewness {ground.moment(3):+.3f}, kurtosis {ground.moment(4):.3f}"
        )
    print("  choppy over linear S(k):", ", ".join(f"{name} {ratio:.3f}" for name, ratio in tail_ratios(linear, choppy)))
    chosen.out.mkdir(parents=True, exist_ok=True)
    for name, figure in (
        ("sea_dispersion", draw_dispersion()),
        ("sea_spectra", draw_spectra()),
        ("sea_choppy", draw_choppy(linear, choppy)),
    ):
        (chosen.out / f"{name}.png").write_bytes(png(figure))
        print(f"figure: {chosen.out / name}.png")


if __name__ == "__main__":
    main()
