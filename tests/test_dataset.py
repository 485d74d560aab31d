"""The schema is kept by what is built, and by what is written and read back."""

from __future__ import annotations

import shutil
import signal
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import zarr
from numpy.testing import assert_array_equal

from seamap_rt.dataset import ECHO_ATTRIBUTES, QUALITY_FLAGS, SCHEMA, build, check
from seamap_rt.echoes.dataset import echo_dataset
from seamap_rt.errors import SchemaError
from seamap_rt.interferometry import open_echoes
from seamap_rt.io.appendable import AppendableNetCDF
from seamap_rt.io.growing_store import GrowingStore
from seamap_rt.io.process import hold_interruptions
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import gates
from seamap_rt.scene import load_scene

SIZES = {"receiver": 2, "antenna": 2, "xyz": 3, "rpy": 3, "transmitter": 2, "turn": 1}


def arrays(product: str, seed: int = 0) -> dict[str, np.ndarray]:
    """Random values of every variable of a product."""
    random = np.random.default_rng(seed)
    values = {}
    for number, (name, variable) in enumerate(SCHEMA[product].items()):
        shape = tuple(SIZES.get(dim, 4 + len(dim)) for dim in variable.dims)
        drawn = random.normal(size=shape) + (1j * random.normal(size=shape) if variable.dtype[0] == "c" else 0.0)
        values[name] = (10.0 * drawn).astype(variable.dtype) if number else np.arange(shape[0]).astype(variable.dtype)
    return values


def made(product: str, seed: int = 0, **changed: Any) -> xr.Dataset:
    """A dataset of a product, with values or (as attrs=…) attributes changed."""
    attrs = dict.fromkeys(ECHO_ATTRIBUTES, 1) if product == "echoes" else {}
    attrs = changed.pop("attrs", attrs)
    values = arrays(product, seed) | changed
    coords = {name: values.pop(name) for name in list(values) if name in ("turn", "time", "azimuth", "range", "pulse")}
    return build(product, values, coords, attrs)


def refusal(action: Any, *words: str) -> None:
    with pytest.raises(SchemaError) as error:
        action()
    message = str(error.value)
    assert "\n" not in message
    for word in words:
        assert word in message


# ---------------------------------------------------------------------------------------------------- building


@pytest.mark.parametrize("product", SCHEMA)
def test_what_is_built_keeps_the_schema(product: str) -> None:
    dataset = made(product)
    check(product, dataset)
    assert set(dataset.variables) == set(SCHEMA[product])
    for name, variable in SCHEMA[product].items():
        assert dataset[name].dims == variable.dims
        assert dataset[name].dtype == np.dtype(variable.dtype)


@pytest.mark.parametrize("product", SCHEMA)
def test_cf_attributes_are_on_every_variable(product: str) -> None:
    dataset = made(product)
    assert dataset.attrs["Conventions"].startswith("CF-")
    for name, variable in SCHEMA[product].items():
        attributes = dataset[name].attrs
        assert attributes["units"] == variable.units
        assert len(attributes["long_name"]) > 3
        assert attributes.get("standard_name") == variable.standard_name
    for name in {"quality", "flag"} & set(dataset.variables):
        assert_array_equal(dataset[name].attrs["flag_masks"], list(QUALITY_FLAGS.values()))
        assert dataset[name].attrs["flag_masks"].dtype == dataset[name].dtype  # CF: the type of the variable
        assert dataset[name].attrs["flag_meanings"].split() == list(QUALITY_FLAGS)


def test_heights_carry_their_cf_name() -> None:
    for product in ("maps/polar", "maps/ground", "truth/polar", "truth/ground"):
        assert made(product)["height"].attrs["standard_name"] == "sea_surface_height_above_mean_sea_level"


def test_quality_flags_are_bits_of_their_own() -> None:
    assert list(QUALITY_FLAGS) == [
        "no_echo",
        "low_coherence",
        "ambiguous",
        "partly_shadowed",
        "saturated",
        "blind",
        "submerged",
    ]
    assert list(QUALITY_FLAGS.values()) == [1 << bit for bit in range(7)]


def test_values_are_cast_and_kept() -> None:
    values = arrays("maps/polar")
    dataset = made("maps/polar", height=values["height"].astype(np.float64), turn=[0])
    assert dataset["height"].dtype == np.float32
    assert_array_equal(dataset["height"].values, values["height"])


