"""What a store of echoes gives back when it is damaged, or was left in the middle of a turn."""

from __future__ import annotations

import json
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr
import zarr

from seamap_rt.errors import InputError, SchemaError
from seamap_rt.interferometry import open_echoes
from seamap_rt.io.echo_store import EchoStore
from seamap_rt.settings import RadarSettings
from validation import analytic

RADAR = RadarSettings(prf_hz=1000.0, sector_deg=(0.0, 9.0), range_m=(30.0, 60.0))


def turn(number: int) -> xr.Dataset:
    echoes = analytic.echoes(analytic.FlatSea(), RADAR, attitude_deg=(0.0, 0.0, 0.0), position_m=(0.0, 0.0, 0.0))
    echoes["turn"] = xr.full_like(echoes["turn"], number)
    return echoes.assign_attrs(complete_turns=number + 1)


@pytest.fixture
def store(tmp_path: Path) -> Path:
    with EchoStore(tmp_path / "echoes.zarr") as made:
        for number in range(2):
            made.append(turn(number))
    return tmp_path / "echoes.zarr"


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


@pytest.mark.parametrize("longer", [["voltage"], ["voltage", "time", "azimuth"], ["turn"]])
def test_a_turn_that_was_not_finished_is_left_out(store: Path, longer: list[str]) -> None:
    """As a killed process leaves it: some arrays have grown, and `complete_turns` has not."""
    before = open_echoes(store).load()
    group = zarr.open_group(store, mode="a", use_consolidated=False)
    for name in longer:
        array = group[name]
        assert isinstance(array, zarr.Array)
        array.resize((array.shape[0] + 7, *array.shape[1:]))
        array[-7:] = 2 if name == "turn" else 1
    after = open_echoes(store)
    assert after.sizes == before.sizes
    xr.testing.assert_identical(after.load(), before)


def test_whole_turns_are_read_while_it_grows(tmp_path: Path) -> None:
    """Also of a store whose writer was killed: it says how many pulses are whole, others look like turn 0."""
    growing = EchoStore(tmp_path / "echoes.zarr")
    for number in range(2):
        growing.append(turn(number))
    group = zarr.open_group(growing.path, mode="a", use_consolidated=False)
    array = group["turn"]
    assert isinstance(array, zarr.Array)
    array.resize((array.shape[0] + 5000,))
    found = open_echoes(growing.path)
    assert found.attrs["complete_turns"] == 2
    assert found.sizes["pulse"] == 2 * turn(0).sizes["pulse"]
    assert set(found["turn"].values) == {0, 1}


def test_anyone_may_open_it_plainly_also_while_it_grows(tmp_path: Path) -> None:
    """`xr.open_zarr(path)`, where a warning is an error: whole turns, none of them in part, from the first to the last
    and after."""
    pulses = turn(0).sizes["pulse"]
    path = tmp_path / "echoes.zarr"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with EchoStore(path) as growing:
            for number in range(2):
                growing.append(turn(number))
                found = xr.open_zarr(path).load()
                assert found.attrs["complete_turns"] == number + 1
                assert found.sizes["pulse"] == (number + 1) * pulses
                _lengthened(path, "voltage")  # the next turn has begun
                xr.testing.assert_identical(xr.open_zarr(path).load(), found)
                _lengthened(path, "voltage", -7)
            growing.rollback()
            found = xr.open_zarr(path)
            assert (found.attrs["complete_turns"], found.sizes["pulse"]) == (1, pulses)
            growing.append(turn(1))
        whole = xr.open_zarr(path).load()
    assert "complete_pulses" not in whole.attrs
    ours = open_echoes(path).load()
    for name in ours.variables:
        xr.testing.assert_equal(whole[name].variable, ours[name].variable)


def _lengthened(path: Path, name: str, by: int = 7) -> None:
    array = zarr.open_group(path, mode="a", use_consolidated=False)[name]
    assert isinstance(array, zarr.Array)
    array.resize((array.shape[0] + by, *array.shape[1:]))


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
    for path in (tmp_path / "file", tmp_path / "none", tmp_path):
        assert "is not an echo store" in refused(path)
    shutil.rmtree(store / "turn")
    assert "'turn' is missing" in refused(store)


@pytest.mark.parametrize("gone", [".", "*", "voltage", "time", "zarr.json", "time/c"])
def test_what_somebody_removes_while_it_grows_is_told_by_its_name(gone: str, tmp_path: Path) -> None:
    """All of it, or what a removal has taken when it meets the writer: an OSError by name, and not one warning."""
    path = tmp_path / "echoes.zarr"
    with pytest.raises(OSError, match=r"echoes\.zarr"), EchoStore(path) as made:  # noqa: PT012
        made.append(turn(0))
        for each in [path] if gone == "." else path.glob(gone):
            shutil.rmtree(each) if each.is_dir() else each.unlink()
        made.append(turn(1))


@pytest.mark.parametrize("gone", ["*", "pulse", "*/zarr.json", "pulse/zarr.json"])
def test_what_somebody_removes_in_the_midst_of_a_turn_is_no_warning(
    gone: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Files go while the turn's own are written: the arrays that are left are shortened, the others are passed over."""
    path = tmp_path / "echoes.zarr"

    def removed(file: Path, *_: object, **__: object) -> int:
        for each in path.glob(gone):
            shutil.rmtree(each, ignore_errors=True) if each.is_dir() else each.unlink(missing_ok=True)
        raise FileNotFoundError(2, "No such file or directory", str(file))

    with pytest.raises(OSError, match=r"echoes\.zarr|No such file"), EchoStore(path) as made:  # noqa: PT012
        made.append(turn(0))
        monkeypatch.setattr("zarr.storage._local._put", removed)
        made.append(turn(1))
