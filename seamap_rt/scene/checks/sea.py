"""The sea: that it does not break before it is so steep, and that the mesh follows its waves and fits memory."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...conventions import GRAVITY
from ...errors import refuse
from ...io.text import rounded_down, rounded_up
from ...mesh.sizing import MOST_TRIANGLES, MeshDetail, triangles
from ...settings import PlatformSettings, RadarSettings, SeaSettings, SinusoidWaves

STEEPEST = 0.142  # significant wave height over the peak's wavelength: of the steepest regular wave (Michell 1893)


def check_record(sea: SeaSettings, platform: PlatformSettings) -> None:
    """A boat follows waves that are known one by one."""
    if sea.model == "recorded" and platform.motion == "wave_following":
        raise ValueError(
            "platform.motion = 'wave_following': must be fixed, sinusoidal or file where sea.model = 'recorded' (the "
            "boat follows waves that are known one by one); choose one of them"
        )


def check_steepness(sea: SeaSettings) -> None:
    """A system given by its height and period is not steeper than water stands. By the wavelength in deep water, of
    which that in shallow water falls short."""
    refuse(_too_steep(sea))


def _too_steep(sea: SeaSettings) -> Iterator[str]:
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
