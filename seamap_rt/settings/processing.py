"""[retrieval] and [prediction]: how echoes become heights, and how these become forecasts."""

from __future__ import annotations

import json
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BeforeValidator, model_validator

from .section import Direction, Meaning, Section, When, as_tuple, compass

_SLIDING = When("estimator", "sliding_plane")
_AS_GIVEN = When("channels", "as_given")


class RetrievalSettings(Section):
    """How echoes become heights.

    Echoes carry them, with the scene's depth and current: `sr.retrieve(echoes)` goes by these, `--set
    retrieval.KEY=VALUE` or other settings replace them.
    """

    cell_range_m: Annotated[float, Ge(1e-3), Le(1000.0), Meaning("m", "a cell has a length")] = 3.0
    """Cell length | Length of a cell in range."""
    cell_azimuth_deg: Annotated[float, Ge(1e-4), Le(45.0), Meaning("°", "a cell has a width")] = 1.8
    """Cell width | Width of a cell, a look; it may be finer than the beam."""
    estimator: Literal["adaptive", "sliding_plane", "single_cell"] = "adaptive"
    """`adaptive`: optimal interpolation (Bretherton et al. 1976) between single dwells and gates, each trusted as far
    as its own echo goes, along the sea's covariance as the map itself shows it; `sliding_plane`: takes the slopes from
    a first map and averages along them over a wider window, less speckle for a resolution of about the window;
    `single_cell`: averages the covariance over one cell."""
    window_range_m: Annotated[float, Ge(1e-3), Le(1000.0), Meaning("m", "length of the sliding window"), _SLIDING] = 4.5
    """Length of the window of sliding_plane."""
    window_azimuth_deg: Annotated[float, Ge(1e-4), Le(45.0), Meaning("°", "width of the sliding window"), _SLIDING] = (
        2.7
    )
    """Width of the window of sliding_plane."""
    paths: Literal["best", "one_way"] = "best"
    """`best`: where transmitters alternate and both receivers hear all, each antenna on itself (p = 2), whose phase is
    twice as steep, resolved by one antenna to both (p = 1) of the same echoes; `one_way`: p = 1."""
    ambiguity: Literal["resolve", "fold"] = "resolve"
    """Which cycle a phase is on. `resolve`: cells are grown from the surest on, round shadows, by the mean level, by p
    = 1 and by their neighbours, and what stays in doubt is flagged `ambiguous`; `fold`: all within half an ambiguity of
    mean level."""
    crest_bias: Literal["report", "remove"] = "report"
    """Of partly shadowed cells, what is in sight stands above the cell's mean: reported, or removed."""
    diffraction_mrad: Annotated[
        float | None,
        Ge(0.0),
        Le(100.0),
        Meaning("mrad", "an angle", left_out="0; for recordings and with tracing.diffraction 1 to 1.5 at 3 cm"),
    ] = None
    """Error of the angle of arrival | Error of the angle at which echoes arrive over the crests before them, by
    diffraction, if all water around were hidden. That times the range and the root of the hidden share, at most the
    sea's own rms height, is part of height_std; bars of single dwells and forecasts hold none of it."""
    coherent_s: Annotated[float, Ge(0.0), Le(0.02), Meaning("s", "of pulses added before they are multiplied")] = 0.0
    """Pulses added for [ms] | Duration of pulses that are added before receivers are compared; it pays far out, where
    noise rules, for sliding_plane and not for adaptive."""
    channels: Literal["as_given", "from_cross_paths"] = "as_given"
    """The channels' imbalance: channel_gain_db and channel_phase_deg, or measured from switched transmitters, lower to
    upper against upper to lower."""
    channel_gain_db: Annotated[
        float, Ge(-60.0), Le(60.0), Meaning("dB", "of the upper receiver over the lower"), _AS_GIVEN
    ] = 0.0
    """Gain of the upper receiver over the lower, known and taken out."""
    channel_phase_deg: Annotated[Direction, Meaning("°", "of the upper receiver over the lower"), _AS_GIVEN] = 0.0
    """Phase of the upper receiver over the lower, known and taken out."""
    map_time_s: Annotated[
        float | None,
        Ge(-60.0),
        Le(60.0),
        Meaning("s", "after each turn's start", left_out="each cell at the time when the beam passed it"),
    ] = None
    """Time of the ground maps, to which every wave runs on at its own speed in the direction that the radial velocities
    give."""
    depth_m: Annotated[
        float | None,
        Ge(0.05),
        Meaning("m", "of the water, as on a chart", infinite=True, left_out="a run takes sea.depth_m"),
    ] = None
    """Water depth | Depth of the water, from a chart: periods of the sea state and maps at map_time_s follow from it;
    inf is deep. Echoes alone do not hold it: `retrieve` without it takes deep water, and the sea state says so."""
    current_m_s: Annotated[
        float | None, Ge(0.0), Le(10.0), Meaning("m/s", "a uniform current", left_out="a run takes sea.current_m_s")
    ] = None
    """Speed of the current, from a chart, with which a map's waves run on; `retrieve` without it takes none."""
    current_toward_deg: Annotated[
        Direction | None,
        compass(
            "Current flows towards | Direction to which the current flows",
            left_out="a run takes sea.current_toward_deg",
        ),
    ] = None
    pulse_pairs: Annotated[Literal["both", "forward", "backward"], When("radar.interferogram", "alternating_pulse")] = (
        "both"
    )
    """Of alternating pulses: a lower antenna's pulse with the upper one's after it (`forward`), with that before it
    (`backward`), or `both`, whose Doppler phases cancel."""
    receivers: Annotated[tuple[int, int], BeforeValidator(as_tuple), Meaning("1")] = (0, 1)
    """The two receivers that are compared, numbered from 0."""
    min_snr_db: Annotated[float, Ge(-30.0), Le(60.0), Meaning("dB", "below it a cell has no echo")] = 0.0
    """Least signal to noise | Signal-to-noise ratio below which a cell is not answered."""
    ground_m: Annotated[float, Ge(1e-3), Le(1000.0), Meaning("m", "side of a ground cell")] = 3.0
    """Ground cell | Side of a ground cell."""

    @model_validator(mode="after")
    def _check_current(self) -> Self:
        if (self.current_m_s is None) != (self.current_toward_deg is None):
            raise ValueError("give current_m_s and current_toward_deg together: a current has a speed and a direction")
        return self

    @property
    def carried(self) -> str:
        """As echoes and maps carry them, in their attribute `retrieval`: JSON of what is not left at its default."""
        return json.dumps(self.model_dump(exclude_defaults=True))


