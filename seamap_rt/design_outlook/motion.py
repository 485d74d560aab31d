"""What the boat's motion, and the error with which her sensors tell it, cost: closed forms over moments of the motion.

A boat that leans by τ along a look lifts the beam by τ. The echo of a grazing angle ψ is weighed by the two-way
pattern at −ψ − τ instead of −ψ: a Gaussian beam of −3 dB width B, level over a far sea, loses
5 log₁₀(1 + 16 ln 2 σ²/B²) dB in the mean over a normal lean of rms σ (0.6 dB at σ = B/6), and more where power lacks
already, as a cell must stand over the noise by itself. The antennas rise and fall by heave and by the lever's lean.

Motion that is known costs no height: the retrieval levels each pulse. What is measured wrong does. At a range R errors
δα of the attitude along the look, δψ of the heading, δz and δh of the place up and in either direction make

    ⟨δheight²⟩ = R²⟨δα²⟩ + ⟨δz²⟩ + 2 ∫ S(k) C²(k) (1 − J₀(k d)) dk,    d² = 2⟨δh²⟩ + R²⟨δψ²⟩,

the last of which is what the surface differs by between places d apart, in means over a cell (C): slope times d where d
is small, twice the variance where it is large. Each mean square is that of bias, latency and interpolation between
readings over the motion, and of the noise of one reading times what a height keeps of it
(`interferometry.error_covariance`). The mean plane of a map stays in its heights: it levels no tilt away.

Motion is as given: a taller mast, whose weight makes a boat roll more, is not heavier here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray
from scipy.special import j0

from ..conventions import unit_from_azimuth, wrap_degrees, written
from ..interferometry.error_covariance import variance_kept
from ..io.motionfile import read_motion
from ..physics import dispersion
from ..radar.installation import Installation
from ..radar.platform import Sensors, boat_motion
from ..radar.pose import boat_axes
from ..scene import Scene
from ..sea import Sea
from ..sea.wave_trains import Components
from ..settings import PlatformSettings, RadarSettings, SeaSettings, SensorSettings
from .error import Design
from .strips import STARTS, Waves, azimuths, directions

Array = NDArray[np.float64]

_TIMES, _STEP_S = 200, 1.618  # at which a motion without end is looked at
_STREAM = 7


class BoatWaves(NamedTuple):
    """The waves that a boat rides, of random phases; current [m/s] east, north."""

    waves: Waves
    sea: SeaSettings

    @property
    def current(self) -> tuple[float, float]:
        east, north = unit_from_azimuth(self.sea.current_toward_deg)
        return float(self.sea.current_m_s * east), float(self.sea.current_m_s * north)

    def components(self) -> Components:
        """One wave for four wavenumbers and four directions."""
        k = np.sqrt(self.waves.wavenumber[1::4] * self.waves.wavenumber[2::4])
        toward = 0.5 * (directions()[1::4] + directions()[2::4])
        variance = self.waves.variance.reshape(k.size, 4, toward.size, 4).sum(axis=(1, 3)).ravel()
        east, north = (np.outer(k, each).ravel() for each in unit_from_azimuth(toward))
        phase = np.random.default_rng(_STREAM).random(variance.size)
        omega = np.repeat(dispersion.angular_frequency(k, self.sea.depth_m), toward.size)
        drift = self.current[0] * east + self.current[1] * north
        amplitude = np.sqrt(2.0 * variance) * np.exp(2j * np.pi * phase)
        return Components(east, north, omega + drift, np.ones(variance.size), amplitude)


@dataclass(frozen=True)
class Motion:
    """Of a boat and its sensors. rise (place,) m, of the antennas over their height at rest at as many moments as a
    strip has places; lean (place · look,) rad, upwards along each look then; tilt_rms: rad along a look.

    Mean squares of errors that do not average out: attitude (look,) rad² along each look, heading rad², up m², aside
    m² in one direction; noise: of one reading in the same order; readings: a second; dwell_s: of a look.
    """

    rise: Array
    lean: Array
    tilt_rms: float
    attitude: Array
    heading: float
    up: float
    aside: float
    noise: tuple[float, float, float, float]
    readings: float
    dwell_s: float

    @classmethod
    def of(cls, scene: Scene, radar: RadarSettings, waves: Waves) -> Motion | None:
        """None for a boat that keeps still and upright and knows it. radar: as it looks."""
        turning = scene.resolved_retrieval.cell_azimuth_deg / (6.0 * radar.rotation_rpm)
        dwell_s = radar.stare_s if radar.scan == "staring" else turning
        platform = scene.platform
        sensors = platform.sensors
        upright = platform.motion == "fixed" and not (platform.list_deg or platform.trim_deg)
        if upright and sensors == SensorSettings():
            return None
        motion = boat_motion(platform, cast(Sea, BoatWaves(waves, scene.sea)))  # which has what a boat asks of a sea
        times = _times(platform)
        quiet = sensors.model_copy(update=dict.fromkeys(_NOISE, 0.0))
        installation = Installation(radar, platform, motion, Sensors(quiet, motion, scene.seed))
        true, measured = installation.pose(times), installation.sensed.pose(times)
        place, turned = measured.origin - true.origin, np.radians(wrap_degrees(measured.attitude - true.attitude))
        look = azimuths()
        lean = _lean(true.attitude, look)
        wrong = _lean(measured.attitude - (0.0, 0.0, 1.0) * (measured.attitude - true.attitude), look) - lean
        leaning = _quantiles(lean, ((7 * np.arange(look.size)) % look.size + 0.5) / look.size)
        leaning[:, ::2] = leaning[::-1, ::2]  # so that the mast stands high as often when it leans forth as back
        return cls(
            rise=_quantiles(true.origin[:, 2:] - radar.height_m, np.array([0.5]))[:, 0],
            lean=leaning.ravel(),
            tilt_rms=float(np.sqrt(np.mean(lean**2))),
            attitude=np.mean(wrong**2, axis=0),
            heading=float(np.mean(turned[:, 2] ** 2)),
            up=float(np.mean(place[:, 2] ** 2)),
            aside=float(0.5 * np.mean(np.sum(place[:, :2] ** 2, axis=1))),
            noise=(
                float(np.radians(sensors.attitude_noise_deg)) ** 2,
                float(np.radians(sensors.heading_noise_deg)) ** 2,
                sensors.position_noise_m**2,
                sensors.position_noise_m**2,
            ),
            readings=min(sensors.rate_hz, radar.prf_hz),
            dwell_s=dwell_s,
        )

    def in_words(self, design: Design, waves: Waves) -> str:
        """Its two sizes: the lean, and the heights' error by the sensors at 100 m or the window's end."""
        at = float(min(100.0, design.ranges[-1]))
        near = int(np.abs(design.ranges - at).argmin())
        wrong = float(np.sqrt(np.mean(self.height_variance(design, waves)[:, near])))
        lean = written(float(np.degrees(self.tilt_rms)), 1)
        return f"{lean}° rms of lean along a look, {written(wrong, 2)} m rms of height at {at:.0f} m by its sensors"

    def height_variance(self, design: Design, waves: Waves) -> Array:
        """Variance [m²] (look, gate) of the heights by the sensors' errors."""
        ground, k = design.ground, waves.wavenumber
        averaged = variance_kept(self.readings * self.dwell_s)
        attitude, heading, up, aside = (each * averaged for each in self.noise)
        away = np.sqrt(2.0 * (self.aside + aside) + ground**2 * (self.heading + heading))
        variance = waves.variance.sum(axis=1) * np.sinc(k * design.cell_m / (2.0 * np.pi)) ** 2
        displaced = 2.0 * (1.0 - j0(np.outer(away, k))) @ variance
        return ground**2 * (self.attitude[:, None] + attitude) + self.up + up + displaced


