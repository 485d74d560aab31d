"""One frozen model per section of a scene file. Each limit carries its reason; unknown keys are refused.

Keys carry their unit as a suffix. Checks that need only one section live here; checks across sections live in scene.py.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Discriminator, model_validator

from .conventions import unit_from_azimuth


def limited(
    reason: str,
    *,
    above: float | None = None,
    least: float | None = None,
    below: float | None = None,
    most: float | None = None,
    infinite: bool = False,
) -> AfterValidator:
    """A validator for a number within limits, whose message gives the limit and why it is there."""

    def check(value: float) -> float:
        if math.isnan(value):
            raise ValueError("is not a number; give a finite value")
        if math.isinf(value) and not infinite:
            raise ValueError("must be finite")
        for limit, broken, words in (
            (above, above is not None and value <= above, "must be greater than"),
            (least, least is not None and value < least, "must be at least"),
            (below, below is not None and value >= below, "must be less than"),
            (most, most is not None and value > most, "must be at most"),
        ):
            if broken:
                raise ValueError(f"{words} {limit:g} ({reason})")
        return value

    return AfterValidator(check)


def as_tuple(value: object) -> object:
    """TOML has lists where the settings are frozen."""
    return tuple(value) if isinstance(value, list) else value


def _pair(
    check: Callable[[tuple[float, float]], tuple[float, float]],
) -> tuple[BeforeValidator, AfterValidator]:
    return BeforeValidator(as_tuple), AfterValidator(check)


class Section(BaseModel):
    """A section of a scene file: frozen, strict about types, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, validate_default=False)


# ---------------------------------------------------------------------------------------------------- sea

Direction = Annotated[float, limited("a compass direction", least=-360.0, most=360.0)]


class FlatWaves(Section):
    """No waves at all."""

    spectrum: Literal["flat"]


class SinusoidWaves(Section):
    """One regular wave, η = (height_m/2) cos(k·x − ωt + phase)."""

    spectrum: Literal["sinusoid"]
    height_m: Annotated[float, limited("crest to trough; 0 is flat", least=0.0, most=50.0)]
    wavelength_m: Annotated[float, limited("a wave has a length", above=0.0, most=1e5)]
    phase_deg: Annotated[float, limited("a phase", least=-3600.0, most=3600.0)] = 0.0
    wave_from_deg: Direction = 270.0

    @model_validator(mode="after")
    def _not_broken(self) -> Self:
        if self.height_m / self.wavelength_m > 0.142:
            raise ValueError(
                f"height_m/wavelength_m = {self.height_m / self.wavelength_m:.3g}: must be at most 0.142 "
                "(a steeper wave breaks, Michell 1893)"
            )
        return self


class RandomWaves(Section):
    """A wave system that is drawn from a spectrum."""


Spreading = Literal["cos2s", "mitsuyasu", "hasselmann", "donelan_banner", "elfouhaily", "long_crested"]
WindSpeed = Annotated[float, limited("10 m above the sea", above=0.0, most=60.0)]
Fetch = Annotated[float, limited("distance to the windward shore", above=0.0, most=5e6)]


class SpreadWaves(RandomWaves):
    """A main direction, and how the waves spread about it.

    `inverse_wave_age` is U10 over the phase speed of the peak; mitsuyasu, hasselmann and elfouhaily depend on it. Left
    out, it follows from the wind where the system is given by a wind, else it is 0.84, a fully developed sea.
    """

    wave_from_deg: Direction = 270.0
    spreading: Spreading = "cos2s"
    spreading_exponent: Annotated[float, limited("the s of cos^2s(θ/2)", above=0.0, most=500.0)] = 10.0
    inverse_wave_age: (
        Annotated[float, limited("U10 over the peak's phase speed; 0.84 is fully developed", least=0.1, most=10.0)]
        | None
    ) = None


