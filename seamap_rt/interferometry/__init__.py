"""Echoes → phase, height and slope, on the ground. Reads echoes and the radar's own description, nothing else.

It sees no truth, loads neither Dr.Jit nor Mitsuba, and takes ray-traced, analytic and recorded echoes alike. Settings
(`[retrieval]`; `retrieve(echoes)` takes those that the echoes carry, their scene's, unless it is given others):

    estimator    adaptive (the default): optimal interpolation (Bretherton et al. 1976) between single dwells and gates.
                 Each is weighted by its own echo, with the sea's covariance as the map itself shows it; waves
                 shorter than it shows are those of a wind sea's spectrum, k⁻⁴ (Phillips 1958), at the map's own level.
                 Where in a gate its echo comes from follows from the powers of the gates beside it (Tweedie's formula).
                 sliding_plane: one window that follows the slopes. single_cell: no window.
    paths        best: where transmitters alternate and both receivers hear all, each antenna on itself, p = 2, between
                 neighbouring pulses; p = 1 of the same echoes gives the cycle. one_way: p = 1.
    ambiguity    resolve: regions of cells grow from the most certain on, round shadows, by the mean level, by p = 1 and
                 by their neighbours; cells that stay in doubt are flagged ambiguous.
                 fold: all within half an ambiguity of mean level.
    crest_bias   report, or remove: in partly shadowed cells what is seen stands above the mean of the cell.
    map_time_s   ground maps at one instant: each wave is advanced at its own speed, in the direction that the radial
                 velocities give.
    channels     as_given (channel_gain_db, channel_phase_deg), or from_cross_paths: lower to upper against upper to
                 lower.
    coherent_s   pulses added up before the receivers are compared; pays far out for sliding_plane, not for adaptive.
    cell_range_m, cell_azimuth_deg
                 the cells; looks may be finer than the beam.

`/polar` holds, beside heights, slopes and error bars: `radial_velocity` of what echoes (it includes the own speeds of
Bragg waves and breakers) and `doppler_width` (0 where it is too narrow to be measured), neither of a magnetron whose
phases are not taken off; `visible_share` and `crest_bias`, estimated from the echo alone; and the flags.

Heights of adaptive are expectations: where the echo is weak they stay near mean level, so their spread is less than
the sea's. Take the wave height from `seamap_rt.sea_state`, which allows for that.

Recordings: `open_recording(file, header)` or `echoes_from_recording(lower, upper, header, time=…, azimuth=…)`.
`seamap_rt/io/recording_header.py` lists the header's keys: conjugated phases, cable delays, encoder counts, a heading
sensor's own clock. `seamap_rt.inspection` judges what was recorded: sign of the phase, offsets, gaps, gain.

Evidence: validation/models/retrieval.md and error_bars.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_attributes

if TYPE_CHECKING:
    from .recorded import echoes_from_recording, open_recording
    from .retrieval import open_echoes, retrieve, retrieve_one

__all__ = ["echoes_from_recording", "open_echoes", "open_recording", "retrieve", "retrieve_one"]

__getattr__ = lazy_attributes(
    __name__,
    {
        "recorded": "echoes_from_recording open_recording",
        "retrieval": "open_echoes retrieve retrieve_one",
    },
)
