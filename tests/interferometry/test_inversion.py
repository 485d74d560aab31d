"""Phase to height, its exact inverse, and the small parts of the retrieval, each by a law of its own."""

from __future__ import annotations

import subprocess
import sys
from functools import cache
from typing import Literal

import numpy as np
import pytest
import xarray as xr

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.echoes import from_scatterers
from seamap_rt.errors import SchemaError
from seamap_rt.interferometry import retrieve
from seamap_rt.interferometry.dwells import Dwells
from seamap_rt.interferometry.inversion import Fan, difference_at_height, height_per_phase, locate
from seamap_rt.interferometry.products import Products, dwell_means
from seamap_rt.interferometry.windows import (
    Covariance,
    PhaseSlopes,
    independent_looks,
    window_weights,
)
from seamap_rt.scene import Scene
from seamap_rt.settings import RetrievalSettings
from validation.analytic import height_from_range_difference, range_difference

EPS = np.finfo(np.float64).eps
SHARES = [0.25, 0.5]  # of single and switched transmitters
TILTS = [-0.3, 0.0, 0.2]


def triangle(tilt: float, baseline: float) -> tuple[np.ndarray, ...]:
    """Points by ground range and height, and their exact R₁ and ΔR; the lower antenna stands at 5 m."""
    ground, height = np.meshgrid(np.geomspace(12.0, 3000.0, 40), np.linspace(-2.0, 2.0, 9))
    lower = np.hypot(ground, 5.0 - height)
    return ground, height, lower, range_difference(ground, height, baseline, 5.0, tilt)