class SpectralWaves(SpreadWaves):
    """A system with a peak, by its height and period or by the wind."""

    significant_wave_height_m: (
        Annotated[float, limited("0 is flat; no sea above 30 m", least=0.0, most=30.0)] | None
    ) = None
    peak_period_s: (
        Annotated[float, limited("wind waves and swell lie between 0.3 and 40 s", least=0.3, most=40.0)] | None
    ) = None
    wind_speed_m_s: WindSpeed | None = None

    @model_validator(mode="after")
    def _one_way_to_say_its_size(self) -> Self:
        by_height = (self.significant_wave_height_m is not None, self.peak_period_s is not None)
        by_wind = self.wind_speed_m_s is not None
        if by_wind == all(by_height) or any(by_height) != all(by_height):
            raise ValueError(
                "give either significant_wave_height_m and peak_period_s, or wind_speed_m_s "
                "(and fetch_m for jonswap and tma), not a mixture"
            )
        return self


class PiersonMoskowitzWaves(SpectralWaves):
    """A fully developed sea (Pierson & Moskowitz 1964), by wind speed or scaled to Hs and Tp."""

    spectrum: Literal["pierson_moskowitz"]


class GrowingWaves(SpectralWaves):
    """A sea with an enhanced peak, by wind and fetch or scaled to Hs, Tp and γ."""

    peak_enhancement: Annotated[float, limited("γ of the JONSWAP spectrum", least=1.0, most=20.0)] = 3.3
    fetch_m: Fetch | None = None

    @model_validator(mode="after")
    def _wind_needs_fetch(self) -> Self:
        if (self.wind_speed_m_s is None) != (self.fetch_m is None):
            raise ValueError("give wind_speed_m_s and fetch_m together: jonswap and tma by wind need both")
        return self


class JonswapWaves(GrowingWaves):
    """A growing sea (Hasselmann et al. 1973)."""

    spectrum: Literal["jonswap"]


class TmaWaves(GrowingWaves):
    """A growing sea in water of finite depth, JONSWAP × Φ (Bouws et al. 1985). Hs is that of the sea itself."""

    spectrum: Literal["tma"]


class ElfouhailyWaves(SpreadWaves):
    """The whole wind sea, from its peak to the ripples (Elfouhaily et al. 1997), by wind and wave age or fetch."""

    spectrum: Literal["elfouhaily"]
    wind_speed_m_s: WindSpeed
    fetch_m: Fetch | None = None
    spreading: Spreading = "elfouhaily"

    @model_validator(mode="after")
    def _one_age(self) -> Self:
        age = self.inverse_wave_age
        if age is not None and self.fetch_m is not None:
            raise ValueError("give fetch_m or inverse_wave_age, not both: each says how old the sea is")
        if age is not None and not 0.8 <= age <= 5.0:
            raise ValueError(
                f"inverse_wave_age = {age:g}: must lie within 0.8 to 5 (Elfouhaily et al. 1997); "
                "0.84 is fully developed"
            )
        return self


class FileWaves(RandomWaves):
    """A measured or modelled directional spectrum, read from a file.

    A relative path counts from the scene file's folder. `time` is ISO text, the nearest one is taken (the first, if it
    is left out); `site` numbers the stations of the file. Beyond the last frequency the spectrum goes on as
    f^−tail_exponent; 0 ends it there.
    """

    spectrum: Literal["file"]
    file: str
    kind: Literal["auto", "ndbc", "swan", "ww3", "wavespectra"] = "auto"
    time: str | None = None
    site: Annotated[int, limited("stations are numbered from 0", least=0)] = 0
    tail_exponent: Annotated[float, limited("a tail falls off; 0 is none", least=0.0, most=12.0)] = 5.0

    @model_validator(mode="after")
    def _tail_holds_little(self) -> Self:
        if 0.0 < self.tail_exponent < 3.0:
            raise ValueError(
                f"tail_exponent = {self.tail_exponent:g}: must be 0 or at least 3 (a flatter tail would hold most "
                "of the waves); 4 to 5 is usual"
            )
        return self


WaveSystem = Annotated[
    FlatWaves | SinusoidWaves | PiersonMoskowitzWaves | JonswapWaves | TmaWaves | ElfouhailyWaves | FileWaves,
    Discriminator("spectrum"),
]

DEFAULT_RESOLUTION_M = 0.8
MOST_POINTS_A_SIDE = 4096