def _size(text: str, shapes: str) -> Meaning:
    return Meaning("m", "sizes of boats", left_out="none: the shape needs no such", text=f"{text}; of {shapes}.")


Size = Annotated[float, Gt(0.0), Le(300.0)]
_BOX = When("shape", "box")
_FLOATING = When("shape", "disc box")
_FROM_FILE = When("shape", "file")
_VESSEL = When("prediction.vessel.shape", "raft disc box file")


class VesselSettings(Section):
    """The vessel whose heave, roll and pitch are forecast.

    `raft` follows the surface; `disc` is a buoy; `box` a box-shaped boat; `file` a NetCDF file of Capytaine.
    """

    shape: Literal["none", "raft", "disc", "box", "file"] = "none"
    """Which vessel: none forecasts the water alone."""
    length_m: Annotated[Size | None, _size("Length", "`box`"), _BOX] = None
    beam_m: Annotated[Size | None, _size("Beam", "`box`; diameter of `disc`"), _FLOATING] = None
    draught_m: Annotated[Size | None, _size("Draught", "`box` and `disc`"), _FLOATING] = None
    roll_period_s: Annotated[
        float | None, Gt(0.0), Le(60.0), Meaning("s", "periods of boats", left_out="by the box's stability"), _BOX
    ] = None
    """Natural period of roll, of `box`."""
    file: Annotated[str | None, Meaning(left_out="none: only the shape file needs one"), _FROM_FILE] = None
    """Path of a NetCDF file of Capytaine, of `file`; a relative one counts from the scene file's folder."""
    body: Annotated[str | None, Meaning(left_out="the only one there"), _FROM_FILE] = None
    """Which body of `file`: the name before `__Heave`. Others are there, and held fast."""
    symmetry: Annotated[
        Literal["sides", "sides_and_ends", "round"] | None,
        Meaning(left_out="none: the file has all directions"),
        _FROM_FILE,
    ] = None
    """What gives the directions of waves that `file` leaves out: with `sides` port is like starboard, with
    `sides_and_ends` bow like stern too, with `round` all directions are alike, and one is enough."""

    @model_validator(mode="after")
    def _check_shape_sizes(self) -> Self:
        needed = {"disc": ("beam_m", "draught_m"), "box": ("length_m", "beam_m", "draught_m"), "file": ("file",)}
        also = {"box": ("roll_period_s",), "file": ("body", "symmetry")}
        mine = needed.get(self.shape, ())
        for name in ("length_m", "beam_m", "draught_m", "roll_period_s", "file", "body", "symmetry"):
            given = getattr(self, name) is not None
            if name in mine and not given:
                raise ValueError(f'{name} is missing; shape = "{self.shape}" needs it')
            if given and name not in (*mine, *also.get(self.shape, ())):
                raise ValueError(f'{name} is given, but shape = "{self.shape}" has none; leave it out')
        return self


