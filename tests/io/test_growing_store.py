"""What a store that grows gives back while it does, when it is damaged, or was left in the middle of a turn."""

from __future__ import annotations

import json
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import zarr

from seamap_rt.errors import InputError, SchemaError
from seamap_rt.interferometry import open_echoes
from seamap_rt.io.growing_store import GrowingStore
from seamap_rt.settings import RadarSettings
from validation import analytic

RADAR = RadarSettings(prf_hz=1000.0, sector_deg=(0.0, 9.0), range_m=(30.0, 60.0))


def turn(number: int) -> xr.Dataset:
    echoes = analytic.echoes(analytic.FlatSea(), RADAR, attitude_deg=(0.0, 0.0, 0.0), position_m=(0.0, 0.0, 0.0))
    echoes["turn"] = xr.full_like(echoes["turn"], number)
    return echoes.assign_attrs(complete_turns=number + 1)


def grown(path: Path, turns: int = 2) -> GrowingStore:
    store = GrowingStore(path, ("turn", "pulse"))
    for number in range(turns):
        store.append({"echoes": turn(number)})
    return store


@pytest.fixture
def store(tmp_path: Path) -> Path:
    """The echoes of a run's store, alone: a store as well, as earlier versions write it."""
    grown(tmp_path / "run.zarr").close()
    (tmp_path / "run.zarr" / "echoes").rename(tmp_path / "echoes.zarr")
    shutil.rmtree(tmp_path / "run.zarr")
    return tmp_path / "echoes.zarr"


def no_room(*_: object) -> None:
    raise OSError(28, "No space left on device")


