"""Virtual wave gauges: a wire's record of the true surface, beside it the radar's map at the same place, judged."""

from .file import GaugeFile
from .judging import aliasing, judge, judge_one
from .reading import gauge_series
from .spectra import GaugeSpectra, NoSpectrum, spectra

__all__ = ["GaugeFile", "GaugeSpectra", "NoSpectrum", "aliasing", "gauge_series", "judge", "judge_one", "spectra"]
