"""gauges.nc, and gauges in a whole run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from made_gauges import a_sea, gauge, made_maps, plane, with_gauges
from numpy.testing import assert_array_equal

from seamap_rt.dataset import check
from seamap_rt.gauges import gauge_series
from seamap_rt.io.appendable import AppendableNetCDF
from seamap_rt.report import style
from seamap_rt.scene import load_scene
from seamap_rt.session import RunResult, run
from seamap_rt.simulation import Simulator

# --------------------------------------------------------------------------------------------------------- the file


def test_turn_by_turn_is_all_at_once(tmp_path: Path) -> None:
    sea = a_sea(spectrum="sinusoid", height_m=1.0, wavelength_m=40.0)
    maps, wires = made_maps(plane, turns=5, period=1.3), [gauge("a b"), gauge("c")]
    whole = gauge_series(maps, sea, wires, maps, turn_s=1.3)
    with AppendableNetCDF(tmp_path / "gauges.nc", ("turn", "sample")) as file:
        for turn in range(5):
            one = xr.DataTree.from_dict(
                {f"/{group}": maps[group].to_dataset().isel(turn=[turn]) for group in ("polar", "ground")}
            )
            file.append(gauge_series(one, sea, wires, one, turn_s=1.3))
            assert not (tmp_path / "gauges.nc").exists()
    with xr.open_dataset(tmp_path / "gauges.nc") as read:
        check("gauges", read)
        assert set(read.variables) == set(whole.variables)
        assert dict(read.sizes) == dict(whole.sizes)
        for name, variable in whole.variables.items():
            assert_array_equal(read[name].values, variable.values, err_msg=str(name))
            assert read[name].attrs.keys() == variable.attrs.keys()
    assert [path.name for path in tmp_path.iterdir()] == ["gauges.nc"]


def test_a_file_without_turns_does_not_appear(tmp_path: Path) -> None:
    with AppendableNetCDF(tmp_path / "gauges.nc", ("turn", "sample")):
        pass
    assert not list(tmp_path.iterdir())


# ---------------------------------------------------------------------------------------------------------- the run


def run_of(turns: int, folder: Path) -> RunResult:
    """Turns with two gauges."""
    tables = (
        'name = "wire"\neast_m = -50.0\nnorth_m = 1.0',
        'name = "near"\nground_range_m = 30.0\nazimuth_deg = 268.0',
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "DPI", 40)  # nothing here looks at pixels
        return run(load_scene(with_gauges(folder, turns, *tables)), folder / "out")


@pytest.fixture(scope="module")
def short_run(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    return run_of(9, tmp_path_factory.mktemp("short"))


@pytest.mark.slow
def test_the_radar_follows_the_wires_of_a_long_run(tmp_path: Path) -> None:
    long_run = run_of(36, tmp_path)
    metrics = json.loads((long_run.folder / "metrics.json").read_text(encoding="utf-8"))
    assert [entry["name"] for entry in metrics["gauges"]] == ["wire", "near"]
    for entry in metrics["gauges"]:
        # Cells of 3 m lose 4–5 cm of this sea, the retrieval errs by 6–8 cm, and the sea has 35 cm rms: r = 0.96
        # expected of it, and 36 turns of seven waves tell r to ±0.02.
        assert entry["correlation"] > 0.9
        assert entry["rms_error_m"] < 0.15
        assert entry["answered"] > 0.9
        assert entry["averaging_rms_m"] < entry["rms_error_m"]
        assert entry["spectrum"]["frequency_hz"][-1] < entry["nyquist_hz"] == pytest.approx(0.5)
        assert "half the turn rate" in entry["aliasing"]


def test_gauges_nc_holds_what_maps_and_truth_hold(short_run: RunResult) -> None:
    with (
        xr.open_dataset(short_run.folder / "gauges.nc") as gauges,
        xr.open_datatree(short_run.folder / "maps.nc") as maps,
        xr.open_datatree(short_run.folder / "truth.nc") as truth,
    ):
        check("gauges", gauges)
        assert gauges.sizes == {"gauge": 2, "turn": 9, "sample": 36}
        first = [
            xr.DataTree.from_dict({f"/{group}": tree[group].to_dataset().isel(turn=slice(0, 8)) for group in tree})
            for tree in (maps, truth)
        ]
        again = gauge_series(first[0], None, load_scene(short_run.folder / "scene.toml").gauges, first[1])
        for name in ("height", "height_std", "seen_time", "quality", "seen_cell_height"):
            assert_array_equal(again[name].values, gauges[name].values[:, :8])
        # The wire passes through the surface at the radar's times: a wave of 1 s between samples of ¼ s is missed by
        # (ωΔt)²/8 of its amplitude, a third; this sea has 2 cm rms of waves so short.
        for number in range(2):
            between = np.interp(gauges["seen_time"][number], gauges["time"], gauges["true_height"][number])
            assert np.sqrt(np.mean((between - gauges["seen_true_height"].values[number]) ** 2)) < 0.03


def test_the_report_shows_the_gauges(short_run: RunResult) -> None:
    page = (short_run.folder / "report.html").read_text(encoding="utf-8")
    for name in ("gauge_0", "gauge_1", "evolution"):
        assert f'<figure id="{name}">' in page
    assert "Wave gauge: near" in page
    assert "<h3>Wave gauges</h3>" in page
    assert (short_run.folder / "gauge_1.png").exists()


def test_an_interrupted_run_leaves_whole_turns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    simulate = Simulator.turn

    def stop(self: Simulator, number: int, *told: Any) -> Any:
        if number == 2:
            raise KeyboardInterrupt
        return simulate(self, number, *told)

    monkeypatch.setattr(Simulator, "turn", stop)
    file = with_gauges(tmp_path, 9, 'name = "wire"\neast_m = -50.0\nnorth_m = 1.0')
    with pytest.raises(KeyboardInterrupt, match="2 of 9 turns are complete"):
        run(load_scene(file), tmp_path / "cut")
    with xr.open_dataset(tmp_path / "cut" / "gauges.nc") as gauges:
        assert gauges.sizes == {"gauge": 1, "turn": 2, "sample": 8}
        assert np.isfinite(gauges["height"].values).all()
    assert not list((tmp_path / "cut").glob(".*"))
