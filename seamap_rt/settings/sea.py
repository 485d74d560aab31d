"""[sea] and [[sea.waves]]: the water, its wave systems, one model for each `spectrum`, and how much of them the surface
resolves."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BeforeValidator, Discriminator, model_validator

from .section import Direction, Meaning, Phase, Section, When, as_tuple, compass

Spreading = Literal["cos2s", "mitsuyasu", "hasselmann", "donelan_banner", "elfouhaily", "long_crested"]
HIGHEST_SEA_M = 30.0  # significant wave height
PERIODS_S = (0.3, 40.0)  # of a peak: wind waves and swell
WindSpeed = Annotated[float, Ge(0.01), Le(60.0)]
Fetch = Annotated[float, Ge(1.0), Le(5e6)]

_FROM = compass("Waves come from | Direction from which the waves come")
_SPREADING = Meaning(
    text="How the waves' directions spread about the main one: `cos2s` with a fixed exponent, `mitsuyasu`, "
    "`hasselmann`, `donelan_banner` and `elfouhaily` by those papers, `long_crested` not at all."
)
_WIND = Meaning(
    "m/s", "10 m above the sea", text="Wind speed | Wind speed 10 m above the sea, which raises this system."
)


class FlatWaves(Section):
    """No waves at all."""

    spectrum: Literal["flat"]
    """No waves."""


class SinusoidWaves(Section):
    """One regular wave, η = (height_m/2) cos(k·x − ωt + phase).

    Its steepness height_m/wavelength_m is at most 0.142: a steeper wave breaks (Michell 1893).
    """

    spectrum: Literal["sinusoid"]
    """One regular wave."""
    height_m: Annotated[float, Ge(0.0), Le(50.0), Meaning("m", "crest to trough; 0 is flat")]
    """Height, crest to trough."""
    wavelength_m: Annotated[float, Gt(0.0), Le(1e5), Meaning("m", "a wave has a length")]
    """Wavelength."""
    phase_deg: Annotated[Phase, Meaning("°", "a phase")] = 0.0
    """Phase at the origin at time 0; 0 is a crest."""
    wave_from_deg: Annotated[Direction, _FROM] = 270.0

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


class SpreadWaves(RandomWaves):
    """A main direction, and how the waves spread about it."""

    wave_from_deg: Annotated[Direction, _FROM] = 270.0
    spreading: Annotated[Spreading, _SPREADING] = "cos2s"
    spreading_exponent: Annotated[
        float, Gt(0.0), Le(500.0), Meaning("1", "the s of cos^2s(θ/2)"), When("spreading", "cos2s")
    ] = 10.0
    """Spreading exponent s | Exponent s of `spreading = "cos2s"`; larger is narrower."""
    inverse_wave_age: Annotated[
        float | None,
        Ge(0.1),
        Le(10.0),
        Meaning(
            "1",
            "U10 over the peak's phase speed; 0.84 is fully developed",
            left_out="follows from the wind where the system is given by a wind, else 0.84, a fully developed sea",
        ),
        When("spreading spectrum", "mitsuyasu hasselmann elfouhaily"),
    ] = None
    """U10 over the phase speed of the spectrum's peak; `mitsuyasu`, `hasselmann` and `elfouhaily` depend on it."""


class SpectralWaves(SpreadWaves):
    """A system with a peak, given by its height and period or by the wind."""

    significant_wave_height_m: Annotated[
        float | None, Ge(0.0), Le(HIGHEST_SEA_M), Meaning("m", "0 is flat; no sea above 30 m", left_out="by the wind")
    ] = None
    """Significant wave height (Hs) | Significant wave height Hs = 4σ; together with `peak_period_s`."""
    peak_period_s: Annotated[
        float | None,
        Ge(PERIODS_S[0]),
        Le(PERIODS_S[1]),
        Meaning("s", "wind waves and swell lie between 0.3 and 40 s", left_out="by the wind"),
    ] = None
    """Peak period (Tp) | Period Tp of the spectrum's peak, as one meets it who drifts with the current."""
    wind_speed_m_s: Annotated[
        WindSpeed | None, Meaning("m/s", "10 m above the sea", left_out="by height and period")
    ] = None
    """Wind speed | Wind speed 10 m above the sea, in place of height and period (jonswap and tma: together with
    `fetch_m`)."""

    @model_validator(mode="after")
    def _check_size(self) -> Self:
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
    """A fully developed sea."""


class GrowingWaves(SpectralWaves):
    """A sea with an enhanced peak, by wind and fetch or scaled to Hs, Tp and γ."""

    peak_enhancement: Annotated[float, Ge(1.0), Le(20.0), Meaning("1", "γ of the JONSWAP spectrum")] = 3.3
    """Peak enhancement γ | Peak enhancement γ."""
    fetch_m: Annotated[
        Fetch | None, Meaning("m", "distance to the windward shore", left_out="by height and period")
    ] = None
    """[km] | Distance over which the wind has blown; together with `wind_speed_m_s`."""

    @model_validator(mode="after")
    def _check_fetch(self) -> Self:
        if (self.wind_speed_m_s is None) != (self.fetch_m is None):
            raise ValueError("give wind_speed_m_s and fetch_m together: jonswap and tma by wind need both")
        return self


