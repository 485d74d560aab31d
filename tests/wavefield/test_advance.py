"""Maps at one instant: known waves, scanned by a turning antenna, and what the map should have been."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt import load_scene, retrieve
from seamap_rt.conventions import GRAVITY, unit_from_azimuth
from seamap_rt.physics.dispersion import Water
from seamap_rt.simulation import Simulator
from seamap_rt.wavefield.advance import GroundFields, advanced
from seamap_rt.wavefield.wave_direction import Travel, map_travel

SIDE, REACH = 3.0, 300.0
X, Y = np.meshgrid(*2 * [np.arange(-REACH, REACH + 0.5 * SIDE, SIDE)])
R = np.hypot(X, Y)
SWEEP = np.degrees(np.arctan2(X, Y)) % 360.0
# Away from where the turn closes, the radar and the map's edge, by the way of a group (1 s at 8 m/s) and some cells.
INSIDE = (R > 25.0) & (R < REACH - 40.0) & ~((np.abs(X) < 20.0) & (Y > 0.0))


@dataclass(frozen=True)
class Wave:
    """A plane wave: period [s], azimuth it comes from [deg], amplitude [m], depth of the water [m]."""

    period: float
    wave_from: float
    amplitude: float = 1.0
    depth: float = np.inf

    @property
    def k(self) -> float:
        omega = 2.0 * np.pi / self.period
        k = omega**2 / GRAVITY
        for _ in range(200):  # k = ω²/(g tanh kh); the mean of old and new settles
            k = 0.5 * (k + omega**2 / (GRAVITY * np.tanh(k * self.depth)))
        return k

    def at(self, t: NDArray[np.float64] | float) -> tuple[NDArray, NDArray, NDArray]:
        """Height and slopes to the east and north, at the cells and their times."""
        east, north = unit_from_azimuth(self.wave_from)
        phase = -self.k * (X * east + Y * north) - 2.0 * np.pi / self.period * t
        rise = self.amplitude * self.k * np.sin(phase)
        return self.amplitude * np.cos(phase), east * rise, north * rise


def scanned(waves: list[Wave], turn_s: float = 1.0, error: float = 0.05) -> GroundFields:
    time = np.where(R < REACH, turn_s * SWEEP / 360.0, np.nan)
    height, slope_x, slope_y = np.sum([wave.at(np.nan_to_num(time)) for wave in waves], axis=0)
    known = np.where(np.isfinite(time), 1.0, np.nan)
    return GroundFields(known * height, known * error, known * slope_x, known * slope_y, time)


def rms(field: NDArray, where: NDArray[np.bool_] = INSIDE) -> float:
    return float(np.sqrt(np.mean(field[where] ** 2)))


@pytest.mark.parametrize("wave_from", [0.0, 60.0, 270.0])
@pytest.mark.parametrize("period", [4.0, 6.0, 10.0])
@pytest.mark.parametrize("to_s", [0.0, 0.5])
def test_a_scanned_wave_is_set_upright(period: float, wave_from: float, to_s: float) -> None:
    wave = Wave(period, wave_from)
    got = advanced(scanned([wave]), SIDE, to_s, Travel.from_direction(wave_from))
    want = wave.at(to_s)
    # Beside a group's shift by the scan, c_g dt/dR, that it is right to first order in, what the map's edges and the
    # turn's closing lack spreads inwards: 0.5 % of the amplitude of short waves to 2.4 % of long ones, found by trial.
    assert rms(got.height - want[0]) < 0.03
    assert rms(np.hypot(got.slope_x - want[1], got.slope_y - want[2])) < 0.03 * wave.k
    np.testing.assert_array_equal(got.time[R < REACH], to_s)


def test_what_is_seen_twice_where_the_turn_closes_counts_once() -> None:
    # Waves that meet the beam's start and end: the map's two sides hold one strip of them, of c_g · 1 s = 8 m, twice.
    wave = Wave(10.0, 45.0)
    got = advanced(scanned([wave]), SIDE, 0.5, Travel.from_direction(45.0))
    closing = (np.abs(X) < 12.0) & (Y > 40.0) & (Y < REACH - 40.0)
    # The strip's edges are known to half a cell: 0.17 of the amplitude is left, 0.42 if it counts twice.
    assert rms(got.height - wave.at(0.5)[0], closing) < 0.25


def test_crossing_seas_each_run_their_way() -> None:
    wind, swell = Wave(4.0, 250.0, 0.5), Wave(8.0, 80.0, 0.8)
    ways = [Travel.from_direction(wave.wave_from) for wave in (wind, swell)]
    both = Travel(
        np.array([swell.k, wind.k]),
        np.concatenate([way.east for way in ways[::-1]]),
        np.concatenate([way.north for way in ways[::-1]]),
    )
    seen, want = scanned([wind, swell]), wind.at(0.5)[0] + swell.at(0.5)[0]
    got = advanced(seen, SIDE, 0.5, both)
    # Each as it would be alone, and beside it what is carried by groups that are not its own: one of 4.0, one of 8.0 s.
    assert rms(got.height - want) < 0.07 * rms(want)
    astray = advanced(seen, SIDE, 0.5, ways[0])
    assert rms(astray.height - want) > 0.3 * rms(want)


def test_at_its_own_time_a_cell_stays_as_it_is() -> None:
    seen = scanned([Wave(6.0, 300.0)])
    got = advanced(seen, SIDE, 0.4, Travel.from_direction(300.0))
    own = INSIDE & (np.abs(seen.time - 0.4) < 0.005)
    np.testing.assert_allclose(got.height[own], seen.height[own], atol=0.03)  # 0.005 s of 1 m at 1 rad/s, and the law's
    # A map of one instant asked for that instant: not a bit changes, gaps included.
    still = replace(seen, time=np.where(R < REACH, 0.4, np.nan))
    for each in fields(GroundFields):
        same = getattr(advanced(still, SIDE, 0.4, Travel.from_direction(300.0)), each.name)
        np.testing.assert_array_equal(same, getattr(still, each.name))


def test_forth_and_back_is_the_same_map() -> None:
    way = Travel.from_direction(250.0)
    height, slope_x, slope_y = np.add(Wave(5.0, 240.0).at(0.0), Wave(7.0, 270.0).at(0.0))
    start = GroundFields(height, np.full_like(height, 0.05), slope_x, slope_y, np.zeros_like(height))
    gone = advanced(start, SIDE, 1.0, way)
    back = advanced(gone, SIDE, 0.0, way)
    assert rms(gone.height - start.height) > 0.5 * rms(start.height)
    # A rotation and its inverse; what is lost ran over the map's edge.
    assert rms(back.height - start.height) < 0.02 * rms(start.height)
    assert rms(back.slope_x - start.slope_x) < 0.02 * rms(start.slope_x)
    np.testing.assert_allclose(back.height_std[INSIDE], 0.05, rtol=0.01)
    assert back.slope_x_std is None


def test_errors_of_slopes_go_with_the_slopes() -> None:
    # As those of heights do: as they were where all arrives, larger at a hole.
    wave, error = Wave(6.0, 270.0), np.full(X.shape, 0.02)
    seen = replace(scanned([wave]), slope_x_std=error, slope_y_std=2.0 * error)
    hole = np.hypot(X - 150.0, Y + 90.0)
    calm = replace(seen, slope_x=0.0 * seen.slope_x, slope_y=0.0 * seen.slope_y)
    gapped = replace(seen, slope_x=np.where(hole < 40.0, np.nan, seen.slope_x))
    got, still, torn = (advanced(each, SIDE, 0.5, Travel.from_direction(270.0)) for each in (seen, calm, gapped))
    (whole, _), east_north, (beside_hole, _) = (errors_of(each) for each in (got, still, torn))
    np.testing.assert_array_equal(np.isfinite(whole), np.isfinite(got.slope_x))
    assert [rms(each) for each in east_north] == pytest.approx([0.02, 0.04], rel=0.04)
    beside = (hole > 40.0) & (hole < 45.0) & np.isfinite(beside_hole)
    assert rms(beside_hole, beside) > 1.1 * rms(whole, beside)


def errors_of(ground: GroundFields) -> tuple[np.ndarray, np.ndarray]:
    assert ground.slope_x_std is not None
    assert ground.slope_y_std is not None
    return ground.slope_x_std, ground.slope_y_std


def test_a_still_sea_stays_still() -> None:
    flat = scanned([Wave(6.0, 0.0, amplitude=0.0)])
    got = advanced(flat, SIDE, 0.7, Travel.from_direction(0.0))
    for name in ("height", "slope_x", "slope_y"):
        np.testing.assert_allclose(getattr(got, name)[R < REACH], 0.0, atol=1e-12)
    np.testing.assert_allclose(got.height_std[R < REACH], 0.05, rtol=1e-9)


def test_noise_neither_grows_nor_shrinks() -> None:
    flat = scanned([Wave(6.0, 0.0, amplitude=0.0)])
    noisy = replace(flat, height=flat.height + 0.05 * np.random.default_rng(4).normal(size=X.shape))
    got = advanced(noisy, SIDE, 0.5, Travel.from_direction(0.0))
    # Every wave is turned, none made larger. 20 000 cells know the spread to 0.5 %; where the scan gathers noise
    # (some 2 %), it does so as at 25 m, the nearest.
    assert rms(got.height) == pytest.approx(0.05, rel=0.04)
    assert rms(got.height_std) == pytest.approx(0.05, rel=0.04)


def test_gaps_cost_certainty_and_make_nothing_wild() -> None:
    wave = Wave(6.0, 270.0)
    seen, want = scanned([wave]), wave.at(1.0)[0]
    hole = (np.hypot(X - 150.0, Y + 90.0) < 40.0) | (np.random.default_rng(5).random(X.shape) < 0.05)
    gapped = replace(seen, height=np.where(hole, np.nan, seen.height), slope_x=np.where(hole, np.nan, seen.slope_x))
    got = advanced(gapped, SIDE, 1.0, Travel.from_direction(270.0))
    found = np.isfinite(got.height)
    np.testing.assert_array_equal(found, np.isfinite(got.height_std))
    inner = np.hypot(X - 150.0, Y + 90.0)
    assert not found[inner < 30.0].any()
    assert found[INSIDE & (inner > 60.0)].mean() > 0.9
    # A wave of 1 m; at the hole's sharp edge as much is made up as a third of it.
    assert np.nanmax(np.abs(got.height[INSIDE])) < 1.5
    near, far = (INSIDE & found & where for where in (inner < 45.0, inner > 60.0))
    assert rms(got.height_std, near) > 1.5 * rms(got.height_std, far)
    assert 0.95 < rms(got.height_std, near) / rms(got.height - want, near) < 1.4  # 0.83 if groups all ran as one
    # Where a whole side is missing the errors are no better than the model of them: three in four within two.
    assert np.mean(np.abs(got.height - want)[near] < 2.0 * got.height_std[near]) > 0.65
    assert np.mean(np.abs(got.height - want)[far] < 2.0 * got.height_std[far]) > 0.95


def test_shallow_water_slows_the_waves() -> None:
    wave = Wave(9.0, 90.0, depth=4.0)
    seen, want, way = scanned([wave], turn_s=2.0), wave.at(1.0)[0], Travel.from_direction(90.0)
    right = rms(advanced(seen, SIDE, 1.0, way, Water(4.0)).height - want)
    deep = rms(advanced(seen, SIDE, 1.0, way).height - want)
    assert right < 0.05 * rms(want)  # twice the turn, twice the error
    assert deep > 2.0 * right


def test_a_simulated_turn_is_the_sea_of_one_instant() -> None:
    scene = load_scene("choppy_sea", {"tracing.tracer": "horizon", "radar.range_m": [15.0, 120.0]})
    simulator = Simulator(scene)
    ground = retrieve(simulator.turn(0).echoes)["ground"].to_dataset().isel(turn=0)
    names = [each.name for each in fields(GroundFields)]
    seen = GroundFields(*(ground[name].values.astype(np.float64) for name in names))
    # Which of the two ways the map's own waves run: within 5° as they came from 270°.
    way = map_travel(seen.height, seen.height_std, SIDE, Travel.from_direction(220.0))
    assert abs(way.wave_from_deg - 270.0) < 5.0
    x, y = np.meshgrid(ground["x"].values, ground["y"].values)
    got = advanced(seen, SIDE, 0.0, way)
    sea = simulator.sea.elevation(x, y, np.zeros(x.shape))
    late = (np.hypot(x, y) > 20.0) & (np.hypot(x, y) < 100.0) & (seen.time > 0.5)
    late &= np.isfinite(seen.height) & np.isfinite(got.height)
    before, after = (np.sqrt(np.mean((each.height - sea)[late] ** 2)) for each in (seen, got))
    assert before > 0.25  # m: waves of 0.35 m rms that have run on by up to a second
    assert after < 0.13  # what the retrieval itself errs by there, some 0.1


def test_maps_without_anything_are_left_alone() -> None:
    nothing = np.full((9, 9), np.nan)
    empty = GroundFields(nothing, nothing, nothing, nothing, nothing)
    assert np.isnan(advanced(empty, SIDE, 0.0, Travel.from_direction(0.0)).height).all()
    timed = replace(empty, time=np.linspace(0.0, 1.0, 81).reshape(9, 9))
    assert np.isnan(advanced(timed, SIDE, 0.0, Travel.from_direction(0.0)).height).all()


def test_what_cannot_be_is_refused() -> None:
    ground, way = scanned([Wave(6.0, 0.0)]), Travel.from_direction(0.0)
    with pytest.raises(ValueError, match="side = 0: must be positive"):
        advanced(ground, 0.0, 0.0, way)
    with pytest.raises(ValueError, match="depth = -1: must be positive"):
        advanced(ground, SIDE, 0.0, way, Water(-1.0))
    with pytest.raises(ValueError, match="to_s = nan: must be finite"):
        advanced(ground, SIDE, np.nan, way)
    with pytest.raises(ValueError, match="must be one shape"):
        advanced(replace(ground, time=ground.time[1:]), SIDE, 0.0, way)