# --------------------------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize("product", SCHEMA)
def test_unknown_names_are_refused(product: str) -> None:
    refusal(lambda: made(product, unheard_of=np.zeros(3)), product, "'unheard_of'", "not in the schema")


@pytest.mark.parametrize("product", SCHEMA)
def test_missing_variables_are_refused(product: str) -> None:
    whole = made(product)
    for name, variable in SCHEMA[product].items():
        if variable.required:
            refusal(lambda name=name: check(product, whole.drop_vars(name)), product, f"'{name}'", "missing")
        else:
            check(product, whole.drop_vars(name))


def test_building_without_a_variable_is_refused() -> None:
    values = arrays("truth/ground")
    coords = {name: values.pop(name) for name in ("turn", "y", "x")}
    del values["height"]
    refusal(lambda: build("truth/ground", values, coords), "truth/ground", "'height'", "missing")


@pytest.mark.parametrize("name", ECHO_ATTRIBUTES)
def test_missing_attributes_are_refused(name: str) -> None:
    attrs = dict.fromkeys(ECHO_ATTRIBUTES, 1)
    del attrs[name]
    refusal(lambda: made("echoes", attrs=attrs), "echoes", f"'{name}'", ECHO_ATTRIBUTES[name])


def test_wrong_dimensions_are_refused() -> None:
    refusal(lambda: made("maps/polar", height=np.zeros((3, 4))), "maps/polar", "'height'", "2 dimensions")
    whole = made("maps/polar")
    other = whole.assign(height=whole["height"].transpose("azimuth", "turn", "range"))
    refusal(lambda: check("maps/polar", other), "'height'", "('azimuth', 'turn', 'range')")


def test_wrong_types_are_refused() -> None:
    whole = made("echoes")
    refusal(lambda: check("echoes", whole.assign(voltage=whole["voltage"].real)), "'voltage'", "float32", "complex64")
    polar = made("maps/polar")
    refusal(lambda: check("maps/polar", polar.assign(quality=polar["height"])), "'quality'", "float32", "int16")
    check("maps/polar", polar.assign(height=polar["quality"]))  # whole numbers of metres are heights too
    text = xr.DataArray(np.full(polar["height"].shape, "high"), dims=polar["height"].dims)
    refusal(lambda: check("maps/polar", polar.assign(height=text)), "'height'")


@pytest.mark.parametrize("dim", ["receiver", "antenna", "xyz"])
def test_echoes_of_one_antenna_are_refused(dim: str) -> None:
    refusal(lambda: check("echoes", made("echoes").isel({dim: slice(0, 1)})), "size 2", "size 3")


# ------------------------------------------------------------------------------------------- echoes on the disk


def echo_turns(count: int) -> list[xr.Dataset]:
    """Turns of random voltages, one pulse under water, through the writer's own builder."""
    radar = load_scene("tiny", overrides={"radar.sector_deg": [240.0, 250.0], "radar.range_m": [15.0, 40.0]}).radar
    random = np.random.default_rng(3)
    turns = []
    for number in range(count):
        fired = pulses(Installation(radar), number)
        shape = (fired.number.size, 2, gates(radar).size)
        voltage = (random.normal(size=shape) + 1j * random.normal(size=shape)).astype(np.complex64) * 1e-7
        drowned = np.zeros(shape[0], dtype=bool)
        drowned[5 + number] = True
        voltage[drowned] = np.nan
        turns.append(echo_dataset(Installation(radar), [fired], [voltage], "HH", [drowned], first_turn=number))
    return turns


def both(turns: list[xr.Dataset]) -> xr.Dataset:
    joined = xr.concat(turns, "pulse", data_vars="minimal", coords="minimal", compat="override")
    return joined.assign_attrs(turns[-1].attrs)


def assert_same_echoes(found: xr.Dataset, expected: xr.Dataset) -> None:
    """Names, roles, values to the bit, attributes; flag masks compare as lists (JSON has no arrays)."""
    assert set(found.data_vars) == set(expected.data_vars)
    assert set(found.coords) == set(expected.coords)
    for name in expected.variables:
        assert found[name].dims == expected[name].dims
        assert found[name].dtype == expected[name].dtype
        assert found[name].values.tobytes() == expected[name].values.tobytes()
        for key, value in expected[name].attrs.items():
            assert_array_equal(found[name].attrs[key], value)
    assert {key: found.attrs[key] for key in expected.attrs} == expected.attrs