class SeaSettings(Section):
    """The water: its depth, its current, its wave systems, and the finest wave that is resolved.

    Periods and spectra are those that one meets who drifts with the current.
    Waves shorter than twice `resolution_m` are not on the surface but in the scattering. `energy_fraction`, in its
    place, asks for the resolution that keeps this share of all waves' variance.
    """

    model: Literal["linear", "choppy"] = "linear"
    depth_m: Annotated[float, limited("water has a depth; inf is deep", least=0.05, infinite=True)] = math.inf
    resolution_m: Annotated[float, limited("spacing of the resolved waves' grid", above=0.0, most=100.0)] | None = None
    energy_fraction: (
        Annotated[float, limited("share of the waves' variance that is resolved", above=0.0, below=1.0)] | None
    ) = None
    extent_m: Annotated[float, limited("side of the periodic patch", least=10.0, most=20_000.0)] = 1024.0
    current_m_s: Annotated[float, limited("a uniform current", least=0.0, most=10.0)] = 0.0
    current_toward_deg: Direction = 0.0
    waves: Annotated[tuple[WaveSystem, ...], BeforeValidator(as_tuple)] = ()

    @model_validator(mode="before")
    @classmethod
    def _default_resolution(cls, tree: object) -> object:
        if isinstance(tree, dict) and tree.get("resolution_m") is None and tree.get("energy_fraction") is None:
            return {**tree, "resolution_m": DEFAULT_RESOLUTION_M}
        return tree

    @model_validator(mode="after")
    def _one_resolution(self) -> Self:
        if self.resolution_m is not None and self.energy_fraction is not None:
            raise ValueError("give resolution_m or energy_fraction, not both: one follows from the other")
        return self

    @model_validator(mode="after")
    def _grid_fits_memory(self) -> Self:
        if self.resolution_m is not None:
            check_grid(self.extent_m, self.resolution_m)
        return self


def check_grid(extent_m: float, resolution_m: float, energy_fraction: float | None = None) -> None:
    """Raise ValueError unless the grid of resolved waves fits memory and holds waves.

    energy_fraction: the share that asked for the resolution, if it was not given itself.
    """
    side = extent_m / resolution_m
    asked = "" if energy_fraction is None else f"energy_fraction = {energy_fraction!r}: asks for {resolution_m:.3g} m, "
    key = "resolution_m" if energy_fraction is None else "energy_fraction"
    finer, coarser = ("lower", "raise") if energy_fraction is None else ("raise", "lower")
    if side > MOST_POINTS_A_SIDE:
        raise ValueError(
            f"{asked}extent_m/resolution_m = {side:.0f}: must be at most {MOST_POINTS_A_SIDE} (a grid of {side:.0f}² "
            f"points would take {side**2 * 100 / 1e9:.3g} GB); {coarser} {key} or lower extent_m"
        )
    if side < 8:
        raise ValueError(f"{asked}extent_m/resolution_m = {side:.1f}: must be at least 8; {finer} {key}")


# ------------------------------------------------------------------------------------------------ scattering


class ScatteringSettings(Section):
    """How the sea's surface returns the radar's power.

    `two_scale` is theory, facet by facet, whose mean is brought to the measured model `calibrated_to`; `nrl`, `git`,
    `tsc` and `hybrid` are those models' means on every facet that is seen; `constant` is `nrcs_db`.
    """

    nrcs: Literal["two_scale", "nrl", "git", "tsc", "hybrid", "constant"] = "two_scale"
    nrcs_db: Annotated[float, limited("σ0 of nrcs = 'constant'", least=-120.0, most=30.0)] = -40.0
    calibrated_to: Literal["nrl", "git", "tsc", "hybrid", "none"] = "nrl"
    extrapolate: bool = False
    breaking: bool = True
    hydrodynamic_modulation: bool = True
    doppler: Literal["full", "orbital"] = "full"
    polarization: Literal["VV", "HH"] = "VV"
    wind_speed_m_s: Annotated[float, limited("10 m above the sea; drives the short waves", least=0.5, most=40.0)] = 8.0
    wind_from_deg: Direction = 270.0
    inverse_wave_age: Annotated[
        float, limited("0.84 is a fully developed sea, 5 a very young one", least=0.84, most=5.0)
    ] = 0.84
    decorrelation_time_s: Annotated[
        float, limited("5 to 33 ms for a 3 m X-band cell in the literature", least=1e-3, infinite=True)
    ] = 0.010
    permittivity: Literal["meissner_wentz12", "meissner_wentz04", "klein_swift77"] = "meissner_wentz12"
    temperature_c: Annotated[float, limited("range of the permittivity model", least=-2.0, most=34.0)] = 20.0
    salinity_psu: Annotated[float, limited("range of the permittivity model", least=0.0, most=40.0)] = 35.0

    @property
    def mean_model(self) -> str | None:
        """The empirical model that sets the mean, if one does."""
        if self.nrcs == "two_scale":
            return None if self.calibrated_to == "none" else self.calibrated_to
        return None if self.nrcs == "constant" else self.nrcs


