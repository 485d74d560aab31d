"""What is kept of a radar between turns is made anew when a file that it was made from has changed."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from seamap_rt.echoes.response import tabulated, two_way_beams
from seamap_rt.radar.array import antenna_array
from seamap_rt.settings import AntennaSettings, RadarSettings


def written(path: Path, beam_deg: float) -> None:
    """A pattern whose azimuth beam is so wide between its half-power points."""
    rows = [f"azimuth,{angle},{-12.0 * (angle / beam_deg) ** 2}" for angle in np.arange(-10.0, 10.1, 0.1)]
    rows += [f"elevation,{angle},{-12.0 * (angle / 24.0) ** 2}" for angle in np.arange(-90.0, 91.0, 3.0)]
    path.write_text("\n".join(["cut,angle_deg,gain_db", *rows]))


def test_a_pattern_that_was_written_anew_is_the_one_that_is_used(tmp_path: Path) -> None:
    file = tmp_path / "pattern.csv"
    radar = RadarSettings(antenna=AntennaSettings(pattern="file", file=str(file)))
    written(file, 2.0)
    wide, heard = two_way_beams(radar), tabulated(radar)
    np.testing.assert_allclose(antenna_array(radar).beam_deg, 2.0, rtol=0.01)  # −12 dB (½)² = −3 dB, and 3.01 are half
    assert two_way_beams(radar) is wide
    assert tabulated(radar) is heard
    written(file, 1.25)  # another size in bytes too, should the clock be coarse
    np.testing.assert_allclose(antenna_array(radar).beam_deg, 1.25, rtol=0.01)
    assert two_way_beams(radar) is not wide
    assert two_way_beams(radar).scale > 1.5 * wide.scale  # the table spans so many beams
