"""A scene's link budget: the textbook's beside the simulator's, as text and as a table on file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import db, radar_wavelength, written
from ..errors import InputError
from ..io.process import hold_interruptions
from ..io.results_folder import clear_folder, results_folder, write_whole
from ..io.text import csv_text, number_list
from ..radar import link
from ..radar.antenna import antenna
from ..radar.link import Budget, LinkBudget, nrcs_words
from ..radar.receiver import data_rate, noise_power, pulse_coherence
from ..radar.waveform import RangeResponse, blind_range_m, gate_spacing_m, straddling_loss_db, unambiguous_range_m
from ..scattering import MEAN_MODELS, mean_level
from ..scene import Scene
from ..scene.water_checks import STEEPEST_SINE
from ..settings import RadarSettings

Column = tuple[str, str, NDArray[np.float64], int]  # heading, name in the CSV, values, decimals

_TITLES = {
    "textbook": "Textbook budget: the beam's peak on every cell, even over its −3 dB width, the whole pulse",
    "simulator": "Simulator's budget: the integral over the two-way pattern and the range response",
}
_REFERENCE_M = 100.0  # range at which the losses are stated


def link_lines(scene: Scene, table: LinkBudget, curve: LinkBudget) -> list[str]:
    """Aligned lines of plain text. table: the ranges to list; curve: ranges close enough to find crossings on."""
    facts = [*_facts(scene), *_reaches(curve)]
    wide = max(len(name) for name, _ in facts)
    lines = [f"Link budget of {scene.name}: a level boat over mean sea level", ""]
    lines += [f"{name:{wide}}  {value}" for name, value in facts]
    seen = _sea_columns(scene.radar, table)
    lines += ["", f"The sea; {nrcs_words(table)}", *_align_columns(seen)]
    for each in table.budgets:
        lines += ["", _TITLES[each.name], *_align_columns([seen[0], *_budget_columns(table, each)])]
    notes = _notes(scene.radar, table.range)
    return [*lines, "", *notes] if notes else lines


def link_table(radar: RadarSettings, table: LinkBudget) -> str:
    """The same as CSV, a row per range: values in dB are 10 log10, cells that have none (σ0 in a null) are empty."""
    columns = {name: values for _, name, values, _ in _sea_columns(radar, table)}
    columns["noise_dbm"] = np.full(table.range.shape, _dbm(table.noise))
    for each in table.budgets:
        columns |= {f"{each.name}_{name}": values for _, name, values, _ in _budget_columns(table, each)}
    values = np.stack(list(columns.values()), axis=1)
    return csv_text([list(columns), *np.where(np.isfinite(values), values, np.nan)])


def _facts(scene: Scene) -> list[tuple[str, str]]:
    """Names and values of the facts that do not depend on range."""
    radar = scene.radar
    across = (link.footprint_m(radar, r) for r in (100.0, 200.0))
    spacing, (worst, mean) = gate_spacing_m(radar), straddling_loss_db(radar)
    gain, pulses = db(antenna(radar).gain), link.dwell(radar)
    facts = [
        ("wavelength", f"{1e3 * radar_wavelength(radar.frequency_hz):.2f} mm"),
        ("antenna", f"{gain:.2f} dBi; {_beam(radar)}"),
        ("beam across the look", "{} m at 100 m, {} m at 200 m".format(*(written(float(each), 2) for each in across))),
        ("range resolution", _resolution(radar)),
        ("gates", f"every {spacing:.3f} m; a point between two loses {worst:.2f} dB, on average {mean:.2f}"),
        ("noise", f"{_dbm(noise_power(radar)):.2f} dBm in {radar.bandwidth_hz / 1e6:g} MHz"),
        ("dwell", f"{written(1e3 * pulses.duration_s, 2)} ms, {pulses.pulses} pulses a receiver"),
        ("integration", _integration(scene, pulses.pulses)),
        ("range limits", f"blind to {blind_range_m(radar):.2f} m, unambiguous to {unambiguous_range_m(radar):.0f} m"),
        ("data rate", _data_rate(radar)),
    ]  # fmt: skip
    if radar.height_m < _REFERENCE_M:
        losses = link.losses_to_textbook(radar, _REFERENCE_M)
        elevation = float(losses.elevation) + 0.0
        total = losses.azimuth + elevation + losses.response
        pieces = (
            f"azimuth pattern {losses.azimuth:.2f}, elevation pattern {elevation:.2f}, filter {losses.response:.2f}"
        )
        facts.append(("simulator less than textbook", f"{total:.2f} dB at {_REFERENCE_M:g} m: {pieces}"))
    return facts


def _beam(radar: RadarSettings) -> str:
    width, height = link.beam_widths_deg(radar)
    if np.isinf(antenna(radar).azimuth_beamwidth_deg):
        return f"no beam: the scene's {width:.2f}° × {height:.2f}° stand for one"
    return f"beam {width:.2f}° × {height:.2f}°, one-way −3 dB"


def _resolution(radar: RadarSettings) -> str:
    measured, cell = RangeResponse.of(radar).resolution_m, link.range_cell_m(radar)
    words = f"{written(measured, 2)} m at −3 dB; the textbook's cell is {written(cell, 2)} m"
    if radar.waveform != "chirp":
        return words
    return f"{words}; compression gains {db(link.compression_gain(radar)):.1f} dB at best"


def _integration(scene: Scene, pulses: int) -> str:
    _, loose, tight = link.integrations(scene.radar, scene.scattering.decorrelation_time_s)
    memory, lost = 1e3 * scene.scattering.decorrelation_time_s, float(db(pulses / tight.gain))
    in_phase = f"coherent {db(tight.gain):.2f} dB, {lost:.2f} below N for a decorrelation time of {memory:g} ms"
    if pulse_coherence(scene.radar) == 0.0:
        in_phase = "coherent 0 dB, of a magnetron's random phases"
    return f"non-coherent √N {db(loose.gain):.2f} dB; {in_phase}"


def _data_rate(radar: RadarSettings) -> str:
    rate = data_rate(radar)
    fine, coarse, raw = (written(each / 1e6, 1) for each in (rate.complex_12, rate.complex_16, rate.raw))
    gates = f"gates {fine} MB/s at 12 + 12 bits, {coarse} at 16 + 16"
    if radar.receiver.chain != "digital":
        return gates
    return f"{gates}; the converters' samples {raw} at {radar.receiver.adc_bits}"


def _reaches(curve: LinkBudget) -> list[tuple[str, str]]:
    """The furthest range at which each budget has a signal to noise ratio of 0 dB."""
    rows: list[tuple[str, str]] = []
    for each in curve.budgets:
        words = []
        for integration, row in zip(curve.integrations, each.snr, strict=True):
            reach = link.furthest(curve.range, row)
            far = f"beyond {curve.range[-1]:.0f} m" if math.isinf(reach) else f"{reach:.0f} m"
            words.append(f"{integration.name} {'nowhere' if math.isnan(reach) else far}")
        rows.append((f"SNR is 0 dB at, {each.name}", ", ".join(words)))
    return rows


def _sea_columns(radar: RadarSettings, table: LinkBudget) -> list[Column]:
    return [
        ("range m", "range_m", table.range, 1),
        ("grazing °", "grazing_deg", np.degrees(table.grazing), 2),
        ("gain to sea dBi", "gain_towards_sea_dbi", db(table.gain), 2),
        ("beam across m", "footprint_m", link.footprint_m(radar, table.range), 2),
        ("cell m²", "cell_area_m2", table.area, 2),
        ("mean σ0 dB", "nrcs_db", db(table.nrcs), 2),
    ]


def _budget_columns(table: LinkBudget, each: Budget) -> list[Column]:
    """Columns of a budget, without the ranges."""
    columns: list[Column] = [("echo dBm", "echo_dbm", _dbm(each.power), 2)]
    for heading, prefix, rows in (("SNR dB", "snr", each.snr), ("σ0 min dB", "minimum_nrcs", each.minimum_nrcs)):
        for mode, row in zip(table.integrations, rows, strict=True):
            name = mode.name.replace(" ", "_").replace("-", "")
            columns.append((f"{heading} {mode.name}", f"{prefix}_{name}_db", db(row), 2))
    return columns


def _align_columns(columns: Sequence[Column]) -> list[str]:
    """Headings of two lines at most, numbers flush right."""
    heads = [_split_unit(heading) for heading, *_ in columns]
    cells = [
        [f"{value:.{digits}f}" if math.isfinite(value) else "—" for value in values] for *_, values, digits in columns
    ]
    widths = [max(map(len, (*head, *cell))) for head, cell in zip(heads, cells, strict=True)]
    rows = [*zip(*heads, strict=True), *zip(*cells, strict=True)]
    return ["  ".join(f"{text:>{width}}" for text, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def _split_unit(heading: str) -> tuple[str, str]:
    for unit in ("dBm", "dBi", "dB", "m²", "m", "°"):
        words = heading.split(" ")
        if unit in words:
            words.remove(unit)
            return " ".join(words), unit
    return heading, ""


def _notes(radar: RadarSettings, ranges: NDArray[np.float64]) -> list[str]:
    notes: list[str] = []
    if np.any(ranges < blind_range_m(radar)):
        left = ": the simulator's budget counts what is left of it" if radar.waveform == "chirp" else ""
        notes.append(
            f"From nearer than {blind_range_m(radar):.4g} m the echo begins while the pulse is still sent{left}."
        )
    if np.any(ranges > unambiguous_range_m(radar)):
        notes.append(f"Beyond {unambiguous_range_m(radar):.5g} m echoes fold into the gates of the next pulse.")
    if radar.receiver.chain == "digital":
        notes.append("The converter's own noise and its saturation are not counted.")
    if radar.antennas:
        notes.append("The antenna is that of [radar.antenna]; those of [[radar.antennas]] may differ.")
    return notes


def _dbm(power: ArrayLike) -> NDArray[np.float64]:
    return db(1e3 * np.asarray(power, dtype=np.float64))


PRODUCTS = ("link.csv", "link.png")
FURTHEST_M = 20_000.0  # m, the longest range window that a scene may have
CURVE_POINTS = 160


# ------------------------------------------------------------------------------------------------- numbers


def mean_sea(scene: Scene, range_m: ArrayLike) -> tuple[NDArray[np.float64], str]:
    """Mean σ0 (range,) [ratio] of the scene at slant ranges [m], over all directions of the wind; and its name.

    Beyond the model's grazing angles it keeps its edge value, as in the simulation. Theory that is calibrated to
    nothing has a mean only facet by facet: NRL 2012 stands in for it.
    """
    scattering, frequency = scene.scattering, scene.radar.frequency_hz
    level = mean_level(scattering, np.degrees(link.grazing_angle(scene.radar, range_m)), frequency)
    if scattering.nrcs == "constant":
        return level, "constant"
    model, wind = MEAN_MODELS[scattering.mean_model or "nrl"], scattering.wind_speed_m_s
    name = f"{model.paper}, mean over wind directions" if model.knows_wind_direction else model.paper
    if scattering.mean_model is None:
        name += " (NRL) as a stand-in for theory calibrated to none"
    held = model.nearest_wind(wind)
    return level, name if scattering.extrapolate or held == wind else f"{name}, from its {held:.3g} m/s on by theory"


def link_budget(scene: Scene, range_m: ArrayLike) -> LinkBudget:
    """Both budgets at slant ranges (range,) [m] to mean sea level, each at least radar.height_m.

    The textbook's is `radar.link.textbook_power`, the simulator's `radar.link.flat_sea_power`: the integral over the
    two-way pattern and the range response, less what of a chirp is still being sent. Neither counts shadows.
    """
    radar, ranges = scene.radar, np.asarray(range_m, dtype=np.float64)
    nrcs, model = mean_sea(scene, ranges)
    methods = link.integrations(radar, scene.scattering.decorrelation_time_s)
    return LinkBudget(
        range=ranges,
        grazing=link.grazing_angle(radar, ranges),
        gain=link.gain_towards_sea(radar, ranges),
        area=link.cell_area(radar, ranges),
        nrcs=nrcs,
        nrcs_model=model,
        noise=noise_power(radar),
        integrations=methods,
        budgets=(
            link.budget(radar, "textbook", link.textbook_power(radar, 1.0, ranges), nrcs, methods),
            link.budget(radar, "simulator", simulated_power(radar, ranges), nrcs, methods),
        ),
    )


def simulated_power(radar: RadarSettings, ranges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Echo [W] of a sea of σ0 = 1 by the simulator's own integral."""
    return link.flat_sea_power(radar, 1.0, ranges) * link.eclipsed_share(radar, ranges)


