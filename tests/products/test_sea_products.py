"""The spectrum beside the sea on file, what the command writes and says, and what it refuses."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sea_products
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal
from sea_products import DRAWINGS, PNG, scene, written

from seamap_rt.cli import main
from seamap_rt.errors import InputError, NoBackendError
from seamap_rt.products import writing
from seamap_rt.products.sampling import square_points, times_of
from seamap_rt.products.writing import directional_spectrum
from seamap_rt.report import style
from seamap_rt.scene import Scene, load_scene
from seamap_rt.sea.spectra import elfouhaily97
from seamap_rt.simulation import Simulator

without_pictures = sea_products.without_pictures  # a fixture of every test

# ---------------------------------------------------------------------------------------------------- the spectrum


def mixed() -> Scene:
    waves = [
        {"spectrum": "jonswap", "significant_wave_height_m": 0.9, "peak_period_s": 4.0, "wave_from_deg": 300.0},
        {"spectrum": "flat"},
        {
            "spectrum": "jonswap",
            "significant_wave_height_m": 0.5,
            "peak_period_s": 3.0,
            "wave_from_deg": 30.0,
            "spreading": "long_crested",
        },
        {"spectrum": "sinusoid", "height_m": 0.3, "wavelength_m": 20.0, "wave_from_deg": 200.0},
    ]
    return scene(sea__waves=waves, sea__depth_m=15.0)


def test_spectrum_holds_each_systems_height_and_direction() -> None:
    made = mixed()
    spectrum = directional_spectrum(made, Simulator(made).sea)
    assert_array_equal(spectrum["system"].values, [0, 2, 3])
    assert_array_equal(spectrum["system_kind"].values, [0, 1, 2])
    assert_allclose(spectrum["system_direction"].values, [300.0, 30.0, 200.0], atol=1e-9)
    assert_allclose(spectrum["system_height"].values, [0.9, 0.5, 0.3], rtol=1e-6)
    frequency = spectrum["frequency"].values
    of_systems = spectrum["system_spectrum"].values
    # 240 points by the trapezoid rule, and up to six times the peak: 1 − 0.1 % of the height.
    heights = 4.0 * np.sqrt(np.trapezoid(of_systems, frequency, axis=1))
    assert_allclose(heights, [0.9, 0.5, 0.0], rtol=3e-3)
    assert_allclose(1.0 / frequency[of_systems[:2].argmax(axis=1)], [4.0, 3.0], rtol=0.01)  # half a step
    assert_allclose(spectrum["frequency_spectrum"].values, of_systems.sum(axis=0))
    plane = spectrum["directional_spectrum"].values
    # Over the circle the sum is exact but for the spreading's harmonics beyond 90: none of cos^20(θ/2) has any.
    assert_allclose(2.0 * plane.sum(axis=1), of_systems[0], rtol=1e-9)
    assert spectrum["direction"].values[plane.sum(axis=0).argmax()] == 300.0


def test_file_of_a_mixed_and_of_no_sea_can_be_written(tmp_path: Path) -> None:
    for name, made in (("mixed", mixed()), ("none", scene(sea__waves=[]))):
        fields, result = written(tmp_path / name, made, times="0", side=40.0, spacing=1.0)
        assert np.isfinite(fields["sea_surface_height"].values).all()
        assert "significant height" in (tmp_path / name / "statistics.txt").read_text()
        assert "nan" not in (tmp_path / name / "statistics.txt").read_text()
        with xr.open_dataset(tmp_path / name / "sea.nc", group="spectrum") as spectrum:
            assert spectrum.sizes["system"] == len([1 for each in made.sea.waves if each.spectrum != "flat"])
        assert result.headline().startswith("Hs ")


# ------------------------------------------------------------------------------------------------ what is refused


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0:5:0.5", np.arange(11) * 0.5),
        ("0:1:0.3", [0.0, 0.3, 0.6, 0.9]),
        ("0:0.3:0.1", [0.0, 0.1, 0.2, 0.3]),
        ("2:2:1", [2.0]),
        ("1,2.5,4", [1.0, 2.5, 4.0]),
        ("3", [3.0]),
    ],
)
def test_times_are_read(text: str, expected: Any) -> None:
    assert_allclose(times_of(text), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "must be numbers"),
        ("now", "must be numbers"),
        ("1,,2", "must be numbers"),
        ("0:5", "three numbers"),
        ("0:1:2:3", "three numbers"),
        ("0,1:2", "three numbers"),
        ("5:0:1", "STOP at least START"),
        ("0:5:0", "STEP must be greater than 0"),
        ("0:5:-1", "STEP must be greater than 0"),
        ("0:1e9:0.1", "1e[+]10 values"),
        ("1,0", "later than the one before"),
        ("1,1", "later than the one before"),
        ("nan", "finite"),
        ("0:inf:1", "finite"),
    ],
)
def test_times_that_are_none_are_refused(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        times_of(text)


def test_default_square_is_the_range_circle_at_what_is_resolved() -> None:
    places = square_points(scene())
    assert_allclose(places[1] - places[0], 1.6, rtol=0.02)  # a whole number of points fills the side
    assert_allclose(places[-1] - places[0] + places[1] - places[0], 60.0)
    assert_allclose(places, -places[::-1], atol=1e-12)
    wide = load_scene("choppy_sea")
    assert_allclose(np.diff(square_points(wide)), 800.0 / 512.0)
    assert square_points(load_scene("long_crested_swell", overrides={"sea.extent_m": 200.0}))[-1] < 100.0


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """`seamap-rt sea` in this process, in an empty folder; SIGTERM is given back as it was."""
    monkeypatch.chdir(tmp_path)
    before = signal.getsignal(signal.SIGTERM)
    Path("small.toml").write_text(scene().to_toml())

    def run(*arguments: Any) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            main(["sea", "small.toml", *(str(argument) for argument in arguments)])
        said = capsys.readouterr()
        assert isinstance(end.value.code, int)
        return end.value.code, said.out, said.err

    yield run
    signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--times", "3:1:1"), "--times = '3:1:1'"),
        (("--times", "0:5:0"), "STEP must be greater than 0"),
        (("--side", "0"), "--side = 0"),
        (("--side", "nan"), "--side = nan"),
        (("--side", "129"), "at most 128, sea.extent_m"),
        (("--spacing", "61"), "half of --side"),
        (("--spacing", "-1"), "--spacing = -1"),
        (("--spacing", "0.01"), "GB of memory"),
        (("--spacing", "0.02", "--times", "0:500:0.1"), "GB"),
        (("--side", "wide"), "wide"),
        (("--set", "sea.wavs=1"), "sea.wavs"),
        (("--set", "sea.extent_m"), "KEY=VALUE"),
    ],
)
def test_bad_input_is_one_line(call: Any, options: tuple[str, ...], words: str) -> None:
    code, out, err = call("--out", "results", *options)
    assert (code, out) == (2, "")
    assert err.startswith("seamap-rt: ")
    assert err.count("\n") == 1
    assert words in err
    assert not list(Path("results").glob("*"))


def test_command_writes_everything_and_says_so(call: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the pictures, but for the one from the mast, which here finds no backend: that is a line, not an end."""

    def refused(*_: Any, **__: Any) -> None:
        raise NoBackendError("no LLVM was found; install one")

    for module, name, draw in DRAWINGS:
        monkeypatch.setattr(module, name, draw)
    monkeypatch.setattr(style, "png", PNG)
    monkeypatch.setattr("seamap_rt.tracing.picture.render_from_mast", refused)
    options = ("--out", "results", "--times", "0,0.4,1.2", "--spacing", "1", "--seed", "5")
    code, out, err = call(*options)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == "from_mast.png is left out: no LLVM was found; install one"
    assert lines[1].startswith("Hs 0.")
    assert "0.90 m asked for" in lines[1]
    assert lines[2].startswith("results/sea.nc (with statistics.txt, ")
    left = {path.name for path in Path("results").iterdir()}
    assert left == set(writing.PRODUCTS) - {"from_mast.png"}
    with xr.open_dataset("results/sea.nc", decode_times=False) as fields:
        assert_allclose(fields["time"].values, [0.0, 0.4, 1.2])
        assert fields.attrs["seed"] == 5
    assert call(*options)[0] == 2  # another run's results
    code, out, err = call("--out", "results", "--times", "0", "--spacing", "2", "--overwrite")
    assert code == 0
    assert "sea.gif is left out: it needs two times" in out
    assert not Path("results/sea.gif").exists()


