"""One frozen model per section of a scene file: limits, default, unit and meaning of every key.

Keys carry their unit as a suffix; unknown keys are refused. A check that needs one section alone stands beside that
section. Settings lie below `radar`, `scattering`, `sea` and `mesh`, which take them as arguments; checks across
sections need those subpackages, so they lie above them, in `seamap_rt.scene`: two on purpose.
"""

# ruff: noqa: F401 - the names of the package
from .platform import GaugeSettings, ObjectSettings, PlatformSettings, SensorErrors, SensorSettings
from .processing import PredictionSettings, QuietSettings, RetrievalSettings, VesselSettings
from .radar import WIDEST_DEG, AntennaSettings, PlacedAntenna, RadarSettings, ReceiverSettings
from .sea import (
    DEFAULT_RESOLUTION_M,
    HIGHEST_SEA_M,
    MOST_POINTS_A_SIDE,
    PERIODS_S,
    ElfouhailyWaves,
    FileWaves,
    FlatWaves,
    GrowingWaves,
    JonswapWaves,
    PiersonMoskowitzWaves,
    RandomWaves,
    SeaSettings,
    SinusoidWaves,
    SpectralWaves,
    SpreadWaves,
    TmaWaves,
    WaveSystem,
    check_grid,
)
from .section import Meaning, Section, When, as_tuple, meaning_of
from .surface import ScatteringSettings, TracingSettings
