"""The sea: that it does not break before it is so steep, that the mesh follows its waves and fits memory, that models
of its echo are used within the ranges of their papers, and that gauges stand in it where the radar looks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ..conventions import GRAVITY, ground_range
from ..io.text import rounded_down, rounded_up
from ..mesh.sizing import MOST_TRIANGLES, MeshDetail, triangles
from ..scattering import MEAN_MODELS, wind_from_sea_state
from ..scattering.permittivity import permittivity_of
from ..settings import (
    GaugeSettings,
    PlatformSettings,
    RadarSettings,
    RetrievalSettings,
    ScatteringSettings,
    SeaSettings,
    SinusoidWaves,
)

STEEPEST = 0.142  # significant wave height over the peak's wavelength: of the steepest regular wave (Michell 1893)


def check_record(sea: SeaSettings, platform: PlatformSettings) -> None:
    """A boat follows waves that are known one by one."""
    if sea.model == "recorded" and platform.motion == "wave_following":
        raise ValueError(
            "platform.motion = 'wave_following': must be fixed, sinusoidal or file where sea.model = 'recorded' (the "
            "boat follows waves that are known one by one); choose one of them"
        )


def check_steepness(sea: SeaSettings) -> Iterator[str]:
    """A system given by its height and period is not steeper than water stands. By the wavelength in deep water, of
    which that in shallow water falls short."""
    for number, waves in enumerate(sea.waves):
        height, period = (getattr(waves, name, None) for name in ("significant_wave_height_m", "peak_period_s"))
        if height is None or period is None:
            continue
        length = GRAVITY * period**2 / (2.0 * math.pi)
        if height > STEEPEST * length:
            yield (
                f"sea.waves.{number}.significant_wave_height_m = {height:g}: must be at most {STEEPEST * length:.3g} "
                f"where peak_period_s = {period:g}, {STEEPEST:g} of the wavelength (steeper waves break; measured "
                "seas keep below 1/15, DNV-RP-C205); lower the height or lengthen the period"
            )


BYTES_PER_TRIANGLE = 600.0  # vertices, the tracer's tree and the facets' arrays


def check_waves(detail: MeshDetail, sea: SeaSettings) -> None:
    """Four facets at least for a regular wave."""
    facet = detail.facet_m
    for number, waves in enumerate(sea.waves):
        if isinstance(waves, SinusoidWaves) and waves.height_m > 0.0 and waves.wavelength_m < 4.0 * facet:
            raise ValueError(
                f"tracing.facet_m = {facet:.10g}: must be at most {rounded_down(0.25 * waves.wavelength_m)} (a quarter "
                f"of sea.waves.{number}.wavelength_m = {waves.wavelength_m:.10g}, or the mesh misses the wave); lower "
                "tracing.facet_m or lengthen the wave"
            )


def check_memory(detail: MeshDetail, radar: RadarSettings) -> None:
    """The mesh fits memory."""
    facet, columns = detail.facet_m, detail.columns_per_beam
    count = float(triangles(radar, facet, columns))
    if count > MOST_TRIANGLES:
        raise ValueError(
            f"tracing.facet_m = {facet:.10g}: must be at least {rounded_up(facet * count / MOST_TRIANGLES)} "
            f"for this sector and range (the mesh would have {count:.3g} triangles, "
            f"{_gigabytes(count)}, and may have {MOST_TRIANGLES:.3g}, {_gigabytes(MOST_TRIANGLES)}); "
            "raise tracing.facet_m, lower tracing.columns_per_beam, narrow radar.sector_deg or shorten "
            "radar.range_m"
        )


def _gigabytes(count: float) -> str:
    return f"{count * BYTES_PER_TRIANGLE / 1e9:.3g} GB"


LEAST_WIND = 0.5  # m/s, of scattering.wind_speed_m_s
STEEPEST_SINE = math.sin(math.radians(59.9))  # sine of the grazing angle beyond which no clutter model is used


def check_permittivity(scattering: ScatteringSettings, radar: RadarSettings) -> None:
    """The permittivity model holds for frequency and water."""
    try:
        permittivity_of(scattering, radar.frequency_hz)
    except ValueError as error:
        raise ValueError(
            f"scattering.permittivity = '{scattering.permittivity}': {error}, or choose another scattering.permittivity"
        ) from None


def check_mean_model(scattering: ScatteringSettings, radar: RadarSettings) -> None:
    """The measured model that sets the mean holds for frequency and grazing angles, unless it is extrapolated; and for
    the wind where it is all that echoes: theory's mean goes on from the model's nearest wind by theory (`mean_level`).
    """
    name = scattering.mean_model
    if name is None or scattering.extrapolate:
        return
    model = MEAN_MODELS[name]
    key = "scattering.nrcs" if scattering.nrcs == name else "scattering.calibrated_to"
    other = f"or choose another {key}" + (" ('none' leaves theory alone)" if key.endswith("to") else "")
    remedy = f"{other}, or set scattering.extrapolate = true to let its formula run on"
    least, most = model.sea_state
    wind = scattering.wind_speed_m_s
    if scattering.nrcs == name and model.nearest_wind(wind) != wind:
        limits = [max(LEAST_WIND, float(wind_from_sea_state(state))) for state in (least, most)]
        raise ValueError(
            f"scattering.wind_speed_m_s = {wind:.10g}: must be {rounded_up(limits[0])} to {rounded_down(limits[1])} "
            f"(sea state {least:g} to {most:g}, where {key} = '{name}' holds: {model.paper}); change it, {remedy}, or "
            "set scattering.nrcs = 'two_scale', whose mean goes on from there by theory"
        )
    low, high = model.frequency_hz
    frequency = radar.frequency_hz
    if not low <= frequency <= high:
        raise ValueError(
            f"radar.frequency_hz = {frequency:.10g}: must be {low:g} to {high:g}, where {key} = '{name}' holds "
            f"({model.paper}); change it, {remedy}"
        )
    if name != "nrl":
        _check_grazing(radar, key, name, f"{other}, or set scattering.extrapolate = true to keep its edge value")


def _check_grazing(radar: RadarSettings, key: str, name: str, remedy: str) -> None:
    """NRL 2012 reaches from 0.1° to 60°, and what little lies beyond takes its edge value; the others end sooner.
    Steeper than 60°, about the mast's foot, no clutter model is used."""
    (near, far), height = radar.range_m, radar.height_m
    model = MEAN_MODELS[name]
    least, most = (math.sin(math.radians(angle)) for angle in model.grazing_deg)
    if far > height / least:
        raise ValueError(
            f"radar.range_m = [{near:.10g},{far:.10g}]: its far end must be at most {rounded_down(height / least)} "
            f"(there the sea is seen under {model.grazing_deg[0]:g}°, the least for which {key} = '{name}' holds: "
            f"{model.paper}); lower it, {remedy}"
        )
    if near < height / most and most < STEEPEST_SINE:
        if far <= height / most:
            raise ValueError(
                f"radar.range_m = [{near:.10g},{far:.10g}]: lies wholly nearer than {rounded_up(height / most)} "
                f"(there the sea is seen under {model.grazing_deg[1]:g}°, the most for which {key} = '{name}' holds: "
                f"{model.paper}); move it out, lower radar.height_m, {remedy}"
            )
        raise ValueError(
            f"radar.range_m = [{near:.10g},{far:.10g}]: its near end must be at least {rounded_up(height / most)} "
            f"(there the sea is seen under {model.grazing_deg[1]:g}°, the most for which {key} = '{name}' holds: "
            f"{model.paper}); raise it, {remedy}"
        )


