"""Whatever is given to a public function in place of its data is refused in the project's words, in one line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import seamap_rt as sr
from seamap_rt.errors import InputError, SchemaError
from seamap_rt.settings import GaugeSettings, RadarSettings
from validation import analytic

RADAR = RadarSettings(prf_hz=1000.0, sector_deg=(0.0, 9.0), range_m=(30.0, 60.0))
GAUGE = GaugeSettings(name="wire", east_m=5.0, north_m=45.0)
FLAT = sr.load_scene("flat")


@pytest.fixture(scope="module")
def maps() -> xr.DataTree:
    echoes = analytic.echoes(analytic.FlatSea(), RADAR, attitude_deg=(0.0, 0.0, 0.0), position_m=(0.0, 0.0, 0.0))
    return sr.retrieve(echoes)


def made_wrong(maps: xr.DataTree) -> dict[str, Any]:
    """What is none of a function's data, by what it is."""
    polar = maps["polar"].to_dataset()
    return {
        "nothing": None,
        "number": 3,
        "path of nothing": "no such store",
        "Path": Path("none"),
        "folder": "/",
        "dataset": xr.Dataset({"a": ("x", [1.0])}),
        "tree of something else": xr.DataTree.from_dict({"/polar": xr.Dataset({"a": ("x", [1.0])})}),
        "tree without a variable": xr.DataTree.from_dict({"/polar": polar.drop_vars("quality")}),
        "array": np.zeros((3, 3)),
        "dict": {"polar": 1},
        "list": [1, 2],
        "function": len,
    }


Call = Callable[[Any, xr.DataTree], object]
CALLS: dict[str, Call] = {
    "retrieve": lambda wrong, _: sr.retrieve(wrong),
    "compare, maps": lambda wrong, maps: sr.compare(wrong, maps),
    "compare, truth": lambda wrong, maps: sr.compare(maps, wrong),
    "sea_state": lambda wrong, _: sr.sea_state(wrong),
    "reconstruct": lambda wrong, _: sr.reconstruct(wrong),
    "forecast": lambda wrong, _: sr.forecast(wrong),
    "quiet_windows": lambda wrong, _: sr.quiet_windows(wrong, {"elevation": 0.5}),
    "quiet_windows, limit": lambda wrong, _: sr.quiet_windows(xr.Dataset(), wrong),
    "highest_wave": lambda wrong, _: sr.highest_wave(wrong),
    "advise": lambda wrong, _: sr.advise(wrong, sr.prediction.Follower()),
    "gauge_series": lambda wrong, _: sr.gauge_series(wrong, None, [GAUGE]),
    "gauge_series, gauges": lambda wrong, maps: sr.gauge_series(maps, None, wrong, turn_s=1.0),
    "load_scene": lambda wrong, _: sr.load_scene(wrong),
    "simulate": lambda wrong, _: sr.simulate(wrong),
    "run": lambda wrong, _: sr.run(wrong),
    "iterate": lambda wrong, _: next(sr.iterate(wrong)),
    "expected": lambda wrong, _: sr.expected(wrong),
    "outlook": lambda wrong, _: sr.outlook(wrong),
    "export": lambda wrong, _: sr.export(wrong, "maps.nc", (50.0, 8.0)),
    "export, path": lambda wrong, maps: sr.export(maps, wrong, (50.0, 8.0)),
    "inspect": lambda wrong, _: sr.inspect(wrong),
    "read_polar_images": lambda wrong, _: sr.read_polar_images(wrong),
    "read_radial_volume": lambda wrong, _: sr.read_radial_volume(wrong),
    "write_radial_volume": lambda wrong, _: sr.write_radial_volume("volume.nc", wrong),
    "write_radial_volume, path": lambda wrong, maps: sr.write_radial_volume(wrong, maps["polar"].to_dataset()),
    "open_recording": lambda wrong, _: sr.open_recording(wrong),
    "echoes_from_recording": lambda wrong, _: sr.echoes_from_recording(
        wrong, wrong, {"frequency_hz": 1e10}, time=[0.0], azimuth=[0.0]
    ),
    "from_scatterers": lambda wrong, _: sr.echoes.from_scatterers(wrong, [[0.0, 100.0, 0.0]], [1.0]),
    "from_scatterers, xyz": lambda wrong, _: sr.echoes.from_scatterers(FLAT, wrong, [1.0]),
    "sea.realize": lambda wrong, _: sr.sea.realize(wrong, seed=1),
    "shadowing": lambda wrong, _: sr.studies.shadowing(wrong),
    "trade": lambda wrong, _: sr.studies.trade(wrong, {"radar.height_m": [5.0]}, workers=0),
    "trade, vary": lambda wrong, _: sr.studies.trade("tiny", wrong, workers=0),
}
OPTIONAL: dict[str, Call] = {  # where None has a meaning
    "retrieve, settings": lambda wrong, _: sr.retrieve(xr.Dataset(), wrong),
    "reconstruct, settings": lambda wrong, maps: sr.reconstruct(maps, wrong),
    "reconstruct, observations": lambda wrong, maps: sr.reconstruct(maps, observations=wrong),
    "inspect, maps": lambda wrong, _: sr.inspect(xr.Dataset(), wrong),
    "load_scene, overrides": lambda wrong, _: sr.load_scene("tiny", wrong),
    "gauge_series, sea": lambda wrong, maps: sr.gauge_series(maps, wrong, [GAUGE], turn_s=1.0),
}


@pytest.mark.parametrize("name", [*CALLS, *OPTIONAL])
def test_wrong_data_is_refused_in_the_projects_words(
    name: str, maps: xr.DataTree, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for kind, wrong in made_wrong(maps).items():
        if name in OPTIONAL and wrong is None:
            continue
        with pytest.raises((InputError, SchemaError)) as caught:  # which names the kind where it is taken
            pytest.fail(f"{name}: {kind} is taken: {(CALLS | OPTIONAL)[name](wrong, maps)!r:.60}")
        lines = caught.value.problems if isinstance(caught.value, InputError) else (str(caught.value),)
        assert all(line.isprintable() and line for line in lines), (name, kind)
        assert str(caught.value).splitlines() == list(lines), (name, kind)
    assert not list(tmp_path.iterdir())


def test_every_public_function_is_among_them() -> None:
    """Names that take no data of the user's are a class, an error, a package, or show progress."""
    functions = {name for name in dir(sr) if callable(getattr(sr, name)) and not isinstance(getattr(sr, name), type)}
    functions.remove("progress")
    assert functions == functions & {name.split(",")[0] for name in CALLS}