class JonswapWaves(GrowingWaves):
    """A growing sea (Hasselmann et al. 1973)."""

    spectrum: Literal["jonswap"]
    """A growing sea."""


class TmaWaves(GrowingWaves):
    """A growing sea in water of finite depth, JONSWAP × Φ (Bouws et al. 1985). Hs is that of the sea itself."""

    spectrum: Literal["tma"]
    """A growing sea in water of finite depth."""


class ElfouhailyWaves(SpreadWaves):
    """The whole wind sea, from its peak to the ripples (Elfouhaily et al. 1997), by wind and wave age or fetch."""

    spectrum: Literal["elfouhaily"]
    """A wind sea from its peak to the ripples."""
    wind_speed_m_s: Annotated[WindSpeed, _WIND]
    fetch_m: Annotated[
        Fetch | None, Meaning("m", "distance to the windward shore", left_out="by `inverse_wave_age`")
    ] = None
    """[km] | Distance over which the wind has blown; in place of `inverse_wave_age`."""
    spreading: Annotated[Spreading, _SPREADING] = "elfouhaily"
    inverse_wave_age: Annotated[
        float | None,
        Ge(0.8),
        Le(5.0),
        Meaning(
            "1",
            "Elfouhaily et al. 1997; 0.84 is fully developed",
            left_out="by `fetch_m`, else 0.84, a fully developed sea",
        ),
    ] = None
    """U10 over the phase speed of the spectrum's peak; in place of `fetch_m`."""

    @model_validator(mode="after")
    def _check_age(self) -> Self:
        if self.inverse_wave_age is not None and self.fetch_m is not None:
            raise ValueError("give fetch_m or inverse_wave_age, not both: each says how old the sea is")
        return self


class FileWaves(RandomWaves):
    """A measured or modelled directional spectrum, read from a file."""

    spectrum: Literal["file"]
    """A spectrum from a file."""
    file: str
    """Path of the file; a relative one counts from the scene file's folder."""
    kind: Literal[
        "auto",
        "ndbc",
        "swan",
        "ncswan",
        "ww3",
        "ww3_station",
        "era5",
        "datawell",
        "spotter",
        "triaxys",
        "octopus",
        "wavespectra",
        "json",
        "recorded",
    ] = "auto"
    """Format | Format: NDBC; SWAN's text or NetCDF; WAVEWATCH III's NetCDF or text; ERA5; Datawell's .spt; Spotter;
    TRIAXYS; Octopus; wavespectra's own NetCDF, Zarr or JSON. `auto` recognises them. `recorded`: the spectrum of a
    recorded sea (`sea.file`)."""
    time: Annotated[str | None, Meaning(left_out="the first")] = None
    """Time as ISO text, such as `2020-01-01T06:00`; the nearest in the file is taken."""
    site: Annotated[int, Ge(0), Meaning("1", "stations are numbered from 0")] = 0
    """Number of the file's station."""
    tail_exponent: Annotated[float, Ge(0.0), Le(12.0), Meaning("1", "a tail falls off; 0 is none")] = 5.0
    """Beyond the last frequency the spectrum goes on as f to the minus this; 0 ends it there, else it must be at least
    3 (4 to 5 is usual)."""

    @model_validator(mode="after")
    def _check_tail(self) -> Self:
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


_RECORDED = When("model", "recorded")
DEFAULT_RESOLUTION_M = 0.8
MOST_POINTS_A_SIDE = 4096