# -------------------------------------------------------------------------------------------- what is requested


def ranges_of(text: str | None, scene: Scene) -> NDArray[np.float64]:
    """Slant ranges [m] of R,R,…, or a handful across the range window; InputError for what is not on the sea."""
    if text is None:
        near, far = window_of(scene)
        steps = (m * 10.0**power for power in range(-1, 5) for m in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0))
        return np.array([near, *(step for step in steps if near < step < far), far])
    about, form = f"--ranges = '{text}'", "write R,R,… in metres, as in 50,100,200"
    ranges = np.array([float(each) for each in number_list(text, about, form)])
    height = scene.radar.height_m
    wrong = ranges[(ranges <= height) | (ranges > FURTHEST_M)]
    if wrong.size:
        raise InputError(
            f"--ranges = {wrong[0]:.10g}: must be greater than {height:.10g} and at most {FURTHEST_M:.10g} (the sea "
            "begins radar.height_m below the antenna, and no range window reaches farther); change it"
        )
    return ranges


def window_of(scene: Scene) -> tuple[float, float]:
    """The range window [m] without what lies under the mast, steeper than the clutter models go."""
    (near, far), height = scene.radar.range_m, scene.radar.height_m
    return min(max(near, height / STEEPEST_SINE), 0.5 * (height + far)), far


