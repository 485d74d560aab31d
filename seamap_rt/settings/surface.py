"""[scattering] and [tracing]: what of the sea's surface each antenna sees, and how that returns the radar's power."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le

from .section import Direction, Meaning, Section, When, compass

_RANGE = "range of the permittivity model"
_TWO_SCALE = When("nrcs", "two_scale")


class ScatteringSettings(Section):
    """How the sea's surface returns the radar's power, and the wind that roughens it."""

    nrcs: Literal["two_scale", "nrl", "git", "tsc", "hybrid", "constant"] = "two_scale"
    """Echo model | Model of the radar cross-section σ0: `two_scale` is theory, facet by facet, whose mean is brought to
    the measured model `calibrated_to`; `nrl`, `git`, `tsc` and `hybrid` are those models' means on every facet that is
    seen; `constant` is `nrcs_db`."""
    nrcs_db: Annotated[
        float, Ge(-120.0), Le(30.0), Meaning("dB", "σ0 of nrcs = 'constant'"), When("nrcs", "constant")
    ] = -40.0
    """Constant σ0 | σ0 of every facet with nrcs = "constant"."""
    calibrated_to: Annotated[Literal["nrl", "git", "tsc", "hybrid", "none"], _TWO_SCALE] = "nrl"
    """Mean echo calibrated to | The measured model that sets the mean of `two_scale`: `nrl` that over all directions,
    and how the echo changes with the wind's direction is theory's; `git`, `tsc` and `hybrid` that too. Beyond its winds
    theory goes on from the nearest that it holds for. `none` leaves theory alone."""
    extrapolate: bool = False
    """Whether a measured model's formula runs on beyond the winds and frequencies of its paper."""
    breaking: Annotated[bool, _TWO_SCALE] = True
    """Breakers, which know no polarization and so raise HH."""
    sea_spikes: Annotated[bool | None, Meaning(left_out="true in HH, false in VV"), _TWO_SCALE] = None
    """Breakers are single events that run with their wave, grow and fade: sea spikes; `false`: a share of each facet,
    with the same mean."""
    texture: Annotated[bool, _TWO_SCALE] = False
    """Breakers gather in patches that live for seconds and run before the wind, as wide as the law of Watts & Wicks
    (1990) has it; `false`: only where the resolved waves gather them. The mean is the same."""
    hydrodynamic_modulation: Annotated[bool, _TWO_SCALE] = True
    """Short waves are gathered by the strain of the long ones."""
    doppler: Literal["full", "orbital"] = "full"
    """`full`: Bragg waves of both directions and breakers run on the water at their own speeds, and drift before the
    wind with it; `orbital`: they only ride on the waves."""
    wind_drift: Annotated[float, Ge(0.0), Le(0.1), Meaning("1", "of the wind's speed; about 0.03 is measured")] = 0.03
    """Speed of the water's skin down-wind over wind_speed_m_s, Stokes' drift and all: 0.03 of the wind at 10 m (Wu
    1975, J. Fluid Mech. 68). A current of the sea comes on top; of swell's own Stokes' drift nothing is known here."""
    polarization: Literal["VV", "HH"] = "VV"
    """Polarization | Polarization sent and received."""
    wind_speed_m_s: Annotated[
        float, Ge(0.5), Le(40.0), Meaning("m/s", "10 m above the sea; drives the short waves")
    ] = 8.0
    """Wind speed | Wind speed 10 m above the sea; it drives the short waves, which scatter."""
    wind_from_deg: Annotated[Direction, compass("Wind blows from | Direction from which the wind blows")] = 270.0
    inverse_wave_age: Annotated[
        float, Ge(0.84), Le(5.0), Meaning("1", "0.84 is a fully developed sea, 5 a very young one")
    ] = 0.84
    """U10 over the peak's phase speed of the sea that this wind raises: it moves the peak, and hardly the waves that
    scatter."""
    decorrelation_time_s: Annotated[
        float, Ge(1e-3), Meaning("s", "5 to 33 ms for a 3 m X-band cell in the literature", infinite=True)
    ] = 0.010
    """[ms] | τc of the speckle's correlation exp(−(τ/τc)²), beside the scatterers' own motion; inf: by that alone."""
    permittivity: Literal["meissner_wentz12", "meissner_wentz04", "klein_swift77"] = "meissner_wentz12"
    """Model of sea water's permittivity, named by its paper."""
    temperature_c: Annotated[float, Ge(-2.0), Le(34.0), Meaning("°C", _RANGE)] = 20.0
    """Temperature of the water."""
    salinity_psu: Annotated[float, Ge(0.0), Le(40.0), Meaning("psu", _RANGE)] = 35.0
    """Salinity of the water."""

    @property
    def has_sea_spikes(self) -> bool:
        """Whether breakers are single events: as `sea_spikes` says; if it is left out, in HH, which is spiky at sea."""
        wanted = self.polarization == "HH" if self.sea_spikes is None else self.sea_spikes
        return wanted and self.breaking and self.nrcs == "two_scale"

    @property
    def mean_model(self) -> str | None:
        """The empirical model that sets the mean, if one does."""
        if self.nrcs == "two_scale":
            return None if self.calibrated_to == "none" else self.calibrated_to
        return None if self.nrcs == "constant" else self.nrcs


