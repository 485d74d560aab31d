"""The looks of one turn: which pulses each has, how the antennas stood, and the interferograms that they make."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..radar.grid import look_sweeps
from ..settings import RetrievalSettings
from .ambiguity import HeightEstimate
from .description import RadarDescription, compared_receivers, transmitters
from .dwell_sums import DwellSums, PulseComparison
from .dwells import Dwells
from .estimators import single_cell
from .interferogram import AROUND, BLURRED_GATES, LASTING, EchoPower, Interferogram
from .poses import LookPoses, PhaseModel, PulsePoses
from .products import PulsePairs
from .speckle import DwellPulses, pulse_coherence_kept
from .velocity import Lag, beam_passage
from .windows import pulse_correlation

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Looks:
    """One turn's pulses, and how they are shared out."""

    voltage: NDArray[np.complex64]  # (pulse, receiver, gate)
    transmitter: NDArray[np.integer]
    pulses: PulsePoses
    dwells: Dwells
    antennas: tuple[int, int]  # of the receivers that are compared
    sweeps: NDArray[np.float64]  # deg from the sector's start, centres of the looks
    width: float  # deg
    radar: RadarDescription
    settings: RetrievalSettings

    @classmethod
    def of(cls, echoes: xr.Dataset, radar: RadarDescription, settings: RetrievalSettings) -> Looks:
        """From echoes that keep the schema: their pulses sorted into looks of the settings' cell width."""
        sweeps = look_sweeps(radar.sector, settings.cell_azimuth_deg, radar.staring)
        width = float(sweeps[1] - sweeps[0]) if sweeps.size > 1 else settings.cell_azimuth_deg
        antennas = compared_receivers(echoes, radar, settings.receivers)
        pulses = PulsePoses.of(echoes, radar)
        return cls(
            np.asarray(echoes["voltage"].data),
            np.asarray(echoes["transmitter"].values),
            pulses,
            pulses.dwells(radar, antennas[0], sweeps, width),
            antennas,
            sweeps,
            width,
            radar,
            settings,
        )

    @property
    def passage(self) -> float:
        """Time constant [s] by which the turning beam leaves what it hears."""
        return np.inf if self.radar.staring else beam_passage(self.radar.azimuth_beamwidth, self.radar.period)

    def model(self, pairs: PulsePairs, paths: int) -> PhaseModel:
        """What phases mean, by how the antennas stood on the very pulses that are compared."""
        same = all(np.array_equal(n, m) for n, m in pairs.pairs)
        rows, owners = (pairs.lower, pairs.lower) if same else pairs.members
        senders = self._senders(pairs, paths, same)
        every = same and rows.size == self.pulses.time.size
        pulses, dwells = (self.pulses, self.dwells) if every else (self.pulses[rows], self.dwells[owners])
        poses = LookPoses.of(pulses, dwells, self.antennas, senders, self.radar.sector[0])
        return PhaseModel(self.radar, poses, paths)

    def level_of(self, senders: tuple[int, ...]) -> NDArray[np.float64]:
        """Phase (pulse, gate) of mean sea level on each pulse, of one way."""
        each = Dwells.of_single_pulses(self.pulses.time.size)
        poses = LookPoses.of(self.pulses, each, self.antennas, senders, self.radar.sector[0])
        flat = np.nan_to_num(PhaseModel(self.radar, poses, 1).flat)  # one row where the antennas stand still
        return np.broadcast_to(flat, (self.pulses.time.size, flat.shape[1]))

    def senders(self, pairs: PulsePairs, paths: int) -> tuple[int, ...]:
        """The antennas that send what is compared."""
        return self._senders(pairs, paths, all(np.array_equal(n, m) for n, m in pairs.pairs))

    def _senders(self, pairs: PulsePairs, paths: int, same: bool) -> tuple[int, ...]:
        rows = None if same else (pairs.lower, pairs.upper)
        return transmitters(self.transmitter, self.antennas, rows, paths)


