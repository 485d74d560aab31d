"""[retrieval]: how echoes become heights."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le
from pydantic import BeforeValidator

from .limits import Meaning
from .section import Section, as_tuple


class RetrievalSettings(Section):
    """How echoes become heights.

    `sr.retrieve(echoes)` takes the defaults of this section, not the scene's: give `scene.retrieval`, or
    `--set retrieval.KEY=VALUE`.
    """

    cell_range_m: Annotated[
        float, Gt(0.0), Le(1000.0), Meaning("Length of a cell in range.", unit="m", reason="a cell has a length")
    ] = 3.0
    cell_azimuth_deg: Annotated[
        float,
        Gt(0.0),
        Le(45.0),
        Meaning("Width of a cell, a look; it may be finer than the beam.", unit="°", reason="a cell has a width"),
    ] = 1.8
    estimator: Annotated[
        Literal["adaptive", "sliding_plane", "single_cell"],
        Meaning(
            "`adaptive`: optimal interpolation (Bretherton et al. 1976) between single dwells and gates, each trusted "
            "as far as its own echo goes, along the sea's covariance as the map itself shows it; `sliding_plane`: "
            "takes the slopes from a first map and averages along them over a wider window, less speckle for a "
            "resolution of about the window; `single_cell`: averages the covariance over one cell."
        ),
    ] = "adaptive"
    window_range_m: Annotated[
        float,
        Gt(0.0),
        Le(1000.0),
        Meaning("Length of the window of sliding_plane.", unit="m", reason="length of the sliding window"),
    ] = 4.5
    window_azimuth_deg: Annotated[
        float,
        Gt(0.0),
        Le(45.0),
        Meaning("Width of the window of sliding_plane.", unit="°", reason="width of the sliding window"),
    ] = 2.7
    paths: Annotated[
        Literal["best", "one_way"],
        Meaning(
            "`best`: where transmitters alternate and both receivers hear all, each antenna on itself (p = 2), whose "
            "phase is twice as steep, resolved by one antenna to both (p = 1) of the same echoes; `one_way`: p = 1."
        ),
    ] = "best"
    ambiguity: Annotated[
        Literal["resolve", "fold"],
        Meaning(
            "Which cycle a phase is on. `resolve`: cells are grown from the surest on, round shadows, by the mean "
            "level, by p = 1 and by their neighbours, and what stays in doubt is flagged `ambiguous`; `fold`: all "
            "within half an ambiguity of mean level."
        ),
    ] = "resolve"
    crest_bias: Annotated[
        Literal["report", "remove"],
        Meaning("Of partly shadowed cells, what is in sight stands above the cell's mean: reported, or removed."),
    ] = "report"
    coherent_s: Annotated[
        float,
        Ge(0.0),
        Le(0.02),
        Meaning(
            "Duration of pulses that are added before receivers are compared; it pays far out, where noise rules, for "
            "sliding_plane and not for adaptive.",
            unit="s",
            reason="of pulses added before they are multiplied",
        ),
    ] = 0.0
    channels: Annotated[
        Literal["as_given", "from_cross_paths"],
        Meaning(
            "The channels' imbalance: channel_gain_db and channel_phase_deg, or measured from switched transmitters, "
            "lower to upper against upper to lower."
        ),
    ] = "as_given"
    channel_gain_db: Annotated[
        float,
        Ge(-60.0),
        Le(60.0),
        Meaning(
            "Gain of the upper receiver over the lower, known and taken out.",
            unit="dB",
            reason="of the upper receiver over the lower",
        ),
    ] = 0.0
    channel_phase_deg: Annotated[
        float,
        Ge(-360.0),
        Le(360.0),
        Meaning(
            "Phase of the upper receiver over the lower, known and taken out.",
            unit="°",
            reason="of the upper receiver over the lower",
        ),
    ] = 0.0
    map_time_s: Annotated[
        float | None,
        Ge(-60.0),
        Le(60.0),
        Meaning(
            "Time of the ground maps, to which every wave runs on at its own speed in the direction that the radial "
            "velocities give.",
            unit="s",
            reason="after each turn's start",
            left_out="each cell at the time when the beam passed it",
        ),
    ] = None
    depth_m: Annotated[
        float,
        Gt(0.0),
        Meaning(
            "Depth of the water, in which waves run on to map_time_s; inf is deep.",
            unit="m",
            reason="of the water, in which waves run on to map_time_s",
            infinite=True,
        ),
    ] = math.inf
    pulse_pairs: Annotated[
        Literal["both", "forward", "backward"],
        Meaning(
            "Of alternating pulses: a lower antenna's pulse with the upper one's after it (`forward`), with that "
            "before it (`backward`), or `both`, whose Doppler phases cancel."
        ),
    ] = "both"
    receivers: Annotated[
        tuple[int, int],
        BeforeValidator(as_tuple),
        Meaning("The two receivers that are compared, numbered from 0.", unit="1"),
    ] = (0, 1)
    min_snr_db: Annotated[
        float,
        Ge(-30.0),
        Le(60.0),
        Meaning(
            "Signal-to-noise ratio below which a cell is not answered.", unit="dB", reason="below it a cell has no echo"
        ),
    ] = 0.0
    ground_m: Annotated[
        float, Gt(0.0), Le(1000.0), Meaning("Side of a ground cell.", unit="m", reason="side of a ground cell")
    ] = 3.0