@pytest.mark.parametrize("baseline", [0.05, 0.2, 0.9])
@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("share", SHARES)
def test_height_and_ground_range_and_back(share: float, tilt: float, baseline: float) -> None:
    # r = R₁ + share ΔR rounds R₁ by an ulp, and ΔR/B carries few ulp: R · 1e-15 · R/… as the closed form itself.
    ground, height, lower, delta = triangle(tilt, baseline)
    got = locate(lower + share * delta, delta, Fan.upright(baseline, 5.0, tilt, share))
    np.testing.assert_allclose(got.height, height, rtol=0, atol=1e-10)
    np.testing.assert_allclose(got.out, ground, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(got.right, 0.0)
    back = difference_at_height(lower + share * delta, height, Fan.upright(baseline, 5.0, tilt, share))
    np.testing.assert_allclose(back, delta, rtol=0, atol=20 * EPS)
    judge = height_from_range_difference(lower, delta, baseline, 5.0, tilt)
    np.testing.assert_allclose(got.height, judge, rtol=0, atol=1e-10)


@pytest.mark.parametrize("tilt", TILTS)
def test_height_per_phase_is_the_derivative(tilt: float) -> None:
    # At a fixed gate. The formula leaves out B/R of itself, and the gate's own shift by share · ΔR.
    wavelength, baseline, gate = 0.03, 0.2, np.array([30.0, 100.0, 400.0])
    fan = Fan.upright(baseline, 5.0, tilt)
    middle = difference_at_height(gate, 0.0, fan)
    step = 1e-6
    up, down = (locate(gate, middle + s, fan).height for s in (step, -step))
    slope = np.abs(up - down) / (2.0 * step) * wavelength / (2.0 * np.pi)
    got = height_per_phase(gate, middle, fan, wavelength)
    np.testing.assert_allclose(got, slope, rtol=2.0 * baseline / gate.min())
    if tilt == 0.0:
        np.testing.assert_allclose(got, wavelength * gate / (2.0 * np.pi * baseline), rtol=1e-9)


def test_no_triangle_no_height() -> None:
    # Warnings are errors here: none may be given.
    for difference, baseline in ((0.01, 0.0), (0.21, 0.2), (-0.25, 0.2), (np.nan, 0.2), (0.0, np.nan)):
        found = locate(100.0, difference, Fan.upright(baseline, 5.0))
        assert np.isnan(found.height)
        assert np.isnan(found.out)
    mixed = locate(100.0, np.array([0.01, 0.3]), Fan.upright(0.2, 5.0))
    np.testing.assert_array_equal(np.isnan(mixed.height), [False, True])
    # A gate nearer than the mast is high: no sea at z = 0 there, and no warning either.
    assert np.isfinite(difference_at_height(4.0, 0.0, Fan.upright(0.2, 5.0)))
    assert not np.isfinite(height_per_phase(100.0, 0.01, Fan.upright(0.0, 5.0), 0.03))


# ----------------------------------------------------------------------------------------------- windows, looks


@pytest.mark.parametrize("spacing", [0.75, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("width", [0.1, 1.5, 2.7, 3.0, 4.5, 10.0])
def test_window_weights(width: float, spacing: float) -> None:
    weights = window_weights(width, spacing)
    assert weights.size % 2 == 1
    np.testing.assert_array_equal(weights, weights[::-1])
    assert weights.sum() == pytest.approx(width / spacing, rel=1e-12)  # all of the window is covered, once
    assert weights.max() <= 1.0
    assert weights[0] > 0.0
    middle = weights.size // 2
    assert weights[middle] == pytest.approx(min(1.0, width / spacing), rel=1e-12)


def test_independent_looks() -> None:
    assert independent_looks(np.ones(8), np.eye(1, 8).ravel()) == pytest.approx(8.0)
    assert independent_looks(np.ones(8), np.ones(8)) == pytest.approx(1.0)
    assert independent_looks(np.array([0.5, 1.0, 0.5]), np.array([1.0, 0.0, 0.0])) == pytest.approx(4.0 / 1.5)


def test_a_dwells_covariance_is_the_mean_over_its_pulses() -> None:
    rng = np.random.default_rng(1)
    shape = (40, 2, 6)
    voltage = (rng.normal(size=shape) + 1j * rng.normal(size=shape)).astype(np.complex64)
    rows = np.arange(40)
    dwells, kinds = Dwells(np.repeat([2, 0, -1, 1], 10), 4), [[Products((rows, 0), (rows, 1), rows)]]
    (got,) = dwell_means(voltage, dwells, kinds)
    for number, rows in ((0, slice(10, 20)), (1, slice(30, 40)), (2, slice(0, 10))):
        lower, upper = voltage[rows, 0].astype(complex), voltage[rows, 1].astype(complex)
        np.testing.assert_allclose(got.cross[number], (lower * upper.conj()).mean(axis=0), rtol=0, atol=1e-6)
        np.testing.assert_allclose(got.lower[number], (np.abs(lower) ** 2).mean(axis=0), rtol=1e-6)
        np.testing.assert_allclose(got.upper[number], (np.abs(upper) ** 2).mean(axis=0), rtol=1e-6)
    assert np.isnan(got.cross[3]).all()  # a look without pulses
    # A pulse that was not sampled counts nothing, gate by gate.
    holed = voltage.copy()
    holed[10:13, 1, 2] = np.nan
    (part,) = dwell_means(holed, dwells, kinds)
    lower, upper = voltage[13:20, 0, 2].astype(complex), voltage[13:20, 1, 2].astype(complex)
    np.testing.assert_allclose(part.cross[0, 2], (lower * upper.conj()).mean(), rtol=0, atol=1e-6)
    np.testing.assert_allclose(part.lower[0, 2], (np.abs(lower) ** 2).mean(), rtol=1e-6)
    np.testing.assert_array_equal(np.delete(part.cross, 2, axis=1), np.delete(got.cross, 2, axis=1))


# -------------------------------------------------------------------------------------------- masks and refusals


def scene_of(**radar) -> Scene:
    return Scene.model_validate(
        {
            "name": "masks",
            "radar": {"noise": False, "sector_deg": (0.0, 18.0), "range_m": (20.0, 80.0), **radar},
        }
    )


@cache
def made(**radar) -> xr.Dataset:
    rng = np.random.default_rng(9)
    ground, azimuth = rng.uniform(12.0, 90.0, 2500), np.radians(rng.uniform(-6.0, 24.0, 2500))
    points = np.stack((ground * np.sin(azimuth), ground * np.cos(azimuth), np.zeros(2500)), axis=1)
    return from_scatterers(scene_of(**radar), points, 1e-2 * rng.exponential(size=2500))


def echoes_of(**radar) -> xr.Dataset:
    """A field of scatterers on a flat sea, dense enough that every cell hears some."""
    return made(**radar).copy(deep=True)


ESTIMATORS: tuple[Literal["adaptive", "single_cell", "sliding_plane"], ...] = (
    "adaptive",
    "single_cell",
    "sliding_plane",
)
SETTINGS = [RetrievalSettings(ground_m=20.0, estimator=each) for each in ESTIMATORS]


@pytest.mark.parametrize(("settings", "dead"), [*zip(SETTINGS, (0, 1, 0), strict=True)], ids=ESTIMATORS)
def test_a_receiver_of_noise_alone_gives_hardly_an_unflagged_height(settings: RetrievalSettings, dead: int) -> None:
    """One that gives 0 or NaN is `test_a_dead_receiver_leaves_no_echo`."""
    echoes = echoes_of(noise=True, transmit_power_w=1e6)
    voltage = echoes["voltage"].values
    rng, level = np.random.default_rng(1), np.sqrt(0.5 * echoes.attrs["noise_power_w"])
    shape = (*voltage[:, dead].shape, 2)
    voltage[:, dead] = level * rng.normal(size=shape).astype(np.float32).view(np.complex64)[..., 0]
    polar = retrieve(echoes, settings)["polar"].to_dataset()
    height, quality = polar["height"].values, polar["quality"].values
    bad = quality & (QUALITY_FLAGS["no_echo"] | QUALITY_FLAGS["low_coherence"] | QUALITY_FLAGS["ambiguous"])
    # 50 independent pulses: a sample coherence above 0.3 happens to exp(−50 · 0.09) = 1 % of the cells.
    assert np.mean(np.isfinite(height) & (bad == 0)) < 0.03


def test_a_dead_look_leaves_its_neighbours_alone() -> None:
    echoes = echoes_of()
    whole = retrieve(echoes, SETTINGS[1])["polar"].to_dataset()["height"].values[0]
    pulses_a_look = echoes.sizes["pulse"] // whole.shape[0]
    echoes["voltage"][2 * pulses_a_look : 3 * pulses_a_look] = np.nan
    height = retrieve(echoes, SETTINGS[1])["polar"].to_dataset()["height"].values[0]
    alive = np.flatnonzero(np.isfinite(height).any(axis=1))
    np.testing.assert_array_equal(alive, np.setdiff1d(np.arange(whole.shape[0]), [2]))
    np.testing.assert_array_equal(np.isfinite(height[alive]), np.isfinite(whole[alive]))


def test_submerged_pulses_flag_their_look() -> None:
    echoes = echoes_of()
    echoes["flag"][120] = QUALITY_FLAGS["submerged"]
    quality = retrieve(echoes, SETTINGS[1])["polar"].to_dataset()["quality"].values[0]
    flagged = np.flatnonzero((quality & QUALITY_FLAGS["submerged"]).all(axis=1))
    np.testing.assert_array_equal(flagged, [2])


def broken(kind: str) -> xr.Dataset:
    echoes = echoes_of()
    match kind:
        case "no voltage":
            return echoes.drop_vars("voltage")
        case "no position":
            return echoes.drop_vars("position")
        case "transposed":
            return echoes.transpose("range", "receiver", "pulse", ...)
        case "real":
            return echoes.assign(voltage=echoes["voltage"].real)
        case "one receiver":
            return echoes.isel(receiver=[0])
        case "no attribute":
            del echoes.attrs["baseline_m"]
            return echoes
        case "no turn":
            echoes.attrs["complete_turns"] = 0
            return echoes
        case "other mode":
            echoes.attrs["interferogram"] = "alternating_pulse"
            return echoes
    raise AssertionError(kind)


@pytest.mark.parametrize(
    "kind", ["no voltage", "no position", "transposed", "real", "one receiver", "no attribute", "no turn", "other mode"]
)
def test_broken_echoes_are_refused_in_one_line(kind: str) -> None:
    with pytest.raises(SchemaError) as caught:
        retrieve(broken(kind), SETTINGS[1])
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) > 20
    assert "echoes" in message


def test_phase_and_unwrapped_phase_agree() -> None:
    polar = retrieve(echoes_of(), SETTINGS[1])["polar"].to_dataset()
    wrapped, whole = polar["phase"].values, polar["phase_unwrapped"].values
    known = np.isfinite(whole)
    assert known.mean() > 0.9
    turns = (whole - wrapped)[known] / (2.0 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-5)
    assert np.abs(wrapped).max() <= np.pi + 1e-6
    # arg⟨V_lower V_upper*⟩ is +pkΔR, positive where the sea lies below the baseline; the transmitters take turns.
    assert polar.attrs["paths"] == 2
    k = 2.0 * np.pi * 10e9 / SPEED_OF_LIGHT * polar.attrs["paths"]
    flat = k * difference_at_height(polar["range"].values, 0.0, Fan.upright(0.2, 4.9))
    assert np.abs(np.median((whole - flat)[0][known[0]])) < 0.2


def test_retrieval_loads_neither_drjit_nor_mitsuba(tmp_path) -> None:
    echoes = echoes_of().isel(pulse=slice(0, 500))
    path = tmp_path / "echoes.nc"
    voltage: np.ndarray = np.asarray(echoes["voltage"].values)
    echoes.drop_vars("voltage").assign(
        real=(("pulse", "receiver", "range"), np.real(voltage)), imag=(("pulse", "receiver", "range"), np.imag(voltage))
    ).to_netcdf(path, engine="h5netcdf")
    script = f"""
import sys
import xarray as xr
import seamap_rt
stored = xr.load_dataset({str(path)!r}, engine="h5netcdf")
echoes = stored.drop_vars(["real", "imag"]).assign(voltage=(stored["real"] + 1j * stored["imag"]).astype("complex64"))
maps = seamap_rt.retrieve(echoes)
assert float(maps["polar"]["height"].notnull().mean()) > 0.5
print(sorted(name for name in sys.modules if name.split(".")[0] in ("drjit", "mitsuba", "sionna")))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"


def plane_of_phase(per_gate: float, per_look: float, spread: float = 1.0) -> Covariance:
    """Cells whose phase is a plane, and whose power differs from cell to cell by up to `spread` decades."""
    look, gate = np.meshgrid(np.arange(7), np.arange(12), indexing="ij")
    power = 10.0 ** np.random.default_rng(3).uniform(0.0, spread, look.shape)
    turned = np.exp(1j * (per_gate * gate + per_look * look)).astype(np.complex128)
    return Covariance((power * turned).astype(np.complex128), power, power.copy())


def test_a_window_along_a_plane_keeps_its_phase_whatever_the_power() -> None:
    cells, flat = plane_of_phase(0.4, -0.3), np.zeros(1)
    weights = window_weights(4.5, 1.5), window_weights(2.7, 1.8)
    along = cells.windowed_along(*weights, PhaseSlopes(flat + 0.4, flat - 0.3))
    np.testing.assert_allclose(np.angle(along.cross / cells.cross), 0.0, rtol=0, atol=8 * EPS)
    np.testing.assert_allclose(along.coherence, 1.0, rtol=8 * EPS)
    against = cells.windowed_along(*weights, PhaseSlopes(flat - 0.4, flat + 0.3))
    assert np.abs(np.angle(against.cross / cells.cross)).max() > 0.1


def test_beside_a_dead_cell_the_window_shrinks_on_both_sides() -> None:
    # Equal powers and a slope that is not taken off: symmetric windows keep the middle's phase, one-sided ones do not.
    cells = plane_of_phase(0.4, -0.3, spread=0.0)
    cells.cross[3, 5] = np.nan
    flat, weights = np.zeros(1), (window_weights(4.5, 1.5), window_weights(2.7, 1.8))
    found = cells.windowed_along(*weights, PhaseSlopes(flat, flat))
    assert np.isnan(found.cross[3, 5])
    alive = np.isfinite(cells.cross)
    np.testing.assert_allclose(np.angle(found.cross[alive] / cells.cross[alive]), 0.0, rtol=0, atol=8 * EPS)
