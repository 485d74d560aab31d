"""The shape of measured clutter's K-distribution: its law by hand, by polarization and by cell."""

from __future__ import annotations

import math

import pytest

from seamap_rt.radar import link
from seamap_rt.scattering import clutter_shape_watts_wicks90
from seamap_rt.settings import RadarSettings


def shape_of(radar: RadarSettings, polarization: str, range_m: float) -> float:
    grazing_deg = math.degrees(float(link.grazing_angle(radar, range_m)))
    return clutter_shape_watts_wicks90(grazing_deg, float(link.cell_area(radar, range_m)), polarization)


def test_clutter_is_spikier_in_hh_and_in_small_cells() -> None:
    radar = RadarSettings.model_validate({"range_m": [30.0, 150.0]})
    wide = RadarSettings.model_validate({"range_m": [30.0, 150.0], "antenna": {"azimuth_beamwidth_deg": 3.6}})
    shape = shape_of(radar, "VV", 100.0)
    assert shape / shape_of(radar, "HH", 100.0) == pytest.approx(10.0**0.7)
    # By 5/8 of the power of the area, of beams as wide as their patterns come out.
    area = float(link.cell_area(wide, 100.0) / link.cell_area(radar, 100.0))
    assert shape_of(wide, "VV", 100.0) / shape == pytest.approx(area**0.625)
    # ψ = 2.866°, 9.42 m²: 2/3 log 2.866 + 5/8 log 9.42 − 1 = −0.0862.
    assert shape == pytest.approx(10.0**-0.0862, rel=2e-3)
    assert math.isnan(shape_of(radar, "VV", 20.0))
