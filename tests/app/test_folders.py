"""Folders of any kind are known by what is in them, and seen as far as they go; a trade's point is run as it was."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from made_folders import maps_tree

from seamap_rt import metrics
from seamap_rt.app.folders import Roots, find_runs, kind_of, products_of
from seamap_rt.app.panels import Section, errors_by_range
from seamap_rt.app.sea_view import sea_surface
from seamap_rt.app.source import MAP_VIEWS, Results, Source
from seamap_rt.app.trade_view import Point, folder_of_point, scene_of_point, words_of_point
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.errors import InputError
from seamap_rt.io.results_folder import OF_RUN, RUN
from seamap_rt.scene import load_scene
from seamap_rt.studies.sweep import Sweep

_KINDS = {
    "run": ("maps.nc", "truth.nc", "prediction.nc", "scene.toml"),
    "retrieval": ("maps.nc", "retrieval.html"),
    "simulation": ("truth.nc",),
    "shadowing": ("shadowing.nc", "scene.toml"),
    "trade": ("trade.json",),
    "sea": ("sea.nc", "from_mast.png"),
    "forecast": ("prediction.nc",),
}


@pytest.mark.parametrize("kind", _KINDS)
def test_a_folder_is_known_by_what_is_in_it(tmp_path: Path, kind: str) -> None:
    folder = tmp_path / "runs" / "one"
    folder.mkdir(parents=True)
    for name in _KINDS[kind]:
        (folder / name).touch()
    assert kind_of(folder) == kind
    assert [(each.name, each.kind) for each in find_runs(tmp_path / "runs")] == [("one", kind)]


def test_a_run_is_one_from_its_first_turn_on(tmp_path: Path) -> None:
    assert kind_of(tmp_path) is None
    for name in ("truth.nc", "maps.nc"):
        (tmp_path / RUN / OF_RUN[name]).mkdir(parents=True)
    assert kind_of(tmp_path) == "run"


# --------------------------------------------------------------------------------------- maps without truth, and back


def _source(folder: Path, *products: str) -> Source:
    for name in products:
        maps_tree(name == "maps").to_netcdf(folder / f"{name}.nc", engine="h5netcdf")
    return Source(Results(folder))


def test_a_retrieval_shows_what_it_has_and_no_error(tmp_path: Path) -> None:
    source = _source(tmp_path, "maps")
    titles = {view: [panel.title for panel in source.view(view, 0).panels] for view in MAP_VIEWS}
    assert titles["heights"] == ["Retrieved height", "Stated error"]
    assert titles["slopes"] == ["Retrieved slope to east", "Retrieved slope to north"]
    assert titles["polar"] == ["Retrieved height", "Stated error"]
    assert titles["echo"] == ["Echo power", "Interferometric phase", "Coherence"]
    assert source.height_m == pytest.approx(6.0)  # by its own ranges: no scene says it
    assert np.isnan(Section.of(source, 270.0, 0).true).all()
    told = errors_by_range(source, 0)
    assert np.isnan(told.rms).all()
    assert np.nanmedian(told.stated) == pytest.approx(0.1)


def test_a_simulation_shows_the_true_sea_alone(tmp_path: Path) -> None:
    source = _source(tmp_path, "truth")
    assert source.results.turns() == [0]
    assert not source.results.growing
    titles = {view: [panel.title for panel in source.view(view, 0).panels] for view in ("heights", "slopes", "polar")}
    assert titles["heights"] == ["True height"]
    assert titles["slopes"] == ["True slope to east", "True slope to north"]
    assert titles["polar"] == ["True height", "In sight of both antennas"]
    section = Section.of(source, 270.0, 0)
    assert np.isnan(section.retrieved).all()
    np.testing.assert_allclose(section.true, -0.01 * np.sqrt(source.layout.range**2 - 36.0), rtol=1e-3)
    told = errors_by_range(source, 0)
    assert np.isnan(told.rms).all()
    assert (told.visible[1], told.visible[7]) == (1.0, 0.0)
    x, _, height, lit, _ = sea_surface(source, 0, retrieved=True)
    assert np.isfinite(height).any()
    assert lit.any()
    assert x.max() <= 3.0  # the west alone is looked at


def test_a_run_has_both_and_their_difference(tmp_path: Path) -> None:
    source = _source(tmp_path, "maps", "truth")
    assert [panel.title for panel in source.view("heights", 0).panels][:3] == [
        "True height",
        "Retrieved height",
        "Error",
    ]
    assert np.nanmax(errors_by_range(source, 0).rms) == pytest.approx(0.1, rel=1e-4)


def test_cells_flagged_as_ambiguous_count_in_no_error(tmp_path: Path) -> None:
    """As in metrics.json: a height that is a phase cycle off, and says so, is no error of the page's graphs either."""
    maps = maps_tree(True)
    polar = maps["polar"].to_dataset()
    polar["height"][:, ::2] += 10.0
    polar["quality"][:, ::2] = QUALITY_FLAGS["ambiguous"]
    maps["polar"] = xr.DataTree(polar)
    maps.to_netcdf(tmp_path / "maps.nc", engine="h5netcdf")
    source = _source(tmp_path, "truth")
    assert np.nanmax(errors_by_range(source, 0).rms) == pytest.approx(0.1, rel=1e-4)
    assert metrics.counted_cells(polar, maps_tree(False)["polar"].to_dataset()).sum() == 30 * np.sum(
        polar["ground_range"][0, 0] < 60.0
    )