# ----------------------------------------------------------------------------------------------------- radar


class AntennaSettings(Section):
    """What an antenna hears: its pattern and its gain.

    `file` holds a measured pattern, CSV or MSI/Planet; a relative path counts from the scene file's folder. A waveguide
    that is fed at its end looks square to its aperture at `design_frequency_hz` alone (left out: the radar's own).
    """

    pattern: Literal["slotted_waveguide", "gaussian", "isotropic", "file"] = "slotted_waveguide"
    file: str | None = None
    azimuth_beamwidth_deg: Annotated[
        float, limited("one-way, −3 dB; three beams to either side must look ahead", above=0.05, most=25.0)
    ] = 1.8
    elevation_beamwidth_deg: Annotated[float, limited("one-way, −3 dB", above=0.5, most=120.0)] = 18.0
    width_m: Annotated[float, limited("aperture width", above=0.0, most=20.0)] = 1.0
    height_m: Annotated[float, limited("aperture height", above=0.0, most=5.0)] = 0.1
    ohmic_loss_db: Annotated[float, limited("a loss is not negative", least=0.0, most=20.0)] = 0.0
    gain_dbi: Annotated[float, limited("overrides directivity − ohmic loss", least=-20.0, most=60.0)] | None = None
    feed: Literal["centre", "end"] = "centre"
    design_frequency_hz: Annotated[float, limited("of an end-fed guide", least=1e9, most=1e11)] | None = None
    guide_width_m: Annotated[float, limited("inner width of the waveguide; WR-90", above=1e-3, most=0.2)] = 0.02286

    @model_validator(mode="after")
    def _a_file_for_its_pattern(self) -> Self:
        if (self.pattern == "file") != bool(self.file):
            raise ValueError("give pattern = 'file' and file = '…' together: one says what the other is for")
        return self


def _offset(value: tuple[float, float, float]) -> tuple[float, float, float]:
    if not all(math.isfinite(part) and abs(part) <= 100.0 for part in value):
        raise ValueError("must be three finite numbers within ±100 m")
    return value


Offset = Annotated[tuple[float, float, float], BeforeValidator(as_tuple), AfterValidator(_offset)]


class PlacedAntenna(AntennaSettings):
    """One of any number of antennas; pattern keys that are left out are those of [radar.antenna].

    `offset_m` is that of its phase centre from the point that stands radar.height_m above the sea: along the aperture
    to the right, along the boresight, up; `offset_error_m` what the true one has more than the one that is known. The
    channel's gain and phase are those of its receiver, which the retrieval does not know.
    """

    offset_m: Offset
    offset_error_m: Offset = (0.0, 0.0, 0.0)
    role: Literal["tx", "rx", "both"] = "both"
    bandwidth_hz: Annotated[float, limited("of the antenna itself", least=1e6, most=1e11)] | None = None
    channel_gain_db: Annotated[float, limited("of its receiver over the others'", least=-20.0, most=20.0)] = 0.0
    channel_phase_deg: Annotated[float, limited("of its receiver over the others'", least=-360.0, most=360.0)] = 0.0