class TracingSettings(Section):
    """Which part of the sea each antenna sees, and how finely the sea is meshed.

    The mesh is as fine as the maps need: a model predicts what it costs them and takes the fewest facets that meet the
    errors allowed here, never coarser than the sea's own grid, a third of the radar's range cell or three columns a
    beam. `facet_m` and `columns_per_beam`, if given, are taken as they are.
    """

    tracer: Literal["facets", "horizon", "paths"] = "facets"
    """Tracer | `facets`: a shadow ray to every facet that faces the antenna, by Sionna RT/Mitsuba, on any triangulated
    sea; `horizon`: running maximum of the elevation angle along the mesh's own profiles, for a sea that stands once
    over each place, without a ray tracing backend; `paths`: a line of sight to every facet by Sionna RT's PathSolver,
    an independent and slower reference."""
    diffraction: Literal["none", "knife_edge"] = "knife_edge"
    """`knife_edge`: the field over up to two crests at each facet and antenna: they turn the phase of the water behind
    them, lit or not; `none`: straight rays, geometric shadows, a sixth faster."""
    unresolved_shadowing: Literal["none", "fresnel", "smith"] = "none"
    """Shadows of waves that the mesh does not carry. `none`: they cast none; `smith`: they hide what they would hide
    from light. Of each lit facet that share is in sight and echoes which Smith (1967) gives for the slopes of the
    wind's short waves and the facet's own grazing angle; `fresnel`: what they hide keeps the share of its echo that
    bends into shadows of their size, a third to a half in VV. Wave optics lies between `none` and `smith`; cells more
    than half visible change by 0.03 dB."""
    height_error_m: Annotated[float, Ge(1e-4), Le(10.0), Meaning("m", "an error is more than nothing")] = 0.02
    """Height error allowed to the mesh | What the mesh may cost the maps' heights: rms over cells more than half
    visible, in the expectation over speckle."""
    visible_error: Annotated[
        float | None, Ge(1e-3), Le(1.0), Meaning("1", "a share of a cell", left_out="no target")
    ] = None
    """What the mesh may cost a cell's visible share, rms."""
    facet_m: Annotated[
        float | None,
        Ge(0.02),
        Le(20.0),
        Meaning("m", "spacing of the mesh along the look", left_out="by the errors allowed"),
    ] = None
    """Facet length | Spacing of the mesh along the look."""
    columns_per_beam: Annotated[
        int | None,
        Ge(3),
        Le(64),
        Meaning(
            "1", "fewer than 3 alias the two-way pattern, more than 64 gain nothing", left_out="by the errors allowed"
        ),
    ] = None
    """Columns of the mesh within a beam width."""
