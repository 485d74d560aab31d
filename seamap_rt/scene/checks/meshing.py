"""The mesh: that it follows the waves and fits memory."""

from __future__ import annotations

from ...io.numbers import rounded_down, rounded_up
from ...mesh.sizing import MOST_TRIANGLES, MeshDetail, triangles
from ...settings import RadarSettings, SeaSettings, SinusoidWaves

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