def store_of(folder: Path, *turns: xr.Dataset) -> GrowingStore:
    store = GrowingStore(folder / "run.zarr", ("turn", "pulse"))
    for turn in turns:
        store.append({"echoes": turn})
    return store


def test_echoes_survive_the_store_to_the_bit(tmp_path: Path) -> None:
    turns = echo_turns(2)
    store = store_of(tmp_path, turns[0])
    assert_same_echoes(open_echoes(tmp_path), turns[0])
    store.append({"echoes": turns[1]})
    found = open_echoes(tmp_path)
    assert_same_echoes(found, both(turns))
    assert found.attrs["complete_turns"] == 2
    assert np.isnan(found["voltage"].values).any(axis=(1, 2)).sum() == 2
    assert_array_equal(found["flag"].values[np.isnan(found["voltage"].values).any(axis=(1, 2))], 64)
    store.close()
    assert_same_echoes(open_echoes(tmp_path), both(turns))


def test_store_is_complex64_zarr_for_anyone(tmp_path: Path) -> None:
    store_of(tmp_path, *echo_turns(1)).close()
    for group in (
        zarr.open_group(tmp_path / "run.zarr/echoes", mode="r"),
        zarr.open_group(tmp_path / "run.zarr")["echoes"],
    ):
        assert isinstance(group, zarr.Group)
        voltage = group["voltage"]
        assert isinstance(voltage, zarr.Array)
        assert voltage.dtype == np.complex64
        assert voltage.metadata.zarr_format == 3
        assert dict(group.attrs)["complete_turns"] == 1
        assert set(ECHO_ATTRIBUTES) <= set(group.attrs)


def test_a_new_store_replaces_the_old_one(tmp_path: Path) -> None:
    first, second = echo_turns(2)
    store_of(tmp_path, first).close()
    store_of(tmp_path, second.assign_attrs(complete_turns=1)).close()
    found = xr.open_zarr(tmp_path / "run.zarr", group="echoes", consolidated=False)
    assert_array_equal(found["turn"].values, 1)


@pytest.mark.parametrize("broken", ["voltage", "time", "flag", "transmitter"])
def test_turn_that_fails_halfway_leaves_the_whole_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, broken: str
) -> None:
    """As when the disk fills: some arrays have the turn, one has not."""
    first, second = echo_turns(2)
    store = store_of(tmp_path, first)
    write = zarr.AsyncArray.setitem

    async def fails(array: zarr.AsyncArray[Any], *given: Any) -> Any:
        if array.basename == broken:
            raise OSError(28, "No space left on device")
        return await write(array, *given)

    with monkeypatch.context() as patch:
        patch.setattr(zarr.AsyncArray, "setitem", fails)
        with pytest.raises(OSError, match=r"run\.zarr"):
            store.append({"echoes": second})
    assert_same_echoes(open_echoes(tmp_path), first)
    store.append({"echoes": second})  # and the store can go on
    assert_same_echoes(open_echoes(tmp_path), both([first, second]))


def test_store_without_an_attribute_is_refused(tmp_path: Path) -> None:
    store_of(tmp_path, *echo_turns(1)).close()
    (tmp_path / "run.zarr/echoes").rename(tmp_path / "echoes.zarr")
    shutil.rmtree(tmp_path / "run.zarr")
    del zarr.open_group(tmp_path / "echoes.zarr", mode="r+").attrs["baseline_m"]
    refusal(lambda: open_echoes(tmp_path), "'baseline_m'", "missing")


# ------------------------------------------------------------------------------------------ NetCDF by turns


def tree(turn: int, product: str = "maps") -> xr.DataTree:
    groups = {}
    for group in ("polar", "ground"):
        name = f"{product}/{group}"
        dataset = made(name, seed=0).assign_coords(turn=np.array([turn], dtype=np.int32))
        dataset["turn"].attrs = made(name)["turn"].attrs
        fields = [key for key in dataset.data_vars if dataset[key].dtype.kind == "f"]
        random = np.random.default_rng(turn)
        for key in fields:
            dataset[key].values[...] = random.normal(size=dataset[key].shape)
            dataset[key].values.flat[turn] = np.nan
        groups[f"/{group}"] = dataset
    return xr.DataTree.from_dict(groups)


