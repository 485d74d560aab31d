"""The design study's fourth claim: from 5 m, at Hs/λ = 1/30, more than half of the sea is shadowed beyond 160 m.

    python -m validation.claims.shadowing [--seeds 4] [--full] [--out validation/figures/shadowing_claim.png]

Slopes decide how far one sees, not steepness, and slopes depend on the shortest wave in the sea. JONSWAP seas (γ = 3.3,
cos²ˢ with s = 10) whose peaks are 20, 40 and 60 m long are simulated down to shorter and shorter waves. For each the
range beyond which half is shadowed is computed along the waves, at 45°, across and over all looks, with 95 % bands over
seeds (Student's t; all values of one seed count as one draw). Beside it stands that of Smith (1967), with the slope
that the mesh carries along the look. The mesh is never coarser than the grid of the waves.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import GRAVITY
from seamap_rt.report import style
from seamap_rt.scene import Scene
from seamap_rt.studies.shadowing import joined, shadowing_by_cutoff

from .. import FIGURES
from ..options import options

FIGURE = FIGURES / "shadowing_claim.png"
CLAIM_M, HEIGHT_M, STEEPNESS = 160.0, 5.0, 1.0 / 30.0
PEAKS_M = (20.0, 40.0, 60.0)
CUTOFFS_M = (12.0, 6.0, 3.0, 1.6, 1.0)  # shortest waves; twice the spacing of the sea's grid
SHORTEST_M = 0.5  # further, of the full version
JUDGED = ("along", "all looks")
NYQUIST_M = 6.0  # of a map of 3 m cells
_FAR_M, _MARGIN_M = {12.0: 600.0, 6.0: 500.0, 3.0: 400.0}, 30.0  # range window by cutoff
_NEAREST_FAR_M = 300.0
_COLOURS = dict(zip(PEAKS_M, (style.VERMILION, style.BLUE, style.GREEN), strict=True))


def claimed_sea(peak_m: float, cutoff_m: float) -> Scene:
    """choppy_sea with waves of that peak wavelength and the claim's steepness; the patch covers the range window."""
    far = _FAR_M.get(cutoff_m, _NEAREST_FAR_M)
    return sr.load_scene(
        "choppy_sea",
        overrides={
            "sea.waves.0.significant_wave_height_m": STEEPNESS * peak_m,
            "sea.waves.0.peak_period_s": float(np.sqrt(2.0 * np.pi * peak_m / GRAVITY)),
            "sea.extent_m": 2.0 * (far + _MARGIN_M),
            "radar.height_m": HEIGHT_M,
            "radar.range_m": [15.0, far],
        },
    )


def cutoffs_of(full: bool) -> tuple[float, ...]:
    """Shortest waves [m]; `full` draws them down to 0.5 m as well."""
    return (*CUTOFFS_M, SHORTEST_M) if full else CUTOFFS_M


def half_ranges(seeds: int, cutoffs_m: tuple[float, ...] = CUTOFFS_M) -> dict[float, xr.Dataset]:
    """For each peak wavelength `look_r50`, its band and Smith's over (cutoff_wavelength, look)."""
    return {peak: joined(list(_by_cutoff(peak, seeds, cutoffs_m))) for peak in PEAKS_M}


def _by_cutoff(peak: float, seeds: int, cutoffs_m: tuple[float, ...]) -> Iterator[xr.Dataset]:
    names = [f"look_r50{end}" for end in ("", "_low", "_high", "_smith", "_wagner")]
    for cutoff in cutoffs_m:
        data = shadowing_by_cutoff(claimed_sea(peak, cutoff), [0.5 * cutoff], [HEIGHT_M], seeds)
        yield data[[*names, "facet_m"]].isel(height=0)


def judged(studies: dict[float, xr.Dataset]) -> tuple[str, str, list[str]]:
    """Verdict, assumption and figures of claim 4 from half ranges."""
    lines = [_finest(studies, look) for look in JUDGED]
    lines += [_line(peak, data, look) for look in JUDGED for peak, data in studies.items()]
    met = [cutoff for data in studies.values() if np.isfinite(cutoff := cutoff_of_claim(data, "all looks"))]
    if not met:
        return "not reproduced", "", lines
    along = [peak for peak, data in studies.items() if np.isfinite(cutoff_of_claim(data, "along"))]
    ahead = f"for peaks of {', '.join(f'{peak:g}' for peak in along)} m alone" if along else "for none of the peaks"
    assumption = (
        f"it is meant for all looks together and waves shorter than {_span(met)} m are left out, as on a grid of "
        f"{_span([0.5 * cutoff for cutoff in met])} m; along the waves {ahead}"
    )
    return "only if", assumption, lines


def sentence(verdict: str, assumption: str, lines: list[str]) -> str:
    """The judgement in one sentence."""
    because = f" {assumption}" if assumption else ""
    return f"Claim 4, half shadowed from {CLAIM_M:.0f} m on: {verdict}{because}; {lines[len(JUDGED) - 1]}."


