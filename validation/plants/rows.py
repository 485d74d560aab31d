"""All rows, in the order of the data's way."""

from __future__ import annotations

from . import (
    rows_app,
    rows_begin,
    rows_declared,
    rows_files,
    rows_judged,
    rows_light,
    rows_maps,
    rows_nonlinear_sea,
    rows_prediction,
    rows_radar,
    rows_recorded_sea,
    rows_scattering,
    rows_sea,
    rows_small_shadows,
    rows_spikes,
    rows_transmitter,
)

PLANTS = (
    *rows_sea.PLANTS,
    *rows_scattering.PLANTS,
    *rows_light.PLANTS,
    *rows_small_shadows.PLANTS,
    *rows_spikes.PLANTS,
    *rows_nonlinear_sea.PLANTS,
    *rows_radar.PLANTS,
    *rows_recorded_sea.PLANTS,
    *rows_declared.PLANTS,
    *rows_transmitter.PLANTS,
    *rows_maps.PLANTS,
    *rows_judged.PLANTS,
    *rows_files.PLANTS,
    *rows_prediction.PLANTS,
    *rows_begin.PLANTS,
    *rows_app.PLANTS,
)