# ------------------------------------------------------------------------------------------------- products


class LinkProducts(NamedTuple):
    """Lines to print, and the files that were written, if a folder was named."""

    lines: list[str]
    files: tuple[Path, ...]


def write_link(
    scene: Scene, out: str | Path | None = None, *, ranges: str | None = None, overwrite: bool = False
) -> LinkProducts:
    """Work out a scene's link budget; with a folder, write link.csv (a row per range) and link.png too.

    ranges: R,R,… slant ranges [m] of the table; default a handful across the range window. Raises InputError for bad
    input. Traces nothing and needs no backend.
    """
    radar = scene.radar
    table = link_budget(scene, ranges_of(ranges, scene))
    furthest = max(radar.range_m[1], min(FURTHEST_M, unambiguous_range_m(radar)))  # an echo from beyond would fold
    curve = link_budget(scene, np.geomspace(window_of(scene)[0], furthest, CURVE_POINTS))
    lines = link_lines(scene, table, curve)
    if out is None:
        return LinkProducts(lines, ())
    folder = Path(out)
    with results_folder(folder, overwrite, PRODUCTS):
        from ..report import style  # matplotlib, which a refusal does without
        from .link_figure import draw

        picture = style.png(draw(scene, link_budget(scene, np.geomspace(*window_of(scene), CURVE_POINTS))))
        clear_folder(folder, PRODUCTS)
        with hold_interruptions():
            write_whole(folder / "link.csv", link_table(radar, table))
            write_whole(folder / "link.png", picture)
    return LinkProducts(lines, tuple(folder / name for name in PRODUCTS))