class ReceiverSettings(Section):
    """From the mixer to complex gates: ideal ones (`baseband`), or by sampling the intermediate frequency (`digital`).

    The converter's full scale is that of a sine at the antenna's port. Automatic gain sets it from the echoes of the
    dwell before; the sensitivity-time control weakens what comes from nearer than `stc_range_m` by
    (range/stc_range_m)^stc_exponent in power, and what it took is given back after the converter.
    """

    chain: Literal["baseband", "digital"] = "baseband"
    if_hz: Annotated[float, limited("intermediate frequency", above=0.0, most=1e10)] = 160e6
    adc_rate_hz: Annotated[float, limited("samples per second", least=1e6, most=1e10)] = 200e6
    adc_bits: Annotated[int, limited("a converter has bits; beyond 24 it would be none", least=1, most=24)] = 12
    full_scale_dbm: Annotated[float, limited("of a sine at the antenna's port", least=-120.0, most=30.0)] = -30.0
    gain: Literal["fixed", "agc"] = "fixed"
    agc_headroom_db: Annotated[float, limited("of the full scale over the strongest echo", least=0.0, most=60.0)] = 6.0
    stc_exponent: Annotated[float, limited("0 is none; clutter falls as 3 to 7", least=0.0, most=8.0)] = 0.0
    stc_range_m: Annotated[float, limited("from which on nothing is weakened", above=0.0, most=20_000.0)] = 100.0


def _sector(value: tuple[float, float]) -> tuple[float, float]:
    start, stop = value
    if not (math.isfinite(start) and math.isfinite(stop)) or abs(start) > 360.0:
        raise ValueError("must be two finite angles, the first within ±360")
    if not 0.0 < stop - start <= 360.0:
        raise ValueError("must be [start, stop] with stop above start by at most 360")
    return value


def _range_window(value: tuple[float, float]) -> tuple[float, float]:
    near, far = value
    if not (math.isfinite(near) and math.isfinite(far)) or near <= 0.0 or far <= near or far > 20_000.0:
        raise ValueError("must be [near, far] with 0 < near < far ≤ 20000")
    return value


class RadarSettings(Section):
    """Waveform, scan, the two antennas and the receiver."""

    frequency_hz: Annotated[float, limited("range of the scattering models", least=3e9, most=35e9)] = 10e9
    waveform: Literal["pulse", "chirp"] = "pulse"
    pulse_width_s: Annotated[float, limited("as long as the transmitter is on", least=1e-9, most=1e-4)] = 20e-9
    chirp_bandwidth_hz: Annotated[float, limited("swept by a chirp", least=1e5, most=1e9)] = 50e6
    compression_window: Literal["none", "hann", "hamming", "taylor"] = "hamming"
    bandwidth_hz: Annotated[float, limited("noise bandwidth of the receiver", least=1e5, most=1e9)] = 50e6
    prf_hz: Annotated[float, limited("pulses per second", least=10.0, most=1e5)] = 10e3
    transmit_power_w: Annotated[float, limited("peak power", above=0.0, most=1e6)] = 1.0
    noise_figure_db: Annotated[float, limited("a receiver adds noise", least=0.0, most=40.0)] = 3.0
    losses_db: Annotated[float, limited("a loss is not negative", least=0.0, most=60.0)] = 2.0
    noise: bool = True
    scan: Literal["turning", "staring"] = "turning"
    rotation_rpm: Annotated[float, limited("the antenna turns", least=1.0, most=120.0)] = 60.0
    stare_s: Annotated[
        float, limited("how long a map of a staring antenna lasts; the sea is the same all along", least=1e-3, most=0.1)
    ] = 0.05
    sector_deg: Annotated[tuple[float, float], *_pair(_sector)] = (0.0, 360.0)
    range_m: Annotated[tuple[float, float], *_pair(_range_window)] = (15.0, 400.0)
    range_sampling_m: Annotated[float, limited("spacing of the range gates", least=0.05, most=100.0)] = 1.5
    height_m: Annotated[float, limited("mean height of the phase centres over the sea", above=0.0, most=1000.0)] = 5.0
    baseline_m: Annotated[float, limited("distance between the phase centres", least=0.0, most=20.0)] = 0.2
    tilt_deg: Annotated[float, limited("beyond it the antennas lie on their backs", least=-60.0, most=60.0)] = 0.0
    transmit: Literal["single", "switched"] = "switched"
    interferogram: Literal["single_pulse", "alternating_pulse"] = "single_pulse"
    baseline_error_m: Annotated[float, limited("the true baseline's excess", least=-1.0, most=1.0)] = 0.0
    channel_gain_db: Annotated[float, limited("upper receiver over the lower", least=-20.0, most=20.0)] = 0.0
    channel_phase_deg: Annotated[float, limited("upper receiver over the lower", least=-360.0, most=360.0)] = 0.0
    antenna: AntennaSettings = AntennaSettings()
    antennas: Annotated[tuple[PlacedAntenna, ...], BeforeValidator(as_tuple)] = ()
    receiver: ReceiverSettings = ReceiverSettings()

    @model_validator(mode="before")
    @classmethod
    def _antennas_are_like_the_common_one(cls, tree: object) -> object:
        if not isinstance(tree, dict) or not isinstance(tree.get("antennas"), list | tuple):
            return tree
        common, placed = _as_table(tree.get("antenna", {})), [_as_table(entry) for entry in tree["antennas"]]
        if common is None or any(entry is None for entry in placed):
            return tree
        return {**tree, "antennas": [_like(common, entry) for entry in placed if entry is not None]}


