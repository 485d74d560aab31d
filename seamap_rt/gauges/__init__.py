"""Virtual wave gauges: a wire's record of the true surface, beside it the radar's map at the same place, judged.

`[[gauges]]` puts them into the sea (`east_m`, `north_m`, or `ground_range_m` and `azimuth_deg`). `gauges.nc` and the
report hold the wire's record, what the map says there once a turn with its error bar, both spectra, and the
correlation. On any maps, recorded ones too, without a wire:

    gauge_series(maps, None, [GaugeSettings(name="pier", east_m=80.0, north_m=0.0)], turn_s=1.0)

Evidence: validation/README.md, "Wave gauges".
"""

from .judging import GaugeSpectra, NoSpectrum, aliasing, gauge_series, judge, judge_one, spectra

__all__ = ["GaugeSpectra", "NoSpectrum", "aliasing", "gauge_series", "judge", "judge_one", "spectra"]
