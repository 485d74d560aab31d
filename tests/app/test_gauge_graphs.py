"""What gauges read, as the page shows it: the file's own numbers, of whole turns, and the turn that is looked at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from made_folders import TURNS, gauge_series

from seamap_rt.app.gauge_graphs import has_gauges, pairs, read_gauges, record, spectra_of, spectrum
from seamap_rt.app.results import Results
from seamap_rt.gauges import GaugeSpectra, NoSpectrum
from seamap_rt.io.appendable import AppendableNetCDF


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    folder = tmp_path_factory.mktemp("gauged")
    (folder / "maps.nc").touch()
    with AppendableNetCDF(folder / "gauges.nc", ("turn", "sample")) as file:
        for turn in range(TURNS):
            file.append(gauge_series(turn))
    return Results(folder)


def test_what_is_read_is_what_the_file_holds(results: Results) -> None:
    found = read_gauges(results)
    with xr.open_dataset(results.folder / "gauges.nc") as held:
        for name in ("height", "true_height", "seen_time", "east", "time"):
            np.testing.assert_array_equal(found[name].values, held[name].values)
        assert list(found["gauge"].values) == list(held["gauge"].values) == ["west"]


def test_a_record_that_grows_is_read_as_far_as_it_is_whole(tmp_path: Path) -> None:
    (tmp_path / "maps.nc").touch()
    results = Results(tmp_path)
    assert not has_gauges(results)
    with AppendableNetCDF(tmp_path / "gauges.nc", ("turn", "sample")) as file:
        file.append(gauge_series(0))
        file.append(gauge_series(1))
        assert has_gauges(results)
        assert read_gauges(results).sizes["turn"] == 2


def test_the_graphs_show_the_wire_the_map_and_the_turn(results: Results) -> None:
    gauge = read_gauges(results).sel(gauge="west")
    made = record(gauge, 20, dark=False)
    assert made["layout"]["shapes"][0]["x0"] == 20.5
    assert [each["name"] for each in made["data"]] == ["the surface, by the wire", "the map"]
    both = pairs(gauge, dark=False)
    assert both is not None
    x, y = (np.array(both["data"][1][name]) for name in "xy")
    np.testing.assert_allclose(y, 0.9 * x, atol=1e-4)
    told = spectra_of(gauge)
    assert isinstance(told, GaugeSpectra)
    data = {each["name"]: each for each in spectrum(told, dark=False)["data"]}
    radar, wire = (np.array(data[name]["y"]) for name in ("the map", "wire, once a turn"))
    high = wire > 0.1 * wire.max()  # elsewhere is what float32 leaves
    np.testing.assert_allclose(radar[high] / wire[high], 0.81, rtol=1e-3)  # 0.9², to the digits that are sent


def test_a_short_record_has_no_spectrum_and_says_why(results: Results) -> None:
    told = spectra_of(read_gauges(results).sel(gauge="west").isel(turn=slice(0, 9)))
    assert isinstance(told, NoSpectrum)
    assert "too short a record" in told.reason
