"""[retrieval]: how echoes become heights."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from annotated_types import Ge, Le
from pydantic import BeforeValidator, model_validator

from .section import Direction, Meaning, Section, as_tuple, compass


class RetrievalSettings(Section):
    """How echoes become heights.

    `sr.retrieve(echoes)` takes the defaults of this section, not the scene's: give
    `scene.resolved_retrieval`, which knows the scene's depth and current, or `--set retrieval.KEY=VALUE`.
    """

    cell_range_m: Annotated[float, Ge(1e-3), Le(1000.0), Meaning("m", "a cell has a length")] = 3.0
    """Length of a cell in range."""
    cell_azimuth_deg: Annotated[float, Ge(1e-4), Le(45.0), Meaning("°", "a cell has a width")] = 1.8
    """Width of a cell, a look; it may be finer than the beam."""
    estimator: Literal["adaptive", "sliding_plane", "single_cell"] = "adaptive"
    """`adaptive`: optimal interpolation (Bretherton et al. 1976) between single dwells and gates, each trusted as far
    as its own echo goes, along the sea's covariance as the map itself shows it; `sliding_plane`: takes the slopes from
    a first map and averages along them over a wider window, less speckle for a resolution of about the window;
    `single_cell`: averages the covariance over one cell."""
    window_range_m: Annotated[float, Ge(1e-3), Le(1000.0), Meaning("m", "length of the sliding window")] = 4.5
    """Length of the window of sliding_plane."""
    window_azimuth_deg: Annotated[float, Ge(1e-4), Le(45.0), Meaning("°", "width of the sliding window")] = 2.7
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
    coherent_s: Annotated[float, Ge(0.0), Le(0.02), Meaning("s", "of pulses added before they are multiplied")] = 0.0
    """Duration of pulses that are added before receivers are compared; it pays far out, where noise rules, for
    sliding_plane and not for adaptive."""
    channels: Literal["as_given", "from_cross_paths"] = "as_given"
    """The channels' imbalance: channel_gain_db and channel_phase_deg, or measured from switched transmitters, lower to
    upper against upper to lower."""
    channel_gain_db: Annotated[float, Ge(-60.0), Le(60.0), Meaning("dB", "of the upper receiver over the lower")] = 0.0
    """Gain of the upper receiver over the lower, known and taken out."""
    channel_phase_deg: Annotated[float, Ge(-360.0), Le(360.0), Meaning("°", "of the upper receiver over the lower")] = (
        0.0
    )
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
    """Depth of the water, from a chart: periods of the sea state and maps at map_time_s follow from it; inf is deep.
    Echoes alone do not hold it: `retrieve` without it takes deep water, and the sea state says so."""
    current_m_s: Annotated[
        float | None, Ge(0.0), Le(10.0), Meaning("m/s", "a uniform current", left_out="a run takes sea.current_m_s")
    ] = None
    """Speed of the current, from a chart, with which a map's waves run on; `retrieve` without it takes none."""
    current_toward_deg: Annotated[
        Direction | None,
        compass("Direction to which the current flows", left_out="a run takes sea.current_toward_deg"),
    ] = None
    pulse_pairs: Literal["both", "forward", "backward"] = "both"
    """Of alternating pulses: a lower antenna's pulse with the upper one's after it (`forward`), with that before it
    (`backward`), or `both`, whose Doppler phases cancel."""
    receivers: Annotated[tuple[int, int], BeforeValidator(as_tuple), Meaning("1")] = (0, 1)
    """The two receivers that are compared, numbered from 0."""
    min_snr_db: Annotated[float, Ge(-30.0), Le(60.0), Meaning("dB", "below it a cell has no echo")] = 0.0
    """Signal-to-noise ratio below which a cell is not answered."""
    ground_m: Annotated[float, Ge(1e-3), Le(1000.0), Meaning("m", "side of a ground cell")] = 3.0
    """Side of a ground cell."""

    @model_validator(mode="after")
    def _a_current_has_speed_and_direction(self) -> Self:
        if (self.current_m_s is None) != (self.current_toward_deg is None):
            raise ValueError("give current_m_s and current_toward_deg together: a current has a speed and a direction")
        return self
