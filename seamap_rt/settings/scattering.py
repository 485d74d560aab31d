"""[scattering]: how the sea's surface returns the radar's power."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le

from .limits import Meaning
from .section import Direction, Section, compass

_RANGE = "range of the permittivity model"


class ScatteringSettings(Section):
    """How the sea's surface returns the radar's power, and the wind that roughens it."""

    nrcs: Annotated[
        Literal["two_scale", "nrl", "git", "tsc", "hybrid", "constant"],
        Meaning(
            "Model of the radar cross-section σ0: `two_scale` is theory, facet by facet, whose mean is brought to the "
            "measured model `calibrated_to`; `nrl`, `git`, `tsc` and `hybrid` are those models' means on every facet "
            "that is seen; `constant` is `nrcs_db`."
        ),
    ] = "two_scale"
    nrcs_db: Annotated[
        float,
        Ge(-120.0),
        Le(30.0),
        Meaning('σ0 of every facet with nrcs = "constant".', unit="dB", reason="σ0 of nrcs = 'constant'"),
    ] = -40.0
    calibrated_to: Annotated[
        Literal["nrl", "git", "tsc", "hybrid", "none"],
        Meaning(
            "The measured model that sets the mean of `two_scale`: `nrl` that over all directions, and how the echo "
            "changes with the wind's direction is theory's; `git`, `tsc` and `hybrid` that too. Beyond its winds "
            "theory goes on from the nearest that it holds for. `none` leaves theory alone."
        ),
    ] = "nrl"
    extrapolate: Annotated[
        bool,
        Meaning("Whether a measured model's formula runs on beyond the winds and frequencies of its paper."),
    ] = False
    breaking: Annotated[bool, Meaning("Breakers, which know no polarization and so raise HH.")] = True
    sea_spikes: Annotated[
        bool,
        Meaning(
            "Breakers are single events that run with their wave, grow and fade: sea spikes; `false`: a share of each "
            "facet, with the same mean."
        ),
    ] = False
    hydrodynamic_modulation: Annotated[bool, Meaning("Short waves are gathered by the strain of the long ones.")] = True
    doppler: Annotated[
        Literal["full", "orbital"],
        Meaning(
            "`full`: Bragg waves of both directions and breakers run on the water at their own speeds; `orbital`: they "
            "only ride on it."
        ),
    ] = "full"
    polarization: Annotated[Literal["VV", "HH"], Meaning("Polarization sent and received.")] = "VV"
    wind_speed_m_s: Annotated[
        float,
        Ge(0.5),
        Le(40.0),
        Meaning(
            "Wind speed 10 m above the sea; it drives the short waves, which scatter.",
            unit="m/s",
            reason="10 m above the sea; drives the short waves",
        ),
    ] = 8.0
    wind_from_deg: Annotated[Direction, compass("Direction from which the wind blows")] = 270.0
    inverse_wave_age: Annotated[
        float,
        Ge(0.84),
        Le(5.0),
        Meaning(
            "U10 over the peak's phase speed of the sea that this wind raises: it moves the peak, and hardly the waves "
            "that scatter.",
            unit="1",
            reason="0.84 is a fully developed sea, 5 a very young one",
        ),
    ] = 0.84
    decorrelation_time_s: Annotated[
        float,
        Ge(1e-3),
        Meaning(
            "τc of the speckle's correlation exp(−(τ/τc)²), beside the scatterers' own motion; inf: by that alone.",
            unit="s",
            reason="5 to 33 ms for a 3 m X-band cell in the literature",
            infinite=True,
        ),
    ] = 0.010
    permittivity: Annotated[
        Literal["meissner_wentz12", "meissner_wentz04", "klein_swift77"],
        Meaning("Model of sea water's permittivity, named by its paper."),
    ] = "meissner_wentz12"
    temperature_c: Annotated[
        float, Ge(-2.0), Le(34.0), Meaning("Temperature of the water.", unit="°C", reason=_RANGE)
    ] = 20.0
    salinity_psu: Annotated[float, Ge(0.0), Le(40.0), Meaning("Salinity of the water.", unit="psu", reason=_RANGE)] = (
        35.0
    )

    @property
    def mean_model(self) -> str | None:
        """The empirical model that sets the mean, if one does."""
        if self.nrcs == "two_scale":
            return None if self.calibrated_to == "none" else self.calibrated_to
        return None if self.nrcs == "constant" else self.nrcs
