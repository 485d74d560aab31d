"""Free waves on a square lattice of wavevectors, each of which obeys the dispersion relation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..physics.dispersion import Water
from .spectrum import Spectrum

Field = NDArray[np.float64]

_LONG_SIDE, _SHORT_SIDE = 153, 101  # modes a side: as fine as a turn's time lets; both near what FFTs like
_NEAR = 0.3  # of the reach: short waves are slow, and matter where they are soon met
_LEAST_LEFT = 0.004  # of the sea's variance: waves shorter than hold that are left out
_SHORTEST_M = 4.0  # of waves that radars of some metres' resolution tell apart
_FAST = 1.25  # times the peak's period: of longer waves there is next to nothing
_APART = 4.0  # of the peak's wavelengths: so far apart, waves of narrow spectra hardly know of each other


@dataclass(frozen=True)
class Lattice:
    """Wavevectors (n, n), n odd and the middle 0, of a square of 2π/spacing a side, that waves within `radius` m of the
    centre use."""

    spacing: float  # rad/m
    kx: Field  # rad/m, east
    ky: Field
    k: Field
    frequency: Field  # rad/s, intrinsic
    omega: Field  # rad/s, over ground
    scale: Field  # m, standard deviation of each part of the complex amplitude; 0 of waves that are not carried
    band: tuple[float, float]  # rad/m, of the waves that it carries
    radius: float

    @classmethod
    def of(cls, spectrum: Spectrum, side: int, spacing: float, band: tuple[float, float], radius: float) -> Lattice:
        """Waves of wavenumbers in a band [rad/m] with the variances of a spectrum."""
        step = spacing * (np.arange(side, dtype=np.float64) - side // 2)
        kx, ky = np.meshgrid(step, step, indexing="ij")
        k = np.hypot(kx, ky)
        moving = np.where(k > 0.0, k, spacing)
        frequency = np.where(k > 0.0, spectrum.water.frequency(moving), 0.0)
        omega = np.where(k > 0.0, spectrum.omega(kx, ky, moving), 0.0)
        return cls(spacing, kx, ky, k, frequency, omega, np.zeros(k.shape), band, radius).rescaled(spectrum)

    def rescaled(self, spectrum: Spectrum) -> Lattice:
        """The same waves with the variances of another spectrum."""
        carried = (self.k > max(self.band[0], 0.5 * self.spacing)) & (self.k <= self.band[1])
        density = np.where(carried, spectrum.density(self.kx, self.ky), 0.0)
        # η = Re Σ a e^j(k·x − ωt): a wave's variance is |a|²/2, that of either part of a.
        return replace(self, scale=np.sqrt(density) * self.spacing)

    @property
    def variance(self) -> float:
        """m², of the sea that it carries."""
        return float(np.sum(self.scale**2))

    def sinking(self, water: Water) -> float:
        """m, how far the mean level would sink if water that is at home on a level moved with these waves: ⟨D·∇η⟩ of
        first-order Lagrangian waves."""
        k = np.where(self.k > 0.0, self.k, 1.0)
        return float(np.sum(self.scale**2 * self.k / np.tanh(np.minimum(k * water.depth, 300.0))))

    def factor(self, kind: str, water: Water) -> NDArray[np.complex128]:
        """What a kind of observation, or a displacement of the water, is of a wave's amplitude."""
        return factor(kind, self.kx, self.ky, self.k, self.frequency, water)


def factor(kind: str, kx: Field, ky: Field, k: Field, frequency: Field, water: Water) -> NDArray[np.complex128]:
    """What a kind of observation, or a displacement of the water, is of the amplitude of waves of some wavevectors
    [rad/m] and intrinsic frequencies [rad/s]; all of one shape."""
    moving = np.where(k > 0.0, k, 1.0)
    name, _, axis = kind.partition("_")
    if name == "elevation":
        return np.ones(k.shape, np.complex128)
    along = ky if axis == "y" else kx
    if name == "slope":
        return np.asarray(1j * along, np.complex128)
    if kind == "velocity_z":
        return np.asarray(-1j * frequency, np.complex128)
    orbit = along / moving / np.tanh(np.minimum(moving * water.depth, 300.0))
    return np.asarray(1j * orbit if name == "displacement" else frequency * orbit, np.complex128)


def fastest(spectrum: Spectrum) -> float:
    """m/s over ground, of the longest groups of waves."""
    water = spectrum.water
    speed = water.group_speed(water.wavenumber(2.0 * np.pi / (_FAST * spectrum.peak_period)))
    return float(speed) + float(np.hypot(*water.current))


def lattices(spectrum: Spectrum, reach: float, seconds: float) -> list[Lattice]:
    """Long waves over all the water that is seen, and short ones near by.

    reach: m, of what is seen; seconds: from the first observation to the last forecast. The sea is periodic: the square
    is so wide that nothing that is seen on one side comes in at the other within that time, nor is so near to what does
    that the fit takes the one from the other.
    """
    water = spectrum.water
    end = min(spectrum.wavenumber_above(_LEAST_LEFT), 2.0 * np.pi / _SHORTEST_M)
    length = 2.0 * np.pi / float(water.wavenumber(2.0 * np.pi / spectrum.peak_period))
    spacing = 2.0 * np.pi / (2.0 * reach + fastest(spectrum) * seconds + _APART * length)
    edge = min(end, spacing * (_LONG_SIDE // 2))
    side = 2 * int(np.ceil(edge / spacing)) + 1
    long = Lattice.of(spectrum, side, spacing, (0.0, edge), np.inf)
    if edge >= end:
        return [long]
    near = max(_NEAR * reach, 60.0)
    slow = float(water.group_speed(edge)) + float(np.hypot(*water.current))
    spacing = 2.0 * np.pi / (2.0 * near + slow * seconds)
    end = min(end, spacing * (_SHORT_SIDE // 2))
    if edge >= end:
        return [long]
    side = 2 * int(np.ceil(end / spacing)) + 1
    return [long, Lattice.of(spectrum, side, spacing, (edge, end), near)]