def _as_table(value: object) -> dict[str, object] | None:
    """What was said of an antenna, by a file or in Python; None if it is no table."""
    if isinstance(value, AntennaSettings):
        return {key: each for key, each in value.model_dump(exclude_unset=True).items() if each is not None}
    return value if isinstance(value, dict) else None


def _like(common: dict[str, object], entry: dict[str, object]) -> dict[str, object]:
    """An antenna's keys, those that it leaves out taken from the common ones; another pattern needs no file."""
    merged = {**common, **entry}
    if merged.get("pattern") != "file" and "file" not in entry:
        merged.pop("file", None)
    return merged


# --------------------------------------------------------------------------------- platform, tracing, retrieval

Period = Annotated[float, limited("a boat answers waves of 0.5 s and more", least=0.5, most=300.0)]
Phase = Annotated[float, limited("a phase", least=-3600.0, most=3600.0)]
Bias = Annotated[float, limited("a sensor that errs by more is broken", least=-45.0, most=45.0)]
Noise = Annotated[float, limited("rms of one reading", least=0.0, most=45.0)]


class SensorSettings(Section):
    """How the boat measures its own motion: perfect unless said otherwise.

    Each of `rate_hz` readings a second is of the motion `latency_s` before; between readings it is interpolated, the
    retrieval being in no hurry. inf: a reading at every pulse.
    """

    roll_bias_deg: Bias = 0.0
    pitch_bias_deg: Bias = 0.0
    heading_bias_deg: Bias = 0.0
    height_bias_m: Bias = 0.0
    attitude_noise_deg: Noise = 0.0
    heading_noise_deg: Noise = 0.0
    position_noise_m: Noise = 0.0
    rate_hz: Annotated[float, limited("readings a second", least=0.1, infinite=True)] = math.inf
    latency_s: Annotated[float, limited("age of a reading", least=0.0, most=10.0)] = 0.0


