"""`retrieve` of recordings: what is surely wrong is refused, what is doubtful said first, what grows is followed."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

import command_line
import numpy as np
import pytest
import xarray as xr

import seamap_rt as sr
from seamap_rt.errors import InputError
from seamap_rt.io.growing_store import GrowingStore
from seamap_rt.session.retrieving import follow_turns
from seamap_rt.settings import RetrievalSettings

call, elsewhere = command_line.call, command_line.elsewhere  # fixtures
pytestmark = pytest.mark.usefixtures("elsewhere")
SLIM = RetrievalSettings(estimator="single_cell")
HEADER = """
frequency_hz = 10e9
pulse_width_s = 20e-9
bandwidth_hz = 50e6
height_m = {mast}
baseline_m = 0.2
azimuth_beamwidth_deg = 1.8
elevation_beamwidth_deg = 18.0
transmit = "switched"
first_gate_m = 15.0
gate_m = 1.5
sector_deg = [240.0, 300.0]
"""


@pytest.fixture(scope="module")
def echoes() -> xr.Dataset:
    scene = sr.load_scene("tiny", overrides={"turns": 3, "tracing.tracer": "horizon"})
    return sr.simulate(scene).echoes


def record(echoes: xr.Dataset, turns: int = 1, mast: float = 5.0) -> None:
    few = echoes.isel(pulse=echoes["turn"].values < turns)
    lower, upper = (few["voltage"].values[:, each] for each in (0, 1))
    arrays = {name: few[name].values for name in ("time", "azimuth", "transmitter")}
    np.savez("night.npz", allow_pickle=False, lower=lower, upper=upper, **arrays)
    Path("night.toml").write_text(HEADER.format(mast=mast))


def test_exchanged_receivers_are_refused_and_nothing_is_written(echoes: xr.Dataset, call: Any) -> None:
    record(echoes)
    right = call("retrieve", "night.npz", "--out", "right")
    assert right.code == 0
    assert not right.out.startswith(("doubtful", "surely"))
    exchanged = ("retrieve", "night.npz", "--name", "lower=upper", "--name", "upper=lower", "--out", "maps")
    refused = call(*exchanged)
    assert refused.code == 2
    assert "sign of the phase" in refused.err
    assert "exchange lower and upper" in refused.err
    assert len(refused.err.strip().splitlines()) == 1
    assert not Path("maps/maps.nc").exists()
    forced = call(*exchanged, "--even-if-wrong")
    assert forced.code == 0
    assert forced.out.startswith("surely wrong: sign of the phase")
    assert Path("maps/maps.nc").exists()


def test_what_is_doubtful_is_said_in_the_first_line_and_on_the_page(echoes: xr.Dataset, call: Any) -> None:
    record(echoes, mast=6.5)
    answer = call("retrieve", "night.npz", "--out", "maps")
    assert answer.code == 0
    first = answer.out.splitlines()[0]
    assert first.startswith("doubtful: mast height")
    assert "doubtful" in Path("maps/retrieval.html").read_text(encoding="utf-8")


def test_options_that_make_no_sense_are_refused(echoes: xr.Dataset, call: Any) -> None:
    record(echoes)
    for option, value in (("--follow", "-1"), ("--wind-from", "nan")):
        answer = call("retrieve", "night.npz", option, value, "--out", "maps")
        assert answer.code == 2
        assert answer.err.startswith(f"seamap-rt: {option} = ")


def test_turns_that_come_later_are_retrieved_once_each(echoes: xr.Dataset) -> None:
    """A clock of its own: nothing waits. The file cannot be read at the second look."""
    looks = iter([1, None, 1, 2, 3])
    now = [0.0]

    def opened() -> xr.Dataset:
        turns = next(looks, 3)
        if turns is None:
            raise InputError("half a file")
        few = echoes.isel(pulse=echoes["turn"].values < turns)
        few.attrs = {**few.attrs, "complete_turns": turns}
        return few

    def sleep(seconds: float) -> None:
        now[0] += seconds

    came = [
        int(turn.maps["polar"].to_dataset()["turn"].values[0])
        for turn in follow_turns(opened, SLIM, 3.0, clock=lambda: now[0], sleep=sleep)
    ]
    assert came == [0, 1, 2]
    assert now[0] < 10.0  # and it ends


def test_a_file_that_stays_unreadable_is_an_error_in_the_end() -> None:
    now = [0.0]

    def opened() -> xr.Dataset:
        raise InputError("no file")

    with pytest.raises(InputError, match="no file"):
        list(follow_turns(opened, SLIM, 2.0, clock=lambda: now[0], sleep=lambda s: now.__setitem__(0, now[0] + s)))


def test_a_store_is_followed_while_it_grows(echoes: xr.Dataset, call: Any) -> None:
    turns = [echoes.isel(pulse=echoes["turn"].values == number) for number in range(3)]
    for number, turn in enumerate(turns):
        turn.attrs = {**turn.attrs, "complete_turns": number + 1}

    def grow() -> None:
        with GrowingStore(Path("run.zarr"), ("turn", "pulse")) as store:
            for turn in turns:
                store.append({"echoes": turn})
                time.sleep(0.3)

    writer = threading.Thread(target=grow)
    writer.start()
    time.sleep(0.2)
    answer = call("retrieve", "run.zarr", "--follow", "2", "--out", "maps", "--set", "retrieval.estimator=single_cell")
    writer.join()
    assert answer.code == 0, answer.err
    assert [line.split(":")[0] for line in answer.out.splitlines() if line.startswith("turn ")] == [
        "turn 1",
        "turn 2",
        "turn 3",
    ]
    with xr.open_datatree("maps/maps.nc") as maps:
        assert maps["polar"].sizes["turn"] == 3


def test_maps_are_exported_with_their_place(echoes: xr.Dataset, call: Any) -> None:
    record(echoes)
    answer = call(
        "retrieve", "night.npz", "--out", "maps", "--to", "geotiff,csv,cfradial", "--to", "netcdf", "--at", "-33.9,18.4"
    )
    assert answer.code == 0, answer.err
    for name in ("ground.tif", "ground.csv", "ground.nc", "polar_cfradial.nc"):
        assert Path("maps", name).exists()
        assert str(Path("maps", name)) in answer.out
    with xr.open_dataset("maps/ground.nc") as read, xr.open_datatree("maps/maps.nc") as maps:
        np.testing.assert_array_equal(read["height"].values, maps["ground"]["height"].values)
        assert float(read["lat"].mean()) == pytest.approx(-33.9, abs=1e-4)
        np.testing.assert_allclose(read["heading"].values, 0.0)
        polar = sr.read_radial_volume("maps/polar_cfradial.nc")
        np.testing.assert_array_equal(polar["height"].values, maps["polar"]["height"].values)
    with xr.open_dataset("maps/polar_cfradial.nc") as volume:
        assert (float(volume["latitude"]), float(volume["longitude"])) == (-33.9, 18.4)
    again = call("retrieve", "night.npz", "--out", "maps", "--overwrite")
    assert again.code == 0
    assert not any(Path("maps", name).exists() for name in ("ground.nc", "polar_cfradial.nc"))  # of an earlier one


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--to", "netcdf"), "--to: needs --at LAT,LON"),
        (("--at", "54,7"), "--at: needs --to"),
        (("--to", "shapefile", "--at", "54,7"), "--to shapefile: must be"),
        (("--to", "csv", "--at", "99,7"), "--at: latitude = 99"),
    ],
)
def test_exports_that_make_no_sense_are_refused(echoes: xr.Dataset, call: Any, options: Any, words: str) -> None:
    record(echoes)
    answer = call("retrieve", "night.npz", "--out", "maps", *options)
    assert answer.code == 2
    assert words in answer.err
    assert len(answer.err.strip().splitlines()) == 1
    assert not Path("maps/maps.nc").exists()