def interferogram(looks: Looks) -> tuple[Interferogram, tuple[Lag, ...]]:
    """The interferogram of the most ways that the echoes hold, and what the voltages do from pulse to pulse.

    Where they hold that of one way as well, it resolves the cycles of the other, which are twice as narrow.
    """
    radar, settings = looks.radar, looks.settings
    times = looks.pulses.time
    paired = PulseComparison.of(looks.voltage, looks.transmitter, times, looks.antennas, radar, settings)
    pairs = {paths: each for paths, each in ((1, paired.one), (2, paired.two)) if each is not None}
    models = {paths: looks.model(each, paths) for paths, each in pairs.items()}
    levels = None
    if not all(model.poses.at_rest for model in models.values()):
        senders = {paths: looks.senders(each, paths) for paths, each in pairs.items()}
        level = {each: looks.level_of(each) for each in set(senders.values())}
        levels = {paths: paths * level[each] for paths, each in senders.items()}
    sums = DwellSums.of(
        looks.voltage, looks.transmitter, times, paired, looks.dwells, looks.antennas, radar, settings, levels
    )
    made = _interferograms(looks, sums, pairs, models, rotated=levels is not None)
    both = _coherent(sums, radar.noise_power) and _resolves_pulse(made[max(made)].model)
    return made[max(made) if both else min(made)], sums.lags


def _resolves_pulse(model: PhaseModel) -> bool:
    """Whether in most gates the phase of mean sea level turns little within a pulse's length: below a high mast that of
    both ways is blurred where that of one way is not."""
    return bool(np.mean(model.turn_within_pulse > 1.0) < BLURRED_GATES)


def _coherent(sums: DwellSums, noise_power: float) -> bool:
    """Whether echoes last from one pulse to the next: of both ways two pulses are compared."""
    if not sums.lags:
        return True
    products = sums.lags[0].products
    with np.errstate(invalid="ignore"):
        clean = np.sqrt(np.maximum(products.lower - noise_power, 0.0) * np.maximum(products.upper - noise_power, 0.0))
    return bool(np.nansum(np.abs(products.cross)) >= LASTING * np.nansum(clean))


def _interferograms(
    looks: Looks, sums: DwellSums, pairs: Mapping[int, PulsePairs], models: Mapping[int, PhaseModel], rotated: bool
) -> dict[int, Interferogram]:
    made: dict[int, Interferogram] = {}
    pulses = next(each for each in (sums.one, sums.two) if each is not None)
    echo = EchoPower(pulses, sums.noise_power, looks.radar, looks.width)
    dwelt = _median_dwell(looks, pairs[max(pairs)].lower, sums.noise_power)
    for paths, covariance in ((1, sums.one), (2, sums.two)):
        if covariance is None:
            continue
        if rotated:
            covariance = covariance.rotated(np.nan_to_num(models[paths].flat))
        others = _expected_from(made[1]) if 1 in made else tuple
        often = pairs[paths].lower.size / max(1, pairs[max(pairs)].lower.size)
        made[paths] = Interferogram(
            covariance,
            echo,
            models[paths],
            dwelt.resample(often),
            sums.noise_square[paths],
            looks.settings,
            _coherence_left(sums, pairs[paths], looks.radar),
            others,
        )
    return made


def _coherence_left(sums: DwellSums, pairs: PulsePairs, radar: RadarDescription) -> NDArray[np.float64] | float:
    """Share (look, gate) of the echo that is left between the pulses that are compared; 1 of the same ones."""
    if len(pairs.pairs) < 2 or not sums.lags:
        return 1.0
    lag = sums.lags[0]
    # Products of pulses are of both receivers as they were recorded, and so is their noise.
    return pulse_coherence_kept(lag.products.windowed(*AROUND), radar.noise_power, radar.interval / lag.seconds)


def _median_dwell(looks: Looks, rows: NDArray[np.intp], noise_power: float) -> DwellPulses:
    """Pulses of the median look, of those that are compared, and their speckle's correlation."""
    look = looks.pulses.looks(looks.sweeps, looks.width)
    of_look = look[rows][look[rows] >= 0]
    pulses = max(1, int(np.median(np.bincount(of_look)))) if of_look.size else 1
    correlation = pulse_correlation(looks.voltage, look, noise_power, pulses - 1, rows, looks.settings.receivers[0])
    return DwellPulses(pulses, correlation, looks.sweeps.size)


def _expected_from(coarse: Interferogram) -> Callable[[], tuple[HeightEstimate, ...]]:
    """Heights of another interferogram, made on demand."""

    @lru_cache(maxsize=1)
    def others() -> tuple[HeightEstimate, ...]:
        resolved = single_cell(coarse)
        std = np.where(resolved.ambiguous, np.nan, resolved.std)
        return (HeightEstimate(resolved.heights.height, std),)

    return others