class PlatformSettings(Section):
    """The boat: its course, how it moves about it, and what its sensors say of that.

    `fixed` keeps its attitude; `sinusoidal` rolls, pitches, yaws and heaves by given amplitudes; `wave_following` goes
    with the very waves that the radar sees, as far as its length and beam let it; `file` is a recorded motion. List and
    trim are its attitude at rest: starboard down, bow up. `lever_arm_m` leads from the point about which the boat turns
    to the middle of the antennas: starboard, forward, up; left out, that point lies at the waterline straight below.
    """

    motion: Literal["fixed", "sinusoidal", "wave_following", "file"] = "fixed"
    speed_m_s: Annotated[float, limited("through the scene, along the heading", least=0.0, most=30.0)] = 0.0
    heading_deg: Direction = 0.0
    list_deg: Annotated[float, limited("beyond it the boat capsizes", least=-45.0, most=45.0)] = 0.0
    trim_deg: Annotated[float, limited("beyond it the boat founders", least=-45.0, most=45.0)] = 0.0
    roll_deg: Annotated[float, limited("an amplitude", least=0.0, most=45.0)] = 0.0
    roll_period_s: Period = 4.0
    roll_phase_deg: Phase = 0.0
    pitch_deg: Annotated[float, limited("an amplitude", least=0.0, most=45.0)] = 0.0
    pitch_period_s: Period = 5.0
    pitch_phase_deg: Phase = 0.0
    yaw_deg: Annotated[float, limited("an amplitude", least=0.0, most=45.0)] = 0.0
    yaw_period_s: Period = 8.0
    yaw_phase_deg: Phase = 0.0
    heave_m: Annotated[float, limited("an amplitude", least=0.0, most=20.0)] = 0.0
    heave_period_s: Period = 5.0
    heave_phase_deg: Phase = 0.0
    file: str | None = None
    length_m: Annotated[float, limited("of the boat's waterline", above=0.1, most=300.0)] = 7.0
    beam_m: Annotated[float, limited("of the boat's waterline", above=0.1, most=60.0)] = 2.5
    lever_arm_m: Offset | None = None
    sensors: SensorSettings = SensorSettings()

    @model_validator(mode="after")
    def _says_what_it_does(self) -> Self:
        if (self.motion == "file") != bool(self.file):
            raise ValueError("give motion = 'file' and file = '…' together: one says what the other is for")
        if self.motion == "file" and (self.speed_m_s or self.list_deg or self.trim_deg):
            raise ValueError("speed_m_s, list_deg and trim_deg: must be 0 with motion = 'file'; the file holds them")
        if self.motion != "sinusoidal":
            for key in ("roll_deg", "pitch_deg", "yaw_deg", "heave_m"):
                if getattr(self, key):
                    raise ValueError(
                        f"{key} = {getattr(self, key):g}: is an amplitude, and must be 0 unless motion = 'sinusoidal'; "
                        "set that, or give a steady attitude by list_deg and trim_deg"
                    )
        return self


class ObjectSettings(Section):
    """A thing in the scene: it hides the sea behind it, and echoes with its radar cross-section.

    `mesh` is an STL, GLB, OBJ or PLY file, z up, y ahead, in metres times `scale`; a relative path counts from the
    scene file's folder. `rcs_dbsm` is the mean over its speckle while it is wholly in sight; left out, it echoes
    nothing. `fixed_to` the boat, `position_m` counts from the foot of the mast in the boat's axes (starboard, forward,
    up from the waterline) and turns with it; else east, north, up of mean sea level at the origin.
    """

    mesh: str
    position_m: Annotated[tuple[float, float, float], BeforeValidator(as_tuple)]
    heading_deg: Direction = 0.0
    scale: Annotated[float, limited("metres per unit of the file", above=0.0, most=1e4)] = 1.0
    rcs_dbsm: Annotated[float, limited("in sight as a whole", least=-100.0, most=80.0)] | None = None
    fixed_to: Literal["world", "boat"] = "world"

    @model_validator(mode="after")
    def _stands_somewhere(self) -> Self:
        if not all(math.isfinite(part) and abs(part) <= 30_000.0 for part in self.position_m):
            raise ValueError("position_m: must be three finite numbers within ±30000 m")
        return self


def _gauge_name(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9 ._+-]{0,39}", name):
        raise ValueError("must be 1 to 40 letters, digits, blanks and . _ + -, the first a letter or digit")
    return name


Shore = Annotated[float, limited("a place in the scene", least=-20_000.0, most=20_000.0)]


class GaugeSettings(Section):
    """A virtual wave gauge: a wire, fixed to the ground, that reads the surface where it stands `sample_hz` times a
    second, beside which the radar's map is read once a turn.

    Its place is given by east_m and north_m of the origin, the foot of the mast at time 0, or by azimuth_deg and
    ground_range_m, the horizontal distance, from there.
    """

    name: Annotated[str, AfterValidator(_gauge_name)]
    east_m: Shore | None = None
    north_m: Shore | None = None
    ground_range_m: Annotated[float, limited("a distance", least=0.0, most=20_000.0)] | None = None
    azimuth_deg: Direction | None = None
    sample_hz: Annotated[float, limited("readings a second of the wire", least=0.1, most=1000.0)] = 4.0

    @model_validator(mode="after")
    def _one_way_to_say_where(self) -> Self:
        square = (self.east_m is not None, self.north_m is not None)
        polar = (self.ground_range_m is not None, self.azimuth_deg is not None)
        if (all(square), any(polar)) != (True, False) and (any(square), all(polar)) != (False, True):
            raise ValueError(
                "give its place either by east_m and north_m or by ground_range_m and azimuth_deg, not by "
                + ("a mixture" if any(square + polar) else "nothing")
            )
        return self

    @property
    def place(self) -> tuple[float, float]:
        """East and north of the origin [m]."""
        if self.east_m is not None and self.north_m is not None:
            return self.east_m, self.north_m
        assert self.ground_range_m is not None
        assert self.azimuth_deg is not None
        east, north = unit_from_azimuth(self.azimuth_deg)
        return self.ground_range_m * float(east), self.ground_range_m * float(north)