def refused(path: Path) -> str:
    with pytest.raises((InputError, SchemaError)) as caught:
        open_echoes(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_every_chunk_is_asked_for(store: Path) -> None:
    """Of any array, those of zeros alone too: Zarr itself would read what is lost as zeros."""
    whole = open_echoes(store)
    assert whole.attrs["complete_turns"] == 2
    chunks = [path for path in sorted(store.rglob("*")) if path.is_file() and path.name != "zarr.json"]
    assert {path.relative_to(store).parts[0] for path in chunks} >= {"voltage", "time", "attitude", "range"}
    for chunk in chunks:
        held = chunk.read_bytes()
        chunk.unlink()
        assert f"'{chunk}': is missing, and would be read as zeros" in refused(store)
        chunk.write_bytes(held[:-1])
        assert f"'{chunk}': holds {len(held) - 1} bytes: must be {len(held)}" in refused(store)
        chunk.write_bytes(held)
    xr.testing.assert_identical(open_echoes(store).load(), whole.load())


def test_what_an_earlier_version_left_unfinished_is_one_line(store: Path) -> None:
    """Arrays of unlike length; or of like length, whose last pulses would look like those of turn 0."""
    group = zarr.open_group(store, mode="r+")
    array = group["voltage"]
    assert isinstance(array, zarr.Array)
    array.resize((array.shape[0] + 7, *array.shape[1:]))
    assert "is not an echo store, or damaged" in refused(store)
    array.resize((array.shape[0] - 7, *array.shape[1:]))
    group.attrs["complete_pulses"] = 1
    assert "an earlier version left it unfinished" in refused(store)


def test_anyone_may_open_it_plainly_also_while_it_grows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`xr.open_zarr(path, group="echoes")`, where a warning is an error: whole turns, none of them in part, from the
    first to the last and after; and so by its own path when it is finished."""
    pulses, path = turn(0).sizes["pulse"], tmp_path / "run.zarr"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with GrowingStore(path, ("turn", "pulse")) as growing:
            for number in range(2):
                growing.append({"echoes": turn(number)})
                found = xr.open_zarr(path, group="echoes").load()
                assert found.attrs["complete_turns"] == number + 1
                assert found.sizes["pulse"] == (number + 1) * pulses
                with monkeypatch.context() as patch:
                    patch.setattr(zarr.Group, "update_attributes", no_room)
                    with pytest.raises(OSError, match=r"run\.zarr"):
                        growing.append({"echoes": turn(number + 1)})  # the next turn, but for its mark
                xr.testing.assert_identical(xr.open_zarr(path, group="echoes").load(), found)
                assert open_echoes(path).sizes["pulse"] == (number + 1) * pulses
        whole = xr.open_zarr(path, group="echoes").load()
        xr.testing.assert_identical(xr.open_zarr(path / "echoes").load(), whole)
    ours = open_echoes(path).load()
    for name in ours.variables:
        xr.testing.assert_equal(whole[name].variable, ours[name].variable)


@pytest.mark.parametrize("growing", [True, False])
def test_echoes_are_opened_without_a_look_at_what_lies_beside_them(tmp_path: Path, growing: bool) -> None:
    """By the run's folder, its store, or the group: nothing else of the store need even be there."""
    store = GrowingStore(tmp_path / "run.zarr", ("turn", "pulse"))
    truth = xr.Dataset({"height": (("turn", "x"), [[1.0, 2.0]])}, {"turn": [0]})
    store.append({"echoes": turn(0), "truth": xr.DataTree.from_dict({"/polar": truth})})
    if not growing:
        store.close()
    before = open_echoes(store.path).load()
    for file in (store.path / "truth").rglob("*"):
        if file.is_file():
            file.write_bytes(b"nonsense")
    for gone in (False, True):
        if gone:
            shutil.rmtree(store.path / "truth")
        for path in (tmp_path, store.path):
            xr.testing.assert_identical(open_echoes(path).load(), before)


@pytest.mark.parametrize("late", [1, 3])
def test_a_group_may_begin_late_and_have_nothing_of_a_turn(tmp_path: Path, late: int) -> None:
    """As forecasts, of turns that show no sea: it is as long as its own, and its file has these alone."""
    issued = [number for number in range(5) if number >= late and number != 3]
    files = {"maps": tmp_path / "maps.nc", "forecast": tmp_path / "prediction.nc"}
    with GrowingStore(tmp_path / "run.zarr", ("turn", "issue"), files) as store:
        for number in range(5):
            maps = xr.Dataset({"height": (("turn", "x"), [[1.0 * number]])}, {"turn": [number]})
            made = xr.Dataset({"elevation": ("issue", [2.0 * number])}, {"issue": [number]})
            store.append({"maps": maps, "forecast": made if number in issued else None})
    with xr.open_dataset(files["maps"]) as maps, xr.open_dataset(files["forecast"]) as made:
        assert maps["turn"].values.tolist() == list(range(5))
        assert made["issue"].values.tolist() == issued
        assert made["elevation"].values.tolist() == [2.0 * number for number in issued]


def test_room_for_turns_to_come_is_given_back(tmp_path: Path) -> None:
    """Arrays that got more room several times are as long as their turns when the store is finished, and have these."""
    with GrowingStore(tmp_path / "run.zarr") as store:
        for number in range(40):
            store.append({"maps": xr.Dataset({"height": (("turn", "x"), np.full((1, 3000), 1.0 * number))})})
    group = zarr.open_group(store.path, mode="r", use_consolidated=False)
    height = group["maps/height"]
    assert isinstance(height, zarr.Array)
    assert height.shape == (40, 3000)
    np.testing.assert_array_equal(np.asarray(height[:])[:, -1], np.arange(40.0))
    assert len(list((store.path / "maps" / "height" / "c").iterdir())) == 40


def _of_another_type(described: dict) -> None:
    described["shape"] = "many"


def _without_names(described: dict) -> None:
    described["dimension_names"] = 3


def _of_no_format(described: dict) -> None:
    described["zarr_format"] = "three"


@pytest.mark.parametrize(
    ("name", "change"),
    [
        *((name, change) for name in ("voltage", "turn") for change in (_of_another_type, _without_names)),
        *((name, _of_no_format) for name in ("voltage", "turn", ".")),
    ],
)
def test_damaged_descriptions_are_one_line(store: Path, name: str, change: Callable[[dict], None]) -> None:
    file = store / name / "zarr.json"
    described = json.loads(file.read_text())
    change(described)
    file.write_text(json.dumps(described))
    assert str(store) in refused(store)


def test_other_things_are_one_line(tmp_path: Path, store: Path) -> None:
    (tmp_path / "file").write_text("no store")
    (tmp_path / "empty").mkdir()
    for path in (tmp_path / "file", tmp_path / "none", tmp_path / "empty"):
        assert "is not an echo store" in refused(path)
    shutil.rmtree(store / "turn")
    assert "'turn' is missing" in refused(store)
    grown(tmp_path / "run.zarr")
    (tmp_path / "run.zarr" / "zarr.json").unlink()
    assert "is not an echo store" in refused(tmp_path / "run.zarr")


@pytest.mark.parametrize("gone", [".", "*", "echoes/voltage", "echoes/time", "zarr.json", "echoes/time/c"])
def test_what_somebody_removes_while_it_grows_is_told_by_its_name(gone: str, tmp_path: Path) -> None:
    """All of it, or what a removal has taken when it meets the writer: an OSError by name, and not one warning."""
    store = grown(tmp_path / "run.zarr", 1)
    for each in [store.path] if gone == "." else store.path.glob(gone):
        shutil.rmtree(each) if each.is_dir() else each.unlink()
    with pytest.raises(OSError, match=r"run\.zarr"):
        store.append({"echoes": turn(1)})


@pytest.mark.parametrize("gone", ["*", "echoes/pulse", "echoes/*/zarr.json", "echoes/pulse/zarr.json"])
def test_what_somebody_removes_in_the_midst_of_a_turn_is_no_warning(
    gone: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Files go while the turn's own are written."""
    store = grown(tmp_path / "run.zarr", 1)

    def removed(file: Path, *_: object, **__: object) -> int:
        for each in store.path.glob(gone):
            shutil.rmtree(each, ignore_errors=True) if each.is_dir() else each.unlink(missing_ok=True)
        raise FileNotFoundError(2, "No such file or directory", str(file))

    monkeypatch.setattr("zarr.storage._local._put", removed)
    with pytest.raises(OSError, match=r"run\.zarr|No such file"):
        store.append({"echoes": turn(1)})


def test_a_group_named_from_within_its_store_holds_no_turn_that_is_not_marked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While a store grows its arrays have room for turns to come, which the root's mark leaves out."""
    grown(tmp_path / "run.zarr")
    whole = open_echoes(tmp_path / "run.zarr")
    monkeypatch.chdir(tmp_path / "run.zarr")
    assert open_echoes("echoes").sizes == whole.sizes


def test_a_run_without_echoes_is_named_as_such(tmp_path: Path) -> None:
    grown(tmp_path / "run.zarr")
    shutil.rmtree(tmp_path / "run.zarr" / "echoes")
    with pytest.raises(InputError, match=r"run\.zarr': has no group echoes; wait for the run's first turn"):
        open_echoes(tmp_path)
