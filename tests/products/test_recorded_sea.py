"""The nonlinear sea on file: what is in it, that a stopped one goes on with the same bits, and what is refused."""

from __future__ import annotations

import itertools
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sea_products
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

from seamap_rt.cli import main
from seamap_rt.dataset import check
from seamap_rt.errors import InputError, MachineLimitError
from seamap_rt.io.recorded_sea import recorded_sea as recorded_sea_file
from seamap_rt.io.recovery import recover
from seamap_rt.products import recorded_sea
from seamap_rt.products.recorded_sea import RecordedSea, write_recorded_sea
from seamap_rt.resolved_scene import run_sea
from seamap_rt.scene import Scene
from seamap_rt.sea.recorded import first_frame

TIMES, SPACING, SIDE = "1:3.4:0.4", 3.0, 84.0  # s, m, m


def scene(**keys: Any) -> Scene:
    """Waves of 25 m, and down to 6 m, on 84 m."""
    small: dict[str, Any] = {
        "sea__extent_m": SIDE,
        "sea__resolution_m": SPACING,
        "sea__waves__0__significant_wave_height_m": 0.8,
        "sea__waves__0__peak_period_s": 4.0,
        "radar__range_m": [5.0, 12.0],
        "radar__height_m": 2.0,
    }
    return sea_products.scene(**(small | keys))


def opened(folder: Path) -> xr.Dataset:
    with xr.open_dataset(folder / "recorded_sea.nc", decode_times=False) as fields:
        return fields.load()


def write(folder: Path, **options: Any) -> RecordedSea:
    return write_recorded_sea(scene(), folder, **{"times": TIMES, "order": 2, "spacing": SPACING, **options})


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[xr.Dataset, RecordedSea]:
    folder = tmp_path_factory.mktemp("whole")
    made = write(folder)
    assert [path.name for path in folder.iterdir() if path.name != ".seamap-rt.lock"] == ["recorded_sea.nc"]
    return opened(folder), made


def test_file_says_what_it_holds(whole: tuple[xr.Dataset, RecordedSea]) -> None:
    fields, made = whole
    check("recorded_sea", fields)
    assert fields["elevation"].dims == ("time", "y", "x")
    assert {fields[name].dtype for name in ("elevation", "surface_potential")} == {np.dtype(np.float32)}
    assert_allclose(fields["time"], np.arange(1.0, 3.5, 0.4))
    step = fields.attrs["spacing_m"]
    for name in ("x", "y"):
        assert_allclose(fields[name], -0.5 * SIDE + step * np.arange(fields.sizes[name]))
        assert_allclose(fields.sizes[name] * step, SIDE)  # the next point would be the first again
    wanted = {"periodic": 1, "order": 2, "seed": scene().seed, "depth_m": np.inf, "scene": scene().to_toml()}
    assert {name: fields.attrs[name] for name in wanted} == wanted
    told = {name: value for name, value in made.attributes.items() if name != "scene"}
    assert {name: fields.attrs[name] for name in told} == told
    height = 4.0 * np.sqrt(np.mean(np.var(fields["elevation"].values.astype(float), axis=(1, 2))))
    assert_allclose(fields.attrs["significant_wave_height_m"], height, rtol=1e-4)
    # Of one draw of some 30 waves a side; 3 % went with the breaking and the beginning.
    assert_allclose(height, fields.attrs["significant_wave_height_asked_m"], rtol=0.05)
    assert abs(fields.attrs["energy_drift"]) < 1e-4
    assert 0.0 < fields.attrs["energy_broken"] < fields.attrs["energy_broken_since_start"] < 0.1
    assert "Hs 0." in made.headline()