class TracingSettings(Section):
    """How the lit part of the sea is found, and how finely the sea is meshed.

    The mesh is as fine as its errors ask: `height_error_m`, rms of the map's heights over cells more than half visible,
    and `visible_error`, rms of a cell's visible share, in the expectation over speckle. `facet_m` or `columns_per_beam`
    given are taken as they are.
    """

    tracer: Literal["facets", "horizon", "paths"] = "facets"
    diffraction: Literal["none", "knife_edge"] = "none"
    height_error_m: Annotated[float, limited("an error is more than nothing", least=1e-4, most=10.0)] = 0.02
    visible_error: Annotated[float, limited("a share of a cell", least=1e-3, most=1.0)] | None = None
    facet_m: Annotated[float, limited("spacing of the mesh along the look", least=0.02, most=20.0)] | None = None
    columns_per_beam: (
        Annotated[int, limited("fewer than 3 alias the two-way pattern, more than 64 gain nothing", least=3, most=64)]
        | None
    ) = None


class RetrievalSettings(Section):
    """How echoes become heights.

    `single_cell` averages the covariance over one cell. `sliding_plane` takes the slopes from that first map and
    averages along them over a wider window: less speckle, at the price of a resolution of about the window. `adaptive`
    chooses the window by what the echo holds: its power, its coherence, and how the waves themselves go on from cell to
    cell.
    `paths`: where the echoes hold interferograms of one way (one antenna sends, both hear) and of two (each hears
    itself), `best` takes both ways, whose phase is twice as steep, and resolves it by the one way.
    `pulse_pairs` matters to pairs of pulses alone: a lower antenna's pulse with the upper one's after it (forward),
    with that before it, or both, whose Doppler phases cancel. `receivers` are the two that are compared.
    """

    cell_range_m: Annotated[float, limited("a cell has a length", above=0.0, most=1000.0)] = 3.0
    cell_azimuth_deg: Annotated[float, limited("a cell has a width", above=0.0, most=45.0)] = 1.8
    estimator: Literal["adaptive", "sliding_plane", "single_cell"] = "adaptive"
    window_range_m: Annotated[float, limited("length of the sliding window", above=0.0, most=1000.0)] = 4.5
    window_azimuth_deg: Annotated[float, limited("width of the sliding window", above=0.0, most=45.0)] = 2.7
    paths: Literal["best", "one_way"] = "best"
    ambiguity: Literal["resolve", "fold"] = "resolve"
    crest_bias: Literal["report", "remove"] = "report"
    coherent_s: Annotated[float, limited("of pulses added before they are multiplied", least=0.0, most=0.02)] = 0.0
    channels: Literal["as_given", "from_cross_paths"] = "as_given"
    channel_gain_db: Annotated[float, limited("of the upper receiver over the lower", least=-60.0, most=60.0)] = 0.0
    channel_phase_deg: Annotated[float, limited("of the upper receiver over the lower", least=-360.0, most=360.0)] = 0.0
    map_time_s: Annotated[float, limited("after each turn's start", least=-60.0, most=60.0)] | None = None
    depth_m: Annotated[
        float, limited("of the water, in which waves run on to map_time_s", above=0.0, infinite=True)
    ] = float("inf")
    pulse_pairs: Literal["both", "forward", "backward"] = "both"
    receivers: Annotated[tuple[int, int], BeforeValidator(as_tuple)] = (0, 1)
    min_snr_db: Annotated[float, limited("below it a cell has no echo", least=-30.0, most=60.0)] = 0.0
    ground_m: Annotated[float, limited("side of a ground cell", above=0.0, most=1000.0)] = 3.0