def test_sky_from_the_mast_is_blurred_by_the_scenes_own_wind_sea(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The slopes below the mesh are ∫ k² S dk of the scene's wind and wave age, here by a plain sum."""
    slopes = []

    def seen(*_: Any, unresolved_mss: float, **__: Any) -> None:
        slopes.append(unresolved_mss)
        raise NoBackendError("not drawn here")

    monkeypatch.setattr("seamap_rt.tracing.picture.render_from_mast", seen)
    young = scene(scattering__inverse_wave_age=3.0, scattering__wind_speed_m_s=8.0)
    written(tmp_path, young, times="0", spacing=1.0)
    k = np.geomspace(Simulator(young).sea.resolved.wavenumber_limit, 2e4, 20_001)
    assert slopes == pytest.approx([np.trapezoid(k**2 * elfouhaily97(k, 8.0, 3.0), k)], rel=1e-3)
    assert slopes != pytest.approx([np.trapezoid(k**2 * elfouhaily97(k, 8.0), k)], rel=1e-2)


def test_a_sea_of_which_nothing_is_resolved_can_be_written(tmp_path: Path) -> None:
    ripples = {"spectrum": "jonswap", "significant_wave_height_m": 0.05, "peak_period_s": 0.5}
    file, made = written(tmp_path, scene(sea__waves=[ripples], sea__resolution_m=15.0))
    assert not file["sea_surface_height"].values.any()
    assert_allclose(file.attrs["sea_significant_wave_height"], 0.05, rtol=1e-3)
    assert "0.05 m asked for" in made.headline()