def test_water_moves_with_the_surface(whole: tuple[xr.Dataset, RecordedSea]) -> None:
    """∂η/∂t = w − u·∇η (1 + …): by differences in time and the linear part of W, up to second order, (ka)² = 3 %.

    Central differences over 0.8 s leave (ω dt)²/6 = 7 % at the peak and more beyond: so both sides are compared as far
    as they agree, 0.95 of correlation.
    """
    fields, _ = whole
    height, potential = (fields[name].values.astype(float) for name in ("elevation", "surface_potential"))
    k = 2.0 * np.pi * np.fft.fftfreq(height.shape[1], fields.attrs["spacing_m"])
    size = np.hypot(k[:, None], k)
    up = np.fft.ifft2(size * np.fft.fft2(potential[2])).real
    rise = (height[3] - height[1]) / 0.8
    assert np.corrcoef(up.ravel(), rise.ravel())[0, 1] > 0.95
    assert_allclose(np.std(up), np.std(rise), rtol=0.15)


def test_order_one_is_the_runs_linear_sea(tmp_path: Path) -> None:
    """At every point and time, on a current: the sea that the scene itself would draw. Heights are rounded to 6e-5 m,
    and its own are interpolated."""
    made = scene(sea__current_m_s=0.8, sea__current_toward_deg=20.0, seed=5)
    write_recorded_sea(made, tmp_path, times="2:3:0.5", order=1)
    fields, sea = opened(tmp_path), run_sea(made)
    expected = sea.elevation(
        fields["x"].values[None, None], fields["y"].values[None, :, None], np.array([2, 2.5, 3])[:, None, None]
    )
    assert np.std(expected) > 0.06
    assert_allclose(fields["elevation"], expected, atol=1e-4 + 6.0 * sea.resolved.elevation_error)


def test_long_crested_sea_has_alike_rows(tmp_path: Path) -> None:
    made = scene(sea__waves__0__spreading="long_crested", sea__waves__0__wave_from_deg=270.0)
    write_recorded_sea(made, tmp_path, times="0:1:0.5", order=1)
    fields, sea = opened(tmp_path), run_sea(made)
    assert fields.sizes["x"] == fields.sizes["y"]
    assert fields.attrs["length_m"] == 4 * SIDE
    height = fields["elevation"].values
    assert_array_equal(height, np.broadcast_to(height[:, :1], height.shape))
    assert_allclose(
        height[0, 0], sea.elevation(fields["x"].values, 7.0, 0.0), atol=1e-4 + 6.0 * sea.resolved.elevation_error
    )


def test_a_scene_takes_the_record(tmp_path: Path) -> None:
    """Its water stands where the file has it, to what the reader states of its spline."""
    drawn = scene()
    made = write_recorded_sea(drawn, tmp_path, times="0:6:0.25", order=2, spacing=SPACING)
    fields = opened(tmp_path)
    again = sea_products.scene(
        sea__model="recorded",
        sea__file=str(made.file),
        **{f"sea__{name}": None for name in ("waves", "extent_m", "resolution_m", "current_m_s", "current_toward_deg")},
        radar__range_m=[5.0, 12.0],
        radar__height_m=2.0,
    )
    sea, frames = run_sea(again), recorded_sea_file(str(made.file))
    assert frames.periodic
    assert frames.potential
    assert_allclose(frames.side_m, SIDE)
    number = first_frame(frames) + 4
    x, y = fields["x"].values, fields["y"].values[:, None]
    error = sea.resolved.elevation_error
    assert_allclose(sea.elevation(x, y, 1.0), fields["elevation"][number], atol=6.0 * error + 1e-3)
    assert error < 0.02 * np.std(fields["elevation"][number])


# ------------------------------------------------------------------------------------------------- it goes on


def assert_goes_on(folder: Path, whole: xr.Dataset) -> None:
    assert write(folder, resume=True).file.exists()
    fields = opened(folder)
    xr.testing.assert_identical(fields, whole)
    assert not list(folder.glob("*.part")) + list(folder.glob(".recorded*"))


