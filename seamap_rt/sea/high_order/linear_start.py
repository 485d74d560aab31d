"""The linear waves of a sea as the beginning of a nonlinear one: on which rectangle they repeat, and their state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ..surface import Sea
from ..wave_trains import LineTrain, PlaneTrain, RegularTrain, WaveTrain
from .basin import Band
from .evolution import State

_OFF_LATTICE = 1e-6  # of a wavenumber step: so far a regular wave may be from one that repeats on the patch
_ALONG_AN_AXIS = 1e-9


@dataclass(frozen=True)
class LinearStart:
    """Linear waves on the rectangle on which they repeat, which is the scene's patch; of waves that all run along one
    axis, one line of it (of long-crested systems: four sides long).

    Raises InputError for waves that repeat on no such rectangle.
    """

    sea: Sea
    extent: float  # m, side of the patch
    depth: float  # m

    def __post_init__(self) -> None:
        if not self.sea.trains:
            raise InputError("sea.waves: has no waves, and a level sea stays level; give a [[sea.waves]]")
        lines = [train for train in self.sea.trains if isinstance(train, LineTrain)]
        if lines and not any(self.axes):
            raise InputError(
                "sea.waves: long-crested waves repeat on a nonlinear sea's patch only if all waves run along one axis; "
                "set wave_from_deg to 270, 90, 0 or 180, or give every system another spreading"
            )
        for train in self.sea.trains:
            if isinstance(train, RegularTrain):
                _indices(train, self.lengths)

    @property
    def axes(self) -> tuple[bool, bool]:
        """Whether all waves run along x, or all along y."""
        towards = [None if isinstance(train, PlaneTrain) else train.toward for train in self._known]
        return tuple(
            all(toward is not None and abs(toward[across]) < _ALONG_AN_AXIS for toward in towards) for across in (1, 0)
        )  # type: ignore[return-value]

    @property
    def _known(self) -> list[PlaneTrain | LineTrain | RegularTrain]:
        return [train for train in self.sea.trains if isinstance(train, PlaneTrain | LineTrain | RegularTrain)]

    @property
    def lengths(self) -> tuple[float, float]:
        """Of the rectangle along x and y, m."""
        longest = max((train.lattice.length for train in self._known if isinstance(train, LineTrain)), default=0.0)
        length = max(self.extent, longest)
        return length, length

    def band(self, spacing: float) -> Band:
        """All waves that points so far apart [m] can carry."""
        length_x, length_y = self.lengths
        along_x, along_y = self.axes
        most_x, most_y = (int(np.ceil(0.5 * length / spacing - 1e-9)) - 1 for length in self.lengths)
        return Band(length_x, length_y, 0 if along_y else most_x, 0 if along_x else most_y, self.depth)

    def state(self, band: Band, time: float) -> State:
        """The linear waves at a time [s], as far as the band carries them."""
        rows, columns = band.most_y, band.most_x
        amplitude = np.zeros((2 * rows + 1, 2 * columns + 1), dtype=np.complex128)
        for train in self._known:
            _add(amplitude, train, self.lengths)
        whole = np.concatenate((np.arange(rows + 1), np.arange(-rows, 0))) + rows
        ahead = 0.5 * amplitude[whole][:, columns:]
        behind = 0.5 * np.conj(amplitude[::-1, ::-1])[whole][:, columns:]
        turned = np.exp(-1j * np.remainder(band.omega * time, 2.0 * np.pi))
        ahead, behind = ahead * turned, behind * np.conj(turned)
        speed = band.omega / np.where(band.rise > 0.0, band.rise, np.inf)
        return State(time, ahead + behind, -1j * speed * (ahead - behind))


def _add(amplitude: NDArray[np.complex128], train: WaveTrain, lengths: tuple[float, float]) -> None:
    """Add a train's waves, those that the array carries, to the amplitudes (ky, kx) of −m … m."""
    if isinstance(train, RegularTrain):
        column, row = _indices(train, lengths)
        given, at = np.array([[train.amplitude * np.exp(1j * train.phase)]]), (row, column)
    elif isinstance(train, LineTrain):
        east, north = (round(part) for part in train.toward)
        given, at = train.amplitude[:, :: east or north], (0, 0)
        given = given if east else given.T
    else:
        assert isinstance(train, PlaneTrain)
        given, at = train.amplitude, (0, 0)
    here, there = [], []
    for size, number, shift in zip(amplitude.shape, given.shape, at, strict=True):
        most, reach = size // 2, number // 2
        low, high = max(-most, shift - reach), min(most, shift + reach)
        if low > high:
            return
        here.append(slice(low + most, high + most + 1))
        there.append(slice(low - shift + reach, high - shift + reach + 1))
    amplitude[tuple(here)] += given[tuple(there)]


def _indices(train: RegularTrain, lengths: tuple[float, float]) -> tuple[int, int]:
    """How often a regular wave repeats along x and y."""
    turns = train.wavenumber / (2.0 * np.pi)
    exact = [turns * part * length for part, length in zip(train.toward, lengths, strict=True)]
    whole = tuple(round(number) for number in exact)
    if any(abs(number - near) > _OFF_LATTICE * max(1, abs(near)) for number, near in zip(exact, whole, strict=True)):
        raise InputError(
            f"sea.waves: a regular wave of {1.0 / turns:.6g} m repeats {exact[0]:.4g} × {exact[1]:.4g} times on a "
            f"nonlinear sea's patch of {lengths[0]:.6g} m, must do so a whole number of times; set extent_m, "
            "wavelength_m and wave_from_deg so"
        )
    return whole[0], whole[1]