def joined(trees: list[xr.DataTree]) -> dict[str, xr.Dataset]:
    return {
        group: xr.concat([t[group].to_dataset() for t in trees], "turn", data_vars="minimal")
        for group in ("polar", "ground")
    }


@pytest.mark.parametrize("product", ["maps", "truth"])
@pytest.mark.parametrize("turns", [1, 3])
def test_trees_survive_the_file(tmp_path: Path, product: str, turns: int) -> None:
    trees = [tree(turn, product) for turn in range(turns)]
    with AppendableNetCDF(tmp_path / "maps.nc") as file:
        for one in trees:
            file.append(one)
    with xr.open_datatree(tmp_path / "maps.nc") as found:
        assert set(found.children) == {"polar", "ground"}
        for group, expected in joined(trees).items():
            dataset = found[group].to_dataset().load()
            check(f"{product}/{group}", dataset)
            assert set(dataset.data_vars) == set(expected.data_vars)
            assert set(dataset.coords) == set(expected.coords)
            assert dataset.attrs == expected.attrs
            for name in expected.variables:
                assert dataset[name].dtype == expected[name].dtype
                assert_array_equal(dataset[name].values, expected[name].values)  # NaN equals NaN
                for key, value in expected[name].attrs.items():
                    assert_array_equal(dataset[name].attrs[key], value)


def test_coordinates_beside_the_dimensions_stay_coordinates(tmp_path: Path) -> None:
    one = tree(0)
    polar = one["polar"].to_dataset().set_coords("time")
    with AppendableNetCDF(tmp_path / "maps.nc") as file:
        file.append(xr.DataTree.from_dict({"/polar": polar}))
    with xr.open_datatree(tmp_path / "maps.nc") as found:
        assert "time" in found["polar"].coords


@pytest.fixture
def minds_ctrl_c() -> Iterator[None]:
    """SIGINT raises KeyboardInterrupt, even where the tests run in the background, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("minds_ctrl_c")
def test_signals_wait_while_a_turn_is_written() -> None:
    """Ctrl-C in the middle of a turn's files is raised after the last of them, once, and only then."""
    done: list[str] = []

    def write() -> None:
        with hold_interruptions():
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGALRM)  # nor does one that is raised again cut it off
            done.append("written")
        done.append("not reached")

    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with pytest.raises(KeyboardInterrupt):
        write()
    assert done == ["written"]
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before
    with hold_interruptions():
        done.append("again")
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_other_threads_write_without_signals() -> None:
    """Handlers can be set in the main thread only; a run in another one must not fail for it."""
    done: list[str] = []

    def write() -> None:
        with hold_interruptions():
            done.append("written")

    thread = threading.Thread(target=write)
    thread.start()
    thread.join()
    assert done == ["written"]


def test_earlier_file_is_untouched_until_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "maps.nc"
    with AppendableNetCDF(path) as file:
        file.append(tree(0))
    before = path.read_bytes()
    with AppendableNetCDF(path) as file:
        assert path.read_bytes() == before
        file.append(tree(0))
        file.append(tree(1))
        assert path.read_bytes() == before
    with xr.open_datatree(path) as found:
        assert found["polar"].sizes["turn"] == 2
    whole = path.read_bytes()
    with AppendableNetCDF(path):  # no turn: the earlier results stay
        pass
    assert path.read_bytes() == whole
    assert [found.name for found in tmp_path.iterdir()] == ["maps.nc"]


def test_turn_that_fails_halfway_is_taken_back(tmp_path: Path) -> None:
    """Its first group is written, its second does not fit: both end with the turn before."""
    bad = tree(1)
    broken = xr.DataTree.from_dict(
        {"/polar": bad["polar"].to_dataset(), "/ground": bad["ground"].to_dataset().isel(x=slice(0, 2))}
    )

    def write() -> None:
        with AppendableNetCDF(tmp_path / "maps.nc") as file:
            file.append(tree(0))
            file.append(broken)

    with pytest.raises(Exception, match="after others of"):
        write()
    with xr.open_datatree(tmp_path / "maps.nc") as found:
        for group, expected in joined([tree(0)]).items():
            assert found[group].sizes["turn"] == 1
            assert_array_equal(found[group]["height"].values, expected["height"].values)
