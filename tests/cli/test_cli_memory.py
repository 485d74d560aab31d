"""Under limits of memory a command succeeds, or ends at once with one line and exit code 4."""

from __future__ import annotations

import resource
from pathlib import Path

import pytest

from seamap_rt.cli.application import NO_RESOURCE, answer
from seamap_rt.cli.shell import app
from seamap_rt.cli.stops import Stops
from seamap_rt.compute import machine
from seamap_rt.errors import InputError, MachineLimitError, ResourceError, say_of, shortage
from seamap_rt.io.meshfile import load_mesh
from seamap_rt.io.opening import check_declared_size
from seamap_rt.scene import load_scene
from seamap_rt.scene.agreement import run_bytes
from seamap_rt.settings import ObjectSettings
from seamap_rt.simulation import Simulator
from validation.hard_cases.limits import keeps_the_law, under

SCENES = Path(__file__).parents[2] / "scenes"
COMPUTING = (
    "run",
    "simulate",
    "retrieve",
    "predict",
    "shadowing",
    "trade",
    "sea",
    "outlook",
    "link",
    "validate",
    "app",
)


@pytest.mark.parametrize(
    ("kind", "most"), [(resource.RLIMIT_AS, 4e8), (resource.RLIMIT_AS, 1.5e9), (resource.RLIMIT_DATA, 2.1e8)]
)
@pytest.mark.parametrize("tracer", ["facets", "horizon"])
def test_a_run_under_a_limit_ends_with_one_line(kind: int, most: float, tracer: str, tmp_path: Path) -> None:
    code, lines = under(kind, int(most), ["run", "tiny", "--tracer", tracer, "--out", str(tmp_path / "run")])
    assert code == NO_RESOURCE
    assert keeps_the_law(code, lines), lines
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("name", COMPUTING)
def test_each_command_that_computes_asks_for_its_memory_first(name: str, tmp_path: Path) -> None:
    also = {"predict": ["m.nc"], "retrieve": ["e.zarr"], "app": [], "validate": []}.get(name, ["tiny"])
    also += ["--out", str(tmp_path)] if name in ("simulate", "sea") else []
    also += ["--vary", "radar.height_m=3,5"] if name == "trade" else []
    code, lines = under(resource.RLIMIT_DATA, 204_800_000, [name, *also])
    assert code == NO_RESOURCE
    assert keeps_the_law(code, lines), lines


def _in_a_reader(error: BaseException) -> None:
    try:
        raise error
    except Exception:
        raise InputError("echoes.zarr: is damaged") from None


@pytest.mark.parametrize(
    "error", [MemoryError(), RuntimeError("can't start new thread"), ImportError("x.so: failed to map segment from …")]
)
def test_no_file_is_blamed_for_memory(
    error: BaseException, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Readers make damage of what they meet; it stays a lack of memory."""
    monkeypatch.setattr("seamap_rt.cli.application.app", lambda *_, **__: _in_a_reader(error))
    stops = Stops()
    try:
        assert answer([], stops) == NO_RESOURCE
    finally:
        stops.end(process=False)
    assert keeps_the_law(NO_RESOURCE, capsys.readouterr().err.splitlines())
    assert shortage(ValueError("damaged")) is None


@pytest.mark.parametrize("wrapped", [False, True])
def test_what_the_machine_does_not_hold_is_told_as_it_is(
    wrapped: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In its own words and by its own exit code, whoever has worded it anew."""
    lack = MachineLimitError("waves.nc: declares 9 TB of numbers: must fit into 8 GB of free memory; give fewer")
    monkeypatch.setattr(
        "seamap_rt.cli.application.app", lambda *_, **__: _in_a_reader(lack) if wrapped else _raise(lack)
    )
    stops = Stops()
    try:
        assert answer([], stops) == NO_RESOURCE
    finally:
        stops.end(process=False)
    assert capsys.readouterr().err == f"seamap-rt: {lack}\n"


def _raise(error: Exception) -> None:
    raise error


def test_readers_say_that_the_machine_lacks_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """All check by one function."""
    monkeypatch.setattr("seamap_rt.compute.machine.free_memory", lambda: 1e9)
    with pytest.raises(MachineLimitError, match="must fit into 800 MB"):
        check_declared_size("waves.nc", 1e9, 1e9)


def test_a_reader_that_names_its_file_keeps_what_is_larger_than_the_machine() -> None:
    """The subject comes first, the type stays: on a larger machine the input may be right."""
    with (
        pytest.raises(MachineLimitError, match=r"^file 'a\.csv', declares 9 TB$"),
        say_of("file 'a.csv', ", kind=InputError),
    ):
        raise MachineLimitError("declares 9 TB")


def test_a_damaged_mesh_is_no_lack_of_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Content that promises petabytes is bad input by name; the same error without memory is the machine's."""
    file = tmp_path / "buoy.stl"
    file.write_bytes((SCENES / "objects" / "buoy.stl").read_bytes())
    thing = ObjectSettings(mesh=str(file), position_m=(0.0, 50.0, 0.0))

    def petabytes(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("trimesh.load_scene", petabytes)
    with pytest.raises(InputError, match=r"buoy\.stl.*damaged") as caught:
        load_mesh(thing)
    assert shortage(caught.value) is None
    monkeypatch.setattr("seamap_rt.io.meshfile.free_memory", lambda: 0.0)
    with pytest.raises(MemoryError):
        load_mesh(thing)


def test_the_commands_that_compute_are_these() -> None:
    light = {"new", "keys", "scenes", "doctor", "recover", "--install-completion"}
    assert {name for name in app if name not in ("--help", "-h", "--version")} - light == set(COMPUTING)


def test_a_run_is_weighed_before_its_sea_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the estimate of the scene itself: more of a larger scene, and nothing is loaded for what does not fit."""
    scene = load_scene("tiny")
    need = run_bytes(scene)
    monkeypatch.setattr("seamap_rt.simulation.run_sea", lambda *_: pytest.fail("the sea was drawn"))
    monkeypatch.setattr(
        machine, "memory_limits", lambda: iter([machine.Limit(0.9 * need, 0.0, "the test", "give more")])
    )
    with pytest.raises(ResourceError, match="the test allows"):
        Simulator(scene)
    assert run_bytes(load_scene("choppy_sea")) > need
