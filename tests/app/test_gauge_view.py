"""What gauges read, as the page shows it: the file's own numbers, of whole turns, and the turn that is looked at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from made_folders import TURNS, gauge_series, write_run

from seamap_rt.app.source import Results, Source
from seamap_rt.app.waves_view import has_gauges, read_gauges, view_gauge
from seamap_rt.gauges import NoSpectrum, spectra
from seamap_rt.io.appendable import AppendableNetCDF
from seamap_rt.report.gauge_figures import gauge_figure


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


def test_the_figure_shows_the_wire_the_map_and_the_turn(results: Results) -> None:
    gauge = read_gauges(results).sel(gauge="west")
    record, spectrum, pairs = gauge_figure(gauge, 20).axes
    assert 20.5 in [np.unique(np.asarray(line.get_xdata())).tolist()[0] for line in record.lines]
    lines = {str(line.get_label()): line for line in spectrum.lines}
    radar, wire = (np.asarray(lines[name].get_ydata()) for name in ("radar", "wire, once a turn"))
    high = wire > 0.1 * wire.max()  # elsewhere is what float32 leaves
    np.testing.assert_allclose(radar[high] / wire[high], 0.81, rtol=1e-3)  # 0.9²
    dots = next(line for line in pairs.lines if line.get_marker() == "o")
    np.testing.assert_allclose(np.asarray(dots.get_ydata()), 0.9 * np.asarray(dots.get_xdata()), atol=1e-4)


def test_of_many_turns_those_up_to_the_one_that_is_looked_at_are_drawn() -> None:
    gauge = gauge_series(0, 200).sel(gauge="west")
    for turn, first, last in ((None, 0.0, 90.5), (20, 0.0, 90.5), (150, 60.5, 151.5)):
        low, high = gauge_figure(gauge, turn).axes[0].get_xlim()
        assert (low, high) == pytest.approx((first, last), abs=1.01)


def test_the_page_is_told_of_a_gauge_with_its_image(tmp_path: Path) -> None:
    write_run(tmp_path / "run")
    told = view_gauge(Source(Results(tmp_path / "run")), 11, "of another run", dark=True)
    assert (told.choices, told.chosen, told.words) == ({"west": "west"}, "west", "At 60 m, 270°.")
    assert dict(told.figures)["Turns with a height"].endswith(" %")
    (image,) = told.images
    assert image.source.startswith("data:image/png;base64,")
    assert "west" in image.alt


def test_a_short_record_has_no_spectrum_and_says_why(results: Results) -> None:
    told = spectra(read_gauges(results).sel(gauge="west").isel(turn=slice(0, 9)))
    assert isinstance(told, NoSpectrum)
    assert "too short a record" in told.reason
