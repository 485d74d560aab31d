"""Range window, patch of sea, range gates and ground map."""

from __future__ import annotations

from ...conventions import SPEED_OF_LIGHT
from ...io.text import rounded_down, rounded_up
from ...radar.grid import MOST_GROUND_CELLS, ground_cells, least_ground_side
from ...radar.waveform import RangeResponse, gate_spacing_m
from ...settings import RadarSettings, RandomWaves, RetrievalSettings, SeaSettings

_LONG = 0.05  # share of waves too long for a record's patch, from which on it is told
LEAST_MARGIN_M = 30.0  # beyond the far gate; the mesh itself runs on by the range response's reach


def check_height(radar: RadarSettings) -> None:
    """The far end of the range window reaches the sea."""
    (near, far), height = radar.range_m, radar.height_m
    if far <= height:
        raise ValueError(
            f"radar.range_m = [{near:.10g},{far:.10g}]: its far end must be greater than radar.height_m "
            f"= {height:.10g} (the sea lies farther below the antenna, so nothing is seen); raise the "
            "far end or lower radar.height_m"
        )


def check_patch(radar: RadarSettings, sea: SeaSettings) -> None:
    """The range circle fits in the periodic patch, if the waves repeat."""
    margin = max(LEAST_MARGIN_M, RangeResponse.of(radar).support_m)
    needed, extent = 2.0 * (radar.range_m[1] + margin), sea.extent_m
    if sea.model == "recorded":
        check_reach(sea, radar, margin)
        return
    repeats = any(
        isinstance(waves, RandomWaves) and getattr(waves, "spreading", None) != "long_crested" for waves in sea.waves
    )
    if repeats and extent < needed:
        room = 0.5 * extent - margin
        nearer = f" or lower the far end of radar.range_m to {rounded_down(room)}" if room > 0.0 else ""
        raise ValueError(
            f"sea.extent_m = {extent:.10g}: must be at least {rounded_up(needed)} (the range circle, 2 × (far "
            f"end of radar.range_m + {margin:.10g} m), must fit in the periodic patch, or the same "
            f"waves are seen twice); raise sea.extent_m{nearer}"
        )


def check_reach(sea: SeaSettings, radar: RadarSettings, margin: float) -> None:
    """A recorded patch holds the range circle and a margin [m], or is to be continued beyond; one that repeats is
    not."""
    from ...io.recorded_sea import recorded_sea  # loads what reads files

    file = recorded_sea(sea.file)
    if file.periodic and sea.beyond != "refused":
        raise ValueError(
            f"sea.beyond = '{sea.beyond}': must be 'refused', for the patch of sea.file repeats; leave it out"
        )
    near, far = radar.range_m
    if sea.beyond == "refused" and file.reach_m < far + margin:
        room = file.reach_m - margin
        nearer = f", or lower the far end of radar.range_m to {rounded_down(room)}" if room > near else ""
        more = "" if file.periodic else ", or have it continued beyond (sea.beyond = 'level' or 'mirrored')"
        raise ValueError(
            f"sea.file reaches {file.reach_m:.10g} m from the antenna: must reach {rounded_up(far + margin)} (the far "
            f"end of radar.range_m + {margin:.10g} m); give a larger record{nearer}{more}"
        )


def check_start(sea: SeaSettings) -> None:
    """A recorded sea's time 0 lies in its record, with what is taken from before and after it."""
    if sea.model == "recorded" and sea.start_s is not None:
        from ...io.recorded_sea import recorded_sea  # loads what reads files
        from ...sea.recorded import start_of

        start_of(recorded_sea(sea.file), sea.start_s)


def told_of_record(sea: SeaSettings, radar: RadarSettings) -> list[str]:
    """What one should know of a recorded sea before it is run, a line each: how far it reaches, and what comes
    beyond."""
    if sea.model != "recorded":
        return []
    from ...io.recorded_sea import recorded_sea  # loads what reads files
    from ...sea.recorded import start_of

    file = recorded_sea(sea.file)
    frame, late = start_of(file, sea.start_s)
    begin, end = file.begin_s, file.begin_s + (file.frames - 1) * file.step_s
    told = [
        f"sea.file = '{sea.file}' runs from {file.said(begin)} to {file.said(end)}; time 0 of the run is its "
        f"{file.said(begin + frame * file.step_s + late)} (sea.start_s)"
    ]
    if file.cut:
        told.append(
            f"sea.file = '{sea.file}': {file.points} × {file.points} points of it are used, {file.side_m:.4g} m a "
            "side: the largest square without gaps at its edges"
        )
    if file.long_share > _LONG:
        told.append(
            f"sea.file = '{sea.file}': {file.long_share:.0%} of the variance are waves longer than its patch of "
            f"{file.side_m:.4g} m: their heights are kept, how the water flows to and fro in them is not known"
        )
    if not file.periodic and file.reach_m < radar.range_m[1]:
        how = {"level": "the sea is level", "mirrored": "the patch is mirrored"}.get(sea.beyond, "it ends")
        reach = f"{file.reach_m:.4g} m from the antenna" if file.reach_m > 0.0 else "not to the antenna"
        told.append(
            f"sea.file = '{sea.file}' reaches {reach}, radar.range_m to {radar.range_m[1]:g} m: beyond {how}, and "
            "nothing there is judged"
        )
    return told


def check_gates(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """Gates lie no further apart than cells are long and than the range resolution."""
    sampling, cell = radar.range_sampling_m, retrieval.cell_range_m
    if sampling > cell:
        raise ValueError(
            f"radar.range_sampling_m = {sampling:.10g}: must be at most retrieval.cell_range_m = "
            f"{cell:.10g} (else cells hold no gate); lower radar.range_sampling_m or lengthen "
            "retrieval.cell_range_m"
        )
    chirp = radar.waveform == "chirp"
    swept = radar.chirp_bandwidth_hz if chirp else 1.0 / radar.pulse_width_s
    resolution = SPEED_OF_LIGHT / (2.0 * min(radar.bandwidth_hz, swept))
    if gate_spacing_m(radar) > resolution:
        raise ValueError(
            f"radar.range_sampling_m = {sampling:.10g}: must be at most the range resolution of "
            f"{rounded_down(resolution)} m (c/2 over the lesser of radar.bandwidth_hz and "
            f"{'radar.chirp_bandwidth_hz' if chirp else '1/radar.pulse_width_s'}; the sea between the gates "
            f"would be missed); lower radar.range_sampling_m to {rounded_down(resolution)}"
        )


def check_window(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """The range window holds a cell."""
    (near, far), cell = radar.range_m, retrieval.cell_range_m
    length = max(cell, 2.0 * gate_spacing_m(radar))
    if far - near < length:
        raise ValueError(
            f"radar.range_m = [{near:.10g},{far:.10g}]: must be at least {length:.4g} long (a cell of "
            "retrieval.cell_range_m, or three gates); raise its far end"
        )


def check_ground_map(radar: RadarSettings, retrieval: RetrievalSettings) -> None:
    """The ground map fits memory."""
    far, side = radar.range_m[1], retrieval.ground_m
    cells = ground_cells(far, side)
    if cells > MOST_GROUND_CELLS:
        raise ValueError(
            f"retrieval.ground_m = {side:.10g}: must be at least {rounded_up(least_ground_side(far))} (the ground map "
            f"would have {cells:.3g} cells, and may have {MOST_GROUND_CELLS:.3g}); raise retrieval.ground_m"
        )