def check_names_and_rates(gauges: Sequence[GaugeSettings]) -> Iterator[str]:
    """Names differ, rates do not."""
    names = [gauge.name for gauge in gauges]
    for number, gauge in enumerate(gauges):
        first = names.index(gauge.name)
        if first < number:
            yield (f"gauges.{number}.name = '{gauge.name}': is the name of gauges.{first}; give each gauge its own")
        rate = gauges[0].sample_hz
        if gauge.sample_hz != rate:
            yield (
                f"gauges.{number}.sample_hz = {gauge.sample_hz:.10g}: must be {rate:.10g}, that of gauges.0 (all "
                "gauges are read together); give them one rate"
            )


def check_known(gauges: Sequence[GaugeSettings], sea: SeaSettings) -> Iterator[str]:
    """Gauges stand where a recorded sea is known."""
    if sea.model != "recorded" or not gauges:
        return
    from ..io.recorded_sea import recorded_sea  # loads what reads files

    file = recorded_sea(sea.file)
    for number, gauge in enumerate(gauges):
        if not file.holds(*np.array(gauge.position)[:, None]).all():
            west, east, south, north = file.judged_m
            yield (
                f"gauges.{number}: '{gauge.name}' stands where sea.file is not known, and is not judged there: it must "
                f"stand {west:.4g} to {east:.4g} m east and {south:.4g} to {north:.4g} m north; move it"
            )


def check_positions(
    gauges: Sequence[GaugeSettings], radar: RadarSettings, platform: PlatformSettings, retrieval: RetrievalSettings
) -> Iterator[str]:
    """Gauges stand within the range window and, of a boat at rest, within the sector."""
    moves = platform.speed_m_s > 0.0 or platform.motion == "file"
    near, far = map(float, ground_range(radar.range_m, radar.height_m))
    if moves:
        near = 0.0
    start, stop = radar.sector_deg
    if radar.scan == "staring":
        middle, half = 0.5 * (start + stop), 0.5 * retrieval.cell_azimuth_deg
        start, stop = middle - half, middle + half
    for number, gauge in enumerate(gauges):
        about, (east, north) = f"gauges.{number}: '{gauge.name}' stands", gauge.position
        away, azimuth = math.hypot(east, north), math.degrees(math.atan2(east, north)) % 360.0
        if not near * (1.0 - 1e-9) <= away <= far:
            yield (
                f"{about} {away:.4g} m from the antenna, and must stand {rounded_up(near)} to {rounded_down(far)} m "
                "from it (radar.range_m over the water); move it or change radar.range_m"
            )
        elif not moves and (azimuth - start + 1e-9) % 360.0 > stop - start + 2e-9:
            looks = "the one look of radar.sector_deg" if radar.scan == "staring" else "radar.sector_deg"
            yield (
                f"{about} at azimuth {azimuth:.4g}°, outside of {looks} ({start:.10g}° to {stop:.10g}°); move it "
                "or change radar.sector_deg"
            )