def _limit(label: str, of: str, unit: str) -> Meaning:
    text = f"{label} stays below | What {of} stays below, in magnitude."
    return Meaning(unit, "a limit", left_out="it is not limited", text=text)


class QuietSettings(Section):
    """What a quiet window is: limits that all hold for a time. None is looked for where no limit is given."""

    elevation_m: Annotated[float | None, Gt(0.0), Le(30.0), _limit("Water height", "the water's height", "m")] = None
    velocity_z_m_s: Annotated[
        float | None, Gt(0.0), Le(30.0), _limit("Water speed upwards", "the water's speed upwards", "m/s")
    ] = None
    heave_m: Annotated[float | None, Gt(0.0), Le(30.0), _limit("Heave", "the vessel's heave", "m"), _VESSEL] = None
    roll_deg: Annotated[float | None, Gt(0.0), Le(90.0), _limit("Roll", "the vessel's roll", "°"), _VESSEL] = None
    pitch_deg: Annotated[float | None, Gt(0.0), Le(90.0), _limit("Pitch", "the vessel's pitch", "°"), _VESSEL] = None
    duration_s: Annotated[float, Gt(0.0), Le(30.0), Meaning("s", "what is predictable")] = 5.0
    """Window lasts | How long a window lasts."""
    confidence: Annotated[float, Gt(0.0), Lt(1.0), Meaning("1", "a probability")] = 0.9
    """Probability from which on a window is called."""

    @property
    def limits(self) -> dict[str, float]:
        """By the names of what is forecast."""
        given = {
            "elevation": self.elevation_m,
            "velocity_z": self.velocity_z_m_s,
            "heave": self.heave_m,
            "roll": self.roll_deg,
            "pitch": self.pitch_deg,
        }
        return {name: limit for name, limit in given.items() if limit is not None}


class PredictionSettings(Section):
    """From maps to a forecast: of the sea, of a vessel in it, and of quiet windows."""

    turns: Annotated[int, Ge(1), Le(40), Meaning("1", "turns that the fit holds")] = 10
    """How many turns' maps a wave field rests on."""
    lead_s: Annotated[float, Ge(0.0), Le(60.0), Meaning("s", "beyond it the sea is not predictable")] = 30.0
    """Forecast ahead | How far ahead forecasts are made."""
    sharpness: Annotated[
        float | None,
        Ge(0.0),
        Le(1.0),
        Meaning("1", "from linear to first-order Lagrangian waves", left_out="as the maps show it"),
    ] = None
    """How far the water is moved by its own waves: 0 for waves of Airy, 1 for first-order Lagrangian ones."""
    amplitude_dispersion: Annotated[
        float | None, Ge(0.0), Le(1.0), Meaning("1", "from linear to third-order waves", left_out="as the maps show it")
    ] = None
    """How far waves run faster by the sea's own height: 0 for waves of Airy, 1 for the whole of what the third order in
    steepness adds on deep water."""
    heading_deg: Annotated[
        Direction | None,
        compass("Heading of the vessel while it runs on", left_out="the heading of the boat; north for maps alone"),
    ] = None
    speed_m_s: Annotated[
        float | None, Ge(0.0), Le(30.0), Meaning("m/s", "of boats", left_out="the speed of the boat; 0 for maps alone")
    ] = None
    """Speed over ground along that heading."""
    vessel: VesselSettings = VesselSettings()
    """What floats there."""
    quiet: QuietSettings = QuietSettings()
    """Quiet windows | What counts as quiet."""

    @model_validator(mode="after")
    def _check_motions(self) -> Self:
        motions = sorted(set(self.quiet.limits) & {"heave", "roll", "pitch"})
        if motions and self.vessel.shape == "none":
            raise ValueError(f"quiet limits {motions[0]}, but there is no vessel; give vessel.shape")
        if self.quiet.limits and self.quiet.duration_s > self.lead_s:
            raise ValueError(
                f"quiet.duration_s = {self.quiet.duration_s:g}: is longer than lead_s = {self.lead_s:g}; shorten it"
            )
        return self
