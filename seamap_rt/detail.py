"""Level of detail: how fine the mesh must be for what is asked of it."""

from __future__ import annotations

from dataclasses import dataclass

from .settings import RadarSettings, SeaSettings, TracingSettings

_COLUMNS = 4  # a beam
_RUNGS = 6  # a resolution cell


@dataclass(frozen=True)
class MeshDetail:
    """The spacings of a mesh."""

    facet_m: float  # between rungs, along the look
    columns_per_beam: int

    def meshing(self, tracing: TracingSettings) -> TracingSettings:
        """The settings with the spacings filled in."""
        return tracing.model_copy(update={"facet_m": self.facet_m, "columns_per_beam": self.columns_per_beam})


def radar_detail(radar: RadarSettings, tracing: TracingSettings) -> MeshDetail:
    """The spacings as given; where they are not, those that fill the radar's own cells, whatever the sea."""
    return MeshDetail(tracing.facet_m or 0.5, tracing.columns_per_beam or _COLUMNS)


def mesh_detail(sea: SeaSettings, radar: RadarSettings, tracing: TracingSettings) -> MeshDetail:
    """The spacings that a scene needs."""
    return radar_detail(radar, tracing)
