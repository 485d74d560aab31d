"""No number that a scene may hold makes a warning or a traceback: each key at its ends and next to nothing, in a scene
that uses it, is refused in one line or gives an outlook and a link budget."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_schema import NEEDED, SECTIONS, keys, kinds, model

from seamap_rt.design_outlook import estimate_outlook
from seamap_rt.design_outlook.model import outlook_rows
from seamap_rt.errors import InputError
from seamap_rt.io.scenefile import apply_overrides
from seamap_rt.products.link import link_budget
from seamap_rt.scene.model import scene_of
from seamap_rt.settings.section import _path

TESTS = Path(__file__).parents[1]
TINIEST = (5e-324, 1e-300, 1e-160)  # the least number, one whose square is nothing, one whose square is the least
UNKNOWN_TO_THE_OUTLOOK = ("GaugeSettings", "ObjectSettings", "PredictionSettings", "QuietSettings", "VesselSettings")
OF_THE_LINK = ("RadarSettings", "AntennaSettings")
HEIGHT = {"significant_wave_height_m": 0.2, "peak_period_s": 5.0}
WIND = {"wind_speed_m_s": 8.0, "fetch_m": 1e5}
USED = {  # what a key needs to count; by the beginning of its path
    "radar.antennas.": {"radar.antennas": [{"offset_m": [0.0, 0.0, up]} for up in (-0.1, 0.1)]},
    "radar.antenna.": {"radar.antenna.feed": "end", "radar.transmit": "single"},
    "radar.receiver.": {"radar.receiver.chain": "digital", "radar.receiver.stc_exponent": 2.0},
    "radar.chirp": {"radar.waveform": "chirp", "radar.pulse_width_s": 1e-7},
    "radar.stare": {"radar.scan": "staring"},
    "radar.transmit_": {"radar.transmitter": "magnetron", "radar.coherent_on_receive": True},
    "platform.": {"platform.motion": "sinusoidal", "platform.sensors.rate_hz": 10.0},
    "platform.length_m": {"platform.motion": "wave_following"},
    "platform.beam_m": {"platform.motion": "wave_following"},
    "scattering.nrcs_db": {"scattering.nrcs": "constant"},
    "retrieval.cell_azimuth_deg": {"radar.scan": "staring"},
    "objects.": {"objects": [{"mesh": str(TESTS.parent / "scenes/objects/buoy.stl"), "position_m": [0.0, 50.0, 0.0]}]},
    "prediction.vessel.": {"prediction.vessel": {"shape": "box", "length_m": 8.0, "beam_m": 3.0, "draught_m": 1.0}},
    "gauges.": {"gauges": [{"name": "wire", "east_m": 0.0, "north_m": 30.0}]},
    "gauges.0.ground": {"gauges": [{"name": "wire", "ground_range_m": 30.0, "azimuth_deg": 90.0}]},
    "gauges.0.azimuth": {"gauges": [{"name": "wire", "ground_range_m": 30.0, "azimuth_deg": 90.0}]},
}


def ends(key: dict[str, Any]) -> Iterator[float | int]:
    """The extreme values that a key takes, by the limits that it states."""
    for kind in (each for each in kinds(key) if each.get("type") in ("number", "integer")):
        whole = kind["type"] == "integer"
        low, high = (-(2**63), 2**63 - 1) if whole else (-1.7976931348623157e308, 1.7976931348623157e308)
        low = kind.get("minimum", low)
        if "exclusiveMinimum" in kind:
            low = kind["exclusiveMinimum"] + 1 if whole else math.nextafter(kind["exclusiveMinimum"], math.inf)
        high = kind.get("maximum", high)
        if "exclusiveMaximum" in kind:
            high = math.nextafter(kind["exclusiveMaximum"], -math.inf)
        nearly = () if whole or low > TINIEST[-1] else TINIEST if low > 0.0 else TINIEST[-1:]
        yield from dict.fromkeys((low, high, *nearly))


def system(where: str, name: str) -> dict[str, Any]:
    """A wave system of that kind that uses a key."""
    made = dict(NEEDED[where])
    if where in ("PiersonMoskowitzWaves", "JonswapWaves", "TmaWaves"):
        by_wind = name in WIND
        size = {key: value for key, value in WIND.items() if key in dict(keys(where)) or key == "wind_speed_m_s"}
        made = {"spectrum": made["spectrum"], **(size if by_wind else HEIGHT)}
    if where == "FileWaves":
        made["file"] = str(TESTS / "io/spectra/ww3.nc")
    if name == "inverse_wave_age" and where != "ElfouhailyWaves":
        made["spreading"] = "donelan_banner"
    return made


def scene_at(where: str, name: str, value: float) -> dict[str, Any]:
    path = f"{_path(model(where))}{name}"
    waves = system(where, name) if where.endswith("Waves") else NEEDED["JonswapWaves"]
    used = max((each for each in USED if path.startswith(each)), key=len, default="")
    tree = {"name": "mine", "sea": {"resolution_m": 2.0, "waves": [dict(waves)]}, "radar": {"range_m": [15.0, 40.0]}}
    if where not in ("TracingSettings", "SinusoidWaves"):  # which decide how fine the mesh is made
        tree["tracing"] = {"facet_m": 0.5, "columns_per_beam": 4}
    return apply_overrides(tree, {**USED.get(used, {}), path: value})


@pytest.mark.parametrize("where", SECTIONS)
@pytest.mark.slow
def test_every_number_at_its_ends_is_refused_in_one_line_or_is_worked_out(where: str) -> None:
    """Warnings are errors here."""
    taken = 0
    for name, key in keys(where):
        for value in ends(key):
            try:
                scene = scene_of(scene_at(where, name, value))
                if where not in UNKNOWN_TO_THE_OUTLOOK:
                    assert list(outlook_rows(estimate_outlook(scene)))
                if where in OF_THE_LINK:
                    link_budget(scene, np.array([scene.radar.height_m + 10.0]))
            except InputError:  # of one line by its class
                continue
            except Exception as error:
                raise AssertionError(f"{name} = {value!r}") from error
            taken += 1
    assert taken or not any(True for _, key in keys(where) for _ in ends(key))


FILES = {
    "objects.0.mesh": {"objects": [{"mesh": "x.stl", "position_m": [0.0, 30.0, 0.0]}]},
    "radar.antenna.file": {"radar.antenna.pattern": "file"},
    "radar.antennas.0.file": {**USED["radar.antennas."], "radar.antennas.0.pattern": "file"},
    "platform.file": {"platform.motion": "file"},
    "sea.file": {"sea.model": "recorded"},
    "sea.waves.0.file": {"sea.waves": [{"spectrum": "file"}]},
}


@pytest.mark.parametrize("key", FILES)
@pytest.mark.parametrize("name", ["a" * 300, "b/" * 3000, "\udc80"], ids=["long name", "long path", "no text"])
def test_a_name_that_no_file_has_is_refused(key: str, name: str) -> None:
    tree = {"name": "mine", "sea": {"waves": [dict(NEEDED["JonswapWaves"])]}}
    with pytest.raises(InputError):
        estimate_outlook(scene_of(apply_overrides(tree, {**FILES[key], key: f"{name}.stl"})))
