"""A run in a few figures, in one paragraph, in rows and warnings of its sea; and what metrics.json says of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr

from ..conventions import db, written
from ..echoes.radar_cross_section import SeaSurface
from ..io.text import to_builtin
from ..radar.array import antenna_array
from ..scattering import ShortWaves
from ..scene import Scene
from ..sea import Sea, spectral_system
from ..settings import RandomWaves
from . import reduce
from .limits import costed, modelled, not_modelled
from .page_elements import digits, metres, percent

_GROSS = 0.005  # of the heights: fewer wrong ones are not worth a word
_NO_WAVES_DB = -60.0  # a spectrum that begins so far below the resolved waves' has none there
_LEAST_COVERED = 0.9  # of the ground cells of the first turn


def _group(metrics: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """A mapping of the metrics; empty where they have none."""
    result = metrics.get(name)
    return result if isinstance(result, Mapping) else {}


def run_line(scene: Scene) -> str:
    """What ran, by the keys that matter most, as they were in the end."""
    turns = f"{scene.turns} turn{'s' * (scene.turns > 1)}"
    array = antenna_array(scene.radar)
    radar = (
        f"{scene.radar.height_m:g} m mast, antennas {array.baseline_m:g} m apart, {scene.radar.transmit_power_w:g} W"
    )
    return f"Scene {scene.name}, seed {scene.seed}, {turns}; {radar}"


def verdict(metrics: Mapping[str, Any]) -> str:
    """What the radar does of this sea, in a sentence; empty where the metrics do not say."""
    measured, overall = _group(metrics, "measured"), _group(metrics, "overall")
    if measured.get("fully_measured_radius_m") is None:
        return ""
    reach, radius = measured["reach_m"], measured["fully_measured_radius_m"]
    if not reach:
        why = "its heights are no better than the mean level at any range"
        if overall.get("cells") == 0 and overall.get("visible_fraction") is not None:
            why = f"no cell gets a sure height, and {percent(overall['visible_fraction'])} of the sea is in sight"
        return f"This radar hardly measures this sea: {why}."
    error, missed, band = overall.get("height_rmse_m"), measured.get("missed_share"), overall.get("range_m")
    heights = ""
    if error is not None:
        heights = ", their height to ± " + (f"{100.0 * error:.0f} cm" if error >= 0.01 else f"{1000.0 * error:.0f} mm")
    at = f" at {band[0]:.0f} to {band[1]:.0f} m" if band else ""
    blank = f"; it misses {percent(missed)} of the cells{at}" if missed is not None else ""
    gross = measured.get("gross_share") or 0.0
    wrong = (
        f", and {percent(gross)} of its heights are wrong by more than half the wave height" if gross > _GROSS else ""
    )
    more = "more than " if measured.get("reach_to_the_end") else ""
    return f"Sees the waves out to {more}{reach:.0f} m{heights}: {radius_in_words(radius)}{blank}{wrong}."


def radius_in_words(radius_m: float) -> str:
    """What a fully measured radius means."""
    return f"in all as much as a map without gaps or errors out to {radius_m:.0f} m (fully measured radius)"


def summary(scene: Scene, truth: xr.DataTree, metrics: Mapping[str, Any]) -> str:
    """The run in one paragraph."""
    figures, sea_state = dict(headline(metrics)), metrics.get("sea_state_in_words")
    waves = "; ".join(reduce.describe_waves(each, scene.sea.depth_m) for each in scene.sea.waves) or "no waves"
    state = f"; the maps, with their noise, gaps and cells allowed for, say {sea_state}" if sea_state else ""
    radar, array = scene.radar, antenna_array(scene.radar)
    few = {2: "two", 3: "three", 4: "four"}.get(len(array.elements), str(len(array.elements)))
    boat = {
        "sinusoidal": " on a rolling boat",
        "file": " on a moving boat",
        "wave_following": " on a boat that rides it",
    }
    return (
        f"A simulated radar {radar.height_m:g} m above the sea{boat.get(scene.platform.motion, '')}, "
        f"with {few} antennas {array.baseline_m:g} m apart, "
        f"mapped this sea: {waves}. At {reduce.judged_band(truth)}, in cells more than half visible, the retrieved "
        f"height is off by {figures['Height error, rms']} rms "
        f"({figures['Height error, robust']} robust, bias {figures['Height bias']}), and its "
        f"correlation with the true height is {figures['Correlation']}. The scene's wave height is "
        f"{figures['Wave height Hs, of the scene']}{state}. Half of the sea "
        f"is visible to {figures['Half visible to']}; what lies in shadow stays blank in the maps, or "
        "is flagged."
    )


def wave_height(metrics: Mapping[str, Any]) -> str:
    """Wave height of the sea at large, by all turns' maps, with its standard error."""
    state = _group(metrics, "sea_state")
    series = (reduce.series(state.get(f"significant_wave_height{name}")) for name in ("", "_std", "_least"))
    height, error, least = (float(values[-1]) if values.size else np.nan for values in series)
    if not np.isfinite(height):
        return f"at least {written(least, 2)} m" if np.isfinite(least) else metres(None)
    return f"{written(height, 2)} ± {written(error, 2)} m" if np.isfinite(error) else f"{written(height, 2)} m"