class SeaSettings(Section):
    """The water: its depth, its current, its wave systems, and the finest wave that is resolved.

    Any number of wave systems add up. Periods and spectra are those that one meets who drifts with the current. Waves
    follow the full dispersion relation, with depth and surface tension. Waves shorter than twice `resolution_m` are not
    on the surface but in the scattering; which waves are on the surface decides what hides behind crests.
    """

    model: Literal["linear", "choppy", "recorded"] = "linear"
    """`linear` waves, or `choppy`: first-order Lagrangian waves, whose crests are sharper; a scene of which more than 2
    % of the water folds over at time 0 is refused. `recorded`: the surface of `file`."""
    file: Annotated[str, _RECORDED] = ""
    """Of a recorded sea: NetCDF or Zarr of the elevation over time, y and x (metres east and north of the antenna),
    HOS-ocean's `3d.dat`, a stereo camera's grids. Side, spacing, depth and spectrum are the file's where they are left
    out."""
    beyond: Annotated[Literal["refused", "level", "mirrored"], _RECORDED] = "refused"
    """Beyond a recorded patch that ends within the range circle: `refused`, or the sea goes on `level`, or `mirrored`
    at the patch's edges. Nothing there is judged: no metric, gauge or forecast takes a cell of it."""
    start_s: Annotated[
        float | None,
        Ge(-1e9),
        Le(1e9),
        Meaning(
            "s",
            "times of a record; it must hold the run",
            left_out="as early as the record allows: what is interpolated and heard before time 0 takes its beginning",
        ),
        _RECORDED,
    ] = None
    """Time of a recorded sea's file, of dates from its first, that is the scene's time 0."""
    depth_m: Annotated[float, Ge(0.05), Meaning("m", "water has a depth; inf is deep", infinite=True)] = math.inf
    """Water depth | Depth of the water; inf is deep."""
    resolution_m: Annotated[
        float | None,
        Gt(0.0),
        Le(100.0),
        Meaning(
            "m", "spacing of the resolved waves' grid", left_out=f"{DEFAULT_RESOLUTION_M}, or by `energy_fraction`"
        ),
    ] = None
    """Spacing of the resolved waves | Spacing of the grid of resolved waves: the shortest wave on the surface is twice
    as long."""
    energy_fraction: Annotated[
        float | None,
        Gt(0.0),
        Lt(1.0),
        Meaning("1", "share of the waves' variance that is resolved", left_out="by `resolution_m`"),
    ] = None
    """Share of the waves resolved | Share of the waves' variance that is to be on the surface: asks for the resolution
    that keeps it, in place of `resolution_m`."""
    extent_m: Annotated[float, Ge(10.0), Le(20_000.0), Meaning("m", "side of the periodic patch")] = 1024.0
    """Side of the patch of sea | Side of the periodic patch of sea; it must hold the range circle, unless the waves do
    not repeat (`sinusoid`, `flat`, `long_crested`)."""
    current_m_s: Annotated[float, Ge(0.0), Le(10.0), Meaning("m/s", "a uniform current")] = 0.0
    """Speed of a uniform current, which carries the waves."""
    current_toward_deg: Annotated[
        Direction, compass("Current flows towards | Direction to which the current flows")
    ] = 0.0
    waves: Annotated[tuple[WaveSystem, ...], BeforeValidator(as_tuple)] = ()
    """Wave systems, `[[sea.waves]]`: wind sea and swells, each with its own spectrum."""

    @model_validator(mode="before")
    @classmethod
    def _default_resolution(cls, tree: object) -> object:
        if isinstance(tree, dict) and tree.get("resolution_m") is None and tree.get("energy_fraction") is None:
            return {**tree, "resolution_m": DEFAULT_RESOLUTION_M}
        return tree

    @model_validator(mode="after")
    def _check_resolution(self) -> Self:
        if self.resolution_m is not None and self.energy_fraction is not None:
            raise ValueError("give resolution_m or energy_fraction, not both: one follows from the other")
        return self

    @model_validator(mode="after")
    def _check_recording(self) -> Self:
        if self.model == "recorded" and not self.file:
            raise ValueError("model = 'recorded': needs `file`, the recorded sea; name it")
        if self.model == "recorded" and not any(isinstance(waves, RandomWaves) for waves in self.waves):
            raise ValueError(
                "waves: must hold the spectrum of the recorded sea, from which the mesh is sized; leave `waves` out, "
                "and it is taken from the file"
            )
        if self.model != "recorded" and self.beyond != "refused":
            raise ValueError(
                f"beyond = '{self.beyond}': must be 'refused' where model = '{self.model}', which has no edge; "
                "leave it out"
            )
        if self.model != "recorded" and self.start_s is not None:
            raise ValueError(f"model = '{self.model}': has no record to begin in; leave start_s = {self.start_s:g} out")
        if self.model == "recorded" and self.current_m_s:
            raise ValueError(
                f"current_m_s = {self.current_m_s:g}: must be 0 where model = 'recorded' (the record holds what the "
                "current did to its waves); tell it to the retrieval, as retrieval.current_m_s"
            )
        return self

    @model_validator(mode="after")
    def _grid_fits_memory(self) -> Self:
        if self.resolution_m is not None:
            check_grid(self.extent_m, self.resolution_m)
        return self


def check_grid(extent_m: float, resolution_m: float, energy_fraction: float | None = None) -> None:
    """Raise ValueError unless the grid of resolved waves fits memory and holds waves.

    energy_fraction: the share from which the resolution follows, if it was not given itself.
    """
    side = extent_m / resolution_m
    cause = "" if energy_fraction is None else f"energy_fraction = {energy_fraction!r}: asks for {resolution_m:.3g} m, "
    key = "resolution_m" if energy_fraction is None else "energy_fraction"
    finer, coarser = ("lower", "raise") if energy_fraction is None else ("raise", "lower")
    if side > MOST_POINTS_A_SIDE:
        raise ValueError(
            f"{cause}extent_m/resolution_m = {side:.0f}: must be at most {MOST_POINTS_A_SIDE} (a grid of {side:.0f}² "
            f"points would take {side * side * 100 / 1e9:.3g} GB); {coarser} {key} or lower extent_m"
        )
    if side < 8:
        raise ValueError(f"{cause}extent_m/resolution_m = {side:.1f}: must be at least 8; {finer} {key}")