@pytest.mark.parametrize("word", ["set in: 0.", "recorded: 1.8"])
def test_interrupted_it_goes_on_with_the_same_bits(
    word: str,
    whole: tuple[xr.Dataset, RecordedSea],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By a clock that runs a minute a reading."""
    passing = SimpleNamespace(perf_counter=itertools.count(0.0, 60.0).__next__)
    monkeypatch.setattr(recorded_sea, "clock", passing)

    def stop(line: str) -> None:
        if word in line:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="--resume"):
        write(tmp_path, progress=stop)
    if "recorded" in word:
        assert opened(tmp_path).sizes["time"] == 3
    with pytest.raises(InputError, match="--resume goes on"):
        write(tmp_path)
    with pytest.raises(InputError, match="another order"):
        write(tmp_path, resume=True, order=3)
    with pytest.raises(InputError, match="another scene"):
        write_recorded_sea(scene(radar__height_m=3.0), tmp_path, times=TIMES, order=2, spacing=SPACING, resume=True)
    assert_goes_on(tmp_path, whole[0])


def test_interrupted_before_anything_is_kept_it_says_nothing_of_going_on(tmp_path: Path) -> None:
    def stop(_: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        write(tmp_path, progress=stop)
    assert "--resume" not in str(stopped.value)
    write(tmp_path)  # and the same command begins anew


_KILLED = """
import os, sys
sys.path.insert(0, {tests!r})
from pathlib import Path
import test_recorded_sea as it
keep, count = it.recorded_sea.save_state, 0
def killed(*given):
    global count
    count += 1
    if count == 5:  # the first is before all frames
        os._exit(9)  # the fourth frame is on file, its state is not
    keep(*given)
it.recorded_sea.save_state = killed
it.write(Path({folder!r}))
"""


@pytest.mark.parametrize("recovered", [False, True])
@pytest.mark.slow
def test_killed_it_goes_on_with_the_same_bits(
    recovered: bool, whole: tuple[xr.Dataset, RecordedSea], tmp_path: Path
) -> None:
    script = _KILLED.format(tests=str(Path(__file__).parent), folder=str(tmp_path))
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 9
    assert not (tmp_path / "recorded_sea.nc").exists()
    if recovered:
        found = recover(tmp_path)
        assert found is not None
        assert found.complete == 4
        xr.testing.assert_equal(opened(tmp_path), whole[0].isel(time=slice(4)))
    assert_goes_on(tmp_path, whole[0])


# ------------------------------------------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"times": "0,1,3"}, "even times"),
        ({"times": "3"}, "even times"),
        ({"order": 0}, "--order = 0"),
        ({"spacing": -1.0}, "--spacing = -1"),
        ({"resume": True}, "leave --resume out"),
    ],
)
def test_what_cannot_be_is_refused(options: dict[str, Any], words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        write(tmp_path / "out", **options)


def test_too_little_memory_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorded_sea, "free_memory", lambda: 1e5)
    with pytest.raises(MachineLimitError, match=r"GB of memory.*raise --spacing"):
        write(tmp_path)


def test_a_sea_that_cannot_live_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By steps that are far too long."""
    monkeypatch.setattr(recorded_sea.Plan, "longest_step", 3.0)
    with pytest.raises(InputError, match="breaks beyond"):
        write(tmp_path, times="0:90:3", order=3)
    assert not list(tmp_path.glob(".recorded*"))


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "it.toml").write_text(scene().to_toml(), encoding="utf-8")
    given = ["sea", str(tmp_path / "it.toml"), "--out", str(tmp_path / "out")]

    def run(*arguments: str) -> tuple[int, str]:
        with pytest.raises(SystemExit) as end:
            main([*given, *arguments])
        assert isinstance(end.value.code, int)
        return end.value.code, "".join(capsys.readouterr())

    code, told = run("--nonlinear", "--order", "1", "--times", "0:1:0.5", "--spacing", "5")
    assert code == 0
    assert "Hs 0." in told
    assert "recorded_sea.nc" in told
    assert "are left out" in told
    for wrong, words in (
        (["--order", "2"], "give --nonlinear"),
        (["--resume"], "give --nonlinear"),
        (["--nonlinear", "--side", "20"], "fills its patch"),
        (["--nonlinear"], "--overwrite"),
    ):
        code, refused = run(*wrong)
        assert code == 2
        assert words in refused