def _whole_metres(value: Any) -> str:
    return f"{digits(value, 0)} m" if value is not None else digits(None, 0)


def headline(metrics: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The figures at the top of the page: label and value."""
    overall, measured = _group(metrics, "overall"), _group(metrics, "measured")
    return [
        ("Fully measured radius", _whole_metres(measured.get("fully_measured_radius_m"))),
        ("Reach", _whole_metres(measured.get("reach_m"))),
        ("Height error, rms", metres(overall.get("height_rmse_m"))),
        ("Height error, robust", metres(overall.get("height_robust_m"))),
        ("Height bias", metres(overall.get("height_bias_m"), signed=True)),
        ("Correlation", digits(overall.get("height_correlation"), 3)),
        ("Wave height Hs, of the scene", metres(metrics.get("hs_scene_m"), 2)),
        ("Wave height Hs, from the maps", wave_height(metrics)),
        ("Half visible to", reduce.half_visible_in_words(metrics)),
    ]


def sea_rows(metrics: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Label and value of each fact that the metrics hold of the sea; none if they hold none."""
    sea = _group(metrics, "sea")
    if not sea:
        return []
    rows = [
        ("Resolved", f"waves longer than {_number(sea, 'resolution_m', 3, 2.0)} m"),
        ("Share of the variance resolved", _share(sea, "variance_share")),
        ("Share of the same spectra's mean square slope resolved", _share(sea, "mean_square_slope_share")),
        ("Significant height, resolved (4σ)", f"{_number(sea, 'elevation_std', 3, 4.0)} m"),
        ("Mean square slope, resolved", _number(sea, "mean_square_slope", 3)),
        ("Rms slope towards east, north", f"{_number(sea, 'slope_std_east', 3)}, {_number(sea, 'slope_std_north', 3)}"),
        ("Significant height over the peak's length", _number(sea, "significant_steepness", 2)),
    ]
    short = _group(metrics, "short_waves")
    if short:
        no_waves = reduce.number(short.get("level_step_db")) < _NO_WAVES_DB
        step = "the wind raises no waves of that length" if no_waves else f"{_number(short, 'level_step_db', 2)} dB"
        rows += [
            ("Left to the scattering: waves shorter than", f"{2.0 * np.pi / short['wavenumber_from']:.3g} m"),
            ("Their mean square slope", _number(short, "mean_square_slope", 3)),
            ("Share of the whole mean square slope on the mesh", _share(short, "resolved_slope_share")),
            ("Step of the spectrum where they take over", step),
        ]
    choppy = _group(sea, "choppy")
    if choppy:
        rows += [
            ("Choppy: mean level put back", f"{_number(choppy, 'set_down', 2, 100.0)} cm"),
            ("Choppy: waves enlarged to keep the height", f"× {_number(choppy, 'amplitude_scale', 4)}"),
            ("Choppy: skewness of the elevation", _number(choppy, "skewness", 2)),
            ("Choppy: share of the water that folds over at time 0", _share(choppy, "folded_share", 3)),
            ("Choppy: most of a turn's mesh under a fold", _share(metrics, "folded_share", 3)),
        ]
    rows.append(("Skewness of a narrow-banded second-order sea (3kσ)", _number(sea, "skewness_stokes", 2)))
    return rows


def warnings(metrics: Mapping[str, Any]) -> list[str]:
    """Warnings that a reader must see before any figure, one line each."""
    notes = (fold_warning(metrics), ground_warning(metrics), objects_warning(metrics))
    return [*(each for each in notes if each), *(metrics.get("vessel_notes") or ())]


def fold_warning(metrics: Mapping[str, Any]) -> str | None:
    """One line if choppy waves folded over anywhere, else None."""
    water = reduce.number(_group(_group(metrics, "sea"), "choppy").get("folded_share"))
    mesh = reduce.number(metrics.get("folded_share"))
    worst = np.nanmax([water, mesh, 0.0])
    if worst <= 0.0:
        return None
    return (
        f"sea.model = 'choppy': crests fold over on {water:.2g} of the water and {mesh:.2g} of the mesh; the highest "
        "sheet is meshed there"
    )


def ground_warning(metrics: Mapping[str, Any]) -> str | None:
    """One line if the boat ran off the ground maps, else None."""
    covered = reduce.number(metrics.get("ground_covered"))
    if not covered < _LEAST_COVERED:
        return None
    return (
        f"the boat runs off the ground maps, which lie around its start: of the last turn they hold {covered:.0%}; the "
        "polar maps hold all of it"
    )


def objects_warning(metrics: Mapping[str, Any]) -> str | None:
    """One line if objects echo more than the sea around them, else None."""
    rows = [row for row in metrics.get("modelled") or () if row.get("what") == "objects"]
    over = next((reduce.number(row["value"]) for row in rows if row["unit"].startswith("dB")), np.nan)
    if not over > 0.0:
        return None
    return (
        f"objects echo up to {over:.0f} dB over the sea in their cells: there, and in their sidelobes, heights are "
        "theirs and not the sea's"
    )


def _number(facts: Mapping[str, Any], name: str, digits: int, factor: float = 1.0) -> str:
    value = factor * reduce.number(facts.get(name))
    return f"{value:.{digits}g}" if np.isfinite(value) else "—"


def _share(facts: Mapping[str, Any], name: str, digits: int = 4) -> str:
    value = 100.0 * reduce.number(facts.get(name))
    return f"{value:.{digits}g} %" if np.isfinite(value) else "—"


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
    longest = f"maximum prediction time {digits(rows[0].get('maximum_prediction_time_s'), 2)} s"
    return f"{rows[0]['forecasts']} forecasts at the boat: {ahead}; {longest}"


def window_line(metrics: Mapping[str, Any]) -> str:
    """What quiet windows were worth, in a line; empty where none were judged."""
    rate = metrics.get("quiet_windows")
    if not rate:
        return ""
    right = f", {percent(rate['right'])} of them right" if rate["called"] else ""
    return (
        f"quiet windows: {rate['called']} of {rate['windows']} called at {rate['confidence']:.0%}{right}, "
        f"{percent(rate['found'])} of the quiet ones; area under hits against false alarms {digits(rate['area'], 3)} "
        f"(persistence {digits(rate['persistence_area'], 3)})"
    )


def run_facts(scene: Scene, sea: Sea, surface: SeaSurface, timing: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The keys `modelled`, `left_out`, `mesh`, `sea`, `short_waves` and `calibration` of metrics.json.

    sea, surface: the run's own, of its Simulator. timing: `timing_s` of metrics.json; adds to the rows of `modelled`
    what each took.
    """
    rows = modelled(scene, sea.resolved)
    return {
        "modelled": rows if timing is None else costed(rows, timing),
        "left_out": not_modelled(scene, sea.resolved),
        "mesh": scene.detail.facts(),
        "sea": {name: to_builtin(value) for name, value in asdict(sea.resolved).items()},
        "short_waves": _short_waves(scene, sea),
        "calibration": _calibration(scene, surface),
    }


def _calibration(scene: Scene, surface: SeaSurface) -> dict[str, list[float]] | None:
    """How many dB the calibration adds to what theory gives, by grazing angle and direction; None without one."""
    scale = surface.scale
    if scale is None:
        return None
    (near, far), height = scene.radar.range_m, scene.radar.height_m
    grazing = np.geomspace(np.arcsin(height / far), np.arcsin(min(1.0, height / near)), 5)
    looks = {"up_wind_db": 0.0, "cross_wind_db": 0.5 * np.pi, "down_wind_db": np.pi}
    added = {name: db(scale(grazing, angle)).tolist() for name, angle in looks.items()}
    return {"grazing_deg": np.degrees(grazing).tolist(), **added}


def _short_waves(scene: Scene, sea: Sea) -> dict[str, float] | None:
    """What the scattering takes over from the mesh; None where its level is a given."""
    scattering, limit = scene.scattering, sea.resolved.wavenumber_limit
    if scattering.nrcs != "two_scale":
        return None
    waves = ShortWaves.of(scattering, limit)
    systems = [spectral_system(each, scene.sea.depth_m) for each in scene.sea.waves if isinstance(each, RandomWaves)]
    step = waves.level_step_db(lambda k: np.asarray(sum((system.radial(k) for system in systems), np.zeros(k.size))))
    slope = sea.resolved.mean_square_slope
    return {
        "wavenumber_from": limit,
        "variance": waves.variance,
        "mean_square_slope": waves.mean_square_slope,
        "resolved_slope_share": slope / (slope + waves.mean_square_slope),
        "level_step_db": step,
    }