_NOISE = ("attitude_noise_deg", "heading_noise_deg", "position_noise_m")


def _times(platform: PlatformSettings) -> Array:
    """At which a motion is looked at: of a recorded one those at which its sensors know it."""
    if platform.motion != "file":
        return _STEP_S * np.arange(_TIMES if platform.motion != "fixed" else 1, dtype=np.float64)
    assert platform.file is not None
    time = read_motion(platform.file).time
    early = platform.sensors.latency_s + 1.0 / platform.sensors.rate_hz
    return np.linspace(min(time[0] + early, time[-1]), time[-1], _TIMES)


def _lean(attitude_deg: Array, look_deg: Array) -> Array:
    """Rad (time, look) by which what is level on the boat looks up towards each azimuth."""
    east, north = unit_from_azimuth(look_deg)
    up = boat_axes(attitude_deg)[:, 2]
    return -np.arctan((up[:, :1] * east + up[:, 1:2] * north) / up[:, 2:])


def _quantiles(values: Array, offset: Array) -> Array:
    """(STARTS, look) evenly spaced quantiles of values (time, look), each look's set off by its own offset (look,)."""
    share = (np.arange(STARTS)[:, None] + np.broadcast_to(offset, values.shape[1:])) / STARTS
    return np.stack([np.quantile(values[:, n], share[:, n]) for n in range(values.shape[1])], axis=1)
