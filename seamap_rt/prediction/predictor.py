"""From turn to turn: maps come in, the wave field that fits the last of them goes out."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from ..compute.machine import pool
from ..physics.dispersion import Water
from ..wavefield.sea_state import TurnSpectrum, systems_of, water_of
from ..wavefield.wave_systems import WaveSystems
from .drift import Drift
from .ensemble import Ensemble
from .field import WaveField
from .fit import Fit
from .innovations import Innovations
from .observations import Observations, of_turn
from .spectrum import spectrum_of_turns

_SHARP, _SURE = 1.0, 0.5  # of a real sea, and how far seas may be from it
_OTHERS = -1  # in place of a turn's number, of observations by other instruments
_FORGOTTEN = 0.9  # of the evidence, from turn to turn


@dataclass
class _Turn:
    """What is kept of a turn."""

    number: int
    seen: Observations
    spectrum: TurnSpectrum | None


class Predictor:
    """Keeps what was seen in the last turns, and the waves that fit it.

    turns: how many; lead_s: how far ahead [s] forecasts are wanted. sharpness: see WaveField; amplitude_dispersion: see
    Spectrum; None: as the maps show.
    """

    def __init__(
        self,
        turns: int = 10,
        lead_s: float = 30.0,
        sharpness: float | None = None,
        amplitude_dispersion: float | None = None,
    ) -> None:
        self._most, self._lead = turns, lead_s
        self._turns: list[_Turn] = []
        self._fit: Fit | None = None
        self._ensemble: Ensemble | None = None
        self._sharpness, self._issued = sharpness, 0.0
        self._drift = Drift(amplitude_dispersion)
        self._count, self._systems = 0, None
        self._innovations = Innovations()
        self._evidence = _SURE**-2 * np.array([_SHARP, 1.0])

    def turn(self, polar: xr.Dataset) -> WaveField | None:
        """The field after one more turn's polar map; None while no turn of the last ones shows a sea."""
        water = self._drift.water(water_of(polar.attrs))
        number = int(polar["turn"])
        shown = TurnSpectrum.of(polar, water)
        self._turns = [turn for turn in self._turns if number - self._most < turn.number < number]
        known = [turn.spectrum for turn in self._turns if turn.spectrum] + ([shown] if shown else [])
        spectrum = spectrum_of_turns(known, water, self._found(known, water))
        if spectrum is None:
            self._fit, self._turns = None, []
            return None
        spectrum = replace(spectrum, amplitude_dispersion=self._drift.amplitude_dispersion)
        seen = of_turn(polar, np.sqrt(spectrum.variance))
        self._turns.append(_Turn(number, seen, shown))
        if not any(len(turn.seen) for turn in self._turns):
            self._fit = None
            return None
        centre = _centre(polar)
        weighed: Future[None] | None = None
        with pool() as workers:
            if self._fit is not None and self._fit.suits(spectrum, centre):
                self._fit.keep({t.number for t in self._turns})
                self._fit.add([seen], [number])
                if self._drift.learn(self._fit, number):
                    water, share = self._drift.water(water_of(polar.attrs)), self._drift.amplitude_dispersion
                    spectrum = replace(spectrum, water=water, amplitude_dispersion=share)
                    self._fit, self._innovations = None, Innovations()  # older ones are of waves that ran wrong
            if self._fit is None or self._ensemble is None or not self._fit.suits(spectrum, centre):
                seconds = self._lead + self._most * float(np.ptp(polar["time"].values))
                self._fit = Fit.anew(spectrum, [t.seen for t in self._turns], seconds, centre)
                self._fit.add([t.seen for t in self._turns], [t.number for t in self._turns])
                self._fit.settle(workers)
                self._learn(self._fit, None)
                self._fit.relabel(self.sharpness)
                self._ensemble = Ensemble(self._fit)
            else:
                self._fit.renew(spectrum, centre)
                self._learn(self._fit, number)
                self._fit.relabel(self.sharpness, number)
                weighed = workers.submit(self._innovations.compare, self._fit, number)
            self._issued = float(polar["time"].max())
            self._ensemble.settle(self._fit, self._issued, workers)
            if weighed:
                weighed.result()
        made = self._field(self._fit, self._ensemble)
        self._innovations.remember(made)
        return made

    def _found(self, known: list[TurnSpectrum], water: Water) -> WaveSystems | None:
        """The wave systems in the last turns, looked for again with each second, fourth … turn, then each fourth."""
        self._count += 1
        shown = [each for each in known if each.shown]
        if shown and (self._systems is None or len(shown) & (len(shown) - 1) == 0 or self._count % 4 == 0):
            self._systems = systems_of(shown, water, self._systems)
        return self._systems

    def _field(self, fit: Fit, ensemble: Ensemble) -> WaveField:
        return fit.field(self._issued, self.sharpness, ensemble.members, self._innovations.model_error(fit))

    def also(self, seen: Observations) -> WaveField:
        """The field with observations of other instruments taken up too; the last turn's end stays its time.

        Raises ValueError before the first turn that shows a sea.
        """
        if self._fit is None or self._ensemble is None:
            raise ValueError("no turn has shown a sea yet")
        self._fit.add([seen], [_OTHERS])
        with pool() as workers:
            self._fit.weigh()
            self._fit.settle(workers)
            self._fit.relabel(self.sharpness, _OTHERS)
            self._ensemble.settle(self._fit, self._issued, workers)
        return self._field(self._fit, self._ensemble)

    @property
    def sharpness(self) -> float:
        """How far water is moved by its own waves, see WaveField."""
        if self._sharpness is not None:
            return self._sharpness
        return float(np.clip(self._evidence[0] / self._evidence[1], 0.0, 1.0))

    def _learn(self, fit: Fit, number: int | None) -> None:
        """Takes up what the observations of one turn, or of all, say of the sharpness."""
        self._evidence = _FORGOTTEN * self._evidence + (1.0 - _FORGOTTEN) * _SURE**-2 * np.array([_SHARP, 1.0])
        self._evidence = self._evidence + fit.shift_evidence(number)


def _centre(polar: xr.Dataset) -> tuple[float, float]:
    """Where the antennas were at the end of a turn, m."""
    if "antenna_x" not in polar:
        return 0.0, 0.0
    last = int(np.argmax(polar["time"].values))
    x, y = (float(np.nan_to_num(polar[name].values[last])) for name in ("antenna_x", "antenna_y"))
    return x, y
