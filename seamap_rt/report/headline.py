"""A run in a few figures, and in one paragraph."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from ..radar.array import antenna_array
from ..scene import Scene
from . import maps, reduce
from .page_elements import digits, metres, percent


def summary(scene: Scene, truth: xr.DataTree, metrics: Mapping[str, Any]) -> str:
    """The run in one paragraph."""
    figures = dict(headline(scene, truth, metrics))
    waves = "; ".join(maps.describe_waves(each, scene.sea.depth_m) for each in scene.sea.waves) or "no waves"
    radar, array = scene.radar, antenna_array(scene.radar)
    boat = {
        "sinusoidal": " on a rolling boat",
        "file": " on a moving boat",
        "wave_following": " on a boat that rides it",
    }
    return (
        f"A simulated radar {radar.height_m:g} m above the sea{boat.get(scene.platform.motion, '')}, "
        f"with {_few(len(array.elements))} antennas {array.baseline_m:g} m apart, "
        f"mapped this sea: {waves}. Between {reduce.JUDGED_M[0]:g} and {reduce.JUDGED_M[1]:g} m, in cells more than "
        f"half visible, the retrieved height is off by {figures['Height error, rms']} rms "
        f"({figures['Height error, robust']} robust, bias {figures['Height bias']}), and its "
        f"correlation with the true height is {figures['Correlation']}. Four "
        f"standard deviations of the true heights there are {figures['Hs, true']}, of the map's, which are means "
        f"of what may be, {figures['Hs, retrieved']}{_retrieved_state(metrics)}. "
        f"Both antennas see {figures['Visible at 100 m']} of the sea at 100 m and "
        f"{figures['Visible at 160 m']} at 160 m; what lies in shadow stays blank in the maps, or is flagged."
    )


def _retrieved_state(metrics: Mapping[str, Any]) -> str:
    words = metrics.get("sea_state_in_words")
    return f"; with its noise, gaps and cells allowed for it says {words}" if words else ""


def _few(number: int) -> str:
    return {2: "two", 3: "three", 4: "four"}.get(number, str(number))


def headline(scene: Scene, truth: xr.DataTree, metrics: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The figures at the top of the page: label and value."""
    overall = metrics.get("overall")
    overall = overall if isinstance(overall, Mapping) else {}
    return [
        ("Height error, rms", metres(overall.get("height_rmse_m"))),
        ("Height error, robust", metres(overall.get("height_robust_m"))),
        ("Height bias", metres(overall.get("height_bias_m"), signed=True)),
        ("Correlation", digits(overall.get("height_correlation"), 3)),
        ("Hs, true", metres(overall.get("hs_true_m"), 2)),
        ("Hs, retrieved", metres(overall.get("hs_retrieved_m"), 2)),
        ("Visible at 100 m", percent(reduce.visible_at(truth, scene.radar.height_m, 100.0))),
        ("Visible at 160 m", percent(reduce.visible_at(truth, scene.radar.height_m, 160.0))),
    ]


def forecast_line(metrics: Mapping[str, Any]) -> str:
    """What forecasts at the first place were worth, in a line."""
    rows = [row for row in metrics.get("prediction") or () if row["place"] == 0 and row["lead_s"][0] > 0.0]
    if not rows:
        return "forecasts: none; no turn shows a sea"
    ahead = "; ".join(
        f"{row['lead_s'][0]:g}–{row['lead_s'][1]:g} s correlation {digits(row['correlation'], 3)}, error "
        f"{digits(row['error_share'], 2)} σ (stated {digits(row['stated_share'], 2)}, persistence "
        f"{digits(row['persistence_share'], 2)})"
        for row in rows
    )
    return f"{rows[0]['forecasts']} forecasts at the boat: {ahead}"


def window_line(metrics: Mapping[str, Any]) -> str:
    """What quiet windows were worth, in a line; empty where none were judged."""
    told = metrics.get("quiet_windows")
    if not told:
        return ""
    right = f", {percent(told['right'])} of them right" if told["called"] else ""
    return (
        f"quiet windows: {told['called']} of {told['windows']} called at {told['confidence']:.0%}{right}, "
        f"{percent(told['found'])} of the quiet ones; area under hits against false alarms {digits(told['area'], 3)} "
        f"(persistence {digits(told['persistence_area'], 3)})"
    )