def test_estimators_know_where_a_moving_boat_was(tmp_path: Path) -> None:
    """Waves are fitted at the places of the cells, which go with the antenna, on the page as in files."""
    maps = maps_tree(True)
    polar = maps["polar"].to_dataset()
    for name, metres in (("antenna_x", 3.0), ("antenna_y", -7.0)):
        polar[name] = xr.full_like(polar["time"], metres)
    maps["polar"] = xr.DataTree(polar)
    maps.to_netcdf(tmp_path / "maps.nc", engine="h5netcdf")
    seen = Source(Results(tmp_path)).polar(0)
    assert (seen["antenna_x"] == 3.0).all()
    assert (seen["antenna_y"] == -7.0).all()
    np.testing.assert_allclose(seen["height"], polar["height"].isel(turn=0), rtol=1e-6)
    assert (seen["antenna_x"].dims, seen["quality"].dtype.kind) == (("azimuth",), "i")


def test_pictures_of_the_sea_may_be_taken_away(tmp_path: Path) -> None:
    for name in ("from_mast.png", "statistics.txt", "other.png"):
        (tmp_path / name).touch()
    assert set(products_of(tmp_path)) == {"from_mast.png", "statistics.txt"}


# --------------------------------------------------------------------------------------------------- a trade's point


def test_a_point_is_run_with_the_scene_and_the_seed_that_the_trade_gave_it(tmp_path: Path) -> None:
    scene = load_scene("tiny")
    vary = {"radar.height_m": [4.0, 8], "radar.antenna.azimuth_beamwidth_deg": [1.8, 2.5]}
    sweep = Sweep.of(scene, vary, 2, tmp_path)
    (tmp_path / "trade.json").write_text(json.dumps(sweep.manifest))
    roots = Roots(tmp_path)
    names = set()
    for each, wanted in zip(sweep.points, sweep.scenes, strict=True):
        point = Point(each.keys, each.seed, "done", "", {})
        assert scene_of_point(tmp_path, point, roots) == wanted
        names.add(folder_of_point("trade", point))
    assert len(names) == 8
    last = Point({"radar.height_m": 8}, 2, "done", "", {})
    assert words_of_point(last) == "antenna height 8 m, seed 2"


@pytest.mark.parametrize("content", ["", "{", "[]", '{"scene": 3}', '{"scene": "a = ["}'])
def test_a_damaged_trade_is_refused_in_a_line(tmp_path: Path, content: str) -> None:
    (tmp_path / "trade.json").write_text(content)
    with pytest.raises(InputError, match=r"trade\.json cannot be read"):
        scene_of_point(tmp_path, Point({"radar.height_m": 8}, 2, "done", "", {}), Roots(tmp_path))


def test_a_points_folder_stays_beside_its_trade(tmp_path: Path) -> None:
    point = Point({"sea.waves.0.file": "../../etc/x y"}, 1, "done", "", {})
    assert "/" not in folder_of_point("trade", point)
    assert (tmp_path / folder_of_point("trade", point)).resolve().parent == tmp_path