def cutoff_of_claim(data: xr.Dataset, look: str) -> float:
    """Shortest wave [m] with which the half range of a look is the claim's; NaN if it is for none that was drawn."""
    cutoff, half = data["cutoff_wavelength"].values, data["look_r50"].sel(look=look).values
    known = np.isfinite(half)
    order = np.argsort(half[known])
    cutoff, half = cutoff[known][order], half[known][order]
    inside = half.size > 0 and half[0] <= CLAIM_M <= half[-1]
    return float(np.exp(np.interp(CLAIM_M, half, np.log(cutoff)))) if inside else np.nan


def _span(values: list[float]) -> str:
    low, high = (f"{value:.2g}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def _finest(studies: dict[float, xr.Dataset], look: str) -> str:
    """The claim with the shortest waves that were simulated."""
    halves = [float(data["look_r50"].sel(look=look).isel(resolution=-1)) for data in studies.values()]
    shortest = min(float(data["cutoff_wavelength"].min()) for data in studies.values())
    low, high = min(halves), max(halves)
    return (
        f"{look}, with waves down to {shortest:g} m, half is shadowed: from {low:.0f} to {high:.0f} m on, "
        f"{low / CLAIM_M:.2f} to {high / CLAIM_M:.2f} of what is claimed"
    )


def _line(peak: float, data: xr.Dataset, look: str) -> str:
    chosen = data.sel(look=look)
    each = (
        f"{float(one['cutoff_wavelength']):g} m: {float(one['look_r50']):.0f} [{float(one['look_r50_low']):.0f}, "
        f"{float(one['look_r50_high']):.0f}], Smith {float(one['look_r50_smith']):.0f}"
        for one in (chosen.isel(resolution=number) for number in range(chosen.sizes["resolution"]))
    )
    return f"peak {peak:g} m, {look}, half range [m] by the shortest wave: " + "; ".join(each)


@style.styled
def draw(studies: dict[float, xr.Dataset], seeds: int) -> Figure:
    """Half range against the shortest wave that is drawn: a panel per look, a colour per peak wavelength."""
    figure = style.new_figure(3.5)
    looks = [str(look) for look in studies[PEAKS_M[0]]["look"].values]
    top = 1.1 * np.nanmax([data["look_r50_smith"].values.max() for data in studies.values()])
    cutoffs = studies[PEAKS_M[0]]["cutoff_wavelength"].values
    panels: list[Axes] = []
    for number, look in enumerate(looks):
        axes = style.place(figure, 0.5 + 1.68 * number, 0.62, 1.56, 2.25, xscale="log", yscale="log")
        style.graph(
            axes, "Shortest wave drawn (m)", "Half range (m)" if number == 0 else "", f"({'abcd'[number]}) {look}"
        )
        axes.axhline(CLAIM_M, color=style.BLACK, linewidth=1.0, label="claim: 160 m")
        axes.axvline(NYQUIST_M, color=style.GREY, linewidth=0.8, linestyle=":", label="grid of 3 m")
        for peak, data in studies.items():
            _draw_one(axes, data.sel(look=look), peak)
        axes.set(xticks=cutoffs, xticklabels=[f"{cutoff:g}" for cutoff in cutoffs])
        axes.set_yticks([50, 100, 160, 200, 400, 800], labels=["50", "100", "160", "200", "400", "800"])
        axes.minorticks_off()
        axes.tick_params(labelleft=number == 0)
        axes.set_ylim(50.0, top)
        panels.append(axes)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper left", bbox_to_anchor=(0.06, 1.0), ncols=5)
    figure.text(
        0.075,
        0.015,
        f"Antenna at {HEIGHT_M:g} m, Hs/λ = 1/30. Bars: 95 % over {seeds} seeds. Dashed: Smith 1967, meshed slopes.",
        color=style.GREY,
    )
    return figure


def _draw_one(axes: Axes, data: xr.Dataset, peak: float) -> None:
    cutoff = data["cutoff_wavelength"].values * (peak / 40.0) ** 0.03  # slightly apart, so that bars do not overlap
    half = data["look_r50"].values
    reach: NDArray = np.abs(np.stack([half - data["look_r50_low"].values, data["look_r50_high"].values - half]))
    marks = {"fmt": "o-", "markersize": 3.0, "linewidth": 1.0, "capsize": 1.5}
    axes.errorbar(cutoff, half, np.nan_to_num(reach), color=_COLOURS[peak], label=f"peak at {peak:g} m", **marks)
    axes.plot(cutoff, data["look_r50_smith"].values, "--", color=_COLOURS[peak], linewidth=0.9)


def main() -> None:
    arguments = options(__doc__, seeds=int, full=False, out=FIGURE)
    start = time.perf_counter()
    seeds = arguments.seeds or (10 if arguments.full else 4)
    studies = half_ranges(seeds, cutoffs_of(arguments.full))
    verdict, assumption, lines = judged(studies)
    print("\n".join(lines))
    print(sentence(verdict, assumption, lines))
    arguments.out.write_bytes(style.png(draw(studies, seeds)))
    print(f"{arguments.out}, {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
